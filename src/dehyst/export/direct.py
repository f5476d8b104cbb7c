"""A direct inverse as numbers of a unit: y, its rate and scheduling variables in, the needed u out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dehyst.control.block import Block
from dehyst.export.float_rules import check_unit
from dehyst.export.names import c_names
from dehyst.export.numbers import (
    TOLERANCE,
    DirectNumbers,
    OffsetUnit,
    Tables,
    UnitNumbers,
    direct_in,
    direct_numbers,
    in_real,
    read,
)
from dehyst.export.signal import SAMPLES

WHAT = "direct-inverse"


def numbers_of(block: Block, real: str) -> DirectBlockNumbers:
    """Return the numbers of a block in a precision."""
    p = block.parameters
    own = p.line_slope, p.line_offset, p.fade
    exact = direct_numbers(p.direct)
    direct = direct_in(exact, real)
    given = c_names(block.given[1:], DirectBlockNumbers.leading)
    numbers = DirectBlockNumbers(direct, *in_real(own, real), given, float_tolerance(direct))
    check_unit(DirectBlockNumbers(exact, *own), numbers, block.ramp, real)
    return numbers


@dataclass(frozen=True)
class DirectBlockNumbers(UnitNumbers):
    """``dehyst_direct_block``, fields named as there; `given` are C names of its scheduling variables from outside."""

    core = "direct_block"
    functions = ("dehyst_direct_block_reset", "dehyst_direct_block_step")
    tables = "c/direct_tables.j2"
    leading = ("y", "rate")
    takes_given = True
    saved = False
    kind = "stops and lags"
    what = WHAT
    direct: DirectNumbers
    line_slope: float
    line_offset: float
    fade: float
    given: tuple[str, ...] = ()
    tolerance: float = 0.0
    offset: OffsetUnit | None = None

    input_low, input_high = read("direct", "input_low"), read("direct", "input_high")
    output_low, output_high = read("direct", "output_low"), read("direct", "output_high")

    @property
    def rising(self) -> Tables:
        """Those of the direct inverse."""
        return self.direct.rising

    @property
    def direct_inverse(self) -> DirectNumbers | None:
        """It is one."""
        return self.direct

    @property
    def memory(self) -> tuple[tuple[str, str, str], ...]:
        """All that it remembers."""
        return (("direct.memory", "memory", "REALS"),)

    @property
    def sizes(self) -> tuple[tuple[str, str, str], ...]:
        """Its terms, and numbers that it remembers."""
        d = self.direct
        counts = (("STOPS", d.radius), ("PATHS", d.length), ("CREEPS", d.gain))
        reals = ("REALS", f"{max(1, d.memory)}", "numbers that it remembers")
        return (*((name, f"{len(values)}", "") for name, values in counts), reals)

    @property
    def parts(self) -> int:
        """Stops and lags."""
        return self.direct.memory // 2

    def bytes(self, size: int) -> tuple[int, int, int]:
        """Return bytes of constants, state and image on a 32-bit target, by the size of a real."""
        return size * 3 + self.direct.bytes(size), size * (max(1, self.direct.memory) + 20) + {4: 16, 8: 24}[size], 0


def float_tolerance(d: DirectNumbers) -> float:
    """Return how far answers in float may be from those of the model: 1e-5 of the range of u, and rounding of y. [u]

    A creep lag adds less than its last digit when it is nearly there: that can add up over the samples of the test.
    """
    largest = max(abs(d.input_low), abs(d.input_high), d.input_high - d.input_low)
    digit = float(np.spacing(np.float32(largest)))
    table = np.array(d.weight).reshape(d.sets, d.terms)[:, d.coefficients : -1]
    weights = np.abs(table).sum(axis=0) if table.size else np.zeros(0)
    first = len(d.radius) + len(d.length)
    stalled = sum(w * 0.5 * digit * min(1.0 / gain, SAMPLES) for w, gain in zip(weights[first:], d.gain, strict=True))
    return TOLERANCE * (d.output_high - d.output_low) + digit * float(weights.sum()) + float(stalled)
