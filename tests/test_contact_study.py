"""What benchmarks/contacts.py measured holds what docs/explanation/adaptation.md says of contact."""

import csv

from places import ROOT

RESULT = ROOT / "docs" / "generate" / "contacts.csv"


def rows(compensator):
    with RESULT.open(encoding="utf-8", newline="") as file:
        return [row for row in csv.DictReader(file) if row["compensator"] == compensator]


def test_after_a_contact_best_errs_as_before_within_5_s():
    touched = [row for row in rows("best") if row["contact"] != "none"]
    assert len(touched) == 3 * 8
    for row in touched:
        assert float(row["settled_mdeg"]) <= 1.5 * float(row["before_mdeg"]), row


def test_no_contact_is_learned_or_taken_for_missing_hysteresis():
    free = {row["plant"]: row for row in rows("best") if row["contact"] == "none"}
    for row in rows("best"):
        assert not row["stale_s"] and not row["shifted_s"], row
        assert float(row["lowest_scale"]) > float(free[row["plant"]]["lowest_scale"]) - 0.1, row
        assert float(row["highest_scale"]) < float(free[row["plant"]]["highest_scale"]) + 0.1, row


def test_what_comes_at_once_is_noticed_within_half_a_second_and_nothing_is_noticed_without():
    for row in rows("best"):
        if row["contact"] == "none":
            assert row["touched_s"] == ""
        elif ("a hand" in row["contact"] and "after" not in row["contact"]) or "load" in row[
            "contact"
        ]:
            assert float(row["touched_s"]) < 0.5, row
