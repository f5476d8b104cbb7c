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
        ("1", "6", "709 → 106 → 78.4", "214 → 51.6 → 20.1", "1190 → 146 → 52.7"),
        ("1", "17.0", "34.8 → 16.8 → 18.2", "12.8 → 9.97 → 9.35", "147 → 23.7 → 14.2"),
        ("2", "6", "792 → 146 → 53.9", "238 → 76.1 → 22.5", "1452 → 294 → 69.1"),
        ("2", "15.4", "53.7 → 25.3 → 20", "20.8 → 17.2 → 15.9", "234 → 51 → 23.2"),
        ("4", "6", "2359 → 377 → 119", "822 → 290 → 47.6", "3266 → 929 → 205"),
        ("4", "16.8", "164 → 70.3 → 18.9", "44.6 → 35 → 9.06", "628 → 300 → 32.4"),
        ("1 of 1+2+4", "6", "682 → 102 → 77.5", "207 → 39.5 → 19.9", "1140 → 114 → 48.4"),
        ("1 of 1+2+4", "6.3", "589 → 95.3 → 72.1", "178 → 36.9 → 18.2", "1013 → 107 → 43.4"),
        ("2 of 1+2+4", "6", "724 → 131 → 56.9", "230 → 68.3 → 20.9", "1302 → 240 → 70.4"),
        ("2 of 1+2+4", "6.3", "654 → 121 → 53.6", "202 → 60.3 → 20.4", "1199 → 231 → 63.8"),
        ("4 of 1+2+4", "6", "2354 → 405 → 152", "831 → 287 → 49.2", "3117 → 704 → 181"),
        ("4 of 1+2+4", "6.3", "2105 → 362 → 131", "714 → 260 → 42.5", "2930 → 687 → 178"),
    ),
    "kind": (
        ("1", "6", "785 → 85.2 → 47.9", "243 → 40.2 → 9.24", "1263 → 99.6 → 30.3"),
        ("1", "32.2", "6.68 → 2.61 → 2.45", "1.77 → 0.741 → 0.497", "46.1 → 4.18 → 1.39"),
        ("2", "6", "929 → 108 → 37.8", "282 → 58.5 → 11.6", "1704 → 154 → 38.6"),
        ("2", "21.5", "25.1 → 7.09 → 4.9", "6.53 → 2.42 → 0.863", "143 → 14.1 → 8.05"),
        ("4", "6", "2682 → 415 → 101", "968 → 331 → 47", "3509 → 1013 → 152"),
        ("4", "33.0", "28 → 16.2 → 3.33", "7.1 → 7.07 → 1.21", "200 → 147 → 7.19"),
        ("1 of 1+2+4", "6", "693 → 81.2 → 51.9", "208 → 31.8 → 9.87", "1141 → 89.4 → 32.8"),
        ("1 of 1+2+4", "8.0", "321 → 44.9 → 34.7", "91.2 → 14.4 → 4.85", "661 → 51.6 → 18.6"),
        ("2 of 1+2+4", "6", "779 → 98.1 → 43.4", "244 → 52.4 → 12.8", "1373 → 110 → 40.5"),
        ("2 of 1+2+4", "8.0", "376 → 54 → 27.2", "107 → 26.4 → 6.22", "842 → 57.7 → 23.8"),
        ("4 of 1+2+4", "6", "2427 → 330 → 112", "867 → 288 → 59.9", "3205 → 315 → 177"),
        ("4 of 1+2+4", "8.0", "1308 → 206 → 70.7", "402 → 177 → 31.1", "2289 → 807 → 122"),
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
