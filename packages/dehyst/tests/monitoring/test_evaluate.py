"""dehyst evaluate: saved models of any family on a log that they were not identified from."""

import dataclasses
import io
import itertools
import json
import re
from itertools import pairwise

import numpy as np
import pytest

import dehyst
from dehyst.errors import ParameterError
from dehyst.families import example
from dehyst.models import DirectInverse, ModelCard, SignalCard
from dehyst.models._start import begun

CARD = ModelCard(SignalCard("pressure", "bar", -2.0, 2.0), SignalCard("angle", "deg", -3.0, 3.0))
PLAYS = dehyst.PrandtlIshlinskii([0.0, 0.3, 0.8], [1.0, 0.4, 0.3], card=CARD)
X = 2.0 * np.sin(np.linspace(0.0, 60.0, 3000)) * np.linspace(1.0, 0.6, 3000)
T = 0.01 * np.arange(X.size)


def log(x=X, y=None, **more):
    y = PLAYS.simulate(x) if y is None else y
    given = {
        "time": T[: x.size],
        "input_name": "pressure",
        "input_unit": "bar",
        "output_name": "angle",
    }
    return dehyst.Recording(input=x, output=y, **{**given, "output_unit": "deg", **more})


def test_errors_are_those_of_numpy_from_where_both_ends_were_visited():
    y = PLAYS.simulate(X) + 0.2 + 0.05 * np.sin(7.0 * T)
    entry = dehyst.evaluate(PLAYS, log(y=y))["pi"]
    begin = max(
        np.argmax(X.min() + 0.02 * np.ptp(X) >= X), np.argmax(X.max() - 0.02 * np.ptp(X) <= X)
    )
    error = (PLAYS.simulate(X) - y)[begin:]
    assert entry.output.rmse == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)
    assert entry.output_bias == pytest.approx(error.mean(), rel=1e-12)
    assert entry.error_percent == pytest.approx(100.0 * error.std() / np.ptp(y), rel=1e-9)
    asked = np.clip(PLAYS.inverse().simulate(y), -2.0, 2.0)[begin:] - X[begin:]
    assert entry.input.rms_percent == pytest.approx(
        100.0 * np.sqrt(np.mean(asked**2)) / np.ptp(X), rel=1e-9
    )
    assert entry.input.bias_percent == pytest.approx(100.0 * asked.mean() / np.ptp(X), rel=1e-9)


def test_the_mechanism_itself_is_the_one_to_run_whatever_bias_the_log_has():
    line = dehyst.PrandtlIshlinskii([0.0], [1.4], card=CARD)
    found = dehyst.evaluate({"line": line, "plays": PLAYS}, log(y=PLAYS.simulate(X) + 1.0))
    assert found.run == "plays" and [entry.name for entry in found.entries] == ["plays", "line"]
    assert found["plays"].error_percent < 1e-9 < found["line"].error_percent
    assert found["plays"].bias_percent == pytest.approx(
        -100.0 / np.ptp(found.recordings[0].output), rel=1e-9
    )


def test_runs_that_are_offset_against_each_other_are_scored_without_the_offset_of_each():
    y = PLAYS.simulate(X)
    found = dehyst.evaluate(PLAYS, [log(y=y + 0.5), log(y=y - 0.3)])
    assert found["pi"].error_percent < 1e-9 < 1.0 < found["pi"].output.rmse_percent
    assert "offset" not in codes(found)  # 0.1 deg of more than 5
    assert "offset" in codes(dehyst.evaluate(PLAYS, log(y=y + 1.0)))


@pytest.mark.parametrize("name", ["dahl", "preisach", "creep-pi", "elements"])
def test_a_family_scores_nothing_on_its_own_answer(name):
    model = example(name)
    x = np.sin(np.linspace(0.0, 40.0, 400))
    t = 0.05 * np.arange(400)
    y = model.simulate(x, t)
    entry = dehyst.evaluate(model, dehyst.Recording(input=x, output=y, time=t))[name]
    assert entry.error_percent < 1e-9
    assert entry.input is None or entry.input_percent < 1e-6


def test_a_direct_inverse_is_scored_in_both_directions():
    model = DirectInverse(radii=[0.5], stop_weights=[1.0], polynomial=[0.0, 1.0], card=CARD)
    y = 2.5 * np.sin(np.linspace(0.0, 60.0, 3000))
    u = model.run(y, T).u
    entry = dehyst.evaluate(model, log(u, y))["direct-inverse"]
    assert (
        entry.error_percent < 1e-6 and entry.input.rms_percent < 15.0
    )  # clipped to the card's 2 bar of 3 bar
    assert (
        entry.clipped == pytest.approx(np.mean(np.abs(u) > 2.0), abs=1e-12) and entry.clipped > 0.1
    )


def test_demands_beyond_the_range_of_the_actuator_are_clipped_before_they_are_scored():
    y = 100.0 * PLAYS.simulate(X)
    entry = dehyst.evaluate(PLAYS, log(y=y))["pi"]
    demand = PLAYS.inverse().simulate(y)
    assert np.abs(demand - X).max() > 100.0 and entry.clipped == np.mean(np.abs(demand) > 2.0) > 0.9
    assert entry.input.rms_percent < 100.0


def test_what_cannot_be_scored_says_why_and_the_others_are():
    timed = example("creep-pi")
    untimed = dehyst.evaluate({"plays": PLAYS, "timed": timed}, log(time=None))
    assert "no time stamps" in untimed["timed"].reason and untimed.run == "plays"
    swapped = dehyst.evaluate(PLAYS, log(PLAYS.simulate(X), X, input_unit="deg", output_unit="bar"))
    assert swapped.run is None and "swapped" in swapped["pi"].reason
    scheduled = DirectInverse(
        polynomial=[[0.0, 1.0], [0.0, 2.0]],
        schedules=(dehyst.models.Schedule("load", 0.0, 1.0, "N"),),
        card=CARD,
    )
    assert "--schedule load=" in dehyst.evaluate(scheduled, log())["direct-inverse"].reason
    loaded = dataclasses.replace(
        log(), schedules={"load": np.zeros(X.size)}, schedule_units={"load": "N"}
    )
    assert dehyst.evaluate(scheduled, loaded)["direct-inverse"].output is not None


def codes(found):
    return {finding.code for entry in found.entries for finding in entry.findings} | {
        f.code for f in found.findings
    }


def test_warnings_name_what_limits_the_errors():
    assert codes(dehyst.evaluate(PLAYS, log())) == set()
    assert "outside-range" in codes(dehyst.evaluate(PLAYS, log(1.5 * X)))
    assert "unit-converted" in codes(
        dehyst.evaluate(PLAYS, log(1e5 * X, PLAYS.simulate(X), input_unit="Pa"))
    )
    assert "unit-unknown" in codes(dehyst.evaluate(PLAYS, log(input_unit="")))
    short = np.linspace(-2.0, 2.0, 200)
    assert "log-too-short" in codes(dehyst.evaluate(PLAYS, log(short)))
    late = np.concatenate([0.2 * X, np.linspace(X[-1] * 0.2, 2.0, 50), np.linspace(2.0, -2.0, 50)])[
        :3000
    ]
    assert "start-counts" not in codes(dehyst.evaluate(PLAYS, log()))
    assert "start-counts" in codes(
        dehyst.evaluate(PLAYS, log(np.concatenate([late, [2.0, -2.0]]), time=None))
    )
    noise = np.random.default_rng(0).normal(size=X.size)
    other = dehyst.evaluate(PLAYS, log(y=noise))
    assert "unexplained" in codes(other) and other.run is None


def test_what_is_no_model_is_refused():
    for wrong in ("model.json", [], {}, [PLAYS, 3.0]):
        with pytest.raises(ParameterError, match=r"dehyst\.load"):
            dehyst.evaluate(wrong, log())


@pytest.fixture
def files(tmp_path):
    table = np.column_stack([T, X, PLAYS.simulate(X)])
    path = tmp_path / "use.csv"
    np.savetxt(path, table, delimiter=",", header="time_s,pressure_bar,angle_deg", comments="")
    line = dehyst.PrandtlIshlinskii([0.0], [1.4], card=CARD)
    return PLAYS.save(tmp_path / "plays.json"), line.save(tmp_path / "line.json"), path


def test_scores_with_a_following_offset_say_so(run, files):
    said = "outputs are scored with an offset that follows the last cycle, within 10 % of range"
    assert said in " ".join(run("evaluate", *files, "--follow-offset", "0.1")[1].split())
    assert "offset that follows" not in run("evaluate", *files)[1]


def test_the_command_prints_a_table_and_the_line_to_type_next(run, files):
    status, out, err = run("evaluate", *files)
    assert status == 0, err
    assert out.startswith(f"run {files[0]}") and f"dehyst compensate {files[0]}" in out.replace(
        "\n", ""
    )


def test_what_several_models_share_is_said_once_under_their_names(run, files, tmp_path):
    doubt = dataclasses.replace(
        CARD, provenance={"grade": "care", "verdict": "two loops: usable with care."}
    )
    weights = ([0.9, 0.4, 0.3], [1.0, 0.5, 0.3])
    doubted = [
        dehyst.PrandtlIshlinskii([0.0, 0.3, 0.8], w, card=doubt).save(tmp_path / f"doubt{k}.json")
        for k, w in enumerate(weights)
    ]
    said = run("evaluate", *doubted, files[0], files[2])[1].replace("\n", "")
    assert said.count("warning verdict") == said.count("Watch the actuator") == 1
    assert re.search(
        rf"({doubted[0]}, {doubted[1]}|{doubted[1]}, {doubted[0]}) *warning verdict", said
    )


def test_json_holds_both_errors_with_their_bias(run, files):
    status, out, _ = run("evaluate", *files, "--json")
    found = json.loads(out)
    assert status == 0 and found["run"] == str(files[0]) and found["samples"] == X.size
    assert [entry["name"] for entry in found["models"]] == [str(files[0]), str(files[1])]
    assert set(found["models"][1]["input_error"]) == {
        "rms_percent",
        "bias_percent",
        "without_bias_percent",
    }
    assert (
        found["models"][1]["output_error"]["rmse_percent"]
        > 1.0
        > found["models"][0]["output_error"]["rmse_percent"]
    )


def test_the_loop_of_the_log_is_beside_that_of_each_model(run, files):
    out = run("evaluate", *files)[1]
    # Names of files are long here, and the table folds its columns to the width of the terminal.
    assert re.search(r"loop +width", out) and "largest loops of the log" in out
    # A play of half width r and weight w opens a loop by 2 r w: the mechanism is measured again, a line has no loop.
    numbers = json.loads(run("evaluate", *files, "--json")[1])
    measured = numbers["numbers"]["estimates"]["width"]["value"]
    assert measured == pytest.approx(2.0 * (0.3 * 0.4 + 0.8 * 0.3), rel=0.02)
    modelled = [entry["numbers"]["estimates"]["width"]["value"] for entry in numbers["models"]]
    assert modelled == pytest.approx([measured, 0.0], abs=1e-3)


def test_loops_of_a_model_are_in_the_units_of_the_log():
    radians = log(y=np.deg2rad(PLAYS.simulate(X)), output_unit="rad")
    evaluation = dehyst.evaluate({"plays": PLAYS}, radians)
    measured, modelled = evaluation.loops, evaluation["plays"].loops
    assert modelled.units == measured.units
    width = measured.estimates["width"].value
    assert modelled.estimates["width"].value == pytest.approx(width, rel=1e-6)


def test_a_log_that_no_model_explains_is_a_no_and_wrong_columns_are_refused(run, files, tmp_path):
    other = tmp_path / "other.csv"
    rows = np.column_stack([T, X, np.random.default_rng(0).normal(size=X.size)])
    np.savetxt(other, rows, delimiter=",", header="time_s,pressure_bar,angle_deg", comments="")
    status, out, _ = run("evaluate", files[0], other)
    assert status == 1 and "dehyst identify" in out
    np.savetxt(other, rows, delimiter=",", header="time_s,a,b", comments="")
    status, _, err = run("evaluate", files[0], other)
    assert status == 2 and "--input COLUMN --output COLUMN" in err
    assert run("evaluate", files[0], other, "--input", "a", "--output", "b")[0] == 1
    assert run("evaluate", files[0], files[0], files[2])[0] == 2


def test_a_model_scored_on_the_log_that_it_was_fitted_to_is_no_test_and_that_is_said(tmp_path):
    place = tmp_path / "log.csv"
    rows = np.column_stack([T, X, PLAYS.simulate(X)])
    np.savetxt(place, rows, delimiter=",", header="time_s,pressure_bar,angle_deg", comments="")
    record = dehyst.read_log(place, "pressure_bar", "angle_deg")
    model = dehyst.identify(record, "pi", n=10).model
    [told] = [
        each for each in dehyst.evaluate(model, record)["pi"].findings if each.code == "fitted-log"
    ]
    assert "fitted to 50 % of these samples of log.csv" in told.message
    second = dehyst.read_log(
        place, "pressure_bar", "angle_deg", start=15.5
    )  # all of it was held out
    assert "fitted-log" not in codes(dehyst.evaluate(model, second))


def test_samples_after_a_sensor_was_set_anew_are_not_called_outside_the_range():
    """They were left out of the scores, and the warning said that the model was scored on them."""
    y = PLAYS.simulate(X)
    found = dehyst.evaluate(PLAYS, log(y=np.where(np.arange(X.size) < 2000, y, y + 6.0)))
    assert "two-actuators" in codes(found) and "outside-range" not in codes(found)


WORK = ModelCard(SignalCard("drive", "V", 0.0, 100.0), SignalCard("stroke", "um", 0.0, 60.0))
STROKES = {
    "rising": [0.0, 100.0, 0.0],
    "falling": [0.0, 100.0],
    "decayed": [0.0, 100.0, 0.0, 90.0, 10.0, 80.0, 20.0, 70.0, 25.0, 40.0],
}


def walked(points, step=1.0):
    legs = [np.arange(1, 1 + max(1, round(abs(b - a) / step))) for a, b in pairwise(points)]
    ways = [
        a + (b - a) * leg / leg.size for (a, b), leg in zip(pairwise(points), legs, strict=True)
    ]
    return np.concatenate([[points[0]], *ways])


def of_known_past(seed, past, low=None):
    """An actuator of plays that had another past, its exact model, and a log of a part of its range."""
    rng = np.random.default_rng(seed)
    model = dehyst.PrandtlIshlinskii(
        np.array([0.0, 4.0, 10.0, 18.0, 28.0, 40.0]),
        np.append(0.3, rng.uniform(0.03, 0.1, 5)),
        card=WORK,
    )
    low = rng.uniform(20.0, 40.0) if low is None else low
    high = low + rng.uniform(15.0, 30.0)
    x = walked([low, high, low, 0.5 * (low + high), low, high, low, high])
    lived = walked([*STROKES[past], low])
    y = model.simulate(np.concatenate([lived, x]))[lived.size :]
    names = {"input_name": "drive", "input_unit": "V", "output_name": "stroke", "output_unit": "um"}
    return model, dehyst.Recording(input=x, output=y, **names)


@pytest.mark.spread(7)
@pytest.mark.parametrize("past", STROKES)
@pytest.mark.parametrize("seed", range(8))
def test_an_unknown_past_is_not_blamed_on_the_sensor(past, seed):
    model, record = of_known_past(seed, past)
    for start in ("model", "rest", "rising", "falling"):
        found = dehyst.evaluate(model, record, start=start)
        assert found["pi"].error_percent < 1e-4 and "offset" not in codes(found)
        assert ("unknown-past" in codes(found)) is (abs(found["pi"].bias_percent) > 1.0)
    if past != "decayed":
        assert abs(dehyst.evaluate(model, record, start=past)["pi"].bias_percent) < 1e-6


@pytest.mark.spread(3)
@pytest.mark.parametrize("seed", range(8))
def test_a_shifted_zero_is_said_where_no_past_can_explain_it(seed):
    model, record = of_known_past(seed, "rising")
    shifted = dataclasses.replace(record, output=record.output + 60.0)
    [told] = [
        each for each in dehyst.evaluate(model, shifted)["pi"].findings if each.code == "offset"
    ]
    assert "no past of the actuator explains that" in told.message
    whole = walked([0.0, 100.0, 0.0, 60.0, 30.0, 100.0, 0.0, 100.0])
    known = dataclasses.replace(record, input=whole, output=model.simulate(whole) + 5.0)
    assert {"offset"} == codes(dehyst.evaluate(model, known)) - {"outside-range"}
    steeper = dataclasses.replace(record, input=whole, output=1.3 * model.simulate(whole))
    told = [
        each.message
        for each in dehyst.evaluate(model, steeper)["pi"].findings
        if each.code == "offset"
    ]
    assert told and "zero" not in told[0] and "no mere constant" in told[0]


@pytest.mark.parametrize(
    "name", ["play-sum", "elements", "preisach", "generalised-pi", "mixed-sum"]
)
def test_of_no_family_a_past_is_blamed_on_the_sensor(name):
    model = example(name)
    low, high = model.ends
    x = np.interp(
        np.linspace(0.0, 7.0, 700),
        range(8),
        0.5 * (low + high) + 0.2 * (high - low) * np.array([0.0, 1, -1, 1, 0, 1, -1, 0]),
    )
    time = 0.05 * np.arange(x.size)
    for truth, start in itertools.permutations(("rest", "rising", "falling"), 2):
        y = begun(model, truth, x[0]).simulate(x, time)
        found = dehyst.evaluate(model, dehyst.Recording(input=x, output=y, time=time), start=start)
        assert not {"offset", "unexplained"} & codes(found), (truth, start)
        same = dehyst.evaluate(model, dehyst.Recording(input=x, output=y, time=time), start=truth)
        assert codes(same) <= {"start-counts"} and same[model.family].error_percent < 1e-9


def test_the_command_takes_the_start_and_says_it(run, tmp_path):
    model, record = of_known_past(3, "falling")
    path = model.save(tmp_path / "a-model-with-a-long-name.json")
    rows = np.column_stack([record.input, record.output])
    np.savetxt(tmp_path / "use.csv", rows, delimiter=",", header="drive_V,stroke_um", comments="")
    plain = run("evaluate", path, tmp_path / "use.csv")[1]
    assert (
        "start: model, " in plain
        and "warning unknown-past" in plain
        and "--start falling" in " ".join(plain.split())
    )
    told = run("evaluate", path, tmp_path / "use.csv", "--start", "falling")[1]
    assert "start: falling, " in told and "unknown-past" not in told
    assert run("evaluate", path, tmp_path / "use.csv", "--start", "unknown")[0] == 0
    assert run("evaluate", path, tmp_path / "use.csv", "--start", "zero")[0] == 2


@pytest.mark.parametrize("start", ["zero", "rest", "rising", "falling"])
def test_the_log_of_a_fit_is_scored_as_the_fit_scored_it(start):
    """Also behind a gap, before which a piece of the log says nothing of the memory."""
    x = np.concatenate([X, 0.5 * X[:400], X])
    time = np.concatenate([T, T[-1] + 50.0 + T[:400], T[-1] + 150.0 + T])
    lived = PLAYS.with_state(
        PLAYS.final_state({"rising": [2, -2.0], "falling": [-2.0, 2.0]}.get(start, [0.0]))
    )
    y = np.concatenate([lived.simulate(x[: X.size]), PLAYS.simulate([2.0, *x[X.size :]])[1:]])
    record = dehyst.Recording(input=x, output=y, time=time, breaks=(X.size, X.size + 400))
    fit = dehyst.identify(record, "pi", initial_state=start, train_fraction=1.0)
    entry = dehyst.evaluate(fit.model, record)["pi"]
    assert entry.output.rmse_percent < 2.0 * fit.train.rmse_percent + 0.05


def test_no_number_of_the_table_is_cut_for_a_long_family():
    from rich.console import Console

    from dehyst.app import table
    from dehyst.app._evaluate import _heads

    row = ("wire_design.json", "inverse-stop-rate", "9.75", "-3.6", "14.4", "-1.2", "0.125")
    console = Console(width=80, record=True, file=io.StringIO())
    console.print(table(_heads(len(row[0])), [row]))
    shown = console.export_text()
    assert all(number in shown for number in row[2:]) and row[0] in shown and "clipped %" in shown


def test_the_first_tenth_of_a_log_tells_its_past():
    """A log that begins after a large stroke, of which it shows nothing, and never leaves the middle of the range."""
    past, small = np.linspace(-2.0, 2.0, 50), 0.4 * np.sin(np.linspace(0.0, 12.0, 600))
    come = np.concatenate([past, np.linspace(2.0, 0.0, 30)[1:]])
    whole = PLAYS.simulate(np.concatenate([come, small]))
    later = log(small, whole[come.size :], time=None)
    as_saved = dehyst.evaluate(PLAYS, later)["pi"]
    known = dehyst.evaluate(PLAYS, later, start="known")["pi"]
    assert known.output.rmse_percent < 0.01 and known.input.rms_percent < 0.01
    assert as_saved.output.rmse_percent > 1.0
    assert "unknown-past" in {finding.code for finding in as_saved.findings}
    with pytest.raises(ParameterError, match="known"):
        dehyst.evaluate(PLAYS, later, start="guessed")
