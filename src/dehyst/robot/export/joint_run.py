"""Test run of an exported joint controller: a joint that follows a motion, with switching and faulty sensors."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np

from dehyst.arrays import Array
from dehyst.export.precision import rounded
from dehyst.export.signal import Signal
from dehyst.models import DirectInverse, HysteresisModel
from dehyst.robot.control.joint import GIVEN, SWITCHES, JointController, JointReference, in_si
from dehyst.robot.control.parameters import Adaptation, JointControllerParameters

SENSORS = ("angle", "pressure_1", "pressure_2")
REFERENCE = (
    "angle_d", "velocity_d", "acceleration_d", "load_d", "mean_pressure_d", "pressure_difference_d", "extra_d",
)  # fmt: skip
OUTPUTS = (
    "valve_1", "valve_2", "desired_1", "desired_2", "pressure_difference_out", "torque", "integrator", "compensation",
    "angle_observed", "velocity_observed", "load_observed", "contact", "doubt",
)  # fmt: skip
ANSWERS = (  # fields of the controller's output that these are
    "valve_1", "valve_2", "desired_1", "desired_2", "pressure_difference", "torque", "integrator", "compensation",
    "angle", "velocity", "load", "contact", "doubt",
)  # fmt: skip
SAMPLES = 1600
START = 0.1  # [rad]
PUSH = 15.0  # torque from outside, [Nm]
WORN = 1.2  # what the joint has become of what was identified: there is something to learn


def joint_run(
    parameters: JointControllerParameters,
    compensator: HysteresisModel | DirectInverse | None,
    real: str,
    adaptation: Adaptation | None = None,
) -> Signal:
    """Record a joint that follows a motion, with switching, faulty sensors, and one that fails at the end.

    The joint is a point mass at the controller's own characteristic, its pressures follow what is desired: plain, but
    the controller is in a loop. What is recorded is replayed, in the same order, into whatever is exported.
    """
    controller = JointController(parameters, compensator, adaptation)
    learns = compensator is not None and compensator.core == "direct"
    direct = in_si(cast(DirectInverse, compensator)) if learns else None
    friction = None if direct is None else _Friction(direct, parameters)
    rows: list[Array] = []
    switch: list[int] = []
    answers: list[list[float]] = []
    flags: list[int] = []
    plant = _Joint(parameters, 0.0 if direct else 20.0)
    rng = np.random.default_rng(20260722)
    for k in range(SAMPLES):
        reference = _reference(parameters, k)
        on = _switches(k)
        if direct is not None:
            reference = _taught(reference, direct, adaptation or Adaptation(), parameters, k)
            on |= _learns(k)
            on &= ~SWITCHES["position"] if 350 <= k < 420 else on
        readings = np.array([plant.sensed_angle(), *(plant.pressure + 30.0 * rng.standard_normal(2))])
        readings = _faulty(readings, k, parameters)
        row = np.array([rounded(x, real) for x in (*readings, *_lost(reference, k).as_tuple())])
        if k == 0:
            controller.reset(*row[:3])
        out = controller.step(row[0], row[1], row[2], JointReference(*row[3:]), on)
        rows.append(row)
        switch.append(on)
        answers.append([getattr(out, name) for name in ANSWERS])
        flags.append(out.flags)
        plant.step(np.array([out.desired_1, out.desired_2]))
        if friction is not None:
            plant.load = friction.torque(plant, reference) - (PUSH if 900 <= k < 1100 else 0.0)
    return Signal(np.array(rows), np.array(switch), np.array(answers), np.array(flags), (*SENSORS, *REFERENCE), OUTPUTS)


class _Friction:
    """What a joint needs that is a bit more than its direct inverse says."""

    def __init__(self, model: DirectInverse, parameters: JointControllerParameters) -> None:
        self._step = model.core_stepper(parameters.period)
        self._given = [schedule.name for schedule in model.outside]

    def torque(self, plant: _Joint, reference: JointReference) -> float:
        """Return it with the known load, for the present angle. [Nm]"""
        given = [float(getattr(reference, name)) for name in self._given]
        return float(WORN * self._step(plant.angle, plant.velocity, *given) + reference.load)


class _Joint:
    """A mass at the nominal characteristic whose pressures follow with a short lag."""

    def __init__(self, parameters: JointControllerParameters, damping: float) -> None:
        self.p, self.damping = parameters, damping
        self.angle, self.velocity, self.load = START, 0.0, 0.0
        self.pressure = np.full(2, 0.4 * (parameters.pressure_low + parameters.pressure_high))

    def sensed_angle(self) -> float:
        step = self.p.angle_step
        return round(self.angle / step) * step if step > 0 else self.angle

    def step(self, desired: Array) -> None:
        p = self.p
        q = min(max(self.angle, p.angle_low), p.angle_high)
        a, b, c = (sum(x * q**j for j, x in enumerate(poly)) for poly in (p.a, p.b, p.c))
        torque = a * self.pressure.mean() + b * (self.pressure[0] - self.pressure[1]) + c - self.load
        self.velocity += p.period * (torque / p.inertia - self.damping * self.velocity)
        self.angle = min(max(self.angle + p.period * self.velocity, 2 * p.angle_low), 2 * p.angle_high)
        self.pressure += min(1.0, p.period * 100.0) * (desired - self.pressure)


def _reference(p: JointControllerParameters, k: int) -> JointReference:
    size = 0.4 * (p.angle_high - p.angle_low)
    middle = 0.5 * (p.angle_high + p.angle_low)
    w, t = 8.0, k * p.period
    shrink = 1.0 / (1.0 + t)
    mean = 0.5 * (p.pressure_low + p.pressure_high)
    return JointReference(
        angle=middle + size * shrink * np.sin(w * t),
        velocity=size * shrink * w * np.cos(w * t),
        acceleration=-size * shrink * w * w * np.sin(w * t),
        load=2.0 * np.sin(3.0 * t),
        mean_pressure=mean,
        pressure_difference=0.1 * mean * np.sin(5.0 * t),
        extra=0.01 * mean * np.cos(7.0 * t),
    )


def _taught(
    reference: JointReference, model: DirectInverse, adaptation: Adaptation, p: JointControllerParameters, k: int
) -> JointReference:
    """Sweep what schedules the model; move slowly but for a while, so that it learns, then through all the range."""
    t = k * p.period
    given = {name: getattr(reference, name) for name in GIVEN}
    for schedule, speed in zip(model.outside, (9.0, 13.0), strict=False):
        half = 0.55 * (schedule.high - schedule.low)  # beyond its ends too
        given[schedule.name] = 0.5 * (schedule.low + schedule.high) + half * np.sin(speed * t)
    size = (0.03 if k < 1100 else 0.4) * (p.angle_high - p.angle_low)
    phase = (k % 800) / 800
    return replace(
        reference,
        angle=(START if k < 1100 else 0.5 * (p.angle_high + p.angle_low)) + size * (4 * abs(phase - 0.5) - 1),
        velocity=size * (-4 if phase < 0.5 else 4) / (800 * p.period),
        acceleration=2 * adaptation.most_acceleration if 450 <= k < 550 else 0.5 * adaptation.most_acceleration,
        **given,
    )


def _switches(k: int) -> int:
    position, integrator, compensator = (SWITCHES[name] for name in ("position", "integrator", "compensator"))
    if k < 100:
        return 0
    if k < 300:
        return position
    return position | (integrator if k % 700 < 500 else 0) | (compensator if k < 900 or k >= 1100 else 0)


def _learns(k: int) -> int:
    adapt = SWITCHES["adapt"] if k >= 200 and not 1200 <= k < 1300 else 0
    return adapt | (SWITCHES["disturbance"] if 600 <= k < 800 or 1000 <= k < 1250 else 0)


def _faulty(readings: Array, k: int, p: JointControllerParameters) -> Array:
    """Short faults that are bridged, and from 1500 on an angle that stays away."""
    if k % 250 in (120, 121, 122) or k >= 1500:
        readings[0] = np.nan
    if k % 330 in (200, 201):
        readings[1] = np.inf
    if k % 410 in (300, 301, 302) and p.pressure_jump > 0:
        readings[2] += 3 * p.pressure_jump
    if k % 370 == 250:
        readings[0] = 1e30
    return readings


def _lost(reference: JointReference, k: int) -> JointReference:
    return replace(reference, angle=np.nan) if k % 290 in (140, 141) else reference
