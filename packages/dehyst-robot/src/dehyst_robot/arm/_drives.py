"""Joints of the simulated robot with commands or user-defined controllers; `Arm` adds the paper's controllers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

import dehyst_robot._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst_robot.arm._joints import built_plant, noise_seed, refuse_beyond
from dehyst_robot.arm._mechanisms import Mechanism
from dehyst_robot.arm._parameters import Robot
from dehyst_robot.arm._policy import POLICY
from dehyst_robot.arm._rigid_body import (
    arm_model,
    joint_inertia,
    mj_step_address,
    moment_arms,
    new_data,
)
from dehyst_robot.arm._runs import ArmLog, Reference
from dehyst_robot.control import Controller, Seat
from dehyst_robot.control import kit as control_kit

if TYPE_CHECKING:
    from mujoco import MjModel

SEEDS = 1 << 32


class Drives:
    """Joints of a robot without the paper's controllers: step them with commands, or run them with `Controller`s.

    In a period of the simulation come sensors, then commands, then physics, as in `Arm`. The same commands give the
    same run, bit for bit. `reset` returns the readings with which a controller starts, `sense` the first of a run.

    Parameters
    ----------
    robot
        From `load_robot`.
    moving
        Numbers of the joints that move, increasing; None: all. The others are locked at their zero pose.
    pressures
        Whether commands of `step` are gauge pressures in the muscles [Pa], reached at once; else valves, -1..1.
    seed
        Of the sensors' noise and the muscles' tolerances.
    mechanisms
        Joint number -> two foreign hysteresis mechanisms, one a muscle, instead of the built-in one.
    controllers
        Joint number -> user-defined `dehyst_robot.Controller`, for `run`.

    Raises
    ------
    ParameterError
        If there is no such joint, mechanisms are no pair, the seed is none, or a controller is for a joint that has no
        muscles, or lacks a method.

    Examples
    --------
    A proportional controller of joint 1, written in Python, at 1 kHz:

    >>> from dehyst_robot.arm import load_robot
    >>> drives = Drives(load_robot(), (1,))
    >>> readings = drives.reset()
    >>> for _ in range(1000):
    ...     pull = 0.5 * (0.1 - readings[0, 0])
    ...     readings = drives.step([[pull, -pull]], ticks=2)
    >>> bool(readings[0, 0] > 0.02)
    True
    """

    def __init__(
        self,
        robot: Robot,
        moving: tuple[int, ...] | None = None,
        *,
        pressures: bool = False,
        seed: int = 0,
        mechanisms: Mapping[int, Sequence[Mechanism]] | None = None,
        controllers: Mapping[int, Controller] | None = None,
    ) -> None:
        if moving is None:
            moving = tuple(robot.joints)
        controllers = controllers or {}
        mechanisms = mechanisms or {}
        _refuse_unusable(controllers, robot, moving)
        if controllers and pressures:
            raise ParameterError(
                "pressures=True and controllers: a controller answers with commands of valves, so pressures would be "
                "ignored. Leave one of them out."
            )
        if not 0 <= seed < SEEDS:
            raise ParameterError(
                f"seed = {seed} is none. Pass a whole number from 0 to {SEEDS - 1}.", seed=seed
            )
        self.robot = robot
        self.moving = moving
        self.period = robot.simulation.period
        self.seed = seed
        self._pressures = pressures
        self.model = self._rigid_bodies()
        self.data = new_data(self.model)
        # The same memory as MuJoCo's: to ask for it anew costs as much as a period.
        self._angles = self.data.qpos
        self._loop = _native.ClosedLoop(
            mj_step_address(), self.model._address, self.data._address,
            self.data.qpos, self.data.qvel, self.data.qfrc_applied, self.period,
        )  # fmt: skip
        inertia = joint_inertia(self.model)
        pole = robot.electric_pole
        self._plants: dict[int, _native.PneumaticJoint] = {}
        self._no_torque = np.zeros(len(moving))
        # A quick test in `step`: while all angles are below this, none is beyond its range.
        self._least_limit = POLICY.beyond * min(robot.joint(number).range for number in moving)
        self._without_controller: list[int] = []
        # Joints are added in the order of the model's degrees of freedom.
        for index, number in enumerate(moving):
            if not robot.joint(number).pneumatic:
                # The servo sees the inertia of its joint in the zero pose.
                self._loop.add_electric(
                    inertia[index] * pole**2, 2 * inertia[index] * pole, inertia[index]
                )
                continue
            drive = self._driven(number, controllers.get(number))
            plant = built_plant(robot, number, seed, mechanisms.get(number, ()))
            self._plants[number] = plant
            self._loop.add_pneumatic(plant, *drive)
            if drive == (None, None):
                self._without_controller.append(number)
        self.reset()

    def _rigid_bodies(self) -> MjModel:
        """Return MuJoCo's model of the links; a class with something around the arm makes its own."""
        return arm_model(self.robot, moving=self.moving, fused=True)

    def _driven(
        self, number: int, controller: Controller | None
    ) -> tuple[_native.JointController | None, Seat | None]:
        """Return the paper's controller of a joint, which only an `Arm` has, and the user-defined one."""
        if controller is None:
            return None, None
        return None, control_kit.seated(controller, number, self.period)

    def reset(self, seed: int | None = None) -> Array:
        """Put the joints at rest in the zero pose, every muscle at the mean pressure, without memory; return readings.

        `seed`: of the noise from here on, None for the same again; the muscles stay the same.
        """
        if seed is not None:
            self.seed = seed
        self.data.qpos[:] = 0
        self.data.qvel[:] = 0
        self.data.qfrc_applied[:] = 0
        # Muscles at the mean pressure balance each other in the zero pose.
        mean = self.robot.controller.mean_pressure
        for number, plant in self._plants.items():
            plant.reset(0.0, mean, mean, noise_seed(self.seed, number))
        return self._loop.reset_controllers(False)

    def sense(self) -> Array:
        """Read the sensors, (n, 3) as in `step`. Each reading has new noise, so read once in a period."""
        return self._loop.sense()

    def sensed(self, number: int) -> dict[str, float]:
        """Return the last readings of all sensors of a joint: name in packages/dehyst-robot/plant/sensors.h -> SI."""
        return self._plants[number].sensed

    def step(
        self, commands: npt.ArrayLike, ticks: int = 1, hung: npt.ArrayLike | None = None
    ) -> Array:
        """Hold commands for `ticks` periods, and return the readings after them.

        Parameters
        ----------
        commands
            (n, 2): of both valves of a joint, -1..1, positive fills; pressures [Pa] if they are commanded; of an
            electric joint its angle [rad] and a number that is not used.
        ticks
            Periods of the simulation, 1 or more.
        hung
            (n,) or one additional torque on the joints; None: none. [Nm]

        Raises
        ------
        ParameterError
            If commands or torques do not fit.
        SimulationError
            If a joint is so far beyond its range that neither muscles nor stops are simulated there.

        Returns
        -------
        readings
            (n, 3): angle [rad] and gauge pressures of both muscles [Pa]; zeros in place of those of electric joints.
        """
        values = np.ascontiguousarray(commands, dtype=np.float64)
        torque = self._no_torque
        if hung is not None:
            torque = np.asarray(hung, dtype=np.float64) + self._no_torque
        count = len(self.moving)
        if values.shape != (count, 2) or ticks < 1 or torque.shape != (count,):
            raise ParameterError(
                f"commands of shape {values.shape} and torques of shape {torque.shape} for {ticks} periods: the moving "
                f"joints {self.moving} take ({count}, 2), two numbers a joint, and a torque each, for 1 period or "
                f"more.",
                shape=values.shape,
                ticks=ticks,
            )
        readings = self._loop.act(values, self._pressures, ticks, torque)
        if max(map(abs, self._angles.tolist())) > self._least_limit:
            refuse_beyond(self.robot, self.moving, self.data.qpos[None])
        return readings

    def run(self, reference: Reference, every_s: float) -> ArmLog:
        """Run the closed loop along a reference from where it is, logging a row every `every_s` seconds.

        Raises
        ------
        ParameterError
            If the reference does not belong to these joints or to the control period, or is not finite; if a joint has
            no controller.
        OutputError
            If a user-defined controller does not return two finite numbers; its own exceptions are raised as they are.
        SimulationError
            If a joint went so far beyond its range that neither muscles nor stops are simulated there.
        """
        ticks = reference.ticks(self.moving, self.period)
        if not every_s > 0:
            raise ParameterError(
                f"a row every {every_s} s is no log. Pass a positive time.", every_s=every_s
            )
        if self._without_controller:
            number = self._without_controller[0]
            raise ParameterError(
                f"joint {number} has no controller that could follow a reference. Pass one, "
                f"JointBench(robot, {number}, controller=MyController()) or "
                f"Drives(robot, controllers={{{number}: MyController()}}), or give the "
                f"commands: step(commands).",
                joint=number,
            )
        ticks_per_row = max(1, round(every_s / self.period))
        values = np.ascontiguousarray(reference.values)
        switches = np.ascontiguousarray(reference.switches)
        rows = self._loop.run(values, switches, ticks, ticks_per_row)
        time = np.asarray(np.arange(rows.shape[0]) * (ticks_per_row * self.period))
        log = ArmLog.unpack(time, rows)
        # The joints moved on after the last row.
        refuse_beyond(self.robot, self.moving, np.vstack([log.angle, self.data.qpos]))
        return log

    @property
    def angles(self) -> Array:
        """True angles, (n,). [rad]"""
        return np.array(self._angles)

    @property
    def velocities(self) -> Array:
        """True angular velocities, (n,). [rad/s]"""
        return np.array(self.data.qvel)


class JointBench(Drives):
    """One pneumatic joint of the simulated arm, the others locked at their zero pose: `Drives` of that joint.

    Parameters
    ----------
    robot
        Parameters, from `load_robot`.
    number
        Of the joint.
    seed
        Of the sensors' noise and the muscles' tolerances.
    mechanisms
        Two user-defined hysteresis mechanisms (`dehyst_robot.Mechanism`); none: the built-in one.
    controller
        User-defined `dehyst_robot.Controller`, for `run`; None: commands come by `step`.

    Raises
    ------
    ParameterError
        If no muscles drive the joint, mechanisms are no pair, or the controller lacks a method.

    Examples
    --------
    Both valves shut, nothing moves but by leakage:

    >>> from dehyst_robot.arm import load_robot
    >>> bench = JointBench(load_robot(), 1)
    >>> readings = bench.step([[0.0, 0.0]], ticks=100)
    >>> bool(abs(bench.angles[0]) < 1e-3)
    True
    """

    def __init__(
        self,
        robot: Robot,
        number: int,
        *,
        seed: int = 0,
        mechanisms: Sequence[Mechanism] = (),
        controller: Controller | None = None,
    ) -> None:
        moment_arms(robot, number)  # refuses an electric joint
        controllers = {}
        if controller is not None:
            controllers[number] = controller
        super().__init__(
            robot,
            (number,),
            seed=seed,
            mechanisms={number: mechanisms},
            controllers=controllers,
        )


def _refuse_unusable(controllers: Mapping[int, Any], robot: Robot, moving: Sequence[int]) -> None:
    """Refuse a controller for a joint that is not moved by muscles."""
    if not isinstance(controllers, Mapping):
        raise ParameterError(
            f"a {type(controllers).__name__} does not say which joint it controls. Pass {{{moving[0]}: controller}}."
        )
    allowed = tuple(number for number in moving if number in robot.pneumatic)
    for number in controllers:
        if number in allowed:
            continue
        reason = "has no muscles" if number in moving else "does not move"
        raise ParameterError(
            f"a controller for joint {number}, which {reason}. Joints that can have one: {allowed}.",
            joint=number,
        )
