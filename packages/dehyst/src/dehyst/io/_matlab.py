"""MAT files of version 4, 6 and 7: vectors, matrices, structs, strings, Simulink's structure with time.

A struct field becomes ``struct.field``; a signal of Simulink's structure with time takes its label. Compiled readers of
this format can crash the interpreter on a damaged file (docs/decisions/0007-own-reader-of-mat-files.md); this one
checks every length before it reads. Layout after the public description "MAT-File Format" of The MathWorks.
"""

from __future__ import annotations

import math
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.findings import Finding
from dehyst.io._collect import Collector, strings_of
from dehyst.io._foreign import refuse_bomb
from dehyst.shell import visible

MAX_DEPTH = 6  # of structs and cells that are looked into
MAX_ITEMS = 200  # of a cell or a struct array
MAX_NESTED = 16  # a file that nests deeper is damaged
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
TEXT_TYPES = {16: "utf-8", 17: "utf-16", 18: "utf-32"}
OLD_TYPES = ("f8", "f4", "i4", "i2", "u2", "u1")
NAMES = (1, 2, 16)  # types of the letters of a name
MATRIX, COMPRESSED = 14, 15
CELL, STRUCT, OBJECT, CHAR = 1, 2, 3, 4
NUMERIC = range(6, 16)
_SAVE = "save('log.mat', '-struct', 's')"
# Class of an object -> the line of MATLAB that saves its numbers; {0} is the variable.
CURES = {
    "table": "type: s = table2struct({0}, 'ToScalar', true); " + _SAVE,
    "timetable": "type: s = table2struct(timetable2table({0}, 'ConvertRowTimes', false), 'ToScalar', true); "
    "s.time = seconds({0}.Properties.RowTimes - {0}.Properties.RowTimes(1)); " + _SAVE,
    "timeseries": "type: s = struct('time', {0}.Time, 'data', squeeze({0}.Data)); save('log.mat', 's')",
    "string": "type: {0} = cellstr({0}); and save it again",
    "categorical": "type: {0} = cellstr({0}); and save it again",
    "datetime": "type: {0} = seconds({0} - {0}(1)); and save it again",
    "duration": "type: {0} = seconds({0}); and save it again",
    "containers.Map": "type: s = cell2struct(values({0}), matlab.lang.makeValidName(keys({0})), 2); "
    + _SAVE,
    "dictionary": "type: s = cell2struct(num2cell(values({0})), cellstr(keys({0})), 1); " + _SAVE,
    "Simulink.SimulationData.Dataset": "take one signal: ts = {0}{{1}}.Values; s = struct('time', ts.Time, 'data', "
    "squeeze(ts.Data)); save('log.mat', 's')",
    "Simulink.SimulationOutput": "take one signal: ts = {0}.logsout{{1}}.Values; s = struct('time', ts.Time, 'data', "
    "squeeze(ts.Data)); save('log.mat', 's')",
}


# For an object of any other class.
CURE_OF_SIGNALS = (
    "for a signal, save its numbers: s = struct('time', {0}.Time, 'data', {0}.Data); "
    "save('log.mat', 's')"
)


@dataclass(frozen=True)
class Opaque:
    """An object that only MATLAB can read, of a class."""

    kind: str


class MatlabText(list[str]):
    """Rows of a character array."""


class DamageError(ValueError):
    """The bytes contradict the format."""


def fill(collector: Collector, data: bytes, path: Path) -> None:
    """Add every variable of a file."""
    recent = data.startswith(b"MATLAB")
    variables = _variables(data, collector.name) if recent else _old_variables(data)
    for key, value in variables.items():
        _walk(collector, key, value, 0)


def _walk(collector: Collector, path: str, value: Any, depth: int) -> None:
    """Add what a variable holds: an array, `Text`, a list of cells, a list of structs, None, or `Opaque`."""
    if depth > MAX_DEPTH:
        return
    if isinstance(value, Opaque):
        note_object(collector, path, value.kind)
    elif isinstance(value, np.ndarray):
        collector.add(path, value)
    elif isinstance(value, MatlabText):
        if len(value) > 1:
            collector.add(path, np.array(value, dtype=np.str_))
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        if len(value) == 1:
            _walk_struct(collector, path, value[0], depth)
            return
        for k, item in enumerate(value[:MAX_ITEMS], 1):
            _walk_struct(collector, f"{path}({k})", item, depth)
    elif isinstance(value, list):
        texts = strings_of([_single_text(cell) or cell for cell in value])
        if texts is not None:
            collector.add(path, texts)
            return
        for k, cell in enumerate(value[:MAX_ITEMS], 1):
            _walk(collector, f"{path}{{{k}}}", cell, depth + 1)


def _walk_struct(collector: Collector, path: str, item: dict[str, Any], depth: int) -> None:
    is_signal = "values" in item
    label = _single_text(item.get("label"))
    for field, value in item.items():
        if field == "values" and label:
            # signals(k).values named by its label, beside the time of the struct above
            _walk(collector, f"{path.rpartition('.')[0] or path}.{label}", value, depth + 1)
        elif not is_signal or field not in {"label", "blockName"}:
            _walk(collector, f"{path}.{field}", value, depth + 1)


def _single_text(value: Any) -> str:
    if isinstance(value, MatlabText) and len(value) == 1:
        return value[0]
    return ""


def note_object(collector: Collector, path: str, kind: str = "") -> None:
    """Say which variable is a MATLAB object that only MATLAB can read, and how to save it."""
    name, whereabouts = "x", f"of the file {collector.name}"
    if path and path != "None":
        name, whereabouts = path, f"{path} in {collector.name}"
    of_class = ""
    if kind:
        of_class = f" of class {kind}"
    cure = CURES.get(kind, CURE_OF_SIGNALS)
    message = (
        f"a variable {whereabouts} is a MATLAB object{of_class}, which only MATLAB can read. In MATLAB, "
        f"{cure.format(name)}"
    )
    collector.findings.append(Finding("matlab-object", message))


@dataclass
class _Cursor:
    """A place in bytes that never moves past their end."""

    data: memoryview
    order: str
    place: int = 0

    @property
    def ended(self) -> bool:
        return self.place >= len(self.data)

    def take(self, size: int) -> memoryview:
        if size < 0 or self.place + size > len(self.data):
            raise DamageError(f"{size} bytes wanted at {self.place} of {len(self.data)}")
        part = self.data[self.place : self.place + size]
        self.place += size
        return part

    def element(self) -> tuple[int, memoryview]:
        """Type and bytes of the next data element; short ones share the 8 bytes of their tag."""
        first, second = struct.unpack(self.order + "II", self.take(8))
        if first >> 16:
            if first >> 16 > 4:
                raise DamageError("a short element of more than 4 bytes")
            return first & 0xFFFF, self.data[self.place - 4 : self.place - 4 + (first >> 16)]
        part = self.take(second)
        if first != COMPRESSED:
            # Filled up to eights of its own: a packed variable before it may have ended anywhere.
            self.place = min(len(self.data), self.place + -second % 8)
        return first, part

    def numbers(self) -> npt.NDArray[Any]:
        kind, part = self.element()
        if kind not in TYPES:
            raise DamageError(f"type {kind} where numbers belong")
        return np.frombuffer(part, dtype=self.order + TYPES[kind])

    def string(self) -> str:
        return bytes(self.element()[1]).decode("ascii", "replace").rstrip("\0")


def _variables(data: bytes, name: str) -> dict[str, Any]:
    """Variables of version 6 or 7; `DamageError` or what struct and zlib say of a damaged file."""
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if order is None:
        raise DamageError("no byte order at 126")
    cursor = _Cursor(memoryview(data), order, 128)
    variables: dict[str, Any] = {}
    unpacked = 0
    while not cursor.ended:
        kind, part = cursor.element()
        if kind == COMPRESSED:
            expander = zlib.decompressobj()
            room = max(64 << 20, 100 * len(data)) - unpacked
            raw = expander.decompress(part, max(1, room) + 1)
            unpacked += len(raw)
            refuse_bomb(unpacked, len(data), name)
            if not expander.eof:
                raise DamageError("a packed variable ends early")
            kind, part = _Cursor(memoryview(raw), order).element()
        if kind == MATRIX:
            variable, value = _matrix(_Cursor(part, order), 0)
            if variable and not variable.startswith("__"):
                variables[variable] = value
    return variables


def _matrix(cursor: _Cursor, depth: int) -> tuple[str, Any]:
    """Name and value of an array; None for complex and sparse ones."""
    if depth > MAX_NESTED:
        raise DamageError("nested too deeply")
    if cursor.ended:
        return "", np.zeros(0)
    flags = cursor.numbers()
    if flags.size < 1:
        raise DamageError("no flags")
    kind = int(flags[0]) & 0xFF
    if kind > NUMERIC[-1]:
        return _object(cursor)
    shape = tuple(int(n) for n in cursor.numbers())
    if len(shape) < 2 or min(shape) < 0:
        raise DamageError(f"shape {shape}")
    size = math.prod(shape)
    name = cursor.string()
    if kind in NUMERIC:
        values = cursor.numbers()
        if values.size != size:
            raise DamageError(f"{values.size} numbers for shape {shape}")
        if int(flags[0]) & 0x800:
            return name, None  # complex
        return name, values.reshape(shape, order="F")
    if kind == CHAR:
        return name, _text(cursor, shape, size)
    if kind == CELL:
        return name, [_nested(cursor, depth) for _ in range(_count(cursor, size, 1))]
    if kind in (STRUCT, OBJECT):
        if kind == OBJECT:
            cursor.string()  # its class
        return name, _structs(cursor, size, depth)
    return name, None


def _object(cursor: _Cursor) -> tuple[str, Opaque]:
    """Name and class of an object: three texts, of which the second is the way in which it is stored."""
    texts: list[str] = []
    while not cursor.ended and len(texts) < 3:
        kind, part = cursor.element()
        if kind not in NAMES:
            break
        texts.append(visible(bytes(part).decode("ascii", "replace").rstrip("\0")))
    # Texts that are not there are empty.
    name, _, kind_of_object = [*texts, "", "", ""][:3]
    return name, Opaque(kind_of_object)


def _text(cursor: _Cursor, shape: tuple[int, ...], size: int) -> MatlabText:
    kind, part = cursor.element()
    if kind in TEXT_TYPES:
        encoding = TEXT_TYPES[kind]
        if kind != 16:
            encoding += {"<": "-le", ">": "-be"}[cursor.order]
        characters = bytes(part).decode(encoding, "replace")
    elif kind in TYPES and TYPES[kind][0] in "ui":
        codes = np.frombuffer(part, dtype=cursor.order + TYPES[kind]).astype(np.int64)
        # What is no letter of the basic plane is damage.
        is_letter = (codes >= 0) & (codes < 0xD800)
        characters = "".join(map(chr, np.where(is_letter, codes, 0xFFFD).tolist()))
    else:
        raise DamageError(f"type {kind} where characters belong")
    if len(shape) != 2 or len(characters) != size:
        return MatlabText([characters])
    return MatlabText(characters[row :: shape[0]].strip() for row in range(shape[0]))


def _structs(cursor: _Cursor, size: int, depth: int) -> list[dict[str, Any]]:
    lengths = cursor.numbers()
    raw = bytes(cursor.element()[1])
    if lengths.size == 0 or lengths[0] < 1:
        return []
    width = int(lengths[0])
    fields: list[str] = []
    for k in range(0, len(raw), width):
        fields.append(raw[k : k + width].split(b"\0")[0].decode("ascii", "replace"))
    structs: list[dict[str, Any]] = []
    for _ in range(_count(cursor, size, len(fields))):
        structs.append({field: _nested(cursor, depth) for field in fields})
    return structs


def _count(cursor: _Cursor, size: int, fields: int) -> int:
    """Number of nested arrays, which cannot exceed what their tags alone would take."""
    left = len(cursor.data) - cursor.place
    if size * fields * 8 > left:
        raise DamageError(f"{size} elements in {left} bytes")
    return size * bool(fields)


def _nested(cursor: _Cursor, depth: int) -> Any:
    kind, part = cursor.element()
    if kind != MATRIX:
        raise DamageError(f"type {kind} where an array belongs")
    return _matrix(_Cursor(part, cursor.order), depth + 1)[1]


def _old_variables(data: bytes) -> dict[str, Any]:
    """Variables of version 4; `DamageError` or what struct says of a damaged file."""
    variables: dict[str, Any] = {}
    # The first number is small only if it is read in the order in which it was written.
    order = ">"
    if struct.unpack("<i", data[:4])[0] in range(5000):
        order = "<"
    cursor = _Cursor(memoryview(data), order)
    while not cursor.ended:
        code, rows, columns, imaginary, length = struct.unpack(order + "iiiii", cursor.take(20))
        number, layout = code // 10 % 10, code % 10
        is_header = 0 <= code < 5000 and number < len(OLD_TYPES) and imaginary in (0, 1)
        if not is_header or rows < 0 or columns < 0:
            raise DamageError(f"no version 4 variable at {cursor.place - 20}")
        name = bytes(cursor.take(length)).rstrip(b"\0").decode("ascii", "replace")
        dtype = np.dtype(order + OLD_TYPES[number])
        values = np.frombuffer(cursor.take(rows * columns * dtype.itemsize), dtype=dtype)
        if imaginary:
            cursor.take(rows * columns * dtype.itemsize)
        if layout == 0 and not imaginary:
            variables[name] = values.reshape((rows, columns), order="F")
        elif layout == 1:
            codes = values.reshape((rows, columns), order="F").tolist()
            variables[name] = MatlabText(
                "".join(chr(int(c)) for c in row if 0 <= c < 0xD800).strip() for row in codes
            )
    return variables
