r"""Reads files of families that are sums of elements today: same parameters, same output.

Before they were rows, ``creep-pi``, ``rate-dependent-pi``, ``generalised-pi``, ``maxwell-slip`` and
``krasnoselskii-pokrovskii`` were records of their own. Where the formula of a file is a sum of elements, reading it
makes that sum. What no element does is kept here, to be played and inverted; it cannot be identified any more: creep
that acts with the time to the *next* sample, thresholds that grow with a low-passed rate, dampers over the true steps
of time, an envelope that is a tangent, a position over a force that begins in a state of the force::

    y    = T^-1(c + S g(x) + sum over i of w_i z_i + sum over m of g_m clip(x - p_m, -+ b_m)
           + sum over j of a_j clip((x - x') / h, -+ s_j) + sum over l of v_l q_l + b s)
    z_i  = clip(z_i, g(x) -+ (r_i + beta_i |s|));   a slider of stiffness k is S = k, w = -k
    q_l <- t + (q_l - t) exp(-h / tau_l), t = clip(q_l, x' -+ r_l), before the sample, x' the input of the one before
    s   <- s + (1 - exp(-h / lag)) ((x - x') / h - s), after the sample
    g(x) = a_0 tanh(a_1 x + a_2) + a_3
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.families.base import UNSCALED, LoopModel, Scaling
from dehyst.families.elements import Element, ElementModel
from dehyst.families.inversion import FARTHEST
from dehyst.models import ModelCard
from dehyst.models.arrays import parameter_array, parameter_number, strictly_increasing
from dehyst.models.card import NO_CARD

AHEAD = 2  # of the memory: the input of the sample before, the rate
DIGITS = 13  # of lines: what rounding alone tells apart are one
SATURATED = 1.0 - 1e-12
NONE = np.zeros(0)
RENAMED = {"play-creep": "creep-pi", "preisach-sum": "generalised-pi", "damper-sum": "maxwell-slip"}  # rows, in files


def model_of(name: str, values: dict[str, Any], scaling: Scaling, start: str) -> LoopModel:
    """Return the model of an old file's values: a sum of elements where its formula is one.

    Raises
    ------
    ParameterError
        If the values are none of such a model.
    """
    if name == KERNELS:
        return _kernels(values, scaling, start)
    formula = _FORMULAS[name](values)
    if formula.timed or formula.envelope.size or formula.solved:
        return FormerModel(name, values, scaling, start)
    if formula.sign < 0.0:
        scaling = replace(scaling, amplitude=-scaling.amplitude)
    return ElementModel(
        formula.elements(),
        formula.offset,
        before_map=(tuple(formula.points[0].tolist()), tuple(formula.points[1].tolist())),
        after_map=(tuple(formula.inner.tolist()), tuple(formula.outer.tolist())),
        row=name,
        scaling=scaling,
        start=start,
    )


@dataclass(frozen=True, eq=False)
class Formula:
    """The numbers of the module's formula.

    Attributes
    ----------
    slope, offset
        S, c.
    plays
        w, r, beta of each, (3, n).
    pieces, dampers, creeps
        g, b, p (3, m); a, s (2, l); v, r, tau (3, o).
    rate, lag
        b; time constant of s. [s]
    envelope, points
        a (4,) or empty; g by points (2, q), which the sum of elements knows.
    inner, outer
        T^-1 by its breakpoints; empty: none.
    period
        For which creep can be undone. [s]
    solved
        Whether the output is the x and the input the y.
    sign
        -1: the output is -y.
    """

    slope: float
    offset: float
    plays: Array
    pieces: Array = field(default_factory=lambda: np.zeros((3, 0)))
    dampers: Array = field(default_factory=lambda: np.zeros((2, 0)))
    creeps: Array = field(default_factory=lambda: np.zeros((3, 0)))
    rate: float = 0.0
    lag: float = 1.0
    envelope: Array = field(default_factory=lambda: NONE)
    points: Array = field(default_factory=lambda: np.zeros((2, 0)))
    inner: Array = field(default_factory=lambda: NONE)
    outer: Array = field(default_factory=lambda: NONE)
    period: float = 0.0
    solved: bool = False
    sign: float = 1.0

    @property
    def timed(self) -> bool:
        """Whether time acts."""
        return bool(self.creeps.size or self.dampers.size or self.rate or np.any(self.plays[2]))

    def elements(self) -> tuple[Element, ...]:
        """The sum of elements that is the formula, where neither time nor a tangent acts."""
        pieces = [
            Element("input", weight=g, map=((p - 2.0 * b, p - b, p + b, p + 2.0 * b), (-b, -b, b, b)))
            for g, b, p in self.pieces.T.tolist()
            if b > 0.0
        ]
        plays = [Element("play", r, weight=w) for w, r, _ in self.plays.T.tolist()]
        return (Element("input", weight=self.slope), *pieces, *plays)

    @property
    def direct(self) -> float:
        """Weight with which the sum follows x at once."""
        w, r, beta = self.plays
        return self.slope + float(np.sum(np.where((r == 0.0) & (beta == 0.0) | (w < 0.0), w, 0.0)))


@dataclass(frozen=True, repr=False, eq=False)
class FormerModel(LoopModel):
    """A model of an old file that no sum of elements is.

    Parameters
    ----------
    row
        Name of its family.
    values
        Its parameters, as the file has them.

    Raises
    ------
    ParameterError
        If they are none of that family.
    """

    row: str
    values: dict[str, Any]
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = NO_CARD

    def __post_init__(self) -> None:
        """Check by making the formula."""
        object.__setattr__(self, "family", self.row)
        object.__setattr__(self, "rate_dependent", self._formula.timed)
        object.__setattr__(self, "direction", "inverse" if self._formula.solved else "forward")

    @cached_property
    def _formula(self) -> Formula:
        return _FORMULAS[self.row](self.values)

    def parameters(self) -> dict[str, Any]:
        """Return the values, plain."""
        return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in self.values.items()}

    @property
    def free_parameters(self) -> int:
        """Weights that are not 0, offset, rate, map."""
        q = self._formula
        weights = [q.plays[0], q.pieces[0], q.creeps[0], q.dampers[0], np.array([q.slope, q.rate])]
        return 1 + sum(int(np.count_nonzero(w)) for w in weights) + q.envelope.size // 2 + max(0, q.inner.size - 3)

    @property
    def no_inverse(self) -> str:
        """Whether something follows at once, and outweighs what comes late."""
        q = self._formula
        if q.direct <= 0.0:
            return (
                "nothing of the output follows the input at once, so it does not move when the input has just turned."
            )
        gain = -np.expm1(-q.period / q.creeps[2])
        needed = float(np.sum(q.creeps[0] * gain / (2.0 - gain)))
        if q.direct <= needed:
            return (
                f"creep is too fast for samples every {q.period:g} s: undoing it step by step needs a weight of the "
                f"input itself above {needed:.3g}, and it has {q.direct:.3g}; the inverse would oscillate."
            )
        weight, _, growth = q.plays
        if not q.rate and not np.any(growth):
            return ""
        late = np.abs(np.concatenate([[0.0], np.cumsum(weight * growth)]) - q.rate)
        delay = float(np.max(late / (q.slope + np.concatenate([[0.0], np.cumsum(weight)]))))
        if delay >= q.lag:
            return (
                f"the rate delays the output by up to {delay:.3g} s, and it is known with a lag of only {q.lag:.3g} s: "
                f"undoing it sample by sample would oscillate."
            )
        return ""

    def rest(self, x: float) -> Array:
        """Plays and creep at x, sliders without deflection."""
        q = self._formula
        at = float(self._seen(np.array([x]))[0])
        if q.solved:
            still = replace(q, plays=np.zeros((3, 0)), dampers=np.zeros((2, 0)), slope=q.direct)
            at = _solved(at - q.offset, *_clipped(still, 0.0, 0.0, np.zeros(AHEAD)))
        states = np.full(q.plays.shape[1] + q.creeps.shape[1], at)
        return np.concatenate([[at, 0.0], states])

    def run(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Evaluate the formula; solve it where it was identified the other way round."""
        return self._backward(x, dt, memory) if self._formula.solved else self._forward(x, dt, memory)

    def run_inverse(self, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """The other way round, exactly: the formula is piecewise linear in the present sample."""
        return self._forward(y, dt, memory) if self._formula.solved else self._backward(y, dt, memory)

    def _forward(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        q, memory, u = self._formula, memory.copy(), np.empty(x.size)
        for k, (at, h) in enumerate(zip(self._seen(x).tolist(), _steps(dt, x.size), strict=True)):
            _creep(q, h, memory)
            constant, slope, weight, origin, reach = _clipped(q, h, memory[0], memory)
            u[k] = constant + slope * at + np.clip(at - origin, -reach, reach) @ weight
            _moved(q, at, h, memory)
        u = q.sign * (q.offset + u)
        return (_native.map_values(q.inner, q.outer, u) if q.inner.size else u), memory

    def _backward(self, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        q, memory, x = self._formula, memory.copy(), np.empty(y.size)
        u = q.sign * (_native.map_values(q.outer, q.inner, y) if q.inner.size else y) - q.offset
        for k, (wanted, h) in enumerate(zip(u.tolist(), _steps(dt, y.size), strict=True)):
            _creep(q, h, memory)
            x[k] = _solved(wanted, *_clipped(q, h, memory[0], memory))
            _moved(q, x[k], h, memory)
        return self._unseen(x), memory

    def _seen(self, x: Array) -> Array:
        a = self._formula.envelope
        return np.asarray(a[0] * np.tanh(a[1] * x + a[2]) + a[3]) if a.size else x

    def _unseen(self, g: Array) -> Array:
        """The x at which the envelope is g; of values that no x reaches, the farthest x that numbers tell apart."""
        a = self._formula.envelope
        if not a.size:
            return g
        return np.asarray((np.arctanh(np.clip((g - a[3]) / a[0], -SATURATED, SATURATED)) - a[2]) / a[1])


def _steps(dt: Array | None, size: int) -> list[float]:
    return [0.0] * size if dt is None else dt.tolist()


def _creep(q: Formula, h: float, memory: Array) -> None:
    if h > 0.0 and q.creeps.size:
        _, radius, time = q.creeps
        state = memory[-time.size :]
        target = np.clip(state, memory[0] - radius, memory[0] + radius)
        state[:] = target + (state - target) * np.exp(-h / time)


def _clipped(q: Formula, h: float, before: float, memory: Array) -> tuple[float, float, Array, Array, Array]:
    """Return the parts of constant + slope x + sum of weight clip(x - origin, -+ reach), in this order."""
    plays, (creep, *_) = q.plays, q.creeps
    z = memory[AHEAD : AHEAD + plays.shape[1]]
    constant = float(creep @ memory[memory.size - creep.size :]) + q.rate * float(memory[1])
    parts = [(-plays[0], z, plays[1] + plays[2] * abs(memory[1])), (q.pieces[0], q.pieces[2], q.pieces[1])]
    if h > 0.0:
        parts.append((q.dampers[0] / h, np.full(q.dampers.shape[1], before), q.dampers[1] * h))
    weight, origin, reach = (np.concatenate(each) for each in zip(*parts, strict=True))
    return constant, q.slope + float(plays[0].sum()), weight, origin, reach


def _solved(u: float, constant: float, slope: float, weight: Array, origin: Array, reach: Array) -> float:
    """The x at which such a sum, which rises, is u; within the reach of all families."""
    ends = np.concatenate([origin - reach, origin + reach])
    knots = np.unique(np.concatenate([ends[np.isfinite(ends)], [-FARTHEST, FARTHEST]]).clip(-FARTHEST, FARTHEST))
    values = constant + slope * knots + np.clip(knots[:, None] - origin, -reach, reach) @ weight
    return float(np.interp(u, values, knots))


def _moved(q: Formula, x: float, h: float, memory: Array) -> None:
    _, radius, growth = q.plays
    state, now = memory[AHEAD : AHEAD + radius.size], radius + growth * abs(memory[1])
    state[:] = np.clip(state, x - now, x + now)
    if h > 0.0:
        memory[1] += -np.expm1(-h / q.lag) * ((x - memory[0]) / h - memory[1])
    memory[0] = x


def _together(values: dict[str, Any], *names: str) -> Array:
    """Arrays of one size, none negative, as rows; the last may hold any numbers if its name ends in "places"."""
    rows = [np.zeros(0) if not np.size(values[name]) else parameter_array(values[name], name) for name in names]
    if len({row.size for row in rows}) > 1:
        raise ParameterError(
            f"{', '.join(names)} have {', '.join(str(row.size) for row in rows)} values; as many each."
        )
    for name, row in zip(names, rows, strict=True):
        if not name.endswith("places") and np.any(row < 0.0):
            raise ParameterError(f"{name} holds {row.min():g}; values are from 0 on.")
    return np.stack(rows)


def _mapped(values: dict[str, Any]) -> tuple[Array, Array]:
    inner, outer = (np.asarray(values[name], dtype=np.float64) for name in ("map_inner", "map_outer"))
    if inner.size != outer.size or inner.size == 1:
        raise ParameterError(f"the map has {inner.size} sums and {outer.size} outputs; pairs are needed, two or more.")
    for name, row in (("map_inner", inner), ("map_outer", outer)):
        strictly_increasing(row, name)
    return inner, outer


def _known(values: dict[str, Any], *names: str) -> None:
    if set(values) != set(names):
        raise ParameterError(f"its parameters are {list(values)!s:.120}, not {sorted(names)}.")


def _creep_pi(values: dict[str, Any]) -> Formula:
    _known(
        values, "thresholds", "weights", "creep_thresholds", "time_constants", "creep_weights", "offset", "map_inner",
        "map_outer", "period",
    )  # fmt: skip
    plays = _together(values, "weights", "thresholds")
    creeps = _together(values, "creep_weights", "creep_thresholds", "time_constants")
    if np.any(creeps[2] <= 0.0):
        raise ParameterError("a time constant is 0; creep takes time.")
    inner, outer = _mapped(values)
    return Formula(
        0.0,
        parameter_number(values["offset"], "offset"),
        np.vstack([plays, np.zeros(plays.shape[1])]),
        creeps=creeps,
        period=parameter_number(values["period"], "period"),
        inner=inner,
        outer=outer,
    )


def _rate_dependent_pi(values: dict[str, Any]) -> Formula:
    _known(
        values, "direct", "thresholds", "growths", "weights", "rate_weight", "lag", "offset", "map_inner", "map_outer"
    )
    direct, rate, lag, offset = (parameter_number(values[n], n) for n in ("direct", "rate_weight", "lag", "offset"))
    if lag <= 0.0:
        raise ParameterError(f"lag = {lag:g} s is not above 0; a rate needs time to be known.")
    plays = _together(values, "weights", "thresholds", "growths")
    inner, outer = _mapped(values)
    return Formula(direct, offset, plays, rate=rate, lag=lag, inner=inner, outer=outer)


def _generalised_pi(values: dict[str, Any]) -> Formula:
    _known(values, "direct", "thresholds", "weights", "shape", "points_x", "points_g", "offset")
    direct, offset = (parameter_number(values[name], name) for name in ("direct", "offset"))
    plays = _together(values, "weights", "thresholds")
    shape = np.asarray(values["shape"], dtype=np.float64)
    points = np.stack([np.asarray(values[name], dtype=np.float64) for name in ("points_x", "points_g")])
    if shape.size not in (0, 4) or (shape.size and (min(shape[:2]) <= 0.0 or points.size)):
        raise ParameterError("an envelope is a tangent (a0, a1, a2, a3), a0 > 0 and a1 > 0, or points, or neither.")
    return Formula(direct, offset, np.vstack([plays, np.zeros(plays.shape[1])]), envelope=shape, points=points)


def _maxwell_slip(values: dict[str, Any]) -> Formula:
    _known(
        values, "stiffness", "spring_places", "spring_widths", "spring_stiffnesses", "thresholds", "stiffnesses",
        "speeds", "dampings", "offset", "position", "falling",
    )  # fmt: skip
    stiffness, offset = (parameter_number(values[name], name) for name in ("stiffness", "offset"))
    if stiffness < 0.0 or not all(isinstance(values[name], bool) for name in ("position", "falling")):
        raise ParameterError(f"stiffness = {stiffness:g} is negative, or position and falling are not true or false.")
    k, d = _together(values, "stiffnesses", "thresholds")
    dampings, speeds = _together(values, "dampings", "speeds")
    return Formula(
        stiffness + float(np.sum(k)),
        offset,
        np.stack([-k, d, np.zeros(k.size)]),
        _together(values, "spring_stiffnesses", "spring_widths", "spring_places"),
        np.stack([dampings, np.where(speeds > 0.0, speeds, np.inf)]),
        solved=values["position"],
        sign=-1.0 if values["falling"] else 1.0,
    )


_FORMULAS = {
    "creep-pi": _creep_pi,
    "rate-dependent-pi": _rate_dependent_pi,
    "generalised-pi": _generalised_pi,
    "maxwell-slip": _maxwell_slip,
}
KERNELS = "krasnoselskii-pokrovskii"
NAMES = (*_FORMULAS, KERNELS)


def _kernels(values: dict[str, Any], scaling: Scaling, start: str) -> ElementModel:
    """Kernels between two ridges are generalised plays: a ridge function of the play of half their distance.

    max(r(x - rho_i), min(r(x - rho_j), z)) = r(p - m), p the play of radius (rho_i - rho_j)/2, m the middle of both.
    Beyond the ridges the output goes on with the mean slope of the largest loop.
    """
    _known(values, "lines", "ridge", "weights", "offset")
    lines, weights = (parameter_array(values[name], name) for name in ("lines", "weights"))
    ridge, offset = (parameter_number(values[name], name) for name in ("ridge", "offset"))
    if np.any(np.diff(lines) <= 0.0) or weights.size != lines.size * (lines.size + 1) // 2 or ridge <= 0.0:
        raise ParameterError(
            f"{lines.size} lines, {weights.size} weights and a ridge of {ridge:g} do not belong together: n increasing "
            f"lines have n (n + 1)/2 weights and a ridge above 0."
        )
    i, j = np.tril_indices(lines.size)
    radii, low = ((0.5 * (lines[i] + sign * lines[j])).round(DIGITS) for sign in (-1.0, 1.0))
    first, last = float(lines[0]), float(lines[-1]) + ridge
    elements = []
    for radius in np.unique(radii):
        own = radii == radius
        knots = np.unique(np.concatenate([low[own], low[own] + ridge]).round(DIGITS))
        u = np.concatenate([[knots[0] - 1.0], knots, [knots[-1] + 1.0]])
        v = np.clip(2.0 * (u[:, None] - low[own]) / ridge - 1.0, -1.0, 1.0) @ weights[own]
        elements.append(Element("play", float(radius), map=(tuple(u.tolist()), tuple(v.tolist()))))
    slope = 2.0 * float(np.sum(weights)) / (last - first)
    outside = ((first - 1.0, first, last, last + 1.0), (-slope, 0.0, 0.0, slope))
    return ElementModel((Element("input", map=outside), *elements), offset, row=KERNELS, scaling=scaling, start=start)
