"""What crates of Rust and packages of Ada share: the C sources below ``csrc/`` and what wraps them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from dehyst.errors import ParameterError
from dehyst.export import c, core_files
from dehyst.export.budget import budget
from dehyst.export.rendering import render
from dehyst.export.subject import Subject
from dehyst.models.block import BLOCK_FLAGS

BLOCK_WORDS = (
    ("REJECTED", "The last sample was no number."),
    ("REJECTED_EVER", "Some sample since the last reset was rejected."),
    ("LIMITED", "The last sample met the limit of the input or of the output."),
    ("LIMITED_EVER", "Some sample since the last reset did."),
)


def refuse_word(name: str, words: frozenset[str], what: str) -> None:
    """Refuse a unit's name that is a word of the language."""
    if name in words:
        raise ParameterError(f"--name {name!r} cannot be {what}. Choose another: --name {name}_unit.", name=name)


def sources(subject: Subject, values: Mapping[str, Any]) -> dict[str, str | bytes]:
    """Return the C sources, with a file that does not compile where the other language's storage does not hold."""
    files = {**core_files.needed(subject.functions), **c.unit_files(subject)}
    files[f"{subject.name}_layout.c"] = render("wrapped/layout.c.j2", **values)
    return {f"csrc/{file}": text for file, text in files.items()}


def template_values(subject: Subject, argument: Callable[[str], str]) -> dict[str, Any]:
    """Return what templates are filled with, beside the values of C templates; `argument` names a further input."""
    block, cost = subject.block, budget(subject)
    core = core_files.needed(subject.functions)
    functions = core_files.defined(text for file, text in core.items() if file.endswith(".c"))
    return c.template_values(subject) | {
        "arguments": [argument(name) for name in (block.inputs if block else ())],
        "flags": constants(subject),
        "functions": [f"{name}_float" if subject.real == "float" else name for name in functions],
        "image_words": cost.image_bytes // 4,
        "words": (cost.state_bytes + 64) // 8,  # wider pointers, gaps between members; layout.c compares
    }


def constants(subject: Subject) -> list[tuple[str, int, str]]:
    """Return name, bit and meaning of each constant of the unit."""
    if subject.controller is None:
        return [(name, BLOCK_FLAGS[name.lower().replace("_", "-")], meaning) for name, meaning in BLOCK_WORDS]
    rows = []
    for kind, bits in (("Switch", subject.controller.switches), ("Flag", subject.controller.flags)):
        for name, (bit, meaning) in bits.items():
            rows.append((name.upper().replace("-", "_"), bit, f"{kind}: {meaning}."))
    return rows
