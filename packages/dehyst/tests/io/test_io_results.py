"""Results written for other tools: MCAP runs and tables."""

import csv
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.errors import MissingExtraError, OutputError
from dehyst.io import read_table, write_mcap
from dehyst.io._write import write_table
from effort import lines_run

RNG = np.random.default_rng(7)
T = np.arange(200) * 5e-4


@pytest.fixture(autouse=True, scope="module")
def _ros():
    pytest.importorskip("rosbags", reason="the extra dehyst[ros] is not installed")


def channels():
    arm = {f"angle_{k}_rad": RNG.normal(size=T.size) for k in range(1, 8)}
    special = np.tile([0.0, -0.0, np.nan, np.inf, -np.inf, 5e-324, 1.7976931348623157e308, 0.1], 5)
    return {
        "joint_1": (
            T,
            {"angle_rad": RNG.normal(size=T.size), "pressure_1_bar": RNG.normal(size=T.size)},
        ),
        "joint_2": (
            T,
            {"angle_rad": RNG.normal(size=T.size), "pressure_1_bar": RNG.normal(size=T.size)},
        ),
        "arm/Log": (T, arm),
        "special": (np.arange(40) * 0.1 + 1 / 3, {"value": special}),
    }


def test_a_run_reads_back_bit_for_bit_with_our_own_reader(tmp_path):
    written = channels()
    table = read_table(write_mcap(tmp_path / "run.mcap", written))
    expected = {}
    for name, (t, columns) in written.items():
        for column, values in {"time_s": t, **columns}.items():
            expected[f"/{name}.{column}"] = np.asarray(values)
    assert {name for name in table.columns if not name.endswith("bag_time")} == set(expected)
    for name, values in expected.items():
        assert table.columns[name].tobytes() == values.tobytes(), name
        assert table.clocks[name] == f"{name.rpartition('.')[0]}.bag_time"
    assert np.array_equal(table.columns["/joint_1.bag_time"], np.round(T * 1e9))


def test_a_run_is_a_sound_mcap_file_to_its_own_reference_reader(tmp_path):
    reader = pytest.importorskip("mcap.reader", reason="the package mcap is not installed")
    written = channels()
    found = {}
    with write_mcap(tmp_path / "run.mcap", written).open("rb") as stream:
        bag = reader.make_reader(stream, validate_crcs=True)
        summary = bag.get_summary()
        for schema, channel, message in bag.iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            names = [line.split()[1] for line in schema.data.decode().splitlines()]
            # CDR: four bytes of header, then doubles that are aligned without padding.
            assert message.data[:4] == b"\0\1\0\0"
            numbers = np.frombuffer(message.data[4:], dtype="<f8")
            found.setdefault(channel.topic, []).append(
                (message.log_time, dict(zip(names, numbers, strict=True)))
            )
    assert summary.statistics.message_count == 3 * T.size + 40
    assert len(summary.schemas) == 3  # joints 1 and 2 share one
    for name, (t, columns) in written.items():
        messages = found[f"/{name}"]
        assert [stamp for stamp, _ in messages] == np.round(np.asarray(t) * 1e9).astype(
            int
        ).tolist()
        for column, values in columns.items():
            assert (
                np.array([row[column] for _, row in messages]).tobytes()
                == np.asarray(values).tobytes()
            )


def test_time_below_zero_moves_the_stamps_of_all_channels_alike(tmp_path):
    late, early = np.array([0.0, 1.0]), np.array([-2.0, -1.0])
    table = read_table(
        write_mcap(tmp_path / "a.mcap", {"a": (late, {"x": late}), "b": (early, {"x": early})})
    )
    assert table.columns["/a.bag_time"].tolist() == [2e9, 3e9] and table.columns[
        "/b.bag_time"
    ].tolist() == [0, 1e9]
    assert np.array_equal(table.columns["/b.time_s"], early)


def test_a_row_of_thirty_columns_is_written_without_a_loop_over_them(tmp_path):
    t = np.arange(10_000) * 5e-4
    columns = {f"column_{k}": RNG.normal(size=t.size) for k in range(30)}
    lines = lines_run(lambda: write_mcap(tmp_path / "a.mcap", {"joint_1": (t, columns)}))
    assert lines < 85 * t.size  # 49, those of the package rosbags among them


@pytest.mark.parametrize(
    "bad",
    [
        {},
        {"": (T, {})},
        {"joint 1": (T, {"x": T})},
        {"a": (T, {"dp [bar]": T})},
        {"a": (T, {"x__y": T})},
        {"a": (T, {"lambda": T})},
        {"a": (T, {"time_s": T})},
        {"a": (T, {"x": T[:-1]})},
        {"a": (T[:, None], {"x": T[:, None]})},
        {"a": (np.where(T > 0.05, np.nan, T), {"x": T})},
        {"a": (T * 1e15, {"x": T})},
    ],
)
def test_what_cannot_be_a_channel_is_refused_and_nothing_written(tmp_path, bad):
    with pytest.raises(OutputError):
        write_mcap(tmp_path / "a.mcap", bad)
    with pytest.raises(OutputError):
        write_mcap(tmp_path / "nowhere" / "a.mcap", {"a": (T, {"x": T})})
    assert not list(tmp_path.iterdir())


def test_without_its_package_the_error_names_the_extra_and_another_way(tmp_path, monkeypatch):
    for loaded in [key for key in sys.modules if key.split(".")[0] == "rosbags"]:
        monkeypatch.delitem(sys.modules, loaded)
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(
        MissingExtraError, match=r"writing 'a.mcap' needs.*dehyst\[ros\].*[Cc][Ss][Vv]"
    ):
        write_mcap(tmp_path / "a.mcap", {"a": (T, {"x": T})})


CELLS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**70), 2**70),
    st.floats(),
    st.text(max_size=5),
    st.lists(st.integers()),
)


@given(st.lists(st.lists(CELLS, min_size=3, max_size=3), min_size=1, max_size=4))
def test_any_cells_make_a_table_whose_numbers_read_back_to_the_bit(tmp_path_factory, columns):
    folder = tmp_path_factory.mktemp("t")
    named = {f"c{k}": cells for k, cells in enumerate(columns)}
    with write_table(folder / "a.csv", named).open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 3
    for name, cells in named.items():
        for row, cell in zip(rows, cells, strict=True):
            if type(cell) is float:
                assert (float(row[name]) if row[name] else None) == (None if cell != cell else cell)


def test_columns_of_different_lengths_are_no_table(tmp_path):
    for columns in ({}, {"a": [1], "b": []}):
        with pytest.raises(OutputError, match="length"):
            write_table(tmp_path / "a.csv", columns)
