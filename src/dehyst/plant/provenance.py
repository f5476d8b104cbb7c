"""Where the numbers of the packaged parameter file come from, and which of them were changed."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from dehyst.plant.parameters import PACKAGED, Robot, load_robot

_TABLE = re.compile(r"\[([\w.-]+)\]")
_VALUE = re.compile(r"([\w-]+)\s*=\s*[^#]*#\s*(.*)")


@cache
def sources() -> dict[str, str]:
    """Return what the packaged file says beside each number: dotted key -> meaning, source or "assumption".

    Examples
    --------
    >>> sources()["sensors.encoder_bits"]
    '[1]'
    """
    found: dict[str, str] = {}
    table = ""
    for line in PACKAGED.read_text(encoding="utf-8").splitlines():
        if heading := _TABLE.match(line):
            table = heading[1]
        elif value := _VALUE.match(line):
            found[f"{table}.{value[1]}"] = value[2].strip()
    return found


def changes_from_packaged(robot: Robot) -> dict[str, Any]:
    """Return the values, by dotted key, in which a robot differs from the packaged one.

    Examples
    --------
    >>> changes_from_packaged(load_robot(changes={"hysteresis.scale": 1.5}))
    {'hysteresis.scale': 1.5}
    """
    packaged = dict(_leaves(load_robot().values))
    return {key: value for key, value in _leaves(robot.values) if packaged.get(key) != value}


def _leaves(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value
