"""Code blocks of a Markdown page: find them, run them, compare what they print with what the page shows.

Rules, for README.md and every page below docs/:

- A ```python block is run; blocks of one page share their variables. A ```text (or ```output) block right after it
  shows what it prints. ```python no-run is not run, nor is ```console no-run.
- In a ```console block every line `$ dehyst ...`, `$ head ...`, `$ python examples/...` or `$ make -s -C examples/...`
  is run in a shell, in one temporary folder for each page; the lines below it show what it prints. Other commands
  (`$ pip ...`) are not run.
- A line `...` in a shown output stands for any number of words.

Compared are words, whatever the line breaks, and the blanks within brackets, of which numpy's arrays have one more or
less for the sign of a zero. Words must agree; numbers may differ by 1 % of their size or by one unit of the last digit
shown, and rounding errors (both below 1e-9) by any factor: other processors and libraries round otherwise.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Any

RUN = ("dehyst ", "head ", "python examples/", "make -s -C examples/")
ROOT = Path(__file__).resolve().parents[2]
OUTPUTS = ("text", "output")
WIDTH = "100"  # columns of the terminal in which shown outputs were printed
_FENCE = re.compile(r"^(`{3,})(.*)$")
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:e[-+]?\d+)?", re.IGNORECASE)


@dataclass(frozen=True)
class Fence:
    """A fenced block: its info string, its text, and the indices of its first and last line of text."""

    info: str
    text: str
    first: int
    last: int

    @property
    def language(self) -> str:
        """First word of the info string."""
        return (self.info.split() or [""])[0]


@dataclass(frozen=True)
class Step:
    """Something to run and what the page says it prints; None if the page shows nothing.

    Attributes
    ----------
    kind
        "python" or "console".
    code
        Source, or the command line.
    shown
        Output on the page.
    first, last
        Lines of the page that hold the output, last excluded.
    line
        Line of the code on the page, from 1.
    """

    kind: str
    code: str
    shown: str | None
    first: int
    last: int
    line: int


def fences(text: str) -> list[Fence]:
    """All fenced blocks of a page, in order."""
    found: list[Fence] = []
    lines = text.split("\n")
    start: tuple[str, str, int] | None = None
    for k, line in enumerate(lines):
        mark = _FENCE.match(line)
        if start is None and mark:
            start = (mark[1], mark[2].strip(), k + 1)
        elif start is not None and line.strip() == start[0]:
            found.append(Fence(start[1], "\n".join(lines[start[2] : k]), start[2], k))
            start = None
    return found


def steps(text: str) -> list[Step]:
    """Everything on a page that is run, in order."""
    lines = text.split("\n")
    found: list[Step] = []
    blocks = fences(text)
    for block, after in zip(blocks, [*blocks, None][1:], strict=True):
        if block.info == "python":
            beside = (
                after is not None
                and after.language in OUTPUTS
                and not "".join(lines[block.last + 1 : after.first - 1]).strip()
            )
            shown = (
                (after.text, after.first, after.last)
                if beside and after
                else (None, block.last, block.last)
            )
            found.append(Step("python", block.text, *shown, block.first + 1))
        elif block.info == "console":
            found += _commands(block, lines)
    return found


def _commands(block: Fence, lines: list[str]) -> list[Step]:
    found: list[Step] = []
    k = block.first
    while k < block.last:
        if not lines[k].startswith("$ "):
            k += 1
            continue
        begin, command = k, lines[k][2:]
        while command.endswith("\\") and k + 1 < block.last:
            k += 1
            command = command[:-1] + lines[k].removeprefix(">").lstrip()
        end = k + 1
        while end < block.last and not lines[end].startswith("$ "):
            end += 1
        if command.startswith(RUN):
            found.append(
                Step("console", command, "\n".join(lines[k + 1 : end]), k + 1, end, begin + 1)
            )
        k = end
    return found


def run_page(text: str, folder: Path) -> list[tuple[Step, str]]:
    """Run a page from top to bottom in a folder; return each step with what it printed.

    Raises
    ------
    AssertionError
        If a Python block raises or a command cannot be started.
    """
    names: dict[str, Any] = {"__name__": "__page__"}
    before = Path.cwd()
    (folder / "examples").symlink_to(ROOT / "examples", target_is_directory=True)
    os.chdir(folder)
    try:
        return [
            (step, _python(step, names) if step.kind == "python" else _console(step))
            for step in steps(text)
        ]
    finally:
        os.chdir(before)


def _python(step: Step, names: dict[str, Any]) -> str:
    stream = io.StringIO()
    with contextlib.redirect_stdout(stream):
        try:
            exec(compile(step.code, f"<line {step.line}>", "exec", dont_inherit=True), names)
        except Exception:
            raise AssertionError(
                f"the Python block at line {step.line} fails:\n{traceback.format_exc()}"
            ) from None
    return stream.getvalue()


def _console(step: Step) -> str:
    # The command that belongs to this interpreter comes first, whatever else is installed.
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    done = subprocess.run(
        ["sh", "-c", step.code],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "PATH": path, "COLUMNS": WIDTH, "NO_COLOR": "1", "TERM": "dumb"},
        timeout=600,
        check=False,
    )
    return done.stdout


def agree(shown: str, printed: str) -> bool:
    """Whether a shown output is what was printed, by the rules at the top.

    Examples
    --------
    >>> agree("rms 0.164 %", "rms  0.1641\\n%"), agree("rms 0.16 %", "rms 0.19 %"), agree("a\\n...\\nz", "a b c z")
    (True, False, True)
    """
    parts = [_words(part) for part in re.split(r"(?m)^[ \t]*\.\.\.[ \t]*$", shown)]
    words = _words(printed)
    place = 0
    for index, part in enumerate(parts):
        if index == len(parts) - 1 and index > 0:
            place = max(place, len(words) - len(part))
        where = (
            range(place, place + 1)
            if index in (0, len(parts) - 1)
            else range(place, len(words) - len(part) + 1)
        )
        fits = next((k for k in where if _same(part, words[k : k + len(part)])), None)
        if fits is None:
            return False
        place = fits + len(part)
    return place == len(words)


def _words(text: str) -> list[str]:
    return re.sub(r"(\[)\s+|\s+(\])", r"\1\2", text).split()


def _same(shown: list[str], printed: list[str]) -> bool:
    return len(shown) == len(printed) and all(map(_same_word, shown, printed))


def _same_word(shown: str, printed: str) -> bool:
    if shown == printed:
        return True
    if _NUMBER.sub("#", shown) != _NUMBER.sub("#", printed):
        return False
    return all(map(_same_number, _NUMBER.findall(shown), _NUMBER.findall(printed)))


def _same_number(shown: str, printed: str) -> bool:
    a, b = float(shown), float(printed)
    near = abs(a - b) <= max(0.01 * abs(a), 1.001 * _last_digit(shown))
    # A whole number is a count of something or a size in percent: the last digit is all the freedom it gets.
    if _is_whole(shown) and _is_whole(printed):
        near = abs(a - b) <= 1.0
    return near or (abs(a) < 1e-9 and abs(b) < 1e-9)


def _is_whole(number: str) -> bool:
    return re.fullmatch(r"[-+]?\d+", number) is not None


def _last_digit(number: str) -> float:
    """Size of one unit in the last place of a written number."""
    mantissa, _, exponent = number.lower().partition("e")
    digits = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(exponent or 0) - digits))


def with_outputs(text: str, results: list[tuple[Step, str]]) -> str:
    """The page with every shown output that is no longer true replaced by what was printed.

    Outputs that agree stay as they are, so that a rebuild on another machine changes nothing.
    """
    lines = text.split("\n")
    for step, printed in reversed(results):
        if step.shown is None or agree(step.shown, printed) or step.shown.strip() == "...":
            continue
        lines[step.first : step.last] = [line.rstrip() for line in printed.rstrip("\n").split("\n")]
    return "\n".join(lines)
