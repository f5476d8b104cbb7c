"""Tables of explanation/integrator.md, from the run in benchmarks/results/integrator.json.

python benchmarks/integrator.py
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

RESULT = Path(__file__).resolve().parents[2] / "benchmarks" / "results" / "integrator.json"
TITLES = {"maxwell-slip": "Maxwell slip", "preisach": "Preisach", "dahl": "Dahl"}


@cache
def result() -> dict[str, Any]:
    """The run."""
    found: dict[str, Any] = json.loads(RESULT.read_text(encoding="utf-8"))
    return found


def gains() -> str:
    """Error of the slow trial over the integrator's gain, and the torque of the integrator at gain 1."""
    first = next(iter(result().values()))
    values = [f"{gain['gain']:g}" for gain in first["off"]["gains"]]
    lines = [
        f"| plant | compensator | {' | '.join(values)} | its torque, gain 1 |",
        "|---" * (len(values) + 3) + "|",
    ]
    for plant, figures in result().items():
        for name in ("off", "on"):
            runs = figures[name]["gains"]
            errors = " | ".join(f"{gain['rms_deg']:.3f}" for gain in runs)
            torque = next(gain["work_Nm"] for gain in runs if gain["gain"] == 1.0)
            lines.append(f"| {TITLES[plant]} | {name} | {errors} | {torque:.2f} Nm |")
    return "\n".join(lines)


def at_rest() -> str:
    """Torque of the integrator at rest: at the begin, at the end, and its slope over the last two minutes."""
    columns = [f"{what}, {name}" for what in ("first", "last", "drift") for name in ("off", "on")]
    lines = [f"| plant | {' | '.join(columns)} |", "|---" * (len(columns) + 1) + "|"]
    for plant, figures in result().items():
        drifts = [figures[name]["drift"] for name in ("off", "on")]
        cells = [f"{drift['torque_Nm'][0]:.2f} Nm" for drift in drifts]
        cells += [f"{drift['torque_Nm'][-1]:.2f} Nm" for drift in drifts]
        cells += [f"{1e3 * drift['slope_Nm_s']:.1f} mNm/s" for drift in drifts]
        lines.append(f"| {TITLES[plant]} | {' | '.join(cells)} |")
    return "\n".join(lines)


def observer() -> str:
    """Largest error at rest without integrator, and rms error of the slow trial, with and without the observer."""
    columns = [
        "rest: off",
        "compensator",
        "and observer",
        "slow: compensator",
        "and observer",
        "integrator beside the compensator",
        "all three",
    ]
    lines = [f"| plant | {' | '.join(columns)} |", "|---" * (len(columns) + 1) + "|"]
    for plant, figures in result().items():
        rests = [figures[name]["rest"]["error_deg"] for name in ("off", "on", "observer")]
        cells = [f"{max(map(abs, errors)):.3f}" for errors in rests]
        along = {gain["gain"]: gain["rms_deg"] for gain in figures["on"]["gains"]}
        slow = (
            along[0.0],
            figures["observer"]["rms_deg"],
            along[1.0],
            figures["observer and integrator"]["rms_deg"],
        )
        cells += [f"{error:.3f}" for error in slow]
        lines.append(f"| {TITLES[plant]} | {' | '.join(cells)} |")
    return "\n".join(lines)
