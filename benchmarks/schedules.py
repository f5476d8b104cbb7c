"""Rigs whose loop changes with another signal: held-out error of the default choice without and with `--schedule`.

python benchmarks/schedules.py

The table of docs/decisions/0066-weights-that-go-with-a-signal.md; a minute.
"""

from __future__ import annotations

import runpy
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt

import dehyst

Array = npt.NDArray[np.float64]
STEP, LOW, HIGH = 0.01, 20.0, 80.0
PLAYS = dehyst.PrandtlIshlinskii(np.linspace(0.0, 0.6, 7), np.full(7, 0.15))
WIDE = dehyst.PrandtlIshlinskii([0.25], [1.0])


def recorded(x: Array, y: Array, signal: Array, step: float = STEP) -> dehyst.Recording:
    """A log with its signal."""
    time = step * np.arange(x.size)
    return dehyst.Recording(x, y, time, schedules={"signal": signal})


def strokes(count: int, seed: int) -> Array:
    """Random strokes between -1 and 1."""
    tips = np.concatenate([[0.0, 1.0, -1.0], np.random.default_rng(seed).uniform(-1.0, 1.0, count)])
    parts = []
    for begin, end in pairwise(tips.tolist()):
        parts.append(np.linspace(begin, end, max(3, int(60 * abs(end - begin))), endpoint=False))
    return np.concatenate(parts)


def warm(seed: int, count: int, level: float | None = None) -> dehyst.Recording:
    """Gain, loop and level of plays and stops go with a temperature, each along a curve."""
    x = strokes(count, seed)
    signal = 50.0 + 30.0 * np.sin(2.0 * np.pi * STEP * np.arange(x.size) / 5.0 + seed)
    if level is not None:
        signal = np.full(x.size, level)
    xi = (signal - LOW) / (HIGH - LOW)
    loop = x - WIDE.simulate(x)
    y = (1.0 + 0.5 * xi**1.3) * PLAYS.simulate(x) + 0.4 * (1.0 - xi) * loop + 0.3 * xi
    return recorded(x, y + 0.002 * np.random.default_rng(seed).standard_normal(x.size), signal)


def relays() -> dehyst.Recording:
    """The rig of examples/warm_actuator.py, which warms up and cools down."""
    rig = runpy.run_path(str(Path(__file__).parents[1] / "examples" / "warm_actuator.py"))
    x = rig["strokes"](60, 1)
    signal = 50.0 - 30.0 * np.cos(2.0 * np.pi * STEP * np.arange(x.size) / 6.0)
    noise = 0.003 * np.random.default_rng(5).standard_normal(x.size)
    return recorded(x, rig["answer"](x, signal) + noise, signal)


def dampers() -> Iterator[dehyst.Recording]:
    """A clockwise loop whose force grows sixfold with a voltage, at four voltages."""
    time = np.arange(0.0, 2.0, 0.005)
    x = 1.5 * np.sin(4.0 * np.pi * time) * (1.0 + 0.3 * np.sin(np.pi * time))
    stop = x - dehyst.PrandtlIshlinskii([0.3], [1.0]).simulate(x)
    for number, volt in enumerate((0.0, 0.75, 1.5, 2.25)):
        noise = 2.0 * np.random.default_rng(number).standard_normal(x.size)
        force = (200.0 + 500.0 * volt) * stop / 0.3 + 40.0 * x + noise
        yield recorded(x, force, np.full(x.size, volt), 0.005)


def held_out(records: list[dehyst.Recording]) -> str:
    """Held-out error with and without the signal, percent of range."""
    plain = [replace(record, schedules={}, schedule_units={}) for record in records]
    errors = []
    for logs in (plain, records):
        fit = dehyst.identify(logs)
        errors.append((fit.test or fit.train).rmse_percent)
    return f"{errors[0]:.2g} | {errors[1]:.2g}"


def main() -> None:
    """Print the table."""
    levels = [warm(10 + k, 25, level) for k, level in enumerate((20.0, 40.0, 60.0, 80.0))]
    rigs = {
        "gain, loop and level go with a temperature": [warm(1, 40)],
        "the same, a log at each of four temperatures": levels,
        "relays whose gain, loop and level go with a temperature": [relays()],
        "clockwise loop, six times as large at 2.25 V as at 0 V, four logs": list(dampers()),
    }
    print("| rig | without | with the signal |\n|---|---|---|")
    for name, records in rigs.items():
        print(f"| {name} | {held_out(records)} |")
    between = warm(20, 25, 50.0)
    fit = dehyst.identify(levels)
    error = dehyst.evaluate(fit.model, between)[fit.family].error_percent
    print(f"four temperatures, another log at 50 degC: {error:.2g} % of range")


if __name__ == "__main__":
    main()
