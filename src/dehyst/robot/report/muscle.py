"""The page and the picture of a muscle model on the test bench."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.findings import Grade
from dehyst.report.drawing import Line, chart
from dehyst.report.page import write_page
from dehyst.report.parts import (
    Draw,
    Figure,
    Page,
    Panel,
    Table,
    notes_section,
    numbered,
    tables_section,
    warnings_section,
)
from dehyst.report.svg import write_picture
from dehyst.report.text import number, short
from dehyst.report.theme import CYCLE, DATA, INK, MODEL, MUTED, TEST
from dehyst.robot.muscles.bench import Bench
from dehyst.robot.muscles.experiments import STROKE, Loop, reach
from dehyst.robot.muscles.fit import MuscleFit

TITLE = "dehyst muscle: "  # by which a picture is known that may be drawn anew
BAR = 1e5
DOTS = 500  # of a log on the map
NARROW = 1e-4  # percent of the response's range; a narrower loop is none
NO_LOOPS = "This model has no hysteresis: both ways lie on one line."
HILL = 2.0  # percent of F_0, by which Hill's curve may miss and still be drawn
GOOD, USABLE = 2.0, 5.0  # percent of the range of force, on samples left out
CONTRACTION, PRESSURE, FORCE = "contraction [%]", "pressure [bar]", "force [N]"


def write_muscle_report(
    bench: Bench, path: str | os.PathLike[str], *, title: str = "", fit: MuscleFit | None = None
) -> Path:
    """Write the page of a muscle on the bench: one HTML file that needs nothing else.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from dehyst.robot.muscles import muscle
    >>> from dehyst.robot.muscles.bench import run_bench
    >>> bench = run_bench(muscle("tondu-lopez"), [0.0, 0.1, 0.2], [2e5, 4e5])
    >>> page = write_muscle_report(bench, pathlib.Path(tempfile.mkdtemp()) / "muscle.html")
    >>> page.read_text(encoding="utf-8")[:15]
    '<!DOCTYPE html>'
    """
    badge, grade, lead = _verdict(bench, fit)
    warnings = () if fit is None else (*fit.log.findings, *fit.findings)
    page = Page(
        kind="A muscle model on the bench",
        title=bench.model.name,
        relation=title or "contraction, pressure → force",
        subject="muscle",
        badge=badge,
        grade=grade,
        lead=lead,
        sections=(
            *muscle_figures(bench, fit),
            *warnings_section(warnings),
            tables_section(*_tables(bench, fit)),
            *notes_section([("left out", text) for text in bench.skipped]),
        ),
    )
    return write_page(page, path)


def write_muscle_figure(bench: Bench, path: str | os.PathLike[str], fit: MuscleFit | None = None) -> Path:
    """Write forces, loops and quick release as one picture, ``.svg`` or ``.png``."""
    drawn = [figure for figure in muscle_figures(bench, fit) if figure.key != "fit"]
    panels = [replace(figure.panels[0], title=figure.title) for figure in drawn]
    return write_picture(Figure("muscle", bench.model.name, "", tuple(panels)), path, f"{TITLE}{bench.model.name}")


def _verdict(bench: Bench, fit: MuscleFit | None) -> tuple[str, Grade, str]:
    if fit is None:
        return (
            "not calibrated",
            Grade.CARE,
            "Published or typed parameters: forces of another muscle of the kind may differ by a good deal. Fit it to "
            "a bench log of yours: --log.",
        )
    error = fit.held_out_percent if math.isfinite(fit.held_out_percent) else fit.rmse_percent
    grade = Grade.GOOD if error <= GOOD else Grade.CARE if error <= USABLE else Grade.BAD
    words = ("fits", "fits roughly", "does not fit")[grade]
    lead = (
        f"Fitted to {short(fit.log.name, 60)}: {number(fit.rmse)} N rms ({number(fit.rmse_percent)} % of the range of "
        f"force), on samples left out {number(fit.held_out)} N ({number(fit.held_out_percent)} %)."
    )
    return words, grade, lead


def muscle_figures(bench: Bench, fit: MuscleFit | None = None) -> tuple[Figure, ...]:
    """Return the pictures: the fit, forces, isobaric loops, isotonic loops, quick release and force over speed."""
    drawn = [_fit_figure(fit)] if fit is not None else []
    drawn.append(_map_figure(bench, fit))
    if bench.isobaric:
        drawn.append(
            _loops_figure(
                bench.isobaric,
                False,
                "Isobaric loops: pressure held, length driven",
                "An infinitely slow cycle of contraction at each pressure, after one that settles it.",
                "Lengthening pulls harder than shortening; the right panel shows by how much.",
            )
        )
    if bench.isotonic:
        drawn.append(
            _loops_figure(
                bench.isotonic,
                True,
                "Isotonic loops: load held, pressure driven",
                "An infinitely slow cycle of pressure under each load, from where the muscle just carries it: this is "
                "the loop that a compensator meets.",
                "On the right the distance of its branches; one that leans to a side is an asymmetric loop.",
            )
        )
    if bench.releases:
        drawn.append(_release_figure(bench))
    return numbered(drawn)


def _fit_figure(fit: MuscleFit) -> Figure:
    what, x, used = "points at rest" if fit.log.time is None else "a motion", 100.0 * fit.log.contraction, fit.used
    measured, fitted, missed = (
        np.where(used, y, np.nan) for y in (fit.log.force, fit.force, fit.force - fit.log.force)
    )
    if fit.log.time is None:
        lines = [
            Line(x, measured, DATA, "measured", width=0.0, marker="o"),
            Line(x, fitted, MODEL, "fitted", width=0.0, marker="x"),
        ]
        error = Line(x, missed, TEST, width=0.0, marker="o")
    else:
        lines = [
            Line(x, measured, DATA, "measured", 2.2),
            Line(x, fitted, MODEL, "fitted", 0.9, outline=True, order=3.0),
        ]
        error = Line(x, missed, TEST, width=0.8)
    return Figure(
        "fit",
        "Measured and fitted",
        f"The log as {what}: measured force and that of the fitted model over contraction, and what is left. Samples "
        "at which the muscle hangs loose are not drawn.",
        (
            Panel("Force", chart(CONTRACTION, FORCE, lines), "Measured and fitted force over contraction."),
            Panel(
                "Model less measured",
                chart(CONTRACTION, "error [N]", [error], zero=True),
                f"Error over contraction, {number(fit.rmse)} N rms.",
            ),
        ),
    )


def _map_figure(bench: Bench, fit: MuscleFit | None) -> Figure:
    model, forces = bench.model, bench.forces
    low, high = reach(model)
    most = min(high, 1.05 * float(np.nanmax([*forces.free, forces.contraction[-1]])))
    k, p = np.linspace(low, most, 161), np.linspace(0.0, float(forces.pressure.max()), 81)
    over_contraction = [(_bar(each), 100 * k, model.static_force(k, np.full(k.size, each))) for each in forces.pressure]
    over_pressure = [
        (f"{100 * each:.3g} %", p / BAR, model.static_force(np.full(p.size, each), p)) for each in forces.contraction
    ]
    words = f"At {_bar(forces.pressure[-1])} it pulls up to {number(100 * forces.free[-1])} % of contraction."
    return Figure(
        "forces",
        "Static forces",
        "Force at rest over contraction at each pressure, where it pulls; and over pressure at each contraction: "
        "straight lines are what a controller can invert in closed form."
        + (" Dots: the log." if fit is not None else ""),
        (
            Panel(
                "Force over contraction",
                chart(CONTRACTION, FORCE, [*_dots(fit), *_pulling(over_contraction)]),
                f"Falling curves. {words}",
            ),
            Panel("Force over pressure", chart(PRESSURE, FORCE, _pulling(over_pressure)), "Rising curves."),
        ),
    )


def _pulling(curves: Sequence[tuple[str, Array, Array]]) -> list[Line]:
    """Curves where the force is not negative, each in its colour; those that never pull are left out."""
    shown = [(name, x, np.where(force >= 0, force, np.nan)) for name, x, force in curves]
    return _in_colours([curve for curve in shown if np.isfinite(curve[2]).sum() > 1], 1.5)


def _in_colours(curves: Sequence[tuple[str, Array, Array]], width: float) -> list[Line]:
    return [Line(x, y, CYCLE[i % len(CYCLE)], name, width) for i, (name, x, y) in enumerate(curves)]


def _dots(fit: MuscleFit | None) -> list[Line]:
    """Samples of the log that pull, at most `DOTS` of them."""
    if fit is None:
        return []
    which = np.flatnonzero(fit.used)
    which = which[:: -(-which.size // DOTS)]
    return [
        Line(100 * fit.log.contraction[which], fit.log.force[which], MUTED, width=0.0, alpha=0.7, marker=".", order=3)
    ]


def _loops_figure(loops: Sequence[Loop], isotonic: bool, title: str, caption: str, more: str) -> Figure:
    """Loops, and the distance of their branches where they have one."""
    key, across, up = ("isotonic", PRESSURE, CONTRACTION) if isotonic else ("isobaric", CONTRACTION, FORCE)
    pairs = [(_held(loop, isotonic), *_shown(loop, isotonic)) for loop in loops]
    name = f"{up.partition(' [')[0]} over {across.partition(' [')[0]}".capitalize()
    panels = [Panel(name, chart(across, up, _in_colours(pairs, 1.2)), f"Loops of {name}.")]
    if any(loop.width_percent > NARROW for loop in loops):
        gaps = [(held, x[: STROKE + 1], y[: STROKE - 1 : -1] - y[: STROKE + 1]) for held, x, y in pairs]
        widest = max(loops, key=lambda loop: loop.width)
        wide = f"{100 * widest.width:.3g} %" if isotonic else f"{number(widest.width)} N"
        words = f"Distance of the branches, at {_held(widest, isotonic)} up to {wide}."
        name = "Falling less rising pressure" if isotonic else "Lengthening less shortening"
        panels.append(Panel(name, chart(across, up, _in_colours(gaps, 1.2), include=(0.0,)), words))
    else:
        more = NO_LOOPS
    return Figure(key, title, f"{caption} {more}", tuple(panels))


def _release_figure(bench: Bench) -> Figure:
    speed = bench.velocity
    released = [(f"{number(each.load)} N", 1e3 * each.time, 100 * each.contraction) for each in bench.releases]
    draw = chart("time [ms]", CONTRACTION, _in_colours(released, 1.3))
    panels = [Panel("After the release", draw, "Contraction over time, one line a load.")]
    if speed is not None:
        words = f"Contraction {number(100 * speed.contraction)} %, {_bar(speed.pressure)}."
        panels.append(Panel("Force over speed of shortening", _speed(bench), words))
    return Figure(
        "release",
        "Quick release",
        f"Held at contraction 0 at {_bar(speed.pressure if speed else bench.forces.pressure[-1])} and let go with a "
        "weight that is lighter than the force: what is left of the oscillation shows the damping. On the right the "
        "force at constant speed through one contraction, with Hill's curve where it fits.",
        tuple(panels),
    )


def _bar(pressure: float) -> str:
    return f"{pressure / BAR:.4g}\u00a0bar"


def _shown(loop: Loop, isotonic: bool) -> tuple[Array, Array]:
    """Drive and response as drawn: contraction in percent, pressure in bar."""
    return (loop.drive / BAR, 100 * loop.response) if isotonic else (100 * loop.drive, loop.response)


def _held(loop: Loop, isotonic: bool) -> str:
    return f"{number(loop.held)} N" if isotonic else _bar(loop.held)


def _speed(bench: Bench) -> Draw:
    found = bench.velocity
    assert found is not None
    a, b = found.hill
    lines = [Line(found.speed, found.force, CYCLE[0], "model", 1.8)]
    if found.hill_percent <= HILL:
        curve = found.isometric * ((1.0 + a) * b / (found.speed + b) - a)
        lines.append(Line(found.speed, curve, INK, f"Hill, a = {number(a)} of F₀", 1.0, dashes=(0, (4, 3))))
    lines.append(Line(np.zeros(1), np.array([found.isometric]), TEST, "at rest", width=0.0, marker="o"))
    return chart("speed of shortening [m/s]", FORCE, lines, include=(0.0,))


def _tables(bench: Bench, fit: MuscleFit | None) -> tuple[Table, ...]:
    found = [_force_table(bench), _figures_table(bench), _loop_table(bench), _parameter_table(bench, fit)]
    if bench.releases:
        rows = tuple(
            (f"{number(each.load)} N", number(each.mass), number(each.peak_speed), number(100 * each.peak_contraction))
            for each in bench.releases
        )
        head = ("load after the release", "mass [kg]", "peak speed [m/s]", "at contraction [%]")
        found.insert(3, Table("Quick release", head, rows))
    return tuple(found)


def _force_table(bench: Bench) -> Table:
    head = ("contraction", *(f"{p / BAR:.3g} bar" for p in bench.forces.pressure))
    rows = tuple(
        (f"{100 * k:.3g} %", *(number(force) if force > 0 else "slack" for force in row))
        for k, row in zip(bench.forces.contraction, bench.forces.force, strict=True)
    )
    return Table("Force at rest [N]", head, rows, "slack: the formula is not above zero, and a muscle does not push")


def _figures_table(bench: Bench) -> Table:
    found = bench.forces
    rows = tuple(
        (_bar(p), number(blocked), number(100 * free) if math.isfinite(free) else "–", number(stiffness / 1e3))
        for p, blocked, free, stiffness in zip(found.pressure, found.blocked, found.free, found.stiffness, strict=True)
    )
    head = ("pressure", "blocked force [N]", "free contraction [%]", "stiffness half way [N/mm]")
    return Table("Stroke and stiffness", head, rows)


def _loop_table(bench: Bench) -> Table:
    rows = tuple(
        (
            f"{'isotonic' if isotonic else 'isobaric'}, {_held(loop, isotonic)}",
            f"{number(100 * loop.width)} %" if isotonic else f"{number(loop.width)} N",
            number(loop.width_percent),
            number(round(loop.asymmetry_percent, 1) or 0.0) if loop.width else "–",
        )
        for loops, isotonic in ((bench.isobaric, False), (bench.isotonic, True))
        for loop in loops
    )
    note = "asymmetry: how much more of the loop's area lies over the upper half of what is driven"
    return Table("Loops", ("loop", "width", "width [% of range]", "asymmetry [%]"), rows, note)


def _parameter_table(bench: Bench, fit: MuscleFit | None) -> Table:
    model, errors = bench.model, {} if fit is None else fit.standard_errors
    rows: list[tuple[str, ...]] = []
    for entry in model.PARAMETERS:
        value = getattr(model, entry.name)
        for i, each in enumerate(value if isinstance(value, tuple) else (value,)):
            name = f"{entry.name}[{i}]" if isinstance(value, tuple) else entry.name
            error = errors.get(name)
            told = () if fit is None else ("–" if error is None else f"± {number(error, 2)}",)
            unit = "" if entry.unit == "1" else entry.unit
            rows.append((name, number(each, 5), *told, unit, entry.meaning, entry.source))
    if fit is None:
        return Table("Parameters", ("parameter", "value", "unit", "meaning", "source"), tuple(rows))
    head = ("parameter", "value", "standard error", "unit", "meaning", "source of the default")
    return Table("Parameters", head, tuple(rows), "–: kept as given, at a bound, or not told by the log")
