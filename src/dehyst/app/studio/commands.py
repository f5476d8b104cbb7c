"""What the page may ask for: commands of dehyst, each with the options of its own request, and their files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import Field, dataclass, fields
from pathlib import Path
from typing import Any, get_args, get_type_hints

from dehyst.app import requests
from dehyst.errors import ParameterError

SIGNALS = "signals"


@dataclass(frozen=True, eq=False)
class SignalsRequest(requests.InspectRequest):
    """What a log looks like over time, to choose a part of it; a command of the studio alone."""

    input: str | None = requests.option()
    output: str | None = requests.option()
    time: str | None = requests.option()


COMMANDS: Mapping[str, type[Any]] = {
    "inspect": requests.InspectRequest,
    SIGNALS: SignalsRequest,
    "identify": requests.IdentifyRequest,
    "compare": requests.CompareRequest,
    "evaluate": requests.EvaluateRequest,
    "export": requests.ExportRequest,
    "verify": requests.VerifyRequest,
}
READ = ("log", "logs", "model", "models", "controller", "folder")  # files that the studio keeps, by their id
WRITTEN = {"save": "model.json", "report": "report.html"}  # written with every call that can write them


def words_of(
    command: str, given: Mapping[str, Any], place: Callable[[str], Path], folder: Path
) -> tuple[list[str], dict[str, Path]]:
    """Return the words of a command line, and the files that it will write.

    Parameters
    ----------
    command
        One of `COMMANDS`.
    given
        Option by the name of its field -> value; of a file that is read the id.
    place
        Path of an id.
    folder
        Where files are written, whatever was asked for.

    Raises
    ------
    ParameterError
        If there is no such command or option, or a value is not of its kind.

    Examples
    --------
    >>> folder = Path("work")
    >>> given = {"log": "7", "run": "up"}
    >>> words_of("inspect", given, lambda name: Path(f"{name}.csv"), folder)[0]
    ['inspect', '--run=up', '--json', '--', '7.csv']
    """
    request = COMMANDS.get(command)
    if request is None:
        raise ParameterError(f"the studio has no command '{command}'; it has {', '.join(COMMANDS)}.")
    hints = get_type_hints(request)
    options: list[str] = []
    arguments: list[str] = []
    written: dict[str, Path] = {}
    left = {name: value for name, value in given.items() if value not in (None, "", [])}
    for entry in fields(request):
        name, hint = entry.name, hints[entry.name]
        if name == "json":
            options.append("--json")
        elif name in WRITTEN or (name == "out" and command == "export"):
            written[name] = folder / WRITTEN.get(name, "code")
            options.append(f"{_flag(entry)}={written[name]}")
        elif name not in left:
            continue
        elif name in READ:
            ids = left.pop(name)
            paths = [str(place(each)) for each in (ids if isinstance(ids, list) else [ids])]
            if "argument" in entry.metadata:
                arguments += paths
            else:
                options += [f"{_flag(entry)}={path}" for path in paths]
        elif hint not in (Path, Path | None):  # the page names no file of this machine
            options += _typed(entry, hint, left.pop(name))
    if left:
        raise ParameterError(f"`dehyst {command}` has no option '{next(iter(left))}' that the studio can set.")
    return [command, *options, "--", *arguments], written


def _flag(entry: Field[Any]) -> str:
    flag = entry.metadata["flag"] or requests.COMMON.get(entry.name, ("",))[0]
    return str(flag or f"--{entry.name.replace('_', '-')}")


def _typed(entry: Field[Any], hint: Any, value: Any) -> list[str]:
    """One option as it would be typed; what its value means is the command line's to judge."""
    flag, _, negative = _flag(entry).partition("/")
    if bool in (hint, *get_args(hint)):
        return [flag] if value is True else [negative] if negative else []
    if tuple in (getattr(each, "__origin__", None) for each in (hint, *get_args(hint))):
        if not isinstance(value, list):
            raise ParameterError(f"{flag} takes a list.")
        if ... in get_args(hint):
            return [f"{flag}={each}" for each in value]
        return [flag, *map(str, value)]
    if isinstance(value, dict | list):
        raise ParameterError(f"{flag} takes one value.")
    return [f"{flag}={value}"]
