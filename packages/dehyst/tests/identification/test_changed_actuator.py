"""An actuator that becomes another one while it is logged: told, placed, left out; a sound one never is."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import dehyst
from dehyst.identification._mending import changed_at

Array = npt.NDArray[np.float64]
N = 9600
K = np.arange(N)
CYCLE = 2 * np.pi * K / 600
SIZES = np.array([1.0, 0.6, 0.85, 0.3])
X = 4.0 * SIZES[(K // 600) % 4] * np.sin(CYCLE)
TRUTH = dehyst.PrandtlIshlinskii([0.0, 0.2, 0.5, 1.0, 2.0, 3.0], [3.0, 1.2, 1.0, 0.9, 0.5, 0.6])
NOISE = 0.05 * np.random.default_rng(3).standard_normal(N)
Y = TRUTH.simulate(X) + NOISE

CHANGES = {
    "jams": lambda y: np.clip(y, -5.0, 5.0),
    "jams on one side": lambda y: np.minimum(y, 0.0),
    "is half as strong": lambda y: 0.5 * y,
    "is stronger": lambda y: 1.6 * y,
    "is set anew": lambda y: y + 12.0,
    "turns about": lambda y: -y,
}


@pytest.mark.slow
@pytest.mark.parametrize("at", [2000, 4150, 6000, 7000])
@pytest.mark.parametrize("what", CHANGES)
def test_a_change_is_placed_said_and_left_out(what: str, at: int) -> None:
    y = np.concatenate([Y[:at], CHANGES[what](Y)[at:]])
    fit = dehyst.identify(dehyst.Recording(input=X, output=y, time=0.02 * K), "auto")
    codes = {finding.code for finding in fit.warnings}
    [found] = [finding for finding in fit.warnings if finding.code == "two-actuators"]
    change = changed_at(X, y)
    assert change is not None and at - 1200 <= change.begin <= at <= change.place + 1 <= at + 700
    assert f"sample {change.place} (t = {0.02 * change.place:.6g} s)" in found.message
    assert (
        f"{N - change.begin} samples from sample {change.begin} (t = {0.02 * change.begin:.6g} s) on"
        in found.message
    )
    assert fit.recordings[0].left_out == tuple(range(change.begin, N))
    assert not codes & {"static-as-good", "poor-fit"}
    assert "do not compensate with it" in fit.verdict
    assert fit.test is not None and fit.test.rmse_percent < 1.0


def healthy(seed: int) -> tuple[str, Array, Array]:
    rng = np.random.default_rng(seed)
    size = {
        "varied": rng.uniform(0.2, 1.0, N // 300 + 1)[K // 300],
        "growing": 0.1 + 0.9 * K / N,
        "decaying": 1.0 - 0.9 * K / N,
        "small, then wide": np.where(K < N // 2, 0.3, 1.0),
        "wide, then small": np.where(K < N // 2, 1.0, 0.25),
    }
    motion = list(size)[seed % 5]
    x = size[motion] * np.sin(2 * np.pi * K / 300) + (seed % 3 == 0) * 0.4 * np.sin(
        2 * np.pi * K / 4700
    )
    count = int(rng.integers(4, 12))
    rig = dehyst.PrandtlIshlinskii(
        [0.0, *np.sort(rng.uniform(0.02, 0.9, count - 1))], rng.uniform(0.1, 1.0, count)
    )
    y = rig.simulate(x)
    span = float(np.ptp(y))
    fault = ["none", "drift", "creep", "curve", "noise", "rate", "saturates", "warms up"][
        seed // 5 % 8
    ]
    if fault == "drift":
        y = y + 0.3 * span * K / N
    elif fault == "creep":
        slow = np.convolve(x, np.exp(-np.arange(2000) / 400.0) / 400.0)[:N]
        y = y + 0.2 * span * slow
    elif fault == "curve":
        y = span * np.tanh(2.0 * y / span) + 0.2 * y**2 / span
    elif fault == "rate":
        y = y + 0.1 * span * np.gradient(x) * 50.0
    elif fault == "saturates":
        y = np.clip(y, np.quantile(y, 0.2), np.quantile(y, 0.9))
    elif fault == "warms up":
        y = y * (1.0 - 0.3 * np.exp(-K / 1500.0))
    noise = 0.03 if fault == "noise" else 0.003
    return f"{motion}, {fault}", x, y + noise * span * rng.standard_normal(N)


@pytest.mark.slow
def test_no_change_is_seen_where_none_is() -> None:
    false = [name for name, x, y in map(healthy, range(160)) if changed_at(x, y) is not None]
    assert false == []
    assert changed_at(X, Y) is None


def test_a_change_that_passes_or_a_faster_motion_is_none() -> None:
    assert changed_at(X, np.where((K >= 3000) & (K < 4800), 0.5 * Y, Y)) is None
    x = np.sin(np.where(K < N // 2, CYCLE, 4.0 * CYCLE))
    assert changed_at(x, x + 0.5 * np.gradient(x) * 100.0) is None


def test_a_change_needs_two_whole_cycles_before_it() -> None:
    x = np.sin(2 * np.pi * np.arange(3000) / 200)
    found = {
        cycles: changed_at(x, np.where(np.arange(3000) < 200 * cycles, 2 * x, x))
        for cycles in (1, 1.5, 2, 2.5, 5)
    }
    assert [cycles for cycles, change in found.items() if change is not None] == [2.5, 5]
