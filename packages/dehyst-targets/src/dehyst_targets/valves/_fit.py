"""Dead band and jump of a sticking valve in front of a linear process, and what explains the log without one.

The valve is a row of a grid over S and J; the linear part of each is a least-squares problem. This is the Hammerstein
way of M. Jelali, "Estimation of valve stiction in control loops using separable least-squares and global search
algorithms", Journal of Process Control 18, 2008, with a long past in place of a disturbance model, as S. Karra and
M. N. Karim, "Comprehensive methodology for detection and diagnosis of oscillatory control loops", Control Engineering
Practice 17, 2009, ask for one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst_targets.valves._moves import read_off_valves
from dehyst_targets.valves._policy import POLICY
from dehyst_targets.valves._positions import valve_positions
from dehyst_targets.valves._regression import BlockSums, regression_sums

# Where the valve may stand before the first sample, in shares of what static friction holds.
STARTS = np.array([-0.98, -0.5, 0.0, 0.5, 0.98])
SAME = 0.02  # paths that differ by less than this share of the dead band are one
RATIOS = np.linspace(0.0, 1.0, 3)  # J/S of the first grid
POSITION_RATIOS = np.linspace(
    0.0, 1.0, 5
)  # the same where the position was logged, which shows the jump
FINE_RATIOS = 7  # of each finer one
FIRST, FINE = 45, 13  # dead bands of the first grid, and of each finer one
FINER, PITS = 7, 4  # dead bands around each of so many pits of the first grid
ROUNDS = 2  # of grids around the best valve
DRAWS = 100  # of the block bootstrap
FEWEST_BLOCKS, MOST_BLOCKS = 8, 12
FINEST, COARSEST = 200, 60  # samples a cycle of the valve's path, and of the regression
LONGEST = 20000  # samples of a log of the position whose valve's path is that of every sample
NEAR = np.array(
    [-1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0]
)  # moves of the signal from a valve that was read off
HARMONICS = 7  # of an external periodic disturbance
PERIODS = np.linspace(-1.5, 1.5, 13)  # cycles that its frequency may differ over the log


@dataclass(frozen=True)
class ValveEstimate:
    """A number with its interval of 95 %."""

    value: float
    low: float
    high: float

    def as_dict(self) -> dict[str, float]:
        """Return the three numbers."""
        return {"value": self.value, "low": self.low, "high": self.high}


@dataclass(frozen=True)
class StickingEvidence:
    """What speaks for a sticking valve.

    Attributes
    ----------
    over_linear, over_periodic
        Fall of Schwarz's criterion against a valve that follows, alone and with an external disturbance of one period;
        above 0 the sticking valve explains the log better.
    steadiness
        Mean gain of a block over its standard error.
    """

    over_linear: float
    over_periodic: float
    steadiness: float


@dataclass(frozen=True)
class ValveFit:
    """The best sticking valve of a log.

    `unseen` is the largest dead band that the log does not exclude where a valve that follows does as well. `signal`
    is the controller output and `path` the position at steps of the fit,
    `profile` dead bands and Schwarz's criterion of each against a valve that follows, `read_off` dead band and jump
    that the moves of the position show, None where they do not.
    """

    dead_band: ValveEstimate
    jump: ValveEstimate
    moves_on: bool
    evidence: StickingEvidence
    unseen: float
    swing: float
    period: float
    cycles: float
    signal: Array
    path: Array
    profile: tuple[Array, Array]
    read_off: tuple[float, float] | None


def reversals_of(signal: Array, least: float) -> Array:
    """Return the samples at which a signal turns by more than `least`.

    Examples
    --------
    >>> reversals_of(np.array([0.0, 2.0, 1.5, 3.0, 0.0, 2.0]), 1.0).tolist()
    [3, 4]
    """
    turns = []
    high = low = 0
    way = 0
    for k in range(signal.size):
        if signal[k] > signal[high]:
            high = k
        if signal[k] < signal[low]:
            low = k
        if way >= 0 and signal[high] - signal[k] > least:
            if high:
                turns.append(high)
            way, low, high = -1, k, k
        elif way <= 0 and signal[k] - signal[low] > least:
            if low:
                turns.append(low)
            way, low, high = 1, k, k
    return np.array(turns, dtype=np.intp)


@dataclass(frozen=True)
class _Grid:
    """Valves: (k,) each."""

    dead_band: Array
    jump: Array
    moves_on: Mask

    @classmethod
    def of(cls, dead_bands: Array, ratios: Array, modes: tuple[bool, ...]) -> _Grid:
        rows = []
        for moves_on in modes:
            for dead_band in dead_bands:
                for ratio in ratios:
                    # Without a dead band all valves are one, without a jump both kinds.
                    repeats = (dead_band == 0.0 and (ratio > 0.0 or moves_on is not modes[0])) or (
                        ratio == 0.0 and moves_on is not modes[0]
                    )
                    if not repeats:
                        rows.append((dead_band, ratio * dead_band, moves_on))
        columns = np.array(rows).T
        return cls(columns[0], columns[1], columns[2].astype(bool))


class _TwoRateLog:
    """A log at the two rates that the fit needs."""

    def __init__(self, output: Array, answer: Array, nearest: int) -> None:
        low, high = np.percentile(output, [0.5, 99.5])
        self.swing = float(high - low)
        turns = reversals_of(output, POLICY.swing * self.swing)
        self.cycles = 0.5 * max(turns.size - 1, 1)
        self.period = float(output.size)
        if turns.size > 2:
            self.period = 2.0 * float(np.median(np.diff(turns)))
        # The valve sees the last value of each step, the regression means.
        first = max(1, int(self.period // FINEST))
        if nearest == 0:
            # A valve that sticks after every sample goes another way at another rate, and the position shows it.
            first = min(first, max(1, output.size // LONGEST))
        signal = output[first - 1 :: first]
        coarse = max(1, round(self.period / first / COARSEST))
        self.size = signal.size // coarse
        self.coarse, self.step = coarse, first * coarse
        self.signal = signal[: self.size * coarse]
        means = answer[: self.size * self.step].reshape(self.size, -1).mean(axis=1)
        self.deviation = float(means.std())
        self.answer = (means - means.mean()) / max(self.deviation, 1e-300)
        # A valve that comes free is seen to a sample.
        self.move = float(np.median(np.abs(np.diff(self.means(self.signal[:, None])[:, 0]))))
        self.nearest = nearest
        self.read_off: list[tuple[float, float]] = []
        if nearest == 0:
            largest = POLICY.largest_dead_band * self.swing
            for valve in read_off_valves(output, answer):
                if valve[0] < largest:
                    self.read_off.append(valve)
        self.blocks = int(np.clip(round(self.cycles), FEWEST_BLOCKS, MOST_BLOCKS))

    def means(self, path: Array) -> Array:
        """Return means of paths (T, k) over the steps of the regression, about zero."""
        steps = path.reshape(self.size, self.coarse, -1).mean(axis=1)
        return np.asarray(steps - self.signal.mean())

    def linear(self, others: Array | None = None) -> BlockSums:
        """Return the sums of a valve that follows."""
        return regression_sums(
            self.answer, self.means(self.signal[:, None]), self.blocks, self.nearest, others
        )

    def paths(self, grid: _Grid) -> tuple[Array, BlockSums]:
        """Return of each valve the path (T, k) that explains the answer best among its starts, and its sums."""
        count, starts = grid.dead_band.size, STARTS.size
        hold = 0.5 * (grid.dead_band + grid.jump)
        begin = (self.signal[0] + hold[:, None] * STARTS).ravel()
        path = valve_positions(
            self.signal,
            np.repeat(grid.dead_band, starts),
            np.repeat(grid.jump, starts),
            begin,
            np.repeat(grid.moves_on, starts),
        )
        steps = self.means(path)
        different = _different(steps[self.size // 4 :], SAME * np.repeat(grid.dead_band, starts))
        owner = different // starts
        sums = regression_sums(self.answer, steps[:, different], self.blocks, self.nearest)
        errors = sums.errors(sums.structures[len(sums.structures) // 3])
        best = np.empty(count, dtype=np.intp)
        for k in range(count):
            of_owner = np.flatnonzero(owner == k)
            best[k] = of_owner[errors[of_owner].argmin()]
        return path[:, different[best]], sums.select(best)


def _different(steps: Array, close: Array) -> Array:
    """Return which paths differ from those before them with another start of the same valve."""
    starts = STARTS.size
    chosen: list[int] = []
    for first in range(0, steps.shape[1], starts):
        different: list[int] = []
        for k in range(first, first + starts):
            apart = [float(np.mean(np.abs(steps[:, k] - steps[:, j]))) for j in different]
            if not apart or min(apart) > close[k]:
                different.append(k)
        chosen += different
    return np.array(chosen, dtype=np.intp)


class _Search:
    """The search for the best valve of a log."""

    def __init__(self, log: _TwoRateLog, seed: int) -> None:
        self.log = log
        rng = np.random.default_rng(seed)
        blocks = log.blocks
        self.weights = rng.multinomial(blocks, np.full(blocks, 1.0 / blocks), DRAWS).astype(float)

    def run(self) -> ValveFit:
        log = self.log
        linear = log.linear()
        scores, structures = linear.criterion()
        without, plain = float(scores[0]), structures[0]
        # Denser where dead bands are small.
        largest = POLICY.largest_dead_band * log.swing
        dead_bands = largest * np.linspace(0.0, 1.0, FIRST)[1:] ** 1.5
        ratios = _ratios(log.nearest == 0)
        first = _Tried(self, _Grid.of(dead_bands, ratios, (True, False)))
        profile = _profile(first.grid, first.scores - without)
        # Seen from sample to sample the right valve is a narrow pit, whose edge alone the first grid may meet.
        finer = [_Tried(self, first.near(centre)) for centre in first.pits()]
        read_off = None
        if log.read_off:
            around = [_Tried(self, _grid_near(*valve, log.move)) for valve in log.read_off]
            finer += around
            best_scores = [float(grid_tried.scores.min()) for grid_tried in around]
            read_off = log.read_off[int(np.argmin(best_scores))]
        for grid_tried in finer:
            profile = _with_profile(profile, _profile(grid_tried.grid, grid_tried.scores - without))
        all_tried = [first, *finer]
        tried = min(finer, key=lambda candidate: float(candidate.scores.min()))
        for _ in range(ROUNDS):
            tried = _Tried(self, tried.around())
            all_tried.append(tried)
        k, chosen = tried.best, tried.structure
        gains = linear.block_errors(plain, 0) - tried.sums.block_errors(chosen, k)
        best = float(tried.scores[k])
        evidence = StickingEvidence(without - best, self._periodic() - best, _steadiness(gains))
        limit = best + POLICY.excluded + POLICY.inexact * max(without - best, 0.0)
        possible = [candidate.scores <= limit for candidate in all_tried]
        return ValveFit(
            tried.estimate("dead_band", all_tried, possible, log.move, read_off),
            tried.estimate("jump", all_tried, possible, log.move, read_off),
            bool(tried.grid.moves_on[k]),
            evidence,
            max(_unseen(*profile), float(np.mean(np.abs(np.diff(log.signal))))),
            log.swing,
            log.period,
            log.cycles,
            log.signal,
            tried.path[:, k],
            profile,
            read_off,
        )

    def _periodic(self) -> float:
        """Return the criterion of a valve that follows, and a disturbance of one period with its harmonics."""
        log = self.log
        time = np.arange(log.size)
        best = np.inf
        for shift in PERIODS:
            turn = log.step / log.period + shift / log.size
            waves = []
            for harmonic in range(1, HARMONICS + 1):
                if 0.0 < turn * harmonic < 0.45:
                    phase = 2.0 * np.pi * turn * harmonic * time
                    waves += [np.sin(phase), np.cos(phase)]
            if waves:
                best = min(best, float(log.linear(np.array(waves).T).criterion(more=1)[0][0]))
        return best


class _Tried:
    """A grid of valves that was fitted."""

    def __init__(self, search: _Search, grid: _Grid) -> None:
        self.grid = grid
        self.shows_moves = search.log.nearest == 0
        self.path, self.sums = search.log.paths(grid)
        self.scores, structures = self.sums.criterion(more=2)
        self.best = int(self.scores.argmin())
        self.structure = structures[self.best]
        # Without a past the pit is a wide one.
        self.widest = int(self.sums.errors((0, self.sums.taps)).argmin())
        self.drawn = self.sums.redrawn_errors(self.structure, search.weights).argmin(axis=1)

    def pits(self) -> list[int]:
        """Return the valves around which a finer grid may find a better one."""
        dead_bands, scores = _profile(self.grid, self.scores)
        edge = np.concatenate(([np.inf], scores, [np.inf]))
        pits = np.flatnonzero((scores <= edge[:-2]) & (scores <= edge[2:]))
        deepest = pits[np.argsort(scores[pits], kind="stable")][:PITS]
        centres = []
        for pit in deepest:
            here = np.flatnonzero(self.grid.dead_band == dead_bands[pit])
            centres.append(int(here[self.scores[here].argmin()]))
        if self.widest not in centres:
            centres.append(self.widest)
        return centres

    def near(self, centre: int) -> _Grid:
        """Return a finer grid around one valve, with all jumps."""
        middle = self.grid.dead_band[[centre]]
        step = _step(self.grid.dead_band, middle)
        dead_bands = np.linspace(max(middle[0] - step, 0.1 * middle[0]), middle[0] + step, FINER)
        return _Grid.of(dead_bands, _ratios(self.shows_moves), (True, False))

    def around(self) -> _Grid:
        """Return a finer grid around the best valve and those of the bootstrap."""
        grid = self.grid
        chosen = np.append(self.drawn, self.best)
        near = grid.dead_band[chosen]
        ratio = grid.jump / np.maximum(grid.dead_band, 1e-12)
        step = _step(grid.dead_band, near)
        dead_bands = np.linspace(max(near.min() - step, 0.1 * near.min()), near.max() + step, FINE)
        step = _step(ratio, ratio[chosen])
        ends = np.clip([ratio[chosen].min() - step, ratio[chosen].max() + step], 0.0, 1.0)
        modes = tuple(mode for mode in (True, False) if mode in grid.moves_on[chosen])
        if 0.0 in ratio[chosen]:
            # Without a jump both kinds are one.
            modes = (True, False)
        ratios = np.linspace(ends[0], ends[1], FINE_RATIOS)
        if self.shows_moves:
            # The pit may be so narrow that only the best valve itself lies in it.
            dead_bands = np.union1d(dead_bands, grid.dead_band[self.best])
            ratios = np.union1d(ratios, ratio[self.best])
        return _Grid.of(dead_bands, ratios, modes)

    def estimate(
        self,
        name: str,
        all_tried: list[_Tried],
        possible: list[Mask],
        move: float,
        read_off: tuple[float, float] | None,
    ) -> ValveEstimate:
        """Return the best value of one number and its interval of 95 %.

        The interval holds the values of the bootstrap and of all valves that are possible, and what was read off
        the moves; half a step of the grid, and half of what the signal moves from sample to sample, are added.
        """
        values: Array = getattr(self.grid, name)
        value = float(values[self.best])
        ends = list(np.percentile(values[self.drawn], [2.5, 97.5]))
        if read_off is not None:
            ends.append(read_off[("dead_band", "jump").index(name)])
        for candidate, which in zip(all_tried, possible, strict=True):
            ends += getattr(candidate.grid, name)[which].tolist()
        half = 0.5 * max(_step(values, values[[self.best]]), move)
        return ValveEstimate(value, max(min(*ends, value) - half, 0.0), max(*ends, value) + half)


def _ratios(shows_moves: bool) -> Array:
    """J/S of the first grids."""
    if shows_moves:
        return POSITION_RATIOS
    return RATIOS


def _grid_near(dead_band: float, jump: float, move: float) -> _Grid:
    """Return a fine grid around a valve that was read off, as far as the signal moves from sample to sample."""
    dead_bands = dead_band + np.minimum(move, 0.1 * dead_band) * NEAR
    ratios = np.clip((jump + move * NEAR) / dead_band, 0.0, 1.0)
    return _Grid.of(dead_bands, np.unique(ratios), (True, False))


def _step(values: Array, near: Array) -> float:
    """Largest distance of neighbours from the last value below some to the first one above."""
    ordered = np.unique(np.round(values, 12))
    if ordered.size < 2:
        return 0.0
    first = max(int(np.searchsorted(ordered, near.min() - 1e-9)) - 1, 0)
    last = min(int(np.searchsorted(ordered, near.max() + 1e-9)) + 1, ordered.size)
    return float(np.diff(ordered[first : last + 1]).max())


def _profile(grid: _Grid, scores: Array) -> tuple[Array, Array]:
    """Return dead bands, rising, and the best score of each against a valve that follows."""
    dead_bands = np.unique(grid.dead_band)
    best = [float(scores[grid.dead_band == band].min()) for band in dead_bands]
    return dead_bands, np.array(best)


def _with_profile(first: tuple[Array, Array], second: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return two profiles in one, rising in the dead band."""
    dead_bands = np.concatenate((first[0], second[0]))
    order = np.argsort(dead_bands, kind="stable")
    return dead_bands[order], np.concatenate((first[1], second[1]))[order]


def _unseen(dead_bands: Array, scores: Array) -> float:
    """Largest dead band that is not excluded against a valve that follows."""
    possible = dead_bands[scores < POLICY.excluded]
    if not possible.size:
        return 0.0
    return float(possible.max())


def _steadiness(gains: Array) -> float:
    spread = float(gains.std(ddof=1))
    return float(gains.mean()) / max(spread / math.sqrt(gains.size), 1e-300)


def fit_valve(output: Array, answer: Array, *, measured_directly: bool, seed: int = 0) -> ValveFit:
    """Fit a sticking valve to a controller output and what answers.

    Parameters
    ----------
    output
        Controller output, evenly sampled, (T,). [%]
    answer
        Valve position or measurement, (T,).
    measured_directly
        Whether the answer is the position: then it may answer in the same sample, since no controller reads it.
    seed
        Of the bootstrap.
    """
    return _Search(_TwoRateLog(output, answer, int(not measured_directly)), seed).run()
