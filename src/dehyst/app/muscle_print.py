"""What dehyst muscle prints: the list of models, forces, loops, releases, a fit."""

from __future__ import annotations

import inspect
import io
import math
import re
from functools import cache
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from dehyst.app.terminal import terminal
from dehyst.errors import DehystError
from dehyst.robot.muscles import MuscleModel, muscle_class, names
from dehyst.robot.muscles.bench import Bench
from dehyst.robot.muscles.fit import MuscleFit, parameter_names
from dehyst.robot.muscles.loops import Loop
from dehyst.robot.muscles.release import force_velocity

BAR = 1e5
YEAR = re.compile(r"\b(?:19|20)\d\d\b")
NARROW = 1e-6  # of the range: a loop that is narrower has no hysteresis
HILL = 2.0  # percent of F_0; a curve that misses more is not worth its name
TRIED = 3e5  # Pa, at which is looked whether a model has loops


def title_of(model: MuscleModel | type[MuscleModel]) -> str:
    """Return the first line of a model's page: what it is, and whose."""
    kind = model if isinstance(model, type) else type(model)
    text = inspect.getdoc(inspect.getmodule(kind)) or kind.name
    return text.splitlines()[0].rstrip(".")


@cache
def kind_of(name: str) -> tuple[str, str]:
    """Return whether a model's forces depend on speed, and on what happened before: found by trying.

    Examples
    --------
    >>> kind_of("tondu-lopez")[1]
    'loops'
    """
    from dehyst.robot.muscles.loops import isobaric_loop

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


def list_text() -> str:
    """Return the list as a table for the terminal."""
    table = Table(box=None, pad_edge=False)
    for head in ("model", "speed", "loops", "fits", "what it is"):
        table.add_column(head, justify="right" if head == "fits" else "left")
    table.columns[4].overflow = "fold"
    sets: list[tuple[str, str, str]] = []
    for entry in list_models():
        fitted = len(parameter_names(muscle_class(entry["name"]).published()))
        table.add_row(
            Text(entry["name"], style="bold"),
            "yes" if entry["speed"] else "",
            "yes" if entry["hysteresis"] else "",
            str(fitted),
            Text(entry["title"]),
        )
        sets += [(entry["name"], which, source) for which, source in entry["sets"].items()]
    return _rendered(table) + "\n" + _rendered(_sets(sets)) + "\n" + LEGEND


LEGEND = (
    "speed: the force depends on it; loops: it depends on what happened before; fits: parameters that --log fits\n"
    "next: dehyst muscle MODEL, or dehyst muscle MODEL --set SET\n"
)


def _sets(sets: list[tuple[str, str, str]]) -> Table:
    table = Table(box=None, pad_edge=False)
    for head in ("model", "--set", "source"):
        table.add_column(head, overflow="fold" if head == "source" else "ellipsis")
    for name, which, source in sets:
        table.add_row(Text(name), Text(which), Text(source))
    return table


def _rendered(table: Table) -> str:
    stream = io.StringIO()
    own = terminal()
    Console(file=stream, width=own.width, markup=False, highlight=False).print(table)
    return "\n".join(line.rstrip() for line in stream.getvalue().splitlines()) + "\n"


def print_fit(fit: MuscleFit) -> None:
    """Print how well the log is met, and the parameters."""
    out, covers = terminal(), fit.log.covers
    way = "points at rest" if fit.log.time is None else "a motion"
    out.print(
        Text(
            f"{fit.model.name} fitted to {fit.log.name}: {fit.rmse:.3g} N rms, {fit.rmse_percent:.2f} % of the range "
            f"of force; on samples left out {fit.held_out:.3g} N, {fit.held_out_percent:.2f} %",
            style="bold",
        )
    )
    (k0, k1), (p0, p1) = covers["contraction"], covers["pressure"]
    out.print(
        Text(
            f"{int(fit.used.sum())} of {len(fit.log)} samples, {way}; contraction {100 * k0:.3g} to {100 * k1:.3g} %, "
            f"{p0 / BAR:.3g} to {p1 / BAR:.3g} bar; largest error {fit.largest:.3g} N; {_solved(fit)}"
        )
    )
    out.print()
    table = Table(box=None, pad_edge=False)
    for head in ("parameter", "value", "+-", "unit", "meaning"):
        table.add_column(head, justify="right" if head in ("value", "+-") else "left", overflow="fold")
    names_left = list(parameter_names(fit.model))
    for entry in fit.model.PARAMETERS:
        for name in [each for each in names_left if each.partition("[")[0] == entry.name]:
            error = fit.standard_errors[name]
            value = fit.model.vector()[names_left.index(name)]
            table.add_row(
                Text(name), f"{value:.5g}", _error(fit, name, error), "" if entry.unit == "1" else entry.unit,
                Text(entry.meaning),
            )  # fmt: skip
    out.print(table)
    out.print()


def _solved(fit: MuscleFit) -> str:
    searched = len(parameter_names(fit.model)) - len(fit.linear) - len(fit.without_effect)
    parts = [f"{len(fit.linear)} of {len(parameter_names(fit.model))} parameters in closed form"] if fit.linear else []
    if searched:
        parts.append(f"{searched} searched from {fit.starts} starts (seed {fit.seed})")
    return ", ".join(parts)


def _error(fit: MuscleFit, name: str, error: float | None) -> str:
    if error is not None:
        return f"{error:.2g}"
    if name in fit.without_effect:
        return "kept"
    return "at bound" if name in fit.at_bound else "not told"


def print_bench(bench: Bench) -> None:
    """Print forces, stroke and stiffness, loops, quick release and force over speed."""
    out = terminal()
    out.print(
        Text(f"{bench.model.name}: {title_of(bench.model)}; l_0 = {1e3 * bench.model.length:.4g} mm", style="bold")
    )
    out.print()
    out.print(_forces(bench))
    out.print()
    if bench.isotonic:
        out.print(_loops(bench.isotonic))
        out.print()
    for line in (*_moving(bench), *(f"left out: {text}" for text in bench.skipped)):
        out.print(Text(line))


def _forces(bench: Bench) -> Table:
    found, table = bench.forces, Table(box=None, pad_edge=False)
    table.add_column("force [N] at contraction", no_wrap=True)
    for p in found.pressure:
        table.add_column(f"{p / BAR:.3g} bar", justify="right")
    for k, row in zip(found.contraction, found.force, strict=True):
        table.add_row(f"{100 * k:.3g} %", *(f"{force:.0f}" if force > 0 else "slack" for force in row))
    table.add_row("")
    table.add_row("free contraction [%]", *(_finite(100 * each, ".1f") for each in found.free))
    table.add_row("stiffness half way [N/mm]", *(_finite(each / 1e3, ".3g") for each in found.stiffness))
    loops = {loop.held: loop for loop in bench.isobaric}
    table.add_row("isobaric loop, width [N]", *(_width(loops.get(float(p))) for p in found.pressure))
    return table


def _width(loop: Loop | None) -> str:
    if loop is None:
        return "-"
    return f"{loop.width:.3g}" if loop.width_percent > 1e2 * NARROW else "0"


def _loops(loops: tuple[Loop, ...]) -> Table:
    table = Table(box=None, pad_edge=False)
    for head in ("isotonic", "pressure [bar]", "contraction [%]", "width [%]", "of stroke", "asymmetry"):
        table.add_column(head, justify="left" if head == "isotonic" else "right", no_wrap=True)
    for loop in loops:
        wide = loop.width_percent > 1e2 * NARROW
        table.add_row(
            f"{loop.held:.4g} N",
            f"{loop.drive.min() / BAR:.3g} to {loop.drive.max() / BAR:.3g}",
            f"{100 * loop.response.min():z.2f} to {100 * loop.response.max():z.2f}",
            f"{100 * loop.width:.3g}" if wide else "0",
            f"{loop.width_percent:.2f} %" if wide else "0 %",
            f"{round(loop.asymmetry_percent) or 0:+d} %" if wide else "-",
        )
    return table


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
