"""Claims about the C text, as questions to bitwuzla: is there any pattern of bits for which it is wrong?"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bitwuzla
from bitwuzla import Kind, Result
from outcome import Failed
from solver.interpreter import Machine, Pointer, Program, Struct
from solver.symbols import Real, Symbols, Theory, runs

FILES = ("block.c", "model.c", "pi.c", "play.c", "map.c", "guard.c")
__all__ = ["Bench", "Pointer", "block", "copy_of", "operator", "state"]
LIMITS = {"double": "1e100", "float": "1e15"}
RANGES = ("input", "output", "reach")


class Bench:
    """The core in one precision, unknowns, and questions about them."""

    def __init__(self, precision: str) -> None:
        self.theory = Theory(precision)
        self.program = Program(*FILES, defines=("DEHYST_FLOAT",) if precision == "float" else ())
        self.limit = self.theory.value(LIMITS[precision])
        self.asked = 0

    def real(self, name: str) -> Real:
        return self.theory.unknown(name)

    def at_most(self, a: Real, b: Real) -> Any:
        return self.theory.term(Kind.FP_LEQ, a.term, b.term)

    def plain(self, x: Real) -> Any:
        """x is a number within the limit of inputs."""
        return self.at_most(Real(self.theory.term(Kind.FP_ABS, x.term)), self.limit)

    def truth(self, value: bool) -> Any:
        return self.theory.terms.mk_true() if value else self.theory.terms.mk_false()

    def within(self, x: Real, low: Real, high: Real) -> Any:
        return self.theory.all([self.at_most(low, x), self.at_most(x, high)])

    def band(self, z: Real, x: Real, r: Real) -> Any:
        """z lies in x - r .. x + r, both rounded as the core rounds them."""
        low = self.theory.term(Kind.FP_SUB, self.theory.nearest, x.term, r.term)
        high = self.theory.term(Kind.FP_ADD, self.theory.nearest, x.term, r.term)
        return self.within(z, Real(low), Real(high))

    def same(self, a: list[Real], b: list[Real]) -> Any:
        """One real each: zeros of both signs differ, NaNs do not."""
        return self.theory.all(
            [self.theory.term(Kind.EQUAL, p.term, q.term) for p, q in zip(a, b, strict=True)]
        )

    def prove(self, given: list[Any], program: Callable[[Machine], Any], claim: Callable[[Any], Any], *,
              anything: str = "") -> int:  # fmt: skip
        """Prove a claim about what a program hands back, on all of its ways; return how many there were.

        A claim of None asks for nothing. Results of the operations `anything` may be any real: that only makes the
        claim stronger.

        Raises
        ------
        Failed
            With the way on which the claim is wrong.
        """
        count = 0
        for domain, result in runs(
            self.theory, lambda d: program(Machine(self.program, d)), anything
        ):
            count += 1
            wanted = claim(result)
            if wanted is not None:
                self._ask([*given, *domain.path], wanted, domain)
        return count

    def _ask(self, given: list[Any], claim: Any, domain: Symbols) -> None:
        solver = bitwuzla.Bitwuzla(self.theory.terms, bitwuzla.Options())
        for fact in given:
            solver.assert_formula(fact)
        solver.assert_formula(self.theory.negation(claim))
        self.asked += 1
        if solver.check_sat() != Result.UNSAT:
            raise Failed(f"wrong on the way {domain.taken}")


def operator(bench: Bench, n: int) -> Struct:
    """Return a Prandtl-Ishlinskii operator with r_1 = 0 and nothing else known."""
    rows = {
        name: [bench.real(f"{name}{i}") for i in range(n)]
        for name in ("threshold", "slope", "loading")
    }
    rows["threshold"][0] = bench.theory.value(0)
    return Struct(n=n, center=bench.real("center"), offset=bench.real("offset"), **rows)


def some_map(bench: Bench, name: str, n: int) -> Struct:
    """Return a map of n points."""
    return Struct(
        n=n, **{side: [bench.real(f"{name}_{side}{i}") for i in range(n)] for side in "uv"}
    )


def block(bench: Bench, n: int, points: int = 0) -> Struct:
    """Return a block of n operators between maps of so many points."""
    maps = {name: some_map(bench, name, points) for name in ("before", "after")}
    ranges = {
        f"{name}_{end}": bench.real(f"{name}_{end}") for name in RANGES for end in ("low", "high")
    }
    rest = {name: bench.real(name) for name in ("line_slope", "line_offset", "fade")}
    model = Struct(hysteresis=operator(bench, n), **maps)
    return Struct(model=model, start=[], fingerprint=0, **ranges, **rest)


def state(bench: Bench, n: int, started: int = 1) -> Struct:
    """Return a block's state of which nothing is known."""
    model = Struct(
        z=[bench.real(f"z{i}") for i in range(n)], output=bench.real("model_output"), flags=0
    )
    return Struct(
        model=model,
        share=bench.real("share"),
        output=bench.real("output"),
        flags=0,
        started=started,
    )


def copy_of(given: Struct) -> Struct:
    """Return a state that may be written on."""
    model = given["model"]
    return Struct(given, model=Struct(model, z=list(model["z"])))
