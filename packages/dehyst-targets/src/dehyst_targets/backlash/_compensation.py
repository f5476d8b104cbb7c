"""What a machine adds to its commands, and what that leaves of the errors that were measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.units import convert
from dehyst_targets.backlash._lost_motion import LostMotion


@dataclass(frozen=True, eq=False)
class Compensation:
    """What a machine adds to a commanded position, for each direction of motion.

    Between nominal points it is a straight line, beyond the first and the last one it stays as it is there. A single
    point is a constant. An ideal one is the negative error, ``added = -(actual - commanded)``.

    Attributes
    ----------
    nominal
        Commanded positions, (n,), rising. [unit]
    rising, falling
        Added while the commanded position rises or falls, (n,). [unit]

    Examples
    --------
    >>> play = Compensation(np.zeros(1), np.array([0.02]), np.array([-0.02]))
    >>> play.added(np.array([0.0, 100.0]), rising=True).tolist()
    [0.02, 0.02]
    """

    nominal: Array
    rising: Array
    falling: Array

    def added(self, commanded: Array, *, rising: bool) -> Array:
        """Return what is added to commanded positions (k,) in one direction, (k,). [unit]"""
        values = self.falling
        if rising:
            values = self.rising
        return np.interp(commanded, self.nominal, values)

    def converted(self, source: str, target: str) -> Compensation:
        """Return the same compensation in another unit of length or angle."""
        factor = 1.0
        if source != target:
            factor = float(convert(1.0, source, target))
        return Compensation(factor * self.nominal, factor * self.rising, factor * self.falling)

    def left(self, lost: LostMotion) -> tuple[Array, Array]:
        r"""Return the errors, rising and falling, that are left at the points of a measurement, (n,) each. [unit]

        With the error :math:`e(x)` of one direction, :math:`e_{left}(x) = a(x) + e(x + a(x))` where :math:`a` is
        added. The mean of both directions at `LostMotion.reference` is taken away, as in the measurement.
        """
        errors = []
        for rising, measured in ((True, lost.rising), (False, lost.falling)):
            added = self.added(lost.nominal, rising=rising)
            # The axis is sent to another place, and errs there as it was measured there.
            errors.append(added + np.interp(lost.nominal + added, lost.nominal, measured))
        shift = 0.5 * (errors[0][lost.reference] + errors[1][lost.reference])
        return errors[0] - shift, errors[1] - shift


def compensation_for(lost: LostMotion, *, one_number: bool) -> Compensation:
    """Return the compensation of a measurement: over position, or one number for the whole axis.

    Lost motion within the repeatability is not compensated: then both directions get the mean error. The one number
    is the mean lost motion, half of it to either side.

    Examples
    --------
    >>> lost = LostMotion.example()
    >>> compensation_for(lost, one_number=True).rising.round(4).tolist()
    [0.0199]
    """
    if one_number:
        # Which side an axis is homed from is not known here, so that each side gets half.
        half = np.array([0.5 * lost.mean])
        return Compensation(np.zeros(1), half, -half)
    if not lost.is_significant:
        # A table of chance would add errors that are not there.
        return Compensation(lost.nominal, -lost.middle, -lost.middle)
    return Compensation(lost.nominal, -lost.rising, -lost.falling)
