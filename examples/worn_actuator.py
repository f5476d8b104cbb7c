"""Logs of an actuator that wears, to try `dehyst drift` on.

    python examples/worn_actuator.py

writes new.csv (the actuator as it was identified), month_1.csv, month_2.csv, month_3.csv (from the third on its
hysteresis is 12 % smaller) and cycling.csv (490 cycles, in which it loses 20 %). Noise remembers: it is a first-order
process, correlated from sample to sample.
"""

import itertools

import numpy as np

import dehyst
from dehyst.io import write_csv

RATE, PERIOD = 20.0, 4.0  # samples a second; length of a cycle [s]
RADII = np.linspace(0.0, 1.2, 9)  # of the plays [bar]
SLIP = np.r_[0.0, np.full(8, 0.6)]  # of each stop [deg/bar]; what wears


def drive(random: np.random.Generator, cycles: int) -> np.ndarray:
    """Pressure of uneven cycles, every third of them half as large. [bar]"""
    size = 2.0 * (1.0 + 0.03 * random.standard_normal(2 * cycles + 2))
    size[4::6] *= 0.5
    size[5::6] *= 0.5
    size[:2] = 2.1
    tips = size * np.where(np.arange(size.size) % 2, -1.0, 1.0)
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(1, round(RATE * PERIOD / 2) + 1) / round(RATE * PERIOD / 2))
    return np.concatenate([a + (b - a) * ramp for a, b in itertools.pairwise([0.0, *tips])])


def write(name: str, seed: int, cycles: int, first: float, last: float) -> None:
    """Write a log in which the hysteresis goes from one share of its size to another."""
    random = np.random.default_rng(seed)
    pressure = drive(random, cycles)
    curve = 7.0 * pressure
    whole = dehyst.PrandtlIshlinskii(RADII, np.r_[7.0, -SLIP[1:]]).simulate(pressure)  # 7 x less the plays' share
    loop = (whole - curve) + np.sum(SLIP) * pressure  # the stops
    noise = np.empty(pressure.size)
    value = 0.0
    for k, fresh in enumerate(random.standard_normal(pressure.size)):
        value = 0.9 * value + 0.03 * np.sqrt(1.0 - 0.9**2) * fresh
        noise[k] = value
    angle = curve - np.linspace(first, last, pressure.size) * loop + noise
    write_csv(name, {"time_s": np.arange(pressure.size) / RATE, "pressure_bar": pressure, "angle_deg": angle})


if __name__ == "__main__":
    write("new.csv", 0, 24, 1.0, 1.0)
    for month, share in enumerate((1.0, 1.0, 0.88), start=1):
        write(f"month_{month}.csv", month, 24, share, share)
    write("cycling.csv", 9, 490, 1.0, 0.8)
    print("wrote new.csv, month_1.csv, month_2.csv, month_3.csv, cycling.csv")
