"""What the residual follows: each cause is found where it is, noise explains nothing, and its floor is told."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst.data import turning_points
from dehyst.findings import Grade
from dehyst.identification._residual import CAUSES, residual_structure
from dehyst.report._figures import all_figures
from dehyst.report._figures.residuals import SMALL_ENOUGH

MODEL = dehyst.PrandtlIshlinskii([0.0, 0.2, 0.4, 0.6], [0.6, 0.4, 0.3, 0.2])
STEP = 0.06


def strokes(seconds=300.0, seed=0, step=STEP):
    """Strokes of all sizes and speeds, every fifth followed by a rest."""
    rng, time, place = np.random.default_rng(seed), [0.0], [0.0]
    while time[-1] < seconds:
        to = rng.uniform(0.2, 1.0) * (-1.0) ** (len(place) % 2)
        time.append(time[-1] + rng.uniform(0.5, 4.0))
        place.append(to)
        if rng.random() < 0.2:
            time.append(time[-1] + rng.uniform(1.0, 4.0))
            place.append(to)
    t = np.arange(0.0, seconds, step)
    return t, np.interp(t, time, place)


def since_turn(t, x):
    """Time since the last turn, and which way the input goes since; sample by sample."""
    turns = turning_points(x, 0.1).tolist()
    since, way = np.empty(t.size), np.empty(t.size)
    for first, last in itertools.pairwise(turns):
        since[first : last + 1] = t[first : last + 1] - t[first]
        way[first : last + 1] = np.sign(x[last] - x[first])
    return since, way


def crept(t, x, tau=1.5):
    lag, out = x[0], np.empty(t.size)
    for k, value in enumerate(x):
        lag += (1.0 - math.exp(-STEP / tau)) * (value - lag)
        out[k] = lag - value
    return out


LEFT = {
    "offset": lambda t, x, f: np.full(t.size, 0.01),
    "drift": lambda t, x, f: 0.02 * np.sin(t / 75.0),
    "position": lambda t, x, f: 0.01 * np.cos(4.0 * x),
    "way-since-turn": lambda t, x, f: 0.03 * since_turn(t, x)[1] * np.exp(-5.0 * way_of(x)),
    "time-since-turn": lambda t, x, f: 0.02 * crept(t, x),
    "rate": lambda t, x, f: 0.01 * np.gradient(x, t),
    "delay": lambda t, x, f: np.interp(t - 0.05, t, f) - f,
}


def way_of(x):
    turns = turning_points(x, 0.1)
    at = np.searchsorted(turns, np.arange(x.size), side="right") - 1
    return np.abs(x - x[turns[at]])


def found(t, x, f, e, time=True, **more):
    record = dehyst.Recording(input=x, output=f + e, time=t if time else None)
    return residual_structure(
        [record], [f], [np.arange(x.size) >= x.size // 2], float(np.ptp(f)), **more
    )


def noise(like, ratio, seed=1):
    size = np.std(like) or np.max(np.abs(like))
    return np.random.default_rng(seed).normal(0.0, ratio * size, like.size)


@pytest.mark.parametrize("cause", [*LEFT, "after-turn"])
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("time", [True, False])
def test_a_residual_is_given_to_its_cause_beside_noise(cause, seed, time):
    t, x = strokes(seed=seed)
    f = MODEL.simulate(x)
    if cause == "after-turn":
        since, way = since_turn(t, x)
        e, cause = -0.02 * way * np.exp(-since / 0.7), "time-since-turn"
    else:
        e = LEFT[cause](t, x, f)
    says = found(t, x, f, e + noise(e, 0.5), time)
    half = e[t.size // 2 :]
    true = np.mean(half**2) / (np.mean(half**2) + 0.25 * (np.std(e) or np.max(np.abs(e))) ** 2)
    largest = says.largest
    assert largest.name == cause
    assert largest.share == pytest.approx(true, abs=0.12)
    assert largest.size_percent == pytest.approx(says.rms_percent * math.sqrt(largest.share))
    assert says.explained >= largest.share - 1e-12
    assert (
        f"{100.0 * largest.share:.0f} % of the model's squared error {largest.words}"
        in says.suggestions[0]
    )


@pytest.mark.parametrize("samples", [400, 2000, 5000])
@pytest.mark.parametrize("seed", range(6))
def test_noise_follows_nothing(samples, seed):
    t, x = strokes(STEP * samples, seed)
    f = MODEL.simulate(x)
    says = found(t, x, f, np.random.default_rng(seed).normal(0.0, 0.01, t.size))
    assert [cause.name for cause in says.causes] == list(CAUSES)
    assert all(cause.share < 0.06 for cause in says.causes)
    assert says.noise_share > 0.6 and "noise" in says.suggestions[-1]


@pytest.mark.parametrize("wave", [np.sin, lambda a: 2.0 / np.pi * np.arcsin(np.sin(a))])
def test_the_noise_floor_is_what_repeated_strokes_differ_by(wave):
    t = np.arange(0.0, 240.0, STEP)
    x = wave(2.0 * np.pi * t / 6.0)
    f = MODEL.simulate(x)
    repeated = (
        0.05 * np.cos(9.0 * x) * np.sign(np.gradient(x))
    )  # the model's own fault, alike in every cycle
    slow = np.convolve(
        np.random.default_rng(3).normal(0.0, 0.01, t.size + 4), np.ones(5) / math.sqrt(5.0), "valid"
    )
    says = found(
        t, x, f, repeated + slow
    )  # differences from sample to sample see little of such noise
    assert says.noise_from == "repeats"
    assert says.noise_percent == pytest.approx(1.0 / np.ptp(f), rel=0.2)


def test_without_repeats_the_floor_is_what_jumps_from_sample_to_sample():
    t, x = strokes()
    f = MODEL.simulate(x)
    says = found(
        t, x, f, 0.02 * np.cos(4.0 * x) + np.random.default_rng(0).normal(0.0, 0.005, t.size)
    )
    assert says.noise_from == "differences"
    assert says.noise_percent == pytest.approx(0.5 / np.ptp(f), rel=0.2)


def test_a_delay_has_its_size_and_its_sign():
    t, x = strokes()
    f = MODEL.simulate(x)
    for late in (0.05, -0.08):
        assert found(t, x, f, np.interp(t - late, t, f) - f).delay == pytest.approx(late, rel=0.1)
        assert found(t, x, f, np.interp(t - late, t, f) - f, False).delay == pytest.approx(
            late / STEP, rel=0.1
        )


@pytest.mark.slow
@given(
    st.sampled_from(list(LEFT)),
    st.floats(-3, 3),
    st.floats(-3, 3),
    st.booleans(),
    st.integers(0, 20),
)
@settings(max_examples=40, deadline=None)
def test_units_signs_and_offsets_change_nothing(cause, a, b, turned, seed):
    t, x = strokes(60.0, seed)
    f = MODEL.simulate(x)
    e = LEFT[cause](t, x, f)
    e = e + noise(e, 0.3)
    sign, scale, far = (-1.0) ** turned, 10.0**a, 10.0**b
    one = found(t, x, f, e)
    other = found(
        scale * t + 1e3, sign * far * x + 3.0, sign * scale * f - 70.0 * scale, sign * scale * e
    )
    for mine, yours in zip(one.causes, other.causes, strict=True):
        assert (yours.share, yours.own) == pytest.approx((mine.share, mine.own), abs=1e-3)
    assert (one.rms_percent, one.explained) == pytest.approx(
        (other.rms_percent, other.explained), rel=1e-3
    )
    assert other.noise_percent == pytest.approx(one.noise_percent, rel=1e-2)


def test_pieces_and_recordings_are_seen_each_with_its_own_turns():
    t, x = strokes()
    f = MODEL.simulate(x)
    e = LEFT["time-since-turn"](t, x, f)
    cut = (1000, 2500)
    one = dehyst.Recording(input=x, output=f + e, time=t, breaks=cut)
    two = dehyst.Recording(input=x[2500:], output=(f + e)[2500:], time=t[2500:] - 70.0)
    says = residual_structure(
        [one, two], [f, f[2500:]], [t >= 0.0, t[2500:] > 200.0], float(np.ptp(f))
    )
    assert says.largest.name == "time-since-turn"
    assert says.largest.share > 0.8


def test_too_few_samples_and_nothing_but_rounding_say_nothing():
    t, x = strokes(9.0)
    f = MODEL.simulate(x)
    few, exact = (
        found(t, x, f, 0.01 * x),
        found(*strokes(), f := MODEL.simulate(strokes()[1]), 1e-15 * f),
    )
    for says in (few, exact):
        assert (says.causes, says.largest, says.noise_share, says.suggestions) == (
            (),
            None,
            None,
            (),
        )


def test_where_all_is_fitted_already_no_more_is_asked_to_be():
    t, x = strokes()
    f = MODEL.simulate(x)
    e = LEFT["position"](t, x, f)
    held, fitted = (found(t, x, f, e, part=part).suggestions[0] for part in ("held-out", "fitted"))
    assert "(--train-fraction), or see whether another family" in held
    assert "--train-fraction" not in fitted and "See whether another family does better" in fitted


def test_a_long_log_is_looked_at_in_part_and_says_the_same():
    says = []
    for step in (STEP, STEP / 50.0):
        t, x = strokes(600.0, step=step)
        f = MODEL.simulate(x)
        e = 0.01 * np.cos(4.0 * x)
        says.append(found(t, x, f, e + noise(e, 0.5)))
    assert t.size >= 500_000
    assert says[1].largest.name == says[0].largest.name == "position"
    assert says[1].largest.share == pytest.approx(says[0].largest.share, abs=0.02)
    assert says[1].noise_percent == pytest.approx(says[0].noise_percent, rel=0.05)


@pytest.mark.parametrize(
    "family", ["static", "pi", "play-sum", "dahl", pytest.param("auto", marks=pytest.mark.slow)]
)
@pytest.mark.parametrize("time", [True, False])
def test_every_fit_says_it_in_its_report_and_its_json(family, time):
    t, x = strokes(90.0)
    y = (
        MODEL.simulate(x)
        + LEFT["time-since-turn"](t, x, x)
        + np.random.default_rng(0).normal(0.0, 0.003, t.size)
    )
    fit = dehyst.identify(dehyst.Recording(input=x, output=y, time=t if time else None), family)
    assert fit.residual is fit.residual
    assert fit.as_dict()["residual"] == fit.residual.as_dict()
    assert fit.residual.part == "held-out"
    assert fit.residual.rms_percent == pytest.approx(fit.test.rmse_percent, rel=1e-6)
    figure = next(figure for figure in all_figures(fit) if figure.key == "structure")
    # Beside a good verdict the figure says first that nothing has to be done.
    first = (SMALL_ENOUGH,) if fit.grade is Grade.GOOD else ()
    assert figure.points == (*first, *fit.residual.suggestions)
    assert len(figure.table.rows) >= len(CAUSES) + 1


def test_what_was_fitted_is_looked_at_where_nothing_was_held_out():
    x = strokes(90.0)[1]
    fit = dehyst.identify(
        dehyst.Recording(input=x, output=MODEL.simulate(x) + 0.02 * x**2), "pi", train_fraction=1.0
    )
    assert fit.residual.part == "fitted"
    assert fit.residual.rms_percent == pytest.approx(fit.train.rmse_percent, rel=1e-6)


@pytest.mark.parametrize(("timed", "knows", "words"), [
    (False, False, "time stamps"), (True, False, "knows creep (--family"), (True, True, "longer rests"),
])  # fmt: skip
def test_the_cure_of_creep_depends_on_what_log_and_model_know(timed, knows, words):
    t, x = strokes()
    f = MODEL.simulate(x)
    creep = {"knows_time": knows, "confirmed": ["time-since-turn"] if timed else []}
    assert words in found(t, x, f, LEFT["time-since-turn"](t, x, f), timed, **creep).suggestions[0]


@pytest.mark.parametrize("cause", ["time-since-turn", "rate", "delay"])
def test_without_a_test_of_its_own_no_cause_is_named(cause):
    t, x = strokes()
    f = MODEL.simulate(x)
    [seen] = found(t, x, f, LEFT[cause](t, x, f)).suggestions[:1]
    [named] = found(t, x, f, LEFT[cause](t, x, f), confirmed=[cause]).suggestions[:1]
    assert (
        seen != named
        and "does not show" in seen
        and not {"one clock", "knows creep", "knows the rate"} & {seen}
    )
    assert "one clock" not in seen and "--family mixed-sum" not in seen


@pytest.mark.parametrize(("hertz", "damped"), [(5.0, 0.0), (7.3, 0.02), (3.1, 0.05)])
@pytest.mark.parametrize("seed", range(3))
def test_a_residual_that_rings_is_said_with_its_frequency(hertz, damped, seed):
    t, x = strokes(seed=seed)
    f = MODEL.simulate(x)
    e, phase = np.zeros(t.size), 2.0 * np.pi * hertz * t
    for turn in [0, *turning_points(x, 0.1).tolist()] if damped else [0]:  # each turn rings anew
        after = t[turn:] - t[turn]
        e[turn:] += (
            0.01
            * np.exp(-damped * 2.0 * np.pi * hertz * after)
            * np.sin(phase[turn:] - phase[turn])
        )
    says = found(t, x, f, e + noise(e, 0.5))
    assert says.peak is not None and says.peak.frequency == pytest.approx(hertz, rel=0.05)
    assert says.peak.low <= hertz <= says.peak.high and 0.3 < says.peak.share <= 1.0
    assert any(f"around {says.peak.frequency:.4g} Hz" in sentence for sentence in says.suggestions)
    assert not any("was not logged" in sentence for sentence in says.suggestions)


@pytest.mark.parametrize("cause", LEFT)
@pytest.mark.parametrize("seed", range(3))
def test_no_other_residual_has_a_peak(cause, seed):
    t, x = strokes(seed=seed)
    f = MODEL.simulate(x)
    e = LEFT[cause](t, x, f)
    assert found(t, x, f, e + noise(e, 0.3)).peak is None
    assert found(t, x, f, noise(f, 0.01)).peak is None
