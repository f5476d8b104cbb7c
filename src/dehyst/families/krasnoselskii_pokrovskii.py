r"""Krasnosel'skii-Pokrovskii operator: a Preisach operator whose relays switch along ridges of finite slope.

.. math::

    y = c + \sum_{i \ge j} w_{ij}\, z_{ij}, \qquad
    z_{ij}[k] = \max\big(r(x_k - \rho_i),\ \min(r(x_k - \rho_j),\ z_{ij}[k-1])\big)

    r(u) = -1 \ (u \le 0), \quad 2 u/a - 1 \ (0 \le u \le a), \quad 1 \ (u \ge a)

A kernel rises along the ridge that begins at rho_i and falls along the one that begins at rho_j <= rho_i: a generalised
play with two levels at which it saturates. The output is continuous for any finite number of kernels, which that of a
sum of relays is not, and it is piecewise linear in the input. Kernels with i = j have no memory; where their ridges
cover the range with positive weights, the output strictly follows the input. Beyond the ridges it goes on with the mean
slope.

With a ridge as wide as the lines are apart and weights that depend on i - j only it is a Prandtl-Ishlinskii operator
with thresholds (i - j) a/2; with a ridge that gets narrower it becomes the Preisach operator with relays rho_i, rho_j.

=============  =============================================================  ========  ===============================
parameter      meaning                                                        unit      source
=============  =============================================================  ========  ===============================
lines          rho, where ridges begin, (n,), increasing                      scaled    chosen by held-out blocks
ridge          a, width of a ridge                                            scaled    chosen by held-out blocks
weights        w_ij, j <= i, row by row, (n (n + 1)/2,)                       scaled    convex fit
offset         c                                                              scaled    convex fit
=============  =============================================================  ========  ===============================

Sources: Krasnosel'skii and Pokrovskii 1983 for generalised plays and ridge functions; Banks, Kurdila and Webb 1997
for kernels on a grid and their identification (equations as in the textbooks, high confidence; nothing about pneumatic
muscles was found). The start state is that of the Preisach operator: unknown, until a decaying sweep has left each
kernel halfway between its ridges, which is `rest`.

Cannot show
-----------
Rate, creep, drift. Minor loops between the same inputs are congruent, as of the Preisach operator. Ridges have one
width everywhere, so that a sharp corner of the loop and a gentle one do not stand in one model. Clockwise loops need
negative weights off the diagonal; they are fitted, and have an inverse only if the reversible part outweighs them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst.errors import ParameterError
from dehyst.families.base import UNSCALED, LoopModel, Scaling
from dehyst.families.registry import Family
from dehyst.families.training import Training
from dehyst.families.triangle import size_of, triangle_of
from dehyst.families.triangle_fit import beyond, fit_triangle
from dehyst.models import ModelCard
from dehyst.models.arrays import parameter_array, parameter_number
from dehyst.models.card import NO_CARD

Array = npt.NDArray[np.float64]

SHAPES = ((10, 1), (20, 1), (20, 2), (20, 4))  # lines over the fitted range, distances of them a ridge is wide
FINEST = 32  # lines, tried where 20 are better than 10


@dataclass(frozen=True, repr=False, eq=False)
class KrasnoselskiiPokrovskii(LoopModel):
    """Krasnosel'skii-Pokrovskii operator; the module's docstring has the equations.

    Attributes
    ----------
    lines
        Where ridges begin, (n,), increasing. [scaled input]
    ridge
        Width of a ridge, positive. [scaled input]
    weights
        w_ij, j <= i, in the order (0,0), (1,0), (1,1), (2,0) ..., (n (n + 1)/2,). [scaled output]
    offset
        Output when half of all is up. [scaled output]

    Examples
    --------
    >>> one = KrasnoselskiiPokrovskii(lines=np.array([-1.0, 0.0]), ridge=1.0, weights=np.array([0.0, 1.0, 0.0]))
    >>> one.with_start("rising").simulate([-1.0, 0.0, 0.5, 1.0, 0.0, -0.5]).tolist()
    [-1.0, -1.0, 0.0, 1.0, 1.0, 0.0]
    """

    lines: Array = field(default_factory=lambda: np.array([-1.0, 0.0]))
    ridge: float = 1.0
    weights: Array = field(default_factory=lambda: np.array([0.1, 0.8, 0.1]))
    offset: float = 0.0
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = NO_CARD
    family = "krasnoselskii-pokrovskii"

    def __post_init__(self) -> None:
        """Check the parameters."""
        lines, weights = parameter_array(self.lines, "lines"), parameter_array(self.weights, "weights")
        ridge = parameter_number(self.ridge, "ridge")
        if np.any(np.diff(lines) <= 0.0) or weights.size != size_of(lines.size):
            raise ParameterError(
                f"{lines.size} lines with {weights.size} weights do not make a Krasnosel'skii-Pokrovskii model: n "
                f"increasing lines have n (n + 1)/2 weights w_ij, j <= i."
            )
        if ridge <= 0.0:
            raise ParameterError(f"ridge = {ridge:g} must be positive: over this input a kernel rises.", ridge=ridge)
        for name, value in (("lines", lines), ("weights", weights), ("ridge", ridge)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "offset", parameter_number(self.offset, "offset"))

    def rest(self, x: float) -> Array:
        """States of kernels halfway between their ridges, what a decaying sweep about x leaves."""
        i, j = np.tril_indices(self.lines.size)
        middle = 0.5 * (self.lines[i] + self.lines[j])
        return np.asarray(np.clip(2.0 * (x - middle) / self.ridge - 1.0, -1.0, 1.0))

    def run(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:  # noqa: D102
        return _native.kernels_run(*self._engine, memory, x)

    def run_inverse(self, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Scaled inputs for scaled outputs: a search among the lines, then Newton's steps, exact on the last piece."""
        return _native.kernels_invert(*self._engine, memory, y)

    def states(self, x: Array) -> Array:
        """States of the kernels, (T, n (n + 1)/2): output = offset + states @ weights."""
        return _native.kernels_states(self.lines, self.ridge, self.before(float(x[0])), x)

    @cached_property
    def _engine(self) -> tuple[Array, float, Array, float, float, float]:
        """What the kernels in C take; beyond the ridges the mean slope of the largest loop."""
        slope = 2.0 * float(np.sum(self.weights)) / float(self.lines[-1] + self.ridge - self.lines[0])
        return self.lines, self.ridge, self.weights, self.offset, slope, slope

    @property
    def width(self) -> float:
        """Input over which a kernel rises. [scaled input]"""
        return self.ridge

    def with_masses(self, masses: Array, offset: float) -> Self:
        """Return the same grid with other weights, (n (n + 1)/2,)."""
        return replace(self, weights=masses, offset=offset)

    @property
    def free_parameters(self) -> int:  # noqa: D102
        return 1 + int(np.count_nonzero(np.abs(self.weights) > 1e-12))

    @property
    def no_inverse(self) -> str:  # noqa: D102
        edges = np.unique(np.concatenate([self.lines, self.lines + self.ridge]))
        pieces = np.diff(edges) > 1e-9 * (edges[-1] - edges[0])  # a line may begin where a ridge ends, but for rounding
        middles = (0.5 * (edges[1:] + edges[:-1]))[pieces]
        on = (middles[:, None] > self.lines) & (middles[:, None] < self.lines + self.ridge)
        # Rising, a ridge moves its kernels from the diagonal on, those of the nearest line first; falling likewise.
        square = triangle_of(self.weights)
        rising = np.array([np.min(np.cumsum(square[i, i::-1])) for i in range(self.lines.size)])
        falling = np.array([np.min(np.cumsum(square[j:, j])) for j in range(self.lines.size)])
        least = np.minimum(on @ rising, on @ falling)
        flat = least <= 1e-9 * float(np.sum(np.abs(self.weights)))
        if not np.any(flat):
            return ""
        return (
            f"on {np.count_nonzero(flat)} of {middles.size} pieces between its ridges the output need not follow the "
            f"input; positive weights on the diagonal that outweigh negative ones, and ridges without gaps, give one."
        )

    @classmethod
    def example(cls) -> Self:
        """Kernels around the middle of their plane, ridges two lines wide."""
        model = cls(*_grid(12, 2, 0))
        i, j = np.tril_indices(12)
        weights = np.exp(-0.05 * (i + j - 11.0) ** 2 - 0.1 * (i - j - 3.0) ** 2) + 0.6 * (i == j)
        return model.with_masses(weights / np.sum(weights), 0.0)


def _grid(lines: int, wide: int, more: int) -> tuple[Array, float, Array]:
    """Lines, ridge and zero weights; ridges of `wide` distances together cover -1..1, `more` of them lie beyond."""
    apart = 2.0 / (lines - 1 + wide)
    rho = np.asarray(-1.0 + apart * np.arange(-more, lines + more), dtype=np.float64)
    return rho, wide * apart, np.zeros(size_of(rho.size))


def fit(training: Training) -> KrasnoselskiiPokrovskii:
    """Least squares of the weights, not negative (off the diagonal not positive for clockwise loops): convex."""

    def blank(lines: int, wide: int) -> KrasnoselskiiPokrovskii:
        return KrasnoselskiiPokrovskii(*_grid(lines, wide, beyond(lines)), scaling=training.scaling)

    def finer(best: KrasnoselskiiPokrovskii) -> list[KrasnoselskiiPokrovskii]:
        if best.lines.size == SHAPES[0][0] + 2 * beyond(SHAPES[0][0]):
            return []
        wide = round(best.ridge / float(best.lines[1] - best.lines[0]))
        return [blank(FINEST, wide).with_start(best.start)]

    return fit_triangle(training, [blank(*shape) for shape in SHAPES], finer)


FAMILY = Family(
    name="krasnoselskii-pokrovskii",
    title="Krasnosel'skii-Pokrovskii",
    model=KrasnoselskiiPokrovskii,
    fit=fit,
    convex=True,
    source="Krasnosel'skii and Pokrovskii 1983; Banks, Kurdila and Webb 1997",
)
