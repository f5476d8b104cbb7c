r"""Springs with Coulomb sliders in parallel: the friction of Iwan, and of pneumatic muscles.

The force f over a position q of an elastic spring, which may stiffen, beside sliders that slip at a deflection d::

    f = c + k_0 q + sum over m of g_m clip(q - p_m, -+ b_m) + sum over i of k_i e_i
    e_i,k = clip(e_i,k-1 + q_k - q_{k-1}, -+ d_i)                                  force W_i = k_i d_i when it slips

Curves after a reversal are the virgin curve doubled (Masing). With time stamps dampers may stand beside the sliders,
a rising law of the speed by its pieces: one without end is viscous, one that saturates soon is Coulomb friction with
a soft start::

    f = ... + sum over j of a_j clip(q', -+ s_j),    q'_k = (q_k - q_{k-1}) / h_k

The force leads the position, so loops run clockwise. Loops that run counter-clockwise are those of a position over a
force; then the input is the force, the output is the q that solves the equation (``position``), and without dampers
and pieces this is a Prandtl-Ishlinskii operator, the exact inverse of the stop form above.

============================  ====================================================  =============  =====================
parameter                     meaning                                               unit           source
============================  ====================================================  =============  =====================
``stiffness``                 k_0 > 0, elastic; the slope beyond all pieces         scaled         identified, convex
``spring_places``             p_m, middle of a piece of a stiffening spring         half ranges    grid
``spring_widths``             b_m, half its width                                   half ranges    grid
``spring_stiffnesses``        g_m, from 0 on                                        scaled         identified, convex
``thresholds``                d_i                                                   half ranges    grid, 0 to 1
``stiffnesses``               k_i, from 0 on                                        scaled         identified, convex
``speeds``                    s_j at which a damper saturates; 0 stands for never   half ranges/s  grid of the log
``dampings``                  a_j, from 0 on                                        s              identified, convex
``offset``                    c                                                     scaled         identified, convex
``position``                  whether the output is the position                    -              the smaller error
``falling``                   whether the output is -f: the curve of the log falls  -              the smaller error
============================  ====================================================  =============  =====================

Source: W. D. Iwan, A distributed-element model for hysteresis and its steady-state dynamic response, J. Appl. Mech.
33, 1966; T. Vo-Minh, T. Tjahjowidodo, H. Ramon and H. Van Brussel, A new approach to modeling hysteresis in a
pneumatic artificial muscle using the Maxwell-slip model, IEEE/ASME Trans. Mechatronics 16, 2011. Structure: high
confidence. The pieces of spring and dampers are this project's.

The fit: all stiffnesses and dampings are the solution of one convex program. Whether there are dampers and pieces is
decided by blocks held out within the training. For a position the program's errors are weighted by how much the
mechanism gives way, so that they are errors of the position one sample ahead; a few Gauss-Newton steps on the simulated
position follow where they hold on blocks that they did not see. There is no seed.

Cannot show
-----------
Branches that differ other than by the spring; creep under a held input; friction that falls with the speed
(Stribeck); inertia.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import least_squares

from dehyst.errors import ParameterError
from dehyst.families.base import UNSCALED, Scaling
from dehyst.families.convex import FOLDS, Rows, folds_of, held_out, rows_of, solve
from dehyst.families.parallel import (
    DAMPER,
    PIECE,
    STOP,
    Elements,
    ParallelModel,
    elements,
    not_negative,
    optional_array,
    same_size,
)
from dehyst.families.registry import Family
from dehyst.families.training import Stretch, Training
from dehyst.models import ModelCard
from dehyst.models.arrays import Array, parameter_number
from dehyst.models.card import NO_CARD

SLIDERS = 24
DAMPERS = 10
SPRING_PIECES = (0, 8)
SMALLEST, SMALLEST_POSITION = 0.001, 0.05  # of the elastic spring: position and force determine each other
ARRAYS = (
    "spring_places", "spring_widths", "spring_stiffnesses", "thresholds", "stiffnesses", "speeds", "dampings",
)  # fmt: skip
REWEIGHTED = 2
POLISHED, STEPS = 1500, 10  # samples that a polish looks at, and its steps
FARTHEST, HELD = 3.0, 0.02  # how far a polish may go, of the logarithm, and what going there costs


def _none() -> Array:
    return np.zeros(0)


@dataclass(frozen=True, repr=False, eq=False)
class MaxwellSlip(ParallelModel):
    """Springs with sliders, and dampers where there are any; the module says the formulas.

    A model with dampers depends on the speed and needs time stamps (``rate_dependent``), one without does not.

    Parameters
    ----------
    stiffness
        k_0 > 0.
    spring_places, spring_widths, spring_stiffnesses
        p, b and g of the pieces of the spring, (m,), m may be 0.
    thresholds, stiffnesses
        d and k of the sliders, (n,).
    speeds, dampings
        s [1/s], 0 for a damper that does not saturate, and a [s] of the dampers, (l,), l may be 0.
    offset
        c.
    position
        Whether the output is the position and the input the force.
    falling
        Whether the output is the force with the other sign.

    Raises
    ------
    ParameterError
        If sizes differ, a value is not finite, or one is negative that must not be.

    Examples
    --------
    >>> MaxwellSlip(stiffness=1.0, thresholds=[0.5], stiffnesses=[2.0]).simulate([0.0, 0.25, 1.0, 0.0]).tolist()
    [0.0, 0.75, 2.0, -1.0]
    >>> MaxwellSlip(speeds=[0.0], dampings=[0.5]).simulate([0.0, 1.0, 1.0], [0.0, 1.0, 2.0]).tolist()
    [0.0, 1.5, 1.0]
    """

    stiffness: float = 1.0
    spring_places: Array = field(default_factory=_none)
    spring_widths: Array = field(default_factory=_none)
    spring_stiffnesses: Array = field(default_factory=_none)
    thresholds: Array = field(default_factory=_none)
    stiffnesses: Array = field(default_factory=_none)
    speeds: Array = field(default_factory=_none)
    dampings: Array = field(default_factory=_none)
    offset: float = 0.0
    position: bool = False
    falling: bool = False
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = NO_CARD
    family: ClassVar[str] = "maxwell-slip"

    def __post_init__(self) -> None:
        put = object.__setattr__  # frozen: normalise once, here
        for name in ("stiffness", "offset"):
            put(self, name, parameter_number(getattr(self, name), name))
        for name in ARRAYS:
            put(self, name, optional_array(getattr(self, name), name))
        if not isinstance(self.position, bool | np.bool_):
            raise ParameterError(f"position is a {type(self.position).__name__}; say True or False.")
        same_size(self.thresholds, self.stiffnesses, ("thresholds", "stiffnesses"))
        same_size(self.speeds, self.dampings, ("speeds", "dampings"))
        for name in ("spring_widths", "spring_stiffnesses"):
            same_size(self.spring_places, getattr(self, name), ("spring_places", name))
        for name in ("spring_widths", "spring_stiffnesses", "thresholds", "stiffnesses", "speeds", "dampings"):
            not_negative(getattr(self, name), name)
        if self.stiffness < 0.0:
            raise ParameterError(f"stiffness = {self.stiffness:g} is negative; an elastic spring pushes back.")
        if self.falling and self.position:
            raise ParameterError("a falling position is not known; give the force the other sign.")
        put(self, "rate_dependent", bool(self.speeds.size))

    def make(self) -> Elements:
        """Pieces of the spring, then sliders, then dampers."""
        return elements(
            (PIECE, self.spring_stiffnesses, self.spring_widths, self.spring_places),
            (STOP, self.stiffnesses, self.thresholds, 0.0),
            (DAMPER, self.dampings, np.where(self.speeds > 0.0, self.speeds, np.inf), 0.0),
            slope=self.stiffness,
        )

    @cached_property
    def _elastic(self) -> Elements:
        return self.parts.weighted(np.where(self.parts.kind == PIECE, self.parts.weight, 0.0))

    def rest(self, x: float) -> Array:
        """Sliders without deflection; where the output is the position, that of the spring under this force."""
        if not self.position:
            return self.parts.rest(x)
        at = self._elastic.invert(np.array([x - self.offset]), None, self.parts.rest(0.0))[0]
        return self.parts.rest(float(at[0]))

    def run(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Force for a position, or position for a force."""
        return self._position(x, dt, memory) if self.position else self._force(x, dt, memory)

    def run_inverse(self, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """The other way round."""
        return self._force(y, dt, memory) if self.position else self._position(y, dt, memory)

    def _force(self, q: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        u, after = self.parts.run(q, dt, memory)
        return (-1.0 if self.falling else 1.0) * (self.offset + u), after

    def _position(self, force: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        return self.parts.invert(force - self.offset, dt, memory)

    @property
    def free_parameters(self) -> int:
        """Offset, stiffness, pieces, sliders and dampers that are not 0."""
        return 2 + int(np.count_nonzero(self.parts.weight))

    @property
    def no_inverse(self) -> str:
        """With an elastic spring the force strictly follows the position."""
        if self.falling:
            return (
                "the curve of the log falls, but the force rises after every turn: give the log's force the other sign."
            )
        return "" if self.stiffness > 0.0 else "the elastic spring has no stiffness, so many positions bear one force."

    @classmethod
    def example(cls) -> MaxwellSlip:
        """Three sliders."""
        return cls(stiffness=0.3, thresholds=np.array([0.05, 0.2, 0.5]), stiffnesses=np.array([2.0, 1.0, 0.5]))


def fit(training: Training) -> MaxwellSlip:
    """All stiffnesses by one convex program; what is beside them by blocks held out within the training.

    Unless the loops run clockwise the force may be what was applied and the position what was measured, or the log may
    hold the force of a wide loop whose curve seems to fall: all are fitted, and the smallest error of the simulated
    output decides.
    """
    if training.clockwise:
        return _fit(training, False)
    other = replace(training, stretches=tuple(replace(s, y=-s.y) for s in training.stretches))
    return training.best([_fit(training, True), _fit(training, False), replace(_fit(other, False), falling=True)])


def _fit(training: Training, position: bool) -> MaxwellSlip:
    if position:
        return training.best_start(_fitted_position(training))
    short, templates = training.thinned(), _templates(training)
    errors = [held_out(_rows(short, template, False)) for template in templates]
    chosen = templates[_first_good(errors)]
    return training.best_start(_solved(_rows(training, chosen, False), chosen, training.scaling, False))


def _fitted_position(training: Training) -> MaxwellSlip:
    """What the program finds, polished: its error is that of one sample ahead, what counts is the simulated one."""
    few, kinds = training.thinned(POLISHED), itertools.groupby(_templates(_swapped(training)), _kind)
    models = [_simulated_best(training, list(templates)) for _, templates in kinds]
    fitted, rest = _last_held_out(few)
    if not rest.y.size:  # a handful of samples
        return few.best(models)
    candidates = [(model, _polished(fitted, model)) for model in models]
    errors = [np.hypot(few.rms(model), rest.rms(model)) for pair in candidates for model in pair]
    number = _first_good(errors)
    chosen = models[number // 2]
    return _polished(few, chosen) if number % 2 else chosen


def _kind(template: MaxwellSlip) -> tuple[int, int]:
    return template.speeds.size, template.spring_places.size


def _simulated_best(training: Training, templates: list[MaxwellSlip]) -> MaxwellSlip:
    """From all samples or from fewer: noise in the rate pulls dampers down, and longer steps have less of it."""
    seen, few, models = _swapped(training), training.thinned(POLISHED), []
    for template in templates:
        for samples in {part.samples: part for part in (seen, seen.thinned(), seen.thinned(POLISHED))}.values():
            models.append(_solved(_rows(samples, template, True), template, training.scaling, True))
    return few.best([few.best_start(model) for model in models])


def _last_held_out(training: Training) -> tuple[Training, Training]:
    """The training with its last blocks only moving the memory, and with these alone counted."""
    last, at = folds_of(training) == FOLDS - 1, 0
    parts: tuple[list[Stretch], list[Stretch]] = ([], [])
    for s in training.stretches:
        held = np.zeros(s.counts.size, dtype=np.bool_)
        count = int(np.count_nonzero(s.counts))
        held[s.counts] = last[at : at + count]
        at += count
        parts[0].append(replace(s, counts=s.counts & ~held))
        parts[1].append(replace(s, counts=held))
    return replace(training, stretches=tuple(parts[0])), replace(training, stretches=tuple(parts[1]))


def _polished(training: Training, model: MaxwellSlip) -> MaxwellSlip:
    """The same elements with stiffnesses that lessen the error of the simulated position, from the program's on."""
    names = ("spring_stiffnesses", "stiffnesses", "dampings")
    ends = np.cumsum([1, *(getattr(model, name).size for name in names)])
    first = np.log(np.concatenate([[model.stiffness], *(getattr(model, name) for name in names)]))

    def moved(u: Array) -> MaxwellSlip:
        parts = np.split(np.exp(first + np.clip(u[1:], -FARTHEST, FARTHEST)), ends)
        changed: dict[str, Any] = dict(zip(names, parts[1:], strict=False))
        stiffness = max(float(parts[0][0]), SMALLEST_POSITION)
        return replace(model, offset=model.offset + float(u[0]), stiffness=stiffness, **changed)

    def miss(u: Array) -> Array:
        residual = training.residual(moved(u))
        return np.concatenate([np.nan_to_num(residual, nan=10.0), HELD * np.sqrt(residual.size) * rms * u])

    rms = training.rms(model)
    found = least_squares(miss, np.zeros(first.size + 1), diff_step=1e-4, max_nfev=STEPS)
    return training.best([model, moved(found.x)])


def _first_good(errors: list[float]) -> int:
    """The first one that no later one betters by more than 1 %: the simpler ones come first."""
    best = 0
    for number, error in enumerate(errors):
        if error < 0.99 * errors[best]:
            best = number
    return best


def _templates(training: Training) -> list[MaxwellSlip]:
    every = itertools.product((False, True) if training.timed else (False,), SPRING_PIECES, ("zero", "rest"))
    return [_template(training, dampers, pieces, start) for dampers, pieces, start in every]


def _swapped(training: Training) -> Training:
    """Training whose input is the position: the measured output."""
    stretches = tuple(Stretch(s.y, s.x, s.dt, s.counts) for s in training.stretches)
    return Training(stretches, training.scaling, training.orientation, training.seed)


def _template(training: Training, dampers: bool, pieces: int, start: str) -> MaxwellSlip:
    edges = np.linspace(-1.0, 1.0, pieces + 1)
    common: dict[str, Any] = {
        "spring_places": 0.5 * (edges[1:] + edges[:-1]),
        "spring_widths": 0.5 * np.diff(edges),
        "spring_stiffnesses": np.ones(pieces),
        "thresholds": ((1.0 + np.arange(SLIDERS)) / SLIDERS) ** 2,
        "stiffnesses": np.ones(SLIDERS),
        "start": start,
    }
    if not dampers:
        return MaxwellSlip(**common)
    rates = np.concatenate([np.diff(s.x) / s.dt[1:] for s in training.stretches if s.dt is not None])
    fastest = float(np.quantile(np.abs(rates), 0.99))
    speeds = np.concatenate([[0.0], np.geomspace(0.01, 0.7, DAMPERS - 1) * fastest])
    return MaxwellSlip(**common, speeds=speeds, dampings=np.ones(DAMPERS))


def _rows(training: Training, template: MaxwellSlip, position: bool) -> Rows:
    """Rows of the elements, and the input itself in front; as errors of the position where that is the output."""
    smallest = SMALLEST_POSITION if position else SMALLEST
    found = rows_of(training, template, np.zeros(template.parts.size))
    x = np.concatenate([s.x[s.counts] for s in training.stretches])
    bounded, lower = np.column_stack([x, found.bounded]), np.concatenate([[smallest], found.lower])
    rows = Rows(found.free, bounded, found.y, folds_of(training), lower)
    if not position:
        return rows
    soft = _softness(training, template, rows)
    for _ in range(REWEIGHTED):
        soft = _softness(training, template, replace(rows, weight=soft))
    return replace(rows, weight=soft)


def _softness(training: Training, template: MaxwellSlip, rows: Rows) -> Array:
    """How much the position gives way to a force, (K,): 1 over the stiffness of what does not slip."""
    found, parts = solve(rows).bounded, template.parts
    stuck = np.abs(rows.bounded[:, 1:]) < parts.radius * (1.0 - 1e-9)
    weight = found[1:] * stuck
    damper = parts.kind == DAMPER
    if np.any(damper):
        steps = np.concatenate([s.dt[s.counts] for s in training.stretches if s.dt is not None])
        weight[:, damper] /= np.where(steps > 0.0, steps, np.inf)[:, None]
    return np.asarray(1.0 / (found[0] + np.sum(weight, axis=1)))


def _solved(rows: Rows, template: MaxwellSlip, scaling: Scaling, position: bool) -> MaxwellSlip:
    found = solve(rows)
    pieces, sliders = template.spring_places.size, template.thresholds.size
    g, k, a = np.split(found.bounded[1:], [pieces, pieces + sliders])
    common: dict[str, Any] = {
        "stiffness": float(found.bounded[0]),
        "spring_places": template.spring_places[g > 0.0],
        "spring_widths": template.spring_widths[g > 0.0],
        "spring_stiffnesses": g[g > 0.0],
        "thresholds": template.thresholds[k > 0.0],
        "stiffnesses": k[k > 0.0],
        "speeds": template.speeds[a > 0.0],
        "dampings": a[a > 0.0],
        "offset": found.offset,
        "position": position,
        "scaling": scaling,
        "start": template.start,
    }
    return MaxwellSlip(**common)


FAMILY = Family("maxwell-slip", "Maxwell slip", MaxwellSlip, fit, True, "Iwan 1966; Vo-Minh and others 2011")
