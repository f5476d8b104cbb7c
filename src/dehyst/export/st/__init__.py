"""Target ``st``: a function block for PLCs, as IEC 61131-3 text, Siemens SCL, PLCopen XML and files of TwinCAT.

What is generated is data (`dehyst.export.st.pou.Pou`) until the last moment: so all forms say the same; each is
then read back and run by the own checker (`dehyst.export.iec`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.export.c import with_warning
from dehyst.export.names import check_type_name, type_name
from dehyst.export.precision import Floats
from dehyst.export.signal import Whole
from dehyst.export.st.blocks import (
    direct_function_block,
    element_function_block,
    function_block,
    retained,
    signal_names,
)
from dehyst.export.st.pou import Pou, plain, plcopen_xml, rendered, siemens_scl, structured_text, twincat_source
from dehyst.export.st.programs import NO_NUMBER, PlcSignal, Ports, example, self_test, writable
from dehyst.export.st.verification import check_forms
from dehyst.export.subject import Subject
from dehyst.export.targets import Check
from dehyst.version import __version__

REAL = {"double": "LREAL", "float": "REAL"}
FUNCTION_BLOCKS: Mapping[str, Callable[..., Pou]] = {
    "block": function_block,
    "direct_block": direct_function_block,
    "element_block": element_function_block,
}
_DATE = "2000-01-01T00:00:00"  # the format wants one; equal exports are equal files


def files(subject: Subject) -> dict[str, str | bytes]:
    """Return the function block, its example and its test in all forms, and README.md."""
    units = units_of(subject)
    name = units[0].name
    values = {
        "name": name, "real": REAL[subject.real], "words": _words(subject), "samples": subject.test.samples,
        "power_cycle": _after_power_cycle(subject),
    }  # fmt: skip
    readme = rendered("README.md.j2", numbers=subject.block, units=units, **values)
    return {**sources(name, units, subject.checksum), "README.md": with_warning(readme, subject)}


def units_of(subject: Subject) -> tuple[Pou, Pou, Pou]:
    """Return the function block, its example and its test."""
    real, words, ports, name = REAL[subject.real], _words(subject), ports_of(subject), block_name(subject)
    call = example(name, real, words, ports)
    return function_block_of(subject, name), call, self_test(name, real, ports, plc_signal(subject))


def ports_of(subject: Subject) -> Ports:
    """Return inputs and outputs of the function block."""
    return Ports.of(function_block_of(subject, ""))


def function_block_of(subject: Subject, name: str) -> Pou:
    """Return the function block of a subject under this name."""
    real, words = REAL[subject.real], _words(subject)
    assert subject.block is not None  # the target takes no controllers
    unit = FUNCTION_BLOCKS[subject.block.core](name, real, subject.block, words)
    return retained(unit, real) if subject.retain else unit


def block_name(subject: Subject) -> str:
    """Return the name of the function block's type."""
    return type_name(subject.name, _variables(subject))


def check_own_name(subject: Subject) -> None:
    """Refuse a name that the user chose and that the function block's type cannot have."""
    check_type_name(subject.name, _variables(subject))


def _variables(subject: Subject) -> set[str]:
    return {variable.name.lower() for variable in function_block_of(subject, "").variables}


def sources(name: str, units: tuple[Pou, Pou, Pou], model: str) -> dict[str, str | bytes]:
    """Return the units in all forms; `model` is the checksum of the model."""
    block, call, test = units
    return {
        f"{name}.st": structured_text(block) + "\n" + structured_text(call),
        f"{name}_Test.st": structured_text(test),
        f"{name}.scl": siemens_scl(block) + "\n" + siemens_scl(call),
        f"{name}_Test.scl": siemens_scl(test, shared=False),
        f"{name}.xml": plcopen_xml(name, units, __version__, _DATE, model),
        **{f"twincat/{unit.name}.TcPOU": twincat_source(unit) for unit in units},
    }


def plc_signal(subject: Subject) -> PlcSignal:
    """Return the test signal for the PLC: inputs that have a constant, and the model's answers to these."""
    real, ports, test = REAL[subject.real], ports_of(subject), subject.test
    samples = test.samples
    x = np.array([[writable(float(value), real) for value in row] for row in test.inputs[:samples]])
    outputs, flags = _answers(subject, np.where(x < NO_NUMBER, x, np.nan))
    return PlcSignal(
        dict(zip(ports.inputs, _columns(x), strict=True)),
        {name: tuple(bool(on & bit) for on in test.switch[:samples]) for name, bit in ports.switches.items()},
        dict(zip(ports.outputs, _columns(outputs), strict=True)),
        tuple(int(word) for word in flags),
        dict(zip(ports.outputs, tolerances(subject), strict=True)),
    )


def _columns(table: Array) -> list[Floats]:
    return [tuple(float(x) for x in column) for column in table.T]


def _answers(subject: Subject, x: Array) -> tuple[Array, Whole]:
    """Return outputs and flags; a number that a block in float rejects is given as NaN to the model in double."""
    answered = subject.answer(x, subject.test.switch)
    return answered.outputs, answered.flags


def tolerances(subject: Subject) -> tuple[float, ...]:
    """Return the largest allowed difference of each output from the model: none in LREAL."""
    return tuple(0.0 for _ in subject.tolerances) if subject.real == "double" else subject.tolerances


def _cell(text: str) -> str:
    """Return a text for a cell of a table in Markdown."""
    return " ".join(plain(text).replace("|", "/").split())


_AFTER_POWER_CYCLE = {
    "block": (
        "the block has forgotten the past: the first call begins with the start states, as Restart does. Its answer "
        "can be wrong by up to the width of the loop until the actuator was homed or has made a stroke over its "
        "range: home it, set Restart for one call, then Enable. Exported with --retain, its states outlive a power "
        "cycle."
    ),
    "block that is retained": (
        "what the block remembers is in VAR RETAIN: the first call goes on where the last one before was. That is "
        "right if the actuator was held meanwhile. If it was moved, relieved or emptied, home it and set Restart for "
        "one call before Enable; if the model creeps or has a dead time, do so too, because the block does not know "
        "how long the power was off. Tables are not kept, and need no such memory."
    ),
}


def _after_power_cycle(subject: Subject) -> str:
    return _AFTER_POWER_CYCLE["block that is retained" if subject.retain else "block"]


def _words(subject: Subject) -> dict[str, str]:
    origin = [f"{key}: {value}" for key, value in sorted(subject.provenance.items()) if value not in (None, "", [], {})]
    about = [
        f"{subject.title}",
        f"Written by dehyst {__version__}; model checksum {subject.checksum}",
        f"After a power cycle: {_after_power_cycle(subject)}",
        *(line[:200] for line in origin[:20]),
        "SPDX-License-Identifier: 0BSD",
    ]
    return {
        "input": _cell(subject.input.label),
        "output": _cell(subject.output.label),
        "about": "\n".join(about),
        "title": _cell(subject.title),
        **dict(zip(signal_names(tuple(dict(subject.more))), (_cell(about) for _, about in subject.more), strict=True)),
        "task": f" of {1e3 * subject.period:g} ms" if subject.period else "",
    }


def verify(folder: Path, subject: Subject) -> list[Check]:
    """Run all forms in the own checker and compare them with the model's answers."""
    signals = {"test signal": subject.test}
    if subject.excerpt is not None:
        signals["excerpt of your log"] = subject.excerpt
    name, real = block_name(subject), REAL[subject.real]
    return check_forms(folder, name, real, ports_of(subject), signals, tolerances(subject))
