"""Monotone piecewise linear maps, the curve without hysteresis, and modified Prandtl-Ishlinskii models."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self, cast

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models._arrays import parameter_array, signal_array, strictly_increasing
from dehyst.models._base import HysteresisModel, StackStepper, StepMethod, Stepper, make_stepper
from dehyst.models._card import NO_CARD, ModelCard
from dehyst.models._prandtl_ishlinskii import AroundPlays, PrandtlIshlinskii
from dehyst.models._unknown import Plays


@dataclass(frozen=True, eq=False)
class MonotoneMap:
    r"""Strictly monotone, piecewise linear map v(u), continued along its end segments.

    Equal to Kuhnen's superposition of one-sided dead-zone operators,
    :math:`S[u] = v_m + \sum_i w_i S_{r_i}(u - u_m)`, with the slopes as partial sums of the weights; its inverse
    only swaps the two lists, which is exact.

    Parameters
    ----------
    u
        Breakpoints, (m,), m >= 2, strictly increasing.
    v
        Values, (m,), strictly increasing or strictly decreasing.

    Raises
    ------
    ParameterError
        If the map is not strictly monotone.

    Examples
    --------
    >>> bend = MonotoneMap([0.0, 1.0, 2.0], [0.0, 1.0, 1.5])
    >>> bend([0.5, 3.0]).tolist()
    [0.5, 2.0]
    >>> bend.inverse()([0.5, 2.0]).tolist()
    [0.5, 3.0]
    """

    u: Array
    v: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "u", parameter_array(self.u, "u"))
        object.__setattr__(self, "v", parameter_array(self.v, "v"))
        if self.u.size != self.v.size or self.u.size < 2:
            raise ParameterError(
                f"a map needs at least two breakpoints and as many values, got {self.u.size} and {self.v.size}.",
                u=self.u.size,
                v=self.v.size,
            )
        strictly_increasing(self.u, "u")
        # A falling map is a rising one of the values with the other sign.
        if self.increasing:
            strictly_increasing(self.v, "v")
        else:
            strictly_increasing(-self.v, "-v")

    @property
    def increasing(self) -> bool:
        """Whether the map rises."""
        return bool(self.v[-1] > self.v[0])

    @property
    def slopes(self) -> Array:
        """Slopes of the segments, (m - 1,). [v/u]"""
        return np.diff(self.v) / np.diff(self.u)

    @property
    def inverse_gain(self) -> float:
        """Largest slope of the inverse map; infinite where a slope is too small for double precision. [u/v]"""
        # The flattest segment of the map is the steepest one of its inverse.
        flattest = float(np.min(np.abs(self.slopes)))
        return float("inf") if flattest == 0.0 else 1.0 / flattest

    def __call__(self, u: npt.ArrayLike) -> Array:
        """Return the values at u, (T,)."""
        return _native.map_values(self.u, self.v, signal_array(u, "u"))

    def file_parameters(self) -> dict[str, list[float]]:
        """Return breakpoints and values as plain JSON values."""
        return {"u": self.u.tolist(), "v": self.v.tolist()}

    def inverse(self) -> MonotoneMap:
        """Return the inverse map."""
        if self.increasing:
            return MonotoneMap(self.v, self.u)
        # Arguments of a map must increase.
        return MonotoneMap(self.v[::-1], self.u[::-1])

    @property
    def pairs(self) -> tuple[Array, Array]:
        """Breakpoints and values, as the core takes them."""
        return self.u, self.v


# A curve is a play of radius 0 and weight 1, which has no memory, with a map in front.
_IDENTITY = np.ones(1)
_ZERO = np.zeros(1)


@dataclass(frozen=True, eq=False, repr=False)
class StaticCurve(HysteresisModel):
    """Memoryless monotone curve y = v(x).

    Parameters
    ----------
    curve
        The map.
    card
        Names and units of the signals, provenance.

    Examples
    --------
    >>> StaticCurve(MonotoneMap([0.0, 1.0], [0.0, 2.0])).simulate([0.5]).tolist()
    [1.0]
    """

    curve: MonotoneMap
    card: ModelCard = NO_CARD
    family: ClassVar[str] = "static"

    @property
    def nonzero_weights(self) -> int:
        """A curve has no operators with memory."""
        return 0

    @property
    def free_parameters(self) -> int:
        """Number of points of the curve."""
        return int(self.curve.v.size)

    @property
    def kinds(self) -> tuple[str, ...]:
        """A map."""
        return ("map",)

    @property
    def inverse_gain(self) -> float:
        """Largest slope of the inverse curve. [input/output]"""
        return self.curve.inverse_gain

    def stepper(self, method: StepMethod = "auto") -> Stepper | StackStepper:
        return make_stepper(
            _ZERO, _IDENTITY, 0.0, 0.0, _ZERO, before=self.curve.pairs, method=method
        )

    def inverse(self) -> StaticCurve:
        """Return the inverse curve."""
        return StaticCurve(self.curve.inverse(), self.card.swapped())

    def _plays(self) -> tuple[Plays, MonotoneMap, None]:
        return Plays(_ZERO, _IDENTITY, 0.0, _ZERO), self.curve, None

    def _inner(self) -> HysteresisModel:
        # The operator alone is the identity: the curve is the map in front of it.
        return PrandtlIshlinskii(_ZERO, _IDENTITY)

    def file_parameters(self) -> dict[str, Any]:
        return {"curve": self.curve.file_parameters()}

    def with_state(self, state: npt.ArrayLike | None) -> Self:
        """Return the curve itself: it has no memory."""
        return self


@dataclass(frozen=True, eq=False, repr=False)
class ModifiedPrandtlIshlinskii(AroundPlays):
    r"""Modified Prandtl-Ishlinskii model for loops that saturate or are asymmetric.

    .. math:: y = S(H[x]), \qquad x = H^{-1}[S^{-1}(y)]

    S is a monotone piecewise linear map behind the operator H. Its inverse has the map in front, so the class
    carries both places; at least one is used.

    Parameters
    ----------
    hysteresis
        The operator H, with offset, centre and state.
    after_map
        S, map of the operator's output, or None. [output]
    before_map
        Map of the input, or None. [input]
    card
        Names and units of the signals, provenance; by default that of the operator.

    Raises
    ------
    ParameterError
        If no map is given: then it is a plain PrandtlIshlinskii.

    References
    ----------
    K. Kuhnen, European Journal of Control 9(4), 2003, section on memory-free nonlinearities.

    Examples
    --------
    >>> inner = PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0])
    >>> model = ModifiedPrandtlIshlinskii(inner, after_map=MonotoneMap([0.0, 1.0, 2.0], [0.0, 1.0, 1.2]))
    >>> model.simulate([0.0, 1.0, 0.0]).round(12).tolist()
    [0.0, 1.1, 0.5]
    >>> model.inverse().simulate([0.0, 1.1, 0.5]).round(12).tolist()
    [0.0, 1.0, 0.0]
    """

    hysteresis: PrandtlIshlinskii
    after_map: MonotoneMap | None = None
    before_map: MonotoneMap | None = None
    card: ModelCard = NO_CARD
    family: ClassVar[str] = "modified-pi"

    def __post_init__(self) -> None:
        # Without a map the class would be a second name for the same operator.
        if self.after_map is None and self.before_map is None:
            raise ParameterError(
                "a modified Prandtl-Ishlinskii model without a map is a plain one; pass after_map=MonotoneMap(...) "
                "or use the PrandtlIshlinskii itself."
            )
        self._take_card()

    @property
    def inverse_gain(self) -> float:
        """Bound of the inverse's slope: that of H^-1 times the steepest parts of the inverse maps. [input/output]"""
        # Slopes of a chain multiply; the steepest parts need not meet, so this is a bound.
        gain = self.hysteresis.inverse_gain
        for mapping in (self.after_map, self.before_map):
            if mapping is not None:
                gain *= mapping.inverse_gain
        return gain

    def stepper(self, method: StepMethod = "auto") -> Stepper | StackStepper:
        inner = self.hysteresis
        return make_stepper(
            inner.thresholds,
            inner.weights,
            inner.center,
            inner.offset,
            inner._state,
            before=_pairs(self.before_map),
            after=_pairs(self.after_map),
            method=method,
        )

    def inverse(self) -> ModifiedPrandtlIshlinskii:
        """Return x = before^-1(H^-1[after^-1(y)]), a model of the same class."""
        return ModifiedPrandtlIshlinskii(
            self.hysteresis.inverse(),
            after_map=_inverted(self.before_map),
            before_map=_inverted(self.after_map),
            card=self.card.swapped(),
        )

    def _plays(self) -> tuple[Plays, MonotoneMap | None, MonotoneMap | None]:
        return self.hysteresis._plays()[0], self.before_map, self.after_map

    def _inner(self) -> HysteresisModel:
        return self.hysteresis

    def with_operator(self, operator: HysteresisModel) -> HysteresisModel:
        """Return the same maps around another operator."""
        return replace(self, hysteresis=cast(PrandtlIshlinskii, operator))

    @property
    def maps(self) -> tuple[MonotoneMap | None, MonotoneMap | None]:
        """Maps before and after H."""
        return self.before_map, self.after_map

    def times(self, factor: float) -> ModifiedPrandtlIshlinskii:
        # The last part of the chain is scaled: the map behind the operator, or the operator itself.
        if self.after_map is None:
            return replace(self, hysteresis=self.hysteresis.times(factor))
        return replace(self, after_map=MonotoneMap(self.after_map.u, self.after_map.v * factor))

    def file_parameters(self) -> dict[str, Any]:
        parameters: dict[str, Any] = {"hysteresis": self.hysteresis.file_parameters()}
        for name, mapping in (("after", self.after_map), ("before", self.before_map)):
            parameters[name] = None
            if mapping is not None:
                parameters[name] = mapping.file_parameters()
        return parameters


def _pairs(mapping: MonotoneMap | None) -> tuple[Array, Array] | None:
    if mapping is None:
        return None
    return mapping.pairs


def _inverted(mapping: MonotoneMap | None) -> MonotoneMap | None:
    if mapping is None:
        return None
    return mapping.inverse()
