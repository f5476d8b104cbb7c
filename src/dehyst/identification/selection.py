"""Chooses a family by its error on held-out blocks of the training part.

The training samples are cut into five consecutive blocks. Each candidate is fitted five times without one block and
scored on it; since the memory of a play depends on the input alone, which is known throughout, a block can be left out
anywhere. Scores are compared by ratio (geometric mean over the blocks): blocks differ in difficulty, and one that holds
the only virgin curve must not decide alone. `Folds` sums the blocks once for one bank of operators.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, rank
from dehyst.identification.data import DataSet, extremes
from dehyst.identification.families import (
    FAMILIES,
    MAP_PIECES,
    STATIC,
    Estimate,
    Regularisation,
    fit_family,
    gain_of,
    is_high,
    mapped,
)
from dehyst.identification.fit import Candidate
from dehyst.identification.memory import largest_radius
from dehyst.identification.regressors import Bank, NormalEquations, make_bank, ramp_columns
from dehyst.identification.short_signal import ShortSignal, shorten
from dehyst.identification.static_curve import fit_static, held_out_errors
from dehyst.identification.threads import in_parallel

Marks = npt.NDArray[np.bool_]

BLOCKS = 5
# What is left of a log without one block may not move every play; a trace of ridge keeps those at rest, whose
# weights would otherwise be anything. Relative to the rms of the scaled output.
FOLD_RIDGE = 1e-4


def output_knots() -> Array:
    """Knots of the output map over the training range, scaled."""
    return np.linspace(-1.0, 1.0, MAP_PIECES + 1)


def blocks_of(rows: int, blocks: int = BLOCKS) -> list[slice]:
    """Consecutive blocks of some rows."""
    parts = np.array_split(np.arange(rows), blocks)
    return [slice(int(part[0]), int(part[-1]) + 1) for part in parts]


class Setting(Protocol):
    """What a choice says about the program."""

    @property
    def family(self) -> str:
        """Model family."""

    @property
    def regularisation(self) -> Regularisation | None:
        """Of the output map."""


class Folds:
    """Consecutive blocks of the rows under one bank of operators."""

    def __init__(self, short: ShortSignal, bank: Bank, blocks: int = BLOCKS, ramps: bool = True) -> None:
        self._short, self._bank = short, bank
        self._y, self._weight = short.y, short.weight
        self._blocks = blocks_of(short.rows, blocks)
        self.knots = output_knots()
        self._samples = float(self._y.size if self._weight is None else np.sum(self._weight))
        self._targets = self._y[None, :]
        if ramps:
            self._targets = np.vstack([ramp_columns(self._y, self.knots), self._y])
        self._sums = short.sums(bank.thresholds, bank.states, self._targets, self._blocks)
        self._warm: dict[tuple[str, int], Marks | None] = {}

    def errors(self, choice: Setting, eps: float) -> Array:
        """RMSE on every block of the fit to the others, scaled, (blocks,)."""
        return np.array([error for _, _, error in self.estimates(choice, eps)])

    def estimates(self, choice: Setting, eps: float) -> list[tuple[Estimate, slice, float]]:
        """Fit to all blocks but one, the rows of that block and the RMSE on them, scaled, for each block."""
        estimates = [self._without(choice, eps, left_out) for left_out in range(len(self._blocks))]
        return [(found, block, self._rms(found, block)) for found, block in zip(estimates, self._blocks, strict=True)]

    def _without(self, choice: Setting, eps: float, left_out: int) -> Estimate:
        others = [block for k, block in enumerate(self._sums) if k != left_out]
        sums = self._summed(np.sum(others, axis=0), left_out)
        estimate = fit_family(
            choice.family, sums, eps, self.knots, choice.regularisation,
            fold_ridge=FOLD_RIDGE**2 * self._samples,
            warm=self._warm.get((choice.family, left_out)),
            triangle=lambda: self._triangle(left_out),
        )  # fmt: skip
        self._warm[choice.family, left_out] = estimate.passive
        return estimate

    def whole(self, choice: Setting, eps: float) -> tuple[Estimate, float]:
        """Fit to all rows, and its RMSE on these, scaled."""
        whole = self._sums[0] if len(self._sums) == 1 else np.sum(self._sums, axis=0)
        estimate = fit_family(
            choice.family, self._summed(whole, None), eps, self.knots, choice.regularisation,
            warm=self._warm.get((choice.family, -1)), triangle=lambda: self._triangle(None),
        )  # fmt: skip
        self._warm[choice.family, -1] = estimate.passive
        return estimate, self._rms(estimate, slice(0, self._y.size), alone=False)

    def _summed(self, matrix: Array, left_out: int | None) -> NormalEquations:
        """Sums with the count of the samples, where levels were taken out of them."""
        if not any(piece.own_level for piece in self._short.pieces):
            return NormalEquations(self._bank.thresholds, matrix)
        counts = np.ones(self._y.size) if self._weight is None else self._weight.copy()
        if left_out is not None:
            counts[self._blocks[left_out]] = 0.0
        return NormalEquations(self._bank.thresholds, matrix, float(np.sum(counts)))

    def _rms(self, estimate: Estimate, block: slice, alone: bool = True) -> float:
        bank = self._bank
        inner = self._short.outputs(bank.thresholds, bank.states, estimate.weights, estimate.offset)[block]
        residual = self._short.levelled(mapped(estimate, inner, self.knots) - self._y[block], block, alone)
        return float(np.sqrt(np.average(residual**2, weights=None if self._weight is None else self._weight[block])))

    def _triangle(self, left_out: int | None) -> Array:
        from dehyst.identification.least_squares import triangle  # only where normal equations will not do

        plays = self._short.plays(self._bank.thresholds, self._bank.states)
        rows = np.column_stack([np.ones(self._y.size), plays, self._targets.T])
        for block in self._blocks:
            rows[block] = self._short.levelled(rows[block], block, alone=False)
        if self._weight is not None:
            rows *= np.sqrt(self._weight)[:, None]
        return triangle(rows if left_out is None else np.delete(rows, self._blocks[left_out], axis=0))


# Rows that take part in the comparison: more change no choice, only its cost.
COMPARED_ROWS = 4000
# A finer grid changes the fit, not the choice of a family, nor that of the paper's start.
COMPARED_OPERATORS, STARTING_OPERATORS = 100, 2000
FEWEST_ROWS = 40
# Errors below this share of the best candidate's are not told apart: a block at standstill must not decide.
FLOOR = 0.1
# A simpler family is preferred when its error is within this share of the best one.
WITHIN_NOISE = 0.02
# Cumulative slopes are bounded by nothing outside the fitted amplitudes: they must be clearly better than stops.
CLEARLY_BETTER = 0.15
NO_DIFFERENCE = 0.002
# A curve without memory is as good as a model whose error is more than this share of the curve's.
STATIC_AS_GOOD = 0.95
REGULARISATIONS = tuple(Regularisation(s, r) for s in (0.003, 0.01, 0.03) for r in (0.05, 0.1))
# Exponent of the threshold grid of the stop form.
STOP_POWER = 2
# What "auto" compares for the number of operators and the exponent of their grid.
OPERATORS = (5, 7, 10, 14, 20, 28, 40, 57, 80, 113, 160)
POWERS = (1.0, 2.0)
# The loosest bound that is begun with, relative to the ratio of the ranges.
LOOSE = 0.001
# A firmer eps may raise the error of the fit by this share, where that is more than rounding.
AFFORDABLE = 0.05
EXACT = 1e-6
# It has to leave the gain this share of what is high: with all rows the output map may be a little steeper.
ROOM = 0.9
# What is tried, relative to the ratio of the ranges: ten preferred numbers to a decade.
FIRMER = (0.01, 0.0125, 0.016, 0.02, 0.025, 0.0315, 0.04, 0.05, 0.063, 0.08, 0.1, 0.125, 0.16, 0.2, 0.25, 0.315)
STARTS = ("zero", "rest", "rising", "falling")
# Families in the order of preference at like error, by the orientation of the loop.
BY_ORIENTATION = {
    "counter-clockwise": (STATIC, "pi", "modified-pi"),
    "clockwise": (STATIC, "stop", "pi-cumulative"),
    "mixed": (STATIC, *FAMILIES),
    "none": (STATIC, "pi", "modified-pi"),
}


@dataclass(frozen=True, slots=True)
class Choice:
    """What is fitted in the end."""

    # family, initial_state, regularisation: The settings; the regularisation is None for families without an output map
    family: str
    initial_state: str
    regularisation: Regularisation | None
    power: float | None = None  # Exponent of the threshold grid, or None for the one of the family


def threshold_grid(data: DataSet, operators: int, choice: Choice, given: Array | None) -> Array:
    """Thresholds of one choice, scaled: the given ones, or ((i - 1)/n)^p max|x - m| over the training samples.

    p = 1 is the paper's grid. Leading loops are steep right after a reversal, where p = 2 is dense.
    """
    power = grid_power(choice.family) if choice.power is None else choice.power
    if given is not None:
        return given / data.half_range
    radius = max(
        largest_radius(choice.initial_state, float(piece.x[0]), *extremes(piece.x, slice(0, piece.split)))
        for piece in data.pieces
        if piece.split
    )
    grid: Array = (np.arange(operators) / operators) ** power * radius
    return grid


def grid_power(family: str) -> int:
    """Exponent of the threshold grid of a family."""
    return STOP_POWER if family == "stop" else 1


def possible_choices(families: Sequence[str], starts: Sequence[str]) -> Iterator[Choice]:
    """Every setting to compare, simpler families first; a curve without memory has no start."""
    for family in families:
        for start in starts if family != STATIC else starts[:1]:
            if family == "modified-pi":
                yield from (Choice(family, start, regularisation) for regularisation in REGULARISATIONS)
            else:
                yield Choice(family, start, None)


def compare(
    data: DataSet, choices: Iterable[Choice], operators: int, eps: float, given: Array | None
) -> list[tuple[Choice, Array]]:
    """Return each choice with its RMSE on every held-out block, scaled, (BLOCKS,)."""
    listed = list(choices)
    shorts = {unknown: shorten(data, start, COMPARED_ROWS) for unknown, start in _memories(listed).items()}

    def errors_of(group: list[Choice]) -> list[tuple[Choice, Array]]:
        start = group[0].initial_state
        short = shorts[start == "unknown"]
        if short.rows < FEWEST_ROWS:
            return []
        if group[0].family == STATIC:
            return [(group[0], held_out_errors(short, blocks_of(short.rows)))]
        bank = make_bank(data, threshold_grid(data, min(operators, COMPARED_OPERATORS), group[0], given), start)
        folds = Folds(short, bank, ramps=any(choice.family == "modified-pi" for choice in group))
        return [(choice, folds.errors(choice, eps)) for choice in group]

    results = [result for part in in_parallel(errors_of, _by_bank(listed)) for result in part]
    return sorted(results, key=lambda result: listed.index(result[0]))


def _memories(choices: list[Choice]) -> dict[bool, str]:
    """Which samples count depends on the start only by whether it is unknown."""
    return {choice.initial_state == "unknown": choice.initial_state for choice in choices}


def _by_bank(choices: list[Choice]) -> list[list[Choice]]:
    """Choices that share one bank of operators, together."""
    groups: dict[tuple[str, int, bool], list[Choice]] = {}
    for choice in choices:
        bank = (choice.initial_state, grid_power(choice.family), choice.family == STATIC)
        groups.setdefault(bank, []).append(choice)
    return list(groups.values())


def start_of_paper(data: DataSet, operators: int, eps: float, given: Array | None) -> str:
    """Start state of the paper's program: "zero", unless another one halves the error of the fit.

    Data that were made by the operator from another state say so by orders of magnitude; measured data never do.
    """
    errors: dict[str, float] = {}
    short = shorten(data, "zero", COMPARED_ROWS)
    if short.rows < FEWEST_ROWS:
        return "zero"
    for start in ("zero", "origin", "rest", "rising", "falling"):
        grid = threshold_grid(data, min(operators, STARTING_OPERATORS), Choice("pi", start, None), given)
        bank = make_bank(data, grid, start)
        folds = Folds(short, bank, blocks=1, ramps=False)
        errors[start] = folds.whole(Choice("pi", start, None), eps)[1]
    best = min(errors, key=lambda start: rank(errors[start]))
    return best if errors[best] < 0.5 * errors["zero"] else "zero"


def choose_operators(data: DataSet, choice: Choice, eps: float) -> tuple[int, Choice]:
    """Fewest operators, and the exponent of their grid, whose error on held-out blocks is within 2 % of the least."""
    start = choice.initial_state
    short = shorten(data, start, COMPARED_ROWS)
    if short.rows < FEWEST_ROWS:
        return COMPARED_OPERATORS, choice
    grids = [(n, replace(choice, power=power)) for n in OPERATORS for power in POWERS]

    def score_of(grid: tuple[int, Choice]) -> float:
        n, setting = grid
        bank = make_bank(data, threshold_grid(data, n, setting, None), start)
        folds = Folds(short, bank, ramps=setting.family == "modified-pi")
        return _score(folds.errors(setting, eps))

    scores = in_parallel(score_of, grids)
    enough = min(scores) + np.log1p(WITHIN_NOISE)
    own = grid_power(choice.family)
    good = [grid for grid, score in zip(grids, scores, strict=True) if score <= enough]
    return min(good, key=lambda grid: (grid[0], grid[1].power != own))


class Firmness(NamedTuple):
    """What a firmer bound of the slope after a reversal does."""

    # Smallest eps, scaled, with which the inverse's gain is not high, or the largest one that costs no more than 5 % of
    # the fit where that is less; None if the gain is not high anyway, or nothing firmer can be afforded
    affordable: float | None = None
    # enough, cost: Smallest eps with which the gain is not high, or None, and by which share it raises the error of the
    # fit
    enough: float | None = None
    cost: float = 0.0
    strain: float = 0.0  # By which share the error of the fit is larger than with the loosest bound, 0.001

    def times(self, slope: float) -> Firmness:
        """The same in the units of a call."""
        affordable, enough = (None if eps is None else eps * slope for eps in self[:2])
        return self._replace(affordable=affordable, enough=enough)


def firmness(data: DataSet, choice: Choice, operators: int, eps: float, given: Array | None) -> Firmness:
    """Compare firmer bounds with an eps by the error of the fit and the gain of the inverse."""
    start = choice.initial_state
    if choice.family == STATIC:
        return _firmness(partial(fit_static, data, start), eps)
    short = shorten(data, start, COMPARED_ROWS)
    if short.rows < FEWEST_ROWS:
        return Firmness()
    bank = make_bank(data, threshold_grid(data, min(operators, COMPARED_OPERATORS), choice, given), start)
    return _firmness(partial(Folds(short, bank, 1, choice.family == "modified-pi").whole, choice), eps)


def _firmness(fitted: Callable[[float], tuple[Estimate, float]], eps: float) -> Firmness:
    """From what is fitted with an eps, and its error."""
    estimate, error = fitted(eps)
    found = Firmness(strain=_raised(error, fitted(LOOSE)[1]) if eps > LOOSE else 0.0)
    for firmer in FIRMER if is_high(gain_of(estimate)) else ():
        if firmer <= eps:
            continue
        estimate, raised = fitted(firmer)
        cost = _raised(raised, error)
        if cost <= AFFORDABLE:
            found = found._replace(affordable=firmer)
        if not is_high(gain_of(estimate) / ROOM):
            return found._replace(enough=firmer, cost=cost)
    return found


def _raised(error: float, beside: float) -> float:
    """By which share an error is larger than another one."""
    return float(np.hypot(error, EXACT) / np.hypot(beside, EXACT)) - 1.0


def choose(results: list[tuple[Choice, Array]]) -> tuple[Choice, tuple[Candidate, ...]]:
    """Return the best choice, a simpler family winning within noise, and the comparison for the report."""
    floor = FLOOR * min(float(np.sqrt(np.mean(errors**2))) for _, errors in results)
    scores = [_score(np.hypot(errors, floor)) for _, errors in results]
    order = sorted(range(len(results)), key=scores.__getitem__)
    winner = order[0]
    families = list(dict.fromkeys(choice.family for choice, _ in results))
    for index in order:
        simpler = families.index(results[index][0].family) < families.index(results[winner][0].family)
        margin = CLEARLY_BETTER if results[order[0]][0].family == "pi-cumulative" else WITHIN_NOISE
        if results[index][0].family == STATIC:
            margin = 1.0 / STATIC_AS_GOOD - 1.0
        if simpler and scores[index] - scores[order[0]] <= np.log1p(margin):
            winner = index
    for index in range(len(results)):  # the start state that assumes least, where it makes no difference
        same = replace(results[index][0], initial_state=results[winner][0].initial_state) == results[winner][0]
        if same and index < winner and scores[index] - scores[winner] <= np.log1p(NO_DIFFERENCE):
            winner = index
    candidates = [
        _candidate(*results[index], chosen=index == winner) for index in [winner, *(k for k in order if k != winner)]
    ]
    return results[winner][0], tuple(candidates)


def _score(errors: Array) -> float:
    """Log of the geometric mean, of six digits: settings that differ by rounding alone are equal."""
    return float(np.log(rank(float(np.exp(np.mean(np.log(errors + 1e-12)))))))


def _candidate(choice: Choice, errors: Array, chosen: bool) -> Candidate:
    # Scaled outputs span 2 over the training part.
    percent = 50.0 * errors
    return Candidate(
        family=choice.family,
        initial_state=choice.initial_state,
        smoothing=None if choice.regularisation is None else choice.regularisation.smoothing,
        error_percent=float(np.exp(np.mean(np.log(np.maximum(percent, 1e-12))))),
        uncertainty_percent=float(np.std(percent, ddof=1) / np.sqrt(percent.size)),
        chosen=chosen,
    )
