"""Figures of a run: what was measured for which signal, and the times behind it."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from typing import Any

from .limits import LIMITS
from .measure import Times


@dataclass
class Figures:
    """Measured figures by (what, signal), and times by (group, signal)."""

    values: dict[tuple[str, str], float] = field(default_factory=dict)
    groups: dict[tuple[str, str], dict[str, dict[str, float]]] = field(default_factory=dict)

    def add(self, what: str, signal: str, value: float) -> None:
        """Keep a figure."""
        self.values[what, signal] = float(f"{value:.4g}")  # more digits would be noise

    def times(self, group: str, signal: str, times: Times) -> None:
        """Keep the times of a group of methods, and say on standard error that it is done."""
        print(f"measured: {group}, {signal}", file=sys.stderr, flush=True)
        self.groups[group, signal] = times.as_dict()

    def ratio(self, what: str, signal: str, times: Times, name: str, other: str) -> None:
        """Keep the ratio of two methods' times per sample, if both ran."""
        if name in times.seconds and other in times.seconds:
            self.add(what, signal, times.ratio(name, other))

    def rows(self, quick: bool, partial: bool = False) -> list[dict[str, Any]]:
        """Every limit with its figure; `ok` is null where nothing was measured. Partial: measured ones only."""
        rows = []
        for limit in LIMITS:
            value = self.values.get((limit.what, limit.signal))
            if value is None and partial:
                continue
            rows.append({
                "what": limit.what, "signal": limit.signal, "measured": value, "sense": limit.sense,
                "limit": limit.value, "asked": limit.asked(quick),
                "ok": None if value is None else limit.holds(value, quick),
            })  # fmt: skip
        return rows

    def extra(self) -> list[dict[str, Any]]:
        """Figures without a limit."""
        bounded = {(limit.what, limit.signal) for limit in LIMITS}
        return [
            {"what": what, "signal": signal, "measured": value}
            for (what, signal), value in self.values.items()
            if (what, signal) not in bounded
        ]
