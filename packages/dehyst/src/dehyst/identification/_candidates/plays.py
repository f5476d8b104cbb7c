"""Sums of plays or stops, and the curve without memory, as candidates: chosen, fitted, and fast refits."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.errors import ExcitationError
from dehyst.identification._candidate import BlockErrors, Outcome
from dehyst.identification._candidates.play_blocks import play_block_errors
from dehyst.identification._candidates.play_form import PlayForm
from dehyst.identification._cautions import Knows
from dehyst.identification._data import DataSet
from dehyst.identification._families import STATIC, Estimate, build_model, fit_family, reduce
from dehyst.identification._fit import Certificate, ComparedSetting, Refit
from dehyst.identification._prepared import Prepared
from dehyst.identification._refine import polish, refine
from dehyst.identification._regressors import (
    NormalEquations,
    PlayBank,
    fitted_samples,
    make_bank,
    normal_equations,
    settled_bank,
)
from dehyst.identification._scores import score, scored_parts, simulated
from dehyst.identification._selection import (
    BY_ORIENTATION,
    REGULARISATIONS,
    STARTS,
    Choice,
    best_choice,
    choose_operators,
    compare_choices,
    firmness,
    output_knots,
    possible_choices,
    start_of_paper,
    threshold_grid,
)
from dehyst.identification._settings import (
    PAPER_EPS,
    PAPER_OPERATORS,
    check_settings,
    eps_of_call,
    is_papers,
    paper_eps,
)
from dehyst.identification._static_curve import NO_MEMORY, curve_of, fit_static
from dehyst.identification._threads import single_blas
from dehyst.models import HysteresisModel, ModelCard

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
    # operators, eps, thresholds: Settings of the fit: n, eps relative to the ratio of the ranges, and thresholds or
    # None. [input]
    operators: int
    eps: float
    thresholds: Array | None
    _stored_sums: list[tuple[PlayBank, bool, NormalEquations]] = field(default_factory=list)
    _refits: dict[tuple[int | None, float | None, str | None] | None, Refit] = field(
        default_factory=dict
    )

    def keep(self, bank: PlayBank, sums: NormalEquations, ramps: bool) -> None:
        """Remember sums over the fitted samples, the last eight of them."""
        if bank.thresholds.size <= KEPT_OPERATORS:
            self._stored_sums = [*self._stored_sums[-KEPT_SUMS + 1 :], (bank, ramps, sums)]

    def __call__(
        self, n: int | None, eps: float | None, family: str | None, thresholds: npt.ArrayLike | None
    ) -> Refit:
        """Fit once more with some settings changed; see `Fit.refit`."""
        begin = time.perf_counter()
        setting = None
        if thresholds is None:
            setting = (n, eps, family)
        if setting in self._refits:
            return self._refits[setting]
        if family is None:
            family = self.choice.family
        operators_asked = self.operators
        if n is not None:
            operators_asked = n
        eps_asked = eps
        if eps_asked is None:
            eps_asked = self.eps * _slope(self.data, family)
        grid = check_settings(
            family, operators_asked, eps_asked, thresholds, self.choice.initial_state
        )
        if n is None and grid is None:
            grid = self.thresholds
        operators = int(operators_asked)
        if grid is not None:
            operators = grid.size
        if eps is None:
            scaled = self.eps
        elif family == "pi":
            scaled = paper_eps(float(eps), self.records[0], self.data)
        else:
            scaled = float(eps)
        with single_blas():
            refit = self._fit(family, operators, float(eps_asked), scaled, grid, begin)
        if setting is not None:
            self._refits[setting] = refit
        return refit

    def _fit(
        self,
        family: str,
        operators: int,
        eps: float,
        scaled: float,
        thresholds: Array | None,
        begin: float,
    ) -> Refit:
        data, start = self.data, self.choice.initial_state
        regularisation = None
        if family == "modified-pi":
            regularisation = self.choice.regularisation or REGULARISATIONS[-1]
        # The exponent of the grid was chosen for the family of the fit; another one has its own.
        power = None
        if family == self.choice.family:
            power = self.choice.power
        choice = Choice(family, start, regularisation, power)
        knots = _knots_of(family)
        bank, sums = self._sums(threshold_grid(data, operators, choice, thresholds), knots)
        estimate = _solved(data, bank, sums, choice, scaled)
        model = build_model(estimate, data, bank, knots, ModelCard())
        outputs = simulated(self.records, data, settled_bank(data, bank, model), model)
        fitted, held_out = scored_parts(self.records, data, start)
        train = score(self.records, outputs, fitted, data.output_range)
        test = score(self.records, outputs, held_out, data.output_range)
        if train is None:
            raise AssertionError("no training samples")  # the fit has checked
        return Refit(
            family, operators, eps, model, train, test, model.inverse_gain, model.nonzero_weights,
            estimate.kkt_residual, estimate.condition, estimate.route, time.perf_counter() - begin,
        )  # fmt: skip

    def _sums(self, grid: Array, knots: Array | None) -> tuple[PlayBank, NormalEquations]:
        """Sums of a grid: stored ones, those of a finer grid added up, or a pass over the data."""
        bank = make_bank(self.data, grid, self.choice.initial_state)
        for stored, with_ramps, sums in reversed(self._stored_sums):
            if knots is not None and not with_ramps:
                continue
            # A stored grid serves if each threshold asked for is one of its own.
            places = np.searchsorted(stored.thresholds, bank.thresholds - SAME)
            if places[-1] >= stored.thresholds.size or np.unique(places).size < places.size:
                continue
            if np.max(np.abs(stored.thresholds[places] - bank.thresholds)) > SAME:
                continue
            chosen = np.zeros(stored.thresholds.size, dtype=np.bool_)
            chosen[places] = True
            if not chosen.all():
                sums = sums.coarser(chosen)
            return bank, sums
        sums = normal_equations(self.data, bank, knots)
        self.keep(bank, sums, knots is not None)
        return bank, sums


def _slope(data: DataSet, family: str) -> float:
    """Unit of an eps of the call: the paper's program bounds w_1 itself, others a share of the mean slope."""
    if family == "pi":
        return data.amplitude / data.half_range
    return 1.0


def _knots_of(family: str) -> Array | None:
    """Knots of the output map; only one family has one."""
    if family == "modified-pi":
        return output_knots()
    return None


def _solved(
    data: DataSet, bank: PlayBank, sums: NormalEquations, choice: Choice, eps: float
) -> Estimate:
    knots = _knots_of(choice.family)
    estimate = fit_family(
        choice.family,
        sums,
        eps,
        knots,
        choice.regularisation,
        triangle=lambda: reduce(data, bank, knots),
    )
    if knots is None or choice.regularisation is None:
        return estimate
    return polish(sums, eps, knots, choice.regularisation, estimate)


@dataclass(frozen=True)
class _Problem:
    data: DataSet
    operators: int
    eps: float
    thresholds: Array | None


@dataclass(frozen=True)
class PlaysFamily:
    """A family of plays or stops with its settings, which were checked; "static" is a curve, "auto" the best of all.

    Attributes
    ----------
    family
        One of `FAMILIES`, "static" or "auto".
    operators
        Number of them; the paper's until one is chosen.
    eps, choose_eps
        Smallest slope after a reversal, and whether it is only what a choice begins with.
    thresholds
        Instead of a grid. [input]
    initial_state
        Memory before the first sample, or "auto".
    choose_operators
        Whether the number of operators is chosen.
    power
        Exponent of the grid of thresholds; None for that of the family.
    """

    family: str
    operators: int = PAPER_OPERATORS
    eps: float = PAPER_EPS
    choose_eps: bool = False
    thresholds: tuple[float, ...] | None = None
    initial_state: str = "auto"
    choose_operators: bool = False
    power: float | None = None

    @property
    def settings(self) -> dict[str, Any]:
        """As plain values, for the fit."""
        grid = "grid"
        if self.thresholds is not None:
            grid = "given"
        return {
            "family": self.family,
            "n": self.operators,
            "eps": self.eps,
            "thresholds": grid,
            "initial_state": self.initial_state,
        }

    @property
    def threshold_array(self) -> Array | None:
        """The thresholds as an array, (n,), or None."""
        if self.thresholds is None:
            return None
        return np.array(self.thresholds)

    def scaled_eps(self, log: Prepared) -> float:
        """The smallest slope, relative to the ratio of the ranges of the log."""
        # The paper's program bounds w_1 itself; everywhere else eps is relative already.
        if self.family == "pi" and not self.choose_eps:
            return paper_eps(self.eps, log.records[0], log.data)
        return self.eps

    def fit(self, log: Prepared) -> Outcome:
        """Choose and fit."""
        with single_blas():
            return _fitted(self, log)

    def block_errors(self, log: Prepared) -> BlockErrors:
        """Return the errors on blocks, with the paper's start where none was named, and eps and n as they stand."""
        start = self.initial_state
        if start == "auto":
            start = "zero"
        eps = self.scaled_eps(log)
        return play_block_errors(
            log, self.family, self.operators, self.power, eps, start, self.threshold_array
        )


def plays_of(
    family: str = "auto",
    n: int | str = PAPER_OPERATORS,
    eps: float | str | None = None,
    thresholds: npt.ArrayLike | None = None,
    initial_state: str = "auto",
) -> PlaysFamily:
    """Return a family of plays with settings as `dehyst.identify` takes them.

    Raises
    ------
    ParameterError
        If a setting lies outside what its formula allows.

    Examples
    --------
    >>> plays_of("pi", n=20).operators, plays_of("stop").choose_eps
    (20, True)
    """
    eps_begun, choose_eps = eps_of_call(family, eps)
    grid = check_settings(family, n, eps_begun, thresholds, initial_state)
    choose_operators = isinstance(n, str)
    operators = PAPER_OPERATORS
    if not isinstance(n, str):
        operators = int(n)
    listed = None
    if grid is not None:
        listed = tuple(grid.tolist())
        operators = len(listed)
    return PlaysFamily(
        family, operators, eps_begun, choose_eps, listed, initial_state, choose_operators
    )


def _fitted(call: PlaysFamily, log: Prepared) -> Outcome:
    data, split = log.data, log.split
    slope = _slope(data, call.family)
    scaled = call.scaled_eps(log)
    thresholds = call.threshold_array
    problem = _Problem(data, call.operators, scaled, thresholds)
    families: tuple[str, ...] = (call.family,)
    if call.family == "auto":
        families = BY_ORIENTATION[log.seen.loop.name]
    starts: tuple[str, ...] = (call.initial_state,)
    if call.family == "pi" and call.initial_state == "auto":
        starts = (start_of_paper(data, problem.operators, scaled, thresholds),)
    elif call.initial_state == "auto":
        starts = STARTS
    choice, compared = _choose(problem, families, starts)
    if call.power is not None:
        choice = replace(choice, power=call.power)
    settings = {**call.settings, **split.settings}
    if log.weights is not None:
        settings["weights"] = "given"
    if call.choose_operators and choice.family != STATIC:
        operators, choice = choose_operators(data, choice, scaled)
        problem = replace(problem, operators=operators)
        settings |= {"n": operators, "n_by": "cross-validation", "power": choice.power}
    firm = firmness(data, choice, problem.operators, scaled, thresholds)
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
        refitter = Refitter(log.records, data, choice, problem.operators, problem.eps, thresholds)
        bank, estimate = _fit(problem, choice, refitter)
    if choice.regularisation is not None:
        settings["smoothing"] = choice.regularisation.smoothing
        settings["ridge"] = choice.regularisation.ridge
    if choice.family == STATIC:
        model: HysteresisModel = curve_of(estimate, data)
    else:
        model = build_model(estimate, data, bank, _knots_of(choice.family), ModelCard())
    form = None
    if choice.family != STATIC:
        settled = settled_bank(data, bank, model)
        form = PlayForm(data, settled, choice, _knots_of(choice.family), estimate, problem.eps)
    firm = firm.times(slope)
    # Only the paper's own bound depends on the units, which is what the strain tells of.
    strain = 0.0
    if is_papers(settings):
        strain = firm.strain
    certificate = Certificate(
        kkt_residual=estimate.kkt_residual,
        inverse_gain=model.inverse_gain,
        affordable_eps=firm.affordable,
        enough_eps=firm.enough,
        enough_eps_cost=firm.cost,
        strain=strain,
        nonzero_weights=model.nonzero_weights,
        operators=problem.operators,
        undetermined=tuple((bank.undetermined * data.half_range).tolist()),
        initial_state=choice.initial_state,
        route=estimate.route,
        condition=estimate.condition,
    )
    static = log.curve(choice.initial_state)
    return Outcome(
        family=choice.family,
        model=model,
        settings=settings,
        certificate=certificate,
        measure=lambda turns: log.measure(
            data, settled_bank(data, bank, model), model, static, turns
        ),
        static=static,
        knows=Knows(leads=choice.family in ("stop", "pi-cumulative")),
        compared=compared,
        refitter=refitter,
        form=form,
    )


def _choose(
    problem: _Problem, families: Sequence[str], starts: Sequence[str]
) -> tuple[Choice, tuple[ComparedSetting, ...]]:
    choices = list(possible_choices(families, starts))
    if len(choices) == 1:
        return choices[0], ()
    results = compare_choices(
        problem.data, choices, problem.operators, problem.eps, problem.thresholds
    )
    if not results:  # too few samples to hold any out
        family = next(name for name in families if name != STATIC)
        regularisation = None
        if family == "modified-pi":
            regularisation = REGULARISATIONS[-1]
        return Choice(family, starts[0], regularisation), ()
    return best_choice(results)


def _fit(problem: _Problem, choice: Choice, refitter: Refitter | None) -> tuple[PlayBank, Estimate]:
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
    grid = threshold_grid(data, problem.operators, choice, problem.thresholds)
    bank = make_bank(data, grid, choice.initial_state)
    knots = _knots_of(choice.family)
    sums = normal_equations(data, bank, knots)
    if refitter is not None:
        refitter.keep(bank, sums, knots is not None)
    estimate = _solved(data, bank, sums, choice, problem.eps)
    if knots is None:
        estimate = refine(data, bank, sums, problem.eps, estimate)
    return bank, estimate
