"""Figures of the residual: its size over time and input, what it depends on, how much of it is noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dehyst.arrays import Array
from dehyst.findings import Grade
from dehyst.identification import Fit, Residual
from dehyst.report._drawing import DASHED, Bar, bar_heights, bars, break_times, chart, time_of
from dehyst.report._figures.loops import part_lines
from dehyst.report._judgement import overall
from dehyst.report._parts import Axes, Draw, PageFigure, PageTable, Panel
from dehyst.report._text import bracketed, number, with_unit
from dehyst.report._theme import FIFTH, GRID, MUTED, OTHER, TRAIN

NOISE = {
    "repeats": "noise, from strokes that were repeated",
    "differences": "noise, from sample to sample: the least it can be",
}
TOGETHER = "all causes together"


def residual_figure(fit: Fit) -> PageFigure:
    """Return measured output less model, over time and over the input."""
    rec = fit.recordings[0]
    score, part = (fit.train, "fitted") if fit.test is None else (fit.test, "held-out")
    caption = (
        f"Measured output less model. The band is ± the RMSE of the {part} part, "
        f"{with_unit(score.rmse, rec.output_unit)} ({score.rmse_percent:.2g} % of the output's range). A trend over "
        "time means drift or creep; a loop over the input means rate dependence or a shape that the family cannot take."
    )
    breaks = sum(len(rec.breaks) for rec in fit.recordings)
    if breaks == 1:
        caption += " Dotted line: the place where samples are missing."
    elif breaks:
        caption += f" Dotted lines: the {breaks} places where samples are missing."
    if len(fit.recordings) > 1:
        caption += " Logs are drawn one after another, with a dashed line between them."
    times, borders, label = _one_after_another(fit)
    left, inputs, marks = [], [], []
    for record, output, t in zip(fit.recordings, fit.predictions, times, strict=True):
        left.append(record.output - output)
        inputs.append(record.input)
        marks += break_times(record, t)
    return PageFigure(
        "residual",
        "Residual",
        caption,
        (
            Panel(
                "Over time",
                _left(fit, times, left, label, score.rmse, marks, borders),
                "Residual over time with a band of plus and minus the RMSE.",
            ),
            Panel(
                "Over input",
                _left(fit, inputs, left, rec.input_label, score.rmse, (), ()),
                f"Residual over {rec.input_label} with the same band.",
            ),
        ),
    )


def _left(
    fit: Fit,
    across: Sequence[Array],
    left: Sequence[Array],
    label: str,
    rmse: float,
    marks: Sequence[float],
    borders: Sequence[float],
) -> Draw:
    """Draw what is left of each recording, with a band of the RMSE."""
    rec = fit.recordings[0]
    lines = []
    for i, (x, residual) in enumerate(zip(across, left, strict=True)):
        lines += part_lines(fit, i, x, residual, 0.9)

    def band(axes: Axes) -> None:
        axes.axhspan(-rmse, rmse, color=GRID.light, lw=0, zorder=0.5)
        for border in borders:
            axes.axvline(border, color=MUTED.light, lw=0.8, ls=DASHED, zorder=1)

    up = f"residual{bracketed(rec.output_unit) or f' of {rec.output_name}'}"
    return chart(label, up, lines, zero=True, include=(-rmse, rmse), marks=marks, also=band)


def _one_after_another(fit: Fit) -> tuple[list[Array], list[float], str]:
    """Abscissa of each recording, shifted behind the one before; where one ends; the axis label."""
    if len(fit.recordings) == 1:
        t, label = time_of(fit.recordings[0])
        return [t], [], label
    timed = all(rec.time is not None for rec in fit.recordings)
    label = "time, log after log [s]" if timed else "sample number, log after log"
    times, borders, start = [], [], 0.0
    for rec in fit.recordings:
        t = np.arange(len(rec), dtype=np.float64)
        if timed:
            t, _ = time_of(rec)
        times.append(t - t[0] + start)
        start = float(times[-1][-1] + np.median(np.diff(t)))
        borders.append(start)
    return times, borders[:-1], label


SMALL_ENOUGH = (
    "The error is small enough: the verdict on the model is good. What follows says where the rest of the error comes "
    "from, for those who want it smaller still."
)


def structure_figure(fit: Fit) -> PageFigure | None:
    """Return what the residual depends on; None where it is rounding alone, or too short to tell."""
    residual = fit.residual
    if not residual.causes:
        return None
    caption = (
        f"How much of the model's squared error in the {residual.part} part ({number(residual.rms_percent)} % of range "
        "rms) each cause explains by itself. It is fitted to every other block and scored on the blocks between, so "
        "noise explains nothing. Dark: what no other cause explains as well. Causes overlap: shares need not add up "
        "to 100 %."
    )
    rows = _rows(residual)
    shown, words = [], []
    for name, share, own_share, _ in rows:
        colour = FIFTH if name in NOISE.values() else TRAIN
        shown.append(Bar(name, 100.0 * share, colour, _percent(share), dark=100.0 * own_share))
        words.append(f"{name} {_percent(share)}")
    together = 100.0 * residual.explained
    shown.append(Bar(TOGETHER, together, OTHER, _percent(residual.explained), dark=together))
    points = residual.suggestions
    if points and overall(fit) is Grade.GOOD:
        points = (SMALL_ENOUGH, *points)
    draw = bars(shown, "share of the squared error [%]", edge=100.0)
    alt = f"Bars: {', '.join(words)}."
    return PageFigure(
        "structure",
        "What the residual depends on",
        caption,
        (Panel("Share of the squared error", draw, alt, bar_heights(len(shown))),),
        table=_table(residual, rows),
        points=points,
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _rows(residual: Residual) -> list[tuple[str, float, float, float]]:
    """Name, share, own share and size of every bar."""
    rows = [(cause.title, cause.share, cause.own, cause.size_percent) for cause in residual.causes]
    if residual.noise_share is not None and residual.noise_percent is not None:
        rows.append(
            (
                NOISE[residual.noise_from],
                residual.noise_share,
                residual.noise_share,
                residual.noise_percent,
            )
        )
    return rows


def _table(residual: Residual, rows: Sequence[tuple[str, float, float, float]]) -> PageTable:
    """Shares and sizes of the causes, and of all together."""
    cells = []
    for name, share, own_share, size in rows:
        cells.append((name, _percent(share), _percent(own_share), f"{number(size)} %"))
    together = residual.rms_percent * float(np.sqrt(residual.explained))
    cells.append((TOGETHER, _percent(residual.explained), "", f"{number(together)} %"))
    return PageTable(
        "What the residual depends on", ("", "share", "own share", "rms, % of range"), tuple(cells)
    )
