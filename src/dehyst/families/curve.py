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
    """Coefficients (degree, degree + 1) of polynomials that rise on [-1, 1]: integrals of Bernstein's polynomials.

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
    held = np.clip(x, -1.0, 1.0)
    polynomial = np.polynomial.polynomial
    slope = polynomial.polyval(held, polynomial.polyder(curve)) if curve.size > 1 else np.zeros_like(held)
    return np.asarray(polynomial.polyval(held, curve) + slope * (x - held))


def slopes(curve: Array) -> Array:
    """Slopes (PLACES,) over [-1, 1]: all there are, for the ends go straight on."""
    x = np.linspace(-1.0, 1.0, PLACES)
    polynomial = np.polynomial.polynomial
    return np.asarray(polynomial.polyval(x, polynomial.polyder(curve)) if curve.size > 1 else np.zeros_like(x))
