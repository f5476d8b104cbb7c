"""Description of a model: its signals, units, ranges and origin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from dehyst.arrays import Array
from dehyst.findings import Finding
from dehyst.shell import visible
from dehyst.units import canonical, convert


@dataclass(frozen=True, slots=True)
class SignalCard:
    """Name, unit and identified range of one signal.

    Attributes
    ----------
    name
        Column name in the log.
    unit
        Unit of the values, "" if unknown.
    low, high
        Smallest and largest value seen in identification; None if the model was written by hand. [unit]
    """

    name: str
    unit: str = ""
    low: float | None = None
    high: float | None = None

    @property
    def label(self) -> str:
        """Axis label, ``name [unit]``, on one line; what cannot be printed is spelled out."""
        return visible(f"{self.name} [{self.unit}]" if self.unit else self.name)

    def __str__(self) -> str:
        """Label and range on one line; what is endless is left out."""
        label = self.label
        # Some logs have a whole sentence as the name of a column.
        if len(label) > 60:
            label = f"{label[:57]}..."
        if self.low is None or self.high is None:
            return label
        return f"{label} {self.low:z.4g} to {self.high:z.4g}"


@dataclass(frozen=True)
class ModelCard:
    """Signals and provenance that travel with a model into its file.

    Attributes
    ----------
    input, output
        The two signals.
    provenance
        Log, columns, date, settings and verdict of the identification: plain JSON values.

    Examples
    --------
    >>> card = ModelCard(SignalCard("pressure", "bar"), SignalCard("angle", "deg"))
    >>> card.swapped().input.label
    'angle [deg]'
    """

    input: SignalCard = SignalCard("input")
    output: SignalCard = SignalCard("output")
    provenance: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "provenance", dict(self.provenance))

    def swapped(self) -> ModelCard:
        """Card of the inverse model: input and output change places."""
        return ModelCard(self.output, self.input, self.provenance)


NO_CARD = ModelCard()  # of models written by hand


def in_units_of(
    card: SignalCard, values: Array, unit: str, column: str
) -> tuple[Array, list[Finding]]:
    """Return the values in the model's unit, and findings; the same array where nothing was converted.

    Raises
    ------
    UnitError
        If both units are known and one cannot be turned into the other.

    Examples
    --------
    >>> import numpy as np
    >>> values, findings = in_units_of(SignalCard("pressure", "bar"), np.array([1e5]), "Pa", "'p'")
    >>> values.tolist(), [finding.code for finding in findings]
    ([1.0], ['unit-converted'])
    """
    # Two spellings of one unit need no conversion, and so no finding.
    if unit == card.unit or canonical(unit) == canonical(card.unit) is not None:
        return values, []
    # An unknown unit is no error: many logs name none.
    if not unit or not card.unit:
        return values, [
            Finding(
                "unit-unknown",
                f"column {column} is in '{unit or 'unknown'}', the model in '{card.unit or 'unknown'}': the values "
                f"were taken as they are. Name the unit in the column, for example {card.name}_{card.unit or 'bar'}.",
            )
        ]
    message = f"column {column} was converted from {unit} to {card.unit}."
    return convert(values, unit, card.unit), [Finding("unit-converted", message)]
