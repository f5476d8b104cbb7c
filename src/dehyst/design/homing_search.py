"""Search of the shortest decaying motion: which tips, by dynamic programming over what may remain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.design.strokes import Limits
from dehyst.errors import ParameterError

NODES = 64  # of the grid of amplitudes besides the radii themselves
LEVELS = 400  # steps of the tolerance in which what remains is counted
ROUNDING = 1e-6  # of a level


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
        low, high = (np.clip(z, value - r, value + r) for z in (low, high))
    return x[-1] - high, x[-1] - low


def spending(
    r: Array, s: Array, ends: tuple[float, float], begin: float, end: float, tolerance: float, limits: Limits
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
    nodes = np.unique(np.concatenate([grid, r[r <= room]]))[::-1]  # falling, the last one 0: the end
    time = limits.stroke_time(nodes[:, None] + nodes[None, :])
    level = tolerance / LEVELS
    left = _left_between(r, s, nodes) / level
    above = np.array([float(s @ np.maximum(0.0, r - a)) for a in nodes]) / level
    least, following = _budgeted(time, _levels(np.ceil(left - ROUNDING)))
    whole = limits.stroke_time(nodes) + limits.stroke_time(2 * nodes)  # to the first tip, and over to the second
    budget = LEVELS - _levels(np.ceil(above - ROUNDING))
    total = np.where(budget >= 0, whole + least[np.arange(nodes.size), np.maximum(budget, 0)], np.inf)
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
    least, following = np.full((count, LEVELS + 1), np.inf), np.zeros((count, LEVELS + 1), dtype=np.int64)
    least[-1] = 0.0
    budget = np.arange(LEVELS + 1)
    for j in range(count - 2, -1, -1):
        after = np.arange(j + 1, count)
        rest = budget - cost[j, after][:, None]
        options = np.where(rest >= 0, least[after[:, None], np.maximum(rest, 0)], np.inf) + time[j, after][:, None]
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


def _bound(r: Array, s: Array, nodes: Array, time: Array, left: Array, level: float, limits: Limits) -> float:
    """Return a time that no motion of the kind that keeps the tolerance undercuts: everything is rounded down.

    After the first tip a_0 and the second one a_1 a stop of radius r >= a_1 keeps |E| up to r - min(a_0, a_1) if
    2 r > a_0 + a_1, else r - a_1. Between two amplitudes of the grid the first tip takes the time of the smaller and
    leaves the rest of the larger one.
    """
    least, _ = _budgeted(time, _levels(np.floor(left + ROUNDING)))
    smaller, larger = np.concatenate([nodes[1:], nodes[-1:]])[:, None], nodes[:, None]  # intervals of a_0, and zero
    second = nodes[None, :]
    kept = np.where(2.0 * r > (larger + second)[..., None], np.minimum(larger, second)[..., None], second[..., None])
    remains = (np.where(r >= second[..., None], r - kept, 0.0) @ s) / level
    budget = LEVELS - _levels(np.floor(remains + ROUNDING))
    rest = np.where(budget >= 0, least[np.arange(nodes.size)[None, :], np.maximum(budget, 0)], np.inf)
    return float((limits.stroke_time(smaller) + limits.stroke_time(smaller + second) + rest).min())


def _with_first_tip(
    chain: Sequence[float], r: Array, s: Array, begin: float, end: float, tolerance: float,
    room: tuple[float, float], limits: Limits,
) -> Array:  # fmt: skip
    """Return start, tips and end: both directions tried, the first tip as near as the tolerance allows."""
    found: list[Array] = []
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
            lower, upper = (share, upper) if remains(motion(share)) > allowed else (lower, share)
        points = motion(upper)
        if room[0] <= points.min() and points.max() <= room[1]:
            found.append(points[np.concatenate(([True], np.diff(points) != 0))])
    return min(found, key=lambda points: float(limits.stroke_time(np.abs(np.diff(points))).sum()))
