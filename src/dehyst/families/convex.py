"""Weights of elements in parallel: one convex program, and its held-out error within the training part.

    minimise |W (c + F a + P w - T(y))|^2   subject to   w >= lower,   T piecewise linear, rising, of mean slope 1

T is the identity, or it is identified too; W is 1, or 1/T' of a first solution, which makes the error one of y.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.families.parallel import ParallelModel
from dehyst.families.training import Training
from dehyst.identification.families import continued, map_points
from dehyst.identification.least_squares import solve_bounded, triangle

Array = npt.NDArray[np.float64]

FOLDS = 4
SMALLEST_SLOPE = 0.05  # of a map, as in identify
NORMALISATION = 1e3
RIDGE = 1e-3  # of weights, against the rms of the target: operators that are alike share what they explain
TWICE = 2  # solutions for a map: the second in units of the output


@dataclass(frozen=True, eq=False)
class Rows:
    """A linear program's rows at the compared samples.

    Attributes
    ----------
    free
        F (K, f), columns without bounds besides the constant.
    bounded
        P (K, n).
    y
        (K,)
    fold
        Which of `FOLDS` blocks a row belongs to, (K,).
    lower
        Bounds of w, (n,).
    weight
        W of a program without a map, (K,), or None.
    """

    free: Array
    bounded: Array
    y: Array
    fold: npt.NDArray[np.int64]
    lower: Array
    weight: Array | None = None


@dataclass(frozen=True, eq=False)
class Weights:
    """What such a program finds.

    Attributes
    ----------
    offset, free, bounded
        c, a (f,), w (n,).
    map_inner, map_outer
        T^-1 by its breakpoints; empty for the identity.
    """

    offset: float
    free: Array
    bounded: Array
    map_inner: Array
    map_outer: Array

    def predict(self, rows: Rows) -> Array:
        """Outputs (K,)."""
        u = self.offset + rows.free @ self.free + rows.bounded @ self.bounded
        return continued(u, self.map_inner, self.map_outer) if self.map_inner.size else u


def rows_of(training: Training, template: ParallelModel, lower: Array, free: tuple[int, ...] = ()) -> Rows:
    """Rows of a template's elements along the training's inputs, in the template's start state.

    Parameters
    ----------
    lower
        Bounds of the weights of the elements that are not `free`, in their order, (n,).
    free
        Which elements have weights without bounds.
    """
    outputs = []
    for s in training.stretches:
        dt = s.dt if template.rate_dependent else None
        outputs.append(template.parts.bank(template.seen(s.x), dt, template.before(float(s.x[0])))[s.counts])
    bank = np.concatenate(outputs)
    bounded = np.setdiff1d(np.arange(template.parts.size), free)
    return Rows(bank[:, list(free)], bank[:, bounded], training.y, folds_of(training), lower)


def folds_of(training: Training) -> npt.NDArray[np.int64]:
    """Block of every compared sample: each stretch in `FOLDS` parts."""
    parts = []
    for stretch in training.stretches:
        count = int(np.count_nonzero(stretch.counts))
        parts.append(np.arange(count, dtype=np.int64) * FOLDS // max(1, count))
    return np.concatenate(parts)


def solve(rows: Rows, pieces: int = 0, smoothing: float = 0.05) -> Weights:
    """Solve the program with all rows; `pieces` of the map, 0 for none."""
    return _solve([rows], rows, pieces, smoothing)


def held_out(rows: Rows, pieces: int = 0, smoothing: float = 0.05) -> float:
    """Root of the mean squared error of blocks that were not fitted, each left out in turn, scaled output."""
    parts = [_chosen(rows, rows.fold == number) for number in range(FOLDS)]
    square = 0.0
    for number, part in enumerate(parts):
        others = [other for k, other in enumerate(parts) if k != number and other.y.size]
        if part.y.size and others:
            found = _solve(others, rows, pieces, smoothing)
            miss = found.predict(part) - part.y
            square += float(np.sum((miss if part.weight is None else miss * part.weight) ** 2))
    return float(np.sqrt(square / max(1, rows.y.size)))


def _chosen(rows: Rows, mask: npt.NDArray[np.bool_]) -> Rows:
    weight = None if rows.weight is None else rows.weight[mask]
    return Rows(rows.free[mask], rows.bounded[mask], rows.y[mask], rows.fold[mask], rows.lower, weight)


def _solve(parts: list[Rows], whole: Rows, pieces: int, smoothing: float) -> Weights:
    f, n = whole.free.shape[1], whole.lower.size
    samples = sum(part.y.size for part in parts)
    scale = np.sqrt(samples * max(float(np.mean(whole.y**2)), 1e-12))
    ridge = np.zeros((n, 1 + f + n + 1))
    ridge[:, 1 + f : 1 + f + n] = RIDGE * scale * np.eye(n)
    if not pieces:
        columns = [_system(part) for part in parts]
        found = solve_bounded(np.vstack([*map(_short, columns), ridge]), 1 + f, whole.lower)
        return Weights(float(found.free[0]), found.free[1:], found.bounded, np.zeros(0), np.zeros(0))
    knots = np.linspace(float(whole.y.min()), float(whole.y.max()), pieces + 1)
    extra = _map_rows(pieces, 1 + f + n, smoothing * scale, NORMALISATION * scale)
    lower = np.concatenate([whole.lower, np.full(pieces, SMALLEST_SLOPE)])
    regularised = np.vstack([extra, np.insert(ridge, [1 + f + n] * pieces, 0.0, axis=1)])
    slopes = np.ones(pieces)
    for _ in range(TWICE):
        systems = []
        for part in parts:
            place = np.clip(np.searchsorted(knots, part.y, side="right") - 1, 0, pieces - 1)
            ramps = -_ramps(part.y, knots)
            system = np.column_stack([np.ones(part.y.size), part.free, part.bounded, ramps, np.zeros(part.y.size)])
            systems.append(_short(system / slopes[place][:, None]))
        found = solve_bounded(np.vstack([*systems, regularised]), 1 + f, lower)
        slopes = found.bounded[n:]
    u, v = map_points(knots, slopes)
    # The program's T begins with 0 at its first knot, the map's with the knot.
    return Weights(float(found.free[0] + knots[0]), found.free[1:], found.bounded[:n], u, v)


def _system(part: Rows) -> Array:
    system = np.column_stack([np.ones(part.y.size), part.free, part.bounded, part.y])
    return system if part.weight is None else system * part.weight[:, None]


def _short(system: Array) -> Array:
    return triangle(system) if system.shape[0] > system.shape[1] else system


def _ramps(y: Array, knots: Array) -> Array:
    """How far y has come in each piece, (K, p); the first and the last go on."""
    low, high = knots[:-1].copy(), knots[1:].copy()
    low[0], high[-1] = -np.inf, np.inf
    return np.asarray(np.clip(y[:, None], low, high) - knots[:-1])


def _map_rows(pieces: int, before: int, smoothing: float, normalisation: float) -> Array:
    """Rows that fix the mean slope 1 and hold neighbouring slopes together."""
    rows = np.zeros((pieces, before + pieces + 1))
    rows[0, before:-1] = normalisation / pieces
    rows[0, -1] = normalisation
    k = np.arange(1, pieces)
    rows[k, before + k - 1] = -smoothing
    rows[k, before + k] = smoothing
    return rows
