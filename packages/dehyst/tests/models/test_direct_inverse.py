"""The direct inverse: its definition by independent oracles, bounds for an unknown past, monotone in y, scales."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import _native
from dehyst.errors import ParameterError
from dehyst.models import (
    GROUPS,
    DirectInverse,
    ModelCard,
    RejectedSamplesWarning,
    Schedule,
    SignalCard,
)

CARD = ModelCard(SignalCard("u", "", -5.0, 5.0), SignalCard("y", "", -1.0, 1.0))


def random_model(seed, schedules=(), past="rest"):
    rng = np.random.default_rng(seed)
    sets = max(1, 2 * len(schedules))
    return DirectInverse(
        radii=np.sort(rng.uniform(0.01, 1.0, 6)),
        stop_weights=rng.uniform(0, 1, (sets, 6)),
        path_lengths=np.sort(rng.uniform(0.05, 1.0, 3)),
        path_weights=rng.uniform(0, 1, (sets, 3)),
        time_constants=[0.4, 5.0],
        creep_weights=rng.uniform(0, 1, (sets, 2)),
        polynomial=rng.normal(size=(sets, 4)),
        viscous=rng.uniform(0, 1, sets),
        center=0.1,
        schedules=schedules,
        past=past,
    )


def walk(seed, samples=400):
    rng = np.random.default_rng(seed)
    return np.cumsum(0.08 * rng.standard_normal(samples)), np.cumsum(
        rng.uniform(0.002, 0.05, samples)
    )


def by_definition(model, y, t, sigma=None):
    """Every term by its own recursion in plain Python."""
    rate = central(y, t)
    factors = shares(model, y, sigma)
    u = sum(
        (factors @ model.polynomial)[:, j] * (y - model.center) ** j
        for j in range(model.polynomial.shape[1])
    )
    for i, r in enumerate(model.radii):
        z, stop = y[0], []
        for x in y:
            z = max(x - r, min(x + r, z))
            stop.append(x - z)
        u = u + (factors @ model.stop_weights)[:, i] * stop
    for k, length in enumerate(model.path_lengths):
        value, last, lag = 0.0, y[0], []
        for x in y:
            end = np.sign(x - last) * length
            value = end + np.exp(-abs(x - last) / length) * (value - end)
            last = x
            lag.append(value)
        u = u + (factors @ model.path_weights)[:, k] * lag
    for j, tau in enumerate(model.time_constants):
        value, lag = y[0], []
        for n, x in enumerate(y):
            value += (1 - np.exp(-(t[n] - t[n - 1]) / tau)) * (x - value) if n else 0.0
            lag.append(x - value)
        u = u + (factors @ model.creep_weights)[:, j] * lag
    return u + (factors @ model.viscous) * rate


def central(y, t):
    return np.concatenate([[(y[1] - y[0]) / (t[1] - t[0])], (y[2:] - y[:-2]) / (t[2:] - t[:-2]),
                           [(y[-1] - y[-2]) / (t[-1] - t[-2])]])  # fmt: skip


def shares(model, y, sigma):
    if not model.schedules:
        return np.ones((y.size, 1))
    columns = []
    for schedule in model.schedules:
        value = sigma[schedule.name] if schedule.outside else y
        xi = np.clip((value - schedule.low) / (schedule.high - schedule.low), 0, 1)
        columns += [1 - xi, xi]
    return np.stack(columns, axis=1)


SCHEDULES = [
    (),
    (Schedule("output", -0.5, 0.7),),
    (Schedule("output", -0.5, 0.7), Schedule("p", -0.4, 0.4)),
]


@pytest.mark.parametrize("schedules", SCHEDULES, ids=["plain", "by output", "by output and p"])
def test_the_answer_is_the_sum_of_its_terms_each_by_its_own_definition(schedules):
    for seed in range(5):
        model = random_model(seed, schedules)
        y, t = walk(seed + 100)
        sigma = {"p": np.sin(t)}
        expected = by_definition(model, y, t, sigma)
        found = model.run(y, t, given=sigma if len(schedules) > 1 else None).u
        assert (
            np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()
        )  # decay() is within 1e-7


@pytest.mark.parametrize("x", [0.0, 1e-9, 0.01, 0.1, 0.5])
def test_decay_is_the_exponential_to_1e_7_in_small_steps(x):
    assert abs(_native.decay(x) / np.exp(-x) - 1) < 1e-7


@given(st.floats(0, 1e100))
def test_decay_lies_between_zero_and_one(x):
    assert 0 <= _native.decay(x) <= 1


def test_decay_is_within_two_thousandths_of_its_value_up_to_4():
    x = np.linspace(0, 4, 101)
    assert max(abs(_native.decay(v) * np.exp(v) - 1) for v in x) < 2e-3


def test_the_bank_of_an_identification_is_what_the_model_runs():
    model = random_model(3)
    y, t = walk(7)
    terms = (model.radii, model.path_lengths, model.time_constants, True)
    begun, memory = _native.direct_bank(y[:9], t[:9], *terms)  # in two parts
    bank = np.concatenate([begun, _native.direct_bank(y[9:], t[9:], *terms, memory)[0]])
    weights = np.concatenate([model.stop_weights[0], model.path_weights[0], model.creep_weights[0]])
    curve = np.polynomial.polynomial.polyval(y - model.center, model.polynomial[0])
    found = bank @ weights + curve + model.viscous[0] * central(y, t)
    assert np.abs(found - model.run(y, t).u).max() < 1e-12


@pytest.mark.parametrize("seed", range(20))
def test_the_truth_lies_within_the_doubt_whatever_the_past_was(seed):
    model = random_model(seed, SCHEDULES[seed % 2]).with_card(CARD)
    past, t_past = walk(seed + 50, 300)
    y, t = walk(seed + 60, 500)
    past, y = np.clip(past, -1, 1), np.clip(y - y[0] + past[-1], -1, 1)
    time = np.concatenate([t_past, t_past[-1] + t])
    truth = model.run(np.concatenate([past, y]), time).u[300:]
    run = model.with_past("unknown").run(y, time[300:])
    rate = model.viscous.max() * np.abs(
        central(np.concatenate([past, y]), time)[300:] - central(y, time[300:])
    )
    assert (np.abs(run.u - truth) <= run.doubt + rate + 1e-12).all()
    assert (
        np.diff(run.doubt) <= 1e-12
    ).all() or model.schedules  # with one set of weights it never grows


def test_after_a_stroke_over_twice_the_largest_radius_no_stop_is_in_doubt():
    model = DirectInverse(radii=[0.1, 0.5], stop_weights=[1.0, 2.0], past="unknown")
    y = np.linspace(0.0, 1.0, 101)
    run = model.run(y, np.arange(101.0))
    assert run.doubt[0] == 0.1 + 2 * 0.5
    assert run.doubt[-1] == 0.0


STROKES = {"rising": (1.0, -1.0), "falling": (-1.0, 1.0)}


@given(
    seed=st.integers(0, 10_000), start=st.sampled_from(list(STROKES)), first=st.floats(-2.5, 2.5)
)
@settings(max_examples=100, deadline=None)
def test_a_model_begun_after_strokes_remembers_what_the_strokes_leave_to_the_bit(
    seed, start, first
):
    """The oracle makes the strokes; a period of 1e9 s lets what creeps settle where they end."""
    model = random_model(seed).with_card(CARD)
    driven, begun = (each.core_stepper(1e9) for each in (model, model.with_past(start)))
    high_or_low, turn = STROKES[start]
    driven.reset(high_or_low)
    for y in (turn, first):
        driven(y)
    assert begun(first) == driven(first)
    assert begun.memory.tolist() == driven.memory.tolist()
    assert begun.doubt == 0.0


@given(
    seed=st.integers(0, 10_000), start=st.sampled_from(list(STROKES)), first=st.floats(-0.9, 0.9)
)
@settings(max_examples=30, deadline=None)
def test_both_directions_begin_after_the_same_strokes(seed, start, first):
    """The forward model solves, along other code, for the output that its inverse asked that input for."""
    rising = start == "rising"
    model = random_model(seed).with_card(ModelCard(SignalCard("u", "", -99.0, 99.0), CARD.output))
    # The rate is the difference from the sample before there, and that of both neighbours here.
    model = dataclasses.replace(model, polynomial=[0.0, 1.0], viscous=[0.0])
    y = first + (1.0 - abs(first)) * np.sin(np.arange(60) / 9.0)
    time = np.arange(60.0)
    u = model.inverse().after_strokes(y[0], rising).simulate(y, time)
    answered = model.after_strokes(u[0], rising).simulate(u, time)
    np.testing.assert_allclose(answered, y, atol=1e-6)
    assert np.abs(model.at_rest(u[0]).simulate(u, time) - y).max() > 1e-3


def test_a_past_that_there_is_not_is_refused():
    with pytest.raises(ParameterError, match="unknown, rest, rising, falling"):
        random_model(0, past="homed")


def test_an_unknown_past_starts_without_any_hysteresis_in_the_answer():
    model = random_model(1, past="unknown")
    assert np.abs(model.run([0.3], [0.0]).parts[0, :2]).max() < 1e-15


@pytest.mark.parametrize("seed", range(10))
def test_u_rises_with_y_at_every_moment_if_the_curve_does(seed):
    rng = np.random.default_rng(seed)
    model = random_model(seed)
    curve = np.concatenate([[0.0], rng.uniform(0.1, 1.0, 1), [0.0], rng.uniform(0, 1, 1)])
    model = DirectInverse(**{**vars(model), "polynomial": curve})
    y, t = walk(seed)
    assert model.least_slope(-9.0, 9.0) > 0
    for k in (50, 200, 399):
        ends = [
            model.run(np.append(y[:k], y[k] + d), t[: k + 1], np.zeros(k + 1)).u[-1]
            for d in (-0.1, 0, 0.1)
        ]
        assert ends[0] < ends[1] < ends[2]


def test_the_least_slope_counts_weights_that_change_with_y():
    flat = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0])
    assert flat.least_slope(-1, 1) == 1.0
    steep = DirectInverse(
        radii=[0.5], stop_weights=[[0.0], [4.0]], polynomial=[[0.0, 1.0], [0.0, 1.0]],
        schedules=(Schedule("output", -1.0, 1.0),),
    )  # fmt: skip
    assert steep.least_slope(-1, 1) == pytest.approx(1.0 - 4.0 * 0.5 / 2.0)


def test_pruning_changes_no_answer():
    model = random_model(2)
    sparse = DirectInverse(**{**vars(model), "stop_weights": np.array([[0, 1.0, 0, 0, 2.0, 0]])})
    y, t = walk(3)
    assert sparse.pruned().radii.size == 2
    assert np.abs(sparse.run(y, t).u - sparse.pruned().run(y, t).u).max() < 1e-13


def test_scales_multiply_the_parts_of_their_groups():
    model = random_model(4)
    y, t = walk(5)
    run = model.run(y, t)
    scales = np.array([0.5, 1.5, 0.0, 2.0])
    found = model.scaled(scales, offset=0.25).run(y, t).u
    assert np.abs(found - (run.u + 0.25 + run.parts @ (scales - 1))).max() < 1e-12
    assert len(GROUPS) == 4


def test_the_stepper_at_a_fixed_period_is_the_simulation():
    model = random_model(6)
    y, _ = walk(8)
    t = 1e-3 * np.arange(y.size)
    rate = central(y, t)
    run = model.run(y, t, rate)
    for at in (None, y[0]):
        step = model.core_stepper(1e-3)
        if at is not None:
            step.reset(at)
        found = [step(a, b) for a, b in zip(y, rate, strict=True)]
        assert np.abs(np.array(found) - run.u).max() < 1e-12


def test_a_stepper_begins_at_rest_at_the_first_sample_it_accepts_wherever_that_is():
    model = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0])
    step = model.core_stepper(1e-3)
    assert step(np.nan) == 0.0 and step.rejected
    assert step(20.0) == 20.0  # at rest: no stop is bent
    assert not step.rejected and step.rejected_ever
    step.reset(0.0)
    assert step(20.0) == 21.0
    assert not step.rejected_ever


def test_a_stepper_goes_on_from_an_image_to_the_bit_and_refuses_those_of_others():
    model = random_model(6, past="unknown")
    y, _ = walk(8)
    step, other = model.core_stepper(1e-3), model.core_stepper(1e-3)
    for x in y[:200]:
        step(x)
    step(np.nan)
    image = step.save()
    other.restore(image)
    assert (other.doubt, other.rejected, other.rejected_ever) == (step.doubt, True, True)
    assert other(np.nan) == step(np.nan)
    assert [other(x, 0.3) for x in y[200:]] == [step(x, 0.3) for x in y[200:]]
    unstarted = model.core_stepper(1e-3)
    unstarted.restore(model.core_stepper(1e-3).save())
    assert unstarted(0.7) == model.core_stepper(1e-3)(0.7)
    before = other.save().tolist()
    for stranger in (
        random_model(7),
        random_model(6),
        random_model(6, schedules=(Schedule("load", 0.0, 1.0),)),
    ):
        with pytest.raises(ValueError, match="belongs to"):
            other.restore(stranger.core_stepper(1e-3).save())
    with pytest.raises(ValueError, match="another period"):
        other.restore(model.core_stepper(2e-3).save())
    for place, value in ((2, 1e6), (2, 0.5), (1, 2.0), (3, np.nan), (-1, -1.0), (21, 50.0)):
        damaged = image.copy()
        damaged[place] = value
        with pytest.raises(ValueError, match="saved state"):
            other.restore(damaged)
    assert other.save().tolist() == before


def test_a_sample_that_is_not_a_number_costs_its_neighbours_nothing_and_is_told():
    model = random_model(6)
    t = 0.02 * np.arange(300)
    y = 0.7 * np.sin(t)
    whole = model.run(y, t).u
    holed = y.copy()
    holed[[0, 100, 101]] = np.nan
    with pytest.warns(RejectedSamplesWarning, match="3 of 300"):
        run = model.run(holed, t)
    assert run.u[0] == 0.0
    assert run.u[100] == run.u[101] == run.u[99]
    good = np.isfinite(holed)
    assert np.abs(run.u - whole)[good].max() < 0.02 * np.ptp(whole)
    assert (np.diff(run.u[102:110]) != 0).all()
    with pytest.warns(RejectedSamplesWarning, match="2 of 300"):
        model.run(y, t, np.where(np.arange(300) < 2, np.inf, 0.0))


def test_samples_that_are_not_numbers_are_held_and_flagged():
    step = random_model(0).core_stepper(1e-3)
    good = step(0.3, 0.1)
    memory = step.memory.tolist()
    for bad in (np.nan, np.inf, 1e101):
        assert step(bad, 0.0) == good
        assert step.rejected
        assert step(0.3, bad) == good
    assert step.memory.tolist() == memory


@given(st.lists(st.floats(allow_nan=True, allow_infinity=True, width=64), max_size=30))
def test_no_sequence_of_samples_makes_an_answer_beyond_the_limits(samples):
    model = random_model(9).with_card(CARD)
    step = model.core_stepper(1e-3)
    for x in samples:
        assert -15.0 <= step(x, x, x, x) <= 15.0


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"stop_weights": [-1.0, 1.0]}, "negative weight"),
        ({"radii": [0.5, 0.4]}, "increase strictly"),
        ({"radii": [0.0, 0.4]}, "must be positive"),
        ({"stop_weights": [1.0]}, "has shape"),
        ({"polynomial": np.ones(9)}, "takes 1 to 8"),
        ({"viscous": [1.0, 2.0]}, "has shape"),
        ({"schedules": tuple(Schedule(name, 0, 1) for name in "abcd")}, "at most 3"),
        ({"center": np.nan}, "not a finite number"),
    ],
)
def test_what_is_no_model_is_refused_with_the_cure(changes, said):
    base = {"radii": [0.1, 0.2], "stop_weights": [1.0, 1.0]}
    with pytest.raises(ParameterError, match=said):
        DirectInverse(**{**base, **changes})


def test_signals_that_do_not_fit_are_refused():
    model = random_model(0, (Schedule("p", 0.0, 1.0),))
    with pytest.raises(ParameterError, match="depends on 'p'"):
        model.run([0.0, 1.0], [0.0, 1.0])
    with pytest.raises(ParameterError, match="2 samples of y but 3 times"):
        model.run([0.0, 1.0], [0.0, 1.0, 2.0])
    with pytest.raises(ParameterError, match="runs backwards at sample 1"):
        model.run([0.0, 1.0], [1.0, 0.0], given={"p": 0.5})


def test_without_an_identified_range_signals_of_any_unit_pass_unlimited():
    model = DirectInverse(
        radii=[0.5e6], stop_weights=[2.0], polynomial=[0.0, 3.0]
    )  # in Pa and counts, say
    y = np.array([0.0, 5e6, 4e7, 3.8e7])
    assert model.run(y, np.arange(4.0)).u.tolist() == [0.0, 16e6, 121e6, 113e6]


def test_an_output_is_not_looked_for_without_a_range():
    from dehyst.models._follow import follow

    with pytest.raises(ParameterError, match="names no range"):
        follow(DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0]), [0.0, 1.0])
