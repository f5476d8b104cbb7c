"""Columns of sums of elements in the engine: ramps, and sums of matrices that are stored by triangles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst import _native
from dehyst.families._program import BLOCKS, block_sums

LEVELS = range(_native.engine_best_level() + 1)


@pytest.fixture(params=LEVELS)
def level(request):
    """Run at each instruction set that this processor has."""
    _native.engine_use_level(request.param)
    yield request.param
    _native.engine_use_level(_native.engine_best_level())


def symmetric(rng, count, size):
    matrices = rng.standard_normal((count, size, size))
    return matrices + matrices.transpose(0, 2, 1)


def triangles_of(matrices):
    stored = np.empty((len(matrices), matrices.shape[1] * (matrices.shape[1] + 1) // 2))
    for matrix, row in zip(matrices, stored, strict=True):
        _native.triangle(matrix, row)
    return stored


def test_a_triangle_holds_the_lower_half_row_by_row():
    (matrix,) = symmetric(np.random.default_rng(0), 1, 7)
    (stored,) = triangles_of(matrix[None])
    assert np.array_equal(stored, matrix[np.tril_indices(7)])


@given(st.data(), st.integers(1, 40), st.integers(0, 9), st.integers(1, 3))
def test_sums_of_triangles_are_those_of_the_matrices(data, size, count, sums):
    chosen = np.array(sorted(data.draw(st.sets(st.integers(0, size - 1), min_size=1))))
    rng = np.random.default_rng(size)
    matrices = symmetric(rng, count, size)
    factors = rng.standard_normal((sums, count)) * rng.integers(0, 2, (sums, count))
    added = _native.sums_of_triangles(triangles_of(matrices), factors, chosen)
    wanted = np.einsum("sm,mij->sij", factors, matrices)[:, chosen[:, None], chosen]
    assert added.shape == (sums, chosen.size, chosen.size)
    assert np.array_equal(added, added.transpose(0, 2, 1))
    np.testing.assert_allclose(added, wanted, rtol=0, atol=1e-13)


def test_levels_agree_on_sums_of_triangles(level):
    matrices = symmetric(np.random.default_rng(1), 50, 60)
    factors = np.random.default_rng(2).uniform(0.1, 2.0, (6, 50))
    chosen = np.delete(np.arange(60), [3, 4, 30])
    added = _native.sums_of_triangles(triangles_of(matrices), factors, chosen)
    wanted = np.einsum("sm,mij->sij", factors, matrices)[:, chosen[:, None], chosen]
    np.testing.assert_allclose(added, wanted, rtol=0, atol=1e-12)


@pytest.mark.parametrize("chosen", [[0, 0], [1, 0], [-1, 0], [0, 4], [0, 2**40]])
def test_rows_that_do_not_increase_or_lie_outside_are_refused(chosen):
    stored = triangles_of(symmetric(np.random.default_rng(0), 2, 4))
    with pytest.raises(ValueError, match="chosen"):
        _native.sums_of_triangles(stored, np.ones((1, 2)), np.array(chosen))
    with pytest.raises(ValueError, match="differ"):
        _native.sums_of_triangles(stored, np.ones((1, 3)), np.array([0]))


@pytest.mark.parametrize("shape", [(5,), (7,)])
def test_a_triangle_of_another_size_is_refused(shape):
    with pytest.raises(ValueError, match="numbers"):
        _native.triangle(np.eye(3), np.empty(shape))


def test_ramps_are_clipped_cells_less_their_value_at_zero(level):
    rng = np.random.default_rng(3)
    e, cell = rng.uniform(-1.5, 1.5, (200, 6)), rng.integers(0, 6, 45)
    gain, ends, x_ends = (
        rng.uniform(-2.0, 2.0, 45),
        np.sort(rng.uniform(-1, 1, (2, 45)), axis=0),
        np.sort(rng.uniform(-1, 1, (2, 45)), axis=0),
    )
    ends[:, :5] = [[-np.inf], [np.inf]]
    x_ends[:, 5:20] = 0.0
    out = np.full((200, 45), np.nan)
    _native.ramps(e, cell, np.stack([gain, *ends, *x_ends]), out)
    of_cells = np.clip(e[:, cell], *ends) - np.clip(0.0, *ends)
    of_input = np.clip(e[:, :1], *x_ends) - np.clip(0.0, *x_ends)
    assert np.array_equal(out, gain * of_cells + of_input)


@pytest.mark.parametrize("cell", [-1, 2])
def test_a_ramp_of_a_cell_that_is_not_there_is_refused(cell):
    with pytest.raises(ValueError, match="cell"):
        _native.ramps(np.zeros((3, 2)), np.array([cell]), np.zeros((5, 1)), np.zeros((3, 1)))


def test_sums_of_blocks_and_pieces_add_up_to_those_of_all_weighted_rows():
    rng = np.random.default_rng(4)
    columns, y = rng.standard_normal((300, 9)), rng.uniform(-1.0, 1.0, 300)
    block, weight = rng.integers(0, BLOCKS, 300), rng.uniform(0.0, 3.0, 300)
    sums = block_sums(columns, y, block, np.zeros(9), np.zeros((0, 2), dtype=int), 4, weight)
    rows = np.column_stack([np.ones(300), columns])
    added = sums.gram.sum(axis=(0, 1))[: 10 * 11 // 2]
    wanted = rows.T @ (weight[:, None] * rows)
    np.testing.assert_allclose(added, wanted[np.tril_indices(10)], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(sums.rhs.sum(axis=(0, 1))[:10], rows.T @ (weight * y), atol=1e-12)
    assert sums.counted.sum() == pytest.approx(weight.sum(), rel=1e-14)
    assert sums.square.sum() == pytest.approx(weight @ y**2, rel=1e-13)
