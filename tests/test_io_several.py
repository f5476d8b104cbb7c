"""Several columns of a log, row by row: what is read, left out, and refused."""

import numpy as np
import pytest

from dehyst.errors import ColumnError, RecordingError, TimeError
from dehyst.io.logs import read_columns

LOG = "time_s,length_mm,p_bar,F_N,run\n0,300,1,150,a\n1,290,1,,a\n2,280,2,160,a\n3,270,900,1,b\n"
ALL = {"length": "length", "pressure": "p", "force": "F"}


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "bench.csv"
    path.write_text(LOG)
    return path


def test_rows_with_a_number_in_every_column_are_kept_and_the_others_named(log):
    found = read_columns(log, ALL, run="a")
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


def test_a_window_cuts_in_the_log_s_own_time(log):
    assert read_columns(log, {"length": "length"}, run="a", start=1.0, stop=2.5).values["length"].tolist() == [
        290.0,
        280.0,
    ]
    with pytest.raises(TimeError, match="no sample"):
        read_columns(log, ALL, run="a", start=50.0)


def test_wrong_names_twice_the_same_and_empty_logs_are_refused(log, tmp_path):
    with pytest.raises(ColumnError, match="Did you mean 'length_mm'"):
        read_columns(log, {"length": "lenght_mm"}, run="a")
    with pytest.raises(ColumnError, match="force and pressure are both column 'F_N'"):
        read_columns(log, {"force": "F", "pressure": "F_N"}, run="a")
    empty = tmp_path / "empty.csv"
    empty.write_text("x;y\n1;\n;2\n3;\n;4\n")
    with pytest.raises(RecordingError, match="both numbers"):
        read_columns(empty, {"a": "x", "b": "y"})
