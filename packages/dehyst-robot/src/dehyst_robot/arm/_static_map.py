"""Static force of a muscle model as the table that the plant interpolates.

The plant interpolates the model's own static force, its friction left out, on an even grid of gauge pressure and
contraction: the middle of the model's loop. Hysteresis, creep and viscous force are the plant's.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst_robot.arm._policy import POLICY
from dehyst_robot.arm._tables import Muscle
from dehyst_robot.muscles import MuscleModel, muscle

CONTRACTIONS = (-0.05, 0.35)  # of a table, or the model's limits if these are narrower
# Points along pressure and contraction of the first table, and of the largest one.
FIRST = (17, 65)
MOST = (1025, 4097)
# Share of `table_error` that the error along each axis may have: both add up.
MARGIN = 0.4


@dataclass(frozen=True, eq=False)
class StaticMap:
    """Static forces of a model on an even grid.

    Attributes
    ----------
    pressure, contraction
        (n,) gauge, (m,). [Pa], [1]
    force
        (n, m). [N]
    """

    pressure: Array
    contraction: Array
    force: Array


def static_map_model(type_: Muscle) -> MuscleModel:
    """Return the model of a type of muscle that names one: its parameters, as long as the muscle is.

    Raises
    ------
    ParameterError
        If its set or its parameters are none of the model's.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from dehyst_robot.arm import load_robot
    >>> static_map_model(replace(load_robot().muscle("dmsp40"), model="tondu-lopez", parameters={"shape": 1.4})).shape
    1.4
    """
    assert type_.model is not None
    if "length" in type_.parameters:
        raise ParameterError(
            "the length is length_m of the muscle. Remove length from its parameters."
        )
    return muscle(type_.model, type_.set or "", **{**type_.parameters, "length": type_.length})


@lru_cache(maxsize=64)
def static_map(model: MuscleModel, highest: float) -> StaticMap:
    """Return a model's static force as a table, off by less than 0.1 % of the full force.

    The grid runs from 0 to a highest pressure and over contractions from -0.05 to 0.35, or the model's limits if these
    are narrower; it ends where the force at the highest pressure is least, because polynomials rise again behind their
    data. It is refined until the middles of its cells are right. Beyond it the plant goes on in lines, and holds the
    force of the last contraction where a line would rise.

    Parameters
    ----------
    model
        Any muscle model.
    highest
        Gauge pressure. [Pa]

    Raises
    ------
    ParameterError
        If the model does not pull at the highest pressure, or bends too sharply for a table.

    Examples
    --------
    >>> import math
    >>> table = static_map(muscle("klute"), 7e5)
    >>> math.isclose(table.force[-1, 0], muscle("klute").static_force(table.contraction[0], 7e5))
    True
    """
    low = max(model.limits[0], CONTRACTIONS[0])
    high = min(model.limits[1], CONTRACTIONS[1])
    # The force may rise again behind its least value: the table ends there.
    k = np.linspace(0.0, high, 1001)
    high = float(k[np.argmin(model.static_force(k, highest))])
    full = float(model.static_force(0.0, highest))
    if not (full > 0 and high > 0):
        raise ParameterError(
            f"{model.name} pulls with {full:.3g} N at {highest / 1e5:g} bar and no contraction: no muscle does. Change "
            f"its parameters.",
            model=model.name,
        )
    rows, columns = FIRST
    while True:
        p, k = np.linspace(0.0, highest, rows), np.linspace(low, high, columns)
        force = _forces(model, p, k)
        between_p = _forces(model, _middles(p), k) - (force[1:] + force[:-1]) / 2
        between_k = _forces(model, p, _middles(k)) - (force[:, 1:] + force[:, :-1]) / 2
        off_p = np.abs(between_p).max() / full
        off_k = np.abs(between_k).max() / full
        if off_p < MARGIN * POLICY.table_error and off_k < MARGIN * POLICY.table_error:
            return StaticMap(p, k, force)
        # Each axis is refined by itself: many models are nearly straight along the pressure.
        finer_rows, finer_columns = rows, columns
        if off_p >= MARGIN * POLICY.table_error:
            finer_rows = 2 * rows - 1
        if off_k >= MARGIN * POLICY.table_error:
            finer_columns = 2 * columns - 1
        if finer_rows > MOST[0] or finer_columns > MOST[1]:
            raise ParameterError(
                f"{model.name} bends too sharply with these parameters: a table of {rows} x {columns} forces is off by "
                f"{100 * max(off_p, off_k):.2g} % of {full:.4g} N, {100 * POLICY.table_error:g} % is allowed. Use "
                f"another parameter set or model: dehyst muscle lists them.",
                model=model.name,
            )
        rows, columns = finer_rows, finer_columns


def _forces(model: MuscleModel, pressure: Array, contraction: Array) -> Array:
    return np.ascontiguousarray(model.static_force(contraction[None, :], pressure[:, None]))


def _middles(points: Array) -> Array:
    return (points[1:] + points[:-1]) / 2
