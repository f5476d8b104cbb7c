"""Makes the Gymnasium environment of a robot; gymnasium is imported when one is made."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dehyst.robot.arm.parameters import Robot
    from dehyst.robot.environment import ReachEnv


def gym(robot: Robot | None = None, joints: tuple[int, ...] | None = (1,), **more: Any) -> ReachEnv:
    """Return the environment `dehyst.robot.environment.ReachEnv` of a robot.

    Raises
    ------
    MissingExtraError
        If gymnasium is not installed: ``pip install 'dehyst[gym]'``.

    Examples
    --------
    >>> gym(joints=(1, 2)).action_space.shape
    (4,)
    """
    from dehyst.robot.environment import ReachEnv

    return ReachEnv(robot, joints, **more)
