"""Tree to Python source, with every type checked on the way: nothing is converted silently.

Stricter than any compiler of a PLC: both operands of a sign have one type; constants of a real type stand alone on the
right of ``:=`` or as initial values (inside an expression compilers disagree about their type); AND and OR evaluate
both sides, as the standard allows, so that an index cannot hide behind a condition.
"""

from __future__ import annotations

from dehyst.export.iec import tree
from dehyst.export.iec.arithmetic import value_of
from dehyst.export.iec.scope import Scope, check_literal
from dehyst.export.iec.tree import INTEGERS, REALS, TextError, Type, Unit

Code = tuple[str, Type]
_BOOL, _DINT = Type("BOOL"), Type("DINT")
_PYTHON = {"=": "==", "<>": "!="}


def translate(unit: Unit, blocks: dict[str, Unit]) -> str:
    """Return the source of ``def run(s)`` that does one call of a unit on the variables of ``s``."""
    scope = Scope(unit, blocks)
    writer = _Writer(scope)
    writer.statements(unit.body, 1, ())
    scope.check_all_used()
    plain = [name for name, v in scope.variables.items() if v.type.bounds is None and v.type.name in tree.ELEMENTARY]
    kept = [name for name in plain if scope.variables[name].section != "CONSTANT"]
    others = [name for name in scope.variables if name not in plain]
    first = [f"    v_{name} = s.v_{name}" for name in (*plain, *others)]
    last = [f"    s.v_{name} = v_{name}" for name in kept]
    return "\n".join(["def run(s):", *first, *writer.lines, *last, "    return s"]) + "\n"


class _Writer:
    def __init__(self, scope: Scope) -> None:
        self.scope = scope
        self.lines: list[str] = []
        self.loops = 0

    # ---- statements

    def write(self, depth: int, text: str) -> None:
        self.lines.append("    " * depth + text)

    def statements(self, body: tuple[tree.Statement, ...], depth: int, counting: tuple[str, ...]) -> None:
        if not body:
            self.write(depth, "pass")
        for statement in body:
            self.statement(statement, depth, counting)

    def statement(self, node: tree.Statement, depth: int, counting: tuple[str, ...]) -> None:
        if isinstance(node, tree.Assignment):
            self.assignment(node, depth, counting)
        elif isinstance(node, tree.If):
            for number, (condition, body) in enumerate(node.branches):
                self.write(depth, f"{'elif' if number else 'if'} {self.of(condition, _BOOL)}:")
                self.statements(body, depth + 1, counting)
            self.write(depth, "else:")
            self.statements(node.otherwise, depth + 1, counting)
        elif isinstance(node, tree.For):
            self.count(node, depth, counting)
        elif isinstance(node, tree.While):
            self.write(depth, f"for _ in budget.rounds({node.line}):")
            self.write(depth + 1, f"if not ({self.of(node.condition, _BOOL)}): break")
            self.loop(node.body, depth, counting)
        elif isinstance(node, tree.Exit):
            if not self.loops:
                raise TextError("EXIT outside a loop", node.line)
            self.write(depth, "break")
        else:
            self.call(node, depth)

    def loop(self, body: tuple[tree.Statement, ...], depth: int, counting: tuple[str, ...]) -> None:
        self.loops += 1
        self.statements(body, depth + 1, counting)
        self.loops -= 1

    def assignment(self, node: tree.Assignment, depth: int, counting: tuple[str, ...]) -> None:
        variable = self.scope.find(node.target.name, node.line)
        if variable.section in ("VAR_INPUT", "CONSTANT") or node.target.member:
            raise TextError(f"{node.target.name} cannot be assigned", node.line)
        if node.target.name.lower() in counting:
            raise TextError(f"{node.target.name} counts a loop and must not be assigned in it", node.line)
        target, type_ = self.name(node.target)
        self.write(depth, f"{target} = {self.of(node.value, type_, alone=True)}")

    def count(self, node: tree.For, depth: int, counting: tuple[str, ...]) -> None:
        counter, type_ = self.name(node.variable)
        if type_ != _DINT or self.scope.find(node.variable.name, node.line).section != "VAR":
            raise TextError(f"{node.variable.name} counts a loop: it must be a DINT of VAR", node.line)
        if node.variable.name.lower() in counting:
            raise TextError(f"{node.variable.name} counts a loop around this one already", node.line)
        first, last = self.of(node.first, _DINT), self.of(node.last, _DINT)
        values = f"range({first}, {last} + {node.step}, {node.step})"
        self.write(depth, f"for {counter} in budget.count({values}, {node.line}):")
        self.loop(node.body, depth, (*counting, node.variable.name.lower()))
        self.write(depth, f"{counter} = {AFTER_LOOP}  # undefined behind the loop")

    def call(self, node: tree.Call, depth: int) -> None:
        instance, type_ = self.name(node.instance)
        if type_.name.lower() not in self.scope.blocks:
            raise TextError(f"{node.instance.name} is no function block", node.line)
        for name, value in node.inputs:
            wanted = self.scope.member(type_.name, name, "VAR_INPUT", node.line)
            self.write(depth, f"{instance}.v_{name.lower()} = {self.of(value, wanted, alone=True)}")
        self.write(depth, f"run_{type_.name.lower()}({instance})")

    # ---- expressions

    def of(self, node: tree.Expression, wanted: Type, *, alone: bool = False) -> str:
        """Return the code of an expression that must have this type; constants take it."""
        if isinstance(node, tree.Literal):
            if wanted.name in REALS and not alone:
                raise TextError(f"{node.text}: declare it as a constant, tools disagree about its type", node.line)
            check_literal(node, wanted.name)
            return repr(value_of(node, wanted.name))
        code, type_ = self.expression(node)
        if type_ != wanted:
            raise TextError(f"{wanted} expected, {type_} found", node.line)
        return code

    def expression(self, node: tree.Expression) -> Code:
        if isinstance(node, tree.Literal):
            if node.kind == "bool":
                return repr(node.text == "TRUE"), _BOOL
            raise TextError(f"{node.text}: nothing here gives it a type", node.line)
        if isinstance(node, tree.Name):
            return self.name(node)
        if isinstance(node, tree.Unary):
            return self.unary(node)
        return self.binary(node)

    def name(self, node: tree.Name) -> Code:
        type_ = self.scope.find(node.name, node.line).type
        code = f"v_{node.name.lower()}"
        if node.member is not None:
            if type_.name in tree.ELEMENTARY:
                raise TextError(f"{node.name} has no parts", node.line)
            return f"{code}.v_{node.member.lower()}", self.scope.member(
                type_.name, node.member, "VAR_OUTPUT", node.line
            )
        if (node.index is None) != (type_.bounds is None):
            raise TextError(f"{node.name} is {type_}", node.line)
        if node.index is None or type_.bounds is None:
            return code, type_
        low, high = type_.bounds
        index = self.of(node.index, _DINT)
        return f"{code}[place({index}, {low}, {high}, {node.line})]", Type(type_.name)

    def unary(self, node: tree.Unary) -> Code:
        if node.sign == "NOT":
            return f"(not {self.of(node.operand, _BOOL)})", _BOOL
        code, type_ = self.expression(node.operand)
        if type_.name in REALS:
            return f"(-{code})", type_
        if type_ == _DINT:
            return f"whole(-{code}, 'DINT', {node.line})", type_
        raise TextError(f"no - of {type_}", node.line)

    def binary(self, node: tree.Binary) -> Code:
        if node.sign in ("AND", "OR"):
            sign = "&" if node.sign == "AND" else "|"
            return f"({self.of(node.left, _BOOL)} {sign} {self.of(node.right, _BOOL)})", _BOOL
        type_ = self.expression(node.right if isinstance(node.left, tree.Literal) else node.left)[1]
        left, right = self.of(node.left, type_), self.of(node.right, type_)
        if node.sign in ("=", "<>", "<", ">", "<=", ">="):
            if type_.name not in (*REALS, *INTEGERS):
                raise TextError(f"{type_} cannot be compared", node.line)
            return f"({left} {_PYTHON.get(node.sign, node.sign)} {right})", _BOOL
        if type_.name in INTEGERS and type_.bounds is None:
            value = f"whole_divide({left}, {right}, {node.line})" if node.sign == "/" else f"{left} {node.sign} {right}"
            return f"whole({value}, '{type_.name}', {node.line})", type_
        if type_.name not in REALS or type_.bounds is not None:
            raise TextError(f"no {node.sign} of {type_}", node.line)
        value = f"divide({left}, {right})" if node.sign == "/" else f"({left} {node.sign} {right})"
        return (value if type_.name == "LREAL" else f"single({value})"), type_


AFTER_LOOP = 2**31 - 1  # a value that no code relies on
