"""Parameters of an oscillator with a Bouc-Wen element from force and position."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from oscillator.linear import identify_linear
from oscillator.model import BoucWenOscillator
from oscillator.output_error import OutputErrorFit, fit_output_error, lead_time
from oscillator.records import PeriodicRecord

NAMES = ("mass", "damping", "stiffness", "alpha", "beta gamma", "beta delta", "nu")
# In units of the best linear oscillator: all of its mass; half of its damping, for hysteresis gives the rest; its
# stiffness shared equally between spring and element; an element that yields at the rms force, delta zero.
START = (1.0, 0.5, 0.5, 0.5, 0.5, 0.0, 1.0)


@dataclass(frozen=True)
class BoucWenFit:
    """Physical parameters and how sure they are.

    Attributes
    ----------
    oscillator
        The identified system; its beta is 1 by convention, gamma and delta carry the products.
    values, standard_errors
        By name: mass [kg], damping [N s/m], stiffness and alpha [N/m], "beta gamma" and "beta delta" [N^(1-nu)/m],
        and nu if it was free.
    correlation
        Between them (p, p), in that order.
    fit
        What the optimiser found.
    """

    oscillator: BoucWenOscillator
    values: dict[str, float]
    standard_errors: dict[str, float]
    correlation: Array
    fit: OutputErrorFit


def identify_bouc_wen(
    records: Sequence[PeriodicRecord], *, nu: float | None = 1.0, start: Sequence[float] = START
) -> BoucWenFit:
    """Identify mass, damping, stiffness, alpha, beta gamma, beta delta (and nu) by output error.

    beta itself cannot be told from gamma and delta: only the products act. Stiffness and alpha can be told apart, but
    only by the curvature of the loops: for small motion only their sum acts, and the estimates are correlated.

    Parameters
    ----------
    records
        Averaged periods of one or more experiments.
    nu
        Exponent, or None to identify it too.
    start
        Relative to the best linear oscillator (m, c, k) and the rms force F: m, c, k, alpha, then beta gamma and
        beta delta in units of k / F^nu, then nu.

    Raises
    ------
    ExcitationError, IdentificationError
        As by the linear fit and the optimiser.
    """
    linear = identify_linear(records)
    load = float(np.sqrt(np.mean([np.mean(record.force**2) for record in records])))
    count = 7 if nu is None else 6

    def physical(p: Array) -> Array:
        power = float(p[6]) if nu is None else nu
        unit = linear.stiffness / load**power
        scale = np.array(
            [linear.mass, linear.damping, linear.stiffness, linear.stiffness, unit, unit, 1.0]
        )
        scaled: Array = p * scale[:count]
        return scaled

    def build(p: Array) -> BoucWenOscillator:
        mass, damping, stiffness, alpha, gamma, delta, *rest = physical(p)
        return BoucWenOscillator(
            mass, damping, stiffness, alpha, 1.0, gamma, delta, rest[0] if rest else nu or 1.0
        )

    fit = fit_output_error(
        build, start[:count], records, lead=lead_time(linear.mass, 0.25 * linear.damping)
    )
    slope = _derivative(physical, fit.parameters)
    covariance = slope @ fit.covariance @ slope.T
    errors = np.sqrt(np.diag(covariance))
    names = NAMES[:count]
    return BoucWenFit(
        build(fit.parameters),
        dict(zip(names, physical(fit.parameters).tolist(), strict=True)),
        dict(zip(names, errors.tolist(), strict=True)),
        covariance / np.outer(errors, errors),
        fit,
    )


def _derivative(function: Callable[[Array], Array], point: Array) -> Array:
    """Central differences (p, p)."""
    columns = []
    for j in range(point.size):
        step = np.zeros(point.size)
        step[j] = 1e-6
        columns.append((function(point + step) - function(point - step)) / 2e-6)
    return np.stack(columns, axis=1)
