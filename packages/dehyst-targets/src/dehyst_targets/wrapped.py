"""What crates of Rust and packages of Ada share: the C sources below ``csrc/`` and what wraps them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from dehyst.errors import ParameterError
from dehyst.export import Subject, c, core_files
from dehyst.export import kit as export_kit
from dehyst.models import BLOCK_FLAGS

BLOCK_WORDS = (
    ("REJECTED", "The last sample was no number."),
    ("REJECTED_EVER", "Some sample since the last reset was rejected."),
    ("LIMITED", "The last sample met the limit of the input or of the output."),
    ("LIMITED_EVER", "Some sample since the last reset did."),
)


def refuse_word(name: str, words: frozenset[str], what: str) -> None:
    """Refuse a unit's name that is a word of the language."""
    if name in words:
        raise ParameterError(
            f"--name {name!r} cannot be {what}. Choose another: --name {name}_unit.", name=name
        )


def first_fault(lines: Sequence[str], words: Sequence[str], status: int) -> str:
    """Return the first line with the first of these words that any line has, or the exit status of a program.

    Examples
    --------
    >>> first_fault(["1 error", "WRONG: state"], ("WRONG", "error"), 1), first_fault([], ("error",), 1)
    ('WRONG: state', 'exit status 1')
    """
    for word in words:
        for line in lines:
            if word in line:
                return line
    return f"exit status {status}"


def wrapped_sources(subject: Subject, values: Mapping[str, Any]) -> dict[str, str | bytes]:
    """Return the C sources, with a file that does not compile where the other language's storage does not hold."""
    files = c.source_files(subject, "csrc")
    layout = export_kit.render("wrapped/layout.c.j2", **values)
    files[f"csrc/{subject.name}_layout.c"] = layout
    return files


def wrapped_values(subject: Subject, argument: Callable[[str], str]) -> dict[str, Any]:
    """Return what templates are filled with, beside the values of C templates; `argument` names a further input."""
    cost = export_kit.budget(subject)
    arguments: list[str] = []
    if subject.block is not None:
        arguments = [argument(name) for name in subject.block.inputs]
    sources = core_files.needed(subject.functions)
    functions = core_files.defined(sources[name] for name in c.names_ending(sources, ".c"))
    if subject.real == "float":
        # dehyst_config.h gives the functions these names in single precision.
        functions = [f"{name}_float" for name in functions]
    return c.template_values(subject) | {
        "arguments": arguments,
        "flags": constants(subject),
        "functions": functions,
        "image_words": cost.image_bytes // 4,
        # 64 bytes more hold wider pointers and gaps between members; layout.c compares.
        "words": (cost.state_bytes + 64) // 8,
    }


def constants(subject: Subject) -> list[tuple[str, int, str]]:
    """Return name, bit and meaning of each constant of the unit."""
    rows = []
    if subject.controller is None:
        for name, meaning in BLOCK_WORDS:
            rows.append((name, BLOCK_FLAGS[name.lower().replace("_", "-")], meaning))
        return rows
    for kind, bits in (("Switch", subject.controller.switches), ("Flag", subject.controller.flags)):
        for name, (bit, meaning) in bits.items():
            rows.append((name.upper().replace("-", "_"), bit, f"{kind}: {meaning}."))
    return rows
