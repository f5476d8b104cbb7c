"""Timing of a test path: jerk-limited from rest to rest at a command speed, and slowed down to given limits."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol, Self, TypeVar

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Rows
from dehyst.errors import ParameterError
from dehyst_robot.iso9283._curves import Curve
from dehyst_robot.iso9283._paths import TestPath


def rest_to_rest(
    distance: float, speed: float, acceleration: float, jerk: float
) -> tuple[Array, Array]:
    """Return the seven phases of the fastest jerk-limited motion from rest to rest.

    With T_j the time of constant jerk and T_a that of the whole acceleration:

    - v j >= a^2: T_j = a/j, T_a = v/a + T_j; otherwise T_j = sqrt(v/j), T_a = 2 T_j;
    - cruising for (D - v T_a)/v; if that is negative, the peak speed is the root of D = v T_a.

    Closed form, so that it is exact, vectorised and without a dependency; the tests compare it with ruckig.

    Parameters
    ----------
    distance
        D > 0. [m]
    speed, acceleration, jerk
        Limits v, a, j > 0. [m/s, m/s^2, m/s^3]

    Returns
    -------
    duration : (7,)
        Of the phases; some may be zero. [s]
    jerk : (7,)
        In the phases: j, 0, -j, 0, -j, 0, j. [m/s^3]

    Examples
    --------
    >>> rest_to_rest(2.0, 1.0, 1.0, 2.0)[0].tolist()
    [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5]
    """
    d, v, a, j = distance, speed, acceleration, jerk

    def ramp(v: float) -> tuple[float, float]:
        """Return T_j and T_a up to a speed."""
        if v * j >= a * a:
            return a / j, v / a + a / j
        t_jerk = math.sqrt(v / j)
        return t_jerk, 2.0 * t_jerk

    if v * ramp(v)[1] > d:  # the speed limit is not reached
        if d * j * j >= 2.0 * a**3:
            v = 0.5 * a * (math.sqrt((a / j) ** 2 + 4.0 * d / a) - a / j)
        else:
            v = float(np.cbrt(0.25 * d * d * j))  # v = j T_j^2, D = 2 j T_j^3
    t_jerk, t_ramp = ramp(v)
    # Rounding must not make a phase of negative length.
    constant = max(t_ramp - 2.0 * t_jerk, 0.0)
    cruise = max(d / v - t_ramp, 0.0)
    duration = np.array([t_jerk, constant, t_jerk, cruise, t_jerk, constant, t_jerk])
    return duration, np.array([j, 0.0, -j, 0.0, -j, 0.0, j])


def leg_limits(
    curve: Curve, speed: float, acceleration: float, jerk: float
) -> tuple[float, float, float]:
    """Return the limits along a curve that keep the whole acceleration and jerk, bends included, within theirs.

    With r(s) run as s(t), kappa the curvature:

    - acceleration: s'' along the tangent, kappa s'^2 across; the bend may take a/sqrt(2), the tangent has the rest;
    - jerk: s''' - kappa^2 s'^3 along, 3 kappa s' s'' + kappa' s'^3 across. If their bound is beyond the limit, the leg
      is run slower as a whole (v, a, j times sigma, sigma^2, sigma^3), which keeps the command speed constant.

    Returns
    -------
    speed, acceleration, jerk : float
        Limits for s', s'', s'''. [m/s, m/s^2, m/s^3]

    Examples
    --------
    >>> from dehyst_robot.iso9283._curves import Straight
    >>> leg_limits(Straight(np.zeros(3), np.ones(3)), 0.25, 2.0, 20.0)
    (0.25, 2.0, 20.0)
    """
    v, a, j, kappa = speed, acceleration, jerk, curve.curvature
    if kappa == 0.0:
        return v, a, j
    # The bend gets a/sqrt(2) at most, the tangent the rest of the acceleration and half of the jerk.
    v = min(v, math.sqrt(a / (math.sqrt(2.0) * kappa)))
    a = math.sqrt(a * a - (kappa * v * v) ** 2)
    j = 0.5 * j
    worst = math.hypot(j + kappa**2 * v**3, 3.0 * kappa * v * a + curve.curvature_rate * v**3)
    sigma = min(1.0, float(np.cbrt(jerk / worst)))
    return sigma * v, sigma**2 * a, sigma**3 * j


class Timing(Protocol):
    """Members of a motion in repeating cycles that a trial uses: `Timed` along a path, or joints along a reference."""

    @property
    def factor(self) -> float:
        """Factor of all times to those of the original motion."""

    @property
    def duration(self) -> float:
        """Duration of one cycle. [s]"""

    @property
    def figure_names(self) -> tuple[str, ...]:
        """Names of the parts that are evaluated separately."""

    def slower(self, factor: float) -> Self:
        """Return the same motion, `factor` times as long as this one."""

    def figure(self, t: npt.ArrayLike, /) -> Rows:
        """Return the index of the part at times t (T,), -1 between two."""

    def cycle(self, t: npt.ArrayLike, /) -> Rows:
        """Return the number of the cycle at times t (T,), from 0."""


AnyTiming = TypeVar("AnyTiming", bound=Timing)


class PathMotion(NamedTuple):
    """Arc length and its derivatives by time, (T,) each."""

    s: Array  # [m], within the cycle
    speed: Array  # [m/s]
    acceleration: Array  # [m/s^2]
    jerk: Array  # [m/s^3]


class Steady(NamedTuple):
    """Range of a leg that is run at its command speed."""

    leg: int
    speed: float  # [m/s]
    start: float  # arc length within the leg, [m]
    stop: float


@dataclass(frozen=True, eq=False)
class Timed:
    """A test path with its speed law; cycles repeat for ever. Made by `timed`.

    Times before zero give the start. At a `factor` f the same motion takes f times as long, rests too.

    Attributes
    ----------
    path
        The test path.
    factor
        Times are this much longer than at the command speed.
    steady
        For each leg of the path, where it is run at its command speed, and that speed, at factor 1.
    start, s, speed, acceleration, jerk
        (P,) phases of constant jerk at factor 1: when each begins, and arc length, speed, acceleration and jerk then.
    leg
        (P,) the leg of each phase; a rest belongs to the leg before it.
    cycle_time
        Duration of one cycle at factor 1. [s]
    """

    path: TestPath
    factor: float
    steady: tuple[Steady, ...]
    start: Array
    s: Array
    speed: Array
    acceleration: Array
    jerk: Array
    leg: Rows
    cycle_time: float

    @property
    def duration(self) -> float:
        """Duration of one cycle. [s]"""
        return self.factor * self.cycle_time

    @property
    def figure_names(self) -> tuple[str, ...]:
        """Names of the path's figures."""
        return tuple(figure.name for figure in self.path.figures)

    def slower(self, factor: float) -> Timed:
        """Return the same motion, `factor` times as long as this one."""
        if not (math.isfinite(factor) and factor > 0):
            raise ParameterError(
                f"a time factor of {factor} is no motion; pass a positive one, such as 10."
            )
        return replace(self, factor=self.factor * factor)

    def _elapsed(self, t: npt.ArrayLike) -> Array:
        """Return times since the start of the first cycle, at factor 1."""
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        return np.asarray(np.maximum(times, 0.0) / self.factor)

    def _phase(self, t: npt.ArrayLike) -> tuple[Rows, Array]:
        """Return the phase of each time and the time in it, at factor 1."""
        tau = np.mod(self._elapsed(t), self.cycle_time)
        phase = np.searchsorted(self.start, tau, side="right").astype(np.int64) - 1
        return phase, tau - self.start[phase]

    def motion(self, t: npt.ArrayLike) -> PathMotion:
        """Return arc length within the cycle, speed, acceleration and jerk along the path at times t (T,)."""
        k, dt = self._phase(t)
        s0, v0, a0, j = self.s[k], self.speed[k], self.acceleration[k], self.jerk[k]
        f = self.factor
        # Constant jerk within a phase; each derivative by time has a factor more in its denominator.
        return PathMotion(
            s0 + dt * (v0 + dt * (a0 / 2.0 + dt * j / 6.0)),
            (v0 + dt * (a0 + dt * j / 2.0)) / f,
            (a0 + dt * j) / f**2,
            j / f**3,
        )

    def on_leg(self, t: npt.ArrayLike) -> Rows:
        """Return the index of the leg at times t (T,); the rest after a leg belongs to it."""
        return self.leg[self._phase(t)[0]]

    def position(self, t: npt.ArrayLike) -> Array:
        """Return the commanded points (T, 3). [m]"""
        return self.path.position(self.motion(t).s)

    def state(self, t: npt.ArrayLike) -> tuple[Array, Array, Array]:
        """Return commanded position, velocity and acceleration in space, (T, 3) each. [m, m/s, m/s^2]"""
        motion = self.motion(t)
        position, tangent, bend = self.path.chain.at(motion.s)
        v = motion.speed[:, None]
        a = motion.acceleration[:, None]
        return position, tangent * v, tangent * a + bend * v**2

    def figure(self, t: npt.ArrayLike) -> Rows:
        """Return the index of the figure at times t (T,), -1 on a transfer; the rest after a figure belongs to it."""
        return self.path.figure_of_leg[self.on_leg(t)]

    def cycle(self, t: npt.ArrayLike) -> Rows:
        """Return the number of the cycle at times t (T,), from 0."""
        return np.floor_divide(self._elapsed(t), self.cycle_time).astype(np.int64)

    def command_speed(self, figure: int) -> float:
        """Return the command speed of a figure: the smallest of its legs. [m/s]"""
        return min(self.steady[k].speed for k in self._legs_of(figure)) / self.factor

    def share_at_command_speed(self, figure: int) -> float:
        """Return the share of a figure's length that is run at the command speed; ISO 9283 asks for 0.5 or more."""
        legs = self._legs_of(figure)
        steady = length = 0.0
        for k in legs:
            steady += self.steady[k].stop - self.steady[k].start
            length += self.path.legs[k].curve.length
        return steady / length

    def steady_ranges(self, figure: int) -> list[tuple[float, float]]:
        """Return where a figure is run at its command speed: ranges of its arc length, one a stroke. [m]"""
        ranges = []
        for k in self._legs_of(figure):
            offset = self.path.legs[k].offset
            ranges.append((offset + self.steady[k].start, offset + self.steady[k].stop))
        return ranges

    def _legs_of(self, figure: int) -> list[int]:
        return [k for k, leg in enumerate(self.path.legs) if leg.figure == figure]


def timed(
    path: TestPath, speed: float, acceleration: float, jerk: float, rest: float, factor: float = 1.0
) -> Timed:
    """Give a test path its speed law: every leg from rest to rest in seven phases, then a rest.

    Acceleration and jerk are limits on the whole vector, bends included. A leg with a sharp bend (small circle, rounded
    corners) gets a lower command speed for that, constant over the leg; `Timed.command_speed` says which.

    Parameters
    ----------
    path
        The way.
    speed
        Command speed along the path. [m/s]
    acceleration, jerk
        Limits on the length of the acceleration and jerk vectors. [m/s^2, m/s^3]
    rest
        Time at rest after every leg. [s]
    factor
        Factor of all times: 10 is the paper's slow trial.

    Returns
    -------
    Timed
        A cycle of it can be repeated.

    Examples
    --------
    >>> from dehyst_robot.iso9283 import TestCube, test_path
    >>> fast = timed(test_path(TestCube(0.4, [0.6, 0.0, 0.9]), 0.03), 0.25, 2.0, 40.0, rest=1.0)
    >>> slow = fast.slower(10.0)
    >>> bool(np.allclose(slow.position([50.0]), fast.position([5.0])))
    True
    """
    for name, value in (
        ("speed", speed),
        ("acceleration", acceleration),
        ("jerk", jerk),
        ("factor", factor),
    ):
        if not (math.isfinite(value) and value > 0):
            raise ParameterError(
                f"{name} = {value} along the path; nothing moves. Pass a positive number."
            )
    if not (math.isfinite(rest) and rest >= 0):
        raise ParameterError(f"rest = {rest} s; pass zero or more.")
    tables = []
    steady = []
    for k, (leg, start) in enumerate(zip(path.legs, path.chain.starts.tolist(), strict=True)):
        limits = leg_limits(leg.curve, speed, acceleration, jerk)
        rows, steady_range = _leg_phases(k, leg.curve.length, *limits, rest, start)
        tables.append(rows)
        steady.append(steady_range)
    table = np.concatenate(tables)
    ends = np.cumsum(table[:, 0])
    starts = np.concatenate(([0.0], ends[:-1]))
    _, s, v, a, j, leg_of_phase = table.T
    return Timed(
        path=path,
        factor=factor,
        steady=tuple(steady),
        start=starts,
        s=s,
        speed=v,
        acceleration=a,
        jerk=j,
        leg=leg_of_phase.astype(np.int64),
        cycle_time=float(ends[-1]),
    )


def _leg_phases(
    leg: int,
    length: float,
    speed: float,
    acceleration: float,
    jerk: float,
    rest: float,
    origin: float,
) -> tuple[Array, Steady]:
    """Return the phases of a leg and its steady range.

    A phase is a row: duration, s and its three derivatives at its start, leg. The rest is the last one.
    """
    duration, jerks = rest_to_rest(length, speed, acceleration, jerk)
    rows = []
    s = v = a = 0.0
    for dt, j in zip(duration, jerks, strict=True):
        rows.append((dt, origin + s, v, a, j, leg))
        s += dt * (v + dt * (a / 2.0 + dt * j / 6.0))
        v += dt * (a + dt * j / 2.0)
        a += dt * j
    rows.append((rest, origin + length, 0.0, 0.0, 0.0, leg))
    # The fourth phase is the cruise; it may have no length.
    cruise, braking = rows[3], rows[4]
    steady = Steady(
        leg,
        speed=float(cruise[2]),
        start=float(cruise[1] - origin),
        stop=float(braking[1] - origin),
    )
    phases = np.array(rows)
    return phases[phases[:, 0] > 0.0], steady


def slow_down_to(
    motion: AnyTiming,
    utilisation: Callable[[AnyTiming], float],
    tolerance: float = 0.01,
    largest: float = 100.0,
) -> AnyTiming:
    """Slow a motion down just enough for its limits.

    Finds the smallest factor f >= 1 at which the utilisation is at most 1, to within `tolerance` of f. It divides a
    bracket at the root of the model u = c + d/f^2 through its ends (static load and inertia), every third time in the
    middle. The factor that is returned has been evaluated and keeps the limits.

    Parameters
    ----------
    motion
        The motion at its desired speed.
    utilisation
        Largest use of a limit by a motion: required pressure over the largest pressure, valve flow over the largest
        flow. It must fall as the motion gets slower.
    tolerance
        Relative width of the bracket at which the search ends.
    largest
        Largest factor to try.

    Returns
    -------
    motion
        The same, or a slower one.

    Raises
    ------
    ParameterError
        If the limits are broken even at the largest factor: then it is the load, not the speed. If the utilisation is
        not a finite number.

    Examples
    --------
    >>> from dehyst_robot.iso9283 import TestCube, test_path
    >>> fast = timed(test_path(TestCube(0.4, [0.6, 0.0, 0.9]), 0.03), 0.25, 2.0, 40.0, rest=1.0)
    >>> slower = slow_down_to(fast, lambda motion: 0.5 + 2.0 / motion.factor**2)
    >>> 2.0 <= slower.factor <= 2.02
    True
    """

    def use(factor: float) -> float:
        value = float(utilisation(motion.slower(factor)))
        if not math.isfinite(value):
            raise ParameterError(
                f"the utilisation at {factor:g} times the duration is {value}; it must be a number."
            )
        return value

    low = 1.0
    use_low = use(low)
    if use_low <= 1.0:
        return motion
    # A utilisation that is all inertia falls with the square of the factor; a fifth more makes an upper end likely.
    high = min(1.2 * math.sqrt(use_low), largest)
    use_high = use(high)
    while use_high > 1.0:
        if high >= largest:
            raise ParameterError(
                f"the path breaks the limits by a factor of {use_high:.3g} even at {largest:g} times the duration, so "
                f"it is the load and the posture, not the speed. Move the test cube, make it or reference.range_share "
                f"smaller, or lower the payload.",
                utilisation=use_high,
            )
        low, use_low, high = high, use_high, min(2.0 * high, largest)
        use_high = use(high)
    # A guess is moved a little beyond the root, so that the other end of the bracket comes near, too.
    nudge = 1.0 + 0.4 * tolerance
    tries = 0
    while high > low * (1.0 + tolerance):
        tries += 1
        factor = _inertial_guess(low, use_low, high, use_high) * nudge
        # Even where the model is wrong, the bracket shrinks.
        if tries % 3 == 0 or not low < factor < high:
            factor = math.sqrt(low * high)
        value = use(factor)
        if value <= 1.0:
            high, use_high, nudge = factor, value, 1.0 - 0.4 * tolerance
        else:
            low, use_low, nudge = factor, value, 1.0 + 0.4 * tolerance
    return motion.slower(high)


def _inertial_guess(low: float, use_low: float, high: float, use_high: float) -> float:
    """Return f with u(f) = 1 for u = c + d/f^2 through both ends of the bracket."""
    # use_low > 1 >= use_high: the denominator is positive.
    x_low, x_high = low**-2.0, high**-2.0
    x = x_high + (1.0 - use_high) * (x_low - x_high) / (use_low - use_high)
    return math.sqrt(1.0 / x)
