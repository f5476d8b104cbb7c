"""Inputs and outputs of the function blocks, in the order of the columns of their signals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from dehyst.export.iec import Instance
from dehyst.export.signal import Signal


@dataclass(frozen=True)
class Ports:
    """How a signal's columns belong to a function block.

    Parameters
    ----------
    inputs
        Names in the order of the columns.
    switches
        Name -> bit of the signal's switch.
    outputs
        Names in the order of the columns.
    doubtful
        Name -> bit of the flags that may hang on the last digit in REAL: whether a limit was met.
    """

    inputs: tuple[str, ...]
    switches: Mapping[str, int]
    outputs: tuple[str, ...]
    doubtful: Mapping[str, int]

    @property
    def sure(self) -> int:
        """Return the bits of the flags that hold in REAL too."""
        return ~sum(self.doubtful.values())

    def call(self, unit: Instance, signal: Signal, k: int) -> dict[str, float | int | bool]:
        """Call a unit with sample k of a signal."""
        row = {name: float(x) for name, x in zip(self.inputs, signal.inputs[k], strict=True)}
        switches = {name: bool(signal.switch[k] & bit) for name, bit in self.switches.items()}
        return unit.call(**row, **switches, Restart=False)


def signal_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of further inputs of a unit in a function block.

    Examples
    --------
    >>> signal_names(("signal_0", "load"))
    ('GivenSignal0', 'GivenLoad')
    """
    return tuple("Given" + "".join(word.capitalize() for word in name.split("_")) for name in names)


BLOCK = Ports(
    ("InputValue",),
    MappingProxyType({"Enable": 1}),
    ("OutputValue",),
    MappingProxyType({"Limited": 4, "LimitedEver": 8}),
)
JOINT = Ports(
    (
        "Angle",
        "Pressure1",
        "Pressure2",
        "DesiredAngle",
        "DesiredVelocity",
        "DesiredAcceleration",
        "DesiredLoad",
        "MeanPressure",
        "DirectDifference",
        "ExtraDifference",
    ),
    MappingProxyType({"Position": 1, "Integrating": 2, "Compensating": 4}),
    (
        "Valve1",
        "Valve2",
        "Desired1",
        "Desired2",
        "PressureDifference",
        "Torque",
        "IntegratorTorque",
        "Compensation",
        "ObservedAngle",
        "ObservedVelocity",
        "ObservedLoad",
        "Contact",
        "Doubt",
    ),
    MappingProxyType({"PressureLimit": 16, "ValveLimit": 32}),
)
DIRECT_JOINT = replace(
    JOINT,
    switches=MappingProxyType({**JOINT.switches, "Learning": 8, "Resisting": 16}),
    doubtful=MappingProxyType({**JOINT.doubtful, "Learned": 256}),
)
