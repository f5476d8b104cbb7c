"""Parameter file of the simulated robot: reads, changes and checks it; values in SI, with their sources."""

from __future__ import annotations

import copy
import hashlib
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

from dehyst.errors import ParameterError
from dehyst.files import document_of, text_of
from dehyst.shell import did_you_mean
from dehyst_robot.arm._routing import NEEDED, joint_arms, refuse_unusable
from dehyst_robot.arm._static_map import static_map, static_map_model
from dehyst_robot.arm._tables import SPRING, Joint, Muscle, Tables, Valve
from dehyst_robot.fields import checked_table, dotted, entries, key_text, record, short_repr
from dehyst_robot.muscles import muscle_names

PACKAGED = Path(__file__).with_name("arm.toml")
REALISTIC = PACKAGED.with_name("realistic.toml")
# Name of conditions -> changes to the packaged file.
CONDITIONS: Mapping[str, Path | None] = {"kind": None, "realistic": REALISTIC}
DEFAULT = "realistic"
LACKS = (
    ', or write as the first line extends = "default": what is not in the file is taken from the packaged arm; or '
    'extends = "parts": the same, but for its joints and what belongs to them'
)
# A file that extends "parts" does not take these: they belong to the joints of the packaged arm.
OF_ITS_JOINTS = ("name", "joint", "compensator.joints", "path.center_m", "path.posture_weights")
# Muscles are pretensioned by at most 5 % and contract by at most 25 %: catalogue of the DMSP.
CONTRACTIONS = (-0.05, 0.30)
LEAST_OF_A_PATH = 3  # joints: fewer do not reach all points of a space
# PLANT_RING of packages/dehyst-robot/plant/plant.h, less two samples that the interpolation needs.
DELAY_PERIODS = 62
SPEED_OF_SOUND = 343.0  # in the tube between valve and muscle [m/s]
COEFFICIENTS = {"tool": 6, "exponential": 6, "geometric": 8}
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Robot(Tables):
    """A robot as its parameter file describes it. Attributes are the file's tables in SI, `dehyst_robot.arm.Tables`.

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

    raw: Mapping[str, Any]
    folder: Path = Path()

    def joint(self, number: int) -> Joint:
        """Return the joint of this number, from 1 on."""
        if number not in self.joints:
            raise ParameterError(
                f"the robot has no joint {number!r}. Its joints are {numbers_text(self.joints)}, with muscles "
                f"{numbers_text(self.pneumatic) or 'none'}.",
                joint=number,
            )
        return self.joints[number]

    def muscle(self, name: str) -> Muscle:
        """Return the type of muscle of this name, e.g. that of a joint's ``drive``."""
        return _member(self.muscles, name, "muscle")

    def muscles_of(self, number: int) -> tuple[Muscle, ...]:
        """Return the types of muscle 1 and 2 of a joint; none if it is electric.

        A spring is as long as muscle 1 and has no hysteresis and creep; its valve feeds a closed volume as large.
        """
        joint = self.joint(number)
        if not joint.pneumatic:
            return ()
        muscles = [self.muscle(name) for name in joint.driven if name != SPRING]
        if joint.sprung:
            beside = muscles[0]
            volume = beside.dead_volume + beside.length * beside.volume[0]
            muscles += [replace(beside, volume=(0.0,) * 4, dead_volume=volume, viscous_force=0.0, creep_time=(),
                                creep_force=(), creep_pressure=(), hysteresis=0.0, tendon=0.0, warming=0.0,
                                warming_time=0.0, warm_stiffness=0.0)]  # fmt: skip
        return tuple(muscles)

    def lengths(self, number: int) -> list[float]:
        """Return the lengths of a joint's muscles at rest, without that of a spring. [m]"""
        joint = self.joint(number)
        return [muscle.length for muscle in self.muscles_of(number)][: 2 - joint.sprung]

    def valve(self, name: str | None) -> Valve:
        """Return the valve of this name."""
        return _member(self.valves, name, "valve")

    @property
    def pneumatic(self) -> tuple[int, ...]:
        """Numbers of the joints that muscles drive."""
        return tuple(number for number, joint in self.joints.items() if joint.pneumatic)

    @property
    def compensated(self) -> tuple[int, ...]:
        """Numbers of the joints that get a compensator: ``compensator.joints``, or all that muscles drive."""
        chosen = self.compensator.joints
        if chosen is None:
            return self.pneumatic
        return tuple(number for number in self.pneumatic if number in chosen)

    def beside(self, file: str) -> Path:
        """Return the path of a file that the robot's file names."""
        return self.folder / file

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
        """SHA-256 of all values and of a body's file, 16 hexadecimal digits: the same one is the same robot."""
        text = json.dumps(self.raw, sort_keys=True, ensure_ascii=True).encode()
        if self.body is not None:
            text += self.beside(self.body.file).read_bytes()
        return hashlib.sha256(text).hexdigest()[:16]

    def __repr__(self) -> str:
        described = []
        for number, joint in self.joints.items():
            described.append(f"{number} {' and '.join(dict.fromkeys(joint.driven))}")
        drives = ", ".join(described)
        return f"<Robot {self.name!r}: joints {drives}; {self.hysteresis.mechanism}; {self.fingerprint}>"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Robot):
            return NotImplemented
        return self.raw == other.raw and (self.body is None or self.folder == other.folder)

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
        return _robot(dict(self.raw), changes, "robot", self.folder)


def load_robot(
    path: str | PathLike[str] | None = None,
    changes: Mapping[str, object] | None = None,
    *,
    conditions: str | None = None,
) -> Robot:
    """Read a robot from a parameter file.

    Parameters
    ----------
    path
        TOML file; None: the packaged arm. A file that begins with ``extends = "default"``, or with conditions in the
        place of "default", takes what it does not hold from the packaged arm; one with ``extends = "parts"`` takes its
        muscles, valves, air and settings, and has joints of its own, 1 to 12. Any other file must be complete.
    changes
        As for `Robot.with_changes`, applied before the values are checked.
    conditions
        Of the packaged arm. ``"kind"``: the equations alone. ``"realistic"``: with what a real joint adds, such as
        delays, compliance, backlash, valves and sensors that are off, and a supply that all joints share. None: those
        that the file extends, or realistic.

    Raises
    ------
    ParameterError
        If the file cannot be read, a key is unknown, missing, of a wrong type or outside its physical range, or
        conditions are not known or meant for a file that extends nothing.

    Examples
    --------
    >>> load_robot(changes={"hysteresis.mechanism": "dahl"}).hysteresis.mechanism
    'dahl'
    >>> load_robot(conditions="realistic").valve("mpye").delay, load_robot(conditions="kind").valve("mpye").delay
    (0.001, 0.0)
    >>> load_robot(changes={"joint.1.radus_m": 0.06})  # doctest: +IGNORE_EXCEPTION_DETAIL
    Traceback (most recent call last):
    dehyst.errors.ParameterError: ... Did you mean joint.1.radius_m? ...
    """
    if path is None:
        return robot_of({"extends": "default"}, PACKAGED.name, Path(), changes, conditions)
    return robot_of(_read(path), Path(path).name, Path(path).parent, changes, conditions)


def robot_of(
    values: Mapping[str, Any],
    name: str,
    folder: Path = Path(),
    changes: Mapping[str, object] | None = None,
    conditions: str | None = None,
) -> Robot:
    """Return the robot of a parameter file's contents; `name` and `folder` are the file's, the rest of `load_robot`."""
    values = dict(values)
    base = values.pop("extends", None)
    if base not in (None, "default", "parts", *CONDITIONS):
        raise ParameterError(
            f'{name}: extends = {short_repr(base)} is not known. Write extends = "default" for the packaged arm, or '
            f"{' or '.join(map(repr, CONDITIONS))} for its conditions, 'parts' for a robot with joints of its own, or "
            f"copy that file whole.",
            key="extends",
            value=base,
        )
    if conditions is not None and (base is None or conditions not in CONDITIONS):
        reason = "not known" if base else "those of the packaged arm"
        raise ParameterError(
            f"{name}: conditions {short_repr(conditions)} are {reason}. They are {' and '.join(CONDITIONS)}, for the "
            f"packaged arm and files that begin with extends = ...; any other file says all numbers itself.",
            conditions=conditions,
        )
    packaged: dict[str, Any] = {}
    if base is not None:
        packaged = _packaged(conditions or base)
    _refuse_unused(values, name)
    if base == "parts":
        _remove_joints(packaged)
    return _robot(_merged(packaged, values), changes or {}, name, folder)


def _packaged(conditions: object) -> dict[str, Any]:
    """Return the values of the packaged arm; words that are no conditions stand for the default ones."""
    if conditions not in CONDITIONS:
        conditions = DEFAULT
    values = _read(PACKAGED)
    changes = CONDITIONS[str(conditions)]
    if changes is not None:
        values = _merged(values, _read(changes))
    return values


def _remove_joints(values: dict[str, Any]) -> None:
    for key in OF_ITS_JOINTS:
        table, _, inner = key.rpartition(".")
        holder = values[table] if table else values
        del holder[inner]


def _refuse_unused(values: Mapping[str, Any], name: str) -> None:
    """Refuse keys that a file itself gives to a joint that does not use them."""
    joints = values.get("joint")
    if not isinstance(joints, Mapping):
        return  # refused later, with all that a table needs
    for number, joint in joints.items():
        if not isinstance(joint, Mapping):
            continue
        reasons = {}
        routing = joint.get("routing", "pulley")
        if routing != "pulley":
            reasons["radius_m"] = f"routing = {short_repr(routing)} has no pulley"
        if "body" in values:
            for key in ("axis", "link_length_m", "link_radius_m", "link_mass_kg"):
                reasons[key] = "[body] has the links"
        for key, reason in reasons.items():
            if key in joint:
                raise ParameterError(
                    f"{name}: joint.{number}.{key} = {short_repr(joint[key])} would do nothing: {reason}. Remove it.",
                    key=f"joint.{number}.{key}",
                )


def numbers_text(numbers: Iterable[int]) -> str:
    """Return numbers in words: "1", "1 to 7" or "1, 2, 4"."""
    in_order = list(numbers)
    if len(in_order) > 2 and in_order == list(range(in_order[0], in_order[-1] + 1)):
        return f"{in_order[0]} to {in_order[-1]}"
    return ", ".join(map(str, in_order))


def _member(table: Mapping[str, T], name: str | None, kind: str) -> T:
    if name not in table:
        raise ParameterError(
            f"the robot has no {kind} {name!r}; it has {', '.join(table)}. Electric joints have none: see "
            f"robot.pneumatic.",
            name=name,
        )
    assert name is not None
    return table[name]


def _robot(
    values: dict[str, Any], changes: Mapping[str, object], source: str, folder: Path = Path()
) -> Robot:
    for key, value in changes.items():
        _refuse_idle(values, key_text(key), value, source)
        # A dotted key becomes tables in tables, so that changes merge as a file would.
        nested: Any = value
        for part in reversed(key_text(key).split(".")):
            nested = {part: nested}
        values = _merged(values, nested)
    raw = checked_table(Tables, values, source, LACKS)
    robot = Robot(**vars(record(Tables, raw)), raw=raw, folder=folder)
    refuse_contradictions(robot, source)
    return robot


def _refuse_idle(values: Mapping[str, Any], key: str, value: object, source: str) -> None:
    """Refuse a change of a key that does not exist, unless it is a new table, and a table without values."""
    if _empty(value):
        raise ParameterError(
            f"{source}: {key} = {short_repr(value)} changes nothing. Name keys below it with their values, or leave it "
            f"out.",
            key=key,
        )
    if isinstance(value, Mapping) or _holds(values, key):
        return
    keys = dotted(Tables, values)
    if not any(f"{candidate}.".startswith(f"{key}.") for candidate in keys):
        raise ParameterError(
            f"{source}: there is no key {short_repr(key)}.{did_you_mean(key, keys)} A key is TABLE.KEY or "
            f"TABLE.NAME.KEY with its unit, e.g. joint.1.radius_m; tables: {', '.join(entries(Tables))}.",
            key=key,
        )


def _holds(values: Any, key: str) -> bool:
    """Return whether there is a value at this dotted key. It saves listing all keys for most changes."""
    for part in key.split("."):
        if not isinstance(values, Mapping) or part not in values:
            return False
        values = values[part]
    return True


def _empty(value: object, depth: int = 3) -> bool:
    """Return whether a table, or one in it, is empty."""
    if not isinstance(value, Mapping) or not depth:
        return False
    return not value or any(_empty(inner, depth - 1) for inner in value.values())


def _merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return `base` with the values of `over`, tables merged key by key."""
    out = dict(base)
    for key, value in over.items():
        old = out.get(key)
        if isinstance(old, Mapping) and isinstance(value, Mapping):
            out[key] = _merged(old, value)
        else:
            out[key] = value
    return out


def _read(path: str | PathLike[str]) -> dict[str, Any]:
    def refused(fault: str) -> ParameterError:
        cure = "Name a TOML file with lines like radius_m = 0.05 below [joint.1], or none for the packaged arm."
        return ParameterError(
            f"the parameter file '{Path(path).name or path}' {fault}. {cure}", file=Path(path).name
        )

    return dict(document_of(text_of(path, refused), refused, "TOML"))


_TABLE = re.compile(r"\[([\w.-]+)\]")
_VALUE = re.compile(r"([\w-]+)\s*=\s*[^#]*#\s*(.*)")


def sources(file: Path | None = None) -> dict[str, str]:
    """Return the comments beside the numbers of a file: dotted key -> meaning, source or "assumption".

    Without a file they are those of the packaged ones.

    Examples
    --------
    >>> sources()["sensors.encoder_bits"]
    '[1]'
    """
    comments: dict[str, str] = {}
    table = ""
    for path in (PACKAGED, REALISTIC) if file is None else (file,):
        for line in path.read_text(encoding="utf-8").splitlines():
            if heading := _TABLE.match(line):
                table = heading[1]
            elif value := _VALUE.match(line):
                comments[f"{table}.{value[1]}"] = value[2].strip()
    return comments


def changes_from_packaged(robot: Robot) -> dict[str, Any]:
    """Return the values, by dotted key, in which a robot differs from the packaged one of its `conditions_of`.

    Examples
    --------
    >>> changes_from_packaged(load_robot(changes={"hysteresis.scale": 1.5}))
    {'hysteresis.scale': 1.5}
    """
    packaged = dict(_leaves(load_robot(conditions=conditions_of(robot)).values))
    return {key: value for key, value in _leaves(robot.values) if packaged.get(key) != value}


def conditions_of(robot: Robot) -> str:
    """Return the conditions of the packaged arm from which a robot differs in the fewest values.

    Examples
    --------
    >>> conditions_of(load_robot()), conditions_of(load_robot(conditions="kind", changes={"joint.1.radius_m": 0.06}))
    ('realistic', 'kind')
    """
    values = dict(_leaves(robot.values))
    differences = {}
    for name in CONDITIONS:
        packaged = dict(_leaves(load_robot(conditions=name).values))
        keys = {*values, *packaged}
        differences[name] = sum(values.get(key) != packaged.get(key) for key in keys)
    return min(CONDITIONS, key=lambda name: (differences[name], name != DEFAULT))


def _leaves(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def refuse_contradictions(robot: Robot, source: str) -> None:
    """Refuse names of tables and files that are not there, and values that contradict each other."""
    for name, table in (("body", robot.body), ("reference", robot.reference)):
        if table is not None and table.file is not None and not robot.beside(table.file).is_file():
            raise _refused(
                f"is not there. It is looked for beside {source}.",
                f"{name}.file",
                table.file,
                source,
            )
    for name, law in robot.maps.items():
        count = COEFFICIENTS[law.form]
        if len(law.coefficients) != count:
            raise _refused(
                f"has not the {count} coefficients of the form {law.form!r}.",
                f"map.{name}.coefficients",
                law.coefficients,
                source,
            )
    if SPRING in robot.muscles:
        raise ParameterError(
            f"{source}: muscle.{SPRING} is called as a spring in drives is. Give it another name."
        )
    for name, muscle in robot.muscles.items():
        _check_static(robot, name, source)
        counts = {len(muscle.creep_time), len(muscle.creep_force), len(muscle.creep_pressure)}
        if len(counts) > 1:
            raise _refused(
                f"and creep_force_N and creep_pressure_N_bar have {sorted(counts)} numbers: one of each a branch of "
                f"creep. For no creep type hysteresis.creep = 0.",
                f"muscle.{name}.creep_time_s", muscle.creep_time, source,
            )  # fmt: skip
    for number in robot.joints:
        _check_joint(robot, number, source)
    _check_life(robot, source)
    _check_pressures(robot, source)
    _check_numbers_of_joints(robot, source)
    # The short side of the rectangle has a rounded corner at both ends.
    if 2 * robot.path.rounding >= 0.8 * robot.path.cube:
        raise _refused(
            f"rounds more than the rectangle's short side of 0.8 x {robot.path.cube:g} m holds; below "
            f"{0.4 * robot.path.cube:.4g} m.",
            "path.rounding_m", robot.path.rounding, source,
        )  # fmt: skip


def _check_static(robot: Robot, name: str, source: str) -> None:
    """Refuse a type of muscle without a static force, and parameters that its model does not have."""
    muscle = robot.muscles[name]
    table = f"muscle.{name}"
    if muscle.map is not None:
        _refuse_unknown(muscle.map, list(robot.maps), f"{table}.map", source)
    if muscle.model is not None:
        try:
            static_map(static_map_model(muscle), robot.air.supply)
        except ParameterError as fault:
            raise _refused(
                f"cannot be used: {fault}", f"{table}.model", muscle.model, source
            ) from None
        return
    if muscle.set is not None or muscle.parameters:
        key = f"{table}.set"
        if muscle.set is None:
            key = f"{table}.parameters"
        raise ParameterError(
            f"{source}: {key} belongs to a model. Write {table}.model, or remove it.", key=key
        )
    if muscle.map is None:
        raise ParameterError(
            f"{source} lacks {table}.map. Write one of the file's maps, {', '.join(robot.maps)}, or as {table}.model "
            f"one of the models, {', '.join(muscle_names())}{LACKS}.",
            missing=[f"{table}.map"],
            source=source,
        )


def _check_numbers_of_joints(robot: Robot, source: str) -> None:
    """Refuse settings that do not fit the number of joints."""
    path = robot.path
    count = len(robot.joints)
    for number in robot.compensator.joints or ():
        if number not in robot.joints:
            raise _refused(f"names joint {number}; there are {numbers_text(robot.joints)}.", "compensator.joints",
                           robot.compensator.joints, source)  # fmt: skip
    if path.posture_weights is not None and len(path.posture_weights) != count:
        raise _refused(f"has not one weight for each of the {count} joints.", "path.posture_weights",
                       path.posture_weights, source)  # fmt: skip
    if path.center is not None and count < LEAST_OF_A_PATH:
        raise _refused(
            f"asks for a path of the tool in space, which {count} of {LEAST_OF_A_PATH} joints cannot follow. Remove "
            f"it: the joints then move along a reference of their own.",
            "path.center_m", path.center, source,
        )  # fmt: skip


def _refuse_unknown(word: str, names: Iterable[str], key: str, source: str) -> None:
    if word not in names:
        raise _refused(
            f"is not in the file.{did_you_mean(word, names)} It has {', '.join(names)}.",
            key,
            word,
            source,
        )


def _check_joint(robot: Robot, number: int, source: str) -> None:
    joint = robot.joints[number]
    key = f"joint.{number}"
    if joint.drive is not None and joint.drives is not None:
        raise _drive_missing(source, "has both drives and", key)
    if joint.drive is None and joint.drives is None:
        raise _drive_missing(source, "lacks", key)
    if joint.drives is None:
        _refuse_unknown(joint.driven[0], ["electric", *robot.muscles], f"{key}.drive", source)
    else:
        # A spring can pull against muscle 1 only.
        first, second = joint.drives
        _refuse_unknown(first, list(robot.muscles), f"{key}.drives", source)
        _refuse_unknown(second, [*robot.muscles, SPRING], f"{key}.drives", source)
    _refuse_missing_link(robot, number, source)
    if joint.pneumatic:
        _check_muscles(robot, number, source)


def _drive_missing(source: str, fault: str, key: str) -> ParameterError:
    return ParameterError(
        f'{source} {fault} {key}.drive. Write one of drive = "electric", the type of both muscles, or drives = '
        f'["dmsp40", "dmsp20"] for muscle 1 and 2.',
        key=f"{key}.drive",
    )


def _refuse_missing_link(robot: Robot, number: int, source: str) -> None:
    """Refuse a joint without a link: keys of its own in a chain, a name in the file of a body."""
    keys: tuple[str, ...] = ("body_joint",)
    cure = ", the name of the joint in the file of [body]"
    if robot.body is None:
        keys = ("axis", "damping_Nm_s", "link_length_m", "link_radius_m", "link_mass_kg")
        cure = LACKS
    values = robot.raw["joint"][str(number)]
    missing = [f"joint.{number}.{key}" for key in keys if key not in values]
    if missing:
        raise ParameterError(
            f"{source} lacks {', '.join(missing)}. Add them{cure}.", missing=missing, source=source
        )


def _check_muscles(robot: Robot, number: int, source: str) -> None:
    """Check the keys that a joint with muscles needs, and those of other routings, which it must not have."""
    joint = robot.joints[number]
    table = f"joint.{number}"
    for routing, names in NEEDED.items():
        if routing == joint.routing:
            continue
        for name in names:
            # Files may leave a radius there: `_refuse_unused` checks it.
            if name != "radius" and getattr(joint, name) is not None:
                raise _refused(f"does not route by {name}. Write {table}.routing = {routing!r}, or remove that key.",
                               f"{table}.routing", joint.routing, source)  # fmt: skip
    needed = ["valve", *NEEDED[joint.routing], "contraction"]
    if joint.sprung:
        needed += ["spring", "spring_preload"]
    key_of_field = {entry.field: key for key, entry in entries(Joint).items()}
    values = robot.raw["joint"][str(number)]
    missing = []
    for name in needed:
        if key_of_field[name] not in values:
            missing.append(key_of_field[name])
    if missing:
        raise ParameterError(
            f"{source}: {table} is driven by muscles and lacks {', '.join(missing)}. Add them, or set {table}.drive = "
            f'"electric".',
            key=table,
            missing=missing,
        )
    assert joint.valve is not None
    _refuse_unknown(joint.valve, list(robot.valves), f"{table}.valve", source)
    # Tendons need the model of the body, which is built on first use.
    if joint.routing != "tendon":
        refuse_unusable(joint, joint_arms(joint, f"{source}: {table}"), robot.lengths(number), CONTRACTIONS,
                        f"{source}: {table}")  # fmt: skip
    elif robot.body is None:
        raise _refused(
            "needs a [body] whose MJCF file has the tendons.", f"{table}.routing", "tendon", source
        )


def _check_life(robot: Robot, source: str) -> None:
    """Refuse delays that the plant cannot remember, and effects that lack their second number."""
    _refuse_long_delays(robot, source)

    def refuse_half(table: str, key: str, effect: float, needed_key: str, needed: float) -> None:
        if effect > 0 and not needed > 0:
            raise ParameterError(
                f"{source}: {table}.{key} is set and {table}.{needed_key} is 0. Set both, as in the realistic arm.",
                key=f"{table}.{needed_key}",
            )

    for name, m in robot.muscles.items():
        refuse_half(f"muscle.{name}", "tendon_N_m", m.tendon, "tendon_time_s", m.tendon_time)
    for name, v in robot.valves.items():
        table = f"valve.{name}"
        refuse_half(table, "tube_length_m", v.tube_length, "tube_diameter_m", v.tube_diameter)
    for number, joint in robot.joints.items():
        table = f"joint.{number}"
        damping = joint.backlash_damping
        refuse_half(table, "backlash_deg", joint.backlash, "backlash_damping_Nm_s", damping)
    s = robot.sensors
    refuse_half(
        "sensors", "angle_drift_deg", s.angle_drift, "angle_drift_time_s", s.angle_drift_time
    )
    refuse_half(
        "sensors",
        "pressure_drift_bar",
        s.pressure_drift,
        "pressure_drift_time_s",
        s.pressure_drift_time,
    )


def _refuse_long_delays(robot: Robot, source: str) -> None:
    simulation = robot.simulation
    sensors = robot.sensors
    command = simulation.command_delay + simulation.command_jitter
    delays = {}  # key of the file -> the longest delay with what is added to it [s]
    for name, valve in robot.valves.items():
        delays[f"valve.{name}.delay_s"] = command + valve.delay
    for name, valve in robot.valves.items():
        delays[f"valve.{name}.tube_length_m"] = valve.tube_length / SPEED_OF_SOUND
    delays["sensors.angle_delay_s"] = sensors.angle_delay + sensors.angle_jitter
    delays["sensors.pressure_delay_s"] = sensors.pressure_delay + sensors.pressure_jitter
    longest = DELAY_PERIODS * simulation.period
    for key, delay in delays.items():
        if delay > longest:
            raise _refused(
                f"makes a delay of {1e3 * delay:.3g} ms with what is added to it; the plant remembers {DELAY_PERIODS} "
                f"periods, {1e3 * longest:.3g} ms. Make delays smaller or simulation.period_s larger.",
                key, dict(_leaves(robot.raw)).get(key, 0.0), source,
            )  # fmt: skip


def _check_pressures(robot: Robot, source: str) -> None:
    c = robot.controller
    supply = robot.air.supply
    if not c.pressure_low < c.mean_pressure < c.pressure_high:
        raise _refused(
            f"is not between pressure_low_bar = {c.pressure_low / 1e5:g} and pressure_high_bar = "
            f"{c.pressure_high / 1e5:g}.",
            "controller.mean_pressure_bar", c.mean_pressure / 1e5, source,
        )  # fmt: skip
    if c.pressure_high >= supply:
        raise _refused(
            f"is not below the supply, air.supply_bar = {supply / 1e5:g}: nothing would flow.",
            "controller.pressure_high_bar", c.pressure_high / 1e5, source,
        )  # fmt: skip


def _refused(message: str, key: str, value: object, source: str) -> ParameterError:
    return ParameterError(
        f"{source}: {key} = {short_repr(value)} {message}", key=key, value=value, source=source
    )
