"""Every hysteresis family on every measured log, the example and the loops of the simulated joint 1.

    python benchmarks/compare.py                # all runs of all logs; some minutes on two cores
    python benchmarks/compare.py --quick        # one run of each log
    python benchmarks/compare.py --json         # the same for programs; docs/build.py draws from results/compare.json

The measured logs lie beside the project (--data); without them only what dehyst makes itself is compared. Ends with
status 1 if a comparison takes more than 60 s of processor time, if the chosen family is worse than that of `identify`,
or, where all logs are there, if it is not better on at least two of them.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from result_files import save, tidy

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, TimeElapsedColumn

import dehyst
import dehyst_robot
from dehyst import Recording
from dehyst.identification import all_names
from dehyst.io import example_recording

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
RESULTS = Path(__file__).parent / "results" / "compare.json"
# No log here is a butterfly, and of other loops that family says so.
COMPARED = tuple(name for name in all_names() if name != "butterfly")
# Keys of a run in the file.
SHOWN = (
    "log",
    "kind",
    "source",
    "run",
    "samples",
    "processor_seconds",
    "orientation",
    "chosen",
)
LIMIT = 60.0  # of one comparison [s]
MECHANISMS = ("maxwell-slip", "preisach", "dahl")


@dataclass(frozen=True)
class Log:
    """A log: what it is, where it comes from, what is compared of it.

    Attributes
    ----------
    name
        Of its folder, or of what dehyst makes.
    kind
        What moves.
    source
        Who measured it.
    input, output
        Columns.
    runs
        Those that are compared, the first one with --quick.
    start
        Where the window begins. [s]
    """

    name: str
    kind: str
    source: str
    input: str
    output: str
    runs: tuple[str, ...] = ("",)
    start: float | None = None


LOGS = (
    Log("tendon_sheath_joint", "tendon-sheath joint", "nhoyh/hysteresis_compensation_ROS", "angle_cmd_deg", "angle_deg",
        ("config_000", "config_090", "config_180", "config_270", "conf0_50", "conf0_60", "conf0_70")),
    Log("piezo_dbo", "piezo actuator", "yan9a/DiscreteBacklashOperator", "voltage_v", "displacement_um",
        ("test", "model"), 2.0),
    Log("pneumatic_arm_segment", "soft pneumatic arm", "Jeevan-HM/Soft-Robotic-Arm", "pressure_interp_psi", "tilt_rad",
        ("oct28_exp1", "oct28_exp5", "oct28_exp9", "oct25_axial"), 12.0),
    Log("cavatappi_muscle", "fluidic muscle",
        "DiegotheSoftRoboticist/Material-based-Modeling-of-Cavatappi-Artificial-Muscles", "pressure_psi",
        "displacement_mm", ("200g_s3_t1", "200g_s2_t1", "300g_s3_t1", "400g_s3_t1")),
    Log("pam_wrist_joint", "pneumatic wrist joint", "Tsukasa-B/jetson_project", "pressure_mpa", "angle_deg"),
    Log("mr_damper", "magneto-rheological damper", "labcontrol-data/mr-damper", "displacement_mm", "force_N",
        ("ensaio1.2", "ensaio10.1", "ensaio.A.1", "ensaio.A.6")),
)  # fmt: skip
MADE = (
    Log("example", "example log", "dehyst example", "pressure_difference", "angle"),
    Log(
        "simulated_joint",
        "simulated joint 1",
        "dehyst_robot.identify_joint",
        "sheared_bar",
        "angle_rad",
        MECHANISMS,
    ),
)


def runs_of(data: Path, quick: bool = False) -> list[tuple[Log, str]]:
    """Logs and runs that can be asked here; what is not in the data folder is said."""
    there = [log for log in LOGS if (data / log.name).is_dir()]
    if len(there) < len(LOGS):
        print(
            f"{len(LOGS) - len(there)} of {len(LOGS)} measured logs are not in the data folder",
            file=sys.stderr,
        )
    return [(log, run) for log in (*there, *MADE) for run in (log.runs[:1] if quick else log.runs)]


def recording(log: Log, run: str, data: Path) -> Recording:
    """Read, or make, a run."""
    if log.name == "example":
        return example_recording()
    if log.name == "simulated_joint":
        return loops_of(run)
    path = data / log.name / "data.csv.gz"
    return dehyst.read_log(path, log.input, log.output, run=run or None, start=log.start)


def loops_of(mechanism: str) -> Recording:
    """The log from which the paper's compensator of joint 1 is identified: nested loops, seen and unseen ones."""
    robot = dehyst_robot.load_robot(conditions="kind", changes={"hysteresis.mechanism": mechanism})
    with tempfile.TemporaryDirectory() as folder:
        found = dehyst_robot.identify_joint(
            robot, 1, dehyst_robot.calibrate(robot, 1), Path(folder)
        )
    x, y, t = (found.log[name] for name in ("sheared_bar", "angle_rad", "time_s"))
    return Recording(input=x, output=y, time=t)


def compared(log: Log, run: str, data: Path) -> dict[str, Any]:
    """All families on one run, as plain numbers."""
    record = recording(log, run, data)
    begun, wall = time.process_time(), time.perf_counter()
    found = dehyst.compare(record, COMPARED).as_dict()
    spent, waited = time.process_time() - begun, time.perf_counter() - wall
    return {
        "log": log.name, "kind": log.kind, "source": log.source, "run": run, "samples": len(record),
        "processor_seconds": round(spent, 2), "wall_seconds": round(waited, 2), **tidy(found),
    }  # fmt: skip


def shown(row: dict[str, Any]) -> dict[str, Any]:
    """Return what pages show of a run: errors, ties and reasons, no sample and no parameter."""
    families = {}
    for name, entry in row["families"].items():
        test = entry["test"]
        families[name] = {
            "test": test and {"rmse_percent": test["rmse_percent"]},
            "tied": entry["tied"],
        }
        if test is None:
            families[name]["reason"] = entry["reason"]
    auto = {
        "family": row["auto"]["family"],
        "test": {"rmse_percent": row["auto"]["test"]["rmse_percent"]},
    }
    return {**{key: row[key] for key in SHOWN}, "auto": auto, "families": families}


def error(row: dict[str, Any], family: str) -> float:
    """Held-out error of a family on a run, percent of range; infinite where it could not be identified."""
    test = row["families"].get(family, {}).get("test")
    return (
        float("inf")
        if test is None or test["rmse_percent"] is None
        else float(test["rmse_percent"])
    )


def carried(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What the family chosen on one run of a log does on the others: rank, error, and that of `identify` there."""
    pairs = []
    for a in rows:
        for b in rows:
            if a is b or a["log"] != b["log"]:
                continue
            there = sorted(error(b, family) for family in b["families"])
            mine = error(b, a["chosen"])
            pairs.append({
                "log": a["log"], "from": a["run"], "to": b["run"], "family": a["chosen"],
                "rank": 1 + sum(other < mine for other in there),
                "tied": bool(b["families"][a["chosen"]]["tied"]),
                "percent": mine if mine < float("inf") else None,
                "best_percent": there[0], "auto_percent": b["auto"]["test"]["rmse_percent"],
            })  # fmt: skip
    return pairs


def line(row: dict[str, Any]) -> str:
    """A run in the printed table."""
    chosen, auto = row["chosen"], row["auto"]["family"]
    name = " ".join(filter(None, (row["log"], row["run"])))
    return (
        f"{name:36s}{row['samples']:7d}  {chosen:25s}{error(row, chosen):8.3f}  {auto:14s}"
        f"{row['auto']['test']['rmse_percent']:8.3f}{row['processor_seconds']:8.1f}"
    )


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the measured logs")
    parser.add_argument("--json", action="store_true", help="print the result for programs")
    parser.add_argument(
        "--out", type=Path, help=f"write that to a file too, such as {RESULTS.name}"
    )
    parser.add_argument("--quick", action="store_true", help="one run of each log")
    parser.add_argument(
        "--jobs", type=int, default=min(2, os.cpu_count() or 1), help="comparisons at the same time"
    )
    options = parser.parse_args()
    tasks = runs_of(options.data, options.quick)
    rows = measured(tasks, options.data, options.jobs)
    found = {"dehyst": dehyst.__version__, "quick": options.quick, "logs": rows}
    if options.out:
        save(options.out, {**found, "logs": [shown(row) for row in rows]})
    if options.json:
        print(json.dumps(found, indent=1))
    else:
        print(
            f"{'log':36s}{'samples':>7s}  {'chosen':25s}{'percent':>8s}  {'identify':14s}{'percent':>8s}{'cpu s':>8s}"
        )
        print("\n".join(line(row) for row in rows))
    return 0 if holds(rows, complete={log for log, _ in tasks}.issuperset(LOGS)) else 1


def measured(tasks: list[tuple[Log, str]], data: Path, jobs: int) -> list[dict[str, Any]]:
    """All comparisons, in the order of the tasks; progress on the error stream."""
    rows: dict[int, dict[str, Any]] = {}
    columns = (*Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeElapsedColumn())
    with (
        ProcessPoolExecutor(jobs) as pool,
        Progress(*columns, console=Console(stderr=True), transient=True) as bar,
    ):
        shown = bar.add_task("comparing", total=len(tasks))
        asked = {pool.submit(compared, log, run, data): k for k, (log, run) in enumerate(tasks)}
        for done in as_completed(asked):
            log, run = tasks[asked[done]]
            rows[asked[done]] = done.result()
            bar.update(shown, advance=1, description=f"{log.name} {run}")
    return [rows[k] for k in sorted(rows)]


def holds(rows: list[dict[str, Any]], *, complete: bool) -> bool:
    """Whether each comparison was quick enough and its choice never worse than that of `identify`, at times better."""
    auto = [(error(row, row["chosen"]), row["auto"]["test"]["rmse_percent"]) for row in rows]
    better = {row["log"] for row, (mine, other) in zip(rows, auto, strict=True) if mine < other}
    return (
        all(row["processor_seconds"] <= LIMIT for row in rows)
        and all(mine <= other for mine, other in auto)
        and (len(better) >= 2 or not complete)
    )


if __name__ == "__main__":
    sys.exit(main())
