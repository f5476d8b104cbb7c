"""The modified Prandtl-Ishlinskii model: a monotone map around the operator."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, cast

import numpy as np

from dehyst.errors import ParameterError
from dehyst.models.base import HysteresisModel, StackStepper, StepMethod, Stepper, make_stepper
from dehyst.models.card import NO_CARD, ModelCard
from dehyst.models.monotone import MonotoneMap
from dehyst.models.prandtl_ishlinskii import AroundPlays, PrandtlIshlinskii
from dehyst.models.unknown import Plays


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
    after
        S, map of the operator's output, or None. [output]
    before
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
    >>> model = ModifiedPrandtlIshlinskii(inner, after=MonotoneMap([0.0, 1.0, 2.0], [0.0, 1.0, 1.2]))
    >>> model.simulate([0.0, 1.0, 0.0]).round(12).tolist()
    [0.0, 1.1, 0.5]
    >>> model.inverse().simulate([0.0, 1.1, 0.5]).round(12).tolist()
    [0.0, 1.0, 0.0]
    """

    hysteresis: PrandtlIshlinskii
    after: MonotoneMap | None = None
    before: MonotoneMap | None = None
    card: ModelCard = NO_CARD
    family: ClassVar[str] = "modified-pi"

    def __post_init__(self) -> None:
        if self.after is None and self.before is None:
            raise ParameterError(
                "a modified Prandtl-Ishlinskii model without a map is a plain one; pass after=MonotoneMap(...) "
                "or use the PrandtlIshlinskii itself."
            )
        self._take_card()

    @property
    def inverse_gain(self) -> float:
        """Bound of the inverse's slope: that of H^-1 times the steepest parts of the inverse maps. [input/output]"""
        gain = self.hysteresis.inverse_gain
        for mapping in (self.after, self.before):
            if mapping is not None:
                gain *= mapping.inverse_gain
        return gain

    def stepper(self, method: StepMethod = "auto") -> Stepper | StackStepper:  # noqa: D102 - see the base class
        inner = self.hysteresis
        return make_stepper(
            inner.thresholds,
            inner.weights,
            inner.center,
            inner.offset,
            np.zeros(inner.thresholds.size) if inner.state is None else inner.state,
            before=None if self.before is None else self.before.pairs,
            after=None if self.after is None else self.after.pairs,
            method=method,
        )

    def inverse(self) -> ModifiedPrandtlIshlinskii:
        """Return x = before^-1(H^-1[after^-1(y)]), a model of the same class."""
        return ModifiedPrandtlIshlinskii(
            self.hysteresis.inverse(),
            after=None if self.before is None else self.before.inverse(),
            before=None if self.after is None else self.after.inverse(),
            card=self.card.swapped(),
        )

    def _plays(self) -> tuple[Plays, MonotoneMap | None, MonotoneMap | None]:
        return self.hysteresis._plays()[0], self.before, self.after

    def _inner(self) -> HysteresisModel:
        return self.hysteresis

    def with_operator(self, operator: HysteresisModel) -> HysteresisModel:
        """Return the same maps around another operator."""
        return replace(self, hysteresis=cast(PrandtlIshlinskii, operator))

    @property
    def maps(self) -> tuple[MonotoneMap | None, MonotoneMap | None]:
        """Maps before and after H."""
        return self.before, self.after

    def times(self, factor: float) -> ModifiedPrandtlIshlinskii:  # noqa: D102 - see the base class
        if self.after is None:
            return replace(self, hysteresis=self.hysteresis.times(factor))
        return replace(self, after=MonotoneMap(self.after.u, self.after.v * factor))

    def file_parameters(self) -> dict[str, Any]:  # noqa: D102 - documented in the base class
        maps = {"after": self.after, "before": self.before}
        told = {name: None if each is None else each.file_parameters() for name, each in maps.items()}
        return {"hysteresis": self.hysteresis.file_parameters(), **told}
