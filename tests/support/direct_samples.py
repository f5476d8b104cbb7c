"""Motions and logs made by known direct inverses, written out sample by sample, for tests of their identification."""

from __future__ import annotations

import itertools

import numpy as np

import dehyst

TIPS = (
    1.0,
    -1.0,
    0.75,
    -0.5,
    0.35,
    -0.65,
    0.5,
    -0.15,
    -1.0,
    1.0,
    -0.75,
    0.5,
    -0.35,
    0.65,
    -0.5,
    0.15,
)


def motion(tips=TIPS, stroke=2.0, hold=0.0, step=0.02, reach=10.0):
    """Smooth strokes between tips, each followed by a hold: time and output."""
    points, parts = (0.0, *tips, 0.0), [np.zeros(1)]
    for k, (a, b) in enumerate(itertools.pairwise(points)):
        seconds = stroke[k % len(stroke)] if isinstance(stroke, tuple) else stroke
        share = np.arange(1, round(seconds / step) + 1) / round(seconds / step)
        parts += [a + (b - a) * (3.0 - 2.0 * share) * share**2, np.full(round(hold / step), b)]
    y = reach * np.concatenate(parts)
    return step * np.arange(y.size), y


def asked(t, y, rate, *, stops=(), paths=(), creep=(), viscous=0.0, curve=(0.0, 1.0), share=None):
    """u of a direct inverse at rest, by its definition: one loop over the samples.

    Terms are pairs (scale, weight); `share` multiplies everything but the curve.
    """
    play, path, lag = [y[0]] * len(stops), [0.0] * len(paths), [y[0]] * len(creep)
    u = np.empty(y.size)
    for k, value in enumerate(y):
        way, passed = (value - y[k - 1], t[k] - t[k - 1]) if k else (0.0, 0.0)
        rest = viscous * rate[k]
        for i, (radius, weight) in enumerate(stops):
            play[i] = max(value - radius, min(value + radius, play[i]))
            rest += weight * (value - play[i])
        for i, (length, weight) in enumerate(paths):
            fade = np.exp(-abs(way) / length)
            path[i] = np.sign(way) * length * (1.0 - fade) + path[i] * fade
            rest += weight * path[i]
        for i, (tau, weight) in enumerate(creep):
            lag[i] += (1.0 - np.exp(-passed / tau)) * (value - lag[i])
            rest += weight * (value - lag[i])
        u[k] = sum(c * value**j for j, c in enumerate(curve)) + rest * (
            1.0 if share is None else share[k]
        )
    return u


def log(t, y, u, **names):
    """Recording of an actuator: input u, output y."""
    return dehyst.Recording(
        input=u, output=y, time=t, **({"input_unit": "bar", "output_unit": "deg"} | names)
    )
