"""`dehyst drift` as a user meets it: exit status by the verdict, files that are not overwritten, JSON, the page."""

import json
import re
import shlex
import sys

import numpy as np
import pytest

import dehyst
from dehyst.io import write_csv
from places import DATA, ROOT
from report_samples import read

sys.path.insert(0, str(ROOT / "benchmarks"))

from drift_rig import cycling_log, logged

PURE = {"creep": 0.0}


def counted(entry):
    """Parts that count as changed; the error, which is their sum, left out."""
    return {change["part"] for change in entry["changes"] if change["drifted"]} - {"error"}


def write(path, record, **names):
    x, y = names.get("x", "pressure_bar"), names.get("y", "angle_deg")
    write_csv(path, {"time_s": record.time, x: record.input, y: record.output})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Logs of an actuator when it was new, later, and worn; other columns; another motion; a model of the first."""
    place = tmp_path_factory.mktemp("drift")
    write(place / "new.csv", cycling_log(1, 24, PURE, minor=True))
    write(place / "later.csv", cycling_log(2, 24, PURE, minor=True))
    write(place / "worn.csv", cycling_log(3, 24, {**PURE, "hysteresis": 0.8}, minor=True))
    write(place / "other.csv", cycling_log(4, 24, PURE), x="voltage_V")
    write(place / "small.csv", cycling_log(5, 24, PURE, amplitude=0.8))
    dehyst.identify(dehyst.read_log(place / "new.csv", "pressure", "angle"), "pi", n=30).model.save(
        place / "model.json"
    )
    return place


def test_an_unchanged_actuator_ends_with_status_0_and_says_what_would_have_been_found(run, folder):
    status, out, err = run("drift", folder / "model.json", folder / "new.csv", folder / "later.csv")
    assert (status, err) == (0, "")
    flat = " ".join(out.split())
    assert "unchanged since it was identified (against new.csv)" in flat
    assert re.search(
        r"A change of offset by \S+ deg, gain by \S+ %, hysteresis size by \S+ %", flat
    )
    assert "new.csv: reference" in flat


def test_a_worn_actuator_ends_with_status_1_and_the_next_line_to_type(run, folder):
    status, out, _ = run(
        "drift",
        folder / "model.json",
        folder / "new.csv",
        folder / "later.csv",
        folder / "worn.csv",
    )
    flat = " ".join(out.split())
    assert status == 1
    assert (
        flat.startswith("drifted")
        and "first seen in worn.csv" in flat
        and "--refit new.json" in flat
    )


@pytest.mark.slow
def test_each_part_is_one_line_of_a_narrow_terminal_without_powers_of_ten(run, folder):
    """Names and intervals were broken over two lines, and a change of the error was "+1.49e+03 %"."""
    out = run("drift", folder / "model.json", folder / "new.csv", folder / "worn.csv")[1]
    rows = out[out.index("95 % interval") :].split("\n\n")[0].splitlines()[1:]
    assert len(rows) >= 7 and all(
        re.match(r"[* ] \w[\w ]+ [+-]\S+ (%|deg)", row) for row in rows
    ), rows
    assert not re.search(r"\de\+0\d", out)


@pytest.mark.slow
def test_cannot_tell_ends_with_status_4_and_the_motion_that_it_asks_for_tells(run, folder):
    """Closed loop: what is printed is typed, the rig moved so, and the log is accepted."""
    status, out, _ = run(
        "drift", folder / "model.json", folder / "later.csv", "--refit", folder / "not.json"
    )
    flat = " ".join(out.split())
    assert status == 4 and flat.startswith("cannot tell (against the model)")
    assert "accepted" not in flat and not (folder / "not.json").exists()
    line = shlex.split(re.search(r"next: (dehyst design .*) --out drift.csv", out).group(1))
    status, out, _ = run(*line[1:], "--out", folder / "drift.csv")
    assert (
        status == 0
        and re.search(r"36 complete cycles", out)
        and "dehyst drift MODEL.json LATER.csv" in out
    )
    t, x = np.loadtxt(folder / "drift.csv", delimiter=",", skiprows=1, usecols=(0, 1)).T
    for seed, (name, wear) in enumerate(
        {"first": {}, "second": {}, "third": {"gain": 1.05}}.items()
    ):
        write(folder / f"{name}.csv", logged(np.random.default_rng(seed), x, t, {**PURE, **wear}))
    for name, wanted in (("second", 0), ("third", 1)):
        reference = ("--reference", folder / "first.csv", "--json")
        status, out, _ = run("drift", folder / "model.json", folder / f"{name}.csv", *reference)
        result = json.loads(out)
        assert status == wanted and result["logs"][0]["tested"] == 36


def test_the_reference_may_be_named(run, folder):
    status, out, _ = run(
        "drift",
        folder / "model.json",
        folder / "later.csv",
        "--reference",
        folder / "new.csv",
        "--json",
    )
    assert status == 0 and json.loads(out)["reference"] == "new.csv"


def test_another_motion_ends_with_status_3(run, folder):
    status, out, _ = run("drift", folder / "model.json", folder / "small.csv")
    assert status == 3
    assert "not comparable" in out and "80 %" in out


def test_a_log_of_other_columns_is_an_error_alone_and_one_line_among_others(run, folder):
    status, _, err = run("drift", folder / "model.json", folder / "other.csv")
    assert status == 2 and err.startswith("ColumnError")
    reference = ("--reference", folder / "new.csv", "--json")
    status, out, _ = run(
        "drift", folder / "model.json", folder / "other.csv", folder / "later.csv", *reference
    )
    logs = {log["log"]: log["status"] for log in json.loads(out)["logs"]}
    assert status == 0 and logs == {"later.csv": "unchanged", "other.csv": "not comparable"}


def test_json_is_only_json_and_its_keys_are_documented(run, folder):
    arguments = (folder / "worn.csv", "--json", "--refit", folder / "json.json")
    status, out, err = run("drift", folder / "model.json", *arguments)
    assert (status, err) == (1, "")
    result = json.loads(out, parse_constant=pytest.fail)

    def keys(value):
        if isinstance(value, dict):
            return set(value).union(*map(keys, value.values()))
        return set().union(*map(keys, value)) if isinstance(value, list) else set()

    page = (ROOT / "docs" / "reference" / "json.md").read_text(encoding="utf-8")
    assert not keys(result) - set(re.findall(r"`([\w-]+)`", page))
    assert result["refit"]["accepted"] is True
    assert (
        dehyst.load(folder / "json.json").card.provenance["replaces"]["reason"]
        == result["refit"]["reason"]
    )


def test_after_a_new_model_its_verdict_and_the_next_command_are_printed(run, folder):
    status, out, _ = run(
        "drift", folder / "model.json", folder / "worn.csv", "--refit", folder / "next.json"
    )
    flat = " ".join(out.split())
    verdict = dehyst.load(folder / "next.json").card.provenance["verdict"]
    assert status == 1 and f"verdict on the new model: {verdict}" in flat
    assert "next: dehyst compensate" in flat and "next.json REFERENCE.csv --output angle" in flat


def test_a_model_that_is_no_better_is_not_written(run, folder):
    target = folder / "no_better.json"
    status, out, _ = run(
        "drift", folder / "model.json", folder / "new.csv", folder / "later.csv", "--refit", target
    )
    assert status == 0 and not target.exists()
    assert "the old model stays" in " ".join(out.split()) and "nothing was written" in " ".join(
        out.split()
    )


@pytest.mark.parametrize("name", ["model.json", "worn.csv", "taken.json"])
def test_nothing_that_exists_is_overwritten(run, folder, name):
    model = (folder / "model.json").read_bytes()
    (folder / "taken.json").write_bytes(model)  # a model of dehyst, in use on a machine perhaps
    before = (folder / name).read_bytes()
    status, _, err = run(
        "drift", folder / "model.json", folder / "worn.csv", "--refit", folder / name
    )
    assert status == 2 and err.startswith("OutputError")
    assert (folder / name).read_bytes() == before
    if name != "taken.json":
        assert (
            run(
                "drift",
                folder / "model.json",
                folder / "worn.csv",
                "--refit",
                folder / name,
                "--overwrite",
            )[0]
            == 2
        )
        assert (folder / name).read_bytes() == before


@pytest.mark.slow
def test_the_page_begins_with_the_error_over_the_cycles_and_runs_nothing(run, folder):
    page = folder / "drift.html"
    status, _, _ = run(
        "drift", folder / "model.json", folder / "new.csv", folder / "worn.csv", "--report", page
    )
    text = page.read_text(encoding="utf-8")
    assert status == 1
    assert read(page).ids("section")[:3] == ["error", "parts", "loop"]
    assert "default-src 'none'" in text
    assert text.count("<script") == 1
    assert not re.search(r"https?://", re.sub(r'xmlns[^"=]*="[^"]*"', "", text))
    assert "hysteresis size" in text


def test_names_of_logs_are_text_on_the_page(run, folder):
    hostile = folder / "<b>log.csv"
    hostile.write_bytes((folder / "worn.csv").read_bytes())
    run("drift", folder / "model.json", hostile, "--report", folder / "hostile.html")
    text = (folder / "hostile.html").read_text(encoding="utf-8")
    assert "<b>" not in text and "&lt;b&gt;log.csv" in text


@pytest.mark.slow
def test_a_direct_inverse_is_compared_in_units_of_the_input(run, folder):
    log = dehyst.read_log(folder / "new.csv", "pressure", "angle")
    dehyst.identify(log, "direct-inverse", creep=0).model.save(folder / "direct.json")
    status, out, _ = run(
        "drift", folder / "direct.json", folder / "new.csv", folder / "worn.csv", "--json"
    )
    told = json.loads(out)["logs"][1]
    change = {c["part"]: c for c in told["changes"]}
    assert status == 1
    assert (
        told["forward_percent"] > 0.0 and "inverse_percent" not in told
    )  # the words of the verdict
    assert len(told["blocks"]["forward_percent"]) == len(told["blocks"]["error_percent"])
    assert change["offset"]["unit"] == "bar"
    assert change["hysteresis"]["drifted"] and -30.0 < change["hysteresis"]["estimate"] < -15.0


@pytest.mark.slow
@pytest.mark.skipif(
    not (DATA / "piezo_dbo" / "data.csv.gz").is_file(), reason="no measured logs beside the project"
)
def test_a_measured_piezo_drifts_in_its_offset_alone_within_one_log(run, tmp_path):
    log = DATA / "piezo_dbo" / "data.csv.gz"
    columns = ("--run", "model", "--from", "2")
    names = ("--input", "voltage_v", "--output", "displacement_um")
    assert run("identify", log, *names, *columns, "--save", tmp_path / "model.json")[0] == 0
    status, out, _ = run("drift", tmp_path / "model.json", log, *columns, "--json")
    result = json.loads(out)
    assert status == 1 and result["logs"][0]["cycles"] > 30
    assert counted(result["logs"][0]) == {"offset"}


@pytest.mark.slow
@pytest.mark.skipif(
    not (DATA / "piezo_dbo" / "data.csv.gz").is_file(), reason="no measured logs beside the project"
)
def test_a_measured_arm_is_the_same_in_three_runs_but_for_zero_and_gain(run, tmp_path):
    log = DATA / "pneumatic_arm_segment" / "data.csv.gz"
    names = ("--input", "pressure_interp_psi", "--output", "tilt_rad", "--from", "12")
    assert (
        run("identify", log, *names, "--run", "oct28_exp1", "--save", tmp_path / "model.json")[0]
        == 0
    )
    runs = [word for name in ("oct28_exp1", "oct28_exp5", "oct28_exp9") for word in ("--run", name)]
    status, out, _ = run("drift", tmp_path / "model.json", log, "--from", "12", *runs, "--json")
    result = json.loads(out)
    assert status == 1 and result["reference"].endswith("oct28_exp1")
    for entry in result["logs"][1:]:
        assert counted(entry) <= {"offset", "gain"}
