"""inspect_log: what a log holds, which columns look like input and output, and what to type next."""

import math
import shlex
import time

import numpy as np
import pytest

from dehyst.app._inspect import run_inspect
from dehyst.app.requests import InspectRequest
from dehyst.errors import OutputError, RunError
from dehyst.io import inspect_log, read_log, write_csv
from places import DATA

REAL = DATA

T = np.arange(500) * 0.02
WAVE = np.sin(2 * np.pi * T / 2.5)
LAG = np.sin(2 * np.pi * T / 2.5 - 0.3)


def test_the_summary_tells_units_ranges_loops_and_missing_cells(tmp_path):
    angle = 20 * LAG
    angle[:50] = np.nan
    columns = {
        "time_s": T,
        "pressure_bar": 3 + WAVE,
        "angle_deg": angle,
        "load_N": np.full(500, 7.0),
    }
    summary = inspect_log(write_csv(tmp_path / "log.csv", columns))
    by_name = {column.name: column for column in summary.columns}
    assert [column.name for column in summary.columns] == list(columns)
    assert by_name["pressure_bar"].unit == "bar"
    assert (by_name["pressure_bar"].minimum, by_name["pressure_bar"].maximum) == pytest.approx(
        (2.0, 4.0), abs=1e-3
    )
    assert by_name["pressure_bar"].loops == 4
    assert by_name["angle_deg"].missing == pytest.approx(0.1)
    assert by_name["angle_deg"].samples == 450
    assert by_name["load_N"].constant
    assert [by_name[name].role for name in columns] == ["time", "input", "output", ""]
    assert summary.rows == 500
    assert summary.runs == {}


def test_the_sampling_is_measured(tmp_path):
    keep = np.delete(np.arange(500), np.arange(100, 120))
    time = T[keep].copy()
    time[[200, 300]] = time[[199, 299]]
    file = write_csv(
        tmp_path / "log.csv", {"time_ms": 1000 * time, "p_bar": WAVE[keep], "angle_deg": LAG[keep]}
    )
    sampling = inspect_log(file).sampling
    assert sampling is not None
    assert sampling.column == "time_ms"
    assert sampling.median == pytest.approx(0.02)
    assert (sampling.gaps, sampling.repeated, sampling.backward) == (1, 2, 0)
    assert sampling.last == pytest.approx(T[-1])


def test_the_command_can_be_typed_as_it_stands(tmp_path):
    folder = tmp_path / "my logs"
    folder.mkdir()
    file = folder / "log.csv"
    rows = [
        f"{run},{t},{x},{y}"
        for run in ("it's 1", "b")
        for t, x, y in zip(T, WAVE, LAG, strict=True)
    ]
    file.write_text("run,time_s,pressure [bar],angle [deg]\n" + "\n".join(rows))
    summary = inspect_log(file)
    assert summary.run == "it's 1"
    assert summary.runs == {"it's 1": 500, "b": 500}
    words = shlex.split(summary.command)
    assert words[:2] == ["dehyst", "identify"]
    options = dict(zip(words[3::2], words[4::2], strict=True))
    recording = read_log(words[2], options["--input"], options["--output"], run=options["--run"])
    np.testing.assert_array_equal(recording.input, WAVE)
    with pytest.raises(RunError):
        inspect_log(file, run="c")


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["time_s", "angle_deg", "pressure_bar"], ("pressure_bar", "angle_deg")),
        (["time_s", "angle_cmd_deg", "angle_deg"], ("angle_cmd_deg", "angle_deg")),
        (["t", "x", "y"], ("x", "y")),
        (["t", "u", "y"], ("u", "y")),
        (["time_s", "force_N", "displacement_mm"], ("displacement_mm", "force_N")),
        (["time_s", "displacement_um", "voltage_v"], ("voltage_v", "displacement_um")),
    ],
)
def test_input_and_output_are_guessed_from_names_and_units(tmp_path, names, expected):
    summary = inspect_log(
        write_csv(tmp_path / "log.csv", dict(zip(names, (T, WAVE, LAG), strict=True)))
    )
    assert (summary.input, summary.output) == expected
    assert all(column.reason for column in summary.columns if column.role)


def test_nothing_is_guessed_from_a_single_signal(tmp_path):
    summary = inspect_log(write_csv(tmp_path / "log.csv", {"time_s": T, "angle_deg": LAG}))
    assert (summary.input, summary.output, summary.command) == (None, None, "")


def test_an_empty_column_has_no_range(tmp_path):
    file = write_csv(
        tmp_path / "log.csv", {"p_bar": WAVE, "q": np.full(500, np.nan), "angle_deg": LAG}
    )
    column = inspect_log(file).columns[1]
    assert (column.samples, column.missing, column.constant) == (0, 1.0, False)
    assert math.isnan(column.minimum)


def test_columns_of_different_lengths_are_not_written(tmp_path):
    for columns in ({"a": [1.0], "b": [1.0, 2.0]}, {}, {"a": np.zeros((2, 2))}):
        with pytest.raises(OutputError, match="vectors of one length"):
            write_csv(tmp_path / "log.csv", columns)
    assert not (tmp_path / "log.csv").exists()


# Real logs, where they are at hand. They never become part of the project.

CASES = [
    ("tendon_sheath_joint", "config_000", None, "angle_cmd_deg", "angle_deg", 510, []),
    ("tendon_sheath_joint", "config_180", None, "angle_cmd_deg", "angle_deg", 511, []),
    ("piezo_dbo", "model", 2.0, "voltage_v", "displacement_um", 7627, []),
    ("pneumatic_arm_segment", "oct28_exp5", 12.0, "pressure_interp_psi", "tilt_rad", 10600, []),
    ("cavatappi_muscle", "200g_s3_t1", None, "pressure_psi", "displacement_mm", 3580, ["gap"]),
    ("pam_wrist_joint", None, None, "pressure_mpa", "angle_deg", 297, ["few-loops"]),
    ("mr_damper", "ensaio1.2", None, "displacement_mm", "force_N", 3001, []),
]


@pytest.mark.parametrize(("folder", "run", "start", "x", "y", "rows", "codes"), CASES)
def test_real_logs_read_without_false_alarm_and_their_columns_are_guessed(
    folder, run, start, x, y, rows, codes
):
    file = REAL / folder / "data.csv.gz"
    if not file.exists():
        pytest.skip("measured logs are not at hand (shared/data beside the project)")
    recording = read_log(file, x, y, run=run, start=start)
    assert len(recording) == rows
    assert [finding.code for finding in recording.findings] == codes
    assert recording.breaks == ()
    summary = inspect_log(file, run=run)
    assert (summary.input, summary.output) == (x, y)


def test_the_held_pressure_of_a_real_log_is_found():
    file = REAL / "pneumatic_arm_segment" / "data.csv.gz"
    if not file.exists():
        pytest.skip("measured logs are not at hand (shared/data beside the project)")
    recording = read_log(file, "pressure_psi", "tilt_rad", run="oct28_exp5", start=12)
    [finding] = recording.findings
    assert finding.code == "held-input"
    assert "pressure_interp_psi" in finding.message


def faulty(kind):
    columns = {"time_s": T.copy(), "pressure_bar": 3 + WAVE, "angle_deg": 20 * LAG}
    if kind == "gap":
        keep = np.delete(np.arange(500), np.arange(100, 130))
        return {name: values[keep] for name, values in columns.items()}
    if kind == "coarse-time":
        columns["time_s"] = np.floor(T)
    elif kind == "time-unit":
        columns = {
            "t": 1000 * T,
            "pressure_bar": columns["pressure_bar"],
            "angle_deg": columns["angle_deg"],
        }
    elif kind == "no-time":
        del columns["time_s"]
    elif kind == "non-finite":
        columns["angle_deg"][7] = np.nan
    elif kind == "outlier":
        columns["pressure_bar"][7] = 1e6
    elif kind == "clock-restart":
        columns["time_s"][300:] -= 6.0
        for name in (
            "pressure_bar",
            "angle_deg",
        ):  # signals that go on smoothly say that only the clock was set
            columns[name][300:] = columns[name][37:237]
    elif kind == "not-readable":
        columns["time_s"] = np.random.default_rng(0).permutation(T)
    return columns


@pytest.mark.parametrize(
    "kind",
    [
        "gap",
        "coarse-time",
        "time-unit",
        "no-time",
        "non-finite",
        "outlier",
        "clock-restart",
        "not-readable",
        "",
    ],
)
def test_inspecting_tells_what_reading_would_find(tmp_path, kind):
    file = write_csv(tmp_path / "log.csv", faulty(kind))
    summary = inspect_log(file)
    assert (summary.input, summary.output) == ("pressure_bar", "angle_deg")
    codes = [finding.code for finding in summary.findings]
    assert codes == ([kind] if kind else [])
    assert bool(summary.command) == (kind != "not-readable")  # which would end in that error
    if kind != "not-readable":
        assert summary.findings == read_log(file, "pressure", "angle").findings


def test_a_single_signal_in_milliseconds_is_warned_of_and_can_be_cured(tmp_path):
    file = write_csv(tmp_path / "log.csv", {"t": 1000 * T, "angle_deg": LAG})
    assert [finding.code for finding in inspect_log(file).findings] == ["time-unit"]
    summary = inspect_log(file, time_unit="ms")
    assert summary.findings == ()
    assert summary.sampling is not None
    assert summary.sampling.median == pytest.approx(0.02)


def test_the_named_unit_of_time_is_part_of_the_command(tmp_path):
    file = write_csv(tmp_path / "log.csv", faulty("time-unit"))
    assert inspect_log(file, time_unit="ms").command.endswith("--time-unit ms")


def wide_log(path, columns, name):
    rows = [
        ",".join(f"{np.sin(0.9 * k + 0.001 * j):.3f}" for j in range(columns)) for k in range(12)
    ]
    path.write_text(",".join(name(j) for j in range(columns)) + "\n" + "\n".join(rows) + "\n")
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [lambda j: f"p{j}_bar" if j % 2 else f"angle{j}_deg", lambda j: "x"], ids=["own", "one"]
)
def test_the_time_to_look_at_a_log_grows_with_its_columns_and_not_faster(name, tmp_path):
    spent = []
    for columns in (1500, 12000):
        path = wide_log(tmp_path / f"{columns}.csv", columns, name)
        begin = time.process_time()
        summary = inspect_log(path)
        spent.append(time.process_time() - begin)
        assert len(summary.columns) == columns
        assert all(len(found.message) < 1000 for found in summary.findings)
    assert spent[1] < 24 * spent[0]  # 8 if it is linear, 64 if it is quadratic


@pytest.mark.slow
def test_of_very_many_columns_the_likely_ones_are_printed_and_the_others_counted(tmp_path, capsys):
    run_inspect(
        InspectRequest(
            wide_log(tmp_path / "l.csv", 3000, lambda j: "p_bar" if j == 2500 else f"c{j}")
        )
    )
    out = capsys.readouterr().out
    assert len(out.splitlines()) < 90 and "p_bar" in out and "and 2940 more columns" in out


def test_of_a_single_loop_all_is_fitted_by_the_command_that_inspect_prints(tmp_path):
    """The warning said --train-fraction 1, and the line below it fitted a half that never turns."""
    t = np.linspace(0.0, 20.0, 400)
    x = 1.0 - np.cos(2 * np.pi * t / 20.0)
    file = write_csv(
        tmp_path / "log.csv", {"time_s": t, "pressure_bar": x, "angle_deg": 20 * np.sin(t / 7.0)}
    )
    summary = inspect_log(file)
    assert [finding.code for finding in summary.findings] == ["few-loops"]
    assert summary.command.endswith(" --train-fraction 1")
