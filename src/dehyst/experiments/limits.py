"""Does a motion respect pressures and valves? Asked of the nominal model, before anything moves."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.control import JointControllerParameters
from dehyst.experiments.quasistatic import pressure_room
from dehyst.experiments.results import Characteristic
from dehyst.plant.parameters import Robot

SHARE = 0.85  # of pressures and of valve flow that a path may use: the rest is for the controller


def largest_flow(controller: JointControllerParameters, pressure: Array, fills: npt.NDArray[np.bool_]) -> Array:
    """Mass flow of the fully open nominal valve at absolute muscle pressures, ISO 6358. [kg/s]"""
    air = controller.pneumatics
    supply = np.asarray(air.supply)
    upstream = np.where(fills, supply, pressure)
    downstream = np.where(fills, pressure, air.ambient)
    ratio = np.clip(downstream / upstream, air.ratio, 1.0)
    psi = np.sqrt(np.maximum(0.0, 1 - ((ratio - air.ratio) / (1 - air.ratio)) ** 2))
    return np.asarray(air.conductance * air.reference_density * upstream * psi)


def utilisation(
    robot: Robot,
    characteristic: Characteristic,
    controller: JointControllerParameters,
    angle: Array,
    torque: Array,
    spacing: float,
) -> float:
    """Largest share of the allowed pressure difference and valve flow that a joint needs along a motion.

    Parameters
    ----------
    robot
        The arm.
    characteristic, controller
        Of the joint.
    angle, torque
        (K,) of the joint, with the whole inverse dynamics. [rad, Nm]
    spacing
        Of the samples. [s]

    Returns
    -------
    use : float
        1 where `SHARE` of a limit is reached.
    """
    flow = flow_share(robot, characteristic, controller, angle, torque, spacing)
    return max(pressure_share(robot, characteristic, angle, torque), flow) / SHARE


def pressure_share(robot: Robot, characteristic: Characteristic, angle: Array, torque: Array) -> float:
    """Largest |dp| along a motion (K,) [rad, Nm] by the one that the muscles' limits allow."""
    mean = robot.controller.mean_pressure
    difference = characteristic.difference(angle, mean, torque)
    return float(np.abs(difference).max() / pressure_room(robot, mean))


def flow_share(
    robot: Robot,
    characteristic: Characteristic,
    controller: JointControllerParameters,
    angle: Array,
    torque: Array,
    spacing: float,
) -> float:
    """Largest mass flow along a motion (K,) [rad, Nm, s] by that of the open nominal valve at its pressures."""
    mean = robot.controller.mean_pressure
    difference = characteristic.difference(angle, mean, torque)
    air, use = controller.pneumatics, 0.0
    for side, volume in zip((0.5, -0.5), controller.volume, strict=True):
        pressure = mean + side * difference + air.ambient
        chamber = np.polynomial.polynomial.polyval(angle, volume)
        flow = chamber / (air.polytropic * air.gas_temperature) * np.gradient(pressure, spacing)
        flow += pressure / air.gas_temperature * np.gradient(chamber, spacing)
        room = largest_flow(controller, pressure, flow > 0)
        use = max(use, float(np.max(np.abs(flow) / np.maximum(room, 1e-9))))
    return use
