"""The characteristic that a compensator stands on: as calibrated, or bent to the loop at the mean pressure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from dehyst.arrays import Array
from dehyst.experiments.loops_run import BAR
from dehyst.experiments.recipes import Recipe
from dehyst.experiments.results import Characteristic
from dehyst.plant.parameters import Robot

MOST_DEGREE = 7  # of a polynomial in the controller: DEHYST_DEGREE - 1 of core/dehyst.h


def backbones_of(robot: Robot, calibrated: Mapping[int, Characteristic], chosen: Recipe) -> dict[int, Characteristic]:
    """Return joint number -> characteristic that a recipe's compensator stands on."""
    return {n: local_characteristic(robot, one) if chosen.local else one for n, one in calibrated.items()}


def local_characteristic(robot: Robot, found: Characteristic) -> Characteristic:
    """Return the characteristic bent to the polynomial dp(q) through the loop at the mean pressure without load.

    It reaches that mean pressure's loop exactly, and swallows part of its hysteresis: the polynomial bends towards the
    loop's tips. Only C is changed. If there is no sweep at the mean pressure, it is the loop of the nearest one.
    """
    q, dp, mean, torque = _unloaded_sweep(found, robot.controller.mean_pressure).T
    degree = robot.calibration.degree
    value = np.polynomial.polynomial.polyval
    fitted = np.polynomial.polynomial.polyfit(q, dp, degree)
    c = torque - value(q, found.a) * mean - value(q, found.b) * value(q, fitted)
    return replace(found, c=np.polynomial.polynomial.polyfit(q, c, min(degree + 2, MOST_DEGREE)))


def _unloaded_sweep(found: Characteristic, mean: float) -> Array:
    """The sweep nearest to the mean pressure and, among those, with the smallest torque."""

    def distance(sweep: Array) -> tuple[int, float]:
        return round(abs(float(sweep[:, 2].mean()) - mean) / (0.1 * BAR)), float(np.abs(sweep[:, 3]).mean())

    return min(found.sweeps, key=distance)
