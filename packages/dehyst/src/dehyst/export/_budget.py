"""What an exported unit costs on a target: bytes of parameters and state, instructions of a step."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from dehyst.export._numbers import Map
from dehyst.export._subject import Subject
from dehyst.export.precision import BYTES

# Clock in Hz of a usual chip with the core, by its data sheet: STM32F405, STM32H743. At best one instruction a cycle.
CLOCKS = {"cortex-m4f": 168e6, "cortex-m7": 480e6}
_MEASURED = Path(__file__).resolve().parent / "instructions.json"  # written by benchmarks


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
        Target -> instructions of a step in a slow signal, "typical", and of the slowest that was found, "most", that
        after a reset included: sums over operators, terms or elements that lie above everything that was counted,
        compiled with -O2 (benchmarks/target.py).
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

    def seconds(self) -> dict[str, tuple[float, float]]:
        """Target -> time of a step, typical and at most, at its clock in `CLOCKS` and one instruction a cycle."""
        times = {}
        for name, values in self.instructions.items():
            if name in CLOCKS:
                times[name] = (values["typical"] / CLOCKS[name], values["most"] / CLOCKS[name])
        return times

    def lines(self) -> list[str]:
        """Return it in words, a line each."""
        memory = f"{self.parameter_bytes} bytes of constants, {self.state_bytes} bytes a unit"
        if self.image_bytes:
            memory += f", {self.image_bytes} bytes a saved state"
        lines = [f"{memory}; no allocation"]
        for name, values in self.instructions.items():
            typical, most = values["typical"], values["most"]
            lines.append(f"{name}: {typical:.0f} instructions a step, {most:.0f} at most")
        if not self.instructions:
            lines.append(
                "instructions of a step: not measured for this kind of unit; count them on your target"
            )
        return lines


def budget(subject: Subject) -> Budget:
    """Return what the unit costs."""
    size = BYTES[subject.real]
    constants, state, image = subject.numbers.bytes(size)
    if subject.tunable and subject.block:
        # Two pages of tunable numbers, and where it is used the map behind, backwards.
        constants += size * 10
        back = _back(subject)
        if back:
            constants += size * 2 * len(back[0]) + 12
        state += 2 * size
    return Budget(constants, state, image, _instructions(subject))


def _back(subject: Subject) -> Map | None:
    """Return the map behind, backwards, that limits which were tuned are taken through: only an inverse holds back."""
    if subject.block is None or not subject.tunable or subject.what != "inverse":
        return None
    return subject.block.back


@cache
def _measured() -> dict[str, Any]:
    # Before the first count there is no file, and the budget says that nothing was measured.
    if not _MEASURED.is_file():
        return {}
    return dict(json.loads(_MEASURED.read_text(encoding="utf-8")))


def _instructions(subject: Subject) -> dict[str, dict[str, float]]:
    """Return sums over what a step does, each part with the cost that was measured."""
    kind, counts = subject.numbers.work
    counts = {**counts, "tunable": int(subject.tunable)}
    # At worst both limits were tuned and are taken through the map behind.
    most = {**counts, "maps": counts.get("maps", 0) + 2 * (_back(subject) is not None)}
    if subject.direct:
        for part, count in subject.direct.strokes.items():
            most[part] += count
    instructions = {}
    for name, entry in _measured().get("targets", {}).items():
        costs = entry.get(kind, {}).get(subject.real)
        if costs:
            instructions[name] = {
                "typical": _sum(costs["typical"], counts),
                "most": _sum(costs["most"], most),
            }
    return instructions


def _sum(cost: Mapping[str, float], counts: Mapping[str, int]) -> float:
    total = cost["step"]
    for part, count in counts.items():
        # A part that a unit does not have need not have been measured.
        if count:
            total += cost[part] * count
    return total
