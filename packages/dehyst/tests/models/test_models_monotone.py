"""The monotone map against Kuhnen's superposition of one-sided dead zones."""

from fractions import Fraction as F

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst import MonotoneMap
from oracles import dead_zone_map

widths = st.lists(st.integers(1, 300).map(lambda k: k / 64), min_size=1, max_size=10)


@st.composite
def maps(draw):
    """Maps over dyadic breakpoints with slopes between 1/100 and 100, rising or falling."""
    du = draw(widths)
    slopes = draw(st.lists(st.floats(0.01, 100.0), min_size=len(du), max_size=len(du)))
    u = np.concatenate([[0.0], np.cumsum(du)]) + draw(st.integers(-300, 300)) / 64
    v = np.concatenate([[0.0], np.cumsum(np.array(slopes) * du)]) + draw(st.floats(-10, 10))
    return MonotoneMap(u, v if draw(st.booleans()) else -v)


@given(maps(), st.lists(st.floats(-50, 50), min_size=1, max_size=12), st.data())
def test_a_map_is_a_superposition_of_dead_zones_about_any_anchor(mapping, points, data):
    u, v = [F(x) for x in mapping.u.tolist()], [F(x) for x in mapping.v.tolist()]
    slopes = [(v[i + 1] - v[i]) / (u[i + 1] - u[i]) for i in range(len(u) - 1)]
    at = data.draw(st.integers(0, len(u) - 2))
    anchor, value = (u[at] + u[at + 1]) / 2, (v[at] + v[at + 1]) / 2
    expected = [dead_zone_map(p, slopes, u[1:-1], anchor, value) for p in points]
    scale = (
        max(abs(e) for e in expected)
        + max(abs(x) for x in v)
        + 100 * max(abs(p) for p in points)
        + 1
    )
    for got, exact in zip(mapping(points), expected, strict=True):
        assert abs(F(float(got)) - exact) < F(1, 10**14) * F(float(scale))


@given(maps())
def test_breakpoints_are_met_exactly(mapping):
    assert np.array_equal(mapping(mapping.u), mapping.v)
    assert np.array_equal(mapping.inverse()(mapping.v), mapping.u)


@given(maps(), st.lists(st.floats(-50, 50), min_size=2, max_size=12))
def test_a_map_and_its_inverse_undo_each_other(mapping, points):
    x = np.array(points)
    y = mapping(x)
    steep, flat = np.max(np.abs(mapping.slopes)), np.min(np.abs(mapping.slopes))
    span = np.max(np.abs(mapping.u)) + np.max(np.abs(x))
    reach = np.max(np.abs(mapping.v)) + np.max(np.abs(y))
    assert np.max(np.abs(mapping.inverse()(y) - x)) < 4e-16 * (4 * span + reach / flat)
    assert np.max(np.abs(mapping(mapping.inverse()(y)) - y)) < 4e-16 * (4 * reach + span * steep)


@given(maps(), st.lists(st.floats(-50, 50), min_size=2, max_size=12))
def test_a_map_is_monotone(mapping, points):
    y = mapping(np.sort(points))
    rounding = 1e-14 * (np.max(np.abs(y)) + np.max(np.abs(mapping.v)))
    assert np.all(np.diff(y) * (1 if mapping.increasing else -1) >= -rounding)


@given(maps())
def test_a_map_continues_along_its_end_segments(mapping):
    ends = mapping([mapping.u[0] - 2.0, mapping.u[-1] + 3.0])
    expected = [mapping.v[0] - 2.0 * mapping.slopes[0], mapping.v[-1] + 3.0 * mapping.slopes[-1]]
    np.testing.assert_allclose(ends, expected, rtol=1e-12, atol=1e-12)


@given(maps())
def test_the_inverse_of_the_inverse_is_the_map(mapping):
    again = mapping.inverse().inverse()
    assert np.array_equal(again.u, mapping.u)
    assert np.array_equal(again.v, mapping.v)
    assert mapping.inverse().increasing == mapping.increasing
    assert mapping.inverse().inverse_gain == pytest.approx(np.max(np.abs(mapping.slopes)))


def test_the_last_breakpoint_is_met_exactly_whatever_the_digits():
    rng = np.random.default_rng(0)
    for _ in range(300):
        u, v = np.sort(rng.normal(size=(2, 4)) * 10.0 ** rng.integers(-3, 4, (2, 1)), axis=1)
        assert np.array_equal(MonotoneMap(u, v)(u), v)
