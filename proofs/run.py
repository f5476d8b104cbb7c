"""Run the proofs of the core: `make proofs` installs what they need and comes here.

    python proofs/run.py                       all of them, about a quarter of an hour on two cores
    python proofs/run.py --quick               small numbers, about two minutes
    python proofs/run.py wp misra              some of them
    python proofs/run.py --json FILE           write the result; docs/explanation/proofs.md shows proofs/results.json
    python proofs/run.py --stale               say which of these results are of another core than that of today

Ends with status 1 if a proof fails, 2 if one could not be run because a tool is missing.
"""

from __future__ import annotations

import argparse
import datetime
import hashlib
import json
import platform
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import analyzer
import eva
import fuzzing
import misra
import patterns
import weakest
from outcome import Outcome, Proof
from solver import proofs as solver

PROOFS: tuple[Proof, ...] = (
    *eva.PROOFS, *weakest.PROOFS, *solver.PROOFS, *fuzzing.PROOFS, *patterns.PROOFS, *misra.PROOFS, *analyzer.PROOFS,
)  # fmt: skip
ROOT = Path(__file__).resolve().parents[1]
KERNEL = ROOT / "packages" / "dehyst"
RESULTS = ROOT / "proofs" / "results.json"
WORDS = {True: "ok", False: "FAILED", None: "not run"}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "names", nargs="*", help=f"beginnings of {', '.join(p.name for p in PROOFS)}"
    )
    parser.add_argument("--quick", action="store_true", help="small numbers")
    parser.add_argument("--json", type=Path, help="write the result there")
    parser.add_argument(
        "--stale", action="store_true", help="run nothing; say which results are of another core"
    )
    arguments = parser.parse_args()
    if arguments.stale:
        print(stale())
        return 0
    chosen = [p for p in PROOFS if not arguments.names or p.name.startswith(tuple(arguments.names))]
    if not chosen:
        parser.error(f"no proof begins with {', '.join(arguments.names)}")
    outcomes = [
        _run(proof, number, len(chosen), arguments.quick) for number, proof in enumerate(chosen, 1)
    ]
    if arguments.json:
        _write(arguments.json, outcomes, arguments.quick)
    _summary(outcomes)
    return (
        1
        if any(o.ok is False for o in outcomes)
        else 2
        if any(o.ok is None for o in outcomes)
        else 0
    )


def core_checksum() -> str:
    """What the core is: a digest of the names and texts of its C files."""
    digest = hashlib.sha256()
    for path in sorted((KERNEL / "core").glob("*.[ch]")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:12]


def stale(path: Path = RESULTS) -> str:
    """One line: whether the results are of the core of today, and which are not."""
    entries = json.loads(path.read_text(encoding="utf-8"))["proofs"]
    old = [entry for entry in entries if entry.get("core") != core_checksum()]
    if not old:
        return f"proofs: all {len(entries)} results are of this core"
    listed = ", ".join(f"{entry['name']} ({entry.get('date', 'no date')})" for entry in old)
    return f"proofs: {len(old)} of {len(entries)} results are of another core than this one: {listed}; run: make proofs"


def _run(proof: Proof, number: int, count: int, quick: bool) -> Outcome:
    print(f"[{number}/{count}] {proof.name}: {proof.claim}", flush=True)
    outcome = proof.outcome(quick)
    print(f"        {WORDS[outcome.ok]}, {outcome.seconds:.1f} s: {outcome.result}", flush=True)
    return outcome


def _write(path: Path, outcomes: list[Outcome], quick: bool) -> None:
    """Write the result; proofs that were not chosen keep theirs."""
    before = json.loads(path.read_text(encoding="utf-8"))["proofs"] if path.exists() else []
    entries = {entry["name"]: entry for entry in before}
    about = {"quick": quick, "machine": f"{platform.system()} {platform.machine()}", "core": core_checksum(),
             "date": datetime.datetime.now(datetime.UTC).date().isoformat()}  # fmt: skip
    entries |= {o.name: {**o.as_dict(), **about} for o in outcomes}
    known = [p.name for p in PROOFS if p.name in entries]
    text = json.dumps({"proofs": [entries[name] for name in known]}, indent=1)
    path.write_text(text + "\n", encoding="utf-8")


def _summary(outcomes: list[Outcome]) -> None:
    width = max(len(o.name) for o in outcomes)
    print(f"\n{'proof':{width}}  {'':7}  {'s':>6}  tool, extent")
    for o in outcomes:
        print(
            f"{o.name:{width}}  {WORDS[o.ok]:7}  {o.seconds:6.1f}  {', '.join(filter(None, (o.tool, o.extent)))}"
        )
    good = sum(o.ok is True for o in outcomes)
    print(f"{good} of {len(outcomes)} hold, {sum(o.seconds for o in outcomes):.0f} s")


if __name__ == "__main__":
    sys.exit(main())
