"""Claims about logs that tell least: loops behind a rest, an output that does not follow, tested parts that differ."""

import re

import numpy as np
import pytest
from scipy.signal import lfilter

import dehyst
from dehyst.identification._auto import fit_plays as identify_plays

PLAYS = dehyst.PrandtlIshlinskii([0.0, 0.1, 0.25, 0.5], [0.5, 0.2, 0.2, 0.2])


def codes(fit):
    return {finding.code for finding in fit.warnings}


def recording(x, seed=0):
    noise = 1e-3 * np.random.default_rng(seed).normal(size=x.size)
    return dehyst.Recording(x, PLAYS.simulate(x) + noise, 0.01 * np.arange(x.size))


@pytest.mark.parametrize("rest", [0, 100, 200, 326, 400])
@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_loops_of_one_size_are_said_whatever_rest_is_before_them(rest, noise):
    still = noise * np.random.default_rng(1).normal(size=rest)
    x = np.concatenate([still, np.sin(2 * np.pi * np.arange(670) / 100)])
    found = codes(identify_plays(recording(x), "pi", n=20))
    assert found & {"one-loop-size", "few-loops", "never-turns"}


def test_few_loops_of_several_sizes_are_not_of_one_size():
    x = np.interp(
        np.arange(900), np.linspace(0, 899, 10), [0, 1, -1, 0.5, -0.4, 0.8, -1, 1, -0.3, 0]
    )
    assert "one-loop-size" not in codes(identify_plays(recording(x), "pi", n=20))


def unrelated(seed):
    """A valve that wanders, and a flow that steps once by itself, or wanders too."""
    rng = np.random.default_rng(seed)
    x = lfilter([0.2], [1.0, -0.98], rng.normal(size=800)) * np.repeat([1.0, 1.5], 400)
    steps = np.repeat([0.0, 1.0], [200, 600]) + 0.2 * rng.normal(size=800)
    return dehyst.Recording(
        x, steps if seed % 3 else np.cumsum(rng.normal(size=800)), name="flow.csv"
    )


@pytest.mark.parametrize("seeds", [range(2), pytest.param(range(2, 30), marks=pytest.mark.slow)])
@pytest.mark.exhaustive
def test_an_unrelated_output_is_answered_by_a_sentence(seeds):
    for seed in seeds:
        fit = dehyst.identify(unrelated(seed))
        assert "good for compensation" not in fit.verdict
        judged = fit.test.nrmse > 1.0 and fit.static_test.nrmse > 1.0
        assert ("output-unrelated" in codes(fit)) == judged
        assert fit.verdict.startswith("the output does not follow this input") == judged
        assert not (judged and "drift" in codes(fit))
        assert not re.search(
            r"\d{3,}\.\d+ %", fit.verdict
        )  # how many times the range, in the place of 2511 %


def test_a_gain_that_differs_in_the_tested_half_is_said():
    x = (
        np.sin(np.arange(4000) / 60)
        * np.linspace(1.0, 0.9, 4000)
        * (0.75 + 0.25 * np.cos(np.arange(4000) / 400))
    )
    record = recording(x)
    later = np.where(np.arange(4000) < 2000, 1.0, 1.1)
    changed = dehyst.Recording(record.input, record.output * later, record.time)
    assert "held-out-worse" in codes(identify_plays(changed, "pi"))
    assert "held-out-worse" not in codes(identify_plays(record, "pi"))


def test_a_shifted_zero_is_no_unrelated_output():
    record = recording(np.sin(np.arange(4000) / 60))
    shifted = np.where(np.arange(4000) < 2000, 0.0, 5.0)
    fit = identify_plays(dehyst.Recording(record.input, record.output + shifted), "pi")
    assert "output-unrelated" not in codes(fit)
