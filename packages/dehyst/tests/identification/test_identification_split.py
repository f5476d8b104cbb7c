"""What is held out: whole recordings where there are several, a share of each where one is asked for."""

import itertools

import numpy as np
import pytest

import dehyst
from dehyst.errors import ParameterError
from dehyst.identification import compare
from dehyst.identification._split import split_recordings

MODEL = dehyst.PrandtlIshlinskii([0.0, 0.1, 0.3, 0.6], [0.4, 0.3, 0.2, 0.3])


def recording(size: float, seed: int, samples: int = 600, level: float = 0.0) -> dehyst.Recording:
    """Three loops of one size and a smaller one, from zero to zero."""
    turns = np.array([0.0, 1.0, -1.0, 1.0, -1.0, 1.0, -0.5, 0.5, 0.0]) * size
    x = np.interp(np.linspace(0, turns.size - 1, samples), np.arange(turns.size), turns)
    noise = np.random.default_rng(seed).normal(0.0, 0.003, samples)
    return dehyst.Recording(input=x, output=MODEL.simulate(x) + noise + level, name=f"run {seed}")


def runs() -> list[dehyst.Recording]:
    return [recording(size, k) for k, size in enumerate((1.0, 0.7, 0.9, 0.8, 0.6))]


def test_of_several_recordings_whole_ones_are_held_out_and_the_verdict_says_so():
    fit = dehyst.identify(runs(), "pi", n=20)
    assert "on 2 recordings held out" in fit.verdict
    assert fit.settings["held_out"] == [1, 2] and fit.settings["train_fraction"] == pytest.approx(
        0.6
    )
    assert fit.model.card.provenance["settings"]["held_out"] == [1, 2]
    for k in range(5):
        held = k in (1, 2)
        assert fit.test_masks[k].all() == held and fit.train_masks[k].all() == (not held)
    assert fit.test.rmse_percent < 0.5


def test_one_or_two_recordings_and_a_share_that_is_given_are_split_each():
    one, two, five = runs()[:1], runs()[:2], runs()
    assert split_recordings(one, None) == split_recordings(one, 0.5)
    assert split_recordings(two, None) == split_recordings(two, 0.5)
    assert split_recordings(five, 0.5).ends == (300,) * 5
    assert split_recordings(five, 1).ends == (600,) * 5
    assert "on held-out loops" in dehyst.identify(five, "pi", n=20, train_fraction=0.5).verdict


def test_the_order_of_recordings_does_not_matter():
    listed = runs()
    found = set()
    for order in itertools.permutations(range(5)):
        found.add(
            frozenset(order[k] for k in split_recordings([listed[k] for k in order], None).held_out)
        )
    assert found == {frozenset({1, 2})}


def test_units_zeros_and_signs_do_not_matter():
    for factor, zero in ((1e-6, 3.0), (-1e5, 0.0), (7.0, -1000.0)):
        turned = [
            dehyst.Recording(input=factor * r.input + zero, output=-3.0 * r.output) for r in runs()
        ]
        assert split_recordings(turned, None).held_out == (1, 2)


def test_a_recording_that_leaves_the_range_of_the_others_is_fitted():
    beyond = [recording(1.0, 0), recording(0.9, 1), recording(0.9, 2)]
    low = dehyst.Recording(input=beyond[1].input - 1.0, output=beyond[1].output)
    split = split_recordings([*beyond, low], None)
    assert 0 not in split.held_out and 3 not in split.held_out and split.held_out
    data = dehyst.identify([*beyond, low], "pi", n=20)
    assert "extrapolation" not in {finding.code for finding in data.warnings}


def test_recordings_that_would_be_too_little_or_too_much_to_test_on_are_split_each():
    short = [recording(1.0, 0, 6000), recording(0.5, 1, 300), recording(0.5, 2, 300)]
    assert split_recordings(short, None) == split_recordings(short, 0.5)
    only = [recording(1.0, 0, 300), recording(0.5, 1, 6000), recording(0.4, 2, 300)]
    assert split_recordings(only, None) == split_recordings(only, 0.5)


def test_recordings_without_weight_are_no_test():
    listed = runs()
    weights = [np.full(600, float(k not in (1, 2))) for k in range(5)]
    fit = dehyst.identify(listed, "pi", n=20, weights=weights)
    assert fit.test is not None and not set(fit.settings.get("held_out", [])) & {1, 2}


@pytest.mark.slow
def test_all_that_identifies_holds_out_the_same():
    listed = runs()
    expected = [1, 2]
    assert dehyst.identify(listed, "direct-inverse", creep=0).settings["held_out"] == expected
    assert dehyst.identify(listed, "pi", n=20, shear=0.05).settings["held_out"] == expected
    assert (
        dehyst.identify(listed, "pi", n=20, max_inverse_gain=20.0).settings["held_out"] == expected
    )
    found = compare(listed, ["pi", "dahl", "direct-inverse"])
    assert [mask.any() for mask in found.masks] == [k in expected for k in range(5)]


def test_recordings_apart_are_told_though_one_of_them_is_held_out():
    listed = runs()
    listed[1] = recording(0.7, 1, level=0.3)
    fit = dehyst.identify(listed, "pi", n=20)
    assert 1 in fit.settings["held_out"] and "recordings-differ" in {
        finding.code for finding in fit.warnings
    }


@pytest.mark.parametrize("wrong", [0.0, 1.5, float("nan"), "half"])
def test_a_wrong_share_is_refused(wrong):
    with pytest.raises(ParameterError, match="train_fraction"):
        split_recordings(runs(), wrong)


def test_an_inverse_that_makes_full_strokes_of_noise_is_not_to_be_used():
    """A loop as flat after its reversals as only an eps below the usual one leaves it."""
    x = recording(1.0, 0).input
    flat = dehyst.PrandtlIshlinskii([0.0, 0.1], [1.0 / 3000.0, 1.0]).simulate(x)
    fit = dehyst.identify(
        dehyst.Recording(input=x, output=flat), "pi", thresholds=[0.0, 0.1], eps=1e-9
    )
    gain = fit.certificate.inverse_gain * np.ptp(flat) / np.ptp(x)
    assert 2e3 < gain < 1e4
    assert "inverse-useless" in {finding.code for finding in fit.warnings}
    assert "do not compensate" in fit.verdict
