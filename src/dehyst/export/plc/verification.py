"""What `dehyst verify` finds out about Structured Text: each form of it, run by the own checker."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from dehyst.errors import DehystError, OutputError
from dehyst.export.checks import Check
from dehyst.export.iec import Instance, load
from dehyst.export.plc.plcopen import text_of
from dehyst.export.signal import Array, Signal, Whole, same_bits

REJECTED = 3  # flags that do not hang on the last digit


def forms(name: str) -> dict[str, tuple[str, ...]]:
    """Return the forms of a unit and the files that each is made of."""
    return {
        "IEC 61131-3 text": (f"{name}.st", f"{name}_Test.st"),
        "Siemens SCL": (f"{name}.scl", f"{name}_Test.scl"),
        "PLCopen XML": (f"{name}.xml",),
    }


def check_forms(folder: Path, name: str, real: str, signals: Mapping[str, Signal], tolerance: float) -> list[Check]:
    """Run each form with every signal and its own test program.

    Parameters
    ----------
    folder
        That was exported.
    name, real
        Of the function block; LREAL or REAL.
    signals
        By what they are called.
    tolerance
        Largest difference of outputs; LREAL must have the same bits.
    """
    found = []
    for form, paths in forms(name).items():
        claim = f"own checker reads {form}: words, types, names, constants"
        try:
            library = load("\n".join(source(folder / path) for path in paths))
            found.append(Check(claim, "passed", ", ".join(paths)))
            for label, signal in signals.items():
                found.append(_compare(library.new(name), f"own checker runs {form}: {label}", real, signal, tolerance))
            found.append(
                _test_program(library.new(f"{name}_Test"), f"own checker runs {form}: test program of the PLC")
            )
        except KeyError as fault:
            found.append(Check(claim, "failed", f"it holds no {fault}: export again"))
        except DehystError as fault:
            found.append(Check(claim, "failed", str(fault)))
    return found


def source(path: Path) -> str:
    """Return the text of a file; of PLCopen XML the text that its elements say.

    Raises
    ------
    OutputError
        If the file cannot be read.
    """
    try:
        return text_of(path.read_bytes()) if path.suffix == ".xml" else path.read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError) as fault:
        raise OutputError(f"'{path.name}' cannot be read ({fault}). Export again.", path=str(path)) from None


def _compare(block: Instance, claim: str, real: str, signal: Signal, tolerance: float) -> Check:
    outputs, flags = run(block, signal)
    if real == "LREAL":
        wrong = [k for k in range(signal.samples) if not same_bits(outputs[k : k + 1], signal.outputs[k])]
        wrong += np.flatnonzero(flags != signal.flags).tolist()
    else:
        near = np.abs(outputs - signal.outputs[:, 0]) <= tolerance
        wrong = np.flatnonzero(~near | ((flags ^ signal.flags) & REJECTED != 0)).tolist()
    if wrong:
        k = min(wrong)
        detail = f"sample {k}: {outputs[k]!r}, flags {flags[k]}; the model {signal.outputs[k, 0]!r}, {signal.flags[k]}"
        return Check(claim, "failed", detail)
    worst = float(np.max(np.abs(outputs - signal.outputs[:, 0]), initial=0.0))
    words = "bit for bit the model" if real == "LREAL" else f"within {worst:.2g} of the model"
    return Check(claim, "passed", f"{signal.samples} samples, {words}")


def run(block: Instance, signal: Signal) -> tuple[Array, Whole]:
    """Return outputs and flags (T,) of a fresh instance."""
    rows = [
        block.call(InputValue=float(x), Enable=bool(on), Restart=False)
        for x, on in zip(signal.inputs[:, 0], signal.switch, strict=True)
    ]
    return np.array([row["OutputValue"] for row in rows]), np.array([row["FlagWord"] for row in rows], dtype=np.int64)


def _test_program(program: Instance, claim: str) -> Check:
    calls = int(program.value("Last")) + 1
    for _ in range(calls):
        out = program.call()
    good = bool(out["Finished"]) and bool(out["Passed"])
    return Check(claim, "passed" if good else "failed", f"{calls} calls, {out['Mismatches']} mismatches")
