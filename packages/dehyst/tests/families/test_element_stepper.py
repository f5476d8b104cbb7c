"""A sum sample by sample is the sum along the whole signal, to the bit; what is no sample changes nothing."""

import numpy as np
import pytest

from dehyst.errors import ParameterError
from dehyst.families import ROW_NAMES, example
from dehyst.families._elements import ElementStepper

PERIOD = 2.0**-6  # stamps are then exact
T = PERIOD * np.arange(400)
X = 0.8 * np.sin(5.0 * T) * np.cos(0.7 * T)


def both_ways(name):
    model = example(name)
    return (model, model.inverse())


@pytest.mark.parametrize("name", ROW_NAMES)
@pytest.mark.parametrize("way", [0, 1])
def test_sample_by_sample_is_the_whole_signal_to_the_bit(name, way):
    model = both_ways(name)[way]
    step = model.stepper(PERIOD)
    assert isinstance(step, ElementStepper)
    answers = np.array([step(value) for value in X.tolist()])
    assert answers.tobytes() == model.simulate(X, T).tobytes()
    step.reset()
    assert step(X[0]) == answers[0]


@pytest.mark.parametrize("way", [0, 1])
def test_what_is_no_number_is_held_and_said_and_what_is_far_out_is_refused(way):
    model = both_ways("mixed-sum")[way]
    step, clean = model.stepper(PERIOD), model.stepper(PERIOD)
    assert step(np.nan) == 0.0
    assert step.rejected and step.rejected_ever
    for value in X[:50].tolist():
        clean(value)
        step(value)
        assert not step.rejected
        held = step.output
        assert step(np.inf) == held == step.output
        assert step.rejected and step.rejected_ever
    with pytest.raises(ParameterError, match="Drop them"):
        step(1e200)
    assert step(X[50]) == clean(X[50])


def test_the_time_of_a_call_counts_before_that_of_the_stepper():
    model = example("creep-pi")
    slow, asked = model.stepper(4.0 * PERIOD), model.stepper(PERIOD)
    for value in X[:40].tolist():
        assert slow(value) == asked(value, 4.0 * PERIOD)
