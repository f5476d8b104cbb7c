"""What the commands of this package share: the options of reading, and the picture that they are to write."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from dehyst.app import refuse_existing

READING = ("time", "time_unit", "dt", "sheet", "run", "start", "stop")


def reading_options(request: object) -> dict[str, Any]:
    """Return the options of reading that a request has, as `dehyst.read_log` takes them."""
    return {name: getattr(request, name) for name in READING}


def refuse_picture(path: Path | None, title: str, overwrite: bool) -> None:
    """Refuse a picture that could not be written, or would replace a file that is none of this title."""
    if path is None:
        return
    # Most calls draw nothing, and need not load what draws.
    from dehyst.report import require_picture_name

    refuse_existing(require_picture_name(path), overwrite, own=title)
