"""Outliers and wrapped angles: numbers that are no measurements are named and left out; signals are left alone."""

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from dehyst.data import find_outliers
from dehyst.data._outliers import _certain_range
from dehyst.io import read_log, read_signal, read_table, write_csv
from dehyst.io._columns import count_runs, select_run
from places import DATA

REAL = DATA
N = 2000
T = np.arange(N) * 0.01
X = 3.0 * np.sin(2 * np.pi * T / 2)
Y = 20.0 * np.sin(2 * np.pi * T / 2 - 0.2)
NOISE = np.random.default_rng(1).normal(size=20000)
Array = npt.NDArray[np.float64]


def write(path, x=X, y=Y, names=("p_bar", "angle_deg")):
    return write_csv(path / "log.csv", {"time_s": T[: x.size], names[0]: x, names[1]: y})


@pytest.mark.parametrize("value", [100.0, 6.5, -1e6, 32767.0])
@pytest.mark.parametrize("column", ["p_bar", "angle_deg"])
@pytest.mark.parametrize("length", [1, 3])
def test_a_spike_drops_its_rows_and_is_named(tmp_path, value, column, length):
    signals = {"p_bar": X.copy(), "angle_deg": Y / 8}
    signals[column] = signals[column].copy()
    signals[column][500 : 500 + length] = value
    rec = read_log(write(tmp_path, *signals.values()), "p", "angle")
    [finding] = rec.findings
    assert finding.code == "outlier"
    assert f"'{column}' is {value:.6g} in line" in finding.message
    assert " 502" in finding.message
    np.testing.assert_allclose(rec.input, np.delete(X, np.s_[500 : 500 + length]), atol=1e-9)
    assert rec.breaks == ()


@pytest.mark.parametrize("code", [-9999.0, 9999.0, 1e6, 32767.0, -999.0])
def test_codes_of_a_failed_sensor_are_dropped_at_any_length(tmp_path, code):
    y = Y.copy()
    bad = np.r_[0:2, 300, 700:704, 1200:1260, N - 1]
    y[bad] = code
    rec = read_log(write(tmp_path, y=y), "p", "angle")
    np.testing.assert_allclose(rec.output, np.delete(Y, bad), atol=1e-9)
    assert rec.findings[0].code == "outlier"
    assert "68 of 2000 rows" in rec.findings[0].message


def test_a_small_spike_is_found_beside_large_ones():
    v = X.copy()
    v[[300, 900, 1500]] = [1e6, -50.0, 9.0]
    assert np.flatnonzero(find_outliers(v)).tolist() == [300, 900, 1500]


def test_a_coarse_converter_does_not_hide_a_spike():
    v = np.round(2 * X)
    v[300] = 100.0
    v[800:850] = -9999.0
    assert np.flatnonzero(find_outliers(v)).tolist() == [300, *range(800, 850)]


def stick_slip():
    """Drive a block through a spring: it sticks until the force is large, then slips at once."""
    place, places = 0.0, []
    for drive in 10 * np.sin(T / 2):
        place = drive - np.sign(drive - place) * 0.1 if abs(drive - place) > 2 else place
        places.append(place)
    return np.array(places)


PERIOD = np.arange(20000) / 20000
SIGNALS = {
    "white noise": NOISE,
    "heavy noise": np.random.default_rng(2).laplace(size=20000),
    "few samples of noise": NOISE[:30],
    "random walk": np.cumsum(NOISE),
    "square wave": np.sign(np.sin(60 * PERIOD)),
    "noisy slow square wave": np.sign(np.sin(7 * PERIOD)) * 50 + 0.01 * NOISE,
    "one step": np.where(PERIOD > 0.5, 100.0, 0.0) + 0.01 * NOISE,
    "staircase": np.floor(10 * PERIOD) * 1e6,
    "pulses": np.where(np.arange(20000) % 1000 < 10, 24.0, 0.0) + 0.01 * NOISE,
    "single pulses without noise": np.where(np.arange(20000) % 5000 == 7, 24.0, 0.0),
    "stick-slip": stick_slip(),
    "sawtooth": 500 * PERIOD % 1.0,
    "triangle": np.abs(5 * PERIOD % 2 - 1),
    "fast sine": np.sin(np.arange(300) * 2.0),
    "codes within the range": np.round(20000 * PERIOD),
    "converter": np.round(4 * np.sin(20 * PERIOD)),
    "two levels, one like a code": np.where(np.sin(60 * PERIOD) > 0.9, 9999.0, 0.0),
    "cusps": np.sqrt(np.abs(np.sin(20 * PERIOD))),
    "constant": np.full(100, 5.0),
    "nothing": np.zeros(0),
    "three samples": np.array([0.0, 9999.0, 0.0]),
}


def test_a_signal_has_no_outliers():
    assert [name for name, values in SIGNALS.items() if find_outliers(values).any()] == []


@pytest.mark.parametrize(
    "folder",
    [
        "tendon_sheath_joint",
        "piezo_dbo",
        "pneumatic_arm_segment",
        "cavatappi_muscle",
        "pam_wrist_joint",
        "mr_damper",
    ],
)
def test_no_column_of_a_measured_log_has_outliers(folder):
    file = REAL / folder / "data.csv.gz"
    if not file.exists():
        pytest.skip("measured logs are not at hand (shared/data beside the project)")
    table = read_table(file)
    seen = 0
    for run in count_runs(table) or [None]:
        mask = select_run(table, run)[1]
        for values in table.columns.values():
            part = values[mask]
            part = part[np.isfinite(part)]
            seen += part.size
            assert not find_outliers(part).any()
    assert seen > 500


@pytest.mark.parametrize(
    ("unit", "turn", "low"),
    [("deg", 360.0, 0.0), ("deg", 360.0, -180.0), ("rad", 2 * np.pi, -np.pi)],
)
def test_an_angle_that_wraps_is_unwrapped(tmp_path, unit, turn, low):
    angle = turn * (0.9 + 0.4 * np.sin(T)) + low
    wrapped = (angle - low) % turn + low
    crossed = int(np.sum(np.abs(np.diff(wrapped)) > turn / 2))
    assert crossed > 4
    rec = read_log(write(tmp_path, y=wrapped, names=("p_bar", f"angle_{unit}")), "p", "angle")
    np.testing.assert_allclose(rec.output - rec.output[0], angle - angle[0], atol=1e-8)
    [finding] = rec.findings
    assert finding.code == "angle-wrap"
    first = int(np.flatnonzero(np.abs(np.diff(wrapped)) > turn / 2)[0]) + 3
    assert f"{crossed} times, at lines {first}, " in finding.message


def test_an_angle_that_jumps_by_itself_is_not_unwrapped(tmp_path):
    square = np.where(np.sin(T) > 0, 355.0, 2.0) + np.sin(20 * T)
    rec = read_log(write(tmp_path, y=square), "p", "angle")
    np.testing.assert_allclose(rec.output, square, atol=1e-9)
    pressure = (100 * T) % 360
    rec = read_log(write(tmp_path, x=pressure), "p", "angle")
    assert "angle-wrap" not in [finding.code for finding in rec.findings]


def test_a_wrap_and_an_outlier_are_both_cured(tmp_path):
    angle = 360 * (0.9 + 0.4 * np.sin(T))
    wrapped = angle % 360
    wrapped[77] = -9999.0
    rec = read_log(write(tmp_path, y=wrapped), "p", "angle")
    np.testing.assert_allclose(rec.output, np.delete(angle, 77), atol=1e-8)
    assert sorted(finding.code for finding in rec.findings) == ["angle-wrap", "outlier"]


def test_faults_outside_the_window_do_not_matter(tmp_path):
    y = Y.copy()
    y[10] = 1e5
    file = write(tmp_path, y=y)
    assert read_log(file, "p", "angle", start=1.0).findings == ()
    assert [f.code for f in read_signal(file, "angle").findings] == ["outlier"]


@given(
    hnp.arrays(np.float64, st.integers(32, 300), elements=st.floats(-1e6, 1e6)), st.integers(1, 40)
)
def test_the_range_found_by_counting_is_no_more_than_that_of_the_quantiles(values, levels):
    for v in (values, np.round(values / 1e6 * levels)):
        low, high = np.percentile(v, [2, 98])
        assert _certain_range(v) <= (high - low) * (1 + 1e-12)
