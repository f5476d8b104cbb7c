"""Logs in chunks: the same model as in memory, in constant memory, and faults that cure."""

import dataclasses
import json
import subprocess
import sys
import textwrap
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import dehyst
from dehyst.data.loops import turning_points
from dehyst.errors import ExcitationError, LogError, OutputError, ParameterError, RecordingError, TimeError
from dehyst.identification import identify as identify_plays
from dehyst.identification.data import prepare as prepare_in_memory
from dehyst.identification.facts import branches as branches_in_memory
from dehyst.identification.short_signal import shorten
from dehyst.identification.split import split_recordings
from dehyst.identification.stream import source as spools
from dehyst.identification.stream.data import branches, prepare, split_logs
from dehyst.identification.stream.log import read
from dehyst.identification.stream.measure import Cycles
from dehyst.identification.stream.outline import Outline, Zigzag
from dehyst.identification.stream.samples import Tape
from dehyst.identification.stream.source import STAGES, Watch


class Chunks:
    """A source in memory, counted."""

    name, input_name, output_name, input_unit, output_unit = "made", "pressure", "angle", "bar", "deg"

    def __init__(self, x, y, time=None, size=7001, costly=False):
        self.x, self.y, self.time, self.chunk, self.costly = x, y, time, size, costly
        self.passes = 0

    def __iter__(self):
        self.passes += 1
        for k in range(0, self.x.size, self.chunk):
            part = slice(k, k + self.chunk)
            yield None if self.time is None else self.time[part], self.x[part], self.y[part]


def record(samples=90_000, seed=0, noise=0.02):
    """Noisy loops of an operator, input off centre, with time."""
    rng = np.random.default_rng(seed)
    time = 0.002 * np.arange(samples)
    swing = np.sin(2 * np.pi * time / 7.3) * (0.7 + 0.3 * np.sin(time / 31))
    x = 3.0 + 2.0 * swing + 0.005 * rng.standard_normal(samples)
    model = dehyst.PrandtlIshlinskii(np.linspace(0.0, 1.5, 12), np.r_[1.0, 0.3 * np.ones(11)])
    return time, x, model.simulate(x - 3.0) + noise * rng.standard_normal(samples)


def recording(time, x, y, breaks=()):
    return dehyst.Recording(
        input=x, output=y, time=time, breaks=breaks, name="made", input_name="pressure", output_name="angle",
        input_unit="bar", output_unit="deg",
    )  # fmt: skip


def same(first, second, tolerance=1e-12):
    """Both fits have the same family, start, parameters and scores."""
    assert first.family == second.family
    assert first.certificate.initial_state == second.certificate.initial_state
    pairs = zip(first.model.stepper("dense").parameters, second.model.stepper("dense").parameters, strict=True)
    for a, b in pairs:
        a, b = np.atleast_1d(a), np.atleast_1d(b)
        assert a.shape == b.shape
        assert np.max(np.abs(a - b), initial=0.0) <= tolerance * max(np.max(np.abs(a), initial=0.0), 1e-300)
    for name in ("train", "test", "static_train", "static_test"):
        a, b = getattr(first, name), getattr(second, name)
        assert (a is None) == (b is None)
        if a is not None:
            assert b.as_dict() == pytest.approx(a.as_dict(), rel=tolerance)
    a, b = first.certificate, second.certificate
    assert b.inverse_miss_percent == pytest.approx(a.inverse_miss_percent, rel=tolerance)
    assert (b.undetermined, b.affordable_eps, b.operators) == (a.undetermined, a.affordable_eps, a.operators)
    assert b.round_trip_error == pytest.approx(a.round_trip_error, abs=1e-14)
    assert first.facts.orientation == second.facts.orientation
    assert (first.facts.loops, first.facts.turns) == (second.facts.loops, second.facts.turns)
    codes = [{finding.code for finding in fit.warnings} for fit in (first, second)]
    assert codes[1] - {"streamed", "plays-only"} == codes[0]


@pytest.mark.slow
@pytest.mark.parametrize("family", ["auto", "pi", "pi-cumulative", "modified-pi", "stop"])
def test_the_result_is_that_of_the_same_samples_in_memory(family):
    time, x, y = record()
    expected = identify_plays(recording(time, x, y), family)
    same(expected, dehyst.identify_stream(Chunks(x, y, time), family))


@pytest.mark.parametrize("start", ["rest", "rising", "falling", "unknown", "origin"])
def test_every_start_state_gives_the_same_result(start):
    time, x, y = record(70_001)
    expected = dehyst.identify(recording(time, x, y), "pi", n=20, initial_state=start)
    same(expected, dehyst.identify_stream(Chunks(x, y, time), "pi", n=20, initial_state=start))


def test_the_length_of_the_chunks_changes_no_bit():
    time, x, y = record(70_000)
    sizes = (1 << 15, 1000, 4999, 32_769, 500_000)
    first, *fits = (dehyst.identify_stream(Chunks(x, y, time, size), "pi", n=12) for size in sizes)
    for size, fit in zip(sizes[1:], fits, strict=True):
        assert first.model.weights.tobytes() == fit.model.weights.tobytes(), size
        assert first.as_dict() == fit.as_dict(), size


@pytest.mark.parametrize(("fraction", "costly"), [(1.0, False), (0.13, True), (0.999, False)])
def test_any_part_may_be_fitted_with_a_temporary_copy_or_without(fraction, costly):
    time, x, y = record(80_000)
    expected = dehyst.identify(recording(time, x, y), "pi", n=10, train_fraction=fraction)
    source = Chunks(x, y, time, costly=costly)
    same(expected, dehyst.identify_stream(source, "pi", n=10, train_fraction=fraction))
    assert (source.passes == 1) == costly


def test_gaps_in_time_break_the_memory_as_they_do_in_memory():
    time, x, y = record(90_000)
    keep = np.ones(x.size, dtype=bool)
    keep[20_000:21_500], keep[40_000:40_900], keep[70_000:70_010] = False, False, False
    time, x, y = time[keep], x[keep], y[keep]
    breaks = tuple((np.flatnonzero(np.diff(time) > 0.5) + 1).tolist())
    assert len(breaks) == 2
    expected = dehyst.identify(recording(time, x, y, breaks), "pi", n=20)
    found = dehyst.identify_stream(Chunks(x, y, time), "pi", n=20)
    assert {"gap", "unknown-memory"} <= {finding.code for finding in found.warnings}
    same(expected, without_gap(found))
    kept = found.recordings[0]
    assert kept.input[list(kept.breaks)].tolist() == x[list(breaks)].tolist()


def without_gap(fit):
    """The fit without the finding about gaps, which belongs to reading."""
    return dataclasses.replace(fit, warnings=tuple(f for f in fit.warnings if f.code != "gap"))


def test_a_clock_that_restarts_begins_a_piece_and_one_that_is_lost_is_refused():
    time, x, y = record(70_000)
    again = np.where(np.arange(x.size) < 30_000, time, time - 60.0)
    expected = dehyst.identify(recording(again, x, y, (30_000,)), "pi", n=10)
    found = dehyst.identify_stream(Chunks(x, y, again), "pi", n=10)
    assert found.recordings[0].breaks and found.train.as_dict() == pytest.approx(expected.train.as_dict())
    assert "clock-restart" in {finding.code for finding in found.warnings}
    with pytest.raises(TimeError, match="--time"):
        dehyst.identify_stream(Chunks(x, y, np.sin(time)), "pi", n=10)


@pytest.mark.slow
def test_several_logs_are_fitted_together():
    logs = [record(50_000, 1), record(70_000, 2)]
    expected = dehyst.identify([recording(*log) for log in logs], "pi", n=10)
    found = dehyst.identify_stream([Chunks(x, y, t, costly=k == 1) for k, (t, x, y) in enumerate(logs)], "pi", n=10)
    same(expected, found)
    assert [kept.samples for kept in found.recordings] == [50_000, 70_000]


@pytest.mark.slow
def test_a_falling_curve_and_a_wide_loop_are_told_apart_as_in_memory():
    time, x, y = record(60_000)
    wide = dehyst.PrandtlIshlinskii([0.0, 1.6], [0.01, 1.0]).simulate(x - 3.0)
    for output in (-y, wide, -wide):
        expected = identify_plays(recording(time, x, output), n=8)
        same(expected, dehyst.identify_stream(Chunks(x, output, time), n=8), 1e-11)


@pytest.mark.slow
def test_a_long_log_is_kept_as_its_extremes_and_its_predictions_are_those_of_all_samples():
    time, x, y = record(400_000)
    expected = dehyst.identify(recording(time, x, y), "pi", n=10)
    found = dehyst.identify_stream(Chunks(x, y, time, 50_000), "pi", n=10)
    same(expected, found)
    kept = found.recordings[0]
    assert kept.samples == 400_000 == kept.provenance["samples"]
    assert len(kept) < 200_000
    places = np.searchsorted(time, kept.time)
    for ours, all_ in (
        (kept.input, x),
        (kept.output, y),
        (found.predictions[0], expected.predictions[0]),
        (found.inverse_predictions[0], expected.inverse_predictions[0]),
        (found.train_masks[0], expected.train_masks[0]),
        (found.test_masks[0], expected.test_masks[0]),
    ):
        np.testing.assert_allclose(ours, all_[places], rtol=0, atol=1e-11)
    assert (kept.input.min(), kept.output.max(), kept.input[-1]) == (x.min(), y.max(), x[-1])
    assert found.model.card.input.low == x.min()
    assert found.facts.drift_percent == pytest.approx(expected.facts.drift_percent, rel=1e-6)
    assert found.facts.rate_dependence_percent == pytest.approx(expected.facts.rate_dependence_percent, rel=1e-6)


def columns(folder, kind, time, x, y):
    """The log as a file of some kind."""
    file = folder / f"log.{kind}"
    if kind == "csv":
        rows = (f"{a!r},{b!r},{c!r}\n" for a, b, c in zip(time.tolist(), x.tolist(), y.tolist(), strict=True))
        file.write_text("time_s,pressure_bar,angle_deg\n" + "".join(rows))
    elif kind == "npz":
        np.savez(file, time_s=time, pressure_bar=x, angle_deg=y)
    elif kind == "packed.npz":
        np.savez_compressed(file, time_s=time, pressure_bar=x, angle_deg=y)
    else:
        polars = pytest.importorskip("polars")
        polars.DataFrame({"time_s": time, "pressure_bar": x, "angle_deg": y}).write_parquet(file)
    return file


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["csv", "npz", "packed.npz", "parquet"])
def test_a_file_in_chunks_gives_the_result_of_the_file_read_at_once(tmp_path, kind):
    time, x, y = record(40_000)
    file = columns(tmp_path, kind, time, x, y)
    expected = dehyst.identify(dehyst.read_log(file, "pressure", "angle"), "pi", n=20)
    log = dehyst.open_chunks(file, "pressure", "angle", rows=7777)
    found = dehyst.identify_stream(log, "pi", n=20)
    same(expected, found)
    assert log.costly == (kind in ("csv", "packed.npz"))
    kept, whole = found.recordings[0], expected.recordings[0]
    assert (kept.input_label, kept.output_label) == (whole.input_label, whole.output_label)
    assert kept.provenance["sha256"] == whole.provenance["sha256"]


def test_a_bag_in_chunks_gives_the_result_of_the_bag_read_at_once(tmp_path):
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kind, point = "geometry_msgs/msg/Point", store.types["geometry_msgs/msg/Point"]
    time, x, y = record(3000)
    folder = tmp_path / "bag"
    with rosbag2.Writer(folder, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
        link = writer.add_connection("/joint", kind, typestore=store)
        for t, a, b in zip(time, x, y, strict=True):
            writer.write(link, int(1e9 * (t + 1)), store.serialize_cdr(point(a, b, 0.0), kind))
    file = next(folder.glob("*.mcap"))
    names = {"input": "/joint.x", "output": "/joint.y"}
    expected = dehyst.identify(dehyst.read_log(file, **names), "pi", n=10)
    same(expected, dehyst.identify_stream(dehyst.open_chunks(file, **names, rows=700), "pi", n=10))


@pytest.mark.slow
def test_the_fit_makes_a_report_and_a_model_file(tmp_path):
    time, x, y = record(80_000)
    fit = dehyst.identify_stream(Chunks(x, y, time), "pi", n=10)
    page = dehyst.write_report(fit, tmp_path / "report.html")
    assert "80000 samples" in Path(page or tmp_path / "report.html").read_text(encoding="utf-8")
    loaded = dehyst.load(fit.model.save(tmp_path / "model.json"))
    assert loaded.weights.tolist() == fit.model.weights.tolist()
    assert loaded.card.provenance["logs"][0]["samples"] == 80_000
    json.dumps(fit.as_dict())


def test_progress_names_every_stage_in_order_and_never_goes_back():
    time, x, y = record(70_000)
    seen = []
    dehyst.identify_stream(Chunks(x, y, time), "auto", n=10, progress=seen.append)
    stages = list(dict.fromkeys(now.stage for now in seen))
    assert stages == list(STAGES)
    assert {now.of for now in seen} == {len(STAGES)}
    assert [now.number for now in seen] == sorted(now.number for now in seen)
    for now in seen:
        assert now.done >= 0 and (now.done <= now.total or now.total == 0)
    assert max(now.done for now in seen if now.stage == "scoring") == 70_000


# ---- The parts

signals = st.lists(st.integers(-6, 6), min_size=1, max_size=60)


@given(signals, st.lists(st.integers(1, 9), min_size=1, max_size=60), st.sampled_from([0.5, 1.5, 2.5, 4.5]))
def test_turning_points_of_blocks_are_those_of_the_whole(values, cuts, swing):
    x = np.array(values, dtype=np.float64)
    zigzag, begin, found = Zigzag(swing), 0, []
    for cut in [*cuts, x.size]:
        if begin < x.size:
            found += zigzag.add(begin, x[begin : begin + cut])[:, 0].astype(int).tolist()
            begin = min(x.size, begin + cut)
    expected = turning_points(x, swing).tolist()
    assert x[found].tolist() == x[[k for k in expected if 0 < k < x.size - 1]].tolist() or found == expected[1:-1]
    assert zigzag.inner == len(found)


def test_drift_of_blocks_is_that_of_the_whole():
    from dehyst.identification.facts import drift

    rng = np.random.default_rng(0)
    x = np.sin(0.01 * np.arange(20_000)) + 0.001 * rng.standard_normal(20_000)
    residual = 1e-5 * np.arange(x.size) + 0.1 * rng.standard_normal(x.size)
    cycles = Cycles(0.05 * float(np.ptp(x)), 2, float(x.min()), float(x.max()))
    for k in range(0, x.size, 777):
        part = slice(k, k + 777)
        cycles.add(k, x[part], np.array([residual[part], -residual[part]]))
    assert cycles.drift(0) == pytest.approx(drift(x, residual), rel=1e-9)
    assert cycles.drift(1)[0] == pytest.approx(-drift(x, residual)[0], rel=1e-9)


@given(st.integers(1, 400), st.sampled_from([4, 8, 16]), st.sampled_from([4, 8, 32]), st.integers(0, 99))
def test_an_outline_keeps_extremes_and_sums_of_any_length(samples, block, most, seed):
    rng = np.random.default_rng(seed)
    x, y = rng.standard_normal((2, samples)).round(1)
    outline = Outline(most)
    for k in range(0, samples, block):
        outline.add(None, x[k : k + block], y[k : k + block])
    rows = outline.rows()
    places = rows[:, 0].astype(int)
    assert rows[:, 1].tolist() == x[places].tolist() and rows[:, 2].tolist() == y[places].tolist()
    assert np.all(np.diff(places) > 0) and places[0] == 0 and places[-1] == samples - 1
    assert {x.min(), x.max()} <= set(rows[:, 1]) and {y.min(), y.max()} <= set(rows[:, 2])
    assert len(places) <= 5 * (most + block) + 1
    start, stop = sorted(rng.integers(0, samples + 1, 2).tolist())
    low, high, begin, end = outline.extremes(start, stop, 0)
    if begin < end:
        assert start <= begin and end <= stop
        assert (low, high) == (x[begin:end].min(), x[begin:end].max())
    sums, (x0, y0), end = outline.moments(stop)
    assert end <= stop
    a, b = x[:end] - x0, y[:end] - y0
    assert sums == pytest.approx(np.array([end, a.sum(), b.sum(), a @ a, b @ b, a @ b]), abs=1e-9)
    first = outline.first_beyond(float(x.max()), False, 0)
    assert first <= int(np.argmax(x)) < first + outline.size


def test_pieces_of_a_stream_say_what_those_in_memory_say(monkeypatch):
    monkeypatch.setattr("dehyst.identification.short_signal.OFTEN", 2)
    time, x, y = record(150_000)
    keep = np.ones(x.size, dtype=bool)
    keep[61_000:62_000] = False
    time, x, y = time[keep], x[keep], y[keep]
    source = Chunks(x, y, time)
    log = read(source, Tape(source, "made", Watch(None), copied=False))
    rec = recording(time, x, y, (61_000,))
    streamed = prepare([log], split_logs([log], 0.6))
    whole = prepare_in_memory([rec], split_recordings([rec], 0.6))
    for name in ("center", "half_range", "level", "amplitude", "trend", "output_range"):
        assert getattr(streamed, name) == getattr(whole, name)
    for a, b in zip(streamed.pieces, whole.pieces, strict=True):
        assert (a.start, a.split, a.known, a.within, a.after_break) == (
            b.start,
            b.split,
            b.known,
            b.within,
            b.after_break,
        )
        assert a.x.size == b.x.size
        assert a.x[100:40_000].tobytes() == b.x[100:40_000].tobytes()
        assert a.y[0] == b.y[0]
    for a, b in zip(branches(streamed), branches_in_memory(whole), strict=True):
        assert a.inner == b.inner
        for name in ("x", "y", "falling"):
            assert getattr(a, name).tobytes() == getattr(b, name).tobytes()
    for start in ("zero", "unknown"):
        for a, b in zip(shorten(streamed, start, 500).pieces, shorten(whole, start, 500).pieces, strict=True):
            for name in ("x", "place", "y"):
                assert getattr(a, name).tobytes() == getattr(b, name).tobytes()


# ---- Memory

MEMORY = """
    import resource, sys
    import numpy as np
    import dehyst

    class Sine:
        name = "sine"
        def __init__(self, chunks): self.chunks = chunks
        def __iter__(self):
            for k in range(self.chunks):
                t = np.arange(k << 17, (k + 1) << 17) * 0.0005
                x = np.sin(t)
                yield None, x, np.maximum(x - 0.2, 0.0) + x

    dehyst.identify_stream(Sine(2), "pi", n=10)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    dehyst.identify_stream(Sine(int(sys.argv[1])), "pi", n=10)
    print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)
"""


def run(code, *arguments):
    command = [sys.executable, "-c", textwrap.dedent(code), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="resource is of POSIX")
def test_memory_does_not_grow_with_the_log():
    # 64 chunks are 134 MB of samples, of which a list of x or y alone would be half.
    assert float(run(MEMORY, "64")) < 40.0


@pytest.mark.slow
def test_no_array_of_the_length_of_the_log_is_made_anywhere(tmp_path):
    time, x, y = record(1 << 22)
    peaks = []
    for samples in (1 << 16, 1 << 19, 1 << 22):  # the first one imports what is imported late
        source = Chunks(x[:samples], y[:samples], time[:samples], 1 << 15, costly=True)
        tracemalloc.start()
        dehyst.identify_stream(source, "pi", n=10, spool_dir=tmp_path)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    # An array of the samples that the last one has more would take 29 MB.
    assert peaks[2] - peaks[1] < 14e6


# ---- Faults


def test_an_interrupted_pass_leaves_nothing_behind(tmp_path):
    time, x, y = record(80_000)

    class Interrupted(Chunks):
        def __iter__(self):
            for k, chunk in enumerate(super().__iter__()):
                if k == 8:
                    raise KeyboardInterrupt
                yield chunk

    with pytest.raises(KeyboardInterrupt):
        dehyst.identify_stream(Interrupted(x, y, time, costly=True), "pi", spool_dir=tmp_path)
    assert list(tmp_path.iterdir()) == []
    dehyst.identify_stream(Chunks(x, y, time, costly=True), "pi", n=5, spool_dir=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_disk_without_room_is_refused_before_it_is_full(tmp_path, monkeypatch):
    time, x, y = record(80_000)
    source = Chunks(x, y, time, costly=True)
    source.size, source.consumed = 1e9, 1e6
    monkeypatch.setattr(spools.shutil, "disk_usage", lambda folder: type("Usage", (), {"free": 1e9}))
    with pytest.raises(OutputError, match=r"--spool-dir.*TMPDIR.*NPZ"):
        dehyst.identify_stream(source, spool_dir=tmp_path)
    monkeypatch.undo()
    with pytest.raises(OutputError, match="--spool-dir"):
        dehyst.identify_stream(source, spool_dir=tmp_path / "nowhere")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_disk_that_runs_full_is_an_error_that_cures(tmp_path, monkeypatch):
    time, x, y = record(80_000)
    full = Path("/dev/full")
    monkeypatch.setattr(spools.tempfile, "TemporaryFile", lambda **_: full.open("r+b", buffering=0))
    with pytest.raises(OutputError, match=r"No space left on device.*another folder"):
        dehyst.identify_stream(Chunks(x, y, time, costly=True), spool_dir=tmp_path)


@pytest.mark.parametrize("how", ["longer", "shorter", "other"])
def test_a_log_that_changes_between_passes_is_refused(how):
    time, x, y = record(80_000)

    class Growing(Chunks):
        def __iter__(self):
            if self.passes == 2:
                if how == "longer":
                    self.x, self.y, self.time = np.r_[x, x], np.r_[y, y], np.r_[time, time + 160]
                elif how == "shorter":
                    self.x, self.y, self.time = x[:70_000], y[:70_000], time[:70_000]
                else:
                    self.y = y + 1.0
            return super().__iter__()

    with pytest.raises(LogError, match=r"changed while it was read.*copy"):
        dehyst.identify_stream(Growing(x, y, time), "pi", n=10)


@pytest.mark.parametrize(
    ("chunk", "error", "word"),
    [
        ((None, np.zeros(3), np.zeros(2)), LogError, "one length"),
        ((None, np.zeros((3, 1)), np.zeros((3, 1))), LogError, "one length"),
        ((None, np.array([0.0, np.nan]), np.zeros(2)), LogError, "not finite"),
        ((np.array([0.0, np.inf]), np.zeros(2), np.zeros(2)), LogError, "not finite"),
        ((None, np.zeros(2), np.zeros(2)), RecordingError, "at least 4"),
        ((None, np.zeros(0), np.zeros(0)), RecordingError, "at least 4"),
        ((None, np.zeros(100), np.arange(100.0)), ExcitationError, "stays at 0"),
        ((None, np.arange(100.0), np.ones(100)), ExcitationError, "stays at 1"),
    ],
)
def test_chunks_that_are_none_and_signals_that_rest_are_refused(chunk, error, word):
    with pytest.raises(error, match=word):
        dehyst.identify_stream([type("Source", (), {"__iter__": lambda self: iter([chunk])})()])


def test_time_in_some_chunks_only_is_refused():
    chunks = [(np.arange(3.0), np.arange(3.0), np.arange(3.0)), (None, np.arange(3.0), np.arange(3.0))]
    with pytest.raises(LogError, match="all of them"):
        dehyst.identify_stream(type("Source", (), {"__iter__": lambda self: iter(chunks)})())


def test_what_can_be_read_only_once_is_refused():
    time, x, y = record(5000)
    for source in ((chunk for chunk in Chunks(x, y, time)), 3, []):
        with pytest.raises(ParameterError, match="open_chunks"):
            dehyst.identify_stream(source)
    with pytest.raises(ParameterError, match="different units"):
        other = Chunks(x, y, time)
        other.input_unit = "Pa"
        dehyst.identify_stream([Chunks(x, y, time), other])
    with pytest.raises(ParameterError, match="train_fraction"):
        dehyst.identify_stream(Chunks(x, y, time), train_fraction=0.0)


# ---- The command


def invoke(capsys, *arguments):
    """Output of the command, in this process; errors as they are raised."""
    from dehyst.cli import app

    app(["identify", *map(str, arguments), "--input", "pressure", "--output", "angle"], standalone_mode=False)
    return capsys.readouterr().out


@pytest.mark.slow
def test_the_command_gives_the_same_figures_in_chunks_and_chooses_by_size(tmp_path, capsys, monkeypatch):
    log = columns(tmp_path, "csv", *record(40_000))
    options = (log, "--n", "10", "--family", "pi", "--json")
    whole = json.loads(invoke(capsys, *options))
    chunked = json.loads(invoke(capsys, *options, "--stream", "--spool-dir", tmp_path))
    codes = [found["code"] for found in chunked.pop("warnings")]
    assert "streamed" in codes
    assert codes.count("streamed") == 1
    whole.pop("warnings")
    whole.pop("residual")  # of the samples that figures show: fewer of a streamed log
    for key, value in whole.items():
        if key == "input_error":
            for part in value:
                assert chunked[key][part] == pytest.approx(value[part], rel=1e-9)
        elif isinstance(value, dict):
            assert chunked[key].keys() == value.keys()
            for part, one in value.items():
                expected = pytest.approx(one, rel=1e-12) if isinstance(one, float) else one
                assert chunked[key][part] == expected
        elif isinstance(value, float):
            assert chunked[key] == pytest.approx(value, rel=1e-12, abs=1e-14)
    monkeypatch.setattr("dehyst.app.logs.memory_size", lambda: 10.0 * log.stat().st_size)
    assert "streamed" not in invoke(capsys, *options, "--no-stream")
    assert "streamed" not in invoke(capsys, *options)
    monkeypatch.setattr("dehyst.app.logs.memory_size", lambda: 9.9 * log.stat().st_size)
    assert "streamed" in invoke(capsys, *options)
    assert "streamed" not in invoke(capsys, *options, "--from", "1")


def test_what_does_not_go_in_chunks_is_refused_if_asked_for_and_read_at_once_if_not(tmp_path, capsys, monkeypatch):
    time, x, y = record(2000)
    log = columns(tmp_path, "csv", time, x, y)
    with pytest.raises(ParameterError, match=r"--from and --to.*--no-stream"):
        invoke(capsys, log, "--stream", "--to", "3")
    odd = tmp_path / "odd.csv"
    odd.write_text(log.read_text(encoding="utf-8"), encoding="utf-16")
    with pytest.raises(LogError, match="cannot be read in chunks"):
        invoke(capsys, odd, "--stream")
    monkeypatch.setattr("dehyst.app.logs.memory_size", lambda: 1.0)
    assert "operators" in invoke(capsys, odd, "--n", "5", "--family", "pi")


def test_the_progress_bar_shows_stage_and_bytes_on_a_terminal_only():
    import io

    from rich.console import Console

    from dehyst.app.identify import stream_progress
    from dehyst.app.logs import memory_size

    screen = io.StringIO()
    with stream_progress(False, Console(file=screen, force_terminal=True, width=100)) as show:
        show(dehyst.Progress("summing", 4, 7, 5e8, 2e9))
    assert "summing, 4 of 7" in screen.getvalue()
    assert "0.5/2.0 GB" in screen.getvalue()
    for quiet, terminal in ((True, True), (False, False)):
        with stream_progress(quiet, Console(file=screen, force_terminal=terminal)) as show:
            assert show is None
    assert memory_size() > 1e8
