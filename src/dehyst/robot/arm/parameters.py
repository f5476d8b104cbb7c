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
from dehyst.fields import checked, did_you_mean, dotted, entries, record, shown, word_of
from dehyst.files import document_of, text_of
from dehyst.robot.arm.routing import NEEDED, refuse_unusable, told_arms
from dehyst.robot.arm.static_map import model_of, static_map
from dehyst.robot.arm.tables import SPRING, Joint, Muscle, Tables, Valve
from dehyst.robot.muscles import names as model_names

PACKAGED = Path(__file__).with_name("arm.toml")
REALISTIC = PACKAGED.with_name("realistic.toml")
CONDITIONS: Mapping[str, Path | None] = {"kind": None, "realistic": REALISTIC}  # name -> changes to the packaged file
DEFAULT = "realistic"  # of these
LACKS = (
    ', or write as the first line extends = "default": what is not in the file is taken from the packaged arm; or '
    'extends = "parts": the same, but for its joints and what belongs to them'
)
OF_ITS_JOINTS = ("name", "joint", "compensator.joints", "path.center_m", "path.posture_weights")
# Muscles are pretensioned by at most 5 % and contract by at most 25 %: catalogue of the DMSP.
CONTRACTIONS = (-0.05, 0.30)
LEAST_OF_A_PATH = 3  # joints: fewer do not reach all points of a space
DELAY_PERIODS = 62  # PLANT_RING of plant/plant.h, less what the interpolation needs
COEFFICIENTS = {"tool": 6, "exponential": 6, "geometric": 8}
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Robot(Tables):
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

    raw: Mapping[str, Any]
    folder: Path = Path()

    def joint(self, number: int) -> Joint:
        """Return the joint of this number, from 1 on."""
        if number not in self.joints:
            raise ParameterError(
                f"the robot has no joint {number!r}. Its joints are {listed(self.joints)}, with muscles "
                f"{listed(self.pneumatic) or 'none'}.",
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
        found = [self.muscle(name) for name in joint.driven if name != SPRING] if joint.pneumatic else []
        if joint.sprung:
            of = found[0]
            found += [replace(of, volume=(0.0,) * 4, dead_volume=of.dead_volume + of.length * of.volume[0],
                              viscous_force=0.0, creep_time=(), creep_force=(), creep_pressure=(), hysteresis=0.0,
                              tendon=0.0, warming=0.0, warming_time=0.0, warm_stiffness=0.0)]  # fmt: skip
        return tuple(found)

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
        told = self.compensator.joints
        return tuple(n for n in self.pneumatic if told is None or n in told)

    def beside(self, file: str) -> Path:
        """Return the place of a file that the robot's own names."""
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
        body = b"" if self.body is None else self.beside(self.body.file).read_bytes()
        return hashlib.sha256(text + body).hexdigest()[:16]

    def __repr__(self) -> str:
        drives = ", ".join(f"{n} {' and '.join(dict.fromkeys(joint.driven))}" for n, joint in self.joints.items())
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
    values, name = (_read(path), Path(path).name) if path is not None else ({"extends": "default"}, PACKAGED.name)
    return robot_of(values, name, Path() if path is None else Path(path).parent, changes, conditions)


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
            f'{name}: extends = {shown(base)} is not known. Write extends = "default" for the packaged arm, or '
            f"{' or '.join(map(repr, CONDITIONS))} for its conditions, 'parts' for a robot with joints of its own, or "
            f"copy that file whole.",
            key="extends",
            value=base,
        )
    if conditions is not None and (base is None or conditions not in CONDITIONS):
        raise ParameterError(
            f"{name}: conditions {shown(conditions)} are {'not known' if base else 'those of the packaged arm'}. They "
            f"are {' and '.join(CONDITIONS)}, for the packaged arm and files that begin with extends = ...; any other "
            f"file says all numbers itself.",
            conditions=conditions,
        )
    packaged: dict[str, Any] = {}
    if base is not None:
        over = CONDITIONS[conditions or (base if base in CONDITIONS else DEFAULT)]
        packaged = _merged(_read(PACKAGED), _read(over) if over else {})
    _refuse_unused(values, name)
    for key in OF_ITS_JOINTS if base == "parts" else ():
        table, _, inner = key.rpartition(".")
        del (packaged[table] if table else packaged)[inner]
    return _robot(_merged(packaged, values), changes or {}, name, folder)


def _refuse_unused(values: Mapping[str, Any], name: str) -> None:
    """Keys that a file itself gives to a joint that has no use for them."""
    joints = values.get("joint")
    for number, joint in joints.items() if isinstance(joints, Mapping) else ():
        if not isinstance(joint, Mapping):
            continue
        routing = joint.get("routing", "pulley")
        unused = {"radius_m": f"routing = {shown(routing)} has no pulley"} if routing != "pulley" else {}
        if "body" in values:
            unused |= dict.fromkeys(("axis", "link_length_m", "link_radius_m", "link_mass_kg"), "[body] has the links")
        for key in [key for key in unused if key in joint]:
            raise ParameterError(
                f"{name}: joint.{number}.{key} = {shown(joint[key])} would do nothing: {unused[key]}. Remove it.",
                key=f"joint.{number}.{key}",
            )


def listed(numbers: Iterable[int]) -> str:
    """Return numbers as they are read: "1", "1 to 7" or "1, 2, 4"."""
    given = list(numbers)
    if len(given) > 2 and given == list(range(given[0], given[-1] + 1)):
        return f"{given[0]} to {given[-1]}"
    return ", ".join(map(str, given))


def _member(table: Mapping[str, T], name: str | None, kind: str) -> T:
    if name not in table:
        raise ParameterError(
            f"the robot has no {kind} {name!r}; it has {', '.join(table)}. Electric joints have none: see "
            f"robot.pneumatic.",
            name=name,
        )
    assert name is not None
    return table[name]


def _robot(values: dict[str, Any], changes: Mapping[str, object], source: str, folder: Path = Path()) -> Robot:
    for key, value in changes.items():
        _refuse_idle(values, word_of(key), value, source)
        nested: Any = value
        for part in reversed(word_of(key).split(".")):
            nested = {part: nested}
        values = _merged(values, nested)
    raw = checked(Tables, values, source, LACKS)
    robot = Robot(**vars(record(Tables, raw)), raw=raw, folder=folder)
    refuse_contradictions(robot, source)
    return robot


def _refuse_idle(values: Mapping[str, Any], key: str, value: object, source: str) -> None:
    """A change of a single key names one that exists, only whole tables may be new; and each changes something."""
    if _empty(value):
        raise ParameterError(
            f"{source}: {key} = {shown(value)} changes nothing. Name keys below it with their values, or leave it out.",
            key=key,
        )
    if isinstance(value, Mapping) or _holds(values, key):
        return
    known = dotted(Tables, values)
    if not any(f"{each}.".startswith(f"{key}.") for each in known):
        raise ParameterError(
            f"{source}: there is no key {shown(key)}.{did_you_mean(key, known)} A key is TABLE.KEY or TABLE.NAME.KEY "
            f"with its unit, e.g. joint.1.radius_m; tables: {', '.join(entries(Tables))}.",
            key=key,
        )


def _holds(values: Any, key: str) -> bool:
    """Whether there is a value at this dotted key: the quick answer for most of them."""
    for part in key.split("."):
        if not isinstance(values, Mapping) or part not in values:
            return False
        values = values[part]
    return True


def _empty(value: object, depth: int = 3) -> bool:
    """Whether a table, or one in it, holds nothing."""
    if not isinstance(value, Mapping) or not depth:
        return False
    return not value or any(_empty(each, depth - 1) for each in value.values())


def _merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return `base` with the values of `over`, tables merged key by key."""
    out = dict(base)
    for key, value in over.items():
        old = out.get(key)
        out[key] = _merged(old, value) if isinstance(old, Mapping) and isinstance(value, Mapping) else value
    return out


def _read(path: str | PathLike[str]) -> dict[str, Any]:
    def refused(what: str) -> ParameterError:
        cure = "Name a TOML file with lines like radius_m = 0.05 below [joint.1], or none for the packaged arm."
        return ParameterError(f"the parameter file '{Path(path).name or path}' {what}. {cure}", file=Path(path).name)

    return dict(document_of(text_of(path, refused), refused, "TOML"))


_TABLE = re.compile(r"\[([\w.-]+)\]")
_VALUE = re.compile(r"([\w-]+)\s*=\s*[^#]*#\s*(.*)")


def sources(file: Path | None = None) -> dict[str, str]:
    """Return what a file, else the packaged ones, says beside each number: dotted key -> meaning, source, "assumption".

    Examples
    --------
    >>> sources()["sensors.encoder_bits"]
    '[1]'
    """
    found: dict[str, str] = {}
    table = ""
    files = (PACKAGED, REALISTIC) if file is None else (file,)
    for line in "".join(each.read_text(encoding="utf-8") for each in files).splitlines():
        if heading := _TABLE.match(line):
            table = heading[1]
        elif value := _VALUE.match(line):
            found[f"{table}.{value[1]}"] = value[2].strip()
    return found


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
    own = dict(_leaves(robot.values))
    packaged = {name: dict(_leaves(load_robot(conditions=name).values)) for name in CONDITIONS}
    unlike = {name: sum(own.get(k) != of.get(k) for k in {*own, *of}) for name, of in packaged.items()}
    return min(CONDITIONS, key=lambda name: (unlike[name], name != DEFAULT))


def _leaves(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def refuse_contradictions(robot: Robot, source: str) -> None:
    """Check names that refer to other tables, and values against each other."""
    for name, table in (("body", robot.body), ("reference", robot.reference)):
        if table is not None and table.file is not None and not robot.beside(table.file).is_file():
            raise _refused(f"is not there. It is looked for beside {source}.", f"{name}.file", table.file, source)
    for name, law in robot.maps.items():
        wanted = COEFFICIENTS[law.form]
        if len(law.coefficients) != wanted:
            raise _refused(
                f"has not the {wanted} coefficients of the form {law.form!r}.",
                f"map.{name}.coefficients",
                law.coefficients,
                source,
            )
    if SPRING in robot.muscles:
        raise ParameterError(f"{source}: muscle.{SPRING} is called as a spring in drives is. Give it another name.")
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
    if 2 * robot.path.rounding >= 0.8 * robot.path.cube:
        raise _refused(
            f"rounds more than the rectangle's short side of 0.8 x {robot.path.cube:g} m holds; below "
            f"{0.4 * robot.path.cube:.4g} m.",
            "path.rounding_m", robot.path.rounding, source,
        )  # fmt: skip


def _check_static(robot: Robot, name: str, source: str) -> None:
    """A type of muscle has a map or a model, and the model the parameters that it is given."""
    muscle, where = robot.muscles[name], f"muscle.{name}"
    if muscle.map is not None:
        _known(muscle.map, list(robot.maps), f"{where}.map", source)
    if muscle.model is not None:
        try:
            static_map(model_of(muscle), robot.air.supply)
        except ParameterError as fault:
            raise _refused(f"cannot be used: {fault}", f"{where}.model", muscle.model, source) from None
        return
    if muscle.set is not None or muscle.parameters:
        key = f"{where}.parameters" if muscle.set is None else f"{where}.set"
        raise ParameterError(f"{source}: {key} belongs to a model. Write {where}.model, or remove it.", key=key)
    if muscle.map is None:
        raise ParameterError(
            f"{source} lacks {where}.map. Write one of the file's maps, {', '.join(robot.maps)}, or as {where}.model "
            f"one of the models, {', '.join(model_names())}{LACKS}.",
            missing=[f"{where}.map"],
            source=source,
        )


def _check_numbers_of_joints(robot: Robot, source: str) -> None:
    """What is told of single joints fits the joints that there are."""
    count, path = len(robot.joints), robot.path
    for number in robot.compensator.joints or ():
        if number not in robot.joints:
            raise _refused(f"names joint {number}; there are {listed(robot.joints)}.", "compensator.joints",
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


def _known(word: str, names: Iterable[str], key: str, source: str) -> None:
    if word not in names:
        raise _refused(f"is not in the file.{did_you_mean(word, names)} It has {', '.join(names)}.", key, word, source)


def _check_joint(robot: Robot, number: int, source: str) -> None:
    joint = robot.joints[number]
    where = f"joint.{number}"
    if (joint.drive is None) == (joint.drives is None):
        raise ParameterError(
            f"{source} {'lacks' if joint.drive is None else 'has both drives and'} {where}.drive. Write one of drive = "
            f'"electric", the type of both muscles, or drives = ["dmsp40", "dmsp20"] for muscle 1 and 2.',
            key=f"{where}.drive",
        )
    for m, name in enumerate(joint.driven):
        types = [*robot.muscles, *[SPRING] * m] if joint.drives else ["electric", *robot.muscles]
        _known(name, types, f"{where}.drive{'s' if joint.drives else ''}", source)
    chain = ("axis", "damping_Nm_s", "link_length_m", "link_radius_m", "link_mass_kg")
    needed = chain if robot.body is None else ("body_joint",)
    if lacking := [key for key in needed if key not in robot.raw["joint"][str(number)]]:
        more = LACKS if robot.body is None else ", the name of the joint in the file of [body]"
        keys = [f"{where}.{key}" for key in lacking]
        raise ParameterError(f"{source} lacks {', '.join(keys)}. Add them{more}.", missing=keys, source=source)
    if not joint.pneumatic:
        return
    for routing, names in NEEDED.items():
        for name in {*names} - {"radius"} if joint.routing != routing else ():
            if getattr(joint, name) is not None:
                raise _refused(f"does not route by {name}. Write {where}.routing = {routing!r}, or remove that key.",
                               f"{where}.routing", joint.routing, source)  # fmt: skip
    key_of = {entry.field: key for key, entry in entries(Joint).items()}
    asked = ("valve", *NEEDED[joint.routing], "contraction", *["spring", "spring_preload"] * joint.sprung)
    lacking = [key_of[name] for name in asked if key_of[name] not in robot.raw["joint"][str(number)]]
    if lacking:
        raise ParameterError(
            f"{source}: {where} is driven by muscles and lacks {', '.join(lacking)}. Add them, or set {where}.drive = "
            f'"electric".',
            key=where,
            missing=lacking,
        )
    assert joint.valve is not None
    _known(joint.valve, list(robot.valves), f"{where}.valve", source)
    if joint.routing != "tendon":  # those need the body's model: on first use
        refuse_unusable(joint, told_arms(joint, f"{source}: {where}"), robot.lengths(number), CONTRACTIONS,
                        f"{source}: {where}")  # fmt: skip
    elif robot.body is None:
        raise _refused("needs a [body] whose MJCF file has the tendons.", f"{where}.routing", "tendon", source)


def _check_life(robot: Robot, source: str) -> None:
    """Delays must fit into the plant's memory; what divides by a second number needs that one."""
    s, sensors = robot.simulation, robot.sensors
    command = s.command_delay + s.command_jitter
    delays = {f"valve.{name}.delay_s": command + valve.delay for name, valve in robot.valves.items()}
    delays |= {f"valve.{name}.tube_length_m": valve.tube_length / 343.0 for name, valve in robot.valves.items()}
    delays |= {f"sensors.{kind}_delay_s": getattr(sensors, f"{kind}_delay") + getattr(sensors, f"{kind}_jitter")
               for kind in ("angle", "pressure")}  # fmt: skip
    for key, delay in delays.items():
        if delay > DELAY_PERIODS * s.period:
            raise _refused(
                f"makes a delay of {1e3 * delay:.3g} ms with what is added to it; the plant remembers {DELAY_PERIODS} "
                f"periods, {1e3 * DELAY_PERIODS * s.period:.3g} ms. Make delays smaller or simulation.period_s larger.",
                key, dict(_leaves(robot.raw)).get(key, 0.0), source,
            )  # fmt: skip
    needed = [(f"muscle.{name}", muscle.tendon, "tendon_N_m", muscle.tendon_time, "tendon_time_s")
              for name, muscle in robot.muscles.items()]  # fmt: skip
    needed += [(f"valve.{name}", valve.tube_length, "tube_length_m", valve.tube_diameter, "tube_diameter_m")
               for name, valve in robot.valves.items()]  # fmt: skip
    needed += [(f"joint.{number}", joint.backlash, "backlash_deg", joint.backlash_damping, "backlash_damping_Nm_s")
               for number, joint in robot.joints.items()]  # fmt: skip
    needed += [("sensors", sensors.angle_drift, "angle_drift_deg", sensors.angle_drift_time, "angle_drift_time_s"),
               ("sensors", sensors.pressure_drift, "pressure_drift_bar", sensors.pressure_drift_time,
                "pressure_drift_time_s")]  # fmt: skip
    for where, value, key, other, lacking in needed:
        if value > 0 and not other > 0:
            raise ParameterError(
                f"{source}: {where}.{key} is set and {where}.{lacking} is 0. Set both, as in the realistic arm.",
                key=f"{where}.{lacking}",
            )


def _check_pressures(robot: Robot, source: str) -> None:
    c, supply = robot.controller, robot.air.supply
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
    return ParameterError(f"{source}: {key} = {shown(value)} {message}", key=key, value=value, source=source)
