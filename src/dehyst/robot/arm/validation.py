"""Checks values of a parameter file: unknown, missing, of a wrong type, out of range, inconsistent."""

from __future__ import annotations

import difflib
import math
import types
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, Union, get_args, get_origin, get_type_hints

from dehyst.errors import ParameterError
from dehyst.robot.arm import tables
from dehyst.robot.arm.tables import Key

if TYPE_CHECKING:
    from dehyst.robot.arm.parameters import Robot

SINGLE: dict[str, type] = {
    table.__name__.lower(): table
    for table in (
        tables.Air, tables.Hysteresis, tables.Tolerance, tables.Sensors, tables.Base, tables.Electric, tables.Payload,
        tables.Simulation, tables.Controller, tables.Compensator, tables.Homing, tables.Calibration,
        tables.Identification, tables.Path,
    )
}  # fmt: skip
NAMED: dict[str, type] = {"map": tables.ForceMap, "muscle": tables.Muscle, "valve": tables.Valve, "joint": tables.Joint}
# tables of tables: [joint.1], [muscle.dmsp40]
TEXTS = ("name",)
Nested = dict[str, Any]


# what stands after the quantity's name -> factor to SI. Frequencies become angular: [rad/s].
IN_SI = ("", "m", "kg", "s", "K", "N", "Nm", "Nm_s", "m_s", "m_s2", "m_s3", "1_s")
TO_SI: dict[str, float] = dict.fromkeys(IN_SI, 1.0) | {
    "deg": math.pi / 180.0,
    "bar": 1e5,
    "bar_rad": 1e5,
    "N_bar": 1e-5,
    "l": 1e-3,
    "l_per_m": 1e-3,
    "l_s_bar": 1e-3 / 1e5,
    "Hz": 2.0 * math.pi,
}


def key_of(quantity: str, unit: str) -> str:
    """Return the key of a quantity in a parameter file.

    Examples
    --------
    >>> key_of("supply", "bar")
    'supply_bar'
    >>> key_of("ratio", "")
    'ratio'
    """
    return f"{quantity}_{unit}" if unit else quantity


def converted(values: Mapping[str, Any], source: str) -> tuple[Nested, Nested]:
    """Check nested values and return them twice: as in the file (plain numbers, lists, texts) and as tables in SI.

    Parameters
    ----------
    values
        Table name -> key -> value; tables of tables one deeper. In SI these are in the plural: ``joints``.
    source
        Name of the file, for messages.
    """
    _refuse_unknown(values, source)
    missing = sorted(set(_required(values)) - set(_dotted(values)))
    if missing:
        shown = ", ".join(missing[:12]) + (f" and {len(missing) - 12} more" if len(missing) > 12 else "")
        raise ParameterError(
            f"{source} lacks {len(missing)} of the keys that a robot needs: {shown}. Add them, or write extends = "
            f'"default" as the first line, then what is not in the file is taken from the packaged arm.',
            missing=missing,
            source=source,
        )
    raw: Nested = {name: _text(values[name], name, source) for name in TEXTS}
    si: Nested = dict(raw)
    for name, table in SINGLE.items():
        raw[name], si[name] = _table(values[name], table, name, source)
    for name, table in NAMED.items():
        raw[name], si[f"{name}s"] = {}, {}
        for member in sorted(values[name]):
            raw[name][member], built = _table(values[name][member], table, f"{name}.{member}", source)
            si[f"{name}s"][int(member) if name == "joint" else member] = built
    return raw, si


@cache
def keys_of(table: type) -> dict[str, tuple[str, Any, Key]]:
    """Return key of the file -> (field, type, what it may hold) of a table."""
    found = {}
    for name, hint in get_type_hints(table, include_extras=True).items():
        kind, key = get_args(hint)[:2]
        found[key_of(name, key.unit)] = (name, kind, key)
    return found


def known_keys(values: Mapping[str, Any]) -> list[str]:
    """Return every dotted key that a file with these named tables may hold."""
    found = list(TEXTS)
    found += [f"{name}.{key}" for name, table in SINGLE.items() for key in keys_of(table)]
    for name, table in NAMED.items():
        members = values.get(name)
        found += [
            f"{name}.{m}.{key}" for m in (members if isinstance(members, Mapping) else ()) for key in keys_of(table)
        ]
    return found


def refuse(message: str, key: str, value: object, source: str) -> ParameterError:
    """Return the error for a value that cannot stand at this key."""
    return ParameterError(f"{source}: {key} = {shown(value)} {message}", key=key, value=value, source=source)


def closest(word: str, known: Sequence[str]) -> str:
    """Return "; the closest known ... is" or nothing."""
    found = difflib.get_close_matches(word, known, 1, 0.5)
    return f"; the closest that exists is {found[0]!r}" if found else ""


def shown(value: object) -> str:
    """Return a value as it is typed, cut after sixty letters."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _dotted(values: Mapping[str, Any], prefix: str = "") -> list[str]:
    """Return the dotted names of all values that are not tables."""
    found: list[str] = []
    for key, value in values.items():
        name = f"{prefix}{key}"
        found += _dotted(value, name + ".") if isinstance(value, Mapping) else [name]
    return found


def _required(values: Mapping[str, Any]) -> list[str]:
    optional = {f"{n}.{k}" for n, t in NAMED.items() for k, (_, kind, _) in keys_of(t).items() if _is_optional(kind)}
    named: Nested = {name: dict(values.get(name, {})) for name in NAMED}
    for number in range(1, 8):
        named["joint"].setdefault(str(number), {})
    return [key for key in known_keys(named) if f"{key.split('.')[0]}.{key.split('.')[-1]}" not in optional]


def _refuse_unknown(values: Mapping[str, Any], source: str) -> None:
    for name, table in values.items():
        if name not in TEXTS and isinstance(name, str) and (name in SINGLE or name in NAMED):
            if not isinstance(table, Mapping):
                raise refuse(f"is not a table: write [{name}] and its keys below it.", name, table, source)
            for member, inner in table.items() if name in NAMED else ():
                if not isinstance(inner, Mapping):
                    raise refuse(f"is not a table: write [{name}.{member}].", f"{name}.{member}", inner, source)
                if name == "joint" and member not in "1234567":
                    raise refuse("is no joint: the arm has joints 1 to 7.", f"joint.{member}", "...", source)
    known = known_keys(values)
    tops = [*TEXTS, *SINGLE, *NAMED]
    for name in values:
        if name not in tops:
            raise ParameterError(
                f"{source}: no such table or key {name!r}{closest(str(name), [*tops, *known])}. Tables: "
                f"{', '.join(tops)}.",
                key=name,
                source=source,
            )
    for dotted in _dotted(values):
        if dotted not in known:
            near = [key for key in known if key.rpartition(".")[0] == dotted.rpartition(".")[0]]
            hint = closest(dotted, near) or closest(dotted, known)
            raise ParameterError(
                f"{source}: no such key {dotted!r}{hint}. Keys are written with their unit, e.g. joint.1.radius_m.",
                key=dotted,
                source=source,
            )


def _table(values: Mapping[str, Any], table: type, name: str, source: str) -> tuple[Nested, Any]:
    raw: Nested = {}
    si: Nested = {}
    for key, (field, kind, spec) in keys_of(table).items():
        si[field] = None
        if key in values:
            raw[key] = _value(values[key], kind, spec, f"{name}.{key}", source)
            si[field] = _in_si(raw[key], TO_SI[spec.unit])
    assert is_dataclass(table)
    assert set(si) == {f.name for f in fields(table)}
    return raw, table(**si)


def _in_si(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return tuple(float(v) * factor for v in value)
    return value * factor if isinstance(value, float) else value


def _is_optional(kind: Any) -> bool:
    return get_origin(kind) in (Union, types.UnionType)


def _value(value: Any, kind: Any, spec: Key, key: str, source: str) -> Any:
    if _is_optional(kind):
        kind = next(k for k in get_args(kind) if k is not type(None))
    if kind is str:
        text = _text(value, key, source)
        if spec.choices and text not in spec.choices:
            hint = closest(text, spec.choices)
            raise refuse(f"is none of {', '.join(spec.choices)}{hint}.", key, value, source)
        return text
    if kind is int:
        return _whole(value, spec, key, source)
    if get_origin(kind) is tuple:
        return _list(value, spec, key, source)
    return _number(value, spec, key, source)


def _text(value: Any, key: str, source: str) -> str:
    if not isinstance(value, str) or not value:
        raise refuse("is not a text in quotes.", key, value, source)
    return value


def _number(value: Any, spec: Key, key: str, source: str) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise refuse(f"is not a number{f' [{spec.unit}]' if spec.unit else ''}.", key, value, source)
    number = float(value)
    if not (math.isfinite(number) and spec.low <= number <= spec.high):
        unit = f" {spec.unit}" if spec.unit else ""
        raise refuse(
            f"lies outside what is physical, {spec.low:g} .. {spec.high:g}{unit}; mind the unit in the key.",
            key,
            value,
            source,
        )
    return number


def _whole(value: Any, spec: Key, key: str, source: str) -> int:
    number = _number(value, spec, key, source)
    if not isinstance(value, Integral) and not number.is_integer():
        raise refuse("is not a whole number.", key, value, source)
    return int(number)


def _list(value: Any, spec: Key, key: str, source: str) -> list[float]:
    if hasattr(value, "tolist"):
        value = value.tolist()
    if not isinstance(value, (list, tuple)):
        raise refuse("is not a list of numbers: write [1.0, 2.0].", key, value, source)
    if not spec.least <= len(value) <= spec.most:
        wanted = str(spec.least) if spec.least == spec.most else f"{spec.least} to {spec.most}"
        raise refuse(f"has {len(value)} numbers, not {wanted}.", key, value, source)
    return [_number(v, spec, f"{key}[{i}]", source) for i, v in enumerate(value)]


# Muscles are pretensioned by at most 5 % and contract by at most 25 %: catalogue of the DMSP.
LEAST_CONTRACTION, MOST_CONTRACTION = -0.05, 0.30
COEFFICIENTS = {"tool": 6, "exponential": 6, "geometric": 8}


def refuse_contradictions(robot: Robot, source: str) -> None:
    """Check names that refer to other tables, and values against each other."""
    for name, law in robot.maps.items():
        wanted = COEFFICIENTS[law.form]
        if len(law.coefficients) != wanted:
            raise refuse(
                f"has not the {wanted} coefficients of the form {law.form!r}.",
                f"map.{name}.coefficients",
                law.coefficients,
                source,
            )
    for name, muscle in robot.muscles.items():
        _known(muscle.map, list(robot.maps), f"muscle.{name}.map", source)
        counts = {len(muscle.creep_time), len(muscle.creep_force), len(muscle.creep_pressure)}
        if len(counts) > 1:
            raise refuse(
                f"and creep_force_N and creep_pressure_N_bar have {sorted(counts)} numbers: one of each a branch of "
                f"creep. For no creep type hysteresis.creep = 0.",
                f"muscle.{name}.creep_time_s", muscle.creep_time, source,
            )  # fmt: skip
    for number in robot.joints:
        _check_joint(robot, number, source)
    _check_pressures(robot, source)
    if 2 * robot.path.rounding >= 0.8 * robot.path.cube:
        raise refuse(
            f"rounds more than the rectangle's short side of 0.8 x {robot.path.cube:g} m holds; below "
            f"{0.4 * robot.path.cube:.4g} m.",
            "path.rounding_m", robot.path.rounding, source,
        )  # fmt: skip


def _known(word: str, names: list[str], key: str, source: str) -> None:
    if word not in names:
        raise refuse(f"is not in the file{closest(word, names)}. It has {', '.join(names)}.", key, word, source)


def _check_joint(robot: Robot, number: int, source: str) -> None:
    joint = robot.joints[number]
    where = f"joint.{number}"
    _known(joint.drive, ["electric", *robot.muscles], f"{where}.drive", source)
    if not joint.pneumatic:
        return
    lacking = [key for key, value in (("valve", joint.valve), ("radius_m", joint.radius),
                                      ("contraction", joint.contraction)) if value is None]  # fmt: skip
    if lacking:
        raise ParameterError(
            f"{source}: {where} is driven by muscles and lacks {', '.join(lacking)}. Add them, or set {where}.drive = "
            f'"electric".',
            key=where,
            missing=lacking,
        )
    assert joint.valve is not None
    assert joint.radius is not None
    assert joint.contraction is not None
    _known(joint.valve, list(robot.valves), f"{where}.valve", source)
    stroke = joint.radius * joint.range / robot.muscles[joint.drive].length
    low, high = joint.contraction - stroke, joint.contraction + stroke
    if low < LEAST_CONTRACTION or high > MOST_CONTRACTION:
        raise ParameterError(
            f"{source}: at the ends of the range of {where} its muscles contract by {low:.3f} and {high:.3f} of their "
            f"length, possible are {LEAST_CONTRACTION:g} .. {MOST_CONTRACTION:g}. Make {where}.range_deg or radius_m "
            f"smaller, the muscle longer, or put contraction in the middle.",
            key=where,
            low=low,
            high=high,
        )


def _check_pressures(robot: Robot, source: str) -> None:
    c, supply = robot.controller, robot.air.supply
    if not c.pressure_low < c.mean_pressure < c.pressure_high:
        raise refuse(
            f"is not between pressure_low_bar = {c.pressure_low / 1e5:g} and pressure_high_bar = "
            f"{c.pressure_high / 1e5:g}.",
            "controller.mean_pressure_bar", c.mean_pressure / 1e5, source,
        )  # fmt: skip
    if c.pressure_high >= supply:
        raise refuse(
            f"is not below the supply, air.supply_bar = {supply / 1e5:g}: nothing would flow.",
            "controller.pressure_high_bar", c.pressure_high / 1e5, source,
        )  # fmt: skip
