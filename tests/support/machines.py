"""The numeric part of the suite as other machines would run it, on this one.

    python tests/support/machines.py                          every machine of the list that this processor can be
    python tests/support/machines.py nehalem tests/test_x.py  one of them, on some files

Each machine is a set of environment variables: the kernels of OpenBLAS (numpy's and scipy's), what numpy and the C
library may use of the processor, the engine's instruction set, threads, time zone, locale, seed of hashes, and a HOME
that cannot be written. What a processor lacks is said and not run. Ends with status 1 if a test fails on any machine.
"""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from places import ROOT

# Where results are computed and shown: choices, tables, pages.
NUMERIC = (
    "test_docs.py", "test_doctests.py", "test_example.py", "test_printed.py", "test_compare.py", "test_ties.py",
    "test_direct_inverse.py", "test_identify_direct.py", "test_identification_*.py", "test_experiment_direct.py",
    "test_experiment_identification.py", "test_drift.py", "test_design_excitation.py", "test_engine_evaluate.py",
    "test_engine_active_set.py", "test_families_conformity.py", "test_families_preisach.py", "test_muscle_fit.py",
    "test_unknown_memory.py", "test_real_logs*.py", "test_report.py", "test_io_text.py", "test_cli.py",
)  # fmt: skip
# Pages and figures that only quote what the other tests compute, or take minutes for their plots.
LEFT_OUT = "not generated and not figure and not demo and not key_of"

# Run at the start of every Python below: the engine has no variable of its own, and needs none.
STARTS = """import os
try:
    from dehyst import _native
    _native.engine_use_level(min(int(os.environ["ENGINE_LEVEL"]), _native.engine_best_level()))
except ImportError:  # another Python than that of the tests
    pass
"""


@dataclass(frozen=True)
class Machine:
    """What is set for a machine.

    Attributes
    ----------
    core
        OPENBLAS_CORETYPE.
    needs
        Instructions, as /proc/cpuinfo calls them, without which its kernels end with a signal.
    level
        Of the engine: 0 portable, 1 AVX2, 2 AVX-512.
    without
        Instructions that numpy and the C library must do without.
    threads, zone, language, seed
        OMP_NUM_THREADS, TZ, LC_ALL, PYTHONHASHSEED.
    """

    core: str
    needs: frozenset[str] = field(default_factory=frozenset)
    level: int = 0
    without: str = ""
    threads: int = 1
    zone: str = "UTC"
    language: str = "C"
    seed: int = 0


AVX512 = frozenset({"avx512f", "avx512dq", "avx512bw", "avx512vl"})
X86 = {
    "haswell": Machine(
        "Haswell", frozenset({"avx2", "fma"}), 1, "AVX512", 1, "Asia/Kolkata", "tr_TR.UTF-8", 1
    ),
    "nehalem": Machine("Nehalem", frozenset(), 0, "AVX2", 2, "Pacific/Apia", "C", 2),
    "skylake": Machine("SkylakeX", AVX512, 2, "", 2, "America/St_Johns", "C.UTF-8", 3),
}
ARM = {
    "armv8": Machine("ARMV8", threads=1, zone="Asia/Kolkata", language="tr_TR.UTF-8", seed=1),
    "neoverse": Machine("NEOVERSEN1", threads=2, zone="Pacific/Apia", seed=2),
}
MACHINES = {"x86_64": X86, "aarch64": ARM}.get(platform.machine(), {})
GLIBC = {"": "", "AVX512": "-AVX512F,-AVX512VL", "AVX2": "-AVX512F,-AVX512VL,-AVX2,-FMA,-FMA4"}


def processor() -> set[str]:
    """Instructions of this processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return set()
    return {
        word
        for line in lines
        if line.startswith(("flags", "Features"))
        for word in line.split(":")[1].split()
    }


def dispatched(without: str) -> str:
    """Names that this numpy gives to what it must do without: AVX2, or X86_V3 since 2.4."""
    try:
        from numpy._core import _multiarray_umath as numpy_core
    except ImportError:  # numpy 1
        from numpy.core import _multiarray_umath as numpy_core  # type: ignore[no-redef]
    parts = {"": (), "AVX512": ("AVX512", "X86_V4"), "AVX2": ("AVX", "FMA", "X86_V3", "X86_V4")}[
        without
    ]
    return " ".join(name for name in numpy_core.__cpu_dispatch__ if name.startswith(parts or "-"))


def settings(machine: Machine, folder: Path) -> dict[str, str]:
    """Environment variables of a machine, with what they need in a folder."""
    (folder / "sitecustomize.py").write_text(STARTS, encoding="utf-8")
    language, localedef = machine.language, shutil.which("localedef")
    if "_" in language:  # made here, because few machines have it
        make = [localedef, "-i", language.partition(".")[0], "-f", "UTF-8", folder / language]
        made = (
            localedef is not None
            and subprocess.run(make, capture_output=True, check=False).returncode == 0
        )
        language = language if made else "C"
    return {
        "OPENBLAS_CORETYPE": machine.core,
        "OMP_NUM_THREADS": str(machine.threads),
        "OPENBLAS_NUM_THREADS": str(machine.threads),
        "NPY_DISABLE_CPU_FEATURES": dispatched(machine.without),
        "GLIBC_TUNABLES": f"glibc.cpu.hwcaps={GLIBC[machine.without]}" if machine.without else "",
        "ENGINE_LEVEL": str(machine.level),
        "EXAMPLES": "120",
        "PYTHONPATH": os.pathsep.join(
            filter(None, [str(folder), os.environ.get("PYTHONPATH", "")])
        ),
        "PYTHONHASHSEED": str(machine.seed),
        "TZ": machine.zone,
        "LC_ALL": language,
        "LOCPATH": str(folder) if "_" in language else "",
        "HOME": str(
            folder / "sitecustomize.py" / "home"
        ),  # below a file nobody can write, root neither
    }


def files() -> list[str]:
    """Files of the numeric part."""
    return sorted(
        {
            str(path.relative_to(ROOT))
            for name in NUMERIC
            for path in sorted(
                [*ROOT.glob(f"tests/{name}"), *ROOT.glob(f"packages/*/tests/*/{name}")]
            )
        }
    )


def run(name: str, arguments: list[str]) -> bool | None:
    """Run the tests on a machine; None if this processor cannot be that machine."""
    machine = MACHINES[name]
    missing = machine.needs - processor()
    if missing:
        print(f"{name}: not run, this processor has no {', '.join(sorted(missing))}", flush=True)
        return None
    with tempfile.TemporaryDirectory() as place:
        given = {key: value for key, value in settings(machine, Path(place)).items() if value}
        print(f"{name}: {' '.join(f'{key}={value}' for key, value in given.items())}", flush=True)
        tests = arguments or ["-n", "auto", "--dist", "worksteal", "-k", LEFT_OUT, *files()]
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *tests]
        return (
            subprocess.run(command, cwd=ROOT, env=os.environ | given, check=False).returncode == 0
        )


def main() -> int:
    """Run the machines that are named, or all."""
    arguments = sys.argv[1:]
    names = [arguments.pop(0)] if arguments and arguments[0] in MACHINES else list(MACHINES)
    results = {name: run(name, arguments) for name in names}
    print(
        "; ".join(
            f"{name}: { {True: 'ok', False: 'FAILED', None: 'not run'}[ok] }"
            for name, ok in results.items()
        )
    )
    return 1 if False in results.values() else 0


if __name__ == "__main__":
    sys.exit(main())
