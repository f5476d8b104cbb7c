"""What the commands share: a console that takes user text literally, progress, findings."""

from __future__ import annotations

import errno
import json
import math
import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from dehyst.findings import Finding
from dehyst.shell import visible_lines


class _Terminal(Console):
    """A console on which only its own styles are obeyed, no escape sequence of a name."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterator[Segment]:
        for segment in super().render(renderable, options):
            yield segment if segment.control else Segment(visible_lines(segment.text), segment.style)

    def on_broken_pipe(self) -> None:  # what the end of a pipe means is the command's to say
        raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))


def terminal(stderr: bool = False) -> Console:
    """Console for results, or for messages with `stderr`; column names in brackets are not markup."""
    return _Terminal(stderr=stderr, markup=False, highlight=False, soft_wrap=False)


def tell(text: str) -> None:
    """Write one line about what was done on standard error."""
    sys.stderr.write(visible_lines(text) + "\n")


@contextmanager
def ask_progress(what: str, quiet: bool = False) -> Iterator[None]:
    """Show what is going on while it takes long, on a terminal only."""
    if quiet or not sys.stderr.isatty():
        yield
        return
    with terminal(stderr=True).status(f"{what} ..."):
        yield


def print_json(found: Mapping[str, Any]) -> None:
    """Write a result as JSON, which has no infinities: null stands for them."""
    sys.stdout.write(json.dumps(_finite(found), indent=1, allow_nan=False) + "\n")


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value


def print_end(out: Console, following: str, **written: Path | None) -> None:
    """Print what was written, and what to type next."""
    out.print()
    for what, path in written.items():
        if path is not None:
            out.print(Text(f"{what}: {path}"))
    out.print(Text(f"next: {following}"), soft_wrap=True)


def print_findings(findings: Iterable[Finding], stderr: bool = False) -> None:
    """Print findings, code first, wrapped and indented."""
    console = terminal(stderr)
    for finding in findings:
        console.print(Text.assemble(("\nwarning ", "yellow"), (finding.code, "bold yellow"), f": {finding.message}"))
