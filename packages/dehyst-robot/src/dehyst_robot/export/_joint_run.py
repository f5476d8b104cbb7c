"""Test run of an exported joint controller: a joint that follows a motion, with switching and faulty sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from dehyst.arrays import Array
from dehyst.export import Signal
from dehyst.export import kit as export_kit
from dehyst.models import DirectInverse, HysteresisModel
from dehyst_robot.control import (
    SWITCHES,
    Adaptation,
    JointController,
    JointControllerParameters,
    JointReference,
)
from dehyst_robot.control import kit as control_kit

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
    direct, friction = None, None
    if learns:
        direct = control_kit.in_si(cast(DirectInverse, compensator))
        friction = _Friction(direct, parameters)
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
            # For a while the position is not controlled.
            if 350 <= k < 420:
                on &= ~SWITCHES["position"]
        # Noise of the pressure sensors, the same in each run.
        readings = np.array(
            [plant.sensed_angle(), *(plant.pressure + 30.0 * rng.standard_normal(2))]
        )
        readings = _faulty(readings, k, parameters)
        # Rounded to the target's numbers: it must see what the core sees.
        row = np.array(
            [export_kit.rounded(x, real) for x in (*readings, *_lost(reference, k).as_tuple())]
        )
        if k == 0:
            controller.reset(*row[:3])
        out = controller.step(row[0], row[1], row[2], JointReference(*row[3:]), on)
        # What went in, what came out, and which flags were up.
        rows.append(row)
        switch.append(on)
        answers.append([getattr(out, name) for name in ANSWERS])
        flags.append(out.flags)
        plant.step(np.array([out.desired_1, out.desired_2]))
        if friction is not None:
            plant.load = friction.torque(plant, reference)
            # Something pushes, which neither model nor reference knows.
            if 900 <= k < 1100:
                plant.load -= PUSH
    return Signal(
        np.array(rows),
        np.array(switch),
        np.array(answers),
        np.array(flags),
        (*SENSORS, *REFERENCE),
        OUTPUTS,
    )


class _Friction:
    """Friction of a test joint: a bit more than its direct inverse feeds forward, as of a worn joint."""

    def __init__(self, model: DirectInverse, parameters: JointControllerParameters) -> None:
        self._step = model.core_stepper(parameters.period)
        self._scheduled_by = [schedule.name for schedule in model.outside]

    def torque(self, plant: _Joint, reference: JointReference) -> float:
        """Return it with the known load, for the present angle. [Nm]"""
        values = [float(getattr(reference, name)) for name in self._scheduled_by]
        return float(WORN * self._step(plant.angle, plant.velocity, *values) + reference.load)


class _Joint:
    """A mass at the nominal characteristic whose pressures follow with a short lag."""

    def __init__(self, parameters: JointControllerParameters, damping: float) -> None:
        self.p, self.damping = parameters, damping
        self.angle, self.velocity, self.load = START, 0.0, 0.0
        self.pressure = np.full(2, 0.4 * (parameters.pressure_low + parameters.pressure_high))

    def sensed_angle(self) -> float:
        step = self.p.angle_step
        if step <= 0:
            return self.angle
        return round(self.angle / step) * step

    def step(self, desired: Array) -> None:
        p = self.p
        q = min(max(self.angle, p.angle_low), p.angle_high)
        a, b, c = _polynomial(p.a, q), _polynomial(p.b, q), _polynomial(p.c, q)
        torque = (
            a * self.pressure.mean() + b * (self.pressure[0] - self.pressure[1]) + c - self.load
        )
        self.velocity += p.period * (torque / p.inertia - self.damping * self.velocity)
        self.angle = min(
            max(self.angle + p.period * self.velocity, 2 * p.angle_low), 2 * p.angle_high
        )
        self.pressure += min(1.0, p.period * 100.0) * (desired - self.pressure)


def _polynomial(coefficients: Sequence[float], q: float) -> float:
    return sum(coefficient * q**power for power, coefficient in enumerate(coefficients))


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
    reference: JointReference,
    model: DirectInverse,
    adaptation: Adaptation,
    p: JointControllerParameters,
    k: int,
) -> JointReference:
    """Sweep what schedules the model; move slowly but for a while, so that it learns, then through all the range."""
    t = k * p.period
    scheduled = {name: getattr(reference, name) for name in control_kit.GIVEN}
    for schedule, speed in zip(model.outside, (9.0, 13.0), strict=False):
        # Beyond the ends of the schedule too.
        half = 0.55 * (schedule.high - schedule.low)
        scheduled[schedule.name] = 0.5 * (schedule.low + schedule.high) + half * np.sin(speed * t)
    center, share, way = 0.5 * (p.angle_high + p.angle_low), 0.4, 4
    if k < 1100:
        center, share = START, 0.03
    size = share * (p.angle_high - p.angle_low)
    phase = (k % 800) / 800
    if phase < 0.5:
        way = -4
    acceleration = 0.5 * adaptation.most_acceleration
    # For a while too fast to learn.
    if 450 <= k < 550:
        acceleration = 2 * adaptation.most_acceleration
    return replace(
        reference,
        angle=center + size * (4 * abs(phase - 0.5) - 1),
        velocity=size * way / (800 * p.period),
        acceleration=acceleration,
        **scheduled,
    )


def _switches(k: int) -> int:
    """What is on in a period: everything comes and goes."""
    if k < 100:
        return 0
    switches = SWITCHES["position"]
    if k < 300:
        return switches
    if k % 700 < 500:
        switches |= SWITCHES["integrator"]
    if k < 900 or k >= 1100:
        switches |= SWITCHES["compensator"]
    return switches


def _learns(k: int) -> int:
    switches = 0
    if k >= 200 and not 1200 <= k < 1300:
        switches |= SWITCHES["adapt"]
    if 600 <= k < 800 or 1000 <= k < 1250:
        switches |= SWITCHES["disturbance"]
    return switches


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
    """The reference, whose angle is no number now and then."""
    if k % 290 in (140, 141):
        return replace(reference, angle=np.nan)
    return reference
