"""Rigs that ring: tracking of the default choice with its resonance, and with `--resonance none`.

python benchmarks/resonances.py

The table of docs/decisions/0070-resonance.md; some minutes.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt
from zoo.logs import designed, smooth
from zoo.rigs import RIGS, Rig

import dehyst
from dehyst.identification import Fit
from dehyst.models import kit as models_kit

Array = npt.NDArray[np.float64]
MECHANISMS = {  # rig of the zoo, frequency of what it moves [Hz], damping
    "stack": (60.0, 0.03),
    "solenoid": (45.0, 0.05),
    "finger": (1.6, 0.08),
    "tendon": (4.0, 0.04),
    "bowden": (5.0, 0.05),
    "stage": (12.0, 0.03),
    "muscles": (2.5, 0.15),
    "wire": (0.4, 0.1),
}
OWN = ("piezo",)  # rings by itself, at 800 Hz
QUIET = ("walls", "landau", "flag", "gear", "spool", "wax")  # and some that do not
SCANS = {
    "at the log's speed": 0.5,
    "five times as fast": 5.0,
}  # of a triangle, over that of a stroke of the log
STROKES = 12
INSIDE = (0.25, 0.75)


def swung(y: Array, frequency: float, damping: float, period: float) -> Array:
    """Answer of an oscillator to an output (T,) on a line between samples, exact, from rest at its first sample."""
    w = 2.0 * np.pi * frequency
    pole = w * complex(-damping, np.sqrt(1.0 - damping**2))
    decay = np.exp(pole * period)
    # A ramp of slope v is followed 2 zeta v/w behind, and each change of slope starts a swing.
    late = 2.0 * damping / w
    gain = complex(late, (1.0 - 2.0 * damping**2) / pole.imag)
    z, last, slope = 0j, float(y[0]), 0.0
    answer = np.empty(y.size)
    for k, value in enumerate(y.tolist()):
        new = (value - last) / period
        z = (z + (new - slope)) * decay
        answer[k] = value - late * new + (gain * z).real
        last, slope = value, new
    return answer


def played(rig: Rig, u: Array) -> Array:
    """True output of a rig and of what it moves."""
    y = rig.play(u)
    if rig.name not in MECHANISMS:
        return y
    return swung(y, *MECHANISMS[rig.name], rig.period)


def logs(rig: Rig) -> Iterator[tuple[str, Array]]:
    """Inputs of two logs: what design plans, and triangles as people log them."""
    yield "designed", designed(rig, "usual")
    sizes = np.random.default_rng(1).uniform(0.2, 1.0, 24)
    half = round(rig.stroke / rig.period)
    low, span = rig.low, rig.high - rig.low
    parts = [np.full(half // 2, low + 0.5 * span)]
    at = float(parts[0][-1])
    for number, size in enumerate(sizes.tolist()):
        tip = low + 0.5 * span * (1.0 + (size if number % 2 else -size))
        count = max(4, round(half * abs(tip - at) / span))
        parts.append(np.linspace(at, tip, count + 1)[1:])
        parts.append(np.full(half // 4, tip))
        at = tip
    yield "triangles and rests", np.concatenate(parts)


def scan(rig: Rig, low: float, high: float, speed: float, first: float) -> tuple[Array, int]:
    """A reference of triangles, and where they begin."""
    half = max(8, round(rig.stroke / rig.period * (INSIDE[1] - INSIDE[0]) / speed))
    bottom, top = (low + (high - low) * share for share in INSIDE)
    approach = smooth(first, bottom, round(rig.stroke / rig.period))
    stroke = bottom + (top - bottom) * np.arange(1, half + 1) / half
    triangles = np.concatenate([stroke, stroke[::-1]] * (STROKES // 2))
    return np.concatenate([np.full(8, first), approach, triangles]), 8 + approach.size


def missed(rig: Rig, fit: Fit, log: Array, wanted: Array, begin: int) -> tuple[float, float]:
    """Errors of the compensator with its resonance and without, percent of the range of the log's output."""
    time, errors = rig.period * np.arange(wanted.size), []
    for model in (fit.model, replace(fit.model, resonance=None)):
        shaped = model.shaped(wanted, time)
        inverse = models_kit.begun(model.inverse(), models_kit.DEFAULT, float(shaped[0]))
        demand = model.ahead(inverse.simulate(shaped, time), time)
        # The last stroke is held where the reference is not known any more.
        error = (played(rig, demand) - wanted)[begin : -wanted.size // 20]
        errors.append(100.0 * float(np.sqrt(np.mean(error**2)) / np.ptp(log)))
    return errors[0], errors[1]


def main() -> int:
    """Print the table; 1 if a compensator with its resonance errs more than 1.05 times as much as without."""
    heads = ["rig", "log", "frequency, damping", "identified", *SCANS]
    print("| " + " | ".join(heads) + " |\n|---|---|---|---|---|---|")
    ratios, worst = [], 0.0
    for name in (*OWN, *MECHANISMS, *QUIET):
        rig = RIGS[name]
        for kind, u in logs(rig):
            y = played(rig, u)
            record = dehyst.Recording(u, rig.measured(y, kind), rig.period * np.arange(u.size))
            fit = dehyst.identify(record)
            truth = {**MECHANISMS, "piezo": (800.0, 0.04)}.get(name)
            resonance = fit.model.resonance
            cells = [name, kind, "none", "none"]
            if truth:
                cells[2] = f"{truth[0]:g} Hz, {truth[1]:g}"
            if resonance:
                cells[3] = f"{resonance.frequency:.3g} Hz, {resonance.damping:.2g}"
            for speed in SCANS.values():
                first = float(played(rig, np.full(2, rig.rest))[0])
                wanted, begin = scan(rig, float(y.min()), float(y.max()), speed, first)
                if not resonance:
                    cells.append("")
                    continue
                with_it, without = missed(rig, fit, y, wanted, begin)
                cells.append(f"{without:.2g} -> {with_it:.2g}")
                ratios.append(with_it / without)
                worst = max(worst, ratios[-1])
            print("| " + " | ".join(cells) + " |", flush=True)
    mean = float(np.exp(np.mean(np.log(ratios))))
    print(
        f"\n{mean:.2f} times as much with the resonance as without (geometric mean), at most {worst:.2f}"
    )
    return int(worst > 1.05)


if __name__ == "__main__":
    sys.exit(main())
