"""The page and the picture of a muscle model on the test bench."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.findings import Grade
from dehyst.report import Draw, Page, PageFigure, PageTable, Panel, PanelLine, chart
from dehyst.report import kit as report_kit
from dehyst_robot.muscles import Bench, Loop, MuscleFit, contraction_reach
from dehyst_robot.muscles import kit as muscles_kit
from dehyst_robot.report._policy import POLICY

TITLE = "dehyst muscle: "  # by which a picture is known that may be drawn anew
BAR = 1e5
DOTS = 500  # of a log on the map
NO_LOOPS = "This model has no hysteresis: both ways lie on one line."
CONTRACTION, PRESSURE, FORCE = "contraction [%]", "pressure [bar]", "force [N]"


def write_muscle_report(
    bench: Bench, path: str | os.PathLike[str], *, title: str = "", fit: MuscleFit | None = None
) -> Path:
    """Write the page of a muscle on the bench: one HTML file that needs nothing else.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from dehyst_robot.muscles import muscle
    >>> from dehyst_robot.muscles import run_bench
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
            *report_kit.warnings_section(warnings),
            report_kit.tables_section(*_tables(bench, fit)),
            *report_kit.notes_section([("left out", text) for text in bench.skipped]),
        ),
    )
    return report_kit.write_page(page, path)


def write_muscle_figure(
    bench: Bench, path: str | os.PathLike[str], fit: MuscleFit | None = None
) -> Path:
    """Write forces, loops and quick release as one picture, ``.svg`` or ``.png``."""
    panels = []
    for figure in muscle_figures(bench, fit):
        if figure.key != "fit":
            panels.append(replace(figure.panels[0], title=figure.title))
    name = bench.model.name
    return report_kit.write_picture(
        PageFigure("muscle", name, "", tuple(panels)), path, f"{TITLE}{name}"
    )


def _verdict(bench: Bench, fit: MuscleFit | None) -> tuple[str, Grade, str]:
    if fit is None:
        return (
            "not calibrated",
            Grade.CARE,
            "Published or typed parameters: forces of another muscle of the kind may differ by a good deal. Fit it to "
            "a bench log of yours: --log.",
        )
    # A short log leaves no samples out; then the fitted ones must do.
    error = fit.held_out_percent
    if not math.isfinite(error):
        error = fit.rmse_percent
    if error <= POLICY.good:
        badge, grade = "fits", Grade.GOOD
    elif error <= POLICY.usable:
        badge, grade = "fits roughly", Grade.CARE
    else:
        badge, grade = "does not fit", Grade.BAD
    number = report_kit.number
    lead = (
        f"Fitted to {report_kit.short(fit.log.name, 60)}: {number(fit.rmse)} N rms ({number(fit.rmse_percent)} % "
        f"of the range of force), on samples left out {number(fit.held_out)} N ({number(fit.held_out_percent)} %)."
    )
    return badge, grade, lead


def muscle_figures(bench: Bench, fit: MuscleFit | None = None) -> tuple[PageFigure, ...]:
    """Return the pictures: the fit, forces, isobaric loops, isotonic loops, quick release and force over speed."""
    drawn = []
    if fit is not None:
        drawn.append(_fit_figure(fit))
    drawn.append(_map_figure(bench, fit))
    if bench.isobaric:
        drawn.append(
            _loops_figure(
                bench.isobaric,
                ISOBARIC,
                "An infinitely slow cycle of contraction at each pressure, after one that settles it.",
                "Lengthening pulls harder than shortening; the right panel shows by how much.",
            )
        )
    if bench.isotonic:
        drawn.append(
            _loops_figure(
                bench.isotonic,
                ISOTONIC,
                "An infinitely slow cycle of pressure under each load, from where the muscle just carries it: this is "
                "the loop that a compensator meets.",
                "On the right the distance of its branches; one that leans to a side is an asymmetric loop.",
            )
        )
    if bench.releases:
        drawn.append(_release_figure(bench))
    return report_kit.numbered(drawn)


@dataclass(frozen=True)
class _LoopKind:
    """How loops of a kind are driven, named and drawn."""

    key: str
    title: str
    across: str  # the axis of what is driven
    up: str  # the axis of the response
    difference: str  # between the branches
    isotonic: bool

    def name_of(self, loop: Loop) -> str:
        """Return what is constant in the loop: its load or its pressure."""
        if self.isotonic:
            return f"{report_kit.number(loop.held)} N"
        return _bar(loop.held)

    def curve_of(self, loop: Loop) -> tuple[Array, Array]:
        """Return drive and response as drawn: contraction in percent, pressure in bar."""
        if self.isotonic:
            return loop.drive / BAR, 100 * loop.response
        return 100 * loop.drive, loop.response


ISOBARIC = _LoopKind(
    "isobaric",
    "Isobaric loops: pressure held, length driven",
    CONTRACTION,
    FORCE,
    "Lengthening less shortening",
    False,
)


ISOTONIC = _LoopKind(
    "isotonic",
    "Isotonic loops: load held, pressure driven",
    PRESSURE,
    CONTRACTION,
    "Falling less rising pressure",
    True,
)


def _fit_figure(fit: MuscleFit) -> PageFigure:
    log = fit.log
    x = 100.0 * log.contraction
    measured = np.where(fit.used, log.force, np.nan)
    fitted = np.where(fit.used, fit.force, np.nan)
    missed = np.where(fit.used, fit.force - log.force, np.nan)
    # Points at rest have no order that a line could follow.
    if log.time is None:
        kind = "points at rest"
        lines = [
            PanelLine(x, measured, report_kit.DATA, "measured", width=0.0, marker="o"),
            PanelLine(x, fitted, report_kit.MODEL, "fitted", width=0.0, marker="x"),
        ]
        error = PanelLine(x, missed, report_kit.TEST, width=0.0, marker="o")
    else:
        kind = "a motion"
        lines = [
            PanelLine(x, measured, report_kit.DATA, "measured", 2.2),
            PanelLine(x, fitted, report_kit.MODEL, "fitted", 0.9, outline=True, order=3.0),
        ]
        error = PanelLine(x, missed, report_kit.TEST, width=0.8)
    return PageFigure(
        "fit",
        "Measured and fitted",
        f"The log as {kind}: measured force and that of the fitted model over contraction, and what is left. Samples "
        "at which the muscle hangs loose are not drawn.",
        (
            Panel(
                "Force",
                chart(CONTRACTION, FORCE, lines),
                "Measured and fitted force over contraction.",
            ),
            Panel(
                "Model less measured",
                chart(CONTRACTION, "error [N]", [error], zero=True),
                f"Error over contraction, {report_kit.number(fit.rmse)} N rms.",
            ),
        ),
    )


def _map_figure(bench: Bench, fit: MuscleFit | None) -> PageFigure:
    model, forces = bench.model, bench.forces
    low, high = contraction_reach(model)
    most = min(high, 1.05 * float(np.nanmax([*forces.free, forces.contraction[-1]])))
    k, p = np.linspace(low, most, 161), np.linspace(0.0, float(forces.pressure.max()), 81)
    over_contraction = []
    for pressure in forces.pressure:
        force = model.static_force(k, np.full(k.size, pressure))
        over_contraction.append((_bar(pressure), 100 * k, force))
    over_pressure = []
    for contraction in forces.contraction:
        force = model.static_force(np.full(p.size, contraction), p)
        over_pressure.append((f"{100 * contraction:.3g} %", p / BAR, force))
    caption = (
        "Force at rest over contraction at each pressure, where it pulls; and over pressure at each contraction: "
        "straight lines are what a controller can invert in closed form."
    )
    if fit is not None:
        caption += " Dots: the log."
    free = report_kit.number(100 * forces.free[-1])
    return PageFigure(
        "forces",
        "Static forces",
        caption,
        (
            Panel(
                "Force over contraction",
                chart(CONTRACTION, FORCE, [*_dots(fit), *_pulling(over_contraction)]),
                f"Falling curves. At {_bar(forces.pressure[-1])} it pulls up to {free} % of contraction.",
            ),
            Panel(
                "Force over pressure",
                chart(PRESSURE, FORCE, _pulling(over_pressure)),
                "Rising curves.",
            ),
        ),
    )


def _pulling(curves: Sequence[tuple[str, Array, Array]]) -> list[PanelLine]:
    """Curves where the force is not negative, each in its colour; those that never pull are left out."""
    shown = []
    for name, x, force in curves:
        pull = np.where(force >= 0, force, np.nan)
        if np.isfinite(pull).sum() > 1:
            shown.append((name, x, pull))
    return _in_colours(shown, 1.5)


def _in_colours(curves: Sequence[tuple[str, Array, Array]], width: float) -> list[PanelLine]:
    lines = []
    for (name, x, y), colour in zip(curves, itertools.cycle(report_kit.CYCLE), strict=False):
        lines.append(PanelLine(x, y, colour, name, width))
    return lines


def _dots(fit: MuscleFit | None) -> list[PanelLine]:
    """Samples of the log that pull, at most `DOTS` of them."""
    if fit is None:
        return []
    which = np.flatnonzero(fit.used)
    which = which[:: -(-which.size // DOTS)]
    return [
        PanelLine(
            100 * fit.log.contraction[which],
            fit.log.force[which],
            report_kit.MUTED,
            width=0.0,
            alpha=0.7,
            marker=".",
            order=3,
        )
    ]


def _loops_figure(loops: Sequence[Loop], kind: _LoopKind, caption: str, more: str) -> PageFigure:
    """Loops, and the distance of their branches where they have one."""
    curves, gaps = [], []
    stroke = muscles_kit.STROKE
    for loop in loops:
        name = kind.name_of(loop)
        x, y = kind.curve_of(loop)
        curves.append((name, x, y))
        # The way back runs through the same places in reverse.
        gaps.append((name, x[: stroke + 1], y[: stroke - 1 : -1] - y[: stroke + 1]))
    across, up = kind.across, kind.up
    title = f"{up.partition(' [')[0]} over {across.partition(' [')[0]}".capitalize()
    panels = [Panel(title, chart(across, up, _in_colours(curves, 1.2)), f"Loops of {title}.")]
    # Without a loop there is no second panel, but a sentence.
    if any(loop.width_percent > POLICY.narrow for loop in loops):
        widest = max(loops, key=lambda loop: loop.width)
        width = f"{report_kit.number(widest.width)} N"
        if kind.isotonic:
            width = f"{100 * widest.width:.3g} %"
        words = f"Distance of the branches, at {kind.name_of(widest)} up to {width}."
        draw = chart(across, up, _in_colours(gaps, 1.2), include=(0.0,))
        panels.append(Panel(kind.difference, draw, words))
    else:
        more = NO_LOOPS
    return PageFigure(kind.key, kind.title, f"{caption} {more}", tuple(panels))


def _release_figure(bench: Bench) -> PageFigure:
    released = []
    for release in bench.releases:
        load = f"{report_kit.number(release.load)} N"
        released.append((load, 1e3 * release.time, 100 * release.contraction))
    draw = chart("time [ms]", CONTRACTION, _in_colours(released, 1.3))
    panels = [Panel("After the release", draw, "Contraction over time, one line a load.")]
    pressure = bench.forces.pressure[-1]
    speed = bench.velocity
    if speed is not None:
        pressure = speed.pressure
        words = f"Contraction {report_kit.number(100 * speed.contraction)} %, {_bar(pressure)}."
        panels.append(Panel("Force over speed of shortening", _speed(bench), words))
    return PageFigure(
        "release",
        "Quick release",
        f"Held at contraction 0 at {_bar(pressure)} and let go with a "
        "weight that is lighter than the force: what is left of the oscillation shows the damping. On the right the "
        "force at constant speed through one contraction, with Hill's curve where it fits.",
        tuple(panels),
    )


def _bar(pressure: float) -> str:
    return f"{pressure / BAR:.4g}\u00a0bar"


def _speed(bench: Bench) -> Draw:
    velocity = bench.velocity
    assert velocity is not None
    a, b = velocity.hill
    speed = velocity.speed
    lines = [PanelLine(speed, velocity.force, report_kit.CYCLE[0], "model", 1.8)]
    if velocity.hill_percent <= POLICY.hill:
        # Hill's curve is drawn where it fits, and kept back where it would mislead.
        curve = velocity.isometric * ((1.0 + a) * b / (speed + b) - a)
        name = f"Hill, a = {report_kit.number(a)} of F₀"
        lines.append(PanelLine(speed, curve, report_kit.INK, name, 1.0, dashes=(0, (4, 3))))
    at_rest = np.array([velocity.isometric])
    lines.append(PanelLine(np.zeros(1), at_rest, report_kit.TEST, "at rest", width=0.0, marker="o"))
    return chart("speed of shortening [m/s]", FORCE, lines, include=(0.0,))


def _tables(bench: Bench, fit: MuscleFit | None) -> tuple[PageTable, ...]:
    tables = [_force_table(bench), _figures_table(bench), _loop_table(bench)]
    if bench.releases:
        tables.append(_release_table(bench))
    tables.append(_parameter_table(bench, fit))
    return tuple(tables)


def _release_table(bench: Bench) -> PageTable:
    number = report_kit.number
    rows = []
    for release in bench.releases:
        row = (
            f"{number(release.load)} N",
            number(release.mass),
            number(release.peak_speed),
            number(100 * release.peak_contraction),
        )
        rows.append(row)
    head = ("load after the release", "mass [kg]", "peak speed [m/s]", "at contraction [%]")
    return PageTable("Quick release", head, tuple(rows))


def _force_table(bench: Bench) -> PageTable:
    head = ("contraction", *(f"{p / BAR:.3g} bar" for p in bench.forces.pressure))
    rows = []
    for contraction, forces in zip(bench.forces.contraction, bench.forces.force, strict=True):
        row = [f"{100 * contraction:.3g} %"]
        for force in forces:
            if force > 0:
                row.append(report_kit.number(force))
            else:
                row.append("slack")
        rows.append(tuple(row))
    note = "slack: the formula is not above zero, and a muscle does not push"
    return PageTable("Force at rest [N]", head, tuple(rows), note)


def _figures_table(bench: Bench) -> PageTable:
    forces = bench.forces
    columns = (forces.pressure, forces.blocked, forces.free, forces.stiffness)
    rows = []
    for pressure, blocked, free, stiffness in zip(*columns, strict=True):
        # A stiff muscle pulls at every contraction that was tried: it has no free one.
        stroke = "–"
        if math.isfinite(free):
            stroke = report_kit.number(100 * free)
        stiff = report_kit.number(stiffness / 1e3)
        rows.append((_bar(pressure), report_kit.number(blocked), stroke, stiff))
    head = ("pressure", "blocked force [N]", "free contraction [%]", "stiffness half way [N/mm]")
    return PageTable("Stroke and stiffness", head, tuple(rows))


def _loop_table(bench: Bench) -> PageTable:
    rows = []
    for loops, kind in ((bench.isobaric, ISOBARIC), (bench.isotonic, ISOTONIC)):
        for loop in loops:
            width = f"{report_kit.number(loop.width)} N"
            if kind.isotonic:
                width = f"{report_kit.number(100 * loop.width)} %"
            asymmetry = "–"
            if loop.width:
                # "or 0.0" turns a rounded −0.0 into 0.
                asymmetry = report_kit.number(round(loop.asymmetry_percent, 1) or 0.0)
            percent = report_kit.number(loop.width_percent)
            rows.append((f"{kind.key}, {kind.name_of(loop)}", width, percent, asymmetry))
    note = "asymmetry: how much more of the loop's area lies over the upper half of what is driven"
    head = ("loop", "width", "width [% of range]", "asymmetry [%]")
    return PageTable("Loops", head, tuple(rows), note)


def _parameter_table(bench: Bench, fit: MuscleFit | None) -> PageTable:
    rows = []
    for entry in bench.model.PARAMETERS:
        value = getattr(bench.model, entry.name)
        # A tuple of numbers has a row for each.
        numbers = {entry.name: value}
        if isinstance(value, tuple):
            numbers = {f"{entry.name}[{i}]": number for i, number in enumerate(value)}
        unit = entry.unit
        if unit == "1":
            unit = ""
        for name, number in numbers.items():
            row = [name, report_kit.number(number, 5)]
            if fit is not None:
                row.append(_standard_error(fit, name))
            rows.append((*row, unit, entry.meaning, entry.source))
    if fit is None:
        head: tuple[str, ...] = ("parameter", "value", "unit", "meaning", "source")
        return PageTable("Parameters", head, tuple(rows))
    head = ("parameter", "value", "standard error", "unit", "meaning", "source of the default")
    note = "–: kept as given, at a bound, or not told by the log"
    return PageTable("Parameters", head, tuple(rows), note)


def _standard_error(fit: MuscleFit, name: str) -> str:
    error = fit.standard_errors.get(name)
    if error is None:
        return "–"
    return f"± {report_kit.number(error, 2)}"
