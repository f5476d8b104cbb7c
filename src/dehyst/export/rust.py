"""Target ``rust``: a crate without ``std`` and dependencies around the C sources, which its build.rs compiles."""

from __future__ import annotations

import json
import os
import re
import shutil
import tempfile
from pathlib import Path

from dehyst.export import c, wrapped
from dehyst.export.compilers import PATIENCE, found, run, version_of
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


def files(subject: Subject) -> dict[str, str | bytes]:
    """Return the crate: C sources, build.rs, library, tests and example."""
    name = subject.name
    wrapped.refuse_word(name, WORDS, "the name of a crate: it is a word of Rust or a crate that comes with it")
    about = json.dumps(comment(subject.title).encode("ascii", "replace").decode())
    values = wrapped.template_values(subject, lambda word: f"{word}_" if word in WORDS else word)
    values |= {"about": about, "language": "Rust", "binding": "src/lib.rs"}

    def made(file: str) -> str:
        return render(f"rust/{file}.j2", **values)

    excerpt = {} if subject.excerpt is None else {"tests/excerpt.hex": to_hex(subject.excerpt)}
    return {
        **wrapped.sources(subject, values),
        "Cargo.toml": made("Cargo.toml"),
        "build.rs": made("build.rs"),
        "src/lib.rs": made("lib.rs"),
        "tests/bits.rs": made("bits.rs"),
        "tests/signal.hex": to_hex(subject.test),
        **excerpt,
        "examples/loop.rs": made("loop.rs"),
        "README.md": c.with_warning(made("README.md"), subject),
    }


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
        done = run([cargo, "test", "--offline"], folder, own)
    if done is None:
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
