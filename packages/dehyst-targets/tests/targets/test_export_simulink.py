"""The Simulink target: its S-function runs with a stand-in for Simulink's header and gives the bits of the model."""

import re
import shutil
import subprocess

import numpy as np
import pytest

from dehyst.export import export, subject_of, verify
from dehyst.export._signal import to_hex
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.export import joint_subject
from export_samples import large_model, make_check, mapped_model, needs_make

SUBJECTS = {
    "inverse in double": lambda: subject_of(large_model(14), name="joint_1"),
    "inverse with a map in float": lambda: subject_of(mapped_model(), name="joint_1", real="float"),
    "forward with a map in double": lambda: subject_of(mapped_model(), "forward", name="joint_1"),
    "joint controller in double": lambda: joint_subject(
        large_model(14), JointControllerParameters(), name="joint_1"
    ),
    "joint controller in float": lambda: joint_subject(
        large_model(14), JointControllerParameters(), name="joint_1", real="float"
    ),
}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Return a function that exports a subject once."""
    made = {}

    def folder(name):
        if name not in made:
            made[name] = tmp_path_factory.mktemp("simulink") / "out"
            export(SUBJECTS[name](), "simulink", made[name])
        return made[name]

    return folder


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize("name", SUBJECTS)
def test_the_s_function_gives_the_models_answers(folders, name, tmp_path):
    done = make_check(folders(name), tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    for claim in ("S-function", "three times a step", "operating point", "initial conditions"):
        assert re.search(rf"(?m){claim}.* ok$", done.stdout)
    assert not done.stderr


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize(
    ("old", "new", "claim"),
    [
        (
            "#define MDL_UPDATE\n",
            "#define MDL_UPDATE\nstatic int never;\n#define copy_words(to, from) (void)never\n",
            "samples",
        ),
        ("ssSetDWorkUsedAsDState(S, STATE, SS_DWORK_USED_AS_DSTATE);", "", "operating point"),
        ("enum { STATE = 0, NEXT = 1 };", "enum { STATE = 0, NEXT = 0 };", "three times"),
    ],
    ids=["no update", "state not kept", "state moved by outputs"],
)
def test_an_s_function_that_is_wrong_is_noticed(folders, tmp_path, old, new, claim):
    copy = tmp_path / "copy"
    shutil.copytree(folders("inverse in double"), copy)
    source = copy / "sfun_joint_1.c"
    text = source.read_text()
    assert old in text
    source.write_text(text.replace(old, new))
    done = make_check(copy, tmp_path / "build")
    assert done.returncode != 0
    assert re.search(rf"(?m){claim}.*FAILED", done.stdout)


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize("name", ["inverse in double", "joint controller in double"])
def test_an_s_function_tells_other_last_digits_from_a_wrong_unit_and_judges_nothing_behind_one(
    folders, name, tmp_path
):
    copy = tmp_path / "copy"
    shutil.copytree(folders(name), copy)
    (copy / "Makefile").write_text(
        (copy / "Makefile").read_text().replace("\t$(abspath $(BUILD))/check\n", "")
    )
    source = copy / "src" / "pi.c"
    text = source.read_text()
    assert "pi->offset + " in text
    ends = []
    for size, says in (
        ("1e-13", "usable, not bit-equal, because "),
        ("1e-3", "FAILED: do not use"),
    ):
        source.write_text(text.replace("pi->offset + ", f"pi->offset + {size} + "))
        done = make_check(copy, tmp_path / size)
        ends.append(
            (
                done.returncode == 0,
                says in done.stdout.splitlines()[-1],
                "not judged" in done.stdout,
            )
        )
        assert float(re.search(r"(\S+) of range", done.stdout)[1].strip("(")) > 0.0
    assert ends == [(True, True, False), (False, True, True)]


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("name", ["inverse in double", "joint controller in float"])
def test_what_is_written_by_hand_compiles_without_a_warning(folders, name, compiler):
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    folder = folders(name)
    strict = [
        compiler,
        "-std=c99",
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-Wpedantic",
        "-Werror",
        "-fsyntax-only",
    ]
    paths = [f"-I{folder / place}" for place in ("src", "check", "check/stand_in")]
    files = [folder / "sfun_joint_1.c", folder / "src" / "joint_1_simulink.c"]
    subprocess.run([*strict, *paths, "-DMATLAB_MEX_FILE", *map(str, files)], check=True)


@pytest.mark.slow
def test_verify_runs_it_and_says_that_matlab_was_not_there(folders, monkeypatch):
    monkeypatch.setattr("dehyst.export.compilers.LEVELS", ("-O0",))
    checks = verify(folders("inverse in double"))
    assert all(check.ok for check in checks)
    assert [
        check.claim for check in checks if "MATLAB" in check.claim and check.status == "skipped"
    ]


def test_the_signal_for_matlab_has_all_digits():
    subject = SUBJECTS["joint controller in double"]()
    rows = [line.split() for line in to_hex(subject.test).splitlines()]
    words = np.array(
        [[int(word, 16) for word in (*row[:10], *row[11:-1])] for row in rows], dtype=np.uint64
    )
    wanted = np.hstack([subject.test.inputs, subject.test.outputs])
    assert np.array_equal(words, wanted.view(np.uint64))
    assert [int(row[10]) for row in rows] == subject.test.switch.tolist()
    assert [int(row[-1]) for row in rows] == subject.test.flags.tolist()


@pytest.mark.parametrize("name", SUBJECTS)
def test_scripts_for_matlab_name_files_that_are_there_and_close_what_they_open(folders, name):
    folder = folders(name)
    scripts = {path.name: path.read_text() for path in folder.glob("*.m")}
    assert set(scripts) == {"build_joint_1.m", "check_joint_1.m", "settings_joint_1.m"}
    for file, text in scripts.items():
        code = "\n".join(line for line in text.splitlines() if not line.strip().startswith("%"))
        code = re.sub(r"'[^'\n]*'", "''", code)
        opened = len(re.findall(r"(?m)^\s*(?:function|if)\b", code)) + len(
            re.findall(r"(?<=\n)\s*for\b", code)
        )
        assert opened == len(re.findall(r"(?<![\w(])end(?=\s*(?:$|\n|;))", code)), file
        assert all(code.count(a) == code.count(b) for a, b in ("()", "[]", "{}")), file
        assert text.startswith(f"function {file.removesuffix('.m')}")
    named = re.findall(r"'(src/\w+\.c)'", scripts["build_joint_1.m"])
    assert sorted(named) == sorted(f"src/{path.name}" for path in (folder / "src").glob("*.c"))
    assert named == re.findall(r"'(src/\w+\.c)'", scripts["settings_joint_1.m"])


@pytest.mark.parametrize("name", ["inverse in double", "joint controller in double"])
def test_the_recipe_of_the_c_function_block_calls_what_the_header_declares(folders, name):
    folder = folders(name)
    header, readme = (
        (folder / "src" / "joint_1_simulink.h").read_text(),
        (folder / "README.md").read_text(),
    )
    called = set(
        re.findall(
            r"\bjoint_1_simulink_\w+(?=\()", "\n".join(re.findall(r"(?s)```c\n(.*?)```", readme))
        )
    )
    assert called == set(re.findall(r"\bjoint_1_simulink_\w+(?=\()", header))
    words = int(re.search(r"JOINT_1_MEMORY (\d+)", header)[1])
    assert f"| `memory` | Persistent | uint32 | {words} | |" in readme
