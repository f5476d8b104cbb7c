"""Actuators that are no model of dehyst, for examples/several_actuators.py: sums of relays, and how to log them."""

from collections.abc import Callable

import numpy as np

import dehyst

Rig = Callable[[np.ndarray, np.ndarray], np.ndarray]

PERIOD, NOISE = 0.01, 2e-4  # [s]; of the sensors


class Relays:
    """A Preisach sum of relays: up above one limit, down below another, each at its place of a random plane."""

    def __init__(self, seed: int, width: float) -> None:
        random = np.random.default_rng(seed)
        middle, half = random.normal(0.0, 0.5, 3000), np.abs(random.normal(0.0, width, 3000))
        self.low, self.high = middle - half, middle + half

    def play(self, signal: np.ndarray) -> np.ndarray:
        """Return the answer to a signal from rest."""
        state, answer = np.where(self.low + self.high > 0.0, -1.0, 1.0), np.empty(signal.size)
        for k, x in enumerate(signal):
            state[x > self.high], state[x < self.low] = 1.0, -1.0
            answer[k] = state.mean() + 0.3 * x
        return answer


def stage(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Two axes: each moves the other by a tenth."""
    x = Relays(3, 0.2).play(u) + 0.1 * Relays(5, 0.1).play(v)
    return np.array([x, Relays(4, 0.2).play(v) + 0.1 * Relays(6, 0.1).play(u)])


def muscles(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Two muscles of one joint: the difference of their forces turns it, their sum makes it stiff."""
    first, second = Relays(3, 0.2).play(u), Relays(4, 0.15).play(v)
    return np.array([0.6 * (first - second), 0.4 * (first + second)])


def swings(sizes: list[float]) -> np.ndarray:
    """Return a motion from 0 through turning points, 2 s each, still for a second at the end."""
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(1, 201) / 200)
    parts = [a + (b - a) * ramp for a, b in zip([0.0, *sizes[:-1]], sizes, strict=True)]
    return np.concatenate([*parts, np.full(100, sizes[-1])])


TRAINING = swings([1.0, -1.0, 1.0, -0.6, 0.7, -0.3, 0.4, -0.1, 0.9, -0.9, 0.2, -0.5, 1.0, -1.0, 0.5, 0.0])
SECOND = swings([0.3, 0.8, -0.9, -0.2, -1.0, 1.0, 0.1, 0.6, -0.4, 1.0, -1.0, 0.5, -0.7, 0.2, -0.1, 0.0])
REFERENCE = swings([0.55, -0.5, 0.35, -0.2, 0.3, -0.55, 0.1, 0.4, 0.0])


def logged(rig: Rig) -> dict[str, np.ndarray]:
    """Return the log of a rig while both inputs move."""
    x, y = rig(TRAINING, SECOND) + NOISE * np.random.default_rng(0).standard_normal((2, TRAINING.size))
    return {"time_s": PERIOD * np.arange(x.size), "u_V": TRAINING, "v_V": SECOND, "x_mm": x, "y_mm": y}


def identified(drive: np.ndarray, answer: np.ndarray) -> dehyst.Model:
    """Log with a noisy sensor, identify, return the model."""
    seen = answer + NOISE * np.random.default_rng(0).standard_normal(answer.size)
    return dehyst.identify(dehyst.Recording(input=drive, output=seen, time=PERIOD * np.arange(drive.size))).model


def asked(model: dehyst.Model, wanted: np.ndarray) -> np.ndarray:
    """Return what the model's inverse asks for, from rest."""
    return model.inverse().at_rest(float(wanted[0])).simulate(wanted, PERIOD * np.arange(wanted.size))


def error(wanted: np.ndarray, got: np.ndarray) -> str:
    """Return the rms error in percent of the range."""
    return f"{100.0 * np.sqrt(np.mean((wanted - got) ** 2)) / np.ptp(wanted):4.1f} %"
