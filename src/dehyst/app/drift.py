"""dehyst drift: tests whether the actuator has changed since its identification, and offers a new model."""

from __future__ import annotations

import math
from typing import Any

from rich.table import Column
from rich.text import Text

from dehyst.app.design import USUAL_LIMIT
from dehyst.app.ending import Status, concluding
from dehyst.app.logs import Read, recordings_of, signals_of, verdict_findings
from dehyst.app.requests import DesignRequest, DriftRequest
from dehyst.app.targets import PAGE, refuse_clashes
from dehyst.app.terminal import ask_progress, print_findings, print_json, table, terminal
from dehyst.design import design_drift_motion
from dehyst.errors import ColumnError, DehystError, ExcitationError, ParameterError, RecordingError
from dehyst.findings import Grade, grade_of
from dehyst.models import Model, load
from dehyst.monitoring import Change, Drift, drift
from dehyst.monitoring.parts import NAMES, Subject
from dehyst.monitoring.result import other_way, plain
from dehyst.shell import command

ENDS = {  # of what is found: exit status, colour
    "unchanged": (Status.DONE, "green"),
    "drifted": (Status.NO, "red"),
    "not comparable": (Status.NOT_COMPARABLE, "yellow"),
    "cannot tell": (Status.CANNOT_TELL, "yellow"),
}
SAMPLES = 200  # of a designed cycle


def run_drift(request: DriftRequest) -> None:
    """Read, compare, refit if asked to, report, print; the exit status is the verdict's."""
    sources = (request.model, *request.logs, request.reference)  # a model in use is not replaced without a word
    refuse_clashes(sources, request.overwrite, refit=(request.refit, None), report=(request.report, PAGE))
    model = load(request.model)
    with ask_progress("reading", request.json):
        read, unusable = _read_all(request, model)
        reference, every = None, read
        if request.reference is not None:
            reference, *more = recordings_of(request, request.reference, None, model.card)
            if more:
                raise ParameterError(
                    "--reference is one recording, and --from and --to name several parts. Name one of them."
                )
            every = [*read, (request.reference, None, reference)]
        signals: dict[str, Any] = dict(signals_of(request, every, model.context)[0])
    with ask_progress("comparing", request.json):
        found = drift(
            model,
            [record for *_, record in read],
            reference=reference,
            false_alarm=request.false_alarm,
            least=request.least,
            ignore=request.ignore,
            refit=request.refit is not None,
            **signals,
        ).with_unusable(unusable)
    if request.refit is not None and found.acceptance is not None and found.acceptance.accepted:
        found.model.save(request.refit)
    if request.report is not None:
        from dehyst.report import write_drift_report

        with ask_progress("drawing", request.json):
            write_drift_report(found, request.report, request.model.name)
    with concluding(ENDS[found.status][0]):
        if request.json:
            print_json(found.as_dict())
        else:
            _print(found, request)
            print_findings(verdict_findings(model, f"'{request.model}'", "Do not apply its inverse to a machine"))


def _read_all(request: DriftRequest, model: Model) -> tuple[list[Read], list[tuple[str, str]]]:
    """Return recordings with log and run; and logs of other columns or without motion, with the reason."""
    read: list[Read] = []
    unusable: list[tuple[str, str]] = []
    fault: DehystError | None = None
    for log in request.logs:
        for run in request.runs or (None,):
            try:
                read += [(log, run, record) for record in recordings_of(request, log, run, model.card)]
            except (ColumnError, ExcitationError, RecordingError) as failed:
                unusable.append((log.name, str(failed)))
                fault = failed
    if not read and fault is not None:
        raise fault
    return read, unusable


def _print(found: Drift, request: DriftRequest) -> None:
    out, other = terminal(), other_way(Subject.of(found.model).backward)
    out.print(found.verdict, style=f"bold {ENDS[found.status][1]}")
    for entry in found.logs:
        out.print()
        error = f", error {entry.error_percent:.3g} % of range rms" if entry.error_percent is not None else ""
        inverse = f", {other} {entry.inverse_percent:.3g} %" if entry.inverse_percent is not None else ""
        tested = f" ({entry.tested} tested)" if 0 < entry.tested < entry.cycles else ""
        out.print(f"{entry.name}: {entry.status}, {entry.cycles} cycles{tested}{error}{inverse}", soft_wrap=True)
        if entry.changes:
            heads = (Column("", no_wrap=True), ">change", ">95 % interval", ">effect %", ">seen from", ">p")
            out.print(table(heads, map(_row, entry.changes)))
    for trend in found.trends:
        if trend.clear:
            slope = f"{trend.slope:+.3g} {trend.unit} in 100 cycles"
            out.print(f"trend of {trend.part}: {slope} ({trend.low:+.3g} to {trend.high:+.3g})")
    print_findings([*(f for entry in found.logs for f in entry.findings), *found.findings])
    out.print()
    if found.acceptance is not None:
        _print_acceptance(found, request)
    if request.report is not None:
        out.print(f"report: {request.report}")
    if found.status == "drifted" and found.acceptance is None:
        out.print("next: repeat with --refit new.json; it is written only if it is better", soft_wrap=True)
    if found.status == "cannot tell":
        out.print(f"next: {_motion(found)}", soft_wrap=True)


def _row(change: Change) -> tuple[str | Text, ...]:
    unit = f" {change.unit}" if change.unit else ""
    return (
        Text(f"{'*' if change.drifted else ' '} {NAMES[change.part]}", style="bold" if change.drifted else ""),
        f"{plain(change.estimate, '+.3g')}{unit}",
        f"{plain(change.low, '+.2g')} to {plain(change.high, '+.2g')}",
        plain(change.effect_percent, ".2g"),
        f"{plain(change.detectable, '.2g')}{unit}",
        f"{change.p_value:.1g}",
    )


def _motion(found: Drift) -> str:
    """The command that makes a motion that tells."""
    motion = found.motion
    options: dict[str, str] = {}
    if motion["rate"]:
        usual = DesignRequest()
        plan = design_drift_motion(
            motion["low"], motion["high"], rate=motion["rate"], time_limit=math.inf, period=motion["period_s"] / SAMPLES
        )
        options["rate"] = f"{motion['rate']:.3g}"
        if plan.duration > USUAL_LIMIT:
            options["time_limit"] = f"{1.01 * plan.duration:.0f}"
        if plan.period < usual.period:
            options["period"] = f"{plan.period:.2g}"
    ends = f"{motion['low']:.4g}", f"{motion['high']:.4g}"
    return command("design", for_="drift", range=ends, unit=motion["unit"] or None, **options, out="drift.csv")


def _print_acceptance(found: Drift, request: DriftRequest) -> None:
    """Say what the new model is worth, and what to do with it; a compensator is offered only where that allows one."""
    assert found.acceptance is not None
    out = terminal()
    out.print(found.acceptance.reason, style="bold")
    if not found.acceptance.accepted:
        out.print(f"model: {request.model}, as before; nothing was written")
        return
    out.print(f"model: {request.refit}")
    verdict, output = found.model.card.provenance.get("verdict"), found.model.card.output.name
    if isinstance(verdict, str):
        out.print(f"verdict on the new model: {verdict}", soft_wrap=True)
    if grade_of(verdict) is Grade.BAD:
        told = "do not compensate with the new model; read its verdict, cure it and identify again"
    else:
        needs = dict.fromkeys(found.model.needs, "COLUMN")
        told = command("compensate", request.refit, "REFERENCE.csv", output=output, **needs)
    out.print(f"next: {told}", soft_wrap=True)
