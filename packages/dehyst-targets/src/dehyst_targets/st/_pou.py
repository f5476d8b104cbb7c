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
from dehyst_targets.iec import ELEMENTARY, LARGEST, REALS, SMALLEST

OPTIMIZED = "{ S7_Optimized_Access := 'TRUE' }"  # of SCL: variables are laid out by the compiler
SECTIONS = ("VAR_INPUT", "VAR_OUTPUT", "VAR RETAIN", "VAR", "VAR CONSTANT")
SHOWN = 12  # digits of a checksum
# REAL holds both, and products of several of them reach every number of LREAL.
SCALES = {"ScaleUp": 2.0**112, "ScaleDown": 2.0**-112}


@dataclass(frozen=True)
class PouVariable:
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
    variables: tuple[PouVariable, ...]
    body: str
    comment: str

    def section(self, name: str) -> list[PouVariable]:
        """Return the variables of one section, in order."""
        return [variable for variable in self.variables if variable.section == name]


def structured_text(unit: Pou) -> str:
    """Return the source as IEC 61131-3 has it: CODESYS, TwinCAT and their kin."""
    head = f"{st_comment(unit.comment)}\n{unit.kind} {unit.name}\n"
    return head + _declarations(unit, quoted=False) + f"\n{unit.body.rstrip()}\n\nEND_{unit.kind}\n"


def siemens_scl(unit: Pou, *, shared: bool = True) -> str:
    """Return the source as an external SCL source of TIA Portal wants it.

    Differences: names of blocks in quotes, # before those of variables, ``VERSION``, ``BEGIN``, no arrays among
    constants, no PROGRAM (a function block instead, to be called from an organisation block). `shared` tables stand
    in a data block that all instances read; those that are not stand in VAR, a copy an instance.
    """
    tables, declared, scl_names = [], [], {}
    for variable in unit.variables:
        scl_names[variable.name] = f"#{variable.name}"
        if variable.section != "VAR CONSTANT" or not variable.size:
            declared.append(variable)
        elif shared:
            tables.append(variable)
            scl_names[variable.name] = f'"{unit.name}_Tables".{variable.name}'
        else:
            # SCL has no constant arrays: without a data block each instance holds the table.
            declared.append(replace(variable, section="VAR"))
    data = ""
    if tables:
        data = _data_block(f"{unit.name}_Tables", tables) + "\n"
    unit = replace(unit, kind="FUNCTION_BLOCK", variables=tuple(declared))
    head = f'{st_comment(unit.comment)}\n{unit.kind} "{unit.name}"\n{OPTIMIZED}\nVERSION : 0.1\n'
    body = _marked(unit.body.rstrip(), scl_names)
    return (
        data + head + _declarations(unit, quoted=True) + f"\nBEGIN\n\n{body}\n\nEND_{unit.kind}\n"
    )


def _data_block(name: str, tables: list[PouVariable]) -> str:
    """Return tables as a global data block; its values follow BEGIN, one by one, which every version of TIA takes."""
    declared = [_declaration(replace(v, initial=()), quoted=True) for v in tables]
    values = []
    for table in tables:
        for index, value in enumerate(table.initial):
            values.append(f"    {table.name}[{index}] := {value};")
    head = f'DATA_BLOCK "{name}"\n{OPTIMIZED}\nVERSION : 0.1\nNON_RETAIN\nSTRUCT'
    return "\n".join([head, *declared, "END_STRUCT;", "", "BEGIN", *values, "END_DATA_BLOCK", ""])


def _marked(body: str, names: Mapping[str, str]) -> str:
    """Write variables of the unit as SCL does: not members, and not in comments."""

    def marked(match: re.Match[str]) -> str:
        return names.get(match[0], match[0])

    # Comments and code take turns, because the pattern has one group.
    parts = re.split(r"(?s)(\(\*.*?\*\))", body)
    for index, part in enumerate(parts):
        if not part.startswith("(*"):
            parts[index] = re.sub(r"(?<![\w.])[A-Za-z_]\w*", marked, part)
    return "".join(parts)


def plain_word(text: str) -> str:
    """Return a text that can stand in a comment: ASCII, no ends and no beginnings of comments, lines kept.

    Examples
    --------
    >>> plain_word("angle *) [°]")
    'angle * ) [deg]'
    """
    for sign, word in (
        ("°", "deg"),
        ("µ", "u"),
        ("μ", "u"),
        ("²", "^2"),
        ("³", "^3"),
        ("(*", "( *"),
        ("*)", "* )"),
    ):
        text = text.replace(sign, word)
    return "".join(c if c == "\n" or " " <= c <= "~" else "?" for c in text)


def st_comment(text: str) -> str:
    """Return a text as a comment of lines that are not too long."""
    lines: list[str] = []
    for paragraph in plain_word(text).split("\n"):
        # An empty paragraph stays an empty line.
        lines += textwrap.wrap(paragraph, 100) or [""]
    return "(* " + "\n   ".join(lines) + " *)"


def _declarations(unit: Pou, *, quoted: bool) -> str:
    lines = []
    for section in SECTIONS:
        variables = unit.section(section)
        # Some tools refuse an empty section.
        if variables:
            lines.append(section)
            for variable in variables:
                lines.append(_declaration(variable, quoted=quoted))
            lines.append("END_VAR")
    return "\n".join(lines) + "\n"


def _declaration(variable: PouVariable, *, quoted: bool) -> str:
    type_ = variable.type
    if quoted and type_ not in ELEMENTARY:
        type_ = f'"{type_}"'
    if variable.size:
        type_ = f"ARRAY[0..{variable.size - 1}] OF {type_}"
    text = f"    {variable.name} : {type_}"
    if variable.initial and variable.size:
        # A minus sign is a hyphen to textwrap, which must not break a line behind it.
        values = textwrap.fill(
            ", ".join(variable.initial), 92, break_long_words=False, break_on_hyphens=False
        )
        text += " := [\n" + textwrap.indent(values, " " * 8) + "]"
    elif variable.initial:
        text += f" := {variable.initial[0]}"
    text += ";"
    if variable.comment:
        text += f" (* {plain_word(variable.comment)} *)"
    return text


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
    # What is beyond REAL becomes infinite here, and is refused below with a cure.
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
    if not exponent:
        return mantissa
    return f"{mantissa}E{int(exponent):+d}"


# A misspelt value in a template stops the export, because a gap in a program could stay unseen.
_ENVIRONMENT = Environment(
    loader=PackageLoader("dehyst_targets", "templates/st"),
    undefined=StrictUndefined,
    keep_trailing_newline=True,
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
            sign, comparison = "+", "<="
            if down:
                sign, comparison = "-", ">="
            # The end of the loop counts on, and loops are nested: the innermost ends first.
            counters.append((counter, sign))
            return f"{indent}{counter} := {first};\n{indent}WHILE {counter} {comparison} {last} DO"
        counter, sign = counters.pop()
        return f"{indent}    {counter} := {counter} {sign} 1;\n{indent}END_WHILE;"

    return re.sub(r"(?m)^( *)(?:FOR (\w+) := (.+) TO (.+?)( BY -1)? DO|END_FOR;)$", written, text)


def block_of(name: str, variables: Sequence[PouVariable], body: str, about: str) -> Pou:
    """Return a function block with those of the variables that its body names, and with all inputs and outputs.

    A number that is no ordinary REAL, which matiec refuses as a constant of LREAL too, is made of two by multiplying,
    which is exact.
    """
    words = set(re.findall(r"[A-Za-z_]\w*", re.sub(r"(?s)\(\*.*?\*\)", " ", body)))
    declared, products, scales = [], [], set()
    for v in variables:
        if v.name not in words and v.section not in ("VAR_INPUT", "VAR_OUTPUT"):
            continue
        value = 0.0
        if v.section == "VAR CONSTANT" and v.type in REALS and not v.size:
            value = float(v.initial[0])
        # Powers of two change the exponent only: the product has the same bits as the number.
        factors = [f"{v.name}Part"]
        while value and not SMALLEST <= abs(value) <= LARGEST:
            scale = "ScaleUp"
            if abs(value) < SMALLEST:
                scale = "ScaleDown"
            factors.append(scale)
            value /= SCALES[scale]
        if len(factors) > 1:
            declared.append(
                replace(v, name=factors[0], initial=(constant(value, v.type),), comment="")
            )
            v = replace(v, section="VAR", initial=("0.0",))
            products.append(f"{v.name} := {' * '.join(factors)};\n")
            scales.add((factors[1], v.type))
        declared.append(v)
    for scale, type_ in sorted(scales):
        initial = (constant(SCALES[scale], type_),)
        declared.append(PouVariable("VAR CONSTANT", scale, type_, initial))
    head = ""
    if products:
        head = "(* ---- numbers that some compilers refuse as constants *)\n"
    return Pou("FUNCTION_BLOCK", name, tuple(declared), head + "".join(products) + body, about)


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
    content = {
        "name": project,
        "version": ".".join((version, model[:SHOWN], units_checksum[:SHOWN])),
    }
    coordinates = ElementTree.SubElement(
        ElementTree.SubElement(root, "contentHeader", content), "coordinateInfo"
    )
    # The schema wants a scaling for each graphical language, although nothing is drawn here.
    for language in ("fbd", "ld", "sfc"):
        ElementTree.SubElement(
            ElementTree.SubElement(coordinates, language), "scaling", {"x": "1", "y": "1"}
        )
    # It also wants the elements dataTypes and configurations, empty as they are.
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
    for section, tag, attributes in _LISTS:
        variables = unit.section(section)
        if variables:
            declarations = ElementTree.SubElement(interface, tag, attributes)
            for variable in variables:
                _add_variable(declarations, variable)
    body = ElementTree.SubElement(ElementTree.SubElement(pou, "body"), "ST")
    _add_text(body, f"{st_comment(unit.comment)}\n\n{unit.body.rstrip()}\n")
    _add_text(ElementTree.SubElement(pou, "documentation"), plain_word(unit.comment))


def _add_text(parent: ElementTree.Element, text: str) -> None:
    ElementTree.SubElement(parent, "xhtml", {"xmlns": XHTML}).text = text


def _add_variable(parent: ElementTree.Element, variable: PouVariable) -> None:
    element = ElementTree.SubElement(parent, "variable", {"name": variable.name})
    type_ = ElementTree.SubElement(element, "type")
    if variable.size:
        array = ElementTree.SubElement(type_, "array")
        ElementTree.SubElement(array, "dimension", {"lower": "0", "upper": str(variable.size - 1)})
        type_ = ElementTree.SubElement(array, "baseType")
    if variable.type in ELEMENTARY:
        ElementTree.SubElement(type_, variable.type)
    else:
        ElementTree.SubElement(type_, "derived", {"name": variable.type})
    if variable.initial:
        values = ElementTree.SubElement(element, "initialValue")
        if variable.size:
            values = ElementTree.SubElement(values, "arrayValue")
        for text in variable.initial:
            parent_of_value = values
            if variable.size:
                parent_of_value = ElementTree.SubElement(values, "value")
            ElementTree.SubElement(parent_of_value, "simpleValue", {"value": text})
    if variable.comment:
        _add_text(ElementTree.SubElement(element, "documentation"), plain_word(variable.comment))


def st_text(xml: bytes) -> str:
    """Return the units of a PLCopen file as source text, so that what the file says can be run."""
    # A document type or an entity could grow without limit while it is read.
    if not xml.startswith(HEAD) or b"<!" in xml:
        raise ModelFileError(
            "the PLCopen XML file does not begin as dehyst writes it, in UTF-8: export it again"
        )
    try:
        root = ElementTree.fromstring(xml)
        pous = root.findall(f"{{{SPACE}}}types/{{{SPACE}}}pous/{{{SPACE}}}pou")
        return "\n".join(map(_unit_text, pous))
    except (ElementTree.ParseError, KeyError, AttributeError, TypeError) as error:
        raise ModelFileError(
            f"the PLCopen XML file is damaged ({error}): export it again"
        ) from None


def twincat_source(unit: Pou) -> bytes:
    """Return a unit as a source file of TwinCAT 3 (``.TcPOU``): the IEC 61131-3 text, declaration and body apart."""
    declaration = (
        f"{st_comment(unit.comment)}\n{unit.kind} {unit.name}\n{_declarations(unit, quoted=False)}"
    )
    # "]]>" would end the section CDATA.
    declaration = declaration.replace("]]>", "]] >")
    body = f"{unit.body.rstrip()}\n".replace("]]>", "]] >")
    # TwinCAT knows an object by its identity; made of the text, it makes equal exports equal files.
    identity = uuid.uuid5(uuid.NAMESPACE_OID, declaration + body)
    return HEAD + (
        f'\n<TcPlcObject Version="1.1.0.1" ProductVersion="3.1.4024.0">\n'
        f'  <POU Name="{unit.name}" Id="{{{identity}}}" SpecialFunc="None">\n'
        f"    <Declaration><![CDATA[{declaration}]]></Declaration>\n"
        f"    <Implementation>\n      <ST><![CDATA[{body}]]></ST>\n    </Implementation>\n"
        f"  </POU>\n</TcPlcObject>\n"
    ).encode("ascii")


def text_of_twincat(source: bytes) -> str:
    """Return the unit of a file of TwinCAT as source text."""
    if not source.startswith(HEAD) or b"<!DOCTYPE" in source or b"<!ENTITY" in source:
        raise ModelFileError(
            "the TwinCAT file does not begin as dehyst writes it, in UTF-8: export it again"
        )
    try:
        pou = ElementTree.fromstring(source)[0]
        declaration, body = (
            pou.findtext("Declaration") or "",
            pou.findtext("Implementation/ST") or "",
        )
        kind = next(
            kind
            for kind in _KINDS
            if re.search(rf"(?m)^{kind} {re.escape(pou.attrib['Name'])}$", declaration)
        )
    except (ElementTree.ParseError, KeyError, IndexError, StopIteration) as error:
        raise ModelFileError(f"the TwinCAT file is damaged ({error}): export it again") from None
    return f"{declaration}\n{body}\nEND_{kind}\n"


def _unit_text(pou: ElementTree.Element) -> str:
    kinds = {name: kind for kind, name in _KINDS.items()}
    kind = kinds[pou.attrib["pouType"]]
    lines = [f"{kind} {pou.attrib['name']}"]
    for declarations in pou.find(f"{{{SPACE}}}interface"):  # type: ignore[union-attr]
        lines.append(_section_of(declarations))
        lines.extend(map(_variable_text, declarations))
        lines.append("END_VAR")
    body = pou.find(f"{{{SPACE}}}body/{{{SPACE}}}ST/{{{XHTML}}}xhtml")
    return "\n".join([*lines, str(body.text), f"END_{kind}"])  # type: ignore[union-attr]


def _section_of(declarations: ElementTree.Element) -> str:
    """Return the section of Structured Text that a list of variables in PLCopen XML stands for."""
    tag = declarations.tag.removeprefix(f"{{{SPACE}}}")
    # Three sections share the tag localVars: the attributes tell them apart.
    for section, name, attributes in _LISTS:
        if name == tag and attributes == declarations.attrib:
            return section
    raise KeyError(tag)


def _variable_text(variable: ElementTree.Element) -> str:
    type_ = variable.find(f"{{{SPACE}}}type")
    array = variable.find(f"{{{SPACE}}}type/{{{SPACE}}}array")
    if array is not None:
        type_ = array.find(f"{{{SPACE}}}baseType")
    base = type_[0]  # type: ignore[index]
    name = base.attrib.get("name", base.tag.removeprefix(f"{{{SPACE}}}"))
    values = [value.attrib["value"] for value in variable.iter(f"{{{SPACE}}}simpleValue")]
    initial = ""
    if values:
        initial = f" := {values[0]}"
    if array is not None:
        bounds = array.find(f"{{{SPACE}}}dimension").attrib  # type: ignore[union-attr]
        name = f"ARRAY[{bounds['lower']}..{bounds['upper']}] OF {name}"
        if values:
            initial = f" := [{', '.join(values)}]"
    return f"{variable.attrib['name']} : {name}{initial};"
