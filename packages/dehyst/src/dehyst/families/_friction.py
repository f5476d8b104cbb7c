"""Common base of friction models along a path: y = c(x) + sum of w z[x], forward, inverse, convex fit."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from functools import cached_property
from typing import Protocol, Self, TypeVar

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array, rank
from dehyst.errors import IdentificationError, ParameterError
from dehyst.families._base import LoopModel
from dehyst.families._curve import FLOOR, rising_polynomials, slopes, values
from dehyst.families._inversion import FARTHEST
from dehyst.families._policy import POLICY
from dehyst.families._training import Training
from dehyst.least_squares import lawson_hanson, triangle
from dehyst.models import kit as models_kit

M = TypeVar("M", bound="Mixable")

SHARPEST = (
    100.0  # power of an element: with more a knee is a corner, and a move costs as many steps
)
CALM = 1e-9  # least slope of the output over the input that counts as rising


class Mixable(Protocol):
    """A model that is linear in a curve and in the weights of columns."""

    def states(self, x: Array, dt: Array | None = None) -> Array:
        """Columns (T, m) along scaled inputs, from the start state on."""

    def column_ranges(self) -> tuple[Array, Array]:
        """How fast each column falls and rises over the input, (m,), where a fit is to keep the output rising."""

    def mixed(self, curve: Array, weights: Array) -> Self:
        """Return the model with a curve and weights."""


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
            object.__setattr__(self, name, models_kit.parameter_array(getattr(self, name), name))

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

    def states(self, x: Array, dt: Array | None = None) -> Array:
        """States (T, m) of the elements along scaled inputs, from the start state on."""
        return _native.bank_states(x, self._table, self.before(float(x[0])))

    def column_ranges(self) -> tuple[Array, Array]:
        """As `slope_ranges`: a fitted model rises in every state."""
        return self.slope_ranges()

    def mixed(self, curve: Array, weights: Array) -> Self:
        """Return the same elements over another curve with other weights."""
        return replace(self, curve=curve, weights=weights)  # type: ignore[type-var]

    @property
    def least_slope(self) -> float:
        """Largest lower bound of dy/dx over all places and reachable states, scaled."""
        low, high = self.slope_ranges()
        worst = np.where(self.weights < 0.0, high, low)
        return float(np.min(slopes(self.curve)) + np.sum(worst * self.weights))

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
        """Coefficients of the curve, and weight and parameters of each element."""
        per_element = 1 + self.parameters_of_element
        return int(self.curve.size + per_element * np.count_nonzero(self.weights))

    @property
    @abstractmethod
    def parameters_of_element(self) -> int:
        """Parameters of an element besides its weight."""


class Mixer:
    """Best curves and weights on one set of data, for one model's elements after the other: convex programs.

    The columns are polynomials that rise, and for each element one that leads, ``z - min(0, low) x``, or one that lags,
    ``high x - z``, low and high the limits of dz/dx. Each rises in every state, and so does their sum with weights
    that are not negative. Where the loops of the log run one way round, elements of that sign are offered only.

    Parameters
    ----------
    training
        Data.
    signs
        Those offered: 1 leads, -1 lags; by default those that the loops of the log show.
    """

    def __init__(self, training: Training, signs: tuple[int, ...] = ()) -> None:
        self.training = training
        self._basis = rising_polynomials()
        self._x = training.joined(lambda s: s.x[:, None])[:, 0]
        self._curves = np.column_stack([values(row, self._x) for row in self._basis])
        self._y = training.y - FLOOR * self._x
        by_orientation = {"clockwise": (1,), "counter-clockwise": (-1,)}
        self.signs = signs or by_orientation.get(training.orientation, (1, -1))

    def error(self, model: Mixable) -> float:
        """Return the root mean square of what the best mixture leaves; infinite for elements that diverge."""
        if not np.all(np.isfinite(model.column_ranges())):
            return float("inf")
        columns = self._columns(model)
        if not np.all(np.isfinite(columns)):
            return float("inf")
        return quick(columns, self._y)

    def __call__(self, model: M) -> M:
        """Return the model with the best curve and weights."""
        low, high = model.column_ranges()
        solution, offset = nonnegative(self._columns(model), self._y)
        first = len(self._basis)
        curve = solution[:first] @ self._basis
        curve[0] += offset
        curve[1] += FLOOR
        weights = np.zeros(low.size)
        by_sign = solution[first:].reshape(len(self.signs), -1)
        # Each column holds a share of x besides its element; that share belongs to the curve.
        for sign, part in zip(self.signs, by_sign, strict=True):
            weights += sign * part
            share = high if sign < 0 else -np.minimum(0.0, low)
            curve[1] += np.sum(part * share)
        return model.mixed(curve, weights)

    def _columns(self, model: Mixable) -> Array:
        low, high = model.column_ranges()
        z = self.training.joined(lambda s: model.states(s.x, s.dt))
        x = self._x[:, None]
        columns = [self._curves]
        for sign in self.signs:
            if sign > 0:
                columns.append(z - np.minimum(0.0, low) * x)
            else:
                columns.append(high * x - z)
        return np.hstack(columns)


def quick(columns: Array, y: Array) -> float:
    """Return the residual of the best weights >= 0 and offset, by normal equations: precise enough to compare."""
    # Without its mean each column is free of the offset, which need not be solved for.
    centred, target = columns - columns.mean(axis=0), y - y.mean()
    size = np.sqrt(np.einsum("ij,ij->j", centred, centred))
    size[size == 0.0] = 1.0
    gram = (centred.T @ centred) / np.outer(size, size)
    gram.flat[:: size.size + 1] += 1e-12
    side = (centred.T @ target) / size
    weights = _native.solve_bounded(
        gram,
        side,
        np.zeros(size.size),
        0,
        0,
        _native.WEIGHTS,
        target_norm=max(float(np.linalg.norm(target)), 1e-150),
    )[0]
    square = float(target @ target - 2.0 * (side @ weights) + weights @ gram @ weights)
    return float(np.sqrt(max(square, 0.0) / y.size))


def nonnegative(columns: Array, y: Array) -> tuple[Array, float]:
    """Return the weights >= 0 and the offset that fit y best, by an orthogonal factorisation."""
    mean, level = columns.mean(axis=0), float(y.mean())
    reduced = triangle(np.column_stack([columns - mean, y - level]))
    # Columns of length 1 keep the tolerances of the solver meaningful; a column of zeros stays as it is.
    size = np.linalg.norm(reduced[:, :-1], axis=0)
    size[size == 0.0] = 1.0
    scaled = lawson_hanson(reduced[:, :-1] / size, reduced[:, -1])
    if scaled is None:
        raise IdentificationError(
            f"the least squares with weights >= 0 over {size.size} columns did not end. The log hardly moves: "
            f"look at it with dehyst inspect.",
            columns=size.size,
        )
    weights = scaled / size
    return weights, level - float(mean @ weights)


def best_start(errors: dict[str, float]) -> str:
    """Return the start state with the smallest error; "zero", unless that is worse by a tenth.

    A wrong start may fit a short log a little better, with elements so long that they never settle.
    """
    least = min(errors, key=lambda start: rank(errors[start]))
    return least if errors[least] < POLICY.friction_start * errors["zero"] else "zero"


def positive(values: Array, name: str) -> None:
    """Raise ParameterError unless all values are above 0."""
    bad = values <= 0.0
    if np.any(bad):
        k = int(np.argmax(bad))
        raise ParameterError(f"{name}[{k}] = {values[k]:g}, but must be above 0.", index=k)


def sharpness(powers: Array) -> None:
    """Raise ParameterError unless all powers lie between 1 and `SHARPEST`."""
    bad = ~((powers >= 1.0) & (powers <= SHARPEST))
    if np.any(bad):
        k = int(np.argmax(bad))
        raise ParameterError(
            f"power[{k}] = {powers[k]:g}, but must be at least 1, and at most {SHARPEST:g}: a sharper knee looks the "
            f"same and only costs time.",
            index=k,
        )
