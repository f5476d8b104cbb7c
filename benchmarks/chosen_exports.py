"""Every model that `identify` takes on the runs of `compare.py`, exported and verified: does each target run it?

    python benchmarks/chosen_exports.py                    # 26 runs, both purposes, C, FMI 3.0 and Structured Text
    python benchmarks/chosen_exports.py --quick            # one run of each log
    python benchmarks/chosen_exports.py --targets c,fmu2   # others

For compensation the inverse is exported where the model has one, for simulation the model. Each folder is checked as
`dehyst verify` does it: compiled by every compiler here, at every level, and compared with the model's answers to the
bit. Ends with status 1 if an export is refused or a check fails.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from compare import DATA, Log, recording, runs_of

import dehyst
from dehyst.errors import DehystError
from dehyst.export import export, subject_of
from dehyst.export._verification import verify_folder

PURPOSES = ("compensate", "simulate")
TARGETS = ("c", "fmu3", "st")


def exported(log: Log, name: str, purpose: str, targets: tuple[str, ...]) -> dict[str, Any]:
    """Identify, export to each target, verify."""
    model = dehyst.identify(recording(log, name, DATA), purpose=purpose).model
    what = "inverse" if purpose == "compensate" and not model.no_inverse else "forward"
    row = {"log": log.name, "run": name, "purpose": purpose, "family": model.family, "what": what}
    try:
        subject = subject_of(model, what, name="chosen")
    except DehystError as refusal:
        return {**row, "targets": dict.fromkeys(targets, f"refused: {refusal}")}
    with tempfile.TemporaryDirectory() as place:
        return {
            **row,
            "targets": {one: verdict(subject, one, Path(place) / one) for one in targets},
        }


def verdict(subject: Any, target: str, folder: Path) -> str:
    """Return "equal", or what is wrong."""
    try:
        found = verify_folder(export(subject, target, folder).folder)
    except DehystError as refusal:
        return f"refused: {refusal}"
    bad = [f"{check.claim}: {check.detail}" for check in found.checks if check.status == "failed"]
    return "; ".join(bad) or found.why_not or "equal"


def main() -> int:
    """Ask every run, print a line each, save."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="one run of each log")
    parser.add_argument(
        "--targets", default=",".join(TARGETS), help="of dehyst export, separated by commas"
    )
    given = parser.parse_args()
    targets, rows = tuple(given.targets.split(",")), []
    for log, name in runs_of(DATA, given.quick):
        for purpose in PURPOSES:
            row = exported(log, name, purpose, targets)
            rows.append(row)
            shown = "  ".join(f"{target} {said}" for target, said in row["targets"].items())
            print(
                f"{log.name + '/' + name:36s}{purpose:11s} {row['family']:22s}{row['what']:8s} {shown}",
                flush=True,
            )
    verdicts = [said for row in rows for said in row["targets"].values()]
    equal = sum(said == "equal" for said in verdicts)
    print(f"{equal} of {len(verdicts)} exports answer with the model's bits")
    return 0 if equal == len(verdicts) else 1


if __name__ == "__main__":
    sys.exit(main())
