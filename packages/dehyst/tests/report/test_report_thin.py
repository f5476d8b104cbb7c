"""Claims about thinning: the picture stays the same."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst.report import Window
from dehyst.report._thin import (
    ACROSS,
    LIMIT,
    UP,
    interrupted,
    joined,
    occupancy,
    thin_path,
    thin_series,
)


def clean_loop(samples: int, loops: int) -> tuple[np.ndarray, np.ndarray]:
    t = np.linspace(0, 2 * np.pi * loops, samples)
    return np.cos(t), np.cos(t - 0.4)


def test_a_short_path_is_left_alone():
    x, y = clean_loop(LIMIT, 3)
    kept = thin_path(x, y, Window.around((x, y)))
    assert kept is not None and kept[0] is x and kept[1] is y


def test_an_oversampled_loop_is_thinned_within_a_cell_and_keeps_its_extremes():
    x, y = clean_loop(200_000, 3)
    window = Window.around((x, y))
    kept = thin_path(x, y, window)
    assert kept is not None and kept[0].size < LIMIT
    assert {float(x.max()), float(x.min())} <= set(kept[0].tolist())
    assert {float(y.max()), float(y.min())} <= set(kept[1].tolist())
    u, v = window.cells(x[::97], y[::97])
    ku, kv = window.cells(*kept)
    nearest = np.array([np.min(np.hypot(ku - a, kv - b)) for a, b in zip(u, v, strict=True)])
    assert nearest.max() <= 3.0 * np.sqrt(2.0)


def test_noise_is_drawn_as_an_area_that_holds_every_sample():
    rng = np.random.default_rng(0)
    x, y = rng.standard_normal((2, 50_000))
    window = Window.around((x, y))
    assert thin_path(x, y, window) is None
    columns, rows, visited = occupancy(x, y, window)
    assert (
        visited.shape == (rows.size, columns.size)
        and rows.size <= UP + 1
        and columns.size <= ACROSS + 1
    )
    column = np.rint((x - columns[0]) / (columns[1] - columns[0])).astype(int)
    row = np.rint((y - rows[0]) / (rows[1] - rows[0])).astype(int)
    near = np.zeros(x.size, dtype=bool)
    for i in (-1, 0, 1):  # a sample on the border of two cells may count for either
        for k in (-1, 0, 1):
            near |= (
                visited[
                    np.clip(row + i, 0, rows.size - 1), np.clip(column + k, 0, columns.size - 1)
                ]
                >= 0.5
            )
    assert near.all()
    assert visited[1, 1] == 0.0  # a corner where nothing was


def test_an_area_follows_lines_between_samples_but_not_across_gaps():
    x, y = np.array([0.0, 1.0, np.nan, 1.0, 0.0]), np.array([0.0, 0.0, np.nan, 1.0, 1.0])
    _, rows, visited = occupancy(x, y, Window(-0.1, 1.1, -0.1, 1.1))
    middle = visited[:, ACROSS // 2] >= 0.5
    assert rows[middle].min() < 0.05 and rows[middle].max() > 0.95
    assert not visited[UP // 2].any()  # nothing joins the two lines


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 10_000), size=st.integers(1, 30_000), limit=st.integers(10, 2000))
def test_a_thinned_series_keeps_the_extremes_and_the_limit(seed, size, limit):
    rng = np.random.default_rng(seed)
    y = rng.standard_normal(size)
    y[rng.integers(0, size, size // 10)] = np.nan
    kept = thin_series(y, limit)
    assert np.all(np.diff(kept) > 0) and kept[0] == 0 and kept[-1] == size - 1
    assert kept.size <= max(size if size <= limit else 0, 1.5 * limit + 4)
    if np.isfinite(y).any():
        assert np.nanmax(y[kept]) == np.nanmax(y) and np.nanmin(y[kept]) == np.nanmin(y)


def test_interruptions_fall_between_pieces():
    values = interrupted(np.arange(6.0), (2, 4))
    assert np.isnan(values[[2, 5]]).all() and values.size == 8


@pytest.mark.parametrize("value", [0.0, 5.0, -1e-30, 1e12])
def test_a_constant_gets_a_window(value):
    window = Window.around((np.full(5, value), np.full(5, value)))
    assert window.x_high > window.x_low and window.y_high > window.y_low
    assert np.isfinite(window.cells(np.array([value]), np.array([value]))).all()


@pytest.mark.parametrize("seed", range(5))
def test_joined_lines_stay_within_a_cell_and_keep_their_extremes(seed):
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, 3000)
    y = np.interp(t, np.sort(rng.random(40)), rng.standard_normal(40)) + 0.2 * np.sin(60 * t)
    window = Window.around((t, y))
    kept_t, kept_y = joined(t, y, window)
    assert kept_t.size < 1000
    assert {float(y.min()), float(y.max())} <= set(kept_y.tolist())
    u, v = window.cells(t, y)
    ku, kv = window.cells(kept_t, kept_y)
    steep = np.abs(np.gradient(v, u)) < 1.0  # there, the vertical distance is the distance
    assert np.max(np.abs(np.interp(u, ku, kv) - v)[steep]) < 2.0
