"""The command line as a user meets it: every command, files in and out, JSON, exit status, words of the errors."""

import json
import os
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import dehyst
from dehyst.export import subject_of
from dehyst.families import example
from dehyst.io import example_recording, write_csv
from element_samples import CARD as ELEMENT_CARD
from in_one import in_one

QUICK = ("--n", "20", "--family", "pi")
PRESSURE, ANGLE = "pressure_difference_bar", "angle_deg"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """An example log, a model identified on it, and a reference to follow."""
    place = tmp_path_factory.mktemp("cli")
    rec = example_recording(rate=10.0)
    write_csv(place / "log.csv", {"time_s": rec.time, PRESSURE: rec.input, ANGLE: rec.output})
    fit = dehyst.identify(dehyst.read_log(place / "log.csv", PRESSURE, ANGLE), "pi", n=20)
    fit.model.save(place / "model.json")
    t = np.arange(0, 20, 0.05)
    write_csv(place / "reference.csv", {"time_s": t, ANGLE: 25 * np.sin(0.5 * t)})
    return place


def table(text):
    """A CSV text as {column: values}."""
    lines = text.splitlines()
    values = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    return dict(zip(lines[0].split(","), values.T, strict=True))


# identify


def test_identify_prints_verdict_scores_and_the_next_command(run, folder):
    status, out, err = run(
        "identify", folder / "log.csv", "--input", PRESSURE, "--output", ANGLE, *QUICK
    )
    assert (status, err) == (0, "")
    flat = " ".join(out.split())
    for word in (
        "pi, held out",
        "no hysteresis, held out",
        "rms [deg]",
        "of 20 operators",
        "next:",
    ):
        assert word in flat
    assert re.search(r"inverse gain at most \S+ bar/deg", flat)
    assert re.search(r"pi, \d+ of 20 operators: \d+\.\d\d % of range rms on held-out loops", flat)


def test_identify_json_is_only_json_with_the_promised_keys(run, folder):
    status, out, err = run(
        "identify", folder / "log.csv", "--input", PRESSURE, "--output", ANGLE, "--json", *QUICK
    )
    assert (status, err) == (0, "")
    result = json.loads(out)
    score = {"rmse", "rmse_percent", "nrmse", "max"}
    assert set(result["train"]) == set(result["test"]) == set(result["static_test"]) == score
    assert (result["family"], result["n"]) == ("pi", 20)
    assert 0 < result["nonzero_weights"] <= 20
    for key in ("kkt_residual", "round_trip_error", "inverse_gain"):
        assert isinstance(result[key], float)
    assert result["kkt_residual"] < 1e-12 and result["round_trip_error"] < 1e-12
    assert all(set(warning) == {"code", "message"} for warning in result["warnings"])
    # The same numbers as in Python.
    fit = dehyst.identify(dehyst.read_log(folder / "log.csv", PRESSURE, ANGLE), "pi", n=20)
    assert result["test"]["rmse"] == pytest.approx(fit.test.rmse, rel=1e-12)


def test_several_parts_of_a_log_are_recordings_fitted_together(run, folder):
    log = folder / "log.csv"
    named = ("identify", log, "--input", PRESSURE, "--output", ANGLE, "--json", *QUICK)
    status, out, _ = run(
        *named, "--from", "0", "--to", "40", "--from", "60", "--to", "100", "--from", "110"
    )
    assert status == 2  # three beginnings, two ends
    whole = run(*named, "--from", "0", "--to", "inf", "--save", folder / "open.json", "--overwrite")
    assert whole[0] == 0 and json.loads(whole[1])["test"] == json.loads(run(*named)[1])["test"]
    status, out, _ = run(*named, "--from", "0", "--from", "60", "--to", "40", "--to", "100")
    parts = [
        dehyst.read_log(log, PRESSURE, ANGLE, start=a, stop=b) for a, b in ((0, 40), (60, 100))
    ]
    fit = dehyst.identify(parts, "pi", n=20)
    assert status == 0 and json.loads(out)["test"]["rmse"] == pytest.approx(
        fit.test.rmse, rel=1e-12
    )
    status, out, err = run(*named, "--from", "0", "--to", "40", "--from", "30", "--to", "100")
    assert status == 2 and "--from 0.0 --from 30.0 --to 40.0 --to 100.0: several parts" in " ".join(
        err.split()
    )
    bounds = ("--from", "0", "--from", "60", "--to", "40", "--to", "100")
    status, out, _ = run("evaluate", folder / "model.json", log, "--json", *bounds)
    assert status == 0 and json.loads(out)["samples"] == sum(map(len, parts))


def test_json_has_null_where_there_is_no_test_and_never_infinity(run, folder):
    arguments = (
        "identify",
        folder / "log.csv",
        "--input",
        PRESSURE,
        "--output",
        ANGLE,
        "--json",
        *QUICK,
    )
    status, out, _ = run(*arguments, "--train-fraction", "1")
    result = json.loads(out, parse_constant=pytest.fail)
    assert status == 0
    assert result["test"] is None and result["static_test"] is None
    assert "(nothing held out)" in result["verdict"]


def test_identify_saves_a_model_that_remembers_where_it_came_from(run, folder, tmp_path):
    target = tmp_path / "m.json"
    status, out, _ = run(
        "identify",
        folder / "log.csv",
        "--input",
        PRESSURE,
        "--output",
        ANGLE,
        *QUICK,
        "--save",
        target,
    )
    assert status == 0 and str(target) in out.replace("\n", "") and "dehyst compensate" in out
    model = dehyst.load(target)
    assert (model.card.input.label, model.card.output.label) == (
        "pressure_difference [bar]",
        "angle [deg]",
    )
    assert model.card.provenance["logs"][0]["file"] == "log.csv"
    assert model.card.provenance["settings"]["n"] == 20


@pytest.mark.slow
def test_identify_writes_report_and_figures(run, folder, tmp_path):
    page, figures = tmp_path / "r.html", tmp_path / "figures"
    arguments = ("identify", folder / "log.csv", "--input", PRESSURE, "--output", ANGLE, *QUICK)
    status, _, _ = run(*arguments, "--report", page, "--figures", figures)
    assert status == 0
    assert page.read_text(encoding="utf-8").lstrip().lower().startswith("<!doctype html")
    assert {path.suffix for path in figures.iterdir()} >= {".svg", ".png"}


@pytest.mark.slow
def test_figures_are_written_without_a_report_too(run, folder, tmp_path):
    arguments = ("identify", folder / "log.csv", "--input", PRESSURE, "--output", ANGLE, *QUICK)
    status, out, _ = run(*arguments, "--figures", tmp_path / "figures")
    assert status == 0 and "figures: " in out
    assert {path.suffix for path in (tmp_path / "figures").iterdir()} == {".svg", ".png"}
    assert [path.name for path in tmp_path.iterdir()] == ["figures"]


def test_family_and_settings_reach_the_identification(run, folder):
    base = ("identify", folder / "log.csv", "--input", PRESSURE, "--output", ANGLE, "--json")
    for family in ("pi", "pi-cumulative", "modified-pi", "stop"):
        result = json.loads(run(*base, "--family", family, "--n", "15")[1])
        assert (result["family"], result["n"]) == (family, 15)
    result = json.loads(
        run(*base, "--family", "pi", "--thresholds", "0,0.1,0.5", "--initial-state", "rest")[1]
    )
    assert (result["n"], result["initial_state"]) == (3, "rest")
    gains = [
        json.loads(run(*base, *QUICK, "--eps", eps)[1])["inverse_gain"] for eps in ("0.001", "5.0")
    ]
    assert gains[1] < gains[0]


def test_the_window_cuts_the_log(run, folder, tmp_path):
    target = tmp_path / "m.json"
    base = (
        "identify",
        folder / "log.csv",
        "--input",
        PRESSURE,
        "--output",
        ANGLE,
        *QUICK,
        "--save",
        target,
    )
    assert run(*base, "--from", "12", "--to", "84")[0] == 0
    log = dehyst.load(target).card.provenance["logs"][0]
    assert log["samples"] == 720
    assert log["window"] == [12.0, 84.0]


def test_several_logs_and_several_runs_are_fitted_together(run, folder, tmp_path):
    rec = example_recording(rate=10.0)
    run_column = np.repeat(["a", "b", "c"], len(rec) // 3)
    lines = [f"run,time_s,{PRESSURE},{ANGLE}"]
    lines += [
        f"{r},{t},{x},{y}"
        for r, t, x, y in zip(run_column, rec.time, rec.input, rec.output, strict=True)
    ]
    (tmp_path / "runs.csv").write_text("\n".join(lines) + "\n")
    target = tmp_path / "m.json"
    tail = ("--input", PRESSURE, "--output", ANGLE, *QUICK, "--save", target)
    assert run("identify", tmp_path / "runs.csv", "--run", "a", "--run", "c", *tail)[0] == 0
    logs = dehyst.load(target).card.provenance["logs"]
    assert [log["run"] for log in logs] == ["a", "c"]
    other = tmp_path / "other.csv"
    write_csv(
        other,
        {
            "time_s": rec.time,
            PRESSURE: rec.input,
            ANGLE: rec.output + 0.01 * np.sin(7.0 * rec.time),
        },
    )
    assert run("identify", folder / "log.csv", other, *tail, "--overwrite")[0] == 0
    assert len(dehyst.load(target).card.provenance["logs"]) == 2
    status, _, err = run("identify", tmp_path / "runs.csv", *tail, "--overwrite")
    assert status == 2 and err.startswith("RunError") and "--run" in err


@pytest.mark.parametrize(
    ("x", "y"),
    [
        ("p [bar]", "q [deg]"),
        ("<b>", "</b>"),
        ("[bold]", "[/red]"),
        ("druck [µm]", "winkel °"),
        ("$x_1$", "{y}"),
    ],
)
def test_odd_column_names_survive(run, tmp_path, x, y):
    rec = example_recording(rate=5.0)
    log = tmp_path / "odd log.csv"
    write_csv(log, {"time_s": rec.time, x: rec.input, y: rec.output})
    target = tmp_path / "m.json"
    status, out, _ = run("identify", log, "--input", x, "--output", y, *QUICK, "--save", target)
    assert status == 0
    model = dehyst.load(target)
    assert model.card.input.name == x.split(" [")[0]
    assert model.card.output.name == dehyst.read_log(log, x, y).output_name
    assert model.card.output.name in out  # in the line to type next
    status, out, _ = run("simulate", target, log, "--input", x)
    assert status == 0 and model.card.input.name in out.splitlines()[0]
    status, out, _ = run("inspect", log)
    assert status == 0 and x.split(" [")[0] in out


def bad_log(place):
    """A log of mere noise: no model of it may drive anything."""
    rng = np.random.default_rng(0)
    t = np.arange(0, 60, 0.05)
    write_csv(place, {"time_s": t, "p_bar": np.sin(t), "q_deg": rng.standard_normal(t.size)})
    return place


@pytest.mark.slow
def test_what_to_do_next_agrees_with_the_verdict(run, tmp_path):
    log, model = bad_log(tmp_path / "noise.csv"), tmp_path / "m.json"
    arguments = ("identify", log, "--input", "p_bar", "--output", "q_deg", *QUICK)
    for more in ((), ("--save", model, "--report", tmp_path / "r.html")):
        status, out, _ = run(*arguments, *more)
        flat = " ".join(out.split())
        assert status == 0 and "do not compensate with it" in flat
        assert "next: do not compensate with this model" in flat and "dehyst compensate" not in flat
    assert "dehyst simulate" in flat
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "dehyst compensate" not in page and "dehyst simulate" in page
    assert 'class="verdict stop" id="verdict"' in page


@pytest.mark.slow
def test_a_model_asked_for_to_simulate_is_offered_for_that(run, folder, tmp_path):
    """LuGre has no inverse: the advice was to leave --for simulate out, and its report showed a gain of infinity."""
    log, model, page = folder / "log.csv", tmp_path / "m.json", tmp_path / "r.html"
    line = (
        "identify",
        log,
        "--input",
        PRESSURE,
        "--output",
        ANGLE,
        "--family",
        "lugre",
        "--for",
        "simulate",
    )
    flat = " ".join(run(*line)[1].split())
    assert "simulate with it, do not compensate with it. It has no inverse: " in flat
    assert flat.endswith("next: repeat with --save model.json --report report.html")
    out = run(*line, "--save", model, "--report", page)[1]
    following = out.rpartition("next: ")[2].strip()
    assert following.startswith("dehyst simulate ")
    assert run(*following.replace("LOG.csv", str(log)).split()[1:])[0] == 0
    text = page.read_text(encoding="utf-8")
    assert "for simulation only" in text and "\u221e" not in text and "not a number" not in text


def test_columns_that_leave_a_choice_end_in_a_line_that_works(run, tmp_path, monkeypatch):
    t = np.arange(0.0, 60.0, 0.05)
    x = 5 * np.sin(t) * np.linspace(1.0, 0.3, t.size)
    y = dehyst.PrandtlIshlinskii([0.0, 1.0], [1.0, 0.5]).simulate(x)
    write_csv(tmp_path / "log.csv", {"time_s": t, "dac": x, "adc": y})
    monkeypatch.chdir(tmp_path)
    status, _, err = run("identify", "log.csv")
    assert status == 2
    line = " ".join(err.split()).rpartition("to be typed if it is right: ")[2]
    assert line == "dehyst identify log.csv --input dac --output adc"
    assert run(*line.split()[1:], *QUICK)[0] == 0


# simulate, compensate


def judged(folder, place, grade, verdict):
    model = dehyst.load(folder / "model.json")
    card = replace(model.card, provenance={"grade": grade, "verdict": verdict})
    model.with_card(card).save(place)
    return place


def test_compensate_says_loudly_that_a_model_is_not_fit_for_it(run, folder, tmp_path):
    verdict = "pi, 3 of 9 operators: 20 % off: do not compensate with it.\x1b[31m"
    model = judged(folder, tmp_path / "m.json", "no", verdict)
    status, out, err = run("compensate", model, folder / "reference.csv", "--output", ANGLE)
    assert status == 0 and len(table(out)) == 3
    said = " ".join(err.split())
    assert (
        "warning verdict: " in said
        and "do not compensate with it" in said
        and "Do not apply this input" in said
    )
    assert "20 % off" in said and "\x1b" not in err
    assert (
        run("simulate", model, folder / "log.csv", "--input", PRESSURE)[0] == 0
    )  # to simulate is no harm


@pytest.mark.slow
def test_an_empty_file_may_be_written_over(run, folder, tmp_path):
    for name in ("empty.json", "empty.csv"):
        (tmp_path / name).touch()
    arguments = (
        folder / "log.csv",
        "--input",
        PRESSURE,
        "--output",
        ANGLE,
        "--save",
        tmp_path / "empty.json",
    )
    assert run("identify", *arguments)[0] == 0
    assert run("example", "--out", tmp_path / "empty.csv")[0] == 0
    assert dehyst.load(tmp_path / "empty.json").family


def test_compensate_repeats_a_verdict_with_reserve_and_no_other(run, folder, tmp_path):
    arguments = (folder / "reference.csv", "--output", ANGLE)
    model = judged(
        folder,
        tmp_path / "m.json",
        "care",
        "pi, 3 of 9 operators: 6 % off: usable with care (drift).",
    )
    status, _, err = run("compensate", model, *arguments)
    assert (
        status == 0
        and "warning verdict: " in err
        and "usable with care (drift)" in " ".join(err.split())
    )
    harmless = [
        ("good", "pi: 1 % off: good for compensation."),
        (None, "do not compensate with it"),
        (["no"], "bad"),
    ]
    for grade, verdict in [*harmless, ("no", None), ("care", 7), (2, "do not compensate")]:
        status, _, err = run("compensate", judged(folder, model, grade, verdict), *arguments)
        assert status == 0 and err.startswith("start: model, ") and err.count("\n") == 1


def test_simulate_prints_the_models_output_with_units(run, folder):
    status, out, err = run(
        "simulate", folder / "model.json", folder / "log.csv", "--input", PRESSURE
    )
    assert status == 0 and err.startswith("start: model, ") and err.count("\n") == 1
    columns = table(out)
    assert list(columns) == ["time [s]", "pressure_difference [bar]", "model_angle [deg]"]
    rec = dehyst.read_log(folder / "log.csv", PRESSURE, ANGLE)
    assert np.array_equal(columns["pressure_difference [bar]"], rec.input)
    model = dehyst.load(folder / "model.json")
    assert np.array_equal(columns["model_angle [deg]"], model.simulate(rec.input))


def test_compensate_then_simulate_gives_the_reference_back(run, folder, tmp_path):
    asked, answer = tmp_path / "input.csv", tmp_path / "answer.csv"
    status, out, _ = run(
        "compensate",
        folder / "model.json",
        folder / "reference.csv",
        "--output",
        ANGLE,
        "--start",
        "model",
        "--out",
        asked,
    )
    assert (status, out) == (0, "")
    column = "compensated_pressure_difference [bar]"
    assert run("simulate", folder / "model.json", asked, "--input", column, "--out", answer)[0] == 0
    reference = dehyst.read_signal(folder / "reference.csv", ANGLE).values
    found = dehyst.read_signal(answer, "model_angle [deg]").values
    assert np.abs(found - reference).max() < 1e-10 * np.ptp(reference)
    # And it is not the identity: the compensator had to do something.
    assert np.ptp(table(asked.read_text())[column]) < 0.2 * np.ptp(reference)


def test_a_unit_that_shapes_its_reference_has_a_period_though_its_sum_knows_no_time(run, tmp_path):
    """Its delay is counted in samples: without a word of the period a faster loop got a tenth of it."""
    model = replace(example("play-sum"), resonance=(5.0, 0.02), period=0.02, card=ELEMENT_CARD)
    model.save(tmp_path / "m.json")
    line = (
        "export",
        tmp_path / "m.json",
        "--target",
        "c",
        "--overwrite",
        "--out",
        tmp_path / "unit",
    )
    status, out, err = run(*line)
    readme = " ".join((tmp_path / "unit" / "README.md").read_text().split())
    assert status == 0 and "warning reference-shaped" in err + out
    assert "0.02 s from sample to sample" in readme and "the actuator rings at 5 Hz" in readme
    assert subject_of(model, name="m").period == 0.02
    assert subject_of(model, name="m", period=0.002).unit.numbers.model.parameters.delay == 50
    status, out, err = run(*line, "--period", "0.2")
    assert status == 0 and "warning resonance-too-fast" in err + out and " ahead" not in out
    status, out, err = run(*line, "--what", "forward")
    assert status == 0 and "warning resonance-left-out" in err + out


def test_a_reference_is_moved_ahead_once_however_long_it_is_known(run, tmp_path):
    model = replace(example("play-sum"), resonance=(2.5, 0.0), period=0.02)
    t = np.arange(0.0, 20.0, 0.02)
    model.save(tmp_path / "m.json")
    write_csv(tmp_path / "reference.csv", {"time_s": t, "output": np.where(t < 10.0, 0.0, 0.5)})
    line = ("compensate", tmp_path / "m.json", tmp_path / "reference.csv", "--output", "output")
    first, words = {}, {}
    for ahead in ("auto", "0", "0.06", "0.2"):
        status, csv, err = run(*line, "--ahead", ahead)
        written = table(csv)
        values = written[next(name for name in written if name.startswith("compensated"))]
        first[ahead] = float(t[np.argmax(np.abs(values - values[0]) > 1e-9)])
        words[ahead] = " ".join(err.split())
        assert status == 0 and "two parts 0.2 s apart" in words[ahead]
    assert first == pytest.approx({"auto": 9.9, "0": 10.0, "0.06": 9.94, "0.2": 9.8}, abs=1e-6)
    assert "the output follows 0.1 s behind" in words["0"]
    assert "the output follows 0.04 s behind" in words["0.06"]
    assert "behind" not in words["auto"] + words["0.2"]


def test_a_reference_too_short_to_ring_is_left_as_it_is(run, tmp_path):
    replace(example("play-sum"), resonance=(2.5, 0.0), period=0.02).save(tmp_path / "m.json")
    for values in ([0.1], [0.1, 0.1], [0.0, 0.1, 0.2]):
        columns = {"time_s": 0.02 * np.arange(len(values)), "output": np.array(values)}
        write_csv(tmp_path / "reference.csv", columns)
        line = ("compensate", tmp_path / "m.json", tmp_path / "reference.csv", "--output", "output")
        status, _, err = run(*line)
        assert status == 0 and "shaped" not in err and "round-trip" not in err


@pytest.mark.parametrize("text", ["", "300", "300,2", "300 Hz,0.02", "0,0.1", "nan,0.1", "1,2,3"])
def test_a_resonance_that_is_none_is_refused_with_what_to_type(run, folder, text):
    status, out, err = run("identify", folder / "log.csv", "--resonance", text)
    assert status and "Traceback" not in err + out
    assert "resonance" in err and ("300,0.02" in err or "frequency" in err)


def test_computed_values_are_sent_earlier_by_the_dead_time(run, tmp_path):
    """compensate said that the inverse loses digits, and left it to the person to move the values."""
    model = replace(example("creep-pi"), dead_time=0.1, period=0.02)
    t = np.arange(0.0, 20.0, 0.02)
    wanted = 0.5 * np.sin(t)
    model.save(tmp_path / "late.json")
    write_csv(tmp_path / "reference.csv", {"time_s": t, "output": wanted})
    line = ("compensate", tmp_path / "late.json", tmp_path / "reference.csv", "--output", "output")
    asked = {}
    for ahead, told in (
        ("auto", "stands 0.1 s before the output"),
        ("0", "leave --ahead 0 out"),
        ("0.06", "stands 0.06 s before"),
    ):
        status, csv, err = run(*line, "--ahead", ahead)
        said = " ".join(err.split())
        assert status == 0 and "warning dead-time: " in said and told in said
        assert "round-trip" not in said
        written = table(csv)
        asked[ahead] = written[next(name for name in written if name.startswith("compensated"))]
    np.testing.assert_allclose(asked["auto"][:-5], asked["0"][5:], atol=1e-12)
    np.testing.assert_allclose(asked["0.06"][:-3], asked["0"][3:], atol=1e-12)
    errors = {}
    for ahead in ("auto", "0"):
        sent = asked[ahead]
        answer = model.at_rest(float(sent[0])).simulate(sent, t)
        errors[ahead] = np.abs(answer - wanted)[100:-5].max()
    assert errors["auto"] < 0.02 and errors["0"] > 0.04
    assert run(*line)[1] == run(*line, "--ahead", "auto")[1]
    for wrong in ("-1", "soon", "nan", "inf"):
        status, _, err = run(*line, f"--ahead={wrong}")
        assert status != 0 and "--ahead 0.08" in " ".join(err.split())
    out = run(
        "export",
        tmp_path / "late.json",
        "--target",
        "c",
        "--range",
        "-1",
        "1",
        "--out",
        tmp_path / "unit",
    )[1]
    assert "give the unit the reference that much ahead" in " ".join(out.split())
    assert "wants its input 0.1 s ahead" in (tmp_path / "unit" / "README.md").read_text()


def test_units_are_converted_and_said(run, folder, tmp_path):
    reference = dehyst.read_signal(folder / "reference.csv", ANGLE)
    radians = tmp_path / "rad.csv"
    write_csv(radians, {"time_s": reference.time, "angle_rad": np.deg2rad(reference.values)})
    _, degrees_out, _ = run(
        "compensate", folder / "model.json", folder / "reference.csv", "--output", ANGLE
    )
    status, out, err = run("compensate", folder / "model.json", radians, "--output", "angle_rad")
    assert status == 0
    assert "unit-converted" in err and "from rad to" in " ".join(err.split())
    column = "compensated_pressure_difference [bar]"
    assert np.abs(table(out)[column] - table(degrees_out)[column]).max() < 1e-9
    assert table(out)["angle [deg]"] == pytest.approx(reference.values, abs=1e-9)


def test_units_that_cannot_be_converted_are_refused_and_unknown_ones_said(run, folder, tmp_path):
    write_csv(
        tmp_path / "a.csv",
        {"time_s": [0, 1, 2, 3], "force_N": [0, 1, 2, 3], "reference": [0, 5, 9, 3]},
    )
    status, out, err = run(
        "compensate", folder / "model.json", tmp_path / "a.csv", "--output", "force_N"
    )
    assert status == 2 and out == "" and err.startswith("UnitError")
    status, out, err = run(
        "compensate", folder / "model.json", tmp_path / "a.csv", "--output", "reference"
    )
    assert status == 0 and "unit-unknown" in err and len(out.splitlines()) == 5


def test_leaving_the_identified_range_is_said(run, folder, tmp_path):
    t = np.arange(0, 20, 0.1)
    write_csv(tmp_path / "far.csv", {"time_s": t, ANGLE: 90 * np.sin(t), PRESSURE: 20 * np.sin(t)})
    for command in (("compensate", "--output", ANGLE), ("simulate", "--input", PRESSURE)):
        status, _, err = run(command[0], folder / "model.json", tmp_path / "far.csv", *command[1:])
        assert status == 0 and "outside-range" in err and "extrapolates" in " ".join(err.split())


def test_a_reference_may_leave_the_range_by_two_percent_without_a_word(run, folder, tmp_path):
    card = dehyst.load(folder / "model.json").card.output
    for beyond, said in ((0.015, False), (0.025, True)):
        top = card.high + beyond * (card.high - card.low)
        write_csv(
            tmp_path / "r.csv",
            {"time_s": np.arange(400) / 20, ANGLE: top * np.sin(np.linspace(0, 7, 400))},
        )
        err = run("compensate", folder / "model.json", tmp_path / "r.csv", "--output", ANGLE)[2]
        assert ("reference leaves" in " ".join(err.split())) == said


def test_jumps_of_the_computed_input_are_said_with_size_and_place(run, folder, tmp_path):
    card = dehyst.load(folder / "model.json").card.input
    angle = np.r_[np.linspace(0, 10, 100), np.linspace(-10, 0, 100)]
    write_csv(tmp_path / "r.csv", {"time_s": np.arange(200) / 100, ANGLE: angle})
    status, out, err = run(
        "compensate", folder / "model.json", tmp_path / "r.csv", "--output", ANGLE
    )
    flat = " ".join(err.split())
    assert status == 0 and "warning input-jumps: " in flat and "at 1 of 199 steps" in flat
    x = table(out)["compensated_pressure_difference [bar]"]
    size = np.abs(np.diff(x)).max()
    assert f"{size:.4g} bar ({100 * size / (card.high - card.low):.3g} %)" in flat
    assert "from 0.99 s to 1 s" in flat and "--eps" not in flat  # the reference itself jumps
    assert (
        "input-jumps"
        not in run(
            "compensate", folder / "model.json", folder / "reference.csv", "--output", ANGLE
        )[2]
    )


def test_a_gap_carries_the_memory_on_and_that_is_what_is_said(run, folder, tmp_path):
    t = np.r_[np.arange(100), np.arange(400, 500)] / 20
    wave = 20 * np.sin(t)
    write_csv(tmp_path / "gap.csv", {"time_s": t, ANGLE: wave, PRESSURE: wave / 10})
    model = dehyst.load(folder / "model.json")
    expected = {"compensate": model.inverse().simulate(wave), "simulate": model.simulate(wave / 10)}
    for command in (("compensate", "--output", ANGLE), ("simulate", "--input", PRESSURE)):
        status, out, err = run(
            command[0],
            folder / "model.json",
            tmp_path / "gap.csv",
            *command[1:],
            "--start",
            "model",
        )
        flat = " ".join(err.split())
        assert (
            status == 0 and "warning memory-carried: " in flat and "between 4.95 s and 20 s" in flat
        )
        assert "unknown" not in flat and "input-jumps" not in flat
        assert list(table(out).values())[-1] == pytest.approx(expected[command[0]], rel=1e-12)


def test_findings_of_simulate_go_to_stderr_so_that_csv_can_be_piped(run, folder, tmp_path):
    lines = (folder / "log.csv").read_text().splitlines()
    lines[50] = lines[50].rsplit(",", 2)[0] + ",nan,1"
    (tmp_path / "holes.csv").write_text("\n".join(lines) + "\n")
    status, out, err = run(
        "simulate", folder / "model.json", tmp_path / "holes.csv", "--input", PRESSURE
    )
    assert status == 0 and "warning" in err and "warning" not in out
    assert len(table(out)) == 3


# inspect, example


def test_inspect_shows_columns_and_a_command_that_works(run, folder):
    status, out, _ = run("inspect", folder / "log.csv")
    assert status == 0
    assert PRESSURE.removesuffix("_bar") in out and "looks like" in out
    line = next(line for line in out.splitlines() if line.startswith("next: "))
    assert "--input pressure_difference_bar --output angle_deg" in line
    summary = json.loads(run("inspect", folder / "log.csv", "--json")[1])
    assert summary["rows"] == 1440
    assert {column["name"] for column in summary["columns"]} == {"time_s", PRESSURE, ANGLE}


def test_inspect_shows_motion_on_top_of_a_large_offset(run, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    t = np.arange(200) / 10
    columns = {
        "time_s": t,
        "p_Pa": 1e5 + np.sin(t),
        "still": np.full(200, 1e5),
        "q_deg": 1 + 1e-6 * np.cos(t),
    }
    write_csv(tmp_path / "log.csv", columns)
    rows = {
        line.split()[0]: line
        for line in run("inspect", tmp_path / "log.csv")[1].splitlines()
        if line.strip()
    }
    for name in ("p_Pa", "q_deg"):
        low, high = (float(cell) for cell in rows[name].split()[2:4])
        span = np.ptp(columns[name])
        assert low == pytest.approx(columns[name].min(), abs=span / 1000)
        assert high == pytest.approx(columns[name].max(), abs=span / 1000)
        assert "e" not in rows[name].split()[2] + rows[name].split()[3]
    assert "constant" in rows["still"] and "constant" not in rows["p_Pa"] + rows["q_deg"]


@pytest.mark.parametrize("width", ["30", "80", "200"])
def test_inspect_never_breaks_a_name(run, tmp_path, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", width)
    long = "pressure_of_the_left_upper_muscle_after_the_second_valve_filtered_bar"
    t = np.arange(200) / 10
    write_csv(
        tmp_path / "log.csv", {"time_s": t, long: np.sin(t), "ang le_deg": np.cos(t), "圧" * 20: t}
    )
    lines = run("inspect", tmp_path / "log.csv")[1].splitlines()
    for name in (long, "ang le_deg", "圧" * 20):
        assert any(line.startswith(name) for line in lines)
    row = next(line for line in lines if line.startswith(long))
    assert row.split()[1:5] == ["bar", f"{np.sin(t).min():.5g}", f"{np.sin(t).max():.5g}", "3"]


def test_two_samples_that_differ_are_not_called_constant(run, tmp_path):
    (tmp_path / "log.csv").write_text("time_s,p_bar,q_deg\n0,1,5\n1,2,5\n2,3,5\n")
    rows = {
        line.split()[0]: line
        for line in run("inspect", tmp_path / "log.csv")[1].splitlines()
        if line.strip()
    }
    assert "constant" not in rows["p_bar"] and "constant" in rows["q_deg"]


def test_the_unit_of_the_clock_can_be_named_for_every_command(run, folder, tmp_path):
    rec = example_recording(rate=10.0)
    write_csv(
        tmp_path / "log.csv", {"time": rec.time * 1000, PRESSURE: rec.input, ANGLE: rec.output}
    )
    log, model = tmp_path / "log.csv", tmp_path / "m.json"
    unit = ("--time-unit", "ms")
    pair = ("--input", PRESSURE, "--output", ANGLE)
    assert (
        run("identify", log, *pair, *QUICK, *unit, "--from", "12", "--to", "84", "--save", model)[0]
        == 0
    )
    assert dehyst.load(model).card.provenance["logs"][0]["samples"] == 720
    for command in (
        ("simulate", model, log, "--input", PRESSURE),
        ("compensate", model, log, "--output", ANGLE),
    ):
        status, out, _ = run(*command, *unit, "--to", "50")
        assert status == 0 and table(out)["time [s]"][-1] == pytest.approx(49.9)
    out = run("inspect", log, *unit)[1]
    assert "10 Hz" in out and "--time-unit ms" in out
    status, _, err = run("inspect", log, "--time-unit", "bar")
    assert status == 2 and err.startswith("UnitError: ")


def test_example_writes_a_log_and_says_what_to_type(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, out, _ = run("example", "--out", "my log.csv", "--seed", "3")
    assert status == 0
    assert '"my log.csv"' in out  # quoted for any shell
    rec = dehyst.read_log("my log.csv", PRESSURE, ANGLE)
    assert np.array_equal(rec.output, example_recording(seed=3).output)
    assert run("example")[0] == 0 and (tmp_path / "example.csv").is_file()


# Errors


def failing(folder, tmp_path):
    log, model = folder / "log.csv", folder / "model.json"
    pair = ("--input", PRESSURE, "--output", ANGLE)
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "text.csv").write_text("hello\nworld\n")
    (tmp_path / "flat.csv").write_text(
        "time_s,p_bar,q_deg\n" + "".join(f"{k},1,{k % 5}\n" for k in range(50))
    )
    return [
        ("LogError", ("identify", tmp_path / "missing.csv", *pair)),
        ("LogError", ("identify", tmp_path, *pair)),
        ("LogError", ("identify", tmp_path / "empty.csv", *pair)),
        ("LogError", ("identify", tmp_path / "text.csv", *pair)),
        ("ColumnError", ("identify", log, "--input", "nope", "--output", ANGLE)),
        ("ColumnError", ("identify", log, "--input", ANGLE, "--output", ANGLE)),
        (
            "ExcitationError",
            ("identify", tmp_path / "flat.csv", "--input", "p_bar", "--output", "q_deg"),
        ),
        ("ParameterError", ("identify", log, *pair, "--family", "bouc")),
        ("ParameterError", ("identify", log, *pair, "--family", "bouc-wen", "--n", "7")),
        ("ParameterError", ("identify", log, *pair, "--for", "fun")),
        ("ParameterError", ("identify", log, *pair, "--n", "0")),
        ("ParameterError", ("identify", log, *pair, "--eps", "-1")),
        ("ParameterError", ("identify", log, *pair, "--eps", "nan")),
        ("ParameterError", ("identify", log, *pair, "--train-fraction", "2")),
        ("ParameterError", ("identify", log, *pair, "--thresholds", "0,a")),
        ("ParameterError", ("identify", log, *pair, "--initial-state", "odd")),
        ("OutputError", ("identify", log, *pair, "--figures", tmp_path / "empty.csv")),
        ("TimeError", ("identify", log, *pair, "--from", "5", "--to", "5")),
        ("TimeError", ("identify", log, *pair, "--from", "1e6")),
        ("OutputError", ("identify", log, *pair, "--save", tmp_path / "no" / "m.json")),
        ("OutputError", ("identify", log, *pair, "--save", log)),
        (
            "OutputError",
            ("identify", log, *pair, "--save", tmp_path / "x", "--report", tmp_path / "x"),
        ),
        ("ModelFileError", ("simulate", log, log, "--input", PRESSURE)),
        (
            "ModelFileError",
            ("compensate", tmp_path / "none.json", folder / "reference.csv", "--output", ANGLE),
        ),
        ("ColumnError", ("simulate", model, log, "--input", "nope")),
        ("OutputError", ("simulate", model, log, "--input", PRESSURE, "--out", log)),
        ("OutputError", ("compensate", model, log, "--output", ANGLE, "--out", tmp_path)),
        ("LogError", ("inspect", tmp_path / "missing.csv")),
        ("OutputError", ("example", "--out", tmp_path / "no" / "e.csv")),
    ]


def test_errors_exit_with_status_2_and_their_name_and_touch_nothing(run, folder, tmp_path):
    before = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    for name, arguments in failing(folder, tmp_path):
        status, out, err = run(*arguments)
        assert (status, out) == (2, ""), arguments
        assert err.startswith(f"{name}: ") and len(err) > 40, (arguments, err)
    assert {path: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before


def test_a_log_is_never_overwritten_by_another_name_for_it(run, folder, tmp_path):
    log = tmp_path / "log.csv"
    log.write_bytes((folder / "log.csv").read_bytes())
    (tmp_path / "link.csv").symlink_to(log)
    os.link(log, tmp_path / "hard.csv")
    content = log.read_bytes()
    for other in ("link.csv", "hard.csv"):
        run(
            "identify",
            log,
            "--input",
            PRESSURE,
            "--output",
            ANGLE,
            *QUICK,
            "--save",
            tmp_path / other,
        )
        run("simulate", folder / "model.json", log, "--input", PRESSURE, "--out", tmp_path / other)
        assert log.read_bytes() == content
        status, _, err = run(
            "identify",
            log,
            "--input",
            PRESSURE,
            "--output",
            ANGLE,
            "--save",
            tmp_path / other,
            "--overwrite",
        )
        assert status == 2 and "the log itself" in " ".join(err.split())
        status, _, err = run(
            "simulate",
            folder / "model.json",
            log,
            "--input",
            PRESSURE,
            "--out",
            tmp_path / other,
            "--overwrite",
        )
        assert status == 2 and "the log or the model itself" in " ".join(err.split())
        assert os.path.samestat((tmp_path / other).stat(), log.stat()), (
            "the other name is still there"
        )
    arguments = (
        "simulate",
        folder / "model.json",
        log,
        "--input",
        PRESSURE,
        "--out",
        folder / "model.json",
    )
    model = (folder / "model.json").read_bytes()
    assert run(*arguments)[0] == 2
    assert (folder / "model.json").read_bytes() == model


@pytest.mark.slow
def test_no_file_of_the_user_is_overwritten_unless_he_says_so(run, folder, tmp_path):
    mine = tmp_path / "mine"
    pair = ("--input", PRESSURE, "--output", ANGLE, *QUICK)
    commands = [
        ("example", "--out", mine),
        ("simulate", folder / "model.json", folder / "log.csv", "--input", PRESSURE, "--out", mine),
        (
            "compensate",
            folder / "model.json",
            folder / "reference.csv",
            "--output",
            ANGLE,
            "--out",
            mine,
        ),
        ("identify", folder / "log.csv", *pair, "--save", mine),
        ("identify", folder / "log.csv", *pair, "--report", mine),
    ]
    for command in commands:
        mine.write_text("a year of measurements")
        status, out, err = run(*command)
        assert (status, out) == (2, "") and err.startswith("OutputError: ") and "--overwrite" in err
        assert mine.read_text() == "a year of measurements"
        assert run(*command, "--overwrite")[0] == 0
        assert len(mine.read_text()) > 100


def test_a_command_can_be_repeated_where_nothing_would_be_lost(run, folder, tmp_path):
    for _ in range(2):
        assert run("example", "--out", tmp_path / "e.csv")[0] == 0
        assert run("compensate", folder / "model.json", folder / "reference.csv", "--output", ANGLE,
                   "--out", tmp_path / "c.csv")[0] == 0  # fmt: skip
    assert run("example", "--out", tmp_path / "e.csv", "--seed", "1")[0] == 2
    (tmp_path / "e.csv").write_text((tmp_path / "e.csv").read_text() + "one more row")
    assert run("example", "--out", tmp_path / "e.csv")[0] == 2


@pytest.mark.slow
def test_identify_replaces_its_own_model_and_page_but_not_one_by_the_other(run, folder, tmp_path):
    model, page = tmp_path / "m.json", tmp_path / "r.html"
    arguments = ("identify", folder / "log.csv", "--input", PRESSURE, "--output", ANGLE, *QUICK)
    for _ in range(2):
        assert run(*arguments, "--save", model, "--report", page)[0] == 0
    for swapped in (("--save", page), ("--report", model)):
        status, _, err = run(*arguments, *swapped)
        assert status == 2 and err.startswith("OutputError: ")
    dehyst.load(model)


def test_a_source_is_never_overwritten_whatever_is_said(run, folder):
    log, model = (folder / "log.csv").read_bytes(), (folder / "model.json").read_bytes()
    for command in (
        (
            "identify",
            folder / "log.csv",
            "--input",
            PRESSURE,
            "--output",
            ANGLE,
            "--save",
            folder / "log.csv",
        ),
        (
            "simulate",
            folder / "model.json",
            folder / "log.csv",
            "--input",
            PRESSURE,
            "--out",
            folder / "log.csv",
        ),
        (
            "simulate",
            folder / "model.json",
            folder / "log.csv",
            "--input",
            PRESSURE,
            "--out",
            folder / "model.json",
        ),
    ):
        assert run(*command, "--overwrite")[0] == 2
    assert (folder / "log.csv").read_bytes() == log and (
        folder / "model.json"
    ).read_bytes() == model


@in_one(
    "arguments", [("identify",), ("compensate", "a"), ("nonsense",), ("inspect", "a", "--loud")]
)
def test_wrong_usage_exits_with_status_2_and_points_to_help(run, arguments):
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert "--help" in err


# Help, version, pipes: in a process of its own, as the shell starts it.


@in_one("command, words",
    [
        ("", ("identify", "simulate", "compensate", "inspect", "example", "--version", "dehyst inspect LOG")),
        ("identify", ("--input", "--output", "--run", "--from", "--to", "--family", "--n", "--eps", "--train-fraction",
                      "--save", "--report", "--figures", "--json", "--thresholds", "--initial-state",
                      "--time-unit", "--overwrite")),
        ("simulate", ("--input", "--out", "--from", "--to", "--run", "--time", "--time-unit", "--overwrite")),
        ("compensate", ("--output", "--out", "reference", "--time-unit", "--overwrite")),
        ("inspect", ("--run", "--json", "--time-unit")),
        ("example", ("--out", "--seed", "--overwrite")),
    ],
)  # fmt: skip
def test_help_names_every_option(run, command, words):
    status, out, err = run(*command.split(), "--help")
    assert (status, err) == (0, "")
    for word in words:
        assert word in out


def test_help_and_version_load_no_numerics():
    code = (
        "import sys\nsys.argv = ['dehyst', {!r}]\nfrom dehyst import cli\n"
        "try:\n    cli.main()\nexcept SystemExit:\n    pass\n"
        "print(sorted({{'numpy', 'scipy', 'matplotlib', 'rich', 'h5py'}} & set(sys.modules)))"
    )
    for option in ("--help", "--version"):
        done = subprocess.run(
            [sys.executable, "-c", code.format(option)], capture_output=True, text=True, check=True
        )
        assert done.stdout.splitlines()[-1] == "[]"
    assert dehyst.__version__ in done.stdout


@pytest.mark.skipif(os.name != "posix", reason="pipes of a POSIX shell")
def test_a_reader_that_leaves_early_is_told_by_the_status_alone(folder):
    arguments = [
        "simulate",
        str(folder / "model.json"),
        str(folder / "log.csv"),
        "--input",
        PRESSURE,
    ]
    process = subprocess.Popen(
        [sys.executable, "-m", "dehyst", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    process.stdout.close()
    err = process.stderr.read()
    assert process.wait(timeout=600) == 141
    assert err == ""


@pytest.mark.parametrize("command", ["play", "logs", "inspect"])
def test_playing_a_model_loads_nothing_that_identifies_one(command):
    loaded = f"import sys, dehyst.app._{command}; print('scipy' in sys.modules, 'dehyst.identification' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", loaded], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["False", "False"]
