"""Flags of the joint controllers during the trials: limits of pressures and valves, faults of sensors."""

from __future__ import annotations

import numpy as np

from dehyst.experiments.results import PlantResult, TrialRun
from dehyst.report.reproduction.numbers import OFF, trial_name
from dehyst.report.text import number

# Bits of the flags, as in core/dehyst.h.
PRESSURE, VALVE = 16, 32
FAULTS = 1 | 2 | 4 | 8 | 64 | 128
KINDS = (
    (PRESSURE, "the desired pressure was limited"),
    (VALVE, "a valve was limited"),
    (FAULTS, "a fault was flagged"),
)


def limit_words(plant: PlantResult) -> str:
    """Say where limits were reached, or that they were not."""
    if not plant.runs:
        return ""
    found = [words for run in plant.runs for words in _of_run(run)]
    if not found:
        return "No pressure or valve was limited and no sensor fault flagged at any logged moment of the trials."
    return f"Limits and faults at the logged moments: {'; '.join(found)}."


def _of_run(run: TrialRun) -> list[str]:
    side = "without" if run.compensator == OFF else "with compensator"
    said = []
    for bits, words in KINDS:
        hit = (run.flags & bits) != 0
        if hit.any():
            joints = ", ".join(str(j + 1) for j in np.flatnonzero(hit.any(axis=0)).tolist())
            share = number(100 * float(hit.any(axis=1).mean()), 2)
            said.append(f"{trial_name(run.trial)} {side}: {words} in {share} % of the time (joint {joints})")
    return said
