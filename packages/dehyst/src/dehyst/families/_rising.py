"""Tests whether a sum of elements rises with its input in every state: its least possible slope."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise, product
from typing import TYPE_CHECKING

import numpy as np

from dehyst.arrays import Array

if TYPE_CHECKING:
    from dehyst.families._elements import Element

LEAST_SLOPE = 1e-6  # scaled: below it rounding would be more than 1e-10 of an inverse
SLIVER = 1e-12  # knots as near are one that was rounded: between them no slope counts
MOST_GROWTH = 15.0 / 16.0  # of a radius with the input: what the machine allows
LAGS = ("relax", "past", "product")
FOLLOW = ("input", "play", "past")


def least_slope(elements: Sequence[Element], schedules: int = 0, period: float = 0.0) -> float:
    """Return a lower bound of the slope of sum h w f(e) with the input, over all inputs, memories and speeds.

    Of plays and stops those move together whose radius is below some value, up at x - r and down at x + r: the bound
    is the least over all such values, inputs and both directions. All other elements count with the least they can
    do. A schedule counts at its ends, between which the slope is linear.

    The sum rises with the present input where that bound is above 0. An inverse is stable, too, if the bound stays
    above 0 for slower motions, for which the faster lags have caught up: ``past`` then follows the input and ``relax``
    stands still. So the least over all such speeds is taken. At half the sampling rate a lag of gain q gives
    back q/(2 - q) of its slope with the other sign, and a radius that grows by g gives back 2 g - 1, for a period [s]
    that is not 0.

    A product stands still with the present input; as its lags catch up it goes with the other one, or with twice the
    input, each within its radius: of all products of a lag that has not caught up the most of the sum counts.

    Examples
    --------
    >>> from dehyst.families._elements import Element
    >>> least_slope([Element("input", weight=0.5), Element("play", 0.2, weight=0.4), Element("play", 0.4, weight=-0.2)])
    0.5
    """
    least = np.inf
    for ends in product((0.0, 1.0), repeat=schedules):
        shares = [1.0]
        for xi in ends:
            shares += [1.0 - xi, xi]
        least = min(least, _at_shares(elements, shares, period))
    return least


def most_slope(elements: Sequence[Element]) -> float:
    """Return an upper bound of the slope of the sum with the input, over all inputs, memories and speeds.

    Every element counts with the most that it can add; paths and plays that widen with twice the slope of their map.

    Examples
    --------
    >>> from dehyst.families._elements import Element
    >>> most_slope([Element("input", weight=0.5), Element("path", 0.2, weight=0.25)])
    1.0
    """
    factor = {"past": 0.0, "product": 0.0, "path": 2.0, "wide": 2.0}
    slopes = []
    for q in elements:
        slopes.append(factor.get(q.kind, 1.0) * max(0.0, float(pieces(q)[1].max())))
    return sum(slopes)


def _at_shares(elements: Sequence[Element], share: Sequence[float], period: float) -> float:
    """Return the bound where every schedule stands at one of its ends."""
    used: list[Element] = []
    lags: list[Element] = []
    moving: list[Element] = []
    for q in elements:
        if share[q.schedule] > 0.0:
            used.append(q)
            group = lags if q.kind in LAGS else moving
            group.append(q)
    pairs = []
    for q, following in pairwise(elements):
        if q.kind == "product" and share[q.schedule] > 0.0:
            pairs.append(_product(q, following))
    alone = sum([_alone(q, period) for q in used])
    plays = min(_moving(moving, 1.0), _moving(moving, -1.0))
    least = alone + plays - _products(pairs, -1.0, period)
    # The slower the input, the more lags catch up with it: one more at each step, the fastest first.
    for lag in sorted(lags, key=lambda q: q.time):
        alone -= _alone(lag, period)
        if lag.kind in FOLLOW:
            moving.append(lag)
            plays = min(_moving(moving, 1.0), _moving(moving, -1.0))
        least = min(least, alone + plays - _products(pairs, lag.time, period))
    return least


def _product(q: Element, following: Element) -> tuple[Array, tuple[float, float]]:
    """Return least and most slope of a product with either lag, and the time constants of the two."""
    slopes = pieces(q)[1]
    return q.radius * np.array([slopes.min(), slopes.max()]), (q.time, following.time)


def _products(
    pairs: Sequence[tuple[Array, tuple[float, float]]], caught: float, period: float
) -> float:
    """Return the most that products fall by with an input so slow that lags up to a time constant follow it."""
    # Least and most slope of a sum, by the time constant of the lag that holds; -1 where both follow.
    slopes: dict[float, Array] = {}
    early = 0.0
    for slope, times in pairs:
        hold = [time for time in times if time > caught]
        if not hold:
            slopes[-1.0] = slopes.get(-1.0, 0.0) + 2.0 * slope
        elif len(hold) == 1:
            slopes[hold[0]] = slopes.get(hold[0], 0.0) + slope
        early += sum([_early(time, period) for time in hold]) * float(np.abs(slope).max())
    largest = [float(np.abs(slope).max()) for slope in slopes.values()]
    return early + sum(largest)


def _early(time: float, period: float) -> float:
    """Return the share of its slope that a lag gives back at half the sampling rate, with the other sign."""
    if period <= 0.0:
        return 0.0
    gain = 1.0
    if time > 0.0:
        gain = float(-np.expm1(-period / time))
    return gain / (2.0 - gain)


@lru_cache(maxsize=1024)  # asked for every speed and direction
def pieces(element: Element) -> tuple[Array, Array]:
    """Inner breakpoints of w f (p,) and the slopes between and beyond them (p + 1,)."""
    u, v = (np.asarray(values) for values in element.map)
    if u.size < 2:
        return np.zeros(0), np.array([element.weight])
    return u[1:-1], element.weight * np.diff(v) / np.diff(u)


def _alone(element: Element, period: float) -> float:
    """The least that an element adds that neither follows the input itself nor moves with the plays."""
    inner, slopes = pieces(element)
    least, most = float(slopes.min()), float(slopes.max())
    early = _early(element.time, period)
    match element.kind:
        case "creep":
            return min(0.0, least)
        case "relax":
            return least + early * min(0.0, least)
        case "past":
            return -early * max(0.0, most)
        case "path":
            return 2.0 * min(0.0, _least_within(inner, slopes, element.radius))
        case "wide":
            growth, back = MOST_GROWTH, 0.0
            if period > 0.0:
                growth = min(element.time / period, MOST_GROWTH)
                back = max(0.0, 2.0 * growth - 1.0)
            return (1.0 + growth) * min(0.0, least) - back * max(0.0, most)
    return 0.0


def _least_within(inner: Array, slopes: Array, radius: float) -> float:
    first, last = np.searchsorted(inner, -radius, "right"), np.searchsorted(inner, radius, "left")
    return float(slopes[first : last + 1].min())


def _moving(elements: Sequence[Element], side: float) -> float:
    """What follows the input, and plays and stops, with an input that rises (side 1) or falls (-1)."""
    places = [np.zeros(1)]
    for q in elements:
        if q.kind in FOLLOW:
            places.append(pieces(q)[0] + side * _radius(q))
    knots = np.unique(np.concatenate(places))
    knots = knots[np.diff(knots, prepend=-np.inf) > SLIVER]
    # One place between any two knots is enough, since slopes are constant there.
    x = np.concatenate([knots[:1] - 1.0, 0.5 * (knots[1:] + knots[:-1]), knots[-1:] + 1.0])
    still = np.zeros(x.size)
    # By radius: the slope that is added when the plays and stops of that radius move, too.
    groups = {0.0: still.copy()}
    for q in elements:
        if q.kind in FOLLOW:
            inner, slopes = pieces(q)
            slope = slopes[np.searchsorted(inner, x - side * _radius(q))]
            groups[_radius(q)] = groups.get(_radius(q), 0.0) + slope
    for q in elements:
        if q.kind == "stop" and q.radius > 0.0:
            least = _least_within(*pieces(q), q.radius)
            still += least
            groups[q.radius] = groups.get(q.radius, 0.0) - np.full(x.size, least)
    by_radius = [groups[radius] for radius in sorted(groups)]
    return float((still + np.cumsum(by_radius, axis=0)).min())


def _radius(element: Element) -> float:
    return 0.0 if element.kind == "input" else element.radius
