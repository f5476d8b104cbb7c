"""A curve without hysteresis: what every hysteresis model has to beat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from dehyst.models.base import HysteresisModel, StackStepper, StepMethod, Stepper, make_stepper
from dehyst.models.card import NO_CARD, ModelCard
from dehyst.models.monotone import MonotoneMap
from dehyst.models.prandtl_ishlinskii import PrandtlIshlinskii
from dehyst.models.unknown import Plays

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
    def kinds(self) -> tuple[str, ...]:
        """A map."""
        return ("map",)

    @property
    def inverse_gain(self) -> float:
        """Largest slope of the inverse curve. [input/output]"""
        return self.curve.inverse_gain

    def stepper(self, method: StepMethod = "auto") -> Stepper | StackStepper:  # noqa: D102 - see the base class
        return make_stepper(_ZERO, _IDENTITY, 0.0, 0.0, _ZERO, before=self.curve.pairs, method=method)

    def inverse(self) -> StaticCurve:
        """Return the inverse curve."""
        return StaticCurve(self.curve.inverse(), self.card.swapped())

    def _plays(self) -> tuple[Plays, MonotoneMap, None]:
        return Plays(_ZERO, _IDENTITY, 0.0, _ZERO), self.curve, None

    def _inner(self) -> HysteresisModel:
        return PrandtlIshlinskii(_ZERO, _IDENTITY)

    def file_parameters(self) -> dict[str, Any]:  # noqa: D102 - documented in the base class
        return {"curve": self.curve.file_parameters()}

    def with_state(self, state: npt.ArrayLike | None) -> Self:
        """Return the curve itself: it has no memory."""
        return self
