"""How fast a signal moves: ranges a second, of its fast strokes, whatever rests and noise it has."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dehyst.arrays import Array

# A way so long is motion, as a share of the range: noise of sensors is several times smaller.
CHORD = 0.05
# Where the signal does not go so far, a share of its own range.
SMALL_CHORD = 0.25
# Samples that pass a chord, at least; and the share of the way that is slower than the speed: a single jump is none.
MOVING = 0.005
SLOWER = 0.9
# Pairs of samples further apart in time than so many times the usual lie beside a gap.
GAP = 3.0


def top_speed(parts: Sequence[tuple[Array, Array]], span: float) -> float:
    """Return the speed of the fast strokes of a signal, in ranges a second.

    Differences are taken over as many samples as the signal needs to pass a twentieth of its range, so that noise does
    not count, and weighed by the way, so that neither rests nor slow strokes hide the fast ones.

    Parameters
    ----------
    parts
        Pieces of the signal: time and values, (T,) each. [s], [unit]
    span
        Range that counts as one. [unit]

    Returns
    -------
    speed : float
        0 for a signal that stays where it is. [1/s]

    Examples
    --------
    >>> time = np.arange(0.0, 40.0, 0.01)
    >>> round(top_speed([(time, np.sin(time))], 2.0), 2)  # a sine, half a range in a second at most
    0.5
    """
    long = [(time, x) for time, x in parts if x.size > 1]
    if not long or not span > 0.0:
        return 0.0
    reach = max(float(np.max(x)) for _, x in long) - min(float(np.min(x)) for _, x in long)
    chord = min(CHORD * span, SMALL_CHORD * reach)
    lag = 1
    ways, times = _over(long, lag)
    while float(np.quantile(ways, 1.0 - MOVING)) < chord:
        lag *= 2
        if all(x.size <= 2 * lag for _, x in long):
            break
        ways, times = _over(long, lag)
    usual = (times > 0.0) & (times <= GAP * float(np.median(times))) & (ways >= 0.5 * chord)
    if not np.any(usual):
        return 0.0
    ways, speeds = ways[usual], ways[usual] / times[usual]
    order = np.argsort(speeds)
    passed = np.cumsum(ways[order])
    at = int(np.searchsorted(passed, SLOWER * float(passed[-1])))
    return float(speeds[order][min(at, speeds.size - 1)]) / span


def _over(parts: list[tuple[Array, Array]], lag: int) -> tuple[Array, Array]:
    """Ways and times between samples that lie a number of samples apart, of all pieces that are longer."""
    pieces = [(time, x) for time, x in parts if x.size > lag]
    ways = np.concatenate([np.abs(x[lag:] - x[:-lag]) for _, x in pieces])
    times = np.concatenate([time[lag:] - time[:-lag] for time, _ in pieces])
    return ways, times
