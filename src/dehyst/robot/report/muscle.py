"""A muscle model on the test bench -> one picture, and one self-contained HTML page."""

from __future__ import annotations

import math
import os
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.files import write_atomically
from dehyst.findings import Grade
from dehyst.report.figures.panel import Axes, Figure, Panel, add_legend, draw_path, label_axes, says
from dehyst.report.rendering import Sheet, sheet_page
from dehyst.report.svg import write_picture
from dehyst.report.tables import Table
from dehyst.report.text import number, short
from dehyst.report.theme import CYCLE, DATA, INK, MODEL, MUTED, TEST, Token
from dehyst.report.thin import Window
from dehyst.robot.muscles.bench import Bench
from dehyst.robot.muscles.fit import MuscleFit
from dehyst.robot.muscles.force_map import reach
from dehyst.robot.muscles.loops import STROKE, Loop

TITLE = "dehyst muscle: "  # by which a picture is known that may be drawn anew
BAR = 1e5
FEW_DOTS, MANY_DOTS = 120, 500  # of a log on the map
ONE_ROW = 4  # entries of a legend
NARROW = 1e-4  # percent of the response's range; a narrower loop is none
NO_LOOPS = "This model has no hysteresis: both ways lie on one line."
HILL = 2.0  # percent of F_0, by which Hill's curve may miss and still be drawn
GOOD, USABLE = 2.0, 5.0  # percent of the range of force, on samples left out


def write_muscle_report(
    bench: Bench, path: str | os.PathLike[str], *, title: str = "", fit: MuscleFit | None = None
) -> Path:
    """Write the page of a muscle on the bench: one HTML file that needs nothing else and runs nothing.

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
    return write_atomically(path, muscle_page(bench, title, fit))


def write_muscle_figure(bench: Bench, path: str | os.PathLike[str], fit: MuscleFit | None = None) -> Path:
    """Write forces, loops and quick release as one picture, ``.svg`` or ``.png``."""
    drawn = [figure for figure in muscle_figures(bench, fit) if figure.key != "fit"]
    panels = [replace(figure.panels[0], title=figure.title) for figure in drawn]
    return write_picture(Figure("muscle", bench.model.name, "", tuple(panels)), path, f"{TITLE}{bench.model.name}")


def muscle_page(bench: Bench, title: str = "", fit: MuscleFit | None = None) -> str:
    """Return the text of the page."""
    badge, grade, lead = _verdict(bench, fit)
    warnings = () if fit is None else (*fit.log.findings, *fit.findings)
    return sheet_page(
        Sheet(
            kind="A muscle model on the bench",
            title=bench.model.name,
            relation=title or "contraction, pressure → force",
            subject="muscle",
            badge=badge,
            grade=grade,
            lead=lead,
            figures=muscle_figures(bench, fit),
            warnings=warnings,
            tables=_tables(bench, fit),
            notes=[("left out", text) for text in bench.skipped],
        )
    )


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
        drawn.append(_isobaric_figure(bench))
    if bench.isotonic:
        drawn.append(_isotonic_figure(bench))
    if bench.releases:
        drawn.append(_release_figure(bench))
    return tuple(drawn)


def _fit_figure(fit: MuscleFit) -> Figure:
    what = "points at rest" if fit.log.time is None else "a motion"
    return Figure(
        "fit",
        "Measured and fitted",
        f"The log as {what}: measured force and that of the fitted model over contraction, and what is left. Samples "
        "at which the muscle hangs loose are not drawn.",
        (
            Panel("Force", partial(_draw_fit, fit), says("Measured and fitted force over contraction.")),
            Panel(
                "Model less measured",
                partial(_draw_missed, fit),
                says(f"Error over contraction, {number(fit.rmse)} N rms."),
            ),
        ),
    )


def _map_figure(bench: Bench, fit: MuscleFit | None) -> Figure:
    free = bench.forces.free[-1]
    words = f"At {_bar(bench.forces.pressure[-1])} it pulls up to {number(100 * free)} % of contraction."
    return Figure(
        "forces",
        "Static forces",
        "Force at rest over contraction at each pressure, where it pulls; and over pressure at each contraction: "
        "straight lines are what a controller can invert in closed form."
        + (" Dots: the log." if fit is not None else ""),
        (
            Panel("Force over contraction", partial(_draw_map, bench, fit), says("Falling curves.", words)),
            Panel("Force over pressure", partial(_draw_over_pressure, bench), says("Rising curves.")),
        ),
    )


def _isobaric_figure(bench: Bench) -> Figure:
    loops = bench.isobaric
    widest = max(loops, key=lambda loop: loop.width)
    panels = [Panel("Force over contraction", partial(_draw_loops, loops, "force [N]", False), says("Loops."))]
    if _has_loops(loops):
        draw = partial(_draw_gaps, loops, "force [N]", False)
        words = says(f"At {_bar(widest.held)} up to {number(widest.width)} N.")
        panels.append(Panel("Lengthening less shortening", draw, words))
        more = "Lengthening pulls harder than shortening; the right panel shows by how much."
    else:
        more = NO_LOOPS
    return Figure(
        "isobaric",
        "Isobaric loops: pressure held, length driven",
        f"An infinitely slow cycle of contraction at each pressure, after one that settles it. {more}",
        tuple(panels),
    )


def _isotonic_figure(bench: Bench) -> Figure:
    loops = bench.isotonic
    draw = partial(_draw_loops, loops, "contraction [%]", True)
    panels = [Panel("Contraction over pressure", draw, says("Loops of contraction over pressure."))]
    if _has_loops(loops):
        draw = partial(_draw_gaps, loops, "contraction [%]", True)
        panels.append(Panel("Falling less rising pressure", draw, says("Distance of the branches over pressure.")))
        more = "On the right the distance of its branches; one that leans to a side is an asymmetric loop."
    else:
        more = NO_LOOPS
    return Figure(
        "isotonic",
        "Isotonic loops: load held, pressure driven",
        "An infinitely slow cycle of pressure under each load, from where the muscle just carries it: this is the loop "
        f"that a compensator meets. {more}",
        tuple(panels),
    )


def _has_loops(loops: tuple[Loop, ...]) -> bool:
    return any(loop.width_percent > NARROW for loop in loops)


def _release_figure(bench: Bench) -> Figure:
    speed = bench.velocity
    panels = [
        Panel("After the release", partial(_draw_releases, bench), says("Contraction over time, one line a load.")),
    ]
    if speed is not None:
        words = f"Contraction {number(100 * speed.contraction)} %, {_bar(speed.pressure)}."
        panels.append(Panel("Force over speed of shortening", partial(_draw_speed, bench), says(words)))
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


def _tokens(count: int) -> list[Token]:
    return [CYCLE[k % len(CYCLE)] for k in range(count)]


def _draw_fit(fit: MuscleFit, axes: Axes) -> None:
    x = 100.0 * fit.log.contraction
    if fit.log.time is None:
        keep = fit.used
        label_axes(axes, Window.around((x[keep], fit.log.force[keep])), "contraction [%]", "force [N]")
        axes.plot(x[keep], fit.log.force[keep], "o", ms=5.5, mew=0.0, color=DATA.light, label="measured")
        axes.plot(x[keep], fit.force[keep], "x", ms=5.0, mew=1.1, color=MODEL.light, label="fitted")
        add_legend(axes)
        return
    measured, fitted = (np.where(fit.used, values, np.nan) for values in (fit.log.force, fit.force))
    window = Window.around((x, measured), (x, fitted))
    label_axes(axes, window, "contraction [%]", "force [N]")
    draw_path(axes, x, measured, window, DATA, label="measured", width=2.2)
    draw_path(axes, x, fitted, window, MODEL, label="fitted", width=0.9, outline=True)
    add_legend(axes)


def _draw_missed(fit: MuscleFit, axes: Axes) -> None:
    x, missed = 100.0 * fit.log.contraction, np.where(fit.used, fit.force - fit.log.force, np.nan)
    window = Window.around((x, missed), (x[:1], np.zeros(1)))
    label_axes(axes, window, "contraction [%]", "error [N]")
    axes.axhline(0.0, color=MUTED.light, lw=0.8, zorder=1)
    if fit.log.time is None:
        axes.plot(x, missed, "o", ms=4.0, mew=0.0, color=TEST.light)
    else:
        draw_path(axes, x, missed, window, TEST, label="error", width=0.8)


def _draw_map(bench: Bench, fit: MuscleFit | None, axes: Axes) -> None:
    model, pressures = bench.model, bench.forces.pressure
    low, high = reach(model)
    most = min(high, 1.05 * float(np.nanmax([*bench.forces.free, bench.forces.contraction[-1]])))
    k = np.linspace(low, most, 161)
    curves = [model.static_force(k, np.full(k.size, p)) for p in pressures]
    shown = [np.where(force >= 0, force, np.nan) for force in curves]
    dots = [] if fit is None else [_dots(fit)]
    label_axes(axes, Window.around(*((100 * k, force) for force in shown), *dots), "contraction [%]", "force [N]")
    for x, y in dots:
        size = 3.2 if x.size <= FEW_DOTS else 1.8
        axes.plot(x, y, "o", ms=size, mew=0.0, color=MUTED.light, alpha=0.8, zorder=3)
    for p, force, token in zip(pressures, shown, _tokens(len(shown)), strict=True):
        axes.plot(100 * k, force, color=token.light, lw=1.5, label=_bar(p))
    _legend(axes)


def _dots(fit: MuscleFit) -> tuple[Array, Array]:
    """Samples of the log that pull, at most `MANY_DOTS` of them."""
    which = np.flatnonzero(fit.used)
    which = which[:: -(-which.size // MANY_DOTS)]
    return 100 * fit.log.contraction[which], fit.log.force[which]


def _draw_over_pressure(bench: Bench, axes: Axes) -> None:
    p = np.linspace(0.0, float(bench.forces.pressure.max()), 81)
    places = bench.forces.contraction
    curves = [bench.model.static_force(np.full(p.size, k), p) for k in places]
    shown = [(k, np.where(force >= 0, force, np.nan)) for k, force in zip(places, curves, strict=True)]
    shown = [(k, force) for k, force in shown if np.isfinite(force).sum() > 1]
    label_axes(axes, Window.around(*((p / BAR, force) for _, force in shown)), "pressure [bar]", "force [N]")
    for (k, force), token in zip(shown, _tokens(len(shown)), strict=True):
        axes.plot(p / BAR, force, color=token.light, lw=1.5, label=f"{100 * k:.3g} %")
    _legend(axes)


def _shown(loop: Loop, isotonic: bool) -> tuple[Array, Array]:
    """Drive and response as drawn: contraction in percent, pressure in bar."""
    if isotonic:
        return loop.drive / BAR, 100 * loop.response
    return 100 * loop.drive, loop.response


def _held(loop: Loop, isotonic: bool) -> str:
    return f"{number(loop.held)} N" if isotonic else _bar(loop.held)


def _draw_loops(loops: tuple[Loop, ...], up: str, isotonic: bool, axes: Axes) -> None:
    across = "pressure [bar]" if isotonic else "contraction [%]"
    pairs = [_shown(loop, isotonic) for loop in loops]
    label_axes(axes, Window.around(*pairs), across, up)
    for loop, (x, y), token in zip(loops, pairs, _tokens(len(loops)), strict=True):
        axes.plot(x, y, color=token.light, lw=1.2, label=_held(loop, isotonic))
    _legend(axes)


def _draw_gaps(loops: tuple[Loop, ...], up: str, isotonic: bool, axes: Axes) -> None:
    across = "pressure [bar]" if isotonic else "contraction [%]"
    pairs = []
    for loop in loops:
        x, y = _shown(loop, isotonic)
        pairs.append((x[: STROKE + 1], y[: STROKE - 1 : -1] - y[: STROKE + 1]))
    label_axes(axes, Window.around(*pairs, (pairs[0][0][:1], np.zeros(1))), across, up)
    for loop, (x, y), token in zip(loops, pairs, _tokens(len(loops)), strict=True):
        axes.plot(x, y, color=token.light, lw=1.2, label=_held(loop, isotonic))
    _legend(axes)


def _draw_releases(bench: Bench, axes: Axes) -> None:
    pairs = [(1e3 * each.time, 100 * each.contraction) for each in bench.releases]
    label_axes(axes, Window.around(*pairs), "time [ms]", "contraction [%]")
    for each, (x, y), token in zip(bench.releases, pairs, _tokens(len(pairs)), strict=True):
        axes.plot(x[::5], y[::5], color=token.light, lw=1.3, label=f"{number(each.load)} N")
    _legend(axes)


def _legend(axes: Axes) -> None:
    """Put the legend above the panel, in two rows where there are many entries."""
    many = len(axes.get_legend_handles_labels()[1])
    if many <= ONE_ROW:
        add_legend(axes)
        return
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.115), ncols=-(-many // 2), labelcolor=INK.light)


def _draw_speed(bench: Bench, axes: Axes) -> None:
    found = bench.velocity
    assert found is not None
    a, b = found.hill
    window = Window.around((found.speed, found.force), (np.zeros(1), np.zeros(1)))
    label_axes(axes, window, "speed of shortening [m/s]", "force [N]")
    axes.plot(found.speed, found.force, color=CYCLE[0].light, lw=1.8, label="model")
    if found.hill_percent <= HILL:
        curve = found.isometric * ((1.0 + a) * b / (found.speed + b) - a)
        axes.plot(found.speed, curve, color=INK.light, lw=1.0, ls=(0, (4, 3)), label=f"Hill, a = {number(a)} of F₀")
    axes.plot([0.0], [found.isometric], "o", ms=4.5, mew=0.0, color=TEST.light, label="at rest")
    _legend(axes)


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
