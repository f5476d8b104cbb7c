"""Table and figure of explanation/bouc-wen-benchmark.md, from the run that lies in benchmarks/results/bouc_wen.json.

python benchmarks/bouc_wen.py --out benchmarks/results/bouc_wen.json
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

RESULT = Path(__file__).resolve().parents[2] / "benchmarks" / "results" / "bouc_wen.json"
SHOWN = {
    "maxwell-slip": "#8a939e",
    "duhem, polynomial": "#d55e00",
    "duhem, piecewise linear": "#0072b2",
}
UNITS = {
    "mass": "kg", "damping": "N s/m", "stiffness": "N/m", "alpha": "N/m", "beta gamma": "1/m", "beta delta": "1/m"
}  # fmt: skip
TRUTH = {
    "mass": 2,
    "damping": 10,
    "stiffness": 5e4,
    "alpha": 5e4,
    "beta gamma": 800,
    "beta delta": -1100,
}


@cache
def result() -> dict[str, Any]:
    """The run."""
    found: dict[str, Any] = json.loads(RESULT.read_text(encoding="utf-8"))
    return found


def page() -> str:
    """Errors of every model and published ones, then the physical parameters."""
    lines = [
        "| model | kind | parameters | rms error, multisine [m] | rms error, sweep [m] | time [s] |",
        "|---|---|---|---|---|---|",
    ]
    for model in result()["models"]:
        errors = model["rms_error_m"]
        lines.append(
            f"| {model['model']} | {model['kind']} | {model['parameters']} | {errors['multisine']:.2e} "
            f"| {errors['sweep']:.2e} | {model['seconds']:.1f} |"
        )
    lines += ["", "| published | rms error, multisine [m] |", "|---|---|"]
    lines += [
        f"| {name} | {error:.2e} |" for name, error in result()["published_multisine_m"].items()
    ]
    white = result()["models"][-1]
    lines += ["", "| white box | identified | standard error | true |", "|---|---|---|---|"]
    for name, value in white["values"].items():
        error = white["standard_errors"][name]
        lines.append(f"| {name} [{UNITS[name]}] | {value:.7g} | {error:.2g} | {TRUTH[name]:g} |")
    correlation = white["correlation_of_stiffness_and_alpha"]
    lines += ["", f"Correlation of the errors of stiffness and alpha: {correlation:.2f}."]
    return "\n".join(lines)


def figure() -> Figure:
    """The slope of the hysteretic element as each family found it; a loop; errors beside the published ones."""
    drawn = Figure(figsize=(9.6, 3.9), layout="constrained")
    slope, loop, errors = drawn.subplots(1, 3, width_ratios=(1.0, 1.0, 1.25))
    models = {model["model"]: model for model in result()["models"]}
    curves = [("system", result()["system"], "#1b2530", 3.6)]
    curves += [(name, models[name], colour, 1.5) for name, colour in SHOWN.items()]
    for name, found, colour, width in curves:
        if found["slopes"]:
            y = [1e-3 * value for value in found["slopes"]["slope_N_per_m"]]
            slope.plot(
                found["slopes"]["force_N"],
                y,
                color=colour,
                lw=width,
                alpha=0.35 if width > 2 else 1.0,
            )
        closed = [found["loop"][key] + found["loop"][key][:1] for key in ("position_mm", "force_N")]
        loop.plot(*closed, color=colour, lw=width, alpha=0.35 if width > 2 else 1.0, label=name)
    slope.set(
        title="Slope of the loop",
        xlabel="force, along the motion [N]",
        ylabel="dz/dy [N/mm]",
        ylim=(0, 500),
    )
    loop.set(title="Loop at 10 Hz", xlabel="position [mm]", ylabel="spring and element [N]")
    ours = [(model["rms_error_m"]["multisine"], name, "#0072b2") for name, model in models.items()]
    others = [(error, name, "#8a939e") for name, error in result()["published_multisine_m"].items()]
    listed = sorted(ours + others, reverse=True)
    for row, (error, name, colour) in enumerate(listed):
        errors.plot([1e-8, error], [row, row], color=colour, lw=1.0, alpha=0.5)
        errors.plot(error, row, "o", color=colour, ms=5)
        errors.text(
            1.3 * error, row, name.partition(" (")[0], va="center", fontsize=6.5, color=colour
        )
    errors.axvline(result()["noise_m"], color="#1b2530", lw=0.8, ls=":")
    errors.set(title="Multisine test, rms error [m]", xscale="log", xlim=(3e-8, 2e-1), yticks=[])
    drawn.legend(*loop.get_legend_handles_labels(), loc="outside lower left", ncols=4)
    return drawn
