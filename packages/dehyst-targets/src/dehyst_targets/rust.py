"""Target ``rust``: a crate without ``std`` and dependencies around the C sources, which its build.rs compiles."""

from __future__ import annotations

import json
import os
import re
import shutil
import tempfile
from pathlib import Path

from dehyst.export import Check, Subject, c, found
from dehyst.export import kit as export_kit
from dehyst_targets import wrapped

_WORDS = """
abstract alloc as async await become box break const continue core crate do dyn else enum extern false final fn for
gen if impl in let loop macro match mod move mut override priv proc_macro pub ref return self static std struct super
test trait true try type typeof unsafe unsized use virtual where while yield
"""
# Words of the language, and crates that come with it.
WORDS = frozenset(_WORDS.split())
_CLAIM = "cargo test"
_FAULTS = ("do not use", ": error", "error")


def _files(subject: Subject) -> dict[str, str | bytes]:
    """Return the crate: C sources, build.rs, library, tests and example."""
    wrapped.refuse_word(
        subject.name,
        WORDS,
        "the name of a crate: it is a word of Rust or a crate that comes with it",
    )
    title = export_kit.comment(subject.title).encode("ascii", "replace").decode()
    values = wrapped.wrapped_values(subject, _argument)
    values |= {"about": json.dumps(title), "language": "Rust", "binding": "src/lib.rs"}

    def text_of(file: str) -> str:
        return export_kit.render(f"rust/{file}.j2", **values)

    files = {
        **wrapped.wrapped_sources(subject, values),
        "Cargo.toml": text_of("Cargo.toml"),
        "build.rs": text_of("build.rs"),
        "src/lib.rs": text_of("lib.rs"),
        "tests/bits.rs": text_of("bits.rs"),
        "tests/signal.hex": export_kit.to_hex(subject.test),
        "examples/loop.rs": text_of("loop.rs"),
        "README.md": c.with_warning(text_of("README.md"), subject),
    }
    if subject.excerpt is not None:
        files["tests/excerpt.hex"] = export_kit.to_hex(subject.excerpt)
    return files


def _argument(word: str) -> str:
    """Return the name of a further input; a word of the language gets an underscore."""
    if word in WORDS:
        return f"{word}_"
    return word


def _verify(folder: Path, subject: Subject) -> list[Check]:
    """Run the tests of the crate with cargo, without network and settings of the user's; objects go elsewhere."""
    cargo = shutil.which("cargo")
    compilers = found()
    if cargo is None:
        return [_skipped("cargo")]
    if not compilers:
        return [_skipped("C compiler (cc, gcc or clang)")]
    with tempfile.TemporaryDirectory(prefix="dehyst-") as place:
        environment = {
            "CARGO_HOME": f"{place}/home",
            "CARGO_TARGET_DIR": f"{place}/target",
            "CC": next(iter(compilers)),
        }
        # cargo may be the one of rustup, which finds its toolchain by these.
        for key in ("RUSTUP_HOME", "RUSTUP_TOOLCHAIN"):
            if key in os.environ:
                environment[key] = os.environ[key]
        # The crate depends on no other, so that cargo needs no network.
        run = export_kit.run_program([cargo, "test", "--offline"], folder, environment)
    if run is None:
        return [Check(_CLAIM, "failed", f"not finished after {export_kit.PATIENCE} s")]
    if run.returncode:
        lines = [line.strip() for line in (run.stdout + run.stderr).splitlines()]
        return [Check(_CLAIM, "failed", wrapped.first_fault(lines, _FAULTS, run.returncode))]
    return [_judged(folder, run.stdout, cargo)]


def _skipped(tool: str) -> Check:
    why = f"no {tool} on this machine; on Debian: apt-get install cargo gcc"
    return Check(_CLAIM, "skipped", why)


def _judged(folder: Path, printed: str, cargo: str) -> Check:
    """Compare the number of tests that passed with the number in the sources."""
    passed = sum(map(int, re.findall(r"test result: ok\. (\d+) passed", printed)))
    # One test more stands in the documentation of the library.
    due = 1 + (folder / "tests" / "bits.rs").read_text(encoding="utf-8").count("#[test]")
    if passed != due:
        return Check(_CLAIM, "failed", f"{passed} tests passed, due are {due}")
    return Check(_CLAIM, "passed", f"{passed} tests; {export_kit.version_of(cargo)}", ran=True)


WRITER = export_kit.Writer(_files, _verify)
