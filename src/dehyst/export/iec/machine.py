"""Run what was checked: load a text, make instances of its function blocks and programs, call them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from dehyst.export.iec import arithmetic
from dehyst.export.iec.arithmetic import RunError, single, value_of
from dehyst.export.iec.parser import parse
from dehyst.export.iec.translate import translate
from dehyst.export.iec.tree import ELEMENTARY, TextError, Unit, Variable

__all__ = ["Instance", "Library", "RunError", "load"]

Value = float | int | bool


def load(text: str) -> Library:
    """Parse and check a text.

    Parameters
    ----------
    text
        Function blocks, each before its first use, and programs.

    Raises
    ------
    TextError
        With the line, if the text is not in the subset or breaks a rule.

    Examples
    --------
    >>> library = load('''
    ... FUNCTION_BLOCK Adder
    ...   VAR_INPUT amount : DINT; END_VAR
    ...   VAR_OUTPUT total : DINT; END_VAR
    ...   total := total + amount;
    ... END_FUNCTION_BLOCK''')
    >>> adder = library.new("Adder")
    >>> [adder.call(amount=2)["total"] for _ in range(3)]
    [2, 4, 6]
    """
    blocks: dict[str, Unit] = {}
    units: dict[str, Unit] = {}
    names: dict[str, Any] = {
        name: getattr(arithmetic, name) for name in ("single", "divide", "whole", "whole_divide", "place")
    }
    budget = names["budget"] = arithmetic.Budget()
    for unit in parse(text):
        key = unit.name.lower()
        if key in units:
            raise TextError(f"{unit.name} is defined twice", unit.line)
        space = dict(names)
        exec(compile(translate(unit, dict(blocks)), f"<{unit.name}>", "exec"), space)
        names[f"run_{key}"] = space["run"]
        units[key] = unit
        if unit.kind == "FUNCTION_BLOCK":
            blocks[key] = unit
    return Library(units, {key: names[f"run_{key}"] for key in units}, budget)


@dataclass(frozen=True)
class Library:
    """Checked units by their names in small letters."""

    units: Mapping[str, Unit]
    code: Mapping[str, Callable[[Any], Any]]
    budget: arithmetic.Budget

    def new(self, name: str) -> Instance:
        """Make an instance with the declared initial values."""
        return Instance(self.units[name.lower()], self._variables(name), self.code[name.lower()], self.budget)

    def _variables(self, name: str) -> SimpleNamespace:
        variables = {f"v_{v.name.lower()}": self._initial(v) for v in self.units[name.lower()].variables}
        return SimpleNamespace(**variables)

    def _initial(self, variable: Variable) -> Any:
        type_ = variable.type
        if type_.name not in ELEMENTARY:
            return self._variables(type_.name)
        zero: Value = False if type_.name == "BOOL" else 0.0 if type_.name in ("REAL", "LREAL") else 0
        if type_.bounds is None:
            return value_of(variable.initial[0], type_.name) if variable.initial else zero
        if variable.initial:
            return [value_of(literal, type_.name) for literal in variable.initial]
        return [zero] * (type_.bounds[1] - type_.bounds[0] + 1)


@dataclass(frozen=True)
class Instance:
    """One instance and its variables."""

    unit: Unit
    variables: SimpleNamespace
    code: Callable[[Any], Any]
    budget: arithmetic.Budget

    def call(self, **inputs: Value) -> dict[str, Value]:
        """Set inputs by name, run once and return all outputs by name as declared.

        Raises
        ------
        RunError
            If an index leaves its array, an integer its range, or a loop does not end.
        """
        declared = {v.name: v for v in self.unit.variables if v.section == "VAR_INPUT"}
        for name, value in inputs.items():
            type_ = declared[name].type.name
            setattr(self.variables, f"v_{name.lower()}", single(value) if type_ == "REAL" else value)
        self.budget.refill()
        self.code(self.variables)
        return {v.name: self.value(v.name) for v in self.unit.variables if v.section == "VAR_OUTPUT"}

    def value(self, name: str) -> Any:
        """Return the present value of any variable."""
        return getattr(self.variables, f"v_{name.lower()}")
