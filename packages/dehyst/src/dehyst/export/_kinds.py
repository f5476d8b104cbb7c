"""Kinds of controllers that packages add to what is exported, beside models and their inverses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol, cast

from dehyst.errors import ParameterError
from dehyst.export._subject import WHATS, Subject
from dehyst.findings import Finding
from dehyst.models import Model
from dehyst.plugins import EXPORTS, added, load_added

GROUP = "dehyst.controllers"


class ControllerKind(Protocol):
    """What a package offers for a value of ``--what`` that it adds."""

    def from_file(
        self, model: Model, path: Path, *, name: str, real: str
    ) -> tuple[Subject, list[Finding]]:
        """Return the controller that holds `model` with the parameters of a file."""
        ...

    def from_folder(
        self, model: Model, text: Callable[[str], str], folder: Path, settings: Mapping[str, Any]
    ) -> Subject:
        """Return the controller of an export folder again; `text` reads a file of it."""
        ...

    def pair_findings(self, model: Model, model_path: Path, path: Path) -> list[Finding]:
        """Return what speaks against a model and a file of parameters belonging together."""
        ...

    def shown_interface(self) -> list[str]:
        """Return lines about inputs and outputs, for the terminal."""
        ...


def whats() -> tuple[str, ...]:
    """Return what can be exported: models, their inverses, and the controllers of packages that are installed."""
    return (*WHATS, *added(GROUP))


def controller_kind(what: str) -> ControllerKind:
    """Return the kind of this name.

    Raises
    ------
    ParameterError
        If no package that is installed has it.
    """
    if what in added(GROUP):
        return cast(ControllerKind, load_added(GROUP, what))
    # The names of other packages of dehyst are known even where they are not installed.
    package = EXPORTS.get(what, "")
    cure = ""
    if package:
        cure = f" It is part of {package}, which is not installed: pip install {package}"
    raise ParameterError(
        f"--what {what!r:.40} is unknown; there are: {', '.join(whats())}.{cure}", value=what
    )
