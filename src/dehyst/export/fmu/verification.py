"""Checks of an exported FMU: compiles its sources, steps its binary, reads its description with FMPy."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import OutputError
from dehyst.export.compilers import check_folder
from dehyst.export.fmu.interface import interface
from dehyst.export.fmu.loader import Instance
from dehyst.export.fmu.package import step_of
from dehyst.export.signal import Signal, Whole, same_bits
from dehyst.export.subject import Subject
from dehyst.export.targets import Check


def verify(folder: Path, subject: Subject) -> list[Check]:
    """Compile the sources, step the binary, ask FMPy where it is installed."""
    path = folder / f"{subject.name}.fmu"
    signals = [("test signal", subject.test)] + ([("excerpt of the log", subject.excerpt)] if subject.excerpt else [])
    return [
        *check_folder(folder),
        *(_stepped(path, subject, words, signal) for words, signal in signals),
        _validated(path),
    ]


def _stepped(path: Path, subject: Subject, words: str, signal: Signal) -> Check:
    claim = f"the FMU's binary answers the {words} like the model"
    try:
        found = run(path, subject, signal)
    except OutputError as fault:
        return Check(claim, "skipped" if "no binary" in str(fault) else "failed", str(fault))
    outputs, flags = found
    off = np.abs(outputs - signal.outputs).max(axis=0)
    if subject.real == "double":
        good = same_bits(outputs, signal.outputs) and bool((flags == signal.flags).all())
        return Check(
            claim, "passed" if good else "failed", f"{signal.samples} samples, {'' if good else 'not the '}bits"
        )
    good = bool((off <= subject.tolerances).all())
    return Check(claim, "passed" if good else "failed", f"{signal.samples} samples, {off.max():.3g} at most")


def run(path: Path, subject: Subject, signal: Signal) -> tuple[Array, Whole]:
    """Return the outputs (T, k) and flags (T,) of the FMU's binary along a signal.

    Raises
    ------
    OutputError
        If it cannot be loaded or refuses a call.
    """
    variables = interface(subject)
    inputs = [v.name for v in variables if v.kind == "real" and v.role == "input"]
    switches = [v.name for v in variables if v.kind == "truth" and v.role == "input"]
    outputs = [v.name for v in variables if v.kind == "real" and v.role == "output"][: signal.outputs.shape[1]]
    rows, flags = [], []
    with Instance(path) as fmu:
        fmu.enter()
        for k in range(signal.samples):
            for name, value in zip(inputs, signal.inputs[k], strict=True):
                fmu.set(name, [float(value)])
            for bit, name in enumerate(switches):
                fmu.set(name, [int(signal.switch[k]) >> bit & 1])
            if k == 0:
                fmu.exit()
            fmu.step(step_of(subject))
            rows.append([fmu.get(name)[0] for name in outputs])
            flags.append(int(fmu.get("flags")[0]))
    return np.array(rows), np.array(flags, dtype=np.int64)


def _validated(path: Path) -> Check:
    claim = "FMPy finds nothing wrong with the model description"
    if find_spec("fmpy") is None:
        return Check(claim, "skipped", "FMPy is not installed; type: pip install 'dehyst[fmi]'")
    problems = import_module("fmpy.validation").validate_fmu(str(path))
    return Check(claim, "failed" if problems else "passed", "; ".join(map(str, problems[:3])))
