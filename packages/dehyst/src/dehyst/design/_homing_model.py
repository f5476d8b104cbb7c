"""Shortest homing motion of an identified direct inverse: its stop operators and first-order lags."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dehyst.arrays import Array
from dehyst.design._excitation import Limits
from dehyst.design._homing import Homing, check_room, judged, shortest_homing
from dehyst.errors import ParameterError
from dehyst.models import DirectInverse

SHARES = (1.0, 0.9, 0.75, 0.6, 0.45, 0.3, 0.2, 0.12, 0.07)  # of the tolerance, for the stops
MOST_STROKES = 200  # over the range, for lags along the path
STOPS_OF_LAG = 12  # that imitate a lag while a motion is searched


def home_model(
    model: DirectInverse,
    limits: Limits,
    *,
    tolerance: float,
    low: float | None = None,
    high: float | None = None,
    start: float | None = None,
    end: float | None = None,
    spent: bool = True,
) -> Homing:
    r"""Return a short motion after which what a direct inverse remembers is known to a tolerance, whatever was before.

    As `shortest_homing`, with the weights of the model. A lag along the path forgets with the way W that is travelled,
    not with the span: its interval is :math:`2 x e^{-W/x}` wide, so that strokes are added until it is narrow enough.
    Where weights depend on a schedule, the largest that they can be are counted. Creep forgets with time only and is
    left out: hold still, or let the compensator ramp in.

    Parameters
    ----------
    model
        Its stops, lags along the path and their weights.
    limits
        Of rate and acceleration. [y/s, y/s^2]
    tolerance
        Largest ``half_width`` of u, and with ``spent`` largest ``residual``, > 0. [u]
    low, high
        Range that the motion may use; None: that of the model's card. [y]
    start, end, spent
        As for `shortest_homing`.

    Returns
    -------
    homing : Homing
        Its guarantees hold for stops and lags together. ``bound_s`` is that of the stops alone.

    Raises
    ------
    ParameterError
        If no range is known, the model remembers nothing, or the tolerance cannot be met within the range.

    Examples
    --------
    >>> model = DirectInverse(radii=[2.0, 8.0], stop_weights=[0.1, 0.05], polynomial=[0.0, 0.2])
    >>> homing = home_model(model, Limits(20.0), tolerance=0.02, low=-20.0, high=20.0, spent=False)
    >>> homing.points.round(1).tolist(), round(homing.half_width, 2)
    ([0.0, 15.2], 0.02)
    """
    if low is None:
        low = model.card.output.low
    if high is None:
        high = model.card.output.high
    if low is None or high is None:
        raise ParameterError("the model's card holds no range of its output; pass low and high.")
    r, s = model.radii, _largest(model.stop_weights)
    x, p = model.path_lengths, _largest(model.path_weights)
    if not (s.any() or p.any()):
        raise ParameterError(
            "no stop and no path lag of the model carries weight: it remembers nothing to be homed."
        )
    check_room(low, high, tolerance, start, end)
    search = _spent if spent else _known
    motions: list[Homing] = []
    fault: ParameterError | None = None
    # Stops and lags divide the tolerance; which division gives the shortest motion, only trying tells.
    for share in SHARES if p.any() else SHARES[:1]:
        try:
            motion = search(r, s, x, p, (low, high), (start, end), limits, tolerance, share)
        except ParameterError as refused:
            fault = refused
            continue
        for homing in motion:
            if max(homing.half_width, spent * homing.residual) <= tolerance * (1 + 1e-9):
                motions.append(homing)
    if not motions:
        raise fault or ParameterError(
            f"no motion of {MOST_STROKES} strokes within {low:g} to {high:g} leaves {tolerance:g} of what the lags "
            f"along the path hold; the largest length is {x.max():g}. Allow a wider range or a larger tolerance.",
            tolerance=tolerance,
        )
    return min(motions, key=lambda homing: homing.duration)


def _largest(weights: Array) -> Array:
    """Largest weight of each term over what the schedules may be: the larger set of each, summed."""
    if weights.shape[0] == 1:
        return np.asarray(weights[0])
    return np.asarray(np.maximum(weights[0::2], weights[1::2]).sum(axis=0))


def _known(
    r: Array, s: Array, x: Array, p: Array, room: tuple[float, float], ends: tuple[float | None, float | None],
    limits: Limits, tolerance: float, share: float,
) -> Iterator[Homing]:  # fmt: skip
    """Yield the shortest motion for the stops, with strokes over the range added until the lags have forgotten."""
    if s.any():
        stops_alone = shortest_homing(
            r, *room, limits, weights=s, tolerance=share * tolerance, start=ends[0], spent=False
        )
        points = stops_alone.points.tolist()
    else:
        points = [0.5 * sum(room) if ends[0] is None else ends[0]]
    for _ in range(MOST_STROKES):
        whole = judged(np.array(points), r, s, limits, 0.0, x, p)
        if whole.half_width <= tolerance:
            yield whole
            return
        # The next stroke goes to the end that is farther away.
        to_low, to_high = points[-1] - room[0], room[1] - points[-1]
        points.append(room[0] if to_low >= to_high else room[1])


def _spent(
    r: Array, s: Array, x: Array, p: Array, room: tuple[float, float], ends: tuple[float | None, float | None],
    limits: Limits, tolerance: float, share: float,
) -> Iterator[Homing]:  # fmt: skip
    """Yield a decaying motion planned with stops that imitate the lags, and the same after strokes over the range."""
    radii, weights = r, s
    if p.any():
        largest = 0.5 * (room[1] - room[0])
        grid = np.geomspace(0.02 * largest, largest, STOPS_OF_LAG)
        step = np.gradient(grid)
        like = (p[:, None] * np.exp(-grid / x[:, None]) / x[:, None]).sum(axis=0) * step
        radii, weights = np.concatenate([r, grid]), np.concatenate([s, like])
    plan = shortest_homing(
        radii,
        *room,
        limits,
        weights=weights,
        tolerance=share * tolerance,
        start=ends[0],
        end=ends[1],
    )
    points = plan.points
    if not p.any():
        yield judged(points, r, s, limits, plan.bound_s)
        return
    ends_in_turn = (room[1], room[0], room[1])
    for strokes in range(4):
        # Lags forget with the way; strokes over the whole range in front add to it.
        tried = np.array([points[0], *ends_in_turn[:strokes], *points[1:]])
        moves = np.concatenate(([True], np.diff(tried) != 0))
        yield judged(tried[moves], r, s, limits, 0.0, x, p)
