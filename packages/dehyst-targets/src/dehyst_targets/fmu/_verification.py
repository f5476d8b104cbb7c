"""Checks of an exported FMU: compiles its sources, and lets FMPy step its binary and read its description."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import OutputError
from dehyst.export import Check, Signal, Subject, Whole
from dehyst.export import kit as export_kit
from dehyst_targets.fmu._interface import fmu_interface
from dehyst_targets.fmu._package import step_of

# FMPy hands the messages of every FMU of FMI 2.0 to the logger that was named last, even when its instance is gone.
_LOGGERS: list[Any] = []
WITHOUT_FMPY = "FMPy is not installed; type: pip install 'dehyst-targets[fmi]'"


def check_fmu(folder: Path, subject: Subject) -> list[Check]:
    """Compile the sources; where FMPy is installed, let it step the binary and look for faults in the description."""
    path = folder / f"{subject.name}.fmu"
    checks = [
        *export_kit.check_folder(folder),
        _stepped(path, subject, "test signal", subject.test),
    ]
    if subject.excerpt:
        checks.append(_stepped(path, subject, "excerpt of the log", subject.excerpt))
    checks.append(_validated(path))
    return checks


def _stepped(path: Path, subject: Subject, words: str, signal: Signal) -> Check:
    claim = f"the FMU's binary answers the {words} like the model"
    if find_spec("fmpy") is None:
        return Check(claim, "skipped", WITHOUT_FMPY)
    fmpy: Any = import_module("fmpy")
    if fmpy.platform not in fmpy.supported_platforms(str(path)):
        return Check(
            claim,
            "skipped",
            f"the FMU has no binary for this machine ({fmpy.platform}). Export it on a machine with a compiler for "
            f"it, or type, in a copy: fmpy compile {path.name}",
        )
    try:
        outputs, flags = run_fmu(path, subject, signal)
    except OutputError as fault:
        return Check(claim, "failed", str(fault))
    if subject.real == "double":
        good = export_kit.same_bits(outputs, signal.outputs) and bool((flags == signal.flags).all())
        detail = f"{signal.samples} samples, bits"
        if not good:
            detail = f"{signal.samples} samples, not the bits"
    else:
        off = np.abs(outputs - signal.outputs).max(axis=0)
        good = bool((off <= subject.tolerances).all())
        detail = f"{signal.samples} samples, {off.max():.3g} at most"
    return Check(claim, "passed" if good else "failed", detail)


def run_fmu(path: Path, subject: Subject, signal: Signal) -> tuple[Array, Whole]:
    """Return the outputs (T, k) and flags (T,) of the FMU's binary along a signal, stepped by FMPy.

    Raises
    ------
    OutputError
        If it cannot be loaded or refuses a call.
    """
    variables = fmu_interface(subject)
    names: dict[tuple[str, str], list[str]] = {}
    for v in variables:
        names.setdefault((v.kind, v.role), []).append(v.name)
    inputs, switches = names["real", "input"], names.get(("truth", "input"), [])
    outputs = names["real", "output"][: signal.outputs.shape[1]]
    rows = np.empty(signal.outputs.shape)
    flags = np.empty(signal.samples, dtype=np.int64)
    step = step_of(subject)
    with _instance(path) as (fmu, description):
        types, number = {}, {}
        for v in description.modelVariables:
            types[v.name], number[v.name] = v.type, v.valueReference
        real, whole = types[inputs[0]], types["flags"]
        set_real, get_real = getattr(fmu, f"set{real}"), getattr(fmu, f"get{real}")
        get_whole = getattr(fmu, f"get{whole}")
        input_numbers = [number[name] for name in inputs]
        switch_numbers = [number[name] for name in switches]
        output_numbers = [number[name] for name in outputs]
        # FMI 3.0 takes the start time when initialization begins, and has no call for it.
        if description.fmiVersion == "2.0":
            fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        for k in range(signal.samples):
            set_real(input_numbers, signal.inputs[k].tolist())
            pattern = int(signal.switch[k])
            fmu.setBoolean(
                switch_numbers, [bool(pattern >> bit & 1) for bit in range(len(switches))]
            )
            # The controller of a joint starts at rest at what its sensors say before this call.
            if k == 0:
                fmu.exitInitializationMode()
            fmu.doStep(k * step, step)
            rows[k] = get_real(output_numbers)
            flags[k] = get_whole([number["flags"]])[0]
    return rows, flags


@contextmanager
def _instance(path: Path) -> Iterator[tuple[Any, Any]]:
    """FMPy's instance of an FMU with its model description; what the FMU says about a refused call is in the error."""
    fmpy: Any = import_module("fmpy")
    messages: list[str] = []

    # FMI 2.0 passes five values, FMI 3.0 four; the text is the last one.
    def note(*values: Any) -> None:
        messages.append(values[-1].decode())

    try:
        with tempfile.TemporaryDirectory() as folder:
            description = fmpy.read_model_description(str(path))
            fmu = fmpy.instantiate_fmu(
                fmpy.extract(str(path), folder), description, "CoSimulation", logger=note
            )
            _LOGGERS.append(fmu.callbacks)
            try:
                yield fmu, description
            finally:
                fmu.freeInstance()
    except Exception as fault:  # FMPy has no class of errors of its own
        message = ""
        if messages:
            message = f": {messages[-1]}"
        raise OutputError(
            f"FMPy cannot run '{path.name}': {fault}{message} Export it again.", path=path.name
        ) from fault


def _validated(path: Path) -> Check:
    claim = "FMPy finds nothing wrong with the model description"
    if find_spec("fmpy") is None:
        return Check(claim, "skipped", WITHOUT_FMPY)
    problems = import_module("fmpy.validation").validate_fmu(str(path))
    return Check(claim, "failed" if problems else "passed", "; ".join(map(str, problems[:3])))
