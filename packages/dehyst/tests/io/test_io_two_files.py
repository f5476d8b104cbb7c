"""Input and output in two files: what a place is, which clock counts, and how exactly two clocks are aligned."""

import json
import re
from itertools import accumulate
from pathlib import Path

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from dehyst import read_log
from dehyst.errors import ColumnError, LogError, ParameterError, TimeError
from dehyst.families import example
from dehyst.io import kit as io_kit
from dehyst.io import read_two_files, write_csv
from dehyst.io._alignment import align
from dehyst.io._two_files import signal_place
from test_identification_findings import PI

STEP = 0.02
FINE = np.arange(0.0, 130.0, 0.002)


def motion(t):
    """Swings of all sizes, no two alike."""
    return (0.55 + 0.45 * np.sin(0.09 * t + 0.4)) * np.sin(1.1 * t) + 0.2 * np.sin(0.31 * t)


def held(t, model=PI):
    """Output of a rate-independent actuator at some times: simulated finely, as no instrument logs it."""
    return np.interp(t, FINE, model.simulate(motion(FINE)))


def logged(begin, drift=0.0, step=0.013, lasts=90.0, noise=0.0, model=PI, seed=0):
    """Stamps and output of an instrument whose first sample is at `begin`, and whose seconds are longer by `drift`."""
    t = np.arange(0.0, lasts, step)
    y = held(begin + (1.0 + drift) * t, model)
    return t, y + noise * np.ptp(y) * np.random.default_rng(seed).standard_normal(t.size)


TX = np.arange(0.0, 110.0, STEP)
X = motion(TX)


def error_in_the_middle(found, begin, drift, t):
    """By how much an alignment is wrong at the middle of the output. [s]"""
    middle = 0.5 * t[-1]
    return found.begin + (1.0 + found.drift) * middle - begin - (1.0 + drift) * middle


@pytest.fixture
def files(tmp_path):
    """Write u.csv and y.csv, the output from 7.31 s on; return their paths."""

    def write(begin=7.31, zero=0.0, y_zero=0.0, **options):
        t, y = logged(begin, **options)
        u_path, y_path = tmp_path / "u.csv", tmp_path / "y.csv"
        write_csv(u_path, {"time_s": zero + TX, "voltage_V": X})
        write_csv(y_path, {"time_s": y_zero + t, "position_um": y})
        return (u_path, "voltage"), (y_path, "position")

    return write


def codes(record):
    return [finding.code for finding in record.findings]


# --- clocks


@pytest.mark.parametrize("drift", [0.0, 4e-5, -2e-4])
def test_offset_is_exact_to_a_fraction_of_a_step_and_drift_to_a_few_ppm(drift):
    t, y = logged(12.345, drift)
    found = align(TX, X, t, y)
    assert abs(error_in_the_middle(found, 12.345, drift, t)) < 0.15 * STEP
    assert abs(found.drift - drift) < max(5e-6, found.drift_doubt)
    assert found.begin_doubt < STEP
    assert found.explained > 0.999
    if drift == 0.0:
        assert found.drift == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.003, 0.02])
def test_noise_of_both_signals_stays_within_the_doubt(noise):
    rng = np.random.default_rng(3)
    for begin, drift in ((3.2, 3e-5), (15.01, -6e-5)):
        t, y = logged(begin, drift, noise=noise)
        x = X + noise * np.ptp(X) * rng.standard_normal(X.size)
        found = align(TX, x, t, y)
        assert abs(error_in_the_middle(found, begin, drift, t)) < found.begin_doubt < 4 * STEP


@pytest.mark.slow
@pytest.mark.parametrize("family", ["bouc-wen", "dahl", "preisach", "generalised-pi"])
def test_loops_of_the_literature_are_no_offset(family):
    t, y = logged(5.005, model=example(family))
    found = align(TX, X, t, y)
    assert found.explained > 0.98
    assert abs(error_in_the_middle(found, 5.005, 0.0, t)) < STEP


def test_a_wide_loop_is_no_offset_and_a_pure_delay_is_one():
    wide = type(PI)([0.0, 0.6], [0.05, 1.0])
    for delay in (0.0, 0.4):
        t, y = logged(8.0 - delay, model=wide)
        assert align(TX, X, t, y).begin == pytest.approx(8.0 - delay, abs=0.5 * STEP)


def test_a_first_order_lag_counts_as_offset_as_the_finding_says():
    pole = np.exp(-0.002 / 0.1)
    y = PI.simulate(motion(FINE))
    late = np.fromiter(accumulate(y, lambda last, now: pole * last + (1.0 - pole) * now), float)
    t = np.arange(0.0, 90.0, 0.013)
    found = align(TX, X, t, np.interp(8.0 + t, FINE, late))
    assert found.begin == pytest.approx(8.0 - 0.1, abs=0.02)


def test_a_hole_in_the_log_of_the_input_moves_nothing():
    t, y = logged(8.0)
    rows = np.r_[0:1500, 2000 : TX.size]
    found = align(TX[rows], X[rows], t, y)
    assert found.begin == pytest.approx(8.0, abs=0.5 * STEP)


def test_a_falling_output_is_aligned_as_a_rising_one():
    t, y = logged(9.99)
    rising, falling = align(TX, X, t, y), align(TX, X, t, -3.0 * y)
    assert falling.begin == pytest.approx(rising.begin, abs=1e-3 * STEP)


@pytest.mark.slow
@settings(max_examples=10, deadline=None, derandomize=True, phases=[Phase.generate])
@given(
    begin=st.floats(-30.0, 40.0),
    step=st.sampled_from([0.004, 0.02, 0.05]),
    scale=st.floats(1e-6, 1e6),
)
def test_any_offset_rate_and_unit_is_found(begin, step, scale):
    # The input's log begins late enough for outputs that begin before it.
    tx = TX + 30.0
    lasts = 0.9 * (FINE[-1] - 40.0 - begin)
    t = np.arange(0.0, min(lasts, 70.0), step)
    y = held(begin + 30.0 + t)
    x = motion(tx[tx < FINE[-1]])
    found = align(tx[: x.size] - 30.0, scale * x, t, -5.0 + y / scale)
    assert abs(found.begin + found.drift * 0.5 * t[-1] - begin) < 0.6 * max(STEP, step)


def test_doubling_both_clocks_doubles_the_offset():
    t, y = logged(6.5)
    once, twice = align(TX, X, t, y), align(2.0 * TX, X, 2.0 * t, y)
    assert twice.begin == pytest.approx(2.0 * once.begin, rel=1e-6)
    assert twice.begin_doubt == pytest.approx(2.0 * once.begin_doubt, rel=1e-3)


def test_periods_that_are_alike_are_named():
    tx = np.arange(0.0, 80.0, STEP)
    t = np.arange(0.0, 50.0, STEP)
    y = PI.simulate(np.sin(FINE))
    found = align(tx, np.sin(tx), t, np.interp(t + 40.0, FINE, y))
    assert found.rival is not None
    period = 2.0 * np.pi
    for begin in (found.begin, found.rival):
        assert abs((begin - 40.0 + period / 4) % (period / 2) - period / 4) < STEP


def test_too_few_samples_are_not_aligned():
    assert align(TX[:10], X[:10], TX[:10], X[:10]) is None
    assert align(TX, 0.0 * X, TX, X) is None


# --- files


def test_two_files_on_clocks_of_their_own_give_the_loop_of_one(files):
    record = read_two_files(*files(drift=5e-5))
    assert codes(record) == ["aligned-clocks"]
    assert record.name == "u.csv and y.csv"
    assert (record.input_label, record.output_label) == ("voltage [V]", "position [um]")
    # The recording is on the input's samples, and its output is the actuator's at these.
    np.testing.assert_array_equal(record.input, X[np.isin(TX, record.time)])
    assert np.max(np.abs(record.output - held(record.time))) < 0.01 * np.ptp(record.output)
    clocks = record.provenance["clocks"]
    assert clocks["begin_s"] == pytest.approx(7.31, abs=0.4 * STEP)
    assert clocks["drift_ppm"] == pytest.approx(50.0, abs=6.0)
    assert record.provenance["file"] == "u.csv" and record.provenance["output_file"] == "y.csv"


def test_equal_stamps_are_one_clock_and_are_read_as_one_file(tmp_path):
    y = PI.simulate(X)
    write_csv(tmp_path / "u.csv", {"time_s": TX, "voltage_V": X})
    write_csv(tmp_path / "y.csv", {"time_s": TX, "position_um": y})
    write_csv(tmp_path / "both.csv", {"time_s": TX, "voltage_V": X, "position_um": y})
    two = read_two_files((tmp_path / "u.csv", "voltage"), (tmp_path / "y.csv", "position"))
    one = read_log(tmp_path / "both.csv", "voltage", "position")
    for name in ("time", "input", "output"):
        np.testing.assert_array_equal(getattr(two, name), getattr(one, name))
    assert two.findings == one.findings == ()


def test_epochs_that_overlap_are_kept_and_a_disagreement_is_said(files):
    places = files(zero=1.76e9, y_zero=1.76e9 + 7.31)
    assert codes(read_two_files(*places)) == ["two-clocks"]
    places = files(zero=1.76e9, y_zero=1.76e9 + 7.31 + 0.5)
    late = read_two_files(*places)
    assert codes(late) == ["shape-offset", "two-clocks"]
    assert re.search(r"turns 0\.(49\d|5) s after the input", late.findings[0].message)
    aligned = read_two_files(*places, clocks="shape")
    assert codes(aligned) == ["aligned-clocks"]
    assert aligned.provenance["clocks"]["begin_s"] == pytest.approx(7.31, abs=0.2 * STEP)


def test_two_loggers_that_both_begin_at_zero_are_no_one_clock_in_silence(files, tmp_path):
    places = files()
    write_csv(tmp_path / "y.csv", {"time_s": TX, "position_um": held(TX + 3.0)})
    record = read_two_files(*places)
    assert codes(record) == ["shape-offset"]
    assert re.search(r"turns (3|2\.99|3\.0\d?) s before the input", record.findings[0].message)
    aligned = read_two_files(*places, clocks="shape")
    assert aligned.provenance["clocks"]["begin_s"] == pytest.approx(3.0, abs=0.2 * STEP)


def test_epochs_an_hour_apart_are_aligned(files):
    record = read_two_files(*files(zero=1.76e9, y_zero=1.76e9 + 3607.31))
    assert codes(record) == ["aligned-clocks"]
    assert record.provenance["clocks"]["begin_s"] == pytest.approx(7.31, abs=0.2 * STEP)


def test_stamps_of_one_clock_can_be_kept(files):
    places = files(begin=7.31, y_zero=7.31)
    record = read_two_files(*places, clocks="stamps")
    assert codes(record) == ["two-clocks"]
    assert record.time[0] == pytest.approx(7.32)
    assert "clocks" not in record.provenance


def test_a_window_is_one_of_the_inputs_time(files):
    record = read_two_files(*files(), start=20.0, stop=60.0)
    assert record.time[0] == pytest.approx(20.0, abs=1.1 * STEP) and record.time[-1] < 60.0
    assert np.max(np.abs(record.output - held(record.time))) < 0.01 * np.ptp(record.output)


def test_one_column_each_is_aligned_with_a_step_and_refused_without(tmp_path):
    u_path, y_path = tmp_path / "u.txt", tmp_path / "y.txt"
    np.savetxt(u_path, X)
    np.savetxt(y_path, held(TX + 4.1)[:4000])
    places = (u_path, "#1"), (y_path, "#1")
    with pytest.raises(TimeError, match=r"5500 samples, y\.txt 4000.*--dt 0\.001"):
        read_two_files(*places)
    record = read_two_files(*places, dt=STEP)
    assert record.provenance["clocks"]["begin_s"] == pytest.approx(4.1, abs=0.2 * STEP)
    assert (record.input_name, record.output_name) == ("u", "y")


def test_equally_many_rows_without_time_belong_together_row_by_row(tmp_path):
    np.savetxt(tmp_path / "u.txt", X)
    np.savetxt(tmp_path / "y.txt", PI.simulate(X))
    record = read_two_files((tmp_path / "u.txt", "#1"), (tmp_path / "y.txt", "#1"))
    np.testing.assert_array_equal(record.input, X)
    assert record.time is None and codes(record) == ["no-time"]


def test_dt_is_for_the_file_without_a_clock(files, tmp_path):
    places = files()
    np.savetxt(tmp_path / "y.txt", held(4.1 + TX)[:4000])
    record = read_two_files(places[0], (tmp_path / "y.txt", "#1"), dt=STEP)
    assert record.provenance["clocks"]["begin_s"] == pytest.approx(4.1, abs=0.2 * STEP)
    with pytest.raises(TimeError, match=r"y\.txt no time column.*--dt"):
        read_two_files(places[0], (tmp_path / "y.txt", "#1"))


@pytest.mark.slow
def test_unrelated_files_are_refused_with_the_numbers(files, tmp_path):
    places = files()
    t = np.arange(0.0, 90.0, 0.02)
    other = np.cumsum(np.random.default_rng(5).standard_normal(t.size))
    write_csv(tmp_path / "z.csv", {"time_s": t, "position_um": other})
    with pytest.raises(TimeError, match=r"\d+ % of the variance.*80 %.*--clocks stamps") as error:
        read_two_files(places[0], (tmp_path / "z.csv", "position"))
    assert error.value.facts["explained"] < 0.8


def test_clocks_without_a_common_zero_are_not_kept(files):
    with pytest.raises(TimeError, match=r"no common zero.*--clocks shape"):
        read_two_files(*files(zero=1.76e9), clocks="stamps")


def test_stamps_apart_are_refused(files):
    with pytest.raises(TimeError, match="do not overlap"):
        read_two_files(*files(y_zero=500.0), clocks="stamps")


def test_a_clock_that_restarts_is_refused(tmp_path, files):
    places = files()
    t, y = logged(7.31)
    write_csv(tmp_path / "y.csv", {"time_s": np.r_[t, t], "position_um": np.r_[y, y]})
    with pytest.raises(TimeError, match=r"y\.csv restarts.*one recording in each file"):
        read_two_files(*places)


def test_wrong_words_have_cures(files):
    places = files()
    with pytest.raises(ParameterError, match="auto, stamps, shape"):
        read_two_files(*places, clocks="both")
    with pytest.raises(ColumnError, match="no output column 'angle'"):
        read_two_files(places[0], (places[1][0], "angle"))
    with pytest.raises(LogError, match="cannot read"):
        read_two_files(places[0], (places[1][0].with_name("none.csv"), "angle"))


# --- places


def test_a_file_of_that_very_name_wins_and_a_drive_is_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("u.csv").write_text("a\n1\n")
    assert signal_place("u.csv:a") == (Path("u.csv"), "a")
    assert signal_place("u.csv:a:b") == (Path("u.csv"), "a:b")
    for whole in ("u.csv", "u.csv:", r"C:\u.csv", "C:/u.csv", ":a", ""):
        assert signal_place(whole) is None
    Path("u.csv:a").write_text("a\n1\n")
    assert signal_place("u.csv:a") is None
    # A folder with a dot is no file, and a name with a colon is found beside it.
    Path("v:1.csv").write_text("a\n1\n")
    assert signal_place("v:1.csv:a") == (Path("v:1.csv"), "a")


def test_two_places_or_none():
    assert io_kit.two_places(["u.csv", "y.csv"]) is None
    pair = io_kit.two_places(["u.csv:a", "y.csv:b"])
    assert pair == ((Path("u.csv"), "a"), (Path("y.csv"), "b"))
    for logs in (["u.csv:a"], ["u.csv:a", "y.csv"], ["u.csv:a", "y.csv:b", "z.csv:c"]):
        with pytest.raises(ParameterError, match="two are needed"):
            io_kit.two_places(logs)


# --- the command line


@pytest.mark.slow
def test_the_line_that_is_printed_can_be_typed(files, run, tmp_path, monkeypatch):
    files()
    monkeypatch.chdir(tmp_path)
    status, out, _ = run("inspect", "u.csv:voltage", "y.csv:position")
    assert status == 0
    assert "next: dehyst identify u.csv:voltage y.csv:position" in out
    status, out, _ = run(
        "identify", "u.csv:voltage", "y.csv:position", "--family", "pi", "--save", "m.json"
    )
    assert status == 0 and "aligned-clocks" in out
    assert "--output position" in out
    # A command can be repeated: the model in the file is of the same two files.
    again = run("identify", "u.csv:voltage", "y.csv:position", "--family", "pi", "--save", "m.json")
    assert again[0] == 0
    (log,) = json.loads(Path("m.json").read_text())["provenance"]["logs"]
    assert log["clocks"]["begin_s"] == pytest.approx(7.31, abs=0.2 * STEP)


def test_inspect_of_two_files_is_json_too(files, run, tmp_path, monkeypatch):
    files()
    monkeypatch.chdir(tmp_path)
    status, out, _ = run("inspect", "u.csv:voltage", "y.csv:position", "--json")
    content = json.loads(out)
    assert status == 0
    assert content["clocks"]["begin_s"] == pytest.approx(7.31, abs=0.2 * STEP)
    assert [entry["name"] for entry in content["files"]] == ["u.csv", "y.csv"]


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("inspect u.csv y.csv", "dehyst inspect u.csv:COLUMN y.csv:COLUMN"),
        ("inspect u.csv --clocks shape", "dehyst inspect u.csv:COLUMN y.csv:COLUMN"),
        ("identify u.csv --clocks shape", "u.csv:COLUMN y.csv:COLUMN"),
        ("identify u.csv:voltage y.csv", "two are needed"),
        ("identify u.csv:voltage y.csv:position --input a", "--input a names a column"),
        ("loops u.csv:voltage y.csv:position --out u.csv", "is the log itself"),
    ],
)
def test_what_makes_no_pair_is_refused_with_a_cure(line, named, files, run, tmp_path, monkeypatch):
    files()
    monkeypatch.chdir(tmp_path)
    status, out, err = run(*line.split())
    assert status == 2 and out == ""
    assert named in " ".join(err.split())
