"""Compensators: compute the pressure difference that cancels hysteresis along the desired path."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from dehyst._native import StackStepper, Stepper
from dehyst.arrays import Array
from dehyst.errors import OutputError, ParameterError
from dehyst.models import HysteresisModel, Model, subtracted_shear
from dehyst.models import kit as models_kit

PLAYS = "plays"  # form of the models whose memory is a state a play


@runtime_checkable
class Compensator(Protocol):
    """Three methods that make a compensator; any class that has them is one.

    Its input is the desired path, never the measured one, which would be positive feedback. It returns the pressure
    difference that is added behind the inverse joint characteristic. [Pa] `along` evaluates it over a path before the
    run; the values become the reference's ``extra``.

    Examples
    --------
    Coulomb friction that opposes the desired motion:

    >>> class Coulomb:
    ...     def reset(self, angle: float) -> None:
    ...         self.term = 0.0
    ...     def step(self, angle: float, velocity: float) -> float:
    ...         self.term = 0.2e5 * (velocity > 0) - 0.2e5 * (velocity < 0)
    ...         return self.term
    ...     def output(self) -> float:
    ...         return self.term
    >>> along(Coulomb(), [0.0, 0.1, 0.1], [0.0, 1.0, -1.0]).tolist()
    [0.0, 20000.0, -20000.0]
    """

    def reset(self, angle: float) -> None:
        """Start at rest at a desired angle [rad], with the memory that homing leaves."""

    def step(self, angle: float, velocity: float) -> float:
        """Return the term [Pa] for the next sample of the desired path: angle [rad], velocity [rad/s]."""

    def output(self) -> float:
        """Return the present term [Pa] without advancing, so that it can be faded in and out or exchanged."""


@runtime_checkable
class PathCompensator(Protocol):
    """A compensator that answers for a whole desired path at once, such as a learned feedforward."""

    def over(self, angle: Array, velocity: Array, time: Array) -> Array:
        """Return the term (T,) [Pa] along angles [rad], velocities [rad/s] and times [s], (T,) each."""


class InverseCompensator:
    r"""The paper's compensator: :math:`\Delta p = H^{-1}[q_d] - k q_d` with an identified model's inverse.

    Parameters
    ----------
    inverse
        H^-1: angle [rad] -> sheared pressure difference, for instance ``fit.model.inverse()``. Its start state is
        that after homing.
    shear
        k that was added before the fit, x = dp - dp_nom + k q; 0 for the inverse of a sheared model, which subtracts
        it itself. [Pa/rad]
    unit
        Size of one unit of the inverse's output, 1e5 for bar. [Pa]

    Raises
    ------
    ParameterError
        If `inverse` is no model, a number is not finite, or k would be subtracted twice.

    Examples
    --------
    >>> from dehyst import PrandtlIshlinskii
    >>> model = PrandtlIshlinskii([0.0, 0.5], [0.5, 0.5])  # bar -> rad
    >>> compensator = InverseCompensator(model.inverse(), shear=1e5)
    >>> along(compensator, [0.0, 0.1, 0.0]).tolist()
    [0.0, 10000.0, 0.0]
    """

    def __init__(self, inverse: HysteresisModel, shear: float, unit: float = 1e5) -> None:
        if getattr(inverse, "core", "") != PLAYS:
            raise ParameterError(
                f"inverse is a {type(inverse).__name__}, not a hysteresis model of plays; pass model.inverse() of a "
                f"model that was identified from pressure to angle, or a LoopCompensator of dehyst.families."
            )
        self.inverse = inverse
        self.shear = models_kit.parameter_number(shear, "shear")
        refuse_second_shear(inverse, self.shear)
        self.unit = models_kit.parameter_number(unit, "unit")
        self._step = inverse.stepper()
        self._angle = 0.0

    def reset(self, angle: float) -> None:
        """Return to the model's start state, then to the angle."""
        self._step.reset()
        self.step(angle, 0.0)

    def step(self, angle: float, velocity: float) -> float:
        """Return the term for the next desired angle; the velocity does not matter to a rate-independent model."""
        self._step(angle)
        # A sample that is not finite is rejected: then the shear keeps the last angle too.
        if not self._step.rejected:
            self._angle = angle
        return self.output()

    def output(self) -> float:
        """Return the present term. [Pa]"""
        return self.unit * self._step.output - self.shear * self._angle


class RampedCompensator(InverseCompensator):
    r"""The compensator without a homing: its memory is unknown, and it returns the middle of what is possible.

    The term is the middle of the guaranteed interval, the mean of two inverses that begin with the lowest and the
    highest memory that any past can have left. At first that is the straight line through the loop, then it ramps in
    with every stroke, and from a stroke of twice the largest radius on it is that of `InverseCompensator`. Any other
    answer would be wrong by more for some past.

    Parameters
    ----------
    inverse, shear, unit
        As in `InverseCompensator`.
    past
        Range (low, high) that the angle has not left since the memory was that of the inverse's start state: it
        narrows what can be remembered. None: the angle may have been anywhere. [rad]

    Raises
    ------
    ParameterError
        As in `InverseCompensator`.

    Examples
    --------
    The memory is unknown at first and known after a stroke of 0.2 rad; the doubt is the half width of the interval:

    >>> from dehyst import PrandtlIshlinskii
    >>> from dehyst.models import ShearedPrandtlIshlinskii
    >>> model = ShearedPrandtlIshlinskii(PrandtlIshlinskii([0.0, 0.1], [0.5, 0.5]), shear=1.0)
    >>> compensator = RampedCompensator(model.inverse(), shear=0.0)
    >>> compensator.reset(0.0)
    >>> [(round(compensator.step(q, 0.0)), round(compensator.doubt)) for q in (0.0, 0.05, 0.1, 0.05)]
    [(0, 5000), (2500, 2500), (5000, 0), (0, 0)]
    """

    def __init__(
        self,
        inverse: HysteresisModel,
        shear: float,
        unit: float = 1e5,
        past: tuple[float, float] | None = None,
    ) -> None:
        super().__init__(inverse, shear, unit)
        self.past = past
        self._steps = self._ends(0.0)

    def _ends(self, angle: float) -> tuple[Stepper | StackStepper, Stepper | StackStepper]:
        # Any memory lies between these two, and so does its term: plays keep their order.
        lowest, highest = self.inverse.extreme_states(angle, past=self.past)
        return self.inverse.with_state(lowest).stepper(), self.inverse.with_state(highest).stepper()

    def reset(self, angle: float) -> None:
        """Forget everything; the angle is the first of the path."""
        self._steps = self._ends(angle)
        self.step(angle, 0.0)

    def step(self, angle: float, velocity: float) -> float:
        """Return the term for the next desired angle."""
        for step in self._steps:
            step(angle)
        if not self._steps[0].rejected:
            self._angle = angle
        return self.output()

    def output(self) -> float:
        """Return the present term. [Pa]"""
        first, second = self._steps[0].output, self._steps[1].output
        return self.unit * 0.5 * (first + second) - self.shear * self._angle

    @property
    def doubt(self) -> float:
        """Guaranteed half width: largest distance to the term of the true past. [Pa]"""
        first, second = self._steps[0].output, self._steps[1].output
        return self.unit * 0.5 * abs(first - second)


def refuse_second_shear(inverse: Model, shear: float) -> None:
    """Refuse to subtract k q from a compensator that subtracts it itself."""
    k = subtracted_shear(inverse)
    if k and shear:
        raise ParameterError(
            f"k would be subtracted twice: this compensator comes from a loop sheared by {k:g} and subtracts it "
            f"itself, and shear = {shear:g} would do it again. Set shear = 0, or pass model.hysteresis.inverse().",
            shear=shear,
        )


def along(
    compensator: Compensator | PathCompensator,
    angle: npt.ArrayLike,
    velocity: npt.ArrayLike | None = None,
    time: npt.ArrayLike | None = None,
) -> Array:
    """Return a compensator's term along a desired path, (T,). [Pa]

    Parameters
    ----------
    compensator
        Is reset to the first angle, then stepped through the whole path. If it has a method
        ``over(angle, velocity, time)``, alone or besides, and `time` is passed, that computes the whole path in one
        call: it takes a hundredth of the time, and a model that depends on rate gets the speed.
    angle
        Desired angles, (T,). [rad]
    velocity
        Desired velocities, (T,); None for zeros, which suits compensators that do not use it. [rad/s]
    time
        Increasing, (T,). [s]

    Raises
    ------
    ParameterError
        If `compensator` lacks a method, lengths differ, or the path is not finite.
    OutputError
        If the compensator returns anything but a finite number: it would reach the valves.
    """
    at_once = isinstance(compensator, PathCompensator) and time is not None
    missing = []
    for name in ("reset", "step", "output"):
        if not callable(getattr(compensator, name, None)):
            missing.append(name)
    if missing and not at_once:
        raise ParameterError(
            f"a {type(compensator).__name__} is no compensator: it lacks {' and '.join(missing)}. Give it "
            f"reset(angle), step(angle, velocity) -> Pa and output() -> Pa; or over(angle, velocity, time) -> Pa, and "
            f"pass the time.",
            missing=tuple(missing),
        )
    q = models_kit.signal_array(angle, "angle")
    qd = np.zeros(q.size)
    if velocity is not None:
        qd = models_kit.signal_array(velocity, "velocity")
    if q.size != qd.size:
        raise ParameterError(
            f"{q.size} angles but {qd.size} velocities; pass one of each a sample."
        )
    if not (np.all(np.isfinite(q)) and np.all(np.isfinite(qd))):
        raise ParameterError(
            "the desired path is not finite everywhere; a compensator must not be driven with it."
        )
    if isinstance(compensator, PathCompensator) and time is not None and q.size:
        return _finite_term(compensator, compensator.over(q, qd, _times(time, q.size)), q)
    assert isinstance(compensator, Compensator)  # its methods were looked for
    term = np.empty(q.size)
    if q.size:
        compensator.reset(float(q[0]))
    for k in range(q.size):
        term[k] = _pressure(compensator, compensator.step(float(q[k]), float(qd[k])), k, q)
    return term


def _times(time: npt.ArrayLike, size: int) -> Array:
    t = models_kit.signal_array(time, "time")
    if t.size != size or not np.all(np.isfinite(t)) or np.any(np.diff(t) <= 0.0):
        raise ParameterError(
            f"time has {t.size} values for {size} angles, or does not increase; pass one time stamp [s] a sample."
        )
    return t


def _finite_term(compensator: PathCompensator, answer: object, q: Array) -> Array:
    # What a user's method returns may be anything: all of it becomes one message.
    try:
        term = np.asarray(answer, dtype=np.float64)
    except (TypeError, ValueError):
        term = np.empty(0)
    if term.shape != q.shape:
        raise OutputError(
            f"{type(compensator).__name__}.over answered {answer!r:.40} for {q.size} angles; it must be one finite "
            f"pressure difference in Pa for each. Correct over(), or remove it: then step() is called."
        )
    # The first sample that is not finite is refused as one of step().
    for k in np.flatnonzero(~np.isfinite(term))[:1]:
        _pressure(compensator, term[k], int(k), q, "over")
    return term


def _pressure(
    compensator: Compensator | PathCompensator,
    answer: object,
    k: int,
    q: Array,
    method: str = "step",
) -> float:
    try:
        value = float(answer)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        value = float("nan")
    if not np.isfinite(value):
        raise OutputError(
            f"{type(compensator).__name__}.{method} answered {answer!r:.40} at sample {k} (desired angle {q[k]:g} "
            f"rad); it must be a finite pressure difference in Pa, because it goes to the valves. Correct {method}(), "
            f"or leave the compensator off.",
            sample=k,
        )
    return value
