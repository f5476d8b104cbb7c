"""Controllers of one's own, in Python, in the place of the paper's controller of a joint."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol, runtime_checkable

from dehyst.errors import OutputError, ParameterError
from dehyst.robot.control.joint import JointReference


class Reading(NamedTuple):
    """What the sensors of a joint show: encoder [rad], gauge pressures of both muscles [Pa]."""

    angle: float
    pressure_1: float
    pressure_2: float


@runtime_checkable
class Controller(Protocol):
    """Two methods that make a controller of a joint; any class that has them is one.

    It is asked once a period of the simulation, 0.5 ms, and answers the commands of both valves. One that runs more
    slowly counts the periods and repeats its last answer. A call costs some 2 us beside its own work.

    Examples
    --------
    A PI controller of the angle with proportional control of the pressures, on joint 1:

    >>> class MyController:
    ...     def reset(self, seen: Reading, period: float) -> None:
    ...         self.period, self.sum = period, 0.0
    ...     def step(self, seen: Reading, wanted: JointReference) -> tuple[float, float]:
    ...         error = wanted.angle - seen.angle
    ...         self.sum += 40.0 * error * self.period
    ...         difference = 3.0 * error + self.sum - (seen.pressure_1 - seen.pressure_2) / 1e5
    ...         return 0.3 * difference, -0.3 * difference
    >>> isinstance(MyController(), Controller)
    True
    """

    def reset(self, seen: Reading, period: float) -> None:
        """Start at rest at these readings: the first `step` follows at once. `period`: of the calls. [s]"""

    def step(self, seen: Reading, wanted: JointReference) -> tuple[float, float]:
        """Return the commands of both valves, -1..1: positive fills the muscle, beyond 1 is limited.

        `wanted.extra` is what the compensator adds to the pressure difference, 0 while there is none. [Pa]
        """


Seat = Callable[[tuple[float, float, float], tuple[float, ...] | None], tuple[float, float]]


def seated(controller: Controller, number: int, period: float) -> Seat:
    """Return a controller as the closed loop calls it: with bare numbers, no reference for a reset.

    Raises
    ------
    ParameterError
        If it lacks a method.
    OutputError
        From the loop, if an answer is not two finite numbers.
    """
    if isinstance(controller, type):
        name = controller.__name__
        raise ParameterError(f"{name} is a class: pass a controller of joint {number}, {name}().", joint=number)
    if not isinstance(controller, Controller):
        raise ParameterError(
            f"a {type(controller).__name__} is no controller of joint {number}: give it reset(seen, period) and "
            f"step(seen, wanted) -> (valve_1, valve_2).",
            joint=number,
        )

    def asked(seen: tuple[float, float, float], wanted: tuple[float, ...] | None) -> tuple[float, float]:
        if wanted is None:
            controller.reset(Reading(*seen), period)
            return 0.0, 0.0
        answer = controller.step(Reading(*seen), JointReference(*wanted))
        try:
            first, second = answer
            first, second = float(first), float(second)
        except (TypeError, ValueError):
            first = second = math.nan
        if not math.isfinite(first + second):
            raise OutputError(
                f"{type(controller).__name__}.step of joint {number} answered {answer!r:.60} at a wanted angle of "
                f"{wanted[0]:g} rad; it must be two finite numbers, because they go to the valves: return "
                f"valve_1, valve_2, from -1 to 1.",
                joint=number,
            )
        return first, second

    return asked
