"""Commands run in processes of their own, with their progress, and stopped at once when nobody waits for them."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import AsyncIterator
from contextlib import suppress
from typing import Any

from dehyst.app import kit as app_kit

KEPT = 2  # processes kept ready: a log that is opened is inspected and drawn at once
READ = 65536  # bytes at once
LATEST = 4000  # characters of a message: the end of a traceback is what counts


class Workers:
    """Starts commands at once: processes wait that have already loaded the packages, which takes a second."""

    def __init__(self) -> None:
        self._ready: list[Process] = []
        self._busy: set[Process] = set()

    @property
    def busy(self) -> bool:
        """Whether a command runs."""
        return bool(self._busy)

    async def prepare(self, number: int = KEPT) -> None:
        """Start processes until so many are ready."""
        self._ready = [process for process in self._ready if process.returncode is None]
        while len(self._ready) < number:
            started = await asyncio.create_subprocess_exec(
                sys.executable, "-P", "-m", "dehyst_studio.worker",
                stdin=PIPE, stdout=PIPE, stderr=PIPE, env=os.environ | {"PYTHONUTF8": "1"},
                start_new_session=True,
            )  # fmt: skip
            self._ready.append(started)

    async def run(self, words: list[str]) -> AsyncIterator[dict[str, Any]]:
        """Yield progress, {"stage", "done", "of"}, and at the end {"status", "said", "printed"}.

        A caller that leaves before the end stops the command: its process, and those that it started, are killed, which
        is safe at any moment because every file is written so that a kill leaves it whole.
        """
        await self.prepare(1)
        process = self._ready.pop(0)
        assert process.stdin is not None and process.stdout is not None
        self._busy.add(process)
        printed = asyncio.ensure_future(process.stdout.read())
        try:
            process.stdin.write(json.dumps(words).encode() + b"\n")
            process.stdin.close()
            error_lines: list[str] = []
            async for line in _lines(process):
                if line.startswith(app_kit.MARK):
                    yield json.loads(line[len(app_kit.MARK) :])
                else:
                    error_lines.append(line)
            status = await process.wait()
            yield {
                "status": status,
                "said": "\n".join(error_lines)[-LATEST:],
                "printed": (await printed).decode(),
            }
        finally:
            _kill(process)
            printed.cancel()
            self._busy.discard(process)

    async def end(self) -> None:
        """Kill every process, and wait until they are gone."""
        for process in (*self._busy, *self._ready):
            _kill(process)
        await asyncio.gather(*(process.communicate() for process in self._ready))


async def _lines(process: Process) -> AsyncIterator[str]:
    """Lines of the error stream, of any length."""
    assert process.stderr is not None
    unfinished = b""
    while part := await process.stderr.read(READ):
        *lines, unfinished = (unfinished + part).split(b"\n")
        for line in lines:
            yield line.decode(errors="replace")
    if unfinished:
        yield unfinished.decode(errors="replace")


def _kill(process: Process) -> None:
    if process.returncode is None:
        with suppress(ProcessLookupError, PermissionError):
            if hasattr(os, "killpg"):
                os.killpg(process.pid, signal.SIGKILL)  # it leads a group of its own
            else:
                process.kill()
