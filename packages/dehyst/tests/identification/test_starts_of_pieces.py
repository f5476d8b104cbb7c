"""Starts of short pieces that begin anywhere are estimated, where that explains pieces that are not fitted better."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import dehyst
from dehyst.errors import ParameterError
from dehyst.identification._candidates import literature

Array = npt.NDArray[np.float64]
SAMPLES = 150


def motion(seed: int, size: int) -> Array:
    """Random strokes about a centre that wanders, so that most pieces see a part of the range."""
    rng = np.random.default_rng(seed)
    tips, at = [0.0], [0]
    while at[-1] < size:
        centre = 0.6 * np.sin(at[-1] / 700.0)
        tips.append(float(np.clip(centre + rng.normal(0.0, 0.35), -1.0, 1.0)))
        at.append(at[-1] + int(rng.integers(20, 60)))
    return np.interp(np.arange(size), at, tips)


def bouc_wen(x: Array) -> Array:
    """Bouc-Wen beside a hardening spring: no sum of plays."""
    z, y = 0.0, np.empty(x.size)
    for k in range(x.size):
        move = (x[k] - x[k - 1]) / 20.0 if k else 0.0
        for _ in range(20):
            z += move * 6.0 - 4.0 * abs(move) * abs(z) ** 0.5 * z - 2.0 * move * abs(z) ** 1.5
        y[k] = z + 0.8 * x[k] + 0.5 * x[k] ** 3
    return y


def pieces(count: int = 40) -> list[dehyst.Recording]:
    """Pieces between which the way of three others was lost, noise of 0.1 % of the range."""
    x = motion(0, 4 * count * SAMPLES)
    y = bouc_wen(x)
    y += 1e-3 * float(np.ptp(y)) * np.random.default_rng(0).normal(size=y.size)
    logged = []
    for k in range(count):
        part = slice((4 * k + 3) * SAMPLES, (4 * k + 4) * SAMPLES)
        logged.append(dehyst.Recording(input=x[part], output=y[part]))
    return logged


def error(model: dehyst.models.HysteresisModel, logged: list[dehyst.Recording]) -> float:
    """Error of what follows the first third of each piece, rms."""
    misses = []
    for piece in logged:
        first = SAMPLES // 3
        after = model.after(piece.input[:first], piece.output[:first])
        misses.append(after.simulate(piece.input[first:]) - piece.output[first:])
    return float(np.sqrt(np.mean(np.concatenate(misses) ** 2)))


@pytest.mark.slow
def test_pieces_that_were_not_fitted_are_explained_better_and_the_verdict_says_why(monkeypatch):
    logged = pieces()
    fit = dehyst.identify(logged[::2], "stop-sum", train_fraction=1.0)
    monkeypatch.setattr(literature, "with_starts", lambda *_: None)
    without = dehyst.identify(logged[::2], "stop-sum", train_fraction=1.0)
    assert error(fit.model, logged[1::2]) < 0.9 * error(without.model, logged[1::2])
    assert fit.settings["starts"] == 20
    assert "starts" not in without.settings


@pytest.mark.slow
def test_held_out_pieces_are_tested_from_the_start_that_their_first_third_tells():
    fit = dehyst.identify(pieces(), "stop-sum")
    assert "(starts of 40 pieces were estimated)" in fit.verdict
    assert fit.test is not None
    assert fit.test.rmse_percent < 1.5
    held_out = fit.settings["held_out"]
    tested = sum(int(fit.test_masks[k].sum()) for k in held_out)
    # A third of a piece tells its start, and is no test.
    assert tested == len(held_out) * (SAMPLES - round(0.33 * SAMPLES))


@pytest.mark.slow
def test_pieces_of_one_recording_that_breaks_off_are_started_too():
    logged = pieces(24)
    x = np.concatenate([piece.input for piece in logged])
    y = np.concatenate([piece.output for piece in logged])
    breaks = tuple(range(SAMPLES, x.size, SAMPLES))
    record = dehyst.Recording(input=x, output=y, breaks=breaks)
    fit = dehyst.identify(record, "stop-sum")
    assert fit.settings["starts"] == 24
    assert fit.test is not None
    assert fit.test.rmse_percent < 3.0


def test_a_log_with_few_pieces_is_identified_as_before():
    x = motion(1, 3000)
    fit = dehyst.identify(dehyst.Recording(input=x, output=bouc_wen(x)), "stop-sum")
    assert "starts" not in fit.settings
    assert "starts" not in fit.verdict


def test_relative_errors_let_small_loops_count_as_much_as_large_ones():
    large = motion(2, 1500)
    small = 0.05 * motion(3, 1500)
    # The gain about the middle is another one: what fits the large loops misses the small ones.
    records = []
    for x in (large, small):
        plays = dehyst.PrandtlIshlinskii([0.0, 0.2], [1.0, 0.6]).simulate(x)
        records.append(dehyst.Recording(input=x, output=plays + 0.3 * np.tanh(40.0 * x)))
    misses = []
    for relative in (False, True):
        fit = dehyst.identify(records, "play-sum", train_fraction=1.0, relative=relative)
        miss = fit.predictions[1] - records[1].output
        misses.append(float(np.sqrt(np.mean(miss**2))))
    assert misses[1] < 0.9 * misses[0]


def test_relative_errors_are_for_sums_of_elements():
    x = motion(2, 300)
    with pytest.raises(ParameterError, match="relative"):
        dehyst.identify(dehyst.Recording(input=x, output=x), "pi", relative=True)
