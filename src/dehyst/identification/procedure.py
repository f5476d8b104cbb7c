"""identify(): from recordings to a fitted, certified model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data.recording import Recording, require_recordings, takes_recordings
from dehyst.errors import ExcitationError, ParameterError
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
    PAPER_EPS,
    PAPER_OPERATORS,
    check_recordings,
    check_settings,
    check_weights,
    eps_of_call,
    paper_eps,
    refuse_both,
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


@takes_recordings
def identify(
    recordings: Recording | Sequence[Recording],
    family: str = "auto",
    *,
    n: int | str = PAPER_OPERATORS,
    eps: float | str | None = None,
    thresholds: npt.ArrayLike | None = None,
    initial_state: str = "auto",
    train_fraction: float | None = None,
    weights: npt.ArrayLike | Sequence[npt.ArrayLike] | None = None,
    shear: float | str | None = None,
    max_inverse_gain: float | None = None,
) -> Fit:
    r"""Identify a hysteresis model from one recording or several.

    The paper's problem, with the input centred and an offset c identified along:

    .. math::

        \min_{w, c} \sum_k \Big(y_k - c - \sum_i w_i z_i[k]\Big)^2
        \quad \text{subject to} \quad w_1 \ge \varepsilon, \; w_i \ge 0

    Parameters
    ----------
    recordings
        One recording or a list of them; all are fitted together.
    family
        "pi" (Prandtl-Ishlinskii, the paper's), "pi-cumulative" (positive partial sums instead of weights),
        "modified-pi" (with an output map, for loops that saturate or are asymmetric), "stop" (for clockwise loops),
        "static" (a curve without memory), or "auto": the one with the least error on loops held out within the
        training part, the simpler one within 2 %, and the curve where none is 5 % better. "direct-inverse" is
        `identify_direct` with its usual settings.
    n
        Number of operators, at thresholds r_i = (i - 1)/n max|x|; ((i - 1)/n)^2 max|x| for "stop", whose
        loops are steep right after a reversal. Memory grows with n^2: 10 000 operators take several gigabytes.
        "auto" takes the fewest operators, on a grid with exponent 1 or 2, that are within 2 % of the least error on
        held-out loops.
    eps
        Smallest slope right after a reversal, whose inverse bounds that of the compensator. For the family "pi" the
        paper's bound w_1 >= eps, by default its 0.001 [output/input]; for all others, and for family "auto", relative
        to output range over input range. "auto", the default of these, begins with 0.001 and, where the inverse would
        amplify by more than 20 times the ratio of the ranges, raises it (relative, for "pi" too) until it does not, or
        as far as the error of the fit grows by no more than 5 %.
    thresholds
        Thresholds to use instead of the grid, (n,), increasing from 0. [input]
    initial_state
        Memory before the first sample: "zero" (after decaying oscillation; the paper), "rest" (never moved),
        "rising" or "falling" (in the middle of a periodic motion), "unknown" (samples before both extremes were
        visited do not count), "origin" (came from rest at input 0), or "auto": by held-out error; for the family
        "pi" it is "zero" unless another start halves the error.
    train_fraction
        Share of each recording that is fitted; the rest is the test. 1 fits everything and tests nothing. None, the
        default, fits the first half of one recording or two; of three or more, whole ones are held out, about half of
        the samples, such that the input of these stays within the range that is fitted.
    weights
        How much each sample counts, (T,), 0 or more, or one such array for each recording: squared errors are
        multiplied by it, in the fit and in the scores. 2 is the same as a sample that was logged twice; 0 leaves
        a sample out, except that its input is remembered. By default all count alike.
    shear
        k: the loop is fitted around the diagonal, as :math:`y = H[u + k y]`, and the model is the sheared one, whose
        inverse subtracts k y again; for the families "pi" (which "auto" then stands for) and "pi-cumulative". "auto"
        chooses k by the held-out error of the inverse (`choose_shear`). None fits the loop as it was logged.
        [input/output]
    max_inverse_gain
        G, largest slope of the inverse right after a reversal, instead of eps: a wanted output that moves by one step
        of its sensor changes the input asked for by at most G times that step. [input/output]

    Returns
    -------
    fit : Fit
        Model, scores, certificate and findings.

    Raises
    ------
    ParameterError
        If a setting lies outside what its formula allows.
    ExcitationError
        If the input or output does not move, or memory is unknown throughout the training part.
    IdentificationError
        If the quadratic program is not solved.

    References
    ----------
    M. Kastner, H. Gattringer, R. Naderer, "Evaluation of a Joint Hysteresis Model in a Robot Actuated by Pneumatic
    Muscles", ICINCO 2012. K. Kuhnen, European Journal of Control 9(4), 2003.

    Examples
    --------
    >>> import numpy as np, dehyst
    >>> x = 2 * np.sin(np.linspace(0, 30, 600)) * np.linspace(1, 0.2, 600)
    >>> y = dehyst.PrandtlIshlinskii([0.0, 0.5, 1.0], [1.0, 0.5, 0.25]).simulate(x)
    >>> rec = dehyst.Recording(input=x, output=y)
    >>> fit = dehyst.identify(rec, family="pi", thresholds=[0.0, 0.5, 1.0])
    >>> fit.model.weights.round(9).tolist()
    [1.0, 0.5, 0.25]
    """
    recordings = require_recordings(recordings)  # before the family: identify(u, y) makes an array of it
    if str(family) == DIRECT:
        given_here = {
            "n": n != PAPER_OPERATORS, "eps": eps is not None, "thresholds": thresholds is not None,
            "weights": weights is not None, "shear": shear is not None,
            "max_inverse_gain": max_inverse_gain is not None,
        }  # fmt: skip
        return _identify_direct(recordings, initial_state, train_fraction, given_here)
    records = check_recordings(recordings)
    begun, chosen = eps_of_call(family, eps)
    given = check_settings(family, n, begun, thresholds, initial_state)
    sample_weights = check_weights(weights, records)
    split = split_recordings(records, train_fraction, sample_weights)
    call = call_of(family, n, (begun, chosen), given, initial_state, split, sample_weights is not None)
    if eps is not None:
        refuse_both(eps, shear, max_inverse_gain)
    if shear is None and max_inverse_gain is None:
        return solve_in_memory(call, records, sample_weights)
    from dehyst.identification.gain import identify_sheared, identify_within  # they call what is below

    if shear is not None:
        return identify_sheared(call, records, sample_weights, shear, max_inverse_gain)
    return identify_within(call, records, sample_weights, 0.0 if max_inverse_gain is None else max_inverse_gain)


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


def _identify_direct(
    recordings: Recording | Sequence[Recording],
    initial_state: str,
    train_fraction: float | None,
    given: dict[str, bool],
) -> Fit:
    from dehyst.identification.direct import identify_direct  # which compares itself with the families of this module

    set_here = [name for name, there in given.items() if there]
    if set_here:
        raise ParameterError(
            f"{' and '.join(set_here)} {'says' if len(set_here) == 1 else 'say'} nothing to the family "
            f"'direct-inverse': its radii, path lengths and slopes are its own and every sample counts alike. Leave "
            f"{'it' if len(set_here) == 1 else 'them'} out; creep and schedules are settings of "
            "dehyst.identify_direct.",
            settings=set_here,
        )
    return identify_direct(recordings, initial_state=initial_state, train_fraction=train_fraction)


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


@takes_recordings
def identify_paper(recordings: Recording | Sequence[Recording], *, train_fraction: float | None = None) -> Fit:
    """Identify with the 2012 paper's own settings: n = 100, w_1 >= eps = 0.001, w >= 0, z0 = 0.

    The same as ``identify(recordings, family="pi")``: the input is centred, an offset is identified along, and z0 is
    0 unless another start halves the error of the fit, which only data made by the operator itself bring about. To
    insist on z0 = 0 in any case, call ``identify(recordings, family="pi", initial_state="zero")``.

    Parameters
    ----------
    recordings
        One recording or a list of them.
    train_fraction
        Share of each recording that is fitted.

    Examples
    --------
    >>> import numpy as np, dehyst
    >>> x = np.sin(np.linspace(0, 20, 400))
    >>> fit = identify_paper(dehyst.Recording(input=x, output=2 * x))
    >>> fit.family, fit.certificate.operators
    ('pi', 100)
    """
    return identify(recordings, "pi", n=PAPER_OPERATORS, eps=PAPER_EPS, train_fraction=train_fraction)


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
