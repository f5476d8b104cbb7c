"""The arm without controllers: commands of one's own go to valves or muscles, period after period."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.robot.arm.joints import BEYOND, built_plant, noise_seed, refuse_beyond
from dehyst.robot.arm.mechanisms import Mechanism
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.arm.rigid_body import arm_model, joint_inertia, mj_step_address, new_data


class Drives:
    """Joints of a robot driven by a controller of one's own; the physics, noise and order are those of `Arm`.

    Parameters
    ----------
    robot
        From `load_robot`.
    moving
        Numbers of the joints that move, increasing; None: all. The others are locked at their zero pose.
    pressures
        Whether commands are gauge pressures in the muscles [Pa], reached at once; else valves, -1..1.
    seed
        Of the sensors' noise and the muscles' tolerances.
    mechanisms
        Joint number -> two foreign hysteresis mechanisms, one a muscle, instead of the built-in one.

    Raises
    ------
    ParameterError
        If there is no such joint, or mechanisms are no pair.

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
        mechanisms: Mapping[int, tuple[Mechanism, Mechanism]] | None = None,
    ) -> None:
        self.robot, self.moving, self.period = robot, moving or tuple(robot.joints), robot.simulation.period
        self._pressures, self._seed = pressures, seed
        self.model = arm_model(robot, moving=self.moving, fused=True)
        self.data = new_data(self.model)
        self._angles = self.data.qpos  # the same memory: to ask for it anew costs as much as a period
        self._loop = _native.ClosedLoop(
            mj_step_address(), self.model._address, self.data._address,
            self.data.qpos, self.data.qvel, self.data.qfrc_applied, self.period,
        )  # fmt: skip
        inertia, pole = joint_inertia(self.model), robot.electric_pole
        self._plants = {}
        self._least = BEYOND * min(robot.joint(number).range for number in self.moving)
        for index, number in enumerate(self.moving):
            if robot.joint(number).pneumatic:
                plant = built_plant(robot, number, seed, (mechanisms or {}).get(number, ()))
                self._loop.add_pneumatic(plant, None)
                self._plants[number] = plant
            else:
                self._loop.add_electric(inertia[index] * pole**2, 2 * inertia[index] * pole, inertia[index])

    def reset(self, seed: int | None = None) -> Array:
        """At rest in the zero pose, every muscle at the mean pressure, nothing remembered; return what is seen.

        `seed`: of the noise from here on, None for the same again; the muscles stay the same.
        """
        self._seed = self._seed if seed is None else seed
        self.data.qpos[:], self.data.qvel[:], self.data.qfrc_applied[:] = 0, 0, 0
        mean = self.robot.controller.mean_pressure
        for number, plant in self._plants.items():
            plant.reset(0.0, mean, mean, noise_seed(self._seed, number))
        return self._loop.sense()

    def step(self, commands: npt.ArrayLike, ticks: int = 1) -> Array:
        """Hold commands for `ticks` periods, and return what the sensors show then.

        Parameters
        ----------
        commands
            (n, 2): of both valves of a joint, -1..1, positive fills; pressures [Pa] if they are commanded; of an
            electric joint its angle [rad] and a number that is not used.
        ticks
            Periods of the simulation, 1 or more.

        Raises
        ------
        ParameterError
            If commands do not fit.
        SimulationError
            If a joint is so far beyond its range that neither muscles nor stops are simulated there.

        Returns
        -------
        seen
            (n, 3): angle [rad] and gauge pressures of both muscles [Pa]; zeros in place of those of electric joints.
        """
        values = np.ascontiguousarray(commands, dtype=np.float64)
        if values.shape != (len(self.moving), 2) or ticks < 1:
            raise ParameterError(
                f"commands of shape {values.shape} for {ticks} periods: the moving joints {self.moving} take "
                f"({len(self.moving)}, 2), two numbers a joint, for 1 period or more.",
                shape=values.shape,
                ticks=ticks,
            )
        seen = self._loop.act(values, self._pressures, ticks)
        if max(map(abs, self._angles.tolist())) > self._least:
            refuse_beyond(self.robot, self.moving, self.data.qpos[None])
        return seen

    @property
    def angles(self) -> Array:
        """True angles, (n,). [rad]"""
        return np.array(self._angles)
