"""A polynomial of past inputs and past own outputs (NARX), fitted one step ahead, scored in free run."""

from __future__ import annotations

import itertools

import numpy as np

from boxes.signals import BOUND, Half, Predictor, ridges, worst
from dehyst.arrays import Array

KEPT = (1200, 400, 150)  # samples of the fitted half; the output between them is interpolated
LAGS = (1, 2, 3)
DEGREES = (1, 2, 3)
STRENGTHS = (1e-10, 1e-6, 1e-3)


class Narx:
    """One choice of thinning, lags and degree."""

    def __init__(self, half: Half, kept: int, lags: int, degree: int):
        self.every, self.lags = half.every(kept), lags
        self.x, self.y = half.x[:: self.every], half.y[:: self.every]
        variables = range(2 * lags + 2)  # the sign of the motion is the last
        self.powers = [
            list(c)
            for d in range(1, degree + 1)
            for c in itertools.combinations_with_replacement(variables, d)
        ]
        width = max(map(len, self.powers))
        one = 2 * lags + 2
        self.index = np.array([p + [one] * (width - len(p)) for p in self.powers])

    def fitted(self, end: int) -> list[Array]:
        """Weights, one set a ridge, of one step ahead over the samples before an end."""
        n, x, y = self.lags, self.x[:end], self.y[:end]
        past = [x[n - k : x.size - k] for k in range(n + 1)] + [
            y[n - k : y.size - k] for k in range(1, n + 1)
        ]
        v = np.column_stack([*past, np.sign(x[n:] - x[n - 1 : -1]), np.ones(x.size - n)])
        a = np.column_stack([np.ones(v.shape[0]), v[:, self.index].prod(axis=2)])
        return ridges(a, y[n:], STRENGTHS)

    def free(self, x: Array, begin: int, weight: Array) -> Array:
        """Own outputs from a sample on; those before it are the measured ones."""
        n, slope = self.lags, weight[1:]
        y = np.concatenate([self.y[:begin], np.zeros(x.size - begin)])
        v = np.ones(2 * n + 3)
        for k in range(begin, x.size):
            v[: n + 1] = x[k - n : k + 1][::-1]
            v[n + 1 : 2 * n + 1] = y[k - n : k][::-1]
            v[2 * n + 1] = np.sign(x[k] - x[k - 1])
            y[k] = min(max(weight[0] + float(v[self.index].prod(axis=1) @ slope), -BOUND), BOUND)
        return y


def narx(half: Half) -> Predictor:
    """Thinning, lags, degree and ridge are chosen by free runs, through blocks and through the whole half."""
    best: tuple[float, Narx, Array] | None = None
    for kept, lags, degree in itertools.product(KEPT, LAGS, DEGREES):
        one = Narx(half, kept, lags, degree)
        parts = [(begin // one.every, end // one.every) for begin, end in half.blocks]
        fits = [*(one.fitted(begin) for begin, _ in parts), one.fitted(one.x.size)]
        parts.append((lags, one.x.size))
        for k in range(len(STRENGTHS)):
            errors = [
                one.free(one.x[:end], begin, weights[k])[begin:] - one.y[begin:end]
                for weights, (begin, end) in zip(fits, parts, strict=True)
            ]
            score = worst(errors)
            if best is None or score < best[0]:
                best = score, one, fits[-1][k]
    assert best is not None
    _, one, weight = best

    def predicted(x: Array) -> Array:
        f = one.free(x[:: one.every], one.x.size, weight)
        return np.interp(np.arange(x.size), np.arange(x.size)[:: one.every], f)

    return predicted
