"""Units of time as strangers write them: converted where they are known, refused with a cure where they are not."""

import numpy as np
import pytest

from dehyst import inspect_log, read_log
from dehyst.errors import DehystError, UnitError
from dehyst.io import write_csv

S, MS, US, NS, MIN, H, D, WEEK = 1.0, 1e-3, 1e-6, 1e-9, 60.0, 3600.0, 86400.0, 604800.0
KNOWN = {
    **dict.fromkeys(("time [s]", "t (sec)", "Zeit [Sek.]", "time_seconds", "time in s", "t/s", "Time{s}"), S),
    **dict.fromkeys(("temps [secondes]", "tiempo (segundos)", "time [SS]", "elapsed sec", "Zeit in Sekunden"), S),
    **dict.fromkeys(("time [s since start]", "time (seconds since 2024-01-01 00:00)", "Time:s", "timeSec"), S),
    **dict.fromkeys(("time [ms]", "TIME (MS)", "timeMs", "elapsedMs", "time_msec", "Zeit [Millisekunden]", "t/ms"), MS),
    **dict.fromkeys(("time in ms", "Time_Ms", "time [milliseconds]", "time [millisec]", "t [1/1000 s]"), MS),
    **dict.fromkeys(("time [us]", "time [µs]", "time [μs]", "timestampUs", "time_micros", "t (microsec)"), US),
    **dict.fromkeys(("time [ns]", "time_nanoseconds", "timestampNs", "Zeit [Nanosekunden]", "t [1e-9 s]"), NS),
    **dict.fromkeys(("time [min]", "Zeit [Minuten]", "time_minutes", "t [min.]", "time in minutes", "t_min"), MIN),
    **dict.fromkeys(("time [h]", "Zeit [Std]", "Zeit [Std.]", "time (hh)", "time [hrs]", "time_hours"), H),
    **dict.fromkeys(("Zeit [Stunden]", "temps [heures]", "time_h", "elapsedHours", "t / h", "t [hr]"), H),
    **dict.fromkeys(("time [d]", "time [days]", "time_days", "Zeit [Tage]", "Zeit in Tagen", "t/d", "time_d"), D),
    **dict.fromkeys(("time [D]", "temps [jours]", "tiempo [días]", "days since 1970 [days]", "elapsedDays"), D),
    **dict.fromkeys(("time [weeks]", "Zeit [Wochen]", "time_weeks", "time (wk)"), WEEK),
    **dict.fromkeys(("time [0.1s]", "time [0,1 s]", "time [1/10 s]", "time [ds]", "time [s/10]", "t_0.1s"), 0.1),
    **dict.fromkeys(("time [cs]", "time [1/100 s]", "time [10ms]", "time [10 ms]", "time [centiseconds]"), 0.01),
    **dict.fromkeys(("time [10us]", "time [10 µs]", "t_10us", "time (x 10 us)", "time [10^-5 s]"), 1e-5),
    **dict.fromkeys(("time [100ns]", "time [100 ns]"), 1e-7),
    **dict.fromkeys(("time [ps]", "time [picoseconds]"), 1e-12),
    **dict.fromkeys(("time [fs]", "time [femtoseconds]"), 1e-15),
    "Time, s": S, "stamp (nsec)": NS,
    "time [ks]": 1e3, "time [15 min]": 900.0, "time [2.5 ms]": 2.5e-3, "t [1/60 s]": 1 / 60,
}  # fmt: skip
UNKNOWN = [
    "time [ticks]", "time_ticks", "timeTicks", "time [samples]", "time_samples", "time [cycles]", "time [jiffies]",
    "time [Ms]", "time [m]", "time [mm]", "time [counts]", "time [frames]", "Zeit [Takte]", "time [a.u.]",
    "time [years]", "time [months]", "time (ticks)", "t [Hz]", "time in ticks", "time, ticks", "time [div]", "t [1/s]",
    "elapsed cycles", "time [px]", "time [clk]", "time_counts", "time [0 s]", "time [beats]",
]  # fmt: skip
SILENT_SECONDS = [
    "time",
    "t",
    "timestamp",
    "time (relative)",
    "time [-]",
    "Zeit (local)",
    "time_sensor",
    "time_1",
]
T = 0.05 * np.arange(200)
X = 2.0 + np.sin(0.7 * T)
Y = 3.0 * np.sin(0.7 * T - 0.4)


def log(folder, name, factor):
    return write_csv(
        folder / "log.csv", {name: 7.0 + T / factor, "pressure_bar": X, "angle_deg": Y}
    )


def outcome(folder, name, factor):
    """Right, refused with its cure, warned, or wrong without a word."""
    try:
        rec = read_log(log(folder, name, factor), "pressure", "angle")
    except DehystError as fault:
        return "refused" if "--time-unit" in str(fault) else "refused without a cure"
    if rec.time is not None and np.allclose(np.diff(rec.time), 0.05, rtol=1e-6):
        return "right"
    return "warned" if rec.findings else "wrong"


@pytest.mark.parametrize("name", KNOWN)
def test_a_known_unit_of_time_is_converted(tmp_path, name):
    assert outcome(tmp_path, name, KNOWN[name]) == "right"


@pytest.mark.spread(10)
@pytest.mark.parametrize("name", UNKNOWN)
def test_an_unknown_unit_of_time_is_refused_and_its_cure_reads_the_log(tmp_path, monkeypatch, name):
    assert outcome(tmp_path, name, 0.0005) == "refused"
    file = log(tmp_path, name, 0.0005)
    for unit in ("0.0005", 0.0005, "0.5 ms"):
        rec = read_log(file, "pressure", "angle", time_unit=unit)
        np.testing.assert_allclose(np.diff(rec.time), 0.05, rtol=1e-9)
    summary = inspect_log(file)
    assert any("--time-unit" in finding.message for finding in summary.findings)
    monkeypatch.setattr("dehyst.io._long.WHOLE_BYTES", 0)  # and in parts
    with pytest.raises(UnitError, match="--time-unit"):
        read_log(file, "pressure", "angle")
    rec = read_log(file, "pressure", "angle", time_unit="0.0005")
    np.testing.assert_allclose(np.diff(rec.time), 0.05, rtol=1e-9)


@pytest.mark.parametrize("name", SILENT_SECONDS)
def test_a_name_without_a_unit_is_still_read_as_seconds(tmp_path, name):
    assert outcome(tmp_path, name, 1.0) == "right"


def test_there_are_120_spellings():
    assert len(KNOWN) + len(UNKNOWN) >= 120


STARTS = {
    "Excel": 45_000.0,
    "MATLAB": 739_000.25,
    "Julian dates": 2_460_000.5,
    "days since 1970": 19_800.0,
}
FORMS = ["csv", "npz", "mat", "xlsx", "parquet"]


def written(folder, form, name, stamps):
    columns = {name: stamps, "pressure_bar": X, "angle_deg": Y}
    file = folder / f"log.{form}"
    if form == "csv":
        return write_csv(file, columns)
    if form == "npz":
        np.savez(file, **columns)
    elif form == "mat":
        pytest.importorskip("scipy.io").savemat(file, columns)
    else:
        pytest.importorskip("openpyxl" if form == "xlsx" else "pyarrow")
        pandas = pytest.importorskip("pandas")
        frame = pandas.DataFrame(columns)
        frame.to_excel(file, index=False) if form == "xlsx" else frame.to_parquet(file)
    return file


@pytest.mark.spread(10)
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["time", "date", "t", "Zeitstempel"])
def test_day_numbers_are_known_by_their_range_and_step_and_said(tmp_path, form, name):
    for who, start in STARTS.items():
        for step in (0.05, 1.0, 10.0, 60.0):
            stamps = start + step * np.arange(T.size) / D
            rec = read_log(written(tmp_path, form, name, stamps), "pressure", "angle")
            digits = np.spacing(start) * D  # what a double of this size can tell
            np.testing.assert_allclose(np.diff(rec.time), step, atol=4 * digits)
            assert rec.time[0] == 0.0
            assert [f.code for f in rec.findings] == ["day-numbers"], rec.findings
            assert who in rec.findings[0].message
            named = read_log(tmp_path / f"log.{form}", "pressure", "angle", time_unit="d")
            np.testing.assert_array_equal(named.time, rec.time)


@pytest.mark.parametrize("start", STARTS.values())
def test_a_clock_that_has_run_for_hours_is_no_day_number(tmp_path, start):
    for step in (1e-4, 5e-4, 1e-3, 0.02, 0.1, 1 / 300):
        rec = read_log(
            written(tmp_path, "csv", "time", start + step * np.arange(T.size)), "pressure", "angle"
        )
        np.testing.assert_allclose(np.diff(rec.time), step, rtol=1e-4)
        assert rec.findings == ()


def test_numbers_that_may_be_days_and_seconds_are_refused(tmp_path):
    stamps = 45_000.0 + np.cumsum(np.random.default_rng(0).uniform(2.1e-4, 4.4e-4, T.size))
    file = written(tmp_path, "csv", "time", stamps)
    with pytest.raises(UnitError, match="--time-unit s or --time-unit d"):
        read_log(file, "pressure", "angle")
    slow, fast = (read_log(file, "pressure", "angle", time_unit=unit) for unit in ("d", "s"))
    np.testing.assert_allclose(np.diff(slow.time), D * np.diff(fast.time), rtol=1e-6)


EPOCHS = [
    (638_700_000_000_000_000, 1e-7),
    (133_500_000_000_000_000, 1e-7),
    (1_717_000_000_000_000_000, 1e-9),
]


@pytest.mark.parametrize(("start", "scale"), [*EPOCHS, (1_717_000_000_000, 1e-3)])
def test_clocks_of_computers_are_known_by_their_range(tmp_path, start, scale):
    stamps = [start + round(k * 0.05 / scale) for k in range(T.size)]
    rows = [f"{t},{x},{y}" for t, x, y in zip(stamps, X, Y, strict=True)]
    (tmp_path / "log.csv").write_text("timestamp,pressure_bar,angle_deg\n" + "\n".join(rows))
    rec = read_log(tmp_path / "log.csv", "pressure", "angle")
    np.testing.assert_allclose(np.diff(rec.time), 0.05, atol=1e-5)
    assert rec.time[0] == 0.0 and rec.findings == ()


@pytest.mark.parametrize(
    ("name", "step"), [("time", 1e-9), ("time [ps]", 10.0), ("time [h]", 50.0), ("time [d]", 2.0)]
)
def test_a_step_or_a_duration_that_no_log_has_is_said(tmp_path, name, step):
    rec = read_log(written(tmp_path, "csv", name, step * np.arange(T.size)), "pressure", "angle")
    assert [f.code for f in rec.findings] == ["time-unit"] and "--time-unit" in rec.findings[
        0
    ].message
