"""Butterfly loops: error of the model on what was held out, and tracking of its inverse on one wing.

    python benchmarks/butterflies.py            # the table of docs/how-to/butterfly-loops.md; about a minute
    python benchmarks/butterflies.py --compare  # with the best family of `dehyst compare` too; some minutes more
    python benchmarks/butterflies.py --elsewhere  # whether a log of the zoo of other rigs is taken for a butterfly

No rig is of the family: relays (Preisach) and a rod after Jiles and Atherton (examples/simulators/butterfly.py), a
Bouc-Wen state, and relays that switch late. What `auto` took before it knew butterflies stands in the table of the fit:
the best sum of elements, or plays. On the wing the actuator is poled by two strokes, and then follows triangles and
smaller turns between 50 and 95 % of the wing; beside it stands the same model without memory, the curve of the wing.
"""

from __future__ import annotations

import argparse
import runpy
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
from zoo.logs import recording
from zoo.rigs import RIGS as ZOO

import dehyst
from dehyst.families.kit import butterfly_in

Array = npt.NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[1]
SIMULATOR = runpy.run_path(str(ROOT / "examples" / "simulators" / "butterfly.py"))
STEP, TOP = SIMULATOR["STEP"], SIMULATOR["TOP"]
ferroelectric, rod = SIMULATOR["ferroelectric"], SIMULATOR["rod"]


def bouc_wen(field: Array) -> Array:
    """|x - 0.8 z|^1.6 of a Bouc-Wen state z, in small steps."""
    z, last = 0.0, 0.0
    y = np.empty(field.size)
    for k, value in enumerate((field / TOP).tolist()):
        change = (value - last) / 20.0
        for _ in range(20):
            z += change * (1.0 - (0.5 + 0.5 * np.sign(change * z)) * abs(2.5 * z) ** 1.5)
        last = value
        y[k] = abs(value - 0.8 * z) ** 1.6
    return y


def late(field: Array) -> Array:
    """Relays whose strain comes 20 ms late."""
    y = ferroelectric(field)
    share = 1.0 - np.exp(-STEP / 0.02)
    for k in range(1, y.size):
        y[k] = y[k - 1] + share * (y[k] - y[k - 1])
    return y


# Physics, noise of the log [% of range].
RIGS: dict[str, tuple[Callable[[Array], Array], float]] = {
    "ferroelectric": (ferroelectric, 0.3),
    "with imprint, unequal wings": (lambda x: ferroelectric(x, 0.6, 0.3, 0.2, 0.45), 1.0),
    "rod": (lambda x: rod(x, bias=0.0), 0.2),
    "rod with a bias": (lambda x: rod(x, bias=0.35), 0.5),
    "Bouc-Wen": (bouc_wen, 0.3),
    "relays, 20 ms late": (late, 0.3),
}


def logged(name: str, seed: int = 1) -> dehyst.Recording:
    """The log of a rig."""
    physics, noise = RIGS[name]
    time, field = SIMULATOR["drive"]()
    strain = physics(field)
    strain += np.random.default_rng(seed).normal(0.0, 0.01 * noise * np.ptp(strain), strain.size)
    return dehyst.Recording(field, strain, time, input_name="field", output_name="strain")


def tracked(physics: Callable[[Array], Array], model: dehyst.Model) -> tuple[float, float]:
    """Error on the upper wing with its inverse, and with the curve of the wing; percent of the log's output range."""
    wing = model.wing("upper")
    turn, end = wing.card.output.low, wing.card.output.high
    if model.after_map[1][0] < model.after_map[1][model.turn]:
        turn, end = end, turn
    tips = turn + (end - turn) * np.array(
        [0.95, 0.5, 0.95, 0.6, 0.8, 0.7, 0.9, 0.5, 0.75, 0.6, 0.95]
    )
    wanted = np.interp(np.arange(0.0, 10.0, STEP), np.arange(tips.size), tips)
    poling = TOP * np.sin(np.linspace(0.0, 2.5 * np.pi, 400))
    errors = []
    for one in (wing.after_strokes(TOP, rising=False), wing.without_memory):
        demand = np.clip(one.inverse().simulate(wanted), -TOP, TOP)
        came = np.linspace(TOP, demand[0], 50)
        strain = physics(np.concatenate([poling, came, demand]))[-demand.size :]
        span = 0.01 * (model.card.output.high - model.card.output.low)
        errors.append(float(np.sqrt(np.mean((strain - wanted) ** 2))) / span)
    return errors[0], errors[1]


def best_compared(log: dehyst.Recording) -> str:
    """The best family of `dehyst compare` beside the butterfly, and its error on what was held out."""
    best, least = "", float("inf")
    for entry in dehyst.compare(log).entries:
        if entry.family != "butterfly" and entry.error_percent < least:
            best, least = entry.family, entry.error_percent
    return f"{least:.2f} ({best})"


def seen_elsewhere() -> list[str]:
    """Rigs of the zoo whose usual log is taken for a butterfly."""
    seen = []
    for name, rig in ZOO.items():
        log = recording(rig, "usual")
        part = slice(0, len(log) // 2)
        scaled = []
        for signal in (log.input[part], log.output[part]):
            scaled.append(2.0 * (signal - signal.min()) / np.ptp(signal) - 1.0)
        if butterfly_in([(scaled[0], scaled[1])]) is not None:
            seen.append(name)
    return seen


def main() -> int:
    """Print the table; 1 if a butterfly is not seen, or errs by more than 4 % of range."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--compare", action="store_true")
    parser.add_argument("--elsewhere", action="store_true", help="only look at the rigs of the zoo")
    options = parser.parse_args()
    if options.elsewhere:
        seen = seen_elsewhere()
        print(
            f"butterflies in {len(seen)} of {len(ZOO)} logs of the zoo: {', '.join(seen) or 'none'}"
        )
        return int(bool(seen))
    heads = [
        "rig",
        "noise",
        "butterfly",
        "auto before",
        "best curve",
        "inverse",
        "curve of the wing",
    ]
    if options.compare:
        heads.append("best other family")
    print("| " + " | ".join(heads) + " |\n" + "|---" * len(heads) + "|")
    bad = 0
    for name, (physics, noise) in RIGS.items():
        log = logged(name)
        fit = dehyst.identify(log)
        error = fit.output_error.rmse_percent
        bad += fit.family != "butterfly" or error > 4.0
        before = fit.table[1]
        curve = min(row.test_percent for row in fit.table if row.family == "static")
        cells = [
            name,
            f"{noise:g}",
            f"{error:.2f}",
            f"{before.test_percent:.1f} ({before.family})",
            f"{curve:.1f}",
        ]
        if fit.family == "butterfly":
            cells += [f"{error:.2f}" for error in tracked(physics, fit.model)]
        if options.compare:
            cells.append(best_compared(log))
        print("| " + " | ".join(cells) + " |", flush=True)
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
