"""dehyst drift: has the actuator changed since it was identified; a new model only if it is better."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

from rich.table import Table
from rich.text import Text

from dehyst.app.context import Read, recording_of, signals_of, verdict_findings
from dehyst.app.ending import concluding
from dehyst.app.requests import DesignRequest, DriftRequest
from dehyst.app.status import Status
from dehyst.app.targets import PAGE, refuse_clashes
from dehyst.app.terminal import ask_progress, print_findings, print_json, terminal
from dehyst.design import design_drift_motion
from dehyst.errors import ColumnError, DehystError, ExcitationError, RecordingError
from dehyst.findings import Grade, grade_of
from dehyst.models import Model, load
from dehyst.monitoring import Change, Drift, drift
from dehyst.monitoring.parts import NAMES, Subject
from dehyst.monitoring.result import other_way
from dehyst.shell import quoted

STATUS = {
    "unchanged": Status.DONE,
    "drifted": Status.NO,
    "not comparable": Status.NOT_COMPARABLE,
    "cannot tell": Status.CANNOT_TELL,
}
SAMPLES = 200  # of a designed cycle
STYLES = {
    "unchanged": "bold green",
    "drifted": "bold red",
    "not comparable": "bold yellow",
    "cannot tell": "bold yellow",
}


def run_drift(request: DriftRequest) -> None:
    """Read, compare, refit if asked to, report, print; the exit status is the verdict's."""
    sources = (request.model, *request.logs, request.reference)  # a model in use is not replaced without a word
    refuse_clashes(sources, request.overwrite, refit=(request.refit, None), report=(request.report, PAGE))
    model = load(request.model)
    with ask_progress("reading", request.json):
        read, unusable = _read_all(request, model)
        reference, every = None, read
        if request.reference is not None:
            reference = recording_of(request, request.reference, None, model.card)
            every = [*read, (request.reference, None, reference)]
        signals: dict[str, Any] = dict(signals_of(request, every, [model]))
    with ask_progress("comparing", request.json):
        found = drift(
            model,
            [record for _, _, record in read],
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
        with ask_progress("drawing", request.json):
            _report(found, request)
    with concluding(STATUS[found.status]):
        if request.json:
            print_json(found.as_dict())
        else:
            _print(found, request)
            print_findings([*verdict_findings(model, f"'{request.model}'", "Do not apply its inverse to a machine")])


def _read_all(request: DriftRequest, model: Model) -> tuple[list[Read], list[tuple[str, str]]]:
    """Return recordings with log and run; and logs of other columns or without motion, with the reason."""
    read: list[Read] = []
    unusable: list[tuple[str, str]] = []
    fault: DehystError | None = None
    for log in request.logs:
        for run in request.runs or (None,):
            try:
                read.append((log, run, recording_of(request, log, run, model.card)))
            except (ColumnError, ExcitationError, RecordingError) as failed:
                unusable.append((log.name, str(failed)))
                fault = failed
    if not read and fault is not None:
        raise fault
    return read, unusable


def _report(found: Drift, request: DriftRequest) -> None:
    from dehyst.report import write_drift_report

    assert request.report is not None
    write_drift_report(found, request.report, request.model.name)


def _print(found: Drift, request: DriftRequest) -> None:
    out, other = terminal(), other_way(Subject.of(found.model).backward)
    out.print(Text(found.verdict, style=STYLES[found.status]))
    for entry in found.logs:
        out.print()
        error = f", error {entry.error_percent:.3g} % of range rms" if entry.error_percent is not None else ""
        inverse = f", {other} {entry.inverse_percent:.3g} %" if entry.inverse_percent is not None else ""
        tested = f" ({entry.tested} tested)" if 0 < entry.tested < entry.cycles else ""
        out.print(Text(f"{entry.name}: {entry.status}, {entry.cycles} cycles{tested}{error}{inverse}"), soft_wrap=True)
        if entry.changes:
            out.print(_table(entry.changes))
    for trend in found.trends:
        if trend.clear:
            out.print(
                Text(
                    f"trend of {trend.part}: {trend.slope:+.3g} {trend.unit} in 100 cycles "
                    f"({trend.low:+.3g} to {trend.high:+.3g})"
                )
            )
    print_findings([*(f for entry in found.logs for f in entry.findings), *found.findings])
    out.print()
    if found.acceptance is not None:
        out.print(Text(found.acceptance.reason, style="bold"))
        written = found.acceptance.accepted
        out.print(Text(f"model: {request.refit if written else f'{request.model}, as before; nothing was written'}"))
        if written:
            _print_accepted(found, cast(Path, request.refit))
    if request.report is not None:
        out.print(Text(f"report: {request.report}"))
    if found.status == "drifted" and found.acceptance is None:
        out.print(Text("next: repeat with --refit new.json; it is written only if it is better"), soft_wrap=True)
    if found.status == "cannot tell":
        out.print(Text(f"next: {_motion(found)}"), soft_wrap=True)


def _motion(found: Drift) -> str:
    """The command that makes a motion that tells."""
    motion = found.motion
    words = [f"dehyst design --for drift --range {motion['low']:.4g} {motion['high']:.4g}"]
    if motion["unit"]:
        words.append(f"--unit {quoted(motion['unit'])}")
    if motion["rate"]:
        usual = DesignRequest()
        plan = design_drift_motion(
            motion["low"], motion["high"], rate=motion["rate"], time_limit=math.inf, period=motion["period_s"] / SAMPLES
        )
        words.append(f"--rate {motion['rate']:.3g}")
        if plan.duration > usual.time_limit:
            words.append(f"--time-limit {1.01 * plan.duration:.0f}")
        if plan.period < usual.period:
            words.append(f"--period {plan.period:.2g}")
    return " ".join((*words, "--out drift.csv"))


def _print_accepted(found: Drift, path: Path) -> None:
    """Say what the new model is worth, and what to do with it; a compensator is offered only where that allows one."""
    verdict, output = found.model.card.provenance.get("verdict"), found.model.card.output.name
    model, out = quoted(path), terminal()
    if isinstance(verdict, str):
        out.print(Text(f"verdict on the new model: {verdict}"), soft_wrap=True)
    if grade_of(verdict) is Grade.BAD:
        told = "do not compensate with the new model; read its verdict, cure it and identify again"
    else:
        told = f"dehyst compensate {model} REFERENCE.csv --output {quoted(output)}"
    out.print(Text(f"next: {told}"), soft_wrap=True)


def _table(changes: Sequence[Change]) -> Table:
    table = Table(box=None, pad_edge=False)
    for name in ("", "change", "95 % interval", "effect [%]", "seen from", "p"):
        table.add_column(Text(name), justify="left" if not name else "right")
    for change in changes:
        unit = f" {change.unit}" if change.unit else ""
        table.add_row(
            Text(f"{'*' if change.drifted else ' '} {NAMES[change.part]}", style="bold" if change.drifted else ""),
            f"{change.estimate:+.3g}{unit}",
            f"{change.low:+.3g} to {change.high:+.3g}",
            f"{change.effect_percent:.2g}",
            f"{change.detectable:.2g}{unit}",
            f"{change.p_value:.2g}",
        )
    return table
