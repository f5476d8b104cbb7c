"""What follows 150 known samples: error of a model that runs on after them, and of the model as it was saved.

python benchmarks/known_past.py [--motions 20] [--known 150]

Random strokes of examples of families, without noise. Errors are rms over what follows, shares of the output's range;
medians over the motions. The table of docs/decisions/0067-a-past-that-is-known.md.
"""

from __future__ import annotations

import argparse
import time as clock
from itertools import pairwise
from statistics import median

import numpy as np
import numpy.typing as npt

import dehyst
from dehyst.families import example
from dehyst.models import Model, ModelCard, SignalCard

Array = npt.NDArray[np.float64]
STEP = 0.01  # s
CARD = ModelCard(SignalCard("u", low=-1.0, high=1.0), SignalCard("y", low=-1.0, high=1.0))
FAMILIES = (
    "play-sum", "preisach", "dahl", "bouc-wen", "duhem", "full-sum", "inverse-stop-rate", "creep-pi",
)  # fmt: skip


def models() -> dict[str, Model]:
    """Ten plays, and the example of each family."""
    plays = dehyst.PrandtlIshlinskii(np.linspace(0.0, 0.9, 10), np.full(10, 0.1), card=CARD)
    named: dict[str, Model] = {"ten plays": plays}
    for name in FAMILIES:
        named[name] = example(name)
    return named


def motion(seed: int, size: float) -> Array:
    """Thirty random strokes."""
    tips = np.concatenate([[0.0], np.random.default_rng(seed).uniform(-1.0, 1.0, 30)])
    parts = []
    for begin, end in pairwise(tips.tolist()):
        samples = max(3, int(40 * abs(end - begin)))
        parts.append(size * np.linspace(begin, end, samples, endpoint=False))
    return np.concatenate(parts)


def errors(model: Model, seed: int, known: int) -> tuple[float, float, float]:
    """Errors of what follows, known and as saved, and the seconds that the search took."""
    x = motion(seed, model.ends[1])
    stamps = STEP * np.arange(x.size) if model.rate_dependent else None
    y = model.simulate(x, stamps)
    first = int(np.random.default_rng(seed).integers(200, x.size - 2 * known))
    past, rest = slice(first, first + known), slice(first + known, None)
    begun = clock.perf_counter()
    after = model.after(x[past], y[past], None if stamps is None else stamps[past])
    seconds = clock.perf_counter() - begun
    misses = []
    for each in (after, model):
        answer = each.simulate(x[rest], None if stamps is None else stamps[rest])
        misses.append(float(np.sqrt(np.mean((answer - y[rest]) ** 2)) / np.ptp(y)))
    return misses[0], misses[1], seconds


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--motions", type=int, default=20)
    parser.add_argument("--known", type=int, default=150, help="samples")
    options = parser.parse_args()
    print("| model | known past | as saved | s each |\n|---|---|---|---|")
    for name, model in models().items():
        rows = [errors(model, seed, options.known) for seed in range(options.motions)]
        known, saved, seconds = (median(column) for column in zip(*rows, strict=True))
        print(f"| {name} | {known:.1g} | {saved:.2g} | {seconds:.2f} |")


if __name__ == "__main__":
    main()
