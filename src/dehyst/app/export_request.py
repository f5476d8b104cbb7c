"""The command line of ``dehyst export``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dehyst.export.excerpt import ALL, Part


@dataclass(frozen=True)
class ExportRequest:
    """The command line of ``dehyst export``."""

    model: Path
    target: str
    out: Path
    real: str | None = None
    what: str = "inverse"
    range: tuple[float, float] | None = None
    ramp: int | None = None
    log: Path | None = None
    column: str | None = None
    controller: Path | None = None
    name: str | None = None
    prune: bool = False
    overwrite: bool = False
    json: bool = False
    part: Part = ALL
    period: float | None = None
