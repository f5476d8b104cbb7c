"""Tables in the layouts of loggers, spreadsheets and scripts: the truth is read, or something is said."""

import importlib.util

import numpy as np
import pytest

from dehyst.errors import LogError
from dehyst.io import inspect_log, read_log, read_signal, read_table
from table_layouts import ANGLE, FLOW, PRESSURE, ROWS, SECONDS, judge, layouts, make

WORKBOOKS = (
    importlib.util.find_spec("python_calamine") is not None
    and importlib.util.find_spec("openpyxl") is not None
)
LAYOUTS = layouts(WORKBOOKS)
# Every word of these layouts can be told: no finding about names, and no refusal.
PLAIN = ("semicolon", "tab", "pipe", "xlsx")
DOUBTFUL = ("one-short", "two-more-cells")


def judged(chosen, folder):
    cases = (make(*layout) for layout in chosen)
    return {case.name: judge(case, folder) for case in cases}


def wrong(verdicts):
    return {
        name: verdict
        for name, verdict in verdicts.items()
        if verdict != "right" and not verdict.startswith("said")
    }


def test_no_layout_is_read_wrongly_without_a_word(tmp_path):
    assert not wrong(judged(LAYOUTS[::197], tmp_path))


@pytest.mark.exhaustive
def test_none_of_2800_layouts_is_read_wrongly_without_a_word(tmp_path):
    verdicts = judged(LAYOUTS, tmp_path)
    assert not wrong(verdicts)
    sure = [
        name
        for name in verdicts
        if name.startswith(PLAIN) and not any(kind in name for kind in DOUBTFUL)
    ]
    assert len(sure) > 1000 and {name for name in sure if verdicts[name] != "right"} == set()
    assert sum(verdict == "right" for verdict in verdicts.values()) >= 0.95 * len(verdicts)


@pytest.mark.parametrize("delimiter", ["tab", "semicolon", "pipe", "comma", "xlsx"])
@pytest.mark.parametrize("stamps", ["iso-blank", "german"])
def test_a_stamp_with_a_blank_moves_no_column(tmp_path, delimiter, stamps):
    if delimiter == "xlsx" and not WORKBOOKS:
        pytest.skip("no package for spreadsheets")
    case = make(delimiter, ".", stamps, "two-words", "lf", False, False)
    path = tmp_path / f"log{case.ending}"
    path.write_bytes(case.data)
    rec = read_log(path, "pressure_bar", "angle_deg")
    assert np.array_equal(rec.input, PRESSURE) and np.array_equal(rec.output, ANGLE)
    assert np.array_equal(read_signal(path, "ambient flow").values, FLOW)
    assert (rec.input_unit, rec.output_unit) == ("bar", "deg")
    np.testing.assert_allclose(rec.time - rec.time[0], SECONDS, atol=2e-6)


def test_in_parts_the_columns_are_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr("dehyst.io._long.WHOLE_BYTES", 0)
    path = tmp_path / "log.tsv"
    path.write_bytes(make("tab", ".", "iso-blank", "two-words", "lf", False, False).data)
    rec = read_log(path, "pressure_bar", "angle_deg")
    assert np.array_equal(rec.input, PRESSURE) and np.array_equal(rec.output, ANGLE)
    np.testing.assert_allclose(rec.time - rec.time[0], SECONDS, atol=2e-6)
    path.write_bytes(make("blank", ".", "iso-blank", "one-line", "lf", False, False).data)
    monkeypatch.setattr("dehyst.io._long.SIZE_LIMIT", 0)
    with pytest.raises(LogError, match="too long to be read at once"):
        read_log(path, "pressure_bar", "angle_deg")


# Names that do not fit


def body(*columns, mark=","):
    return "\n".join(mark.join(row) for row in zip(*columns, strict=True)) + "\n"


T = [f"{t:.2f}" for t in SECONDS]
X = [f"{x:.3f}" for x in PRESSURE]
Y = [f"{y:.4f}" for y in ANGLE]
COUNT = [str(k) for k in range(ROWS)]


def saved(folder, text):
    path = folder / "log.csv"
    path.write_text(text)
    return path


def finding(path, code):
    return next((found.message for found in read_table(path).findings if found.code == code), "")


def test_an_index_without_a_name_shifts_no_name(tmp_path):
    for first in (COUNT, [f"run {k}" for k in COUNT]):
        path = saved(tmp_path, "time_s,pressure_bar,angle_deg\n" + body(first, T, X, Y))
        rec = read_log(path, "pressure", "angle")
        assert np.array_equal(rec.input, PRESSURE) and np.array_equal(rec.time, SECONDS)
        assert "3 names" in finding(path, "header-width") and "4 cells" in finding(
            path, "header-width"
        )


def test_rows_that_are_counted_are_no_time(tmp_path):
    rec = read_log(
        saved(tmp_path, "pressure_bar,angle_deg\n" + body(COUNT, X, Y)), "pressure", "angle"
    )
    assert rec.time is None and "no-time" in [found.code for found in rec.findings]
    rec = read_log(
        saved(tmp_path, ",pressure_bar,angle_deg\n" + body(COUNT, X, Y)), "pressure", "angle"
    )
    assert rec.time is None


def test_columns_beside_the_named_ones_move_no_name(tmp_path):
    zero = ["0.0"] * ROWS
    for beside in (zero, ["OK"] * ROWS, [""] * ROWS, ["OK", "WARN"] * (ROWS // 2)):
        path = saved(tmp_path, "Sample,Time,Voltage,Stroke\n" + body(COUNT, T, X, Y, beside, zero))
        rec = read_log(path, "Voltage", "Stroke")
        assert np.array_equal(rec.input, PRESSURE) and np.array_equal(rec.time, SECONDS)
        assert "4 names (Sample, Time, Voltage, Stroke)" in finding(path, "header-width")


def test_names_that_nothing_places_are_not_used_and_the_cure_reads_the_log(tmp_path):
    path = saved(tmp_path, "time,Inlet,Outlet\n" + body(T, X, Y, Y, X))
    said = finding(path, "header-width")
    assert "cannot be told" in said and "--input column_4 --output column_5" in said
    rec = read_log(path, "column_4", "column_5")
    assert np.array_equal(rec.input, ANGLE) and np.array_equal(rec.output, PRESSURE)
    cured = saved(tmp_path, "time,a,b,c,d\n" + body(T, X, Y, Y, X))
    assert not finding(cured, "header-width")


@pytest.mark.parametrize(
    "head",
    [
        "Test rig 3\nOperator N. N.\n\n",
        "# the valve was readjusted here\n",
        "# valve 3, set by N. N.\n",
        "Report 3,,\n",
        "***End_of_Header***\n",
        "",
    ],
)
def test_prose_and_titles_are_no_names_and_not_spoken_of(tmp_path, head):
    path = saved(tmp_path, head + body(T, X, Y))
    table = read_table(path)
    assert table.order == ("column_1", "column_2", "column_3") and not table.findings
    assert np.array_equal(read_log(path, "column_2", "column_3").time, SECONDS)


# Units, groups, preambles


@pytest.mark.parametrize(
    "units", ["s,m3/h,%", "s,rpm,%", "[s],[1/min],[-]", "hh:mm:ss,l/min,N/mm", ",m3/h,%"]
)
def test_a_row_of_units_is_no_header(tmp_path, units):
    path = saved(tmp_path, f"time,flow,opening\n{units}\n" + body(T, X, Y))
    table = read_table(path)
    assert table.order == ("time", "flow", "opening")
    assert table.label("flow")[1] == units.split(",")[1].strip("[]")


@pytest.mark.parametrize(
    ("head", "names"),
    [
        ("t,u,y\n", ["t", "u", "y"]),
        ("Raw,Raw,Adjusted\nField,Moment,Moment\n", ["Raw Field", "Raw Moment", "Adjusted Moment"]),
        (
            "  Raw    Raw    Adjusted \n  Field   Moment  Moment\n",
            ["Raw Field", "Raw Moment", "Adjusted Moment"],
        ),
        ("A,,B\nx,y,x\n", ["A x", "A y", "B x"]),
        ("Report 3,,\nRate,1000,\nGain,3,\n,,\nt,u,y\n", ["t", "u", "y"]),
        ("time,101,102\n", ["time", "101", "102"]),
    ],
)
def test_the_line_that_names_the_columns_is_the_header(tmp_path, head, names):
    table = read_table(saved(tmp_path, head + body(T, X, Y)))
    assert list(table.order) == names and len(table.rows) == ROWS


def test_a_preamble_below_a_text_column_is_no_data(tmp_path):
    head = "Rate,1000,,\nGain,3,,\n\nlabel,time_s,pressure,angle\n"
    table = read_table(saved(tmp_path, head + body(["a"] * ROWS, T, X, Y)))
    assert table.order == ("label", "time_s", "pressure", "angle") and len(table.rows) == ROWS


def test_a_first_row_with_a_failed_sensor_is_data(tmp_path):
    table = read_table(saved(tmp_path, "t,u,y\n0.0,ERR,1.0\n" + body(T, X, Y)))
    assert table.order == ("t", "u", "y") and len(table.rows) == ROWS + 1


# Commas that part cells and mark decimals


def test_commas_are_told_apart_by_the_number_of_names_or_refused(tmp_path):
    both = body(*([cell.replace(".", ",") for cell in column] for column in (T, X, Y)))
    path = saved(tmp_path, "time_s,pressure_bar,angle_deg\n" + both)
    rec = read_log(path, "pressure", "angle")
    assert np.array_equal(rec.input, PRESSURE) and np.array_equal(rec.output, ANGLE)
    assert np.array_equal(rec.time, SECONDS)
    assert "3 names" in finding(path, "comma-twice")
    with pytest.raises(LogError, match=r"two ways.* 0 \| 00 \| 1 \| 330 .* 0,00 \| 1,330 \|"):
        read_table(saved(tmp_path, both))
    rows = "\n".join(
        ", ".join(cells)
        for cells in ([c.replace(".", ",") for c in r] for r in zip(T, X, Y, strict=True))
    )
    path = saved(tmp_path, rows)  # a blank after each comma that parts cells
    assert np.array_equal(read_log(path, "column_2", "column_3").input, PRESSURE)
    assert finding(path, "comma-twice")


def test_whole_numbers_between_commas_stay_what_they_are(tmp_path):
    counts = [str(37 * k % 1024) for k in range(ROWS)]
    padded = [f"{91 * k % 1024:04d}" for k in range(ROWS)]
    path = saved(tmp_path, body(COUNT, counts, counts[::-1]))
    assert read_table(path).columns["column_2"][1] == 37.0
    path = saved(tmp_path, "n,a,b\n" + body(COUNT, counts, padded))
    assert read_table(path).columns["b"][1] == 91.0


# Time without a name


@pytest.mark.parametrize(
    ("columns", "clock"),
    [
        ((T, X, Y), "column_1"),
        (([""] * ROWS, T, X, Y), "column_2"),
        ((COUNT, T, X, Y), "column_2"),
        ((X, Y, T), "column_3"),
        (([T[k - k % 2] for k in range(ROWS)], X, Y), "column_1"),
        ((X, Y), None),
    ],
)
def test_time_without_a_name_is_found_wherever_it_stands(tmp_path, columns, clock):
    path = saved(tmp_path, body(*columns))
    x, y = (f"column_{1 + columns.index(column)}" for column in (X, Y))
    rec = read_log(path, x, y)
    assert rec.provenance["time"] == clock
    assert rec.time is None if clock is None else abs(rec.time[-1] - SECONDS[-1]) < 0.3


# Text that is no table

PAIRS = list(zip(PRESSURE.tolist(), ANGLE.tolist(), strict=True))
LISTS = {
    "python": str([list(pair) for pair in PAIRS]),
    "mathematica": str(PAIRS)
    .replace("[", "{")
    .replace("]", "}")
    .replace("(", "{")
    .replace(")", "}"),
    "numpy": str(np.array(PAIRS)),
    "repr": repr(np.array(PAIRS)),
    "json": '{"x": ' + str(PRESSURE.tolist()) + ', "y": ' + str(ANGLE.tolist()) + "}",
    "json, indented": "[\n" + ",\n".join(f"  [\n    {x},\n    {y}\n  ]" for x, y in PAIRS) + "\n]",
    "json lines": "\n".join(f'{{"x": {x}, "y": {y}}}' for x, y in PAIRS),
    "matlab": f"x = {PRESSURE.tolist()};\ny = {ANGLE.tolist()};".replace(",", ""),
    "matlab matrix": "A = [\n" + "\n".join(f"{x} {y}" for x, y in PAIRS) + "\n];",
}


@pytest.mark.parametrize("writing", LISTS)
def test_lists_in_brackets_are_called_that(tmp_path, writing):
    with pytest.raises(LogError, match="holds a list in brackets"):
        read_table(saved(tmp_path, LISTS[writing]))


@pytest.mark.parametrize(
    "head", ['{"rig": 3}\n', "[Settings]\nRate=10\n[Data]\n", "Range = [0 10]\n"]
)
def test_brackets_above_a_table_do_not_matter(tmp_path, head):
    assert read_table(saved(tmp_path, head + "t,u,y\n" + body(T, X, Y))).order == ("t", "u", "y")


@pytest.mark.parametrize("first", [True, False])
def test_signals_in_rows_are_called_that(tmp_path, first):
    rows = [",".join([name] * first + column) for name, column in (("x", X), ("y", Y))]
    with pytest.raises(LogError, match="its signals stand in rows"):
        read_table(saved(tmp_path, "\n".join(rows)))


def test_outlines_of_a_text_editor_are_passed_over(tmp_path):
    rows = "\n".join(f"| {x} | {y} |" for x, y in zip(X, Y, strict=True))
    for text in (
        f"| x | y |\n|---|:--|\n{rows}",
        f"+---+---+\n| x | y |\n+---+---+\n{rows}\n+---+---+\n",
    ):
        table = read_table(saved(tmp_path, text))
        assert table.order == ("x", "y") and not table.findings
        assert np.array_equal(table.columns["x"], PRESSURE)
        assert inspect_log(tmp_path / "log.csv").command.endswith("--input x --output y")


def test_too_many_columns_are_refused_before_they_are_read(tmp_path):
    row = ",".join(["0.5"] * 20_001)
    with pytest.raises(LogError, match=r'20001 columns.*cut -d "," -f1,2,3'):
        read_table(saved(tmp_path, "\n".join([row] * 12)))
