"""Sweeps that run: the table does not depend on who computed it, nor on how often it was stopped."""

import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import sweep_evaluators
from dehyst.errors import DehystError, MissingExtraError, OutputError, ParameterError
from dehyst_robot.experiments import run_sweep
from dehyst_robot.experiments._sweep.points import expand_points, summarise
from dehyst_robot.experiments._sweep.spec import load_sweep
from effort import PATIENCE
from places import SUPPORT

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


def test_the_table_has_a_row_a_point_with_all_parameters_and_what_the_evaluator_gave(
    spec, tmp_path
):
    result = run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.quick, workers=0)
    table = rows(result.out)
    assert (result.runs, result.failed, result.resumed) == (RUNS, 0, 0)
    assert len(table) == len(expand_points(spec)) == 26
    assert [row["study"] for row in table] == ["size"] * 6 + ["poles"] * 16 + ["state"] * 4
    for row, point in zip(table, expand_points(spec), strict=True):
        scale, pole = (
            point.values.get("hysteresis.scale", 1.0),
            point.values.get("controller.pole_1_s", 6.0),
        )
        assert (row["hysteresis.scale"], row["controller.pole_1_s"]) == (repr(scale), repr(pole))
        assert (
            row["initial_state"] == point.values.get("initial_state", "homed")
            and row["error"] == ""
        )
        asked = {"experiment": "joint", "joint": 1, "seed": point.seed, "trials": ("slow", "fast")}
        figures = sweep_evaluators.quick(
            point.changes, **asked, compensators=("off", "paper"), run_settings=point.run_settings
        )
        shared = point.study != "poles" and (scale, point.run_settings["initial_state"]) == (
            1.0,
            "homed",
        )
        for name, figure in figures.items():
            assert shared or row[name] == repr(figure)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "s.toml"]


@pytest.mark.slow
def test_the_table_is_the_same_from_one_process_and_from_several(spec, tmp_path):
    tables = []
    for workers in (0, 3):
        out = tmp_path / f"{workers}.csv"
        run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=workers)
        tables.append(out.read_bytes())
    assert tables[0] == tables[1]


@pytest.mark.slow
def test_workers_have_one_thread_and_leave_ctrl_c_to_their_parent(spec, tmp_path):
    before = os.environ.get("OMP_NUM_THREADS")
    run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.tells_its_surroundings, workers=2)
    table = rows(tmp_path / "a.csv")
    assert {(row["threads"], row["deaf"], row["nan"]) for row in table} == {("1.0", "1.0", "")}
    assert str(float(os.getpid())) not in {row["pid"] for row in table}
    assert os.environ.get("OMP_NUM_THREADS") == before


SCRIPT = """
import sys
import sweep_evaluators
from dehyst_robot.experiments._sweep import load_sweep, run_sweep
if __name__ == "__main__":
    run_sweep(load_sweep(sys.argv[1]), sys.argv[2], evaluate=getattr(sweep_evaluators, sys.argv[3]), workers=2)
"""


def start(folder, out, evaluator="slow"):
    script = folder / "script.py"
    script.write_text(SCRIPT)
    path = os.pathsep.join([str(SUPPORT), *filter(None, sys.path)])
    return subprocess.Popen(
        [sys.executable, script, folder / "s.toml", out, evaluator],
        env={**os.environ, "PYTHONPATH": path},
        cwd=folder,
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


def finished_rows(table):
    return len(rows(table)) if table.exists() else 0


@pytest.mark.exhaustive
def test_after_a_kill_the_sweep_goes_on_and_the_table_is_that_of_an_uninterrupted_run(
    spec, tmp_path
):
    out, whole = tmp_path / "a.csv", tmp_path / "b.csv"
    process = start(tmp_path, out, "slow")
    wait_until(lambda: finished_rows(out) >= 2)
    process.kill()
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    wait_until(lambda: not members(process.pid))  # its workers end with it
    finished = len({row["key"] for row in rows(out)})
    assert 2 <= finished < RUNS
    result = run_sweep(spec, out, evaluate=sweep_evaluators.slow, workers=4)
    assert result.resumed == finished
    run_sweep(spec, whole, evaluate=sweep_evaluators.slow, workers=2)
    assert out.read_bytes() == whole.read_bytes()


@pytest.mark.slow
def test_ctrl_c_waits_for_no_run_and_ends_every_worker(tmp_path, spec):
    process = start(tmp_path, tmp_path / "a.csv", "touches_a_file_and_sleeps")
    wait_until(lambda: (tmp_path / "begun").exists())
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to all of them
    errors = process.communicate(timeout=PATIENCE)[1]
    assert errors.count("KeyboardInterrupt") == 1  # of the script; the workers say nothing
    wait_until(lambda: not members(process.pid))
    assert not (tmp_path / "a.csv").exists()


def stopped_after(spec, out, finished, **options):
    """Run a sweep that is stopped, as by Ctrl-C, after so many runs."""

    def stop(count, failed, total, resumed):
        if count == finished:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0, progress=stop, **options)


@pytest.mark.parametrize("finished", [1, 7, RUNS])
def test_a_stopped_sweep_keeps_what_was_finished_and_ends_in_the_same_table(
    spec, tmp_path, finished
):
    out = tmp_path / "a.csv"
    stopped_after(spec, out, finished)
    assert len({row["key"] for row in rows(out)}) == finished
    assert run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0).resumed == finished
    run_sweep(spec, tmp_path / "b.csv", evaluate=sweep_evaluators.quick, workers=0)
    assert out.read_bytes() == (tmp_path / "b.csv").read_bytes()


@pytest.fixture
def finished(spec, tmp_path):
    """A table with all runs, and what is in it."""
    out = tmp_path / "a.csv"
    run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0)
    return out, out.read_bytes()


@pytest.mark.parametrize("cell", ["</svg>", "[1.0]", "inf", "1e999", "nan nan"])
def test_a_damaged_figure_costs_one_run(spec, finished, cell):
    out, table = finished
    lines = table.decode().splitlines()
    poles = next(
        k for k, line in enumerate(lines) if line.startswith("poles")
    )  # a run of one study only
    lines[poles] = lines[poles].rpartition(",")[0] + "," + cell
    out.write_text("\n".join(lines) + "\n")
    assert run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0).resumed == RUNS - 1
    assert out.read_bytes() == table


def test_a_sweep_with_more_values_runs_only_those(finished, tmp_path):
    out, table = finished
    (tmp_path / "s.toml").write_text(
        "# more\n" + TEXT.replace("0.5,", "0.4, 0.5,").replace("draws = 8", "draws = 9")
    )
    result = run_sweep(
        load_sweep(tmp_path / "s.toml"), out, evaluate=sweep_evaluators.quick, workers=0
    )
    assert (result.resumed, result.runs) == (RUNS, RUNS + 4)
    figures = {row["key"]: row["fast/off/rms_deg"] for row in rows(out)}
    before = {
        row["key"]: row["fast/off/rms_deg"] for row in csv.DictReader(table.decode().splitlines())
    }
    assert before == {key: figures[key] for key in before}


def test_runs_of_another_sweep_stay_in_the_table_unless_it_is_overwritten(finished, tmp_path):
    out, table = finished
    (tmp_path / "s.toml").write_text(TEXT.replace("0.5,", "0.6,"))
    changed = load_sweep(tmp_path / "s.toml")
    with pytest.raises(OutputError, match=r"holds 2 runs that are not of this sweep.*--overwrite"):
        run_sweep(changed, out, evaluate=sweep_evaluators.quick, workers=0)
    (tmp_path / "s.toml").write_text(TEXT)
    with pytest.raises(OutputError, match="--overwrite"):  # another experiment is another sweep
        run_sweep(load_sweep(tmp_path / "s.toml"), out, evaluate=sweep_evaluators.slow, workers=0)
    assert out.read_bytes() == table
    result = run_sweep(changed, out, evaluate=sweep_evaluators.quick, workers=0, overwrite=True)
    assert result.resumed == 0 and rows(out)[0]["hysteresis.scale"] == "0.6"


def test_another_robot_or_version_is_another_run(spec, finished, monkeypatch):
    keys = {point.key for point in expand_points(spec)}
    monkeypatch.setattr("dehyst_robot.experiments._sweep.points.__version__", "0")
    assert keys.isdisjoint(point.key for point in expand_points(spec))


@pytest.mark.slow
def test_runs_that_fail_are_rows_and_can_be_tried_again(spec, tmp_path):
    out = tmp_path / "a.csv"
    for workers in (0, 2):
        result = run_sweep(
            spec, out, evaluate=sweep_evaluators.fails_at_scale_2, workers=workers, overwrite=True
        )
        table = rows(out)
        wrong = [row for row in table if row["error"]]
        assert result.failed == len(wrong) == 2 and len(table) == 26
        assert {row["error"] for row in wrong} == {"ZeroDivisionError: no such plant"}
        assert {(row["hysteresis.scale"], row["slow/off/rms_deg"]) for row in wrong} == {
            ("2.0", "")
        }
    summary = summarise(spec, result.points, result.columns)
    assert [(row.runs, row.failed) for row in summary[:3]] == [(2, 0), (2, 0), (2, 2)]
    again = run_sweep(spec, out, evaluate=sweep_evaluators.fails_at_scale_2, workers=0, retry=True)
    assert (again.resumed, again.failed) == (RUNS - 2, 2)


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    "workers", [1, 2]
)  # one: the next run always waits in the process that dies
def test_a_run_that_kills_its_process_is_one_row_and_costs_no_other(spec, tmp_path, workers):
    result = run_sweep(
        spec, tmp_path / "a.csv", evaluate=sweep_evaluators.dies_at_scale_2, workers=workers
    )
    wrong = [row for row in rows(result.out) if row["error"]]
    assert result.failed == 2 and {row["hysteresis.scale"] for row in wrong} == {"2.0"}
    assert "died" in wrong[0]["error"]


def test_a_summary_counts_the_runs_whose_compensator_was_declined(spec, tmp_path):
    result = run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.quick, workers=0)
    assert {row.declined for row in summarise(spec, result.points, result.columns)} == {0}
    declined = [float(point.number == 2) for point in result.points]
    marked = {**result.columns, "paper/declined": declined, "best/declined": [0.0] * len(declined)}
    counts = [row.declined for row in summarise(spec, result.points, marked)]
    assert counts == [0, 2, *[0] * (len(counts) - 2)]
    # A table that was read from its file has text and gaps.
    texts = ["" if not number else "1.0" for number in declined]
    of_text = {**result.columns, "paper/declined": texts}
    assert [row.declined for row in summarise(spec, result.points, of_text)] == counts


def test_medians_and_ranges_are_over_seeds_and_draws(spec, tmp_path):
    result = run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.quick, workers=0)
    summary = summarise(spec, result.points, result.columns)
    assert [row.study for row in summary] == ["size"] * 3 + ["poles"] + ["state"] * 2
    assert [row.runs for row in summary] == [2, 2, 2, 16, 2, 2]
    assert summary[3].values == {"controller.pole_1_s": "drawn"}
    for row in summary:
        assert set(row.figures) == {"slow, paper/off", "fast, paper/off"}
        assert all(figure == pytest.approx((0.3, 0.3, 0.3)) for figure in row.figures.values())


@pytest.mark.parametrize(
    "name", ["a.xls", "a.parquet", "a", "nowhere/a.csv", "folder.csv", "a\0.csv"]
)
def test_a_table_that_cannot_be_written_is_refused_before_anything_runs(spec, tmp_path, name):
    (tmp_path / "folder.csv").mkdir()

    def never(changes, **settings):
        raise AssertionError

    with pytest.raises(OutputError):
        run_sweep(spec, tmp_path / name, evaluate=never, workers=0)


def test_a_table_that_exists_is_kept_unless_told_otherwise(spec, tmp_path):
    out = tmp_path / "a.csv"
    out.write_text("mine\nalone\n")
    with pytest.raises(OutputError, match="--overwrite"):
        run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0)
    assert out.read_text() == "mine\nalone\n"
    run_sweep(spec, out, evaluate=sweep_evaluators.quick, workers=0, overwrite=True)
    assert len(rows(out)) == 26


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


def test_without_distributed_the_error_names_the_extra(spec, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtraError, match="pip install dehyst-robot"):
        run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.quick)


@pytest.mark.slow
def test_a_dask_cluster_gives_the_same_table(spec, tmp_path, monkeypatch):
    distributed = pytest.importorskip(
        "distributed", reason="the extra dehyst[dask] is not installed"
    )
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(SUPPORT), *filter(None, sys.path)]))
    run_sweep(spec, tmp_path / "a.csv", evaluate=sweep_evaluators.fails_at_scale_2, workers=0)
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, dashboard_address=None, processes=False
    ) as cluster:
        address = cluster.scheduler_address
        run_sweep(
            spec, tmp_path / "b.csv", evaluate=sweep_evaluators.fails_at_scale_2, dask=address
        )
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    monkeypatch.setattr("dehyst_robot.experiments._sweep.run.SECONDS_TO_CONNECT", 0.5)
    for nowhere in ("tcp://127.0.0.1:9", "no address at all", ""):
        with pytest.raises(DehystError, match="Dask"):
            run_sweep(spec, tmp_path / "c.csv", evaluate=sweep_evaluators.quick, dask=nowhere)
