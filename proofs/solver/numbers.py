"""The interpreter's domain of numbers: a slow C machine, to compare the interpreter with a compiler."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

warnings.filterwarnings("ignore", category=RuntimeWarning, module=__name__)


class Numbers:
    """Reals are numpy scalars of one precision."""

    def __init__(self, precision: type[np.float32] | type[np.float64] = np.float64) -> None:
        self.type = precision
        self.pattern = np.uint64 if precision is np.float64 else np.uint32

    def real(self, value: Any) -> Any:
        return value if isinstance(value, self.type) else self.type(value)

    def literal(self, text: str) -> Any:
        """A literal with its suffix; the core casts the others, so that rounding twice does no harm."""
        clean = text.rstrip("fFlL") if not text.lower().startswith("0x") else text
        return self.type(float.fromhex(clean) if clean.lower().startswith("0x") else clean)

    def is_real(self, value: Any) -> bool:
        return isinstance(value, self.type)

    def is_bits(self, value: Any) -> bool:
        return isinstance(value, self.pattern)

    def is_symbolic(self, value: Any) -> bool:
        return False

    def decide(self, value: Any) -> bool:
        return bool(value)

    def minus(self, value: Any) -> Any:
        return -value

    def arithmetic(self, op: str, left: Any, right: Any) -> Any:
        match op:
            case "+":
                return left + right
            case "-":
                return left - right
            case "*":
                return left * right
            case "/":
                return np.divide(left, right)
        return bool({"<": left < right, "<=": left <= right, ">": left > right, ">=": left >= right,
                     "==": left == right, "!=": left != right}[op])  # fmt: skip

    def bitwise(self, op: str, left: Any, right: Any) -> Any:
        a, b = int(left), int(right)
        if op in ("<=", "<", ">=", ">", "==", "!="):
            return {"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b, "==": a == b, "!=": a != b}[
                op
            ]
        return self.pattern({"&": a & b, "|": a | b, "^": a ^ b, ">>": a >> b, "+": a + b}[op])

    def read_union(self, union: dict[str, Any], member: str) -> Any:
        ((written, value),) = union.items()
        if written == member:
            return value
        return (
            self.type(value).view(self.pattern)
            if member == "bits"
            else self.pattern(value).view(self.type)
        )
