"""Unknown memory: the interval holds the truth whatever was before, is attained, and shrinks to a point."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

import dehyst
from dehyst import ModifiedPrandtlIshlinskii, PrandtlIshlinskii, StopOperatorModel
from dehyst.cli import app
from dehyst.errors import OutputError, ParameterError
from dehyst.io import write_csv
from dehyst.models import (
    DirectInverse,
    ModelCard,
    MonotoneMap,
    ShearedPrandtlIshlinskii,
    SignalCard,
    StaticCurve,
)
from dehyst_robot.control import InverseCompensator, RampedCompensator, along
from unknown_histories import contained, follow, outputs, parts, random_states, turning_path

RADII = np.array([0.0, 0.1, 0.25, 0.5, 1.0, 1.6])
WEIGHTS = np.array([1.0, 0.5, 0.4, 0.3, 0.2, 0.1])
PLAY = PrandtlIshlinskii(RADII, WEIGHTS, offset=0.3, center=-0.2)
MIXED = PrandtlIshlinskii(RADII, np.array([2.0, -0.6, 0.5, -0.9, 0.7, -0.4]), offset=-1.0)
MODELS = {
    "pi": PLAY,
    "inverse": PLAY.inverse(),
    "stop": StopOperatorModel(
        RADII, np.array([0.0, 0.5, 0.4, 0.3, 0.2, 0.1]), slope=0.7, center=0.4
    ),
    "mixed signs": MIXED,
    "saturating": ModifiedPrandtlIshlinskii(
        PLAY, after_map=MonotoneMap([-3.0, 0.0, 2.0, 5.0], [-1.0, 0.0, 2.5, 3.0])
    ),
    "falling": ModifiedPrandtlIshlinskii(
        PLAY, after_map=MonotoneMap([-3.0, 0.0, 5.0], [4.0, 0.5, -1.0])
    ),
    "map in front": ModifiedPrandtlIshlinskii(
        PLAY, before_map=MonotoneMap([-2.0, 0.0, 2.0], [-1.0, 0.2, 3.0])
    ),
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
def test_both_ends_are_attained_by_an_admissible_start_whatever_the_signs_of_the_weights(
    model, x, side
):
    start = extreme_start(model, x, side)
    low, high = model.interval(x)
    if start is None:
        assert low[-1] == pytest.approx(high[-1], abs=1e-12)
        return
    reached = model.with_state(start).simulate(x)[
        -1
    ]  # with_state refuses a state that no input produces
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
        radii=compensator.thresholds[1:],
        stop_weights=-w[1:],
        polynomial=[0.0, w.sum()],
        past="unknown",
    )
    y = turning_path(np.random.default_rng(2), 60, 0.7)
    run = direct.run(y, np.arange(y.size, dtype=float))
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


@pytest.mark.parametrize("name", MODELS)
def test_a_past_within_a_range_keeps_the_truth_and_narrows_the_interval(name):
    """Strokes from the model's start state that never leave the range."""
    model = MODELS[name]
    draw = np.random.default_rng(11)
    inner, before, _ = parts(model)
    ends = (-0.4, 0.5) if before is None else (-0.3, 0.3)
    shift = inner.center if before is None else 0.0
    past = (ends[0] + shift, ends[1] + shift)
    z = np.zeros((2000, inner.thresholds.size))
    for _ in range(15):
        x = draw.uniform(*past, 2000)
        z = follow(z, inner.thresholds, (x if before is None else before(x)) - inner.center)
    x = np.clip(turning_path(draw, 40, 0.3) + shift, *past)
    low, high = model.interval(x, past=past)
    y = outputs(model, z, x)
    slack = 1e-12 * (1 + np.abs(y).max())
    assert np.all((low - slack <= y) & (y <= high + slack))
    any_low, any_high = model.interval(x)
    assert np.all((low >= any_low - slack) & (high <= any_high + slack))
    assert (high - low)[0] < 0.9 * (any_high - any_low)[0]
    certainty = model.certainty(x, past=past)
    assert certainty[0] > 0.0
    assert np.all(np.diff(certainty) >= 0.0)


def test_a_past_range_is_attained_at_both_ends():
    x = np.array([0.1, 0.25, 0.05])
    low, high = PLAY.interval(x, past=(-0.8, 0.6))
    ends = []
    for path in (
        [-0.8, 0.1],
        [0.6, 0.1],
    ):  # from the start state down or up to the end of the range, then to x
        ends.append(PLAY.with_state(PLAY.final_state(path)).simulate(x))
    np.testing.assert_allclose([high, low], sorted(ends, key=lambda y: -y[0]), atol=1e-12)


@pytest.mark.parametrize("past", [(1.0, -1.0), (0.0,), "ab", (0.0, np.nan)])
def test_a_past_that_is_no_range_is_refused(past):
    for name in ("pi", "map in front"):
        with pytest.raises(ParameterError, match="past"):
            MODELS[name].interval([0.0], past=past)


def test_the_compensator_without_a_homing_is_the_middle_of_the_interval_and_ends_as_the_known_one():
    inverse = MODELS["compensator"]
    path = (
        np.concatenate([turning_path(np.random.default_rng(4), 30, 0.5), [-9.0, 9.0, 0.3, 0.1]])
        + inverse.center
    )
    ramped = RampedCompensator(inverse, shear=0.0)
    low, high = inverse.interval(path)
    np.testing.assert_allclose(along(ramped, path), 1e5 * (low + high) / 2, atol=1e-6)
    assert ramped.doubt == 0.0
    known = along(InverseCompensator(inverse, shear=0.0), path)
    np.testing.assert_allclose(along(ramped, path)[-3:], known[-3:], atol=1e-6)
    ramped.reset(path[0])
    assert ramped.doubt == pytest.approx(1e5 * (high - low)[0] / 2)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("unknown")
    model = MODELS["saturating"].with_card(
        ModelCard(SignalCard("p", "bar", -2.0, 2.0), SignalCard("q", "deg", -1, 3))
    )
    model.save(folder / "m.json")
    x = turning_path(np.random.default_rng(9), 80, 1.2)
    write_csv(
        folder / "log.csv",
        {"time_s": 0.1 * np.arange(x.size), "p_bar": x, "q_deg": np.clip(x, -0.5, 1.5)},
    )
    return folder


def run(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments], catch_exceptions=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "option", "column"),
    [("simulate", "--input", "p_bar"), ("compensate", "--output", "q_deg")],
)
def test_the_command_line_writes_middle_low_high_certainty_and_a_picture(
    files, tmp_path, command, option, column
):
    line = [command, files / "m.json", files / "log.csv", option, column, "--unknown-state"]
    answer = run(*line, "--figure", tmp_path / "band.svg")
    table = np.loadtxt(answer.stdout.splitlines()[1:], delimiter=",")
    model = dehyst.load(files / "m.json")
    low, high = (model if command == "simulate" else model.inverse()).interval(table[:, 1])
    np.testing.assert_allclose(
        table[:, 2:5], np.column_stack([(low + high) / 2, low, high]), rtol=1e-12
    )
    assert table[0, 5] == 0.0
    assert "memory-unknown" in answer.stderr
    picture = (tmp_path / "band.svg").read_text(encoding="utf-8")
    assert "possible, whatever was before" in picture
    assert (
        run(*line, "--figure", tmp_path / "band.svg").exit_code == 0
    )  # its own picture is drawn anew


def test_options_of_the_band_are_refused_without_it_and_a_picture_over_the_log(files):
    line = ["simulate", files / "m.json", files / "log.csv", "--input", "p_bar"]
    with pytest.raises(
        ParameterError, match=r"--past is for an actuator .*.* Leave out --past or --start model"
    ):
        run(*line, "--past", "-1", "1", "--start", "model")
    with pytest.raises(
        ParameterError,
        match=r"'rest' assumes one: at rest .* Leave out --unknown-state or --start rest",
    ):
        run(*line, "--start", "rest", "--unknown-state")
    with pytest.raises(OutputError, match="is the log or the model itself"):
        run(*line, "--unknown-state", "--figure", files / "log.csv")
    with pytest.raises(OutputError, match="neither SVG nor PNG"):
        run(*line, "--unknown-state", "--figure", files / "band.csv")


def test_a_direct_inverse_on_the_command_line_gives_the_band_of_its_own_unknown_memory(files):
    model = DirectInverse(
        radii=[0.1, 0.4], stop_weights=[1.0, 0.5], polynomial=[0.0, 0.2],
        card=ModelCard(SignalCard("p", "bar", -2.0, 2.0), SignalCard("q", "deg", -1.0, 3.0)),
    )  # fmt: skip
    model.save(files / "direct.json")
    line = [
        "compensate",
        files / "direct.json",
        files / "log.csv",
        "--output",
        "q_deg",
        "--unknown-state",
    ]
    table = np.loadtxt(run(*line).stdout.splitlines()[1:], delimiter=",")
    expected = model.with_past("unknown").run(table[:, 1], table[:, 0])
    np.testing.assert_allclose(table[:, 2], expected.u, atol=1e-12)
    np.testing.assert_allclose(table[:, 4] - table[:, 3], 2 * expected.doubt, atol=1e-12)
    assert table[0, 5] == 0.0
    assert table[-1, 5] == 1.0
    with pytest.raises(ParameterError, match="--past does not go with a direct inverse"):
        run(*line, "--past", "-1", "1")
