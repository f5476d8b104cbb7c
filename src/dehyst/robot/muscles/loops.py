"""Slow cycles: force over contraction at constant pressure, contraction over pressure at constant load."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.robot.muscles.base import Memory, MuscleModel
from dehyst.robot.muscles.force_map import TOLERANCE, free_contraction

STROKE = 120  # samples of a stroke of a loop


@dataclass(frozen=True, eq=False)
class Loop:
    """One closed cycle of a slow motion, the memory spent by the cycle before it.

    Attributes
    ----------
    held
        What was constant: the pressure [Pa] or the load [N].
    drive, response
        (T,) contraction and force [N] of an isobaric loop, pressure [Pa] and contraction of an isotonic one; up first.
    time
        (T,) [s], or None if it was infinitely slow.
    width
        Largest distance of the two branches. [response]
    width_percent
        The same in percent of the response's range.
    asymmetry_percent
        How much more of the loop's area lies over the upper half of the drive than over the lower: 0 for a loop that
        looks the same turned by half a turn, 100 if all of it does, negative if the lower half has more.
    """

    held: float
    drive: Array
    response: Array
    time: Array | None
    width: float
    width_percent: float
    asymmetry_percent: float


def isobaric_loop(
    model: MuscleModel, pressure: float, low: float, high: float, *, period: float | None = None, cycles: int = 2
) -> Loop:
    """Return the force over a contraction that goes to and fro at constant speed while the pressure is held.

    Parameters
    ----------
    model
        Any muscle model.
    pressure
        Held. [Pa]
    low, high
        Contractions between which it moves; it starts at rest at the first.
    period
        Of a cycle; None: infinitely slow, so that only hysteresis shows. [s]
    cycles
        Of which the last one is returned.

    Raises
    ------
    ParameterError
        If the contractions are not in order or outside the model's limits.

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
    >>> loop = isobaric_loop(muscle("tondu-lopez"), 3e5, 0.02, 0.2)
    >>> loop.width > 0
    True
    """
    _insist(low < high, f"the contraction cannot go from {low:g} to {high:g}: the first must be the lower one.")
    drive, time = _strokes(low, high, period, cycles)
    force = model.simulate(drive, np.full(drive.size, float(pressure)), time)
    return _last_cycle(pressure, drive, force, time)


def isotonic_loop(
    model: MuscleModel, load: float, low: float, high: float, *, period: float | None = None, cycles: int = 2
) -> Loop:
    """Return the contraction over a pressure that goes up and down while the muscle carries a constant load.

    At each sample the contraction is solved for which the force, friction included, is the load.

    Parameters
    ----------
    model
        Any muscle model.
    load
        Held. [N]
    low, high
        Pressures between which it goes. [Pa]
    period, cycles
        As for `isobaric_loop`.

    Raises
    ------
    ParameterError
        If the pressures are not in order, or no contraction within the model's limits carries the load.

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
    >>> loop = isotonic_loop(muscle("tondu-lopez"), 150.0, 1e5, 5e5)
    >>> bool(np.ptp(loop.response) > 0.01)
    True
    """
    _insist(low < high, f"the pressure cannot go from {low:g} to {high:g} Pa: the first must be the lower one.")
    drive, time = _strokes(low, high, period, cycles)
    start = free_contraction(model, low, load)
    if math.isnan(start):
        start = balance(model, model.rest(0.0), 0.0, low, math.nan, load)
    memory, found = model.rest(start, math.nan if time is None else float(time[0])), [start]
    for i in range(1, drive.size):
        p, t = float(drive[i]), math.nan if time is None else float(time[i])
        found.append(balance(model, memory, found[-1], p, t, load))
        _, memory = model.run([found[-1]], [p], None if time is None else [t], memory)
    return _last_cycle(load, drive, np.array(found), time)


def balance(model: MuscleModel, memory: Memory, near: float, pressure: float, time: float, load: float) -> float:
    """Return the contraction, close to one, at which the force after moving there is the load."""

    def left(k: float) -> float:
        return model.force_after(memory, k, pressure, time) - load

    first = left(near)
    if first == 0.0:
        return near
    low, high = model.limits
    step, last = math.copysign(1e-4, first), near
    while True:
        k = min(max(last + step, low), high)
        if (left(k) > 0) != (first > 0):
            return float(brentq(left, *sorted((last, k)), xtol=TOLERANCE))
        if k in (low, high):
            raise ParameterError(
                f"no contraction from {low:.3g} to {high:.3g} carries {load:.4g} N at {pressure / 1e5:.3g} bar: "
                f"{model.name} gives {left(k) + load:.4g} N at {k:.3g}. Take a smaller load, or a higher pressure.",
                load=load,
                pressure=pressure,
            )
        last, step = k, 2.0 * step


def _strokes(low: float, high: float, period: float | None, cycles: int) -> tuple[Array, Array | None]:
    """Drive and time of cycles of two strokes, `STROKE` samples each and one."""
    _insist((period is None or period > 0) and cycles >= 1, f"a period of {period} s and {cycles} cycles are no loop.")
    stroke = np.linspace(0.0, 1.0, STROKE + 1)
    share = np.concatenate([np.zeros(1), *([stroke[1:], stroke[-2::-1]] * cycles)])
    time = None if period is None else np.linspace(0.0, period * cycles, share.size)
    return low + (high - low) * share, time


def _last_cycle(held: float, drive: Array, response: Array, time: Array | None) -> Loop:
    x, y = (each[-2 * STROKE - 1 :] for each in (drive, response))
    t = None if time is None else time[: x.size]
    up, down = y[: STROKE + 1], y[: STROKE - 1 : -1]  # both over the same values of the drive
    span = float(np.ptp(y))
    width = float(np.max(np.abs(up - down)))
    gap = np.abs(up - down)
    lower, upper = float(gap[: STROKE // 2].sum()), float(gap[STROKE // 2 + 1 :].sum())
    tilt = 100.0 * (upper - lower) / (upper + lower) if width > 1e-9 * span else 0.0
    return Loop(float(held), x, y, t, width, 100.0 * width / span if span > 0 else 0.0, tilt)


def _insist(holds: bool, message: str) -> None:
    if not holds:
        raise ParameterError(message)
