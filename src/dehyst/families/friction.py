"""What families of friction along a path share: y = c(x) + sum of w z[x], forwards, backwards, fitted convexly."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from scipy.optimize import nnls

from dehyst import _native
from dehyst.errors import IdentificationError, ParameterError
from dehyst.families.base import LoopModel
from dehyst.families.curve import FLOOR, rising_polynomials, slopes, values
from dehyst.families.inversion import FARTHEST
from dehyst.families.training import Training
from dehyst.models.arrays import Array, parameter_array

F = TypeVar("F", bound="FrictionLoop")

CALM = 1e-9  # least slope of the output over the input that counts as rising


class FrictionLoop(LoopModel):
    """A curve plus weighted elements whose states z move along the path of the input, whatever its speed.

    The output leads where weights are positive (clockwise loops, as of a force over a displacement), and lags where
    they are negative. Memory: the input before, and the state of each element.
    """

    curve: Array
    weights: Array

    @abstractmethod
    def table(self) -> Array:
        """Elements (m, 10) as the engine takes them: slope, power, psi at 4 (dx > 0) + 2 (z > 0) + (x > 0)."""

    @abstractmethod
    def slope_ranges(self) -> tuple[Array, Array]:
        """Least and largest dz/dx of each element over all its reachable states, (m,)."""

    def check(self) -> None:
        """Take over arrays that cannot be written to, and check what every family of this kind needs."""
        for name in ("curve", "weights"):
            object.__setattr__(self, name, parameter_array(getattr(self, name), name))

    @cached_property
    def _table(self) -> Array:
        return np.ascontiguousarray(self.table().ravel())

    def rest(self, x: float) -> Array:
        """Every element relaxed, at x."""
        return np.concatenate([[x], np.zeros(self.weights.size)])

    def run(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Outputs along scaled inputs, and the memory after them."""
        return _native.bank_run(x, self.curve, self._table, self.weights, memory)

    def run_inverse(self, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Inputs for outputs: a root of a rising function each sample, to the last bits."""
        return _native.bank_invert(y, FARTHEST, self.curve, self._table, self.weights, memory)

    def states(self, x: Array) -> Array:
        """States (T, m) of the elements along scaled inputs, from the start state on."""
        return _native.bank_states(x, self._table, self.before(float(x[0])))

    @property
    def least_slope(self) -> float:
        """Largest lower bound of dy/dx over all places and reachable states, scaled."""
        low, high = self.slope_ranges()
        return float(np.min(slopes(self.curve)) + np.sum(np.where(self.weights < 0.0, high, low) * self.weights))

    @property
    def no_inverse(self) -> str:
        """Why not: some reachable state in which the output does not rise with the input."""
        least = self.least_slope
        if least > CALM:
            return ""
        return (
            f"after a turn its output may move against its input (least slope {least:.3g} of the mean one), so that "
            f"one output belongs to several inputs."
        )

    @property
    def free_parameters(self) -> int:
        """Coefficients of the curve, and what each element has of its own."""
        return int(self.curve.size + (1 + self.own) * np.count_nonzero(self.weights))

    @property
    @abstractmethod
    def own(self) -> int:
        """Parameters of an element besides its weight."""


@dataclass(frozen=True)
class Mixture:
    """Best curve and weights for elements that are given: `rms` is the scaled residual."""

    curve: Array
    weights: Array
    rms: float


def mix(training: Training, model: FrictionLoop, signs: tuple[int, ...] = (1, -1)) -> Mixture:
    """Return the curve and weights that fit best with a model's elements and start: convex, and rising throughout.

    The columns are polynomials that rise, and for each element what leads, ``z - min(0, low) x``, and what lags,
    ``high x - z``, low and high the limits of dz/dx. Each rises in every state, and so does their sum with weights
    that are not negative. `signs` says which of the two are offered.
    """
    basis = rising_polynomials()
    low, high = model.slope_ranges()
    x = training.joined(lambda s: s.x[:, None])[:, 0]
    z = training.joined(lambda s: model.states(s.x))
    columns = [values(row, x)[:, None] for row in basis]
    if 1 in signs:
        columns.append(z - np.minimum(0.0, low) * x[:, None])
    if -1 in signs:
        columns.append(high * x[:, None] - z)
    found, offset, rms = nonnegative(np.hstack(columns), training.y - FLOOR * x)
    parts = np.split(found, np.cumsum([len(basis), *[low.size] * (len(signs) - 1)]))
    curve = parts[0] @ basis
    weights = np.zeros(low.size)
    for sign, part in zip((s for s in (1, -1) if s in signs), parts[1:], strict=True):
        weights += sign * part
        curve[1] += np.sum(part * (high if sign < 0 else -np.minimum(0.0, low)))
    curve[0] += offset
    curve[1] += FLOOR
    return Mixture(curve, weights, rms)


def nonnegative(columns: Array, y: Array) -> tuple[Array, float, float]:
    """Return weights >= 0 and an offset that fit y best, and the root mean square of what remains."""
    mean, level = columns.mean(axis=0), float(y.mean())
    centred = columns - mean
    size = np.linalg.norm(centred, axis=0)
    size[size == 0.0] = 1.0
    triangle: Array = np.linalg.qr(np.column_stack([centred / size, y - level]), mode="r")  # type: ignore[assignment]
    if not np.all(np.isfinite(triangle)):
        return np.zeros(size.size), level, float("inf")
    try:
        scaled, miss = nnls(triangle[:, :-1], triangle[:, -1], maxiter=30 * size.size)
    except RuntimeError:
        raise IdentificationError(
            f"the least squares with weights >= 0 over {size.size} columns did not end. The log hardly moves: "
            f"look at it with dehyst inspect.",
            columns=size.size,
        ) from None
    weights = scaled / size
    return weights, level - float(mean @ weights), float(miss) / np.sqrt(y.size)


def positive(values: Array, name: str, least: float = 0.0) -> None:
    """Raise ParameterError unless all values are above `least`."""
    if np.any(values <= least):
        k = int(np.argmax(values <= least))
        raise ParameterError(f"{name}[{k}] = {values[k]:g}, but must be above {least:g}.", index=k)
