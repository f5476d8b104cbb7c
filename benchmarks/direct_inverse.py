"""Direct inverse against the forward families on measured logs, in both directions, held out.

    python benchmarks/direct_inverse.py            # the table of docs/decisions/0025-...
    python benchmarks/direct_inverse.py --json

The logs stand beside the project (../shared/data) and may not be passed on. Train is the first half of each run, test
the second. The best forward family is taken for each column by itself, by its error on the test half.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import dehyst

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
TENDON = ("tendon_sheath_joint", "angle_cmd_deg", "angle_deg")
PIEZO = ("piezo_dbo", "voltage_v", "displacement_um")
ARM = ("pneumatic_arm_segment", "pressure_interp_psi", "tilt_rad")
CAVATAPPI = ("cavatappi_muscle", "pressure_psi", "displacement_mm")
WRIST = ("pam_wrist_joint", "pressure_mpa", "angle_deg")
DAMPER = ("mr_damper", "displacement_mm", "force_N")
RUNS: list[tuple[tuple[str, str, str], dict[str, Any]]] = [
    *((PIEZO, window) for window in ({"run": "model", "start": 2}, {"run": "test", "start": 2})),
    (PIEZO, {"run": "test", "start": 2, "stop": 30}),
    *(
        (ARM, {"run": run, "start": 12})
        for run in ("oct28_exp1", "oct28_exp5", "oct28_exp9", "oct25_axial")
    ),
    *(
        (CAVATAPPI, {"run": run})
        for run in ("200g_s2_t1", "200g_s3_t1", "300g_s3_t1", "400g_s3_t1")
    ),
    *((TENDON, {"run": f"config_{angle:03d}"}) for angle in range(0, 271, 30)),
    *(
        (TENDON, {"run": f"conf{run}"})
        for run in ("0_50", "0_60", "0_60_", "0_70", "90_50", "90_60", "90_70")
    ),
    (WRIST, {}),
    *((DAMPER, {"run": run}) for run in ("ensaio.A.1", "ensaio.A.6", "ensaio1.2", "ensaio10.1")),
]


def name_of(log: tuple[str, str, str], window: dict[str, Any]) -> str:
    """Folder, run and window."""
    until = f" to {window['stop']} s" if "stop" in window else ""
    return f"{log[0]} {window.get('run', 'its only run')}{until}"


def measure(log: tuple[str, str, str], window: dict[str, Any]) -> dict[str, Any]:
    """Errors of one run in percent of the ranges."""
    folder, x, y = log
    recording = dehyst.read_log(DATA / folder / "data.csv.gz", x, y, **window)
    begin = time.perf_counter()
    fit = dehyst.identify(recording, "direct-inverse", train_fraction=1.0 if log is WRIST else 0.5)
    seconds = time.perf_counter() - begin
    own, *others, _ = fit.table  # the last one is the curve
    output = min(others, key=lambda row: row.test_percent)
    return {
        "log": name_of(log, window),
        "held_out": fit.test is not None,
        "input": own.input_percent,
        "input_forward": others[0].input_percent,
        "input_family": others[0].family,
        "output": own.test_percent,
        "output_forward": output.test_percent,
        "output_family": output.family,
        "terms": [name for name in fit.settings["groups"] if name != "stops"]
        + ["by output"] * fit.settings["by_output"],
        "degree": fit.settings["degree"],
        "start": fit.settings["start"],
        "verdict": fit.verdict.rsplit(": ", 1)[1].rstrip("."),
        "seconds": seconds,
    }


def shown(percent: float) -> str:
    """A percentage, short."""
    return f"{percent:.2f}" if percent < 100.0 else "> 100"


def line(row: dict[str, Any]) -> str:
    """A row of the table; the smaller error of a pair in bold."""
    cells = [row["log"] + ("" if row["held_out"] else " (fitted)")]
    for own, other, family in (
        (row["input"], row["input_forward"], row["input_family"]),
        (row["output"], row["output_forward"], row["output_family"]),
    ):
        mine, theirs = shown(own), shown(other)
        cells += (
            [f"**{mine}**", f"{theirs} {family}"]
            if own < other
            else [mine, f"**{theirs}** {family}"]
        )
    cells.append(", ".join([f"degree {row['degree']}", *row["terms"]]))
    return f"| {' | '.join(cells)} |"


def main() -> int:
    """Measure, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--json", action="store_true", help="print every figure as JSON")
    wanted = parser.parse_args()
    if not (DATA / "piezo_dbo" / "data.csv.gz").is_file():
        sys.stderr.write(
            f"no measured logs in {DATA}; they may not be passed on with the project\n"
        )
        return 1
    rows = [measure(*run) for run in RUNS]
    if wanted.json:
        sys.stdout.write(json.dumps(rows, indent=1) + "\n")
        return 0
    print(
        "| log | input: direct | best forward inverse | output: direct, read forward | best forward family | terms |"
    )
    print("|---|---|---|---|---|---|")
    print("\n".join(line(row) for row in rows))
    scored = [row for row in rows if row["held_out"]]
    for key in ("input", "output"):
        better = sum(row[key] < row[f"{key}_forward"] for row in scored)
        print(
            f"\n{key}: smaller error than every forward family on {better} of {len(scored)} held-out halves"
        )
    print(f"\n{sum(row['seconds'] for row in rows) / len(rows):.2f} s a run, comparison included")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
