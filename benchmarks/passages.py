"""Through how many files a log's column goes until a model is saved, and a model until it is exported as C.

    python benchmarks/passages.py

Runs `dehyst identify` and `dehyst export --target c` in this process and looks at every call of a function of dehyst.
A file is passed if one of its functions is given the thing, alone or inside a record, a list or a dictionary: for a
column an array with most of the samples of the log, for a model an instance of `dehyst.Model`. A climb is such a call
into a room that lies above the room of the caller. CONTRIBUTING.md shows the two lines that this prints.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

import dehyst
from dehyst import cli

PACKAGE = Path(dehyst.__file__).parent
SAMPLES = 5_000  # most of the 7 200 of the example log


def is_column(value: object) -> bool:
    """Whether it is an array with most of the samples of the log."""
    return isinstance(value, np.ndarray) and value.size >= SAMPLES


def is_model(value: object) -> bool:
    """Whether it is a model."""
    return isinstance(value, dehyst.Model)


def holds(value: object, wanted: Callable[[object], bool], depth: int = 2) -> bool:
    """Whether a value is what is looked for, or holds it in a record, a list or a dictionary."""
    if wanted(value):
        return True
    if depth == 0:
        return False
    if isinstance(value, Mapping):
        inner: list[Any] = list(value.values())[:50]
    elif isinstance(value, list | tuple):
        inner = list(value[:50])
    elif type(value).__module__.startswith("dehyst"):
        inner = list(getattr(value, "__dict__", {}).values())
    else:
        return False
    return any(holds(part, wanted, depth - 1) for part in inner)


def room_of(file: str) -> str:
    """Room of a file of the package, "" for one of another package."""
    path = Path(file)
    if PACKAGE not in path.parents:
        return ""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


class Passages:
    """Files that were passed, in the order of their first call, and the climbs between rooms."""

    def __init__(self, wanted: Callable[[object], bool], floors: Mapping[str, int]) -> None:
        self.wanted = wanted
        self.floors = floors
        self.files: dict[str, None] = {}
        self.climbs: set[tuple[str, str]] = set()

    def __call__(self, frame: FrameType, event: str, _argument: object) -> None:
        """Take note of a call, for `sys.setprofile`."""
        code = frame.f_code
        if event != "call" or code.co_name.startswith("<"):
            return
        room = room_of(code.co_filename)
        if not room or not code.co_filename.endswith(".py"):  # a template is no file of ours
            return
        arguments = [
            frame.f_locals.get(name)
            for name in code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
        ]
        if not any(holds(value, self.wanted) for value in arguments):
            return
        self.files[os.path.relpath(code.co_filename, PACKAGE)] = None
        caller = room_of(frame.f_back.f_code.co_filename) if frame.f_back else ""
        if caller and self.floors.get(room, 0) > self.floors.get(caller, 0):
            self.climbs.add((caller, room))


def trace(
    words: list[str], wanted: Callable[[object], bool], floors: Mapping[str, int]
) -> Passages:
    """Run a command line and return what was passed."""
    passages = Passages(wanted, floors)
    sys.argv = ["dehyst", *words]
    sys.setprofile(passages)
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
            cli.main()
    finally:
        sys.setprofile(None)
    return passages


def main() -> None:
    """Trace both ways and print a line for each."""
    from test_floors import FLOOR

    columns = ["--input", "pressure_difference_bar", "--output", "angle_deg"]
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        trace(["example"], is_column, FLOOR)
        column = trace(
            ["identify", "example.csv", *columns, "--save", "model.json"], is_column, FLOOR
        )
        model = trace(
            ["export", "model.json", "--target", "c", "--name", "elbow", "--out", "elbow"],
            is_model,
            FLOOR,
        )
    for title, passages in (
        ("a column until its model is saved", column),
        ("a model until it is C", model),
    ):
        print(f"{title}: {len(passages.files)} files, {len(passages.climbs)} climbs")
        print("   " + ", ".join(passages.files))
        print(
            "   climbs: "
            + (", ".join(f"{low} -> {high}" for low, high in sorted(passages.climbs)) or "none")
        )


if __name__ == "__main__":
    main()
