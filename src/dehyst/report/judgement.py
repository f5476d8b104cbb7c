"""Grades a fit in six aspects (accuracy, unseen data, inverse, ...): good, usable with care, do not use."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from dehyst.arrays import Array, rank
from dehyst.data.ranges import robust_range
from dehyst.findings import Grade, grade_of
from dehyst.identification.cautions import INVERSE_MISSES, POOR_PERCENT, hidden_by, of_range
from dehyst.identification.certify import FEW_LOOPS, GOOD_PERCENT, SERIOUS, UNUSABLE
from dehyst.identification.fit import Fit, Score, word_of
from dehyst.identification.selection import STATIC_AS_GOOD
from dehyst.models import SignalCard
from dehyst.report.parts import Light
from dehyst.report.text import count, number, short, with_unit

# Limits between good and care, care and bad; those that decide the verdict are the identification's own.
RMSE_PERCENT = (GOOD_PERCENT, POOR_PERCENT)
BETTER_THAN_CURVE = (1.5, 1.0 / STATIC_AS_GOOD)
TEST_OVER_TRAIN = (2.0, 5.0)
FELT = 1.0  # percent of range
ROUND_TRIP = (1e-9, 1e-6)
# RMS by which the inverse misses the applied input when it is given the measured output, percent of its range.
INVERSE_MISS = (GOOD_PERCENT, INVERSE_MISSES)
# Aspects of what keeps a verdict from being good; all others are about the data.
ABOUT = {"high-inverse-gain": "Inverse", "paper-bound": "Inverse", "forward-better": "Inverse"}
KKT = 1e-9
UNDETERMINED_SHARE = (0.1, 0.5)


def lights(fit: Fit) -> tuple[Light, ...]:
    """Return the judgement of a fit, one light for each aspect."""
    found = [Light(aspect, *judge(fit)) for aspect, judge in ASPECTS.items()]
    found = [_with_warnings(light, fit) for light in found]
    if fit.certificate.kkt_residual > KKT:
        reason = f"KKT residual {number(fit.certificate.kkt_residual)}; below {KKT:g} expected"
        found.append(Light("Optimality", Grade.CARE, reason))
    if overall(fit) is not Grade.BAD:  # what the verdict does not forbid no light forbids
        found = [replace(light, grade=min(light.grade, Grade.CARE)) for light in found]
    return tuple(found)


def _with_warnings(light: Light, fit: Fit) -> Light:
    """A light that is not good where a warning about its aspect keeps the verdict from being good."""
    serious = sorted(code for code in codes(fit) & SERIOUS if ABOUT.get(code, "The data") == light.aspect)
    if light.grade is not Grade.GOOD or not serious:
        return light
    return replace(light, grade=Grade.CARE, reason=f"{light.reason}; read the warning {', '.join(serious)}")


def overall(fit: Fit) -> Grade:
    """Return the grade of the whole: what the verdict says; for a fit made by hand, the same rule."""
    said = grade_of(fit.verdict)
    if said is not None:
        return said
    score = fit.train if fit.test is None else fit.test
    found = codes(fit)
    if not score.rmse_percent <= POOR_PERCENT or found & (UNUSABLE - {"never-turns"}):
        return Grade.BAD
    if score.rmse_percent <= GOOD_PERCENT and fit.test is not None and not found & SERIOUS:
        return Grade.GOOD
    return Grade.CARE


def codes(fit: Fit) -> set[str]:
    """Return the codes of all findings."""
    return {finding.code for finding in fit.warnings}


def _grade(value: float, limits: tuple[float, float], *, high_is_good: bool = False) -> Grade:
    good, bad = limits
    if not math.isfinite(value):
        return Grade.GOOD if high_is_good and value > 0 else Grade.BAD
    if high_is_good:
        value, good, bad = -value, -good, -bad
    return Grade.GOOD if value <= good else Grade.CARE if value <= bad else Grade.BAD


def _score(fit: Fit) -> tuple[Score, str]:
    """The score that counts: unseen samples if there are any."""
    return (fit.train, "fitted samples") if fit.test is None else (fit.test, "samples held out")


Judged = tuple[Grade, str]


def _accuracy(fit: Fit) -> Judged:
    score, where = _score(fit)
    reason = f"RMSE {number(score.rmse_percent)} % of the output's range on {where}"
    return _grade(score.rmse_percent, RMSE_PERCENT), reason


def improvement(fit: Fit) -> float:
    """Return how many times smaller the error is than that of the best curve without hysteresis."""
    score, _ = _score(fit)
    static = fit.static_train if fit.static_test is None or fit.test is None else fit.static_test
    return static.rmse / score.rmse if score.rmse > 0.0 else math.inf


def curve_fits_better(fit: Fit) -> bool:
    """Whether the curve beats a model with memory on fitted samples, whatever the held-out ones say."""
    return fit.test is not None and fit.certificate.operators > 0 and fit.train.rmse > fit.static_train.rmse


def _against_curve(fit: Fit) -> Judged:
    if not fit.certificate.operators:
        return Grade.GOOD, "the model is the curve: none with memory did better"
    times = improvement(fit)
    grade = _grade(times, BETTER_THAN_CURVE, high_is_good=True)
    if curve_fits_better(fit) and times >= 1.0 and "static-as-good" not in codes(fit):
        reason = (
            f"on samples held out its error is {number(times, 2)} times smaller than that of the best curve without "
            f"hysteresis, but on those fitted the curve is as good: {number(fit.static_train.rmse_percent)} against "
            f"{number(fit.train.rmse_percent)} % of range"
        )
        return max(Grade.CARE, grade), reason
    if "static-as-good" in codes(fit):
        grade = Grade.BAD
    if grade is Grade.BAD:
        return grade, "a curve without hysteresis is as good; the model adds nothing"
    reason = f"error {number(times, 2)} times smaller than that of the best curve without hysteresis"
    return grade, reason


def _unseen(fit: Fit) -> Judged:
    if fit.test is None:
        return Grade.CARE, "nothing was held out; the error on new motions is unknown"
    if "extrapolation" in codes(fit):
        return Grade.CARE, "the held-out input leaves the fitted range: a test of extrapolation"
    if fit.test.rmse <= 0.0 or fit.train.rmse <= 0.0:
        return Grade.GOOD, "no error worth comparing"
    ratio = fit.test.rmse / fit.train.rmse
    # Twice almost nothing is still almost nothing: a ratio is judged only where the error is felt.
    small = fit.test.rmse_percent < FELT
    grade = Grade.GOOD if small else min(_grade(ratio, TEST_OVER_TRAIN), Grade.CARE)
    words = f"error on held-out samples is {number(ratio, 2)} times that on fitted ones"
    return grade, f"{words}, and below {FELT:g} % of range" if small and ratio > TEST_OVER_TRAIN[0] else words


def relative_gain(fit: Fit) -> float:
    """Return the gain of the inverse in ranges: how many % of the input's range 1 % of the output's can ask for."""
    return fit.certificate.inverse_gain * _span([rec.output for rec in fit.recordings]) / _input_range(fit)


def _input_range(fit: Fit) -> float:
    """Range of the log's own input, which a sheared fit shows as u + k y."""
    card: SignalCard = fit.model.card.input
    if fit.model.shear is not None and card.low is not None and card.high is not None:
        return max(card.high - card.low, 5e-324)
    return _span([rec.input for rec in fit.recordings])


def _span(signals: list[Array]) -> float:
    """Range over all recordings; the smallest positive number for a constant, which never passes identification."""
    return max(robust_range(signals), 5e-324)


def inverse_miss(fit: Fit) -> tuple[float, float]:
    """Return RMS and largest difference of the input asked for and the input applied.

    Over held-out samples, or over the fitted ones if none were held out. [input]
    """
    chosen = fit.train_masks if fit.test is None else fit.test_masks
    miss = np.concatenate(
        [
            (demanded - recording.input)[mask]
            for recording, demanded, mask in zip(fit.recordings, fit.inverse_predictions, chosen, strict=True)
        ]
    )
    return float(np.sqrt(np.mean(miss**2))), float(np.max(np.abs(miss)))


def _inverse(fit: Fit) -> Judged:
    if fit.model.no_inverse:
        return Grade.BAD, f"there is none: {fit.model.no_inverse.rstrip('.')}"
    error, gain = fit.certificate.round_trip_error, relative_gain(fit)
    miss, curve = fit.input_error.rms_percent, fit.curve_input.rms_percent
    if math.isnan(miss):  # of a fit made by hand
        miss = 100.0 * inverse_miss(fit)[0] / _input_range(fit)
    grade = _grade(miss, INVERSE_MISS)
    if rank(miss) > rank(curve):
        grade = max(grade, Grade.CARE)
    if not math.isnan(error):
        grade = max(grade, _grade(error, ROUND_TRIP))
    if codes(fit) & {"inverse-misses", "inverse-useless"}:
        grade = Grade.BAD
    reason = (
        f"misses the applied input by {of_range(miss)} its range (RMS)"
        f"{'' if math.isnan(error) else f'; undoes the model to {number(error, 2)}'}"
    )
    if "high-inverse-gain" in codes(fit):
        grade = max(grade, Grade.CARE)
        reason += (
            f", but after a turn 1 % of output can ask for {of_range(gain)} the input's range; smooth the reference"
        )
    elif not math.isnan(gain):
        reason += f"; 1 % of output asks for at most {number(gain, 2)} % of input"
    return grade, reason


def _determined(fit: Fit) -> Judged:
    missing = len(fit.certificate.undetermined)
    if "never-turns" in codes(fit):
        return Grade.BAD, "the input never turns in the fitted samples: one branch cannot show hysteresis"
    if not fit.certificate.operators:
        return Grade.GOOD, "a curve has no operators; do not go beyond the logged range"
    if " of " not in fit.size:
        return Grade.GOOD, f"{fit.size}; its search does not tell which of them the samples leave open"
    if missing == 0:
        return Grade.GOOD, f"all {fit.certificate.operators} {word_of(fit.model)} moved in the fitted samples"
    grade = min(_grade(missing / max(1, fit.certificate.operators), UNDETERMINED_SHARE), Grade.CARE)
    reason = f"{missing} of {fit.certificate.operators} operators never moved; do not go beyond the logged range"
    return grade, reason


def _data(fit: Fit) -> Judged:
    facts, found = fit.facts, codes(fit)
    fits_clockwise = fit.family in ("stop", "pi-cumulative")
    noticed = {
        "clockwise": [] if fits_clockwise else ["loops run clockwise, against what this family assumes"],
        "mixed-loop": ["loops run in both directions"],
        "rate-dependent": facts.depends,
        "drift": [f"{number(abs(facts.drift_percent), 2)} % of range drift"],
        "two-actuators": ["the actuator became another one within the log"],
        **{code: [f"only {count(facts.loops, 'complete loop')}"] for code in FEW_LOOPS},
        "small-test": ["too little is held out to test a model on"],
        "unknown-memory": ["some samples after gaps do not count"],
        "unknown-level": ["of some pieces after gaps the level is unknown"],
        "one-loop-size": ["all loops are of one size, so smaller ones are untested"],
    }
    reasons = [words for code, said in noticed.items() if code in found for words in said]
    grade = Grade.GOOD
    if reasons:
        grade = Grade.BAD if "two-actuators" in found else Grade.CARE
    return grade, "; ".join(filter(None, [*(reasons or [_looked_for(fit)]), fit.lacking]))


def _looked_for(fit: Fit) -> str:
    """What was looked for, and whether it was found; what the log cannot tell is said beside it.

    That something was not found is no news beside a model that has terms of it.
    """
    facts = fit.facts
    sizes = facts.motion.smallest, facts.motion.largest
    loops = count(facts.loops, "complete loop")
    if math.isfinite(sizes[0]):
        loops += f" of {sizes[0]:.0f} to {sizes[1]:.0f} % of the input's range"
    absent = ["drift from cycle to cycle"]
    missing = [each for each in facts.evidence if each.told and not each.there]
    absent += [f"dependence on {each.words}" for each in missing if not fit.has_terms(each)]
    small = [
        f"dependence on {each.words} too small for a test, though the model has terms of it"
        for each in missing
        if fit.has_terms(each)
    ]
    return "; ".join([f"{loops}, no {' and no '.join(absent)} found", *facts.depends, *small])


ASPECTS = {
    "Accuracy": _accuracy,
    "Against a curve": _against_curve,
    "Unseen data": _unseen,
    "Inverse": _inverse,
    "Determined": _determined,
    "The data": _data,
}


def in_words(fit: Fit, found: tuple[Light, ...]) -> tuple[str, ...]:
    """Return the plain-language reading of the fit, a few sentences."""
    score, where = _score(fit)
    grades = {light.aspect: light.grade for light in found}
    rec = fit.recordings[0]
    samples = sum(len(r) for r in fit.recordings)
    logs = "" if len(fit.recordings) == 1 else f" in {len(fit.recordings)} logs"
    says = [
        f"From {samples} samples{logs}, with {count(fit.facts.loops, 'complete loop')}, dehyst identified a model of "
        f"family {fit.family} with {count(fit.certificate.nonzero_weights, 'weight')}. On {where} it is typically "
        f"{with_unit(score.rmse, rec.output_unit)} off ({number(score.rmse_percent)} % of the output's range), "
        f"{with_unit(score.max, rec.output_unit)} at worst."
    ]
    times = improvement(fit)
    if not fit.certificate.operators:
        hidden = hidden_by(codes(fit))
        why = "hysteresis was not found on loops held out, or does not repeat"
        if hidden:
            why = f"a loop may be hidden by what the warning {hidden} says"
        elif fit.facts.has_loop:
            why = "there is a loop, but no model with memory did better on parts of it that were left out"
        says.append(f"It is a curve without memory: {why}.")
    elif grades["Against a curve"] is Grade.BAD:
        says.append("A simple curve without hysteresis does as well: use that, or look for what else moves the output.")
    elif curve_fits_better(fit):
        says.append("On the fitted samples a simple curve without hysteresis does as well.")
    elif math.isfinite(times):
        says.append(f"The best curve without hysteresis is {number(times, 2)} times worse.")
    if fit.model.no_inverse:
        says.append("It has no inverse: it predicts what the actuator does, and cannot compensate it.")
    elif overall(fit) is Grade.BAD or grades["Inverse"] is Grade.BAD:
        says.append("Its inverse should not drive a machine as it is; the lights below say why.")
    else:
        says.append("Its inverse can drive the actuator, within the range of this log:")
        says[-1] += f" {_range(fit, 'input')}, {_range(fit, 'output')}."
    weak = [f"“{light.aspect}”" for light in found if light.grade is not Grade.GOOD]
    if weak:
        says.append(f"Before you rely on it, read below: {', '.join(weak)}.")
    return tuple(says)


def _range(fit: Fit, role: str) -> str:
    signals = [rec.input if role == "input" else rec.output for rec in fit.recordings]
    rec = fit.recordings[0]
    name, unit = (rec.input_name, rec.input_unit) if role == "input" else (rec.output_name, rec.output_unit)
    low, high = min(float(np.min(s)) for s in signals), max(float(np.max(s)) for s in signals)
    return f"{short(name, 40)} {number(low)} to {with_unit(high, unit)}"
