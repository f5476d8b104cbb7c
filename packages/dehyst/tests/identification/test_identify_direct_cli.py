"""dehyst identify --family direct-inverse, compensate and simulate with its model, and its report."""

import json

import numpy as np
import pytest

import dehyst
from dehyst.errors import UnitError
from dehyst.io import write_csv
from direct_samples import TIPS, asked, motion

U, Y = "pressure_bar", "angle_deg"
STOPS = ((0.4, 0.5), (3.0, 0.3))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A log with creep and a load, and a reference."""
    place = tmp_path_factory.mktemp("direct")
    t, y = motion(TIPS, stroke=(1.0, 3.0, 5.0), hold=2.0)
    sigma = 30.0 + 20.0 * np.sin(0.17 * t)
    share = 0.5 + np.clip((sigma - 10.0) / 40.0, 0, 1)
    u = asked(t, y, np.zeros(y.size), stops=STOPS, creep=((4.0, 0.3),), share=share)
    write_csv(
        place / "log.csv",
        {"time_s": t, U: u, Y: y, "load_N": sigma, "mean_bar": 3.0 + 0.01 * sigma},
    )
    write_csv(place / "mass.csv", {"time_s": t, U: u, Y: y, "load_kg": sigma, "load_N": sigma})
    runs = {"run": np.repeat(["light", "heavy"], y.size), "time_s": np.tile(t, 2), Y: np.tile(y, 2)}
    loads = np.repeat([1.0, 2.0], y.size)
    hung = np.concatenate(
        [asked(t, y, np.zeros(y.size), stops=STOPS, share=np.full(y.size, k)) for k in (1.0, 1.5)]
    )
    write_csv(place / "runs.csv", {**runs, U: hung, "load_g": 1000 * loads})
    write_csv(
        place / "plain.csv", {"time_s": t, U: asked(t, y, np.zeros(y.size), stops=STOPS), Y: y}
    )
    t, y = motion((0.8, -0.6, 0.3))
    write_csv(
        place / "reference.csv",
        {"time_s": t, Y: y, "load_N": 20.0 + 0 * t, "pressure_bar": 0.9 * y},
    )
    return place


def identify(run, folder, *more, log="log.csv"):
    return run(
        "identify", folder / log, "--input", U, "--output", Y, "--family", "direct-inverse", *more
    )


@pytest.mark.slow
def test_the_verdict_the_comparison_and_the_evidence_are_printed(run, folder):
    status, out, err = identify(run, folder, "--creep", "3", "--schedule", "load=load_N")
    assert (status, err) == (0, "")
    flat = " ".join(out.split())
    for words in ("direct-inverse,", "modified-pi forward", "dependence on time (creep): found",
                  "schedules load", "next: repeat with --save"):  # fmt: skip
        assert words in flat, words


@pytest.mark.slow
def test_json_holds_both_errors_and_the_table(run, folder):
    status, out, err = identify(
        run, folder, "--creep-times", "4", "--schedule", "load=load_N", "--json"
    )
    assert (status, err) == (0, "")
    result = json.loads(out, parse_constant=pytest.fail)
    assert result["family"] == "direct-inverse"
    assert set(result["test"]) == {"rmse", "rmse_percent", "nrmse", "max"}
    assert result["input_error"]["test"]["rms_percent"] < 1.0
    assert result["schedules"] == ["load"]
    assert result["time_constants"] == [4.0]
    assert result["kkt_residual"] < 1e-10
    assert [row["family"] for row in result["table"] if row["chosen"]] == ["direct-inverse"]
    assert {"modified-pi", "static"} < {row["family"] for row in result["table"]}
    assert {"rate", "creep"} == {each["group"] for each in result["evidence"]}
    rec = dehyst.read_log(folder / "log.csv", U, Y, schedules={"load": "load_N"})
    fit = dehyst.identify(rec, "direct-inverse", creep_times=[4.0])
    assert result["test"]["rmse"] == pytest.approx(fit.test.rmse, rel=1e-9)


@pytest.mark.slow
def test_a_saved_compensator_follows_a_reference_and_is_read_forward(run, folder, tmp_path):
    model, out = tmp_path / "m.json", tmp_path / "u.csv"
    assert (
        identify(run, folder, "--save", model, "--schedule", "load=load_N", "--creep", "2")[0] == 0
    )
    arguments = ("compensate", model, folder / "reference.csv", "--output", Y, "--start", "model")
    status, _, err = run(*arguments, "--schedule", "load=load_N", "--out", out)
    assert status == 0, err
    loaded = dehyst.load(model)
    reference = dehyst.read_signal(folder / "reference.csv", Y)
    asked_for = dehyst.read_signal(out, f"compensated_{loaded.card.input.name}").values
    expected = loaded.run(
        reference.values, reference.time, given={"load": np.full(reference.values.size, 20.0)}
    )
    np.testing.assert_allclose(asked_for, expected.u, rtol=1e-9, atol=1e-12)
    # The reference has a column of that name, so that none needs to be typed.
    assert run(*arguments, "--out", tmp_path / "again.csv")[0] == 0
    assert (tmp_path / "again.csv").read_text() == out.read_text()
    status, text, err = run(
        "simulate", model, folder / "reference.csv", "--input", U, "--schedule", "load=load_N"
    )
    assert status == 0, err
    assert text.splitlines()[0].endswith("model_angle [deg]")


def test_a_model_without_schedule_refuses_a_column_for_one_and_needs_time_only_for_creep(
    run, folder, tmp_path
):
    model = tmp_path / "m.json"
    assert identify(run, folder, "--save", model, "--creep", "0", log="plain.csv")[0] == 0
    status, _, err = run(
        "compensate", model, folder / "reference.csv", "--output", Y, "--schedule", "load=load_N"
    )
    assert status == 2 and "does not depend on load" in err
    status, text, _ = run("compensate", model, folder / "reference.csv", "--output", Y)
    assert status == 0 and "compensated_pressure [bar]" in text.splitlines()[0]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--n", "50"), "--n"),
        (("--eps", "0.1"), "--eps"),
        (("--thresholds", "0,1"), "--thresholds"),
        (("--creep", "-2"), "creep"),
        (("--creep-times", "4,a"), "--creep-times"),
        (("--creep", "3", "--creep-times", "4,20"), "both given"),
        (("--schedule", "load=mean_bar"), "force or torque"),
        (("--schedule", "mean_pressure=load_N"), "pressure"),
        (("--schedule", "load=no_such"), "no_such"),
        (("--initial-state", "asleep"), "initial_state"),
    ],
)
def test_what_does_not_fit_is_refused_with_a_cure(run, folder, arguments, words):
    status, out, err = identify(run, folder, *arguments)
    assert (status, out) == (2, "")
    assert words in err
    assert "Traceback" not in err


@pytest.mark.slow
def test_a_load_that_is_a_mass_stays_one_and_no_force_is_taken_for_it(run, folder, tmp_path):
    model, out = tmp_path / "m.json", tmp_path / "u.csv"
    status, text, err = identify(
        run, folder, "--schedule", "load=load_kg", "--creep", "0", "--save", model, log="mass.csv"
    )
    assert status == 0, err
    assert "kg (a mass; no joint controller takes it)" in " ".join(text.split())
    (schedule,) = dehyst.load(model).outside
    assert schedule.unit == "kg"
    t, y = motion((0.8, -0.6, 0.3))
    write_csv(
        tmp_path / "r.csv",
        {"time_s": t, Y: y, "load_g": 2e4 + 0 * t, "load_kg": 20.0 + 0 * t, "load_N": 20 + 0 * t},
    )
    answers = []
    for column in ("load_kg", "load_g"):
        load = "--schedule", f"load={column}"
        status, _, err = run("compensate", model, tmp_path / "r.csv", "--output", Y, *load, "--out", out,
                             "--overwrite")  # fmt: skip
        assert status == 0, err
        answers.append(np.loadtxt(out, delimiter=",", skiprows=1, usecols=2))
    np.testing.assert_allclose(answers[0], answers[1])
    status, _, err = run(
        "compensate", model, tmp_path / "r.csv", "--output", Y, "--schedule", "load=load_N"
    )
    assert status == 2 and "a mass is not a force" in " ".join(err.split())
    force = tmp_path / "f.json"
    assert (
        identify(
            run,
            folder,
            "--schedule",
            "load=load_N",
            "--creep",
            "0",
            "--save",
            force,
            log="mass.csv",
        )[0]
        == 0
    )
    status, _, err = run(
        "compensate", force, tmp_path / "r.csv", "--output", Y, "--schedule", "load=load_kg"
    )
    assert status == 2 and "a mass is not a force" in " ".join(err.split())


@pytest.mark.slow
def test_runs_under_different_loads_are_fitted_in_one_call_and_the_refusal_of_one_says_so(
    run, folder
):
    more = ("--schedule", "load=load_g", "--creep", "0")
    status, _, err = identify(run, folder, "--run", "light", *more, log="runs.csv")
    assert status == 2 and "repeat --run" in " ".join(err.split())
    status, out, err = identify(
        run, folder, "--run", "light", "--run", "heavy", *more, log="runs.csv"
    )
    assert status == 0, err
    assert "load 1000 to 2000 g" in " ".join(out.split())
    assert "schedule-once" not in out and "schedule-no-gain" not in out


def test_other_families_refuse_its_options(run, folder):
    for option in (
        ("--creep", "3"),
        ("--creep-times", "4"),
    ):
        status, _, err = run("identify", folder / "log.csv", "--input", U, "--output", Y, *option)
        assert status == 2 and option[0] in err and "direct-inverse" in err


def test_commands_for_forward_models_name_the_way_out(run, folder, tmp_path):
    model = tmp_path / "m.json"
    identify(run, folder, "--save", model, "--creep", "0", log="plain.csv")
    status, _, err = run(
        "export", model, "--target", "c", "--what", "forward", "--out", tmp_path / "out"
    )
    assert status == 2 and "direct inverse" in err and not (tmp_path / "out").exists()


@pytest.mark.slow
def test_the_report_shows_the_loop_first_and_runs_nothing(run, folder, tmp_path):
    page, figures = tmp_path / "r.html", tmp_path / "figures"
    status, _, err = identify(
        run,
        folder,
        "--schedule",
        "load=load_N",
        "--creep",
        "3",
        "--report",
        page,
        "--figures",
        figures,
    )
    assert status == 0, err
    text = page.read_text(encoding="utf-8")
    assert text.count("<script") == 1 and "http" not in text.split("</style>")[1].replace(
        "http://www.w3.org", ""
    )
    titles = [
        "The loop",
        "Model and inverse against the data",
        "Residual",
        "What the model is made of",
    ]
    at = [text.index(f"{title}</h2>") for title in titles]
    assert at == sorted(at)
    assert {path.name.split("-", 2)[2] for path in figures.glob("*.svg")} >= {
        "loop.svg",
        "terms.svg",
    }
    assert "What a direct-inverse model says of itself" in text and "Parameters: " in text
    assert "load" in text


@pytest.mark.slow
def test_a_drift_is_not_told_from_a_mass_where_the_model_has_a_force(run, folder, tmp_path):
    model = tmp_path / "m.json"
    assert (
        identify(
            run,
            folder,
            "--schedule",
            "load=load_N",
            "--creep",
            "0",
            "--save",
            model,
            log="mass.csv",
        )[0]
        == 0
    )
    status, _, err = run("drift", model, folder / "mass.csv", "--schedule", "load=load_kg")
    assert status == 2 and "a mass is not a force" in " ".join(err.split())


def test_a_joint_controller_refuses_a_load_that_is_a_mass():
    from dehyst.models import DirectInverse, ModelCard, Schedule, SignalCard
    from dehyst_robot.control._joint import in_si

    card = ModelCard(SignalCard("torque", "Nm"), SignalCard("angle", "deg"))
    for unit in ("kg", "g"):
        by_mass = DirectInverse(
            polynomial=np.zeros((2, 1)), schedules=(Schedule("load", 0.0, 1.0, unit),), card=card
        )
        with pytest.raises(UnitError, match=f"is in {unit}, which is no torque"):
            in_si(by_mass)


def test_the_line_that_a_design_prints_says_what_to_do_with_a_log_that_begins_earlier(
    run, tmp_path
):
    status, out, err = run("design", "--range", "-30", "30", "--unit", "deg", "--rate", "40", "--time-limit", "360",
                           "--out", tmp_path / "e.csv")  # fmt: skip
    assert status == 0, err
    assert "if it begins at s seconds, add s to both" in " ".join(out.split())
