"""Test for rate dependence and creep: fits the log with and without them, compares on held-out blocks."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import turning_points
from dehyst.findings import Finding
from dehyst.identification._data import ENOUGH, LONG, DataSet
from dehyst.identification._evidence_rows import TimedStretch, block_triangles
from dehyst.identification._policy import POLICY
from dehyst.least_squares import Solution, solve_bounded, triangle
from dehyst.shell import command

RATE, CREEP = "rate", "creep"
BLOCKS = 10
# All 2^10 ways to exchange "with" and "without" in the blocks.
_SIGNS = 1.0 - 2.0 * ((np.arange(1 << BLOCKS)[:, None] >> np.arange(BLOCKS)) & 1)
# Significant at this level, and the error smaller by more than this share.
LEVEL, WORTH = 0.05, 0.02
# What leaves less than the first share of its course unexplained by hysteresis is not found, whatever p; from the
# second one on, what is not found is not there. Both are measured, in decision 41.
IMITATED = 0.04
TOLD = 0.12
# Hysteresis of any kind: a polynomial, stops and lags along the path (their scales in half ranges).
DEGREE = 7
RADII, LENGTHS = np.geomspace(0.01, 0.95, 12), np.geomspace(0.05, 1.5, 5)
# Time constants of creep, from three sampling steps to a third of the log or 1 : 300 of that.
TIMES, STEPS, SHARE, WIDEST = 6, 3.0, 1.0 / 3.0, 300.0
RIDGE = 1e-6
# Of a curve of the input: its pieces, and the slope that is left where it is flat, share of the mean one.
KNOTS, FLAT = 64, 0.05
LEAST = 200  # samples
HELD = 400  # times after the stop at which the model is asked for its output
RESTING = 0.02  # the input rests while it stays within this share of its range
SLOWER = 10.0


@dataclass(frozen=True, slots=True)
class Evidence:
    """What rate, or creep, is worth on data that was not fitted.

    Attributes
    ----------
    group
        "rate" (a term that follows the speed) or "creep" (lags in time).
    without_percent, with_percent
        Error on held-out blocks without and with the group, percent of the range of the signal that is explained:
        RMS of each block, and the geometric mean of these, so that every block counts alike.
    better
        In how many blocks the error is smaller with it.
    blocks
        Number of blocks.
    p
        How often a mean improvement as large as this one, or larger, would come about if the group made no difference:
        the share of all exchanges of "with" and "without" within blocks (exact permutation test, one-sided). Blocks are
        neighbours in time, so it is a guide and no proof.
    own
        Share of the group's course (rms) along this log that no hysteresis imitates, in 0..1.
    apart
        The same along the signal that does not drive, if that is less. A response rests and hurries even where its
        cause is one sine; only where both signals do are rate and creep told apart.
    """

    group: str
    without_percent: float
    with_percent: float
    better: int
    blocks: int
    p: float
    own: float = 1.0
    apart: float = 1.0

    @property
    def told(self) -> bool:
        """Whether the log can tell: along holds and several speeds nothing else imitates rate, or creep."""
        return min(self.own, self.apart) >= TOLD

    @property
    def there(self) -> bool:
        """Whether it is there: p below 5 %, an error smaller by more than 2 %, and a course that is its own."""
        better = self.with_percent < (1.0 - WORTH) * self.without_percent
        return better and self.p < LEVEL and self.own >= IMITATED

    @property
    def size_percent(self) -> float:
        """RMS of what it explains, percent of range; 0 where it is not there."""
        if not self.there:
            return 0.0
        return float(np.sqrt(self.without_percent**2 - self.with_percent**2))

    def as_dict(self) -> dict[str, object]:
        """Return the values as printed by ``--json``."""
        return {
            "group": self.group,
            "without_percent": self.without_percent,
            "with_percent": self.with_percent,
            "better": self.better,
            "blocks": self.blocks,
            "p": self.p,
            "own": self.own,
            "apart": self.apart,
            "told": self.told,
            "there": self.there,
        }

    @property
    def figures(self) -> str:
        """Both errors, with as many digits as tell them apart, at most four."""
        without, with_it = self.without_percent, self.with_percent
        for digits in (2, 3, 4):
            if f"{without:.{digits}f}" != f"{with_it:.{digits}f}":
                break
        return f"{without:.{digits}f} % of range without, {with_it:.{digits}f} % with it"

    @property
    def answer(self) -> str:
        """The result of the test in a few words."""
        if self.there and self.told:
            return "found"
        if self.there:
            return "found, but this log cannot tell rate and creep apart"
        if self.told:
            return "not found"
        return "cannot be told from hysteresis in this log"

    @property
    def words(self) -> str:
        """The quantity on which the output depends."""
        if self.group == RATE:
            return "rate"
        return "time (creep)"

    def __str__(self) -> str:
        """One sentence."""
        return (
            f"dependence on {self.words}: {self.answer}; {self.figures} on held-out blocks, better in {self.better} of "
            f"{self.blocks}, p = {self.p:.2g}, {100 * self.own:.0f} % of its effect unlike hysteresis"
        )


def _round(value: float) -> str:
    """A number with two digits and without an exponent."""
    return f"{float(f'{value:.2g}'):g}"


def rows_of(sizes: Sequence[int], turns: int) -> list[slice]:
    """Choose the samples to test: all of logs of these sizes, or about 50 000 of long ones, at least 40 to a swing."""
    size = sum(sizes)
    if size <= LONG:
        return [slice(0, length) for length in sizes]
    step = max(1, min(-(-size // ENOUGH), size // (40 * max(1, turns))))
    share = min(1.0, step * ENOUGH / size)
    return [slice(0, round(share * length), step) for length in sizes]


def stretches_of(data: DataSet, recording: int, rows: slice, signals: Array) -> list[TimedStretch]:
    """Cut those rows of a recording where its memory breaks; `signals`: time, input, output, loads, (3 + loads, m)."""
    stretches = []
    step = rows.step or 1
    for piece in data.pieces:
        first, last = -(-piece.start // step), -(-(piece.start + piece.x.size) // step)
        time, x, y, *loads = signals[:, first:last]
        if piece.recording == recording and time.size > 2:
            at = np.arange(time.size) * step + first * step - piece.start
            counts = at >= piece.usable_from("zero")
            if piece.weight is not None:
                counts &= piece.weight[at] > 0.0
            # A stretch whose memory is unknown to its end shows nothing.
            if counts.any():
                stretches.append(TimedStretch(time, x, y, counts, tuple(loads)))
    return stretches


def evidence(stretches: Sequence[TimedStretch]) -> tuple[Evidence, ...]:
    r"""Test whether a log depends on rate, and whether it creeps: each beside the other and any hysteresis.

    One of the two signals, q, drives, and the other one is explained by it, with weights fitted to nine of ten blocks
    and scored on the tenth:

    .. math::

        P(q) \pm \Big(\sum_i s_i(q) E_{r_i}[q] + \sum_j p_j(q) R_{x_j}[q] + \sum_m k_m (q - L_{\tau_m}[q])
            + d \dot q\Big), \quad s, p, k, d \ge 0

    Which of the signals drives, and the sign, is what explains the log best: the displacement of a friction, the
    voltage of a piezo. A constant of each block is free, so that a zero that wanders is not taken for creep.

    Returns
    -------
    tested : tuple of Evidence
        Of rate and of creep; empty where samples are too few.

    Examples
    --------
    >>> t = np.arange(0.0, 120.0, 0.05)
    >>> x = np.sin(t**1.3 / 4) * np.where(t % 30 < 20, 1.0, 0.4)
    >>> [(term.group, term.there) for term in evidence([TimedStretch(t, x, x + 0.05 * np.gradient(x, t), t >= 0)])]
    [('rate', True), ('creep', False)]
    """
    if sum(int(stretch.counts.sum()) for stretch in stretches) < LEAST:
        return ()
    tested = _tested(stretches)
    if not _any_there(tested):
        return tested
    # A steep curve is more than the powers of the input follow, and rate or creep may imitate what they leave. Where
    # the input behind that curve describes the log better without them than the input itself with them, it decides.
    behind_curve = _tested(_behind_curve(stretches)) or tested
    decided = []
    for plain, curved in zip(tested, behind_curve, strict=True):
        decided.append(min(plain, curved, key=lambda term: term.without_percent))
    return tuple(decided)


def _any_there(terms: Sequence[Evidence]) -> bool:
    """Whether the log shows rate or creep."""
    return any(term.there for term in terms)


def _behind_curve(stretches: Sequence[TimedStretch]) -> list[TimedStretch]:
    """Put in place of the input what the best rising, or falling, curve makes of it."""
    x = np.concatenate([stretch.x[stretch.counts] for stretch in stretches])
    y = np.concatenate([stretch.y[stretch.counts] for stretch in stretches])
    order = np.argsort(x, kind="stable")
    # The curve goes through the means of parts with equally many samples.
    ends = np.linspace(0, x.size, KNOTS + 1).round().astype(int).tolist()
    places = []
    means = []
    for begin, end in itertools.pairwise(ends):
        if end > begin:
            places.append(float(x[order[begin:end]].mean()))
            means.append(float(y[order[begin:end]].mean()))
    trend = 1.0
    if means[-1] < means[0]:
        trend = -1.0
    curve = trend * np.maximum.accumulate(trend * np.array(means))
    # Some slope has to stay where the curve is flat, or the input could not be told from its output there.
    least = trend * FLAT * float(np.ptp(curve)) / max(float(np.ptp(places)), 1e-300)
    return [s._replace(x=np.interp(s.x, places, curve) + least * s.x) for s in stretches]


def _tested(stretches: Sequence[TimedStretch]) -> tuple[Evidence, ...]:
    """Evidence as `evidence` describes it, of the input as it is."""
    exchanged = [stretch._replace(x=stretch.y, y=stretch.x) for stretch in stretches]
    hypotheses: list[_Hypothesis] = []
    for driven in (stretches, exchanged):
        blocks = _blocks(driven)
        if blocks is None:
            return ()
        for sign in (1.0, -1.0):
            hypotheses.append(_Hypothesis(blocks, len(stretches[0].loads), sign))
    best = min(range(len(hypotheses)), key=lambda k: hypotheses[k].fitted)
    # Two further on stands the same sign with the signals exchanged.
    chosen, turned = hypotheses[best], hypotheses[(best + 2) % 4]
    terms = (chosen.test(RATE, turned), chosen.test(CREEP, turned))
    if _any_there(terms):
        return terms
    # Where nothing is found, nothing is to be told apart.
    return tuple(replace(term, apart=term.own) for term in terms)


def permutation_p(gains: Array) -> float:
    """Share of all sign changes of the gains whose mean is at least as large as theirs.

    Examples
    --------
    >>> permutation_p(np.ones(10))
    0.0009765625
    >>> permutation_p(np.zeros(10))
    1.0
    """
    means: Array = _SIGNS[: 1 << gains.size, : gains.size] @ gains
    return float(np.mean(means >= means[0] - 1e-12 * np.sum(np.abs(gains))))


class _Block(NamedTuple):
    """Triangle of a block's rows, and their number."""

    rows: Array
    samples: int


class _Hypothesis:
    """One choice of the signal that drives, and of the sign of its terms.

    Columns: [powers | stops and lags at either end of the output and of each load | creep | rate | what is explained];
    creep and rate at either end of each load, if there are any.
    """

    def __init__(self, blocks: list[_Block], loads: int, sign: float) -> None:
        ends = max(1, 2 * loads)
        self.free = DEGREE + loads * (DEGREE + 1)
        first = self.free + 2 * (1 + loads) * (RADII.size + LENGTHS.size)
        last = first + ends * (TIMES + 1)
        self.groups = {CREEP: np.arange(first, last - ends), RATE: np.arange(last - ends, last)}
        self.every = np.arange(last + 1)
        signs = np.where((self.every >= self.free) & (self.every < last), sign, 1.0)
        self.blocks = []
        rows = []
        for block in blocks:
            rows.append(block.rows * signs)
            self.blocks.append(_Block(rows[-1], block.samples))
        self.whole = triangle(np.concatenate(rows))
        self.fitted = _square(self.whole, self.every, self._solve(self.every, self.whole))

    @cached_property
    def all_but_one(self) -> list[Array]:
        """Triangle of all blocks without the first, the second, and so on."""
        rows = [block.rows for block in self.blocks]
        triangles = []
        for k in range(len(rows)):
            triangles.append(triangle(np.concatenate(rows[:k] + rows[k + 1 :])))
        return triangles

    @cached_property
    def with_all(self) -> Array:
        """RMS on every block with all columns."""
        return self._held_out(self.every)

    def test(self, group: str, turned: _Hypothesis) -> Evidence:
        """`turned` is the hypothesis in which the other signal drives."""
        remaining = np.setdiff1d(self.every, self.groups[group])
        with_it, without_it = self.with_all, self._held_out(remaining)
        gains = np.log(without_it) - np.log(with_it)
        return Evidence(
            group,
            50.0 * float(np.exp(np.mean(np.log(without_it)))),
            50.0 * float(np.exp(np.mean(np.log(with_it)))),
            int(np.sum(with_it < without_it)),
            BLOCKS,
            permutation_p(gains),
            self._unlike(group, remaining[:-1]),
            turned._unlike(group, remaining[:-1]),
        )

    def _held_out(self, columns: npt.NDArray[np.int64]) -> Array:
        """RMS on every block of the fit to the others; 2 is the range."""
        errors = []
        for block, fitted_rows in zip(self.blocks, self.all_but_one, strict=True):
            solution = self._solve(columns, fitted_rows)
            errors.append(np.sqrt(_square(block.rows, columns, solution) / block.samples))
        return np.maximum(np.array(errors, dtype=np.float64), 1e-12)

    def _solve(self, columns: npt.NDArray[np.int64], rows: Array) -> Solution:
        rows = rows[:, columns]
        penalty = np.zeros((columns.size, columns.size))
        penalty[:-1, :-1] = np.diag(np.sqrt(RIDGE * np.sum(rows[:, :-1] ** 2, axis=0)))
        lower = np.zeros(columns.size - 1 - self.free)
        return solve_bounded(triangle(np.concatenate([rows, penalty])), self.free, lower)

    def _unlike(self, group: str, remaining: npt.NDArray[np.int64]) -> float:
        """Largest share of a column of a group that no combination of the remaining columns imitates."""
        columns = self.whole[:, self.groups[group]]
        factor = triangle(np.column_stack([self.whole[:, remaining], columns]))
        left = np.linalg.norm(factor[remaining.size :, remaining.size :], axis=0)
        return float(np.max(left / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)))


def _square(rows: Array, columns: npt.NDArray[np.int64], solution: Solution) -> float:
    left = rows[:, columns] @ np.concatenate([solution.free, solution.bounded, [-1.0]])
    return float(left @ left)


def _blocks(stretches: Sequence[TimedStretch]) -> list[_Block] | None:
    """Rows of all stretches, x as what drives, in ten blocks less their means; None if a signal stands still."""
    inputs = []
    outputs = []
    steps = []
    longest = 0.0
    for stretch in stretches:
        inputs.append(stretch.x[stretch.counts])
        outputs.append(stretch.y[stretch.counts])
        steps.append(np.diff(stretch.time))
        longest = max(longest, float(stretch.time[-1] - stretch.time[0]))
    input_scaling = _scaling(np.concatenate(inputs))
    output_scaling = _scaling(np.concatenate(outputs))
    if input_scaling is None or output_scaling is None:
        return None
    step = float(np.median(np.concatenate(steps)))
    times = np.geomspace(max(STEPS * step, SHARE * longest / WIDEST), SHARE * longest, TIMES)
    scaled = []
    for stretch in stretches:
        x = (stretch.x - input_scaling[0]) / input_scaling[1]
        y = (stretch.y - output_scaling[0]) / output_scaling[1]
        scaled.append(stretch._replace(x=x, y=y))
    return list(map(_Block._make, block_triangles(scaled, BLOCKS, DEGREE, RADII, LENGTHS, times)))


def _scaling(signal: Array) -> tuple[float, float] | None:
    """Middle and half of the range of a signal; None if it stands still."""
    low = float(signal.min())
    high = float(signal.max())
    if high <= low:
        return None
    return 0.5 * (low + high), 0.5 * (high - low)


def without_holds(
    tested: Sequence[Evidence],
    answer: Callable[[Array], Array],
    time: Array,
    span: tuple[float, float],
) -> Iterator[Finding]:
    """Warn of a model with creep where hysteresis imitates it: of how it answers at a tenth of the speed.

    `span` is the range of the input.
    """
    creep = next((term for term in tested if term.group == CREEP), None)
    if creep is None or creep.own >= TOLD:
        return
    usual = answer(time)
    slower = 100.0 * float(
        np.sqrt(np.mean((answer(SLOWER * time) - usual) ** 2)) / max(np.ptp(usual), 1e-300)
    )
    if slower > POLICY.other_speed:
        line = command("design", range=(f"{span[0]:.3g}", f"{span[1]:.3g}"))
        yield Finding(
            "creep-without-holds",
            f"at a tenth of the log's speed the model answers {slower:.2g} % of range (rms) otherwise, and this "
            f"log cannot confirm that: hysteresis imitates {100 - 100 * creep.own:.0f} % of the course of creep in "
            f"it. Use the model at the speeds of the log, or log with holds after reversals and at different "
            f"speeds; `{line}` plans them.",
        )


def beyond_rests(
    x: Array, time: Array, answer: Callable[[Array, Array], Array], span: float
) -> Iterator[Finding]:
    """Warn of a model that creeps on when it is held at rest for as long as the log, after the log's longest way.

    `answer` maps input and time, each (T,), to the output (T,), whose range is `span`.
    """
    # What was before the first sample and comes after the last is not known.
    turns = turning_points(x)[1:-1]
    up = np.flatnonzero(np.diff(x[turns]) > 0.0)
    if not up.size:
        return
    longest = float(np.max(np.diff(time[turns])))  # from turn to turn, with the rest between them
    whole, step = float(time[-1] - time[0]), float(np.median(np.diff(time)))
    first, last = turns[up[-1]], turns[up[-1] + 1]
    at = int(first + np.argmax(x[first : last + 1] >= x[last] - RESTING * np.ptp(x)))
    # The pause is seen from the sampling step on, so that the speed of before is gone.
    pauses = np.geomspace(step, whole, HELD)
    y = answer(
        np.concatenate([x[: at + 1], np.full(HELD, x[at])]),
        np.concatenate([time[: at + 1], time[at] + pauses]),
    )[-HELD:]
    unseen = pauses >= longest
    drift = 100.0 * np.abs(y - y[unseen][0])[unseen] / max(span, 1e-300)
    if drift.max() > POLICY.beyond_rests:
        settled = float(pauses[unseen][np.flatnonzero(drift >= 0.9 * drift.max())[0]])
        hold = _round(1.05 * settled)
        line = command("design", range=(f"{np.min(x):.3g}", f"{np.max(x):.3g}"), hold=hold)
        yield Finding(
            "creep-beyond-rests",
            f"held at rest for {_round(whole)} s the model creeps on by {drift.max():.2g} % of range after the "
            f"first {_round(longest)} s, and from one turn to the next the log never takes longer: this is a guess. "
            f"Where the actuator will rest longer, log a rest of {hold} s; `{line}` plans one.",
        )
