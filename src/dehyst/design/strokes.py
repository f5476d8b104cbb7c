"""Smooth strokes from point to point within limits of rate and acceleration, each followed by a hold of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.design.excitation import smooth_stroke
from dehyst.errors import ParameterError

PEAK_RATE = 35.0 / 16.0  # of a smooth stroke of length and time one
PEAK_ACCELERATION = 16.8 / math.sqrt(5.0)  # of the same: 420 u^2 (1 - u)^2 (1 - 2 u) where u (1 - u) = 1/5


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
        return np.maximum(PEAK_RATE * w / self.rate, np.sqrt(PEAK_ACCELERATION * w / self.acceleration))

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


def sampled(points: Array, stroke_s: Array, hold_s: Array, period: float) -> tuple[Array, Array, npt.NDArray[np.int64]]:
    """Sample strokes with holds.

    Parameters
    ----------
    points
        Ends of the strokes, (K + 1,). [unit]
    stroke_s, hold_s
        Duration of stroke k from point k to k + 1 and of the hold after it, (K,). [s]
    period
        Of the samples. [s]

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
    value = points[k] + (points[k + 1] - points[k]) * smooth_stroke(u)
    value[-1] = points[-1]
    return time, value, k
