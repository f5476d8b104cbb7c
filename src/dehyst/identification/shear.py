"""Identification within a bound of the inverse's gain, and of the sheared loop y = H[u + k y] with the choice of k."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data.ranges import robust_range
from dehyst.data.recording import Recording, takes_recordings
from dehyst.errors import DehystError, ParameterError
from dehyst.findings import Finding, Grade, grade_of
from dehyst.identification.cautions import POOR_PERCENT, of_range, unit_of_gain
from dehyst.identification.certify import GOOD_PERCENT
from dehyst.identification.cross_validation import Trial, cross_validate
from dehyst.identification.data import DataSet, prepare, range_over
from dehyst.identification.families import HIGH_GAIN
from dehyst.identification.fit import Fit
from dehyst.identification.procedure import Call, solve_in_memory
from dehyst.identification.regressors import Bank
from dehyst.identification.scores import InMemory, Measure, Measured
from dehyst.identification.settings import PAPER_EPS, PAPER_OPERATORS, check_recordings
from dehyst.identification.split import split_recordings
from dehyst.models import (
    HysteresisModel,
    ModelCard,
    PrandtlIshlinskii,
    ShearedPrandtlIshlinskii,
    SignalCard,
    StaticCurve,
)
from dehyst.models.arrays import parameter_number

# Candidates for k lie from the range of the input over the range of the output to so many times that.
LARGEST = 100.0
# The smallest k whose inverse misses no more than this above the least: beyond, k only costs digits and threshold grid.
WITHIN = 0.05
# A gain of the compensator above this share of what the bound allows is decided by the bound, not by the data.
OFF_BOUND = 0.75
# The paper's eps has units: in those of another log, or with a large k, it may exceed the slope itself.
LARGEST_EPS = 0.01
SHEARED_FAMILIES = ("pi", "pi-cumulative")


@dataclass(frozen=True)
class ShearChoice:
    """What `choose_shear` compared, and what it took.

    Attributes
    ----------
    shear
        k. [input/output]
    gain
        Slope of the compensator right after a reversal, with k subtracted, in cross-validation. [input/output]
    error
        What the inverse missed on held-out blocks, geometric mean of the RMS. [input]
    on_bound
        Whether the chosen k leaves the compensator steep after a reversal, or its first weight at the bound: then the
        bound decides the gain, not the data.
    trials
        All candidates in the order of k, as `cross_validate` returns them.

    Examples
    --------
    >>> from dehyst.io import example_recording
    >>> choice = choose_shear(example_recording())
    >>> choice.on_bound, choice.error <= 1.05 * min(trial.inverse_error for trial in choice.trials)
    (False, True)
    """

    shear: float
    gain: float
    error: float
    on_bound: bool
    trials: tuple[Trial, ...]

    def as_list(self) -> list[dict[str, float]]:
        """Return k, what the inverse missed and the gain of the compensator for each candidate, as plain values."""
        return [{"shear": t.shear, "inverse_error": t.inverse_error, "gain": _gain(t)} for t in self.trials]


@takes_recordings
def choose_shear(
    recordings: Recording | Sequence[Recording],
    *,
    family: str = "pi",
    n: int = PAPER_OPERATORS,
    eps: float = PAPER_EPS,
    max_inverse_gain: float | None = None,
    initial_state: str = "zero",
    train_fraction: float | None = None,
    weights: npt.ArrayLike | Sequence[npt.ArrayLike] | None = None,
) -> ShearChoice:
    r"""Choose the scale k of the sheared loop :math:`x = u + k y` by the held-out error of the inverse.

    Forward accuracy says little: the larger k, the nearer y lies to x/k whatever the model. What counts is

    .. math:: u - (H^{-1}[y] - k y)

    on blocks of the log that were not fitted. With a small k the first weight ends at the paper's bound, and the
    compensator steps at every reversal; candidates with a gain of more than 20 times the ratio of the ranges there are
    left out if there are others, and all count where a gain is given. Of these the smallest k within 5 % of the least
    error is taken.

    Parameters
    ----------
    recordings
        One recording or a list of them: input u and output y as they were logged, not sheared.
    family
        "pi" or "pi-cumulative".
    n
        Number of operators.
    eps
        Smallest first weight, as `identify` takes it; at most a hundredth of the slope of the sheared loop.
    max_inverse_gain
        G, largest slope of the compensator right after a reversal: then eps = 1/(G + k) for each k. [input/output]
    initial_state
        Memory before the first sample, as `cross_validate` takes it.
    train_fraction
        Share of each recording that takes part; the rest stays unseen.
    weights
        How much each sample counts, as `identify` takes it.

    Returns
    -------
    choice : ShearChoice

    Raises
    ------
    ParameterError
        If a setting lies outside what its formula allows.
    ExcitationError
        If input or output does not move.

    Examples
    --------
    A loop whose backbone was taken off: the output does not follow from the input, the compensator does.

    >>> import numpy as np, dehyst
    >>> y = np.interp(np.linspace(0, 12, 2401), range(13), [0, 1, -1, .8, -.8, .5, -.9, .6, -.5, 1, -.3, .7, 0])
    >>> u = dehyst.StopOperatorModel([0.0, 0.1, 0.3], [0.0, 1.0, 0.5], slope=0.0).simulate(y)
    >>> choice = choose_shear(dehyst.Recording(input=u, output=y))
    >>> choice.shear > 0, bool(choice.error < 0.05 * np.std(u))
    (True, True)
    """
    records = check_recordings(recordings)
    check_family(family)
    data = prepare(records, split_recordings(records, 1.0))
    ratio = data.trend * robust_range([record.input for record in records]) / robust_range([r.output for r in records])
    trials: list[Trial] = []
    bounds: list[float] = []
    for k in candidates(ratio):
        bounds.append(_bound(family, eps, max_inverse_gain, k, ratio))
        table = cross_validate(
            records, families=(family,), n=(n,), shear=(k,), starts=(initial_state,),
            eps=bounds[-1], train_fraction=train_fraction, weights=weights,
        )  # fmt: skip
        trials += table.trials
    steep = HIGH_GAIN * abs(ratio)  # what the finding high-inverse-gain warns of
    free = [
        t
        for t, eps_k in zip(trials, bounds, strict=True)
        if _gain(t) <= min(steep, OFF_BOUND * (1.0 / eps_k - abs(t.shear)))
    ]
    eligible = free if free and max_inverse_gain is None else trials
    least = min(t.inverse_error for t in eligible)
    chosen = next(t for t in eligible if t.inverse_error <= (1.0 + WITHIN) * least)
    return ShearChoice(chosen.shear, _gain(chosen), chosen.inverse_error, chosen not in free, tuple(trials))


def _bound(family: str, eps: float, gain: float | None, k: float, ratio: float) -> float:
    """Return the eps of a cross-validation: that of the gain, or the paper's where the sheared slope allows it."""
    slope = 1.0 / (abs(k) + abs(ratio))
    if gain is not None:
        bound = min(eps_of_gain(gain, k), slope)
        return bound if family == "pi" else bound / slope
    return min(eps, LARGEST_EPS * slope) if family == "pi" else eps


def candidates(ratio: float) -> list[float]:
    """Return 1, 2 and 5 times powers of ten from a ratio to a hundred times it, with its sign.

    Examples
    --------
    >>> candidates(0.54)
    [1.0, 2.0, 5.0, 10.0, 20.0, 50.0]
    """
    size = abs(ratio)
    first = math.floor(math.log10(size))
    grid = [float(f"{digit}e{first + decade}") for decade in range(4) for digit in (1, 2, 5)]
    return [math.copysign(k, ratio) for k in grid if size <= k <= LARGEST * size]


def _gain(trial: Trial) -> float:
    """Slope of the compensator right after a reversal: k is subtracted."""
    return trial.inverse_gain - abs(trial.shear)


def eps_of_gain(gain: float, shear: float = 0.0) -> float:
    """Return the bound of the first weight that keeps |1/w_1| - |k| <= G: eps = 1/(G + |k|). [output/input].

    Examples
    --------
    >>> eps_of_gain(20.0), eps_of_gain(20.0, shear=5.0)
    (0.05, 0.04)
    """
    gain = parameter_number(gain, "max_inverse_gain")
    if gain <= 0.0:
        raise ParameterError(
            f"max_inverse_gain = {gain:g} must be positive: it is the largest change of the inverse's output for one "
            f"unit of its input, right after a reversal. 1000 is what the paper's eps = 0.001 allows.",
            gain=gain,
        )
    return 1.0 / (gain + abs(shear))


def check_family(family: str) -> None:
    """Refuse families whose inverse less k y is not of their own kind."""
    if family not in SHEARED_FAMILIES:
        raise ParameterError(
            f"a shear does not go with family '{family}': its inverse less k y is no sum of plays. Take --family "
            f"{' or '.join(SHEARED_FAMILIES)}, or leave the shear out.",
            family=family,
        )


def sheared(records: tuple[Recording, ...], k: float) -> tuple[Recording, ...]:
    """Return the recordings with u + k y as input, which says so in its name."""
    return tuple(
        replace(r, input=r.input + k * r.output, input_name=f"{r.input_name} + {k:.4g} {r.output_name}")
        for r in records
    )


# An output map multiplies the gain of the operator in front of it: eps is raised until their product fits.
TRIES = 4
ROUNDING = 1e-9
# Families that a shear chosen from the data is compared with, and by how much one must be better to be named.
RIVALS = ("pi", "modified-pi")
BETTER = 0.9


def identify_within(call: Call, records: tuple[Recording, ...], weights: tuple[Array, ...] | None, gain: float) -> Fit:
    """Fit with the eps that keeps the inverse's gain within G, and check that it does. [input/output]"""
    data = prepare(records, call.split, weights)
    slope = data.amplitude / data.half_range
    eps = eps_of_gain(gain)
    if eps > slope:
        unit = unit_of_gain(records[0])
        raise ParameterError(
            f"max_inverse_gain = {gain:g}{unit} is less than a straight line through this log needs, "
            f"{1.0 / slope:.3g}{unit}. Pass more, for example {3.0 / slope:.1g}: right after a reversal the inverse is "
            f"steeper than on average.",
            gain=gain,
            slope=slope,
        )
    exact = call.family == "pi"  # its eps is in units of the log, that of the others relative
    eps = eps if exact else eps / slope
    fit = solve_in_memory(replace(call, eps=eps, choose_eps=False), records, weights)
    for _ in range(TRIES):
        excess = fit.certificate.inverse_gain / gain
        if excess <= 1.0 + ROUNDING or exact or eps * excess > 1.0:
            break
        eps *= excess
        fit = solve_in_memory(replace(call, eps=eps, choose_eps=False), records, weights)
    return _checked(_with_settings(fit, {"max_inverse_gain": gain}), gain)


def identify_sheared(
    call: Call,
    records: tuple[Recording, ...],
    weights: tuple[Array, ...] | None,
    shear: float | str,
    gain: float | None,
) -> Fit:
    """Fit y = H[u + k y] and return the sheared model, judged by what its inverse misses of u."""
    asked, call = call, replace(call, family="pi") if call.family == "auto" else call
    check_family(call.family)
    if gain is not None:
        eps_of_gain(gain)
    k, choice = _scale(call, records, weights, shear, gain)
    turned = sheared(records, k)
    call = replace(call, eps=_eps(call, turned, weights, k, gain), choose_eps=False)
    fit = solve_in_memory(call, turned, weights, _against(records, turned))
    model = ShearedPrandtlIshlinskii(cast(PrandtlIshlinskii, fit.model), k, _card(fit, records))
    certificate = replace(fit.certificate, inverse_gain=model.inverse_gain)
    fit = replace(fit, model=model, certificate=certificate, shear_choice=choice)
    fit = _named(fit, k, records[0], asked.family == "auto")
    if choice is not None and gain is None:
        fit = replace(fit, warnings=(*fit.warnings, *_rivals(asked, records, weights, fit)))
    limits = {} if gain is None else {"max_inverse_gain": gain}
    return _checked(
        _with_settings(fit, {"shear": k, "shear_by": "held-out inverse" if choice else "given"} | limits), gain
    )


def _scale(
    call: Call,
    records: tuple[Recording, ...],
    weights: tuple[Array, ...] | None,
    shear: float | str,
    gain: float | None,
) -> tuple[float, ShearChoice | None]:
    if shear != "auto":
        try:
            return parameter_number(float(shear), "shear"), None
        except ValueError:
            raise ParameterError(
                f"shear = {shear!r:.40} is neither a number nor 'auto'; it is k of u + k y, in "
                f"{unit_of_gain(records[0]).strip() or 'units of input over output'}."
            ) from None
    if call.given is not None:
        raise ParameterError(
            "shear = 'auto' compares several k, each with a grid of its own, but thresholds are given. Leave them out, "
            "or give the number k that they are meant for."
        )
    choice = choose_shear(
        records,
        family=call.family,
        n=call.operators,
        eps=call.eps,
        max_inverse_gain=gain,
        initial_state="zero" if call.initial_state == "auto" else call.initial_state,
        train_fraction=call.split.train_fraction,
        weights=weights,
    )
    return choice.shear, choice


def _eps(
    call: Call, turned: tuple[Recording, ...], weights: tuple[Array, ...] | None, k: float, gain: float | None
) -> float:
    """Bound that keeps 1/w_1 - k within the gain: of w_1 for "pi", relative to the slope for the others."""
    data = prepare(turned, call.split, weights)
    slope = data.amplitude / data.half_range
    if gain is None:
        return min(call.eps, LARGEST_EPS * slope) if call.family == "pi" else call.eps
    bound = min(eps_of_gain(gain, k), slope)  # a line through the sheared loop has a gain of about zero
    return bound if call.family == "pi" else bound / slope


def _against(records: tuple[Recording, ...], turned: tuple[Recording, ...]) -> Measure:
    """Measure of the sheared loop, with the inverse's miss as a share of the range of the log's own input."""
    ratio = robust_range([record.input for record in turned]) / robust_range([record.input for record in records])
    whole = InMemory(turned)

    def measure(data: DataSet, bank: Bank, model: HysteresisModel, static: StaticCurve, turns: int) -> Measured:
        found = whole(data, bank, model, static, turns)
        test = found.input_test and found.input_test.times(ratio)
        train, curve = found.input_train.times(ratio), found.curve_input.times(ratio)
        return replace(found, input_train=train, input_test=test, curve_input=curve)

    return measure


def _card(fit: Fit, records: tuple[Recording, ...]) -> ModelCard:
    """Card with the log's own input instead of u + k y, and what the inverse misses of it."""
    first = records[0]
    low, high = range_over([record.input for record in records])
    inverse = {"rmse_percent": fit.certificate.inverse_miss_percent}
    card: ModelCard = fit.model.card
    provenance = {**card.provenance, "inverse": inverse}
    return replace(card, provenance=provenance, input=SignalCard(first.input_name, first.input_unit, low, high))


def _named(fit: Fit, k: float, record: Recording, chosen: bool) -> Fit:
    """Fit whose verdict says that the loop was sheared, and is no better than its inverse."""
    miss, warnings = fit.certificate.inverse_miss_percent, fit.warnings
    if miss > POOR_PERCENT:
        warnings += (
            Finding(
                "inverse-errs",
                f"the compensator misses the applied input by {of_range(miss)} its range (rms). The errors of the "
                f"output look better than they are, since a sheared loop sees the output in its input. Log more loops "
                f"of different size, or take the creep out of them with holds.",
            ),
        )
    return replace(fit, verdict=_verdict(fit, k, record, chosen), warnings=warnings)


def _verdict(fit: Fit, k: float, record: Recording, chosen: bool) -> str:
    """The judgement in one line: what counts is what the compensator misses of the log's own input."""
    certificate, judged = fit.certificate, fit.train if fit.test is None else fit.test
    where = "on the fitted samples (none held out)" if fit.test is None else "on held-out loops"
    grade, miss = fit.verdict.rpartition(": ")[2], certificate.inverse_miss_percent
    if grade_of(grade) is Grade.GOOD and miss > GOOD_PERCENT:
        grade = "usable with care" + (" (inverse-errs)." if miss > POOR_PERCENT else ".")
    family = "pi, the family that a shear takes" if chosen else fit.family
    return (
        f"loop sheared by k = {k:.4g}{unit_of_gain(record)}: {family}, {certificate.nonzero_weights} of "
        f"{certificate.operators} operators: its inverse, the compensator, gives the applied input back to "
        f"{of_range(miss)} its range rms {where} (the sheared loop itself, which sees the output in its input, "
        f"{judged.rmse_percent:.2f} % of the output's): {grade}"
    )


def _rivals(
    call: Call, records: tuple[Recording, ...], weights: tuple[Array, ...] | None, fit: Fit
) -> tuple[Finding, ...]:
    """Say if the inverse of the loop as it was logged misses less than that of the sheared one."""
    own, best, family = fit.certificate.inverse_miss_percent, float("inf"), ""
    for name in RIVALS:
        try:
            rival = solve_in_memory(replace(call, family=name), records, weights)
        except DehystError:
            continue  # a loop without its backbone need not be of any of them
        if rival.certificate.inverse_miss_percent < best:
            best, family = rival.certificate.inverse_miss_percent, name
    if not best < BETTER * own:
        return ()
    return (
        Finding(
            "shear-not-better",
            f"without a shear the inverse of family '{family}' gives the applied input back to {of_range(best)} its "
            f"range, the sheared one to {of_range(own)} it. A shear is for loops whose backbone was taken off. Leave "
            f"--shear out and take --family {family}.",
        ),
    )


def _with_settings(fit: Fit, more: dict[str, Any]) -> Fit:
    """Fit whose settings and card say what limits it."""
    settings = {**fit.settings, **more}
    card = fit.model.card
    provenance = {**card.provenance, "settings": settings, "verdict": fit.verdict}
    return replace(fit, settings=settings, model=fit.model.with_card(replace(card, provenance=provenance)))


def _checked(fit: Fit, gain: float | None) -> Fit:
    """Fit with a warning if its inverse is steeper than allowed."""
    found = fit.certificate.inverse_gain
    if gain is None or found <= gain * (1.0 + ROUNDING):
        return fit
    finding = Finding(
        "gain-exceeded",
        f"the inverse's gain is {found:.4g}, more than the {gain:g} that were allowed, and a firmer eps does not lower "
        f"it: an output map or the end of the sheared loop is as flat as that. Identify with --family pi, or another k "
        f"(--shear), or allow more.",
    )
    return replace(fit, warnings=(*fit.warnings, finding))
