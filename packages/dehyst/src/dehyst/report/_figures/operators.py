"""Figures of what a model is made of: its play operators, their weights and loading curve, its other terms."""

from __future__ import annotations

from functools import partial

import numpy as np

from dehyst.arrays import Array
from dehyst.data import turning_points
from dehyst.identification import Fit
from dehyst.models import MonotoneMap, PrandtlIshlinskii
from dehyst.models import kit as models_kit
from dehyst.report._drawing import PanelLine, chart, label_axes, stems, time_of
from dehyst.report._parts import Axes, Draw, PageFigure, Panel
from dehyst.report._text import bracketed, count, number, with_unit
from dehyst.report._theme import BAD, CYCLE, FIFTH, INK, MUTED, STATIC, TEST, TRAIN
from dehyst.report._thin import Window

_LOOKS = ((TRAIN, 2.6), (FIFTH, 1.8), (TEST, 1.1))
# Plays are told apart in the picture when their thresholds differ by this share of half the input's range.
APART = 0.06
# Loops drawn over time: enough to see the memory, few enough to follow.
LOOPS_SHOWN = 3

FORMULA = "z[k] = max( x[k] − c − r,  min( x[k] − c + r,  z[k−1] ) )"


def play_figure(fit: Fit, across: str = "") -> PageFigure | None:
    """Return the plays of the model over this log's own input (the paper's figure 4); None for a model without memory.

    `across` names the input, if not as the log does.
    """
    core = fit.model.play_core
    if core is None:
        return None
    rec = fit.recordings[0]
    chosen = typical_thresholds(core, 0.5 * float(np.ptp(rec.input)))
    names = [with_unit(float(r), rec.input_unit) for r in chosen]
    caption = (
        f"The building block of the model: a play of half width r, driven by this log's input less its centre "
        f"c\u00a0=\u00a0{with_unit(core.center, rec.input_unit)}. While the input moves inside the play, z stands "
        f"still; that is the memory. Drawn for r\u00a0=\u00a0{', '.join(names)}, out of {core.nonzero_weights} with "
        "weight; the model is their weighted sum."
    )
    x, plays = _plays(fit, core, chosen)
    t, label = time_of(rec)
    points = turning_points(x)
    end = int(points[2 * LOOPS_SHOWN + 1]) if points.size > 2 * LOOPS_SHOWN + 2 else x.size
    looks = [
        (z, f"r = {name}", token, width)
        for z, name, (token, width) in zip(plays, names, _LOOKS, strict=False)
    ]
    over_input = [
        PanelLine(x, z, token, name, width, outline=True) for z, name, token, width in looks
    ]
    over_time = [PanelLine(t[:end], z[:end], token, name, width) for z, name, token, width in looks]
    if chosen[0] > 0.0:  # the play of width zero is the centred input itself
        over_time.insert(0, PanelLine(t[:end], x[:end] - core.center, MUTED, "x − c", 0.9))
    up = f"play z{bracketed(rec.input_unit)}"
    return PageFigure(
        "play",
        "The play operator",
        caption,
        (
            Panel(
                "Play over input",
                chart(across or rec.input_label, up, over_input),
                f"Play operators with r = {', '.join(names)} over the input: parallelograms of width 2 r.",
            ),
            Panel(
                "Play over time" + ("" if end == x.size else f", first {LOOPS_SHOWN} loops"),
                chart(label, up, over_time),
                "The input and the same play operators over time; each follows after a turn of 2 r.",
            ),
        ),
        FORMULA,
    )


def typical_thresholds(core: PrandtlIshlinskii, reach: float) -> Array:
    """Return two or three thresholds to draw: the play without width, a wide one and one between, where it differs.

    Parameters
    ----------
    core
        The plays; those that carry weight are chosen from.
    reach
        Half the range of the input, which decides what can be told apart. [input]

    Examples
    --------
    >>> typical_thresholds(PrandtlIshlinskii([0.0, 0.01, 0.3, 0.9, 1.9], [1.0, 1.0, 1.0, 1.0, 1.0]), 2.0).tolist()
    [0.0, 0.3, 0.9]
    >>> typical_thresholds(PrandtlIshlinskii([0.0, 0.01, 0.05, 0.2], [1.0, 1.0, 1.0, 1.0]), 2.0).tolist()
    [0.0, 0.2]
    """
    first = core.thresholds[:1]
    carrying = core.thresholds[(core.weights != 0.0) & (core.thresholds > first[0])]
    if carrying.size == 0:
        return first
    # The widest plays hardly move; a play of half the reach shows what a play is.
    wide = _nearest(carrying, 0.5 * reach)
    middle = _nearest(carrying, first[0] + (wide - first[0]) / 3.0)
    between = [middle] if min(middle - first[0], wide - middle) >= APART * reach else []
    return np.array([first[0], *between, wide])


def _nearest(values: Array, aim: float) -> float:
    return float(values[int(np.argmin(np.abs(values - aim)))])


def _plays(fit: Fit, core: PrandtlIshlinskii, thresholds: Array) -> tuple[Array, list[Array]]:
    """Input of the first piece (T,) and the play of each threshold (T,), memory as identified."""
    piece = fit.recordings[0].pieces[0]
    x = np.asarray(fit.recordings[0].input[piece])
    plays = []
    for r in thresholds:
        k = int(np.argmin(np.abs(core.thresholds - r)))
        state = None if core.state is None else core.state[k : k + 1]
        plays.append(
            PrandtlIshlinskii(np.array([r]), np.ones(1), 0.0, state, core.center).simulate(x)
        )
    return x, plays


def weights_figure(fit: Fit) -> PageFigure | None:
    """Return weights, initial loading curve and output map; None for a model without memory."""
    core, (kind, _, slope), (_, mapping) = fit.model.play_core, fit.model.operators, fit.model.maps
    if core is None:
        return None
    undetermined = np.array(fit.certificate.undetermined, dtype=np.float64)
    across, up, ratio = (bracketed(unit) for unit in _units(fit))
    caption = (
        f"Weight of each {kind} operator over its threshold; {fit.certificate.nonzero_weights} of "
        f"{fit.certificate.operators} offered have one. "
    )
    if slope is not None:
        caption += f"The slope that remains when all of them slip is k = {with_unit(slope, _units(fit)[2])}. "
    if undetermined.size:
        caption += (
            f"Crosses: {count(undetermined.size, 'operator')} that never moved in the fitted samples; the data says "
            "nothing about them. "
        )
    caption += (
        "Thin lines: interval of each weight (95 %); neighbours can stand in for each other. "
        "Initial loading curve φ(r): the output while the input rises by r from the state zero. Its slope is the sum "
        "of the weights so far; the inverse model has the inverse curve."
    )
    panels = [
        Panel(
            "Weights over thresholds",
            partial(_draw_weights, fit, core, undetermined, across, ratio),
            f"{count(core.nonzero_weights, 'weight')}, thresholds up to {number(float(core.thresholds[-1]))}.",
        ),
        Panel(
            "Initial loading curve φ(r)",
            _loading(fit, core, across, up),
            "Initial loading curve from zero to the largest input of the log.",
        ),
    ]
    if mapping is not None:
        caption += (
            " Output map S: bends the sum of the operators into a loop that saturates or is asymmetric; dots are its "
            "breakpoints."
        )
        words = f"Monotone map with {mapping.u.size} breakpoints."
        panels.append(Panel("Output map S", _map(fit, mapping), words))
    return PageFigure("weights", "Weights and loading curve", caption, tuple(panels))


def _units(fit: Fit) -> tuple[str, str, str]:
    """Unit of the input, of what the operators add up to, and of a weight."""
    rec = fit.recordings[0]
    both = rec.input_unit and rec.output_unit
    return rec.input_unit, rec.output_unit, f"{rec.output_unit}/{rec.input_unit}" if both else ""


def _draw_weights(
    fit: Fit, core: PrandtlIshlinskii, undetermined: Array, across: str, unit: str, axes: Axes
) -> None:
    kind, weights, _ = fit.model.operators
    carrying = weights != 0.0
    r, w = core.thresholds[carrying], weights[carrying]
    edge = max(float(core.thresholds[-1]), float(undetermined.max(initial=0.0)), 1e-300)
    zero = np.zeros(1)
    window = Window.around((np.array([0.0, edge]), np.zeros(2)), (r, w), (zero, zero), margin=0.06)
    label_axes(
        axes,
        window,
        f"threshold r{across}",
        f"{'stop weight s' if kind == 'stop' else 'weight w'}{unit}",
    )
    axes.axhline(0.0, color=MUTED.light, lw=0.8, zorder=1)
    for sign, token, name in ((w > 0, TRAIN, "weight"), (w < 0, TEST, "negative weight")):
        if sign.any():
            stems(axes, r[sign], w[sign], token, name)
    interval = fit.weight_interval
    if interval is not None:
        low, high = interval.low[carrying], interval.high[carrying]
        axes.vlines(r, low, high, color=INK.light, lw=1.0, zorder=4)
    if undetermined.size:
        cross = {"ms": 6, "mew": 1.5, "zorder": 4, "clip_on": False, "label": "not determined"}
        axes.plot(undetermined, np.zeros_like(undetermined), "x", color=BAD.light, **cross)


def _loading(fit: Fit, core: PrandtlIshlinskii, across: str, up: str) -> Draw:
    reach = max(float(np.max(np.abs(rec.input - core.center))) for rec in fit.recordings)
    r = np.union1d(np.linspace(0.0, reach, 200), core.thresholds[core.thresholds <= reach])
    return chart(f"r{across}", f"φ(r){up}", [PanelLine(r, core.loading_curve(r), TRAIN, width=1.8)])


def _map(fit: Fit, mapping: MonotoneMap) -> Draw:
    # The map goes on beyond the data; only the part that this log used is of interest.
    ends = np.array([extreme(np.concatenate(fit.predictions)) for extreme in (np.min, np.max)])
    low, high = np.sort(mapping.inverse()(ends))
    inner = mapping.u[(mapping.u > low) & (mapping.u < high)]
    u = np.concatenate([[low], inner, [high]])
    unit = bracketed(fit.recordings[0].output_unit)
    lines = [
        PanelLine(u, mapping(u), STATIC, width=1.8),
        PanelLine(inner, mapping(inner), STATIC, width=0.0, marker="o"),
    ]
    return chart(f"sum of the operators H[x]{unit}", f"output S{unit}", lines)


def terms_figure(fit: Fit) -> PageFigure | None:
    """Return the weights of other terms over their scale; None for a model without such terms."""
    rec = fit.recordings[0]
    unit = bracketed(
        f"{rec.input_unit}/{rec.output_unit}" if rec.input_unit and rec.output_unit else ""
    )
    panels = tuple(
        Panel(
            table.name.capitalize(),
            partial(_draw_terms, table, f"weight{unit}"),
            f"{table.name.capitalize()}: {count(table.scale.size, 'term')} with weight.",
        )
        for table in fit.model.weight_tables
        if table.scale.size
    )
    caption = (
        f"Terms with weight, over their scale: {fit.size}. All weights are 0 or more, so every term opposes motion. "
        f"{'; '.join(fit.model.remarks).capitalize()}."
    )
    return PageFigure("terms", "What the model is made of", caption, panels) if panels else None


def _draw_terms(table: models_kit.WeightTable, label: str, axes: Axes) -> None:
    scale, weights = table.scale, table.weights
    window = Window.around((scale, weights.max(axis=0)), (scale, np.zeros(scale.size)), margin=0.08)
    label_axes(axes, window, f"{table.label}{bracketed(table.unit)}", label)
    axes.axhline(0.0, color=MUTED.light, lw=0.8, zorder=1)
    alone = weights.shape[0] == 1
    for k, row in enumerate(weights):
        positive = row > 0.0
        name = "weight" if alone else f"set {k + 1}"
        stems(axes, scale[positive], row[positive], TRAIN if alone else CYCLE[k % len(CYCLE)], name)
