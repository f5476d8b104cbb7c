"""Unknown memory: the interval holds the truth whatever was before, is attained, and shrinks to a point."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst import (
    ModifiedPrandtlIshlinskii,
    PrandtlIshlinskii,
    ShearedPrandtlIshlinskii,
    StaticCurve,
    StopOperatorModel,
)
from dehyst.errors import ParameterError
from dehyst.models import DirectInverse, MonotoneMap
from unknown_histories import contained, outputs, random_states, turning_path

RADII = np.array([0.0, 0.1, 0.25, 0.5, 1.0, 1.6])
WEIGHTS = np.array([1.0, 0.5, 0.4, 0.3, 0.2, 0.1])
PLAY = PrandtlIshlinskii(RADII, WEIGHTS, offset=0.3, center=-0.2)
MIXED = PrandtlIshlinskii(RADII, np.array([2.0, -0.6, 0.5, -0.9, 0.7, -0.4]), offset=-1.0)
MODELS = {
    "pi": PLAY,
    "inverse": PLAY.inverse(),
    "stop": StopOperatorModel(RADII, np.array([0.0, 0.5, 0.4, 0.3, 0.2, 0.1]), slope=0.7, center=0.4),
    "mixed signs": MIXED,
    "saturating": ModifiedPrandtlIshlinskii(PLAY, after=MonotoneMap([-3.0, 0.0, 2.0, 5.0], [-1.0, 0.0, 2.5, 3.0])),
    "falling": ModifiedPrandtlIshlinskii(PLAY, after=MonotoneMap([-3.0, 0.0, 5.0], [4.0, 0.5, -1.0])),
    "map in front": ModifiedPrandtlIshlinskii(PLAY, before=MonotoneMap([-2.0, 0.0, 2.0], [-1.0, 0.2, 3.0])),
    "sheared": ShearedPrandtlIshlinskii(PLAY, shear=0.1),
    "compensator": ShearedPrandtlIshlinskii(PLAY, shear=2.0).inverse(),
}


@pytest.mark.parametrize("name", MODELS)
def test_the_interval_holds_the_truth_in_ten_thousand_of_ten_thousand_random_histories(name):
    assert contained(MODELS[name], histories=10_000, samples=40, seed=7) == 10_000


def test_the_count_sees_an_interval_that_is_too_narrow():
    assert contained(PLAY, histories=1000, samples=40, seed=7, shrink=0.8) < 1000


@st.composite
def operators(draw):
    n = draw(st.integers(1, 7))
    gaps = draw(st.lists(st.floats(0.01, 1.0), min_size=n, max_size=n))
    weights = draw(st.lists(st.floats(-2.0, 2.0), min_size=n, max_size=n))
    first = draw(st.sampled_from([0.0, 0.3]))
    return PrandtlIshlinskii(
        np.cumsum([first, *gaps[1:]]), weights, draw(st.floats(-1, 1)), None, draw(st.floats(-1, 1))
    )


signals = st.lists(st.floats(-3, 3), min_size=1, max_size=25).map(np.array)


@given(operators(), signals, signals)
def test_the_interval_holds_the_truth_for_any_operator_any_past_and_any_input(model, past, x):
    # A state from somewhere, then a past, then x: before x nobody knew anything.
    y = model.with_state(model.final_state(past)).simulate(x)
    low, high = model.interval(x)
    slack = 1e-12 * (1 + np.abs(y).max())
    assert np.all(low - slack <= y)
    assert np.all(y <= high + slack)


@given(operators(), signals)
def test_width_never_grows_and_certainty_never_falls(model, x):
    low, high = model.interval(x)
    width = high - low
    assert np.all(np.diff(width) <= 1e-11 * (1 + width[0]))
    certainty = model.certainty(x)
    assert np.all((certainty >= 0.0) & (certainty <= 1.0))
    assert np.all(np.diff(certainty) >= 0.0)


@given(operators(), signals, st.floats(-3, 3))
def test_the_interval_is_a_point_from_a_stroke_of_twice_the_largest_radius_on(model, x, begin):
    reach = 2.0 * model.thresholds[-1] * (1 + 1e-9) + 1e-9
    path = np.concatenate([x, [begin, begin + reach], x])
    low, high = model.interval(path)
    after = slice(x.size + 1, None)
    np.testing.assert_array_equal(low[after], high[after])
    np.testing.assert_array_equal(model.certainty(path)[after], 1.0)
    size = np.abs(model.weights) @ (model.thresholds + 10.0)
    np.testing.assert_allclose(low[after], model.simulate(path)[after], rtol=0, atol=1e-13 * size)


def extreme_start(model, x, side):
    """Admissible start state that brings the output after x to an end of its interval, by the formula's increments."""
    r, w, v = model.thresholds, model.weights, x - model.center
    top, bottom = v.max(), v.min()
    a, middle = (top - bottom) / 2, (top + bottom) / 2
    free = np.flatnonzero(r > a)
    if not free.size:
        return None
    tails = np.cumsum(w[::-1])[::-1][free]
    steps = np.diff(np.concatenate([[a], r[free]]))
    late = middle + side * np.cumsum(np.sign(tails) * steps)
    z = np.clip(late[0], v[0] - r, v[0] + r)
    z[free] = late
    return z


@given(operators(), signals, st.sampled_from([-1.0, 1.0]))
def test_both_ends_are_attained_by_an_admissible_start_whatever_the_signs_of_the_weights(model, x, side):
    start = extreme_start(model, x, side)
    low, high = model.interval(x)
    if start is None:
        assert low[-1] == pytest.approx(high[-1], abs=1e-12)
        return
    reached = model.with_state(start).simulate(x)[-1]  # with_state refuses a state that no input produces
    size = np.abs(model.weights) @ (model.thresholds + 10.0)
    assert reached == pytest.approx(high[-1] if side > 0 else low[-1], abs=1e-11 * size)


def per_operator(model, x):
    """What each play allows by itself, summed: an interval that forgets that neighbours hang together."""
    low, high = (np.stack([play(x, r, x[0] + s * r) for r in model.thresholds], 1) for s in (-1, 1))
    w = model.weights
    return np.where(w > 0, low, high) @ w, np.where(w > 0, high, low) @ w


def play(x, r, z):
    out = np.empty(x.size)
    for k, value in enumerate(x):
        z = max(value - r, min(value + r, z))
        out[k] = z
    return out


def test_play_by_play_bounds_are_as_tight_for_weights_of_one_sign_and_three_times_too_wide_for_mixed_ones():
    x = np.array([0.0, 0.3, -0.1, 0.2])
    for model, over in ((PLAY, (1.0, 1.0)), (PLAY.inverse(), (1.0, 1.0)), (MIXED, (2.0, 5.0))):
        plain = type(model)(model.thresholds, model.weights)
        low, high = plain.interval(x)
        naive_low, naive_high = per_operator(plain, x)
        ratio = (naive_high - naive_low)[-1] / (high - low)[-1]
        assert over[0] - 1e-9 <= ratio <= over[1] + 1e-9


@given(operators(), st.floats(0.0, 3.0), signals, signals)
def test_what_is_known_is_used_and_the_rest_may_be_anything(model, known, past, x):
    """Two pasts agree up to a radius: a homing by strokes up to it makes them so."""
    homing = model.center + known * np.array([1.0, -1.0] * 3 + [0.0])
    state = model.final_state(np.concatenate([past + model.center, homing]))
    told = model.with_state(state)
    low, high = told.interval(x, known)
    y = told.simulate(x)
    slack = 1e-12 * (1 + np.abs(y).max())
    assert np.all((low - slack <= y) & (y <= high + slack))
    other = state.copy()
    sure = int(np.searchsorted(model.thresholds, known, side="right"))
    if sure:  # any other state that agrees up to the radius, here the lowest
        other[sure:] = state[sure - 1] - (model.thresholds[sure:] - model.thresholds[sure - 1])
        y = model.with_state(other).simulate(x)
        assert np.all((low - slack <= y) & (y <= high + slack))
    assert np.all(high - low <= np.subtract(*model.interval(x)[::-1]) + 1e-9) or sure


def test_a_homing_up_to_the_largest_radius_leaves_nothing_unknown():
    x = np.linspace(-0.2, 0.5, 20)
    low, high = PLAY.interval(x, known=RADII[-1])
    np.testing.assert_array_equal(low, high)
    np.testing.assert_allclose(low, PLAY.simulate(x), atol=1e-14)
    half = PLAY.interval(x, known=0.5)
    none = PLAY.interval(x)
    assert 0.0 < (half[1] - half[0])[0] < (none[1] - none[0])[0]


def test_the_middle_of_the_compensator_is_the_direct_inverse_of_the_core_with_unknown_memory():
    """Another implementation, in C, that follows each stop's lowest and highest play."""
    compensator = ShearedPrandtlIshlinskii(PrandtlIshlinskii(RADII, WEIGHTS), shear=1.0).inverse()
    w = compensator.weights
    direct = DirectInverse(
        radii=compensator.thresholds[1:], stop_weights=-w[1:], polynomial=[0.0, w.sum()], known=False
    )
    y = turning_path(np.random.default_rng(2), 60, 0.7)
    run = direct.simulate(y, np.arange(y.size, dtype=float))
    low, high = compensator.interval(y)
    np.testing.assert_allclose(run.u, (low + high) / 2, atol=1e-11)
    np.testing.assert_allclose(run.doubt, (high - low) / 2, atol=1e-11)


def test_samples_that_are_not_finite_change_nothing_and_before_the_first_nothing_is_known():
    x = np.array([np.nan, np.inf, 0.2, np.nan, 0.9, 0.1])
    low, high = PLAY.interval(x)
    assert np.all(np.isinf(low[:2]) & np.isinf(high[:2]))
    clean = PLAY.interval(np.array([0.2, 0.2, 0.9, 0.1]))
    np.testing.assert_array_equal(low[2:], clean[0])
    np.testing.assert_array_equal(high[2:], clean[1])
    np.testing.assert_array_equal(PLAY.certainty(x)[:2], 0.0)


def test_a_curve_has_no_memory_to_be_unknown():
    curve = StaticCurve(MonotoneMap([0.0, 1.0], [0.0, 2.0]))
    low, high = curve.interval([0.2, 0.7])
    np.testing.assert_array_equal(low, high)
    np.testing.assert_array_equal(low, curve.simulate([0.2, 0.7]))
    np.testing.assert_array_equal(curve.certainty([0.2, 0.7]), 1.0)


def test_a_negative_radius_is_refused():
    with pytest.raises(ParameterError, match="radius up to which"):
        PLAY.interval([0.0], known=-1.0)


def test_the_oracle_steps_as_the_model_does():
    x = turning_path(np.random.default_rng(1), 30, 1.5)
    states = random_states(np.random.default_rng(0), PLAY, 5)
    for name in ("pi", "saturating", "map in front"):
        model = MODELS[name]
        y = outputs(model, states, x)
        for k in range(5):
            np.testing.assert_allclose(model.with_state(states[k]).simulate(x), y[k], atol=1e-12)
