r"""Sums of elements (plays, stops, creep, ...): one parameter record for all such families, run by the core.

A row of the grammar names elements, maps and a direction; the record holds their numbers::

    T(y) = c + sum over k of h_k w_k f_k(e_k),   x = M(u)

===========  =============================================================================================  ============
kind         element e, memory z, present input x                                                         slope with x
===========  =============================================================================================  ============
``input``    e = x                                                                                        1
``play``     e = z <- max(x - r, min(x + r, z))                                                           0 or 1
``stop``     e = x - z, z as play                                                                         0 or 1
``creep``    e = z <- z + g (t - z), t = max(x - r, min(x + r, z)), g = 1 - exp(-h / time)                0 to g
``relax``    e = x - z of the sample before, then z as creep; time 0, r = 0: the rate                     1
``past``     e = z of the sample before, then z as creep                                                  0
``path``     e = z <- s r + exp(-|x - x'| / r) (z - s r), s the sign of x - x'                            0 to 2
``wide``     e = z <- play of radius r + (time / h) |x - x'|, time / h <= 15/16                           0 to 2
``product``  e = z z+ of the sample before, both within -r .. r, then z as past; z+ of the next element   0
===========  =============================================================================================  ============

h is the time since the sample before, x' its input. f is a piecewise linear map of any slopes; M and T are increasing.
A product is followed by a ``past`` or another product: sums of products are Volterra's second order of what lags.
Since no element falls with x while its memory stands, the sum rises with x for any memory if its least slope is above
0 (`dehyst.families.rising`); then the inverse is exact, sample by sample, for every row.

Source: M. Brokate and J. Sprekels, Hysteresis and Phase Transitions, 1996, for sums of maps of plays; P. R. Dahl,
1968, for the path; P. Krejci and K. Kuhnen, 2001, for creep. The sum of all, its certificate and its inverse are this
project's (docs/decisions/0042-one-machine-of-elements.md).

Cannot show
-----------
Inertia, memory of the sign of the speed beyond these elements, drift without cause.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, dataclass, fields, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.families.base import PRELUDE, UNSCALED, LoopModel, Scaling
from dehyst.families.element_machine import element_machine
from dehyst.families.inversion import FARTHEST, first_input
from dehyst.families.rising import LEAST_SLOPE, least_slope, most_slope
from dehyst.models import ModelCard, SignalCard
from dehyst.models.arrays import parameter_array, parameter_number, strictly_increasing
from dehyst.models.card import NO_CARD
from dehyst.models.machine import Direction, Machine

KINDS = _native.ELEMENT_KINDS
DIRECTIONS = ("forward", "inverse")
LAGS = ("creep", "relax", "past", "product")
SQUARE = 17  # points
MIDDLE = 1e12  # of a range so wide that what is scaled is in its middle
AHEAD = 2  # numbers of the memory in front of the elements: the input of the sample before, and its step

Pairs = tuple[tuple[float, ...], tuple[float, ...]]
NO_MAP: Pairs = ((), ())
# What elements become where their lags have caught up, and where nothing is remembered at all; "": they add nothing.
CAUGHT_UP = {"creep": "play", "wide": "play", "past": "input", "relax": ""}
MEMORYLESS = {"creep": "input", "wide": "input", "past": "input", "relax": "", "play": "input", "stop": "", "path": ""}


@dataclass(frozen=True)
class Element:
    """One element: w f(e).

    Attributes
    ----------
    kind
        One of `KINDS`.
    radius
        r of the table, from 0 on; of a path above 0. [half ranges]
    time
        Time constant; of ``wide`` how long the radius grows at the speed of the input. [s]
    weight
        w.
    map
        f: arguments, increasing, and values; none: f(e) = e.
    schedule
        0: h = 1; 2 v + 1: the share 1 - xi of schedule v; 2 v + 2: xi.

    Raises
    ------
    ParameterError
        If something is no number, negative that must not be, or no map.
    """

    kind: str
    radius: float = 0.0
    time: float = 0.0
    weight: float = 1.0
    map: Pairs = NO_MAP
    schedule: int = 0

    def __post_init__(self) -> None:
        """Normalise; refuse what is no element."""
        put = object.__setattr__
        if self.kind not in KINDS:
            raise ParameterError(f"an element is of the kind {self.kind!r:.40}; the kinds are {', '.join(KINDS)}.")
        for name in ("radius", "time", "weight"):
            put(self, name, parameter_number(getattr(self, name), f"{name} of an element"))
        if self.radius < 0.0 or self.time < 0.0 or (self.kind == "path" and self.radius == 0.0):
            raise ParameterError(
                f"a {self.kind} has radius {self.radius:g} and time {self.time:g}; pass values from 0 on, a path's "
                f"radius above 0."
            )
        if type(self.schedule) is not int:
            raise ParameterError(
                f"the schedule of an element is {self.schedule!r:.40}; pass the number of a share, 0 on."
            )
        put(self, "map", pairs_of(self.map, "the map of an element"))

    @property
    def timed(self) -> bool:
        """Whether its step depends on time."""
        return self.time > 0.0 and self.kind in (*LAGS, "wide")


def pairs_of(given: Any, name: str, rising: bool = False) -> Pairs:
    """Return arguments and values of a map as tuples, both empty for none.

    Raises
    ------
    ParameterError
        If sizes differ, there is one point alone, or arguments (values too, if `rising`) do not increase.
    """
    try:
        arguments, values = given
        empty = not len(arguments) and not len(values)
    except (TypeError, ValueError):
        raise ParameterError(f"{name} is {given!r:.60}; pass two lists, arguments and values.") from None
    if empty:
        return NO_MAP
    u, v = parameter_array(arguments, f"arguments of {name}"), parameter_array(values, f"values of {name}")
    if u.size != v.size or u.size < 2:
        raise ParameterError(f"{name} has {u.size} arguments and {v.size} values; pass as many of both, two or more.")
    strictly_increasing(u, f"arguments of {name}")
    if rising:
        strictly_increasing(v, f"values of {name}")
    return tuple(u.tolist()), tuple(v.tolist())


@dataclass(frozen=True, repr=False, eq=False)
class ElementModel(LoopModel):
    """A sum of elements; the module says the formulas.

    Parameters
    ----------
    elements
        Of the sum.
    offset
        c.
    before_map, after_map
        M and T^-1, arguments and values, increasing.
    direction
        "forward": the sum is the output, u the input. "inverse": it was identified the other way round, the sum is the
        input and u the output; `run` solves and `run_inverse` evaluates.
    dead_time
        Forward the input counts so much later, rounded to whole periods. The inverse says which input belongs to an
        output; that it must come earlier is for who plays it. [s]
    period
        Of the log it was identified from; for it the inverse is stable. 0: unknown, not checked, no dead time. [s]
    schedules
        Source, low and high of each: -1 follows u of the sample before, 0 and 1 a given signal.
    row
        Name of the family it belongs to.

    Raises
    ------
    ParameterError
        If a part is none, or an inverse model does not rise, so that it has no output.

    Examples
    --------
    >>> model = ElementModel((Element("input", weight=0.5), Element("creep", time=2.0, weight=0.5)))
    >>> y = model.simulate([0.0, 1.0, 1.0], [0.0, 1.0, 2.0])
    >>> y.round(4).tolist(), model.inverse().simulate(y, [0.0, 1.0, 2.0]).round(12).tolist()
    ([0.0, 0.6967, 0.8161], [0.0, 1.0, 1.0])
    """

    elements: tuple[Element, ...] = (Element("input"),)
    offset: float = 0.0
    before_map: Pairs = NO_MAP
    after_map: Pairs = NO_MAP
    direction: str = "forward"
    dead_time: float = 0.0
    period: float = 0.0
    schedules: tuple[tuple[int, float, float], ...] = ()
    row: str = "elements"
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = NO_CARD
    core = "elements"

    def __post_init__(self) -> None:
        """Normalise; refuse what is no model."""
        put = object.__setattr__
        try:
            put(self, "elements", tuple(q if isinstance(q, Element) else Element(*q) for q in self.elements))
            put(self, "schedules", tuple(_schedule(given) for given in self.schedules))
        except TypeError as fault:
            raise ParameterError(f"elements and schedules are not lists of such ({fault!s:.120}).") from None
        if not self.elements:
            raise ParameterError("a sum of elements has none; pass one Element or more.")
        for q, after in zip(self.elements, (*self.elements[1:], Element("input")), strict=True):
            if q.kind == "product" and after.kind not in ("past", "product"):
                raise ParameterError(
                    f"a product is followed by {after.kind!r}, and takes the lag of a past or product behind it. Put "
                    f"one there; weight 0 leaves it out of the sum."
                )
        put(self, "offset", parameter_number(self.offset, "offset"))
        for name in ("before_map", "after_map"):
            put(self, name, pairs_of(getattr(self, name), name, rising=True))
        for name in ("dead_time", "period"):
            put(self, name, parameter_number(getattr(self, name), name))
        put(self, "family", self.row)
        put(self, "rate_dependent", any(q.timed for q in self.elements))
        self._check()

    def _check(self) -> None:
        if self.direction not in DIRECTIONS:
            raise ParameterError(f"direction = {self.direction!r:.40}; it is one of {', '.join(DIRECTIONS)}.")
        if self.period < 0.0 or not 0.0 <= self.dead_time <= 1e4 * self.period:
            raise ParameterError(
                f"a dead time of {self.dead_time:g} s at a period of {self.period:g} s; pass both from 0 on, the dead "
                f"time at most 10 000 periods: it is kept sample by sample."
            )
        most = 2 * len(self.schedules)
        if len(self.schedules) > _native.DIRECT_SCHEDULES or any(not 0 <= q.schedule <= most for q in self.elements):
            raise ParameterError(
                f"{len(self.schedules)} schedules have the shares 0 to {most}, at most {_native.DIRECT_SCHEDULES} "
                f"schedules; an element names another."
            )
        if self.direction == "inverse" and self._fall:
            raise ParameterError(f"the inverse model does not tell its output: {self._fall}")

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of its elements, each once, and "map" if there is one before or behind the sum."""
        own = dict.fromkeys(q.kind for q in self.elements)
        return (*own, "map") if self.before_map[0] or self.after_map[0] else tuple(own)

    def machine(  # noqa: D102 - documented in the base class
        self, direction: Direction, range: tuple[float, float] | None, ramp: int, period: float | None
    ) -> Machine:
        return element_machine(self, direction, range, ramp, period)

    @property
    def prompt(self) -> Self:
        """The same sum without dead time."""
        return replace(self, dead_time=0.0)

    @property
    def without_lags(self) -> ElementModel:
        """The same sum where every lag has caught up with its input: plays, stops and curve, no creep."""
        return self._become(CAUGHT_UP)

    @property
    def without_memory(self) -> ElementModel:
        """The same sum where every play follows its input: the curve of large, slow motions."""
        return self._become(MEMORYLESS)

    def _become(self, kinds: Mapping[str, str]) -> ElementModel:
        squared = [replace(q, kind="input", map=_square(q)) if q.kind == "product" else q for q in self.elements]
        changed = [(q, kinds.get(q.kind, q.kind)) for q in squared]
        kept = tuple(replace(q, kind=kind, radius=q.radius * (kind != "input")) for q, kind in changed if kind)
        still = sum(q.weight * float(np.interp(0.0, *q.map)) for q, kind in changed if not kind and q.map[0])
        return replace(self, elements=kept, offset=self.offset + still)

    @cached_property
    def least_slope(self) -> float:
        """Lower bound of the slope of the sum, over all inputs and memories; scaled."""
        return least_slope(self.elements, len(self.schedules), self.period)

    @property
    def inverse_gain(self) -> float:
        """Upper bound of the slope |dx/dy| of the inverse, over all memories. [input/output]"""
        scale = abs(self.scaling.half_range / self.scaling.amplitude)
        if self.direction == "inverse":
            return scale * most_slope(self.elements)
        flattest = self.least_slope
        for u, v in (self.before_map, self.after_map):
            flattest *= float(np.min(np.diff(v) / np.diff(u))) if u else 1.0
        return scale / flattest if flattest > 0.0 else float("inf")

    @property
    def _fall(self) -> str:
        if self.least_slope >= LEAST_SLOPE:
            return ""
        return (
            f"while its lags catch up the output can fall although the input rises: the least slope of the sum is "
            f"{self.least_slope:.3g} output ranges per input range, and an inverse that settles needs {LEAST_SLOPE:g}."
        )

    @property
    def no_inverse(self) -> str:
        """Why the sum does not rise for every memory."""
        return self._fall if self.direction == "forward" else ""

    @property
    def nonzero_weights(self) -> int:
        """Number of elements that carry weight."""
        return sum(q.weight != 0.0 for q in self.elements)

    @property
    def context(self) -> tuple[SignalCard, ...]:
        """The given signals that schedules follow: signal_0, signal_1."""
        followed = {source: SignalCard(f"signal_{source}", "", low, high) for source, low, high in self.schedules}
        return tuple(followed[k] for k in (0, 1) if k in followed)

    @property
    def parts(self) -> tuple[int, str]:
        """Number of elements."""
        return len(self.elements), "elements"

    def pruned(self) -> Self:
        """Return the same sum without elements of zero weight, which is exact; one stays."""
        kept: list[Element] = []
        for q in self.elements:
            if q.weight != 0.0 or (kept and kept[-1].kind == "product"):  # whose lag it is
                kept.append(q)
        return replace(self, elements=tuple(kept) or (Element("input", weight=0.0),))

    @property
    def free_parameters(self) -> int:
        """Points of maps, weights that are not 0, offset."""
        own = sum(len(q.map[0]) if q.map[0] else int(q.weight != 0.0) for q in self.elements)
        return own + 1 + sum(max(0, len(u) - 2) for u, _ in (self.before_map, self.after_map))

    @property
    def timed(self) -> bool:
        """Whether time counts: creep, rate or a dead time."""
        return self.rate_dependent or self.dead_time > 0.0

    @property
    def delay(self) -> int:
        """Dead time in samples."""
        return round(self.dead_time / self.period) if self.dead_time else 0

    @cached_property
    def tables(self) -> tuple[Any, ...]:
        """What the machine is made of (`_native.ElementSum`)."""
        q = self.elements
        kind = np.array([KINDS.index(e.kind) for e in q], dtype=np.int32)
        schedule = np.array([e.schedule for e in q], dtype=np.int32)
        real = [np.array([getattr(e, name) for e in q]) for name in ("radius", "time", "weight")]
        points = np.array([len(e.map[0]) for e in q], dtype=np.int32)
        maps = np.array([[u for e in q for u in e.map[side]] for side in (0, 1)]).reshape(2, -1)
        before, after = (np.array(pairs).reshape(2, -1) for pairs in (self.before_map, self.after_map))
        source = np.array([s[0] for s in self.schedules], dtype=np.int32)
        limits = np.array([[s[side] for s in self.schedules] for side in (1, 2)]).reshape(2, -1)
        return (
            kind, schedule, *real, points, maps, self.offset, before, after, -FARTHEST, FARTHEST, source, limits
        )  # fmt: skip

    @cached_property
    def _sum(self) -> _native.ElementSum:
        return _native.ElementSum(*self.tables)

    @property
    def evaluated(self) -> ElementModel:
        """The sum itself, from its argument to its value: of an inverse model, from the output to the input."""
        if self.direction == "forward":
            return replace(self, dead_time=0.0)
        return replace(self, direction="forward", dead_time=0.0, scaling=self.scaling.swapped())

    def __getstate__(self) -> dict[str, Any]:
        """Everything but the machine, which is made anew."""
        return {name: value for name, value in self.__dict__.items() if name != "_sum"}

    @property
    def _unscheduled(self) -> ElementModel:
        """The same with given signals, which nobody knows before the first sample, in the middle of their range."""
        middle = (-1, -MIDDLE, MIDDLE)
        return replace(self, schedules=tuple(s if s[0] < 0 else middle for s in self.schedules))

    def rest(self, x: float) -> Array:
        """Everything that follows the input at it, and nothing relaxing; then the inputs that are under way."""
        still = replace(self.evaluated, start="rest")
        at = x if self.direction == "forward" else first_input(still._unscheduled, x)
        return np.concatenate([self._sum.rest(at), np.full(self.delay, x)])

    def before(self, first: float) -> Array:
        """As every family, but lags have had time to come to the first sample; it is what is under way, too.

        Of an inverse model the start is one of its output, along which it was identified: that which answers `first`.
        """
        if self.delay or self.direction == "inverse":
            sum_ = self.evaluated
            at = first if self.direction == "forward" else first_input(sum_._unscheduled, first)
            return np.concatenate([sum_.before(at), np.full(self.delay, first)])
        memory = np.array(super().before(first))
        memory[AHEAD:][[q.kind in LAGS for q in self.elements]] = memory[0]
        return memory

    def _stroke(self, memory: Array, at: float, turn: float) -> Array:
        """Memory needs no schedule."""
        way = np.linspace(at, turn, PRELUDE + 1)[1:]
        return self.columns(way, np.zeros(PRELUDE), memory)[1]

    def ahead(self, demand: Array, every: int = 1) -> Array:
        """As many samples earlier as inputs are under way."""
        late = round(self.delay / every)
        return np.concatenate([demand[late:], np.repeat(demand[-1:], min(late, demand.size))])

    def run(self, x: Array, dt: Array | None, memory: Array, given: Array | None = None) -> tuple[Array, Array]:
        """Evaluate the sum, or solve it; `given` (T, 2) are scheduling signals."""
        state, ring = np.split(memory, [AHEAD + len(self.elements)])
        late = np.concatenate([ring, x])
        machine = self._sum.run if self.direction == "forward" else self._sum.solve
        y, after = self._taken(machine(late[: x.size], dt, self._signals(given), state))
        return y, np.concatenate([after, late[x.size :]])

    def run_inverse(self, y: Array, dt: Array | None, memory: Array, given: Array | None = None) -> tuple[Array, Array]:
        """Solve the sum, or evaluate it; what is under way stays."""
        state, ring = np.split(memory, [AHEAD + len(self.elements)])
        machine = self._sum.solve if self.direction == "forward" else self._sum.run
        x, after = self._taken(machine(y, dt, self._signals(given), state))
        return x, np.concatenate([after, ring])

    def columns(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Return e of each element, (T, n), without map and weight, along the sum's own argument, and the memory."""
        return self._sum.columns(x, dt, memory[: AHEAD + len(self.elements)])

    def parameters(self) -> dict[str, Any]:
        """Return the parameters by name, plain values; scaling, start and card left out."""
        named = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        named["elements"] = [astuple(q) for q in self.elements]
        return {name: _plain(value) for name, value in named.items() if name not in ("scaling", "start", "card")}

    @classmethod
    def example(cls) -> ElementModel:
        """An element of each kind."""
        bend = ((-1.0, -0.3, 0.4, 1.0), (-0.25, -0.02, 0.05, 0.35))
        return cls(
            (
                Element("input", weight=0.6),
                Element("input", map=bend),
                Element("play", 0.2, weight=0.3),
                Element("stop", 0.3, weight=0.1),
                Element("creep", 0.05, time=1.0, weight=0.2),
                Element("relax", 0.0, time=0.2, weight=0.1),
                Element("product", 1.0, time=0.2, weight=0.05),
                Element("past", 0.0, time=3.0, weight=0.1),
                Element("path", 0.3, weight=0.1),
                Element("wide", 0.1, time=0.01, weight=0.1),
            ),
            period=0.02,
        )

    def _more(self, signals: Mapping[str, npt.ArrayLike], size: int) -> dict[str, Any]:
        """The given signals side by side, (T, 2); None where no schedule follows one."""
        named = self.given(signals, size)
        none = np.zeros(size)
        return {"given": np.column_stack([named.get(f"signal_{k}", none) for k in (0, 1)])} if named else {}

    def _signals(self, given: Array | None) -> Array | None:
        if given is None and any(source >= 0 for source, _, _ in self.schedules):
            raise ParameterError(
                f"this {self.family} model is scheduled by a signal that is not given; pass given=, (T, 2), one column "
                f"for each of the signals 0 and 1."
            )
        return given

    def _taken(self, found: tuple[Array, Array, int, int]) -> tuple[Array, Array]:
        if found[2]:
            raise ParameterError(
                f"{found[2]} samples are not finite or beyond {_native.INPUT_LIMIT:g}; the memory would carry them "
                f"into every later sample. Drop them."
            )
        return found[0], found[1]


def _square(product: Element) -> Pairs:
    """The map of a product whose lags have caught up: the square of the input within its radius, in pieces of line."""
    u = np.linspace(-product.radius, product.radius, SQUARE) if product.radius else np.array([-1.0, 1.0])
    v = np.clip(u, -product.radius, product.radius) ** 2
    v = _native.map_values(np.array(product.map[0]), np.array(product.map[1]), v) if product.map[0] else v
    far = u[[0, -1]] * FARTHEST / max(product.radius, 1e-9)
    u, v = np.concatenate([far[:1], u, far[1:]]), v[[0, *range(u.size), -1]]
    return tuple(u.tolist()), tuple(v.tolist())


def _schedule(given: Any) -> tuple[int, float, float]:
    try:
        source, low, high = given
    except (TypeError, ValueError):
        raise ParameterError(f"a schedule is {given!r:.60}; pass its source, low and high.") from None
    low, high = parameter_number(low, "low of a schedule"), parameter_number(high, "high of a schedule")
    if source not in (-1, 0, 1) or not low < high:
        raise ParameterError(
            f"a schedule follows {source!r:.20} from {low:g} to {high:g}; its source is -1 (u of the sample before), 0 "
            f"or 1 (given signals), and its range goes up."
        )
    return int(source), low, high


def _plain(value: Any) -> Any:
    """Tuples as lists, all the way down."""
    return [_plain(part) for part in value] if isinstance(value, tuple | list) else value
