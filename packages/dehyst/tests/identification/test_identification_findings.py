"""Every warning fires on data made for it and on none that is clean; auto chooses; bad input is refused by name."""

import inspect
import re
from functools import cache

import numpy as np
import pytest

import dehyst
from dehyst.errors import DehystError, ExcitationError, ParameterError, RecordingError
from dehyst.identification import _cautions as cautions
from dehyst.identification._auto import fit_plays as identify_plays
from identification_oracles import loops
from in_one import in_one

SIZES = (2.0, 1.6, 1.9, 1.2, 1.7, 2.0, 1.4, 1.8)
SAMPLES = 60
PI = dehyst.PrandtlIshlinskii([0.0, 0.2, 0.5, 0.9], [0.7, 0.4, 0.3, 0.3])
STOP = dehyst.StopOperatorModel([0.0, 0.4, 1.0], [0.0, 1.0, 0.8], slope=0.3)


def noise(size, scale, seed=0):
    return scale * np.random.default_rng(seed).standard_normal(size)


def clean(**changes):
    """A recording that deserves no warning, with parts replaced."""
    x = loops((*SIZES, *SIZES), SAMPLES)
    parts = {
        "input": x,
        "output": PI.simulate(x) + noise(x.size, 0.01),
        "time": 0.02 * np.arange(x.size),
    }
    return dehyst.Recording(**(parts | changes))


def rate_dependent():
    """A sensor that lags by 0.1 s, at four speeds."""
    time = 0.02 * np.arange(4000)
    frequency = np.repeat(np.tile([0.1, 0.4, 0.2, 0.8], 2), 500)
    x = 2.0 * np.sin(2 * np.pi * np.cumsum(frequency) * 0.02)
    y = PI.simulate(x)
    for k in range(1, y.size):
        y[k] = y[k - 1] + 0.2 * (y[k] - y[k - 1])
    return dehyst.Recording(input=x, output=y + noise(x.size, 0.01), time=time)


def drifting():
    rec = clean()
    return clean(output=rec.output + 0.3 * np.linspace(0.0, 1.0, len(rec)))


def weakened():
    rec = clean()
    half = np.arange(len(rec)) < len(rec) // 2
    return clean(output=np.where(half, rec.output, 0.3 * rec.output + 0.5 * np.ptp(rec.output)))


def dead():
    """Right after a reversal its output stands still."""
    x = clean().input
    return dehyst.Recording(
        input=x, output=dehyst.PrandtlIshlinskii([0.0, 0.8], [1e-9, 3.0]).simulate(x)
    )


def figure_of_eight():
    angle = np.linspace(0.0, 20 * np.pi, 2001)
    return dehyst.Recording(
        input=np.sin(angle), output=np.sin(angle) + 0.15 * np.sin(2 * angle + 1e-3)
    )


def growing():
    sizes = (1.0, 0.7, 0.9, 1.0, 0.8, 0.6, 2.0, 1.4, 1.9, 2.0, 1.0, 1.5)
    x = loops(sizes, SAMPLES)
    return dehyst.Recording(input=x, output=PI.simulate(x) + noise(x.size, 0.01))


def memoryless():
    x = loops((*SIZES, *SIZES), SAMPLES)
    return dehyst.Recording(input=x, output=x + 0.1 * x**3 + noise(x.size, 0.05))


def small_loops():
    rec = clean()
    x = np.concatenate([rec.input, loops((1.2, 1.0, 0.8, 1.1, 1.2), SAMPLES)])
    y = PI.simulate(x) + noise(x.size, 0.01)
    return dehyst.Recording(input=x, output=y, breaks=(len(rec),))


def backlash():
    x = loops((*SIZES, *SIZES), SAMPLES)
    lost = dehyst.PrandtlIshlinskii([0.0, 0.3], [0.0, 1.0])
    return dehyst.Recording(input=x, output=lost.simulate(x) + noise(x.size, 0.002))


def clockwise():
    x = loops((*SIZES, *SIZES), SAMPLES)
    return dehyst.Recording(input=x, output=STOP.simulate(x) + noise(x.size, 0.01))


def butterfly():
    x = loops((*SIZES, *SIZES), SAMPLES)
    return dehyst.Recording(input=x, output=PI.simulate(x) ** 2 + noise(x.size, 0.01))


def erratic(scale=1.0):
    x = loops((*SIZES, *SIZES), SAMPLES)
    return dehyst.Recording(input=x, output=x + noise(x.size, scale))


def interrupted():
    return clean(breaks=(600, 1200))


def in_units(gain):
    rec = clean()
    return dehyst.Recording(input=rec.input, output=gain * rec.output, time=rec.time)


def broken_off():
    """The second half comes after a gap, and hardly moves: its memory stays unknown, and it holds no loop."""
    rec = clean()
    half = len(rec) // 2
    return dehyst.Recording(
        input=np.concatenate([rec.input[:half], 0.04 * rec.input[half:]]),
        output=np.concatenate([rec.output[:half], 0.04 * rec.output[half:]]),
        time=rec.time,
        breaks=(half,),
    )


def equal_loops(count=14):
    x = loops((2.0, -2.0) * count, SAMPLES)
    y = PI.simulate(x) + noise(x.size, 0.01)
    return dehyst.Recording(input=x, output=y, time=0.02 * np.arange(x.size))


# code: (recording, arguments of identify, a word of the cure)
FIRING = {
    "clockwise": (clockwise, {}, "swapped"),
    "mixed-loop": (figure_of_eight, {}, "report"),
    "butterfly-loop": (butterfly, {}, "--family butterfly"),
    "rate-dependent": (rate_dependent, {}, "speed of use"),
    "drift": (drifting, {}, "--from"),
    "few-loops": (lambda: clean(), {"train_fraction": 0.08}, "--train-fraction"),
    "one-loop-size": (lambda: equal_loops(), {}, "dehyst design --range -2 2"),
    "unknown-memory": (interrupted, {}, "without gaps"),
    "unknown-level": (lambda: small_loops(), {}, "begin each piece with a full loop"),
    "undetermined-operators": (
        lambda: clean(),
        {"thresholds": [0.0, 0.5, 1.0, 2.5, 3.0]},
        "fewer thresholds",
    ),
    "extrapolation": (growing, {}, "--train-fraction"),
    "small-test": (lambda: clean(), {"train_fraction": 0.998}, "--train-fraction"),
    "static-as-good": (memoryless, {"family": "pi"}, "Use the curve (--family static)"),
    "no-hysteresis": (memoryless, {}, "insist with --family"),
    "high-inverse-gain": (backlash, {}, "--eps"),
    "inverse-useless": (dead, {"family": "pi", "eps": 1e-8}, "raise --eps"),
    "two-actuators": (weakened, {}, "--from, --to"),
    "poor-fit": (erratic, {}, "may be the reason: mixed-loop"),
    "never-turns": (lambda: clean(), {"train_fraction": 0.02, "n": 10}, "--train-fraction 1"),
    "inverse-misses": (lambda: erratic(2.0), {"family": "pi"}, "simulation only"),
    "recordings-differ": (
        lambda: [clean(), clean(output=clean().output + 1.0)],
        {},
        "align the zeros",
    ),
    "paper-bound": (lambda: in_units(7e-4), {"family": "pi"}, "--eps auto"),
    "no-held-out": (lambda: broken_off(), {}, "--train-fraction"),
}


@pytest.mark.slow
def test_clean_data_brings_no_warning():
    fit = dehyst.identify(clean())
    assert fit.warnings == ()
    assert "good for compensation" in fit.verdict


@pytest.mark.parametrize("code", FIRING)
def test_a_warning_fires_on_data_made_for_it_and_names_a_cure(code):
    make, settings, cure = FIRING[code]
    fit = dehyst.identify(make(), **({"n": 40} | settings))
    found = [finding for finding in fit.warnings if finding.code == code]
    assert len(found) == 1
    assert cure in found[0].message
    assert any(character.isdigit() for character in found[0].message) or code in {
        "mixed-loop",
        "no-held-out",
        "never-turns",
    }


def test_every_code_that_identification_can_give_is_tested():
    given = set(re.findall(r'Finding\(\s*"([a-z-]+)"', inspect.getsource(cautions)))
    assert (
        given
        == set(FIRING)
        | {
            "output-late",
            "output-early",
            "plays-only",
            "spectral-peak",
            "resonance",
            "resonance-not-shaped",
            "output-unrelated",
            "held-out-worse",
        }
    )  # tested in test_ringing.py, test_cures.py, test_lateness.py, test_choice_told.py, test_causes.py and others


@pytest.mark.slow
def test_a_test_of_a_few_samples_makes_no_model_good():
    fit = dehyst.identify(clean(), train_fraction=0.998)
    assert fit.test is not None and fit.test.rmse_percent < 3.0
    assert "usable with care (small-test)" in fit.verdict


@pytest.mark.slow
def test_the_verdict_follows_the_warnings():
    made = ((memoryless, "modified-pi"), (erratic, "auto"), (drifting, "auto"), (backlash, "auto"))
    verdicts = [dehyst.identify(make(), family, n=25).verdict for make, family in made]
    assert (
        "usable with care (static-as-good" in verdicts[0]
    )  # its inverse is as good as the curve's
    assert "do not compensate with it" in verdicts[1]
    assert "usable with care (drift" in verdicts[2]
    assert "high-inverse-gain" in verdicts[3]


@pytest.mark.slow
def test_findings_of_the_log_come_first_and_once():
    note = dehyst.Finding("gap", "no samples between 1 s and 2 s")
    rec = clean().with_findings(note, note)
    other = dehyst.Recording(
        rec.input, rec.output + noise(len(rec), 0.01), rec.time, findings=rec.findings
    )
    fit = dehyst.identify([rec, other], train_fraction=1)
    assert [finding.code for finding in fit.warnings].count("gap") == 1
    assert fit.warnings[0] == note


@pytest.mark.slow
def test_facts_are_those_of_the_data():
    facts = dehyst.identify(clean()).facts
    assert (facts.orientation, facts.trend, facts.loops) == ("counter-clockwise", 1, 8)
    assert 2.0 < facts.width_percent < 40.0
    assert abs(facts.drift_percent) < 0.5
    assert facts.rate_dependence_percent is not None and facts.rate_dependence_percent < 0.5
    assert dehyst.identify(clean(time=None)).facts.rate_dependence_percent is None
    assert dehyst.identify(clockwise()).facts.orientation == "clockwise"
    assert dehyst.identify(figure_of_eight()).facts.orientation == "mixed"
    drift = dehyst.identify(drifting(), "pi", train_fraction=1).facts.drift_percent
    rec = drifting()
    assert drift == pytest.approx(100 * 0.3 * 14 / 16 / np.ptp(rec.output), rel=0.2)


# Choice of family.


def test_plays_take_the_simplest_family_within_noise():
    fit = identify_plays(clean())
    assert fit.family == "pi"
    assert fit.test.rmse_percent < 1.1 * 100 * 0.01 / np.ptp(clean().output)
    best = min(candidate.error_percent for candidate in fit.candidates)
    chosen = [candidate for candidate in fit.candidates if candidate.chosen]
    assert len(chosen) == 1 and chosen[0].family == "pi"
    assert chosen[0].error_percent <= 1.02 * best * (1 + 1e-9)
    compared = {candidate.family for candidate in fit.candidates}
    assert compared == {"static", "pi", "pi-cumulative", "modified-pi"}


def test_auto_takes_the_output_map_where_the_loop_saturates():
    rec = clean()
    fit = identify_plays(clean(output=np.tanh(rec.output)))
    assert fit.family == "modified-pi"
    assert fit.test.rmse < 0.3 * dehyst.identify(clean(output=np.tanh(rec.output)), "pi").test.rmse


def test_auto_takes_stops_for_clockwise_loops():
    fit = dehyst.identify(clockwise())
    assert "stop" in fit.model.kinds
    assert fit.test.rmse < 0.013
    assert identify_plays(clockwise()).family in {"stop", "pi-cumulative"}
    assert dehyst.identify(clockwise(), "pi").test.rmse > 10 * fit.test.rmse


def test_a_named_family_is_obeyed():
    for family in ("pi", "pi-cumulative", "modified-pi", "stop"):
        fit = dehyst.identify(clockwise(), family)
        assert (
            fit.family == fit.model.family.replace("pi-cumulative", "pi")
            or family == "pi-cumulative"
        )
        assert fit.settings["family"] == family


def test_the_papers_settings_are_one_call():
    paper = dehyst.identify(clean(), "pi")
    assert paper.certificate.operators == 100
    assert paper.settings["eps"] == 0.001
    assert paper.certificate.initial_state == "zero"
    assert paper.model.weights[0] >= 0.001 * np.ptp(clean().output) / np.ptp(clean().input) * 0.9


def test_the_choice_is_the_same_every_time():
    first, second = dehyst.identify(clean(), n=25), dehyst.identify(clean(), n=25)
    assert np.array_equal(first.predictions[0], second.predictions[0])
    assert first.candidates == second.candidates


@pytest.mark.slow
def test_held_out_samples_never_touch_the_fit():
    rec = clean()
    half = len(rec) // 2
    other = rec.output.copy()
    other[half:] = np.clip(
        np.random.default_rng(5).permutation(other[half:]), rec.output.min(), rec.output.max()
    )
    for family in ("pi", "modified-pi", "auto"):
        first, second = (
            dehyst.identify(rec, family, n=25),
            dehyst.identify(clean(output=other), family, n=25),
        )
        assert first.family == second.family
        assert np.array_equal(first.predictions[0], second.predictions[0])
        assert second.test.rmse > 10 * first.test.rmse


# Scales, directions.


@cache
def of_its_own_units(make):
    return dehyst.identify(make(), n=25)


@pytest.mark.spread(9)
@pytest.mark.parametrize("make", [clean, clockwise, lambda: clean(output=np.tanh(clean().output))])
@pytest.mark.parametrize(
    ("gain_x", "gain_y"),
    [(1e-9, 1.0), (1.0, 1e-9), (1e9, 1e-9), (1e-9, 1e9), (3e-3, 7e4), (-1.0, -1.0)],
)
def test_units_do_not_matter(make, gain_x, gain_y):
    rec = make()
    scaled = dehyst.Recording(input=gain_x * rec.input, output=gain_y * rec.output, time=rec.time)
    first, second = of_its_own_units(make), dehyst.identify(scaled, n=25)
    assert first.family == second.family
    assert second.test.rmse_percent == pytest.approx(first.test.rmse_percent, abs=1e-9)
    assert [w.code for w in first.warnings] == [w.code for w in second.warnings]
    assert second.certificate.round_trip_error < 1e-12


@pytest.mark.parametrize(("shift_x", "shift_y"), [(100.0, 0.0), (0.0, -3000.0), (-50.0, 1e4)])
def test_offsets_do_not_matter(shift_x, shift_y):
    rec = clean()
    moved = dehyst.Recording(input=rec.input + shift_x, output=rec.output + shift_y, time=rec.time)
    first, second = dehyst.identify(rec, n=25), dehyst.identify(moved, n=25)
    assert first.family == second.family
    assert second.test.rmse_percent == pytest.approx(first.test.rmse_percent, abs=1e-9)


@pytest.mark.parametrize("family", ["pi", "pi-cumulative", "modified-pi", "stop", "auto"])
@pytest.mark.parametrize("make", [clean, clockwise])
def test_a_falling_curve_gives_the_mirrored_model(make, family):
    rec = make()
    mirrored = dehyst.Recording(input=rec.input, output=-rec.output, time=rec.time)
    first, second = dehyst.identify(rec, family, n=25), dehyst.identify(mirrored, family, n=25)
    assert first.family == second.family
    assert second.facts.trend == -first.facts.trend == -1
    assert second.facts.orientation == first.facts.orientation
    assert second.test.rmse_percent == pytest.approx(first.test.rmse_percent, abs=1e-9)
    assert np.abs(second.predictions[0] + first.predictions[0]).max() < 1e-9
    assert second.certificate.round_trip_error < 1e-12


def test_scores_are_what_their_names_say():
    rec = clean()
    fit = dehyst.identify(rec, "pi")
    half = len(rec) // 2
    error = fit.predictions[0] - rec.output
    for score, part in ((fit.train, slice(None, half)), (fit.test, slice(half, None))):
        assert score.rmse == pytest.approx(np.sqrt(np.mean(error[part] ** 2)), rel=1e-12)
        assert score.rmse_percent == pytest.approx(100 * score.rmse / np.ptp(rec.output), rel=1e-12)
        assert score.nrmse == pytest.approx(score.rmse / np.std(rec.output[part]), rel=1e-12)
        assert score.max == np.abs(error[part]).max()
    curve = fit.static.simulate(rec.input) - rec.output
    assert fit.static_test.rmse == pytest.approx(np.sqrt(np.mean(curve[half:] ** 2)), rel=1e-12)
    assert fit.static_test.rmse > 3 * fit.test.rmse


def test_the_round_trip_of_the_certificate_is_that_of_the_inverse():
    rec = clean()
    for family in ("pi", "modified-pi", "stop"):
        fit = dehyst.identify(rec, family)
        y = fit.model.simulate(rec.input)
        back = fit.model.inverse().simulate(y)
        assert np.abs(back - rec.input).max() <= fit.certificate.round_trip_error * np.ptp(
            rec.input
        ) * (1 + 1e-9)
        assert fit.certificate.round_trip_error < 1e-12
        # The gain bounds every slope of the inverse that shows up.
        moving = np.abs(np.diff(y)) > 1e-6
        assert (
            np.abs(np.diff(back)[moving] / np.diff(y)[moving])
        ).max() <= fit.certificate.inverse_gain * (1 + 1e-6)


def test_the_inverse_miss_is_the_input_asked_for_less_the_input_applied():
    rec = clean()
    half = len(rec) // 2
    for family in ("pi", "modified-pi", "stop"):
        for fraction, part in ((0.5, slice(half, None)), (1.0, slice(None))):
            fit = dehyst.identify(rec, family, n=25, train_fraction=fraction)
            asked = fit.model.inverse().simulate(rec.output)
            assert np.array_equal(asked, fit.inverse_predictions[0])
            held = np.clip(asked, rec.input.min(), rec.input.max())
            miss = np.sqrt(np.mean((held - rec.input)[part] ** 2))
            expected = 100 * miss / np.ptp(rec.input)
            assert fit.certificate.inverse_miss_percent == pytest.approx(expected, rel=1e-9)
            if family == "pi":
                assert expected < 1.0


def test_eps_bounds_the_gain_of_the_inverse():
    rec = backlash()
    ratio = np.ptp(rec.input[: len(rec) // 2]) / np.ptp(rec.output[: len(rec) // 2])
    for eps in (0.001, 0.1, 0.5):
        literal = dehyst.identify(rec, "pi", eps=eps)
        assert literal.model.weights[0] >= eps * (1 - 1e-12)
        assert literal.certificate.inverse_gain <= 1 / eps * (1 + 1e-9)
        relative = dehyst.identify(rec, "stop", eps=eps)
        assert relative.certificate.inverse_gain <= ratio / eps * (1 + 1e-9)


def test_the_papers_bound_holds_in_any_units_and_one_beyond_the_slope_is_refused_with_the_value_to_type():
    rec = backlash()
    small = dehyst.Recording(input=rec.input, output=0.1 * rec.output)
    assert dehyst.identify(small, "pi").model.weights[0] >= 0.001 * (1 - 1e-12)
    pascal = dehyst.Recording(
        input=1e5 * rec.input, output=rec.output, input_unit="Pa", output_unit="rad"
    )
    with pytest.raises(ParameterError, match="--eps 9e-09"):
        dehyst.identify(pascal, "pi")


def test_an_eps_that_costs_little_is_named_and_does_cost_little():
    rec = backlash()
    fit = dehyst.identify(rec, "modified-pi", eps=0.001)
    named = fit.certificate.affordable_eps
    assert named is not None
    firmer = dehyst.identify(rec, "modified-pi", eps=named)
    assert firmer.certificate.inverse_gain < 0.2 * fit.certificate.inverse_gain
    assert firmer.train.rmse < 1.5 * fit.train.rmse


def test_data_of_the_operator_itself_give_its_weights_back_whatever_its_start():
    for x in (loops(SIZES, SAMPLES), loops(SIZES, SAMPLES)[15:] + 0.3):
        rec = dehyst.Recording(input=x, output=PI.simulate(x))
        fit = dehyst.identify(rec, "pi", thresholds=PI.thresholds)
        np.testing.assert_allclose(fit.model.weights, PI.weights, rtol=1e-9)


# Bad input.

BAD_SETTINGS = [
    ({"family": "Pi"}, "modified-pi"),
    ({"family": None}, "modified-pi"),
    ({"n": 0}, "100"),
    ({"n": -5}, "100"),
    ({"n": 1.5}, "whole number"),
    ({"n": "many"}, "whole number"),
    ({"n": True}, "whole number"),
    ({"n": 10**9}, "at most 10000"),
    ({"n": float("inf")}, "whole number"),
    ({"eps": 0.0}, "and 1"),
    ({"eps": -1.0}, "and 1"),
    ({"eps": 2.0}, "and 1"),
    ({"eps": float("nan")}, "eps"),
    ({"eps": "small"}, "eps"),
    ({"train_fraction": 0.0}, "(0, 1]"),
    ({"train_fraction": 1.5}, "(0, 1]"),
    ({"train_fraction": -0.5}, "(0, 1]"),
    ({"train_fraction": float("nan")}, "train_fraction"),
    ({"train_fraction": "half"}, "train_fraction"),
    ({"thresholds": []}, "thresholds"),
    ({"thresholds": "none"}, "thresholds"),
    ({"thresholds": [0.5, 1.0]}, "must be 0"),
    ({"thresholds": [0.0, 1.0, 1.0]}, "increase"),
    ({"thresholds": [0.0, 1.0, 0.5]}, "increase"),
    ({"thresholds": [0.0, float("nan")]}, "finite"),
    ({"thresholds": [[0.0, 1.0]]}, "shape"),
    ({"thresholds": [-1.0, 0.0]}, "must be 0"),
    ({"initial_state": "asleep"}, "rising"),
    ({"initial_state": 0}, "rising"),
]


@in_one("settings, cure", BAD_SETTINGS)
def test_a_setting_that_makes_no_sense_is_refused_by_name(settings, cure):
    with pytest.raises(ParameterError) as caught:
        dehyst.identify(clean(), **settings)
    assert cure in str(caught.value)
    assert next(iter(settings)) in str(caught.value)


@in_one("wrong", [None, 5, "log.csv", [], [1.0, 2.0], np.zeros((10, 2)), {"input": [1.0]}])
def test_what_is_no_recording_is_refused_with_the_way_to_make_one(wrong):
    with pytest.raises(ParameterError, match=r"read_log|dehyst\.Recording\("):
        dehyst.identify(wrong)


def test_mixed_units_are_refused():
    with pytest.raises(ParameterError, match="different units"):
        dehyst.identify([clean(input_unit="bar"), clean(input_unit="psi")])


@in_one("role", ["input", "output"])
def test_a_constant_signal_is_refused(role):
    flat = np.full(len(clean()), 3.25)
    with pytest.raises(ExcitationError, match=r"3\.25.*--train-fraction 1"):
        dehyst.identify(clean(**{role: flat}))
    late = clean().input.copy()
    late[: len(late) // 2] = 0.0
    with pytest.raises(ExcitationError, match="first 50 %"):
        dehyst.identify(clean(**{role: late}))


@in_one("value", [np.nan, np.inf, -np.inf])
def test_a_recording_with_samples_that_are_not_finite_is_refused(value):
    for role in ("input", "output", "time"):
        spoiled = np.array(getattr(clean(), role))
        spoiled[7] = value
        with pytest.raises(RecordingError, match="index 7"):
            clean(**{role: spoiled})


@pytest.mark.spread(20)
@pytest.mark.parametrize("samples", range(4, 60, 5))
@pytest.mark.parametrize("family", ["auto", "pi", "pi-cumulative", "modified-pi", "stop"])
def test_short_recordings_are_fitted_with_a_warning_or_refused_by_name(samples, family):
    x = loops((2.0, 1.0), 15)[:samples]
    rec = dehyst.Recording(input=x, output=PI.simulate(x))
    try:
        fit = dehyst.identify(rec, family)
    except DehystError as fault:
        assert len(str(fault)) > 40
    else:
        assert {"few-loops", "never-turns"} & {finding.code for finding in fit.warnings}
        assert np.isfinite(fit.predictions[0]).all()


def test_recordings_shorter_than_four_samples_are_refused():
    with pytest.raises(RecordingError, match="at least 4"):
        dehyst.Recording(input=[0.0, 1.0, 0.0], output=[0.0, 1.0, 0.0])


@pytest.mark.spread(6)
@pytest.mark.parametrize("seed", range(12))
def test_no_data_makes_identification_fail_without_a_name(seed):
    rng = np.random.default_rng(seed)
    size = int(rng.integers(4, 300))
    kinds = [
        lambda: rng.standard_normal(size),
        lambda: np.cumsum(rng.standard_normal(size)),
        lambda: np.round(rng.uniform(0, 2, size)),
        lambda: np.linspace(0, 1, size),
        lambda: np.repeat(rng.standard_normal(size), 3)[:size],
        lambda: 10.0 ** rng.uniform(-200, 140, size),
        lambda: np.where(np.arange(size) == size // 3, 1.0, 0.0),
    ]
    for _ in range(6):
        x, y = kinds[rng.integers(len(kinds))](), kinds[rng.integers(len(kinds))]()
        breaks = (
            tuple(sorted({int(k) for k in rng.integers(1, size, 2)})) if rng.random() < 0.3 else ()
        )
        family = ("auto", "pi", "pi-cumulative", "modified-pi", "stop")[rng.integers(5)]
        fraction = float(rng.choice([0.5, 1.0, 0.1]))
        try:
            fit = dehyst.identify(
                dehyst.Recording(input=x, output=y, breaks=breaks),
                family,
                train_fraction=fraction,
                n=20,
            )
        except DehystError as fault:
            assert str(fault)
            continue
        assert np.isfinite(fit.train.rmse)
        assert np.isfinite(fit.predictions[0]).all()
        assert fit.certificate.kkt_residual < 1e-9
