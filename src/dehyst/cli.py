"""The command line: builds a parser for every command, and calls the function that runs it."""

from __future__ import annotations

import sys
from dataclasses import MISSING, Field, fields
from importlib import import_module
from inspect import Parameter, Signature
from types import ModuleType
from typing import Annotated, Any, get_args, get_type_hints

import typer

from dehyst.app import requests
from dehyst.app.ending import end

COMMANDS: dict[str, type[Any]] = {  # module of `dehyst.app` and the function there -> what it is given
    "identify:run_identify": requests.IdentifyRequest,
    "play:run_simulate": requests.SimulateRequest,
    "play:run_compensate": requests.CompensateRequest,
    "inspect:run_inspect": requests.InspectRequest,
    "inspect:run_example": requests.ExampleRequest,
    "doctor:run_doctor": requests.DoctorRequest,
    "design:run_design": requests.DesignRequest,
    "reproduce:run_reproduce": requests.ReproduceRequest,
    "rig:run_rig": requests.RigRequest,
    "sweep:run_sweep_command": requests.SweepRequest,
    "drift:run_drift": requests.DriftRequest,
    "watch:run_watch": requests.WatchRequest,
    "export:run_export": requests.ExportRequest,
    "verify:run_verify": requests.VerifyRequest,
    "compare:run_compare": requests.CompareRequest,
    "evaluate:run_evaluate": requests.EvaluateRequest,
    "muscle:run_muscle": requests.MuscleRequest,
    "page:run_page": requests.PageRequest,
    "studio:run_studio": requests.StudioRequest,
}
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


def add(run: str, request: type[Any]) -> None:
    """Add the command that calls `run` with a request made of what was typed."""
    module, _, function = run.partition(":")

    def command(**typed: Any) -> None:
        given = {key: tuple(value) if isinstance(value, list) else value for key, value in typed.items()}
        told = {key: value for key, value in given.items() if value is not None}  # else the default of the request
        getattr(_loaded(module), function)(request(**told))

    hints = get_type_hints(request)
    parameters = [_parameter(entry, hints[entry.name]) for entry in fields(request)]
    command.__name__, command.__doc__ = request.__name__.removesuffix("Request").lower(), request.__doc__
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    command.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    app.command()(command)


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
    loaded = import_module(f"dehyst.app.{module}")
    sys.stderr.write(f"\r{' ' * len(first)}\r" if first else "")
    return loaded


for _run, _request in COMMANDS.items():
    add(_run, _request)


def main() -> None:
    """Run the command line; a fault that a user can cure ends with its message and no traceback."""
    end(app)
