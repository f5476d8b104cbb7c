"""Names of a unit: each declared once, whatever the case of its letters; initial values fit their types."""

from __future__ import annotations

import math

from dehyst.export.iec.arithmetic import value_of
from dehyst.export.iec.tree import ELEMENTARY, INTEGERS, REALS, Literal, TextError, Type, Unit, Variable


class Scope:
    """The variables of a unit and the function blocks that it may use.

    Parameters
    ----------
    unit
        Function block or program.
    blocks
        Function blocks by their name in small letters.

    Raises
    ------
    TextError
        If a name is declared twice, is that of a function block, or an initial value does not fit.
    """

    def __init__(self, unit: Unit, blocks: dict[str, Unit]) -> None:
        self.unit = unit
        self.blocks = blocks
        self.variables: dict[str, Variable] = {}
        self.used: set[str] = set()
        for variable in unit.variables:
            self._declare(variable)

    def _declare(self, variable: Variable) -> None:
        name, type_ = variable.name.lower(), variable.type
        if name in self.variables or name in self.blocks or name == self.unit.name.lower():
            raise TextError(f"{variable.name} is declared twice (case does not count)", variable.line)
        if type_.name not in ELEMENTARY and type_.name.lower() not in self.blocks:
            raise TextError(f"{variable.name}: no type {type_.name}", variable.line)
        if variable.initial or variable.section == "CONSTANT":
            _check_initial(variable)
        self.variables[name] = variable

    def find(self, name: str, line: int) -> Variable:
        """Return the declaration of a name and note its use."""
        variable = self.variables.get(name.lower())
        if variable is None:
            raise TextError(f"{name} is not declared", line)
        self.used.add(name.lower())
        return variable

    def member(self, block: str, name: str, section: str, line: int) -> Type:
        """Return the type of an input or output of a function block."""
        for variable in self.blocks[block.lower()].variables:
            if variable.name.lower() == name.lower() and variable.section == section:
                return variable.type
        raise TextError(f"{block} has no {section} {name}", line)

    def check_all_used(self) -> None:
        """Refuse variables that nothing reads or writes."""
        for name, variable in self.variables.items():
            if name not in self.used:
                raise TextError(f"{variable.name} is declared and never used", variable.line)


def _check_initial(variable: Variable) -> None:
    type_, values = variable.type, variable.initial
    count = 1 if type_.bounds is None else type_.bounds[1] - type_.bounds[0] + 1
    if len(values) != count:
        raise TextError(f"{variable.name}: {len(values)} initial values for {count}", variable.line)
    for value in values:
        check_literal(value, type_.name, f"{variable.name}: ")


def check_literal(value: Literal, type_: str, of: str = "") -> None:
    """Refuse a constant, `of` a variable, that is not of this type, or beyond its range."""
    kind = "real" if type_ in REALS else "integer" if type_ in INTEGERS else "bool" if type_ == "BOOL" else "none"
    if value.kind != kind:
        raise TextError(f"{of}{value.text} is no {type_}", value.line)
    low, high = INTEGERS.get(type_, (0, 0))
    if kind == "integer" and not low <= int(value.text) <= high:
        raise TextError(f"{of}{value.text} is beyond {type_}", value.line)
    if kind == "real" and not math.isfinite(value_of(value, type_)):
        raise TextError(f"{of}{value.text} is beyond {type_}", value.line)
