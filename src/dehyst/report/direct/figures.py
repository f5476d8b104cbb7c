"""Figures of a direct inverse: the loop in its own direction, what is left over, the weights, what was compared."""

from __future__ import annotations

from functools import partial

import numpy as np

from dehyst.arrays import Array
from dehyst.identification.direct import DirectFit
from dehyst.identification.fit import Candidate
from dehyst.models import DirectInverse
from dehyst.recording import Recording
from dehyst.report.figures.candidates import candidates_figure, draw_bars
from dehyst.report.figures.loop import draw_parts, loop_figure
from dehyst.report.figures.panel import (
    Axes,
    Figure,
    Panel,
    add_legend,
    draw_path,
    label_axes,
    legend_label,
    path_of,
    says,
)
from dehyst.report.figures.residual import residual_figure
from dehyst.report.text import count, number, with_unit
from dehyst.report.theme import CYCLE, MODEL, MUTED, STATIC, TRAIN
from dehyst.report.thin import Window
from dehyst.ties import rank


def direct_figures(fit: DirectFit) -> tuple[Figure, ...]:
    """Return the figures of the report, in order."""
    figures = (
        loop_figure(fit), residual_figure(fit), _forward(fit), _weights(fit), _against(fit), candidates_figure(fit),
    )  # fmt: skip
    return tuple(figure for figure in figures if figure is not None)


def _forward(fit: DirectFit) -> Figure:
    first, score = fit.recordings[0], fit.judged_forward
    caption = (
        f"The same model read in the other direction: the output for which it asks for the applied input, solved "
        f"sample by sample. Off by {with_unit(score.rmse, first.output_unit)} rms ({number(score.rmse_percent)} % of "
        f"the output's range). It was not fitted for this: where the output hardly moves while the input does, a small "
        f"error of the input is a large one of the output."
    )
    return Figure(
        "forward",
        "Read forward",
        caption,
        (Panel("Output over input", partial(_draw_forward, fit), says("Loop of output over input with the model.")),),
    )


def _draw_forward(fit: DirectFit, axes: Axes) -> None:
    rec = fit.recordings[0]
    window = Window.around((rec.input, rec.output), (rec.input, fit.outputs[0]))
    label_axes(axes, window, rec.input_label, rec.output_label)
    draw_parts(fit, 0, (rec.input, rec.output), window, axes)
    said = path_of(rec, fit.outputs[0])
    draw_path(axes, path_of(rec, rec.input), said, window, MODEL, label="model", width=0.9, outline=True, order=3)
    add_legend(axes)


def _weights(fit: DirectFit) -> Figure | None:
    model = fit.model
    rec = fit.recordings[0]
    out = f" [{rec.output_unit}]" if rec.output_unit else ""
    tables = (
        ("Stops", model.radii, model.stop_weights, f"radius r{out}"),
        ("Path lags", model.path_lengths, model.path_weights, f"length x{out}"),
        ("Creep", model.time_constants, model.creep_weights, "time constant τ [s]"),
    )
    panels = [
        Panel(
            title,
            partial(_draw_weights, model, scale, weights, label, _unit(rec)),
            says(f"{title}: {count(scale.size, 'term')} with weight."),
        )
        for title, scale, weights, label in tables
        if scale.size
    ]
    panels.append(Panel("Curve", partial(_draw_curve, fit), says("Polynomial part of the input over output.")))
    caption = "Terms with weight, over their scale. All weights are 0 or more: every term opposes motion."
    if model.schedules:
        names = ", ".join(f"{s.name} {number(s.low)} to {with_unit(s.high, s.unit)}" for s in model.schedules)
        caption += f" Weights are blended between two sets over {names}; each set has its colour."
    if np.any(model.viscous > 0.0):
        values = ", ".join(number(value) for value in model.viscous)
        caption += f" Viscous: {values} {_unit(rec)} s.".replace("  ", " ")
    return Figure("weights", "What the model is made of", caption, tuple(panels))


def _unit(rec: Recording) -> str:
    return f"{rec.input_unit}/{rec.output_unit}" if rec.input_unit and rec.output_unit else ""


def _draw_weights(model: DirectInverse, scale: Array, weights: Array, label: str, unit: str, axes: Axes) -> None:
    window = Window.around((scale, weights.max(axis=0)), (scale, np.zeros(scale.size)), margin=0.08)
    label_axes(axes, window, label, f"weight [{unit}]" if unit else "weight")
    axes.axhline(0.0, color=MUTED.light, lw=0.8, zorder=1)
    if scale.size > 1 and scale[0] > 0.0:
        axes.set_xscale("log")
        axes.set_xlim(0.8 * scale[0], 1.25 * scale[-1])
        ticks = _ticks(0.8 * float(scale[0]), 1.25 * float(scale[-1]))
        axes.set_xticks(ticks, labels=[f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
    for k, row in enumerate(weights):
        token, there = (TRAIN if weights.shape[0] == 1 else CYCLE[k % len(CYCLE)]), row > 0.0
        name = "weight" if weights.shape[0] == 1 else _set_name(model, k)
        axes.vlines(scale[there], 0.0, row[there], color=token.light, lw=1.6, zorder=2)
        axes.plot(scale[there], row[there], "o", color=token.light, ms=4.5, mew=0.0, label=name, zorder=3)
    add_legend(axes)


def _ticks(low: float, high: float) -> list[float]:
    """Places of a logarithmic axis: 1, 2, 5 of every decade, or 1 where that would be too many."""
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    fine = [place * 10.0**decade for decade in decades for place in (1.0, 2.0, 5.0)]
    ticks = [tick for tick in fine if low <= tick <= high]
    return (
        ticks if len(ticks) <= 5 else [tick for tick in ticks[:] if np.isclose(np.log10(tick) % 1.0, 0.0)] or ticks[::3]
    )


def _set_name(model: DirectInverse, k: int) -> str:
    schedule = model.schedules[k // 2]
    return f"{schedule.name} at {number(schedule.high if k % 2 else schedule.low)}"


def _draw_curve(fit: DirectFit, axes: Axes) -> None:
    model, rec = fit.model, fit.recordings[0]
    card = model.card.output
    low, high = (card.low, card.high) if card.low is not None and card.high is not None else (-1.0, 1.0)
    y = np.linspace(low, high, 201)
    rows = model.polynomial if len(model.schedules) == 1 and model.schedules[0].outside else model.polynomial[:1]
    curves = [np.polynomial.polynomial.polyval(y - model.center, row) for row in rows]
    window = Window.around(*((y, curve) for curve in curves))
    label_axes(axes, window, rec.output_label, f"P [{rec.input_unit}]" if rec.input_unit else "P")
    for k, curve in enumerate(curves):
        name = _set_name(model, k) if len(curves) > 1 else "curve"
        axes.plot(y, curve, color=(CYCLE[k] if len(curves) > 1 else STATIC).light, lw=1.8, label=legend_label(name))
    if len(curves) > 1:
        add_legend(axes)


def _against(fit: DirectFit) -> Figure | None:
    if not fit.rivals:
        return None
    part = "held-out" if fit.test is not None else "fitted"
    return Figure(
        "against",
        "Against forward families",
        f"Errors on the {part} samples. Input: what the inverse of each family asks for at the measured output, less "
        f"what was applied. Output: its model at the applied input. A compensator is used in the first way.",
        (
            Panel("Error of the input", partial(_draw_against, fit, True), says("Bars of errors of the input.")),
            Panel("Error of the output", partial(_draw_against, fit, False), says("Bars of errors of the output.")),
        ),
    )


def _draw_against(fit: DirectFit, inverse: bool, axes: Axes) -> None:
    own = fit.judged.rmse_percent if inverse else fit.judged_forward.rmse_percent
    others = [(r.family, r.inverse_percent if inverse else r.forward_percent) for r in fit.rivals]
    rows = [
        Candidate(name, "", None, error, np.nan, name == fit.family) for name, error in [(fit.family, own), *others]
    ]
    label = f"RMSE [% of the {'input' if inverse else 'output'}'s range]"
    draw_bars(sorted(rows, key=lambda row: rank(row.error_percent)), label, axes)
