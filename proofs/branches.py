"""Branches of the core that the C programs of the tests take, counted by gcov.

    python proofs/branches.py            a line a file, and each branch that is never taken

The core is compiled without optimisation, so that every branch of the text is one. Ends with status 1 if a branch is
missed that is not in EXPLAINED.
"""

from __future__ import annotations

import gzip
import json
import sys
import tempfile
from collections import Counter
from pathlib import Path

from outcome import CORE, said, sources, tool

TESTS = CORE.parents[2] / "tests" / "support"
RUNS = (("core_bits", ()), ("core_claims", ()), ("block_random", ("6000", "1")))
EXPLAINED = {
    (
        "element_block.c",
        "for (int32_t round = 0; open && round < LINES + DEHYST_HALVINGS; ++round) {",
    ): "no sum tried needs all rounds",
    (
        "element_block.c",
        "const dehyst_real part = round < LINES ? miss_low / (miss_low - miss_high) : (dehyst_real)0.5;",
    ): "the last halvings keep the bound of time for any sum; no sum tried gets there",
    ("joint_image.c", "return numbers && (step >= value || value - step < value);"): (
        "what is no number is refused by reals_are_good before"
    ),
    (
        "element_inverse.c",
        "while (close < 2 && round < DEHYST_ROUNDS) {",
    ): "no sum tried needs all rounds",
    ("element_inverse.c", "const int halves = slow || round >= LAST || (beyond && known[up]);"): (
        "the last halvings keep the bound of time for any sum; no sum tried gets there"
    ),
}
"""(file, text of the line): why no input takes one of its branches."""


def counted(folder: Path) -> dict[tuple[str, int], list[int]]:
    """Return how often each branch of each line was taken, by all programs together."""
    gcc, gcov = tool("apt-get install gcc", "gcc"), tool("apt-get install gcc", "gcov")
    options = ["-std=c11", "-O0", "--coverage", "-ffp-contract=off", f"-I{CORE}"]
    for source in sources():
        said([gcc, *options, "-c", source, "-o", folder / f"{source.stem}.o"])
    for name, arguments in RUNS:
        program = [
            gcc,
            f"-I{CORE}",
            "--coverage",
            TESTS / f"{name}.c",
            *sorted(folder.glob("[!.]*.o")),
            "-lm",
        ]
        said([*program, "-o", folder / name], cwd=folder)
        said([folder / name, *arguments])
    taken: dict[tuple[str, int], list[int]] = {}
    for source in sources():
        said(
            [
                gcov,
                "--json-format",
                "--branch-counts",
                "--branch-probabilities",
                folder / f"{source.stem}.o",
            ],
            cwd=folder,
        )
        for found in json.loads(
            gzip.decompress((folder / f"{source.stem}.gcov.json.gz").read_bytes())
        )["files"]:
            if Path(found["file"]).name == source.name:
                for line in found["lines"]:
                    taken[source.name, line["line_number"]] = [b["count"] for b in line["branches"]]
    return taken


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        taken = counted(Path(folder))
    total, missed, unexplained = Counter(), Counter(), 0
    for (name, line), counts in sorted(taken.items()):
        total[name] += len(counts)
        missed[name] += sum(c == 0 for c in counts)
        if 0 in counts:
            text = (CORE / name).read_text(encoding="utf-8").splitlines()[line - 1].strip()
            why = EXPLAINED.get((name, text), "")
            unexplained += not why
            print(
                f"{name}:{line}: {counts.count(0)} of {len(counts)} never taken: {text}"
                + (f" ({why})" if why else "")
            )
    for name in sorted(total):
        print(f"{name:22} {total[name] - missed[name]:4} of {total[name]:4}")
    print(f"{'core':22} {total.total() - missed.total():4} of {total.total():4} branches, "
          f"{missed.total()} missed, on {unexplained} lines without an explanation")  # fmt: skip
    return 1 if unexplained else 0


if __name__ == "__main__":
    sys.exit(main())
