"""Which samples stand for a log in a choice, and which of them are left out together.

A choice looks at some thousand samples of a log. They are spread by way, not by time: a log that rests for most of its
time would else be chosen for how it rests. The input counts as moving once it has left a band around its last place, so
that noise at rest is no way. All rests together count as a class of their own, with a fifth of the weight at most.

What is left out together is a fifth of the way: once in four parts that lie far from each other, and once in one piece.
The memory of a model depends on the input alone, which is known throughout, so any samples can be left out without
breaking it. Parts that are spread are covered by what stays, also of one loop: they tell how well a model interpolates.
A fifth in one piece is another motion, at another time: it tells how well a model goes on. The score of a candidate is
the geometric mean of both.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array, Mask
from dehyst.data._policy import POLICY

Numbers = npt.NDArray[np.int64]

FOLDS = 5
# Fold of each part of the way. No two neighbours are left out together, and of cycles of 2 to 10 parts each fold leaves
# out two different phases at least.
ORDER = np.array([3, 2, 0, 4, 1, 4, 1, 3, 2, 0, 2, 0, 3, 1, 4, 1, 4, 3, 0, 2])
ROUNDING = 1e-9  # of a part


class SpreadRows(NamedTuple):
    """Samples of a signal that stand for it.

    Attributes
    ----------
    rows
        Their indices, increasing, (k,).
    weight
        How much each counts, 1 in the mean of all signals, (k,).
    """

    rows: Numbers
    weight: Array


def spread_rows(
    signals: Sequence[Array], counts: Sequence[Mask], most: int
) -> tuple[SpreadRows, ...]:
    """Return the samples of each signal that stand for it in a choice.

    Parameters
    ----------
    signals
        Inputs x, (T,) each, one of them at least not constant.
    counts
        Which samples count, (T,) each.
    most
        Number of samples of all signals together, about; all are taken if there are fewer.

    Examples
    --------
    >>> x = np.concatenate([np.linspace(-1.0, 1.0, 50), np.ones(950)])  # it rests for 95 % of the time
    >>> spread = spread_rows([x], [np.ones(1000, dtype=bool)], 100)[0]
    >>> bool(np.sum(spread.weight[spread.rows < 50]) > 0.75 * np.sum(spread.weight))
    True
    """
    shares = shares_of(signals, counts)
    samples = sum(int(np.count_nonzero(count)) for count in counts)
    spread = []
    if samples <= most:
        for share, count in zip(shares, counts, strict=True):
            rows = np.flatnonzero(count)
            spread.append(SpreadRows(rows, samples * share[rows]))
        return tuple(spread)
    places = (np.arange(most) + 0.5) / most
    begun = 0.0
    for share in shares:
        progress = begun + np.cumsum(share)
        end = progress[-1] if progress.size else begun
        inside = places[(places >= begun) & (places < end)]
        at = np.searchsorted(progress, inside, side="right")
        rows, weight = np.unique(at, return_counts=True)
        spread.append(SpreadRows(rows.astype(np.int64), weight.astype(np.float64)))
        begun = end
    taken = sum(part.rows.size for part in spread)
    scale = taken / most
    return tuple(part._replace(weight=scale * part.weight) for part in spread)


def shares_of(signals: Sequence[Array], counts: Sequence[Mask]) -> tuple[Array, ...]:
    """Return how much of the whole each sample stands for, by its way, or as a part of all rests; in all 1.

    Examples
    --------
    >>> share = shares_of([np.array([0.0, 1.0, 1.0, 0.0, 0.0])], [np.ones(5, dtype=bool)])[0]
    >>> share.round(3).tolist()  # the way is 0.8 of the whole, the rests are 0.2
    [0.067, 0.4, 0.067, 0.4, 0.067]
    """
    moves = _moves(signals)
    way, still, samples = 0.0, 0, 0
    for move, count in zip(moves, counts, strict=True):
        way += float(np.sum(move[count]))
        still += int(np.count_nonzero(count & (move == 0.0)))
        samples += int(np.count_nonzero(count))
    rests = min(POLICY.most_rests, still / max(samples, 1))
    if not way > 0.0:
        rests = 1.0
    shares = []
    for move, count in zip(moves, counts, strict=True):
        share = np.where(move == 0.0, rests / max(still, 1), 0.0)
        if way > 0.0:
            share = share + move * ((1.0 - rests) / way)
        shares.append(np.where(count, share, 0.0))
    return tuple(shares)


def folds_of(weight: Array) -> tuple[Numbers, Numbers]:
    """Return the folds, 0 to 4, that each row of a log belongs to, spread and in one piece, (k,) each.

    Parameters
    ----------
    weight
        Weights of the rows in their order, (k,).

    Examples
    --------
    >>> spread, in_one_piece = folds_of(np.ones(40))
    >>> spread[:8].tolist(), in_one_piece[:9].tolist()
    ([3, 3, 2, 2, 0, 0, 4, 4], [0, 0, 0, 0, 0, 0, 0, 0, 1])
    """
    ends = np.cumsum(weight)
    progress = ends - 0.5 * weight
    total = max(float(ends[-1]), 1e-300) if ends.size else 1.0
    # A row whose middle is the end of a part belongs to the next one, whatever the rounding.
    part = np.floor(progress * (ORDER.size / total) + ROUNDING).astype(np.int64)
    part = np.minimum(part, ORDER.size - 1)
    return np.asarray(ORDER[part]), part // (ORDER.size // FOLDS)


def score_of(errors: Array) -> float:
    """Return the number that candidates are ranked by, the lowest first.

    Parameters
    ----------
    errors
        Rms errors on what was left out, (10,): of the five spread folds, then of the five in one piece. Not a number
        where a fold has no row.

    Examples
    --------
    >>> round(score_of(np.array([1.0, 1.0, 1.0, 1.0, 1.0, 4.0, 4.0, 4.0, 4.0, 4.0])), 9)
    2.0
    """
    means = []
    for part in (errors[:FOLDS], errors[FOLDS:]):
        scored = part[~np.isnan(part)]
        # A log so short that no fold of a kind has a row has no score.
        if not scored.size:
            return float("nan")
        means.append(scored.mean())
    return float(np.sqrt(means[0] * means[1]))


def _moves(signals: Sequence[Array]) -> list[Array]:
    """How far each sample moves on its signal, (T,): the way of a play as wide as the band."""
    low = min(float(np.min(x)) for x in signals if x.size)
    high = max(float(np.max(x)) for x in signals if x.size)
    band = np.array([POLICY.still_band * 0.5 * (high - low)])
    moves = []
    for x in signals:
        if not x.size:
            moves.append(np.zeros(0))
            continue
        rows = np.arange(x.size, dtype=np.int64)
        z, _ = _native.play_bank(np.ascontiguousarray(x), band, x[:1].copy(), rows)
        moves.append(np.abs(np.diff(z[:, 0], prepend=x[0])))
    return moves
