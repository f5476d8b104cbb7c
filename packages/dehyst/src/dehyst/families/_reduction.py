r"""Takes terms out of a sum of elements while it stays the sum that it was.

The full sum, with all its weights, is the teacher: a smaller sum of some of its columns is fitted to what it answers,
along the log and along a probing motion of random strokes that the log need not have::

    minimise  sum over rows of (c + A_s v - s)^2 + ridge,   s = c_0 + A w,   v >= 0

Columns are taken out by what the squared error grows without each, :math:`v_k^2 / (H^{-1})_{kk}` (Hassibi and Stork
1993), and the others are fitted again. That the error on the log alone grows little would not be enough: a log shows
few turning points, and terms that none of them needs are those that all other motions need.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array, Mask
from dehyst.errors import DehystError
from dehyst.families._training import Stretch

Numbers = npt.NDArray[np.int64]

STROKES = 80  # of the probing motion
MOST_PROBED = 20_000  # samples of it
PROBED_ROWS = 3000
RESTING = 0.15  # share of its strokes behind which it rests ...
REST = 40  # ... so many samples
AT_ONCE = 12  # of so many terms one is taken out of a sum that is too large, then the others are fitted again
RIDGE = 1e-9  # keeps the sums regular; relative to their mean diagonal
PROVEN = 1e-6  # violation of the optimality conditions, relative


@dataclass(frozen=True, eq=False)
class Teacher:
    """What a smaller sum is fitted to.

    Attributes
    ----------
    rows
        Columns of the full sum at all rows, (K, p).
    weight
        How much each row counts, (K,).
    sets
        Which rows belong to the log, and which to the probing motion, (K,) each.
    offset, weights
        c_0 and w, (p,).
    least
        Lower bounds of the weights, (p,); what has one above 0 stays.
    outputs
        The output for values of the sum: its map, if it has one.
    """

    rows: Array
    weight: Array
    sets: Sequence[Mask]
    offset: float
    weights: Array
    least: Array
    outputs: Callable[[Array], Array]

    @cached_property
    def sums(self) -> Array:
        """What the full sum is, (K,)."""
        return np.asarray(self.offset + self.rows @ self.weights)

    @cached_property
    def answers(self) -> Array:
        """Its outputs, (K,)."""
        return self.outputs(self.sums)


@dataclass(frozen=True, eq=False)
class Reduced:
    """A smaller sum: offset, weights of all columns (p,), most of them 0, and how far its conditions are violated.

    `apart` is the difference of its output to that of the full sum, rms, on the set of rows where it is largest.
    """

    offset: float
    weights: Array
    kkt: float
    apart: float = 0.0


def probing(stretches: Sequence[Stretch], seed: int = 0) -> tuple[Array, Array | None]:
    """Return input and time steps of random strokes over the range -1 to 1, as fast as the stretches move.

    The motion is used with either sign, so that a log with both signs changed leads to the same model.
    """
    random = np.random.default_rng(seed)
    moves = np.abs(np.concatenate([np.diff(stretch.x) for stretch in stretches]))
    moves = moves[moves > 0.0]
    paces = np.quantile(moves, [0.3, 0.6, 0.9]) if moves.size else np.full(3, 0.01)
    tips = np.concatenate([[0.0, 1.0, -1.0], random.uniform(-1.0, 1.0, STROKES)])
    way = float(np.sum(np.abs(np.diff(tips))))
    paces = np.maximum(paces, 3.0 * way / MOST_PROBED)
    parts = [np.zeros(1)]
    for begin, end in pairwise(tips.tolist()):
        samples = max(2, round(abs(end - begin) / float(random.choice(paces))))
        parts.append(begin + (end - begin) * np.arange(1, samples + 1) / samples)
        if random.random() < RESTING:
            parts.append(np.full(REST, end))
    x = np.concatenate(parts)
    steps = [stretch.dt[1:] for stretch in stretches if stretch.dt is not None]
    if len(steps) < len(stretches):
        return x, None
    dt = np.full(x.size, float(np.median(np.concatenate(steps))))
    dt[0] = 0.0
    return x, dt


def reduced(
    teacher: Teacher, tolerance: float, too_large: Callable[[Array], bool] | None = None
) -> Reduced:
    """Return the smallest sum that was found whose output is within a tolerance, rms, on each set of rows.

    While its weights (p,) are `too_large`, terms are taken out whatever the tolerance, as long as there are any.
    """
    # Rows times the roots of their weights: a product of one matrix with itself takes half of what that of two takes.
    root = np.sqrt(teacher.weight)[:, None]
    rows = np.empty((len(root), 1 + teacher.weights.size))
    rows[:, :1] = root
    np.multiply(teacher.rows, root, out=rows[:, 1:])
    gram = rows.T @ rows
    gram[np.diag_indices_from(gram)] += RIDGE * float(np.mean(np.diag(gram)))
    target = teacher.sums
    side = rows.T @ (root[:, 0] * target)
    norm = float(np.sqrt(teacher.weight @ target**2))
    stays = teacher.least > 0.0
    smallest = Reduced(teacher.offset, teacher.weights, 0.0)
    share = 0.5
    while True:
        chosen = np.flatnonzero(stays | (smallest.weights > 0.0))
        order = _dispensable(gram, chosen, smallest.weights[chosen], stays)
        count = max(1, int(share * order.size))
        smaller = None
        while order.size and smaller is None and count:
            remaining = np.setdiff1d(chosen, order[:count])
            smaller = _fitted(gram, side, norm, teacher, remaining)
            if smaller is None or smaller.apart > tolerance:
                smaller, share, count = None, share / 3.0, count // 3
        if smaller is None and order.size and too_large and too_large(smallest.weights):
            # A few of the least at a time, so that the others can take over.
            remaining = np.setdiff1d(chosen, order[: max(1, order.size // AT_ONCE)])
            smaller = _fitted(gram, side, norm, teacher, remaining)
        if smaller is None:
            return smallest
        smallest = smaller


def _dispensable(gram: Array, chosen: Numbers, weights: Array, stays: Mask) -> Numbers:
    """Return the columns that can be taken out, those that matter least first."""
    unknowns = np.concatenate([[0], 1 + chosen])
    inverse = np.linalg.inv(gram[np.ix_(unknowns, unknowns)])
    growth = weights**2 / np.maximum(np.diag(inverse)[1:], 1e-300)
    order = chosen[np.argsort(growth, kind="stable")]
    return np.asarray(order[~stays[order]])


def _fitted(
    gram: Array, side: Array, norm: float, teacher: Teacher, chosen: Numbers
) -> Reduced | None:
    """Return the sum of some columns that is closest to the full one; None if it was not solved."""
    unknowns = np.concatenate([[0], 1 + chosen])
    lower = np.concatenate([[0.0], teacher.least[chosen]])
    try:
        u, _, kkt, *_ = _native.solve_bounded(
            np.ascontiguousarray(gram[np.ix_(unknowns, unknowns)]), side[unknowns], lower, 1, 0,
            _native.WEIGHTS, None, None, None, max(norm, 1e-150),
        )  # fmt: skip
    except DehystError:
        return None
    if not kkt <= PROVEN:
        return None
    weights = np.zeros(teacher.weights.size)
    weights[chosen] = u[1:]
    offset = float(u[0])
    return Reduced(offset, weights, float(kkt), _apart(teacher, offset, weights))


def _apart(teacher: Teacher, offset: float, weights: Array) -> float:
    """Return the difference to the output of the full sum on the set of rows where it is largest, rms."""
    answer = teacher.outputs(offset + teacher.rows @ weights)
    square = (answer - teacher.answers) ** 2
    apart = [np.average(square[rows], weights=teacher.weight[rows]) for rows in teacher.sets]
    return float(np.sqrt(max(apart)))
