"""`dehyst verify` signs off a fresh export of the model in the folder and nothing else; no byte of the folder runs."""

import hashlib
import json
import os
import shutil
import subprocess
import zipfile

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dehyst import __version__
from dehyst.errors import DehystError
from dehyst.export import _verification as verification
from dehyst.export import compilers, export, read_manifest, subject_of
from dehyst.export._signal import from_csv
from dehyst.models import DirectInverse
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.export import joint_subject
from dehyst_targets.fmu import _sources as sources
from export_samples import CARD, mapped_model, needs_make, play_model

pytestmark = needs_make
WAVE = 3 * np.sin(np.arange(50) / 5)


def direct_unit():
    model = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0], card=CARD)
    return subject_of(model, name="elbow", period=0.01)


UNITS = {
    "c": lambda excerpt=WAVE: subject_of(
        play_model(), name="elbow", excerpt=excerpt, excerpt_source="log.csv, angle"
    ),
    "c-header": lambda: subject_of(
        play_model(), name="elbow", real="float", range=(-0.5, 1.5), ramp=7
    ),
    "simulink": lambda: joint_subject(mapped_model(), JointControllerParameters(), name="axis"),
    "st": lambda excerpt=WAVE: subject_of(mapped_model(), "forward", name="elbow", excerpt=excerpt),
    "arduino": lambda: subject_of(play_model(), name="elbow", real="float"),
    "rust": lambda: subject_of(play_model(), name="elbow"),
    "direct": direct_unit,
}
EXAMPLES = {"simulink": 6}  # of a joint controller, whose test signal takes a second


@pytest.fixture(scope="module")
def exports(tmp_path_factory):
    """An export of each kind, made once."""
    made = {}

    def of(kind):
        if kind not in made:
            target = "c" if kind == "direct" else kind
            made[kind] = export(UNITS[kind](), target, tmp_path_factory.mktemp(kind) / "out").folder
        return made[kind]

    return of


@pytest.fixture
def nothing_runs(monkeypatch):
    """No process may be started."""

    def refuse(*_, **__):
        raise AssertionError("something was run")

    monkeypatch.setattr(subprocess, "Popen", refuse)


@pytest.fixture
def nothing_compiles(monkeypatch):
    """The check passes without a compiler, so that only the comparison stands between a folder and its signature."""
    monkeypatch.setattr(
        compilers, "_check_with", lambda *_: compilers.Check("make check", "passed", ran=True)
    )
    monkeypatch.setattr("dehyst_targets.arduino.BOARDS", {})


def signed(folder):
    """Whether a folder is signed off; a refusal is none."""
    try:
        return verification.verify_folder(folder).good
    except DehystError:
        return False


def renew(folder):
    """Write the checksums of what is there, as somebody does who wants a changed folder to pass."""
    path = folder / "manifest.json"
    manifest = json.loads(path.read_text())
    for name in manifest["files"]:
        manifest["files"][name] = hashlib.sha256((folder / name).read_bytes()).hexdigest()
    path.write_text(json.dumps(manifest, indent=1) + "\n")


@pytest.mark.parametrize(
    "kind", [pytest.param(k, marks=pytest.mark.slow if k == "rust" else ()) for k in UNITS]
)
def test_what_was_exported_is_signed_off(exports, nothing_compiles, kind):
    assert signed(exports(kind))


@pytest.mark.slow
@pytest.mark.parametrize("kind", UNITS)
def test_a_folder_with_any_byte_changed_is_never_signed_off(
    exports, nothing_compiles, tmp_path, kind
):
    whole = exports(kind)
    names = sorted(
        path.relative_to(whole).as_posix() for path in whole.rglob("*") if path.is_file()
    )

    @settings(max_examples=EXAMPLES.get(kind, 25), suppress_health_check=list(HealthCheck))
    @given(
        st.sampled_from(names), st.integers(0, 10**9), st.integers(1, 255), st.booleans(), st.data()
    )
    def changed(name, place, bits, renewed, data):
        folder = shutil.copytree(whole, tmp_path / "out", dirs_exist_ok=True)
        text = bytearray((whole / name).read_bytes())
        how = data.draw(st.sampled_from(["change", "insert", "delete"]))
        place %= len(text)
        if how == "change":
            text[place] ^= bits
        else:
            text[place : place + (how == "delete")] = b"" if how == "delete" else bytes([bits])
        if name == "manifest.json" and other_date(whole, text):
            return  # nothing in a folder tells when it was made
        (folder / name).write_bytes(bytes(text))
        if renewed and name != "manifest.json":
            renew(folder)
        if name == "expected/excerpt.csv" and renewed and other_excerpt(kind, text, tmp_path):
            return  # nothing in a folder tells which log was meant
        assert not signed(folder), (name, place, how)

    changed()


def other_excerpt(kind, text, tmp_path):
    """Whether a changed excerpt is what an export of another log gives: the model answers it with the same numbers."""
    try:
        inputs = from_csv(bytes(text).decode(), 1, "excerpt").inputs[:, 0]
        fresh = export(UNITS[kind](inputs), kind, tmp_path / "other", overwrite=True).folder
    except (DehystError, ValueError):
        return False
    return (fresh / "expected" / "excerpt.csv").read_bytes() == bytes(text)


def other_date(whole, text):
    """Whether nothing but the date of a manifest was changed."""
    try:
        changed = json.loads(bytes(text))
    except ValueError:
        return False
    kept = read_manifest(whole)
    return isinstance(changed, dict) and {**changed, "date": ""} == {**kept, "date": ""}


ODD = [
    None,
    [],
    {},
    "",
    "x",
    "0.0.9",
    True,
    0,
    -1,
    7.5,
    10**30,
    1e300,
    float("inf"),
    float("nan"),
    ["c"],
    {"a": 1},
    "é",
]


def places(value, path=()):
    """Return the path of every field of a manifest, and of those inside it."""
    inner = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    return ([path] if path else []) + [
        place for key, one in inner for place in places(one, (*path, key))
    ]


@pytest.mark.slow
@pytest.mark.parametrize("kind", UNITS)
def test_a_folder_with_any_field_of_its_manifest_changed_is_never_signed_off(
    exports, nothing_compiles, tmp_path, kind
):
    folder = shutil.copytree(exports(kind), tmp_path / "out")
    kept = (folder / "manifest.json").read_text()

    @settings(max_examples=EXAMPLES.get(kind, 25), suppress_health_check=list(HealthCheck))
    @given(st.sampled_from(places(json.loads(kept))), st.sampled_from([*ODD, "missing"]))
    def changed(path, value):
        manifest = json.loads(kept)
        around = manifest
        for key in path[:-1]:
            around = around[key]
        if type(around[path[-1]]) is type(value) and around[path[-1]] == value:
            return
        around[path[-1]] = value
        if value == "missing":
            del around[path[-1]]
        (folder / "manifest.json").write_text(json.dumps(manifest, indent=1) + "\n")
        assert not signed(folder)

    changed()


@pytest.mark.parametrize("number", ["Infinity", "-Infinity", "NaN"])
def test_a_manifest_with_a_number_that_is_none_is_refused(exports, nothing_runs, tmp_path, number):
    folder = shutil.copytree(exports("c"), tmp_path / "out")
    text = (folder / "manifest.json").read_text()
    (folder / "manifest.json").write_text(text.replace("{", f'{{\n "period": {number},', 1))
    with pytest.raises(DehystError, match=f"holds {number}"):
        verification.verify_folder(folder)


@pytest.mark.spread(13)
@pytest.mark.parametrize("kind", ["c", "direct", "simulink"])
@pytest.mark.parametrize("target", ["c", "st", "simulink", "arduino"])
@pytest.mark.parametrize("what", ["inverse", "joint-controller", "direct-inverse", "nothing"])
def test_a_manifest_of_another_target_or_unit_is_an_answer_and_no_traceback(
    exports, nothing_compiles, tmp_path, kind, target, what
):
    kept = read_manifest(exports(kind))
    if (kept["target"], kept["settings"]["what"]) == (target, what):
        return
    folder = shutil.copytree(exports(kind), tmp_path / "out")
    manifest = {**kept, "target": target, "settings": {**kept["settings"], "what": what}}
    (folder / "manifest.json").write_text(json.dumps(manifest, indent=1) + "\n")
    assert not signed(folder)


VERSIONS = {
    "an older one": ("0.0.9", "verify the folder with dehyst 0.0.9"),
    "a newer one": ("9.9", "verify the folder with dehyst 9.9"),
    "none": (None, "names no version of dehyst"),
    "a list": ([__version__], "names no version of dehyst"),
    "a number": (1, "names no version of dehyst"),
    "words": ("1\nall checks passed", "names no version of dehyst"),
    "a long one": ("1" * 5000, "names no version of dehyst"),
}


@pytest.mark.parametrize("version", VERSIONS)
def test_a_folder_of_another_version_is_not_run_and_the_version_that_is_needed_named(
    run, exports, nothing_runs, tmp_path, version
):
    """The folder of issue 15: a wrong sign where nobody looks, a Makefile that runs a program, checksums renewed."""
    folder = shutil.copytree(exports("c"), tmp_path / "out")
    source = folder / "src" / "elbow.c"
    source.write_text(
        source.read_text().replace("return ", "if (x > 10 && x < 10.001) return -x; return ", 1)
    )
    (folder / "Makefile").write_text(
        f"X := $(shell touch {tmp_path / 'ran'})\n" + (folder / "Makefile").read_text()
    )
    renew(folder)
    manifest = read_manifest(folder) | {"dehyst": VERSIONS[version][0]}
    (folder / "manifest.json").write_text(json.dumps(manifest, indent=1) + "\n")
    (folder / "VERIFIED.txt").write_text("Verified by `dehyst verify`.\n")
    status, out, _ = run("verify", folder)
    assert status == 1
    assert VERSIONS[version][1] in out
    assert f"this is {__version__}" in out
    assert not (folder / "VERIFIED.txt").exists()
    assert not (tmp_path / "ran").exists()


def test_a_folder_without_a_version_is_not_signed_off(exports, nothing_runs, tmp_path):
    folder = shutil.copytree(exports("c"), tmp_path / "out")
    manifest = read_manifest(folder)
    del manifest["dehyst"]
    (folder / "manifest.json").write_text(json.dumps(manifest, indent=1) + "\n")
    assert not signed(folder)


def test_a_key_that_stands_twice_is_not_signed_off(exports, nothing_runs, tmp_path):
    folder = shutil.copytree(exports("c"), tmp_path / "out")
    text = (folder / "manifest.json").read_text()
    (folder / "manifest.json").write_text(text.replace("{", '{\n "dehyst": "9.9",', 1))
    found = verification.verify_folder(folder)
    assert not found.good
    assert "its text is not as exported" in str(found.checks)


HIDDEN = {
    "rust": ("dehyst.targets", "dehyst-targets"),
    "simulink": ("dehyst.controllers", "dehyst-robot"),
}


@pytest.mark.parametrize("kind", HIDDEN)
def test_an_export_whose_package_is_not_installed_is_neither_signed_off_nor_called_wrong(
    run, exports, nothing_runs, monkeypatch, tmp_path, kind
):
    hidden, package = HIDDEN[kind]
    folder = shutil.copytree(exports(kind), tmp_path / "out")
    installed = verification.added
    monkeypatch.setattr(
        verification, "added", lambda group: {} if group == hidden else installed(group)
    )
    status, out, _ = run("verify", folder, "--json")
    answer = json.loads(out)
    assert (status, answer["verified"]) == (1, False)
    assert f"pip install {package}" in answer["why_not"]
    assert "failed" not in {check["status"] for check in answer["checks"]}
    [skipped, _] = [check for check in answer["checks"] if check["status"] == "skipped"]
    assert (
        f"is part of {package}, which is not installed: pip install {package}" in skipped["detail"]
    )
    assert not (folder / "VERIFIED.txt").exists()
    with (folder / "model.json").open("a") as model:
        model.write(" ")
    assert verification.verify_folder(folder).why_not == verification.WRONG


def move_and_link(folder, name):
    elsewhere = folder.parent / "elsewhere"
    shutil.move(folder / name, elsewhere)
    (folder / name).symlink_to(elsewhere)


def as_pipe(folder, name):
    (folder / name).unlink()
    os.mkfifo(folder / name)


def as_folder(folder, name):
    (folder / name).unlink()
    (folder / name).mkdir()


LAID_OUT = {
    "a source is a link": lambda f: move_and_link(f, "src/elbow.c"),
    "the sources are a link": lambda f: move_and_link(f, "src"),
    "the manifest is a link": lambda f: move_and_link(f, "manifest.json"),
    "the model is a pipe": lambda f: as_pipe(f, "model.json"),
    "the manifest is a pipe": lambda f: as_pipe(f, "manifest.json"),
    "the Makefile is a folder": lambda f: as_folder(f, "Makefile"),
    "a source whose name differs in case": lambda f: (f / "src" / "ELBOW.c").write_text("int x;"),
    "a folder whose name differs in case": lambda f: (
        (f / "SRC").mkdir(),
        (f / "SRC" / "elbow.c").write_text(""),
    ),
    "a file whose name differs in case": lambda f: (f / "MODEL.json").write_text("{}"),
    "an included makefile": lambda f: (f / "rules.mk").write_text("X := 1"),
    "a file named like an option": lambda f: (f / "src" / "-fplugin=x.so").write_text(""),
}


@pytest.mark.parametrize("change", LAID_OUT)
def test_a_folder_that_is_not_laid_out_as_exported_is_not_signed_off(
    exports, nothing_runs, tmp_path, change
):
    folder = shutil.copytree(exports("c"), tmp_path / "out")
    LAID_OUT[change](folder)
    assert not signed(folder)


def test_what_runs_is_a_fresh_export_and_a_folder_that_changes_meanwhile_is_not_signed_off(
    exports, monkeypatch, tmp_path
):
    folder = shutil.copytree(exports("c"), tmp_path / "out")
    ran = []

    def change(place, *_):
        ran.extend(
            sorted(
                path.relative_to(place).as_posix() for path in place.rglob("*") if path.is_file()
            )
        )
        assert not place.samefile(folder)
        (folder / "src" / "elbow.c").write_text("changed after it was compared")
        return compilers.Check("make check", "passed", ran=True)

    monkeypatch.setattr(compilers, "_check_with", change)
    monkeypatch.setattr(compilers, "LEVELS", ("-O0",))
    monkeypatch.setattr(compilers.found, "__defaults__", (("cc",),))
    found = verification.verify_folder(folder)
    assert ran == sorted([*found.manifest["files"], "manifest.json"])
    assert not found.good
    assert "its files changed" in str(found.checks)


@pytest.mark.parametrize("broken", ["{", "[]", "", '{"format": "dehyst-export"}'])
def test_an_old_signature_does_not_outlive_a_broken_manifest(run, exports, tmp_path, broken):
    folder = shutil.copytree(exports("c"), tmp_path / "out")
    (folder / "VERIFIED.txt").write_text("Verified by `dehyst verify`.\n")
    (folder / "manifest.json").write_text(broken)
    assert run("verify", folder)[0] == 2
    assert not (folder / "VERIFIED.txt").exists()


def test_a_file_of_that_name_in_a_folder_that_is_no_export_stays(run, tmp_path):
    (tmp_path / "VERIFIED.txt").write_text("by me")
    assert run("verify", tmp_path)[0] == 2
    assert (tmp_path / "VERIFIED.txt").read_text() == "by me"


HOSTILE = {
    "MAKEFLAGS": "-n", "GNUMAKEFLAGS": "-n", "MAKEFILES": "/dev/full", "CC": "false", "CFLAGS": "-Werror -DX=",
    "CPPFLAGS": "-Dint=", "LDFLAGS": "-lnowhere", "CPATH": "here", "C_INCLUDE_PATH": "here", "COMPILER_PATH": "here",
    "GCC_EXEC_PREFIX": "/nowhere/", "GCC_COMPARE_DEBUG": "-fnothing", "DEPENDENCIES_OUTPUT": "here/x", "STD": "-std=c",
    "WARNINGS": "-Werror", "VPATH": "here", "BUILD": "/dev/full", "SHELL": "/bin/false", "LANG": "tr_TR.UTF-8",
}  # fmt: skip


def test_nothing_that_the_environment_says_to_make_and_compilers_counts(
    exports, monkeypatch, tmp_path
):
    monkeypatch.setattr(compilers, "LEVELS", ("-O0",))
    monkeypatch.setattr(compilers.found, "__defaults__", (("cc",),))
    here = tmp_path / "here"
    here.mkdir()
    (here / "stdio.h").write_text("#error other header\n")
    (here / "as").symlink_to(shutil.which("false"))
    for name, value in HOSTILE.items():
        monkeypatch.setenv(name, value.replace("here", str(here)))
    found = verification.verify_folder(exports("c"))
    assert found.good, found.checks
    assert not (here / "x").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("one_compiler")
def test_an_fmu_whose_binary_another_compiler_made_is_not_run_and_where_it_can_be_verified_is_said(
    monkeypatch, tmp_path
):
    with monkeypatch.context() as elsewhere:
        elsewhere.setattr(sources, "OPTIONS", (*sources.OPTIONS, "-O0"))
        folder = export(subject_of(play_model(), name="elbow"), "fmu2", tmp_path / "out").folder
    with zipfile.ZipFile(folder / "elbow.fmu") as packed:
        made = [name for name in packed.namelist() if name.startswith("binaries/")]
    monkeypatch.setattr("dehyst_targets.fmu._verification.run_fmu", None)  # would be a fault
    [fault] = [check.detail for check in verification.verify_folder(folder).checks if not check.ok]
    expected = (
        f"not as exported: elbow.fmu; {', '.join(sorted(made))} in elbow.fmu {'is' if len(made) == 1 else 'are'} "
        f"not what this machine makes of the"
    )
    assert made
    assert fault.startswith(expected)
    assert "verify it where it was exported" in fault
