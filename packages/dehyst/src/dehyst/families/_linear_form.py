"""A fit as its program saw it: unknowns, what the output goes up by with each of them, and what was left."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from dehyst.arrays import Array

# Of a weight that is 0: the term stays in the model, so that models of all draws have the same terms.
NEXT_TO_NOTHING = 1e-300


@dataclass(frozen=True, eq=False)
class LinearForm:
    """Near its solution u the output of a fit is y + A (v - u) for unknowns v.

    Attributes
    ----------
    rows
        A, at the fitted rows in the order of the log, (K, p). The first unknown is the offset.
    miss
        What was measured less y, (K,); in the unit of the rows.
    unknowns, lower
        u and its lower bounds, (p,); the offset has none.
    penalty
        What the program adds to the normal equations for each row, (p, p).
    inputs, outputs
        Input and output y of the rows, (K,); None where the rows are of the input. [input], [output]
    unit
        What one unit of each row is, (K,). [output]
    estimate
        The model of the fit. Terms that it does without may be among the unknowns.
    model
        The model with other unknowns.
    """

    rows: Array
    miss: Array
    unknowns: Array
    lower: Array
    penalty: Array
    inputs: Array | None
    outputs: Array | None
    unit: Array
    estimate: Any
    model: Callable[[Array], Any]
