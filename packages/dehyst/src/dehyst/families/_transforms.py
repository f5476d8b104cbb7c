r"""Powers of an input of one sign, in front of a sum: what heats, attracts or squeezes goes with the square.

    T(y) = c + sum of w f(e_k[M(u)]),   M: -1 .. 1 to itself, in shares s of the range from input 0:

===========  ====================  =========================================================================
square       0.95 s^2 + 0.05 s     heat of a current, force of a magnet, stress of an elastomer under voltage
root         sqrt(s)               what saturates: a magnet near saturation, a flow by its pressure
logarithm    log(u/low), scaled    inputs of which equal ratios count, the largest 5 times the least or more
===========  ====================  =========================================================================

Ramps of the input can bend any curve; plays and lags cannot: their radii are those of the input itself. So a transform
is taken where sums behind it err clearly less on what is left out. M is piecewise linear, exact at its points, so that
model, inverse and every target have one and the same map. Its slope never vanishes: the inverse stays bounded.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dehyst.arrays import Array
from dehyst.families._base import Scaling
from dehyst.families._policy import POLICY

POINTS = 33
LINEAR = (
    0.05  # share of a line beside the square: at input 0 the inverse would be steep without end
)

LEAST_RATIO = 5.0  # of the ends of a range: below it a logarithm is next to a root
FARTHEST_FROM_ZERO = (
    0.5  # share of the range's end: between it and the end a power is next to a line
)
Pairs = tuple[tuple[float, ...], tuple[float, ...]]


def _square(s: Array) -> Array:
    return (1.0 - LINEAR) * s**2 + LINEAR * s


OF_SHARES: dict[str, Callable[[Array], Array]] = {"square": _square, "root": np.sqrt}
LOGARITHM = "logarithm"


def transforms(scaling: Scaling) -> dict[str, Pairs]:
    """Return name -> map of the scaled input, for a range of one sign that begins near input 0; else none.

    Examples
    --------
    >>> sorted(transforms(Scaling(center=50.0, half_range=50.0)))
    ['root', 'square']
    >>> sorted(transforms(Scaling(center=5.5, half_range=4.6))), sorted(transforms(Scaling(0.0, 50.0)))
    (['logarithm', 'root', 'square'], [])
    """
    x = np.linspace(-1.0, 1.0, POINTS)
    u = scaling.center + scaling.half_range * x
    most = float(np.max(np.abs(u)))
    slack = POLICY.one_sided * 2.0 * abs(scaling.half_range)
    if u.min() < -slack and u.max() > slack:
        return {}
    # Shares of the farthest end; the few inputs of the other sign are below 0.
    s = np.sign(u.sum()) * u / most
    maps = {}
    if s.min() <= FARTHEST_FROM_ZERO:
        for name, power in OF_SHARES.items():
            maps[name] = _pairs(x, np.sign(s) * power(np.abs(s)))
    if 0.0 < s.min() <= 1.0 / LEAST_RATIO:
        maps[LOGARITHM] = _pairs(x, np.log(s))
    return maps


def _pairs(x: Array, v: Array) -> Pairs:
    """Return the map from -1 .. 1 onto itself with the shape of values that rise or fall."""
    scaled = 2.0 * (v - v.min()) / np.ptp(v) - 1.0
    if v[0] > v[-1]:
        scaled = -scaled
    return tuple(x.tolist()), tuple(scaled.tolist())


def transform_name(scaling: Scaling, before_map: Pairs) -> str:
    """Return the name of the transform that a map in front of a sum is; "" for none of them."""
    for name, pairs in transforms(scaling).items():
        if before_map == pairs:
            return name
    return ""
