"""dehyst sensor as a user meets it: the sheet, the corrected reading beside it, JSON, pictures, cures."""

import json
import re
import runpy
import shlex

import numpy as np
import pytest

import dehyst
from dehyst.data import sensor_data_sheet
from dehyst.io import write_csv
from dehyst.models import load
from dehyst.monitoring import corrected_readings
from places import ROOT

PLAY = dehyst.PrandtlIshlinskii([0.0, 2.0, 6.0], [0.004, 0.0002, 0.0001])
CELL = ("--reading", "bridge", "--quantity", "force")


def force(count, seed=0):
    """Cycles from 0 to 100 N with a rest at both ends, and random strokes behind."""
    one = [
        np.linspace(0.0, 100.0, 80),
        np.full(40, 100.0),
        np.linspace(100.0, 0.0, 80),
        np.full(40, 0.0),
    ]
    tips = np.append(np.random.default_rng(seed).uniform(0.0, 100.0, 8), 0.0)
    inner = [np.linspace(a, b, 40) for a, b in zip([0.0, *tips[:-1]], tips, strict=True)]
    return np.concatenate([*one * count, *inner])


def write_cell(path, count=6, seed=0):
    """A bridge with plays, a bend and noise."""
    x = force(count, seed)
    y = PLAY.simulate(x) + 2e-7 * x * (100.0 - x)
    y += 2e-5 * np.random.default_rng(seed).normal(size=x.size)
    write_csv(path, {"time_s": 0.25 * np.arange(x.size), "force_N": x, "bridge [mV/V]": y})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A log, another one of the same cell, a model either way, and a cell that stands still."""
    place = tmp_path_factory.mktemp("sensor")
    write_cell(place / "cell.csv")
    write_cell(place / "later.csv", 3, 5)
    record = dehyst.read_log(place / "cell.csv", "bridge", "force")
    dehyst.identify(record, "stop-sum").model.save(place / "forward.json")
    other = dehyst.read_log(place / "cell.csv", "force", "bridge")
    dehyst.identify(other, "play-sum").model.save(place / "inverse.json")
    dehyst.identify(record, "stop-sum", train_fraction=1.0).model.save(place / "whole.json")
    write_csv(
        place / "still.csv",
        {"time_s": np.arange(50.0), "force_N": np.arange(50.0), "y": np.ones(50)},
    )
    return place


@pytest.fixture(autouse=True)
def _inside(folder, monkeypatch):
    monkeypatch.chdir(folder)


def number(out, label, column=0):
    """A figure of a table: its value, and the columns behind it."""
    row = re.search(rf"^{re.escape(label)}  +(.*)$", out, re.MULTILINE)[1]
    return float(re.split(r"  +", row)[column].split()[0])


def test_it_prints_the_figures_of_a_data_sheet(run):
    status, out, _ = run("sensor", "cell.csv", *CELL)
    assert status == 0
    # A play of half width r reads max(x - r, r) rising and min(x + r, 100 - r) falling.
    x = np.linspace(0.0, 100.0, 1001)
    rising = falling = 0.0
    for r, weight in ((0.0, 0.004), (2.0, 0.0002), (6.0, 0.0001)):
        rising = rising + weight * np.maximum(x - r, r)
        falling = falling + weight * np.minimum(x + r, 100.0 - r)
    middle = 0.5 * (rising + falling) + 2e-7 * x * (100.0 - x)
    full_scale = middle[-1] - middle[0]
    bend = middle - middle[0] - full_scale * x / 100.0
    width = np.max(falling - rising)
    assert number(out, "hysteresis") == pytest.approx(100.0 * width / full_scale, rel=0.03)
    expected = 100.0 * np.max(bend) / full_scale
    assert number(out, "non-linearity, terminal") == pytest.approx(expected, rel=0.03)
    strip = min(np.ptp(middle - slope * x) for slope in np.linspace(0.0042, 0.0044, 401))
    assert number(out, "non-linearity, best") == pytest.approx(50.0 * strip / full_scale, rel=0.05)
    assert "in 10" in out and "at 100 N" in out and "(mV/V)/N" in out
    assert "6 rising and 6 falling strokes, 6 cycles" in out
    assert "next: dehyst identify cell.csv --input bridge --output force" in out


def test_json_has_what_python_has(run):
    status, out, _ = run("sensor", "cell.csv", *CELL, "--line", "best", "--json")
    sheet = sensor_data_sheet(dehyst.read_log("cell.csv", "bridge", "force"), "best")
    content = json.loads(out)
    assert status == 0 and content["line"]["name"] == "best"
    for name, figure in content["figures"].items():
        value = sheet.figures[name].value.value
        assert figure["value"]["value"] == (None if np.isnan(value) else value)


@pytest.mark.parametrize("model", ["forward.json", "inverse.json"])
def test_with_a_model_both_readings_stand_beside_each_other(run, model):
    """The model was fitted to the first half: only the second one counts, for both."""
    status, out, _ = run("sensor", "cell.csv", *CELL, "--model", model)
    assert status == 0 and "was not fitted to" in out
    assert number(out, "hysteresis", 2) < 0.2 * number(out, "hysteresis")
    assert number(out, "combined error", 2) < 0.3 * number(out, "combined error")
    what = model.partition(".")[0]
    assert f"next: dehyst export {model} --target c --what {what} --out sensor" in out
    status, out, _ = run("sensor", "later.csv", *CELL, "--model", model, "--json")
    content = json.loads(out)
    assert not content["held_out"]
    rms = [content["figures"]["rms"], content["corrected"]["figures"]["rms"]]
    assert rms[1]["value"]["value"] < 0.3 * rms[0]["value"]["value"]


def test_the_corrected_reading_is_that_of_the_model():
    record = dehyst.read_log("later.csv", "bridge", "force")
    model = load("forward.json")
    readings = corrected_readings(model, record)
    assert np.array_equal(readings.after[0].input, model.simulate(record.input, record.time))
    assert readings.after[0].input_unit == "N"
    inverse = corrected_readings(load("inverse.json"), record)
    assert np.max(np.abs(inverse.after[0].input - readings.after[0].input)) < 2.0


def test_columns_of_the_model_need_no_names(run):
    status, out, _ = run("sensor", "later.csv", "--model", "forward.json")
    assert status == 0 and "bridge [mV/V] over force [N]" in out


def test_a_model_of_all_samples_says_what_to_type(run):
    status, _, err = run("sensor", "cell.csv", *CELL, "--model", "whole.json")
    assert status == 2 and "--train-fraction 0.5" in err
    status, _, _ = run("sensor", "later.csv", *CELL, "--model", "whole.json")
    assert status == 0


def test_columns_must_be_named(run):
    status, _, err = run("sensor", "cell.csv", "--reading", "bridge")
    assert status == 2 and "--reading bridge --quantity COLUMN" in err and "force_N" in err
    status, _, err = run("sensor", "cell.csv", "--reading", "brigde", "--quantity", "force")
    assert status == 2 and "bridge" in err and "Traceback" not in err


@pytest.mark.parametrize(
    "typed, words",
    [
        (("still.csv", "--reading", "y", "--quantity", "force"), "input 'y'"),
        (("still.csv", "--reading", "force", "--quantity", "y"), "output 'y'"),
        (("cell.csv", *CELL, "--line", "ideal"), "terminal, best, zero"),
        (("cell.csv", *CELL, "--model", "nowhere.json"), "nowhere.json"),
        (("cell.csv", "--reading", "force", "--quantity", "force"), "force"),
    ],
)
def test_what_cannot_be_measured_says_why(run, typed, words):
    status, _, err = run("sensor", *typed)
    assert status == 2 and words in err and "Traceback" not in err


def test_units_that_are_no_units_of_the_model_are_refused(run):
    way = np.tile(np.linspace(0.0, 1.0, 100), 4)
    columns = {"time_s": np.arange(400.0), "bridge [mV/V]": way, "force_degC": way}
    write_csv("wrong.csv", columns)
    status, _, err = run("sensor", "wrong.csv", *CELL, "--model", "forward.json")
    assert status == 2 and "degC" in err and "Traceback" not in err


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sheet.svg", "sheet.png", "sheet.html"])
def test_the_picture_is_written_and_may_be_drawn_anew(run, tmp_path, name):
    out = tmp_path / name
    for model in ((), ("--model", "forward.json")):
        status, printed, _ = run("sensor", "cell.csv", *CELL, "--out", out, *model)
        assert status == 0 and "picture: " in printed and out.is_file()
    if name.endswith("html"):
        page = out.read_text(encoding="utf-8")
        for word in ("hysteresis", "non-linearity", "repeatability", "corrected bridge"):
            assert word in page


def test_a_file_of_somebody_else_is_kept(run, tmp_path):
    own = tmp_path / "mine.svg"
    own.write_text("<svg>mine</svg>")
    status, _, err = run("sensor", "cell.csv", *CELL, "--out", own)
    assert status == 2 and "--overwrite" in err and own.read_text() == "<svg>mine</svg>"


@pytest.mark.slow
def test_reading_and_quantity_may_stand_in_two_files(run):
    record = dehyst.read_log("cell.csv", "bridge", "force")
    write_csv("u.csv", {"time_s": record.time, "bridge": record.input})
    write_csv("y.csv", {"time_s": record.time, "force_N": record.output})
    status, out, _ = run("sensor", "u.csv:bridge", "y.csv:force")
    assert status == 0 and "6 cycles" in out


@pytest.mark.slow
def test_the_load_cell_of_the_examples_is_four_times_better_with_its_temperature(tmp_path):
    cell = runpy.run_path(str(ROOT / "examples" / "simulators" / "load_cell.py"))
    x = cell["calibration"]()
    warm = 25.0 - 12.0 * np.cos(np.linspace(0.0, 4.0 * np.pi, x.size))
    reading = cell["reading"](x, warm) + 1e-4 * np.random.default_rng(5).normal(size=x.size)
    time = cell["STEP"] * np.arange(x.size)
    log = dehyst.Recording(reading, 500.0 * x, time, schedules={"body": warm})
    model = dehyst.identify(log).model
    used = cell["use"](3)
    warm = 25.0 - 11.0 * np.cos(np.linspace(0.0, 5.0, used.size))
    reading = cell["reading"](used, warm)
    time = cell["STEP"] * np.arange(used.size)
    record = dehyst.Recording(reading, 500.0 * used, time, schedules={"body": warm})
    readings = corrected_readings(model, record)
    before = sensor_data_sheet(readings.before).figures["rms"].value.value
    after = sensor_data_sheet(readings.after, "ideal").figures["rms"].value.value
    assert after < 0.25 * before


@pytest.mark.slow
def test_each_line_that_is_printed_can_be_typed(run, tmp_path, monkeypatch):
    write_cell(tmp_path / "my cell.csv")
    monkeypatch.chdir(tmp_path)

    def following(printed):
        return shlex.split(re.search(r"next: dehyst (.*)", printed)[1])

    _, out, _ = run("sensor", "my cell.csv", *CELL)
    status, _, err = run(*following(out))
    assert status == 0, err
    _, out, _ = run("sensor", "my cell.csv", *CELL, "--model", "sensor.json")
    status, out, err = run(*following(out))
    assert status == 0 and "-> force [N]" in out, err
