"""Figures of the residual: its size over time and input, what it depends on, how much of it is noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dehyst.arrays import Array
from dehyst.identification.fit import Fit
from dehyst.identification.residual import TITLES, Residual
from dehyst.report.drawing import DASHED, Bar, bar_heights, bars, break_times, chart, time_of
from dehyst.report.figures.loops import parts
from dehyst.report.parts import Axes, Draw, Figure, Panel, Table
from dehyst.report.text import bracketed, number, with_unit
from dehyst.report.theme import FIFTH, GRID, MUTED, OTHER, TRAIN

NOISE = {
    "repeats": "noise, from strokes that were repeated",
    "differences": "noise, from sample to sample: the least it can be",
}
TOGETHER = "all causes together"


def residual_figure(fit: Fit) -> Figure:
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
    left = [rec.output - said for rec, said in zip(fit.recordings, fit.predictions, strict=True)]
    times, borders, label = _one_after_another(fit)
    marks = [moment for rec, t in zip(fit.recordings, times, strict=True) for moment in break_times(rec, t)]
    inputs = [rec.input for rec in fit.recordings]
    return Figure(
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
    rec = fit.recordings[0]
    lines = [line for i, x in enumerate(across) for line in parts(fit, i, x, left[i], 0.9)]

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
    times, borders, start = [], [], 0.0
    for rec in fit.recordings:
        t = time_of(rec)[0] if timed else np.arange(len(rec), dtype=np.float64)
        times.append(t - t[0] + start)
        start = float(times[-1][-1] + np.median(np.diff(t)))
        borders.append(start)
    return times, borders[:-1], "time, log after log [s]" if timed else "sample number, log after log"


def structure_figure(fit: Fit) -> Figure | None:
    """Return what the residual depends on; None where it is rounding alone, or too short to tell."""
    found = fit.residual
    if not found.causes:
        return None
    caption = (
        f"How much of the model's squared error in the {found.part} part ({number(found.rms_percent)} % of range rms) "
        "each cause explains by itself. It is fitted to every other block and scored on the blocks between, so noise "
        "explains nothing. Dark: what no other cause explains as well. Causes overlap: shares need not add up to 100 %."
    )
    rows = _rows(found)
    shown = [
        Bar(name, 100.0 * share, FIFTH if name in NOISE.values() else TRAIN, _percent(share), own=100.0 * own)
        for name, share, own, _ in rows
    ]
    together = 100.0 * found.explained
    shown.append(Bar(TOGETHER, together, OTHER, _percent(found.explained), own=together))
    best = ", ".join(f"{name} {_percent(share)}" for name, share, _, _ in rows)
    draw = bars(shown, "share of the squared error [%]", edge=100.0)
    return Figure(
        "structure",
        "What the residual depends on",
        caption,
        (Panel("Share of the squared error", draw, f"Bars: {best}.", bar_heights(len(shown))),),
        table=_table(found, rows),
        points=found.suggestions,
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _rows(found: Residual) -> list[tuple[str, float, float, float]]:
    """Name, share, own share and size of every bar."""
    rows = [(TITLES[cause.name], cause.share, cause.own, cause.size_percent) for cause in found.causes]
    if found.noise_share is not None and found.noise_percent is not None:
        rows.append((NOISE[found.noise_from], found.noise_share, found.noise_share, found.noise_percent))
    return rows


def _table(found: Residual, rows: Sequence[tuple[str, float, float, float]]) -> Table:
    cells = [(name, _percent(share), _percent(own), f"{number(size)} %") for name, share, own, size in rows]
    together = found.rms_percent * float(np.sqrt(found.explained))
    cells.append((TOGETHER, _percent(found.explained), "", f"{number(together)} %"))
    return Table("What the residual depends on", ("", "share", "own share", "rms, % of range"), tuple(cells))
