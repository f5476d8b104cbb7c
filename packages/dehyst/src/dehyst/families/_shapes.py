"""Search of the shapes of friction elements; curve and weights are solved for at every one of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, rank
from dehyst.families._base import STARTS, Scaling
from dehyst.families._friction import Mixable, Mixer, best_start
from dehyst.families._policy import POLICY
from dehyst.families._training import Training

F = TypeVar("F", bound=Mixable)
# Shapes, scaling and start -> a model of these elements.
Maker = Callable[[Sequence[Array], Scaling, str], F]

COARSE = 1500  # samples for the grid
FINE = 3000  # samples for the simplex
STEPS = 20  # evaluations of a simplex a parameter
ROUNDS = 2
NEAR = 1e-3  # of a simplex that has ended, in coordinates: shapes matter to their third digit
ALIKE = 1e-6  # of its errors, as a share of the first one


def search(
    training: Training,
    make: Maker[F],
    grid: Sequence[Array],
    limits: Array,
    most: int = 1,
    signs: tuple[int, ...] = (),
) -> F:
    """Return the best model of up to `most` elements: best of a grid, added one by one, each followed by a simplex.

    Parameters
    ----------
    training
        Data.
    make
        Makes a model of shapes.
    grid
        Shapes (p,) to begin with.
    limits
        (p, 2), between which shapes stay.
    most
        Largest number of elements.
    signs
        As of `Mixer`.
    """
    coarse = Mixer(training.thinned(COARSE), signs)
    fine = Mixer(training.thinned(FINE), signs)
    start, shapes, error = first_element(coarse, fine, make, grid, limits)
    for _ in range(1, most):
        # One more element from the grid, then all of them are refined together.
        _, best = _best_of_grid(coarse, make, shapes, grid, start)
        more_shapes, least = simplex(fine, make, [*shapes, grid[best]], limits, start)
        if not least < POLICY.friction_element * error:
            break
        shapes, error = more_shapes, least
    return Mixer(training.spread(), signs)(make(shapes, training.scaling, start))


def first_element(
    coarse: Mixer, fine: Mixer, make: Maker[F], grid: Sequence[Array], limits: Array
) -> tuple[str, list[Array], float]:
    """Return start state, shape and error of one element; the usual start and the best other one are both refined."""
    best: dict[str, tuple[float, int]] = {}
    for start in STARTS:
        best[start] = _best_of_grid(coarse, make, [], grid, start)
    unusual = [start for start in STARTS if start != "zero"]
    rival = min(unusual, key=lambda start: rank(best[start][0]))
    starts = ["zero"]
    if best[rival][0] < best["zero"][0]:
        starts.append(rival)
    shapes, errors = {}, {}
    for start in starts:
        shapes[start], errors[start] = simplex(fine, make, [grid[best[start][1]]], limits, start)
    start = best_start(errors)
    return start, shapes[start], errors[start]


def _best_of_grid(
    data: Mixer, make: Maker[F], shapes: Sequence[Array], grid: Sequence[Array], start: str
) -> tuple[float, int]:
    """Return the least error of the shapes with one more of the grid, and which one that is; the first of equals."""
    best = (float("inf"), 0)
    for k, shape in enumerate(grid):
        error = rank(data.error(make([*shapes, shape], data.training.scaling, start)))
        best = min(best, (error, k))
    return best


def simplex(
    data: Mixer, make: Maker[F], shapes: Sequence[Array], limits: Array, start: str
) -> tuple[list[Array], float]:
    """Return better shapes near given ones, and their error: Nelder and Mead within limits, a fixed budget."""
    size = len(shapes[0])
    bounds = np.tile(limits, (len(shapes), 1))

    def error(flat: npt.NDArray[np.float64]) -> float:
        return data.error(make(list(flat.reshape(-1, size)), data.training.scaling, start))

    best = np.clip(np.concatenate(shapes), bounds[:, 0], bounds[:, 1])
    least = error(best)
    # The simplex may collapse beside a limit; the second round spreads it again.
    for _ in range(ROUNDS):
        wide = np.minimum(0.4, 0.25 * (bounds[:, 1] - bounds[:, 0]))
        inward = np.where(best + wide > bounds[:, 1], -wide, wide)
        corners = np.vstack([best, best + np.diag(inward)])
        best, least = nelder_mead(error, corners, bounds, STEPS * best.size, NEAR, ALIKE * least)
    return list(best.reshape(-1, size)), least


def nelder_mead(
    error: Callable[[Array], float],
    corners: Array,
    bounds: Array,
    budget: int,
    near: float,
    alike: float,
) -> tuple[Array, float]:
    """Return where an error is least, and the error there: the simplex of Nelder and Mead within bounds.

    Parameters
    ----------
    error
        Of a point (p,).
    corners
        First simplex, (p + 1, p).
    bounds
        (p, 2): points beyond are moved to them.
    budget
        Evaluations; the iteration that spends the last one is ended.
    near, alike
        The search ends where all corners are as near in every coordinate, and their errors as alike.

    Examples
    --------
    >>> square = lambda x: float((x[0] - 0.2) ** 2 + (x[1] + 3.0) ** 2)
    >>> start, limits = np.array([[0.0, 0.0], [0.5, 0.0], [0.0, -0.5]]), np.array([[-1.0, 1.0], [-1.0, 1.0]])
    >>> best, least = nelder_mead(square, start, limits, 200, 1e-6, 1e-12)
    >>> best.round(4).tolist(), round(least, 6)
    ([0.2, -1.0], 4.0)
    """
    low, high = bounds[:, 0], bounds[:, 1]
    spent = 0

    def measured(point: Array) -> tuple[float, Array]:
        nonlocal spent
        spent += 1
        inside = np.clip(point, low, high)
        return error(inside), inside

    simplex = sorted(map(measured, corners), key=_error)
    while spent < budget:
        least, best = simplex[0]
        worst, point = simplex[-1]
        places = np.array([place for _, place in simplex])
        spread = float(np.max(np.abs(places - best)))
        if spread <= near and worst - least <= alike:
            break
        middle = np.mean(places[:-1], axis=0)
        way = middle - point
        next_corner = measured(middle + way)
        improves = next_corner[0] < simplex[-2][0]
        if next_corner[0] < least:
            next_corner = min(measured(middle + 2.0 * way), next_corner, key=_error)
        elif not improves and next_corner[0] < worst:
            limit = next_corner[0]
            next_corner = measured(middle + 0.5 * way)
            improves = next_corner[0] <= limit
        elif not improves:
            next_corner = measured(middle - 0.5 * way)
            improves = next_corner[0] < worst
        if improves:
            simplex[-1] = next_corner
        else:
            # Nothing helped: all corners move half of their way to the best one.
            for k in range(1, len(simplex)):
                simplex[k] = measured(best + 0.5 * (places[k] - best))
        simplex.sort(key=_error)
    return simplex[0][1], simplex[0][0]


def _error(corner: tuple[float, Array]) -> float:
    return corner[0]
