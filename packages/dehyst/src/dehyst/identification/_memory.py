"""Initial states of the plays, at the first sample and after gaps: assumed, and from when on they are known."""

from __future__ import annotations

from typing import Literal, NamedTuple, get_args

import numpy as np

from dehyst.arrays import Array

InitialState = Literal["zero", "origin", "rest", "rising", "falling", "unknown"]
INITIAL_STATES: tuple[str, ...] = get_args(InitialState)
# What they take the actuator to have done before the first sample.
PASTS = {
    "zero": "strokes that died out",
    "origin": "one stroke from input 0",
    "rest": "nothing, it was never moved",
    "rising": "full strokes, the last one rising",
    "falling": "full strokes, the last one falling",
    "unknown": "anything",
}


def past_in_words(start: str) -> str:
    """Return what a start state assumes, for a person.

    Examples
    --------
    >>> past_in_words("zero")
    'strokes that died out (zero)'
    """
    return f"{PASTS[start]} ({start})"


# Both extremes count as visited when the signal came within this share of its range: closer than that, the
# plays that could still remember carry next to nothing.
VISITED = 0.02
# Share of the range that a piece has to go over to tell loops ...
LOOPS = 0.1
# ... and for its own extremes to stand for those of the range.
NEARLY = 0.9


def state_before(
    kind: str, thresholds: Array, first: float, low: float, high: float, origin: float = 0.0
) -> Array:
    """States z0 (n,) of plays whose history before the first sample is assumed.

    Parameters
    ----------
    kind
        "zero": after a decaying oscillation around the centre, z0 = 0 (the 2012 paper). "origin": came from rest at
        input 0, before centring. "rest": never moved, z0 = x_0. "rising": went from the upper to the lower extreme
        and came up to x_0, as in a log that starts within a rising branch of a periodic motion. "falling": the mirror
        image. "unknown": like "rising"; samples whose memory matters are masked by `known_from`.
    thresholds
        r, (n,). [input]
    first
        x_0, first sample of the centred input. [input]
    low, high
        Extremes of the centred input. [input]
    origin
        Where input 0 lies in the centred input. [input]

    Examples
    --------
    >>> state_before("rising", np.array([0.0, 1.0]), first=0.5, low=-1.0, high=1.0).tolist()
    [0.5, 0.0]
    """
    if kind == "zero":
        return np.zeros(thresholds.size)
    if kind == "origin":
        return np.full(thresholds.size, origin)
    if kind == "rest":
        return np.full(thresholds.size, first)
    z = np.zeros(thresholds.size)
    for turn in (low, high, first) if kind == "falling" else (high, low, first):
        z = np.maximum(turn - thresholds, np.minimum(turn + thresholds, z))
    return z


def known_from(x: Array, low: float, high: float) -> int:
    """Index from which on no play with 2 r < high - low remembers anything before the first sample.

    That is where both extremes were visited; the length of x if they never were.

    Examples
    --------
    >>> known_from(np.array([0.0, 1.0, 0.0, -1.0, 0.0]), -1.0, 1.0)
    3
    """
    slack = VISITED * (high - low)
    return max(_first(x, low + slack, below=True), _first(x, high - slack, below=False))


class Known(NamedTuple):
    """What is known of the memory within a piece whose beginning says nothing."""

    begin: int  # Index from which on it is known, the size of the piece where it never is
    # None where all of it is known from there on. Otherwise least and largest input of the piece: plays wider than that
    # stand still, nobody knows where, and the output has an unknown level.
    within: tuple[float, float] | None


def known_within(x: Array) -> Known:
    """What is known of the memory within a piece, x scaled to [-1, 1] over the training samples.

    All is known once both extremes were visited. A piece that does so late or never counts once it has visited its own
    extremes, with a level of its own, if these are a tenth of the range apart and that wins more samples than it costs
    levels.

    Examples
    --------
    >>> x = np.tile([0.0, 0.94, 0.0, -0.94], 10)
    >>> known_within(x).begin, known_within(0.5 * x), known_within(0.05 * x).begin
    (3, Known(begin=3, within=(-0.47, 0.47)), 40)
    """
    low, high = float(x.min()), float(x.max())
    by_range = known_from(x, -1.0, 1.0)
    if 2 * by_range <= x.size or high - low < 2.0 * LOOPS:
        return Known(by_range, None)
    by_itself = known_from(x, low, high)
    # A level of its own costs as much as it wins where the range is seen soon after.
    if by_range - by_itself > x.size - by_range:
        return Known(by_itself, (low, high))
    return Known(by_range, None)


def known_after_break(x: Array) -> int:
    """Index from which a piece counts where it can have no level of its own, as for creep and lengths of way.

    It goes over 90 % of the range then: only plays with r > 0.9 are unknown, and their part of the output is within
    sum w_i (r_i - 0.9) of the truth.

    Examples
    --------
    >>> x = np.tile([0.0, 0.94, 0.0, -0.93], 10)
    >>> known_after_break(x), known_after_break(0.5 * x)
    (3, 40)
    """
    whole, low, high = known_from(x, -1.0, 1.0), float(x.min()), float(x.max())
    if 2 * whole <= x.size or high - low < 2.0 * NEARLY:
        return whole
    return min(whole, known_from(x, low, high))


def _first(x: Array, bound: float, below: bool) -> int:
    """First index at which x reaches a bound, its length if it never does; looks no further than needed."""
    begin, size = 0, 1024
    while begin < x.size:
        part = x[begin : begin + size]
        reached = part >= bound
        if below:
            reached = part <= bound
        places = np.flatnonzero(reached)
        if places.size:
            return begin + int(places[0])
        begin, size = begin + size, 2 * size
    return int(x.size)


def largest_radius(kind: str, first: float, low: float, high: float) -> float:
    """max |x - m|, m the value the memory starts from: beyond it no play ever moves. [input]"""
    origin = first if kind == "rest" else 0.0
    return max(abs(high - origin), abs(low - origin))
