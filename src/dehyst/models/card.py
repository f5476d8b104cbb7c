"""What a model is about: its signals, their units and ranges, and where it came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from dehyst.shell import visible


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
        """Axis label, ``name [unit]``."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    def __str__(self) -> str:
        """Label and range on one line; what cannot be printed is spelled out, what is endless left out."""
        label = visible(self.label)
        label = label if len(label) <= 60 else f"{label[:57]}..."
        return label if self.low is None or self.high is None else f"{label} {self.low:z.4g} to {self.high:z.4g}"


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
