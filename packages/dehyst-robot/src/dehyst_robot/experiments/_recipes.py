"""Compensators of the experiment by name: what is logged, and what is identified, for each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from dehyst.errors import ParameterError

PLAY, DIRECT = "pi", "direct-inverse"
CREEP = (
    4.0,
    25.0,
    150.0,
)  # [s], a factor of 6 apart; none of them is a time constant of the simulated muscles


@dataclass(frozen=True)
class Recipe:
    """How a compensator is identified and used.

    Attributes
    ----------
    summary
        One line for ``--help`` and the report.
    family
        "pi": the paper's model, inverted; "direct-inverse": the inverse itself, in torque.
    changes
        Settings that differ from the robot's file.
    local
        The backbone is the polynomial through the loop at the mean pressure, not the calibrated A, B, C.
    log
        Which motions are logged: "loops", the decaying ones; "rates", these and strokes of several speeds with rests;
        "pressures", these, and the loops at other mean pressures.
    time_constants
        Of the creep of a direct inverse. [s]
    schedules
        What its weights depend on from outside: "mean_pressure". On the angle they depend if the log says so.
    adaptive
        Whether the scales of its groups are learned while it runs.
    passes
        Repetitions of the path from which a torque along the path is learned.
    stops_only
        A direct inverse of stop operators alone: the Maxwell-slip model of Vo-Minh et al. in torque over the angle.
    odd
        The paper's model has neither offset nor centre, H[-x] = -H[x], and its states are zero at the start, of the log
        and of a trial: equations (2) and (13) as they are printed.
    """

    summary: str
    family: str = PLAY
    changes: Mapping[str, object] = field(default_factory=lambda: MappingProxyType({}), hash=False)
    local: bool = False
    log: str = "loops"
    time_constants: tuple[float, ...] = ()
    schedules: tuple[str, ...] = ()
    adaptive: bool = False
    passes: int = 0
    stops_only: bool = False
    odd: bool = False

    @property
    def direct(self) -> bool:
        """Whether a direct inverse is identified."""
        return self.family == DIRECT


def _direct(summary: str, log: str = "rates", **more: Any) -> Recipe:
    return Recipe(summary, DIRECT, log=log, **more)


# With k = 1 bar/rad the first weight ends at the paper's bound, and the compensator steps by 999 bar/rad after a
# reversal. Cross-validation of the inverse chose 5, 10 and 20 for three mechanisms (decision 27).
STEEPER = MappingProxyType({"compensator.shear_bar_rad": 10.0})
# What the paper says of its model, whatever the robot's file says.
PRINTED = MappingProxyType(
    {
        "compensator.shear_bar_rad": 1.0,
        "compensator.operators": 100,
        "compensator.eps": 0.001,
    }
)
RECIPES: Mapping[str, Recipe] = MappingProxyType(
    {
        "paper": Recipe("the paper's, on the calibrated characteristic A, B, C"),
        "literal": Recipe(
            "the paper read literally, on a polynomial through the loop at 3 bar", local=True
        ),
        "printed": Recipe(
            "literal, its model as printed: no offset, no centre, states zero at the start",
            changes=PRINTED,
            local=True,
            odd=True,
        ),
        "scaled": Recipe("the paper's with k = 10 bar/rad instead of 1", changes=STEEPER),
        "direct": _direct(
            "the inverse itself, in torque: stops, path lags, viscosity, no creep", log="loops"
        ),
        "creep": _direct(
            "direct with creep, from a log of several speeds with rests", time_constants=CREEP
        ),
        "scheduled": _direct(
            "creep, weights over the mean pressure, from logs at several ones",
            log="pressures",
            time_constants=CREEP,
            schedules=("mean_pressure",),
        ),
        "adaptive": _direct(
            "creep, learning its scales while it runs", time_constants=CREEP, adaptive=True
        ),
        "ilc": _direct(
            "creep, and a torque learned along the path from repeated passes",
            time_constants=CREEP,
            passes=4,
        ),
        "maxwell-slip": _direct(
            "Vo-Minh's: stop operators alone, in torque over the angle",
            log="loops",
            stops_only=True,
        ),
        # From the longer log it errs less with four mechanisms, and more, or is not accepted, with the other three
        # (docs/explanation/the-paper-and-this-repository.md).
        "best": _direct(
            "adaptive, from the log that the paper's is identified from",
            log="loops",
            time_constants=CREEP,
            adaptive=True,
        ),
    }
)
NAMES = tuple(RECIPES)


def recipe(name: str) -> Recipe:
    """Return the recipe of a compensator."""
    if name not in RECIPES:
        raise ParameterError(
            f"no compensator '{name}'. There are: {', '.join(NAMES)}; one of your own goes through Python: "
            f"run_trial(..., Equipment(own={{1: my_compensator}})).",
            name=name,
        )
    return RECIPES[name]
