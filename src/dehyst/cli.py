"""The command line: builds a parser for every command, and calls the function that runs it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import MISSING, Field, fields
from importlib import import_module
from inspect import Parameter, Signature
from types import ModuleType
from typing import Annotated, Any, get_args, get_type_hints

import typer

from dehyst.app import requests
from dehyst.app.command import Command
from dehyst.app.ending import end
from dehyst.errors import MissingExtraError
from dehyst.plugins import PACKAGE_COMMANDS, added, package_of

COMMANDS = (
    Command("dehyst.app.identify:run_identify", requests.IdentifyRequest),
    Command("dehyst.app.play:run_simulate", requests.SimulateRequest),
    Command("dehyst.app.play:run_compensate", requests.CompensateRequest),
    Command("dehyst.app.inspect:run_inspect", requests.InspectRequest),
    Command("dehyst.app.inspect:run_example", requests.ExampleRequest),
    Command("dehyst.app.doctor:run_doctor", requests.DoctorRequest),
    Command("dehyst.app.design:run_design", requests.DesignRequest),
    Command("dehyst.app.drift:run_drift", requests.DriftRequest),
    Command("dehyst.app.watch:run_watch", requests.WatchRequest),
    Command("dehyst.app.export:run_export", requests.ExportRequest),
    Command("dehyst.app.verify:run_verify", requests.VerifyRequest),
    Command("dehyst.app.compare:run_compare", requests.CompareRequest),
    Command("dehyst.app.evaluate:run_evaluate", requests.EvaluateRequest),
    Command("dehyst.app.page:run_page", requests.PageRequest),
    Command("dehyst.app.studio:run_studio", requests.StudioRequest),
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


def _version(wanted: bool) -> None:
    if wanted:
        from dehyst.version import __version__

        typer.echo(f"dehyst {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """From a logged hysteresis loop to a verified compensator."""


def add(command: Command) -> None:
    """Add a command, which calls its function with a request made of what was typed."""
    request = command.request

    def run(**typed: Any) -> None:
        values = {key: tuple(value) if isinstance(value, list) else value for key, value in typed.items()}
        options = {key: value for key, value in values.items() if value is not None}  # else the default of the request
        module, _, function = command.run.partition(":")
        getattr(_loaded(module), function)(request(**options))

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
    for name, point in points.items():
        if name not in present:
            add(point.load())
    for name in PACKAGE_COMMANDS:
        if name not in points and name not in present:
            app.command(name, hidden=True, context_settings=ANY_WORDS)(_missing(name))


def _missing(name: str) -> Callable[[], None]:
    def run() -> None:
        package = package_of(name)
        raise MissingExtraError(
            f"`dehyst {name}` is a command of {package}, which is not installed. Type: pip install {package}",
            extra=package,
        )

    run.__name__, run.__doc__ = name, f"Of {package_of(name)}, which is not installed."
    return run


def _parameter(entry: Field[Any], hint: Any) -> Parameter:
    """A field of a request as typer knows it: of several values a list."""
    about, metavar, default = entry.metadata["about"], entry.metadata["metavar"], entry.default
    typed: Any
    if "argument" in entry.metadata:
        typed = typer.Argument(help=about, metavar=metavar)
    else:
        flag, about = (entry.metadata["flag"], about) if about else requests.COMMON[entry.name]
        typed = typer.Option(flag or f"--{entry.name.replace('_', '-')}", help=about, metavar=metavar)
    if get_args(hint)[1:] == (...,):
        hint, default = list[get_args(hint)[0]], default or None  # type: ignore[misc]
    default = Parameter.empty if default is MISSING else default
    return Parameter(entry.name, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[hint, typed])


def _loaded(module: str) -> ModuleType:
    """Load what a command needs; on a terminal its first word comes before that."""
    first = "starting ..." if sys.stderr.isatty() else ""
    sys.stderr.write(first)
    sys.stderr.flush()
    loaded = import_module(module)
    sys.stderr.write(f"\r{' ' * len(first)}\r" if first else "")
    return loaded


for _command in COMMANDS:
    add(_command)


def main() -> None:
    """Run the command line; a fault that a user can cure ends with its message and no traceback."""
    words = [word for word in sys.argv[1:] if not word.startswith("-")]
    if not words or words[0] not in {command.name for command in COMMANDS}:
        add_packages()  # looking for them takes longer than everything else here
    end(app)
