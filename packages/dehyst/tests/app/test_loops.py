"""dehyst loops as a user meets it: tables, JSON, pictures, cures; what inspect and identify say of loops."""

import json
import re

import numpy as np
import pytest

import dehyst
from dehyst.data import measure_loops
from dehyst.io import write_csv


def motion(cycles, steps=200):
    """From rest through so many cycles between -10 and 10."""
    turn = np.linspace(0.0, 2 * np.pi * cycles, cycles * steps + 1)
    return 10.0 * np.sin(turn)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A friction that wears, the same without units, half a loop, and a log that never comes back."""
    place = tmp_path_factory.mktemp("loops")
    rng = np.random.default_rng(5)
    x = motion(30)
    time = 0.01 * np.arange(x.size)
    slider = dehyst.StopOperatorModel([0.0, 1.0], [0.0, 20.0], 0.0)
    force = slider.simulate(x) * (1.0 - 0.002 * time) + 0.1 * rng.normal(size=x.size)
    write_csv(place / "friction.csv", {"time_s": time, "way_mm": x, "force_N": force})
    write_csv(place / "plain.csv", {"u": x[:1000], "v": force[:1000]})
    way = np.linspace(-1.0, 1.0, 400)
    half = np.tanh((way - 0.15) / 0.2)
    write_csv(place / "half.csv", {"field [A/m]": way, "B [T]": half})
    return place


FRICTION = ("friction.csv", "--input", "way_mm", "--output", "force_N")
HALF = ("half.csv", "--input", "field", "--output", "B")


@pytest.fixture(autouse=True)
def _inside(folder, monkeypatch):
    monkeypatch.chdir(folder)


def test_it_prints_a_row_a_loop_and_what_wears(run):
    status, out, _ = run("loops", *FRICTION)
    assert status == 0
    assert "loop clockwise" in out and "loss" in out and "mJ" in out
    rows = re.findall(r"^(?:\d+) +[\d.]+ +-10 +10 .*$", out, re.MULTILINE)
    # 29 loops: the first and the last twelve are shown.
    assert len(rows) == 24 and "5 loops in the middle are not shown" in out
    assert "scatter of 29 loops" in out
    change = re.search(r"loss (-[\d.]+) % \((-[\d.]+) to (-[\d.]+)\)", out)
    # 0.2 % a second of the first value, 2 s a cycle.
    assert float(change[1]) == pytest.approx(-0.4 / 0.94, rel=0.03)


def test_json_has_what_python_has(run):
    status, out, _ = run("loops", *FRICTION, "--json")
    said = json.loads(out)
    measured = measure_loops(dehyst.read_log("friction.csv", "way_mm", "force_N"))
    assert status == 0 and said == json.loads(json.dumps(measured.as_dict()))
    assert said["units"]["work"] == "mJ" and len(said["loops"]) == said["count"] == 29


@pytest.mark.parametrize("name", ["loops.svg", "loops.png", "loops.html"])
def test_the_picture_is_written_and_may_be_drawn_anew(run, tmp_path, name):
    out = tmp_path / name
    for _ in range(2):
        status, said, _ = run("loops", *FRICTION, "--out", out)
        assert status == 0 and "picture: " in said and out.is_file()


def test_every_number_is_drawn(run, tmp_path):
    run("loops", *FRICTION, "--out", tmp_path / "loops.html")
    page = (tmp_path / "loops.html").read_text(encoding="utf-8")
    for word in ("width", "remanence", "coercivity", "at the upper turn", "at the lower turn"):
        assert word in page, word
    assert "From cycle to cycle" in page


def test_another_ending_is_refused_before_any_work(run, tmp_path):
    status, _, err = run("loops", *FRICTION, "--out", tmp_path / "loops.txt")
    assert status == 2 and ".svg" in err
    own = tmp_path / "mine.svg"
    own.write_text("<svg>mine</svg>")
    status, _, err = run("loops", *FRICTION, "--out", own)
    assert status == 2 and "--overwrite" in err and own.read_text() == "<svg>mine</svg>"


def test_a_log_without_a_loop_says_what_to_type_and_that_works(run):
    status, _, err = run("loops", *HALF)
    assert status == 2 and "no closed loop" in err and "--symmetric" in err
    status, out, _ = run("loops", *HALF, "--symmetric")
    assert status == 0 and "as --symmetric says" in out and "J/m3" in out
    # Who says that the other half is alike needs no warning that there is none, and goes on with the same line.
    assert "few-loops" not in out
    line = re.search(r"next: dehyst (.*)", out)[1]
    assert "--symmetric" in line


def test_without_units_there_are_none(run):
    _, out, _ = run("loops", "plain.csv", "--input", "u", "--output", "v")
    assert "area" in out and "loss" not in out and "[]" not in out


def test_several_logs_are_one_table(run):
    _, out, _ = run(
        "loops",
        *FRICTION[:1],
        "--json",
        *FRICTION[1:],
        "--from",
        "0",
        "--to",
        "20",
        "--from",
        "30",
        "--to",
        "50",
    )
    names = json.loads(out)["loops"]
    assert [loop["number"] for loop in names] == list(range(1, len(names) + 1))
    assert any(loop["start"] > 30 for loop in names) and any(loop["end"] < 20 for loop in names)


def test_inspect_and_identify_say_the_same(run):
    measured = measure_loops(dehyst.read_log("friction.csv", "way_mm", "force_N"))
    opening = f"opening {measured.estimates['opening_percent'].value:.2g} % of range"
    _, seen, _ = run("inspect", "friction.csv")
    assert opening in seen and measured.words in seen
    summary = json.loads(run("inspect", "friction.csv", "--json")[1])
    assert summary["numbers"]["estimates"]["area"]["unit"] == "mJ"
    _, said, _ = run("identify", *FRICTION, "--family", "stop", "--n", "10")
    assert opening in said and measured.words in said


def test_identify_prints_the_dead_band_of_a_model_that_has_one(run, tmp_path):
    rng = np.random.default_rng(0)
    x = 0.5 * motion(6) * np.linspace(1.0, 0.4, 1201)
    for threshold, has_band in ((0.4, True), (0.0, False)):
        travel = dehyst.PrandtlIshlinskii([threshold, 1.0], [1.5, 0.5]).simulate(x)
        log = {"pressure_bar": x, "travel_mm": travel + 0.01 * rng.normal(size=x.size)}
        write_csv(tmp_path / "valve.csv", {"time_s": 0.02 * np.arange(x.size), **log})
        words = ("--input", "pressure_bar", "--output", "travel_mm", "--family", "pi")
        _, out, _ = run("identify", tmp_path / "valve.csv", *words)
        band = re.search(r"dead band ([\d.]+) bar", out)
        assert bool(band) == has_band
        if band:
            assert float(band[1]) == pytest.approx(2 * threshold, rel=0.08)


def test_no_number_is_cut_in_a_narrow_terminal_where_directions_differ(run, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    t = np.arange(4000) / 100.0
    x = np.sin(2.0 * np.pi * t / 8.0)
    y = np.where(t < 16.0, np.sin(2.0 * np.pi * t / 8.0 - 0.2), np.sin(2.0 * np.pi * t / 8.0 + 0.2))
    log = tmp_path / "turned.csv"
    np.savetxt(
        log,
        np.column_stack([t, 1e-5 * x, 12345.0 * y]),
        "%.9g",
        ",",
        header="t_s,u_m,y_N",
        comments="",
    )
    status, out, err = run("loops", log, "--input", "u_m", "--output", "y_N")
    assert status == 0, err
    table = out[out.index("\nloop ") : out.index("largest loop")]
    assert "…" not in table and " ccw" in table and " cw" in table
