"""The core against exact rational arithmetic."""

from fractions import Fraction as F

import numpy as np
import pytest

from dehyst import (
    ModifiedPrandtlIshlinskii,
    MonotoneMap,
    PrandtlIshlinskii,
    StopOperatorModel,
    _native,
)
from oracles import (
    exact_inverse,
    exact_pi,
    exact_play,
    random_thresholds,
    random_walk,
    random_weights,
)

EPS = np.finfo(float).eps
NO_MAP = np.zeros(0)


def largest_error(got, expected):
    return max(abs(F(float(g)) - e) for g, e in zip(got, expected, strict=True))


def test_each_play_equals_its_definition_to_the_last_bit():
    rng = np.random.default_rng(1)
    x = (
        np.round(random_walk(rng, 200) * 256) / 256
    )  # dyadic: the sums are exact, and so must the states be
    for radius in (0.0, 3 / 256, 0.25, 0.75):
        z0 = float(rng.integers(-20, 20)) / 256
        got = PrandtlIshlinskii([radius], [1.0], state=[z0]).simulate(x)
        assert largest_error(got, exact_play(x, F(radius), z0)) == 0
        assert radius == 0.75 or np.count_nonzero(np.diff(got)) > 20


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["positive", "negative", "paper", "mixed"])
@pytest.mark.parametrize("n", [1, 2, 7, 8, 9, 16, 100])
def test_outputs_and_states_are_exact_up_to_rounding(kind, n):
    rng = np.random.default_rng([n, len(kind)])
    r, w = random_thresholds(rng, n), random_weights(rng, n, kind)
    offset, center = rng.normal(size=2)
    start = PrandtlIshlinskii(r, w).final_state(random_walk(rng, 60))
    model = PrandtlIshlinskii(r, w, offset, start, center)
    x = random_walk(rng, 40, swing=4) + center
    y = np.full(x.size, np.nan)  # poisoned: an output that is not written fails
    y[:] = model.simulate(x)
    expected = exact_pi(x, r, w, start, offset, center)
    scale = np.max(np.abs(w)) + np.max(np.abs(model.partial_sums))
    assert largest_error(y, expected) < 20 * EPS * (scale + abs(offset)) * (1 + abs(center))
    bank = [
        exact_pi(x, [radius], [1.0], [z], 0, center) for radius, z in zip(r, start, strict=True)
    ]
    assert largest_error(model.final_state(x), [z[-1] for z in bank]) < 4 * EPS * (2 + abs(center))
    moved = sum(len(set(z)) > 1 for z in bank)
    assert moved >= min(n, 1 + n // 3)  # the comparison saw several plays move


def test_the_bank_holds_every_play_at_the_rows_asked_for():
    rng = np.random.default_rng(2)
    r = random_thresholds(rng, 12)
    x = random_walk(rng, 120)
    z0 = PrandtlIshlinskii(r, np.ones(12)).final_state(random_walk(rng, 60))
    single = np.stack(
        [
            PrandtlIshlinskii([ri], [1.0], state=[zi]).simulate(x)
            for ri, zi in zip(r, z0, strict=True)
        ]
    )
    rows = np.array([0, 3, 4, 50, 119])
    bank, last = _native.play_bank(x, r, z0, rows)
    assert bank.shape == (5, 12)
    assert np.array_equal(bank, single[:, rows].T)
    assert np.array_equal(last, single[:, -1])
    assert np.count_nonzero(np.ptp(single, axis=1)) >= 6


def test_the_bank_holds_its_states_over_a_rejected_sample():
    r, z0 = np.array([0.0, 0.5]), np.zeros(2)
    bank, _ = _native.play_bank(np.array([1.0, np.nan, 0.8]), r, z0, np.arange(3))
    assert bank.tolist() == [[1.0, 0.5], [1.0, 0.5], [0.8, 0.5]]


def test_the_closed_inverse_of_the_core_is_that_of_the_printed_sums():
    rng = np.random.default_rng(3)
    for n in (1, 2, 5, 30):
        r, w = random_thresholds(rng, n), random_weights(rng, n, "mixed")
        z = PrandtlIshlinskii(r, w).final_state(random_walk(rng, 60))
        fault, *got = _native.pi_invert(r, w, z)
        assert fault == 0
        for values, expected in zip(got, exact_inverse(r, w, z), strict=True):
            scale = max(abs(float(e)) for e in expected) or 1.0
            assert float(largest_error(values, expected)) < 1e-13 * scale


@pytest.mark.parametrize(
    ("r", "w", "fault"),
    [([0.5], [1.0], -1), ([0.0], [0.0], 1), ([0.0, 1.0], [1.0, -1.0], 2), ([0, 1], [-1.0, 2.0], 2)],
)
def test_the_core_names_the_partial_sum_that_has_no_inverse(r, w, fault):
    assert _native.pi_invert(np.array(r, dtype=float), np.array(w), np.zeros(len(r)))[0] == fault


def test_the_stop_form_is_its_definition():
    rng = np.random.default_rng(4)
    n = 9
    r = np.round(random_thresholds(rng, n) * 256) / 256
    s = np.concatenate([[0.0], rng.integers(0, 256, n - 1) / 256])
    x = np.round(random_walk(rng, 200) * 256) / 256
    model = StopOperatorModel(r, s, slope=0.25, offset=0.5)
    plays = [exact_play(x, F(ri), 0.0) for ri in r.tolist()]
    stops = [[F(xi) - zi for xi, zi in zip(x.tolist(), z, strict=True)] for z in plays]
    expected = [
        F(1, 2)
        + F(1, 4) * F(float(xk))
        + sum(F(float(si)) * e[k] for si, e in zip(s, stops, strict=True))
        for k, xk in enumerate(x)
    ]
    assert largest_error(model.simulate(x), expected) == 0
    play = model.as_play()
    assert play.weights[0] == 0.25 + s.sum()
    assert np.array_equal(play.weights[1:], -s[1:])


def test_the_modified_model_is_map_operator_map():
    rng = np.random.default_rng(5)
    before, after = (
        MonotoneMap([-2.0, 0.0, 2.0], [-1.0, 0.0, 3.0]),
        MonotoneMap([-9.0, 1.0, 9.0], [5.0, 0.0, -1.0]),
    )
    inner = PrandtlIshlinskii(
        random_thresholds(rng, 6), random_weights(rng, 6, "positive"), 0.3, None, -0.1
    )
    x = random_walk(rng, 200, amplitude=2.5)
    whole = ModifiedPrandtlIshlinskii(inner, after_map=after, before_map=before).simulate(x)
    assert np.array_equal(whole, after(inner.simulate(before(x))))
    assert np.max(np.abs(whole - inner.simulate(x))) > 1.0


@pytest.mark.parametrize(
    "arrays",
    [
        (np.zeros(0), np.zeros(0), 0.0, 0.0, NO_MAP, NO_MAP, NO_MAP, NO_MAP, np.zeros(0)),
        (np.zeros(2), np.zeros(1), 0.0, 0.0, NO_MAP, NO_MAP, NO_MAP, NO_MAP, np.zeros(2)),
        (np.zeros(2), np.zeros(2), 0.0, 0.0, NO_MAP, NO_MAP, NO_MAP, NO_MAP, np.zeros(1)),
        (np.zeros(1), np.zeros(1), 0.0, 0.0, np.zeros(1), np.zeros(1), NO_MAP, NO_MAP, np.zeros(1)),
        (np.zeros(1), np.zeros(1), 0.0, 0.0, NO_MAP, NO_MAP, np.zeros(2), np.zeros(3), np.zeros(1)),
    ],
)
def test_the_binding_refuses_arrays_that_do_not_fit_together(arrays):
    with pytest.raises(ValueError, match=r"differ in length|list of pairs"):
        _native.Stepper(*arrays)
