"""The streaming normal equations are those of the cells written out, whatever the signal, the state and the pieces."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import _native

UNIT = np.finfo(float).eps


def play_outputs(x, r, z):
    """Return outputs (T, n) of play operators and their last states, by the definition."""
    out = np.empty((len(x), len(r)))
    for k, sample in enumerate(x):
        z = np.maximum(sample - r, np.minimum(sample + r, z))
        out[k] = z
    return out, z


def written_out(x, targets, r, z, weights=None):
    """Return sums of products of [1 | cells | targets] in extended precision, and the last states."""
    outputs, last = play_outputs(x, r, z)
    plays = outputs.astype(np.longdouble)
    cells = plays - np.column_stack([plays[:, 1:], np.zeros(len(x))])
    columns = np.column_stack([np.ones(len(x)), cells, targets.T])
    return (columns.T * (1 if weights is None else weights)) @ columns, last


def in_plays(sums, n):
    """Return the sums with z_i = cell_i + ... + cell_n in place of the cells."""
    sums = sums.astype(np.longdouble)
    plays = np.eye(len(sums), dtype=np.longdouble)
    plays[1 : n + 1, 1 : n + 1] = np.triu(np.ones((n, n)))
    return plays @ sums @ plays.T


def error(found, exact, n):
    """Return max|G - G_ref| / max|G_ref| of the cells, or of the plays if it is larger."""
    of_cells = np.abs(found - exact).max() / np.abs(exact).max()
    a, b = in_plays(found, n), in_plays(exact, n)
    return float(max(of_cells, np.abs(a - b).max() / np.abs(b).max()))


def thresholds(rng, n):
    """Return 0 = r_1 < ... < r_n: evenly spaced, uneven, or on integers."""
    return [np.arange(n) / n, np.r_[0, np.cumsum(rng.uniform(0.02, 1, n))[:-1]], np.arange(n) * 2.0][rng.integers(3)]


def signal(rng, samples, reach):
    """Return a signal of one of the kinds that matter: white, walking, on a grid, smooth, noisy, constant."""
    k = np.arange(samples)
    kind = rng.integers(6)
    smooth = reach * np.sin(k / rng.uniform(2, 40))
    if kind == 0:
        return rng.uniform(-reach, reach, samples)
    if kind == 1:
        return np.cumsum(rng.normal(0, reach / 8, samples))
    if kind == 2:
        return np.round(rng.uniform(-reach, reach, samples))
    if kind == 3:
        return smooth
    if kind == 4:
        return smooth + rng.uniform(-0.05, 0.05, samples) * reach
    return np.full(samples, rng.uniform(-reach, reach))


def start_state(rng, r, reach):
    """Return an admissible state: demagnetised, flat, or left behind by a history."""
    kind = rng.integers(4)
    if kind == 0:
        return np.zeros(len(r))
    if kind == 1:
        return np.full(len(r), rng.uniform(-reach, reach))
    return play_outputs(rng.uniform(-reach, reach, rng.integers(1, 12)), r, np.zeros(len(r)))[1]


def case(seed, n=None, samples=200):
    """Return x, targets, thresholds and a start state drawn from a seed."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 41)) if n is None else n
    r = thresholds(rng, n)
    reach = (r[-1] + 0.3) * rng.uniform(0.3, 2)
    x = signal(rng, int(rng.integers(1, samples)), reach)
    return x, rng.normal(size=(int(rng.integers(0, 4)), len(x))), r, start_state(rng, r, reach)


@pytest.mark.parametrize("n", range(1, 41))
def test_sums_are_those_of_the_cells_written_out(n):
    for seed in range(6):
        x, targets, r, z = case([n, seed], n)
        gram = _native.Gram(r, z, len(targets))
        gram.add(x, targets)
        exact, last = written_out(x, targets, r, z)
        found = gram.take()
        assert np.array_equal(found, found.T)
        assert error(found, exact, n) < 4e-14
        assert np.abs(gram.state - last).max() <= 4 * UNIT * (np.abs(x).max() + r[-1])


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_pieces_weights_and_skipped_samples_add_up(seed):
    x, targets, r, z = case(seed)
    rng = np.random.default_rng([seed, 1])
    weights = rng.choice([0.0, 1.0, 2.5], len(x)) * rng.uniform(0.5, 1, len(x)) if rng.random() < 0.5 else None
    cuts = np.sort(rng.integers(0, len(x) + 1, 4))
    gram = _native.Gram(r, z, len(targets))
    found = np.zeros((1 + len(r) + len(targets),) * 2)
    kept = np.ones(len(x))
    for piece, (a, b) in enumerate(zip(np.r_[0, cuts], np.r_[cuts, len(x)], strict=True)):
        if piece == 2:
            gram.skip(x[a:b])
            kept[a:b] = 0
        else:
            gram.add(x[a:b], targets[:, a:b].copy(), None if weights is None else weights[a:b])
        if rng.random() < 0.5:
            found += gram.take()
    found += gram.take()
    exact, last = written_out(x, targets, r, z, kept if weights is None else kept * weights)
    if kept @ (kept if weights is None else weights) > 0:
        assert error(found, exact, len(r)) < 4e-14
    assert np.abs(gram.state - last).max() <= 4 * UNIT * (np.abs(x).max() + r[-1])


def test_a_take_forgets_the_sums_and_keeps_the_state():
    x, r = np.array([0.0, 3.0, -1.0]), np.arange(4.0)
    gram = _native.Gram(r, np.zeros(4), 0)
    gram.add(x, np.empty((0, 3)))
    gram.take()
    assert not gram.take().any()
    gram.add(x, np.empty((0, 3)))
    exact, _ = written_out(x, np.empty((0, 3)), r, play_outputs(x, r, np.zeros(4))[1])
    assert error(gram.take(), exact, 4) < 1e-15


def test_only_targets_leaves_the_rest_at_zero():
    x, _, r, z = case(3, 12)
    y = np.vstack([x**2, np.cos(x)])
    gram = _native.Gram(r, z, 2)
    gram.only_targets(True)
    gram.add(x, y)
    found, (exact, _) = gram.take(), written_out(x, y, r, z)
    assert not found[:13, 1:13].any()
    assert np.abs(found[13:] - exact[13:]).max() < 1e-13 * np.abs(exact[13:]).max()
    gram.only_targets(False)
    gram.add(x, y)
    assert error(gram.take(), written_out(x, y, r, play_outputs(x, r, z)[1])[0], 12) < 4e-14


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": np.array([0.0, np.nan, 1.0])}, "sample 1 of x is nan"),
        ({"x": np.array([0.0, 0.0, 1e101])}, "sample 2 of x"),
        ({"targets": np.array([[0.0, 0.0, np.inf]])}, "sample 2 of target 0 is inf"),
        ({"weights": np.array([1.0, -1.0, 1.0])}, "sample 1 of the weights is -1"),
        ({"targets": np.zeros((2, 3))}, r"shape \(1, 3\)"),
        ({"weights": np.ones(2)}, "differ in length"),
    ],
)
def test_bad_samples_are_named_and_shapes_checked(change, message):
    gram = _native.Gram(np.arange(3.0), np.zeros(3), 1)
    with pytest.raises(ValueError, match=message):
        gram.add(**({"x": np.zeros(3), "targets": np.zeros((1, 3))} | change))


@pytest.mark.parametrize(
    ("r", "z", "message"),
    [
        ([0.5, 1.0], [0.0, 0.0], "first threshold must be 0"),
        ([0.0, 1.0, 1.0], [0.0] * 3, "increase strictly"),
        ([0.0, 1.0], [0.0, 2.0], "not admissible"),
        ([0.0, np.nan], [0.0, 0.0], "not finite"),
        ([], [], "operators"),
        ([0.0, 1.0], [0.0], "differ in length"),
    ],
)
def test_operators_that_cannot_be_are_refused(r, z, message):
    with pytest.raises(ValueError, match=message):
        _native.Gram(np.array(r, dtype=float), np.array(z, dtype=float), 1)
