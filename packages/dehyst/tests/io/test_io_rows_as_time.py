"""--dt: one row is so many seconds, where the log has no time."""

import numpy as np
import pytest

from dehyst import inspect_log, read_log
from dehyst.errors import TimeError
from dehyst.io import read_columns, read_signal, write_csv

DT = 5e-8
X = np.sin(0.05 * np.arange(400))
Y = 2.0 * np.sin(0.05 * np.arange(400) - 0.3)


def lines():
    return [f"{x:.6f},{y:.6f}" for x, y in zip(X, Y, strict=True)]


@pytest.fixture
def log(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text("\n".join(["drive_V,stroke_um", *lines()]))
    return file


def test_every_reader_counts_the_rows(log):
    t = DT * np.arange(400)
    np.testing.assert_allclose(read_log(log, "drive", "stroke", dt=DT).time, t, rtol=1e-12)
    np.testing.assert_allclose(read_signal(log, "drive", dt=DT).time, t, rtol=1e-12)
    np.testing.assert_allclose(read_columns(log, {"x": "drive"}, dt=DT).time, t, rtol=1e-12)
    assert read_log(log, "drive", "stroke", dt=DT).findings == ()
    assert len(read_log(log, "drive", "stroke", dt=DT, start=100.5 * DT, stop=200.5 * DT)) == 100


def test_a_row_that_was_left_out_keeps_its_time_and_empty_lines_have_none(log):
    damaged = lines()
    damaged[200] = "1.0"
    log.write_text("\n".join(["drive_V,stroke_um", *damaged]))
    t = DT * np.delete(np.arange(400), 200)
    np.testing.assert_allclose(read_log(log, "drive", "stroke", dt=DT).time, t, rtol=1e-9)
    log.write_text("\n\n".join(["drive_V,stroke_um", *lines()]))
    np.testing.assert_allclose(
        read_log(log, "drive", "stroke", dt=DT).time, DT * np.arange(400), rtol=1e-9
    )


def test_signals_of_several_lengths_each_have_their_rows(tmp_path):
    np.savez(tmp_path / "log.npz", drive_V=X, stroke_um=Y, other=X[:100])
    np.testing.assert_allclose(
        read_signal(tmp_path / "log.npz", "other", dt=0.5).time, 0.5 * np.arange(100)
    )
    assert read_log(tmp_path / "log.npz", "drive", "stroke", dt=0.5).time[-1] == 199.5


def test_a_clock_that_is_not_read_is_named(tmp_path):
    file = write_csv(
        tmp_path / "log.csv", {"time_s": 0.1 * np.arange(400), "drive_V": X, "stroke_um": Y}
    )
    rec = read_log(file, "drive", "stroke", dt=DT)
    [finding] = rec.findings
    assert (
        rec.time[1] == DT
        and finding.code == "several-time-columns"
        and "'time_s'" in finding.message
    )


@pytest.mark.parametrize("dt", [0.0, -1.0, float("nan"), float("inf")])
def test_seconds_that_are_none_are_refused(log, dt):
    with pytest.raises(TimeError, match="--dt"):
        read_log(log, "drive", "stroke", dt=dt)


def test_rows_and_a_clock_are_not_both_named(log):
    for other in ({"time": "drive"}, {"time_unit": "ms"}):
        with pytest.raises(TimeError, match="leave out one of them"):
            read_log(log, "drive", "stroke", dt=DT, **other)


def test_the_command_of_inspect_counts_the_rows_too(log):
    summary = inspect_log(log, dt=DT)
    assert summary.sampling is not None and summary.sampling.median == pytest.approx(DT)
    assert summary.command.endswith(f"--dt {DT}") and [f.code for f in summary.findings] == []
    assert "--dt" in inspect_log(log).findings[0].message


def table(order, stamps):
    columns = {"t": stamps, "x": X, "y": Y, "n": np.arange(400.0), "-": None}
    rows = zip(
        *(
            [("" if v is None else repr(float(v[k]))) for k in range(400)]
            for v in map(columns.get, order)
        ),
        strict=True,
    )
    return "\n".join(",".join(row) for row in rows)


@pytest.mark.parametrize("order", ["txy", "-txy", "ntxy", "xyt", "xty", "nxyt"])
@pytest.mark.parametrize("steps", ["even", "repeated", "uneven"])
def test_time_is_found_in_any_column_of_a_table_without_names(tmp_path, order, steps):
    t = 2e-4 * np.arange(400)
    if steps == "repeated":
        t = 4e-4 * (np.arange(400) // 2)
    if steps == "uneven":
        t = np.cumsum(np.random.default_rng(2).exponential(2e-4, 400))
    (tmp_path / "log.csv").write_text(table(order, t))
    if steps != "even" and "n" in order:
        return  # two columns count up, and none of them evenly in seconds
    place = f"column_{order.index('t') + 1}"
    summary = inspect_log(tmp_path / "log.csv")
    assert summary.sampling is not None and summary.sampling.column == place
