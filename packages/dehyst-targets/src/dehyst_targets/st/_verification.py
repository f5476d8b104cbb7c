"""What dehyst verify finds out about Structured Text: each form of it, run by the own checker."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import DehystError, OutputError
from dehyst.export import Check, Signal, Whole
from dehyst_targets.iec import Instance, load_program
from dehyst_targets.st._pou import st_text, text_of_twincat
from dehyst_targets.st._programs import Ports


def forms(name: str) -> dict[str, tuple[str, ...]]:
    """Return the forms of a unit and the files that each is made of."""
    return {
        "IEC 61131-3 text": (f"{name}.st", f"{name}_Test.st"),
        "Siemens SCL": (f"{name}.scl", f"{name}_Test.scl"),
        "PLCopen XML": (f"{name}.xml",),
        "TwinCAT": (f"twincat/{name}.TcPOU", f"twincat/{name}_Test.TcPOU"),
    }


def check_forms(
    folder: Path,
    name: str,
    real: str,
    ports: Ports,
    signals: Mapping[str, Signal],
    tolerances: Sequence[float],
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
    checks = []
    for form, paths in forms(name).items():
        claim = f"{form}, own checker: well formed, types agree"
        try:
            library = load_program("\n".join(source(folder / path) for path in paths))
            checks.append(Check(claim, "passed", ", ".join(paths)))
            for label, signal in signals.items():
                claim = f"{form}, own checker: {label}"
                checks.append(_compare(library.new(name), claim, real, ports, signal, tolerances))
            claim = f"{form}, own checker: the PLC's own test"
            checks.append(_test_program(library.new(f"{name}_Test"), claim))
        except KeyError as fault:
            checks.append(Check(claim, "failed", f"it holds no {fault}: export again"))
        except DehystError as fault:
            checks.append(Check(claim, "failed", str(fault)))
    return checks


def source(path: Path) -> str:
    """Return the text of a file; of XML the text that its elements say.

    Raises
    ------
    OutputError
        If the file cannot be read.
    """
    try:
        content = path.read_bytes()
        if path.suffix == ".xml":
            return st_text(content)
        if path.suffix == ".TcPOU":
            return text_of_twincat(content)
        return content.decode("ascii")
    except (OSError, UnicodeDecodeError) as fault:
        raise OutputError(
            f"'{path.name}' cannot be read ({fault}). Export again.", path=str(path)
        ) from None


def _compare(
    unit: Instance, claim: str, real: str, ports: Ports, signal: Signal, tolerances: Sequence[float]
) -> Check:
    outputs, flags = run_blocks(unit, ports, signal)
    with np.errstate(invalid="ignore"):
        error = np.abs(outputs - signal.outputs)
    if real == "LREAL":
        # Bits are compared, so that -0 and NaN count too.
        good = (outputs.view(np.uint64) == signal.outputs.view(np.uint64)).all(axis=1)
        good &= flags == signal.flags
    else:
        # Whether a limit was met may hang on the last digit of a REAL.
        good = (error <= np.asarray(tolerances)).all(axis=1)
        good &= (flags ^ signal.flags) & ports.sure == 0
    if not good.all():
        k = int(np.flatnonzero(~good)[0])
        detail = f"sample {k}: {outputs[k].tolist()}, flags {flags[k]}; the model {signal.outputs[k].tolist()}"
        return Check(claim, "failed", f"{detail}, flags {signal.flags[k]}")
    size = np.max(np.abs(signal.outputs), axis=0, initial=np.finfo(np.float64).tiny)
    worst = float(np.max(error / size, initial=0.0))
    words = f"within {worst:.2g} of the largest output"
    if real == "LREAL":
        words = "bit for bit the model"
    return Check(claim, "passed", f"{signal.samples} samples, {words}")


def run_blocks(unit: Instance, ports: Ports, signal: Signal) -> tuple[Array, Whole]:
    """Return outputs (T, k) and flags (T,) of a fresh instance."""
    outputs = np.empty((signal.samples, len(ports.outputs)))
    flags = np.empty(signal.samples, dtype=np.int64)
    for k in range(signal.samples):
        answer = ports.call(unit, signal, k)
        outputs[k] = [answer[name] for name in ports.outputs]
        flags[k] = answer["FlagWord"]
    return outputs, flags


def _test_program(program: Instance, claim: str) -> Check:
    calls = int(program.value("LastSample")) + 1
    for _ in range(calls):
        out = program.call()
    detail = f"{calls} calls, {out['Mismatches']} mismatches"
    if out["Finished"] and out["Passed"]:
        return Check(claim, "passed", detail)
    return Check(claim, "failed", detail)
