"""Logs in chunks: the samples that reading at once gives, in memory that does not grow with the log."""

import gzip
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import dehyst
from dehyst.errors import ColumnError, LogError, RecordingError, RunError, TimeError
from dehyst.io import open_chunks
from log_files import STREAMED, save

N = 5003
T = np.arange(N) * 0.01
X = 3 * np.sin(T / 3) + np.sin(7.1 * T)
Y = 20 * np.cos(T / 3) + 0.01 * np.sin(91.0 * T)
COLUMNS = {"time_s": T, "pressure_bar": X, "angle_deg": Y}


def csv_text(rows=N, header="time_s,pressure_bar,angle_deg"):
    cells = zip(T[:rows].tolist(), X[:rows].tolist(), Y[:rows].tolist(), strict=True)
    return header + "\n" + "".join(f"{t:.2f},{x!r},{y:.6f}\n" for t, x, y in cells)


@pytest.mark.slow
@pytest.mark.parametrize("form", STREAMED)
def test_the_samples_are_those_of_reading_at_once(form, tmp_path):
    path, x_name, y_name = save(tmp_path, form, COLUMNS)
    known = dehyst.read_log(path, input=x_name, output=y_name)
    log = open_chunks(path, input=x_name, output=y_name, rows=700)
    for _ in range(2):  # as often as needed
        chunks, consumed = [], []
        for chunk in log:
            chunks.append(chunk)
            consumed.append(log.consumed)
        assert consumed == sorted(consumed)
        assert log.consumed == log.size == path.stat().st_size
        time, x, y = (np.concatenate(parts) for parts in zip(*chunks, strict=True))
        assert max(c[1].size for c in chunks) <= 700
        assert x.tobytes() == known.input.tobytes()
        assert y.tobytes() == known.output.tobytes()
        assert time.tobytes() == known.time.tobytes()
    assert log.samples == len(known)
    assert (log.name, log.input_label, log.output_label) == (known.name, known.input_label, known.output_label)
    assert (log.input_unit, log.output_unit) == (known.input_unit, known.output_unit)
    assert log.provenance == known.provenance
    assert {f.code for f in log.findings} == {f.code for f in known.findings}


@pytest.mark.slow
@pytest.mark.parametrize("form", ["csv", "csv.gz", "npz", "packed.npz"])
def test_memory_does_not_grow_with_the_log(form, tmp_path):
    def peak(rows):
        path = tmp_path / f"{rows}.{form}"
        time = np.arange(rows) * 1e-3
        columns = {"time_s": time, "pressure_bar": np.sin(time), "angle_deg": np.cos(time)}
        if "csv" in form:
            block = "".join(f"{k},{k % 77}.25,{k % 91}.125\n" for k in range(10_000, 20_000))
            text = ("time_s,pressure_bar,angle_deg\n" + block * (rows // 10_000)).encode()
            path.write_bytes(gzip.compress(text, 1) if form.endswith("gz") else text)
        else:
            (np.savez_compressed if "packed" in form else np.savez)(path, **columns)
        del columns, time
        tracemalloc.start()
        count = sum(x.size for _, x, _ in open_chunks(path, "pressure", "angle", rows=4096))
        used = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert count == rows
        return path.stat().st_size, used

    (small, before), (large, after) = peak(300_000), peak(600_000)
    assert large > 1.9 * small
    assert after < 1.05 * before + 1e5
    assert form != "csv" or (large > 10e6 and after < 40e6)


def test_rows_without_numbers_are_left_out_and_counted(tmp_path):
    lines = csv_text(400).splitlines()
    lines[11] = "0.10,,1"
    lines[21] = "0.20,ERR,1"
    lines[31] = "0.30,1,inf"
    lines[41] = "# a comment"
    lines[51] = "0.50,1"
    lines[61] = "NA,1,1"
    (tmp_path / "log.csv").write_text("\n".join(lines))
    log = open_chunks(tmp_path / "log.csv", "pressure", "angle", rows=7)
    values = np.concatenate([x for _, x, _ in log])
    known = dehyst.read_log(tmp_path / "log.csv", "pressure", "angle")
    assert values.tobytes() == known.input.tobytes()
    assert log.samples == 400 - 6
    found = {f.code: f.message for f in log.findings}
    assert set(found) == {"non-finite", "ragged-lines"}
    assert "4 of 398 rows" in found["non-finite"]
    assert "lines 12, 22, 32, 62" in found["non-finite"]
    assert "line 52" in found["ragged-lines"]
    assert log.provenance == known.provenance
    list(log)
    assert {f.code: f.message for f in log.findings} == found  # counted anew in every pass


def test_gaps_and_a_clock_that_jumps_back_are_findings(tmp_path):
    time = np.concatenate((T[:300], T[300:600] + 50, T[:200]))
    np.savez(tmp_path / "log.npz", time_s=time, pressure_bar=X[:800], angle_deg=Y[:800])
    log = open_chunks(tmp_path / "log.npz", "pressure", "angle", rows=128)
    assert np.concatenate([t for t, _, _ in log]).tolist() == time.tolist()
    found = {f.code: f.message for f in log.findings}
    assert "1 gap, before sample 301" in found["gap"]
    assert "at sample 601" in found["clock-restart"]


@pytest.mark.parametrize("label", [lambda k: f"run {k // 100}", lambda k: k // 100], ids=["text", "number"])
def test_one_run_is_read_when_it_is_named(label, tmp_path):
    rows = [f"{label(k)},{T[k]:.2f},{float(X[k])!r},{float(Y[k])!r}" for k in range(400)]
    (tmp_path / "log.csv").write_text("run,time_s,pressure_bar,angle_deg\n" + "\n".join(rows))
    name = str(label(250))
    known = dehyst.read_log(tmp_path / "log.csv", "pressure", "angle", run=name)
    log = open_chunks(tmp_path / "log.csv", "pressure", "angle", run=name, rows=30)
    assert np.concatenate([x for _, x, _ in log]).tobytes() == known.input.tobytes()
    assert (log.name, log.provenance) == (known.name, known.provenance)
    with pytest.raises(RunError, match="holds 4 runs and none was named"):
        open_chunks(tmp_path / "log.csv", "pressure", "angle")
    with pytest.raises(RunError, match=r"no run 'other'. It holds: (run )?0, (run )?1"):
        list(open_chunks(tmp_path / "log.csv", "pressure", "angle", run="other"))


def test_a_second_run_far_behind_the_start_is_not_mixed_in(tmp_path):
    rows = [f"{'a' if k < 330_000 else 'b'},{k},{k % 77},{k % 91}\n" for k in range(330_100)]
    (tmp_path / "log.csv").write_text("run,time_s,pressure_bar,angle_deg\n" + "".join(rows))
    log = open_chunks(tmp_path / "log.csv", "pressure", "angle")
    with pytest.raises(RunError, match="several runs and none was named: a, b"):
        list(log)


def test_dates_and_epochs_count_from_the_first_sample(tmp_path):
    rows = [f"2024-05-03 12:{k // 60:02d}:{k % 60:02d},{float(X[k])!r},{float(Y[k])!r}" for k in range(500)]
    (tmp_path / "dates.csv").write_text("when,pressure_bar,angle_deg\n" + "\n".join(rows))
    np.savez(tmp_path / "epoch.npz", timestamp=1.7e18 + T * 1e9, pressure_bar=X, angle_deg=Y)
    for name in ("dates.csv", "epoch.npz"):
        known = dehyst.read_log(tmp_path / name, "pressure", "angle")
        time = np.concatenate([t for t, _, _ in open_chunks(tmp_path / name, "pressure", "angle", rows=99)])
        assert time.tobytes() == known.time.tobytes()
        assert time[0] == 0.0


def test_a_log_without_time_has_none(tmp_path):
    np.savez(tmp_path / "log.npz", pressure_bar=X, angle_deg=Y)
    log = open_chunks(tmp_path / "log.npz", "pressure", "angle")
    assert not log.has_time
    assert all(time is None for time, _, _ in log)


REFUSED = {
    "quotes.csv": ("\n".join(f'"{k}","{k % 7},5","2"' for k in range(50)), LogError, "cannot be read in chunks"),
    "units.csv": ("t,p,phi\n" + "\n".join(f"{k},{k % 7} bar,2" for k in range(50)), LogError, "units in cells"),
    "log.mat": ("MATLAB 5.0 MAT-file" + " " * 200, LogError, "CSV, NPZ, NPY, Parquet, Feather, ROS bags and MCAP can"),
    "empty.csv": ("", LogError, "is empty"),
    "clock.csv": (csv_text(99).replace("pressure", "time"), ColumnError, "no input column"),
    "nothing.csv": ("time_s,pressure_bar,angle_deg\n" + "1,nan,2\n" * 9, LogError, "no column of numbers|no line"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_is_refused_with_the_cure(name, tmp_path):
    text, kind, message = REFUSED[name]
    (tmp_path / name).write_text(text)
    with pytest.raises((kind, RecordingError), match=message):
        list(open_chunks(tmp_path / name, "pressure" if name != "quotes.csv" else "#2", "#3"))


def test_a_missing_file_a_folder_and_other_things_are_refused_by_name(tmp_path):
    with pytest.raises(LogError, match=r"cannot read .*No such file"):
        open_chunks(tmp_path / "none.csv", "x", "y")
    with pytest.raises(LogError, match="is a folder"):
        open_chunks(tmp_path, "x", "y")
    with pytest.raises(LogError, match="is no path"):
        open_chunks(None, "x", "y")
    with pytest.raises(ColumnError, match="are both column"):
        open_chunks(save(tmp_path, "plain.csv", COLUMNS)[0], "angle", "angle")


def test_two_clocks_are_refused(tmp_path):
    np.savez(tmp_path / "log.npz", pressure_bar=X, angle_deg=Y[:99])
    with pytest.raises(TimeError, match="two clocks"):
        open_chunks(tmp_path / "log.npz", "pressure", "angle")


@pytest.mark.parametrize(
    "form", ["packed.csv.gz", "packed.npz", "vectors.npz", "matrix.npy", "table.parquet", "bag.mcap"]
)
def test_a_damaged_file_is_a_named_error(form, tmp_path):
    if form not in STREAMED:
        pytest.skip("its package is not installed")
    path, x_name, y_name = save(tmp_path, form, COLUMNS)
    data = path.read_bytes()
    for cut in (data[: len(data) // 2], data[:-3], data[: len(data) // 2] + b"\xff" * 99 + data[len(data) // 2 + 99 :]):
        path.write_bytes(cut)
        try:
            log = open_chunks(path, x_name, y_name, rows=500)
            samples = sum(x.size for _, x, _ in log)
        except (LogError, RecordingError):
            continue
        # Damage where nothing is read, or numbers that became others.
        assert samples == N or any(f.code == "non-finite" for f in log.findings)


def test_text_that_stops_being_plain_is_refused_with_its_line(tmp_path):
    plain = "".join(f"{k},{k % 7}.5,{k % 9}\n" for k in range(400_000))
    text = "time_s,pressure_bar,angle_deg\n" + plain + "".join(f"{k},1 bar,{k % 9}\n" for k in range(30_000))
    (tmp_path / "log.csv").write_text(text)
    with pytest.raises(LogError, match=r"near line \d+, many of its lines are not plain numbers"):
        list(open_chunks(tmp_path / "log.csv", "pressure", "angle"))


@given(
    cells=st.lists(
        st.tuples(
            *[st.one_of(st.floats(-99, 99).map(repr), st.sampled_from(["", "nan", "x", "inf", "1e400", " 2"]))] * 2
        ),
        max_size=60,
    ),
    rows=st.integers(50, 99),
    ending=st.sampled_from(["\n", "\r\n"]),
)
def test_whatever_the_cells_what_is_given_out_are_the_finite_rows(tmp_path_factory, cells, rows, ending):
    path = tmp_path_factory.mktemp("chunks") / "log.csv"
    lines = ["p_bar,phi_deg", *["1.5,2.5"] * 600, *(",".join(pair) for pair in cells)]
    path.write_bytes(ending.join(lines).encode())

    def value(cell):
        try:
            return float(cell)
        except ValueError:
            return np.nan

    wanted = np.array([[1.5, 2.5]] * 600 + [[value(a), value(b)] for a, b in cells])
    wanted = wanted[np.isfinite(wanted).all(axis=1)]
    log = open_chunks(path, "p", "phi", rows=rows)
    found = np.concatenate([np.column_stack([x, y]) for _, x, y in log])
    assert found.tobytes() == wanted.tobytes()
