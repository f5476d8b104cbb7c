"""Finds an input whose sensor is at the end of its range: it stands at its extreme, the output goes on and back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dehyst.arrays import Array
from dehyst.findings import Finding

OUT = 0.01  # of its range: so far the output goes on while the input stands, in the mean of its rests ...
PACE = 0.15  # ... as fast, at the begin and the end of a rest, as this share of what it does before and behind it ...
MOST = 0.6  # ... and back again in this share of the rests
SWUNG = 0.5  # of the way out: what rings goes to and fro
JUMP = 0.1  # of the input's range: a step that leads into a rest, behind which an output may ring
IN_RESTS = 0.005  # of the samples are in such rests
FEWEST = 2  # rests at one extreme: in a single one anything may have moved the output
LEAST = 3  # samples of a rest


class Clipped(NamedTuple):
    """An extreme at which the input stands."""

    level: float  # [input]
    share: float  # of the samples
    out: float  # how far the output goes on, share of its range


def rests(values: Array, level: float) -> list[tuple[int, int]]:
    """Stretches of three samples or more at exactly this level: first and behind the last."""
    edges = np.flatnonzero(np.diff((values == level).astype(np.int64), prepend=0, append=0))
    firsts, lasts = edges[::2], edges[1::2]
    long = lasts - firsts >= LEAST
    return list(zip(firsts[long].tolist(), lasts[long].tolist(), strict=True))


def about_clipping(name: str, log: str, x: Array, y: Array, unit: str) -> list[Finding]:
    """Say where an input stands at its extreme while the output goes on."""
    found = clipped(x, y)
    if not found:
        return []
    levels = " and ".join(f"{one.level:.6g}{unit and ' '}{unit}" for one in found)
    share, out = sum(one.share for one in found), max(one.out for one in found)
    return [
        Finding(
            "saturated-input",
            f"input '{name}' of {log} stands exactly at {levels} in {100.0 * share:.2g} % of the samples, while the "
            f"output goes on by {100.0 * out:.2g} % of its range and comes back before the input moves: its sensor or "
            f"converter is at the end of its range, or something else moves the output there. The model takes the "
            f"input for what it reads, so it is wrong near {'these ends' if len(found) > 1 else 'this end'}, and its "
            f"errors do not show that. Log with a larger range of the sensor, or with a smaller motion.",
        )
    ]


def clipped(x: Array, y: Array) -> tuple[Clipped, ...]:
    """Extremes of an input at which it stands while the output goes on and comes back.

    In a hold the output creeps on in the direction in which it came; it comes back after the input has turned, not
    before. After a step it may ring, but it is at rest before the input moves again.

    Examples
    --------
    >>> x = np.sin(np.arange(2000) / 30)
    >>> low = np.minimum(x, 0.8)
    >>> [found.level for found in clipped(low, 2 * x)], clipped(low, 2 * low)
    ([0.8], ())
    """
    reach, span = float(np.ptp(x)), float(np.ptp(y))
    if not span > 0.0:
        return ()
    sign = np.sign(float(np.dot(x - x.mean(), y - y.mean()))) or 1.0
    found = []
    for level, outward in ((float(x.max()), sign), (float(x.min()), -sign)):
        near = [(a, b) for a, b in rests(x, level) if a > 0 and b < x.size]
        stretches = [(a, b) for a, b in near if abs(x[a] - x[a - 1]) < JUMP * reach]
        if len(stretches) < FEWEST:
            continue
        share = sum(b - a for a, b in stretches) / x.size
        moves = np.array([_moves(outward * y, a, b) for a, b in stretches])
        out, back, before, first, last, behind, swung = moves.mean(axis=0)
        returns = np.mean((moves[:, 0] > 0.5 * OUT * span) & (moves[:, 1] > 0.0))
        if share < IN_RESTS or out < OUT * span or back < 0.5 * OUT * span or returns < MOST:
            continue
        if swung < SWUNG * out and first > PACE * before and last > PACE * behind:
            found.append(Clipped(level, share, out / span))
    return tuple(found)


def _moves(y: Array, begin: int, end: int) -> tuple[float, ...]:
    """How far the output goes out and back in a rest, and in its ends and beside them; how far it goes otherwise.

    Out in the quarter before the rest and in its first one, back in its last quarter and in the one behind it.
    """
    last = end - 1
    part = max(1, (last - begin) // 4)
    ahead, after = max(begin - part, 0), min(last + part, y.size - 1)
    inside = y[begin:end]
    place = int(np.argmax(inside))
    top = float(inside[place])
    rise, fall = inside[: place + 1], inside[place:]
    swung = max(np.max(np.maximum.accumulate(rise) - rise), np.max(fall - np.minimum.accumulate(fall)))
    return (
        top - float(y[begin]),
        top - float(y[last]),
        float(y[begin] - y[ahead]),
        float(y[begin + part] - y[begin]),
        float(y[last - part] - y[last]),
        float(y[last] - y[after]),
        float(swung),
    )
