"""Cells that could be read in two ways, or hardly: separators of thousands, text among numbers, cells with a unit."""

import numpy as np
import pytest

from dehyst.errors import ColumnError
from dehyst.io import inspect_log, read_log

N = 80
PRESSURE = np.round(1000 + 400 * np.sin(np.arange(N) / 6.0)).astype(
    int
)  # mbar, on both sides of 1000
ANGLE = np.round(10 * np.sin(np.arange(N) / 6.0 - 0.3), 2)


def log(folder, pressures, decimal=",", delimiter=";", quote=""):
    """A log whose time and angle show its decimal sign."""
    rows = [
        delimiter.join(
            quote + cell + quote
            for cell in (
                f"{k * 0.05:.2f}".replace(".", decimal),
                p,
                f"{a:.2f}".replace(".", decimal),
            )
        )
        for k, (p, a) in enumerate(zip(pressures, ANGLE, strict=True))
    ]
    file = folder / "log.csv"
    file.write_text("\n".join([delimiter.join(["time_s", "pressure_mbar", "angle_deg"]), *rows]))
    return file


def grouped(values, mark):
    return [f"{value:,}".replace(",", mark) for value in values.tolist()]


@pytest.mark.parametrize(
    ("decimal", "mark", "delimiter", "quote"),
    [
        (",", ".", ";", ""),
        (".", ",", ";", ""),
        (",", ".", "\t", ""),
        (".", ",", "\t", ""),
        (".", ",", ",", '"'),
    ],
)
def test_whole_numbers_that_pass_a_thousand_keep_their_size(
    tmp_path, decimal, mark, delimiter, quote
):
    rec = read_log(
        log(tmp_path, grouped(PRESSURE, mark), decimal, delimiter, quote), "pressure", "angle"
    )
    np.testing.assert_array_equal(rec.input, PRESSURE)
    np.testing.assert_array_equal(rec.output, ANGLE)
    [finding] = rec.findings
    assert finding.code == "thousands-separator"
    first = int(np.flatnonzero(PRESSURE >= 1000)[0])
    assert f"lines {first + 2}, " in finding.message
    assert f"{grouped(PRESSURE, mark)[first]} is {PRESSURE[first]}" in finding.message


def test_thousands_that_begin_late_in_the_log_are_found(tmp_path):
    rows = [f"0,{k:03d};{800 + k % 100};{k % 7},5" for k in range(300)]
    rows += [
        f"0,{k:03d};{f'{950 + k % 100:,}'.replace(',', '.')};{k % 7},5" for k in range(300, 400)
    ]
    (tmp_path / "log.csv").write_text("time_s;p_mbar;angle_deg\n" + "\n".join(rows))
    rec = read_log(tmp_path / "log.csv", "p", "angle")
    assert (rec.input.min(), rec.input.max()) == (800, 1049)


@pytest.mark.parametrize(("decimal", "mark"), [(",", "."), (".", ",")])
def test_two_separators_in_one_number_leave_no_doubt(tmp_path, decimal, mark):
    values = 1_000_000 + 1000 * PRESSURE
    rec = read_log(log(tmp_path, grouped(values, mark), decimal), "pressure", "angle")
    np.testing.assert_array_equal(rec.input, values)


@pytest.mark.parametrize(("decimal", "mark"), [(",", "."), (".", ",")])
def test_a_column_that_can_be_read_in_two_ways_is_refused(tmp_path, decimal, mark):
    file = log(tmp_path, grouped(PRESSURE + 3000, mark), decimal)
    with pytest.raises(ColumnError, match="two ways") as caught:
        read_log(file, "pressure", "angle")
    value = int(PRESSURE[0]) + 3000
    assert f"is {value} if" in str(caught.value)
    assert f"{value / 1000:.3f} if" in str(caught.value)
    assert caught.value.facts["column"] == "pressure_mbar"
    assert "not-readable" in [finding.code for finding in inspect_log(file).findings]


def test_a_refused_column_does_not_spoil_the_others(tmp_path):
    file = tmp_path / "log.csv"
    rows = [
        f"{k * 0.05:.2f};{3 + k % 7}.169;{k % 5}.5;{k % 9}.25".replace(".", ",") for k in range(N)
    ]
    rows = [row.replace(",169", ".169") for row in rows]
    file.write_text("time_s;odd;x;y\n" + "\n".join(rows))
    assert "thousands-separator" not in [
        finding.code for finding in read_log(file, "x", "y").findings
    ]
    with pytest.raises(ColumnError, match="two ways"):
        read_log(file, "odd", "y")


@pytest.mark.parametrize(
    ("delimiter", "decimal"), [(",", "."), ("\t", "."), (";", "."), (" ", "."), (";", ",")]
)
def test_three_decimals_are_no_thousands(tmp_path, delimiter, decimal):
    cells = [f"{value / 1000 + 1:.3f}".replace(".", decimal) for value in PRESSURE.tolist()]
    rec = read_log(log(tmp_path, cells, decimal, delimiter), "pressure", "angle")
    np.testing.assert_allclose(rec.input, PRESSURE / 1000 + 1, rtol=1e-12)
    assert rec.findings == ()


def test_a_number_below_one_shows_that_the_column_has_decimals(tmp_path):
    cells = [f"{value / 1000:.3f}" for value in PRESSURE.tolist()]
    rec = read_log(log(tmp_path, cells, ","), "pressure", "angle")
    np.testing.assert_allclose(rec.input, PRESSURE / 1000, rtol=1e-12)


def bracketed(values, decimal):
    return [
        (f"{v:.2f}" if v >= 0 else f"({-v:.2f})").replace(".", decimal) for v in values.tolist()
    ]


@pytest.mark.parametrize("decimal", [".", ","])
def test_numbers_in_brackets_are_negative(tmp_path, decimal):
    force = np.round(5 * np.cos(np.arange(N) / 6.0 + 2.0), 2)  # begins with a negative
    rec = read_log(log(tmp_path, bracketed(force, decimal), decimal), "pressure", "angle")
    np.testing.assert_array_equal(rec.input, force)
    [finding] = rec.findings
    assert finding.code == "bracketed-negatives"
    assert f"line{'s'} 2, 3, " in finding.message


@pytest.mark.parametrize("other", ["OL", "-1.5"])
def test_brackets_beside_other_text_or_a_minus_sign_are_refused(tmp_path, other):
    cells = bracketed(np.round(1 + 5 * np.cos(np.arange(N) / 6.0 + 2.0), 2), ".")
    cells[7] = other
    with pytest.raises(
        ColumnError, match=r"text in \d+ of 80 cells, such as '\(1\.08\)' \(line 2\) and '"
    ) as caught:
        read_log(log(tmp_path, cells, "."), "pressure", "angle")
    assert "plain numbers" in str(caught.value)


@pytest.mark.parametrize(("every", "refused"), [(8, True), (20, False)])
def test_a_column_with_much_text_is_refused_and_one_with_little_loses_rows(
    tmp_path, every, refused
):
    cells = ["sensor off" if k % every == 3 else str(v) for k, v in enumerate(PRESSURE.tolist())]
    file = log(tmp_path, cells, ".")
    if refused:
        with pytest.raises(ColumnError, match="'sensor off'"):
            read_log(file, "pressure", "angle")
    else:
        rec = read_log(file, "pressure", "angle")
        assert rec.input.size == N - 4
        assert [finding.code for finding in rec.findings] == ["non-finite"]


def test_empty_and_missing_cells_are_no_text(tmp_path):
    cells = [
        "" if k % 4 == 3 else "NaN" if k % 4 == 2 else str(v)
        for k, v in enumerate(PRESSURE.tolist())
    ]
    rec = read_log(log(tmp_path, cells, "."), "pressure", "angle")
    assert rec.input.size == N // 2


@pytest.mark.parametrize("blank", [" ", ""])
@pytest.mark.parametrize(("decimal", "delimiter"), [(".", ","), (",", ";"), (".", "\t")])
def test_units_in_the_cells_are_taken_from_there(tmp_path, decimal, delimiter, blank):
    cells = [f"{v / 1000:.2f}{blank}bar".replace(".", decimal) for v in PRESSURE.tolist()]
    file = log(tmp_path, cells, decimal, delimiter)
    file.write_text(file.read_text().replace("pressure_mbar", "pressure"))
    rec = read_log(file, "pressure", "angle")
    np.testing.assert_array_equal(rec.input, [float(f"{v / 1000:.2f}") for v in PRESSURE.tolist()])
    assert rec.input_unit == "bar"
    assert [finding.code for finding in rec.findings] == ["unit-in-cells"]


def test_units_that_contradict_the_header_are_refused(tmp_path):
    file = log(tmp_path, [f"{v / 1000:.2f} bar" for v in PRESSURE.tolist()], ".")
    with pytest.raises(ColumnError, match="mbar by its header and in bar by its cells"):
        read_log(file, "pressure", "angle")


def test_units_that_change_from_cell_to_cell_are_refused(tmp_path):
    cells = [f"{v / 1000:.2f} bar" if v > 1000 else f"{v} mbar" for v in PRESSURE.tolist()]
    with pytest.raises(ColumnError, match="text"):
        read_log(log(tmp_path, cells, "."), "pressure", "angle")


def test_values_with_units_may_be_names(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text("0 bar,2 bar\n" + "\n".join(f"{k % 13},{(k - 2) % 13}" for k in range(60)))
    rec = read_log(file, "0 bar", "2 bar")
    assert len(rec) == 60
