"""dehyst muscle: a muscle model on the test bench, fitted to a log if there is one."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from rich.table import Column, Table
from rich.text import Text

from dehyst.app.targets import MUSCLE, MUSCLES, PAGE, refuse_clashes, refuse_other_model, save_model
from dehyst.app.terminal import ask_progress, print_end, print_findings, print_json, table, terminal
from dehyst.arrays import Array
from dehyst.errors import DehystError, ParameterError
from dehyst.robot.commands.muscle_log import read_bench_log
from dehyst.robot.commands.requests import MuscleRequest
from dehyst.robot.muscles import MuscleModel, muscle, muscle_class, names
from dehyst.robot.muscles.bench import Bench, default_contractions, run_bench
from dehyst.robot.muscles.experiments import Loop, force_velocity, isobaric_loop
from dehyst.robot.muscles.fit import MuscleFit, fit_muscle
from dehyst.robot.muscles.parameters import parameter_names
from dehyst.robot.muscles.registry import load_muscle, save_muscle
from dehyst.shell import command
from dehyst.units import convert, dimension

BAR = 1e5
HIGHEST = 20.0  # bar
CONTRACTIONS = (-5.0, 50.0)  # percent
PRESSURES = tuple(float(p) for p in range(1, 7))  # bar
LONGEST = 20.0  # m; muscles are sold up to 9 m
YEAR = re.compile(r"\b(?:19|20)\d\d\b")
NARROW = 1e-6  # of the range: a loop that is narrower has no hysteresis
HILL = 2.0  # percent of F_0; a curve that misses more is not worth its name
TRIED = 3e5  # Pa, at which is looked whether a model has loops


def run_muscle(request: MuscleRequest) -> None:
    """Make the model, fit it, put it on the bench, write what was asked for, print."""
    if request.list_models:
        if request.json:
            print_json(list_models())
        else:
            _print_list()
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
        found = {"format": "dehyst-muscle-bench", "title": title_of(bench.model), **bench.as_dict()}
        found["bounds"] = {entry.name: [entry.low, entry.high] for entry in bench.model.PARAMETERS if entry.fitted}
        found["fit"] = None if fit is None else fit.as_dict()
        print_json(found)
        return
    if fit is not None:
        _print_fit(fit)
    _print_bench(bench)
    if fit is not None:
        print_findings([*fit.log.findings, *fit.findings])
    print_end(_next(bench, fit, request), model=request.save, report=request.report, picture=request.figure)


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


def title_of(model: MuscleModel | type[MuscleModel]) -> str:
    """Return the first line of a model's docstring, and of its page: what it is, and whose."""
    return (model.__doc__ or model.name).splitlines()[0].rstrip(".")


@cache
def kind_of(name: str) -> tuple[str, str]:
    """Return whether a model's forces depend on speed, and on what happened before: found by trying.

    Examples
    --------
    >>> kind_of("tondu-lopez")[1]
    'loops'
    """
    model = muscle_class(name).published()
    try:
        loop = isobaric_loop(model, TRIED, 0.02, 0.1)
        speed = force_velocity(model, TRIED, 0.05, speeds=[0.0, 0.05, 0.2])
    except DehystError:
        return ("dynamic" if model.dynamic else "static", "?")
    spread = float(np.ptp(speed.force[1:]))
    moves = "dynamic" if spread > 1e-3 * max(speed.isometric, 1.0) else "static"
    return moves, "loops" if loop.width_percent > 1e2 * NARROW else "none"


def list_models() -> list[dict[str, Any]]:
    """Return every model: name, year, what it shows, parameters, sets with their sources."""
    found = []
    for name in names():
        kind = muscle_class(name)
        title = title_of(kind)
        moves, loops = kind_of(name)
        year = YEAR.search(title)
        found.append(
            {
                "name": name,
                "title": title,
                "year": int(year[0]) if year else None,
                "speed": moves == "dynamic",
                "hysteresis": loops == "loops",
                "parameters": [
                    {
                        "name": entry.name, "unit": entry.unit, "low": entry.low, "high": entry.high,
                        "meaning": entry.meaning, "source": entry.source, "fitted": entry.fitted,
                    }
                    for entry in kind.PARAMETERS
                ],
                "sets": dict(kind.SETS),
            }
        )  # fmt: skip
    return found


def _print_list() -> None:
    out, models = terminal(), list_models()
    rows = [
        (
            Text(entry["name"], style="bold"), "yes" if entry["speed"] else "", "yes" if entry["hysteresis"] else "",
            str(len(parameter_names(muscle_class(entry["name"]).published()))), entry["title"],
        )
        for entry in models
    ]  # fmt: skip
    out.print(table(("model", "speed", "loops", ">fits", Column("what it is", overflow="fold")), rows))
    out.print()
    sets = [(entry["name"], which, source) for entry in models for which, source in entry["sets"].items()]
    out.print(table(("model", "--set", Column("source", overflow="fold")), sets))
    out.print(
        "\nspeed: the force depends on it; loops: it depends on what happened before; fits: parameters that --log "
        "fits\n"
        "next: dehyst muscle MODEL, or dehyst muscle MODEL --set SET",
        soft_wrap=True,
    )


def _print_fit(fit: MuscleFit) -> None:
    """Print how well the log is met, and the parameters."""
    out, covers = terminal(), fit.log.covers
    way = "points at rest" if fit.log.time is None else "a motion"
    out.print(
        f"{fit.model.name} fitted to {fit.log.name}: {fit.rmse:.3g} N rms, {fit.rmse_percent:.2f} % of the range of "
        f"force; on samples left out {fit.held_out:.3g} N, {fit.held_out_percent:.2f} %",
        style="bold",
    )
    (k0, k1), (p0, p1) = covers["contraction"], covers["pressure"]
    out.print(
        f"{int(fit.used.sum())} of {len(fit.log)} samples, {way}; contraction {100 * k0:.3g} to {100 * k1:.3g} %, "
        f"{p0 / BAR:.3g} to {p1 / BAR:.3g} bar; largest error {fit.largest:.3g} N; {_solved(fit)}"
    )
    out.print()
    entries = {entry.name: entry for entry in fit.model.PARAMETERS}
    found = zip(parameter_names(fit.model), fit.model.vector(), strict=True)
    rows = []
    for name, value in found:
        entry = entries[name.partition("[")[0]]
        rows.append((name, f"{value:.5g}", _error(fit, name), "" if entry.unit == "1" else entry.unit, entry.meaning))
    numbers = [Column(head, justify="right", overflow="fold") for head in ("value", "+-")]
    words = [Column(head, overflow="fold") for head in ("parameter", "unit", "meaning")]
    out.print(table((words[0], *numbers, *words[1:]), rows))
    out.print()


def _solved(fit: MuscleFit) -> str:
    searched = len(parameter_names(fit.model)) - len(fit.linear) - len(fit.without_effect)
    parts = [f"{len(fit.linear)} of {len(parameter_names(fit.model))} parameters in closed form"] if fit.linear else []
    if searched:
        parts.append(f"{searched} searched from {fit.starts} starts (seed {fit.seed})")
    return ", ".join(parts)


def _error(fit: MuscleFit, name: str) -> str:
    error = fit.standard_errors[name]
    if error is not None:
        return f"{error:.2g}"
    if name in fit.without_effect:
        return "kept"
    return "at bound" if name in fit.at_bound else "not told"


def _print_bench(bench: Bench) -> None:
    """Print forces, stroke and stiffness, loops, quick release and force over speed."""
    out = terminal()
    out.print(f"{bench.model.name}: {title_of(bench.model)}; l_0 = {1e3 * bench.model.length:.4g} mm", style="bold")
    out.print()
    out.print(_forces(bench))
    out.print()
    if bench.isotonic:
        heads = ("isotonic", ">pressure [bar]", ">contraction [%]", ">width [%]", ">of stroke", ">asymmetry")
        loops = table(heads, map(_loop, bench.isotonic))
        for column in loops.columns:
            column.no_wrap = True
        out.print(loops)
        out.print()
    for line in (*_moving(bench), *(f"left out: {text}" for text in bench.skipped)):
        out.print(line)


def _forces(bench: Bench) -> Table:
    found = bench.forces
    loops = {loop.held: loop for loop in bench.isobaric}
    rows = [
        (f"{100 * k:.3g} %", *(f"{force:.0f}" if force > 0 else "slack" for force in row))
        for k, row in zip(found.contraction, found.force, strict=True)
    ]
    rows += [
        ("",),
        ("free contraction [%]", *(_finite(100 * each, ".1f") for each in found.free)),
        ("stiffness half way [N/mm]", *(_finite(each / 1e3, ".3g") for each in found.stiffness)),
        ("isobaric loop, width [N]", *(_width(loops.get(float(p))) for p in found.pressure)),
    ]
    return table(
        (Column("force [N] at contraction", no_wrap=True), *(f">{p / BAR:.3g} bar" for p in found.pressure)), rows
    )


def _width(loop: Loop | None) -> str:
    if loop is None:
        return "-"
    return f"{loop.width:.3g}" if loop.width_percent > 1e2 * NARROW else "0"


def _loop(loop: Loop) -> tuple[str, ...]:
    wide = loop.width_percent > 1e2 * NARROW
    return (
        f"{loop.held:.4g} N",
        f"{loop.drive.min() / BAR:.3g} to {loop.drive.max() / BAR:.3g}",
        f"{100 * loop.response.min():z.2f} to {100 * loop.response.max():z.2f}",
        f"{100 * loop.width:.3g}" if wide else "0",
        f"{loop.width_percent:.2f} %" if wide else "0 %",
        f"{round(loop.asymmetry_percent) or 0:+d} %" if wide else "-",
    )


def _moving(bench: Bench) -> list[str]:
    """Lines on quick release and force over speed."""
    lines = []
    if bench.releases:
        at = bench.velocity.pressure if bench.velocity else bench.forces.pressure[-1]
        speeds = ", ".join(f"{each.load:.0f} N: {each.peak_speed:.3g} m/s" for each in bench.releases)
        lines.append(f"quick release from 0 % at {at / BAR:.3g} bar, peak speed with a weight of {speeds}")
    found = bench.velocity
    if found is None:
        return lines
    place = f"shortening through {100 * found.contraction:.3g} % at {found.pressure / BAR:.3g} bar"
    spread = float(np.ptp(found.force[1:]))
    if spread <= 1e-6 * max(found.isometric, 1.0):
        lines.append(f"{place}: speed does not change the force")
        return lines
    fastest = f"{found.fastest:.3g} m/s" if math.isfinite(found.fastest) else "more than 10 m/s"
    hill = ""
    if found.hill_percent <= HILL:
        a, b = found.hill
        hill = f"; Hill's curve with a/F0 = {a:.3g}, b = {b:.3g} m/s misses {found.hill_percent:.2f} %"
    lines.append(f"{place}: damping {found.damping:.3g} N s/m at first, v_max {fastest}{hill}")
    return lines


def _finite(value: float, how: str) -> str:
    return f"{value:{how}}" if math.isfinite(value) else "-"


def _next(bench: Bench, fit: MuscleFit | None, request: MuscleRequest) -> str:
    if str(request.model).lower().endswith(".json") and fit is None:
        return "the same line with --report muscle.html draws it; --pressures, --loads and --contractions say where"
    if fit is None:
        sets = [each for each in muscle_class(bench.model.name).SETS if each != request.which]
        several = len(sets) > 1 or request.which
        other = f", or another set: {command('muscle', bench.model.name, set=sets[-1])}" if several else ""
        line = command(
            "muscle", bench.model.name, log="bench.csv", contraction="COLUMN", pressure="COLUMN", force="COLUMN"
        )
        return f"fit it to your muscle: {line}{other}"
    if request.save is None:
        return "repeat with --save muscle.json --report muscle.html, or with another model: dehyst muscle --list"
    line = command("muscle", request.save, pressures="0.5,1,2")
    return f"{line} puts the fitted muscle on the bench again"
