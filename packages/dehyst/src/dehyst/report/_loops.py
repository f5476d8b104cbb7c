"""The picture and the page of `dehyst loops`: each number of the largest loop, drawn where it is measured."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path

import numpy as np

from dehyst.data import Loops, MeasuredLoop
from dehyst.report._drawing import DASHED, PanelLine, chart, double_arrow
from dehyst.report._page import write_page
from dehyst.report._parts import Axes, Draw, Page, PageFigure, PageSection, PageTable, Panel
from dehyst.report._svg import write_picture
from dehyst.report._text import bracketed, count, number, short, with_unit
from dehyst.report._theme import DATA, MODEL, MUTED, TEST, TRAIN, ThemeColour

LOOPS = "dehyst loops: "  # by which a picture is known that may be drawn anew
# Labels of places that lie closer together than this share of the axis would cover each other.
APART = 0.04
TURNS = {"high": "upper", "low": "lower"}
ROOM = 0.16  # above and below the loop, share of the output's range
WIDE = 0.25  # a distance of this share of the range has its label inside the loop
TANGENT = 0.12  # length of the line that shows a slope, share of the input's range


def write_loops(measured: Loops, path: str | os.PathLike[str]) -> Path:
    """Write the picture of the numbers of a loop, ``.svg`` or ``.png``, or a page with them, ``.html``.

    Parameters
    ----------
    measured
        Result of `dehyst.data.measure_loops`.
    path
        File to write.

    Raises
    ------
    OutputError
        If the file cannot be written or has another ending.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from dehyst.data import measure_loops
    >>> from dehyst.io import example_recording
    >>> path = write_loops(measure_loops(example_recording()), pathlib.Path(tempfile.mkdtemp()) / "loops.svg")
    >>> path.read_text(encoding="utf-8").count("coercivity") > 0
    True
    """
    figure = loops_figure(measured)
    if Path(path).suffix.lower() == ".html":
        return write_page(_page(measured, figure), path)
    return write_picture(figure, path, f"{LOOPS}{short(measured.name, 60)}", headed=True)


def loops_figure(measured: Loops) -> PageFigure:
    """Return the largest loop with its numbers, all loops, and how width and area change from cycle to cycle."""
    loop = measured.largest[0]
    x, y = loop.path
    enclosed = f"{measured.area_word} {with_unit(loop.area, measured.units['work'])}"
    if not loop.closes:
        enclosed += f", does not close: gap {loop.gap_percent:+.1f} % of range"
    closed = PanelLine(np.append(x, x[0]), np.append(y, y[0]), TRAIN, enclosed, 1.6)
    # Labels of the turns stand above and below the loop.
    room = ROOM * (loop.output_high - loop.output_low)
    panels = [
        Panel(
            f"Loop {loop.number}: where each number is measured",
            chart(
                measured.input_label,
                measured.output_label,
                [closed],
                include=(loop.output_low - room, loop.output_high + room),
                also=partial(_annotate, measured, loop),
            ),
            f"{measured.output_label} over {measured.input_label}, {measured.opening_words}; {measured.words}.",
            heights=(4.0,),
        ),
        Panel("All loops", _all_loops(measured), "Every loop of the log.", heights=(4.0,)),
    ]
    if measured.trends:
        panels.append(_trend_panel(measured))
    return PageFigure(
        "loops", "Numbers of the loop", measured.opening_words, tuple(panels), width=6.4
    )


def _all_loops(measured: Loops) -> Draw:
    lines: list[PanelLine] = []
    largest = set(measured.largest)
    for loop in measured.loops:
        colour, label = DATA, "other loops"
        if loop in largest:
            colour, label = TRAIN, "largest loops"
        if label in {line.label for line in lines}:
            label = ""
        lines.append(PanelLine(loop.path[0], loop.path[1], colour, label, 1.0))
    return chart(measured.input_label, measured.output_label, lines)


def _trend_panel(measured: Loops) -> Panel:
    """Width and area of the largest loops, in percent of their means."""
    places = np.array([float(loop.number) for loop in measured.largest])
    lines = []
    for name, colour in (("width", TRAIN), ("area", TEST)):
        # What is zero in all of them has no percentage.
        if name not in measured.trends:
            continue
        values = np.array([getattr(loop, name) for loop in measured.largest])
        label = name
        if name == "area":
            label = measured.area_word
        change = measured.trends[name]
        label += f": {change.value:+.2g} % from one to the next"
        lines.append(
            PanelLine(places, 100.0 * values / np.mean(values), colour, label, 0.8, marker="o")
        )
    return Panel(
        "From cycle to cycle",
        chart("number of the loop", "% of the mean", lines),
        "Width and area over the number of the loop.",
    )


def _annotate(measured: Loops, loop: MeasuredLoop, axes: Axes) -> None:
    """Draw the numbers of a loop into its axes."""
    x, y = loop.path
    axes.fill(x, y, color=TRAIN.light, alpha=0.12, lw=0, zorder=1)
    x_middle = 0.5 * (loop.input_low + loop.input_high)
    y_middle = 0.5 * (loop.output_low + loop.output_high)
    x_place, y_place = x_middle, y_middle
    if measured.input_reference == "zero":
        x_place = 0.0
    if measured.output_reference == "zero":
        y_place = 0.0
    if loop.orientation == "butterfly":
        valley = loop.saturation_low + loop.saturation_high > 2.0 * y_middle
        y_place = loop.output_low if valley else loop.output_high
    units = measured.units
    width = f"width {with_unit(loop.width, units['output'])}"
    # The same distance twice would be drawn over itself.
    if abs(x_place - x_middle) < APART * loop.depth:
        width += f"\nremanence {with_unit(loop.remanence, units['output'])} (half)"
    else:
        label = f"remanence {with_unit(loop.remanence, units['output'])} (half)"
        _upright(axes, x_place, loop.outputs_at(x_place), label, MODEL)
    _upright(axes, x_middle, loop.outputs_at(x_middle), width, TEST)
    label = f"coercivity {with_unit(loop.coercivity, units['input'])} (half)"
    _level(axes, loop.inputs_at(y_place), y_place, label, MODEL)
    _turn(axes, loop, "high", units["output"])
    _turn(axes, loop, "low", units["output"])


def _falls(loop: MeasuredLoop) -> bool:
    return loop.saturation_high < loop.saturation_low


def _upright(
    axes: Axes, x: float, ends: tuple[float, float], label: str, colour: ThemeColour
) -> None:
    """A distance of two outputs at one input, with its name beside it, or above it in a narrow loop."""
    if not np.isfinite(ends).all():
        return
    double_arrow(axes, (x, ends[0]), (x, ends[1]), colour)
    low, high = min(ends), max(ends)
    if high - low > WIDE * float(np.ptp(axes.get_ylim())):
        _label(axes, (x, low + 0.8 * (high - low)), (6, 0), label, colour, "left", "center")
    else:
        _label(axes, (x, high), (-10, 12), label, colour, "right", "bottom")


def _level(
    axes: Axes, ends: tuple[float, float], y: float, label: str, colour: ThemeColour
) -> None:
    """A distance of two inputs at one output, with its name over its end, or right of it in a narrow loop."""
    if not np.isfinite(ends).all():
        return
    double_arrow(axes, (ends[0], y), (ends[1], y), colour)
    if abs(ends[1] - ends[0]) > WIDE * float(np.ptp(axes.get_xlim())):
        _label(axes, (max(ends), y), (-8, 3), label, colour, "right", "bottom")
    else:
        _label(axes, (max(ends), y), (12, -10), label, colour, "left", "top")


def _label(
    axes: Axes,
    place: tuple[float, float],
    shift: tuple[int, int],
    label: str,
    colour: ThemeColour,
    across: str,
    up: str,
) -> None:
    axes.annotate(
        label,
        place,
        shift,
        textcoords="offset points",
        ha=across,
        va=up,
        fontsize=9,
        color=colour.light,
        zorder=6,
    )


def _turn(axes: Axes, loop: MeasuredLoop, side: str, unit: str) -> None:
    """The output at a turn, and the slopes before and behind it."""
    saturation = getattr(loop, f"saturation_{side}")
    if not np.isfinite(saturation):
        return
    turn, inward = loop.input_low, 1.0
    if side == "high":
        turn, inward = loop.input_high, -1.0
    axes.plot([turn], [saturation], "o", color=MODEL.light, ms=4.5, mew=0.0, zorder=5)
    slopes = []
    for way in ("to", "from"):
        slope = getattr(loop, f"slope_{way}_{side}")
        slopes.append(number(slope, 2))
        ends = np.array([turn + inward * TANGENT * loop.depth, turn])
        axes.plot(ends, saturation + slope * (ends - turn), color=MUTED.light, lw=1.2, ls=DASHED)
    # The upper end of the loop has its label at the top of the axes, the lower one at their foot.
    upper = saturation >= 0.5 * (loop.output_low + loop.output_high)
    place, up = 0.03, "bottom"
    if upper:
        place, up = 0.97, "top"
    across, align = 0.97, "right"
    # Beside the end, where the loop is not; where both ends are high, or low, each on its own side.
    other = loop.saturation_low + loop.saturation_high - saturation
    if upper == (other >= 0.5 * (loop.output_low + loop.output_high)):
        if side == "low":
            across, align = 0.03, "left"
    elif upper != _falls(loop):
        across, align = 0.03, "left"
    axes.annotate(
        f"{with_unit(saturation, unit)} at the {TURNS[side]} turn\n"
        f"slope {slopes[0]} before, {slopes[1]} behind",
        (turn, saturation),
        (across, place),
        textcoords="axes fraction",
        ha=align,
        va=up,
        fontsize=9,
        color=MUTED.light,
        arrowprops={"arrowstyle": "-", "color": MUTED.light, "lw": 0.6, "shrinkB": 4},
    )


def _page(measured: Loops, figure: PageFigure) -> Page:
    units = measured.units
    rows = []
    for label, words, where in measured.rows:
        rows.append((label, words.replace("+-", "±"), where))
    largest = PageTable(
        f"Numbers of {count(len(measured.largest), 'largest loop')}",
        ("number", "value", "where it is measured"),
        tuple(rows),
        f"Intervals of 95 %: {measured.basis}.",
        words=True,
    )
    each = []
    for loop in measured.loops:
        each.append(
            (
                str(loop.number),
                number(loop.start),
                number(loop.width),
                number(loop.opening_percent, 2),
                number(loop.area),
                number(loop.coercivity),
                number(loop.gap_percent, 2),
                loop.orientation,
            )
        )
    heads = (
        "loop",
        "begin",
        f"width{bracketed(units['output'])}",
        "opening [%]",
        f"{measured.area_word}{bracketed(units['work'])}",
        f"coercivity{bracketed(units['input'])}",
        "gap [%]",
        "direction",
    )
    return Page(
        kind="Numbers of the loops",
        title=short(measured.name, 80),
        relation=f"{short(measured.input_name, 60)} → {short(measured.output_name, 60)}",
        subject="loops",
        lead=f"{measured.opening_words}; {measured.words}".replace("+-", "±"),
        sections=(
            figure,
            PageSection(
                "tables",
                "Tables",
                (largest, PageTable("Every loop", heads, tuple(each), folded=True)),
            ),
        ),
    )
