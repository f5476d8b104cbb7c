"""The curve without hysteresis under friction models: a rising polynomial on [-1, 1] with straight ends."""

from __future__ import annotations

from functools import lru_cache
from math import comb

import numpy as np

from dehyst.arrays import Array

DEGREE = 7
FLOOR = 1e-3  # least slope of a fitted curve, scaled; what leaves an inverse
PLACES = 2001


@lru_cache
def rising_polynomials(degree: int = DEGREE) -> Array:
    """Return coefficients (degree, degree + 1) of polynomials that rise on [-1, 1]: integrals of Bernstein's.

    Their sums with weights that are not negative rise too.
    """
    rows = np.zeros((degree, degree + 1))
    up, down = np.polynomial.Polynomial([0.5, 0.5]), np.polynomial.Polynomial([0.5, -0.5])
    for k in range(degree):
        slope = comb(degree - 1, k) * up**k * down ** (degree - 1 - k)
        whole = slope.integ().coef
        rows[k, : whole.size] = whole
    rows.flags.writeable = False
    return rows


def values(curve: Array, x: Array) -> Array:
    """Curve at x, straight beyond [-1, 1]."""
    inside = np.clip(x, -1.0, 1.0)
    polynomial = np.polynomial.polynomial
    # Outside the range the curve goes straight on with the slope of its end.
    return np.asarray(polynomial.polyval(inside, curve) + _slope(curve, inside) * (x - inside))


def slopes(curve: Array) -> Array:
    """Slopes (PLACES,) over [-1, 1]: all there are, for the ends go straight on."""
    return _slope(curve, np.linspace(-1.0, 1.0, PLACES))


def _slope(curve: Array, x: Array) -> Array:
    """Slope of a polynomial at x in [-1, 1]."""
    if curve.size < 2:
        return np.zeros_like(x)
    polynomial = np.polynomial.polynomial
    return np.asarray(polynomial.polyval(x, polynomial.polyder(curve)))
