"""Binary logs: files of independent writers read back number for number."""

import gzip
import io
import pickle
import warnings
import zipfile
from importlib import import_module
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from scipy.io import savemat

from dehyst import load
from dehyst.errors import DehystError, LogError, MissingExtraError, ModelFileError, TimeError
from dehyst.io import read_log, read_signal, read_table
from effort import no_hang
from log_files import FORMS, save

N = 300
T = np.arange(N) * 0.01
X = 3.0 * np.sin(2 * np.pi * T)
Y = 20.0 * np.sin(2 * np.pi * T - 0.2)


def check(rec, codes=()):
    np.testing.assert_array_equal(rec.input, X)
    np.testing.assert_array_equal(rec.output, Y)
    assert rec.time is not None
    np.testing.assert_allclose(rec.time, T, rtol=0, atol=1e-6)
    assert tuple(f.code for f in rec.findings) == codes


@pytest.mark.parametrize(
    "form", [form for form in FORMS if form not in ("single.npz", "log.mf4", "book.xlsx")]
)
def test_numbers_that_the_package_of_a_format_wrote_are_read_bit_for_bit(tmp_path, form):
    path, x, y = save(tmp_path, form, {"time_s": T, "pressure_bar": X, "angle_deg": Y})
    rec = read_log(path, x, y)
    check(rec, ("time-from-step",) if form.startswith("step") else ())
    assert (rec.input_unit, rec.output_unit) == (("bar", "deg") if "pressure" in x else ("", ""))


# MAT up to version 7


def test_a_sampling_rate_beside_the_signals_makes_the_clock(tmp_path):
    savemat(tmp_path / "log.mat", {"fs": 100.0, "x_F": np.column_stack([X, Y])})
    check(read_log(tmp_path / "log.mat", "x_F_1", "x_F_2"), ("time-from-step",))


def test_structs_carry_their_own_clock(tmp_path):
    fast = np.arange(2 * N) * 0.005
    log = {
        "valve": {"time": T, "pressure_bar": X},
        "encoder": {"time": fast, "angle_deg": 7.0 * fast},
    }
    savemat(tmp_path / "log.mat", log)
    rec = read_log(tmp_path / "log.mat", "valve.pressure_bar", "encoder.angle_deg")
    np.testing.assert_array_equal(rec.input, X)
    np.testing.assert_allclose(rec.output, 7.0 * T, atol=1e-12)
    assert [f.code for f in rec.findings] == ["two-clocks"]
    assert (rec.input_unit, rec.output_unit) == ("bar", "deg")


def test_structure_with_time_takes_the_labels(tmp_path):
    signals = np.array(
        [(X[:, None], "pressure_bar"), (Y[:, None], "angle_deg")],
        dtype=[("values", object), ("label", object)],
    )
    savemat(tmp_path / "log.mat", {"simout": {"time": T[:, None], "signals": signals}})
    check(read_log(tmp_path / "log.mat", "simout.pressure_bar", "simout.angle_deg"))


def test_strings_tell_the_runs_of_a_mat_file_apart(tmp_path):
    runs = np.array(["a"] * N + ["b"] * N, dtype=object)
    savemat(
        tmp_path / "log.mat",
        {"run": runs, "t": np.tile(T, 2), "x": np.tile(X, 2), "y": np.tile(Y, 2)},
    )
    check(read_log(tmp_path / "log.mat", "x", "y", run="b"))


def test_different_lengths_without_a_clock_are_refused(tmp_path):
    savemat(tmp_path / "log.mat", {"x": X, "y": Y[:-5]})
    with pytest.raises(TimeError, match="300 and 295 samples"):
        read_log(tmp_path / "log.mat", "x", "y")


MATLAB = sorted((Path(scipy.io.__file__).parent / "matlab" / "tests" / "data").glob("*.mat"))


def vectors(path):
    """Real numeric vectors of a file by scipy, or nothing where scipy refuses."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            content = scipy.io.loadmat(path)
    except Exception:  # any refusal of the oracle means that there is nothing to compare
        return {}
    return {
        name: value.ravel().astype(float)
        for name, value in content.items()
        if not name.startswith("__")
        and isinstance(value, np.ndarray)
        and value.dtype.kind in "fiub"
        and value.ndim == 2
        and min(value.shape) == 1
        and value.size > 1
    }


def test_matlab_s_own_files_of_twenty_years_are_read_like_scipy_reads_them_or_refused_by_name():
    if not MATLAB:
        pytest.skip("this build of scipy ships no MATLAB files")
    compared, refused = 0, []
    for path in MATLAB:
        expected = vectors(path)
        try:
            columns = read_table(path).columns
        except DehystError:
            refused += [path.name] if expected else []
            continue
        for name, values in expected.items():
            np.testing.assert_array_equal(columns[name], values, err_msg=f"{path.name}: {name}")
            compared += 1
    assert refused == [] and compared >= 10


# MAT 7.3 and HDF5


def test_version_73_is_read_transposed_with_structs_and_strings(tmp_path):
    file = tmp_path / "log.mat"
    with h5py.File(file, "w", userblock_size=512) as out:
        group = out.create_group("log")
        for name, value in (("time", T), ("pressure_bar", X), ("angle_deg", Y)):
            group.create_dataset(name, data=value[None, :], compression="gzip").attrs[
                "MATLAB_class"
            ] = b"double"
        out.create_dataset("pair", data=np.vstack([X, Y])).attrs["MATLAB_class"] = b"double"
        cell = out.create_group("#refs#")
        texts = [
            cell.create_dataset(f"s{k}", data=np.array([[ord("a") + k // 150]], np.uint16))
            for k in range(N)
        ]
        for text in texts:
            text.attrs["MATLAB_class"] = b"char"
        references = np.array([text.ref for text in texts], dtype=h5py.ref_dtype)[None, :]
        out.create_dataset("run", data=references, dtype=h5py.ref_dtype).attrs["MATLAB_class"] = (
            b"cell"
        )
    raw = bytearray(file.read_bytes())
    raw[:19] = b"MATLAB 7.3 MAT-file"
    file.write_bytes(raw)
    rec = read_log(file, "log.pressure_bar", "log.angle_deg", run="b")
    np.testing.assert_array_equal(rec.input, X[150:])
    np.testing.assert_array_equal(rec.time, T[150:])
    assert "pair_2" in read_table(file).columns


def test_a_dataset_that_claims_a_terabyte_is_refused(tmp_path):
    with h5py.File(tmp_path / "log.h5", "w") as out:
        out.create_dataset("x", shape=(1 << 37,), dtype="f8", chunks=(1 << 16,))
    with pytest.raises(LogError, match="claims to hold"):
        read_table(tmp_path / "log.h5")


# NumPy


def test_date_times_of_an_archive_count_from_the_first(tmp_path):
    stamps = np.datetime64("2024-05-01T23:59:59", "ns") + np.round(T * 1e9).astype(
        "timedelta64[ns]"
    )
    np.savez(tmp_path / "e.npz", stamp=stamps, x=X, y=Y)
    check(read_log(tmp_path / "e.npz", "x", "y"))


def test_pickled_objects_are_never_loaded(tmp_path):
    class Trap:
        def __reduce__(self):
            return (Path.touch, (tmp_path / "ran",))

    np.savez(tmp_path / "log.npz", x=np.array([Trap()] * 5, dtype=object))
    with pytest.raises(LogError, match="Python objects"):
        read_table(tmp_path / "log.npz")
    assert not (tmp_path / "ran").exists()
    (tmp_path / "log.npy").write_bytes(pickle.dumps(Trap()))
    with pytest.raises(LogError):
        read_table(tmp_path / "log.npy")
    assert not (tmp_path / "ran").exists()


@pytest.mark.slow
def test_archives_that_unpack_to_too_much_are_refused(tmp_path):
    np.savez_compressed(tmp_path / "bomb.npz", x=np.zeros(20_000_000))
    assert (tmp_path / "bomb.npz").stat().st_size < 400_000
    with pytest.raises(LogError, match="claims to hold"):
        read_table(tmp_path / "bomb.npz")


def test_the_longest_sheet_of_a_spreadsheet_is_read_with_the_digits_that_its_writer_keeps(tmp_path):
    path, x, y = save(tmp_path, "book.xlsx", {"time_s": T, "pressure_bar": X, "angle_deg": Y})
    rec = read_log(path, x, y)
    np.testing.assert_allclose(rec.input, X, rtol=1e-15)  # openpyxl writes 16 digits
    assert [finding.code for finding in rec.findings] == ["sheet"] and "'log'" in rec.findings[
        0
    ].message


def test_a_damaged_spreadsheet_is_refused_with_the_way_out(tmp_path):
    with zipfile.ZipFile(tmp_path / "log.xlsx", "w") as archive:
        archive.writestr("xl/workbook.xml", "<workbook/>")
    with pytest.raises(LogError, match=r"damaged.*as CSV"):
        read_table(tmp_path / "log.xlsx")


# Extras


@pytest.mark.parametrize("ending", ["parquet", "feather", "csv"])
def test_dates_that_are_texts_are_time_in_every_format(tmp_path, ending):
    polars = pytest.importorskip("polars", reason="the extra dehyst[parquet] is not installed")
    stamps = [f"2024-05-01T12:00:{k // 100:02d}.{10 * (k % 100):03d}" for k in range(400)]
    t = 0.01 * np.arange(400)
    frame = polars.DataFrame({"time": stamps, "u_bar": np.sin(5 * t), "y_deg": np.cos(5 * t)})
    file = tmp_path / f"log.{ending}"
    {"parquet": frame.write_parquet, "feather": frame.write_ipc, "csv": frame.write_csv}[ending](
        file
    )
    log = read_log(file, "u", "y")
    np.testing.assert_allclose(log.time - log.time[0], t, atol=1e-6)
    assert "no-time" not in {finding.code for finding in log.findings}


@pytest.mark.parametrize("ending", ["parquet", "feather"])
def test_parquet_and_feather(tmp_path, ending):
    polars = pytest.importorskip("polars", reason="the extra dehyst[parquet] is not installed")
    file = tmp_path / f"log.{ending}"
    runs = ["a"] * N + ["b"] * N
    frame = polars.DataFrame(
        {"run": runs, "time_s": np.tile(T, 2), "p_bar": np.tile(X, 2), "y": np.tile(Y, 2)}
    )
    frame.write_parquet(file) if ending == "parquet" else frame.write_ipc(file, compression="zstd")
    check(read_log(file, "p", "y", run="b"))
    stamps = polars.Series((np.round(T * 1e9) + 1.7e18).astype(np.int64)).cast(
        polars.Datetime("ns")
    )
    frame = polars.DataFrame({"stamp": stamps, "x": X, "y": [*Y.tolist()[:-1], None]})
    frame.write_parquet(file) if ending == "parquet" else frame.write_ipc(file)
    rec = read_log(file, "x", "y")
    np.testing.assert_allclose(rec.time, T[:-1], atol=1e-6)
    assert [f.code for f in rec.findings] == ["non-finite"]


@pytest.mark.slow
@pytest.mark.parametrize(("version", "ending"), [("4.10", "mf4"), ("3.30", "mdf"), ("3.30", "dat")])
def test_mdf(tmp_path, version, ending):
    asammdf = pytest.importorskip("asammdf", reason="the extra dehyst[mdf] is not installed")
    slow = np.arange(N // 2) * 0.02
    with asammdf.MDF(version=version) as out:
        out.append(
            [
                asammdf.Signal(X, T, unit="bar", name="pressure"),
                asammdf.Signal(Y, T, unit="°", name="angle"),
            ]
        )
        out.append([asammdf.Signal(4.0 * slow, slow, unit="N", name="force")])
        saved = Path(
            out.save(tmp_path / f"log.{'mf4' if ending == 'mf4' else 'mdf'}", overwrite=True)
        )
    file = saved.rename(tmp_path / f"renamed.{ending}")
    rec = read_log(file, "pressure", "angle")
    check(rec)
    assert (rec.input_unit, rec.output_unit) == ("bar", "deg")
    rec = read_log(file, "pressure", "force")
    np.testing.assert_allclose(rec.output, 4.0 * np.asarray(rec.time), atol=1e-12)
    assert "two-clocks" in [f.code for f in rec.findings]


def write_bag(path, kind):
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    first = kind == "bag"
    store = get_typestore(Stores.ROS1_NOETIC if first else Stores.LATEST)
    types = store.types
    time_type, header_type = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    joint_type, float_type = types["sensor_msgs/msg/JointState"], types["std_msgs/msg/Float64"]
    if first:
        writer = Writer1(path / "log.bag")
    else:
        plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
        writer = Writer2(path / "bag", version=9, storage_plugin=plugin)
    pack = store.serialize_ros1 if first else store.serialize_cdr
    with writer as out:
        joints = out.add_connection("/joint_states", joint_type.__msgtype__, typestore=store)
        pressure = out.add_connection("/pressure_bar", float_type.__msgtype__, typestore=store)
        for k in range(N):
            stamp = 1_700_000_000_000_000_000 + 10_000_000 * k
            head = {"seq": k} if first else {}
            header = header_type(
                **head, stamp=time_type(sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id=""
            )
            position = np.array([Y[k], -1.0])
            empty = np.zeros(0)
            message = joint_type(
                header=header, name=["a", "b"], position=position, velocity=empty, effort=empty
            )
            out.write(joints, stamp + 3_000_000, pack(message, joint_type.__msgtype__))
            out.write(pressure, stamp, pack(float_type(data=float(X[k])), float_type.__msgtype__))
    if first or kind == "folder":
        return path / ("log.bag" if first else "bag")
    return next((path / "bag").glob(f"*.{kind}"))


@pytest.mark.parametrize("kind", ["bag", "folder", "db3", "mcap"])
def test_ros_bags(tmp_path, kind):
    pytest.importorskip("rosbags", reason="the extra dehyst[ros] is not installed")
    path = write_bag(tmp_path, kind)
    rec = read_log(path, "/pressure_bar.data", "/joint_states.position[0]")
    # Both clocks count from 1970; the joint's header.stamp equals the time the pressure was received.
    assert len(rec) == N
    np.testing.assert_array_equal(rec.input, X)
    np.testing.assert_allclose(rec.output, Y, atol=1e-3)
    np.testing.assert_allclose(rec.time, T, atol=1e-6)
    assert len(str(rec.provenance["sha256"])) == 64


def test_durations_of_messages_count_nanoseconds(tmp_path):
    pytest.importorskip("rosbags", reason="the extra dehyst[ros] is not installed")
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.LATEST)
    point = store.types["trajectory_msgs/msg/JointTrajectoryPoint"]
    duration, empty = store.types["builtin_interfaces/msg/Duration"], np.zeros(0)
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as out:
        topic = out.add_connection("/p", point.__msgtype__, typestore=store)
        for k in range(N):
            after = duration(sec=0, nanosec=10_000_000 * (k + 1))
            message = point(np.array([X[k], Y[k]]), empty, empty, empty, time_from_start=after)
            out.write(topic, 10**18 + 999 * k, store.serialize_cdr(message, point.__msgtype__))
    rec = read_log(
        tmp_path / "bag", "/p.positions[0]", "/p.positions[1]", time="/p.time_from_start"
    )
    np.testing.assert_allclose(rec.time - rec.time[0], T, atol=1e-9)


def test_a_missing_extra_names_the_line_to_type(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "importlib.import_module",
        lambda name: (_ for _ in ()).throw(ModuleNotFoundError(f"No module named {name!r}")),
    )
    for data, ending, extra in (
        (b"PAR1....", "parquet", "parquet"),
        (b"MDF     4.10", "mf4", "mdf"),
        (b"#ROSBAG V2.0\n", "bag", "ros"),
        (b"\x89MCAP0\r\n", "mcap", "ros"),
        (b"\x89HDF\r\n\x1a\n", "h5", "hdf5"),
        (b"CDF\x01", "nc", "netcdf"),
    ):
        file = tmp_path / f"log.{ending}"
        file.write_bytes(data)
        with pytest.raises(MissingExtraError, match=rf"pip install 'dehyst\[{extra}\]'"):
            read_table(file)


def test_missing_empty_and_foreign_files_are_refused(tmp_path):
    cases = [
        ("none.csv", None, "No such file"),
        ("empty.csv", b"", "is empty"),
        ("blank.csv", b"\n\n# nothing\n", "holds no data"),
        ("text.csv", b"hello world\nthis is no table\n", "no table of numbers"),
        ("image.csv", bytes(range(256)) * 20, "not text"),
        ("fake.npz", b"1,2,3\n" * 10, "not those of a NumPy archive"),
        ("cut.gz", b"\x1f\x8b\x08\x00", "ends early"),
    ]
    for name, data, message in cases:
        if data is not None:
            (tmp_path / name).write_bytes(data)
        with pytest.raises(LogError, match=message):
            read_table(tmp_path / name)
    with pytest.raises(LogError, match="is a folder"):
        read_table(tmp_path)
    with pytest.raises(DehystError):
        read_signal("a\0b.csv", "x")


def test_a_gzip_bomb_is_refused_unread(tmp_path):
    (tmp_path / "bomb.csv.gz").write_bytes(gzip.compress(b"0,0\n" * 20_000_000, 6))
    with no_hang(), pytest.raises(LogError, match="expands from"):
        read_table(tmp_path / "bomb.csv.gz")


@pytest.mark.slow
def test_a_packed_mat_bomb_is_refused(tmp_path):
    stream = io.BytesIO()
    savemat(stream, {"x": np.zeros(12_000_000)}, do_compression=True)
    (tmp_path / "log.mat").write_bytes(stream.getvalue())
    with pytest.raises(LogError, match="claims to hold"):
        read_table(tmp_path / "log.mat")


def test_a_matrix_beside_a_time_vector_keeps_all_its_columns(tmp_path):
    t = np.arange(200) * 0.01
    np.savez(tmp_path / "log.npz", t=t, data=np.column_stack([3 * t, np.sin(7 * t)]))
    rec = read_log(tmp_path / "log.npz", "data_2", "data_1")
    np.testing.assert_array_equal(rec.time, t)
    np.testing.assert_array_equal(rec.output, 3 * t)


def opaque(name, kind, version):
    """A MAT file whose only variable is an object of a class, as MATLAB writes it."""
    if version == "7.3":
        stream = io.BytesIO()
        with h5py.File(stream, "w", userblock_size=512) as out:
            node = out.create_dataset(name, data=np.array([[3707764736, 2, 1, 1, 1, 1]], "u4"))
            node.attrs["MATLAB_class"], node.attrs["MATLAB_object_decode"] = (
                np.bytes_(kind),
                np.int32(3),
            )
        return b"MATLAB 7.3 MAT-file".ljust(512) + stream.getvalue()[512:]

    def element(code, data):
        return np.array([code, len(data)], "<u4").tobytes() + data + b"\0" * (-len(data) % 8)

    words = [element(1, word.encode()) for word in (name, "MCOS", kind)]
    flags = element(6, np.array([17, 0], "<u4").tobytes())
    head = b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM"
    return head + element(14, flags + b"".join(words))


@pytest.mark.parametrize("version", ["6", "7.3"])
@pytest.mark.parametrize(
    ("kind", "cure"),
    [
        ("table", "s = table2struct(log1, 'ToScalar', true);"),
        ("timetable", "seconds(log1.Properties.RowTimes - log1.Properties.RowTimes(1))"),
        ("timeseries", "s = struct('time', log1.Time, 'data', squeeze(log1.Data))"),
        ("string", "log1 = cellstr(log1);"),
        (
            "containers.Map",
            "s = cell2struct(values(log1), matlab.lang.makeValidName(keys(log1)), 2)",
        ),
        ("datetime", "log1 = seconds(log1 - log1(1));"),
        ("rig.Own", "struct('time', log1.Time, 'data', log1.Data)"),
    ],
)
def test_a_file_that_holds_only_an_object_of_matlab_says_its_class_and_the_line_that_saves_it(
    tmp_path, kind, cure, version
):
    (tmp_path / "log.mat").write_bytes(opaque("log1", kind, version))
    with pytest.raises(LogError) as caught:
        read_table(tmp_path / "log.mat")
    assert f"log1 in log.mat is a MATLAB object of class {kind}" in str(
        caught.value
    ) and cure in str(caught.value)
    assert "delimiter" not in str(caught.value)


def test_a_file_without_signals_names_what_it_holds_and_no_delimiter(tmp_path):
    savemat(tmp_path / "log.mat", {"fs": 100.0, "gain": 2.0})
    with pytest.raises(LogError, match="single numbers it holds fs, gain") as caught:
        read_table(tmp_path / "log.mat")
    assert "delimiter" not in str(caught.value)


@pytest.mark.parametrize("wanted", ["sensor[:,6]", "sensor[:, 6]", "sensor(:,7)"])
def test_an_index_is_answered_with_the_column_that_it_means(tmp_path, wanted):
    savemat(tmp_path / "log.mat", {"t": T, "sensor": np.outer(X, np.arange(1, 9))})
    with pytest.raises(DehystError, match="did you mean 'sensor_7'"):
        read_log(tmp_path / "log.mat", "sensor_1", wanted)


@pytest.mark.parametrize("form", ["parquet", "feather"])
def test_units_in_the_metadata_of_arrow_fields_are_those_of_the_columns(
    tmp_path, monkeypatch, form
):
    pyarrow = pytest.importorskip("pyarrow")
    pytest.importorskip("polars", reason="the extra dehyst[parquet] is not installed")
    from pyarrow import feather, parquet

    columns = (
        ("t", T * 1000.0, {"unit": "ms"}),
        ("p", X, {"Units": "Bar", "sensor": "a"}),
        ("phi_deg", Y, {}),
    )
    schema = pyarrow.schema(
        [pyarrow.field(name, pyarrow.float64(), metadata=told) for name, _, told in columns]
    )
    table = pyarrow.table([values for _, values, _ in columns], schema=schema)
    if form == "parquet":
        parquet.write_table(table, tmp_path / "log.parquet")
    else:
        feather.write_feather(table, tmp_path / "log.feather")
    rec = read_log(tmp_path / f"log.{form}", "p", "phi")
    check(rec)
    assert (rec.input_unit, rec.output_unit) == ("bar", "deg")
    monkeypatch.setattr("dehyst.io._long.WHOLE_BYTES", 0)
    again = read_log(tmp_path / f"log.{form}", "p", "phi")
    check(again)
    assert again.input_unit == "bar"


TABLE = b"t,x,y\n" + b"".join(b"%d,%d,%d\n" % (k, k % 7, k % 5) for k in range(99))
PACKED = {  # name -> content that is packed by gzip, what the refusal calls it, what it says to type
    "log.npz.gz": (b"PK\x03\x04" + bytes(99), "a NumPy archive", "gzip -dk log.npz.gz"),
    "log.npy.gz": (b"\x93NUMPY" + bytes(99), "a NumPy array", "gzip -dk log.npy.gz"),
    "log.gz": (b"PAR1" + bytes(99), "Parquet", "gzip -dk log.gz"),
    "log.mat.gz": (b"MATLAB 5.0 MAT-file" + bytes(99), "a MAT file", "gzip -dk log.mat.gz"),
    "log.h5.gz": (b"\x89HDF\r\n\x1a\n" + bytes(99), "HDF5", "gzip -dk log.h5.gz"),
    "model.gz": (b'{"format": "dehyst-model"}', "a model that dehyst saved", "Name the log"),
    "twice.csv.gz": (gzip.compress(TABLE), "packed before", "gzip -dk twice.csv.gz"),
    "log.tar.gz": (bytes(257) + b"ustar" + bytes(99), "an archive", "tar -xzf log.tar.gz"),
}


@pytest.mark.parametrize("name", PACKED)
def test_a_packed_log_that_is_no_text_is_named_with_what_to_type(tmp_path, name):
    content, title, cure = PACKED[name]
    (tmp_path / name).write_bytes(gzip.compress(content))
    with pytest.raises(LogError) as fault:
        read_table(tmp_path / name)
    assert title in str(fault.value) and cure in str(fault.value)


@pytest.mark.parametrize(("module", "program"), [("bz2", "bzip2"), ("lzma", "xz")])
def test_a_log_that_another_program_packed_is_named_with_what_to_type(tmp_path, module, program):
    (tmp_path / "log.csv.packed").write_bytes(import_module(module).compress(TABLE))
    with pytest.raises(LogError, match=f"{program} -dk log.csv.packed"):
        read_table(tmp_path / "log.csv.packed")


def test_text_packed_by_gzip_is_read_as_before(tmp_path):
    (tmp_path / "log.csv.gz").write_bytes(gzip.compress(TABLE))
    (tmp_path / "log.csv").write_bytes(TABLE)
    packed, plain = (
        read_log(tmp_path / name, "x", "y", time="t") for name in ("log.csv.gz", "log.csv")
    )
    assert packed.input.size == 99
    np.testing.assert_array_equal(packed.output, plain.output)


def test_a_packed_model_is_refused_with_what_to_type(tmp_path):
    (tmp_path / "model.json.gz").write_bytes(gzip.compress(b"{}"))
    with pytest.raises(
        ModelFileError, match=r"packed with gzip .to unpack it: gzip -dk model\.json\.gz"
    ):
        load(tmp_path / "model.json.gz")
