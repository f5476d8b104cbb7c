"""Aligns the clocks of two instruments: offset and drift under which an output follows an input best.

    t = begin + (1 + drift) (t_out - t_out[0])          minimise |y(t) - sum_j w_j v_j(t)|^2,   w_j >= 0

with v_j the plays P_r[x], cut into intervals: their sums with weights of one sign are the hysteresis operators that
follow their input and turn when it turns (Preisach's, coarsely). Such an operator has loops of any width, but no lag:
width is not taken for an offset, and a lag of the actuator is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array, Rows
from dehyst.data import summarise_loops
from dehyst.io._policy import POLICY
from dehyst.least_squares import solve_bounded, triangle

# Thresholds of plays for the search, for its minima and for the solution. [half the range of the input]
COARSE = np.array([0.0, 0.1, 0.25, 0.5])
MIDDLE = np.array([0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6, 0.7, 0.85])
FINE = np.concatenate(([0.0, 0.01, 0.02], np.linspace(0.0, 0.95, 22)[1:]))
GRID = 4096  # steps of the search in the longer of two logs
BLOCKS = 24  # of samples whose errors are taken as independent of each other
STEPS = 20
FOLLOWED = 6  # minima of the search that are solved, by each of two measures
# Starts that leave so many times as much as the best one are not solved.
HOPELESS = 10.0
# Smaller corrections than this share of a step of the input, or of their doubt, end the solution.
ENOUGH, ENOUGH_DOUBT = 1e-4, 0.05


class _Detail(NamedTuple):
    """On how many samples a solution rests, and on which operators."""

    rows: int
    thresholds: Array
    intervals: int  # into which each play is cut


ROUGH = _Detail(2000, MIDDLE, 2)
EXACT = _Detail(10_000, FINE, 3)
# What fewer operators would correct shows how much of an offset is their doing.
FEWER = _Detail(10_000, FINE[::2], 3)


@dataclass(frozen=True, slots=True)
class Alignment:
    """Clock of an output in that of its input.

    Attributes
    ----------
    begin
        Time of the output's first sample. [s of the input's clock]
    drift
        By how much a second of the output's clock is longer than one of the input's; 0 where none can be seen.
    begin_doubt, drift_doubt
        Half widths of intervals of 95 %: of `begin` in the middle of the log, and of the drift. [s], [1]
    explained
        Share of the variance of the output that follows the input then, 0 to 1.
    rival
        Another begin that agrees nearly as well, or None. [s]
    """

    begin: float
    drift: float
    begin_doubt: float
    drift_doubt: float
    explained: float
    rival: float | None = None

    def stamps(self, time: Array) -> Array:
        """Stamps of the output in the clock of the input, (T,)."""
        return np.asarray(self.begin + (1.0 + self.drift) * (time - time[0]))


@dataclass(frozen=True, slots=True)
class _Solution:
    """Place of the output's clock, and what is left there."""

    begin: float
    drift: float
    left: float  # mean square of what does not follow, over the variance of the output
    covered: float  # duration that both logs cover [s]
    rises: bool  # with the input
    doubts: tuple[float, float] = (np.inf, np.inf)


def align(tx: Array, x: Array, ty: Array, y: Array) -> Alignment | None:
    """Return how the clock of an output lies in that of its input; None if the logs are too short to say.

    Parameters
    ----------
    tx, x
        Stamps and values of the input, (T,). [s]
    ty, y
        Those of the output, (S,), from any zero. [s]
    """
    if min(tx.size, ty.size) < POLICY.aligned_from or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return None
    problem = _AlignedPair(tx, x, ty, y)
    starts: list[_Solution] = []
    for begin in problem.search():
        start = problem.at(begin, 0.0, ROUGH)
        if start is not None:
            starts.append(start[0])
    if not starts:
        return None
    least = min(start.left for start in starts)
    solutions: list[_Solution] = []
    for place in starts:
        # A step of the grid costs less than that.
        if place.left <= HOPELESS * least + POLICY.alike:
            solutions.append(problem.solve(place, ROUGH, with_drift=False))
    best, rivals = _best(solutions, problem.grid_step)
    drifting = problem.solve(best, EXACT, with_drift=True)
    doubts = problem.doubts(drifting)
    chosen = drifting
    if abs(drifting.drift) <= doubts[1]:
        chosen = problem.solve(replace(drifting, drift=0.0), EXACT, with_drift=False)
        doubts = problem.doubts(chosen)[0], doubts[1]
    return Alignment(
        chosen.begin,
        chosen.drift,
        *doubts,
        1.0 - chosen.left,
        rivals[0] if rivals else None,
    )


def _best(solutions: list[_Solution], apart: float) -> tuple[_Solution, list[float]]:
    """Return the solution to take, and begins that are as good."""
    # Half a period later, a falling output looks like a rising one; and few outputs fall.
    rising = min((entry.left for entry in solutions if entry.rises), default=np.inf)
    falling = min((entry.left for entry in solutions if not entry.rises), default=np.inf)
    rises = POLICY.falls * rising <= falling
    least = rising if rises else falling
    limit = POLICY.as_good * least + POLICY.alike
    equal = [entry for entry in solutions if entry.rises == rises and entry.left <= limit]
    # Of periods that are all alike, those are taken that use most of both logs.
    longest = max(entry.covered for entry in equal)
    long_enough = [entry for entry in equal if entry.covered >= POLICY.as_long * longest]
    best = min(long_enough, key=lambda entry: entry.left)
    rivals = [
        entry.begin
        for entry in solutions
        if entry.left <= limit and abs(entry.begin - best.begin) > apart
    ]
    return best, sorted(rivals, key=lambda begin: abs(begin - best.begin))


class _AlignedPair:
    """Two signals, and what of the input may be in the output."""

    def __init__(self, tx: Array, x: Array, ty: Array, y: Array) -> None:
        self.tx, self.ty = tx, ty - ty[0]
        self.length = float(tx[-1] - tx[0])
        self.step = self.length / (tx.size - 1)
        self.grid_step = max(self.step, max(self.length, float(self.ty[-1])) / GRID)
        width, noise = self._smoothing(x)
        x = _smoothed(x, round(width / self.step))
        y = _smoothed(y, round(width * (ty.size - 1) / float(self.ty[-1])))
        low, high = float(x.min()), float(x.max())
        self.x = (2.0 * x - low - high) / (high - low)
        self.y = (y - y.mean()) / y.std()
        # Noise that is left lets plays run ahead of a turn by the time in which the input passes it.
        way = float(np.mean(np.abs(np.diff(_smoothed(x, 8))))) / self.step
        self.lead = float(np.hypot(noise / way, POLICY.smoothing_shifts * width))
        # Before the input has passed most of its range, wide plays are where they were before the log.
        passed = np.maximum.accumulate(self.x) - np.minimum.accumulate(self.x)
        self.determined = int(np.argmax(passed >= 2.0 * POLICY.passed))

    def _smoothing(self, x: Array) -> tuple[float, float]:
        """Width of the mean that takes the noise of the input out [s], and how much of it stays [input].

        It is far below the duration of a swing. Both signals are smoothed alike, which shifts neither.
        """
        span = float(np.ptp(x))
        noise = 1.4826 * float(np.median(np.abs(np.diff(x, 2)))) / 6.0**0.5
        swings = int(
            np.sum(summarise_loops(x, POLICY.loop_share * span).swings > POLICY.loop_share * span)
        )
        most = POLICY.smoothed_most * self.length / max(swings, 1)
        width = min((noise / (POLICY.quiet * span)) ** 2 * self.step, most)
        return width, noise / max(width / self.step, 1.0) ** 0.5

    def plays(self, thresholds: Array, rows: Rows) -> Array:
        """Plays at some samples, (rows, thresholds)."""
        state = np.full(thresholds.size, self.x[0])
        plays, _ = _native.play_bank(self.x, thresholds, state, rows)
        return np.asarray(plays)

    def search(self) -> list[float]:
        """Begins of the output at which it follows the input best, on a grid, best first."""
        grid = np.arange(self.tx[0], self.tx[-1], self.grid_step)
        # Where the input has gaps, samples serve several steps of the grid.
        rows, places = np.unique(np.searchsorted(self.tx, grid), return_inverse=True)
        plays = self.plays(COARSE, rows.astype(np.int64))[places]
        features = np.column_stack((np.ones(grid.size), plays, plays[:, 0] ** 2))
        y = np.interp(np.arange(0.0, self.ty[-1], self.grid_step), self.ty, self.y)
        left, explained, starts = _left_at_shifts(features, y)
        minima = np.flatnonzero((left[1:-1] <= left[:-2]) & (left[1:-1] < left[2:])) + 1
        if minima.size == 0:
            minima = np.array([int(np.argmin(left))])
        # Of swings that shrink, each period later leaves a smaller share, and explains less.
        by_share = minima[np.argsort(left[minima], kind="stable")][:FOLLOWED]
        by_sum = minima[np.argsort(-explained[minima], kind="stable")][:FOLLOWED]
        chosen = dict.fromkeys([*by_share.tolist(), *by_sum.tolist()])
        return [float(self.tx[0] + self.grid_step * starts[k]) for k in chosen]

    def solve(self, start: _Solution, detail: _Detail, with_drift: bool) -> _Solution:
        """Correct a begin, and the drift, by steps of Gauss and Newton, as long as they leave less."""
        state = self.at(start.begin, start.drift, detail, with_drift)
        if state is None:
            return start
        for _ in range(STEPS):
            solution, correction = state
            least = max(ENOUGH * self.step, ENOUGH_DOUBT * min(solution.doubts[0], self.step))
            if abs(correction[0]) < least:
                break
            better = self._better(solution, correction, detail, with_drift)
            if better is None:
                break
            state = better
        return state[0]

    def _better(
        self, solution: _Solution, correction: Array, detail: _Detail, with_drift: bool
    ) -> tuple[_Solution, Array] | None:
        """Solution after the longest part of a correction that leaves less, or None."""
        for part in (1.0, 0.5, 0.2):
            tried = self.at(*self._moved(solution, part * correction), detail, with_drift)
            if tried is not None and tried[0].left < solution.left:
                return tried
        return None

    def doubts(self, solution: _Solution) -> tuple[float, float]:
        """Doubts of begin and drift: by the errors, and of the begin by what fewer operators would correct."""
        # What is wrong alike from end to end of a log is no drift.
        fewer = self.at(solution.begin, solution.drift, FEWER, True)
        assert fewer is not None
        begin, drift = solution.doubts
        return float(np.hypot(begin, POLICY.misfit * fewer[1][0])) + self.lead, drift

    def _moved(self, solution: _Solution, correction: Array) -> tuple[float, float]:
        """Begin and drift after a correction at the middle of the input and one of the rate."""
        shift = float(np.clip(correction[0], -4.0 * self.grid_step, 4.0 * self.grid_step))
        rate = float(np.clip(correction[1], -POLICY.largest_drift, POLICY.largest_drift))
        middle = 0.5 * (self.tx[0] + self.tx[-1])
        begin = solution.begin + shift + rate * (solution.begin - middle)
        drift = (1.0 + solution.drift) * (1.0 + rate) - 1.0
        return begin, float(np.clip(drift, -POLICY.largest_drift, POLICY.largest_drift))

    def at(
        self, begin: float, drift: float, detail: _Detail, with_drift: bool = False
    ) -> tuple[_Solution, Array] | None:
        """What is left at a begin and a drift, and the correction that would leave less."""
        stamps = begin + (1.0 + drift) * self.ty
        first, last = np.searchsorted(self.tx, (stamps[0], stamps[-1]))
        first = max(first, min(self.determined, first + (last - first) // 4))
        if last - first < POLICY.aligned_from:
            return None
        rows = np.arange(first, last, max(1, (last - first) // detail.rows), dtype=np.int64)
        t = self.tx[rows]
        y = np.interp(t, stamps, self.y)
        spread = float(np.mean((y - y.mean()) ** 2))
        if spread == 0.0:
            return None
        sign = self._sign(rows, y)
        operators = sign * self._operators(rows, detail)
        free = np.ones((rows.size, 1))
        weights = solve_bounded(
            triangle(np.column_stack((free, operators, y))), 1, np.zeros(operators.shape[1])
        ).bounded
        modelled = operators @ weights
        rate = np.gradient(modelled, t)
        middle = 0.5 * (self.tx[0] + self.tx[-1])
        columns = [rate]
        if with_drift:
            columns.append(rate * (t - middle))
        moves = np.column_stack(columns)
        # What the weights that are at work could take up is no sign of an offset.
        known = np.column_stack((free, operators[:, weights > 0.0]))
        basis = np.linalg.qr(known)[0]
        error = y - basis @ (basis.T @ y)
        moves = moves - basis @ (basis.T @ moves)
        residual = y - modelled
        residual = residual - residual.mean()
        normal = moves.T @ moves
        correction = np.zeros(2)
        doubts = [np.inf, np.inf]
        if np.linalg.cond(normal) < 1e14:
            correction[: moves.shape[1]] = np.linalg.solve(normal, moves.T @ error)
            scores = np.array(
                [b.sum(axis=0) for b in np.array_split(moves * error[:, None], BLOCKS)]
            )
            inverse = np.linalg.inv(normal)
            covariance = inverse @ (scores.T @ scores) @ inverse
            doubts[: moves.shape[1]] = (2.0 * np.sqrt(np.diag(covariance))).tolist()
        left = float(np.mean(residual**2)) / spread
        solution = _Solution(
            begin, drift, left, float(t[-1] - t[0]), sign > 0.0, (doubts[0], doubts[1])
        )
        return solution, correction

    def _operators(self, rows: Rows, detail: _Detail) -> Array:
        """Plays cut into intervals, (rows, operators)."""
        plays = self.plays(detail.thresholds, rows)
        edges = np.linspace(-1.0, 1.0, detail.intervals + 1)
        parts = [np.clip(plays, low, high) for low, high in pairwise(edges)]
        return np.hstack(parts)

    def _sign(self, rows: Rows, y: Array) -> float:
        """Whether the output rises with the input, 1, or falls, -1."""
        return float(np.sign(np.sum((self.x[rows] - self.x[rows].mean()) * (y - y.mean()))) or 1.0)


def _smoothed(values: Array, width: int) -> Array:
    """Mean of so many samples about each, twice; of fewer towards the ends."""
    for _ in range(2):
        if width < 2:
            break
        half = min(width // 2, values.size // 4)
        sums = np.concatenate(([0.0], np.cumsum(values)))
        places = np.arange(values.size)
        reach = np.minimum(half, np.minimum(places, values.size - 1 - places))
        values = (sums[places + reach + 1] - sums[places - reach]) / (2 * reach + 1)
    return values


def _left_at_shifts(features: Array, y: Array) -> tuple[Array, Array, Rows]:
    """Share of y's squares that features do not explain, sum of those they do, with y begun at each row; these rows.

    Sums over the rows that both cover come from running sums and from one correlation by FFT.
    """
    count, width = features.shape
    least = round(POLICY.least_overlap * min(count, y.size))
    starts = np.arange(least - y.size, count - least + 1)
    first = np.maximum(starts, 0)
    last = np.minimum(starts + y.size, count)
    products = features[:, :, None] * features[:, None, :]
    sums = np.concatenate((np.zeros((1, width, width)), np.cumsum(products, axis=0)))
    normal = sums[last] - sums[first]
    size = 1 << (count + y.size).bit_length()
    spectrum = np.conj(np.fft.rfft(y, size))[:, None] * np.fft.rfft(features, size, axis=0)
    sides = np.fft.irfft(spectrum, size, axis=0)[starts]
    running = np.concatenate(([0.0], np.cumsum(y)))
    squares = np.concatenate(([0.0], np.cumsum(y**2)))
    total = running[last - starts] - running[first - starts]
    square = squares[last - starts] - squares[first - starts]
    ridge = 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(width)
    weights = np.linalg.solve(normal + ridge, sides[:, :, None])[:, :, 0]
    left = square - np.sum(weights * sides, axis=1)
    spread = square - total**2 / (last - first)
    return left / np.maximum(spread, 1e-12 * square.max()), spread - left, starts
