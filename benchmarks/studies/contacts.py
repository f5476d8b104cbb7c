"""A hand, a wall or a load at a joint alone that moves to and fro: its errors, and what is learned."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from dehyst.errors import ParameterError
from dehyst.models import DirectInverse
from dehyst_robot.arm import Arm, Reference, Robot
from dehyst_robot.arm._rigid_body import arm_mjcf
from dehyst_robot.control import FLAGS
from dehyst_robot.experiments import Equipment, home
from dehyst_robot.experiments._calibration import refuse_failed
from dehyst_robot.experiments._trials import trial_arm, trial_switches
from studies.alone import Array, rms, to_start

STROKE_S = 8.0
AMPLITUDE = np.radians(14.0)
BEGINS_S, ENDS_S, STOPS_S = 40.0, 120.0, 200.0  # of the contact, and of the motion
SETTLED_S = 5.0  # after the release the error is asked for
SPACING_S = 0.004  # at which a contact answers to the joint
EDGE_S = 0.5  # over which a hand takes hold
IMPEDANCE = 0.01  # d of a contact of MuJoCo: its force is that of a spring, and hardly that of a mass m d/(1 - d)
SLOW = np.radians(0.5)  # speed at which a hand that brakes gives half of its torque, rad/s

# Torque [Nm] of a contact, of the angle [rad], the speed [rad/s], and where the joint was when it began [rad].
Contact = Callable[[float, float, float], float]


@dataclass(frozen=True)
class Wall:
    """A plane of MuJoCo that the last link lies against at an angle of joint 1, without friction.

    Attributes
    ----------
    stiffness
        Of the torque of the contact by the angle beyond the wall. [Nm/rad]
    at
        That angle. [deg]
    damping
        [Nm s/rad]
    """

    stiffness: float
    at: float
    damping: float = 5.0


@dataclass(frozen=True)
class Touch:
    """A contact, and how long it takes until it is there in full [s]; what MuJoCo's solver touches beside it."""

    contact: Contact
    edge: float = EDGE_S
    wall: Wall | None = None


def along(torque: float) -> Contact:
    """A hand that helps the motion by a torque, or brakes it by a negative one, whatever the speed. [Nm]"""
    return lambda angle, speed, begun: float(torque * np.tanh(speed / SLOW))


def wall(stiffness: float, at: float) -> Contact:
    """A wall of a stiffness [Nm/rad] from an angle [deg] on."""
    return lambda angle, speed, begun: -stiffness * max(angle - np.radians(at), 0.0)


def held(stiffness: float, damping: float) -> Contact:
    """A hand that holds the joint where it took it: a spring [Nm/rad] and a damper [Nm s/rad]."""
    return lambda angle, speed, begun: -stiffness * (angle - begun) - damping * speed


def load(torque: float) -> Contact:
    """Something that hangs on the joint. [Nm]"""
    return lambda angle, speed, begun: torque


class ArmAtWall(Arm):
    """Joint 1 alone, upright, whose last link meets a plane of MuJoCo while `there` says so.

    The force is that of MuJoCo's contact: both ends of the link's capsule touch the plane.
    """

    def __init__(self, wall: Wall, robot: Robot, **parts: Any) -> None:
        self._wall = wall
        super().__init__(robot, **parts)

    def _rigid_bodies(self) -> mujoco.MjModel:
        spec = mujoco.MjSpec.from_string(
            arm_mjcf(self.robot, set(self.moving), self.robot.payload.mass, 1.0, {}, fused=True)
        )
        link = spec.geom(f"link {max(self.robot.joints)}")
        link.contype = 1
        at = np.radians(self._wall.at)
        normal = np.array([np.sin(at), -np.cos(at), 0.0])
        # Behind the axis by the radius of the link, so that the link meets it at that angle.
        spec.worldbody.add_geom(
            name="wall",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[1.0, 1.0, 0.1],
            pos=-link.size[0] * normal,
            quat=np.sqrt(0.5) * np.array([1.0, -normal[1], normal[0], 0.0]),  # from z to the normal
            contype=1,
            conaffinity=1,
            condim=1,
            priority=1,  # its softness alone counts
            solimp=[IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0],
        )
        model = spec.compile()
        model.geom("wall").solref[:] = self._softness(model)
        return model

    def _softness(self, model: mujoco.MjModel) -> Array:
        """Return stiffness and damping as MuJoCo takes them, negative, by the mass that it assumes. [1/s^2, 1/s]

        At rest a contact of depth r and impedance d pushes with s r m/(1 - d), with m = 1/invweight of its body.
        """
        link = model.geom(f"link {max(self.robot.joints)}")
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        middle = data.geom(link.id).xpos
        half = link.size[1] * data.geom(link.id).xmat.reshape(3, 3)[:, 2]
        squares = 0.0
        for end in (middle + half, middle - half):
            squares += float(end[0] ** 2 + end[1] ** 2)
        mass = squares / float(model.body_invweight0[link.bodyid[0], 0])
        share = (1.0 - IMPEDANCE) / mass
        return -share * np.array([self._wall.stiffness, self._wall.damping])

    def there(self, yes: bool) -> None:
        """Put the wall there, or take it away."""
        off = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        self.model.opt.disableflags = 0 if yes else int(off)


CONTACTS: dict[str, Touch | None] = {
    "none": None,
    "a hand that brakes, 4 Nm": Touch(along(-4.0)),
    "a hand that helps, 4 Nm": Touch(along(4.0)),
    "a hand that brakes, 10 Nm": Touch(along(-10.0)),
    "a hand that holds on, 60 Nm/rad": Touch(held(60.0, 3.0)),
    "a wall at 6 degrees, 200 Nm/rad": Touch(wall(200.0, 6.0)),
    "a load of 5 Nm": Touch(load(5.0)),
    "a wall at 6 degrees, 200 Nm/rad, of MuJoCo": Touch(load(0.0), wall=Wall(200.0, 6.0)),
    "a hand that brakes, 4 Nm after 5 s": Touch(along(-4.0), edge=5.0),
    "a hand that brakes, 4 Nm after 60 s": Touch(along(-4.0), edge=60.0),
}


@dataclass(frozen=True, eq=False)
class Touched:
    """What a joint did before, during and after a contact.

    Attributes
    ----------
    time
        From the start of the motion, (T,). [s]
    error
        Desired less true angle, (T,). [deg]
    pushed
        Torque of the contact, (T,). [Nm]
    scales
        Of the groups of the compensator, in use, (T, groups).
    flags
        Of the controller, (T,).
    """

    time: Array
    error: Array
    pushed: Array
    scales: Array
    flags: npt.NDArray[np.int64]

    def between(self, begin: float, end: float) -> float:
        """Return the rms error from a time to another. [deg]"""
        return rms(self.error[(self.time >= begin) & (self.time < end)])

    @property
    def before(self) -> float:
        """Rms error of the last 24 s without contact. [deg]"""
        return self.between(BEGINS_S - 3 * STROKE_S, BEGINS_S)

    @property
    def during(self) -> float:
        """Rms error of the contact. [deg]"""
        return self.between(BEGINS_S, ENDS_S)

    @property
    def settled(self) -> float:
        """Rms error of the two strokes from 5 s after the release on. [deg]"""
        begin = ENDS_S + SETTLED_S
        return self.between(begin, begin + 2 * STROKE_S)

    @property
    def peak(self) -> float:
        """Largest torque of the contact. [Nm]"""
        return float(np.abs(self.pushed).max())

    @property
    def later(self) -> float:
        """Rms error of the last 40 s. [deg]"""
        return self.between(STOPS_S - 40.0, STOPS_S)

    def noticed(self, name: str) -> float:
        """Return how long after the contact began a flag was raised; nan if it was not. [s]"""
        seen = (self.flags & FLAGS[name]) != 0
        times = self.time[seen & (self.time >= BEGINS_S) & (self.time < ENDS_S)]
        return float(times[0] - BEGINS_S) if times.size else float("nan")

    def scale_extremes(self) -> tuple[float, float]:
        """Return the lowest and the highest scale that was in use from the contact on."""
        used = self.scales[self.time >= BEGINS_S]
        if used.size == 0:
            return 1.0, 1.0
        return float(used.min()), float(used.max())


def motion(times: Array) -> tuple[Array, Array, Array]:
    """Return strokes to and fro, begun at rest in the middle: angle, velocity and acceleration, (K, 1) each."""
    omega = np.pi / STROKE_S
    phase = omega * times
    grows = np.clip(times / STROKE_S, 0.0, 1.0)
    size = AMPLITUDE * grows * grows * (3.0 - 2.0 * grows)
    angle = size * np.sin(phase)
    velocity = np.gradient(angle, times)
    return angle[:, None], velocity[:, None], np.gradient(velocity, times)[:, None]


def loop_energy(robot: Robot, equipment: Equipment, number: int, compensator: str) -> float:
    """Return the work of a direct inverse along two strokes, as it was identified; nan of others. [J]"""
    model = equipment.compensators.get(number)
    if compensator == "off" or not isinstance(model, DirectInverse):
        return float("nan")
    times: Array = np.asarray(SPACING_S * np.arange(round(6 * STROKE_S / SPACING_S) + 1))
    angle, velocity, _ = motion(times)
    mean = np.full(times.size, robot.controller.mean_pressure)
    given = {"mean_pressure": mean, "load": np.zeros(times.size)}
    signals = {name: given[name] for name in model.needs}
    torque = model.run(angle[:, 0], times, given=signals).u
    last = times >= times[-1] - 2 * STROKE_S
    return float(np.trapezoid((torque * velocity[:, 0])[last], times[last]))


def touched_arm(robot: Robot, equipment: Equipment, number: int, by: Touch | None) -> Arm:
    """Return the joint alone as in a trial, beside a wall of MuJoCo if the contact has one."""
    if by is None or by.wall is None:
        return trial_arm(robot, equipment, "slow", (number,))
    if number != 1:
        raise ParameterError(f"joint {number}: the wall of MuJoCo stands beside joint 1. Pass 1.")
    return ArmAtWall(
        by.wall,
        robot,
        moving=(number,),
        controllers=equipment.controllers,
        compensators=equipment.compensators,
        adaptations=equipment.adaptations,
        seed=equipment.seed,
    )


def touch(
    robot: Robot, equipment: Equipment, number: int, compensator: str, by: Touch | None
) -> Touched:
    """Home a joint alone, move it to and fro, and touch it from 40 s to 120 s; None touches nothing.

    The contact answers to the true angle and speed of the joint 250 times a second.
    """
    arm = touched_arm(robot, equipment, number, by)
    home(arm, equipment.characteristics)
    mean = robot.controller.mean_pressure
    switches = trial_switches(robot, (number,), "slow", compensator, equipment.adaptations)
    times: Array = np.asarray(SPACING_S * np.arange(round(STOPS_S / SPACING_S) + 1))
    path = motion(times)
    feedforward = arm.feedforward(*path)
    start = to_start(arm, path[0][0])
    arm.run(Reference.motion(0.01, start, arm.feedforward(*start), mean, switches), every_s=1.0)
    error, pushed, scales, flags = [], [], [], []
    torque, begun = 0.0, 0.0
    for k in range(times.size - 1):
        angle, speed = float(arm.angles[0]), float(arm.data.qvel[0])
        lasting = times[k] - BEGINS_S
        if lasting < 0.0:
            begun = angle
        before, torque = torque, 0.0
        is_there = by is not None and 0.0 <= lasting < ENDS_S - BEGINS_S
        if isinstance(arm, ArmAtWall):
            arm.there(is_there)
        if by is not None and is_there:
            torque = min(lasting / by.edge, 1.0) * by.contact(angle, speed, begun)
        part = slice(k, k + 2)
        moves = path[0][part], path[1][part], path[2][part]
        pulls = np.array([[before], [torque]])
        told = Reference.motion(SPACING_S, moves, feedforward[part], mean, switches, hung=pulls)
        log = arm.run(told, every_s=SPACING_S)
        refuse_failed(arm, log)
        error.append(float(np.degrees(path[0][k + 1, 0] - arm.angles[0])))
        pushed.append(torque + float(arm.data.qfrc_constraint[0]))
        scales.append(log.scale[-1, 0] * log.scales[-1, 0])
        flags.append(int(np.bitwise_or.reduce(log.flags[:, 0])))
    return Touched(times[1:], np.array(error), np.array(pushed), np.array(scales), np.array(flags))
