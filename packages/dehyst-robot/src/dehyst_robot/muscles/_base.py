r"""Base class of muscle models: force from contraction and pressure, with hysteresis, and its inverse.

All models are frozen records in SI units with one sign: the contraction :math:`\kappa = (l_0 - l)/l_0` is positive when
the muscle is shorter than at rest, the pressure is gauge, and the force is a pull,

.. math:: F = F_{static}(\kappa, p) - R(\kappa, p, v, s),

less a resistance R that opposes the motion. v is the speed of shortening, and s in -1..1 says how far the contacts of
weave and rubber have slipped: a sum of stop operators of the contraction, which is the memory. For a given motion R
depends on the pressure of the moment only, so that a force can be solved for the pressure sample by sample.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from dehyst._native import play_bank
from dehyst.arrays import Array
from dehyst.errors import ParameterError, RecordingError
from dehyst.models import kit as models_kit
from dehyst_robot.muscles._parameters import ParameterRecord
from dehyst_robot.muscles._solve import solve_pressure

PRESSURE_LIMIT = 5e6  # Pa; far beyond the 8 bar of any muscle, so that a wrong unit does not pass
SPEED_LIMIT = 1e4  # m/s; muscles reach 1


@dataclass(frozen=True)
class Arithmetic:
    """Functions of one kind of numbers, so that a formula is written once: arrays for logs, floats for a simulation.

    On floats they are those of `math`: a step costs a microsecond or two and not the ten to thirty of small arrays.
    """

    exp: Callable[[Any], Any]
    sqrt: Callable[[Any], Any]
    maximum: Callable[[Any, Any], Any]
    minimum: Callable[[Any, Any], Any]
    where: Callable[[Any, Any, Any], Any]


ARRAYS = Arithmetic(np.exp, np.sqrt, np.maximum, np.minimum, np.where)


def _where(condition: Any, yes: Any, no: Any) -> Any:
    if condition:
        return yes
    return no


FLOATS = Arithmetic(math.exp, math.sqrt, max, min, _where)


def polynomial(coefficients: tuple[float, ...], x: Any) -> Any:
    """Return the value of a polynomial, coefficients lowest power first.

    Examples
    --------
    >>> polynomial((1.0, 2.0, 3.0), 10.0)
    321.0
    """
    value = coefficients[-1] + 0.0 * x
    for c in reversed(coefficients[:-1]):
        value = value * x + c
    return value


@dataclass(frozen=True, eq=False)
class Memory:
    """State of a muscle between two samples.

    Attributes
    ----------
    contraction
        The last one.
    time
        Of the last sample [s], NaN without time stamps.
    plays
        (n,) states of the play operators under the stops, in contraction.
    """

    contraction: float
    time: float
    plays: Array


class MuscleModel(ParameterRecord, ABC):
    """A muscle: forces from contraction and pressure.

    A model defines its formulas, `_static` and, if it has friction or damping, `_resistance`; the rest follows.

    Attributes
    ----------
    length
        l_0, at rest without pressure and load. [m]
    name
        As typed on the command line.
    dynamic
        Whether motion matters, by its speed or its past; by default whether there is a `_resistance`.
    affine_in_pressure
        Whether F = f_a(kappa) p - f_e(kappa).
    PARAMETERS
        Its parameters, in the order of the fields.
    SETS
        Published parameter sets: name -> source.
    """

    length: float = float("nan")
    dynamic: ClassVar[bool] = False
    affine_in_pressure: ClassVar[bool] = True

    def __init_subclass__(cls) -> None:
        """Complete what a model declares."""
        super().__init_subclass__()
        if "dynamic" not in vars(cls):
            cls.dynamic = cls._resistance is not MuscleModel._resistance

    # -- formulas of a model -------------------------------------------------------------------------------------------

    @abstractmethod
    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        """Static force at rest, arrays or floats. [N]"""

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        """Force that opposes the motion; speed of shortening [m/s], slip in -1..1. [N]"""
        return 0.0 * kappa

    def _contacts(self) -> tuple[Array, Array]:
        """Slip strains (n,), increasing, and shares (n,), together 1, of the stop operators in the slip; or none."""
        # Many models have a single slip strain and call it so.
        strains = np.empty(0)
        if hasattr(self, "presliding"):
            strains = np.array([self.presliding])
        return strains, np.ones(strains.size)

    @property
    def limits(self) -> tuple[float, float]:
        """Contractions between which the formulas are valid."""
        return -0.2, 0.9

    # -- forces -------------------------------------------------------------------------------------------------------

    def static_force(
        self, kappa: npt.ArrayLike, pressure: npt.ArrayLike, *, clamp: bool = False
    ) -> Array:
        """Return the force at rest, without friction; arguments broadcast.

        Parameters
        ----------
        kappa
            Contraction.
        pressure
            Gauge. [Pa]
        clamp
            Return 0 where the formula is negative: a muscle does not push.

        Returns
        -------
        force : Array
            Pull. [N]

        Raises
        ------
        ParameterError
            If a value is not finite, or outside `limits`.

        Examples
        --------
        >>> from dehyst_robot.muscles import muscle
        >>> muscle("maker").static_force([0.0, 0.25], 3e5).round().tolist()
        [3096.0, -374.0]
        >>> muscle("maker").static_force([0.0, 0.25], 3e5, clamp=True).round().tolist()
        [3096.0, 0.0]
        """
        k, p = self._checked(kappa, pressure)
        with np.errstate(all="ignore"):
            force = self._finite(self._static(k, p, ARRAYS))
        return _clamped(force, clamp)

    def affine(
        self, kappa: npt.ArrayLike, pressures: tuple[float, float] = (2e5, 4e5)
    ) -> tuple[Array, Array]:
        """Return f_a [N/Pa] and f_e [N] of F = f_a p - f_e.

        Exact where the force is affine in the pressure; else the line through the forces at two pressures.

        Examples
        --------
        >>> from dehyst_robot.muscles import muscle
        >>> pull, rubber = muscle("maker").affine(0.1)
        >>> round(float(pull * 3e5 - rubber))
        1469
        """
        low, high = pressures
        k = np.asarray(kappa, float)
        if not high > low:
            raise ParameterError(
                f"pressures = {pressures}: the second one must be above the first one."
            )
        first = self.static_force(k, np.full_like(k, low))
        second = self.static_force(k, np.full_like(k, high))
        slope = (second - first) / (high - low)
        return slope, slope * low - first

    def simulate(
        self,
        contraction: npt.ArrayLike,
        pressure: npt.ArrayLike,
        time: npt.ArrayLike | None = None,
        *,
        clamp: bool = False,
    ) -> Array:
        """Return the force along a motion that starts at rest, without memory.

        Parameters
        ----------
        contraction
            (T,).
        pressure
            (T,), or one for all; gauge. [Pa]
        time
            (T,), increasing. [s] None: the motion is infinitely slow, terms that depend on speed are at their limit.
        clamp
            As in `static_force`.

        Returns
        -------
        force : (T,)
            Pull. [N]

        Raises
        ------
        ParameterError, RecordingError
            If values are not finite or outside `limits`, lengths differ, or time does not increase.

        Examples
        --------
        Friction is odd in the direction, half a loop high:

        >>> from dehyst_robot.muscles import muscle
        >>> braid = muscle("chou-hannaford")
        >>> force = braid.simulate([0.10, 0.12, 0.10], 3e5)
        >>> (braid.static_force([0.10, 0.12, 0.10], 3e5) - force).round(9).tolist()
        [0.0, 3.0, -3.0]
        """
        force, _ = self.run(contraction, pressure, time)
        return _clamped(force, clamp)

    def run(
        self,
        contraction: npt.ArrayLike,
        pressure: npt.ArrayLike,
        time: npt.ArrayLike | None = None,
        memory: Memory | None = None,
    ) -> tuple[Array, Memory]:
        """Return force (T,) and memory after a motion, continuing from a memory; None is rest at the first sample.

        Pieces of a motion, each with the memory that the one before it left, give the forces of the whole.

        Examples
        --------
        >>> from dehyst_robot.muscles import muscle
        >>> braid = muscle("chou-hannaford")
        >>> first, memory = braid.run([0.10, 0.12], 3e5)
        >>> second, memory = braid.run([0.10], 3e5, memory=memory)
        >>> bool(second[0] == braid.simulate([0.10, 0.12, 0.10], 3e5)[2])
        True
        """
        x, p = self._signals(contraction, pressure)
        speed, slip, memory = self._motion(x, self._times(time, x.size, memory), memory)
        with np.errstate(all="ignore"):
            force = self._moving(x, p, speed, slip, ARRAYS)
        return self._finite(force), memory

    def force_after(
        self, memory: Memory, contraction: float, pressure: float, time: float = float("nan")
    ) -> float:
        """Return the force after moving from a memory to a contraction, as `run`, but for one sample and faster. [N]

        Parameters
        ----------
        memory
            State of the muscle; it is not changed.
        contraction, pressure
            To which it moves. [1], [Pa]
        time
            At which it is there, after that of the memory; NaN: infinitely slow. [s]

        Raises
        ------
        ParameterError
            If the contraction is outside `limits`, or there is no finite force.

        Examples
        --------
        >>> from dehyst_robot.muscles import muscle
        >>> braid = muscle("chou-hannaford")
        >>> memory = braid.rest(0.1)
        >>> force, _ = braid.run([0.12], 3e5, memory=memory)
        >>> round(braid.force_after(memory, 0.12, 3e5) - float(force[0]), 9)
        0.0
        """
        if not self.limits[0] <= contraction <= self.limits[1]:
            self._checked(contraction, pressure)
        slip = speed = 0.0
        if memory.plays.size:
            slip = float(self._slip(np.float64(contraction), memory.plays))
        # Not a number, and so not positive, where one of the times is not known.
        elapsed = time - memory.time
        if elapsed > 0:
            speed = self.length * (contraction - memory.contraction) / elapsed
        force = self._one_force(contraction, pressure, speed, slip)
        if not math.isfinite(force):
            self._finite(force)  # raises
        return force

    def rest(self, contraction: float, time: float = float("nan")) -> Memory:
        """Return the memory of a muscle that rests at a contraction, its contacts relaxed."""
        strains, _ = self._contacts()
        return Memory(float(contraction), float(time), np.full(strains.size, float(contraction)))

    def stepper(self, contraction: float = 0.0) -> MuscleStepper:
        """Return the model as a function of one sample, at rest at a contraction."""
        return MuscleStepper(self, contraction)

    # -- back to the pressure -----------------------------------------------------------------------------------------

    def inverse_pressure(self, force: npt.ArrayLike, kappa: npt.ArrayLike) -> Array:
        """Return the gauge pressure at which the muscle at rest pulls with a force; may be negative. [Pa]

        Raises
        ------
        InvertibilityError
            Where no pressure does it: at contractions at which pressure does not pull any more.

        Examples
        --------
        >>> from dehyst_robot.muscles import muscle
        >>> round(float(muscle("maker").inverse_pressure(1469.0, 0.1)), -2)
        300000.0
        """
        k, f = self._checked(kappa, force, "force", np.inf)
        return solve_pressure(
            lambda p: self._static(k, p, ARRAYS), f, self.affine_in_pressure, self._about(k)
        )

    def inverse(
        self,
        force: npt.ArrayLike,
        contraction: npt.ArrayLike,
        time: npt.ArrayLike | None = None,
        memory: Memory | None = None,
    ) -> Array:
        """Return the pressures (T,) that give a force along a motion, friction and memory included. [Pa]

        The memory belongs to the motion alone, so that each sample is solved by itself; friction in proportion to the
        pressure is solved with it.

        Raises
        ------
        InvertibilityError
            Where no pressure does it.

        Examples
        --------
        >>> from dehyst_robot.muscles import muscle
        >>> braid = muscle("tondu-lopez")
        >>> path = [0.10, 0.12, 0.10]
        >>> braid.inverse(braid.simulate(path, 3e5), path).round(3).tolist()
        [300000.0, 300000.0, 300000.0]
        """
        x, f = self._signals(contraction, force, "force", np.inf)
        speed, slip, _ = self._motion(x, self._times(time, x.size, memory), memory)
        return solve_pressure(
            lambda p: self._moving(x, p, speed, slip, ARRAYS),
            f,
            self.affine_in_pressure,
            self._about(x),
        )

    # -- inside -------------------------------------------------------------------------------------------------------

    def _moving(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        return self._static(kappa, pressure, m) - self._resistance(kappa, pressure, speed, slip, m)

    def _slip(self, kappa: Any, plays: Array) -> Array:
        """Slip (...) of stop operators from a state: the strain since their plays moved last, until they slip."""
        strains, shares = self._contacts()
        return np.asarray(np.clip((kappa[..., None] - plays) / strains, -1.0, 1.0) @ shares)

    def _finite(self, force: Any) -> Array:
        """Return forces, or refuse the parameters that make them infinite or nan."""
        array = np.asarray(force, float)
        if not np.isfinite(array).all():
            listed = ", ".join(f"{key} = {value}" for key, value in self.as_dict().items())
            raise ParameterError(
                f"{self.name} gives forces that are not finite: a parameter is far outside its range. They are "
                f"{listed}.",
            )
        return array

    def _one_force(self, x: float, pressure: float, speed: float, slip: float) -> float:
        """Force of one sample, on plain floats. [N]"""
        try:
            return float(self._moving(x, pressure, speed, slip, FLOATS))
        except OverflowError:
            raise ParameterError(
                f"{self.name} has no force at contraction {x:g} and {pressure:g} Pa: the pressure, or a parameter, is "
                "far outside its range."
            ) from None

    def _about(self, kappa: Array) -> str:
        return f"{self.name} between contractions {np.min(kappa, initial=1):.3g} and {np.max(kappa, initial=-1):.3g}"

    def _motion(
        self, x: Array, time: Array | None, memory: Memory | None
    ) -> tuple[Array, Array, Memory]:
        """Return speed of shortening (T,) by backward differences, slip (T,), and the memory after the motion."""
        if x.size == 0:
            return x, x, memory or self.rest(0.0)
        first = last = float("nan")
        if time is not None:
            first, last = float(time[0]), float(time[-1])
        start = memory or self.rest(float(x[0]), first)
        speed = np.zeros(x.size)
        if time is not None:
            # A motion from rest has no step before its first sample: there the speed stays 0.
            step = np.diff(time, prepend=start.time)
            moved = np.diff(x, prepend=start.contraction)
            with np.errstate(over="ignore"):
                np.divide(self.length * moved, step, out=speed, where=step > 0)
            fast = np.flatnonzero(np.abs(speed) > SPEED_LIMIT)
            if fast.size:
                i = int(fast[0])
                raise RecordingError(
                    f"at sample {i} the muscle moves at {speed[i]:.3g} m/s: {step[i]:.3g} s for a contraction of "
                    f"{moved[i]:.3g}. Times are in seconds; drop time stamps that nearly repeat.",
                    index=i,
                )
        slip = np.zeros(x.size)
        state = start.plays
        if state.size:
            strains, _ = self._contacts()
            plays, state = play_bank(x, strains, state, np.arange(x.size, dtype=np.int64))
            slip = self._slip(x, plays)
        return speed, slip, Memory(float(x[-1]), last, state)

    def _times(
        self, time: npt.ArrayLike | None, samples: int, memory: Memory | None
    ) -> Array | None:
        if time is None:
            return None
        t = models_kit.signal_array(time, "time")
        if t.size != samples:
            raise RecordingError(
                f"time has {t.size} samples, contraction {samples}; pass one time for each."
            )
        # A motion that continues another one must not begin before its end.
        with_start = t
        if memory and not math.isnan(memory.time):
            with_start = np.concatenate(([memory.time], t))
        bad = np.flatnonzero(~(np.diff(with_start) > 0) | ~np.isfinite(with_start[1:]))
        if bad.size or (t.size and not np.isfinite(t[0])):
            at = 0
            if bad.size:
                at = int(bad[0])
            raise RecordingError(
                f"time does not increase after sample {at}: speeds would be infinite. Sort the log, drop repeated "
                "samples, or pass time=None for a motion that is infinitely slow.",
                index=at,
            )
        return t

    def _signals(
        self,
        contraction: npt.ArrayLike,
        second: npt.ArrayLike,
        name: str = "pressure",
        most: float = PRESSURE_LIMIT,
    ) -> tuple[Array, Array]:
        x = models_kit.signal_array(contraction, "contraction")
        y = constant_or_signal(second, x.size, name)
        if x.size != y.size:
            raise RecordingError(
                f"contraction has {x.size} samples, {name} {y.size}; they must be of one log."
            )
        self._checked(x, y, name, most)
        return x, y

    def _checked(
        self,
        kappa: npt.ArrayLike,
        second: npt.ArrayLike,
        name: str = "pressure",
        most: float = PRESSURE_LIMIT,
    ) -> tuple[Array, Array]:
        try:
            k, y = np.broadcast_arrays(np.asarray(kappa, float), np.asarray(second, float))
        except (TypeError, ValueError) as fault:
            raise ParameterError(
                f"contraction and {name} are no arrays of numbers that fit ({fault})."
            ) from None
        low, high = self.limits
        # Written so that nan is wrong, too.
        wrong = ~((k >= low) & (k <= high))
        if wrong.any():
            raise ParameterError(
                f"contraction {float(k[wrong].flat[0])!r} is outside {low:.4g} .. {high:.4g}, where the formulas of "
                f"{self.name} hold. Contraction is (l_0 - l)/l_0, a number, not a length or per cent.",
                limits=self.limits,
            )
        wrong = ~np.isfinite(y) | (np.abs(y) > most)
        if wrong.any():
            limit = ""
            if most < np.inf:
                limit = f" up to {most:g} Pa"
            raise ParameterError(
                f"{name} {float(y[wrong].flat[0])!r} is not a finite number{limit}."
            )
        return k, y


def constant_or_signal(values: npt.ArrayLike, samples: int, name: str) -> Array:
    """Return one value a sample: a number for all, or a signal as it is."""
    if np.ndim(values) == 0:
        return np.full(samples, models_kit.parameter_number(values, name))  # type: ignore[arg-type]
    return models_kit.signal_array(values, name)


def _clamped(force: Array, clamp: bool) -> Array:
    if clamp:
        return np.maximum(force, 0.0)
    return force


class MuscleStepper:
    """A muscle sample by sample, on plain floats: the forces of `MuscleModel.run`, to rounding.

    Examples
    --------
    >>> from dehyst_robot.muscles import muscle
    >>> step = muscle("tondu-lopez").stepper(0.0)
    >>> step(0.0, 3e5, 0.001) > step(0.01, 3e5, 0.001)
    True
    """

    def __init__(self, model: MuscleModel, contraction: float = 0.0) -> None:
        strains, shares = model._contacts()
        self._model = model
        self._limits = model.limits
        self._strains = strains
        # A single stop is computed here, several in the core.
        self._single_strain = 0.0
        if strains.size == 1:
            self._single_strain = float(strains[0])
        # A sum of stops is written as one of plays, which is what the core has.
        stiffness = shares / strains
        self._thresholds = np.concatenate(([0.0], strains))
        self._weights = np.concatenate(([stiffness.sum()], -stiffness))
        self.reset(contraction)

    def reset(self, contraction: float) -> None:
        """Rest at a contraction, without memory."""
        self._last = self._play = float(contraction)
        state = np.full(self._weights.size, self._last)
        self._slips = models_kit.make_stepper(
            self._thresholds, self._weights, 0.0, 0.0, state, method="dense"
        )

    def __call__(self, contraction: float, pressure: float, period: float) -> float:
        """Return the force [N] after moving there within a period [s]; gauge pressure [Pa].

        Raises
        ------
        ParameterError
            If the contraction is outside the model's limits.
        """
        speed, slip = self._move(contraction, period)
        return self._model._one_force(contraction, pressure, speed, slip)

    def pressure(self, contraction: float, force: float, period: float) -> float:
        """Return the gauge pressure [Pa] that gives a force [N] after moving there within a period [s], and move.

        Raises
        ------
        ParameterError
            If the contraction is outside the model's limits; the memory stays as it was.
        InvertibilityError
            If no pressure gives the force.
        """
        speed, slip = self._move(contraction, period)

        def force_at(p: Array) -> Array:
            return np.array([self._model._one_force(contraction, float(p[0]), speed, slip)])

        about = f"{self._model.name} at contraction {contraction:.4g}"
        target = np.array([float(force)])
        solution = solve_pressure(force_at, target, self._model.affine_in_pressure, about)
        return float(solution[0])

    def _move(self, x: float, period: float) -> tuple[float, float]:
        """Move to the next contraction and return speed and slip."""
        if not self._limits[0] <= x <= self._limits[1]:
            raise ParameterError(
                f"contraction {x:g} is outside {self._limits[0]:.4g} .. {self._limits[1]:.4g}, where the formulas of "
                f"{self._model.name} hold: the joint left the range of its muscle."
            )
        if not period > 0:
            raise ParameterError(f"period = {period!r} s must be positive.")
        speed = self._model.length * (x - self._last) / period
        slip = 0.0
        d = self._single_strain
        if d:
            self._play = max(x - d, min(x + d, self._play))
            slip = max(-1.0, min(1.0, (x - self._play) / d))
        elif self._strains.size:
            slip = max(-1.0, min(1.0, self._slips(x)))
        self._last = x
        return speed, slip

    @property
    def memory(self) -> Memory:
        """Present state; without a time."""
        plays = np.array(self._slips.state[1:])
        if self._single_strain:
            plays = np.array([self._play])
        return Memory(self._last, float("nan"), plays)
