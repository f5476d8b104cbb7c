r"""Fits sums over several inputs: for each output one convex program of the columns of all inputs.

    minimise  sum over rows of (c + sum over i of s_i A_i w_i - y)^2  +  n (lam^2 |differences|^2 + ridge^2 |w|^2)
    subject to  w_i >= 0,  w_i >= floor for ramps of the own input,  s_i = +1 or -1

The signs s_i say whether the output rises or falls with each input: those of plays that leave the least error. The
terms are chosen by what is left out of the training (`dehyst.families._choice`). Where two outputs have
two inputs, the floor is raised until the least determinant of the slopes is above 0, so that there is an inverse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from dehyst.arrays import Array
from dehyst.data import kit as data_kit
from dehyst.families._base import Scaling
from dehyst.families._choice import (
    EVERY,
    FIRST,
    MOST_ROWS,
    OTHERS,
    WITHOUT,
    pace_of,
    row_bank,
)
from dehyst.families._columns import Columns, columns_of
from dehyst.families._coupled import LEAST_DETERMINANT, CoupledModel, Paths
from dehyst.families._elements import Element, ElementModel
from dehyst.families._policy import POLICY
from dehyst.families._program import (
    LEAST,
    Numbers,
    Program,
    RampRegularisation,
    Sums,
    Weights,
    block_sums,
)
from dehyst.families._reduction import PROBED_ROWS, Teacher, probing, reduced
from dehyst.families._training import Training
from dehyst.models import SignalCard

RAMPS = 8
# Groups of columns that are tried, in this order, and the same for a log without time stamps.
TERMS = (
    ("play",),
    ("play", "stop"),
    ("lag",),
    ("lag", "lead"),
    ("play", "creep"),
    ("lag", "creep-by-place"),
    ("play", "stop", "creep", "relax", "rate"),
)
TIMELESS = TERMS[:4]
NOTHING = (Element("input", weight=0.0),)
CURVES: tuple[str, ...] = ()
FLOORS = (0.05, 0.1, 0.2, 0.3, 0.4)  # above LEAST


@dataclass(frozen=True, eq=False)
class CoupledTraining:
    """The fitted part of all recordings.

    Attributes
    ----------
    inputs
        Of each input its stretches; their outputs do not count.
    outputs
        Of each output its values along each stretch, scaled.
    """

    inputs: tuple[Training, ...]
    outputs: tuple[tuple[Array, ...], ...]


@dataclass(frozen=True, eq=False)
class FittedOutput:
    """The sums of one output.

    Attributes
    ----------
    terms
        Groups of columns that were chosen.
    kkt
        Violation of the optimality conditions, relative.
    """

    terms: tuple[str, ...]
    kkt: float


@dataclass(frozen=True, eq=False)
class FittedCoupled:
    """The model, what it has to beat, and what is known of each output.

    Attributes
    ----------
    model
        Of all inputs.
    alone, curves
        Of the own input of each output alone, and of curves of all inputs without memory.
    outputs
        What was chosen for each.
    """

    model: CoupledModel
    alone: CoupledModel
    curves: CoupledModel
    outputs: tuple[FittedOutput, ...]


class Rows:
    """Rows of the columns of all inputs, the same samples of each."""

    def __init__(self, training: CoupledTraining, timed: bool) -> None:
        self.training = training
        terms = TERMS if timed else TIMELESS
        groups = list(dict.fromkeys(name for combination in terms for name in combination))
        spread = _merged(training)
        self.columns: list[Columns] = []
        values = []
        for one in training.inputs:
            pace = pace_of(one, "forward") if timed else None
            self.columns.append(columns_of(groups, RAMPS, pace))
            bank = row_bank(one, "forward", self.columns[-1], "rest", spread)
            values.append(bank.values)
        self.values = np.hstack(values)
        self.weight, self.folds, self.places = bank.weight, bank.folds, bank.places
        self.input = np.repeat(np.arange(len(values)), [part.shape[1] for part in values])
        self.is_ramp = np.concatenate([columns.group == "x" for columns in self.columns])
        self.neighbours = self._neighbours()

    def target(self, output: int) -> Array:
        """An output at the rows, (K,)."""
        y = np.empty(len(self.places))
        for number, values in enumerate(self.training.outputs[output]):
            rows = self.places[:, 0] == number
            y[rows] = values[self.places[rows, 1]]
        return y

    def of(self, groups: Sequence[str], inputs: Sequence[int]) -> Numbers:
        """Which columns are those of some groups and inputs."""
        used = []
        begin = 0
        for number, columns in enumerate(self.columns):
            if number in inputs:
                used.append(begin + columns.of(groups))
            begin += columns.cell.size
        return np.concatenate(used)

    @cached_property
    def probed(self) -> Array:
        """All columns along random strokes of one input after the other, the others at rest, (K', p)."""
        blocks = []
        for number, one in enumerate(self.training.inputs):
            parts = []
            x, dt = probing(one.stretches, number)
            chosen = np.unique(np.linspace(0, x.size - 1, PROBED_ROWS).astype(np.int64))
            for other, columns in enumerate(self.columns):
                if other != number:
                    parts.append(np.zeros((chosen.size, columns.cell.size)))
                    continue
                cells = ElementModel(columns.cells)
                e, _ = cells.columns(x, dt, cells.rest(float(x[0])))
                parts.append(columns.values(np.ascontiguousarray(e[chosen])))
            blocks.append(np.hstack(parts))
        return np.vstack(blocks)

    def _neighbours(self) -> Numbers:
        pairs = []
        begin = 0
        for columns in self.columns:
            pairs.append(begin + columns.neighbours)
            begin += columns.cell.size
        return np.concatenate(pairs)


class OutputFit:
    """The program of one output, with one sign for each input."""

    def __init__(self, rows: Rows, output: int, signs: tuple[float, ...]) -> None:
        self.rows, self.signs = rows, signs
        self.y = rows.target(output)
        self.values = rows.values * np.array(signs)[rows.input]

    @cached_property
    def _spread(self) -> Sums:
        return self._summed(self.rows.folds[0])

    @cached_property
    def _in_one_piece(self) -> Sums:
        return self._summed(self.rows.folds[1])

    def _summed(self, fold: Numbers) -> Sums:
        least = np.zeros(self.values.shape[1])
        return block_sums(
            self.values, self.y, fold, least, self.rows.neighbours, 1, self.rows.weight
        )

    def least(self, own: int | None, floor: float, columns: Numbers) -> Array:
        """Least weights of some columns: ramps of the own input have a floor."""
        is_own = self.rows.is_ramp & (self.rows.input == own)
        return np.where(is_own, floor, 0.0)[columns]

    def score(
        self, columns: Numbers, regularisation: RampRegularisation, own: int | None, floor: float
    ) -> float:
        """Return the error on what is left out, as of `dehyst.data.kit.score_of`."""
        errors = []
        values = self.values[:, columns]
        for sums, fold in zip((self._spread, self._in_one_piece), self.rows.folds, strict=True):
            program = Program(sums, columns, False).with_least(self.least(own, floor, columns))
            fitted = program.solve_each(WITHOUT, regularisation)
            for number, weights in enumerate(fitted):
                left_out = fold == number
                if not np.any(left_out):
                    errors.append(np.nan)
                    continue
                miss = weights.outputs(values[left_out] @ weights.weight) - self.y[left_out]
                errors.append(
                    float(np.sqrt(np.average(miss**2, weights=self.rows.weight[left_out])))
                )
        return data_kit.score_of(np.array(errors))

    def weights(
        self, columns: Numbers, regularisation: RampRegularisation, own: int | None, floor: float
    ) -> Weights:
        """Return the weights from all rows."""
        program = Program(self._spread, columns, False)
        return program.with_least(self.least(own, floor, columns)).solve(EVERY, regularisation)

    def effects(self, columns: Numbers, weights: Weights) -> Array:
        """Return how far each input moves the output, rms about its mean, (n,)."""
        sizes = []
        for number in range(len(self.signs)):
            part = self.rows.input[columns] == number
            effect = self.values[:, columns[part]] @ weights.weight[part]
            mean = np.average(effect, weights=self.rows.weight)
            sizes.append(float(np.sqrt(np.average((effect - mean) ** 2, weights=self.rows.weight))))
        return np.array(sizes)


def fit_coupled(
    training: CoupledTraining,
    inputs: Sequence[SignalCard],
    outputs: Sequence[SignalCard],
    scalings: Sequence[Sequence[Scaling]],
    rest: Sequence[float],
    period: float,
) -> FittedCoupled:
    """Return the sums of all outputs, chosen and fitted."""
    timed = all(one.timed for one in training.inputs)
    rows = Rows(training, timed)
    every = tuple(range(len(inputs)))
    fits = []
    effects = []
    plays = rows.of(TERMS[0], every)
    for output in range(len(outputs)):
        fit = _signed(rows, output, plays, len(inputs))
        effects.append(fit.effects(plays, fit.weights(plays, FIRST, None, LEAST)))
        fits.append(fit)
    own = _own(np.array(effects))
    chosen = [_terms(fit, number, every, timed) for fit, number in zip(fits, own, strict=True)]

    def model_of(
        choices: Sequence[ChosenTerms], floor: float
    ) -> tuple[CoupledModel, list[SumsOfOutput]]:
        made = []
        for fit, number, choice in zip(fits, own, choices, strict=True):
            made.append(_sums(fit, choice, number, floor))
        paths = _paths(made, scalings, period)
        return CoupledModel(paths, tuple(inputs), tuple(outputs), tuple(rest), period), made

    def dearer(floor: float) -> float:
        """By how much a floor raises the error on what is left out, of the output where that is most."""
        shares = []
        for fit, choice, number in zip(fits, chosen, own, strict=True):
            columns = rows.of(choice.terms, choice.inputs)
            score = fit.score(columns, choice.regularisation, number, floor)
            shares.append(score / max(choice.score, 1e-300))
        return max(shares)

    model, made = model_of(chosen, LEAST)
    if len(outputs) == len(inputs) == 2:
        certain = model.determinant > LEAST_DETERMINANT
        for floor in FLOORS:
            # Beyond the first certain inverse a firmer one, of lower gain, must cost next to nothing.
            if certain and dearer(floor) > POLICY.affordable_gain:
                break
            firmer, sums = model_of(chosen, floor)
            if firmer.determinant > LEAST_DETERMINANT:
                model, made, certain = firmer, sums, True
    alone, _ = model_of(
        [one._replace(inputs=(i,)) for one, i in zip(chosen, own, strict=True)], LEAST
    )
    curves, _ = model_of([ChosenTerms(CURVES, FIRST, every, 0.0)] * len(fits), LEAST)
    results = []
    for choice, one in zip(chosen, made, strict=True):
        results.append(FittedOutput(choice.terms, one.kkt))
    return FittedCoupled(model, alone, curves, tuple(results))


class ChosenTerms(NamedTuple):
    """Terms of an output, their regularisation, the inputs that take part, and the error on what is left out."""

    terms: tuple[str, ...]
    regularisation: RampRegularisation
    inputs: tuple[int, ...]
    score: float


@dataclass(frozen=True, eq=False)
class SumsOfOutput:
    """Elements from each input, offset, and the violation of the optimality conditions."""

    elements: tuple[tuple[Element, ...], ...]
    offset: float
    kkt: float


def _signed(rows: Rows, output: int, columns: Numbers, inputs: int) -> OutputFit:
    """Return the program with those signs that leave the least error: with a wrong one a weight is 0."""
    best, least = None, np.inf
    for signs in product((1.0, -1.0), repeat=inputs):
        fit = OutputFit(rows, output, signs)
        weights = fit.weights(columns, FIRST, None, 0.0)
        miss = weights.outputs(fit.values[:, columns] @ weights.weight) - fit.y
        error = float(np.average(miss**2, weights=rows.weight))
        if best is None or error < least:
            best, least = fit, error
    assert best is not None  # there is one choice of signs at least
    return best


def _own(effects: Array) -> tuple[int, ...]:
    """Which input is the own one of each output, from the effects (m, n): that which moves it most."""
    if len(effects) == 1 or effects.shape[1] != 2:
        return tuple(int(np.argmax(row)) for row in effects)
    straight, crossed = effects[0, 0] * effects[1, 1], effects[0, 1] * effects[1, 0]
    return (0, 1) if straight >= crossed else (1, 0)


def _terms(fit: OutputFit, own: int, every: tuple[int, ...], timed: bool) -> ChosenTerms:
    """Return the groups, the inputs and the regularisation that err least on what is left out."""
    choices = []
    # Sums of the own input alone come first: of those that are as good the smallest is taken.
    for inputs in ((own,), every):
        for terms in TERMS if timed else TIMELESS:
            columns = fit.rows.of(terms, inputs)
            of_terms = []
            for regularisation in (FIRST, *OTHERS):
                score = fit.score(columns, regularisation, own, LEAST)
                of_terms.append(ChosenTerms(terms, regularisation, inputs, score))
            choices.append(min(of_terms, key=lambda one: one.score))
    least = min(one.score for one in choices)
    return next(one for one in choices if one.score <= POLICY.smaller_model * least)


def _sums(fit: OutputFit, choice: ChosenTerms, own: int, floor: float) -> SumsOfOutput:
    """Return the sums of an output, fitted to all rows, without the terms that hardly matter."""
    rows = fit.rows
    columns = rows.of(choice.terms, choice.inputs)
    weights = fit.weights(columns, choice.regularisation, own, floor)
    probed = (rows.probed * np.array(fit.signs)[rows.input])[:, columns]
    values = fit.values[:, columns]
    of_log = np.arange(len(values) + len(probed)) < len(values)
    score = choice.score or fit.score(columns, choice.regularisation, own, floor)
    teacher = Teacher(
        np.vstack([values, probed]),
        np.concatenate([rows.weight, np.full(len(probed), rows.weight.sum() / len(probed))]),
        (of_log, ~of_log),
        weights.offset,
        weights.weight,
        fit.least(own, floor, columns),
        np.asarray,
    )
    smaller = reduced(teacher, POLICY.reduction * score)
    elements = []
    begin = 0
    used = rows.input[columns]
    for number, table in enumerate(rows.columns):
        weight = np.zeros(table.cell.size)
        part = used == number
        weight[columns[part] - begin] = smaller.weights[part]
        begin += table.cell.size
        signed = []
        for element in table.elements(weight):
            signed.append(replace(element, weight=fit.signs[number] * element.weight))
        elements.append(tuple(signed))
    return SumsOfOutput(tuple(elements), smaller.offset, max(weights.kkt, smaller.kkt))


def _paths(
    made: Sequence[SumsOfOutput], scalings: Sequence[Sequence[Scaling]], period: float
) -> Paths:
    rows = []
    for one, of_output in zip(made, scalings, strict=True):
        paths = []
        for number, elements in enumerate(one.elements):
            offset = one.offset if number == 0 else 0.0
            model = ElementModel(
                elements or NOTHING, offset, scaling=of_output[number], start="rest", period=period
            )
            paths.append(model)
        rows.append(tuple(paths))
    return tuple(rows)


def _merged(training: CoupledTraining) -> tuple[data_kit.SpreadRows, ...]:
    """Return the samples that stand for the log: those of each input by its way, together."""
    n = len(training.inputs)
    by_input = []
    for one in training.inputs:
        signals = [stretch.x for stretch in one.stretches]
        counts = [stretch.counts for stretch in one.stretches]
        by_input.append(data_kit.spread_rows(signals, counts, MOST_ROWS))
    merged = []
    for number, stretch in enumerate(training.inputs[0].stretches):
        weight = np.zeros(stretch.x.size)
        for spread in by_input:
            weight[spread[number].rows] += spread[number].weight / n
        rows = np.flatnonzero(weight)
        merged.append(data_kit.SpreadRows(rows, weight[rows]))
    return tuple(merged)
