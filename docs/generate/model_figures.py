"""A figure for each model: families answer the same oscillation, muscles show their map and a loop."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

import dehyst
from dehyst import families
from dehyst.models import ModelCard, SignalCard
from dehyst_robot import muscles

Array = npt.NDArray[np.float64]

BLUE, ORANGE, GREY, MUTED = "#0072b2", "#d55e00", "#8a939e", "#566170"
SAMPLES = 150  # of a stroke
TURNS = (
    0.0,
    1.0,
    -1.0,
    0.8,
    -0.7,
    0.1,
    0.5,
    0.1,
    0.9,
    -1.0,
)  # a virgin curve, strokes, a minor loop
SPEEDS = ((8.0, BLUE, "slow"), (0.5, ORANGE, "16 times faster"))  # seconds a stroke
PRESSURES = (1e5, 3e5, 5e5)
STEPS = 241


def figures() -> dict[str, Callable[[], Figure]]:
    """Return what draws the figure of each model, by its name below docs/images."""
    drawn: dict[str, Callable[[], Figure]] = {}
    for name, model in _identified().items():
        drawn[f"models/{name}"] = partial(_loop_figure, model)
    for name in families.names():
        drawn[f"models/{name}"] = partial(_family_figure, name)
    for name in muscles.muscle_names():
        drawn[f"models/muscle-{name}"] = partial(_muscle_figure, name)
    return drawn


def oscillation() -> Array:
    """Return the input that every family answers, (T,)."""
    half = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, SAMPLES + 1)))[1:]
    strokes = [a + (b - a) * half for a, b in itertools.pairwise(TURNS)]
    return np.concatenate([[TURNS[0]], *strokes])


def _identified() -> dict[str, Any]:
    plain = dehyst.PrandtlIshlinskii([0.0, 0.1, 0.25, 0.5, 0.8], [0.35, 0.2, 0.2, 0.2, 0.2])
    leading = dehyst.PrandtlIshlinskii([0.0, 0.1, 0.25, 0.5], [1.8, -0.4, -0.3, -0.2])
    bend = dehyst.MonotoneMap([-1.2, -0.5, 0.0, 0.5, 1.2], [-0.75, -0.55, 0.0, 0.4, 0.55])
    card = ModelCard(
        SignalCard("input", low=-1.3, high=1.3), SignalCard("output", low=-1.0, high=1.0)
    )
    direct = dehyst.models.DirectInverse(
        radii=[0.1, 0.3, 0.6], stop_weights=[0.4, 0.3, 0.2], polynomial=[0, 0.8], card=card
    )
    return {
        "static": dehyst.models.StaticCurve(dehyst.MonotoneMap([-1.0, 0.0, 1.0], [-0.7, 0.1, 0.8])),
        "pi": plain,
        "pi-cumulative": leading,
        "modified-pi": dehyst.models.ModifiedPrandtlIshlinskii(plain, after_map=bend),
        "stop": dehyst.StopOperatorModel([0.0, 0.1, 0.3, 0.6], [0.0, 0.4, 0.3, 0.2], 0.5),
        "direct-inverse": direct,
    }


def _loop_figure(model: Any) -> Figure:
    x = oscillation()
    if isinstance(model, dehyst.models.DirectInverse):
        return _draw(
            x,
            [
                (
                    np.asarray(model.run(x, np.arange(x.size, dtype=np.float64)).u),
                    BLUE,
                    "input that the output needs",
                )
            ],
            "output",
            "input",
        )
    return _draw(x, [(model.simulate(x), BLUE, "")])


def _family_figure(name: str) -> Figure:
    x, model = oscillation(), families.example(name)
    if not model.rate_dependent:
        return _draw(x, [(model.simulate(x), BLUE, "")])
    lines = []
    for seconds, colour, label in SPEEDS:
        lines.append((model.simulate(x, np.arange(x.size) * seconds / SAMPLES), colour, label))
    return _draw(x, lines)


def _draw(
    x: Array, lines: list[tuple[Array, str, str]], across: str = "input", up: str = "output"
) -> Figure:
    figure = Figure(figsize=(7.2, 2.9), layout="constrained")
    loop, course = figure.subplots(1, 2, width_ratios=(1.0, 1.35))
    stroke = np.arange(x.size) / SAMPLES
    every = slice(None, None, 3)
    course.plot(stroke[every], x[every], color=GREY, lw=1.0, label=across)
    for y, colour, label in lines:
        loop.plot(x[every], y[every], color=colour, lw=1.3)
        course.plot(stroke[every], y[every], color=colour, lw=1.3, label=label or up)
    loop.set(xlabel=across, ylabel=up)
    course.set(xlabel="strokes")
    course.legend(fontsize=8, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3)
    return figure


def _muscle_figure(name: str) -> Figure:
    model = muscles.muscle(name)
    figure = Figure(figsize=(7.2, 2.9), layout="constrained")
    chart, loop = figure.subplots(1, 2)
    kappa = np.linspace(0.0, 0.3, 61)
    for p in PRESSURES:
        force = model.static_force(kappa, np.full_like(kappa, p), clamp=True)
        chart.plot(100 * kappa, force, color=BLUE, lw=1.2)
        chart.annotate(f"{p / 1e5:g} bar", (0.4, force[0]), fontsize=8, color=MUTED, va="bottom")
    chart.set(xlabel="contraction [%]", ylabel="force [N]")
    t = np.linspace(0.0, 20.0, STEPS)
    motion = 0.08 + 0.05 * np.sin(2 * np.pi * t / 8.0) * (1.0 - 0.03 * t)
    loop.plot(100 * motion, model.simulate(motion, 3e5, t), color=ORANGE, lw=1.2)
    loop.set(xlabel="contraction [%]", ylabel="force at 3 bar [N]")
    return figure
