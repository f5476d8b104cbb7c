"""Long logs are made ready as short ones are: false values, a broken actuator, a clock set to and fro."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import dehyst
from dehyst.identification.fit import Fit

Array = npt.NDArray[np.float64]
TRUTH = dehyst.PrandtlIshlinskii(np.arange(10) * 0.2, [3.0, 1.0, 1.0, 0.6, 0.5, 0.4, 0.3, 0.2, 0.2, 0.2])


class Rig:
    name, input_name, output_name = "rig", "pressure", "angle"

    def __init__(self, x: Array, y: Array, time: Array | None = None, costly: bool = False) -> None:
        self.x, self.y, self.time, self.costly, self.passes = x, y, time, costly, 0

    def __iter__(self) -> Iterator[tuple[Array | None, Array, Array]]:
        self.passes += 1
        for k in range(0, self.x.size, 7001):
            part = slice(k, k + 7001)
            yield None if self.time is None else self.time[part], self.x[part], self.y[part]


def loops(samples: int, period: int) -> tuple[Array, Array]:
    k = np.arange(samples)
    x = 2.0 * np.sin(2 * np.pi * k / period) * (0.7 + 0.3 * np.sin(k / period / 3))
    return x, TRUTH.simulate(x) + 0.01 * np.random.default_rng(0).standard_normal(samples)


def said(fit: Fit, code: str) -> str:
    return " ".join(finding.message for finding in fit.warnings if finding.code == code)


def identified(rig: Any) -> Fit:
    return dehyst.identify_stream(rig, "pi", n=20)


SIZES = [(20_000, 200), (300_000, 300)]  # every sample is kept of the first, one in eight or so of the second


@pytest.mark.parametrize(("samples", "period"), SIZES)
@pytest.mark.parametrize("costly", [False, True])
def test_false_values_are_left_out_and_said(samples: int, period: int, costly: bool) -> None:
    x, y = loops(samples, period)
    clean = identified(Rig(x, y))
    assert not said(clean, "outlier") and clean.test is not None
    spoiled, coded = y.copy(), x.copy()
    spoiled[samples // 4 : samples // 4 + 2] = 200.0
    coded[samples // 3] = -9999.0
    fit = identified(Rig(coded, spoiled, costly=costly))
    assert fit.recordings[0].samples == samples - 3
    assert "3 samples of rig" in said(fit, "outlier") and "'angle' above" in said(fit, "outlier")
    assert fit.test is not None and fit.test.rmse == pytest.approx(clean.test.rmse, rel=0.01)


@pytest.mark.parametrize(("samples", "period"), SIZES)
def test_the_one_wide_loop_of_a_log_is_no_false_value(samples: int, period: int) -> None:
    x, _ = loops(samples, period)
    x *= 0.2
    x[samples // 2 : samples // 2 + period] = 1.9 * np.sin(2 * np.pi * np.arange(period) / period)
    fit = identified(Rig(x, TRUTH.simulate(x)))
    assert fit.recordings[0].samples == samples and not said(fit, "outlier")


@pytest.mark.parametrize(("samples", "period"), SIZES)
def test_what_follows_the_end_of_the_actuator_is_left_out_and_said(samples: int, period: int) -> None:
    x, y = loops(samples, period)
    y[samples * 2 // 3 :] = -14.0
    fit = identified(Rig(x, y))
    kept = fit.recordings[0].samples
    assert samples * 2 // 3 - 3 * period < kept <= samples * 2 // 3
    message = said(fit, "output-stopped")
    assert f"from sample {samples * 2 // 3}" in message and f"from sample {kept}" in message
    assert f"The {samples - kept} samples" in message and f"of {samples}" in message
    assert fit.test is not None and fit.test.rmse < 0.03


@pytest.mark.slow
def test_a_clock_that_is_set_to_and_fro_is_no_break() -> None:
    x, y = loops(60_000, 300)
    time = 0.01 * np.arange(60_000)
    clean = identified(Rig(x, y, time))
    jumping = time.copy()
    for begin, end, jump in ((10_000, 10_004, 1.0), (33_000, 33_020, -0.7), (50_000, 50_003, 1.0)):
        jumping[begin:end] += jump
    fit = identified(Rig(x, y, jumping))
    assert fit.recordings[0].breaks == () and fit.as_dict()["test"] == clean.as_dict()["test"]
    assert "10000 (+1 s), 10004 (-1 s)" in said(fit, "clock-jump") and not said(fit, "clock-restart")
    assert fit.recordings[0].time is not None and clean.recordings[0].time is not None
    np.testing.assert_allclose(fit.recordings[0].time, clean.recordings[0].time, atol=1e-9)


def test_a_clock_that_jumps_with_the_signals_or_once_stays_a_break() -> None:
    x, y = loops(60_000, 300)
    time = 0.01 * np.arange(60_000) - 100.0 * (np.arange(60_000) >= 30_000)
    once = identified(Rig(x, y, time))
    assert len(once.recordings[0].breaks) == 1 and "or the clock was set" in said(once, "clock-restart")
    shifted = x.copy()
    shifted[30_000:30_010] += 1.0
    time = 0.01 * np.arange(60_000)
    time[30_000:30_010] += 5.0
    apart = identified(Rig(shifted, y, time))
    assert apart.recordings[0].breaks and not said(apart, "clock-jump")
