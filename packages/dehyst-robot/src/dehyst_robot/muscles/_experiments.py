"""Simulated experiments on a muscle model: static force map, slow loops, quick release, force over speed.

Everything is in SI units, pressures are gauge, contractions are (l_0 - l)/l_0. Hill's curve of a living muscle,
(F + a)(v + b) = (F_0 + a) b, is fitted to the forces at speed, because some of the models were made to follow it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst_robot.muscles._base import Memory, MuscleModel

FURTHEST = 0.6  # contraction; no muscle goes beyond, whatever its formula does there
TOLERANCE = 1e-10  # of a contraction
STROKE = 120  # samples of a stroke of a loop
GRAVITY = 9.81  # m/s^2
FASTEST = 10.0  # m/s; a muscle that still pulls at this speed is not limited by it
LEAD = 0.04  # contraction over which a steady speed is held before the force is read
SHARES = (0.2, 0.4, 0.6, 0.8)  # of the blocked force, loads after the release
STEPS = 3000  # of a release


@dataclass(frozen=True, eq=False)
class ForceMap:
    """Static forces over contraction and pressure, and figures of the muscle from them.

    Attributes
    ----------
    contraction, pressure
        (n,); (m,). [1], [Pa]
    force
        (n, m), without friction; negative where the formula is, though a muscle does not push. [N]
    blocked
        (m,) at contraction 0. [N]
    free
        (m,) contraction at which the force is zero; NaN where the formula never gets there.
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
    >>> from dehyst_robot.muscles import muscle
    >>> forces = force_map(muscle("tondu-lopez"), [0.0, 0.1, 0.2], [1e5, 3e5])
    >>> forces.force.shape, bool(forces.free[0] == forces.free[1])
    ((3, 2), True)
    """
    k = np.atleast_1d(np.asarray(contraction, float))
    p = np.atleast_1d(np.asarray(pressure, float))
    force = model.static_force(k[:, None], p[None, :])
    free = np.array([free_contraction(model, pressure_i) for pressure_i in p.tolist()])
    # Where there is no free contraction, the stiffness is that at 10 %.
    half = np.where(np.isfinite(free), 0.5 * free, 0.1)
    h = 1e-4  # step of the difference quotient
    slope = (model.static_force(half + h, p) - model.static_force(half - h, p)) / (2 * h)
    return ForceMap(
        k, p, force, model.static_force(np.zeros(p.size), p), free, -slope / model.length
    )


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
    >>> from dehyst_robot.muscles import muscle
    >>> round(free_contraction(muscle("tondu-lopez"), 3e5), 3)
    0.297
    """
    low, high = contraction_reach(model)
    grid = np.linspace(low, high, 241)
    # The first place where the force falls below the load: behind it a formula may rise again.
    left = model.static_force(grid, np.full(grid.size, pressure)) - load
    falls = np.flatnonzero((left[:-1] > 0) & (left[1:] <= 0))
    if not falls.size:
        return math.nan
    i = int(falls[0])
    root = brentq(
        lambda k: float(model.static_force(k, pressure)) - load,
        grid[i],
        grid[i + 1],
        xtol=TOLERANCE,
    )
    return float(root)


def contraction_reach(model: MuscleModel) -> tuple[float, float]:
    """Return the range of contractions of all experiments: 0 to `FURTHEST`, or to the limits of the formulas."""
    low, high = model.limits
    inside = 1e-9 * (high - low)
    return max(0.0, low + inside), min(FURTHEST, high - inside)


def lowest_pressure(model: MuscleModel, load: float, highest: float) -> float:
    """Return the lowest pressure at which a muscle of its length at rest carries a load, NaN if there is none.

    Parameters
    ----------
    model
        Any muscle model.
    load
        Pull. [N]
    highest
        Highest pressure of the search. [Pa]
    """
    grid = np.linspace(0.0, highest, 61)
    left = model.static_force(np.zeros(grid.size), grid) - load
    if left[0] >= 0:
        return 0.0
    rises = np.flatnonzero((left[:-1] < 0) & (left[1:] >= 0))
    if not rises.size:
        return math.nan
    i = int(rises[0])
    return float(
        brentq(lambda p: float(model.static_force(0.0, p)) - load, grid[i], grid[i + 1], xtol=1e-3)
    )


@dataclass(frozen=True, eq=False)
class Loop:
    """One closed cycle of a slow motion; a cycle before it has erased the memory of the start.

    Attributes
    ----------
    held
        The constant one: the pressure [Pa] or the load [N].
    drive, response
        (T,) contraction and force [N] of an isobaric loop, pressure [Pa] and contraction of an isotonic one; up first.
    time
        (T,) [s], or None if it was infinitely slow.
    width
        Largest distance of the two branches. [response]
    width_percent
        The same in percent of the response's range.
    asymmetry_percent
        Difference of the loop's area over the upper and over the lower half of the drive, in percent of the area: 0 for
        a loop that is point-symmetric, 100 if all of it lies over the upper half.
    """

    held: float
    drive: Array
    response: Array
    time: Array | None
    width: float
    width_percent: float
    asymmetry_percent: float


def isobaric_loop(
    model: MuscleModel,
    pressure: float,
    low: float,
    high: float,
    *,
    period: float | None = None,
    cycles: int = 2,
) -> Loop:
    """Return the force over a contraction that goes up and down at constant speed, at constant pressure.

    Parameters
    ----------
    model
        Any muscle model.
    pressure
        Constant. [Pa]
    low, high
        Contractions between which it moves; it starts at rest at the first.
    period
        Of a cycle; None: infinitely slow, so that only hysteresis shows. [s]
    cycles
        Of which the last one is returned.

    Raises
    ------
    ParameterError
        If the contractions are not in order or outside the model's limits.

    Examples
    --------
    >>> from dehyst_robot.muscles import muscle
    >>> loop = isobaric_loop(muscle("tondu-lopez"), 3e5, 0.02, 0.2)
    >>> loop.width > 0
    True
    """
    _insist(
        low < high,
        f"the contraction cannot go from {low:g} to {high:g}: the first must be the lower one.",
    )
    drive, time = _strokes(low, high, period, cycles)
    force = model.simulate(drive, np.full(drive.size, float(pressure)), time)
    return _last_cycle(pressure, drive, force, time)


def isotonic_loop(
    model: MuscleModel,
    load: float,
    low: float,
    high: float,
    *,
    period: float | None = None,
    cycles: int = 2,
) -> Loop:
    """Return the contraction over a pressure that goes up and down while the muscle carries a constant load.

    At each sample the contraction is solved for which the force, friction included, is the load.

    Parameters
    ----------
    model
        Any muscle model.
    load
        Constant. [N]
    low, high
        Pressures between which it goes. [Pa]
    period, cycles
        As for `isobaric_loop`.

    Raises
    ------
    ParameterError
        If the pressures are not in order, or no contraction within the model's limits carries the load.

    Examples
    --------
    >>> from dehyst_robot.muscles import muscle
    >>> loop = isotonic_loop(muscle("tondu-lopez"), 150.0, 1e5, 5e5)
    >>> bool(np.ptp(loop.response) > 0.01)
    True
    """
    _insist(
        low < high,
        f"the pressure cannot go from {low:g} to {high:g} Pa: the first must be the lower one.",
    )
    drive, time = _strokes(low, high, period, cycles)
    start = free_contraction(model, low, load)
    if math.isnan(start):
        start = balance(model, model.rest(0.0), 0.0, low, math.nan, load)
    # Not a number for an infinitely slow motion, as in a memory.
    times = np.full(drive.size, math.nan)
    if time is not None:
        times = time
    memory = model.rest(start, float(times[0]))
    path = [start]
    for i in range(1, drive.size):
        p, t = float(drive[i]), float(times[i])
        path.append(balance(model, memory, path[-1], p, t, load))
        stamp = None
        if time is not None:
            stamp = [t]
        _, memory = model.run([path[-1]], [p], stamp, memory)
    return _last_cycle(load, drive, np.array(path), time)


def balance(
    model: MuscleModel, memory: Memory, near: float, pressure: float, time: float, load: float
) -> float:
    """Return the contraction, close to one, at which the force after moving there is the load."""

    def left(k: float) -> float:
        return model.force_after(memory, k, pressure, time) - load

    first = left(near)
    if first == 0.0:
        return near
    low, high = model.limits
    # A muscle that pulls more than the load shortens: steps that double, until the sign of the difference changes.
    step = math.copysign(1e-4, first)
    last = near
    while True:
        k = min(max(last + step, low), high)
        if (left(k) > 0) != (first > 0):
            return float(brentq(left, *sorted((last, k)), xtol=TOLERANCE))
        if k in (low, high):
            raise ParameterError(
                f"no contraction from {low:.3g} to {high:.3g} carries {load:.4g} N at {pressure / 1e5:.3g} bar: "
                f"{model.name} gives {left(k) + load:.4g} N at {k:.3g}. Take a smaller load, or a higher pressure.",
                load=load,
                pressure=pressure,
            )
        last = k
        step = 2.0 * step


def _strokes(
    low: float, high: float, period: float | None, cycles: int
) -> tuple[Array, Array | None]:
    """Return drive and time of cycles of two strokes, `STROKE` samples each, and the first sample."""
    _insist(
        (period is None or period > 0) and cycles >= 1,
        f"a period of {period} s and {cycles} cycles are no loop.",
    )
    stroke = np.linspace(0.0, 1.0, STROKE + 1)
    cycle = np.concatenate([stroke[1:], stroke[-2::-1]])
    share = np.concatenate([np.zeros(1), np.tile(cycle, cycles)])
    time = None
    if period is not None:
        time = np.linspace(0.0, period * cycles, share.size)
    return low + (high - low) * share, time


def _last_cycle(constant: float, drive: Array, response: Array, time: Array | None) -> Loop:
    x = drive[-2 * STROKE - 1 :]
    y = response[-2 * STROKE - 1 :]
    t = None
    if time is not None:
        t = time[: x.size]
    # Both branches over the same values of the drive.
    up, down = y[: STROKE + 1], y[: STROKE - 1 : -1]
    gap = np.abs(up - down)
    span = float(np.ptp(y))
    width = float(np.max(gap))
    lower = float(gap[: STROKE // 2].sum())
    upper = float(gap[STROKE // 2 + 1 :].sum())
    width_percent = tilt = 0.0
    if span > 0:
        width_percent = 100.0 * width / span
    # The asymmetry of a loop that has no width is rounding.
    if width > 1e-9 * span:
        tilt = 100.0 * (upper - lower) / (upper + lower)
    return Loop(float(constant), x, y, t, width, width_percent, tilt)


def _insist(holds: bool, message: str) -> None:
    if not holds:
        raise ParameterError(message)


def finite_or_none(value: float) -> float | None:
    """Return a number as JSON can hold it: None for nan and infinity."""
    if math.isfinite(value):
        return value
    return None


@dataclass(frozen=True, eq=False)
class Release:
    """Motion after a release: the latch opens, and the muscle moves a weight that is lighter than its force.

    Attributes
    ----------
    load, mass
        Left after the release. [N], [kg]
    time, contraction, speed
        (T,) from the release on, until the muscle hangs loose or the time is over; speed of shortening. [s], [1],
        [m/s]
    peak_speed
        Largest speed: there the force equals the load. [m/s]
    peak_contraction
        Contraction there.
    """

    load: float
    mass: float
    time: Array
    contraction: Array
    speed: Array
    peak_speed: float
    peak_contraction: float


@dataclass(frozen=True, eq=False)
class ForceVelocity:
    """Force while the muscle shortens at constant speeds through one contraction at one pressure.

    Attributes
    ----------
    pressure, contraction
        Of the experiment. [Pa], [1]
    speed, force
        (n,), speed from 0 on. [m/s], [N]
    isometric
        F_0, static. [N]
    fastest
        Speed at which the force is zero, NaN if there is none up to `FASTEST`. [m/s]
    damping
        Force lost on the first m/s, slope at the lowest speeds. [N s/m]
    hill
        a/F_0 and b [m/s] of Hill's curve through the forces; NaN where speed does not matter.
    hill_percent
        Error of the curve, rms in percent of F_0.
    """

    pressure: float
    contraction: float
    speed: Array
    force: Array
    isometric: float
    fastest: float
    damping: float
    hill: tuple[float, float]
    hill_percent: float

    def as_dict(self) -> dict[str, float | None]:
        """Return the figures, without the samples."""
        figures = {
            "pressure_Pa": self.pressure,
            "contraction": self.contraction,
            "isometric_N": self.isometric,
            "fastest_m_s": self.fastest,
            "damping_N_s_m": self.damping,
            "hill_a": self.hill[0],
            "hill_b_m_s": self.hill[1],
            "hill_percent": self.hill_percent,
        }
        return {name: finite_or_none(value) for name, value in figures.items()}


def quick_release(
    model: MuscleModel,
    pressure: float,
    load: float,
    *,
    contraction: float = 0.0,
    mass: float | None = None,
) -> Release:
    """Return the motion of a muscle that is released at a contraction and moves a weight.

    m dv/dt = F(kappa, p, v) - load, in steps a good deal shorter than those of the muscle's own oscillation.

    Parameters
    ----------
    model
        Any muscle model.
    pressure
        Constant. [Pa]
    load
        Left after the release, less than the force before it. [N]
    contraction
        Of the muscle before the release.
    mass
        That is moved; by default that of the weight, load/g. [kg]

    Examples
    --------
    >>> from dehyst_robot.muscles import muscle
    >>> model = muscle("tondu-lopez")
    >>> before = float(model.static_force(0.0, 3e5))
    >>> slow, fast = (quick_release(model, 3e5, share * before) for share in (0.8, 0.4))
    >>> fast.peak_speed > slow.peak_speed
    True
    """
    before = float(model.static_force(contraction, pressure))
    if not 0 < load < before:
        raise ParameterError(
            f"a load of {load:.4g} N is not between 0 and the {before:.4g} N that {model.name} pulls at contraction "
            f"{contraction:g} and {pressure / 1e5:g} bar: nothing would be released. Take a load in between.",
            load=load,
            force=before,
        )
    m = load / GRAVITY
    if mass is not None:
        m = float(mass)
    if not m > 0:
        raise ParameterError(f"mass = {m:g} kg must be positive.", mass=m)
    dt = _step(model, pressure, contraction, m)
    high = model.limits[1]
    step = model.stepper(contraction)
    force, k, v = before, contraction, 0.0
    samples = [(k, v)]
    # Semi-implicit Euler steps, which keep the energy of an oscillation.
    for _ in range(STEPS):
        v += dt * (force - load) / m
        k += dt * v / model.length
        if not k < high:
            break
        force = step(k, pressure, dt)
        samples.append((k, v))
        if force <= 0.0:  # the weight flies: a muscle does not push
            break
    path = np.array(samples)
    peak = int(np.argmax(path[:, 1]))
    time = np.asarray(dt * np.arange(len(samples)), float)
    return Release(
        load, m, time, path[:, 0], path[:, 1], float(path[peak, 1]), float(path[peak, 0])
    )


def _step(model: MuscleModel, pressure: float, contraction: float, mass: float) -> float:
    """Return the time step: one and a half oscillations in `STEPS` steps, or less where the damping is strong."""
    h = min(0.02, 0.5 * (model.limits[1] - contraction))
    drop = model.static_force(contraction, pressure) - model.static_force(contraction + h, pressure)
    stiffness = max(float(drop) / (h * model.length), 1.0)
    damping = force_velocity(model, pressure, contraction + h, speeds=[0.0, 1e-3]).damping
    duration = 3.0 * math.pi * math.sqrt(mass / stiffness)
    step = duration / STEPS
    if damping > 0:
        step = min(step, 0.5 * mass / damping)
    return step


def force_at_speed(model: MuscleModel, pressure: float, contraction: float, speed: float) -> float:
    """Return the force [N] of a muscle that shortens at a constant speed [m/s] through a contraction."""
    if speed == 0.0:
        return float(model.static_force(contraction, pressure))
    start = max(contraction - LEAD, model.limits[0] + 1e-9)
    way = np.linspace(start, contraction, 41)
    time = (way - start) * (model.length / speed)
    return float(model.simulate(way, np.full(way.size, pressure), time)[-1])


def force_velocity(
    model: MuscleModel,
    pressure: float,
    contraction: float = 0.05,
    *,
    speeds: npt.ArrayLike | None = None,
) -> ForceVelocity:
    """Return the force over the speed of shortening at one contraction and pressure.

    Parameters
    ----------
    model
        Any muscle model.
    pressure
        Constant. [Pa]
    contraction
        At which the forces are read; the motion comes from `LEAD` before it.
    speeds
        (n,) from 0 on; by default up to the fastest there is, or 1 m/s. [m/s]

    Raises
    ------
    ParameterError
        If contraction, pressure or a speed is outside the model's limits.

    Examples
    --------
    >>> from dehyst_robot.muscles import muscle
    >>> curve = force_velocity(muscle("tondu-lopez"), 3e5)
    >>> bool(curve.force[0] == curve.isometric)
    True
    """
    isometric = force_at_speed(model, pressure, contraction, 0.0)

    def force_at(v: float) -> float:
        return force_at_speed(model, pressure, contraction, v)

    fastest = math.nan
    if speeds is None:
        if isometric > 0:
            fastest = _fastest(force_at)
        speeds = np.linspace(0.0, 1.0 if math.isnan(fastest) else fastest, 41)
    v = np.asarray(speeds, float)
    if v.size < 2 or np.any(v < 0) or not np.all(np.isfinite(v)):
        raise ParameterError(
            "speeds must be two or more, finite, and not negative: the muscle shortens."
        )
    force = np.array(list(map(force_at, v.tolist())))
    # Not from 0 on: there friction changes its sign.
    first, second = force_at(1e-4), force_at(1.1e-3)
    damping = max((first - second) / 1e-3, 0.0)
    hill, error = _hill(v, force, isometric)
    return ForceVelocity(pressure, contraction, v, force, isometric, fastest, damping, hill, error)


def _fastest(force_at: Callable[[float], float]) -> float:
    """Return the speed at which the force is zero, NaN if there is none up to `FASTEST`. [m/s]"""
    grid = np.geomspace(1e-3, FASTEST, 41)
    if force_at(float(grid[0])) <= 0:
        return math.nan  # such a speed is too low to be told from rest
    for slower, faster in pairwise(grid.tolist()):
        if force_at(faster) <= 0:
            return float(brentq(force_at, slower, faster, xtol=1e-9))
    return math.nan


def _hill(v: Array, force: Array, isometric: float) -> tuple[tuple[float, float], float]:
    """Return a/F_0 and b by linear least squares of F v = b (F_0 - F) - a v, and the error in percent of F_0."""
    none = (math.nan, math.nan), math.nan
    moving = v > 0
    # A force that speed hardly changes has no such curve.
    if isometric <= 0 or moving.sum() < 3 or np.ptp(force[moving]) < 1e-3 * isometric:
        return none
    x = v[moving]
    f = force[moving] / isometric
    (b, a), *_ = np.linalg.lstsq(np.stack([1.0 - f, -x], axis=1), f * x, rcond=None)
    if not (b > 0 and a > -1):
        return none
    curve = (1.0 + a) * b / (x + b) - a
    return (float(a), float(b)), float(100.0 * np.sqrt(np.mean((curve - f) ** 2)))
