"""Shortest homing motion: afterwards the state of a bank of stop operators is known, or bounded.

A stop of radius r holds E = x - z, |E| <= r, where z moves with z <- max(x - r, min(x + r, z)). Nobody knows z before
the first motion: every z in [x - r, x + r] is admissible.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.design._excitation import Limits
from dehyst.errors import ParameterError

NODES = 64  # of the grid of amplitudes besides the radii themselves
LEVELS = 400  # steps of the tolerance in which what remains is counted
ROUNDING = 1e-6  # of a level
NONE = np.zeros(0)  # no lags along the path


def admissible(points: npt.ArrayLike, radii: npt.ArrayLike) -> tuple[Array, Array]:
    """Return lowest and highest E of each stop after a motion through points, over all states before it.

    A play's update is monotone in its state, so the extreme states before stay the extreme ones; and it only depends
    on where a motion turns. While the span S = max x - min x is less than 2 r, exactly the z in
    [max x - r, min x + r] are possible: the interval of E is 2 r - S wide. From S = 2 r on it is a point.

    Parameters
    ----------
    points
        Turning points of the motion, (K + 1,), the first one its start. [unit]
    radii
        (n,) [unit]

    Returns
    -------
    low, high
        (n,) each. [unit]

    Examples
    --------
    >>> low, high = admissible([0.0, 1.5], [0.5, 1.0])
    >>> low.tolist(), high.tolist()
    ([0.5, 0.5], [0.5, 1.0])
    """
    x, r = np.asarray(points, dtype=np.float64), np.asarray(radii, dtype=np.float64)
    low, high = x[0] - r, x[0] + r
    for value in x[1:]:
        low = np.clip(low, value - r, value + r)
        high = np.clip(high, value - r, value + r)
    return x[-1] - high, x[-1] - low


def spending(
    r: Array,
    s: Array,
    ends: tuple[float, float],
    begin: float,
    end: float,
    tolerance: float,
    limits: Limits,
) -> tuple[Array, float]:
    """Return start, tips and end of the shortest decaying motion that spends a bank's memory, and its bound in time.

    Parameters
    ----------
    r, s
        Radii, increasing, and weights of the stops, (n,). [unit, output/unit]
    ends
        Of the range. [unit]
    begin, end
        Of the motion. [unit]
    tolerance
        Largest sum_i s_i |E_i| afterwards. [output]
    limits
        Of rate and acceleration.
    """
    low, high = ends
    room = min(high - end, end - low)
    grid = np.linspace(0.0, min(room, float(r[-1])), NODES + 1)
    # Amplitudes fall; the last one is 0, the end.
    nodes = np.unique(np.concatenate([grid, r[r <= room]]))[::-1]
    time = limits.stroke_time(nodes[:, None] + nodes[None, :])
    level = tolerance / LEVELS
    left = _left_between(r, s, nodes) / level
    above = np.array([float(s @ np.maximum(0.0, r - a)) for a in nodes]) / level
    least, following = _budgeted(time, _levels(np.ceil(left - ROUNDING)))
    # The time to the first tip, and over to the second one.
    whole = limits.stroke_time(nodes) + limits.stroke_time(2 * nodes)
    budget = LEVELS - _levels(np.ceil(above - ROUNDING))
    total = np.where(
        budget >= 0, whole + least[np.arange(nodes.size), np.maximum(budget, 0)], np.inf
    )
    at = int(np.argmin(total))
    if not np.isfinite(total[at]):
        most = float(s @ np.min(np.abs(r[:, None] - nodes[None, :]), axis=1))
        raise ParameterError(
            f"within {low:g} to {high:g} a homing that ends at {end:g} leaves {most:.3g} of the stops' output "
            f"(largest radius {r[-1]:g}, room {room:g}), more than the tolerance {tolerance:g}. Allow a wider range, "
            f"a tolerance of that size, or leave out larger radii.",
            residual=most,
        )
    chain, remaining = [float(nodes[at])], int(budget[at])
    costs = _levels(np.ceil(left - ROUNDING))
    while at < nodes.size - 1:
        step = int(following[at, remaining])
        remaining -= int(costs[at, step])
        at = step
        chain.append(float(nodes[at]))
    points = _with_first_tip(chain, r, s, begin, end, tolerance, (low, high), limits)
    return points, _bound(r, s, nodes, time, left, level, limits)


def _levels(values: Array) -> npt.NDArray[np.int64]:
    """Whole levels of the tolerance; whatever is beyond it is one more than there are."""
    return np.minimum(values, LEVELS + 1).astype(np.int64)


def _budgeted(time: Array, cost: npt.NDArray[np.int64]) -> tuple[Array, npt.NDArray[np.int64]]:
    """Return least time from each amplitude to the end for each budget, (N, levels + 1), and the next amplitude."""
    count = time.shape[0]
    least = np.full((count, LEVELS + 1), np.inf)
    following = np.zeros((count, LEVELS + 1), dtype=np.int64)
    least[-1] = 0.0
    budget = np.arange(LEVELS + 1)
    for j in range(count - 2, -1, -1):
        after = np.arange(j + 1, count)
        remaining = budget - cost[j, after][:, None]
        later = least[after[:, None], np.maximum(remaining, 0)]
        options = np.where(remaining >= 0, later, np.inf) + time[j, after][:, None]
        following[j] = j + 1 + np.argmin(options, axis=0)
        least[j] = options.min(axis=0)
    return least, following


def _left_between(r: Array, s: Array, nodes: Array) -> Array:
    """Return (N, N) what remains of stops with radii between two successive amplitudes: distance to the nearer one."""
    left = np.full((nodes.size, nodes.size), np.inf)
    for j, a in enumerate(nodes):
        near = np.minimum(np.abs(r[:, None] - a), np.abs(r[:, None] - nodes[None, j + 1 :]))
        inside = (r[:, None] <= a) & (r[:, None] >= nodes[None, j + 1 :])
        left[j, j + 1 :] = s @ np.where(inside, near, 0.0)
    return left


def _bound(
    r: Array, s: Array, nodes: Array, time: Array, left: Array, level: float, limits: Limits
) -> float:
    """Return a time that no motion of the kind that keeps the tolerance undercuts: everything is rounded down.

    After the first tip a_0 and the second one a_1 a stop of radius r >= a_1 keeps |E| up to r - min(a_0, a_1) if
    2 r > a_0 + a_1, else r - a_1. Between two amplitudes of the grid the first tip takes the time of the smaller and
    leaves the rest of the larger one.
    """
    least, _ = _budgeted(time, _levels(np.floor(left + ROUNDING)))
    # Ends of the intervals of a_0 between the amplitudes of the grid, down to zero.
    smaller, larger = np.concatenate([nodes[1:], nodes[-1:]])[:, None], nodes[:, None]
    second = nodes[None, :]
    nearest = np.where(
        2.0 * r > (larger + second)[..., None],
        np.minimum(larger, second)[..., None],
        second[..., None],
    )
    remains = (np.where(r >= second[..., None], r - nearest, 0.0) @ s) / level
    budget = LEVELS - _levels(np.floor(remains + ROUNDING))
    later = least[np.arange(nodes.size)[None, :], np.maximum(budget, 0)]
    later = np.where(budget >= 0, later, np.inf)
    return float((limits.stroke_time(smaller) + limits.stroke_time(smaller + second) + later).min())


def _with_first_tip(
    chain: Sequence[float], r: Array, s: Array, begin: float, end: float, tolerance: float,
    room: tuple[float, float], limits: Limits,
) -> Array:  # fmt: skip
    """Return start, tips and end: both directions tried, the first tip as near as the tolerance allows."""
    motions: list[Array] = []
    for sign in (1.0, -1.0):
        tips = end + np.array([sign * (-1.0) ** k * a for k, a in enumerate(chain[:-1], 1)])

        def motion(first: float, sign: float = sign, tips: Array = tips) -> Array:
            lead = begin + first * (end + sign * chain[0] - begin)
            return np.concatenate(([begin, lead] if first > 0 else [begin], tips, [end]))

        def remains(points: Array) -> float:
            lowest, highest = admissible(points, r)
            return float(s @ np.maximum(np.abs(lowest), np.abs(highest)))

        lower, upper = 0.0, 1.0
        allowed = max(tolerance, remains(motion(1.0)))
        if remains(motion(0.0)) <= allowed:
            upper = 0.0
        for _ in range(60 if upper else 0):
            share = 0.5 * (lower + upper)
            if remains(motion(share)) > allowed:
                lower = share
            else:
                upper = share
        points = motion(upper)
        if room[0] <= points.min() and points.max() <= room[1]:
            motions.append(points[np.concatenate(([True], np.diff(points) != 0))])
    return min(motions, key=lambda points: float(limits.stroke_time(np.abs(np.diff(points))).sum()))


@dataclass(frozen=True, eq=False)
class Homing:
    """A motion that homes a bank of stops, and what it guarantees.

    Attributes
    ----------
    points
        (K + 1,) start, tips, end. [unit]
    stroke_s
        (K,) shortest smooth strokes within the limits. [s]
    half_width
        Guaranteed: half the interval of sum_i s_i E_i afterwards, over all admissible states before. [output]
    residual
        Guaranteed: largest sum_i s_i |E_i| afterwards, over all admissible states before. [output]
    bound_s
        No motion of its kind over the searched amplitudes that keeps the tolerance takes less time. [s]

    Examples
    --------
    >>> homing = shortest_homing([0.1, 0.3, 0.5], -1.0, 1.0, Limits(1.0), tolerance=0.05)
    >>> homing.residual <= 0.05, homing.bound_s <= homing.duration, round(homing.travel, 1)
    (True, True, 2.5)
    """

    points: Array
    stroke_s: Array
    half_width: float
    residual: float
    bound_s: float

    @property
    def travel(self) -> float:
        """Way of all strokes. [unit]"""
        return float(np.abs(np.diff(self.points)).sum())

    @property
    def duration(self) -> float:
        """Time of all strokes. [s]"""
        return float(self.stroke_s.sum())


def shortest_homing(
    radii: npt.ArrayLike,
    low: float,
    high: float,
    limits: Limits,
    *,
    weights: npt.ArrayLike | None = None,
    tolerance: float = 0.05,
    start: float | None = None,
    end: float | None = None,
    spent: bool = True,
) -> Homing:
    r"""Return the shortest motion after which a bank of stops is known to a tolerance, from any state before.

    Known (``spent=False``). After any motion of span S the interval of the output of the bank is

    .. math:: \sum_i s_i \max(0, 2 r_i - S)

    wide, whatever its path: only the span counts. So the shortest motion is the shortest of the span S* that makes
    this twice the tolerance: one stroke of length S* <= 2 r_max if there is room for it on one side, else a short one
    to the other side before. Neither can be beaten: a motion that goes a up and b down, a + b = S*, travels
    a + b + min(a, b) at least. One full stroke over 2 r_max makes every stop of radius <= r_max known.

    Known and spent (``spent=True``), for a compensator that begins at zero: the motion decays, tips at
    e +- a_1, a_2, ... around the end e, a_1 > a_2 > ... > 0, so that the last stroke that moved a stop left it at
    E = +-(a_k - r) with the tip a_k nearest to its radius (or 0, the end). What remains is

    .. math:: \sum_i s_i |E_i| = \sum_i s_i \min_k |r_i - a_k|

    a median problem on a line, with the strokes' time as the price of a tip. It is solved by dynamic programming over
    amplitudes (the radii and a grid) and what is left of the tolerance, in 400 levels: rounded up for the motion,
    rounded down for ``bound_s``. The first tip only serves to make the memory known, so it is then made as short as
    the tolerance allows.

    Parameters
    ----------
    radii
        Of the stops r_i > 0, (n,). [unit]
    low, high
        Range that the motion may use. [unit]
    limits
        Of rate and acceleration. [unit/s, unit/s^2]
    weights
        s_i >= 0, (n,). [output/unit] None: equal shares of one, s_i = 1/(n r_i).
    tolerance
        Largest ``half_width``, and with ``spent`` largest ``residual``, > 0. [output] With weights of None: the share
        of all that the bank can hold.
    start, end
        Where the motion begins, and with ``spent`` ends; None: the middle. [unit]
    spent
        Whether what remains must be small too.

    Returns
    -------
    homing : Homing

    Raises
    ------
    ParameterError
        If a value makes no sense, or the range is too small for the tolerance: the message says what it allows.

    Examples
    --------
    >>> once = shortest_homing([0.1, 0.5], -1.0, 1.0, Limits(1.0), tolerance=1e-9, spent=False)
    >>> once.points.round(6).tolist(), once.half_width < 1e-9
    ([0.0, 1.0], True)
    >>> spent = shortest_homing([0.1, 0.5], -1.0, 1.0, Limits(1.0), tolerance=0.01)
    >>> spent.points.round(2).tolist(), round(spent.residual, 3)
    ([0.0, 0.49, -0.49, 0.1, 0.0], 0.01)
    """
    r, s = _bank(radii, weights)
    begin, target = check_room(low, high, tolerance, start, end)
    if not spent:
        points = _known(r, s, low, high, begin, tolerance)
        return judged(points, r, s, limits, math.inf)
    points, bound = spending(r, s, (low, high), begin, target, tolerance, limits)
    return judged(points, r, s, limits, bound)


def check_room(
    low: float, high: float, tolerance: float, start: float | None, end: float | None
) -> tuple[float, float]:
    """Return where a motion begins and ends, None the middle; refuse a range, a tolerance or a place that is none."""
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ParameterError(
            f"a range from {low:g} to {high:g} leaves no room to move; pass low < high."
        )
    if not tolerance > 0:
        raise ParameterError(
            f"tolerance = {tolerance:g}; no motion leaves less than nothing. Pass a positive number."
        )
    middle = 0.5 * (low + high)
    begin = _within(start, low, high, "start", middle)
    return begin, _within(end, low, high, "end", middle)


def _bank(radii: npt.ArrayLike, weights: npt.ArrayLike | None) -> tuple[Array, Array]:
    r = np.asarray(radii, dtype=np.float64).ravel()
    if not r.size or not (np.isfinite(r) & (r > 0)).all():
        raise ParameterError(
            "radii of stops must be positive numbers, one at least; pass those of the model."
        )
    s = 1.0 / (r.size * r)
    if weights is not None:
        s = np.asarray(weights, dtype=np.float64).ravel()
    if s.shape != r.shape or not (np.isfinite(s) & (s >= 0)).all():
        raise ParameterError(
            f"{s.size} weights for {r.size} radii, the smallest {s.min(initial=0.0):g}: pass one weight of zero or "
            f"more for each radius."
        )
    order = np.argsort(r)
    return r[order], s[order]


def _within(value: float | None, low: float, high: float, name: str, middle: float) -> float:
    x = middle if value is None else float(value)
    if not low <= x <= high:
        raise ParameterError(
            f"{name} = {x:g} lies outside the range {low:g} to {high:g}; pass a place inside it."
        )
    return x


def _width(r: Array, s: Array, span: float) -> float:
    return float(s @ np.maximum(0.0, 2.0 * r - span))


def _least_span(r: Array, s: Array, tolerance: float, largest: float) -> float:
    """Smallest span after which half the interval of the output is the tolerance; refuse if it is beyond `largest`."""
    if 0.5 * _width(r, s, largest) > tolerance * (1 + 1e-12):
        raise ParameterError(
            f"the range is {largest:g} wide, less than a full stroke 2 r = {2 * r[-1]:g} over the largest stop: the "
            f"output stays unknown to +-{0.5 * _width(r, s, largest):.3g}, more than the tolerance {tolerance:g}. "
            f"Allow a wider range, a tolerance of that size, or leave out larger radii.",
            span=largest,
            half_width=0.5 * _width(r, s, largest),
        )
    lower, upper = 0.0, min(largest, 2.0 * float(r[-1]))
    if 0.5 * _width(r, s, 0.0) <= tolerance:
        return 0.0
    for _ in range(80):
        span = 0.5 * (lower + upper)
        # A wider span leaves less unknown.
        if 0.5 * _width(r, s, span) > tolerance:
            lower = span
        else:
            upper = span
    return upper


def _known(r: Array, s: Array, low: float, high: float, begin: float, tolerance: float) -> Array:
    span = _least_span(r, s, tolerance, high - low)
    sign = 1.0 if high - begin >= begin - low else -1.0
    room = max(high - begin, begin - low)
    back = max(0.0, span - room)  # what the wider side lacks is taken on the other one, first
    points = [begin, begin - sign * back, begin + sign * (span - back)]
    return np.array(points if back > 0 else points[::2])


def judged(
    points: Array,
    r: Array,
    s: Array,
    limits: Limits,
    bound: float,
    x: Array = NONE,
    p: Array = NONE,
) -> Homing:
    """Return a motion with its guarantees: extreme states of stops and of lags along the path, of lengths x, after it.

    `p` are the weights of the lags, and `bound` is a time that no other motion undercuts. [s]
    """
    low, high = admissible(points, r)
    lag_low, lag_high = -x, x
    for a, b in pairwise(points):
        fade = np.exp(-abs(b - a) / x)
        end = np.sign(b - a) * x * (1 - fade)
        lag_low, lag_high = end + fade * lag_low, end + fade * lag_high
    stroke = limits.stroke_time(np.abs(np.diff(points)))
    half = 0.5 * float(s @ (high - low) + p @ (lag_high - lag_low))
    residual = float(
        s @ np.maximum(np.abs(low), np.abs(high))
        + p @ np.maximum(np.abs(lag_low), np.abs(lag_high))
    )
    return Homing(points, stroke, half, residual, min(bound, float(stroke.sum())))
