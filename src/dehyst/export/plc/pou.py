"""A function block or program as data: its variables and the text of its body, and both as source text."""

from __future__ import annotations

import re
import textwrap
from dataclasses import dataclass, replace

OPTIMIZED = "{ S7_Optimized_Access := 'TRUE' }"  # of SCL: variables are laid out by the compiler
SECTIONS = ("VAR_INPUT", "VAR_OUTPUT", "VAR", "VAR CONSTANT")


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


def siemens_scl(unit: Pou) -> str:
    """Return the source as an external SCL source of TIA Portal wants it.

    Differences: names of blocks in quotes, # before those of variables, ``VERSION``, ``BEGIN``, no arrays among
    constants, no PROGRAM (a function block instead, to be called from an organisation block).
    """
    variables = tuple(
        replace(v, section="VAR") if v.section == "VAR CONSTANT" and v.size else v for v in unit.variables
    )
    unit = replace(unit, kind="FUNCTION_BLOCK", variables=variables)
    head = f'{comment(unit.comment)}\n{unit.kind} "{unit.name}"\n{OPTIMIZED}\nVERSION : 0.1\n'
    body = _marked(unit.body.rstrip(), {variable.name for variable in variables})
    return head + _declarations(unit, quoted=True) + f"\nBEGIN\n\n{body}\n\nEND_{unit.kind}\n"


def _marked(body: str, names: set[str]) -> str:
    """Put # before variables of the unit: not before members, and not in comments."""

    def marked(match: re.Match[str]) -> str:
        return f"#{match[0]}" if match[0] in names else match[0]

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
    elementary = variable.type in ("BOOL", "DINT", "UDINT", "REAL", "LREAL")
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
