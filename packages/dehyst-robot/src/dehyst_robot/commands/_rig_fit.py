"""dehyst rig fit: numbers of a robot's file from logs, and the file with them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.app import ask_progress, print_end, print_findings, print_json, refuse_existing, table
from dehyst.app import kit as app_kit
from dehyst.arrays import Array
from dehyst.errors import ColumnError, MissingExtraError, ParameterError, UnitError
from dehyst.files import write_atomically
from dehyst.findings import Finding
from dehyst.io import LogColumns, read_columns, read_table
from dehyst.io import kit as io_kit
from dehyst.report import require_picture_name
from dehyst.shell import command
from dehyst.units import convert, dimension
from dehyst_robot.arm import Robot, load_robot, pneumatic_joint_parameters, robot_of
from dehyst_robot.commands._muscle_log import (
    PERCENT,
    contraction_of,
    contraction_of_length,
    read_bench_log,
)
from dehyst_robot.commands._requests import MuscleRequest, RigRequest
from dehyst_robot.experiments import FittedNumber, PlantFit, RigLog
from dehyst_robot.experiments import kit as experiments_kit

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
        raise ParameterError(
            f"there is no log. Type: {command('rig', 'fit', request.file, 'BENCH.csv')}"
        )
    robot = load_robot(request.file)
    number = request.joint or next(iter(robot.pneumatic), 1)
    pneumatic_joint_parameters(robot, number, 0)  # an electric joint is refused
    if request.out is not None:
        refuse_existing(request.out, request.overwrite, own=None)
    if request.figure is not None:
        refuse_existing(request.figure, request.overwrite, own=app_kit.RIGS)
        require_picture_name(request.figure)
    # Findings of all logs are printed together at the end.
    columns, findings = _columns(request.column), list[Finding]()
    logs = []
    for path in (*request.logs, *request.test):
        log = read_rig_log(
            path,
            robot,
            number,
            columns,
            findings,
            run=request.run,
            sheet=request.sheet,
            tested=path in request.test,
        )
        logs.append(log)
    # A fit simulates the joint some hundred times.
    with ask_progress("fitting", quiet=request.json):
        plant_fit = experiments_kit.fit_plant(robot, number, logs)
    source = ", ".join(path.name for path in request.logs)
    following = ""
    if request.out is not None:
        write_atomically(request.out, fitted_text(request.file, request.out, plant_fit, source))
        following = command("rig", "check", request.out)
    if request.figure is not None:
        from dehyst_robot.report import write_fit_figure

        write_fit_figure(request.figure, plant_fit)
    if request.json:
        print_json(_plain(plant_fit, findings))
        return
    _print(plant_fit)
    print_findings(findings, stderr=True)
    print_end(following, robot=request.out, picture=request.figure)


def _columns(typed: tuple[str, ...]) -> dict[str, str]:
    columns = dict[str, str]()
    for text in typed:
        role, equals, name = text.partition("=")
        if role not in ROLES or not equals or not name:
            raise ParameterError(
                f"--column {text!r:.60} is not ROLE=NAME. Roles: {', '.join(ROLES)}."
            )
        columns[role] = name
    return columns


def _names_in(source: Any, columns: Mapping[str, str]) -> dict[str, str]:
    """Role -> name of its column, of the roles that a log has."""
    names = dict[str, str]()
    for role in ROLES:
        if role == "pressure_2" and _constant_pressure(columns):
            continue
        spellings = [columns.get(role, role)]
        # Of two pressures the first may be called pressure_1.
        if role == "pressure" and role not in columns:
            spellings.append("pressure_1")
        for name in spellings:
            try:
                names[role] = io_kit.find_column(source, name, role)
            except ColumnError:
                # A role that was not typed may be missing.
                if role in columns:
                    raise
    return names


def _constant_pressure(columns: Mapping[str, str]) -> re.Match[str] | None:
    """Number and unit, where a pressure was typed instead of the name of a column."""
    return re.fullmatch(r"([0-9.]+) ?([A-Za-z]+)", columns.get("pressure_2", ""))


def read_rig_log(
    path: Path,
    robot: Robot,
    number: int,
    columns: Mapping[str, str],
    findings: list[Finding],
    *,
    run: str | None = None,
    sheet: str | None = None,
    tested: bool = False,
) -> RigLog:
    """Read a log; its columns tell which kind it is.

    `columns`: role -> column, of pressure_2 also a number and unit.
    """
    source = read_table(path, sheet)
    names = _names_in(source, columns)
    constant = _constant_pressure(columns)
    length = robot.muscles_of(number)[0].length
    moving = next((role for role in ("contraction", "length", "angle") if role in names), "")
    joint = moving == "angle"
    has_pair = "pressure" in names and (constant is not None or "pressure_2" in names)
    # What is measured tells what kind of experiment it was.
    if moving and "pressure" in names and "valve" in names:
        quantity = "pressure"
    elif moving and not joint and {"pressure", "force"} <= names.keys():
        request = MuscleRequest(
            contraction=names.get("contraction"),
            length_column=names.get("length") if moving == "length" else None,
            pressure=names["pressure"],
            force=names["force"],
            run=run,
            sheet=sheet,
        )
        log, _ = read_bench_log(path, request, length)
        findings.extend(log.findings)
        # A muscle alone has no partner: the second column means nothing.
        pair = np.stack([log.pressure, log.pressure], axis=1)
        return RigLog(path.name, "force", log.force, pair, log.contraction, log.time, tested=tested)
    elif joint and has_pair and "torque" in names:
        quantity = "torque"
    elif joint and has_pair:
        quantity = "angle"
    else:
        raise ColumnError(
            f"{path.name} has no columns that belong together: found {', '.join(names) or 'none'}. A log needs "
            f"{NEEDED}. Name yours: --column force=LoadCell_N; pressure_2 may be constant: --column pressure_2=2bar.",
            columns=tuple(source.columns),
        )
    roles: tuple[str, ...] = (moving, "pressure", "pressure_2", "torque", "valve")
    # A filling is of one muscle: what else is logged does not matter.
    if quantity == "pressure":
        roles = (moving, "pressure", "valve")
    needed = {role: names[role] for role in roles if role in names}
    table = read_columns(path, needed, run=run, sheet=sheet)
    findings.extend(table.findings)
    pressure = _si(table, "pressure", "pressure", "Pa")
    if quantity == "pressure":
        second = pressure
    elif constant is not None:
        # A constant pressure was typed as a number with its unit.
        second = np.full(pressure.size, float(convert(float(constant[1]), constant[2], "Pa")))
    else:
        second = _si(table, "pressure_2", "pressure", "Pa")
    if joint:
        motion = _si(table, "angle", "angle", "rad")
    elif moving == "length":
        motion = contraction_of_length(table, None, length, findings)
    else:
        motion = contraction_of(table, None, length, findings)
    valve = None
    response = motion
    if quantity == "pressure":
        response, valve = pressure, _command(table)
    elif quantity == "torque":
        response = _si(table, "torque", "torque", "Nm")
    pair = np.stack([pressure, second], axis=1).clip(min=0.0)
    return RigLog(path.name, quantity, response, pair, motion, table.time, valve, joint, tested)


# The unit that a message proposes for a column of a kind.
PROPOSED = {"pressure": "bar", "angle": "deg"}


def _si(columns: LogColumns, role: str, kind: str, unit: str) -> Array:
    logged = columns.units[role]
    if dimension(logged) != kind:
        raise UnitError(
            f"column '{columns.names[role]}' of {columns.name} is in '{logged}', and {role} needs a unit of {kind}: "
            f"call it {columns.names[role]}_{PROPOSED.get(kind, unit)}.",
            unit=logged,
        )
    return np.asarray(convert(columns.values[role], logged, unit))


def _command(columns: LogColumns) -> Array:
    valve = columns.values["valve"]
    if columns.units["valve"] in PERCENT:
        valve = valve / 100.0
    largest = float(np.max(np.abs(valve)))
    if largest > 1.0:
        raise UnitError(
            f"column '{columns.names['valve']}' of {columns.name} goes to {largest:.4g}: the command "
            f"of a valve is -1 .. 1 of its stroke, positive fills. Divide it by the value that opens the valve fully."
        )
    return valve


def _tells(number: FittedNumber) -> str:
    if number.key.startswith("map."):
        return TELLS["map"]
    return TELLS[number.key.rpartition(".")[2]]


def _print(plant_fit: PlantFit) -> None:
    """Print what the logs tell, what they cannot, and the errors of the plant."""
    _print_numbers(plant_fit)
    out = app_kit.terminal()
    rows = []
    for log_fit in plant_fit.logs:
        factor, unit = experiments_kit.UNITS[log_fit.log.quantity]
        figures = [f"{factor * log_fit.errors[key]:.3g}" for key in ERRORS]
        rows.append([log_fit.log.name, f"{log_fit.log.quantity} [{unit}]", *figures])
    heads = ["log", "of", ">fitted: before", ">after", ">held out: before", ">after", ">bent"]
    title = "rms errors of the plant; bent: all numbers moved, told or not"
    out.print(table(heads, rows, title=title))
    # How long what was done to the joint, log by log: it explains what the logs tell.
    for log_fit in plant_fit.logs:
        kinds = ", ".join(f"{kind} {size:.3g}" for kind, size in log_fit.log.kinds.items())
        out.print(f"{log_fit.log.name}: {kinds} [s]")
    for name, value in plant_fit.offsets.items():
        out.print(f"{name} of the logs of angles: {value:.4g} {experiments_kit.OFFSETS[name]}")


def _print_numbers(plant_fit: PlantFit) -> None:
    out = app_kit.terminal()
    fitted, unchanged = [], []
    missing_logs: dict[str, None] = {}
    for number in plant_fit.numbers:
        name, before = experiments_kit.named(number.key, number.place), f"{number.before:.4g}"
        if number.told:
            fitted.append([name, before, f"{number.found:.4g}", f"±{number.interval:.2g}"])
        else:
            unchanged.append([name, before, number.why])
            # One kind of log tells several numbers: it is named once.
            missing_logs[_tells(number)] = None
    if fitted:
        heads = ["number", ">file", ">found", ">95 %"]
        out.print(table(heads, fitted, title="what the logs tell"))
        out.print()
    if unchanged:
        title = "what they cannot tell: the file's number stays"
        out.print(table(["number", ">file", "why"], unchanged, title=title))
        out.print(f"What would tell: {'; '.join(missing_logs)}.\n")


def _plain(plant_fit: PlantFit, findings: list[Finding]) -> dict[str, Any]:
    numbers = []
    for number in plant_fit.numbers:
        numbers.append(asdict(number) | {"what_would_tell": _tells(number)})
    logs = []
    for log_fit in plant_fit.logs:
        entry = {
            "log": log_fit.log.name,
            "kinds": log_fit.log.kinds,
            "quantity": log_fit.log.quantity,
            "tested": log_fit.log.tested,
            "rms": log_fit.errors,
        }
        logs.append(entry)
    return {
        "format": "dehyst-rig-fit",
        "numbers": numbers,
        "logs": logs,
        "offsets": plant_fit.offsets,
        "changes": plant_fit.changes,
        "warnings": [finding.as_dict() for finding in findings],
    }


def fitted_text(file: Path, out: Path, plant_fit: PlantFit, source: str) -> str:
    """Return the text of a robot's file with the fitted values in it, each with its interval; all else stays.

    Raises
    ------
    MissingExtraError
        If tomlkit is not installed.
    """
    try:
        import tomlkit
    except ImportError:
        raise MissingExtraError(
            "writing the fitted file needs the package tomlkit, which is not installed. Type: pip install "
            "dehyst-robot. Without --out the numbers are printed all the same.",
            extra="dehyst-robot",
            module="tomlkit",
        ) from None
    document = tomlkit.parse(file.read_text(encoding="utf-8"))
    for key, value in plant_fit.changes.items():
        *tables, name = key.split(".")
        table: Any = document
        for part in tables:
            if part not in table:
                # A table that the file takes from "extends" is not in it yet.
                table[part] = tomlkit.table(is_super_table=part != tables[-1])
            table = table[part]
        numbers = [number for number in plant_fit.numbers if number.key == key and number.told]
        # The comment says where the number comes from, as every comment of the file does.
        item = tomlkit.value(_toml(value))
        item.comment(f"fitted: {source}; 95 %: {', '.join(map(_interval, numbers))}")
        item.trivia.comment_ws = "  "
        table[name] = item
    text: str = tomlkit.dumps(document)
    robot_of(document.unwrap(), out.name, out.parent)  # what it names is beside it, too
    return text


def _toml(value: Any) -> str:
    """Return a number or a list of them as it stands in the file, to six digits."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return f"{value:.6g}"


def _interval(number: FittedNumber) -> str:
    if number.place == experiments_kit.ALL:
        return f"all ±{100.0 * number.interval / number.found:.2g} %"
    if number.place is None:
        return f"±{number.interval:.2g}"
    return f"[{number.place + 1}] ±{number.interval:.2g}"
