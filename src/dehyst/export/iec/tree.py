"""What a Structured Text file says, as frozen data."""

from __future__ import annotations

from dataclasses import dataclass

from dehyst.errors import DehystError

ELEMENTARY = ("BOOL", "DINT", "UDINT", "REAL", "LREAL")
INTEGERS = {"DINT": (-(2**31), 2**31 - 1), "UDINT": (0, 2**32 - 1)}
REALS = ("REAL", "LREAL")


class TextError(DehystError):
    """The text is not in the subset that the checker knows, or breaks one of its rules."""

    def __init__(self, message: str, line: int) -> None:
        super().__init__(f"line {line}: {message}", line=line)


@dataclass(frozen=True)
class Token:
    """One word, number or sign. Names and keywords are kept as written."""

    kind: str  # name, real, integer, sign, pragma, end
    text: str
    line: int
    mark: str = ""  # of Siemens SCL: " around names of blocks, # before names of variables


@dataclass(frozen=True)
class Type:
    """An elementary type, an array of one, or the name of a function block."""

    name: str  # BOOL .. LREAL, or a function block
    bounds: tuple[int, int] | None = None  # of an array, both included

    def __str__(self) -> str:
        return f"ARRAY[{self.bounds[0]}..{self.bounds[1]}] OF {self.name}" if self.bounds else self.name


@dataclass(frozen=True)
class Literal:
    """A constant as written: TRUE, 12 or 1.5E-3, with its sign."""

    text: str
    kind: str  # bool, integer, real
    line: int


@dataclass(frozen=True)
class Name:
    """A variable, one of its elements (index), or an output of a function block (member)."""

    name: str
    line: int
    index: Expression | None = None
    member: str | None = None


@dataclass(frozen=True)
class Unary:
    """NOT x or -x."""

    sign: str
    operand: Expression
    line: int


@dataclass(frozen=True)
class Binary:
    """Two operands and a sign between them."""

    sign: str
    left: Expression
    right: Expression
    line: int


Expression = Literal | Name | Unary | Binary


@dataclass(frozen=True)
class Assignment:
    """target := value."""

    target: Name
    value: Expression
    line: int


@dataclass(frozen=True)
class If:
    """Branches (condition, statements) in order, and what is done if no condition holds."""

    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]
    line: int


@dataclass(frozen=True)
class For:
    """FOR variable := first TO last BY step; the step is a constant, 1 or -1."""

    variable: Name
    first: Expression
    last: Expression
    step: int
    body: tuple[Statement, ...]
    line: int


@dataclass(frozen=True)
class While:
    """WHILE condition DO body."""

    condition: Expression
    body: tuple[Statement, ...]
    line: int


@dataclass(frozen=True)
class Exit:
    """Leave the innermost loop."""

    line: int


@dataclass(frozen=True)
class Call:
    """Call of a function block instance with named inputs."""

    instance: Name
    inputs: tuple[tuple[str, Expression], ...]
    line: int


Statement = Assignment | If | For | While | Exit | Call


@dataclass(frozen=True)
class Variable:
    """One declared variable; `initial` are the literals of its initial value, one an element."""

    name: str
    type: Type
    section: str  # VAR_INPUT, VAR_OUTPUT, VAR, CONSTANT
    initial: tuple[Literal, ...]
    line: int


@dataclass(frozen=True)
class Unit:
    """A FUNCTION_BLOCK or a PROGRAM."""

    kind: str
    name: str
    variables: tuple[Variable, ...]
    body: tuple[Statement, ...]
    line: int
