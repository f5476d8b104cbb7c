"""Several inputs from a log: rigs of relays, refusals, and what the commands do with such a model."""

import json
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

import dehyst
from dehyst.cli import app
from dehyst.errors import ExcitationError, ParameterError
from dehyst.io import write_csv
from simulated_loops import stage_log, two_axes, wandering

NAMES = {"input": ["a", "b"], "output": ["x", "y"]}


def recording(**log):
    columns = stage_log(**log)
    return dehyst.Recording(
        input=columns["a_V"], output=columns["x_um"], time=columns["time_s"], input_name="a", output_name="x",
        input_unit="V", output_unit="um", schedules={"b": columns["b_V"], "y": columns["y_um"]},
        schedule_units={"b": "V", "y": "um"},
    )  # fmt: skip


def tracked(fit, coupling, sign=1.0):
    """Error of both axes on the rig along wanted outputs that were never logged, percent of their range."""
    u, v = 0.6 * wandering(8, 1500), 0.6 * wandering(9, 1500)
    # What the rig itself can do, slowed down: reachable, and no motion of the log.
    wanted = two_axes(u, v, coupling, sign).T * [10.0, 8.0]
    demand = (
        fit.model.rested((75.0 + 75.0 * u[0], 75.0 + 75.0 * v[0]))
        .inverse()
        .simulate(wanted, 0.01 * np.arange(1500))
    )
    got = two_axes(*((demand - 75.0) / 75.0).T, coupling, sign).T * [10.0, 8.0]
    return 100.0 * np.sqrt(np.mean((got - wanted) ** 2, axis=0)) / np.ptp(wanted, axis=0)


@pytest.mark.parametrize(
    ("coupling", "sign"),
    [
        (0.1, 1.0),
        pytest.param(0.1, -1.0, marks=pytest.mark.slow),
        pytest.param(0.9, -1.0, marks=pytest.mark.slow),
    ],
)
def test_a_stage_of_relays_is_inverted_with_a_certificate(coupling, sign):
    fit = dehyst.identify(recording(samples=6000, coupling=coupling, sign=sign), **NAMES)
    assert fit.determinant > 0.0 and "one pair of inputs" in fit.certificate
    assert fit.kkt_residual < 1e-9
    for one in fit.outputs:
        assert one.test_percent < 1.5
        assert one.test_percent < 0.6 * min(one.alone_percent, one.curve_percent)
    assert [one.own for one in fit.outputs] == ["a", "b"]
    assert np.all(tracked(fit, coupling, sign) < 1.5)


@pytest.mark.slow
def test_inputs_in_another_order_give_the_same_model():
    straight = dehyst.identify(recording(), **NAMES)
    turned = dehyst.identify(recording(), input=["b", "a"], output=["x", "y"])
    for one, other in zip(straight.outputs, turned.outputs, strict=True):
        # Rows of a log are chosen by the way of all inputs, and added in the order of the names.
        assert one.own == other.own and one.test_percent == pytest.approx(
            other.test_percent, rel=0.25
        )


@pytest.mark.slow
def test_an_output_that_falls_with_an_input_has_a_negative_effect():
    fit = dehyst.identify(recording(coupling=0.3, sign=-1.0), **NAMES)
    x, y = fit.outputs
    assert x.effects["b"] > 0.0 > y.effects["a"]


def test_one_output_of_two_inputs_errs_less_than_a_model_of_one():
    log = recording(coupling=0.5)
    fit = dehyst.identify(log, input=["a", "b"], output=["x"])
    alone = dehyst.identify(dehyst.Recording(log.input, log.output, log.time))
    assert fit.outputs[0].test_percent < 0.3 * alone.test.rmse_percent
    assert fit.determinant is None and fit.model.inverse().simulate(
        log.output, log.time, b=log.schedules["b"]
    ).shape == (3000, 2)


@pytest.mark.slow
def test_without_coupling_the_other_input_has_next_to_no_effect():
    fit = dehyst.identify(recording(coupling=0.0), **NAMES)
    x, y = fit.outputs
    assert (
        abs(x.effects["b"]) < 0.02 * x.effects["a"] and abs(y.effects["a"]) < 0.02 * y.effects["b"]
    )


@pytest.mark.slow
def test_breaks_and_several_recordings_are_pieces_of_their_own():
    log = recording()
    halves = []
    for part in (slice(0, 1500), slice(1500, 3000)):
        further = {name: values[part] for name, values in log.schedules.items()}
        halves.append(
            dehyst.Recording(
                input=log.input[part], output=log.output[part], time=log.time[part], input_name="a", output_name="x",
                schedules=further,
            )
        )  # fmt: skip
    fit = dehyst.identify(halves, **NAMES)
    assert all(one.test_percent < 3.0 for one in fit.outputs)


@pytest.mark.parametrize(
    ("names", "fault", "words"),
    [
        ({"input": ["a"], "output": ["x"]}, ParameterError, "pass two or more inputs"),
        ({"input": ["a", "b"], "output": ["x", "y", "a"]}, ParameterError, "one or two outputs"),
        (
            {"input": ["a", "c"], "output": ["x", "y"]},
            ParameterError,
            "no signal 'c'; it has a, x, b, y",
        ),
        ({"input": ["a", "b"], "output": ["x", "y"], "family": "pi"}, ParameterError, "no family"),
        (
            {"input": ["a", "b"], "output": ["x", "y"], "size": 9},
            ParameterError,
            "no family, purpose, size",
        ),
        (
            {"input": ["a", "b"], "output": ["x", "y"], "train_fraction": 0.01},
            ExcitationError,
            "30 samples are fitted",
        ),
    ],
)
def test_signals_that_do_not_fit_are_refused_with_what_to_pass(names, fault, words):
    with pytest.raises(fault, match=words):
        dehyst.identify(recording(), **names)


def test_inputs_that_move_together_and_signals_that_stand_still_are_refused():
    log = recording()
    for b, words in ((0.5 * log.input, "moves together"), (np.full(len(log), 3.0), "stays at 3")):
        same = dehyst.Recording(
            input=log.input, output=log.output, time=log.time, input_name="a", output_name="x",
            schedules={"b": b, "y": log.schedules["y"]},
        )  # fmt: skip
        with pytest.raises(ExcitationError, match=words):
            dehyst.identify(same, **NAMES)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("coupled")
    write_csv(place / "stage.csv", stage_log())
    u, v = 0.5 * wandering(8, 300), 0.5 * wandering(9, 300)
    x, y = two_axes(u, v)
    write_csv(
        place / "wanted.csv", {"time_s": 0.01 * np.arange(300), "x_um": 10.0 * x, "y_um": 8.0 * y}
    )
    return place


def run(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


OPTIONS = ("--input", "a", "--input", "b", "--output", "x", "--output", "y")


def test_from_a_log_to_inputs_that_give_the_wanted_outputs(folder):
    saved = folder / "stage.json"
    done = run(
        "coupled", folder / "stage.csv", *OPTIONS, "--save", saved, "--figure", folder / "stage.svg"
    )
    assert done.exit_code == 0, done.output
    assert "one pair of inputs for each pair of outputs" in " ".join(done.output.split())
    assert "next: dehyst compensate" in done.output and (folder / "stage.svg").is_file()
    done = run("compensate", saved, folder / "wanted.csv", "--out", folder / "demand.csv")
    assert done.exit_code == 0, done.output
    heads = (folder / "demand.csv").read_text().splitlines()[0]
    assert heads == "time [s],x [um],y [um],compensated a [V],compensated b [V]"
    table = np.genfromtxt(folder / "demand.csv", delimiter=",", skip_header=1)
    write_csv(
        folder / "inputs.csv", {"time_s": table[:, 0], "a_V": table[:, 3], "b_V": table[:, 4]}
    )
    done = run("simulate", saved, folder / "inputs.csv", "--out", folder / "outputs.csv")
    assert done.exit_code == 0, done.output
    back = np.genfromtxt(folder / "outputs.csv", delimiter=",", skip_header=1)
    assert np.max(np.abs(back[:, 3:] - table[:, 1:3])) < 1e-9


@pytest.mark.slow
def test_json_holds_the_figures(folder):
    done = run("coupled", folder / "stage.csv", *OPTIONS, "--json")
    figures = json.loads(done.stdout)
    assert figures["determinant"] > 0.0 and [one["name"] for one in figures["outputs"]] == [
        "x",
        "y",
    ]


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (("coupled", "stage.csv", "--input", "a"), "inputs named: 1, outputs named: 0"),
        (("compensate", "stage.json", "wanted.csv", "--start", "rising"), "--start"),
        (
            ("compensate", "stage.json", "wanted.csv", "--out", "stage.json"),
            "the log or the model itself",
        ),
        (("evaluate", "stage.json", "stage.csv"), "takes models of one input"),
        (
            ("sensor", "stage.csv", "--reading", "a", "--quantity", "x", "--model", "stage.json"),
            "takes models of one",
        ),
        (("export", "stage.json", "--target", "st", "--out", "st"), "written in C alone"),
        (("drift", "stage.json", "stage.csv"), "cannot be taken apart"),
    ],
)
def test_a_command_that_cannot_take_it_says_what_to_type(folder, monkeypatch, words, fault):
    monkeypatch.chdir(folder)
    if not (folder / "stage.json").is_file():
        assert run("coupled", "stage.csv", *OPTIONS, "--save", "stage.json").exit_code == 0
    done = run(*words)
    assert done.exit_code not in (0, 70) and fault in " ".join(
        (done.output + str(done.exception)).split()
    )


def test_an_option_of_one_value_that_is_typed_twice_is_refused_with_the_command_for_several(folder):
    done = subprocess.run(
        [sys.executable, "-m", "dehyst", "identify", "stage.csv", "--input", "a", "--input", "b", "--output", "x"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "--input was typed 2 times" in done.stderr and "dehyst coupled" in done.stderr


@pytest.mark.slow
def test_a_log_that_begins_elsewhere_than_at_rest_is_fitted_behind_what_is_not_known():
    log = recording(samples=6000)
    further = {name: values[400:] for name, values in log.schedules.items()}
    cut = dehyst.Recording(
        log.input[400:], log.output[400:], log.time[400:], "cut", "a", "x", schedules=further
    )
    fit = dehyst.identify(cut, **NAMES)
    assert all(one.test_percent < 2.0 for one in fit.outputs)


def test_coupling_that_the_log_does_not_show_is_said():
    log = recording(coupling=0.0)
    rng = np.random.default_rng(5)
    b = dehyst.Recording(
        log.input,
        log.output,
        log.time,
        "free",
        "a",
        "x",
        schedules={"b": rng.normal(size=len(log)), "y": log.schedules["y"]},
    )
    fit = dehyst.identify(b, input=["a", "b"], output=["x"])
    assert "coupling-not-shown" in {finding.code for finding in fit.warnings}
    assert fit.outputs[0].effects["b"] == 0.0


def test_one_output_is_compensated_while_the_other_input_is_in_the_file(folder):
    saved = folder / "one.json"
    done = run("coupled", folder / "stage.csv", *OPTIONS[:6], "--save", saved)
    assert done.exit_code == 0 and "one value of a for each x" in " ".join(done.output.split())
    columns = {name: values[:300] for name, values in stage_log().items()}
    write_csv(folder / "known.csv", {name: columns[name] for name in ("time_s", "x_um", "b_V")})
    done = run("compensate", saved, folder / "known.csv", "--out", folder / "one.csv")
    assert done.exit_code == 0, done.output
    assert (folder / "one.csv").read_text().startswith("time [s],x [um],compensated a [V]\n")
    demand = np.genfromtxt(folder / "one.csv", delimiter=",", skip_header=1)[:, 2]
    write_csv(
        folder / "both.csv", {"time_s": columns["time_s"], "a_V": demand, "b_V": columns["b_V"]}
    )
    done = run("simulate", saved, folder / "both.csv", "--out", folder / "back.csv")
    assert done.exit_code == 0, done.output
    back = np.genfromtxt(folder / "back.csv", delimiter=",", skip_header=1)[:, 3]
    assert np.max(np.abs(back - columns["x_um"])) < 1e-9
