"""`dehyst verify` signs off nothing that was manipulated, nothing that did not run; `--overwrite` loses nothing."""

import hashlib
import io
import json
import shutil
import zipfile

import numpy as np
import pytest

from dehyst.errors import OutputError
from dehyst.export import _verification as verification
from dehyst.export import compilers, export, subject_of
from dehyst.models import ModelCard
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.export import joint_subject
from export_samples import CARD, mapped_model, play_model
from fmu_tools import quickly

pytestmark = pytest.mark.skipif(
    shutil.which("make") is None or shutil.which("cc") is None, reason="no make or cc"
)
WAVE = 3 * np.sin(np.arange(200) / 20)


@pytest.fixture(autouse=True, scope="module")
def quick():
    with quickly():
        yield


@pytest.fixture(scope="module")
def exports(tmp_path_factory):
    """An export of a target, made once."""
    made = {}

    def of(target):
        if target not in made:
            unit = subject_of(
                play_model(), name="unit_1", excerpt=WAVE, excerpt_source="log.csv, angle"
            )
            made[target] = export(unit, target, tmp_path_factory.mktemp(target) / "out").folder
        return made[target]

    return of


def renew(place):
    """Renew all checksums, as somebody would who wants a manipulated folder to pass."""
    path = place / "manifest.json"
    manifest = json.loads(path.read_text())
    manifest["files"] = {
        name: hashlib.sha256((place / name).read_bytes()).hexdigest() for name in manifest["files"]
    }
    path.write_text(json.dumps(manifest))


def forge(place, **facts):
    path = place / "manifest.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | facts))


def edit(place, name, old, new):
    text = (place / name).read_text()
    assert old in text
    (place / name).write_text(text.replace(old, new, 1))
    renew(place)


def members(place, change):
    """Rewrite the FMU of a folder with changed members."""
    path = place / "unit_1.fmu"
    with zipfile.ZipFile(path) as packed:
        files = {name: packed.read(name) for name in packed.namelist()}
    change(files)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as packed:
        for name, data in files.items():
            packed.writestr(name, data)
    path.write_bytes(out.getvalue())
    renew(place)


def add(place, name, text):
    (place / name).parent.mkdir(exist_ok=True)
    (place / name).write_text(text)


def early(place):
    edit(place, "src/block.c", "return", "return 1 +")
    edit(place, "check/check.c", "int main(void)\n{", "int main(void)\n{\n    return 0;")


ATTACKS = {
    "a makefile that make prefers": (
        "c",
        lambda f: add(f, "GNUmakefile", "check:\n\t@true\n"),
        "GNUmakefile",
    ),
    "a header that ends the program": (
        "c",
        lambda f: add(
            f, "check/stdio.h", "__attribute__((constructor)) static void e(void) { _Exit(0); }"
        ),
        "check/stdio.h",
    ),
    "a compiler of one's own": (
        "rust",
        lambda f: add(f, ".cargo/config.toml", ""),
        ".cargo/config.toml",
    ),
    "a header beside the one header": ("c-header", lambda f: add(f, "stdint.h", ""), "stdint.h"),
    "a wrong block and a check that returns early": ("c", early, "src/block.c"),
    "a block that goes wrong later": (
        "c",
        lambda f: edit(f, "src/block.c", "#include", "/**/\n#include"),
        "src/block.c",
    ),
    "no files in the manifest": ("c", lambda f: forge(f, files={}), "lists none"),
    "a file left out of the manifest": (
        "c",
        lambda f: leave_out(f, "src/pi.c"),
        "missing: src/pi.c",
    ),
    "a forged checksum of the model": (
        "c",
        lambda f: forge(f, model_sha256="0" * 64),
        "model_sha256",
    ),
    "a forged title": ("c", lambda f: forge(f, title="certified"), "title"),
    "a forged provenance": (
        "c",
        lambda f: forge(f, provenance={"verdict": "good for compensation"} | {"x": 1}),
        "prov",
    ),
    "forged limits": (
        "c",
        lambda f: forge(f, output={"name": "pressure", "unit": "bar", "low": -9, "high": 9}),
        "output",
    ),
    "a forged source of the excerpt": ("c", lambda f: forge(f, excerpt_source="x"), "README.md"),
    "a version that is text": ("c", lambda f: forge(f, dehyst="1\nall checks passed"), "dehyst"),
    "a date that is text": ("c", lambda f: forge(f, date="today\nVerified"), "date"),
    "another version, and facts of the model": (
        "c",
        lambda f: forge(f, dehyst="9.9", operators=3),
        "dehyst 9.9, this",
    ),
    "another README": (
        "c",
        lambda f: (add(f, "README.md", "-ffast-math is fine"), renew(f)),
        "README.md",
    ),
    "another README of an FMU": (
        "fmu2",
        lambda f: edit(f, "README.md", "`pip", "- `binaries/x`: `pip"),
        "README.md",
    ),
    "another description in an FMU": (
        "fmu2",
        lambda f: members(
            f, lambda m: m.update({"modelDescription.xml": m["modelDescription.xml"] + b"<!-- -->"})
        ),
        "unit_1.fmu",
    ),
    "other sources in an FMU": (
        "fmu3",
        lambda f: members(f, lambda m: m.update({"sources/core/block.c": b"int x;"})),
        "unit_1.fmu",
    ),
    "one more file in an FMU": (
        "fmu3",
        lambda f: members(f, lambda m: m.update({"resources/x": b""})),
        "unit_1.fmu",
    ),
    "no FMU at all": ("fmu2", lambda f: (add(f, "unit_1.fmu", "PK"), renew(f)), "unit_1.fmu"),
    "another S-function": (
        "simulink",
        lambda f: edit(f, "sfun_unit_1.c", "#define", "/**/\n#define"),
        "sfun_unit_1.c",
    ),
    "another text for the PLC": (
        "st",
        lambda f: edit(f, next(f.glob("*.scl")).name, ";", "; ;"),
        ".scl",
    ),
}


def leave_out(place, missing):
    (place / missing).unlink()
    files = json.loads((place / "manifest.json").read_text())["files"]
    forge(place, files={name: checksum for name, checksum in files.items() if name != missing})


@pytest.mark.slow
@pytest.mark.parametrize("attack", ATTACKS)
def test_a_manipulated_folder_is_not_signed_off_and_nothing_of_it_runs(
    exports, tmp_path, monkeypatch, attack
):
    target, change, word = ATTACKS[attack]
    place = shutil.copytree(exports(target), tmp_path / "out")
    change(place)
    monkeypatch.setattr(compilers, "_check_with", None)  # would be a fault
    found = verification.verify_folder(place)
    assert not found.good
    assert any(word in check.detail for check in found.checks if check.status == "failed"), (
        found.checks
    )
    assert not any(check.ran for check in found.checks)


@pytest.mark.slow
@pytest.mark.parametrize("target", ["c", "c-header", "fmu2", "fmu3", "simulink", "st"])
def test_an_export_is_the_same_when_exported_again_and_signed_off(exports, target):
    found = verification.verify_folder(exports(target))
    assert found.good, found.checks
    detail = {check.claim: check.detail for check in found.checks}
    assert "are the same" in detail["files are those that dehyst exports from this model"]
    assert (
        "log.csv, angle"
        in detail["excerpt in this folder: expected answers are those of the model"]
    )


@pytest.mark.slow
@pytest.mark.parametrize("target", ["c", "simulink"])
def test_a_joint_controller_and_a_library_are_the_same_when_exported_again(tmp_path, target):
    unit = joint_subject(mapped_model(), JointControllerParameters(), name="axis_1")
    assert verification.verify_folder(export(unit, target, tmp_path / "joint").folder).good
    if target == "simulink":
        unit = subject_of(mapped_model(), name="axis_1", real="float", range=(-0.5, 1.5), ramp=7)
        assert verification.verify_folder(export(unit, "arduino", tmp_path / "library").folder).good


@pytest.mark.parametrize("name", ["GNUMAKEFLAGS", "MAKEFLAGS"])
def test_what_the_environment_says_to_make_does_not_count(exports, monkeypatch, name):
    monkeypatch.setenv(name, "-n")
    found = verification.verify_folder(exports("c"))
    assert found.good
    assert next(check.detail for check in found.checks if check.ran).startswith("8 claims")


def test_a_header_path_of_the_environment_does_not_count(exports, monkeypatch, tmp_path):
    (tmp_path / "stdio.h").write_text("#error other header\n")
    for name in ("CPATH", "C_INCLUDE_PATH"):
        monkeypatch.setenv(name, str(tmp_path))
    assert verification.verify_folder(exports("c")).good


@pytest.mark.parametrize(
    "program", ["", 'puts("all checks passed");', 'puts("x ok"); puts("all checks passed");']
)
def test_a_check_that_says_less_than_it_should_has_failed(exports, tmp_path, program):
    place = shutil.copytree(exports("c"), tmp_path / "out")
    edit(
        place, "check/check.c", "int main(void)\n{", f"int main(void)\n{{\n    {program} return 0;"
    )
    [check] = compilers.check_folder(place)
    assert check.status == "failed"
    assert "due are 8 and 1" in check.detail


@pytest.mark.slow
def test_the_first_failure_is_told_and_not_what_follows_from_it(exports, tmp_path):
    place = shutil.copytree(exports("c"), tmp_path / "out")
    edit(place, "src/pi.c", "pi->offset + ", "pi->offset + 0.125 + ")
    [check] = compilers.check_folder(place)
    assert check.status == "failed"
    assert check.detail.count("FAILED") == 1
    assert check.detail.count("expected") == 1
    assert "test signal" in check.detail


def test_faults_are_printed_once_and_first(run, exports, tmp_path):
    place = shutil.copytree(exports("c"), tmp_path / "out")
    (place / "src" / "extra.h").write_text("")
    status, out, _ = run("verify", place)
    assert status == 1
    assert out.startswith("failed no file was added to the sources\n  added: src/extra.h")
    assert out.count("src/extra.h") == 1


@pytest.mark.slow
def test_notes_and_build_results_are_tolerated(exports, tmp_path):
    place = shutil.copytree(exports("c"), tmp_path / "out")
    (place / "notes.txt").write_text("mine")
    (place / "build").mkdir()
    (place / "build" / "check").write_text("")
    found = verification.verify_folder(place)
    assert found.good
    assert any("notes.txt" in check.detail for check in found.checks)


def test_a_manifest_that_leads_out_of_the_folder_is_refused(exports, tmp_path):
    place = shutil.copytree(exports("c"), tmp_path / "out")
    forge(place, files={"../secret": "0"})
    with pytest.raises(OutputError, match="outside"):
        verification.verify_folder(place)


@pytest.mark.slow
def test_nothing_is_signed_off_without_a_compiler(run, exports, tmp_path, monkeypatch):
    place = shutil.copytree(exports("c"), tmp_path / "out")
    monkeypatch.setattr(compilers, "found", dict)
    status, out, _ = run("verify", place)
    assert status == 1
    assert "not verified: nothing was compiled; install gcc or clang" in out
    assert not (place / "VERIFIED.txt").exists()
    place = shutil.copytree(exports("st"), tmp_path / "st")
    assert run("verify", place)[0] == 0


@pytest.mark.parametrize(
    ("grade", "verdict"),
    [
        ("no", "pi: 12 % rms: do not compensate with it."),
        ("care", "pi: 4 % rms: usable with care."),
    ],
)
def test_the_verdict_on_a_model_travels(run, tmp_path, grade, verdict):
    card = ModelCard(CARD.input, CARD.output, {"grade": grade, "verdict": verdict})
    unit = subject_of(play_model(card), name="unit_1")
    place = export(unit, "c-header", tmp_path / "out").folder
    assert verdict in (place / "README.md").read_text()
    status, out, _ = run("verify", place)
    words = f"the code is the model's; the model's verdict was: {verdict}"
    assert status == 0
    assert out.rstrip().endswith(words)
    assert (place / "VERIFIED.txt").read_text().rstrip().endswith(words)


# ---- What lies where an export is to go.


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a model and an export of it."""
    monkeypatch.chdir(tmp_path)
    play_model().save("rig.json")
    export(subject_of(play_model(), name="rig"), "c", "out")
    return tmp_path


@pytest.mark.parametrize("out", ["mine", "."])
def test_a_folder_that_is_no_export_is_never_replaced(run, place, out):
    (place / "mine").mkdir()
    (place / "mine" / "log.csv").write_text("a week of measurements")
    status, _, err = run("export", "rig.json", "--target", "c", "--out", out, "--overwrite")
    assert status == 2
    assert "--overwrite replaces exports only" in " ".join(err.split())
    assert (place / "mine" / "log.csv").read_text() == "a week of measurements"
    assert (place / "rig.json").exists()


def test_notes_in_an_export_survive_its_replacement(run, place):
    (place / "out" / "notes.txt").write_text("mine")
    (place / "out" / "src" / "mine.c").write_text("int x;")
    (place / "out" / "README.md").write_text("edited")
    assert run("export", "rig.json", "--target", "st", "--out", "out")[0] == 2
    assert run("export", "rig.json", "--target", "st", "--out", "out", "--overwrite")[0] == 0
    assert (place / "out" / "notes.txt").read_text() == "mine"
    assert (place / "out" / "src" / "mine.c").read_text() == "int x;"
    assert not (place / "out" / "src" / "rig.c").exists()
    assert not (place / "out" / "check").exists()
    assert not [path for path in (place / "out").iterdir() if path.name.startswith(".")]


def test_a_file_of_the_user_that_the_new_export_would_need_is_named(run, place):
    (place / "out" / "rig.st").write_text("mine")
    (place / "out" / "Rig.st").write_text("mine")
    status, _, err = run("export", "rig.json", "--target", "st", "--out", "out", "--overwrite")
    assert status == 2
    assert ".st" in err
    assert (place / "out" / "src" / "rig.c").exists()


@pytest.mark.parametrize("state", ["empty", "exported"])
def test_an_export_can_go_into_the_folder_one_is_in(run, place, monkeypatch, state):
    where = place / "out"
    if state == "empty":
        where = place / "fresh"
        where.mkdir()
    monkeypatch.chdir(where)
    assert run("export", "../rig.json", "--target", "c", "--out", ".")[0] == 0
    assert (where / "manifest.json").exists()
    assert verification.verify_folder(where).checks[0].ok


def test_the_folder_of_the_model_and_one_above_is_not_replaced(run, place, monkeypatch):
    shutil.copy("rig.json", "out/rig2.json")
    status, _, err = run("export", "out/rig2.json", "--target", "c", "--out", "out", "--overwrite")
    assert status == 2
    assert "is read for the export" in " ".join(err.split())
    (place / "out" / "deep").mkdir()
    monkeypatch.chdir(place / "out" / "deep")
    status, _, err = run(
        "export", place / "rig.json", "--target", "c", "--out", place / "out", "--overwrite"
    )
    assert status == 2
    assert "the folder you are in" in err


def test_a_working_directory_that_is_gone_is_named(run, place, monkeypatch):
    gone = place / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    status, _, err = run("export", place / "rig.json", "--target", "c", "--out", "new")
    assert status == 2
    assert "does not exist any more" in " ".join(err.split())


def test_an_export_that_links_elsewhere_is_no_export_to_be_replaced(run, place):
    shutil.move(place / "out" / "src", place / "elsewhere")
    (place / "out" / "src").symlink_to(place / "elsewhere")
    assert run("export", "rig.json", "--target", "st", "--out", "out", "--overwrite")[0] == 2
    assert (place / "elsewhere" / "rig.c").exists()
