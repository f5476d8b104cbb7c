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
import numpy.typing as npt
from scipy.optimize import least_squares

from dehyst.arrays import Array, Mask
from dehyst.errors import ParameterError, RecordingError
from dehyst_robot._native import PneumaticJoint
from dehyst_robot.arm import (
    ForceMapTable,
    Hysteresis,
    Joint,
    Muscle,
    Robot,
    Valve,
    pneumatic_joint_parameters,
)
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.experiments._policy import POLICY
from dehyst_robot.fields import entries

TABLES: Mapping[str, type] = {
    "map": ForceMapTable, "hysteresis": Hysteresis, "muscle": Muscle, "valve": Valve, "joint": Joint
}  # fmt: skip
MAP = {
    "tool": (0, 1, 2, 3),
    "exponential": tuple(range(6)),
    "geometric": (0, 4, 5, 6, 7),
}  # the others are redundant
ALIKE = {
    f"tolerance.{name}": 0.0
    for name in ("hysteresis", "force", "shape", "contraction", "dead_band", "middle")
}
ALIKE["hysteresis.scatter"] = 0.0
AT_REST = {"hysteresis.mechanism": "none", "hysteresis.creep": 0.0}
TOLD = (
    0.5  # of a number that its 95 % interval may reach to either side, or the log does not tell it
)
OFFSETS = {"zero": "deg", "load": "Nm"}
ALL = -1  # in the place of an index: a factor of a whole list
NONE_LEFT = (
    0.1  # of the file's number: a wider one is told, too, if it shows that there is none of it
)
LONG = 4000  # samples of a log that count at most
SAMPLES = {"angle": 250}  # of logs whose angle is solved for
PARTS, HELD_OUT = 10, (2, 5, 8)  # of a log, and those that are not fitted
KINDS = {
    (True, True): "hold",
    (True, False): "isobaric",
    (False, True): "isometric",
}  # pressure, length still?
STILL = {
    "pressure": 5e3,
    "moved": 0.005,
    "response": 0.02,
}  # [Pa], of its range, of its range: does not move
UNITS = {
    "force": (1.0, "N"),
    "torque": (1.0, "Nm"),
    "angle": (180.0 / math.pi, "deg"),
    "pressure": (1e-5, "bar"),
}


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
        columns = (self.response, self.pressure, self.moved, self.time, self.valve)
        counts = sorted({column.shape[0] for column in columns if column is not None})
        if len(counts) != 1 or counts[0] < PARTS:
            raise RecordingError(
                f"columns of {self.name} have {counts} samples: they must be of one log, of {PARTS} or more."
            )
        if self.time is None and self.quantity in ("angle", "pressure"):
            raise RecordingError(
                f"{self.name} has no time, without which its {self.quantity} tells nothing. Log it."
            )

    @property
    def fitted(self) -> Mask:
        """(T,) samples that the fit sees."""
        # Parts spread over the log: its beginning is not like its end.
        part = np.arange(self.response.size) * PARTS // self.response.size
        return np.logical_not(self.tested | np.isin(part, HELD_OUT))

    @property
    def counted(self) -> Mask:
        """(T,) samples that say something: of forces those at which the muscle pulls."""
        if self.quantity != "force":
            return np.ones(self.response.size, dtype=bool)
        return np.asarray(self.response > POLICY.slack_force * float(self.response.max()))

    @property
    def kinds(self) -> dict[str, float]:
        """Seconds of what bench engineers call it: isobaric, isometric, isotonic, hold, step, filling; or points."""
        if self.time is None:
            return {"points at rest": float(self.response.size)}
        if self.quantity == "pressure":
            return {"filling": float(np.ptp(self.time))}
        seconds: dict[str, float] = {}
        for part in np.array_split(np.arange(self.response.size), min(60, self.response.size // 5)):
            kind = self._kind_of(part)
            seconds[kind] = seconds.get(kind, 0.0) + float(np.ptp(self.time[part]))
        return seconds

    def _kind_of(self, part: npt.NDArray[np.intp]) -> str:
        """What a bench engineer calls some samples of the log."""
        # Of a muscle alone the second pressure means nothing; of a log of angles the response is what moves.
        pressure = self.pressure[:, : 1 + self.of_joint]
        position = self.moved
        if self.quantity == "angle":
            position = self.response
        pressure_range = float(np.ptp(pressure[part], axis=0).max())
        position_range = float(np.ptp(position[part]))
        response_range = float(np.ptp(self.response[part]))
        still = (
            pressure_range <= STILL["pressure"],
            position_range <= STILL["moved"] * max(float(np.ptp(position)), 0.01),
        )
        kind = KINDS.get(still, "both move")
        if kind == "isometric":
            largest_step = np.abs(np.diff(pressure[part], axis=0)).max()
            if largest_step > 0.5 * pressure_range:
                return "step"
        if kind == "both move":
            steady = response_range <= STILL["response"] * float(np.ptp(self.response))
            # A log of angles is one under a constant load.
            if self.quantity == "angle" or steady:
                return "isotonic"
        return kind


def named(key: str, index: int | None) -> str:
    """Return a key with the place in its list, from 1 on; a factor of the whole list is said to be one."""
    if index is None:
        return key
    if index == ALL:
        return f"{key}, factor"
    return f"{key}[{index + 1}]"


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
class FittedNumber:
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
    numbers: tuple[FittedNumber, ...]
    logs: tuple[LogFit, ...]
    offsets: dict[str, float]

    @property
    def changes(self) -> dict[str, Any]:
        """Dotted key -> fitted value, a list where the file has one."""
        return {
            number.key: _at(self.robot.raw, number.key) for number in self.numbers if number.told
        }


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
    >>> from dehyst_robot.arm import load_robot
    >>> true = load_robot(changes={"map.tool.coefficients": [6000, 0.13, 10.5, 2.0, 0.25, 620000]} | ALIKE)
    >>> k, p = np.meshgrid(np.linspace(0, 0.2, 12), np.linspace(1e5, 6e5, 6))
    >>> k, p = k.ravel(), p.ravel()
    >>> log = RigLog("points", "force", np.zeros(72), np.stack([p, p], axis=1), k)
    >>> force = respond(true, 1, log)
    >>> fit = fit_plant(load_robot(), 1, [RigLog("points", "force", force, log.pressure, k)])
    >>> [f"{value:.4g}" for value in fit.changes["map.tool.coefficients"]][:4]
    ['6000', '0.13', '10.5', '2']
    """
    if all(log.tested for log in logs):
        raise ParameterError("every log is kept for the test. Give one or more that may be fitted.")
    start = robot.with_changes(ALIKE)
    logs = [_even(log) for log in logs]
    problem = _PlantFitProblem(start, number, logs, _free(start, number, logs))
    first, doubt = problem.first, problem.doubt
    # Before anything is fitted the errors say nothing of the noise.
    problem.weigh(first, rough=True)
    shown = np.linalg.norm(problem.slopes(first), axis=0) * doubt > POLICY.least_effect
    # Twice, for the weights follow from the errors of the fit.
    x = problem.search(first, shown, doubt=True)
    problem.weigh(x)
    x = problem.search(x, shown, doubt=True)
    offsets = np.array([free.key in OFFSETS for free in problem.free])
    # What interval counts as narrow, number by number.
    size = _narrow(x, first)
    slopes = problem.slopes(x)
    spread = np.linalg.inv(slopes.T @ slopes + np.diag(doubt**-2.0))
    fitted = offsets | shown & (2.0 * np.sqrt(np.diag(spread)) <= size)
    # The number with the widest interval goes back to the file, one after the other, until all are narrow.
    while True:
        begin = first
        if np.any(fitted & ~offsets):
            begin = np.where(fitted, x, first)
        moved = problem.search(begin, fitted)
        problem.weigh(moved)
        slopes = problem.slopes(moved)
        interval = 2.0 * np.sqrt(_variance(slopes, fitted, doubt))
        over = np.where(fitted & ~offsets, interval / _narrow(moved, first), 0.0)
        if over.max(initial=0.0) <= 1.0:
            break
        fitted[int(np.argmax(over))] = False
    numbers = []
    for i, free in enumerate(problem.free):
        if offsets[i]:
            continue
        why = ""
        if not fitted[i]:
            why = _why(problem.free, i, slopes, spread, size)
        value, half_width = float(moved[i]), float(interval[i])
        numbers.append(
            FittedNumber(free.key, free.place, free.value, value, half_width, bool(fitted[i]), why)
        )
    before = problem.responses(problem.search(first, offsets))
    after, bent = problem.responses(moved), problem.responses(x)
    fits = tuple(map(_scored, logs, before, after, bent))
    changes = problem.changes(moved)
    if changes:
        robot = robot.with_changes(changes)
    return PlantFit(robot, tuple(numbers), fits, problem.offsets(moved))


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
    changes: dict[str, Any] = {}
    if not log.of_joint:
        changes[f"joint.{number}.parallel"] = 1
    if log.time is None:
        changes |= AT_REST
        for name in set(robot.joint(number).driven) - {arm_kit.SPRING}:
            changes[f"muscle.{name}.viscous_force_N"] = 0.0
    return changes


def _course(robot: Robot, number: int, log: RigLog, zero: float = 0.0, load: float = 0.0) -> Array:
    """What `respond` returns, of a robot with what the log is `_driven` by."""
    physics = pneumatic_joint_parameters(robot, number, 0)
    radius, length = physics["arm"][0][0], physics["muscle"][0]["length"]
    angle = log.moved
    if not log.of_joint:
        # How a muscle alone is led to a joint does not matter.
        physics["arm"] = [[radius], [-radius]]
        angle = (log.moved - physics["contraction"]) * length / radius
    period = 1.0
    if log.time is not None:
        period = float(log.time[1] - log.time[0])
    if log.quantity == "angle":
        return _balanced(physics, log, period, math.radians(zero), load)
    if log.quantity == "pressure":
        return _filled(physics, log, angle, robot.simulation.period)
    course = arm_kit.run_pressures(physics, angle, log.pressure, period)
    if log.quantity == "torque":
        return course.torque
    return course.force[:, 0]


def _balanced(
    physics: dict[str, Any], log: RigLog, period: float, zero: float, load: float
) -> Array:
    """Angles (T,) at which the muscles carry the load, one after the other: the memory of each goes on from there."""
    joint, p, q = PneumaticJoint(physics, 0), log.pressure, float(log.response[0]) + zero
    # The memory before the log is not known: the muscles begin at rest.
    joint.reset(q, float(p[0, 0]), float(p[0, 1]), 0)
    angles, stiffness = [], 100.0 * physics["arm"][0][0]

    def excess(image: bytes, old: float, new: float, k: int) -> float:
        """Torque beyond the load after a step from the saved state."""
        joint.restore(image)
        speed = (new - old) / period
        return joint.impose(old, speed, float(p[k, 0]), float(p[k, 1]), period) - load

    for k in range(p.shape[0]):
        image, a = joint.save(), q
        f = excess(image, q, a, k)
        # Secant steps; the stiffness of the last sample is a good first slope.
        for _ in range(12):
            step = min(max(f / stiffness, -0.2), 0.2)
            if abs(step) < 1e-6:
                break
            b = min(max(a + step, -3.0), 3.0)
            g = excess(image, q, b, k)
            if b != a and (f - g) / (b - a) > 1e-3:
                stiffness = (f - g) / (b - a)
            a, f = b, g
        # The memory goes on from the angle that was accepted.
        excess(image, q, a, k)
        q = a
        angles.append(q - zero)
    return np.array(angles)


def _filled(physics: dict[str, Any], log: RigLog, angle: Array, period: float) -> Array:
    """Gauge pressure (T,) of the first muscle behind its valve."""
    assert log.time is not None
    assert log.valve is not None
    # Valves need the plant's own step, which is finer than the log's.
    fine = np.arange(log.time[0], log.time[-1] + period, period)
    q = np.interp(fine, log.time, angle)
    # A command stands until the next one.
    latest = np.clip(np.searchsorted(log.time, fine, side="right") - 1, 0, log.time.size - 1)
    command = log.valve[latest]
    commands = np.stack([command, np.zeros(command.size)], axis=1)
    joint = PneumaticJoint(physics, 0)
    joint.reset(float(q[0]), float(log.response[0]), float(log.response[0]), 0)
    signals = joint.run(q, np.gradient(q, period), commands, period)
    pressure = signals["pressure"][:, 0] - physics["air"]["ambient"]
    return np.asarray(np.interp(log.time, fine + period, pressure))


def _even(log: RigLog) -> RigLog:
    """The same log at even intervals, few enough for a fit."""
    if log.time is None:
        return log
    logged = log.time
    # More samples of a slow log say nothing new.
    count = min(logged.size, SAMPLES.get(log.quantity, LONG))
    time = np.linspace(logged[0], logged[-1], count)

    def at(values: Array) -> Array:
        return np.asarray(np.interp(time, logged, values))

    valve = log.valve
    if valve is not None:
        valve = valve[np.searchsorted(logged, time, side="right") - 1]
    return RigLog(
        log.name,
        log.quantity,
        at(log.response),
        np.stack([at(log.pressure[:, 0]), at(log.pressure[:, 1])], axis=1),
        at(log.moved),
        time,
        valve,
        log.of_joint,
        log.tested,
    )


def _at(raw: Mapping[str, Any], key: str) -> Any:
    value: Any = raw
    for part in key.split("."):
        value = value.get(part, 0.0)
    return value


def _keys(robot: Robot, number: int, logs: Sequence[RigLog]) -> list[tuple[str, int | None]]:
    """Keys and places of the numbers that logs of this joint may tell."""
    joint = robot.joint(number)
    name = joint.driven[0]
    muscle = robot.muscle(name)
    keys: list[tuple[str, int | None]] = []
    # The parameters of a force model are `dehyst muscle`'s to fit.
    if muscle.model is None and muscle.map is not None:
        law = robot.maps[muscle.map]
        keys += [(f"map.{muscle.map}.coefficients", i) for i in MAP[law.form]]
        if law.force_of_length is not None and law.form == "tool":
            keys[0] = (f"map.{muscle.map}.force_of_length", 0)
    keys += [
        (f"muscle.{name}.hysteresis_N", None),
        ("hysteresis.pressure_share", None),
        ("hysteresis.asymmetry", None),
        (f"muscle.{name}.viscous_force_N", None),
    ]
    if muscle.creep_time:
        keys += [
            (f"muscle.{name}.creep_force_N", ALL),
            (f"muscle.{name}.creep_pressure_N_bar", ALL),
        ]
    if any(log.of_joint for log in logs):
        keys.append((f"joint.{number}.contraction", None))
        if joint.routing == "pulley":
            keys.append((f"joint.{number}.radius_m", None))
    if any(log.quantity == "pressure" for log in logs):
        keys += [
            (f"valve.{joint.valve}.conductance_l_s_bar", None),
            (f"muscle.{name}.dead_volume_l", None),
        ]
    return keys


def _free_number(robot: Robot, key: str, place: int | None) -> Free | None:
    """The number of the file with its bounds and doubt; None where it stands at a bound, as what is switched off."""
    # A factor of a whole list begins at 1.
    value, low, high = 1.0, 0.0, 100.0
    if place != ALL:
        in_file: Any = _at(robot.raw, key)
        if place is not None:
            in_file = in_file[place]
        value = float(in_file)
        bounds = entries(TABLES[key.split(".")[0]])[key.split(".")[-1]].key
        low, high = bounds.low, bounds.high
    if key.startswith("map."):
        low, high = sorted((0.1 * value, 10.0 * value))
    if low < value < high or value == low < high:
        doubt = POLICY.doubt * (abs(value) or 0.1 * (high - low))
        return Free(key, place, value, low, high, doubt)
    return None


def _free(robot: Robot, number: int, logs: Sequence[RigLog]) -> list[Free]:
    """Numbers that logs of this joint may tell; whether they do is seen from the slopes."""
    numbers = []
    for key, place in _keys(robot, number, logs):
        free = _free_number(robot, key, place)
        if free is not None:
            numbers.append(free)
    # All logs of angles share the joint's zero and its load.
    for log in logs:
        if log.quantity == "angle":
            middle = -math.degrees(float(log.response.max() + log.response.min()) / 2)
            numbers.append(Free("zero", None, middle, -180.0, 180.0, 90.0))
            numbers.append(Free("load", None, 0.0, -1e4, 1e4, 1e3))
            break
    return numbers


class _PlantFitProblem:
    """Errors of all logs over the free numbers, each log with its weight."""

    def __init__(self, robot: Robot, joint: int, logs: Sequence[RigLog], free: list[Free]) -> None:
        self.robot, self.joint, self.logs, self.free = robot, joint, logs, free
        self.driven = [_driven(robot, joint, log) for log in logs]
        self.weight: Array = np.ones(len(logs))
        self.first = np.array([number.value for number in free])
        self.doubt = np.array([number.doubt for number in free])
        self.bounds = np.array([[number.low, number.high] for number in free]).T

    def changes(self, x: Array) -> dict[str, Any]:
        """Keys of the file whose values differ."""
        changes: dict[str, Any] = {}
        for number, value in zip(self.free, x.tolist(), strict=True):
            if number.key in OFFSETS or value == number.value:
                continue
            in_file = _at(self.robot.raw, number.key)
            if number.place is None:
                changes[number.key] = value
            elif number.place == ALL:
                changes[number.key] = [value * old for old in in_file]
            else:
                changes.setdefault(number.key, list(in_file))[number.place] = value
        return changes

    def offsets(self, x: Array) -> dict[str, float]:
        offsets = {}
        for number, value in zip(self.free, x.tolist(), strict=True):
            if number.key in OFFSETS:
                offsets[number.key] = value
        return offsets

    def responses(self, x: Array) -> list[Array]:
        changes, offsets = self.changes(x), self.offsets(x)
        responses = []
        for driven, log in zip(self.driven, self.logs, strict=True):
            # One call with all changes: the checks of a robot take long.
            robot = self.robot.with_changes(changes | driven)
            responses.append(_course(robot, self.joint, log, **offsets))
        return responses

    def missed(self, x: Array) -> list[Array]:
        """Return the error of the fitted samples, an array for each log."""
        try:
            responses = self.responses(x)
        except ParameterError:
            # No joint at all, as with a contraction beyond what muscles do: worse than anything that there is.
            responses = [log.response + 10.0 * float(np.ptp(log.response)) for log in self.logs]
        missed = []
        for response, log in zip(responses, self.logs, strict=True):
            missed.append((response - log.response)[log.fitted & log.counted])
        return missed

    def weigh(self, x: Array, *, rough: bool = False) -> None:
        """Weights from the errors at x; rough: from the ranges, before anything is fitted."""
        for k, (log, missed) in enumerate(zip(self.logs, self.missed(x), strict=True)):
            if not missed.size:
                continue
            span = float(np.ptp(log.response))
            rms, correlation = 0.05 * span, 1.0
            if not rough:
                rms, correlation = float(np.sqrt(np.mean(missed**2))), _correlation(missed)
            self.weight[k] = 1.0 / (max(rms, 1e-6 * span, 1e-12) * math.sqrt(correlation))

    def errors(self, x: Array) -> Array:
        weighted = []
        for weight, missed in zip(self.weight, self.missed(x), strict=True):
            weighted.append(weight * missed)
        return np.concatenate(weighted)

    def search(self, x: Array, moving: Mask, *, doubt: bool = False) -> Array:
        """Least squares over some of the numbers, with their doubt about the file's or without."""
        which = np.flatnonzero(moving)
        if not which.size:
            return x
        low, high = self.bounds[:, which]
        # Numbers of all sizes are searched in units of their doubt.
        scale = self.doubt[which]
        inside = np.clip(x[which], low + 1e-9 * scale, high - 1e-9 * scale)

        def errors(v: Array) -> Array:
            new = x.copy()
            new[which] = v
            if not doubt:
                return self.errors(new)
            return np.concatenate([self.errors(new), ((new - self.first) / self.doubt)[which]])

        solution = least_squares(
            errors,
            inside,
            bounds=(low, high),
            x_scale=scale,
            max_nfev=30,
            xtol=1e-7,
            ftol=1e-7,
            diff_step=1e-5,
        )
        new = x.copy()
        new[which] = solution.x
        return new

    def slopes(self, x: Array) -> Array:
        """(m, n) of the weighted errors, by central differences."""
        columns = []
        for i, h in enumerate(1e-4 * self.doubt):
            below, above = x.copy(), x.copy()
            # At a bound the difference is one-sided.
            below[i] = np.clip(x[i] - h, *self.bounds[:, i])
            above[i] = np.clip(x[i] + h, *self.bounds[:, i])
            columns.append((self.errors(above) - self.errors(below)) / (above[i] - below[i]))
        return np.stack(columns, axis=1)


def _correlation(missed: Array) -> float:
    """Samples that count as one: 1 + 2 sum of the autocorrelation up to where it ends."""
    # Errors that follow each other count as few.
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


def _variance(slopes: Array, fitted: Mask, doubt: Array) -> Array:
    """Variances of the numbers that are fitted, the others at the file's; infinite for those."""
    variances = np.full(fitted.size, np.inf)
    if fitted.any():
        scale = doubt[fitted]
        scaled = slopes[:, fitted] * scale
        inner = np.linalg.pinv(scaled.T @ scaled, rcond=1e-14, hermitian=True)
        # What the doubt about the other numbers adds.
        through = inner @ scaled.T @ (slopes[:, ~fitted] * doubt[~fitted])
        variances[fitted] = (np.diag(inner) + np.sum(through**2, axis=1)) * scale**2
    return variances


def _why(free: list[Free], i: int, slopes: Array, spread: Any, size: Array) -> str:
    """Why a number is not told."""
    if float(np.linalg.norm(slopes[:, i])) * free[i].doubt < POLICY.least_effect:
        return "no sample depends on it"
    # How much the logs see a number and another one as the same.
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
            rms = math.nan
            if missed.size:
                rms = float(np.sqrt(np.mean(missed**2)))
            errors[f"{part}_{when}"] = rms
    return LogFit(log, before, after, errors)
