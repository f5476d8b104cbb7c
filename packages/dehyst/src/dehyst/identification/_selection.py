"""Chooses a family by its error on held-out samples of the training part.

Each candidate is fitted ten times without a fifth of the way, and scored on it; since the memory of a play depends on
the input alone, which is known throughout, any samples can be left out (`dehyst.data.kit.folds_of`). Five folds are
spread, five are in one piece; a score is the geometric mean of the mean errors on both (`dehyst.data.kit.score_of`):
with a mean of squares the fold that holds the only virgin curve would decide alone. `Folds` sums them once for one
bank of operators.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask, Rows, rank
from dehyst.data import kit as data_kit
from dehyst.data import range_of
from dehyst.identification._data import DataSet
from dehyst.identification._families import (
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
from dehyst.identification._fit import ComparedSetting
from dehyst.identification._memory import largest_radius
from dehyst.identification._policy import POLICY
from dehyst.identification._regressors import NormalEquations, PlayBank, make_bank, ramp_columns
from dehyst.identification._short_signal import ShortSignal, shorten
from dehyst.identification._static_curve import (
    FEWEST_ROWS,
    best_smoothing,
    fit_static,
    held_out_errors,
)
from dehyst.identification._threads import in_parallel

Marks = npt.NDArray[np.bool_]

BLOCKS = data_kit.FOLDS
# What is left of a log without one fold may not move every play; a trace of ridge keeps those at rest, whose
# weights would otherwise be anything. Relative to the rms of the scaled output.
FOLD_RIDGE = 1e-4


def output_knots() -> Array:
    """Knots of the output map over the training range, scaled."""
    return np.linspace(-1.0, 1.0, MAP_PIECES + 1)


class Setting(Protocol):
    """What a choice says about the program."""

    @property
    def family(self) -> str:
        """Model family."""

    @property
    def regularisation(self) -> Regularisation | None:
        """Regularisation of the output map; None if there is none."""


class Folds:
    """Fifths of the rows under one bank of operators; with `whole` all rows are one of them."""

    def __init__(
        self, short: ShortSignal, bank: PlayBank, ramps: bool = True, whole: bool = False
    ) -> None:
        self._short, self._bank = short, bank
        self._y, self._weight = short.y, short.weight
        self._folds = short.folds
        spread, in_one_piece = data_kit.folds_of(short.weight)
        # Parts of the rows that are left out together, whichever fold is.
        part = BLOCKS * in_one_piece + spread
        if whole:
            part = np.zeros(short.rows, dtype=np.int64)
        self.knots = output_knots()
        self._samples = float(np.sum(self._weight))
        self._targets = self._y[None, :]
        if ramps:
            self._targets = np.vstack([ramp_columns(self._y, self.knots), self._y])
        # The rows are walked through once, so the sums are those of parts that lie one after the other.
        self._parts = _parts_of(part)
        self._sums = short.sums(bank.thresholds, bank.states, self._targets, self._parts)
        self._warm: dict[tuple[str, int], Marks | None] = {}
        self._without_fold: dict[int, NormalEquations] = {}

    def errors(self, choice: Setting, eps: float) -> Array:
        """RMSE on every fold of the fit to the others, scaled, (10,); not a number where it has no row."""
        errors = np.full(len(self._folds), np.nan)
        for left_out, rows in enumerate(self._folds):
            if rows.size:
                errors[left_out] = self._estimate(choice, eps, left_out)[2]
        return errors

    def estimates(self, choice: Setting, eps: float) -> list[tuple[Estimate, Rows, float]]:
        """Fit to all spread folds but one, the rows of that fold and the RMSE on them, scaled, for each with rows."""
        results = []
        for left_out, rows in enumerate(self._folds[:BLOCKS]):
            if rows.size:
                results.append(self._estimate(choice, eps, left_out))
        return results

    def _estimate(self, choice: Setting, eps: float, left_out: int) -> tuple[Estimate, Rows, float]:
        rows = self._folds[left_out]
        estimate = self._without(choice, eps, left_out)
        # The level of a piece is what its fitted samples say; those left out do not tell their own.
        miss = self._short.levelled(self._miss(estimate), self._fitted(left_out))[rows]
        error = float(np.sqrt(np.average(miss**2, weights=self._weight[rows])))
        return estimate, rows, error

    def _fitted(self, left_out: int | None) -> Mask:
        """Which rows are fitted, (k,)."""
        fitted = np.ones(self._y.size, dtype=np.bool_)
        if left_out is not None:
            fitted[self._folds[left_out]] = False
        return fitted

    def _without(self, choice: Setting, eps: float, left_out: int) -> Estimate:
        if left_out not in self._without_fold:
            self._without_fold[left_out] = self._sums_without(left_out)
        sums = self._without_fold[left_out]
        estimate = fit_family(
            choice.family, sums, eps, self.knots, choice.regularisation,
            fold_ridge=FOLD_RIDGE**2 * self._samples,
            warm=self._warm.get((choice.family, left_out)),
            triangle=lambda: self._triangle(left_out),
        )  # fmt: skip
        self._warm[choice.family, left_out] = estimate.passive
        return estimate

    def _sums_without(self, left_out: int) -> NormalEquations:
        # Subtracting the fold from the sum of all would round otherwise than adding the others.
        fitted = []
        is_fitted = self._fitted(left_out)
        for part, part_sums in zip(self._parts, self._sums, strict=True):
            if is_fitted[part.start]:
                fitted.append(part_sums)
        return self._summed(self._short.together(fitted), left_out)

    def whole(self, choice: Setting, eps: float) -> tuple[Estimate, float]:
        """Fit to all rows, and its RMSE on these, scaled; pieces with a level of their own each have theirs."""
        whole = self._short.together(self._sums)
        estimate = fit_family(
            choice.family, self._summed(whole, None), eps, self.knots, choice.regularisation,
            warm=self._warm.get((choice.family, -1)), triangle=lambda: self._triangle(None),
        )  # fmt: skip
        self._warm[choice.family, -1] = estimate.passive
        miss = self._short.levelled(self._miss(estimate), self._fitted(None))
        return estimate, float(np.sqrt(np.average(miss**2, weights=self._weight)))

    def _summed(self, matrix: Array, left_out: int | None) -> NormalEquations:
        """Sums with the count of the samples, where levels were taken out of them."""
        if not any(piece.own_level for piece in self._short.pieces):
            return NormalEquations(self._bank.thresholds, matrix)
        samples = float(np.sum(self._weight[self._fitted(left_out)]))
        return NormalEquations(self._bank.thresholds, matrix, samples)

    def _miss(self, estimate: Estimate) -> Array:
        """Error at every row, with the level that the model has."""
        bank = self._bank
        inner = self._short.outputs(bank.thresholds, bank.states, estimate.weights, estimate.offset)
        return mapped(estimate, inner, self.knots) - self._y

    def _triangle(self, left_out: int | None) -> Array:
        from dehyst.least_squares import triangle  # only where normal equations will not do

        plays = self._short.plays(self._bank.thresholds, self._bank.states)
        rows = np.column_stack([np.ones(self._y.size), plays, self._targets.T])
        fitted = self._fitted(left_out)
        rows = self._short.levelled(rows, fitted) * np.sqrt(self._weight)[:, None]
        return triangle(rows[fitted])


def _parts_of(fold: Rows) -> list[slice]:
    """Return the parts of the rows that belong to one fold each, in their order."""
    ends = [*(1 + np.flatnonzero(np.diff(fold))).tolist(), fold.size]
    return [slice(begin, end) for begin, end in itertools.pairwise([0, *ends])]


# Rows that take part in the comparison: more change no choice, only its cost.
COMPARED_ROWS = 4000
# A finer grid changes the fit, not the choice of a family, nor that of the paper's start.
COMPARED_OPERATORS, STARTING_OPERATORS = 100, 2000
NO_DIFFERENCE = 0.002
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
FIRMER = (
    0.01,
    0.0125,
    0.016,
    0.02,
    0.025,
    0.0315,
    0.04,
    0.05,
    0.063,
    0.08,
    0.1,
    0.125,
    0.16,
    0.2,
    0.25,
    0.315,
)
STARTS = ("zero", "rest", "rising", "falling")
# Families in the order of preference at like error, by the orientation of the loop.
BY_ORIENTATION = {
    "counter-clockwise": (STATIC, "pi", "pi-cumulative", "modified-pi"),
    "clockwise": (STATIC, "stop", "pi-cumulative"),
    "mixed": (STATIC, *FAMILIES),
    "none": (STATIC, "pi", "pi-cumulative", "modified-pi"),
}


@dataclass(frozen=True, slots=True)
class Choice:
    """What is fitted in the end."""

    # family, initial_state, regularisation: The settings; the regularisation is None for families without an output map
    family: str
    initial_state: str
    regularisation: Regularisation | None
    power: float | None = None  # Exponent of the threshold grid, or None for the one of the family


def threshold_grid(
    data: DataSet, operators: int, choice: Choice, thresholds: Array | None
) -> Array:
    """Thresholds of one choice, scaled: those of the call, or ((i - 1)/n)^p max|x - m| over the training samples.

    p = 1 is the paper's grid. Leading loops are steep right after a reversal, where p = 2 is dense.
    """
    if thresholds is not None:
        return thresholds / data.half_range
    power: float = grid_power(choice.family)
    if choice.power is not None:
        power = choice.power
    radius = max(
        largest_radius(choice.initial_state, float(piece.x[0]), *range_of(piece.x[: piece.split]))
        for piece in data.pieces
        if piece.split
    )
    grid: Array = (np.arange(operators) / operators) ** power * radius
    return grid


def grid_power(family: str) -> int:
    """Exponent of the threshold grid of a family."""
    if family == "stop":
        return STOP_POWER
    return 1


def possible_choices(families: Sequence[str], starts: Sequence[str]) -> Iterator[Choice]:
    """Every setting to compare, simpler families first; a curve without memory has no start."""
    for family in families:
        family_starts = starts
        if family == STATIC:
            family_starts = starts[:1]
        for start in family_starts:
            if family != "modified-pi":
                yield Choice(family, start, None)
                continue
            for regularisation in REGULARISATIONS:
                yield Choice(family, start, regularisation)


def compare_choices(
    data: DataSet, choices: Iterable[Choice], operators: int, eps: float, thresholds: Array | None
) -> list[tuple[Choice, Array]]:
    """Return each choice with its RMSE on every held-out fold, scaled, (10,)."""
    listed = list(choices)
    # Which samples count depends on the start only by whether it is unknown.
    shorts = {}
    for choice in listed:
        unknown = choice.initial_state == "unknown"
        if unknown not in shorts:
            shorts[unknown] = shorten(data, choice.initial_state, COMPARED_ROWS)

    def errors_of(group: list[Choice]) -> list[tuple[Choice, Array]]:
        start = group[0].initial_state
        short = shorts[start == "unknown"]
        if short.rows < FEWEST_ROWS:
            return []
        if group[0].family == STATIC:
            return [(group[0], held_out_errors(short))]
        count = min(operators, COMPARED_OPERATORS)
        bank = make_bank(data, threshold_grid(data, count, group[0], thresholds), start)
        folds = Folds(short, bank, ramps=any(choice.family == "modified-pi" for choice in group))
        return [(choice, folds.errors(choice, eps)) for choice in group]

    results = list(itertools.chain.from_iterable(in_parallel(errors_of, _by_bank(listed))))
    return sorted(results, key=lambda result: listed.index(result[0]))


def _by_bank(choices: list[Choice]) -> list[list[Choice]]:
    """Choices that share one bank of operators, together."""
    groups: dict[tuple[str, int, bool], list[Choice]] = {}
    for choice in choices:
        bank = (choice.initial_state, grid_power(choice.family), choice.family == STATIC)
        groups.setdefault(bank, []).append(choice)
    return list(groups.values())


def start_of_paper(data: DataSet, operators: int, eps: float, thresholds: Array | None) -> str:
    """Start state of the paper's program: "zero", unless another one halves the error of the fit.

    Data that were made by the operator from another state say so by orders of magnitude; measured data never do.
    """
    errors: dict[str, float] = {}
    short = shorten(data, "zero", COMPARED_ROWS)
    if short.rows < FEWEST_ROWS:
        return "zero"
    count = min(operators, STARTING_OPERATORS)
    for start in ("zero", "origin", "rest", "rising", "falling"):
        choice = Choice("pi", start, None)
        bank = make_bank(data, threshold_grid(data, count, choice, thresholds), start)
        folds = Folds(short, bank, ramps=False, whole=True)
        errors[start] = folds.whole(choice, eps)[1]
    best = min(errors, key=lambda start: rank(errors[start]))
    if errors[best] < 0.5 * errors["zero"]:
        return best
    return "zero"


def choose_operators(data: DataSet, choice: Choice, eps: float) -> tuple[int, Choice]:
    """Fewest operators, and the exponent of their grid, whose error on held-out samples is within 2 % of the least."""
    start = choice.initial_state
    short = shorten(data, start, COMPARED_ROWS)
    if short.rows < FEWEST_ROWS:
        return COMPARED_OPERATORS, choice
    usual_power = grid_power(choice.family)
    # From the fewest operators on; at each number the usual grid comes first.
    grids = []
    for n in OPERATORS:
        for power in sorted(POWERS, key=lambda power: power != usual_power):
            grids.append((n, replace(choice, power=power)))

    def score_of(grid: tuple[int, Choice]) -> float:
        n, setting = grid
        bank = make_bank(data, threshold_grid(data, n, setting, None), start)
        folds = Folds(short, bank, ramps=setting.family == "modified-pi")
        return _score(folds.errors(setting, eps))

    scores = in_parallel(score_of, grids)
    enough = min(scores) + np.log1p(POLICY.within_noise)
    good = [grid for grid, score in zip(grids, scores, strict=True) if score <= enough]
    return good[0]


class Firmness(NamedTuple):
    """What a firmer bound of the slope after a reversal does."""

    # Smallest eps, scaled, with which the inverse's gain is not high, or the largest one that costs no more than 5 % of
    # the fit where that is less; None if the gain is not high anyway, or nothing firmer can be afforded
    affordable: float | None = None
    # enough, cost: Smallest eps with which the gain is not high, or None, and by which share it raises the error of the
    # fit
    enough: float | None = None
    cost: float = 0.0
    # By which share the error of the fit is larger than with the loosest bound, 0.001
    strain: float = 0.0

    def times(self, slope: float) -> Firmness:
        """The same in the units of a call."""
        scaled = self
        if self.affordable is not None:
            scaled = scaled._replace(affordable=self.affordable * slope)
        if self.enough is not None:
            scaled = scaled._replace(enough=self.enough * slope)
        return scaled


def firmness(
    data: DataSet, choice: Choice, operators: int, eps: float, thresholds: Array | None
) -> Firmness:
    """Compare firmer bounds with an eps by the error of the fit and the gain of the inverse."""
    start = choice.initial_state
    if choice.family == STATIC:
        fitted = partial(fit_static, data, start, smoothing=best_smoothing(data, start))
        return _firmness(fitted, eps)
    short = shorten(data, start, COMPARED_ROWS)
    if short.rows < FEWEST_ROWS:
        return Firmness()
    count = min(operators, COMPARED_OPERATORS)
    bank = make_bank(data, threshold_grid(data, count, choice, thresholds), start)
    folds = Folds(short, bank, choice.family == "modified-pi", whole=True)
    return _firmness(partial(folds.whole, choice), eps)


def _firmness(fitted: Callable[[float], tuple[Estimate, float]], eps: float) -> Firmness:
    """From what is fitted with an eps, and its error."""
    estimate, error = fitted(eps)
    result = Firmness()
    if eps > LOOSE:
        result = Firmness(strain=_raised(error, fitted(LOOSE)[1]))
    if not is_high(gain_of(estimate)):
        return result
    for firmer in FIRMER:
        if firmer <= eps:
            continue
        estimate, raised = fitted(firmer)
        cost = _raised(raised, error)
        if cost <= AFFORDABLE:
            result = result._replace(affordable=firmer)
        if not is_high(gain_of(estimate) / ROOM):
            return result._replace(enough=firmer, cost=cost)
    return result


def _raised(error: float, beside: float) -> float:
    """By which share an error is larger than another one."""
    return float(np.hypot(error, EXACT) / np.hypot(beside, EXACT)) - 1.0


def best_choice(results: list[tuple[Choice, Array]]) -> tuple[Choice, tuple[ComparedSetting, ...]]:
    """Return the best choice, a simpler family winning within noise, and the comparison for the report."""
    choices = [choice for choice, _ in results]
    scores = [_score(errors) for _, errors in results]
    order = sorted(range(len(results)), key=scores.__getitem__)
    best = winner = order[0]
    families = list(dict.fromkeys(choice.family for choice in choices))
    usual_margin = POLICY.within_noise
    if choices[best].family == "pi-cumulative":
        usual_margin = POLICY.clearly_better
    for index in order:
        family = choices[index].family
        simpler = families.index(family) < families.index(choices[winner].family)
        margin = usual_margin
        if family == STATIC:
            margin = 1.0 / POLICY.static_as_good - 1.0
        if simpler and scores[index] - scores[best] <= np.log1p(margin):
            winner = index
    # The start state that assumes least wins where it makes no difference.
    for index, choice in enumerate(choices):
        start = choices[winner].initial_state
        same = replace(choice, initial_state=start) == choices[winner]
        if same and index < winner and scores[index] - scores[winner] <= np.log1p(NO_DIFFERENCE):
            winner = index
    candidates = [_candidate(*results[winner], chosen=True)]
    for index in order:
        if index != winner:
            candidates.append(_candidate(*results[index], chosen=False))
    return choices[winner], tuple(candidates)


def _score(errors: Array) -> float:
    """Log of the score, of six digits: settings that differ by rounding alone are equal."""
    return float(np.log(rank(data_kit.score_of(errors) + 1e-12)))


def _candidate(choice: Choice, errors: Array, chosen: bool) -> ComparedSetting:
    # Scaled outputs span 2 over the training part.
    percent = 50.0 * errors
    smoothing = None
    if choice.regularisation is not None:
        smoothing = choice.regularisation.smoothing
    return ComparedSetting(
        family=choice.family,
        initial_state=choice.initial_state,
        smoothing=smoothing,
        error_percent=data_kit.score_of(percent),
        uncertainty_percent=float(np.nanstd(percent, ddof=1) / np.sqrt(percent.size)),
        chosen=chosen,
    )
