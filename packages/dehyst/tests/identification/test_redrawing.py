"""Doubts of errors: redrawn parts of the held-out samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import dehyst
from dehyst.identification._policy import POLICY
from dehyst.identification._redrawing import interval, part_squares, redrawn, within_doubt
from dehyst.io import example_recording

squares_of_parts = st.lists(st.floats(1e-6, 1e6), min_size=2, max_size=12).map(np.array)


@given(squares_of_parts)
def test_an_interval_holds_the_error_and_lies_between_the_parts(squares):
    low, high = interval(squares)
    least, most = np.sqrt(squares.min()), np.sqrt(squares.max())
    assert least * (1 - 1e-12) <= low <= high <= most * (1 + 1e-12)
    inside = np.sort(redrawn(squares))
    assert np.mean((inside >= low) & (inside <= high)) >= POLICY.redraw_share


@given(squares_of_parts, st.floats(1e-3, 1e3))
def test_intervals_follow_the_unit(squares, unit):
    low, high = interval(squares)
    np.testing.assert_allclose(interval(unit**2 * squares), (unit * low, unit * high), rtol=1e-9)


def test_equal_parts_leave_no_doubt():
    assert interval(np.full(10, 4.0)) == (2.0, 2.0)


def test_an_interval_holds_the_true_error_of_noise_as_often_as_it_says():
    """Errors of white noise of size 1, 40 parts of 25 samples in ten: the truth lies inside in about nine of ten."""
    rng = np.random.default_rng(5)
    inside = 0
    for _ in range(300):
        low, high = interval(np.mean(rng.normal(size=(10, 25)) ** 2, axis=1))
        inside += low <= 1.0 <= high
    # Ten parts make a bootstrap a little narrow.
    assert 0.78 <= inside / 300 <= 0.94


@given(squares_of_parts)
def test_a_row_ties_with_itself_and_not_with_one_beyond_the_ratio(squares):
    assert within_doubt(squares, squares)
    assert not within_doubt(1.01 * POLICY.tied_ratio**2 * squares, squares)


def test_the_difference_is_paired():
    """Parts differ a hundredfold; a row that is a tenth worse on each of them is no tie."""
    best = np.geomspace(1.0, 100.0, 10)
    assert not within_doubt(1.1**2 * best, best)
    assert within_doubt(best[::-1].copy(), best)


def test_one_part_that_makes_the_whole_difference_is_no_tie_beyond_the_ratio():
    best = np.ones(10)
    worse = best.copy()
    worse[3] = 1000.0
    assert not within_doubt(worse, best)


def test_parts_cover_every_chosen_sample_once():
    record = example_recording()
    mask = np.arange(len(record)) % 3 > 0
    outputs = [record.output + 0.5]
    squares = part_squares(outputs, [record], [mask])
    assert squares.size == POLICY.compared_blocks
    np.testing.assert_allclose(squares, 0.25)


@pytest.mark.slow
def test_every_row_of_a_comparison_has_an_interval_around_its_error():
    comparison = dehyst.compare(
        example_recording(), ["static", "pi", "modified-pi", "direct-inverse"]
    )
    for entry in comparison.entries:
        low, high = entry.interval_percent
        assert low <= entry.error_percent <= high
        assert entry.as_dict()["interval_percent"] == (low, high)
    assert not comparison["static"].tied and not comparison["pi"].tied


@pytest.fixture(scope="module")
def fit():
    return dehyst.identify(example_recording())


@pytest.mark.slow
def test_a_row_that_is_three_times_better_on_held_out_samples_is_named_with_the_reason(fit):
    assert fit.passed_over == ""
    row = next(row for row in fit.table if not row.chosen and row.family != "static")
    better = replace(row, test_percent=fit.test.rmse_percent / 4.0)
    words = replace(fit, table=(better, *fit.table)).passed_over
    assert f"--family {row.family}" in words and "It was not taken" in words
    left_out = {}
    for setting in fit.candidates:
        left_out.setdefault(setting.family, setting.error_percent)
    assert f"{left_out[row.family]:.3g} %" in words and f"{left_out[fit.family]:.3g} %" in words
    nearly = replace(row, test_percent=fit.test.rmse_percent / 2.9)
    assert replace(fit, table=(nearly, *fit.table)).passed_over == ""
