"""The description of an FMU: its variables in groups that share value references, and modelDescription.xml."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal
from xml.etree import ElementTree as Xml

import numpy as np

from dehyst.units import DIMENSION, OFFSETS, TABLE

Kind = Literal["real", "whole", "truth"]
Role = Literal["time", "input", "output", "parameter", "local", "constant"]


@dataclass(frozen=True)
class Variable:
    """One variable of an FMU.

    Attributes
    ----------
    name
        As importers show it.
    kind
        Real number, whole number or truth value.
    role
        Time, input, output, parameter that may be set between steps, local to be read, or constant.
    description
        One line.
    unit
        Of real ones, "" for none.
    start
        Start values: one for a scalar, none for time. For a local only their number counts.
    low, high
        Range, where there is one. [unit]
    array
        Whether it is an array, even of one value.
    place
        Index of its first value among the signals of its kind, among all locals, or among all constants.

    Examples
    --------
    >>> Variable("angle", "real", "input", "measured angle", "rad", (0.0,)).length
    1
    """

    name: str
    kind: Kind
    role: Role
    description: str
    unit: str = ""
    start: tuple[float, ...] = ()
    low: float | None = None
    high: float | None = None
    array: bool = False
    place: int = 0

    @property
    def length(self) -> int:
        """Number of values."""
        return max(len(self.start), 1)

    @property
    def nominal(self) -> float | None:
        """Size that is usual: half of the range, or None without a range or without any width."""
        if self.low is None or self.high is None or not self.high > self.low:
            return None
        return max(abs(self.low), abs(self.high))


TIME = Variable("time", "real", "time", "end of the last step", "s")


def placed(variables: Iterable[Variable], *, arrays: bool) -> tuple[Variable, ...]:
    """Give each variable its place, time first; without arrays, every element becomes a variable of its own.

    The place of a variable in the result is its value reference.

    Examples
    --------
    >>> r = Variable("r", "real", "constant", "thresholds", "V", (0.0, 1.0), array=True)
    >>> [v.name for v in placed([r], arrays=False)], placed([r], arrays=True)[1].length
    (['time', 'r[1]', 'r[2]'], 2)
    """
    if not arrays:
        variables = scalars(variables)
    next_place = {"real": 0, "whole": 0, "truth": 0, "local": 0, "constant": 0}
    # Time stands beside the signals: it takes no place among them.
    out = [TIME]
    for variable in variables:
        counter: str = variable.kind
        # The wrapper keeps locals and constants in arrays that do not depend on their type.
        if variable.role in ("local", "constant"):
            counter = variable.role
        out.append(replace(variable, place=next_place[counter]))
        next_place[counter] += variable.length
    return tuple(out)


def scalars(variables: Iterable[Variable]) -> Iterator[Variable]:
    """Split arrays into their elements, ``name[1]`` and so on."""
    for variable in variables:
        if not variable.array:
            yield variable
            continue
        for index, value in enumerate(variable.start, 1):
            yield replace(variable, name=f"{variable.name}[{index}]", start=(value,), array=False)


def variable_count(variables: Sequence[Variable], kind: Kind) -> int:
    """Number of signals of a kind, parameters among them; locals, constants and time not counted."""
    return sum(
        v.length for v in variables if v.kind == kind and v.role in ("input", "output", "parameter")
    )


def fmu_constants(variables: Sequence[Variable]) -> list[float]:
    """Values of all constants in the order of their places."""
    values: list[float] = []
    for variable in variables:
        if variable.role == "constant":
            values += map(float, variable.start)
    return values


Version = Literal[2, 3]
LOG_CATEGORIES = {
    "logStatusError": "calls that were refused; always on",
    "logStatusDiscard": "steps that were not made",
    "logStatusWarning": "rejected samples, sensor faults, limits",
}
# FMI 3.0 has types of every size: these are the ones whose C types the wrapper stores.
_TYPES: dict[int, dict[str, str]] = {
    2: {"real": "Real", "whole": "Integer", "truth": "Boolean"},
    3: {"real": "Float64", "whole": "Int32", "truth": "Boolean"},
}


# dimension of dehyst.units -> exponents of the base units; the first unit of each dimension has the factor 1
_BASE: dict[str, dict[str, int]] = {
    "pressure": {"kg": 1, "m": -1, "s": -2},
    "angle": {"rad": 1},
    "length": {"m": 1},
    "force": {"kg": 1, "m": 1, "s": -2},
    "voltage": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "current": {"A": 1},
    "torque": {"kg": 1, "m": 2, "s": -2},
    "time": {"s": 1},
    "temperature": {"K": 1},
}
# Those of a joint controller that no log has.
_DERIVED: dict[str, dict[str, int]] = {
    "rad/s": {"rad": 1, "s": -1},
    "rad/s^2": {"rad": 1, "s": -2},
    "1/s": {"s": -1},
    "kg.m2": {"kg": 1, "m": 2},
    "m3": {"m": 3},
    "Nm/Pa": {"m": 3},
    "Pa/rad": {"kg": 1, "m": -1, "s": -2, "rad": -1},
    "J/kg": {"m": 2, "s": -2},
    "kg/m3": {"kg": 1, "m": -3},
    # The sonic conductance of a valve is a volume flow for each pascal of pressure.
    "m3/(s.Pa)": {"m": 4, "s": 1, "kg": -1},
}


@dataclass(frozen=True)
class BaseUnit:
    """What a value in a unit is in SI base units: factor times it, and an offset, of their powers."""

    exponents: dict[str, int]
    factor: float = 1.0
    offset: float = 0.0


def base_unit(unit: str) -> BaseUnit | None:
    """Return what FMI calls the base unit, or None for a unit that is known by its name only.

    Examples
    --------
    >>> base_unit("bar")
    BaseUnit(exponents={'kg': 1, 'm': -1, 's': -2}, factor=100000.0, offset=0.0)
    >>> base_unit("furlong") is None
    True
    """
    if unit in _DERIVED:
        return BaseUnit(_DERIVED[unit])
    dimension = DIMENSION.get(unit)
    if not dimension:
        return None
    return BaseUnit(_BASE[dimension], TABLE[dimension][unit], OFFSETS.get(unit, 0.0))


@dataclass(frozen=True)
class Description:
    """What a model description says.

    Attributes
    ----------
    name
        C identifier: model name, model identifier, file names.
    token
        GUID of FMI 2.0, instantiation token of FMI 3.0.
    text
        One line about the model.
    tool
        Name and version of what wrote it.
    variables
        By value reference.
    period
        Fixed period of the samples, None if every communication step is one sample. [s]
    step
        Proposed communication step. [s]
    end
        Proposed end of a first run. [s]
    single
        Whether real numbers but time are of type Float32.
    """

    name: str
    token: str
    text: str
    tool: str
    variables: tuple[Variable, ...]
    period: float | None
    step: float
    end: float
    single: bool = False


def model_description(about: Description, version: Version) -> bytes:
    """Return the file's bytes: the same for the same content."""
    root = Xml.Element("fmiModelDescription", _head(about, version))
    if version == 2:
        simulation = Xml.SubElement(root, "CoSimulation", _capabilities_2(about))
        Xml.SubElement(Xml.SubElement(simulation, "SourceFiles"), "File", name="all.c")
    else:
        Xml.SubElement(root, "CoSimulation", _capabilities_3(about))
    _units(root, about.variables)
    categories = Xml.SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        Xml.SubElement(categories, "Category", name=name, description=text)
    Xml.SubElement(
        root,
        "DefaultExperiment",
        startTime="0",
        stopTime=xml_number(about.end),
        stepSize=xml_number(about.step),
    )
    # The value reference is the index, so that the wrapper finds a variable in its table without a search.
    variables = Xml.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(about.variables):
        if version == 3:
            _variable_3(variables, reference, variable, about.single and is_single(variable))
        elif variable.role != "time":  # optional there, and one importer takes it for a fault
            _variable_2(variables, reference, variable)
    if version == 2:
        _structure_2(root, about.variables)
    else:
        _structure_3(root, about.variables)
    Xml.indent(root)
    return bytes(Xml.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def build_description(name: str) -> bytes:
    """Return sources/buildDescription.xml of FMI 3.0."""
    root = Xml.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = Xml.SubElement(root, "BuildConfiguration", modelIdentifier=name)
    # A fused multiply-add rounds once instead of twice, and the answers would lose the bits of the model.
    files = Xml.SubElement(
        configuration, "SourceFileSet", language="C99", compilerOptions="-ffp-contract=off"
    )
    Xml.SubElement(files, "SourceFile", name="all.c")
    Xml.indent(root)
    return bytes(Xml.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def xml_number(value: float, single: bool = False) -> str:
    """Shortest text that is this double, or this float, again.

    Examples
    --------
    >>> xml_number(0.1), xml_number(0.25), xml_number(0.1 + 1e-12, single=True)
    ('0.1', '0.25', '0.1')
    """
    if single:
        # The digits of a double would promise more than a Float32 holds.
        return str(np.float32(value))
    return repr(float(value))


def is_single(variable: Variable) -> bool:
    """Whether a variable is a Float32 in an FMU of single precision. Time is not: a Float32 would lose its steps."""
    return variable.kind == "real" and variable.role != "time"


def one_line(text: str) -> str:
    """Text that XML can hold, on one line."""
    # XML has no way to write most control characters: each becomes a space.
    for character in set(text):
        if not character.isprintable():
            text = text.replace(character, " ")
    return re.sub(r"\s+", " ", text).strip()


def _head(about: Description, version: Version) -> dict[str, str]:
    token_name = {2: "guid", 3: "instantiationToken"}[version]
    return {
        "fmiVersion": f"{version}.0",
        "modelName": about.name,
        token_name: about.token,
        "description": one_line(about.text),
        "license": "0BSD",
        "generationTool": about.tool,
        # Only with this convention do importers take r[1], r[2] of FMI 2.0 for one array.
        "variableNamingConvention": "structured",
    }


def _truth(value: object) -> str:
    """Return a truth value as XML Schema writes it."""
    return str(bool(value)).lower()


def _capabilities_2(about: Description) -> dict[str, str]:
    return {
        "modelIdentifier": about.name,
        "needsExecutionTool": "false",
        "canHandleVariableCommunicationStepSize": _truth(not about.period),
        "canInterpolateInputs": "false",
        "maxOutputDerivativeOrder": "0",
        "canRunAsynchronuously": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "false",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "false",
    }


def _capabilities_3(about: Description) -> dict[str, str]:
    capabilities = {
        "modelIdentifier": about.name,
        "needsExecutionTool": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "canHandleVariableCommunicationStepSize": "true",
        "hasEventMode": "false",
        "canReturnEarlyAfterIntermediateUpdate": "false",
        "providesIntermediateUpdate": "false",
    }
    # A step may be any whole number of periods, so its size varies; this attribute names the period.
    if about.period:
        capabilities["fixedInternalStepSize"] = xml_number(about.period)
    return capabilities


def _units(root: Xml.Element, variables: tuple[Variable, ...]) -> None:
    names = sorted({one_line(v.unit) for v in variables} - {""})
    definitions = Xml.SubElement(root, "UnitDefinitions")
    # A variable may name only units that are defined here; one that no table knows has no base unit.
    for name in names:
        unit, base = Xml.SubElement(definitions, "Unit", name=name), base_unit(name)
        if base:
            attributes = {key: str(power) for key, power in base.exponents.items()}
            if base.factor != 1:
                attributes["factor"] = xml_number(base.factor)
            if base.offset:
                attributes["offset"] = xml_number(base.offset)
            Xml.SubElement(unit, "BaseUnit", attributes)


def _place(variable: Variable) -> dict[str, str]:
    """Causality, variability and where the start value comes from."""
    if variable.role == "time":
        return {"causality": "independent", "variability": "continuous"}
    if variable.role == "constant":
        return {"causality": "local", "variability": "constant", "initial": "exact"}
    if variable.role == "parameter":
        return {"causality": "parameter", "variability": "tunable", "initial": "exact"}
    # FMI allows whole numbers and truth values to change in jumps only.
    place = {"causality": variable.role, "variability": "discrete"}
    if variable.kind == "real":
        place["variability"] = "continuous"
    if variable.role != "input":
        place["initial"] = "calculated"
    return place


def _values(variable: Variable, single: bool = False) -> dict[str, str]:
    """Attributes that belong to the type."""
    attributes: dict[str, str] = {}
    if one_line(variable.unit):
        attributes["unit"] = one_line(variable.unit)
    if variable.kind == "real" and variable.role in ("input", "output", "parameter"):
        limits = {"min": variable.low, "max": variable.high, "nominal": variable.nominal}
        for key, limit in limits.items():
            if limit is not None:
                attributes[key] = xml_number(limit, single)
    # Outputs and locals are calculated: FMI forbids a start value of theirs.
    if variable.start and variable.role not in ("output", "local"):
        attributes["start"] = " ".join(_text(variable, value, single) for value in variable.start)
    return attributes


def _text(variable: Variable, value: float, single: bool) -> str:
    if variable.kind == "truth":
        return _truth(value)
    if variable.kind == "whole":
        return str(int(value))
    return xml_number(value, single)


def _variable_2(parent: Xml.Element, reference: int, variable: Variable) -> None:
    head = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": one_line(variable.description),
    }
    scalar = Xml.SubElement(parent, "ScalarVariable", head | _place(variable))
    Xml.SubElement(scalar, _TYPES[2][variable.kind], _values(variable))


def _variable_3(parent: Xml.Element, reference: int, variable: Variable, single: bool) -> None:
    head = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": one_line(variable.description),
    }
    place = _place(variable)
    if variable.role == "input":
        # FMI 3.0 lets an input say that its start value holds; FMI 2.0 forbids the attribute there.
        place["initial"] = "exact"
    kind = _TYPES[3][variable.kind]
    if single:
        kind = "Float32"
    element = Xml.SubElement(parent, kind, head | place | _values(variable, single))
    if variable.array:
        Xml.SubElement(element, "Dimension", start=str(variable.length))


def _structure_2(root: Xml.Element, variables: tuple[Variable, ...]) -> None:
    """Outputs belong to the last step: at one and the same time they depend on no input."""
    structure = Xml.SubElement(root, "ModelStructure")
    for group in ("Outputs", "InitialUnknowns"):
        unknowns = Xml.SubElement(structure, group)
        for index, variable in enumerate(variables):  # from 1, for time is not listed
            if variable.role == "output":
                Xml.SubElement(unknowns, "Unknown", index=str(index), dependencies="")


def _structure_3(root: Xml.Element, variables: tuple[Variable, ...]) -> None:
    structure = Xml.SubElement(root, "ModelStructure")
    # FMI 3.0 lists unknowns by value reference, FMI 2.0 by their place in the file.
    for group in ("Output", "InitialUnknown"):
        for reference, variable in enumerate(variables):
            if variable.role == "output":
                Xml.SubElement(structure, group, valueReference=str(reference), dependencies="")
