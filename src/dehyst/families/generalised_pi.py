r"""Plays between two equal envelopes: loops that saturate, with a closed inverse.

A Prandtl-Ishlinskii operator of a rising envelope g instead of the input::

    z_i = max(g(x) - r_i, min(g(x) + r_i, z_i))
    y   = c + q g(x) + sum over i of p_i z_i
    g(x) = a_0 tanh(a_1 x + a_2) + a_3,  or piecewise linear through given points

so its inverse is the closed one of that operator, then the envelope backwards, x = g^-1(Pi^-1[y]).

============================  ====================================================  ===========  =======================
parameter                     meaning                                               unit         source
============================  ====================================================  ===========  =======================
``shape``                     a_0 > 0, a_1 > 0, a_2, a_3; empty: none               scaled       identified, search
``points_x``, ``points_g``    points of a piecewise linear envelope; empty: none    scaled       identified, search
``direct``                    q > 0, weight of the envelope itself                  scaled       identified, convex
``thresholds``                r_i, of g                                             scaled       grid, 0 to 1
``weights``                   p_i, from 0 on                                        scaled       identified, convex
``offset``                    c                                                     scaled       identified, convex
============================  ====================================================  ===========  =======================

Source: M. Al Janaideh, S. Rakheja and C.-Y. Su, An analytical generalized Prandtl-Ishlinskii model inversion for
hysteresis compensation in micropositioning control, IEEE/ASME Trans. Mechatronics 16, 2011. Structure: high
confidence. The numbers of `GeneralisedPrandtlIshlinskii.published` are those of Al Janaideh's example program.

The fit: for a given envelope weights and offset are the solution of a convex program; the envelope is searched around
it (variable projection) from nine fixed and three seeded starts for the tangent, and from the tangent for the points.
Which envelope is taken is decided by blocks held out within the training.

Cannot show
-----------
Loops that run clockwise (no weight is negative); branches that differ other than by the envelope, as both sides have
the same one (with two there is no closed inverse); creep and rate.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from scipy.optimize import least_squares, minimize

from dehyst import _native
from dehyst.errors import IdentificationError, ParameterError
from dehyst.families.base import UNSCALED, Scaling
from dehyst.families.convex import Rows, held_out, rows_of, solve
from dehyst.families.parallel import PLAY, Elements, ParallelModel, elements, not_negative, optional_array, same_size
from dehyst.families.registry import Family
from dehyst.families.training import Training
from dehyst.models import ModelCard
from dehyst.models.arrays import Array, parameter_number, strictly_increasing
from dehyst.models.card import NO_CARD
from dehyst.ties import rank

PLAYS = 20
SMALLEST = 0.02  # weight of the envelope itself: the inverse's gain after a reversal is at most 50 times that of g
PIECES = (6, 12)
SEARCHED = 2000  # samples that a search looks at
EVALUATIONS = 120  # of one search
STARTS = 3  # of the search for the tangent
SATURATED = 1.0 - 1e-12


def _none() -> Array:
    return np.zeros(0)


@dataclass(frozen=True, repr=False, eq=False)
class GeneralisedPrandtlIshlinskii(ParallelModel):
    """Plays between two equal envelopes; the module says the formulas.

    Parameters
    ----------
    direct, thresholds, weights
        q > 0; r and p of the plays, (n,).
    shape
        (a_0, a_1, a_2, a_3), or empty.
    points_x, points_g
        Points of a piecewise linear envelope, (m,), or empty. With neither the envelope is x.
    offset
        c.

    Raises
    ------
    ParameterError
        If sizes differ, a value is not finite, or the envelope does not rise.

    Examples
    --------
    >>> model = GeneralisedPrandtlIshlinskii.published()
    >>> y = model.simulate([0.0, 5.0, -2.0, 1.0])
    >>> bool(np.max(np.abs(model.inverse().simulate(y) - [0.0, 5.0, -2.0, 1.0])) < 1e-13)
    True
    """

    direct: float = 1.0
    thresholds: Array = field(default_factory=_none)
    weights: Array = field(default_factory=_none)
    shape: Array = field(default_factory=_none)
    points_x: Array = field(default_factory=_none)
    points_g: Array = field(default_factory=_none)
    offset: float = 0.0
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = NO_CARD
    family: ClassVar[str] = "generalised-pi"

    def __post_init__(self) -> None:
        put = object.__setattr__  # frozen: normalise once, here
        for name in ("thresholds", "weights", "shape", "points_x", "points_g"):
            put(self, name, optional_array(getattr(self, name), name))
        for name in ("direct", "offset"):
            put(self, name, parameter_number(getattr(self, name), name))
        same_size(self.thresholds, self.weights, ("thresholds", "weights"))
        same_size(self.points_x, self.points_g, ("points_x", "points_g"))
        for name in ("thresholds", "weights"):
            not_negative(getattr(self, name), name)
        for name in ("points_x", "points_g"):
            strictly_increasing(getattr(self, name), name)
        if self.points_x.size == 1 or (self.points_x.size and self.shape.size):
            raise ParameterError("an envelope is a tangent (shape), or two points or more, or neither; not both.")
        if self.shape.size not in (0, 4) or (self.shape.size and min(self.shape[:2]) <= 0.0):
            raise ParameterError("shape is (a0, a1, a2, a3) with a0 > 0 and a1 > 0: the envelope must rise.")

    def envelope(self, x: Array) -> Array:
        """g(x)."""
        if self.shape.size:
            a = self.shape
            return np.asarray(a[0] * np.tanh(a[1] * x + a[2]) + a[3])
        return _native.map_values(self.points_x, self.points_g, x) if self.points_x.size else x

    def envelope_inverse(self, g: Array) -> Array:
        """The x at which the envelope is g; of values that no x reaches, the farthest x that numbers tell apart."""
        if self.shape.size:
            a = self.shape
            return np.asarray((np.arctanh(np.clip((g - a[3]) / a[0], -SATURATED, SATURATED)) - a[2]) / a[1])
        return _native.map_values(self.points_g, self.points_x, g) if self.points_x.size else g

    def make(self) -> Elements:
        """Plays of g."""
        return elements((PLAY, self.weights, self.thresholds, 0.0), slope=self.direct)

    def seen(self, x: Array) -> Array:
        """The envelope."""
        return np.ascontiguousarray(self.envelope(x))

    def run_inverse(self, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """The plays backwards, then the envelope."""
        g, after = super().run_inverse(y, dt, memory)
        return self.envelope_inverse(g), after

    @property
    def free_parameters(self) -> int:
        """Weights that are not 0, offset, and the envelope; its scale and level are those of the weights."""
        return 2 + int(np.count_nonzero(self.weights)) + self.shape.size // 2 + max(0, self.points_x.size - 2)

    @property
    def no_inverse(self) -> str:
        """The envelope itself must have weight."""
        if self.direct <= 0.0:
            return f"the envelope itself has weight {self.direct:g}, so the output does not move at once when x turns."
        return ""

    @classmethod
    def example(cls) -> GeneralisedPrandtlIshlinskii:
        """Three plays in a tangent."""
        return cls(
            direct=0.3,
            thresholds=np.array([0.1, 0.3, 0.6]),
            weights=np.array([0.3, 0.2, 0.2]),
            shape=np.array([1.2, 1.2, 0.2, -0.2]),
        )

    @classmethod
    def published(cls) -> GeneralisedPrandtlIshlinskii:
        """Return Al Janaideh's example: seven plays, the first with threshold 0."""
        r: Array = 0.45 * np.arange(7, dtype=np.float64)
        p = np.asarray(0.65 * np.exp(-7.75e-4 * r), dtype=np.float64)
        return cls(0.4, r, p, np.array([6.0, 0.4, 0.0, 0.0]))


def fit(training: Training) -> GeneralisedPrandtlIshlinskii:
    """Weights by the convex program for every envelope that a seeded search looks at (variable projection)."""
    if training.clockwise:
        raise IdentificationError(
            "the loops run clockwise (the output leads the input), and generalised-pi has no negative weights: it can "
            "only lag. Take maxwell-slip, or swap input and output."
        )
    few = training.thinned(SEARCHED)
    plain = min((_template(training, start) for start in ("zero", "rest")), key=lambda model: rank(_error(few, model)))
    tangent = _search_tangent(few, plain)
    candidates = [plain, tangent, *(_search_points(few, tangent, pieces) for pieces in PIECES)]
    short, best, chosen = training.thinned(), np.inf, plain
    for model in candidates:
        error = held_out(_rows(short, model))
        if error < 0.99 * best:
            best, chosen = error, model
    return training.best_start(_solved(training, chosen))


def _template(training: Training, start: str) -> GeneralisedPrandtlIshlinskii:
    thresholds = ((0.5 + np.arange(PLAYS)) / PLAYS) ** 1.5
    return GeneralisedPrandtlIshlinskii(
        thresholds=thresholds, weights=np.ones(PLAYS), scaling=training.scaling, start=start
    )


def _rows(training: Training, model: GeneralisedPrandtlIshlinskii) -> Rows:
    """Rows of the envelope itself and of the plays."""
    rows = rows_of(training, model, np.zeros(model.weights.size))
    g = model.envelope(np.concatenate([s.x[s.counts] for s in training.stretches]))
    return replace(rows, bounded=np.column_stack([g, rows.bounded]), lower=np.insert(rows.lower, 0, SMALLEST))


def _residual(training: Training, model: GeneralisedPrandtlIshlinskii) -> Array:
    """What the best weights leave, (K,)."""
    rows = _rows(training, model)
    return solve(rows).predict(rows) - rows.y


def _error(training: Training, model: GeneralisedPrandtlIshlinskii) -> float:
    return float(np.mean(_residual(training, model) ** 2))


def _search_tangent(training: Training, plain: GeneralisedPrandtlIshlinskii) -> GeneralisedPrandtlIshlinskii:
    """Tangent through (-1, -1) and (1, 1) with the steepness exp(u_0) and the place u_1 that leave least."""

    def bent(u: Array) -> GeneralisedPrandtlIshlinskii:
        steep, place = float(np.exp(np.clip(u[0], -3.0, 2.0))), float(np.clip(u[1], -4.0, 4.0))
        low, high = np.tanh(place - steep), np.tanh(place + steep)
        scale = 2.0 / max(high - low, 1e-9)
        return replace(plain, shape=np.array([scale, steep, place, -1.0 - scale * low]))

    random = training.random()
    grid = [np.array([np.log(steep), place]) for steep in (0.4, 1.0, 2.0) for place in (-1.0, 0.0, 1.0)]
    grid += [np.array([random.uniform(-1.5, 1.0), random.uniform(-2.0, 2.0)]) for _ in range(3)]
    ranked = sorted(grid, key=lambda u: rank(_error(training, bent(u))))[:STARTS]
    options = {"maxfev": EVALUATIONS // STARTS, "xatol": 1e-3, "fatol": 1e-9}
    found = [minimize(lambda u: _error(training, bent(u)), u, method="Nelder-Mead", options=options) for u in ranked]
    return bent(min(found, key=lambda result: rank(float(result.fun))).x)


def _search_points(
    training: Training, tangent: GeneralisedPrandtlIshlinskii, pieces: int
) -> GeneralisedPrandtlIshlinskii:
    """Piecewise linear envelope from -1 to 1, its slopes from those of the tangent on."""
    x = np.linspace(-1.0, 1.0, pieces + 1)

    def bent(u: Array) -> GeneralisedPrandtlIshlinskii:
        rise = np.exp(np.clip(u, -5.0, 5.0))
        return replace(tangent, shape=_none(), points_x=x, points_g=_from_rises(rise))

    def miss(u: Array) -> Array:
        held = 1e-3 * np.sqrt(training.samples) * np.diff(u)  # slopes that the data leaves open follow their neighbours
        return np.concatenate([_residual(training, bent(u)), held])

    start = np.log(np.maximum(np.diff(tangent.envelope(x)), 1e-2))
    found = least_squares(miss, start - np.mean(start), method="trf", diff_step=1e-4, max_nfev=max(4, 100 // pieces))
    return bent(found.x)


def _from_rises(rise: Array) -> Array:
    return -1.0 + 2.0 * np.concatenate([[0.0], np.cumsum(rise)]) / np.sum(rise)


def _solved(training: Training, model: GeneralisedPrandtlIshlinskii) -> GeneralisedPrandtlIshlinskii:
    found = solve(_rows(training, model))
    p = found.bounded[1:]
    return replace(
        model,
        direct=float(found.bounded[0]),
        thresholds=model.thresholds[p > 0.0],
        weights=p[p > 0.0],
        offset=found.offset,
    )


FAMILY = Family(
    "generalised-pi",
    "Generalised Prandtl-Ishlinskii",
    GeneralisedPrandtlIshlinskii,
    fit,
    False,
    "Al Janaideh, Rakheja and Su 2011",
)
