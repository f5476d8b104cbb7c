"""Files beside an .fmu file: its sources, a check that needs only a compiler, tables for FMPy."""

from __future__ import annotations

import csv
import io
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.export import Signal, Subject, Whole
from dehyst.export import kit as export_kit
from dehyst_targets.fmu._description import Variable, Version
from dehyst_targets.fmu._interface import BEYOND
from dehyst_targets.fmu._package import Package, package, single_of, step_of
from dehyst_targets.fmu._sources import hexadecimal

REJECTED = 3  # flags of a block that never do: rejected, rejected ever


def fmu_files(subject: Subject, version: Version) -> dict[str, str | bytes]:
    """Return the files of an FMU of this version of FMI: the .fmu file, and those beside it."""
    fmu = package(subject, version)
    return {f"{subject.name}.fmu": fmu.fmu, **fmu_companions(fmu)}


def fmu_companions(fmu: Package) -> dict[str, str | bytes]:
    """Return relative path -> content of everything beside the .fmu file."""
    subject = fmu.subject
    given_inputs, answers = fmpy_tables(fmu)
    values = export_kit.template_values(subject) | {
        "fmi": fmu.version,
        "single": single_of(subject, fmu.version),
        "implementation": False,
        # The check tries to set one parameter to zero; a unit whose offset follows the last cycle has none.
        "parameter": next(iter(references(fmu, "real", "parameter")), None),
    }
    files: dict[str, str | bytes] = {}
    for path, content in fmu.sources.items():
        files[f"sources/{path}"] = content
    readme = _readme(fmu, values, samples=given_inputs.count("\n") - 1)
    return {
        **files,
        "check/check.c": export_kit.render("fmu/check.c.j2", **values),
        "check/expected.h": _expected(fmu, values),
        "example/main.c": export_kit.render("fmu/main.c.j2", **values, **_example(fmu)),
        "fmpy/input.csv": given_inputs,
        "fmpy/expected.csv": answers,
        "Makefile": export_kit.plain_template("fmu/Makefile"),
        "CMakeLists.txt": export_kit.render("fmu/CMakeLists.txt.j2", **values),
        "README.md": export_kit.with_warning(readme, subject),
    }


def _readme(package: Package, values: dict[str, Any], samples: int) -> str:
    step = step_of(package.subject)
    by_role: dict[str, list[Variable]] = {}
    for variable in package.variables:
        by_role.setdefault(variable.role, []).append(variable)
    return export_kit.render(
        "fmu/README.md.j2",
        **values,
        beyond=BEYOND[package.subject.real],
        token=package.token,
        step=repr(step),
        stop=repr(step * samples),
        binaries=sorted(package.binaries.files),
        missing=package.binaries.missing,
        inputs=by_role.get("input", []),
        answered=_answered(package),
        outputs=by_role.get("output", []),
        parameters=by_role.get("parameter", []),
        locals=by_role.get("local", []),
        constants=len(by_role.get("constant", [])),
    )


def _example(package: Package) -> dict[str, object]:
    """What the example moves and shows: the input of a block, the desired angle of a joint controller."""
    subject = package.subject
    source = references(package, "real", "input")[0]
    result = references(package, "real", "output")[0]
    low, high = subject.input.low, subject.input.high
    if subject.controller:
        input_name, output_name, low, high = subject.controller.example
        for reference, variable in enumerate(package.variables):
            if variable.name == input_name:
                source = reference
            elif variable.name == output_name:
                result = reference
    return {
        "token": package.token,
        "step": hexadecimal(step_of(subject)),
        "input": source,
        "output": result,
        "low": hexadecimal(low or 0.0),
        "high": hexadecimal(high or 0.0),
        "input_name": package.variables[source].name,
        "output_name": package.variables[result].name,
    }


def references(package: Package, kind: str, role: str) -> list[int]:
    """Value references of the signals of a kind, in the order of the tables."""
    return [k for k, v in enumerate(package.variables) if v.kind == kind and v.role == role]


def _expected(package: Package, values: dict[str, Any]) -> str:
    subject = package.subject
    tables = {"test": _rows(subject.test)}
    if subject.excerpt:
        tables["excerpt"] = _rows(subject.excerpt)
    # Flags that are compared: others may hang on the last digit of a float.
    sure = REJECTED
    if subject.controller:
        sure = 0xFFFFFFFF & ~subject.controller.last_digit_flags
    tolerances: list[str] = []
    if subject.real != "double":
        tolerances = list(map(repr, subject.tolerances))
    return export_kit.render(
        "fmu/expected.h.j2",
        parameter=values["parameter"],
        ranges=values["ranges"],
        token=package.token,
        # C99 reads hexadecimal constants without any rounding.
        period=hexadecimal(step_of(subject)),
        sure=sure,
        inputs=references(package, "real", "input"),
        outputs=references(package, "real", "output")[: subject.test.outputs.shape[1]],
        switches=references(package, "truth", "input"),
        flags=references(package, "whole", "output")[0],
        tolerances=tolerances,
        tables=tables,
    )


def _rows(signal: Signal) -> list[list[str]]:
    """Return a signal as C constants: inputs, switch, outputs and flags of each sample."""
    rows = []
    for k in range(signal.samples):
        inputs = map(export_kit.pattern, signal.inputs[k])
        outputs = map(export_kit.pattern, signal.outputs[k])
        rows.append([*inputs, f"{signal.switch[k]}u", *outputs, f"{signal.flags[k]}u"])
    return rows


def fmpy_tables(package: Package) -> tuple[str, str]:
    """Return input and expected output as FMPy reads them, of the samples of the test signal that are numbers.

    FMPy interpolates: a sample that is no number would spoil its neighbours.
    """
    subject = package.subject
    # A unit in float rejects from 1e15 on: below this limit no sample of the tables is rejected.
    good = np.flatnonzero((np.abs(subject.test.inputs) < 1e14).all(axis=1))
    inputs, switch = subject.test.inputs[good], subject.test.switch[good]
    outputs = _answers(subject, inputs, switch)
    time = np.asarray(step_of(subject) * np.arange(good.size + 1))
    names = _variables_of(package, "real", "input")
    switches = _variables_of(package, "truth", "input")
    columns = list(inputs.T)
    for bit in range(len(switches)):
        columns.append((switch >> bit) & 1)
    # FMPy shows the outputs of the start too, before the first step.
    first = [0.0] * outputs.shape[1]
    if subject.block:
        first = [subject.start_output]
    return (
        _table(time[:-1], [*names, *switches], columns),
        _table(time, _answered(package), list(np.vstack([first, outputs]).T)),
    )


def _answered(package: Package) -> list[Variable]:
    """Outputs that the tables hold."""
    return _variables_of(package, "real", "output")[: package.subject.test.outputs.shape[1]]


def _variables_of(package: Package, kind: str, role: str) -> list[Variable]:
    return [package.variables[k] for k in references(package, kind, role)]


def _answers(subject: Subject, inputs: Array, switch: Whole) -> Array:
    """Return the model's outputs (T, k) from a start on."""
    if subject.controller:
        return subject.controller.run(inputs, switch)
    return subject.answer(inputs, switch).outputs


def _table(time: Array, variables: list[Variable], columns: list[Array]) -> str:
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    heading = ["time"]
    for variable in variables:
        heading.append(variable.name)
    out.writerow(heading)
    rows = np.column_stack([time, *columns])
    for row in rows.tolist():
        # repr gives the shortest text that is read back as the same double.
        out.writerow(map(repr, row))
    return text.getvalue()
