"""`dehyst muscle` as a user meets it: list, bench, units of a log, JSON, page and picture, messages that cure."""

import json
import re

import numpy as np
import pytest

from dehyst_robot.commands._muscle import kind_of
from dehyst_robot.muscles import muscle, muscle_names
from in_one import in_one
from places import ROOT

DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def truth():
    return muscle("sarosi", "DMSP-20-map")


@pytest.fixture(scope="module")
def bench(tmp_path_factory, truth):
    """Folder with one bench log in several dresses."""
    place = tmp_path_factory.mktemp("bench")
    k, p = (
        each.ravel() for each in np.meshgrid(np.linspace(0.0, 0.2, 12), np.linspace(0.5e5, 6e5, 12))
    )
    force = np.maximum(truth.static_force(k, p), 0.0)
    dresses = {
        "plain": ("contraction,pressure_bar,force_N", k, p / 1e5, force),
        "percent": ("contraction_percent,pressure_kPa,force_kN", 100 * k, p / 1e3, force / 1e3),
        "length": ("length_mm,pressure_psi,force_N", 296 * (1 - k), p / 6894.757293168361, force),
        "shortening": ("shortening_mm,pressure_MPa,force_N", 296 * k, p / 1e6, force),
        "nameless": ("contraction,pressure,force", 100 * k, p / 1e3, -force),
        "absolute": (
            "contraction,pressure_bar,force_N",
            k,
            (p - 0.5e5) / 1e5 + 1.01325,
            np.maximum(truth.static_force(k, p - 0.5e5), 0),
        ),
        "mass": ("contraction,pressure_bar,force_kg", k, p / 1e5, force / 9.80665),
        "wrong": ("contraction,pressure_bar,force_N", k, p / 1e3, force),
    }
    for name, (head, *columns) in dresses.items():
        np.savetxt(
            place / f"{name}.csv",
            np.stack(columns, axis=1),
            delimiter=",",
            header=head,
            comments="",
            fmt="%.9g",
        )
    return place


def figures(run, *words):
    status, out, err = run("muscle", *words, "--json")
    assert (status, err) == (0, ""), err
    return json.loads(out)


def test_the_list_names_every_model_and_every_set(run):
    status, out, _ = run("muscle", "--list")
    assert status == 0
    assert all(re.search(rf"(?m)^{name} ", out) for name in muscle_names())
    found = {entry["name"]: entry for entry in json.loads(run("muscle", "--list", "--json")[1])}
    assert set(found) == set(muscle_names())
    assert found["vo-minh"]["hysteresis"] and not found["sarosi"]["hysteresis"]
    assert found["klute"]["speed"] and not found["maker"]["speed"]
    assert found["tondu-lopez"]["year"] == 2000
    assert all(
        entry["sets"] and all(each["source"] for each in entry["parameters"])
        for entry in found.values()
    )


def test_what_a_model_shows_is_found_by_trying(run):
    assert kind_of("tondu-zagal") == ("dynamic", "none")
    assert kind_of("chou-hannaford") == ("static", "loops")


@pytest.mark.parametrize("name", muscle_names())
def test_every_model_prints_its_bench(run, name):
    status, out, err = run("muscle", name, "--pressures", "3,5", "--loads", "150")
    assert (status, err) == (0, "")
    force = float(muscle(name).static_force(0.0, 3e5))
    assert re.search(rf"(?m)^0 % +{force:.0f} ", out)
    assert "free contraction [%]" in out and "next: fit it to your muscle" in " ".join(out.split())


def test_parameters_sets_and_length_are_those_that_were_typed(run):
    found = figures(
        run,
        "maker",
        "--set",
        "DMSP-20",
        "--length",
        "300mm",
        "--param",
        "bell=1.5",
        "--pressures",
        "6",
    )
    expected = muscle("maker", "DMSP-20", length=0.3, bell=1.5)
    assert found["force_map"]["force_N"][0][0] == pytest.approx(
        float(expected.static_force(0.0, 6e5))
    )
    found = figures(
        run, "aschemann-schindele", "--param", "a=0.01,-0.02,0.01,0", "--pressures", "6"
    )
    assert found["parameters"]["a"] == [0.01, -0.02, 0.01, 0.0]
    found = figures(
        run, "aschemann-schindele", "--param", "b=0", "--pressures", "6"
    )  # one value is a list of one
    assert found["parameters"]["b"] == [0.0]


@pytest.mark.parametrize(
    ("log", "options"),
    [
        ("plain", ()),
        ("percent", ("--contraction", "contraction_percent")),
        ("length", ("--length-column", "length", "--length", "0.296")),
        ("shortening", ("--contraction", "shortening", "--length", "296mm")),
        ("nameless", ()),
        ("absolute", ("--absolute",)),
        ("wrong", ("--pressure-unit", "kPa")),
        ("mass", ("--force", "force_kg")),
    ],
)
def test_one_log_in_any_units_gives_one_fit(run, bench, truth, log, options):
    found = figures(run, "sarosi", "--log", bench / f"{log}.csv", *options)
    fit = found["fit"]
    assert fit["rmse_percent"] < 0.001
    for name in ("a3", "a4", "a5", "a6"):
        assert fit["parameters"][name] == pytest.approx(getattr(truth, name), rel=1e-3)
    codes = {warning["code"] for warning in fit["warnings"]}
    assert ("muscle-unit-guessed" in codes) == (log == "nameless")
    assert ("muscle-mass" in codes) == (log == "mass")
    assert ("muscle-force-sign" in codes) == (log == "nameless")


def test_a_force_in_a_unit_that_cannot_be_is_refused_and_percent_that_look_like_a_number_are_doubted(
    run, tmp_path
):
    contraction, pressure = np.meshgrid(np.linspace(0.0, 0.2, 6), [2.0, 3.0, 4.0, 5.0])
    force = muscle("sarosi").static_force(contraction, 1e5 * pressure)
    log = tmp_path / "log.csv"
    columns = np.stack([contraction, pressure, force], axis=-1).reshape(-1, 3)
    np.savetxt(
        log, columns, delimiter=",", header="contraction_pct,pressure_bar,force_kN", comments=""
    )
    status, _, err = run("muscle", "maker", "--log", log, "--contraction", "contraction_pct")
    assert (
        status != 0 and re.search(r"the strongest\s+muscles pull", err) and "--force-unit N" in err
    )
    options = ("--log", log, "--contraction", "contraction_pct", "--force-unit", "N")
    doubts = [
        w["message"]
        for w in figures(run, "maker", *options)["fit"]["warnings"]
        if "percent" in w["message"]
    ]
    assert any("--contraction-unit 1" in message for message in doubts)
    cured = figures(run, "maker", *options, "--contraction-unit", "1")["fit"]
    assert "muscle-unit-guessed" not in {warning["code"] for warning in cured["warnings"]}


def test_a_force_without_a_unit_is_said_to_be_taken_as_newtons(run, bench):
    warnings = figures(run, "sarosi", "--log", bench / "nameless.csv")["fit"]["warnings"]
    guessed = [w["message"] for w in warnings if w["code"] == "muscle-unit-guessed"]
    assert (
        len(guessed) == 3 and "'force'" in guessed[2] and "--force-unit lbf" in guessed[2]
    )  # kN would be refused


def test_a_pressure_that_looks_absolute_is_said_to(run, bench):
    warnings = figures(run, "sarosi", "--log", bench / "absolute.csv")["fit"]["warnings"]
    assert any(w["code"] == "muscle-absolute" and "--absolute" in w["message"] for w in warnings)


@in_one("words, message",
    [
        (("muscle",), r"nothing says which model.*chou-hannaford"),
        (("muscle", "tondulopez"), r"Did you mean tondu-lopez\?"),
        (("muscle", "maker", "--set", "DMSP"), r"there are: DMSP-40"),
        (("muscle", "maker", "--param", "bel=1"), r"no parameter 'bel'"),
        (("muscle", "maker", "--param", "bell"), r"not NAME=VALUE"),
        (("muscle", "maker", "--param", "bell=nan"), r"not NAME=VALUE"),
        (("muscle", "maker", "--pressures", "-1"), r"-1 bar is outside 0 to 20 bar"),
        (("muscle", "maker", "--pressures", "600"), r"600 bar is outside"),
        (("muscle", "maker", "--pressures", "1;2"), r"not a list of numbers"),
        (("muscle", "maker", "--contractions", "80"), r"80 % is outside -5 to 50 %"),
        (("muscle", "maker", "--length", "300"), r"Write 300mm"),
        (("muscle", "maker", "--length", "long"), r"no length"),
        (("muscle", "maker", "--param", "length=300"), r"Write 300mm"),
        (("muscle", "maker", "--length", "-1mm"), r"not positive"),
        (("muscle", "maker", "--log", "plain.csv", "--seed", "-1"), r"from 0 on"),
        (("muscle", "maker", "--save", "m.json"), r"Add --log"),
        (("muscle", "none.json"), r"does not exist"),
        (("muscle", "maker", "--figure", "m.jpeg"), r"neither SVG nor PNG"),
        (("muscle", "maker", "--log", "plain.csv", "--contraction", "contractoin"), r"Did you mean 'contraction'\?"),
        (("muscle", "maker", "--log", "plain.csv", "--force", "pressure"), r"pressure and force are both column"),
        (("muscle", "maker", "--log", "plain.csv", "--contraction", "force"), r"contraction and force are both"),
        (("muscle", "maker", "--log", "plain.csv", "--length-column", "contraction"), r"--length 300mm"),
        (("muscle", "maker", "--log", "plain.csv", "--contraction", "a", "--length-column", "b"), r"Leave one of them"),
        (("muscle", "maker", "--log", "wrong.csv"), r"600 bar, but muscles are driven with .*--pressure-unit kPa"),
        (("muscle", "maker", "--log", "plain.csv", "--pressure-unit", "kPa"), r"--pressure-unit bar"),
        (("muscle", "maker", "--log", "plain.csv", "--pressure-unit", "N"), r"a unit of force, but pressure needs"),
        (("muscle", "maker", "--log", "plain.csv", "--absolute"), r"leave --absolute out"),
        (("muscle", "maker", "--log", "length.csv", "--contraction", "length"), r"a shortening"),
        (("muscle", "maker", "--log", "length.csv", "--contraction", "length", "--length", "296mm"), r"but muscles"),
        (("muscle", "maker", "--log", "length.csv", "--length-column", "length", "--length", "1"), r"another one"),
        (("muscle", "maker", "--log", "plain.csv", "--report", "plain.csv"), r"the log itself"),
        (("muscle", "maker", "--report", "a.html", "--figure", "a.html"), r"a file for each"),
        (("muscle", "maker", "--report", "nowhere/a.html"), r"no folder"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_refused_with_its_cure(run, bench, monkeypatch, words, message):
    monkeypatch.chdir(bench)
    status, out, err = run(*words)
    assert (status, out) == (2, "")
    assert re.search(message, " ".join(err.split()))
    assert "Traceback" not in err


@pytest.mark.slow
def test_a_fit_is_saved_reported_drawn_and_put_on_the_bench_again(run, bench, tmp_path, truth):
    saved, page, picture = (tmp_path / name for name in ("m.json", "m.html", "m.svg"))
    words = (
        "muscle",
        "sarosi",
        "--log",
        bench / "plain.csv",
        "--save",
        saved,
        "--report",
        page,
        "--figure",
        picture,
    )
    status, out, err = run(*words)
    assert (status, err) == (0, "")
    flat = " ".join(out.split())
    assert "on samples left out" in flat and "6 parameters" in flat and "points at rest" in flat
    again = figures(run, saved, "--pressures", "4")
    assert again["force_map"]["blocked_N"][0] == pytest.approx(
        float(truth.static_force(0.0, 4e5)), rel=1e-4
    )
    text = page.read_text(encoding="utf-8")
    assert text.count("<script") == 1 and text.count('class="plot"') >= 8
    assert all(
        word in text
        for word in ("Measured and fitted", "Static forces", "Isotonic loops", "standard error")
    )
    assert "dehyst muscle: sarosi" in picture.read_text(encoding="utf-8")[:600]
    assert run(*words)[0] == 0  # its own files may be written anew
    picture.write_text("mine" * 20)
    assert run(*words)[0] == 2 and picture.read_text() == "mine" * 20


@pytest.mark.slow
def test_a_log_with_time_is_a_motion_unless_it_is_said_to_be_points(run, tmp_path):
    truth = muscle("chou-hannaford", "DMSP-40")
    time = np.arange(0.0, 40.0, 0.05)
    k = 0.08 - 0.06 * np.cos(2 * np.pi * time / 10.0)
    p = 1e5 * (3.0 + np.floor(time / 20.0))
    rows = np.stack([time, k, p / 1e5, truth.simulate(k, p, time)], axis=1)
    log = tmp_path / "motion.csv"
    np.savetxt(
        log,
        rows,
        delimiter=",",
        header="time_s,contraction,pressure_bar,force_N",
        comments="",
        fmt="%.9g",
    )
    words = ("chou-hannaford", "--param", "band=30", "--log", log)
    moved, still = figures(run, *words)["fit"], figures(run, *words, "--at-rest")["fit"]
    assert not moved["at_rest"] and moved["parameters"]["band"] == pytest.approx(80.0, rel=1e-3)
    assert (
        still["at_rest"]
        and still["parameters"]["band"] == 30.0
        and "band" in still["without_effect"]
    )


def keys_of(value):
    if isinstance(value, dict):
        return set(value).union(*(keys_of(item) for key, item in value.items() if key not in FREE))
    return set().union(*map(keys_of, value)) if isinstance(value, list) else set()


FREE = ("parameters", "standard_errors", "bounds", "sets")  # names of a model


def test_every_key_of_the_json_is_documented(run, bench):
    found = figures(run, "kerscher", "--log", bench / "plain.csv")
    keys = keys_of(found) | keys_of(json.loads(run("muscle", "--list", "--json")[1]))
    documented = set(
        re.findall(r"`([\w-]+)`", (DOCS / "reference" / "json.md").read_text(encoding="utf-8"))
    )
    assert not keys - documented
    assert len(keys) > 40


def test_a_damaged_muscle_file_is_refused_by_name(run, tmp_path):
    for text in (
        "",
        "[]",
        "{}",
        '{"format": "dehyst-muscle", "schema": 2}',
        '{"format": "dehyst-muscle", "schema": 1}',
    ):
        file = tmp_path / "m.json"
        file.write_text(text)
        status, _, err = run("muscle", file)
        assert status == 2 and err.startswith("ModelFileError") and "m.json" in err
    content = {
        "format": "dehyst-muscle",
        "schema": 1,
        "model": "maker",
        "parameters": muscle("maker").as_dict(),
    }
    for key, value in (
        ("force", "much"),
        ("force", None),
        ("force", [1, 2]),
        ("other", 1.0),
        ("length", -1.0),
    ):
        file.write_text(json.dumps(content | {"parameters": content["parameters"] | {key: value}}))
        assert run("muscle", file)[0] == 2, (key, value)
