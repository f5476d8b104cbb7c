"""What dehyst verify finds out about Structured Text: each form of it, run by the own checker."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import DehystError, OutputError
from dehyst.export.iec import Instance, load
from dehyst.export.signal import Signal, Whole
from dehyst.export.st.pou import text_of, text_of_twincat
from dehyst.export.st.programs import Ports
from dehyst.export.targets import Check


def forms(name: str) -> dict[str, tuple[str, ...]]:
    """Return the forms of a unit and the files that each is made of."""
    return {
        "IEC 61131-3 text": (f"{name}.st", f"{name}_Test.st"),
        "Siemens SCL": (f"{name}.scl", f"{name}_Test.scl"),
        "PLCopen XML": (f"{name}.xml",),
        "TwinCAT": (f"twincat/{name}.TcPOU", f"twincat/{name}_Test.TcPOU"),
    }


def check_forms(
    folder: Path, name: str, real: str, ports: Ports, signals: Mapping[str, Signal], tolerances: Sequence[float]
) -> list[Check]:
    """Run each form with every signal and its own test program.

    Parameters
    ----------
    folder
        That was exported.
    name, real
        Of the function block; LREAL or REAL.
    ports
        Its inputs and outputs.
    signals
        By what they are called.
    tolerances
        Largest difference of each output in REAL; LREAL must have the same bits.
    """
    found = []
    for form, paths in forms(name).items():
        claim = f"{form}, own checker: well formed, types agree"
        try:
            library = load("\n".join(source(folder / path) for path in paths))
            found.append(Check(claim, "passed", ", ".join(paths)))
            for label, signal in signals.items():
                claim = f"{form}, own checker: {label}"
                found.append(_compare(library.new(name), claim, real, ports, signal, tolerances))
            claim = f"{form}, own checker: the PLC's own test"
            found.append(_test_program(library.new(f"{name}_Test"), claim))
        except KeyError as fault:
            found.append(Check(claim, "failed", f"it holds no {fault}: export again"))
        except DehystError as fault:
            found.append(Check(claim, "failed", str(fault)))
    return found


def source(path: Path) -> str:
    """Return the text of a file; of XML the text that its elements say.

    Raises
    ------
    OutputError
        If the file cannot be read.
    """
    try:
        content = path.read_bytes()
        read = {".xml": text_of, ".TcPOU": text_of_twincat}.get(path.suffix)
        return read(content) if read else content.decode("ascii")
    except (OSError, UnicodeDecodeError) as fault:
        raise OutputError(f"'{path.name}' cannot be read ({fault}). Export again.", path=str(path)) from None


def _compare(unit: Instance, claim: str, real: str, ports: Ports, signal: Signal, tolerances: Sequence[float]) -> Check:
    outputs, flags = run(unit, ports, signal)
    with np.errstate(invalid="ignore"):
        error = np.abs(outputs - signal.outputs)
    if real == "LREAL":
        good = (outputs.view(np.uint64) == signal.outputs.view(np.uint64)).all(axis=1) & (flags == signal.flags)
    else:
        good = (error <= np.asarray(tolerances)).all(axis=1) & ((flags ^ signal.flags) & ports.sure == 0)
    if not good.all():
        k = int(np.flatnonzero(~good)[0])
        detail = f"sample {k}: {outputs[k].tolist()}, flags {flags[k]}; the model {signal.outputs[k].tolist()}"
        return Check(claim, "failed", f"{detail}, flags {signal.flags[k]}")
    size = np.max(np.abs(signal.outputs), axis=0, initial=np.finfo(np.float64).tiny)
    worst = float(np.max(error / size, initial=0.0))
    words = "bit for bit the model" if real == "LREAL" else f"within {worst:.2g} of the largest output"
    return Check(claim, "passed", f"{signal.samples} samples, {words}")


def run(unit: Instance, ports: Ports, signal: Signal) -> tuple[Array, Whole]:
    """Return outputs (T, k) and flags (T,) of a fresh instance."""
    rows = [ports.call(unit, signal, k) for k in range(signal.samples)]
    outputs = np.array([[row[name] for name in ports.outputs] for row in rows], dtype=np.float64)
    return outputs, np.array([row["FlagWord"] for row in rows], dtype=np.int64)


def _test_program(program: Instance, claim: str) -> Check:
    calls = int(program.value("LastSample")) + 1
    for _ in range(calls):
        out = program.call()
    good = bool(out["Finished"]) and bool(out["Passed"])
    return Check(claim, "passed" if good else "failed", f"{calls} calls, {out['Mismatches']} mismatches")
