"""A Gymnasium environment of the simulated robot: reach angles with muscles that have hysteresis."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import MissingExtraError, ParameterError, SimulationError
from dehyst.robot.arm.drives import Drives
from dehyst.robot.arm.parameters import Robot, load_robot

try:
    import gymnasium
    from gymnasium.spaces import Box
except ImportError as fault:
    raise MissingExtraError(
        f"an environment of the robot needs the package gymnasium, which is not installed ({fault}). Type: pip install "
        f"'dehyst[gym]' - or drive the robot with dehyst.Drives.",
        extra="gym",
    ) from None

DEGREES = 180.0 / np.pi
Values = npt.NDArray[np.float32]


class ReachEnv(gymnasium.Env[Values, Values]):
    """Bring the joints to angles drawn at each reset, and hold them there.

    Observation, float32: changes of the angles since the last step times 10, wanted angles, angles, each a share of the
    joint's range; then both pressures of each joint with muscles, as shares of the largest. Action, -1..1: two valves
    for each joint with muscles (or two pressures, from the lowest to the highest), the angle as a share of its range
    for an electric one. Reward: minus the mean distance of the joints from the wanted angles. [deg]
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
        Largest wanted angle, as a share of the range.

    Raises
    ------
    ParameterError
        If there is no such joint, or ticks, seconds or reach make no episode.

    Examples
    --------
    >>> env = ReachEnv(joints=(1,))
    >>> seen, _ = env.reset(seed=3)
    >>> seen.shape, env.action_space.shape
    ((5,), (2,))
    >>> _, reward, terminated, truncated, told = env.step(env.action_space.sample())
    >>> bool(reward < 0), terminated, sorted(told)
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
        chosen = [robot.joint(number) for number in self.drives.moving]
        n, muscles = len(chosen), np.array([joint.pneumatic for joint in chosen])
        self._range = np.array([joint.range for joint in chosen])
        self._ticks, self._reach = ticks, reach
        self._steps = max(1, round(seconds / (ticks * self.drives.period)))
        low, high = robot.controller.pressure_low, robot.controller.pressure_high
        self._middle, self._half = (0.5 * (low + high), 0.5 * (high - low)) if pressures else (0.0, 1.0)
        used = np.column_stack([np.ones(n, bool), muscles])  # an electric joint takes one number
        self._used = np.flatnonzero(used)
        scale = np.where(muscles[:, None], [[self._half] * 2], self._range[:, None])
        self._scale = scale.ravel()[self._used]
        self._shift = np.where(muscles[:, None], [[self._middle] * 2], 0.0).ravel()[self._used]
        self._commands = np.zeros(2 * n)
        self._from = np.concatenate([np.arange(n) * 3, (np.flatnonzero(muscles)[:, None] * 3 + [1, 2]).ravel()])
        self._seen_scale = np.concatenate([1.0 / self._range, np.full(2 * int(muscles.sum()), 1.0 / high)])
        self._seen = np.zeros(2 * n + self._from.size)  # change, target, angle, pressures
        self.observation_space = Box(-10.0, 10.0, (self._seen.size,), np.float32)
        self.action_space = Box(-1.0, 1.0, (self._used.size,), np.float32)
        self._left, self._wanted = 0, np.zeros(n)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Values, dict[str, Any]]:
        """Begin an episode at rest in the zero pose, with a new target and new noise."""
        super().reset(seed=seed)
        seen = self.drives.reset(int(self.np_random.integers(1 << 31)))
        n = self._range.size
        self._wanted = self._reach * self._range * self.np_random.uniform(-1.0, 1.0, n)
        self._left = self._steps
        self._seen[n : 2 * n] = self._wanted / self._range
        self._seen[2 * n : 3 * n] = seen[:, 0] / self._range
        return self._observed(seen), self._told()

    def step(self, action: Values) -> tuple[Values, float, bool, bool, dict[str, Any]]:
        """Hold an action for a step.

        Raises
        ------
        ParameterError
            If the action has another shape, or a number that is not finite: a policy that diverged.
        """
        asked = np.asarray(action)
        if asked.shape != self._used.shape or not math.isfinite(sum(asked.tolist())):
            raise ParameterError(
                f"the action {action!r:.80} is not {self._used.size} finite numbers from -1 to 1. Look for nan in what "
                f"chose it, or for a batch of actions where one is taken."
            )
        held = np.minimum(np.maximum(asked, -1.0), 1.0)
        self._commands[self._used] = self._shift + self._scale * held
        try:
            observed, lost = self._observed(self.drives.step(self._commands.reshape(-1, 2), self._ticks)), False
        except SimulationError:
            observed, lost = self._seen.astype(np.float32), True
        self._left -= 1
        told = self._told()
        reward = -sum(map(abs, told["error_deg"].tolist())) / self._range.size
        return observed, reward, lost, self._left <= 0, told

    def _observed(self, seen: Array) -> Values:
        n, now = self._range.size, self._seen
        before = now[2 * n : 3 * n].copy()
        np.multiply(seen.ravel()[self._from], self._seen_scale, out=now[2 * n :])
        np.multiply(now[2 * n : 3 * n] - before, 10.0, out=now[:n])
        return np.minimum(np.maximum(now, -10.0), 10.0).astype(np.float32)

    def _told(self) -> dict[str, Any]:
        angle = self.drives.angles * DEGREES
        return {"angle_deg": angle, "error_deg": self._wanted * DEGREES - angle}
