"""Judges what a candidate made of a log: scores, findings, grade and verdict, the card of the model."""

from __future__ import annotations

import datetime as _datetime
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from dehyst.arrays import rank
from dehyst.data import Loops
from dehyst.families.kit import Butterfly
from dehyst.findings import Finding, Grade
from dehyst.identification import _facts as facts
from dehyst.identification._candidate import Outcome
from dehyst.identification._cautions import (
    Knows,
    about_data,
    about_fit,
    hidden_by,
    no_hysteresis,
    of_range,
    unrelated,
    with_reasons,
)
from dehyst.identification._data import DataSet, input_range, output_range
from dehyst.identification._families import STATIC
from dehyst.identification._fit import Certificate, Fit, LoopFacts, Score, codes_of, size_of
from dehyst.identification._policy import POLICY
from dehyst.identification._scores import Measured
from dehyst.identification._settings import is_papers
from dehyst.identification._split import tested_on
from dehyst.models import ModelCard, SignalCard, StaticCurve
from dehyst.version import __version__


def _examine(
    data: DataSet,
    seen: Seen,
    measured: Measured,
    certificate: Certificate,
    knows: Knows,
    settings: Mapping[str, Any],
) -> tuple[LoopFacts, tuple[Finding, ...]]:
    """What the data shows and every finding a user should know, those of reading the log first."""
    change, doubt = measured.drift
    loops, turns = seen.counts
    if settings.get("family") == "auto":  # which has tried what leads
        knows = replace(knows, leads=True)
    turns_at = None
    if seen.butterfly is not None:
        places = data.center + data.half_range * np.array(seen.butterfly[:2])
        turns_at = (float(places[0]), float(places[1]))
    loop_facts = LoopFacts(
        orientation=seen.loop.name,
        trend=data.trend,
        width_percent=seen.opening_percent,
        loops=loops,
        turns=turns,
        drift_percent=-100.0 * change / data.output_range,
        motion=seen.motion,
        evidence=measured.evidence,
        numbers=seen.numbers,
        butterfly=turns_at,
    )
    span = input_range(measured.recordings)
    judged = list(about_data(data, loop_facts, abs(change), doubt, knows, span))
    judged += about_fit(
        data,
        measured,
        certificate,
        is_papers(settings),
        settings["train_fraction"] < 1.0,
        knows,
        turns,
        seen.loop.name == "clockwise",
    )
    # What moves an unrelated output looks like another actuator, or like drift.
    silent = POLICY.drifts if unrelated(measured) else frozenset()
    unique: dict[tuple[str, str], Finding] = {}
    for record in measured.recordings:
        for finding in record.findings:
            # Reading counts the loops of a whole log; here they are counted in what is fitted, and said with that.
            if finding.code not in POLICY.few_loops:
                unique[finding.code, finding.message] = finding
    for finding in judged:
        if finding.code not in silent:
            unique[finding.code, finding.message] = finding
    return loop_facts, tuple(unique.values())


def grade_and_verdict(
    name: str,
    measured: Measured,
    findings: tuple[Finding, ...],
    tested: str,
    no_inverse: str = "",
    has_loop: bool = False,
    winged: bool = False,
) -> tuple[Grade, str]:
    """The grade, and the judgement in one line; `name` is the family and its size, `tested` says what was held out.

    A compensator is good if its input error is: within 3 % of the input's range, and no worse than that of the curve's
    inverse. Within that bound only what does harm on the next motion forbids it. A `winged` model, without an inverse
    over its whole range, has one on either wing, which nobody has tested.
    """
    codes = codes_of(findings)
    test, judged, static = measured.test, measured.train, measured.static_train
    scored_on = "on the fitted samples (none held out)"
    if test is not None:
        judged = test
        scored_on = f"on {tested}"
    if measured.static_test is not None:
        static = measured.static_test
    inverse, curve = measured.input_error.rms_percent, measured.curve_input.rms_percent
    against = sorted(codes & (POLICY.serious | POLICY.unusable))
    if inverse > POLICY.good_percent:
        against.append(f"its inverse misses by more than {POLICY.good_percent:g} %")
    elif rank(inverse) > rank(curve):
        against.append(
            f"the inverse of a curve without hysteresis misses less, {of_range(curve)} range"
        )
    if codes & POLICY.harmful or (codes & POLICY.unusable and inverse > POLICY.good_percent):
        grade = Grade.BAD
        ending = f"do not compensate with it ({', '.join(sorted(codes & POLICY.unusable))})"
    elif judged.rmse_percent <= POLICY.good_percent and test is not None and not against:
        grade = Grade.GOOD
        ending = "good for compensation"
    else:
        grade = Grade.CARE
        ending = "usable with care"
        reasons = reasons_of(judged, test is not None, against)
        if reasons:
            ending += f" ({reasons})"
    errs, curve_errs = _rms(judged.rmse_percent), _rms(static.rmse_percent)
    if "output-unrelated" in codes:
        return grade, (
            f"the output does not follow this input: {name} misses by {errs} {scored_on}, the best curve without "
            f"hysteresis by {curve_errs}: {ending}."
        )
    if no_inverse:
        grade, advice = Grade.BAD, "do not compensate with it. It has no inverse"
        if winged and not codes & POLICY.unusable:
            grade, advice = Grade.CARE, "compensate with it on one wing. On both it has no inverse"
        return grade, (
            f"{name}: {errs} {scored_on}, against {_bare(static.rmse_percent)} for the "
            f"best curve without hysteresis: simulate with it, {advice}: {no_inverse.rstrip('.')}."
        )
    gives = f"gives the applied input back to {of_range(inverse)} its range"
    if name == STATIC:
        hidden = hidden_by(codes)
        why = ""
        if "no-hysteresis" in codes and hidden:
            why = f"; a loop may be hidden ({hidden})"
        elif "no-hysteresis" in codes and has_loop:
            why = "; there is a loop, but no model with memory did better on parts left out"
        elif "no-hysteresis" in codes:
            why = "; hysteresis was not found, or does not repeat"
        return grade, (
            f"static, a curve without memory: {errs} {scored_on}; its inverse {gives}{why}: {ending}."
        )
    return grade, (
        f"{name}: {errs} {scored_on}, against {_bare(static.rmse_percent)} for the best "
        f"curve without hysteresis; the inverse {gives}: {ending}."
    )


def _rms(percent: float) -> str:
    """An error as the verdict says it: a percentage of a range, or how many times it."""
    if percent < 100.0:
        return f"{percent:.2f} % of range rms"
    return f"{of_range(percent)} the range rms"


def _bare(percent: float) -> str:
    if percent < 100.0:
        return f"{percent:.2f} %"
    return f"{of_range(percent)} it"


def reasons_of(judged: Score, held_out: bool, serious: list[str]) -> str:
    """Why a model is to be used with care."""
    reasons = list(serious)
    if not judged.rmse_percent <= POLICY.good_percent:
        reasons.append(f"its output errs by more than {POLICY.good_percent:g} %")
    if not held_out:
        reasons.append("nothing held out")
    return ", ".join(reasons)


class Seen(NamedTuple):
    """What the fitted part shows: orientation, loops and turning points, motion of the input; numbers of all loops."""

    loop: facts.Orientation
    counts: tuple[int, int]
    motion: facts.Motion
    numbers: Loops | None
    butterfly: Butterfly | None = None

    @property
    def opening_percent(self) -> float:
        """Of the largest loops; without a closed one, of branches that rise and fall."""
        if self.numbers is None:
            return 100.0 * self.loop.width
        return self.numbers.estimates["opening_percent"].value


def seen_in(
    pieces: tuple[facts.Branches, ...], numbers: Loops | None, butterfly: Butterfly | None
) -> Seen:
    """Say what the branches of the fitted part show."""
    counts, motion = facts.count_loops(pieces), facts.motion(pieces)
    return Seen(facts.orientation(pieces), counts, motion, numbers, butterfly)


def judge(data: DataSet, seen: Seen, outcome: Outcome) -> Fit:
    """Return the fit of an outcome of any family: scores, findings, grade and verdict, provenance.

    Parameters
    ----------
    data
        The log, scaled.
    seen
        What its fitted part shows.
    outcome
        What a candidate made of it.
    """
    model, family, static = outcome.model, outcome.family, outcome.static
    measured = outcome.measure(seen.counts[1])
    certificate = replace(
        outcome.certificate,
        round_trip_error=measured.round_trip,
        inverse_miss_percent=measured.input_error.rms_percent,
    )
    settings = outcome.settings
    loop_facts, findings = _examine(data, seen, measured, certificate, outcome.knows, settings)
    codes = codes_of(findings)
    findings += tuple(outcome.remarks(measured))
    if family == STATIC and outcome.compared:
        span = input_range(measured.recordings)
        findings += (no_hysteresis(outcome.compared, span, codes, loop_facts),)
    findings = with_reasons(findings)
    terms = certificate.operators
    name = STATIC
    if terms:
        name = f"{family}, {size_of(model, certificate.nonzero_weights, terms)}"
    grade, verdict = grade_and_verdict(
        name,
        measured,
        findings,
        tested_on(settings),
        model.no_inverse,
        loop_facts.has_loop,
        model.winged,
    )
    card = _card(measured, settings, family, certificate.initial_state, grade, verdict)
    # The ranges of a model that names them are part of it.
    model_card: ModelCard = card
    if model.card.output.low is not None:
        model_card = replace(model.card, provenance=card.provenance)
    scored = {}
    for field in fields(Fit):
        if hasattr(measured, field.name):
            scored[field.name] = getattr(measured, field.name)
    return Fit(
        family=family,
        model=model.with_card(model_card),
        **scored,
        static=StaticCurve(static.curve, card),
        certificate=certificate,
        facts=loop_facts,
        candidates=outcome.compared,
        warnings=findings,
        settings=settings,
        verdict=verdict,
        grade=grade,
        refitter=outcome.refitter,
        details=outcome.details,
        form=outcome.form,
    )


def _card(
    measured: Measured,
    settings: Mapping[str, Any],
    family: str,
    start: str,
    grade: Grade,
    verdict: str,
) -> ModelCard:
    records = measured.recordings
    low_in, high_in = input_range(records)
    low_out, high_out = output_range(records)
    logs = []
    for record in records:
        logs.append(dict(record.provenance) | {"name": record.name, "samples": record.samples})
    test = None
    if measured.test is not None:
        test = measured.test.as_dict()
    provenance = {
        "logs": logs,
        "date": _datetime.datetime.now(_datetime.UTC).isoformat(timespec="seconds"),
        "dehyst": __version__,
        "settings": dict(settings),
        "identified_family": family,
        "initial_state": start,
        "train": measured.train.as_dict(),
        "test": test,
        "verdict": verdict,
        "grade": str(grade),
    }
    if measured.speeds:
        provenance["fitted_speed"] = dict(measured.speeds)
    return ModelCard(
        SignalCard(records[0].input_name, records[0].input_unit, low_in, high_in),
        SignalCard(records[0].output_name, records[0].output_unit, low_out, high_out),
        provenance,
    )
