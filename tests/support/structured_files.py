"""MAT and HDF5 files built from their grammar with lies in every field: what flipped bytes seldom reach.

A file begins sound: `hostile_*` takes dice, builds nested variables and, now and then, writes another number than the
true one into a type, a size, a shape, a flag, a name or a count. Most files have one to three lies, some have none.
"""

import io
import math
import random
import re
import struct
import zlib

import numpy as np

NUMBERS = (
    0,
    1,
    2,
    3,
    4,
    5,
    7,
    8,
    16,
    60,
    255,
    256,
    2**15,
    2**16,
    2**31 - 1,
    2**31,
    2**32 - 8,
    2**32 - 1,
)
NAMES = (
    "time_s",
    "pressure_bar",
    "angle_deg",
    "s",
    "label",
    "values",
    "",
    "__f__",
    "x" * 300,
    "a.b",
    "\x1b[31m",
    "\xff",
)
NAMES += ("#refs#", "None", "time", "signals", "=cmd|'x'!A0", "<script>", "9", "\u202eleft")
CODES = {"i1": 1, "u1": 2, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 9, "i8": 12, "u8": 13}
CLASSES = {
    "f8": 6,
    "f4": 7,
    "i1": 8,
    "u1": 9,
    "i2": 10,
    "u2": 11,
    "i4": 12,
    "u4": 13,
    "i8": 14,
    "u8": 15,
}


class Liar:
    """Dice that tell, now and then, another number than the true one."""

    def __init__(self, dice):
        self.dice, self.often = dice, dice.choice([0.0, 0.002, 0.01, 0.04])

    def number(self, true):
        if self.dice.random() >= self.often:
            return true
        return self.dice.choice(
            [*NUMBERS, true + 1, max(true - 1, 0), true ^ (1 << self.dice.randrange(31))]
        )

    def flips(self, share):
        return self.often > 0 and self.dice.random() < share

    def name(self):
        return self.dice.choice(NAMES).encode(
            "utf-8" if self.dice.random() < 0.5 else "latin-1", "replace"
        )


# MAT version 5


def hostile_mat5(dice):
    lies = Liar(dice)
    order = dice.choice("<<<>")
    parts = []
    for known in dice.sample(["time_s", "pressure_bar", "angle_deg"], dice.randrange(4)):
        parts.append(_packed(lies, order, _array(lies, order, known.encode(), 60)))
    parts += [
        _packed(lies, order, _matrix(lies, order, lies.name(), 0))
        for _ in range(dice.randrange(1, 4))
    ]
    dice.shuffle(parts)
    text = (
        b"MATLAB 5.0 MAT-file".ljust(124)
        + struct.pack(order + "H", 0x100)
        + (b"IM" if order == "<" else b"MI")
    )
    data = text + b"".join(parts)
    return data[: dice.randrange(len(data))] if lies.flips(0.1) else data


def _element(lies, order, kind, content):
    kind, size = lies.number(kind), lies.number(len(content))
    if len(content) <= 4 and lies.dice.random() < 0.5:
        return struct.pack(order + "I", (size & 0xFFFF) << 16 | kind & 0xFFFF) + content.ljust(
            4, b"\0"
        )
    pad = b"" if kind == 15 or lies.flips(0.02) else bytes(-len(content) % 8)
    return struct.pack(order + "II", kind & 0xFFFFFFFF, size & 0xFFFFFFFF) + content + pad


def _packed(lies, order, element):
    if lies.dice.random() < 0.6:
        return element
    packed = zlib.compress(element)
    if lies.flips(0.1):
        packed = packed[: lies.dice.randrange(len(packed))] + lies.dice.randbytes(
            lies.dice.randrange(8)
        )
    return _element(lies, order, 15, packed)


def _head(lies, order, kind, shape, name):
    flags = kind | (lies.dice.choice([0x100, 0x200, 0x400, 0x800]) if lies.flips(0.1) else 0)
    return (
        _element(
            lies,
            order,
            6,
            struct.pack(order + "II", lies.number(flags) & 0xFFFFFFFF, lies.number(0) & 0xFFFFFFFF),
        )
        + _element(
            lies,
            order,
            5,
            b"".join(struct.pack(order + "I", lies.number(n) & 0xFFFFFFFF) for n in shape),
        )
        + _element(lies, order, 1, name)
    )


def _array(lies, order, name, size=None):
    kind = "f8" if size else lies.dice.choice(list(CODES))
    shape = (
        (size, 1)
        if size
        else lies.dice.choice([(0, 0), (1, 1), (1, 60), (60, 3), (3, 2, 2), (1,) * 40, (7,)])
    )
    stored = kind if lies.dice.random() < 0.7 else "u1"
    values = (np.sin(np.arange(math.prod(shape)) / 3) * 20).astype(stored)
    if stored in ("f8", "f4") and values.size and lies.flips(0.2):
        values[lies.dice.randrange(values.size)] = lies.dice.choice(
            [np.nan, np.inf, -np.inf, 1e38, 5e-324]
        )
    body = _head(lies, order, CLASSES[kind], shape, name)
    body += _element(lies, order, CODES[stored], values.astype(order + stored).tobytes())
    return _element(lies, order, 14, body)


def _matrix(lies, order, name, depth):
    kind = lies.dice.choice(
        ["array", "array", "char", "cell", "struct", "object", "sparse", "opaque", "empty", "deep"]
    )
    if kind == "array" or depth > 4:
        return _array(lies, order, name)
    if kind == "deep":
        inner = _array(lies, order, name)
        for _ in range(lies.dice.choice([3, 15, 16, 17, 200])):
            inner = _element(
                Liar(random.Random(1)), order, 14, _head(lies, order, 1, (1, 1), name) + inner
            )
        return inner
    if kind == "empty":
        return _element(lies, order, 14, b"")
    if kind == "opaque":
        body = _element(lies, order, 6, struct.pack(order + "II", 17, 0)) + _element(
            lies, order, 1, name
        )
        return _element(lies, order, 14, body + lies.dice.randbytes(lies.dice.randrange(40)))
    shape = lies.dice.choice([(0, 0), (1, 1), (1, 3), (2, 2), (1, 2, 2)])
    many = math.prod(shape)
    body = _head(
        lies,
        order,
        {"cell": 1, "struct": 2, "object": 3, "char": 4, "sparse": 5}[kind],
        shape,
        name,
    )
    if kind == "char":
        code, stored = lies.dice.choice(
            [
                (16, "u1"),
                (17, "u2"),
                (18, "u4"),
                (4, "u2"),
                (2, "u1"),
                (3, "i2"),
                (lies.number(4), "u2"),
            ]
        )
        letters = np.array([lies.number(65 + k) & 0x7FFF for k in range(many)])
        body += _element(lies, order, code, letters.astype(order + stored).tobytes())
    elif kind == "sparse":
        for stored in ("i4", "i4", "f8"):
            body += _element(
                lies, order, CODES[stored], np.arange(many).astype(order + stored).tobytes()
            )
    elif kind == "cell":
        body += b"".join(_matrix(lies, order, b"", depth + 1) for _ in range(many))
    else:
        if kind == "object":
            body += _element(lies, order, 1, b"timeseries")
        fields = [lies.name()[:31] for _ in range(lies.dice.randrange(4))]
        if lies.dice.random() < 0.3:
            fields = [b"time", b"values", b"label"]
        body += _element(lies, order, 5, struct.pack(order + "I", lies.number(32) & 0xFFFFFFFF))
        body += _element(lies, order, 1, b"".join(field.ljust(32, b"\0") for field in fields))
        body += b"".join(_matrix(lies, order, b"", depth + 1) for _ in range(many) for _ in fields)
    return _element(lies, order, 14, body)


# MAT version 4


def hostile_mat4(dice):
    lies = Liar(dice)
    order = dice.choice("<<>")
    data = b""
    for name in [
        b"time_s",
        b"pressure_bar",
        b"angle_deg",
        *(lies.name() for _ in range(dice.randrange(3))),
    ]:
        number, stored = dice.choice(list(enumerate(["f8", "f4", "i4", "i2", "u2", "u1"])))
        layout, imaginary = dice.choice([0, 0, 0, 0, 1, 2]), int(dice.random() < 0.1)
        rows, columns = dice.choice([(60, 1), (60, 1), (1, 60), (6, 10), (0, 0), (1, 1)])
        values = (np.sin(np.arange(rows * columns * (1 + imaginary)) / 3) * 20 + 20).astype(
            order + stored
        )
        if stored in ("f8", "f4") and values.size and lies.flips(0.3):
            values[dice.randrange(values.size)] = dice.choice(
                [np.nan, np.inf, -np.inf, 1e38, -1.0, 1e20]
            )
        code = 1000 * (order == ">") + 10 * number + layout
        head = [
            lies.number(n) & 0xFFFFFFFF for n in (code, rows, columns, imaginary, len(name) + 1)
        ]
        data += struct.pack(order + "5I", *head) + name + b"\0" + values.tobytes()
    return data[: dice.randrange(len(data))] if lies.flips(0.1) else data


# HDF5, and MAT version 7.3, which is HDF5 behind 512 bytes


def hostile_hdf5(dice):
    return _hdf5(dice, matlab=False)


def hostile_mat73(dice):
    head = b"MATLAB 7.3 MAT-file".ljust(124) + struct.pack("<H", 0x200) + b"IM"
    return head.ljust(512, b"\0") + _hdf5(dice, matlab=True)[512:]


def _hdf5(dice, matlab):
    import h5py

    lies, stream = Liar(dice), io.BytesIO()
    with h5py.File(
        stream, "w", userblock_size=512 if matlab else 0, libver=dice.choice(["earliest", "latest"])
    ) as out:
        for name in ("time_s", "pressure_bar", "angle_deg"):
            if dice.random() < 0.9:
                node = out.create_dataset(
                    name, data=20 * np.sin(np.arange(60) / 3), compression=dice.choice([None, 4])
                )
                if matlab:
                    node.attrs["MATLAB_class"] = np.bytes_(b"double")
        for _ in range(dice.randrange(1, 5)):
            _member(lies, out, out, matlab, 0)
    raw = bytearray(stream.getvalue())
    for _ in range(dice.choice([0, 0, 1, 2, 4])):
        # Messages and trees are kept in the first kilobytes, behind their four letters.
        marks = [
            found.start() for found in re.finditer(b"OHDR|TREE|HEAP|SNOD|GCOL|FRHP|\x89HDF", raw)
        ]
        at = (
            dice.choice(marks) + dice.randrange(4, 80)
            if dice.random() < 0.5
            else dice.randrange(min(4096, len(raw)))
        )
        lie = lies.number(dice.choice(NUMBERS)) & 0xFFFFFFFF
        width = dice.choice([1, 2, 4, 8])
        raw[at : at + width] = (lie & (1 << 8 * min(width, 4)) - 1).to_bytes(width, "little")
    return bytes(raw)


def _member(lies, file, group, matlab, depth):
    import h5py

    dice = lies.dice
    name = dice.choice([*NAMES[:4], *NAMES[8:]]).replace("\0", "") + str(dice.randrange(99))
    if name in group:
        return
    kind = dice.choice(
        [
            "group",
            "struct",
            "loop",
            "soft",
            "elsewhere",
            "huge",
            "odd",
            "text",
            "reference",
            "empty",
            "wide",
        ]
    )
    if kind in ("group", "struct") and depth < 8:
        inner = group.create_group(name)
        if kind == "struct":
            inner.create_dataset("values", data=np.arange(60.0))
            label = inner.create_dataset("label", data=np.array([[ord(c)] for c in "angle"], "u2"))
            label.attrs["MATLAB_class"] = np.bytes_(b"char")
        for _ in range(dice.randrange(1, 4)):
            _member(lies, file, inner, matlab, depth + 1)
        return
    if kind == "loop":
        group[name] = group
        return
    if kind == "soft":
        group[name] = h5py.SoftLink(dice.choice(["/", "/time_s", f"/{name}", "..", "/nothing"]))
        return
    if kind == "elsewhere":
        group[name] = h5py.ExternalLink(
            dice.choice(["other.h5", "/dev/zero", "..", ""]) or ".", "/x"
        )
        return
    if kind == "huge":
        shape = dice.choice([(2**31,), (2**40,), (2**20, 2**20), (1,) * 31, (2**62,)])
        node = group.create_dataset(name, shape, "f8", chunks=tuple(min(n, 64) for n in shape))
    elif kind == "wide":
        node = group.create_dataset(name, data=np.zeros((2, dice.choice([1, 500, 5000]))))
    elif kind == "odd":
        dtype = dice.choice(
            [
                np.dtype("c16"),
                np.dtype("?"),
                np.dtype("f2"),
                np.dtype(">i8"),
                np.dtype("S5"),
                np.dtype("V7"),
                np.dtype([("a", "f8"), ("b", "S3"), ("c", "i4", (3,))]),
                np.dtype(("f8", (3, 2))),
                h5py.enum_dtype({"on": 1, "off": 0}, basetype="i1"),
                h5py.vlen_dtype(np.dtype("f8")),
                h5py.opaque_dtype(np.dtype("M8[ns]")),
            ]
        )
        node = group.create_dataset(name, dice.choice([(), (0,), (60,), (3, 2)]), dtype)
    elif kind == "text":
        values = [dice.choice(NAMES) for _ in range(dice.choice([1, 3, 60]))]
        node = group.create_dataset(name, data=values, dtype=h5py.string_dtype())
    elif kind == "reference":
        targets = [
            dice.choice([file.ref, group.ref, *([file["time_s"].ref] if "time_s" in file else [])])
            for _ in range(3)
        ]
        node = group.create_dataset(
            name, data=np.array(targets, h5py.ref_dtype), dtype=h5py.ref_dtype
        )
    else:
        node = group.create_dataset(name, data=h5py.Empty("f8"))
    if matlab or lies.flips(0.2):
        words = [
            b"double",
            b"char",
            b"cell",
            b"struct",
            b"logical",
            b"\xff\xfe",
            b"",
            b"function_handle",
            7,
            2.5,
            [b"a", b"b"],
        ]
        node.attrs["MATLAB_class"] = dice.choice(words)
    if lies.flips(0.15):
        node.attrs[dice.choice(["MATLAB_empty", "MATLAB_object_decode"])] = dice.choice(
            [1, 0, 2**40, "x", [1, 2]]
        )
