"""The stop form: for clockwise loops such as force against displacement."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models.arrays import parameter_array, parameter_number
from dehyst.models.base import HysteresisModel, StackStepper, StepMethod, Stepper
from dehyst.models.card import NO_CARD, ModelCard
from dehyst.models.prandtl_ishlinskii import PrandtlIshlinskii
from dehyst.models.unknown import Plays


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
        put = object.__setattr__  # frozen: normalise once, here
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
        play = self.as_play()  # checks shapes, order and state
        put(self, "state", play.state)

    def as_play(self) -> PrandtlIshlinskii:
        """Return the same operator as a sum of plays."""
        if self.thresholds.size != self.stop_weights.size:
            raise ParameterError(
                f"{self.thresholds.size} thresholds but {self.stop_weights.size} stop weights; pass one per threshold."
            )
        weights = _native.stop_to_play(self.slope, self.stop_weights)
        return PrandtlIshlinskii(self.thresholds, weights, self.offset, self.state, self.center, self.card)

    @property
    def nonzero_weights(self) -> int:
        """Number of stop elements that carry weight, and the slope."""
        return int(np.count_nonzero(self.stop_weights)) + int(self.slope != 0.0)

    @property
    def inverse_gain(self) -> float:
        """Largest slope of the inverse, 1 / min |S_i|; for s >= 0 it is 1/k. [input/output]"""
        return self.as_play().inverse_gain

    def stepper(self, method: StepMethod = "auto") -> Stepper | StackStepper:  # noqa: D102 - see the base class
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
        keep = self.stop_weights != 0.0
        keep[0] = True
        state = None if self.state is None else self.state[keep]
        return replace(self, thresholds=self.thresholds[keep], stop_weights=self.stop_weights[keep], state=state)

    def file_parameters(self) -> dict[str, Any]:  # noqa: D102 - documented in the base class
        return {
            "thresholds": self.thresholds.tolist(),
            "stop_weights": self.stop_weights.tolist(),
            "slope": self.slope,
            "offset": self.offset,
            "center": self.center,
            "state": None if self.state is None else self.state.tolist(),
        }

    def with_state(self, state: npt.ArrayLike | None) -> Self:  # noqa: D102 - documented in the base class
        return replace(self, state=None if state is None else parameter_array(state, "state"))
