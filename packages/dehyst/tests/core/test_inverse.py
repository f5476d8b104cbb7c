"""The closed inverse undoes the model, in both orders, from any visited state, within 1e-12 of the range."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst import ModifiedPrandtlIshlinskii, MonotoneMap, PrandtlIshlinskii, StopOperatorModel
from dehyst.errors import InvertibilityError
from dehyst.models import StaticCurve
from oracles import (
    exact,
    exact_inverse,
    input_by_bisection,
    random_thresholds,
    random_walk,
    random_weights,
)

TOLERANCE = 1e-12
EPS = np.finfo(float).eps
SIZES = (1, 2, 3, 8, 17, 40, 100)
PLAIN = ("positive", "negative", "paper", "mixed")
FAMILIES = (*PLAIN, "stop", "after-rising", "after-falling", "before", "both", "static")


def bend(rng, span, falling=False, pieces=12):
    """Return a strictly monotone map over +-span, slopes 0.2 to 2."""
    u = np.linspace(-span, span, pieces)
    v = (
        np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 2.0, pieces - 1) * np.diff(u))])
        + rng.normal()
    )
    return MonotoneMap(u, -v if falling else v)


def visited(model, rng):
    """Return the model in a state that a random history left."""
    return model.with_state(model.final_state(random_walk(rng, 150)))


def make(family, n, rng):
    """Return a random model of a family in a visited state; inputs reach from -1 to 1."""
    r = random_thresholds(rng, n)
    offset, center = rng.normal(size=2) * 0.5
    if family in PLAIN:
        return visited(
            PrandtlIshlinskii(r, random_weights(rng, n, family), offset, None, center), rng
        )
    if family == "stop":
        s = np.concatenate([[0.0], rng.uniform(0.0, 2.0 / n, n - 1)])
        return visited(StopOperatorModel(r, s, rng.uniform(0.1, 1.0), offset, None, center), rng)
    if family == "static":
        return StaticCurve(bend(rng, 1.0, falling=bool(rng.random() < 0.5)))
    before = bend(rng, 1.0) if family in ("before", "both") else None
    if before is not None:  # the operator sees the map's values: put it in their middle
        center, r = np.mean(before.v[[0, -1]]), r * np.ptp(before.v) / 2
    inner = PrandtlIshlinskii(r, random_weights(rng, n, "mixed"), offset, None, center)
    after = bend(rng, 2.0, falling=family == "after-falling") if family != "before" else None
    return visited(ModifiedPrandtlIshlinskii(inner, after_map=after, before_map=before), rng)


def relative(error, signal):
    return float(np.max(np.abs(error)) / np.ptp(signal))


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("family", FAMILIES)
def test_inverse_and_model_undo_each_other_in_both_orders(family, n):
    rng = np.random.default_rng([FAMILIES.index(family), n])
    for _ in range(6):
        model = make(family, n, rng)
        inverse = model.inverse()
        x = random_walk(rng, 400)
        y = model.simulate(x)
        assert relative(inverse.simulate(y) - x, x) < TOLERANCE
        # The other order, with a wish for the output that no simulation produced.
        wish = np.interp(random_walk(rng, 400), [-1.0, 1.0], [np.min(y), np.max(y)])
        assert relative(model.simulate(inverse.simulate(wish)) - wish, wish) < TOLERANCE


@pytest.mark.parametrize("family", [f for f in FAMILIES if f != "static"])
def test_the_round_trips_are_not_vacuous(family):
    rng = np.random.default_rng(7)
    model = make(family, 17, rng)
    x = random_walk(rng, 400)
    y = model.simulate(x)
    start, end = model.stepper().state, model.final_state(x)
    assert np.count_nonzero(start) == 17  # the start state was visited, and was not rest
    assert np.count_nonzero(start != end) >= 5  # several plays moved
    gaps = np.diff(getattr(model, "hysteresis", model).thresholds)
    assert np.any(np.abs(np.diff(start)) < 0.9 * gaps)  # nor was it wiped out by one large swing
    # The model has a loop: near the same input, outputs differ by far more than the tolerance.
    order = np.argsort(x)
    assert np.max(np.abs(np.diff(y[order]))) > 1e-3 * np.ptp(y)
    # And the state matters: without it the inverse is wrong.
    wrong = model.inverse().with_state(None).simulate(y)
    assert relative(wrong - x, x) > 1e-3 or family == "paper"


@pytest.mark.parametrize("family", FAMILIES)
def test_the_inverse_of_the_inverse_is_the_model(family):
    rng = np.random.default_rng(11)
    for n in (1, 2, 9, 60):
        model = make(family, n, rng)
        again = model.inverse().inverse()
        x = random_walk(rng, 300)
        y = model.simulate(x)
        assert relative(again.simulate(x) - y, y) < TOLERANCE
        inner, back = (getattr(m, "hysteresis", m) for m in (model, again))
        inner = inner.as_play() if isinstance(inner, StopOperatorModel) else inner
        if isinstance(inner, PrandtlIshlinskii):
            scale = np.max(np.abs(inner.partial_sums))
            np.testing.assert_allclose(back.thresholds, inner.thresholds, rtol=0, atol=TOLERANCE)
            np.testing.assert_allclose(
                back.partial_sums, inner.partial_sums, rtol=0, atol=TOLERANCE * scale
            )
            np.testing.assert_allclose(back.state, inner.state, rtol=0, atol=TOLERANCE)
            assert (back.center, back.offset) == (inner.center, inner.offset)


@pytest.mark.parametrize("kind", PLAIN)
def test_the_inverse_has_the_parameters_of_the_closed_form(kind):
    rng = np.random.default_rng(3)
    for n in (1, 2, 10, 100):
        r, w = random_thresholds(rng, n), random_weights(rng, n, kind)
        model = visited(PrandtlIshlinskii(r, w), rng)
        ri, wi, zi = exact_inverse(r, w, model.state, sign=-1 if kind == "negative" else 1)
        inverse = model.inverse()
        for got, expected in ((inverse.thresholds, ri), (inverse.weights, wi), (inverse.state, zi)):
            expected = np.array([float(v) for v in expected])
            np.testing.assert_allclose(
                got, expected, rtol=1e-10, atol=1e-15 * np.max(np.abs(expected))
            )
        assert np.array_equal(inverse.weights == 0.0, w == 0.0)  # what was pruned stays pruned


def test_the_inverse_finds_the_input_that_bisection_finds():
    rng = np.random.default_rng(5)
    for n in (1, 3, 7):
        model = visited(
            PrandtlIshlinskii(random_thresholds(rng, n), random_weights(rng, n, "mixed")), rng
        )
        y = model.simulate(random_walk(rng, 40, swing=4))
        found = input_by_bisection(y, model.thresholds, model.weights, model.state, -4, 4)
        np.testing.assert_allclose(model.inverse().simulate(y), found, rtol=0, atol=1e-14)


def test_the_papers_printed_equation_18_does_not_invert():
    # Kastner, Gattringer & Naderer (2012) print r'_i = sum_{j<=i} w_j (r_i - w_j); (19) and (20) are right.
    rng = np.random.default_rng(18)
    n = 10
    model = PrandtlIshlinskii(np.arange(n) / n, rng.uniform(0.1, 0.5, n))
    r, w = model.thresholds, model.weights
    printed = np.array([np.sum(w[: i + 1] * (r[i] - w[: i + 1])) for i in range(n)])
    assert printed[0] == -(w[0] ** 2) < 0.0  # no play has a negative radius
    with pytest.raises(ValueError, match="negative"):
        PrandtlIshlinskii(printed, model.inverse().weights)

    x = random_walk(rng, 400)
    y = model.simulate(x)
    z, composed = np.zeros(n), []
    for (
        sample
    ) in y:  # max-min with a negative radius is still a formula: give the print its best chance
        z = np.maximum(sample - printed, np.minimum(sample + printed, z))
        composed.append(model.inverse().weights @ z)
    assert relative(np.array(composed) - x, x) > 0.1
    assert relative(model.inverse().simulate(y) - x, x) < TOLERANCE


@st.composite
def extreme_models(draw):
    """Legal and hard: w_1 = 0.001, slopes up to 1000, thresholds crowded or wide apart."""
    n = draw(st.integers(2, 100))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    w = np.concatenate([[1e-3], rng.uniform(0.0, 1.0, n - 1) ** draw(st.sampled_from([1, 4, 12]))])
    w[1:] *= 10.0 ** draw(st.integers(-2, 3)) / np.sum(w[1:])
    return visited(PrandtlIshlinskii(random_thresholds(rng, n), w), rng), rng


@given(extreme_models())
def test_extreme_models_lose_no_more_digits_than_the_number_format(case):
    model, rng = case
    inverse = model.inverse()
    x = random_walk(rng, 300)
    y = model.simulate(x)
    # One unit in the last place of y is 1/w_1 times as much of x: no arithmetic can do better than this.
    unavoidable = EPS * np.max(np.abs(y)) * model.inverse_gain / np.ptp(x)
    assert relative(inverse.simulate(y) - x, x) < max(TOLERANCE, 4 * unavoidable)
    # The order that a compensator uses loses digits only where one slope is far steeper than the one before:
    # w'_2 cancels w'_1 there, and no pair of doubles 1000 and -999.99 adds up to 1/S_2 more closely.
    jump = np.max(model.partial_sums[1:] / model.partial_sums[:-1])
    assert relative(model.simulate(inverse.simulate(y)) - y, y) < max(TOLERANCE, EPS * jump)


def test_an_unlimited_stiff_start_does_not_spoil_the_compensator():
    # w'_1 = 1000 and slopes of 0.001: a sum of w' z' as written loses six digits here, a sum by slopes none.
    rng = np.random.default_rng(2)
    model = PrandtlIshlinskii(np.arange(100) / 100, [1e-3, *rng.uniform(0.0, 20.0, 99)])
    y = model.simulate(random_walk(rng, 500))
    inverse = model.inverse()
    naive = PrandtlIshlinskii(inverse.thresholds, inverse.weights)
    bank = np.stack([PrandtlIshlinskii([r], [1.0]).simulate(y) for r in naive.thresholds])
    assert relative(model.simulate(naive.weights @ bank) - y, y) > TOLERANCE
    assert relative(model.simulate(inverse.simulate(y)) - y, y) < 1e-13


def test_thousand_operators_are_inverted_too():
    rng = np.random.default_rng(1000)
    for kind in PLAIN:
        model = visited(
            PrandtlIshlinskii(random_thresholds(rng, 1000), random_weights(rng, 1000, kind)), rng
        )
        x = random_walk(rng, 300)
        y = model.simulate(x)
        assert relative(model.inverse().simulate(y) - x, x) < TOLERANCE
        assert relative(model.simulate(model.inverse().simulate(y)) - y, y) < TOLERANCE


@pytest.mark.parametrize("kind", PLAIN)
def test_pruning_zero_weights_is_exact(kind):
    rng = np.random.default_rng(4)
    w = random_weights(rng, 40, kind)
    w[1:] *= rng.random(39) < 0.5
    if kind == "mixed":
        w = np.diff(np.repeat(rng.uniform(0.2, 2.0, 20), 2), prepend=0.0)
    model = visited(PrandtlIshlinskii(random_thresholds(rng, 40), w), rng)
    pruned = model.pruned()
    assert pruned.thresholds.size == model.nonzero_weights < 40
    x = random_walk(rng, 300)
    y = model.simulate(x)
    assert relative(pruned.simulate(x) - y, y) < 1e-14
    assert relative(pruned.inverse().simulate(y) - x, x) < TOLERANCE


@pytest.mark.parametrize(
    ("weights", "index"),
    [
        ([1.0, -1.0], 1),
        ([1.0, -2.0, 3.0], 1),
        ([-1.0, 0.5, 0.5], 2),
        ([0.0, 1.0], 0),
        ([-0.0, -1.0], 0),
    ],
)
def test_a_partial_sum_that_vanishes_or_changes_sign_is_named(weights, index):
    model = PrandtlIshlinskii(np.arange(len(weights)) * 0.5, weights)
    with pytest.raises(InvertibilityError, match=f"first {index + 1} weights") as fault:
        model.inverse()
    assert fault.value.facts["index"] == index
    assert fault.value.facts["partial_sum"] == float(sum(exact(weights)[: index + 1]))


def test_a_dead_zone_has_no_inverse():
    with pytest.raises(InvertibilityError, match=r"smallest threshold is 0\.1") as fault:
        PrandtlIshlinskii([0.1, 0.5], [1.0, 1.0]).inverse()
    assert fault.value.facts["threshold"] == 0.1


def test_thresholds_that_merge_in_the_inverse_are_refused_by_name():
    # r'_3 - r'_2 = S_2 (r_3 - r_2) vanishes beside r'_2: the inverse would silently lose an operator.
    model = PrandtlIshlinskii([0.0, 1.0, 1.0 + 1e-15, 2.0], [1e6, -1e6 + 1e-6, 1.0, 1.0])
    with pytest.raises(InvertibilityError, match="double precision"):
        model.inverse()


def test_the_inverse_gain_bounds_every_slope_of_the_inverse_and_is_reached_at_reversals():
    rng = np.random.default_rng(9)
    for family in FAMILIES:
        model = make(family, 8, rng)
        y = model.simulate(random_walk(rng, 2000, swing=50))
        x = model.inverse().simulate(y)
        moved = np.abs(np.diff(y)) > 1e-6
        slopes = np.abs(np.diff(x)[moved] / np.diff(y)[moved])
        assert np.max(slopes) <= model.inverse_gain * (1 + 1e-6)
        if family in ("positive", "negative", "paper"):
            assert np.max(slopes) >= model.inverse_gain * (1 - 1e-6)


# A bound of the rounding, for all plays: sums of n terms, none larger than the range, are rounded in the inverse, and
# so are its input and output; a small slope takes them up to the input, and a large one down to the output again.


def bound(model, x, y):
    """Return (n + X + Y) eps S: X and Y the largest input and output in ranges, S the ratio of the slopes."""
    slopes = np.cumsum(model.weights)
    far = sum(float(np.max(np.abs(signal)) / np.ptp(signal)) for signal in (x, y))
    return (len(slopes) + far) * EPS * float(np.max(slopes) / np.min(slopes))


def steep(seed):
    """Return a model of random slopes that differ by a factor up to 1e4, far from zero or not, and its numbers."""
    rng = np.random.default_rng(seed)
    n, top = int(rng.choice([1, 2, 3, 8, 17, 40, 100])), 10 ** rng.uniform(0.5, 4.0)
    alternating = np.arange(n) % 2 == seed % 2
    slopes = (
        np.where(alternating, top, 1.0),
        np.where(rng.random(n) < rng.random(), top, 1.0),
        np.sort(np.exp(rng.uniform(0.0, np.log(top), n))),  # all weights are positive
        np.where(np.arange(n) < n // 2, top, 1.0),
        np.exp(rng.uniform(0.0, np.log(top), n)),
        np.cumsum(random_weights(rng, n, "positive")),
    )[seed % 6]
    offset, center = (
        rng.normal(size=2)
        * 10 ** rng.uniform(-2.0, 3.0, 2)
        * (seed % 4 == 0)
        * [np.max(slopes), 1.0]
    )
    model = PrandtlIshlinskii(
        random_thresholds(rng, n), np.diff(slopes, prepend=0.0), offset, None, center
    )
    walk = np.random.default_rng(seed + 1)
    return model.with_state(model.final_state(center + random_walk(walk, 150))), walk, center


@pytest.mark.parametrize("count", [150, pytest.param(3000, marks=pytest.mark.slow)])
def test_the_stated_bound_holds_for_slopes_that_differ_by_a_factor_of_ten_thousand_and_is_not_vacuous(
    count,
):
    shares = []
    for seed in range(count):
        model, rng, center = steep(seed)
        inverse, x = model.inverse(), center + random_walk(rng, 400)
        y = model.simulate(x)
        wish = np.interp(random_walk(rng, 400), [-1.0, 1.0], [np.min(y), np.max(y)])
        missed = model.simulate(inverse.simulate(wish)) - wish
        shares.append(relative(missed, wish) / bound(model, x, y))
        shares.append(relative(inverse.simulate(y) - x, x) / bound(model, x, y))
    assert 0.1 < max(shares) < 1.0
