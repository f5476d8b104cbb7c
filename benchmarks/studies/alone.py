"""A joint alone with a direct inverse on the path: repeated passes, contact, learning."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dehyst.errors import ParameterError
from dehyst.models import DirectInverse
from dehyst_robot.arm import Arm, ArmLog, Reference, Robot
from dehyst_robot.control import SWITCHES, Adaptation
from dehyst_robot.experiments import calibrate, controller_parameters, home, identify_joint
from dehyst_robot.experiments._calibration import home_and_learn, refuse_failed
from dehyst_robot.experiments._path import PlannedPath
from dehyst_robot.experiments._results import Characteristic
from dehyst_robot.experiments._trials import SLOW, trial_motion

Array = npt.NDArray[np.float64]

POSITION, INTEGRATOR, COMPENSATOR, ADAPT, DISTURBANCE = (
    SWITCHES[name] for name in ("position", "integrator", "compensator", "adapt", "disturbance")
)
LOG_S = {True: 0.02, False: 0.01}  # of slow and fast trials
KNOT_S = {True: 0.04, False: 0.004}
APPROACH_S = 6.0
REST_S = 1.0


@dataclass(frozen=True, eq=False)
class Alone:
    """A joint that moves alone, what was identified on it, and how it learns.

    Attributes
    ----------
    robot
        The plant that is run; not necessarily that which was identified.
    path
        Of the arm's tool.
    characteristic
        Calibrated A, B, C.
    model
        The joint's direct inverse; None: no compensator.
    adaptation
        How it learns where that is switched on.
    number
        Of the joint.
    seed
        Of noise and tolerances.
    """

    robot: Robot
    path: PlannedPath
    characteristic: Characteristic
    model: DirectInverse | None = None
    adaptation: Adaptation | None = None
    number: int = 1
    seed: int = 0

    def with_changes(self, **changes: object) -> Alone:
        """Return the same joint on a changed robot, keys with __ for their dots: ``hysteresis__scale=0.5``."""
        return replace(
            self,
            robot=self.robot.with_changes({k.replace("__", "."): v for k, v in changes.items()}),
        )

    def arm(self) -> Arm:
        """Return the joint with its controller, at rest."""
        told = controller_parameters(self.robot, self.number, self.characteristic)
        return Arm(
            self.robot,
            moving=(self.number,),
            controllers={self.number: told},
            compensators={self.number: self.model} if self.model is not None else None,
            adaptations={self.number: self.adaptation} if self.adaptation is not None else None,
            seed=self.seed,
        )


@dataclass(frozen=True, eq=False)
class Followed:
    """What a joint alone did along the path.

    Attributes
    ----------
    log
        All passes.
    error
        Desired less true angle, (passes, K). [deg]
    pushed
        Torque that pushed it at the rows of the log. [Nm]
    learned
        Scales in use at the end.
    """

    log: ArmLog
    error: Array
    pushed: Array
    learned: Array

    def figures(self, number: int = -1) -> tuple[float, float]:
        """rms and largest error of a pass. [deg]"""
        return rms(self.error[number]), float(np.abs(self.error[number]).max())

    @property
    def contact_error(self) -> Array:
        """Estimated less true contact torque at the rows of the log. [Nm]"""
        return np.asarray(self.log.contact[:, 0] + self.pushed)


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def follow(
    joint: Alone,
    trial: str,
    switches: int = 0,
    *,
    passes: int = 1,
    push: Callable[[Array], Array] | None = None,
    learn_homing: bool = False,
) -> Followed:
    """Home a joint alone, bring it to the path, and follow it.

    Parameters
    ----------
    joint
        What is run.
    trial
        "fast", "slow" or "slow_no_integrator".
    switches
        Beyond position control, integrator and, if there is a model, compensator: `ADAPT`, `DISTURBANCE`.
    passes
        How often the path is followed without a break.
    push
        Torque [Nm] that pushes the joint, of times (K,) from the start of the path [s]; None: nothing does.
    learn_homing
        Whether it learns from the homing, too.

    Raises
    ------
    SimulationError
        If the controller failed safe.
    """
    arm, slow = joint.arm(), trial in SLOW
    on = POSITION | (0 if trial == "slow_no_integrator" else INTEGRATOR)
    on |= (COMPENSATOR | switches) if joint.model is not None else 0
    (home_and_learn if learn_homing else home)(arm, {joint.number: joint.characteristic})
    mean = joint.robot.controller.mean_pressure
    motion = trial_motion(joint.robot, joint.path, trial)
    column = [joint.number - 1]
    spacing = KNOT_S[slow]
    times: Array = np.asarray(
        spacing * np.arange(int(np.ceil(passes * motion.duration / spacing)) + 1)
    )
    angle, velocity, acceleration = (
        values[:, column] for values in joint.path.motion(motion, times)
    )
    start = to_start(arm, angle[0])
    arm.run(Reference.motion(0.01, start, arm.feedforward(*start), mean, on), every_s=1.0)
    hung = np.zeros((times.size, 1)) if push is None else push(times)[:, None]
    path = (angle, velocity, acceleration)
    told = Reference.motion(spacing, path, arm.feedforward(*path), mean, on, hung=hung)
    log = arm.run(told, every_s=LOG_S[slow])
    refuse_failed(arm, log)
    log = log.until(passes * motion.duration)
    error = np.degrees(log.desired - log.angle)[:, 0]
    rows = error.size // passes
    return Followed(
        log=log,
        error=error[: passes * rows].reshape(passes, rows),
        pushed=np.interp(log.time, times, hung[:, 0]),
        learned=arm.learned(joint.number),
    )


def to_start(arm: Arm, goal: Array) -> tuple[Array, Array, Array]:
    """Motion (K, n) at knots of 10 ms from where the joints are to a goal (n,), and a rest there."""
    t = 0.01 * np.arange(round((APPROACH_S + 2 * REST_S) / 0.01) + 1)
    u = np.clip((t - REST_S) / APPROACH_S, 0.0, 1.0)[:, None]
    way = goal - arm.encoder_angles
    return (
        np.asarray(arm.encoder_angles + way * u**3 * (10 - 15 * u + 6 * u**2)),
        np.asarray(way * 30 * u**2 * (1 - u) ** 2 / APPROACH_S),
        np.asarray(way * 60 * u * (1 - u) * (1 - 2 * u) / APPROACH_S**2),
    )


def smooth_push(
    at: float, lasting: float = 15.0, size: float = 5.0, edge: float = 1.0
) -> Callable[[Array], Array]:
    """A push from a time on [s], with smooth edges. [Nm]

    Examples
    --------
    >>> smooth_push(10.0)(np.array([9.0, 10.5, 20.0, 30.0])).tolist()
    [0.0, 2.5, 5.0, 0.0]
    """

    def rise(t: Array) -> Array:
        x = np.clip(t / edge, 0.0, 1.0)
        return np.asarray(x * x * (3 - 2 * x))

    return lambda t: size * (rise(t - at) - rise(t - at - lasting))


def identified_alone(
    robot: Robot, path: PlannedPath, number: int = 1, seed: int = 0, compensator: str = "creep"
) -> Alone:
    """Calibrate a joint, identify a direct inverse on it, and return it ready to be run on that plant or another.

    Raises
    ------
    ParameterError
        If the compensator of that name is no direct inverse.
    """
    characteristic = calibrate(robot, number, seed=seed)
    with tempfile.TemporaryDirectory() as folder:
        found = identify_joint(
            robot, number, characteristic, Path(folder), compensator=compensator, seed=seed
        )
    if found.direct is None:
        raise ParameterError(
            f"'{compensator}' is no direct inverse. Type compensator='creep'.", name=compensator
        )
    return Alone(robot, path, characteristic, found.direct.pruned(), Adaptation(), number, seed)
