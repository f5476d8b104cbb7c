"""The clock of historians and data loggers: date and time in two columns, in every order and notation."""

from datetime import datetime, timedelta

import numpy as np
import pytest

from dehyst import inspect_log, read_log
from dehyst.errors import LogError, TimeError

START = datetime(2024, 3, 5, 20, 0)
DATES = {
    "ISO": "%Y-%m-%d", "German": "%d.%m.%Y", "American": "%m/%d/%Y", "year first": "%Y/%m/%d", "short": "%d.%m.%y",
    "digits": "%Y%m%d",
}  # fmt: skip
CLOCKS = {"plain": "%H:%M:%S", "points": "%H.%M.%S", "half": "%I:%M:%S %p", "minutes": "%H:%M", "parts": "%H:%M:%S.%f",
          "digits": "%H%M%S"}  # fmt: skip
NAMES = [("date", "time"), ("Datum", "Uhrzeit"), ("Date", "Clock"), ("LogDate", "LogTime")]
LAYOUTS = ["date time x y", "time date x y", "n date time x y", "x y date time", "date n time x y"]


def signals(size):
    x = 5.0 - 5.0 * np.cos(2.0 * np.pi * np.arange(size) / 150.0)
    return x, np.roll(x, 9)


def written(folder, date, clock, names, layout, newest_first, rows_a_stamp=1, size=600, step=60):
    """A log over one midnight, and the true time of its rows, from the oldest on."""
    x, y = signals(size)
    when = [START + timedelta(seconds=step * (k // rows_a_stamp)) for k in range(size)]
    columns = {
        "date": [f"{t:{DATES[date]}}" for t in when],
        "time": [f"{t:{CLOCKS[clock]}}" for t in when],
        "n": [str(28495079 - k) if newest_first else str(k) for k in range(size)],
        "x": [f"{v:.4f}" for v in x],
        "y": [f"{v:.4f}" for v in y],
    }
    head = {"date": names[0], "time": names[1], "n": "id", "x": "valve_percent", "y": "flow"}
    lines = [";".join(columns[name][k] for name in layout.split()) for k in range(size)]
    lines = lines[::-1] if newest_first else lines
    file = folder / "log.csv"
    file.write_text("\n".join([";".join(head[name] for name in layout.split()), *lines]))
    return file, step * (np.arange(size) // rows_a_stamp)


def wrong(folder, *case):
    """What is wrong with one log, "" if nothing is."""
    file, t = written(folder, *case)
    rec = read_log(file, "valve_percent", "flow")
    codes = {finding.code for finding in rec.findings} - {"reversed-time"}
    if rec.time is None or rec.breaks or codes or len(rec) != t.size:
        return f"{case}: {codes}, breaks {rec.breaks}"
    if not np.array_equal(rec.time, t) or not np.allclose(rec.input, signals(t.size)[0], atol=1e-4):
        return f"{case}: time from {rec.time[0]} to {rec.time[-1]}"
    part = read_log(file, "valve_percent", "flow", start=6000.0, stop=12000.0)
    named = [read_log(file, "valve_percent", "flow", time=name).time for name in case[2]]
    same = len(part) == 100 and all(np.array_equal(time, t) for time in named)
    line = inspect_log(file).sampling
    shown = line is not None and (line.first, line.last, line.median, line.backward) == (
        0.0,
        t[-1],
        60.0,
        0,
    )
    return "" if same and shown else f"{case}: window of {len(part)}, {line}"


CASES = [
    (date, clock, names, layout, newest_first)
    for date in DATES
    for clock in CLOCKS
    for names in NAMES
    for layout in LAYOUTS
    for newest_first in (False, True)
]


def test_date_and_time_in_two_columns_are_one_clock(tmp_path):
    assert [text for case in CASES[::487] if (text := wrong(tmp_path, *case))] == []


@pytest.mark.exhaustive
def test_all_notations_layouts_and_orders_are_one_clock(tmp_path):
    assert [text for case in CASES[::11] if (text := wrong(tmp_path, *case))] == []


@pytest.mark.parametrize("newest_first", [False, True])
@pytest.mark.parametrize("many", [2, 10])
def test_rows_that_share_a_stamp_keep_their_order(tmp_path, newest_first, many):
    file, t = written(tmp_path, "ISO", "plain", NAMES[0], LAYOUTS[0], newest_first, many)
    rec = read_log(file, "valve_percent", "flow")
    assert {f.code for f in rec.findings} == {"coarse-time"} | (
        {"reversed-time"} if newest_first else set()
    )
    np.testing.assert_allclose(rec.input, signals(t.size)[0], atol=1e-4)
    np.testing.assert_allclose(rec.time, t + 60.0 / many * (np.arange(t.size) % many), atol=1e-9)


@pytest.mark.parametrize("newest_first", [False, True])
def test_stamps_in_one_column_newest_first_count_from_the_oldest(tmp_path, newest_first):
    x, y = signals(600)
    lines = [f"{START + timedelta(minutes=k)},{x[k]:.4f},{y[k]:.4f}" for k in range(600)]
    (tmp_path / "log.csv").write_text(
        "\n".join(["time,valve,flow", *(lines[::-1] if newest_first else lines)])
    )
    rec = read_log(tmp_path / "log.csv", "valve", "flow", start=0.0, stop=6000.0)
    np.testing.assert_array_equal(rec.time, 60.0 * np.arange(100))
    np.testing.assert_allclose(rec.input, x[:100], atol=1e-4)


@pytest.mark.parametrize(
    ("name", "unit"), [("time", 1.0), ("time [s]", 1.0), ("time_ms", 1e-3), ("time [h]", 3600.0)]
)
def test_a_number_that_begins_anew_with_each_date_is_joined_to_it(tmp_path, name, unit):
    x, y = signals(600)
    when = [START + timedelta(minutes=k) for k in range(600)]
    day = [(t - datetime(t.year, t.month, t.day)).total_seconds() / unit for t in when]
    lines = [
        f"{t:%Y-%m-%d},{s!r},{a:.4f},{b:.4f}" for t, s, a, b in zip(when, day, x, y, strict=True)
    ]
    for order in (1, -1):
        (tmp_path / "log.csv").write_text("\n".join([f"date,{name},valve,flow", *lines[::order]]))
        rec = read_log(tmp_path / "log.csv", "valve", "flow")
        np.testing.assert_allclose(rec.time, 60.0 * np.arange(600), atol=1e-6)
        assert rec.breaks == ()


def test_a_time_of_day_alone_goes_on_over_midnight(tmp_path):
    x, y = signals(600)
    for clock in [*CLOCKS][:-1]:
        lines = [
            f"{START + timedelta(minutes=k):{CLOCKS[clock]}},{x[k]:.4f},{y[k]:.4f}"
            for k in range(600)
        ]
        for order in (1, -1):
            (tmp_path / "log.csv").write_text("\n".join(["time,valve,flow", *lines[::order]]))
            rec = read_log(tmp_path / "log.csv", "valve", "flow")
            np.testing.assert_array_equal(rec.time, 60.0 * np.arange(600))
            assert rec.breaks == () and len(rec.findings) == (order < 0)


def test_dates_alone_are_no_clock_of_many_rows_a_day(tmp_path):
    x, y = signals(600)
    lines = [f"{START + timedelta(minutes=k):%Y-%m-%d},{x[k]:.4f},{y[k]:.4f}" for k in range(600)]
    (tmp_path / "log.csv").write_text("\n".join(["date,valve,flow", *lines]))
    rec = read_log(tmp_path / "log.csv", "valve", "flow")
    assert rec.time is None and [f.code for f in rec.findings] == ["no-time"]
    with pytest.raises(TimeError, match="dates without a time of day"):
        read_log(tmp_path / "log.csv", "valve", "flow", time="date")


@pytest.mark.parametrize("newest_first", [False, True])
def test_a_long_log_whose_dates_must_be_joined_is_read_at_once_or_says_why_not(
    tmp_path, monkeypatch, newest_first
):
    file, _ = written(tmp_path, "ISO", "plain", NAMES[0], LAYOUTS[0], newest_first)
    known = read_log(file, "valve_percent", "flow")
    monkeypatch.setattr("dehyst.io._long.WHOLE_BYTES", 0)
    np.testing.assert_array_equal(read_log(file, "valve_percent", "flow").time, known.time)
    monkeypatch.setattr("dehyst.io._long.SIZE_LIMIT", 0)
    with pytest.raises(LogError, match="its date and its time in two columns"):
        read_log(file, "valve_percent", "flow")
