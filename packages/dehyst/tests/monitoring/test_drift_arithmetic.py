"""Drift, piece by piece and without a fit: cycles, groups, estimates, tests, limits, against oracles of their own."""

import dataclasses
import itertools

import numpy as np
import pytest
from scipy import stats

import dehyst
from dehyst.models import ModelCard, SignalCard
from dehyst.monitoring import JudgedModel, LogDrift, PartChange, ScoredBlocks
from dehyst.monitoring import _logs as logs
from dehyst.monitoring import _parts as taken
from dehyst.monitoring import _procedure as procedure
from dehyst.monitoring import _result as result
from dehyst.monitoring import _testing as testing
from dehyst.monitoring._groups import (
    Contrast,
    Cycle,
    contrast,
    cycles_of,
    groups_of,
    rms,
    trend,
)
from dehyst.monitoring._parts import Estimates, MeasuredRecording, Prediction, Scale, memoryless
from dehyst.student import quantile

SCALE = Scale((0.0, 1.0), (2.0, 5.0), 4.0)


def zigzag(tips, steps=10):
    """Straight strokes from tip to tip, `steps` samples each."""
    parts = [np.linspace(a, b, steps, endpoint=False) for a, b in itertools.pairwise(tips)]
    return np.concatenate([*parts, [tips[-1]]])


# --- cycles -------------------------------------------------------------------------------------------------


def test_cycles_go_from_lower_turn_to_lower_turn_once_both_ends_were_visited():
    x = zigzag([0.0, 1.0, -1.0, 0.5, -1.0, 1.0, -1.0, 0.0])
    found = cycles_of(x, [slice(0, x.size)], -1.0, 1.0)
    assert [(c.begin, c.end) for c in found] == [(20, 40), (40, 60)]
    assert [c.path for c in found] == pytest.approx([2 * 1.5**2 / 4, 2 * 2.0**2 / 4])


def test_a_signal_that_comes_within_a_tenth_of_its_ends_has_visited_them():
    x = zigzag([0.0, 0.85, -0.85, 0.85, -0.85, 0.85, -0.85, 0.0])
    assert len(cycles_of(x, [slice(0, x.size)], -1.0, 1.0)) == 2
    assert len(cycles_of(x, [slice(0, x.size)], -1.3, 1.3)) == 0


def test_small_loops_belong_to_the_large_one_unless_there_are_too_few_large_ones():
    with_minor = [v for _ in range(9) for v in (1.0, 0.5, 0.8, -1.0)]
    x = zigzag([0.0, 1.0, -1.0, *with_minor, 0.0])  # a swing of 0.3 of 2: below 0.3, at 0.15
    assert len(cycles_of(x, [slice(0, x.size)], -1.0, 1.0)) == 9
    few = zigzag([0.0, 1.0, -1.0, *[v for _ in range(3) for v in (1.0, 0.4, 0.8, -1.0)], 0.0])
    assert len(cycles_of(few, [slice(0, few.size)], -1.0, 1.0)) == 6  # its small loops count too


def test_a_gap_ends_a_cycle_and_the_memory_begins_anew():
    x = zigzag([0.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 0.0])
    whole = cycles_of(x, [slice(0, x.size)], -1.0, 1.0)
    cut = cycles_of(x, [slice(0, 45), slice(45, x.size)], -1.0, 1.0)
    assert [(c.begin, c.end) for c in whole] == [(20, 40), (40, 60), (60, 80)]
    assert [(c.begin, c.end) for c in cut] == [(20, 40), (60, 80)]
    assert cycles_of(np.zeros(50), [slice(0, 50)], 0.0, 0.0) == ()


def test_groups_hold_equal_shares_of_the_squared_path():
    cycles = [Cycle(k, k + 1, path) for k, path in enumerate([1.0] * 8 + [4.0] * 4)]
    places = np.cumsum([c.path for c in cycles]) - 0.5 * np.array([c.path for c in cycles])
    wanted = [int(4 * place / 24.0) for place in places]
    assert [k for k, group in enumerate(groups_of(cycles, 4)) for _ in group] == wanted
    assert [len(group) for group in groups_of(cycles, 12)] == [1] * 12
    assert len(groups_of(cycles, 11)) <= 11 and sum(map(len, groups_of(cycles, 11))) == 12


# --- statistics ---------------------------------------------------------------------------------------------


def test_p_values_intervals_and_power_are_those_of_students_distribution():
    found = Contrast(1.5, 0.4, 7)
    t = stats.t(7)
    assert found.p_value(0.0) == pytest.approx(2 * t.sf(1.5 / 0.4))
    assert found.p_value(0.5) == pytest.approx(2 * t.sf(1.0 / 0.4))
    assert found.p_value(0.5, sided=1) == pytest.approx(t.sf(1.0 / 0.4))
    assert Contrast(-1.5, 0.4, 7).p_value(0.0) == pytest.approx(found.p_value(0.0))
    assert Contrast(-1.5, 0.4, 7).p_value(0.0, sided=1) == pytest.approx(t.cdf(1.5 / 0.4))
    assert found.p_value(3.0) == 1.0
    assert found.interval(0.95) == pytest.approx(
        (1.5 - 0.4 * t.ppf(0.975), 1.5 + 0.4 * t.ppf(0.975))
    )
    assert found.detectable(0.2, 0.01) == pytest.approx(0.2 + 0.4 * (t.ppf(0.995) + t.ppf(0.9)))
    assert quantile(0.9, 3) == pytest.approx(stats.t.ppf(0.95, 3))
    assert Contrast(0.3, 0.0, 5).p_value(0.2) == 0.0 and Contrast(0.2, 0.0, 5).p_value(0.2) == 1.0


def test_a_contrast_is_welchs_with_the_freedom_of_the_smaller_sample():
    a, b = np.array([1.0, 2.0, 4.0, 5.0]), np.array([0.0, 1.0, 0.5])
    found = contrast(a, b)
    assert found.estimate == pytest.approx(3.0 - 0.5) and found.freedom == 2
    assert found.error == pytest.approx(np.sqrt(a.var(ddof=1) / 4 + b.var(ddof=1) / 3))
    assert contrast(a, 1.0).estimate == 2.0 and contrast(a, 1.0).freedom == 3


# --- estimates ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def measured():
    """Twelve cycles of a drive, the loop of a play, and an error made of known parts in each half."""
    x = zigzag([0.0, 1.0, -1.0, *[1.0, -1.0, 0.5, -1.0] * 6, 0.0], 25)
    play = dehyst.PrandtlIshlinskii([0.0, 0.3], [2.0, 3.0])
    response = play.simulate(x)
    loop = response - 5.0 * x
    record = dehyst.Recording(input=x, output=response, time=0.1 * np.arange(x.size))
    prediction = Prediction(response, loop, x)
    columns = taken.part_columns(record, x, prediction, SCALE)
    cycles = cycles_of(x, [slice(0, x.size)], -1.0, 1.0)
    later = np.arange(x.size) >= cycles[6].begin
    error = (
        0.2
        + 0.03 * columns["gain"]
        - 0.1 * columns["hysteresis"]
        + np.where(later, 0.4 * columns["bend"], 0.0)
    )
    return MeasuredRecording(
        record, x, response, prediction, error, 0.5 * x, columns, np.ones(x.size, dtype=bool)
    ), cycles


def test_columns_are_those_of_the_formula(measured):
    data, _ = measured
    xi = data.drive
    np.testing.assert_allclose(data.columns["gain"], data.prediction.response - 2.0)
    np.testing.assert_allclose(
        data.columns["bend"], 5.0 * np.polynomial.legendre.legval(xi, [0, 0, 1])
    )
    np.testing.assert_allclose(
        data.columns["s-bend"], 5.0 * np.polynomial.legendre.legval(xi, [0, 0, 0, 1])
    )
    np.testing.assert_array_equal(data.columns["hysteresis"], data.prediction.loop)


def test_creep_is_the_drive_less_its_lags(measured):
    """Oracle: the lags stepped sample by sample, each a first-order hold, settled at the mean before."""
    data, _ = measured
    step, mean = 0.1, float(np.mean(data.drive))
    total = np.zeros(data.drive.size)
    for lag in (4.0 / 3.0, 4.0, 12.0):
        late, gain = mean, 1.0 - np.exp(-step / lag)
        for k, value in enumerate(data.drive.tolist()):
            late += gain * (value - late)
            total[k] += (value - late) / 3.0
    np.testing.assert_allclose(data.columns["creep"], 5.0 * total, atol=1e-9)


def test_every_group_gives_its_parts_back_and_what_is_ignored_is_taken_out_of_the_error(measured):
    data, cycles = measured
    groups, parts = [(cycle,) for cycle in cycles], ("offset", "gain", "hysteresis", "bend")
    found = taken.estimate(data, groups, (parts,), ("offset", "bend"))
    bend = [0.0] * 6 + [0.4] * 6
    np.testing.assert_allclose(found.values, [[0.2, 0.03, -0.1, b] for b in bend], atol=1e-9)
    assert np.max(found.remainder) < 1e-9
    for k, cycle in enumerate(cycles):
        place = slice(cycle.begin, cycle.end)
        columns = {name: column[place] for name, column in data.columns.items()}
        kept = 0.03 * columns["gain"] - 0.1 * columns["hysteresis"]
        assert found.counted[k] == pytest.approx(np.sqrt(np.mean(kept**2)))
        assert found.error[k] == pytest.approx(np.sqrt(np.mean(data.error[place] ** 2)))
        assert found.inverse[k] == pytest.approx(np.sqrt(np.mean((0.5 * data.drive[place]) ** 2)))
        assert found.motion[k] == pytest.approx(np.std(data.drive[place]))
    everything = slice(cycles[0].begin, cycles[-1].end)
    assert found.sizes[0] == 1.0 and found.sizes[1] == pytest.approx(
        np.std(data.columns["gain"][everything])
    )


def test_parts_fitted_in_turn_leave_the_rest_to_the_next(measured):
    data, cycles = measured
    steps = (("offset", "gain"), ("hysteresis",))
    found = taken.estimate(data, [cycles], steps)
    place = slice(cycles[0].begin, cycles[-1].end)
    matrix = np.column_stack([data.columns[p][place] for p in steps[0]])
    first = np.linalg.lstsq(matrix, data.error[place], rcond=None)[0]
    left = data.error[place] - matrix @ first
    column = data.columns["hysteresis"][place]
    second = column @ left / (column @ column)
    np.testing.assert_allclose(found.values[0], [*first, second])
    assert found.remainder[0] == pytest.approx(np.sqrt(np.mean((left - second * column) ** 2)))


def test_a_part_that_another_one_equals_is_dropped_and_one_that_is_apart_is_kept(measured):
    data, cycles = measured
    groups = groups_of(cycles, 12)
    assert taken.distinct_parts(data, groups, ("offset", "gain", "hysteresis")) == (
        "offset",
        "gain",
        "hysteresis",
    )
    data.columns["viscous"] = data.columns["gain"] + 1e-3 * data.columns["bend"]
    kept = taken.distinct_parts(data, groups, ("offset", "gain", "hysteresis", "viscous"))
    del data.columns["viscous"]
    assert kept == ("offset", "gain", "hysteresis")


# --- tests --------------------------------------------------------------------------------------------------


def groups(values, rest=0.1, counted=0.1, motion=1.0):
    values = np.asarray(values, dtype=float)
    q = values.shape[0]
    full = [np.broadcast_to(v, q).astype(float) for v in (rest, counted, motion)]
    return Estimates(
        ("offset", "gain"), values, full[0], full[1], None, full[1], np.array([1.0, 4.0]), full[2]
    )


def one(changes, part):
    return next(change for change in changes if change.part == part)


NOW = np.array([[0.1, 0.02], [0.3, 0.05], [0.2, 0.02], [0.15, 0.04], [0.25, 0.03]])
THEN = np.array([[0.05, 0.0], [0.0, 0.01], [0.1, 0.0], [0.05, 0.02], [0.0, 0.0]])


def test_changes_are_shown_in_their_units_and_tested_at_the_tolerance():
    """Span 10: a coefficient of 1 of the offset does 10 % of range, of the gain (rms 4) 40 %."""
    rule = testing.Rule(0.01, None, 3.0)
    changes = testing.changes_of(groups(NOW), None, False, SCALE, rule, "deg")
    offset, gain = one(changes, "offset"), one(changes, "gain")
    assert (offset.unit, gain.unit) == ("deg", "%")
    assert offset.estimate == pytest.approx(0.2) and gain.estimate == pytest.approx(3.2)
    assert offset.effect_percent == pytest.approx(2.0) and gain.effect_percent == pytest.approx(
        40 * 0.032
    )
    for k, (change, tolerance) in enumerate(((offset, 0.5 * 3.0 / 10.0), (gain, 3.0 / 40.0))):
        tested = contrast(NOW[:, k])
        factor = (1.0, 100.0)[k]
        assert change.p_value == pytest.approx(tested.p_value(tolerance))
        assert change.detectable == pytest.approx(factor * tested.detectable(tolerance, 0.01))
        assert change.detectable_percent == pytest.approx(
            (10.0, 40.0)[k] * tested.detectable(tolerance, 0.01)
        )
        assert (change.low, change.high) == pytest.approx(
            [factor * end for end in tested.interval(0.95)]
        )


def test_a_part_is_resolved_if_the_log_would_have_shown_one_percent_of_range():
    """Span 10: the scatter between groups of the offset decides, the estimates are the same."""
    values = np.column_stack([[1.0, -1.0, 1.0, -1.0, 0.0], np.zeros(5)])
    rule, limit = testing.Rule(0.01, None, None), contrast(values[:, 0]).detectable(0.0, 0.01)
    for share, resolved in ((0.95, True), (1.05, False)):
        scatter = share * (1.0 - testing.POLICY.least_change) / 10.0 / limit
        offset = one(
            testing.changes_of(groups(scatter * values), None, False, SCALE, rule, ""), "offset"
        )
        assert offset.resolved == resolved and offset.detectable_percent == pytest.approx(
            0.1 + 0.9 * share
        )


def test_groups_moved_alike_are_compared_in_pairs_and_others_are_not():
    rule = testing.Rule(0.01, 0.1, None)
    for motion, wanted in (
        (1.04, contrast(NOW[:, 0] - THEN[:, 0])),
        (1.06, contrast(NOW[:, 0], THEN[:, 0])),
    ):
        changes = testing.changes_of(
            groups(NOW, motion=motion), groups(THEN), True, SCALE, rule, ""
        )
        assert one(changes, "offset").p_value == pytest.approx(wanted.p_value(0.1 / 10.0))
    shorter = groups(THEN[:4])
    wanted = contrast(NOW[:, 0], THEN[:4, 0]).p_value(0.1 / 10.0)
    assert one(
        testing.changes_of(groups(NOW), shorter, True, SCALE, rule, ""), "offset"
    ).p_value == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("least", "own", "part", "referred", "wanted"),
    [
        (None, None, "gain", False, 0.1), (None, 3.0, "gain", True, 0.1), (None, 3.0, "gain", False, 3.0),
        (None, 3.0, "offset", False, 1.5), (None, 0.05, "gain", False, 0.1), (0.7, 3.0, "gain", False, 0.7),
        (0.0, 3.0, "offset", True, 0.0),
    ],
)  # fmt: skip
def test_what_does_not_count_is_a_tenth_of_a_percent_or_the_models_own_error(
    least, own, part, referred, wanted
):
    assert testing.Rule(0.01, least, own).tolerance(part, referred) == wanted


def test_the_bound_of_unchanged_is_one_percent_or_twice_what_is_worth_a_word():
    assert [testing.Rule(0.01, least, None).bound for least in (None, 0.2, 0.5, 2.0)] == [
        1.0,
        1.0,
        1.0,
        4.0,
    ]


@pytest.mark.parametrize(("alike", "allowed"), [(True, 1.25), (False, 1.5)])
def test_growth_of_the_error_is_tested_on_a_logarithmic_scale(alike, allowed):
    later, then = np.array([0.4, 0.5, 0.45, 0.42, 0.48]), np.array([0.2, 0.21, 0.19, 0.2, 0.2])
    changes = testing.changes_of(
        groups(NOW, counted=later, rest=then), groups(THEN, counted=then, rest=then), alike, SCALE,
        testing.Rule(0.01, None, 9.0), "",
    )  # fmt: skip
    tested = contrast(np.log(later) - np.log(then))
    error, rest = one(changes, "error"), one(changes, "rest")
    assert error.estimate == pytest.approx(100 * (np.exp(tested.estimate) - 1))
    assert error.high == pytest.approx(100 * (np.exp(tested.interval(0.95)[1]) - 1))
    assert (
        error.p_value == pytest.approx(tested.p_value(np.log(allowed), sided=1)) and error.drifted
    )
    assert error.effect_percent == pytest.approx(10 * np.exp(np.mean(np.log(later))))
    assert error.detectable == pytest.approx(
        100 * (np.exp(tested.detectable(np.log(allowed), 0.01)) - 1)
    )
    assert (
        error.detectable_percent is None and rest.estimate == pytest.approx(0.0) and rest.resolved
    )
    assert not error.resolved


def test_an_error_below_a_tenth_of_a_percent_may_grow_and_one_above_may_not():
    for size, small in ((0.009, True), (0.011, False)):
        changes = testing.changes_of(
            groups(NOW, counted=size),
            groups(THEN, counted=0.2 * size),
            True,
            SCALE,
            testing.Rule(0.01, None, None),
            "",
        )
        error = one(changes, "error")
        assert (
            (error.p_value == 1.0) == small and error.resolved == small and error.drifted != small
        )


def test_without_a_reference_the_error_is_compared_with_that_of_the_card():
    later = np.array([0.28, 0.3, 0.32, 0.31])
    changes = testing.changes_of(
        groups(NOW[:4], counted=later), None, False, SCALE, testing.Rule(0.01, None, 2.0), ""
    )
    tested = contrast(np.log(later), float(np.log(0.2)))  # 2 % of 10
    assert one(changes, "error").p_value == pytest.approx(tested.p_value(np.log(1.5), sided=1))
    none = testing.changes_of(
        groups(NOW[:4]), None, False, SCALE, testing.Rule(0.01, None, None), ""
    )
    assert {change.part for change in none} == {"offset", "gain"}


def change(part="gain", drifted=False, resolved=True, percent=0.5):
    return PartChange(part, 1.0, 0.5, 1.5, "%", 0.4, 2.0, percent, 0.5, drifted, resolved)


@pytest.mark.parametrize(
    ("changes", "error", "ignored", "wanted"),
    [
        ([change(), change("error")], 9.0, (), "unchanged"),
        ([change(drifted=True, resolved=False), change("error")], 9.0, (), "drifted"),
        ([change(resolved=False), change("error")], 0.1, (), "cannot tell"),
        ([change(), change("error", resolved=False)], 0.1, (), "cannot tell"),
        ([change()], 1.0, (), "unchanged"),
        ([change()], 1.01, (), "cannot tell"),
        ([change()], 9.0, ("error",), "unchanged"),
    ],
)
def test_unchanged_is_said_only_where_everything_is_resolved(changes, error, ignored, wanted):
    assert testing.status_of(changes, error, testing.Rule(0.01, None, None, ignored)) == wanted


def test_what_is_ignored_never_counts_and_needs_no_power():
    rule = testing.Rule(0.5, 0.0, 0.1, ("offset",))
    offset = one(testing.changes_of(groups(100.0 * NOW), None, False, SCALE, rule, ""), "offset")
    assert (
        offset.p_value < 0.5
        and not offset.drifted
        and offset.resolved
        and offset.detectable_percent > 1.0
    )
    assert one(
        testing.changes_of(groups(100.0 * NOW), None, False, SCALE, rule, ""), "gain"
    ).drifted


# --- comparable ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (-1.0, 1.0, ""), (-0.6, 1.0, ""), (-0.59, 1.0, "less than 80 %"), (-1.0, 1.19, ""), (-1.21, 1.0, "goes beyond"),
        (-1.0, 1.21, "goes beyond"), (2.0, 3.0, "0 % of it"),
    ],
)  # fmt: skip
def test_a_range_is_covered_from_80_percent_to_10_beyond(low, high, words):
    why = logs.uncovered(
        np.array([low, 0.5 * (low + high), high]), SignalCard("p", "bar", -1.0, 1.0)
    )
    assert (words in why) if words else not why
    assert not logs.uncovered(np.array([0.0, 9.0]), SignalCard("p", "bar", None, None))


def test_four_groups_are_enough_and_half_of_the_variance_must_be_explained():
    cycle = Cycle(0, 1, 1.0)
    assert not logs.too_few([(cycle,)] * 4, [cycle] * 4)
    assert "3 complete cycles whose" in logs.too_few([(cycle,)] * 3, [cycle] * 3)
    assert "1 complete cycle whose" in logs.too_few([(cycle,)], [cycle])
    response = np.array([1.0, -1.0, 1.0, -1.0])
    assert not logs.unexplained(np.full(4, np.sqrt(0.49)), response)
    assert "explains 40 %" in logs.unexplained(np.full(4, np.sqrt(0.6)), response)
    assert "explains 0 %" in logs.unexplained(np.ones(4), np.zeros(4))


# --- opening and limits -------------------------------------------------------------------------------------


def test_the_last_quarter_of_a_long_log_counts_as_now():
    cycles = [Cycle(k, k + 1, 1.0) for k in range(100)]
    assert len(logs.now_of(cycles[:47])) == 47
    assert logs.now_of(cycles[:48]) == cycles[36:48]
    assert logs.now_of(cycles) == cycles[75:]


def carded(provenance, low=-1.0, high=3.0):
    card = ModelCard(
        SignalCard("x", "bar", low, high), SignalCard("y", "deg", 0.0, 10.0), provenance
    )
    return dehyst.PrandtlIshlinskii([0.0, 0.2], [1.0, 1.0]).with_card(card)


@pytest.mark.parametrize(
    ("provenance", "wanted"),
    [
        ({"test": {"rmse_percent": 2}, "train": {"rmse_percent": 1.0}}, 2.0),
        ({"test": None, "train": {"rmse_percent": 1.5}}, 1.5),
        ({"test": {"rmse_percent": True}}, None), ({"test": {"rmse_percent": -0.1}}, None),
        ({"test": {"rmse_percent": 1e6}}, None), ({"test": {"rmse_percent": 0.0}}, 0.0), ({}, None),
    ],
)  # fmt: skip
def test_the_models_own_error_is_the_held_out_one_of_its_card(provenance, wanted):
    assert logs.own_error(carded(provenance)) == wanted


def log_of(x, t=None, begin=0, reference=(), name="log"):
    record = dehyst.Recording(input=x, output=x, time=t, name=name)
    cycles = cycles_of(x, [slice(0, x.size)], float(x.min()), float(x.max()))
    prediction = Prediction(x, np.zeros(x.size))
    data = MeasuredRecording(
        record, x, x, prediction, 0.0 * x, None, {}, np.ones(x.size, dtype=bool)
    )
    return logs.Log(record, "", cycles, cycles if reference else (), data)


@pytest.mark.parametrize(
    ("size", "step", "alike", "words"),
    [
        (1.0, 0.1, True, ""), (0.9, 0.1, True, ""), (0.8, 0.1, False, "scatters"), (1.2, 0.1, False, "scatters"),
        (1.0, 0.14, True, ""), (1.0, 0.16, False, "a cycle takes"), (1.0, 0.06, False, "a cycle takes"),
    ],
)  # fmt: skip
def test_motions_are_alike_within_15_percent_of_size_and_a_factor_of_one_and_a_half_in_speed(
    size, step, alike, words
):
    x = zigzag([0.0, *[1.0, -1.0] * 8, 0.0], 20)
    known = log_of(x, 0.1 * np.arange(x.size), reference=True, name="new")
    findings = []
    assert logs.moved_alike(log_of(size * x, step * np.arange(x.size)), known, findings) == alike
    assert [words in finding.message for finding in findings] == ([] if alike else [True])
    assert not logs.moved_alike(log_of(size * x), logs.Log(known.record, ""), [])


def test_scale_and_motion_are_those_of_the_card_and_the_period_that_of_the_cycles():
    x = zigzag([0.0, *[1.0, -1.0] * 8, 0.0], 20)
    log = log_of(x, 0.1 * np.arange(x.size))
    subject = JudgedModel.of(carded({}))
    scale = logs.scale_of(subject, [log], None)
    assert scale.drive == (1.0, 2.0) and scale.response == (5.0, 5.0) and scale.span == 10.0
    assert scale.period == pytest.approx(4.0)
    motion = logs.logged_motion(subject, scale)
    assert (motion["low"], motion["high"], motion["unit"], motion["period_s"]) == (
        -1.0,
        3.0,
        "bar",
        scale.period,
    )
    assert motion["rate"] == pytest.approx(35 / 16 * 4.0 / 2.0)  # a stroke of 4 in half a period
    free = logs.scale_of(JudgedModel.of(carded({}, None, None)), [log], None)
    assert free.drive == (0.0, 1.0)
    assert logs.logged_motion(subject, Scale((0.0, 1.0), (0.0, 1.0), None))["rate"] is None


@pytest.mark.parametrize(
    ("settings", "logged", "read", "wanted"),
    [
        ({"train_fraction": 0.6}, {}, {}, 0.6), ({}, {}, {}, 1.0), ({"train_fraction": "x"}, {}, {}, 1.0),
        ({"train_fraction": 0.5}, {"first_row": 100, "last_row": 299}, {"first_row": 0, "last_row": 399}, 0.5),
        ({"train_fraction": 1.0}, {"first_row": 100, "last_row": 299}, {"first_row": 200, "last_row": 399}, 0.5),
        ({"train_fraction": 0.5}, {"first_row": 0, "last_row": 99}, {"first_row": 200, "last_row": 399}, 0.0),
        ({"train_fraction": 0.6}, {"run": "b"}, {}, None),
    ],
)  # fmt: skip
def test_the_share_that_a_model_was_fitted_to_is_found_by_checksum_and_rows(
    settings, logged, read, wanted
):
    model = carded({"logs": [None, {"sha256": "1"} | logged], "settings": settings})
    record = dehyst.Recording(
        input=[0.0, 1.0, 0.0, 1.0], output=[0.0, 1.0, 0.0, 1.0], provenance={"sha256": "1"} | read
    )
    assert logs.fitted_share(model, record) == wanted
    other = dehyst.Recording(
        input=[0.0, 1.0, 0.0, 1.0], output=[0.0, 1.0, 0.0, 1.0], provenance={"sha256": "2"}
    )
    assert logs.fitted_share(model, other) is None


def test_percents_are_of_the_ranges():
    found = Estimates(
        (), np.zeros((2, 0)), *(np.array([0.3, 0.4]),) * 2, np.array([0.1, 0.3]), *(np.ones(2),) * 3
    )
    error, inverse = testing.percents(found, SCALE)
    assert error == pytest.approx(100 * np.sqrt(0.125) / 10.0) and inverse == pytest.approx(
        100 * np.sqrt(0.05) / 2.0
    )


def test_a_curve_without_memory_has_the_slope_of_large_motions():
    model = dehyst.PrandtlIshlinskii([0.0, 0.5], [1.0, 2.0], offset=1.0, center=0.25)
    still = memoryless(model)
    x = np.linspace(-50.0, 50.0, 7)
    slope = np.diff(still.simulate(x)) / np.diff(x)
    np.testing.assert_allclose(slope, 3.0)
    assert still.simulate([0.25]).tolist() == [1.0]


def test_the_worst_log_decides_and_the_verdict_of_nothing_says_what_may_have_stayed_hidden():
    def entry(status, *changes, name="log"):
        return LogDrift(None, status, "", name, 9, 9, 4.86, 3.0, changes)

    states = [entry(status) for status in ("reference", "unchanged", "cannot tell", "drifted")]
    assert [result.status_of_all(states[: k + 1]) for k in range(4)] == [
        "not comparable", "unchanged", "cannot tell", "drifted",
    ]  # fmt: skip
    hidden = entry(
        "cannot tell", change("gain", resolved=False, percent=8.0), change("hysteresis", resolved=False, percent=9.0),
        change("bend", resolved=False, percent=2.0), change("error", resolved=False, percent=None),
    )  # fmt: skip
    told = result.verdict_of("cannot tell", [hidden], 2.01, "against the model", False)
    assert (
        "a change of hysteresis size by 2 % (9 % of range) or gain by 2 % (8 % of range) may have"
        in told
    )
    assert "bend" not in told and "larger by 1 % (0.5 to 1.5), it may have doubled" in told
    assert "error 4.86 % of range rms, against 2.01 % when it was identified; inverse 3 %" in told
    both = entry("drifted", change("error", drifted=True), change("gain", drifted=True))
    found = result.verdict_of("drifted", [both], 2.01, "against the model", True)
    assert (
        found.startswith("drifted (against the model): gain +1 % (0.5 to 1.5); error")
        and "forward 3 %" in found
    )
    alone = entry("drifted", change("error", drifted=True), change("gain"))
    assert "error of the model +1 %" in result.verdict_of("drifted", [alone], None, "a", False)
    with pytest.raises(KeyError):
        result.no_refit("drifted")
    assert all(
        "old model stays" in result.no_refit(s)
        for s in ("unchanged", "cannot tell", "not comparable")
    )


def test_the_drive_is_scaled_to_its_range_for_curve_and_creep():
    x, scale = np.linspace(-1.0, 5.0, 50), Scale((2.0, 3.0), (0.0, 4.0), None)
    record = dehyst.Recording(input=x, output=x)
    columns = taken.part_columns(record, x, Prediction(x, 0.0 * x), scale)
    np.testing.assert_allclose(
        columns["bend"], 4.0 * np.polynomial.legendre.legval((x - 2.0) / 3.0, [0, 0, 1])
    )
    assert "creep" not in columns and "viscous" not in columns and "own-creep" not in columns
    timed = dehyst.Recording(input=x, output=x, time=np.arange(50.0))
    own = Prediction(x, 0.0 * x, None, np.ones(50), np.ones(50))
    columns = taken.part_columns(timed, x, own, Scale((2.0, 3.0), (0.0, 4.0), 9.0))
    assert {"viscous", "own-creep"} <= set(columns) and "creep" not in columns


def test_creep_begins_anew_after_a_gap_and_a_long_rest_counts_as_thirty_cycles():
    t = np.r_[np.arange(40.0), 40.0 + np.arange(40.0)]
    xi = np.sin(0.7 * t)
    record = dehyst.Recording(input=xi, output=xi, time=t, breaks=(40,))
    alone = [
        dehyst.Recording(input=xi[s], output=xi[s], time=t[s])
        for s in (slice(0, 40), slice(40, 80))
    ]
    pieces = [taken._lagging(each, each.input, 9.0) for each in alone]
    np.testing.assert_allclose(taken._lagging(record, xi, 9.0), np.concatenate(pieces))
    late = [
        np.where(np.arange(80) < 40, t, t + rest) for rest in (269.0, 5000.0)
    ]  # 270 s between two samples, and more
    short, long = (
        taken._lagging(dehyst.Recording(input=xi, output=xi, time=each), xi, 9.0) for each in late
    )
    np.testing.assert_allclose(short, long)


def test_an_alike_reference_lowers_what_does_not_count():
    rule = testing.Rule(0.01, None, 3.0)
    for alike, tolerance in ((True, 0.1), (False, 3.0)):
        gain = one(testing.changes_of(groups(NOW), groups(THEN), alike, SCALE, rule, ""), "gain")
        assert gain.p_value == pytest.approx(
            contrast(NOW[:, 1] - THEN[:, 1]).p_value(tolerance / 40.0)
        )


def test_one_group_whose_error_is_eight_times_as_large_doubles_the_error_though_the_interval_does_not_say_so():
    later = np.r_[0.8, np.full(11, 0.1)]
    values = np.tile(NOW[:1], (12, 1))
    changes = testing.changes_of(
        groups(values, counted=later),
        groups(values, counted=0.1),
        True,
        SCALE,
        testing.Rule(0.01, None, None),
        "",
    )
    error = one(changes, "error")
    assert error.high < 100.0 and not error.drifted and not error.resolved
    milder = np.r_[0.3, np.full(11, 0.1)]
    changes = testing.changes_of(
        groups(values, counted=milder),
        groups(values, counted=0.1),
        True,
        SCALE,
        testing.Rule(0.01, None, None),
        "",
    )
    assert one(changes, "error").resolved


def test_cycles_are_scored_one_by_one_in_percent_of_the_ranges(measured):
    data, cycles = measured
    scale = Scale((0.0, 2.0), (2.0, 5.0), 4.0)
    steps = (("offset", "gain", "hysteresis", "bend"),)
    blocks = testing.scored_blocks(data, cycles, steps, scale, 100, cycles[:3])
    np.testing.assert_array_equal(blocks.cycle, 101.0 + np.arange(12))
    place = slice(cycles[4].begin, cycles[4].end)
    assert blocks.error_percent[4] == pytest.approx(
        100 * np.sqrt(np.mean(data.error[place] ** 2)) / 10.0
    )
    assert blocks.inverse_percent[4] == pytest.approx(
        100 * np.sqrt(np.mean((0.5 * data.drive[place]) ** 2)) / 4.0
    )
    np.testing.assert_allclose(blocks.changes["offset"], 0.2)
    np.testing.assert_allclose(blocks.changes["gain"], 3.0)
    everything = slice(cycles[0].begin, cycles[-1].end)
    effect = 100.0 * 0.4 * np.std(data.columns["bend"][everything]) / 10.0
    np.testing.assert_allclose(blocks.changes["bend"][6:], effect, rtol=1e-6)
    trends = testing.trends_of([entry_with(blocks), entry_with(blocks)], 0.01)
    assert [trend.part for trend in trends] == ["error", "offset", "gain", "hysteresis", "bend"]
    assert trends[0].unit == "%" and testing.trends_of([entry_with(None)], 0.01) == ()
    steep = ScoredBlocks(
        np.arange(20.0), 0.5 * np.arange(20.0), None, {"gain": -0.25 * np.arange(20.0)}
    )
    error, gain = testing.trends_of([entry_with(steep)], 0.01)
    assert (error.slope, gain.slope) == pytest.approx((50.0, -25.0)) and error.clear and gain.clear
    assert (error.low, error.high) == pytest.approx((50.0, 50.0))


def entry_with(blocks):
    return LogDrift(None, "unchanged", "", "log", 9, 9, 1.0, None, (change("gain"),), blocks)


def test_a_log_is_opened_in_the_units_of_the_model_and_parted_by_what_was_fitted():
    x = zigzag([1.0, *[3.0, -1.0] * 9, 1.0], 20)
    model = carded({"logs": [{"sha256": "1"}], "settings": {"train_fraction": 0.5}})
    subject = JudgedModel.of(model)
    names = {"input_unit": "kPa", "output_unit": "deg"}
    record = dehyst.Recording(input=100.0 * x, output=x, provenance={"sha256": "1"}, **names)
    findings = []
    alone = logs.open_log(subject, record, False, findings)
    assert [finding.code for finding in findings] == ["unit-converted"]
    np.testing.assert_allclose(alone.record.input, x)
    assert all(c.end <= x.size // 2 for c in alone.reference) and all(
        c.begin >= x.size // 2 for c in alone.cycles
    )
    assert (
        len(alone.reference) == 3
        and len(alone.cycles) == 4
        and "3 complete cycles" in alone.why_not
    )
    logs.open_log(subject, record, True, findings)
    assert len(findings) == 1  # said once
    others = logs.open_log(subject, record, True, [])
    assert len(others.reference) == 8 and others.cycles == () and not others.why_not
    stranger = dehyst.Recording(input=100.0 * x, output=x, **names)
    assert len(logs.open_log(subject, stranger, True, []).cycles) == 8
    known = logs.reference_log(subject, stranger, [])
    assert (
        len(known.reference) == 8
        and known.cycles == ()
        and logs.reference_log(subject, None, []) is None
    )
    volts = dehyst.Recording(input=x, output=x, input_unit="V", output_unit="deg")
    assert "swapped" in logs.open_log(subject, volts, True, []).why_not


@pytest.mark.parametrize(("swing", "count"), [(0.06, 8), (0.04, 1)])
def test_swings_below_a_twentieth_of_the_range_are_no_cycles(swing, count):
    x = zigzag(
        [0.0, 1.0, -1.0, *[v for _ in range(7) for v in (-1.0 + 2 * swing, -1.0)], 1.0, -1.0, 0.0]
    )
    assert len(cycles_of(x, [slice(0, x.size)], -1.0, 1.0)) == count


def test_slopes_of_noise_that_remembers_get_wider_intervals_than_those_of_white_noise():
    """Oracle: spread of the slopes of other draws of the same noise."""
    random, k = np.random.default_rng(2), np.arange(120.0)
    for memory in (0.0, 0.8):
        slopes, reaches = [], []
        for _ in range(60):
            white = random.standard_normal(160)
            noise = np.convolve(white, memory ** np.arange(40), "valid")[:120]
            slope, low, high = trend(k, noise, 0.95)
            slopes.append(slope)
            reaches.append(0.5 * (high - low))
            assert slope == pytest.approx(np.polyfit(k, noise, 1)[0])
        assert (
            1.5 < np.median(reaches) / np.std(slopes) < 3.2
        )  # Student's quantile of few blocks, about 2.1
    assert trend(k[:15], noise[:15], 0.95) is None and trend(k[:16], noise[:16], 0.95) is not None
    assert trend(np.zeros(20), np.arange(20.0), 0.95) is None


@pytest.mark.parametrize(
    ("tested", "before", "card", "codes"),
    [
        (True, None, (-1.0, 1.0), {"drift-no-reference", "drift-not-told-apart"}),
        (True, "known", (-1.0, 1.0), {"drift-not-told-apart"}),
        (True, "known", (None, None), {"drift-no-range", "drift-not-told-apart"}),
        (False, None, (None, None), set()),
    ],
)
def test_what_limits_the_judgement_is_said_where_something_was_tested(
    measured, tested, before, card, codes
):
    data, cycles = measured
    log = logs.Log(data.record, "", cycles, (), data)
    findings = []
    subject = JudgedModel.of(carded({}, *card))
    told = ("offset", "gain", "hysteresis", "bend", "s-bend")
    logs.say_what_limits(subject, [log] if tested else [], told, before, 2.0, SCALE, findings)
    assert {finding.code for finding in findings} == codes
    if before is None and tested:
        assert "was 2 % of range" in findings[0].message
    apart = [finding.message for finding in findings if finding.code == "drift-not-told-apart"]
    assert all(
        message.startswith("creep cannot be told") and "no time stamps" not in message
        for message in apart
    )
    findings.clear()
    logs.say_what_limits(subject, [log], (*told, "creep"), "known", 2.0, SCALE, findings)
    assert "drift-not-told-apart" not in {finding.code for finding in findings}
    untimed = Scale(SCALE.drive, SCALE.response, None)
    logs.say_what_limits(subject, [log], told, "known", 2.0, untimed, findings)
    assert "(there are no time stamps)" in findings[-1].message


def test_samples_beyond_the_range_of_a_direct_inverse_are_counted(measured):
    data, cycles = measured
    inside = np.ones(data.drive.size, dtype=bool)
    inside[cycles[1].begin : cycles[1].begin + 7] = False
    log = logs.Log(data.record, "", cycles, (), dataclasses.replace(data, inside=inside))
    findings = []
    logs.say_what_is_beyond(JudgedModel.of(carded({})), log, cycles[:2], findings)
    assert findings[0].message.startswith(f"7 of {cycles[1].end - cycles[0].begin} samples")
    logs.say_what_is_beyond(JudgedModel.of(carded({})), log, cycles[2:], findings)
    assert len(findings) == 1
    kept = log.measured.places(cycles[:2])
    assert kept.size == cycles[1].end - cycles[0].begin - 7 and not np.isin(cycles[1].begin, kept)
    nothing = dataclasses.replace(data, inside=np.zeros(data.drive.size, dtype=bool))
    assert nothing.places(cycles[:1]).size == cycles[0].end - cycles[0].begin


# --- what mutants showed ------------------------------------------------------------------------------------


def test_a_log_gets_its_columns_and_what_the_inverse_misses_from_the_model():
    x = zigzag([0.0, *[3.0, -1.0] * 4, 0.0], 20)
    subject = JudgedModel.of(carded({}))
    y = subject.model.simulate(x) + 0.5
    record = dehyst.Recording(input=x, output=y)
    known = logs.with_model(
        subject, logs.Log(record, ""), Scale((1.0, 2.0), (5.0, 5.0), None)
    ).measured
    np.testing.assert_allclose(known.inverse_error, known.prediction.drive - x)
    np.testing.assert_allclose(known.error, y - known.prediction.response)
    np.testing.assert_allclose(known.columns["gain"], known.prediction.response - 5.0)
    assert np.abs(known.inverse_error).max() > 0.1
    unfit = logs.Log(record, "too few")
    assert logs.with_model(subject, unfit, SCALE) is unfit


def test_rows_that_only_one_side_names_say_nothing_of_the_share():
    rows = [{"sha256": "1", "first_row": 0, "last_row": 9}]
    model = carded({"logs": rows, "settings": {"train_fraction": 0.6}})
    record = dehyst.Recording(
        input=[0.0, 1.0] * 2, output=[0.0, 1.0] * 2, provenance={"sha256": "1"}
    )
    assert logs.fitted_share(model, record) == 0.6


def test_a_card_whose_range_is_a_point_or_half_unknown_covers_nothing_to_speak_of():
    x = zigzag([0.0, *[1.0, -1.0] * 8, 0.0], 20)
    for low, high in ((1.0, 1.0), (None, 1.0), (1.0, None)):
        card = SignalCard("x", "bar", low, high)
        assert logs.uncovered(x, card) == ""
        assert logs.scale_of(JudgedModel.of(carded({}, low, high)), [log_of(x)], None).drive == (
            0.0,
            1.0,
        )
    findings = []
    subject = JudgedModel.of(carded({}, None, 3.0))
    logs.say_what_limits(subject, [log_of(x)], taken.PARTS, None, None, SCALE, findings)
    assert "drift-no-range" in [finding.code for finding in findings]
    apart = logs.uncovered(np.array([7.0, 8.0]), SignalCard("p", "bar", 0.0, 1.0))
    assert "0 % of it" in apart and "100 % of it" not in apart


def test_a_unit_that_nobody_knows_is_the_same_unit():
    record = dehyst.Recording(
        input=[0.0, 1.0] * 2, output=[0.0, 1.0] * 2, input_unit="ticks", output_unit="ticks"
    )
    card = SignalCard("x", "ticks", 0.0, 1.0)
    found, findings, why = logs.recording_in_units_of(record, (card, card))
    assert (found is record, findings, why) == (True, [], "")


def test_loops_of_a_tenth_of_the_range_are_not_tried_where_a_fifth_are_enough():
    inner = [v for _ in range(3) for v in (0.4, 0.8, 0.66, 0.8)]  # swings of 0.4, and of 0.14, of 2
    x = zigzag([0.0, 1.0, -1.0, *[v for _ in range(4) for v in (1.0, *inner, -1.0)], 0.0])
    lower = [a for a in range(4) for _ in range(4)]  # -1 and three of 0.4 in each large one
    assert len(cycles_of(x, [slice(0, x.size)], -1.0, 1.0)) == len(lower)
    quarter = [Cycle(k, k + 1, 0.25) for k in range(10)]
    assert [len(group) for group in groups_of(quarter, 4)] == [2, 3, 2, 3]


def test_columns_of_nothing_are_left_out_and_small_ones_are_not(measured):
    data, cycles = measured
    still = Prediction(
        data.prediction.response,
        data.prediction.loop,
        data.drive,
        viscous=np.zeros(data.drive.size),
    )
    assert "viscous" not in taken.part_columns(data.record, data.drive, still, SCALE)
    small = dataclasses.replace(data, columns={k: 1e-3 * v for k, v in data.columns.items()})
    parts = ("offset", "gain", "hysteresis")
    assert taken.distinct_parts(small, groups_of(cycles, 12), parts) == parts


def test_pairs_need_motions_within_five_percent_whatever_their_size():
    rule = testing.Rule(0.01, 0.1, None)
    for size in (0.1, 10.0):
        for share, wanted in (
            (1.04, contrast(NOW[:, 0] - THEN[:, 0])),
            (1.06, contrast(NOW[:, 0], THEN[:, 0])),
        ):
            changes = testing.changes_of(
                groups(NOW, motion=share * size), groups(THEN, motion=size), True, SCALE, rule, ""
            )
            assert one(changes, "offset").p_value == pytest.approx(wanted.p_value(0.1 / 10.0))


def test_errors_below_a_millionth_of_the_range_do_not_grow():
    changes = testing.changes_of(
        groups(NOW, counted=9e-6),
        groups(THEN, counted=1e-6),
        True,
        SCALE,
        testing.Rule(0.01, 1e-9, None),
        "",
    )
    assert one(changes, "error").estimate == pytest.approx(
        0.0, abs=1e-9
    )  # both count as 1e-5 of 10


def test_a_doubled_error_is_the_root_of_the_mean_square_of_the_groups():
    """Groups of 1 and 3 after 1: the RMS is 2.24 times as large, the root of the mean cube would be more yet."""
    later = np.array([1.0, 1.0, 1.0, 1.0, 3.9])
    assert rms(later) == pytest.approx(np.sqrt((4.0 + 3.9**2) / 5.0))


def test_trends_have_the_interval_of_the_blocks_at_the_rate_shared_by_all():
    """Oracle: the bootstrap of blocks draw by draw."""
    rng = np.random.default_rng(4)
    places, values = np.arange(16.0), 0.1 * np.arange(16.0) + rng.standard_normal(16)
    slope, low, high = trend(places, values, 0.95)
    assert slope == pytest.approx(np.polyfit(places, values, 1)[0])
    assert high - slope == pytest.approx(slope - low)
    narrow = trend(places, values, 0.5)
    assert (high - low) / (narrow[2] - narrow[1]) == pytest.approx(
        quantile(0.95, 2) / quantile(0.5, 2)
    )
    rest = values - np.polyval(np.polyfit(places, values, 1), places)
    starts = np.random.default_rng(0).integers(0, 16 - 5 + 1, (999, 4))
    slopes = []
    for begins in starts:
        again = np.concatenate([rest[begin : begin + 5] for begin in begins])[:16]
        slopes.append(np.polyfit(places, again, 1)[0])
    wanted = np.std(slopes) * np.sqrt(16 / (16 - 5 - 2)) * quantile(0.95, 2)
    assert high - slope == pytest.approx(wanted, rel=1e-6)
    assert trend(np.ones(40), np.arange(40.0), 0.95) is None
    assert trend(0.05 * places, values, 0.95) == pytest.approx(
        (20.0 * slope, 20.0 * low, 20.0 * high)
    )
    blocks = ScoredBlocks(places, values, None, {"gain": -values})
    error, _ = testing.trends_of([entry_with(blocks)], 0.02)
    assert error.high == pytest.approx(100.0 * trend(places, values, 0.99)[2])


def test_a_reference_without_time_stamps_has_no_speed_that_could_be_another():
    x = zigzag([0.0, *[1.0, -1.0] * 8, 0.0], 20)
    timed, free = log_of(x, 0.1 * np.arange(x.size)), log_of(x, reference=True)
    assert logs.moved_alike(timed, free, []) and logs.moved_alike(
        log_of(x), dataclasses.replace(free), []
    )


def test_what_the_inverse_misses_is_in_percent_of_the_range_of_the_drive():
    found = dataclasses.replace(groups(NOW), inverse=np.full(5, 0.3))
    assert testing.percents(found, Scale((0.0, 3.0), (2.0, 5.0), None))[1] == pytest.approx(5.0)


def test_parts_that_the_model_lacks_are_kept_where_loops_tell_them_apart(measured):
    data, cycles = measured
    parts = ("offset", "gain", "bend")
    assert taken.distinct_parts(data, groups_of(cycles, 3), parts) == parts


def test_a_gain_that_too_few_cycles_confirm_is_told_with_what_to_log():
    pairs = np.array([[1.0, 0.5], [9.0, 3.0], [0.4, 0.4], [0.5, 0.6]])
    decision = procedure._decide(None, pairs, Scale((0.0, 1.0), (0.0, 1.0), None))
    assert not decision.accepted and decision.p_value > procedure.POLICY.refit_level
    assert "dehyst design --for drift" in decision.reason
    worse = procedure._decide(None, pairs[:, ::-1], Scale((0.0, 1.0), (0.0, 1.0), None))
    assert not worse.accepted and "design" not in worse.reason
