r"""Output bounds of a model whose initial state is unknown.

With M and m the largest and smallest input so far, a play of radius r has forgotten its start as soon as
:math:`M - m \ge 2 r`. The others lie anywhere in :math:`[M - r, m + r]`, neighbours at most :math:`r_{i+1} - r_i`
apart: with :math:`a = (M - m)/2` the increments of their deviation from the middle :math:`(M + m)/2` are free within
:math:`r_i - r_{i-1}`, the first within :math:`r_i - a`. A sum over increments takes each at its end, so that the output
lies within the output of the middle and

.. math:: W(a) = \int_a^\infty \Big| \sum_{r_i \ge r} w_i \Big| \, dr

of it, for weights of any sign; both ends are attained. W falls with a, a never falls: the interval never grows, and is
a point from the first stroke of length :math:`2 r_n` on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models._arrays import parameter_number

# Rounding of a sum of plays, as a share of the sum of their largest values: what keeps a guarantee a guarantee.
ROUNDING = 1e-13


@dataclass(frozen=True, eq=False)
class Plays:
    """A sum of plays without its constant: thresholds r (n,), weights w (n,), centre of the input, start state (n,)."""

    thresholds: Array
    weights: Array
    center: float
    state: Array


@dataclass(frozen=True, eq=False)
class Start:
    """The extreme states that the past allows, (n,), and the extremes of the input known by then, centred."""

    lowest: Array
    highest: Array
    top: float
    bottom: float


Past = tuple[float, float] | None


def start_states(
    plays: Plays, first: float, known_radius: float | None, past: Past = None
) -> Start:
    """Return what is possible before the first sample.

    Parameters
    ----------
    plays
        The operator.
    first
        First input that counts.
    known_radius
        Plays of radius up to it are in the state of the model; None: nothing is known.
    past
        Range that the input has not left since the memory was that of the model's start state; None: any.
    """
    r = plays.thresholds
    if known_radius is not None and parameter_number(known_radius, "known") < 0.0:
        raise ParameterError(
            f"known = {known_radius:g} is negative; it is the radius up to which the plays are in the model's state, "
            f"such as the half stroke of a homing. None stands for a memory of which nothing is known.",
            known=known_radius,
        )
    # Whatever the past was, each play lies within its radius of the first input.
    v = first - plays.center
    lowest, highest = v - r, v + r
    if past is not None:
        # The first input is part of the past of what follows.
        bottom, top = min(past[0], first), max(past[1], first)
        # Pushed by the input only: down to bottom + r, up to top - r, if it began above or below.
        lowest = np.maximum(lowest, np.minimum(plays.state, bottom - plays.center + r))
        highest = np.minimum(highest, np.maximum(plays.state, top - plays.center - r))
    sure = 0
    if known_radius is not None:
        sure = int(np.searchsorted(r, known_radius, side="right"))
    if sure == 0:
        return Start(lowest, highest, v, v)
    z, last = float(plays.state[sure - 1]), float(r[sure - 1])
    reach = np.maximum(r - last, 0.0)
    sure_ones = np.arange(r.size) < sure
    # A larger play differs from the last known one by the difference of their radii at most.
    low, high = z - reach, z + reach
    if past is not None:
        low, high = np.maximum(low, lowest), np.minimum(high, highest)
    return Start(
        np.where(sure_ones, plays.state, low),
        np.where(sure_ones, plays.state, high),
        z + last,
        z - last,
    )


def check_past(past: Past) -> Past:
    """Return a past range, or refuse it."""
    if past is None:
        return None
    try:
        bottom, top = past
    except (TypeError, ValueError):
        raise ParameterError(
            f"past = {past!r:.60} is no pair of numbers; pass past=(low, high)."
        ) from None
    bottom, top = parameter_number(bottom, "past[0]"), parameter_number(top, "past[1]")
    if not bottom < top:
        raise ParameterError(
            f"past = ({bottom:g}, {top:g}) is no range; pass the smallest input that was possible first, then the "
            f"largest.",
            low=bottom,
            high=top,
        )
    return bottom, top


def half_width(plays: Plays, half_stroke: npt.ArrayLike) -> Array:
    r"""Return :math:`W(a) = \int_a^\infty |\sum_{r_i \ge r} w_i| dr` at a, (T,). [output]

    Examples
    --------
    >>> plays = Plays(np.array([0.0, 1.0, 2.0]), np.array([1.0, -3.0, 2.0]), 0.0, np.zeros(3))
    >>> half_width(plays, [0.0, 0.5, 1.0, 1.5, 2.0, 9.0]).tolist()
    [3.0, 2.5, 2.0, 1.0, 0.0, 0.0]
    """
    # W is piecewise linear between the radii, and 0 beyond the largest one.
    knots = np.concatenate([[0.0], plays.thresholds])
    # Sums of the weights of all plays that are as large or larger.
    tails = np.cumsum(plays.weights[::-1])[::-1]
    pieces = np.abs(tails) * np.diff(knots)
    left = np.concatenate([np.cumsum(pieces[::-1])[::-1], [0.0]])
    width: Array = np.interp(np.asarray(half_stroke, dtype=np.float64), knots, left)
    return width


def half_strokes(centred: Array, start: Start) -> Array:
    """Half of what the input has swept so far, (T,), never falling."""
    top = np.maximum(np.maximum.accumulate(centred), start.top)
    bottom = np.minimum(np.minimum.accumulate(centred), start.bottom)
    return 0.5 * (top - bottom)


def held(x: Array, limit: float) -> tuple[Array, int]:
    """Input with rejected samples replaced by the last good one, and the index of the first good one (T if none)."""
    good = np.abs(x) <= limit
    if good.all():
        return x, 0
    if not good.any():
        return x, x.size
    first = int(np.argmax(good))
    # The index of the last good sample, for each sample.
    places = np.maximum.accumulate(np.where(good, np.arange(x.size), first))
    return x[places], first
