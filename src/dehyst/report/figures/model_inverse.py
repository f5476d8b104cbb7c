"""Figure 4: model and inverse model against the data (the paper's Figure 5)."""

from __future__ import annotations

from functools import partial

import numpy as np

from dehyst.arrays import Array
from dehyst.identification.fit import Fit
from dehyst.report.figures.panel import (
    NO_LABEL,
    Axes,
    Figure,
    Panel,
    add_legend,
    draw_path,
    label_axes,
    path_of,
    says,
)
from dehyst.report.judgement import inverse_miss
from dehyst.report.text import with_unit
from dehyst.report.theme import DATA, MODEL, STATIC
from dehyst.report.thin import Window


def model_figure(fit: Fit) -> Figure:
    """Return figure 4."""
    rec = fit.recordings[0]
    caption = (
        "Model: what it predicts for the measured input, with the best curve without hysteresis (dashed), which "
        "every hysteresis model has to beat."
    )
    model = Panel(
        "Model: output over input",
        partial(_draw_model, fit),
        says(f"{rec.output_label} over {rec.input_label}: measured, model, and the curve without hysteresis."),
    )
    if fit.model.no_inverse:
        return Figure("model", "Model against the data", f"{caption} It has no inverse.", (model,))
    rms, worst = (with_unit(value, rec.input_unit) for value in inverse_miss(fit))
    caption += (
        " Inverse model: the compensator's view, the input that it asks for to reach the measured output. It misses "
        f"the input that was really applied by {rms} (RMS; largest {worst})."
    )
    inverse = Panel(
        "Inverse model: input over output",
        partial(_draw_inverse, fit),
        says(f"{rec.input_label} over {rec.output_label}: applied, and asked for by the inverse model."),
    )
    return Figure("model", "Model and inverse against the data", caption, (model, inverse))


def _draw_model(fit: Fit, axes: Axes) -> None:
    pairs = [(rec.input, rec.output) for rec in fit.recordings]
    fits = list(zip((rec.input for rec in fit.recordings), fit.predictions, strict=True))
    window = Window.around(*pairs, *fits)
    label_axes(axes, window, fit.recordings[0].input_label, fit.recordings[0].output_label)
    _draw_pairs(fit, pairs, "measured", window, axes)
    low = min(float(rec.input.min()) for rec in fit.recordings)
    high = max(float(rec.input.max()) for rec in fit.recordings)
    across = np.linspace(low, high, 400)
    axes.plot(
        across,
        fit.static.simulate(across),
        color=STATIC.light,
        lw=1.5,
        ls=(0, (4, 2)),
        label="without hysteresis",
        zorder=2.5,
    )
    _draw_pairs(fit, fits, "model", window, axes)
    add_legend(axes)


def _draw_inverse(fit: Fit, axes: Axes) -> None:
    pairs = [(rec.output, rec.input) for rec in fit.recordings]
    asked = list(zip((rec.output for rec in fit.recordings), fit.inverse_predictions, strict=True))
    window = Window.around(*pairs, *asked)
    label_axes(axes, window, fit.recordings[0].output_label, fit.recordings[0].input_label)
    _draw_pairs(fit, pairs, "applied", window, axes)
    _draw_pairs(fit, asked, "asked for by the inverse", window, axes)
    add_legend(axes)


def _draw_pairs(fit: Fit, pairs: list[tuple[Array, Array]], label: str, window: Window, axes: Axes) -> None:
    """Draw all recordings in one colour: wide and light for the data, thin and dark for the model."""
    data = label in ("measured", "applied")
    for i, (x, y) in enumerate(pairs):
        rec = fit.recordings[i]
        draw_path(
            axes,
            path_of(rec, x),
            path_of(rec, y),
            window,
            DATA if data else MODEL,
            label=label if i == 0 else NO_LABEL,
            width=2.6 if data else 0.8,
            outline=not data,
            order=2 if data else 3,
        )
