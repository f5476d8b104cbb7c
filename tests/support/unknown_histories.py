"""Random histories of many actuators at once, with plays of plain numpy, for the tests to count with."""

import numpy as np


def parts(model):
    """Thresholds, weights, centre, offset and the maps of a model."""
    inner = model.hysteresis if model.family == "modified-pi" else model
    inner = inner.as_play() if hasattr(inner, "as_play") else inner
    return inner, getattr(model, "before_map", None), getattr(model, "after_map", None)


def follow(z, r, value):
    """One step of plays (N, n) with an input (N,) or a number."""
    value = np.asarray(value)[..., None]
    return np.maximum(value - r, np.minimum(value + r, z))


def turning_path(draw, samples, reach):
    """A path of strokes of random length, densely enough sampled that some lie between the turning points."""
    tips = (
        reach * draw.uniform(-1.0, 1.0, samples // 4 + 2) * draw.uniform(0.1, 1.0, samples // 4 + 2)
    )
    return np.interp(np.linspace(0, tips.size - 1, samples), np.arange(tips.size), tips)


def random_states(draw, model, histories, moves=12):
    """States (N, n) after random histories: an arbitrary admissible beginning, then strokes of all sizes."""
    inner, _, _ = parts(model)
    r = inner.thresholds
    start = draw.uniform(-2.0, 2.0, histories) * r[-1]
    steps = np.diff(r, prepend=0.0) * draw.uniform(-1.0, 1.0, (histories, r.size))
    at_the_end = draw.random((histories, 1)) < 0.3  # as far from each other as neighbours can be
    steps = np.where(at_the_end, np.sign(steps) * np.diff(r, prepend=0.0), steps)
    z = start[:, None] + np.cumsum(steps, axis=1)
    size = r[-1] * 10.0 ** draw.uniform(-1.5, 0.5, (moves, histories))
    for scale in size:
        z = follow(z, r, start + scale * draw.uniform(-1.0, 1.0, histories))
    return z


def outputs(model, states, x):
    """Outputs (N, T) from states (N, n) along x (T,)."""
    inner, before, after = parts(model)
    u = (x if before is None else before(x)) - inner.center
    z, y = states, np.empty((states.shape[0], x.size))
    for k, value in enumerate(u):
        z = follow(z, inner.thresholds, value)
        y[:, k] = inner.offset + z @ inner.weights
    return y if after is None else after(y.ravel()).reshape(y.shape)


def contained(model, histories, samples, seed, shrink=1.0):
    """How many of so many random histories stay within the interval at every sample."""
    draw = np.random.default_rng(seed)
    inner, before, _ = parts(model)
    reach = 0.6 * inner.thresholds[-1] if before is None else 1.0
    x = turning_path(draw, samples, reach) + inner.center
    low, high = model.interval(x)
    middle, half = (low + high) / 2, (high - low) / 2 * shrink
    y = outputs(model, random_states(draw, model, histories), x)
    slack = 1e-12 * (1.0 + np.abs(y).max())
    return int(np.sum(np.all(np.abs(y - middle) <= half + slack, axis=1)))
