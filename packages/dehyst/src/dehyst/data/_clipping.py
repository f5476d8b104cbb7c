"""Finds an input whose sensor is at the end of its range: it stands at its extreme, the output goes on and back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dehyst.arrays import Array
from dehyst.data._policy import POLICY
from dehyst.findings import Finding


class Clipped(NamedTuple):
    """An extreme at which the input stands."""

    level: float  # [input]
    share: float  # of the samples
    out: float  # how far the output goes on, share of its range


def rests(values: Array, level: float) -> list[tuple[int, int]]:
    """Stretches of three samples or more at exactly this level: first and behind the last."""
    edges = np.flatnonzero(np.diff((values == level).astype(np.int64), prepend=0, append=0))
    firsts, lasts = edges[::2], edges[1::2]
    long = lasts - firsts >= POLICY.least_rest
    return list(zip(firsts[long].tolist(), lasts[long].tolist(), strict=True))


def about_clipping(name: str, log: str, x: Array, y: Array, unit: str) -> list[Finding]:
    """Say where an input stands at its extreme while the output goes on."""
    clippings = clipped(x, y)
    if not clippings:
        return []
    levels = " and ".join(f"{clipping.level:.6g}{unit and ' '}{unit}" for clipping in clippings)
    share = sum(clipping.share for clipping in clippings)
    out = max(clipping.out for clipping in clippings)
    ends = "these ends" if len(clippings) > 1 else "this end"
    return [
        Finding(
            "saturated-input",
            f"input '{name}' of {log} stands exactly at {levels} in {100.0 * share:.2g} % of the samples, while the "
            f"output goes on by {100.0 * out:.2g} % of its range and comes back before the input moves: its sensor or "
            f"converter is at the end of its range, or something else moves the output there. The model takes the "
            f"input for what it reads, so it is wrong near {ends}, and its "
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
    clippings = []
    for level, outward in ((float(x.max()), sign), (float(x.min()), -sign)):
        samples, moves_of_rests = 0, []
        for begin, end in rests(x, level):
            # A rest at an end of the log, or behind a step, tells nothing.
            if (
                begin > 0
                and end < x.size
                and abs(x[begin] - x[begin - 1]) < POLICY.step_into_rest * reach
            ):
                samples += end - begin
                moves_of_rests.append(_moves(outward * y, begin, end))
        if len(moves_of_rests) < POLICY.fewest_rests:
            continue
        share = samples / x.size
        moves = np.array(moves_of_rests)
        out, back, before, first, last, behind, swung = moves.mean(axis=0)
        returns = np.mean((moves[:, 0] > 0.5 * POLICY.rest_out * span) & (moves[:, 1] > 0.0))
        if (
            share < POLICY.in_rests
            or out < POLICY.rest_out * span
            or back < 0.5 * POLICY.rest_out * span
            or returns < POLICY.rest_returns
        ):
            continue
        if (
            swung < POLICY.rest_ringing * out
            and first > POLICY.rest_pace * before
            and last > POLICY.rest_pace * behind
        ):
            clippings.append(Clipped(level, share, out / span))
    return tuple(clippings)


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
    swung = max(
        np.max(np.maximum.accumulate(rise) - rise), np.max(fall - np.minimum.accumulate(fall))
    )
    return (
        top - float(y[begin]),
        top - float(y[last]),
        float(y[begin] - y[ahead]),
        float(y[begin + part] - y[begin]),
        float(y[last - part] - y[last]),
        float(y[last] - y[after]),
        float(swung),
    )
