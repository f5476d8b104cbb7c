"""Tracking of the default choice with and without dead time, resonance and power of the input.

python benchmarks/surroundings.py

Eleven rigs of the zoo and their routine logs; about a minute. The table of docs/decisions/0076-powers-of-the-input.md.
"""

from __future__ import annotations

import numpy as np
from zoo.logs import ROUTINE, recording
from zoo.rigs import RIGS
from zoo.scores import tracked

import dehyst
import dehyst.families._lateness as lateness

WITH_A_PART = ("muscles", "elastomer", "piezo", "tendon", "bowden", "cylinder")
WITHOUT = ("gear", "walls", "flag", "stack", "finger")


def tracking(name: str, surroundings: bool) -> dict[str, float]:
    """Return the error along each reference, percent of range."""
    rig, log = RIGS[name], recording(RIGS[name], ROUTINE)
    taken = lateness.transformed
    if surroundings:
        fit = dehyst.identify(log)
    else:
        lateness.transformed = lambda training, chosen, *_: (training, chosen)
        fit = dehyst.identify(log, ahead=0.0, resonance=None)
        lateness.transformed = taken
    errors = tracked(rig, fit, float(np.ptp(log.output)))
    return {kind: scores["tracking"] for kind, scores in errors.items()}


def main() -> None:
    """Print a row for each rig, and the geometric means."""
    print("| rig | scan | rests | twice the speed | ratio |\n|---|---|---|---|---|")
    for group in (WITH_A_PART, WITHOUT):
        ratios = []
        for name in group:
            without, with_parts = tracking(name, False), tracking(name, True)
            logs = [np.log(with_parts[kind] / without[kind]) for kind in without]
            ratios.append(float(np.mean(logs)))
            cells = [f"{without[kind]:.2f} -> {with_parts[kind]:.2f}" for kind in without]
            print(f"| {name} | {' | '.join(cells)} | {np.exp(ratios[-1]):.2f} |", flush=True)
        print(f"geometric mean {np.exp(np.mean(ratios)):.2f}")


if __name__ == "__main__":
    main()
