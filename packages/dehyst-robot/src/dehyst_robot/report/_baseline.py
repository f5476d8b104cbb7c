"""What gain alone does: errors of the packaged arm at the paper's pole and at the highest that has its margins."""

from __future__ import annotations

from collections.abc import Mapping

from dehyst.report import PageSection, PageTable
from dehyst_robot.experiments import Reproduction

Rows = tuple[tuple[str, str, str, str, str], ...]
# Conditions -> joint, pole, and per trial off, paper, best: rows of docs/explanation/gain-or-compensator.md, which
# benchmarks/gains.py measures.
MEASURED: Mapping[str, Rows] = {
    "realistic": (
        ("1", "6", "709 → 93.6 → 80.7", "214 → 33.4 → 21.7", "1190 → 129 → 62.1"),
        ("1", "17.0", "34.8 → 17 → 18.2", "12.8 → 9.54 → 9.37", "147 → 18.1 → 15"),
        ("2", "6", "792 → 133 → 50.9", "238 → 70.4 → 25.3", "1452 → 242 → 113"),
        ("2", "15.4", "53.7 → 24.2 → 19.7", "20.8 → 17.3 → 16", "234 → 44.8 → 27.4"),
        ("4", "6", "2359 → 313 → 121", "822 → 207 → 49", "3266 → 806 → 188"),
        ("4", "16.8", "164 → 52.7 → 19.2", "44.6 → 29.6 → 9.66", "628 → 162 → 30.7"),
        ("1 of 1+2+4", "6", "682 → 91.8 → 80.2", "207 → 28.6 → 21.4", "1140 → 79.4 → 64"),
        ("1 of 1+2+4", "6.3", "589 → 86.7 → 76.3", "178 → 25.7 → 19.4", "1013 → 74.6 → 57.6"),
        ("2 of 1+2+4", "6", "724 → 116 → 53.1", "230 → 58.2 → 22.8", "1302 → 202 → 102"),
        ("2 of 1+2+4", "6.3", "654 → 106 → 50", "202 → 53.3 → 22.2", "1199 → 191 → 98.6"),
        ("4 of 1+2+4", "6", "2354 → 331 → 138", "831 → 218 → 56.1", "3117 → 407 → 150"),
        ("4 of 1+2+4", "6.3", "2105 → 296 → 133", "714 → 199 → 45.8", "2930 → 388 → 137"),
    ),
    "kind": (
        ("1", "6", "785 → 74 → 50.8", "243 → 33.9 → 11.2", "1263 → 92.1 → 51.7"),
        ("1", "32.2", "6.68 → 2.53 → 2.4", "1.77 → 0.675 → 0.516", "46.1 → 3.68 → 2.04"),
        ("2", "6", "929 → 99.7 → 37.5", "282 → 51.4 → 14", "1704 → 154 → 98.8"),
        ("2", "21.5", "25.1 → 6.65 → 4.6", "6.53 → 2.01 → 0.728", "143 → 13.3 → 8.97"),
        ("4", "6", "2682 → 384 → 78.4", "968 → 256 → 35.2", "3509 → 652 → 132"),
        ("4", "33.0", "28 → 15.7 → 2.87", "7.1 → 6.54 → 1.18", "200 → 110 → 5.69"),
    ),
}
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


def baseline(result: Reproduction) -> PageSection | None:
    """Return what the loops would do at higher gains, where that was measured; None for a result without settings."""
    changes = result.settings.get("changes")
    if not isinstance(changes, Mapping):
        return None
    rows = MEASURED.get(str(result.settings.get("conditions")), ())
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
