"""False values in a Recording, whoever built it: found, named, left out; the model is that of the clean data."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import dehyst
from dehyst.data import find_outliers, robust_range
from dehyst.errors import RecordingError
from dehyst.identification import mended

Array = npt.NDArray[np.float64]
N = 2400
NOISE = np.random.default_rng(7).normal(0.0, 0.05, N)
TRUTH = dehyst.PrandtlIshlinskii([0.0, 0.3, 0.7, 1.2], [4.0, 3.0, 2.0, 2.0])


def rig() -> tuple[Array, Array, Array]:
    """Input in bar, output in degrees with noise and without: loops of three sizes, again and again."""
    t = np.linspace(0.0, 12.0, N)
    x = (2.0 + 0.8 * np.sin(2 * np.pi * t / 6)) * np.sin(2 * np.pi * t)
    y = TRUTH.simulate(x)
    return x, y + NOISE, y


def true_error(model: dehyst.models.HysteresisModel) -> float:
    """Against the truth, on loops that nothing was fitted to."""
    x = 2.6 * np.sin(np.linspace(0.0, 30.0, 3000)) * np.linspace(1.0, 0.2, 3000)
    gap = model.simulate(x) - TRUTH.simulate(x)
    return float(np.sqrt(np.mean(gap**2)))


X, Y, CLEAN = rig()
BEST = dehyst.identify(dehyst.Recording(input=X, output=Y), "pi", n=40)


@pytest.mark.spread(18)
@pytest.mark.parametrize("where", [0, 1, 4, 700, 1000, 1199, 1201, N - 5, N - 1])
@pytest.mark.parametrize(
    ("length", "value"), [(1, 1000.0), (1, -1e6), (2, 85.0), (5, 85.0), (5, -300.0), (20, 400.0)]
)
@pytest.mark.parametrize("signal", ["input", "output"])
def test_false_values_leave_the_model_as_it_was(
    signal: str, length: int, value: float, where: int
) -> None:
    if length > 5 and not 20 < where < N - 25:
        pytest.skip("a log that begins or ends with many such values may have begun or ended there")
    signals = {"input": X.copy(), "output": Y.copy()}
    begin = min(where, N - length)
    signals[signal][begin : begin + length] = value
    fit = dehyst.identify(dehyst.Recording(**signals), "pi", n=40)
    [found] = [finding for finding in fit.warnings if finding.code == "outlier"]
    assert f"{length} of {N} samples" in found.message and f"{value:.6g} in sample" in found.message
    assert fit.recordings[0].left_out == tuple(range(begin, begin + length))
    assert true_error(fit.model) < 1.5 * true_error(BEST.model)
    assert fit.test is not None and BEST.test is not None
    assert fit.test.rmse_percent == pytest.approx(BEST.test.rmse_percent, rel=0.05)
    assert fit.test.max < 0.5  # none of them is in the score
    assert fit.predictions[0].shape == (N,)  # and the samples keep their places
    assert fit.model.card.output.high < 40.0


def random_values(rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Some false samples: single ones, runs of one value or of many, in either signal."""
    signals = [X.copy(), Y.copy()]
    bad = np.zeros(N, dtype=bool)
    for _ in range(int(rng.integers(1, 4))):
        length, k = int(rng.choice([1, 2, 5])), int(rng.integers(0, 2))
        begin = int(rng.integers(0, N - length))
        size = float(rng.choice([3.0, 30.0, 1e4]))
        values = size * (1.0 + (0.0 if rng.integers(0, 2) else 0.4) * rng.random(length))
        signals[k][begin : begin + length] = rng.choice([-1.0, 1.0]) * np.ptp(signals[k]) * values
        bad[begin : begin + length] = True
    return signals[0], signals[1], bad


@pytest.mark.spread(8)
@pytest.mark.parametrize("seed", range(30))
def test_random_false_values_are_left_out_or_named(seed: int) -> None:
    x, y, bad = random_values(np.random.default_rng(seed))
    fit = dehyst.identify(dehyst.Recording(input=x, output=y), "pi", n=40)
    assert set(np.flatnonzero(bad)) <= set(fit.recordings[0].left_out)
    assert true_error(fit.model) < 1.5 * true_error(BEST.model)


def legitimate(rng: np.random.Generator) -> Array:
    """Signals that are what they are: drives, references, switched and held ones, with noise or without."""
    n = int(rng.choice([200, 500, 2000, 8000]))
    cycles = float(rng.uniform(2, 30))
    phase = np.linspace(0.0, cycles, n) + rng.uniform()
    corners = rng.uniform(-1.0, 1.0, int(cycles) + 2)
    base = [
        np.sin(2 * np.pi * phase),
        2.0 * np.abs(2.0 * (phase % 1.0) - 1.0) - 1.0,
        np.sin(2 * np.pi * phase) * np.linspace(1.0, 0.1, n),
        np.interp(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, corners.size), corners),
        np.clip(1.5 * np.sin(2 * np.pi * phase), -1.0, 1.0),
    ][int(rng.integers(0, 5))]
    hold = int(rng.integers(5, 80))
    slip = base.copy()
    for k in range(1, n):
        slip[k] = slip[k - 1] if abs(base[k] - slip[k - 1]) < 0.3 else base[k]
    pulses = np.arange(n) % int(rng.integers(20, 400)) < rng.integers(2, 40)
    kinds = [
        base,
        np.round(base * rng.integers(4, 60)),
        np.repeat(base[::hold], hold)[:n],
        np.sign(base),
        base + rng.uniform(0.2, 2.0) * pulses,
        np.sign(base) * rng.uniform(0.2, 3.0) + base,
        np.where(np.arange(n) < n * rng.uniform(0.01, 0.3), 0.0, base + rng.uniform(-2.0, 2.0)),
        slip,
    ]
    noise = float(rng.choice([0.0, 1e-3, 1e-2, 0.05])) * rng.normal(size=n)
    return np.asarray((kinds[int(rng.integers(0, len(kinds)))] + noise) * 10 ** rng.uniform(-3, 3))


@pytest.mark.spread(5)
@pytest.mark.parametrize("seed", range(20))
def test_no_signal_of_a_rig_has_outliers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(25):
        assert not find_outliers(legitimate(rng)).any()


def test_a_clean_recording_is_handed_through_as_it_is() -> None:
    rec = dehyst.Recording(input=X, output=Y)
    assert mended(rec) is rec


def test_what_a_signal_does_across_a_break_is_no_jump() -> None:
    x, y = np.tile(X[:600], 4), np.tile(Y[:600], 4)
    y[600:605] += 300.0
    rec = mended(dehyst.Recording(input=x, output=y, breaks=(600, 605, 1200)))
    assert rec.left_out == ()


@pytest.mark.parametrize("family", ["direct-inverse", "modified-pi"])
def test_other_models_leave_them_out_as_well(family: str) -> None:
    y = Y.copy()
    y[1000:1005] = 85.0
    clean, spoiled = (dehyst.identify(dehyst.Recording(input=X, output=v), family) for v in (Y, y))
    assert spoiled.test.rmse_percent == pytest.approx(clean.test.rmse_percent, rel=0.1)


@pytest.mark.slow
def test_families_and_their_comparison_leave_them_out_as_well() -> None:
    y = Y.copy()
    y[1000:1005] = 85.0
    clean, spoiled = (
        dehyst.identify(dehyst.Recording(input=X, output=v), "preisach") for v in (Y, y)
    )
    assert clean.test is not None and spoiled.test is not None
    assert spoiled.test.rmse == pytest.approx(clean.test.rmse, rel=0.1)


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("seed", range(5))
def test_a_few_samples_do_not_make_the_range(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    y = Y.copy()
    y[rng.integers(0, N, count)] = rng.uniform(80, 1e6, count)
    assert np.ptp(Y) * 0.97 < robust_range([y]) <= np.ptp(Y)
    y = Y.copy()
    begin = int(rng.integers(0, N - count))
    y[begin : begin + count] = 1e9
    assert np.ptp(Y) * 0.97 < robust_range([y]) <= np.ptp(Y)


def test_the_range_of_a_clean_signal_is_from_its_least_to_its_largest_value() -> None:
    for signal in (
        X,
        Y,
        np.sign(X),
        X * np.linspace(1.0, 0.1, N),
        np.round(X),
        np.arange(5.0),
        X[:300],
    ):
        assert robust_range([signal]) == np.ptp(signal)
    assert robust_range([np.array([]), X, Y]) == np.ptp(np.concatenate([X, Y]))


def test_the_range_of_a_signal_that_rests_is_that_of_its_motion() -> None:
    y = 0.001 * np.random.default_rng(0).normal(size=100_000)
    y[500:560] += np.sin(np.linspace(0.0, np.pi, 60))
    assert 0.97 < robust_range([y]) < 1.02


def test_an_outlier_is_left_out_whatever_left_out_says_already() -> None:
    y = Y.copy()
    y[1000] = 1000.0
    rec = mended(dehyst.Recording(input=X, output=y, left_out=[3, 1]))
    assert rec.left_out == (1, 3, 1000)
    with pytest.raises(RecordingError, match="indices from 0"):
        dehyst.Recording(input=X, output=y, left_out=[N])
