"""Designed excitation: limits are kept, every stop is reached from both sides, creep and rate can be told apart."""

import itertools
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst.design import (
    CYCLES,
    UNSEEN_TIPS,
    Limits,
    design_drift_motion,
    design_excitation,
    lags,
    separability,
)
from dehyst.design._plan import HOMED, HOMED_RADII
from dehyst.design._policy import POLICY
from dehyst.design._separability import OCTAVES, columns
from dehyst.errors import ParameterError
from dehyst.monitoring._groups import cycles_of, groups_of
from dehyst.monitoring._logs import MOST_GROUPS

PLAN = design_excitation(-30.0, 50.0, rate=40.0, time_limit=500.0, unit="deg")
RADII = 40.0 * np.geomspace(0.004, 0.95, 30)  # those of a direct inverse over this range


def shares(points):
    return (np.asarray(points) - 10.0) / 40.0


def ends(kind):
    """Return (start, tip) of all strokes of a part."""
    starts = PLAN.points[:-1]
    parts = [section.part for section in PLAN.sections for _ in section.tips]
    return [
        (a, b) for a, b, part in zip(starts, PLAN.points[1:], parts, strict=True) if part == kind
    ]


@pytest.mark.slow
@given(
    low=st.floats(-100.0, 100.0), width=st.floats(0.01, 200.0), stroke=st.floats(0.5, 6.0), more=st.floats(1.05, 4.0),
    damp=st.floats(0.5, 20.0),
)  # fmt: skip
@settings(deadline=None, max_examples=6)
def test_every_plan_stays_within_range_rate_acceleration_and_time(low, width, stroke, more, damp):
    rate, acceleration = 35 / 16 * width / stroke, damp * width / stroke**2
    with pytest.raises(ParameterError) as refused:
        design_excitation(
            low, low + width, rate=rate, acceleration=acceleration, time_limit=1.0, period=0.001
        )
    limit = more * refused.value.facts["needed"]
    plan = design_excitation(
        low, low + width, rate=rate, acceleration=acceleration, time_limit=limit, period=0.001
    )
    period = plan.duration / 5e4
    _, value, _ = plan.signal(period)
    slack = 1e-9 * (abs(low) + width)
    assert plan.duration <= limit + 1e-9
    assert low - slack <= value.min() and value.max() <= low + width + slack
    assert np.abs(np.diff(value)).max() / period <= rate * (1 + 1e-6) + slack / period
    assert plan.peak_rate <= rate * (1 + 1e-12) and plan.peak_acceleration <= acceleration * (
        1 + 1e-9
    )
    assert value[0] == plan.middle and value[-1] == plan.middle


def test_peak_rate_and_acceleration_are_those_of_the_samples():
    time, value, _ = PLAN.signal(0.001)
    rate = np.gradient(value, 0.001)
    assert np.abs(rate).max() == pytest.approx(PLAN.peak_rate, rel=1e-5)
    assert np.abs(np.gradient(rate, 0.001)).max() == pytest.approx(PLAN.peak_acceleration, rel=1e-2)
    assert time[-1] == pytest.approx(PLAN.duration, abs=0.001)


def test_every_stop_is_driven_to_both_ends_and_turned_inside_in_each_half():
    _, value, part = PLAN.signal()
    fitted = np.isin(part, ["loops", "holds"])
    y = shares(value[fitted])
    stops = columns(y, PLAN.period, radii=RADII / 40.0)["stops"]
    turns = (
        np.flatnonzero(
            (np.diff(y)[:-1] != 0) & (np.sign(np.diff(y)[1:]) != np.sign(np.diff(y)[:-1]))
        )
        + 1
    )
    half = y.size // 2
    for rows in (slice(0, half), slice(half, None)):
        reached = stops[rows] / (RADII / 40.0)
        assert (reached.max(axis=0) > 1 - 1e-6).all() and (reached.min(axis=0) < -1 + 1e-6).all()
    inside = np.abs(stops[turns] / (RADII / 40.0)) < 0.95
    held = 0.5 * min(abs(b - a) for a, b in ends("loops") if PLAN.middle not in (a, b)) < RADII
    assert inside.any(axis=0)[
        held
    ].all()  # a branch that returns before the stop slips, for all but the finest


def test_minor_loops_of_one_size_stand_at_three_places_and_on_both_branches():
    ways = [(round(float(shares(a)), 9), round(float(shares(b)), 9)) for a, b in ends("loops")]
    size = [(min(a, b), a < b) for a, b in ways if abs(abs(b - a) - 0.4) < 1e-9]
    assert {(low, rising) for low, rising in size} >= {
        (low, rising) for low in (0.5, -0.2, -0.9) for rising in (True, False)
    }


def test_the_same_loops_come_at_two_rates_a_decade_apart():
    steps = np.abs(np.diff(PLAN.points)), PLAN.stroke_s
    parts = np.array([section.part for section in PLAN.sections for _ in section.tips])
    mean = (steps[0] / steps[1])[parts == "loops"]
    peak = 35 / 16 * mean
    slow = [s for s in PLAN.sections if "tenth" in s.why]
    assert peak.max() == pytest.approx(PLAN.limits.rate)
    assert len(slow) == 1
    first = abs(slow[0].tips[1] - slow[0].tips[0]) / slow[0].stroke_s[1] * 35 / 16
    assert first == pytest.approx(PLAN.limits.rate / 10)


def test_holds_are_log_spaced_and_at_places_on_both_sides():
    holds = [section for section in PLAN.sections if section.part == "holds"]
    assert len(holds) == 2
    for section in holds:
        times = [t for t in section.hold_s if t > 0]
        assert len(times) >= 2 and np.allclose(np.array(times[1:]) / np.array(times[:-1]), 3.0)
        places = shares([tip for tip, t in zip(section.tips, section.hold_s, strict=True) if t > 0])
        assert places.min() < 0 < places.max() and len(set(places.round(6))) == places.size


def test_the_second_half_mirrors_the_first_so_that_creep_to_either_side_cancels():
    _, value, part = PLAN.signal(PLAN.duration / 40000)
    y = shares(value[np.isin(part, ["loops", "holds"])])
    assert abs(y.mean()) < 1e-3 * np.abs(y).mean()
    first = [s for s in PLAN.sections if s.part in ("loops", "holds")]
    for a, b in zip(first[:3], first[3:], strict=True):
        assert (
            np.allclose(shares(a.tips), -shares(b.tips))
            and a.hold_s == b.hold_s
            and a.stroke_s == b.stroke_s
        )


def test_the_test_part_holds_no_loop_that_is_fitted():
    fitted = {
        tuple(np.round(shares(each), 6)) for kind in ("loops", "holds") for each in ends(kind)
    }
    tested = [tuple(np.round(shares(each), 6)) for each in ends("test")]
    assert not fitted & set(tested)
    assert np.allclose(shares([b for _, b in ends("test")])[:-1], UNSEEN_TIPS)


def test_after_the_last_part_the_memory_is_spent_whatever_it_was():
    _, value, part = PLAN.signal()
    last = np.flatnonzero(part != "home")[-1]
    y = shares(value[last:])
    radii = np.geomspace(*HOMED, HOMED_RADII)
    held = [-radii, radii]
    for step in np.diff(y):
        held = [np.clip(e + step, -radii, radii) for e in held]
    assert np.abs(np.array(held) / radii).mean() <= POLICY.homing_left + 1e-4


def test_creep_rate_and_hysteresis_are_told_apart_and_by_one_loop_they_are_not():
    assert PLAN.separable.smallest > 10 * PLAN.one_loop.smallest
    assert PLAN.separable.creep > 10 * PLAN.one_loop.creep
    assert PLAN.separable.rate > 0.5 > 0.2 > PLAN.one_loop.rate
    assert PLAN.separable.condition < 200 < 1000 < PLAN.one_loop.condition


def test_more_time_is_used_only_for_a_better_plan():
    plans = [design_excitation(-1.0, 1.0, time_limit=t) for t in (320.0, 450.0, 900.0, 4000.0)]
    assert all(
        a.separable.smallest <= b.separable.smallest / 0.96 for a, b in itertools.pairwise(plans)
    )
    assert plans[-1].duration < 1500.0


def test_weights_follow_from_noisy_data_as_the_singular_value_says():
    """An independent check of what the figure means: least squares on the plan's columns, noise of rms 1e-3."""
    _, value, part = PLAN.signal(0.2)
    y = shares(value[np.isin(part, ["loops", "holds"])])
    bank = columns(y, 0.2, radii=OCTAVES)
    table = np.concatenate(list(bank.values()), axis=1)
    table /= np.sqrt((table**2).mean(axis=0))
    random = np.random.default_rng(0)
    weights = np.ones(table.shape[1])
    found = [
        np.linalg.lstsq(table, table @ weights + 1e-3 * random.standard_normal(y.size), rcond=None)[
            0
        ]
        - weights
        for _ in range(40)
    ]
    worst = np.linalg.svd(np.array(found), compute_uv=False)[0] / np.sqrt(40)
    figure = separability(y, 0.2)
    assert worst == pytest.approx(1e-3 / (figure.smallest * np.sqrt(y.size)), rel=0.5)


@given(
    steps=st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=300),
    tau=st.floats(0.05, 500.0),
    period=st.floats(0.001, 2.0),
)
@settings(deadline=None, max_examples=40)
def test_lags_in_blocks_are_the_recursion(steps, tau, period):
    y = np.array(steps)
    x, expected = y[0], []
    for value in y:
        x += (1 - np.exp(-period / tau)) * (value - x)
        expected.append(x)
    assert np.allclose(lags(y, period, [tau])[:, 0], expected, atol=1e-12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"low": 1.0}, "low < high"),
        ({"high": float("inf")}, "low < high"),
        ({"low": -1e308, "high": 1e308}, "physical size"),
        ({"low": 1e16, "high": 1e16 + 4.0}, "low < high"),
        ({"rate": -1.0}, "nothing could move"),
        ({"rate": float("inf")}, "nothing could move"),
        ({"rate": 1e-9, "time_limit": 1e13}, "samples, more than a file"),
        ({"acceleration": 0.0}, "nothing could move"),
        ({"period": 0.0}, "no sampling"),
        ({"period": 5.0}, "samples of the shortest stroke"),
        ({"time_limit": 20.0}, "shortest plan takes"),
        ({"time_limit": float("nan")}, "shortest plan takes"),
        ({"time_constants": []}, "one or more positive"),
        ({"time_constants": [4.0, -1.0]}, "one or more positive"),
    ],
)
def test_what_cannot_be_planned_is_refused_with_a_cure(change, words):
    with pytest.raises(ParameterError, match=words):
        design_excitation(**{"low": -1.0, "high": 1.0, **change})


def test_the_time_that_a_refusal_names_is_enough():
    with pytest.raises(ParameterError) as refused:
        design_excitation(-1.0, 1.0, rate=0.3, acceleration=0.2, time_limit=100.0)
    needed = refused.value.facts["needed"]
    assert (
        design_excitation(-1.0, 1.0, rate=0.3, acceleration=0.2, time_limit=needed).duration
        <= needed
    )


@pytest.mark.parametrize("rate", [180.0, 200.0, 230.0])
def test_the_period_that_a_refusal_names_is_short_enough(rate):
    asked = {"low": -20.0, "high": 130.0, "rate": rate, "time_limit": 130.0}
    with pytest.raises(ParameterError, match="would not be smooth") as refused:
        design_excitation(**asked, period=0.03)
    named = float(re.search(r"Pass a period of (\S+) s at most", str(refused.value))[1])
    assert design_excitation(**asked, period=named).period == named


def test_a_slow_acceleration_lowers_the_rate_that_the_decade_is_counted_from():
    plan = design_excitation(-1.0, 1.0, rate=100.0, acceleration=0.5, time_limit=1200.0)
    assert plan.limits.rate == pytest.approx(plan.peak_rate)
    assert plan.limits.stroke_time(1.88) == pytest.approx(Limits(100.0, 0.5).stroke_time(1.88))


# --- motion for drift ---------------------------------------------------------------------------------------


@given(
    low=st.floats(-100.0, 100.0),
    width=st.floats(0.01, 200.0),
    stroke=st.floats(0.5, 6.0),
    time=st.floats(1.0, 3.0),
)
@settings(deadline=None, max_examples=10)
def test_a_motion_for_drift_keeps_its_limits_and_has_cycles_for_all_groups(
    low, width, stroke, time
):
    """Oracle: the cycles and groups that drift itself makes."""
    limits = {"rate": 35 / 16 * width / stroke, "period": 0.001}
    with pytest.raises(ParameterError) as refused:
        design_drift_motion(low, low + width, time_limit=1.0, **limits)
    plan = design_drift_motion(
        low, low + width, time_limit=time * refused.value.facts["needed"], **limits
    )
    assert plan.duration <= time * refused.value.facts["needed"] + 1e-9
    assert plan.peak_rate <= limits["rate"] * (1 + 1e-12)
    _, value, _ = plan.signal(plan.duration / 2e4)
    slack = 1e-9 * (abs(low) + width)
    assert low - slack <= value.min() and value.max() <= low + width + slack
    assert value[0] == value[-1] == plan.middle
    found = cycles_of(value, [slice(0, value.size)], low, low + width)
    assert len(found) == CYCLES
    assert [len(group) for group in groups_of(found, MOST_GROUPS)] == [
        CYCLES // MOST_GROUPS
    ] * MOST_GROUPS


def test_more_time_makes_the_slow_cycle_slower_and_creep_easier_to_tell():
    shares = [
        design_drift_motion(-1.0, 1.0, time_limit=limit).separable.creep for limit in (300.0, 600.0)
    ]
    assert shares[1] > 2.0 * shares[0]
