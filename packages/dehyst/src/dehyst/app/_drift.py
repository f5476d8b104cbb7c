"""dehyst drift: tests whether the actuator has changed since its identification, and offers a new model."""

from __future__ import annotations

import math

from rich.table import Column
from rich.text import Text

from dehyst.app._ending import Status, concluding
from dehyst.app._logs import Read, Shares, recordings_of, verdict_findings, with_schedules
from dehyst.app._policy import POLICY
from dehyst.app._targets import PAGE, refuse_clashes
from dehyst.app._terminal import ask_progress, print_findings, print_json, table, terminal
from dehyst.app.requests import DesignRequest, DriftRequest
from dehyst.design import design_drift_motion
from dehyst.errors import ColumnError, DehystError, ExcitationError, ParameterError, RecordingError
from dehyst.findings import Finding, Grade, grade_in
from dehyst.models import Model, load
from dehyst.monitoring import (
    NAMES,
    Drift,
    JudgedModel,
    PartChange,
    drift,
    other_way,
    without_exponent,
)
from dehyst.shell import command, schedules_to_type

ENDS = {  # of what is found: exit status, colour
    "unchanged": (Status.DONE, "green"),
    "drifted": (Status.NO, "red"),
    "not comparable": (Status.NOT_COMPARABLE, "yellow"),
    "cannot tell": (Status.CANNOT_TELL, "yellow"),
}
SAMPLES = 200  # of a designed cycle


def run_drift(request: DriftRequest) -> None:
    """Read, compare, refit if asked to, report, print; the exit status is the verdict's."""
    # The model is a source too: one that is in use is not replaced without a word.
    sources = (request.model, *request.logs, request.reference)
    refuse_clashes(
        sources, request.overwrite, refit=(request.refit, None), report=(request.report, PAGE)
    )
    model = load(request.model)
    with ask_progress("reading", request.json) as progress:
        read, unusable = _read_all(request, model, progress)
        reference, every = None, read
        if request.reference is not None:
            reference, *more = recordings_of(request, request.reference, None, model.card, progress)
            if more:
                raise ParameterError(
                    "--reference is one recording, and --from and --to name several parts. Name one of them."
                )
            every = [*read, (request.reference, None, reference)]
        every = with_schedules(request, every, model.context)
        if reference is not None:
            *read, (_, _, reference) = every
        else:
            read = every
    with ask_progress("comparing", request.json):
        result = drift(
            model,
            [record for *_, record in read],
            reference=reference,
            false_alarm=request.false_alarm,
            least=request.least,
            ignore=request.ignore,
            refit=request.refit is not None,
        ).with_unusable(unusable)
    if request.refit is not None and result.acceptance is not None and result.acceptance.accepted:
        result.model.save(request.refit)
    if request.report is not None:
        from dehyst.report import write_drift_report

        with ask_progress("drawing", request.json):
            write_drift_report(result, request.report, request.model.name)
    with concluding(ENDS[result.status][0]):
        if request.json:
            print_json(result.as_dict())
        else:
            _print(result, request)
            print_findings(
                verdict_findings(
                    model, f"'{request.model}'", "Do not apply its inverse to a machine"
                )
            )


def _read_all(
    request: DriftRequest, model: Model, progress: Shares
) -> tuple[list[Read], list[tuple[str, str]]]:
    """Return recordings with log and run; and logs of other columns or without motion, with the reason."""
    read: list[Read] = []
    unusable: list[tuple[str, str]] = []
    fault: DehystError | None = None
    for log in request.logs:
        for run in request.runs or (None,):
            try:
                # A run counts only if all of its parts can be read.
                records = list(recordings_of(request, log, run, model.card, progress))
                read += [(log, run, record) for record in records]
            # One log that cannot be read must not hide what the others say.
            except (ColumnError, ExcitationError, RecordingError) as failed:
                unusable.append((log.name, str(failed)))
                fault = failed
    # Without any log the reason of the last one is the answer.
    if not read and fault is not None:
        raise fault
    return read, unusable


def _print(result: Drift, request: DriftRequest) -> None:
    """Print the verdict, the changes of each log, the trends, and what to do next."""
    out, other_direction = terminal(), other_way(JudgedModel.of(result.model).backward)
    out.print(result.verdict, style=f"bold {ENDS[result.status][1]}")
    findings: list[Finding] = []
    for entry in result.logs:
        findings += entry.findings
        line = f"{entry.name}: {entry.status}, {entry.cycles} cycles"
        # Of long logs only the last part is tested, and the user should know how much that is.
        if 0 < entry.tested < entry.cycles:
            line += f" ({entry.tested} tested)"
        if entry.error_percent is not None:
            line += f", error {entry.error_percent:.3g} % of range rms"
        if entry.inverse_percent is not None:
            line += f", {other_direction} {entry.inverse_percent:.3g} %"
        out.print()
        out.print(line, soft_wrap=True)
        if entry.changes:
            numbers = (">change", ">95 % interval", ">effect %", ">seen from", ">p")
            heads = (Column("", no_wrap=True), *numbers)
            out.print(table(heads, map(_row, entry.changes)))
    for trend in result.trends:
        # A trend that may be zero is no news.
        if trend.clear:
            slope = f"{trend.slope:+.3g} {trend.unit} in 100 cycles"
            out.print(f"trend of {trend.part}: {slope} ({trend.low:+.3g} to {trend.high:+.3g})")
    # What was met in reading comes before what limits the judgement.
    print_findings([*findings, *result.findings])
    out.print()
    if result.acceptance is not None:
        _print_acceptance(result, request)
    if request.report is not None:
        out.print(f"report: {request.report}")
    if result.status == "drifted" and result.acceptance is None:
        out.print(
            "next: repeat with --refit new.json; it is written only if it is better", soft_wrap=True
        )
    if result.status == "cannot tell":
        out.print(f"next: {_motion(result)}", soft_wrap=True)


def _row(change: PartChange) -> tuple[str | Text, ...]:
    """A change in the table; one that counts has a star and is bold."""
    unit = ""
    if change.unit:
        unit = f" {change.unit}"
    name = Text(f"  {NAMES[change.part]}")
    if change.drifted:
        name = Text(f"* {NAMES[change.part]}", style="bold")
    return (
        name,
        f"{without_exponent(change.estimate, '+.3g')}{unit}",
        f"{without_exponent(change.low, '+.2g')} to {without_exponent(change.high, '+.2g')}",
        without_exponent(change.effect_percent, ".2g"),
        f"{without_exponent(change.detectable, '.2g')}{unit}",
        f"{change.p_value:.1g}",
    )


def _motion(result: Drift) -> str:
    """The command that makes a motion that tells."""
    motion = result.motion
    options: dict[str, str] = {}
    if motion["rate"]:
        usual = DesignRequest()
        plan = design_drift_motion(
            motion["low"],
            motion["high"],
            rate=motion["rate"],
            time_limit=math.inf,
            period=motion["period_s"] / SAMPLES,
        )
        options["rate"] = f"{motion['rate']:.3g}"
        # The command must not be refused for its length, which the cycles of the log ask for.
        if plan.duration > POLICY.usual_limit:
            options["time_limit"] = f"{1.01 * plan.duration:.0f}"
        # A quick motion needs samples closer together than the usual ones.
        if plan.period < usual.period:
            options["period"] = f"{plan.period:.2g}"
    ends = f"{motion['low']:.4g}", f"{motion['high']:.4g}"
    return command(
        "design", for_="drift", range=ends, unit=motion["unit"] or None, **options, out="drift.csv"
    )


def _print_acceptance(result: Drift, request: DriftRequest) -> None:
    """Say what the new model is worth, and what to do with it; a compensator is offered only where that allows one."""
    assert result.acceptance is not None
    out = terminal()
    out.print(result.acceptance.reason, style="bold")
    if not result.acceptance.accepted:
        out.print(f"model: {request.model}, as before; nothing was written")
        return
    out.print(f"model: {request.refit}")
    verdict, output = result.model.card.provenance.get("verdict"), result.model.card.output.name
    # A provenance may come from anybody's file, and only a text can be printed.
    if isinstance(verdict, str):
        out.print(f"verdict on the new model: {verdict}", soft_wrap=True)
    if grade_in(result.model.card.provenance) is Grade.BAD:
        next_line = (
            "do not compensate with the new model; read its verdict, cure it and identify again"
        )
    else:
        needs = schedules_to_type(result.model.needs)
        wing = result.model.wing_to_type
        options = {"output": output, "out": "compensated.csv", **needs, **wing}
        next_line = command("compensate", request.refit, "REFERENCE.csv", **options)
    out.print(f"next: {next_line}", soft_wrap=True)
