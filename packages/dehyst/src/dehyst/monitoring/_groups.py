r"""Groups cycles of a periodic signal so that each group is equally informative; t-tests between groups.

Tests on groups are honest about noise that is correlated within a group, whatever its colour: every group of
consecutive cycles is fitted by itself, and what counts is how the estimates :math:`\theta_g` of q groups scatter, not
how samples do:

.. math:: t = \frac{|\bar\theta - \theta_0| - \Delta}{\sqrt{s^2 / q + s_0^2 / q_0}}

with the smallest change :math:`\Delta` worth a word and q - 1 degrees of freedom, of two samples those of the smaller.
That is conservative for groups of unequal variance at levels below 8 %.

References
----------
R. Ibragimov, U. K. Müller, "t-Statistic Based Correlation and Heterogeneity Robust Inference", Journal of Business and
Economic Statistics 28(4), 2010; "Inference with Few Heterogeneous Clusters", Review of Economics and Statistics 98(1),
2016.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import turning_points
from dehyst.identification import known_from
from dehyst.student import place_of_tail, quantile, tail

# A swing begins or ends a cycle when it exceeds this share of the range; smaller ones are tried while the cycles are
# fewer than enough: small loops inside a large one belong to it.
SWINGS = (0.3, 0.15, 0.05)
ENOUGH_CYCLES = 8
# The memory counts as known once the signal came this close to both ends of its range: cycles are never quite alike.
NEAR_END = 0.1


@dataclass(frozen=True, slots=True)
class Cycle:
    """From one lower turning point of the driving signal to the next.

    Attributes
    ----------
    begin, end
        Samples, `end` excluded.
    path
        Sum of its squared swings, as a share of the squared range: how much it says.
    """

    begin: int
    end: int
    path: float


def cycles_of(x: Array, pieces: Sequence[slice], low: float, high: float) -> tuple[Cycle, ...]:
    """Return the complete cycles of a signal whose memory is known, in order.

    Parameters
    ----------
    x
        Driving signal, (T,).
    pieces
        Spans without a gap; the memory is unknown at the begin of each.
    low, high
        Range of the signal.

    Examples
    --------
    >>> x = np.tile([0.0, 1.0, 2.0, 1.0], 12)
    >>> found = cycles_of(x, [slice(0, x.size)], 0.0, 2.0)
    >>> len(found), found[0].begin, found[0].end
    (10, 4, 8)
    """
    best: list[Cycle] = []
    for share in SWINGS:
        cycles: list[Cycle] = []
        for piece in pieces:
            cycles += _of_piece(x, piece, low, high, share)
        if len(cycles) > len(best):
            best = cycles
        if len(best) >= ENOUGH_CYCLES:
            break
    return tuple(best)


def _of_piece(x: Array, piece: slice, low: float, high: float, share: float) -> list[Cycle]:
    """Cycles of a piece, cut where its swings exceed a share of the range."""
    span, part = high - low, np.ascontiguousarray(x[piece])
    if not span > 0.0 or part.size < 3:
        return []
    first_known = known_from(part, low + NEAR_END * span, high - NEAR_END * span)
    turns = turning_points(part, share * span)
    values = part[turns]
    inner = np.arange(1, turns.size - 1)
    lower = inner[(values[inner] < values[inner - 1]) & (turns[inner] >= first_known)]
    cycles = []
    for first, last in itertools.pairwise(lower.tolist()):
        path = float(np.sum(np.diff(values[first : last + 1]) ** 2)) / span**2
        cycles.append(Cycle(piece.start + int(turns[first]), piece.start + int(turns[last]), path))
    return cycles


def groups_of(cycles: Sequence[Cycle], most: int) -> list[tuple[Cycle, ...]]:
    """Cut cycles into at most so many consecutive groups of about equal squared path.

    Examples
    --------
    >>> [len(group) for group in groups_of([Cycle(k, k + 1, 1.0) for k in range(10)], 4)]
    [2, 3, 2, 3]
    """
    if len(cycles) <= most:
        return [(cycle,) for cycle in cycles]
    path = np.array([cycle.path for cycle in cycles])
    # A cycle belongs to the group that holds the middle of its path.
    before = np.cumsum(path) - 0.5 * path
    number = np.minimum((most * before / np.sum(path)).astype(np.int64), most - 1)
    groups: dict[int, list[Cycle]] = {}
    for n, cycle in zip(number.tolist(), cycles, strict=True):
        groups.setdefault(n, []).append(cycle)
    return list(map(tuple, groups.values()))


def samples_of_cycles(group: Sequence[Cycle]) -> npt.NDArray[np.int64]:
    """Indices of the samples of a group."""
    return np.concatenate([np.arange(cycle.begin, cycle.end) for cycle in group])


# Draws of the block bootstrap of a trend, and the blocks of cycles that it needs at least.
DRAWS = 999
TREND_BLOCKS = 16


@dataclass(frozen=True, slots=True)
class Contrast:
    """Difference of a mean from a number or another mean.

    Attributes
    ----------
    estimate, error
        Difference and its standard error.
    freedom
        Degrees of freedom of Student's distribution.
    """

    estimate: float
    error: float
    freedom: int

    def interval(self, confidence: float) -> tuple[float, float]:
        """Two-sided interval of that confidence."""
        reach = self.error * quantile(confidence, self.freedom)
        return self.estimate - reach, self.estimate + reach

    def p_value(self, tolerance: float, sided: int = 2) -> float:
        """Probability of such an estimate if the truth were within the tolerance; one-sided: not above it."""
        size = self.estimate
        if sided == 2:
            size = abs(size)
        beyond = size - tolerance
        # Simulated logs have no scatter: the estimate is then the truth.
        if self.error == 0.0:
            return float(not beyond > 0.0)
        return min(1.0, sided * tail(beyond / self.error, self.freedom))

    def detectable(self, tolerance: float, level: float) -> float:
        """Size of a change that would have been found nine times in ten at that level of a test."""
        return tolerance + self.error * (
            quantile(1.0 - level, self.freedom) + place_of_tail(0.1, self.freedom)
        )


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def contrast(values: Array, reference: Array | float = 0.0) -> Contrast:
    """Compare the mean of group estimates with a number, or with that of the groups of a reference.

    Examples
    --------
    >>> found = contrast(np.array([1.0, 2.0, 3.0]))
    >>> found.estimate, round(found.error, 4), found.freedom
    (2.0, 0.5774, 2)
    """
    variance = float(np.var(values, ddof=1)) / values.size
    if isinstance(reference, float):
        return Contrast(float(np.mean(values)) - reference, variance**0.5, values.size - 1)
    variance += float(np.var(reference, ddof=1)) / reference.size
    # The smaller sample bounds the freedom: that of Welch lies above it, so that the test is careful.
    freedom = min(values.size, reference.size) - 1
    return Contrast(float(np.mean(values) - np.mean(reference)), variance**0.5, freedom)


def trend(places: Array, values: Array, confidence: float) -> tuple[float, float, float] | None:
    """Slope of values over places with its interval, by a bootstrap of overlapping blocks of residuals.

    None if there are too few values. Draws are the same every time.

    Examples
    --------
    >>> k = np.arange(40.0)
    >>> slope, low, high = trend(k, 0.5 * k + np.sin(9 * k), 0.95)
    >>> low < 0.5 < high
    True
    """
    n = values.size
    if n < TREND_BLOCKS or not np.ptp(places) > 0.0:
        return None
    centred = places - np.mean(places)
    lever = centred / float(centred @ centred)
    slope = float(lever @ values)
    residuals = values - np.mean(values) - slope * centred
    # Neighbouring blocks of cycles are correlated: residuals are drawn in runs that keep this.
    length = max(3, round(2.0 * n ** (1 / 3)))
    random = np.random.default_rng(0)
    starts = random.integers(0, n - length + 1, (DRAWS, -(-n // length)))
    drawn = residuals[(starts[:, :, None] + np.arange(length)).reshape(DRAWS, -1)[:, :n]]
    # Residuals of a straight line, in blocks, are a little smaller than the noise.
    spread = float(np.std(drawn @ lever)) * float(np.sqrt(n / max(n - length - 2, 1)))
    reach = spread * quantile(confidence, max(2, n // length - 2))
    return slope, slope - reach, slope + reach
