"""Slow, independent forms of the identification problem: plays sample by sample, qpOASES, 50-digit arithmetic.

Nothing here calls the package's own solver, scaling or core.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import mpmath
import numpy as np


def loops(amplitudes, samples=40, start=0.0):
    """Return a smooth signal from `start` through +a, -a for each amplitude a; turning points are met exactly."""
    turns = [start]
    for a in amplitudes:
        turns += [a, -a]
    rise = 0.5 - 0.5 * np.cos(np.pi * np.arange(1, samples + 1) / samples)
    parts = [p + (q - p) * rise for p, q in itertools.pairwise(turns)]
    return np.concatenate([[start], *parts])


def plays(x, thresholds, z0):
    """Return the outputs of play operators by their definition, (T, n)."""
    r, z = np.asarray(thresholds, dtype=float), np.array(z0, dtype=float)
    out = np.empty((len(x), r.size))
    for k, sample in enumerate(x):
        z = np.maximum(sample - r, np.minimum(sample + r, z))
        out[k] = z
    return out


@dataclass
class Problem:
    """minimise |c + C v - y|^2 subject to v >= lower, in scaled units."""

    columns: np.ndarray
    y: np.ndarray
    lower: np.ndarray
    thresholds: np.ndarray
    input_scale: float
    output_scale: float

    def weights_of(self, thresholds, weights):
        """Return a fitted model's weights, zeros where operators were dropped, in scaled units."""
        full = np.zeros(self.thresholds.size)
        index = np.searchsorted(
            self.thresholds * self.input_scale * (1 + 1e-12) + 1e-300, thresholds
        )
        assert np.allclose(
            self.thresholds[index] * self.input_scale, thresholds, rtol=1e-12, atol=0
        )
        full[index] = weights
        return full * self.input_scale / self.output_scale


def scaled_problem(recordings, n, eps, family="pi", fraction=0.5):
    """State the documented problem for recordings that start from the state zero.

    x and y are scaled to [-1, 1] over the training part, r_i = (i - 1)/n max|x|, the fraction squared
    for the stop form.
    """
    cut = [len(rec) if fraction >= 1 else int(fraction * len(rec)) for rec in recordings]
    x_train = [np.array(rec.input[:k]) for rec, k in zip(recordings, cut, strict=True)]
    y_train = np.concatenate(
        [np.array(rec.output[:k]) for rec, k in zip(recordings, cut, strict=True)]
    )
    every = np.concatenate(x_train)
    a, center = np.ptp(every) / 2, (every.min() + every.max()) / 2
    b, level = np.ptp(y_train) / 2, (y_train.min() + y_train.max()) / 2
    scaled = [(x - center) / a for x in x_train]
    power = 2 if family == "stop" else 1
    thresholds = (np.arange(n) / n) ** power * np.abs(np.concatenate(scaled)).max()
    z = np.vstack([plays(x, thresholds, np.zeros(n)) for x in scaled])
    columns, lower = z, np.zeros(n)
    # The paper's program bounds w_1 itself, the other families the slope in scaled units.
    lower[0] = eps * a / b if family == "pi" else eps
    if family == "pi-cumulative":
        columns, lower = z - np.column_stack([z[:, 1:], np.zeros(len(z))]), np.full(n, eps)
    if family == "stop":
        columns = z[:, :1] - z
        columns[:, 0] = z[:, 0]
    return Problem(columns, (y_train - level) / b, lower, thresholds, a, b)


def offset_of(problem, v):
    """Return the best offset for given weights."""
    return float(np.mean(problem.y - problem.columns @ v))


def kkt_residual(problem, v):
    """Return the largest violation of the optimality conditions, from all rows of the raw problem.

    Gradients relative to |column| |y|, both without their means, which the free offset takes.
    """
    y = problem.y - problem.y.mean()
    centred = problem.columns - problem.columns.mean(axis=0)
    gradient = centred.T @ (centred @ v - y)
    size = np.linalg.norm(centred, axis=0) * np.linalg.norm(y)
    relative = gradient / np.where(size > 0, size, 1.0)
    at_bound = v <= problem.lower
    return float(np.max(np.where(at_bound, np.maximum(-relative, 0.0), np.abs(relative))))


QUIET = {"printLevel": "none", "nWSR": 20000}


def solve_qpoases(problem):
    """Return the weights by qpOASES from casadi, the solver that the 2012 paper used."""
    import casadi

    rows = np.linalg.qr(
        np.column_stack([np.ones(problem.y.size), problem.columns, problem.y]), mode="r"
    )
    matrix, target = rows[:, :-1], rows[:, -1]
    size = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
    matrix = matrix / size
    h = casadi.DM(matrix.T @ matrix)
    solver = casadi.conic(
        "qp", "qpoases", {"h": h.sparsity(), "a": casadi.Sparsity(0, size.size)}, QUIET
    )
    lower = np.concatenate([[-np.inf], problem.lower * size[1:]])
    solution = solver(h=h, g=-matrix.T @ target, lbx=lower, ubx=np.full(size.size, np.inf))
    assert solver.stats()["success"]
    return (np.array(solution["x"]).ravel() / size)[1:]


SCALE = 80  # bits after the point: floats become whole numbers, and sums of products exact


def _whole(values):
    return np.array(
        [int(math.ldexp(float(v), SCALE)) for v in np.ravel(values)], dtype=object
    ).reshape(np.shape(values))


def solve_exactly(problem, support, digits=50):
    """Return the optimum with 50 digits, given which weights are off their bound, or fail.

    The normal equations on the support are solved in high precision and the optimality conditions are checked for
    all operators; since the problem is convex, that proves the optimum wherever the support came from.
    """
    with mpmath.workdps(digits):
        columns, y, lower = _whole(problem.columns), _whole(problem.y), _whole(problem.lower)
        shift = 1 << SCALE
        base = y * shift - columns @ np.where(support, 0, lower)
        chosen = np.column_stack([np.full(y.size, shift, dtype=object), columns[:, support]])
        gram = (chosen.T @ chosen).tolist()
        right = (chosen.T @ base).tolist()
        unit = mpmath.mpf(shift)
        solution = mpmath.cholesky_solve(
            mpmath.matrix([[mpmath.mpf(v) / unit**2 for v in row] for row in gram]),
            mpmath.matrix([mpmath.mpf(v) / unit**3 for v in right]),
        )
        on = [solution[i + 1] for i in range(int(support.sum()))]
        # The residual keeps three times the bits of the data, so that a gradient of zero is seen as one.
        fine = 1 << (2 * SCALE)
        found = np.array([int(mpmath.nint(v * fine)) for v in [solution[0], *on]], dtype=object)
        residual = chosen @ found - base * shift
        gradient = columns.T @ residual
        size = float(abs(gradient).max()) if (abs(gradient) > 0).any() else 1.0
        for j in np.flatnonzero(~support):
            assert gradient[j] >= 0, (
                f"operator {j} should leave its bound: gradient {float(gradient[j]) / size:g}"
            )
        v = np.array(problem.lower)
        v[support] = [float(w) for w in on]
        assert (v >= problem.lower).all(), "a weight of the support lies below its bound"
        return v
