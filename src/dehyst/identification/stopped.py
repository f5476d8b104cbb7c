"""An actuator that breaks while it is logged: its output stays where it fell to, and the input cycles on."""

from __future__ import annotations

import numpy as np

from dehyst.arrays import Array
from dehyst.data.loops import turning_points
from dehyst.data.ranges import robust_range
from dehyst.data.recording import Recording
from dehyst.findings import Finding

AT_REST = 0.005  # of its range, or what it moves in the second half: the output stands still
STAYS = 0.05  # of its range: within so much the output stays to the end ...
FEWEST, SHARE = 20, 0.01  # ... for at least so many samples and this share of the log ...
DRIVEN = 0.3  # ... while the input goes over this share of its range ...
SWINGS = 3  # ... so many times ...
FOLLOWED = 0.25  # ... over which the output went by this share of its range before
BINS = 8  # of the input, in which the output before and after is compared


def stopped_at(x: Array, y: Array) -> tuple[int, int] | None:
    """First sample of the swing in which the output stopped following the input for good, and where it came to rest.

    None if it never did.

    Examples
    --------
    >>> x = np.sin(np.arange(2000) / 10)
    >>> stopped_at(x, 2 * x), stopped_at(x, np.where(np.arange(2000) < 1000, 2 * x, -2.1))
    (None, (927, 1000))
    """
    span, tail = robust_range([y]), y[-max(FEWEST, int(SHARE * y.size)) :]
    if float(np.ptp(tail)) > 2.0 * STAYS * span:
        return None
    moving = np.flatnonzero(np.abs(y - np.median(tail)) > STAYS * span)
    stop = 0 if moving.size == 0 else int(moving[-1]) + 1
    if stop < FEWEST or y.size - stop < tail.size:
        return None
    low, high = float(x[stop:].min()), float(x[stop:].max())
    if not high - low > DRIVEN * robust_range([x]):
        return None
    if turning_points(x[stop:], 0.5 * (high - low)).size <= SWINGS:
        return None
    turns = turning_points(x[:stop], 0.5 * (high - low))
    begin = int(turns[max(0, turns.size - 3)])  # the swing before: a fall takes its time
    if begin < FEWEST:
        return None
    before, after = (_levels(x[part], y[part], low, high) for part in (slice(0, begin), slice(stop, None)))
    both = np.isfinite(before) & np.isfinite(after)
    if both.sum() < 2 or not np.ptp(before[both]) > FOLLOWED * span:
        return None
    level = np.median(y[stop:])
    rest = float(np.abs(y[stop + (y.size - stop) // 2 :] - level).max())
    return begin, int(np.flatnonzero(np.abs(y - level) > max(rest, AT_REST * span))[-1]) + 1


def _levels(x: Array, y: Array, low: float, high: float) -> Array:
    """Mean output where the input lies in each of some intervals of a range; nan where it never does."""
    cell = np.clip((BINS * (x - low) / (high - low)).astype(np.int64), -1, BINS)
    inside = (x >= low) & (x <= high)
    cell = np.minimum(cell[inside], BINS - 1)
    count = np.bincount(cell, minlength=BINS)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.bincount(cell, y[inside], BINS) / count)


def about_stop(record: Recording, stop: tuple[int, int], broke: int, place: int, samples: int) -> Finding:
    """Say where the output came to rest, sample `broke` of `samples` of the log, and from which on all was left out."""
    times = ["" if record.time is None else f" (t = {record.time[k]:.6g} s)" for k in stop]
    end = float(np.median(record.output[stop[1] :]))
    unit = f" {record.output_unit}" if record.output_unit else ""
    return Finding(
        "output-stopped",
        f"the output '{record.output_name}' of {record.name} stops following its input: from sample {broke}{times[1]} "
        f"on it stays at {end:.4g}{unit} while the input cycles on. The actuator broke, or its sensor was lost. The "
        f"{samples - place} samples from sample {place}{times[0]} on, of {samples}, were left out of the fit and of "
        f"its errors: the swing before counts as doubtful. Repair it, and log again if the model needs more loops.",
    )
