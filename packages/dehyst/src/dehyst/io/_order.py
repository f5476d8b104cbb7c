"""Repairs time stamps out of order: repeated, swapped, stray, restarting; reports every change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Rows
from dehyst.data import gap_limit, is_even, turning_points
from dehyst.data import kit as data_kit
from dehyst.errors import TimeError
from dehyst.io._clean import Context, Samples
from dehyst.io._policy import POLICY
from dehyst.io._table import list_first, list_rows, number_of, usual_step

# Rows of the file at which the clock was set, and by how much [s].
Jumps = tuple[tuple[int, float], ...]


def order_time(samples: Samples, about: Context, jumps: Jumps | None = None) -> Samples:
    """Make time increase: sort the few rows out of order, take out jumps, spread repeated stamps, break at restarts.

    `jumps`: where the clock was set, if that was judged on more of the log than `samples`.
    """
    if samples.time is None or samples.time.size < 2:
        return samples
    if np.all(np.diff(samples.time) > 0):
        return mend_jumps(samples, about, jumps)
    samples = _sort_few(samples, about)
    samples = _sort_swapped(samples, about)
    samples = _drop_stray(samples, about)
    samples = mend_jumps(samples, about, jumps)
    samples = _drop_doubled(samples, about)
    samples = _spread_repeated(samples, about)
    time = _stamps(samples)
    restarts = np.flatnonzero(np.diff(time) < 0) + 1
    still = np.flatnonzero(np.diff(time) == 0) + 1
    if still.size:
        raise TimeError(
            f"{still.size} of {time.size} rows of {about.log} have the time stamp of the row before them, and nothing "
            f"tells how far they are apart, first at {list_rows(samples.rows[still], about.word)}. Name another time "
            f"column with --time, or say how many seconds lie between two rows: --dt 0.01",
            rows=samples.rows[still],
        )
    if restarts.size == 0:
        return samples
    if restarts.size > POLICY.max_restarts and restarts.size > 0.01 * time.size:
        raise TimeError(
            f"time stamps of {about.log} run backward {restarts.size} times in {time.size} rows, first at "
            f"{list_rows(samples.rows[restarts], about.word)}. The order of the samples is the memory of the actuator, "
            f"so it is not guessed. Sort the log by time, or name another time column with --time.",
            rows=samples.rows[restarts],
        )
    about.say(
        "clock-restart",
        f"the clock of {about.log} jumps back at {list_rows(samples.rows[restarts], about.word)}: several "
        f"recordings follow each other. Each is treated as a piece of its own, with unknown memory at its start. "
        f"Better split the log, or add a column run.",
    )
    return replace(samples, breaks=tuple(int(k) for k in restarts))


def _stamps(samples: Samples) -> Array:
    assert samples.time is not None
    return samples.time


def _sort_few(samples: Samples, about: Context) -> Samples:
    """Sort if few rows stand out of order, near their place, and leave no hole where they belong.

    A clock that restarts, or a stamp that is simply wrong, does not fit between other stamps in this way.
    """
    t = _stamps(samples)
    late = np.flatnonzero(t < np.maximum.accumulate(t))
    if late.size == 0 or late.size > max(1, POLICY.out_of_order * t.size):
        return samples
    order = np.argsort(t, kind="stable")
    moved = np.abs(order - np.arange(t.size))
    if moved.max() > max(POLICY.nearest_place, POLICY.out_of_order * t.size):
        return samples
    step = np.diff(t[order])
    typical = float(np.median(step))
    touched = step[(moved[1:] > 0) | (moved[:-1] > 0)]
    # Two recordings laid into each other have steps of half the usual size, or less.
    if touched.min() < 0.6 * typical or touched.max() > 4.0 * typical:
        return samples
    return _put_in_order(samples, order, late, about)


def _put_in_order(samples: Samples, order: Rows, late: Rows, about: Context) -> Samples:
    stand, them = "stand", "them"
    if late.size == 1:
        stand, them = "stands", "it"
    about.say(
        "swapped-rows",
        f"{number_of(late.size, 'row')} of {about.log} {stand} after rows that follow {them} in time "
        f"({list_rows(samples.rows[late], about.word)}); they were put in order. Nothing to do.",
    )
    return samples.take(order)


def _sort_swapped(samples: Samples, about: Context) -> Samples:
    t = _stamps(samples)
    order = np.arange(t.size)
    swapped: list[int] = []
    for k in (np.flatnonzero(np.diff(t) < 0) + 1).tolist():
        before = t[k - 2] if k >= 2 else -np.inf
        after = t[k + 1] if k + 1 < t.size else np.inf
        if before < t[k] and t[k - 1] < after and not (k >= 2 and order[k - 1] != k - 1):
            order[k - 1], order[k] = k, k - 1
            swapped.append(k)
    # At the very ends a pair cannot be told from a restart of the clock by order alone; its size tells.
    typical = usual_step(t)
    late = np.array(swapped, dtype=np.int64)
    far = t[late - 1] - t[late] > 10 * typical
    for k in late[far].tolist():
        order[k - 1], order[k] = k - 1, k
    if far.all():
        return samples
    return _put_in_order(samples, order, late[~far], about)


def _drop_stray(samples: Samples, about: Context) -> Samples:
    """Drop single stamps that fit neither before nor after while their neighbours fit each other."""
    t = _stamps(samples)
    typical = usual_step(t)
    stray: set[int] = set()
    for k in (np.flatnonzero(np.diff(t) < 0) + 1).tolist():
        if k >= 2 and 0 < t[k] - t[k - 2] <= 4 * typical:
            stray.add(k - 1)  # one stamp too high
        elif k + 1 < t.size and 0 < t[k + 1] - t[k - 1] <= 4 * typical:
            stray.add(k)  # one stamp too low
    if not stray:
        return samples
    index = np.array(sorted(stray))
    about.say(
        "stray-time",
        f"{index.size} time stamps of {about.log} fit neither the one before nor the one after "
        f"({list_rows(samples.rows[index], about.word)}); these rows were left out. Check the logger if there are "
        f"many.",
    )
    return samples.take(np.delete(np.arange(t.size), index))


def _drop_doubled(samples: Samples, about: Context) -> Samples:
    """Drop rows that repeat stamp and values of the row before them, unless the clock is coarse."""
    t = _stamps(samples)
    repeated = np.concatenate(([False], np.diff(t) == 0))
    doubled = repeated.copy()
    for v in samples.values:
        doubled[1:] &= np.diff(v) == 0
    # With a coarse clock, equal rows are a signal at rest.
    coarse = repeated.sum() >= POLICY.coarse_clock * t.size and doubled.sum() < 0.9 * repeated.sum()
    if not doubled.any() or coarse:
        return samples
    about.say(
        "repeated-time",
        f"{int(doubled.sum())} of {t.size} rows of {about.log} repeat the time stamp and the values before them "
        f"({list_rows(samples.rows[doubled], about.word)}); the first of each was kept. Nothing is lost.",
    )
    return samples.take(~doubled)


def _spread_repeated(samples: Samples, about: Context) -> Samples:
    """Spread the rows that share a stamp evenly over the time to the next stamp.

    A group of n rows at stamp t, followed by the stamp t', gets t + k (t' - t) / n, k = 0..n-1. Before a gap the
    usual step between stamps takes the place of t' - t. Where most stamps are shared, the first group may
    have begun before the log did; it then ends where the second begins, at the usual pace.
    """
    t = _stamps(samples)
    starts = np.concatenate(([0], np.flatnonzero(np.diff(t) != 0) + 1))
    if starts.size == t.size or starts.size < 2:
        return samples
    counts = np.diff(np.concatenate((starts, [t.size])))
    usual, many = usual_step(t), float(np.median(counts))
    width = np.append(np.diff(t[starts]), usual)
    width = np.where((width <= 0) | (width > usual), usual, width)
    width[-1] = usual * min(1.0, counts[-1] / many)  # the log may end within a group
    place = np.arange(t.size) - np.repeat(starts, counts)
    begin = t[starts].copy()
    if many > 1 and counts[0] < many:
        begin[0] += usual * (1.0 - counts[0] / many)
        width[0] = usual * counts[0] / many
    spread = np.repeat(begin, counts) + place * np.repeat(width / counts, counts)
    shared = int(t.size - starts.size)
    about.say(
        "coarse-time",
        f"{shared} of {t.size} rows of {about.log} share the time stamp of the row before them, in groups of up to "
        f"{int(counts.max())} (first at {list_rows(samples.rows[starts[counts > 1]], about.word)}): the clock is "
        f"coarser than the sampling, {usual:.4g} s against about {usual_step(spread):.3g} s. The rows of each "
        f"group were spread evenly over its time. Rates are only as good as that; log time with more digits.",
    )
    return replace(samples, time=spread)


def mend_jumps(samples: Samples, about: Context, jumps: Jumps | None = None) -> Samples:
    """Take out jumps of the clock, forward or back, across which all signals go on smoothly; `jumps` if judged before.

    Time that passed, or another recording, would show in the signals: they moved before and after the jump, and would
    stand elsewhere. Of a pair of jumps that cancel within a few samples it is enough that no signal jumps.
    """
    t = samples.time
    if t is None:
        return samples
    jumps = find_jumps(samples) if jumps is None else jumps
    onward = 1 if samples.rows[-1] >= samples.rows[0] else -1
    late = np.zeros(t.size)
    inside: list[tuple[int, float]] = []
    for row, size in jumps:
        place = int(np.argmax(onward * samples.rows >= onward * row))
        if place > 0:
            late[place] += size
            inside.append((row, size))
    if not inside:
        return samples
    rows, sizes = zip(*inside, strict=True)
    shown = list_first(list(map("{:+.4g} s".format, sizes)), 4)
    go = "goes" if len(about.columns) == 1 else "go"
    jumps_were = "jump was" if len(inside) == 1 else "jumps were"
    about.say(
        "clock-jump",
        f"the clock of {about.log} jumps at {list_rows(rows, about.word)} (by {shown}) while "
        f"{' and '.join(about.columns)} {go} on smoothly: the clock was set, the log was not interrupted. The "
        f"{jumps_were} taken out, and memory goes on. Nothing to do; a clock that only counts up (monotonic) does not "
        f"jump.",
    )
    return replace(samples, time=t - np.cumsum(late), jumps=tuple(inside))


def find_jumps(samples: Samples) -> Jumps:
    """Rows at which the clock was set, and by how much.

    Only of evenly sampled signals is it known what time has passed. Forward, lost rows must be excluded: the jump is
    long, a signal would have moved clearly, and most jumps of the log are like this.
    """
    t = samples.time
    if t is None or t.size < POLICY.jumps_from:
        return ()
    step = np.diff(t)
    typical = usual_step(t)
    places = np.flatnonzero((step < 0.0) | (step > gap_limit(step))) + 1
    few = 0 < places.size <= max(POLICY.jumps_most, POLICY.jumps_share * step.size)
    if typical == 0.0 or not few or not is_even(step):
        return ()
    size = step[places - 1] - typical
    shift = np.zeros(places.size)
    signals = [_Signal.of(values, places) for values in samples.values]
    for k, m in data_kit.taken_back(places, size, t.size):
        if _go_on(signals, places[[k, m]]):
            shift[[k, m]] = size[k], -size[k]
    for k in np.flatnonzero(shift == 0.0).tolist():
        missing = abs(size[k]) / typical
        forward = bool(size[k] > 0.0)
        if forward and missing < POLICY.lost_rows:
            continue  # rows may have been lost
        smooth = all(signal.is_smooth(places[k]) for signal in signals)
        if smooth and any(signal.moves(places[k], missing, forward) for signal in signals):
            shift[k] = size[k]
    if 2 * np.count_nonzero(shift) > places.size:
        # One clock, one explanation: the others need not be smooth, as at a reversal, if only no signal jumps there.
        likely = (size < 0.0) | (size >= POLICY.lost_rows * typical)
        for k in np.flatnonzero((shift == 0.0) & likely).tolist():
            if _go_on(signals, places[[k]]):
                shift[k] = size[k]
    lone = (shift > 0.0) & ~_cancelled(shift)
    if np.count_nonzero(lone) <= np.count_nonzero((shift == 0.0) & (size > 0.0)):
        # Rows were lost elsewhere, and so they were here.
        shift[lone] = 0.0
    jumped = np.flatnonzero(shift)
    return tuple(zip(samples.rows[places[jumped]].tolist(), shift[jumped].tolist(), strict=True))


def _cancelled(shift: Array) -> npt.NDArray[np.bool_]:
    """Jumps that one beside them takes back to the last digit."""
    pair = (shift[:-1] == -shift[1:]) & (shift[1:] != 0.0)
    return np.asarray(np.append(pair, False) | np.append(False, pair))


def _go_on(signals: Sequence[_Signal], places: Rows) -> bool:
    """Whether no signal jumps at these places."""
    return all(signal.goes_on(places) for signal in signals)


class _Signal(NamedTuple):
    """A signal, and what it usually does from one sample to the next."""

    values: Array
    step: float
    largest: float
    bend: float
    quiet: float
    window: int

    @classmethod
    def of(cls, v: Array, places: Rows) -> _Signal:
        """Quantiles of its steps and second differences, those at the jumps left out."""
        step, bend = np.abs(np.diff(v)), np.abs(np.diff(v, 2))
        beside = np.concatenate([places - 1, places - 2])
        step = np.delete(step, places - 1)
        bend = np.delete(bend, beside[(beside >= 0) & (beside < bend.size)])
        swings = max(1, turning_points(v).size - 1)
        moved = step[step > 0.0]
        typical = 0.0
        if moved.size:
            typical = float(np.median(moved))
        return cls(
            v,
            typical,
            float(np.quantile(step, 0.99)),
            float(np.quantile(bend, 0.95)),
            float(np.median(bend)),
            max(20, v.size // swings // 10),
        )

    @property
    def smooth(self) -> float:
        """Second difference that passes for smooth."""
        return POLICY.smooth_bend * self.bend + POLICY.smooth_step * self.step

    def goes_on(self, places: Rows) -> bool:
        """Whether no step at these places is larger than usual."""
        steps = np.abs(self.values[places] - self.values[places - 1])
        return bool(np.all(steps <= POLICY.usual_steps * self.largest))

    def is_smooth(self, place: int) -> bool:
        """Whether the signal goes on in its direction and at its speed."""
        near = self.values[max(place - 2, 0) : place + 2]
        return near.size == 4 and bool(np.max(np.abs(np.diff(near, 2))) <= self.smooth)

    def moves(self, place: int, missing: float, forward: bool) -> bool:
        """Whether the signal moves before and after, and would have moved far in so many samples."""
        before = self.values[max(place - self.window, 0) : place]
        after = self.values[place : place + self.window]
        least = min(float(np.ptp(before)), float(np.ptp(after)))
        gone = min(missing, self.window) * least / self.window
        hidden = POLICY.unseen_steps * self.step
        if forward:
            hidden = max(hidden, POLICY.clearly_moved * self.smooth)
        return least > POLICY.moving_bend * self.quiet and gone > hidden
