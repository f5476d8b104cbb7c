"""One pneumatic joint of the plant: its physics from the parameter file, and runs in open loop.

Names of the parameters are those of packages/dehyst-robot/plant/plant.h.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError, SimulationError
from dehyst_robot._native import PneumaticJoint
from dehyst_robot.arm._mechanisms import BUILDERS, Mechanism, foreign, none
from dehyst_robot.arm._parameters import Robot
from dehyst_robot.arm._policy import POLICY
from dehyst_robot.arm._rigid_body import moment_arms
from dehyst_robot.arm._static_map import static_map, static_map_model
from dehyst_robot.arm._tables import ForceMapTable, Muscle, Sensors, Valve

# PLANT_MAP_... of packages/dehyst-robot/plant/plant.h
FORMS = {"tool": 0, "exponential": 1, "geometric": 2, "spring": 3, "table": 4}
# Indices of the coefficients that change the shape of a map, and of those that scale its force all together.
SHAPES = {"tool": (1, 2, 3), "exponential": (2,), "geometric": (4, 7), "spring": (), "table": (1,)}
FORCES = {
    "tool": (0,),
    "exponential": (0, 1, 3, 4, 5),
    "geometric": (0, 5, 6),
    "spring": (),
    "table": (0,),
}
WIDEST_DEAD_BAND = 0.9  # of the command: a tenth is left that opens the valve
WIDEST_DRAW = 2.5  # rms: a muscle that is further off does not pass the maker's final test


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
        Nested; keys are the fields of ``plant_joint`` in packages/dehyst-robot/plant/plant.h.

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> joint = pneumatic_joint_parameters(load_robot(), 1, seed=0)
    >>> joint["arm"], joint["air"]["supply"], joint["muscle"][0]["map"]
    ([[0.05], [-0.05]], 801300.0, 0)
    """
    joint = robot.joint(number)
    arms = moment_arms(robot, number)
    # Two muscles of one type are not equal, nor are their valves: both are drawn from the seed.
    valve, air = robot.valve(joint.valve), robot.air
    fittings = fitting_scatter(robot, number, seed)
    scatters = muscle_scatter(robot, number, seed)
    muscles = []
    for side, muscle in enumerate(robot.muscles_of(number)):
        fitting = fittings[side]
        values = _muscle(robot, muscle, *scatters[side], fitting.shape, fitting.shift)
        muscles.append(_side_by_side(values, joint.parallel))
    if joint.sprung:
        # F = F0 - k s, from the preload at zero and the contraction s L there.
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
        "valve": [_valve(valve, fitting) for fitting in fittings],
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
    """Deviations of a muscle with its valve from their types: factors of the map's shape, shift of the contraction."""

    shape: tuple[float, ...]
    shift: float
    dead_band: float
    middle: float


def fitting_scatter(robot: Robot, number: int, seed: int) -> list[Fitting]:
    """Return how both muscles of a joint and their valves differ from their types.

    Drawn as in `muscle_scatter`, from another stream.
    """
    draw = _drawn([int(seed), int(number), 1], (2, 6))
    tolerance = robot.tolerance
    fittings = []
    for side in draw.tolist():
        fitting = Fitting(
            shape=tuple(1.0 + tolerance.shape * deviation for deviation in side[:3]),
            shift=tolerance.contraction * side[3],
            dead_band=1.0 + tolerance.dead_band * side[4],
            middle=tolerance.middle * side[5],
        )
        fittings.append(fitting)
    return fittings


def _drawn(stream: list[int], shape: tuple[int, int]) -> Array:
    """Return normally distributed numbers, limited as tolerances are."""
    draw = np.random.default_rng(stream).standard_normal(shape)
    return np.asarray(draw.clip(-WIDEST_DRAW, WIDEST_DRAW))


def muscle_scatter(robot: Robot, number: int, seed: int) -> list[tuple[float, float]]:
    """Return for both muscles of a joint the factors of their static force and of their hysteresis.

    Normally distributed with the rms of the [tolerance] table, cut at 2.5 times that; drawn from the seed and the
    joint's number, so that a joint is the same whether it is run alone or with the whole arm.
    """
    draw = _drawn([int(seed), int(number)], (2, 2))
    rms = np.array([robot.tolerance.force, robot.tolerance.hysteresis])
    return [(float(force), float(friction)) for force, friction in 1.0 + rms * draw]


def map_coefficients(law: ForceMapTable, length: float, scale: float = 1.0) -> list[float]:
    """Return the coefficients of a static map for a muscle of this length, its force multiplied by `scale`.

    The map of 20 mm muscles has a largest force that grows with the length [2 in arm.toml],
    F_m = p_ref c_1 atan(c_2 p_ref (l_0 - c_3)).

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> [round(map_coefficients(load_robot().maps["tool20"], length)[0]) for length in (0.1, 0.25, 1.0)]
    [884, 1207, 1389]
    """
    values = list(law.coefficients)
    # The length replaces the largest force that the coefficients of the file were measured with.
    if law.force_of_length is not None and law.form == "tool":
        c1, c2, c3 = law.force_of_length
        p_ref = values[5]
        values[0] = p_ref * c1 * math.atan(c2 * p_ref * max(length - c3, 0.0))
    for index in FORCES[law.form]:
        values[index] *= scale
    return values


def _muscle(
    robot: Robot,
    muscle: Muscle,
    force: float,
    friction: float,
    shape: Sequence[float],
    shift: float,
) -> dict[str, Any]:
    creep = robot.hysteresis.creep
    branches = 0
    if creep > 0:
        branches = len(muscle.creep_time)
    form, coefficients, table = _static(robot, muscle, force)
    # A form may have fewer coefficients of shape than factors are drawn.
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
        "creep_force": (creep * np.array(muscle.creep_force[:branches])).tolist(),
        "creep_pressure": (creep * np.array(muscle.creep_pressure[:branches])).tolist(),
        "hysteresis": _hysteresis(robot, muscle.hysteresis * friction),
        "shift": shift,
        "tendon": muscle.tendon,
        "tendon_time": muscle.tendon_time,
        "warming": muscle.warming,
        "warming_time": muscle.warming_time,
        "warm_stiffness": muscle.warm_stiffness,
    }


def _static(robot: Robot, muscle: Muscle, force: float) -> tuple[str, list[float], dict[str, Any]]:
    """Return form and coefficients of a muscle's static map, and its table if a model computes the force."""
    if muscle.model is None:
        assert muscle.map is not None  # checked with the file
        law = robot.maps[muscle.map]
        return law.form, map_coefficients(law, muscle.length, force), {}
    table = static_map(static_map_model(muscle), robot.air.supply)
    # The plant needs the first point and the step of an even grid.
    grid: list[float] = []
    for axis in (table.pressure, table.contraction):
        grid += [float(axis[0]), float(axis[1] - axis[0])]
    return "table", [force, 1.0, *grid], {"table": table.force}


# Parameters that add up when muscles lie side by side. Each muscle gets its share of the loss that warms them.
ADDED_UP = ("volume", "dead_volume", "viscous_force", "creep_force", "creep_pressure", "tendon")


def _side_by_side(muscle: dict[str, Any], count: int) -> dict[str, Any]:
    """Return `count` equal muscles as one: contraction and pressure the same, forces and volumes that much larger."""
    if count == 1:
        return muscle
    names_of_forms = {code: name for name, code in FORMS.items()}
    coefficients = list(muscle["coefficient"])
    for index in FORCES[names_of_forms[muscle["map"]]]:
        coefficients[index] *= count
    combined = {**muscle, "coefficient": coefficients}
    for key in ADDED_UP:
        value = muscle[key]
        if isinstance(value, list):
            combined[key] = [count * item for item in value]
        else:
            combined[key] = count * value
    combined["hysteresis"] = dict(muscle["hysteresis"])
    combined["hysteresis"]["size"] *= count
    combined["warming"] = muscle["warming"] / count
    return combined


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
    return {
        **built,
        "pressure_strain": chosen.pressure_strain,
        "scatter": chosen.scatter,
        "warm": chosen.warm,
    }


def _valve(valve: Valve, fitting: Fitting) -> dict[str, float]:
    values = asdict(valve)
    bits = values.pop("bits")
    values["dead_band"] = min(max(valve.dead_band * fitting.dead_band, 0.0), WIDEST_DEAD_BAND)
    values["step"] = 0.0  # of its command; 0: not rounded
    if bits:
        values["step"] = 2.0 ** (1 - bits)
    values["middle"] = fitting.middle
    return values


def _sensors(sensors: Sensors) -> dict[str, float]:
    values = asdict(sensors)
    return {"angle_step": 2.0 * math.pi / 2 ** values.pop("encoder_bits"), **values}


def built_plant(
    robot: Robot, number: int, seed: int, mechanisms: Sequence[Mechanism] = ()
) -> PneumaticJoint:
    """Return the muscles, valves and sensors of a joint, with two user-defined mechanisms or none."""
    if len(mechanisms) not in (0, 2):
        raise ParameterError(
            f"{len(mechanisms)} mechanisms for the two muscles of joint {number}: give two, each with a memory of its "
            f"own.",
            joint=number,
            mechanisms=len(mechanisms),
        )
    parameters = pneumatic_joint_parameters(robot, number, seed)
    if mechanisms and robot.joint(number).sprung:
        mechanisms = mechanisms[:1]  # a spring has no hysteresis
    for side in range(len(mechanisms)):
        parameters["muscle"][side]["hysteresis"] = foreign()
    plant = PneumaticJoint(parameters, noise_seed(seed, number))
    for side, mechanism in enumerate(mechanisms):
        try:
            plant.attach(side, mechanism)
        except TypeError as fault:
            raise ParameterError(
                f"muscle {side + 1} of joint {number}: {fault}.", joint=number
            ) from None
    return plant


def noise_seed(seed: int, number: int) -> int:
    """Return the seed of a joint's sensor noise: no two joints of any two seeds have the same noise."""
    # Joints 1 to 7 use eight numbers a seed; those from 8 on use numbers beyond all of these.
    first = 0
    if number >= 8:
        first = 1 << 40
    return first + seed * 8 + number


@dataclass(frozen=True, eq=False)
class Course:
    """Motion of a joint in open loop. The second axis of (T, 2) arrays is the muscle; q > 0 shortens the first one.

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
        Physics of the joint, see `dehyst_robot.arm._joints.pneumatic_joint_parameters`.
    angle
        (T,) angles, one a period, linear in between. [rad]
    pressure
        (T, 2) gauge pressures; those of the first sample are where nothing is remembered. [Pa]
    period
        Time from sample to sample, 0.5 ms on the robot. [s]
    mechanisms
        Two user-defined hysteresis mechanisms (`dehyst_robot.Mechanism`); none: those of the parameters.

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

    >>> from dehyst_robot.arm import load_robot
    >>> from dehyst_robot.arm import pneumatic_joint_parameters
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
    # The start is the first sample; the signals begin one period later.
    of_muscles = {}
    for name in ("pressure", "contraction", "force", "friction"):
        of_muscles[name] = np.vstack([first[name], signals[name]])
    of_muscles["pressure"] = of_muscles["pressure"] - float(parameters["air"]["ambient"])
    time: Array = np.arange(q.size, dtype=np.float64) * period
    torque_of_course = np.append(torque, signals["torque"])
    return Course(time=time, angle=q, torque=torque_of_course, **of_muscles)


def _checked(angle: npt.ArrayLike, commands: npt.ArrayLike, period: float) -> tuple[Array, Array]:
    q = np.ascontiguousarray(angle, dtype=np.float64)
    u = np.ascontiguousarray(commands, dtype=np.float64)
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
            f"the physics of the joint are not usable: {fault}. See dehyst_robot.arm._joints.pneumatic_joint_parameters"
        ) from None
    for muscle, mechanism in enumerate(mechanisms):
        joint.attach(muscle, mechanism)
    return joint


def refuse_beyond(robot: Robot, moving: Sequence[int], angles: Array) -> None:
    """Refuse angles far beyond a range: there the map of a muscle is wrong, and end stops are not simulated."""
    allowed = POLICY.beyond * np.array([robot.joint(number).range for number in moving])
    reached = np.abs(angles).max(axis=0)
    worst = int(np.argmax(np.nan_to_num(reached / allowed, nan=np.inf)))
    if reached[worst] <= allowed[worst]:
        return
    number = moving[worst]
    preload = ""
    if robot.joint(number).sprung:
        preload = f" or joint.{number}.spring_preload_N"
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
