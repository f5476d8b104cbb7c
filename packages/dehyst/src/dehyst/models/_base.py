"""Base class of hysteresis models: simulate, step in real time, invert, save."""

from __future__ import annotations

import warnings
from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar, Literal, Self, TypeAlias

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst._native import StackStepper, Stepper
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models._arrays import signal_array
from dehyst.models._machine import Direction, Machine, play_machine
from dehyst.models._model import Band, Model
from dehyst.models._policy import POLICY
from dehyst.models._unknown import Past, Plays, check_past, half_width, held, start_states

if TYPE_CHECKING:
    from dehyst.models._monotone import MonotoneMap

__all__ = ["HysteresisModel", "RejectedSamplesWarning", "StackStepper", "StepMethod", "Stepper"]

StepMethod: TypeAlias = Literal["auto", "dense", "logarithmic"] | float | None

_NO_MAP = np.zeros(0)


class RejectedSamplesWarning(UserWarning):
    """Some samples were not finite; the last good output was held for them."""


class HysteresisModel(Model):
    """A rate-independent model y = Gamma[x] with a state, frozen after construction.

    Subclasses give the parameters of the core's general form y = after(H[before(x)]), H a
    Prandtl-Ishlinskii operator; everything else follows from it.
    """

    bounded = True
    core = "plays"
    closeness = 1e-9
    family: ClassVar[str] = ""

    @abstractmethod
    def inverse(self) -> HysteresisModel:
        """Return the model that undoes this one, state included: x = inverse.simulate(model.simulate(x))."""

    @property
    def kinds(self) -> tuple[str, ...]:
        """ "play" or "stop", and "map" if there is one before or behind them."""
        if self.maps == (None, None):
            return (self.operators[0],)
        return (self.operators[0], "map")

    @abstractmethod
    def with_state(self, state: npt.ArrayLike | None) -> Self:
        """Return the same model starting from another state (n,)."""

    @abstractmethod
    def stepper(self, method: StepMethod = "auto") -> Stepper | StackStepper:
        """Return the model as a function of one sample, for real time.

        Parameters
        ----------
        method
            "dense" takes every operator into account at every sample: a time proportional to n that hardly depends on
            the signal, with bits that are the same on every machine.
            "logarithmic" keeps the operators in segments: a sample costs O(log n) at worst, and hardly anything while
            the input goes on in one direction; outputs agree with dense steps within 1e-14 of max|y|. "auto" is dense
            up to 100 operators and logarithmic above. A period [s] in its place, which other models need, or None, is
            "auto": plays answer the same at any.

        Returns
        -------
        step
            Called with a sample, it returns the output; a period [s] behind it, which other models need, changes
            nothing.

        Raises
        ------
        ParameterError
            If there is no such method.

        Notes
        -----
        The state lives in the stepper, not in the model: ``step(x_k)`` advances it, ``step.save()`` and
        ``step.restore(image)`` copy it, ``step.reset()`` returns to the model's start state. A sample that is
        not finite holds the last good output, sets ``step.rejected`` and leaves the state untouched.
        """

    @property
    @abstractmethod
    def inverse_gain(self) -> float:
        """Largest slope |dx/dy| of the inverse: how much it amplifies noise. [input/output]"""

    @property
    def parts(self) -> tuple[int, str]:
        """Number of operators that the core moves."""
        return self.radii.size, "operators"

    def times(self, factor: float) -> HysteresisModel | None:
        """Return the model with its output times a factor, the card as it was; None if it cannot be had."""
        return None

    @property
    def radii(self) -> Array:
        """Thresholds of the play operators inside, (n,); a curve without memory has one, 0. [input of the operator]"""
        return self._plays()[0].thresholds

    def __repr__(self) -> str:
        """One line: family, operators, signals and their identified ranges; parameters are attributes."""
        operators = "curve"
        if self.nonzero_weights:
            operators = f"{self.nonzero_weights} of {self.stepper().state.size} operators"
        return f"<{type(self).__name__} {self.family!r}: {operators}, {self.card.input!s} -> {self.card.output!s}>"

    def simulate(
        self, x: npt.ArrayLike, time: npt.ArrayLike | None = None, **signals: npt.ArrayLike
    ) -> Array:
        """Return the model's output for an input signal, starting from the model's state.

        The state of an identified model is that of the actuator before the first sample of its log. At another moment,
        of which nothing is known, the middle of `interval` is never off by more than half its width; `at_rest` begins
        with an actuator that has not moved.

        Parameters
        ----------
        x
            Input samples, (T,). [input] A sample that is not finite is rejected: the last good output is held.
        time
            Not used: the order of the samples is all that counts. [s]

        Returns
        -------
        y : (T,)
            Output samples. [output]

        Warns
        -----
        RejectedSamplesWarning
            If samples were rejected, with their number.

        Notes
        -----
        Short signals are stepped sample by sample and give the bits of ``stepper("dense")``. Long ones, from about a
        hundred samples on, go through an engine whose cost hardly depends on the number of operators; it agrees
        with the steps within 1e-14 of max|y|, and the interpreter is free meanwhile.
        """
        inputs = signal_array(x, "input x")
        self.given(signals, inputs.size)
        # Dense steps have the bits of blocks and of exported code.
        y, rejected = self.stepper("dense").simulate(inputs)
        if rejected:
            warnings.warn(
                f"{rejected} of {y.size} samples are not finite (or beyond {_native.INPUT_LIMIT:g}); the last good "
                f"output was held for them and the state did not move. Clean the input, or read it with "
                f"dehyst.read_log.",
                RejectedSamplesWarning,
                stacklevel=2,
            )
        return y

    def at_rest(self, first: float) -> Self:
        """Return the same model as if it had been at rest at a first input since ever: no play is displaced.

        Examples
        --------
        >>> from dehyst import PrandtlIshlinskii
        >>> model = PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0])
        >>> model.simulate([2.0]).tolist(), model.at_rest(2.0).simulate([2.0]).tolist()
        ([3.5], [4.0])
        """
        # At rest every play stands in the middle, at the argument itself.
        plays, before, _ = self._plays()
        value = float(first) if before is None else float(before([first])[0])
        return self.with_state(np.full(plays.thresholds.size, value - plays.center))

    def after_strokes(self, first: float, rising: bool) -> Self:
        plays, before, _ = self._plays()
        low, high = self.ends
        # A signal that rises to its first sample went to the upper end of the range and to the lower one before.
        turns = [high, low, float(first)] if rising else [low, high, float(first)]
        if before is not None:
            turns = before(turns).tolist()
        z = np.zeros(plays.thresholds.size)
        for turn in turns:
            u = turn - plays.center
            z = np.clip(z, u - plays.thresholds, u + plays.thresholds)
        return self.with_state(z)

    def interval(
        self, x: npt.ArrayLike, known: float | None = None, past: Past = None
    ) -> tuple[Array, Array]:
        r"""Return the interval in which the output lies whatever the actuator did before the first sample.

        Parameters
        ----------
        x
            Input samples, (T,). [input]
        known
            Radius up to which the plays are in the model's state, such as the half stroke of a homing; larger ones may
            be in any state that goes with it. None: nothing is known, not even where the input came from. [input]
        past
            Range (low, high) that the input has not left since the memory was that of the model's start state, such as
            the actuator's range of travel. None: it may have been anywhere. [input]

        Returns
        -------
        low, high : (T,)
            Smallest and largest output over all admissible start states. Both are attained, whatever the signs of the
            weights; with a past range, if all weights but the first have one sign. Infinite before the first finite
            sample. [output]

        Raises
        ------
        ParameterError
            If `known` is negative, or `past` is no range.

        Notes
        -----
        The interval of an operator never grows, and is a point from the first stroke of length 2 r_n on. That of a
        model with an output map is the map of it. Docs: explanation/unknown-memory.md.

        Examples
        --------
        >>> from dehyst import PrandtlIshlinskii
        >>> low, high = PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0]).interval([0.0, 0.4, 1.0, 0.2])
        >>> low.round(12).tolist(), high.round(12).tolist()
        ([-0.5, 0.3, 1.5, 0.7], [0.5, 0.9, 1.5, 0.7])
        """
        return self._bounds(signal_array(x, "input x"), known, past)

    def extreme_states(
        self, first: float, known: float | None = None, past: Past = None
    ) -> tuple[Array, Array]:
        """Return the lowest and the highest play states (n,) that a past can have left before a first input.

        Every admissible state lies between them, play by play, and stays there along any input; for weights of one
        sign (the first may differ: its play has radius 0) the outputs of both are the ends of `interval`.

        Examples
        --------
        >>> from dehyst import PrandtlIshlinskii
        >>> [state.tolist() for state in PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0]).extreme_states(2.0)]
        [[2.0, 1.5], [2.0, 2.5]]
        """
        plays, before, _ = self._plays()
        value = float(first) if before is None else float(before([first])[0])
        start = start_states(plays, value, known, _mapped(past, before))
        return start.lowest, start.highest

    @property
    def usual_past(self) -> tuple[float, float] | None:
        """The identified range of the input, if the card names one. [input]"""
        low, high = self.card.input.low, self.card.input.high
        if low is None or high is None or not low < high:
            return None
        return low, high

    def band(
        self,
        x: npt.ArrayLike,
        time: npt.ArrayLike | None = None,
        past: Past = None,
        **signals: npt.ArrayLike,
    ) -> Band:
        """Return `interval` with its middle, which is never off by more than half the width, and `certainty`."""
        # The middle is the best answer: whatever the past was, it errs by half of the width at most.
        low, high = self.interval(x, past=past)
        return Band(0.5 * (low + high), low, high, 0.5 * (high - low), self.certainty(x, past=past))

    def certainty(self, x: npt.ArrayLike, known: float | None = None, past: Past = None) -> Array:
        """Return how much of the memory is known, (T,): 0 for nothing, 1 once no start state matters; never falling.

        It is one less the width of the operator's interval as a share of the largest that it can have.

        Examples
        --------
        >>> from dehyst import PrandtlIshlinskii
        >>> PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0]).certainty([0.0, 0.4, 1.0, 0.2]).round(12).tolist()
        [0.0, 0.4, 1.0, 1.0]
        """
        plays, _, _ = self._plays()
        low, high, first = self._operator_interval(signal_array(x, "input x"), known, past)
        # The widest interval is that of an actuator that has not moved yet.
        whole = 2.0 * float(half_width(plays, 0.0))
        share = np.zeros(low.size)
        if first < low.size:
            # Rounding may widen the interval a little; what was known once stays known.
            share[first:] = 1.0
            if whole != 0.0:
                width = (high - low)[first:]
                share[first:] = np.maximum.accumulate(np.clip(1.0 - width / whole, 0.0, 1.0))
        return share

    def with_operator(self, operator: HysteresisModel) -> HysteresisModel:
        """Return the same model around another operator: that itself, where there are no maps around it."""
        return operator

    def _plays(self) -> tuple[Plays, MonotoneMap | None, MonotoneMap | None]:
        """The operator inside, and the maps before and after it."""
        raise NotImplementedError(f"a {type(self).__name__} does not say what its memory is")

    def _bounds(self, x: Array, known_radius: float | None, past: Past) -> tuple[Array, Array]:
        _, _, after = self._plays()
        low, high, first = self._operator_interval(x, known_radius, past)
        if after is not None and first < x.size:
            lower, upper = after(low[first:]), after(high[first:])
            if not after.increasing:
                lower, upper = upper, lower
            low[first:], high[first:] = lower, upper
        return low, high

    def _operator_interval(
        self, x: Array, known_radius: float | None, past: Past
    ) -> tuple[Array, Array, int]:
        """Bounds of the operator's output, infinite before the first good sample, and the index of that."""
        _, before, _ = self._plays()
        # Bounds are infinite until there is a sample that the core takes.
        values, first = held(x, _native.INPUT_LIMIT)
        low, high = np.full(x.size, -np.inf), np.full(x.size, np.inf)
        if first < x.size:
            u = values[first:]
            if before is not None:
                u = before(u)
            bounds = self._inner()._operator_bounds(u, known_radius, _mapped(past, before))
            low[first:], high[first:] = bounds
        return low, high, first

    def _operator_bounds(
        self, u: Array, known_radius: float | None, past: Past
    ) -> tuple[Array, Array]:
        """Bounds of an operator's output along finite inputs."""
        raise NotImplementedError(f"a {type(self).__name__} is no operator")

    def _inner(self) -> HysteresisModel:
        """The operator alone."""
        return self

    def machine(
        self,
        direction: Direction,
        range: tuple[float, float] | None,
        ramp: int,
        period: float | None,
    ) -> Machine:
        return play_machine(self, direction, range, ramp)

    def final_state(self, x: npt.ArrayLike) -> Array:
        """Return the play states (n,) after an input signal, for ``with_state``."""
        # The outputs are not needed; the stepper holds the states after the last sample.
        step = self.stepper("dense")
        step.simulate(signal_array(x, "input x"))
        return step.state

    def moved(
        self, x: npt.ArrayLike, time: npt.ArrayLike | None = None, **signals: npt.ArrayLike
    ) -> Self:
        return self.with_state(self.final_state(x))


def _mapped(past: Past, before: MonotoneMap | None) -> Past:
    """Past range behind a map in front."""
    past = check_past(past)
    if past is None or before is None:
        return past
    ends = before(list(past))
    return float(np.min(ends)), float(np.max(ends))


def make_stepper(
    thresholds: Array,
    weights: Array,
    center: float,
    offset: float,
    state: Array,
    before: tuple[Array, Array] | None = None,
    after: tuple[Array, Array] | None = None,
    method: StepMethod = "auto",
) -> Stepper | StackStepper:
    """Build one of the core's steppers from the parameters of the general form."""
    # A period in place of a method, as other models need it, changes nothing.
    if method is None or isinstance(method, (int, float)):
        method = "auto"
    if method not in ("auto", "dense", "logarithmic"):
        raise ParameterError(
            f"method = {method!r:.40} is no way to step; pass 'dense' (time proportional to the number of operators, "
            f"bits of exported code), 'logarithmic' (for many operators) or 'auto'.",
            method=method,
        )
    dense = method == "dense" or (method == "auto" and thresholds.size <= POLICY.dense_up_to)
    before_u, before_v = before or (_NO_MAP, _NO_MAP)
    after_u, after_v = after or (_NO_MAP, _NO_MAP)
    kind = Stepper if dense else StackStepper
    return kind(thresholds, weights, center, offset, before_u, before_v, after_u, after_v, state)


def check_state(state: Array, thresholds: Array) -> None:
    """Raise unless ``|z_i - z_{i+1}| <= r_{i+1} - r_i``: only such states can follow from an input.

    The closed inverse is exact for admissible states only; an arbitrary vector breaks it.
    """
    if state.size != thresholds.size:
        raise ParameterError(
            f"state has {state.size} values for {thresholds.size} play operators; pass one per operator, "
            f"or state=None for the model at rest in its centre.",
            state=state.size,
            operators=thresholds.size,
        )
    # States that were computed from an input may miss the condition by rounding.
    slack = 1e-9 * max(float(thresholds[-1]), float(np.max(np.abs(state))), 1e-300)
    fault = np.flatnonzero(np.abs(np.diff(state)) > np.diff(thresholds) + slack)
    if fault.size:
        k = int(fault[0])
        raise ParameterError(
            f"state is not admissible: |z[{k}] - z[{k + 1}]| = {abs(state[k] - state[k + 1]):g} exceeds "
            f"r[{k + 1}] - r[{k}] = {thresholds[k + 1] - thresholds[k]:g}. No input can produce it, and the "
            f"inverse would be wrong. Use model.final_state(x) of a real input, or state=None.",
            index=k,
        )
