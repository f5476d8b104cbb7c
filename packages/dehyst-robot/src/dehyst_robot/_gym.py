"""Makes the Gymnasium environment of a robot; gymnasium is imported when one is made."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dehyst_robot.arm import Robot
    from dehyst_robot.environment import ReachEnv


def gym(robot: Robot | None = None, joints: tuple[int, ...] | None = (1,), **more: Any) -> ReachEnv:
    """Return the environment `dehyst_robot.environment.ReachEnv` of a robot.

    Raises
    ------
    MissingExtraError
        If gymnasium is not installed: ``pip install 'dehyst-robot[gym]'``.

    Examples
    --------
    >>> gym(joints=(1, 2)).action_space.shape
    (4,)
    """
    # gymnasium is an extra: only who makes an environment needs it.
    from dehyst_robot.environment import ReachEnv

    return ReachEnv(robot, joints, **more)
