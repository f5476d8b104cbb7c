"""Identifies the direct inverse of a joint, in torque, from its written logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.identification import Fit, identify_direct
from dehyst.io import read_log
from dehyst.models import GROUPS, DirectInverse
from dehyst.robot.experiments.recipes import Recipe

SHEARED, ANGLE, TIME, MEAN = "sheared_torque_Nm", "angle_rad", "time_s", "mean_pressure_bar"
TORQUE = "torque_Nm"
CURVE = 5  # degree of the curve over the angle that is no loop


def identify_torque(files: Sequence[Path], chosen: Recipe) -> Fit:
    """Fit a direct inverse to logs of a joint: angle -> torque of the muscles, sheared so that it rises with the angle.

    ``dehyst identify LOG --family direct-inverse --input sheared_torque_Nm --output angle_rad`` has the same code path.
    """
    records = [read_log(file, input=SHEARED, output=ANGLE, time=TIME) for file in files]
    by_mean = "mean_pressure" in chosen.schedules
    given = [read_log(file, input=MEAN, output=ANGLE, time=TIME).input for file in files] if by_mean else None
    return identify_direct(
        records,
        creep="auto" if chosen.time_constants else 0,
        creep_times=chosen.time_constants or None,
        mean_pressure=given,
        units={"mean_pressure": "bar"},
        initial_state="rest",
        train_fraction=1.0,
        position_schedule=not chosen.stops_only,
        stops_only=chosen.stops_only,
    )


def unsheared(model: DirectInverse, stiffness: float, low: float, high: float) -> DirectInverse:
    """Return tau(q) = u(q) - k q: the torque of a model that was fitted to u = tau + k q.

    Parameters
    ----------
    model
        q [rad] -> u [Nm].
    stiffness
        k. [Nm/rad]
    low, high
        Range of tau in the log. [Nm]

    Examples
    --------
    >>> model = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 60.0])
    >>> unsheared(model, 60.0, -1.0, 1.0).polynomial.tolist()
    [[0.0, 0.0]]
    """
    curve = np.array(model.polynomial)
    curve[:2, 0] -= stiffness * model.center  # the factors of two sets of a schedule add up to 1
    curve[:2, 1] -= stiffness
    signal = replace(model.card.input, name="torque_Nm", unit="Nm", low=low, high=high)
    return replace(model, polynomial=curve, card=replace(model.card, input=signal))


def without_time(model: DirectInverse, columns: Mapping[str, Array]) -> float:
    """Return the share of the loops that stops and path lags alone leave unexplained: std of the rest over std.

    Loops are what a curve over the angle does not explain. A joint without hysteresis has loops of creep and viscosity,
    which a direct inverse explains well; compensating them makes its largest error larger, so they do not count.

    Parameters
    ----------
    model
        q [rad] -> tau [Nm].
    columns
        A log by column name: ``angle_rad``, ``time_s``, ``torque_Nm``, ``mean_pressure_bar``.
    """
    q = columns[ANGLE]
    run = model.run(q, columns[TIME], given={"mean_pressure": columns[MEAN]})
    hysteresis = run.parts[:, [GROUPS.index(name) for name in ("short", "long")]].sum(axis=1)
    curves = np.vander((q - q.mean()) / max(float(np.ptp(q)), 1e-12), CURVE + 1)

    def loop(values: Array) -> float:
        return float(np.std(values - curves @ np.linalg.lstsq(curves, values, rcond=None)[0]))

    return loop(columns[TORQUE] - hysteresis) / max(loop(columns[TORQUE]), 1e-12)
