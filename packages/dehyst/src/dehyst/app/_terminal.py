"""What commands print: tables, findings, written files, the next command to type, JSON, progress."""

from __future__ import annotations

import errno
import json
import math
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Column, Table
from rich.text import Text

from dehyst.findings import Finding
from dehyst.shell import visible_lines

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn


Told = Callable[[str, float, float | None], None]  # stage, done, of; of is None where nobody knows
MARK = "\x1e"  # begins a line of progress on the error stream of a command that a program runs
_listeners: list[Told] = []


def tell_progress(listener: Told) -> None:
    """From now on progress is told to a function instead of shown on a terminal."""
    _listeners[:] = [listener]


class _Terminal(Console):
    """A console on which only its own styles are obeyed, no escape sequence of a name."""

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterator[Segment]:
        for segment in super().render(renderable, options):
            yield (
                segment if segment.control else Segment(visible_lines(segment.text), segment.style)
            )

    def on_broken_pipe(self) -> None:  # what the end of a pipe means is the command's to say
        raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))


def terminal(stderr: bool = False) -> Console:
    """Console for results, or for messages with `stderr`; text is printed as it is, brackets are no markup."""
    return _Terminal(stderr=stderr, markup=False, highlight=False, emoji=False, soft_wrap=False)


def tell(text: str) -> None:
    """Write one line about what was done on standard error."""
    sys.stderr.write(visible_lines(text) + "\n")


def table(
    heads: Iterable[str | Column],
    rows: Iterable[Sequence[str | Text]],
    bold: int | None = None,
    title: str | None = None,
) -> Table:
    """Return a table without lines; a column whose head begins with ">" is flush right, and row `bold` is bold."""

    def column(head: str) -> Column:
        return Column(head.removeprefix(">"), justify="right" if head.startswith(">") else "left")

    columns = [column(head) if isinstance(head, str) else head for head in heads]
    # Without lines and padding a table can be copied into a mail or a ticket.
    made = Table(*columns, title=title, title_justify="left", box=None, pad_edge=False)
    for number, row in enumerate(rows):
        made.add_row(*row, style="bold" if number == bold else None)
    return made


def percent(share: float) -> str:
    """A share as percent with two digits and without an exponent.

    Examples
    --------
    >>> percent(0.04213), percent(5.27)
    ('4.2 %', '530 %')
    """
    return f"{float(f'{100 * share:.2g}'):g} %"


def print_findings(findings: Iterable[Finding], stderr: bool = False) -> None:
    """Print findings, code first, wrapped and indented."""
    console = terminal(stderr)
    for finding in findings:
        console.print(
            Text.assemble(
                ("\nwarning ", "yellow"), (finding.code, "bold yellow"), f": {finding.message}"
            )
        )


def print_end(following: str, **written: Path | None) -> None:
    """Print what was written, and what to type next."""
    out = terminal()
    out.print()
    for label, path in written.items():
        if path is not None:
            out.print(f"{label}: {path}")
    if following:
        # A command that was wrapped could not be copied.
        out.print(f"next: {following}", soft_wrap=True)


def print_json(content: Any) -> None:
    """Write a result as JSON, which has no infinities: null stands for them."""
    sys.stdout.write(json.dumps(_finite(content), indent=1, allow_nan=False) + "\n")


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value


@contextmanager
def ask_progress(task: str, quiet: bool = False) -> Iterator[Callable[[float], None]]:
    """Show what is going on, and for how long already; on a terminal only.

    Whoever knows the share that is finished calls what this yields with it.
    """
    for listener in _listeners:
        listener(task, 0.0, None)
    if quiet or _listeners or not sys.stderr.isatty():
        yield lambda share: _tell_share(task, share)
        return
    # Only a terminal shows these columns, and loading them takes time.
    from rich.progress import SpinnerColumn, TextColumn, TimeElapsedColumn

    with progress_bar(
        SpinnerColumn(), TextColumn("{task.description} ..."), TimeElapsedColumn()
    ) as bar:
        if bar is None:
            yield lambda share: None
            return
        # The share is known only once the work has begun: until then the line shows the time alone.
        number = bar.add_task(task, total=None)
        yield lambda share: bar.update(number, description=f"{task}, {100.0 * share:.0f} %")


def _tell_share(task: str, share: float) -> None:
    for listener in _listeners:
        listener(task, share, 1.0)


@contextmanager
def progress_bar(
    *columns: ProgressColumn,
    quiet: bool = False,
    keep: bool = False,
) -> Iterator[Progress | None]:
    """Yield a progress bar on the error stream, which stays at its end with `keep`; None where there is no terminal."""
    for listener in _listeners:
        from dehyst.app._told import Teller

        yield Teller(listener)
        return
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.progress import Progress

    with Progress(*columns, console=terminal(stderr=True), transient=not keep) as bar:
        yield bar
