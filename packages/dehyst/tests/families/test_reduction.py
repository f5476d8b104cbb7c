"""Smaller sums stay next to the full one, on the log and on other motions, and keep what makes them rise."""

import numpy as np
import pytest

from dehyst.families import Stretch
from dehyst.families._reduction import Teacher, probing, reduced


def teacher(seed, outputs=lambda sums: sums):
    """A full sum of 40 columns that are alike, along 300 rows of a log and 200 others."""
    random = np.random.default_rng(seed)
    few = random.standard_normal((500, 8))
    rows = few @ random.standard_normal((8, 40)) + 0.1 * random.standard_normal((500, 40))
    of_log = np.arange(500) < 300
    least = np.where(np.arange(40) < 3, 0.05, 0.0)
    weights = np.maximum(random.exponential(0.1, 40), least)
    weight = random.uniform(0.5, 1.5, 500)
    return Teacher(rows, weight, (of_log, ~of_log), 0.3, weights, least, outputs)


def apart(full, smaller, rows):
    """Difference of both outputs at some rows, rms, from the numbers alone."""
    sums = [full.offset + full.rows @ full.weights, smaller.offset + full.rows @ smaller.weights]
    miss = (full.outputs(sums[1]) - full.outputs(sums[0]))[rows]
    return np.sqrt(np.average(miss**2, weights=full.weight[rows]))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("outputs", [lambda sums: sums, lambda sums: 20.0 * sums])
def test_a_smaller_sum_is_within_the_tolerance_on_either_set_of_rows(seed, outputs):
    full = teacher(seed, outputs)
    tolerance = 0.2
    smaller = reduced(full, tolerance)
    assert np.count_nonzero(smaller.weights) <= 40 and np.all(smaller.weights >= full.least)
    for rows in full.sets:
        assert apart(full, smaller, rows) <= tolerance


@pytest.mark.parametrize("seed", range(4))
def test_a_larger_tolerance_needs_no_more_terms_and_none_keeps_the_full_sum(seed):
    full = teacher(seed)
    terms = [np.count_nonzero(reduced(full, t).weights) for t in (0.0, 0.1, 1.0, 100.0)]
    assert terms[0] == np.count_nonzero(full.weights) and terms[-1] == 3
    assert terms == sorted(terms, reverse=True) and terms[2] < terms[0]


def test_a_probing_motion_fills_the_range_as_fast_as_the_log_moves():
    x = np.sin(np.linspace(0.0, 20.0, 2000))
    dt = np.full(2000, 0.01)
    signal, steps = probing([Stretch(x, x, dt, np.ones(2000, dtype=bool))])
    assert signal.min() == -1.0 and signal.max() == 1.0 and steps[1:] == pytest.approx(0.01)
    moves = np.abs(np.diff(signal))
    assert moves.max() <= 1.5 * np.abs(np.diff(x)).max()
    assert probing([Stretch(x, x, None, np.ones(2000, dtype=bool))])[1] is None
