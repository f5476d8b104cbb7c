"""Sheared-loop model: hysteresis identified relative to the 45 degree line, used as a correction of the input."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import InvertibilityError, ParameterError
from dehyst.models._arrays import parameter_number
from dehyst.models._base import HysteresisModel, StackStepper, StepMethod, Stepper
from dehyst.models._card import NO_CARD, ModelCard
from dehyst.models._model import Model
from dehyst.models._prandtl_ishlinskii import AroundPlays, PrandtlIshlinskii
from dehyst.models._unknown import Plays

# Key in the provenance of a compensator that subtracts k y itself: nobody must subtract it a second time.
SUBTRACTED = "shear_subtracted"


def subtracted_shear(model: Model) -> float:
    """Return k if this compensator subtracts k y itself, else 0.

    Examples
    --------
    >>> model = ShearedPrandtlIshlinskii(PrandtlIshlinskii([0.0, 0.1], [0.05, 0.04]), shear=10.0)
    >>> subtracted_shear(model.inverse()), subtracted_shear(model.hysteresis.inverse())
    (10.0, 0.0)
    """
    k = model.card.provenance.get(SUBTRACTED, 0.0)
    return float(k) if isinstance(k, int | float) else 0.0


@dataclass(frozen=True, eq=False, repr=False)
class ShearedPrandtlIshlinskii(AroundPlays):
    r"""Prandtl-Ishlinskii operator of the sheared loop, in the coordinates of the log.

    .. math:: y = H[u + k y], \qquad u = G[y] = H^{-1}[y] - k y

    The compensator G subtracts what the shear added, and is itself a sum of plays, exactly: H^-1 with its first weight
    reduced by k. `inverse` returns it, so whatever takes a model's inverse (simulation, blocks, exported code) is
    right without knowing about k. Its slopes 1/S_i - k fall from one partial sum S_i of H to the next. While all are
    positive, the input alone decides the output and the model can be simulated; where the last ones are not, as on a
    joint whose backbone was taken off, only the compensator exists.

    Parameters
    ----------
    hysteresis
        H, from u + k y to y, with offset, centre and state; weights w >= 0, or positive partial sums.
    shear
        k, with the sign of the weights. [input/output]
    card
        Names and units of u and y; by default those of the operator, which speaks of u + k y.

    Raises
    ------
    ParameterError
        If a parameter is no number.
    InvertibilityError
        If H has no inverse.

    Examples
    --------
    >>> loop = PrandtlIshlinskii([0.0, 0.1], [0.05, 0.04])
    >>> model = ShearedPrandtlIshlinskii(loop, shear=10.0)
    >>> compensator = model.inverse()
    >>> compensator.simulate([0.0, 0.01, 0.0]).round(9).tolist()
    [0.0, 0.055555556, -0.044444444]
    >>> (loop.inverse().simulate([0.0, 0.01, 0.0]) - 10.0 * np.array([0.0, 0.01, 0.0])).round(9).tolist()
    [0.0, 0.055555556, -0.044444444]
    """

    hysteresis: PrandtlIshlinskii
    shear: float
    card: ModelCard = NO_CARD
    family: ClassVar[str] = "sheared-pi"
    judged_backward = True

    def __post_init__(self) -> None:
        if not isinstance(self.hysteresis, PrandtlIshlinskii):
            raise ParameterError(
                f"hysteresis is a {type(self.hysteresis).__name__}; a sheared model is made of a PrandtlIshlinskii, "
                f"whose inverse less k y is a sum of plays again."
            )
        object.__setattr__(self, "shear", parameter_number(self.shear, "shear"))
        self._take_card()
        # An operator without an inverse is refused here, not at the first use.
        self.inverse()

    @property
    def inverse_gain(self) -> float:
        """Largest slope of the compensator, max_i |1/S_i - k|; after a reversal it is 1/w_1 - k. [input/output]"""
        return float(np.max(np.abs(self.inverse().partial_sums)))

    @property
    def has_forward(self) -> bool:
        """Whether the input alone decides the output: all slopes 1/S_i - k have the sign of the first weight."""
        slopes = self.inverse().partial_sums * np.sign(self.hysteresis.weights[0])
        return bool(np.all(slopes > 0.0))

    @property
    def no_forward(self) -> str:
        """Why the input alone does not decide the output."""
        if self.has_forward:
            return ""
        lowest = float(np.min(self.inverse().partial_sums * np.sign(self.hysteresis.weights[0])))
        return (
            f"this model only runs as a compensator: once its loop is open, {self.card.input.name} changes by "
            f"{lowest:.3g} for each unit of {self.card.output.name}, so that the input alone does not decide the "
            f"output (its backbone was taken off before the fit, or k = {self.shear:g} hides it). Use "
            f"model.inverse(), `dehyst compensate` or `dehyst export --what inverse`; or simulate the sheared "
            f"loop, model.hysteresis.simulate(u + k y)."
        )

    def as_play(self) -> PrandtlIshlinskii:
        """Return the model as a plain operator from u to y.

        Raises
        ------
        InvertibilityError
            If there is none.
        """
        if not self.has_forward:
            lowest = float(
                np.min(self.inverse().partial_sums * np.sign(self.hysteresis.weights[0]))
            )
            raise InvertibilityError(self.no_forward, slope=lowest, shear=self.shear)
        return self.inverse().inverse()

    def stepper(self, method: StepMethod = "auto") -> Stepper | StackStepper:
        return self.as_play().stepper(method)

    def inverse(self) -> PrandtlIshlinskii:
        """Return the compensator u = H^-1[y] - k y, a plain operator from y to u."""
        whole = self.hysteresis.inverse()
        weights = whole.weights.copy()
        weights[0] -= self.shear
        # H^-1 takes y - offset, so k y leaves k times the offset behind.
        offset = whole.offset - self.shear * whole.center
        # The provenance says that k y is subtracted already, so that nobody does it a second time.
        card = self.card.swapped()
        card = replace(card, provenance={**card.provenance, SUBTRACTED: self.shear})
        return replace(whole, weights=weights, offset=offset, card=card)

    def __repr__(self) -> str:
        """One line: family, k, operators, signals and their identified ranges; parameters are attributes."""
        operators = f"{self.nonzero_weights} of {self.hysteresis.thresholds.size} operators"
        signals = f"{self.card.input!s} -> {self.card.output!s}"
        return (
            f"<{type(self).__name__} {self.family!r}: k = {self.shear:.4g}, {operators}, {signals}>"
        )

    def _plays(self) -> tuple[Plays, None, None]:
        return self.as_play()._plays()

    def _inner(self) -> HysteresisModel:
        return self.as_play()

    def file_parameters(self) -> dict[str, Any]:
        return {"hysteresis": self.hysteresis.file_parameters(), "shear": self.shear}

    def replay(
        self,
        x: npt.ArrayLike,
        y: npt.ArrayLike,
        time: npt.ArrayLike | None = None,
        **signals: npt.ArrayLike,
    ) -> Array:
        """Return the output for an input that came from an output: H[x + k y] where x alone does not decide it.

        Examples
        --------
        >>> model = ShearedPrandtlIshlinskii(PrandtlIshlinskii([0.0, 0.1], [0.05, 0.04]), shear=10.0)
        >>> model.replay(model.inverse().simulate([0.0, 0.01]), [0.0, 0.01]).round(12).tolist()
        [0.0, 0.01]
        """
        if not self.no_forward:
            return self.simulate(x, time, **signals)
        return self.hysteresis.simulate(np.asarray(x) + self.shear * np.asarray(y), time, **signals)

    def times(self, factor: float) -> ShearedPrandtlIshlinskii:
        return replace(self, hysteresis=self.hysteresis.times(factor), shear=self.shear / factor)
