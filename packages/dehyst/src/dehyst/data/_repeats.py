"""Finds samples that two recordings share: one log named twice, a copy of it, or windows that overlap.

Samples that count twice are fitted and tested at once, so that a model of noise looks as if it had been confirmed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask, Rows
from dehyst.data._policy import POLICY
from dehyst.data._recording import Recording
from dehyst.errors import ParameterError
from dehyst.findings import Finding

PROBES = 400  # samples of the shorter recording that are looked for in the longer one
SMOOTH = 1e-9  # of the range: a bend that is rounding, as are those of one step of a converter
LOOKED_AT = 2000  # samples: where these are not rounded, the others need not be looked at
HALF = 0.5001  # of the last digit: so far rounding moves a value


def refuse_repeated(records: Sequence[Recording]) -> None:
    """Refuse recordings that hold the same samples, also as a copy with fewer digits, a window or a thinned copy.

    Raises
    ------
    ParameterError
        If two of them share samples.

    Examples
    --------
    >>> x = np.sin(np.linspace(0.0, 20.0, 400))
    >>> refuse_repeated([Recording(x, 2 * x), Recording(x, 2.1 * x)])
    >>> refuse_repeated([Recording(x, 2 * x), Recording(x, 2 * x)])  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    dehyst.errors.ParameterError: recordings 1 and 2 (recording) hold the same 400 samples...
    """
    sides = [_Side(record) for record in records]
    for first, second in combinations(range(len(sides)), 2):
        shared = _shared(sides[first], sides[second])
        if not shared:
            continue
        names = dict.fromkeys([records[first].name, records[second].name])
        whole = shared == len(records[first]) == len(records[second])
        overlap = f"share {shared} samples"
        if whole:
            overlap = f"hold the same {shared} samples"
        raise ParameterError(
            f"recordings {first + 1} and {second + 1} ({', '.join(names)}) {overlap}: the same log twice, a copy or a "
            f"part of it. What counts twice would be fitted and tested at once, so that even noise would look "
            f"confirmed. Name each log, run and window once, and no copy beside it.",
            recordings=(first, second),
            samples=shared,
        )


def shared_samples(first: Recording, second: Recording) -> int:
    """Count samples of the shorter of two recordings that are samples of the other one too, 0 if they differ.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> x, y = np.cumsum(rng.normal(size=(2, 500)), axis=1)
    >>> log = Recording(x, y)
    >>> shared_samples(log, Recording(x[300:].round(3), y[300:].round(3))), shared_samples(log, Recording(y, x))
    (200, 0)
    """
    return _shared(_Side(first), _Side(second))


Pairs = npt.NDArray[np.complex128]  # input and output of each sample as one number, (T,)


def counted_once(record: Recording) -> Recording:
    """Leave out a stretch that repeats an earlier one sample by sample: a copy behind it, a block that was sent again.

    Two periods of a simulated motion are equal too: only signals with noise are looked at.

    Examples
    --------
    >>> x, y = np.cumsum(np.random.default_rng(1).normal(size=(2, 500)), axis=1)
    >>> found = counted_once(Recording(np.tile(x, 2), np.tile(y, 2)))
    >>> len(found.left_out), found.findings[0].code
    (500, 'repeated-samples')
    """
    block = _repeated(record)
    size = block.stop - block.start
    if not size:
        return record
    rows = range(block.start, block.stop)
    finding = Finding(
        "repeated-samples",
        f"samples {block.start} to {block.stop - 1} of {record.name} repeat {size} earlier ones to the last digit, as "
        f"no two measurements do: a file that was joined with its copy, or a block that was sent twice. They count "
        f"once, so that nothing is fitted and tested at once. Remove the copy from the file.",
    )
    return replace(record, left_out=(*record.left_out, *rows)).with_findings(finding)


def _repeated(record: Recording) -> slice:
    """Longest stretch of a recording that repeats an earlier one; empty if there is none."""
    side = _Side(record)
    rows = side.rows[side.order]
    lags = np.diff(side.order)[rows[1:] == rows[:-1]]
    if lags.size < POLICY.repeated_moves:
        return slice(0, 0)
    values, counts = np.unique(lags, return_counts=True)
    block = _longest(_same(side, side, -int(values[np.argmax(counts)])))
    # Noise elsewhere in the log does not tell whether this stretch was measured twice or simulated.
    if np.count_nonzero(_moves(side.rows[block])) < POLICY.repeated_moves:
        return slice(0, 0)
    if not _is_rough((record.input[block], record.output[block])):
        return slice(0, 0)
    return block


class Digits(NamedTuple):
    """How a signal was rounded when it was written; "binary" 52 is not at all."""

    kind: str  # "decimals", "significant" or "binary"
    digits: int

    def unit(self, values: Array) -> Array | float:
        """Last digit of each value, (T,), or of all of them."""
        if self.kind == "decimals":
            return 10.0**-self.digits
        # A double is exact as it stands: it has no last digit that counts.
        if self == EXACT:
            return 0.0
        if self.kind == "binary":
            return 2.0**-self.digits * np.abs(values)
        size = np.floor(np.log10(np.maximum(np.abs(values), 1e-300)))
        return np.asarray(10.0 ** (size - self.digits + 1))

    def rounded(self, values: Array) -> Array:
        """Values with no more digits than that."""
        if self.kind == "decimals":
            return values.round(self.digits)
        if self.kind == "significant":
            unit = self.unit(values)
            return np.asarray(np.round(values / unit) * unit)
        if self == EXACT:
            return values
        return np.asarray(values.astype(np.float32), dtype=np.float64)

    def hold(self, values: Array) -> bool:
        """Whether values have no more digits than that."""
        rounded = self.rounded(values)
        return bool(np.all(np.abs(rounded - values) <= 1e-14 * np.abs(values)))


EXACT = Digits("binary", 52)
WRITTEN = (
    [Digits("decimals", count) for count in range(POLICY.written_digits)],
    [Digits("significant", count) for count in range(3, POLICY.written_digits)],
    [Digits("binary", 23)],
)


def _digits(values: Array) -> Digits:
    """Of the ways in which a signal may have been rounded the coarsest."""
    possible = [EXACT]
    with np.errstate(over="ignore"):  # a value beyond single precision is not of it
        for ways in WRITTEN:
            # The first samples refuse nearly every way, and they are few.
            for how in ways:
                if how.hold(values[:LOOKED_AT]) and how.hold(values):
                    possible.append(how)
                    break
    return max(possible, key=lambda how: float(np.median(how.unit(values[:LOOKED_AT]))))


class _Side:
    """A recording that is compared with others."""

    def __init__(self, record: Recording) -> None:
        self.signals = (record.input, record.output)
        self.size = len(record)

    @cached_property
    def digits(self) -> tuple[Digits, ...]:
        """Of input and output."""
        return tuple(map(_digits, self.signals))

    @cached_property
    def rows(self) -> Pairs:
        """As they are."""
        return _rows(self.signals)

    @cached_property
    def order(self) -> Rows:
        """Sorts the rows."""
        order: Rows = np.argsort(self.rows, kind="stable")
        return order

    @cached_property
    def is_rough(self) -> bool:
        """Whether a signal holds noise, which no second measurement repeats."""
        return _is_rough(self.signals)

    def like(self, side: _Side) -> Pairs:
        """Rows with no more digits than either of two recordings has, rounded in the same way for both."""
        signals = []
        for values, *digits in zip(self.signals, self.digits, side.digits, strict=True):
            for how in (*sorted(digits), min(digits)):
                values = how.rounded(values)
            signals.append(values)
        return _rows(signals)


def _is_rough(signals: Sequence[Array]) -> bool:
    for values in signals:
        steps = np.diff(values)
        least = float(np.min(np.abs(steps), where=steps != 0.0, initial=np.inf))
        bend = np.diff(steps)
        bend[np.abs(bend) < max(SMOOTH * float(np.ptp(values)), 1.01 * least)] = 0.0
        if np.mean(np.sign(bend[1:]) * np.sign(bend[:-1]) < 0.0) > POLICY.rough:
            return True
    return False


def _rows(signals: Sequence[Array]) -> Pairs:
    rows: Pairs = signals[0] + 1j * signals[1]
    return rows + 0.0  # a negative zero would be sorted elsewhere


def _shared(first: _Side, second: _Side) -> int:
    """Count samples of the shorter of two recordings that are samples of the other one too."""
    long, short = first, second
    if first.size < second.size:
        long, short = second, first
    if short.size == long.size and _same(long, short, 0).all():
        return short.size
    rows, sought, order = long.rows, short.rows, long.order
    if long.digits != short.digits:
        rows, sought = long.like(short), short.like(long)
        order = np.argsort(rows, kind="stable")
    moves = np.flatnonzero(_moves(sought))
    if moves.size < POLICY.sought_moves:
        return 0
    probes = moves[np.linspace(0, moves.size - 1, min(PROBES, moves.size)).astype(np.int64)]
    places = _places(rows, order, sought[probes])
    present = places >= 0
    if present.mean() < POLICY.likely:
        return 0
    lags, counts = np.unique(places[present] - probes[present], return_counts=True)
    block = _longest(_same(long, short, int(lags[np.argmax(counts)])))
    size = int(block.stop - block.start)
    if size >= POLICY.whole_window * short.size:
        return size
    if (
        size > POLICY.shared_block * short.size
        and short.is_rough
        and np.count_nonzero(_moves(sought[block])) >= POLICY.repeated_moves
    ):
        return size
    if _within(rows, order, sought[moves]):
        return short.size
    return 0


def _same(long: _Side, short: _Side, lag: int) -> Mask:
    """Which samples of the shorter recording are those of the other one `lag` later, but for rounding, (T,)."""
    same: Mask = np.zeros(short.size, dtype=bool)
    here = slice(max(0, -lag), max(0, min(short.size, long.size - lag)))
    shifted = slice(here.start + lag, here.stop + lag)
    same[here] = True
    pairs = zip(long.signals, short.signals, strict=True)
    if not all(np.array_equal(a[shifted], b[here]) for a, b in pairs):
        for a, b, *digits in zip(
            long.signals, short.signals, long.digits, short.digits, strict=True
        ):
            unit = np.max(
                [np.broadcast_to(how.unit(b[here]), b[here].shape) for how in digits], axis=0
            )
            same[here] &= np.abs(a[shifted] - b[here]) <= HALF * unit + 1e-14 * np.abs(b[here])
    return same


def _moves(rows: Pairs) -> Mask:
    """At which samples both signals differ from those before."""
    step = np.diff(rows, prepend=rows[:1])
    return np.asarray((step.real != 0.0) & (step.imag != 0.0))


def _places(rows: Pairs, order: Rows, sought: Pairs) -> Rows:
    """Where each of some rows is first, -1 where it is not; `order` sorts the rows."""
    place = np.minimum(np.searchsorted(rows, sought, sorter=order), rows.size - 1)
    return np.where(rows[order[place]] == sought, order[place], -1)


def _longest(same: Mask) -> slice:
    """Longest stretch of a mask."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]]).astype(np.int8)))
    if not edges.size:
        return slice(0, 0)
    longest = int(np.argmax(edges[1::2] - edges[::2]))
    return slice(int(edges[2 * longest]), int(edges[2 * longest + 1]))


def _within(rows: Pairs, order: Rows, sought: Pairs) -> bool:
    """Whether rows that are all different are among others, in the same order: a copy that was thinned out."""
    places = _places(rows, order, sought)
    different = np.unique(sought).size == sought.size
    return different and bool(np.all(places >= 0) and np.all(np.diff(places) > 0))
