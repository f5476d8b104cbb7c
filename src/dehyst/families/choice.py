r"""Chooses the terms, output map and regularisation of a sum of elements by held-out blocks of the training part.

The training is cut into five consecutive blocks. A candidate's score is a mean of errors of its output on blocks that
it did not see: m, the median of the rms of each block left out in turn, and f_4 and f_5, of the last two blocks, each
predicted from those before it alone::

    score = (m f_4 f_5 f_5)^(1/4)

m is a median since one block may hold what no other does, the largest loop as a rule, and would decide alone. Errors of
the fit itself are no part of it: they are smallest for the sums with the most weights, and say nothing about a motion
that was not logged (docs/decisions/0043). Errors of a sum in the inverse direction are those of its solution. The best
two of all rows, with and without a map, are tried with every regularisation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dehyst.arrays import rank
from dehyst.errors import DehystError, IdentificationError
from dehyst.families.base import Scaling
from dehyst.families.columns import GROUPS, RATE_LAGS, Columns, Pace, columns_of
from dehyst.families.elements import Element, ElementModel
from dehyst.families.program import (
    BLOCKS,
    LEAST,
    PIECES,
    Marks,
    Numbers,
    Program,
    Regularisation,
    Sums,
    Weights,
    sums_of,
)
from dehyst.families.table import Sum
from dehyst.families.training import Training
from dehyst.identification.families import HIGH_GAIN
from dehyst.models.arrays import Array

EVERY = tuple(range(BLOCKS))
LEFT = (*EVERY, BLOCKS - 2)  # blocks that a score predicts, and what is seen for it, after everything
SEEN = (EVERY, *(tuple(b for b in EVERY if b != block) for block in EVERY), EVERY[: BLOCKS - 2])
MOST_SAMPLES = 20_000  # of a training that elements see; longer ones are thinned, their turning points kept
MOST_ROWS = 4000  # of the choice, spread over the training; elements see every sample
FEWEST = 4 * BLOCKS
RAMPS = {"forward": 8, "inverse": 16}
OF_MAP = {"forward": PIECES, "inverse": 1}  # no inverse row has a map
FIRST = Regularisation(0.003, 0.001)
OTHERS = (Regularisation(0.0005, 0.0003), Regularisation(0.02, 0.003), Regularisation(0.1, 0.01))
FINALISTS = 2
AFFORDABLE = 1.03  # times the error of the fit, for an inverse whose gain is not high
FIRMER, FIRMEST = 1.001, 4.0  # a gain without bound is met in steps
TRIES = 10
STARTS = {  # the origin is that of the log's input
    "forward": ("zero", "rest", "rising", "falling", "origin"),
    "inverse": ("zero", "rest", "rising", "falling"),
}
BETTER_START = 0.98
FARTHEST = 1.6  # scaled outputs beyond it are not predicted: 0.3 of the range beyond what was seen
CHUNK = 4096
SMALLEST = 1e-9
USUAL = 0.95  # of the samples move less than what a rate is scaled with


@dataclass(frozen=True)
class Candidate:
    """A sum with or without a map, one regularisation, its score, and its error on blocks left out (rms, scaled)."""

    sum: Sum
    mapped: bool
    regularisation: Regularisation
    score: float
    left_out: float


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
    """

    model: ElementModel
    candidates: tuple[Candidate, ...]
    kkt: float
    carrying: int
    columns: int

    def later(self, time: float) -> Chosen:
        """The same for an output that comes later. [s]"""
        return replace(self, model=replace(self.model, dead_time=time))


def choose(training: Training, sums: Sequence[Sum], firm: bool = True) -> Chosen:
    """Return the best of some sums; `firm` ones have an inverse whose gain is not high, where that costs little.

    Raises
    ------
    IdentificationError
        If there are too few samples, or no candidate could be fitted.
    """
    if training.y.size < FEWEST:
        raise IdentificationError(
            f"{training.y.size} samples are fitted, and sums of elements are chosen on {BLOCKS} blocks of them: give "
            f"{FEWEST} or more, or take a smaller family, such as pi."
        )
    workshops: dict[str, Workshop] = {}
    for direction in dict.fromkeys(one.direction for one in sums):
        groups = dict.fromkeys(group for one in sums if one.direction == direction for group in one.groups)
        workshops[direction] = workshop_of(training, direction, tuple(groups))
    first = [workshops[one.direction].candidate(one, mapped, FIRST) for one in sums for mapped in one.maps]
    first.sort(key=_demerit)  # stable: earlier rows first
    more = [
        workshops[one.sum.direction].candidate(one.sum, one.mapped, regularisation)
        for one in first[:FINALISTS]
        for regularisation in OTHERS
    ]
    ordered = sorted((*first, *more), key=_demerit)
    if not np.isfinite(ordered[0].score):
        raise IdentificationError("no sum of elements could be fitted; take a smaller family, such as pi.")
    best, model, weights = _fitted(ordered, workshops, firm)
    ordered.sort(key=lambda candidate: candidate is not best)
    return Chosen(model, tuple(ordered), weights.kkt, int(np.count_nonzero(weights.weight)), weights.weight.size)


def score_of(left: Sequence[float], before_last: float) -> float:
    """What sums are ranked by, the lowest first: the module's formula.

    Parameters
    ----------
    left
        Errors of each block left out, rms, scaled.
    before_last
        Of the last block but one, predicted from those before it.

    Examples
    --------
    >>> round(score_of([0.03, 0.03, 0.5, 0.03, 0.03], 0.03), 9)  # one block that is missed does not decide
    0.03
    """
    parts = np.array([np.median(left), before_last, left[-1], left[-1]])
    return float(np.exp(np.mean(np.log(np.maximum(parts, SMALLEST)))))


def _demerit(candidate: Candidate) -> float:
    return rank(candidate.score / candidate.sum.worth)


def _fitted(
    ordered: Sequence[Candidate], workshops: dict[str, Workshop], firm: bool
) -> tuple[Candidate, ElementModel, Weights]:
    """The best candidate, fitted to everything; of firm ones the best that has an inverse, if any has."""
    best = None
    for one in (each for each in ordered if np.isfinite(each.score)):
        model, weights = workshops[one.sum.direction].model(one, firm)
        best = best or (one, model, weights)
        if not (firm and model.no_inverse):
            return one, model, weights
    assert best is not None  # the first score is finite
    return best


def workshop_of(training: Training, direction: str, groups: tuple[str, ...]) -> Workshop:
    """One that was made for this training and has the columns, or a new one from the start state of its direction."""
    made = [shop for shop in training.shared if shop.direction == direction]
    shop = next((shop for shop in made if shop.groups.issuperset(groups)), None)
    if shop is None:
        thin = training.shared[0].training if training.shared else training.thinned(MOST_SAMPLES)
        if made:  # with all that was asked so far, so that rows of the same groups asked one by one share columns
            asked = made[-1].groups.union(groups)
            groups = tuple(name for name in GROUPS if name in asked)
        shop = Workshop(thin, direction, groups, made[0].start if made else "")
        training.shared.append(shop)
    return shop


@dataclass(frozen=True, eq=False)
class Bank:
    """Rows of the program, spread over the training.

    Attributes
    ----------
    values
        Columns, (K, p).
    target, output
        What the sum is to be, and the output of the log; the same in the forward direction. (K,)
    block
        Of each row, (K,), consecutive.
    places
        Stretch and sample of each row, (K, 2).
    """

    values: Array
    target: Array
    output: Array
    block: Numbers
    places: Numbers

    def part(self, block: int) -> slice:
        """Rows of a block."""
        return slice(*np.searchsorted(self.block, [block, block + 1]).tolist())


class Workshop:
    """Columns and sums of one direction, and what they predict."""

    def __init__(self, training: Training, direction: str, groups: Sequence[str], start: str = "") -> None:
        self.training, self.direction, self.groups = training, direction, frozenset(groups)
        self.pace = pace_of(training, direction)
        self.start = start or self._best_start()
        self.columns = columns_of(groups, RAMPS[direction], self.pace)
        self.bank = self._bank(self.columns, self.start)
        self.sums = self._sums(self.columns, self.bank, OF_MAP[direction])
        self._programs: dict[tuple[tuple[str, ...], bool], tuple[Program, Marks | None]] = {}
        self._scores: dict[tuple[tuple[str, ...], bool, Regularisation], tuple[float, float]] = {}
        self._models: dict[tuple[Candidate, bool], tuple[ElementModel, Weights]] = {}
        self._last: tuple[tuple[tuple[str, ...], bool], Columns, Bank, Sums] | None = None

    def candidate(self, one: Sum, mapped: bool, regularisation: Regularisation) -> Candidate:
        """Score a sum, once; infinite where it has no solution."""
        key = (one.groups, mapped, regularisation)
        if key not in self._scores:
            self._scores[key] = self._scored(*key)
        return Candidate(one, mapped, regularisation, *self._scores[key])

    def _scored(self, groups: tuple[str, ...], mapped: bool, regularisation: Regularisation) -> tuple[float, float]:
        columns, key = self.columns.of(groups), (groups, mapped)
        program, warm = self._programs.get(key) or (Program(self.sums, columns, mapped), None)
        try:
            whole, *found = program.solve_each(SEEN, regularisation, warm)
            self._programs[key] = (program, whole.passive)
            errors = [self._rms(columns, *each) for each in zip(found, map(self.bank.part, LEFT), strict=True)]
        except DehystError:
            return float("inf"), float("inf")
        left_out = np.sqrt(np.mean(np.square(errors[:BLOCKS])))
        return score_of(errors[:BLOCKS], errors[BLOCKS]), float(left_out)

    def missed(self, chosen: Candidate) -> Array:
        """What a sum misses at every row, fitted to all of them; of an inverse one the input."""
        columns = self.columns.of(chosen.sum.groups)
        program, warm = self._programs.get((chosen.sum.groups, chosen.mapped)) or (
            Program(self.sums, columns, chosen.mapped),
            None,
        )
        found = program.solve(EVERY, chosen.regularisation, warm)
        return found.outputs(self.bank.values[:, columns] @ found.weight) - self.bank.target

    def model(self, chosen: Candidate, firm: bool) -> tuple[ElementModel, Weights]:
        """Fit a candidate to all rows, once."""
        if (chosen, firm) not in self._models:
            self._models[chosen, firm] = self._fitted(chosen, firm)
        return self._models[chosen, firm]

    def _fitted(self, chosen: Candidate, firm: bool) -> tuple[ElementModel, Weights]:
        columns, bank, sums = self._whole(chosen.sum.groups, chosen.mapped)
        own = np.arange(columns.cell.size)
        program = Program(sums, own, chosen.mapped)
        found = program.solve(EVERY, chosen.regularisation)
        model = self._record(columns, found, chosen.sum.name)
        if not firm or self.direction == "inverse":
            return model, found
        held, bound, allowed = model, LEAST, AFFORDABLE**2 * _squares(found, bank)
        for _ in range(TRIES):  # a firmer slope after a reversal changes the map, too
            steep = held.inverse_gain * abs(held.scaling.amplitude / held.scaling.half_range) / HIGH_GAIN
            if steep <= 1.0:
                return held, found
            bound *= min(FIRMER * steep, FIRMEST)
            firmer = program.with_least(np.where(sums.least > 0.0, bound, 0.0))
            weights = firmer.solve(EVERY, chosen.regularisation)
            if _squares(weights, bank) > allowed:
                break
            held, found = self._record(columns, weights, chosen.sum.name), weights
        return held, found

    def _whole(self, groups: tuple[str, ...], mapped: bool) -> tuple[Columns, Bank, Sums]:
        """Columns of a sum at all samples; of the sum before they are kept, as candidates differ in other things."""
        if self._last is None or self._last[0] != (groups, mapped):
            columns = columns_of(groups, RAMPS[self.direction], self.pace)
            same = self._last is not None and self._last[0][0] == groups
            bank = self._last[2] if same and self._last else self._bank(columns, self.start, every=1)
            self._last = (groups, mapped), columns, bank, self._sums(columns, bank, PIECES if mapped else 1)
        return self._last[1:]

    def _record(self, columns: Columns, found: Weights, row: str) -> ElementModel:
        return ElementModel(
            columns.elements(found.weight),
            found.offset,
            after_map=(tuple(found.inner.tolist()), tuple(found.outer.tolist())),
            direction=self.direction,
            period=self.training.period,
            row=row,
            scaling=self.training.scaling,
            start=self.start,
        )

    def _rms(self, columns: Numbers, found: Weights, rows: slice) -> float:
        """Error of the output at some rows, scaled."""
        weight = np.zeros(self.columns.cell.size)
        weight[columns] = found.weight
        if self.direction == "forward":
            predicted = found.outputs(self.bank.values[rows] @ weight)
        else:
            predicted = self._solved(ElementModel(self.columns.elements(weight), found.offset, start=self.start), rows)
        miss = np.clip(predicted, -FARTHEST, FARTHEST) - self.bank.output[rows]
        return float(np.sqrt(np.mean(miss**2)))

    def _solved(self, model: ElementModel, rows: slice) -> Array:
        """Outputs that solve a sum of outputs, at some rows."""
        places, solved = self.bank.places[rows], []
        for number in np.unique(places[:, 0]):
            stretch = self.training.stretches[number]
            at = places[places[:, 0] == number, 1]
            part = slice(0, int(at[-1]) + 1)  # from the beginning: memory is that of the solution
            dt = stretch.dt[part] if model.rate_dependent and stretch.dt is not None else None
            y, _ = model.run_inverse(stretch.x[part], dt, model.before(float(stretch.y[0])))
            solved.append(y[at])
        return np.concatenate(solved)

    def _best_start(self) -> str:
        """The start state from which plays and stops err least; the first one, unless another is better by 2 %."""
        columns, least, best = columns_of(("play", "stop"), RAMPS[self.direction], None), np.inf, ""
        for start in STARTS[self.direction]:
            bank = self._bank(columns, start)
            found = Program(self._sums(columns, bank, 1), np.arange(columns.cell.size), False).solve(EVERY, FIRST)
            error = float(np.sqrt(np.mean((found.outputs(bank.values @ found.weight) - bank.target) ** 2)))
            if rank(error) < BETTER_START * least:
                least, best = error, start
        return best

    def _sums(self, columns: Columns, bank: Bank, pieces: int) -> Sums:
        least = np.where(columns.group == "x", LEAST, 0.0)
        return sums_of(bank.values, bank.target, bank.block, least, columns.neighbours, pieces)

    def _bank(self, columns: Columns, start: str, every: int | None = None) -> Bank:
        """Rows of columns; `every` which sample has one, None for as many as a choice takes."""
        compared = [np.flatnonzero(stretch.counts) for stretch in self.training.stretches]
        every = every or -(-sum(at.size for at in compared) // MOST_ROWS)
        template = ElementModel(columns.cells, start=start, scaling=self._seen_scaling())
        values, target, output, places = [], [], [], []
        for number, (stretch, at) in enumerate(zip(self.training.stretches, compared, strict=True)):
            rows = at[::every]
            seen, wanted = (stretch.x, stretch.y) if self.direction == "forward" else (stretch.y, stretch.x)
            values.append(_rows(columns, template, seen, stretch.dt, rows))
            target.append(wanted[rows])
            output.append(stretch.y[rows])
            places.append(np.stack([np.full(rows.size, number), rows], axis=1))
        joined = np.concatenate(places)
        block = np.arange(len(joined)) * BLOCKS // max(1, len(joined))
        return Bank(np.concatenate(values), np.concatenate(target), np.concatenate(output), block, joined)

    def _seen_scaling(self) -> Scaling:
        scaling = self.training.scaling
        return scaling if self.direction == "forward" else scaling.swapped()


def _squares(found: Weights, bank: Bank) -> float:
    return float(np.sum((found.outputs(bank.values @ found.weight) - bank.output) ** 2))


def _rows(columns: Columns, template: ElementModel, seen: Array, dt: Array | None, rows: Numbers) -> Array:
    """Columns (K, p) at some samples of a signal; elements see all of them up to the last."""
    memory, parts = template.before(float(seen[0])), [np.zeros((0, columns.cell.size))]
    seen = seen[: rows[-1] + 1 if rows.size else 0]
    steps = dt if template.rate_dependent else None
    for begin in range(0, seen.size, CHUNK):
        part = slice(begin, begin + CHUNK)
        e, memory = template.columns(seen[part], None if steps is None else steps[: seen.size][part], memory)
        here = rows[slice(*np.searchsorted(rows, [begin, begin + CHUNK]))] - begin
        parts.append(columns.values(e if here.size == len(e) else e[here]))
    return np.concatenate(parts)


def pace_of(training: Training, direction: str) -> Pace | None:
    """Period, duration and speeds of a training; None without time stamps."""
    if not training.timed:
        return None
    steps = np.concatenate([stretch.dt[1:] for stretch in training.stretches if stretch.dt is not None])
    if not steps.size:
        return None
    period, duration = float(np.median(steps)), max(float(stretch.time[-1]) for stretch in training.stretches)
    lags = ElementModel(tuple(Element("relax", 0.0, samples * period) for samples in RATE_LAGS))
    moved = []
    for stretch in training.stretches:
        seen = stretch.x if direction == "forward" else stretch.y
        moved.append(np.abs(lags.columns(seen, stretch.dt, lags.before(float(seen[0])))[0]))
    usual = np.quantile(np.concatenate(moved), USUAL, axis=0)
    return Pace(period, duration, tuple(np.maximum(usual, SMALLEST).tolist()))
