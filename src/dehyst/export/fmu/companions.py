"""Files beside an .fmu file: its sources, a check that needs only a compiler, tables for FMPy."""

from __future__ import annotations

import csv
import io
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.export.c import template_values, with_warning
from dehyst.export.fmu.description import Variable
from dehyst.export.fmu.interface import BEYOND
from dehyst.export.fmu.package import Package, single_of, step_of
from dehyst.export.fmu.sources import hexadecimal
from dehyst.export.precision import pattern
from dehyst.export.rendering import TEMPLATES, render
from dehyst.export.signal import Signal, Whole
from dehyst.export.subject import Subject

REJECTED = 3  # flags of a block that never do: rejected, rejected ever


def companions(package: Package) -> dict[str, str | bytes]:
    """Return relative path -> content of everything beside the .fmu file."""
    subject = package.subject
    given, answers = fmpy_tables(package)
    scale = next(iter(references(package, "real", "parameter")), None)
    values = template_values(subject) | {
        "fmi": package.version,
        "single": single_of(subject, package.version),
        "implementation": False,
        "parameter": scale,
    }
    return {
        **{f"sources/{path}": content for path, content in package.sources.items()},
        "check/check.c": render("fmu/check.c.j2", **values),
        "check/expected.h": _expected(package, values),
        "example/main.c": render("fmu/main.c.j2", **values, **_example(package)),
        "fmpy/input.csv": given,
        "fmpy/expected.csv": answers,
        "Makefile": (TEMPLATES / "fmu" / "Makefile").read_text(encoding="utf-8"),
        "CMakeLists.txt": render("fmu/CMakeLists.txt.j2", **values),
        "README.md": with_warning(
            render(
                "fmu/README.md.j2",
                **values,
                beyond=BEYOND[subject.real],
                token=package.token,
                step=repr(step_of(subject)),
                stop=repr(step_of(subject) * (given.count("\n") - 1)),
                binaries=sorted(package.binaries.files),
                missing=package.binaries.missing,
                inputs=[v for v in package.variables if v.role == "input"],
                answered=_answered(package),
                outputs=[v for v in package.variables if v.role == "output"],
                parameters=[v for v in package.variables if v.role == "parameter"],
                locals=[v for v in package.variables if v.role == "local"],
                constants=sum(v.role == "constant" for v in package.variables),
            ),
            subject,
        ),
    }


def _example(package: Package) -> dict[str, object]:
    """What the example moves and shows: the input of a block, the desired angle of a joint controller."""
    subject = package.subject
    numbers = {variable.name: number for number, variable in enumerate(package.variables)}
    source, result = references(package, "real", "input")[0], references(package, "real", "output")[0]
    low, high = subject.input.low, subject.input.high
    if subject.controller:
        moved, shown, low, high = subject.controller.example
        source, result = numbers[moved], numbers[shown]
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
    tables = {"test": subject.test} | ({"excerpt": subject.excerpt} if subject.excerpt else {})
    sure = 0xFFFFFFFF & ~subject.controller.last_digit_flags if subject.controller else REJECTED
    return render(
        "fmu/expected.h.j2",
        parameter=values["parameter"],
        ranges=values["ranges"],
        token=package.token,
        period=hexadecimal(step_of(subject)),
        sure=sure,
        inputs=references(package, "real", "input"),
        outputs=references(package, "real", "output")[: subject.test.outputs.shape[1]],
        switches=references(package, "truth", "input"),
        flags=references(package, "whole", "output")[0],
        tolerances=[] if subject.real == "double" else [repr(value) for value in subject.tolerances],
        tables={name: [_row(signal, k) for k in range(signal.samples)] for name, signal in tables.items()},
    )


def _row(signal: Signal, k: int) -> list[str]:
    inputs, outputs = (list(map(pattern, table[k])) for table in (signal.inputs, signal.outputs))
    return [*inputs, f"{int(signal.switch[k])}u", *outputs, f"{int(signal.flags[k])}u"]


def fmpy_tables(package: Package) -> tuple[str, str]:
    """Return input and expected output as FMPy reads them, of the samples of the test signal that are numbers.

    FMPy interpolates: a sample that is no number would spoil its neighbours.
    """
    subject = package.subject
    good = np.flatnonzero((np.abs(subject.test.inputs) < 1e14).all(axis=1))
    inputs, switch = subject.test.inputs[good], subject.test.switch[good]
    outputs = _answers(subject, inputs, switch)
    time = np.asarray(step_of(subject) * np.arange(good.size + 1))
    names = [package.variables[k] for k in references(package, "real", "input")]
    switches = [package.variables[k] for k in references(package, "truth", "input")]
    columns = [*inputs.T, *((switch >> bit) & 1 for bit in range(len(switches)))]
    first = [subject.start_output] if subject.block else [0.0] * outputs.shape[1]
    return (
        _table(time[:-1], [*names, *switches], columns),
        _table(time, _answered(package), list(np.vstack([first, outputs]).T)),
    )


def _answered(package: Package) -> list[Variable]:
    """Outputs that the tables hold."""
    outputs = [package.variables[k] for k in references(package, "real", "output")]
    return outputs[: package.subject.test.outputs.shape[1]]


def _answers(subject: Subject, inputs: Array, switch: Whole) -> Array:
    """Return the model's outputs (T, k) from a start on."""
    if subject.controller:
        return subject.controller.run(inputs, switch)
    return subject.answer(inputs, switch).outputs


def _table(time: Array, variables: list[Variable], columns: list[Array]) -> str:
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    out.writerow(["time", *(variable.name for variable in variables)])
    for k, t in enumerate(time):
        out.writerow([repr(float(t)), *(repr(float(column[k])) for column in columns)])
    return text.getvalue()
