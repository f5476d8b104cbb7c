"""What gain alone does: errors of the packaged arm at the paper's pole and at the highest that has its margins."""

from __future__ import annotations

from collections.abc import Mapping

from dehyst.report.parts import Section, Table
from dehyst.robot.experiments.results import Reproduction

Rows = tuple[tuple[str, str, str, str, str], ...]
# Conditions -> joint, pole, and per trial off, paper, best: rows of docs/explanation/gain-or-compensator.md, which
# benchmarks/gains.py measures.
MEASURED: Mapping[str, Rows] = {
    "realistic": (
        ("1", "6", "651 → 106 → 74.7", "196 → 39.7 → 16.7", "1113 → 141 → 57"),
        ("1", "17.0", "31.5 → 15.1 → 15.9", "8.85 → 4.08 → 3.29", "144 → 20.4 → 7.98"),
    ),
}
OF_THE_PROCEDURE = ("calibration", "identification", "homing", "path")  # tables that leave the plant as it is
HEAD = ("joint", "pole [1/s]", "fast", "slow", "slow, no integrator")
WORDS = (
    "A loop with higher gains suppresses hysteresis by itself: an error without compensator says little without the "
    "gains beside it. All gains of a loop are powers of its pole; the highest pole has 6 dB and 5 ms to spare."
)
WINS = (
    "Gain wins on a joint alone with the integrator on: at its highest pole it errs less without compensator than at 6 "
    "1/s with the best one. Joints that move together cannot be tightened like this; there the compensator wins."
)
UNKNOWN = (
    "For this robot the highest pole was not searched; highest_pole in dehyst.robot.experiments.gains finds it, with "
    "and without compensator."
)


def baseline(result: Reproduction) -> Section | None:
    """Return what the loops would do at higher gains, where that was measured; None for a result without settings."""
    changes = result.settings.get("changes")
    if not isinstance(changes, Mapping):
        return None
    rows = MEASURED.get(str(result.settings.get("conditions")), ())
    if not rows or any(key.partition(".")[0] not in OF_THE_PROCEDURE for key in changes):
        return Section("gain", "Gain or compensator", (WORDS, UNKNOWN))
    note = (
        "Rms error in mdeg without compensator → with the paper's → with the best, medians over the muscles and seeds "
        "that were run; measured beforehand, by benchmarks/gains.py."
    )
    return Section("gain", "Gain or compensator", (WORDS, Table("", HEAD, rows, note), WINS))
