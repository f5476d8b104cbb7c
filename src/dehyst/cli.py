"""Command line: parse, call one function, print."""

from __future__ import annotations

import sys
from dataclasses import MISSING, Field, fields
from importlib import import_module
from inspect import Parameter, Signature
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, get_args, get_type_hints

import typer

from dehyst.app import requests
from dehyst.app.ending import end
from dehyst.app.requests import Json, Log, Overwrite, Run, TimeUnit

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


def _command(run: str, request: type[Any]) -> None:
    """Add the command that calls `run`, "room:function" of `dehyst.app`, with a request made of what was typed."""
    hints = get_type_hints(request, include_extras=True)
    for entry in fields(request):
        if "typed" in entry.metadata:
            hints[entry.name] = Annotated[hints[entry.name], entry.metadata["typed"]]
    room, _, function = run.partition(":")

    def command(**typed: Any) -> None:
        given = {key: tuple(value or ()) if _several(hints[key]) else value for key, value in typed.items()}
        getattr(_loaded(room), function)(request(**given))

    command.__name__, command.__doc__ = request.__name__.removesuffix("Request").lower(), request.__doc__
    command.__annotations__ = {entry.name: _listed(hints[entry.name]) for entry in fields(request)}
    parameters = [
        Parameter(entry.name, Parameter.KEYWORD_ONLY, default=_default(entry), annotation=_listed(hints[entry.name]))
        for entry in fields(request)
    ]
    command.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    app.command()(command)


def _loaded(room: str) -> ModuleType:
    """Load what a command needs; on a terminal its first word comes before that."""
    first = "starting ..." if sys.stderr.isatty() else ""
    sys.stderr.write(first)
    sys.stderr.flush()
    loaded = import_module(f"dehyst.app.{room}")
    sys.stderr.write(f"\r{' ' * len(first)}\r" if first else "")
    return loaded


def _several(hint: Any) -> bool:
    return get_args(get_args(hint)[0])[1:] == (...,)


def _listed(hint: Any) -> Any:
    """The option as typer knows it: of several values a list."""
    kind, *about = get_args(hint)
    return Annotated[list[get_args(kind)[0]], *about] if _several(hint) else hint  # type: ignore[misc]


def _default(entry: Field[Any]) -> Any:
    return Parameter.empty if entry.default is MISSING else None if entry.default == () else entry.default


_command("identify:run_identify", requests.IdentifyRequest)
_command("play:run_simulate", requests.SimulateRequest)
_command("play:run_compensate", requests.CompensateRequest)


@app.command()
def inspect(log: Log, run: Run = None, time_unit: TimeUnit = None, json: Json = False) -> None:
    """Show columns, units, sampling, gaps and loops of a log, and the line to type next."""
    from dehyst.app.inspect import run_inspect

    run_inspect(log, run, json, time_unit)


@app.command()
def example(
    out: Annotated[Path, typer.Option("--out", help="CSV file to write.")] = Path("example.csv"),
    seed: Annotated[int, typer.Option("--seed", help="Seed of the sensor noise.")] = 0,
    overwrite: Overwrite = False,
) -> None:
    """Write an example log: a simulated joint with Maxwell slip and creep."""
    from dehyst.app.example import run_example

    run_example(out, seed, overwrite)


_command("design:run_design", requests.DesignRequest)
_command("reproduce:run_reproduce", requests.ReproduceRequest)
_command("sweep:run_sweep_command", requests.SweepRequest)
_command("drift:run_drift", requests.DriftRequest)
_command("export:run_export", requests.ExportRequest)


@app.command()
def verify(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder written by `dehyst export`.")],
    json: Json = False,
) -> None:
    """Compile and run an export, compare it with the model and with your log, sign it off."""
    from dehyst.app.verify import run_verify

    run_verify(folder, json)


_command("compare:run_compare", requests.CompareRequest)
_command("evaluate:run_evaluate", requests.EvaluateRequest)
_command("muscle:run_muscle", requests.MuscleRequest)


def main() -> None:
    """Run the command line; a fault that a user can cure ends with its message and no traceback."""
    end(app)
