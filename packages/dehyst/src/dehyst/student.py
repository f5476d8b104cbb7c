"""Student's distribution: the share of its tail, and the place where the tail has a given share.

The incomplete beta function is a continued fraction, which keeps the digits of a small share too. SciPy has both
functions, but nothing else in the kernel needs its 143 MB.
"""

from __future__ import annotations

import math
from functools import lru_cache

TINY = 1e-300  # stands for a zero that would be divided by
ENOUGH = 1e-16  # a factor that differs less from 1 changes nothing
MOST_TERMS = 10_000  # the fraction needs about the square root of the freedom
MOST_STEPS = 100  # of Newton's method, which doubles the place at first and the digits later


def tail(t: float, freedom: int) -> float:
    """Return the probability that Student's variable exceeds t.

    Examples
    --------
    >>> round(tail(1.0, 1), 12), round(tail(-1.0, 1), 12)
    (0.25, 0.75)
    """
    if t < 0.0:
        return 1.0 - tail(-t, freedom)
    square = t * t
    return 0.5 * _incomplete_beta(
        freedom / (freedom + square), square / (freedom + square), 0.5 * freedom
    )


@lru_cache(maxsize=256)
def place_of_tail(share: float, freedom: int) -> float:
    """Return the t >= 0 that Student's variable exceeds with this probability, at most 0.5.

    Newton's method begins at 0. The tail is convex there, so that the steps never pass the place.

    Examples
    --------
    >>> round(place_of_tail(0.025, 7), 3)
    2.365
    """
    log_scale = (
        math.lgamma(0.5 * (freedom + 1))
        - math.lgamma(0.5 * freedom)
        - 0.5 * math.log(freedom * math.pi)
    )
    t = 0.0
    for _ in range(MOST_STEPS):
        density = math.exp(log_scale - 0.5 * (freedom + 1) * math.log1p(t * t / freedom))
        further = t + (tail(t, freedom) - share) / density
        if not further > t:
            break
        t = further
    return t


def quantile(confidence: float, freedom: int) -> float:
    """Two-sided quantile of Student's distribution.

    Examples
    --------
    >>> round(quantile(0.95, 7), 3)
    2.365
    """
    return place_of_tail(0.5 * (1.0 - confidence), freedom)


def _incomplete_beta(x: float, complement: float, a: float) -> float:
    """Regularised incomplete beta function I_x(a, 1/2); x + complement = 1, each with all its digits."""
    b = 0.5
    if x <= 0.0 or not math.isfinite(complement):
        return 0.0
    if complement <= 0.0:
        return 1.0
    log_beta = math.lgamma(a) + math.lgamma(b) - math.lgamma(a + b)
    front = math.exp(a * math.log(x) + b * math.log(complement) - log_beta)
    if x < (a + 1.0) / (a + b + 2.0):  # where the fraction converges fast
        return front * _fraction(x, a, b) / a
    return 1.0 - front * _fraction(complement, b, a) / b


def _fraction(x: float, a: float, b: float) -> float:
    """Continued fraction of the incomplete beta function, by Lentz's method."""
    upper, lower = 1.0, 1.0 / _not_zero(1.0 - (a + b) * x / (a + 1.0))
    value = lower
    for m in range(1, MOST_TERMS):
        even = m * (b - m) * x / ((a + 2 * m - 1.0) * (a + 2 * m))
        odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1.0))
        for term in (even, odd):
            lower = 1.0 / _not_zero(1.0 + term * lower)
            upper = _not_zero(1.0 + term / upper)
            value *= lower * upper
        if abs(lower * upper - 1.0) < ENOUGH:
            break
    return value


def _not_zero(number: float) -> float:
    return number if abs(number) > TINY else TINY
