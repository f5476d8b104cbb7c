"""Sweeps that run: the table does not depend on who computed it, nor on how often it was stopped."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import sweep_evaluators
from dehyst.errors import DehystError, MissingExtraError, OutputError, ParameterError
from dehyst.robot.experiments.sweep import expand, load_sweep, run_sweep
from dehyst.robot.experiments.sweep.points import summarise
from effort import PATIENCE

TEXT = """
name = "test"
seeds = [1, 2]
trials = ["slow", "fast"]
[[study]]
name = "size"
grid."hysteresis.scale" = [0.5, 1.0, 2.0]
[[study]]
name = "poles"
draws = 8
random."controller.pole_1_s" = {low = 4.0, high = 16.0}
[[study]]
name = "state"
grid.initial_state = ["homed", "unknown"]
"""
RUNS = 2 * (3 + 8 + 1)  # the homed one is also the one of scale 1


@pytest.fixture
def spec(tmp_path):
    file = tmp_path / "s.toml"
    file.write_text(TEXT)
    return load_sweep(file)


def rows(path):
    with Path(path).open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_the_table_has_a_row_a_point_with_all_parameters_and_what_the_evaluator_gave(spec, tmp_path):
    result = run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.quick, workers=0)
    table = rows(result.out)
    assert (result.runs, result.failed, result.resumed) == (RUNS, 0, 0)
    assert len(table) == len(expand(spec)) == 26
    assert [row["study"] for row in table] == ["size"] * 6 + ["poles"] * 16 + ["state"] * 4
    for row, point in zip(table, expand(spec), strict=True):
        scale, pole = point.values.get("hysteresis.scale", 1.0), point.values.get("controller.pole_1_s", 6.0)
        assert (row["hysteresis.scale"], row["controller.pole_1_s"]) == (repr(scale), repr(pole))
        assert row["initial_state"] == point.values.get("initial_state", "homed") and row["error"] == ""
        asked = {"experiment": "joint", "joint": 1, "seed": point.seed, "trials": ("slow", "fast")}
        figures = sweep_evaluators.quick(
            point.changes, **asked, compensators=("off", "paper"), run_settings=point.run_settings
        )
        shared = point.study != "poles" and (scale, point.run_settings["initial_state"]) == (1.0, "homed")
        for name, figure in figures.items():
            assert shared or row[name] == repr(figure)
    assert not result.journal.exists()


@pytest.mark.slow
def test_the_table_is_the_same_from_one_process_and_from_several(spec, tmp_path):
    tables = []
    for workers in (0, 3):
        out = tmp_path / f"{workers}.csv"
        run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=workers)
        tables.append(out.read_bytes())
    assert tables[0] == tables[1]


@pytest.mark.slow
def test_workers_have_one_thread_and_do_not_hear_ctrl_c(spec, tmp_path):
    before = os.environ.get("OMP_NUM_THREADS")
    run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.tells_its_surroundings, workers=2)
    table = rows(tmp_path / "a.csv")
    assert {(row["threads"], row["deaf"], row["nan"]) for row in table} == {("1.0", "1.0", "")}
    assert str(float(os.getpid())) not in {row["pid"] for row in table}
    assert os.environ.get("OMP_NUM_THREADS") == before


SCRIPT = """
import sys
import sweep_evaluators
from dehyst.robot.experiments.sweep import load_sweep, run_sweep
if __name__ == "__main__":
    run_sweep(load_sweep(sys.argv[1]), sys.argv[2], evaluate=getattr(sweep_evaluators, sys.argv[3]), workers=2)
"""


def start(folder, out, evaluator="slow"):
    script = folder / "script.py"
    script.write_text(SCRIPT)
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    return subprocess.Popen(
        [sys.executable, script, folder / "s.toml", out, evaluator],
        env={**os.environ, "PYTHONPATH": path},
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # A suite that was started in the background ignores Ctrl-C, and so would all that it starts.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


def wait_until(condition):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def members(group):
    """Processes of a process group that are still there and no zombies."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, pgrp = stat.read_text().rpartition(")")[2].split()[:3]
        except OSError:
            continue
        if int(pgrp) == group and state != "Z":
            found.append(stat.parent.name)
    return found


@pytest.mark.slow
def test_after_a_kill_the_sweep_goes_on_and_the_table_is_that_of_an_uninterrupted_run(spec, tmp_path):
    out, whole = tmp_path / "a.csv", tmp_path / "b.csv"
    journal = tmp_path / "a.csv.journal"
    process = start(tmp_path, out)
    wait_until(lambda: journal.exists() and journal.read_bytes().count(b"\n") >= 6)
    process.kill()
    process.communicate()
    assert process.returncode == -signal.SIGKILL and not out.exists()
    wait_until(lambda: not members(process.pid))  # its workers end with it
    done = journal.read_bytes().count(b"\n") - 1
    assert 5 <= done < RUNS
    result = run_sweep(spec, out, evaluate=sweep_evaluators.slow, workers=1)
    assert result.resumed == done and not journal.exists()
    run_sweep(spec, whole, evaluate=sweep_evaluators.quick, workers=0)  # slow gives the same figures, later
    assert out.read_bytes() == whole.read_bytes()


@pytest.mark.slow
def test_ctrl_c_stops_at_once_and_keeps_what_was_finished(tmp_path, spec):
    process = start(tmp_path, tmp_path / "a.csv", "very_slow")
    wait_until(lambda: (tmp_path / "a.csv.journal").exists() and len(members(process.pid)) >= 3)
    time.sleep(0.3)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to all of them
    errors = process.communicate(timeout=PATIENCE)[1]
    assert (tmp_path / "a.csv.journal").read_bytes().count(b"\n") == 1  # no run was waited for
    assert errors.count("KeyboardInterrupt") == 1  # of the script; the workers say nothing
    wait_until(lambda: not members(process.pid))
    assert (tmp_path / "a.csv.journal").exists()


@pytest.fixture
def interrupted(spec, tmp_path):
    """A journal with all runs but the table gone, as after a kill in the last moment."""
    out = tmp_path / "a.csv"

    def keep(done, failed, total, resumed):
        if done == total:
            (tmp_path / "copy").write_bytes((tmp_path / "a.csv.journal").read_bytes())

    run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0, progress=keep)
    table = out.read_bytes()
    out.unlink()
    (tmp_path / "copy").rename(tmp_path / "a.csv.journal")
    return out, tmp_path / "a.csv.journal", table


@pytest.mark.parametrize("cut", [1, 2, 17, 60])
def test_a_torn_last_line_costs_one_run(spec, interrupted, cut):
    out, journal, table = interrupted
    journal.write_bytes(journal.read_bytes()[:-cut])
    assert run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0).resumed == RUNS - 1
    assert out.read_bytes() == table


@pytest.mark.parametrize("damage", [b"\0\0\0", b"{]", b"[1]", b'{"key": 3}', b'{"key": "a", "figures": 3}', b"\xff"])
def test_a_damaged_line_costs_one_run_too(spec, interrupted, damage):
    out, journal, table = interrupted
    lines = journal.read_bytes().split(b"\n")
    lines[3] = damage
    journal.write_bytes(b"\n".join(lines))
    assert run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0).resumed == RUNS - 1
    assert out.read_bytes() == table


@pytest.mark.parametrize(
    "forged",
    [{"figures": {"ratio": lie}} for lie in ("</svg>", [1.0], {}, True, None, 10**400, float("inf"))]
    + [{"error": 3}, {"error": None}],
    ids=lambda forged: repr(forged)[:40],
)
def test_a_forged_line_costs_one_run_too(spec, interrupted, forged):
    out, journal, table = interrupted
    lines = journal.read_bytes().split(b"\n")
    lines[3] = json.dumps(json.loads(lines[3]) | forged).encode()
    journal.write_bytes(b"\n".join(lines))
    assert run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0).resumed == RUNS - 1
    assert out.read_bytes() == table


@pytest.mark.parametrize("size", [0, 1, 20, 60])
def test_a_journal_torn_in_its_first_line_begins_anew(spec, interrupted, size):
    out, journal, table = interrupted
    journal.write_bytes(journal.read_bytes()[:size])
    assert run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0).resumed == 0
    assert out.read_bytes() == table


def test_a_changed_sweep_does_not_go_on_in_an_old_journal_unless_told_to_begin_anew(interrupted, tmp_path):
    out, journal, _ = interrupted
    (tmp_path / "s.toml").write_text(TEXT.replace("0.5,", "0.6,"))
    changed, before = load_sweep(tmp_path / "s.toml"), journal.read_bytes()
    with pytest.raises(OutputError, match="--restart"):
        run_sweep(changed, out, evaluate=sweep_evaluators.quick, workers=0)
    assert journal.read_bytes() == before and not out.exists()
    with pytest.raises(OutputError, match="--restart"):  # another experiment is another sweep
        run_sweep(load_sweep(tmp_path / "s.toml"), out, evaluate=sweep_evaluators.slow, workers=0)
    result = run_sweep(changed, out, evaluate=sweep_evaluators.quick, workers=0, restart=True)
    assert result.resumed == 0 and rows(out)[0]["hysteresis.scale"] == "0.6"


def test_a_comment_in_the_file_changes_nothing(interrupted, tmp_path):
    out = interrupted[0]
    (tmp_path / "s.toml").write_text("# again\n" + TEXT)
    spec = load_sweep(tmp_path / "s.toml")
    assert run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0).resumed == RUNS


def test_what_is_no_journal_is_left_alone(spec, tmp_path):
    mine = tmp_path / "a.csv.journal"
    for content in ("my diary", "my diary\nof today\n", '{"format": "other"}\n'):
        mine.write_text(content)
        for restart in (False, True):
            with pytest.raises(OutputError, match="no journal"):
                run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.quick, workers=0, restart=restart)
        assert mine.read_text() == content


@pytest.mark.slow
def test_runs_that_fail_are_rows_and_can_be_tried_again(spec, tmp_path):
    out = tmp_path / "a.csv"
    for workers in (0, 2):
        result = run_sweep(
            spec, out, evaluate=sweep_evaluators.fails_at_scale_2, workers=workers, overwrite=True, restart=True
        )
        table = rows(out)
        wrong = [row for row in table if row["error"]]
        assert result.failed == len(wrong) == 2 and len(table) == 26 and result.journal.exists()
        assert {row["error"] for row in wrong} == {"ZeroDivisionError: no such plant"}
        assert {(row["hysteresis.scale"], row["slow/off/rms_deg"]) for row in wrong} == {("2.0", "")}
    summary = summarise(spec, result.points, result.columns)
    assert [(row.runs, row.failed) for row in summary[:3]] == [(2, 0), (2, 0), (2, 2)]
    again = run_sweep(spec, out, evaluate=sweep_evaluators.fails_at_scale_2, workers=0, retry=True)
    assert (again.resumed, again.failed) == (RUNS - 2, 2)


@pytest.mark.slow
def test_a_run_that_kills_its_process_is_one_row_and_costs_no_other(spec, tmp_path):
    result = run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.dies_at_scale_2, workers=2)
    wrong = [row for row in rows(result.out) if row["error"]]
    assert result.failed == 2 and {row["hysteresis.scale"] for row in wrong} == {"2.0"}
    assert "died" in wrong[0]["error"]


def test_medians_and_ranges_are_over_seeds_and_draws(spec, tmp_path):
    result = run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.quick, workers=0)
    summary = summarise(spec, result.points, result.columns)
    assert [row.study for row in summary] == ["size"] * 3 + ["poles"] + ["state"] * 2
    assert [row.runs for row in summary] == [2, 2, 2, 16, 2, 2]
    assert summary[3].values == {"controller.pole_1_s": "drawn"}
    for row in summary:
        assert set(row.figures) == {"slow, paper/off", "fast, paper/off"}
        assert all(figure == pytest.approx((0.3, 0.3, 0.3)) for figure in row.figures.values())


def test_parquet_holds_what_csv_holds(spec, tmp_path):
    polars = pytest.importorskip("polars", reason="the extra dehyst[parquet] is not installed")
    run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.fails_at_scale_2, workers=0)
    run_sweep(spec, tmp_path / "a.parquet", evaluate=sweep_evaluators.fails_at_scale_2, workers=0)
    frame = polars.read_parquet(tmp_path / "a.parquet")
    table = rows(tmp_path / "a.csv")
    assert frame.columns == list(table[0]) and frame.height == len(table) == 26
    told = [{name: "" if cell is None else str(cell) for name, cell in row.items()} for row in frame.to_dicts()]
    assert told == table
    assert frame.schema["seed"] == polars.Int64 and frame.schema["slow/off/rms_deg"] == polars.Float64


@pytest.mark.parametrize("name", ["a.xls", "a", "nowhere/a.csv", "folder.csv", "a\0.csv"])
def test_a_table_that_cannot_be_written_is_refused_before_anything_runs(spec, tmp_path, name):
    (tmp_path / "folder.csv").mkdir()

    def never(changes, **settings):
        raise AssertionError

    with pytest.raises(OutputError):
        run_sweep(spec, tmp_path / name, evaluate=never, workers=0)


def test_a_table_that_exists_is_kept_unless_told_otherwise(spec, tmp_path):
    out = tmp_path / "a.csv"
    out.write_text("mine")
    with pytest.raises(OutputError, match="--overwrite"):
        run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0)
    assert out.read_text() == "mine" and not (tmp_path / "a.csv.journal").exists()
    run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0, overwrite=True)
    assert len(rows(out)) == 26


def test_two_processes_do_not_write_one_journal(spec, tmp_path):
    pytest.importorskip("fcntl")
    from dehyst.robot.experiments.sweep.journal import Journal

    with Journal(tmp_path / "a.csv.journal", "x"), pytest.raises(OutputError, match="another process"):
        run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.quick, workers=0)


def test_progress_counts_up_to_the_number_of_different_runs(spec, tmp_path):
    told = []
    run_sweep(
        spec,
        tmp_path / "a.csv",
        evaluate=sweep_evaluators.fails_at_scale_2,
        workers=0,
        progress=lambda *each: told.append(each),
    )
    assert [done for done, *_ in told] == list(range(RUNS + 1))
    assert told[-1] == (RUNS, 2, RUNS, 0)


@pytest.mark.parametrize("workers", [-1, 100_000])
def test_an_impossible_number_of_workers_is_refused(spec, tmp_path, workers):
    with pytest.raises(ParameterError, match="workers"):
        run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.quick, workers=workers)


@pytest.mark.slow
def test_a_script_without_its_guard_is_told_so(tmp_path, spec):
    script = tmp_path / "bare.py"
    script.write_text(SCRIPT.replace('if __name__ == "__main__":', "if True:"))
    told = subprocess.run(
        [sys.executable, script, tmp_path / "s.toml", tmp_path / "a.csv", "quick"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert told.returncode == 1 and "below the line `if __name__ == '__main__':`" in told.stderr


def test_an_evaluator_that_cannot_be_sent_is_told_so(spec, tmp_path):
    with pytest.raises(ParameterError, match="module that the workers can import"):
        run_sweep(spec, tmp_path / "a.csv", evaluate=lambda changes, **settings: {}, workers=1)


def test_the_journal_is_plain_json_lines(interrupted):
    entries = [json.loads(line) for line in interrupted[1].read_text().splitlines()]
    assert entries[0]["format"] == "dehyst-sweep-journal" and len(entries) == RUNS + 1
    assert all(set(entry) == {"key", "figures", "error"} for entry in entries[1:])


def test_without_distributed_the_error_names_the_extra(spec, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtraError, match=r"dehyst\[dask\]"):
        run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.quick, dask="tcp://127.0.0.1:1")


@pytest.mark.slow
def test_a_dask_cluster_gives_the_same_table(spec, tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed", reason="the extra dehyst[dask] is not installed")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)]))
    run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.fails_at_scale_2, workers=0)
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, dashboard_address=None, processes=False
    ) as cluster:
        address = cluster.scheduler_address
        run_sweep(spec, tmp_path / "b.csv", evaluate=sweep_evaluators.fails_at_scale_2, dask=address)
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    monkeypatch.setattr("dehyst.robot.experiments.sweep.workers.DASK_SECONDS", 0.5)
    for nowhere in ("tcp://127.0.0.1:9", "no address at all", ""):
        with pytest.raises(DehystError, match="Dask"):
            run_sweep(spec, tmp_path / "c.csv", evaluate=sweep_evaluators.quick, dask=nowhere)
