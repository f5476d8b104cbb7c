"""Target ``st``: a function block for PLCs, as IEC 61131-3 text, Siemens SCL and PLCopen XML, with its test.

What is generated is data (`dehyst.export.plc.pou.Pou`) until the last moment: so all three forms say the same; each
is then read back and run by the own checker (`dehyst.export.iec`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np

from dehyst import __version__
from dehyst.control.block import Block, Direction
from dehyst.export.checks import Check
from dehyst.export.numbers import BlockNumbers
from dehyst.export.plc.block import INPUT_LIMIT, function_block
from dehyst.export.plc.names import type_name
from dehyst.export.plc.plcopen import plcopen_xml
from dehyst.export.plc.pou import Pou, siemens_scl, structured_text
from dehyst.export.plc.programs import PlcSignal, example, self_test, writable
from dehyst.export.plc.template import rendered
from dehyst.export.plc.verification import check_forms
from dehyst.export.subject import Subject

REAL = {"double": "LREAL", "float": "REAL"}
TOLERANCE = 1e-5  # of the output range, with REAL
_DATE = "2000-01-01T00:00:00"  # the format wants one; equal exports are equal files


def files(subject: Subject) -> dict[str, str | bytes]:
    """Return the function block, its example and its test in all three forms, and README.md."""
    name, real, words = block_name(subject), REAL[subject.real], _words(subject)
    numbers = _numbers(subject)
    units = (
        function_block(name, real, numbers, words),
        example(name, real, words),
        self_test(name, real, plc_signal(subject)),
    )
    readme = rendered(
        "README.md.j2",
        name=name,
        real=real,
        words=words,
        numbers=numbers,
        samples=subject.test.samples,
        subject=subject,
    )
    return {**sources(name, units), "README.md": readme}


def block_name(subject: Subject) -> str:
    """Return the name of the function block's type."""
    block = function_block("", REAL[subject.real], _numbers(subject), _words(subject))
    return type_name(subject.name, {variable.name.lower() for variable in block.variables})


def sources(name: str, units: tuple[Pou, Pou, Pou]) -> dict[str, str | bytes]:
    """Return the units in all three forms."""
    block, call, test = units
    return {
        f"{name}.st": structured_text(block) + "\n" + structured_text(call),
        f"{name}_Test.st": structured_text(test),
        f"{name}.scl": siemens_scl(block) + "\n" + siemens_scl(call),
        f"{name}_Test.scl": siemens_scl(test),
        f"{name}.xml": plcopen_xml(name, units, __version__, _DATE),
    }


def plc_signal(subject: Subject) -> PlcSignal:
    """Return the test signal for the PLC: inputs that have a constant, and the model's answers to these."""
    real, settings = REAL[subject.real], subject.settings
    x = tuple(writable(float(value), real) for value in subject.test.inputs[:, 0])
    seen = [value if abs(value) <= INPUT_LIMIT[real] else math.nan for value in x]  # a model in double takes 1e16
    block = Block(subject.model, cast(Direction, subject.what), range=settings.get("range"), ramp=int(settings["ramp"]))
    outputs, flags = block.run(np.array(seen), subject.test.switch != 0)
    return PlcSignal(
        x,
        tuple(bool(on) for on in subject.test.switch),
        tuple(float(y) for y in outputs),
        tuple(int(word) for word in flags),
        tolerance(subject),
    )


def tolerance(subject: Subject) -> float:
    """Return the largest allowed difference from the model: none in LREAL."""
    numbers = _numbers(subject)
    return 0.0 if subject.real == "double" else TOLERANCE * (numbers.output_high - numbers.output_low)


def _numbers(subject: Subject) -> BlockNumbers:
    assert subject.block is not None
    return subject.block


def _words(subject: Subject) -> dict[str, str]:
    origin = [f"{key}: {value}" for key, value in sorted(subject.provenance.items()) if value not in (None, "", [], {})]
    about = [
        f"{subject.title}",
        f"Written by dehyst {__version__}; model checksum {subject.checksum}",
        *(line[:200] for line in origin[:20]),
        "SPDX-License-Identifier: 0BSD",
    ]
    return {
        "input": subject.input.label,
        "output": subject.output.label,
        "about": "\n".join(about),
        "title": subject.title,
        "task": f" of {1e3 * subject.period:g} ms" if subject.period else "",
    }


def verify(folder: Path, subject: Subject, manifest: Mapping[str, Any]) -> list[Check]:
    """Run all three forms in the own checker and compare them with the model's answers."""
    signals = {"test signal": subject.test}
    if subject.excerpt is not None:
        signals["excerpt of your log"] = subject.excerpt
    return check_forms(folder, block_name(subject), REAL[subject.real], signals, tolerance(subject))
