"""Slow, independent oracles: exact rational arithmetic, formulas as printed, nothing shared with the core."""

from __future__ import annotations

from fractions import Fraction as F

import mpmath
import numpy as np


def exact(values):
    """Return the rational numbers that floats are."""
    return [F(float(v)) for v in values]


def exact_play(x, radius, z0):
    """Return one play operator's outputs by its definition, case by case, as rationals."""
    z, out = F(float(z0)), []
    for sample in exact(x):
        if sample - z > radius:
            z = sample - radius
        elif z - sample > radius:
            z = sample + radius
        out.append(z)
    return out


def exact_pi(x, thresholds, weights, state, offset=0, center=0):
    """Return sum of weighted plays of x - center, plus offset, as rationals."""
    shifted = [s - F(float(center)) for s in exact(x)]
    total = [F(float(offset))] * len(shifted)
    for r, w, z0 in zip(exact(thresholds), exact(weights), exact(state), strict=True):
        z = z0
        for k, sample in enumerate(shifted):
            z = max(sample - r, min(sample + r, z))
            total[k] += w * z
    return total


def exact_inverse(thresholds, weights, state, sign=1):
    """Return r', w', z' by Kuhnen's sums as printed in 2003, as rationals; sign = -1 mirrors the thresholds."""
    r, w, z = exact(thresholds), exact(weights), exact(state)
    n = len(r)
    s = [sum(w[: i + 1]) for i in range(n)]
    ri = [sign * sum(w[j] * (r[i] - r[j]) for j in range(i + 1)) for i in range(n)]
    wi = [1 / w[0]] + [-w[i] / (s[i] * s[i - 1]) for i in range(1, n)]
    zi = [sum(w[: i + 1]) * z[i] + sum(w[j] * z[j] for j in range(i + 1, n)) for i in range(n)]
    return ri, wi, zi


def input_by_bisection(y, thresholds, weights, state, low, high, digits=40):
    """Return the input whose output is y, sample by sample, by bisection: no inverse formula is used.

    For operators that rise with the input; every sample is searched between low and high.
    """
    with mpmath.workdps(digits):
        r, w = [mpmath.mpf(float(v)) for v in thresholds], [mpmath.mpf(float(v)) for v in weights]
        z = [mpmath.mpf(float(v)) for v in state]
        found = []
        for target in y:
            target = target if isinstance(target, mpmath.mpf) else mpmath.mpf(float(target))
            a, b = mpmath.mpf(low), mpmath.mpf(high)
            for _ in range(int(digits * 3.4)):
                x = (a + b) / 2
                value = sum(
                    wi * max(x - ri, min(x + ri, zi)) for ri, wi, zi in zip(r, w, z, strict=True)
                )
                a, b = (x, b) if value < target else (a, x)
            z = [max(x - ri, min(x + ri, zi)) for ri, zi in zip(r, z, strict=True)]
            found.append(float(x))
        return np.array(found)


def dead_zone_map(u, slopes, breaks, anchor, value):
    """Return Kuhnen's superposition of one-sided dead zones: S_r(x) = max(x-r, 0), x, min(x-r, 0) for r >, =, < 0.

    `slopes` are those of the segments between -inf, breaks..., +inf; the map passes through (anchor, value), and
    anchor lies inside the segment that carries the weight w_0.
    """
    home = sum(1 for b in breaks if b <= anchor)
    x = F(float(u)) - anchor
    total = value + slopes[home] * x
    for i in range(home, len(breaks)):  # outward to the right: each weight is the change of slope
        total += (slopes[i + 1] - slopes[i]) * max(x - (breaks[i] - anchor), F(0))
    for i in range(home - 1, -1, -1):  # and to the left
        total += (slopes[i] - slopes[i + 1]) * min(x - (breaks[i] - anchor), F(0))
    return total


def main_extremes(x):
    """Return the samples that a history leaves in memory: each older swing is wider than all that follow."""
    kept: list[float] = []
    for sample in x:
        kept.append(sample)
        while len(kept) >= 3:
            a, b, c = kept[-3:]
            if b in (a, c) or (a < b) == (b < c):  # no turn at b
                del kept[-2]
            elif len(kept) >= 4 and min(kept[-4], c) <= min(a, b) and max(a, b) <= max(kept[-4], c):
                del kept[-3:-1]  # the swing a-b lies inside the swings around it: wiped out
            else:
                break
    return kept


# Material for the tests: models and histories of every kind that the closed inverse covers.


def random_walk(rng, samples, amplitude=1.0, swing=10):
    """Return a signal that turns at random levels, a few samples a swing."""
    turns = rng.uniform(-amplitude, amplitude, samples // swing + 2)
    return np.interp(np.arange(samples) / swing, np.arange(turns.size), turns)


def random_thresholds(rng, n, span=1.0):
    """Return 0 = r_1 < ... < r_n < span, sometimes evenly spaced, sometimes crowded."""
    if n == 1:
        return np.zeros(1)
    gaps = np.ones(n) if rng.random() < 0.3 else rng.uniform(0.05, 1.0, n)
    return span * np.concatenate([[0.0], np.cumsum(gaps)[:-1]]) / gaps.sum()


def random_weights(rng, n, kind):
    """Return weights with slopes S of order one: "positive", "negative", "paper" (w_1 = 0.001, most are 0), "mixed"."""
    if kind == "paper":
        w = rng.exponential(1.0, n) * (rng.random(n) < 0.14)
        w[0] = 0.0
        return np.concatenate([[1e-3], w[1:] / max(w.sum(), 1e-9) if w.any() else w[1:]])
    if kind == "mixed":  # all partial sums positive, weights of both signs
        return np.diff(rng.uniform(0.2, 2.0, n), prepend=0.0)
    w = rng.uniform(0.02, 1.0, n) * 2.0 / n
    return -w if kind == "negative" else w
