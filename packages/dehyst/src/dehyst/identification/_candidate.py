"""The protocol of candidates: what can be fitted to a log, and what it hands to the judge."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from dehyst.arrays import Array
from dehyst.families.kit import LinearForm
from dehyst.findings import Finding
from dehyst.identification._cautions import Knows
from dehyst.identification._fit import Certificate, ComparedSetting, Refitting
from dehyst.identification._scores import Measured
from dehyst.models import StaticCurve

if TYPE_CHECKING:
    from dehyst.identification._prepared import Prepared


class Candidate(Protocol):
    """A family with its settings, which can be fitted to a log: plays, a curve, a row, a family of the literature."""

    @property
    def family(self) -> str:
        """Name of the family."""

    def fit(self, log: Prepared) -> Outcome:
        """Return the model of the fitted part of a log, and what the judge has to know of it."""

    def block_errors(self, log: Prepared) -> BlockErrors:
        """Return the errors on fifths of the way of the fitted part, each left out of a fit in turn."""


@dataclass(frozen=True, eq=False)
class BlockErrors:
    """Errors of a candidate on five fifths of the way of a log that its fit did not see.

    Attributes
    ----------
    output
        RMS error of the output, (5,); not a number for a model of the input. [output]
    input
        RMS of the input that the inverse asks for less the applied one, (5,); not a number without an inverse. [input]
    nonzero_weights, inverse_gain
        Of the fit to all but the last fifth.
    smoothing
        Of the output map, the best of those that "auto" tries; None for families without one.
    """

    output: Array
    input: Array
    nonzero_weights: int
    inverse_gain: float
    smoothing: float | None = None


def no_remarks(measured: Measured) -> Iterable[Finding]:
    """Return nothing: most families have no findings of their own."""
    return ()


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a candidate made of a log, before it is judged.

    Attributes
    ----------
    family, model
        What was fitted; the card of the model may name the ranges of its signals.
    settings
        As plain values, for the fit and the card.
    certificate
        What proves the fit; round trip and miss of the inverse are the judge's to fill in.
    measure
        Compares model and curve with all samples; it is called with the number of turning points of the fitted part.
    static
        The best curve without hysteresis.
    knows
        What a model of this family can show, which findings depend on.
    compared
        Settings that the family compared by itself, the best first.
    refitter
        What `Fit.refit` calls; None where sums were not kept.
    details
        What only this family says of itself.
    remarks
        Findings that only this family has, asked for once the model was measured.
    form
        Makes the linear form of the judged model, for intervals; None where there is none.
    """

    family: str
    model: Any
    settings: Mapping[str, Any]
    certificate: Certificate
    measure: Callable[[int], Measured]
    static: StaticCurve
    knows: Knows
    compared: tuple[ComparedSetting, ...] = ()
    refitter: Refitting | None = None
    details: Mapping[str, Any] = field(default_factory=dict)
    remarks: Callable[[Measured], Iterable[Finding]] = no_remarks
    form: Callable[[Any], LinearForm] | None = None
