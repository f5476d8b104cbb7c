"""Columns that nobody named are those that names and units leave no choice about; else the choice is shown."""

import json
import re

import numpy as np
import pytest

from dehyst.io import inspect_log, write_csv
from export_samples import play_model

T = np.arange(900) / 50
X = 1.5 * np.sin(T) * np.cos(T / 9) + 0.4
Y = play_model().simulate(X)
HEADS = {  # columns of X, of Y, and of others -> whether the pair is clear
    ("pressure_bar", "angle_deg"): True,
    ("voltage_v", "displacement_um"): True,
    ("u", "y"): True,
    ("input", "output"): True,
    ("a", "b"): False,
    ("#1", "#2"): False,
    ("left_deg", "right_deg"): False,
    ("pressure_1_bar", "angle_deg", "pressure_2_bar"): False,
    ("pressure_bar", "angle_deg", "angle_2_deg"): False,
    ("pressure_bar", "angle_deg", "speed_deg_per_s"): True,
}


def log_of(path, heads):
    signals = (X, Y, 0.7 * X + 0.1 * Y)
    write_csv(path, {"time_s": T, **dict(zip(heads, signals, strict=False))})
    return path


@pytest.mark.parametrize("heads", HEADS, ids="-".join)
def test_identify_takes_what_is_clear_and_says_so_and_asks_otherwise(run, tmp_path, heads):
    log = log_of(tmp_path / "log.csv", heads)
    status, out, err = run("identify", log, "--family", "pi", "--n", "9")
    assert inspect_log(log).clear == HEADS[heads]
    if HEADS[heads]:
        assert status == 0
        assert (
            out.splitlines()[0]
            == f"columns: --input {heads[0]} --output {heads[1]}, by their names and units"
        )
        return
    assert (status, out) == (2, "")
    assert re.search(
        r"if it is right: dehyst identify \S+ --input \S+ --output \S+$", " ".join(err.split())
    )
    assert all(head in err for head in heads)
    assert "looks like" in err  # the table of inspect


def test_with_json_the_standard_output_holds_nothing_else(run, tmp_path):
    log = log_of(tmp_path / "log.csv", ("pressure_bar", "angle_deg"))
    status, out, err = run("identify", log, "--family", "pi", "--n", "9", "--json")
    assert status == 0
    assert json.loads(out)["family"] == "pi"
    assert err.startswith("columns: --input pressure_bar --output angle_deg")


def test_what_is_proposed_gives_what_is_named(run, tmp_path):
    line = (
        "identify",
        log_of(tmp_path / "log.csv", ("pressure_bar", "angle_deg")),
        "--family",
        "pi",
        "--json",
    )
    named = run(*line, "--input", "pressure_bar", "--output", "angle_deg")
    assert json.loads(run(*line)[1])["train"] == json.loads(named[1])["train"]


def test_one_of_the_two_may_be_named(run, tmp_path):
    log = log_of(tmp_path / "log.csv", ("pressure_bar", "angle_deg", "speed_deg_per_s"))
    _, out, _ = run("identify", log, "--family", "pi", "--n", "9", "--output", "angle_deg")
    assert out.startswith("columns: --input pressure_bar --output angle_deg")
    status, _, err = run("identify", log, "--output", "pressure_bar")
    assert status == 2
    assert "The best guess, to be typed if it is right: dehyst identify" in " ".join(err.split())


@pytest.mark.slow
def test_compare_proposes_too(run, tmp_path):
    log = log_of(tmp_path / "log.csv", ("pressure_bar", "angle_deg"))
    status, out, _ = run("compare", log, "--families", "static")
    assert status == 0
    assert out.startswith("columns: --input pressure_bar --output angle_deg")
    assert run("compare", log_of(tmp_path / "ab.csv", ("a", "b")))[0] == 2


def test_commands_with_a_model_take_its_columns(run, tmp_path):
    log = log_of(tmp_path / "log.csv", ("pressure_bar", "angle_deg"))
    model = tmp_path / "m.json"
    play_model().save(model)
    named = run("simulate", model, log, "--input", "pressure_bar")
    assert run("simulate", model, log) == named
    assert run("compensate", model, log) == run("compensate", model, log, "--output", "angle_deg")
    folder = tmp_path / "out"
    assert run("export", model, "--target", "c", "--out", folder, "--log", log)[0] == 0
    assert (folder / "expected" / "excerpt.csv").exists()


def test_a_log_without_the_models_columns_names_what_it_has(run, tmp_path):
    log = log_of(tmp_path / "log.csv", ("a", "b"))
    model = tmp_path / "m.json"
    play_model().save(model)
    for command in ("simulate", "compensate"):
        status, _, err = run(command, model, log)
        assert status == 2
        assert "a, b" in err
        assert f"add --{'input' if command == 'simulate' else 'output'} COLUMN" in " ".join(
            err.split()
        )
