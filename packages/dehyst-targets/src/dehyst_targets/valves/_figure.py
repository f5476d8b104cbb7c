"""The picture of a verdict: what answered over the controller output, and which dead bands explain the record."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import numpy as np

from dehyst.report import Axes, Draw, PageFigure, Panel, PanelLine, chart
from dehyst.report import kit as report_kit
from dehyst_targets.valves._policy import POLICY
from dehyst_targets.valves._verdict import NO_SIGN, ValveVerdict

TITLE = "dehyst valve: "  # by which a picture is known that may be drawn anew
SHOWN = 4000  # samples


def write_valve_figure(path: str | PathLike[str], verdict: ValveVerdict) -> Path:
    """Write the picture of a verdict, ``.svg`` or ``.png``.

    Parameters
    ----------
    path
        File to write.
    verdict
        Of `judge_valve`.

    Raises
    ------
    OutputError
        If the ending is another one, or the file cannot be written.
    """
    panels = [
        Panel("What answers", _answer(verdict), "What was measured over the controller output."),
        Panel(
            "Valve of the fit",
            _valve(verdict),
            "Position of the fitted valve, its dead band and jump.",
        ),
        Panel(
            "Which dead bands",
            _profile(verdict),
            "Criterion over the dead band; the valve that follows is at zero.",
        ),
    ]
    figure = PageFigure("valve", verdict.words, verdict.loop.name, tuple(panels))
    return report_kit.write_picture(figure, path, f"{TITLE}{verdict.loop.name}", headed=True)


def _answer(verdict: ValveVerdict) -> Draw:
    loop = verdict.loop
    values, name = loop.measurement, "measurement"
    if loop.position is not None:
        values, name = loop.position, "position"
    assert values is not None
    part = slice(max(0, values.size - SHOWN), None)
    line = PanelLine(loop.output[part], values[part], report_kit.DATA, width=0.7)
    return chart("controller output [%]", name, [line])


def _valve(verdict: ValveVerdict) -> Draw:
    fit = verdict.fit
    part = slice(max(0, fit.signal.size - SHOWN), None)
    signal, path = fit.signal[part], fit.path[part]
    middle = 0.5 * float(path.min() + path.max())
    across = 0.5 * float(signal.min() + signal.max())
    half, jump = 0.5 * fit.dead_band.value, 0.5 * fit.jump.value

    def sizes(axes: Axes) -> None:
        arrow = {"arrowstyle": "<->", "color": report_kit.TEST.light}
        axes.annotate("", (across + half, middle), (across - half, middle), arrowprops=arrow)
        axes.text(across, middle, "S", color=report_kit.TEST.light, va="bottom")
        right = across + half
        axes.annotate("", (right, middle + jump), (right, middle - jump), arrowprops=arrow)
        axes.text(right, middle + 0.5 * jump, " J", color=report_kit.TEST.light)

    return chart(
        "controller output [%]",
        "valve [%]",
        [PanelLine(signal, path, report_kit.MODEL, width=0.9)],
        also=sizes if verdict.kind != NO_SIGN else None,
    )


def _profile(verdict: ValveVerdict) -> Draw:
    dead_bands, scores = verdict.fit.profile
    lines = [
        PanelLine(dead_bands, scores, report_kit.MODEL),
        PanelLine(
            dead_bands[[0, -1]],
            np.full(2, POLICY.excluded),
            report_kit.MUTED,
            "excluded above",
            dashes="dashed",
        ),
    ]
    return chart("dead band [% of controller output]", "criterion", lines, zero=True)
