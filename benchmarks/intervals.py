"""How often 95 % intervals of `Fit.interval` hold what they should, on generated logs.

python benchmarks/intervals.py [--logs 200] [--kinds pi-white,...] [--json FILE]

Each log is 2000 samples of 25 random strokes between -2 and 2 that reach both ends. The truth is the model of the same
family from a log nine times as long without noise: the generating model itself where it is of that family. Counted
are predictions of strokes that were never logged (60 places), demands of the inverse along them (60), and width and
slope of the largest loop. The table of docs/decisions/0069-intervals.md.
"""

from __future__ import annotations

import argparse
import json
import time as clock
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import dehyst
from dehyst import Recording
from dehyst.families import example
from dehyst.models import Model

Array = npt.NDArray[np.float64]
STEP = 0.01  # s
SIZE, LONG = 2000, 9
THRESHOLDS, WEIGHTS = (0.0, 0.1, 0.3, 0.6, 1.0), (1.0, 0.5, 0.4, 0.3, 0.2)
# Strokes to both ends, behind which the memory is known, then others.
SETTLED = (0.0, 2.0, -2.0, 2.0)
PROBE = (-1.0, 1.2, 0.2)
PLACES = 60


@dataclass(frozen=True)
class Kind:
    """What makes a log, and what is fitted to it; `noise` is a share of the output's range."""

    mechanism: str
    family: str
    noise: float
    kept: float = 0.0  # correlation of the noise from one sample to the next
    size: int = SIZE


KINDS = {
    "pi, white noise": Kind("plays", "pi", 0.01),
    "pi, noise that lasts 20 samples": Kind("plays", "pi", 0.01, 0.905),
    "pi, noise that lasts 100 samples": Kind("plays", "pi", 0.01, 0.98),
    "pi, 300 samples, white noise": Kind("plays", "pi", 0.01, 0.0, 300),
    "pi, Bouc-Wen rig, white noise": Kind("bouc-wen", "pi", 0.01),
    "pi, Preisach rig, noise that lasts": Kind("preisach", "pi", 0.005, 0.905),
    "modified-pi, plays, white noise": Kind("plays", "modified-pi", 0.01),
    "creep-pi, plays, white noise": Kind("plays", "creep-pi", 0.01),
    "creep-pi, plays, noise that lasts": Kind("plays", "creep-pi", 0.01, 0.905),
    "play-sum, Bouc-Wen rig, white noise": Kind("bouc-wen", "play-sum", 0.01),
    "generalised-pi, Preisach rig, noise that lasts": Kind(
        "preisach", "generalised-pi", 0.005, 0.905
    ),
    "full-sum, Bouc-Wen rig, white noise": Kind("bouc-wen", "full-sum", 0.01),
}


def strokes(tips: npt.ArrayLike, size: int) -> Array:
    """About `size` samples of strokes at one speed that reach each tip."""
    turns = np.asarray(tips, dtype=np.float64)
    ways = np.abs(np.diff(turns))
    parts = [turns[:1]]
    for begin, end, way in zip(turns[:-1], turns[1:], ways, strict=True):
        samples = max(2, round(size * float(way / ways.sum())))
        parts.append(begin + (end - begin) * np.arange(1, samples + 1) / samples)
    return np.concatenate(parts)


def motion(random: np.random.Generator, size: int, times: int = 1) -> Array:
    """Both ends and 23 random strokes, a number of times."""
    tips = [0.0]
    for _ in range(times):
        tips += [2.0, -2.0, *random.uniform(-2.0, 2.0, 23)]
    return strokes(tips, size)


def mechanism_of(name: str) -> Any:
    """A model with the range -2 to 2."""
    if name == "plays":
        return dehyst.PrandtlIshlinskii(THRESHOLDS, WEIGHTS)
    model: Any = example(name)
    return replace(model, scaling=replace(model.scaling, half_range=2.0))


def noise_of(random: np.random.Generator, size: int, kept: float) -> Array:
    """Noise of deviation 1 whose correlation falls by the factor `kept` a sample."""
    white = random.normal(size=size)
    noise = np.empty(size)
    last = white[0]
    for k in range(size):
        last = kept * last + np.sqrt(1.0 - kept**2) * white[k] if k else white[0]
        noise[k] = last
    return noise


def probe() -> tuple[Array, Array, npt.NDArray[np.int64]]:
    """Strokes that were never logged, time, and the places that count."""
    before = strokes(SETTLED, 550)
    x = np.concatenate([before, strokes([SETTLED[-1], *PROBE], 350)[1:]])
    places = np.linspace(before.size, x.size - 1, PLACES).round().astype(np.int64)
    return x, STEP * np.arange(x.size), places


def figures(x: Array, time: Array, places: npt.NDArray[np.int64], reference: Array) -> Any:
    """What is computed of each model."""

    def compute(model: Model) -> Array:
        y = model.simulate(x, time)
        loop = strokes([2.0, -2.0, 2.0, -2.0, 2.0], 160)
        answer = model.simulate(loop, STEP * np.arange(loop.size))
        width = float(answer[100] - answer[140])
        slope = float(np.ptp(answer[80:]) / 4.0)
        demand = model.inverse().simulate(reference, time)
        return np.concatenate([y[places], demand[places], [width, slope]])

    return compute


def measured(kind: Kind, logs: int) -> dict[str, Any]:
    """Shares of the intervals that hold the truth."""
    rig = mechanism_of(kind.mechanism)
    x, time, places = probe()
    reference = rig.simulate(x, time)
    compute = figures(x, time, places, reference)
    settings: dict[str, Any] = {"train_fraction": 1.0}
    if kind.family in ("pi", "modified-pi"):
        settings |= {"n": 20, "initial_state": "zero"}
    far = motion(np.random.default_rng(99), LONG * SIZE, LONG)
    far_time = STEP * np.arange(far.size)
    long = Recording(far, rig.simulate(far, far_time), far_time)
    truth = compute(dehyst.identify(long, kind.family, **settings).model)
    held, widths, misses, seconds, blocks = [], [], [], [], []
    for number in range(logs):
        random = np.random.default_rng(number)
        u = motion(random, kind.size)
        stamps = STEP * np.arange(u.size)
        y = rig.simulate(u, stamps)
        y = y + kind.noise * np.ptp(y) * noise_of(random, u.size, kind.kept)
        fit = dehyst.identify(Recording(u, y, stamps), kind.family, **settings)
        begun = clock.perf_counter()
        assert fit.draws is not None
        seconds.append(clock.perf_counter() - begun)
        interval = fit.interval(compute)
        held.append((truth >= interval.low) & (truth <= interval.high))
        widths.append(interval.high - interval.low)
        misses.append(np.abs(interval.value - truth))
        blocks.append(fit.draws.blocks)
    shares = np.mean(held, axis=0)
    return {
        "predictions": float(shares[:PLACES].mean()),
        "least_prediction": float(shares[:PLACES].min()),
        "inverse": float(shares[PLACES:-2].mean()),
        "width": float(shares[-2]),
        "slope": float(shares[-1]),
        "half_width": float(np.mean([w[:PLACES] for w in widths]) / 2.0 / np.ptp(reference)),
        "miss": float(np.mean([m[:PLACES] for m in misses]) / np.ptp(reference)),
        "blocks": float(np.median(blocks)),
        "milliseconds": 1e3 * float(np.median(seconds)),
    }


def main() -> None:
    """Print a row of each kind."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--logs", type=int, default=200)
    parser.add_argument("--kinds", default="")
    parser.add_argument("--json", type=Path)
    request = parser.parse_args()
    results = {}
    print(
        "| logs | predictions | least place | inverse | width | slope | half width, miss [% of range] | blocks | ms |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for name, kind in KINDS.items():
        if request.kinds and not any(word in name for word in request.kinds.split(";")):
            continue
        row = measured(kind, request.logs)
        results[name] = row
        print(
            f"| {name} | {row['predictions']:.3f} | {row['least_prediction']:.2f} | {row['inverse']:.3f} | "
            f"{row['width']:.3f} | {row['slope']:.3f} | {100 * row['half_width']:.2f}, {100 * row['miss']:.2f} | "
            f"{row['blocks']:.0f} | {row['milliseconds']:.0f} |",
            flush=True,
        )
    if request.json is not None:
        request.json.write_text(
            json.dumps({"logs": request.logs, "kinds": results}, indent=1) + "\n"
        )


if __name__ == "__main__":
    main()
