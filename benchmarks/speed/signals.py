"""Inputs of the benchmark: from the kindest to the worst for an evaluator that follows turning points."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

RATE = 2000.0  # [Hz]
PERIOD = 20.0  # [s]
RANGE = 2.0  # the sine runs from -1 to 1


def smooth(samples: int) -> Array:
    """Sine of amplitude 1, 20 s a period, sampled at 2 kHz."""
    return np.sin(2.0 * np.pi / (PERIOD * RATE) * np.arange(samples))


def noisy(samples: int) -> Array:
    """The sine with uniform noise of +-1 % of its range 2, as a sensor gives it."""
    noise = np.random.default_rng(1).uniform(-0.01 * RANGE, 0.01 * RANGE, samples)
    return np.asarray(smooth(samples) + noise)


def white(samples: int) -> Array:
    """Uniform noise over the full range: every sample turns, no branch can be predicted."""
    return np.random.default_rng(2).uniform(-1.0, 1.0, samples)


def walk(samples: int) -> Array:
    """Gaussian random walk scaled to +-1: turning points at every scale."""
    path = np.cumsum(np.random.default_rng(3).standard_normal(samples))
    path -= 0.5 * (path.max() + path.min())
    return np.asarray(path / np.abs(path).max())


def decaying(samples: int, period: int = 2000) -> Array:
    """Triangle of 2000 samples a period whose amplitude runs linearly to 0: as much memory as there can be."""
    phase = np.arange(samples) % period / period
    return np.asarray((1.0 - 4.0 * np.abs(phase - 0.5)) * np.linspace(1.0, 0.0, samples))


SIGNALS: dict[str, Callable[[int], Array]] = {
    "smooth": smooth,
    "noisy": noisy,
    "white": white,
    "walk": walk,
    "decaying": decaying,
}


def operator(n: int) -> tuple[Array, Array]:
    """Thresholds r_i = (i - 1)/n and positive weights (n,) that sum to 1."""
    weights = np.random.default_rng(n).uniform(0.5, 1.5, n)
    return np.arange(n) / n, weights / weights.sum()
