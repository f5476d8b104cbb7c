"""One joint of the simulated arm on a test bench, with valves commanded step by step.

`Arm` runs the built-in controller in a closed loop of its own. Here the loop is the caller's: for a controller that
lives elsewhere, in an FMU, on a target or in a script.
"""

from __future__ import annotations

from typing import NamedTuple

import dehyst._native as _native
from dehyst.errors import ParameterError
from dehyst.robot.arm.arm import built_plant, noise_seed
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.arm.physics_engine import mujoco
from dehyst.robot.arm.rigid_body import arm_model, new_data


class Reading(NamedTuple):
    """What the sensors of a joint show: encoder [rad], gauge pressures of both muscles [Pa]."""

    angle: float
    pressure_1: float
    pressure_2: float


class JointBench:
    """One pneumatic joint of the simulated arm, the others locked at their zero pose.

    A period is `sense`, then `step`: the same physics, noise and order as in ``Arm(robot, moving=(number,))``, so that
    the same valve commands give the same run, bit for bit.

    Parameters
    ----------
    robot
        Parameters, from `load_robot`.
    number
        Of the joint.
    seed
        Of the sensors' noise and the muscles' tolerances.

    Raises
    ------
    ParameterError
        If no muscles drive the joint.

    Examples
    --------
    Both valves shut, nothing moves but by leakage:

    >>> from dehyst.robot.arm import load_robot
    >>> bench = JointBench(load_robot(), 1)
    >>> for _ in range(100):
    ...     reading = bench.sense()
    ...     bench.step(0.0, 0.0)
    >>> abs(bench.angle) < 1e-3
    True
    """

    def __init__(self, robot: Robot, number: int, *, seed: int = 0) -> None:
        if not robot.joint(number).pneumatic:
            raise ParameterError(
                f"joint {number} is electric: it has no valves. Joints with muscles: {robot.pneumatic}.", joint=number
            )
        self._period = robot.simulation.period
        self._mean = robot.controller.mean_pressure
        self._seed = noise_seed(seed, number)
        self._model = arm_model(robot, moving=(number,), fused=True)
        self._data = new_data(self._model)
        self._plant: _native.PneumaticJoint = built_plant(robot, number, seed)
        self._advance = mujoco().mj_step
        self._start = self.reset()

    def reset(self) -> Reading:
        """At rest in the zero pose, both muscles at the mean pressure, nothing remembered; return `start`."""
        self._data.qpos[:] = 0
        self._data.qvel[:] = 0
        self._data.qfrc_applied[:] = 0
        self._plant.reset(0.0, self._mean, self._mean, self._seed)
        self._start = self.sense()
        return self._start

    def sense(self) -> Reading:
        """Read the sensors, once a period: each reading has noise of its own."""
        return Reading(*self._plant.sense(self.angle, self.period))

    def step(self, valve_1: float, valve_2: float, hung: float = 0.0) -> None:
        """Advance by one period.

        Parameters
        ----------
        valve_1, valve_2
            Commands, -1..1; positive fills the muscle.
        hung
            Torque that pulls on the joint besides. [Nm]
        """
        drive = self._plant.step(self.angle, self.velocity, valve_1, valve_2, self.period)
        self._data.qfrc_applied[0] = hung + drive
        self._advance(self._model, self._data)

    @property
    def period(self) -> float:
        """Of the simulation and of the control. [s]"""
        return self._period

    @property
    def start(self) -> Reading:
        """What the sensors showed at the start: a controller is to be reset to it."""
        return self._start

    @property
    def angle(self) -> float:
        """True angle. [rad]"""
        return float(self._data.qpos[0])

    @property
    def velocity(self) -> float:
        """True angular velocity. [rad/s]"""
        return float(self._data.qvel[0])
