"""dehyst valve: exit status, JSON, files that it writes."""

import json

import pytest

from dehyst.io import write_csv
from simulated_loops import valve_loop


@pytest.fixture
def loop_csv(tmp_path):
    return write_csv(tmp_path / "loop.csv", valve_loop(samples=1200))


@pytest.mark.slow
def test_json_holds_the_verdict_and_its_numbers(run, loop_csv):
    status, out, _ = run("valve", str(loop_csv), "--json")
    figures = json.loads(out)
    assert status == 0
    assert figures["format"] == "dehyst-valve"
    assert figures["kind"] == "sticks"
    assert figures["dead_band_percent"]["low"] < 4.0 < figures["dead_band_percent"]["high"]


@pytest.mark.slow
def test_what_cannot_be_told_ends_with_status_4_and_writes_the_test(run, tmp_path):
    log = write_csv(tmp_path / "loop.csv", valve_loop(valve="linear", wave=("sine", 3.0, 40.0)))
    test = tmp_path / "test.csv"
    status, out, _ = run("valve", str(log), "--test", str(test))
    assert status == 4
    assert "not identifiable" in out
    assert test.read_text().startswith("time_s,OP_%\n")


@pytest.mark.slow
def test_the_picture_is_drawn_and_another_file_is_not_overwritten(run, loop_csv, tmp_path):
    picture = tmp_path / "valve.svg"
    status, _, _ = run("valve", str(loop_csv), "--figure", str(picture))
    assert status == 0
    assert "S =" in picture.read_text()
    status, _, err = run("valve", str(loop_csv), "--figure", str(loop_csv))
    assert status == 2
    assert loop_csv.read_text().startswith("time_s")
    assert err
