r"""Creep beside plays: an actuator that goes on moving after its input has stopped, and the explicit inverse.

A Prandtl-Ishlinskii operator with creep operators in parallel, and a monotone map T behind them::

    T(y_k) = c + sum over i of w_i P_i[x]_k + sum over j of v_j K_j[x]_k
    P_i:  z_k = max(x_k - r_i, min(x_k + r_i, z_{k-1}))                           play of threshold r_i
    K_j:  z_k = t + (z_{k-1} - t) exp(-h_k / T_j),  t = z_{k-1} clipped to x_{k-1} -+ s_j

h_k is the time since the sample before. K follows the input that was held meanwhile, exactly, so steps of time of any
length may be mixed. It knows past samples only, which makes the inverse explicit: undo T, take away what creep gives,
undo the plays. Time constants stand in a geometric row: with equal weights the answer to a step grows with the
logarithm of time, one unit a decade. The inverse is stable where the input itself has enough weight against creep
that is as fast as the sampling (a delay cannot be undone)::

    w_1 > sum over j of v_j q_j / (2 - q_j),    q_j = 1 - exp(-h / T_j)

==============================  ==================================================  ===========  =====================
parameter                       meaning                                             unit         source
==============================  ==================================================  ===========  =====================
``thresholds``                  r_i, the first is 0                                 half ranges  grid, 0 to 1
``weights``                     w_i, from 0 on; w_1 > 0                             scaled       identified, convex
``creep_thresholds``            s_j, within which creep does not pull; 0 is a lag   half ranges  grid, 0 to 0.3
``time_constants``              T_j                                                 s            grid of the sampling
``creep_weights``               v_j, from 0 on                                      scaled       identified, convex
``offset``                      c                                                   scaled       identified, convex
``map_inner``, ``map_outer``    breakpoints T(y) and y; none: T(y) = y              scaled       identified, convex
``period``                      h, for which the inverse is stable; 0: not checked  s            of the log
==============================  ==================================================  ===========  =====================

Source: P. Krejci and K. Kuhnen, Inverse control of systems with hysteresis and creep, IEE Proc. Control Theory Appl.
148, 2001; K. Kuhnen, 2003, for the map. Structure: high confidence, the inverse checked here. The condition of
stability is this project's.

The fit: weights, offset and map are the solution of one convex program, in which every creep operator brings along
the weight of the input that a stable inverse needs. Map, thresholds of creep and start state by blocks held out
within the training. There is no seed.

Cannot show
-----------
Loops that run clockwise (no weight is negative); an output that overshoots after a step; what happens between two
samples: an actuator faster than the sampling looks like a play; inertia.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from dehyst.errors import IdentificationError, ParameterError
from dehyst.families.base import UNSCALED, Scaling
from dehyst.families.convex import Rows, Weights, held_out, rows_of, solve
from dehyst.families.parallel import (
    CREEP,
    PLAY,
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
from dehyst.models.arrays import Array, parameter_array, parameter_number, strictly_increasing
from dehyst.models.card import NO_CARD

PLAYS = 24
DECADE = 3  # time constants a decade
CREEP_THRESHOLDS = (0.0, 0.1, 0.3)
MAP_PIECES = (0, 8, 20)
MARGIN = 1.5  # above what a stable inverse needs
SMALLEST = 0.02  # weight of the input itself: the inverse's gain after a reversal is at most 50


def _none() -> Array:
    return np.zeros(0)


@dataclass(frozen=True, repr=False, eq=False)
class CreepPrandtlIshlinskii(MappedModel):
    """Plays and creep operators in parallel, a monotone map behind them; the module says the formulas.

    Parameters
    ----------
    thresholds, weights
        r and w of the plays, (n,).
    creep_thresholds, time_constants, creep_weights
        s, T [s] and v of the creep operators, (m,), m may be 0.
    offset, map_inner, map_outer
        c, and T^-1 by its breakpoints.

    Raises
    ------
    ParameterError
        If sizes differ, a value is not finite, thresholds do not increase, or something is negative that must not be.

    Examples
    --------
    >>> model = CreepPrandtlIshlinskii(creep_thresholds=[0.0], time_constants=[1.0], creep_weights=[0.5])
    >>> y = model.simulate([0.0, 1.0, 1.0], [0.0, 1.0, 2.0])
    >>> y.round(4).tolist(), model.inverse().simulate(y, [0.0, 1.0, 2.0]).round(15).tolist()
    ([0.0, 1.0, 1.3161], [0.0, 1.0, 1.0])
    """

    thresholds: Array = field(default_factory=lambda: np.zeros(1))
    weights: Array = field(default_factory=lambda: np.ones(1))
    creep_thresholds: Array = field(default_factory=_none)
    time_constants: Array = field(default_factory=_none)
    creep_weights: Array = field(default_factory=_none)
    offset: float = 0.0
    map_inner: Array = field(default_factory=_none)
    map_outer: Array = field(default_factory=_none)
    period: float = 0.0
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = NO_CARD
    family: ClassVar[str] = "creep-pi"
    rate_dependent: ClassVar[bool] = True

    def __post_init__(self) -> None:
        put = object.__setattr__  # frozen: normalise once, here
        for name in ("thresholds", "weights"):
            put(self, name, parameter_array(getattr(self, name), name))
        for name in ("creep_thresholds", "time_constants", "creep_weights"):
            put(self, name, optional_array(getattr(self, name), name))
        same_size(self.thresholds, self.weights, ("thresholds", "weights"))
        for name in ("creep_thresholds", "creep_weights"):
            same_size(self.time_constants, getattr(self, name), ("time_constants", name))
        strictly_increasing(self.thresholds, "thresholds")
        for name in ("thresholds", "weights", "creep_thresholds", "creep_weights"):
            not_negative(getattr(self, name), name)
        if np.any(self.time_constants <= 0.0):
            raise ParameterError("a time constant is 0 or negative; creep takes time: pass seconds above 0.")
        put(self, "period", parameter_number(self.period, "period"))
        self._check_map()

    def make(self) -> Elements:
        """Plays, then creep."""
        return elements(
            (PLAY, self.weights, self.thresholds, 0.0),
            (CREEP, self.creep_weights, self.creep_thresholds, self.time_constants),
        )

    @property
    def free_parameters(self) -> int:
        """Weights that are not 0, offset, map."""
        return int(np.count_nonzero(self.weights) + np.count_nonzero(self.creep_weights)) + self._check_map()

    @property
    def no_inverse(self) -> str:
        """Without a part that follows the input at once nothing can be undone."""
        if self.thresholds[0] > 0.0 or self.weights[0] <= 0.0:
            return "no play of threshold 0 has weight, so the output does not move when the input has just turned."
        needed = float(np.sum(self.creep_weights * _early(self.period, self.time_constants)))
        if self.weights[0] <= needed:
            return (
                f"creep is too fast for samples every {self.period:g} s: undoing it step by step needs a weight of the "
                f"input itself above {needed:.3g}, and it has {self.weights[0]:.3g}; the inverse would oscillate."
            )
        return ""

    @classmethod
    def example(cls) -> CreepPrandtlIshlinskii:
        """Three plays and log(t) creep."""
        return cls(
            thresholds=np.array([0.0, 0.2, 0.5]),
            weights=np.array([0.4, 0.2, 0.2]),
            creep_thresholds=np.zeros(4),
            time_constants=np.array([0.1, 1.0, 10.0, 100.0]),
            creep_weights=np.full(4, 0.05),
        )


def _early(period: float, constants: Array) -> Array:
    """Weight of the input itself that a creep operator of weight 1 needs beside it for a stable inverse."""
    q = -np.expm1(-period / constants)
    return np.asarray(q / (2.0 - q))


def time_constants_of(training: Training) -> Array:
    """A geometric row from two samples to the length of the training, [s]."""
    least = 2.0 * period_of(training)
    most = max(float(s.time[-1]) for s in training.stretches)
    count = max(2, round(DECADE * np.log10(max(most / least, 10.0))) + 1)
    return np.geomspace(least, max(most, 10.0 * least), min(count, 16))


def period_of(training: Training) -> float:
    """Usual step of time, [s]."""
    return float(np.median(np.concatenate([s.dt[1:] for s in training.stretches if s.dt is not None])))


def fit(training: Training) -> CreepPrandtlIshlinskii:
    """Weights by the convex program; what is beside them by blocks held out within the training."""
    if not training.timed:
        raise IdentificationError(
            "creep takes time, but the recording has no time stamps. Name their column (--time), or take a family "
            "without time, such as pi."
        )
    if training.clockwise:
        raise IdentificationError(
            "the loops run clockwise (the output leads the input), and creep-pi has no negative weights: it can only "
            "lag. Take maxwell-slip, or swap input and output."
        )
    short, constants = training.thinned(), time_constants_of(training)
    best, chosen = np.inf, None
    for start in ("zero", "rest"):
        for wide in (1, len(CREEP_THRESHOLDS)):
            template = _template(training, constants, CREEP_THRESHOLDS[:wide], start)
            rows = _rows(short, template)
            for pieces in MAP_PIECES:
                error = held_out(rows, pieces)
                if error < 0.99 * best:
                    best, chosen = error, (template, pieces)
    assert chosen is not None
    template, pieces = chosen
    found = solve(_rows(training, template), pieces)
    return training.best_start(_model(template, found), ("zero", "rest", "rising", "falling", "origin"))


def _template(
    training: Training, constants: Array, creep_thresholds: tuple[float, ...], start: str
) -> CreepPrandtlIshlinskii:
    s, t = np.meshgrid(np.array(creep_thresholds), constants, indexing="ij")
    return CreepPrandtlIshlinskii(
        thresholds=(np.arange(PLAYS) / PLAYS) ** 1.5,
        weights=np.ones(PLAYS),
        creep_thresholds=s.ravel(),
        time_constants=t.ravel(),
        creep_weights=np.ones(s.size),
        period=period_of(training),
        scaling=training.scaling,
        start=start,
    )


def _rows(training: Training, template: CreepPrandtlIshlinskii) -> Rows:
    """Rows in which every creep operator brings the weight of the input itself that its inverse needs."""
    n = template.thresholds.size
    lower = np.zeros(template.parts.size)
    lower[0] = SMALLEST
    rows = rows_of(training, template, lower)
    rows.bounded[:, n:] += rows.bounded[:, :1] * _brought(template)
    return rows


def _brought(template: CreepPrandtlIshlinskii) -> Array:
    return MARGIN * _early(template.period, template.time_constants)


def _model(template: CreepPrandtlIshlinskii, found: Weights) -> CreepPrandtlIshlinskii:
    n = template.thresholds.size
    w, v = found.bounded[:n].copy(), found.bounded[n:]
    w[0] += float(_brought(template) @ v)
    plays, creeps = w > 0.0, v > 0.0
    return CreepPrandtlIshlinskii(
        template.thresholds[plays],
        w[plays],
        template.creep_thresholds[creeps],
        template.time_constants[creeps],
        v[creeps],
        found.offset,
        found.map_inner,
        found.map_outer,
        template.period,
        template.scaling,
        template.start,
    )


FAMILY = Family(
    "creep-pi", "Prandtl-Ishlinskii with creep", CreepPrandtlIshlinskii, fit, True, "Krejci and Kuhnen 2001"
)
