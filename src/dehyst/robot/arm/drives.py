"""Joints of the simulated robot with commands or controllers of one's own; `Arm` adds the paper's controllers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

import dehyst.robot._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.robot.arm.joints import BEYOND, built_plant, noise_seed, refuse_beyond
from dehyst.robot.arm.mechanisms import Mechanism
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.arm.rigid_body import arm_model, joint_inertia, mj_step_address, moment_arms, new_data
from dehyst.robot.arm.runs import ArmLog, Reference
from dehyst.robot.control.controller import Controller, Seat, seated

SEEDS = 1 << 32


class Drives:
    """Joints of a robot without the paper's controllers: step them with commands, or run them with `Controller`s.

    A period of the simulation is: sensors, then commands, then physics, as in `Arm`. The same commands give the same
    run, bit for bit; `reset` is the look at the sensors at which a controller starts, `sense` the first of a run.

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
        Joint number -> `dehyst.Controller` of one's own, for `run`.

    Raises
    ------
    ParameterError
        If there is no such joint, mechanisms are no pair, the seed is none, or a controller is for a joint that has no
        muscles, or lacks a method.

    Examples
    --------
    A proportional controller of joint 1, written in Python, at 1 kHz:

    >>> from dehyst.robot.arm import load_robot
    >>> drives = Drives(load_robot(), (1,))
    >>> seen = drives.reset()
    >>> for _ in range(1000):
    ...     pull = 0.5 * (0.1 - seen[0, 0])
    ...     seen = drives.step([[pull, -pull]], ticks=2)
    >>> bool(seen[0, 0] > 0.02)
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
        moving, own = tuple(robot.joints) if moving is None else moving, controllers or {}
        _refuse_lawless(own, robot, moving)
        if own and pressures:
            raise ParameterError(
                "pressures=True and controllers: a controller answers with commands of valves, so pressures would be "
                "ignored. Leave one of them out."
            )
        if not 0 <= seed < SEEDS:
            raise ParameterError(f"seed = {seed} is none. Pass a whole number from 0 to {SEEDS - 1}.", seed=seed)
        self.robot, self.moving, self.period, self.seed = robot, moving, robot.simulation.period, seed
        self._pressures = pressures
        self.model = arm_model(robot, moving=moving, fused=True)
        self.data = new_data(self.model)
        self._angles = self.data.qpos  # the same memory: to ask for it anew costs as much as a period
        self._loop = _native.ClosedLoop(
            mj_step_address(), self.model._address, self.data._address,
            self.data.qpos, self.data.qvel, self.data.qfrc_applied, self.period,
        )  # fmt: skip
        inertia, pole = joint_inertia(self.model), robot.electric_pole
        self._plants: dict[int, _native.PneumaticJoint] = {}
        self._nothing = np.zeros(len(moving))
        self._least = BEYOND * min(robot.joint(number).range for number in moving)
        self._idle: list[int] = []  # joints without any controller
        for index, number in enumerate(moving):
            if not robot.joint(number).pneumatic:
                self._loop.add_electric(inertia[index] * pole**2, 2 * inertia[index] * pole, inertia[index])
                continue
            drive = self._driven(number, own.get(number))
            self._plants[number] = built_plant(robot, number, seed, (mechanisms or {}).get(number, ()))
            self._loop.add_pneumatic(self._plants[number], *drive)
            if drive == (None, None):
                self._idle.append(number)
        self.reset()

    def _driven(self, number: int, own: Controller | None) -> tuple[_native.JointController | None, Seat | None]:
        """The paper's controller of a joint, which an `Arm` has, and one's own."""
        return None, None if own is None else seated(own, number, self.period)

    def reset(self, seed: int | None = None) -> Array:
        """At rest in the zero pose, every muscle at the mean pressure, nothing remembered; return what is seen.

        `seed`: of the noise from here on, None for the same again; the muscles stay the same.
        """
        self.seed = self.seed if seed is None else seed
        self.data.qpos[:], self.data.qvel[:], self.data.qfrc_applied[:] = 0, 0, 0
        mean = self.robot.controller.mean_pressure
        for number, plant in self._plants.items():
            plant.reset(0.0, mean, mean, noise_seed(self.seed, number))
        return self._loop.reset_controllers(False)

    def sense(self) -> Array:
        """Look at the sensors, (n, 3) as `step`: each look has noise of its own, and there is one a period."""
        return self._loop.sense()

    def sensed(self, number: int) -> dict[str, float]:
        """Return what every sensor of plant/sensors.h showed of a joint at the last look: name -> value in SI."""
        return self._plants[number].sensed

    def step(self, commands: npt.ArrayLike, ticks: int = 1, hung: npt.ArrayLike | None = None) -> Array:
        """Hold commands for `ticks` periods, and return what the sensors show then.

        Parameters
        ----------
        commands
            (n, 2): of both valves of a joint, -1..1, positive fills; pressures [Pa] if they are commanded; of an
            electric joint its angle [rad] and a number that is not used.
        ticks
            Periods of the simulation, 1 or more.
        hung
            (n,) or one torque that pulls on the joints besides; None: none. [Nm]

        Raises
        ------
        ParameterError
            If commands or torques do not fit.
        SimulationError
            If a joint is so far beyond its range that neither muscles nor stops are simulated there.

        Returns
        -------
        seen
            (n, 3): angle [rad] and gauge pressures of both muscles [Pa]; zeros in place of those of electric joints.
        """
        values = np.ascontiguousarray(commands, dtype=np.float64)
        pull = self._nothing if hung is None else np.asarray(hung, dtype=np.float64) + self._nothing
        if values.shape != (len(self.moving), 2) or ticks < 1 or pull.shape != self._nothing.shape:
            raise ParameterError(
                f"commands of shape {values.shape} and torques of shape {pull.shape} for {ticks} periods: the moving "
                f"joints {self.moving} take ({len(self.moving)}, 2), two numbers a joint, and a torque each, for 1 "
                f"period or more.",
                shape=values.shape,
                ticks=ticks,
            )
        seen = self._loop.act(values, self._pressures, ticks, pull)
        if max(map(abs, self._angles.tolist())) > self._least:
            refuse_beyond(self.robot, self.moving, self.data.qpos[None])
        return seen

    def run(self, reference: Reference, every_s: float) -> ArmLog:
        """Run the closed loop along a reference from where it is, logging a row every `every_s` seconds.

        Raises
        ------
        ParameterError
            If the reference does not belong to these joints or to the control period, or is not finite; if a joint has
            no controller.
        OutputError
            If a controller of one's own answers with something that is not two finite numbers; any other fault in it
            comes out as it is.
        SimulationError
            If a joint went so far beyond its range that neither muscles nor stops are simulated there.
        """
        ticks = reference.ticks(self.moving, self.period)
        if not every_s > 0:
            raise ParameterError(f"a row every {every_s} s is no log. Pass a positive time.", every_s=every_s)
        if self._idle:
            raise ParameterError(
                f"joint {self._idle[0]} has no controller that could follow a reference. Pass one, JointBench(robot, "
                f"{self._idle[0]}, controller=MyController()) or Drives(robot, controllers={{{self._idle[0]}: "
                f"MyController()}}), or give the commands: step(commands).",
                joint=self._idle[0],
            )
        every = max(1, round(every_s / self.period))
        values, switches = np.ascontiguousarray(reference.values), np.ascontiguousarray(reference.switches)
        log = self._loop.run(values, switches, ticks, every)
        found = ArmLog.unpack(np.asarray(np.arange(log.shape[0]) * (every * self.period)), log)
        refuse_beyond(self.robot, self.moving, np.vstack([found.angle, self.data.qpos]))
        return found

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
        Two hysteresis mechanisms of one's own (`dehyst.robot.arm.mechanisms.Mechanism`); none: the built-in one.
    controller
        `dehyst.Controller` of one's own, for `run`; None: commands come by `step`.

    Raises
    ------
    ParameterError
        If no muscles drive the joint, mechanisms are no pair, or the controller lacks a method.

    Examples
    --------
    Both valves shut, nothing moves but by leakage:

    >>> from dehyst.robot.arm import load_robot
    >>> bench = JointBench(load_robot(), 1)
    >>> seen = bench.step([[0.0, 0.0]], ticks=100)
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
        own = {} if controller is None else {number: controller}
        moment_arms(robot, number)  # refuses an electric joint
        super().__init__(robot, (number,), seed=seed, mechanisms={number: mechanisms}, controllers=own)


def _refuse_lawless(laws: Mapping[int, Any], robot: Robot, moving: Sequence[int]) -> None:
    """Refuse a controller for a joint that is not moved by muscles."""
    if not isinstance(laws, Mapping):
        raise ParameterError(
            f"a {type(laws).__name__} does not say which joint it controls. Pass {{{moving[0]}: controller}}."
        )
    wrong = [number for number in laws if number not in moving or number not in robot.pneumatic]
    if wrong:
        raise ParameterError(
            f"a controller for joint {wrong[0]}, which {'has no muscles' if wrong[0] in moving else 'does not move'}. "
            f"Joints that can have one: {tuple(n for n in moving if n in robot.pneumatic)}.",
            joint=wrong[0],
        )
