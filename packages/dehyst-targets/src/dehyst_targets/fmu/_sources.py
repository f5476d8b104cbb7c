"""Sources of an FMU: the core, the unit's header and the FMI functions, included by one file all.c."""

from __future__ import annotations

import os
import platform
import re
import shutil
import struct
import subprocess
import tempfile
from collections import Counter
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from dehyst.errors import OutputError
from dehyst.export import kit as export_kit
from dehyst.version import __version__
from dehyst_targets.fmu._description import (
    Variable,
    Version,
    fmu_constants,
    is_single,
    variable_count,
)

_FUNCTION = re.compile(r"(?m)^[a-z][\w \t*]*?\b(dehyst_\w+)\(")
_LOCAL = re.compile(
    r"(?m)^static [\w \t*]*?\b(\w+)(?:\(|\[| =)|^typedef (?:union|struct|enum) (\w+)|^\} (\w+);"
)
_MACRO = re.compile(r"(?m)^[ \t]*#[ \t]*define (\w+)")


@dataclass(frozen=True)
class FmuUnit:
    """What is inside an FMU.

    Attributes
    ----------
    name
        C identifier.
    title
        One line about it.
    part
        Template of its type and functions, below templates/fmu.
    values
        For this template.
    core
        File name -> text of all C sources and headers that it needs, those of the core as they are.
    variables
        By value reference.
    period
        Of the samples, None if every communication step is one. [s]
    single
        Whether real numbers but time are of type Float32.
    """

    name: str
    title: str
    part: str
    values: Mapping[str, object]
    core: Mapping[str, str]
    variables: tuple[Variable, ...]
    period: float | None
    single: bool


def fmu_sources(unit: FmuUnit, version: Version, token: str, content: int) -> dict[str, bytes]:
    """Return the files below sources/: all.c is to be compiled, it includes all others."""
    # C has no array without elements: each has one at least.
    counts = {}
    for kind in ("real", "whole", "truth"):
        counts[kind] = max(variable_count(unit.variables, kind), 1)
    singles: list[Variable] = []
    if unit.single:
        singles = list(filter(is_single, unit.variables))
    head = export_kit.render(
        "fmu/unit_head.h.j2",
        title=unit.title,
        version=__version__,
        name=unit.name,
        token=token,
        content=content,
        period=hexadecimal(unit.period or 0.0),
        counts=counts,
        variables=unit.variables,
        singles=singles,
        constants=list(map(hexadecimal, fmu_constants(unit.variables))) or ["0"],
    )
    texts = {f"core/{name}": text for name, text in unit.core.items()}
    texts["unit.h"] = head + export_kit.render(unit.part, name=unit.name, **unit.values)
    templates = Path(__file__).resolve().parents[1] / "templates" / "fmu"
    for name in ("fmu.h", f"fmi{version}.h", f"fmi{version}.c"):
        texts[name] = (templates / name).read_text(encoding="utf-8")
    # The core's configuration gives its functions other names in single precision.
    suffix = ""
    if "_float\n" in unit.core[export_kit.CONFIG]:
        suffix = "_float"
    texts["all.c"] = export_kit.render(
        "fmu/all.c.j2",
        fmi=version,
        name=unit.name,
        functions=functions(unit.core),
        suffix=suffix,
        core=included(unit.core),
    )
    return {path: text.encode() for path, text in sorted(texts.items())}


def functions(core: Mapping[str, str]) -> list[str]:
    """Names of the core's functions, renamed in each FMU so that several can be linked into one program."""
    names: set[str] = set()
    for path, text in core.items():
        if path.endswith(".h"):
            names.update(_FUNCTION.findall(text))
    return sorted(names)


def included(core: Mapping[str, str]) -> list[dict[str, object]]:
    """Source files in order, each with the names of its own that another file has too: they are kept apart."""
    local: dict[str, set[str]] = {}
    uses: Counter[str] = Counter()
    for path in sorted(core):
        if path.endswith(".c"):
            # One of the three groups of the pattern holds the name.
            local[path] = set(map("".join, _LOCAL.findall(core[path])))
            uses.update(local[path])
    files: list[dict[str, object]] = []
    for path, names in local.items():
        files.append(
            {
                "name": path,
                "stem": re.sub(r"\W", "_", path.removesuffix(".c")),
                "local": sorted(name for name in names if uses[name] > 1),
                "macros": sorted(set(_MACRO.findall(core[path]))),
            }
        )
    return files


def hexadecimal(value: float) -> str:
    """C constant that is this double, to the bit."""
    return float(value).hex()


# Contracted products would change last bits; hidden functions keep two FMUs in one process apart.
OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-shared")
# zig compiles checks of undefined behaviour into a program unless it is asked not to.
ZIG = ("-fno-sanitize=undefined", "-s", "-fPIC")
TIMEOUT_S = 900  # zig makes the C library of a platform first, once
PAGE = 1 << 14  # libraries in a universal binary begin at multiples of it


@dataclass(frozen=True)
class Platform:
    """A platform that binaries can be made for.

    Attributes
    ----------
    folders
        Below binaries/: FMI 2.0's name of the platform, "" if it has none, FMI 3.0's name.
    suffix
        Of the library.
    machine
        System and processor as Python names them.
    triple
        What zig calls it. Such libraries run on old systems, too: from glibc 2.17 on.
    compilers
        Commands to try where there is no zig, the first that is found is used.
    options
        Of these.
    cpu
        Type and subtype of the processor of a Mac, as a universal binary names it.
    """

    folders: tuple[str, str]
    suffix: str
    machine: str
    triple: str
    compilers: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    cpu: tuple[int, int] = (0, 0)


LINUX = Platform(
    ("linux64", "x86_64-linux"),
    ".so",
    "Linux x86_64",
    "x86_64-linux-gnu.2.17",
    ("cc", "gcc", "clang"),
    ("-fPIC",),
)
WINDOWS = Platform(
    ("win64", "x86_64-windows"),
    ".dll",
    "Windows AMD64",
    "x86_64-windows-gnu",
    ("x86_64-w64-mingw32-gcc",),
    # The user may lack the DLL of libgcc; a time stamp would make equal exports unequal.
    ("-static-libgcc", "-Wl,--no-insert-timestamp"),
)
TARGETS = (
    LINUX,
    WINDOWS,
    # FMI 2.0 has no name for Linux on ARM64.
    Platform(("", "aarch64-linux"), ".so", "Linux aarch64", "aarch64-linux-gnu.2.17"),
    Platform(
        ("darwin64", "x86_64-darwin"),
        ".dylib",
        "Darwin x86_64",
        "x86_64-macos",
        # The numbers of a processor are CPU_TYPE and CPU_SUBTYPE of mach/machine.h.
        cpu=(0x01000007, 3),
    ),
    Platform(
        ("darwin64", "aarch64-darwin"),
        ".dylib",
        "Darwin arm64",
        "aarch64-macos",
        cpu=(0x0100000C, 0),
    ),
)


@dataclass(frozen=True)
class Binaries:
    """What was compiled: path below the FMU -> bytes; and what was not, with the reason."""

    files: dict[str, bytes]
    missing: tuple[str, ...]


def compile_binaries(name: str, sources: Mapping[str, bytes], version: Version) -> Binaries:
    """Compile the FMU for every platform that FMI names and a compiler is found for.

    Raises
    ------
    OutputError
        If a compiler is there and fails: what it says is in the message.
    """
    made: dict[str, dict[Platform, Future[bytes]]] = {}
    missing = []
    # A compiler is a process of its own, so a thread only waits for it.
    with ThreadPoolExecutor() as pool:
        for target in TARGETS:
            folder, library = target.folders[version - 2], name + target.suffix
            if command := _command(target) if folder else None:
                job = pool.submit(_compiled, command, target, sources, library)
                made.setdefault(f"binaries/{folder}/{library}", {})[target] = job
            elif folder:
                compilers = " or ".join((*target.compilers, "zig (pip install ziglang)"))
                missing.append(f"{folder}: no {compilers} for it on this machine")
    files = {}
    for path, jobs in made.items():
        # Macs have two processors: both libraries go into one file.
        files[path] = universal({target: job.result() for target, job in jobs.items()})
    # In FMI 2.0 both processors of a Mac share a folder, which is missing only once.
    return Binaries(files, tuple(dict.fromkeys(missing)))


def universal(parts: Mapping[Platform, bytes]) -> bytes:
    """Return a library, or one for several processors of Macs: a header that says where each begins, and they."""
    if len(parts) == 1:
        return next(iter(parts.values()))
    # 0xCAFEBABE marks a universal binary, whose header is big-endian on every processor.
    head, body = struct.pack(">II", 0xCAFEBABE, len(parts)), b""
    for target, library in parts.items():
        head += struct.pack(
            ">5I", *target.cpu, PAGE + len(body), len(library), PAGE.bit_length() - 1
        )
        body += library + bytes(-len(library) % PAGE)
    return head.ljust(PAGE, b"\0") + body


def this_machine() -> str:
    """System and processor, as `Target.machine` says them."""
    return f"{platform.system()} {platform.machine()}"


def _command(target: Platform) -> tuple[str, ...] | None:
    """What compiles for a platform: zig of the package ziglang, or a compiler on the path."""
    if zig := find_spec("ziglang"):
        folder = Path(next(iter(zig.submodule_search_locations or ())))
        return (str(folder / "zig"), "cc", "-target", target.triple, *ZIG)
    # A plain cc compiles for the machine it runs on.
    if target is LINUX and this_machine() != target.machine:
        return None
    compiler = next(filter(None, map(shutil.which, target.compilers)), None)
    if not compiler:
        return None
    return (compiler, *target.options)


def _cache() -> dict[str, str]:
    """Where zig keeps what it makes once: below the home folder, or where that cannot be written the temporary one."""
    home = os.environ.get("HOME")
    if home and os.access(home, os.W_OK):
        return {}
    return {"ZIG_GLOBAL_CACHE_DIR": str(Path(tempfile.gettempdir()) / "zig-cache")}


def _compiled(
    command: tuple[str, ...], target: Platform, sources: Mapping[str, bytes], library: str
) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        for path, content in sources.items():
            file = Path(folder) / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        process = subprocess.run(
            [*command, *OPTIONS, "all.c", "-o", library],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=TIMEOUT_S,
            check=False,
            # Compilers that write a date into a library take that of the variable instead.
            env=_cache() | export_kit.plain_environment() | {"SOURCE_DATE_EPOCH": "0"},
        )
        if process.returncode:
            name = target.folders[1]
            raise OutputError(
                f"{command[0]} cannot compile the FMU for {name}: {process.stderr.strip()[:400]}. Check that this "
                f"compiler compiles at all, or take it off the PATH: the FMU then has no binary for {name}.",
                target=name,
            )
        return (Path(folder) / library).read_bytes()
