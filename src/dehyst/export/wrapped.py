"""What crates of Rust and packages of Ada share: the C sources below ``csrc/`` and what wraps them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from dehyst.control.block import BLOCK_FLAGS
from dehyst.control.joint import FLAGS, SWITCHES
from dehyst.errors import ParameterError
from dehyst.export import c, core_files
from dehyst.export.budget import budget
from dehyst.export.rendering import render
from dehyst.export.subject import Subject

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
    ("STALE", "Flag: the compensator does not fit: it is scaled down to the hysteresis that there is."),
    ("SHIFTED", "Flag: an offset of the torque, the same both ways: a pressure sensor or a weight."),
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
    words = (*_told(SWITCH_WORDS, SWITCHES), *_told(FLAG_WORDS, FLAGS))
    return c.template_values(subject) | {
        "arguments": [argument(name) for name in (block.inputs if block else ())],
        "flags": _told(BLOCK_WORDS, BLOCK_FLAGS) if block else words,
        "functions": [f"{name}_float" if subject.real == "float" else name for name in functions],
        "image_words": cost.image_bytes // 4,
        "words": (cost.state_bytes + 64) // 8,  # wider pointers, gaps between members; layout.c compares
    }


def _told(words: tuple[tuple[str, str], ...], bits: Mapping[str, int]) -> tuple[tuple[str, int, str], ...]:
    """Name, bit and meaning of each constant."""
    return tuple((name, bits[name.lower().replace("_", "-")], meaning) for name, meaning in words)
