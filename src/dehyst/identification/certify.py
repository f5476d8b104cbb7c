"""From estimated parameters to a `Fit`: model, scores, optimality check, findings, verdict, provenance."""

from __future__ import annotations

import datetime as _datetime
from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from dehyst.arrays import Mask, rank
from dehyst.data.recording import Recording
from dehyst.data.speeds import top_speed
from dehyst.findings import Finding
from dehyst.identification import facts
from dehyst.identification.cautions import (
    Knows,
    about_data,
    about_fit,
    hidden_by,
    no_hysteresis,
    of_range,
    unrelated,
    with_reasons,
)
from dehyst.identification.data import DataSet, range_over
from dehyst.identification.families import STATIC, Estimate, build_model
from dehyst.identification.fit import Candidate, Certificate, Fit, LoopFacts, Refitting, Score, size_of
from dehyst.identification.regressors import Bank, settled
from dehyst.identification.scores import Measure, Measured
from dehyst.identification.selection import Choice, Firmness, output_knots
from dehyst.identification.settings import PAPER_EPS
from dehyst.identification.split import tested_on
from dehyst.identification.static_curve import curve_of, fit_static
from dehyst.models import ModelCard, SignalCard, StaticCurve
from dehyst.version import __version__

GOOD_PERCENT = 3.0
# Findings that keep a small error from being called good.
SERIOUS = {
    "rate-dependent",
    "drift",
    "mixed-loop",
    "few-loops",
    "small-test",
    "high-inverse-gain",
    "paper-bound",
    "recordings-differ",
    "swapped-columns",
    "output-stopped",
    "forward-better",
    "schedule-once",
}
DRIFTS = {"drift", "two-actuators"}
FEW_LOOPS = {"few-loops", "never-turns"}
# And those that forbid compensation.
UNUSABLE = {
    "output-unrelated",
    "poor-fit",
    "static-as-good",
    "inverse-misses",
    "never-turns",
    "inverse-useless",
    "two-actuators",
}
# Of these: whatever the inverse misses of this log, on the next motion it does harm.
HARMFUL = {"output-unrelated", "never-turns", "inverse-useless", "two-actuators"}


def _examine(
    data: DataSet, seen: Seen, measured: Measured, certificate: Certificate, knows: Knows, settings: dict[str, Any]
) -> tuple[LoopFacts, tuple[Finding, ...]]:
    """What the data shows and every finding a user should know, those of reading the log first."""
    change, doubt = measured.drift
    loops, turns = seen.counts
    if settings.get("family") == "auto":  # which has tried what leads
        knows = replace(knows, leads=True)
    loop_facts = LoopFacts(
        orientation=seen.loop.name,
        trend=data.trend,
        width_percent=100.0 * seen.loop.width,
        loops=loops,
        turns=turns,
        drift_percent=-100.0 * change / data.output_range,
        motion=seen.motion,
        evidence=measured.evidence,
    )
    held_out = settings["train_fraction"] < 1.0
    judged = [
        *about_data(
            data, loop_facts, abs(change), doubt, knows, range_over([record.input for record in measured.recordings])
        ),
        *about_fit(
            data, measured, certificate, _is_papers(settings), held_out, knows, turns, seen.loop.name == "clockwise"
        ),
    ]
    if unrelated(measured):  # then what looks like another actuator, or like drift, is what moves the output
        judged = [finding for finding in judged if finding.code not in DRIFTS]
    # Reading counts the loops of a whole log by itself; here they are counted in what is fitted, and said with that.
    read = [finding for record in measured.recordings for finding in record.findings if finding.code not in FEW_LOOPS]
    unique = {(finding.code, finding.message): finding for finding in [*read, *judged]}
    return loop_facts, tuple(unique.values())


def verdict_of(
    name: str,
    measured: Measured,
    findings: tuple[Finding, ...],
    tested: str,
    no_inverse: str = "",
    has_loop: bool = False,
) -> str:
    """The judgement in one line; `name` is the family and its size, `tested` says what was held out, if anything was.

    A compensator is good if its input error is: within 3 % of the input's range, and no worse than that of the curve's
    inverse. Within that bound only what does harm on the next motion forbids it.
    """
    test, codes = measured.test, {finding.code for finding in findings}
    judged, static = test or measured.train, measured.static_test or measured.static_train
    where = f"on {tested}" if test is not None else "on the fitted samples (none held out)"
    inverse, curve = measured.input_error.rms_percent, measured.curve_input.rms_percent
    against = sorted(codes & (SERIOUS | UNUSABLE))
    if inverse > GOOD_PERCENT:
        against.append(f"its inverse misses by more than {GOOD_PERCENT:g} %")
    elif rank(inverse) > rank(curve):
        against.append(f"the inverse of a curve without hysteresis misses less, {of_range(curve)} range")
    if codes & HARMFUL or (codes & UNUSABLE and inverse > GOOD_PERCENT):
        grade = f"do not compensate with it ({', '.join(sorted(codes & UNUSABLE))})"
    elif judged.rmse_percent <= GOOD_PERCENT and test is not None and not against:
        grade = "good for compensation"
    else:
        reasons = reasons_of(judged, test is not None, against)
        grade = "usable with care" + (f" ({reasons})" if reasons else "")
    errs, curve_errs = (_rms(score.rmse_percent) for score in (judged, static))
    if "output-unrelated" in codes:
        return (
            f"the output does not follow this input: {name} misses by {errs} {where}, the best curve without "
            f"hysteresis by {curve_errs}: {grade}."
        )
    if no_inverse:
        return (
            f"{name}: {errs} {where}, against {_bare(static.rmse_percent)} for the "
            f"best curve without hysteresis: simulate with it, do not compensate with it. It has no inverse: "
            f"{no_inverse.rstrip('.')}."
        )
    gives = f"gives the applied input back to {of_range(inverse)} its range"
    if name == STATIC:
        hidden = hidden_by(codes)
        why = "hysteresis was not found, or does not repeat"
        if hidden:
            why = f"a loop may be hidden ({hidden})"
        elif has_loop:
            why = "there is a loop, but no model with memory did better on parts left out"
        return (
            f"static, a curve without memory: {errs} {where}; its inverse {gives}"
            + (f"; {why}" if "no-hysteresis" in codes else "")
            + f": {grade}."
        )
    return (
        f"{name}: {errs} {where}, against {_bare(static.rmse_percent)} for the best "
        f"curve without hysteresis; the inverse {gives}: {grade}."
    )


def _rms(percent: float) -> str:
    """An error as the verdict says it: a percentage of a range, or how many times it."""
    return f"{percent:.2f} % of range rms" if percent < 100.0 else f"{of_range(percent)} the range rms"


def _bare(percent: float) -> str:
    return f"{percent:.2f} %" if percent < 100.0 else f"{of_range(percent)} it"


def reasons_of(judged: Score, held_out: bool, serious: list[str]) -> str:
    """Why a model is to be used with care."""
    error = [] if judged.rmse_percent <= GOOD_PERCENT else [f"its output errs by more than {GOOD_PERCENT:g} %"]
    return ", ".join([*serious, *error, *([] if held_out else ["nothing held out"])])


class Seen(NamedTuple):
    """What the fitted part shows: orientation, loops and turning points, motion of the input."""

    loop: facts.Orientation
    counts: tuple[int, int]
    motion: facts.Motion


def seen_in(found: tuple[facts.Branches, ...]) -> Seen:
    """Say what the branches of the fitted part show."""
    return Seen(facts.orientation(found), facts.count_loops(found), facts.motion(found))


def certify(
    data: DataSet,
    operators: int,
    choice: Choice,
    bank: Bank,
    estimate: Estimate,
    firm: Firmness,
    candidates: tuple[Candidate, ...],
    seen: Seen,
    settings: dict[str, Any],
    measure: Measure,
    refitter: Refitting | None,
) -> Fit:
    """Return the fit of one estimate: model, predictions, scores, certificate, findings, verdict.

    `measure` compares model and curve with all samples; `refitter` holds the sums, if refits are possible.
    """
    static = curve_of(fit_static(data, choice.initial_state)[0], data)
    knots = output_knots() if choice.family == "modified-pi" else None
    model = (
        curve_of(estimate, data) if choice.family == STATIC else build_model(estimate, data, bank, knots, ModelCard())
    )
    measured = measure(data, settled(data, bank, model), model, static, seen.counts[1])
    certificate = Certificate(
        kkt_residual=estimate.kkt_residual,
        round_trip_error=measured.round_trip,
        inverse_gain=model.inverse_gain,
        inverse_miss_percent=measured.input_error.rms_percent,
        affordable_eps=firm.affordable,
        enough_eps=firm.enough,
        enough_eps_cost=firm.cost,
        strain=firm.strain if _is_papers(settings) else 0.0,
        nonzero_weights=model.nonzero_weights,
        operators=operators,
        undetermined=tuple(float(r) for r in bank.undetermined * data.half_range),
        initial_state=choice.initial_state,
        route=estimate.route,
        condition=estimate.condition,
    )
    knows = Knows(leads=choice.family in ("stop", "pi-cumulative"))
    name = f"{choice.family}, {size_of(model, model.nonzero_weights, operators)}" if operators else STATIC
    return fit_of(
        model, choice.family, name, knows, data, seen, static, measured, certificate, settings, candidates, refitter
    )


def fit_of(
    model: Any,
    family: str,
    name: str,
    knows: Knows,
    data: DataSet,
    seen: Seen,
    static: StaticCurve,
    measured: Measured,
    certificate: Certificate,
    settings: dict[str, Any],
    candidates: tuple[Candidate, ...],
    refitter: Refitting | None = None,
    no_inverse: str = "",
    more: tuple[Finding, ...] = (),
) -> Fit:
    """Return the fit of a model of any family: findings, verdict, provenance.

    `name` is family and size, as the verdict says them; `no_inverse` why there is none, "" if there is one; `more` are
    findings that only this family has.
    """
    loop_facts, findings = _examine(data, seen, measured, certificate, knows, settings)
    if family == STATIC and candidates:
        span = range_over([record.input for record in measured.recordings])
        more = (*more, no_hysteresis(candidates, span, [finding.code for finding in findings], loop_facts))
    findings = with_reasons((*findings, *more))
    verdict = verdict_of(name, measured, findings, tested_on(settings), no_inverse, loop_facts.has_loop)
    card = _card(measured, settings, family, certificate.initial_state, verdict)
    own: ModelCard = model.card  # of a model that names its ranges, they are part of it
    return Fit(
        family=family,
        model=model.with_card(card if own.output.low is None else replace(own, provenance=card.provenance)),
        **{one.name: getattr(measured, one.name) for one in fields(Fit) if hasattr(measured, one.name)},
        static=StaticCurve(static.curve, card),
        certificate=certificate,
        facts=loop_facts,
        candidates=candidates,
        warnings=findings,
        settings=settings,
        verdict=verdict,
        refitter=refitter,
    )


def _is_papers(settings: dict[str, Any]) -> bool:
    """Whether the bound is the paper's, w_1 >= 0.001 in units of the log."""
    return bool(settings["family"] == "pi" and settings["eps"] == PAPER_EPS)


def fitted_speed(records: Sequence[Recording], masks: Sequence[Mask]) -> dict[str, Any]:
    """Speeds of both signals in the fitted samples, in ranges a second, as a fact of a card; empty without time."""
    timed = [(record, mask) for record, mask in zip(records, masks, strict=True) if record.time is not None]
    if not timed:
        return {}
    inputs = [(np.asarray(record.time)[mask], record.input[mask]) for record, mask in timed]
    outputs = [(np.asarray(record.time)[mask], record.output[mask]) for record, mask in timed]
    low, high = range_over([record.input for record in records])
    least, most = range_over([record.output for record in records])
    speeds = {"input": top_speed(inputs, high - low), "output": top_speed(outputs, most - least)}
    return {"fitted_speed": {name: float(f"{speed:.4g}") for name, speed in speeds.items()}}


def _card(measured: Measured, settings: dict[str, Any], family: str, start: str, verdict: str) -> ModelCard:
    records = measured.recordings
    low_in, high_in = range_over([record.input for record in records])
    low_out, high_out = range_over([record.output for record in records])
    provenance = {
        "logs": [dict(record.provenance) | {"name": record.name, "samples": record.samples} for record in records],
        "date": _datetime.datetime.now(_datetime.UTC).isoformat(timespec="seconds"),
        "dehyst": __version__,
        "settings": dict(settings),
        "identified_family": family,
        "initial_state": start,
        "train": measured.train.as_dict(),
        "test": None if measured.test is None else measured.test.as_dict(),
        "verdict": verdict,
        **fitted_speed(records, measured.train_masks),
    }
    return ModelCard(
        SignalCard(records[0].input_name, records[0].input_unit, low_in, high_in),
        SignalCard(records[0].output_name, records[0].output_unit, low_out, high_out),
        provenance,
    )
