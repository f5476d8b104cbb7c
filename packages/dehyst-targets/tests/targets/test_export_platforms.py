"""FMUs and C for every platform from one machine: made by zig, they answer to the bit under wine and qemu."""

import io
import os
import shutil
import struct
import subprocess
import zipfile
from pathlib import Path

import pytest

from dehyst.export import export, subject_of
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.export import joint_subject
from dehyst_targets.fmu import _sources as sources
from dehyst_targets.fmu import fmu_companions, package
from direct_export_samples import direct_model
from element_samples import scheduled_model
from export_samples import mapped_model, play_model

pytestmark = pytest.mark.slow
ZIG = (
    Path(
        pytest.importorskip(
            "ziglang", reason="needs zig: pip install 'dehyst-targets[fmi]'"
        ).__path__[0]
    )
    / "zig"
)
WINE = shutil.which("wine64") or shutil.which("/usr/lib/wine/wine64") or shutil.which("wine")
WINDOWS = {
    "WINEPREFIX": os.environ.get("WINEPREFIX", str(Path.home() / ".wine")),
    "WINEDEBUG": "-all",
}
QEMU, ARM = shutil.which("qemu-aarch64"), Path("/usr/aarch64-linux-gnu")
PROCESSORS = {"aarch64": "little-endian", "s390x": "big-endian"}
UNITS = {
    "pi": lambda real: subject_of(play_model(), "inverse", name="unit_1", real=real),
    "modified": lambda real: subject_of(mapped_model(), "forward", name="unit_1", real=real),
    "elements": lambda real: subject_of(scheduled_model(), "inverse", name="unit_1", real=real),
    "direct": lambda real: subject_of(
        direct_model(), "inverse", name="unit_1", real=real, period=0.004
    ),
    "joint": lambda real: joint_subject(
        play_model(), JointControllerParameters(), name="unit_1", real=real
    ),
}
FOLDERS = {
    2: {"linux64", "win64", "darwin64"},
    3: {"x86_64-linux", "aarch64-linux", "x86_64-windows", "x86_64-darwin", "aarch64-darwin"},
}


def binaries(name, version, *folders):
    """The package of a unit with the binaries of some platforms: all are made by the first test."""
    with pytest.MonkeyPatch.context() as patch:
        wanted = tuple(
            target for target in sources.TARGETS if target.folders[version - 2] in folders
        )
        patch.setattr(sources, "TARGETS", wanted)
        return package(UNITS[name]("double"), version)


def unpacked(name, version, folder, platform):
    """The FMU of a unit with the binary of a platform, and its check beside it."""
    made = binaries(name, version, platform)
    with zipfile.ZipFile(io.BytesIO(made.fmu)) as packed:
        packed.extractall(folder)
    for path, text in fmu_companions(made).items():
        if path.startswith("check/"):
            (folder / path).parent.mkdir(exist_ok=True)
            (folder / path).write_bytes(text if isinstance(text, bytes) else text.encode())
    return folder


def checked(folder, binaries, triple, suffix, *runner, **env):
    """What the folder's check says, linked with a binary of the FMU and run where the binary belongs."""
    place = folder / "binaries" / binaries
    check = place / ("check.exe" if suffix == ".dll" else "check")
    build = [
        ZIG,
        "cc",
        "-target",
        triple,
        "-std=c99",
        "-O1",
        "-fno-sanitize=undefined",
        "-Icheck",
        "-Isources",
    ]
    made = subprocess.run(
        [*build, "check/check.c", place / f"unit_1{suffix}", "-o", check],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert made.returncode == 0, made.stderr
    done = subprocess.run(
        [*runner, check], capture_output=True, text=True, env=os.environ | env, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.exhaustive
def test_zig_makes_a_binary_for_each_platform_that_the_standard_names_and_the_same_again(version):
    first, second = (package(UNITS["pi"]("double"), version) for _ in range(2))
    assert {path.split("/")[1] for path in first.binaries.files} == FOLDERS[version]
    assert not first.binaries.missing and first.fmu == second.fmu


def test_the_library_of_macs_in_fmi_2_holds_one_for_each_processor():
    macs = (2, "darwin64"), (3, "x86_64-darwin", "aarch64-darwin")
    old, new = (binaries("pi", *which).binaries.files for which in macs)
    both = old["binaries/darwin64/unit_1.dylib"]
    assert struct.unpack(">II", both[:8]) == (0xCAFEBABE, 2)
    kinds = set()
    for k in range(2):
        cpu, _, at, size, align = struct.unpack(">5I", both[8 + 20 * k : 28 + 20 * k])
        assert at % (1 << align) == 0 and at + size <= len(both)
        assert struct.unpack("<II", both[at : at + 8]) == (
            0xFEEDFACF,
            cpu,
        )  # a 64-bit Mach-O of that processor
        kinds.add(cpu)
    assert kinds == {0x01000007, 0x0100000C}
    assert len(new) == 2
    assert all(
        path.startswith("binaries/") and text[:4] == b"\xcf\xfa\xed\xfe"
        for path, text in new.items()
    )


@pytest.mark.skipif(WINE is None, reason="needs wine: apt-get install wine64")
@pytest.mark.parametrize(
    ("name", "version"), [("pi", 2), ("modified", 3), ("elements", 3), ("direct", 2), ("joint", 3)]
)
def test_the_windows_library_answers_to_the_bit_under_wine(name, version, tmp_path):
    place = {2: "win64", 3: "x86_64-windows"}[version]
    folder = unpacked(name, version, tmp_path / "fmu", place)
    said = checked(folder, place, "x86_64-windows-gnu", ".dll", WINE, **WINDOWS)
    assert "samples: " in said and "bits" in said and "FAILED" not in said


@pytest.mark.skipif(
    QEMU is None or not ARM.is_dir(), reason="needs apt-get install qemu-user libc6-arm64-cross"
)
@pytest.mark.parametrize("name", UNITS)
def test_the_aarch64_library_answers_to_the_bit_under_qemu(name, tmp_path):
    folder = unpacked(name, 3, tmp_path / "fmu", "aarch64-linux")
    place = folder / "binaries" / "aarch64-linux"
    runner = (QEMU, "-L", str(ARM), "-E", f"LD_LIBRARY_PATH={place}")
    said = checked(folder, "aarch64-linux", "aarch64-linux-gnu.2.17", ".so", *runner)
    assert "samples: " in said and "bits" in said and "FAILED" not in said


def compiled(folder, *compiler):
    """The exported check of C sources, compiled as its README says."""
    program = folder / "program.exe"
    files = [folder / "check" / "check.c", *sorted((folder / "src").glob("*.c"))]
    build = [
        *compiler,
        "-std=c99",
        f"-I{folder / 'src'}",
        f"-I{folder / 'check'}",
        *files,
        "-o",
        program,
    ]
    made = subprocess.run(build, capture_output=True, text=True)
    assert made.returncode == 0, made.stderr
    return program


def last_line(*command, **env):
    done = subprocess.run(
        command, capture_output=True, text=True, env=os.environ | env, timeout=300
    )
    return done.stdout.splitlines()[-1] if done.returncode == 0 else done.stdout + done.stderr


@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("name", UNITS)
@pytest.mark.exhaustive
def test_exported_c_answers_to_the_bit_on_other_processors_systems_and_by_another_compiler(
    name, real, tmp_path
):
    folder = export(UNITS[name](real), "c", tmp_path / "out").folder
    said, zig = {}, (ZIG, "cc", "-O2", "-ffp-contract=off", "-fno-sanitize=undefined", "-target")
    for processor in PROCESSORS:
        qemu, root = shutil.which(f"qemu-{processor}"), Path(f"/usr/{processor}-linux-gnu")
        if qemu and root.is_dir():
            program = compiled(folder, *zig, f"{processor}-linux-gnu.2.17")
            said[processor] = last_line(qemu, "-L", root, program)
    if WINE and real == "double":
        said["windows"] = last_line(WINE, compiled(folder, *zig, "x86_64-windows-gnu"), **WINDOWS)
    if tcc := shutil.which("tcc"):
        said["tcc"] = last_line(compiled(folder, tcc))
    if not said:
        pytest.skip(
            "needs one of: apt-get install qemu-user libc6-arm64-cross libc6-s390x-cross wine64 tcc"
        )
    assert set(said.values()) == {"all checks passed"}, said


def test_the_linux_library_asks_for_no_new_c_library(tmp_path):
    needs = binaries("pi", 3, "x86_64-linux", "aarch64-linux").binaries.files
    assert len(needs) == 2
    versions = {
        tuple(map(int, v.split(b".")[:2])) for text in needs.values() for v in _versions(text)
    }
    assert versions and max(versions) <= (2, 17)


def _versions(library):
    return [word[len(b"GLIBC_") :] for word in library.split(b"\0") if word.startswith(b"GLIBC_2")]


@pytest.mark.parametrize("home", ["/dev/null/home", None])
def test_without_a_home_folder_that_can_be_written_zig_works_too(home, monkeypatch):
    monkeypatch.setattr(sources, "TARGETS", (sources.LINUX,))
    monkeypatch.delenv("HOME") if home is None else monkeypatch.setenv("HOME", home)
    assert set(package(UNITS["pi"]("double"), 2).binaries.files) == {"binaries/linux64/unit_1.so"}


def test_what_zig_says_when_it_fails_is_in_the_message(monkeypatch):
    monkeypatch.setattr(sources, "ZIG", ("-fno-such-option",))
    with pytest.raises(sources.OutputError, match="cannot compile the FMU"):
        package(UNITS["pi"]("double"), 2)
