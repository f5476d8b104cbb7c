"""Function blocks and programs as data, and their text: Structured Text, Siemens SCL and PLCopen XML."""

from __future__ import annotations

import hashlib
import re
import textwrap
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from xml.etree import ElementTree

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from dehyst.errors import ModelFileError, ParameterError
from dehyst.export.iec.parser import ELEMENTARY, LARGEST, REALS, SMALLEST

OPTIMIZED = "{ S7_Optimized_Access := 'TRUE' }"  # of SCL: variables are laid out by the compiler
SECTIONS = ("VAR_INPUT", "VAR_OUTPUT", "VAR RETAIN", "VAR", "VAR CONSTANT")
SHOWN = 12  # digits of a checksum
SCALES = {"ScaleUp": 2.0**112, "ScaleDown": 2.0**-112}


@dataclass(frozen=True)
class Variable:
    """A variable of a unit.

    Parameters
    ----------
    section
        One of `SECTIONS`.
    name
        As it stands in the body.
    type
        BOOL, DINT, UDINT, REAL, LREAL, or the name of a function block.
    initial
        Constants as text: none, one, or with `size` one an element.
    size
        Number of elements of an array that begins at 0; 0: no array.
    comment
        What it is, with its unit.
    """

    section: str
    name: str
    type: str
    initial: tuple[str, ...] = ()
    size: int = 0
    comment: str = ""


@dataclass(frozen=True)
class Pou:
    """A program organisation unit: FUNCTION_BLOCK or PROGRAM, its variables, the statements, a comment on top."""

    kind: str
    name: str
    variables: tuple[Variable, ...]
    body: str
    comment: str

    def section(self, name: str) -> list[Variable]:
        """Return the variables of one section, in order."""
        return [variable for variable in self.variables if variable.section == name]


def structured_text(unit: Pou) -> str:
    """Return the source as IEC 61131-3 has it: CODESYS, TwinCAT and their kin."""
    head = f"{comment(unit.comment)}\n{unit.kind} {unit.name}\n"
    return head + _declarations(unit, quoted=False) + f"\n{unit.body.rstrip()}\n\nEND_{unit.kind}\n"


def siemens_scl(unit: Pou, *, shared: bool = True) -> str:
    """Return the source as an external SCL source of TIA Portal wants it.

    Differences: names of blocks in quotes, # before those of variables, ``VERSION``, ``BEGIN``, no arrays among
    constants, no PROGRAM (a function block instead, to be called from an organisation block). `shared` tables stand
    in a data block that all instances read; those that are not stand in VAR, a copy an instance.
    """
    tables = [v for v in unit.variables if v.section == "VAR CONSTANT" and v.size]
    others = [v for v in unit.variables if v not in tables]
    written, data = {v.name: f"#{v.name}" for v in unit.variables}, ""
    if shared and tables:
        written |= {v.name: f'"{unit.name}_Tables".{v.name}' for v in tables}
        data = _data_block(f"{unit.name}_Tables", tables) + "\n"
    else:
        others = [replace(v, section="VAR") if v in tables else v for v in unit.variables]
    unit = replace(unit, kind="FUNCTION_BLOCK", variables=tuple(others))
    head = f'{comment(unit.comment)}\n{unit.kind} "{unit.name}"\n{OPTIMIZED}\nVERSION : 0.1\n'
    body = _marked(unit.body.rstrip(), written)
    return data + head + _declarations(unit, quoted=True) + f"\nBEGIN\n\n{body}\n\nEND_{unit.kind}\n"


def _data_block(name: str, tables: list[Variable]) -> str:
    """Return tables as a global data block; its values follow BEGIN, one by one, which every version of TIA takes."""
    declared = [_declaration(replace(v, initial=()), quoted=True) for v in tables]
    values = [f"    {v.name}[{k}] := {value};" for v in tables for k, value in enumerate(v.initial)]
    head = f'DATA_BLOCK "{name}"\n{OPTIMIZED}\nVERSION : 0.1\nNON_RETAIN\nSTRUCT'
    return "\n".join([head, *declared, "END_STRUCT;", "", "BEGIN", *values, "END_DATA_BLOCK", ""])


def _marked(body: str, names: Mapping[str, str]) -> str:
    """Write variables of the unit as SCL does: not members, and not in comments."""

    def marked(match: re.Match[str]) -> str:
        return names.get(match[0], match[0])

    parts = re.split(r"(?s)(\(\*.*?\*\))", body)
    return "".join(part if part.startswith("(*") else re.sub(r"(?<![\w.])[A-Za-z_]\w*", marked, part) for part in parts)


def plain(text: str) -> str:
    """Return a text that can stand in a comment: ASCII, no ends and no beginnings of comments, lines kept.

    Examples
    --------
    >>> plain("angle *) [°]")
    'angle * ) [deg]'
    """
    for sign, word in (("°", "deg"), ("µ", "u"), ("μ", "u"), ("²", "^2"), ("³", "^3"), ("(*", "( *"), ("*)", "* )")):
        text = text.replace(sign, word)
    return "".join(c if c == "\n" or " " <= c <= "~" else "?" for c in text)


def comment(text: str) -> str:
    """Return a text as a comment of lines that are not too long."""
    lines = [line for paragraph in plain(text).split("\n") for line in (textwrap.wrap(paragraph, 100) or [""])]
    return "(* " + "\n   ".join(lines) + " *)"


def _declarations(unit: Pou, *, quoted: bool) -> str:
    found = []
    for section in SECTIONS:
        variables = unit.section(section)
        if variables:
            found += [section, *(_declaration(variable, quoted=quoted) for variable in variables), "END_VAR"]
    return "\n".join(found) + "\n"


def _declaration(variable: Variable, *, quoted: bool) -> str:
    elementary = variable.type in ELEMENTARY
    type_ = variable.type if elementary or not quoted else f'"{variable.type}"'
    if variable.size:
        type_ = f"ARRAY[0..{variable.size - 1}] OF {type_}"
    text = f"    {variable.name} : {type_}"
    if variable.initial and variable.size:
        values = textwrap.fill(", ".join(variable.initial), 92, break_long_words=False, break_on_hyphens=False)
        text += " := [\n" + textwrap.indent(values, " " * 8) + "]"
    elif variable.initial:
        text += f" := {variable.initial[0]}"
    return f"{text};" + (f" (* {plain(variable.comment)} *)" if variable.comment else "")


def constant(value: float, type_: str) -> str:
    """Return the shortest decimal constant whose nearest LREAL or REAL is `value`: 17 or 9 digits at most.

    IEC 61131-3 has no hexadecimal floating-point constants; it wants digits on both sides of the point.

    Parameters
    ----------
    value
        Finite; for REAL it is rounded to single precision first.
    type_
        ``"LREAL"`` or ``"REAL"``.

    Raises
    ------
    ParameterError
        If the value is not finite in this type.

    Examples
    --------
    >>> [constant(x, "LREAL") for x in (0.1, 1e-05, -2.0, 1e300)]
    ['0.1', '1.0E-5', '-2.0', '1.0E+300']
    >>> constant(0.1, "REAL")
    '0.1'
    """
    with np.errstate(over="ignore"):
        number = np.float64(value) if type_ == "LREAL" else np.float32(value)
    if not np.isfinite(number):
        raise ParameterError(
            f"{value!r} is no number of type {type_}: a PLC has no constant for it. Export with --real double, or "
            "identify the model in units that give numbers of ordinary size.",
            value=value,
            type=type_,
        )
    text = str(number)
    mantissa, _, exponent = text.partition("e")
    if "." not in mantissa:
        mantissa += ".0"
    return f"{mantissa}E{int(exponent):+d}".replace("E-0", "E-").replace("E+0", "E+") if exponent else mantissa


_ENVIRONMENT = Environment(
    loader=PackageLoader("dehyst.export", "templates/st"), undefined=StrictUndefined, keep_trailing_newline=True
)


def rendered(template: str, **values: object) -> str:
    """Return a template of this target with its values filled in."""
    text = _ENVIRONMENT.get_template(template).render(**values)
    return _counted(re.sub(r"(?m)[ \t]+$", "", text))


def _counted(text: str) -> str:
    """Return a text whose counted loops are written with WHILE: matiec skips a FOR whose ends are equal."""
    counters: list[tuple[str, str]] = []

    def written(match: re.Match[str]) -> str:
        indent, counter, first, last, down = match.groups()
        if counter:
            counters.append((counter, "-" if down else "+"))
            return f"{indent}{counter} := {first};\n{indent}WHILE {counter} {'>=' if down else '<='} {last} DO"
        counter, sign = counters.pop()
        return f"{indent}    {counter} := {counter} {sign} 1;\n{indent}END_WHILE;"

    return re.sub(r"(?m)^( *)(?:FOR (\w+) := (.+) TO (.+?)( BY -1)? DO|END_FOR;)$", written, text)


def block_of(name: str, variables: Sequence[Variable], body: str, about: str) -> Pou:
    """Return a function block with those of the variables that its body names, and with all inputs and outputs.

    A number that is no ordinary REAL, which matiec refuses as a constant of LREAL too, is made of two by multiplying,
    which is exact.
    """
    words = set(re.findall(r"[A-Za-z_]\w*", re.sub(r"(?s)\(\*.*?\*\)", " ", body)))
    declared, products, scales = [], [], set()
    for v in variables:
        if v.name not in words and v.section not in ("VAR_INPUT", "VAR_OUTPUT"):
            continue
        value = float(v.initial[0]) if v.section == "VAR CONSTANT" and v.type in REALS and not v.size else 0.0
        factors = [f"{v.name}Part"]
        while value and not SMALLEST <= abs(value) <= LARGEST:
            factors.append("ScaleDown" if abs(value) < SMALLEST else "ScaleUp")
            value /= SCALES[factors[-1]]
        if len(factors) > 1:
            declared.append(replace(v, name=factors[0], initial=(constant(value, v.type),), comment=""))
            v = replace(v, section="VAR", initial=("0.0",))
            products.append(f"{v.name} := {' * '.join(factors)};\n")
            scales.add((factors[1], v.type))
        declared.append(v)
    declared += [Variable("VAR CONSTANT", s, type_, (constant(SCALES[s], type_),)) for s, type_ in sorted(scales)]
    head = "(* ---- numbers that some compilers refuse as constants *)\n" if products else ""
    return Pou("FUNCTION_BLOCK", name, tuple(declared), head + "".join(products) + body, about)


def names(text: str) -> list[str]:
    """Return the words of a text: names that are declared alike."""
    return text.split()


SPACE = "http://www.plcopen.org/xml/tc6_0201"
XHTML = "http://www.w3.org/1999/xhtml"
HEAD = b'<?xml version="1.0" encoding="utf-8"?>'
_LISTS: tuple[tuple[str, str, dict[str, str]], ...] = (
    ("VAR_INPUT", "inputVars", {}),
    ("VAR_OUTPUT", "outputVars", {}),
    ("VAR RETAIN", "localVars", {"retain": "true"}),
    ("VAR", "localVars", {}),
    ("VAR CONSTANT", "localVars", {"constant": "true"}),
)
_KINDS = {"FUNCTION_BLOCK": "functionBlock", "PROGRAM": "program"}


def plcopen_xml(project: str, units: tuple[Pou, ...], version: str, date: str, model: str) -> bytes:
    """Return a project with these units as PLCopen XML.

    Its headers tell two libraries apart: product and version that wrote it; as version of the content also the first
    digits of the `model`'s checksum, and of one of the units, which limits, ramp and controller change too.
    """
    root = ElementTree.Element("project", {"xmlns": SPACE})
    about = {
        "companyName": "dehyst", "productName": "dehyst", "productVersion": version, "creationDateTime": date,
        "contentDescription": f"{project}, model checksum {model}",
    }  # fmt: skip
    ElementTree.SubElement(root, "fileHeader", about)
    units_checksum = hashlib.sha256("".join(map(structured_text, units)).encode()).hexdigest()
    content = {"name": project, "version": ".".join((version, model[:SHOWN], units_checksum[:SHOWN]))}
    coordinates = ElementTree.SubElement(ElementTree.SubElement(root, "contentHeader", content), "coordinateInfo")
    for language in ("fbd", "ld", "sfc"):
        ElementTree.SubElement(ElementTree.SubElement(coordinates, language), "scaling", {"x": "1", "y": "1"})
    types = ElementTree.SubElement(root, "types")
    ElementTree.SubElement(types, "dataTypes")
    pous = ElementTree.SubElement(types, "pous")
    for unit in units:
        _add_unit(pous, unit)
    ElementTree.SubElement(ElementTree.SubElement(root, "instances"), "configurations")
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return HEAD + f"\n{text}\n".encode()


def _add_unit(pous: ElementTree.Element, unit: Pou) -> None:
    pou = ElementTree.SubElement(pous, "pou", {"name": unit.name, "pouType": _KINDS[unit.kind]})
    interface = ElementTree.SubElement(pou, "interface")
    for section, tag, given in _LISTS:
        variables = unit.section(section)
        if variables:
            found = ElementTree.SubElement(interface, tag, given)
            for variable in variables:
                _add_variable(found, variable)
    body = ElementTree.SubElement(ElementTree.SubElement(pou, "body"), "ST")
    _add_text(body, f"{comment(unit.comment)}\n\n{unit.body.rstrip()}\n")
    _add_text(ElementTree.SubElement(pou, "documentation"), plain(unit.comment))


def _add_text(parent: ElementTree.Element, text: str) -> None:
    ElementTree.SubElement(parent, "xhtml", {"xmlns": XHTML}).text = text


def _add_variable(parent: ElementTree.Element, variable: Variable) -> None:
    found = ElementTree.SubElement(parent, "variable", {"name": variable.name})
    type_ = ElementTree.SubElement(found, "type")
    if variable.size:
        array = ElementTree.SubElement(type_, "array")
        ElementTree.SubElement(array, "dimension", {"lower": "0", "upper": str(variable.size - 1)})
        type_ = ElementTree.SubElement(array, "baseType")
    if variable.type in ELEMENTARY:
        ElementTree.SubElement(type_, variable.type)
    else:
        ElementTree.SubElement(type_, "derived", {"name": variable.type})
    if variable.initial:
        initial = ElementTree.SubElement(found, "initialValue")
        values = ElementTree.SubElement(initial, "arrayValue") if variable.size else initial
        for text in variable.initial:
            place = ElementTree.SubElement(values, "value") if variable.size else values
            ElementTree.SubElement(place, "simpleValue", {"value": text})
    if variable.comment:
        _add_text(ElementTree.SubElement(found, "documentation"), plain(variable.comment))


def text_of(xml: bytes) -> str:
    """Return the units of a PLCopen file as source text, so that what the file says can be run."""
    if not xml.startswith(HEAD) or b"<!" in xml:  # no document type, no entity: nothing that grows while it is read
        raise ModelFileError("the PLCopen XML file does not begin as dehyst writes it, in UTF-8: export it again")
    try:
        root = ElementTree.fromstring(xml)
        pous = root.findall(f"{{{SPACE}}}types/{{{SPACE}}}pous/{{{SPACE}}}pou")
        return "\n".join(_unit_text(pou) for pou in pous)
    except (ElementTree.ParseError, KeyError, AttributeError, TypeError) as error:
        raise ModelFileError(f"the PLCopen XML file is damaged ({error}): export it again") from None


def twincat_source(unit: Pou) -> bytes:
    """Return a unit as a source file of TwinCAT 3 (``.TcPOU``): the IEC 61131-3 text, declaration and body apart."""
    declaration = f"{comment(unit.comment)}\n{unit.kind} {unit.name}\n{_declarations(unit, quoted=False)}"
    parts = [text.replace("]]>", "]] >") for text in (declaration, unit.body.rstrip() + "\n")]  # the end of CDATA
    identity = uuid.uuid5(uuid.NAMESPACE_OID, "".join(parts))
    return HEAD + (
        f'\n<TcPlcObject Version="1.1.0.1" ProductVersion="3.1.4024.0">\n'
        f'  <POU Name="{unit.name}" Id="{{{identity}}}" SpecialFunc="None">\n'
        f"    <Declaration><![CDATA[{parts[0]}]]></Declaration>\n"
        f"    <Implementation>\n      <ST><![CDATA[{parts[1]}]]></ST>\n    </Implementation>\n"
        f"  </POU>\n</TcPlcObject>\n"
    ).encode("ascii")


def text_of_twincat(source: bytes) -> str:
    """Return the unit of a file of TwinCAT as source text."""
    if not source.startswith(HEAD) or b"<!DOCTYPE" in source or b"<!ENTITY" in source:
        raise ModelFileError("the TwinCAT file does not begin as dehyst writes it, in UTF-8: export it again")
    try:
        pou = ElementTree.fromstring(source)[0]
        declaration, body = pou.findtext("Declaration") or "", pou.findtext("Implementation/ST") or ""
        kind = next(kind for kind in _KINDS if re.search(rf"(?m)^{kind} {re.escape(pou.attrib['Name'])}$", declaration))
    except (ElementTree.ParseError, KeyError, IndexError, StopIteration) as error:
        raise ModelFileError(f"the TwinCAT file is damaged ({error}): export it again") from None
    return f"{declaration}\n{body}\nEND_{kind}\n"


def _unit_text(pou: ElementTree.Element) -> str:
    kind = {name: kind for kind, name in _KINDS.items()}[pou.attrib["pouType"]]
    lines = [f"{kind} {pou.attrib['name']}"]
    for found in pou.find(f"{{{SPACE}}}interface"):  # type: ignore[union-attr]
        tag = found.tag.removeprefix(f"{{{SPACE}}}")
        section = next(s for s, name, given in _LISTS if name == tag and given == found.attrib)
        lines += [section, *(_variable_text(variable) for variable in found), "END_VAR"]
    body = pou.find(f"{{{SPACE}}}body/{{{SPACE}}}ST/{{{XHTML}}}xhtml")
    return "\n".join([*lines, str(body.text), f"END_{kind}"])  # type: ignore[union-attr]


def _variable_text(variable: ElementTree.Element) -> str:
    type_ = variable.find(f"{{{SPACE}}}type")
    array = variable.find(f"{{{SPACE}}}type/{{{SPACE}}}array")
    base = type_[0] if array is None else array.find(f"{{{SPACE}}}baseType")[0]  # type: ignore[index]
    name = base.attrib.get("name", base.tag.removeprefix(f"{{{SPACE}}}"))
    values = [value.attrib["value"] for value in variable.iter(f"{{{SPACE}}}simpleValue")]
    initial = f" := [{', '.join(values)}]" if array is not None else f" := {values[0]}" if values else ""
    if array is not None:
        bounds = array.find(f"{{{SPACE}}}dimension").attrib  # type: ignore[union-attr]
        name = f"ARRAY[{bounds['lower']}..{bounds['upper']}] OF {name}"
    return f"{variable.attrib['name']} : {name}{initial if values else ''};"
