"""Figure 5: what the model leaves over, over time and over input."""

from __future__ import annotations

from functools import partial

import numpy as np

from dehyst.arrays import Array
from dehyst.identification.fit import Fit
from dehyst.report.figures.loop import parts
from dehyst.report.figures.panel import (
    NO_LABEL,
    Axes,
    Figure,
    Panel,
    add_legend,
    break_times,
    draw_path,
    draw_series,
    label_axes,
    path_of,
    says,
    time_of,
)
from dehyst.report.text import with_unit
from dehyst.report.theme import BAD, GRID, MUTED
from dehyst.report.thin import Window

MARKS = 100


def residual_figure(fit: Fit) -> Figure:
    """Return figure 5."""
    rec = fit.recordings[0]
    score, part = (fit.train, "fitted") if fit.test is None else (fit.test, "held-out")
    caption = (
        f"Measured output less model. The band is ± the RMSE "
        f"of the {part} part, {with_unit(score.rmse, rec.output_unit)} ({score.rmse_percent:.2g} % of the output's "
        f"range). A trend over time means drift or creep; a loop that is left over the input means rate "
        "dependence or a shape that the family cannot take."
    )
    breaks = sum(len(rec.breaks) for rec in fit.recordings)
    if breaks:
        caption += (
            f" Dotted lines: the {breaks} places where samples are missing."
            if breaks > 1
            else (" Dotted line: the place where samples are missing.")
        )
    if len(fit.recordings) > 1:
        caption += " Logs are drawn one after another, with a dashed line between them."
    return Figure(
        "residual",
        "Residual",
        caption,
        (
            Panel(
                "Over time",
                partial(_draw_time, fit, score.rmse),
                says("Residual over time with a band of plus and minus the RMSE."),
            ),
            Panel(
                "Over input",
                partial(_draw_drive, fit, score.rmse),
                says(f"Residual over {rec.input_label} with the same band."),
            ),
        ),
    )


def residuals(fit: Fit) -> list[Array]:
    """Return measured less model, (T,) per recording. [output]"""
    return [rec.output - said for rec, said in zip(fit.recordings, fit.predictions, strict=True)]


def _label(fit: Fit) -> str:
    rec = fit.recordings[0]
    return f"residual [{rec.output_unit}]" if rec.output_unit else f"residual of {rec.output_name}"


def _band(axes: Axes, rmse: float) -> None:
    axes.axhspan(-rmse, rmse, color=GRID.light, lw=0, zorder=0.5)
    axes.axhline(0.0, color=MUTED.light, lw=0.8, zorder=1)


def _draw_time(fit: Fit, rmse: float, axes: Axes) -> None:
    left = residuals(fit)
    times, borders, label = _one_after_another(fit)
    window = Window.around(
        *zip(times, left, strict=True),
        (np.array(times[0][:1]), np.array([-rmse])),
        (np.array(times[0][:1]), np.array([rmse])),
    )
    label_axes(axes, window, label, _label(fit))
    _band(axes, rmse)
    seen: set[str] = set()
    for i, rec in enumerate(fit.recordings):
        for mask, name, token in parts(fit, i):
            label_once = name if name not in seen else NO_LABEL
            seen.add(name)
            draw_series(axes, path_of(rec, times[i]), path_of(rec, left[i], mask), token, label=label_once, width=0.9)
        for moment in break_times(rec, times[i])[:MARKS]:
            axes.axvline(moment, color=BAD.light, lw=1.4, ls=(0, (1, 1.5)), zorder=2.5)
    for border in borders:
        axes.axvline(border, color=MUTED.light, lw=0.8, ls=(0, (5, 3)), zorder=1)
    add_legend(axes)


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


def _draw_drive(fit: Fit, rmse: float, axes: Axes) -> None:
    left, across = residuals(fit), [rec.input for rec in fit.recordings]
    window = Window.around(
        *zip(across, left, strict=True),
        (across[0][:1], np.array([-rmse])),
        (across[0][:1], np.array([rmse])),
    )
    label_axes(axes, window, fit.recordings[0].input_label, _label(fit))
    _band(axes, rmse)
    seen: set[str] = set()
    for i, rec in enumerate(fit.recordings):
        for mask, name, token in parts(fit, i):
            label = name if name not in seen else NO_LABEL
            seen.add(name)
            draw_path(axes, path_of(rec, across[i]), path_of(rec, left[i], mask), window, token, label=label, width=0.9)
    add_legend(axes)
