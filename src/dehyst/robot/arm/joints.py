"""One pneumatic joint: its parameters as plant/plant.h names them, and in open loop."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError, SimulationError
from dehyst.robot._native import PneumaticJoint
from dehyst.robot.arm.mechanisms import Mechanism, Parameters, dahl, foreign, maxwell_slip, none, preisach
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.arm.rigid_body import moment_arms
from dehyst.robot.arm.static_map import model_of, static_map
from dehyst.robot.arm.tables import ForceMap, Muscle, Sensors, Valve

FORMS = {"tool": 0, "exponential": 1, "geometric": 2, "spring": 3, "table": 4}  # PLANT_MAP_... of plant/plant.h
# Coefficients that bend the map, and those that the force is proportional to, all together.
SHAPES = {"tool": (1, 2, 3), "exponential": (2,), "geometric": (4, 7), "spring": (), "table": (1,)}
FORCES = {"tool": (0,), "exponential": (0, 1, 3, 4, 5), "geometric": (0, 5, 6), "spring": (), "table": (0,)}
BUILDERS: dict[str, Callable[..., Parameters]] = {"maxwell-slip": maxwell_slip, "preisach": preisach, "dahl": dahl}
WIDEST_DEAD_BAND = 0.9
BEYOND = 1.25  # times its range is where the simulation of a joint ends
WIDEST_DRAW = 2.5  # tolerances end somewhere: no muscle leaves the maker's test bench further off, in rms


def pneumatic_joint_parameters(robot: Robot, number: int, seed: int) -> dict[str, Any]:
    """Return the physics of a joint: two muscles with their tolerances, two valves, air and sensors, in SI.

    Parameters
    ----------
    robot
        From `load_robot`.
    number
        Of the joint.
    seed
        Draws the two muscles' tolerances: same seed and joint, same muscles.

    Returns
    -------
    parameters : dict
        Nested; keys are the fields of ``plant_joint`` in plant/plant.h.

    Examples
    --------
    >>> from dehyst.robot.arm import load_robot
    >>> joint = pneumatic_joint_parameters(load_robot(), 1, seed=0)
    >>> joint["arm"], joint["air"]["supply"], joint["muscle"][0]["map"]
    ([[0.05], [-0.05]], 801300.0, 0)
    """
    joint = robot.joint(number)
    arms = moment_arms(robot, number)
    valve, air = robot.valve(joint.valve), robot.air
    fitted = fitting_scatter(robot, number, seed)
    muscles = [
        _side_by_side(_muscle(robot, muscle, *scatter, each.shape, each.shift), joint.parallel)
        for muscle, scatter, each in zip(
            robot.muscles_of(number), muscle_scatter(robot, number, seed), fitted, strict=True
        )
    ]
    if joint.sprung:  # F = F0 - k s, of its pull at zero and how much it is shorter then
        stiffness = joint.spring * muscles[1]["length"]
        law = [joint.spring_preload + stiffness * joint.middle, stiffness]
        muscles[1] |= {"map": FORMS["spring"], "coefficient": law, "shift": 0.0}
        muscles[1].pop("table", None)
    return {
        "air": {
            "supply": air.supply + air.ambient,
            "ambient": air.ambient,
            "temperature": air.temperature,
            "gas_constant": air.gas_constant,
            "polytropic": air.polytropic,
            "reference_density": air.reference_density,
            "supply_volume": air.supply_volume,
            "supply_conductance": air.supply_conductance,
        },
        "muscle": muscles,
        "valve": [_valve(valve, each) for each in fitted],
        "sensors": _sensors(robot.sensors),
        "arm": [arm.tolist() for arm in arms],
        "contraction": joint.middle,
        "substeps": robot.simulation.substeps,
        "command_delay": robot.simulation.command_delay,
        "command_jitter": robot.simulation.command_jitter,
        "backlash": joint.backlash,
        "backlash_damping": joint.backlash_damping,
    }


class Fitting(NamedTuple):
    """What sets a muscle with its valve apart: factors of its map's shape, shift of its contraction, its valve."""

    shape: tuple[float, ...]
    shift: float
    dead_band: float
    middle: float


def fitting_scatter(robot: Robot, number: int, seed: int) -> list[Fitting]:
    """Return how both muscles of a joint and their valves are off, drawn as in `muscle_scatter` from another stream."""
    draw = np.random.default_rng([int(seed), int(number), 1]).standard_normal((2, 6)).clip(-WIDEST_DRAW, WIDEST_DRAW)
    t = robot.tolerance
    return [
        Fitting(tuple(1.0 + t.shape * d for d in own[:3]), t.contraction * own[3], 1.0 + t.dead_band * own[4],
                t.middle * own[5])
        for own in draw.tolist()
    ]  # fmt: skip


def muscle_scatter(robot: Robot, number: int, seed: int) -> list[tuple[float, float]]:
    """Return for both muscles of a joint the factors of their static force and of their hysteresis.

    Normally distributed with the rms of the [tolerance] table, cut at 2.5 times that; drawn from the seed and the
    joint's number, so that a joint is the same whether it is run alone or with the whole arm.
    """
    draw = np.random.default_rng([int(seed), int(number)]).standard_normal((2, 2)).clip(-WIDEST_DRAW, WIDEST_DRAW)
    rms = np.array([robot.tolerance.force, robot.tolerance.hysteresis])
    return [(float(force), float(friction)) for force, friction in 1.0 + rms * draw]


def map_coefficients(law: ForceMap, length: float, scale: float = 1.0) -> list[float]:
    """Return the coefficients of a static map for a muscle of this length, its force multiplied by `scale`.

    The map of 20 mm muscles has a largest force that grows with the length [2 in arm.toml],
    F_m = p_ref c_1 atan(c_2 p_ref (l_0 - c_3)).

    Examples
    --------
    >>> from dehyst.robot.arm import load_robot
    >>> [round(map_coefficients(load_robot().maps["tool20"], length)[0]) for length in (0.1, 0.25, 1.0)]
    [884, 1207, 1389]
    """
    values = list(law.coefficients)
    if law.force_of_length is not None and law.form == "tool":
        c1, c2, c3 = law.force_of_length
        p_ref = values[5]
        values[0] = p_ref * c1 * math.atan(c2 * p_ref * max(length - c3, 0.0))
    for index in FORCES[law.form]:
        values[index] *= scale
    return values


def _muscle(
    robot: Robot, muscle: Muscle, force: float, friction: float, shape: Sequence[float], shift: float
) -> dict[str, Any]:
    creep = robot.hysteresis.creep
    branches = len(muscle.creep_time) if creep > 0 else 0
    form, coefficients, table = _static(robot, muscle, force)
    for index, factor in zip(SHAPES[form], shape, strict=False):
        coefficients[index] *= factor
    return {
        "map": FORMS[form],
        "coefficient": coefficients,
        **table,
        "length": muscle.length,
        "volume": list(muscle.volume),
        "dead_volume": muscle.dead_volume,
        "viscous_force": muscle.viscous_force,
        "viscous_speed": muscle.viscous_speed,
        "creep_branches": branches,
        "creep_time": list(muscle.creep_time[:branches]),
        "creep_force": [creep * c for c in muscle.creep_force[:branches]],
        "creep_pressure": [creep * d for d in muscle.creep_pressure[:branches]],
        "hysteresis": _hysteresis(robot, muscle.hysteresis * friction),
        "shift": shift,
        **{name: getattr(muscle, name) for name in ("tendon", "tendon_time", "warming", "warming_time",
                                                    "warm_stiffness")},
    }  # fmt: skip


def _static(robot: Robot, muscle: Muscle, force: float) -> tuple[str, list[float], dict[str, Any]]:
    """Form and coefficients of a muscle's static map, and its table if a model gives it."""
    if muscle.model is None:
        assert muscle.map is not None  # checked with the file
        law = robot.maps[muscle.map]
        return law.form, map_coefficients(law, muscle.length, force), {}
    found = static_map(model_of(muscle), robot.air.supply)
    grid = [float(each) for axis in (found.pressure, found.contraction) for each in (axis[0], axis[1] - axis[0])]
    return "table", [force, 1.0, *grid], {"table": found.force}


# What as many times as large is, of muscles side by side; the loss that warms each is its share.
OF_EACH = ("volume", "dead_volume", "viscous_force", "creep_force", "creep_pressure", "tendon")


def _side_by_side(muscle: dict[str, Any], count: int) -> dict[str, Any]:
    """Return `count` equal muscles as one: contraction and pressure the same, forces and volumes that much larger."""
    if count == 1:
        return muscle
    form = next(name for name, number in FORMS.items() if number == muscle["map"])
    found = {**muscle, "coefficient": list(muscle["coefficient"]), "hysteresis": dict(muscle["hysteresis"])}
    for index in FORCES[form]:
        found["coefficient"][index] *= count
    for key in OF_EACH:
        found[key] = [count * each for each in muscle[key]] if isinstance(muscle[key], list) else count * muscle[key]
    found["hysteresis"]["size"] *= count
    return {**found, "warming": muscle["warming"] / count}


def _hysteresis(robot: Robot, size: float) -> dict[str, Any]:
    chosen = robot.hysteresis
    if chosen.mechanism == "none" or chosen.scale == 0 or size == 0:
        return none()
    built = BUILDERS[chosen.mechanism](
        chosen.scale * size,
        pressure_share=chosen.pressure_share,
        reference_pressure=chosen.reference,
        asymmetry=chosen.asymmetry,
    )
    return {**built, "pressure_strain": chosen.pressure_strain, "scatter": chosen.scatter, "warm": chosen.warm}


def _valve(valve: Valve, fitted: Fitting) -> dict[str, float]:
    told = asdict(valve)
    bits = told.pop("bits")
    told["dead_band"] = min(max(valve.dead_band * fitted.dead_band, 0.0), WIDEST_DEAD_BAND)
    return {**told, "step": 2.0 ** (1 - bits) if bits else 0.0, "middle": fitted.middle}


def _sensors(sensors: Sensors) -> dict[str, float]:
    told = asdict(sensors)
    return {"angle_step": 2.0 * math.pi / 2 ** told.pop("encoder_bits"), **told}


def built_plant(robot: Robot, number: int, seed: int, own: Sequence[Mechanism] = ()) -> PneumaticJoint:
    """Return the muscles, valves and sensors of a joint, with mechanisms of one's own or none."""
    if len(own) not in (0, 2):
        raise ParameterError(
            f"{len(own)} mechanisms for the two muscles of joint {number}: give two, each with a memory of its own.",
            joint=number,
            mechanisms=len(own),
        )
    parameters = pneumatic_joint_parameters(robot, number, seed)
    sides = range(len(own) - robot.joint(number).sprung) if own else ()  # a spring has no hysteresis
    for side in sides:
        parameters["muscle"][side]["hysteresis"] = foreign()
    plant = PneumaticJoint(parameters, noise_seed(seed, number))
    for side in sides:
        try:
            plant.attach(side, own[side])
        except TypeError as fault:
            raise ParameterError(f"muscle {side + 1} of joint {number}: {fault}.", joint=number) from None
    return plant


def noise_seed(seed: int, number: int) -> int:
    """Return the seed of a joint's sensor noise."""
    return seed * 8 + number if number < 8 else (1 << 40) + seed * 8 + number  # no joint has the noise of another


@dataclass(frozen=True, eq=False)
class Course:
    """What a joint did. The second axis of (T, 2) arrays is the muscle; positive angles shorten the first one.

    Attributes
    ----------
    time
        (T,), [s]
    angle
        (T,), as it was moved. [rad]
    torque
        (T,), on the joint. [Nm]
    pressure
        (T, 2), gauge. [Pa]
    contraction
        (T, 2), of the length at rest.
    force
        (T, 2), pull of the muscles, never negative. [N]
    friction
        (T, 2), hysteresis force that opposes contraction. [N]
    """

    time: Array
    angle: Array
    torque: Array
    pressure: Array
    contraction: Array
    force: Array
    friction: Array


def run_pressures(
    parameters: dict[str, Any],
    angle: npt.ArrayLike,
    pressure: npt.ArrayLike,
    period: float,
    *,
    mechanisms: Sequence[Mechanism] = (),
) -> Course:
    """Run a joint with ideal pressures in its muscles, in place of valves and chambers.

    Parameters
    ----------
    parameters
        Physics of the joint, see `dehyst.robot.arm.joints.pneumatic_joint_parameters`.
    angle
        (T,) angles, one a period, linear in between. [rad]
    pressure
        (T, 2) gauge pressures; those of the first sample are where nothing is remembered. [Pa]
    period
        Time from sample to sample, 0.5 ms on the robot. [s]
    mechanisms
        Two hysteresis mechanisms of one's own (`dehyst.robot.arm.mechanisms.Mechanism`); none: those of the parameters.

    Returns
    -------
    Course
        T samples, the first one the start.

    Raises
    ------
    ParameterError
        If lengths differ, or the physics are not complete.

    Examples
    --------
    A loop of the angle at 3 bar: the torque at its end is not the one at its start.

    >>> from dehyst.robot.arm import load_robot
    >>> from dehyst.robot.arm.joints import pneumatic_joint_parameters
    >>> physics = pneumatic_joint_parameters(load_robot(), 1, seed=0)
    >>> angle = 0.3 * np.sin(np.linspace(0.0, 2.0 * np.pi, 2001))
    >>> course = run_pressures(physics, angle, np.full((2001, 2), 3e5), period=0.01)
    >>> bool(4.0 < abs(course.torque[1000] - course.torque[2000]) < 24.0)
    True
    """
    q, p = _checked(angle, pressure, period)
    joint = _joint(parameters, mechanisms)
    joint.reset(float(q[0]), float(p[0, 0]), float(p[0, 1]), 0)
    first, torque = joint.state, joint.torque
    signals = joint.run_imposed(q[:-1], np.diff(q) / period, p[1:], period)
    both = {name: np.vstack([first[name], signals[name]]) for name in ("pressure", "contraction", "force", "friction")}
    both["pressure"] = both["pressure"] - float(parameters["air"]["ambient"])
    time: Array = np.arange(q.size, dtype=np.float64) * period
    return Course(time=time, angle=q, torque=np.append(torque, signals["torque"]), **both)


def _checked(angle: npt.ArrayLike, commands: npt.ArrayLike, period: float) -> tuple[Array, Array]:
    q, u = np.ascontiguousarray(angle, dtype=np.float64), np.ascontiguousarray(commands, dtype=np.float64)
    if q.ndim != 1 or q.size == 0 or u.shape != (q.size, 2):
        raise ParameterError(
            f"angles of shape {q.shape} and commands of shape {u.shape}: a joint takes (T,) and (T, 2), "
            "one row of commands an angle",
            angle=q.shape,
            commands=u.shape,
        )
    if not 0 < period < 10 or not np.all(np.isfinite(q)):
        raise ParameterError(
            f"period = {period} s, angles from {q.min()} to {q.max()} rad: a period lies between 0 and 10 s, "
            "0.0005 s on the robot; angles are finite, or the joint would stand still where they are not",
            period=period,
        )
    return q, u


def _joint(parameters: dict[str, Any], mechanisms: Sequence[Mechanism]) -> PneumaticJoint:
    if len(mechanisms) not in (0, 2):
        raise ParameterError(
            f"{len(mechanisms)} mechanisms for two muscles: give two, each with a memory of its own, or none",
            mechanisms=len(mechanisms),
        )
    try:
        joint = PneumaticJoint(parameters, 0)
    except ValueError as fault:
        raise ParameterError(
            f"the physics of the joint are not usable: {fault}. See dehyst.robot.arm.joints.pneumatic_joint_parameters"
        ) from None
    for muscle, mechanism in enumerate(mechanisms):
        joint.attach(muscle, mechanism)
    return joint


def refuse_beyond(robot: Robot, moving: Sequence[int], angles: Array) -> None:
    """Where a muscle is stretched or slack beyond measure, its map is no muscle; end stops are not simulated."""
    allowed = BEYOND * np.array([robot.joint(number).range for number in moving])
    reached = np.abs(angles).max(axis=0)
    worst = int(np.argmax(np.nan_to_num(reached / allowed, nan=np.inf)))
    if reached[worst] <= allowed[worst]:
        return
    number = moving[worst]
    preload = f" or joint.{number}.spring_preload_N" if robot.joint(number).sprung else ""
    side = angles[np.abs(angles[:, worst]).argmax(), worst]
    raise SimulationError(
        f"joint {number} went to {np.degrees(side):.0f} deg, its range ends at "
        f"{math.copysign(np.degrees(robot.joint(number).range), side):.0f} deg: what is simulated there is no arm any "
        f"more. Its loop or its motion is too fast, or something stronger than its muscles pulls: make "
        f"joint.{number}.pole_1_s (without it controller.pole_1_s), the speed{preload} smaller, or change back what "
        f"was changed last.",
        joint=number,
        angle=float(reached[worst]),
    )
