"""Ridge regression and kernels on features of the input: plays, lags in time, saturated rates, and their products."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.signal import lfilter

from boxes.signals import Half, Predictor, bounded, ridges, worst
from dehyst.arrays import Array

RADII = np.array([0.03, 0.07, 0.13, 0.2, 0.3, 0.42, 0.56, 0.75])
LAGS = 6  # from three samples to a third of the fitted half
RATES = (1.0, 3.0)  # lags behind which a rate is taken [samples]; it saturates at its rms
STRENGTHS = (1e-11, 1e-9, 1e-7, 1e-5, 1e-3, 1e-1)
DEGREES = (1, 2, 3)
LENGTHS = (0.5, 1.5, 5.0)  # of the kernel, times the root of the number of features
RIDGE_ROWS, KERNEL_ROWS = 3000, 800


def features(x: Array, half: Half) -> Array:
    """Plays, lags and rates (T, m) along an input (T,); only the fitted half says how they are scaled."""
    z, plays = np.full(RADII.size, x[0]), np.empty((x.size, RADII.size))
    for k, value in enumerate(x.tolist()):
        z = np.maximum(value - RADII, np.minimum(value + RADII, z))
        plays[k] = z
    times = np.geomspace(3.0, max(half.x.size / 3.0, 6.0), LAGS)
    lags = [lagged(x, time) for time in times]
    rates = [(x - lagged(x, time)) for time in RATES]
    rates = [np.tanh(r / max(float(np.sqrt(np.mean(r[: half.x.size] ** 2))), 1e-12)) for r in rates]
    table = np.column_stack([x, plays, *lags, *rates])
    part = table[: half.x.size]
    return np.asarray((table - part.mean(axis=0)) / np.maximum(part.std(axis=0), 1e-9))


def lagged(x: Array, time: float) -> Array:
    """Lag of first order along an input that was at rest before."""
    keep = np.exp(-1.0 / time)
    return np.asarray(lfilter([1.0 - keep], [1.0, -keep], x, zi=[keep * x[0]])[0])


def products(f: Array, degree: int) -> Array:
    """All products of features up to a degree; of the third those with x in them alone."""
    columns = [*f.T]
    if degree > 1:
        columns += [
            f[:, i] * f[:, j]
            for i, j in itertools.combinations_with_replacement(range(f.shape[1]), 2)
        ]
    if degree > 2:
        columns += [
            f[:, 0] * f[:, i] * f[:, j]
            for i, j in itertools.combinations_with_replacement(range(9), 2)
        ]
    return np.column_stack(columns)


def ridge(half: Half) -> Predictor:
    """Polynomials of the features; degree and ridge are chosen on blocks."""
    f, every = features(half.x, half), half.every(RIDGE_ROWS)

    def answer(end: int, degree: int) -> list[Predictor]:
        """Predictors from features, one a ridge, fitted to the samples before an end."""
        a, y = products(f[:end:every], degree), half.y[:end:every]
        middle, spread, level = a.mean(axis=0), np.maximum(a.std(axis=0), 1e-9), float(y.mean())
        weights = ridges((a - middle) / spread, y - level, STRENGTHS)

        def predictor(w: Array) -> Predictor:
            return lambda g: bounded(level + (products(g, degree) - middle) / spread @ w)

        return [predictor(w) for w in weights]

    return chosen(half, f, every, answer, DEGREES)


def kernel(half: Half) -> Predictor:
    """A Gaussian kernel beside a line; its length and ridge are chosen on blocks."""
    f, every = features(half.x, half), half.every(KERNEL_ROWS)

    def answer(end: int, length: float) -> list[Predictor]:
        """Predictors from features, one a ridge, fitted to the samples before an end."""
        known, y = f[:end:every], half.y[:end:every]
        values, vectors = np.linalg.eigh(alike(known, known, length))
        level = float(y.mean())
        turned = vectors.T @ (y - level)
        weights = [
            vectors @ (turned / (np.maximum(values, 0.0) + strength * values[-1]))
            for strength in STRENGTHS
        ]

        def predictor(w: Array) -> Predictor:
            return lambda g: bounded(level + alike(g, known, length) @ w)

        return [predictor(w) for w in weights]

    return chosen(half, f, every, answer, LENGTHS)


def chosen(
    half: Half,
    f: Array,
    every: int,
    answer: Callable[[int, Any], list[Predictor]],
    settings: tuple[float, ...],
) -> Predictor:
    """Fit with the setting and the ridge that err least in the worse of the blocks."""
    scores = []
    for setting in settings:
        tried = [(answer(begin, setting), slice(begin, end, every)) for begin, end in half.blocks]
        scores.append([
            worst([found[k](f[part]) - half.y[part] for found, part in tried]) for k in range(len(STRENGTHS))
        ])  # fmt: skip
    best, k = np.unravel_index(np.argmin(scores), (len(settings), len(STRENGTHS)))
    fitted = answer(half.x.size, settings[best])[k]
    return lambda x: fitted(features(x, half))


def alike(a: Array, b: Array, length: float) -> Array:
    """Kernel (T, K) of features (T, m) and (K, m)."""
    inner = a @ b.T
    square = np.sum(a**2, axis=1)[:, None] + np.sum(b**2, axis=1) - 2.0 * inner
    return np.asarray(np.exp(-0.5 * square / (length**2 * a.shape[1])) + inner / a.shape[1])
