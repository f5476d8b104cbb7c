"""Checker of exported Structured Text: parses it, checks its types, and runs it in IEEE arithmetic.

It knows the subset of IEC 61131-3 that the exported function blocks use and refuses everything else. It is no PLC: what
it shows is that the text is well formed, that types agree, that no index leaves its array and no integer its range, and
that the arithmetic of the text, taken literally, gives the bits of the C core.

It is stricter than any compiler of a PLC: both operands of a sign have one type; constants of a real type stand alone
on the right of ``:=`` or as initial values (inside an expression compilers disagree about their type), and outside of
arrays such that REAL holds them; AND and OR evaluate both sides, as the standard allows, so that an index cannot hide
behind a condition; NOT stands before neither, and loops are WHILE, which matiec and STruC++ read as all others do.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from dehyst.errors import DehystError
from dehyst_targets.iec._parser import (
    ELEMENTARY,
    INTEGERS,
    REALS,
    ProgramUnit,
    StVariable,
    Value,
    parse,
    single,
    value_of,
)

MOST_ROUNDS = 1_000_000  # of all loops in a call


class ProgramError(DehystError):
    """The text did something that a PLC stops at: an index outside its array, an integer outside its range, no end."""


def load_program(text: str) -> Library:
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
    >>> library = load_program('''
    ... FUNCTION_BLOCK Adder
    ...   VAR_INPUT amount : DINT; END_VAR
    ...   VAR_OUTPUT total : DINT; END_VAR
    ...   total := total + amount;
    ... END_FUNCTION_BLOCK''')
    >>> adder = library.new("Adder")
    >>> [adder.call(amount=2)["total"] for _ in range(3)]
    [2, 4, 6]
    """
    units = {unit.name.lower(): unit for unit in parse(text)}
    budget = _Budget()
    names: dict[str, Any] = {
        "single": single, "divide": _divide, "whole": _whole, "whole_divide": _whole_divide, "place": _place,
        "budget": budget,
    }  # fmt: skip
    code: dict[str, Callable[[Any], Any]] = {}
    for name, unit in units.items():
        if unit.kind == "DATA_BLOCK":
            names[f"data_{name}"] = _variables(units, name)  # one for all instances
            continue
        # A block calls only blocks above it: their functions are among the names by now.
        space = dict(names)
        # The parser wrote this source from words that it had checked, so that nothing else can run.
        exec(compile(unit.source, f"<{unit.name}>", "exec"), space)
        code[name] = names[f"run_{name}"] = space["run"]
    return Library(units, code, budget)


@dataclass(frozen=True)
class Library:
    """Checked units and their functions by their names in small letters."""

    units: Mapping[str, ProgramUnit]
    code: Mapping[str, Callable[[Any], Any]]
    budget: _Budget

    def new(self, name: str) -> Instance:
        """Make an instance with the declared initial values."""
        return Instance(
            self.units[name.lower()],
            _variables(self.units, name),
            self.code[name.lower()],
            self.budget,
        )

    def cycled(self, instance: Instance) -> Instance:
        """Return what is left of an instance after a power cycle: what is RETAIN, all else at its initial values."""
        after = self.new(instance.unit.name)
        for variable in instance.unit.variables:
            if variable.retained:
                # An array is a list, which both instances would share without a copy.
                setattr(
                    after.variables,
                    f"v_{variable.name.lower()}",
                    deepcopy(instance.value(variable.name)),
                )
        return after


def _variables(units: Mapping[str, ProgramUnit], name: str) -> SimpleNamespace:
    """Return the variables of a unit with their initial values."""
    variables = SimpleNamespace()
    for variable in units[name.lower()].variables:
        setattr(variables, f"v_{variable.name.lower()}", _initial(units, variable))
    return variables


def _initial(units: Mapping[str, ProgramUnit], variable: StVariable) -> Any:
    type_ = variable.type
    if type_.name not in ELEMENTARY:
        return _variables(units, type_.name)
    zero: Value = 0
    if type_.name == "BOOL":
        zero = False
    elif type_.name in REALS:
        zero = 0.0
    values = [value_of(literal, type_.name) for literal in variable.initial]
    if type_.bounds is None:
        return values[0] if values else zero
    return values or [zero] * (type_.bounds[1] - type_.bounds[0] + 1)


@dataclass(frozen=True)
class Instance:
    """One instance and its variables."""

    unit: ProgramUnit
    variables: SimpleNamespace
    code: Callable[[Any], Any]
    budget: _Budget

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
            # A PLC rounds to REAL where a number is assigned, and so does the checker.
            setattr(
                self.variables, f"v_{name.lower()}", single(value) if type_ == "REAL" else value
            )
        self.budget.left = MOST_ROUNDS
        self.code(self.variables)
        return {
            v.name: self.value(v.name) for v in self.unit.variables if v.section == "VAR_OUTPUT"
        }

    def value(self, name: str) -> Any:
        """Return the present value of any variable."""
        return getattr(self.variables, f"v_{name.lower()}")


# Arithmetic of the types. LREAL is IEEE double, REAL single; integers have a range and leave it with an error.


def _divide(a: float, b: float) -> float:
    """Divide as IEEE says, by zero too."""
    if b != 0.0:
        return a / b
    if a == 0.0 or math.isnan(a) or math.isnan(b):
        return math.nan
    # A comparison does not see the sign of a zero, copysign does.
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def _whole(value: int, type_: str, line: int) -> int:
    low, high = INTEGERS[type_]
    if not low <= value <= high:
        raise ProgramError(f"line {line}: {value} is beyond {type_}", line=line)
    return value


def _whole_divide(a: int, b: int, line: int) -> int:
    """Divide integers towards zero."""
    if b == 0:
        raise ProgramError(f"line {line}: integer division by zero", line=line)
    # Python rounds a quotient down, IEC 61131-3 towards zero.
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


def _place(index: int, low: int, high: int, line: int) -> int:
    if not low <= index <= high:
        raise ProgramError(f"line {line}: index {index} is outside {low}..{high}", line=line)
    return index - low


class _Budget:
    """Rounds of loops that are left in a call, all loops and blocks together: a text that does not end is stopped."""

    left = MOST_ROUNDS

    def rounds(self, line: int) -> Iterator[None]:
        """Count the rounds of a WHILE and stop one that does not end."""
        while True:
            self.left -= 1
            if self.left < 0:
                raise ProgramError(
                    f"line {line}: more than {MOST_ROUNDS} rounds of loops in a call, and no end",
                    line=line,
                )
            yield None
