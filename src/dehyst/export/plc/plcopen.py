"""PLCopen XML (TC6, version 2.01) of units in Structured Text, and its way back to text."""

from __future__ import annotations

from xml.etree import ElementTree

from dehyst.errors import ModelFileError
from dehyst.export.plc.pou import Pou, Variable, comment, plain

SPACE = "http://www.plcopen.org/xml/tc6_0201"
XHTML = "http://www.w3.org/1999/xhtml"
HEAD = b'<?xml version="1.0" encoding="utf-8"?>'
_LISTS = (
    ("VAR_INPUT", "inputVars", False),
    ("VAR_OUTPUT", "outputVars", False),
    ("VAR", "localVars", False),
    ("VAR CONSTANT", "localVars", True),
)
_KINDS = {"FUNCTION_BLOCK": "functionBlock", "PROGRAM": "program"}


def plcopen_xml(project: str, units: tuple[Pou, ...], version: str, date: str) -> bytes:
    """Return a project with these units as PLCopen XML."""
    root = ElementTree.Element("project", {"xmlns": SPACE})
    about = {"companyName": "dehyst", "productName": "dehyst", "productVersion": version, "creationDateTime": date}
    ElementTree.SubElement(root, "fileHeader", about)
    coordinates = ElementTree.SubElement(
        ElementTree.SubElement(root, "contentHeader", {"name": project}), "coordinateInfo"
    )
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
    for section, tag, constant in _LISTS:
        variables = unit.section(section)
        if variables:
            found = ElementTree.SubElement(interface, tag, {"constant": "true"} if constant else {})
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
    if variable.type in ("BOOL", "DINT", "UDINT", "REAL", "LREAL"):
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


def _unit_text(pou: ElementTree.Element) -> str:
    kind = {name: kind for kind, name in _KINDS.items()}[pou.attrib["pouType"]]
    lines = [f"{kind} {pou.attrib['name']}"]
    for found in pou.find(f"{{{SPACE}}}interface"):  # type: ignore[union-attr]
        tag = found.tag.removeprefix(f"{{{SPACE}}}")
        section = next(s for s, name, constant in _LISTS if name == tag and constant == ("constant" in found.attrib))
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
