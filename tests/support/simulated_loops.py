"""Simulated loops: valves of examples/simulators/valve_loop.py, a servo with a reference, a core, an electrode."""

import functools
import itertools
import runpy

import numpy as np

from places import ROOT

RECORDS = slice(200, None)  # the loop has come to its swing


@functools.cache
def simulator():
    """Return the names of the example."""
    return runpy.run_path(str(ROOT / "examples" / "simulators" / "valve_loop.py"))


def valve_loop(process="flow", valve="kano", **changes):
    """Return columns of a simulated loop after its start; of a test in manual all."""
    names = simulator()
    columns = names["Loop"](names["PROCESSES"][process], valve, **changes).run()
    if "manual" in changes:
        return columns
    return {name: values[RECORDS] for name, values in columns.items()}


def servo_log(noise=0.1, closed=True, samples=3000, proportional=0.3, integral=0.02):
    """Return columns of a servo with a dead band, in closed loop, or with a command that was planned before."""
    rng = np.random.default_rng(0)
    time = 0.01 * np.arange(samples)
    reference = 4.0 * np.sin(0.8 * time) + np.sin(2.1 * time)
    command, measured = np.empty(samples), np.empty(samples)
    u = total = position = 0.0
    for k in range(samples):
        position = min(max(position, u - 0.5), u + 0.5)
        command[k], measured[k] = u, position + noise * rng.normal()
        if closed:
            error = reference[k] - measured[k]
            total += integral * error
            u = proportional * error + total
        else:
            u = reference[k]
    return {
        "time_s": time,
        "reference_mm": reference,
        "command_V": command,
        "measured_mm": measured,
    }


def core_loop(samples=200, top=200.0):
    """Columns of two cycles of a core: a curve that saturates, run through later the way back."""
    field = top * np.sin(np.linspace(0.0, 4.0 * np.pi, samples))
    late = field - 12.0 * np.sign(np.cos(np.linspace(0.0, 4.0 * np.pi, samples))) * (
        1.0 - (field / top) ** 2
    )
    density = 0.4 * np.tanh(late / 50.0)
    return {"time_s": 1e-5 * np.arange(samples), "H [A/m]": field, "B [T]": density}


def open_circuit(rate=40.0, turns=(0.0, 1.0, 0.0, 0.6, 0.3, 0.6)):
    """Columns of charge and voltage of an electrode whose hysteresis has one state of this decay rate."""
    parts = [np.linspace(a, b, 150, endpoint=False) for a, b in itertools.pairwise(turns)]
    x, state = np.concatenate(parts), -1.0
    voltage = np.empty(x.size)
    for k in range(x.size):
        move = x[k] - x[k - 1] if k else 0.0
        side = -np.sign(move) or -1.0
        state = side + (state - side) * np.exp(-0.5 * rate * abs(move))
        voltage[k] = 0.5 - 0.4 * x[k] + 0.05 * state * np.sin(np.pi * x[k])
    return {"charge [Ah]": 2.0 * x, "voltage [V]": voltage}


class RelaySum:
    """A sum of relays, which is no sum of plays: each is up above one limit and down below another."""

    def __init__(self, seed, width, relays=300):
        rng = np.random.default_rng(seed)
        middle, half = rng.normal(0.0, 0.6, relays), np.abs(rng.normal(0.0, width, relays))
        self.low, self.high = middle - half, middle + half

    def play(self, x):
        """Return the answer to a signal from rest, (T,)."""
        state = np.where(x[0] > 0.5 * (self.low + self.high), 1.0, -1.0)
        answer = np.empty(x.size)
        for k, value in enumerate(x):
            state[value > self.high], state[value < self.low] = 1.0, -1.0
            answer[k] = state.mean() + 0.5 * value
        return answer


def two_axes(u, v, coupling=0.1, sign=1.0):
    """Return both outputs of a stage of relays, (2, T): each axis moves the other by a share."""
    x = RelaySum(1, 0.2).play(u) + coupling * RelaySum(2, 0.1).play(v)
    y = RelaySum(3, 0.2).play(v) + sign * coupling * RelaySum(4, 0.1).play(u)
    return np.array([x, y])


def wandering(seed, samples=3000, period=0.01):
    """Return a motion of several sines within -1 to 1, (T,)."""
    rng = np.random.default_rng(seed)
    time = period * np.arange(samples)
    frequency, phase = rng.uniform(0.1, 0.6, 4), rng.uniform(0.0, 6.0, 4)
    x = np.sin(2.0 * np.pi * time[:, None] * frequency + phase).sum(axis=1)
    return x / np.max(np.abs(x))


@functools.cache
def stage_log(samples=3000, coupling=0.1, sign=1.0, noise=1e-3):
    """Return columns of a stage of relays while both inputs move."""
    u, v = wandering(1, samples), wandering(2, samples)
    x, y = two_axes(u, v, coupling, sign) + noise * np.random.default_rng(0).normal(
        size=(2, samples)
    )
    return {
        "time_s": 0.01 * np.arange(samples),
        "a_V": 75.0 + 75.0 * u,
        "b_V": 75.0 + 75.0 * v,
        "x_um": 10.0 * x,
        "y_um": 8.0 * y,
    }
