"""What the commands share: a console that takes user text literally, progress, findings."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.text import Text

from dehyst.findings import Finding


def terminal(stderr: bool = False) -> Console:
    """Console for results, or for messages with `stderr`; column names in brackets are not markup."""
    return Console(stderr=stderr, markup=False, highlight=False, soft_wrap=False)


@contextmanager
def ask_progress(what: str, quiet: bool = False) -> Iterator[None]:
    """Show what is going on while it takes long, on a terminal only."""
    if quiet or not sys.stderr.isatty():
        yield
        return
    with terminal(stderr=True).status(f"{what} ..."):
        yield


def print_findings(findings: Iterable[Finding], stderr: bool = False) -> None:
    """Print findings, code first, wrapped and indented."""
    console = terminal(stderr)
    for finding in findings:
        console.print(Text.assemble(("\nwarning ", "yellow"), (finding.code, "bold yellow"), f": {finding.message}"))
