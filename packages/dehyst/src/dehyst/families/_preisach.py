r"""Preisach operator with an Everett function: rate-independent loops with congruent minor loops.

.. math::

    y = c + \iint_{\alpha \ge \beta} \mu(\alpha, \beta)\, \gamma_{\alpha\beta}[x]\, d\alpha\, d\beta, \qquad
    E(\alpha, \beta) = \iint_{\beta \le \beta' \le \alpha' \le \alpha} \mu\, d\alpha'\, d\beta'

A relay :math:`\gamma_{\alpha\beta}` is 1 from x >= alpha on and -1 from x <= beta on. The output follows from the
Everett function E alone: from a turn at input e with output y_e it goes along ::

    y = y_e + 2 E(x, e)   rising,        y = y_e - 2 E(e, x)   falling

so that E(alpha, beta) is half the output difference on a first-order reversal curve, which is how it is measured. The
memory are the turns that no later one has passed (wiping out).

The Everett function is given on a grid of turning values and is bilinear between them: in every square cell the
measure is constant. What the cells on the diagonal weigh is spread along it, as a reversible slope; it makes the output
strictly follow the input, and along every branch the output is piecewise linear. Beyond the grid the output goes on
with the mean slope of the major loop, without further memory.

=============  =============================================================  ========  ===============================
parameter      meaning                                                        unit      source
=============  =============================================================  ========  ===============================
knots          turning values, (n + 1,), increasing                           scaled    chosen by held-out blocks
everett        E(knot a, knot b), a > b, row by row, (n (n + 1)/2,)           scaled    convex fit
offset         c, the output halfway between both saturations                 scaled    convex fit
=============  =============================================================  ========  ===============================

Sources: Preisach 1935; Everett 1955; Mayergoyz 1991 for the theorem (wiping out and congruent minor loops are necessary
and sufficient) and for the identification from reversal curves. Van Damme 2009 used it for a pleated pneumatic muscle,
from first-order reversal curves and normalised by pressure; it did not go into control because the initial state was
unknown (equations as in the textbooks, high confidence). A decaying sweep of the input solves that: whatever the past,
it leaves one and the same state, that of `start` "zero". `rest` is what such a sweep about x leaves, with turns that
come closer by a quarter of a cell each time.

Cannot show
-----------
Rate, creep, drift: the output depends on the order of the turning values only. Minor loops between the same inputs are
congruent; where measured ones change their height with the mean output, no measure fits. Loops within one cell have no
width. Loops that run clockwise need a measure that is negative off the diagonal; it is fitted for them, and has an
inverse only if the reversible part outweighs it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.families._base import UNSCALED, LoopModel, Scaling
from dehyst.families._registry import Family
from dehyst.families._training import Training
from dehyst.families._triangle import masses_of, prefixes, triangle_size
from dehyst.families._triangle_fit import beyond, fit_triangle
from dehyst.models import ModelCard
from dehyst.models import kit as models_kit

GRIDS = (10, 20)  # cells on a side over the fitted range
FINEST = 32  # tried where 20 are better than 10


@dataclass(frozen=True, repr=False, eq=False)
class Preisach(LoopModel):
    """Preisach operator; the module's docstring has the equations.

    Attributes
    ----------
    knots
        Turning values, (n + 1,), increasing. [scaled input]
    everett
        E(knots[a], knots[b]) for a > b, in the order (1,0), (2,0), (2,1), (3,0) ..., (n (n + 1)/2,). [scaled output]
    offset
        Output halfway between both saturations. [scaled output]

    Examples
    --------
    >>> relay_like = Preisach(np.array([-1.0, 0.0, 1.0]), np.array([0.1, 0.9, 0.1]))
    >>> relay_like.simulate([-1.0, 0.0, 1.0, 0.0, -1.0]).round(6).tolist()
    [-0.9, -0.7, 0.9, 0.7, -0.9]
    """

    knots: Array = field(default_factory=lambda: np.array([-1.0, 0.0, 1.0]))
    everett: Array = field(default_factory=lambda: np.array([0.1, 0.9, 0.1]))
    offset: float = 0.0
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = models_kit.NO_CARD
    family = "preisach"
    memory_grows = True

    def __post_init__(self) -> None:
        """Check the parameters and lay out the table."""
        knots = models_kit.parameter_array(self.knots, "knots")
        everett = models_kit.parameter_array(self.everett, "everett")
        increasing = knots.size >= 2 and not np.any(np.diff(knots) <= 0.0)
        if not increasing or everett.size != triangle_size(knots.size - 1):
            raise ParameterError(
                f"{knots.size} knots with {everett.size} values of the Everett function do not make a Preisach model: "
                f"n + 1 increasing knots, n >= 1, have n (n + 1)/2 values E(knots[a], knots[b]), a > b."
            )
        for name, value in (("knots", knots), ("everett", everett)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "offset", models_kit.parameter_number(self.offset, "offset"))

    @cached_property
    def table(self) -> Array:
        """E at all pairs of knots, (n + 1, n + 1), E(knots[a], knots[b]) in row a; 0 where a <= b."""
        n = self.knots.size
        table = np.zeros((n, n))
        table[1:, :-1][np.tril_indices(n - 1)] = self.everett
        return table

    @cached_property
    def _beyond(self) -> tuple[float, float]:
        """Slopes of the output below and above the grid: the mean one of the major loop, as its ends may be flat."""
        # The mean slope, since a grid often ends where the loop saturates.
        slope = 2.0 * float(self.table[-1, 0] / (self.knots[-1] - self.knots[0]))
        return slope, slope

    @classmethod
    def from_masses(cls, knots: Array, masses: Array, offset: float = 0.0) -> Self:
        """Return the operator whose cells (i, j), j <= i, between knots i, i + 1 and j, j + 1 weigh so much.

        Examples
        --------
        >>> Preisach.from_masses([-1.0, 0.0, 1.0], [0.1, 0.7, 0.1]).everett.round(6).tolist()
        [0.1, 0.9, 0.1]
        """
        return cls(knots, prefixes(models_kit.parameter_array(masses, "masses")), offset)

    @property
    def masses(self) -> Array:
        """What each cell weighs, (n (n + 1)/2,), in the order of `everett`; on the diagonal it is reversible."""
        return masses_of(self.everett)

    def rest(self, x: float) -> Array:
        low, high = float(self.knots[0]), float(self.knots[-1])
        sweep = np.clip(x + _decay(low, high, self.knots.size - 1), low, high)
        return self.run(sweep, None, self.saturated())[1]

    def saturated(self) -> Array:
        """Memory of negative saturation: every relay is down, whatever was before."""
        low = float(self.knots[0])
        lowest = self.offset - float(self.table[-1, 0])
        return np.array([low, lowest, low, lowest])

    def run(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        return _native.preisach_run(self.knots, self.table.ravel(), *self._beyond, memory, x)

    def run_inverse(self, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Scaled inputs for scaled outputs in closed form: the stack is unwound by its outputs, then a piece solved."""
        return _native.preisach_invert(self.knots, self.table.ravel(), *self._beyond, memory, y)

    def states(self, x: Array) -> Array:
        """States of the cells, (T, n (n + 1)/2), -1 down to 1 up: output = offset + states @ masses."""
        return _native.preisach_cells(self.knots, self.before(float(x[0])), x)

    @property
    def width(self) -> float:
        """Width of a cell, the narrowest one's. [scaled input]"""
        return float(np.min(np.diff(self.knots)))

    def with_masses(self, masses: Array, offset: float) -> Self:
        """Return the same grid with other masses, (n (n + 1)/2,)."""
        return replace(self, everett=prefixes(masses), offset=offset)

    @property
    def free_parameters(self) -> int:
        return 1 + int(np.count_nonzero(np.abs(self.masses) > 1e-12))

    @property
    def no_inverse(self) -> str:
        rising, falling = np.diff(self.table, axis=0), -np.diff(self.table, axis=1)
        inside = np.tril_indices(self.knots.size - 1)
        steps = np.concatenate([rising[:, :-1][inside], falling[1:][inside]])
        # Rounding of the fit may leave steps of this size where the output stands still.
        follows = steps > 1e-9 * float(np.sum(np.abs(self.masses)))
        if np.all(follows):
            return ""
        return (
            f"on {np.count_nonzero(~follows)} of {steps.size} pieces of its branches the output does not follow the "
            f"input; a positive reversible part on the diagonal that outweighs negative cells gives one."
        )

    @classmethod
    def example(cls) -> Self:
        """A measure around its middle, with a reversible part."""
        knots = np.linspace(-1.0, 1.0, 13)
        middle = 0.5 * (knots[1:] + knots[:-1])
        i, j = np.tril_indices(12)
        mean, width = middle[i] + middle[j], middle[i] - middle[j]
        masses = np.exp(-6.0 * mean**2 - 8.0 * (width - 0.5) ** 2)
        masses[i == j] = 1.0 + middle
        return cls.from_masses(knots, masses / np.sum(masses))


def _decay(low: float, high: float, cells: int) -> Array:
    """Offsets of a sweep about a point whose turns come closer by a quarter of a cell each time; the last one is 0.

    The corners of the staircase that it leaves lie in turn on both sides of alpha + beta = 2 x: none is preferred.
    """
    turns = 4 * cells
    size = (high - low) * np.arange(turns, -1, -1) / turns
    return np.asarray(size * np.where(np.arange(turns, -1, -1) % 2, -1.0, 1.0))


def fit_preisach(training: Training) -> Preisach:
    """Least squares of the masses, not negative (off the diagonal not positive for clockwise loops): convex."""
    grids = [_blank(cells, training) for cells in GRIDS]
    return fit_triangle(training, grids, lambda best: _finer(best, training))


def _blank(cells: int, training: Training) -> Preisach:
    more = beyond(cells)
    knots = np.asarray(np.arange(-more, cells + more + 1) * (2.0 / cells) - 1.0, dtype=np.float64)
    return Preisach(knots, np.zeros(triangle_size(knots.size - 1)), scaling=training.scaling)


def _finer(best: Preisach, training: Training) -> list[Preisach]:
    """Return a finer grid, if the finer one of the two was better."""
    if best.knots.size <= GRIDS[0] + 2 * beyond(GRIDS[0]) + 1:
        return []
    return [_blank(FINEST, training).with_start(best.start)]


FAMILY = Family(
    name="preisach",
    title="Preisach",
    model=Preisach,
    fit=fit_preisach,
    convex=True,
    source="Preisach 1935; Everett 1955; Mayergoyz 1991",
)
