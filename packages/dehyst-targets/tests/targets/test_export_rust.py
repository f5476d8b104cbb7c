"""The Rust target: crates of every kind of unit in one workspace, tested by cargo and linked into one program."""

import os
import re
import shutil
import subprocess
from dataclasses import replace

import pytest

from dehyst.errors import ParameterError
from dehyst.export import compilers, export, subject_of, verify
from dehyst_targets import rust
from element_samples import scheduled_model
from export_samples import play_model
from wrapped_samples import UNITS, other_precision

WITH_CARGO = pytest.mark.skipif(
    shutil.which("cargo") is None or not compilers.found(), reason="needs apt-get install cargo gcc"
)
WITH_GCC = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")


def exported(name, folder, real="double"):
    return export(UNITS[name](real), "rust", folder / name).folder


def cargo(folder, *words):
    own = {"CARGO_TARGET_DIR": str(folder / "target"), "RUSTFLAGS": "-Dwarnings"}
    return subprocess.run(
        ["cargo", *words, "--offline"],
        cwd=folder,
        capture_output=True,
        text=True,
        env=os.environ | own,
    )


@pytest.mark.exhaustive
@WITH_CARGO
@pytest.mark.parametrize("real", ["double", "float"])
def test_units_of_every_kind_have_the_models_answers_and_link_into_one_program(real, tmp_path):
    for name in UNITS:
        exported(name, tmp_path, real)
    export(other_precision(real), "rust", tmp_path / "other")
    names = [*UNITS, "other"]
    (tmp_path / "all" / "src").mkdir(parents=True)
    needs = "".join(f'{name} = {{ path = "../{name}" }}\n' for name in names)
    head = '[package]\nname = "all"\nversion = "0.1.0"\nedition = "2021"\n\n[dependencies]\n'
    (tmp_path / "all" / "Cargo.toml").write_text(head + needs)
    calls = "".join(
        f"    let _ = {name}::Unit::new({'&Default::default()' if name in ('axis', 'taught') else ''});\n"
        for name in names
    )
    (tmp_path / "all" / "src" / "main.rs").write_text(
        f'fn main() {{\n{calls}    println!("linked");\n}}\n'
    )
    (tmp_path / "Cargo.toml").write_text(
        f"[workspace]\nmembers = {[*names, 'all']}\n".replace("'", '"')
    )
    done = cargo(tmp_path, "test", "--workspace")
    assert done.returncode == 0, done.stdout + done.stderr
    due = sum(
        (tmp_path / name / "tests" / "bits.rs").read_text().count("#[test]") + 1 for name in names
    )
    assert sum(map(int, re.findall(r"ok\. (\d+) passed", done.stdout))) == due
    assert cargo(tmp_path, "run", "-q", "-p", "all").stdout == "linked\n"
    for name in ("sums", "axis"):
        table = cargo(tmp_path, "run", "-q", "-p", name, "--example", "loop")
        assert table.returncode == 0 and table.stdout.count("\n") > 10, table.stderr


@pytest.mark.slow
@WITH_CARGO
def test_a_unit_that_computes_something_else_is_noticed(tmp_path):
    folder = exported("taught", tmp_path)
    assert all(check.ok for check in verify(folder))
    source = folder / "csrc" / "taught.c"
    text = source.read_text()
    assert text.count("0x1.8") > 0
    source.write_text(text.replace("0x1.8", "0x1.9", 1))
    assert not all(check.ok for check in verify(folder))
    done = cargo(folder, "test")
    assert done.returncode != 0 and "do not use this build" in done.stdout


@pytest.mark.slow
@WITH_GCC
@pytest.mark.parametrize("real", ["double", "float"])
def test_storage_holds_the_state_and_too_little_does_not_compile(real, tmp_path):
    compiler = [
        ["gcc"],
        *(
            [["arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mthumb"]]
            * bool(shutil.which("arm-none-eabi-gcc"))
        ),
    ]
    for name in UNITS:
        folder = exported(name, tmp_path, real)
        layout = folder / "csrc" / f"{name}_layout.c"
        words = re.search(
            r"struct State\(\[u64; (\d+)\]\)", (folder / "src" / "lib.rs").read_text()
        )[1]
        for command in compiler:
            check = [*command, "-std=c99", "-fsyntax-only", layout]
            assert subprocess.run(check, capture_output=True).returncode == 0
        text = layout.read_text()
        assert f"<= 8 * {words})" in text
        layout.write_text(text.replace(f"<= 8 * {words})", "<= 8 * 5)"))
        assert (
            b"state_fits"
            in subprocess.run(["gcc", "-fsyntax-only", layout], capture_output=True).stderr
        )


def test_the_crate_needs_no_std_no_other_crate_and_has_every_word_explained(tmp_path):
    for name in ("plays", "axis"):
        folder = exported(name, tmp_path)
        assert (folder / "Cargo.toml").read_text().endswith("[dependencies]\n")
        library = (folder / "src" / "lib.rs").read_text()
        assert "#![no_std]\n#![deny(missing_docs)]\n" in library and "std::" not in library
        assert {path.name for path in (folder / "csrc").glob("*.c")} >= {
            f"{name}.c",
            f"{name}_layout.c",
        }
        assert re.search(r'"dehyst_\w+_reset"', (folder / "build.rs").read_text())


@pytest.mark.parametrize("name", ["loop", "match", "crate", "core"])
def test_a_word_of_rust_is_no_name_and_the_cure_is_said(name, tmp_path):
    with pytest.raises(ParameterError, match=f"--name {name}_unit"):
        export(subject_of(play_model(), name=name), "rust", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_an_input_that_is_a_word_of_rust_is_written_otherwise(tmp_path):
    subject = subject_of(scheduled_model(), "forward", name="unit_1")
    named = replace(
        subject,
        numbers=replace(
            subject.numbers, given=("type", "match", "load")[: len(subject.numbers.given)]
        ),
    )
    library = rust.WRITER.files(named)["src/lib.rs"]
    assert "type_: Real" in library and "match_: Real" in library


def test_without_cargo_it_is_skipped_by_name(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda *_, **__: None)
    (check,) = rust.WRITER.verify(tmp_path, UNITS["plays"]("double"))
    assert (check.claim, check.status) == (
        "cargo test",
        "skipped",
    ) and "apt-get install cargo" in check.detail
