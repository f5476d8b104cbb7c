"""Values of a column in the unit in which a model has that signal."""

from __future__ import annotations

from dehyst.arrays import Array
from dehyst.findings import Finding
from dehyst.models.card import SignalCard
from dehyst.units import canonical, convert


def in_units_of(card: SignalCard, values: Array, unit: str, column: str) -> tuple[Array, list[Finding]]:
    """Return the values in the model's unit and what is to be said; the same array where nothing was converted.

    Raises
    ------
    UnitError
        If both units are known and one cannot be turned into the other.

    Examples
    --------
    >>> import numpy as np
    >>> values, said = in_units_of(SignalCard("pressure", "bar"), np.array([1e5]), "Pa", "'p'")
    >>> values.tolist(), [finding.code for finding in said]
    ([1.0], ['unit-converted'])
    """
    if unit == card.unit or canonical(unit) == canonical(card.unit) is not None:
        return values, []
    if not unit or not card.unit:
        return values, [
            Finding(
                "unit-unknown",
                f"column {column} is in '{unit or 'unknown'}', the model in '{card.unit or 'unknown'}': the values "
                f"were taken as they are. Name the unit in the column, for example {card.name}_{card.unit or 'bar'}.",
            )
        ]
    said = Finding("unit-converted", f"column {column} was converted from {unit} to {card.unit}.")
    return convert(values, unit, card.unit), [said]
