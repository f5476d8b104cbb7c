r"""Oscillators with hysteresis: a mass on a spring, a damper and a hysteretic element, driven by a force.

.. math::  m y'' + c y' + k y + k_3 y^3 + h = u

The force u goes in, the position y comes out; h remembers. Integrated in C by a Runge-Kutta scheme of order four that
ends a step where the velocity changes its sign (packages/dehyst/engine/oscillator.h), `steps` times a sample.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError, RecordingError, SimulationError
from dehyst.models._arrays import parameter_number, signal_array
from oscillator.upsampling import finer, finer_periodic

_NONE: Array = np.empty(0)
_PERIODS, _STEADY_SAMPLES = (
    20,
    1_000_000,
)  # in which a steady state must be reached: the larger of both


def sampling_time(time: npt.ArrayLike, samples: int) -> float:
    """Return the spacing of a time axis (T,) [s], or say why it has none."""
    axis = signal_array(time, "time")
    if axis.size != samples or samples < 2:
        raise RecordingError(
            f"time has {axis.size} values and the force {samples}; give one time a sample, at least two.",
            samples=samples,
        )
    step = (axis[-1] - axis[0]) / (samples - 1)
    if not (np.isfinite(step) and step > 0 and np.abs(np.diff(axis) - step).max() < 1e-3 * step):
        raise RecordingError(
            "time is not equally spaced and increasing, and the integration needs the force between the samples. "
            "Resample the record, or pass numpy.arange(samples) / rate.",
            step=float(step),
        )
    return float(step)


@dataclass(frozen=True)
class Motion:
    """What an oscillator did: one value a sample.

    Attributes
    ----------
    position
        y (T,). [m]
    velocity
        y' (T,). [m/s]
    hysteretic_force
        h (T,), without spring and damper. [N]
    """

    position: Array
    velocity: Array
    hysteretic_force: Array


class Oscillator(ABC):
    """What every oscillator can do. `mass`, ... are fields of the records below."""

    @abstractmethod
    def _arguments(self) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
        """(m, c, k, k3), law of Bouc and Wen, slopes, their grid, thresholds, weights, weights of y^2."""

    def simulate(
        self, force: npt.ArrayLike, time: npt.ArrayLike, *, periodic: bool = False, steps: int = 4
    ) -> Array:
        """Return the positions y (T,) [m] that answer a force (T,) [N].

        Parameters
        ----------
        force
            u. [N]
        time
            Equally spaced. [s]
        periodic
            The force is one period of a periodic one and the answer is the steady state: periods are simulated until
            two agree. Otherwise the oscillator starts at rest, unloaded.
        steps
            Steps of integration a sample.

        Raises
        ------
        RecordingError
            The lengths differ, the times are not equally spaced, or the force is not finite.
        SimulationError
            The motion grows beyond all numbers: too few steps for so stiff an oscillator, or not a passive one. Or it
            has no steady state.
        """
        return self.motion(force, time, periodic=periodic, steps=steps).position

    def motion(
        self, force: npt.ArrayLike, time: npt.ArrayLike, *, periodic: bool = False, steps: int = 4
    ) -> Motion:
        """Return positions, velocities and hysteretic forces; parameters and errors as in :meth:`simulate`."""
        u = signal_array(force, "force")
        dt = sampling_time(time, u.size)
        if not np.isfinite(u).all():
            bad = int(np.flatnonzero(~np.isfinite(u))[0])
            raise RecordingError(
                f"force[{bad}] = {u[bad]} is not a number; repair or drop that sample.", index=bad
            )
        if steps < 1:
            raise ParameterError(
                f"steps = {steps}: at least one step of integration a sample is needed.",
                steps=steps,
            )
        grid = finer_periodic(u, 2 * steps) if periodic else finer(u, 2 * steps)
        rows = (
            self._steady(grid, steps, dt) if periodic else self.run(grid, steps, dt, self.rest())[0]
        )
        return Motion(*(np.ascontiguousarray(rows[:, j]) for j in range(3)))

    def rest(self) -> Array:
        """Return the state at rest, unloaded: (y, y', z, stops)."""
        return np.zeros(3 + self._arguments()[4].size)

    def run(self, grid: Array, steps: int, dt: float, state: Array) -> tuple[Array, Array]:
        """Return rows (y, y', h), one a sample of `dt`, from a state on, and the state at the end.

        `grid` is the force at every half step, (2 steps (samples - 1) + 1,). Raises SimulationError as `simulate` does.
        """
        rows, after, finite = _native.oscillate(*self._arguments(), grid, steps, dt, state)
        if finite < rows.shape[0]:
            raise SimulationError(
                f"the simulated motion is not finite from sample {finite} of {rows.shape[0]} on: either the steps are "
                f"too long for this oscillator (more of them: steps={4 * steps}) or its element gives energy instead "
                f"of taking it (weights or slopes below zero).",
                sample=finite,
            )
        return rows, after

    def _steady(self, grid: Array, steps: int, dt: float) -> Array:
        closed = np.append(grid, grid[0])
        state, before = self.rest(), None
        periods = max(_PERIODS, _STEADY_SAMPLES * steps // grid.size)
        for _ in range(periods):
            rows, state = self.run(closed, steps, dt, state)
            if (
                before is not None
                and np.abs(rows - before)[:, 0].max() <= 1e-9 * np.abs(rows[:, 0]).max()
            ):
                return rows[:-1]
            before = rows
        raise SimulationError(
            f"after {periods} periods of the force one still differs from the next: the oscillator has no damping, or "
            f"no steady state of that period. Simulate several periods with periodic=False and judge them.",
            periods=periods,
        )


@dataclass(frozen=True)
class BoucWenOscillator(Oscillator):
    r"""Oscillator with the element of Bouc and Wen, the system of the benchmark of Noel and Schoukens (2016).

    .. math::  z' = \alpha y' - \beta (\gamma |y'| |z|^{\nu-1} z + \delta y' |z|^\nu), \quad h = z

    Only the products beta gamma and beta delta act: beta is a convention.

    Parameters
    ----------
    mass, damping, stiffness
        m > 0 [kg], c [N s/m], k [N/m].
    alpha, beta, gamma, delta, nu
        alpha [N/m]; beta gamma and beta delta [N^(1-nu)/m]; nu > 0.

    Raises
    ------
    ParameterError
        A parameter is not finite, or mass or nu is not positive.

    Examples
    --------
    >>> oscillator = BoucWenOscillator(2.0, 10.0, 5e4, 5e4, 1e3, 0.8, -1.1, 1.0)
    >>> time = np.arange(75) / 750
    >>> bool(np.abs(oscillator.simulate(50 * np.sin(2 * np.pi * 30 * time), time)).max() > 5e-4)
    True
    """

    mass: float
    damping: float
    stiffness: float
    alpha: float
    beta: float
    gamma: float
    delta: float
    nu: float = 1.0

    def __post_init__(self) -> None:
        """Check the parameters."""
        for name in ("mass", "damping", "stiffness", "alpha", "beta", "gamma", "delta", "nu"):
            object.__setattr__(self, name, parameter_number(getattr(self, name), name))
        for name in ("mass", "nu"):
            _positive(name, getattr(self, name))

    def _arguments(self) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
        law = np.array([self.alpha, self.beta, self.gamma, self.delta, self.nu])
        return (
            np.array([self.mass, self.damping, self.stiffness, 0.0]),
            law,
            _NONE,
            _NONE,
            _NONE,
            _NONE,
            _NONE,
        )


@dataclass(frozen=True)
class HystereticOscillator(Oscillator):
    r"""Oscillator whose hysteretic force is one of a family that knows nothing of the system at hand.

    .. math::  h = z + \sum_i (w_i + v_i y^2) E_{r_i}[y], \quad z' = y' G(s z), \quad s = \mathrm{sign}\, y'

    Stop operators E_r are Maxwell's slip elements; G, a table, is the slope of a Duhem model with local memory that
    treats both directions alike. Either part may be absent; without both, only the cubic spring is not linear.

    Parameters
    ----------
    mass, damping, stiffness, cubic
        m > 0 [kg], c [N s/m], k [N/m], k_3 [N/m^3].
    thresholds, weights, square_weights
        r_i > 0 [m], w_i [N/m], v_i [N/m^3]; square_weights may be empty: zeros.
    slope_range
        G is given at equally spaced s z from -slope_range to slope_range [N] and goes on straight beyond.
    slopes
        G there, at least two. [N/m]

    Raises
    ------
    ParameterError
        A parameter is not finite, a threshold, the mass or the range not positive, or lengths differ.

    Examples
    --------
    >>> slip = HystereticOscillator(2.0, 10.0, 5e4, thresholds=(1e-3,), weights=(5e4,))
    >>> time = np.arange(7500) / 750
    >>> round(float(slip.simulate(np.full(7500, 50.0), time)[-1]), 6)  # static: 50 N on 1e5 N/m
    0.0005
    """

    mass: float
    damping: float
    stiffness: float
    cubic: float = 0.0
    thresholds: Sequence[float] = ()
    weights: Sequence[float] = ()
    square_weights: Sequence[float] = ()
    slope_range: float = 1.0
    slopes: Sequence[float] = ()

    def __post_init__(self) -> None:
        """Check the parameters."""
        for name in ("mass", "damping", "stiffness", "cubic", "slope_range"):
            object.__setattr__(self, name, parameter_number(getattr(self, name), name))
        for name in ("thresholds", "weights", "square_weights", "slopes"):
            values = tuple(
                parameter_number(value, f"{name}[{j}]")
                for j, value in enumerate(getattr(self, name))
            )
            object.__setattr__(self, name, values)
        if not self.square_weights:
            object.__setattr__(self, "square_weights", (0.0,) * len(self.weights))
        for name in ("mass", "slope_range"):
            _positive(name, getattr(self, name))
        for j, threshold in enumerate(self.thresholds):
            _positive(f"thresholds[{j}]", threshold)
        if (
            not len(self.thresholds) == len(self.weights) == len(self.square_weights)
            or len(self.slopes) == 1
        ):
            raise ParameterError(
                f"{len(self.thresholds)} thresholds, {len(self.weights)} weights, {len(self.square_weights)} weights "
                f"of the square and {len(self.slopes)} slopes: give one weight a threshold, and no slope or two."
            )

    def _arguments(self) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
        spacing = 2.0 * self.slope_range / (len(self.slopes) - 1) if self.slopes else 1.0
        return (
            np.array([self.mass, self.damping, self.stiffness, self.cubic]),
            _NONE,
            np.array(self.slopes, dtype=np.float64),
            np.array([-self.slope_range, spacing]),
            np.array(self.thresholds, dtype=np.float64),
            np.array(self.weights, dtype=np.float64),
            np.array(self.square_weights, dtype=np.float64),
        )


def _positive(name: str, value: float) -> None:
    if not value > 0:
        raise ParameterError(
            f"{name} = {value:g} must be positive: nothing would move as such an oscillator does."
        )
