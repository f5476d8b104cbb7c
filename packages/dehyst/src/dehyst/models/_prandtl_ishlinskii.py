"""The Prandtl-Ishlinskii operator (sum of plays), its closed-form inverse, and its form as a sum of stops."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import InvertibilityError, ParameterError
from dehyst.models._arrays import parameter_array, parameter_number, strictly_increasing
from dehyst.models._base import (
    HysteresisModel,
    StackStepper,
    StepMethod,
    Stepper,
    check_state,
    make_stepper,
)
from dehyst.models._card import NO_CARD, ModelCard
from dehyst.models._unknown import ROUNDING, Past, Plays, half_strokes, half_width, start_states


@dataclass(frozen=True, eq=False, repr=False)
class PrandtlIshlinskii(HysteresisModel):
    r"""Prandtl-Ishlinskii operator: a weighted sum of play operators.

    .. math::

        z_i[k] = \max(x_k - c - r_i, \min(x_k - c + r_i, z_i[k-1])), \qquad
        y_k = y_0 + \sum_{i=1}^{n} w_i z_i[k]

    Parameters
    ----------
    thresholds
        r, (n,), strictly increasing, r_1 >= 0; the inverse needs r_1 = 0. [input]
    weights
        w, (n,). [output/input] The inverse needs all partial sums w_1 + ... + w_i to have one sign.
    offset
        y_0, output of the state zero. [output]
    state
        z before the first sample, (n,), of the centred input; None is zero, the state after a decaying
        oscillation around the centre. Must be admissible: |z_i - z_{i+1}| <= r_{i+1} - r_i. [input]
    center
        c, subtracted from the input. [input]
    card
        Names and units of the signals, provenance.

    Raises
    ------
    ParameterError
        If shapes differ, thresholds do not increase, a value is not finite, or the state is not admissible.

    References
    ----------
    K. Kuhnen, "Modeling, identification and compensation of complex hysteretic nonlinearities: a modified
    Prandtl-Ishlinskii approach", European Journal of Control 9(4), 2003.

    Examples
    --------
    >>> model = PrandtlIshlinskii(thresholds=[0.0, 0.5], weights=[1.0, 1.0])
    >>> model.simulate([0.0, 1.0, 0.0]).tolist()
    [0.0, 1.5, 0.5]
    >>> model.inverse().simulate([0.0, 1.5, 0.5]).tolist()
    [0.0, 1.0, 0.0]
    """

    thresholds: Array
    weights: Array
    offset: float = 0.0
    state: Array | None = None
    center: float = 0.0
    card: ModelCard = NO_CARD
    family: ClassVar[str] = "pi"

    def __post_init__(self) -> None:
        # The record is frozen: its values are checked and made arrays once, here.
        put = object.__setattr__
        put(self, "thresholds", parameter_array(self.thresholds, "thresholds"))
        put(self, "weights", parameter_array(self.weights, "weights"))
        put(self, "offset", parameter_number(self.offset, "offset"))
        put(self, "center", parameter_number(self.center, "center"))
        r = self.thresholds
        if r.size != self.weights.size:
            raise ParameterError(
                f"{r.size} thresholds but {self.weights.size} weights; pass one weight per threshold.",
                thresholds=r.size,
                weights=self.weights.size,
            )
        if r[0] < 0:
            raise ParameterError(
                f"thresholds[0] = {r[0]:g} is negative; a play has a radius r >= 0.", index=0
            )
        strictly_increasing(r, "thresholds")
        if self.state is not None:
            put(self, "state", parameter_array(self.state, "state"))
            check_state(self._state, r)

    @property
    def _state(self) -> Array:
        if self.state is None:
            return np.zeros(self.thresholds.size)
        return self.state

    @property
    def partial_sums(self) -> Array:
        """S_i = w_1 + ... + w_i, (n,): the slopes of the initial loading curve. [output/input]"""
        return np.cumsum(self.weights)

    @property
    def nonzero_weights(self) -> int:
        """Number of operators that carry weight."""
        return int(np.count_nonzero(self.weights))

    @property
    def inverse_gain(self) -> float:
        """Largest slope of the inverse, 1 / min_i |S_i|; right after a reversal it is 1/|w_1|. [input/output]"""
        # The slopes of the inverse are 1/S_i, along its own loading curve.
        smallest = float(np.min(np.abs(self.partial_sums)))
        return float("inf") if smallest == 0.0 else 1.0 / smallest

    def loading_curve(self, radius: npt.ArrayLike) -> Array:
        r"""Initial loading curve :math:`\varphi(r) = \sum_i w_i \max(r - r_i, 0)`.

        It is the output, less the offset, while the input rises from the state zero; the inverse model has the
        inverse curve.

        Examples
        --------
        >>> PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0]).loading_curve([0.5, 1.0]).tolist()
        [0.5, 1.5]
        """
        r = np.asarray(radius, dtype=np.float64)
        return np.maximum(r[..., None] - self.thresholds, 0.0) @ self.weights

    def stepper(self, method: StepMethod = "auto") -> Stepper | StackStepper:
        return make_stepper(
            self.thresholds, self.weights, self.center, self.offset, self._state, method=method
        )

    def inverse(self) -> PrandtlIshlinskii:
        r"""Return the closed inverse, itself a Prandtl-Ishlinskii operator.

        .. math::

            r'_i = \sum_{j \le i} w_j (r_i - r_j), \quad w'_1 = 1/w_1, \quad w'_i = -\frac{w_i}{S_i S_{i-1}},
            \quad z'_i = \sum_{j \le i} w_j z_i + \sum_{j > i} w_j z_j

        Centre and offset change places. The 2012 paper prints :math:`w_j (r_i - w_j)` in its equation (18),
        which does not invert; see docs/explanation/paper-misprint.md.

        Raises
        ------
        InvertibilityError
            If r_1 > 0 or a partial sum S_i is zero or changes sign.
        """
        fault, r, w, z = _native.pi_invert(self.thresholds, self.weights, self._state)
        if fault == -1:
            raise InvertibilityError(
                f"this model has no inverse: its smallest threshold is {self.thresholds[0]:g}, so inputs that move "
                f"less than that give the same output. Add an operator with threshold 0 and a small positive weight.",
                threshold=float(self.thresholds[0]),
            )
        if fault:
            sums = self.partial_sums
            raise InvertibilityError(
                f"this model has no closed inverse: the partial sum of the first {fault} weights is "
                f"{sums[fault - 1]:g} while the first weight is {self.weights[0]:g}; all partial sums must share one "
                f"sign, or the output turns while the input does not. Identify with w >= 0 (family 'pi') or with "
                f"positive partial sums (family 'pi-cumulative').",
                index=fault - 1,
                partial_sum=float(sums[fault - 1]),
            )
        # A state that was left out stays left out, so that the inverse of an inverse is the model itself.
        state = None if self.state is None and not z.any() else z
        try:
            return PrandtlIshlinskii(r, w, self.center, state, self.offset, self.card.swapped())
        except ParameterError as why:
            raise InvertibilityError(
                f"the inverse of this model cannot be represented in double precision: {why} Its weights span "
                f"{np.min(np.abs(self.partial_sums)):g} to {np.max(np.abs(self.partial_sums)):g} in partial sums; "
                f"raise eps or merge operators that lie close together.",
            ) from None

    def _plays(self) -> tuple[Plays, None, None]:
        return Plays(self.thresholds, self.weights, self.center, self._state), None, None

    def _operator_bounds(
        self, u: Array, known_radius: float | None, past: Past
    ) -> tuple[Array, Array]:
        plays = self._plays()[0]
        start = start_states(plays, float(u[0]), known_radius, past)
        low = self.with_state(start.lowest).simulate(u)
        high = self.with_state(start.highest).simulate(u)
        # A play of radius 0 has no memory, so its weight may have either sign.
        with_memory = self.weights[int(self.thresholds[0] == 0.0) :]
        if np.all(with_memory >= 0.0) or np.all(with_memory <= 0.0):
            return np.minimum(low, high), np.maximum(low, high)
        if past is not None:
            return self._mixed_bounds(u, known_radius, past)
        width = half_width(plays, half_strokes(u - self.center, start))
        # The guarantee holds in exact arithmetic; the slack covers what rounding adds.
        size = float(np.abs(self.weights) @ (self.thresholds + np.max(np.abs(u - self.center))))
        slack = np.where(width > 0.0, ROUNDING * size, 0.0)
        middle = 0.5 * (low + high)
        return middle - width - slack, middle + width + slack

    def _mixed_bounds(
        self, u: Array, known_radius: float | None, past: Past
    ) -> tuple[Array, Array]:
        """Return bounds with a past range: the sum of those of the weights of either sign, and those of any past."""
        rising = replace(self, weights=np.maximum(self.weights, 0.0))
        falling = replace(self, weights=np.minimum(self.weights, 0.0), offset=0.0)
        rising_low, rising_high = rising._operator_bounds(u, known_radius, past)
        falling_low, falling_high = falling._operator_bounds(u, known_radius, past)
        # Both pairs of bounds hold, so the narrower one does at every sample.
        low, high = self._operator_bounds(u, known_radius, None)
        return np.maximum(rising_low + falling_low, low), np.minimum(
            rising_high + falling_high, high
        )

    def file_parameters(self) -> dict[str, Any]:
        return {
            "thresholds": self.thresholds.tolist(),
            "weights": self.weights.tolist(),
            "offset": self.offset,
            "center": self.center,
            "state": _listed(self.state),
        }

    def with_state(self, state: npt.ArrayLike | None) -> Self:
        if state is not None:
            state = parameter_array(state, "state")
        return replace(self, state=state)

    @property
    def play_core(self) -> PrandtlIshlinskii:
        """Itself."""
        return self

    @property
    def operators(self) -> tuple[str, Array, float | None]:
        """Plays with their weights."""
        return "play", self.weights, None

    def times(self, factor: float) -> PrandtlIshlinskii:
        return replace(self, weights=self.weights * factor, offset=self.offset * factor)

    def pruned(self) -> PrandtlIshlinskii:
        """Return the same operator without its zero weights, which is exact; threshold 0 stays."""
        # The inverse needs the threshold 0, even where its weight is 0.
        keep = self.weights != 0.0
        keep[0] = True
        state = self.state
        if state is not None:
            state = state[keep]
        return replace(
            self, thresholds=self.thresholds[keep], weights=self.weights[keep], state=state
        )


def _listed(state: Array | None) -> list[float] | None:
    """Return a state as it stands in a file."""
    if state is None:
        return None
    values: list[float] = state.tolist()
    return values


class AroundPlays(HysteresisModel):
    """A model with a sum of plays inside, `hysteresis`: maps around it, or a shear."""

    hysteresis: PrandtlIshlinskii

    def _take_card(self) -> None:
        """One card a model: that of the operator inside would not reach the file."""
        if self.card is NO_CARD:
            object.__setattr__(self, "card", self.hysteresis.card)
        object.__setattr__(self, "hysteresis", self.hysteresis.with_card(NO_CARD))

    @property
    def nonzero_weights(self) -> int:
        """Number of play operators that carry weight."""
        return self.hysteresis.nonzero_weights

    @property
    def play_core(self) -> PrandtlIshlinskii:
        """The operator H."""
        return self.hysteresis

    @property
    def operators(self) -> tuple[str, Array, float | None]:
        """Those of H."""
        return self.hysteresis.operators

    def with_state(self, state: npt.ArrayLike | None) -> Self:
        """Return the same model starting from another state (n,) of H."""
        return replace(self, hysteresis=self.hysteresis.with_state(state))  # type: ignore[type-var]

    def pruned(self) -> Self:
        """Return the same model without operators of weight zero, which is exact."""
        return replace(self, hysteresis=self.hysteresis.pruned())  # type: ignore[type-var]


@dataclass(frozen=True, eq=False, repr=False)
class StopOperatorModel(HysteresisModel):
    r"""Prandtl-Ishlinskii operator of stop type, the rheological Maxwell-slip model.

    .. math::

        y = y_0 + k (x - c) + \sum_{i \ge 2} s_i E_{r_i}[x - c], \qquad E_r = \mathrm{identity} - \mathrm{play}_r

    With s >= 0 its loops run clockwise. It equals a play operator with w_1 = k + sum s and w_i = -s_i, whose
    partial sums are positive when k > 0: the closed inverse holds.

    Parameters
    ----------
    thresholds
        r, (n,), strictly increasing from r_1 = 0, whose stop is zero. [input]
    stop_weights
        s, (n,), s_1 = 0: stiffness of each element. [output/input]
    slope
        k, elastic slope that remains when all elements slip. [output/input]
    offset, state, center, card
        As in PrandtlIshlinskii; the state is that of the plays (n,).

    Raises
    ------
    ParameterError
        If r_1 is not 0, s_1 is not 0, or anything PrandtlIshlinskii refuses.

    Examples
    --------
    >>> model = StopOperatorModel([0.0, 0.5], [0.0, 2.0], slope=1.0)
    >>> model.simulate([0.0, 1.0, 0.0]).tolist()
    [0.0, 2.0, -1.0]
    """

    thresholds: Array
    stop_weights: Array
    slope: float
    offset: float = 0.0
    state: Array | None = None
    center: float = 0.0
    card: ModelCard = NO_CARD
    family: ClassVar[str] = "stop"

    def __post_init__(self) -> None:
        # The record is frozen: its values are checked and made arrays once, here.
        put = object.__setattr__
        put(self, "thresholds", parameter_array(self.thresholds, "thresholds"))
        put(self, "stop_weights", parameter_array(self.stop_weights, "stop_weights"))
        put(self, "slope", parameter_number(self.slope, "slope"))
        put(self, "offset", parameter_number(self.offset, "offset"))
        put(self, "center", parameter_number(self.center, "center"))
        if self.thresholds[0] != 0.0 or self.stop_weights[0] != 0.0:
            raise ParameterError(
                f"the first element must be r_1 = 0 with s_1 = 0 (a stop of radius zero carries nothing), got "
                f"r_1 = {self.thresholds[0]:g}, s_1 = {self.stop_weights[0]:g}.",
            )
        # The sum of plays checks shapes, order and state.
        play = self.as_play()
        put(self, "state", play.state)

    def as_play(self) -> PrandtlIshlinskii:
        """Return the same operator as a sum of plays."""
        if self.thresholds.size != self.stop_weights.size:
            raise ParameterError(
                f"{self.thresholds.size} thresholds but {self.stop_weights.size} stop weights; pass one per threshold."
            )
        # A stop is the identity less a play, so that the first weight holds all stiffnesses.
        weights = _native.stop_to_play(self.slope, self.stop_weights)
        return PrandtlIshlinskii(
            self.thresholds, weights, self.offset, self.state, self.center, self.card
        )

    @property
    def nonzero_weights(self) -> int:
        """Number of stop elements that carry weight, and the slope."""
        return int(np.count_nonzero(self.stop_weights)) + int(self.slope != 0.0)

    @property
    def inverse_gain(self) -> float:
        """Largest slope of the inverse, 1 / min |S_i|; for s >= 0 it is 1/k. [input/output]"""
        return self.as_play().inverse_gain

    def stepper(self, method: StepMethod = "auto") -> Stepper | StackStepper:
        return self.as_play().stepper(method)

    def inverse(self) -> PrandtlIshlinskii:
        """Return the closed inverse; it is a play operator with non-negative weights when s >= 0."""
        return self.as_play().inverse()

    def _plays(self) -> tuple[Plays, None, None]:
        return self.as_play()._plays()

    def _inner(self) -> HysteresisModel:
        return self.as_play()

    @property
    def play_core(self) -> PrandtlIshlinskii:
        """The same operator as a sum of plays."""
        return self.as_play()

    @property
    def operators(self) -> tuple[str, Array, float | None]:
        """Stops with their weights, and k."""
        return "stop", self.stop_weights, self.slope

    def times(self, factor: float) -> PrandtlIshlinskii:
        """Return the sum of plays with its output times a factor."""
        return self.as_play().times(factor)

    def pruned(self) -> Self:
        """Return the same model without stops of weight zero, which is exact; threshold 0 stays."""
        # The first element has radius 0 and stands for the slope; it stays.
        keep = self.stop_weights != 0.0
        keep[0] = True
        state = self.state
        if state is not None:
            state = state[keep]
        return replace(
            self,
            thresholds=self.thresholds[keep],
            stop_weights=self.stop_weights[keep],
            state=state,
        )

    def file_parameters(self) -> dict[str, Any]:
        return {
            "thresholds": self.thresholds.tolist(),
            "stop_weights": self.stop_weights.tolist(),
            "slope": self.slope,
            "offset": self.offset,
            "center": self.center,
            "state": _listed(self.state),
        }

    def with_state(self, state: npt.ArrayLike | None) -> Self:
        if state is not None:
            state = parameter_array(state, "state")
        return replace(self, state=state)
