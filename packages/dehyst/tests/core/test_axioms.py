"""Axioms of the play and Prandtl-Ishlinskii operators (Visintin, Brokate & Sprekels, Krejci), as properties.

Numbers are multiples of 1/256, so that most comparisons are exact: no tolerance hides a defect.
"""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst import PrandtlIshlinskii, StopOperatorModel
from oracles import main_extremes, random_walk

UNIT = 256.0
levels = st.integers(-1024, 1024).map(lambda k: k / UNIT)
histories = st.lists(levels, min_size=1, max_size=25).map(np.array)
radii = st.integers(1, 1200).map(lambda k: k / UNIT)
positive = st.integers(1, 1024).map(lambda k: k / UNIT)


@st.composite
def operators(draw, weights=positive, start=True):
    """PI operators with r_1 = 0, positive weights, and a state that some history left."""
    n = draw(st.integers(1, 8))
    gaps = draw(st.lists(st.integers(1, 200), min_size=n, max_size=n))
    r = np.concatenate([[0.0], np.cumsum(gaps[1:]) / UNIT])
    w = draw(st.lists(weights, min_size=n, max_size=n))
    model = PrandtlIshlinskii(r, w)
    return model.with_state(model.final_state(draw(histories))) if start else model


def play(x, r, z0=0.0):
    return PrandtlIshlinskii([r], [1.0], state=[z0]).simulate(x)


def refine(x, rng):
    """Insert random samples between neighbours, without new extremes; return the signal and where the old ones are."""
    out, where = [], []
    for a, b in pairwise([*x, x[-1]]):
        where.append(len(out))
        between = np.sort(rng.integers(0, 257, rng.integers(0, 4)) / 256.0)
        out += [a, *(a + (b - a) * between)]
    return np.array(out), np.array(where)


@given(operators(), histories, st.integers(0, 2**31))
def test_rate_independence_under_any_monotone_resampling(model, x, seed):
    fine, where = refine(x, np.random.default_rng(seed))
    assert np.array_equal(model.simulate(fine)[where], model.simulate(x))


@given(operators(), st.integers(1, 5), st.integers(0, 2**31))
def test_rate_independence_under_reparametrised_time(model, turns, seed):
    rng = np.random.default_rng(seed)
    knots = np.concatenate([[0.0], rng.uniform(-3, 3, turns)])
    instants = np.arange(turns + 1) / turns

    def path(time):
        return np.interp(time, instants, knots)

    warped = np.sort(np.concatenate([rng.random(60) ** 3, instants]))
    even = np.sort(np.concatenate([np.linspace(0, 1, 41), instants]))
    y_warped, y_even = model.simulate(path(warped)), model.simulate(path(even))
    for instant in instants:
        a = y_warped[np.searchsorted(warped, instant)]
        b = y_even[np.searchsorted(even, instant)]
        assert a == pytest.approx(b, abs=1e-12)


@given(operators(), histories, st.data())
def test_wiping_out_a_closed_excursion_leaves_no_memory(model, x, data):
    a, b = data.draw(levels), data.draw(levels)
    low, high = min(a, b), max(a, b)
    inside = data.draw(st.lists(levels.map(lambda v: min(max(v, low), high)), max_size=12))
    before = model.final_state([*x, a, b])
    assert np.array_equal(model.final_state([*x, a, b, *inside, b]), before)


@given(operators(start=False), histories)
def test_only_the_main_extremes_are_remembered(model, x):
    reduced = main_extremes([0.0, *x])
    assert len(reduced) <= x.size + 1
    assert np.array_equal(model.final_state(reduced), model.final_state(x))


@given(operators(), histories, histories, levels, levels)
def test_minor_loops_between_the_same_extremes_are_congruent(model, first, second, a, b):
    path = np.concatenate(
        [np.linspace(a, b, 9), np.linspace(b, a, 9)]
    )  # multiples of 1/8 of the swing: exact
    loops = []
    for prehistory in (first, second):
        y = model.simulate([*prehistory, b, a, *path])[prehistory.size + 2 :]
        loops.append(y - y[0])
        assert y[-1] == y[0]  # the loop closes
    assert np.array_equal(*loops)


@given(operators(), histories, st.data())
def test_a_larger_input_never_gives_a_smaller_output(model, x, data):
    up = data.draw(st.lists(positive, min_size=x.size, max_size=x.size))
    assert np.all(model.simulate(x + up) >= model.simulate(x))


@given(operators(), histories, histories, histories)
def test_a_larger_state_never_gives_a_smaller_output(model, x, first, second):
    a, b = model.final_state(first), model.final_state(second)
    high, low = np.maximum(a, b), np.minimum(a, b)  # both admissible: the bound is a lattice
    assert np.all(model.with_state(high).simulate(x) >= model.with_state(low).simulate(x))


@given(operators(start=False), histories)
def test_the_output_stays_below_the_initial_loading_curve(model, x):
    bound = model.loading_curve(np.max(np.abs(x)))
    assert np.all(np.abs(model.simulate(x)) <= bound * (1 + 1e-14))


@given(operators(start=False), positive)
def test_the_first_loading_follows_the_loading_curve(model, x):
    assert model.simulate([x])[0] == model.loading_curve(x)
    assert model.simulate([-x])[0] == -model.loading_curve(x)


@given(histories, radii, levels)
def test_a_play_stays_within_its_band(x, r, z0):
    z = play(x, r, z0)
    assert np.all(np.abs(z - x) <= r)


@given(histories, radii, st.integers(1, 512).map(lambda k: k / UNIT), levels)
def test_a_stop_is_the_identity_less_the_play(x, r, stiffness, z0):
    z0 = float(np.clip(z0, -r, r))  # a state that an input at 0 may leave
    stop = StopOperatorModel([0.0, r], [0.0, stiffness], slope=0.0, state=[0.0, z0]).simulate(x)
    assert np.array_equal(stop, stiffness * (x - play(x, r, z0)))
    assert np.all(np.abs(stop) <= stiffness * r)


@given(operators(), histories, st.integers(1, 4))
def test_a_repeated_sample_changes_nothing(model, x, times):
    y = model.simulate(np.repeat(x, times))
    assert np.array_equal(y, np.repeat(model.simulate(x), times))


@given(operators(), histories)
def test_the_state_carries_the_whole_past(model, x):
    half = x.size // 2
    later = model.with_state(model.final_state(x[:half])).simulate(x[half:])
    assert np.array_equal(np.concatenate([model.simulate(x[:half]), later]), model.simulate(x))


@given(histories, radii, radii)
def test_a_play_of_a_play_is_the_play_of_the_summed_radii(x, a, b):
    assert np.array_equal(play(play(x, b), a), play(x, a + b))


@given(histories, radii, radii)
def test_a_play_is_lipschitz_in_its_radius(x, a, b):
    assert np.all(np.abs(play(x, a) - play(x, b)) <= abs(a - b))


@given(histories, radii, levels, levels, st.data())
def test_a_play_is_lipschitz_in_its_input_and_state(x, r, z0, other, data):
    shifts = np.array(data.draw(st.lists(levels, min_size=x.size, max_size=x.size)))
    bound = max(np.max(np.abs(shifts)), abs(z0 - other))
    assert np.all(np.abs(play(x, r, z0) - play(x + shifts, r, other)) <= bound)


@given(operators(), histories)
def test_states_that_a_history_left_are_admissible(model, x):
    z = model.final_state(x)
    assert z[0] == x[-1]
    assert np.all(np.abs(np.diff(z)) <= np.diff(model.thresholds))


@given(operators(), histories, levels, levels)
def test_centre_and_offset_only_translate(model, x, center, offset):
    moved = PrandtlIshlinskii(model.thresholds, model.weights, offset, model.state, center)
    assert np.array_equal(moved.simulate(x + center), model.simulate(x) + offset)


@given(operators(), histories)
def test_mirrored_input_and_state_give_the_mirrored_output(model, x):
    assert np.array_equal(model.with_state(-model.state).simulate(-x), -model.simulate(x))


@given(operators(), histories, st.sampled_from([0.125, 0.5, 2.0, 64.0]))
def test_scaling_input_thresholds_and_state_scales_the_output(model, x, scale):
    scaled = PrandtlIshlinskii(scale * model.thresholds, model.weights, state=scale * model.state)
    assert np.array_equal(scaled.simulate(scale * x), scale * model.simulate(x))


@given(operators(weights=levels), operators(weights=levels), histories)
def test_the_output_is_linear_in_the_weights(first, second, x):
    n = min(first.weights.size, second.weights.size)
    r = first.thresholds[:n]
    y = [PrandtlIshlinskii(r, w).simulate(x) for w in (first.weights[:n], second.weights[:n])]
    assert np.array_equal(
        PrandtlIshlinskii(r, first.weights[:n] + second.weights[:n]).simulate(x), y[0] + y[1]
    )


@given(operators(start=False), operators(start=False), histories)
def test_one_operator_after_another_is_again_one_with_the_composed_loading_curve(outer, inner, x):
    # Corners of phi1(phi2(.)): those of phi2, and where phi2 reaches those of phi1; between them one slope each.
    reached = inner.inverse().loading_curve(outer.thresholds)
    corners = np.unique(np.concatenate([inner.thresholds, reached]))
    middles = corners + np.append(np.diff(corners) / 2, 1.0)
    slopes = (
        inner.partial_sums[np.searchsorted(inner.thresholds, middles) - 1]
        * outer.partial_sums[np.searchsorted(outer.thresholds, inner.loading_curve(middles)) - 1]
    )
    single = PrandtlIshlinskii(corners, np.diff(slopes, prepend=0.0))
    tolerance = 1e-13 * outer.loading_curve(
        inner.loading_curve(np.max(np.abs(x)))
    ) + 1e-14 * np.max(slopes)
    np.testing.assert_allclose(
        single.simulate(x), outer.simulate(inner.simulate(x)), rtol=0, atol=tolerance
    )


@given(operators(start=False), st.lists(positive, min_size=1, max_size=20))
def test_the_inverse_has_the_inverse_loading_curve(model, r):
    back = model.inverse().loading_curve(model.loading_curve(np.array(r)))
    np.testing.assert_allclose(back, r, rtol=1e-12)


def test_the_walks_of_these_tests_move_several_plays_and_leave_memory():
    rng = np.random.default_rng(0)
    r = np.linspace(0.0, 1.0, 6)
    moved, remembered, forgotten = [], [], []
    for _ in range(50):
        x = random_walk(rng, 100)
        final = PrandtlIshlinskii(r, np.ones(6)).final_state(x)
        moved.append(sum(np.ptp(play(x, radius)) > 0 for radius in r))
        forgotten.append(len(main_extremes([0.0, *x])) / 101)
        remembered.append(bool(np.any(np.abs(np.diff(final)) < 0.9 * np.diff(r))))
    assert np.median(moved) >= 4
    assert np.mean(remembered) > 0.5
    assert np.mean(forgotten) < 0.2
