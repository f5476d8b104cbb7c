"""What gain alone does: errors of the packaged arm at the default pole and at the highest that has its margins."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path

from dehyst.report import PageSection, PageTable
from dehyst_robot.experiments import Reproduction

# Per trial off, paper, best: rows of docs/explanation/gain-or-compensator.md, written by docs/build.py.
TABLE = Path(__file__).with_name("gains.csv")
OF_THE_PROCEDURE = (
    "calibration",
    "identification",
    "homing",
    "path",
)  # tables that leave the plant as it is
HEAD = ("joint", "pole [1/s]", "fast", "slow", "slow, no integrator")
WORDS = (
    "A loop with higher gains suppresses hysteresis by itself: an error without compensator says little without the "
    "gains beside it. All gains of a loop are powers of its pole; the highest pole has 6 dB and 5 ms to spare."
)
WINS = (
    "Gain wins on a joint alone in the slow trial: at its highest pole it errs less without compensator than at 6 1/s "
    "with the best one. Joints that move together cannot be tightened like this; there the compensator wins."
)
UNKNOWN = (
    "For this robot the highest pole was not searched; highest_pole in dehyst_robot.experiments._gains finds it, with "
    "and without compensator."
)


def measured(conditions: str) -> tuple[tuple[str, ...], ...]:
    """Return joint, pole, and off, paper and best in each trial under some conditions; nothing for other ones."""
    rows = []
    with TABLE.open(encoding="utf-8", newline="") as file:
        for of_conditions, *cells in csv.reader(file):
            if of_conditions == conditions:
                rows.append(tuple(cells))
    return tuple(rows)


def baseline(result: Reproduction) -> PageSection | None:
    """Return what the loops would do at higher gains, where that was measured; None for a result without settings."""
    changes = result.settings.get("changes")
    if not isinstance(changes, Mapping):
        return None
    rows = measured(str(result.settings.get("conditions")))
    # Another plant than was measured has other numbers, and none are better than wrong ones.
    if not rows or any(key.partition(".")[0] not in OF_THE_PROCEDURE for key in changes):
        return PageSection("gain", "Gain or compensator", (WORDS, UNKNOWN))
    note = (
        "Rms error in mdeg without compensator → with the paper's → with the best, medians over the muscles and seeds "
        "that were run; measured beforehand, by benchmarks/gains.py."
    )
    return PageSection(
        "gain", "Gain or compensator", (WORDS, PageTable("", HEAD, rows, note), WINS)
    )
