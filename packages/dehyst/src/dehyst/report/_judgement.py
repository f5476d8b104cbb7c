"""Grades a fit in six aspects (accuracy, unseen data, inverse, ...): good, usable with care, do not use."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from dehyst.arrays import Array, rank
from dehyst.data import robust_range
from dehyst.findings import Grade
from dehyst.identification import POLICY, Fit, Score, hidden_by, of_range
from dehyst.models import SignalCard
from dehyst.report._parts import Light
from dehyst.report._policy import POLICY as LIGHTS
from dehyst.report._text import count, number, short, with_unit

# Limits between good and care, care and bad; those that decide the verdict are the identification's own.
RMSE_PERCENT = (POLICY.good_percent, POLICY.poor_percent)
BETTER_THAN_CURVE = (LIGHTS.better_than_curve, 1.0 / POLICY.static_as_good)
# RMS by which the inverse misses the applied input when it is given the measured output, percent of its range.
INVERSE_MISS = (POLICY.good_percent, POLICY.inverse_misses)
# Aspects of what keeps a verdict from being good; all others are about the data.
ABOUT = {"high-inverse-gain": "Inverse", "paper-bound": "Inverse", "forward-better": "Inverse"}


def lights(fit: Fit) -> tuple[Light, ...]:
    """Return the judgement of a fit, one light for each aspect."""
    judged = []
    for aspect, judge in ASPECTS.items():
        judged.append(_with_warnings(Light(aspect, *judge(fit)), fit))
    if fit.certificate.kkt_residual > LIGHTS.optimality:
        reason = f"KKT residual {number(fit.certificate.kkt_residual)}; below {LIGHTS.optimality:g} expected"
        judged.append(Light("Optimality", Grade.CARE, reason))
    if overall(fit) is Grade.BAD:
        return tuple(judged)
    # What the verdict does not forbid no light forbids.
    return tuple(replace(light, grade=min(light.grade, Grade.CARE)) for light in judged)


def _with_warnings(light: Light, fit: Fit) -> Light:
    """A light that is not good where a warning about its aspect keeps the verdict from being good."""
    if light.grade is not Grade.GOOD:
        return light
    serious = []
    for code in sorted(codes(fit) & POLICY.serious):
        if ABOUT.get(code, "The data") == light.aspect:
            serious.append(code)
    if not serious:
        return light
    reason = f"{light.reason}; read the warning {', '.join(serious)}"
    return replace(light, grade=Grade.CARE, reason=reason)


def overall(fit: Fit) -> Grade:
    """Return the grade of the whole: what the verdict says; for a fit made by hand, the same rule."""
    if fit.grade is not None:
        return fit.grade
    score, _ = _score(fit)
    present = codes(fit)
    unusable = POLICY.unusable - {"never-turns"}
    if not score.rmse_percent <= POLICY.poor_percent or present & unusable:
        return Grade.BAD
    if score.rmse_percent > POLICY.good_percent or fit.test is None or present & POLICY.serious:
        return Grade.CARE
    return Grade.GOOD


def codes(fit: Fit) -> set[str]:
    """Return the codes of all findings."""
    return {finding.code for finding in fit.warnings}


def _grade(value: float, limits: tuple[float, float], *, high_is_good: bool = False) -> Grade:
    """Grade of a number between a good and a bad limit."""
    good, bad = limits
    if high_is_good:
        value, good, bad = -value, -good, -bad
        if value == -math.inf:
            return Grade.GOOD
    if not math.isfinite(value) or value > bad:
        return Grade.BAD
    if value > good:
        return Grade.CARE
    return Grade.GOOD


def _score(fit: Fit) -> tuple[Score, str]:
    """The score that counts: unseen samples if there are any."""
    if fit.test is None:
        return fit.train, "fitted samples"
    return fit.test, "samples held out"


Judged = tuple[Grade, str]


def _accuracy(fit: Fit) -> Judged:
    """Judge the error of the output."""
    score, samples = _score(fit)
    reason = f"RMSE {number(score.rmse_percent)} % of the output's range on {samples}"
    return _grade(score.rmse_percent, RMSE_PERCENT), reason


def improvement(fit: Fit) -> float:
    """Return how many times smaller the error is than that of the best curve without hysteresis."""
    score, _ = _score(fit)
    static = fit.static_train
    if fit.static_test is not None and fit.test is not None:
        static = fit.static_test
    if score.rmse > 0.0:
        return static.rmse / score.rmse
    return math.inf


def curve_fits_better(fit: Fit) -> bool:
    """Whether the curve beats a model with memory on fitted samples, whatever the held-out ones say."""
    return (
        fit.test is not None
        and fit.certificate.operators > 0
        and fit.train.rmse > fit.static_train.rmse
    )


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
    reason = (
        f"error {number(times, 2)} times smaller than that of the best curve without hysteresis"
    )
    return grade, reason


def _unseen(fit: Fit) -> Judged:
    """Judge how much larger the error is on samples that were not fitted."""
    if fit.test is None:
        return Grade.CARE, "nothing was held out; the error on new motions is unknown"
    if "extrapolation" in codes(fit):
        return Grade.CARE, "the held-out input leaves the fitted range: a test of extrapolation"
    if fit.test.rmse <= 0.0 or fit.train.rmse <= 0.0:
        return Grade.GOOD, "no error worth comparing"
    ratio = fit.test.rmse / fit.train.rmse
    words = f"error on held-out samples is {number(ratio, 2)} times that on fitted ones"
    # Twice almost nothing is still almost nothing: a ratio is judged only where the error is felt.
    if not fit.test.rmse_percent < LIGHTS.felt:
        return min(_grade(ratio, LIGHTS.test_over_train), Grade.CARE), words
    if ratio > LIGHTS.test_over_train[0]:
        words += f", and below {LIGHTS.felt:g} % of range"
    return Grade.GOOD, words


def relative_gain(fit: Fit) -> float:
    """Return the gain of the inverse in ranges: how many % of the input's range 1 % of the output's can ask for."""
    outputs = [rec.output for rec in fit.recordings]
    return fit.certificate.inverse_gain * _span(outputs) / _input_range(fit)


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
    chosen = fit.test_masks
    if fit.test is None:
        chosen = fit.train_masks
    differences = []
    for recording, demanded, mask in zip(
        fit.recordings, fit.inverse_predictions, chosen, strict=True
    ):
        differences.append((demanded - recording.input)[mask])
    miss = np.concatenate(differences)
    return float(np.sqrt(np.mean(miss**2))), float(np.max(np.abs(miss)))


def _inverse(fit: Fit) -> Judged:
    if fit.model.no_inverse:
        grade = Grade.CARE if fit.model.winged else Grade.BAD
        return grade, f"there is none: {fit.model.no_inverse.rstrip('.')}"
    error, gain = fit.certificate.round_trip_error, relative_gain(fit)
    miss, curve = fit.input_error.rms_percent, fit.curve_input.rms_percent
    # A fit that was made by hand has no input error yet.
    if math.isnan(miss):
        miss = 100.0 * inverse_miss(fit)[0] / _input_range(fit)
    grade = _grade(miss, INVERSE_MISS)
    # An inverse that is worse than a curve's costs work and gains nothing.
    if rank(miss) > rank(curve):
        grade = max(grade, Grade.CARE)
    if not math.isnan(error):
        grade = max(grade, _grade(error, LIGHTS.round_trip))
    if codes(fit) & {"inverse-misses", "inverse-useless"}:
        grade = Grade.BAD
    words = f"misses the applied input by {of_range(miss)} its range (RMS)"
    if not math.isnan(error):
        words += f"; undoes the model to {number(error, 2)}"
    if "high-inverse-gain" in codes(fit):
        grade = max(grade, Grade.CARE)
        asked = f"after a turn 1 % of output can ask for {of_range(gain)} the input's range"
        words += f", but {asked}; smooth the reference"
    elif not math.isnan(gain):
        words += f"; 1 % of output asks for at most {number(gain, 2)} % of input"
    return grade, words


def _determined(fit: Fit) -> Judged:
    missing = len(fit.certificate.undetermined)
    if "never-turns" in codes(fit):
        return (
            Grade.BAD,
            "the input never turns in the fitted samples: one branch cannot show hysteresis",
        )
    if not fit.certificate.operators:
        return Grade.GOOD, "a curve has no operators; do not go beyond the logged range"
    # Only families of operators say how many of them carry weight.
    if " of " not in fit.size:
        return (
            Grade.GOOD,
            f"{fit.size}; its search does not tell which of them the samples leave open",
        )
    if missing == 0:
        return Grade.GOOD, f"all {fit.certificate.operators} {fit.word} moved in the fitted samples"
    grade = min(
        _grade(missing / max(1, fit.certificate.operators), LIGHTS.undetermined), Grade.CARE
    )
    reason = f"{missing} of {fit.certificate.operators} operators never moved; do not go beyond the logged range"
    return grade, reason


def _data(fit: Fit) -> Judged:
    """Judge the log by what was noticed in it."""
    facts, present = fit.facts, codes(fit)
    few = f"only {count(facts.loops, 'complete loop')}"
    noticed = {
        "clockwise": ["loops run clockwise, against what this family assumes"],
        "mixed-loop": ["loops run in both directions"],
        "rate-dependent": facts.depends,
        "drift": [f"{number(abs(facts.drift_percent), 2)} % of range drift"],
        "two-actuators": ["the actuator became another one within the log"],
        **{code: [few] for code in POLICY.few_loops},
        "small-test": ["too little is held out to test a model on"],
        "unknown-memory": ["some samples after gaps do not count"],
        "unknown-level": ["of some pieces after gaps the level is unknown"],
        "one-loop-size": ["all loops are of one size, so smaller ones are untested"],
    }
    # These families can be clockwise, so that nothing speaks against the data.
    if fit.family in ("stop", "pi-cumulative"):
        del noticed["clockwise"]
    reasons: list[str] = []
    for code, words in noticed.items():
        if code in present:
            reasons += words
    grade = Grade.GOOD
    if "two-actuators" in present:
        grade = Grade.BAD
    elif reasons:
        grade = Grade.CARE
    else:
        reasons.append(_looked_for(fit))
    return grade, "; ".join(filter(None, [*reasons, fit.lacking]))


def _looked_for(fit: Fit) -> str:
    """Say what was looked for in the log and was not there, and what the log cannot show.

    Where the model has terms of an effect, "no such effect" would contradict it: the effect is then called small.
    """
    facts = fit.facts
    loops = count(facts.loops, "complete loop")
    smallest, largest = facts.motion.smallest, facts.motion.largest
    if math.isfinite(smallest):
        loops += f" of {smallest:.0f} to {largest:.0f} % of the input's range"
    absent = ["drift from cycle to cycle"]
    small = []
    for evidence in facts.evidence:
        if not evidence.told or evidence.there:
            continue
        words = f"dependence on {evidence.words}"
        if fit.has_terms(evidence):
            small.append(f"{words} too small for a test, though the model has terms of it")
        else:
            absent.append(words)
    return "; ".join([f"{loops}, no {' and no '.join(absent)} found", *facts.depends, *small])


ASPECTS = {
    "Accuracy": _accuracy,
    "Against a curve": _against_curve,
    "Unseen data": _unseen,
    "Inverse": _inverse,
    "Determined": _determined,
    "The data": _data,
}


def in_words(fit: Fit, judged: tuple[Light, ...]) -> tuple[str, ...]:
    """Return the plain-language reading of the fit, a few sentences."""
    score, scored = _score(fit)
    grades = {light.aspect: light.grade for light in judged}
    rec = fit.recordings[0]
    samples = sum(map(len, fit.recordings))
    logs = ""
    if len(fit.recordings) > 1:
        logs = f" in {len(fit.recordings)} logs"
    says = [
        f"From {samples} samples{logs}, with {count(fit.facts.loops, 'complete loop')}, dehyst identified a model of "
        f"family {fit.family} with {count(fit.certificate.nonzero_weights, 'weight')}. On {scored} it is typically "
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
        says.append(
            "A simple curve without hysteresis does as well: use that, or look for what else moves the output."
        )
    elif curve_fits_better(fit):
        says.append("On the fitted samples a simple curve without hysteresis does as well.")
    elif math.isfinite(times):
        says.append(f"The best curve without hysteresis is {number(times, 2)} times worse.")
    if fit.model.winged:
        says.append("It has an inverse on either wing of the loop, and none on both.")
    elif fit.model.no_inverse:
        says.append(
            "It has no inverse: it predicts what the actuator does, and cannot compensate it."
        )
    elif overall(fit) is Grade.BAD or grades["Inverse"] is Grade.BAD:
        says.append("Its inverse should not drive a machine as it is; the lights below say why.")
    else:
        says.append("Its inverse can drive the actuator, within the range of this log:")
        says[-1] += f" {_range(fit, 'input')}, {_range(fit, 'output')}."
    weak = [f"“{light.aspect}”" for light in judged if light.grade is not Grade.GOOD]
    if weak:
        says.append(f"Before you rely on it, read below: {', '.join(weak)}.")
    return tuple(says)


def _range(fit: Fit, role: str) -> str:
    signal = np.concatenate([getattr(rec, role) for rec in fit.recordings])
    low, high = float(np.min(signal)), float(np.max(signal))
    rec = fit.recordings[0]
    name, unit = getattr(rec, f"{role}_name"), getattr(rec, f"{role}_unit")
    return f"{short(name, 40)} {number(low)} to {with_unit(high, unit)}"
