"""`dehyst export` and `dehyst verify` as a user meets them: files, words, exit status, JSON; edits are noticed."""

import hashlib
import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

import dehyst
from dehyst.export import compilers
from dehyst.io import write_csv
from dehyst.models import ModelCard
from dehyst_robot.control import JointControllerParameters, save_controller
from export_samples import CARD, large_model, play_model

pytestmark = pytest.mark.skipif(
    shutil.which("make") is None or shutil.which("cc") is None, reason="no make or cc"
)


@pytest.fixture
def quick(monkeypatch):
    """One compiler at one level instead of all."""
    monkeypatch.setattr(compilers, "LEVELS", ("-O0",))
    monkeypatch.setattr(compilers, "COMPILERS", ("cc",))
    monkeypatch.setattr(compilers.found, "__defaults__", (("cc",),))


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a model, a log and a controller's file."""
    monkeypatch.chdir(tmp_path)
    play_model().save("rig.json")
    t = np.arange(300) / 100
    write_csv(
        "log.csv",
        {
            "time [s]": t,
            "angle [deg]": 3 * np.sin(5 * t),
            "plain": t,
            "angle [rad]": 0.05 * np.sin(t),
        },
    )
    save_controller(JointControllerParameters(), "controller.json")
    return tmp_path


@pytest.mark.slow
def test_a_model_is_exported_verified_and_signed_off(run, place):
    status, out, err = run(
        "export", "rig.json", "--target", "c", "--out", "out", "--log", "log.csv", "--column", "#2"
    )
    assert (status, err) == (0, "")
    assert "inverse compensator: angle [deg] -> pressure [bar], 4 operators" in out
    assert "bytes of constants" in out
    assert "300 samples of log.csv, angle" in out
    assert "next: dehyst verify out" in out
    status, out, err = run("verify", "out")
    assert (status, err) == (0, "")
    assert "0 failed, 0 skipped; signed off in out/VERIFIED.txt" in out.replace("\n", " ")
    signed = (place / "out" / "VERIFIED.txt").read_text()
    assert hashlib.sha256((place / "out" / "manifest.json").read_bytes()).hexdigest() in signed
    assert "-O2" in signed


def test_verify_without_a_log_says_that_it_was_not_compared_with_one(run, place, quick):
    run(
        "export",
        "rig.json",
        "--target",
        "c-header",
        "--out",
        "out",
        "--what",
        "forward",
        "--real",
        "float",
    )
    status, out, _ = run("verify", "out", "--json")
    said = json.loads(out)
    assert (status, said["verified"]) == (0, True)
    skipped = [check for check in said["checks"] if check["status"] == "skipped"]
    assert len(skipped) == 1
    assert "--log LOG --column COLUMN" in skipped[0]["detail"]


@pytest.mark.slow
def test_a_joint_controller_is_exported_and_verified(run, place, quick):
    arguments = (
        "--what",
        "joint-controller",
        "--controller",
        "controller.json",
        "--name",
        "axis_1",
    )
    status, out, _ = run(
        "export", "rig.json", "--target", "c", "--out", "out", *arguments, "--json"
    )
    said = json.loads(out)
    assert (status, said["what"], said["name"]) == (0, "joint-controller", "axis_1")
    status, out, _ = run("verify", "out")
    assert status == 0
    assert "0 failed" in out


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("src/rig.c", "edited: src/rig.c"),
        ("check/expected.h", "edited: check/expected.h"),
        ("expected/test_signal.csv", "holds other numbers"),
        ("model.json", "does not match its checksum"),
    ],
)
def test_an_edited_file_is_named_and_nothing_is_signed(run, place, quick, file, words):
    run("export", "rig.json", "--target", "c", "--out", "out")
    (place / "out" / "VERIFIED.txt").write_text("from before")
    path = place / "out" / file
    text = path.read_text()
    digit = max(
        k
        for k in range(len(text) // 2, len(text))
        if text[k] in "0123456789" and text[k - 1] in "123456789"
    )
    path.write_text(text[:digit] + ("7" if text[digit] != "7" else "3") + text[digit + 1 :])
    status, out, _ = run("verify", "out", "--json")
    assert status == 1
    assert words in " ".join(
        check["detail"] for check in json.loads(out)["checks"] if check["status"] == "failed"
    )
    assert not (place / "out" / "VERIFIED.txt").exists()


def test_a_forged_expectation_is_noticed_because_the_model_is_asked_again(run, place, quick):
    run("export", "rig.json", "--target", "c", "--out", "out")
    table = place / "out" / "expected" / "test_signal.csv"
    lines = table.read_text().splitlines()
    lines[9] = lines[9].replace(",1,", ",0,", 1)
    table.write_text("\n".join(lines) + "\n")
    manifest = json.loads((place / "out" / "manifest.json").read_text())
    manifest["files"]["expected/test_signal.csv"] = hashlib.sha256(table.read_bytes()).hexdigest()
    (place / "out" / "manifest.json").write_text(json.dumps(manifest))
    status, out, _ = run("verify", "out", "--json")
    failed = [check["claim"] for check in json.loads(out)["checks"] if check["status"] == "failed"]
    assert (status, failed[0]) == (1, "test signal: expected answers are those of the model")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--target", "cobol", "--out", "o"), "c-header"),
        (("--target", "c", "--out", "o", "--real", "half"), "double, float"),
        (("--target", "c", "--out", "o", "--what", "both"), "inverse, forward, joint-controller"),
        (("--target", "c", "--out", "o", "--column", "angle"), "--log LOG"),
        (("--target", "c", "--out", "o", "--log", "log.csv", "--column", "no"), "no signal column"),
        (("--target", "c", "--out", "o", "--what", "joint-controller"), "--controller FILE"),
        (
            ("--target", "c", "--out", "o", "--controller", "controller.json"),
            "--what joint-controller",
        ),
        (("--target", "c", "--out", "o", "--name", "int"), "--name unit_int"),
        (("--target", "c", "--out", "o", "--range", "2", "1"), "smallest first"),
        (("--target", "c", "--out", "o", "--ramp", "0"), "ramp"),
        (("--target", "c", "--out", "log.csv"), "is a file"),
        (("--target", "c", "--out", "a/b/c"), "mkdir -p"),
        (("--target", "c", "--out", "."), "--overwrite"),
    ],
)
def test_what_cannot_be_done_is_refused_with_a_cure_and_nothing_is_written(
    run, place, arguments, words
):
    before = sorted(path.name for path in place.iterdir())
    status, out, err = run("export", "rig.json", *arguments)
    assert (status, out) == (2, "")
    assert words in err
    assert sorted(path.name for path in place.iterdir()) == before


@pytest.mark.parametrize("folder", ["nowhere", "."])
def test_a_folder_that_is_no_export_is_refused(run, place, folder):
    status, _, err = run("verify", folder)
    assert status == 2
    assert "dehyst export" in err


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"format": "dehyst-export", "schema": 9}', "[" * 100000]
)
def test_a_damaged_manifest_is_refused(run, place, text):
    run("export", "rig.json", "--target", "c", "--out", "out")
    (place / "out" / "manifest.json").write_text(text)
    status, _, err = run("verify", "out")
    assert status == 2
    assert "manifest.json" in err


def warned(run, model, *arguments):
    model.save("m.json")
    status, out, _ = run(
        "export", "m.json", "--target", "c", "--out", "w", "--json", "--overwrite", *arguments
    )
    assert status == 0
    return {finding["code"]: finding["message"] for finding in json.loads(out)["warnings"]}


@pytest.mark.slow
def test_what_is_doubtful_is_said(run, place):
    bad = ModelCard(
        CARD.input,
        CARD.output,
        {"grade": "no", "verdict": "pi: 12 % rms: do not compensate with it."},
    )
    assert "Do not let it drive a machine" in warned(run, play_model(bad))["verdict"]
    idle = dehyst.PrandtlIshlinskii([0.0, 0.1, 0.2], [1.0, 0.0, 0.5], card=CARD)
    assert "--prune" in warned(run, idle)["zero-weights"]
    assert warned(run, idle, "--prune") == {}
    assert warned(run, play_model()) == {}
    far = dehyst.models.SignalCard("angle", "deg", 1000.0, 1003.0)
    assert (
        warned(run, play_model(ModelCard(CARD.input, far)), "--real", "float") == {}
    )  # what it reaches is elsewhere
    high = dehyst.PrandtlIshlinskii([0.0, 0.1], [1.0, 0.5], 1000.0, card=CARD)
    assert "--real double" in warned(run, high, "--real", "float")["coarse-float"]
    assert "1200 operators" in warned(run, large_model())["many-operators"]
    log = ("--log", "log.csv", "--column")
    assert "taken as they are" in warned(run, play_model(), *log, "plain")["unit-unknown"]
    assert "from rad to deg" in warned(run, play_model(), *log, "#4")["unit-converted"]


def test_a_pruned_export_has_fewer_operators_and_the_same_answers(run, place):
    idle = dehyst.PrandtlIshlinskii([0.0, 0.1, 0.2], [1.0, 0.0, 0.5], card=CARD)
    warned(run, idle, "--what", "forward")
    full = (place / "w" / "expected" / "test_signal.csv").read_text()
    warned(run, idle, "--what", "forward", "--prune")
    manifest = json.loads((place / "w" / "manifest.json").read_text())
    assert manifest["operators"] == 2
    assert full != ""


def test_a_period_may_be_named_for_plays_which_do_not_depend_on_it(run, place):
    warned(run, play_model())
    without = (place / "w" / "src" / "m.c").read_bytes()
    warned(run, play_model(), "--period", "0.001")
    assert (place / "w" / "src" / "m.c").read_bytes() == without


# ---- What a new user met.


def test_a_range_beyond_what_was_identified_is_a_finding(run, place):
    _, out, _ = run(
        "export", "rig.json", "--target", "c", "--out", "a", "--range", "-1.5", "2", "--json"
    )
    assert "outside-range" in [one["code"] for one in json.loads(out)["warnings"]]
    _, out, _ = run(
        "export", "rig.json", "--target", "c", "--out", "b", "--range", "-1.01", "2", "--json"
    )
    assert "outside-range" not in [one["code"] for one in json.loads(out)["warnings"]]


def test_an_excerpt_says_how_much_of_it_counts(run, place):
    write_csv(
        "small.csv", {"time [s]": np.arange(50) / 10, "angle [deg]": 0.01 * np.sin(np.arange(50))}
    )
    _, out, _ = run(
        "export",
        "rig.json",
        "--target",
        "c",
        "--out",
        "a",
        "--log",
        "small.csv",
        "--column",
        "angle",
    )
    assert "0 of them limited; they span 0.3" in out
    assert "excerpt-says-little" in out
    _, out, _ = run(
        "export", "rig.json", "--target", "c", "--out", "b", "--log", "log.csv", "--column", "#2"
    )
    assert "of them limited" in out
    assert "excerpt-says-little" not in out


def test_a_part_of_a_log_is_chosen_as_for_other_commands(run, place):
    t = np.arange(60) / 10
    write_csv(
        "runs.csv",
        {
            "run": np.repeat([1.0, 2.0], 60),
            "time_s": np.tile(t, 2),
            "angle_deg": np.tile(np.sin(t), 2),
        },
    )
    chosen = (
        "--log",
        "runs.csv",
        "--column",
        "angle_deg",
        "--run",
        "2",
        "--from",
        "1",
        "--to",
        "3",
        "--time",
        "time_s",
    )
    status, out, err = run("export", "rig.json", "--target", "c", "--out", "a", *chosen)
    assert (status, err) == (0, "")
    assert " 20 samples of runs.csv" in out
    status, _, err = run("export", "rig.json", "--target", "c", "--out", "b", "--run", "2")
    assert status == 2
    assert "choose a part of --log" in err


def test_a_joint_controller_prints_its_interface_and_takes_no_ramp(run, place):
    joint = (
        "export",
        "rig.json",
        "--target",
        "c",
        "--what",
        "joint-controller",
        "--controller",
        "controller.json",
    )
    status, out, _ = run(*joint, "--out", "a")
    assert status == 0
    assert "sensors: angle [rad], pressure_1 [Pa], pressure_2 [Pa]" in out
    assert "velocity_d [rad/s]" in out
    assert "none of your log" not in out
    status, _, err = run(*joint, "--out", "b", "--ramp", "100")
    assert status == 2
    assert "in seconds" in err


def test_a_model_without_a_range_and_a_name_that_is_taken_say_what_to_type(run, place):
    play_model(ModelCard(replace(CARD.input, low=None, high=None), CARD.output, {})).save(
        "hand.json"
    )
    status, _, err = run("export", "hand.json", "--target", "c", "--out", "a")
    assert status == 2
    assert "--range LO HI" in err
    assert run("export", "hand.json", "--target", "c", "--out", "a", "--range", "-1", "2")[0] == 0
    play_model().save("stdio.json")
    _, out, _ = run("export", "stdio.json", "--target", "c", "--out", "b")
    assert "names begin with unit_stdio_ ('stdio' is a word of C" in out
