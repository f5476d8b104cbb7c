"""dehyst muscle: a muscle model on the test bench, fitted to a log if there is one."""

from __future__ import annotations

import math
import re
from contextlib import suppress
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from rich.table import Column, Table
from rich.text import Text

from dehyst.app import (
    PAGE,
    ask_progress,
    print_end,
    print_findings,
    print_json,
    refuse_clashes,
    refuse_other_model,
    save_model_file,
    table,
)
from dehyst.app import kit as app_kit
from dehyst.arrays import Array
from dehyst.errors import DehystError, ParameterError
from dehyst.shell import command
from dehyst.units import convert, dimension
from dehyst_robot.commands._muscle_log import read_bench_log
from dehyst_robot.commands._policy import POLICY
from dehyst_robot.commands._requests import MuscleRequest
from dehyst_robot.muscles import (
    Bench,
    Loop,
    MuscleFit,
    MuscleModel,
    default_contractions,
    fit_muscle,
    force_velocity,
    isobaric_loop,
    load_muscle,
    muscle,
    muscle_class,
    muscle_names,
    parameter_names,
    run_bench,
)
from dehyst_robot.muscles import kit as muscles_kit

BAR = 1e5
CONTRACTIONS = (-5.0, 50.0)  # percent
PRESSURES = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)  # bar
YEAR = re.compile(r"\b(?:19|20)\d\d\b")
TRIED = 3e5  # Pa, at which is looked whether a model has loops


def run_muscle(request: MuscleRequest) -> None:
    """Make the model, fit it, put it on the bench, write what was asked for, print."""
    if request.list_models:
        if request.json:
            print_json(list_models())
        else:
            _print_list()
        return
    # Before anything is computed: a fit may take a minute.
    _refuse_clashes(request)
    model = _model(request)
    # From here on the bench has the fitted muscle, where there was a log.
    fit, provenance = _fit(request, model)
    if fit is not None:
        model = fit.model
    pressures = _pressures(request, fit)
    contractions = _numbers(request.contractions, "--contractions", CONTRACTIONS, "%", 0.01)
    if contractions is None:
        contractions = default_contractions(model, pressures)
    # No loads typed: the bench chooses some that the muscle can carry.
    loads = _numbers(request.loads, "--loads", (1e-6, 1e6), "N", 1.0)
    bench = run_bench(model, contractions, pressures, loads)
    _write(request, bench, fit, provenance)
    if request.json:
        print_json(_as_dict(bench, fit))
        return
    if fit is not None:
        _print_fit(fit)
    _print_bench(bench)
    if fit is not None:
        print_findings([*fit.log.findings, *fit.findings])
    print_end(
        _next(bench, fit, request),
        model=request.save,
        report=request.report,
        picture=request.figure,
    )


def _as_dict(bench: Bench, fit: MuscleFit | None) -> dict[str, Any]:
    """What ``--json`` prints."""
    document = {
        "format": "dehyst-muscle-bench",
        "title": muscle_title(bench.model),
        **bench.as_dict(),
        "bounds": {},
        "fit": None,
    }
    for entry in bench.model.PARAMETERS:
        if entry.fitted:
            document["bounds"][entry.name] = [entry.low, entry.high]
    if fit is not None:
        document["fit"] = fit.as_dict()
    return document


def _refuse_clashes(request: MuscleRequest) -> None:
    if request.model is None:
        raise ParameterError(
            f"nothing says which model. Type one of: {', '.join(muscle_names())}; or: dehyst muscle --list"
        )
    if request.save is not None and request.log is None:
        raise ParameterError(
            "--save writes what was fitted, but there is no log. Add --log FILE, or leave --save out."
        )
    refuse_clashes(
        [request.log],
        request.overwrite,
        save=(request.save, app_kit.MUSCLE),
        report=(request.report, PAGE),
        figure=(request.figure, app_kit.MUSCLES),
    )
    if request.save is not None and request.log is not None:
        refuse_other_model(request.save, request.overwrite, [request.log], {})


def _model(request: MuscleRequest) -> MuscleModel:
    name = str(request.model)
    changes = dict(map(_parameter, request.parameters))
    if request.length is not None:
        changes["length"] = _length(request.length)
    if not name.lower().endswith(".json"):
        return muscle(name, request.which or "", **changes)
    if request.which is not None:
        raise ParameterError(
            f"--set chooses published parameters, and '{name}' holds its own. Leave --set out."
        )
    # A file of parameters, of a fit for example.
    model = load_muscle(name)
    parameters = {entry.name for entry in model.PARAMETERS}
    for key in changes:
        if key not in parameters:
            raise ParameterError(f"{model.name} has no parameter '{key:.40}'.", parameter=key)
    return replace(model, **changes)  # type: ignore[type-var]


def _parameter(text: str) -> tuple[str, Any]:
    """Name and value of ``--param NAME=VALUE``, a tuple where there are commas."""
    name, equals, value = text.partition("=")
    name = name.strip()
    try:
        # A parameter may be a list, as coefficients are.
        numbers = tuple(map(float, value.split(",")))
    except ValueError:
        numbers = ()
    if not equals or not name or not numbers or not all(map(math.isfinite, numbers)):
        raise ParameterError(
            f"--param {text!r:.60} is not NAME=VALUE with a number, e.g. --param radius=0.01"
        )
    if name == "length":
        return name, _length(value)
    if len(numbers) == 1:
        return name, numbers[0]
    return name, numbers


def _length(text: str) -> float:
    """Length at rest in m, from a number with or without a unit."""
    value, unit = math.nan, "m"
    match = re.fullmatch(r"\s*([0-9.eE+-]+)\s*([A-Za-z]*)\s*", text)
    if match:
        # "1e" and "-" have the characters of a number, but are none.
        with suppress(ValueError):
            value, unit = float(match[1]), match[2] or "m"
    if dimension(unit) != "length" or not math.isfinite(value):
        raise ParameterError(
            f"--length {text!r:.40} is no length. Write it as 0.3 (in metres) or 300mm."
        )
    metres = float(convert(value, unit, "m"))
    if metres <= 0.0:
        raise ParameterError(
            f"--length {text} is not positive. Write it as 0.3 (in metres) or 300mm."
        )
    if metres > POLICY.longest_muscle:
        raise ParameterError(
            f"--length {text} is {metres:g} m, and muscles are up to 9 m long: a number without a unit is in metres. "
            f"Write {text}mm if it is in millimetres.",
            length=metres,
        )
    return metres


def _numbers(
    text: str | None, option: str, limits: tuple[float, float], unit: str, scale: float
) -> Array | None:
    """Numbers of a list with commas, in order, scaled to SI."""
    if text is None:
        return None
    try:
        values = sorted(set(map(float, text.split(","))))
    except ValueError:
        raise ParameterError(
            f"{option} {text!r:.60} is not a list of numbers; write them as 0,5,10 [{unit}]."
        ) from None
    low, high = limits
    for value in values:
        # Written this way round, "nan" is refused too.
        if not low <= value <= high:
            raise ParameterError(
                f"{option}: {value:g} {unit} is outside {low:g} to {high:g} {unit}, which is where muscles "
                f"work. Values are in {unit}.",
                value=value,
            )
    return scale * np.array(values)


def _pressures(request: MuscleRequest, fit: MuscleFit | None) -> Array:
    """Pressures of the bench: those typed, else whole bars within what the log covers."""
    typed = _numbers(request.pressures, "--pressures", (0.0, POLICY.highest_bar), "bar", BAR)
    if typed is not None:
        return typed
    if fit is None:
        return BAR * np.array(PRESSURES)
    low, high = (end / BAR for end in fit.log.covers["pressure"])
    # A little more than the log covers is still covered: gauges have offsets.
    whole = np.arange(max(1.0, math.ceil(low - 0.05)), math.floor(high + 0.05) + 1.0)
    # Too many bars make a table that no terminal holds.
    if 1 <= whole.size <= 8:
        return BAR * whole
    return BAR * np.unique(np.round(np.linspace(low, high, 5), 3))


def _fit(request: MuscleRequest, model: MuscleModel) -> tuple[MuscleFit | None, dict[str, Any]]:
    if request.log is None:
        return None, {}
    with ask_progress("reading", request.json):
        length = None
        if request.length is not None:
            length = _length(request.length)
        log, provenance = read_bench_log(request.log, request, length)
    with ask_progress("fitting", request.json):
        fit = fit_muscle(log, model, seed=request.seed)
    return fit, provenance


def _write(
    request: MuscleRequest, bench: Bench, fit: MuscleFit | None, provenance: dict[str, Any]
) -> None:
    if request.save is not None and fit is not None:
        quality = {
            "rmse_N": fit.rmse,
            "held_out_N": fit.held_out,
            "standard_errors": fit.standard_errors,
            "covers": fit.as_dict()["covers"],
        }
        model = fit.model
        save_model_file(
            request.save,
            request.overwrite,
            lambda path: muscles_kit.save_muscle(model, path, provenance | quality),
        )
    # Pictures need matplotlib, which a run without them does not load.
    if request.report is not None:
        from dehyst_robot.report import write_muscle_report

        write_muscle_report(bench, request.report, title=muscle_title(bench.model), fit=fit)
    if request.figure is not None:
        from dehyst_robot.report import write_muscle_figure

        write_muscle_figure(bench, request.figure, fit)


def _has_loop(loop: Loop) -> bool:
    return loop.width_percent > 1e2 * POLICY.narrow


def muscle_title(model: MuscleModel | type[MuscleModel]) -> str:
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
    speed, loops = "static", "none"
    try:
        loop = isobaric_loop(model, TRIED, 0.02, 0.1)
        velocity = force_velocity(model, TRIED, 0.05, speeds=[0.0, 0.05, 0.2])
    except DehystError:
        # The model cannot be tried there; what it says of itself must do.
        if model.dynamic:
            speed = "dynamic"
        return speed, "?"
    if float(np.ptp(velocity.force[1:])) > 1e-3 * max(velocity.isometric, 1.0):
        speed = "dynamic"
    if _has_loop(loop):
        loops = "loops"
    return speed, loops


def list_models() -> list[dict[str, Any]]:
    """Return every model: name, year, what it shows, parameters, sets with their sources."""
    models = []
    for name in muscle_names():
        kind = muscle_class(name)
        title = muscle_title(kind)
        speed, loops = kind_of(name)
        year = None
        match = YEAR.search(title)
        if match:
            year = int(match[0])
        model = {
            "name": name,
            "title": title,
            "year": year,
            "speed": speed == "dynamic",
            "hysteresis": loops == "loops",
            "parameters": list(map(_parameter_entry, kind.PARAMETERS)),
            "sets": dict(kind.SETS),
        }
        models.append(model)
    return models


def _parameter_entry(entry: Any) -> dict[str, Any]:
    return {
        "name": entry.name,
        "unit": entry.unit,
        "low": entry.low,
        "high": entry.high,
        "meaning": entry.meaning,
        "source": entry.source,
        "fitted": entry.fitted,
    }


def _print_list() -> None:
    out = app_kit.terminal()
    yes = {True: "yes", False: ""}
    rows, sets = [], []
    for entry in list_models():
        name = entry["name"]
        fitted = len(parameter_names(muscle_class(name).published()))
        speed, loops = yes[entry["speed"]], yes[entry["hysteresis"]]
        rows.append((Text(name, style="bold"), speed, loops, str(fitted), entry["title"]))
        for which, source in entry["sets"].items():
            sets.append((name, which, source))
    heads = ("model", "speed", "loops", ">fits", Column("what it is", overflow="fold"))
    out.print(table(heads, rows))
    out.print()
    out.print(table(("model", "--set", Column("source", overflow="fold")), sets))
    out.print(
        "\nspeed: the force depends on it; loops: it depends on what happened before; fits: parameters that --log "
        "fits\n"
        "next: dehyst muscle MODEL, or dehyst muscle MODEL --set SET",
        soft_wrap=True,
    )


def _print_fit(fit: MuscleFit) -> None:
    """Print how well the log is met, and the parameters."""
    out, covers = app_kit.terminal(), fit.log.covers
    # Points without time say nothing about speed.
    way = "a motion"
    if fit.log.time is None:
        way = "points at rest"
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
    rows = []
    for name, value in zip(parameter_names(fit.model), fit.model.vector(), strict=True):
        # "a[0]" is a number of the parameter "a".
        entry = entries[name.partition("[")[0]]
        unit = entry.unit
        if unit == "1":
            unit = ""
        rows.append((name, f"{value:.5g}", _error(fit, name), unit, entry.meaning))
    heads = (
        Column("parameter", overflow="fold"),
        Column("value", justify="right", overflow="fold"),
        Column("+-", justify="right", overflow="fold"),
        Column("unit", overflow="fold"),
        Column("meaning", overflow="fold"),
    )
    out.print(table(heads, rows))
    out.print()


def _solved(fit: MuscleFit) -> str:
    """How the parameters were found: in closed form, or by search."""
    count = len(parameter_names(fit.model))
    searched = count - len(fit.linear) - len(fit.without_effect)
    parts = []
    if fit.linear:
        parts.append(f"{len(fit.linear)} of {count} parameters in closed form")
    if searched:
        parts.append(f"{searched} searched from {fit.starts} starts (seed {fit.seed})")
    return ", ".join(parts)


def _error(fit: MuscleFit, name: str) -> str:
    error = fit.standard_errors[name]
    if error is not None:
        return f"{error:.2g}"
    if name in fit.without_effect:
        return "kept"
    if name in fit.at_bound:
        return "at bound"
    return "not told"


def _print_bench(bench: Bench) -> None:
    """Print forces, stroke and stiffness, loops, quick release and force over speed."""
    out = app_kit.terminal()
    out.print(
        f"{bench.model.name}: {muscle_title(bench.model)}; l_0 = {1e3 * bench.model.length:.4g} mm",
        style="bold",
    )
    out.print()
    out.print(_forces(bench))
    out.print()
    if bench.isotonic:
        heads = (
            "isotonic",
            ">pressure [bar]",
            ">contraction [%]",
            ">width [%]",
            ">of stroke",
            ">asymmetry",
        )
        loops = table(heads, map(_loop, bench.isotonic))
        for column in loops.columns:
            # A wrapped number is two numbers to the eye.
            column.no_wrap = True
        out.print(loops)
        out.print()
    for line in (*_moving(bench), *(f"left out: {text}" for text in bench.skipped)):
        out.print(line)


def _forces(bench: Bench) -> Table:
    """Forces over contraction and pressure, and below them what each pressure gives."""
    forces = bench.forces
    loops = {loop.held: loop for loop in bench.isobaric}
    heads: list[str | Column] = [Column("force [N] at contraction", no_wrap=True)]
    free, stiffness, widths = (
        ["free contraction [%]"],
        ["stiffness half way [N/mm]"],
        ["isobaric loop, width [N]"],
    )
    for k, pressure in enumerate(forces.pressure):
        heads.append(f">{pressure / BAR:.3g} bar")
        free.append(_finite(100 * forces.free[k], ".1f"))
        stiffness.append(_finite(forces.stiffness[k] / 1e3, ".3g"))
        widths.append(_width(loops.get(float(pressure))))
    rows = []
    for contraction, row in zip(forces.contraction, forces.force, strict=True):
        cells = [f"{100 * contraction:.3g} %"]
        for force in row:
            if force > 0:
                cells.append(f"{force:.0f}")
            else:
                cells.append("slack")
        rows.append(cells)
    return table(heads, [*rows, [""], free, stiffness, widths])


def _width(loop: Loop | None) -> str:
    if loop is None:
        return "-"
    if not _has_loop(loop):
        return "0"
    return f"{loop.width:.3g}"


def _loop(loop: Loop) -> tuple[str, ...]:
    # A model without loops has no asymmetry either.
    width, share, asymmetry = "0", "0 %", "-"
    if _has_loop(loop):
        width, share = f"{100 * loop.width:.3g}", f"{loop.width_percent:.2f} %"
        asymmetry = f"{round(loop.asymmetry_percent) or 0:+d} %"
    return (
        f"{loop.held:.4g} N",
        f"{loop.drive.min() / BAR:.3g} to {loop.drive.max() / BAR:.3g}",
        f"{100 * loop.response.min():z.2f} to {100 * loop.response.max():z.2f}",
        width,
        share,
        asymmetry,
    )


def _moving(bench: Bench) -> list[str]:
    """Lines on quick release and force over speed."""
    velocity = bench.velocity
    lines = []
    if bench.releases:
        pressure = bench.forces.pressure[-1]
        if velocity is not None:
            pressure = velocity.pressure
        speeds = []
        for release in bench.releases:
            speeds.append(f"{release.load:.0f} N: {release.peak_speed:.3g} m/s")
        start = f"quick release from 0 % at {pressure / BAR:.3g} bar"
        lines.append(f"{start}, peak speed with a weight of {', '.join(speeds)}")
    if velocity is None:
        return lines
    contraction, pressure = 100 * velocity.contraction, velocity.pressure / BAR
    place = f"shortening through {contraction:.3g} % at {pressure:.3g} bar"
    # At rest the force differs by friction alone, so the first value does not count.
    if float(np.ptp(velocity.force[1:])) <= 1e-6 * max(velocity.isometric, 1.0):
        lines.append(f"{place}: speed does not change the force")
        return lines
    fastest = "more than 10 m/s"
    if math.isfinite(velocity.fastest):
        fastest = f"{velocity.fastest:.3g} m/s"
    hill = ""
    if velocity.hill_percent <= POLICY.hill:
        a, b = velocity.hill
        misses = f"misses {velocity.hill_percent:.2f} %"
        hill = f"; Hill's curve with a/F0 = {a:.3g}, b = {b:.3g} m/s {misses}"
    damping = f"damping {velocity.damping:.3g} N s/m at first"
    lines.append(f"{place}: {damping}, v_max {fastest}{hill}")
    return lines


def _finite(value: float, how: str) -> str:
    if not math.isfinite(value):
        return "-"
    return f"{value:{how}}"


def _next(bench: Bench, fit: MuscleFit | None, request: MuscleRequest) -> str:
    """The line to type after this one."""
    if fit is not None and request.save is not None:
        line = command("muscle", request.save, pressures="0.5,1,2")
        return f"{line} puts the fitted muscle on the bench again"
    if fit is not None:
        return "repeat with --save muscle.json --report muscle.html, or with another model: dehyst muscle --list"
    if str(request.model).lower().endswith(".json"):
        return "the same line with --report muscle.html draws it; --pressures, --loads and --contractions say where"
    name = bench.model.name
    line = command(
        "muscle",
        name,
        log="bench.csv",
        contraction="COLUMN",
        pressure="COLUMN",
        force="COLUMN",
    )
    alternative = ""
    # The set that was just shown is no other one.
    sets = [which for which in muscle_class(name).SETS if which != request.which]
    if len(sets) > 1 or request.which:
        alternative = f", or another set: {command('muscle', name, set=sets[-1])}"
    return f"fit it to your muscle: {line}{alternative}"
