"""Gymnasium environments of the simulated robot: reach angles, or follow them, with muscles that have hysteresis."""

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
# Of a path to follow: share of strokes that a rest follows, its length [s], largest acceleration [rad/s^2].
REST_SHARE, REST_SECONDS, MOST_ACCELERATION = 0.25, 0.5, 10.0
# float32, as policies of machine learning expect it
Values = npt.NDArray[np.float32]


class ReachEnv(gymnasium.Env[Values, Values]):
    """Bring the joints to angles drawn at each reset, and hold them there.

    Registered by the import of this module: ``gymnasium.make("dehyst_robot.environment:dehyst/Joint-v0")``.
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
        numbers = (
            isinstance(ticks, (int, np.integer))
            and isinstance(seconds, (int, float))
            and isinstance(reach, (int, float))
        )
        if not numbers or ticks < 1 or not 0.0 < seconds < math.inf or not 0.0 < reach <= 1.0:
            raise ParameterError(
                f"ticks = {ticks!r:.20}, seconds = {seconds!r:.20}, reach = {reach!r:.20} make no episode. Pass a "
                f"whole number of ticks from 1 on, a positive length in seconds, and a reach from above 0 to 1, a "
                f"share of the joints' range."
            )
        if joints is not None and not isinstance(joints, (tuple, list)):
            raise ParameterError(
                f"joints = {joints!r:.40} are no numbers of joints; pass a tuple, such as (1,)."
            )
        self.drives = Drives(robot, joints and tuple(joints), pressures=pressures)
        moving = [robot.joint(number) for number in self.drives.moving]
        n = len(moving)
        muscles = np.array([joint.pneumatic for joint in moving])
        self._range = np.array([joint.range for joint in moving])
        self._ticks = ticks
        self._reach = reach
        self._steps = max(1, round(seconds / (ticks * self.drives.period)))
        self._done = 0
        self._targets = np.zeros((1, n))

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
        self._lead = self._observed_ahead(ticks * self.drives.period)
        self._ahead = slice(n, n + n * len(self._lead))
        self._observation = np.zeros(self._ahead.stop + self._columns.size)
        self.observation_space = Box(-10.0, 10.0, (self._observation.size,), np.float32)
        self.action_space = Box(-1.0, 1.0, (self._used.size,), np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Values, dict[str, Any]]:
        """Begin an episode at rest in the zero pose, with a new target and new noise."""
        super().reset(seed=seed)
        readings = self.drives.reset(int(self.np_random.integers(1 << 31)))
        at_rest = readings[:, 0] / self._range
        self._targets = self._drawn()
        self._done = 0
        self._observation[self._ahead.stop : self._ahead.stop + at_rest.size] = at_rest
        return self._observed(readings), self._info()

    def _observed_ahead(self, step: float) -> tuple[int, ...]:
        """How many steps of a length [s] the targets are ahead that an observation shows."""
        return (0,)

    def _drawn(self) -> Array:
        """Target angles after each step, (steps, n) or one row for all of them. [rad]"""
        return self._reach * self._range * self.np_random.uniform(-1.0, 1.0, (1, self._range.size))

    def _target(self, ahead: int = 0) -> Array:
        """Target angles (n,) so many steps ahead; at the end the last one stays. [rad]"""
        row: Array = self._targets[min(self._done + ahead, len(self._targets) - 1)]
        return row

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
        self._done += 1
        self._commands[self._used] = self._shift + self._scale * limited
        # A joint that leaves the simulated range ends the episode, with the observation before it.
        terminated = False
        try:
            readings = self.drives.step(self._commands.reshape(-1, 2), self._ticks)
            observation = self._observed(readings)
        except SimulationError:
            observation = self._observation.astype(np.float32)
            terminated = True
        info = self._info()
        reward = -sum(map(abs, info["error_deg"].tolist())) / self._range.size
        return observation, reward, terminated, self._done >= self._steps, info

    def _observed(self, readings: Array) -> Values:
        """Update the observation in place, which costs less in each step than a new array."""
        n, begin = self._range.size, self._ahead.stop
        now = self._observation
        before = now[begin : begin + n].copy()
        np.multiply(readings.ravel()[self._columns], self._reading_scale, out=now[begin:])
        np.multiply(now[begin : begin + n] - before, 10.0, out=now[:n])
        for k, ahead in enumerate(self._lead):
            now[n + k * n : 2 * n + k * n] = self._target(ahead) / self._range
        return np.minimum(np.maximum(now, -10.0), 10.0).astype(np.float32)

    def _info(self) -> dict[str, Any]:
        angle = self.drives.angles * DEGREES
        return {"angle_deg": angle, "error_deg": self._target() * DEGREES - angle}


class TrackEnv(ReachEnv):
    """Follow angles that move: smooth strokes between tips drawn at each reset, with rests behind some of them.

    Registered as ``dehyst_robot.environment:dehyst/JointTrack-v0``. As `ReachEnv`, but a stroke from q_0 to q_1 in the
    time T goes

        q(t) = q_0 + (q_1 - q_0) (10 s^3 - 15 s^4 + 6 s^5),   s = t / T

    which is the path of minimum jerk (Flash and Hogan, 1985). An observation shows two targets for each joint: the
    angle to have at the end of the coming step, and the one `preview` seconds later, as a controller knows its path.
    For n joints it is: changes (n), targets at the end of the step (n), targets `preview` later (n), angles (n),
    pressures. Of the two actions of a joint with muscles the first one fills the muscle that raises the angle.

    Parameters
    ----------
    robot, joints
        As `ReachEnv`; ``more`` are pressures, ticks, seconds and reach.
    speed
        Lowest and highest mean speed of a stroke. [rad/s]
    preview
        How far ahead the second target is. [s]

    Raises
    ------
    ParameterError
        If speed or preview are no times and speeds, or as `ReachEnv`.

    Examples
    --------
    >>> env = TrackEnv(joints=(1,), seconds=2.0)
    >>> observation, _ = env.reset(seed=3)
    >>> observation.shape, env.path.shape
    ((6,), (400, 1))
    """

    def __init__(
        self,
        robot: Robot | None = None,
        joints: tuple[int, ...] | None = (1,),
        *,
        speed: tuple[float, float] = (0.1, 1.0),
        preview: float = 0.1,
        seconds: float = 10.0,
        **more: Any,
    ) -> None:
        try:
            low, high = map(float, speed)
            usable = 0.0 < low <= high < math.inf and 0.0 <= preview < math.inf
        except (TypeError, ValueError):
            usable = False
        if not usable:
            raise ParameterError(
                f"speed = {speed!r:.60} and preview = {preview!r:.20} make no path. Pass the lowest and then the "
                f"highest speed in rad/s, above 0, and a preview of 0 s or more."
            )
        self._speed, self._preview = speed, preview
        super().__init__(robot, joints, seconds=seconds, **more)

    def _observed_ahead(self, step: float) -> tuple[int, ...]:
        return (1, 1 + round(self._preview / step))

    @property
    def path(self) -> Array:
        """Target angles after each step of the episode, (steps, n). [rad]"""
        return self._targets[1:]

    def _drawn(self) -> Array:
        step = self._ticks * self.drives.period
        columns = []
        for reach in (self._reach * self._range).tolist():
            columns.append(self._strokes(reach, step))
        return np.column_stack(columns)

    def _strokes(self, reach: float, step: float) -> Array:
        """Angle of one joint at the begin and after each step. [rad]"""
        parts = [np.zeros(1)]
        size, at = 1, 0.0
        while size <= self._steps:
            tip = float(self.np_random.uniform(-reach, reach))
            speed = float(self.np_random.uniform(*self._speed))
            way = abs(tip - at)
            # The largest acceleration of such a stroke is 10 / sqrt(3) times its way over the square of its time.
            time = max(way / speed, math.sqrt(10.0 / math.sqrt(3.0) * way / MOST_ACCELERATION))
            steps = max(2, math.ceil(time / step))
            s = np.arange(1, steps + 1) / steps
            parts.append(at + (tip - at) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
            # Every fourth stroke or so is followed by a rest of half a second, where creep shows.
            if self.np_random.random() < REST_SHARE:
                parts.append(np.full(max(1, round(REST_SECONDS / step)), tip))
            size, at = sum(map(len, parts)), tip
        return np.concatenate(parts)[: self._steps + 1]


gymnasium.register("dehyst/Joint-v0", entry_point=f"{__name__}:ReachEnv")
gymnasium.register("dehyst/JointTrack-v0", entry_point=f"{__name__}:TrackEnv")
