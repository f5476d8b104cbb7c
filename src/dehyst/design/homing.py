"""Shortest homing: the motion after which the memory of a bank of stops is known, or known and spent.

A stop of radius r holds E = x - z, |E| <= r, where z moves with z <- max(x - r, min(x + r, z)). Nobody knows z before
the first motion: every z in [x - r, x + r] is admissible.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.design.homing_search import admissible, spending
from dehyst.design.strokes import Limits
from dehyst.errors import ParameterError


@dataclass(frozen=True, eq=False)
class Homing:
    """A motion that homes a bank of stops, and what it guarantees.

    Attributes
    ----------
    points
        (K + 1,) start, tips, end. [unit]
    stroke_s
        (K,) shortest smooth strokes within the limits. [s]
    half_width
        Guaranteed: half the interval of sum_i s_i E_i afterwards, over all admissible states before. [output]
    residual
        Guaranteed: largest sum_i s_i |E_i| afterwards, over all admissible states before. [output]
    bound_s
        No motion of its kind over the searched amplitudes that keeps the tolerance takes less time. [s]

    Examples
    --------
    >>> homing = shortest_homing([0.1, 0.3, 0.5], -1.0, 1.0, Limits(1.0), tolerance=0.05)
    >>> homing.residual <= 0.05, homing.bound_s <= homing.duration, round(homing.travel, 1)
    (True, True, 2.5)
    """

    points: Array
    stroke_s: Array
    half_width: float
    residual: float
    bound_s: float

    @property
    def travel(self) -> float:
        """Way of all strokes. [unit]"""
        return float(np.abs(np.diff(self.points)).sum())

    @property
    def duration(self) -> float:
        """Time of all strokes. [s]"""
        return float(self.stroke_s.sum())


def shortest_homing(
    radii: npt.ArrayLike,
    low: float,
    high: float,
    limits: Limits,
    *,
    weights: npt.ArrayLike | None = None,
    tolerance: float = 0.05,
    start: float | None = None,
    end: float | None = None,
    spent: bool = True,
) -> Homing:
    r"""Return the shortest motion after which a bank of stops is known to a tolerance, from any state before.

    Known (``spent=False``). After any motion of span S the interval of the output of the bank is

    .. math:: \sum_i s_i \max(0, 2 r_i - S)

    wide, whatever its path: only the span counts. So the shortest motion is the shortest of the span S* that makes
    this twice the tolerance: one stroke of length S* <= 2 r_max if there is room for it on one side, else a short one
    to the other side before. Neither can be beaten: a motion that goes a up and b down, a + b = S*, travels
    a + b + min(a, b) at least. One full stroke over 2 r_max makes every stop of radius <= r_max known.

    Known and spent (``spent=True``), for a compensator that begins at zero: the motion decays, tips at
    e +- a_1, a_2, ... around the end e, a_1 > a_2 > ... > 0, so that the last stroke that moved a stop left it at
    E = +-(a_k - r) with the tip a_k nearest to its radius (or 0, the end). What remains is

    .. math:: \sum_i s_i |E_i| = \sum_i s_i \min_k |r_i - a_k|

    a median problem on a line, with the strokes' time as the price of a tip. It is solved by dynamic programming over
    amplitudes (the radii and a grid) and what is left of the tolerance, in 400 levels: rounded up for the motion,
    rounded down for ``bound_s``. The first tip only serves to make the memory known, so it is then made as short as
    the tolerance allows.

    Parameters
    ----------
    radii
        Of the stops r_i > 0, (n,). [unit]
    low, high
        Range that the motion may use. [unit]
    limits
        Of rate and acceleration. [unit/s, unit/s^2]
    weights
        s_i >= 0, (n,). [output/unit] None: equal shares of one, s_i = 1/(n r_i).
    tolerance
        Largest ``half_width``, and with ``spent`` largest ``residual``, > 0. [output] With weights of None: the share
        of all that the bank can hold.
    start, end
        Where the motion begins, and with ``spent`` ends; None: the middle. [unit]
    spent
        Whether what remains must be small too.

    Returns
    -------
    homing : Homing

    Raises
    ------
    ParameterError
        If a value makes no sense, or the range is too small for the tolerance: the message says what it allows.

    Examples
    --------
    >>> once = shortest_homing([0.1, 0.5], -1.0, 1.0, Limits(1.0), tolerance=1e-9, spent=False)
    >>> once.points.round(6).tolist(), once.half_width < 1e-9
    ([0.0, 1.0], True)
    >>> spent = shortest_homing([0.1, 0.5], -1.0, 1.0, Limits(1.0), tolerance=0.01)
    >>> spent.points.round(2).tolist(), round(spent.residual, 3)
    ([0.0, 0.49, -0.49, 0.1, 0.0], 0.01)
    """
    r, s = _bank(radii, weights)
    begin, target = check_room(low, high, tolerance, start, end)
    if not spent:
        points = _known(r, s, low, high, begin, tolerance)
        duration = limits.stroke_time(np.abs(np.diff(points)))
        return _homing(points, duration, r, s, _least_time(r, s, begin, low, high, tolerance, limits))
    points, bound = spending(r, s, (low, high), begin, target, tolerance, limits)
    return _homing(points, limits.stroke_time(np.abs(np.diff(points))), r, s, bound)


def check_room(
    low: float, high: float, tolerance: float, start: float | None, end: float | None
) -> tuple[float, float]:
    """Return where a motion begins and ends, None the middle; refuse a range, a tolerance or a place that is none."""
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ParameterError(f"a range from {low:g} to {high:g} leaves no room to move; pass low < high.")
    if not tolerance > 0:
        raise ParameterError(f"tolerance = {tolerance:g}; no motion leaves less than nothing. Pass a positive number.")
    middle = 0.5 * (low + high)
    begin, target = (_within(x, low, high, name, middle) for x, name in ((start, "start"), (end, "end")))
    return begin, target


def _bank(radii: npt.ArrayLike, weights: npt.ArrayLike | None) -> tuple[Array, Array]:
    r = np.asarray(radii, dtype=np.float64).ravel()
    if not r.size or not (np.isfinite(r) & (r > 0)).all():
        raise ParameterError("radii of stops must be positive numbers, one at least; pass those of the model.")
    s = 1.0 / (r.size * r) if weights is None else np.asarray(weights, dtype=np.float64).ravel()
    if s.shape != r.shape or not (np.isfinite(s) & (s >= 0)).all():
        raise ParameterError(
            f"{s.size} weights for {r.size} radii, the smallest {s.min(initial=0.0):g}: pass one weight of zero or "
            f"more for each radius."
        )
    order = np.argsort(r)
    return r[order], s[order]


def _within(value: float | None, low: float, high: float, name: str, middle: float) -> float:
    x = middle if value is None else float(value)
    if not low <= x <= high:
        raise ParameterError(f"{name} = {x:g} lies outside the range {low:g} to {high:g}; pass a place inside it.")
    return x


def _width(r: Array, s: Array, span: float) -> float:
    return float(s @ np.maximum(0.0, 2.0 * r - span))


def _least_span(r: Array, s: Array, tolerance: float, largest: float) -> float:
    """Smallest span after which half the interval of the output is the tolerance; refuse if it is beyond `largest`."""
    if 0.5 * _width(r, s, largest) > tolerance * (1 + 1e-12):
        raise ParameterError(
            f"the range is {largest:g} wide, less than a full stroke 2 r = {2 * r[-1]:g} over the largest stop: the "
            f"output stays unknown to +-{0.5 * _width(r, s, largest):.3g}, more than the tolerance {tolerance:g}. "
            f"Allow a wider range, a tolerance of that size, or leave out larger radii.",
            span=largest,
            half_width=0.5 * _width(r, s, largest),
        )
    lower, upper = 0.0, min(largest, 2.0 * float(r[-1]))
    if 0.5 * _width(r, s, 0.0) <= tolerance:
        return 0.0
    for _ in range(80):
        span = 0.5 * (lower + upper)
        lower, upper = (span, upper) if 0.5 * _width(r, s, span) > tolerance else (lower, span)
    return upper


def _known(r: Array, s: Array, low: float, high: float, begin: float, tolerance: float) -> Array:
    span = _least_span(r, s, tolerance, high - low)
    sign = 1.0 if high - begin >= begin - low else -1.0
    room = max(high - begin, begin - low)
    back = max(0.0, span - room)  # what the wider side lacks is taken on the other one, first
    points = [begin, begin - sign * back, begin + sign * (span - back)]
    return np.array(points if back > 0 else points[::2])


def _least_time(r: Array, s: Array, begin: float, low: float, high: float, tolerance: float, limits: Limits) -> float:
    points = _known(r, s, low, high, begin, tolerance)
    return float(limits.stroke_time(np.abs(np.diff(points))).sum())


def _homing(points: Array, stroke_s: Array, r: Array, s: Array, bound: float) -> Homing:
    lowest, highest = admissible(points, r)
    half = 0.5 * float(s @ (highest - lowest))
    residual = float(s @ np.maximum(np.abs(lowest), np.abs(highest)))
    return Homing(points, stroke_s, half, residual, min(bound, float(stroke_s.sum())))
