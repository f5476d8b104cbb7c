"""Folders of templates: those of this package, and those that other packages add when they are loaded."""

from __future__ import annotations

from pathlib import Path

TEMPLATES = Path(__file__).parent / "templates"
FOLDERS = [str(TEMPLATES)]


def add_templates(folder: Path) -> None:
    """Let `render` find the templates of another package too."""
    if str(folder) not in FOLDERS:
        FOLDERS.append(str(folder))
