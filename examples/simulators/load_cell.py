"""A stand-in for a load cell on a calibration rig: writes a log of its reading and the true force.

    python examples/simulators/load_cell.py calibration.csv   # twelve cycles with holds; the room warms and cools
    python examples/simulators/load_cell.py use.csv --use     # random loads, as in use

Its span and zero go with temperature. It creeps with the logarithm of time, has a narrow loop, and bends like a cubic.
"""

import argparse
from itertools import pairwise

import numpy as np

CAPACITY = 500.0  # N
RATED = 2.0  # mV/V
STEP = 0.4  # s


def strokes(tips, seconds, holds):
    """From tip to tip, each in its time, with a hold behind it."""
    parts = []
    for (a, b), stroke, hold in zip(pairwise(tips), seconds, holds, strict=True):
        parts.append(np.linspace(a, b, max(4, round(stroke / STEP)), endpoint=False))
        parts.append(np.full(round(hold / STEP), b))
    return np.concatenate(parts)


def calibration():
    """Twelve cycles over the whole range at two speeds, with holds at both ends, and partial ones between them."""
    tips, seconds, holds = [0.0], [], []
    for cycle in range(12):
        tips += [1.0, 0.0]
        seconds += [25.0 + 25.0 * (cycle % 2)] * 2
        holds += [60.0, 30.0]
        if cycle % 3 == 1:
            tips += [0.8, 0.2, 0.6, 0.0]
            seconds += [25.0] * 4
            holds += [0.0, 20.0, 0.0, 30.0]
    return strokes(tips, seconds, holds)


def use(seed):
    """Once over the whole range, as a cell is exercised; then random loads at random speeds, some of them held."""
    random = np.random.default_rng(seed)
    tips = np.concatenate([[0.0, 1.0, 0.0], random.uniform(0.0, 1.0, 30), [0.0]])
    seconds = 1.0 + np.abs(np.diff(tips)) * random.uniform(15.0, 60.0, tips.size - 1)
    return strokes(tips, seconds, random.choice([0.0, 0.0, 10.0, 40.0], seconds.size))


def relays(x, count=400):
    """Mean of relays whose centres and widths are spread: a narrow loop that is no sum of plays."""
    random = np.random.default_rng(1)
    middle = random.normal(0.5, 0.3, count)
    half = np.abs(random.normal(0.08, 0.05, count))
    state = np.zeros(count)
    values = []
    for value in x:
        state = np.where(value > middle + half, 1.0, np.where(value < middle - half, 0.0, state))
        values.append(state.mean())
    return np.array(values)


def reading(x, temperature):
    """What the cell reads under a share of its capacity while it has a temperature. [mV/V]"""
    clock = STEP * np.arange(x.size)
    kernel = 0.0004 * np.log1p(clock / 0.5)
    creep = np.convolve(np.diff(x, prepend=x[0]), kernel)[: x.size]
    bent = x + 0.004 * x * (1.0 - x) * (1.6 - x)
    loop = 0.006 * (relays(x) - x)
    warm = temperature - 25.0
    return RATED * ((1.0 + 2e-4 * warm) * bent + creep + loop + 5e-5 * warm) + 0.02


def main():
    """Write the log that was asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log")
    parser.add_argument("--use", action="store_true", help="random loads instead of a calibration")
    options = parser.parse_args()
    x, swings = calibration(), 2.0
    if options.use:
        x, swings = use(3), 0.8
    temperature = 25.0 - 12.0 * np.cos(2.0 * np.pi * swings * np.linspace(0.0, 1.0, x.size))
    y = reading(x, temperature) + 1e-4 * np.random.default_rng(5).standard_normal(x.size)
    table = np.column_stack([STEP * np.arange(x.size), CAPACITY * x, y, temperature])
    np.savetxt(
        options.log, table, delimiter=",", comments="", fmt="%.7g",
        header="time_s,force_N,bridge [mV/V],body_degC",
    )  # fmt: skip
    print(
        f"{options.log}: {x.size} samples, 0 to {CAPACITY:g} N, {temperature.min():.0f} to {temperature.max():.0f} degC"
    )


if __name__ == "__main__":
    main()
