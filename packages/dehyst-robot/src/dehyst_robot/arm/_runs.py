"""References and logs of the closed loop: what joints shall do, and what they did."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError

Switches = npt.NDArray[np.uint32]

_FAULT_NAMES = (
    "angle_lost angle_jump angle_frozen pressure_lost pressure_jump pressure_frozen "
    "reference_lost supply_lost"
)
# Added to the switches of a knot, which have the lower 16 bits: faults from there to the next.
FAULTS: Mapping[str, int] = MappingProxyType(
    {name: 1 << (16 + bit) for bit, name in enumerate(_FAULT_NAMES.split())}
)
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
        (K, n) what is switched on from each knot on: see `dehyst_robot.control`; plus values of `FAULTS`, what goes
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
    def pressures(
        cls, spacing: float, difference: Array, mean: Array, hung: Array, switches: int = 0
    ) -> Reference:
        """Pressures are applied as they are, without position control; difference, mean [Pa] and torque, (K, n)."""
        # Columns of a motion stay 0: nothing reads them while pressures are applied.
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
        # s is the share of the way from knot a to knot b, u the share that is left.
        ticks = round(self.spacing / period)
        span = period * ticks
        count = (self.values.shape[0] - 1) * ticks
        knot = np.arange(count) // ticks
        s = (np.arange(count) % ticks / ticks)[:, None]
        a, b = self.values[knot], self.values[knot + 1]
        u, s2 = 1 - s, s * s
        values = u[..., None] * a + s[..., None] * b
        q_a, v_a = a[..., 0], a[..., 1]
        q_b, v_b = b[..., 0], b[..., 1]
        # Cubic Hermite polynomial and its derivative; the order of the operations is that of the C code.
        values[..., 0] = (
            (1 + 2 * s) * u * u * q_a
            + s * u * u * span * v_a
            + s2 * (3 - 2 * s) * q_b
            - s2 * u * span * v_b
        )
        values[..., 1] = (
            6 * s * u * (q_b - q_a) / span + u * (1 - 3 * s) * v_a + s * (3 * s - 2) * v_b
        )
        return Reference(
            period, np.concatenate([values, self.values[-1:]]), self.switches[[*knot, -1]]
        )

    def ticks(self, moving: tuple[int, ...], period: float) -> int:
        """Return the control periods from knot to knot; refuse a reference that does not fit these joints."""
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
        ticks = 0
        if np.isfinite(self.spacing):
            ticks = round(self.spacing / period)
        # Rounding of decimal fractions is allowed, another speed of the arm is not.
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
    """Log of one run: rows (T,), the n moving joints (T, n), SI units.

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
        Part of the disturbance that a direct inverse does not explain, and the possible error of its torque. [Nm]
    hysteresis, offset
        Ratio of the present hysteresis to that of the compensator's model, 1 until it is estimated; torque beyond the
        model that is the same in both directions. [Nm]
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
        """Return the log of rows (T, n, 25), whose columns are in the order of the loop in C."""
        column = np.moveaxis(log, 2, 0)
        return cls(
            time, column[0], column[1], column[2], column[3], log[:, :, 4:6], column[6], column[7], column[8],
            column[9], column[10], column[11], column[12], column[14], column[15], column[16], log[:, :, 17:],
            column[13].astype(np.int64),
        )  # fmt: skip

    def until(self, end: float) -> ArmLog:
        """Return the rows before a time. [s]"""
        count = int(np.searchsorted(self.time, end))
        columns = {}
        for column in fields(self):
            columns[column.name] = getattr(self, column.name)[:count]
        return ArmLog(**columns)
