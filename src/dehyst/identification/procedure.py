"""identify(): from recordings to a fitted, certified model."""

from __future__ import annotations

import datetime as _datetime
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from threadpoolctl import threadpool_limits

from dehyst import __version__
from dehyst.errors import ExcitationError, ParameterError
from dehyst.identification import facts, judge
from dehyst.identification.build import build_model
from dehyst.identification.data import DataSet, prepare
from dehyst.identification.families import FAMILIES, Estimate, fit_family
from dehyst.identification.fit import Candidate, Certificate, Fit
from dehyst.identification.memory import INITIAL_STATES
from dehyst.identification.regressors import Bank, make_bank, reduce, training_rows
from dehyst.identification.scores import inverse_miss, masks, predictions, round_trip, score
from dehyst.identification.selection import (
    BY_ORIENTATION,
    REGULARISATIONS,
    STARTS,
    Choice,
    choose,
    compare,
    output_knots,
    possible_choices,
    threshold_grid,
)
from dehyst.identification.static_curve import fit_static
from dehyst.models import ModelCard, SignalCard, StaticCurve
from dehyst.models.arrays import parameter_array, parameter_number, strictly_increasing
from dehyst.recording import Recording

Array = npt.NDArray[np.float64]

PAPER_OPERATORS = 100
PAPER_EPS = 0.001
MOST_OPERATORS = 2000


@dataclass(frozen=True)
class _Problem:
    data: DataSet
    operators: int
    eps: float
    given: Array | None


def identify(
    recordings: Recording | Sequence[Recording],
    family: str = "auto",
    *,
    n: int = PAPER_OPERATORS,
    eps: float = PAPER_EPS,
    thresholds: npt.ArrayLike | None = None,
    initial_state: str = "auto",
    train_fraction: float = 0.5,
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
        or "auto": the one with the least error on loops held out within the training part, the simpler one
        within 2 %.
    n
        Number of operators, at thresholds r_i = (i - 1)/n max|x|.
    eps
        Smallest slope right after a reversal, relative to output range over input range; 1/eps bounds the gain
        of the inverse.
    thresholds
        Thresholds to use instead of the grid, (n,), increasing from 0. [input]
    initial_state
        Memory before the first sample: "zero" (after decaying oscillation; the paper), "rest" (never moved),
        "rising" or "falling" (in the middle of a periodic motion), "unknown" (samples before both extremes were
        visited do not count), or "auto": "zero" for the family "pi", by held-out error otherwise.
    train_fraction
        Share of each recording that is fitted; the rest is the test. 1 fits everything and tests nothing.

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
    >>> fit = dehyst.identify(rec, family="pi", thresholds=[0.0, 0.5, 1.0], initial_state="rest")
    >>> fit.model.weights.round(9).tolist()
    [1.0, 0.5, 0.25]
    """
    records = _as_tuple(recordings)
    given = _check_settings(family, n, eps, thresholds, initial_state)
    fraction = parameter_number(train_fraction, "train_fraction")
    # Hundreds of small factorisations: the threads of BLAS would spend their time waiting for each other, up to
    # ten times that of the work itself on a busy machine.
    with threadpool_limits(limits=1, user_api="blas"):
        return _identify(records, family, int(n), float(eps), given, initial_state, fraction)


def _identify(
    records: tuple[Recording, ...],
    family: str,
    n: int,
    eps: float,
    given: Array | None,
    initial_state: str,
    train_fraction: float,
) -> Fit:
    data = prepare(records, train_fraction)
    problem = _Problem(data, n if given is None else given.size, float(eps), given)
    loop = facts.orientation(data)
    families = BY_ORIENTATION[loop.name] if family == "auto" else (family,)
    starts = STARTS if initial_state == "auto" else (initial_state,)
    if family == "pi" and initial_state == "auto":
        starts = ("zero",)
    choice, candidates = _choose(problem, families, starts)
    bank, estimate = _fit(problem, choice)
    settings: dict[str, Any] = {
        "family": family,
        "n": problem.operators,
        "eps": problem.eps,
        "thresholds": "grid" if given is None else "given",
        "initial_state": initial_state,
        "train_fraction": float(train_fraction),
    }
    if choice.regularisation is not None:
        settings["smoothing"] = choice.regularisation.smoothing
        settings["ridge"] = choice.regularisation.ridge
    return _certify(records, problem, choice, bank, estimate, candidates, loop, settings)


def identify_paper(recordings: Recording | Sequence[Recording], *, train_fraction: float = 0.5) -> Fit:
    """Identify with the 2012 paper's own settings: n = 100, eps = 0.001, w >= 0, z0 = 0.

    The same as ``identify(recordings, family="pi")``.

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


def _as_tuple(recordings: Recording | Sequence[Recording]) -> tuple[Recording, ...]:
    if isinstance(recordings, Recording):
        return (recordings,)
    records = tuple(recordings) if isinstance(recordings, Iterable) else ()
    if not records or not all(isinstance(record, Recording) for record in records):
        raise ParameterError(
            "identify() takes a Recording or a list of Recordings. Make one with dehyst.read_log(path, input=..., "
            "output=...) or dehyst.Recording(input=x, output=y)."
        )
    units = {(record.input_unit, record.output_unit) for record in records}
    if len(units) > 1:
        raise ParameterError(
            f"the recordings carry different units, {sorted(units)}; one model has one pair of units. "
            f"Convert them first.",
            units=units,
        )
    return records


def _check_settings(
    family: str, n: int, eps: float, thresholds: npt.ArrayLike | None, initial_state: str
) -> Array | None:
    if family != "auto" and family not in FAMILIES:
        raise ParameterError(f"family {family!r} is not one of auto, {', '.join(FAMILIES)}.", family=family)
    if initial_state != "auto" and initial_state not in INITIAL_STATES:
        raise ParameterError(
            f"initial_state {initial_state!r} is not one of auto, {', '.join(INITIAL_STATES)}.",
            initial_state=initial_state,
        )
    if isinstance(n, bool) or not isinstance(n, (int, np.integer)) or not 1 <= n <= MOST_OPERATORS:
        raise ParameterError(
            f"n = {n!r} operators: pass a whole number from 1 to {MOST_OPERATORS} (the paper uses 100).", n=n
        )
    eps = parameter_number(eps, "eps")
    if not 0.0 < eps <= 1.0:
        raise ParameterError(
            f"eps = {eps:g} must lie in (0, 1]: it is the smallest slope after a reversal, relative to output range "
            f"over input range, and 1/eps bounds the inverse's gain. The paper uses 0.001.",
            eps=eps,
        )
    if thresholds is None:
        return None
    given = parameter_array(thresholds, "thresholds")
    strictly_increasing(given, "thresholds")
    if given[0] != 0.0:
        raise ParameterError(
            f"thresholds[0] = {given[0]:g} must be 0: without a play of radius 0 the model has no inverse.",
            first=float(given[0]),
        )
    return given


def _choose(problem: _Problem, families: Sequence[str], starts: Sequence[str]) -> tuple[Choice, tuple[Candidate, ...]]:
    choices = list(possible_choices(families, starts))
    if len(choices) == 1:
        return choices[0], ()
    results = compare(problem.data, choices, problem.operators, problem.eps, problem.given)
    if not results:  # too few samples to hold any out
        family = families[0]
        return Choice(family, starts[0], REGULARISATIONS[-1] if family == "modified-pi" else None), ()
    return choose(results)


def _fit(problem: _Problem, choice: Choice) -> tuple[Bank, Estimate]:
    data = problem.data
    rows = training_rows(data, choice.initial_state)
    usable = sum(part.size for part in rows)
    if usable < 4:
        raise ExcitationError(
            f"only {usable} training samples remain once the memory of the actuator is known: the input visits both "
            f"of its extremes too late, or after every gap not at all. Fit a larger part (--train-fraction), or assume "
            f"a start (--initial-state zero, rest, rising or falling).",
            samples=usable,
        )
    bank = make_bank(data, threshold_grid(data, problem.operators, choice.initial_state, problem.given),
                     choice.initial_state)  # fmt: skip
    knots = output_knots() if choice.family == "modified-pi" else None
    system = reduce(data, bank, rows, knots)
    estimate = fit_family(choice.family, system, bank.thresholds.size, problem.eps, knots, choice.regularisation)
    return bank, estimate


def _certify(
    records: tuple[Recording, ...],
    problem: _Problem,
    choice: Choice,
    bank: Bank,
    estimate: Estimate,
    candidates: tuple[Candidate, ...],
    loop: facts.Orientation,
    settings: dict[str, Any],
) -> Fit:
    data = problem.data
    knots = output_knots() if choice.family == "modified-pi" else None
    rows = training_rows(data, choice.initial_state)
    model = build_model(estimate, data, bank, knots, ModelCard())
    static = fit_static(data, rows, ModelCard())
    train_masks, test_masks = masks(records, data, choice.initial_state)
    outputs, demands = predictions(records, data, bank, model)
    curves = tuple(static.simulate(record.input) for record in records)
    train, test = (score(records, outputs, chosen, data.output_range) for chosen in (train_masks, test_masks))
    static_train, static_test = (
        score(records, curves, chosen, data.output_range) for chosen in (train_masks, test_masks)
    )
    if train is None or static_train is None:
        raise AssertionError("no training samples")  # _fit has checked
    certificate = Certificate(
        kkt_residual=estimate.kkt_residual,
        round_trip_error=round_trip(model, records[0].input),
        inverse_gain=model.inverse_gain,
        inverse_miss_percent=100.0 * inverse_miss(records, demands, train_masks if test is None else test_masks),
        nonzero_weights=model.nonzero_weights,
        operators=problem.operators,
        undetermined=tuple(float(r) for r in bank.undetermined * data.half_range),
        initial_state=choice.initial_state,
    )
    loop_facts, findings = judge.examine(
        records, data, loop, outputs, curves, train_masks, test_masks, certificate, choice.family
    )
    verdict = judge.verdict(choice.family, train, test, static_test or static_train, certificate, findings)
    card = _card(records, settings, choice, train, test, verdict)
    return Fit(
        family=choice.family,
        model=model.with_card(card),
        recordings=records,
        predictions=outputs,
        inverse_predictions=demands,
        train_masks=train_masks,
        test_masks=test_masks,
        train=train,
        test=test,
        static=StaticCurve(static.curve, card),
        static_train=static_train,
        static_test=static_test,
        certificate=certificate,
        facts=loop_facts,
        candidates=candidates,
        warnings=findings,
        settings=settings,
        verdict=verdict,
    )


def _card(
    records: tuple[Recording, ...],
    settings: dict[str, Any],
    choice: Choice,
    train: Any,
    test: Any,
    verdict: str,
) -> ModelCard:
    first = records[0]
    low_in, high_in = min(float(r.input.min()) for r in records), max(float(r.input.max()) for r in records)
    low_out, high_out = min(float(r.output.min()) for r in records), max(float(r.output.max()) for r in records)
    provenance = {
        "logs": [dict(record.provenance) | {"name": record.name, "samples": len(record)} for record in records],
        "date": _datetime.datetime.now(_datetime.UTC).isoformat(timespec="seconds"),
        "dehyst": __version__,
        "settings": dict(settings),
        "identified_family": choice.family,
        "initial_state": choice.initial_state,
        "train": train.as_dict(),
        "test": None if test is None else test.as_dict(),
        "verdict": verdict,
    }
    return ModelCard(
        SignalCard(first.input_name, first.input_unit, low_in, high_in),
        SignalCard(first.output_name, first.output_unit, low_out, high_out),
        provenance,
    )
