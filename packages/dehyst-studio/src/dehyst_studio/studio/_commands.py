"""What the page may ask for: commands of dehyst, each with the options of its own request, and their files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import Field, dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

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
READ = (
    "log",
    "logs",
    "model",
    "models",
    "controller",
    "folder",
)  # files that the studio keeps, by their id
WRITTEN = {
    "save": "model.json",
    "report": "report.html",
}  # written with every call that can write them


def command_words(
    command: str, values: Mapping[str, Any], place: Callable[[str], Path], folder: Path
) -> tuple[list[str], dict[str, Path]]:
    """Return the words of a command line, and the files that it will write.

    Parameters
    ----------
    command
        One of `COMMANDS`.
    values
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
    >>> values = {"log": "7", "run": "up"}
    >>> command_words("inspect", values, lambda name: Path(f"{name}.csv"), folder)[0]
    ['inspect', '--run=up', '--json', '--', '7.csv']
    """
    request = COMMANDS.get(command)
    if request is None:
        raise ParameterError(
            f"the studio has no command '{command}'; it has {', '.join(COMMANDS)}."
        )
    hints = _hints(command)
    options: list[str] = []
    arguments: list[str] = []
    written: dict[str, Path] = {}
    # The page sends an empty value for a field that nobody filled in.
    left = {}
    for name, value in values.items():
        if value is not None and value != "" and value != []:
            left[name] = value
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
            paths = [str(place(file)) for file in _ids(entry, hint, left.pop(name))]
            if "argument" in entry.metadata:
                arguments += paths
            else:
                options += [f"{_flag(entry)}={path}" for path in paths]
        elif Path not in (hint, *get_args(hint)):  # the page names no file of this machine
            options += _typed(entry, hint, left.pop(name))
    if left:
        raise ParameterError(
            f"`dehyst {command}` has no option '{next(iter(left)):.40}' that the studio can set."
        )
    return [command, *options, "--", *arguments], written


@cache
def _hints(command: str) -> dict[str, Any]:
    return get_type_hints(COMMANDS[command])


def _flag(entry: Field[Any]) -> str:
    flag = entry.metadata["flag"] or requests.COMMON.get(entry.name, ("",))[0]
    return str(flag or f"--{entry.name.replace('_', '-')}")


def _ids(entry: Field[Any], hint: Any, value: Any) -> list[Any]:
    """Ids of the files of a field: of one that takes one file a single one."""
    most, words = 1, "one file"
    if _item(hint) is not None:
        most, words = MOST, f"at most {MOST} files"
    ids = [value]
    if isinstance(value, list):
        ids = value
    if len(ids) > most:
        raise ParameterError(f"'{entry.name}' takes {words}.")
    return ids


def _typed(entry: Field[Any], hint: Any, value: Any) -> list[str]:
    """One option as it would be typed, so that no value can be taken for another option.

    Its type and its length are those of the request; what it means is the command line's to judge.
    """
    flag, _, negative = _flag(entry).partition("/")
    item, kinds = _item(hint), get_args(hint) or (hint,)
    if item is not None:
        if not isinstance(value, list) or len(value) > MOST:
            raise ParameterError(f"{flag} takes a list of at most {MOST} values.")
        return [f"{flag}={_word(flag, item, element)}" for element in value]
    pair = next((get_args(kind) for kind in (hint, *kinds) if get_origin(kind) is tuple), None)
    if pair is not None:
        if not isinstance(value, list) or len(value) != len(pair):
            raise ParameterError(f"{flag} takes {len(pair)} values.")
        return [flag, *(_word(flag, kind, end) for kind, end in zip(pair, value, strict=True))]
    if bool in kinds:
        if not isinstance(value, bool):
            raise ParameterError(f"{flag} takes true or false.")
        if value:
            return [flag]
        # A flag that has no negative form is off when it is not typed.
        return list(filter(None, [negative]))
    return [f"{flag}={_word(flag, kinds[0], value)}"]


def _item(hint: Any) -> type[Any] | None:
    """Kind of the values of a list of any length; None of anything else."""
    kinds = get_args(hint)
    if get_origin(hint) is tuple and kinds[1:] == (...,):
        return kinds[0]  # type: ignore[no-any-return]
    return None


def _word(flag: str, kind: type[Any], value: Any) -> str:
    """A value of a kind as a word; for a number nothing but a number."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    text = str(value) if is_number or isinstance(value, str) else None
    if text is None or len(text) > LONGEST or not READS[kind](text):
        raise ParameterError(f"{flag} takes {WORDS[kind]}.")
    return text


def _reads(read: Callable[[str], Any]) -> Callable[[str], bool]:
    """Whether a text can be read so."""

    def can(text: str) -> bool:
        try:
            read(text)
        except ValueError:
            return False
        return "\0" not in text

    return can


MOST = 1000  # values of one option; a log has fewer runs and parts than that
LONGEST = 10_000  # characters of a value; a hundred thresholds have two thousand
READS = {str: _reads(str.encode), int: _reads(int), float: _reads(float)}
WORDS = {str: f"a text of at most {LONGEST} characters", int: "a whole number", float: "a number"}
