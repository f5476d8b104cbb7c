"""Rows that stand for a log are spread by way; what is left out together is a fifth of it, in parts that lie apart."""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.data import _spread as spread
from dehyst.data import kit

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]
PARTS = 20
EDGES = np.arange(1, PARTS) / PARTS


@st.composite
def strokes(draw: st.DrawFn, least: int = 3, samples: int = 200) -> Array:
    """Strokes between turning points, each at a constant speed, equally long in time."""
    step = st.floats(0.2, 2.0)
    turns = [0.0]
    for sign in [1.0, -1.0] * draw(st.integers(least, 10)):
        turns.append(sign * draw(step))
    return np.interp(
        np.arange(samples * (len(turns) - 1) + 1) / samples, np.arange(len(turns)), turns
    )


def every(x: Array) -> npt.NDArray[np.bool_]:
    return np.ones(x.size, dtype=np.bool_)


def share_of(x: Array) -> Array:
    return kit.shares_of([x], [every(x)])[0]


def middles_of(share: Array) -> Array:
    """How far along the log the middle of each sample's share lies, 0 to 1."""
    return (np.cumsum(share) - 0.5 * share) / np.sum(share)


def far_from_edges(share: Array, distance: float) -> npt.NDArray[np.bool_]:
    """Samples that are no nearer to the end of a part than this share of the whole."""
    apart = np.abs(middles_of(share)[:, None] - EDGES)
    return np.asarray(np.min(apart, axis=1) > distance)


def moves_by_definition(x: Array) -> Array:
    """How far each sample moves the middle of a band that the input drags along."""
    half = spread.POLICY.still_band * 0.5 * float(np.max(x) - np.min(x))
    z = float(x[0])
    moves = []
    for value in x.tolist():
        moved = max(value - half, min(value + half, z))
        moves.append(abs(moved - z))
        z = moved
    return np.array(moves)


def rested(x: Array, at: list[int], long: int) -> tuple[Array, npt.NDArray[np.bool_]]:
    """The log with a rest of some samples after each of these samples, and which samples are those of the log."""
    count = np.ones(x.size, dtype=np.int64)
    count[at] += long
    begins = np.concatenate([[0], np.cumsum(count)[:-1]])
    own = np.zeros(int(count.sum()), dtype=np.bool_)
    own[begins] = True
    return np.repeat(x, count), own


# --- which samples stand for the log --------------------------------------------------------------------------------


@given(strokes(), st.integers(20, 6000))
def test_weights_sum_to_the_rows(x: Array, most: int) -> None:
    (rows,) = kit.spread_rows([x], [every(x)], most)
    assert np.sum(rows.weight) == pytest.approx(rows.rows.size, rel=1e-12)
    assert rows.weight.min() > 0.0
    assert rows.rows.size <= min(most, x.size)
    assert np.all(np.diff(rows.rows) > 0) and rows.rows[0] >= 0 and rows.rows[-1] < x.size


@given(strokes(), st.integers(100, 400))
def test_rows_carry_the_weight_of_the_way_between_them(x: Array, most: int) -> None:
    """Of each stretch of the log they carry its share, within the two rows at its ends."""
    share = share_of(x)
    (rows,) = kit.spread_rows([x], [every(x)], most)
    scale = 1.0 / np.sum(rows.weight)
    largest = max(float(np.max(rows.weight)) * scale, float(np.max(share)))
    for begin, end in itertools.pairwise(np.linspace(0, x.size, 6).astype(int).tolist()):
        inside = (rows.rows >= begin) & (rows.rows < end)
        carried = scale * float(np.sum(rows.weight[inside]))
        assert abs(carried - float(np.sum(share[begin:end]))) <= 2.0 * largest


@given(strokes(), st.data())
def test_samples_that_do_not_count_stand_for_nothing_and_yet_move(
    x: Array, data: st.DataObject
) -> None:
    begin = data.draw(st.integers(0, x.size // 2))
    counts = every(x)
    counts[begin : begin + x.size // 4] = False
    (rows,) = kit.spread_rows([x], [counts], 500)
    assert np.all(counts[rows.rows])
    (share,) = kit.shares_of([x], [counts])
    assert np.all(share[~counts] == 0.0)
    moves = moves_by_definition(x)
    moving = counts & (moves > 0.0)
    ratio = share[moving] / moves[moving]
    assert np.ptp(ratio) < 1e-9 * ratio.max()


@given(strokes(), strokes())
def test_several_signals_share_by_their_ways(x: Array, other: Array) -> None:
    shares = kit.shares_of([x, other], [every(x), every(other)])
    assert np.sum(shares[0]) + np.sum(shares[1]) == pytest.approx(1.0, abs=1e-12)
    rows = kit.spread_rows([x, other], [every(x), every(other)], 1000)
    carried = np.array([np.sum(part.weight) for part in rows])
    wanted = np.array([np.sum(share) for share in shares])
    assert carried / carried.sum() == pytest.approx(wanted, abs=2e-3)


# --- rests ----------------------------------------------------------------------------------------------------------


@given(strokes(samples=40), st.data())
def test_shares_are_the_way_of_a_band_and_rests_have_a_fifth_at_most(
    x: Array, data: st.DataObject
) -> None:
    at = data.draw(st.lists(st.integers(0, x.size - 1), max_size=5, unique=True))
    long, _ = rested(x, at, data.draw(st.sampled_from([1, 30, 600])))
    share = share_of(long)
    moves = moves_by_definition(long)
    at_rest = moves == 0.0
    of_rests = float(np.sum(share[at_rest]))
    assert of_rests == pytest.approx(min(0.2, np.mean(at_rest)), abs=1e-12)
    wanted = (1.0 - of_rests) * moves / np.sum(moves)
    assert share[~at_rest] == pytest.approx(wanted[~at_rest], rel=1e-6, abs=1e-15)


def test_noise_at_rest_is_no_way() -> None:
    rng = np.random.default_rng(0)
    moving = np.interp(np.arange(801) / 100, np.arange(9), [0.0, 1.0, -1.0] * 3)
    resting = moving[-1] + 0.0015 * rng.uniform(-1.0, 1.0, 20_000)
    share = share_of(np.concatenate([moving, resting]))
    assert np.sum(share[moving.size :]) == pytest.approx(0.2, abs=0.002)


def test_a_log_that_never_moves_is_all_rest() -> None:
    assert share_of(np.zeros(10)) == pytest.approx(np.full(10, 0.1))


# --- what is left out together ----------------------------------------------------------------------------------------


def test_no_two_neighbouring_parts_are_in_one_fold_and_each_fold_has_four() -> None:
    order = kit.folds_of(np.ones(PARTS))[0]
    assert np.bincount(order).tolist() == [4] * kit.FOLDS
    assert np.all(np.diff(order) != 0)


@pytest.mark.parametrize("cycle", range(2, 11))
def test_no_fold_leaves_out_one_phase_of_equal_cycles_throughout(cycle: int) -> None:
    """0 1 2 3 4 0 1 2 3 4 ... would, of cycles of five parts: the rest of the log would not show that phase at all."""
    order = kit.folds_of(np.ones(PARTS))[0]
    for fold in range(kit.FOLDS):
        assert np.unique(np.flatnonzero(order == fold) % cycle).size >= 2


@given(st.lists(st.floats(0.2, 1.0), min_size=120, max_size=500))
def test_folds_are_the_parts_of_the_summed_weight(weights: list[float]) -> None:
    """By a walk through the rows: no row is heavier than a part, so each part has a row, and each fold has rows."""
    order = kit.folds_of(np.ones(PARTS))[0].tolist()
    total = sum(weights)
    summed = 0.0
    folds = kit.folds_of(np.array(weights))[0]
    for weight, fold in zip(weights, folds.tolist(), strict=True):
        place = PARTS * (summed + 0.5 * weight) / total
        summed += weight
        if abs(place - round(place)) > 1e-9:
            assert fold == order[int(place)]
    assert np.unique(folds).tolist() == list(range(kit.FOLDS))


@given(strokes(), st.integers(100, 4000))
def test_every_fold_has_rows_and_about_a_fifth_of_the_weight(x: Array, most: int) -> None:
    (rows,) = kit.spread_rows([x], [every(x)], most)
    folds = kit.folds_of(rows.weight)[0]
    for fold in range(kit.FOLDS):
        part = float(np.sum(rows.weight[folds == fold]) / np.sum(rows.weight))
        # Eight ends of parts, at each of which a row lies on one side or on the other.
        assert abs(part - 0.2) <= 4.0 * float(np.max(rows.weight) / np.sum(rows.weight))


def same_parts(first: Array, other: Array, distance: float) -> bool:
    """Whether samples with these shares, the same ones twice, are in the same folds, but for those at ends of parts."""
    clear = far_from_edges(first, distance)
    folds = kit.folds_of(first)[0][clear], kit.folds_of(other)[0][clear]
    return bool(clear.any() and np.array_equal(*folds))


@given(strokes(), st.sampled_from([2, 4, 5, 8]))
def test_decimating_does_not_move_what_is_left_out(x: Array, every_nth: int) -> None:
    """A stroke has 200 samples, so that every eighth still meets the turning points. A part is 0.05 of the whole."""
    share = share_of(x)
    thin = share_of(x[::every_nth])
    middles, thin_middles = middles_of(share)[::every_nth], middles_of(thin)
    assert np.max(np.abs(middles - thin_middles)) < 0.006
    clear = np.min(np.abs(middles[:, None] - EDGES), axis=1) > 0.006
    assert np.array_equal(kit.folds_of(share)[0][::every_nth][clear], kit.folds_of(thin)[0][clear])


@given(strokes(), st.floats(1e-6, 1e6), st.booleans(), st.floats(-100.0, 100.0))
def test_units_and_signs_do_not_move_what_is_left_out(
    x: Array, scale: float, falls: bool, level: float
) -> None:
    other = scale * (level + (-x if falls else x))
    assert same_parts(share_of(x), share_of(other), 1e-3)


@given(strokes(samples=40), st.data(), st.integers(2, 30))
def test_rests_that_are_all_longer_do_not_move_what_is_left_out(
    x: Array, data: st.DataObject, longer: int
) -> None:
    """Once they fill their fifth: what they add together is the same, and each has the same part of it."""
    at = data.draw(st.lists(st.integers(0, x.size - 1), min_size=1, max_size=5, unique=True))
    moves = moves_by_definition(x)
    short, own = rested(x, at, x.size)
    first = share_of(short)
    # Samples within the band rest, too; they are repeated as often.
    at_rest = moves_by_definition(short) == 0.0
    count = np.where(at_rest, longer, 1)
    second = share_of(np.repeat(short, count))
    begins = np.concatenate([[0], np.cumsum(count)[:-1]])
    middles = middles_of(first)[own]
    later = middles_of(second)[begins][own]
    moving = moves > 0.0
    assert middles[moving] == pytest.approx(later[moving], abs=1e-9)


@given(strokes(), st.integers(0, 20_000))
def test_a_rest_moves_the_parts_of_the_way_by_a_fifth_at_most(x: Array, long: int) -> None:
    """However long, and wherever it is."""
    still, own = rested(x, [0], long)
    way = middles_of(moves_by_definition(x))
    moving = moves_by_definition(x) > 0.0
    shift = middles_of(share_of(still))[own][moving] - way[moving]
    assert np.max(np.abs(shift)) <= 0.2 + 1e-9


def test_folds_in_one_piece_are_fifths_of_the_way_one_after_the_other():
    in_one_piece = kit.folds_of(np.ones(PARTS))[1]
    assert in_one_piece.tolist() == sorted(in_one_piece.tolist())
    assert np.bincount(in_one_piece).tolist() == [PARTS // kit.FOLDS] * kit.FOLDS


def test_a_score_is_the_geometric_mean_of_both_means_and_folds_without_rows_do_not_count():
    errors = np.array([1.0, 3.0, 2.0, 2.0, np.nan, 8.0, 8.0, np.nan, 8.0, 8.0])
    assert kit.score_of(errors) == pytest.approx(4.0)


@pytest.mark.filterwarnings("error")
def test_without_a_fold_of_a_kind_there_is_no_score_and_no_warning_of_numpy():
    folds = np.full(10, np.nan)
    folds[5:] = 2.0
    assert np.isnan(kit.score_of(folds))
    folds[3] = 8.0
    assert kit.score_of(folds) == pytest.approx(4.0)
