"""Search of the shapes of friction elements; curve and weights are solved for at every one of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize

from dehyst.arrays import Array, rank
from dehyst.families.base import STARTS, Scaling
from dehyst.families.friction import Mixable, Mixer, best_start
from dehyst.families.training import Training

F = TypeVar("F", bound=Mixable)
Maker = Callable[[Sequence[Array], Scaling, str], F]  # shapes, scaling and start -> a model of these elements

COARSE = 1500  # samples for the grid
FINE = 3000  # samples for the simplex
STEPS = 20  # evaluations of a simplex a parameter
ROUNDS = 2
GAIN = 0.95  # of the error that another element must at least come down to


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
    coarse, fine = (Mixer(training.thinned(samples), signs) for samples in (COARSE, FINE))
    start, shapes, error = first_element(coarse, fine, make, grid, limits)
    for _ in range(1, most):
        tried = [rank(coarse.error(make([*shapes, shape], training.scaling, start))) for shape in grid]
        better, least = simplex(fine, make, [*shapes, grid[tried.index(min(tried))]], limits, start)
        if not least < GAIN * error:
            break
        shapes, error = better, least
    return Mixer(training, signs)(make(shapes, training.scaling, start))


def first_element(
    coarse: Mixer, fine: Mixer, make: Maker[F], grid: Sequence[Array], limits: Array
) -> tuple[str, list[Array], float]:
    """Return start state, shape and error of one element; the usual start and the best other one are both refined."""
    best: dict[str, tuple[float, int]] = {}
    for start in STARTS:
        best[start] = min(
            (rank(coarse.error(make([s], coarse.training.scaling, start))), k) for k, s in enumerate(grid)
        )
    other = min((start for start in STARTS if start != "zero"), key=lambda start: rank(best[start][0]))
    tried = ["zero", other] if best[other][0] < best["zero"][0] else ["zero"]
    refined = {start: simplex(fine, make, [grid[best[start][1]]], limits, start) for start in tried}
    start = best_start({start: error for start, (_, error) in refined.items()})
    return (start, *refined[start])


def simplex(
    data: Mixer, make: Maker[F], shapes: Sequence[Array], limits: Array, start: str
) -> tuple[list[Array], float]:
    """Return better shapes near given ones, and their error: Nelder and Mead within limits, a fixed budget."""
    size = len(shapes[0])
    bounds = np.tile(limits, (len(shapes), 1))

    def error(flat: npt.NDArray[np.float64]) -> float:
        return data.error(make(list(flat.reshape(-1, size)), data.training.scaling, start))

    best = np.clip(np.concatenate(shapes), bounds[:, 0], bounds[:, 1])
    for _ in range(ROUNDS):  # a simplex that has collapsed beside a limit is spread anew
        wide = np.minimum(0.4, 0.25 * (bounds[:, 1] - bounds[:, 0]))
        corners = np.vstack([best, best + np.diag(np.where(best + wide > bounds[:, 1], -wide, wide))])
        options = {"initial_simplex": corners, "maxfev": STEPS * best.size, "xatol": 1e-3, "fatol": 1e-6 * error(best)}
        found = minimize(error, best, method="Nelder-Mead", bounds=bounds, options=options)
        best = found.x
    return list(best.reshape(-1, size)), float(found.fun)
