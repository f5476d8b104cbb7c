"""Slow a motion down just enough for the limits of what has to run it."""

from __future__ import annotations

import math
from collections.abc import Callable

from dehyst.errors import ParameterError
from dehyst.robot.iso9283.timing import Timed


def slow_down_to(
    motion: Timed,
    utilisation: Callable[[Timed], float],
    tolerance: float = 0.01,
    largest: float = 100.0,
) -> Timed:
    """Slow a motion down just enough for its limits.

    Finds the smallest factor f >= 1 at which the utilisation is at most 1, to within `tolerance` of f: a bracket is
    divided where the model u = c + d/f^2 through its ends (static load and inertia) says, every third time in the
    middle. The factor returned has been evaluated and keeps the limits.

    Parameters
    ----------
    motion
        The motion as fast as wanted.
    utilisation
        Largest use of a limit by a motion: required pressure over the largest pressure, valve flow over the largest
        flow. It must fall as the motion gets slower.
    tolerance
        Relative width of the bracket at which to stop.
    largest
        Largest factor to try.

    Returns
    -------
    Timed
        `motion` itself, or a slower one.

    Raises
    ------
    ParameterError
        If the limits are broken even at the largest factor: then it is the load, not the speed. If the utilisation is
        not a finite number.

    Examples
    --------
    >>> from dehyst.robot.iso9283.cube import TestCube, test_path
    >>> from dehyst.robot.iso9283.timing import timed
    >>> fast = timed(test_path(TestCube(0.4, [0.6, 0.0, 0.9]), 0.03), 0.25, 2.0, 40.0, rest=1.0)
    >>> slower = slow_down_to(fast, lambda motion: 0.5 + 2.0 / motion.factor**2)
    >>> 2.0 <= slower.factor <= 2.02
    True
    """

    def use(factor: float) -> float:
        value = float(utilisation(motion.slower(factor)))
        if not math.isfinite(value):
            raise ParameterError(f"the utilisation at {factor:g} times the duration is {value}; it must be a number.")
        return value

    low, use_low = 1.0, use(1.0)
    if use_low <= 1.0:
        return motion
    high = min(1.2 * math.sqrt(use_low), largest)
    use_high = use(high)
    while use_high > 1.0:
        if high >= largest:
            raise ParameterError(
                f"the path breaks the limits by a factor of {use_high:.3g} even at {largest:g} times the duration, so "
                f"it is the load and the posture, not the speed. Move the test cube, make it smaller, or lower the "
                f"payload.",
                utilisation=use_high,
            )
        low, use_low, high = high, use_high, min(2.0 * high, largest)
        use_high = use(high)
    nudge, tries = 1.0 + 0.4 * tolerance, 0
    while high > low * (1.0 + tolerance):
        tries += 1
        factor = _inertial_guess(low, use_low, high, use_high) * nudge
        if tries % 3 == 0 or not low < factor < high:  # whatever the model is worth, the bracket shrinks
            factor = math.sqrt(low * high)
        value = use(factor)
        if value <= 1.0:
            high, use_high, nudge = factor, value, 1.0 - 0.4 * tolerance
        else:
            low, use_low, nudge = factor, value, 1.0 + 0.4 * tolerance
    return motion.slower(high)


def _inertial_guess(low: float, use_low: float, high: float, use_high: float) -> float:
    """Return f with u(f) = 1 for u = c + d/f^2 through both ends of the bracket."""
    x_low, x_high = low**-2.0, high**-2.0
    x = x_high + (1.0 - use_high) * (x_low - x_high) / (use_low - use_high)  # use_low > 1 >= use_high
    return math.sqrt(1.0 / x)
