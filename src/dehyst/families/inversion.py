"""Numerical inverse, sample by sample, of every family whose output strictly rises or falls with its input."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from dehyst.arrays import Array

if TYPE_CHECKING:
    from dehyst.families.base import LoopModel

FARTHEST = 64.0  # scaled inputs beyond it are not looked for: 32 times the identified range
TOLERANCE = 1e-12


def search_inputs(model: LoopModel, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
    """Return the scaled inputs (T,) at which the model answers y, and the memory after them.

    A bracket, then regula falsi (Illinois); the output rises with the input, so there is one solution. Where y is out
    of reach the nearest input within 64 half ranges is taken. The search begins from the memory alone: parts of a
    signal give what the whole does, bit for bit.
    """
    x = np.empty(y.size)
    for k in range(y.size):
        step = None if dt is None else dt[k : k + 1]
        now = memory

        def miss(value: float, step: Array | None = step, now: Array = now, wanted: float = float(y[k])) -> float:
            return float(model.run(np.array([value]), step, now)[0][0]) - wanted

        x[k] = _root(miss, 0.0, 0.25)
        memory = model.run(x[k : k + 1], step, memory)[1]
    return x, memory


def first_input(model: LoopModel, y: float) -> float:
    """Return the scaled input at which the model, arriving as its start says, answers y."""

    def miss(value: float) -> float:
        dt = np.zeros(1) if model.rate_dependent else None
        return float(model.run(np.array([value]), dt, model.before(value))[0][0]) - y

    return _root(miss, 0.0, 0.25)


def _root(miss: Callable[[float], float], guess: float, reach: float) -> float:
    """Zero of a rising function near a guess; its end where it has none."""
    low = high = guess
    below = above = miss(guess)
    while below > 0.0 and low > -FARTHEST:
        high, above, low = low, below, max(guess - reach, -FARTHEST)
        below, reach = miss(low), 2.0 * reach
    while above < 0.0 and high < FARTHEST:
        low, below, high = high, above, min(guess + reach, FARTHEST)
        above, reach = miss(high), 2.0 * reach
    if below >= 0.0 or above <= 0.0:
        return low if below >= 0.0 else high
    side = 0
    for _ in range(200):
        if high - low <= TOLERANCE * max(1.0, abs(low), abs(high)):
            break
        middle = (low * above - high * below) / (above - below)
        if not low < middle < high:
            middle = 0.5 * (low + high)
        value = miss(middle)
        if value == 0.0:
            return middle
        if value < 0.0:
            low, below = middle, value
            above, side = (0.5 * above if side < 0 else above), -1
        else:
            high, above = middle, value
            below, side = (0.5 * below if side > 0 else below), 1
    return low if -below < above else high
