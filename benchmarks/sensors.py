"""Sensors whose physics is no model of the house: which way from the reading to the quantity errs least.

python benchmarks/sensors.py               # the table of docs/decisions/0068; some minutes
python benchmarks/sensors.py --json
python benchmarks/sensors.py --quick       # two sensors

Each sensor is logged as in a calibration: five cycles of two speeds over the whole range, with holds. It is tested on
five logs of use that no model saw: random partial strokes and holds. Two ways lead from the reading to the quantity:

forward    identify(reading -> quantity), the model itself
inverse    identify(quantity -> reading), the inverse of the model

each with `purpose` compensate (the default) and simulate; beside them the best straight line of the calibration.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import dehyst
from dehyst.errors import InvertibilityError

Array = npt.NDArray[np.float64]
STEP = 0.2  # [s]
COLD, WARM = 10.0, 40.0  # degC


class Log(NamedTuple):
    """Quantity (0 to 1) and temperature over time."""

    quantity: Array
    temperature: Array


def strokes(tips: Array, seconds: Array, holds: Array) -> Array:
    """From tip to tip, each in its time, with a hold behind it."""
    parts = []
    for (begin, end), stroke, hold in zip(pairwise(tips.tolist()), seconds, holds, strict=True):
        parts.append(np.linspace(begin, end, max(4, round(stroke / STEP)), endpoint=False))
        parts.append(np.full(round(hold / STEP), end))
    return np.concatenate(parts)


def calibration(count: int = 5) -> Log:
    """Cycles of the whole range at two speeds, with holds at both ends, while the room warms up and cools down."""
    tips = np.tile([0.0, 1.0], count + 1)[: 2 * count + 1]
    seconds = np.where(np.arange(2 * count) % 4 < 2, 50.0, 20.0)
    holds = np.where(np.arange(2 * count) % 2 == 0, 60.0, 30.0)
    inner = strokes(
        np.array([0.0, 0.8, 0.2, 0.6, 0.4, 0.0]), np.full(5, 25.0), np.array([0.0, 20, 0, 20, 20])
    )
    quantity = np.concatenate([strokes(tips, seconds, holds), inner])
    turn = np.linspace(0.0, 2.0 * np.pi, quantity.size)
    return Log(quantity, 25.0 - 13.0 * np.cos(turn))


def use(seed: int) -> Log:
    """Random strokes at random speeds, some with a hold, at temperatures that drift."""
    random = np.random.default_rng(seed)
    tips = np.concatenate([[0.0], random.uniform(0.0, 1.0, 40), [0.0]])
    way = np.abs(np.diff(tips))
    seconds = way * random.uniform(15.0, 60.0, way.size) + 1.0
    holds = random.choice([0.0, 0.0, 10.0, 40.0], way.size)
    quantity = strokes(tips, seconds, holds)
    turn = np.linspace(0.0, 4.0, quantity.size)
    return Log(quantity, 25.0 + 12.0 * np.sin(turn + random.uniform(0.0, 6.0)))


def after(moves: Array, kernel: Array) -> Array:
    """What every move has led to, each by a kernel over time: a convolution."""
    size = 2 * moves.size
    together = np.fft.irfft(np.fft.rfft(moves, size) * np.fft.rfft(kernel, size), size)
    return np.asarray(together[: moves.size])


def relays(x: Array, centre: float, spread: float, width: float, seed: int) -> Array:
    """Mean of 400 relays whose centres and widths are drawn: from 0 up to 1."""
    random = np.random.default_rng(seed)
    middle = random.normal(centre, spread, 400)
    half = np.abs(random.normal(width, 0.6 * width, 400))
    state = np.zeros(400)
    values = np.empty(x.size)
    for k, value in enumerate(x.tolist()):
        state = np.where(value > middle + half, 1.0, np.where(value < middle - half, 0.0, state))
        values[k] = state.mean()
    return values


def moves_of(q: Array) -> Array:
    """Steps from sample to sample."""
    return np.diff(q, prepend=q[0])


def load_cell(log: Log) -> Array:
    """Strain gauges: creep by the logarithm of time, a narrow loop of relays, a cubic, temperature. [mV/V]"""
    q, warm = log.quantity, log.temperature - 25.0
    clock = STEP * np.arange(q.size)
    creep = after(moves_of(q), 0.0004 * np.log1p(clock / 0.5))
    loop = 0.006 * (relays(q, 0.5, 0.3, 0.08, 1) - q)
    bent = 0.004 * q * (1.0 - q) * (1.6 - q)
    return 2.0 * ((1.0 + 2e-4 * warm) * (q + bent) + creep + loop + 5e-5 * warm) + 0.02


def soft(log: Log) -> Array:
    """Conductive rubber: resistance falls along a power law, relaxes by a power of time, with a wide loop. [kOhm]"""
    q = log.quantity
    clock = STEP * (np.arange(q.size) + 0.5)
    relaxed = after(moves_of(q), 0.12 * (clock / 10.0) ** -0.2)
    loop = relays(q, 0.45, 0.35, 0.15, 2)
    pressed = 0.7 * q + 0.2 * loop + relaxed
    return np.asarray(12.0 / (1.0 + 3.0 * np.maximum(pressed, 0.0) ** 0.8))


def torque(log: Log) -> Array:
    """A shaft with dry friction in its coupling, by Dahl's equation, and a soft end stop. [V]"""
    q = log.quantity
    friction = np.zeros(q.size)
    for k, move in enumerate(np.diff(q).tolist(), start=1):
        grip = friction[k - 1]
        friction[k] = grip + move / 0.05 * (1.0 - grip * np.sign(move)) ** 1.5
        friction[k] = min(1.0, max(-1.0, friction[k]))
    return np.asarray(10.0 * (q + 0.04 * q**3 + 0.012 * friction) - 5.0)


def thermistor(log: Log) -> Array:
    """Falls with the exponential of the quantity, behind a skin that is 2 s late; its glass has a loop. [kOhm]"""
    q = log.quantity
    late = np.empty(q.size)
    state = q[0]
    for k, value in enumerate(q.tolist()):
        state += STEP / 2.0 * (value - state)
        late[k] = state
    glass = 0.01 * relays(late, 0.5, 0.3, 0.1, 3)
    return np.asarray(10.0 * np.exp(-2.2 * (late - glass)))


def magnetic(log: Log) -> Array:
    """Field through a core with a wide loop of relays that saturates, and a gain that falls with temperature. [V]"""
    q, warm = log.quantity, log.temperature - 25.0
    core = relays(q, 0.5, 0.25, 0.05, 4)
    return np.asarray((1.0 - 0.002 * warm) * (1.5 * np.tanh(1.4 * (q - 0.5)) + 0.6 * core))


class Sensor(NamedTuple):
    """How it reads, its noise as a share of the range, and whether its temperature is logged."""

    read: Callable[[Log], Array]
    noise: float
    warm: bool


SENSORS = {
    "load cell": Sensor(load_cell, 5e-5, True),
    "soft sensor": Sensor(soft, 1e-3, False),
    "torque sensor": Sensor(torque, 3e-4, False),
    "thermistor": Sensor(thermistor, 3e-4, False),
    "magnetic": Sensor(magnetic, 5e-4, True),
}
WAYS = ("forward", "inverse")
SEEDS = (7, 8, 9, 10, 11)  # of logs of use
PURPOSES = ("compensate", "simulate")


def logged(name: str, log: Log, seed: int) -> tuple[Array, Array, dict[str, Array]]:
    """Reading with its noise, quantity and signals of a log."""
    sensor = SENSORS[name]
    reading = sensor.read(log)
    noise = (
        sensor.noise
        * float(np.ptp(reading))
        * np.random.default_rng(seed).normal(size=reading.size)
    )
    signals = {}
    if sensor.warm:
        signals["temperature"] = log.temperature
    return reading + noise, log.quantity, signals


def straight(reading: Array, quantity: Array, read: Array) -> Array:
    """Quantity by the best straight line of the calibration, least squares."""
    return np.asarray(np.polyval(np.polyfit(reading, quantity, 1), read))


def measured(name: str) -> dict[str, float | str]:
    """Errors of all ways on the log of use, rms in percent of the quantity's range."""
    reading, quantity, signals = logged(name, calibration(), 1)
    clock = STEP * np.arange(reading.size)
    row: dict[str, float | str] = {}
    errors = []
    for seed in SEEDS:
        read, true, _ = logged(name, use(seed), seed)
        errors.append(rms(straight(reading, quantity, read) - true))
    row["line"] = float(np.mean(errors))
    for way in WAYS:
        pair = reading, quantity
        if way == "inverse":
            pair = quantity, reading
        for purpose in PURPOSES:
            recording = dehyst.Recording(*pair, clock, schedules=signals)
            fit = dehyst.identify(recording, purpose=purpose)
            row[f"{way}, {purpose} family"] = f"{fit.family} {fit.direction}"
            row[f"{way}, {purpose}"] = float("nan")
            model = fit.model
            if way == "inverse":
                try:
                    model = model.inverse()
                except InvertibilityError:
                    continue
            errors = []
            for seed in SEEDS:
                read, true, later = logged(name, use(seed), seed)
                needed = {need: later[need] for need in model.needs}
                estimate = model.simulate(read, STEP * np.arange(read.size), **needed)
                errors.append(rms(estimate - true))
            row[f"{way}, {purpose}"] = float(np.mean(errors))
    return row


def rms(error: Array) -> float:
    """Root mean square in percent of the range, which is 1."""
    return 100.0 * float(np.sqrt(np.mean(error**2)))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    names = list(SENSORS)
    if options.quick:
        names = names[:2]
    rows = {}
    for name in names:
        rows[name] = measured(name)
        if not options.json:
            print(name)
            for key, value in rows[name].items():
                print(f"    {key:28} {value if isinstance(value, str) else format(value, '.3f')}")
    if options.json:
        print(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
