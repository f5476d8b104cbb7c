"""dehyst muscle: a muscle model on the test bench, fitted to a log if there is one."""

from __future__ import annotations

import json
import math
import re
import sys
from dataclasses import replace
from typing import Any

import numpy as np

from dehyst.app.muscle_log import read_bench_log
from dehyst.app.muscle_print import list_models, list_text, print_bench, print_fit, title_of
from dehyst.app.requests import MuscleRequest
from dehyst.app.targets import MUSCLE, MUSCLES, PAGE, refuse_clashes, refuse_other_model, save_model
from dehyst.app.terminal import ask_progress, print_end, print_findings, print_json, terminal
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.robot.muscles import MuscleModel, muscle, muscle_class, names
from dehyst.robot.muscles.bench import Bench, default_contractions, run_bench
from dehyst.robot.muscles.fit import MuscleFit, fit_muscle
from dehyst.robot.muscles.storage import load_muscle, save_muscle
from dehyst.shell import quoted, typed
from dehyst.units import convert, dimension

BAR = 1e5
HIGHEST = 20.0  # bar
CONTRACTIONS = (-5.0, 50.0)  # percent
PRESSURES = tuple(float(p) for p in range(1, 7))  # bar
LONGEST = 20.0  # m; muscles are sold up to 9 m


def run_muscle(request: MuscleRequest) -> None:
    """Make the model, fit it, put it on the bench, write what was asked for, print."""
    if request.list_models:
        sys.stdout.write(json.dumps(list_models(), indent=1) + "\n" if request.json else list_text())
        return
    _refuse_clashes(request)
    model = _model(request)
    fit, provenance = _fit(request, model)
    model = model if fit is None else fit.model
    pressures = _pressures(request, fit)
    contractions = _numbers(request.contractions, "--contractions", CONTRACTIONS, "%", 0.01)
    bench = run_bench(
        model,
        default_contractions(model, pressures) if contractions is None else contractions,
        pressures,
        _numbers(request.loads, "--loads", (1e-6, 1e6), "N", 1.0),
    )
    _write(request, bench, fit, provenance)
    if request.json:
        print_json(_facts(bench, fit, request))
    else:
        _print(bench, fit, request)


def _refuse_clashes(request: MuscleRequest) -> None:
    if request.model is None:
        raise ParameterError(f"nothing says which model. Type one of: {', '.join(names())}; or: dehyst muscle --list")
    if request.save is not None and request.log is None:
        raise ParameterError("--save writes what was fitted, but there is no log. Add --log FILE, or leave --save out.")
    refuse_clashes(
        [request.log], request.overwrite, save=(request.save, MUSCLE), report=(request.report, PAGE),
        figure=(request.figure, MUSCLES),
    )  # fmt: skip
    if request.save is not None and request.log is not None:
        refuse_other_model(request.save, request.overwrite, [request.log], {})


def _model(request: MuscleRequest) -> MuscleModel:
    name = str(request.model)
    changes = dict(_parameter(text) for text in request.parameters)
    if request.length is not None:
        changes["length"] = _length(request.length)
    if name.lower().endswith(".json"):
        if request.which is not None:
            raise ParameterError(f"--set chooses published parameters, and '{name}' holds its own. Leave --set out.")
        model = load_muscle(name)
        unknown = [key for key in changes if key not in {entry.name for entry in model.PARAMETERS}]
        if unknown:
            raise ParameterError(f"{model.name} has no parameter '{unknown[0]:.40}'.", parameter=unknown[0])
        return replace(model, **changes)  # type: ignore[type-var]
    return muscle(name, request.which or "", **changes)


def _parameter(text: str) -> tuple[str, Any]:
    """Name and value of ``--param NAME=VALUE``, a tuple where there are commas."""
    name, equals, value = text.partition("=")
    try:
        numbers = tuple(float(part) for part in value.split(","))
    except ValueError:
        numbers = ()
    if not equals or not name.strip() or not numbers or not all(map(math.isfinite, numbers)):
        raise ParameterError(f"--param {text!r:.60} is not NAME=VALUE with a number, e.g. --param radius=0.01")
    if name.strip() == "length":
        return "length", _length(value)
    return name.strip(), numbers[0] if len(numbers) == 1 else numbers


def _length(text: str) -> float:
    """Length at rest in m, from a number with or without a unit."""
    found = re.fullmatch(r"\s*([0-9.eE+-]+)\s*([A-Za-z]*)\s*", text)
    try:
        value, unit = float(found[1]) if found else math.nan, (found[2] if found else "") or "m"
    except ValueError:
        value, unit = math.nan, "m"
    if dimension(unit) != "length" or not math.isfinite(value):
        raise ParameterError(f"--length {text!r:.40} is no length. Write it as 0.3 (in metres) or 300mm.")
    metres = float(convert(value, unit, "m"))
    if not 0.0 < metres <= LONGEST:
        if metres <= 0.0:
            raise ParameterError(f"--length {text} is not positive. Write it as 0.3 (in metres) or 300mm.")
        raise ParameterError(
            f"--length {text} is {metres:g} m, and muscles are up to 9 m long: a number without a unit is in metres. "
            f"Write {text}mm if it is in millimetres.",
            length=metres,
        )
    return metres


def _numbers(text: str | None, option: str, limits: tuple[float, float], unit: str, scale: float) -> Array | None:
    """Numbers of a list with commas, in order, scaled to SI."""
    if text is None:
        return None
    try:
        found = sorted({float(part) for part in text.split(",")})
    except ValueError:
        raise ParameterError(
            f"{option} {text!r:.60} is not a list of numbers; write them as 0,5,10 [{unit}]."
        ) from None
    wrong = [value for value in found if not limits[0] <= value <= limits[1]]
    if wrong:
        raise ParameterError(
            f"{option}: {wrong[0]:g} {unit} is outside {limits[0]:g} to {limits[1]:g} {unit}, which is where muscles "
            f"work. Values are in {unit}.",
            value=wrong[0],
        )
    return scale * np.array(found)


def _pressures(request: MuscleRequest, fit: MuscleFit | None) -> Array:
    given = _numbers(request.pressures, "--pressures", (0.0, HIGHEST), "bar", BAR)
    if given is not None:
        return given
    if fit is None:
        return BAR * np.array(PRESSURES)
    low, high = (end / BAR for end in fit.log.covers["pressure"])
    whole = np.arange(max(1.0, math.ceil(low - 0.05)), math.floor(high + 0.05) + 1.0)
    return BAR * (whole if 1 <= whole.size <= 8 else np.unique(np.round(np.linspace(low, high, 5), 3)))


def _fit(request: MuscleRequest, model: MuscleModel) -> tuple[MuscleFit | None, dict[str, Any]]:
    if request.log is None:
        return None, {}
    with ask_progress("reading", request.json):
        log, provenance = read_bench_log(
            request.log, request, None if request.length is None else _length(request.length)
        )
    with ask_progress("fitting", request.json):
        fit = fit_muscle(log, model, seed=request.seed)
    return fit, provenance


def _write(request: MuscleRequest, bench: Bench, fit: MuscleFit | None, provenance: dict[str, Any]) -> None:
    if request.save is not None and fit is not None:
        kept = {"rmse_N": fit.rmse, "held_out_N": fit.held_out, "standard_errors": fit.standard_errors}
        kept["covers"] = fit.as_dict()["covers"]
        model = fit.model
        save_model(request.save, request.overwrite, lambda path: save_muscle(model, path, provenance | kept))
    if request.report is not None:
        from dehyst.robot.report.muscle import write_muscle_report

        write_muscle_report(bench, request.report, title=title_of(bench.model), fit=fit)
    if request.figure is not None:
        from dehyst.robot.report.muscle import write_muscle_figure

        write_muscle_figure(bench, request.figure, fit)


def _facts(bench: Bench, fit: MuscleFit | None, request: MuscleRequest) -> dict[str, Any]:

    found = {"format": "dehyst-muscle-bench", "title": title_of(bench.model), **bench.as_dict()}
    found["bounds"] = {entry.name: [entry.low, entry.high] for entry in bench.model.PARAMETERS if entry.fitted}
    found["fit"] = None if fit is None else fit.as_dict()
    return found


def _print(bench: Bench, fit: MuscleFit | None, request: MuscleRequest) -> None:
    out = terminal()
    if fit is not None:
        print_fit(fit)
    print_bench(bench)
    if fit is not None:
        print_findings([*fit.log.findings, *fit.findings])
    print_end(out, _next(bench, fit, request), model=request.save, report=request.report, picture=request.figure)


def _next(bench: Bench, fit: MuscleFit | None, request: MuscleRequest) -> str:
    if str(request.model).lower().endswith(".json") and fit is None:
        return "the same line with --report muscle.html draws it; --pressures, --loads and --contractions say where"
    if fit is None:
        sets = [each for each in muscle_class(bench.model.name).SETS if each != request.which]
        other = f", or another set: --set {quoted(sets[-1])}" if len(sets) > 1 or request.which else ""
        return (
            f"fit it to your muscle: dehyst muscle {bench.model.name} --log bench.csv --contraction COLUMN --pressure "
            f"COLUMN --force COLUMN{other}"
        )
    if request.save is None:
        return "repeat with --save muscle.json --report muscle.html, or with another model: dehyst muscle --list"
    line = typed(["dehyst", "muscle", request.save, "--pressures", "0.5,1,2"])
    return f"{line} puts the fitted muscle on the bench again"
