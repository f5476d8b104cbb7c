"""How fast a signal moves: ranges a second, of its fast strokes, whatever rests and noise it has."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dehyst.arrays import Array
from dehyst.data._policy import POLICY


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
    values = np.concatenate([x for _, x in long])
    reach = float(np.max(values)) - float(np.min(values))
    chord = min(POLICY.chord * span, POLICY.small_chord * reach)
    # The lag is doubled until the fastest samples pass the chord, far above the noise.
    lag = 1
    ways, times = _over(long, lag)
    while not _passes(ways, chord):
        lag *= 2
        if all(x.size <= 2 * lag for _, x in long):
            break
        ways, times = _over(long, lag)
    usual = (
        (times > 0.0)
        & (times <= POLICY.speed_gap * float(np.median(times)))
        & (ways >= 0.5 * chord)
    )
    if not np.any(usual):
        return 0.0
    ways, speeds = ways[usual], ways[usual] / times[usual]
    order = np.argsort(speeds)
    passed = np.cumsum(ways[order])
    at = int(np.searchsorted(passed, POLICY.slower * float(passed[-1])))
    return float(speeds[order][min(at, speeds.size - 1)]) / span


def _passes(ways: Array, chord: float) -> bool:
    """Whether the fastest of the samples pass the chord."""
    short = int(np.count_nonzero(ways < chord))
    # Where the quantile stands among sorted ways; only between two that differ it has to be found.
    place = (ways.size - 1) * (1.0 - POLICY.moving)
    if short <= int(place):
        return True
    if short > int(place) + 1:
        return False
    return not float(np.quantile(ways, 1.0 - POLICY.moving)) < chord


def _over(parts: list[tuple[Array, Array]], lag: int) -> tuple[Array, Array]:
    """Ways and times between samples that lie a number of samples apart, of all pieces that are longer."""
    ways, times = [], []
    for time, x in parts:
        if x.size > lag:
            ways.append(np.abs(x[lag:] - x[:-lag]))
            times.append(time[lag:] - time[:-lag])
    return np.concatenate(ways), np.concatenate(times)
