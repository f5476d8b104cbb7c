"""Identification of play operators: from recordings to a fitted, checked model, and fast refits."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data.recording import Recording
from dehyst.errors import ExcitationError
from dehyst.identification import facts
from dehyst.identification.certify import Seen, certify, seen_in
from dehyst.identification.data import DataSet, prepare
from dehyst.identification.families import STATIC, Estimate, build_model, fit_family, reduce
from dehyst.identification.fit import Candidate, Fit, Refit
from dehyst.identification.refine import polish, refine
from dehyst.identification.regressors import Bank, NormalEquations, fitted_samples, make_bank, settled, sums_of
from dehyst.identification.scores import InMemory, Measure, parts, score, simulated
from dehyst.identification.selection import (
    BY_ORIENTATION,
    REGULARISATIONS,
    STARTS,
    Choice,
    choose,
    choose_operators,
    compare,
    firmness,
    output_knots,
    possible_choices,
    start_of_paper,
    threshold_grid,
)
from dehyst.identification.settings import PAPER_OPERATORS, check_settings, eps_of_call, paper_eps
from dehyst.identification.split import Split, split_recordings
from dehyst.identification.static_curve import NO_MEMORY, fit_static
from dehyst.identification.threads import single_blas
from dehyst.models import ModelCard

DIRECT = "direct-inverse"
KEPT_OPERATORS = 2000  # sums of more operators are made anew: they take more memory than a long log
KEPT_SUMS = 8
SAME = 1e-12  # thresholds this close, as a share of the half range, are the same


@dataclass
class Refitter:
    """The data of a fit, scaled, and sums over them."""

    # records, data, choice: What was fitted, and the settings that won
    records: tuple[Recording, ...]
    data: DataSet
    choice: Choice
    # operators, eps, given: Settings of the fit: n, eps relative to the ratio of the ranges, thresholds or None.
    # [input]
    operators: int
    eps: float
    given: Array | None
    _kept: list[tuple[Bank, bool, NormalEquations]] = field(default_factory=list)
    _done: dict[tuple[int | None, float | None, str | None] | None, Refit] = field(default_factory=dict)

    def keep(self, bank: Bank, sums: NormalEquations, ramps: bool) -> None:
        """Remember sums over the fitted samples, the last eight of them."""
        if bank.thresholds.size <= KEPT_OPERATORS:
            self._kept = [*self._kept[-KEPT_SUMS + 1 :], (bank, ramps, sums)]

    def __call__(self, n: int | None, eps: float | None, family: str | None, thresholds: npt.ArrayLike | None) -> Refit:
        """Fit once more with some settings changed; see `Fit.refit`."""
        begin = time.perf_counter()
        setting = (n, eps, family) if thresholds is None else None
        if setting in self._done:
            return self._done[setting]
        chosen = self.choice.family if family is None else family
        slope = self.data.amplitude / self.data.half_range if chosen == "pi" else 1.0
        asked = self.eps * slope if eps is None else eps
        given = check_settings(chosen, self.operators if n is None else n, asked, thresholds, self.choice.initial_state)
        if n is None and given is None:
            given = self.given
        operators = given.size if given is not None else int(self.operators if n is None else n)
        if eps is None:
            scaled = self.eps
        else:
            scaled = paper_eps(float(asked), self.records[0], self.data) if chosen == "pi" else float(asked)
        with single_blas():
            found = self._fit(chosen, operators, float(asked), scaled, given, begin)
        if setting is not None:
            self._done[setting] = found
        return found

    def _fit(self, family: str, operators: int, eps: float, scaled: float, given: Array | None, begin: float) -> Refit:
        data, start = self.data, self.choice.initial_state
        mapped = family == "modified-pi"
        choice = Choice(
            family,
            start,
            (self.choice.regularisation or REGULARISATIONS[-1]) if mapped else None,
            self.choice.power if family == self.choice.family else None,
        )
        bank, sums = self._sums(threshold_grid(data, operators, choice, given), mapped)
        estimate = _solved(data, bank, sums, choice, scaled)
        knots = output_knots() if mapped else None
        model = build_model(estimate, data, bank, knots, ModelCard())
        outputs = simulated(self.records, data, settled(data, bank, model), model)
        train, test = (
            score(self.records, outputs, part, data.output_range) for part in parts(self.records, data, start)
        )
        if train is None:
            raise AssertionError("no training samples")  # the fit has checked
        return Refit(
            family, operators, eps, model, train, test, model.inverse_gain, model.nonzero_weights,
            estimate.kkt_residual, estimate.condition, estimate.route, time.perf_counter() - begin,
        )  # fmt: skip

    def _sums(self, grid: Array, ramps: bool) -> tuple[Bank, NormalEquations]:
        """Sums of a grid: kept ones, those of a finer grid added up, or a pass over the data."""
        wanted = make_bank(self.data, grid, self.choice.initial_state)
        for bank, with_ramps, sums in reversed(self._kept):
            if ramps and not with_ramps:
                continue
            places = np.searchsorted(bank.thresholds, wanted.thresholds - SAME)
            if places[-1] >= bank.thresholds.size or np.unique(places).size < places.size:
                continue
            if np.max(np.abs(bank.thresholds[places] - wanted.thresholds)) > SAME:
                continue
            kept = np.zeros(bank.thresholds.size, dtype=np.bool_)
            kept[places] = True
            return wanted, sums if kept.all() else sums.coarser(kept)
        sums = sums_of(self.data, wanted, output_knots() if ramps else None)
        self.keep(wanted, sums, ramps)
        return wanted, sums


def _solved(data: DataSet, bank: Bank, sums: NormalEquations, choice: Choice, eps: float) -> Estimate:
    knots = output_knots() if choice.family == "modified-pi" else None
    estimate = fit_family(
        choice.family, sums, eps, knots, choice.regularisation, triangle=lambda: reduce(data, bank, knots)
    )
    if knots is None or choice.regularisation is None:
        return estimate
    return polish(sums, eps, knots, choice.regularisation, estimate)


@dataclass(frozen=True)
class _Problem:
    data: DataSet
    operators: int
    eps: float
    given: Array | None
    entering: Callable[[str], object]


def solve_in_memory(
    call: Call, records: tuple[Recording, ...], weights: tuple[Array, ...] | None, measure: Measure | None = None
) -> Fit:
    """Fit recordings that are in memory, with settings that were checked."""
    with single_blas():
        data = prepare(records, call.split, weights)
        return solve(call, records[0], data, facts.branches(data), measure or InMemory(records), records)


@dataclass(frozen=True, eq=False)
class Prepared:
    """Recordings split and scaled once, for all families that are identified from them with their usual settings."""

    records: tuple[Recording, ...]
    split: Split
    measure: InMemory

    @cached_property
    def data(self) -> DataSet:
        """Scaled."""
        return prepare(self.records, self.split)

    @cached_property
    def branches(self) -> tuple[facts.Branches, ...]:
        """Of the fitted part."""
        return facts.branches(self.data)

    @cached_property
    def seen(self) -> Seen:
        """What the fitted part shows."""
        return seen_in(self.branches)

    def call(self, family: str) -> Call:
        """Usual settings of a family."""
        return call_of(family, PAPER_OPERATORS, eps_of_call(family, None), None, "auto", self.split)

    def plays(self, family: str) -> Fit:
        """Fit a family of plays; each once."""
        if family not in self._fits:
            with single_blas():
                self._fits[family] = solve(
                    self.call(family), self.records[0], self.data, self.branches, self.measure, self.records
                )
        return self._fits[family]

    @cached_property
    def _fits(self) -> dict[str, Fit]:
        return {}


def prepared(records: tuple[Recording, ...], train_fraction: float | None) -> Prepared:
    """Return recordings that were checked, split."""
    return Prepared(records, split_recordings(records, train_fraction), InMemory(records))


def call_of(
    family: str,
    n: int | str,
    eps: tuple[float, bool],
    given: Array | None,
    initial_state: str,
    split: Split,
    weighted: bool = False,
) -> Call:
    """Settings of a call that were checked; "auto" for n stands for the paper's number until it is chosen.

    `eps` is what `eps_of_call` says.
    """
    operators = given.size if given is not None else PAPER_OPERATORS if isinstance(n, str) else int(n)
    return Call(family, operators, *eps, given, initial_state, split, isinstance(n, str), weighted)


@dataclass(frozen=True)
class Call:
    """Settings of an identification, checked: those of `identify`, the thresholds as an array or None for a grid.

    Where eps is chosen, `eps` is what the choice begins with.
    """

    family: str
    operators: int
    eps: float
    choose_eps: bool
    given: Array | None
    initial_state: str
    split: Split
    choose_operators: bool = False
    weighted: bool = False

    @property
    def settings(self) -> dict[str, Any]:
        """As plain values, for the fit."""
        return {
            "family": self.family,
            "n": self.operators,
            "eps": self.eps,
            "thresholds": "grid" if self.given is None else "given",
            "initial_state": self.initial_state,
            **self.split.settings,
            **({"weights": "given"} if self.weighted else {}),
        }


def solve(
    call: Call,
    first: Recording,
    data: DataSet,
    found: tuple[facts.Branches, ...],
    measure: Measure,
    records: tuple[Recording, ...] = (),
    entering: Callable[[str], object] = len,
) -> Fit:
    """Choose, fit and certify; the data may be in memory or not.

    Parameters
    ----------
    first
        Any of the recordings, for names and units.
    found
        Branches of the fitted part.
    records
        The recordings, if they are in memory and can be fitted again.
    entering
        Told which stage begins.
    """
    # The paper's program bounds w_1 itself; everywhere else eps is relative to the ratio of the ranges.
    slope = data.amplitude / data.half_range if call.family == "pi" else 1.0
    scaled = call.eps if call.choose_eps or call.family != "pi" else paper_eps(call.eps, first, data)
    problem = _Problem(data, call.operators, scaled, call.given, entering)
    entering("choosing")
    seen = seen_in(found)
    families = BY_ORIENTATION[seen.loop.name] if call.family == "auto" else (call.family,)
    starts = STARTS if call.initial_state == "auto" else (call.initial_state,)
    if call.family == "pi" and call.initial_state == "auto":
        starts = (start_of_paper(data, problem.operators, scaled, call.given),)
    choice, candidates = _choose(problem, families, starts)
    settings = call.settings
    if call.choose_operators and choice.family != STATIC:
        operators, choice = choose_operators(data, choice, scaled)
        problem = replace(problem, operators=operators)
        settings |= {"n": operators, "n_by": "cross-validation", "power": choice.power}
    firm = firmness(data, choice, problem.operators, scaled, call.given)
    if call.choose_eps:
        problem = replace(problem, eps=firm.affordable or scaled)
        firm = firm._replace(affordable=None)  # it is taken
        settings |= {"eps": problem.eps * slope, "eps_by": "error of the fit"}
    refitter = None
    if choice.family == STATIC:
        problem = replace(problem, operators=0)
        bank = make_bank(data, NO_MEMORY, choice.initial_state)
        estimate, _ = fit_static(data, choice.initial_state, problem.eps)
    else:
        refitter = Refitter(records, data, choice, problem.operators, problem.eps, call.given) if records else None
        bank, estimate = _fit(problem, choice, refitter)
    if choice.regularisation is not None:
        settings["smoothing"] = choice.regularisation.smoothing
        settings["ridge"] = choice.regularisation.ridge
    entering("comparing")
    return certify(
        data,
        problem.operators,
        choice,
        bank,
        estimate,
        firm.times(slope),
        candidates,
        seen,
        settings,
        measure,
        refitter,
    )


def _choose(problem: _Problem, families: Sequence[str], starts: Sequence[str]) -> tuple[Choice, tuple[Candidate, ...]]:
    choices = list(possible_choices(families, starts))
    if len(choices) == 1:
        return choices[0], ()
    results = compare(problem.data, choices, problem.operators, problem.eps, problem.given)
    if not results:  # too few samples to hold any out
        family = next(name for name in families if name != STATIC)
        return Choice(family, starts[0], REGULARISATIONS[-1] if family == "modified-pi" else None), ()
    return choose(results)


def _fit(problem: _Problem, choice: Choice, refitter: Refitter | None) -> tuple[Bank, Estimate]:
    data = problem.data
    levels = [piece for piece in data.pieces if piece.unknown_level(choice.initial_state) is None]
    usable = fitted_samples(replace(data, pieces=tuple(levels)), choice.initial_state)
    if usable < 4:
        raise ExcitationError(
            f"only {usable} training samples remain once the memory of the actuator is known: the input visits both "
            f"of its extremes too late, or after every gap not at all. Fit a larger part (--train-fraction), or assume "
            f"a start (--initial-state zero, rest, rising or falling).",
            samples=usable,
        )
    bank = make_bank(data, threshold_grid(data, problem.operators, choice, problem.given), choice.initial_state)
    mapped = choice.family == "modified-pi"
    problem.entering("summing")
    sums = sums_of(data, bank, output_knots() if mapped else None)
    if refitter is not None:
        refitter.keep(bank, sums, mapped)
    estimate = _solved(data, bank, sums, choice, problem.eps)
    problem.entering("refining")
    return bank, estimate if mapped else refine(data, bank, sums, problem.eps, estimate)
