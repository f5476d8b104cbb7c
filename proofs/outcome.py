"""What a proof hands back, and how tools are found."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
CORE = HERE.parent / "packages" / "dehyst" / "core"


@dataclass(frozen=True)
class Outcome:
    """One line of the result.

    ``ok`` is None if the proof was not run; ``result`` then says what to type.
    """

    name: str
    claim: str
    tool: str
    extent: str
    result: str
    ok: bool | None
    seconds: float = 0.0

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


class Missing(Exception):
    """A tool is not installed; the message says what to type."""


class Failed(Exception):
    """A proof does not hold, or a tool could not do its work; the message is what it said."""


@dataclass(frozen=True)
class Proof:
    """A claim, and the function that tries it: ``run(quick)`` gives tool with version, extent and result."""

    name: str
    claim: str
    run: Callable[[bool], tuple[str, str, str]]

    def outcome(self, quick: bool) -> Outcome:
        """Run it; what is missing or does not hold becomes a line of the result too."""
        start = time.perf_counter()
        try:
            tool, extent, result = self.run(quick)
            ok: bool | None = True
        except Missing as missing:
            tool, extent, result, ok = "", "", f"not run: {missing}", None
        except Failed as failed:
            tool, extent, result, ok = "", "", str(failed), False
        return Outcome(
            self.name, self.claim, tool, extent, result, ok, round(time.perf_counter() - start, 1)
        )


def tool(cure: str, *names: str) -> str:
    """Return the first of these programs that is there: beside this Python, or on the path."""
    for name in names:
        beside = Path(sys.executable).parent / name
        found = str(beside) if beside.is_file() else shutil.which(name)
        if found:
            return found
    raise Missing(f"{names[0]} is not installed; {cure}")


def said(command: Sequence[str | Path], seconds: float = 1200.0, **options: Any) -> str:
    """Run a command and return all it printed; a failure of the command is a failure of the proof."""
    try:
        done = subprocess.run(
            [str(part) for part in command],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=seconds,
            check=False,
            **options,
        )
    except subprocess.TimeoutExpired as late:
        raise Failed(f"{Path(str(command[0])).name}: not done after {seconds:.0f} s") from late
    if done.returncode:
        raise Failed(
            f"{Path(str(command[0])).name} ended with status {done.returncode}:\n{done.stdout[-2000:]}"
        )
    return done.stdout


def version(command: str, option: str = "--version") -> str:
    """Return the number in the first line of what a tool says about itself."""
    found = re.search(r"\d+(\.\d+)+", said([command, option]))
    return found[0] if found else "?"


def sources(*without: str) -> list[Path]:
    """Return the files of the core, in order of their names."""
    return [path for path in sorted(CORE.glob("*.c")) if path.stem not in without]
