"""dehyst identify on logs larger than memory: when, and with which progress bar."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from dehyst.app.terminal import terminal
from dehyst.errors import DehystError, LogError, ParameterError
from dehyst.identification.stream import Progress
from dehyst.io.chunks import ChunkedLog, open_chunks
from dehyst.io.text import SIZE_LIMIT

if TYPE_CHECKING:
    from rich.console import Console

    from dehyst.app.requests import IdentifyRequest

# Bytes of memory that identifying a log at once takes for each byte of its file: 5.2 measured for NPZ with two columns,
# 3.6 for CSV with three. Logs that would take more than half of the memory are streamed.
MEMORY_PER_BYTE = 5.0
SHARE = 0.5
# How much larger packed logs are than their files, roughly.
PACKED = {".gz": 4.0, ".parquet": 2.0, ".feather": 2.0}


def memory_size() -> float:
    """Bytes of memory that this process may use; infinite where the system does not tell."""
    try:
        size = float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        size = float("inf")
    try:  # a container may have less
        limit = Path("/sys/fs/cgroup/memory.max").read_text(encoding="ascii").strip()
    except OSError:
        return size
    return min(size, float(limit)) if limit.isdigit() else size


def is_large(logs: Sequence[Path]) -> bool:
    """Whether logs are too large to be identified at once with comfort, or at all."""
    files = [log for log in logs if log.is_file()]
    sizes = [log.stat().st_size * PACKED.get(log.suffix.lower(), 1.0) for log in files]
    if any(log.stat().st_size > SIZE_LIMIT for log in files):
        return True
    return MEMORY_PER_BYTE * sum(sizes) > SHARE * memory_size()


def open_streams(request: IdentifyRequest) -> list[ChunkedLog] | None:
    """Open the logs of a request in chunks if it asks for that, or if they are large; None: read them at once.

    Raises
    ------
    ParameterError
        If streaming was asked for together with what it does not do.
    DehystError
        If streaming was asked for and a log cannot be read in chunks.
    """
    windowed = request.start is not None or request.stop is not None
    if request.stream and windowed:
        raise ParameterError(
            "--stream reads whole logs: --from and --to do not go with it. Leave them out, cut the log into files "
            "beforehand, or read it at once with --no-stream."
        )
    large = request.stream is None and not windowed and is_large(request.logs)
    if not request.stream and not large:
        return None
    try:
        return [
            open_chunks(
                log, request.input or "", request.output or "", request.time, run=run, time_unit=request.time_unit
            )
            for log in request.logs
            for run in (request.runs or (None,))
        ]
    except DehystError as fault:
        # Nobody asked for chunks: a format that cannot be read in them is read at once, as smaller logs are.
        if request.stream or type(fault) is not LogError:
            raise
        return None


@contextmanager
def progress_bar(quiet: bool, console: Console | None = None) -> Iterator[Callable[[Progress], None] | None]:
    """Show stage, share and bytes of a long identification, on a terminal only."""
    console = console or terminal(stderr=True)
    if quiet or not console.is_terminal:
        yield None
        return
    from rich.progress import BarColumn, DownloadColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description}"), BarColumn(), DownloadColumn(), TimeRemainingColumn())
    with Bar(*columns, console=console, transient=True) as bar:
        task = bar.add_task("reading")
        stage = ""

        def show(now: Progress) -> None:
            nonlocal stage
            if now.stage != stage:
                stage = now.stage
                bar.reset(task, description=f"{now.stage}, {now.number} of {now.of}")
            bar.update(task, completed=now.done, total=now.total or None)

        yield show
