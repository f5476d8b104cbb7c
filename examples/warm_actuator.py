"""A stand-in for a rig whose loop changes with its temperature: writes a log, to try `--schedule` with.

    python examples/warm_actuator.py warming.csv               # the housing warms up and cools down during the log
    python examples/warm_actuator.py hot.csv --at 50           # at one temperature, another motion

From 20 to 80 degC the gain grows by half along a curve, a part of the loop goes, and the output is shifted.
"""

import argparse
from itertools import pairwise

import numpy as np

LOW, HIGH = 20.0, 80.0  # degC
STEP = 0.01  # s


def strokes(count, seed):
    """Random strokes between -1 and 1 V."""
    tips = np.concatenate([[0.0, 1.0, -1.0], np.random.default_rng(seed).uniform(-1.0, 1.0, count)])
    parts = [np.linspace(a, b, max(3, int(60 * abs(b - a))), endpoint=False) for a, b in pairwise(tips)]
    return np.concatenate(parts)


def relays(x, width, count=200):
    """Mean of relays that switch up to `width` apart: a loop that is no sum of plays."""
    up = np.linspace(-1.0, 1.0, count)
    state = np.where(up < x[0], 1.0, -1.0)
    values = []
    for value in x:
        state = np.where(value > up + 0.5 * width, 1.0, np.where(value < up - 0.5 * width, -1.0, state))
        values.append(state.mean())
    return np.array(values)


def answer(x, temperature):
    """The stroke for a voltage while the housing has a temperature. [mm]"""
    xi = (temperature - LOW) / (HIGH - LOW)
    return (1.0 + 0.5 * xi**1.3) * (0.6 * x + 0.4 * relays(x, 0.4)) + 0.35 * (1.0 - xi) * relays(x, 0.5) + 0.3 * xi


def main():
    """Write the log that was asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log")
    parser.add_argument("--at", type=float, help="temperature [degC]; without it the housing warms up and cools down")
    options = parser.parse_args()
    x = strokes(60, 1 if options.at is None else 2)
    t = STEP * np.arange(x.size)
    temperature = 50.0 - 30.0 * np.cos(2.0 * np.pi * t / 6.0)
    if options.at is not None:
        temperature = np.full(x.size, options.at)
    y = answer(x, temperature) + 0.003 * np.random.default_rng(5).standard_normal(x.size)
    table = np.column_stack([t, x, y, temperature])
    np.savetxt(
        options.log, table, delimiter=",", comments="", fmt="%.6g",
        header="time_s,drive_V,stroke_mm,housing_degC",
    )  # fmt: skip
    print(f"{options.log}: {x.size} samples at {temperature.min():.0f} to {temperature.max():.0f} degC")


if __name__ == "__main__":
    main()
