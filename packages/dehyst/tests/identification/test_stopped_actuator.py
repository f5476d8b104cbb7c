"""An actuator that breaks while it is logged: said, left out; a log of two actuators is refused for compensation."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import dehyst
from dehyst.identification._mending import stopped_at

Array = npt.NDArray[np.float64]
N = 6000
K = np.arange(N)
TRUTH = dehyst.PrandtlIshlinskii([0.0, 0.3, 0.7], [4.0, 3.0, 2.0])
X = (2.0 + 0.5 * np.sin(K / 300)) * np.sin(2 * np.pi * K / 100)
NOISE = 0.03 * np.random.default_rng(5).normal(size=N)
Y = TRUTH.simulate(X) + NOISE


def true_error(model: dehyst.models.HysteresisModel) -> float:
    x = 2.4 * np.sin(np.linspace(0.0, 30.0, 3000)) * np.linspace(1.0, 0.2, 3000)
    gap = model.simulate(x) - TRUTH.simulate(x)
    return float(np.sqrt(np.mean(gap**2)))


def broken(at: int, fall: int, rest: float) -> Array:
    """Output that falls from its place to an end stop, within some samples, and stays there."""
    share = np.clip((K - at) / fall, 0.0, 1.0)
    return (Y - NOISE) * (1.0 - share) + share * rest + NOISE


BEST = dehyst.identify(dehyst.Recording(input=X, output=Y), "pi", n=40)


@pytest.mark.spread(10)
@pytest.mark.parametrize("at", [1000, 1950, 2030, 3000, 4400, 5600])
@pytest.mark.parametrize("fall", [1, 60])
@pytest.mark.parametrize("rest", [-25.0, 0.0, 14.0])
def test_what_follows_a_break_is_left_out_and_said(at: int, fall: int, rest: float) -> None:
    y = broken(at, fall, rest)
    fit = dehyst.identify(
        dehyst.Recording(input=X, output=y, time=0.01 * K, output_unit="deg"), "pi", n=40
    )
    [found] = [finding for finding in fit.warnings if finding.code == "output-stopped"]
    first = fit.recordings[0].left_out[0]
    assert fit.recordings[0].left_out == tuple(range(first, N)) and at - 200 <= first <= at
    assert f"sample {first} (t = {0.01 * first:.6g} s)" in found.message
    assert fit.test is not None and fit.train_masks[0].sum() == pytest.approx(first / 2, abs=2)
    assert not (fit.train_masks[0] | fit.test_masks[0])[first:].any()
    assert true_error(fit.model) < 1.5 * true_error(BEST.model) + 0.002
    assert "good for compensation" not in fit.verdict


@pytest.mark.parametrize("family", ["direct-inverse", "modified-pi"])
def test_other_models_leave_it_out_as_well(family: str) -> None:
    fit = dehyst.identify(
        dehyst.Recording(input=X, output=broken(4400, 20, -25.0), time=0.01 * K), family
    )
    assert fit.test is not None and fit.test.rmse_percent < 1.0


DEAD = np.where(K < 4000, X, 1.5 + 0.9 * np.sin(K / 20))
SOUND = {
    "cycles": (X, Y),
    "rests at the end": (np.where(K < 4000, X, X[4000]), TRUTH.simulate(np.where(K < 4000, X, X[4000]))),
    "small loops at the end": (X * np.where(K < 4000, 1.0, 0.05), TRUTH.simulate(X * np.where(K < 4000, 1.0, 0.05))),
    "saturated": (X, np.minimum(Y, 3.0)),
    "works in its dead zone at the end": (DEAD, np.minimum(DEAD, 0.5)),
    "dead from the beginning": (X, NOISE),
    "noise": (X, np.random.default_rng(0).normal(size=N)),
    "creeps": (X, Y + K / 300),
}  # fmt: skip


@pytest.mark.parametrize("name", SOUND)
def test_an_actuator_that_works_did_not_stop(name: str) -> None:
    assert stopped_at(*SOUND[name]) is None


def test_a_model_of_two_actuators_is_not_to_be_used() -> None:
    y = np.where(K < 3000, Y, 0.3 * Y + 12.0)
    fit = dehyst.identify(dehyst.Recording(input=X, output=y), "pi", n=40)
    assert "two-actuators" in {finding.code for finding in fit.warnings}
    assert "do not compensate with it" in fit.verdict


def test_a_model_whose_inverse_amplifies_anything_is_not_to_be_used() -> None:
    y = dehyst.PrandtlIshlinskii([0.0, 0.8], [1e-9, 3.0]).simulate(X)
    fit = dehyst.identify(dehyst.Recording(input=X, output=y), "pi", n=40, eps=1e-8)
    assert "inverse-useless" in {finding.code for finding in fit.warnings}
    assert "do not compensate with it" in fit.verdict
