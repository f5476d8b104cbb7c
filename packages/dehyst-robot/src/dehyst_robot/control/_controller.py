"""User-defined controllers, in Python, in the place of the paper's controller of a joint."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol, runtime_checkable

from dehyst.errors import OutputError, ParameterError
from dehyst_robot.control._joint import JointReference


class Reading(NamedTuple):
    """Readings of a joint: encoder [rad], gauge pressures of both muscles [Pa]."""

    angle: float
    pressure_1: float
    pressure_2: float


@runtime_checkable
class Controller(Protocol):
    """Two methods that make a controller of a joint; any class that has them is one.

    It is called once a period of the simulation, 0.5 ms, and returns the commands of both valves. One that runs more
    slowly counts the periods and repeats its last commands. A call costs about 2 us beside its own work.

    Examples
    --------
    A PI controller of the angle with proportional control of the pressures, on joint 1:

    >>> class MyController:
    ...     def reset(self, reading: Reading, period: float) -> None:
    ...         self.period, self.sum = period, 0.0
    ...     def step(self, reading: Reading, reference: JointReference) -> tuple[float, float]:
    ...         error = reference.angle - reading.angle
    ...         self.sum += 40.0 * error * self.period
    ...         difference = 3.0 * error + self.sum - (reading.pressure_1 - reading.pressure_2) / 1e5
    ...         return 0.3 * difference, -0.3 * difference
    >>> isinstance(MyController(), Controller)
    True
    """

    def reset(self, reading: Reading, period: float) -> None:
        """Start at rest at these readings: the first `step` follows at once. `period`: of the calls. [s]"""

    def step(self, reading: Reading, reference: JointReference) -> tuple[float, float]:
        """Return the commands of both valves, -1..1: positive fills the muscle, commands beyond 1 are limited.

        `reference.extra` is what the compensator adds to the pressure difference, 0 while there is none. [Pa]
        """


# A controller as the loop in C calls it: readings and reference, None for a reset -> commands of both valves.
Seat = Callable[[tuple[float, float, float], tuple[float, ...] | None], tuple[float, float]]


def seated(controller: Controller, number: int, period: float) -> Seat:
    """Return a controller as the closed loop calls it: with plain numbers, and without a reference for a reset.

    Raises
    ------
    ParameterError
        If it lacks a method.
    OutputError
        From the loop, if it does not return two finite numbers.
    """
    # A class has the methods, too, but nothing to call them on.
    if isinstance(controller, type):
        name = controller.__name__
        raise ParameterError(
            f"{name} is a class: pass a controller of joint {number}, {name}().", joint=number
        )
    if not isinstance(controller, Controller):
        raise ParameterError(
            f"a {type(controller).__name__} is no controller of joint {number}: give it reset(reading, period) and "
            f"step(reading, reference) -> (valve_1, valve_2).",
            joint=number,
        )

    def commands(
        readings: tuple[float, float, float], reference: tuple[float, ...] | None
    ) -> tuple[float, float]:
        if reference is None:
            controller.reset(Reading(*readings), period)
            return 0.0, 0.0
        answer = controller.step(Reading(*readings), JointReference(*reference))
        # What a user's method returns may be anything: all of it becomes one message.
        try:
            first, second = answer
            first, second = float(first), float(second)
        except (TypeError, ValueError):
            first = second = math.nan
        if not math.isfinite(first + second):
            raise OutputError(
                f"{type(controller).__name__}.step of joint {number} answered {answer!r:.60} at a wanted angle of "
                f"{reference[0]:g} rad; it must be two finite numbers, because they go to the valves: return "
                f"valve_1, valve_2, from -1 to 1.",
                joint=number,
            )
        return first, second

    return commands
