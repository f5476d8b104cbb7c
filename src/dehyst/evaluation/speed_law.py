"""Jerk-limited motion from rest to rest along one curve."""

from __future__ import annotations

import math

import numpy as np

from dehyst.arrays import Array
from dehyst.evaluation.curves import Curve


def rest_to_rest(distance: float, speed: float, acceleration: float, jerk: float) -> tuple[Array, Array]:
    """Return the seven phases of the fastest jerk-limited motion from rest to rest.

    With T_j the time of constant jerk and T_a that of the whole acceleration:

    - v j >= a^2: T_j = a/j, T_a = v/a + T_j; otherwise T_j = sqrt(v/j), T_a = 2 T_j;
    - cruising for (D - v T_a)/v; if that is negative, the peak speed is the root of D = v T_a.

    Closed form, so that it is exact, vectorised and without a dependency; the tests compare it with ruckig.

    Parameters
    ----------
    distance
        D > 0. [m]
    speed, acceleration, jerk
        Limits v, a, j > 0. [m/s, m/s^2, m/s^3]

    Returns
    -------
    duration : (7,)
        Of the phases; some may be zero. [s]
    jerk : (7,)
        In the phases: j, 0, -j, 0, -j, 0, j. [m/s^3]

    Examples
    --------
    >>> rest_to_rest(2.0, 1.0, 1.0, 2.0)[0].tolist()
    [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5]
    """
    d, v, a, j = distance, speed, acceleration, jerk
    ramp = v / a + a / j if v * j >= a * a else 2.0 * math.sqrt(v / j)
    if v * ramp > d:  # the speed limit is not reached
        if d * j * j >= 2.0 * a**3:
            v = 0.5 * a * (math.sqrt((a / j) ** 2 + 4.0 * d / a) - a / j)
        else:
            v = float(np.cbrt(0.25 * d * d * j))  # v = j T_j^2, D = 2 j T_j^3
    t_jerk = a / j if v * j >= a * a else math.sqrt(v / j)
    ramp = v / a + t_jerk if v * j >= a * a else 2.0 * t_jerk
    constant, cruise = max(ramp - 2.0 * t_jerk, 0.0), max(d / v - ramp, 0.0)
    return (
        np.array([t_jerk, constant, t_jerk, cruise, t_jerk, constant, t_jerk]),
        np.array([j, 0.0, -j, 0.0, -j, 0.0, j]),
    )


def leg_limits(curve: Curve, speed: float, acceleration: float, jerk: float) -> tuple[float, float, float]:
    """Return the limits along a curve that keep the whole acceleration and jerk, bends included, within theirs.

    With r(s) run as s(t), kappa the curvature:

    - acceleration: s'' along the tangent, kappa s'^2 across; the bend may take a/sqrt(2), the tangent has the rest;
    - jerk: s''' - kappa^2 s'^3 along, 3 kappa s' s'' + kappa' s'^3 across. If their bound is beyond the limit, the leg
      is run slower as a whole (v, a, j times sigma, sigma^2, sigma^3), which keeps the command speed constant.

    Returns
    -------
    speed, acceleration, jerk : float
        Limits for s', s'', s'''. [m/s, m/s^2, m/s^3]

    Examples
    --------
    >>> from dehyst.evaluation.curves import Straight
    >>> leg_limits(Straight(np.zeros(3), np.ones(3)), 0.25, 2.0, 20.0)
    (0.25, 2.0, 20.0)
    """
    v, a, j, kappa = speed, acceleration, jerk, curve.curvature
    if kappa == 0.0:
        return v, a, j
    v = min(v, math.sqrt(a / (math.sqrt(2.0) * kappa)))
    a = math.sqrt(a * a - (kappa * v * v) ** 2)
    j = 0.5 * j
    worst = math.hypot(j + kappa**2 * v**3, 3.0 * kappa * v * a + curve.curvature_rate * v**3)
    sigma = min(1.0, float(np.cbrt(jerk / worst)))
    return sigma * v, sigma**2 * a, sigma**3 * j
