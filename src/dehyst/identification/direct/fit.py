"""What the identification of a direct inverse returns: model, scores, comparison with forward families, findings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from dehyst.arrays import Array, Mask
from dehyst.findings import Finding
from dehyst.identification.evidence import CREEP, RATE, Evidence
from dehyst.identification.fit import Candidate, LoopFacts, Score
from dehyst.models import DirectInverse
from dehyst.recording import Recording


@dataclass(frozen=True, slots=True)
class DirectCertificate:
    """What proves, or limits, the trust in a direct inverse.

    Attributes
    ----------
    kkt_residual
        Largest violation of the optimality conditions of the convex program, relative.
    nonzero_weights, terms
        Terms with weight, and those offered to the optimisation, the polynomial left out.
    initial_state
        Past before the first sample that was assumed: "unknown", "rest", "rising" or "falling".
    rises
        Whether the input is guaranteed to rise with the output at every instant, whatever the past
        (`DirectInverse.least_slope`): what an adaptation and the reading in the forward direction build on.
    missed
        Samples at which no output within 10 % of the identified range needs the logged input.
    """

    kkt_residual: float
    nonzero_weights: int
    terms: int
    initial_state: str
    rises: bool
    missed: int


@dataclass(frozen=True, slots=True)
class Rival:
    """A forward family on the same samples.

    Attributes
    ----------
    family
        Its name.
    inverse_percent
        RMS of the input its inverse asks for at the measured output, less the applied one. Percent of the input's
        range.
    forward_percent
        RMS error of its output; percent of the output's range.
    """

    family: str
    inverse_percent: float
    forward_percent: float

    def as_dict(self) -> dict[str, object]:
        """Return the values as printed by ``--json``."""
        return {
            "family": self.family,
            "inverse_percent": self.inverse_percent,
            "forward_percent": self.forward_percent,
        }


@dataclass(frozen=True)
class DirectFit:
    """An identified direct inverse with everything needed to judge it.

    Errors of the input are what counts for a compensator: it is asked for the input at a wanted output.

    Attributes
    ----------
    model
        The direct inverse; it is the compensator itself.
    recordings
        The data, one per log.
    predictions
        Input that the model asks for at the measured output of each recording, (T,). [input]
    outputs
        Output that it gives for the applied input, solved sample by sample, (T,). [output]
    train_masks, test_masks
        Which samples were fitted, which held out, (T,).
    train, test
        Errors of the input: percent are of the input's range over the whole log. test is None if nothing was held out.
    forward_train, forward_test
        Errors of the output on the same samples, percent of the output's range.
    static_train, static_test
        Errors of the input of the best curve without memory.
    certificate
        Optimality, terms, start.
    rivals
        Forward families on the same samples, the one with the best inverse first.
    facts
        Orientation and loops of the data, and what they show of rate and creep.
    candidates
        Shapes that were compared on held-out blocks, best first.
    warnings
        Findings, each with a code and a cure.
    settings
        Settings of the call and what was chosen, as plain values.
    verdict
        The judgement in one sentence.

    Examples
    --------
    >>> import numpy as np, dehyst
    >>> t = np.linspace(0.0, 60.0, 1200)
    >>> y = 10 * np.sin(0.8 * t) * np.linspace(1.0, 0.4, 1200)
    >>> truth = dehyst.DirectInverse(radii=[2.0], stop_weights=[0.3], polynomial=[1.0, 0.2])
    >>> fit = dehyst.identify_direct(dehyst.Recording(input=truth.run(y, t).u, output=y, time=t))
    >>> bool(fit.test.rmse_percent < 0.5)
    True
    """

    model: DirectInverse
    recordings: tuple[Recording, ...]
    predictions: tuple[Array, ...]
    outputs: tuple[Array, ...]
    train_masks: tuple[Mask, ...]
    test_masks: tuple[Mask, ...]
    train: Score
    test: Score | None
    forward_train: Score
    forward_test: Score | None
    static_train: Score
    static_test: Score | None
    certificate: DirectCertificate
    rivals: tuple[Rival, ...]
    facts: LoopFacts
    candidates: tuple[Candidate, ...]
    warnings: tuple[Finding, ...]
    settings: Mapping[str, Any] = field(default_factory=dict)
    verdict: str = ""
    family: str = "direct-inverse"

    @property
    def backward(self) -> bool:
        """Whether `predictions` are of the input, and `outputs` those of the output."""
        return True

    @property
    def judged(self) -> Score:
        """Errors of the input that count: those on held-out samples if there are any."""
        return self.train if self.test is None else self.test

    @property
    def judged_forward(self) -> Score:
        """Errors of the output on the same samples."""
        return self.forward_train if self.forward_test is None else self.forward_test

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """What the log shows of rate and creep; empty without time stamps."""
        return self.facts.evidence

    @property
    def evidence_words(self) -> tuple[str, ...]:
        """What the log shows of rate and creep, a sentence each, and what the model has of them where that differs."""
        groups = self.settings.get("groups", ())
        return tuple(
            f"{found}{_kept(found, ('viscous' if found.group == RATE else CREEP) in groups)}" for found in self.evidence
        )

    @property
    def lacking(self) -> str:
        """What this log cannot tell of rate and creep, and the line that plans a motion that does; "" if nothing."""
        card = self.model.card.input
        return "" if card.low is None or card.high is None else self.facts.lacking(card.low, card.high)

    def __repr__(self) -> str:
        """One line: terms and the error that counts."""
        where = "fitted" if self.test is None else "held out"
        return (
            f"<DirectFit: {self.certificate.nonzero_weights} of {self.certificate.terms} terms, input within "
            f"{self.judged.rmse_percent:.2f} % of range rms {where}, {len(self.warnings)} warnings>"
        )

    def __str__(self) -> str:
        """Verdict, comparison, evidence and the codes of the warnings."""
        lines = [self.verdict or repr(self), f"model: {self.model!r}", *self.evidence_words]
        codes = dict.fromkeys(finding.code for finding in self.warnings)
        return "\n".join([*lines, f"warnings: {', '.join(codes) or 'none'}"])

    def as_dict(self) -> dict[str, Any]:
        """Return the verdict as plain values, the content of ``dehyst identify --json``."""
        return {
            "family": self.family,
            "terms": self.certificate.terms,
            "nonzero_weights": self.certificate.nonzero_weights,
            "train": self.train.as_dict(),
            "test": None if self.test is None else self.test.as_dict(),
            "forward_train": self.forward_train.as_dict(),
            "forward_test": None if self.forward_test is None else self.forward_test.as_dict(),
            "static_train": self.static_train.as_dict(),
            "static_test": None if self.static_test is None else self.static_test.as_dict(),
            "rivals": [rival.as_dict() for rival in self.rivals],
            "evidence": [found.as_dict() for found in self.evidence],
            "kkt_residual": self.certificate.kkt_residual,
            "initial_state": self.certificate.initial_state,
            "rises": self.certificate.rises,
            "missed": self.certificate.missed,
            "degree": self.settings.get("degree"),
            "groups": list(self.settings.get("groups", ())),
            "schedules": [schedule.name for schedule in self.model.schedules],
            "time_constants": self.model.time_constants.tolist(),
            "verdict": self.verdict,
            "warnings": [finding.as_dict() for finding in self.warnings],
        }


def _kept(found: Evidence, kept: bool) -> str:
    """What is to be said where a model has what was not found, or has not what was found."""
    if kept == found.there:
        return ""
    if kept:
        return "; the model has a term of it, which made the fit better"
    return "; not in the model, whose other terms do as well there" if found.told else ""
