"""What benchmarks/stale.py measured holds what docs/explanation/adaptation.md says of it."""

import csv
from collections import defaultdict

from places import ROOT

DOCS = ROOT / "docs"
RESULT, PAGE = DOCS / "generate" / "stale.csv", DOCS / "explanation" / "adaptation.md"
EXPLAINED = {
    ("payload 1 kg", "1", "fast"): "the inertia of the payload",
    ("payload 2 kg", "1", "fast"): "the inertia of the payload",
    ("payload 1 kg", "4", "slow"): "the inertia of the payload",
    ("payload 2 kg", "4", "slow"): "the inertia of the payload",
    ("sensor lag 7 ms", "1", "fast"): "where the two are nearest",
}


def errors():
    """Change, joint, trial -> rms errors off, paper, best of every seed."""
    found = defaultdict(lambda: defaultdict(dict))
    with RESULT.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            case = found[row["change"], row["joint"], row["trial"]]
            case[row["seed"]][row["compensator"]] = float(row["rms_mdeg"])
    return {key: list(seeds.values()) for key, seeds in found.items()}


def test_the_page_counts_the_flags_of_the_file():
    raised = defaultdict(lambda: defaultdict(list))
    with RESULT.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if row["compensator"] != "off":
                for flag in ("stale", "shifted"):
                    raised[row["change"]][flag].append(bool(row[f"{flag}_s"]))
    page = PAGE.read_text(encoding="utf-8")
    table = page.partition("**What is told from what.**")[2].partition("\n\nSo ")[0]
    rows = [line.strip("| ").split(" | ") for line in table.splitlines() if line.startswith("| ")]
    assert len(rows) == 10
    for change, *counts in rows[1:]:
        flags = raised[change.partition(",")[0]]
        assert [int(count.partition(",")[0]) for count in counts] == [
            sum(flags["stale"]),
            sum(flags["shifted"]),
        ]
        assert len(flags["stale"]) == 40


def test_best_is_never_above_off_and_below_paper_but_where_the_page_says_why():
    found = errors()
    assert len(found) == 18 * 2 * 2 and len({len(seeds) for seeds in found.values()}) == 1
    assert all(one["best"] <= 1.05 * one["off"] for seeds in found.values() for one in seeds)
    above = []
    for key, seeds in found.items():
        above += [key for one in seeds if one["best"] >= one["paper"]]
    assert len(above) == 7
    assert set(above) == set(EXPLAINED)
    page = " ".join(PAGE.read_text(encoding="utf-8").split())
    assert all(why in page for why in ("in all but seven of 360 runs", *EXPLAINED.values()))
