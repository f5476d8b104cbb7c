"""Where no memory is found, the answer is a curve, and all that can be done with a model can be done with it."""

import json

import numpy as np
import pytest

import dehyst
from dehyst.data import kit as data_kit
from dehyst.report import write_report

SIZES = (1.9, -1.7, 1.4, -2.0, 1.0, -0.4, 1.5, -1.0, 2.0, -1.2, 0.3, -0.7, 0.9, -1.6)


def recording(respond, noise=0.05, seed=0):
    corners = [0.0, *SIZES * 4, 0.0]
    x = np.interp(np.arange((len(corners) - 1) * 40 + 1) / 40, range(len(corners)), corners)
    y = respond(x) + noise * np.random.default_rng(seed).standard_normal(x.size)
    return dehyst.Recording(
        input=x, output=y, time=0.02 * np.arange(x.size), input_name="p", output_name="q"
    )


def bent(x):
    return x + 0.1 * x**3


def falling(x):
    return -2.0 * x + 0.3 * x**2


def open_by_turns(x):
    """A loop that lags in one stretch and leads in the next: hysteresis that does not repeat."""
    play = dehyst.PrandtlIshlinskii([0.0, 0.4], [0.4, 0.6]).simulate(x)
    sign = 1.0 - 2.0 * (np.arange(x.size) // 80 % 2)
    return x + sign * (x - play)


def codes(fit):
    return [finding.code for finding in fit.warnings]


@pytest.mark.slow
@pytest.mark.spread(4)
@pytest.mark.parametrize("respond", [bent, falling, open_by_turns, lambda x: np.tanh(2.0 * x)])
def test_auto_is_never_worse_than_the_curve_where_the_training_part_says_so(respond):
    fit = dehyst.identify(recording(respond))
    assert fit.family == "static" and isinstance(fit.model, dehyst.models.StaticCurve)
    assert fit.test.rmse <= 1.05 * fit.static_test.rmse
    assert "no-hysteresis" in codes(fit) and "static-as-good" not in codes(fit)
    assert "hysteresis was not found, or does not repeat" in fit.verdict
    assert [c.family for c in fit.candidates if c.chosen] == ["static"]
    best = min(c.error_percent for c in fit.candidates if c.family != "static")
    assert fit.candidates[0].error_percent <= best / 0.95


@pytest.mark.slow
def test_where_a_loop_repeats_the_curve_is_a_row_of_the_comparison_and_not_the_answer():
    fit = dehyst.identify(recording(dehyst.PrandtlIshlinskii([0.0, 0.3], [1.0, 0.3]).simulate))
    assert fit.family != "static" and "no-hysteresis" not in codes(fit)
    assert [c.family for c in fit.candidates].count("static") == 1


@pytest.mark.slow
def test_held_out_samples_do_not_decide():
    rec = recording(bent)
    half = len(rec) // 2
    later = rec.output.copy()
    later[half:] = dehyst.PrandtlIshlinskii([0.0, 0.5], [0.5, 1.0]).simulate(rec.input)[half:]
    other = dehyst.identify(dehyst.Recording(input=rec.input, output=later, time=rec.time))
    first = dehyst.identify(rec)
    assert other.family == first.family == "static"
    assert np.array_equal(other.predictions[0], first.predictions[0])


@pytest.mark.parametrize("respond", [bent, falling])
def test_a_curve_by_name_is_the_bar_of_every_fit(respond):
    rec = recording(respond)
    fit = dehyst.identify(rec, "static")
    assert np.array_equal(fit.predictions[0], fit.static.simulate(rec.input))
    assert "no-hysteresis" not in codes(fit) and fit.candidates == ()
    assert np.abs(fit.model.inverse().simulate(fit.predictions[0]) - rec.input).max() < 1e-9
    assert (fit.certificate.operators, fit.certificate.nonzero_weights) == (0, 0)
    assert fit.certificate.kkt_residual < 1e-12


@pytest.mark.slow
def test_the_error_of_a_curve_is_the_mean_over_fits_without_a_fifth_of_the_way():
    rec = recording(bent)
    half = len(rec) // 2
    fitted = np.arange(len(rec)) < half
    (share,) = data_kit.shares_of([rec.input], [fitted])
    means = []
    for fold in data_kit.folds_of(share):
        errors = []
        for number in range(data_kit.FOLDS):
            left_out = fitted & (fold == number)
            curve = dehyst.identify(rec, "static", weights=1.0 - left_out).model
            miss = curve.simulate(rec.input) - rec.output
            errors.append(np.sqrt(np.average(miss[left_out] ** 2, weights=share[left_out])))
        means.append(np.mean(errors))
    span = np.ptp(rec.output[:half])
    expected = 100.0 * np.sqrt(means[0] * means[1]) / span
    shown = next(c for c in dehyst.identify(rec).candidates if c.family == "static")
    assert shown.error_percent == pytest.approx(expected, rel=0.02)


def test_the_slope_of_a_saturating_curve_is_bounded_as_that_of_any_model():
    rec = recording(lambda x: np.tanh(2.0 * x), noise=0.02)
    ratio = np.ptp(rec.output) / np.ptp(rec.input)
    chosen, loose = dehyst.identify(rec, "static"), dehyst.identify(rec, "static", eps=0.001)
    assert loose.certificate.inverse_gain * ratio > 20.0 >= chosen.certificate.inverse_gain * ratio
    assert "high-inverse-gain" in codes(loose) and codes(chosen) == []
    within = dehyst.identify(rec, max_inverse_gain=5.0 / ratio)
    assert within.family == "static" and within.certificate.inverse_gain <= 5.0 / ratio * (1 + 1e-9)


@pytest.mark.slow
def test_a_curve_is_saved_played_exported_verified_reported_and_watched(run, tmp_path):
    rec = recording(bent)
    log, model = tmp_path / "log.csv", tmp_path / "m.json"
    table = np.column_stack([rec.time, rec.input, rec.output])
    np.savetxt(log, table, delimiter=",", header="time_s,p_bar,q_deg", comments="")
    status, out, err = run(
        "identify", log, "--input", "p_bar", "--output", "q_deg", "--save", model, "--json"
    )
    assert status == 0, err
    result = json.loads(out)
    assert (result["family"], result["n"], result["nonzero_weights"]) == ("static", 0, 0)
    curve = dehyst.load(model)
    for command in (
        ["simulate", model, log, "--input", "p_bar"],
        ["compensate", model, log, "--output", "q_deg"],
    ):
        status, out, err = run(*command)
        assert status == 0 and len(out.splitlines()) == len(rec) + 1, err
    assert run("drift", model, log)[0] == 0
    for target in ("c", "st"):
        folder = tmp_path / target
        assert run("export", model, "--target", target, "--out", folder)[0] == 0
        assert run("verify", folder)[0] == 0
    text = write_report(
        dehyst.identify(dehyst.read_log(log, "p_bar", "q_deg")), tmp_path / "r.html"
    ).read_text()
    assert "the model is the curve" in text and "0 operators" not in text
    assert np.array_equal(curve.simulate(rec.input), dehyst.identify(rec).predictions[0])
