"""Numbers of a C export with their symbols, read from its own sources: what an ASAP2 file (A2L) describes.

The sources of the unit say all of it: structures with comments and units, tables, sizes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from dehyst.export._subject import Subject
from dehyst.export.precision import BYTES

STATE = "unit"  # what the state is called in the file, until addresses are filled in
_STRUCT = re.compile(r"(?s)typedef struct (\w+) \{\n(.*?)\n\} \1;")
_MEMBER = re.compile(r"(?s)^    (?:const )?(\w+) ([^;{}]+);(?: */\*(.*?)\*/)?", re.MULTILINE)
_SIZE = re.compile(r"(?:#define |^    )(\w+)(?: =)? (\d+)\b", re.MULTILINE)
_TABLE = re.compile(
    r"(?s)(?:/\*((?:(?!\*/).)*)\*/\n)?static const (\w+) (\w+)(\[\]|) = \{(.*?)\n\};"
)
_TUNABLE = re.compile(r"^(?:volatile )(\w+) (\w+)(\[2\]|) = ", re.MULTILINE)
AXES = {"slope": "threshold", "loading": "threshold", "before_v": "before_u", "after_v": "after_u"}
LAYOUTS = {
    "uint32_t": ("WORD", "ULONG", 0, 2**32 - 1),
    "int32_t": ("WHOLE", "SLONG", -(2**31), 2**31 - 1),
}
# Name of ASAP2, and the largest number that the core takes.
_REAL_TYPES = {"double": ("FLOAT64_IEEE", 1e100), "float": ("FLOAT32_IEEE", 1e15)}


@dataclass(frozen=True)
class CalibrationNumber:
    """A number or a table: where it is, its C type, how many, what it is, its unit and its axis."""

    path: str
    kind: str
    dimensions: tuple[int, ...]
    about: str
    unit: str
    axis: str = ""

    @property
    def count(self) -> int:
        """How many numbers."""
        return math.prod(self.dimensions)


class Sources:
    """Structures, sizes and tables of the sources of a unit."""

    def __init__(self, subject: Subject, header: str, unit_header: str, unit: str) -> None:
        self.structs = dict(_STRUCT.findall(header) + _STRUCT.findall(unit_header))
        self.sizes = {name: int(size) for name, size in _SIZE.findall(header + unit_header)}
        self.unit = unit
        self.name = subject.name
        roles = {"input": subject.input.unit, "output": subject.output.unit}
        if subject.direct:
            roles |= {"y": subject.input.unit, "u": subject.output.unit}
        # Comments of a block name a role in the place of its unit; those of a joint name the unit.
        self.units = None if subject.joint else roles

    def inside(self, kind: str, path: str, about: str = "") -> Iterator[CalibrationNumber]:
        """Yield the numbers of a structure; pointers lead to tables, which stand by themselves."""
        if kind not in self.structs:
            yield CalibrationNumber(path, kind, (), *self._about_and_unit(about))
            return
        for inner, names, words in _MEMBER.findall(self.structs[kind]):
            if "*" in names:
                continue
            for name in map(str.strip, names.split(",")):
                sizes = self._sizes_in(name)
                member = f"{path}.{name.partition('[')[0]}"
                if inner in self.structs and sizes:
                    for k in range(sizes[0]):
                        yield from self.inside(inner, f"{member}[{k}]", words)
                elif inner in self.structs:
                    yield from self.inside(inner, member, words)
                else:
                    yield CalibrationNumber(member, inner, sizes, *self._about_and_unit(words))

    def _sizes_in(self, name: str) -> tuple[int, ...]:
        """Return the sizes of an array from its declaration, where they are numbers or names of constants."""
        sizes = []
        for size in re.findall(r"\[(\w+)\]", name):
            sizes.append(self.sizes.get(size) or int(size))
        return tuple(sizes)

    def parameters(self) -> Iterator[CalibrationNumber]:
        """Yield the constants of the unit."""
        for words, kind, name, many, body in _TABLE.findall(self.unit):
            if kind in self.structs and many:
                # Each row of a table of structures begins with a brace.
                for k in range(body.count("\n    {")):
                    yield from self.inside(kind, f"{name}[{k}]", words)
            elif kind in self.structs:
                yield from self.inside(kind, name, words)
            else:
                rows = len(re.findall(r"[^\s,]+", body))
                axis = AXES.get(name.removeprefix(f"{self.name}_"), "")
                yield CalibrationNumber(
                    name,
                    kind,
                    (rows,),
                    *self._about_and_unit(words),
                    axis and f"{self.name}_{axis}",
                )

    def tunables(self) -> Iterator[CalibrationNumber]:
        """Yield what may be changed while the unit runs."""
        for kind, name, many in _TUNABLE.findall(self.unit):
            # Two pages take turns: one counts while the other is written.
            places = [name]
            if many:
                places = [f"{name}[0]", f"{name}[1]"]
            for place in places:
                yield from self.inside(kind, place, "page that counts, 0 or 1")

    def measurements(self) -> Iterator[CalibrationNumber]:
        """Yield the state of the unit."""
        yield from self.inside(f"{self.name}_state", STATE)

    def _about_and_unit(self, words: str) -> tuple[str, str]:
        """Return what a comment says, and the unit at its end."""
        about, _, end = " ".join(words.replace("*", " ").split()).rpartition("[")
        if not about:
            return end.strip(" ,"), ""
        unit = end.partition("]")[0]
        if self.units is not None:
            unit = self.units.get(unit, "")
        return about.strip(" ,"), unit


def calibration_values(subject: Subject, sources: Mapping[str, str]) -> dict[str, Any]:
    """Return what the template of the A2L file is filled with; `sources` are dehyst.h and those of the unit."""
    name = subject.name
    numbers = Sources(subject, sources["dehyst.h"], sources[f"{name}.h"], sources[f"{name}.c"])
    real, most = _REAL_TYPES[subject.real]
    parameters = list(numbers.parameters())
    flags = f"{STATE}.block.flags"
    if subject.joint:
        flags = f"{STATE}.joint.flags"
    output = f"{STATE}.block.output"
    if subject.tunable:
        # The output of the block is scaled and limited again by the tunable numbers.
        output = f"{STATE}.answer"
    return {
        "parameters": parameters,
        "axes": {parameter.axis for parameter in parameters},
        "tunables": list(numbers.tunables()),
        "measurements": list(numbers.measurements()),
        "flags": flags,
        "output": output,
        "output_limits": (subject.output.low, subject.output.high),
        "bits": subject.flag_bits,
        "layouts": {"dehyst_real": ("REAL", real, -most, most), **LAYOUTS},
        "bytes": {"dehyst_real": BYTES[subject.real], "uint32_t": 4, "int32_t": 4},
    }
