"""dehyst reproduce on the command line: one short run with all it writes, and everything that is refused."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import dehyst
import dehyst_robot.commands._reproduce as command
from dehyst import cli
from dehyst.app import PAGE
from dehyst.errors import OutputError
from dehyst_robot.arm import load_robot
from dehyst_robot.commands._reproduce import QUICK
from dehyst_robot.experiments import (
    PlantResult,
    Reproduction,
    Request,
    evaluate_point,
    reproduce,
)
from dehyst_robot.experiments.kit import RECIPES
from dehyst_robot.report import WHY
from places import ROOT

SHORTEST = {
    **QUICK,
    "calibration.sweep_s": 5.0,
    "calibration.degree": 3,
    "identification.loop_s": 6.0,
    "homing.cycles": 2,
    "homing.period_s": 2.0,
    "path.cycles_fast": 1,
    "path.slow_factor": 1.2,
    "path.cube_m": 0.1,
    "path.rest_s": 0.1,
}
TRIALS = ("fast", "slow", "slow_no_integrator")


def dehyst_reproduce(monkeypatch, capsys, *words):
    """Run the command in this process: exit status, stdout, stderr."""
    monkeypatch.setattr(sys, "argv", ["dehyst", "reproduce", *map(str, words)])
    capsys.readouterr()
    try:
        cli.main()
        status = 0
    except SystemExit as end:
        status = end.code or 0
    out, err = capsys.readouterr()
    assert "Traceback" not in out + err
    return status, out, err


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A run of the whole arm without hysteresis, and of joint 1 alone with LuGre's: folder, stdout, stderr."""
    folder = tmp_path_factory.mktemp("reproduce")
    words = [
        "--quick",
        "--plant",
        "none",
        "--alone",
        "lugre",
        "--joint",
        "1",
        "--out",
        folder / "out",
        "--json",
        folder / "x.json",
    ]
    with pytest.MonkeyPatch.context() as patch, pytest.MonkeyPatch.context() as streams:
        patch.setattr(command, "QUICK", SHORTEST)
        out, err = (open(folder / name, "w+") for name in ("stdout", "stderr"))  # noqa: SIM115, PTH123
        streams.setattr(sys, "stdout", out)
        streams.setattr(sys, "stderr", err)
        patch.setattr(sys, "argv", ["dehyst", "reproduce", *map(str, words)])
        try:
            cli.main()
        except SystemExit as end:
            assert not end.code
    for stream in (out, err):
        stream.close()
    return folder, (folder / "stdout").read_text(), (folder / "stderr").read_text()


@pytest.fixture(scope="module")
def figures(finished):
    text = (finished[0] / "x.json").read_text()
    assert (finished[0] / "out" / "figures.json").read_text() == text
    return json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))


@pytest.mark.slow
def test_the_json_has_the_promised_shape(figures):
    plant = figures["plants"]["none"]
    assert set(figures) >= {"plants", "real_time_factor", "settings"} and list(
        figures["plants"]
    ) == ["none"]
    assert list(plant["joints"]) == ["1"]
    joint = plant["joints"]["1"]
    assert isinstance(joint["identification"]["nonzero_weights"], int)
    assert isinstance(joint["identification"]["inverse_rms_ratio_unseen"], float)
    assert set(joint["trials"]) == set(plant["tool"]) == set(TRIALS)
    for name in TRIALS:
        assert set(joint["trials"][name]) == set(plant["tool"][name]) == {"off", "paper"}
        for run in joint["trials"][name].values():
            assert set(run) == {"rms_deg", "max_deg"} and 0 < run["rms_deg"] <= run["max_deg"] < 20
        for tool in plant["tool"][name].values():
            assert {
                "AT_mm",
                "RT_mm",
                "CR_mm",
                "CO_mm",
                "AV_percent",
                "RV_percent",
                "FV_mm_s",
            } <= set(tool)
            assert (
                tool["cycles"] == 1
                and tool["RT_mm"] is None
                and "cycles" in tool["reasons"]["RT_mm"]
            )
            assert 0 < tool["AT_mm"] < 50
    assert figures["real_time_factor"] > 1


@pytest.mark.slow
def test_the_settings_tell_everything_that_was_set(figures):
    settings = figures["settings"]
    assert settings["plants"] == ["none"] and settings["joints"] == [1] and settings["seeds"] == [0]
    assert (
        settings["changes"]["path.cube_m"] == 0.1
        and settings["parameters"]["path"]["cube_m"] == 0.1
    )
    assert "assumption" in settings["sources"]["joint.1.radius_m"]
    assert {"dehyst", "mujoco", "mink", "numpy"} <= set(settings["versions"])
    line = "dehyst reproduce --quick --plant none --alone lugre --joint 1"
    assert settings["command"].startswith(line) and settings["alone"] == ["lugre"]


@pytest.mark.slow
def test_a_joint_alone_is_that_of_a_sweep(tmp_path):
    short = {**SHORTEST, "calibration.sweep_s": 14.0, "identification.loop_s": 8.0}
    short |= {"homing.cycles": 4, "path.cube_m": 0.3}
    names = ("paper", "best")
    request = Request(("none",), (1,), names, (0,), ("fast",), studies=False, alone=("lugre",))
    result = reproduce(load_robot(changes=short), request, tmp_path)
    runs = result.alone["lugre"].figures[0]["joints"]["1"]["trials"]["fast"]
    point = evaluate_point(
        {**short, "hysteresis.mechanism": "lugre"}, trials=("fast",), compensators=("off", *names)
    )
    assert runs["best"]["rms_deg"] < 0.5 * runs["off"]["rms_deg"]
    for name, run in runs.items():
        for key, value in run.items():
            assert value == pytest.approx(point[f"fast/{name}/{key}"], rel=1e-9)
    # Nothing of it is among the plants of the whole arm.
    assert list(result.plants) == ["none"]


@pytest.mark.slow
def test_a_joint_alone_is_shown_without_tool_and_without_logs_of_its_trials(finished, figures):
    alone = figures["alone"]["lugre"]
    assert list(alone["joints"]) == ["1"] and alone["tool"] == {}
    assert set(alone["joints"]["1"]["trials"]) == set(TRIALS)
    logs = finished[0] / "out" / "logs" / "alone" / "lugre" / "seed0"
    names = {"identification_joint1", "unseen_joint1"}
    assert {file.stem for file in logs.glob("*.csv")} == names
    assert "joint 1 alone, the others locked" in finished[1]
    page = (finished[0] / "out" / "report.html").read_text(encoding="utf-8")
    assert "Joint 1 alone on other plants" in page and "the laws of lugre among its terms" in page
    assert "logs/alone/lugre/seed0/identification_joint1.csv" in page


@pytest.mark.slow
def test_the_figures_are_those_of_the_logs(finished, figures):
    log = finished[0] / "out" / "logs" / "none" / "seed0" / "slow_off.csv"
    table = np.genfromtxt(log, delimiter=",", names=True)
    error = table["joint1_desired_deg"] - table["joint1_angle_deg"]
    told = figures["plants"]["none"]["joints"]["1"]["trials"]["slow"]["off"]
    assert told["rms_deg"] == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-6)
    assert told["max_deg"] == pytest.approx(np.abs(error).max(), rel=1e-6)


@pytest.mark.slow
def test_quick_without_hysteresis_says_that_nothing_was_switched_on(finished, figures):
    assert re.search(r"none: the model of joint 1 was not switched\s+on", finished[1])
    joint = figures["plants"]["none"]["joints"]["1"]
    assert joint["identification"]["accepted"] is False
    for trial in joint["trials"].values():
        assert trial["off"] == trial["paper"]


def test_the_table_stands_in_80_columns_with_every_word_whole(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "80")
    one = {"off": {"rms_deg": 10.0, "max_deg": 20.0}, "literal": {"rms_deg": 12.5, "max_deg": 10.0}}
    joints = {"4": {"trials": dict.fromkeys(TRIALS, one)}}
    plant = PlantResult("maxwell-slip", {}, (), {0: {"joints": joints}}, 30.0)
    command._print(Reproduction({"maxwell-slip": plant}, "literal", {}))
    out = capsys.readouterr().out
    assert "…" not in out and max(map(len, out.splitlines())) <= 80
    row = next(line.split() for line in out.splitlines() if "slow_no_integrator" in line)
    assert row == ["maxwell-slip", "4", "slow_no_integrator", "10.000", "12.500", "1.25", "0.50"]


@pytest.mark.slow
def test_stages_are_told_one_a_line_where_there_is_no_terminal(finished):
    lines = finished[2].splitlines()
    stages = [
        "path and its timing (1)",
        "calibration sweeps (5)",
        "identification (1)",
        "trials (6)",
        "calibration sweeps, joint 1 alone (1)",
        "identification, joint 1 alone (1)",
        "trials, joint 1 alone (6)",
        "report (1)",
    ]
    assert lines[:8] == stages and "report.html" in lines[-1]


@pytest.mark.slow
def test_every_run_has_a_log_that_dehyst_reads_back(finished):
    folder = finished[0] / "out" / "logs" / "none" / "seed0"
    runs = {f"{trial}_{name}" for trial in TRIALS for name in ("off", "paper")}
    assert {f.stem for f in folder.glob("*.csv")} == runs | {
        "identification_joint1",
        "unseen_joint1",
    }
    log = dehyst.read_log(
        folder / "fast_off.csv", input="joint1_desired_deg", output="joint1_angle_deg"
    )
    assert log.input.size > 500 and log.time[1] - log.time[0] == pytest.approx(0.01)
    tool = dehyst.read_log(folder / "fast_off.csv", input="tool_desired_y_m", output="tool_y_m")
    assert np.abs(tool.input - tool.output).max() < 0.05


@pytest.mark.slow
def test_the_mcap_of_a_run_can_be_inspected_and_holds_the_same(finished, monkeypatch, capsys):
    pytest.importorskip("rosbags")
    folder = finished[0] / "out" / "logs" / "none" / "seed0"
    monkeypatch.setattr(sys, "argv", ["dehyst", "inspect", str(folder / "fast_off.mcap")])
    with pytest.raises(SystemExit) as end:
        cli.main()
    out = capsys.readouterr().out
    assert not end.value.code and "joint1" in out and "angle_deg" in out
    csv = np.genfromtxt(folder / "fast_off.csv", delimiter=",", names=True)
    name = re.search(r"\S*joint1\S*angle_deg", out)[0]
    wanted = re.sub("angle_deg$", "desired_deg", name)
    mcap = dehyst.read_log(folder / "fast_off.mcap", input=wanted, output=name)
    np.testing.assert_array_equal(mcap.output, csv["joint1_angle_deg"])


@pytest.mark.slow
def test_the_report_lies_beside_its_logs_and_names_them(finished):
    page = (finished[0] / "out" / "report.html").read_text(encoding="utf-8")
    assert PAGE in page and "logs/none/seed0/fast_off.csv" in page
    assert str(finished[0]) not in page  # no path of this machine


@pytest.mark.slow
def test_a_second_run_may_replace_what_the_first_one_wrote(finished, monkeypatch, capsys):
    def stop(*_):
        raise OutputError("as far as the run")

    monkeypatch.setattr(command, "reproduce", stop)
    words = ("--out", finished[0] / "out", "--json", finished[0] / "x.json")
    assert dehyst_reproduce(monkeypatch, capsys, *words)[2] == "OutputError: as far as the run\n"


@pytest.fixture
def refused(tmp_path, monkeypatch, capsys):
    """Run in a folder with files of one's own: must end with status 2 before anything runs, and lose nothing."""
    monkeypatch.chdir(tmp_path)
    mine = {
        "afile": "a", "my.json": "{}", "broken.toml": "x", "one.toml": '[joint.1]\nradius_m = 0.06\n',
        "odd.toml": 'extends = "default"\n[joint.1]\nradus_m = 0.06\n', "mine/report.html": "notes",
        "kept/figures.json": '{"my": 1}', "under/logs": "wood",
    }  # fmt: skip
    for name, text in mine.items():
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_text(text)

    def run(*words):
        status, out, err = dehyst_reproduce(monkeypatch, capsys, *words)
        assert status == 2 and not out
        assert "calibration sweeps" not in err
        for name, text in mine.items():
            assert Path(name).read_text() == text
        assert {p.name for p in Path().iterdir()} <= {Path(n).parts[0] for n in mine} | {
            "reproduction"
        }
        assert not list(Path().glob("reproduction/**/*.*"))
        return err

    return run


@pytest.mark.parametrize(
    ("words", "cure"),
    [
        ("--plant rust", "maxwell-slip, preisach, dahl, braid, lugre, pinched, ageing, none"),
        ("--plant preisach,", "maxwell-slip, preisach, dahl, braid, lugre, pinched, ageing, none"),
        ("--alone rust", "maxwell-slip, preisach, dahl, braid, lugre, pinched, ageing, none"),
        ("--joint 3", "1, 2, 4"),
        ("--joint one", "a number or all"),
        ("--compensator nothing", "paper, literal, printed, scaled"),
        ("--as-printed --compensator paper", "Leave --compensator out"),
        ("--as-printed --joint 1,2", "Leave --joint out; or leave --as-printed out"),
        ("--as-printed --joint all", "Leave --joint out"),
        ("--as-printed --controller pid", "Leave --controller out"),
        ("--seed -1", "whole numbers from 0"),
        ("--seed 99999999999999999999", "whole numbers from 0"),
        ("--seed x", "integer"),
        ("--cycles 0", "from 1 to 1000"),
        ("--cycles 1.5", "integer"),
        ("--robot missing.toml", "does not exist"),
        ("--robot broken.toml", "is not TOML"),
        ("--robot one.toml", 'extends = "default"'),
        ("--robot odd.toml", "joint.1.radius_m"),
        ("--robot .", "'.' is a folder"),
        ("--out afile", "'afile' is a file. Name another folder"),
        ("--out afile/deeper", "'afile' is a file. Name another folder"),
        ("--out under", "under/logs' is a file"),
        ("--out mine", "mine/report.html' exists already and is no report of dehyst"),
        ("--out kept", "kept/figures.json' exists already and is no result of dehyst reproduce"),
        ("--json my.json", "my.json' exists already and is no result of dehyst reproduce"),
        ("--json mine", "'mine': it is a folder"),
        ("--json nowhere/x.json", "there is no folder"),
        ("--figures afile", "'afile' is a file"),
    ],
    ids=str,
)
def test_what_cannot_be_is_refused_at_once_with_its_cure(refused, words, cure):
    message = " ".join(refused("--quick", *words.split()).split())
    assert cure in re.sub(r"[│\s]+", " ", message)


@pytest.mark.parametrize("package", ["mujoco", "mink", "daqp"])
def test_without_the_packages_of_the_plant_the_extra_is_named(
    package, monkeypatch, capsys, tmp_path
):
    monkeypatch.setitem(sys.modules, package, None)  # as if it were not installed
    status, _, err = dehyst_reproduce(monkeypatch, capsys, "--quick", "--out", tmp_path / "out")
    assert status == 2 and package in err and "pip install dehyst-robot" in err
    assert not list(tmp_path.iterdir())


def test_quick_changes_nothing_of_the_plant():
    quick, full = (
        load_robot(conditions="kind", changes=QUICK).values,
        load_robot(conditions="kind").values,
    )
    changed = {name for name in full if quick[name] != full[name]}
    assert changed == {"calibration", "identification", "homing", "path"}
    same = ("fast_speed_m_s", "acceleration_m_s2", "jerk_m_s3", "cube_m", "rounding_m")
    assert all(quick["path"][key] == full["path"][key] for key in same)


def test_the_conditions_of_the_packaged_arm_are_chosen_by_name(tmp_path):
    from dehyst_robot.commands import ReproduceRequest

    robot = command._robot(ReproduceRequest(quick=True, conditions="realistic", out=tmp_path))
    assert robot == load_robot(conditions="realistic").with_changes(QUICK)
    assert (
        command._robot(ReproduceRequest(quick=True, out=tmp_path)) == robot
    )  # where nothing is said
    line = command._line(ReproduceRequest(quick=True, conditions="kind", out=tmp_path))
    assert "--conditions kind" in line


def test_as_printed_is_the_printed_model_in_joint_1_at_3_bar(tmp_path):
    from dehyst_robot.commands import ReproduceRequest

    request = ReproduceRequest(quick=True, as_printed=True, out=tmp_path)
    asked = command._experiment(request)
    assert asked.joints == (1,) and asked.compensators == ("printed",)
    assert asked.controllers == ("paper",)
    assert not asked.studies
    robot = command._robot(request)
    assert robot.controller.mean_pressure == 3e5
    # The local calibration needs a sweep there without load, which --quick alone leaves out.
    assert 3.0 in robot.values["calibration"]["mean_pressures_bar"]
    assert 0.0 in robot.values["calibration"]["loads_bar"]
    assert "dehyst reproduce --quick --as-printed" in command._line(request)
    changes = RECIPES["printed"].changes
    assert changes["compensator.shear_bar_rad"] == 1.0
    assert changes["compensator.operators"] == 100 and changes["compensator.eps"] == 0.001


def test_what_as_printed_sets_anyway_may_be_typed(tmp_path):
    from dehyst_robot.commands import ReproduceRequest

    command._refuse_contradictions(
        ReproduceRequest(as_printed=True, joint="1", compensator=("printed",), out=tmp_path)
    )


@pytest.mark.slow
def test_as_printed_compensates_joint_1_alone_and_draws_figures_7_and_8(
    tmp_path, monkeypatch, capsys
):
    # Sweeps and loops as quick as in SHORTEST are no hysteresis alone, and the model is not accepted.
    slower = {"calibration.sweep_s": 10.0, "identification.loop_s": 12.0}
    monkeypatch.setattr(command, "QUICK", {**SHORTEST, **slower})
    words = ["--quick", "--as-printed", "--out", tmp_path / "out", "--figures", tmp_path / "drawn"]
    status, out, _ = dehyst_reproduce(monkeypatch, capsys, *words)
    assert status == 0 and "'printed'" in out
    drawn = {path.name for path in (tmp_path / "drawn").iterdir()}
    assert {"preisach-figure-7-trials.svg", "preisach-figure-8-tool.svg"} <= drawn
    log = tmp_path / "out" / "logs" / "preisach" / "seed0" / "fast_printed.csv"
    table = np.genfromtxt(log, delimiter=",", names=True)
    for joint in (1, 2, 4):
        assert np.ptp(table[f"joint{joint}_angle_deg"]) > 1.0
        assert table[f"joint{joint}_torque_error_Nm"].any()
        assert table[f"joint{joint}_compensation_bar"].any() == (joint == 1)


def test_an_error_that_grows_with_a_compensator_is_said_with_joint_trial_ratio_and_where_to_read_why(
    capsys,
):
    sizes = ((1.0, 2.0), (1.26, 1.9), (0.4, 4.5), (1.01, 2.02))
    off, paper, best, alike = ({"rms_deg": rms, "max_deg": most} for rms, most in sizes)
    trials = {
        "fast": {"off": off, "paper": alike, "best": alike},
        "slow": {"off": off, "paper": paper, "best": best},
    }
    plant = PlantResult("dahl", {}, (), {0: {"joints": {"4": {"trials": trials}}, "tool": {}}}, 1.0)
    settings = {"joints": [4], "trials": ["fast", "slow"]}
    command._print_grown(
        Reproduction({"dahl": plant}, "best", settings, compensators=("paper", "best"))
    )
    said = " ".join(capsys.readouterr().err.split())
    assert (
        "The rms error of a joint grows with the compensator “paper” in 1 case: dahl, joint 4, slow (126 %)"
        in said
    )
    assert (
        "largest error of a joint grows with the compensator “best” in 1 case: dahl, joint 4, slow (225 %)"
        in said
    )
    assert said.count("warning: ") == 2 and f"Why: {WHY}." in said
    page, _, anchor = WHY.partition("#")
    titles = re.findall(r"^## (.*)$", (ROOT / page).read_text(encoding="utf-8"), re.M)
    assert anchor in [title.lower().replace(" ", "-") for title in titles]
    trials["slow"] = trials["fast"]
    command._print_grown(
        Reproduction({"dahl": plant}, "best", settings, compensators=("paper", "best"))
    )
    assert not capsys.readouterr().err
    # A joint that moved alone is warned of as well, under a name of its own.
    slow = {"off": off, "paper": paper, "best": best}
    figures = {0: {"joints": {"4": {"trials": {"slow": slow}}}}}
    alone = {"dahl": PlantResult("dahl", {}, (), figures, 1.0)}
    command._print_grown(
        Reproduction({"dahl": plant}, "best", settings, compensators=("paper", "best"), alone=alone)
    )
    said = " ".join(capsys.readouterr().err.split())
    assert "dahl alone, joint 4, slow (126 %)" in said and "dahl, joint" not in said


@pytest.mark.slow
def test_robot_conditions_and_poles_stand_below_the_table(finished):
    said = " ".join(finished[1].split())
    assert (
        "on the seven-joint arm with pneumatic muscles, realistic plant, pole 6 1/s (joint 6: 25"
        in said
    )


@pytest.mark.slow
def test_a_lost_trial_takes_no_other_with_it_and_is_named_with_its_cause(
    tmp_path, monkeypatch, capsys
):
    from dehyst.errors import SimulationError
    from dehyst_robot.experiments import _reproduce as experiment

    def one_is_lost(robot, path, kit, trial, name, **more):
        if (trial, name) == ("fast", "off"):
            raise SimulationError("joint 1 went to 93 deg, its range ends at 40 deg")
        return learned(robot, path, kit, trial, name, **more)

    learned = experiment.learned_trial
    monkeypatch.setattr(experiment, "learned_trial", one_is_lost)
    monkeypatch.setattr(command, "QUICK", {**SHORTEST, "homing.range_share": 0.3})
    rig = ROOT / "examples" / "rigs" / "one_joint.toml"
    words = ["--quick", "--robot", rig, "--plant", "dahl", "--out", tmp_path / "out"]
    status, out, err = dehyst_reproduce(monkeypatch, capsys, *words)
    assert status == 0 and "lost" in next(line for line in out.splitlines() if "fast" in line)
    assert "dahl, seed 0, fast, off: lost, joint 1 went to 93 deg" in " ".join(err.split())
    assert "one_joint.toml" in out and "Warning:" not in err
    plant = json.loads((tmp_path / "out" / "figures.json").read_text())["plants"]["dahl"]
    assert set(plant["joints"]["1"]["trials"]["fast"]) == {"paper"} and len(plant["remarks"]) >= 1
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "1 trial ended early and has no figures" in page and "its range ends at 40 deg" in page
