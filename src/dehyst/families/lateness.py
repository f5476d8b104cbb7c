r"""Estimates the delay between two signals of a log: the shift at which a sum of elements fits best.

A lag that the loop itself has, creep or friction, is in the sum already, which is fitted anew at every shift. What is
left for a shift is a dead time: of transport, of a filter, of two clocks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dehyst.families.choice import Candidate, workshop_of
from dehyst.families.program import BLOCKS
from dehyst.families.training import Training
from dehyst.models.arrays import Array

STEPS = 100  # of a stroke: the first shift that is tried is one of them
FARTHEST = 8  # of a stroke: the largest one
SEEN = 0.1  # share of the squared error that the first shift has to promise
LATE = 0.85  # of the error without a shift: above it nothing is said ...
EARLY = 0.7  # ... of an output that is early, as which rate poses, above this
LEAST_SHIFT = 2  # samples: differences between neighbours, and stamps at either end of a period, make one


@dataclass(frozen=True)
class Lateness:
    """A shift that explains a log better.

    Attributes
    ----------
    samples
        By which the output is late; below 0 it is early.
    without, shifted
        Score of the sum without and with the shift, scaled.
    """

    samples: int
    without: float
    shifted: float


def lateness(training: Training, chosen: Candidate, turns: int) -> Lateness | None:
    r"""Return by how many samples the output is late, None where that is not clear.

    Moving the output by d samples changes the squared error of a fit by :math:`2 d \sum e_k y_k'` to first order,
    without any new fit, since its weights are at their optimum. Only where a shift by a hundredth of a stroke promises
    10 % are sums fitted to shifted signals: with steps that double as long as the score falls, then halved.

    Parameters
    ----------
    training
        The fitted part.
    chosen
        The sum that was chosen for it.
    turns
        Of the input within it. With no more of them than blocks some block has none, and nothing is told.
    """
    first = max(1, round(training.samples / (turns + 1) / STEPS))
    if turns <= BLOCKS:
        return None
    promise = _promised(training, chosen, first)
    if abs(promise) < SEEN:
        return None
    scores = {0: _score(training, chosen, 0)}

    def score(shift: int) -> float:
        if shift not in scores:
            scores[shift] = _score(training, chosen, shift)
        return scores[shift]

    best, step = 0, first if promise > 0.0 else -first
    while abs(best + step) * FARTHEST * (turns + 1) <= training.samples and score(best + step) < score(best):
        best, step = best + step, 2 * step
    while best:
        step = int(step / 2) or 1
        near = min((best - step, best + step), key=score)
        if score(near) < score(best):
            best = near
        elif step == 1:
            break
    if abs(best) < LEAST_SHIFT or not score(best) < (LATE if best > 0 else EARLY) * score(0):
        return None
    return Lateness(best, score(0), score(best))


def _score(training: Training, chosen: Candidate, shift: int) -> float:
    moved = training.late(shift)
    if not moved.stretches:
        return float("inf")
    shop = workshop_of(moved, chosen.sum.direction, chosen.sum.groups)
    return shop.candidate(chosen.sum, chosen.mapped, chosen.regularisation).score


def _promised(training: Training, chosen: Candidate, shift: int) -> float:
    """Share of the squared error that goes if the output is moved ahead by a few samples; below 0 if the other way."""
    shop = workshop_of(training, chosen.sum.direction, chosen.sum.groups)
    error, forward = shop.missed(chosen), chosen.sum.direction == "forward"
    rows = shift * shop.training.samples / training.samples
    moved = [_moved(stretch.y if forward else stretch.x, rows) for stretch in shop.training.stretches]
    change = np.array([moved[number][at] for number, at in shop.bank.places.tolist()])
    return float((2.0 if forward else -2.0) * (error @ change) / (error @ error))


def _moved(signal: Array, rows: float) -> Array:
    """What a signal changes within so many samples, (T,)."""
    half, at = max(1, round(rows)), np.arange(signal.size)
    after, before = np.minimum(at + half, signal.size - 1), np.maximum(at - half, 0)
    return np.asarray(0.5 * rows / half * (signal[after] - signal[before]))
