"""Shortest homing: what it guarantees holds from every state before, and nothing shorter would do."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst.design import Limits, admissible, shortest_homing
from dehyst.design._homing import NODES
from dehyst.errors import ParameterError


def stop(path, radius, before):
    """Return E after a path of samples, by the definition of a stop with increments: an oracle apart from plays."""
    e = before
    for a, b in itertools.pairwise(path):
        e = min(radius, max(-radius, e + (b - a)))
    return e


def fine(points):
    """Return a path in small steps through points."""
    return np.concatenate([np.linspace(a, b, 40) for a, b in itertools.pairwise(points)])


RADII = st.lists(st.floats(0.02, 0.95), min_size=1, max_size=6, unique=True).map(sorted)
SHARES = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6)
PLACES = st.floats(-1.0, 1.0)


@given(
    radii=RADII, shares=SHARES, start=PLACES, tolerance=st.floats(0.01, 0.9), spent=st.booleans()
)
@settings(deadline=None)
def test_from_every_admissible_state_the_output_is_known_to_the_tolerance(
    radii, shares, start, tolerance, spent
):
    homing = shortest_homing(
        radii, -1.0, 1.0, Limits(1.0, 4.0), tolerance=tolerance, start=start, spent=spent
    )
    low, high = admissible(homing.points, radii)
    path = fine(homing.points)
    after = np.array([stop(path, r, share * r) for r, share in zip(radii, shares, strict=False)])
    assert (after >= low - 1e-12).all() and (after <= high + 1e-12).all()
    weights = 1 / (len(radii) * np.array(radii))
    middle = weights @ (low + high) / 2
    assert abs(weights @ after - middle) <= homing.half_width + 1e-12
    assert homing.half_width <= tolerance * (1 + 1e-9)
    if spent:
        assert weights @ np.abs(after) <= homing.residual + 1e-12
        assert homing.residual <= tolerance * (1 + 1e-9)
    assert homing.points[0] == start and np.abs(homing.points).max() <= 1.0


@given(radii=RADII, start=PLACES, ends=st.lists(PLACES, min_size=1, max_size=6))
def test_what_is_unknown_depends_on_the_span_of_a_motion_and_on_nothing_else(radii, start, ends):
    points = np.array([start, *ends])
    low, high = admissible(points, radii)
    assert np.allclose(
        high - low, np.maximum(0.0, 2 * np.array(radii) - np.ptp(points)), atol=1e-12
    )


def test_one_stroke_over_twice_the_largest_radius_makes_every_stop_known():
    radii = np.geomspace(0.004, 0.45, 30)
    homing = shortest_homing(radii, -1.0, 1.0, Limits(1.0), tolerance=1e-12, spent=False)
    assert homing.points.size == 2 and abs(homing.travel - 2 * 0.45) < 1e-9
    path = fine(homing.points)
    assert np.allclose(
        [stop(path, r, -r) for r in radii], [stop(path, r, r) for r in radii], atol=1e-9
    )


@given(
    radii=RADII,
    start=PLACES,
    ends=st.lists(PLACES, min_size=1, max_size=4),
    tolerance=st.floats(0.01, 0.9),
)
@settings(deadline=None)
def test_no_motion_that_makes_the_output_known_travels_less(radii, start, ends, tolerance):
    """Any motion at all, judged by its own guarantee, against the shortest one for the same tolerance."""
    best = shortest_homing(
        radii, -1.0, 1.0, Limits(1.0, 4.0), tolerance=tolerance, start=start, spent=False
    )
    other = np.array([start, *ends])
    low, high = admissible(other, radii)
    half = float(np.sum((high - low) / (2 * len(radii) * np.array(radii))))
    if half <= tolerance:
        assert best.travel <= np.abs(np.diff(other)).sum() + 1e-9
        limits = Limits(1.0, 4.0)
        assert best.duration <= limits.stroke_time(np.abs(np.diff(other))).sum() + 1e-9


@pytest.mark.slow
@given(
    steps=st.lists(st.integers(1, NODES), min_size=1, max_size=6, unique=True),
    first=st.floats(0.0, 1.0),
    radii=RADII,
)
@settings(deadline=None, max_examples=60)
def test_no_decaying_motion_that_spends_the_memory_takes_less_than_the_bound(steps, first, radii):
    """A random homing of the same kind, tips on the grid, sets the tolerance; the bound may not exceed its time."""
    tips = [
        (-1.0) ** k * step / NODES * radii[-1] for k, step in enumerate(sorted(steps, reverse=True))
    ]
    points = np.array([0.0, -first * radii[-1], *tips, 0.0])
    low, high = admissible(points, radii)
    left = float(np.sum(np.maximum(np.abs(low), np.abs(high)) / (len(radii) * np.array(radii))))
    limits = Limits(1.0, 4.0)
    found = shortest_homing(radii, -1.0, 1.0, limits, tolerance=left * (1 + 1e-9) + 1e-9)
    assert found.bound_s <= limits.stroke_time(np.abs(np.diff(points))).sum() + 1e-9
    assert found.bound_s <= found.duration + 1e-12


def test_tips_at_all_radii_leave_nothing():
    radii = [0.1, 0.25, 0.6]
    low, high = admissible([0.0, -0.6, 0.6, -0.25, 0.1, 0.0], radii)
    assert np.allclose(low, 0.0, atol=1e-15) and np.allclose(high, 0.0, atol=1e-15)


def test_a_tighter_tolerance_takes_longer_and_the_gap_to_the_bound_is_small():
    radii = np.geomspace(0.02, 0.95, 24)
    found = [
        shortest_homing(radii, -1.0, 1.0, Limits(1.0, 4.0), tolerance=t) for t in (0.3, 0.1, 0.03)
    ]
    assert found[0].duration < found[1].duration < found[2].duration
    assert all(each.bound_s > 0.85 * each.duration for each in found)


def test_the_homing_of_the_simulated_arm_takes_longer_and_leaves_more():
    cycle = np.arange(18)  # nine cycles that decay by 0.7 each: [homing] of the packaged arm
    old = np.concatenate([[0.0], (-1.0) ** cycle * 0.7 ** (0.5 * cycle), [0.0]])
    radii = np.geomspace(0.02, 0.95, 24)
    low, high = admissible(old, radii)
    left = float(np.mean(np.maximum(np.abs(low), np.abs(high)) / radii))
    limits = Limits(1.0, 4.0)
    found = shortest_homing(radii, -1.0, 1.0, limits, tolerance=left)
    assert found.duration < 0.5 * limits.stroke_time(np.abs(np.diff(old))).sum()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"radii": [0.5, 0.0]}, "positive"),
        ({"radii": []}, "one at least"),
        ({"weights": [1.0]}, "1 weights for 2 radii"),
        ({"weights": [1.0, -1.0]}, "zero or more"),
        ({"tolerance": 0.0}, "Pass a positive"),
        ({"tolerance": float("nan")}, "Pass a positive"),
        ({"low": 1.0}, "low < high"),
        ({"start": 2.0}, "outside the range"),
        ({"end": float("nan")}, "outside the range"),
        ({"radii": [0.5, 3.0], "tolerance": 0.01}, "Allow a wider range"),
        ({"radii": [0.5, 3.0], "tolerance": 0.01, "spent": False}, "Allow a wider range"),
    ],
)
def test_what_cannot_be_homed_is_refused_with_a_cure(change, words):
    given = {"radii": [0.2, 0.5], "low": -1.0, "high": 1.0, "limits": Limits(1.0), **change}
    with pytest.raises(ParameterError, match=words):
        shortest_homing(**given)


@pytest.mark.parametrize(
    "bad", [{"rate": 0.0}, {"rate": float("inf")}, {"rate": 1.0, "acceleration": float("nan")}]
)
def test_limits_that_let_nothing_move_are_refused(bad):
    with pytest.raises(ParameterError, match="nothing could move"):
        Limits(**bad)
