"""The best curve without hysteresis: the baseline for every model, and the result if none is better."""

from __future__ import annotations

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array, rank
from dehyst.data import kit as data_kit
from dehyst.identification._data import DataSet, chunks
from dehyst.identification._families import STATIC, Estimate
from dehyst.identification._short_signal import ShortSignal, shorten
from dehyst.models import MonotoneMap, StaticCurve

PIECES = 60
UNIFORM = np.linspace(-1.0, 1.0, PIECES + 1)
SMALLEST_SLOPE = 1e-3
SMOOTHINGS = (0.001, 0.003, 0.01, 0.03)
MOST_POINTS = 4000  # of the signal that places the breakpoints
CLOSEST = 1e-12
FEWEST_ROWS = 40  # of a choice
# A curve remembers nothing: one play of radius 0.
NO_MEMORY = np.zeros(1)


def fit_static(
    data: DataSet,
    initial_state: str,
    smallest: float = SMALLEST_SLOPE,
    smoothing: float | None = None,
) -> tuple[Estimate, float]:
    """Fit a rising piecewise linear curve y = v(x) by least squares, and return its RMSE with it, scaled.

    minimise |c + sum_j m_j ramp_j(t(x)) - y|^2 + smoothing |m_{j+1} - m_j|^2,  slope of v >= smallest, over [-1, 1]
    scaled. t(x) brings the breakpoints of the curve to equal distances (`_breakpoints`). The smoothing is by default
    the one with the least error on folds left out.
    """
    if smoothing is None:
        smoothing = best_smoothing(data, initial_state)
    breakpoints = _breakpoints(*_fitted_points(data, initial_state))
    return _solved(*_sums(data, initial_state, breakpoints), breakpoints, smallest, smoothing)


def curve_of(estimate: Estimate, data: DataSet) -> StaticCurve:
    """Return the fitted curve in units of the log."""
    assert estimate.breakpoints is not None
    x = data.center + data.half_range * estimate.breakpoints
    y = data.level + data.trend * data.amplitude * _values(estimate)
    return StaticCurve(MonotoneMap(x, y))


def best_curve(data: DataSet, initial_state: str = "zero") -> StaticCurve:
    """Return the curve without hysteresis that every model is compared with, in units of the log."""
    return curve_of(fit_static(data, initial_state)[0], data)


def best_smoothing(data: DataSet, initial_state: str) -> float:
    """Return the smoothing of `SMOOTHINGS` with the least error on folds left out; the second for too few samples."""
    short = shorten(data, initial_state, MOST_POINTS)
    if short.rows < FEWEST_ROWS:
        return SMOOTHINGS[1]
    return _by_smoothing(short)[0]


def held_out_errors(short: ShortSignal) -> Array:
    """RMSE on the rows of every fold of the curve that is fitted to the others, scaled, (10,).

    The breakpoints stand where those of the curve of all rows stand, and the smoothing is the best one.
    """
    return _by_smoothing(short)[1]


def _by_smoothing(short: ShortSignal) -> tuple[float, Array]:
    """The smoothing with the least error on folds left out, and its error on each of them."""
    x = np.concatenate([piece.x[piece.place] for piece in short.pieces])
    y, weight = short.y, short.weight
    breakpoints = _breakpoints(x, y, weight)
    whole, square = _moments(x, y, weight, breakpoints)
    parts = []
    for rows in short.folds:
        parts.append(_moments(x[rows], y[rows], weight[rows], breakpoints))
    best, least, least_score = SMOOTHINGS[0], np.zeros(0), np.inf
    # From the smoothest on, so that a rougher curve has to err less.
    for smoothing in sorted(SMOOTHINGS, reverse=True):
        errors = []
        for rows, (bins, squares) in zip(short.folds, parts, strict=True):
            if not rows.size:
                errors.append(np.nan)
                continue
            fitted, target = whole - bins, max(square - squares, 0.0)
            estimate, _ = _solved(fitted, target, breakpoints, SMALLEST_SLOPE, smoothing)
            miss = np.interp(x[rows], breakpoints, _values(estimate)) - y[rows]
            errors.append(np.sqrt(np.average(miss**2, weights=weight[rows])))
        score = rank(data_kit.score_of(np.array(errors)))
        if score < least_score:
            best, least, least_score = smoothing, np.array(errors), score
    return best, least


def _breakpoints(x: Array, y: Array, weight: Array) -> Array:
    """Place the breakpoints of a rising curve, (p + 1,), from -1 to 1, where it is steep or has many samples.

    They are at equal distances of (x + v + k) / 3: the input, the rising curve v of least squares through all samples
    (isotonic regression), and the weight k of the samples below, each over its range. So no piece holds more than 3 / p
    of any of them. Equal distances of x alone make a steep curve look like a loop.
    """
    order = np.argsort(x, kind="stable")[:: max(1, x.size // MOST_POINTS)]
    u, place = np.unique(x[order], return_inverse=True)
    if u.size < 2:
        return UNIFORM
    count: Array = np.bincount(place, weights=weight[order]).astype(np.float64)
    mean = np.bincount(place, weights=weight[order] * y[order]) / count
    t = _share(u) + _share(rising(mean, count)) + _share(np.cumsum(count))
    breakpoints = np.interp(UNIFORM, 2.0 * _share(t) - 1.0, u)
    breakpoints[0], breakpoints[-1] = -1.0, 1.0
    # Two samples that differ in their last digits only leave no room for breakpoints between them.
    return breakpoints if np.all(np.diff(breakpoints) > CLOSEST) else UNIFORM


def _share(values: Array) -> Array:
    """Values from 0 to 1; all 0 if they do not rise."""
    height = values[-1] - values[0]
    return (values - values[0]) / height if height > 0.0 else np.zeros(values.size)


def rising(y: Array, weight: Array) -> Array:
    """Return the values that never fall and are closest to y in the squares: isotonic regression, (k,).

    Neighbours that fall are replaced by their mean, until none falls (pool adjacent violators; Ayer and others 1955).

    Examples
    --------
    >>> rising(np.array([1.0, 3.0, 2.0, 4.0]), np.ones(4)).tolist()
    [1.0, 2.5, 2.5, 4.0]
    """
    means: list[float] = []
    weights: list[float] = []
    sizes: list[int] = []
    for value, w in zip(y.tolist(), weight.tolist(), strict=True):
        size = 1
        while means and means[-1] >= value:
            total = weights[-1] + w
            value = (weights.pop() * means.pop() + w * value) / total
            w = total
            size += sizes.pop()
        means.append(value)
        weights.append(w)
        sizes.append(size)
    return np.repeat(means, sizes)


def _fitted_points(data: DataSet, initial_state: str) -> tuple[Array, Array, Array]:
    """Input, output and weight of about `MOST_POINTS` of the samples that are fitted, from all pieces alike."""
    spans = [piece.fitted(initial_state) for piece in data.pieces]
    samples = sum(span.stop - span.start for span in spans)
    every = max(1, samples // MOST_POINTS)
    parts = []
    for piece, span in zip(data.pieces, spans, strict=True):
        part = slice(span.start, span.stop, every)
        x, y = piece.x[part], piece.y[part]
        weight = np.ones(x.size) if piece.weight is None else piece.weight[part]
        counts = weight > 0.0
        parts.append((x[counts], y[counts], weight[counts]))
    x, y, weight = map(np.concatenate, zip(*parts, strict=True))
    return x, y, weight


def _of_block(weight: Array | None, block: slice) -> Array | None:
    if weight is None:
        return None
    return weight[block]


def _values(estimate: Estimate) -> Array:
    """Of the curve at its breakpoints, scaled."""
    rises: Array = np.concatenate([[0.0], np.cumsum(estimate.parameters[1:] * np.diff(UNIFORM))])
    return estimate.offset + rises


def _solved(
    moments: Array, square: float, breakpoints: Array, smallest: float, smoothing: float
) -> tuple[Estimate, float]:
    gram, rhs = _from_bins(moments)
    # The unknowns are slopes over t; dx / dt makes slopes over t of slopes over x.
    wider = np.diff(breakpoints) / np.diff(UNIFORM)
    # Slopes over x differ by nothing along a line, and by much where the curve is steep, where t counts them less.
    over_x = np.diag(1.0 / wider)
    difference = np.minimum(wider[:-1], wider[1:])[:, None] * np.diff(over_x, axis=0)
    extra = np.zeros_like(gram)
    extra[1:, 1:] = smoothing**2 * gram[0, 0] * (difference.T @ difference)
    lower = np.concatenate([[0.0], smallest * wider])
    u, passive, kkt, condition, *_ = _native.solve_bounded(
        gram, rhs, lower, 1, 0, _native.SLOPES, extra, np.zeros(1 + PIECES), None, np.sqrt(square)
    )
    left = max(float(square - 2.0 * (rhs @ u) + u @ gram @ u), 0.0)
    estimate = Estimate(
        STATIC,
        u,
        float(u[0]),
        np.ones(1),
        u[1:] / wider,
        None,
        None,
        kkt,
        condition=condition,
        passive=passive,
        breakpoints=breakpoints,
    )
    return estimate, float(np.sqrt(left / gram[0, 0]))


def _sums(data: DataSet, initial_state: str, breakpoints: Array) -> tuple[Array, float]:
    moments, square = np.zeros((PIECES, 5)), 0.0
    for piece in data.pieces:
        for part in chunks(piece.fitted(initial_state)):
            weight = _of_block(piece.weight, part)
            bins, squares = _moments(piece.x[part], piece.y[part], weight, breakpoints)
            moments += bins
            square += squares
    return moments, square


def _moments(x: Array, y: Array, weight: Array | None, breakpoints: Array) -> tuple[Array, float]:
    """Sums over the bins between the breakpoints, and that of y^2.

    Within a bin between two breakpoints all ramps below are full, all above zero, and one is s = t - its lower end: the
    sums of 1, s, s^2, y and s y over each bin are enough.
    """
    t = np.interp(x, breakpoints, UNIFORM)
    bins = _native.bin_sums(t, y, weight, PIECES, -1.0, 1.0)
    weighted = y
    if weight is not None:
        weighted = weight * y
    return bins, float(y @ weighted)


def _from_bins(moments: Array) -> tuple[Array, Array]:
    """Gram matrix of [1 | ramps] and its right-hand side from the sums over bins, t in units of a bin."""
    count, t, tt, y, ty = moments.T
    width = 2.0 / PIECES
    # Samples beyond each bin: its ramp is full there.
    above = np.concatenate([np.cumsum(count[::-1])[::-1][1:], [0.0]])
    full = np.concatenate([np.cumsum(y[::-1])[::-1][1:], [0.0]])
    total = width * (t + above)  # sum of each ramp
    gram = np.zeros((1 + PIECES, 1 + PIECES))
    gram[0, 0] = count.sum()
    gram[0, 1:] = gram[1:, 0] = total
    # For j < k: ramp j is full where ramp k is not zero.
    later = np.triu(np.ones((PIECES, PIECES)), 1) * (width * total)
    gram[1:, 1:] = later + later.T + np.diag(width**2 * (tt + above))
    return gram, np.concatenate([[y.sum()], width * (ty + full)])
