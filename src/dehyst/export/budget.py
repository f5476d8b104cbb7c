"""What a unit costs on a target: bytes of parameters and state, instructions of a step."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from dehyst.export.subject import Subject

_MEASURED = Path(__file__).resolve().parent / "instructions.json"  # written by benchmarks
# Reals of dehyst_joint and dehyst_joint_state beside their tables; bytes of counts, pointers and padding
# on a 32-bit target, by the size of a real. tests/test_export_c.py asks a compiler for such a target.
JOINT_PARAMETERS, JOINT_REST = 72, {4: 24, 8: 32}
MODEL_REST = {4: 40, 8: 48}
IMAGE_OF_DIRECT = 89  # DEHYST_JOINT_WORDS of core/dehyst.h
JOINT_REALS, JOINT_COUNTS = 132, {4: 48, 8: 64}


@dataclass(frozen=True)
class Budget:
    """Static memory, all there is: nothing is allocated, and the stack takes a few hundred bytes.

    Attributes
    ----------
    parameter_bytes
        Constant tables, on a 32-bit target.
    state_bytes
        A unit's state on a 32-bit target; some bytes more with 64-bit pointers.
    image_bytes
        A saved state; 0 if the unit has no such function.
    instructions
        Target -> instructions of a step in a slow signal, "typical", and of the slowest that was found, "most":
        straight lines over n through counts for n up to 200, compiled with -O2 (benchmarks/target.py).
    """

    parameter_bytes: int
    state_bytes: int
    image_bytes: int
    instructions: Mapping[str, Mapping[str, float]]

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return {
            "parameter_bytes": self.parameter_bytes,
            "state_bytes": self.state_bytes,
            "image_bytes": self.image_bytes,
            "instructions": {name: dict(values) for name, values in self.instructions.items()},
        }

    def lines(self) -> list[str]:
        """Return it in words, a line each."""
        steps = [f"{name}: {values['typical']:.0f} instructions a step, {values['most']:.0f} at most"
                 for name, values in self.instructions.items()]  # fmt: skip
        none = ["instructions of a step: not measured for this kind of unit; count them on your target"]
        saved = f", {self.image_bytes} bytes a saved state" if self.image_bytes else ""
        return [
            f"{self.parameter_bytes} bytes of constants, {self.state_bytes} bytes a unit{saved}; no allocation",
            *(steps or none),
        ]


def budget(subject: Subject) -> Budget:
    """Return what the unit costs."""
    size = 4 if subject.real == "float" else 8
    words = size // 4
    if subject.block is not None:
        own, offset = subject.block.bytes(size), subject.block.offset
        more = offset.bytes(size) if offset else (0, 0, 0)
        constants, state, image = (a + b for a, b in zip(own, more, strict=True))
        return Budget(constants, state, image if subject.block.saved else 0, _instructions(subject))
    assert subject.joint is not None  # one of both
    direct, model = subject.joint.direct, subject.joint.compensator
    n, points = (model.operators, sum(model.points)) if model else (0, 0)
    constants = size * (4 * n + 2 * points + JOINT_PARAMETERS) + JOINT_REST[size] + (MODEL_REST[size] if model else 0)
    reals, image_reals = n + JOINT_REALS, n + 40
    if direct is not None:
        constants += direct.bytes(size)
        reals += 2 * max(1, direct.memory)
        image_reals += IMAGE_OF_DIRECT + 2 * direct.memory
    image = 4 * (16 + words * image_reals)
    return Budget(constants, size * reals + JOINT_COUNTS[size], image, _instructions(subject))


@cache
def _measured() -> dict[str, Any]:
    return dict(json.loads(_MEASURED.read_text(encoding="utf-8"))) if _MEASURED.is_file() else {}


def _instructions(subject: Subject) -> dict[str, dict[str, float]]:
    """Straight lines a + b n through what was measured, for the kind and precision of the subject."""
    kind = subject.block.core if subject.block else "direct" if subject.direct else "joint"
    maps = sum(points > 0 for points in subject.map_points)
    found = {}
    for name, entry in _measured().get("targets", {}).items():
        line = entry.get(kind, {}).get(subject.real)
        if line:
            more = maps * entry["map"][subject.real]
            found[name] = {key: line[key][0] + line[key][1] * subject.operators + more for key in ("typical", "most")}
    return found
