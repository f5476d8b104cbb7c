"""How well what `identify` takes by itself tracks on rigs of foreign physics, against every family of the house.

    python benchmarks/zoo_of_rigs.py                         # the rigs that rules are chosen on, usual length
    python benchmarks/zoo_of_rigs.py --rigs judge -j 2       # those that judge them
    python benchmarks/zoo_of_rigs.py --rigs piezo,valve --length short,usual,long,routine
    python benchmarks/zoo_of_rigs.py --auto-only             # only the default again; families from the files
    python benchmarks/zoo_of_rigs.py --table                 # nothing again: the table of the files
    python benchmarks/zoo_of_rigs.py --check                 # width of loops, slopes, sizes of the rigs

Each rig is logged with the motion of `dehyst design`, or its daily work (`routine`). Each family is identified from the
log, and its compensator plays three references on the rig: a scan, rests, and strokes at twice the speed of the log.
Errors are percent of the output's range, rms. Scores of families stay in results/zoo, a file for each rig, until the
rig changes.
"""

from __future__ import annotations

import argparse
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from dataclasses import dataclass, replace

from zoo.checks import checked
from zoo.logs import LENGTHS, ROUTINE
from zoo.rigs import DESIGN, JUDGE, RIGS
from zoo.scores import AUTO, FAMILIES, by_family, rows, scored, summary

CACHE = Path(__file__).parent / "results" / "zoo"
QUICK = ("static", "pi", "full-sum", "direct-inverse")
GROUPS = {"design": DESIGN, "judge": JUDGE, "all": tuple(RIGS)}


@dataclass(frozen=True)
class Task:
    """Logs of one rig to score, one after the other because they share a file."""

    name: str
    seed: int
    lengths: tuple[str, ...]
    families: tuple[str, ...]
    folder: Path
    auto: bool
    fresh: bool

    def run(self) -> list[dict[str, Any]]:
        """Return the scores of each log."""
        rig = replace(RIGS[self.name], seed=self.seed)
        of_lengths = []
        for length in self.lengths:
            of_lengths.append(
                scored(rig, length, self.families, self.folder, self.auto, self.fresh)
            )
        return of_lengths


def chosen(names: str) -> tuple[str, ...]:
    """Return the rigs of a group, or of names with commas."""
    if names in GROUPS:
        return GROUPS[names]
    listed = tuple(names.split(","))
    for name in listed:
        if name not in RIGS:
            sys.exit(f"no rig '{name}'. There are: {', '.join(RIGS)}; and {', '.join(GROUPS)}.")
    return listed


def printed(scores: dict[str, Any]) -> None:
    """Print the rows of one log."""
    lines = rows(scores)
    for row in lines:
        curve = row["over_curve"]
        print(
            f"{row['rig']:11s} {row['length']:7s} {row['reference']:5s}  "
            f"{row['taken']:20s} {row['error']:6.2f}   {row['best']:20s} {row['least']:6.2f}   "
            f"{row['over_best']:5.2f}  {curve if curve is not None else float('nan'):5.2f}  "
            f"{row['over_first']:5.2f} {row['first']:20s} {row['predicted'] or float('nan'):6.2f}",
            flush=True,
        )
    if not lines:
        print(f"{scores['rig']} {scores['length']}: {scores['entries'][AUTO].get('reason')}")


def concluded(figures: dict[str, Any]) -> None:
    """Print the figures over all logs."""
    words = {"over_best": "best family", "over_curve": "curve", "over_first": "first of compare"}
    for key, what in words.items():
        if key in figures:
            ratio = figures[key]
            print(
                f"default over {what}: geometric mean {ratio['mean']:.2f}, worst {ratio['worst']:.2f}, "
                f"within 10 % on {100 * ratio['within_10_percent']:.0f} % of {figures['rows']}"
            )
    for key, what in (
        ("predicted", "measured"),
        ("predicted_at_its_speed", "measured on scan and rests"),
    ):
        if key in figures:
            ratio = figures[key]
            print(
                f"predicted over {what}: geometric mean {ratio['mean']:.2f}, within 1.5 on "
                f"{100 * ratio['within_1_5']:.0f} % of {ratio['logs']} logs"
            )
    if figures["unable"]:
        print(f"no scores: {', '.join(figures['unable'])}")


def main() -> int:
    """Score, print, summarise."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rigs", default="design", help="design, judge, all, or names with commas")
    parser.add_argument(
        "--length", default="usual", help=f"{', '.join((*LENGTHS, ROUTINE))}, or all"
    )
    parser.add_argument("--families", help="only these, with commas")
    parser.add_argument("--seed", type=int, default=0, help="which specimen of each rig")
    parser.add_argument("--quick", action="store_true", help=f"only {', '.join(QUICK)}")
    parser.add_argument(
        "--auto-only", action="store_true", help="identify no family that is missing"
    )
    parser.add_argument("--table", action="store_true", help="identify nothing that the files hold")
    parser.add_argument("--fresh", action="store_true", help="identify all families again")
    parser.add_argument("--check", action="store_true", help="check the rigs, score nothing")
    parser.add_argument(
        "--by-family", action="store_true", help="what each family errs, always taken"
    )
    parser.add_argument("--cache", type=Path, default=CACHE, help="folder of the files")
    parser.add_argument("-j", "--jobs", type=int, default=1)
    options = parser.parse_args()
    names = chosen(options.rigs)
    if options.check:
        bad = [name for name in names if not checked(replace(RIGS[name], seed=options.seed))]
        return 1 if bad else 0
    lengths = tuple(options.length.split(","))
    if options.length == "all":
        lengths = (*LENGTHS, ROUTINE)
    families = FAMILIES
    if options.quick:
        families = QUICK
    if options.families:
        families = tuple(options.families.split(","))
    if options.auto_only:
        families = ()
    tasks = []
    for name in names:
        task = Task(
            name, options.seed, lengths, families, options.cache, not options.table, options.fresh
        )
        tasks.append(task)
    print(
        "rig         log     ref.   default               error   best family          error   "
        "/best /curve /first first                predicted"
    )
    results = []
    with ProcessPoolExecutor(options.jobs) if options.jobs > 1 else nullcontext() as pool:
        for of_rig in pool.map(Task.run, tasks) if pool else map(Task.run, tasks):
            for scores in of_rig:
                printed(scores)
            results += of_rig
    concluded(summary(results))
    stale = sorted({scores["rig"] for scores in results if scores["stale"]})
    if stale:
        print(
            f"families were identified by other sources, --fresh does it again: {', '.join(stale)}"
        )
    if options.by_family:
        for name, figures in by_family(results).items():
            print(
                f"always {name:25s} over the best family: geometric mean {figures['mean']:5.2f}, "
                f"worst {figures['worst']:6.2f}, on {figures['logs']} of {len(results)} logs"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
