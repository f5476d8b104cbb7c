"""The interpreter's domain of symbols: bit-exact IEEE terms of bitwuzla, and every way through the program."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from decimal import Decimal
from operator import eq, ge, gt, le, lt, ne
from typing import Any

import bitwuzla
from bitwuzla import Kind

SIZES = {"double": (11, 53), "float": (8, 24)}
COMPARE = {
    "<": Kind.FP_LT,
    "<=": Kind.FP_LEQ,
    ">": Kind.FP_GT,
    ">=": Kind.FP_GEQ,
    "==": Kind.FP_EQUAL,
}
NUMBERS = {"<": lt, "<=": le, ">": gt, ">=": ge, "==": eq, "!=": ne}
COMPUTE = {"+": Kind.FP_ADD, "-": Kind.FP_SUB, "*": Kind.FP_MUL, "/": Kind.FP_DIV}
BITWISE = {
    "&": Kind.BV_AND,
    "<=": Kind.BV_ULE,
    "<": Kind.BV_ULT,
    ">": Kind.BV_UGT,
    ">=": Kind.BV_UGE,
    "==": Kind.EQUAL,
}


@dataclass(frozen=True)
class Real:
    """A real; with the pattern of bits it was made of, or the number it is, where that is known."""

    term: Any
    bits: Any = None
    number: float | None = None


@dataclass(frozen=True)
class Bits:
    term: Any


@dataclass(frozen=True)
class Truth:
    term: Any


class Theory:
    """Terms of one precision; shared by all runs of a proof."""

    def __init__(self, precision: str = "double") -> None:
        self.terms = bitwuzla.TermManager()
        self.size = SIZES[precision]
        self.width = sum(self.size)
        self.sort = self.terms.mk_fp_sort(*self.size)
        self.pattern = self.terms.mk_bv_sort(self.width)
        self.nearest = self.terms.mk_rm_value(bitwuzla.RoundingMode.RNE)

    def unknown(self, name: str) -> Real:
        """Any pattern of bits, read as a real: NaNs, infinities, subnormals and both zeros are among them."""
        bits = self.terms.mk_const(self.pattern, name)
        return Real(self.terms.mk_term(Kind.FP_TO_FP_FROM_BV, [bits], list(self.size)), bits)

    def value(self, text: str | int | float) -> Real:
        """A number, or a literal of C rounded once."""
        clean = text.rstrip("fFlL") if isinstance(text, str) else repr(float(text))
        number = float(clean)
        exact = number if abs(number) < 2**20 and number == int(number) else None
        return Real(
            self.terms.mk_fp_value(self.sort, self.nearest, format(Decimal(clean), "f")),
            None,
            exact,
        )

    def term(self, kind: Any, *terms: Any) -> Any:
        return self.terms.mk_term(kind, list(terms))

    def all(self, terms: list[Any]) -> Any:
        return (
            self.terms.mk_true()
            if not terms
            else terms[0]
            if len(terms) == 1
            else self.term(Kind.AND, *terms)
        )

    def negation(self, term: Any) -> Any:
        return self.term(Kind.NOT, term)


@dataclass
class Symbols:
    """One run: conditions are taken as `ways` says, True beyond it; what was assumed on the way is `path`."""

    theory: Theory
    anything: str = ""  # of these operations the result may be any real: proves what does not hang on it, and faster
    ways: list[bool] = field(default_factory=list)
    taken: list[bool] = field(default_factory=list)
    path: list[Any] = field(default_factory=list)

    def real(self, value: Any) -> Real:
        return value if isinstance(value, Real) else self.theory.value(int(value))

    def literal(self, text: str) -> Real:
        return self.theory.value(text)

    def is_real(self, value: Any) -> bool:
        return isinstance(value, Real)

    def is_bits(self, value: Any) -> bool:
        return isinstance(value, Bits)

    def is_symbolic(self, value: Any) -> bool:
        return isinstance(value, Truth)

    def decide(self, value: Truth) -> bool:
        way = self.ways[len(self.taken)] if len(self.taken) < len(self.ways) else True
        self.taken.append(way)
        self.path.append(value.term if way else self.theory.negation(value.term))
        return way

    def negation(self, value: Truth) -> Truth:
        return Truth(self.theory.negation(value.term))

    def minus(self, value: Real) -> Real:
        number = None if value.number is None else -value.number
        return Real(self.theory.term(Kind.FP_NEG, value.term), None, number)

    def connect(self, op: str, left: Truth, right: Any) -> Any:
        if not isinstance(right, Truth):
            return left if bool(right) == (op == "&&") else op == "||"
        return Truth(self.theory.term(Kind.AND if op == "&&" else Kind.OR, left.term, right.term))

    def choose(self, condition: Truth, yes: Real, no: Real) -> Real:
        return Real(self.theory.term(Kind.ITE, condition.term, yes.term, no.term))

    def arithmetic(self, op: str, left: Real, right: Real) -> Any:
        if op not in COMPUTE and left.number is not None and right.number is not None:
            return bool(NUMBERS[op](left.number, right.number))
        if op == "!=":
            return Truth(
                self.theory.negation(self.theory.term(Kind.FP_EQUAL, left.term, right.term))
            )
        if op in COMPARE:
            return Truth(self.theory.term(COMPARE[op], left.term, right.term))
        if op in self.anything:
            return self.theory.unknown("any")
        return Real(self.theory.term(COMPUTE[op], self.theory.nearest, left.term, right.term))

    def bitwise(self, op: str, left: Any, right: Any) -> Any:
        a, b = (v.term if isinstance(v, Bits) else self._bits(int(v)) for v in (left, right))
        term = self.theory.term(BITWISE[op], a, b)
        return Bits(term) if op == "&" else Truth(term)

    def _bits(self, value: int) -> Any:
        return self.theory.terms.mk_bv_value(self.theory.pattern, value)

    def read_union(self, union: dict[str, Any], member: str) -> Any:
        ((written, value),) = union.items()
        if written == member:
            return value
        if member != "bits":
            raise TypeError("a real made of bits has no term: the code to prove does not make one")
        return Bits(self._pattern(self.real(value)))

    def _pattern(self, value: Real) -> Any:
        if value.bits is not None:
            return value.bits
        bits = self.theory.terms.mk_const(self.theory.pattern)
        back = self.theory.terms.mk_term(Kind.FP_TO_FP_FROM_BV, [bits], list(self.theory.size))
        self.path.append(self.theory.term(Kind.EQUAL, back, value.term))
        return bits


def runs(
    theory: Theory, program: Callable[[Symbols], Any], anything: str = ""
) -> Iterator[tuple[Symbols, Any]]:
    """Run a program in every way its conditions allow; impossible ways are among them and prove themselves."""
    waiting: list[list[bool]] = [[]]
    while waiting:
        domain = Symbols(theory, anything, waiting.pop())
        known = len(domain.ways)
        result = program(domain)
        waiting += [[*domain.taken[:i], False] for i in range(known, len(domain.taken))]
        yield domain, result
