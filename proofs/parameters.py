"""Blocks to try the proofs on, as C: tables of models and of their inverses, by the formulas of core/dehyst.h.

With S_i = w_1 + ... + w_i and phi_i = sum_{j<i} S_j (r_{j+1} - r_j) an inverse has
thresholds phi, slopes 1/S and loading r.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import accumulate, pairwise

Row = tuple[float, ...]


@dataclass(frozen=True)
class Block:
    """A function block; `after` the hysteresis and `before` it (breakpoints, values)."""

    name: str
    threshold: Row
    slope: Row
    loading: Row
    start: Row
    center: float
    offset: float
    input: tuple[float, float]
    output: tuple[float, float]
    reach: tuple[float, float]
    before: tuple[Row, Row] = ((), ())
    after: tuple[Row, Row] = ((), ())
    line: tuple[float, float] = (0.5, 0.1)
    fade: float = 0.01

    def declarations(self) -> str:
        """Return the C text: tables `<name>_...`, the block, memory for its state, and its sizes."""
        rows = {
            "threshold": self.threshold,
            "slope": self.slope,
            "loading": self.loading,
            "start": self.start,
        }
        rows |= {
            "before_u": self.before[0],
            "before_v": self.before[1],
            "after_u": self.after[0],
            "after_v": self.after[1],
        }
        lines = [
            f"static const dehyst_real {name}[] = {_list(row)};"
            for name, row in rows.items()
            if row
        ]
        maps = [f"{{{len(m[0])}, {side}_u, {side}_v}}" if m[0] else "{0, 0, 0}"
                for side, m in (("before", self.before), ("after", self.after))]  # fmt: skip
        numbers = (*self.input, *self.output, *self.reach, *self.line, self.fade)
        operator = f"{{N, threshold, slope, loading, {_hex(self.center)}, {_hex(self.offset)}}}"
        return "\n".join(
            [
                f"#define N {len(self.threshold)}",
                f"#define OUTPUT_LOW {_hex(self.output[0])}",
                f"#define OUTPUT_HIGH {_hex(self.output[1])}",
                *lines,
                f"static const dehyst_block block = {{{{{maps[0]}, {operator}, {maps[1]}}}, start,",
                f"    {', '.join(_hex(x) for x in numbers)}, 0x{len(self.name):08x}u}};",
                "static dehyst_real z[N];",
                "",
            ]
        )


def _hex(x: float) -> str:
    return f"(dehyst_real)({x.hex()})"


def _list(row: Row) -> str:
    return "{" + ", ".join(_hex(x) for x in row) + "}"


def forward(n: int) -> Block:
    """n plays, softening: weights fall with the threshold."""
    threshold = tuple(0.9 * i / n for i in range(n))
    slope = tuple(accumulate(1.0 / (1 + i) ** 2 for i in range(n)))
    steps = [s * (b - a) for s, (a, b) in zip(slope, pairwise(threshold), strict=False)]
    return Block(
        name=f"model of {n} operators",
        threshold=threshold,
        slope=slope,
        loading=tuple(accumulate(steps, initial=0.0)),
        start=(0.0,) * n,
        center=0.125,
        offset=-0.25,
        input=(-1.0, 1.0),
        output=(-1.9, 1.4),
        reach=(-1.9, 1.4),
    )


def inverse(n: int) -> Block:
    """The inverse of `forward`; its output range is smaller than what some inputs ask for."""
    of = forward(n)
    return replace(
        of,
        name=f"inverse of {n} operators",
        threshold=of.loading,
        slope=tuple(1 / s for s in of.slope),
        loading=of.threshold,
        center=of.offset,
        offset=of.center,
        input=of.output,
        output=(-0.8, 0.75),
        reach=(-0.8, 0.75),
    )


def mapped(block: Block) -> Block:
    """A block between two maps, the last one falling: the modified model, or its inverse."""
    low, high = block.input
    breaks = tuple(low + (high - low) * t for t in (0.0, 0.2, 0.45, 0.8, 1.0))
    values = tuple(low + (high - low) * t for t in (0.0, 0.35, 0.5, 0.7, 1.0))
    a, b = block.reach
    reach = tuple(a + (b - a) * t for t in (0.0, 0.3, 0.6, 1.0))
    return replace(
        block,
        name=f"{block.name} between maps",
        before=(breaks, values),
        after=(reach, (3.0, 1.0, 0.5, -2.0)),
        output=(-2.0, 3.0),
    )


def dead_zone(n: int) -> Block:
    """Every play has a threshold: nothing is held back."""
    of = forward(n)
    return replace(
        of, name=f"model of {n} operators, r_1 > 0", threshold=tuple(r + 0.05 for r in of.threshold)
    )


SETS = (forward(14), inverse(14), mapped(forward(6)), mapped(inverse(8)), dead_zone(4), inverse(1))
