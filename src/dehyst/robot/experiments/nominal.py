"""Nominal parameters of the controller before any measurement: data sheets, with deliberate errors."""

from __future__ import annotations

import numpy as np

from dehyst.arrays import Array
from dehyst.control import JointControllerParameters, Pneumatics
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.arm.rigid_body import ALL_JOINTS, arm_model, joint_inertia
from dehyst.robot.experiments.results import Characteristic

# Bench fit of a DMSP-40 (another source than the plant's map): F = (a1 p + a2) exp(a3 k) + a4 k p + a5 p + a6, p in Pa.
BENCH = (0.0002, 369.27, -37.51, -0.0304, 0.0093, -546.02)
BENCH_VOLUME = 1.2566e-3  # of that muscle per length [m^2]; smaller muscles are scaled by their cross section
DEGREE = 5
OBSERVER_RATIO = 8.0  # an observer is this much faster than the loop that it serves
BAR = 1e5


def nominal_characteristic(robot: Robot, number: int) -> Characteristic:
    """Characteristic from a published bench map, some 10 to 20 % beside the plant: good enough to plan sweeps with."""
    joint = robot.joint(number)
    q = np.linspace(-joint.range, joint.range, 81)
    r = joint.lever
    passive = nominal_forces(robot, number, q, np.zeros((q.size, 2)))
    slope = (nominal_forces(robot, number, q, np.full((q.size, 2), BAR)) - passive) / BAR
    a, b, c = (
        np.polynomial.polynomial.polyfit(q, y, DEGREE)
        for y in (r * (slope[:, 0] - slope[:, 1]), r * slope.sum(axis=1) / 2, r * (passive[:, 0] - passive[:, 1]))
    )
    return Characteristic(a, b, c, float(q[0]), float(q[-1]), 0.0)


def nominal_forces(robot: Robot, number: int, angle: Array, pressure: Array) -> Array:
    """Forces (T, 2) of a joint's muscles at angles (T,) and gauge pressures (T, 2) by the same bench map. [N]"""
    joint = robot.joint(number)
    muscle = robot.muscle(joint.drive)
    a1, a2, a3, a4, a5, a6 = BENCH
    turn = joint.lever / muscle.length * angle
    k = joint.middle + np.stack([turn, -turn], axis=1)
    scale = muscle.volume[0] / BENCH_VOLUME
    return np.asarray(scale * ((a1 * pressure + a2) * np.exp(a3 * k) + a4 * k * pressure + a5 * pressure + a6))


def controller_parameters(robot: Robot, number: int, characteristic: Characteristic) -> JointControllerParameters:
    """Parameters of a joint's controller: calibrated characteristic, nominal geometry, inertia, valve and air.

    Parameters
    ----------
    robot
        Its [controller] table says by how much inertia and valve are believed to differ from the truth.
    number
        Of the joint.
    characteristic
        A, B, C of that joint.
    """
    joint, control = robot.joint(number), robot.controller
    muscle, valve = robot.muscle(joint.drive), robot.valve(joint.valve)
    inertia = joint_inertia(arm_model(robot, moving=ALL_JOINTS))[number - 1]
    kappa = np.polynomial.Polynomial([joint.middle, joint.lever / muscle.length])
    mirrored = np.polynomial.Polynomial([joint.middle, -joint.lever / muscle.length])
    volume = np.polynomial.Polynomial(muscle.length * np.asarray(muscle.volume)) + muscle.dead_volume
    air = robot.air
    return JointControllerParameters(
        period=robot.simulation.period,
        inertia=float(inertia * (1 + control.inertia_error)),
        pole=joint.pole or control.pole,
        observer_pole=max(control.observer_pole, OBSERVER_RATIO * (joint.pole or control.pole)),
        pressure_gain=control.pressure_gain,
        windup_gain=control.windup_gain,
        a=tuple(characteristic.a),
        b=tuple(characteristic.b),
        c=tuple(characteristic.c),
        volume=(tuple(volume(kappa).coef), tuple(volume(mirrored).coef)),
        angle_low=characteristic.low,
        angle_high=characteristic.high,
        pressure_low=control.pressure_low,
        pressure_high=control.pressure_high,
        ramp=control.ramp,
        shear=0.0,
        compensator_unit=BAR,
        pneumatics=Pneumatics(
            supply=air.supply,
            ambient=air.ambient,
            gas_temperature=air.gas_constant * air.temperature,
            polytropic=air.polytropic,
            reference_density=air.reference_density,
            conductance=valve.conductance * (1 + control.conductance_error),
            ratio=valve.ratio,
            dead_band=valve.dead_band,
        ),
        angle_jump=control.angle_jump,
        angle_step=2 * np.pi / 2**robot.sensors.encoder_bits,
        pressure_jump=control.pressure_jump,
        frozen_samples=control.frozen_samples,
        hold_samples=control.hold_samples,
    )
