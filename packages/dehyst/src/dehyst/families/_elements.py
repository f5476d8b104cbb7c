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
0 (`dehyst.families._rising`); then the inverse is exact, sample by sample, for every row.

Source: M. Brokate and J. Sprekels, Hysteresis and Phase Transitions, 1996, for sums of maps of plays; P. R. Dahl,
1968, for the path; P. Krejci and K. Kuhnen, 2001, for creep. The sum of all, its certificate and its inverse are this
project's (docs/decisions/0042-one-machine-of-elements.md).

Cannot show
-----------
Inertia, memory of the sign of the speed beyond these elements, drift without cause.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import astuple, dataclass, field, fields, replace
from functools import cached_property, partial
from math import isfinite
from typing import Any, Self

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.families._base import PRELUDE, UNSCALED, LoopModel, LoopStepper, Scaling, same_input
from dehyst.families._element_machine import element_machine
from dehyst.families._inversion import FARTHEST, first_input
from dehyst.families._rising import LEAST_SLOPE, least_slope, most_slope
from dehyst.families._transforms import transform_name
from dehyst.models import Model, ModelCard, Resonance, SignalCard
from dehyst.models import kit as models_kit
from dehyst.shell import command

KINDS = _native.ELEMENT_KINDS
DIRECTIONS = ("forward", "inverse")
WINGS = ("upper", "lower")
ROUNDING = 1e-9  # of a wing, by which an output may lie beyond its turn
EDGE = 1e-6  # width of what stands beside the turn of a wing, scaled
LAGS = ("creep", "relax", "past", "product")
SQUARE = 17  # points
MIDDLE = 1e12  # of a range so wide that what is scaled is in its middle
SOURCES: int = _native.DIRECT_GIVEN  # signals that the core takes beside its input
AHEAD = 2  # numbers of the memory in front of the elements: the input of the sample before, and its step

Pairs = tuple[tuple[float, ...], tuple[float, ...]]
NO_MAP: Pairs = ((), ())
# What elements become where their lags have caught up, and where nothing is remembered at all; "": they add nothing.
CAUGHT_UP = {"creep": "play", "wide": "play", "past": "input", "relax": ""}
MEMORYLESS = {
    "creep": "input",
    "wide": "input",
    "past": "input",
    "relax": "",
    "play": "input",
    "stop": "",
    "path": "",
}


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
            raise ParameterError(
                f"an element is of the kind {self.kind!r:.40}; the kinds are {', '.join(KINDS)}."
            )
        for name in ("radius", "time", "weight"):
            value = models_kit.parameter_number(getattr(self, name), f"{name} of an element")
            put(self, name, value)
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


def pairs_of(map: Any, name: str, rising: bool = False) -> Pairs:
    """Return arguments and values of a map as tuples; both are empty if there is no map.

    Raises
    ------
    ParameterError
        If sizes differ, there is one point alone, or arguments (values too, if `rising`) do not increase.
    """
    try:
        arguments, values = map
        empty = not len(arguments) and not len(values)
    except (TypeError, ValueError):
        raise ParameterError(
            f"{name} is {map!r:.60}; pass two lists, arguments and values."
        ) from None
    if empty:
        return NO_MAP
    u = models_kit.parameter_array(arguments, f"arguments of {name}")
    v = models_kit.parameter_array(values, f"values of {name}")
    if u.size != v.size or u.size < 2:
        raise ParameterError(
            f"{name} has {u.size} arguments and {v.size} values; pass as many of both, two or more."
        )
    models_kit.strictly_increasing(u, f"arguments of {name}")
    if rising:
        models_kit.strictly_increasing(v, f"values of {name}")
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
        M and T^-1, arguments and values, increasing. The values of T^-1 may turn once at an inner argument, as in a
        butterfly loop: then there is no inverse, but that of a `wing`.
    direction
        "forward": the sum is the output, u the input. "inverse": it was identified the other way round, the sum is the
        input and u the output; `run` solves and `run_inverse` evaluates.
    dead_time
        Forward the input counts so much later, rounded to whole periods. The inverse says which input belongs to an
        output; that it must come earlier is for who plays it. [s]
    period
        Of the log it was identified from; for it the inverse is stable. 0: unknown, not checked, no dead time. [s]
    schedules
        Source, low and high of each: -1 follows u of the sample before, 0, 1 and 2 a given signal.
    row
        Name of the family it belongs to.
    signals
        Name and unit of the given signals 0, 1 and 2; without them they are called signal_0, signal_1 and signal_2.
    resonance
        At which the actuator rings (`dehyst.models.Resonance`), or its frequency [Hz] and damping; None: nothing is
        known of one.

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
    signals: tuple[tuple[str, str], ...] = field(default=(), kw_only=True)
    resonance: Resonance | None = field(default=None, kw_only=True)
    row: str = "elements"
    scaling: Scaling = UNSCALED
    start: str | tuple[float, ...] = "rest"
    card: ModelCard = models_kit.NO_CARD
    core = "elements"

    def __post_init__(self) -> None:
        """Normalise; refuse what is no model."""
        put = object.__setattr__
        try:
            put(self, "elements", tuple(map(_element, self.elements)))
            put(self, "schedules", tuple(map(_schedule, self.schedules)))
            put(self, "signals", tuple((str(name), str(unit)) for name, unit in self.signals))
        except (TypeError, ValueError) as fault:
            raise ParameterError(
                f"elements, schedules and signals are not lists of such ({fault!s:.120})."
            ) from None
        if not self.elements:
            raise ParameterError("a sum of elements has none; pass one Element or more.")
        for q, after in zip(self.elements, (*self.elements[1:], Element("input")), strict=True):
            if q.kind == "product" and after.kind not in ("past", "product"):
                raise ParameterError(
                    f"a product is followed by {after.kind!r}, and takes the lag of a past or product behind it. Put "
                    f"one there; weight 0 leaves it out of the sum."
                )
        put(self, "offset", models_kit.parameter_number(self.offset, "offset"))
        put(self, "before_map", pairs_of(self.before_map, "before_map", rising=True))
        put(self, "after_map", pairs_of(self.after_map, "after_map"))
        for name in ("dead_time", "period"):
            put(self, name, models_kit.parameter_number(getattr(self, name), name))
        put(self, "resonance", models_kit.resonance_of(self.resonance))
        put(self, "family", self.row)
        put(self, "rate_dependent", any(q.timed for q in self.elements))
        self._check()
        put(self, "winged", self.turn > 0)

    def _check(self) -> None:
        if self.direction not in DIRECTIONS:
            raise ParameterError(
                f"direction = {self.direction!r:.40}; it is one of {', '.join(DIRECTIONS)}."
            )
        if self.period < 0.0 or not 0.0 <= self.dead_time <= 1e4 * self.period:
            raise ParameterError(
                f"a dead time of {self.dead_time:g} s at a period of {self.period:g} s; pass both from 0 on, the dead "
                f"time at most 10 000 periods: it is kept sample by sample."
            )
        most = 2 * len(self.schedules)
        named = np.array([q.schedule for q in self.elements], dtype=object)
        too_many = len(self.schedules) > _native.DIRECT_SCHEDULES
        if too_many or np.any(named < 0) or np.any(named > most):
            raise ParameterError(
                f"{len(self.schedules)} schedules have the shares 0 to {most}, at most {_native.DIRECT_SCHEDULES} "
                f"schedules; an element names another."
            )
        if not self._turns_once:
            models_kit.strictly_increasing(np.array(self.after_map[1]), "values of after_map")
        if self.direction == "inverse" and self._fall:
            raise ParameterError(f"the inverse model does not tell its output: {self._fall}")

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of its elements, each once, and "map" if there is one before or behind the sum."""
        kinds = dict.fromkeys(q.kind for q in self.elements)
        if self.before_map[0] or self.after_map[0]:
            kinds["map"] = None
        return tuple(kinds)

    def machine(
        self,
        direction: models_kit.Direction,
        range: tuple[float, float] | None,
        ramp: int,
        period: float | None,
    ) -> models_kit.Machine:
        if self.no_export:
            raise ParameterError(self.no_export)
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
        remaining = []
        still = [0.0]
        for q in self.elements:
            if q.kind == "product":
                # Both lags have caught up with the input, so that their product is its square.
                q = replace(q, kind="input", map=_square(q))
            kind = kinds.get(q.kind, q.kind)
            if kind:
                remaining.append(replace(q, kind=kind, radius=q.radius * (kind != "input")))
            elif q.map[0]:
                # An element that stands still adds the value of its map at 0.
                still.append(q.weight * float(np.interp(0.0, *q.map)))
        return replace(self, elements=tuple(remaining), offset=self.offset + sum(still))

    @cached_property
    def least_slope(self) -> float:
        """Lower bound of the slope of the sum, over all inputs and memories; scaled."""
        return least_slope(self.elements, len(self.schedules), self.period)

    @property
    def _turns_once(self) -> bool:
        """Whether the values of `after_map` fall up to an inner point and rise from there on, or the other way."""
        steps = np.sign(np.diff(self.after_map[1]))
        once = np.count_nonzero(np.diff(steps)) == 1 and bool(np.all(steps))
        return once and self.direction == "forward"

    @cached_property
    def turn(self) -> int:
        """Which point of `after_map` is its turn; 0 if it has none."""
        if not self._turns_once:
            return 0
        return 1 + int(np.flatnonzero(np.diff(np.sign(np.diff(self.after_map[1]))))[0])

    def wing(self, side: str, outputs: npt.ArrayLike | None = None) -> Model:
        """Return one wing of a butterfly: a sum with an inverse, and this model while the actuator is on that wing.

        Beyond the turn there is no output: for one that lies there the inverse holds the input of the turn. The output
        range of its card is that of the wing. It begins as after poling: the input went over its whole range, and comes
        from the end of this wing; a memory that is known stays.

        Parameters
        ----------
        side
            "upper", where the input is above the turn, or "lower".
        outputs
            That the wing is to give, (T,). [output]

        Raises
        ------
        ParameterError
            If the map does not turn, there is no such side, or an output lies beyond the turn.

        Examples
        --------
        >>> from dehyst.families import example
        >>> model = example("butterfly")
        >>> x = [1.0, 0.5, 0.9, 0.4]
        >>> wing, poled = model.wing("upper"), model.after_strokes(1.0, rising=False)
        >>> bool(abs(wing.inverse().simulate(poled.simulate(x)) - x).max() < 1e-12)
        True
        """
        if side not in WINGS:
            raise ParameterError(f"wing = {side!r:.40}; it is one of {', '.join(WINGS)}.")
        if not self.turn:
            return super().wing(side)
        part = slice(self.turn, None) if side == "upper" else slice(0, self.turn + 1)
        u, v = (np.array(values[part]) for values in self.after_map)
        scaling = self.scaling
        if v[-1] < v[0]:
            v, scaling = -v, replace(scaling, amplitude=-scaling.amplitude)
        at, end = scaling.outward(v[[0, -1]] if side == "upper" else v[[-1, 0]]).tolist()
        low, high = min(at, end), max(at, end)
        wanted = np.asarray([] if outputs is None else outputs, dtype=np.float64)
        beyond = (wanted - at) * np.sign(end - at) < -ROUNDING * (high - low)
        if np.any(beyond):
            farthest = float(wanted[np.argmax(np.abs(wanted - at) * beyond)])
            raise ParameterError(
                f"{np.count_nonzero(beyond)} of {wanted.size} wanted outputs lie beyond the turn of the {side} wing, "
                f"the farthest at {farthest:.4g}: the output turns at {at:.4g}, and this wing ends at {end:.4g}. No "
                f"input gives them. Move the reference by {at - farthest:.4g} or more, so that all of it lies between "
                f"{low:.4g} and {high:.4g}.",
                turn=at,
                farthest=farthest,
            )
        card = replace(self.card, output=replace(self.card.output, low=low, high=high))
        # An edge beside the turn, twice as high as the wing: along it the inverse stands still.
        inner, way = (0, -1.0) if side == "upper" else (-1, 1.0)
        edge = u[inner] + way * np.array([EDGE, EDGE + 1.0])
        fall = v[inner] + way * (2.0 * np.ptp(v) + np.array([0.0, 1.0]))
        points = sorted(zip([*u, *edge], [*v, *fall], strict=True))
        arguments, values = zip(*np.array(points).tolist(), strict=True)
        wing = replace(self, after_map=(arguments, values), scaling=scaling, card=card)
        if isinstance(self.start, tuple):
            return wing
        return wing.after_strokes(0.0, rising=side == "lower")

    @property
    def no_export(self) -> str:
        """As of every model; a map that turns is not for targets."""
        if not self.turn:
            return ""
        return (
            f"the map of this {self.family} model turns, and the core runs maps that rise. Export one wing: in Python "
            f'dehyst.load("model.json").wing("upper").save("upper.json"), then '
            f"{command('export', 'upper.json', target='c', out='unit')}."
        )

    @property
    def inverse_gain(self) -> float:
        """Upper bound of the slope |dx/dy| of the inverse, over all memories. [input/output]"""
        if self.turn:
            return float("inf")
        scale = abs(self.scaling.half_range / self.scaling.amplitude)
        if self.direction == "inverse":
            return scale * most_slope(self.elements)
        flattest = self.least_slope
        for u, v in (self.before_map, self.after_map):
            if u:
                flattest *= float(np.min(np.diff(v) / np.diff(u)))
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
        """Why the sum does not rise for every memory, or where its map turns."""
        if self.turn:
            turn = self.after_map[1][self.turn]
            bottom = float(self.scaling.outward(np.array(turn)))
            line = command("compensate", "model.json", "REFERENCE.csv", wing="upper")
            return (
                f"the output turns at {bottom:.4g} {self.card.output.unit}".rstrip()
                + f", so that two inputs give one output. A wing has one: {line} or --wing lower, in Python "
                f'model.wing("upper").inverse().'
            )
        return self._fall if self.direction == "forward" else ""

    @property
    def nonzero_weights(self) -> int:
        """Number of elements that carry weight."""
        return int(np.count_nonzero([q.weight for q in self.elements]))

    @property
    def context(self) -> tuple[SignalCard, ...]:
        """The given signals that schedules follow."""
        cards = {}
        for source, low, high in sorted(self.schedules, key=lambda schedule: schedule[0]):
            if source >= 0:
                cards[source] = self.signal_card(source, low, high)
        return tuple(cards.values())

    def signal_card(self, source: int, low: float, high: float) -> SignalCard:
        """The given signal of a number, with its range."""
        name, unit = f"signal_{source}", ""
        if source < len(self.signals):
            name, unit = self.signals[source]
        return SignalCard(name, unit, low, high)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Which transform of the input it acts on, which signals its weights go with, and where it rings."""
        remarks = []
        transform = transform_name(self.scaling, self.before_map)
        if transform:
            remarks.append(f"acts on the {transform} of {self.card.input.name}")
        if self.resonance is not None:
            f, damping = self.resonance.frequency, self.resonance.damping
            remarks.append(
                f"rings at {f:.4g} Hz (damping {damping:.2g}), which its inverse does not excite"
            )
        for card in self.context:
            remarks.append(
                f"weights go with {card.name}, {card.low:z.4g} to {card.high:z.4g} {card.unit}".rstrip()
            )
        return tuple(remarks)

    @property
    def parts(self) -> tuple[int, str]:
        """Number of elements."""
        return len(self.elements), "elements"

    def pruned(self) -> Self:
        """Return the same sum without elements of zero weight, which is exact; one stays."""
        remaining: list[Element] = []
        for q in self.elements:
            # A product reads the lag of the element behind it, whatever the weight of that one.
            if q.weight != 0.0 or (remaining and remaining[-1].kind == "product"):
                remaining.append(q)
        return replace(self, elements=tuple(remaining) or (Element("input", weight=0.0),))

    @property
    def free_parameters(self) -> int:
        """Points of maps, weights that are not 0, offset."""
        number = 1
        for q in self.elements:
            number += len(q.map[0]) or int(q.weight != 0.0)
        maps = [self.after_map]
        # No point of a transform was identified.
        if not transform_name(self.scaling, self.before_map):
            maps.append(self.before_map)
        for u, _ in maps:
            number += max(0, len(u) - 2)
        return number

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
        kind, schedule, points = [], [], []
        numbers = []
        maps = [np.zeros((2, 0))]
        for q in self.elements:
            kind.append(KINDS.index(q.kind))
            schedule.append(q.schedule)
            points.append(len(q.map[0]))
            numbers.append((q.radius, q.time, q.weight))
            maps.append(_matrix(q.map))
        radius, time, weight = np.ascontiguousarray(np.array(numbers).T)
        schedules = np.array(self.schedules, dtype=np.float64).reshape(-1, 3).T
        return (
            np.array(kind, dtype=np.int32), np.array(schedule, dtype=np.int32), radius, time, weight,
            np.array(points, dtype=np.int32), np.concatenate(maps, axis=1), self.offset,
            _matrix(self.before_map), _matrix(NO_MAP if self.turn else self.after_map), -FARTHEST, FARTHEST,
            schedules[0].astype(np.int32), np.ascontiguousarray(schedules[1:]),
        )  # fmt: skip

    @cached_property
    def _sum(self) -> _native.ElementSum:
        return _native.ElementSum(*self.tables)

    @cached_property
    def evaluated(self) -> ElementModel:
        """The sum itself, from its argument to its value: of an inverse model, from the output to the input."""
        if self.direction == "forward":
            return replace(self, dead_time=0.0)
        return replace(self, direction="forward", dead_time=0.0, scaling=self.scaling.swapped())

    def __getstate__(self) -> dict[str, Any]:
        """Everything but the machine, and the models made of this one, which are made anew."""
        made = ("_sum", "evaluated", "_unscheduled", "_still")
        return {name: value for name, value in self.__dict__.items() if name not in made}

    @cached_property
    def _still(self) -> ElementModel:
        """What is evaluated, begun at rest with given signals in the middle of their range."""
        return replace(self.evaluated, start="rest")._unscheduled

    @cached_property
    def _unscheduled(self) -> ElementModel:
        """The same with given signals in the middle of their range, for who has none."""
        middle = (-1, -MIDDLE, MIDDLE)
        schedules = []
        for schedule in self.schedules:
            schedules.append(schedule if schedule[0] < 0 else middle)
        return replace(self, schedules=tuple(schedules))

    def rest(self, x: float) -> Array:
        """Everything that follows the input at it, and nothing relaxing; then the inputs that are under way."""
        argument = x
        if self.direction == "inverse":
            argument = first_input(self._still, x)
        return np.concatenate([self._sum.rest(argument), np.full(self.delay, x)])

    def before(self, first: float, **more: Array) -> Array:
        """As every family, but lags have had time to reach the first sample, and dead time is filled with it.

        An inverse model was identified along its output. Its start is the state of that output which answers `first`
        with the signals of the first sample.
        """
        if isinstance(self.start, tuple):
            return self._remembered(self.start)
        if self.delay or self.direction == "inverse":
            evaluated = self.evaluated
            argument = first
            if self.direction == "inverse":
                argument = first_input(evaluated if more else evaluated._unscheduled, first, **more)
            return np.concatenate([evaluated.before(argument), np.full(self.delay, first)])
        # The stroke to the first sample takes no time, so lags are set to where it ends.
        memory = np.array(super().before(first))
        memory[AHEAD:][[q.kind in LAGS for q in self.elements]] = memory[0]
        return memory

    def departure(self) -> tuple[Array, float]:
        """As every family; of a memory that runs on the last input, without what is under way."""
        if isinstance(self.start, tuple):
            memory = self._remembered(self.start)[: AHEAD + len(self.elements)]
            return memory, float(memory[0])
        return super().departure()

    def _stroke(self, memory: Array, at: float, turn: float) -> Array:
        """Memory needs no schedule."""
        way = np.linspace(at, turn, PRELUDE + 1)[1:]
        return self.columns(way, np.zeros(PRELUDE), memory)[1]

    def ahead(self, demand: Array, time: npt.ArrayLike | None = None) -> Array:
        """Earlier by the dead time."""
        if not self.dead_time:
            return demand
        at = self.period * np.arange(demand.size, dtype=np.float64)
        if time is not None:
            at = np.asarray(time, dtype=np.float64)
        return models_kit.earlier(demand, at, self.dead_time)

    def simulate(
        self, x: npt.ArrayLike, time: npt.ArrayLike | None = None, **signals: npt.ArrayLike
    ) -> Array:
        """As `LoopModel.simulate`; the dead time is in seconds where there are time stamps."""
        model = self._sampled(time)
        return super(ElementModel, model).simulate(x, time, **signals)

    def _sampled(self, time: npt.ArrayLike | None) -> ElementModel:
        """The same where the dead time is as many samples as fit into it at these time stamps."""
        if not self.dead_time or time is None or np.size(time) < 2:
            return self
        step = float(np.median(np.diff(np.asarray(time, dtype=np.float64))))
        if not step > 0.0 or round(self.dead_time / step) == self.delay:
            return self
        return replace(self, dead_time=round(self.dead_time / step) * self.period)

    def run(
        self, x: Array, dt: Array | None, memory: Array, scheduling: Array | None = None
    ) -> tuple[Array, Array]:
        """Evaluate the sum, or solve it; `scheduling` (T, 3) are the given signals."""
        state, ring = np.split(memory, [AHEAD + len(self.elements)])
        # The ring holds the inputs that the dead time delays; the newest take the place of the oldest.
        late = np.concatenate([ring, x])
        machine = self._sum.run if self.direction == "forward" else self._sum.solve
        y, after = self._checked(machine(late[: x.size], dt, self._signals(scheduling), state))
        if self.turn:
            # The core runs maps that rise alone.
            u, v = _matrix(self.after_map)
            y = _native.map_values(u, v, y)
        return y, np.concatenate([after, late[x.size :]])

    def run_inverse(
        self, y: Array, dt: Array | None, memory: Array, scheduling: Array | None = None
    ) -> tuple[Array, Array]:
        """Solve the sum, or evaluate it; delayed inputs stay as they are."""
        state, ring = np.split(memory, [AHEAD + len(self.elements)])
        machine = self._sum.solve if self.direction == "forward" else self._sum.run
        x, after = self._checked(machine(y, dt, self._signals(scheduling), state))
        return x, np.concatenate([after, ring])

    def columns(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Return e of each element, (T, n), without map and weight, along the sum's own argument, and the memory."""
        return self._sum.columns(x, dt, memory[: AHEAD + len(self.elements)])

    def parameters(self) -> dict[str, Any]:
        """Return the parameters by name, plain values; scaling, start and card left out."""
        parameters = {}
        for entry in fields(self):
            if entry.name == "elements":
                parameters["elements"] = _plain(tuple(map(astuple, self.elements)))
            elif entry.name == "resonance":
                parameters["resonance"] = []
                if self.resonance is not None:
                    parameters["resonance"] = _plain(astuple(self.resonance))
            elif entry.name not in ("scaling", "start", "card", "resonance"):
                parameters[entry.name] = _plain(getattr(self, entry.name))
        return parameters

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
        """Return the signals of the schedules as the argument ``scheduling``, (T, 3); {} if no schedule needs one."""
        by_name = self.given(signals, size)
        if not by_name:
            return {}
        columns = np.zeros((size, SOURCES))
        for source in {schedule[0] for schedule in self.schedules if schedule[0] >= 0}:
            columns[:, source] = by_name[self.signal_card(source, 0.0, 1.0).name]
        return {"scheduling": columns}

    def _signals(self, scheduling: Array | None) -> Array | None:
        if scheduling is None and self.context:
            raise ParameterError(
                f"this {self.family} model is scheduled by a signal that is not given; pass scheduling=, (T, 3), one "
                f"column for each of the signals 0, 1 and 2."
            )
        return scheduling

    def steps(self, inverse: bool, period: float | None) -> models_kit.Steps:
        """As every family; without a dead time or signals from outside the core keeps the memory between samples."""
        if self.delay or self.needs or self.turn:
            return super().steps(inverse, period)
        return ElementStepper(self, inverse, period)

    def _checked(self, answer: tuple[Array, Array, int, int]) -> tuple[Array, Array]:
        values, memory, refused, _ = answer
        if refused:
            raise _refused(refused)
        return values, memory


def _refused(samples: int) -> ParameterError:
    return ParameterError(
        f"{samples} samples are not finite or beyond {_native.INPUT_LIMIT:g}; the memory would carry them "
        f"into every later sample. Drop them."
    )


class ElementStepper(LoopStepper):
    """A sum of elements, or its inverse, as a function of one sample, with its memory in the core.

    Examples
    --------
    >>> from dehyst.families import example
    >>> model = example("creep-pi")
    >>> step = model.stepper(0.01)
    >>> bool(step(0.0) == model.simulate([0.0], [0.0])[0])
    True
    """

    def __init__(self, model: ElementModel, inverse: bool, period: float | None) -> None:
        scaling = model.scaling
        first: Callable[..., float] = same_input
        if inverse:
            scaling, first = scaling.swapped(), partial(first_input, model)
        self._walk = _native.ElementSteps(
            model._sum, inverse is (model.direction == "forward"), scaling.center, scaling.half_range, scaling.level,
            scaling.amplitude,
        )  # fmt: skip
        self._step = self._walk.step
        super().__init__(model, model.run, scaling, first, period)

    @property
    def _memory(self) -> Array | None:
        return self._walk.memory() if self._begun else None

    @_memory.setter
    def _memory(self, memory: Array | None) -> None:
        if memory is not None:
            try:
                self._walk.begin(memory)
            except ValueError as fault:
                raise ParameterError(
                    f"an image whose memory is none of this model ({fault}). Restore what save() of a stepper of the "
                    f"same model returned."
                ) from None
        self._begun = memory is not None

    def __call__(self, value: float, period: float | None = None, **signals: float) -> float:
        """Return the output for the next sample, `period` [s] after the one before."""
        self.rejected = not isfinite(value)
        if self.rejected:
            self.rejected_ever = True
            return self.output
        if signals:
            self._model._more(signals, 1)
        passed = 0.0
        if self._begun:
            passed = self._passed(period)
        else:
            self._memory = self._model.before(self._first((value - self._from) / self._unit))
        try:
            self.output = self._step(value, passed)
        except ValueError:
            raise _refused(1) from None
        return self.output


def _square(product: Element) -> Pairs:
    """Return the map of a product whose lags have caught up: the squared input within its radius, piecewise linear."""
    u = np.array([-1.0, 1.0])
    if product.radius:
        u = np.linspace(-product.radius, product.radius, SQUARE)
    v = np.clip(u, -product.radius, product.radius) ** 2
    if product.map[0]:
        v = _native.map_values(np.array(product.map[0]), np.array(product.map[1]), v)
    # Beyond its radius the product is constant, as far as inputs are looked for.
    far = u[[0, -1]] * FARTHEST / max(product.radius, 1e-9)
    u, v = np.concatenate([far[:1], u, far[1:]]), v[[0, *range(u.size), -1]]
    return tuple(u.tolist()), tuple(v.tolist())


def _matrix(map: Pairs) -> Array:
    """Return arguments and values of a map as rows, (2, p)."""
    return np.array(map, dtype=np.float64).reshape(2, -1)


def _element(element: Any) -> Element:
    return element if isinstance(element, Element) else Element(*element)


def _schedule(schedule: Any) -> tuple[int, float, float]:
    try:
        source, low, high = schedule
    except (TypeError, ValueError):
        raise ParameterError(
            f"a schedule is {schedule!r:.60}; pass its source, low and high."
        ) from None
    low = models_kit.parameter_number(low, "low of a schedule")
    high = models_kit.parameter_number(high, "high of a schedule")
    if source not in (-1, *range(SOURCES)) or not low < high:
        raise ParameterError(
            f"a schedule follows {source!r:.20} from {low:g} to {high:g}; its source is -1 (u of the sample before), "
            f"or 0 to {SOURCES - 1} (given signals), and its range goes up."
        )
    return int(source), low, high


def _plain(value: Any) -> Any:
    """Return tuples as lists, all the way down."""
    if isinstance(value, tuple | list):
        return [_plain(part) for part in value]
    return value
