"""Excerpt of the user's log: the input of what is exported, in its unit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dehyst.export.subject import MOST_EXCERPT
from dehyst.findings import Finding
from dehyst.io import read_signal
from dehyst.models import SignalCard
from dehyst.units import canonical, convert

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Excerpt:
    """Logged samples for the check.

    Attributes
    ----------
    values
        (T,), T at most `MOST_EXCERPT`. [unit of the exported input]
    source
        File and column.
    findings
        What reading found.
    """

    values: Array
    source: str
    findings: tuple[Finding, ...]


def read_excerpt(log: Path, column: str, card: SignalCard) -> Excerpt:
    """Read the first samples of a column, in the unit of a signal.

    Raises
    ------
    LogError
        If log or column cannot be read.
    UnitError
        If the units cannot be converted.
    """
    signal = read_signal(log, column)
    values, findings = signal.values, list(signal.findings)
    same = signal.unit == card.unit or canonical(signal.unit) == canonical(card.unit) is not None
    if not same and signal.unit and card.unit:
        values = convert(values, signal.unit, card.unit)
        findings.append(
            Finding("unit-converted", f"column '{signal.name}' was converted from {signal.unit} to {card.unit}.")
        )
    elif not same:
        findings.append(
            Finding(
                "unit-unknown",
                f"column '{signal.name}' is in '{signal.unit or 'unknown'}', the model in '{card.unit or 'unknown'}': "
                f"the values were taken as they are. Name the unit in the column, for example "
                f"{card.name}_{card.unit or 'bar'}.",
            )
        )
    return Excerpt(np.asarray(values)[:MOST_EXCERPT], f"{log.name}, {signal.name}", tuple(findings))
