"""Actuators that are no model of dehyst, for examples/several_actuators.py: sums of relays, and how to log them."""

import numpy as np

import dehyst

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


def stage(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two axes: each moves the other by a tenth."""
    x = Relays(3, 0.2).play(u) + 0.1 * Relays(5, 0.1).play(v)
    return x, Relays(4, 0.2).play(v) + 0.1 * Relays(6, 0.1).play(u)


def swings(sizes: list[float]) -> np.ndarray:
    """Return a motion from 0 through turning points, 2 s each, still for a second at the end."""
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(1, 201) / 200)
    parts = [a + (b - a) * ramp for a, b in zip([0.0, *sizes[:-1]], sizes, strict=True)]
    return np.concatenate([*parts, np.full(100, sizes[-1])])


def identified(drive: np.ndarray, answer: np.ndarray) -> dehyst.Model:
    """Log with a noisy sensor, identify, return the model."""
    seen = answer + NOISE * np.random.default_rng(0).standard_normal(answer.size)
    return dehyst.identify(dehyst.Recording(input=drive, output=seen, time=PERIOD * np.arange(drive.size))).model


def asked(model: dehyst.Model, wanted: np.ndarray) -> np.ndarray:
    """Return what the model's inverse asks for, from rest."""
    return model.inverse().at_rest(float(wanted[0])).simulate(wanted, PERIOD * np.arange(wanted.size))


def moved(model: dehyst.Model, drive: np.ndarray) -> np.ndarray:
    """Return by how much a drive moves what it acts on, from rest."""
    answer = model.at_rest(float(drive[0])).simulate(drive, PERIOD * np.arange(drive.size))
    return answer - answer[0]


def error(wanted: np.ndarray, got: np.ndarray) -> str:
    """Return the rms error in percent of the range."""
    return f"{100.0 * np.sqrt(np.mean((wanted - got) ** 2)) / np.ptp(wanted):4.1f} %"
