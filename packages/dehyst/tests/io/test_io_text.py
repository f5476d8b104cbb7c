"""Text logs: whatever the delimiter, decimal sign, encoding or header, the numbers are those that were written."""

import csv
import gzip
import io

import numpy as np
import pytest

from dehyst.errors import ColumnError, LogError, ModelFileError, RecordingError, RunError, TimeError
from dehyst.io import inspect_log, read_columns, read_log, read_signal, write_csv
from dehyst.models import load
from effort import lines_run

T = np.round(np.arange(80) * 0.05, 6)
X = np.round(3.0 * np.sin(2 * np.pi * T / 2.0), 5)
Y = np.round(20.0 * np.sin(2 * np.pi * T / 2.0 - 0.2) + 1.0, 4)


def table_text(delimiter=",", decimal=".", header="time_s,pressure_bar,angle_deg"):
    stream = io.StringIO()
    writer = csv.writer(stream, delimiter=delimiter, lineterminator="\n")
    if header is not None:
        writer.writerow(header.split(","))
    for row in zip(T, X, Y, strict=True):
        writer.writerow([repr(float(v)).replace(".", decimal) for v in row])
    return stream.getvalue()


def check(path, x="pressure", y="angle", codes=()):
    rec = read_log(path, x, y)
    np.testing.assert_array_equal(rec.input, X)
    np.testing.assert_array_equal(rec.output, Y)
    assert rec.time is not None
    np.testing.assert_array_equal(rec.time, T)
    assert tuple(f.code for f in rec.findings) == codes


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|", " "])
def test_every_delimiter_and_decimal_sign_gives_the_same_numbers(tmp_path, delimiter):
    file = tmp_path / "log.csv"
    for decimal in "." if delimiter == "," else ".,":
        file.write_text(table_text(delimiter, decimal))
        check(file)


@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1"]
)
def test_every_encoding_and_line_end_gives_the_same_numbers(tmp_path, encoding):
    file = tmp_path / "log.txt"
    for ending in ("\n", "\r\n", "\r"):
        text = table_text(header="time [s],pressure [bar],angle [°]").replace("\n", ending)
        file.write_bytes(text.encode(encoding))
        check(file)
        assert read_log(file, "pressure", "angle").output_unit == "deg"


def test_gzip_is_read_whatever_the_file_is_called(tmp_path):
    for name in ("log.csv.gz", "log.csv"):
        (tmp_path / name).write_bytes(gzip.compress(table_text().encode()))
        check(tmp_path / name)


def test_comments_and_a_preamble_are_passed_over(tmp_path):
    file = tmp_path / "log.csv"
    lines = table_text().splitlines()
    lines[20:20] = ["# the valve was readjusted here", ""]
    file.write_text("\n".join(["Test rig 3", "Operator;N. N.", "Date,2024-05-01", "", *lines]))
    check(file)


@pytest.mark.parametrize("mark", ["# ", "% ", "#"])
def test_a_commented_header_is_a_header(tmp_path, mark):
    file = tmp_path / "log.dat"
    file.write_text(mark + table_text(" "))
    check(file)


@pytest.mark.parametrize("units", ["s,bar,deg", "[s],[bar],[deg]", "(s),(bar),(deg)"])
def test_a_units_row_wins_over_the_names(tmp_path, units):
    file = tmp_path / "log.csv"
    lines = table_text(header="time_ms,pressure,angle").splitlines()
    lines.insert(1, units)
    file.write_text("\n".join(lines))
    check(file)
    rec = read_log(file, "pressure", "angle")
    assert (rec.input_unit, rec.output_unit) == ("bar", "deg")


def test_without_a_header_columns_are_numbered_and_even_steps_are_time(tmp_path):
    file = tmp_path / "log.tsv"
    file.write_text(table_text("\t", header=None))
    check(file, "column_2", "#3")


def test_quoted_cells_and_a_trailing_delimiter(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text(
        "\n".join(",".join(f'"{c}"' for c in row.split(",")) for row in table_text().splitlines())
    )
    check(file)
    file.write_text("\n".join(line + "," for line in table_text().splitlines()))
    check(file)


def test_thousands_are_read_with_a_decimal_comma(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text(
        "time_s;force_N;x_mm\n" + "\n".join(f"0,{k};1.{k:03d},5;{k % 5},25" for k in range(10, 40))
    )
    rec = read_log(file, "x", "force")
    assert rec.output[0] == 1010.5
    assert rec.input[3] == 3.25


def test_commas_that_may_mean_thousands_are_pointed_out(tmp_path):
    file = tmp_path / "log.csv"
    rows = [
        f"{k};{900 + 20 * (k % 10) if k % 10 < 5 else f'1,0{k % 10}0'};{k % 10}" for k in range(40)
    ]
    file.write_text("time_s;force_N;x_mm\n" + "\n".join(rows))
    assert "decimal-comma" in [f.code for f in read_log(file, "x", "force").findings]


def test_ragged_lines_are_left_out_and_named(tmp_path):
    file = tmp_path / "log.csv"
    lines = table_text().splitlines()
    lines[10] = "0.45,1.2"
    lines[30] = lines[30] + ",7,8"
    file.write_text("\n".join(lines))
    rec = read_log(file, "pressure", "angle")
    keep = np.delete(np.arange(80), [9, 29])
    np.testing.assert_array_equal(rec.input, X[keep])
    [finding] = rec.findings
    assert finding.code == "ragged-lines"
    assert "lines 11, 31 " in finding.message


def test_a_table_that_is_mostly_ragged_is_refused(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text(
        "a,b,c\n" + "\n".join(",".join("1.5" for _ in range(2 + k % 3)) for k in range(90))
    )
    with pytest.raises(LogError, match="not a table"):
        read_log(file, "a", "b")


def test_iso_stamps_and_epochs_count_seconds_from_the_first_sample(tmp_path):
    file = tmp_path / "log.csv"
    epochs = [lambda t, s=s: f"{1714607998 * s + round(s * t)}" for s in (1000, 10**9)]
    for stamp in (iso, lambda t: f"{1714607998 + t:.3f}", *epochs):
        rows = [f"{stamp(t)},{x},{y}" for t, x, y in zip(T, X, Y, strict=True)]
        file.write_text("timestamp,pressure_bar,angle_deg\n" + "\n".join(rows))
        rec = read_log(file, "pressure", "angle")
        assert rec.time is not None
        np.testing.assert_allclose(rec.time, T, atol=1e-6)
        assert len(read_log(file, "pressure", "angle", start=1.0, stop=2.0)) == 20


def iso(t):
    total = 86398 + t
    day, rest = (1, total) if total < 86400 else (2, total - 86400)
    return (
        f"2024-05-{day:02d}T{int(rest // 3600):02d}:{int(rest % 3600 // 60):02d}:{rest % 60:06.3f}Z"
    )


@pytest.mark.parametrize(
    ("name", "factor"), [("time_ms", 1e3), ("time_us", 1e6), ("time [ns]", 1e9), ("t_min", 1 / 60)]
)
def test_time_in_other_units_becomes_seconds(tmp_path, name, factor):
    file = write_csv(tmp_path / "log.csv", {name: (T + 5) * factor, "x": X, "y": Y})
    rec = read_log(file, "x", "y")
    assert rec.time is not None
    np.testing.assert_allclose(rec.time, T + 5, rtol=1e-12)


def test_the_window_includes_its_start_and_excludes_its_stop(tmp_path):
    file = write_csv(tmp_path / "log.csv", {"time_s": T, "pressure_bar": X, "angle_deg": Y})
    rec = read_log(file, "pressure", "angle", start=0.5, stop=1.5)
    assert rec.time is not None
    assert (rec.time[0], rec.time[-1]) == (0.5, 1.45)
    assert rec.provenance["window"] == [0.5, 1.5]
    with pytest.raises(TimeError, match=r"covers from 0 s to 3\.95 s"):
        read_log(file, "pressure", "angle", start=100.0)
    with pytest.raises(TimeError, match="is empty"):
        read_log(file, "pressure", "angle", start=2.0, stop=1.0)
    with pytest.raises(TimeError):
        read_log(file, "pressure", "angle", start=float("nan"))


def test_a_column_is_found_by_name_by_case_without_unit_and_by_number(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text(table_text(header="time_s,Pressure_bar,angle [deg]"))
    for x in ("Pressure_bar", "pressure_BAR", "pressure", "#2"):
        for y in ("angle [deg]", "Angle", "#3"):
            check(file, x, y)


def test_an_unknown_or_ambiguous_column_is_refused_with_the_names(tmp_path):
    file = write_csv(tmp_path / "log.csv", {"time_s": T, "p_bar": X, "p_psi": X, "angle_deg": Y})
    with pytest.raises(ColumnError, match=r"any of p_bar, p_psi"):
        read_log(file, "p", "angle")
    with pytest.raises(ColumnError, match=r"Did you mean 'angle_deg'\?") as caught:
        read_log(file, "p_bar", "angel_deg")
    assert "p_psi" in str(caught.value)
    with pytest.raises(ColumnError, match="both column 'p_bar'"):
        read_log(file, "p_bar", "P_BAR")
    with pytest.raises(ColumnError):
        read_log(file, "p_bar", "#9")


def test_several_runs_must_be_named_and_are_kept_apart(tmp_path):
    file = tmp_path / "log.csv"
    rows = [
        f"{run},{t},{x + k},{y}"
        for k, run in enumerate(("up_1", "down_2"))
        for t, x, y in zip(T, X, Y, strict=True)
    ]
    file.write_text("run,time_s,pressure_bar,angle_deg\n" + "\n".join(rows))
    assert inspect_log(file).runs == {"up_1": 80, "down_2": 80}
    with pytest.raises(RunError, match=r"up_1 \(80 rows\), down_2 \(80 rows\)") as caught:
        read_log(file, "pressure", "angle")
    assert caught.value.facts["runs"] == {"up_1": 80, "down_2": 80}
    with pytest.raises(RunError, match="Did you mean 'down_2'"):
        read_log(file, "pressure", "angle", run="down2")
    rec = read_log(file, "pressure", "angle", run="down_2")
    np.testing.assert_array_equal(rec.input, X + 1)
    assert rec.provenance["run"] == "down_2"
    assert rec.provenance["first_row"] == 82
    with pytest.raises(ColumnError, match="holds text"):
        read_log(file, "run", "angle", run="up_1")


def test_runs_may_be_numbered(tmp_path):
    columns = {"trial": np.repeat([1, 2], 40), "time_s": np.tile(T[:40], 2), "x": X, "y": Y}
    file = write_csv(tmp_path / "log.csv", columns)
    assert inspect_log(file).runs == {"1": 40, "2": 40}
    np.testing.assert_array_equal(read_log(file, "x", "y", run="2").input, X[40:])


def test_a_run_is_refused_where_there_are_none(tmp_path):
    file = write_csv(tmp_path / "log.csv", {"time_s": T, "x": X, "y": Y})
    assert inspect_log(file).runs == {}
    with pytest.raises(RunError, match="does not tell runs apart"):
        read_log(file, "x", "y", run="a")


def test_written_signals_read_back_bit_for_bit(tmp_path):
    values = np.random.default_rng(1).normal(size=200) * 10.0 ** np.random.default_rng(2).integers(
        -30, 30, size=200
    )
    file = write_csv(tmp_path / "out.csv", {"time_s": np.arange(200) / 7, "angle_deg": values})
    signal = read_signal(file, "angle")
    assert signal.values.tobytes() == values.tobytes()
    assert signal.time is not None
    assert signal.time.tobytes() == (np.arange(200) / 7).tobytes()
    assert (signal.name, signal.unit) == ("angle", "deg")


def test_the_fingerprint_is_that_of_the_file(tmp_path):
    import hashlib

    file = tmp_path / "log.csv"
    file.write_text(table_text())
    provenance = read_log(file, "pressure", "angle").provenance
    assert provenance["sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
    assert provenance["file"] == "log.csv"
    assert provenance["rows"] == 80


def test_a_hundred_thousand_rows_are_read_without_a_loop_over_them(tmp_path):
    rng = np.random.default_rng(0)
    data = np.column_stack(
        [np.arange(100_000) / 1000, rng.normal(size=(100_000, 5)).cumsum(axis=0)]
    )
    file = tmp_path / "log.csv"
    np.savetxt(
        file,
        data,
        delimiter=",",
        fmt="%.6f",
        header="time_s,pressure_bar,angle_deg,a,b,c",
        comments="",
    )
    assert (
        lines_run(lambda: read_log(file, "pressure", "angle")) < 80_000
    )  # 38 000; 35 000 for a thousand rows


def test_a_nameless_index_or_a_date_beside_the_clock_is_not_taken_for_time(tmp_path):
    rows = [f"{k},{t},{x},{y}" for k, (t, x, y) in enumerate(zip(T, X, Y, strict=True))]
    (tmp_path / "log.csv").write_text(",time_s,pressure_bar,angle_deg\n" + "\n".join(rows))
    check(tmp_path / "log.csv")
    rows = [f"2024-05-01,12:00:{t:06.3f},{x},{y}" for t, x, y in zip(T, X, Y, strict=True)]
    (tmp_path / "log.csv").write_text("Date,Time,pressure_bar,angle_deg\n" + "\n".join(rows))
    rec = read_log(tmp_path / "log.csv", "pressure", "angle")
    np.testing.assert_allclose(rec.time, T, atol=1e-9)
    assert rec.findings == ()


def test_files_of_well_known_programs_are_read(tmp_path):
    rows = "\n".join(f"{t}\t{x}\t{y}\t" for t, x, y in zip(T, X, Y, strict=True))
    head = "LabVIEW Measurement\t\nDate\t2024/01/02\n***End_of_Header***\t\nX_Value\tpressure_bar\tangle_deg\tComment\n"
    (tmp_path / "labview.txt").write_text(head + rows)
    check(tmp_path / "labview.txt")
    text = "sep=;\n" + table_text(";", ",", header="Zeit (s),pressure (bar),angle (°)")
    (tmp_path / "excel.csv").write_bytes(text.encode("latin-1"))
    check(tmp_path / "excel.csv")


def test_quotes_keep_decimal_commas_apart_from_delimiters(tmp_path):
    file = tmp_path / "log.csv"
    rows = [
        ",".join(f'"{float(v)!r}"'.replace(".", ",") for v in row)
        for row in zip(T, X, Y, strict=True)
    ]
    file.write_text('"time_s","pressure_bar","angle_deg"\n' + "\n".join(rows))
    check(file)
    plain = [row.replace('"0,0"', "0") for row in rows]  # whole numbers need no quotes
    assert plain != rows
    file.write_text("time_s,pressure_bar,angle_deg\n" + "\n".join(plain))
    check(file)


@pytest.mark.parametrize(
    "text", ["time_s,pressure_bar,angle_deg\n", "t;p;phi\ns;bar;deg\n\n", "# log\nt\tp\tphi"]
)
def test_a_header_without_rows_is_called_that(tmp_path, text):
    file = tmp_path / "log.csv"
    file.write_text(text)
    with pytest.raises(LogError, match=r"has a header .* but no rows"):
        read_log(file, "p", "phi")


def test_the_time_column_is_no_signal(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text(table_text())
    for pair in (("time_s", "angle"), ("pressure", "time")):
        with pytest.raises(
            ColumnError, match=r"'time_s' of log.csv is its time column.*pressure_bar, angle_deg"
        ):
            read_log(file, *pair)
    with pytest.raises(ColumnError, match="is its time column"):
        read_signal(file, "#1")


def stamped(path, stamps, delimiter=";", skipped=slice(0)):
    x_y = [np.delete(values, skipped) for values in (X, Y)]
    rows = [
        delimiter.join((s, repr(float(x)), repr(float(y))))
        for s, x, y in zip(stamps, *x_y, strict=False)
    ]
    path.write_text(delimiter.join(("when", "pressure_bar", "angle_deg")) + "\n" + "\n".join(rows))
    return path


@pytest.mark.parametrize(
    "form",
    [
        "05.03.2024 12:00:{:06.3f}",
        "5.3.24 12:00:{:06.3f}",
        "03/05/2024 12:00:{:06.3f}",
        "05-03-2024 12:00:{:06.3f}",
        "2024/03/05 12:00:{:06.3f}",
        "3/5/2024 1:00:{:06.3f} PM",
    ],
)
@pytest.mark.parametrize("comma", [False, True])
def test_dates_with_the_year_last_are_time_stamps(tmp_path, form, comma):
    stamps = [form.format(float(t)) for t in T]
    stamps = [s[:-7] + s[-7:].replace(".", ",") if comma else s for s in stamps]
    rec = read_log(stamped(tmp_path / "log.csv", stamps), "pressure", "angle")
    assert rec.time is not None
    np.testing.assert_allclose(rec.time, T, atol=1e-6)
    assert rec.findings == ()


@pytest.mark.parametrize(
    ("days", "step", "codes"),
    [
        (["12/25/2024", "12/26/2024"], 86400.0, []),  # above 12: the month is first
        (["25/11/2024", "26/11/2024"], 86400.0, []),  # above 12: the day is first
        (["30/04/2024", "01/05/2024"], 86400.0, []),
        (["12/04/2024", "12/05/2024"], 86400.0, []),  # one day is likelier than one month
        (["11/04/2024", "12/04/2024"], 86400.0, []),
        (["01/01/2024", "02/02/2024"], 32 * 86400.0, ["date-order"]),
    ],
)
def test_day_or_month_first_is_told_by_the_numbers(tmp_path, days, step, codes):
    stamps = [f"{days[k >= 40]} 00:00:{0.1 * (k % 40):06.3f}" for k in range(80)]
    signal = read_signal(
        stamped(tmp_path / "log.csv", stamps, skipped=slice(40, 70)), "angle"
    )  # a day goes by
    assert signal.time is not None
    assert signal.time[40] == pytest.approx(step)
    assert [f.code for f in signal.findings if f.code == "date-order"] == codes


def test_midnight_and_noon_with_am_and_pm(tmp_path):
    stamps = [f"3/5/2024 {h}:00:00 {half}" for half in ("AM", "PM") for h in (12, *range(1, 12))]
    signal = read_signal(stamped(tmp_path / "log.csv", stamps), "angle")
    assert signal.time is not None
    np.testing.assert_array_equal(signal.time, 3600.0 * np.arange(24))


def test_a_column_called_micros_is_time_in_microseconds(tmp_path):
    file = tmp_path / "log.csv"
    write_csv(file, {"micros": np.round(T * 1e6), "pressure_bar": X, "angle_deg": Y})
    rec = read_log(file, "pressure", "angle")
    assert rec.time is not None
    np.testing.assert_allclose(rec.time, T, atol=1e-9)
    assert rec.findings == ()


def test_wide_logs_have_all_their_columns(tmp_path, columns=3000):
    file = tmp_path / "log.csv"
    names = ["time_s", *(f"ch{j}" for j in range(1, columns))]
    rows = [
        ",".join([f"{k * 0.05:.2f}", *(f"{(j * 7 + k * k) % 101 / 8}" for j in range(1, columns))])
        for k in range(30)
    ]
    file.write_text("\n".join([",".join(names), *rows]))
    rec = read_log(file, "ch1", names[-1])
    np.testing.assert_array_equal(
        rec.output, [((columns - 1) * 7 + k * k) % 101 / 8 for k in range(30)]
    )


MISSING = [
    "nan,nan,nan",
    ",,",
    "NaN,,-",
    "#N/A,#N/A,#N/A",
    "-,-,-",
    "nan,nan,nan\nnan,nan,nan",
    "-0.05,nan,nan",
]


@pytest.mark.parametrize("row", MISSING)
def test_a_first_row_without_values_is_not_the_header(tmp_path, row):
    file = tmp_path / "log.csv"
    lines = table_text().splitlines()
    file.write_text("\n".join([lines[0], row, *lines[1:]]))
    rec = read_log(file, "pressure", "angle")
    np.testing.assert_array_equal(rec.input, X)
    assert rec.input_unit == "bar"
    assert {f.code for f in rec.findings} <= {"non-finite"}
    assert rec.findings or row != MISSING[-1]


@pytest.mark.parametrize("path", [None, 3, b"log.csv", ["log.csv"]])
def test_what_is_no_path_is_refused_by_name(path):
    with pytest.raises(LogError, match="no path"):
        read_log(path, "x", "y")  # type: ignore[arg-type]
    with pytest.raises(ModelFileError, match="no path"):
        load(path)  # type: ignore[arg-type]


# Several columns of a log, row by row

BENCH = "time_s,length_mm,p_bar,F_N,run\n0,300,1,150,a\n1,290,1,,a\n2,280,2,160,a\n3,270,900,1,b\n"
ROLES = {"length": "length", "pressure": "p", "force": "F"}


@pytest.fixture
def bench(tmp_path):
    path = tmp_path / "bench.csv"
    path.write_text(BENCH)
    return path


def test_rows_with_a_number_in_every_column_are_kept_and_the_others_named(bench):
    found = read_columns(bench, ROLES, run="a")
    assert found.values["length"].tolist() == [300.0, 280.0]
    assert found.values["force"].tolist() == [150.0, 160.0]
    assert found.time.tolist() == [0.0, 2.0]
    assert dict(found.units) == {"length": "mm", "pressure": "bar", "force": "N"}
    assert [finding.code for finding in found.findings] == ["non-finite"]
    assert found.provenance["force"] == "F_N" and found.provenance["rows"] == 2


def test_a_point_of_a_table_is_no_outlier(tmp_path):
    path = tmp_path / "map.csv"
    values = np.r_[np.zeros(50), 1e4, np.zeros(50)]
    path.write_text("x,y\n" + "".join(f"{k},{v}\n" for k, v in enumerate(values)))
    assert read_columns(path, {"a": "x", "b": "y"}).values["b"].max() == 1e4


def test_a_window_cuts_in_the_log_s_own_time(bench):
    cut = read_columns(bench, {"length": "length"}, run="a", start=1.0, stop=2.5)
    assert cut.values["length"].tolist() == [290.0, 280.0]
    with pytest.raises(TimeError, match="no sample"):
        read_columns(bench, ROLES, run="a", start=50.0)


def test_wrong_names_twice_the_same_and_empty_logs_are_refused(bench, tmp_path):
    with pytest.raises(ColumnError, match="Did you mean 'length_mm'"):
        read_columns(bench, {"length": "lenght_mm"}, run="a")
    with pytest.raises(ColumnError, match="force and pressure are both column 'F_N'"):
        read_columns(bench, {"force": "F", "pressure": "F_N"}, run="a")
    empty = tmp_path / "empty.csv"
    empty.write_text("x;y\n1;\n;2\n3;\n;4\n")
    with pytest.raises(RecordingError, match="both numbers"):
        read_columns(empty, {"a": "x", "b": "y"})
