"""A direct inverse solved for the output of a given input, and as a block of the core."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models.card import SignalCard
from dehyst.models.machine import Direction, Machine, declared_range

if TYPE_CHECKING:
    from dehyst.models.direct import DirectInverse

# How far beyond the identified range of the output a solution is looked for, share of that range.
BEYOND = 0.1
# Outputs that are tried for the first sample.
TRIED = 4001


class Followed(NamedTuple):
    """Outputs (T,), and at how many samples no output within the range needs that input."""

    y: Array
    missed: int


def follow(
    model: DirectInverse,
    u: npt.ArrayLike,
    time: npt.ArrayLike | None = None,
    given: Mapping[str, Array] | None = None,
    start: str = "unknown",
) -> Followed:
    """Return the output for an input, a direct inverse read in the other direction.

    The rate of the output is the difference from the sample before. The model must carry the identified range of its
    output, within which (and 10 % beyond) a solution is looked for.

    Parameters
    ----------
    model
        The direct inverse.
    u
        Input, (T,). [input]
    time
        (T,), needed by creep and viscous terms. [s]
    given
        Scheduling variables by name, (T,).
    start
        Past before the first sample: "rest", "unknown", or "rising" or "falling" within a periodic motion.

    Raises
    ------
    ParameterError
        If the card names no range of the output.

    Examples
    --------
    >>> from dehyst.models import DirectInverse, ModelCard, SignalCard
    >>> card = ModelCard(SignalCard("u", low=-9.0, high=9.0), SignalCard("y", low=-3.0, high=3.0))
    >>> model = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0], card=card)
    >>> follow(model, [0.0, 2.0, -2.0], start="rest").y.round(9).tolist()
    [0.0, 1.0, -1.0]
    """
    low, high = _range(model)
    inputs = np.ascontiguousarray(u, dtype=np.float64)
    past = {"rising": (high, low), "falling": (low, high)}.get(start, ())
    lowest, highest, path = _memory(model, past, known=start != "unknown")
    factors = _factors(model, given or {}, inputs.size)
    first = _first(model, float(inputs[0]), past, start, factors)
    outputs = [schedule for schedule in model.schedules if not schedule.outside]
    at = outputs[0] if outputs else None
    kinds = [(1 + k % 2) if at is not None and model.schedules[k // 2] is at else 0 for k in range(model.sets)]
    ends = (at.low, at.high) if at is not None else (0.0, 1.0)
    begun = [np.clip(z, first - model.radii, first + model.radii) for z in _begin(lowest, highest, past, first, start)]
    return Followed(
        *_native.direct_forward(
            inputs,
            None if time is None else np.ascontiguousarray(time, dtype=np.float64),
            factors,
            first,
            np.ascontiguousarray(begun[0]),
            np.ascontiguousarray(begun[1]),
            np.ascontiguousarray(_walked(model, path, past, first)),
            np.array(model.radii),
            np.array(model.path_lengths),
            np.array(model.time_constants),
            np.ascontiguousarray(model.stop_weights),
            np.ascontiguousarray(model.path_weights),
            np.ascontiguousarray(model.creep_weights),
            np.ascontiguousarray(model.polynomial),
            np.ascontiguousarray(model.viscous),
            kinds,
            np.full(model.sets, ends[0]),
            np.full(model.sets, ends[1]),
            model.center,
            low,
            high,
            low - BEYOND * (high - low),
            high + BEYOND * (high - low),
        )
    )


def _range(model: DirectInverse) -> tuple[float, float]:
    card = model.card.output
    if card.low is None or card.high is None:
        raise ParameterError(model.no_forward)
    return card.low, card.high


def _memory(model: DirectInverse, past: tuple[float, ...], known: bool) -> tuple[Array, Array, Array]:
    """Lowest and highest plays, and path lags, after the turning points of the past."""
    r, path = model.radii, np.zeros(model.path_lengths.size)
    if not past:
        return -r, np.array(r), path
    lowest = highest = np.full(r.size, past[0])
    for before, turn in zip((past[0], *past), past, strict=False):
        lowest, highest = np.clip(lowest, turn - r, turn + r), np.clip(highest, turn - r, turn + r)
        path = _toward(model, path, turn - before)
    return lowest, highest, path


def _begin(lowest: Array, highest: Array, past: tuple[float, ...], first: float, start: str) -> tuple[Array, Array]:
    """States before the first sample: of the past, or around the first sample itself."""
    if past:
        return lowest, highest
    if start == "rest":
        return np.full(lowest.size, first), np.full(lowest.size, first)
    return first + lowest, first + highest


def _toward(model: DirectInverse, path: Array, way: float) -> Array:
    end = np.where(way < 0.0, -model.path_lengths, model.path_lengths)
    fade = np.array([_native.decay(abs(way) / x) for x in model.path_lengths])
    moved: Array = end + fade * (path - end)
    return moved


def _walked(model: DirectInverse, path: Array, past: tuple[float, ...], first: float) -> Array:
    return _toward(model, path, first - past[-1]) if past else path


def _factors(model: DirectInverse, given: Mapping[str, Array], size: int) -> Array | None:
    """Factors of sets (T, sets) that come from outside; 1 where they do not. None: there are none."""
    if not model.outside:
        return None
    factors = np.ones((size, model.sets))
    for v, schedule in enumerate(model.schedules):
        if schedule.outside:
            xi = np.clip((np.asarray(given[schedule.name]) - schedule.low) / (schedule.high - schedule.low), 0.0, 1.0)
            factors[:, 2 * v], factors[:, 2 * v + 1] = 1.0 - xi, xi
    return factors


def _first(model: DirectInverse, u: float, past: tuple[float, ...], start: str, factors: Array | None) -> float:
    """Output at the first sample: the one whose needed input is closest."""
    low, high = _range(model)
    tried = np.linspace(low, high, TRIED)
    needed = np.array([_needed(model, y, past, start, factors) for y in tried[::40]])
    coarse = int(np.argmin(np.abs(needed - u)))
    near = tried[max(0, 40 * coarse - 40) : 40 * coarse + 41]
    needed = np.array([_needed(model, y, past, start, factors) for y in near])
    left = needed - u
    k = int(np.argmin(np.abs(left)))
    beside = [j for j in (k - 1, k + 1) if 0 <= j < near.size and left[j] * left[k] < 0.0]
    if not beside:
        return float(near[k])
    j = beside[0]  # the crossing lies between
    return float(near[k] - left[k] * (near[j] - near[k]) / (left[j] - left[k]))


def _needed(model: DirectInverse, y: float, past: tuple[float, ...], start: str, factors: Array | None) -> float:
    """Input that an output needs at the first sample, creep and rate at rest."""
    lowest, highest, path = _memory(model, past, start != "unknown")
    states = [np.clip(z, y - model.radii, y + model.radii) for z in _begin(lowest, highest, past, y, start)]
    terms = np.concatenate([y - 0.5 * (states[0] + states[1]), _walked(model, path, past, y)])
    weights = np.concatenate([model.stop_weights, model.path_weights], axis=1)
    share = np.ones(model.sets) if factors is None else factors[0].copy()
    for v, schedule in enumerate(model.schedules):
        if not schedule.outside:
            xi = min(max((y - schedule.low) / (schedule.high - schedule.low), 0.0), 1.0)
            share[2 * v], share[2 * v + 1] = 1.0 - xi, xi
    curve = model.polynomial @ (y - model.center) ** np.arange(model.polynomial.shape[1])
    return float(share @ (curve + weights @ terms))


RATE = "rate"
LARGEST = 1e14  # no limit of a signal lies there
_LIMITS = 8  # place of center, input low and high, output low and high among the parameters


@dataclass(frozen=True)
class DirectParameters:
    """What the core's ``dehyst_direct_block`` is made of.

    Attributes
    ----------
    direct
        ``DirectInverse.parameters(period)`` with the block's limits.
    line_slope, line_offset
        Of the straight line that answers while the block is off. [u/y], [u]
    fade
        Share of a switching that one sample makes.
    """

    direct: tuple[Any, ...]
    line_slope: float
    line_offset: float
    fade: float


def direct_machine(
    model: DirectInverse, direction: Direction, range: tuple[float, float] | None, ramp: int, period: float | None
) -> Machine:
    """Return the block of the core."""
    if direction == "forward":
        raise ParameterError(
            "the model is a direct inverse: it answers which input an output needs, and there is no model of the "
            "output to run. Leave direction out (in a terminal: --what forward), or identify another family for it."
        )
    period = period if period is not None else model.period
    if not period:
        raise ParameterError(
            "the model is a direct inverse: what creeps depends on the time between two samples, which is not known "
            "here. Pass period, the seconds between two samples of your loop (in a terminal: --period SECONDS, what "
            "your target calls it with, for example --period 0.001)."
        )
    input, output = _limited(model.card.output, None, "y"), _limited(model.card.input, range, "u")
    told = list(model.parameters(period))
    told[_LIMITS] = np.array([model.center, input.low, input.high, output.low, output.high], float)
    p = DirectParameters(tuple(told), *_line(model, float(input.low or 0.0), float(input.high or 0.0)), 1.0 / ramp)
    rate = SignalCard(RATE, "", None, None)
    return Machine(
        _native.DirectBlock(p.direct, p.line_slope, p.line_offset, p.fade), p, input, output, (rate, *model.context), 3,
        {RATE: 0.0}, float(period), True, False,
    )  # fmt: skip


def _limited(card: SignalCard, range: tuple[float, float] | None, name: str) -> SignalCard:
    """The signal with limits: those given, or those of the identification."""
    card = replace(card, name=card.name or name)
    low, high = declared_range(card, range)
    if max(abs(low), abs(high)) > LARGEST:
        raise ParameterError(
            f"{card.label} goes from {low:g} to {high:g}; pass --range LO HI, both within {LARGEST:g}.",
            low=low,
            high=high,
        )
    return replace(card, low=low, high=high)


def _line(model: DirectInverse, low: float, high: float) -> tuple[float, float]:
    """Slope and offset of the straight line through the curve at both ends of y."""
    ends = [_curve(model, y) for y in (low, high)]
    slope = (ends[1] - ends[0]) / (high - low)
    return slope, ends[0] - slope * low


def _curve(model: DirectInverse, y: float) -> float:
    """The curve at y, scheduling variables from outside in the middle of their ranges."""
    values = [float(np.polynomial.polynomial.polyval(y - model.center, row)) for row in model.polynomial]
    if not model.schedules:
        return values[0]
    total = 0.0
    for schedule, (below, above) in zip(model.schedules, zip(values[::2], values[1::2], strict=True), strict=True):
        xi = 0.5 if schedule.outside else float(np.clip((y - schedule.low) / (schedule.high - schedule.low), 0.0, 1.0))
        total += (1 - xi) * below + xi * above
    return total
