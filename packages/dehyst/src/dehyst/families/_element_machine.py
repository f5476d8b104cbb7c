"""A sum of elements or its inverse as a block of the core: constants for a period, limits, linear ends."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

import dehyst._native as _native
from dehyst.errors import ParameterError
from dehyst.families._rising import LEAST_SLOPE
from dehyst.models import SignalCard
from dehyst.models import kit as models_kit

if TYPE_CHECKING:
    from dehyst.families._elements import ElementModel, Pairs

BEYOND = 0.5  # of the height of the slow loop: creep and rate may add so much
LONG = 1e9  # s, after which every lag has reached its input
ROUNDING = 1e-9
NUMBERS = (
    "echo", "origin", "center", "half_range", "level", "amplitude", "input_low", "input_high", "output_low",
    "output_high", "reach_low", "reach_high", "line_slope", "line_offset", "fade",
)  # fmt: skip


@dataclass(frozen=True)
class ElementBlockParameters:
    """Parameters of the core's ``dehyst_element_block`` with the bits that are used: what an exporter prints.

    Attributes
    ----------
    kind, schedule, radius, gain, weight, maps
        Of the elements, in their order; the gain for the period.
    offset
        c of the sum.
    before, after
        Maps in front of what runs and behind it: those of the model, or swapped where the sum is solved.
    low, high
        Of all x of the sum. [scaled]
    source, schedule_low, schedule_high
        Of the schedules.
    solves
        Whether the sum is solved and not evaluated.
    delay
        In samples: dead time, or half a swing of the resonance that an inverse must not ring.
    start
        Memory before the stroke to the first sample; () at rest there.
    numbers
        By the names of `NUMBERS`.
    fingerprint
        First 32 bits of the SHA-256 of all of it.
    """

    kind: tuple[int, ...]
    schedule: tuple[int, ...]
    radius: tuple[float, ...]
    gain: tuple[float, ...]
    weight: tuple[float, ...]
    maps: tuple[Pairs, ...]
    offset: float
    before: Pairs
    after: Pairs
    low: float
    high: float
    source: tuple[int, ...]
    schedule_low: tuple[float, ...]
    schedule_high: tuple[float, ...]
    solves: bool
    delay: int
    start: tuple[float, ...]
    numbers: Mapping[str, float]
    fingerprint: int


def element_machine(
    model: ElementModel,
    direction: models_kit.Direction,
    range: tuple[float, float] | None,
    ramp: int,
    period: float | None,
) -> models_kit.Machine:
    """Return the block of the core: at a fixed period, its first good sample as ``model.before`` says.

    An inverse block takes wanted outputs half of the slow loop's height beyond its ends: so much creep and rate may
    add. Dead time counts forward.
    """
    if direction == "inverse":
        # An inverse block answers at once: its reference is given ahead.
        model = model.prompt
    low, high = models_kit.declared_range(model.card.input, range)
    period = models_kit.parameter_number(
        _usual(model, direction) if period is None else period, "period"
    )
    _refuse_period(model, direction, period)
    p, sum_ = _made(model, direction, period, ramp, low, high)
    numbers = p.numbers
    native = _native.ElementBlock(
        sum_, period, p.solves, p.delay, np.array(p.start), np.array([numbers[name] for name in NUMBERS]),
        p.fingerprint,
    )  # fmt: skip
    card = model.card.swapped() if direction == "inverse" else model.card
    input = replace(card.input, low=numbers["input_low"], high=numbers["input_high"])
    output = replace(card.output, low=numbers["output_low"], high=numbers["output_high"])
    return models_kit.Machine(
        native,
        p,
        input,
        output,
        _followed(model),
        _native.DIRECT_GIVEN,
        period=period,
        timed=_timed(model, direction),
        observes=True,
    )


def _solves(model: ElementModel, direction: models_kit.Direction) -> bool:
    """Whether each sample is a solution of the sum, not its value."""
    return (direction == "inverse") == (model.direction == "forward")


def _refuse_period(model: ElementModel, direction: models_kit.Direction, period: float) -> None:
    if not period > 0.0:
        raise ParameterError(
            f"a period of {period:g} s is none; pass the time between two samples, above 0."
        )
    if direction == "inverse":
        model.inverse()  # says why there is none
    if not _solves(model, direction):
        return
    slope = replace(model, direction="forward", period=period, dead_time=0.0).least_slope
    if slope < LEAST_SLOPE:
        raise ParameterError(
            f"every {period:g} s the sum has no stable solution: its least slope is {slope:.3g} of its range, "
            f"and must be {LEAST_SLOPE:g} or more. It was identified every {model.period:g} s; run it so, or "
            f"identify from a log with the period of the machine."
        )


def _timed(model: ElementModel, direction: models_kit.Direction) -> bool:
    """Whether time counts for a block: an inverse one delays a part of its reference if the actuator rings."""
    return model.timed or (direction == "inverse" and model.resonance is not None)


def _usual(model: ElementModel, direction: models_kit.Direction) -> float:
    """Period of the log, or any where time does not count. [s]"""
    if _timed(model, direction) and not model.period:
        raise ParameterError(
            "the model creeps, rings, depends on the rate or has a dead time, and does not say at which period it was "
            "identified. Pass period, the seconds between two samples of your loop (in a terminal: --period 0.001)."
        )
    return model.period or 1.0


def _followed(model: ElementModel) -> tuple[SignalCard, ...]:
    """Given signals that schedules follow, up to the last one that is used, with the ends of all that follow it."""
    last = -1
    ends: dict[int, tuple[float, float]] = {}
    for source, low, high in model.schedules:
        last = max(last, source)
        widest = ends.get(source, (low, high))
        ends[source] = min(low, widest[0]), max(high, widest[1])
    cards = []
    for k in range(last + 1):
        low, high = ends.get(k, (0.0, 1.0))
        cards.append(model.signal_card(k, low, high))
    return tuple(cards)


def _made(
    model: ElementModel,
    direction: models_kit.Direction,
    period: float,
    ramp: int,
    low: float,
    high: float,
) -> tuple[ElementBlockParameters, _native.ElementSum]:
    inverse = direction == "inverse"
    solves = _solves(model, direction)
    scaling = model.scaling
    slow = _slow(model, low, high)
    wide = BEYOND * abs(slow[1] - slow[0])
    reached = min(slow) - wide, max(slow) + wide
    slope = (slow[1] - slow[0]) / (high - low)
    # Without a model the block follows the line through both ends of the slow loop.
    if inverse:
        into, limits = scaling.swapped(), (reached, (low, high))
        line = (1.0 / slope, low - slow[0] / slope)
    else:
        into, limits = scaling, ((low, high), reached)
        line = (slope, slow[0] - slope * low)
    before, after = model.before_map, model.after_map
    maps = ((after[1], after[0]), (before[1], before[0])) if solves else (before, after)
    start, origin = _departure(model)
    ends = _through(maps[0], *_scaled(limits[0], into.center, into.half_range))
    exits = _through(_swapped(maps[1]), *_scaled(limits[1], into.level, into.amplitude))
    x_range = exits if solves else ends
    reach = (-_native.INPUT_LIMIT, _native.INPUT_LIMIT)
    if inverse and not solves:
        reach = exits
    elif not inverse and not solves:
        # A forward block never limits its output to the loop: the actuator did get this input.
        bottom, top = _bounds(model, *ends, (*start, origin) if start else ())
        ends_of_sum = _through(maps[1], bottom, top)
        bottom, top = sorted(into.level + into.amplitude * end for end in ends_of_sum)
        limits = limits[0], (bottom, top)
    tables = list(model.tables)
    tables[8:12] = [np.array(maps[0]).reshape(2, -1), np.array(maps[1]).reshape(2, -1), *x_range]
    sum_ = _native.ElementSum(*tables)
    delay, echo = _delayed(model, inverse, period)
    values = (
        echo,
        origin,
        into.center,
        into.half_range,
        into.level,
        into.amplitude,
        *limits[0],
        *limits[1],
        *reach,
        *line,
    )
    numbers = dict(zip(NUMBERS, map(float, (*values, 1.0 / ramp)), strict=True))
    kind, schedule, radius, weight, element_maps = [], [], [], [], []
    for q in model.elements:
        kind.append(_native.ELEMENT_KINDS.index(q.kind))
        schedule.append(q.schedule)
        radius.append(q.radius)
        weight.append(q.weight)
        element_maps.append(q.map)
    source, schedule_low, schedule_high = [], [], []
    for signal, lower, upper in model.schedules:
        source.append(signal)
        schedule_low.append(lower)
        schedule_high.append(upper)
    parameters = ElementBlockParameters(
        kind=tuple(kind), schedule=tuple(schedule), radius=tuple(radius), gain=tuple(sum_.gains(period).tolist()),
        weight=tuple(weight), maps=tuple(element_maps), offset=model.offset, before=maps[0], after=maps[1],
        low=x_range[0], high=x_range[1], source=tuple(source), schedule_low=tuple(schedule_low),
        schedule_high=tuple(schedule_high), solves=solves, delay=delay,
        start=start, numbers=numbers, fingerprint=0,
    )  # fmt: skip
    # The fingerprint covers every field, so that exported code and model cannot be mixed up.
    digest = hashlib.sha256(repr(parameters).encode()).digest()
    return replace(parameters, fingerprint=int.from_bytes(digest[:4], "big")), sum_


def _delayed(model: ElementModel, inverse: bool, period: float) -> tuple[int, float]:
    """Return a delay of the input in samples, and its share: of a dead time all, of a shaped reference a part."""
    if not inverse:
        return round(model.dead_time / period), 1.0
    if model.resonance is None or not model.resonance.samples(period):
        return 0, 1.0
    return model.resonance.samples(period), model.resonance.share


def _slow(model: ElementModel, low: float, high: float) -> tuple[float, float]:
    """Outputs at both ends of the loop of an input that waits there until all lags have come."""
    scaling = model.scaling
    # Each end is visited twice, and each time the input waits there.
    ends = np.repeat([low, high, low, high], 2)
    x = np.ascontiguousarray(scaling.inward(ends))
    still = replace(model, dead_time=0.0)
    middle = np.full((x.size, _native.DIRECT_GIVEN), 0.0)
    for source, below, above in model.schedules:
        if source >= 0:
            middle[:, source] = 0.5 * (below + above)
    y = scaling.outward(still.run(x, np.full(x.size, LONG), model.evaluated.rest(0.0), middle)[0])
    if not y[5] != y[7]:
        raise ParameterError(
            f"from one end of the input's range, {low:g}, to the other, {high:g}, the output does not move: no block "
            f"can be made of it. Pass range=(low, high), what the actuator can be given.",
            low=low,
            high=high,
        )
    return float(y[5]), float(y[7])


def _departure(model: ElementModel) -> tuple[tuple[float, ...], float]:
    """Memory of the elements from where one stroke leads to the first sample, and its x; () for rest."""
    if model.start == "rest":
        return (), 0.0
    memory = model.evaluated.departure()[0]
    return tuple(memory[2 : 2 + len(model.elements)].tolist()), float(memory[0])


def _swapped(map: Pairs) -> Pairs:
    return map[1], map[0]


def _scaled(limits: tuple[float, float], center: float, unit: float) -> tuple[float, float]:
    low, high = limits
    return (low - center) / unit, (high - center) / unit


def _through(map: Pairs, *values: float) -> tuple[float, float]:
    """Return two values behind an increasing map, continued along its ends; the smaller one first."""
    u, v = np.array(map[0]), np.array(map[1])
    mapped = np.array(values)
    if u.size:
        left = np.clip(np.searchsorted(u, values, side="right") - 1, 0, u.size - 2)
        rise, run = v[left + 1] - v[left], u[left + 1] - u[left]
        mapped = v[left] + (mapped - u[left]) * rise / run
    return float(mapped.min()), float(mapped.max())


def _bounds(
    model: ElementModel, low: float, high: float, start: tuple[float, ...]
) -> tuple[float, float]:
    """Lower and upper bound of the sum over all inputs in low .. high and all memories that they leave."""
    bottom, top = min(low, *start, low), max(high, *start, high)
    least = most = model.offset
    size = abs(model.offset)
    for q in model.elements:
        reach = {
            "input": (low, high),
            "stop": (-q.radius, q.radius),
            "relax": (low - top, high - bottom),
            "path": (-q.radius, q.radius),
            "product": (-(q.radius**2), q.radius**2),
        }.get(q.kind, (bottom, top))
        # A piecewise linear map is largest and least at its points or at the ends of what reaches it.
        values = [0.0] if q.schedule else []
        for e in (*reach, *q.map[0]):
            if reach[0] <= e <= reach[1]:
                values.append(q.weight * _through(q.map, e, e)[0])
        least += min(values)
        most += max(values)
        size += max(map(abs, values))
    return least - ROUNDING * size, most + ROUNDING * size
