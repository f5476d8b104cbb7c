"""The quadratic programs of identification against qpOASES, 50-digit arithmetic, and known truth."""

import casadi
import numpy as np
import pytest

import dehyst
from dehyst.identification import _data as data
from identification_oracles import (
    QUIET,
    kkt_residual,
    loops,
    offset_of,
    plays,
    scaled_problem,
    solve_exactly,
    solve_qpoases,
)

AMPLITUDES = (2.0, 1.7, 1.1, 1.9, 0.6, 1.4)


def recording(
    truth,
    noise=0.0,
    seed=0,
    amplitudes=(*AMPLITUDES, *AMPLITUDES),
    gain=3.0,
    samples=40,
    shift=(5.0, -7.0),
):
    """Loops of different size through a model of the centred input, shifted so that centring matters."""
    x = loops(amplitudes, samples)
    y = gain * truth.simulate(x) + noise * np.random.default_rng(seed).standard_normal(x.size)
    return dehyst.Recording(input=x + shift[0], output=y + shift[1])


GENTLE = dehyst.PrandtlIshlinskii(np.arange(12) / 6.0, 0.5 * np.exp(-np.arange(12) / 3.0))
LAZY = dehyst.PrandtlIshlinskii(
    [0.0, 0.3, 0.9], [0.0, 1.0, 0.5]
)  # moves only beyond 0.3: w_1 wants to be zero
# Clockwise: a stop of 0.5 and a stop of 1.2 beside a spring.
LEADING = dehyst.StopOperatorModel([0.0, 0.5, 1.2], [0.0, 1.0, 0.4], slope=0.5)


def weights_in_the_problem(fit, problem, family):
    """The fit's weights as the unknowns of the scaled problem."""
    if family == "stop":
        v = problem.weights_of(fit.model.thresholds, fit.model.stop_weights)
        v[0] = fit.model.slope * problem.input_scale / problem.output_scale
        return v
    w = problem.weights_of(fit.model.thresholds, fit.model.weights)
    return np.cumsum(w) if family == "pi-cumulative" else w


CASES = [
    ("pi", GENTLE, False),
    ("pi", LAZY, True),
    ("pi-cumulative", GENTLE, False),
    ("pi-cumulative", LEADING, False),
    ("stop", LEADING, False),
]


@pytest.mark.slow
@pytest.mark.parametrize(("family", "truth", "eps_binds"), CASES)
def test_weights_equal_qpoases_and_50_digits(family, truth, eps_binds):
    rec = recording(truth, noise=0.03)
    fit = dehyst.identify(rec, family, initial_state="zero", eps=0.001)
    problem = scaled_problem([rec], 100, 0.001, family)
    v = weights_in_the_problem(fit, problem, family)
    assert (v[0] <= 0.001 * (1 + 1e-9)) == eps_binds
    snapped = np.where(np.abs(v - problem.lower) < 1e-12, problem.lower, v)
    support = snapped > problem.lower
    assert support.sum() > 4  # the comparison is not empty
    assert support.sum() < 100 or (family, truth) == (
        "pi-cumulative",
        GENTLE,
    )  # there no bound binds: least squares
    assert np.abs(v - solve_qpoases(problem)).max() < 1e-6
    assert np.abs(v - solve_exactly(problem, support)).max() < 1e-9
    assert kkt_residual(problem, snapped) < 1e-12
    assert fit.certificate.kkt_residual < 1e-12


def test_the_high_precision_reference_refuses_a_wrong_support():
    rec = recording(GENTLE, noise=0.03)
    fit = dehyst.identify(rec, "pi", n=20)
    problem = scaled_problem([rec], 20, 0.001)
    support = weights_in_the_problem(fit, problem, "pi") > problem.lower
    solve_exactly(problem, support)
    left_out, taken_in = support.copy(), support.copy()
    left_out[np.flatnonzero(support)[1]] = False
    taken_in[np.flatnonzero(~support)[0]] = True
    for wrong in (left_out, taken_in):
        with pytest.raises(AssertionError):
            solve_exactly(problem, wrong)


def test_kkt_residual_sees_a_weight_that_is_off_by_a_millionth():
    rec = recording(GENTLE, noise=0.03)
    problem = scaled_problem([rec], 100, 0.001)
    v = weights_in_the_problem(dehyst.identify(rec, "pi"), problem, "pi")
    v[0] *= 1 + 1e-6
    assert kkt_residual(problem, v) > 1e-9


def test_the_offset_is_the_best_one():
    rec = recording(GENTLE, noise=0.03)
    fit = dehyst.identify(rec, "pi")
    problem = scaled_problem([rec], 100, 0.001)
    v = weights_in_the_problem(fit, problem, "pi")
    half = int(0.5 * len(rec))
    level = (rec.output[:half].min() + rec.output[:half].max()) / 2
    assert fit.model.offset == pytest.approx(
        level + problem.output_scale * offset_of(problem, v), abs=1e-11
    )
    assert fit.model.center == pytest.approx(5.0, abs=1e-12)


@pytest.mark.parametrize("n", [20, 100, 1000])
def test_exact_data_gives_the_true_weights_back(n):
    grid = np.arange(n) / n * 2.0
    truth = np.zeros(n)
    truth[[0, n // 10, n // 4, n // 2, 4 * n // 5]] = [0.4, 0.2, 0.5, 0.1, 0.7]
    rec = recording(dehyst.PrandtlIshlinskii(grid, truth), samples=60 if n < 1000 else 200)
    fit = dehyst.identify(rec, "pi", n=n)
    found = scaled_problem([rec], n, 0.001).weights_of(fit.model.thresholds, fit.model.weights)
    scale = 2.0 / (np.ptp(rec.output[: len(rec) // 2]) / 2)
    assert np.abs(found - 3.0 * truth * scale).max() < 1e-8
    assert fit.test.rmse_percent < 1e-8
    assert fit.certificate.kkt_residual < 1e-12


@pytest.mark.slow
def test_a_thousand_operators_are_still_solved_to_the_optimum():
    rec = recording(GENTLE, noise=0.03, samples=90)
    fit = dehyst.identify(rec, "pi", n=1000)
    problem = scaled_problem([rec], 1000, 0.001)
    v = weights_in_the_problem(fit, problem, "pi")
    support = v > problem.lower
    assert np.abs(v - solve_exactly(problem, support)).max() < 1e-6
    assert kkt_residual(problem, v) < 1e-12
    # Truth: the loading curve, which every resolution shares.
    radius = np.linspace(0.1, 1.9, 19)
    assert np.abs(fit.model.loading_curve(radius) - 3.0 * GENTLE.loading_curve(radius)).max() < 0.03


def test_noise_moves_the_weights_by_no_more_than_statistics_allow():
    truth = dehyst.PrandtlIshlinskii([0.0, 0.3, 0.8, 1.3], [0.5, 0.4, 0.3, 0.6])
    sigma = 0.05
    rec = recording(truth, noise=sigma, gain=1.0)
    fit = dehyst.identify(rec, "pi", thresholds=truth.thresholds, train_fraction=1)
    design = np.column_stack(
        [np.ones(len(rec)), plays(rec.input - 5.0, truth.thresholds, np.zeros(4))]
    )
    covariance = sigma**2 * np.linalg.inv(design.T @ design)[1:, 1:]
    error = fit.model.weights - truth.weights
    assert (np.abs(error) > 0).all()
    distance = error @ np.linalg.solve(covariance, error)  # chi squared, 4 degrees of freedom
    assert 0.1 < distance < 18.5
    assert fit.train.rmse == pytest.approx(sigma, rel=0.1)


def test_given_thresholds_equal_to_the_grid_give_the_same_model():
    rec = recording(GENTLE, noise=0.03)
    free = dehyst.identify(rec, "pi", n=50)
    given = dehyst.identify(rec, "pi", thresholds=np.arange(50) / 50 * 2.0)
    assert np.allclose(free.model.thresholds, given.model.thresholds, rtol=1e-12)
    assert np.allclose(free.model.weights, given.model.weights, rtol=0, atol=1e-9)
    assert given.settings["thresholds"] == "given"
    assert free.settings["thresholds"] == "grid"


def test_given_thresholds_are_those_of_the_model_in_units_of_the_input():
    truth = dehyst.PrandtlIshlinskii([0.0, 0.21, 0.77], [1.0, 0.5, 0.25])
    fit = dehyst.identify(recording(truth), "pi", thresholds=[0.0, 0.21, 0.5, 0.77])
    found = dict(zip(fit.model.thresholds.round(12), fit.model.weights, strict=True))
    assert set(found) >= {0.0, 0.21, 0.77}
    assert [found[r] for r in (0.0, 0.21, 0.77)] == pytest.approx([3.0, 1.5, 0.75], abs=1e-9)
    assert found.get(0.5, 0.0) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
def test_several_recordings_are_one_stacked_problem():
    first = recording(GENTLE, noise=0.03)
    second = recording(GENTLE, noise=0.03, seed=1, amplitudes=(1.0, 2.4, 0.7, 1.9))
    fit = dehyst.identify([first, second], "pi", train_fraction=1)
    problem = scaled_problem([first, second], 100, 0.001, fraction=1)
    v = weights_in_the_problem(fit, problem, "pi")
    assert kkt_residual(problem, v) < 1e-12
    assert np.abs(v - solve_qpoases(problem)).max() < 1e-6
    assert len(fit.predictions) == 2
    for rec, predicted in zip((first, second), fit.predictions, strict=True):
        assert np.array_equal(fit.model.simulate(rec.input), predicted)


def test_reduction_by_blocks_equals_one_reduction(monkeypatch):
    rec = recording(GENTLE, noise=0.03)
    results = []
    for chunk in (10**6, 37):
        monkeypatch.setattr(data, "CHUNK", chunk)
        results.append([dehyst.identify(rec, family) for family in ("pi", "modified-pi")])
    for whole, blocks in zip(*results, strict=True):
        assert whole.train.rmse == pytest.approx(blocks.train.rmse, rel=1e-11)
        assert np.abs(whole.predictions[0] - blocks.predictions[0]).max() < 1e-9
        assert np.allclose(whole.static.curve.v, blocks.static.curve.v, rtol=0, atol=1e-10)
    assert np.allclose(results[0][0].model.weights, results[1][0].model.weights, rtol=0, atol=1e-10)


def test_dropping_zero_weights_is_exact():
    rec = recording(GENTLE, noise=0.03)
    fit = dehyst.identify(rec, "pi")
    assert fit.certificate.nonzero_weights == fit.model.weights.size < 100
    problem = scaled_problem([rec], 100, 0.001)
    grid = problem.thresholds * problem.input_scale
    full = np.zeros(100)
    keep = np.searchsorted(grid * (1 + 1e-12), fit.model.thresholds)
    full[keep] = fit.model.weights
    grid[keep] = fit.model.thresholds
    complete = dehyst.PrandtlIshlinskii(grid, full, fit.model.offset, center=fit.model.center)
    assert complete.nonzero_weights == fit.model.weights.size
    assert np.array_equal(complete.pruned().simulate(rec.input), fit.predictions[0])
    assert np.abs(complete.simulate(rec.input) - fit.predictions[0]).max() < 1e-13 * np.ptp(
        rec.output
    )


# The output map of the modified model.


def bent(u):
    """A curve that saturates: slope 1 in the middle, 0.3 at the ends."""
    return np.interp(u, [-6.0, -1.0, 1.0, 6.0], [-2.5, -1.0, 1.0, 2.5])


def saturating(noise=0.0):
    x = loops((*AMPLITUDES, *AMPLITUDES), 40)
    hysteresis = dehyst.PrandtlIshlinskii([0.0, 0.3, 0.8], [0.8, 0.4, 0.3])
    noise = noise * np.random.default_rng(3).standard_normal(x.size)
    return hysteresis, dehyst.Recording(input=x, output=bent(hysteresis.simulate(x)) + noise)


def test_the_output_map_of_a_saturating_loop_is_recovered():
    hysteresis, rec = saturating(noise=0.005)
    fit = dehyst.identify(rec, "modified-pi", initial_state="zero")
    assert fit.test.rmse_percent < 0.6
    assert dehyst.identify(rec, "pi").test.rmse_percent > 3 * fit.test.rmse_percent
    # The map up to the scale that operator and map share: compare the way from operator output to y.
    x = rec.input
    u_true, u_found = hysteresis.simulate(x), fit.model.hysteresis.simulate(x)
    line = np.polyfit(u_found, u_true, 1)
    levels = np.linspace(0.95 * u_found.min(), 0.95 * u_found.max(), 50)
    assert np.abs(fit.model.after_map(levels) - bent(np.polyval(line, levels))).max() < 0.05


def test_the_output_map_rises_and_keeps_its_bound():
    _, rec = saturating(noise=0.005)
    for family_fit in (
        dehyst.identify(rec, "modified-pi"),
        dehyst.identify(rec, "modified-pi", eps=0.1),
    ):
        slopes = family_fit.model.after_map.slopes
        assert (slopes > 0).all()
        assert slopes.max() <= 1 / 0.05 * (1 + 1e-9)  # slopes of the inverse map are at least 0.05
        assert family_fit.model.hysteresis.partial_sums.min() > 0


def test_a_hard_stop_is_held_at_the_bound_of_the_map():
    x = loops(AMPLITUDES, 40)
    y = np.clip(dehyst.PrandtlIshlinskii([0.0, 0.4], [0.7, 0.3]).simulate(x), -0.8, 0.8)
    fit = dehyst.identify(dehyst.Recording(input=x, output=y), "modified-pi", train_fraction=1)
    assert (np.diff(fit.model.after_map.v) > 0).all()
    assert np.isfinite(fit.certificate.inverse_gain)
    assert fit.certificate.round_trip_error < 1e-12


def modified_objective(fit, rec, half):
    """The documented objective and its QP for casadi: (value at the fit, matrix, target, lower, width row)."""
    smoothing, ridge = fit.settings["smoothing"], fit.settings["ridge"]
    x, y = rec.input[:half], rec.output[:half]
    a, b = np.ptp(x) / 2, np.ptp(y) / 2
    xs, ys = (x - (x.min() + x.max()) / 2) / a, (y - (y.min() + y.max()) / 2) / b
    n = 100
    thresholds = np.arange(n) / n * np.abs(xs).max()
    knots = np.linspace(-1, 1, 21)
    ramp = np.clip(ys[:, None] - knots[:-1], 0, np.diff(knots))
    root = np.sqrt(half)
    rows = [np.column_stack([np.ones(half), plays(xs, thresholds, np.zeros(n)), -ramp])]
    smooth = np.zeros((19, 121))
    for j in range(19):
        smooth[j, 101 + j], smooth[j, 102 + j] = -smoothing * root, smoothing * root
    rows += [smooth, np.column_stack([np.zeros(n), ridge * root * np.eye(n), np.zeros((n, 20))])]
    widths = np.concatenate([np.zeros(101), np.diff(knots)])
    w = np.zeros(n)
    w[np.searchsorted(thresholds * a * (1 + 1e-12), fit.model.hysteresis.thresholds)] = (
        fit.model.hysteresis.weights
    )
    slopes = 1 / fit.model.after_map.slopes[1:-1]
    c = (fit.model.hysteresis.offset - b * knots[0]) / b
    unknowns = np.concatenate([[c], w * a / b, slopes])
    lower = np.concatenate([[-np.inf, 0.001], np.zeros(n - 1), np.full(20, 0.05)])
    return np.vstack(rows), unknowns, lower, widths


def test_the_modified_model_is_the_optimum_of_its_documented_objective():
    _, rec = saturating(noise=0.005)
    fit = dehyst.identify(rec, "modified-pi", initial_state="zero")
    matrix, found, lower, widths = modified_objective(fit, rec, len(rec) // 2)
    assert widths @ found == pytest.approx(2.0, abs=1e-4)  # mean slope 1
    assert (found >= lower - 1e-9).all()
    h = casadi.DM(matrix.T @ matrix)
    solver = casadi.conic(
        "qp", "qpoases", {"h": h.sparsity(), "a": casadi.Sparsity.dense(1, 121)}, QUIET
    )
    # The same mean slope as the fit, which meets it softly: then both solve one problem.
    mean = float(widths @ found)
    best = solver(
        h=h,
        g=np.zeros(121),
        a=widths[None, :],
        lba=mean,
        uba=mean,
        lbx=lower,
        ubx=np.full(121, np.inf),
    )
    reference = float(np.sum((matrix @ np.array(best["x"]).ravel()) ** 2))
    value = float(np.sum((matrix @ found) ** 2))
    assert value == pytest.approx(reference, rel=1e-7)
    assert np.abs(found - np.array(best["x"]).ravel()).max() < 1e-5
