"""Forward families on the same samples: what the direct inverse is measured against."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from dehyst.arrays import Array
from dehyst.errors import DehystError
from dehyst.findings import Finding
from dehyst.identification.direct.cautions import findings_of_data
from dehyst.identification.direct.fit import Rival
from dehyst.identification.families import FAMILIES
from dehyst.identification.fit import Fit, LoopFacts
from dehyst.identification.measures import InMemory
from dehyst.identification.procedure import call_of, solve_in_memory
from dehyst.identification.settings import PAPER_OPERATORS, eps_of_call
from dehyst.identification.split import Split
from dehyst.recording import Recording
from dehyst.ties import rank


class Compared(NamedTuple):
    """Rivals, the one with the best inverse first; what the data shows; findings about the data."""

    rivals: tuple[Rival, ...]
    facts: LoopFacts
    findings: tuple[Finding, ...]


def compare_forward(records: tuple[Recording, ...], split: Split, loads: Sequence[Sequence[Array]]) -> Compared:
    """Identify every forward family and score it.

    A family that cannot be identified is left out; if none can, the fault of the last one is raised.
    """
    fits: list[Fit] = []
    fault: DehystError | None = None
    measure = InMemory(records, loads)  # which tests rate and creep once for all of them
    for family in FAMILIES:
        call = call_of(family, PAPER_OPERATORS, eps_of_call(family, None), None, "auto", split)
        try:
            fits.append(solve_in_memory(call, records, None, measure))
        except DehystError as found:
            fault = found
    if not fits:
        raise fault if fault is not None else AssertionError("no family was tried")
    fits.sort(key=lambda fit: rank(fit.certificate.inverse_miss_percent))
    rivals = tuple(
        Rival(fit.family, fit.certificate.inverse_miss_percent, (fit.test or fit.train).rmse_percent) for fit in fits
    )
    return Compared(rivals, fits[0].facts, tuple(findings_of_data(fits[0].warnings)))
