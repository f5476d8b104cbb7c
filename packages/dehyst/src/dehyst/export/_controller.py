"""What a target has to know of a whole controller: its signals, switches and flags, and a run of it on the host."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from dehyst.arrays import Array
from dehyst.export._signal import Whole


@dataclass(frozen=True)
class Quantity:
    """A signal or a constant of a controller.

    Attributes
    ----------
    name
        A C identifier.
    unit
        SI, "" for a number.
    meaning
        In a few words.
    values
        Of a constant; of an input its value before one is set.
    limits
        Lowest and highest value, where there are any.
    table
        Whether a constant is an array.
    """

    name: str
    unit: str
    meaning: str
    values: tuple[float, ...] = (0.0,)
    limits: tuple[float, float] | None = None
    table: bool = False


@dataclass(frozen=True)
class ControllerInterface:
    """A controller as a target sees it; signals stand in the order of the core's structures.

    Attributes
    ----------
    sensors, references
        Inputs of a period.
    outputs
        Outputs of a period, without the flags.
    switches, flags
        Name -> bit and meaning.
    last_digit_flags
        Bits of the flags that may differ in float, because they depend on the last digit.
    constants
        Parameters, to be read.
    example
        Input that an example moves, output that it shows, and lowest and highest value of that input.
    run
        Inputs (T, m) and switches (T,) -> outputs (T, k) on the host, from a reset on.
    files
        Further files of the export: path -> text.
    """

    sensors: tuple[Quantity, ...]
    references: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]
    switches: Mapping[str, tuple[int, str]]
    flags: Mapping[str, tuple[int, str]]
    last_digit_flags: int
    constants: tuple[Quantity, ...]
    example: tuple[str, str, float, float]
    run: Callable[[Array, Whole], Array]
    files: Mapping[str, str] = field(default_factory=dict)

    @property
    def inputs(self) -> tuple[Quantity, ...]:
        """Sensors, then references."""
        return self.sensors + self.references

    @property
    def flag_bits(self) -> dict[str, int]:
        """Name -> bit of every flag."""
        return {name: bit for name, (bit, _) in self.flags.items()}

    @property
    def switch_bits(self) -> dict[str, int]:
        """Name -> bit of every switch."""
        return {name: bit for name, (bit, _) in self.switches.items()}
