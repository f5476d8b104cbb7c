"""dehyst rig fit: numbers of a robot's file from logs, and the file with them."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.app.targets import RIGS, refuse_existing
from dehyst.app.terminal import ask_progress, print_end, print_findings, print_json, table, terminal
from dehyst.arrays import Array
from dehyst.errors import ColumnError, ParameterError, UnitError
from dehyst.files import write_atomically
from dehyst.findings import Finding
from dehyst.io.columns import find_column
from dehyst.io.formats import read_table
from dehyst.io.logs import Columns, read_columns
from dehyst.report.svg import require_picture_name
from dehyst.robot.arm.joints import pneumatic_joint_parameters
from dehyst.robot.arm.parameters import Robot, load_robot, robot_of
from dehyst.robot.commands.muscle_log import PERCENT, contraction_of, contraction_of_length, read_bench_log
from dehyst.robot.commands.requests import MuscleRequest, RigRequest
from dehyst.robot.experiments.plant_fit import ALL, OFFSETS, UNITS, Number, PlantFit, RigLog, fit_plant, named
from dehyst.shell import command
from dehyst.units import convert, dimension

ROLES = ("contraction", "length", "angle", "pressure", "pressure_2", "force", "torque", "valve")
NEEDED = (
    "contraction or length, pressure and force (a muscle on a bench); angle, pressure, pressure_2, and torque unless "
    "it is constant (a joint); contraction, length or angle, pressure and valve (filling)"
)
ERRORS = ("fitted_before", "fitted_after", "held_out_before", "held_out_after", "held_out_bent")
TELLS = {
    "map": "forces at five lengths and five pressures or more",
    "hysteresis_N": "slow loops of the length at constant pressure",
    "pressure_share": "such loops at two pressures or more",
    "asymmetry": "such loops with small ones inside them, and points at rest",
    "viscous_force_N": "the same loop at 0.01 and 0.2 m/s",
    "creep_force_N": "a hold of minutes after a stroke",
    "creep_pressure_N_bar": "a hold of minutes after a step of pressure, length held",
    "contraction": "torque over the angle at several pairs of pressures",
    "radius_m": "torque over the angle at several pairs of pressures",
    "conductance_l_s_bar": "fillings with known valve command at two lengths",
    "dead_volume_l": "fillings with known valve command at two lengths",
}


def fit(request: RigRequest) -> None:
    """Fit the numbers, print what was told, and write the file and the picture."""
    if not request.logs and not request.test:
        raise ParameterError(f"there is no log. Type: {command('rig', 'fit', request.file, 'BENCH.csv')}")
    robot = load_robot(request.file)
    number = request.joint or next(iter(robot.pneumatic), 1)
    pneumatic_joint_parameters(robot, number, 0)  # an electric joint is refused
    for path, own in ((request.out, None), (request.figure, RIGS)):
        if path is not None:
            refuse_existing(path, request.overwrite, own=own)
    if request.figure is not None:
        require_picture_name(request.figure)
    told, findings = _columns(request.column), list[Finding]()
    logs = [
        read_rig_log(
            path, robot, number, told, findings, run=request.run, sheet=request.sheet, tested=path in request.test
        )
        for path in (*request.logs, *request.test)
    ]
    with ask_progress("fitting", quiet=request.json):
        found = fit_plant(robot, number, logs)
    source = ", ".join(path.name for path in request.logs)
    if request.out is not None:
        write_atomically(request.out, fitted_text(request.file, request.out, found, source))
    if request.figure is not None:
        from dehyst.robot.report.rig import write_fit_figure

        write_fit_figure(request.figure, found)
    if request.json:
        print_json(_plain(found, findings))
        return
    _print(found)
    print_findings(findings, stderr=True)
    following = command("rig", "check", request.out) if request.out else ""
    print_end(following, robot=request.out, picture=request.figure)


def _columns(typed: tuple[str, ...]) -> dict[str, str]:
    found = dict[str, str]()
    for text in typed:
        role, equals, name = text.partition("=")
        if role not in ROLES or not equals or not name:
            raise ParameterError(f"--column {text!r:.60} is not ROLE=NAME. Roles: {', '.join(ROLES)}.")
        found[role] = name
    return found


def read_rig_log(
    path: Path, robot: Robot, number: int, told: Mapping[str, str], findings: list[Finding],
    *, run: str | None = None, sheet: str | None = None, tested: bool = False,
) -> RigLog:  # fmt: skip
    """Read a log; its columns tell which kind it is. `told`: role -> column, of pressure_2 also a number and unit."""
    source, names = read_table(path, sheet), dict[str, str]()
    held = re.fullmatch(r"([0-9.]+) ?([A-Za-z]+)", told.get("pressure_2", ""))
    for role in ROLES:
        if role == "pressure_2" and held:
            continue
        spellings = [told[role]] if role in told else [role, f"{role}_1"] if role == "pressure" else [role]
        for name in spellings:
            try:
                names[role] = find_column(source, name, role)
            except ColumnError:
                if role in told:
                    raise
    moved = next((role for role in ("contraction", "length", "angle") if role in names), "")
    second, length = held or "pressure_2" in names, robot.muscles_of(number)[0].length
    joint = moved == "angle"
    if moved and "pressure" in names and "valve" in names:
        quantity = "pressure"
    elif moved and not joint and {"pressure", "force"} <= names.keys():
        request = MuscleRequest(
            contraction=names.get("contraction"), length_column=names[moved] if moved == "length" else None,
            pressure=names["pressure"], force=names["force"], run=run, sheet=sheet,
        )  # fmt: skip
        log, _ = read_bench_log(path, request, length)
        findings.extend(log.findings)
        pair = np.stack([log.pressure, log.pressure], axis=1)
        return RigLog(path.name, "force", log.force, pair, log.contraction, log.time, tested=tested)
    elif joint and "pressure" in names and second:
        quantity = "torque" if "torque" in names else "angle"
    else:
        raise ColumnError(
            f"{path.name} has no columns that belong together: found {', '.join(names) or 'none'}. A log needs "
            f"{NEEDED}. Name yours: --column force=LoadCell_N; pressure_2 may be constant: --column pressure_2=2bar.",
            columns=tuple(source.columns),
        )
    wanted = [role for role in (moved, "pressure", "pressure_2", "torque", "valve") if role in names]
    if quantity == "pressure":
        wanted = [moved, "pressure", "valve"]
    columns = read_columns(path, {role: names[role] for role in wanted}, run=run, sheet=sheet)
    findings.extend(columns.findings)
    pressure = _si(columns, "pressure", "pressure", "Pa")
    if quantity == "pressure":
        other = pressure
    elif held:
        other = np.full(pressure.size, float(convert(float(held[1]), held[2], "Pa")))
    else:
        other = _si(columns, "pressure_2", "pressure", "Pa")
    if joint:
        angle = _si(columns, "angle", "angle", "rad")
    else:
        angle = (contraction_of_length if moved == "length" else contraction_of)(columns, None, length, findings)
    response = {"pressure": lambda: pressure, "angle": lambda: angle,
                "torque": lambda: _si(columns, "torque", "torque", "Nm")}[quantity]()  # fmt: skip
    valve = _command(columns) if quantity == "pressure" else None
    pair = np.stack([pressure, other], axis=1).clip(min=0.0)
    return RigLog(path.name, quantity, response, pair, angle, columns.time, valve, joint, tested)


def _si(columns: Columns, role: str, kind: str, unit: str) -> Array:
    given = columns.units[role]
    if dimension(given) != kind:
        raise UnitError(
            f"column '{columns.names[role]}' of {columns.name} is in '{given}', and {role} needs a unit of {kind}: "
            f"call it {columns.names[role]}_{'bar' if kind == 'pressure' else 'deg' if kind == 'angle' else unit}.",
            unit=given,
        )
    return np.asarray(convert(columns.values[role], given, unit))


def _command(columns: Columns) -> Array:
    valve = columns.values["valve"] / (100.0 if columns.units["valve"] in PERCENT else 1.0)
    if float(np.max(np.abs(valve))) > 1.0:
        raise UnitError(
            f"column '{columns.names['valve']}' of {columns.name} goes to {np.max(np.abs(valve)):.4g}: the command "
            f"of a valve is -1 .. 1 of its stroke, positive fills. Divide it by the value that opens the valve fully."
        )
    return valve


def _tells(number: Number) -> str:
    return TELLS["map" if number.key.startswith("map.") else number.key.rpartition(".")[2]]


def _print(found: PlantFit) -> None:
    out, told, lost = terminal(), *([n for n in found.numbers if n.told is which] for which in (True, False))
    rows = [
        [named(each.key, each.place), f"{each.before:.4g}", f"{each.found:.4g}", f"±{each.interval:.2g}"]
        for each in told
    ]
    if told:
        out.print(table(["number", ">file", ">found", ">95 %"], rows, title="what the logs tell"))
        out.print()
    if lost:
        rows = [[named(each.key, each.place), f"{each.before:.4g}", each.why] for each in lost]
        out.print(table(["number", ">file", "why"], rows, title="what they cannot tell: the file's number stays"))
        out.print(f"What would tell: {'; '.join(dict.fromkeys(map(_tells, lost)))}.\n")
    rows = []
    for each in found.logs:
        factor, unit = UNITS[each.log.quantity]
        figures = [f"{factor * each.errors[key]:.3g}" for key in ERRORS]
        rows.append([each.log.name, f"{each.log.quantity} [{unit}]", *figures])
    heads = ["log", "of", ">fitted: before", ">after", ">held out: before", ">after", ">bent"]
    out.print(table(heads, rows, title="rms errors of the plant; bent: all numbers moved, told or not"))
    for each in found.logs:
        out.print(f"{each.log.name}: {', '.join(f'{kind} {size:.3g}' for kind, size in each.log.kinds.items())} [s]")
    for name, value in found.offsets.items():
        out.print(f"{name} of the logs of angles: {value:.4g} {OFFSETS[name]}")


def _plain(found: PlantFit, findings: list[Finding]) -> dict[str, Any]:
    return {
        "format": "dehyst-rig-fit",
        "numbers": [asdict(number) | {"what_would_tell": _tells(number)} for number in found.numbers],
        "logs": [{"log": each.log.name, "kinds": each.log.kinds, "quantity": each.log.quantity,
                  "tested": each.log.tested, "rms": each.errors} for each in found.logs],
        "offsets": found.offsets,
        "changes": found.changes,
        "warnings": [finding.as_dict() for finding in findings],
    }  # fmt: skip


def fitted_text(file: Path, out: Path, found: PlantFit, source: str) -> str:
    """Return the text of a robot's file with the fitted values in it, each with its interval; all else stays."""
    lines = file.read_text(encoding="utf-8").splitlines()
    for key, value in found.changes.items():
        intervals = [_interval(number) for number in found.numbers
                     if number.key == key and number.told]  # fmt: skip
        start, _, name = key.rpartition(".")
        numbers = [f"{each:.6g}" for each in (value if isinstance(value, list | tuple) else [value])]
        text = f"[{', '.join(numbers)}]" if isinstance(value, list | tuple) else numbers[0]
        _put(lines, start, name, f"{name} = {text}  # fitted: {source}; 95 %: {', '.join(intervals)}")
    text = "\n".join(lines) + "\n"
    wrong = [key for key, value in found.changes.items() if not _holds(text, key, value)]
    if wrong:
        raise ParameterError(
            f"{file.name} says {', '.join(wrong)} in a way that is not changed by rule (a list over several lines, "
            f"or a dotted key). Write it as [TABLE] and KEY = VALUE in one line, and fit again."
        )
    robot_of(tomllib.loads(text), out.name, out.parent)  # what it names is beside it, too
    return text


def _interval(number: Number) -> str:
    if number.place == ALL:
        return f"all ±{100.0 * number.interval / number.found:.2g} %"
    return f"{'' if number.place is None else f'[{number.place + 1}] '}±{number.interval:.2g}"


def _holds(text: str, key: str, value: Any) -> bool:
    try:
        held: Any = tomllib.loads(text)
        for part in key.split("."):
            held = held[part]
        return bool(np.allclose(held, value, rtol=1e-5))
    except (tomllib.TOMLDecodeError, KeyError, TypeError, ValueError):
        return False


def _put(lines: list[str], start: str, name: str, line: str) -> None:
    """Replace a key in its table, or add it, with the table if need be."""
    heads = [k for k, text in enumerate(lines) if re.match(rf"\[{re.escape(start)}\]", text)]
    if not heads:
        lines += ["", f"[{start}]", line]
        return
    end = next((k for k in range(heads[0] + 1, len(lines)) if lines[k].startswith("[")), len(lines))
    there = [k for k in range(heads[0] + 1, end) if re.match(rf"{re.escape(name)}\s*=", lines[k])]
    if there:
        lines[there[0]] = line
    else:
        lines.insert(heads[0] + 1, line)
