"""Static force map over contraction and pressure: stroke, stiffness, largest force.

Everything is in SI units, pressures are gauge, contractions are (l_0 - l)/l_0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from dehyst.arrays import Array
from dehyst.robot.muscles.base import MuscleModel

FURTHEST = 0.6  # contraction; no muscle goes beyond, whatever its formula does there
TOLERANCE = 1e-10  # of a contraction


@dataclass(frozen=True, eq=False)
class ForceMap:
    """Static forces over contraction and pressure, and what is read from them.

    Attributes
    ----------
    contraction, pressure
        (n,); (m,). [1], [Pa]
    force
        (n, m), without friction; negative where the formula is, though a muscle does not push. [N]
    blocked
        (m,) at contraction 0. [N]
    free
        (m,) contraction at which nothing is left of the force; NaN where the formula never gets there.
    stiffness
        (m,) force lost on a metre of shortening, at half the free contraction. [N/m]
    """

    contraction: Array
    pressure: Array
    force: Array
    blocked: Array
    free: Array
    stiffness: Array


def force_map(model: MuscleModel, contraction: npt.ArrayLike, pressure: npt.ArrayLike) -> ForceMap:
    """Return static forces at every pair of a contraction and a pressure.

    Parameters
    ----------
    model
        Any muscle model.
    contraction, pressure
        (n,); (m,). [1], [Pa]

    Raises
    ------
    ParameterError
        If a value is not finite, or outside the model's limits.

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
    >>> found = force_map(muscle("tondu-lopez"), [0.0, 0.1, 0.2], [1e5, 3e5])
    >>> found.force.shape, bool(found.free[0] == found.free[1])
    ((3, 2), True)
    """
    k = np.atleast_1d(np.asarray(contraction, float))
    p = np.atleast_1d(np.asarray(pressure, float))
    force = model.static_force(k[:, None], p[None, :])
    free = np.array([free_contraction(model, each) for each in p.tolist()])
    half = np.where(np.isfinite(free), 0.5 * free, 0.1)
    h = 1e-4
    slope = (model.static_force(half + h, p) - model.static_force(half - h, p)) / (2 * h)
    return ForceMap(k, p, force, model.static_force(np.zeros(p.size), p), free, -slope / model.length)


def free_contraction(model: MuscleModel, pressure: float, load: float = 0.0) -> float:
    """Return the contraction at which a muscle at rest carries just a load [N], NaN if it does not reach it.

    Parameters
    ----------
    model
        Any muscle model.
    pressure
        Gauge. [Pa]
    load
        Pull. [N]

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
    >>> round(free_contraction(muscle("tondu-lopez"), 3e5), 3)
    0.297
    """
    low, high = reach(model)
    grid = np.linspace(low, high, 241)
    left = model.static_force(grid, np.full(grid.size, pressure)) - load
    falls = np.flatnonzero((left[:-1] > 0) & (left[1:] <= 0))
    if not falls.size:
        return math.nan
    i = int(falls[0])
    root = brentq(lambda k: float(model.static_force(k, pressure)) - load, grid[i], grid[i + 1], xtol=TOLERANCE)
    return float(root)


def reach(model: MuscleModel) -> tuple[float, float]:
    """Return the contractions that are looked at: 0 to `FURTHEST`, or as far as the formulas go."""
    low, high = model.limits
    inside = 1e-9 * (high - low)
    return max(0.0, low + inside), min(FURTHEST, high - inside)


def lowest_pressure(model: MuscleModel, load: float, highest: float) -> float:
    """Return the lowest pressure at which a muscle of its length at rest carries a load, NaN if none up to one does.

    Parameters
    ----------
    model
        Any muscle model.
    load
        Pull. [N]
    highest
        Pressure up to which is looked. [Pa]
    """
    grid = np.linspace(0.0, highest, 61)
    left = model.static_force(np.zeros(grid.size), grid) - load
    if left[0] >= 0:
        return 0.0
    rises = np.flatnonzero((left[:-1] < 0) & (left[1:] >= 0))
    if not rises.size:
        return math.nan
    i = int(rises[0])
    return float(brentq(lambda p: float(model.static_force(0.0, p)) - load, grid[i], grid[i + 1], xtol=1e-3))
