"""The engine's bounded least squares: what independent solvers find on the rows, from the normal equations alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
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


def steps(free, n, rest, basis):
    """Return T of v = T u, entry by entry as engine.h defines it."""
    t, (i, j) = np.eye(free + n + rest), np.indices((n, n))
    t[free : free + n, free : free + n] = {
        "slopes": i == j,
        "weights": j <= i,
        "stops": (j == 0) | (j > i),
    }[basis]
    return t


def modulated_sine(samples, noise, rng):
    t = np.arange(samples) / samples
    x = np.sin(2 * np.pi * 9 * t) * (0.15 + 0.85 * np.abs(np.sin(2 * np.pi * 0.7 * t)))
    return x + noise * rng.uniform(-1, 1, samples)


def bounded_by_rows(rows, y, lower, free):
    """Return the minimiser of |rows u - y| with u >= lower but for the free ones, by QR and scipy's NNLS."""
    r = np.linalg.qr(np.column_stack([rows, y]), mode="r")
    n = rows.shape[1]
    inner, target = r[free:, free:n], r[free:, n]
    length = np.linalg.norm(inner, axis=0)
    length[length == 0] = 1.0
    w = (
        lower[free:]
        + nnls(inner / length, target - inner @ lower[free:], maxiter=100 * n)[0] / length
    )
    return np.concatenate([np.linalg.solve(r[:free, :free], r[:free, n] - r[:free, free:n] @ w), w])


def solve(columns, y, lower, free, plays, basis, **options):
    options.setdefault("target_norm", float(np.linalg.norm(y)))
    return _native.solve_bounded(
        columns.T @ columns, columns.T @ y, lower, free, plays, BASES[basis], **options
    )


def example(n, seed, basis="weights", noise=1e-3, share=0.4, samples=1500, rough=0.01):
    """Return [1 | cells], an output and the u >= 0 behind it."""
    rng = np.random.default_rng(seed)
    plays = play_outputs(modulated_sine(samples, rough, rng), np.arange(n) / n)
    columns = np.column_stack([np.ones(samples), cells_of(plays)])
    u = rng.exponential(1.0, n + 1) * (rng.random(n + 1) < share)
    u[:2] = 0.3, 0.5
    return columns, columns @ (steps(1, n, 0, basis) @ u) + noise * rng.normal(size=samples), u


@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("n", [1, 2, 7, 40, 100])
def test_the_weights_are_those_of_nnls_on_the_rows(basis, n):
    columns, y, _ = example(n, n, basis)
    rng = np.random.default_rng(n)
    lower = np.concatenate([[0.0], np.full(n, 0.01) * (rng.random(n) < 0.3)])
    u, passive, kkt, condition, _, status = solve(columns, y, lower, 1, n, basis)
    expected = bounded_by_rows(columns @ steps(1, n, 0, basis), y, lower, 1)
    assert status == 0 and kkt < 1e-13 and condition >= 1.0
    np.testing.assert_allclose(u, expected, rtol=0, atol=1e-9 * max(1.0, np.abs(expected).max()))
    assert passive[0] and np.array_equal(passive[1:], u[1:] > lower[1:])
    assert np.array_equal(u[1:][~passive[1:]], lower[1:][~passive[1:]])  # exactly at the bound


@pytest.mark.parametrize("basis", BASES)
def test_a_ridge_is_rows_more_in_the_unknowns(basis):
    n, ridge = 60, 1e-3
    columns, y, _ = example(n, 5, basis)
    lower = np.zeros(n + 1)
    wanted = np.linspace(0, 0.1, n + 1)  # 1/2 ridge |u - wanted|^2
    square = ridge * len(y) * np.eye(n + 1)
    u, _, kkt, _, _, status = solve(
        columns, y, lower, 1, n, basis, extra=square, extra_rhs=square @ wanted
    )
    rows = np.vstack([columns @ steps(1, n, 0, basis), np.sqrt(square)])
    expected = bounded_by_rows(rows, np.concatenate([y, np.sqrt(square) @ wanted]), lower, 1)
    assert status == 0 and kkt < 1e-12
    np.testing.assert_allclose(u, expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize("n", [20, 50, 100])
@pytest.mark.parametrize("solver", ["qpoases", "daqp"])
def test_other_active_set_solvers_find_the_same_weights_to_1e_8(solver, n):
    columns, y, _ = example(n, 30 + n)
    centred, target = columns[:, 1:] - columns[:, 1:].mean(0), y - y.mean()
    rows = centred @ steps(0, n, 0, "weights")
    length = np.linalg.norm(rows, axis=0)
    h, g = (rows / length).T @ (rows / length), (rows / length).T @ target
    if solver == "daqp":
        daqp = pytest.importorskip("daqp")
        top, none = np.full(n, 1e30), np.zeros(n, dtype=np.int32)
        settings = {"primal_tol": 1e-13, "dual_tol": 1e-13}
        x, *_ = daqp.solve(h, -g, np.zeros((0, n)), top, np.zeros(n), none, **settings)
    else:
        casadi = pytest.importorskip("casadi")
        silent = {"printLevel": "none", "error_on_fail": False, "terminationTolerance": 1e-14}
        program = casadi.conic("qp", "qpoases", {"h": casadi.DM(h).sparsity()}, silent)
        x = np.asarray(program(h=h, g=-g, lbx=0)["x"]).ravel()
    u, *_ = solve(centred, target, np.zeros(n), 0, n, "weights")
    np.testing.assert_allclose(u, x / length, rtol=0, atol=1e-8 * u.max())


def test_a_thousand_operators_have_the_weights_of_nnls_on_the_rows():
    n = 1000
    columns, y, _ = example(n, 8, noise=0.3, samples=3000, rough=0.0)
    lower = np.zeros(n + 1)
    lower[1] = 1e-3
    u, passive, kkt, _, iterations, status = solve(columns, y, lower, 1, n, "weights")
    expected = bounded_by_rows(columns @ steps(1, n, 0, "weights"), y, lower, 1)
    assert status == 0 and kkt < 1e-13 and passive.sum() < iterations < 500
    np.testing.assert_allclose(u, expected, rtol=0, atol=1e-7 * expected.max())


@pytest.mark.parametrize("share", [0.3, 1.0])
@pytest.mark.parametrize("basis", BASES)
def test_data_of_a_model_gives_its_weights_back_from_the_normal_equations_alone(basis, share):
    columns, y, true = example(100, 3, basis, noise=0.0, share=share, rough=0.0)
    u, passive, *_ = solve(columns, y, np.zeros(101), 1, 100, basis)
    np.testing.assert_allclose(u, true, rtol=0, atol=1e-9 * true.max())
    assert np.array_equal(passive, true > 0)  # no weight that is not there


def test_three_hundred_weights_of_a_thousand_come_back_from_the_normal_equations_alone():
    columns, y, true = example(1000, 3, noise=0.0, share=0.3, samples=6000, rough=0.0)
    u, _, kkt, condition, _, status = solve(columns, y, np.zeros(1001), 1, 1000, "weights")
    assert status == 0 and kkt < 1e-13 and condition < 1e4
    np.testing.assert_allclose(u, true, rtol=0, atol=1e-6 * true.max())


@pytest.mark.parametrize("basis", BASES)
def test_a_warm_start_gives_the_same_result_in_fewer_iterations(basis):
    columns, y, _ = example(100, 11, basis)
    cold = solve(columns, y, np.zeros(101), 1, 100, basis)
    same = solve(columns, y, np.zeros(101), 1, 100, basis, passive=cold[1])
    assert same[4] == 0 and np.array_equal(same[1], cold[1])
    np.testing.assert_allclose(same[0], cold[0], rtol=0, atol=1e-12)
    wrong = cold[1] ^ (np.arange(101) % 9 == 3)  # some too many, some missing
    near = solve(columns, y, np.zeros(101), 1, 100, basis, passive=wrong)
    assert near[4] < cold[4] and np.array_equal(near[1], cold[1])
    np.testing.assert_allclose(near[0], cold[0], rtol=0, atol=1e-12)


def violations(gram, rhs, lower, free, u, passive):
    """Return the largest gradient of a passive unknown, or positive one of the others, columns of length one."""
    scale = np.sqrt(np.diag(gram))
    gradient = np.asarray((rhs - gram @ u) / np.where(scale > 0, scale, 1), dtype=float)
    bounded = np.arange(rhs.size) >= free
    assert np.all(u[bounded] >= lower[bounded]) and np.array_equal(u[~passive], lower[~passive])
    return max(np.abs(gradient[passive]).max(initial=0), gradient[~passive].max(initial=0))


@given(
    st.integers(0, 2**32 - 1),
    st.integers(0, 3),
    st.integers(0, 12),
    st.integers(0, 4),
    st.sampled_from(sorted(BASES)),
)
def test_every_solution_is_proved_by_its_gradient(seed, free, plays, rest, basis):
    rng, n = np.random.default_rng(seed), free + plays + rest
    if n == 0:
        return
    rows = n + int(rng.integers(1, 20))
    columns = (
        rng.integers(-3, 4, (rows, n)).astype(float)
        if rng.random() < 0.5
        else rng.normal(size=(rows, n))
    )
    columns[:, :free] = rng.normal(size=(rows, free))  # the free ones independent
    for j in range(free, n):
        if rng.random() < 0.1:  # zero, twice the same, opposite
            columns[:, j] = [0.0, 1.0, -1.0][rng.integers(3)] * columns[:, rng.integers(free, n)]
    y = rng.normal(size=rows) * 10.0 ** rng.integers(-3, 4)
    lower = np.where(rng.random(n) < 0.5, 0.0, rng.normal(size=n))
    half = rng.normal(size=(int(rng.integers(0, 4)), n))  # rows more, in the unknowns
    wanted = rng.normal(size=len(half))
    extra, extra_rhs = half.T @ half, half.T @ wanted
    start = rng.random(n) < 0.5 if rng.random() < 0.5 else None
    norm = float(np.hypot(np.linalg.norm(y), np.linalg.norm(wanted))) * (rng.random() < 0.5)
    options = {"extra": extra, "extra_rhs": extra_rhs, "passive": start, "target_norm": norm}
    u, passive, kkt, _, _, status = solve(columns, y, lower, free, plays, basis, **options)
    seen = columns.astype(np.longdouble) @ steps(free, plays, rest, basis)
    gram, rhs = seen.T @ seen + extra, seen.T @ y + extra_rhs
    size = (
        np.linalg.norm(y)
        + np.linalg.norm(wanted)
        + np.linalg.norm(np.asarray(seen, dtype=float), axis=0) @ np.abs(u)
    )
    assert status == 0 and kkt < 1e-9
    assert violations(gram, rhs, lower, free, u, passive) <= 1e-12 * size


@given(st.integers(0, 2**32 - 1), st.integers(1, 15), st.sampled_from(sorted(BASES)))
def test_random_plays_are_proved_by_their_gradient(seed, n, basis):
    rng = np.random.default_rng(seed)
    x = np.repeat(rng.uniform(-1, 1, 40), 3) * rng.choice(
        [1.0, 0.3]
    )  # some thresholds are never reached
    thresholds = np.sort(rng.uniform(0, 0.8, n)) * (np.arange(n) > 0)
    columns = np.column_stack([np.ones(x.size), cells_of(play_outputs(x, thresholds))])
    y = rng.normal(size=x.size) + x
    lower = np.zeros(n + 1)
    u, passive, _, _, _, status = solve(columns, y, lower, 1, n, basis)
    seen = columns.astype(np.longdouble) @ steps(1, n, 0, basis)
    assert status == 0
    assert violations(seen.T @ seen, seen.T @ y, lower, 1, u, passive) <= 1e-12 * np.linalg.norm(y)


def test_every_instruction_set_finds_the_same_weights():
    columns, y, _ = example(100, 12)
    used, found = _native.engine_level(), []
    try:
        for level in range(_native.engine_best_level() + 1):
            _native.engine_use_level(level)
            found.append(solve(columns, y, np.zeros(101), 1, 100, "weights"))
    finally:
        _native.engine_use_level(used)
    for other in found[1:]:
        assert np.array_equal(other[1], found[0][1])
        np.testing.assert_allclose(other[0], found[0][0], rtol=0, atol=1e-10)


# ---- Degenerate programs


def test_of_two_equal_columns_one_carries_the_weight():
    rng = np.random.default_rng(0)
    a = rng.normal(size=(30, 3))
    columns = a[:, [0, 1, 1, 2, 2]]
    y = a @ [1.0, 2.0, 3.0]
    u, passive, kkt, _, _, status = solve(columns, y, np.zeros(5), 0, 5, "slopes")
    assert status == 0 and kkt < 1e-13 and passive.sum() == 3
    np.testing.assert_allclose([u[0], u[1] + u[2], u[3] + u[4]], [1.0, 2.0, 3.0], rtol=1e-12)


def test_a_column_of_zeros_stays_at_its_bound():
    columns = np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 0.0]])
    u, passive, *_, status = solve(columns, np.ones(3), np.array([0.0, 0.25]), 0, 2, "slopes")
    assert (
        u.tolist() == pytest.approx([1.0, 0.25])
        and passive.tolist() == [True, False]
        and status == 0
    )


def test_a_column_that_the_free_ones_explain_stays_at_its_bound():
    rng = np.random.default_rng(1)
    free = rng.normal(size=(40, 2))
    columns = np.column_stack([free, free @ [0.3, 0.7], rng.normal(size=40)])
    u, passive, _, _, _, status = solve(
        columns, rng.normal(size=40) + columns[:, 3], np.zeros(4), 2, 2, "slopes"
    )
    assert status == 0 and u[2] == 0.0 and not passive[2] and u[3] > 0.0


@pytest.mark.parametrize("target", ["negative", "zero"])
@pytest.mark.parametrize("basis", BASES)
def test_all_unknowns_may_be_at_their_bounds(target, basis):
    columns, y, _ = example(30, 2)
    lower = np.zeros(31)
    rows = columns @ steps(1, 30, 0, basis)
    y = (
        0.0 * y
        if target == "zero"
        else np.linalg.lstsq(rows.T, -np.linalg.norm(rows, axis=0), rcond=None)[0]
    )
    u, passive, kkt, _, iterations, status = solve(columns, y, lower, 1, 30, basis)
    assert (
        status == 0
        and not u[1:].any()
        and not passive[1:].any()
        and iterations == 0
        and kkt < 1e-13
    )
    assert u[0] == pytest.approx(y.mean(), rel=1e-9)


def test_free_columns_that_are_alike_ask_for_orthogonal_factors():
    columns = np.ones((5, 3))
    _, _, kkt, condition, _, status = solve(columns, np.ones(5), np.zeros(3), 2, 1, "slopes")
    assert status == 2 and np.isinf(kkt) and np.isinf(condition)


def test_columns_too_alike_for_normal_equations_show_in_the_condition():
    rng = np.random.default_rng(4)
    a, e = rng.normal(size=(2, 200, 1))
    conditions = []
    for distance in (1e-1, 1e-3, 1e-5):
        columns = np.hstack([a, a + distance * e])
        _, _, _, condition, _, status = solve(
            columns, columns @ [1.0, 1.0], np.zeros(2), 0, 2, "slopes"
        )
        assert status == 0
        conditions.append(condition * distance)
        assert condition == pytest.approx(np.linalg.cond(columns), rel=0.3)
    assert max(conditions) < 2 * min(conditions)


def test_the_proof_has_the_units_of_columns_and_target():
    columns, y, _ = example(20, 6)
    scales = 10.0 ** np.arange(-10, 11)
    gram, rhs = columns.T @ columns, columns.T @ y
    plain = _native.solve_bounded(
        gram, rhs, np.zeros(21), 1, 20, 0, target_norm=float(np.linalg.norm(y))
    )
    scaled = _native.solve_bounded(
        gram * np.outer(scales, scales),
        rhs * scales * 1e6,
        np.zeros(21),
        1,
        20,
        0,
        target_norm=1e6 * np.linalg.norm(y),
    )
    assert np.array_equal(plain[1], scaled[1]) and scaled[2] < 1e-13
    np.testing.assert_allclose(scaled[0] * scales, plain[0] * 1e6, rtol=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gram": np.eye(2)}, "gram must be"),
        ({"lower": np.zeros(2)}, "lower and rhs"),
        ({"free": 4}, "exceed the number"),
        ({"free": -1}, "exceed the number"),
        ({"free": 1, "plays": 3}, "exceed the number"),
        ({"plays": -1}, "exceed the number"),
        ({"basis": 3}, "basis is 0"),
        ({"extra": np.eye(4)}, "extra must be"),
        ({"extra_rhs": np.zeros(4)}, "extra_rhs and rhs"),
        ({"passive": np.zeros(2, dtype=bool)}, "passive and rhs"),
        ({"target_norm": np.nan}, "target_norm must"),
        ({"rhs": np.array([1.0, np.nan, 0.0])}, "finite"),
        ({"lower": np.array([0.0, np.inf, 0.0])}, "finite"),
        ({"gram": np.diag([1.0, np.nan, 1.0])}, "finite"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(change, message):
    arguments = {
        "gram": np.eye(3),
        "rhs": np.ones(3),
        "lower": np.zeros(3),
        "free": 1,
        "plays": 2,
        "basis": 1,
    }
    with pytest.raises(ValueError, match=message):
        _native.solve_bounded(**(arguments | change))


def test_a_gram_matrix_with_holes_is_no_silent_wrong_number():
    gram = np.eye(4)
    gram[1, 2] = gram[2, 1] = np.nan
    *_, kkt, _, _, status = _native.solve_bounded(gram, np.ones(4), np.zeros(4), 1, 3, 0)
    assert status == 2 and not kkt < 1.0
