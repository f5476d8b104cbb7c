"""Cleaning: every fault of a log is cured or refused, and reported with its row numbers."""

import csv

import numpy as np
import pytest

from dehyst.errors import ExcitationError, RecordingError, TimeError, UnitError
from dehyst.io import read_log, read_signal

N = 400
T = np.round(np.arange(N) * 0.01, 6)
X = np.round(3.0 * np.sin(2 * np.pi * T), 6)
Y = np.round(20.0 * np.sin(2 * np.pi * T - 0.2), 6)


def write(path, columns):
    """The csv module writes; dehyst reads."""
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
    return path


def log(tmp_path, t=T, x=X, y=Y, names=("p_bar", "angle_deg")):
    return write(tmp_path / "log.csv", {"time_s": list(t), names[0]: list(x), names[1]: list(y)})


def read(tmp_path, t=T, x=X, y=Y):
    return read_log(log(tmp_path, t, x, y), "p", "angle")


def codes(rec):
    return [finding.code for finding in rec.findings]


def swapped(*pairs):
    order = np.arange(N)
    for k in pairs:
        order[[k, k + 1]] = [k + 1, k]
    return order


def stray(value):
    t = T.copy()
    t[100] = value
    return t


def without(first, last):
    return np.delete(np.arange(N), np.arange(first, last))


EVERY, TWICE, RESTARTED = np.arange(N), np.repeat(np.arange(N), 2), np.r_[:250, :150]
COARSE = np.floor(T / 0.2 + 1e-9) * 0.2
# Stamps and rows that are logged -> the rows that are read, their breaks, the findings, and words of the first one.
FAULTS = {
    "none": (T, EVERY, EVERY, (), [], ""),
    "rows written twice": (T, TWICE, EVERY, (), ["repeated-time"], "400 of 800 rows"),
    "a gap in coarse stamps": (
        COARSE,
        without(130, 190),
        without(130, 190),
        (130,),
        ["coarse-time", "gap"],
        "",
    ),
    "two swapped pairs": (T, swapped(50, 200), EVERY, (), ["swapped-rows"], "lines 53, 203"),
    "a stamp too high": (stray(999.0), EVERY, without(100, 101), (), ["stray-time"], "line 102"),
    "a stamp too low": (stray(-5.0), EVERY, without(100, 101), (), ["stray-time"], "line 102"),
    "a stamp that is zero": (stray(0.0), EVERY, without(100, 101), (), ["stray-time"], "line 102"),
    "a clock that restarts": (T, RESTARTED, RESTARTED, (250,), ["clock-restart"], "line 252"),
    "newest row first": (T, EVERY[::-1], EVERY, (), ["reversed-time"], ""),
    "a gap with a way": (
        T,
        without(110, 125),
        without(110, 125),
        (110,),
        ["gap"],
        "0.16 s from 1.09 to 1.25 s",
    ),
    "a gap of more than half a loop": (
        T,
        without(111, 210),
        without(111, 210),
        (111,),
        ["gap"],
        "line 113",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_the_clock_is_cured_and_named(tmp_path, fault):
    stamps, logged, kept, breaks, found, words = FAULTS[fault]
    rec = read(tmp_path, stamps[logged], X[logged], Y[logged])
    np.testing.assert_array_equal(rec.input, X[kept])
    np.testing.assert_array_equal(rec.output, Y[kept])
    if stamps is T:
        np.testing.assert_array_equal(rec.time, T[kept])
    assert (rec.breaks, codes(rec)) == (breaks, found)
    assert not words or words in rec.findings[0].message


@pytest.mark.parametrize("column", [0, 1, 2])
def test_a_cell_without_a_measurement_drops_its_row_and_names_its_line(tmp_path, column):
    for cell in [
        "",
        "nan",
        "NaN",
        "inf",
        "-Infinity",
        "1e999",
        "1e200",
        "n/a",
        "oops",
        "1_0",
        "0x10",
        "१",
    ]:
        parts = [list(T), list(X), list(Y)]
        parts[column][6] = cell
        rec = read(tmp_path, *parts)
        np.testing.assert_array_equal(rec.input, np.delete(X, 6), err_msg=cell)
        assert codes(rec) == ["non-finite"]
        assert "line 8" in rec.findings[0].message  # line 1 is the header


def test_faults_of_columns_that_are_not_used_do_not_matter(tmp_path):
    file = write(tmp_path / "log.csv", {"time_s": T, "p_bar": X, "angle_deg": Y, "other": [""] * N})
    assert codes(read_log(file, "p", "angle")) == []


@pytest.mark.parametrize("first", [0, 7])
@pytest.mark.parametrize("rest", [False, True])
def test_stamps_coarser_than_the_sampling_are_spread(tmp_path, first, rest):
    x, y = X.copy(), Y.copy()
    if rest:
        x[100:180], y[100:180] = x[100], y[100]  # equal rows are samples too
    coarse = np.floor(T / 0.2 + 1e-9) * 0.2
    rec = read(tmp_path, coarse[first:], x[first:], y[first:])
    np.testing.assert_array_equal(rec.input, x[first:])
    np.testing.assert_allclose(rec.time, T[first:], atol=1e-9)
    assert codes(rec) == ["coarse-time"]
    assert f"{N - first - 20} of {N - first} rows" in rec.findings[0].message
    assert "groups of up to 20" in rec.findings[0].message
    assert "0.2 s against about 0.01 s" in rec.findings[0].message


def test_a_single_repeated_stamp_with_other_values_loses_no_row(tmp_path):
    t = T.copy()
    t[50] = t[49]
    rec = read(tmp_path, t)
    np.testing.assert_array_equal(rec.input, X)
    assert rec.time is not None
    assert 0 < rec.time[50] - T[49] < 0.02
    assert codes(rec) == ["coarse-time"]


@pytest.mark.parametrize("many", [4, 10])
def test_a_few_rows_in_reversed_order_are_sorted(tmp_path, many):
    count = 1000
    t = np.round(np.arange(count) * 0.01, 6)
    x = np.round(3.0 * np.sin(2 * np.pi * t), 6)
    order = np.arange(count)
    order[500 : 500 + many] = order[500 : 500 + many][::-1]
    rec = read(tmp_path, t[order], x[order], x[order] ** 3)
    np.testing.assert_array_equal(rec.time, t)
    np.testing.assert_array_equal(rec.input, x)
    assert codes(rec) == ["swapped-rows"]
    assert f"{many - 1} rows" in rec.findings[0].message
    assert "lines 503, 504" in rec.findings[0].message


def test_a_short_recording_after_a_restart_is_not_sorted_into_the_first(tmp_path):
    t = np.concatenate([np.arange(1000) * 0.01, 9.9051 + np.arange(9) * 0.01])
    x = np.sin(2 * np.pi * t)
    rec = read(tmp_path, np.round(t, 6), x, x**3)
    assert (rec.breaks, codes(rec)) == ((1000,), ["clock-restart"])


def test_shuffled_stamps_are_refused(tmp_path):
    order = np.random.default_rng(0).permutation(N)
    with pytest.raises(TimeError, match="Sort the log"):
        read(tmp_path, T[order], X[order], Y[order])


def test_a_gap_across_which_nothing_happened_is_only_a_finding(tmp_path):
    x = np.concatenate([X[:225], np.full(100, X[224]), X[225:]])
    t = np.arange(500) * 0.01
    y = np.concatenate([Y[:225], np.full(100, Y[224]), Y[225:]])
    keep = np.delete(np.arange(500), np.arange(240, 255))
    rec = read(tmp_path, t[keep], x[keep], y[keep])
    assert rec.breaks == ()
    assert codes(rec) == ["gap"]


@pytest.mark.parametrize(
    ("false", "code"), [(85.0, "outlier"), (np.nan, "non-finite"), (None, "gap")]
)
def test_rows_left_out_are_said_once_and_rows_that_the_logger_lost_are_a_gap(tmp_path, false, code):
    t = np.round(0.02 * np.arange(3000.0), 6)
    x = np.sin(2 * np.pi * t / 12.0)
    y = 3.0 * x
    if false is None:
        t, x, y = (np.delete(v, slice(1500, 1505)) for v in (t, x, y))
    else:
        y[1500:1505] = false
    assert codes(read(tmp_path, t, x, y)) == [code]


def test_uneven_sampling_and_bursts_are_no_gaps(tmp_path):
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.uniform(0.005, 0.02, size=N))
    assert codes(read(tmp_path, t, np.sin(5 * t), np.cos(5 * t))) == []
    bursts = np.repeat(np.arange(N // 4) * 0.04, 4) + np.tile([0, 1e-5, 2e-5, 3e-5], N // 4)
    assert codes(read(tmp_path, bursts)) == []


def test_rows_dropped_at_length_are_a_gap_too(tmp_path):
    y = list(Y)
    y[110:125] = [""] * 15
    rec = read(tmp_path, y=y)
    assert rec.breaks == (110,)
    assert codes(rec) == ["non-finite", "gap"]
    file = write(tmp_path / "bare.csv", {"p_bar": list(X), "angle_deg": y})
    assert read_log(file, "p", "angle").breaks == (110,)


def test_without_time_rows_are_taken_in_order(tmp_path):
    file = write(tmp_path / "log.csv", {"p_bar": X, "angle_deg": Y})
    rec = read_log(file, "p", "angle")
    assert rec.time is None
    assert codes(rec) == ["no-time"]
    with pytest.raises(TimeError, match="no time column"):
        read_log(file, "p", "angle", start=1.0)


def test_signals_logged_in_turns_are_brought_to_the_input_stamps(tmp_path):
    x = list(X)
    y = list(np.round(2.0 * T, 6))  # linear: interpolation must be exact
    x[1::2] = [""] * (N // 2)
    y[0::2] = [""] * (N // 2)
    rec = read(tmp_path, x=x, y=y)
    np.testing.assert_array_equal(
        rec.input, X[2::2]
    )  # the first input stamp lies before the first output
    np.testing.assert_allclose(rec.output, 2.0 * T[2::2], atol=1e-12)
    assert "two-clocks" in codes(rec)
    assert "non-finite" not in codes(rec)


def test_two_time_columns_each_left_of_its_signal_are_two_clocks(tmp_path):
    t2 = T + 0.0037
    file = write(tmp_path / "log.csv", {"t1_s": T, "p_bar": X, "t2_s": t2, "angle_deg": 5 * t2})
    rec = read_log(file, "p", "angle")
    np.testing.assert_allclose(rec.output, 5 * np.asarray(rec.time), atol=1e-9)
    assert len(rec) == N - 1
    assert codes(rec) == ["two-clocks"]


def test_two_time_columns_named_after_their_signals_are_two_clocks(tmp_path):
    t2 = T * 1.01 + 0.0037
    columns = {"p_bar": X, "angle_deg": np.round(5 * t2, 9), "time_angle_s": t2, "time_p_s": T}
    rec = read_log(write(tmp_path / "log.csv", columns), "p", "angle")
    np.testing.assert_allclose(rec.output, 5 * np.asarray(rec.time), atol=1e-8)
    assert "two-clocks" in codes(rec)


def test_time_columns_that_contradict_each_other_must_be_named(tmp_path):
    columns = {"p_bar": X, "angle_deg": Y, "host_time_s": T, "device_time_s": 1.3 * T**1.1}
    file = write(tmp_path / "log.csv", columns)
    with pytest.raises(TimeError, match="--time host_time_s"):
        read_log(file, "p", "angle")
    rec = read_log(file, "p", "angle", time="host_time")
    np.testing.assert_array_equal(rec.time, T)


def test_two_time_columns_that_agree_are_one_clock(tmp_path):
    columns = {
        "stamp_ns": np.round(1.7e18 + T * 1e9).astype(np.int64),
        "time_s": T,
        "p_bar": X,
        "angle_deg": Y,
    }
    rec = read_log(write(tmp_path / "log.csv", columns), "p", "angle")
    np.testing.assert_array_equal(rec.time, T)
    assert codes(rec) == []


def test_a_constant_input_or_output_is_refused(tmp_path):
    with pytest.raises(ExcitationError, match="is 2 in all 400 rows"):
        read(tmp_path, x=np.full(N, 2.0))
    with pytest.raises(RecordingError, match="not connected"):
        read(tmp_path, y=np.zeros(N))
    assert read_signal(log(tmp_path, x=np.full(N, 2.0)), "p").values.tolist() == [2.0] * N


def test_too_few_rows_are_refused(tmp_path):
    with pytest.raises(RecordingError, match="at least 4"):
        read(tmp_path, T[:3], X[:3], Y[:3])
    with pytest.raises(RecordingError, match="at least 4"):
        read_log(log(tmp_path), "p", "angle", start=1.0, stop=1.025)


def test_a_held_sensor_is_found_and_its_interpolated_sister_is_suggested(tmp_path):
    x = np.round(2 * np.sin(7 * T) + np.sin(11.3 * T), 6)
    held = x[np.arange(N) // 10 * 10]
    columns = {"time_s": T, "p_bar": held, "p_interp_bar": x, "angle_deg": Y}
    file = write(tmp_path / "log.csv", columns)
    rec = read_log(file, "p_bar", "angle")
    assert codes(rec) == ["held-input"]
    assert "every 10 samples, about 10 Hz" in rec.findings[0].message
    assert "'p_interp_bar'" in rec.findings[0].message
    assert codes(read_log(file, "p_interp", "angle")) == []


def test_neither_a_converter_nor_a_trapezoid_is_a_held_sensor(tmp_path):
    slow = np.arange(4000) / 4000 * 2
    coarse = np.round(60 * np.sin(2 * np.pi * slow)) / 20
    trapezoid = np.clip(6 * np.sin(2 * np.pi * slow), -3, 3)
    for x in (coarse, trapezoid):
        file = write(
            tmp_path / "log.csv", {"time_s": slow, "p_bar": x, "angle_deg": np.cos(slow * 5)}
        )
        assert "held-input" not in codes(read_log(file, "p", "angle"))


def test_a_saturated_output_is_found_and_a_play_is_not(tmp_path):
    rec = read(tmp_path, y=np.minimum(Y, 12.0))
    assert "saturated-output" in codes(rec)
    assert "12 deg" in rec.findings[0].message
    x = X * np.where(
        np.arange(X.size) < X.size // 4, 1.0, 0.5
    )  # a converter that is full in the largest loop only
    rec = read(tmp_path, x=x, y=np.minimum(5.0 * x, 0.85 * 5.0 * x.max()))
    assert "saturated-output" in codes(rec), rec.findings
    play = [0.0]
    for value in X:
        play.append(max(value - 0.8, min(value + 0.8, play[-1])))
    assert codes(read(tmp_path, y=play[1:])) == []


@pytest.mark.parametrize(("phase", "word"), [(0.25, "never turns"), (0.75, "turns only once")])
def test_too_few_loops_are_pointed_out(tmp_path, phase, word):
    x = np.cos(2 * np.pi * T / T[-1] * phase)
    rec = read(tmp_path, x=x, y=x**3)
    assert codes(rec) == ["few-loops"]
    assert word in rec.findings[0].message


def test_few_values_are_pointed_out(tmp_path):
    rec = read(tmp_path, y=np.round(Y / 10))
    assert codes(rec) == ["quantised-output"]
    assert "only 5 different values" in rec.findings[0].message


@pytest.mark.parametrize(
    ("x", "y", "swapped"),
    [
        ("angle_deg", "pressure_bar", True),
        ("displacement_um", "voltage_v", True),
        ("angle_deg", "angle_cmd_deg", True),
        ("angle_cmd_deg", "angle_deg", False),
        ("displacement_mm", "force_N", False),
        ("force_N", "displacement_mm", False),
        ("pressure_cmd_bar", "pressure_bar", False),
        ("a", "b", False),
    ],
)
def test_swapped_columns_are_suspected_only_where_both_names_speak(tmp_path, x, y, swapped):
    file = log(tmp_path, names=(x, y))
    assert codes(read_log(file, x, y)) == (["swapped-columns"] if swapped else [])


def test_findings_never_depend_on_rows_outside_the_window(tmp_path):
    y = list(Y)
    y[3] = ""
    file = log(tmp_path, y=y)
    assert codes(read_log(file, "p", "angle", start=1.0)) == []


def test_a_single_signal_keeps_gaps_as_breaks(tmp_path):
    keep = np.delete(np.arange(N), np.arange(110, 125))
    signal = read_signal(log(tmp_path, T[keep], X[keep], Y[keep]), "angle")
    assert signal.breaks == (110,)
    assert signal.provenance["column"] == "angle_deg"


def test_a_named_clock_serves_the_signal_it_fits(tmp_path):
    slow = np.arange(100) * 0.04
    np.savez(
        tmp_path / "log.npz",
        t=T,
        p_bar=X,
        slow_time=slow,
        other_time=slow + 100.0,
        angle_deg=3.0 * slow,
    )
    rec = read_log(tmp_path / "log.npz", "p", "angle", time="slow_time")
    np.testing.assert_allclose(rec.output, 3.0 * np.asarray(rec.time), atol=1e-12)
    assert "two-clocks" in codes(rec)


def test_the_unit_of_time_may_be_named(tmp_path):
    file = write(tmp_path / "log.csv", {"t": np.round(1000 * T, 3), "p_bar": X, "angle_deg": Y})
    [finding] = read_log(file, "p", "angle").findings
    assert finding.code == "time-unit"
    assert "--time-unit ms" in finding.message
    for rec in (
        read_log(file, "p", "angle", time_unit="ms"),
        read_signal(file, "p", time="t", time_unit="msec"),
    ):
        assert codes(rec) == []
        np.testing.assert_allclose(rec.time, T, atol=1e-9)
    with pytest.raises(UnitError, match="'bar' is no unit of time"):
        read_log(file, "p", "angle", time_unit="bar")
    bare = write(tmp_path / "bare.csv", {"p_bar": X, "angle_deg": Y})
    with pytest.raises(TimeError, match="no time column whose unit"):
        read_log(bare, "p", "angle", time_unit="ms")


def test_a_named_unit_of_time_wins_over_the_name(tmp_path):
    rec = read_log(log(tmp_path, t=1000 * T), "p", "angle", time_unit="ms")
    np.testing.assert_allclose(rec.time, T, atol=1e-9)


def test_a_reference_keeps_its_length_where_values_are_missing(tmp_path):
    x = list(X)
    x[0] = x[1] = x[50] = ""
    x[51] = "nan"
    signal = read_signal(log(tmp_path, x=x), "p")
    expected = X.copy()
    expected[:2], expected[50:52] = X[2], X[49]
    np.testing.assert_array_equal(signal.values, expected)
    np.testing.assert_array_equal(signal.time, T)
    assert signal.breaks == ()
    assert codes(signal) == ["held-reference"]
    assert "4 of 400 rows" in signal.findings[0].message
    assert "lines 2, 3, 52, 53" in signal.findings[0].message
    dropped = read_signal(log(tmp_path, x=x), "p", missing="drop")
    np.testing.assert_array_equal(dropped.values, np.delete(X, [0, 1, 50, 51]))
    assert codes(dropped) == ["non-finite"]


def test_an_outlier_of_a_reference_is_held(tmp_path):
    x = X.copy()
    x[100] = -9999.0
    signal = read_signal(log(tmp_path, x=x), "p")
    np.testing.assert_array_equal(np.delete(signal.values, 100), np.delete(X, 100))
    assert signal.values[100] == X[99]
    [finding] = signal.findings
    assert finding.code == "outlier"
    assert "the value before each was held" in finding.message


def test_a_signal_logged_in_turns_is_not_held(tmp_path):
    x = list(X)
    for k in range(N):
        x[k] = x[k] if k % 3 == 0 else ""
    signal = read_signal(log(tmp_path, x=x), "p")
    np.testing.assert_array_equal(signal.values, X[::3])
