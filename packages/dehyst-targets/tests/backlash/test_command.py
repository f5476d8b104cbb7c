"""dehyst backlash: from a plan to a table and back, and every line that is typed wrongly."""

import json
import re

import numpy as np
import pytest

from backlash_machines import Axis, LinuxCNC, Plain, measure, write_sheet
from places import ROOT

POINTS = np.linspace(0.0, 300.0, 7)
TABLE = ("backlash", "table", "measure.csv", "--machine")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a filled sheet, another one without play, and one that was read from the wrong sides."""
    monkeypatch.chdir(tmp_path)
    rows = measure(Plain(Axis(0.04)), POINTS, 3, noise=1e-3)
    write_sheet(tmp_path / "measure.csv", rows)
    write_sheet(tmp_path / "free.csv", measure(Plain(Axis(0.0)), POINTS, 3, noise=1e-3))
    turned = [(repeat, point, not rising, value) for repeat, point, rising, value in rows]
    write_sheet(tmp_path / "turned.csv", turned)
    return tmp_path


def test_from_a_plan_to_a_table_that_the_machine_reads(folder, run):
    line = ("backlash", "plan", "--from", "0", "--to", "300", "--points", "7", "--repeats", "2")
    status, out, _ = run(*line, "--gcode", "plan.ngc", "--sheet", "sheet.csv")
    assert status == 0 and "28 readings" in out and "-2 to 302 mm" in out
    # The sheet is filled in as a user does, with what a simulated axis shows at each of its rows.
    lines = (folder / "sheet.csv").read_text().splitlines()
    filled = [lines[0]]
    for row, (_, _, _, value) in zip(lines[1:], measure(Plain(Axis(0.04)), POINTS, 2), strict=True):
        filled.append(f"{row}{value:.4f}")
    (folder / "sheet.csv").write_text("\n".join(filled))
    typed = re.search(r"dehyst (backlash table .*)", out)[1].split()
    status, out, err = run(*typed)
    assert status == 0 and err == "" and "warning" not in out
    joint = LinuxCNC(Axis(0.04), (folder / "linuxcnc" / "x.comp").read_text())
    left = [value - point for _, point, _, value in measure(joint, POINTS)]
    assert np.ptp(left) < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("sheet", ["measure.csv", "free.csv"])
def test_the_picture_shows_both_directions_and_what_is_left(folder, run, sheet):
    line = ("backlash", "table", sheet, "--machine", "linuxcnc", "--figure", "m.svg", "--json")
    for _ in range(2):  # its own picture may be drawn anew
        assert run(*line)[0] == (sheet == "free.csv")
    text = (folder / "m.svg").read_text(encoding="utf-8")
    assert "<svg" in text and "dehyst backlash: X axis, 7 points, for LinuxCNC" in text


@pytest.mark.parametrize("machine", ["linuxcnc", "grblhal", "marlin"])
def test_what_is_printed_is_what_is_written_and_checked(folder, run, machine):
    status, out, _ = run(*TABLE, machine, "--out", "made")
    assert status == 0 and "not compensated:" in out
    main = next(
        path
        for path in (folder / "made").iterdir()
        if path.suffix in (".comp", ".settings", ".gcode")
    )
    status, out, _ = run("backlash", "check", main, "measure.csv", "--machine", machine)
    assert status == 0 and "it lowers the error" in out
    # The same line again writes the same and is not refused.
    assert run(*TABLE, machine, "--out", "made")[0] == 0


def test_a_table_that_makes_it_worse_fails_the_check(folder, run):
    (folder / "bad.settings").write_text("$160=0.4\n")
    status, out, _ = run("backlash", "check", "bad.settings", "measure.csv", "--machine", "grblhal")
    assert status == 1 and "does not lower the error" in out


@pytest.mark.parametrize(
    ("sheet", "machine", "code"),
    [
        ("free.csv", "linuxcnc", "backlash-within"),
        ("free.csv", "grblhal", "backlash-within"),
        ("turned.csv", "marlin", "backlash-sign"),
        ("measure.csv", "klipper", "backlash-no-table"),
    ],
)
def test_where_no_table_is_right_none_is_written_and_the_status_says_so(
    folder, run, sheet, machine, code
):
    status, out, _ = run("backlash", "table", sheet, "--machine", machine, "--out", "made")
    assert status == 1 and code in out and not (folder / "made").exists()


def test_every_key_of_the_json_output_is_documented(folder, run):
    page = (ROOT / "docs" / "reference" / "json.md").read_text(encoding="utf-8")
    documented = set(re.findall(r"`([\w-]+)`", page))
    plan = json.loads(run("backlash", "plan", "--from", "0", "--to", "9", "--json")[1])
    facts = json.loads(run(*TABLE, "linuxcnc", "--json")[1])
    run(*TABLE, "linuxcnc", "--out", "made")
    line = ("backlash", "check", "made/x.comp", "measure.csv", "--machine", "linuxcnc", "--json")
    check = json.loads(run(*line)[1])
    keys = {*plan, *plan["readings"][0], *facts, *facts["left"], *check}
    assert keys - documented == set()
    assert facts["mean"] == pytest.approx(0.04, abs=1e-3) and check["helps"] is True


BAD = {
    "no action": ("backlash", "measure"),
    "plan without ends": ("backlash", "plan", "--from", "0"),
    "plan backward": ("backlash", "plan", "--from", "9", "--to", "0"),
    "plan with a file": ("backlash", "plan", "measure.csv", "--from", "0", "--to", "9"),
    "plan over the sheet": ("backlash", "plan", "--from", "0", "--to", "9", "--sheet", "measure.csv"),
    "one file for both": (
        "backlash", "plan", "--from", "0", "--to", "9", "--sheet", "a.csv", "--gcode", "a.csv",
    ),
    "no sheet": ("backlash", "table", "--machine", "linuxcnc"),
    "sheet that is not there": ("backlash", "table", "no.csv", "--machine", "linuxcnc"),
    "no machine": ("backlash", "table", "measure.csv"),
    "another machine": (*TABLE, "mach3"),
    "another axis": (*TABLE, "marlin", "--axis", "Q"),
    "bad unit": (*TABLE, "marlin", "--unit", "bar"),
    "bad smoothing": (*TABLE, "marlin", "--smoothing", "-1"),
    "picture of another kind": (*TABLE, "marlin", "--figure", "a.pdf"),
    "picture over the sheet": (*TABLE, "marlin", "--figure", "measure.csv"),
    "out is a file": (*TABLE, "marlin", "--out", "measure.csv"),
    "check without a table": ("backlash", "check", "measure.csv", "--machine", "linuxcnc"),
    "check of no table": ("backlash", "check", "no.comp", "measure.csv", "--machine", "linuxcnc"),
    "check of a sheet": ("backlash", "check", "measure.csv", "measure.csv", "--machine", "linuxcnc"),
    "check for klipper": ("backlash", "check", "measure.csv", "measure.csv", "--machine", "klipper"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_done_is_refused_in_a_sentence(folder, run, name):
    before = (folder / "measure.csv").read_bytes()
    status, out, err = run(*BAD[name])
    assert status == 2 and out == ""
    assert len(err.strip()) > 40 and "Error: " in err
    assert (folder / "measure.csv").read_bytes() == before


def test_a_table_of_somebody_else_is_not_overwritten(folder, run):
    (folder / "made").mkdir()
    (folder / "made" / "x.comp").write_text("0 0 0\n")
    status, _, err = run(*TABLE, "linuxcnc", "--out", "made")
    assert status == 2 and "--overwrite" in err
    assert (folder / "made" / "x.comp").read_text() == "0 0 0\n"
    assert run(*TABLE, "linuxcnc", "--out", "made", "--overwrite")[0] == 0
