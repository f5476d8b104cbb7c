"""Identification within a bound of the inverse's gain, and of the sheared loop y = H[u + k y]."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

from dehyst.data import Recording, robust_range
from dehyst.errors import ParameterError
from dehyst.findings import Finding, Grade
from dehyst.identification._candidates.plays import PlaysFamily
from dehyst.identification._cautions import of_range, unit_of_gain
from dehyst.identification._data import DataSet, input_range, inputs_of
from dehyst.identification._fit import Fit
from dehyst.identification._policy import POLICY
from dehyst.identification._prepared import Prepared
from dehyst.identification._regressors import PlayBank
from dehyst.identification._scores import Measure, Measured
from dehyst.models import (
    HysteresisModel,
    ModelCard,
    PrandtlIshlinskii,
    ShearedPrandtlIshlinskii,
    SignalCard,
    StaticCurve,
)
from dehyst.models import kit as models_kit

# The paper's eps has units: in those of another log, or with a large k, it may exceed the slope itself.
LARGEST_EPS = 0.01
SHEARED_FAMILIES = ("pi", "pi-cumulative")


def eps_of_gain(gain: float, shear: float = 0.0) -> float:
    """Return the bound of the first weight that keeps |1/w_1| - |k| <= G: eps = 1/(G + |k|). [output/input].

    Examples
    --------
    >>> eps_of_gain(20.0), eps_of_gain(20.0, shear=5.0)
    (0.05, 0.04)
    """
    gain = models_kit.parameter_number(gain, "max_inverse_gain")
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
    turned = []
    for record in records:
        x = record.input + k * record.output
        name = f"{record.input_name} + {k:.4g} {record.output_name}"
        turned.append(replace(record, input=x, input_name=name))
    return tuple(turned)


# An output map multiplies the gain of the operator in front of it: eps is raised until their product fits.
TRIES = 4
ROUNDING = 1e-9


def identify_within(call: PlaysFamily, log: Prepared, gain: float) -> Fit:
    """Fit with the eps that keeps the inverse's gain within G, and check that it does. [input/output]"""
    slope = log.data.amplitude / log.data.half_range
    eps = eps_of_gain(gain)
    if eps > slope:
        unit = unit_of_gain(log.records[0])
        raise ParameterError(
            f"max_inverse_gain = {gain:g}{unit} is less than a straight line through this log needs, "
            f"{1.0 / slope:.3g}{unit}. Pass more, for example {3.0 / slope:.1g}: right after a reversal the inverse is "
            f"steeper than on average.",
            gain=gain,
            slope=slope,
        )
    # Its eps is in units of the log, that of the others relative.
    exact = call.family == "pi"
    if not exact:
        eps /= slope
    fit = log.fit(replace(call, eps=eps, choose_eps=False))
    for _ in range(TRIES):
        excess = fit.certificate.inverse_gain / gain
        if excess <= 1.0 + ROUNDING or exact or eps * excess > 1.0:
            break
        eps *= excess
        fit = log.fit(replace(call, eps=eps, choose_eps=False))
    return _checked(_with_settings(fit, {"max_inverse_gain": gain}), gain)


def identify_sheared(call: PlaysFamily, log: Prepared, shear: float, gain: float | None) -> Fit:
    """Fit y = H[u + k y] and return the sheared model, judged by what its inverse misses of u."""
    family_chosen = call.family == "auto"
    if family_chosen:
        call = replace(call, family="pi")
    check_family(call.family)
    if gain is not None:
        eps_of_gain(gain)
    records = log.records
    k = _scale(shear, records[0])
    turned = sheared(records, k)
    turned_log = Prepared(turned, log.split, (), ShearedMeasure(records, turned), log.weights)
    call = replace(call, eps=_eps(call, turned_log.data, k, gain), choose_eps=False)
    fit = turned_log.fit(call)
    model = ShearedPrandtlIshlinskii(cast(PrandtlIshlinskii, fit.model), k, _card(fit, records))
    certificate = replace(fit.certificate, inverse_gain=model.inverse_gain)
    fit = replace(fit, model=model, certificate=certificate)
    fit = _named(fit, k, records[0], family_chosen)
    limits: dict[str, Any] = {"shear": k}
    if gain is not None:
        limits["max_inverse_gain"] = gain
    return _checked(_with_settings(fit, limits), gain)


def _scale(shear: object, record: Recording) -> float:
    """Return k as a number."""
    try:
        return models_kit.parameter_number(float(shear), "shear")  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise ParameterError(
            f"shear = {shear!r:.40} is no number; it is k of u + k y, in "
            f"{unit_of_gain(record).strip() or 'units of input over output'}. dehyst.cross_validate(..., shear=[1, 2, "
            f"5, 10]) compares several.",
            shear=shear,
        ) from None


def _eps(call: PlaysFamily, data: DataSet, k: float, gain: float | None) -> float:
    """Bound that keeps 1/w_1 - k within the gain: of w_1 for "pi", relative to the slope for the others."""
    slope = data.amplitude / data.half_range
    if gain is None and call.family == "pi":
        return min(call.eps, LARGEST_EPS * slope)
    if gain is None:
        return call.eps
    # A line through the sheared loop has a gain of about zero.
    bound = min(eps_of_gain(gain, k), slope)
    if call.family == "pi":
        return bound
    return bound / slope


class ShearedMeasure(Measure):
    """Measure of the sheared loop, with the inverse's miss as a share of the range of the log's own input."""

    def __init__(self, records: tuple[Recording, ...], turned: tuple[Recording, ...]) -> None:
        super().__init__(turned)
        range_of_log = robust_range(inputs_of(records))
        self._ratio = robust_range(inputs_of(turned)) / range_of_log

    def __call__(
        self, data: DataSet, bank: PlayBank, model: HysteresisModel, static: StaticCurve, turns: int
    ) -> Measured:
        """Compare a model whose memory before each piece a bank tells."""
        measured = super().__call__(data, bank, model, static, turns)
        test = measured.input_test and measured.input_test.times(self._ratio)
        train = measured.input_train.times(self._ratio)
        curve = measured.curve_input.times(self._ratio)
        return replace(measured, input_train=train, input_test=test, curve_input=curve)


def _card(fit: Fit, records: tuple[Recording, ...]) -> ModelCard:
    """Card with the log's own input instead of u + k y, and what the inverse misses of it."""
    first = records[0]
    low, high = input_range(records)
    inverse = {"rmse_percent": fit.certificate.inverse_miss_percent}
    card: ModelCard = fit.model.card
    provenance = {**card.provenance, "inverse": inverse}
    return replace(
        card, provenance=provenance, input=SignalCard(first.input_name, first.input_unit, low, high)
    )


def _named(fit: Fit, k: float, record: Recording, chosen: bool) -> Fit:
    """Fit whose verdict says that the loop was sheared, and is no better than its inverse."""
    miss, warnings = fit.certificate.inverse_miss_percent, fit.warnings
    if miss > POLICY.poor_percent:
        warnings += (
            Finding(
                "inverse-errs",
                f"the compensator misses the applied input by {of_range(miss)} its range (rms). The errors of the "
                f"output look better than they are, since a sheared loop sees the output in its input. Log more loops "
                f"of different size, or take the creep out of them with holds.",
            ),
        )
    grade, verdict = _verdict(fit, k, record, chosen)
    return replace(fit, verdict=verdict, grade=grade, warnings=warnings)


def _verdict(fit: Fit, k: float, record: Recording, chosen: bool) -> tuple[Grade | None, str]:
    """The grade, and the judgement in one line: what counts is what the compensator misses of the log's own input."""
    certificate, judged = fit.certificate, fit.train
    scored_on = "on the fitted samples (none held out)"
    if fit.test is not None:
        judged = fit.test
        scored_on = "on held-out loops"
    grade, miss = fit.grade, certificate.inverse_miss_percent
    ending = fit.verdict.rpartition(": ")[2]
    # A sheared loop sees the output in its input, so only the inverse can call the model good.
    if grade is Grade.GOOD and miss > POLICY.good_percent:
        grade = Grade.CARE
        ending = "usable with care."
        if miss > POLICY.poor_percent:
            ending = "usable with care (inverse-errs)."
    family = fit.family
    if chosen:
        family = "pi, the family that a shear takes"
    return grade, (
        f"loop sheared by k = {k:.4g}{unit_of_gain(record)}: {family}, {certificate.nonzero_weights} of "
        f"{certificate.operators} operators: its inverse, the compensator, gives the applied input back to "
        f"{of_range(miss)} its range rms {scored_on} (the sheared loop itself, which sees the output in its input, "
        f"{judged.rmse_percent:.2f} % of the output's): {ending}"
    )


def _with_settings(fit: Fit, more: dict[str, Any]) -> Fit:
    """Fit whose settings and card say what limits it."""
    settings = {**fit.settings, **more}
    card = fit.model.card
    provenance = {
        **card.provenance,
        "settings": settings,
        "verdict": fit.verdict,
        "grade": str(fit.grade),
    }
    return replace(
        fit, settings=settings, model=fit.model.with_card(replace(card, provenance=provenance))
    )


def _checked(fit: Fit, gain: float | None) -> Fit:
    """Fit with a warning if its inverse is steeper than allowed."""
    steepest = fit.certificate.inverse_gain
    if gain is None or steepest <= gain * (1.0 + ROUNDING):
        return fit
    finding = Finding(
        "gain-exceeded",
        f"the inverse's gain is {steepest:.4g}, more than the {gain:g} that were allowed, and a firmer eps does not "
        f"lower it: an output map or the end of the sheared loop is as flat as that. Identify with --family pi, or "
        f"another k (--shear), or allow more.",
    )
    return replace(fit, warnings=(*fit.warnings, finding))
