"""The command line: builds a parser for every command, and calls the function that runs it."""

from __future__ import annotations

import gc
import sys
from dataclasses import MISSING, Field, fields
from importlib import import_module
from inspect import Parameter, Signature
from types import ModuleType
from typing import Annotated, Any, get_args, get_type_hints

import typer

from dehyst.app import Command, end, requests
from dehyst.errors import MissingExtraError, ParameterError
from dehyst.plugins import COMMANDS as PACKAGE_COMMANDS
from dehyst.plugins import added, load_added

COMMANDS = (
    Command("dehyst.app._identify:run_identify", requests.IdentifyRequest),
    Command("dehyst.app._coupled:run_coupled", requests.CoupledRequest),
    Command("dehyst.app._play:run_simulate", requests.SimulateRequest),
    Command("dehyst.app._play:run_compensate", requests.CompensateRequest),
    Command("dehyst.app._inspect:run_inspect", requests.InspectRequest),
    Command("dehyst.app._loops:run_loops", requests.LoopsRequest),
    Command("dehyst.app._sensor:run_sensor", requests.SensorRequest),
    Command("dehyst.app._inspect:run_example", requests.ExampleRequest),
    Command("dehyst.app._doctor:run_doctor", requests.DoctorRequest),
    Command("dehyst.app._design:run_design", requests.DesignRequest),
    Command("dehyst.app._drift:run_drift", requests.DriftRequest),
    Command("dehyst.app._export:run_export", requests.ExportRequest),
    Command("dehyst.app._verify:run_verify", requests.VerifyRequest),
    Command("dehyst.app._compare:run_compare", requests.CompareRequest),
    Command("dehyst.app._evaluate:run_evaluate", requests.EvaluateRequest),
)
GROUP = "dehyst.commands"
ANY_WORDS = {"ignore_unknown_options": True, "allow_extra_args": True}


app = typer.Typer(
    name="dehyst",
    help="From a logged hysteresis loop to a verified compensator.",
    epilog="Begin with `dehyst inspect LOG`, or with `dehyst example` if you have no log yet.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help: starting rich would cost more than the command
)


def _version(asked: bool) -> None:
    if asked:
        from dehyst.version import __version__

        typer.echo(f"dehyst {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_version, is_eager=True, help="Print the version and stop."
        ),
    ] = False,
) -> None:
    """From a logged hysteresis loop to a verified compensator."""


def add(command: Command) -> None:
    """Add a command, which calls its function with a request made of what was typed."""
    request = command.request

    def run(**typed: Any) -> None:
        options = {}
        for key, value in typed.items():
            # What was not typed has the default of the request.
            if value is None:
                continue
            options[key] = value
            if isinstance(value, list):
                options[key] = tuple(value)
        module, _, function = command.run.partition(":")
        work = getattr(_loaded(module), function)
        _look_for_garbage()
        work(request(**options))

    hints = get_type_hints(request)
    parameters = [_parameter(entry, hints[entry.name]) for entry in fields(request)]
    run.__name__, run.__doc__ = command.name, request.__doc__
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    run.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    app.command()(run)


def add_packages() -> None:
    """Add the commands of other packages, and of those that are missing one that says what to type; once."""
    present = {entry.callback.__name__ for entry in app.registered_commands if entry.callback}
    points = added(GROUP)
    # One order on every machine: that of entry points depends on how a disk lists its folders.
    for name in (*PACKAGE_COMMANDS, *sorted(set(points) - set(PACKAGE_COMMANDS))):
        if name in present:
            continue
        if name not in points:
            package = PACKAGE_COMMANDS[name]
            _add_refusal(
                name,
                MissingExtraError(
                    f"`dehyst {name}` is a command of {package}, which is not installed. "
                    f"Type: pip install {package}",
                    extra=package,
                ),
            )
            continue
        try:
            add(load_added(GROUP, name))
        # A package that is broken must not take the other commands with it.
        except ParameterError as broken:
            missing = broken.__cause__
            # A package that its package needs is named with what to type, as everywhere.
            _add_refusal(name, missing if isinstance(missing, ModuleNotFoundError) else broken)


def _add_refusal(name: str, why: Exception) -> None:
    """Add a command that cannot run, and says why and what to type."""

    def run() -> None:
        raise why

    run.__name__, run.__doc__ = name, "Cannot run here; call it to see why."
    app.command(name, hidden=True, context_settings=ANY_WORDS)(run)


def _parameter(entry: Field[Any], hint: Any) -> Parameter:
    """A field of a request as typer knows it: of several values a list."""
    about, metavar, default = entry.metadata["about"], entry.metadata["metavar"], entry.default
    typed: Any
    if "argument" in entry.metadata:
        typed = typer.Argument(help=about, metavar=metavar)
    else:
        # An option without words of its own means the same in all commands that have it.
        if not about:
            about = requests.COMMON[entry.name][1]
        typed = typer.Option(_flag(entry), help=about, metavar=metavar)
    if get_args(hint)[1:] == (...,):
        hint, default = list[get_args(hint)[0]], default or None  # type: ignore[misc]
    if default is MISSING:
        default = Parameter.empty
    return Parameter(
        entry.name, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[hint, typed]
    )


def _loaded(module: str) -> ModuleType:
    """Load what a command needs; on a terminal its first word comes before that."""
    # In a file the word would stay for ever.
    if not sys.stderr.isatty():
        return import_module(module)
    first = "starting ..."
    sys.stderr.write(first)
    sys.stderr.flush()
    loaded = import_module(module)
    sys.stderr.write(f"\r{' ' * len(first)}\r")
    return loaded


def _look_for_garbage() -> None:
    """Look for garbage from now on, but not among what was loaded, where the process began without."""
    if not gc.isenabled():
        gc.freeze()
        gc.enable()


def _run() -> None:
    for command in COMMANDS:
        if command.name in sys.argv[1:2]:
            _refuse_repeated(command, sys.argv[2:])
    app()


def _refuse_repeated(command: Command, words: list[str]) -> None:
    """Refuse an option of one value that was typed twice: the first value would be lost without a word."""
    hints = get_type_hints(command.request)
    for entry in fields(command.request):
        if "argument" in entry.metadata or get_args(hints[entry.name])[1:] == (...,):
            continue
        flag = _flag(entry)
        typed = [word for word in words if word == flag or word.startswith(f"{flag}=")]
        if len(typed) > 1:
            cure = "Leave one of them out."
            if flag in ("--input", "--output"):
                cure = (
                    "Several inputs or outputs: dehyst coupled. One of each: leave the others out."
                )
            raise ParameterError(
                f"{flag} was typed {len(typed)} times, and dehyst {command.name} takes one value for it. {cure}",
                option=flag,
            )


def _flag(entry: Field[Any]) -> str:
    if entry.metadata["about"]:
        return entry.metadata["flag"] or f"--{entry.name.replace('_', '-')}"
    return requests.COMMON[entry.name][0]


for _command in COMMANDS:
    add(_command)


def main() -> None:
    """Run the command line; a fault that a user can cure ends with its message and no traceback."""
    words = [word for word in sys.argv[1:] if not word.startswith("-")]
    if not words or words[0] not in {command.name for command in COMMANDS}:
        add_packages()  # looking for them takes longer than everything else here
    end(_run)
