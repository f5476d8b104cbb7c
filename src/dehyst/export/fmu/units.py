"""Units of an FMU's variables as FMI defines them: exponents of the SI base units and a factor."""

from __future__ import annotations

from dataclasses import dataclass

from dehyst.units import DIMENSION, TABLE

# dimension of dehyst.units -> exponents of the base units; the first unit of each dimension has the factor 1
_BASE: dict[str, dict[str, int]] = {
    "pressure": {"kg": 1, "m": -1, "s": -2},
    "angle": {"rad": 1},
    "length": {"m": 1},
    "force": {"kg": 1, "m": 1, "s": -2},
    "voltage": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "current": {"A": 1},
    "torque": {"kg": 1, "m": 2, "s": -2},
    "time": {"s": 1},
}
# Those of a joint controller that no log has.
_DERIVED: dict[str, dict[str, int]] = {
    "rad/s": {"rad": 1, "s": -1},
    "rad/s^2": {"rad": 1, "s": -2},
    "1/s": {"s": -1},
    "kg.m2": {"kg": 1, "m": 2},
    "m3": {"m": 3},
    "Nm/Pa": {"m": 3},
    "Pa/rad": {"kg": 1, "m": -1, "s": -2, "rad": -1},
    "J/kg": {"m": 2, "s": -2},
    "kg/m3": {"kg": 1, "m": -3},
    "m3/(s.Pa)": {"m": 4, "s": 1, "kg": -1},
}


@dataclass(frozen=True)
class BaseUnit:
    """What one of a unit is in SI base units: factor times their powers."""

    exponents: dict[str, int]
    factor: float = 1.0


def base_unit(unit: str) -> BaseUnit | None:
    """Return what FMI calls the base unit, or None for a unit that is known by its name only.

    Examples
    --------
    >>> base_unit("bar")
    BaseUnit(exponents={'kg': 1, 'm': -1, 's': -2}, factor=100000.0)
    >>> base_unit("furlong") is None
    True
    """
    if unit in _DERIVED:
        return BaseUnit(_DERIVED[unit])
    dimension = DIMENSION.get(unit)
    return BaseUnit(_BASE[dimension], TABLE[dimension][unit]) if dimension else None
