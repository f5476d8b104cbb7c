"""Forty short pieces that begin anywhere: held-out error with and without an estimate of what came before each.

python benchmarks/pieces.py [--pieces 40] [--samples 150]

Rigs that are of no family here: relays with Gaussian centres and half widths (Preisach), and Bouc-Wen with a
hardening spring. A long random motion is cut into pieces; the way of three pieces is lost between two. Half are
fitted. Of the others the first third is known, and the error is that of the rest, percent of the output's range. The
table of docs/decisions/0074-starts-of-pieces.md.
"""

from __future__ import annotations

import argparse
import time as clock
import warnings
from contextlib import nullcontext
from unittest import mock

import numpy as np
import numpy.typing as npt

import dehyst

Array = npt.NDArray[np.float64]
NOISE = 1e-3  # of the range
PLACE = "dehyst.identification._auto.with_starts"


def nothing(*_: object) -> None:
    """Estimate no starts."""


def motion(seed: int, size: int) -> Array:
    """Random strokes of 20 to 60 samples about a centre that wanders: most pieces see a part of the range."""
    rng = np.random.default_rng(seed)
    tips = [0.0]
    samples = [0]
    while samples[-1] < size:
        centre = 0.6 * np.sin(samples[-1] / 700.0)
        tips.append(float(np.clip(centre + rng.normal(0.0, 0.35), -1.0, 1.0)))
        samples.append(samples[-1] + int(rng.integers(20, 60)))
    return np.interp(np.arange(size), samples, tips)


def relays(x: Array, seed: int) -> Array:
    """Sum of 4000 relays."""
    rng = np.random.default_rng(seed)
    centre, half = rng.normal(0.0, 0.4, 4000), np.abs(rng.normal(0.0, 0.3, 4000))
    state = np.where(centre > 0.0, -1.0, 1.0)
    y = np.empty(x.size)
    for k, value in enumerate(x):
        state[value > centre + half] = 1.0
        state[value < centre - half] = -1.0
        y[k] = state.mean()
    return y + 0.2 * x


def bouc_wen(x: Array, seed: int) -> Array:
    """Bouc-Wen with n = 1.5 beside a hardening spring."""
    z, y = 0.0, np.empty(x.size)
    for k in range(x.size):
        move = (x[k] - x[k - 1]) / 20.0 if k else 0.0
        for _ in range(20):
            size = abs(z)
            z += move * 6.0 - 4.0 * abs(move) * size**0.5 * z - 2.0 * move * size**1.5
        y[k] = z + 0.8 * x[k] + 0.5 * x[k] ** 3
    return y


RIGS = {"relays": relays, "Bouc-Wen": bouc_wen}


def pieces_of(
    rig: str, seed: int, count: int, samples: int, noise: float = NOISE
) -> list[dehyst.Recording]:
    """Return the pieces that were logged."""
    x = motion(seed, 4 * count * samples)
    y = RIGS[rig](x, seed)
    y += noise * float(np.ptp(y)) * np.random.default_rng(seed).normal(size=y.size)
    logged = []
    for k in range(count):
        part = slice((4 * k + 3) * samples, (4 * k + 4) * samples)
        logged.append(dehyst.Recording(input=x[part], output=y[part], name=f"{k}"))
    return logged


def error(model: dehyst.Model, logged: list[dehyst.Recording]) -> float:
    """Error of what follows the first third of each piece, percent of the range of all of them."""
    misses = []
    for piece in logged:
        first = len(piece) // 3
        after = model.after(piece.input[:first], piece.output[:first])
        misses.append(after.simulate(piece.input[first:]) - piece.output[first:])
    height = np.ptp(np.concatenate([piece.output for piece in logged]))
    return 100.0 * float(np.sqrt(np.mean(np.concatenate(misses) ** 2)) / height)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--pieces", type=int, default=40)
    parser.add_argument("--samples", type=int, default=150)
    parser.add_argument("--seeds", type=int, default=3)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    print("| rig | seed | without | s | with starts | s | starts |\n|---|---|---|---|---|---|---|")
    for rig in RIGS:
        for seed in range(options.seeds):
            logged = pieces_of(rig, seed, options.pieces, options.samples)
            cells = [rig, str(seed)]
            for without in (True, False):
                begun = clock.perf_counter()
                with mock.patch(PLACE, nothing) if without else nullcontext():
                    fit = dehyst.identify(logged[::2], train_fraction=1.0)
                seconds = clock.perf_counter() - begun
                cells += [f"{error(fit.model, logged[1::2]):.2f} ({fit.family})", f"{seconds:.1f}"]
            cells.append(str(fit.settings.get("starts", 0)))
            print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
