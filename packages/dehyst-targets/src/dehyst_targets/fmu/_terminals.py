"""Terminal and icon of an FMU: how tools connect its signals by name, and the picture that they show."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable
from xml.etree import ElementTree as Xml

import numpy as np

from dehyst_targets.fmu._description import Variable

SIDE = 64  # of the picture, pixels
_LOOP = ((8, 56), (28, 56), (56, 8), (36, 8))  # of a play operator: at rest, along, at rest, back
_BLACK, _WHITE = 0, 255
PICTURE = (
    f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIDE} {SIDE}">\n'
    f'<rect width="{SIDE}" height="{SIDE}" fill="white"/>\n'
    f'<polygon points="{" ".join(f"{x},{y}" for x, y in _LOOP)}" fill="none" stroke="black" stroke-width="4"/>\n'
    "</svg>\n"
)


def terminals(variables: Iterable[Variable]) -> bytes:
    """Return terminalsAndIcons.xml of FMI 3.0: one terminal, a bus with every input and output under its own name."""
    root = Xml.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    shown = Xml.SubElement(root, "GraphicalRepresentation")
    corners = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    Xml.SubElement(shown, "CoordinateSystem", corners, suggestedScalingFactorTo_mm="0.1")
    Xml.SubElement(shown, "Icon", corners)
    about = {"name": "signals", "matchingRule": "bus", "description": "inputs and outputs"}
    bus = Xml.SubElement(Xml.SubElement(root, "Terminals"), "Terminal", about)
    for variable in variables:
        if variable.role in ("input", "output"):
            names = {"variableName": variable.name, "memberName": variable.name}
            Xml.SubElement(bus, "TerminalMemberVariable", names, variableKind="signal")
    Xml.indent(root)
    return bytes(Xml.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def picture() -> bytes:
    """Return the icon as PNG, in shades of grey; not compressed, so that every machine writes the same bytes."""
    y, x = np.mgrid[:SIDE, :SIDE] + 0.5
    grey = np.full((SIDE, SIDE), _WHITE, dtype=np.uint8)
    for (x0, y0), (x1, y1) in zip(_LOOP, (*_LOOP[1:], _LOOP[0]), strict=True):
        along = ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / ((x1 - x0) ** 2 + (y1 - y0) ** 2)
        along = along.clip(0.0, 1.0)
        # A pixel is black within two pixels of a line: the stroke is 4 wide, as in the SVG.
        near = (x - x0 - along * (x1 - x0)) ** 2 + (y - y0 - along * (y1 - y0)) ** 2 <= 4.0
        grey[near] = _BLACK
    # Each row of a PNG begins with the number of its filter: 0 is none.
    rows = np.hstack([np.zeros((SIDE, 1), dtype=np.uint8), grey])
    # Eight bits a pixel, shades of grey, and the zeros of the methods that PNG has.
    head = struct.pack(">2I5B", SIDE, SIDE, 8, 0, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(rows.tobytes(), 0)), (b"IEND", b""))
    png = b"\x89PNG\r\n\x1a\n"
    for kind, data in chunks:
        # The checksum covers kind and data, and leaves the length out.
        checksum = struct.pack(">I", zlib.crc32(kind + data))
        png += struct.pack(">I", len(data)) + kind + data + checksum
    return png
