"""Test signals for homing, calibration, identification and validation: smooth strokes within limits.

All of them move from tip to tip in smooth strokes and return time and value, (T,) each, at a fixed period; the time
starts at zero and ends with the first sample at or after the end of the motion. The peak rate is stated for each.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError

# Shares of the range for loops that test a fit, none of them a tip of the identification: biased minor loops within
# minor loops, a wiped-out loop, and one long stroke back, all inside +-1.
UNSEEN_TIPS = (
    0.86,
    -0.38,
    0.54,
    0.13,
    0.7,
    -0.67,
    -0.16,
    -0.52,
    0.27,
    0.05,
    0.4,
    -0.82,
    0.64,
    -0.55,
)


class Excitation(NamedTuple):
    """A commanded signal over time.

    Attributes
    ----------
    time
        (T,) at a fixed period, from zero. [s]
    value
        (T,) [unit of the amplitude]
    """

    time: Array
    value: Array


def loops(tips: Sequence[float], loop_s: float, hold_s: float, period: float) -> Excitation:
    """Return smooth strokes from zero through tips and back to zero, with a hold at every tip.

    A stroke takes T = loop_s/2 - hold_s however long its way is, the first and the last included: short ways are slow
    ways, so that a lightly damped joint stays quasi-static on all of them. The peak rate is 35/16 of way over T.

    Parameters
    ----------
    tips
        Within -1..1, each unlike the one before it: shares of a range.
    loop_s
        Time of two strokes with their holds. [s]
    hold_s
        Time at rest at each tip. [s]
    period
        Of the samples. [s]

    Returns
    -------
    Excitation
        Of which time is (T,) [s] and value is (T,) within -1..1.

    Raises
    ------
    ParameterError
        If a tip is outside -1..1 or equal to the one before, or if no time is left for strokes.

    Examples
    --------
    >>> time, value = loops([1.0, -0.5], loop_s=8.0, hold_s=2.0, period=1.0)
    >>> value.tolist()
    [0.0, 0.5, 1.0, 1.0, 1.0, 0.25, -0.5, -0.5, -0.5, -0.25, 0.0]
    """
    points = np.concatenate(([0.0], np.asarray(tips, dtype=np.float64).ravel(), [0.0]))
    if points.size == 2 or not (np.abs(points) <= 1).all():
        raise ParameterError(
            f"tips {tips!r} are not shares of the range; pass numbers within -1..1."
        )
    if (np.diff(points) == 0).any():
        raise ParameterError(
            f"tips {tips!r}: two in a row are the same, or one at an end is zero; a stroke needs two different ends."
        )
    stroke = _stroke_time(loop_s, hold_s)
    return _strokes(points, np.full(points.size - 1, stroke), hold_s, period, smooth_stroke)


def decaying_cycles(cycles: int, decay: float, cycle_s: float, period: float) -> Excitation:
    """Return cycles of amplitude 1 that decay geometrically to zero: homing leaves a hysteresis in a known state.

    Tips 1, -d^(1/2), d, -d^(3/2), ... in smooth strokes of cycle_s/2, the first and the last of cycle_s/4, then
    zero. The peak rate is (35/16) 2/(cycle_s/2).

    Parameters
    ----------
    cycles
        Number of cycles.
    decay
        d, ratio of a cycle's amplitude to that of the one before, in (0, 1).
    cycle_s
        Duration of one. [s]
    period
        Of the samples. [s]

    Examples
    --------
    >>> time, value = decaying_cycles(2, decay=0.25, cycle_s=4.0, period=1.0)
    >>> value.round(4).tolist()
    [0.0, 1.0, 0.25, -0.5, -0.125, 0.25, 0.0625, -0.125, 0.0]
    """
    _positive(cycle_s, "cycle_s")
    if not 0 < decay < 1:
        raise ParameterError(
            f"decay = {decay}: the cycles would not die out. Pass a ratio between 0 and 1, such as 0.7."
        )
    if cycles < 1 or cycles != int(cycles):
        raise ParameterError(f"cycles = {cycles}; pass a whole number of one or more.")
    k = np.arange(2 * int(cycles))
    tips = np.concatenate(([0.0], (-1.0) ** k * decay ** (0.5 * k), [0.0]))
    durations = np.full(tips.size - 1, 0.5 * cycle_s)
    durations[[0, -1]] = 0.25 * cycle_s
    return _strokes(tips, durations, 0.0, period, smooth_stroke)


def triangle_sweep(
    sweep_s: float,
    period: float,
    low: float = -1.0,
    high: float = 1.0,
    rounding: float = 0.1,
    start: float | None = None,
) -> Excitation:
    """Return a sweep up and down at constant rate with rounded turns: quasi-static calibration.

    low, high, low, each stroke in sweep_s/2, of which `rounding` at both ends is used to take up the rate smoothly, as
    a raised cosine. The peak rate is 2 (high - low)/(sweep_s (1 - rounding)).

    Parameters
    ----------
    sweep_s
        Time of the sweep up and down. [s]
    period
        Of the samples. [s]
    low, high
        Ends of the sweep, low < high. [any unit]
    rounding
        Share of a stroke used to take up the rate, and again to give it back, in (0, 0.5].
    start
        If given: where the run begins and ends; the ways to and from `low` take the same peak rate at most.

    Examples
    --------
    >>> time, value = triangle_sweep(sweep_s=8.0, period=1.0)
    >>> value.round(2).tolist()
    [-1.0, -0.56, 0.0, 0.56, 1.0, 0.56, 0.0, -0.56, -1.0]
    """
    _positive(sweep_s, "sweep_s")
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ParameterError(f"a sweep from {low} to {high} goes nowhere; pass low < high.")
    if not 0 < rounding <= 0.5:
        raise ParameterError(f"rounding = {rounding}; pass a share in (0, 0.5], such as 0.1.")
    tips, durations = [low, high, low], [0.5 * sweep_s, 0.5 * sweep_s]
    if start is not None and start != low:
        if not math.isfinite(start):
            raise ParameterError(f"start = {start}; pass a finite number or None.")
        way = 0.5 * sweep_s * abs(start - low) / (high - low)
        tips, durations = [start, *tips, start], [way, *durations, way]
    return _strokes(
        np.array(tips), np.array(durations), 0.0, period, lambda u: _rounded_ramp(u, rounding)
    )


def _stroke_time(loop_s: float, hold_s: float) -> float:
    stroke = 0.5 * _positive(loop_s, "loop_s") - _positive(hold_s, "hold_s", zero=True)
    if stroke <= 0:
        raise ParameterError(
            f"loop_s = {loop_s:g} s leaves no time for strokes with a hold of {hold_s:g} s at both tips; "
            f"pass more than {2 * hold_s:g} s, or shorter holds."
        )
    return stroke


def smooth_stroke(u: Array) -> Array:
    """Return a way from 0 to 1 over u in 0..1 whose speed, acceleration and jerk begin and end at zero.

    A joint of compliant muscles is lightly damped: the step of acceleration at the ends of a smooth makes it ring
    through the hold that follows, and the log shows the ringing's hysteresis, not the loop's.
    """
    return np.asarray(u**4 * (35.0 + u * (-84.0 + u * (70.0 - 20.0 * u))))


def _rounded_ramp(u: Array, share: float) -> Array:
    """Return a way from 0 to 1 over u in 0..1: the rate rises as a raised cosine over `share`, and falls likewise."""
    v = 1.0 / (1.0 - share)  # the constant rate in between

    def rise(x: Array) -> Array:
        return np.asarray(0.5 * v * (x - share / np.pi * np.sin(np.pi * x / share)))

    middle = v * (u - 0.5 * share)
    return np.where(u < share, rise(u), np.where(u > 1.0 - share, 1.0 - rise(1.0 - u), middle))


def _strokes(
    tips: Array, durations: Array, hold_s: float, period: float, shape: Callable[[Array], Array]
) -> Excitation:
    """Return strokes between tips (K + 1,) of these durations (K,), with a hold at every tip but first and last."""
    _positive(period, "period")
    _positive(hold_s, "hold_s", zero=True)
    if period > float(durations.min()):
        raise ParameterError(
            f"a period of {period:g} s misses strokes of {durations.min():g} s; pass a shorter period "
            f"or slower strokes."
        )
    holds = np.full(durations.size, hold_s)
    holds[-1] = 0.0
    time, value, _ = sampled(tips, durations, holds, period, shape)
    return Excitation(time, value)


def _positive(value: float, name: str, *, zero: bool = False) -> float:
    if not (math.isfinite(value) and (value > 0 or (zero and value == 0))):
        raise ParameterError(
            f"{name} = {value}; pass a {'number of zero or more' if zero else 'positive number'}."
        )
    return value


PEAK_RATE = 35.0 / 16.0  # of a smooth stroke of length and time one
PEAK_ACCELERATION = 16.8 / math.sqrt(
    5.0
)  # of the same: 420 u^2 (1 - u)^2 (1 - 2 u) where u (1 - u) = 1/5


@dataclass(frozen=True, slots=True)
class Limits:
    """How fast a motion may be.

    Attributes
    ----------
    rate
        Largest |dx/dt|, > 0. [unit/s]
    acceleration
        Largest |d2x/dt2|, > 0; infinite: not limited. [unit/s^2]

    Raises
    ------
    ParameterError
        If one is not a positive number.

    Examples
    --------
    >>> Limits(rate=30.0, acceleration=20.0).stroke_time(56.0).round(2).item()
    4.59
    """

    rate: float
    acceleration: float = math.inf

    def __post_init__(self) -> None:
        for name, value in (("rate", self.rate), ("acceleration", self.acceleration)):
            if not value > 0 or (name == "rate" and not math.isfinite(value)):
                raise ParameterError(
                    f"{name} = {value:g}: nothing could move within that limit. Pass what the rig may do, a positive "
                    f"number in units per second{' squared' if name == 'acceleration' else ''}.",
                    limit=name,
                    value=value,
                )

    def stroke_time(self, way: npt.ArrayLike) -> Array:
        """Return the shortest time of a smooth stroke over a way w >= 0, any shape. [s]

        T = max(35 w/(16 rate), sqrt(16.8 w/(5^(1/2) acceleration))): rate and acceleration peak at the limits and
        no further; the stroke begins and ends without acceleration.

        Examples
        --------
        >>> Limits(rate=35.0).stroke_time([16.0, 0.0]).tolist()
        [1.0, 0.0]
        """
        w = np.asarray(way, dtype=np.float64)
        return np.maximum(
            PEAK_RATE * w / self.rate, np.sqrt(PEAK_ACCELERATION * w / self.acceleration)
        )

    def slower(self, factor: float) -> Limits:
        """Return the limits of the same motion made `factor` times slower.

        Examples
        --------
        >>> Limits(10.0, 100.0).slower(10.0)
        Limits(rate=1.0, acceleration=1.0)
        """
        return Limits(self.rate / factor, self.acceleration / factor**2)

    def shares(self, size: float) -> Limits:
        """Return the limits where positions are counted in multiples of `size`.

        Examples
        --------
        >>> Limits(10.0, 100.0).shares(5.0)
        Limits(rate=2.0, acceleration=20.0)
        """
        return Limits(self.rate / size, self.acceleration / size)


def sampled(
    points: Array,
    stroke_s: Array,
    hold_s: Array,
    period: float,
    shape: Callable[[Array], Array] = smooth_stroke,
) -> tuple[Array, Array, npt.NDArray[np.int64]]:
    """Sample strokes with holds.

    Parameters
    ----------
    points
        Ends of the strokes, (K + 1,). [unit]
    stroke_s, hold_s
        Duration of stroke k from point k to k + 1 and of the hold after it, (K,). [s]
    period
        Of the samples. [s]
    shape
        Of a stroke: a way from 0 to 1 over 0..1.

    Returns
    -------
    time
        (T,) from zero, to the first sample at or after the end. [s]
    value
        (T,) [unit]
    stroke
        (T,) number of the stroke that a sample belongs to, its hold included.

    Examples
    --------
    >>> time, value, stroke = sampled(np.array([0.0, 2.0, 1.0]), np.array([2.0, 2.0]), np.array([1.0, 0.0]), 1.0)
    >>> value.tolist(), stroke.tolist()
    ([0.0, 1.0, 2.0, 2.0, 1.5, 1.0], [0, 0, 0, 1, 1, 1])
    """
    begins = np.concatenate(([0.0], np.cumsum(stroke_s + hold_s)[:-1]))
    total = float(begins[-1] + stroke_s[-1] + hold_s[-1])
    time = period * np.arange(math.ceil(total / period - 1e-9) + 1, dtype=np.float64)
    k = np.searchsorted(begins, time + 1e-9 * period, side="right") - 1
    u = np.clip((time - begins[k]) / stroke_s[k], 0.0, 1.0)
    value = points[k] + (points[k + 1] - points[k]) * shape(u)
    value[-1] = points[-1]
    return time, value, k
