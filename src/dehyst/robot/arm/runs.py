"""What joints shall do, and what they did: references and logs of the closed loop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError

Switches = npt.NDArray[np.uint32]

_WRONG = "angle_lost angle_jump angle_frozen pressure_lost pressure_jump pressure_frozen reference_lost supply_lost"
# Added to the switches of a knot: what goes wrong from there to the next.
FAULTS: Mapping[str, int] = MappingProxyType({name: 1 << (16 + bit) for bit, name in enumerate(_WRONG.split())})
COLUMNS = 8  # of a reference: angle, velocity, acceleration, load, mean pressure, pressure difference, extra, hung


@dataclass(frozen=True, eq=False)
class Reference:
    """What the joints shall do, at knots of equal spacing; between them the loop interpolates.

    Attributes
    ----------
    spacing
        Time between knots, a multiple of the control period. [s]
    values
        (K, n, 8): angle [rad], velocity [rad/s], acceleration [rad/s^2], load torque that the controller knows [Nm],
        mean pressure [Pa], pressure difference [Pa], extra compensation [Pa] and torque that is hung on the joint [Nm],
        of the n moving joints.
    switches
        (K, n) what is switched on from each knot on: see `dehyst.robot.control`; plus values of `FAULTS`, what goes
        wrong with sensors and reference until the next knot.

    Examples
    --------
    One joint, 0.2 bar more in its first muscle than in its second, for 1 s:

    >>> zero = np.zeros((101, 1))
    >>> Reference.pressures(0.01, difference=zero + 2e4, mean=zero + 3e5, hung=zero).duration
    1.0
    """

    spacing: float
    values: Array
    switches: Switches

    @classmethod
    def pressures(cls, spacing: float, difference: Array, mean: Array, hung: Array, switches: int = 0) -> Reference:
        """Pressures are applied as they are, without position control; difference, mean [Pa] and torque, (K, n)."""
        values = np.zeros((*difference.shape, COLUMNS))
        values[:, :, 4] = mean
        values[:, :, 5] = difference
        values[:, :, 7] = hung
        return cls(spacing, values, np.full(difference.shape, switches, np.uint32))

    @classmethod
    def motion(
        cls,
        spacing: float,
        motion: tuple[Array, Array, Array],
        load: Array,
        mean: float,
        switches: int | Switches,
        extra: Array | float = 0.0,
        hung: Array | float = 0.0,
    ) -> Reference:
        """Position control along angle, velocity and acceleration, each (K, n), with the load torque (K, n)."""
        values = np.zeros((*load.shape, COLUMNS))
        for column, signal in enumerate((*motion, load)):
            values[:, :, column] = signal
        values[:, :, 4] = mean
        values[:, :, 6] = extra
        values[:, :, 7] = hung
        return cls(spacing, values, np.broadcast_to(np.asarray(switches, np.uint32), load.shape))

    @property
    def duration(self) -> float:
        """From the first to the last knot. [s]"""
        return float(self.spacing * (self.values.shape[0] - 1))

    def sampled(self, period: float) -> Reference:
        """Return the same reference with a knot at every control period, to the bit as the loop interpolates it.

        Cubic in the angle with the given velocities at the knots, linear in everything else.

        Examples
        --------
        >>> coarse = Reference.pressures(0.01, *(np.linspace(0.0, 1.0, 3)[:, None] for _ in range(3)))
        >>> coarse.sampled(0.0025).values[:, 0, 5].tolist()
        [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0]
        """
        ticks = round(self.spacing / period)
        span = period * ticks
        count = (self.values.shape[0] - 1) * ticks
        knot = np.arange(count) // ticks
        s = (np.arange(count) % ticks / ticks)[:, None]
        a, b = self.values[knot], self.values[knot + 1]
        u, s2 = 1 - s, s * s
        values = u[..., None] * a + s[..., None] * b
        q_a, v_a, q_b, v_b = a[..., 0], a[..., 1], b[..., 0], b[..., 1]
        values[..., 0] = (
            (1 + 2 * s) * u * u * q_a + s * u * u * span * v_a + s2 * (3 - 2 * s) * q_b - s2 * u * span * v_b
        )
        values[..., 1] = 6 * s * u * (q_b - q_a) / span + u * (1 - 3 * s) * v_a + s * (3 * s - 2) * v_b
        return Reference(period, np.concatenate([values, self.values[-1:]]), self.switches[[*knot, -1]])

    def ticks(self, moving: tuple[int, ...], period: float) -> int:
        """Return the control periods from knot to knot; a reference that these joints cannot follow is refused."""
        shape = np.shape(self.values)
        if len(shape) != 3 or shape[0] < 2 or shape[1:] != (len(moving), COLUMNS):
            raise ParameterError(
                f"a reference of shape {shape} does not belong to the {len(moving)} moving joints {moving}: "
                f"pass two knots or more, (K, {len(moving)}, {COLUMNS}).",
                shape=shape,
            )
        if np.shape(self.switches) != shape[:2]:
            raise ParameterError(
                f"switches of shape {np.shape(self.switches)} for {shape[0]} knots of {shape[1]} joints: pass one "
                f"a knot and joint, {shape[:2]}.",
                shape=np.shape(self.switches),
            )
        if not np.isfinite(self.values).all():
            knot = int(np.flatnonzero(~np.isfinite(self.values).all(axis=(1, 2)))[0])
            raise ParameterError(
                f"the reference is not finite at knot {knot}: the arm cannot be told to go there. Remove the NaN.",
                knot=knot,
            )
        ticks = round(self.spacing / period) if np.isfinite(self.spacing) else 0
        if ticks < 1 or abs(ticks * period - self.spacing) > 1e-6 * self.spacing:
            raise ParameterError(
                f"knots lie {self.spacing} s apart, which is no multiple of the control period, {period} s: the "
                f"arm would run at another speed. Choose another spacing, or a simulation.period_s that divides it.",
                spacing=self.spacing,
                period=period,
            )
        return ticks


@dataclass(frozen=True, eq=False)
class ArmLog:
    """What was logged in one run: rows (T,), the n moving joints (T, n), SI units.

    Attributes
    ----------
    time
        From the start of the run. [s]
    desired, angle
        Reference and true angle at the time of the row. [rad]
    measured
        Encoder, mean over the row's interval. [rad]
    torque
        Of the drive. [Nm]
    pressure
        (T, n, 2) measured gauge pressures, mean over the row's interval. [Pa]
    pressure_difference, compensation
        Desired dp, under a controller of one's own the measured one, and the compensator's part of it. [Pa]
    integrator, torque_desired, load
        Integrator's part, desired torque, observed disturbance. [Nm]
    contact, doubt
        What of the disturbance a direct inverse does not explain, and what its torque can be wrong by. [Nm]
    hysteresis, offset
        What there is of the hysteresis over that of the compensator's model, 1 until it is known; torque beyond the
        model that is the same both ways. [Nm]
    scale, scales
        Of the compensator while its model does not fit; of the groups of a direct inverse, (T, n, groups), in use.
    flags
        Flags of the controllers, collected since the row before.
    """

    time: Array
    desired: Array
    angle: Array
    measured: Array
    torque: Array
    pressure: Array
    pressure_difference: Array
    compensation: Array
    integrator: Array
    torque_desired: Array
    load: Array
    contact: Array
    doubt: Array
    hysteresis: Array
    offset: Array
    scale: Array
    scales: Array
    flags: npt.NDArray[np.int64]

    @classmethod
    def unpack(cls, time: Array, log: Array) -> ArmLog:
        """From the loop's own order of columns, (T, n, 25)."""
        column = np.moveaxis(log, 2, 0)
        return cls(
            time, column[0], column[1], column[2], column[3], log[:, :, 4:6], column[6], column[7], column[8],
            column[9], column[10], column[11], column[12], column[14], column[15], column[16], log[:, :, 17:],
            column[13].astype(np.int64),
        )  # fmt: skip

    def until(self, end: float) -> ArmLog:
        """Return the rows before a time. [s]"""
        kept = int(np.searchsorted(self.time, end))
        return ArmLog(**{column.name: getattr(self, column.name)[:kept] for column in fields(self)})
