"""Parameter file of the simulated robot: reads, changes and checks it; values in SI, with their sources."""

from __future__ import annotations

import copy
import hashlib
import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

from dehyst.errors import ParameterError
from dehyst.robot.arm import tables
from dehyst.robot.arm.validation import NAMED, SINGLE, TEXTS, closest, converted, known_keys, refuse_contradictions

PACKAGED = Path(__file__).with_name("arm.toml")
SIZE_LIMIT = 1 << 20
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot as its parameter file describes it. Attributes are the file's tables in SI, in `dehyst.robot.arm.tables`.

    Key ``joint.1.radius_m`` of the file is ``robot.joint(1).radius``, ``muscle.dmsp40.length_m`` is
    ``robot.muscle("dmsp40").length``, ``controller.pole_1_s`` is ``robot.controller.pole``.

    Examples
    --------
    >>> robot = load_robot()
    >>> robot.joint(1).radius, robot.joint(1).pneumatic, robot.pneumatic
    (0.05, True, (1, 2, 4, 6, 7))
    >>> robot.with_changes({"joint.1.radius_m": 0.06}).joint(1).radius
    0.06
    """

    name: str
    air: tables.Air
    maps: Mapping[str, tables.ForceMap]
    muscles: Mapping[str, tables.Muscle]
    hysteresis: tables.Hysteresis
    tolerance: tables.Tolerance
    valves: Mapping[str, tables.Valve]
    sensors: tables.Sensors
    base: tables.Base
    joints: Mapping[int, tables.Joint]
    electric: tables.Electric
    payload: tables.Payload
    simulation: tables.Simulation
    controller: tables.Controller
    compensator: tables.Compensator
    homing: tables.Homing
    calibration: tables.Calibration
    identification: tables.Identification
    path: tables.Path
    raw: Mapping[str, Any]

    def joint(self, number: int) -> tables.Joint:
        """Return the joint of this number, 1 to 7."""
        if number not in self.joints:
            raise ParameterError(
                f"the arm has no joint {number!r}. Its joints are 1 to 7, with muscles {self.pneumatic}.", joint=number
            )
        return self.joints[number]

    def muscle(self, name: str) -> tables.Muscle:
        """Return the type of muscle of this name, e.g. that of a joint's ``drive``."""
        return _member(self.muscles, name, "muscle")

    def valve(self, name: str | None) -> tables.Valve:
        """Return the valve of this name."""
        return _member(self.valves, name, "valve")

    @property
    def pneumatic(self) -> tuple[int, ...]:
        """Numbers of the joints that muscles drive."""
        return tuple(number for number, joint in self.joints.items() if joint.pneumatic)

    @property
    def electric_pole(self) -> float:
        """Double pole of the electric joints' own servos. [1/s]"""
        return self.electric.pole

    @property
    def values(self) -> dict[str, Any]:
        """The file's values with their changes, in the file's units: plain numbers, lists and texts; a copy."""
        return copy.deepcopy(dict(self.raw))

    @property
    def fingerprint(self) -> str:
        """SHA-256 of all values, 16 hexadecimal digits: two robots with the same one are the same robot."""
        text = json.dumps(self.raw, sort_keys=True, ensure_ascii=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def __eq__(self, other: object) -> bool:
        return self.raw == other.raw if isinstance(other, Robot) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.fingerprint)

    def with_changes(self, changes: Mapping[str, object]) -> Robot:
        """Return a robot with other values, checked as a file would be.

        Parameters
        ----------
        changes
            Dotted key -> value in the file's unit, e.g. ``{"hysteresis.scale": 1.5}``; or the name of a table -> a
            mapping of its keys.

        Raises
        ------
        ParameterError
            If a key does not exist, or a value cannot stand there.
        """
        return _robot(self.values, changes, "robot")


def load_robot(path: str | PathLike[str] | None = None, changes: Mapping[str, object] | None = None) -> Robot:
    """Read a robot from a parameter file.

    Parameters
    ----------
    path
        TOML file; None: the packaged arm. A file that begins with ``extends = "default"`` takes what it does not hold
        from the packaged arm; any other file must be complete.
    changes
        As for `Robot.with_changes`, applied before the values are checked.

    Raises
    ------
    ParameterError
        If the file cannot be read, or a key is unknown, missing, of a wrong type or outside its physical range.

    Examples
    --------
    >>> load_robot(changes={"hysteresis.mechanism": "dahl"}).hysteresis.mechanism
    'dahl'
    >>> load_robot(changes={"joint.1.radus_m": 0.06})  # doctest: +IGNORE_EXCEPTION_DETAIL
    Traceback (most recent call last):
    dehyst.errors.ParameterError: ... the closest that exists is 'joint.1.radius_m' ...
    """
    if path is None:
        return _robot(_read(PACKAGED), changes or {}, "arm.toml")
    file = Path(path)
    values = _read(file)
    base = values.pop("extends", None)
    if base not in (None, "default"):
        raise ParameterError(
            f'{file.name}: extends = {base!r} is not known. Write extends = "default" for the packaged arm, or copy '
            f"that file whole.",
            key="extends",
            value=base,
        )
    return _robot(_merged(_read(PACKAGED), values) if base else values, changes or {}, file.name)


def _member(table: Mapping[str, T], name: str | None, kind: str) -> T:
    if name not in table:
        raise ParameterError(
            f"the robot has no {kind} {name!r}; it has {', '.join(table)}. Electric joints have none: see "
            f"robot.pneumatic.",
            name=name,
        )
    assert name is not None
    return table[name]


def _robot(values: dict[str, Any], changes: Mapping[str, object], source: str) -> Robot:
    for dotted, value in changes.items():
        nested: Any = value
        for part in reversed(str(dotted).split(".")):
            nested = {part: nested}
        _refuse_new(values, str(dotted), value)
        values = _merged(values, nested)
    raw, si = converted(values, source)
    robot = Robot(**si, raw=raw)
    refuse_contradictions(robot, source)
    return robot


def _refuse_new(values: Mapping[str, Any], dotted: str, value: object) -> None:
    """A change of a single key names one that exists; only whole tables may be new."""
    known = known_keys(values)
    if isinstance(value, Mapping) or dotted in known:
        return
    tables_of_keys = [*TEXTS, *SINGLE, *NAMED]
    hint = closest(dotted, known)
    raise ParameterError(
        f"no such key {dotted!r}{hint}. A key is TABLE.KEY or TABLE.NAME.KEY with its unit, e.g. joint.1.radius_m; "
        f"tables: {', '.join(tables_of_keys)}.",
        key=dotted,
        value=value,
    )


def _merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return `base` with the values of `over`, tables merged key by key."""
    out = dict(base)
    for key, value in over.items():
        old = out.get(key)
        out[key] = _merged(old, value) if isinstance(old, Mapping) and isinstance(value, Mapping) else value
    return out


def _read(file: Path) -> dict[str, Any]:
    try:
        if file.stat().st_size > SIZE_LIMIT:
            raise ParameterError(
                f"{file.name} has {file.stat().st_size} bytes; a parameter file has thousands. Name the TOML file.",
                file=file.name,
            )
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as fault:
        raise ParameterError(
            f"the parameter file '{file.name or file}' cannot be read ({fault.strerror}). Name a TOML file, or none "
            f"for the packaged arm.",
            file=file.name,
        ) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError, ValueError) as fault:
        if isinstance(fault, ParameterError):
            raise
        raise ParameterError(
            f"'{file.name}' is not TOML: {' '.join(str(fault).split())[:160]}. Lines look like radius_m = 0.05, tables "
            f"like [joint.1]; texts stand in quotes.",
            file=file.name,
        ) from None


_TABLE = re.compile(r"\[([\w.-]+)\]")
_VALUE = re.compile(r"([\w-]+)\s*=\s*[^#]*#\s*(.*)")


@cache
def sources() -> dict[str, str]:
    """Return what the packaged file says beside each number: dotted key -> meaning, source or "assumption".

    Examples
    --------
    >>> sources()["sensors.encoder_bits"]
    '[1]'
    """
    found: dict[str, str] = {}
    table = ""
    for line in PACKAGED.read_text(encoding="utf-8").splitlines():
        if heading := _TABLE.match(line):
            table = heading[1]
        elif value := _VALUE.match(line):
            found[f"{table}.{value[1]}"] = value[2].strip()
    return found


def changes_from_packaged(robot: Robot) -> dict[str, Any]:
    """Return the values, by dotted key, in which a robot differs from the packaged one.

    Examples
    --------
    >>> changes_from_packaged(load_robot(changes={"hysteresis.scale": 1.5}))
    {'hysteresis.scale': 1.5}
    """
    packaged = dict(_leaves(load_robot().values))
    return {key: value for key, value in _leaves(robot.values) if packaged.get(key) != value}


def _leaves(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value
