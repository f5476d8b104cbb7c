"""Long logs: read in parts they give the samples that reading at once gives, and thinned ones the same model."""

import gzip
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import dehyst
from dehyst.data import turning_points
from dehyst.errors import ColumnError, LogError, RecordingError, RunError
from dehyst.io import _long as long
from dehyst.io import read_log
from dehyst.io._thin import FACTOR, Thinner, turn_candidates
from log_files import IN_PARTS, save

N = 5003
T = np.arange(N) * 0.01
X = 3 * np.sin(T / 3) + np.sin(7.1 * T)
Y = 20 * np.cos(T / 3) + 0.01 * np.sin(91.0 * T)
COLUMNS = {"time_s": T, "pressure_bar": X, "angle_deg": Y}


@pytest.fixture
def in_parts(monkeypatch):
    """From now on every log is long, and is read in parts of few rows."""

    def begin(most=10**6, at_once=0):
        monkeypatch.setattr(long, "WHOLE_BYTES", 0)
        monkeypatch.setattr(long, "SIZE_LIMIT", at_once)
        monkeypatch.setattr(long, "PART_ROWS", 700)
        monkeypatch.setattr(long, "MOST_ROWS", most)
        for module in ("hdf5", "mdf"):
            monkeypatch.setattr(f"dehyst.io._{module}.HEAD_ROWS", 1000)

    return begin


def csv_text(rows=N, header="time_s,pressure_bar,angle_deg"):
    cells = zip(T[:rows].tolist(), X[:rows].tolist(), Y[:rows].tolist(), strict=True)
    return header + "\n" + "".join(f"{t:.2f},{x!r},{y:.6f}\n" for t, x, y in cells)


def same(found, known):
    assert found.input.tobytes() == known.input.tobytes()
    assert found.output.tobytes() == known.output.tobytes()
    assert (found.time is None) == (known.time is None)
    assert found.time is None or found.time.tobytes() == known.time.tobytes()
    assert (found.name, found.input_label, found.output_label) == (
        known.name,
        known.input_label,
        known.output_label,
    )
    assert found.breaks == known.breaks
    assert {f.code for f in found.findings} == {f.code for f in known.findings}


@pytest.mark.slow
@pytest.mark.parametrize("form", IN_PARTS)
def test_the_samples_are_those_of_reading_at_once(form, tmp_path, in_parts):
    path, x_name, y_name = save(tmp_path, form, COLUMNS)
    known = read_log(path, input=x_name, output=y_name)
    in_parts()
    shares = []
    found = read_log(path, input=x_name, output=y_name, progress=shares.append)
    same(found, known)
    assert shares == sorted(shares) and shares[-1] == 1.0
    origin = {name: value for name, value in known.provenance.items() if name != "stills"}
    assert dict(found.provenance) == origin


@pytest.mark.slow
@pytest.mark.parametrize("form", ["csv", "csv.gz", "npz", "packed.npz"])
def test_memory_does_not_grow_with_the_log(form, tmp_path, in_parts):
    in_parts(most=20_000)

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
        selection = long.Selection("pressure", "angle", None, None, (-np.inf, np.inf), None, None)
        tracemalloc.start()
        table = long.read_long(path, selection)
        used = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert table.samples == rows and table.rows.size <= 20_000
        return path.stat().st_size, used

    (small, before), (large, after) = peak(300_000), peak(600_000)
    assert large > 1.9 * small
    assert after < 1.15 * before + 1e5
    assert form != "csv" or (large > 10e6 and after < 40e6)


def test_rows_without_numbers_are_left_out_and_counted(tmp_path, in_parts):
    lines = csv_text(400).splitlines()
    lines[11] = "0.10,,1"
    lines[21] = "0.20,ERR,1"
    lines[31] = "0.30,1,inf"
    lines[41] = "# a comment"
    lines[51] = "0.50,1"
    lines[61] = "NA,1,1"
    (tmp_path / "log.csv").write_text("\n".join(lines))
    known = read_log(tmp_path / "log.csv", "pressure", "angle")
    in_parts()
    found = read_log(tmp_path / "log.csv", "pressure", "angle")
    same(found, known)
    messages = {f.code: f.message for f in found.findings}
    assert "4 of 398 rows" in messages["non-finite"]
    assert "lines 12, 22, 32, 62" in messages["non-finite"]
    assert "line 52" in messages["ragged-lines"]


def test_gaps_and_clocks_that_restart_are_found_as_ever_though_few_rows_stay(tmp_path, in_parts):
    rows = np.r_[0:2000, 3300:5000, 1500:2600]  # hours passed before the last of them
    time = T[rows] + np.where(np.arange(rows.size) < 3700, 0.0, 4000.0)
    np.savez(tmp_path / "log.npz", time_s=time, pressure_bar=X[rows], angle_deg=Y[rows])
    known = read_log(tmp_path / "log.npz", "pressure", "angle")
    in_parts(most=1500)
    found = read_log(tmp_path / "log.npz", "pressure", "angle")
    assert len(known.breaks) == len(found.breaks) == 2 and len(found) < 1500
    np.testing.assert_array_equal(found.time[list(found.breaks)], known.time[list(known.breaks)])
    before = [k - 1 for k in found.breaks]
    np.testing.assert_array_equal(found.time[before], known.time[[k - 1 for k in known.breaks]])


@pytest.mark.parametrize(
    "label", [lambda k: f"run {k // 100}", lambda k: k // 100], ids=["text", "number"]
)
def test_one_run_is_read_when_it_is_named(label, tmp_path, in_parts):
    rows = [f"{label(k)},{T[k]:.2f},{float(X[k])!r},{float(Y[k])!r}" for k in range(400)]
    (tmp_path / "log.csv").write_text("run,time_s,pressure_bar,angle_deg\n" + "\n".join(rows))
    name = str(label(250))
    known = read_log(tmp_path / "log.csv", "pressure", "angle", run=name)
    in_parts()
    found = read_log(tmp_path / "log.csv", "pressure", "angle", run=name)
    same(found, known)
    assert found.provenance == known.provenance
    with pytest.raises(RunError, match=r"holds 4 runs and none was named: (run )?0 \(100 rows\)"):
        read_log(tmp_path / "log.csv", "pressure", "angle")
    with pytest.raises(
        RunError, match=r"no run 'other'. It holds: (run )?0 \(100 rows\), (run )?1"
    ):
        read_log(tmp_path / "log.csv", "pressure", "angle", run="other")


def test_a_second_run_far_behind_the_start_is_not_mixed_in(tmp_path, in_parts):
    rows = [f"{'a' if k < 33_000 else 'b'},{k},{k % 77},{k % 91}\n" for k in range(33_100)]
    (tmp_path / "log.csv").write_text("run,time_s,pressure_bar,angle_deg\n" + "".join(rows))
    in_parts(most=5000)
    with pytest.raises(RunError, match=r"holds 2 runs and none was named: a \(33000 rows\), b"):
        read_log(tmp_path / "log.csv", "pressure", "angle")


@pytest.mark.parametrize("window", [{}, {"start": 1.0, "stop": 3.5}, {"stop": 0.9}])
@pytest.mark.parametrize("clock", ["dates", "epoch", "seconds"])
def test_windows_and_dates_count_from_the_same_zero(clock, window, tmp_path, in_parts):
    path = tmp_path / ("log.csv" if clock == "dates" else "log.npz")
    if clock == "dates":
        rows = [
            f"2024-05-03 12:00:{k / 100:05.2f},{float(X[k])!r},{float(Y[k])!r}" for k in range(5000)
        ]
        path.write_text("when,pressure_bar,angle_deg\n" + "\n".join(rows))
    else:
        np.savez(
            path, timestamp=1.7e18 + T * 1e9 if clock == "epoch" else T, pressure_bar=X, angle_deg=Y
        )
    known = read_log(path, "pressure", "angle", **window)
    in_parts()
    same(read_log(path, "pressure", "angle", **window), known)


def test_a_log_without_time_has_none_and_rows_can_be_counted(tmp_path, in_parts):
    np.savez(tmp_path / "log.npz", pressure_bar=X, angle_deg=Y)
    in_parts()
    assert read_log(tmp_path / "log.npz", "pressure", "angle").time is None
    in_parts(most=1500)
    thinned = read_log(tmp_path / "log.npz", "pressure", "angle", dt=0.01)
    places = np.round(thinned.time / 0.01).astype(int)
    assert len(thinned) < 1500 and places[-1] == N - 1
    np.testing.assert_array_equal(thinned.input, X[places])


REFUSED = {
    "quotes.csv": (
        "\n".join(f'"{k}","{k % 7},5","2"' for k in range(50)),
        LogError,
        "too long to be read at once",
    ),
    "units.csv": (
        "t,p,phi\n" + "\n".join(f"{k},{k % 7} bar,2" for k in range(50)),
        LogError,
        "units in cells",
    ),
    "log.mat": (
        "MATLAB 5.0 MAT-file" + " " * 200,
        LogError,
        "read at once only. Save .* as CSV, NPZ, Parquet or HDF5",
    ),
    "empty.csv": ("", LogError, "is empty"),
    "clock.csv": (csv_text(99).replace("pressure", "time"), ColumnError, "no input column"),
    "nothing.csv": (
        "time_s,pressure_bar,angle_deg\n" + "1,nan,2\n" * 9,
        LogError,
        "no column of numbers|no line",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_too_long_and_cannot_be_read_in_parts_is_refused_with_the_cure(
    name, tmp_path, in_parts
):
    text, kind, message = REFUSED[name]
    (tmp_path / name).write_text(text)
    in_parts()
    with pytest.raises((kind, RecordingError), match=message):
        read_log(tmp_path / name, "pressure" if name != "quotes.csv" else "#2", "#3")


def test_two_clocks_are_refused_where_they_cannot_be_read_at_once(tmp_path, in_parts):
    np.savez(tmp_path / "log.npz", pressure_bar=X, angle_deg=Y[:99])
    in_parts()
    with pytest.raises(LogError, match="two clocks"):
        read_log(tmp_path / "log.npz", "pressure", "angle")


@pytest.mark.parametrize(
    "form",
    ["packed.csv.gz", "packed.npz", "vectors.npz", "matrix.npy", "table.parquet", "bag.mcap"],
)
def test_a_damaged_file_is_a_named_error(form, tmp_path, in_parts):
    if form not in IN_PARTS:
        pytest.skip("its package is not installed")
    path, x_name, y_name = save(tmp_path, form, COLUMNS)
    data = path.read_bytes()
    in_parts()
    for cut in (
        data[: len(data) // 2],
        data[:-3],
        data[: len(data) // 2] + b"\xff" * 99 + data[len(data) // 2 + 99 :],
    ):
        path.write_bytes(cut)
        try:
            found = read_log(path, x_name, y_name)
        except (LogError, RecordingError):
            continue
        # Damage where nothing is read, or numbers that became others.
        assert len(found) == N or {"non-finite", "outlier"} & {f.code for f in found.findings}


def test_text_that_stops_being_plain_is_read_at_once_or_refused_with_its_line(tmp_path, in_parts):
    plain = "".join(f"{k},{k % 7}.5,{k % 9}\n" for k in range(150_000))
    text = (
        "time_s,pressure_bar,angle_deg\n"
        + plain
        + "".join(f"{k},1 bar,{k % 9}\n" for k in range(30_000))
    )
    (tmp_path / "log.csv").write_text(text)
    in_parts()
    with pytest.raises(LogError, match=r"near line \d+, many of its lines are not plain numbers"):
        read_log(tmp_path / "log.csv", "pressure", "angle")


@given(
    cells=st.lists(
        st.tuples(
            *[
                st.one_of(
                    st.floats(-99, 99).map(repr),
                    st.sampled_from(["", "nan", "x", "inf", "1e400", " 2"]),
                )
            ]
            * 2
        ),
        max_size=60,
    ),
    ending=st.sampled_from(["\n", "\r\n"]),
)
def test_whatever_the_cells_what_is_read_are_the_finite_rows(tmp_path_factory, cells, ending):
    path = tmp_path_factory.mktemp("long") / "log.csv"
    lines = ["p_bar,phi_deg", *["1.5,2.5"] * 600, *(",".join(pair) for pair in cells)]
    path.write_bytes(ending.join(lines).encode())

    def value(cell):
        try:
            return float(cell)
        except ValueError:
            return np.nan

    expected = np.array([[1.5, 2.5]] * 600 + [[value(a), value(b)] for a, b in cells])
    expected = expected[np.isfinite(expected).all(axis=1)]
    table = long.read_long(
        path, long.Selection("p", "phi", None, None, (-np.inf, np.inf), None, None)
    )
    assert (
        np.column_stack([table.columns["p_bar"], table.columns["phi_deg"]]).tobytes()
        == expected.tobytes()
    )


# What stays of a log that is thinned


def parts(thinner, size, *columns):
    for begin in range(0, columns[0].size, size):
        rows = np.arange(begin, min(begin + size, columns[0].size))
        thinner.add([column[begin : begin + size] for column in columns], rows)
    return thinner.result()


@pytest.mark.parametrize("size", [97, 1000, 20_000])
def test_turning_points_ends_and_extremes_stay_whatever_the_parts(size):
    rng = np.random.default_rng(size)
    levels = rng.uniform(-1, 1, 120)
    x = np.interp(
        np.arange(20_000), np.linspace(0, 20_000, levels.size), levels
    ) + 1e-3 * rng.standard_normal(20_000)
    thinner = Thinner(most=2000, signal=0)
    (kept,), rows = parts(thinner, size, x)
    assert rows.size <= 2000 + size and thinner.samples == x.size
    np.testing.assert_array_equal(kept, x[rows])
    assert np.isin(turning_points(x, thinner.swing), rows).all()
    assert np.isin([0, x.size - 1, x.argmin(), x.argmax()], rows).all()
    assert np.isin(np.arange(0, x.size, thinner.every), rows).all()


def test_rows_below_the_limit_all_stay():
    x = np.random.default_rng(0).standard_normal(3000)
    thinner = Thinner(most=3000, signal=0)
    (kept,), rows = parts(thinner, 500, x)
    np.testing.assert_array_equal(kept, x)
    assert thinner.every == 1 and rows.size == 3000


@given(seed=st.integers(0, 10**6), size=st.integers(3, 400), swing=st.floats(0.01, 1.5))
def test_candidates_of_the_parts_hold_the_turning_points_of_the_whole(seed, size, swing):
    x = np.cumsum(np.random.default_rng(seed).standard_normal(1500))
    x /= np.ptp(x)
    candidates = []
    for begin in range(0, x.size, size):
        candidates.append(begin + turn_candidates(x[begin : begin + size], swing))
    rows = np.unique(np.concatenate(candidates))
    np.testing.assert_array_equal(rows[turning_points(x[rows], swing)], turning_points(x, swing))


def test_every_phase_of_a_round_period_is_met():
    phases = np.arange(0, 10**6, FACTOR**6) % 1000
    assert np.unique(phases).size == 1000


def test_one_false_value_does_not_hide_the_turning_points():
    x = np.sin(np.arange(30_000) / 200.0)
    x[12_345] = 1e30
    thinner = Thinner(most=3000, signal=0)
    _, rows = parts(thinner, 5000, x)
    clean = np.delete(x, 12_345)
    peaks = turning_points(clean, 0.5)[1:-1]
    assert np.isin(peaks + (peaks >= 12_345), rows).all()


def test_an_input_that_turns_at_nearly_every_row_ends_where_there_is_no_more_room():
    x = np.tile([0.0, 1.0], 10_000)
    thinner = Thinner(most=2000, signal=0)
    (kept,), rows = parts(thinner, 500, x)
    assert thinner.is_full and rows.size <= 2500
    np.testing.assert_array_equal(rows, np.arange(rows.size))
    np.testing.assert_array_equal(kept, x[: rows.size])


def test_the_log_says_that_it_was_thinned_and_stands_for_all_of_its_samples(tmp_path, in_parts):
    np.savez(tmp_path / "log.npz", **COLUMNS)
    in_parts(most=1500)
    found = read_log(tmp_path / "log.npz", "pressure", "angle")
    message = next(f.message for f in found.findings if f.code == "thinned")
    assert f"{len(found)} of {N} rows" in message and "--from and --to" in message
    assert found.samples == N and found.provenance["rows"] == len(found)
    part = read_log(tmp_path / "log.npz", "pressure", "angle", start=10.0, stop=20.0)
    known = (T >= 10.0) & (T < 20.0)
    np.testing.assert_array_equal(part.input, X[known])
    assert "thinned" not in {f.code for f in part.findings}


def test_inspecting_a_long_log_proposes_the_same_and_tells_its_true_numbers(tmp_path, in_parts):
    np.savez(tmp_path / "log.npz", **COLUMNS)
    known = dehyst.inspect_log(tmp_path / "log.npz")
    in_parts()
    found = dehyst.inspect_log(tmp_path / "log.npz")
    assert (found.input, found.output, found.rows) == (known.input, known.output, N)


def test_of_many_rows_some_are_inspected(tmp_path, in_parts, monkeypatch):
    np.savez(tmp_path / "log.npz", **COLUMNS)
    known = dehyst.inspect_log(tmp_path / "log.npz")
    in_parts()
    monkeypatch.setattr(long, "MOST_CELLS", 3600)
    found = dehyst.inspect_log(tmp_path / "log.npz")
    assert "thinned" in {f.code for f in found.findings}
    assert (found.input, found.output, found.command) == (known.input, known.output, known.command)
    assert found.rows == known.rows
    assert found.sampling.median == pytest.approx(known.sampling.median)
    assert found.columns[1].maximum == pytest.approx(known.columns[1].maximum, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_model_and_verdict_of_a_thinned_log_are_those_of_the_whole(noise, tmp_path, in_parts):
    rng = np.random.default_rng(3)
    t = 0.01 * np.arange(300_000)
    x = 0.7 * np.sin(t / 4.1) + 0.25 * np.sin(t / 0.37) + noise * rng.standard_normal(t.size)
    truth = dehyst.PrandtlIshlinskii([0.0, 0.1, 0.3, 0.5], [1.0, 0.4, 0.5, 0.3])
    y = truth.simulate(x) + noise * rng.standard_normal(t.size)
    np.savez(tmp_path / "log.npz", time_s=t, pressure_bar=x, angle_deg=y)
    whole = dehyst.identify(read_log(tmp_path / "log.npz", "pressure", "angle"), "pi")
    in_parts(most=30_000)
    log = read_log(tmp_path / "log.npz", "pressure", "angle")
    thinned = dehyst.identify(log, "pi")
    assert len(log) < 30_000 and log.samples == t.size
    assert thinned.grade == whole.grade
    check = np.sin(0.013 * np.arange(20_000)) * np.linspace(0.1, 0.9, 20_000)
    apart = np.abs(thinned.model.simulate(check) - whole.model.simulate(check)).max()
    assert apart < 0.004 * np.ptp(y)
    assert thinned.test.rmse_percent == pytest.approx(whole.test.rmse_percent, abs=0.1)


def test_dates_that_are_texts_are_time_in_every_part(tmp_path, in_parts):
    polars = pytest.importorskip("polars", reason="the extra dehyst[parquet] is not installed")
    stamps = [f"2024-05-01 12:{k // 6000:02d}:{k // 100 % 60:02d}.{k % 100:02d}" for k in range(N)]
    frame = polars.DataFrame({"when": stamps, "pressure_bar": X, "angle_deg": Y})
    frame.write_parquet(tmp_path / "log.parquet")
    whole = read_log(tmp_path / "log.parquet", "pressure", "angle", time="when")
    in_parts()
    same(read_log(tmp_path / "log.parquet", "pressure", "angle", time="when"), whole)
    np.testing.assert_allclose(whole.time - whole.time[0], T, atol=1e-6)
