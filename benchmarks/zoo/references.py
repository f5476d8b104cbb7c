"""References that a rig shall follow: a scan, rests, and strokes at twice the speed of its logs."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from zoo.compiled import Array
from zoo.logs import smooth, true_log
from zoo.rigs import Rig

REFERENCES = SCAN, RESTS, FAST = ("scan", "rests", "fast")
INSIDE = (0.1, 0.9)  # of the range of the log's output
TRIANGLES = (
    0.1,
    0.9,
    0.1,
    0.9,
    0.1,
    0.45,
    0.2,
    0.6,
    0.35,
    0.85,
    0.55,
    0.8,
    0.1,
)  # shares of the same
SCAN_SPEED = 0.5  # speed of a scan, over the mean one of a stroke over the range
DWELLS = (0.25, 1.0, 0.5, 4.0, 0.25, 2.0, 0.5, 1.0, 0.25, 4.0, 1.0)  # strokes
LONG_REST = 8.0  # of the longest dwell at least [s]
FASTER = 2.0
FAST_STROKES = 24


def reference(rig: Rig, kind: str) -> tuple[Array, int]:
    """Return a reference (T,), which begins with a stroke from where the rig rests, and how long that takes."""
    _, y = true_log(rig, "usual")
    low, span = float(y.min()), float(np.ptp(y))
    samples = rig.stroke / rig.period  # of a stroke over the range
    random = rig.random(kind)
    if kind == SCAN:
        shares = _scan(samples)
    elif kind == RESTS:
        shares = _rests(random, samples, LONG_REST / rig.period)
    else:
        shares = _fast(random, samples)
    motion = low + span * shares
    # The rig answers to its input of rest before anything moves.
    first = float(rig.play(np.full(2, rig.rest))[0])
    begun = np.concatenate([np.full(2, first), smooth(first, float(motion[0]), round(samples))])
    return np.concatenate([begun, motion]), begun.size


def _scan(samples: float) -> Array:
    parts = [np.array([TRIANGLES[0]])]
    for begin, end in pairwise(TRIANGLES):
        count = max(4, round(abs(end - begin) * samples / SCAN_SPEED))
        parts.append(begin + (end - begin) * np.arange(1, count + 1) / count)
    return np.concatenate(parts)


def _rests(random: np.random.Generator, samples: float, longest: float) -> Array:
    at = 0.5
    parts = [np.array([at])]
    for dwell in DWELLS:
        # Moves are long enough to tell the levels apart.
        level = at
        while abs(level - at) < 0.15:
            level = float(random.uniform(*INSIDE))
        parts.append(smooth(at, level, max(8, round(samples * (0.3 + 0.7 * abs(level - at))))))
        rest = dwell * samples
        if dwell == max(DWELLS):
            rest = max(rest, longest)
        parts.append(np.full(round(rest), level))
        at = level
    return np.concatenate(parts)


def _fast(random: np.random.Generator, samples: float) -> Array:
    at = 0.5
    parts = [np.array([at])]
    for stroke in range(FAST_STROKES):
        # To and fro, each within its half of the range.
        half = (INSIDE[0], 0.5) if stroke % 2 else (0.5, INSIDE[1])
        tip = float(random.uniform(*half))
        count = max(6, round(abs(tip - at) * samples / FASTER))
        parts.append(smooth(at, tip, count))
        at = tip
    return np.concatenate(parts)
