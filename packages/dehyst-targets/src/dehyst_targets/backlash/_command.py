"""dehyst backlash: a guided measurement of an axis, its lost motion, the table that a machine reads."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.app import (
    Status,
    concluding,
    print_end,
    print_findings,
    print_json,
    refuse_clashes,
    refuse_existing,
    refuse_unwritable,
    table,
)
from dehyst.app import kit as app_kit
from dehyst.arrays import Array
from dehyst.errors import LogError, ParameterError
from dehyst.files import text_of, write_atomically
from dehyst.shell import command
from dehyst_targets.backlash._figure import TITLE, write_backlash_figure
from dehyst_targets.backlash._lost_motion import LostMotion, lost_motion
from dehyst_targets.backlash._machines import MACHINES, machine_named
from dehyst_targets.backlash._plan import MeasurementPlan, plan_measurement
from dehyst_targets.backlash._readings import read_measurement
from dehyst_targets.backlash._requests import BacklashRequest
from dehyst_targets.backlash._write import BacklashTable, checked_table, make_table, write_table
from dehyst_targets.commands import refuse_picture

APPROACH = 2.0  # of a plan where none is typed [unit]
Errors = LostMotion | BacklashTable


def run_backlash(request: BacklashRequest) -> None:
    """Plan a measurement, write the table of one, or check a table."""
    if request.action not in ACTIONS:
        raise ParameterError(
            f"'{request.action:.30}' is no action of dehyst backlash. Type one of: {', '.join(ACTIONS)}."
        )
    ACTIONS[request.action](request)


def _plan(request: BacklashRequest) -> None:
    if request.start is None or request.stop is None or request.files:
        raise ParameterError(
            "a plan needs the ends of the way, and no file. Type e.g. "
            "dehyst backlash plan --from 0 --to 300 --gcode plan.ngc --sheet measure.csv"
        )
    machine = request.machine or "linuxcnc"
    plan = plan_measurement(
        request.start,
        request.stop,
        points=request.points,
        approach=request.approach or (APPROACH,),
        repeats=request.repeats,
        unit=request.unit or "mm",
        rate=request.rate,
        hold=request.hold,
    )
    program = plan.gcode(machine, request.axis, pause=request.pause)
    sheet = None
    if request.sheet is not None:
        sheet = Path(request.sheet)
    texts = ((request.gcode, program), (sheet, plan.sheet()))
    refuse_clashes([], True, gcode=(request.gcode, None), sheet=(sheet, None))
    for path, text in texts:
        if path is not None:
            # A sheet that is being filled in must not be lost.
            refuse_existing(path, request.overwrite, content=text)
    for path, text in texts:
        if path is not None:
            write_atomically(path, text)
    if request.json:
        print_json(_plan_facts(plan, machine, request.axis))
        return
    _print_plan(plan, machine, request, sheet)


def _plan_facts(plan: MeasurementPlan, machine: str, axis: str) -> dict[str, Any]:
    return {
        "format": "dehyst-backlash-plan",
        "machine": machine,
        "axis": axis,
        "unit": plan.unit,
        "low": plan.low,
        "high": plan.high,
        "rate": plan.rate,
        "hold_s": plan.hold,
        "duration_s": plan.duration,
        "readings": [
            {
                "repeat": reading.repeat,
                "approach": reading.approach,
                "commanded": reading.commanded,
                "direction": _direction(reading.rising),
            }
            for reading in plan.readings
        ],
    }


def _direction(rising: bool) -> str:
    if rising:
        return "rising"
    return "falling"


def _print_plan(
    plan: MeasurementPlan, machine: str, request: BacklashRequest, sheet: Path | None
) -> None:
    out = app_kit.terminal()
    form = MACHINES[machine]
    points = np.unique([reading.commanded for reading in plan.readings]).size
    out.print(
        f"{len(plan.readings)} readings of {request.axis} at {points} points, each from below and from above, "
        f"{plan.duration / 60.0:.1f} min at {plan.rate:g} {plan.unit}/s",
        style="bold",
    )
    out.print(
        f"The axis goes from {plan.low:g} to {plan.high:g} {plan.unit}: its limits must lie beyond."
    )
    out.print(f"{form.title}: {form.switched_off}")
    following = "the same line with --gcode plan.ngc --sheet measure.csv writes program and sheet"
    if sheet is not None:
        options: dict[str, object] = {"axis": request.axis}
        if form.files is not None:
            options["out"] = machine
        following = (
            f"warm up, home, run the program, write down each reading in the last column of the sheet; then\n"
            f"{command('backlash', 'table', sheet, machine=machine, **options)}"
        )
    print_end(following, program=request.gcode, sheet=sheet)


def _table(request: BacklashRequest) -> None:
    if len(request.files) != 1:
        raise ParameterError(
            f"{len(request.files)} files are named. Name the filled sheet: "
            f"dehyst backlash table measure.csv --machine linuxcnc --axis X --out FOLDER"
        )
    machine = _machine(request)
    sheet = request.files[0]
    lost = _measured(request, sheet)
    made = make_table(lost, machine, request.axis, smoothing=request.smoothing)
    _refuse_lost_files(request, made, sheet)
    if request.out is not None:
        write_table(lost, machine, request.axis, request.out, smoothing=request.smoothing)
    if request.figure is not None:
        title = f"{request.axis} axis, {lost.nominal.size} points, for {MACHINES[machine].title}"
        write_backlash_figure(request.figure, lost, made, title)
    with _verdict(bool(made.files)):
        if request.json:
            print_json(_facts(lost, made, machine, request.axis))
        else:
            _print(lost, made, machine, request)


def _verdict(yes: bool) -> AbstractContextManager[None]:
    """Return what prints and ends with status 1 after a no, even if its reader leaves."""
    if yes:
        return nullcontext()
    return concluding(Status.NO)


def _machine(request: BacklashRequest) -> str:
    """Return the machine that was typed, which has the axis that was typed."""
    if request.machine is None:
        raise ParameterError(
            f"nothing says for which machine. Type one of: --machine {', --machine '.join(MACHINES)}"
        )
    machine_named(request.machine, request.axis)
    return request.machine


def _measured(request: BacklashRequest, sheet: Path) -> LostMotion:
    if not 0.0 <= request.smoothing < float("inf"):
        raise ParameterError(
            f"--smoothing {request.smoothing:g} is no way. Type 0, or e.g. 3 [mm]."
        )
    readings = read_measurement(
        sheet,
        commanded=request.input,
        measured=request.output,
        unit=request.unit,
        sheet=request.sheet,
    )
    return lost_motion(readings)


def _refuse_lost_files(request: BacklashRequest, made: BacklashTable, sheet: Path) -> None:
    """Refuse outputs that cannot be written or would cost a file that is there."""
    targets: dict[str, tuple[Path | None, str | None]] = {"figure": (request.figure, None)}
    refuse_picture(request.figure, TITLE, request.overwrite)
    if request.out is not None:
        refuse_unwritable(request.out, folder=True)
        for name, text in made.files.items():
            refuse_existing(request.out / name, request.overwrite, content=text)
    refuse_clashes([sheet], True, **targets)


def _facts(lost: LostMotion, made: BacklashTable, machine: str, axis: str) -> dict[str, Any]:
    findings = [*lost.findings]
    if made.reason is not None:
        findings.append(made.reason)
    return {
        "format": "dehyst-backlash",
        "machine": machine,
        "axis": axis,
        "unit": lost.unit,
        "nominal": lost.nominal.tolist(),
        "rising": lost.rising.tolist(),
        "falling": lost.falling.tolist(),
        "lost_motion": lost.lost_motion.tolist(),
        "interval": lost.interval.tolist(),
        "counts": lost.counts.tolist(),
        "mean": lost.mean,
        "mean_interval": lost.mean_interval,
        "spread": lost.spread,
        "freedom": lost.freedom,
        "is_significant": lost.is_significant,
        "is_pitch_significant": lost.is_pitch_significant,
        "offset": lost.offset,
        "files": dict(made.files),
        "left": {"rising": made.rising.tolist(), "falling": made.falling.tolist()},
        "warnings": [finding.as_dict() for finding in findings],
    }


def _print(lost: LostMotion, made: BacklashTable, machine: str, request: BacklashRequest) -> None:
    _print_points(lost)
    findings = list(lost.findings)
    if made.reason is not None:
        findings.append(made.reason)
        print_findings(findings)
        print_end("", picture=request.figure)
        return
    app_kit.terminal().print()
    _print_left(lost, made)
    app_kit.terminal().print(
        f"read back as the machine reads it: within {made.read_back:.1g} {lost.unit} of what was meant"
    )
    _print_limits(lost, machine)
    print_findings(findings)
    written = {}
    if request.out is not None:
        for name in made.files:
            written[name] = request.out / name
    else:
        _print_files(made)
    following = MACHINES[machine].install
    if request.out is None:
        following = f"the same line with --out FOLDER writes it; {following}"
    print_end(following, picture=request.figure, **written)


def _print_points(lost: LostMotion) -> None:
    out = app_kit.terminal()
    digits = _digits(lost)
    rows = []
    for k, nominal in enumerate(lost.nominal):
        below, above = lost.counts[:, k]
        rows.append(
            (
                f"{nominal:g}",
                f"{lost.rising[k]:+z.{digits}f}",
                f"{lost.falling[k]:+z.{digits}f}",
                f"{lost.lost_motion[k]:+z.{digits}f}",
                f"{lost.interval[k]:.{digits}f}",
                f"{below} + {above}",
            )
        )
    heads = (
        f">nominal [{lost.unit}]", ">error rising", ">error falling", ">lost motion", ">±", ">readings",
    )  # fmt: skip
    out.print(table(heads, rows))
    out.print()
    low, high = float(lost.lost_motion.min()), float(lost.lost_motion.max())
    out.print(
        f"lost motion: {lost.mean:.{digits}f} ± {lost.mean_interval:.{digits}f} {lost.unit} on average, "
        f"{low:.{digits}f} to {high:.{digits}f} over the axis (intervals: 95 %)",
        style="bold",
    )
    out.print(
        f"one reading repeats to {lost.spread:.{digits}f} {lost.unit} (1 standard deviation, {lost.freedom} degrees of "
        f"freedom); {lost.offset:+z.{digits}f} {lost.unit} were taken from all errors, so that the mean of both "
        f"directions is 0 at {lost.nominal[lost.reference]:g}"
    )


def _digits(lost: LostMotion) -> int:
    """Decimals that show the spread, between 3 and 6."""
    return int(np.clip(np.ceil(-np.log10(max(lost.spread, 1e-9))), 3, 6))


def _print_left(lost: LostMotion, made: BacklashTable) -> None:
    digits = _digits(lost)
    rows = []
    for name, figure in FIGURES_LEFT.items():
        rows.append((name, f"{figure(lost):.{digits}f}", f"{figure(made):.{digits}f}"))
    out = app_kit.terminal()
    out.print(table((f"[{lost.unit}]", ">measured", ">left at these points"), rows))


def _largest(values: Array) -> float:
    return float(np.abs(values).max())


def _rms(errors: Errors) -> float:
    return float(np.sqrt(np.mean(np.square([errors.rising, errors.falling]))))


FIGURES_LEFT: dict[str, Callable[[Errors], float]] = {
    "largest error": lambda errors: max(_largest(errors.rising), _largest(errors.falling)),
    "error, rms": _rms,
    "largest lost motion": lambda errors: _largest(errors.lost_motion),
    "mean of both directions, largest": lambda errors: _largest(errors.middle),
}


def _print_limits(lost: LostMotion, machine: str) -> None:
    """What no table of this kind compensates."""
    form = MACHINES[machine]
    digits = _digits(lost)
    limits = [
        f"repeatability: a new reading at a point may be off by {lost.expected:.{digits}f} {lost.unit} (2 standard "
        f"deviations, those of the table included)"
    ]
    if form.one_number:
        limits.append(f"what varies over the axis, because {form.title} knows one number an axis")
    else:
        limits.append(
            f"a bend of the error between two points: about {lost.between:.{digits}f} {lost.unit}"
        )
    limits.append(form.limit)
    out = app_kit.terminal()
    out.print("\nnot compensated:")
    for limit in limits:
        out.print(f"- {limit}")


def _print_files(made: BacklashTable) -> None:
    out = app_kit.terminal()
    for name, text in made.files.items():
        out.print(f"\n{name}:", style="bold")
        out.print(text.rstrip(), soft_wrap=True)


def _check(request: BacklashRequest) -> None:
    if len(request.files) != 2:
        raise ParameterError(
            f"{len(request.files)} files are named. Name the table and the sheet: "
            f"dehyst backlash check x.comp measure.csv --machine linuxcnc"
        )
    machine = _machine(request)
    place, sheet = request.files
    lost = _measured(request, sheet)

    def refused(trouble: str) -> LogError:
        return LogError(f"the table '{place}' {trouble}. Name a file of `dehyst backlash table`.")

    made = checked_table(text_of(place, refused), lost, machine, request.axis)
    helps = _rms(made) < _rms(lost)
    with _verdict(helps):
        if request.json:
            print_json(_facts(lost, made, machine, request.axis) | {"helps": helps})
            return
        _print_left(lost, made)
        print_findings(lost.findings)
        _print_verdict(place, machine, helps)


def _print_verdict(place: Path, machine: str, helps: bool) -> None:
    verdict = "it does not lower the error of this measurement"
    if helps:
        verdict = "it lowers the error of this measurement"
    out = app_kit.terminal()
    out.print(
        f"\n{place.name}, read as {MACHINES[machine].title} reads it: {verdict}", style="bold"
    )


ACTIONS = {"plan": _plan, "table": _table, "check": _check}
