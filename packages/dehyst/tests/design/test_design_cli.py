"""dehyst design on the command line: table, CSV, picture, JSON, and messages that cure."""

import csv
import json
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from dehyst.app import DesignRequest
from dehyst.app._design import run_design
from dehyst.cli import app
from dehyst.errors import OutputError, ParameterError, UnitError
from dehyst.io import read_signal
from places import ROOT

RANGE = DesignRequest(range=(-30.0, 50.0), unit="degrees", rate=40.0, time_limit=450.0)
JSON_PAGE = ROOT / "docs" / "reference" / "json.md"


def run(tmp_path, capsys, **change):
    run_design(DesignRequest(**{**RANGE.__dict__, **change}))
    return capsys.readouterr()


def test_the_table_says_how_long_each_part_takes_and_why(tmp_path, capsys):
    out, _ = run(tmp_path, capsys)
    assert "-30 to 50 deg" in out and "begins and ends at 10 deg" in out
    assert "peak rate 40 deg/s" in out
    for word in (
        "home",
        "loops",
        "holds",
        "test",
        "creep to either side cancels",
        "smallest singular value",
    ):
        assert word in " ".join(out.split()), word
    assert "--out FILE.csv" in out


def test_the_samples_are_those_of_the_table_and_read_back_as_a_log(tmp_path, capsys):
    path = tmp_path / "excitation.csv"
    out, err = run(tmp_path, capsys, out=path, period=0.05)
    rows = list(csv.DictReader(path.open()))
    time = np.array([float(row["time_s"]) for row in rows])
    command = np.array([float(row["command [deg]"]) for row in rows])
    assert np.allclose(np.diff(time), 0.05) and command[0] == command[-1] == 10.0
    assert -30.0 <= command.min() < -29.9 and 49.9 < command.max() <= 50.0
    assert np.abs(np.diff(command)).max() / 0.05 <= 40.0
    order = [row["part"] for row in rows]
    assert [a for a, b in zip(order, [None, *order], strict=False) if a != b] == [
        "home", "loops", "holds", "loops", "holds", "test", "home"
    ]  # fmt: skip
    found = re.search(r"--from ([\d.]+) --to ([\d.]+) --train-fraction ([\d.]+)", out).groups()
    begin, last, fraction = (float(word) for word in found)
    end = begin + fraction * (last - begin)
    fitted = {part for t, part in zip(time, order, strict=True) if begin + 0.1 < t < end - 0.2}
    assert fitted == {"loops", "holds"}
    held = {part for t, part in zip(time, order, strict=True) if end + 0.2 < t < last - 0.1}
    assert held == {"test"}
    signal = read_signal(path, column="command [deg]")
    assert signal.unit == "deg" and signal.values.size == time.size
    assert "wrote" in err


def test_json_holds_the_whole_plan_and_every_key_is_documented(tmp_path, capsys):
    out, _ = run(tmp_path, capsys, json=True)
    facts = json.loads(out)
    assert facts["duration_s"] <= 450.0
    assert sum(each["duration_s"] for each in facts["sections"]) == pytest.approx(
        facts["duration_s"]
    )
    assert facts["separable"]["smallest"] > 5 * facts["one_loop"]["smallest"]
    documented = set(re.findall(r"`([\w-]+)`", JSON_PAGE.read_text(encoding="utf-8")))
    assert {*facts, *facts["separable"], *facts["sections"][0]} <= documented


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["svg", "png"])
def test_the_picture_is_drawn_the_same_twice_and_replaces_itself_only(tmp_path, capsys, ending):
    path = tmp_path / f"plan.{ending}"
    run(tmp_path, capsys, figure=path, overwrite=ending == "png")
    first = path.read_bytes()
    run(tmp_path, capsys, figure=path, overwrite=ending == "png")
    assert path.read_bytes() == first
    if ending == "svg":
        words = [
            e.text or ""
            for e in ElementTree.fromstring(first).iter("{http://www.w3.org/2000/svg}text")
        ]
        assert {"home", "loops", "holds", "test", "creep", "command [deg]"} <= set(words)
    other = tmp_path / f"mine.{ending}"
    other.write_text("mine")
    with pytest.raises(OutputError, match="would lose it"):
        run(tmp_path, capsys, figure=other)
    assert other.read_text() == "mine"


def test_a_csv_that_is_not_ones_own_is_not_overwritten(tmp_path, capsys):
    path = tmp_path / "log.csv"
    path.write_text("mine")
    with pytest.raises(OutputError, match="--overwrite"):
        run(tmp_path, capsys, out=path)
    run(tmp_path, capsys, out=path, overwrite=True)
    assert path.read_text().startswith("time_s,command [deg],part\n")


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"range": None}, ParameterError, "--range LO HI"),
        ({"purpose": "fun"}, ParameterError, "--for drift"),
        ({"purpose": "drift", "time_limit": 60.0}, ParameterError, "36 cycles at 40 deg/s take .* Allow"),
        ({"robot": Path("arm.toml")}, ParameterError, "Add --joint"),
        ({"time_limit": 60.0}, ParameterError, r"shortest plan takes \d+ s"),
        ({"rate": -1.0}, ParameterError, "positive number"),
        ({"range": (3.0, 3.0)}, ParameterError, "low < high"),
        ({"figure": Path("plan.pdf")}, OutputError, "neither SVG nor PNG"),
        ({"out": Path("nowhere/x.csv")}, OutputError, "no folder"),
        ({"out": Path("x.svg"), "figure": Path("x.svg")}, OutputError, "two files"),
        ({"joint": 1, "range": None, "time_limit": 100.0}, ParameterError, "deg/s and an acceleration"),
        ({"joint": 1, "unit": "bar"}, UnitError, "deg or rad"),
        ({"joint": 3, "range": None}, ParameterError, "joint 3 is electric"),
        ({"joint": 9, "range": None}, ParameterError, "has no joint 9"),
        ({"joint": 1, "range": (-90.0, 20.0)}, ParameterError, "within joint 1's"),
        ({"joint": 1, "rate": 400.0, "acceleration": 2e4, "range": None}, ParameterError, "At rest .* lower --accel"),
        ({"joint": 7, "rate": 40.0, "range": None, "robot": Path("valve.toml")}, ParameterError, "flow of its valves"),
        ({"joint": 2, "range": (-40.0, 40.0), "rate": 15.0, "robot": Path("low.toml"), "time_limit": 900.0},
         ParameterError, "smaller --range"),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_said_with_the_cure(
    change, error, words, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    Path("low.toml").write_text('extends = "default"\n[controller]\nmean_pressure_bar = 1.2\n')
    Path("valve.toml").write_text(
        'extends = "default"\n[valve.mpye_small]\nconductance_l_s_bar = 0.02\n'
    )
    with pytest.raises(error, match=words):
        run(tmp_path, capsys, **{"period": 0.001, **change})
    assert sorted(path.name for path in tmp_path.iterdir()) == ["low.toml", "valve.toml"]


def test_a_joint_is_designed_in_degrees_from_its_own_limits(tmp_path, capsys):
    path = tmp_path / "joint.csv"
    run_design(DesignRequest(joint=4, out=path, json=True, time_limit=500.0))
    facts = json.loads(capsys.readouterr().out)
    assert (facts["low"], facts["high"], facts["unit"]) == (
        pytest.approx(-28.0),
        pytest.approx(28.0),
        "deg",
    )
    assert facts["pressure_share"] < 0.85 and facts["flow_share"] < 0.85
    head = path.read_text().partition("\n")[0]
    assert head == "time_s,command [deg],nominal_pressure_difference_bar,part"


def test_the_command_is_wired_and_a_refusal_ends_with_status_2():
    result = CliRunner().invoke(app, ["design", "--range", "0", "5", "--unit", "bar", "--json"])
    assert result.exit_code == 0 and json.loads(result.stdout)["unit"] == "bar"
    refused = CliRunner().invoke(app, ["design"])
    assert isinstance(refused.exception, ParameterError)
