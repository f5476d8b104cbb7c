"""Numbers of a C export with their symbols, read from its own sources: what an ASAP2 file (A2L) describes.

The sources of the unit say all of it: structures with comments and units, tables, sizes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from dehyst.export.precision import BYTES
from dehyst.export.subject import Subject

STATE = "unit"  # what the state is called in the file, until addresses are filled in
_STRUCT = re.compile(r"(?s)typedef struct (\w+) \{\n(.*?)\n\} \1;")
_MEMBER = re.compile(r"(?s)^    (?:const )?(\w+) ([^;{}]+);(?: */\*(.*?)\*/)?", re.MULTILINE)
_SIZE = re.compile(r"(?:#define |^    )(\w+)(?: =)? (\d+)\b", re.MULTILINE)
_TABLE = re.compile(r"(?s)(?:/\*((?:(?!\*/).)*)\*/\n)?static const (\w+) (\w+)(\[\]|) = \{(.*?)\n\};")
_TUNABLE = re.compile(r"^(?:volatile )(\w+) (\w+)(\[2\]|) = ", re.MULTILINE)
AXES = {"slope": "threshold", "loading": "threshold", "before_v": "before_u", "after_v": "after_u"}
LAYOUTS = {"uint32_t": ("WORD", "ULONG", 0, 2**32 - 1), "int32_t": ("WHOLE", "SLONG", -(2**31), 2**31 - 1)}


@dataclass(frozen=True)
class Number:
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
        self.unit, self.name = unit, subject.name
        roles = {"input": subject.input.unit, "output": subject.output.unit}
        if subject.direct:
            roles |= {"y": subject.input.unit, "u": subject.output.unit}
        self.units = None if subject.joint else roles  # a joint's are written out

    def inside(self, kind: str, path: str, about: str = "") -> Iterator[Number]:
        """Yield the numbers of a structure; pointers lead to tables, which stand by themselves."""
        if kind not in self.structs:
            yield Number(path, kind, (), *self._told(about))
            return
        for inner, names, words in _MEMBER.findall(self.structs[kind]):
            for name in (one.strip() for one in names.split(",") if "*" not in names):
                sizes = tuple(self.sizes.get(size) or int(size) for size in re.findall(r"\[(\w+)\]", name))
                member = f"{path}.{name.partition('[')[0]}"
                if inner in self.structs and sizes:
                    for k in range(sizes[0]):
                        yield from self.inside(inner, f"{member}[{k}]", words)
                elif inner in self.structs:
                    yield from self.inside(inner, member, words)
                else:
                    yield Number(member, inner, sizes, *self._told(words))

    def parameters(self) -> Iterator[Number]:
        """Yield the constants of the unit."""
        for words, kind, name, many, body in _TABLE.findall(self.unit):
            rows = body.count("\n    {") if kind in self.structs else len(re.findall(r"[^\s,]+", body))
            if kind in self.structs:
                for k in range(rows if many else 1):
                    yield from self.inside(kind, f"{name}[{k}]" if many else name, words)
            else:
                axis = AXES.get(name.removeprefix(f"{self.name}_"), "")
                yield Number(name, kind, (rows,), *self._told(words), axis and f"{self.name}_{axis}")

    def tunables(self) -> Iterator[Number]:
        """Yield what may be changed while the unit runs."""
        for kind, name, many in _TUNABLE.findall(self.unit):
            for k in range(2 if many else 1):
                yield from self.inside(kind, f"{name}[{k}]" if many else name, "page that counts, 0 or 1")

    def measurements(self) -> Iterator[Number]:
        """Yield the state of the unit."""
        yield from self.inside(f"{self.name}_state", STATE)

    def _told(self, words: str) -> tuple[str, str]:
        """What a comment says, and the unit at its end."""
        about, _, rest = " ".join(words.replace("*", " ").split()).rpartition("[")
        unit = rest.partition("]")[0] if about else ""
        return (about or rest).strip(" ,"), unit if self.units is None else self.units.get(unit, "")


def calibration_values(subject: Subject, sources: Mapping[str, str]) -> dict[str, Any]:
    """Return what the template of the A2L file is filled with; `sources` are dehyst.h and those of the unit."""
    found = Sources(subject, sources["dehyst.h"], sources[f"{subject.name}.h"], sources[f"{subject.name}.c"])
    real, most = ("FLOAT64_IEEE", 1e100) if subject.real == "double" else ("FLOAT32_IEEE", 1e15)
    parameters = list(found.parameters())
    return {
        "parameters": parameters,
        "axes": {one.axis for one in parameters},
        "tunables": list(found.tunables()),
        "measurements": list(found.measurements()),
        "flags": f"{STATE}.joint.flags" if subject.joint else f"{STATE}.block.flags",
        "output": f"{STATE}.answer" if subject.tunable else f"{STATE}.block.output",
        "output_limits": (subject.output.low, subject.output.high),
        "bits": subject.flag_bits,
        "layouts": {"dehyst_real": ("REAL", real, -most, most), **LAYOUTS},
        "bytes": {"dehyst_real": BYTES[subject.real], "uint32_t": 4, "int32_t": 4},
    }
