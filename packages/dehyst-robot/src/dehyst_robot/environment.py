"""A Gymnasium environment of the simulated robot: reach angles with muscles that have hysteresis."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import MissingExtraError, ParameterError, SimulationError
from dehyst_robot.arm import Drives, Robot, load_robot

try:
    import gymnasium
    from gymnasium.spaces import Box
except ImportError as fault:
    raise MissingExtraError(
        f"an environment of the robot needs the package gymnasium, which is not installed ({fault}). Type: pip install "
        f"'dehyst-robot[gym]' - or drive the robot with dehyst_robot.Drives.",
        extra="gym",
    ) from None

DEGREES = 180.0 / np.pi
# float32, as policies of machine learning expect it
Values = npt.NDArray[np.float32]


class ReachEnv(gymnasium.Env[Values, Values]):
    """Bring the joints to angles drawn at each reset, and hold them there.

    Observation, float32: changes of the angles since the last step times 10, target angles, angles, each a share of the
    joint's range; then both pressures of each joint with muscles, as shares of the largest. Action, -1..1: two valves
    for each joint with muscles (or two pressures, from the lowest to the highest), the angle as a share of its range
    for an electric one. Reward: minus the mean distance of the joints from the target angles. [deg]
    An episode ends when a joint leaves what is simulated, 1.25 times its range.

    Parameters
    ----------
    robot
        From `load_robot`; None: the packaged one.
    joints
        Numbers of the joints that move; None: all.
    pressures
        Whether actions are pressures, reached at once, instead of valves.
    ticks
        Periods of the simulation in a step: 10 of 0.5 ms are a controller at 200 Hz.
    seconds
        Length of an episode. [s]
    reach
        Largest target angle, as a share of the range.

    Raises
    ------
    ParameterError
        If there is no such joint, or ticks, seconds or reach make no episode.

    Examples
    --------
    >>> env = ReachEnv(joints=(1,))
    >>> observation, _ = env.reset(seed=3)
    >>> observation.shape, env.action_space.shape
    ((5,), (2,))
    >>> _, reward, terminated, truncated, info = env.step(env.action_space.sample())
    >>> bool(reward < 0), terminated, sorted(info)
    (True, False, ['angle_deg', 'error_deg'])
    """

    def __init__(
        self,
        robot: Robot | None = None,
        joints: tuple[int, ...] | None = (1,),
        *,
        pressures: bool = False,
        ticks: int = 10,
        seconds: float = 4.0,
        reach: float = 0.6,
    ) -> None:
        robot = robot or load_robot()
        if ticks < 1 or not seconds > 0.0 or not 0.0 < reach <= 1.0:
            raise ParameterError(
                f"ticks = {ticks}, seconds = {seconds:g}, reach = {reach:g} make no episode. Pass 1 tick or more, a "
                f"positive length in seconds, and a reach from above 0 to 1, a share of the joints' range."
            )
        self.drives = Drives(robot, joints, pressures=pressures)
        moving = [robot.joint(number) for number in self.drives.moving]
        n = len(moving)
        muscles = np.array([joint.pneumatic for joint in moving])
        self._range = np.array([joint.range for joint in moving])
        self._ticks = ticks
        self._reach = reach
        self._steps = max(1, round(seconds / (ticks * self.drives.period)))
        self._left = 0
        self._target = np.zeros(n)

        # An action is scaled and shifted to commands; of the two commands of an electric joint it has the first only.
        low, high = robot.controller.pressure_low, robot.controller.pressure_high
        middle, half = 0.0, 1.0
        if pressures:
            middle, half = 0.5 * (low + high), 0.5 * (high - low)
        self._used = np.flatnonzero(np.column_stack([np.ones(n, bool), muscles]))
        scale = np.where(muscles[:, None], [[half] * 2], self._range[:, None])
        self._scale = scale.ravel()[self._used]
        self._shift = np.where(muscles[:, None], [[middle] * 2], 0.0).ravel()[self._used]
        self._commands = np.zeros(2 * n)

        # Of the readings (n, 3) an observation shows all angles, then the pressures of joints with muscles.
        pressure_columns = (np.flatnonzero(muscles)[:, None] * 3 + [1, 2]).ravel()
        self._columns = np.concatenate([np.arange(n) * 3, pressure_columns])
        pressure_scale = np.full(2 * int(muscles.sum()), 1.0 / high)
        self._reading_scale = np.concatenate([1.0 / self._range, pressure_scale])
        # The order of an observation: changes of the angles, targets, angles, pressures.
        self._observation = np.zeros(2 * n + self._columns.size)
        self.observation_space = Box(-10.0, 10.0, (self._observation.size,), np.float32)
        self.action_space = Box(-1.0, 1.0, (self._used.size,), np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Values, dict[str, Any]]:
        """Begin an episode at rest in the zero pose, with a new target and new noise."""
        super().reset(seed=seed)
        readings = self.drives.reset(int(self.np_random.integers(1 << 31)))
        n = self._range.size
        self._target = self._reach * self._range * self.np_random.uniform(-1.0, 1.0, n)
        self._left = self._steps
        self._observation[n : 2 * n] = self._target / self._range
        self._observation[2 * n : 3 * n] = readings[:, 0] / self._range
        return self._observed(readings), self._info()

    def step(self, action: Values) -> tuple[Values, float, bool, bool, dict[str, Any]]:
        """Hold an action for a step.

        Raises
        ------
        ParameterError
            If the action has another shape, or a number that is not finite: a policy that diverged.
        """
        values = np.asarray(action)
        if values.shape != self._used.shape or not math.isfinite(sum(values.tolist())):
            raise ParameterError(
                f"the action {action!r:.80} is not {self._used.size} finite numbers from -1 to 1. Look for nan in what "
                f"chose it, or for a batch of actions where one is taken."
            )
        limited = np.minimum(np.maximum(values, -1.0), 1.0)
        self._commands[self._used] = self._shift + self._scale * limited
        # A joint that leaves the simulated range ends the episode, with the observation before it.
        terminated = False
        try:
            readings = self.drives.step(self._commands.reshape(-1, 2), self._ticks)
            observation = self._observed(readings)
        except SimulationError:
            observation = self._observation.astype(np.float32)
            terminated = True
        self._left -= 1
        info = self._info()
        reward = -sum(map(abs, info["error_deg"].tolist())) / self._range.size
        return observation, reward, terminated, self._left <= 0, info

    def _observed(self, readings: Array) -> Values:
        """Update the observation in place, which costs less in each step than a new array."""
        n = self._range.size
        now = self._observation
        before = now[2 * n : 3 * n].copy()
        np.multiply(readings.ravel()[self._columns], self._reading_scale, out=now[2 * n :])
        np.multiply(now[2 * n : 3 * n] - before, 10.0, out=now[:n])
        return np.minimum(np.maximum(now, -10.0), 10.0).astype(np.float32)

    def _info(self) -> dict[str, Any]:
        angle = self.drives.angles * DEGREES
        return {"angle_deg": angle, "error_deg": self._target * DEGREES - angle}
