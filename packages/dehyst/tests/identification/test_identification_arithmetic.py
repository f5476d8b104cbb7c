"""Identification, piece by piece and without a whole run: sums, programs, folds, scores, choices, against oracles."""

import itertools

import numpy as np
import pytest
from scipy.optimize import isotonic_regression, lsq_linear

import dehyst
from dehyst import least_squares
from dehyst.data import _ranges as ranges
from dehyst.data import kit as data_kit
from dehyst.errors import ExcitationError, IdentificationError, ParameterError
from dehyst.identification import _data as prepared
from dehyst.identification import _families as families
from dehyst.identification import _memory as memory
from dehyst.identification import _mending as mending
from dehyst.identification import _regressors as regressors
from dehyst.identification import _scores as scores
from dehyst.identification import _selection as selection
from dehyst.identification import _split as split
from dehyst.identification import mended
from dehyst.identification._data import DataSet, Piece
from dehyst.identification._families import Estimate, fit_family
from dehyst.identification._refine import polish
from dehyst.identification._regressors import NormalEquations, normal_equations, ramp_columns
from dehyst.identification._selection import FOLD_RIDGE, Folds, output_knots
from dehyst.identification._short_signal import shorten
from dehyst.identification._static_curve import (
    PIECES,
    SMOOTHINGS,
    best_curve,
    curve_of,
    fit_static,
    held_out_errors,
    rising,
)
from identification_oracles import loops, plays

RNG = np.random.default_rng(3)
R = np.array([0.0, 0.2, 0.5, 0.8])
W = np.array([0.4, 0.2, 0.3, 0.1])
FEW = families.Regularisation(0.03, 0.05)
MAP = np.linspace(-1.0, 1.0, 6)  # knots of a small output map


def piece_of(sizes, split, known, after_break=False, recording=0, start=0, weighted=False, seed=0):
    rng = np.random.default_rng(seed)
    x = loops(sizes, 12)
    y = plays(x, R, np.zeros(4)) @ W + 0.1 + 0.05 * rng.standard_normal(x.size)
    weight = rng.integers(0, 3, x.size).astype(float) if weighted else None
    return Piece(x, y, recording, start, split, known, after_break, weight)


def data_of(*pieces):
    return DataSet(
        pieces, center=2.0, half_range=3.0, level=-1.0, amplitude=0.5, trend=-1, output_range=4.0
    )


PLAIN = data_of(piece_of((1.0, 0.6, 0.9), 60, 20), piece_of((0.8, 1.0), 40, 15, True, seed=1))
HEAVY = data_of(
    piece_of((1.0, 0.6, 0.9), 60, 20, weighted=True),
    piece_of((0.8, 1.0), 40, 15, True, 1, 0, True, 1),
)


def rows_of(data, start, knots=None):
    """Rows [1 | plays | ramps | y] of the fitted samples by definition, and their weights."""
    rows, counts = [], []
    for piece in data.pieces:
        kind = "unknown" if piece.after_break else start
        z0 = memory.state_before(kind, R, piece.x[0], -1.0, 1.0, -data.center / data.half_range)
        z = plays(piece.x, R, z0)
        begin = piece.known if kind == "unknown" else 0
        ramp = (
            []
            if knots is None
            else [np.clip(piece.y - a, 0.0, b - a) for a, b in itertools.pairwise(knots)]
        )
        table = np.column_stack([np.ones(piece.x.size), z, *ramp, piece.y])
        rows.append(table[begin : piece.split])
        counts.append(
            (np.ones(piece.x.size) if piece.weight is None else piece.weight)[begin : piece.split]
        )
    return np.vstack(rows), np.concatenate(counts)


def in_cells(rows):
    """[1 | plays | ...] to [1 | cells | ...]."""
    made = rows.copy()
    made[:, 1:4] -= rows[:, 2:5]
    return made


# --- sums, programs, both routes ------------------------------------------------------------------------------


@pytest.mark.parametrize("data", [PLAIN, HEAVY])
@pytest.mark.parametrize("start", ["zero", "rest", "origin", "rising", "falling", "unknown"])
@pytest.mark.parametrize("knots", [None, MAP])
def test_sums_and_factors_are_those_of_the_fitted_rows(data, start, knots):
    bank = regressors.make_bank(data, R, start)
    rows, count = rows_of(data, start, knots)
    assert bank.thresholds.size == 4
    sums = normal_equations(data, bank, knots)
    cells = in_cells(rows)
    assert np.allclose(sums.matrix, cells.T @ (count[:, None] * cells), rtol=0, atol=1e-10)
    assert (sums.operators, sums.matrix.shape[0]) == (4, 6 if knots is None else 11)
    assert sums.samples == pytest.approx(count.sum())
    factor = families.reduce(data, bank, knots)
    assert np.allclose(factor.T @ factor, rows.T @ (count[:, None] * rows), rtol=0, atol=1e-10)
    wanted = sum(
        (p.split - (p.known if p.after_break or start == "unknown" else 0))
        if p.weight is None
        else np.count_nonzero(
            p.weight[p.known if p.after_break or start == "unknown" else 0 : p.split]
        )
        for p in data.pieces
    )
    assert regressors.fitted_samples(data, start) == wanted


def test_a_span_of_ones_own_and_pieces_without_rows():
    data = data_of(piece_of((1.0, 0.6), 30, 10), piece_of((1.0, 0.6), 5, 9, True))
    bank = regressors.make_bank(data, R, "zero")
    assert normal_equations(data, bank).samples == 30.0  # the second piece is known after its split
    own = normal_equations(data, bank, span=lambda piece: slice(piece.split, piece.split + 3))
    z = np.vstack(
        [
            plays(p.x, R, s)[p.split : p.split + 3]
            for p, s in zip(data.pieces, bank.states, strict=True)
        ]
    )
    assert np.allclose(own.matrix[0, 4], z[:, 3].sum()) and own.samples == 6.0
    factor = families.reduce(data, bank, span=lambda piece: slice(piece.split, piece.split + 3))
    assert np.allclose((factor.T @ factor)[0, 1:5], z.sum(axis=0))
    coarse = normal_equations(data, bank).coarser(np.array([True, False, True, False]))
    two = Piece(data.pieces[0].x, data.pieces[0].y, 0, 0, 30, 0, False)
    wanted = normal_equations(data_of(two), regressors.make_bank(data_of(two), R[[0, 2]], "zero"))
    assert np.allclose(coarse.matrix, wanted.matrix) and coarse.thresholds.tolist() == [0.0, 0.5]
    with pytest.raises(ParameterError, match="keep the first"):
        wanted.coarser(np.array([False, True]))
    with pytest.raises(ParameterError, match="same thresholds"):
        wanted + normal_equations(data, bank)
    assert np.array_equal((wanted + wanted).matrix, 2.0 * wanted.matrix)
    with pytest.raises(AssertionError):
        normal_equations(data, bank, span=lambda piece: slice(3, 3))


def test_operators_that_stand_still_in_the_fitted_samples_are_left_out():
    x = np.concatenate([[0.4], loops((0.5, 0.5), 10), [2.0]])
    piece = Piece(x, x, 0, 0, x.size - 1, 0, False)
    bank = regressors.make_bank(data_of(piece), np.array([0.0, 0.3, 0.5, 0.6]), "zero")
    assert bank.thresholds.tolist() == [0.0, 0.3] and bank.undetermined.tolist() == [0.5, 0.6]
    assert [s.size for s in bank.states] == [2]
    still = regressors.make_bank(
        data_of(Piece(0.0 * x, x, 0, 0, 5, 0, False)), np.array([0.0, 0.3]), "zero"
    )
    assert still.thresholds.tolist() == [0.0]  # the first stays whatever happens
    step = Piece(
        np.array([0.0, 1.0, 1.0, 1.0]), np.zeros(4), 0, 0, 4, 0, False
    )  # the first sample is one of them
    assert regressors.make_bank(
        data_of(step), np.array([0.0, 0.5]), "zero"
    ).thresholds.tolist() == [0.0, 0.5]
    parts = list(regressors.blocks(x, R, np.zeros(4), slice(7, 30), 9))
    assert [(p.start, p.stop) for p, _ in parts] == [(7, 16), (16, 25), (25, 30)]
    assert np.allclose(np.vstack([z for _, z in parts]), plays(x, R, np.zeros(4))[7:30])
    ramp = ramp_columns(x, MAP)
    assert np.allclose(ramp, [np.clip(x - a, 0.0, b - a) for a, b in itertools.pairwise(MAP)])
    assert np.allclose(ramp.sum(axis=0), np.clip(x, -1, 1) + 1)


def weights_of(family, u):
    if family == "pi-cumulative":
        return np.diff(u, prepend=0.0)
    if family == "stop":
        return np.concatenate([[u[0] + u[1:].sum()], -u[1:]])
    return u


@pytest.mark.parametrize("ridge", [0.0, 0.7])
@pytest.mark.parametrize("family", ["pi", "pi-cumulative", "stop", "modified-pi"])
def test_a_program_is_the_objective_that_is_documented(family, ridge):
    knots = MAP if family == "modified-pi" else None
    rows, _ = rows_of(PLAIN, "zero", knots)
    sums = normal_equations(PLAIN, regressors.make_bank(PLAIN, R, "zero"), knots)
    made = families.program(family, sums, 0.02, knots, FEW, ridge)
    z, y, count = rows[:, 1:5], rows[:, -1], len(rows)
    rng = np.random.default_rng(1)

    def objective(u):
        v = np.concatenate([u[:1], np.cumsum(weights_of(family, u[1:5])), u[5:]])
        value = 0.5 * v @ made.gram @ v - made.rhs @ v
        value += 0.0 if made.extra is None else 0.5 * u @ made.extra @ u
        return value - (0.0 if made.extra_rhs is None else made.extra_rhs @ u)

    def documented(u):
        w, m = weights_of(family, u[1:5]), u[5:]
        if family != "modified-pi":
            return 0.5 * np.sum((u[0] + z @ w - y) ** 2) + 0.5 * ridge * np.sum(w**2)
        inner = np.sum((u[0] + z @ w - rows[:, 5:-1] @ m) ** 2) + ridge * np.sum(w**2)
        scale = 1e3 * (np.diff(knots) @ (m - 1.0))
        smooth = 0.03**2 * np.sum(np.diff(m) ** 2) + 0.05**2 * np.sum(w**2) + scale**2
        return 0.5 * inner + 0.5 * count * smooth

    size = 5 + (5 if knots is not None else 0)
    for _ in range(4):
        u, other = rng.random(size), rng.random(size)
        gap = documented(u) - documented(other)
        assert objective(u) - objective(other) == pytest.approx(gap, rel=1e-9, abs=1e-9 * count)
    lowest = {"pi-cumulative": [0.02] * 4}.get(family, [0.02, 0.0, 0.0, 0.0])
    assert made.lower[1:5].tolist() == lowest
    assert made.lower[5:].tolist() == [0.05] * (size - 5)
    reach = np.linalg.norm(y) if knots is None else 1e3 * np.sqrt(count) * 2.0
    assert made.target == pytest.approx(reach)
    assert (made.extra is None) == (family != "modified-pi" and not ridge)


@pytest.mark.parametrize("ridge", [0.0, 0.7])
@pytest.mark.parametrize("family", ["pi", "pi-cumulative", "stop", "modified-pi"])
def test_both_routes_reach_the_optimum_of_an_independent_solver(family, ridge, monkeypatch):
    knots = MAP if family == "modified-pi" else None
    rows, _ = rows_of(PLAIN, "zero", knots)
    bank = regressors.make_bank(PLAIN, R, "zero")
    sums = normal_equations(PLAIN, bank, knots)
    eps, count = 0.45, len(rows)  # binds for the first weight of "pi"

    basis = np.eye(4)
    basis = np.array([weights_of(family, row) for row in basis]).T  # w = basis u
    columns, target = [np.ones(count), *(rows[:, 1:5] @ basis).T], rows[:, -1]
    lower = np.concatenate([[-np.inf], families.lower_bounds(family, 4, eps)])
    system, right = np.column_stack(columns), target
    if knots is not None:
        system, right = np.column_stack([*columns, -rows[:, 5:-1]]), np.zeros(count)
        extra, more = families.smoothing_rows(FEW, 4, np.diff(knots))
        system, right = (
            np.vstack([system, np.sqrt(count) * extra]),
            np.concatenate([right, np.sqrt(count) * more]),
        )
        lower = np.concatenate([lower, [0.05] * 5])
    tail = np.zeros((4, system.shape[1]))
    tail[:, 1:5] = np.sqrt(ridge) * basis
    best = lsq_linear(
        np.vstack([system, tail]),
        np.concatenate([right, np.zeros(4)]),
        (lower, np.inf),
        method="bvls",
        tol=1e-14,
    ).x
    for limit, route in ((1e6, "normal equations"), (0.0, "orthogonal factors")):
        monkeypatch.setattr(families, "LARGEST_CONDITION", limit)
        found = fit_family(
            family,
            sums,
            eps,
            knots,
            FEW,
            fold_ridge=ridge,
            triangle=lambda: families.reduce(PLAIN, bank, knots),
        )
        assert found.route == route
        assert np.abs(found.parameters - best).max() < 1e-6
        assert np.abs(found.weights - weights_of(family, best[1:5])).max() < 1e-6
        assert found.offset == pytest.approx(best[0], abs=1e-6)
        assert found.kkt_residual < 1e-12
        if family == "stop":
            assert found.stop_slope == pytest.approx(best[1], abs=1e-6)
            assert found.stop_weights.tolist() == pytest.approx([0.0, *best[2:5]], abs=1e-6)
        assert (found.slopes is None) == (knots is None)
    monkeypatch.setattr(families, "LARGEST_CONDITION", 0.0)
    with pytest.raises(IdentificationError, match="--n 2"):
        fit_family(family, sums, eps, knots, FEW)


def test_refinement_brings_back_the_optimum_of_the_modified_model():
    bank = regressors.make_bank(PLAIN, R, "zero")
    sums = normal_equations(PLAIN, bank, MAP)
    found = fit_family("modified-pi", sums, 0.02, MAP, FEW)
    best, _ = families.solve_family(
        "modified-pi", families.reduce(PLAIN, bank, MAP), 4, 0.02, MAP, FEW
    )
    off = np.concatenate([[True], found.passive[1:]])
    shaken = found.parameters + 1e-5 * np.where(
        off, np.random.default_rng(0).standard_normal(off.size), 0.0
    )
    spoiled = families.estimate_of("modified-pi", 4, shaken, 0.0, found.route, 2.0, found.passive)
    back = polish(sums, 0.02, MAP, FEW, spoiled)
    assert np.abs(shaken - found.parameters).max() > 1e-6
    assert np.abs(back.parameters - best).max() < 1e-10
    assert (back.condition, back.route) == (2.0, families.NORMAL)
    by_factors = families.estimate_of(
        "modified-pi", 4, shaken, 0.0, families.ORTHOGONAL, 2.0, found.passive
    )
    assert polish(sums, 0.02, MAP, FEW, by_factors) is by_factors
    bound = fit_family(
        "modified-pi", sums, 0.9, MAP, FEW
    )  # w_1 at its bound: taken as free, it would leave it
    assert not bound.passive[1]
    freed = families.estimate_of(
        "modified-pi", 4, bound.parameters, 0.0, bound.route, 2.0, bound.passive | True
    )
    assert polish(sums, 0.9, MAP, FEW, freed) is freed


def test_matrices_that_are_kept_for_the_next_program_cannot_be_changed():
    for kept in (families.unit_ridge("stop", 3), families._smoothing(FEW, 3, (1.0, 1.0))):
        with pytest.raises(ValueError, match="read-only"):
            kept[0, 0] = 1.0


def test_gains_and_maps_follow_from_their_slopes():
    def made(family, weights, slopes=None, parameters=(0.0,)):
        slopes = None if slopes is None else np.array(slopes)
        return Estimate(
            family, np.array(parameters), 0.0, np.array(weights), slopes, None, None, 0.0
        )

    assert families.gain_of(made("pi", [0.2, -0.1, 0.4])) == pytest.approx(10.0)
    assert families.gain_of(made("static", [1.0], [0.25, 0.5], (0.1, 9.0, 9.0))) == pytest.approx(
        4.0
    )
    assert families.gain_of(made("modified-pi", [0.5], [0.2, 2.0])) == pytest.approx(4.0)
    assert families.gain_of(made("modified-pi", [0.5], [0.2, 0.3])) == pytest.approx(
        1.0
    )  # continued at 0.5
    assert families.gain_of(made("pi", [0.0])) == pytest.approx(1e300)
    assert [families.is_high(g) for g in (19.9, 20.0, 20.0 * (1 + 1e-10), 20.01)] == [
        False,
        False,
        False,
        True,
    ]
    knots, slopes = np.array([-1.0, 0.5, 1.0]), np.array([2.0, 0.1])
    u, y = families.map_points(knots, slopes)
    assert u.tolist() == pytest.approx([-5.0, -1.0, 2.0, 2.05, 3.05]) and y.tolist() == [
        -3.0,
        -1.0,
        0.5,
        1.0,
        3.0,
    ]
    assert families.map_points(knots, slopes[::-1])[0].tolist() == pytest.approx(
        [-2.0, -1.0, -0.85, 0.15, 4.15]
    )
    asked = np.array([-7.0, -5.0, -3.0, -1.0, 0.5, 2.025, 4.05])
    wanted = [-4.0, -3.0, -2.0, -1.0, -0.25, 0.75, 5.0]
    assert families.continued(asked, u, y).tolist() == pytest.approx(wanted)
    assert families.mapped(
        made("modified-pi", [1.0], slopes), asked + 1.0, knots
    ).tolist() == pytest.approx(wanted)
    assert families.mapped(made("pi", [1.0]), asked, knots) is asked


# --- least squares with bounds --------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_bounded_least_squares_agree_with_another_solver(seed):
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((30, 9))
    rows[:, 5] *= 1e3
    lower = rng.standard_normal(6) * 0.3 / np.linalg.norm(rows[:, 2:8], axis=0)
    found = least_squares.solve_bounded(rows, 2, lower)
    best = lsq_linear(
        rows[:, :-1], rows[:, -1], (np.concatenate([[-np.inf] * 2, lower]), np.inf), method="bvls"
    )
    assert np.concatenate([found.free, found.bounded]) == pytest.approx(best.x, rel=1e-9, abs=1e-12)
    assert found.kkt_residual < 1e-14
    on = found.bounded > lower
    assert 0 < on.sum() < 6
    alone = least_squares.solve_bounded(rows, 0, np.full(8, -1e3))
    assert alone.free.size == 0
    assert alone.bounded == pytest.approx(
        np.linalg.lstsq(rows[:, :-1], rows[:, -1], rcond=None)[0], abs=1e-10
    )
    few = least_squares.solve_bounded(rows[:4], 1, np.zeros(7))
    other = lsq_linear(rows[:4, :8], rows[:4, -1], ([-np.inf, *[0.0] * 7], np.inf), method="bvls")
    left = rows[:4, 0] * few.free[0] + rows[:4, 1:8] @ few.bounded - rows[:4, -1]
    assert left @ left == pytest.approx(2.0 * other.cost, rel=1e-9, abs=1e-20)
    assert few.kkt_residual < 1e-12


def test_the_optimality_conditions_see_both_kinds_of_violation():
    inner, target, lower = np.diag([2.0, 4.0]), np.array([2.0, 4.0]), np.zeros(2)
    size = np.linalg.norm(target)
    check = least_squares._kkt_residual
    assert check(inner, target, np.array([1.0, 1.0]), lower) == 0.0
    assert check(inner, target, np.array([1.5, 1.0]), lower) == pytest.approx(1.0 / size)
    assert check(inner, target, np.array([1.0, 0.0]), lower) == pytest.approx(4.0 / size)
    assert check(inner, -target, np.zeros(2), lower) == 0.0
    assert check(np.zeros((2, 1)), target, np.zeros(1), lower[:1]) == 0.0


def test_constants_that_are_there_twice_share_their_part():
    x = np.linspace(-1.0, 1.0, 20)
    rows = np.column_stack([np.ones(20), np.ones(20), x, 3.0 + 2.0 * x])
    found = least_squares.solve_bounded(rows, 2, np.zeros(1))
    assert found.free.tolist() == pytest.approx([1.5, 1.5], abs=1e-6)
    assert found.bounded.tolist() == pytest.approx([2.0], abs=1e-9)
    nothing = least_squares.solve_bounded(np.column_stack([np.zeros(20), x, x]), 1, np.zeros(1))
    assert nothing.free.tolist() == [0.0] and nothing.bounded.tolist() == pytest.approx([1.0])


def test_a_column_that_the_free_ones_explain_keeps_its_bound():
    x = np.linspace(-1.0, 1.0, 20)
    rows = np.column_stack([np.ones(20), np.full(20, 2.0), x, 3.0 + 2.0 * x])
    found = least_squares.solve_bounded(rows, 1, np.array([0.25, 0.0]))
    assert found.bounded.tolist() == pytest.approx(
        [0.25, 2.0]
    ) and found.free.tolist() == pytest.approx([2.5])


# --- memory ---------------------------------------------------------------------------------------------------


def test_where_memory_is_known_beyond_the_first_thousand_samples():
    x = np.zeros(9000)
    x[[1500, 8000]] = 0.97, -0.96
    assert memory.known_from(x, -1.0, 1.0) == 8000
    x[1024] = 1.0
    assert memory.known_from(x[:5000], -1.0, 1.0) == 5000
    x[1023] = -0.96
    assert memory.known_from(x, -1.0, 1.0) == 1024
    x[0], x[1] = 1.0, -1.0
    assert memory.known_from(x, -1.0, 1.0) == 1
    assert memory.known_from(np.array([0.959, -0.959]), -1.0, 1.0) == 2
    assert memory.known_from(np.array([3.92, 0.08]), 0.0, 4.0) == 1


def test_a_piece_counts_from_its_own_extremes_with_a_level_of_its_own_where_those_of_the_data_come_late(
    monkeypatch,
):
    def found(size, low, high, whole, own):
        visited = {(-1.0, 1.0): whole, (low, high): own}
        with monkeypatch.context() as patch:
            patch.setattr(memory, "known_from", lambda x, a, b: visited[a, b])
            return memory.known_within(np.linspace(low, high, size))

    assert found(20, -0.95, 0.95, 10, 7) == (10, None)  # early enough
    assert found(20, -0.85, 0.94, 14, 7) == (7, (-0.85, 0.94))
    assert found(20, -0.85, 0.94, 14, 8) == (14, None)  # 6 samples won, 6 without a level
    assert found(20, -0.85, 0.94, 15, 8) == (8, (-0.85, 0.94))
    assert found(20, -0.5, -0.31, 20, 7) == (20, None)  # no tenth of the range
    assert found(20, -0.5, -0.29, 20, 7) == (7, (-0.5, -0.29))
    back = np.tile([0.0, 0.94, 0.0, -0.93], 10)
    assert (memory.known_after_break(back), memory.known_after_break(0.5 * back)) == (3, 40)
    assert memory.known_after_break(np.tile([0.0, 0.94, 0.0], 10)) == 30
    assert memory.known_after_break(np.tile([0.0, 1.0, 0.0, -1.0], 10)) == 3
    assert memory.known_after_break(np.tile([0.0, -1.0, 0.0, 1.0], 10)) == 3
    assert memory.largest_radius("rest", 0.5, -1.0, 2.0) == 1.5
    assert memory.largest_radius("rising", 0.5, -3.0, 2.0) == 3.0


def test_a_memory_from_input_zero_lies_where_input_zero_lies():
    assert memory.state_before("origin", R, 0.3, -1.0, 1.0, -0.6).tolist() == [-0.6] * 4
    assert memory.state_before("origin", R, 0.3, -1.0, 1.0).tolist() == [0.0] * 4


# --- folds and curves -----------------------------------------------------------------------------------------


MOST = 10_000


def short_rows_of(data, start, knots=None, most=MOST):
    """Rows as in `rows_of` that take part in a choice, with their weights, and the samples' weights in them."""
    rows, count = rows_of(data, start, knots)
    short = shorten(data, start, most)
    chosen = []
    begin = 0
    for piece, part in zip(data.pieces, short.pieces, strict=True):
        span = piece.fitted(start)
        chosen.append(begin + part.rows - span.start)
        begin += span.stop - span.start
    chosen = np.concatenate(chosen)
    return rows[chosen], short.weight, count[chosen]


def folds_by_walk(weight):
    """Rows of each fold: twenty parts of the summed weight, spread in the order of twenty equal rows, then by fours."""
    order = data_kit.folds_of(np.ones(20))[0]
    folds = [[] for _ in range(10)]
    summed = 0.0
    for row, w in enumerate(weight.tolist()):
        part = int(20.0 * (summed + 0.5 * w) / weight.sum() + 1e-9)
        folds[order[part]].append(row)
        folds[5 + part // 4].append(row)
        summed += w
    return [np.array(rows) for rows in folds]


@pytest.mark.parametrize("data", [PLAIN, HEAVY])
@pytest.mark.parametrize("start", ["zero", "unknown"])
def test_rows_of_a_choice_are_fitted_samples_that_count_spread_by_way(data, start):
    for most in (30, MOST):
        counts = []
        for piece in data.pieces:
            count = np.zeros(piece.x.size, dtype=bool)
            begin = piece.known if start == "unknown" or piece.after_break else 0
            count[begin : piece.split] = True
            counts.append(count if piece.weight is None else count & (piece.weight > 0.0))
        wanted = data_kit.spread_rows([piece.x for piece in data.pieces], counts, most)
        short = shorten(data, start, most)
        for piece, part, rows in zip(data.pieces, short.pieces, wanted, strict=True):
            assert np.array_equal(part.rows, rows.rows)
            samples = 1.0 if piece.weight is None else piece.weight[rows.rows]
            assert part.weight == pytest.approx(samples * rows.weight, rel=1e-14)
            assert np.array_equal(part.x[part.place], piece.x[rows.rows])
            assert np.array_equal(part.y, piece.y[rows.rows])


@pytest.mark.parametrize("data", [PLAIN, HEAVY])
def test_folds_are_twenty_parts_of_the_weight_and_no_row_is_in_two(data):
    short = shorten(data, "zero", MOST)
    folds = short.folds
    for number, (rows, wanted) in enumerate(zip(folds, folds_by_walk(short.weight), strict=True)):
        assert np.array_equal(rows, wanted)
        parts = 1 + np.count_nonzero(np.diff(rows) > 1)
        assert parts == (4 if number < 5 else 1) or rows.size < 8
    for five in (folds[:5], folds[5:]):
        assert np.array_equal(np.sort(np.concatenate(five)), np.arange(short.rows))


@pytest.mark.parametrize("data", [PLAIN, HEAVY])
def test_held_out_errors_are_those_of_fits_to_the_other_folds(data):
    short = shorten(data, "zero", MOST)
    rows, weight, _ = short_rows_of(data, "zero")
    bank = regressors.make_bank(data, R, "zero")
    folds = Folds(short, bank, ramps=False)
    choice = selection.Choice("pi", "zero", None)
    ridge = np.hstack([np.zeros((4, 1)), FOLD_RIDGE * np.sqrt(weight.sum()) * np.eye(4)])

    def fitted(kept):
        root = np.sqrt(weight[kept])[:, None]
        system, right = (
            np.vstack([root * rows[kept, :5], ridge]),
            np.append(root[:, 0] * rows[kept, 5], np.zeros(4)),
        )
        return lsq_linear(
            system, right, ([-np.inf, 0.02, 0, 0, 0], np.inf), method="bvls", tol=1e-14
        ).x

    def rms(u, kept):
        return np.sqrt(np.average((rows[kept, :5] @ u - rows[kept, 5]) ** 2, weights=weight[kept]))

    every = np.arange(len(rows))
    left_out = folds_by_walk(weight)
    wanted = [rms(fitted(np.setdiff1d(every, fold)), fold) for fold in left_out]
    assert len(wanted) == 10
    assert folds.errors(choice, 0.02) == pytest.approx(wanted, rel=1e-9)
    assert folds.errors(choice, 0.02) == pytest.approx(wanted, rel=1e-9)  # warm
    for (_, fold, error), own_rows, own in zip(
        folds.estimates(choice, 0.02), left_out[:5], wanted[:5], strict=True
    ):
        assert np.array_equal(fold, own_rows) and error == pytest.approx(own, rel=1e-9)
    least = rms(fitted(every), every)
    for whole in (folds, Folds(short, bank, ramps=False, whole=True)):
        assert whole.whole(choice, 0.02)[1] == pytest.approx(least, rel=1e-6)


@pytest.mark.parametrize("data", [PLAIN, HEAVY])
def test_a_fit_with_an_output_map_sees_all_rows_of_the_short_signal(data):
    bank = regressors.make_bank(data, R, "zero")
    knots = output_knots()
    rows, weight, _ = short_rows_of(data, "zero", knots)
    cells = in_cells(rows)
    sums = NormalEquations(R, cells.T @ (weight[:, None] * cells))
    wanted = fit_family("modified-pi", sums, 0.02, knots, FEW)
    inner = wanted.offset + rows[:, 1:5] @ wanted.weights
    residual = families.mapped(wanted, inner, knots) - rows[:, -1]
    folds = Folds(shorten(data, "zero", MOST), bank, ramps=True, whole=True)
    _, error = folds.whole(selection.Choice("modified-pi", "zero", FEW), 0.02)
    assert knots.tolist() == pytest.approx(np.linspace(-1.0, 1.0, 21).tolist())
    assert error == pytest.approx(np.sqrt(np.average(residual**2, weights=weight)), rel=1e-6)


def test_folds_take_the_other_route_where_they_must(monkeypatch):
    bank = regressors.make_bank(HEAVY, R, "zero")
    choice = selection.Choice("pi", "zero", None)
    found = []
    for limit in (1e6, 0.0):
        monkeypatch.setattr(families, "LARGEST_CONDITION", limit)
        folds = Folds(shorten(HEAVY, "zero", MOST), bank, ramps=False)
        found.append([*folds.errors(choice, 0.02), folds.whole(choice, 0.02)[1]])
    assert found[0] == pytest.approx(found[1], rel=1e-9)


# --- the curve ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
def test_rising_values_are_the_closest_ones_that_never_fall(seed):
    rng = np.random.default_rng(seed)
    size = int(rng.integers(1, 60))
    y = rng.integers(-3, 4, size).astype(float) if seed % 2 else rng.standard_normal(size)
    weight = rng.uniform(0.1, 3.0, size)
    found = rising(y, weight)
    assert found.shape == y.shape and np.all(np.diff(found) >= 0.0)
    assert np.average(found, weights=weight) == pytest.approx(np.average(y, weights=weight))
    assert found == pytest.approx(isotonic_regression(y, weights=weight).x, abs=1e-12)
    assert np.array_equal(rising(found, weight), found) or rising(found, weight) == pytest.approx(
        found, abs=1e-14
    )
    assert rising(-y[::-1], weight[::-1]) == pytest.approx(-found[::-1], abs=1e-12)


def scattered(size=300, seed=0, weighted=False):
    """Samples in any order, dense at the left and steep at the right."""
    rng = np.random.default_rng(seed)
    x = np.concatenate([[-1.0, 1.0], 2.0 * rng.random(size - 2) ** 3 - 1.0])
    y = np.tanh(30.0 * (x - 0.4)) + 0.05 * rng.standard_normal(size)
    weight = rng.integers(0, 3, size).astype(float) if weighted else None
    return data_of(Piece(x, y, 0, 0, size, 0, False, weight))


def shares(values):
    """From 0 to 1."""
    return (values - values[0]) / max(np.ptp(values), 1e-300)


def breakpoints_by_rows(x, y, weight):
    """Equal steps of input, rising curve through all samples and weight of those below, each over its range, summed.

    Equal steps of the input where samples that are twins but for rounding leave no room.
    """
    places, which = np.unique(x, return_inverse=True)
    at = [np.flatnonzero(which == k) for k in range(places.size)]
    total = np.array([weight[rows].sum() for rows in at])
    mean = np.array([np.average(y[rows], weights=weight[rows]) for rows in at])
    v = isotonic_regression(mean, weights=total).x
    t = shares(places) + shares(v) + shares(np.cumsum(total))
    inside = np.interp(np.linspace(0.0, 1.0, PIECES + 1)[1:-1], shares(t), places)
    breakpoints = np.concatenate([[-1.0], inside, [1.0]])
    if np.min(np.diff(breakpoints)) <= 1e-12:
        return np.linspace(-1.0, 1.0, PIECES + 1)
    return breakpoints


def curve_by_rows(x, y, weight, smallest, breakpoints, smoothing):
    """The curve at its breakpoints and its RMSE from all rows; unknowns are level and slopes."""
    width = np.diff(breakpoints)
    ramp = np.clip(x[:, None] - breakpoints[:-1], 0.0, width)
    # Slopes of neighbours differ as much as the narrower one is wide, in widths of equal pieces.
    narrower = np.minimum(width[:-1], width[1:]) / (2.0 / PIECES)
    differences = narrower[:, None] * np.diff(np.eye(PIECES), axis=0)
    root, total = np.sqrt(weight)[:, None], np.sqrt(weight.sum())
    smooth = np.hstack([np.zeros((PIECES - 1, 1)), smoothing * total * differences])
    system = np.vstack([root * np.column_stack([np.ones(x.size), ramp]), smooth])
    right = np.append(root[:, 0] * y, np.zeros(PIECES - 1))
    lower = np.array([-np.inf, *[smallest] * PIECES])
    # Columns of like size: slopes of narrow pieces in the solver's tolerances as those of wide ones.
    scale = np.concatenate([[1.0], 1.0 / width])
    u = (
        scale
        * lsq_linear(
            system * scale, right, (lower / scale, np.inf), method="bvls", tol=1e-15, max_iter=2000
        ).x
    )
    values = u[0] + np.concatenate([[0.0], np.cumsum(u[1:] * width)])
    miss = np.interp(x, breakpoints, values) - y
    return values, np.sqrt(np.average(miss**2, weights=weight))


@pytest.mark.parametrize("data", [PLAIN, HEAVY, scattered(), scattered(weighted=True)])
@pytest.mark.parametrize("smallest", [1e-3, 0.5])
def test_the_curve_is_the_best_one_by_rows(data, smallest):
    rows, count = rows_of(data, "zero")
    x, y = rows[:, 1], rows[:, 5]
    estimate, error = fit_static(data, "zero", smallest)
    assert estimate.slopes.min() >= smallest * (1.0 - 1e-12)
    assert estimate.weights.tolist() == [1.0]
    smoothing = smoothing_by_rows(*short_rows_of(data, "zero")[:2])[0]
    values, wanted = curve_by_rows(x, y, count, smallest, estimate.breakpoints, smoothing)
    assert error == pytest.approx(wanted, rel=1e-6)
    steps = estimate.slopes * np.diff(estimate.breakpoints)
    found = estimate.offset + np.concatenate([[0.0], np.cumsum(steps)])
    assert found == pytest.approx(values, abs=1e-5)
    at = np.linspace(-1.0, 1.0, 37)
    expected = -1.0 - 0.5 * np.interp(at, estimate.breakpoints, found)
    assert curve_of(estimate, data).simulate(2.0 + 3.0 * at) == pytest.approx(expected, abs=1e-9)
    usual = curve_of(fit_static(data, "zero", 1e-3)[0], data)
    assert np.array_equal(best_curve(data).curve.v, usual.curve.v)


@pytest.mark.parametrize("seed", range(3))
def test_breakpoints_are_at_equal_steps_of_input_curve_and_samples(seed):
    data = scattered(seed=seed)
    breakpoints = fit_static(data, "zero")[0].breakpoints
    assert breakpoints == pytest.approx(
        breakpoints_by_rows(data.pieces[0].x, data.pieces[0].y, np.ones(data.pieces[0].x.size)),
        abs=1e-12,
    )
    assert breakpoints.size == PIECES + 1 == 61
    assert 0.0 < np.min(np.diff(breakpoints)) < 0.01 < 0.05 < np.max(np.diff(breakpoints))


@pytest.mark.parametrize("steep", [1.0, 10.0, 100.0])
def test_no_piece_of_a_curve_holds_more_than_a_twentieth_of_input_output_or_samples(steep):
    """3 / 60 of each, and what lies between two samples."""
    rng = np.random.default_rng(0)
    x = np.concatenate([np.sin(np.arange(3000) / 50.0), 0.7 + 0.01 * rng.standard_normal(900)])
    y = np.tanh(steep * (x - 0.4)) / np.tanh(steep * 1.4)
    data = data_of(Piece(x, y, 0, 0, x.size, 0, False))
    breakpoints = fit_static(data, "zero")[0].breakpoints
    between = np.max(np.diff(np.sort(x)))
    assert np.max(np.diff(breakpoints)) <= 3.0 / PIECES * 2.0 + between
    held = np.histogram(x, breakpoints)[0]
    assert np.max(held) <= 3.0 / PIECES * x.size + 2
    inside = np.clip(breakpoints, x.min(), x.max())
    heights = np.diff(np.tanh(steep * (inside - 0.4)) / np.tanh(steep * 1.4))
    assert np.max(heights) <= 3.0 / PIECES * np.ptp(y) + np.max(np.diff(np.sort(y)))


def test_breakpoints_without_room_between_them_are_equally_spaced():
    twins = np.concatenate([np.linspace(-1.0, 1.0, 50), 0.3 + 1e-15 * np.arange(500)])
    for x in (np.full(20, 0.5), twins):
        data = data_of(Piece(x, 0.5 * x, 0, 0, x.size, 0, False))
        assert np.array_equal(fit_static(data, "zero")[0].breakpoints, np.linspace(-1.0, 1.0, 61))


def smoothing_by_rows(rows, weight):
    """The smoothing whose curves err least on the folds left out, in the mean, and these errors."""
    x, y = rows[:, 1], rows[:, 5]
    breakpoints = breakpoints_by_rows(x, y, weight)
    errors = {}
    for smoothing in sorted(SMOOTHINGS, reverse=True):
        errors[smoothing] = []
        for fold in folds_by_walk(weight):
            other = np.setdiff1d(np.arange(x.size), fold)
            values, _ = curve_by_rows(
                x[other], y[other], weight[other], 1e-3, breakpoints, smoothing
            )
            miss = np.interp(x[fold], breakpoints, values) - y[fold]
            errors[smoothing].append(np.sqrt(np.average(miss**2, weights=weight[fold])))
    best = min(errors, key=lambda smoothing: data_kit.score_of(np.array(errors[smoothing])))
    return best, errors[best]


@pytest.mark.parametrize("data", [PLAIN, HEAVY, scattered(), scattered(weighted=True)])
def test_held_out_errors_of_the_curve_are_those_of_curves_without_the_fold(data):
    rows, weight, _ = short_rows_of(data, "zero")
    found = held_out_errors(shorten(data, "zero", MOST))
    assert found == pytest.approx(smoothing_by_rows(rows, weight)[1], rel=1e-5)


# --- scores ---------------------------------------------------------------------------------------------------


def test_moments_of_chosen_samples_are_those_of_an_array():
    signals, other = (
        (RNG.standard_normal(9), RNG.standard_normal(6)),
        (RNG.standard_normal(9), RNG.standard_normal(6)),
    )
    weight = np.array([0.0, 2.0, 1.0, 0.0, 3.0, 1.0])
    part = scores.Part(((slice(1, 4), slice(6, 8)), (slice(0, 5),)), (None, weight))
    chosen = np.concatenate([signals[0][[1, 2, 3, 6, 7]], signals[1][:5]])
    less = np.concatenate([other[0][[1, 2, 3, 6, 7]], other[1][:5]])
    count = np.concatenate([np.ones(5), weight[:5]])
    for values, found in ((chosen, part.moments(signals, extremes=True)),
                          (chosen - less, part.moments(signals, other, extremes=True))):  # fmt: skip
        assert found.count == 11.0
        assert found.mean == pytest.approx(np.average(values, weights=count))
        assert found.square == pytest.approx(np.average(values**2, weights=count))
        assert found.rms == pytest.approx(np.sqrt(found.square))
        assert found.largest == np.abs(values[count > 0]).max()
    assert part.moments(signals, None, 1).mean == pytest.approx(
        np.average(signals[1][:5], weights=weight[:5])
    )
    assert part.moments(signals, None, 0).largest == 0.0
    assert (
        part.moments([-np.abs(s) for s in signals], extremes=True).largest
        == np.abs(chosen[count > 0]).max()
    )
    assert np.flatnonzero(part.mask(0, 9)).tolist() == [1, 2, 3, 6, 7]
    assert np.flatnonzero(part.mask(1, 6)).tolist() == [1, 2, 4]
    assert (
        part and not scores.Part(((slice(0, 1),),), (weight,)) and not scores.Part(((),), (None,))
    )
    empty = scores.Part(((),), (None,)).moments(signals[:1])
    assert (empty.count, empty.mean, empty.square, empty.largest) == (0.0, 0.0, 0.0, 0.0)


def test_scores_are_their_definitions():
    x = loops((1.0, 0.7), 10)
    records = tuple(dehyst.Recording(input=x + k, output=2.0 * x + k) for k in (0.0, 1.0))
    part = scores.Part(((slice(3, 30),), (slice(0, 10),)), (None, None))
    outputs = [rec.output + 0.1 * RNG.standard_normal(x.size) for rec in records]
    y = np.concatenate([records[0].output[3:30], records[1].output[:10]])
    error = np.concatenate([outputs[0][3:30], outputs[1][:10]]) - y
    found = scores.score(records, outputs, part, 4.0)
    rmse = np.sqrt(np.mean(error**2))
    assert found.rmse == pytest.approx(rmse) and found.rmse_percent == pytest.approx(25.0 * rmse)
    assert found.nrmse == pytest.approx(rmse / np.std(y)) and found.max == pytest.approx(
        np.abs(error).max()
    )
    assert scores.score(records, outputs, scores.Part(((), ()), (None, None)), 4.0) is None
    flat = [scores.score_from(scores.Moments(1.0, 0.0, s, 0.0), 0.0, 1.0).nrmse for s in (1.0, 0.0)]
    assert flat == [np.inf, 0.0]
    demands = [rec.input + 0.5 for rec in records]
    asked = scores.input_error(records, demands, part)
    inputs = np.concatenate([records[0].input[3:30], records[1].input[:10]])
    off = (
        np.minimum(inputs + 0.5, np.max(x + 1.0)) - inputs
    )  # an actuator goes no further than was applied
    span = np.ptp([records[0].input, x + 1])
    assert asked.rms_percent == pytest.approx(100 * np.sqrt(np.mean(off**2)) / span)
    assert asked.bias_percent == pytest.approx(100 * np.mean(off) / span)
    assert asked.without_bias_percent == pytest.approx(100 * np.std(off) / span)
    assert scores.input_error(records, demands, scores.Part(((), ()), (None, None))) is None


def test_a_round_trip_finds_the_larger_miss_of_both_ways():
    model = dehyst.PrandtlIshlinskii([0.0, 0.3], [1.0, 0.5])
    x = loops((1.0, 0.7), 10)
    assert scores.round_trip(model, x) < 1e-14

    class Off:
        """An inverse that is off by 0.1 everywhere."""

        def __init__(self, inner, shift):
            self.inner, self.shift = inner, shift

        def inverse(self):
            return Off(self.inner.inverse(), 0.1)

        def stepper(self, kind):
            return Stepped(self.inner.stepper(kind), self.shift)

    class Stepped:
        def __init__(self, inner, shift):
            self.inner, self.shift = inner, shift

        def simulate(self, values):
            return (self.inner.simulate(values)[0] + self.shift,)

    y = model.simulate(x)
    back = model.inverse().simulate(y) + 0.1
    wanted = max(0.1 / np.ptp(x), np.abs(model.simulate(back) - y).max() / np.ptp(y))
    assert scores.round_trip(Off(model, 0.0), x) == pytest.approx(wanted, rel=1e-9)


def test_parts_and_simulations_follow_the_pieces():
    rng = np.random.default_rng(0)
    x = 2.0 + 3.0 * np.concatenate([loops((1.0, 0.6, 0.9), 12), loops((0.8, 1.0), 12)])
    first, second = piece_of((1.0, 0.6, 0.9), 60, 20), piece_of((0.8, 1.0), 40, 15, True, 0, 73)
    assert first.x.size == 73
    data = data_of(first, second)
    record = dehyst.Recording(input=x, output=rng.standard_normal(x.size), breaks=(73,))
    fitted, held_out = scores.scored_parts((record,), data, "zero")
    assert fitted.spans == ((slice(0, 60), slice(88, 113)),)
    assert held_out.spans == ((slice(60, 73), slice(113, 73 + second.x.size)),)
    assert scores.scored_parts((record,), data, "unknown")[0].spans == (
        (slice(20, 60), slice(88, 113)),
    )
    assert fitted.weights == (None,)
    bank = regressors.make_bank(data, R, "zero")
    model = dehyst.PrandtlIshlinskii(R[[0, 2]] * 3.0, [1.0, 0.5], center=2.0)
    (found,) = scores.simulated((record,), data, bank, model)
    z = [
        plays(3.0 * p.x, R[[0, 2]] * 3.0, s[[0, 2]] * 3.0)
        for p, s in zip(data.pieces, bank.states, strict=True)
    ]
    assert found == pytest.approx(np.vstack(z) @ [1.0, 0.5], abs=1e-12)
    (again,), (demand,) = scores.predictions((record,), data, bank, model)
    assert np.array_equal(again, found)
    assert demand[:73] == pytest.approx(model.with_state(bank.states[0][[0, 2]] * 3.0).inverse().simulate(
        record.output[:73]))  # fmt: skip
    weighted, _ = scores.scored_parts((record, record), HEAVY, "zero")
    assert all(
        np.array_equal(w[: p.x.size], p.weight)
        for w, p in zip(weighted.weights, HEAVY.pieces, strict=True)
    )


# --- data -----------------------------------------------------------------------------------------------------


def recording(**more):
    x = loops((1.0, 0.6, 0.9), 12)
    return dehyst.Recording(
        **({"input": 5.0 + 2.0 * x, "output": 3.0 - 4.0 * (x + 0.1 * x**3)} | more)
    )


def test_data_are_scaled_split_and_cut():
    record = recording(breaks=(30,))
    data = prepared.prepare([record], split.split_recordings([record], 0.5))
    assert [(p.known, p.within) for p in data.pieces] == [
        memory.known_within(p.x) for p in data.pieces
    ]
    assert [p.known for p in data.pieces] == [23, 41]
    half = 36
    low, high = record.output[:half].min(), record.output[:half].max()
    assert (data.center, data.half_range, data.trend) == (5.0, 2.0, -1)
    assert (data.level, data.amplitude) == pytest.approx((0.5 * (low + high), 0.5 * (high - low)))
    assert [(p.start, p.split, p.x.size, p.after_break) for p in data.pieces] == [
        (0, 30, 30, False), (30, 6, 43, True)]  # fmt: skip
    assert data.pieces[1].x == pytest.approx((record.input[30:] - 5.0) / 2.0)
    assert data.pieces[1].y == pytest.approx((record.output[30:] - data.level) / -data.amplitude)
    assert not data.weighted and HEAVY.weighted
    light = prepared.prepare(
        [record], split.split_recordings([record], 0.5), [np.where(np.arange(73) < 20, 0.5, 0.0)]
    )  # a little is not nothing
    assert light.amplitude == pytest.approx(0.5 * np.ptp(record.output[:20]))
    assert (
        prepared.prepare([recording()], split.split_recordings([recording()], 1.0)).pieces[0].split
        == 73
    )
    piece = Piece(np.zeros(10), np.zeros(10), 0, 0, 6, 8, False)
    assert (piece.fitted("zero"), piece.held_out("zero")) == (slice(0, 6), slice(6, 10))
    assert (piece.fitted("unknown"), piece.held_out("unknown")) == (slice(8, 8), slice(8, 10))
    late = Piece(np.zeros(10), np.zeros(10), 0, 0, 6, 12, True)
    assert (late.usable_from("zero"), late.held_out("zero")) == (12, slice(10, 10))


def test_splits_leave_a_sample_on_either_side_and_count_what_counts():
    asked = [(10, 0.5), (10, 0.01), (10, 0.99), (10, 1.0), (1, 0.5), (7, 0.3), (100, 0.999)]
    assert [split.end_of(*a) for a in asked] == [5, 1, 9, 10, 1, 2, 99]
    record = recording(left_out=tuple(range(30)))
    assert split._end_within(record, 0.5) == 30 + 21
    assert split._end_within(record, 1.0) == 73 and split._end_within(recording(), 0.5) == 36
    found = prepared.counting([record, recording()], None)
    assert found[0].tolist() == [0.0] * 30 + [1.0] * 43 and found[1].tolist() == [1.0] * 73
    given = [np.full(73, 2.0), np.ones(73)]
    assert prepared.counting([record, recording()], given)[0].tolist() == [0.0] * 30 + [2.0] * 43
    assert given[0][0] == 2.0 and prepared.counting([recording()], given) is given
    for fraction in (0.0, -0.1, 1.01):
        with pytest.raises(ParameterError, match="train_fraction"):
            split.checked_train_fraction(fraction)
    assert [(s.start, s.stop) for s in prepared.chunks(slice(3, 10), 3)] == [
        (3, 6),
        (6, 9),
        (9, 10),
    ]
    long = np.zeros(70_000)
    long[[5, 69_999]] = -1.0, 2.0
    assert ranges.range_of(long) == (-1.0, 2.0)
    assert ranges.range_over([long, np.zeros(0), np.array([3.0])]) == (-1.0, 3.0)


def test_signals_that_do_not_move_by_numbers_are_refused():
    first = recording()
    assert prepared.middle(first, (1.0, 4.0), "input", " in the first 50 %") == (2.5, 1.5)
    assert prepared.middle(first, (1e12 - 4, 1e12 + 4), "input", " in the first 50 %") == (
        1e12,
        4.0,
    )
    for pair, said in (((2.0, 2.0), "stays at 2 in the first 50 %"), ((1e12, 1e12 + 0.5), "offset of 1e"),
                       ((0.0, 1e-96), "times 1e[+]96"), ((-1e95, 1e95), "times 1e-95")):  # fmt: skip
        with pytest.raises(ExcitationError, match=said):
            prepared.middle(first, pair, "output", " in the first 50 %")
    prepared.require_gain(first, 1.0, 1e95)
    prepared.require_gain(first, 1.0, 1e-95)
    for gain in (1.1e95, 0.9e-95):
        with pytest.raises(ExcitationError, match=r"be near 1e[+]95|be near 9e-96"):
            prepared.require_gain(first, 1.0, gain)


def test_the_trend_is_the_correlation_where_that_is_clear_and_the_increments_elsewhere():
    angle = np.linspace(0.0, 12 * np.pi, 2000, endpoint=False)
    x = np.sin(angle)
    wide = [
        (share * x + np.sqrt(1.0 - share**2) * np.cos(angle), sign)
        for share, sign in ((0.29, 0), (0.31, 1))
    ]
    for y, wanted in ((x, 1), (-x, -1), *wide):
        shifted, raised = x + 7.0, y - 3.0
        sums = [
            x.size,
            shifted.sum(),
            raised.sum(),
            shifted @ shifted,
            raised @ raised,
            shifted @ raised,
        ]
        assert prepared.clear_trend(np.array(sums)) == wanted
    assert (
        prepared.clear_trend(np.array([4.0, 4.0, 2.0, 4.0, 2.0, 2.0])) == 0
    )  # an input that stands still
    rise = np.arange(100.0)
    assert prepared.trend_of_increments(rise, rise, 50.0) == 1
    assert prepared.trend_of_increments(rise, -rise, 50.0) == -1
    falling = dehyst.Recording(
        input=1000.0 + x, output=0.98 * np.cos(angle) - 0.2 * x
    )  # far from zero, and wide
    assert prepared.prepare([falling], split.split_recordings([falling], 1.0)).trend == -1
    for size, stretches in (
        (200_000, [(0, 200_000)]),
        (400_000, [(20_000 * k, 20_000 * k + 2_500) for k in range(20)]),
    ):
        within = np.zeros(size, dtype=bool)
        for begin, end in stretches:
            within[begin:end] = True
        rising = np.tile(np.arange(500.0), size // 500)
        sign = np.where(within, 1.0, -1.0)  # falls wherever it is not looked at
        assert prepared.trend_of_increments(rising, sign * rising, 250.0) == 1
    noisy = rise / 100.0 + 0.009 * (-1.0) ** np.arange(
        100
    )  # noise of less than a step of 2 % decides nothing
    other = rise / 100.0 - 0.09 * (-1.0) ** np.arange(100)
    assert np.sum(np.diff(noisy) * np.diff(other)) < 0.0
    assert prepared.trend_of_increments(noisy, other, 5.0) == 1


# --- choices --------------------------------------------------------------------------------------------------


def test_threshold_grids_are_powers_up_to_the_largest_radius():
    data = data_of(Piece(np.array([0.5, -1.0, 0.8, 3.0]), np.zeros(4), 0, 0, 3, 0, False))
    made = selection.threshold_grid(data, 4, selection.Choice("pi", "zero", None), None)
    assert made.tolist() == pytest.approx([0.0, 0.25, 0.5, 0.75])
    stop = selection.threshold_grid(data, 4, selection.Choice("stop", "rest", None), None)
    assert stop.tolist() == pytest.approx([0.0, 1.5 / 16, 1.5 / 4, 1.5 * 9 / 16])
    own = selection.threshold_grid(data, 4, selection.Choice("stop", "zero", None, 1.0), None)
    assert own.tolist() == made.tolist()
    given = selection.threshold_grid(
        data, 4, selection.Choice("pi", "zero", None), np.array([0.0, 1.5])
    )
    assert given.tolist() == [0.0, 0.5]
    listed = list(selection.possible_choices(("static", "pi", "modified-pi"), ("zero", "rest")))
    assert [c.family for c in listed].count("static") == 1
    assert len(listed) == 1 + 2 + 2 * len(selection.REGULARISATIONS)
    groups = selection._by_bank([*listed, selection.Choice("stop", "zero", None)])
    assert sorted(map(len, groups)) == [1, 1, 7, 7]


def test_choices_are_compared_by_their_folds_in_the_order_they_were_given():
    choices = [
        selection.Choice(family, "zero", None)
        for family in ("pi", "static", "stop", "pi-cumulative")
    ]
    choices.insert(1, selection.Choice("pi", "rest", None))
    given = R * HEAVY.half_range
    short = shorten(HEAVY, "zero", selection.COMPARED_ROWS)
    found = selection.compare_choices(HEAVY, choices, 4, 0.02, given)
    assert [choice for choice, _ in found] == choices
    for choice, errors in found:
        if choice.family == "static":
            wanted = held_out_errors(short)
        else:
            bank = regressors.make_bank(HEAVY, R, choice.initial_state)
            wanted = Folds(short, bank, ramps=False).errors(choice, 0.02)
        assert errors == pytest.approx(wanted, rel=1e-12) and errors.size == 10
    few = data_of(piece_of((1.0, 0.5), 39, 0))
    assert selection.compare_choices(few, choices, 4, 0.02, given) == []
    assert selection.firmness(few, choices[0], 4, 0.02, given) == selection.Firmness()
    assert selection.choose_operators(few, choices[0], 0.02) == (100, choices[0])
    assert selection.start_of_paper(few, 4, 0.02, given) == "zero"


def test_the_start_of_the_paper_is_another_one_only_where_that_halves_the_error():
    x = 0.7 + 0.3 * loops((0.9, 0.5, 0.8, 1.0), 12)
    z = plays(x, R, np.full(4, 0.7))
    noise = np.random.default_rng(0).standard_normal(x.size)
    given = 3.0 * R
    for scale, wanted in ((1e-6, "rest"), (0.3, "zero")):
        piece = Piece(x, z @ W + scale * noise, 0, 0, x.size, 0, False)
        assert selection.start_of_paper(data_of(piece), 4, 1e-3, given) == wanted


def test_the_fewest_operators_within_two_percent_are_taken():
    x = loops((1.0, 0.6, 0.9, 0.4, 0.8), 20)
    y = plays(x, [0.0, 0.4], np.zeros(2)) @ [0.5, 0.5]
    data = data_of(Piece(x, y, 0, 0, x.size, 0, False))
    n, choice = selection.choose_operators(data, selection.Choice("pi", "zero", None), 1e-3)
    assert (n, choice.power) == (5, 1.0)  # 0.4 is on the straight grid of five
    straight = data_of(Piece(x, x, 0, 0, x.size, 0, False))  # any grid will do: that of the family
    for family, own in (("pi", 1), ("stop", 2)):
        n, choice = selection.choose_operators(
            straight, selection.Choice(family, "zero", None), 1e-3
        )
        assert (n, choice.power) == (5, own)
    assert list(selection.OPERATORS) == [round(5 * 2 ** (k / 2)) for k in range(11)]
    assert np.diff(np.log10(selection.FIRMER)) == pytest.approx(
        [0.1] * 15, abs=0.012
    )  # ten to a decade


def results_of(**errors):
    return [
        (
            selection.Choice(
                name.split("__")[0].replace("_", "-"), [*name.split("__"), "zero"][1], None
            ),
            np.array(e),
        )
        for name, e in errors.items()
    ]


def chosen(**errors):
    choice, candidates = selection.best_choice(
        results_of(**{k: np.full(10, float(e)) for k, e in errors.items()})
    )
    assert candidates[0].chosen and not any(c.chosen for c in candidates[1:])
    assert (
        candidates[0].family == choice.family
        and candidates[0].initial_state == choice.initial_state
    )
    return choice


def test_simpler_families_win_within_their_margins():
    assert chosen(static=9.0, pi=1.015, modified_pi=1.0).family == "pi"
    assert chosen(static=9.0, pi=1.03, modified_pi=1.0).family == "modified-pi"
    assert (
        chosen(static=1.045, pi=1.0).family == "static"
        and chosen(static=1.06, pi=1.0).family == "pi"
    )
    assert chosen(static=9.0, stop=1.14, pi_cumulative=1.0).family == "stop"
    assert chosen(static=9.0, stop=1.17, pi_cumulative=1.0).family == "pi-cumulative"
    assert chosen(pi__zero=1.0015, pi__rest=1.0).initial_state == "zero"
    assert chosen(pi__zero=1.005, pi__rest=1.0).initial_state == "rest"


def test_candidates_say_the_mean_of_their_errors_in_percent_and_how_sure_it_is():
    errors = np.array([0.9, 0.7, 1e-5, 1.1, 0.9, 1.9, 1.7, 1.0, 2.1, 1.9])
    _, candidates = selection.best_choice(results_of(pi=np.full(10, 2.0), stop=errors))
    (candidate,) = [c for c in candidates if c.family == "stop"]
    both = np.mean(errors[:5]) * np.mean(errors[5:])
    assert candidate.error_percent == pytest.approx(50.0 * np.sqrt(both))
    assert candidate.uncertainty_percent == pytest.approx(
        50.0 * np.std(errors, ddof=1) / np.sqrt(10)
    )


def test_a_fold_that_is_met_by_nothing_does_not_decide():
    """As where the output stands still: by ratios, pi would win by any number."""
    results = results_of(pi=2 * ([0.011] * 4 + [0.0]), stop=2 * ([0.01] * 4 + [1e-6]))
    assert selection.best_choice(results)[0].family == "stop"


@pytest.mark.parametrize(("largest", "family"), [(0.045, "pi"), (0.06, "stop")])
def test_a_fold_that_holds_what_no_other_one_holds_decides_as_far_as_it_is_a_fifth(largest, family):
    """Means (4 x 0.005 + largest) / 5 and 0.014; of squares pi would lose both times."""
    results = results_of(pi=2 * ([0.005] * 4 + [largest]), stop=np.full(10, 0.014))
    assert selection.best_choice(results)[0].family == family


def test_firmer_bounds_are_tried_until_the_gain_is_not_high():
    def fitting(cost, need):
        """Error 1 + cost * eps; the gain is 1 / eps, and high below `need` times 0.05."""

        def fitted(eps):
            weights = np.array([eps * need])
            return Estimate(
                "pi", np.zeros(2), 0.0, weights, None, None, None, 0.0
            ), 1.0 + cost * eps

        return fitted

    free = selection._firmness(fitting(0.0, 1.0), 0.001)
    assert (free.affordable, free.enough, free.cost, free.strain) == (
        0.063,
        0.063,
        0.0,
        0.0,
    )  # 1/0.0555 <= 0.9 * 20
    dear = selection._firmness(fitting(2.0, 1.0), 0.001)
    assert dear.affordable == 0.025 and dear.enough == 0.063
    assert dear.cost == pytest.approx(1.126 / 1.002 - 1.0)
    assert selection._firmness(fitting(0.0, 100.0), 0.001) == selection.Firmness()
    firm = selection._firmness(fitting(2.0, 0.1), 0.3)
    assert firm.strain == pytest.approx(1.6 / 1.002 - 1.0) and (firm.affordable, firm.enough) == (
        0.315,
        None,
    )
    assert firm.times(2.0)[:2] == (0.63, None)
    assert selection._raised(2.0, 1.0) == pytest.approx(1.0)
    assert selection._raised(0.0, 1e-9) == pytest.approx(0.0, abs=1e-6)  # both are rounding


def test_a_loop_that_starts_flat_gets_the_bound_that_its_gain_asks_for():
    x = loops((1.0, 0.6, 0.9, 0.4, 0.8), 20)
    data = data_of(Piece(x, plays(x, [0.0, 0.4], np.zeros(2)) @ [0.0, 1.0], 0, 0, x.size, 0, False))
    given = np.array([0.0, 0.4]) * data.half_range
    found = selection.firmness(data, selection.Choice("pi", "zero", None), 2, 0.001, given)
    assert (
        found.enough == 0.063 and found.cost > 0.05 and found.strain == 0.0
    )  # 1 / 0.063 <= 0.9 * 20
    curve = selection.firmness(data, selection.Choice("static", "zero", None), 2, 0.001, given)
    assert curve == selection._firmness(lambda eps: fit_static(data, "zero", eps), 0.001)


# --- mending -------------------------------------------------------------------------------


def test_outliers_are_named_by_value_and_place():
    x = np.sin(np.arange(400) / 10)
    spikes = {50: 100.0, 90: 101.0, 130: 102.0, 200: 103.0, 260: 104.0}
    y = 2.0 * x
    for place, value in spikes.items():
        y[place] = value
    found = mended(dehyst.Recording(input=x, output=y))
    assert found.left_out == tuple(spikes)
    message = found.findings[0].message
    assert (
        "5 of 400 samples" in message
        and "is 100, 101, 102, 103, ... in samples 50, 90, 130, 200, ..." in message
    )
    assert "Memory follows" not in message
    index = np.arange(30)
    assert mending._numbers((index > 9) & (index < 17)) == "samples 10 to 16"
    assert mending._numbers((index > 9) & (index < 14)) == "samples 10, 11, 12, 13"
    assert mending._numbers(np.isin(index, [1, 2, 3, 4, 6])) == "samples 1, 2, 3, 4, ..."
    z = x.copy()
    z[77] = -80.0
    other = mended(dehyst.Recording(input=z, output=2.0 * x))
    assert (
        "is -80 in sample 77)" in other.findings[0].message
        and "Memory follows" in other.findings[0].message
    )
    assert abs(other.input[77] - x[77]) < 0.01 and mended(recording()).findings == ()
