"""From recordings to a fitted, certified model of plays: the flow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from dehyst.arrays import Array
from dehyst.data.recording import Recording
from dehyst.errors import ExcitationError
from dehyst.identification import facts
from dehyst.identification.certify import Seen, certify, seen_in
from dehyst.identification.data import DataSet, prepare
from dehyst.identification.families import STATIC, Estimate, fit_family
from dehyst.identification.fit import Candidate, Fit
from dehyst.identification.folds import output_knots
from dehyst.identification.measures import InMemory, Measure
from dehyst.identification.polish import polish
from dehyst.identification.refine import refine
from dehyst.identification.refit import Refitter
from dehyst.identification.regressors import Bank, fitted_samples, make_bank
from dehyst.identification.selection import (
    BY_ORIENTATION,
    REGULARISATIONS,
    STARTS,
    Choice,
    choose,
    choose_operators,
    compare,
    firmness,
    possible_choices,
    start_of_paper,
    threshold_grid,
)
from dehyst.identification.settings import (
    PAPER_OPERATORS,
    eps_of_call,
    paper_eps,
)
from dehyst.identification.split import Split, split_recordings
from dehyst.identification.static_curve import NO_MEMORY, fit_static
from dehyst.identification.sums import sums_of
from dehyst.identification.threads import single_blas

DIRECT = "direct-inverse"


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
    grid = threshold_grid(data, problem.operators, choice, problem.given)
    bank = make_bank(data, grid, choice.initial_state)
    knots = output_knots() if choice.family == "modified-pi" else None
    problem.entering("summing")
    sums = sums_of(data, bank, knots)
    if refitter is not None:
        refitter.keep(bank, sums, knots is not None)
    estimate = fit_family(
        choice.family, sums, problem.eps, knots, choice.regularisation, triangle=lambda: _triangle(data, bank, knots)
    )
    problem.entering("refining")
    if knots is None or choice.regularisation is None:
        return bank, refine(data, bank, sums, problem.eps, estimate)
    return bank, polish(sums, problem.eps, knots, choice.regularisation, estimate)


def _triangle(data: DataSet, bank: Bank, knots: Array | None) -> Array:
    from dehyst.identification.orthogonal import reduce  # only where normal equations will not do

    return reduce(data, bank, knots)
