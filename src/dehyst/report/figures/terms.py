"""Figure: weights of the terms of a model that is no sum of plays, over their scale."""

from __future__ import annotations

from functools import partial

import numpy as np

from dehyst.identification.fit import Fit
from dehyst.models.model import WeightTable
from dehyst.report.figures.panel import Axes, Figure, Panel, add_legend, label_axes, says
from dehyst.report.text import count
from dehyst.report.theme import CYCLE, MUTED, TRAIN
from dehyst.report.thin import Window


def terms_figure(fit: Fit) -> Figure | None:
    """Return the figure, or None for a model without such terms."""
    rec = fit.recordings[0]
    unit = f" [{rec.input_unit}/{rec.output_unit}]" if rec.input_unit and rec.output_unit else ""
    panels = tuple(
        Panel(
            table.name.capitalize(),
            partial(_draw, table, f"weight{unit}"),
            says(f"{table.name.capitalize()}: {count(table.scale.size, 'term')} with weight."),
        )
        for table in fit.model.weight_tables
        if table.scale.size
    )
    caption = (
        f"Terms with weight, over their scale: {fit.size}. All weights are 0 or more, so every term opposes motion. "
        f"{'; '.join(fit.model.remarks).capitalize()}."
    )
    return Figure("terms", "What the model is made of", caption, panels) if panels else None


def _draw(table: WeightTable, label: str, axes: Axes) -> None:
    scale, weights = table.scale, table.weights
    window = Window.around((scale, weights.max(axis=0)), (scale, np.zeros(scale.size)), margin=0.08)
    label_axes(axes, window, f"{table.label} [{table.unit}]" if table.unit else table.label, label)
    axes.axhline(0.0, color=MUTED.light, lw=0.8, zorder=1)
    for k, row in enumerate(weights):
        token, there = (TRAIN if weights.shape[0] == 1 else CYCLE[k % len(CYCLE)]), row > 0.0
        name = "weight" if weights.shape[0] == 1 else f"set {k + 1}"
        axes.vlines(scale[there], 0.0, row[there], color=token.light, lw=1.6, zorder=2)
        axes.plot(scale[there], row[there], "o", color=token.light, ms=4.5, mew=0.0, label=name, zorder=3)
    add_legend(axes)
