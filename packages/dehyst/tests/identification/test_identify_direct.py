"""Identification of the direct inverse: what made the data is found, optima are optima, noise biases nothing."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.optimize
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst.errors import ExcitationError, ParameterError
from dehyst.identification._direct import selection
from dehyst.identification._direct.data import prepare_direct, separable
from dehyst.identification._direct.program import (
    RADII,
    Bank,
    Layout,
    Shape,
    fitted_rows,
    reduced_blocks,
    rising_powers,
    solve_shape,
)
from dehyst.identification._direct.selection import about_direct_fit
from dehyst.identification._evidence import Evidence, permutation_p
from dehyst.identification._split import split_recordings
from dehyst.least_squares import solve_bounded
from dehyst.models import ModelCard, Schedule, SignalCard
from dehyst.models._follow import follow
from direct_samples import TIPS, asked, log, motion

STOPS = ((0.4, 0.5), (3.0, 0.3))
UNSEEN = (-0.9, 0.6, -0.3, 0.8, -0.7, 0.2)


def prepared(record, share):
    """One recording as the data of a direct inverse."""
    return prepare_direct((record,), split_recordings((record,), share))


@pytest.fixture(scope="module")
def plain():
    """A log of stops and a curve, 38 s."""
    t, y = motion()
    return log(t, y, asked(t, y, np.gradient(y, t), stops=STOPS, curve=(1.0, 0.4, 0.0, 0.002)))


@pytest.fixture(scope="module")
def plain_fit(plain):
    return dehyst.identify(plain, "direct-inverse", initial_state="rest")


def codes(fit):
    return {finding.code for finding in fit.warnings}


def test_stops_and_curve_are_found_again_on_loops_that_were_not_fitted(plain_fit):
    assert plain_fit.input_test.rms_percent < 0.1
    assert plain_fit.settings["groups"] == ["stops"]
    assert plain_fit.settings["degree"] >= 3
    assert not plain_fit.model.schedules
    assert plain_fit.details["rises"]
    t, y = motion(UNSEEN)
    truth = asked(t, y, np.gradient(y, t), stops=STOPS, curve=(1.0, 0.4, 0.0, 0.002))
    assert np.sqrt(np.mean((plain_fit.model.run(y, t).u - truth) ** 2)) < 0.002 * np.ptp(truth)


def test_weights_sit_at_the_radii_that_made_the_data_when_these_are_offered():
    radii = RADII[[8, 17, 24]] * 10.0
    t, y = motion()
    u = asked(t, y, np.zeros(y.size), stops=tuple(zip(radii, (0.5, 0.2, 0.3), strict=True)))
    model = dehyst.identify(
        log(t, y, u), "direct-inverse", initial_state="rest", train_fraction=1.0
    ).model
    found = dict(zip(model.radii.round(9), model.stop_weights[0], strict=True))
    for radius, weight in zip(radii, (0.5, 0.2, 0.3), strict=True):
        assert found.pop(round(radius, 9)) == pytest.approx(weight, rel=0.01)
    assert max(found.values(), default=0.0) < 0.005


def test_the_prediction_is_what_the_saved_model_answers(plain, plain_fit, tmp_path):
    model = dehyst.load(plain_fit.model.save(tmp_path / "m.json"))
    run = model.run(plain.output, plain.time)
    np.testing.assert_allclose(run.u, plain_fit.inverse_predictions[0], rtol=0, atol=1e-9)
    assert model.card == plain_fit.model.card
    assert model.card.provenance["verdict"] == plain_fit.verdict


@pytest.mark.parametrize(
    "shape", [Shape(5), Shape(3, ("stops", "path", "creep", "viscous"), by_output=True)]
)
def test_the_program_reaches_the_optimum_that_another_solver_reaches(plain, shape):
    data = prepared(plain, 0.5)
    layout = Layout(Bank(RADII[::4], np.array([0.2, 1.0]), np.array([0.5, 5.0])), 0)
    rows = np.concatenate(list(fitted_rows(layout, data, "rest")))
    system, free = layout.select(shape, rows), len(layout.constants)
    found = solve_shape(layout, shape, system, rows.shape[0], ridge=1e-4)
    slopes = shape.degree
    rms = np.sqrt(np.mean(system[:, free + slopes : -1] ** 2, axis=0))
    whole = np.vstack([system[:, :-1], np.zeros((rms.size, system.shape[1] - 1))])
    whole[rows.shape[0] :, free + slopes :] = np.diag(np.sqrt(1e-4 * rows.shape[0]) * rms)
    target = np.append(system[:, -1], np.zeros(rms.size))
    low = np.concatenate([[-np.inf] * free, [0.05] * slopes, np.zeros(rms.size)])
    other = scipy.optimize.lsq_linear(
        whole, target, (low, np.inf), method="bvls", tol=1e-14, max_iter=1000
    )
    assert found.kkt_residual < 1e-12
    best = np.sum((whole @ other.x - target) ** 2)
    assert np.sum((whole @ found.unknowns - target) ** 2) <= best * (1 + 1e-9) + 1e-15


@given(st.integers(1, 7), st.data())
def test_polynomials_of_the_program_rise_where_the_data_is(degree, data):
    weights = np.array(data.draw(st.lists(st.floats(0.05, 10.0), min_size=degree, max_size=degree)))
    curve = np.polynomial.Polynomial(rising_powers(degree) @ weights)
    y = np.linspace(-1.0, 1.0, 101)
    assert np.min(curve.deriv()(y)) >= 0.05 - 1e-9
    assert abs(curve(-1.0)) < 1e-9


@pytest.mark.slow
def test_noise_on_the_input_does_not_make_the_compensator_worse_as_it_does_through_a_forward_model():
    t, y = motion()
    clean = asked(t, y, np.zeros(y.size), stops=STOPS, curve=(1.0, 0.4))
    new_t, new_y = motion(UNSEEN)
    truth = asked(new_t, new_y, np.zeros(new_y.size), stops=STOPS, curve=(1.0, 0.4))
    direct, forward = [], []
    for seed in range(3):
        noisy = log(
            t, y, clean + 0.02 * np.ptp(clean) * np.random.default_rng(seed).standard_normal(t.size)
        )
        fit = dehyst.identify(noisy, "direct-inverse", initial_state="rest", train_fraction=1.0)
        mine = fit.model.run(new_y, new_t).u
        other = (
            dehyst.identify(noisy, "modified-pi", train_fraction=1.0)
            .model.inverse()
            .simulate(new_y)
        )
        direct.append(np.sqrt(np.mean((mine - truth) ** 2)))
        forward.append(np.sqrt(np.mean((other - truth) ** 2)))
    assert np.mean(direct) < 0.01 * np.ptp(truth)
    assert np.mean(direct) < 0.5 * np.mean(forward)


@pytest.mark.slow
def test_creep_is_found_and_what_holds_still_is_told_apart_from_stops():
    t, y = motion(stroke=(1.0, 3.0, 6.0), hold=3.0)
    u = asked(t, y, np.zeros(y.size), stops=STOPS, creep=((1.0, 0.2), (6.0, 0.2)))
    fit = dehyst.identify(log(t, y, u), "direct-inverse", initial_state="rest")
    found = {each.group: each for each in fit.evidence}
    assert "creep" in fit.settings["groups"]
    assert found["creep"].there and found["creep"].p < 0.01
    assert "creep-without-holds" not in codes(fit)
    assert fit.input_test.rms_percent < 0.5
    without = dehyst.identify(log(t, y, u), "direct-inverse", initial_state="rest", creep=0)
    assert without.model.time_constants.size == 0
    assert fit.input_test.rms_percent < 0.5 * without.input_test.rms_percent


@pytest.mark.slow
def test_time_constants_wrong_by_a_factor_of_three_cost_little():
    t, y = motion(stroke=(1.0, 3.0, 6.0), hold=3.0)
    u = asked(t, y, np.zeros(y.size), stops=STOPS, creep=((1.0, 0.2), (6.0, 0.2)))
    for factor in (1 / 3, 3.0):
        times = np.array([1.0, 6.0]) * factor
        fit = dehyst.identify(
            log(t, y, u), "direct-inverse", initial_state="rest", creep_times=times
        )
        assert fit.input_test.rms_percent < 1.5
        assert set(fit.model.time_constants) <= set(times)


@pytest.mark.slow
def test_creep_in_a_log_without_holds_comes_with_a_warning():
    t, y = motion()
    u = asked(t, y, np.zeros(y.size), stops=STOPS, creep=((1.0, 0.5),))
    assert "creep-without-holds" in codes(dehyst.identify(log(t, y, u), "direct-inverse", creep=3))


def test_without_holds_creep_cannot_be_told_rather_than_is_not_found():
    t, y = motion()
    u = asked(t, y, np.zeros(y.size), stops=STOPS)
    (found,) = [
        each
        for each in dehyst.identify(log(t, y, u), "direct-inverse").evidence
        if each.group == "creep"
    ]
    assert not found.told
    assert "cannot be told from hysteresis" in str(found)


def test_errors_are_printed_with_the_digits_that_tell_them_apart():
    assert "0.160 % of range without, 0.159 %" in str(Evidence("creep", 0.1604, 0.1593, 4, 10, 0.4))
    assert "2.34 % of range without, 0.16 %" in str(Evidence("creep", 2.34, 0.16, 10, 10, 0.001))


@pytest.mark.parametrize("free", [0.0, 1.0, np.nan])
def test_dependent_free_columns_share_the_least_solution_instead_of_failing(free):
    rng = np.random.default_rng(3)
    bounded, one = rng.uniform(0, 1, (50, 4)), np.ones((50, 1))
    target = 2.0 + bounded @ [1.0, 0.0, 2.0, 0.5]
    second = 1e-14 * rng.normal(size=(50, 1)) if np.isnan(free) else free * one
    found = solve_bounded(np.column_stack([one, second, bounded, target]), 2, np.zeros(4))
    alone = solve_bounded(np.column_stack([one, bounded, target]), 1, np.zeros(4))
    np.testing.assert_allclose(found.bounded, alone.bounded, atol=1e-9)
    assert found.free.sum() == pytest.approx(2.0, abs=1e-9)
    assert np.abs(found.free).max() < 2.1


@pytest.mark.slow
@pytest.mark.parametrize("begins", [0.4, 0.08, 0.02])
def test_a_load_in_one_stretch_of_the_log_ends_in_a_finding_and_not_in_a_traceback(begins):
    t, y = motion(TIPS * 2)
    load = np.where(t < begins * t[-1], 10.0, 20.0)
    fit = dehyst.identify(
        under(load, log(t, y, asked(t, y, np.zeros(y.size), stops=STOPS))),
        "direct-inverse",
        creep=0,
    )
    assert "schedule-once" in codes(fit)
    assert "schedule-no-gain" not in codes(fit)
    assert "usable with care (schedule-once" in fit.verdict or "do not compensate" in fit.verdict


def test_the_reason_is_given_where_a_small_error_is_not_enough(plain):
    fit = dehyst.identify(plain, "direct-inverse", initial_state="rest", train_fraction=1.0)
    assert fit.verdict.endswith("usable with care (nothing held out).")


def test_a_difference_within_the_spread_of_blocks_does_not_make_a_forward_family_better(
    plain, plain_fit
):
    asked = plain_fit.input_error
    other = dehyst.identify(plain, "modified-pi")

    def found(rival_percent, uncertainty):
        best = replace(other, input_test=asked.times(rival_percent))
        findings = about_direct_fit(asked, best, True, uncertainty * asked.rms_percent)
        return "forward-better" in {finding.code for finding in findings}

    assert not found(0.94, 0.0)
    assert found(0.8, 0.05)
    assert not found(0.8, 0.15)


def test_one_branch_is_not_said_to_be_as_good_as_a_curve():
    t, y = motion()
    fit = dehyst.identify(
        log(t, y, asked(t, y, np.zeros(y.size), stops=STOPS)), "direct-inverse", train_fraction=0.05
    )
    assert "never-turns" in codes(fit)
    assert "static-as-good" not in codes(fit)
    assert "do not compensate with it" in fit.verdict


def test_a_number_of_time_constants_and_time_constants_are_not_given_together(plain):
    with pytest.raises(ParameterError, match="both given"):
        dehyst.identify(plain, "direct-inverse", creep=3, creep_times=[1.0, 5.0])


@pytest.mark.slow
def test_creep_that_is_not_there_is_said_to_be_of_no_use(plain):
    fit = dehyst.identify(plain, "direct-inverse", creep=2, initial_state="rest")
    assert "creep-no-gain" in codes(fit)
    far = dehyst.identify(plain, "direct-inverse", creep_times=[1e-4, 1e4], initial_state="rest")
    assert "creep-times-outside" in codes(far)


@pytest.mark.slow
def test_rate_dependence_is_found_where_it_is_and_nowhere_else(plain_fit):
    t, y = motion(stroke=(0.7, 2.0, 5.0))
    u = asked(t, y, np.gradient(y, t), stops=STOPS, viscous=0.2)
    noise = 0.002 * np.ptp(u) * np.random.default_rng(0).standard_normal(t.size)
    with_it = {
        e.group: e for e in dehyst.identify(log(t, y, u + noise), "direct-inverse").evidence
    }["rate"]
    still = asked(t, y, np.gradient(y, t), stops=STOPS)
    without = {
        e.group: e for e in dehyst.identify(log(t, y, still + noise), "direct-inverse").evidence
    }["rate"]
    assert with_it.there and with_it.p < 0.01
    assert not without.there


@given(st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=8))
def test_the_permutation_test_counts_exchanges(gains):
    gains = np.array(gains)
    signs = np.array(np.meshgrid(*[[1, -1]] * gains.size)).reshape(gains.size, -1).T
    expected = np.mean(signs @ gains >= np.sum(gains) - 1e-12 * np.sum(np.abs(gains)))
    assert permutation_p(gains) == pytest.approx(expected)


def test_a_path_lag_is_found():
    t, y = motion()
    u = asked(t, y, np.zeros(y.size), paths=((1.5, 0.6),), curve=(0.0, 0.5))
    fit = dehyst.identify(log(t, y, u), "direct-inverse", initial_state="rest", creep=0)
    assert "path" in fit.settings["groups"]
    assert fit.input_test.rms_percent < 0.3


@pytest.mark.slow
def test_weights_change_with_the_output_only_where_that_is_in_the_data(plain_fit):
    t, y = motion()
    u = asked(t, y, np.zeros(y.size), stops=STOPS, share=0.2 + 1.6 * np.clip((y + 10) / 20, 0, 1))
    fit = dehyst.identify(log(t, y, u), "direct-inverse", initial_state="rest", creep=0)
    assert [schedule.name for schedule in fit.model.schedules] == ["output"]
    assert fit.input_test.rms_percent < 0.5
    assert not plain_fit.model.schedules
    held = dehyst.identify(
        log(t, y, u), "direct-inverse", initial_state="rest", creep=0, position_schedule=False
    )
    assert not held.model.schedules and held.details["rises"]
    assert held.input_test.rms_percent > 3 * fit.input_test.rms_percent


def under(load, record, name="load"):
    """The recording with a signal that changes the loop."""
    return replace(record, schedules={name: load}, schedule_units={name: "N"})


@pytest.mark.slow
@pytest.mark.parametrize("name", ["load", "mean_pressure"])
def test_a_schedule_is_learnt_and_asked_for(name):
    t, y = motion(TIPS * 2)
    sigma = 2.0 + 1.5 * np.sin(0.11 * t)
    low, high = sigma[: t.size // 2].min(), sigma[: t.size // 2].max()
    share = 0.5 + np.clip((sigma - low) / (high - low), 0, 1)
    rec = log(t, y, asked(t, y, np.zeros(y.size), stops=STOPS, share=share))
    fit = dehyst.identify(under(sigma, rec, name), "direct-inverse", initial_state="rest", creep=0)
    (schedule,) = fit.model.schedules
    assert (schedule.name, schedule.unit) == (name, "N")
    assert (schedule.low, schedule.high) == pytest.approx((low, high))
    without = dehyst.identify(rec, "direct-inverse", initial_state="rest", creep=0)
    assert fit.input_test.rms_percent < 0.5
    assert fit.input_test.rms_percent < 0.3 * without.input_test.rms_percent
    answer = fit.model.run(y, t, given={name: sigma}).u
    np.testing.assert_allclose(answer, fit.inverse_predictions[0], atol=1e-9)
    with pytest.raises(ParameterError, match=name):
        fit.model.run(y, t)


def test_a_schedule_that_changes_nothing_is_said_to_be_of_no_use(plain):
    noise = np.random.default_rng(0).standard_normal(len(plain))
    fit = dehyst.identify(under(noise, plain), "direct-inverse", initial_state="rest")
    assert "schedule-no-gain" in codes(fit)


def test_after_a_gap_memory_begins_anew_and_samples_count_once_it_is_known(plain):
    k = len(plain) // 4
    gap = dehyst.Recording(
        input=plain.input, output=plain.output, time=np.where(np.arange(len(plain)) < k, plain.time, plain.time + 50),
        breaks=(k,),
    )  # fmt: skip
    fit = dehyst.identify(gap, "direct-inverse", initial_state="rest", train_fraction=1.0)
    assert "unknown-memory" in codes(fit)
    mask = fit.train_masks[0]
    assert mask[:k].all() and not mask[k]
    begins = k + int(np.argmax(mask[k:]))
    part = plain.output[k:begins]
    reach = np.ptp(plain.output)
    assert (
        part.min() < plain.output.min() + 0.03 * reach
        or part.max() > plain.output.max() - 0.03 * reach
    )
    assert fit.input_train.rms_percent < 0.2


def test_uneven_sampling_is_no_noise():
    t, y = motion(stroke=(1.0, 3.0, 6.0), hold=3.0)
    u = asked(t, y, np.zeros(y.size), stops=STOPS, creep=((2.0, 0.3),))
    kept = np.sort(np.random.default_rng(0).choice(t.size, t.size // 2, replace=False))
    turns = dehyst.data._loops.turning_points(y)
    kept = np.union1d(kept, turns)
    fit = dehyst.identify(
        log(t[kept], y[kept], u[kept]), "direct-inverse", initial_state="rest", creep_times=[2.0]
    )
    assert fit.input_test.rms_percent < 1.0


def test_without_time_stops_are_found_and_creep_is_refused(plain):
    bare = dehyst.Recording(input=plain.input, output=plain.output)
    fit = dehyst.identify(bare, "direct-inverse", initial_state="rest")
    assert fit.input_test.rms_percent < 0.1
    assert fit.evidence == ()
    with pytest.raises(ParameterError, match="--time"):
        dehyst.identify(bare, "direct-inverse", creep=3)


@pytest.mark.slow
def test_an_unknown_past_is_not_taken_for_rest():
    t, y = motion((1.0, -1.0) * 6)
    u = asked(t, y, np.zeros(y.size), stops=((4.0, 1.0),), curve=(0.0, 0.3))
    begin = int(np.argmax(y)) + 60  # within a falling branch: the stops are loaded
    late = log(t[begin:], y[begin:], u[begin:])
    fit = dehyst.identify(late, "direct-inverse", creep=0)
    assert fit.settings["start"] != "rest"
    assert fit.model.past == fit.settings["start"]
    # The model begins as its own log did.
    error = np.sqrt(np.mean((fit.model.run(late.output, late.time).u - late.input) ** 2))
    assert 100.0 * error / np.ptp(late.input) < 0.5
    assert fit.input_train.rms_percent < 0.5
    assert (
        dehyst.identify(late, "direct-inverse", creep=0, initial_state="rest").train.rmse
        > 3 * fit.train.rmse
    )


def test_the_comparison_is_that_of_the_forward_families_on_the_same_samples(plain, plain_fit):
    own, *rows = plain_fit.table
    assert (
        own.chosen
        and own.family == plain_fit.family
        and own.input_percent == plain_fit.input_error.rms_percent
    )
    assert {row.family for row in rows} == {"pi", "pi-cumulative", "modified-pi", "stop", "static"}
    for row in rows[:-1]:
        fit = dehyst.identify(plain, row.family)
        assert row.input_percent == pytest.approx(fit.input_error.rms_percent)
        assert row.test_percent == pytest.approx(fit.output_error.rmse_percent)
    inputs = [row.input_percent for row in rows[:-1]]
    assert inputs == sorted(inputs)
    assert (
        all(row.tracking_percent is not None for row in (own, *rows))
        and plain_fit.tracking == own.tracking_percent
    )


def test_the_one_verdict_judges_it_by_both_errors_and_the_json_has_the_one_shape(plain, plain_fit):
    other = dehyst.identify(plain, "pi")
    assert isinstance(plain_fit, type(other))
    mine, theirs = plain_fit.as_dict(), other.as_dict()
    assert set(mine) - set(theirs) == {
        "degree",
        "groups",
        "time_constants",
        "rises",
        "missed",
    }
    assert (
        set(theirs) <= set(mine)
        and mine["grade"] == str(plain_fit.grade) == f"{plain_fit.grade}" == "good"
    )
    assert (
        plain_fit.output_error == plain_fit.test
        and mine["test"]["rmse_percent"] == plain_fit.test.rmse_percent
    )
    assert plain_fit.size in plain_fit.verdict and plain_fit.size in repr(plain_fit)
    assert mine["elements"] == ["stop"] and mine["direction"] == "inverse"


def test_a_family_that_is_named_stands_beside_the_curve_in_its_table(plain):
    for name in ("pi", "creep-pi", "dahl"):
        fit = dehyst.identify(plain, name)
        assert [(row.family, row.chosen) for row in fit.table] == [
            (fit.family, True),
            ("static", False),
        ]
        assert fit.tracking is None  # there is no other model with a memory to play its inverse on


def test_creep_without_holds_is_told_of_every_row_that_answers_otherwise_at_another_speed(plain):
    t, y = motion()
    crept = log(t, y, asked(t, y, np.zeros(y.size), stops=STOPS, creep=((1.0, 0.5),)))
    assert "creep-without-holds" in codes(dehyst.identify(crept, "inverse-stop"))
    assert "creep-without-holds" not in codes(
        dehyst.identify(crept, "generalised-pi")
    )  # which knows no time
    assert "creep-without-holds" not in codes(
        dehyst.identify(plain, "creep-pi")
    )  # a log without time


def test_a_forward_family_that_is_better_is_named():
    t, y = motion((0.1, -0.1) * 3 + TIPS)
    u = asked(t, y, np.zeros(y.size), stops=STOPS)
    # Hardly anything of the range is fitted.
    fit = dehyst.identify(log(t, y, u), "direct-inverse", train_fraction=0.2, creep=0)
    assert codes(fit) & {"extrapolation", "forward-better"}
    assert "good for compensation" not in fit.verdict


def test_blocks_of_rows_in_parts_are_those_of_all_rows_at_once():
    rows = np.random.default_rng(0).standard_normal((103, 5))
    parts = [rows[:1], rows[1:40], rows[40:41], rows[41:]]
    blocks = reduced_blocks(parts, 103, 4)
    assert sum(block.samples for block in blocks) == 103
    edges = np.cumsum([0, *(block.samples for block in blocks)])
    for block, a, b in zip(blocks, edges[:-1], edges[1:], strict=True):
        np.testing.assert_allclose(block.rows.T @ block.rows, rows[a:b].T @ rows[a:b], atol=1e-12)


def test_a_long_log_is_chosen_and_fitted_on_rows_spread_over_it(plain, plain_fit, monkeypatch):
    monkeypatch.setattr(selection, "MOST_ROWS", 300)
    fit = dehyst.identify(plain, "direct-inverse", initial_state="rest")
    assert fit.settings["groups"] == plain_fit.settings["groups"]
    if fit.settings["degree"] == plain_fit.settings["degree"]:
        np.testing.assert_allclose(
            fit.inverse_predictions[0], plain_fit.inverse_predictions[0], atol=1e-3
        )


# Reading the model forward.


@st.composite
def invertible(draw):
    """A model that rises whatever the past, and what its schedule is given."""
    schedules = draw(
        st.sampled_from(
            [(), (Schedule("load", 1.0, 3.0, "N"),), (Schedule("output", -10.0, 10.0),)]
        )
    )
    sets, card = (
        max(1, 2 * len(schedules)),
        ModelCard(SignalCard("u"), SignalCard("y", "", -10.0, 10.0)),
    )
    of_output = bool(schedules) and not schedules[0].outside

    def rows(count, most):
        first = [draw(st.floats(0.0, most)) for _ in range(count)]
        # Sets of the output's schedule may differ by as little as the curve's slope allows.
        return [first] + [
            [
                value + draw(st.floats(0.0, 0.01)) if of_output else draw(st.floats(0.0, most))
                for value in first
            ]
            for _ in range(sets - 1)
        ]

    curve = [draw(st.floats(-1.0, 1.0)), draw(st.floats(0.2, 2.0)), 0.0, draw(st.floats(0.0, 0.01))]
    model = dehyst.models.DirectInverse(
        radii=[0.3, 2.0, 6.0], stop_weights=rows(3, 2.0), path_lengths=[0.5, 4.0], path_weights=rows(2, 2.0),
        time_constants=[0.3, 4.0], creep_weights=rows(2, 2.0), polynomial=[curve] * sets,
        viscous=[draw(st.floats(0.0, 0.5))] * sets, schedules=schedules, card=card,
    )  # fmt: skip
    assert model.least_slope() > 0.0
    return model


@settings(max_examples=40, deadline=None)
@given(invertible(), st.sampled_from([(0.5,), (0.5, 2.0)]))
def test_reading_a_model_forward_undoes_it(model, stroke):
    t, y = motion((0.9, -0.7, 0.3, -0.2), stroke=stroke, hold=0.2)
    rate, load = np.concatenate([[0.0], np.diff(y) / np.diff(t)]), 2.0 + 1.5 * np.sin(t)
    u = model.run(y, t, rate=rate, given={"load": load}).u
    found = follow(model, u, t, {"load": load}, start="rest")
    assert found.missed == 0
    np.testing.assert_allclose(
        found.y, y, atol=1e-4
    )  # the first sample is interpolated, and what it leaves fades


def test_an_input_that_nothing_needs_is_counted_and_not_followed():
    card = ModelCard(SignalCard("u"), SignalCard("y", "", -1.0, 1.0))
    model = dehyst.models.DirectInverse(polynomial=[0.0, 1.0], card=card)
    found = follow(model, [0.0, 1.0, 50.0, 0.5], start="rest")
    assert found.missed == 1
    assert found.y.max() <= 1.2 + 1e-9
    assert found.y[-1] == pytest.approx(0.5)


# What is refused.


def test_settings_that_are_none_are_refused_with_a_cure(plain):
    for change, words in (
        ({"creep": -1}, "creep"),
        ({"creep": 2.5}, "creep"),
        ({"creep": "many"}, "creep"),
        ({"creep": True}, "creep"),
        ({"creep_times": [3.0, 1.0]}, "increase"),
        ({"creep_times": [0.0, 1.0]}, "positive"),
        ({"creep_times": list(range(1, 20))}, "at most"),
        ({"initial_state": "asleep"}, "initial_state"),
        ({"train_fraction": 1.5}, "train_fraction"),
    ):
        with pytest.raises(ParameterError, match=words):
            dehyst.identify(plain, "direct-inverse", **change)


def test_signals_that_tell_nothing_are_refused_with_a_cure(plain):
    for rec, words in (
        (dehyst.Recording(input=np.ones(100), output=np.sin(np.arange(100.0))), "stays at"),
        (dehyst.Recording(input=np.sin(np.arange(100.0)), output=np.ones(100)), "stays at"),
        (
            dehyst.Recording(input=np.sin(np.arange(20.0)), output=np.sin(np.arange(20.0))),
            "samples",
        ),
        (log(plain.time, -plain.output, plain.input), "Turn the sign"),
    ):
        with pytest.raises(ExcitationError, match=words):
            dehyst.identify(rec, "direct-inverse")
    with pytest.raises(ExcitationError, match="stays at"):
        dehyst.identify(under(np.full(len(plain), 3.0), plain), "direct-inverse")


def test_identify_leads_there_and_refuses_settings_of_other_families(plain, plain_fit):
    fit = dehyst.identify(plain, "direct-inverse", initial_state="rest")
    assert isinstance(fit, dehyst.Fit)
    assert fit.test == plain_fit.test
    for change in (
        {"n": 50},
        {"eps": 0.1},
        {"thresholds": [0.0, 1.0]},
        {"weights": np.ones(len(plain))},
    ):
        with pytest.raises(ParameterError, match=next(iter(change))):
            dehyst.identify(plain, "direct-inverse", **change)


def test_loops_that_run_the_other_way_are_not_called_a_compensator():
    t, y = motion()
    u = 0.5 * y - 0.05 * np.gradient(y, t) * 3.0  # the input lags: no term can show it
    fit = dehyst.identify(log(t, y, u), "direct-inverse")
    assert {"static-as-good", "poor-fit"} & codes(fit)
    assert "do not compensate with it" in fit.verdict


def test_several_recordings_are_fitted_together(plain):
    t, y = motion(UNSEEN)
    second = log(t, y, asked(t, y, np.zeros(y.size), stops=STOPS, curve=(1.0, 0.4, 0.0, 0.002)))
    fit = dehyst.identify([plain, second], "direct-inverse", initial_state="rest")
    assert [p.size for p in fit.inverse_predictions] == [len(plain), len(second)]
    assert fit.input_test.rms_percent < 0.2


def test_what_a_log_separates_is_measured():
    t, y = motion((1.0, -1.0), stroke=2.0, hold=5.0)
    low, high = separable(prepared(log(t, y, y), 1.0))
    assert high == pytest.approx(t[-1] / 3)
    assert low == pytest.approx(max(0.06, high / 300))
