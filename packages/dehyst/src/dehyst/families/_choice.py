r"""Chooses the terms, output map and regularisation of a sum of elements by what is left out of the training.

A fifth of the way of the input is left out in turn, once in four parts that are spread over the training and once in
one piece (`dehyst.data.kit.folds_of`), and predicted from the rest. The score of a candidate is, of the rms errors e_i
of the spread fifths and f_i of the others::

    score = sqrt(mean(e_1 .. e_5) mean(f_1 .. f_5))

A mean of squares would let one fifth decide that contains what no other one contains (usually the largest loop); a mean
of ratios would let one decide on which the output hardly moves. The errors of the fit itself do not count: they are
smallest for the sums with the most weights, and say nothing about a motion that was not logged (docs/decisions/0043).
The errors of a sum in the inverse direction are those of its solution. The two best rows, with and without a map, are
tried with every regularisation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from dehyst.arrays import Array, rank
from dehyst.data import kit as data_kit
from dehyst.errors import DehystError, IdentificationError
from dehyst.families._base import Scaling
from dehyst.families._columns import GROUPS, RATE_LAGS, Columns, Pace, columns_of
from dehyst.families._elements import NO_MAP, Element, ElementModel, Pairs
from dehyst.families._linear_form import LinearForm
from dehyst.families._policy import POLICY
from dehyst.families._program import (
    BLOCKS,
    LEAST,
    LEAST_OF_MAP,
    PIECES,
    Marks,
    Numbers,
    Program,
    RampRegularisation,
    Sums,
    Weights,
    block_sums,
    penalty_of,
)
from dehyst.families._reduction import PROBED_ROWS, Teacher, probing, reduced
from dehyst.families._table import Sum
from dehyst.families._training import Stretch, Training
from dehyst.models import kit as models_kit

EVERY = tuple(range(BLOCKS))
# What each fold is predicted from.
WITHOUT = tuple(EVERY[:fold] + EVERY[fold + 1 :] for fold in EVERY)
# Samples of a training that the elements see. Longer ones are thinned; their turning points stay.
MOST_SAMPLES = 20_000
MOST_ROWS = 4000  # of the choice, spread over the training; elements see every sample
FEWEST = 4 * BLOCKS
RAMPS = {"forward": 8, "inverse": 16}
OF_MAP = {"forward": PIECES, "inverse": 1}  # no inverse row has a map
FIRST = RampRegularisation(0.003, 0.001)
OTHERS = (
    RampRegularisation(0.0005, 0.0003),
    RampRegularisation(0.02, 0.003),
    RampRegularisation(0.1, 0.01),
)
FINALISTS = 2
MADE_SMALL = 4  # of the best sums, the smallest of which is taken
MADE_TO_FIT = 12  # of the best sums, where only so many numbers are allowed
FIRMER, FIRMEST = 1.001, 4.0  # a gain without bound is met in steps
TRIES = 10
STARTS = {  # the origin is that of the log's input
    "forward": ("zero", "rest", "rising", "falling", "origin"),
    "inverse": ("zero", "rest", "rising", "falling"),
}
FARTHEST = 1.6  # scaled outputs beyond it are not predicted: 0.3 of the range beyond what was seen
CHUNK = 512  # samples whose columns stay in the cache of a processor
SMALLEST = 1e-9
USUAL = 0.95  # of the samples move less than what a rate is scaled with


@dataclass(frozen=True)
class ScoredSum:
    """A sum with or without a map, one regularisation, and its score: its error on what is left out, rms, scaled."""

    sum: Sum
    mapped: bool
    regularisation: RampRegularisation
    score: float


@dataclass(frozen=True)
class Chosen:
    """The model of the best of some sums, and what proves it.

    Attributes
    ----------
    model
        Fitted to the whole training.
    candidates
        All that were compared, the best first.
    kkt
        Violation of the optimality conditions of its weights, relative.
    carrying, columns
        Number of weights that are not 0, and of those that were offered.
    terms
        The sum that the model was made of.
    """

    model: ElementModel
    candidates: tuple[ScoredSum, ...]
    kkt: float
    carrying: int
    columns: int
    terms: Terms

    def later(self, time: float) -> Chosen:
        """The same for an output that comes later. [s]"""
        return replace(self, model=replace(self.model, dead_time=time))


@dataclass(frozen=True, eq=False)
class Terms:
    """The sum that a model was made of before terms were taken out, and the training that it was fitted to.

    Attributes
    ----------
    training, direction, start
        Of the workshop.
    columns, weights, least
        All columns of the sum, their weights, and their lower bounds.
    regularisation
        Of the fit.
    """

    training: Training
    direction: str
    start: str
    columns: Columns
    weights: Weights
    least: Array
    regularisation: RampRegularisation

    def form(self, model: ElementModel) -> LinearForm:
        """Return the linear form of the sum; its models have the card and the dead time of `model`."""
        bank = row_bank(self.training, self.direction, self.columns, self.start)
        sums = bank.values @ self.weights.weight
        outputs = self.weights.outputs(sums)
        map_rows, gain, slopes = self.weights.map_rows(outputs)
        rows = np.hstack([np.ones((outputs.size, 1)), bank.values, -map_rows]) / gain[:, None]
        unknowns = np.concatenate([[self.weights.offset], self.weights.weight, slopes])
        lower = np.concatenate([[0.0], self.least, np.full(slopes.size, LEAST_OF_MAP)])
        penalty = penalty_of(
            self.regularisation, self.columns.neighbours, self.least.size, self.weights.outer
        )

        def with_unknowns(v: Array) -> ElementModel:
            size = 1 + self.least.size
            inner = self.weights.inner
            if inner.size:
                rises = v[size:] * np.diff(self.weights.outer)
                inner = inner[0] + np.concatenate([[0.0], np.cumsum(rises)])
            return replace(
                model,
                elements=self.columns.elements(v[1:size]),
                offset=float(v[0]),
                after_map=(tuple(inner.tolist()), tuple(self.weights.outer.tolist())),
            )

        scaling = self.training.scaling
        inputs = predicted = None
        if self.direction == "forward":
            inputs = scaling.center + scaling.half_range * bank.argument
            predicted = scaling.outward(outputs)
        return LinearForm(
            rows=rows,
            miss=bank.target - outputs,
            unknowns=unknowns,
            lower=lower,
            penalty=penalty,
            inputs=inputs,
            outputs=predicted,
            unit=np.full(outputs.size, abs(scaling.amplitude)),
            estimate=model,
            model=with_unknowns,
        )


class Made(NamedTuple):
    """A model, the sum that it was made of, and the violation of its optimality conditions.

    `carrying` weights are not 0; `apart` is what taking the others out changed of the output, rms, scaled.
    """

    model: ElementModel
    terms: Terms
    kkt: float
    carrying: int
    apart: float


def best_sum(
    training: Training, sums: Sequence[Sum], firm: bool = True, most: int | None = None
) -> Chosen:
    """Return the best of some sums; `firm` ones have an inverse whose gain is not high, where that costs little.

    Of `most` so many numbers: weights, points of maps, and the offset.

    Raises
    ------
    IdentificationError
        If there are too few samples, no candidate could be fitted, or none has so few numbers.
    """
    if training.y.size < FEWEST:
        raise IdentificationError(
            f"{training.y.size} samples are fitted, and sums of elements are chosen on {BLOCKS} parts of them: give "
            f"{FEWEST} or more, or take a smaller family, such as pi."
        )
    workshops = _workshops(training, sums)
    candidates = []
    for row in sums:
        for mapped in row.maps:
            candidates.append(workshops[row.direction].candidate(row, mapped, FIRST))
    # The order is stable, so that earlier rows win where scores are equal.
    candidates.sort(key=_demerit)
    for finalist in candidates[:FINALISTS]:
        workshop = workshops[finalist.sum.direction]
        for regularisation in OTHERS:
            candidates.append(workshop.candidate(finalist.sum, finalist.mapped, regularisation))
    ordered = sorted(candidates, key=_demerit)
    if not np.isfinite(ordered[0].score):
        raise IdentificationError(
            "no sum of elements could be fitted; take a smaller family, such as pi."
        )
    best, made = _fitted(ordered, workshops, firm, most)
    for workshop in workshops.values():
        workshop.let_go()
    of_its_name = [row for row in sums if row.name == best.sum.name]
    if len(of_its_name) < len(sums):
        # Fitted once more by its name, so that the person who names this row gets the same model.
        alone = best_sum(training, of_its_name, firm, most)
        others = [candidate for candidate in ordered if candidate.sum.name != best.sum.name]
        return replace(alone, candidates=(*alone.candidates, *others))
    ordered.sort(key=lambda candidate: candidate is not best)
    offered = workshops[best.sum.direction].columns.of(best.sum.groups).size
    return Chosen(made.model, tuple(ordered), made.kkt, made.carrying, offered, made.terms)


def row_again(chosen: Chosen, training: Training, firm: bool, most: int | None = None) -> Chosen:
    """Return the row that was chosen, fitted to another training."""
    return best_sum(training, [chosen.candidates[0].sum], firm, most)


def _workshops(training: Training, sums: Sequence[Sum]) -> dict[str, Workshop]:
    """One workshop a direction, each with the columns of all its sums."""
    groups: dict[str, dict[str, None]] = {}
    for row in sums:
        groups.setdefault(row.direction, {}).update(dict.fromkeys(row.groups))
    workshops = {}
    for direction, names in groups.items():
        workshops[direction] = workshop_of(training, direction, tuple(names))
    return workshops


def _demerit(candidate: ScoredSum) -> float:
    return rank(candidate.score / candidate.sum.worth)


def _fitted(
    ordered: Sequence[ScoredSum], workshops: dict[str, Workshop], firm: bool, most: int | None
) -> tuple[ScoredSum, Made]:
    """The smallest model of the best candidates, fitted to everything; of firm ones one that has an inverse, if any."""
    if most is not None:
        return _within(ordered, workshops, firm, most)
    limit = POLICY.smaller_model * _demerit(ordered[0])
    fitted = []
    for candidate in _finalists(ordered, limit, MADE_SMALL):
        fitted.append((candidate, workshops[candidate.sum.direction].model(candidate, firm)))
    # The order is stable: of equal sizes the one that errs less wins.
    fitted.sort(key=lambda row: row[1].model.free_parameters)
    for row in fitted:
        if not (firm and row[1].model.no_inverse):
            return row
    tried = [row[0] for row in fitted]
    for candidate in ordered:
        if candidate in tried or not np.isfinite(candidate.score):
            continue
        made = workshops[candidate.sum.direction].model(candidate, firm)
        if not made.model.no_inverse:
            return candidate, made
    return fitted[0]


def _within(
    ordered: Sequence[ScoredSum], workshops: dict[str, Workshop], firm: bool, most: int
) -> tuple[ScoredSum, Made]:
    """The model of at most so many numbers that errs least: by its score, and by what it was changed to be so small."""
    best, least, fewest = None, float("inf"), 0
    for candidate in _finalists(ordered, float("inf"), MADE_TO_FIT):
        made = workshops[candidate.sum.direction].model(candidate, firm, most)
        size = made.model.free_parameters
        fewest = min(fewest or size, size)
        error = float(np.hypot(candidate.score, made.apart)) / candidate.sum.worth
        if size <= most and error < least and not (firm and made.model.no_inverse):
            best, least = (candidate, made), error
    if best is None:
        raise IdentificationError(
            f"no model of at most {most} numbers was found (--size {most}); the smallest has {fewest}. Allow more.",
            size=most,
            smallest=fewest,
        )
    return best


def _finalists(ordered: Sequence[ScoredSum], limit: float, most: int) -> list[ScoredSum]:
    """The best candidates within a limit, each sum with one regularisation only."""
    finalists: dict[tuple[Sum, bool], ScoredSum] = {}
    for candidate in ordered:
        within = np.isfinite(candidate.score) and _demerit(candidate) <= limit
        if within and len(finalists) < most:
            finalists.setdefault((candidate.sum, candidate.mapped), candidate)
    return list(finalists.values())


def workshop_of(training: Training, direction: str, groups: tuple[str, ...]) -> Workshop:
    """Return the workshop of this training that has the columns, or make it, from the start state of its direction."""
    same_direction: list[Workshop] = [
        shop for shop in training.shared if shop.direction == direction
    ]
    for shop in same_direction:
        if shop.groups.issuperset(groups):
            return shop
    thin = training.shared[0].training if training.shared else training.thinned(MOST_SAMPLES)
    start = ""
    if same_direction:
        # The new one takes over all earlier groups, so that rows that are asked one by one share their columns.
        all_groups = same_direction[-1].groups.union(groups)
        groups = tuple(name for name in GROUPS if name in all_groups)
        start = same_direction[0].start
    shop = Workshop(thin, direction, groups, start)
    training.shared.append(shop)
    return shop


@dataclass(frozen=True, eq=False)
class RowBank:
    """Rows of the program, spread over the training.

    Attributes
    ----------
    values
        Columns, (K, p).
    argument, target, output
        What the elements see, what the sum is to be, and the output of the log, (K,); forward the last two are one.
    folds
        Of each row, spread and in one piece, (K,) each.
    weight
        How much each row counts, (K,).
    places
        Stretch and sample of each row, (K, 2).
    """

    values: Array
    argument: Array
    target: Array
    output: Array
    folds: tuple[Numbers, Numbers]
    weight: Array
    places: Numbers


class Workshop:
    """Columns and sums of one direction, and what they predict."""

    def __init__(
        self, training: Training, direction: str, groups: Sequence[str], start: str = ""
    ) -> None:
        self.training, self.direction, self.groups = training, direction, frozenset(groups)
        self.pace = pace_of(training, direction)
        self.start = start or self._best_start()
        self.columns = columns_of(groups, RAMPS[direction], self.pace, len(training.schedules))
        self.bank = self._bank(self.columns, self.start)
        self.sums = self._sums(self.columns, self.bank, OF_MAP[direction])
        self.later_sums = self._sums(self.columns, self.bank, OF_MAP[direction], self.bank.folds[1])
        self._programs: dict[tuple[tuple[str, ...], bool], tuple[Program, Marks | None]] = {}
        self._scores: dict[tuple[tuple[str, ...], bool, RampRegularisation], float] = {}
        self._models: dict[tuple[ScoredSum, bool, int | None], Made] = {}
        self._whole: tuple[tuple[str, ...], Columns, RowBank] | None = None

    def candidate(self, row: Sum, mapped: bool, regularisation: RampRegularisation) -> ScoredSum:
        """Score a sum, once; the score is infinite if the sum has no solution."""
        key = (row.groups, mapped, regularisation)
        if key not in self._scores:
            self._scores[key] = self._scored(*key)
        return ScoredSum(row, mapped, regularisation, self._scores[key])

    def _scored(
        self, groups: tuple[str, ...], mapped: bool, regularisation: RampRegularisation
    ) -> float:
        columns = self.columns.of(groups)
        spread, warm = self._program(groups, mapped)
        errors: list[float] = []
        try:
            whole, *fitted = spread.solve_each((EVERY, *WITHOUT), regularisation, warm)
            # The next regularisation of this sum begins with the weights that carry here.
            self._programs[groups, mapped] = (spread, whole.passive)
            errors += self._left_out(columns, fitted, self.bank.folds[0])
            in_one_piece = Program(self.later_sums, columns, mapped)
            fitted = in_one_piece.solve_each(WITHOUT, regularisation, whole.passive)
            errors += self._left_out(columns, fitted, self.bank.folds[1])
        except DehystError:
            return float("inf")
        return data_kit.score_of(np.array(errors))

    def _left_out(
        self, columns: Numbers, fitted: Sequence[Weights], fold: Numbers
    ) -> Iterator[float]:
        """Yield the error on each fold of the weights that were fitted without it; not a number where it has no row."""
        all_weights = np.zeros((self.columns.cell.size, len(fitted)))
        for number, weights in enumerate(fitted):
            all_weights[columns, number] = weights.weight
        sums = None
        if self.direction == "forward":
            # Few columns carry weight. One product for all folds reads these once.
            carrying = np.flatnonzero(all_weights.any(axis=1))
            sums = all_weights[carrying].T @ self._by_column[carrying]
        for number, weights in enumerate(fitted):
            rows = np.flatnonzero(fold == number)
            if not rows.size:
                yield float("nan")
            elif sums is not None:
                yield self._rms(weights.outputs(sums[number, rows]), rows)
            else:
                elements = self.columns.elements(all_weights[:, number])
                inverse = ElementModel(
                    elements,
                    weights.offset,
                    schedules=self.training.schedules,
                    signals=self.training.signals,
                    start=self.start,
                )
                yield self._rms(self._solved(inverse, rows), rows)

    @cached_property
    def _by_column(self) -> Array:
        """Columns of the rows one after the other, (p, K): few of them are read."""
        return np.ascontiguousarray(self.bank.values.T)

    def _program(self, groups: tuple[str, ...], mapped: bool) -> tuple[Program, Marks | None]:
        """Return the program of a sum, and if it was solved before, the unknowns to start from."""
        solved_before = self._programs.get((groups, mapped))
        return solved_before or (Program(self.sums, self.columns.of(groups), mapped), None)

    def missed(self, chosen: ScoredSum) -> Array:
        """Return the error of a sum at every row, fitted to all rows; for an inverse sum the error of the input."""
        columns = self.columns.of(chosen.sum.groups)
        program, warm = self._program(chosen.sum.groups, chosen.mapped)
        weights = program.solve(EVERY, chosen.regularisation, warm)
        return weights.outputs(self.bank.values[:, columns] @ weights.weight) - self.bank.target

    def model(self, chosen: ScoredSum, firm: bool, most: int | None = None) -> Made:
        """Fit a candidate to all rows, and take out of it what it does not need, or what is too many; once."""
        key = (chosen, firm, most)
        if key not in self._models:
            columns, weights, least = self._fitted(chosen, firm)
            smaller, apart = self._reduced(chosen, columns, weights, least, most)
            model = self._record(columns, smaller, chosen.sum.name)
            terms = Terms(
                self.training,
                self.direction,
                self.start,
                columns,
                weights,
                least,
                chosen.regularisation,
            )
            carrying = int(np.count_nonzero(smaller.weight))
            self._models[key] = Made(model, terms, smaller.kkt, carrying, apart)
        return self._models[key]

    def _fitted(self, chosen: ScoredSum, firm: bool) -> tuple[Columns, Weights, Array]:
        """Return columns, weights and lower bounds of a candidate that is fitted to all rows."""
        columns, bank = self._whole_of(chosen.sum.groups)
        sums = self._sums(columns, bank, PIECES if chosen.mapped else 1, _undivided(bank))
        program = Program(sums, np.arange(columns.cell.size), chosen.mapped)
        # Each fit begins with the weights that carried in the one before.
        _, warm = self._program(chosen.sum.groups, chosen.mapped)
        weights = program.solve(EVERY, chosen.regularisation, warm)
        least = sums.least
        if not firm or self.direction == "inverse":
            return columns, weights, least
        bound = LEAST
        allowed = POLICY.affordable_gain**2 * _squares(weights, bank)
        # A larger slope after a reversal changes the map, too, so the bound is raised step by step.
        for _ in range(TRIES):
            model = self._record(columns, weights, chosen.sum.name)
            scale = abs(model.scaling.amplitude / model.scaling.half_range)
            steep = model.inverse_gain * scale / models_kit.POLICY.high_gain
            if steep <= 1.0:
                break
            bound *= min(FIRMER * steep, FIRMEST)
            firmer_least = np.where(sums.least > 0.0, bound, 0.0)
            firmer_program = program.with_least(firmer_least)
            firmer = firmer_program.solve(EVERY, chosen.regularisation, weights.passive)
            if _squares(firmer, bank) > allowed:
                break
            weights, least = firmer, firmer_least
        return columns, weights, least

    def _whole_of(self, groups: tuple[str, ...]) -> tuple[Columns, RowBank]:
        """Return the columns of some groups at all rows: the last ones again, if they are of the same groups."""
        if self._whole is None or self._whole[0] != groups:
            self._whole = None  # before the next ones need as much memory
            columns = self.columns.take(self.columns.of(groups))
            self._whole = groups, columns, self._bank(columns, self.start, whole=True)
        return self._whole[1:]

    def let_go(self) -> None:
        """Drop what only fits to all rows need; it is large."""
        self._whole = None

    def _reduced(
        self,
        chosen: ScoredSum,
        columns: Columns,
        weights: Weights,
        least: Array,
        most: int | None,
    ) -> tuple[Weights, float]:
        """Return the weights of a sum that has fewer terms and is next to the full one, also on other motions."""
        signal, dt = self._probe
        schedules = len(self.training.schedules)
        ends = [0.0]
        if schedules:
            # A sum is linear in its schedules, so that their ends are enough.
            ends = [0.0, 1.0]
        motions = list(product((1.0, -1.0), ends))
        every = -(-2 * signal.size // PROBED_ROWS)
        probed = np.arange(0, signal.size, every)
        template = seen_by(self.training, self.direction, columns, self.start)
        seen, probes = self.bank.target.size, len(motions) * probed.size
        rows = np.empty((seen + probes, columns.cell.size))
        rows[:seen] = self.bank.values[:, self.columns.of(chosen.sum.groups)]
        begin = seen
        for sign, end in motions:
            of_motion = rows[begin : begin + probed.size]
            xi = np.full((signal.size, schedules), end)
            _fill_rows(of_motion, columns, template, sign * signal, dt, probed, xi)
            begin += probed.size
        of_log = np.arange(len(rows)) < seen
        balance = np.full(probes, float(self.bank.weight.sum()) / max(probes, 1))
        teacher = Teacher(
            rows=rows,
            weight=np.concatenate([self.bank.weight, balance]),
            sets=(of_log, ~of_log),
            offset=weights.offset,
            weights=weights.weight,
            least=least,
            outputs=lambda sums: weights.outputs(sums - weights.offset),
        )

        def too_large(weight: Array) -> bool:
            record = self._record(columns, replace(weights, weight=weight), chosen.sum.name)
            return most is not None and record.free_parameters > most

        smaller = reduced(teacher, POLICY.reduction * chosen.score, too_large if most else None)
        kkt = max(weights.kkt, smaller.kkt)
        weights = replace(weights, offset=smaller.offset, weight=smaller.weights, kkt=kkt)
        return weights, smaller.apart

    @cached_property
    def _probe(self) -> tuple[Array, Array | None]:
        """Probing motion of what the elements see."""
        stretches = self.training.stretches
        if self.direction == "inverse":
            stretches = tuple(stretch.turned for stretch in stretches)
        return probing(stretches)

    def _record(self, columns: Columns, weights: Weights, row: str) -> ElementModel:
        return ElementModel(
            columns.elements(weights.weight),
            weights.offset,
            before_map=_before(self.training, self.direction),
            after_map=(tuple(weights.inner.tolist()), tuple(weights.outer.tolist())),
            direction=self.direction,
            period=self.training.period,
            schedules=self.training.schedules,
            signals=self.training.signals,
            row=row,
            scaling=self.training.scaling,
            start=self.start,
        )

    def _rms(self, predicted: Array, rows: Numbers) -> float:
        """Return the error of predicted outputs at some rows, scaled."""
        # A prediction far outside counts as if it were at the limit: one wild sample must not decide.
        miss = np.clip(predicted, -FARTHEST, FARTHEST) - self.bank.output[rows]
        return float(np.sqrt(np.average(miss**2, weights=self.bank.weight[rows])))

    def _solved(self, model: ElementModel, rows: Numbers) -> Array:
        """Return the outputs that solve a sum of outputs, at some rows."""
        places = self.bank.places[rows]
        solved = []
        for number in np.unique(places[:, 0]):
            stretch = self.training.stretches[number]
            at = places[places[:, 0] == number, 1]
            # The solution runs from the beginning of the stretch, so that its memory is its own. Such a sum is one
            # of outputs, so input and output change places.
            turned = stretch.turned
            y = turned.run_inverse(model, float(stretch.y[0]), int(at[-1]) + 1)
            solved.append(y[at])
        return np.concatenate(solved)

    def _best_start(self) -> str:
        """The start state from which plays and stops err least; the first one, unless another is better by 2 %."""
        schedules = len(self.training.schedules)
        columns = columns_of(("play", "stop"), RAMPS[self.direction], None, schedules)
        every_column = np.arange(columns.cell.size)
        least, best = np.inf, ""
        for start in STARTS[self.direction]:
            bank = self._bank(columns, start)
            sums = self._sums(columns, bank, 1, _undivided(bank))
            program = Program(sums, every_column, False)
            weights = program.solve(EVERY, FIRST)
            miss = weights.outputs(bank.values @ weights.weight) - bank.target
            error = float(np.sqrt(np.average(miss**2, weights=bank.weight)))
            if rank(error) < POLICY.better_start * least:
                least, best = error, start
        return best

    def _sums(
        self, columns: Columns, bank: RowBank, pieces: int, fold: Numbers | None = None
    ) -> Sums:
        if fold is None:
            fold = bank.folds[0]
        least = np.where(columns.group == "x", LEAST, 0.0)
        return block_sums(
            bank.values, bank.target, fold, least, columns.neighbours, pieces, bank.weight
        )

    @cached_property
    def _chosen_rows(self) -> tuple[data_kit.SpreadRows, ...]:
        """Rows of the choice, of each stretch."""
        stretches = self.training.stretches
        signals = [stretch.x for stretch in stretches]
        return data_kit.spread_rows(signals, [stretch.counts for stretch in stretches], MOST_ROWS)

    def _bank(self, columns: Columns, start: str, whole: bool = False) -> RowBank:
        """Return rows of columns: those of the choice, or of the `whole` training."""
        rows = None if whole else self._chosen_rows
        return row_bank(self.training, self.direction, columns, start, rows)


def seen_by(training: Training, direction: str, columns: Columns, start: str) -> ElementModel:
    """Return the memory cells of columns, with what stands in front of them."""
    return ElementModel(
        columns.cells,
        before_map=_before(training, direction),
        start=start,
        scaling=seen_scaling(training, direction),
    )


def _before(training: Training, direction: str) -> Pairs:
    """Map in front of a sum: of the input, which an inverse sum does not see."""
    return training.before_map if direction == "forward" else NO_MAP


def seen_scaling(training: Training, direction: str) -> Scaling:
    """Return the scaling of what the elements see."""
    if direction == "forward":
        return training.scaling
    return training.scaling.swapped()


def row_bank(
    training: Training,
    direction: str,
    columns: Columns,
    start: str,
    compared: Sequence[data_kit.SpreadRows] | None = None,
) -> RowBank:
    """Return rows of columns, of each stretch those that are compared; None: every one that counts."""
    if compared is None:
        every = [np.flatnonzero(stretch.counts) for stretch in training.stretches]
        compared = [data_kit.SpreadRows(rows, np.ones(rows.size)) for rows in every]
    template = seen_by(training, direction, columns, start)
    seen, target, output, places = [], [], [], []
    values = np.empty((sum(part.rows.size for part in compared), columns.cell.size))
    filled = 0
    for number, stretch in enumerate(training.stretches):
        rows = compared[number].rows
        seen_as = stretch.turned if direction == "inverse" else stretch
        argument, sum_values = seen_as.x, seen_as.y
        of_stretch = values[filled : filled + rows.size]
        xi = training.xi(stretch)
        _fill_rows(of_stretch, columns, template, argument, stretch.dt, rows, xi, seen_as)
        filled += rows.size
        seen.append(argument[rows])
        target.append(sum_values[rows])
        output.append(stretch.y[rows])
        places.append(np.stack([np.full(rows.size, number), rows], axis=1))
    way = np.concatenate([spread.weight for spread in compared])
    weight = way * np.repeat(
        [stretch.weight for stretch in training.stretches], [part.rows.size for part in compared]
    )
    return RowBank(
        values=values,
        argument=np.concatenate(seen),
        target=np.concatenate(target),
        output=np.concatenate(output),
        folds=data_kit.folds_of(way),
        weight=weight,
        places=np.concatenate(places),
    )


def _undivided(bank: RowBank) -> Numbers:
    """Folds of rows of which none is left out of a fit, (K,)."""
    return np.zeros(bank.target.size, dtype=np.int64)


def _squares(weights: Weights, bank: RowBank) -> float:
    return float(np.sum((weights.outputs(bank.values @ weights.weight) - bank.output) ** 2))


def _fill_rows(
    values: Array,
    columns: Columns,
    template: ElementModel,
    signal: Array,
    dt: Array | None,
    rows: Numbers,
    xi: Array,
    led: Stretch | None = None,
) -> None:
    """Fill in the columns (K, p) at some samples of a signal; the elements run over all samples up to the last row.

    The memory before the first one is that of the stretch by which the signal is `led`, else the start of the template.
    """
    first_value = float(signal[0])
    memory = template.before(first_value) if led is None else led.memory(template, first_value)
    size = int(rows[-1]) + 1 if rows.size else 0
    # Signals run in chunks: all elements at all samples would not fit into memory.
    for begin in range(0, size, CHUNK):
        end = min(begin + CHUNK, size)
        steps = None
        if template.rate_dependent and dt is not None:
            steps = dt[begin:end]
        e, memory = template.columns(signal[begin:end], steps, memory)
        first, last = np.searchsorted(rows, [begin, end])
        chosen = rows[first:last]
        if chosen.size < len(e):
            e = e[chosen - begin]
        columns.values(e, xi[chosen], values[first:last])


def pace_of(training: Training, direction: str) -> Pace | None:
    """Return period, duration and speeds of a training; None without time stamps."""
    if not training.timed:
        return None
    steps = np.concatenate(
        [stretch.dt[1:] for stretch in training.stretches if stretch.dt is not None]
    )
    if not steps.size:
        return None
    period = float(np.median(steps))
    duration = max(float(stretch.time[-1]) for stretch in training.stretches)
    lags = ElementModel(
        tuple(Element("relax", 0.0, samples * period) for samples in RATE_LAGS),
        before_map=_before(training, direction),
    )
    moved = []
    for stretch in training.stretches:
        signal = stretch.x
        if direction == "inverse":
            signal = stretch.y
        e, _ = lags.columns(signal, stretch.dt, lags.before(float(signal[0])))
        moved.append(np.abs(e))
    usual = np.quantile(np.concatenate(moved), USUAL, axis=0)
    return Pace(period, duration, tuple(np.maximum(usual, SMALLEST).tolist()))
