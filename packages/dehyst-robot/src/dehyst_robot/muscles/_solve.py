"""Solves the force of a muscle model for the pressure."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import InvertibilityError

LOW, HIGH = 0.0, 2e6  # Pa; more than any muscle takes
_GRID = 21  # pressures between which the sign of the slope is checked
_HALVINGS = 60  # 2 MPa / 2^60: below rounding


def solve_pressure(
    force_at: Callable[[Array], Array], force: Array, affine: bool, about: str
) -> Array:
    """Return the pressures at which `force_at` gives a force, element by element.

    Parameters
    ----------
    force_at
        Pressures -> forces, of the shape of `force`, each element of its own.
    force
        At these pressures. [N]
    affine
        Whether `force_at` is affine: then it is solved in closed form, from two pressures.
    about
        Name of the muscle, for errors.

    Returns
    -------
    pressure : Array
        Gauge. [Pa]

    Raises
    ------
    InvertibilityError
        Where force does not grow with pressure, or no pressure gives it. Where the force is not affine, 0 to 20 bar are
        searched.

    Examples
    --------
    >>> solve_pressure(lambda p: 2e-3 * p - 10.0, np.array([590.0]), True, "a muscle").round(6).tolist()
    [300000.0]
    """
    at_zero = np.asarray(force_at(np.zeros_like(force)), float)
    if affine:
        rise = np.asarray(force_at(np.full_like(force, 1e6)), float) - at_zero
        _insist(rise > 1e-6 * max(1.0, float(np.max(rise, initial=0.0))), about)
        return np.asarray(1e6 * (force - at_zero) / rise)
    return _monotone(force_at, force, about)


def _monotone(force_at: Callable[[Array], Array], force: Array, about: str) -> Array:
    """Solve by halving; forces on a grid of pressures show first that there is one solution."""
    low, high = np.full_like(force, LOW), np.full_like(force, HIGH)
    steps = []
    for pressure in np.linspace(LOW, HIGH, _GRID):
        steps.append(np.asarray(force_at(np.full_like(force, pressure)), float))
    if force.size:
        _insist(np.min(np.diff(steps, axis=0), axis=0) > 0, about)
    slack = 1e-9 * (steps[-1] - steps[0])
    beyond = (steps[0] > force + slack) | (force > steps[-1] + slack)
    if beyond.any():
        i = int(np.flatnonzero(beyond)[0])
        raise InvertibilityError(
            f"no pressure from {LOW:g} to {HIGH:g} Pa gives {force.flat[i]:.5g} N with {about}: it gives "
            f"{steps[0].flat[i]:.5g} to {steps[-1].flat[i]:.5g} N there. Ask for a force in between.",
            index=i,
        )
    return halved(force_at, force, low, high)


def halved(rising: Callable[[Array], Array], values: Array, low: Array, high: Array) -> Array:
    """Return where a rising function has these values, between two bounds, element by element, to rounding."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        above = np.asarray(rising(middle), float) > values
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(0.5 * (low + high))


def _insist(rises: Array, about: str) -> None:
    if not np.all(rises):
        i = int(np.flatnonzero(np.logical_not(rises))[0])
        raise InvertibilityError(
            f"with {about} the force does not grow with the pressure at sample {i}: it determines no pressure. The "
            "muscle is at or beyond its largest contraction there; keep to smaller ones.",
            index=i,
        )
