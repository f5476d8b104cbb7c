"""dehyst_pi_step, which moves a prefix found by bisection, against the definition of the operator."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst import PrandtlIshlinskii
from oracles import exact, exact_pi, random_thresholds, random_walk, random_weights

KINDS = ("positive", "negative", "paper", "mixed")


def definition(model, x):
    """Return outputs and states of the definition: every play by itself, weights summed as they are, in long double."""
    z = np.zeros(model.thresholds.size) if model.state is None else model.state.copy()
    y = []
    for sample in np.asarray(x) - model.center:
        z = np.maximum(sample - model.thresholds, np.minimum(sample + model.thresholds, z))
        y.append(float(np.sum(model.weights.astype(np.longdouble) * z) + model.offset))
    return np.array(y), z


def stepped(model, x):
    step = model.stepper("dense")
    return np.array([step(v) for v in np.asarray(x).tolist()]), step.state


def size(model, x):
    """Return what rounding is measured by: the sum of the operator's terms."""
    reach = np.max(np.abs(np.asarray(x) - model.center)) + model.thresholds[-1]
    return abs(model.offset) + float(np.sum(np.abs(model.weights))) * reach


@given(st.integers(0, 10**6), st.sampled_from(KINDS), st.booleans())
def test_outputs_and_states_are_those_of_the_definition(seed, kind, dead):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 40))
    r = random_thresholds(rng, n) + (rng.uniform(0.01, 0.3) if dead else 0.0)
    model = PrandtlIshlinskii(
        r, random_weights(rng, n, kind), rng.normal(), None, rng.normal() * 0.3
    )
    model = model.with_state(model.final_state(random_walk(rng, 50)))
    x = random_walk(rng, 200, swing=int(rng.integers(1, 15)))
    x = np.repeat(x, rng.integers(1, 3, x.size))  # some samples twice
    y, state = stepped(model, x)
    expected, z = definition(model, x)
    assert np.max(np.abs(y - expected)) <= 1e-13 * size(model, x)
    assert np.array_equal(state, z)  # states to the bit


grid = st.integers(-8, 8).map(lambda k: k / 4.0)


@given(
    st.lists(st.integers(1, 3), min_size=1, max_size=8),
    st.integers(0, 2),
    st.lists(st.integers(-4, 4).map(lambda k: k / 2.0), min_size=8, max_size=8),
    st.lists(grid, min_size=1, max_size=40),
)
def test_ties_on_a_grid_are_exact(gaps, first, weights, x):
    # Inputs meet thresholds exactly again and again; every number is a multiple of 1/8, so that nothing is rounded.
    r = first / 4.0 + np.concatenate([[0.0], np.cumsum(gaps[1:]) / 4.0])
    model = PrandtlIshlinskii(r, weights[: r.size])
    y, state = stepped(model, x)
    expected, z = definition(model, x)
    assert y.tolist() == expected.tolist()
    assert state.tolist() == z.tolist()


@given(st.integers(0, 10**6))
def test_a_repeated_sample_changes_nothing(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 30))
    model = PrandtlIshlinskii(
        random_thresholds(rng, n), random_weights(rng, n, "mixed"), center=rng.normal()
    )
    step = model.stepper("dense")
    for x in random_walk(rng, 60).tolist():
        y, image = step(x), step.save()
        assert step(x) == y
        assert step.save().tobytes() == image.tobytes()


def test_one_operator_is_a_play_with_a_gain():
    model = PrandtlIshlinskii([0.5], [2.0], offset=1.0, center=0.25)
    assert stepped(model, [0.25, 1.25, 1.0, 0.5, -0.75])[0].tolist() == [1.0, 2.0, 2.0, 2.0, 0.0]
    line = PrandtlIshlinskii([0.0], [2.0], offset=1.0, center=0.25)
    assert stepped(line, [0.25, 1.25, 1.0])[0].tolist() == [1.0, 3.0, 2.5]


@pytest.mark.parametrize("n", [14, 100, 1000])
def test_an_inverse_with_weights_far_larger_than_its_slopes_loses_no_digits(n):
    # Partial sums of the paper's weights: 1/w_1 = 1000 against slopes near one. Compared with exact rationals.
    rng = np.random.default_rng(n)
    model = PrandtlIshlinskii(random_thresholds(rng, n), random_weights(rng, n, "paper")).inverse()
    x = random_walk(rng, 30, amplitude=0.5, swing=3)
    y, _ = stepped(model, x)
    # The stepper uses the running sums S of the weights; those are what the exact operator takes here.
    sums = exact(model.partial_sums)
    weights = [sums[0], *(b - a for a, b in pairwise(sums))]
    states = [exact_pi(x, [r], [1.0], [0.0]) for r in model.thresholds]
    wanted = [
        float(sum((w * z[k] for w, z in zip(weights, states, strict=True)), Fraction(0)))
        for k in range(x.size)
    ]
    assert np.max(np.abs(y - wanted)) <= 4e-15 * max(1.0, float(np.max(np.abs(model.partial_sums))))
