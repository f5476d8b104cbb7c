"""Target ``rust``: a crate without ``std`` and dependencies around the C sources, which its build.rs compiles."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dehyst.control.block import BLOCK_FLAGS
from dehyst.control.joint import FLAGS, SWITCHES
from dehyst.errors import ParameterError
from dehyst.export import c, core_files
from dehyst.export.budget import budget
from dehyst.export.compilers import PATIENCE, found, plain_environment, version_of
from dehyst.export.rendering import comment, render
from dehyst.export.signal import to_hex
from dehyst.export.subject import Subject
from dehyst.export.targets import Check

_WORDS = """
abstract alloc as async await become box break const continue core crate do dyn else enum extern false final fn for
gen if impl in let loop macro match mod move mut override priv proc_macro pub ref return self static std struct super
test trait true try type typeof unsafe unsized use virtual where while yield
"""
WORDS = frozenset(_WORDS.split())  # of the language, or crates that come with it
BLOCK_WORDS = (
    ("REJECTED", "The last sample was no number."),
    ("REJECTED_EVER", "Some sample since the last reset was rejected."),
    ("LIMITED", "The last sample met the limit of the input or of the output."),
    ("LIMITED_EVER", "Some sample since the last reset did."),
)
SWITCH_WORDS = (
    ("POSITION", "Switch: position control; otherwise the reference's pressure difference is applied."),
    ("INTEGRATOR", "Switch: integrator of the position loop."),
    ("COMPENSATOR", "Switch: hysteresis compensator, and the reference's `extra`."),
    ("ADAPT", "Switch: the scales of a direct inverse are learned."),
    ("DISTURBANCE", "Switch: the contact torque is fed back."),
)
FLAG_WORDS = (
    ("ANGLE_FAULT", "Flag: the angle is no number, jumps or is frozen; its prediction is used."),
    ("PRESSURE_FAULT_1", "Flag: the same of the first pressure."),
    ("PRESSURE_FAULT_2", "Flag: the same of the second pressure."),
    ("FAILED", "Flag: a fault lasted too long; valves are closed until a reset."),
    ("PRESSURE_LIMIT", "Flag: desired pressures were limited."),
    ("VALVE_LIMIT", "Flag: a valve was limited."),
    ("REFERENCE_FAULT", "Flag: the reference is no number; the last good one is held."),
    ("FAULT_EVER", "Flag: there was some fault since the reset."),
    ("LEARNED", "Flag: this period taught the adaptation something."),
)


def files(subject: Subject) -> dict[str, str | bytes]:
    """Return the crate: C sources, build.rs, library, tests and example."""
    name = subject.name
    if name in WORDS:
        raise ParameterError(
            f"--name {name!r} cannot be the name of a crate: it is a word of Rust or a crate that comes with it. "
            f"Choose another: --name {name}_unit.",
            name=name,
        )
    core = core_files.needed(subject.functions)
    sources = {f"csrc/{file}": text for file, text in {**core, **c.unit_files(subject)}.items()}
    values = c.template_values(subject) | template_values(subject)

    def made(file: str) -> str:
        return render(f"rust/{file}.j2", **values)

    excerpt = {} if subject.excerpt is None else {"tests/excerpt.hex": to_hex(subject.excerpt)}
    return {
        **sources,
        f"csrc/{name}_layout.c": made("layout.c"),
        "Cargo.toml": made("Cargo.toml"),
        "build.rs": made("build.rs"),
        "src/lib.rs": made("lib.rs"),
        "tests/bits.rs": made("bits.rs"),
        "tests/signal.hex": to_hex(subject.test),
        **excerpt,
        "examples/loop.rs": made("loop.rs"),
        "README.md": c.with_warning(made("README.md"), subject),
    }


def template_values(subject: Subject) -> dict[str, Any]:
    """Return what templates of this target are filled with, beside the values of C templates."""
    block, cost = subject.block, budget(subject)
    core = core_files.needed(subject.functions)
    functions = core_files.defined(text for file, text in core.items() if file.endswith(".c"))
    return {
        "about": json.dumps(comment(subject.title).encode("ascii", "replace").decode()),
        "arguments": [f"{name}_" if name in WORDS else name for name in (block.inputs if block else ())],
        "flags": _told(BLOCK_WORDS, BLOCK_FLAGS)
        if block
        else [*_told(SWITCH_WORDS, SWITCHES), *_told(FLAG_WORDS, FLAGS)],
        "functions": [f"{name}_float" if subject.real == "float" else name for name in functions],
        "image_words": cost.image_bytes // 4,
        "words": (cost.state_bytes + 64) // 8,  # wider pointers, gaps between members; layout.c compares
    }


def _told(words: tuple[tuple[str, str], ...], bits: Mapping[str, int]) -> list[tuple[str, int, str]]:
    """Name, bit and meaning of each constant of the crate."""
    return [(name, bits[name.lower().replace("_", "-")], meaning) for name, meaning in words]


def verify(folder: Path, subject: Subject) -> list[Check]:
    """Run the tests of the crate with cargo, without network and settings of the user's; objects go elsewhere."""
    claim = "cargo test"
    cargo = shutil.which("cargo")
    if cargo is None or not found():
        missing = "cargo" if cargo is None else "C compiler (cc, gcc or clang)"
        return [Check(claim, "skipped", f"no {missing} on this machine; on Debian: apt-get install cargo gcc")]
    with tempfile.TemporaryDirectory(prefix="dehyst-") as place:
        own = {key: os.environ[key] for key in ("RUSTUP_HOME", "RUSTUP_TOOLCHAIN") if key in os.environ}
        own |= {"CARGO_HOME": f"{place}/home", "CARGO_TARGET_DIR": f"{place}/target", "CC": next(iter(found()))}
        try:
            done = subprocess.run(
                [cargo, "test", "--offline"], cwd=folder, capture_output=True, text=True, errors="replace",
                timeout=PATIENCE, check=False, env=plain_environment() | own,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return [Check(claim, "failed", f"not finished after {PATIENCE} s")]
    said = [line.strip() for line in (done.stdout + done.stderr).splitlines()]
    if done.returncode:
        faults = [line for word in ("do not use", ": error", "error") for line in said if word in line]
        return [Check(claim, "failed", next(iter(faults), f"exit status {done.returncode}"))]
    passed = sum(int(number) for number in re.findall(r"test result: ok\. (\d+) passed", done.stdout))
    due = 1 + (folder / "tests" / "bits.rs").read_text(encoding="utf-8").count("#[test]")  # one in the documentation
    if passed != due:
        return [Check(claim, "failed", f"{passed} tests passed, due are {due}")]
    return [Check(claim, "passed", f"{passed} tests; {version_of(cargo)}", ran=True)]
