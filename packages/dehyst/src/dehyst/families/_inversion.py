"""Numerical inverse, sample by sample, of every family whose output strictly rises or falls with its input."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from dehyst.arrays import Array

if TYPE_CHECKING:
    from dehyst.families._base import LoopModel

FARTHEST = 64.0  # scaled inputs beyond it are not looked for: 32 times the identified range
TOLERANCE = 1e-12


def search_inputs(
    model: LoopModel, y: Array, dt: Array | None, memory: Array
) -> tuple[Array, Array]:
    """Return the scaled inputs (T,) at which the model answers y, and the memory after them.

    A bracket, then regula falsi (Illinois); the output rises with the input, so there is one solution. Where y is out
    of reach the nearest input within 64 half ranges is taken. The search begins from the memory alone: parts of a
    signal give what the whole does, bit for bit.
    """
    x = np.empty(y.size)
    for k in range(y.size):
        step = None
        if dt is not None:
            step = dt[k : k + 1]
        miss = partial(_miss, model, step, memory, float(y[k]))
        x[k] = _root(miss, 0.0, 0.25)
        memory = model.run(x[k : k + 1], step, memory)[1]
    return x, memory


def _miss(
    model: LoopModel,
    step: Array | None,
    memory: Array,
    target: float,
    value: float,
    **more: Array,
) -> float:
    """Return how far the answer to an input lies above a target."""
    return float(model.run(np.array([value]), step, memory, **more)[0][0]) - target


def first_input(model: LoopModel, y: float, **more: Array) -> float:
    """Return the scaled input at which the model, arriving as its start says, answers y.

    `more` is what `run` takes beside input and steps of time; its first row counts.
    """
    first = {name: values[:1] for name, values in more.items()}

    dt = np.zeros(1) if model.rate_dependent else None

    def miss(value: float) -> float:
        return _miss(model, dt, model.before(value, **first), y, value, **first)

    return _root(miss, 0.0, 0.25)


def _root(miss: Callable[[float], float], guess: float, reach: float) -> float:
    """Return the zero of a rising function near a guess; the end of the search where there is no zero."""
    low = high = guess
    below = above = miss(guess)
    while below > 0.0 and low > -FARTHEST:
        high, above, low = low, below, max(guess - reach, -FARTHEST)
        below, reach = miss(low), 2.0 * reach
    while above < 0.0 and high < FARTHEST:
        low, below, high = high, above, min(guess + reach, FARTHEST)
        above, reach = miss(high), 2.0 * reach
    if below >= 0.0:
        return low
    if above <= 0.0:
        return high
    side = 0
    # Regula falsi; an end that stays twice in a row counts half, which keeps the steps from becoming small (Illinois).
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
            if side < 0:
                above *= 0.5
            side = -1
        else:
            high, above = middle, value
            if side > 0:
                below *= 0.5
            side = 1
    return low if -below < above else high
