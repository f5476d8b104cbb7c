"""Least squares over a muscle model's parameters: linear ones solved, others searched from several starts.

The search itself finds the parameters that the force is linear in: their mixed second differences vanish. For fixed
values of the others they are solved in closed form (variable projection, Golub and Pereyra 1973), so that a search has
few dimensions; the best start is polished over all parameters at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares, lsq_linear

from dehyst.arrays import Array
from dehyst.errors import DehystError

RANDOM_STARTS = 8
POLISHED = 2  # best starts that are searched to the end
NO_EFFECT = 1e-12  # of the largest force, by a parameter that is moved by a tenth
LINEAR = 1e-9  # the same, of a second difference
ON_BOUND = 1e-6  # distance from a bound that counts as none, of a step
WIDE = 30.0  # bounds whose ratio is larger are searched on a logarithmic scale
EVALUATIONS = 50  # of a search, finite differences not counted

Predict = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of a search.

    Attributes
    ----------
    vector
        (n,) best parameters; those without effect keep their values.
    jacobian
        (m, n) slopes of the forces there, zero for those without effect.
    active, linear
        (n,) which parameters have an effect on the samples, and which the forces are linear in.
    starts
        Number of starts.
    """

    vector: Array
    jacobian: Array
    active: npt.NDArray[np.bool_]
    linear: npt.NDArray[np.bool_]
    starts: int


def search_parameters(
    predict: Predict,
    target: Array,
    first: Array,
    others: list[Array],
    bounds: tuple[Array, Array],
    seed: int,
) -> SearchResult:
    """Return the parameters with the least sum of squares.

    Parameters
    ----------
    predict
        Parameters (n,) -> forces (m,); may raise a `DehystError` where it has none.
    target
        (m,) measured.
    first, others
        Starts, (n,) each: the first decides which parameters have an effect and enter linearly.
    bounds
        Lower and upper, (n,) each.
    seed
        Of further starts.
    """
    low, high = bounds
    x0 = _inside(first, low, high)
    steps = _steps(x0, low, high)
    active, linear = _kinds(predict, x0, steps, float(np.max(np.abs(target))))
    problem = _LeastSquares(predict, target, low, high, active, linear, steps)
    starts = [x0]
    for other in others:
        starts.append(_inside(np.where(active, other, x0), low, high))
    # Where all parameters are linear, one solution is the best one.
    searched = 1
    if np.any(active & ~linear):
        starts += _drawn(x0, low, high, active, np.random.default_rng(seed))
        searched = POLISHED
    candidates = sorted(map(problem.projected, starts), key=_cost_of)
    ends = [problem.searched(x) for _, x in candidates[:searched]]
    _, best = min([*ends, candidates[0]], key=_cost_of)
    best = problem.snapped(problem.polished(best)[1])
    return SearchResult(best, problem.slopes(best), active, linear, len(starts))


def _cost_of(candidate: tuple[float, Array]) -> float:
    return candidate[0]


def refine_parameters(
    predict: Predict, target: Array, result: SearchResult, bounds: tuple[Array, Array]
) -> SearchResult:
    """Return the least squares of other samples, from parameters that are good already."""
    steps = _steps(result.vector, *bounds)
    problem = _LeastSquares(predict, target, *bounds, result.active, result.linear, steps)
    _, projected = problem.projected(result.vector)
    best = problem.snapped(problem.polished(projected)[1])
    return replace(result, vector=best, jacobian=problem.slopes(best))


class _LeastSquares:
    """Forces, bounds, and which parameters move."""

    def __init__(
        self, predict: Predict, target: Array, low: Array, high: Array,
        active: npt.NDArray[np.bool_], linear: npt.NDArray[np.bool_], steps: Array,
    ) -> None:  # fmt: skip
        self.predict = predict
        self.target = target
        self.low = low
        self.high = high
        self.steps = steps
        self.active = active
        self.linear = active & linear
        self.unit = max(float(np.sqrt(np.mean(target**2))), 1e-12)

    def miss(self, x: Array) -> Array:
        """Return the errors (m,), large and finite where the model has no force."""
        try:
            error = self.predict(x) - self.target
        except DehystError:
            return np.full(self.target.size, 100.0 * self.unit)
        return np.nan_to_num(
            error, nan=100.0 * self.unit, posinf=1e6 * self.unit, neginf=-1e6 * self.unit
        )

    def cost(self, x: Array) -> float:
        return float(np.sum(self.miss(x) ** 2))

    def projected(self, x: Array) -> tuple[float, Array]:
        """Return cost and parameters, the linear ones solved for within their bounds."""
        which = np.flatnonzero(self.linear)
        if not which.size:
            return self.cost(x), x
        base = self.miss(x)
        columns = np.empty((base.size, which.size))
        for place, i in enumerate(which.tolist()):
            columns[:, place] = self.miss(x + self._step_of(i)) - base
        norm = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        scale = self.steps[which] / norm
        # The R factor has the same least squares in few rows.
        problem = np.column_stack((columns / norm, -base))
        small = np.asarray(np.linalg.qr(problem, mode="r"), float)
        rows = small[:, :-1]
        right_side = small[:, -1]
        delta = np.linalg.lstsq(rows, right_side, rcond=1e-12)[0] * scale
        new = x.copy()
        new[which] += delta
        if np.any(new < self.low) or np.any(new > self.high):
            box = (self.low[which] - x[which]) / scale, (self.high[which] - x[which]) / scale
            solved = lsq_linear(
                rows, right_side, bounds=(box[0] - 1e-12, box[1] + 1e-12), method="bvls"
            )
            new[which] = x[which] + solved.x * scale
            new = np.clip(new, self.low, self.high)
        new_cost = self.cost(new)
        cost = float(np.sum(base**2))
        if new_cost <= cost:
            return new_cost, new
        return cost, x

    def searched(self, x: Array) -> tuple[float, Array]:
        """Return cost and parameters after a search over those that are not linear, the others solved in each step."""
        outer = np.flatnonzero(self.active & ~self.linear)
        if outer.size:
            _, x = self._least(outer, x, self._projected_miss(x, outer))
        return self.projected(x)

    def polished(self, x: Array) -> tuple[float, Array]:
        """Return cost and parameters after a search over all of them at once, which a good start makes short."""
        # Linear parameters at a bound have been solved for: there they stay.
        free = np.flatnonzero(self.active & ~(self.linear & self.at_bound(x)))
        return self._least(free, x, lambda v: self.miss(self._put(x, free, v)))

    def at_bound(self, x: Array) -> npt.NDArray[np.bool_]:
        """Return which parameters (n,) lie on a bound, to rounding."""
        return np.asarray(np.minimum(x - self.low, self.high - x) <= ON_BOUND * self.steps)

    def snapped(self, x: Array) -> Array:
        """Return the parameters, those very near a bound moved to it, if the cost is no higher."""
        near = np.where(x - self.low <= self.high - x, self.low, self.high)
        new = np.where(self.active & self.at_bound(x), near, x)
        if self.cost(new) <= self.cost(x) * (1.0 + 1e-9):
            return new
        return x

    def _projected_miss(self, x: Array, outer: npt.NDArray[np.int64]) -> Callable[[Array], Array]:
        return lambda v: self.miss(self.projected(self._put(x, outer, v))[1])

    def _least(
        self, which: npt.NDArray[np.int64], x: Array, miss: Callable[[Array], Array]
    ) -> tuple[float, Array]:
        if not which.size:
            return self.cost(x), x
        low, high = self.low[which], self.high[which]
        start = _inside(x, self.low, self.high)[which]
        solution = least_squares(
            lambda v: miss(v) / self.unit, start, bounds=(low, high), x_scale=self.steps[which],
            max_nfev=EVALUATIONS, xtol=1e-9, ftol=1e-9, gtol=1e-9,
        )  # fmt: skip
        new = self._put(x, which, solution.x)
        cost, before = self.cost(new), self.cost(x)
        if cost < before:
            return cost, new
        return before, x

    def slopes(self, x: Array) -> Array:
        """Return the slopes of the forces (m, n) by central differences, inside the bounds."""
        columns = np.zeros((self.target.size, x.size))
        for i in np.flatnonzero(self.active):
            h = 1e-4 * self.steps[i]
            low = np.clip(x[i] - h, self.low[i], self.high[i])
            high = np.clip(x[i] + h, self.low[i], self.high[i])
            a = self.miss(self._put(x, np.array([i]), np.array([low])))
            b = self.miss(self._put(x, np.array([i]), np.array([high])))
            columns[:, i] = (b - a) / max(high - low, 1e-300)
        return columns

    def _step_of(self, i: int) -> Array:
        moved: Array = np.zeros(self.low.size)
        moved[i] = self.steps[i]
        return moved

    @staticmethod
    def _put(x: Array, which: npt.NDArray[np.int64], values: Array) -> Array:
        new = x.copy()
        new[which] = values
        return new


def _inside(x: Array, low: Array, high: Array) -> Array:
    """Return a start that is not on a bound, where a search could not begin."""
    width = np.where(np.isfinite(high - low), high - low, np.maximum(1.0, np.abs(x)))
    return np.asarray(np.clip(x, low + 1e-9 * width, high - 1e-9 * width))


def _steps(x: Array, low: Array, high: Array) -> Array:
    """Return the step (n,) of every parameter: a tenth of its value, less where a bound is near."""
    width = np.where(np.isfinite(high - low), high - low, np.maximum(1.0, np.abs(x)))
    size = np.where(x == 0.0, 0.01 * width, np.minimum(0.1 * np.abs(x), 0.1 * width))
    size = np.maximum(size, 1e-6 * width)
    return np.asarray(np.where(x + 2.0 * size <= high, size, np.minimum(size, 0.25 * width)))


def _kinds(
    predict: Predict, x: Array, steps: Array, largest: float
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Return which parameters have an effect, and a set of them in which the forces are jointly affine."""
    base = predict(x)
    n = x.size
    unit = np.eye(n) * steps

    def at(move: Array) -> Array | None:
        # The other way where the model has no force at the first one.
        for side in (1.0, -1.0):
            try:
                return side * (predict(x + side * move) - base)
            except DehystError:
                continue
        return None

    single = [at(unit[i]) for i in range(n)]
    active = np.ones(n, dtype=bool)
    for i, change in enumerate(single):
        if change is not None:
            active[i] = np.max(np.abs(change)) > NO_EFFECT * largest
    # A parameter joins the set if its effect adds to that of each of its members, and to itself.
    linear = np.zeros(n, dtype=bool)
    for i in np.flatnonzero(active).tolist():
        members = [*np.flatnonzero(linear).tolist(), i]
        linear[i] = all(
            _adds(single[i], single[j], at(unit[i] + unit[j]), largest) for j in members
        )
    return active, linear


def _adds(a: Array | None, b: Array | None, both: Array | None, largest: float) -> bool:
    if a is None or b is None or both is None:
        return False
    size = max(float(np.max(np.abs(a))), float(np.max(np.abs(b))), 1e-3 * largest)
    return bool(np.max(np.abs(both - a - b)) <= LINEAR * size + 1e-13 * largest)


def _drawn(
    x: Array, low: Array, high: Array, active: npt.NDArray[np.bool_], rng: np.random.Generator
) -> list[Array]:
    """Return starts drawn at random: half of them around the first one, half over the bounds."""
    starts = []
    wide = (low > 0) & np.isfinite(high) & (high > WIDE * low)
    for k in range(RANDOM_STARTS):
        share = rng.random(x.size)
        around = x * np.exp(rng.normal(0.0, 0.5, x.size))
        span = np.where(np.isfinite(high - low), high - low, np.maximum(1.0, np.abs(x)))
        lowest = np.where(np.isfinite(low), low, x - 0.5 * span)
        ratio = np.where(wide, high / np.where(wide, low, 1.0), 1.0)
        anywhere = np.where(wide, low * ratio**share, lowest + share * span)
        # All is drawn for every start, so that each start has the same random numbers.
        new = around if k % 2 == 0 else anywhere
        starts.append(_inside(np.where(active, new, x), low, high))
    return starts
