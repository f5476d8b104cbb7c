"""Translates Structured Text to Python: tokens, then recursive descent with type checks."""

from __future__ import annotations

import ctypes
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from dehyst.errors import DehystError
from dehyst_targets.iec._reserved import LONGEST_NAME, RESERVED

INTEGERS = {"DINT": (-(2**31), 2**31 - 1), "UDINT": (0, 2**32 - 1)}
REALS = ("REAL", "LREAL")
ELEMENTARY = ("BOOL", *INTEGERS, *REALS)
SMALLEST, LARGEST = 2.0**-126, (2.0 - 2.0**-23) * 2.0**127  # of ordinary numbers of REAL
_SECTIONS = ("VAR_INPUT", "VAR_OUTPUT", "VAR")
_DEEPEST = 12  # nested statements or brackets; no text of ours comes near
_LARGEST = 1_000_000  # elements of an array
_COMPARED = ("=", "<>", "<", ">", "<=", ">=")
_LEVELS = (("OR",), ("AND",), _COMPARED, ("+", "-"), ("*", "/"))  # weakest first
# AND and OR become & and |, which evaluate both sides: an index cannot hide behind a condition.
_PYTHON = {"=": "==", "<>": "!=", "AND": "&", "OR": "|"}

Value = float | int | bool


class TextError(DehystError):
    """The text is not in the subset that the checker knows, or breaks one of its rules."""

    def __init__(self, message: str, line: int) -> None:
        super().__init__(f"line {line}: {message}", line=line)


class StToken(NamedTuple):
    """One word, number or sign as written, with its line.

    The mark is that of Siemens SCL: a quote around names of blocks, # before names of variables.
    """

    kind: str  # name, real, integer, bool, sign, pragma, end
    text: str
    line: int
    mark: str = ""


@dataclass(frozen=True)
class Type:
    """An elementary type, an array of one with both bounds included, or the name of a function block."""

    name: str
    bounds: tuple[int, int] | None = None

    def __str__(self) -> str:
        return (
            f"ARRAY[{self.bounds[0]}..{self.bounds[1]}] OF {self.name}"
            if self.bounds
            else self.name
        )


_BOOL, _DINT = Type("BOOL"), Type("DINT")


@dataclass(frozen=True)
class StVariable:
    """One declared variable; `initial` are the constants of its initial value, one an element.

    `retained` over a power cycle: it is declared as RETAIN.
    """

    name: str
    type: Type
    section: str  # VAR_INPUT, VAR_OUTPUT, VAR, CONSTANT
    initial: tuple[StToken, ...]
    line: int
    retained: bool = False


@dataclass(frozen=True)
class ProgramUnit:
    """A FUNCTION_BLOCK or a PROGRAM: its variables, and the Python of ``def run(s)``, one call on those of s.

    Or a DATA_BLOCK of SCL, which has variables alone.
    """

    kind: str
    name: str
    variables: tuple[StVariable, ...]
    source: str


def parse(text: str) -> list[ProgramUnit]:
    """Return the function blocks and programs of a text, in order, each checked.

    Raises
    ------
    TextError
        With the line, if the text is not in the subset or breaks a rule.
    """
    units: dict[str, ProgramUnit] = {}
    blocks: dict[str, ProgramUnit] = {}
    data: dict[str, ProgramUnit] = {}
    tokens, at = _tokens(text), 0
    while tokens[at].kind != "end":
        parser = _Parser(tokens, at, blocks, data)
        unit = parser.unit()
        if unit.name.lower() in units:
            raise TextError(f"{unit.name} is defined twice", tokens[at].line)
        units[unit.name.lower()] = unit
        # A program is in neither: no variable can be of its type, and nobody reads its tables.
        if unit.kind == "FUNCTION_BLOCK":
            blocks[unit.name.lower()] = unit
        elif unit.kind == "DATA_BLOCK":
            data[unit.name.lower()] = unit
        at = parser.at
    if not units:
        raise TextError("no FUNCTION_BLOCK and no PROGRAM in the text", 1)
    return list(units.values())


def value_of(literal: StToken, type_: str) -> Value:
    """Return the nearest number of a type. One of REAL is read as double first: with at most nine digits both agree."""
    if type_ == "BOOL":
        return literal.text == "TRUE"
    if type_ in INTEGERS:
        return int(literal.text)
    return single(float(literal.text)) if type_ == "REAL" else float(literal.text)


def single(value: float) -> float:
    """Round a double to single precision: after one operation on singles that is the single result.

    A double has more than twice the digits of a single and two, so that rounding twice rounds as once.
    """
    return ctypes.c_float(value).value


# The order counts: a comment begins like a bracket, a real number like an integer.
_WORDS = re.compile(
    r"""(?P<skip>\s+|\(\*.*?\*\))
      | (?P<real>\d+\.\d+(?:[eE][+-]?\d+)?)
      | (?P<integer>\d+(?![A-Za-z_]))
      | (?P<name>\#?[A-Za-z_][A-Za-z0-9_]*|"[A-Za-z_][A-Za-z0-9_]*")
      | (?P<pragma>\{[^{}]*\})
      | (?P<sign>:=|<=|>=|<>|\.\.|[-+*/()\[\],;:=<>.])""",
    re.VERBOSE | re.DOTALL,
)


def _tokens(text: str) -> list[StToken]:
    """Split a text into words without its comments, one of kind ``end`` behind them."""
    tokens: list[StToken] = []
    position, line = 0, 1
    while position < len(text):
        match = _WORDS.match(text, position)
        if match is None or not match.group().isascii():
            raise TextError(f"{text[position : position + 20]!r} is no word of the language", line)
        kind, word = str(match.lastgroup), match.group()
        plain = word.strip('#"') if kind == "name" else word
        if kind == "name" and len(plain) > LONGEST_NAME:
            raise TextError(
                f"{plain!r} has {len(plain)} characters, older tools take {LONGEST_NAME}", line
            )
        if kind == "name" and ("__" in plain or plain.startswith("_") or plain.endswith("_")):
            raise TextError(
                f"{plain!r}: underscores must stand alone between letters or digits", line
            )
        if kind in ("integer", "real") and len(word) > LONGEST_NAME:
            raise TextError(f"{word[:20]}... has {len(word)} characters", line)
        if kind != "skip":
            tokens.append(StToken(kind, plain, line, word[0] if plain != word else ""))
        line += word.count("\n")
        position = match.end()
    return [*tokens, StToken("end", "end of the text", line)]


@dataclass(frozen=True)
class _Operand:
    """A piece of an expression: its Python, its type, and the constant if it is one, which takes the type wanted."""

    code: str
    type: Type
    line: int
    literal: StToken | None = None
    joined: bool = False  # by AND or OR

    def of(self, target: Type, *, alone: bool = False) -> str:
        """Return its Python where a type is wanted; `alone` on the right of ``:=``, where a real constant may stand."""
        if self.literal is not None:
            if target.name in REALS and not alone:
                raise TextError(
                    f"{self.literal.text}: declare it as a constant, tools disagree about its type",
                    self.line,
                )
            _check_literal(self.literal, target)
            return repr(value_of(self.literal, target.name))
        if self.type != target:
            raise TextError(f"{target} expected, {self.type} found", self.line)
        return self.code


@dataclass
class _Parser:
    """Recursive descent over one unit, which writes the body of ``def run(s)`` on the way."""

    tokens: list[StToken]
    at: int
    blocks: Mapping[str, ProgramUnit]
    data: Mapping[str, ProgramUnit]
    variables: dict[str, StVariable] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)
    lines: list[str] = field(default_factory=list)
    unit_name: str = ""
    scl: bool = False  # Siemens SCL
    depth: int = 0  # of nested statements and brackets
    indent: int = 1
    loops: int = 0

    # words

    def here(self) -> StToken:
        return self.tokens[self.at]

    def take(self) -> StToken:
        self.at += 1
        return self.tokens[self.at - 1]

    def sees(self, *texts: str) -> bool:
        here = self.here()
        return here.kind in ("name", "sign") and not here.mark and here.text.upper() in texts

    def accept(self, text: str) -> bool:
        accepted = self.sees(text)
        self.at += accepted
        return accepted

    def expect(self, *texts: str) -> None:
        for text in texts:
            if not self.accept(text):
                raise TextError(f"{text} expected, {self.here().text!r} found", self.here().line)

    def name(self, mark: str = "") -> StToken:
        """Take a name; in SCL, and only there, those of blocks and variables are marked."""
        token = self.take()
        if token.mark != (mark if self.scl else ""):
            raise TextError(
                f"{token.mark}{token.text}: SCL marks variables with # and blocks with quotes",
                token.line,
            )
        if token.kind != "name" or token.text.upper() in RESERVED:
            raise TextError(f"{token.text!r} is not free as a name", token.line)
        return token

    def integer(self) -> int:
        sign = -1 if self.accept("-") else 1
        token = self.take()
        if token.kind != "integer":
            raise TextError(f"a whole number expected, {token.text!r} found", token.line)
        return sign * int(token.text)

    def literal(self) -> StToken:
        sign = "-" if self.accept("-") else ""
        token = self.take()
        if token.kind in ("integer", "real"):
            return StToken(token.kind, sign + token.text, token.line)
        if token.text.upper() in ("TRUE", "FALSE") and not sign:
            return StToken("bool", token.text.upper(), token.line)
        raise TextError(f"a constant expected, {token.text!r} found", token.line)

    def deeper(self) -> None:
        # The descent is recursive: without a limit a text could exhaust the stack of Python.
        self.depth += 1
        if self.depth > _DEEPEST:
            raise TextError(f"nested more than {_DEEPEST} deep", self.here().line)

    # declarations

    def unit(self) -> ProgramUnit:
        begin = self.take()
        kind = begin.text.upper()
        if kind not in ("FUNCTION_BLOCK", "PROGRAM", "DATA_BLOCK"):
            raise TextError(f"FUNCTION_BLOCK or PROGRAM expected, {begin.text!r} found", begin.line)
        self.scl = self.here().mark == '"'
        self.unit_name = self.name('"').text
        if self.scl:
            self.at += self.here().kind == "pragma"
            self.expect("VERSION", ":")
            self.take()
        if kind == "DATA_BLOCK":
            return self.data_block()
        while self.sees(*_SECTIONS):
            self.section()
        if self.scl:
            self.expect("BEGIN")
        self.statements(f"END_{kind}")
        self.expect(f"END_{kind}")
        # The text is generated: a variable without any use is a fault of its template.
        for name, variable in self.variables.items():
            if name not in self.used:
                raise TextError(f"{variable.name} is declared and never used", variable.line)
        return ProgramUnit(kind, self.unit_name, tuple(self.variables.values()), self.source())

    def source(self) -> str:
        """Scalars are local to the function and written back; arrays and instances of blocks are shared."""
        first, last = [], []
        for name, variable in self.variables.items():
            first.append(f"    v_{name} = s.v_{name}")
            scalar = variable.type.bounds is None and variable.type.name in ELEMENTARY
            if scalar and variable.section != "CONSTANT":
                last.append(f"    s.v_{name} = v_{name}")
        return "\n".join(["def run(s):", *first, *self.lines, *last, "    return s", ""])

    def section(self) -> None:
        section = self.take().text.upper()
        if section == "VAR" and self.accept("CONSTANT"):
            section = "CONSTANT"
        retained = section == "VAR" and self.accept("RETAIN")
        self.declarations("END_VAR", section, retained)

    def data_block(self) -> ProgramUnit:
        """Read the tables of a data block of SCL: declared first, then each element given its value."""
        self.expect("NON_RETAIN", "STRUCT")
        self.declarations("END_STRUCT", "VAR")
        self.expect(";", "BEGIN")
        values: dict[str, list[StToken]] = {name: [] for name in self.variables}
        while not self.accept("END_DATA_BLOCK"):
            token = self.take()
            elements = values[self.find(token).name.lower()]
            self.expect("[")
            if self.integer() != len(elements):
                raise TextError(f"{token.text}: its elements must be given in order", token.line)
            self.expect("]", ":=")
            elements.append(self.literal())
            self.expect(";")
        tables = [
            replace(v, section="CONSTANT", initial=tuple(values[name]))
            for name, v in self.variables.items()
        ]
        self.variables = {}
        for variable in tables:
            self.declare(variable)
        return ProgramUnit("DATA_BLOCK", self.unit_name, tuple(tables), "")

    def declarations(self, end: str, section: str, retained: bool = False) -> None:
        while not self.accept(end):
            name = self.name()
            self.expect(":")
            type_ = self.type()
            initial = self.initial() if self.accept(":=") else ()
            self.expect(";")
            self.declare(StVariable(name.text, type_, section, initial, name.line, retained))

    def type(self) -> Type:
        if not self.accept("ARRAY"):
            if self.here().text.upper() in ELEMENTARY:
                return Type(self.take().text.upper())
            return Type(self.name('"').text)
        self.expect("[")
        low = self.integer()
        self.expect("..")
        high = self.integer()
        self.expect("]", "OF")
        element = self.take()
        if element.text.upper() not in ELEMENTARY or not low <= high < low + _LARGEST:
            raise TextError(f"ARRAY[{low}..{high}] OF {element.text} is not known", element.line)
        return Type(element.text.upper(), (low, high))

    def initial(self) -> tuple[StToken, ...]:
        if not self.accept("["):
            return (self.literal(),)
        literals = [self.literal()]
        while self.accept(","):
            literals.append(self.literal())
        self.expect("]")
        return tuple(literals)

    def declare(self, variable: StVariable) -> None:
        name, type_, line = variable.name.lower(), variable.type, variable.line
        if name in self.variables or name in self.blocks or name == self.unit_name.lower():
            raise TextError(f"{variable.name} is declared twice (case does not count)", line)
        if type_.name not in ELEMENTARY and type_.name.lower() not in self.blocks:
            raise TextError(f"{variable.name}: no type {type_.name}", line)
        if variable.initial or variable.section == "CONSTANT":
            count = 1 if type_.bounds is None else type_.bounds[1] - type_.bounds[0] + 1
            if len(variable.initial) != count:
                raise TextError(
                    f"{variable.name}: {len(variable.initial)} initial values for {count}", line
                )
            for value in variable.initial:
                _check_literal(value, type_, f"{variable.name}: ")
        self.variables[name] = variable

    def find(self, token: StToken) -> StVariable:
        variable = self.variables.get(token.text.lower())
        if variable is None:
            raise TextError(f"{token.text} is not declared", token.line)
        self.used.add(token.text.lower())
        return variable

    def member(self, block: str, name: str, section: str, line: int) -> Type:
        for variable in self.blocks[block.lower()].variables:
            if variable.name.lower() == name.lower() and variable.section == section:
                return variable.type
        raise TextError(f"{block} has no {section} {name}", line)

    # statements

    def write(self, text: str) -> None:
        self.lines.append("    " * self.indent + text)

    def statements(self, *ends: str) -> None:
        self.deeper()
        if self.sees(*ends):
            self.write("pass")
        while not self.sees(*ends):
            if self.here().kind == "end":
                raise TextError(f"{' or '.join(ends)} is missing", self.here().line)
            self.statement()
            self.expect(";")
        self.depth -= 1

    def inner(self, *ends: str) -> None:
        self.indent += 1
        self.statements(*ends)
        self.indent -= 1

    def statement(self) -> None:
        line = self.here().line
        if self.sees("IF"):
            self.condition()
        elif self.sees("FOR"):
            raise TextError("FOR: some tools skip it if its ends are equal, write WHILE", line)
        elif self.accept("WHILE"):
            self.write(f"for _ in budget.rounds({line}):")
            self.write(f"    if not ({self.expression().of(_BOOL)}): break")
            self.expect("DO")
            self.loops += 1
            self.inner("END_WHILE")
            self.loops -= 1
            self.expect("END_WHILE")
        elif self.accept("EXIT"):
            if not self.loops:
                raise TextError("EXIT outside a loop", line)
            self.write("break")
        else:
            self.assignment_or_call()

    def condition(self) -> None:
        word = "if"
        while self.accept("IF") or self.accept("ELSIF"):
            self.write(f"{word} {self.expression().of(_BOOL)}:")
            self.expect("THEN")
            self.inner("ELSIF", "ELSE", "END_IF")
            word = "elif"
        if self.accept("ELSE"):
            self.write("else:")
            self.inner("END_IF")
        self.expect("END_IF")

    def assignment_or_call(self) -> None:
        token = self.here()
        target, variable, member = self.variable()
        if not self.accept(":="):
            self.call(target)
            return
        if variable.section in ("VAR_INPUT", "CONSTANT") or member:
            raise TextError(f"{token.text} cannot be assigned", token.line)
        self.write(f"{target.code} = {self.expression().of(target.type, alone=True)}")

    def call(self, target: _Operand) -> None:
        self.expect("(")
        block = target.type.name
        if block.lower() not in self.blocks:
            raise TextError(f"{target.code.removeprefix('v_')} is no function block", target.line)
        inputs = 0
        while not self.accept(")"):
            if inputs:
                self.expect(",")
            token = self.name()
            self.expect(":=")
            parameter = self.member(block, token.text, "VAR_INPUT", token.line)
            self.write(
                f"{target.code}.v_{token.text.lower()} = {self.expression().of(parameter, alone=True)}"
            )
            inputs += 1
        self.write(f"run_{block.lower()}({target.code})")

    # expressions

    def expression(self, level: int = 0) -> _Operand:
        if level == len(_LEVELS):
            self.deeper()
            operand = self.operand()
            self.depth -= 1
            return operand
        left = self.expression(level + 1)
        while self.sees(*_LEVELS[level]):
            sign = self.take()
            left = _both(left, sign.text.upper(), self.expression(level + 1), sign.line)
        return left

    def operand(self) -> _Operand:
        here = self.here()
        # The sign belongs to the number: -2147483648 is a DINT, 2147483648 is none.
        constant = here.kind in ("integer", "real") or self.sees("TRUE", "FALSE")
        negative = self.sees("-") and self.tokens[self.at + 1].kind in ("integer", "real")
        if constant or negative:
            literal = self.literal()
            return _Operand(repr(literal.text == "TRUE"), _BOOL, literal.line, literal)
        if self.accept("NOT"):
            operand = self.expression(len(_LEVELS))
            if operand.joined:
                raise TextError(
                    "NOT before AND or OR: some tools take it for one of bits, ask each", here.line
                )
            return _Operand(f"(not {operand.of(_BOOL)})", _BOOL, here.line)
        if self.accept("-"):
            return _negated(self.expression(len(_LEVELS)), here.line)
        if self.accept("("):
            operand = self.expression()
            self.expect(")")
            return operand
        return self.variable()[0]

    def variable(self) -> tuple[_Operand, StVariable, bool]:
        """Return a variable, its element or an output of a block; its declaration; whether it is such an output."""
        place = ""
        if self.scl and self.here().mark == '"':  # of a data block
            block = self.name('"')
            if block.text.lower() not in self.data:
                raise TextError(f"{block.text} is no data block", block.line)
            self.expect(".")
            token, place = self.take(), f"data_{block.text.lower()}."
            tables = {v.name.lower(): v for v in self.data[block.text.lower()].variables}
            if token.text.lower() not in tables:
                raise TextError(f"{block.text} has no {token.text}", token.line)
            variable = tables[token.text.lower()]
        else:
            token = self.name("#")
            variable = self.find(token)
        code, type_ = f"{place}v_{token.text.lower()}", variable.type
        if self.accept("."):
            if type_.name in ELEMENTARY:
                raise TextError(f"{token.text} has no parts", token.line)
            name = self.name().text
            of = self.member(type_.name, name, "VAR_OUTPUT", token.line)
            return _Operand(f"{code}.v_{name.lower()}", of, token.line), variable, True
        if self.sees("[") == (type_.bounds is None):
            raise TextError(f"{token.text} is {type_}", token.line)
        if type_.bounds is not None:
            self.expect("[")
            index = self.expression().of(_DINT)
            self.expect("]")
            low, high = type_.bounds
            code, type_ = f"{code}[place({index}, {low}, {high}, {token.line})]", Type(type_.name)
        return _Operand(code, type_, token.line), variable, False


def _type(operand: _Operand) -> Type:
    """The type that an operand gives to what stands beside it."""
    if operand.literal is not None and operand.literal.kind != "bool":
        raise TextError(f"{operand.literal.text}: nothing here gives it a type", operand.line)
    return operand.type


def _negated(operand: _Operand, line: int) -> _Operand:
    type_ = _type(operand)
    if type_.name in REALS:
        return _Operand(f"(-{operand.code})", type_, line)
    if type_ == _DINT:
        return _Operand(f"whole(-{operand.code}, 'DINT', {line})", type_, line)
    raise TextError(f"no - of {type_}", line)


def _both(a: _Operand, sign: str, b: _Operand, line: int) -> _Operand:
    type_ = _BOOL if sign in ("AND", "OR") else _type(b if a.literal is not None else a)
    left, right = a.of(type_), b.of(type_)
    plain = f"({left} {_PYTHON.get(sign, sign)} {right})"
    if sign in ("AND", "OR"):
        return _Operand(plain, _BOOL, line, joined=True)
    if type_.name not in (*REALS, *INTEGERS):
        raise TextError(
            f"{type_} cannot be compared" if sign in _COMPARED else f"no {sign} of {type_}", line
        )
    if sign in _COMPARED:
        return _Operand(plain, _BOOL, line)
    if type_.name in INTEGERS:
        value = plain
        if sign == "/":
            value = f"whole_divide({left}, {right}, {line})"
        return _Operand(f"whole({value}, '{type_.name}', {line})", type_, line)
    value = plain
    if sign == "/":
        value = f"divide({left}, {right})"
    if type_.name != "LREAL":
        # Python computes in double: each result is rounded, as a PLC rounds a REAL.
        value = f"single({value})"
    return _Operand(value, type_, line)


def _check_literal(value: StToken, target: Type, of: str = "") -> None:
    """Refuse a constant, `of` a variable, that is not of this type, or beyond its range."""
    type_ = target.name
    kind = "none"
    if type_ in REALS:
        kind = "real"
    elif type_ in INTEGERS:
        kind = "integer"
    elif type_ == "BOOL":
        kind = "bool"
    if value.kind != kind:
        raise TextError(f"{of}{value.text} is no {type_}", value.line)
    low, high = INTEGERS.get(type_, (0, 0))
    number = abs(value_of(value, type_))
    if (kind == "integer" and not low <= int(value.text) <= high) or not math.isfinite(number):
        raise TextError(f"{of}{value.text} is beyond {type_}", value.line)
    if kind == "real" and target.bounds is None and number and not SMALLEST <= number <= LARGEST:
        raise TextError(
            f"{of}{value.text} is no ordinary REAL, some tools refuse it alone, in LREAL too",
            value.line,
        )
