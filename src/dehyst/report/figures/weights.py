"""Figure 7: weights, initial loading curve and output map, or weights over their scale: the model itself."""

from __future__ import annotations

from functools import partial

import numpy as np

from dehyst.identification.fit import Fit
from dehyst.models import MonotoneMap, PrandtlIshlinskii
from dehyst.models.model import WeightTable
from dehyst.report.figures.panel import Axes, Figure, Panel, add_legend, label_axes, says
from dehyst.report.text import count, number, with_unit
from dehyst.report.theme import BAD, CYCLE, MUTED, STATIC, TEST, TRAIN
from dehyst.report.thin import Window


def weights_figure(fit: Fit) -> Figure | None:
    """Return figure 7, or None for a model without memory."""
    core = fit.model.play_core
    if core is None:
        return None
    undetermined = np.array(fit.certificate.undetermined, dtype=np.float64)
    kind, _, slope = fit.model.operators
    caption = (
        f"Weight of each {kind} operator over its threshold; {fit.certificate.nonzero_weights} of "
        f"{fit.certificate.operators} offered have one. "
    )
    if slope is not None:
        left = with_unit(slope, _units(fit)[2].strip(" []"))
        caption += f"The slope that remains when all of them slip is k = {left}. "
    if undetermined.size:
        caption += (
            f"Crosses: {count(undetermined.size, 'operator')} that never moved in the fitted samples; the data says "
            "nothing about them. "
        )
    caption += (
        "Initial loading curve φ(r): the output while the input rises by r from the state zero. Its slope is the sum "
        "of the weights so far; the inverse model has the inverse curve."
    )
    panels = [
        Panel(
            "Weights over thresholds",
            partial(_draw_weights, fit, core, undetermined),
            says(f"{count(core.nonzero_weights, 'weight')}, thresholds up to {number(float(core.thresholds[-1]))}."),
        ),
        Panel(
            "Initial loading curve φ(r)",
            partial(_draw_loading, fit, core),
            says("Initial loading curve from zero to the largest input of the log."),
        ),
    ]
    mapping = fit.model.maps[1]
    if mapping is not None:
        caption += (
            " Output map S: bends the sum of the operators into a loop that saturates or is asymmetric; dots are its "
            "breakpoints."
        )
        panels.append(
            Panel(
                "Output map S",
                partial(_draw_map, fit, mapping),
                says(f"Monotone map with {mapping.u.size} breakpoints."),
            )
        )
    return Figure("weights", "Weights and loading curve", caption, tuple(panels))


def _units(fit: Fit) -> tuple[str, str, str]:
    """Unit of the input, of what the operators add up to, and of a weight."""
    rec = fit.recordings[0]
    if rec.input_unit and rec.output_unit:
        return f" [{rec.input_unit}]", f" [{rec.output_unit}]", f" [{rec.output_unit}/{rec.input_unit}]"
    return (f" [{rec.input_unit}]" if rec.input_unit else ""), (f" [{rec.output_unit}]" if rec.output_unit else ""), ""


def _reach(fit: Fit, core: PrandtlIshlinskii) -> float:
    """Largest distance of the input from the model's centre. [input]"""
    return max(float(np.max(np.abs(rec.input - core.center))) for rec in fit.recordings)


def _draw_weights(fit: Fit, core: PrandtlIshlinskii, undetermined: np.ndarray, axes: Axes) -> None:
    across, _, unit = _units(fit)
    kind, weights, _ = fit.model.operators
    carrying = weights != 0.0
    r, w = core.thresholds[carrying], weights[carrying]
    edge = max(float(core.thresholds[-1]), float(undetermined.max(initial=0.0)), 1e-300)
    zero = np.zeros(1)
    window = Window.around((np.array([0.0, edge]), np.zeros(2)), (r, w), (zero, zero), margin=0.06)
    label_axes(axes, window, f"threshold r{across}", f"{'stop weight s' if kind == 'stop' else 'weight w'}{unit}")
    axes.axhline(0.0, color=MUTED.light, lw=0.8, zorder=1)
    for sign, token, name in ((w > 0, TRAIN, "weight"), (w < 0, TEST, "negative weight")):
        if sign.any():
            axes.vlines(r[sign], 0.0, w[sign], color=token.light, lw=1.6, zorder=2)
            axes.plot(r[sign], w[sign], "o", color=token.light, ms=4.5, mew=0.0, label=name, zorder=3)
    if undetermined.size:
        axes.plot(
            undetermined,
            np.zeros_like(undetermined),
            "x",
            color=BAD.light,
            ms=6,
            mew=1.5,
            zorder=4,
            clip_on=False,
            label="not determined",
        )
    add_legend(axes)


def _draw_loading(fit: Fit, core: PrandtlIshlinskii, axes: Axes) -> None:
    across, up, _ = _units(fit)
    reach = _reach(fit, core)
    r = np.union1d(np.linspace(0.0, reach, 200), core.thresholds[core.thresholds <= reach])
    phi = core.loading_curve(r)
    window = Window.around((r, phi))
    label_axes(axes, window, f"r{across}", f"φ(r){up}")
    axes.plot(r, phi, color=TRAIN.light, lw=1.8)


def _draw_map(fit: Fit, mapping: MonotoneMap, axes: Axes) -> None:
    # The map goes on beyond the data; only the part that this log used is of interest.
    ends = np.array([extreme(np.concatenate(fit.predictions)) for extreme in (np.min, np.max)])
    low, high = np.sort(mapping.inverse()(ends))
    inner = mapping.u[(mapping.u > low) & (mapping.u < high)]
    u = np.concatenate([[low], inner, [high]])
    window = Window.around((u, mapping(u)))
    unit = f" [{fit.recordings[0].output_unit}]" if fit.recordings[0].output_unit else ""
    label_axes(axes, window, f"sum of the operators H[x]{unit}", f"output S{unit}")
    axes.plot(u, mapping(u), color=STATIC.light, lw=1.8)
    axes.plot(inner, mapping(inner), "o", color=STATIC.light, ms=4.0, mew=0.0)


def terms_figure(fit: Fit) -> Figure | None:
    """Return the figure, or None for a model without such terms."""
    rec = fit.recordings[0]
    unit = f" [{rec.input_unit}/{rec.output_unit}]" if rec.input_unit and rec.output_unit else ""
    panels = tuple(
        Panel(
            table.name.capitalize(),
            partial(_draw_terms, table, f"weight{unit}"),
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


def _draw_terms(table: WeightTable, label: str, axes: Axes) -> None:
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
