"""What the weights of a direct inverse may depend on."""

from __future__ import annotations

from dataclasses import dataclass

from dehyst.errors import ParameterError
from dehyst.models.arrays import parameter_number
from dehyst.units import MASS_FACTORS

OUTPUT = "output"


@dataclass(frozen=True)
class Schedule:
    """A variable between two ends of whose range weights are blended: xi = (sigma - low)/(high - low) within 0..1.

    Parameters
    ----------
    name
        "output" for y itself, else the name of a signal from outside, for instance "mean_pressure" or "load".
    low, high
        Ends of its range, low < high; beyond them it is held. [unit]
    unit
        Of the variable, "" if unknown.

    Raises
    ------
    ParameterError
        If the range is empty.

    Examples
    --------
    >>> Schedule("mean_pressure", 2.0, 4.0, "bar").outside
    True
    """

    name: str
    low: float
    high: float
    unit: str = ""

    def __post_init__(self) -> None:
        for end in ("low", "high"):
            object.__setattr__(self, end, parameter_number(getattr(self, end), f"{end} of schedule '{self.name}'"))
        if not self.low < self.high:
            raise ParameterError(
                f"schedule '{self.name}' has the range {self.low:g} to {self.high:g}: nothing can be blended over it. "
                f"Pass low < high, or leave the schedule out."
            )

    def __str__(self) -> str:
        """Name and, from outside, range; a mass is said to be one."""
        if not self.outside:
            return self.name
        mass = " (a mass; no joint controller takes it)" if self.unit in MASS_FACTORS else ""
        return f"{self.name} {self.low:z.4g} to {self.high:z.4g} {self.unit}".rstrip() + mass

    @property
    def outside(self) -> bool:
        """Whether its values are given from outside."""
        return self.name != OUTPUT
