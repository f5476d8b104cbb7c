r"""Estimates the delay between two signals of a log: the shift at which a sum of elements fits best.

The sum is fitted again at every shift, and it contains the lag of the loop itself, by creep or friction. So a shift
that fits better is a dead time: of transport, of a filter, or between two clocks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dehyst.arrays import Array
from dehyst.families._choice import Chosen, ScoredSum, workshop_of
from dehyst.families._policy import POLICY
from dehyst.families._program import BLOCKS
from dehyst.families._rows import best_row, transformed, turns_of
from dehyst.families._training import Training

STEPS = 100  # the first shift that is tried is a stroke divided by this
ROUNDED = 1e-6  # of a sample: a time that was typed as a multiple of the period is one
FARTHEST = 8  # the largest one is a stroke divided by this


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


class ChosenRow(NamedTuple):
    """The best row, by how much the output is late, and how many samples of that the row has as dead time."""

    chosen: Chosen
    late: Lateness | None
    delay: int

    @property
    def score(self) -> float:
        """Its error on what is left out, rms, scaled."""
        return self.chosen.candidates[0].score


def best_row_and_delay(training: Training, firm: bool, size: int | None, ahead: float) -> ChosenRow:
    """Return the best row, with the dead time that the log shows.

    Parameters
    ----------
    training
        The fitted part.
    firm, size
        As of `best_row`.
    ahead
        How long before its time the reference of the compensator is known: so much of a dead time is taken. [s]
    """
    turns = turns_of(training)
    chosen = best_row(training, firm, size)
    training, chosen = transformed(training, chosen, firm, size)
    late = _lateness(training, chosen.candidates[0], turns)
    if late is None:
        return ChosenRow(chosen, None, 0)
    delay = _delay(late, training.period, ahead)
    if delay == 0:
        return ChosenRow(chosen, late, 0)
    forward = bool(training.before_map[0])
    chosen = best_row(training.late(delay), firm, size, forward)
    if delay == late.samples:
        # The first row had to explain the dead time by its lags; this one tells it better.
        late = _nearer(training, chosen.candidates[0], turns, late)
        if late.samples != delay:
            delay = _delay(late, training.period, ahead)
            chosen = best_row(training.late(delay), firm, size, forward)
    return ChosenRow(chosen.later(delay * training.period), late, delay)


def _delay(late: Lateness, period: float, ahead: float) -> int:
    """Return the dead time of the model in samples: what the log shows, as far as the reference is known ahead."""
    if not period > 0.0:
        return 0
    known = np.floor(ahead / period + ROUNDED)
    return int(max(0.0, min(float(late.samples), known)))


def _lateness(training: Training, chosen: ScoredSum, turns: int) -> Lateness | None:
    r"""Return by how many samples the output is late; None where that is not clear.

    Moving the output by d samples changes the squared error of a fit by :math:`2 d \sum e_k y_k'` to first order,
    without any new fit, since its weights are at their optimum. Only where a shift by a hundredth of a stroke promises
    10 % are sums fitted to shifted signals.

    Parameters
    ----------
    training
        The fitted part.
    chosen
        The sum that was chosen for it.
    turns
        Of the input within it. With no more turns than blocks, some block has none, and the answer is None.
    """
    if turns <= BLOCKS:
        return None
    if abs(_promised(training, chosen, _first_step(training, turns))) < POLICY.promised_error:
        return None
    late = _best_shift(training, chosen, turns)
    share = POLICY.late_error if late.samples > 0 else POLICY.early_error
    if abs(late.samples) < POLICY.least_shift or not late.shifted < share * late.without:
        return None
    return late


def _nearer(training: Training, chosen: ScoredSum, turns: int, late: Lateness) -> Lateness:
    """Return the shift anew for the sum that was chosen from the shifted signals; the same where that gains little.

    The first shift is that of a sum which had to explain the dead time by its lags.

    Parameters
    ----------
    training
        The fitted part, as logged.
    chosen
        The sum that was chosen for it once the output was moved.
    turns
        Of the input within it.
    late
        The shift by which it was moved.
    """
    moved = training.late(late.samples)
    more = _best_shift(moved, chosen, turns)
    if more.shifted * POLICY.smaller_model > more.without or not late.samples + more.samples > 0:
        return late
    return Lateness(late.samples + more.samples, late.without, more.shifted)


def _first_step(training: Training, turns: int) -> int:
    """A hundredth of a stroke, in samples."""
    return max(1, round(training.samples / (turns + 1) / STEPS))


def _best_shift(training: Training, chosen: ScoredSum, turns: int) -> Lateness:
    """Return the shift with the least score, to the side where the squared error falls."""
    scores: dict[int, float] = {}

    def score(shift: int) -> float:
        if shift not in scores:
            scores[shift] = _score(training, chosen, shift)
        return scores[shift]

    # Upwards in steps that double, as long as the score falls ...
    best, step = 0, _first_step(training, turns)
    if _promised(training, chosen, step) < 0.0:
        step = -step
    while abs(best + step) * FARTHEST * (turns + 1) <= training.samples:
        if not score(best + step) < score(best):
            break
        best, step = best + step, 2 * step
    # ... then to either side in steps that are halved, down to one sample.
    while abs(step) > 1:
        step = int(step / 2)
        near = min((best - step, best + step), key=score)
        if score(near) < score(best):
            best = near
    return Lateness(best, score(0), score(best))


def _score(training: Training, chosen: ScoredSum, shift: int) -> float:
    moved = training.late(shift)
    if not moved.stretches:
        return float("inf")
    shop = workshop_of(moved, chosen.sum.direction, chosen.sum.groups)
    return shop.candidate(chosen.sum, chosen.mapped, chosen.regularisation).score


def _promised(training: Training, chosen: ScoredSum, shift: int) -> float:
    """Return the share of the squared error that a shift of the output removes; below 0 if it should go back."""
    shop = workshop_of(training, chosen.sum.direction, chosen.sum.groups)
    error, forward = shop.missed(chosen), chosen.sum.direction == "forward"
    # The workshop holds a thinned training: the shift is counted in its samples.
    rows = shift * shop.training.samples / training.samples
    moved = []
    for stretch in shop.training.stretches:
        moved.append(_moved(stretch.y if forward else stretch.x, rows))
    change = np.array([moved[number][at] for number, at in shop.bank.places.tolist()])
    # The rows count as they do in the fit, whose weights are at their optimum.
    weighted = shop.bank.weight * error
    return float((2.0 if forward else -2.0) * (weighted @ change) / (weighted @ error))


def _moved(signal: Array, rows: float) -> Array:
    """Return how much a signal changes within so many samples, (T,), by central differences."""
    half = max(1, round(rows))
    at = np.arange(signal.size)
    after = np.minimum(at + half, signal.size - 1)
    before = np.maximum(at - half, 0)
    return np.asarray(0.5 * rows / half * (signal[after] - signal[before]))
