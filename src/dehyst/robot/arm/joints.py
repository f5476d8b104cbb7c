"""Parameters of one pneumatic joint, as plant/plant.h names them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from dehyst.errors import ParameterError
from dehyst.robot.arm import mechanisms
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.arm.tables import ForceMap, Muscle, Sensors, Valve

FORMS = {"tool": 0, "exponential": 1, "geometric": 2}  # PLANT_MAP_... of plant/plant.h
# Coefficients that the force is proportional to, all together.
FORCES = {"tool": (0,), "exponential": (0, 1, 3, 4, 5), "geometric": (0, 5, 6)}
BUILDERS: dict[str, Callable[..., mechanisms.Parameters]] = {
    "maxwell-slip": mechanisms.maxwell_slip,
    "preisach": mechanisms.preisach,
    "dahl": mechanisms.dahl,
}
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
    >>> joint["radius"], joint["air"]["supply"], joint["muscle"][0]["map"]
    (0.05, 801300.0, 0)
    """
    joint = robot.joint(number)
    if joint.radius is None or joint.contraction is None or not joint.pneumatic:
        raise ParameterError(
            f"joint {number} is electric: it has no muscles. Joints with muscles: {robot.pneumatic}.", joint=number
        )
    muscle = robot.muscle(joint.drive)
    valve = _valve(robot.valve(joint.valve))
    air = robot.air
    return {
        "air": {
            "supply": air.supply + air.ambient,
            "ambient": air.ambient,
            "temperature": air.temperature,
            "gas_constant": air.gas_constant,
            "polytropic": air.polytropic,
            "reference_density": air.reference_density,
        },
        "muscle": [_muscle(robot, muscle, *scatter) for scatter in muscle_scatter(robot, number, seed)],
        "valve": [valve, dict(valve)],
        "sensors": _sensors(robot.sensors),
        "radius": joint.radius,
        "contraction": joint.contraction,
        "substeps": robot.simulation.substeps,
    }


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


def _muscle(robot: Robot, muscle: Muscle, force: float, friction: float) -> dict[str, Any]:
    law, creep = robot.maps[muscle.map], robot.hysteresis.creep
    branches = len(muscle.creep_time) if creep > 0 else 0
    return {
        "map": FORMS[law.form],
        "coefficient": map_coefficients(law, muscle.length, force),
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
    }


def _hysteresis(robot: Robot, size: float) -> dict[str, Any]:
    chosen = robot.hysteresis
    if chosen.mechanism == "none" or chosen.scale == 0 or size == 0:
        return mechanisms.none()
    return BUILDERS[chosen.mechanism](
        chosen.scale * size,
        pressure_share=chosen.pressure_share,
        reference_pressure=chosen.reference,
        asymmetry=chosen.asymmetry,
    )


def _valve(valve: Valve) -> dict[str, float]:
    return {
        "conductance": valve.conductance,
        "ratio": valve.ratio,
        "dead_band": valve.dead_band,
        "leak": valve.leak,
        "frequency": valve.frequency,
        "damping": valve.damping,
    }


def _sensors(sensors: Sensors) -> dict[str, float]:
    return {
        "angle_step": 2.0 * math.pi / 2**sensors.encoder_bits,
        "pressure_noise": sensors.pressure_noise,
        "pressure_lag": sensors.pressure_lag,
    }
