"""dehyst muscle --log: converts the columns of a test-bench log to contraction, pressure and force in SI units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError, RecordingError, UnitError
from dehyst.findings import Finding
from dehyst.io.logs import Columns, read_columns
from dehyst.robot.commands.requests import MuscleRequest
from dehyst.robot.muscles.bench_log import BenchLog
from dehyst.units import MASS_FACTORS, canonical, convert, dimension, mass_unit

PERCENT = ("%", "percent", "pct", "per cent", "prozent")
PLAIN = ("", "1", "-", "ratio", "mm/mm", "m/m")
SHORTEST, LONGEST = -0.15, 0.5  # contraction: beyond it a unit or a length is wrong
STRONGEST = 2e6  # Pa; no muscle takes 20 bar
WEAKEST = 1e4  # Pa; a log that stays below a tenth of a bar is in another unit
HARDEST = 1e5  # N; the strongest muscles built, for water hydraulics, pull about 28 kN
STILL = 0.005  # contraction; a log that stays below half a percent may hold a number, not percent
VACUUM = -2e4  # Pa gauge; offsets of sensors are smaller
ATMOSPHERE = 101325.0  # Pa
GRAVITY = 9.80665  # m/s^2, standard
# Largest value up to which a pressure without a unit is taken for one, in order.
PRESSURES, FORCES, LENGTHS = ("kPa", "MPa", "bar", "psi", "mbar", "Pa"), ("kN", "lbf", "N"), ("mm", "cm", "m", "in")
GUESSES = ((12.0, "bar"), (1200.0, "kPa"), (12_000.0, "mbar"), (float("inf"), "Pa"))


def read_bench_log(path: Path, request: MuscleRequest, length: float | None) -> tuple[BenchLog, dict[str, Any]]:
    """Read a bench log; return it in SI units, and where it comes from.

    The `length` at rest [m] is needed where the log holds lengths.
    """
    if request.contraction is not None and request.length_column is not None:
        raise ParameterError("--contraction and --length-column both name what moves. Leave one of them out.")
    role = "length" if request.length_column is not None else "contraction"
    wanted = {
        role: request.length_column or request.contraction or "contraction",
        "pressure": request.pressure,
        "force": request.force,
    }
    table = read_columns(
        path, wanted, time=request.time, run=request.run, start=request.start, stop=request.stop,
        time_unit=request.time_unit, sheet=request.sheet, dt=request.dt,
    )  # fmt: skip
    findings = [entry for entry in table.findings if entry.code != "no-time"]
    read = contraction_of_length if role == "length" else contraction_of
    moved = read(table, request.contraction_unit, length, findings)
    pressure = _pressure(table, request, findings)
    force = _force(table, request.force_unit, findings)
    _refuse_range(moved, role)
    _ask_absolute(pressure, force, request.absolute, findings)
    time = None if request.at_rest else table.time
    log = BenchLog(moved, pressure, force, time, table.name, tuple(findings))
    return log, dict(table.provenance)


def _another(candidates: Sequence[str], taken: str, fits: Callable[[str], bool]) -> str | None:
    """Return a unit that a nameless column may have in the place of the one that was taken: none that is refused."""
    return next((unit for unit in candidates if unit != taken and fits(unit)), None)


def _unit(table: Columns, role: str, option: str | None) -> str:
    return option if option is not None else table.units[role]


def _known(table: Columns, role: str, unit: str, kind: str, flag: str) -> None:
    """Refuse a unit of another kind."""
    found = dimension(unit)
    if found != kind:
        what = f"a unit of {found}" if found else "no unit that is known"
        raise UnitError(
            f"column '{table.names[role]}' of {table.name} is in '{unit}', {what}, but {role} needs one of {kind}. "
            f"Check that it is the right column, or say its unit: {flag}.",
            unit=unit,
        )


def contraction_of(table: Columns, option: str | None, length: float | None, findings: list[Finding]) -> Array:
    """Contraction as a number, from one, from percent, or from a shortening in a unit of length."""
    values, unit = table.values["contraction"], _unit(table, "contraction", option)
    if unit.lower() in PERCENT or (not unit and _says_percent(table.names["contraction"])):
        return _doubt_percent(values / 100.0, table.names["contraction"], findings)
    if dimension(unit) == "length":
        if length is None:
            raise ParameterError(
                f"column '{table.names['contraction']}' of {table.name} is in {unit}: a shortening, of which only the "
                f"length at rest makes a contraction. Say it: --length 300mm"
            )
        return np.asarray(convert(values, unit, "m")) / length
    if unit.lower() not in PLAIN:
        _known(table, "contraction", unit, "length", "--contraction-unit percent, --contraction-unit mm")
    largest = float(np.max(np.abs(values)))
    if largest <= 1.0:
        return values
    findings.append(
        Finding(
            "muscle-unit-guessed",
            f"contraction goes up to {largest:.4g} in column '{table.names['contraction']}', which names no unit: "
            f"taken as percent. If it is a length: --contraction-unit mm, and --length 300mm or what it is at rest.",
        )
    )
    return values / 100.0


def _doubt_percent(contraction: Array, name: str, findings: list[Finding]) -> Array:
    """Say so where percent are so small that they look like a number between 0 and 1."""
    largest = float(np.max(np.abs(contraction)))
    if 0.0 < largest < STILL and float(np.ptp(contraction)) > 0.1 * largest:
        findings.append(
            Finding(
                "muscle-unit-guessed",
                f"column '{name}' is in percent, but reaches only {100.0 * largest:.2g} %, a stroke that can hardly be "
                f"measured. If it holds a number from 0 to 1: --contraction-unit 1.",
            )
        )
    return contraction


def _says_percent(name: str) -> bool:
    return any(name.lower().endswith(word) for word in ("percent", "pct", "prozent", "%"))


def contraction_of_length(table: Columns, option: str | None, length: float | None, findings: list[Finding]) -> Array:
    """Contraction from the length of the muscle."""
    values, unit = table.values["length"], _unit(table, "length", option)
    if length is None:
        raise ParameterError(
            f"column '{table.names['length']}' of {table.name} holds lengths; contraction counts from the length "
            f"without pressure and load. Say it: --length 300mm"
        )
    if not unit:
        unit = "m" if np.median(values) < 20.0 * length else "mm"
        other = _another(LENGTHS, unit, lambda each: _within(1.0 - np.asarray(convert(values, each, "m")) / length))
        cure = f"If it is in another one: --contraction-unit {other}." if other else "No other unit fits that length."
        findings.append(
            Finding(
                "muscle-unit-guessed",
                f"column '{table.names['length']}' names no unit: taken as {unit}, which fits --length {length:g} m. "
                f"{cure}",
            )
        )
    _known(table, "length", unit, "length", "--contraction-unit mm")
    return 1.0 - np.asarray(convert(values, unit, "m")) / length


def _pressure(table: Columns, request: MuscleRequest, findings: list[Finding]) -> Array:
    """Gauge pressure in Pa; a unit that is not named is guessed and said, one that cannot be is refused."""
    values, unit = table.values["pressure"], _unit(table, "pressure", request.pressure_unit)
    largest, name = float(np.max(values)), table.names["pressure"]
    if not unit:
        unit = next(found for limit, found in GUESSES if largest <= limit)
        other = _another(
            PRESSURES, unit, lambda each: WEAKEST <= float(np.asarray(convert(largest, each, "Pa"))) <= STRONGEST
        )
        findings.append(_unit_guessed(name, largest, unit, "--pressure-unit", other))
    _known(table, "pressure", unit, "pressure", "--pressure-unit bar")
    found = np.asarray(convert(values, unit, "Pa")) - (ATMOSPHERE if request.absolute else 0.0)
    if largest <= 0.0:
        raise UnitError(
            f"column '{name}' of {table.name} is never above {largest:.4g}: a muscle pulls when its pressure is above "
            f"the ambient. Check the column, its sign and its zero.",
            largest=largest,
        )
    if not WEAKEST <= float(found.max()) <= STRONGEST:
        likely = next(other for limit, other in GUESSES if largest <= limit)
        cure = f"--pressure-unit {likely}" if likely != canonical(unit) else "--pressure-unit with the right one"
        raise UnitError(
            f"column '{name}' of {table.name} goes up to {largest:.4g} {unit}, but muscles are driven with 0.1 to 20 "
            f"bar: its unit is another one. Say it: {cure}",
            unit=unit,
            largest=largest,
        )
    if float(found.min()) < VACUUM:
        cure = "leave --absolute out" if request.absolute else "check the column and its zero"
        raise UnitError(
            f"column '{name}' of {table.name} goes down to {found.min() / 1e5:.3g} bar below the ambient. A muscle is "
            f"not driven with vacuum: {cure}.",
            lowest=float(found.min()),
        )
    return found


def _force(table: Columns, option: str | None, findings: list[Finding]) -> Array:
    unit = _unit(table, "force", option)
    mass = mass_unit(table.names["force"], unit)
    if mass:
        findings.append(
            Finding(
                "muscle-mass",
                f"column '{table.names['force']}' is in {mass}, a mass: taken as the force that it weighs, {GRAVITY} "
                f"N for 1 kg, as load cells are calibrated. Otherwise say the unit: --force-unit N.",
            )
        )
        found = table.values["force"] * (MASS_FACTORS[mass] * GRAVITY)
    else:
        if not unit:
            largest = float(np.max(np.abs(table.values["force"])))
            other = _another(FORCES, "N", lambda each: float(np.asarray(convert(largest, each, "N"))) <= HARDEST)
            findings.append(_unit_guessed(table.names["force"], largest, "N", "--force-unit", other))
        _known(table, "force", unit or "N", "force", "--force-unit N")
        found = np.asarray(convert(table.values["force"], unit or "N", "N"))
    if float(found.max()) <= 0.05 * float(-found.min()):
        findings.append(
            Finding(
                "muscle-force-sign",
                f"column '{table.names['force']}' is negative where the muscle pulls ({found.min():.4g} N): its sign "
                f"was turned, since a pull counts as positive here. Nothing to do.",
            )
        )
        found = -found
    if not float(found.max()) > 0:
        raise RecordingError(f"column '{table.names['force']}' of {table.name} holds no force: it is zero throughout.")
    if float(found.max()) > HARDEST:
        raise UnitError(
            f"column '{table.names['force']}' of {table.name} goes up to {found.max() / 1e3:.4g} kN, but the strongest "
            f"muscles pull some 10 kN: its unit is another one. Say it: --force-unit N",
            unit=unit or "N",
            largest=float(found.max()),
        )
    return found


def _unit_guessed(name: str, largest: float, taken: str, flag: str, other: str | None) -> Finding:
    """Say which unit was taken for a column that names none, and which one it may be in its place."""
    cure = f"If they are in another one: {flag} {other}, or call the column {name}_{other}." if other else ""
    return Finding(
        "muscle-unit-guessed",
        f"column '{name}' names no unit: values up to {largest:.4g} were taken as {taken}. "
        f"{cure or 'No other unit fits a muscle.'}",
    )


def _within(contraction: Array) -> bool:
    """Whether muscles reach a contraction."""
    return bool(contraction.min() >= SHORTEST and contraction.max() <= LONGEST)


def _refuse_range(contraction: Array, role: str) -> None:
    low, high = float(contraction.min()), float(contraction.max())
    if _within(contraction):
        return
    cure = (
        "The length at rest is another one (--length), or the column's unit (--contraction-unit)"
        if role == "length"
        else "Its unit is another one (--contraction-unit percent, mm), or it counts a lengthening"
    )
    raise UnitError(
        f"the contraction goes from {100 * low:.4g} to {100 * high:.4g} %, but muscles reach 0 to 35 %, and are "
        f"stretched by a few. {cure}.",
        low=low,
        high=high,
    )


def _ask_absolute(pressure: Array, force: Array, absolute: bool, findings: list[Finding]) -> None:
    """Say so where the lowest pressure looks like the ambient one, absolute."""
    low = float(pressure.min())
    if absolute or not 0.9e5 < low < 1.1e5:
        return
    idle = float(np.max(force[pressure <= low + 2e3]))
    if idle < 0.02 * float(force.max()):
        findings.append(
            Finding(
                "muscle-absolute",
                f"the lowest pressure is {low / 1e5:.3g} bar, and there the muscle does not pull: the column looks "
                f"absolute, and gauge pressure is needed. If it is: --absolute.",
            )
        )
