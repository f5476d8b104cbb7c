"""Data frames become recordings as files do, and recordings data frames."""

import numpy as np
import pandas
import polars
import pyarrow
import pytest

import dehyst
from dehyst.errors import ColumnError, LogError, MissingExtraError

T = np.arange(200) * 0.01
COLUMNS = {"time_s": T, "p [bar]": np.sin(3 * T), "angle_deg": np.sin(3 * T - 0.2)}
FRAMES = {
    "pandas": pandas.DataFrame,
    "polars": polars.DataFrame,
    "lazy": lambda columns: polars.DataFrame(columns).lazy(),
    "pyarrow": pyarrow.table,
}


@pytest.mark.parametrize("kind", FRAMES)
def test_a_frame_gives_the_recording_of_its_columns(kind):
    rec = dehyst.Recording.from_frame(FRAMES[kind](COLUMNS), input="p", output="angle")
    np.testing.assert_array_equal(rec.input, COLUMNS["p [bar]"])
    np.testing.assert_array_equal(rec.output, COLUMNS["angle_deg"])
    np.testing.assert_array_equal(rec.time, T)
    assert (rec.input_label, rec.output_label) == ("p [bar]", "angle [deg]")
    assert len(rec.provenance["sha256"]) == 64


@pytest.mark.parametrize("backend", ["pandas", "polars", "pyarrow"])
def test_a_recording_goes_to_a_frame_and_back_bit_for_bit(backend):
    rec = dehyst.Recording(
        COLUMNS["p [bar]"], COLUMNS["angle_deg"], T, input_unit="bar", output_unit="deg"
    )
    back = dehyst.Recording.from_frame(rec.to_frame(backend), input="input", output="output")
    for name in ("input", "output", "time"):
        np.testing.assert_array_equal(getattr(rec, name), getattr(back, name))


@pytest.mark.parametrize("zone", [None, "Europe/Vienna"])
def test_an_index_of_dates_is_the_clock(zone):
    stamps = pandas.date_range("2024-03-05 12:00", periods=200, freq="10ms", tz=zone)
    frame = pandas.DataFrame({"p": COLUMNS["p [bar]"], "angle": COLUMNS["angle_deg"]}, index=stamps)
    rec = dehyst.read_log(frame, "p", "angle", start=0.5)
    np.testing.assert_allclose(np.diff(rec.time), 0.01, atol=1e-6)
    assert len(rec) == 150


@pytest.mark.parametrize("kind", ["pandas", "polars"])
def test_missing_values_and_texts_of_a_frame_are_cured_as_those_of_a_file(kind):
    frame = FRAMES[kind](
        {**COLUMNS, "run": ["a"] * 200, "p [bar]": [None, *COLUMNS["p [bar]"][1:]]}
    )
    rec = dehyst.read_log(frame, "p", "angle", run="a")
    assert len(rec) == 199 and "non-finite" in [finding.code for finding in rec.findings]


def test_inspect_looks_at_a_frame():
    summary = dehyst.inspect_log(pandas.DataFrame(COLUMNS))
    assert (
        summary.input == "p [bar]"
        and "from_frame(df, input='p [bar]', output='angle_deg')" in summary.command
    )


def test_a_frame_without_the_column_says_which_it_has():
    with pytest.raises(ColumnError, match=r"p \[bar\].* they hold: dehyst\.inspect_log\(df\)"):
        dehyst.Recording.from_frame(pandas.DataFrame(COLUMNS), input="pressure", output="angle")


class Odd:
    columns = 3


def test_what_is_no_frame_is_refused_with_what_to_type():
    with pytest.raises(LogError, match=r"dehyst\.Recording\(input=u"):
        dehyst.read_log(Odd(), "p", "angle")
    with pytest.raises(LogError, match="a Series cannot be read as a table"):
        dehyst.read_log(pandas.Series([0.0, 1.0, 2.0], index=[0.0, 0.1, 0.2]), "p", "angle")


def test_a_backend_that_is_none_is_refused_with_those_that_are():
    rec = dehyst.Recording([0.0, 1, 2, 1], [0.0, 1, 3, 2])
    with pytest.raises(MissingExtraError, match=r"to_frame\('pandas'\)"):
        rec.to_frame("excel")
