"""Cleans recordings before identification: bridges outliers, drops samples after the actuator failed.

`stopped_at` finds an output that no longer follows its input, `changed_at` an output that is another one at the same
input and memory from some cycle on; both for good.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array, Mask, Rows
from dehyst.data import (
    Recording,
    about_clipping,
    bridged,
    find_outliers,
    robust_range,
    turning_points,
)
from dehyst.findings import Finding
from dehyst.identification._threads import single_blas

CHANGED = 0.15  # of its range before: so far the output stands from where it stood, at its 95 % quantile in a cycle ...
CERTAIN = 3.0  # ... and so many times what the best description leaves of each part, and of the cycle before ...
LASTS = 0.5  # ... and in every later cycle this share of it
# Times as fast or slow: the input moves otherwise, and the output may depend on its rate.
SPEED = 1.5
SWING = 0.3  # of the input's range: a turn
CYCLES = 3  # on either side, or nothing is compared
# More are thinned out: a change that stays is seen in any of them.
MOST_CYCLES, MOST_ROWS = 200, 20_000
PLAYS, HINGES = 10, 8
FAR = 1.5  # times the leverage of what came before: an input and past that were not seen
COMPARED = 0.5  # of the samples of a cycle, at least, or it does not count
RIDGE = 1e-9


@dataclass(frozen=True)
class Change:
    """Where an actuator became another one: samples from `begin` on are left out, `place` shows it, by `size`."""

    begin: int
    place: int
    size: float


def changed_at(x: Array, y: Array) -> Change | None:
    """Find the cycle from which on the output is another one at the same input and memory; None if there is none.

    Plays and a piecewise linear curve, a least-squares fit of each part, describe what an actuator does; the parts are
    those that are described best. It is a change if the first part's description fails at once and for good, for
    inputs and plays that it has seen.

    Examples
    --------
    >>> x = np.sin(np.arange(2000) / 10)
    >>> changed_at(x, 2 * x), changed_at(x, np.where(np.arange(2000) < 1000, 2 * x, x)).begin
    (None, 958)
    """
    with single_blas():
        return _changed_at(x, y)


def _changed_at(x: Array, y: Array) -> Change | None:
    span = robust_range([y])
    rows = np.arange(0, x.size, max(1, x.size // MOST_ROWS))
    x, y = x[rows], y[rows]
    reach = robust_range([x])
    if not (reach > 0.0 and span > 0.0):
        return None
    turns = turning_points(x, SWING * reach)[1:-1]
    thinned = turns[:: 2 * max(1, turns.size // (2 * MOST_CYCLES))]
    marks = np.unique(np.concatenate([[0], thinned, [x.size]]))
    if marks.size <= 2 * CYCLES + 1:
        return None
    terms = _terms(x, reach)
    joint = np.column_stack([terms, y / span])
    sums = np.cumsum([joint[a:b].T @ joint[a:b] for a, b in pairwise(marks)], axis=0)
    cuts = np.arange(CYCLES + 1, marks.size - CYCLES)  # the end of the cycle before is asked too
    misses = [_left(sums[cut - 1]) + _left(sums[-1] - sums[cut - 1]) for cut in cuts]
    best = int(cuts[np.argmin(misses)])
    for cut in (best - 1, best):  # within a cycle, either of its ends may be the best
        before, after = sums[cut - 1], sums[-1] - sums[cut]
        judged = _judged(x, y / span, terms, marks, cut, before, after)
        if judged is None:
            continue
        # What was before the log moves the first cycle, which nobody knows: it is no change if that alone tells of it.
        if _judged(x, y / span, terms, marks, cut, before - sums[0], after) is not None:
            begin, place, size = judged
            return Change(int(rows[begin]), int(rows[place]), size)
    return None


def _judged(
    x: Array, y: Array, terms: Array, marks: Rows, cut: int, before: Array, after: Array
) -> tuple[int, int, float] | None:
    """Whether the cycle that begins at a mark, and all that follow, are no more what came before."""
    begin = int(marks[cut])
    span = robust_range([y[:begin]])
    if not span > 0.0:
        return None
    error = np.abs(y - terms @ _weights(before)) / span
    error_after = np.abs(y - terms @ _weights(after))[marks[cut + 1] :] / span
    last = error[marks[cut - 1] : begin]
    usual = float(np.quantile(np.concatenate([error[:begin], error_after]), 0.95))
    least = max(CHANGED, CERTAIN * max(usual, float(np.quantile(last, 0.95))))
    if error[begin:].max() <= least:
        return None
    familiar = _seen(terms, begin, before)
    sizes = []
    for first, end in pairwise(marks[cut:]):
        cycle = slice(first, end)
        # A cycle of inputs and pasts that were not seen before says nothing.
        if np.mean(familiar[cycle]) >= COMPARED:
            sizes.append(float(np.quantile(error[cycle][familiar[cycle]], 0.95)))
    if len(sizes) < CYCLES or sizes[0] <= least:
        return None
    speeds = [float(np.mean(np.abs(np.diff(part)))) for part in (x[:begin], x[begin:])]
    if min(sizes) <= LASTS * sizes[0] or max(speeds) > SPEED * min(speeds):
        return None
    limit = max(CERTAIN * usual, float(last.max()))
    return begin, begin + int(np.argmax(error[begin:] > limit)), max(sizes)


def _terms(x: Array, reach: float) -> Array:
    """One, the input, its excess over some levels, and plays, (T, n)."""
    radii = reach * np.linspace(0.02, 0.45, PLAYS)
    levels = np.quantile(x, np.linspace(0.0, 1.0, HINGES + 2)[1:-1])
    plays = _native.play_bank(
        np.ascontiguousarray(x), radii, x[0] + np.zeros(PLAYS), np.arange(x.size)
    )[0]
    shift = 0.5 * (float(x.min()) + float(x.max()))
    hinges = np.maximum(x[:, None] - levels, 0.0)
    return np.column_stack(
        [np.ones(x.size), (x - shift) / reach, hinges / reach, (plays - shift) / reach]
    )


def _ridged(sums: Array) -> Array:
    square = sums[:-1, :-1]
    return np.asarray(square + RIDGE * np.trace(square) * np.eye(square.shape[0]))


def _weights(sums: Array) -> Array:
    return np.asarray(np.linalg.solve(_ridged(sums), sums[:-1, -1]))


def _left(sums: Array) -> float:
    return float(sums[-1, -1] - sums[:-1, -1] @ _weights(sums))


def _seen(terms: Array, begin: int, sums: Array) -> npt.NDArray[np.bool_]:
    """Rows whose description by the first rows is no guess: of the leverage that these have, a little more."""
    leverage = np.sum(terms * np.linalg.solve(_ridged(sums), terms.T).T, axis=1)
    return np.asarray(leverage <= FAR * leverage[:begin].max())


def _about_change(record: Recording, change: Change, cut: bool) -> Finding:
    """Say when and by how much it changed; `cut` from there on."""
    left_out = ""
    if cut:
        at = _at_time(record, change.begin)
        left_out = _cut(change.begin, at, len(record), "the model is what the actuator was")
    place_time = _at_time(record, change.place)
    return Finding(
        "two-actuators",
        f"the output '{record.output_name}' of {record.name} changes at sample {change.place}{place_time} by "
        f"{100.0 * change.size:.0f} % of the range that it had, at the same input and past, and stays so: a jam, a "
        f"lost load, a sensor that was set anew. No single model is both what the actuator was and what it became. "
        f"{left_out}Repair it, or identify the part that is like the use (--from, --to).",
    )


def _at_time(record: Recording, sample: int) -> str:
    """Time of a sample in brackets, "" without time stamps."""
    if record.time is None:
        return ""
    return f" (t = {record.time[sample]:.6g} s)"


def _cut(place: int, time: str, samples: int, result: str) -> str:
    return (
        f"The {samples - place} samples from sample {place}{time} on, of {samples}, were left out of the fit and of "
        f"its errors: {result}. "
    )


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
    stop = 0
    if moving.size:
        stop = int(moving[-1]) + 1
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
    before = _levels(x[:begin], y[:begin], low, high)
    after = _levels(x[stop:], y[stop:], low, high)
    both = np.isfinite(before) & np.isfinite(after)
    if both.sum() < 2 or not np.ptp(before[both]) > FOLLOWED * span:
        return None
    level = np.median(y[stop:])
    trembling = float(np.abs(y[stop + (y.size - stop) // 2 :] - level).max())
    moved = np.flatnonzero(np.abs(y - level) > max(trembling, AT_REST * span))
    return begin, int(moved[-1]) + 1


def _levels(x: Array, y: Array, low: float, high: float) -> Array:
    """Mean output where the input lies in each of some intervals of a range; nan where it never does."""
    cell = np.clip((BINS * (x - low) / (high - low)).astype(np.int64), -1, BINS)
    inside = (x >= low) & (x <= high)
    cell = np.minimum(cell[inside], BINS - 1)
    count = np.bincount(cell, minlength=BINS)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.bincount(cell, y[inside], BINS) / count)


def _about_stop(record: Recording, stop: tuple[int, int], cut: bool) -> Finding:
    """Say where the output came to rest; `cut` from the swing before on."""
    left_out = ""
    if cut:
        at = _at_time(record, stop[0])
        left_out = _cut(stop[0], at, len(record), "the swing before counts as doubtful")
    time = _at_time(record, stop[1])
    end = float(np.median(record.output[stop[1] :]))
    unit = ""
    if record.output_unit:
        unit = f" {record.output_unit}"
    return Finding(
        "output-stopped",
        f"the output '{record.output_name}' of {record.name} stops following its input: from sample "
        f"{stop[1]}{time} on it stays at {end:.4g}{unit} while the input cycles on. The actuator broke, or "
        f"its sensor was lost. {left_out}Repair it, and log again if the model needs more loops.",
    )


SHOWN = 4


# What an actuator that was another one from some sample on is told by.
ENDED = {"two-actuators", "output-stopped"}


def mended(record: Recording, cut: bool = True) -> Recording:
    """Recording whose outliers are bridged, and what follows the end of its actuator `cut`; itself if it is sound.

    A play remembers the extremes of its input, so that a false one there spoils what follows: its memory follows the
    line instead. Reading a log finds the same outliers, and drops their rows.

    Examples
    --------
    >>> x = np.sin(np.arange(200) / 10)
    >>> y = np.where(np.arange(200) == 50, 100.0, 2 * x)
    >>> recording = mended(Recording(input=x, output=y))
    >>> recording.left_out, recording.findings[0].code, bool(recording.output[50] < 2.0)
    ((50,), 'outlier', True)
    """
    record = _bridged(record)
    if all(finding.code != "saturated-input" for finding in record.findings):
        x, y, unit = record.input, record.output, record.input_unit
        clipping = about_clipping(record.input_name, record.name, x, y, unit)
        if clipping:
            record = record.with_findings(*clipping)
    ended = _ended(record, cut)
    if ended is None or ended[0] in record.left_out:
        return record
    if cut:
        after_end = range(ended[0], len(record))
        record = replace(record, left_out=(*record.left_out, *after_end))
    return record.with_findings(ended[1])


def _ended(record: Recording, cut: bool) -> tuple[int, Finding] | None:
    """First sample that is no more of the actuator that was, and why; None if it is one all along."""
    stop = stopped_at(record.input, record.output)
    if stop is not None:
        return stop[0], _about_stop(record, stop, cut)
    change = changed_at(record.input, record.output)
    if change is None:
        return None
    return change.begin, _about_change(record, change, cut)


def _bridged(record: Recording) -> Recording:
    input_mask = _outliers(record, record.input)
    output_mask = _outliers(record, record.output)
    bad = input_mask | output_mask
    if not bad.any():
        return record
    places = []
    memory = ""
    if input_mask.any():
        values = _shown(record.input[input_mask])
        places.append(f"'{record.input_name}' is {values} in {_numbers(input_mask)}")
        memory = " Memory follows the line through the input."
    if output_mask.any():
        values = _shown(record.output[output_mask])
        places.append(f"'{record.output_name}' is {values} in {_numbers(output_mask)}")
    finding = Finding(
        "outlier",
        f"{int(bad.sum())} of {bad.size} samples of {record.name} hold a value far from those beside it "
        f"({'; '.join(places)}); they were left out of the fit and of its errors, and a straight line took their place."
        f"{memory} Check the sensor and its wiring; if the values are real, log faster so that they are more than a "
        f"spike.",
    )
    return replace(
        record,
        input=bridged(record.input, input_mask),
        output=bridged(record.output, output_mask),
        left_out=(*record.left_out, *np.flatnonzero(bad).tolist()),
        findings=(*record.findings, finding),
    )


def _outliers(record: Recording, values: Array) -> Mask:
    """Outliers of each piece: what a signal does across a break is no jump."""
    return np.concatenate([find_outliers(values[piece]) for piece in record.pieces])


def _shown(values: Array) -> str:
    return _first(list(dict.fromkeys(map("{:.6g}".format, values.tolist()))))


def _first(texts: list[str]) -> str:
    """The first few of a list, and dots if there are more."""
    text = ", ".join(texts[:SHOWN])
    if len(texts) > SHOWN:
        text += ", ..."
    return text


def _numbers(mask: Mask) -> str:
    """Which samples, counted from 0 as an array counts them."""
    index = np.flatnonzero(mask)
    if index.size == 1:
        return f"sample {index[0]}"
    if index.size > SHOWN and index[-1] - index[0] == index.size - 1:
        return f"samples {index[0]} to {index[-1]}"
    return f"samples {_first(list(map(str, index.tolist())))}"
