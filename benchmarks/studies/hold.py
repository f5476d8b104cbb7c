"""What the integrator still has to do beside a compensator: holding for minutes, and its gain along the path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst_robot.arm import Reference
from dehyst_robot.experiments import controller_parameters, home
from dehyst_robot.experiments._studies import STROKE_S, there_and_part_back
from dehyst_robot.experiments._trials import trial_motion
from studies.alone import COMPENSATOR, INTEGRATOR, POSITION, Alone, rms, to_start

Array = npt.NDArray[np.float64]

SETTLE_S = 4.0  # for the position loop to end its transient
HOLD_S = 180.0
SLICE_S = 0.02  # of an integrator that is computed outside of the controller
GAINS = (0.0, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0)


@dataclass(frozen=True, eq=False)
class Held:
    """A joint that holds still after a stroke.

    Attributes
    ----------
    time
        Since the position loop settled. [s]
    error
        Desired less true angle. [deg]
    integrator
        Its torque. [Nm]
    """

    time: Array
    error: Array
    integrator: Array

    @property
    def drift(self) -> float:
        """Slope of the integrator's torque over the last two thirds. [Nm/s]"""
        late = self.time > self.time[-1] / 3
        return float(np.polyfit(self.time[late], self.integrator[late], 1)[0])


def hold(
    joint: Alone, switches: int = 0, *, integrator: bool = False, lasting: float = HOLD_S
) -> Held:
    """Go out to 18 degrees and part of the way back to 12, and hold there.

    Parameters
    ----------
    joint
        With its direct inverse, or without.
    switches
        Beyond position control and, if there is a model, the compensator.
    integrator
        Whether it is on.
    lasting
        How long, after `SETTLE_S` that do not count. [s]
    """
    arm = joint.arm()
    home(arm, {joint.number: joint.characteristic})
    on = POSITION | (INTEGRATOR if integrator else 0)
    on |= (COMPENSATOR | switches) if joint.model is not None else 0
    t = 0.01 * np.arange(round((1 + 2 * STROKE_S + SETTLE_S + lasting) / 0.01) + 1)
    motion = there_and_part_back(np.asarray(t), float(arm.encoder_angles[0]))
    mean = joint.robot.controller.mean_pressure
    log = arm.run(Reference.motion(0.01, motion, arm.feedforward(*motion), mean, on), every_s=0.1)
    rest = log.time >= 1 + 2 * STROKE_S + SETTLE_S
    error = np.degrees(log.desired - log.angle)[rest, 0]
    return Held(log.time[rest] - log.time[rest][0], error, log.integrator[rest, 0])


@dataclass(frozen=True)
class Gain:
    """The slow trial with one gain of the integrator.

    Attributes
    ----------
    gain
        Over that of three equal poles, M lambda^3.
    rms_deg, max_deg
        Error along the path.
    work_Nm
        rms of the integrator's torque less its mean: what it has to follow.
    """

    gain: float
    rms_deg: float
    max_deg: float
    work_Nm: float


def gains(joint: Alone, switches: int = 0, values: Sequence[float] = GAINS) -> tuple[Gain, ...]:
    """Follow the slow path with integrators of several gains.

    The controller's own integrator is off; this one is computed every 20 ms from the measured angle and added to the
    load that the controller is told. With gain 1 it is the controller's, as the tests say.
    """
    return tuple(_with_gain(joint, switches, value) for value in values)


def _with_gain(joint: Alone, switches: int, gain: float) -> Gain:
    arm = joint.arm()
    home(arm, {joint.number: joint.characteristic})
    on = POSITION | ((COMPENSATOR | switches) if joint.model is not None else 0)
    told = controller_parameters(joint.robot, joint.number, joint.characteristic)
    rate = gain * told.inertia * told.pole**3 * SLICE_S
    motion = trial_motion(joint.robot, joint.path, "slow")
    times: Array = np.asarray(SLICE_S * np.arange(int(motion.duration / SLICE_S) + 1))
    along = joint.path.motion(motion, times)
    first = to_start(arm, along[0][0, [joint.number - 1]])
    angle, velocity, acceleration = (
        np.concatenate([a[:-1:2], b[:, [joint.number - 1]]])
        for a, b in zip(first, along, strict=True)
    )
    path = (angle, velocity, acceleration)
    reference = Reference.motion(
        SLICE_S, path, arm.feedforward(*path), joint.robot.controller.mean_pressure, on
    )
    integral, torque, error = 0.0, np.zeros(angle.size - 1), np.zeros(angle.size - 1)
    for k in range(angle.size - 1):
        integral += rate * float(angle[k, 0] - arm.encoder_angles[0])
        values = reference.values[k : k + 2].copy()
        values[:, :, 3] += integral
        log = arm.run(Reference(SLICE_S, values, reference.switches[k : k + 2]), every_s=SLICE_S)
        torque[k], error[k] = integral, np.degrees(log.desired - log.angle)[0, 0]
    begin = first[0].shape[0] // 2
    error, torque = error[begin:], torque[begin:]
    return Gain(gain, rms(error), float(np.abs(error).max()), float(np.std(torque)))
