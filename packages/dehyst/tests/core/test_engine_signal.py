"""Turning points and essential samples, against their definitions written out."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst import _native
from identification_oracles import plays

# Few values, so that ties, plateaus and closed loops are frequent.
LEVELS = st.lists(st.integers(-6, 6).map(float), min_size=1, max_size=40)


def turns_by_definition(x, swing):
    """First sample, extremes between swings larger than `swing`, last sample: looks at every sample, forgets none."""
    found, low, high, direction = [0], 0, 0, 0
    for k in range(1, len(x)):
        high = k if x[k] >= x[high] and (x[k] > x[high] or k - 1 == high) else high
        low = k if x[k] <= x[low] and (x[k] < x[low] or k - 1 == low) else low
        if direction >= 0 and x[high] - x[k] > swing:
            found += [high] if direction > 0 else []
            direction, low, high = -1, k, k
        elif direction <= 0 and x[k] - x[low] > swing:
            found += [low] if direction < 0 else []
            direction, low, high = 1, k, k
    return np.unique([*found, len(x) - 1])


@given(LEVELS, st.sampled_from([0.5, 1.5, 3.5]))
def test_turning_points_are_those_of_the_definition(levels, swing):
    x = np.array(levels)
    found = _native.turning_points(x, swing)
    expected = turns_by_definition(x, swing)
    assert found.size == expected.size
    assert (x[found] == x[expected]).all()  # of a plateau, any sample
    assert found[0] == 0 and found[-1] == x.size - 1 and (np.diff(found) > 0).all()


@given(LEVELS, st.data())
def test_essential_samples_give_every_play_the_same_bits_at_the_rows(levels, data):
    x = np.array(levels) + 0.1
    rows = np.array(
        sorted(data.draw(st.sets(st.integers(0, x.size - 1), min_size=1))), dtype=np.int64
    )
    r = np.sort(data.draw(st.lists(st.floats(0.0, 7.0), min_size=1, max_size=6)))
    z0 = np.array(data.draw(st.lists(st.floats(-9.0, 9.0), min_size=len(r), max_size=len(r))))
    kept, place = _native.essential(x, rows)
    assert (kept[place] == rows).all() and (np.diff(kept) > 0).all()
    assert np.array_equal(plays(x[kept], r, z0)[place], plays(x, r, z0)[rows])


def test_nothing_between_two_rows_stays_unless_it_turned():
    x = np.concatenate([np.linspace(0.0, 1.0, 500), np.linspace(1.0, -1.0, 500)])
    kept, _ = _native.essential(x, np.array([100, 999]))
    assert kept.size <= 4 and x[kept].max() == 1.0


def test_of_noise_between_two_rows_only_the_nested_extremes_stay():
    x = np.random.default_rng(0).uniform(-1.0, 1.0, 200_000)
    rows = np.arange(999, x.size, 1000)
    kept, _ = _native.essential(x, rows)
    assert kept.size < 30 * rows.size


@pytest.mark.parametrize("rows", [[3], [1, 1], [2, 0], [-1]])
def test_rows_outside_the_signal_or_out_of_order_are_refused(rows):
    with pytest.raises(ValueError, match="rows"):
        _native.essential(np.zeros(3), np.array(rows, dtype=np.int64))


@given(LEVELS, st.integers(1, 7), st.booleans())
def test_sums_over_bins_are_those_of_the_definition(levels, bins, weighted):
    x = np.array(levels) / 5.0  # some beyond the ends
    y, weight = np.cos(np.arange(x.size)), np.arange(x.size) % 3 * 1.0 if weighted else None
    sums = np.zeros((bins, 5))
    for k, place in enumerate(np.clip((x + 1.0) * (bins / 2.0), 0.0, bins)):
        cell = min(int(place), bins - 1)
        t, w = place - cell, 1.0 if weight is None else weight[k]
        sums[cell] += w * np.array([1.0, t, t * t, y[k], t * y[k]])
    assert np.allclose(_native.bin_sums(x, y, weight, bins, -1.0, 1.0), sums, rtol=0, atol=1e-12)


def test_short_signals_have_the_turning_points_they_can_have():
    assert _native.turning_points(np.zeros(0), 1.0).tolist() == []
    assert _native.turning_points(np.zeros(1), 1.0).tolist() == [0]
    assert _native.turning_points(np.zeros(5), 1.0).tolist() == [0, 4]
    assert _native.essential(np.zeros(4), np.zeros(0, dtype=np.int64))[0].size == 0
