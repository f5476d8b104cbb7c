r"""Butterfly loops: a map that turns, behind a sum of plays that rises.

Strain over field of a ferroelectric, or of a magnetostrictive rod, falls and rises again along one stroke, and the loop
crosses itself. What is hysteretic there is the polarisation (or magnetisation) z; the strain is a function of it that
is even, or nearly so::

    y = g(z),   z = c + sum over k of f_k(P_k[x])        P_k plays, f_k piecewise linear and rising

with g piecewise linear, falling on one side of a place z0 and rising on the other: its two *wings*. Neither z nor its
unit is known, so z is scaled to -1 .. 1 over the fitted part; what saturates in z belongs to g.

===========  ==========================================  ======  ====================================================
parameter    meaning                                     unit    source
===========  ==========================================  ======  ====================================================
elements     plays with maps, of the sum z               scaled  search: steps of convex programs, from one play on
after_map    g: arguments z, and values                  scaled  convex for a given z
===========  ==========================================  ======  ====================================================

Each step linearises g(z) and solves for g and for weights from 0 on together (Gauss and Newton, damped as by
Levenberg); the first z is that of the one play which explains most. On one wing y is a rising function of z, so that
`ElementModel.wing` is an ordinary sum with an exact inverse.

Sources: electrostriction S = Q P^2, e.g. Damjanovic 2006, in The Science of Hysteresis 3; magnetostriction as a square
of the magnetisation, e.g. Jiles 1995, J. Phys. D 28. The map behind plays and its fit are this project's
(docs/decisions/0072-butterfly-loops.md). Structure: high confidence.

Cannot show
-----------
Rate, creep, drift; more than one turn of the map; loops of z that run clockwise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, rank
from dehyst.data import kit as data_kit
from dehyst.data import turning_points
from dehyst.errors import IdentificationError
from dehyst.families._choice import STARTS, row_bank
from dehyst.families._columns import Columns, columns_of
from dehyst.families._elements import Element, ElementModel
from dehyst.families._policy import POLICY
from dehyst.families._program import LEAST
from dehyst.families._registry import Family
from dehyst.families._training import Training
from dehyst.least_squares import solve_bounded

CELLS = 32  # along the input, in which strokes are averaged
PIECES = 24  # of the map
ROWS = 1500  # samples of the search, spread over the way of the input
THINNED = 20_000  # samples that the plays see
ROUNDS = 25  # steps of the search
NO_GAIN = 1e-4  # of the squared error, by which the last step must lower it
DAMPING, TRIES = 1e-2, 6
BEND, RIDGE = 0.05, 1e-3  # what a bend of the map, and a weight, count beside the error
KNOTS = np.linspace(-1.0, 1.0, PIECES + 1)
SMOOTH = BEND * np.diff(np.eye(PIECES + 1), 2, axis=0)
FLATTEST = 1e-3  # slope of a wing, scaled: the inverse of what is flatter would only answer noise


class Butterfly(NamedTuple):
    """Where the output turns along the largest strokes of the input.

    Attributes
    ----------
    rising, falling
        Input at the turn on the way up and on the way down, -1 to 1. [half ranges]
    valley
        Whether the output is lowest there; else it is highest.
    strokes
        Number of strokes that were averaged.
    """

    rising: float
    falling: float
    valley: bool
    strokes: int


def butterfly_in(signals: Sequence[tuple[Array, Array]]) -> Butterfly | None:
    """Return where the output turns within strokes, if these make a butterfly; None if not.

    Both ways over most of the range must have a turn of the same kind, well inside and deep enough, the one on the
    way up at no lower input. A damper or a resonance has a peak on one way and a valley on the other.

    Parameters
    ----------
    signals
        Input and output, scaled to -1 .. 1, (T,) each, of every piece.

    Examples
    --------
    >>> x = np.sin(np.linspace(0.0, 20.0, 2000))
    >>> late = np.sin(np.linspace(0.0, 20.0, 2000) - 0.3)
    >>> butterfly_in([(x, 2.0 * late**2 - 1.0)]).valley, butterfly_in([(x, late)])
    (True, None)
    """
    sums, counts = np.zeros((2, CELLS)), np.zeros((2, CELLS))
    strokes = 0
    ways = []
    for x, y in signals:
        points = turning_points(x, POLICY.swing)
        for begin, end in pairwise(points.tolist()):
            ways.append((x[begin : end + 1], y[begin : end + 1]))
    largest = max((abs(x[-1] - x[0]) for x, _ in ways), default=0.0)
    for x, y in ways:
        if largest < POLICY.butterfly_stroke or abs(x[-1] - x[0]) < 0.8 * largest:
            continue
        strokes += 1
        cell = np.clip(((x + 1.0) * (0.5 * CELLS)).astype(np.int64), 0, CELLS - 1)
        falls = int(x[-1] < x[0])
        sums[falls] += np.bincount(cell, y, CELLS)
        counts[falls] += np.bincount(cell, minlength=CELLS)
    if strokes < POLICY.butterfly_strokes:
        return None
    for sign in (1.0, -1.0):
        turns = []
        for way in range(2):
            seen = np.flatnonzero(counts[way])
            turn = _turn(sign * sums[way, seen] / counts[way, seen])
            turns.append(-1 if turn is None else int(seen[turn]))
        up, down = turns
        # One cell less is none: a curve that turns without a loop, at the edge of a cell.
        if min(turns) >= 0 and up >= down - 1:
            places = (2.0 * np.array(turns) + 1.0) / CELLS - 1.0
            return Butterfly(float(places[0]), float(places[1]), sign > 0.0, strokes)
    return None


def _turn(profile: Array) -> int | None:
    """Return where a profile is lowest, if it is far above that at both ends, and nowhere far above both."""
    if profile.size < 3:
        return None
    ends = profile[0], profile[-1]
    depth, height = min(ends) - profile.min(), profile.max() - max(ends)
    return int(np.argmin(profile)) if depth >= POLICY.butterfly_depth > height else None


@dataclass(frozen=True, eq=False)
class _ButterflySearch:
    """Rows of the problem: columns (K, p) that rise, outputs (K,), both times the root of what a row counts."""

    columns: Columns
    values: Array
    y: Array
    root: Array

    @property
    def least(self) -> Array:
        """Lower bounds of the weights: after a reversal z must not stand still."""
        return np.where(self.columns.group == "x", LEAST, 0.0)

    @property
    def unit(self) -> float:
        """What makes a share of the scaled signals as heavy as all rows."""
        return float(np.linalg.norm(self.root))

    def map_of(self, z: Array) -> tuple[Array, float]:
        """Return the smooth map over `KNOTS` that fits the outputs best, and the squared error that it leaves."""
        rows = np.vstack([self.root[:, None] * _hats(z), self.unit * SMOOTH])
        target = np.concatenate([self.root * self.y, np.zeros(len(SMOOTH))])
        g = np.linalg.lstsq(rows, target, rcond=None)[0]
        return g, float(np.sum((target - rows @ g) ** 2))

    def refined(self, weight: Array) -> tuple[Array, float]:
        """Return better weights, and the offset, of z."""
        weight, offset = self._scaled(weight, 0.0)
        g, least = self._cost(weight, offset)
        damping = DAMPING
        for _ in range(ROUNDS):
            for _ in range(TRIES):
                moved = self._step(weight, offset, g, damping)
                moved_g, error = self._cost(*moved)
                if error < least:
                    break
                damping *= 8.0
            else:
                break
            gain = 1.0 - error / least
            (weight, offset), g, least = moved, moved_g, error
            damping /= 8.0
            if gain < NO_GAIN:
                break
        return weight, offset

    def _cost(self, weight: Array, offset: float) -> tuple[Array, float]:
        """Return the map behind a z, and what is to be least."""
        g, error = self.map_of(self.values @ weight + offset)
        return g, error + (RIDGE * self.unit) ** 2 * float(weight @ weight)

    def _step(self, weight: Array, offset: float, g: Array, damping: float) -> tuple[Array, float]:
        """Return weights and offset after a step; the program is linear in the map and in what these change by."""
        z = self.values @ weight + offset
        slope = self.root * (np.diff(g) / np.diff(KNOTS))[_piece(z)]
        size = weight.size
        of_map, of_weights = np.zeros((size, KNOTS.size + 1)), self.unit * np.eye(size)
        rows = np.vstack(
            [
                np.column_stack(
                    [self.root[:, None] * _hats(z), slope, slope[:, None] * self.values]
                ),
                np.column_stack([self.unit * SMOOTH, np.zeros((len(SMOOTH), 1 + size))]),
                np.column_stack([of_map, RIDGE * of_weights]),
                np.column_stack([of_map, np.sqrt(damping) * of_weights]),
            ]
        )
        firm = -RIDGE * self.unit * weight
        target = [self.root * self.y, np.zeros(len(SMOOTH)), firm, np.zeros(size)]
        system = np.column_stack([rows, np.concatenate(target)])
        step = solve_bounded(system, KNOTS.size + 1, self.least - weight)
        return self._scaled(weight + step.bounded, offset + float(step.free[-1]))

    def _scaled(self, weight: Array, offset: float) -> tuple[Array, float]:
        """Return weights and offset such that z goes from -1 to 1."""
        z = self.values @ weight + offset
        half = 0.5 * float(np.ptp(z))
        weight = np.maximum(weight / half, self.least)
        z = self.values @ weight
        return weight, -0.5 * float(z.max() + z.min())


def _piece(z: Array) -> npt.NDArray[np.int64]:
    """Return the piece of a map in which each value lies; the outer ones have no end."""
    return np.clip(np.searchsorted(KNOTS, z, side="right") - 1, 0, PIECES - 1)


def _hats(z: Array) -> Array:
    """Return the share (K, n) that each value of a map over `KNOTS` has; its ends go straight on."""
    piece = _piece(z)
    share = (z - KNOTS[piece]) / np.diff(KNOTS)[piece]
    rows = np.arange(z.size)
    hats = np.zeros((z.size, KNOTS.size))
    hats[rows, piece], hats[rows, piece + 1] = 1.0 - share, share
    return hats


def fit_butterfly(training: Training) -> ElementModel:
    """Sum of plays and map, by least squares of the output.

    Raises
    ------
    IdentificationError
        If the output does not turn as that of a butterfly does.
    """
    seen = butterfly_in([(stretch.x, stretch.y) for stretch in training.stretches])
    if seen is None:
        raise IdentificationError(
            f"the loop is no butterfly: along the {POLICY.butterfly_strokes} largest strokes or more the output would "
            f"have to turn at an inner input on both ways, by {50 * POLICY.butterfly_depth:g} % of its range or more. "
            f"Leave the family out, so that auto chooses one."
        )
    thin = training.unscheduled.thinned(THINNED)
    start, play = _first_play(thin)
    search = _search_of(thin, ("lag",), start)
    first = np.column_stack([np.ones(play.size), search.values, play])
    begin = solve_bounded(first, 1, search.least).bounded
    weight, offset = search.refined(begin)
    z = search.values @ weight + offset
    knots, g = _folded(search, z, seen.valley)
    return ElementModel(
        search.columns.elements(weight),
        offset,
        after_map=(tuple(knots.tolist()), tuple(g.tolist())),
        period=training.period,
        row="butterfly",
        scaling=training.scaling,
        start=start,
    )


def _search_of(training: Training, groups: tuple[str, ...], start: str) -> _ButterflySearch:
    columns = columns_of(groups, 8, None)
    signals = [stretch.x for stretch in training.stretches]
    rows = data_kit.spread_rows(signals, [stretch.counts for stretch in training.stretches], ROWS)
    bank = row_bank(training, "forward", columns, start, rows)
    return _ButterflySearch(
        columns, bank.values, bank.output, np.sqrt(bank.weight / np.mean(bank.weight))
    )


def _first_play(training: Training) -> tuple[str, Array]:
    """Return the start state, and along the rows the one play, of which a map explains most."""
    best: tuple[float, str, Array] = (float("inf"), "", np.zeros(0))
    for start in STARTS["forward"]:
        plays = _search_of(training, ("play",), start)
        errors = []
        for play in np.flatnonzero(plays.columns.group == "play").tolist():
            z = plays.values[:, play]
            if not np.ptp(z) > LEAST:
                continue
            z = 2.0 * (z - z.min()) / np.ptp(z) - 1.0
            errors.append((rank(plays.map_of(z)[1]), play))
        error, play = min(errors)
        if error < POLICY.better_start**2 * best[0]:
            best = (error, start, plays.values[:, play])
    return best[1], best[2]


def _folded(search: _ButterflySearch, z: Array, valley: bool) -> tuple[Array, Array]:
    """Return knots and values of the map that falls on one side of its turn, and rises on the other."""
    sign = 1.0 if valley else -1.0
    g = sign * search.map_of(z)[0]
    width = 2.0 / PIECES
    lowest = int(np.clip(np.argmin(g), 1, PIECES - 1))
    # The turn of the parabola through the lowest point and its neighbours, where a knot has to stand.
    bend = float(g[lowest - 1] - 2.0 * g[lowest] + g[lowest + 1])
    shift = 0.0
    if bend > 0.0:
        shift = 0.5 * float(np.clip((g[lowest - 1] - g[lowest + 1]) / bend, -1.0, 1.0))
    turn = KNOTS[lowest] + width * shift
    knots = turn + width * np.arange(-lowest, PIECES - lowest + 1)
    edges = np.concatenate([[-np.inf], knots[1:-1], [np.inf]])
    ramps = []
    for low, high in pairwise(edges.tolist()):
        ramps.append(np.abs(np.clip(z, low, high) - np.clip(turn, low, high)))
    hats = search.root[:, None] * np.column_stack([np.ones(z.size), *ramps])
    bends = np.zeros((PIECES - 1, PIECES + 1))
    bends[:, 1:] = BEND * search.unit * width * np.diff(np.eye(PIECES), axis=0)
    # At the turn the slope changes its sign.
    bends[lowest - 1] = 0.0
    rows = np.vstack([hats, bends])
    target = np.concatenate([search.root * sign * search.y, np.zeros(len(bends))])
    slopes = solve_bounded(np.column_stack([rows, target]), 1, np.full(PIECES, FLATTEST))
    rises = slopes.bounded * width * np.where(np.arange(PIECES) < lowest, -1.0, 1.0)
    values = np.concatenate([[0.0], np.cumsum(rises)])
    return knots, sign * (values - values[lowest] + float(slopes.free[0]))


def _sample() -> ElementModel:
    """Square of two plays."""
    z = np.linspace(-1.0, 1.0, 9)
    return ElementModel(
        (
            Element("input", weight=0.2),
            Element("play", 0.2, weight=0.4),
            Element("play", 0.4, weight=0.4),
        ),
        after_map=(tuple(z.tolist()), tuple((z**2).tolist())),
        row="butterfly",
    )


FAMILY = Family(
    name="butterfly",
    title="map that turns behind plays",
    model=ElementModel,
    fit=fit_butterfly,
    convex=False,
    source="Damjanovic 2006; Jiles 1995; docs/decisions/0072",
    sample=_sample,
)
