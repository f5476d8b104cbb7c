"""dehyst identify --family direct-inverse: log -> compensator, comparison with forward families, evidence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from dehyst.app.context import schedule_of
from dehyst.app.requests import IdentifyRequest
from dehyst.app.terminal import ask_progress, print_end, print_findings, terminal
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.grades import Grade, grade_of
from dehyst.identification import DirectFit, Score, identify_direct
from dehyst.models import Schedule
from dehyst.recording import Recording
from dehyst.shell import quoted
from dehyst.units import MASS_FACTORS

DIRECT = "direct-inverse"


def refuse_options(request: IdentifyRequest) -> None:
    """Refuse options that say nothing to the family that was asked for."""
    direct = {
        "--creep": request.creep is not None,
        "--creep-times": request.creep_times is not None,
        "--load": request.load is not None,
        "--mean-pressure": request.mean_pressure is not None,
        "--no-position-schedule": not request.position_schedule,
    }
    forward = {
        "--n": request.n != "100",
        "--eps": request.eps is not None,
        "--thresholds": request.thresholds is not None,
        "--stream": request.stream is True,
        "--spool-dir": request.spool_dir is not None,
        "--shear": request.shear is not None,
        "--max-inverse-gain": request.max_inverse_gain is not None,
    }
    is_direct = request.family == DIRECT
    wrong = [name for name, given in (forward if is_direct else direct).items() if given]
    if not wrong:
        return
    about = (
        f"says nothing to --family {DIRECT}, whose terms are its own and which reads the log at once"
        if is_direct
        else f"belongs to --family {DIRECT}, and the family is {request.family}"
    )
    raise ParameterError(
        f"{' and '.join(wrong)} {about}. Leave it out, or choose {'another family' if is_direct else 'that family'}.",
        options=wrong,
    )


def identify_from(request: IdentifyRequest, records: list[Recording]) -> DirectFit:
    """Read the scheduling columns and identify."""
    runs = [(log, run) for log in request.logs for run in (request.runs or (None,))]
    given: dict[str, list[Array]] = {}
    units: dict[str, str] = {}
    with ask_progress("reading", request.json):
        for name, column in (("load", request.load), ("mean_pressure", request.mean_pressure)):
            if column is not None:
                given[name], units[name] = schedule_of(name, column, (request.time, request.time_unit), runs, records)
    signals: dict[str, Any] = dict(given)
    with ask_progress("identifying", request.json):
        return identify_direct(
            records,
            creep="auto" if request.creep is None else request.creep,
            creep_times=_times(request.creep_times),
            units=units,
            position_schedule=request.position_schedule,
            initial_state=request.initial_state,
            train_fraction=request.train_fraction,
            **signals,
        )


def _times(text: str | None) -> list[float] | None:
    if text is None:
        return None
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise ParameterError(
            f"--creep-times {text!r} is not a list of seconds; write them with commas: --creep-times 4,25,150"
        ) from None


def print_direct(fit: DirectFit, request: IdentifyRequest) -> None:
    """Verdict, errors in both directions against the forward families, evidence, findings, the next line."""
    from rich.table import Table
    from rich.text import Text

    out, first = terminal(), fit.recordings[0]
    out.print(Text(fit.verdict, style="bold"))
    out.print()
    table = Table(box=None, pad_edge=False)
    for name in ("", "rms", "rms [% of range]", "max"):
        table.add_column(Text(name), justify="left" if not name else "right")
    part = "held out" if fit.test else "fitted"
    rows: list[tuple[str, Score | None, str]] = [
        (f"input {first.input_name}, fitted", fit.train if fit.test else None, first.input_unit),
        (f"input {first.input_name}, {part}", fit.judged, first.input_unit),
        (f"curve without memory, {part}", fit.static_test or fit.static_train, first.input_unit),
        (f"read forward: {first.output_name}, {part}", fit.judged_forward, first.output_unit),
    ]
    for label, score, unit in rows:
        if score is not None:
            table.add_row(
                Text(label), f"{score.rmse:.4g} {unit}", f"{score.rmse_percent:.2f}", f"{score.max:.4g} {unit}"
            )
    out.print(table)
    out.print()
    for rival in fit.rivals:
        out.print(
            Text(
                f"against {rival.family}: input {rival.inverse_percent:.2f} % of range, output "
                f"{rival.forward_percent:.2f} % ({part})"
            )
        )
    out.print()
    for said in fit.evidence_words:
        out.print(Text(said))
    if fit.lacking:
        out.print(Text(fit.lacking))
    certificate = fit.certificate
    rises = (
        "rises with the output whatever the past" if certificate.rises else "may fall with the output after some past"
    )
    schedules = ", ".join(_schedule_words(schedule) for schedule in fit.model.schedules) or "none"
    times = ", ".join(f"{value:.3g}" for value in fit.model.time_constants)
    out.print(
        Text(
            f"{certificate.nonzero_weights} of {certificate.terms} terms carry weight; degree "
            f"{fit.settings['degree']}; schedules {schedules}; terms of creep {times + ' s' if times else 'none'}; "
            f"start "
            f"'{certificate.initial_state}'\noptimality {certificate.kkt_residual:.0e}; the input {rises}"
        )
    )
    print_findings(fit.warnings)
    print_end(out, _next(fit, request.save), model=request.save, report=request.report, figures=request.figures)


def _schedule_words(schedule: Schedule) -> str:
    """Name and, from outside, range; a mass is said to be one."""
    if not schedule.outside:
        return schedule.name
    mass = " (a mass; no joint controller takes it)" if schedule.unit in MASS_FACTORS else ""
    return f"{schedule.name} {schedule.low:z.4g} to {schedule.high:z.4g} {schedule.unit}".rstrip() + mass


def _next(fit: DirectFit, saved: Path | None) -> str:
    if grade_of(fit.verdict) is Grade.BAD:
        return "do not compensate with this model; cure what the warnings above name and identify again"
    if saved is None:
        return "repeat with --save model.json --report report.html"
    output = quoted(fit.recordings[0].output_name)
    return f"dehyst compensate {quoted(saved)} REFERENCE.csv --output {output}"
