"""Parameters that a sweep can change: values of the robot's parameter file, and settings of a run."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from dehyst.errors import ParameterError
from dehyst.robot.arm import Robot, load_robot
from dehyst.robot.arm.validation import known_keys, shown

# Settings of a run that are no parameters of the robot: name -> value if nothing is said, and values allowed.
RUN_SETTINGS: Mapping[str, tuple[Any, tuple[str, ...] | None]] = {
    "load_Nm": (0.0, None),  # constant torque on the joint; known to the plant, unknown to the controller
    "initial_state": ("homed", ("homed", "unknown", "ramped")),  # of the hysteresis, when a trial begins
    "identified_on": ("here", ("here", "default")),  # the robot that is run, or the one without changes of its plant
    "run_mean_pressure_bar": (0.0, None),  # of the trials, whatever it was in the identification; 0: the same
    "time_constants_factor": (1.0, None),  # of the creep that a compensator is offered
    "passes": (-1, None),  # from which iterative learning learns; -1: as many as its recipe says
}
LARGEST_LOAD = 1000.0
MOST_CHECKED = 1000  # sets of parameters that are tried on the robot beforehand, about a second


@dataclass(frozen=True, eq=False)
class Keys:
    """The keys a sweep can set, and what they are when it does not.

    Attributes
    ----------
    robot
        The robot whose parameters they are.
    """

    robot: Robot = field(default_factory=load_robot)

    @cached_property
    def nominal(self) -> Mapping[str, Any]:
        """Dotted key -> value if nothing is said.

        Examples
        --------
        >>> Keys().nominal["hysteresis.scale"], Keys().nominal["initial_state"]
        (1.0, 'homed')
        """
        return flatten(self.robot.values) | {name: default for name, (default, _) in RUN_SETTINGS.items()}

    @cached_property
    def names(self) -> frozenset[str]:
        """All keys."""
        return frozenset([*known_keys(self.robot.values), *RUN_SETTINGS]) - {"name"}

    @cached_property
    def foreign(self) -> Mapping[str, Any]:
        """Changes that make the packaged robot this one: whole tables by name."""
        packaged = load_robot().values
        return {name: table for name, table in self.robot.values.items() if table != packaged.get(name)}

    def checked(self, key: str, value: Any, where: str) -> Any:
        """Return a value for a key; a whole number as a float where the robot's own value is one.

        Raises
        ------
        ParameterError
            If there is no such key, or a run setting cannot have that value.
        """
        if key not in self.names:
            raise ParameterError(f"{where}: {self._no_such(key)}", key=key)
        if key in RUN_SETTINGS:
            _check_setting(key, value, where)
        if isinstance(self.nominal.get(key), float) and type(value) is int and abs(value) < 1 << 53:
            return float(value)
        return value

    def _no_such(self, key: str) -> str:
        close = difflib.get_close_matches(key, self.names, 3, 0.5)
        if not close:  # the end of the key may be right and its table wrong
            close = sorted(name for name in self.names if name.rpartition(".")[2] == key.rpartition(".")[2])[:3]
        near = f"Did you mean {' or '.join(close)}? " if close else ""
        return (
            f"there is no parameter {shown(key)}. {near}Parameters are the keys of the robot's file with their table, "
            f"for example hysteresis.scale, and {', '.join(RUN_SETTINGS)}."
        )

    def try_on(self, sets: Iterable[tuple[str, Mapping[str, Any]]]) -> None:
        """Build the robot for sets of changes, each with its place in the file, and let it refuse what it cannot be.

        The first thousand are built, later ones only if they hold a value of a kind not seen before, a text say. What
        is not found here fails on its own, as a row of the table.

        Raises
        ------
        ParameterError
            At the first value, or set of values, that is not physical.
        """
        seen: set[tuple[str, str]] = set()
        for number, (where, changes) in enumerate(sets):
            told = {(key, shown(value)) for key, value in changes.items() if not isinstance(value, float)}
            if number >= MOST_CHECKED and told <= seen:
                continue
            seen |= told
            try:
                self.robot.with_changes(changes)
            except ParameterError as fault:
                raise ParameterError(f"{where}: {str(fault).removeprefix('robot: ')}", **fault.facts) from None


def keys_of_file(path: Path) -> Keys:
    """Return the keys for a robot of one's own."""
    return Keys(load_robot(path))


def flatten(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested tables as one with dotted keys.

    Examples
    --------
    >>> flatten({"valve": {"mpye": {"leak": 0.02}}, "name": "arm"})
    {'valve.mpye.leak': 0.02, 'name': 'arm'}
    """
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            flat |= flatten(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def _check_setting(key: str, value: Any, where: str) -> None:
    allowed = RUN_SETTINGS[key][1]
    if allowed is not None:
        if value not in allowed:
            raise ParameterError(f"{where}: {key} is {shown(value)}, but it is one of: {', '.join(allowed)}.", key=key)
        return
    number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    if not number or abs(value) > LARGEST_LOAD:
        raise ParameterError(
            f"{where}: {key} is {shown(value)}, but must be a number between -{LARGEST_LOAD:g} and {LARGEST_LOAD:g}.",
            key=key,
        )
