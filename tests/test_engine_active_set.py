"""The engine's bounded least squares: what an independent solver finds on the rows, from the normal equations alone."""

import numpy as np
import pytest
from scipy.optimize import nnls

from dehyst import _native

BASES = {"slopes": _native.SLOPES, "weights": _native.WEIGHTS, "stops": _native.STOPS}


def play_outputs(x, thresholds):
    """Return all plays' outputs (T, n) by the definition."""
    z, out = np.zeros(thresholds.size), np.empty((x.size, thresholds.size))
    for k, sample in enumerate(x):
        z = np.maximum(sample - thresholds, np.minimum(sample + thresholds, z))
        out[k] = z
    return out


def cells_of(plays):
    """Return z_i - z_{i+1}, the last z as it is."""
    return plays - np.hstack([plays[:, 1:], np.zeros((len(plays), 1))])


def steps(n, basis):
    """Return T (n, n) of v = T u, entry by entry as engine.h defines it."""
    t = np.zeros((n, n))
    for i in range(n):
        for j in range(n):
            if basis == "slopes":
                t[i, j] = i == j
            elif basis == "weights":
                t[i, j] = j <= i
            else:
                t[i, j] = j == 0 or j > i
    return t


def modulated_sine(samples, noise, rng):
    t = np.arange(samples) / samples
    x = np.sin(2 * np.pi * 9 * t) * (0.15 + 0.85 * np.abs(np.sin(2 * np.pi * 0.7 * t)))
    return x + noise * rng.uniform(-1, 1, samples)


@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("n", [1, 2, 7, 40, 100])
def test_the_weights_are_those_of_nnls_on_the_rows(basis, n):
    rng = np.random.default_rng(n)
    x = modulated_sine(1500, 0.01, rng)
    plays = play_outputs(x, np.arange(n) / n)
    y = 0.3 + plays @ (rng.exponential(1.0, n) * (rng.random(n) < 0.4)) + 1e-3 * rng.normal(size=x.size)
    columns = np.hstack([np.ones((x.size, 1)), cells_of(plays)])
    lower = np.concatenate([[0.0], np.full(n, 0.01) * (rng.random(n) < 0.3)])
    u, passive, kkt, condition, _, status = _native.solve_bounded(
        columns.T @ columns, columns.T @ y, lower, 1, n, BASES[basis], target_norm=float(np.linalg.norm(y))
    )
    rows = columns[:, 1:] @ steps(n, basis)
    inner, target = rows - rows.mean(0), y - y.mean()
    length = np.linalg.norm(inner, axis=0)
    expected = lower[1:] + nnls(inner / length, target - inner @ lower[1:], maxiter=100 * n)[0] / length
    assert status == 0 and kkt < 1e-13 and condition >= 1.0
    np.testing.assert_allclose(u[1:], expected, rtol=0, atol=1e-9 * max(1.0, np.abs(expected).max()))
    assert u[0] == pytest.approx(np.mean(y - rows @ u[1:]), abs=1e-9)
    assert passive[0] and np.array_equal(passive[1:], u[1:] > lower[1:])
    assert np.array_equal(u[1:][~passive[1:]], lower[1:][~passive[1:]])  # exactly at the bound
