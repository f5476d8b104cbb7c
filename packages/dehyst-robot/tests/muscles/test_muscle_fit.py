"""Fits of muscle models to bench logs: the optimum, what it is worth, and what the log cannot tell."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from dehyst.errors import ParameterError, RecordingError
from dehyst_robot.muscles import (
    BenchLog,
    fit_muscle,
    load_muscle,
    muscle,
    muscle_names,
    parameter_names,
)
from dehyst_robot.muscles._fit import forces
from dehyst_robot.muscles._registry import save_muscle

BAR = 1e5
# DMSP-20 of 300 mm, measured: Martens, Boblan, Actuators 6(4), 2017, appendix A; force [N], rows of pressure [kPa].
LENGTHS = np.array([296.0, 282.0, 267.0, 250.0, 237.0, 222.0])
MEASURED = {
    110.0: (179.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    157.5: (300.2, 42.9, 0.0, 0.0, 0.0, 0.0),
    197.5: (402.5, 131.0, 27.7, 0.0, 0.0, 0.0),
    250.0: (543.4, 244.7, 122.0, 0.0, 0.0, 0.0),
    312.5: (708.8, 380.4, 221.0, 80.6, 0.0, 0.0),
    375.0: (870.9, 518.9, 328.0, 157.6, 0.0, 0.0),
    450.0: (1065.2, 676.4, 462.3, 252.1, 65.5, 0.0),
    525.0: (1268.9, 837.5, 587.8, 352.3, 124.7, 0.0),
    600.0: (1460.1, 1004.0, 714.8, 443.5, 188.1, 0.0),
    675.0: (1653.5, 1164.3, 840.7, 535.8, 253.3, 0.0),
}
CONTRACTION = np.tile(1.0 - LENGTHS / 296.0, len(MEASURED))
PRESSURE = 1e3 * np.repeat(list(MEASURED), LENGTHS.size)
FORCE = np.array(list(MEASURED.values())).ravel()


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def grid(model, noise=0.0, seed=0, top=6.0):
    """Log of a model at rest, on a grid up to 90 % of what it can."""
    k, p = (
        each.ravel()
        for each in np.meshgrid(np.linspace(0.0, 0.2, 15), np.linspace(1.5, top, 8) * BAR)
    )
    force = np.maximum(model.static_force(k, p), 0.0)
    return BenchLog(
        k, p, force + noise * np.random.default_rng(seed).standard_normal(k.size) * (force > 0)
    )


def motion(model, noise=0.0, seed=0):
    """Log of loops of contraction at three pressures and two speeds."""
    time = np.arange(0.0, 60.0, 0.05)
    k = 0.07 - 0.05 * np.cos(2 * np.pi * np.where(time < 40, time / 20, 4 + (time - 40) / 1.5)) * (
        1 - time / 150
    )
    p = BAR * (2.5 + np.clip(np.floor(time / 20), 0, 2))
    p = np.convolve(np.pad(p, 20, mode="edge"), np.ones(21) / 21, mode="same")[20:-20]
    force = model.simulate(k, p, time)
    return BenchLog(k, p, force + noise * np.random.default_rng(seed).standard_normal(k.size), time)


@pytest.fixture(scope="module")
def measured():
    return BenchLog(CONTRACTION, PRESSURE, FORCE, name="map of Martens and Boblan")


@pytest.fixture(scope="module")
def sarosi(measured):
    return fit_muscle(measured, "sarosi")


def test_sarosi_s_form_fits_the_measured_map_as_well_as_a_search_of_its_own_does(sarosi):
    pulls, p, k = FORCE > 0, PRESSURE / BAR, 100 * CONTRACTION

    def form(v):
        return (v[0] * p + v[1]) * np.exp(v[2] * k) + v[3] * k * p + v[4] * p + v[5]

    published = [6.0078, 197.06, -0.5591, -8.5853, 256.07, -309.60]  # of another fit to this map
    best = least_squares(lambda v: (form(v) - FORCE)[pulls], published, x_scale=np.abs(published))
    assert sarosi.rmse == pytest.approx(rms(best.fun), rel=1e-6)
    assert sarosi.rmse == pytest.approx(7.43, abs=0.01)
    assert sarosi.rmse <= rms((form(published) - FORCE)[pulls])


def test_over_the_whole_measured_map_with_slack_as_no_force_it_is_about_6_newton(sarosi):
    assert rms(np.maximum(sarosi.force, 0.0) - FORCE) == pytest.approx(6.2, abs=0.3)


def test_all_but_the_exponent_is_solved_in_closed_form(sarosi):
    assert sarosi.linear == ("a1", "a2", "a4", "a5", "a6")


def test_a_polynomial_fit_is_linear_least_squares(measured):
    found = fit_muscle(measured, "aschemann-schindele")
    pulls = FORCE > 0
    terms = np.stack(
        [PRESSURE * CONTRACTION**m for m in range(4)] + [-(CONTRACTION**n) for n in range(5)],
        axis=1,
    )[pulls]
    best = np.linalg.lstsq(terms / np.linalg.norm(terms, axis=0), FORCE[pulls], rcond=None)
    assert found.rmse == pytest.approx(np.sqrt(best[1][0] / pulls.sum()), rel=1e-6)
    assert len(found.linear) == 9
    assert found.rmse < 3.0


@pytest.mark.slow
def test_every_model_is_bent_to_the_measured_map_and_rubber_is_what_the_geometry_lacks(measured):
    errors = {name: fit_muscle(measured, name).rmse_percent for name in muscle_names()}
    assert all(np.isfinite(error) for error in errors.values())
    assert errors["chou-hannaford"] > 5.0 > errors["boblan-martens"] > errors["sarosi"]


def test_samples_left_out_are_missed_by_more_than_those_that_were_fitted(sarosi):
    assert sarosi.rmse < sarosi.held_out < 2 * sarosi.rmse


def test_where_the_muscle_hangs_loose_no_sample_counts(sarosi):
    assert int(sarosi.used.sum()) == int((FORCE > 0).sum()) == 37
    slack = next(entry for entry in sarosi.findings if entry.code == "muscle-slack")
    assert "23 of 60 samples" in slack.message


@pytest.mark.parametrize(
    "name", ["maker", "sarosi", "aschemann-schindele", "boblan-martens", "tondu-lopez", "klute"]
)
def test_a_model_s_own_forces_with_noise_are_met_to_the_noise(name):
    truth = muscle(name)
    force = truth.static_force(0.0, 6 * BAR)
    sigma = 0.005 * float(force)
    log = grid(truth, sigma)
    start = truth.with_vector(
        truth.vector() * (1 + 0.15 * np.sin(1 + np.arange(truth.vector().size)))
    )
    found = fit_muscle(log, start)
    missed = (forces(found.model, log) - truth.static_force(log.contraction, log.pressure))[
        found.used
    ]
    assert rms(missed) < 0.6 * sigma
    assert 0.8 * sigma < found.held_out < 1.4 * sigma


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "which", "friction"),
    [
        ("chou-hannaford", "DMSP-40", "band"),
        ("tondu-zagal", "rayon", "drag"),
        ("kerscher", "", "damping_pressure"),
    ],
)
def test_friction_is_found_in_a_motion_and_kept_where_there_is_none(name, which, friction):
    truth = muscle(name, which)
    start = truth.with_vector(
        np.where(np.array(parameter_names(truth)) == friction, 1.5, 1.05) * truth.vector()
    )
    moved = fit_muscle(motion(truth, noise=2.0), start)
    away = getattr(moved.model, friction) - getattr(truth, friction)
    assert abs(away) < min(4 * moved.standard_errors[friction], 0.3 * getattr(truth, friction))
    assert 1.8 < moved.rmse < 2.2
    still = fit_muscle(motion(truth).at_rest(), start)
    assert friction in still.without_effect
    assert getattr(still.model, friction) == getattr(start, friction)
    assert any(
        entry.code == "muscle-not-in-log" and friction in entry.message for entry in still.findings
    )


@pytest.mark.slow
def test_standard_errors_are_the_scatter_of_repeated_logs():
    truth = muscle("sarosi", "DMSP-20-map")
    fits = [fit_muscle(grid(truth, 5.0, seed), truth) for seed in range(24)]
    scatter = np.std([fit.model.vector() for fit in fits], axis=0, ddof=1)
    told = np.array([fits[0].standard_errors[name] for name in parameter_names(truth)])
    assert np.all((told / scatter > 0.6) & (told / scatter < 1.7))


def test_errors_that_follow_each_other_make_wider_intervals():
    truth = muscle("aschemann-schindele")
    log = motion(truth)
    slow = 10.0 * np.sin(log.time)
    fit = fit_muscle(BenchLog(log.contraction, log.pressure, log.force + slow, log.time), truth)
    loose = fit_muscle(BenchLog(log.contraction, log.pressure, log.force + slow), truth)
    assert fit.standard_errors["b[0]"] > 3 * loose.standard_errors["b[0]"]


def test_the_same_seed_gives_the_same_fit_and_another_one_the_same_optimum(measured):
    first, again, other = (fit_muscle(measured, "maker", seed=seed) for seed in (0, 0, 7))
    assert first.model == again.model and first.held_out == again.held_out
    assert other.rmse == pytest.approx(first.rmse, rel=1e-4)


def test_one_pressure_and_half_the_stroke_are_said_to_be_too_little():
    truth = muscle("sarosi", "DMSP-20-map")
    k = np.linspace(0.0, 0.08, 40)
    log = BenchLog(k, np.full(k.size, 4 * BAR), truth.static_force(k, np.full(k.size, 4 * BAR)))
    fit = fit_muscle(log, "sarosi")
    codes = {entry.code for entry in fit.findings}
    assert {"muscle-one-pressure", "muscle-extrapolation", "muscle-undetermined"} <= codes
    assert fit.rmse < 1e-3 * float(log.force.max())


def test_a_model_that_cannot_follow_says_so(measured):
    found = fit_muscle(measured, "chou-hannaford")
    poor = next(entry for entry in found.findings if entry.code == "muscle-poor-fit")
    assert f"{found.rmse_percent:.1f} %" in poor.message


@pytest.mark.slow
def test_parameters_stay_within_their_bounds(measured):
    for name in ("tondu-lopez", "klute", "kerscher"):
        fit = fit_muscle(measured, name)
        low, high = fit.model.bounds()
        assert np.all((low <= fit.model.vector()) & (fit.model.vector() <= high))


def test_a_long_motion_is_fitted_in_seconds_and_all_of_it_counts():
    truth = muscle("chou-hannaford")
    time = np.arange(0.0, 300.0, 0.01)
    k = 0.08 - 0.06 * np.cos(2 * np.pi * time / 7.0)
    p = BAR * (3.0 + np.sin(2 * np.pi * time / 61.0))
    log = BenchLog(k, p, truth.simulate(k, p, time), time)
    fit = fit_muscle(log, muscle("chou-hannaford", band=10.0))
    assert fit.model.band == pytest.approx(truth.band, rel=0.02)
    assert fit.used.size == time.size


def test_too_few_samples_or_columns_of_two_logs_are_refused():
    with pytest.raises(RecordingError, match="6 at least"):
        BenchLog([0.0], [1e5], [10.0])
    with pytest.raises(RecordingError, match="must be of one log"):
        BenchLog(np.zeros(8), np.zeros(8), np.zeros(9))
    with pytest.raises(RecordingError, match="not finite"):
        BenchLog(np.zeros(8), np.zeros(8), np.full(8, np.nan))
    log = BenchLog(np.linspace(0, 0.1, 8), np.full(8, 3e5), np.linspace(900, 300, 8))
    with pytest.raises(RecordingError, match="any of them would do"):
        fit_muscle(log, "aschemann-schindele")
    with pytest.raises(RecordingError, match="stays at 50 N"):
        fit_muscle(BenchLog(log.contraction, log.pressure, np.full(8, 50.0)), "maker")
    with pytest.raises(RecordingError, match=r"does not increase after sample 3.*--at-rest"):
        BenchLog(log.contraction, log.pressure, log.force, np.arange(8.0) % 4)
    with pytest.raises(ParameterError, match="from 0 on"):
        fit_muscle(log, "maker", seed=-1)
    with pytest.raises(ParameterError, match="no muscle model"):
        fit_muscle(log, "unknown")
    with pytest.raises(ParameterError, match="not a length or per cent"):
        fit_muscle(
            BenchLog(np.linspace(0, 30, 20), np.full(20, 3e5), np.linspace(900, 300, 20)),
            "chou-hannaford",
        )


def test_a_saved_muscle_comes_back_bit_for_bit(tmp_path, measured):
    for name in muscle_names():
        model = fit_muscle(measured, name).model if name == "maker" else muscle(name)
        assert load_muscle(save_muscle(model, tmp_path / f"{name}.json")) == model
