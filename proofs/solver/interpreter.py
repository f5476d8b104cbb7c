"""Runs the C text of the core, on numbers or on symbols.

The proofs of this room speak about what is written in core/*.c, so nothing is translated by hand: the preprocessed text
is parsed and interpreted. Over `numbers.Numbers` that is a slow C machine, compared in the tests with the compiled
core bit for bit; over `symbols.Symbols` every real is a term of bit-exact IEEE arithmetic, and a condition that
hangs on an input takes both ways, one run of the program after the other.

What is understood is what the core uses: functions, structs, unions of a real and its bits, arrays, pointers to them,
integers that do not hang on an input. Anything else stops with the line.
"""

from __future__ import annotations

import copy
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pycparser import c_ast, c_parser

CORE = Path(__file__).resolve().parents[2] / "packages" / "dehyst" / "core"
UNSIGNED = (1 << 32) - 1


class NotUnderstood(Exception):
    """A construct of C that the interpreter does not know."""


class _Return(Exception):
    def __init__(self, value: Any) -> None:
        super().__init__()
        self.value = value


class _Break(Exception):
    pass


class _Continue(Exception):
    pass


@dataclass(frozen=True)
class Pointer:
    """Place of a value: a key of a struct, of the local variables, or an index of an array."""

    where: Any
    key: Any

    def load(self) -> Any:
        if isinstance(self.where, list) and not 0 <= self.key < len(self.where):
            raise IndexError(f"index {self.key} of an array of {len(self.where)}")
        return self.where[self.key]

    def store(self, value: Any) -> None:
        if isinstance(self.where, list) and not 0 <= self.key < len(self.where):
            raise IndexError(f"index {self.key} of an array of {len(self.where)}")
        self.where[self.key] = value


class Struct(dict[str, Any]):
    """Members by name; a copy is a copy of all of them."""


class Union(dict[str, Any]):
    """A real and its bits: what was written last, and as which of them."""


class Program:
    """The functions of some files of the core."""

    def __init__(self, *names: str, defines: tuple[str, ...] = ()) -> None:
        self.functions: dict[str, c_ast.FuncDef] = {}
        self.constants: dict[str, int] = {}
        self.structs: dict[str, Any] = {}
        self.types: dict[str, Any] = {}
        for name in names:
            self._take(c_parser.CParser().parse(preprocessed(CORE / name, defines), name))

    def _take(self, tree: Any) -> None:
        for node in tree.ext:
            if isinstance(node, c_ast.FuncDef):
                self.functions[node.decl.name] = node
            elif isinstance(node, c_ast.Typedef):
                self.types[node.name] = node.type
                self._aggregate(node.type)
            elif isinstance(node, c_ast.Decl):
                self._aggregate(node.type)

    def _aggregate(self, node: Any) -> None:
        kind = getattr(node, "type", None) if isinstance(node, c_ast.TypeDecl) else node
        if isinstance(kind, c_ast.Enum) and kind.values:
            for item in kind.values.enumerators:
                value = item.value
                while isinstance(value, c_ast.Cast):
                    value = value.expr
                self.constants[item.name] = whole(value) if value else len(self.constants)
        elif isinstance(kind, c_ast.Struct | c_ast.Union) and kind.decls:
            self.structs[kind.name] = kind


def preprocessed(path: Path, defines: tuple[str, ...]) -> str:
    """Return a file of the core as the parser sees it."""
    compiler = next((name for name in ("gcc", "clang", "cc") if shutil.which(name)), None)
    if compiler is None:
        raise FileNotFoundError(
            "no C compiler to preprocess the core with; on Debian: apt-get install gcc"
        )
    options = [
        "-E",
        "-P",
        "-std=c11",
        "-ffreestanding",
        "-U__GNUC__",
        *(f"-D{name}" for name in defines),
    ]
    done = subprocess.run(
        [compiler, *options, str(path)], capture_output=True, text=True, check=True
    )
    return done.stdout


def whole(node: c_ast.Node) -> int:
    """A constant of an enumeration, which may have a sign."""
    return (
        -whole(node.expr)
        if isinstance(node, c_ast.UnaryOp) and node.op == "-"
        else integer(node.value)
    )


def integer(text: str) -> int:
    return int(text.rstrip("uUlL"), 0)


class Machine:
    """A program over a domain: `numbers.Numbers` or one run of `symbols.Symbols`."""

    def __init__(self, program: Program, domain: Any) -> None:
        self.program = program
        self.domain = domain

    def call(self, name: str, *arguments: Any) -> Any:
        """Run a function; arrays are lists, structs are `Struct`, pointers `Pointer` (or the struct itself)."""
        function = self.program.functions[name]
        declared = function.decl.type.args
        names = [p.name for p in declared.params if p.name] if declared else []
        frame = dict(zip(names, (as_pointer(a) for a in arguments), strict=True))
        for parameter in declared.params if declared else []:
            if parameter.name and self.is_real(parameter.type):
                frame[parameter.name] = self.domain.real(frame[parameter.name])
        try:
            self.run(function.body, frame)
        except _Return as back:
            return (
                self.domain.real(back.value)
                if self.is_real(function.decl.type.type)
                else back.value
            )
        return None

    # ---- statements

    def run(self, node: Any, frame: dict[str, Any]) -> None:
        match node:
            case None | c_ast.EmptyStatement():
                pass
            case c_ast.Compound():
                for item in node.block_items or []:
                    self.run(item, frame)
            case c_ast.DeclList():
                for item in node.decls:
                    self.run(item, frame)
            case c_ast.Decl():
                frame[node.name] = self.initial(node, frame)
            case c_ast.If():
                self.run(node.iftrue if self.truth(node.cond, frame) else node.iffalse, frame)
            case c_ast.For():
                self.run(node.init, frame)
                self.loop(node.cond, node.stmt, node.next, frame)
            case c_ast.While():
                self.loop(node.cond, node.stmt, None, frame)
            case c_ast.Return():
                raise _Return(None if node.expr is None else self.value(node.expr, frame))
            case c_ast.Break():
                raise _Break
            case c_ast.Continue():
                raise _Continue
            case _:
                self.value(node, frame)

    def loop(self, condition: Any, body: Any, step: Any, frame: dict[str, Any]) -> None:
        while condition is None or self.truth(condition, frame):
            try:
                self.run(body, frame)
            except _Break:
                return
            except _Continue:
                pass
            if step is not None:
                self.value(step, frame)

    def initial(self, node: Any, frame: dict[str, Any]) -> Any:
        if node.init is None:
            return self.empty(node.type, frame)
        if isinstance(node.init, c_ast.InitList):
            return self.listed(node, frame)
        value = self.value(node.init, frame)
        return self.domain.real(value) if self.is_real(node.type) else value

    def listed(self, node: Any, frame: dict[str, Any]) -> Any:
        """Return a struct whose members are given in order."""
        values = [self.value(item, frame) for item in node.init.exprs]
        whole = self.empty(node.type, frame)
        kind = self.declared(node.type)
        if not isinstance(whole, Struct) or len(values) != len(kind.decls):
            raise NotUnderstood(f"initialiser at {node.coord}")
        for member, value in zip(kind.decls, values, strict=True):
            whole[member.name] = self.domain.real(value) if self.is_real(member.type) else value
        return whole

    def declared(self, kind: Any) -> Any:
        """Return the declaration of a struct behind its names."""
        inner = kind.type if isinstance(kind, c_ast.TypeDecl) else kind
        if isinstance(inner, c_ast.IdentifierType):
            return self.declared(self.program.types[inner.names[0]])
        return self.program.structs[inner.name]

    def empty(self, kind: Any, frame: dict[str, Any]) -> Any:
        if isinstance(kind, c_ast.ArrayDecl):
            return [self.empty(kind.type, frame) for _ in range(int(self.value(kind.dim, frame)))]
        inner = kind.type if isinstance(kind, c_ast.TypeDecl) else kind
        if isinstance(inner, c_ast.IdentifierType):
            named = self.program.types.get(inner.names[0])
            return (
                self.empty(named, frame)
                if named is not None and inner.names[0] != "dehyst_real"
                else None
            )
        if isinstance(inner, c_ast.Union):
            return Union()
        if isinstance(inner, c_ast.Struct):
            members = self.program.structs[inner.name].decls
            return Struct({m.name: self.empty(m.type, frame) for m in members})
        return None

    # ---- expressions

    def truth(self, node: Any, frame: dict[str, Any]) -> bool:
        return self.decided(self.value(node, frame))

    def decided(self, value: Any) -> bool:
        """Whether a value is true; a symbolic one is taken both ways, in different runs."""
        if value is None or isinstance(value, bool | int):
            return bool(value)
        if isinstance(value, Pointer):
            return True
        return bool(self.domain.decide(value))

    def value(self, node: Any, frame: dict[str, Any]) -> Any:
        match node:
            case c_ast.Constant():
                return (
                    integer(node.value) if "int" in node.type else self.domain.literal(node.value)
                )
            case c_ast.ID() if node.name not in frame:
                return self.program.constants[node.name]
            case c_ast.ID() | c_ast.ArrayRef() | c_ast.StructRef():
                return self.loaded(self.place(node, frame))
            case c_ast.Cast():
                return self.cast(node, frame)
            case c_ast.TernaryOp():
                return self.ternary(node, frame)
            case c_ast.Assignment():
                return self.assign(node, frame)
            case c_ast.UnaryOp():
                return self.unary(node, frame)
            case c_ast.BinaryOp():
                return self.binary(node, frame)
            case c_ast.FuncCall():
                arguments = [self.value(a, frame) for a in (node.args.exprs if node.args else [])]
                return self.call(node.name.name, *arguments)
        raise NotUnderstood(f"{type(node).__name__} at {node.coord}")

    def loaded(self, place: Pointer) -> Any:
        if isinstance(place.where, Union):
            return self.domain.read_union(place.where, place.key)
        value = place.load()
        return Pointer(value, 0) if isinstance(value, list) else value

    def place(self, node: Any, frame: dict[str, Any]) -> Pointer:
        match node:
            case c_ast.ID():
                return Pointer(frame, node.name)
            case c_ast.ArrayRef():
                base = self.value(node.name, frame)
                return Pointer(base.where, base.key + int(self.value(node.subscript, frame)))
            case c_ast.StructRef():
                owner = self.value(node.name, frame)
                return Pointer(
                    owner.load() if isinstance(owner, Pointer) else owner, node.field.name
                )
            case c_ast.UnaryOp(op="*"):
                found: Pointer = self.value(node.expr, frame)
                return found
        raise NotUnderstood(f"place {type(node).__name__} at {node.coord}")

    def cast(self, node: Any, frame: dict[str, Any]) -> Any:
        value = self.value(node.expr, frame)
        if self.is_real(node.to_type.type):
            return self.domain.real(value)
        names = getattr(getattr(node.to_type.type, "type", None), "names", [])
        if "uint32_t" in names and isinstance(value, int):
            return value & UNSIGNED
        return value

    def is_real(self, kind: Any) -> bool:
        inner = kind.type if isinstance(kind, c_ast.TypeDecl) else None
        return isinstance(inner, c_ast.IdentifierType) and inner.names[0] in (
            "dehyst_real",
            "double",
            "float",
        )

    def ternary(self, node: Any, frame: dict[str, Any]) -> Any:
        condition = self.value(node.cond, frame)
        if not self.domain.is_symbolic(condition) or not (
            simple(node.iftrue) and simple(node.iffalse)
        ):
            return self.value(node.iftrue if self.decided(condition) else node.iffalse, frame)
        yes, no = self.value(node.iftrue, frame), self.value(node.iffalse, frame)
        if self.domain.is_real(yes) or self.domain.is_real(no):
            return self.domain.choose(condition, self.domain.real(yes), self.domain.real(no))
        return yes if self.decided(condition) else no

    def assign(self, node: Any, frame: dict[str, Any]) -> Any:
        value = self.value(node.rvalue, frame)
        place = self.place(node.lvalue, frame)
        if node.op != "=":
            value = self.operate(node.op[:-1], self.loaded(place), value)
        if isinstance(place.where, Union):
            place.where.clear()
        elif self.domain.is_real(place.load()):
            value = self.domain.real(value)
        place.store(copy.copy(value) if isinstance(value, Struct) else value)
        return value

    def unary(self, node: Any, frame: dict[str, Any]) -> Any:
        if node.op == "&":
            return self.place(node.expr, frame)
        if node.op == "*":
            return self.loaded(self.place(node, frame))
        if node.op in ("++", "--", "p++", "p--"):
            place = self.place(node.expr, frame)
            before = place.load()
            place.store(before + (1 if "++" in node.op else -1))
            return before if node.op.startswith("p") else place.load()
        value = self.value(node.expr, frame)
        if node.op == "!":
            return (
                self.domain.negation(value)
                if self.domain.is_symbolic(value)
                else not self.decided(value)
            )
        if node.op == "-":
            return self.domain.minus(value) if self.domain.is_real(value) else -value
        if node.op == "~":
            return ~value
        raise NotUnderstood(f"{node.op} at {node.coord}")

    def binary(self, node: Any, frame: dict[str, Any]) -> Any:
        left = self.value(node.left, frame)
        if node.op in ("&&", "||"):
            if not self.domain.is_symbolic(left):
                if self.decided(left) == (node.op == "||"):
                    return node.op == "||"
                return self.value(node.right, frame)
            if simple(node.right):
                return self.domain.connect(node.op, left, self.value(node.right, frame))
            taken = self.decided(left)
            return taken if taken == (node.op == "||") else self.value(node.right, frame)
        return self.operate(node.op, left, self.value(node.right, frame))

    def operate(self, op: str, left: Any, right: Any) -> Any:
        if isinstance(left, Pointer) and isinstance(right, int):
            return Pointer(left.where, left.key + (right if op == "+" else -right))
        if self.domain.is_real(left) or self.domain.is_real(right):
            return self.domain.arithmetic(op, self.domain.real(left), self.domain.real(right))
        if self.domain.is_bits(left) or self.domain.is_bits(right):
            return self.domain.bitwise(op, left, right)
        left, right = (self.decided(v) if self.domain.is_symbolic(v) else v for v in (left, right))
        return INTEGERS[op](left, right)


INTEGERS: dict[str, Any] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: int(a / b),
    "%": lambda a, b: a - b * int(a / b),
    "&": lambda a, b: a & b,
    "|": lambda a, b: a | b,
    "^": lambda a, b: a ^ b,
    "<<": lambda a, b: a << b,
    ">>": lambda a, b: a >> b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
}


def as_pointer(value: Any) -> Any:
    if isinstance(value, list):
        return Pointer(value, 0)
    return Pointer([value], 0) if isinstance(value, Struct) else value


def simple(node: Any) -> bool:
    """Whether an expression may be evaluated although C would not: it changes nothing and reads no array element."""
    if isinstance(node, c_ast.Assignment | c_ast.FuncCall):
        return False
    if isinstance(node, c_ast.UnaryOp) and node.op in ("++", "--", "p++", "p--"):
        return False
    return all(simple(child) for _, child in node.children())
