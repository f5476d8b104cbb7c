"""The smallest slope after a reversal: chosen where nobody says it, the paper's where the paper's family is named."""

import re

import numpy as np
import pytest

import dehyst
from dehyst.errors import ParameterError
from dehyst.identification._auto import fit_plays as identify_plays

SIZES = (1.9, -1.7, 1.4, -2.0, 1.0, -0.4, 1.5, -1.0, 2.0, -1.2, 0.3, -0.7, 0.9, -1.6)


def loops(repeats=4, samples=40):
    corners = [0.0, *SIZES * repeats, 0.0]
    return np.interp(
        np.arange((len(corners) - 1) * samples + 1) / samples, range(len(corners)), corners
    )


def recording(weights, noise=0.005, gain=1.0, thresholds=(0.0, 0.3, 0.8)):
    x = loops()
    y = dehyst.PrandtlIshlinskii(thresholds, weights).simulate(x)
    y += noise * np.random.default_rng(0).standard_normal(x.size)
    return dehyst.Recording(input=x, output=gain * y, time=0.02 * np.arange(x.size))


STIFF = (0.5, 0.6, 0.4)  # a clear slope after every reversal
SLACK = (
    0.02,
    0.9,
    0.4,
)  # hardly any: the inverse amplifies by more than 20, and a firmer eps costs little
BACKLASH = (0.0, 1.0, 0.4)


def codes(fit):
    return [finding.code for finding in fit.warnings]


def gain(fit):
    """Gain of the inverse in ratios of the ranges that were fitted."""
    rec = fit.recordings[0]
    half = len(rec) // 2
    return fit.certificate.inverse_gain * np.ptp(rec.output[:half]) / np.ptp(rec.input[:half])


@pytest.mark.parametrize("family", ["auto", "modified-pi"])
def test_an_eps_that_costs_little_is_taken_by_itself(family):
    rec = recording(SLACK, noise=0.05)
    loose = identify_plays(rec, family, eps=0.001)
    fit = identify_plays(rec, family)
    assert gain(loose) > 20.0 and "high-inverse-gain" in codes(loose)
    assert gain(fit) <= 20.0 and "high-inverse-gain" not in codes(fit)
    assert fit.train.rmse <= 1.055 * loose.train.rmse
    assert fit.test.rmse <= 1.055 * loose.test.rmse
    assert fit.settings["eps"] > 0.001 and fit.settings["eps_by"] == "error of the fit"
    assert f"--eps {fit.settings['eps']:.3g}," in next(
        w.message for w in loose.warnings if "--eps" in w.message
    )


@pytest.mark.parametrize("family", ["auto", "modified-pi", "stop"])
def test_where_the_gain_is_not_high_nothing_is_changed(family):
    rec = recording(STIFF)
    chosen, given = identify_plays(rec, family), identify_plays(rec, family, eps=0.001)
    assert np.array_equal(chosen.predictions[0], given.predictions[0])
    assert chosen.settings["eps"] == 0.001


def test_where_no_eps_is_cheap_the_warning_names_what_one_costs_and_it_costs_that():
    rec = recording(BACKLASH, noise=0.002)
    fit = identify_plays(rec)
    message = next(
        finding.message for finding in fit.warnings if finding.code == "high-inverse-gain"
    )
    eps, cost = (
        float(found)
        for found in re.search(r"--eps (\S+) would .* fit by (\d+) %", message).groups()
    )
    firm = identify_plays(rec, fit.family, eps=eps)
    assert gain(firm) <= 20.0 and "high-inverse-gain" not in codes(firm)
    loose = identify_plays(rec, fit.family, eps=0.001)
    assert 100.0 * (firm.train.rmse / loose.train.rmse - 1.0) == pytest.approx(
        cost, rel=0.1, abs=1.0
    )
    assert cost > 5.0


def test_the_papers_family_keeps_the_papers_bound_to_the_bit():
    for rec in (recording(STIFF), recording(BACKLASH)):
        asked = identify_plays(rec, "pi", eps=0.001)
        for fit in (identify_plays(rec, "pi"), dehyst.identify(rec, "pi")):
            assert np.array_equal(fit.model.weights, asked.model.weights)
            assert fit.settings == asked.settings


def test_auto_chooses_the_papers_eps_too_where_all_families_are_asked():
    rec = recording(STIFF, gain=1e-3)
    fit, plays = dehyst.identify(rec, "pi", eps="auto"), identify_plays(rec, "pi", eps="auto")
    assert fit.settings == plays.settings and np.array_equal(fit.model.weights, plays.model.weights)
    assert not np.array_equal(fit.model.weights, dehyst.identify(rec, "pi").model.weights)


@pytest.mark.spread(5)
@pytest.mark.parametrize("scale", [1e-6, 4e-4, 1e-3, 1.0, 1e6])
@pytest.mark.parametrize("weights", [STIFF, SLACK])
def test_a_relative_eps_makes_the_papers_family_independent_of_units(weights, scale):
    one = identify_plays(recording(weights, noise=0.05), "pi", eps="auto")
    other = identify_plays(recording(weights, noise=0.05, gain=scale), "pi", eps="auto")
    assert other.test.rmse_percent == pytest.approx(one.test.rmse_percent, rel=1e-6)
    assert other.settings["eps"] == pytest.approx(scale * one.settings["eps"], rel=1e-9)
    assert codes(other) == codes(one) == []


@pytest.mark.parametrize("scale", [1e-3, 9e-4, 1.1e-3])
def test_where_the_papers_bound_spoils_the_fit_the_unit_is_named_and_no_actuator_blamed(scale):
    rec = recording(STIFF, gain=scale)
    fit = dehyst.identify(rec, "pi")
    assert fit.test.rmse_percent > 1.5 * identify_plays(rec, "pi", eps="auto").test.rmse_percent
    assert codes(fit) == ["paper-bound"]
    assert "good" not in fit.verdict.rpartition(":")[2] and "paper-bound" in fit.verdict
    named = float(re.search(r"with --eps (\d\S+)\.$", fit.warnings[0].message).group(1))
    assert codes(identify_plays(rec, "pi", eps=named)) == []


def test_where_the_papers_bound_is_nothing_in_these_units_the_gain_is_said_with_the_cause():
    fit = dehyst.identify(recording(BACKLASH, noise=0.05, gain=1e5), "pi")
    message = next(
        finding.message for finding in fit.warnings if finding.code == "high-inverse-gain"
    )
    assert "absolute" in message and "the mean slope" in message and "--eps" in message
    assert "good for compensation" not in fit.verdict


@pytest.mark.slow
def test_a_refit_keeps_the_bound_that_was_chosen():
    for rec in (
        recording(SLACK, noise=0.05, thresholds=(0.0, 0.3, 0.8)),
        recording(STIFF, gain=1e-4),
    ):
        fit = identify_plays(rec)
        again = fit.refit()
        assert again.train.rmse == pytest.approx(fit.train.rmse, rel=1e-9)
        assert again.inverse_gain == pytest.approx(fit.certificate.inverse_gain, rel=1e-9)


def test_what_the_caller_left_out_on_purpose_is_no_warning():
    fit = identify_plays(recording(STIFF), train_fraction=1)
    assert codes(fit) == [] and "(nothing held out)" in fit.verdict


@pytest.mark.parametrize(
    ("settings", "cure"),
    [
        ({"eps": "small"}, "'auto'"),
        ({"eps": "auto", "max_inverse_gain": 5.0}, "Leave one of them out"),
        ({"eps": "auto", "shear": 1.0}, "--max-inverse-gain"),
    ],
)
def test_an_eps_that_makes_no_sense_is_refused(settings, cure):
    with pytest.raises(ParameterError, match=cure):
        identify_plays(recording(STIFF), **settings)
