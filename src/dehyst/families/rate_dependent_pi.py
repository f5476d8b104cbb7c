r"""Plays whose thresholds grow with the rate of the input, and the explicit inverse.

A Prandtl-Ishlinskii operator whose loops widen with the speed::

    T(y_k) = c + a_0 x_k + sum over i of a_i z_i,k + b s_k
    z_i,k  = max(x_k - r_i, min(x_k + r_i, z_i,k-1)),     r_i = alpha_i + beta_i |s_k|
    s_k+1  = s_k + (1 - exp(-h_k / tau)) ((x_k - x_{k-1}) / h_k - s_k)

The rate s is low-passed and made of past samples only. So the thresholds are known before a sample comes, and the
inverse is explicit: one piecewise linear equation a sample. In the literature the rate is the true one; for a rate
that is given the inverse is an operator of the same kind (`closed_inverse`), exact to rounding as long as the r_i
increase::

    b_0 = 1 / a_0,   b_i = -a_i / ((a_0 + .. + a_i) (a_0 + .. + a_{i-1}))
    r'_i = a_0 r_i + sum over j < i of a_j (r_i - r_j)

A model that takes the rate from its own input delays it, and undoing a delay sample by sample is stable only where
the low-pass is slower than the delay, for every number i of moving plays::

    |a_1 beta_1 + .. + a_i beta_i - b| < tau (a_0 + .. + a_i)

============================  ====================================================  ===========  =======================
parameter                     meaning                                               unit         source
============================  ====================================================  ===========  =======================
``direct``                    a_0 > 0, weight of the input itself                   scaled       identified, convex
``thresholds``                alpha_i > 0, at rest                                  half ranges  grid, 0 to 1
``growths``                   beta_i, from 0 on                                     s            identified, held out
``weights``                   a_i, from 0 on                                        scaled       identified, convex
``rate_weight``               b, of the rate itself; 0 in the literature            s            identified, convex
``lag``                       tau > 0                                               s            identified, held out
``offset``                    c                                                     scaled       identified, convex
``map_inner``, ``map_outer``  breakpoints T(y) and y; none: T(y) = y                scaled       identified, convex
============================  ====================================================  ===========  =======================

Source: M. Al Janaideh and P. Krejci, Inverse rate-dependent Prandtl-Ishlinskii model for feedforward compensation of
hysteresis in a piezomicropositioning actuator, IEEE/ASME Trans. Mechatronics 18, 2013. Structure: high confidence,
the inverse checked here. Low-pass, b, T and the condition of stability are this project's.

The fit: weights, b, offset and map are the solution of one convex program for given growths; growths (the same for
all, or in proportion to the thresholds), low-pass, map and start state by blocks held out within the training. There
is no seed.

Cannot show
-----------
Loops that run clockwise (no weight but b is negative); creep while the input is held: when the rate has died away
nothing moves; inertia and resonance.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from dehyst.errors import IdentificationError, ParameterError
from dehyst.families.base import UNSCALED, Scaling
from dehyst.families.convex import Rows, Weights, held_out, rows_of, solve
from dehyst.families.parallel import (
    PLAY,
    RATE,
    Elements,
    MappedModel,
    elements,
    not_negative,
    optional_array,
    same_size,
)
from dehyst.families.registry import Family
from dehyst.families.training import Training
from dehyst.models import ModelCard
from dehyst.models.arrays import Array, parameter_number, strictly_increasing
from dehyst.models.card import NO_CARD

PLAYS = 24
SMALLEST = 0.02  # weight of the input itself: the inverse's gain after a reversal is at most 50
MARGIN = 1.2  # of the low-pass, above what a stable inverse needs
MAP_PIECES = (0, 8, 20)


def _none() -> Array:
    return np.zeros(0)


@dataclass(frozen=True, repr=False, eq=False)
class RateDependentPrandtlIshlinskii(MappedModel):
    """Plays whose thresholds grow with the rate of the input; the module says the formulas.

    Parameters
    ----------
    direct
        a_0 > 0.
    thresholds, growths, weights
        alpha, beta [s] and a of the plays, (n,).
    rate_weight
        b [s].
    lag
        tau > 0 [s].
    offset, map_inner, map_outer
        c, and T^-1 by its breakpoints.

    Raises
    ------
    ParameterError
        If sizes differ, a value is not finite, thresholds do not increase, or something is negative that must not be.

    Examples
    --------
    >>> slow, fast = np.linspace(0.0, 9.0, 7), np.linspace(0.0, 0.9, 7)
    >>> model = RateDependentPrandtlIshlinskii(0.5, [0.1], [0.1], [0.5], lag=0.01)
    >>> x = np.linspace(0.0, 1.0, 7)
    >>> [round(float(model.simulate(x, time)[-1]), 3) for time in (slow, fast)]
    [0.944, 0.894]
    """

    direct: float = 1.0
    thresholds: Array = field(default_factory=_none)
    growths: Array = field(default_factory=_none)
    weights: Array = field(default_factory=_none)
    rate_weight: float = 0.0
    lag: float = 1.0
    offset: float = 0.0
    map_inner: Array = field(default_factory=_none)
    map_outer: Array = field(default_factory=_none)
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = NO_CARD
    family: ClassVar[str] = "rate-dependent-pi"
    rate_dependent: ClassVar[bool] = True

    def __post_init__(self) -> None:
        put = object.__setattr__  # frozen: normalise once, here
        for name in ("thresholds", "growths", "weights"):
            put(self, name, optional_array(getattr(self, name), name))
        for name in ("direct", "rate_weight", "lag"):
            put(self, name, parameter_number(getattr(self, name), name))
        for name in ("growths", "weights"):
            same_size(self.thresholds, getattr(self, name), ("thresholds", name))
            not_negative(getattr(self, name), name)
        strictly_increasing(self.thresholds, "thresholds")
        if self.thresholds.size and self.thresholds[0] <= 0.0:
            raise ParameterError(
                f"thresholds[0] = {self.thresholds[0]:g} is not above 0; a play of threshold 0 is the input itself: "
                f"give its weight as direct."
            )
        if self.lag <= 0.0:
            raise ParameterError(f"lag = {self.lag:g} s is not above 0; a rate needs time to be known.")
        self._check_map()

    def make(self) -> Elements:
        """Plays, then the rate."""
        return elements(
            (PLAY, self.weights, self.thresholds, self.growths),
            (RATE, self.rate_weight, 0.0, 0.0),
            slope=self.direct,
            lag=self.lag,
        )

    @property
    def free_parameters(self) -> int:
        """Direct weight, plays with weight, growth, lag and weight of the rate where they matter, offset, map."""
        plays = int(np.count_nonzero(self.weights))
        grows = int(bool(np.any(self.growths)))
        rate = int(self.rate_weight != 0.0)
        return 1 + plays + grows + rate + max(grows, rate) + self._check_map()

    @property
    def no_inverse(self) -> str:
        """A direct part that rises, and a rate that is slower than the lag it makes."""
        if self.direct <= 0.0:
            return f"the input itself has weight {self.direct:g}, so the output does not move at once when it turns."
        made = float(np.max(_made(self)))
        if made >= self.lag:
            return (
                f"the rate delays the output by up to {made:.3g} s, and it is known with a lag of only "
                f"{self.lag:.3g} s: undoing it sample by sample would oscillate."
            )
        return ""

    def closed_inverse(self) -> tuple[float, Array, Array, Array]:
        """Direct weight b_0, thresholds, growths and weights (n,) of the closed inverse for a rate that is given.

        Examples
        --------
        >>> RateDependentPrandtlIshlinskii(0.5, [0.1], [0.2], [0.5]).closed_inverse()
        (2.0, array([0.05]), array([0.1]), array([-1.]))
        """
        sums = self.direct + np.cumsum(self.weights)
        before = np.concatenate([[self.direct], sums[:-1]])
        thresholds, growths = (
            before * values - np.concatenate([[0.0], np.cumsum(self.weights * values)[:-1]])
            for values in (self.thresholds, self.growths)
        )
        return 1.0 / self.direct, thresholds, growths, -self.weights / (sums * before)

    @classmethod
    def example(cls) -> RateDependentPrandtlIshlinskii:
        """Three plays."""
        return cls(
            direct=0.4,
            thresholds=np.array([0.1, 0.3, 0.6]),
            growths=np.full(3, 0.02),
            weights=np.array([0.3, 0.2, 0.2]),
            lag=0.05,
        )


def _made(model: RateDependentPrandtlIshlinskii) -> Array:
    """Delay of the output by the rate, after each play has begun to move, (n + 1,). [s]"""
    moving = np.concatenate([[0.0], np.cumsum(model.weights * model.growths)]) - model.rate_weight
    return np.asarray(np.abs(moving) / (model.direct + np.concatenate([[0.0], np.cumsum(model.weights)])))


def fit(training: Training) -> RateDependentPrandtlIshlinskii:
    """Weights by the convex program; growth, lag and map by blocks held out within the training."""
    if not training.timed:
        raise IdentificationError(
            "thresholds that grow with the rate need time, but the recording has no time stamps. Name their column "
            "(--time), or take a family without rate, such as pi."
        )
    if training.clockwise:
        raise IdentificationError(
            "the loops run clockwise (the output leads the input), and rate-dependent-pi has no negative weights: it "
            "can only lag. Take maxwell-slip, which has dampers, or swap input and output."
        )
    short, best, chosen = training.thinned(), np.inf, None
    for template in _templates(training):
        rows = _rows(short, template)
        for pieces in MAP_PIECES:
            error = held_out(rows, pieces)
            if error < 0.99 * best:
                best, chosen = error, (template, pieces)
    assert chosen is not None
    template, pieces = chosen
    found = solve(_rows(training, template), pieces)
    return training.best_start(_model(template, found))


def _templates(training: Training) -> list[RateDependentPrandtlIshlinskii]:
    """Without growth first; then delays that are a share of the shortest time in which the input crosses its range."""
    rates = np.concatenate([np.diff(s.x) / s.dt[1:] for s in training.stretches if s.dt is not None])
    crossing = 1.0 / max(float(np.quantile(np.abs(rates), 0.95)), 1e-12)
    delays = [0.0, *(crossing * np.array([0.02, 0.05, 0.1, 0.2, 0.4, 0.8]))]
    thresholds = ((0.5 + np.arange(PLAYS)) / PLAYS) ** 1.5
    found = []
    for delay, rising, start in itertools.product(delays, (False, True), ("zero", "rest")):
        if delay == 0.0 and rising:
            continue
        growths = delay * (thresholds / thresholds[-1] if rising else np.ones(PLAYS))
        lag = max(MARGIN * delay, 0.02 * crossing)
        found.append(
            RateDependentPrandtlIshlinskii(
                thresholds=thresholds,
                growths=growths,
                weights=np.ones(PLAYS),
                lag=lag,
                scaling=training.scaling,
                start=start,
            )
        )
    return found


def _rows(training: Training, template: RateDependentPrandtlIshlinskii) -> Rows:
    """Rows of the input itself and the plays; the rate brings the direct weight that its inverse needs."""
    n = template.weights.size
    found = rows_of(training, template, np.zeros(n + 1))
    x = np.concatenate([s.x[s.counts] for s in training.stretches])
    rate = found.bounded[:, n]
    bounded = np.column_stack([x, found.bounded[:, :n], *_signed_rates(x, rate, template)])
    return Rows(found.free, bounded, found.y, found.fold, np.concatenate([[SMALLEST], np.zeros(n + 2)]))


def _signed_rates(x: Array, rate: Array, template: RateDependentPrandtlIshlinskii) -> tuple[Array, Array]:
    needed = MARGIN / template.lag
    return needed * x + rate, needed * x - rate


def _model(template: RateDependentPrandtlIshlinskii, found: Weights) -> RateDependentPrandtlIshlinskii:
    n = template.weights.size
    direct, a, (ahead, behind) = float(found.bounded[0]), found.bounded[1 : 1 + n], found.bounded[1 + n :]
    kept = a > 0.0
    return RateDependentPrandtlIshlinskii(
        direct + MARGIN / template.lag * float(ahead + behind),
        template.thresholds[kept],
        template.growths[kept],
        a[kept],
        float(ahead - behind),
        template.lag,
        found.offset,
        found.map_inner,
        found.map_outer,
        template.scaling,
        template.start,
    )


FAMILY = Family(
    "rate-dependent-pi",
    "Rate-dependent Prandtl-Ishlinskii",
    RateDependentPrandtlIshlinskii,
    fit,
    True,
    "Al Janaideh and Krejci 2013",
)
