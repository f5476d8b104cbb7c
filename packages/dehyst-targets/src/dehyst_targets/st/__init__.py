"""Target ``st``: a function block for PLCs, as IEC 61131-3 text, Siemens SCL, PLCopen XML and files of TwinCAT.

What is generated is data (`dehyst_targets.st._pou.Pou`) until the last moment: so all forms say the same; each is
then read back and run by the own checker (`dehyst_targets.iec`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.export import Check, Floats, Subject, Whole
from dehyst.export import kit as export_kit
from dehyst.version import __version__
from dehyst_targets.st._blocks import (
    direct_function_block,
    element_function_block,
    function_block,
    retained,
    signal_names,
)
from dehyst_targets.st._names import check_type_name, type_name
from dehyst_targets.st._pou import (
    Pou,
    plain_word,
    plcopen_xml,
    rendered,
    siemens_scl,
    structured_text,
    twincat_source,
)
from dehyst_targets.st._programs import (
    NO_NUMBER,
    PlcSignal,
    Ports,
    example_program,
    self_test,
    writable,
)
from dehyst_targets.st._verification import check_forms

REAL = {"double": "LREAL", "float": "REAL"}
FUNCTION_BLOCKS: Mapping[str, Callable[..., Pou]] = {
    "block": function_block,
    "direct_block": direct_function_block,
    "element_block": element_function_block,
}
_DATE = "2000-01-01T00:00:00"  # the format wants one; equal exports are equal files


def _files(subject: Subject) -> dict[str, str | bytes]:
    """Return the function block, its example and its test in all forms, and README.md."""
    units = units_of(subject)
    name = units[0].name
    values = {
        "name": name, "real": REAL[subject.real], "words": _words(subject), "samples": subject.test.samples,
        "power_cycle": _after_power_cycle(subject),
    }  # fmt: skip
    readme = rendered("README.md.j2", numbers=subject.block, units=units, **values)
    return {
        **st_sources(name, units, subject.checksum),
        "README.md": export_kit.with_warning(readme, subject),
    }


def units_of(subject: Subject) -> tuple[Pou, Pou, Pou]:
    """Return the function block, its example and its test."""
    real, words = REAL[subject.real], _words(subject)
    ports, name = ports_of(subject), block_name(subject)
    call = example_program(name, real, words, ports)
    return function_block_of(subject, name), call, self_test(name, real, ports, plc_signal(subject))


def ports_of(subject: Subject) -> Ports:
    """Return inputs and outputs of the function block."""
    return Ports.of(function_block_of(subject, ""))


def function_block_of(subject: Subject, name: str) -> Pou:
    """Return the function block of a subject under this name."""
    real, words = REAL[subject.real], _words(subject)
    assert subject.block is not None  # the target takes no controllers
    unit = FUNCTION_BLOCKS[subject.block.core](name, real, subject.block, words)
    if subject.retain:
        return retained(unit, real)
    return unit


def block_name(subject: Subject) -> str:
    """Return the name of the function block's type."""
    return type_name(subject.name, _variables(subject))


def check_own_name(subject: Subject) -> None:
    """Refuse a name that the user chose and that the function block's type cannot have."""
    check_type_name(subject.name, _variables(subject))


def _variables(subject: Subject) -> set[str]:
    # What the variables are called does not depend on the name of the block.
    return {variable.name.lower() for variable in function_block_of(subject, "").variables}


def st_sources(name: str, units: tuple[Pou, Pou, Pou], model: str) -> dict[str, str | bytes]:
    """Return the units in all forms; `model` is the checksum of the model."""
    block, call, test = units
    # TwinCAT reads one unit a file, the other tools read several.
    twincat: dict[str, str | bytes] = {}
    for unit in units:
        twincat[f"twincat/{unit.name}.TcPOU"] = twincat_source(unit)
    return {
        f"{name}.st": structured_text(block) + "\n" + structured_text(call),
        f"{name}_Test.st": structured_text(test),
        f"{name}.scl": siemens_scl(block) + "\n" + siemens_scl(call),
        # A test has one instance, so no other one could share its tables.
        f"{name}_Test.scl": siemens_scl(test, shared=False),
        f"{name}.xml": plcopen_xml(name, units, __version__, _DATE, model),
        **twincat,
    }


def plc_signal(subject: Subject) -> PlcSignal:
    """Return the test signal for the PLC: inputs that have a constant, and the model's answers to these."""
    real, ports, test = REAL[subject.real], ports_of(subject), subject.test
    x = np.empty_like(test.inputs[: test.samples])
    for place, value in np.ndenumerate(test.inputs[: test.samples]):
        x[place] = writable(float(value), real)
    # The model must reject what the block rejects: for the model that is NaN.
    outputs, flags = _answers(subject, np.where(x < NO_NUMBER, x, np.nan))
    switches = {}
    for name, bit in ports.switches.items():
        switches[name] = tuple((test.switch[: test.samples] & bit != 0).tolist())
    return PlcSignal(
        dict(zip(ports.inputs, _columns(x), strict=True)),
        switches,
        dict(zip(ports.outputs, _columns(outputs), strict=True)),
        tuple(int(word) for word in flags),
        dict(zip(ports.outputs, st_tolerances(subject), strict=True)),
    )


def _columns(table: Array) -> list[Floats]:
    return [tuple(column) for column in table.T.tolist()]


def _answers(subject: Subject, x: Array) -> tuple[Array, Whole]:
    """Return outputs and flags; a number that a block in float rejects is given as NaN to the model in double."""
    answered = subject.answer(x, subject.test.switch)
    return answered.outputs, answered.flags


def st_tolerances(subject: Subject) -> tuple[float, ...]:
    """Return the largest allowed difference of each output from the model: none in LREAL."""
    if subject.real == "double":
        return (0.0,) * len(subject.tolerances)
    return subject.tolerances


def _cell(text: str) -> str:
    """Return a text for a cell of a table in Markdown."""
    return " ".join(plain_word(text).replace("|", "/").split())


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
    kind = "block"
    if subject.retain:
        kind = "block that is retained"
    return _AFTER_POWER_CYCLE[kind]


def _words(subject: Subject) -> dict[str, str]:
    origin = []
    for key, value in sorted(subject.provenance.items()):
        if value not in (None, "", [], {}):
            # A comment with hundreds of columns would hide the code below it.
            origin.append(f"{key}: {value}"[:200])
    about = [
        f"{subject.title}",
        f"Written by dehyst {__version__}; model checksum {subject.checksum}",
        f"After a power cycle: {_after_power_cycle(subject)}",
        *origin[:20],
        "SPDX-License-Identifier: 0BSD",
    ]
    task = ""
    if subject.period:
        task = f" of {1e3 * subject.period:g} ms"
    words = {
        "input": _cell(subject.input.label),
        "output": _cell(subject.output.label),
        "about": "\n".join(about),
        "title": _cell(subject.title),
        "task": task,
    }
    names = signal_names(tuple(dict(subject.more)))
    for name, (_, meaning) in zip(names, subject.more, strict=True):
        words[name] = _cell(meaning)
    return words


def _verify(folder: Path, subject: Subject) -> list[Check]:
    """Run all forms in the own checker and compare them with the model's answers."""
    signals = {"test signal": subject.test}
    if subject.excerpt is not None:
        signals["excerpt of your log"] = subject.excerpt
    name, real = block_name(subject), REAL[subject.real]
    return check_forms(folder, name, real, ports_of(subject), signals, st_tolerances(subject))


WRITER = export_kit.Writer(_files, _verify, check_own_name)
