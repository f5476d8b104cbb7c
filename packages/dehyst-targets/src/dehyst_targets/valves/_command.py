"""dehyst valve: whether the valve of a control loop sticks, and what to log where that cannot be told."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext

import numpy as np

from dehyst.app import (
    Status,
    ask_progress,
    concluding,
    print_end,
    print_findings,
    print_json,
    refuse_clashes,
    refuse_existing,
    table,
)
from dehyst.app import kit as app_kit
from dehyst.files import write_atomically
from dehyst.findings import Grade
from dehyst.io import format_csv
from dehyst.shell import command, visible
from dehyst_targets.commands import reading_options, refuse_picture
from dehyst_targets.valves._figure import TITLE, write_valve_figure
from dehyst_targets.valves._loop import read_control_loop
from dehyst_targets.valves._policy import POLICY
from dehyst_targets.valves._requests import ValveRequest
from dehyst_targets.valves._verdict import UNKNOWN, ValveVerdict, judge_valve, step_test


def run_valve(request: ValveRequest) -> None:
    """Read, judge, write, print."""
    refuse_clashes([request.log], True, test=(request.test, None), figure=(request.figure, None))
    refuse_picture(request.figure, TITLE, request.overwrite)
    with ask_progress("reading", request.json):
        loop = read_control_loop(
            request.log,
            setpoint=request.setpoint,
            output=request.output,
            measurement=request.measurement,
            position=request.position,
            span=request.span,
            **reading_options(request),
        )
    with ask_progress("fitting valves", request.json):
        verdict = judge_valve(loop)
    if request.test is not None:
        _write_test(verdict, request)
    if request.figure is not None:
        write_valve_figure(request.figure, verdict)
    with _ending(verdict):
        if request.json:
            print_json(verdict.as_dict())
        else:
            _print(verdict, request)


def _ending(verdict: ValveVerdict) -> AbstractContextManager[None]:
    """Return what prints, and ends with status 4 where it cannot be told."""
    if verdict.kind == UNKNOWN:
        return concluding(Status.CANNOT_TELL)
    return nullcontext()


def _write_test(verdict: ValveVerdict, request: ValveRequest) -> None:
    assert request.test is not None
    time, output = step_test(verdict)
    text = format_csv({"time_s": np.round(time, 9), "OP_%": np.round(output, 6)}, request.test)
    # A test that is being run must not be lost.
    refuse_existing(request.test, request.overwrite, content=text)
    write_atomically(request.test, text)


def _print(verdict: ValveVerdict, request: ValveRequest) -> None:
    out = app_kit.terminal()
    out.print(verdict.words, style="bold", soft_wrap=True)
    if verdict.kind != UNKNOWN:
        grade = f"grade: {verdict.grade.words}"
        if verdict.reason:
            grade = f"{grade}, {verdict.reason}"
        out.print(grade)
    out.print()
    rows = table(("", ">", ""), _rows(verdict))
    rows.show_header = False
    out.print(rows)
    print_findings(verdict.findings)
    print_end(_following(verdict, request), picture=request.figure, test=request.test)


def _rows(verdict: ValveVerdict) -> list[tuple[str, str, str]]:
    """Numbers that the verdict rests on."""
    fit, evidence = verdict.fit, verdict.fit.evidence
    unit = "samples"
    if verdict.loop.is_timed:
        unit = "s"
    cycles = f"{fit.cycles:g} cycles of about {fit.period * verdict.loop.period:.4g} {unit}"
    counts = f"Schwarz's criterion, above {POLICY.certain:g} counts"
    rows = [
        ("controller output swings by", f"{fit.swing:.3g} %", cycles),
        ("controller", verdict.mode, _law_words(verdict)),
        ("sticking over following", f"{evidence.over_linear:+.0f}", counts),
    ]
    if verdict.loop.position is None and verdict.mode != "manual":
        rows.append(("sticking over disturbed", f"{evidence.over_periodic:+.0f}", counts))
    rows.append(
        (
            "gain over standard error",
            f"{evidence.steadiness:.1f}",
            f"between blocks, above {POLICY.steady:g} counts",
        )
    )
    return rows


def _law_words(verdict: ValveVerdict) -> str:
    if verdict.explained is None:
        return "the measurement is not named"
    return f"explains {100.0 * verdict.explained:.0f} % of the changes of its output"


def _following(verdict: ValveVerdict, request: ValveRequest) -> str:
    """Return what to type or to do next."""
    if verdict.kind != UNKNOWN and (verdict.grade is Grade.GOOD or request.test is not None):
        if request.figure is not None:
            return ""
        return _line(request, figure="valve.svg")
    if request.test is None:
        return _line(request, test="test.csv")
    columns = command(
        "valve",
        "NEW.csv",
        output=request.output,
        measurement=request.measurement,
        position=request.position,
    )
    return f"put the controller in manual, run {visible(str(request.test))} as its output, log it; then\n{columns}"


def _line(request: ValveRequest, **more: object) -> str:
    return command(
        "valve",
        request.log,
        setpoint=request.setpoint,
        output=request.output,
        measurement=request.measurement,
        position=request.position,
        span=request.span,
        **more,
    )
