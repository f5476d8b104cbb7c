"""The scale k of the sheared loop: subtracted exactly, no step at reversals."""

import json
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

import dehyst
from dehyst import PrandtlIshlinskii, Recording, StopOperatorModel
from dehyst.cli import app
from dehyst.errors import InvertibilityError, ParameterError
from dehyst.models import ShearedPrandtlIshlinskii
from dehyst_robot.control import InverseCompensator, JointController, JointControllerParameters

RESOLUTION = 2 * np.pi / 2**17  # of the arm's encoders [rad]


def nested_loops(samples=200):
    tips = [
        0,
        0.6,
        -0.6,
        0.5,
        -0.5,
        0.4,
        -0.3,
        0.2,
        -0.1,
        0.0,
        0.55,
        -0.2,
        0.3,
        -0.45,
        0.6,
        -0.6,
        0.1,
        0,
    ]
    return np.interp(
        np.linspace(0, len(tips) - 1, samples * (len(tips) - 1) + 1), range(len(tips)), tips
    )


def friction_log(noise=0.01, seed=0):
    """Hysteresis of a joint whose backbone was taken off: Maxwell slip in bar over an angle in rad, with noise."""
    q = nested_loops()
    radii = np.array([0.0, 0.01, 0.03, 0.08, 0.2, 0.4])
    u = StopOperatorModel(radii, np.array([0.0, 3.0, 1.5, 0.8, 0.3, 0.1]), slope=0.0).simulate(q)
    u = u + noise * np.random.default_rng(seed).standard_normal(u.size)
    q = np.round(q / RESOLUTION) * RESOLUTION
    return Recording(
        input=u, output=q, time=0.02 * np.arange(q.size), input_name="hysteresis", output_name="angle",
        input_unit="bar", output_unit="rad",
    )  # fmt: skip


@pytest.fixture(scope="module")
def log():
    return friction_log()


@pytest.fixture(scope="module")
def fit(log):
    return dehyst.identify(log, shear=5.0)


@st.composite
def loops_with_k(draw):
    n = draw(st.integers(1, 6))
    gaps = draw(st.lists(st.floats(0.01, 1.0), min_size=n, max_size=n))
    weights = draw(st.lists(st.floats(0.01, 2.0), min_size=n, max_size=n))
    thresholds = np.cumsum([0.0, *gaps[1:]])
    operator = PrandtlIshlinskii(
        thresholds, weights, draw(st.floats(-2, 2)), None, draw(st.floats(-2, 2))
    )
    return operator, draw(st.floats(0.0, 20.0))


paths = st.lists(st.floats(-3, 3), min_size=1, max_size=30)


@given(loops_with_k(), paths)
def test_the_compensator_is_the_inverse_less_k_y_on_every_path(loop, path):
    operator, k = loop
    y = np.array(path)
    wanted = operator.inverse().simulate(y) - k * y
    got = ShearedPrandtlIshlinskii(operator, k).inverse().simulate(y)
    scale = (
        np.max(np.abs(operator.inverse().simulate(y)))
        + k * np.max(np.abs(y))
        + operator.inverse_gain * 5
    )
    np.testing.assert_allclose(got, wanted, rtol=0, atol=1e-13 * scale)


@given(loops_with_k(), paths, st.floats(0.01, 0.95))
def test_with_all_slopes_positive_the_model_runs_forward_and_its_inverse_undoes_it(
    loop, path, share
):
    operator, _ = loop
    model = ShearedPrandtlIshlinskii(operator, share / operator.partial_sums[-1])
    assert model.has_forward
    u = np.array(path)
    y = model.simulate(u)
    np.testing.assert_allclose(model.inverse().simulate(y), u, rtol=0, atol=1e-9)
    np.testing.assert_allclose(operator.simulate(u + model.shear * y), y, rtol=0, atol=1e-9)


def test_without_a_forward_model_it_refuses_and_names_what_works(fit):
    assert not fit.model.has_forward
    with pytest.raises(InvertibilityError, match=r"only runs as a compensator.*model\.inverse\(\)"):
        fit.model.simulate([0.0, 0.1])


def test_the_k_whose_inverse_errs_least_on_held_out_blocks_is_nearer_to_the_truth_behind_the_noise(
    log,
):
    truth = friction_log(noise=0.0)
    table = dehyst.cross_validate(log, families=["pi"], shear=[0.5, 1.0, 2.0, 5.0, 10.0], eps=0.001)
    miss = {}
    for k in (0.5, table.best("inverse_error").shear):
        compensator = dehyst.identify(log, shear=k).model.inverse()
        miss[k] = np.std(compensator.simulate(truth.output) - truth.input)
    small, best = miss.values()
    assert best < 0.5 * small
    assert best < 0.05 * np.std(truth.input)


def steps_after_reversals(compensator, turns):
    """Largest change of the output when the input moves one resolution back from each turning point."""
    found = []
    for turn in turns:
        step = compensator.stepper()
        for q in np.linspace(0.0, turn, 500):
            step(q)
        before = step.output
        found.append(abs(step(turn - np.sign(turn) * RESOLUTION) - before))
    return max(found)


@pytest.mark.parametrize("gain", [5.0, 20.0])
def test_one_resolution_after_a_reversal_the_output_moves_by_at_most_the_gain(log, gain):
    fit = dehyst.identify(log, shear=5.0, max_inverse_gain=gain)
    assert fit.certificate.inverse_gain <= gain * (1 + 1e-9)
    assert "gain-exceeded" not in {finding.code for finding in fit.warnings}
    turns = np.linspace(-0.6, 0.6, 9)[[0, 1, 2, 6, 7, 8]]
    assert steps_after_reversals(fit.model.inverse(), turns) <= gain * RESOLUTION * (1 + 1e-6)


def test_no_pair_of_samples_on_any_path_moves_the_output_by_more_than_the_gain(log):
    compensator = dehyst.identify(log, shear=5.0, max_inverse_gain=8.0).model.inverse()
    q = np.cumsum(np.random.default_rng(3).integers(-40, 41, 20_000)) * RESOLUTION
    u = compensator.simulate(q)
    assert np.all(np.abs(np.diff(u)) <= 8.0 * np.abs(np.diff(q)) * (1 + 1e-6) + 1e-12)


def test_with_a_small_k_and_the_papers_bound_it_does_step(log):
    fit = dehyst.identify(log, shear=0.2)
    assert steps_after_reversals(fit.model.inverse(), [0.5]) > 100 * RESOLUTION


@pytest.mark.parametrize("family", ["pi", "pi-cumulative", "modified-pi", "stop", "auto"])
def test_the_gain_of_every_family_is_kept_or_the_excess_is_named(family):
    recording = example()
    slope = np.ptp(recording.output) / np.ptp(recording.input)
    fit = dehyst.identify(recording, family, max_inverse_gain=4.0 / slope)
    exceeded = fit.certificate.inverse_gain > 4.0 / slope * (1 + 1e-9)
    assert exceeded == ("gain-exceeded" in {finding.code for finding in fit.warnings})
    assert not exceeded or family == "modified-pi"
    assert fit.settings["max_inverse_gain"] == 4.0 / slope


def example():
    from dehyst.io import example_recording

    return example_recording()


def test_a_log_with_its_backbone_becomes_a_model_that_can_be_simulated():
    recording = example()
    fit = dehyst.identify(recording, shear=0.05)
    assert fit.model.has_forward
    y = fit.model.simulate(recording.input)
    assert np.std(y - recording.output) < 0.1 * np.std(recording.output)
    np.testing.assert_allclose(fit.model.inverse().simulate(y), recording.input, atol=1e-9)


def test_the_miss_of_the_inverse_is_that_of_the_logs_own_input(log, fit):
    bent = fit.model.shear * log.output  # demands are held within the range of the sheared input
    low, high = np.min(log.input + bent), np.max(log.input + bent)
    miss = np.clip(fit.model.inverse().simulate(log.output) + bent, low, high) - bent - log.input
    held_out = miss[fit.test_masks[0]]
    percent = 100 * np.sqrt(np.mean(held_out**2)) / np.ptp(log.input)
    assert fit.certificate.inverse_miss_percent == pytest.approx(percent, rel=1e-9)
    assert fit.certificate.inverse_gain == fit.model.inverse_gain


def test_card_and_file_say_what_was_sheared(tmp_path, log, fit):
    path = fit.model.save(tmp_path / "m.json")
    again = dehyst.load(path)
    assert isinstance(again, ShearedPrandtlIshlinskii)
    assert again.shear == fit.model.shear
    assert again.card.input.name == "hysteresis"
    assert (again.card.input.low, again.card.input.high) == (log.input.min(), log.input.max())
    assert again.card.provenance["settings"]["shear"] == fit.model.shear
    assert (
        again.inverse().simulate(log.output).tobytes()
        == fit.model.inverse().simulate(log.output).tobytes()
    )


def test_a_refit_stays_sheared(fit):
    refit = fit.refit(n=40)
    assert isinstance(refit.model, ShearedPrandtlIshlinskii)
    assert refit.model.shear == fit.model.shear
    assert refit.model.card.input.name == "hysteresis"


def test_k_is_never_subtracted_twice(fit):
    compensator = fit.model.inverse()
    assert InverseCompensator(compensator, shear=0.0).step(0.1, 0.0) == 1e5 * compensator.stepper()(
        0.1
    )
    with pytest.raises(ParameterError, match="subtracted twice"):
        InverseCompensator(compensator, shear=1e5)
    with pytest.raises(ParameterError, match="subtracted twice"):
        JointController(JointControllerParameters(), compensator)
    whole = JointController(JointControllerParameters(), fit.model.hysteresis.inverse())
    with pytest.raises(ParameterError, match="subtracted twice"):
        whole.exchange(compensator)
    whole.exchange(compensator, shear=0.0)


def test_a_compensator_that_errs_is_not_called_good():
    log = friction_log()
    jumping = 0.1 * np.sign(np.sin(np.arange(len(log)) / 37.0))
    erratic = Recording(input=log.input + jumping, output=log.output)
    fit = dehyst.identify(erratic, shear=50.0)
    assert "inverse-errs" in {finding.code for finding in fit.warnings}
    assert "good for compensation" not in fit.verdict


def test_the_headline_of_a_sheared_fit_is_the_error_of_its_inverse(log, fit):
    miss = 100 * np.sqrt(
        np.mean((fit.model.inverse().simulate(log.output) - log.input)[fit.test_masks[0]] ** 2)
    )
    first = float(re.search(r"([\d.]+) % of its range rms on held-out loops", fit.verdict)[1])
    assert first == pytest.approx(miss / np.ptp(log.input), rel=0.04)
    assert first > 5 * fit.test.rmse_percent
    assert fit.verdict.index(f"{fit.test.rmse_percent:.2f} %") > fit.verdict.index(
        "on held-out loops"
    )
    assert "pi, the family that a shear takes" in fit.verdict
    assert "the family that a shear takes" not in dehyst.identify(log, "pi", shear=5.0).verdict
    assert fit.model.card.provenance["verdict"] == fit.verdict


def test_a_gain_that_no_eps_reaches_is_named():
    x = np.interp(np.linspace(0, 9, 1801), range(10), [0, 1, -1, 1, -1, 0.8, -0.8, 0.6, -0.6, 0])
    y = np.tanh(3.0 * PrandtlIshlinskii([0.0, 0.1], [1.0, 0.3]).simulate(x))
    fit = dehyst.identify(Recording(input=x, output=y), "modified-pi", max_inverse_gain=1.6)
    found = [finding for finding in fit.warnings if finding.code == "gain-exceeded"]
    assert len(found) == 1
    assert "--family pi" in found[0].message


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"shear": 5.0, "family": "modified-pi"}, "does not go with family"),
        ({"shear": "much"}, r"is no number; .* in rad|is no number; .*cross_validate"),
        ({"shear": 5.0, "max_inverse_gain": -1.0}, "must be positive"),
        ({"max_inverse_gain": 5.0, "eps": 0.01}, "Leave one of them out"),
        ({"max_inverse_gain": 1e-6}, "less than a straight line"),
    ],
)
def test_settings_that_make_no_sense_are_refused_with_a_cure(log, settings, words):
    with pytest.raises(ParameterError, match=words):
        dehyst.identify(log, **settings)


@pytest.fixture(scope="module")
def files(tmp_path_factory, log):
    from dehyst.io import write_csv

    folder = tmp_path_factory.mktemp("sheared")
    write_csv(
        folder / "log.csv",
        {"time_s": log.time, "hysteresis_bar": log.input, "angle_rad": log.output},
    )
    return folder


def run(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments], catch_exceptions=False)


@pytest.fixture(scope="module")
def identified(files):
    line = [
        "identify",
        files / "log.csv",
        "--input",
        "hysteresis_bar",
        "--output",
        "angle_rad",
        "--shear",
        "5",
    ]
    answer = run(*line, "--max-inverse-gain", "10", "--save", files / "m.json", "--json")
    return json.loads(answer.stdout)


def test_the_command_line_gives_the_model_of_python(files, identified, log):
    fit = dehyst.identify(log, shear=5.0, max_inverse_gain=10.0)
    assert identified["shear"] == fit.model.shear
    assert identified["inverse_gain"] <= 10.0 * (1 + 1e-9)


def test_compensate_subtracts_k_y(files, identified, log):
    answer = run("compensate", files / "m.json", files / "log.csv", "--output", "angle_rad")
    columns = np.loadtxt(answer.stdout.splitlines()[1:], delimiter=",")
    miss = columns[:, 2] - log.input
    assert np.sqrt(np.mean(miss**2)) < 0.1 * np.std(log.input)


def test_an_export_is_the_compensator_bit_for_bit(files, identified):
    answer = run(
        "export", files / "m.json", "--target", "c", "--out", files / "unit", "--json",
    )  # fmt: skip
    codes = [finding["code"] for finding in json.loads(answer.stdout)["warnings"]]
    assert "compensator-only" in codes
    stored = dehyst.load(files / "unit" / "model.json")
    y = nested_loops(20)
    compensator = dehyst.load(files / "m.json").inverse()
    assert stored.simulate(y).tobytes() == compensator.simulate(y).tobytes()


def test_an_export_cannot_hold_back_where_no_forward_model_exists(files, identified):
    with pytest.raises(ParameterError, match="--range holds an inverse back"):
        run(
            "export", files / "m.json", "--target", "c", "--out", files / "no", "--range", "-1", "1"
        )


@pytest.mark.slow
def test_the_report_of_a_sheared_fit_shows_the_gain_of_the_compensator(tmp_path, fit):
    page = dehyst.write_report(fit, tmp_path / "r.html").read_text(encoding="utf-8")
    assert "loop sheared by k = 5 bar/rad" in page


@pytest.mark.parametrize("unit", [1e5, 1.0, 1e-5])
def test_a_shear_in_the_unit_of_the_input_gives_the_same_compensator(log, unit):
    """The paper's eps = 0.001 is larger than the slope of a joint in pascal."""
    scaled = Recording(input=unit * log.input, output=log.output)
    fit = dehyst.identify(scaled, shear=5.0 * unit)
    miss = fit.model.inverse().simulate(log.output) - scaled.input
    assert np.std(miss) < 0.2 * np.std(scaled.input)
