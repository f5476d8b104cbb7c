"""What only the rounding of a processor tells apart is chosen by preference: the same answer on every machine."""

import numpy as np
import pytest

from dehyst import Recording, compare, identify
from dehyst.arrays import rank
from dehyst.families._friction import best_start
from dehyst.identification._selection import Choice, best_choice
from dehyst.models import SignalCard

ROUNDING = (1 - 3e-13, 1.0, 1 + 3e-13)


def log(noise=0.0):
    """A curve without hysteresis: every family and every start explains it equally well."""
    x = np.sin(np.linspace(0.0, 40.0, 1500)) * np.linspace(1.0, 0.5, 1500)
    y = np.tanh(1.5 * x) + noise * np.random.default_rng(3).normal(size=x.size)
    return x, y


def test_scores_that_differ_by_rounding_have_one_rank_and_others_do_not():
    assert rank(0.3 * (1 + 1e-12)) == rank(0.3)
    assert rank(2e-15) == rank(7e-17)
    assert rank(0.30001) > rank(0.3)
    assert rank(float("inf")) == float("inf")


@pytest.mark.parametrize("first", ROUNDING)
@pytest.mark.parametrize("second", ROUNDING)
def test_the_first_family_and_start_in_the_order_of_preference_wins_a_tie(first, second):
    errors = np.array([0.2, 0.3, 0.1, 0.2, 0.25])
    choices = [
        Choice("pi", "zero", None),
        Choice("pi", "rest", None),
        Choice("modified-pi", "zero", None),
    ]
    winner, candidates = best_choice(
        [(choices[0], errors), (choices[1], first * errors), (choices[2], second * errors)]
    )
    assert winner == choices[0]
    assert [(c.family, c.initial_state) for c in candidates] == [
        (c.family, c.initial_state) for c in choices
    ]
    assert best_start({"zero": 0.2, "rest": 0.1 * first, "rising": 0.1 * second}) == "rest"


@pytest.mark.slow
@pytest.mark.parametrize("tiny", [0.0, 1e-15, -1e-15, 3e-14])
def test_noise_of_the_size_of_rounding_changes_no_choice_and_no_order(tiny):
    x, y = log(0.002)
    disturbed = Recording(
        input=x, output=y * (1.0 + tiny * np.random.default_rng(5).normal(size=x.size))
    )
    plain = Recording(input=x, output=y)
    names = ["pi", "modified-pi", "static"]

    def told(recording):
        fit = identify(recording)
        found = compare(recording, names)
        chosen = (
            fit.family,
            fit.settings["initial_state"],
            fit.settings.get("smoothing"),
            fit.verdict,
        )
        return (
            *chosen,
            [(c.family, c.initial_state) for c in fit.candidates],
            [e.family for e in found.entries],
        )

    assert told(disturbed) == told(plain)


def test_a_zero_is_shown_without_a_sign():
    card = SignalCard("angle", "deg", -0.0, 5.0)
    assert str(card) == "angle [deg] 0 to 5"
