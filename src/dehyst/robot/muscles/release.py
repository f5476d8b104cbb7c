"""Quick-release test: a held muscle is released against a smaller load; force over shortening speed.

Hill's curve of a living muscle, (F + a)(v + b) = (F_0 + a) b, is fitted to the forces at speed, because some of the
models were made to follow it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.robot.muscles.base import MuscleModel

GRAVITY = 9.81  # m/s^2
FASTEST = 10.0  # m/s; a muscle that still pulls at this speed is not limited by it
LEAD = 0.04  # contraction over which a steady speed is held before the force is read
SHARES = (0.2, 0.4, 0.6, 0.8)  # of the blocked force, loads after the release
STEPS = 3000  # of a release


@dataclass(frozen=True, eq=False)
class Release:
    """Motion after a release: the latch opens, and a weight is left that is lighter than the force.

    Attributes
    ----------
    load, mass
        Left after the release. [N], [kg]
    time, contraction, speed
        (T,) from the release on, until the muscle hangs loose or all is over; speed of shortening. [s], [1], [m/s]
    peak_speed
        At which the force is just the load: nothing accelerates. [m/s]
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
        Speed at which nothing is left of the force, NaN if there is none up to `FASTEST`. [m/s]
    damping
        Force lost on the first m/s, slope at the lowest speeds. [N s/m]
    hill
        a/F_0 and b [m/s] of Hill's curve through the forces; NaN where speed does not matter.
    hill_percent
        What the curve misses, rms in percent of F_0.
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
        return {name: value if math.isfinite(value) else None for name, value in figures.items()}


def quick_release(
    model: MuscleModel, pressure: float, load: float, *, contraction: float = 0.0, mass: float | None = None
) -> Release:
    """Return the motion of a muscle that was held at a contraction and is let go with a weight.

    m dv/dt = F(kappa, p, v) - load, in steps a good deal shorter than those of the muscle's own oscillation.

    Parameters
    ----------
    model
        Any muscle model.
    pressure
        Held. [Pa]
    load
        Left after the release, less than the force before it. [N]
    contraction
        At which the muscle was held.
    mass
        That is moved; by default that of the weight, load/g. [kg]

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
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
    m = load / GRAVITY if mass is None else float(mass)
    if not m > 0:
        raise ParameterError(f"mass = {m:g} kg must be positive.", mass=m)
    dt, high = _step(model, pressure, contraction, m), model.limits[1]
    step, force, k, v = model.stepper(contraction), before, contraction, 0.0
    found = [(k, v)]
    for _ in range(STEPS):
        v += dt * (force - load) / m
        k += dt * v / model.length
        if not k < high:
            break
        force = step(k, pressure, dt)
        found.append((k, v))
        if force <= 0.0:  # the weight flies: a muscle does not push
            break
    path = np.array(found)
    peak = int(np.argmax(path[:, 1]))
    time = np.asarray(dt * np.arange(len(found)), float)
    return Release(load, m, time, path[:, 0], path[:, 1], float(path[peak, 1]), float(path[peak, 0]))


def _step(model: MuscleModel, pressure: float, contraction: float, mass: float) -> float:
    """Time step: one and a half oscillations on the static stiffness in `STEPS`, short enough for the damping."""
    h = min(0.02, 0.5 * (model.limits[1] - contraction))
    drop = model.static_force(contraction, pressure) - model.static_force(contraction + h, pressure)
    stiffness = max(float(drop) / (h * model.length), 1.0)
    damping = force_velocity(model, pressure, contraction + h, speeds=[0.0, 1e-3]).damping
    whole = 3.0 * math.pi * math.sqrt(mass / stiffness)
    return min(whole / STEPS, 0.5 * mass / damping if damping > 0 else math.inf)


def force_at_speed(model: MuscleModel, pressure: float, contraction: float, speed: float) -> float:
    """Return the force [N] of a muscle that shortens at a constant speed [m/s] through a contraction."""
    if speed == 0.0:
        return float(model.static_force(contraction, pressure))
    start = max(contraction - LEAD, model.limits[0] + 1e-9)
    way = np.linspace(start, contraction, 41)
    time = (way - start) * (model.length / speed)
    return float(model.simulate(way, np.full(way.size, pressure), time)[-1])


def force_velocity(
    model: MuscleModel, pressure: float, contraction: float = 0.05, *, speeds: npt.ArrayLike | None = None
) -> ForceVelocity:
    """Return the force over the speed of shortening at one contraction and pressure.

    Parameters
    ----------
    model
        Any muscle model.
    pressure
        Held. [Pa]
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
    >>> from dehyst.robot.muscles import muscle
    >>> found = force_velocity(muscle("tondu-lopez"), 3e5)
    >>> bool(found.force[0] == found.isometric)
    True
    """
    still = force_at_speed(model, pressure, contraction, 0.0)

    def left(v: float) -> float:
        return force_at_speed(model, pressure, contraction, v)

    fastest = math.nan
    if speeds is None:
        grid = np.geomspace(1e-3, FASTEST, 41)
        spent = next((i for i, v in enumerate(grid.tolist()) if left(v) <= 0), 0) if still > 0 else 0
        if spent:
            fastest = float(brentq(left, grid[spent - 1], grid[spent], xtol=1e-9))
        speeds = np.linspace(0.0, fastest if spent else 1.0, 41)
    v = np.asarray(speeds, float)
    if v.size < 2 or np.any(v < 0) or not np.all(np.isfinite(v)):
        raise ParameterError("speeds must be two or more, finite, and not negative: the muscle shortens.")
    force = np.array([left(each) for each in v.tolist()])
    first, second = left(1e-4), left(1.1e-3)
    damping = max((first - second) / 1e-3, 0.0)
    hill, missed = _hill(v, force, still)
    return ForceVelocity(pressure, contraction, v, force, still, fastest, damping, hill, missed)


def _hill(v: Array, force: Array, still: float) -> tuple[tuple[float, float], float]:
    """Linear least squares of F v = b (F_0 - F) - a v, and what the curve misses in percent of F_0."""
    none = (math.nan, math.nan), math.nan
    moving = v > 0
    if still <= 0 or moving.sum() < 3 or np.ptp(force[moving]) < 1e-3 * still:
        return none
    x, f = v[moving], force[moving] / still
    (b, a), *_ = np.linalg.lstsq(np.stack([1.0 - f, -x], axis=1), f * x, rcond=None)
    if not (b > 0 and a > -1):
        return none
    curve = (1.0 + a) * b / (x + b) - a
    return (float(a), float(b)), float(100.0 * np.sqrt(np.mean((curve - f) ** 2)))
