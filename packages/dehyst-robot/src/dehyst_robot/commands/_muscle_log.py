"""dehyst muscle --log: converts the columns of a test-bench log to contraction, pressure and force in SI units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError, RecordingError, UnitError
from dehyst.findings import Finding
from dehyst.io import LogColumns, read_columns
from dehyst.units import MASS_FACTORS, canonical, convert, dimension, mass_unit
from dehyst_robot.commands._policy import POLICY
from dehyst_robot.commands._requests import MuscleRequest
from dehyst_robot.muscles import BenchLog

PERCENT = ("%", "percent", "pct", "per cent", "prozent")
PLAIN = ("", "1", "-", "ratio", "mm/mm", "m/m")
ATMOSPHERE = 101325.0  # Pa
GRAVITY = 9.80665  # m/s^2, standard
# Largest value up to which a pressure without a unit is taken for one, in order.
PRESSURES, FORCES, LENGTHS = (
    ("kPa", "MPa", "bar", "psi", "mbar", "Pa"),
    ("kN", "lbf", "N"),
    ("mm", "cm", "m", "in"),
)
GUESSES = (
    (POLICY.bar_up_to, "bar"),
    (POLICY.kpa_up_to, "kPa"),
    (POLICY.mbar_up_to, "mbar"),
    (float("inf"), "Pa"),
)


def read_bench_log(
    path: Path, request: MuscleRequest, length: float | None
) -> tuple[BenchLog, dict[str, Any]]:
    """Read a bench log; return it in SI units, and where it comes from.

    The `length` at rest [m] is needed where the log holds lengths.
    """
    role, column, read = "contraction", request.contraction or "contraction", contraction_of
    if request.length_column is not None:
        if request.contraction is not None:
            raise ParameterError(
                "--contraction and --length-column both name what moves. Leave one of them out."
            )
        role, column, read = "length", request.length_column, contraction_of_length
    table = read_columns(
        path,
        {role: column, "pressure": request.pressure, "force": request.force},
        time=request.time,
        run=request.run,
        start=request.start,
        stop=request.stop,
        time_unit=request.time_unit,
        sheet=request.sheet,
        dt=request.dt,
    )
    # A muscle at rest needs no time.
    findings = [entry for entry in table.findings if entry.code != "no-time"]
    contraction = read(table, request.contraction_unit, length, findings)
    pressure = _pressure(table, request, findings)
    force = _force(table, request.force_unit, findings)
    _refuse_range(contraction, role)
    _ask_absolute(pressure, force, request.absolute, findings)
    time = table.time
    if request.at_rest:
        time = None
    log = BenchLog(contraction, pressure, force, time, table.name, tuple(findings))
    return log, dict(table.provenance)


def _another(candidates: Sequence[str], chosen: str, fits: Callable[[str], bool]) -> str | None:
    """Return a unit that a nameless column may have in the place of the chosen one: none that is refused."""
    for unit in candidates:
        if unit != chosen and fits(unit):
            return unit
    return None


def _unit(table: LogColumns, role: str, option: str | None) -> str:
    if option is None:
        return table.units[role]
    return option


def _guessed(largest: float) -> str:
    """The unit of pressure in which muscles have values up to this one."""
    for limit, unit in GUESSES:
        if largest <= limit:
            return unit
    return GUESSES[-1][1]


def _require_kind(table: LogColumns, role: str, unit: str, kind: str, flag: str) -> None:
    """Refuse a unit of another kind."""
    actual = dimension(unit)
    if actual == kind:
        return
    actual_kind = "no unit that is known"
    if actual:
        actual_kind = f"a unit of {actual}"
    raise UnitError(
        f"column '{table.names[role]}' of {table.name} is in '{unit}', {actual_kind}, but {role} needs one of {kind}. "
        f"Check that it is the right column, or say its unit: {flag}.",
        unit=unit,
    )


def contraction_of(
    table: LogColumns, option: str | None, length: float | None, findings: list[Finding]
) -> Array:
    """Contraction as a number, from one, from percent, or from a shortening in a unit of length."""
    values, unit = table.values["contraction"], _unit(table, "contraction", option)
    if unit.lower() in PERCENT or (not unit and _says_percent(table.names["contraction"])):
        return _doubt_percent(values / 100.0, table.names["contraction"], findings)
    if dimension(unit) == "length":
        # Only the length at rest makes a contraction of a length.
        if length is None:
            raise ParameterError(
                f"column '{table.names['contraction']}' of {table.name} is in {unit}: a shortening, of which only the "
                f"length at rest makes a contraction. Say it: --length 300mm"
            )
        return np.asarray(convert(values, unit, "m")) / length
    if unit.lower() not in PLAIN:
        _require_kind(
            table,
            "contraction",
            unit,
            "length",
            "--contraction-unit percent, --contraction-unit mm",
        )
    largest = float(np.max(np.abs(values)))
    # A muscle never shortens by all of its length: up to 1 it is a number.
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
    if 0.0 < largest < POLICY.still and float(np.ptp(contraction)) > 0.1 * largest:
        findings.append(
            Finding(
                "muscle-unit-guessed",
                f"column '{name}' is in percent, but reaches only {100.0 * largest:.2g} %, a stroke that can hardly be "
                f"measured. If it holds a number from 0 to 1: --contraction-unit 1.",
            )
        )
    return contraction


def _says_percent(name: str) -> bool:
    return name.lower().endswith(("percent", "pct", "prozent", "%"))


def contraction_of_length(
    table: LogColumns, option: str | None, length: float | None, findings: list[Finding]
) -> Array:
    """Contraction from the length of the muscle."""
    values, unit = table.values["length"], _unit(table, "length", option)
    if length is None:
        raise ParameterError(
            f"column '{table.names['length']}' of {table.name} holds lengths; contraction counts from the length "
            f"without pressure and load. Say it: --length 300mm"
        )

    def contraction_in(unit: str) -> Array:
        return 1.0 - np.asarray(convert(values, unit, "m")) / length

    if not unit:
        unit = "mm"
        if np.median(values) < 20.0 * length:
            unit = "m"
        cure = "No other unit fits that length."
        alternative = _another(LENGTHS, unit, lambda candidate: _within(contraction_in(candidate)))
        if alternative:
            cure = f"If it is in another one: --contraction-unit {alternative}."
        findings.append(
            Finding(
                "muscle-unit-guessed",
                f"column '{table.names['length']}' names no unit: taken as {unit}, which fits --length {length:g} m. "
                f"{cure}",
            )
        )
    _require_kind(table, "length", unit, "length", "--contraction-unit mm")
    return contraction_in(unit)


def _pressure(table: LogColumns, request: MuscleRequest, findings: list[Finding]) -> Array:
    """Gauge pressure in Pa; a unit that is not named is guessed and said, one that cannot be is refused."""
    values, unit = table.values["pressure"], _unit(table, "pressure", request.pressure_unit)
    largest, name = float(np.max(values)), table.names["pressure"]
    if not unit:
        unit = _guessed(largest)

        def drives_muscles(candidate: str) -> bool:
            return (
                POLICY.weakest
                <= float(np.asarray(convert(largest, candidate, "Pa")))
                <= POLICY.strongest
            )

        alternative = _another(PRESSURES, unit, drives_muscles)
        findings.append(_unit_guessed(name, largest, unit, "--pressure-unit", alternative))
    _require_kind(table, "pressure", unit, "pressure", "--pressure-unit bar")
    pressure = np.asarray(convert(values, unit, "Pa"))
    if request.absolute:
        pressure = pressure - ATMOSPHERE
    highest, lowest = float(pressure.max()), float(pressure.min())
    # Said before the unit is doubted: a reversed sign looks like a wrong unit, too.
    if largest <= 0.0:
        raise UnitError(
            f"column '{name}' of {table.name} is never above {largest:.4g}: a muscle pulls when its pressure is above "
            f"the ambient. Check the column, its sign and its zero.",
            largest=largest,
        )
    if not POLICY.weakest <= highest <= POLICY.strongest:
        likely = _guessed(largest)
        # The unit that was typed is no cure for itself.
        if likely == canonical(unit):
            likely = "with the right one"
        raise UnitError(
            f"column '{name}' of {table.name} goes up to {largest:.4g} {unit}, but muscles are driven with 0.1 to 20 "
            f"bar: its unit is another one. Say it: --pressure-unit {likely}",
            unit=unit,
            largest=largest,
        )
    if lowest < POLICY.vacuum:
        cure = "check the column and its zero"
        if request.absolute:
            cure = "leave --absolute out"
        raise UnitError(
            f"column '{name}' of {table.name} goes down to {lowest / 1e5:.3g} bar below the ambient. A muscle is "
            f"not driven with vacuum: {cure}.",
            lowest=lowest,
        )
    return pressure


def _force(table: LogColumns, option: str | None, findings: list[Finding]) -> Array:
    unit = _unit(table, "force", option)
    name, values = table.names["force"], table.values["force"]
    mass = mass_unit(name, unit)
    if mass:
        findings.append(
            Finding(
                "muscle-mass",
                f"column '{name}' is in {mass}, a mass: taken as the force that it weighs, {GRAVITY} "
                f"N for 1 kg, as load cells are calibrated. Otherwise say the unit: --force-unit N.",
            )
        )
        force = values * (MASS_FACTORS[mass] * GRAVITY)
    else:
        if not unit:
            largest = float(np.max(np.abs(values)))

            def pulls_like_muscles(candidate: str) -> bool:
                return float(np.asarray(convert(largest, candidate, "N"))) <= POLICY.hardest

            alternative = _another(FORCES, "N", pulls_like_muscles)
            findings.append(_unit_guessed(name, largest, "N", "--force-unit", alternative))
        _require_kind(table, "force", unit or "N", "force", "--force-unit N")
        force = np.asarray(convert(values, unit or "N", "N"))
    # Some load cells count a pull as negative.
    if float(force.max()) <= 0.05 * float(-force.min()):
        findings.append(
            Finding(
                "muscle-force-sign",
                f"column '{name}' is negative where the muscle pulls ({force.min():.4g} N): its sign "
                f"was turned, since a pull counts as positive here. Nothing to do.",
            )
        )
        force = -force
    highest = float(force.max())
    if not highest > 0:
        raise RecordingError(
            f"column '{name}' of {table.name} holds no force: it is zero throughout."
        )
    if highest > POLICY.hardest:
        raise UnitError(
            f"column '{name}' of {table.name} goes up to {highest / 1e3:.4g} kN, but the strongest "
            f"muscles pull some 10 kN: its unit is another one. Say it: --force-unit N",
            unit=unit or "N",
            largest=highest,
        )
    return force


def _unit_guessed(
    name: str, largest: float, unit: str, flag: str, alternative: str | None
) -> Finding:
    """Say which unit was taken for a column that names none, and which one it may be in its place."""
    cure = "No other unit fits a muscle."
    if alternative:
        cure = f"If they are in another one: {flag} {alternative}, or call the column {name}_{alternative}."
    return Finding(
        "muscle-unit-guessed",
        f"column '{name}' names no unit: values up to {largest:.4g} were taken as {unit}. {cure}",
    )


def _within(contraction: Array) -> bool:
    """Whether muscles reach a contraction."""
    return bool(contraction.min() >= POLICY.shortest and contraction.max() <= POLICY.longest)


def _refuse_range(contraction: Array, role: str) -> None:
    if _within(contraction):
        return
    low, high = float(contraction.min()), float(contraction.max())
    cure = "Its unit is another one (--contraction-unit percent, mm), or it counts a lengthening"
    if role == "length":
        cure = "The length at rest is another one (--length), or the column's unit (--contraction-unit)"
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
    # A muscle at the ambient pressure does not pull, whatever its length.
    idle = float(np.max(force[pressure <= low + 2e3]))
    if idle < 0.02 * float(force.max()):
        findings.append(
            Finding(
                "muscle-absolute",
                f"the lowest pressure is {low / 1e5:.3g} bar, and there the muscle does not pull: the column looks "
                f"absolute, and gauge pressure is needed. If it is: --absolute.",
            )
        )
