"""Fits the plant's own parameters to logs of a rig or a muscle on a bench: what is found, how sure, what is not told.

Whatever a log holds is what one joint of the plant does with what the log says was done to it: forces and torques from
angle and pressures, angles that balance a constant load, pressures behind a valve. Parameters are keys of the robot's
file, in its units and within its ranges.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from dehyst.arrays import Array, Mask
from dehyst.errors import ParameterError, RecordingError
from dehyst.fields import entries
from dehyst.robot._native import PneumaticJoint
from dehyst.robot.arm.joints import pneumatic_joint_parameters, run_pressures
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.arm.tables import SPRING, ForceMap, Hysteresis, Joint, Muscle, Valve

TABLES: Mapping[str, type] = {
    "map": ForceMap, "hysteresis": Hysteresis, "muscle": Muscle, "valve": Valve, "joint": Joint
}  # fmt: skip
MAP = {"tool": (0, 1, 2, 3), "exponential": tuple(range(6)), "geometric": (0, 4, 5, 6, 7)}  # the others are redundant
ALIKE = {f"tolerance.{name}": 0.0 for name in ("hysteresis", "force", "shape", "contraction", "dead_band", "middle")}
ALIKE["hysteresis.scatter"] = 0.0
AT_REST = {"hysteresis.mechanism": "none", "hysteresis.creep": 0.0}
DOUBT = 0.5  # of a file's number, rms: what is held is taken to be that far off, and so are numbers to begin with
TOLD = 0.5  # of a number that its 95 % interval may reach to either side, or the log does not tell it
OFFSETS = {"zero": "deg", "load": "Nm"}
ALL = -1  # in the place of an index: a factor of a whole list
NONE_LEFT = 0.1  # of the file's number: a wider one is told, too, if it shows that there is none of it
LONG = 4000  # samples of a log that count at most
SAMPLES = {"angle": 250}  # of logs whose angle is solved for
PARTS, HELD_OUT = 10, (2, 5, 8)  # of a log, and those that are not fitted
SLACK = 0.005  # of the largest force: below, a muscle hangs loose
NOTHING = 1e-3  # change of all errors together, in units of theirs, that a number's doubt makes if no sample tells it
KINDS = {(True, True): "hold", (True, False): "isobaric", (False, True): "isometric"}  # pressure, length still?
STILL = {"pressure": 5e3, "moved": 0.005, "response": 0.02}  # [Pa], of its range, of its range: does not move
UNITS = {"force": (1.0, "N"), "torque": (1.0, "Nm"), "angle": (180.0 / math.pi, "deg"), "pressure": (1e-5, "bar")}


@dataclass(frozen=True, eq=False)
class RigLog:
    """What was done to a muscle or a joint, and what it did. SI units.

    Attributes
    ----------
    quantity
        What ``response`` is: "force" of one muscle or "torque" of the joint, driven along ``moved``; "angle" of the
        joint under a constant torque; "pressure" of the first muscle behind its ``valve``.
    response
        (T,) [N], [Nm], [rad] or gauge [Pa].
    pressure
        (T, 2) of muscle 1 and 2, gauge; of a muscle alone the second column means nothing. [Pa]
    moved
        (T,) contraction of a muscle alone, or angle of the joint [rad] if ``of_joint``.
    time
        (T,), increasing [s]; None: each sample is a point at rest.
    valve
        (T,) command of the first muscle's valve, -1..1.
    tested
        Whether all of it is left out of the fit; else three of ten parts are.
    """

    name: str
    quantity: str
    response: Array
    pressure: Array
    moved: Array
    time: Array | None = None
    valve: Array | None = None
    of_joint: bool = False
    tested: bool = False

    def __post_init__(self) -> None:
        many = {each.shape[0] for each in (self.response, self.pressure, self.moved, self.time, self.valve)
                if each is not None}  # fmt: skip
        if len(many) != 1 or min(many) < PARTS:
            raise RecordingError(
                f"columns of {self.name} have {sorted(many)} samples: they must be of one log, of {PARTS} or more."
            )
        if self.time is None and self.quantity in ("angle", "pressure"):
            raise RecordingError(f"{self.name} has no time, without which its {self.quantity} tells nothing. Log it.")

    @property
    def fitted(self) -> Mask:
        """(T,) samples that the fit sees."""
        part = np.arange(self.response.size) * PARTS // self.response.size
        return np.logical_not(self.tested | np.isin(part, HELD_OUT))

    @property
    def counted(self) -> Mask:
        """(T,) samples that say something: of forces those at which the muscle pulls."""
        if self.quantity != "force":
            return np.ones(self.response.size, dtype=bool)
        return np.asarray(self.response > SLACK * float(self.response.max()))

    @property
    def kinds(self) -> dict[str, float]:
        """Seconds of what bench engineers call it: isobaric, isometric, isotonic, hold, step, filling; or points."""
        if self.time is None:
            return {"points at rest": float(self.response.size)}
        if self.quantity == "pressure":
            return {"filling": float(np.ptp(self.time))}
        found: dict[str, float] = {}
        pressure, angle = self.pressure[:, : 1 + self.of_joint], self.quantity == "angle"
        moved = self.response if angle else self.moved
        for part in np.array_split(np.arange(self.response.size), min(60, self.response.size // 5)):
            p, k, f = (float(np.ptp(v[part], axis=0).max()) for v in (pressure, moved, self.response))
            still = p <= STILL["pressure"], k <= STILL["moved"] * max(float(np.ptp(moved)), 0.01)
            kind = KINDS.get(still, "both move")
            if kind == "isometric" and np.abs(np.diff(pressure[part], axis=0)).max() > 0.5 * p:
                kind = "step"
            if kind == "both move" and (angle or f <= STILL["response"] * float(np.ptp(self.response))):
                kind = "isotonic"
            found[kind] = found.get(kind, 0.0) + float(np.ptp(self.time[part]))
        return found


def named(key: str, index: int | None) -> str:
    """Return a key with the place in its list, from 1 on; a factor of the whole list is said to be one."""
    return key if index is None else f"{key}, factor" if index == ALL else f"{key}[{index + 1}]"


class Free(NamedTuple):
    """A number that may move: key of the file and place in its list, `ALL` for a factor of the whole list.

    What is no number of the file is a key of `OFFSETS`: arguments of `respond` that all logs of angles share.
    """

    key: str
    place: int | None
    value: float
    low: float
    high: float
    doubt: float


@dataclass(frozen=True)
class Number:
    """What a log says of one number of the file.

    Attributes
    ----------
    before, found, interval
        Of the file; fitted, or the file's if it is not told; half width of its 95 % interval, with what the numbers
        that were held may be off.
    told
        Whether the logs tell it.
    why
        If not: why.
    """

    key: str
    place: int | None
    before: float
    found: float
    interval: float
    told: bool
    why: str = ""


@dataclass(frozen=True, eq=False)
class LogFit:
    """A log beside the plant: what it does before and after, (T,) each, and rms errors.

    ``errors`` are "fitted_before", "held_out_after" and so on, in SI; those of "bent" have all numbers moved, told or
    not: as close as the plant's equations come.
    """

    log: RigLog
    before: Array
    after: Array
    errors: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class PlantFit:
    """Result: a robot with the numbers that were told, all numbers, every log, and `OFFSETS` of logs of angles."""

    robot: Robot
    numbers: tuple[Number, ...]
    logs: tuple[LogFit, ...]
    offsets: dict[str, float]

    @property
    def changes(self) -> dict[str, Any]:
        """Dotted key -> fitted value, a list where the file has one."""
        given = dict.fromkeys(number.key for number in self.numbers if number.told)
        return {key: _at(self.robot.raw, key) for key in given}


def fit_plant(robot: Robot, number: int, logs: Sequence[RigLog]) -> PlantFit:
    """Return the robot whose joint does what the logs show, as far as they tell.

    Least squares over the samples of all logs, each in units of its own rms error times the root of its errors'
    correlation time, so that errors that follow each other count as few. At first every number has a doubt of half of
    itself about the file's; those whose 95 % interval stays wider than half of themselves go back to the file, and the
    rest are fitted without any doubt. Their variance is that of the fit, and that through numbers that were put back,
    (J_t^T J_t)^-1 J_t^T J_h times their doubt.

    Parameters
    ----------
    robot
        With the numbers to begin with.
    number
        Of a joint with muscles; a muscle alone is its first one.
    logs
        One or more.

    Raises
    ------
    ParameterError
        If no log is to be fitted, or the joint is electric.

    Examples
    --------
    >>> from dehyst.robot.arm import load_robot
    >>> true = load_robot(changes={"map.tool.coefficients": [6000, 0.13, 10.5, 2.0, 0.25, 620000]} | ALIKE)
    >>> k, p = (each.ravel() for each in np.meshgrid(np.linspace(0, 0.2, 12), np.linspace(1e5, 6e5, 6)))
    >>> log = RigLog("points", "force", np.zeros(72), np.stack([p, p], axis=1), k)
    >>> force = respond(true, 1, log)
    >>> found = fit_plant(load_robot(), 1, [RigLog("points", "force", force, log.pressure, k)])
    >>> [f"{each:.4g}" for each in found.changes["map.tool.coefficients"]][:4]
    ['6000', '0.13', '10.5', '2']
    """
    if all(log.tested for log in logs):
        raise ParameterError("every log is kept for the test. Give one or more that may be fitted.")
    start = robot.with_changes(ALIKE)
    logs = [_even(log) for log in logs]
    problem = _Problem(start, number, logs, _free(start, number, logs))
    first = np.array([each.value for each in problem.free])
    doubt = np.array([each.doubt for each in problem.free])
    problem.weigh(first, rough=True)
    shown = np.linalg.norm(problem.slopes(first), axis=0) * doubt > NOTHING
    x = problem.search(first, shown, doubt=True)
    problem.weigh(x)
    x = problem.search(x, shown, doubt=True)
    own = np.array([each.key in OFFSETS for each in problem.free])
    size = _narrow(x, first)
    slopes = problem.slopes(x)
    spread = np.linalg.inv(slopes.T @ slopes + np.diag(doubt**-2.0))
    told = own | shown & (2.0 * np.sqrt(np.diag(spread)) <= size)
    while True:
        moved = problem.search(np.where(told, x, first) if np.any(told & ~own) else first, told)
        problem.weigh(moved)
        slopes = problem.slopes(moved)
        interval = 2.0 * np.sqrt(_variance(slopes, told, doubt))
        over = np.where(told & ~own, interval / _narrow(moved, first), 0.0)
        if over.max(initial=0.0) <= 1.0:
            break
        told[int(np.argmax(over))] = False
    numbers = tuple(
        Number(each.key, each.place, each.value, float(moved[i]), float(interval[i]), bool(told[i]),
               "" if told[i] else _why(problem.free, i, slopes, spread, size))
        for i, each in enumerate(problem.free) if not own[i]
    )  # fmt: skip
    shown_by = [problem.responses(v) for v in (problem.search(first, own), moved, x)]
    fits = tuple(_scored(log, *three) for log, *three in zip(logs, *shown_by, strict=True))
    changes = problem.changes(moved)
    return PlantFit(robot.with_changes(changes) if changes else robot, numbers, fits, problem.offsets(moved))


def respond(robot: Robot, number: int, log: RigLog, zero: float = 0.0, load: float = 0.0) -> Array:
    """Return (T,) what a joint, or its first muscle alone, does with what a log says was done to it.

    Parameters
    ----------
    robot, number
        Robot and joint.
    log
        Its response counts only as the first angle or pressure.
    zero, load
        Of a log of angles: the joint's angle where the log has zero, and the constant torque. [deg], [Nm]
    """
    return _course(robot.with_changes(_driven(robot, number, log)), number, log, zero, load)


def _driven(robot: Robot, number: int, log: RigLog) -> dict[str, Any]:
    """Changes by which a joint moves as in the log: one muscle alone, or every sample at rest."""
    changes: dict[str, Any] = {} if log.of_joint else {f"joint.{number}.parallel": 1}
    if log.time is None:
        names = set(robot.joint(number).driven) - {SPRING}
        changes |= {**AT_REST, **{f"muscle.{name}.viscous_force_N": 0.0 for name in names}}
    return changes


def _course(robot: Robot, number: int, log: RigLog, zero: float = 0.0, load: float = 0.0) -> Array:
    """What `respond` returns, of a robot with what the log is `_driven` by."""
    physics = pneumatic_joint_parameters(robot, number, 0)
    radius, length = physics["arm"][0][0], physics["muscle"][0]["length"]
    if not log.of_joint:  # how it is led to a joint does not matter
        physics["arm"] = [[radius], [-radius]]
    angle = log.moved if log.of_joint else (log.moved - physics["contraction"]) * length / radius
    period = 1.0 if log.time is None else float(log.time[1] - log.time[0])
    if log.quantity == "angle":
        return _balanced(physics, log, period, math.radians(zero), load)
    if log.quantity == "pressure":
        return _filled(physics, log, angle, robot.simulation.period)
    course = run_pressures(physics, angle, log.pressure, period)
    return course.torque if log.quantity == "torque" else course.force[:, 0]


def _balanced(physics: dict[str, Any], log: RigLog, period: float, zero: float, load: float) -> Array:
    """Angles (T,) at which the muscles carry the load, one after the other: the memory of each goes on from there."""
    joint, p, q = PneumaticJoint(physics, 0), log.pressure, float(log.response[0]) + zero
    joint.reset(q, float(p[0, 0]), float(p[0, 1]), 0)
    found, stiffness = [], 100.0 * physics["arm"][0][0]

    def left(image: bytes, old: float, new: float, k: int) -> float:
        joint.restore(image)
        return joint.impose(old, (new - old) / period, float(p[k, 0]), float(p[k, 1]), period) - load

    for k in range(p.shape[0]):
        image, a = joint.save(), q
        f = left(image, q, a, k)
        for _ in range(12):
            step = min(max(f / stiffness, -0.2), 0.2)
            if abs(step) < 1e-6:
                break
            b = min(max(a + step, -3.0), 3.0)
            g = left(image, q, b, k)
            if b != a and (f - g) / (b - a) > 1e-3:
                stiffness = (f - g) / (b - a)
            a, f = b, g
        left(image, q, a, k)
        q = a
        found.append(q - zero)
    return np.array(found)


def _filled(physics: dict[str, Any], log: RigLog, angle: Array, period: float) -> Array:
    """Gauge pressure (T,) of the first muscle behind its valve."""
    assert log.time is not None
    assert log.valve is not None
    fine = np.arange(log.time[0], log.time[-1] + period, period)
    q = np.interp(fine, log.time, angle)
    held = log.valve[np.clip(np.searchsorted(log.time, fine, side="right") - 1, 0, log.time.size - 1)]
    joint = PneumaticJoint(physics, 0)
    joint.reset(float(q[0]), float(log.response[0]), float(log.response[0]), 0)
    signals = joint.run(q, np.gradient(q, period), np.stack([held, np.zeros(held.size)], axis=1), period)
    pressure = signals["pressure"][:, 0] - physics["air"]["ambient"]
    return np.asarray(np.interp(log.time, fine + period, pressure))


def _even(log: RigLog) -> RigLog:
    """The same log at even intervals, few enough for a fit."""
    if log.time is None:
        return log
    known = log.time
    many = min(known.size, SAMPLES.get(log.quantity, LONG))
    time = np.linspace(known[0], known[-1], many)

    def at(values: Array) -> Array:
        return np.asarray(np.interp(time, known, values))

    valve = None if log.valve is None else log.valve[np.searchsorted(known, time, side="right") - 1]
    pressure = np.stack([at(column) for column in log.pressure.T], axis=1)
    return RigLog(log.name, log.quantity, at(log.response), pressure, at(log.moved), time, valve, log.of_joint,
                  log.tested)  # fmt: skip


def _at(raw: Mapping[str, Any], key: str) -> Any:
    found: Any = raw
    for part in key.split("."):
        found = found.get(part, 0.0)
    return found


def _free(robot: Robot, number: int, logs: Sequence[RigLog]) -> list[Free]:
    """Numbers that logs of this joint may tell; whether they do is seen from the slopes."""
    joint, name = robot.joint(number), robot.joint(number).driven[0]
    muscle = robot.muscle(name)
    law = None if muscle.model is not None or muscle.map is None else robot.maps[muscle.map]
    told: list[tuple[str, int | None]] = []
    if law is not None:  # a model's own parameters are `dehyst muscle`'s to fit
        told = [(f"map.{muscle.map}.coefficients", i) for i in MAP[law.form]]
        if law.force_of_length is not None and law.form == "tool":
            told[0] = (f"map.{muscle.map}.force_of_length", 0)
    told += [(f"muscle.{name}.hysteresis_N", None), ("hysteresis.pressure_share", None), ("hysteresis.asymmetry", None)]
    told += [(f"muscle.{name}.viscous_force_N", None)]
    if muscle.creep_time:
        told += [(f"muscle.{name}.creep_{key}", ALL) for key in ("force_N", "pressure_N_bar")]
    if any(log.of_joint for log in logs):
        told += [(f"joint.{number}.contraction", None)]
        told += [(f"joint.{number}.radius_m", None)] if joint.routing == "pulley" else []
    if any(log.quantity == "pressure" for log in logs):
        told += [(f"valve.{joint.valve}.conductance_l_s_bar", None), (f"muscle.{name}.dead_volume_l", None)]
    found = []
    for key, index in told:
        held: Any = _at(robot.raw, key)
        value = 1.0 if index == ALL else float(held if index is None else held[index])
        bounds = entries(TABLES[key.split(".")[0]])[key.split(".")[-1]].key
        low, high = (0.0, 100.0) if index == ALL else (bounds.low, bounds.high)
        if key.startswith("map."):
            low, high = sorted((0.1 * value, 10.0 * value))
        if low < value < high or value == low < high:
            doubt = DOUBT * (abs(value) or 0.1 * (high - low))
            found.append(Free(key, index, value, low, high, doubt))
    angles = [log.response for log in logs if log.quantity == "angle"]
    if angles:
        middle = -math.degrees(float(angles[0].max() + angles[0].min()) / 2)
        found += [Free("zero", None, middle, -180.0, 180.0, 90.0), Free("load", None, 0.0, -1e4, 1e4, 1e3)]
    return found


class _Problem:
    """Errors of all logs over the free numbers, each log with its weight."""

    def __init__(self, robot: Robot, number: int, logs: Sequence[RigLog], free: list[Free]) -> None:
        self.robot, self.number, self.logs, self.free = robot, number, logs, free
        self.driven = [_driven(robot, number, log) for log in logs]
        self.weight: Array = np.ones(len(logs))
        self.scale = np.array([each.doubt for each in free])
        self.bounds = np.array([[each.low, each.high] for each in free]).T

    def changes(self, x: Array) -> dict[str, Any]:
        """Keys of the file whose values differ."""
        found: dict[str, Any] = {}
        for each, value in zip(self.free, x.tolist(), strict=True):
            if each.key not in OFFSETS and value != each.value:
                if each.place == ALL:
                    found[each.key] = [value * old for old in _at(self.robot.raw, each.key)]
                elif each.place is not None:
                    found.setdefault(each.key, list(_at(self.robot.raw, each.key)))[each.place] = value
                else:
                    found[each.key] = value
        return found

    def offsets(self, x: Array) -> dict[str, float]:
        return {each.key: value for each, value in zip(self.free, x.tolist(), strict=True) if each.key in OFFSETS}

    def responses(self, x: Array) -> list[Array]:
        changes, offsets = self.changes(x), self.offsets(x)
        robots = (self.robot.with_changes(changes | driven) for driven in self.driven)  # one each: checks take long
        return [_course(robot, self.number, log, **offsets) for robot, log in zip(robots, self.logs, strict=True)]

    def missed(self, x: Array) -> list[Array]:
        """Of each log, of the samples that are fitted."""
        try:
            responses = self.responses(x)
        except ParameterError:  # no joint at all: a contraction beyond what muscles do
            responses = [log.response + 10.0 * float(np.ptp(log.response)) for log in self.logs]
        return [(response - log.response)[log.fitted & log.counted]
                for response, log in zip(responses, self.logs, strict=True)]  # fmt: skip

    def weigh(self, x: Array, *, rough: bool = False) -> None:
        """Weights from the errors at x; rough: from the ranges, before anything is fitted."""
        for k, (log, missed) in enumerate(zip(self.logs, self.missed(x), strict=True)):
            least = 1e-6 * float(np.ptp(log.response))
            if missed.size:
                rms = 0.05 * float(np.ptp(log.response)) if rough else float(np.sqrt(np.mean(missed**2)))
                self.weight[k] = 1.0 / (max(rms, least, 1e-12) * math.sqrt(1.0 if rough else _correlation(missed)))

    def errors(self, x: Array) -> Array:
        return np.concatenate([w * each for w, each in zip(self.weight, self.missed(x), strict=True)])

    def search(self, x: Array, moving: Mask, *, doubt: bool = False) -> Array:
        """Least squares over some of the numbers, with their doubt about the file's or without."""
        which, first = np.flatnonzero(moving), np.array([each.value for each in self.free])
        if not which.size:
            return x
        low, high = self.bounds[:, which]
        inside = np.clip(x[which], low + 1e-9 * self.scale[which], high - 1e-9 * self.scale[which])

        def errors(v: Array) -> Array:
            new = x.copy()
            new[which] = v
            return np.concatenate([self.errors(new), ((new - first) / self.scale)[which] if doubt else np.empty(0)])

        found = least_squares(errors, inside, bounds=(low, high), x_scale=self.scale[which], max_nfev=30, xtol=1e-7,
                              ftol=1e-7, diff_step=1e-5)  # fmt: skip
        new = x.copy()
        new[which] = found.x
        return new

    def slopes(self, x: Array) -> Array:
        """(m, n) of the weighted errors, by central differences."""
        columns = []
        for i, h in enumerate(1e-4 * self.scale):
            ends = [x.copy(), x.copy()]
            for side, end in zip((-1, 1), ends, strict=True):
                end[i] = np.clip(x[i] + side * h, *self.bounds[:, i])
            columns.append((self.errors(ends[1]) - self.errors(ends[0])) / (ends[1][i] - ends[0][i]))
        return np.stack(columns, axis=1)


def _correlation(missed: Array) -> float:
    """Samples that count as one: 1 + 2 sum of the autocorrelation up to where it ends."""
    power = float(np.mean(missed**2))
    if not power or missed.size < 2 * PARTS:
        return 1.0
    total = 1.0
    for lag in range(1, missed.size // 4):
        like = float(np.mean(missed[lag:] * missed[:-lag])) / power
        if like < 0.05:
            break
        total += 2.0 * like
    return total


def _narrow(x: Array, first: Array) -> Array:
    """95 % intervals of numbers that are told: a share of them, or less of the file's where there is nothing left."""
    return np.asarray(np.maximum(np.maximum(TOLD * np.abs(x), NONE_LEFT * np.abs(first)), 1e-300))


def _variance(slopes: Array, told: Mask, doubt: Array) -> Array:
    """Variances of the numbers that are told, the others at the file's; infinite for those."""
    found = np.full(told.size, np.inf)
    if told.any():
        scale = doubt[told]
        inner = np.linalg.pinv((slopes[:, told] * scale).T @ (slopes[:, told] * scale), rcond=1e-14, hermitian=True)
        through = inner @ (slopes[:, told] * scale).T @ (slopes[:, ~told] * doubt[~told])
        found[told] = (np.diag(inner) + np.sum(through**2, axis=1)) * scale**2
    return found


def _why(free: list[Free], i: int, slopes: Array, spread: Any, size: Array) -> str:
    """Why a number is not told."""
    if float(np.linalg.norm(slopes[:, i])) * free[i].doubt < NOTHING:
        return "no sample depends on it"
    like = np.abs(spread[i]) / np.sqrt(np.diag(spread) * spread[i, i])
    like[i] = 0.0
    alone = 2.0 / float(np.linalg.norm(slopes[:, i]))
    partners = [named(free[j].key, free[j].place) for j in np.argsort(-like)[:2]]
    if alone <= size[i]:
        return f"only together with {' and '.join(partners)}"
    return f"too weak: ±{100 * alone / max(abs(free[i].value), 1e-300):.0f} % of the file's at best"


def _scored(log: RigLog, before: Array, after: Array, bent: Array) -> LogFit:
    """Rms errors on samples that count, fitted and held out."""
    errors = {}
    for part, mask in (("fitted", log.fitted), ("held_out", ~log.fitted)):
        for when, response in (("before", before), ("after", after), ("bent", bent)):
            missed = (response - log.response)[mask & log.counted]
            errors[f"{part}_{when}"] = float(np.sqrt(np.mean(missed**2))) if missed.size else math.nan
    return LogFit(log, before, after, errors)
