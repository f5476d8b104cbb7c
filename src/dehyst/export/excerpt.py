"""Excerpt of the user's log: the input of what is exported, in its unit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.export.signal import Signal
from dehyst.export.subject import MOST_EXCERPT
from dehyst.findings import Finding
from dehyst.io import read_signal
from dehyst.models import SignalCard
from dehyst.models.card import in_units_of

LEAST_SHARE = 0.1  # of the range that an excerpt should use


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


@dataclass(frozen=True)
class Part:
    """Which part of a log: its run, times from and to [s], and the time column."""

    run: str | None = None
    start: float | None = None
    stop: float | None = None
    time: str | None = None


ALL = Part()


def read_excerpt(log: Path, column: str, card: SignalCard, part: Part = ALL) -> Excerpt:
    """Read the first samples of a column, in the unit of a signal, of a part of the log.

    Raises
    ------
    LogError
        If log or column cannot be read.
    UnitError
        If the units cannot be converted.
    """
    signal = read_signal(log, column, time=part.time, run=part.run, start=part.start, stop=part.stop)
    values, findings = in_units_of(card, signal.values, signal.unit, f"'{signal.name}'")
    return Excerpt(np.asarray(values)[:MOST_EXCERPT], f"{log.name}, {signal.name}", (*signal.findings, *findings))


def use_of(signal: Signal, card: SignalCard) -> tuple[int, float]:
    """Return how many samples of an excerpt are limited, and which share of the input's range it uses."""
    limited = int(np.count_nonzero(signal.flags & 4))
    low, high = float(card.low or 0.0), float(card.high or 0.0)
    inside = np.clip(signal.inputs[np.isfinite(signal.inputs)], low, high)
    return limited, float((inside.max() - inside.min()) / (high - low)) if inside.size else 0.0


def use_findings(signal: Signal, card: SignalCard) -> list[Finding]:
    """Return a warning if an excerpt says little: most of it at a limit, or a small part of the range."""
    limited, share = use_of(signal, card)
    if 2 * limited <= signal.samples and share >= LEAST_SHARE:
        return []
    return [
        Finding(
            "excerpt-says-little",
            f"of the excerpt's {signal.samples} samples {limited} are limited, and it uses {100 * share:.2g} % of the "
            f"range of {card!s}: it proves little. Is --column the input of what is exported, in its unit? Choose "
            f"another part with --run, --from and --to.",
        )
    ]
