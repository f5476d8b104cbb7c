"""The Arduino target: library and sketches run with a stand-in for Arduino.h, and compile for boards."""

import re
import shutil

import pytest

from dehyst.app._export import run_export
from dehyst.app.requests import ExportRequest
from dehyst.errors import ParameterError
from dehyst.export import export, read_manifest, subject_of
from dehyst_targets.arduino import BOARDS, SHORT, arduino_values, board_check, short_signal
from export_samples import large_model, make_check, mapped_model, needs_make

SUBJECTS = {
    "inverse": lambda: subject_of(large_model(14), name="joint_1", real="float"),
    "forward with a map": lambda: subject_of(
        mapped_model(), "forward", name="joint_1", real="float"
    ),
}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Return a function that exports a subject once."""
    made = {}

    def folder(name):
        if name not in made:
            made[name] = tmp_path_factory.mktemp("arduino") / "out"
            export(SUBJECTS[name](), "arduino", made[name])
        return made[name]

    return folder


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize("name", SUBJECTS)
def test_library_and_sketches_give_the_models_answers(folders, name, tmp_path):
    done = make_check(folders(name), tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{SHORT} samples: all checks passed" in done.stdout
    assert "duties written: all within 0 .. 255" in done.stdout
    assert not done.stderr


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize(
    ("factor", "says", "beside", "least", "most"),
    [
        ("1.0f", "all checks passed", "microseconds a step", 0.0, 10.0),
        ("1.0005f", "usable, not bit-equal, because", "microseconds a step", 10.0, 100.0),
        ("1.01f", "FAILED, do not use this build", "time of a step: not judged", 100.0, 1e6),
    ],
)
def test_the_sketch_tells_a_board_that_rounds_otherwise_from_one_that_is_wrong(
    folders, factor, says, beside, least, most, tmp_path
):
    copy = tmp_path / "copy"
    shutil.copytree(folders("inverse"), copy)
    source = copy / "src" / "pi.c"
    text = source.read_text()
    assert "z[i] = x - threshold[i];" in text
    source.write_text(
        text.replace("z[i] = x - threshold[i];", f"z[i] = x - threshold[i] * {factor};")
    )
    (copy / "Makefile").write_text(
        (copy / "Makefile").read_text().replace("\t$(abspath $(BUILD))/check\n", "")
    )
    done = make_check(copy, tmp_path / "build")
    assert (done.returncode != 0) == says.startswith("FAILED"), done.stdout
    assert says in done.stdout and beside in done.stdout
    assert (
        least
        <= float(re.search(r"largest difference (\S+) millionths of range", done.stdout)[1])
        <= most
    )


@pytest.mark.parametrize("name", SUBJECTS)
def test_the_folder_has_the_layout_of_a_library(folders, name):
    folder = folders(name)
    properties = dict(
        line.split("=", 1) for line in (folder / "library.properties").read_text().splitlines()
    )
    keys = {
        "name",
        "version",
        "author",
        "maintainer",
        "sentence",
        "paragraph",
        "category",
        "url",
        "architectures",
    }
    assert keys <= set(properties)
    assert re.fullmatch(r"\d+\.\d+\.\d+", properties["version"])
    assert (folder / "src" / properties["includes"]).is_file()
    sketches = list(folder.glob("examples/*/*.ino"))
    assert len(sketches) == 2 and all(path.stem == path.parent.name for path in sketches)
    assert "DEHYST_FLOAT" in (folder / "src" / "dehyst_config.h").read_text()
    words = re.findall(r"(?m)^(\w+)\tKEYWORD2$", (folder / "keywords.txt").read_text())
    assert words and all(
        re.search(rf"\b{word}\(", (folder / "src" / "joint_1.h").read_text()) for word in words
    )


def test_the_short_signal_is_rejected_limited_and_switched():
    signal = short_signal(SUBJECTS["inverse"]())
    assert signal.samples == SHORT
    assert {0, 1} == set(signal.switch.tolist())
    assert any(flags & 1 for flags in signal.flags) and any(flags & 4 for flags in signal.flags)


@pytest.mark.slow
@pytest.mark.parametrize("compiler", BOARDS)
def test_it_compiles_for_boards(folders, compiler):
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    for name, subject in SUBJECTS.items():
        found = board_check(folders(name), subject(), compiler)
        assert found.status == "passed", found
        assert re.search(r"\d+ bytes of flash, \d+ bytes of RAM", found.detail)


@pytest.mark.skipif(shutil.which("avr-gcc") is None, reason="no avr-gcc")
def test_a_unit_too_large_for_an_uno_is_right_for_other_boards_and_verify_says_so(tmp_path):
    subject = subject_of(large_model(200), name="joint_1", real="float")
    export(subject, "arduino", tmp_path / "out")
    found = board_check(tmp_path / "out", subject, "avr-gcc")
    assert found.status == "passed" and "does not fit" in found.detail, found
    assert int(re.search(r"(\d+) bytes of RAM", found.detail)[1]) > 2048
    assert "a Mega (8192 bytes) takes it" in (tmp_path / "out" / "README.md").read_text().replace(
        "\n", " "
    )


@pytest.mark.skipif(shutil.which("avr-gcc") is None, reason="no avr-gcc")
@pytest.mark.parametrize("n", [2, 60])
def test_what_the_readme_says_of_ram_on_avr_is_enough(tmp_path, n):
    subject = subject_of(large_model(n), name="joint_1", real="float")
    export(subject, "arduino", tmp_path / "out")
    detail = board_check(tmp_path / "out", subject, "avr-gcc").detail
    used = int(re.search(r"(\d+) bytes of RAM", detail)[1])
    said = arduino_values(subject)["avr_ram"]
    assert used <= said <= used + 60
    assert f"about {said} bytes" in (tmp_path / "out" / "README.md").read_text()


def test_it_is_float_without_being_asked_and_double_is_refused(tmp_path):
    large_model(5).save(tmp_path / "joint.json")
    run_export(ExportRequest(tmp_path / "joint.json", target="arduino", out=tmp_path / "out"))
    assert read_manifest(tmp_path / "out")["settings"]["real"] == "float"
    with pytest.raises(ParameterError, match="--real double"):
        run_export(
            ExportRequest(
                tmp_path / "joint.json", target="arduino", out=tmp_path / "other", real="double"
            )
        )
