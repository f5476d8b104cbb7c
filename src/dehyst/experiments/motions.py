"""What a joint is made to do for its identification: angles over time."""

from __future__ import annotations

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.evaluation import UNSEEN_TIPS, loops
from dehyst.experiments.quasistatic import SPACING
from dehyst.plant.parameters import Robot


def motion_of(robot: Robot, number: int, log: str) -> Array:
    """Return the angles (K,) of an identification at knots of `SPACING`: "loops", or "rates", loops first. [rad]

    Examples
    --------
    >>> from dehyst.plant.parameters import load_robot
    >>> [round(motion_of(load_robot(), 1, log).size * SPACING) for log in ("loops", "rates")]
    [270, 764]
    """
    reach = robot.identification.range_share * robot.joint(number).range
    parts = [_loops(robot), *([_rates(robot)] if log == "rates" else [])]
    return np.asarray(reach * np.concatenate(parts))


def unseen_motion(robot: Robot, number: int) -> Array:
    """Return loops (K,) that no identification contains. [rad]"""
    settings = robot.identification
    reach = settings.range_share * robot.joint(number).range
    return np.asarray(reach * loops(UNSEEN_TIPS, settings.loop, settings.hold, SPACING).value)


def _loops(robot: Robot) -> Array:
    """The decaying loops twice, the second time smaller."""
    settings = robot.identification
    seen = loops(settings.tips, settings.loop, settings.hold, SPACING).value
    return np.concatenate([seen, settings.second_share * seen])


def _rates(robot: Robot) -> Array:
    """The same few loops at several speeds with rests of several lengths: nothing else tells what depends on time."""
    settings = robot.identification
    if len(settings.strokes) != len(settings.rests):
        raise ParameterError(
            f"identification.strokes_s has {len(settings.strokes)} values and rests_s {len(settings.rests)}: the loops "
            f"are run once for every pair. Give as many of one as of the other."
        )
    pairs = zip(settings.strokes, settings.rests, strict=True)
    return np.concatenate([loops(settings.rate_tips, 2 * (s + r), r, SPACING).value for s, r in pairs])
