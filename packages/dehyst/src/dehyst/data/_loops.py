"""Turning points and loops of a signal, robust to noise; gaps in time, and whether memory is lost across them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.data._policy import POLICY


def turning_points(signal: npt.ArrayLike, swing: float | None = None) -> npt.NDArray[np.int64]:
    """Indices where a signal turns by more than `swing`.

    Parameters
    ----------
    signal
        Values x, (T,), finite.
    swing
        Smallest swing that counts, > 0. [unit of x] By default 5 % of the range of x.

    Returns
    -------
    indices : (m,)
        First sample, every extreme between two swings larger than `swing`, last sample.

    Examples
    --------
    >>> turning_points([0.0, 1.0, 0.99, 1.0, -1.0, 0.0], swing=0.5).tolist()
    [0, 1, 4, 5]
    """
    x = np.asarray(signal, dtype=np.float64)
    if x.size == 0:
        return np.zeros(0, dtype=np.int64)
    if swing is None:
        swing = POLICY.turn_fraction * float(x.max() - x.min())
    return _native.turning_points(np.ascontiguousarray(x), swing)


@dataclass(frozen=True, slots=True)
class LoopSummary:
    """How often and how far a signal went back and forth.

    Attributes
    ----------
    turns
        Number of inner turning points.
    loops
        Back-and-forth cycles, two swings each, ``(turns + 1) // 2``.
    swings
        Distances between successive turning points, (turns + 1,). [unit of x]
    """

    turns: int
    loops: int
    swings: Array


def summarise_loops(signal: npt.ArrayLike, swing: float | None = None) -> LoopSummary:
    """Count the loops of a signal and measure their swings.

    Examples
    --------
    >>> import numpy as np
    >>> summarise_loops(np.sin(np.linspace(0.0, 6 * np.pi, 301))).loops
    3
    """
    x = np.asarray(signal, dtype=np.float64)
    points = turning_points(x, swing)
    swings = np.abs(np.diff(x[points]))
    turns = max(0, points.size - 2)
    return LoopSummary(turns=turns, loops=(turns + 1) // 2, swings=swings)


def gap_limit(step: npt.ArrayLike) -> float:
    """Smallest step between samples that counts as a gap: 5 medians and 3 usual steps. [s]

    The usual step is the mean of the shortest 95 %. Where more than one step in twenty would be a gap, samples come
    in bursts, and only what is 5 times longer than the pauses between bursts counts.

    Parameters
    ----------
    step
        Steps of time, (T - 1,); those that are not positive do not count. [s]

    Examples
    --------
    >>> gap_limit([1.0] * 30 + [9.0])
    5.0
    """
    steps = np.asarray(step, dtype=np.float64)
    steps = np.sort(steps[steps > 0])
    if steps.size == 0:
        return float("inf")
    usual = float(np.mean(steps[: max(1, int(0.95 * steps.size))]))
    limit = max(POLICY.gap_medians * float(np.median(steps)), POLICY.gap_samples * usual)
    if np.mean(steps > limit) > 0.05:
        limit = POLICY.gap_medians * float(np.percentile(steps, 95))
    return float(limit)


def is_even(step: npt.ArrayLike) -> bool:
    """Whether samples come at an even pace: nine of ten steps are within half of the median step.

    What is written at every change of a signal, or by hand, is not; a timer of a busy computer is.

    Examples
    --------
    >>> is_even([1.0, 1.1, 0.9, 7.0] * 2 + [1.0] * 30), is_even([0.2, 1.0, 3.0, 0.5, 8.0])
    (True, False)
    """
    steps = np.asarray(step, dtype=np.float64)
    steps = steps[steps > 0]
    middle = float(np.median(steps)) if steps.size else 0.0
    return bool(
        steps.size
        and np.mean(np.abs(steps - middle) <= POLICY.even_within * middle) >= POLICY.even_share
    )


def memory_lost(
    step: Array, moved: Array, span: float, measured: float, swings: int
) -> npt.NDArray[np.bool_]:
    """Whether the input may have turned unseen within each gap.

    It may if it differs by more than 5 % of its range across the gap, or if the gap is longer than half a loop.

    Parameters
    ----------
    step, moved
        Length of each gap [s] and |dx| across it, (m,). [input]
    span
        Range of the input. [input]
    measured
        Time that was measured, gaps left out. [s]
    swings
        Number of swings of the input.
    """
    lost: npt.NDArray[np.bool_] = (moved > POLICY.moved * span) | (step > measured / max(1, swings))
    return lost


def taken_back(places: npt.NDArray[np.int64], size: Array, samples: int) -> list[tuple[int, int]]:
    """Jumps of a clock that the next one takes back soon, as pairs of their numbers; of a log of so many samples.

    Examples
    --------
    >>> taken_back(np.array([10, 14, 400, 900]), np.array([1.0, -1.0, 1.0, -1.0]), 1000)
    [(0, 1)]
    """
    near = max(POLICY.back_samples, int(POLICY.back_share * samples))
    spans, k = [], 0
    while k + 1 < places.size:
        cancels = abs(size[k] + size[k + 1]) <= POLICY.back_alike * abs(size[k])
        if cancels and places[k + 1] - places[k] <= near:
            spans.append((k, k + 1))
            k += 1
        k += 1
    return spans
