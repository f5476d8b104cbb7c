"""Arrows that show in which direction a loop is run through."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.loops import turning_points
from dehyst.report.figures.panel import Axes
from dehyst.report.theme import Token
from dehyst.report.thin import Window

# Where along a swing an arrow sits: not in the middle, so that those of both branches stay apart in a thin loop.
_PLACE = {1: 0.60, -1: 0.58}
# An arrow spans this share of its swing: long enough to average over noise, short enough to look straight.
_REACH = 0.05


def draw_arrows(axes: Axes, x: Array, y: Array, piece: slice, window: Window, token: Token) -> int:
    """Draw one arrow on the largest rising and one on the largest falling swing of a piece.

    Returns
    -------
    number
        Arrows drawn; none where the input did not swing.
    """
    u, v = x[piece], y[piece]
    points = turning_points(u)
    drawn = 0
    for direction in (1, -1):
        place = _place(u, points, direction)
        if place is None:
            continue
        i, k = place
        tip = (float(np.mean(u[k])), float(np.mean(v[k])))
        tail = (float(np.mean(u[i])), float(np.mean(v[i])))
        axes.annotate(
            "",
            xy=tip,
            xytext=tail,
            zorder=6,
            arrowprops={
                "arrowstyle": "-|>,head_width=0.28,head_length=0.6",
                "color": token.light,
                "lw": 0.0,
                "shrinkA": 0,
                "shrinkB": 0,
                "mutation_scale": 13,
            },
        )
        drawn += 1
    return drawn


def _place(
    u: Array, points: npt.NDArray[np.int64], direction: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]] | None:
    """Samples at tail and tip of the arrow on the largest swing in a direction."""
    swings = np.diff(u[points]) * direction
    if swings.size == 0 or swings.max() <= 0:
        return None
    best = int(np.argmax(swings))
    a, b = int(points[best]), int(points[best + 1])
    share = (u[a : b + 1] - u[a]) / (u[b] - u[a])
    middle = _PLACE[direction]
    tail = a + np.flatnonzero(np.abs(share - (middle - _REACH)) <= _REACH / 2)
    tip = a + np.flatnonzero(np.abs(share - (middle + _REACH)) <= _REACH / 2)
    if tail.size == 0 or tip.size == 0:  # a coarse log: take the nearest samples
        k = a + int(np.argmin(np.abs(share - middle)))
        k = min(max(k, a + 1), b)
        return np.array([k - 1]), np.array([k])
    return tail, tip
