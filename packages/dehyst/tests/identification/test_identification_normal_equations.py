"""Normal equations of the cells: the same optimum as orthogonal factors, additive, exact where the data are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst._native import Gram
from dehyst.errors import ParameterError
from dehyst.identification import _families as families
from dehyst.identification._regressors import NormalEquations
from dehyst.io import example_recording
from identification_oracles import loops, plays

SIZES = (2.0, 1.6, 1.9, 1.2, 1.7, 2.0, 1.4, 1.8)
PI = dehyst.PrandtlIshlinskii([0.0, 0.2, 0.5, 0.9], [0.7, 0.4, 0.3, 0.3])
FAMILIES = ("pi", "pi-cumulative", "modified-pi", "stop")


def noisy(truth=PI, seed=0, scale=0.02, map_of=lambda y: y):
    rng = np.random.default_rng(seed)
    x = loops((*SIZES, *SIZES), 50) + 0.01 * rng.standard_normal(1601)
    y = map_of(truth.simulate(x)) + scale * rng.standard_normal(x.size)
    return dehyst.Recording(input=x + 1.0, output=y - 2.0, time=0.01 * np.arange(x.size))


def parameters_of(model):
    inner = getattr(model, "hysteresis", model)
    own = inner.stop_weights if isinstance(inner, dehyst.StopOperatorModel) else inner.weights
    return inner.thresholds, own


@pytest.fixture
def by_orthogonal_factors(monkeypatch):
    """Identify by the other route."""

    def identify(*arguments, **settings):
        with monkeypatch.context() as patch:
            patch.setattr(families, "LARGEST_CONDITION", 0.0)
            return dehyst.identify(*arguments, **settings)

    return identify


@pytest.mark.spread(8)
@pytest.mark.parametrize("family", [*FAMILIES, pytest.param("auto", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "make", [noisy, lambda: noisy(map_of=np.tanh), lambda: noisy(seed=3, scale=0.2)]
)
def test_both_routes_give_the_same_model(make, family, by_orthogonal_factors):
    rec = make()
    sums, factors = dehyst.identify(rec, family, n=40), by_orthogonal_factors(rec, family, n=40)
    assert (sums.certificate.route, factors.certificate.route) == (
        "normal equations",
        "orthogonal factors",
    )
    assert sums.family == factors.family
    assert sums.certificate.initial_state == factors.certificate.initial_state
    (r, w), (r_other, w_other) = parameters_of(sums.model), parameters_of(factors.model)
    assert np.array_equal(r, r_other)
    slope = np.ptp(rec.output) / np.ptp(rec.input)
    assert np.abs(w - w_other).max() < 1e-9 * slope
    assert sums.test.rmse == pytest.approx(factors.test.rmse, rel=1e-10)
    assert sums.certificate.kkt_residual < 1e-13


@pytest.mark.slow
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from(FAMILIES),
    st.integers(2, 30),
    st.sampled_from([0.001, 0.2]),
)
@settings(max_examples=40)
def test_both_routes_agree_on_random_data(seed, family, n, eps):
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1.0, 1.0, 400).cumsum() if seed % 2 else rng.uniform(-1.0, 1.0, 400)
    rec = dehyst.Recording(
        input=x, output=0.5 * np.clip(x, -1, 1) + np.roll(x, 1) + 0.1 * rng.standard_normal(x.size)
    )
    change = {
        "n": n,
        "eps": eps * (np.ptp(rec.output[:200]) / np.ptp(x[:200]) if family == "pi" else 1.0),
    }
    one = dehyst.identify(rec, family, initial_state="zero", **change)
    kept, families.LARGEST_CONDITION = families.LARGEST_CONDITION, 0.0
    try:
        other = dehyst.identify(rec, family, initial_state="zero", **change)
    finally:
        families.LARGEST_CONDITION = kept
    assert one.train.rmse == pytest.approx(other.train.rmse, rel=1e-9)
    assert np.abs(one.predictions[0] - other.predictions[0]).max() < 1e-6 * np.ptp(rec.output)


@pytest.mark.slow
@pytest.mark.parametrize("n", [100, 1000])
@pytest.mark.parametrize("dense", [True, False])
def test_weights_of_exact_data_come_back(n, dense):
    rng = np.random.default_rng(n)
    t = np.linspace(0.0, 1.0, 30_000)
    x = (0.6 + 0.4 * np.sin(20 * t)) * np.sin(700 * t)
    x = np.concatenate([x, -x])  # centred exactly
    truth = np.where(rng.random(n) < (1.0 if dense else 0.1), rng.random(n), 0.0)
    truth[0] = 0.5
    r = np.arange(n) / n * np.abs(x).max()
    y = dehyst.PrandtlIshlinskii(r, truth).simulate(x)
    rec = dehyst.Recording(input=x, output=y)
    fit = dehyst.identify(rec, "pi", thresholds=r, initial_state="zero", train_fraction=1)
    found = np.zeros(n)
    index = np.searchsorted(r, fit.model.thresholds - 1e-9)
    assert np.allclose(r[index], fit.model.thresholds, rtol=0, atol=1e-15)
    found[index] = fit.model.weights
    # With a thousand weights of like size y is 250 times as large as they are, and so is its rounding.
    bound = 1e-12 if n == 100 else 2e-12 * np.abs(y).max() if dense else 1e-11
    assert np.abs(found - truth).max() < bound * truth.max()


def test_a_weight_counts_as_so_many_samples():
    rec = noisy()
    count = np.random.default_rng(1).integers(0, 4, len(rec))
    repeated = np.repeat(np.arange(len(rec)), np.maximum(count, 1))
    twice = dehyst.Recording(input=rec.input[repeated], output=rec.output[repeated])
    for family in FAMILIES:
        weighted = dehyst.identify(
            rec, family, n=30, weights=count, initial_state="zero", train_fraction=1
        )
        logged = dehyst.identify(
            twice, family, n=30, weights=count[repeated] > 0, initial_state="zero", train_fraction=1
        )
        assert np.allclose(
            parameters_of(weighted.model)[1], parameters_of(logged.model)[1], rtol=0, atol=1e-9
        )
        assert weighted.train.rmse == pytest.approx(logged.train.rmse, rel=1e-11)
        # The curve's smoothing is chosen by way, and a sample that is logged again makes none.
        assert weighted.static_train.rmse == pytest.approx(logged.static_train.rmse, rel=0.03)
        assert (weighted.train_masks[0] == (count > 0)).all()


def test_equal_weights_change_nothing():
    rec = noisy()
    plain, weighted = (
        dehyst.identify(rec, n=30),
        dehyst.identify(rec, n=30, weights=np.ones(len(rec))),
    )
    assert plain.family == weighted.family
    assert np.allclose(
        parameters_of(plain.model)[1], parameters_of(weighted.model)[1], rtol=0, atol=1e-10
    )
    assert [c.family for c in plain.candidates] == [c.family for c in weighted.candidates]


def test_outputs_without_weight_do_not_count_at_all():
    rec = noisy()
    weight = np.ones(len(rec))
    weight[200:240] = weight[1200:1210] = 0.0
    spoiled = rec.output.copy()
    spoiled[weight == 0.0] = 50.0
    other = dehyst.Recording(input=rec.input, output=spoiled, time=rec.time)
    fits = [dehyst.identify(log, n=30, weights=weight) for log in (rec, other)]
    assert fits[0].family == fits[1].family
    assert np.array_equal(fits[0].predictions[0], fits[1].predictions[0])
    assert fits[0].train == fits[1].train and fits[0].test == fits[1].test
    assert fits[0].facts.width_percent == pytest.approx(fits[1].facts.width_percent)


@pytest.mark.parametrize(
    ("weights", "cure"),
    [
        (np.ones(7), "one weight for each sample"),
        ([np.ones(1601), np.ones(1601)], "one weight for each sample"),
        (-np.ones(1601), "0 leaves a sample out"),
        (np.full(1601, np.nan), "0 leaves a sample out"),
        (np.zeros(1601), "Give some of them a weight"),
        ("heavy", "one weight for each sample"),
        (3.0, "not numbers"),
    ],
)
def test_weights_that_make_no_sense_are_refused(weights, cure):
    with pytest.raises(ParameterError, match=cure):
        dehyst.identify(noisy(), "pi", weights=weights)


def test_a_condition_number_above_the_limit_takes_the_other_route_and_the_certificate_says_so(
    monkeypatch,
):
    rec = noisy()
    fit = dehyst.identify(rec, "pi", n=40)
    assert 1.0 < fit.certificate.condition < 1e4 < families.LARGEST_CONDITION == 1e6
    found = [fit]
    for limit in (1.01, 0.99):
        monkeypatch.setattr(families, "LARGEST_CONDITION", limit * fit.certificate.condition)
        found.append(dehyst.identify(rec, "pi", n=40))
    routes = [f.certificate.route for f in found]
    assert routes == ["normal equations", "normal equations", "orthogonal factors"]
    assert [f.as_dict()["route"] for f in found] == routes
    assert all(f.as_dict()["condition"] == pytest.approx(fit.certificate.condition) for f in found)


@pytest.mark.slow
def test_operators_that_the_data_cannot_tell_apart_do_no_harm(by_orthogonal_factors):
    # Of a coarsely quantised input, neighbouring cells are equal in every sample.
    rec = noisy(scale=0.0)
    coarse = dehyst.Recording(input=np.round(4 * rec.input) / 4, output=rec.output)
    for family in FAMILIES:
        sums, factors = (
            identify(coarse, family, n=60) for identify in (dehyst.identify, by_orthogonal_factors)
        )
        assert sums.train.rmse == pytest.approx(factors.train.rmse, rel=1e-9)
        assert np.abs(sums.predictions[0] - factors.predictions[0])[: len(rec) // 2].max() < 1e-7


def accumulate(rec, r):
    gram = Gram(r, np.zeros(r.size), 1)
    gram.add(rec.input - 1.0, rec.output[None, :], None)
    return NormalEquations(r, gram.take())


def test_sums_add_over_recordings_and_pieces_and_over_operators():
    a, b, r = noisy(seed=1), noisy(seed=2), np.arange(20) / 10.0
    parts = [accumulate(rec, r) for rec in (a, b)]
    assert (parts[0] + parts[1]).samples == len(a) + len(b)
    z = plays(a.input - 1.0, r, np.zeros(20))
    cells = z - np.column_stack([z[:, 1:], np.zeros(len(a))])
    columns = np.column_stack([np.ones(len(a)), cells, a.output])
    assert np.allclose(parts[0].matrix, columns.T @ columns, rtol=0, atol=1e-9)
    assert np.array_equal((parts[0] + parts[1]).matrix, parts[0].matrix + parts[1].matrix)
    kept = np.arange(20) % 4 == 0
    assert np.allclose(
        parts[0].coarser(kept).matrix, accumulate(a, r[kept]).matrix, rtol=0, atol=1e-9
    )
    with pytest.raises(ParameterError, match="same thresholds"):
        parts[0] + accumulate(b, r[:5])
    with pytest.raises(ParameterError, match="keep the first"):
        parts[0].coarser(np.arange(20) > 3)


def test_too_many_operators_are_refused_with_the_memory_they_would_take():
    with pytest.raises(ParameterError, match=r"GB.*at most 10000"):
        dehyst.identify(noisy(), "pi", n=10_001)


def test_the_example_takes_normal_equations():
    certificate = dehyst.identify(example_recording(), "modified-pi").certificate
    assert certificate.route == "normal equations"
    assert certificate.condition < families.LARGEST_CONDITION
