"""What plays remember before the first sample and after gaps, and which samples count."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import dehyst
from dehyst.errors import ExcitationError
from dehyst.identification import known_from, state_before
from dehyst.identification._memory import largest_radius
from identification_oracles import loops, plays

THRESHOLDS = [0.0, 0.3, 0.7, 1.1]
WEIGHTS = [0.6, 0.4, 0.3, 0.5]
ORBIT = (2.0, 1.5, 1.9, 0.8, 1.2, 2.0)


def path_state(path, thresholds, z0=0.0):
    """State after a path, by definition of the play."""
    return plays(np.array(path), thresholds, np.full(len(thresholds), z0))[-1]


@pytest.mark.parametrize("first", [-1.0, -0.4, 0.0, 0.9, 1.0])
def test_start_states_are_those_of_the_histories_they_name(first):
    r = np.linspace(0.0, 0.99, 34)
    assert np.array_equal(state_before("zero", r, first, -1.0, 1.0), np.zeros(34))
    assert np.array_equal(state_before("rest", r, first, -1.0, 1.0), np.full(34, first))
    assert np.allclose(
        state_before("rising", r, first, -1.0, 1.0), path_state([1.0, -1.0, first], r), atol=1e-15
    )
    assert np.allclose(
        state_before("falling", r, first, -1.0, 1.0), path_state([-1.0, 1.0, first], r), atol=1e-15
    )
    assert np.array_equal(
        state_before("unknown", r, first, -1, 1), state_before("rising", r, first, -1, 1)
    )


@given(
    st.lists(st.integers(-64, 64), min_size=1, max_size=40),
    st.integers(0, 64),
    st.integers(-64, 64),
)
def test_after_both_extremes_the_history_before_is_forgotten(path, radius, before):
    x, r = np.array(path) / 64.0, radius / 64.0
    k = known_from(x, -1.0, 1.0)
    if k == x.size:
        return
    slack = 0.02 * 2.0  # extremes count as visited within 2 % of the range
    r = min(r, 1.0 - slack)
    # Any state a history within the range can leave.
    other = np.clip(before / 64.0, -1.0 + r, 1.0 - r)
    assert plays(x, [r], [0.0])[k] == plays(x, [r], [other])[k]


def test_known_from_is_the_length_where_an_extreme_is_missed():
    assert known_from(np.array([0.0, 1.0, 0.9]), -1.0, 1.0) == 3
    assert known_from(np.array([0.97, -0.97]), -1.0, 1.0) == 1


def test_no_play_beyond_the_largest_radius_moves():
    x = loops((1.0, 0.6), start=0.4)
    assert largest_radius("zero", x[0], x.min(), x.max()) == 1.0
    assert largest_radius("rest", x[0], x.min(), x.max()) == pytest.approx(1.4)
    beyond = plays(x, [1.0, 1.2, 1.4, 1.5], [0.0, 0.4, 0.4, 0.4])
    assert np.ptp(beyond, axis=0).tolist() == pytest.approx([0.0, 0.2, 0.0, 0.0])


# Identification from each start: the right assumption gives the truth back, wrong ones do not.

PATHS = {"zero": [0.0], "rest": None, "rising": [2.0, -2.0], "falling": [-2.0, 2.0]}


def started(kind, first=0.5):
    """A recording whose history before the first sample is of a given kind."""
    x = loops(ORBIT, 60, start=first)
    history = PATHS[kind]
    z0 = np.full(4, first) if history is None else path_state(history, THRESHOLDS)
    model = dehyst.PrandtlIshlinskii(THRESHOLDS, WEIGHTS, state=z0)
    return dehyst.Recording(input=x, output=model.simulate(x))


@pytest.mark.parametrize("kind", PATHS)
def test_the_right_start_state_gives_the_true_weights(kind):
    rec = started(kind)
    for assumed in PATHS:
        fit = dehyst.identify(
            rec, "pi", thresholds=THRESHOLDS, initial_state=assumed, train_fraction=1
        )
        assert fit.certificate.initial_state == assumed
        if assumed == kind:
            assert fit.model.weights.tolist() == pytest.approx(WEIGHTS, abs=1e-9)
            assert fit.train.rmse_percent < 1e-9
        else:
            assert fit.train.rmse_percent > 0.1


@pytest.mark.parametrize("kind", PATHS)
def test_auto_finds_the_start_state_by_held_out_error(kind):
    fit = dehyst.identify(started(kind), "pi-cumulative", thresholds=THRESHOLDS, train_fraction=1)
    assert fit.certificate.initial_state == kind
    assert fit.train.rmse_percent < 1e-6


@pytest.mark.parametrize("kind", PATHS)
def test_an_unknown_start_is_right_for_every_history(kind):
    fit = dehyst.identify(
        started(kind), "pi", thresholds=THRESHOLDS, initial_state="unknown", train_fraction=1
    )
    assert fit.model.weights.tolist() == pytest.approx(WEIGHTS, abs=1e-9)


@pytest.mark.parametrize("family", ["pi", "pi-cumulative", "modified-pi", "stop"])
def test_samples_before_both_extremes_do_not_count_from_an_unknown_start(family):
    rec = started("rising")
    noisy = rec.output + 0.01 * np.random.default_rng(0).standard_normal(len(rec))
    fit = dehyst.identify(
        dehyst.Recording(input=rec.input, output=noisy), family, initial_state="unknown"
    )
    unknown = ~(fit.train_masks[0] | fit.test_masks[0])
    k = int(np.argmin(unknown))
    assert 60 < k < 130  # up to the first -2, which follows the first +2
    assert unknown[:k].all() and not unknown[k:].any()
    # Poison: any output before, within the range so that the scaling stays, must change nothing.
    poisoned = noisy.copy()
    poisoned[:k] = np.random.default_rng(1).uniform(-1.0, 1.0, k)
    assert noisy[k : len(rec) // 2].min() < -1.0 and noisy[k : len(rec) // 2].max() > 1.0
    # The extremes of the output themselves must lie behind k, or the scale would change with the poison.
    clipped = np.clip(noisy, noisy[k : len(rec) // 2].min(), noisy[k : len(rec) // 2].max())
    fits = [
        dehyst.identify(
            dehyst.Recording(input=rec.input, output=out), family, initial_state="unknown"
        )
        for out in (np.where(unknown, clipped, noisy), poisoned)
    ]
    assert np.array_equal(fits[0].predictions[0], fits[1].predictions[0])
    assert fits[0].train == fits[1].train
    # And the poison is one: a fit that counts them changes.
    zero = [
        dehyst.identify(
            dehyst.Recording(input=rec.input, output=out), family, initial_state="zero"
        ).train.rmse
        for out in (noisy, poisoned)
    ]
    assert zero[1] > 2 * zero[0]


def test_a_break_makes_the_memory_unknown_until_both_extremes_are_visited():
    first, second = started("zero"), started("falling", first=-1.0)
    cut = len(first)
    x = np.concatenate([first.input, second.input])
    y = np.concatenate([first.output, second.output])
    rec = dehyst.Recording(input=x, output=y, breaks=(cut,))
    fit = dehyst.identify(rec, "pi", thresholds=THRESHOLDS, train_fraction=1)
    assert fit.model.weights.tolist() == pytest.approx(WEIGHTS, abs=1e-9)
    counted = fit.train_masks[0]
    assert counted[:cut].all()
    resumed = cut + int(np.argmax(counted[cut:]))
    assert 60 < resumed - cut < 130 and counted[resumed:].all()
    assert [w.code for w in fit.warnings].count("unknown-memory") == 1
    assert f"{resumed - cut} samples" in next(
        w.message for w in fit.warnings if w.code == "unknown-memory"
    )
    # Without the break the same data contradicts itself.
    assert (
        dehyst.identify(
            dehyst.Recording(input=x, output=y), "pi", train_fraction=1
        ).train.rmse_percent
        > 0.1
    )
    # Poison after the break changes nothing.
    poisoned = y.copy()
    poisoned[cut:resumed] = 0.0
    again = dehyst.identify(
        dehyst.Recording(input=x, output=poisoned, breaks=(cut,)),
        "pi",
        thresholds=THRESHOLDS,
        train_fraction=1,
    )
    assert np.array_equal(again.model.weights, fit.model.weights)


def test_predictions_after_a_break_start_from_that_piece_not_from_the_one_before():
    first, second = started("zero"), started("rising", first=-1.0)
    rec = dehyst.Recording(
        input=np.concatenate([first.input, second.input]),
        output=np.concatenate([first.output, second.output]),
        breaks=(len(first),),
    )
    fit = dehyst.identify(rec, "pi", thresholds=THRESHOLDS, train_fraction=1)
    # "rising" is what is assumed after a break; here it is the truth, so even uncounted samples are right.
    assert np.abs(fit.predictions[0] - rec.output).max() < 1e-8


@pytest.mark.parametrize("family", ["pi", "pi-cumulative", "modified-pi", "stop"])
@pytest.mark.parametrize("kind", ["zero", "rest", "rising", "falling", "unknown"])
def test_the_model_starts_where_the_log_starts(family, kind, tmp_path):
    rec = started("falling")
    noisy = dehyst.Recording(
        input=rec.input,
        output=rec.output + 0.01 * np.random.default_rng(0).standard_normal(len(rec)),
    )
    fit = dehyst.identify(noisy, family, initial_state=kind)
    assert np.array_equal(fit.model.simulate(noisy.input), fit.predictions[0])
    file = fit.model.save(tmp_path / "model.json")
    assert np.array_equal(dehyst.load(file).simulate(noisy.input), fit.predictions[0])


def test_memory_that_is_unknown_throughout_is_refused_with_the_way_out():
    x = np.concatenate(
        [loops((1.0,), 50), np.linspace(-1.0, 0.0, 20), loops((0.5, 0.5, 0.5, 0.5), 50)]
    )
    rec = dehyst.Recording(input=x + 0.5 * x**3, output=x, breaks=(10,))
    with pytest.raises(ExcitationError, match="--train-fraction"):
        dehyst.identify(
            dehyst.Recording(input=x, output=x), initial_state="unknown", train_fraction=0.05
        )
    assert dehyst.identify(rec, "pi", train_fraction=1).train.rmse_percent < 20.0
