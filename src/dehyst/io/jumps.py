"""Clocks that were set while a log was written: time jumps, the signals go on. Every cure is a finding."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dehyst.arrays import Array, Rows
from dehyst.findings import Finding
from dehyst.gaps import gap_limit, taken_back
from dehyst.io.clean import Context, Samples
from dehyst.io.table import list_rows
from dehyst.loops import turning_points

JUMPS_MOST, JUMPS_SHARE = 6, 0.01  # this many, or this share of the steps: more are no clock that was set now and then
FEWEST = 32  # samples below which nothing is judged
BEND = 2.0  # times the 95 % quantile of the second differences ...
STEP = 0.25  # ... and this share of the median step: how smoothly a signal goes on
USUAL = 2.0  # times the 99 % quantile of its steps: what a signal may do within a pair of jumps
MOVING = 10.0  # times the median second difference: what the input moves before and after, or it rests
UNSEEN = 1.0  # median steps of the input: what would be missing at least, were the jump a gap


def mend_jumps(samples: Samples, about: Context, findings: list[Finding]) -> Samples:
    """Take out jumps of the clock, forward or back, across which all signals go on smoothly.

    Time that passed, or another recording, would show in the signals: they moved before and after the jump, and would
    stand elsewhere. Of a pair of jumps that cancel within a few samples it is enough that no signal jumps.
    """
    t = samples.time
    if t is None or t.size < FEWEST:
        return samples
    step = np.diff(t)
    typical = float(np.median(step[step > 0])) if np.any(step > 0) else 0.0
    places = np.flatnonzero((step < 0.0) | (step > gap_limit(step))) + 1
    if typical == 0.0 or not 0 < places.size <= max(JUMPS_MOST, JUMPS_SHARE * step.size):
        return samples
    size = step[places - 1] - typical
    shift = np.zeros(places.size)
    usual = [_Usual.of(v, places) for v in samples.values]
    for k, m in taken_back(places, size, t.size):
        if all(about_v.goes_on(v, places[[k, m]]) for about_v, v in zip(usual, samples.values, strict=True)):
            shift[[k, m]] = size[k], -size[k]
    for k in np.flatnonzero(shift == 0.0).tolist():
        smooth = all(about_v.is_smooth(v, places[k]) for about_v, v in zip(usual, samples.values, strict=True))
        if smooth and usual[0].moves(samples.values[0], places[k], abs(size[k]) / typical):
            shift[k] = size[k]
    if not shift.any():
        return samples
    if 2 * np.count_nonzero(shift) > places.size:  # one clock, one explanation: there the others need not be smooth, as
        for k in np.flatnonzero(shift == 0.0).tolist():  # at a reversal; it is enough that no signal jumps
            if all(about_v.goes_on(v, places[[k]]) for about_v, v in zip(usual, samples.values, strict=True)):
                shift[k] = size[k]
    late = np.zeros(t.size)
    late[places] = shift
    mended = t - np.cumsum(late)
    at, by = places[shift != 0.0], size[shift != 0.0]
    shown = ", ".join(f"{value:+.4g} s" for value in by[:4].tolist()) + (", ..." if by.size > 4 else "")
    findings.append(
        Finding(
            "clock-jump",
            f"the clock of {about.log} jumps at {list_rows(samples.rows[at], about.word)} (by {shown}) while "
            f"{' and '.join(about.columns)} {'go' if len(about.columns) > 1 else 'goes'} on smoothly: the clock was "
            f"set, the log was not interrupted. The {'jumps were' if at.size > 1 else 'jump was'} taken out, and "
            f"memory goes on. Nothing to do; a clock that only counts up (monotonic) does not jump.",
        )
    )
    return replace(samples, time=mended)


class _Usual:
    """What a signal usually does from one sample to the next."""

    def __init__(self, step: float, largest: float, bend: float, quiet: float, window: int) -> None:
        self.step, self.largest, self.bend, self.quiet, self.window = step, largest, bend, quiet, window

    @classmethod
    def of(cls, v: Array, places: Rows) -> _Usual:
        """Quantiles of its steps and second differences, those at the jumps left out."""
        step, bend = np.abs(np.diff(v)), np.abs(np.diff(v, 2))
        beside = np.concatenate([places - 1, places - 2])
        step = np.delete(step, places - 1)
        bend = np.delete(bend, beside[(beside >= 0) & (beside < bend.size)])
        swings = max(1, turning_points(v).size - 1)
        moved = step[step > 0.0]
        return cls(
            float(np.median(moved)) if moved.size else 0.0,
            float(np.quantile(step, 0.99)),
            float(np.quantile(bend, 0.95)),
            float(np.median(bend)),
            max(20, v.size // swings // 10),
        )

    def goes_on(self, v: Array, places: Rows) -> bool:
        """Whether no step at these places is larger than usual."""
        return bool(np.all(np.abs(v[places] - v[places - 1]) <= USUAL * self.largest))

    def is_smooth(self, v: Array, place: int) -> bool:
        """Whether the signal goes on in its direction and at its speed."""
        near = v[max(place - 2, 0) : place + 2]
        return near.size == 4 and bool(np.max(np.abs(np.diff(near, 2))) <= BEND * self.bend + STEP * self.step)

    def moves(self, v: Array, place: int, missing: float) -> bool:
        """Whether the signal moves before and after, and would have moved far in so many samples."""
        before, after = v[max(place - self.window, 0) : place], v[place : place + self.window]
        least = min(float(np.ptp(before)), float(np.ptp(after)))
        gone = min(missing, self.window) * least / self.window
        return least > MOVING * self.quiet and gone > UNSEEN * self.step
