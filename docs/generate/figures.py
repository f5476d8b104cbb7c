"""Every figure of README.md and docs/: docs/images/*.svg, and arm.png for places that show no SVG."""

from __future__ import annotations

import contextlib
import io
import itertools
import json
import runpy
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from scipy.signal import TransferFunction, lsim

import dehyst
from dehyst.data import measure_loops, sensor_data_sheet
from dehyst.io import example_recording
from dehyst_targets.backlash import AxisReadings, lost_motion, make_table, plan_measurement
from dehyst_targets.batteries import fit_ocv, ocv_of
from dehyst_targets.magnetics import core_of, fit_core
from dehyst_targets.valves import ControlLoop, judge_valve
from generate import (
    bouc_wen,
    demo,
    families_in_controller,
    model_figures,
    rivals,
    speed,
    which_model,
)
from generate.joint import respond

Array = npt.NDArray[np.float64]

INK, MUTED, GRID = "#1b2530", "#566170", "#e2e6eb"
BLUE, ORANGE, GREEN, GREY = "#0072b2", "#d55e00", "#007a5a", "#8a939e"
STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 11,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#97a1ad",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titlelocation": "left",
    "axes.titlesize": 12,
    "axes.titleweight": "bold",
    "grid.color": GRID,
    "xtick.color": "#97a1ad",
    "ytick.color": "#97a1ad",
    "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.hashsalt": "dehyst",
    "svg.fonttype": "path",  # letters as outlines: the same picture wherever it is shown
    "path.simplify_threshold": 0.2,
}
ROOT = Path(__file__).parents[2]
INTEGRATOR = ROOT / "benchmarks" / "results" / "integrator.json"
STEP = 0.02  # sampling time of the simulated joint [s]


def build(folder: Path, names: set[str] | None = None) -> list[Path]:
    """Draw every figure, or those of some names; return the files."""
    files = []
    for name, draw in FIGURES.items():
        if names is None or name in names:
            files += write(name, draw, folder)
    return files


def write(name: str, draw: Callable[[], Figure], folder: Path) -> list[Path]:
    """Draw one figure as SVG, and as PNG where that is wanted too. No date, no address, no random ids."""
    with matplotlib.rc_context({**matplotlib.rcParamsDefault, "backend": "agg", **STYLE}):
        figure = draw()
        svg = io.StringIO()
        figure.savefig(
            svg,
            format="svg",
            metadata={"Date": None, "Creator": None, "Format": None, "Type": None},
        )
        text = svg.getvalue()
        files = [folder / f"{name}.svg"]
        files[0].parent.mkdir(parents=True, exist_ok=True)
        files[0].write_text(
            "\n".join(line.rstrip() for line in text[text.index("<svg") :].split("\n")), "utf-8"
        )
        if name in WITH_PNG:
            files.append(folder / f"{name}.png")
            figure.savefig(files[1], format="png", dpi=180, metadata={"Software": None})
    return files


@cache
def example_fit() -> dehyst.Fit:
    """The example log, identified as `dehyst identify` does without options."""
    return dehyst.identify(example_recording())


@cache
def tracking() -> tuple[Array, Array, Array, Array]:
    """Time, reference, and angles of the simulated joint driven by a curve's and by the model's inverse."""
    fit = example_fit()
    time = np.arange(0.0, 60.0, STEP)
    wanted = 26.0 * np.linspace(1.0, 0.25, time.size) * np.sin(2 * np.pi * time / 10.0)
    plain, compensated = (
        respond(m.inverse().simulate(wanted, time), STEP) for m in (fit.static, fit.model)
    )
    return time, wanted, plain, compensated


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def arm() -> Figure:
    """The picture of README.md: where the tool of the simulated arm goes, and the error of its joint 1."""
    figure = Figure(figsize=(9.6, 4.7), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.25))
    on = demo.run("fast", demo.COMPENSATOR)
    off = demo.run("fast", "off")
    wanted = demo.in_test_plane(on, on.tool_desired)
    left.plot(*wanted.T, color="#c3cad3", lw=4.0, label="wanted", solid_joinstyle="round")
    left.plot(
        *demo.in_test_plane(off, off.tool).T, color=ORANGE, lw=1.3, label="without compensator"
    )
    left.plot(*demo.in_test_plane(on, on.tool).T, color=BLUE, lw=1.3, label="with compensator")
    left.set(
        title="Tool in the test plane, fast trial", xlabel="[mm]", ylabel="[mm]", aspect="equal"
    )
    left.set(xlim=(-200, 200), ylim=(-255, 380))
    left.legend(loc="upper center", ncols=1, handlelength=1.6, borderaxespad=0.2, fontsize=10)
    off, on = demo.run("slow", "off"), demo.run("slow", demo.COMPENSATOR)
    right.axhline(0.0, color="#97a1ad", lw=0.8)
    for run, colour in ((off, ORANGE), (on, BLUE)):
        right.plot(run.time, np.degrees(run.error[:, 0]), color=colour, lw=1.6)
    right.set(title="Error of joint 1, slow trial", xlabel="time [s]", ylabel="angle error [deg]")
    high = 1.35 * float(np.degrees(np.abs(off.error[:, 0]).max()))
    right.set(xlim=(0, float(on.time[-1])), ylim=(-high, high))
    for words, value, colour, y in zip(
        ("without compensator", "with compensator"),
        demo.errors(demo.experiment(), "slow")[:2],
        (ORANGE, BLUE),
        (0.96, -0.96),
        strict=True,
    ):
        right.text(
            0.99, 0.5 + 0.5 * y, f"{words}: {value:.3f}° rms", color=colour, ha="right",
            va="top" if y > 0 else "bottom", transform=right.transAxes,
        )  # fmt: skip
    return figure


def loop() -> Figure:
    """The example's loop with the model over it, and what the compensator does."""
    fit = example_fit()
    rec = fit.recordings[0]
    figure = Figure(figsize=(9.6, 4.3), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.12))
    held = fit.test_masks[0]
    x, y, model = rec.input[held], rec.output[held], fit.predictions[0][held]
    inset = left.inset_axes((0.58, 0.09, 0.41, 0.44))
    for axes, widths in ((left, (2.6, 0.7)), (inset, (4.0, 1.0))):
        axes.plot(x, y, color="#86bbdf", lw=widths[0], label="measured", solid_joinstyle="round")
        axes.plot(x, model, color=INK, lw=widths[1], label="model, fitted to earlier loops")
    inset.set(xlim=(0.25, 1.75), ylim=(3.5, 17.5), xticks=[], yticks=[], facecolor="white")
    for spine in inset.spines.values():
        spine.set(visible=True, color="#97a1ad")
    left.indicate_inset_zoom(inset, edgecolor="#566170", alpha=0.6)
    left.set(
        title="One log becomes a model", xlabel="pressure difference [bar]", ylabel="angle [deg]"
    )
    left.set(xlim=(-4.7, 4.7), ylim=(-34, 38))
    left.legend(loc="upper left", handlelength=1.6, borderaxespad=0.2)
    time, wanted, plain, compensated = tracking()
    right.axhline(0.0, color="#97a1ad", lw=0.8)
    right.plot(time, plain - wanted, color=ORANGE, lw=1.6)
    right.plot(time, compensated - wanted, color=BLUE, lw=1.6)
    right.set(
        title="Its inverse takes the hysteresis out",
        xlabel="time [s]",
        ylabel="angle error of the simulated joint [deg]",
    )
    high = 1.75 * float(np.max(np.abs(plain - wanted)))
    right.set(xlim=(0, 60), ylim=(-high, high))
    right.text(
        59.5, 0.95 * high, f"best curve without hysteresis: {rms(plain - wanted):.2f}° rms", color=ORANGE, ha="right",
        va="top",
    )  # fmt: skip
    right.text(
        59.5, -0.95 * high, f"with the compensator: {rms(compensated - wanted):.2f}° rms", color=BLUE, ha="right",
        va="bottom",
    )  # fmt: skip
    return figure


def play() -> Figure:
    """The play operator, and how a sum of plays makes a loop."""
    x = np.concatenate(
        [
            np.linspace(a, b, 200)
            for a, b in ((0, 2), (2, -2), (-2, 2), (2, 0.3), (0.3, 1.4), (1.4, 0))
        ]
    )
    figure = Figure(figsize=(9.6, 4.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    for r, colour in ((0.0, GREY), (0.5, BLUE), (1.0, ORANGE)):
        z = dehyst.PrandtlIshlinskii([0.0, max(r, 1e-9)], [0.0, 1.0]).simulate(x) if r else x
        left.plot(x, z, color=colour, lw=2.0, label=f"r = {r:g}")
    left.set(title="Plays of three half widths", xlabel="input x", ylabel="play z")
    left.legend(loc="upper left")
    model = dehyst.PrandtlIshlinskii([0.0, 0.25, 0.5, 0.75, 1.0], [0.3, 0.25, 0.2, 0.2, 0.2])
    right.plot(x, model.simulate(x), color=INK, lw=2.0)
    r = np.linspace(0, 2, 50)
    right.plot(
        r, model.loading_curve(r), color=GREEN, lw=3.5, alpha=0.5, label="initial loading curve"
    )
    right.set(title="A weighted sum of plays", xlabel="input x", ylabel="output y")
    right.legend(loc="upper left")
    return figure


def misprint() -> Figure:
    """The closed inverse, and what equation (18) gives as printed."""
    rng = np.random.default_rng(1)
    n = 20
    model = dehyst.PrandtlIshlinskii(np.arange(n) / n, 0.5 + rng.random(n))
    t = np.linspace(0.0, 4.0, 1601)
    x = np.sin(2 * np.pi * t) * (1.0 - 0.15 * t)
    r, w = model.thresholds, model.weights
    printed = np.array([np.sum(w[: i + 1] * (r[i] - w[: i + 1])) for i in range(n)])
    inverse = model.inverse()
    z = np.zeros(n)
    answers = []
    for y in model.simulate(
        x
    ).tolist():  # thresholds may be negative here, which the model class refuses
        z = np.maximum(y - printed, np.minimum(y + printed, z))
        answers.append(float(inverse.weights @ z))
    figure = Figure(figsize=(9.6, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(t, x, color="#86bbdf", lw=4.0, label="input of the model")
    left.plot(
        t,
        inverse.simulate(model.simulate(x)),
        color=INK,
        lw=1.0,
        label="found again by the inverse",
    )
    left.set(
        title="Equation (18) corrected: r$_i$ − r$_j$",
        xlabel="time",
        ylabel="input x",
        ylim=(-1.2, 1.6),
    )
    left.legend(loc="upper right", ncols=2, fontsize=10)
    right.plot(t, x, color="#86bbdf", lw=4.0, label="input of the model")
    right.plot(t, answers, color=ORANGE, lw=1.2, label="answer as printed")
    right.set(title="Equation (18) as printed: r$_i$ − w$_j$", xlabel="time", ylim=(-3.2, 2.0))
    right.legend(loc="upper right", ncols=2, fontsize=10)
    return figure


def families() -> Figure:
    """A typical loop of each family."""
    t = np.linspace(0.0, 2.0, 801)
    x = np.sin(2 * np.pi * t) * np.where(t < 1.25, 1.0, 0.55)
    r = np.array([0.0, 0.15, 0.3, 0.5])
    play = dehyst.PrandtlIshlinskii(r, [0.35, 0.35, 0.3, 0.25])
    bend = dehyst.MonotoneMap([-1.4, -0.5, 0.1, 0.5, 1.4], [-1.1, -0.55, 0.15, 0.45, 0.62])
    shown = (
        ("pi", play, "lags, symmetric"),
        (
            "modified-pi",
            dehyst.ModifiedPrandtlIshlinskii(play, after_map=bend),
            "lags, saturates, asymmetric",
        ),
        (
            "stop",
            dehyst.StopOperatorModel(r, [0.0, 1.6, 0.9, 0.5], 0.35),
            "leads: force over displacement",
        ),
    )
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    for axes, (name, model, words) in zip(figure.subplots(1, 3), shown, strict=True):
        y = model.simulate(x)
        axes.plot(x[200:], y[200:], color=BLUE, lw=2.0)
        for k in (430, 630):
            axes.annotate(
                "", xy=(x[k + 12], y[k + 12]), xytext=(x[k], y[k]),
                arrowprops={"arrowstyle": "-|>", "color": INK, "mutation_scale": 16, "lw": 0},
            )  # fmt: skip
        axes.set(title=name, xlabel="input", xticklabels=[], yticklabels=[])
        axes.set_ylabel("output" if name == "pi" else "")
        axes.text(0.03, 0.97, words, transform=axes.transAxes, va="top", color=MUTED, fontsize=10)
    return figure


def creep() -> Figure:
    """What a rate-independent model cannot follow: the simulated joint creeps while the pressure is held."""
    time, pressure, angle, plays, chosen = hold()
    figure = Figure(figsize=(9.6, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(time, pressure, color=GREY, lw=2.0)
    left.set(
        title="Pressure, held for three minutes",
        xlabel="time [s]",
        ylabel="pressure difference [bar]",
    )
    right.plot(time, angle, color=BLUE, lw=2.0, label="simulated joint")
    right.plot(time, plays, color=INK, lw=1.2, label="plays (modified-pi)")
    right.plot(time, chosen, color=ORANGE, lw=1.2, label="what identify chooses")
    right.set(
        title="Angle, from 14 deg on", xlabel="time [s]", ylabel="angle [deg]", ylim=(14.0, 16.2)
    )
    right.legend(loc="lower right")
    return figure


def hold() -> tuple[Array, Array, Array, Array, Array]:
    """Time, pressure, angles of the simulated joint, of plays and of the chosen model: a ramp of 2 s, then a hold."""
    time = np.arange(0.0, 182.0, STEP)
    pressure = 2.0 * np.minimum(time / 2.0, 1.0)
    plays = dehyst.identify(example_recording(), "modified-pi").model
    return (
        time, pressure, respond(pressure, STEP), plays.simulate(pressure),
        example_fit().model.simulate(pressure, time),
    )  # fmt: skip


def stack() -> Figure:
    """The state of all plays at three moments: a broken line, one piece for each turn that is remembered."""
    corners = (0.0, 1.0, -0.6, 0.5, -0.25, 0.15, 0.75)
    r = np.linspace(0.0, 1.1, 1101)
    model = dehyst.PrandtlIshlinskii(r, np.full(r.size, 1.0 / r.size))
    path = np.concatenate(
        [np.linspace(a, b, 60, endpoint=False) for a, b in itertools.pairwise(corners)] + [[0.75]]
    )
    figure = Figure(figsize=(9.6, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
    left.plot(path, color=GREY, lw=1.6)
    shown = ((4, GREEN, "A", 6.0), (5, BLUE, "B", 3.6), (6, ORANGE, "C", 1.6))
    for index, colour, name, width in shown:
        sample = 60 * index
        left.plot(sample, corners[index], "o", color=colour, ms=8)
        left.annotate(
            name, (sample, corners[index]), xytext=(7, 5), textcoords="offset points", color=colour
        )
        z = model.final_state(path[: sample + 1])
        right.plot(r, z, color=colour, lw=width, label=name)
        turns = [0, *(np.flatnonzero(np.abs(np.diff(z, 2)) > 1e-6) + 1)]
        right.plot(r[turns], z[turns], "o", color=colour, ms=width + 2.5)
    left.set(title="Input", xlabel="sample", ylabel="x")
    right.set(title="States of 1101 plays", xlabel="threshold r", ylabel="state z(r)")
    right.legend(loc="upper right", ncols=3)
    return figure


def speed_over_operators() -> Figure:
    """Time a sample over the number of operators, from the committed run of the benchmark."""
    figure = Figure(figsize=(9.6, 4.2), layout="constrained")
    axes = figure.subplots()
    n = (14, 100, 1000, 10_000)
    lines = (
        ("numpy loop", "smooth", GREY, "-", "numpy loop"),
        ("numba", "smooth", GREY, "--", "numba"),
        ("engine", "white", ORANGE, "-", "dehyst, white noise"),
        ("engine", "noisy", GREEN, "-", "dehyst, 1 % noise"),
        ("engine", "smooth", BLUE, "-", "dehyst, smooth"),
        ("memcpy", "smooth", INK, ":", "copying the signal"),
    )
    for method, signal, colour, style, label in lines:
        values = [speed.times(f"evaluation, n = {k}", method, signal) for k in n]
        axes.loglog(n, values, style, color=colour, lw=2.0, marker="o", ms=4, label=label)
    axes.set(title="Evaluation, one thread", xlabel="number of operators n", ylabel="ns per sample")
    figure.legend(loc="outside right center")
    return figure


def excitation() -> Figure:
    """A designed excitation: what is run when."""
    plan = dehyst.design_excitation(-30.0, 30.0, rate=40.0, time_limit=360.0, unit="deg")
    time, angle, part = plan.signal(0.05)
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    axes = figure.subplots()
    for name, colour in (("home", GREY), ("loops", BLUE), ("holds", GREEN), ("test", ORANGE)):
        mine = part == name
        mine[1:] |= mine[:-1]  # no gap where the next one begins
        axes.plot(time, np.where(mine, angle, np.nan), color=colour, lw=1.6, label=name)
    axes.set(xlabel="time [s]", ylabel="command [deg]", xlim=(0, plan.duration), ylim=(-32, 44))
    axes.legend(loc="upper right", ncols=4)
    return figure


def backlash() -> Figure:
    """Readings of the simulated axis of the how-to: before a table of LinuxCNC, and with it."""
    axis = runpy.run_path(str(ROOT / "examples" / "backlash_axis.py"))
    plan = plan_measurement(0.0, 300.0, points=13, repeats=3)
    table, figure = None, Figure(figsize=(9.6, 3.6), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for panel, title in zip(panels, ("without a table", "with the table"), strict=True):
        commanded = np.array([reading.commanded for reading in plan.readings])
        rising = np.array([reading.rising for reading in plan.readings])
        error = np.array(axis["run"](plan.gcode(), table)) - commanded
        lost = lost_motion(AxisReadings.of(commanded, error, rising, unit="mm"))
        for name, values, spread, colour in (
            ("falling", lost.falling, lost.falling_spread, ORANGE),
            ("rising", lost.rising, lost.rising_spread, BLUE),
        ):
            ends = (1e3 * (values - 2 * spread), 1e3 * (values + 2 * spread))
            panel.fill_between(lost.nominal, *ends, color=colour, alpha=0.2, lw=0)
            panel.plot(lost.nominal, 1e3 * values, "o-", ms=4, color=colour, lw=1.6, label=name)
        panel.set(title=title, xlabel="commanded position [mm]")
        table = make_table(lost, "linuxcnc").compensation
    panels[0].set_ylabel("error [µm]")
    panels[1].legend(loc="upper left")
    return figure


def valves() -> Figure:
    """The simulated loop of the how-to: what answered, and the valve that was fitted."""
    loop = runpy.run_path(str(ROOT / "examples" / "simulators" / "valve_loop.py"))
    columns = loop["Loop"](loop["PROCESSES"]["flow"]).run()
    record = ControlLoop.of(columns["OP"], columns["PV"], columns["SP"], time=columns["time_s"])
    verdict = judge_valve(record)
    fit, figure = verdict.fit, Figure(figsize=(9.6, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, sharex=True)
    left.plot(record.output[400:], columns["PV"][400:], color=GREY, lw=0.7)
    left.set(title="measured", xlabel="controller output [%]", ylabel="measurement [%]")
    right.plot(fit.signal[400:], fit.path[400:], color=BLUE, lw=0.8)
    right.set(title="fitted valve", xlabel="controller output [%]", ylabel="valve [%]")
    across, up = (0.5 * (part[400:].min() + part[400:].max()) for part in (fit.signal, fit.path))
    half, jump = 0.5 * verdict.dead_band.value, 0.5 * verdict.jump.value
    arrow = {"arrowstyle": "<->", "color": ORANGE}
    right.annotate("", (across + half, up), (across - half, up), arrowprops=arrow)
    right.annotate("", (across + half, up + jump), (across + half, up - jump), arrowprops=arrow)
    right.text(across, up, "S", color=ORANGE, va="bottom")
    right.text(across + half, up + 0.5 * jump, " J", color=ORANGE)
    return figure


def magnetic_cores() -> Figure:
    """The simulated ferrite of the how-to: its loop, and the models of three simulators."""
    core = runpy.run_path(str(ROOT / "examples" / "simulators" / "ferrite_core.py"))["log"]()
    core = core_of(dehyst.Recording(core[:, 1], core[:, 2], input_unit="A/m", output_unit="mT"))
    figure = Figure(figsize=(9.6, 3.6), layout="constrained")
    fits, (h, b) = fit_core(core), core.path
    for panel, key in zip(
        figure.subplots(1, 3, sharey=True), ("chan", "jiles-atherton", "tellinen"), strict=True
    ):
        fit = fits[key]
        panel.plot(h, 1e3 * b, color=GREY, lw=3.0)
        panel.plot(h, 1e3 * fit.model.simulate(h, float(b[0])), color=BLUE, lw=1.2)
        panel.set(title=fit.name, xlabel="H [A/m]", xlim=(-100.0, 100.0))
    figure.axes[0].set_ylabel("B [mT]")
    return figure


def battery_voltage() -> Figure:
    """The simulated electrode of the how-to: its branches, and partial cycles with the model of one state."""
    log = ocv_of(*runpy.run_path(str(ROOT / "examples" / "simulators" / "ocv_cell.py"))["log"]().T)
    fit, figure = fit_ocv(log), Figure(figsize=(9.6, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    left.plot(log.x, log.voltage, color=GREY, lw=0.8)
    left.plot(fit.x, fit.delithiation, color=ORANGE, label="delithiation")
    left.plot(fit.x, fit.lithiation, color=BLUE, label="lithiation")
    left.set(title="branches", xlabel="x in the electrode", ylabel="U [V]")
    left.legend()
    minor = log.minor
    right.plot(log.x[minor], log.voltage[minor], ".", ms=2, color=GREY, label="measured")
    modelled = fit.simulate(log.x, fit.start(float(log.x[0]), float(log.voltage[0])))
    right.plot(log.x[minor], modelled[minor], ".", ms=2, color=BLUE, label="one state")
    right.set(title="partial cycles", xlabel="x in the electrode")
    right.legend(markerscale=4)
    return figure


def another_signal() -> Figure:
    """Loops of the warm actuator of the how-to at three temperatures, with and without the temperature in the model."""
    rig = runpy.run_path(str(ROOT / "examples" / "warm_actuator.py"))
    x = rig["strokes"](60, 1)
    t = rig["STEP"] * np.arange(x.size)
    told = 50.0 - 30.0 * np.cos(2.0 * np.pi * t / 6.0)
    noise = 0.003 * np.random.default_rng(5).standard_normal(x.size)
    log = dehyst.Recording(x, rig["answer"](x, told) + noise, t, schedules={"housing": told})
    scheduled = dehyst.identify(log).model
    plain = dehyst.identify(replace(log, schedules={}, schedule_units={})).model
    way = np.concatenate(
        [np.linspace(a, b, 200, endpoint=False) for a, b in ((0, 1), (1, -1), (-1, 1))]
    )
    clock = rig["STEP"] * np.arange(way.size)
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    panels = figure.subplots(1, 3, sharey=True)
    for panel, temperature in zip(panels, (25.0, 50.0, 75.0), strict=True):
        loop = slice(200, None)
        true = rig["answer"](way, np.full(way.size, temperature))
        told_model = scheduled.simulate(way, clock, housing=temperature)
        panel.plot(way[loop], true[loop], color=GREY, lw=5.0, alpha=0.5, label="rig")
        panel.plot(
            way[loop], plain.simulate(way, clock)[loop], color=ORANGE, lw=1.4, label="without"
        )
        panel.plot(way[loop], told_model[loop], color=BLUE, lw=1.4, label="with the temperature")
        panel.set(title=f"{temperature:.0f} °C", xlabel="drive [V]")
    panels[0].set_ylabel("stroke [mm]")
    panels[0].legend(loc="upper left", fontsize=9)
    return figure


def resonance() -> Figure:
    """Triangles of an actuator of plays that rings at 25 Hz: as it answers, and as with a shaped reference."""
    time = 0.001 * np.arange(5000)
    swing = 2.0 * np.pi * 25.0
    stage = TransferFunction([swing**2], [1.0, 2.0 * 0.02 * swing, swing**2])
    loop = dehyst.PrandtlIshlinskii([0.0, 0.2, 0.5], [1.0, 0.4, 0.2])

    def answered(x: Array) -> Array:
        return np.asarray(lsim(stage, loop.simulate(x), time)[1])

    corners = np.arange(0.0, 5.01, 0.25)
    tips = 0.8 * np.random.default_rng(4).uniform(-1.0, 1.0, corners.size)
    tips[0] = 0.0
    x = np.interp(time, corners, tips)
    fit = dehyst.identify(dehyst.Recording(x, answered(x), time))
    wanted = np.clip(0.6 * (4.0 * np.abs((time / 0.2 + 0.25) % 1.0 - 0.5) - 1.0), -0.6, 0.6)
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    shown = (time > 1.0) & (time < 1.4)
    left.plot(time[shown], wanted[shown], color=GREY, lw=4.0, alpha=0.5, label="wanted")
    for reference, color, label in (
        (wanted, ORANGE, "as it is"),
        (fit.model.shaped(wanted, time), BLUE, "shaped"),
    ):
        y = answered(fit.model.inverse().simulate(reference, time))
        left.plot(time[shown], y[shown], color=color, lw=1.2, label=label)
        right.plot(time[shown], (y - wanted)[shown], color=color, lw=1.2)
    left.set(xlabel="time [s]", ylabel="travel [mm]")
    right.set(xlabel="time [s]", ylabel="error [mm]")
    left.legend(loc="upper right", fontsize=9)
    return figure


def integrator() -> Figure:
    """What the integrator has left to do beside a compensator, from the committed run of benchmarks/integrator.py."""
    found = json.loads(INTEGRATOR.read_text(encoding="utf-8"))
    figure = Figure(figsize=(9.6, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    for (plant, figures), line in zip(found.items(), ("-", "--", ":"), strict=False):
        for name, colour, label in (("off", GREY, "without"), ("on", BLUE, "with compensator")):
            gains = [g for g in figures[name]["gains"] if g["gain"] > 0]
            x, y = [g["gain"] for g in gains], [g["rms_deg"] for g in gains]
            left.loglog(x, y, line, color=colour, lw=1.8, label=f"{label}, {plant}")
            torque = np.array(figures[name]["drift"]["torque_Nm"])
            right.plot(2.0 * np.arange(torque.size), torque - torque[0], line, color=colour, lw=1.8)
    left.set(title="Slow trial", xlabel="gain of the integrator", ylabel="rms error [deg]")
    right.set(title="Three minutes of rest", xlabel="time [s]", ylabel="change of its torque [Nm]")
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def learning() -> Figure:
    """What examples/learn_to_reach.py leaves of the distance from the target, round by round: a minute."""
    with contextlib.redirect_stdout(io.StringIO()):
        errors = runpy.run_path(str(ROOT / "examples" / "learn_to_reach.py"))["learn"]()
    figure = Figure(figsize=(5.6, 2.6), layout="constrained")
    axes = figure.subplots()
    axes.plot(errors, color=BLUE, marker="o", ms=4)
    axes.set(
        title="Distance from the target",
        xlabel="round of 24 tries",
        ylabel="mean [deg]",
        ylim=(0, 12),
    )
    for k, value in ((0, errors[0]), (len(errors) - 1, errors[-1])):
        axes.annotate(f"{value:.1f}", (k, value), (4, 6), textcoords="offset points", color=INK)
    return figure


def numbers_of_a_loop() -> Figure:
    """The largest loop of the example log with the numbers that `dehyst loops` prints, where they are measured."""
    figure = Figure(figsize=(9.6, 5.0), layout="constrained")
    dehyst.plot(measure_loops(example_recording()), figure.subplots())
    return figure


def linearise_a_sensor() -> Figure:
    """The load cell of the how-to before and after its correction, with the figures that `dehyst sensor` prints."""
    cell = runpy.run_path(str(ROOT / "examples" / "simulators" / "load_cell.py"))
    x = cell["calibration"]()
    warm = 25.0 - 12.0 * np.cos(4.0 * np.pi * np.linspace(0.0, 1.0, x.size))
    reading = cell["reading"](x, warm) + 1e-4 * np.random.default_rng(5).standard_normal(x.size)
    log = dehyst.Recording(
        reading,
        cell["CAPACITY"] * x,
        cell["STEP"] * np.arange(x.size),
        input_name="bridge",
        output_name="force",
        input_unit="mV/V",
        output_unit="N",
        schedules={"body": warm},
    )
    model = dehyst.identify(log).model
    # Of a log made in Python nothing says which part a model was fitted to: its first half.
    held_out = replace(log, left_out=tuple(range(len(log) // 2)))
    corrected = replace(
        held_out, input=model.simulate(reading, log.time, body=warm), input_unit="N"
    )
    figure = Figure(figsize=(12.0, 4.6), layout="constrained")
    before, after = figure.subplots(1, 2)
    dehyst.plot(sensor_data_sheet(held_out), before)
    dehyst.plot(sensor_data_sheet(corrected, "ideal"), after)
    for axes, title in ((before, "bridge"), (after, "corrected")):
        axes.set_title(f"{title}: deviation [% FS]", loc="left")
    return figure


def butterfly_loops() -> Figure:
    """The butterfly of the how-to with its model, and what its inverse makes of a reference on the upper wing."""
    rig = runpy.run_path(str(ROOT / "examples" / "simulators" / "butterfly.py"))
    time, field = rig["drive"]()
    strain = rig["ferroelectric"](field)
    model = dehyst.identify(dehyst.Recording(field, strain, time)).model
    figure = Figure(figsize=(12.0, 4.6), layout="constrained")
    loop, wing = figure.subplots(1, 2)
    held_out = slice(time.size // 2, None)
    loop.plot(field[held_out], strain[held_out], lw=2.4, label="log, held out")
    loop.plot(field[held_out], model.simulate(field)[held_out], color=INK, lw=0.8, label="model")
    loop.set_xlabel("field [kV/mm]")
    loop.set_ylabel("strain [%]")
    clock = np.arange(0.0, 10.0, rig["STEP"])
    tips = [0.12, 0.08, 0.12, 0.09, 0.11, 0.1, 0.12, 0.08, 0.1, 0.09, 0.12]
    wanted = np.interp(clock, np.arange(11), tips)
    poling = rig["TOP"] * np.sin(np.linspace(0.0, 2.5 * np.pi, 300))
    poled = model.wing("upper").after_strokes(rig["TOP"], rising=False)
    for inverse, words in (
        (poled, "with the inverse"),
        (poled.without_memory, "with the curve of the wing"),
    ):
        applied = np.append(poling, inverse.inverse().simulate(wanted))
        wing.plot(clock, rig["ferroelectric"](applied)[poling.size :], lw=1.2, label=words)
    wing.plot(clock, wanted, color=INK, lw=0.8, ls="--", label="wanted")
    wing.set_xlabel("time [s]")
    wing.set_ylim(bottom=0.06)
    for axes in (loop, wing):
        axes.legend(loc="lower left")
    return figure


FIGURES: dict[str, Callable[[], Figure]] = {
    "arm": arm,
    "numbers-of-a-loop": numbers_of_a_loop,
    "linearise-a-sensor": linearise_a_sensor,
    "butterfly-loops": butterfly_loops,
    "loop": loop,
    "play": play,
    "misprint": misprint,
    "families": families,
    "creep": creep,
    "stack": stack,
    "excitation": excitation,
    "backlash": backlash,
    "valves": valves,
    "magnetic-cores": magnetic_cores,
    "battery-voltage": battery_voltage,
    "another-signal": another_signal,
    "resonance": resonance,
    "speed": speed_over_operators,
    "bouc-wen": bouc_wen.figure,
    "which-model": which_model.figure,
    "families-in-the-controller": families_in_controller.figure,
    "rivals": rivals.figure,
    "learning": learning,
} | model_figures.figures()
if INTEGRATOR.exists():
    FIGURES["integrator"] = integrator
if not speed.RESULT.exists():
    del FIGURES["speed"]
WITH_PNG = {"arm"}
