"""The programs beside the function block: how it is called, and the test that the PLC runs on itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dehyst.export.numbers import Floats
from dehyst.export.plc.block import number
from dehyst.export.plc.numbers import constant
from dehyst.export.plc.pou import Pou, Variable

_BEYOND = {"LREAL": 1e101, "REAL": 1e16}  # finite, and rejected like a NaN, for which a PLC has no constant
_SMALLEST = {"LREAL": float(np.finfo(np.float64).tiny), "REAL": float(np.finfo(np.float32).tiny)}


@dataclass(frozen=True)
class PlcSignal:
    """What the test program feeds to the block, sample by sample, and what must come out.

    Parameters
    ----------
    inputs, enabled
        Input and the switch, (T,); each input is one for which Structured Text has a constant (`writable`).
    outputs, flags
        Expected output and flags, (T,).
    tolerance
        Largest allowed difference of outputs: 0 for LREAL. With REAL only the flags of rejected samples are compared:
        whether a limit is met may hang on the last digit.
    """

    inputs: Floats
    enabled: tuple[bool, ...]
    outputs: Floats
    flags: tuple[int, ...]
    tolerance: float


def writable(x: float, real: str) -> float:
    """Return an input for which there is a constant: what is no number becomes one that is rejected as well.

    Numbers below the normal ones become 0, because tools disagree about them.

    Examples
    --------
    >>> writable(float("nan"), "LREAL"), writable(5e-324, "LREAL"), writable(0.5, "REAL")
    (1e+101, 0.0, 0.5)
    """
    if not abs(x) <= _BEYOND[real]:
        return _BEYOND[real]
    return x if abs(x) >= _SMALLEST[real] else 0.0


def example(block: str, real: str, words: dict[str, str]) -> Pou:
    """Return a program that calls the block once a cycle of a task with a fixed period."""
    variables = (
        Variable("VAR", "Compensator", block, comment="one instance for each actuator"),
        Variable("VAR", "Measured", real, comment=f"connect it: {words['input']}"),
        Variable("VAR", "Wanted", "BOOL", ("FALSE",), comment="connect it: TRUE while the machine is enabled"),
        Variable("VAR", "Homed", "BOOL", ("FALSE",), comment="connect it: TRUE for one call after homing"),
        Variable("VAR", "Answer", real, comment=f"connect it: {words['output']}"),
        Variable("VAR", "Healthy", "BOOL", ("FALSE",), comment="FALSE while samples are rejected"),
    )
    body = (
        "Compensator(InputValue := Measured, Enable := Wanted, Restart := Homed);\n"
        "Answer := Compensator.OutputValue;\n"
        "Healthy := NOT Compensator.Rejected;\n"
    )
    comment = (
        f"Example of a call of {block}. Give this program a cyclic task with a fixed interval"
        f"{words['task']}; call the block exactly once a cycle, whether it is enabled or not: its states follow."
    )
    return Pou("PROGRAM", f"{block}_Example", variables, body, comment)


def self_test(block: str, real: str, signal: PlcSignal) -> Pou:
    """Return a program that feeds the test signal to the block, one sample a call, and counts what differs."""
    last = len(signal.inputs) - 1
    mask = 15 if real == "LREAL" else 3
    variables = (
        *_RESULTS,
        Variable("VAR_OUTPUT", "Largest", real, ("0.0",), comment="largest difference of outputs"),
        Variable("VAR", "Tested", block),
        Variable("VAR", "Sample", "DINT", ("0",), comment="number of the next sample"),
        Variable("VAR", "Difference", real, ("0.0",)),
        Variable("VAR", "Seen", "UDINT", ("0",), comment="flags that are compared"),
        Variable("VAR CONSTANT", "Last", "DINT", (str(last),)),
        number("Zero", real, 0.0),
        number("Tolerance", real, signal.tolerance),
        _table("TestInput", real, [constant(x, real) for x in signal.inputs], "1E101 or 1E16 stands for NaN"),
        _table("TestEnable", "BOOL", ["TRUE" if on else "FALSE" for on in signal.enabled], ""),
        _table("TestOutput", real, [constant(y, real) for y in signal.outputs], "expected"),
        _table("TestFlags", "UDINT", [str(flags & mask) for flags in signal.flags], "expected"),
    )
    comment = (
        f"Test of {block} on the PLC itself: one sample a call, {last + 1} calls. Passed must become TRUE. "
        "Remove it when it has; the block that is in use is another instance."
    )
    return Pou("PROGRAM", f"{block}_Test", variables, _HEAD + (_ALL if real == "LREAL" else _REJECTED) + _TAIL, comment)


def _table(name: str, type_: str, values: Sequence[str], comment: str) -> Variable:
    return Variable("VAR CONSTANT", name, type_, tuple(values), len(values), comment)


_RESULTS = (
    Variable("VAR_OUTPUT", "Finished", "BOOL", ("FALSE",), comment="TRUE when the last sample was compared"),
    Variable("VAR_OUTPUT", "Passed", "BOOL", ("FALSE",), comment="TRUE if finished without a mismatch"),
    Variable("VAR_OUTPUT", "Mismatches", "DINT", ("0",), comment="samples whose output or flags differ"),
    Variable("VAR_OUTPUT", "FirstMismatch", "DINT", ("-1",), comment="number of the first of them"),
)
_HEAD = """IF NOT Finished THEN
    Tested(InputValue := TestInput[Sample], Enable := TestEnable[Sample], Restart := FALSE);
    Difference := Tested.OutputValue - TestOutput[Sample];
    IF Difference < Zero THEN
        Difference := -Difference;
    END_IF;
    IF Difference > Largest THEN
        Largest := Difference;
    END_IF;
"""
_ALL = """    Seen := Tested.FlagWord;
"""
_REJECTED = """    Seen := 0;
    IF Tested.Rejected THEN
        Seen := Seen + 1;
    END_IF;
    IF Tested.RejectedEver THEN
        Seen := Seen + 2;
    END_IF;
"""
_TAIL = """    IF NOT (Tolerance >= Difference) OR (Seen <> TestFlags[Sample]) THEN
        Mismatches := Mismatches + 1;
        IF FirstMismatch < 0 THEN
            FirstMismatch := Sample;
        END_IF;
    END_IF;
    IF Sample >= Last THEN
        Finished := TRUE;
        Passed := Mismatches = 0;
    ELSE
        Sample := Sample + 1;
    END_IF;
END_IF;
"""
