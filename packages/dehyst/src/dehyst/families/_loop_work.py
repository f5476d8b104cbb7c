"""Closed loops of a model: their area, whose sign tells whether the output leads or lags, and their dead band."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from dehyst.families._policy import POLICY
from dehyst.models import Model

BEHIND_RISE, BEHIND_FALL = 5, 9  # ways of the motion of `dead_band` behind its turns in the middle


def work(
    model: Model, low: float, high: float, seconds: float = 10.0, samples: int = 400
) -> tuple[float, float]:
    """Return the work that a closed loop between two inputs takes up, and its size: range of input times output.

    The third of three equal loops counts: those before bring a model that forgets to its closed loop. The work is
    positive where the output leads, as friction does, and negative where it lags.

    Examples
    --------
    >>> from dehyst import StopOperatorModel
    >>> area, _ = work(StopOperatorModel([0.0, 0.5], [0.0, 2.0], slope=0.0), -2.0, 2.0)
    >>> round(area, 3)  # of a slider of force 1 and stiffness 2: 4 (2 - 0.5)
    6.0
    """
    falling = np.linspace(high, low, samples + 1)[:-1]
    rising = np.linspace(low, high, samples + 1)[:-1]
    turns = np.concatenate([falling, rising])
    x = np.append(np.tile(turns, 3), high)
    y = model.simulate(x, np.arange(x.size) * seconds / (2 * samples))
    # The area by the rule of trapezoids, along the last of the three loops.
    last = slice(4 * samples, None)
    area = float(np.sum(0.5 * (y[last][1:] + y[last][:-1]) * np.diff(x[last])))
    return area, float((high - low) * np.ptp(y[last]))


@dataclass(frozen=True, slots=True)
class DeadBand:
    """How far the input of a model moves behind a turn before the output does.

    Attributes
    ----------
    width
        [input]
    percent
        Of the input's range.
    """

    width: float
    percent: float


def dead_band(model: Model, seconds: float = 10.0, samples: int = 1000) -> DeadBand | None:
    r"""Return the dead band of a model, or None if it has none.

    Behind a turn plays answer one after the other: after a way v the slope is the sum of the weights of those with
    :math:`2 r_i \le v`. The dead band is the way until the slope first reaches a tenth of its mean over the range. It
    is measured behind turns in the middle of the range, where no output is saturated, from below and from above; the
    shorter way counts. So it is one for models of every kind.

    Parameters
    ----------
    model
        Its card names the range of the input.
    seconds, samples
        Of half a way through the range; the band is exact to one part in so many of half the range.

    Returns
    -------
    band
        None where the band is less than 1 % of the input's range, the model needs other signals too, or has no range.

    Examples
    --------
    >>> from dehyst import PrandtlIshlinskii
    >>> from dehyst.models import ModelCard, SignalCard
    >>> valve = PrandtlIshlinskii([0.5, 2.0], [1.0, 1.0])  # no play without width: nothing moves within 2 (0.5)
    >>> card = ModelCard(SignalCard("pressure", "bar", 0.0, 10.0), SignalCard("travel", "mm", 0.0, 20.0))
    >>> dead_band(valve.with_card(card))
    DeadBand(width=1.0, percent=10.0)
    """
    low, high = model.card.input.low, model.card.input.high
    if low is None or high is None or not high > low or model.needs:
        return None
    middle = 0.5 * (low + high)
    tips = (low, middle, high, middle, low, middle, low, middle, high, middle, high)
    ways = [np.linspace(a, b, samples, endpoint=False) for a, b in itertools.pairwise(tips)]
    x = np.append(np.concatenate(ways), high)
    y = model.simulate(x, np.arange(x.size) * seconds / samples)
    steps = np.abs(np.diff(y)).reshape(-1, samples)
    least = POLICY.dead_slope * float(np.ptp(y)) / (2 * samples)
    if not least > 0.0:
        return None
    # The first step that moves the output, behind the turn from below and behind that from above.
    moves = steps[[BEHIND_RISE, BEHIND_FALL]] >= least
    if not moves.any(axis=1).all():
        return None
    share = 0.5 * int(np.min(np.argmax(moves, axis=1))) / samples
    if share < POLICY.dead_least:
        return None
    return DeadBand(round((high - low) * share, 12), 100.0 * share)
