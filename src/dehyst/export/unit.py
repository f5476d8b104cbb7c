"""A unit: a block that runs here, the numbers that a target runs it with, and the signal that compares both."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dehyst.arrays import Array
from dehyst.control.machine_block import MachineBlock
from dehyst.export.names import identifier
from dehyst.export.numbers import UnitNumbers
from dehyst.export.signal import Whole


@dataclass(frozen=True)
class Asked:
    """What a unit is wanted for: the settings of an export."""

    what: str
    real: str
    range: tuple[float, float] | None
    ramp: int
    period: float | None


@dataclass(frozen=True)
class Unit:
    """A unit of any kind.

    Attributes
    ----------
    block
        As it runs here, in double precision.
    numbers
        In the precision of the target.
    inputs, on
        Test signal, (T, m) and (T,).
    more
        (C name, meaning) of each input behind the first.
    heads
        Names of these in tables.
    middle
        A usual value of each input.
    what
        "" for what was asked for, or another name.
    period
        Between samples, if that counts. [s]
    """

    block: MachineBlock[Any]
    numbers: UnitNumbers
    inputs: Array
    on: Whole
    more: tuple[tuple[str, str], ...] = ()
    heads: tuple[str, ...] = ()
    middle: tuple[float, ...] = (0.0,)
    what: str = ""
    period: float | None = None


def c_names(names: tuple[str, ...], taken: tuple[str, ...]) -> tuple[str, ...]:
    """C names of further inputs: their own where that is possible."""
    words = [identifier(name) for name in names]
    plain = len(set(words)) == len(words) and not set(words) & {*taken, "on", "self", "given", "values"}
    return tuple(words) if plain else tuple(f"given_{k + 1}" for k in range(len(names)))
