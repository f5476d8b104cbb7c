"""A fitted estimate becomes a model with scores, certificate, verdict and provenance."""

from __future__ import annotations

import datetime as _datetime
from dataclasses import replace
from typing import Any, NamedTuple

from dehyst.data.recording import Recording
from dehyst.findings import Finding
from dehyst.identification import facts, judge
from dehyst.identification.build import build_model
from dehyst.identification.cautions import Knows, no_hysteresis
from dehyst.identification.data import DataSet, range_over
from dehyst.identification.families import STATIC, Estimate
from dehyst.identification.fit import Candidate, Certificate, Fit, Score, size_of
from dehyst.identification.folds import output_knots
from dehyst.identification.levels import settled
from dehyst.identification.measures import Measure, Measured
from dehyst.identification.refit import Refitter
from dehyst.identification.regressors import Bank
from dehyst.identification.selection import Choice, Firmness
from dehyst.identification.settings import PAPER_EPS
from dehyst.identification.split import tested_on
from dehyst.identification.static_curve import curve_of, fit_static
from dehyst.models import ModelCard, SignalCard, StaticCurve
from dehyst.version import __version__


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
    refitter: Refitter | None,
) -> Fit:
    """Return the fit of one estimate: model, predictions, scores, certificate, findings, verdict.

    Parameters
    ----------
    seen
        What the fitted part shows.
    measure
        Compares model and curve with all samples.
    refitter
        Holds the sums, if refits are possible.
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
    name = f"{choice.family}, {size_of(model, model.nonzero_weights, operators)}"
    return fit_of(
        model, choice.family, name if operators else STATIC, knows, data, seen, static, measured,
        certificate, settings, candidates, refitter,
    )  # fmt: skip


class Seen(NamedTuple):
    """What the fitted part shows: orientation, loops and turning points, motion of the input."""

    loop: facts.Orientation
    counts: tuple[int, int]
    motion: facts.Motion


def seen_in(found: tuple[facts.Branches, ...]) -> Seen:
    """Say what the branches of the fitted part show."""
    return Seen(facts.orientation(found), facts.count_loops(found), facts.motion(found))


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
    refitter: Refitter | None = None,
    no_inverse: str = "",
    more: tuple[Finding, ...] = (),
) -> Fit:
    """Return the fit of a model of any family: findings, verdict, provenance.

    Parameters
    ----------
    name
        Family and size, as the verdict says them.
    knows
        What the family can show.
    no_inverse
        Why there is no inverse, "" if there is one.
    more
        Findings that only this family has.
    """
    loop_facts, findings = judge.examine(
        measured.recordings, data, *seen, measured, certificate, knows,
        paper=_is_papers(settings), held_out=settings["train_fraction"] < 1.0,
    )  # fmt: skip
    if family == STATIC and candidates:
        more = (*more, no_hysteresis(candidates))
    findings = (*findings, *more)
    verdict = judge.verdict(name, measured, findings, tested_on(settings), no_inverse)
    train, test = measured.train, measured.test
    card = _card(measured.recordings, settings, family, certificate.initial_state, train, test, verdict)
    own: ModelCard = model.card  # of a model that names its ranges, they are part of it
    return Fit(
        family=family,
        model=model.with_card(card if own.output.low is None else replace(own, provenance=card.provenance)),
        recordings=measured.recordings,
        predictions=measured.outputs,
        inverse_predictions=measured.demands,
        train_masks=measured.train_masks,
        test_masks=measured.test_masks,
        train=train,
        test=test,
        input_train=measured.input_train,
        input_test=measured.input_test,
        curve_input=measured.curve_input,
        static=StaticCurve(static.curve, card),
        static_train=measured.static_train,
        static_test=measured.static_test,
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


def _card(
    records: tuple[Recording, ...],
    settings: dict[str, Any],
    family: str,
    start: str,
    train: Score,
    test: Score | None,
    verdict: str,
) -> ModelCard:
    first = records[0]
    low_in, high_in = range_over([record.input for record in records])
    low_out, high_out = range_over([record.output for record in records])
    provenance = {
        "logs": [dict(record.provenance) | {"name": record.name, "samples": record.samples} for record in records],
        "date": _datetime.datetime.now(_datetime.UTC).isoformat(timespec="seconds"),
        "dehyst": __version__,
        "settings": dict(settings),
        "identified_family": family,
        "initial_state": start,
        "train": train.as_dict(),
        "test": None if test is None else test.as_dict(),
        "verdict": verdict,
    }
    return ModelCard(
        SignalCard(first.input_name, first.input_unit, low_in, high_in),
        SignalCard(first.output_name, first.output_unit, low_out, high_out),
        provenance,
    )
