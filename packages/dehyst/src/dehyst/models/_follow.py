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
from dehyst.models._card import SignalCard
from dehyst.models._machine import Direction, Machine, declared_range
from dehyst.models._policy import POLICY

if TYPE_CHECKING:
    from dehyst.models._direct import DirectInverse

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
    signals: Mapping[str, Array] | None = None,
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
    signals
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
    # A motion that rises to its first sample went to the upper end and to the lower one before.
    past = {"rising": (high, low), "falling": (low, high)}.get(start, ())
    lowest, highest, path = _memory(model, past)
    factors = _factors(model, signals or {}, inputs.size)
    first = _first(model, float(inputs[0]), past, start, factors)
    # Sets whose factor the core computes itself, from the output: 1 the lower end, 2 the upper one, 0 all others.
    kinds = [0] * model.sets
    ends = (0.0, 1.0)
    for v, schedule in enumerate(model.schedules):
        if not schedule.outside:
            kinds[2 * v : 2 * v + 2] = 1, 2
            ends = (schedule.low, schedule.high)
    lowest, highest = _begin(lowest, highest, past, first, start)
    return Followed(
        *_native.direct_forward(
            inputs,
            None if time is None else np.ascontiguousarray(time, dtype=np.float64),
            factors,
            first,
            np.clip(lowest, first - model.radii, first + model.radii),
            np.clip(highest, first - model.radii, first + model.radii),
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
            low - POLICY.followed_beyond * (high - low),
            high + POLICY.followed_beyond * (high - low),
        )
    )


def _range(model: DirectInverse) -> tuple[float, float]:
    card = model.card.output
    if card.low is None or card.high is None:
        raise ParameterError(model.no_forward)
    return card.low, card.high


def _memory(model: DirectInverse, past: tuple[float, ...]) -> tuple[Array, Array, Array]:
    """Return the lowest and highest plays, and the path lags, after the turning points of the past."""
    r, path = model.radii, np.zeros(model.path_lengths.size)
    if not past:
        return -r, np.array(r), path
    lowest = highest = np.full(r.size, past[0])
    before = past[0]
    for turn in past:
        lowest = np.clip(lowest, turn - r, turn + r)
        highest = np.clip(highest, turn - r, turn + r)
        path = _toward(model, path, turn - before)
        before = turn
    return lowest, highest, path


def _begin(
    lowest: Array, highest: Array, past: tuple[float, ...], first: float, start: str
) -> tuple[Array, Array]:
    """Return the states before the first sample: of the past, or around the first sample itself."""
    if past:
        return lowest, highest
    if start == "rest":
        return np.full(lowest.size, first), np.full(lowest.size, first)
    return first + lowest, first + highest


def _toward(model: DirectInverse, path: Array, way: float) -> Array:
    """Return the path lags after a way: they forget exponentially what was before."""
    end = np.where(way < 0.0, -model.path_lengths, model.path_lengths)
    fade = np.array([_native.decay(abs(way) / x) for x in model.path_lengths])
    moved: Array = end + fade * (path - end)
    return moved


def _walked(model: DirectInverse, path: Array, past: tuple[float, ...], first: float) -> Array:
    return _toward(model, path, first - past[-1]) if past else path


def _factors(model: DirectInverse, signals: Mapping[str, Array], size: int) -> Array | None:
    """Return the factors of sets (T, sets) that come from outside, 1 for all others; None if there are none."""
    if not model.outside:
        return None
    factors = np.ones((size, model.sets))
    for v, schedule in enumerate(model.schedules):
        if schedule.outside:
            sigma = np.asarray(signals[schedule.name])
            xi = np.clip((sigma - schedule.low) / (schedule.high - schedule.low), 0.0, 1.0)
            factors[:, 2 * v] = 1.0 - xi
            factors[:, 2 * v + 1] = xi
    return factors


def _first(
    model: DirectInverse, u: float, past: tuple[float, ...], start: str, factors: Array | None
) -> float:
    """Return the output at the first sample: the one whose needed input is closest."""
    low, high = _range(model)
    tried = np.linspace(low, high, TRIED)
    # First every 40th of them, then all around the best one.
    needed = np.array([_needed(model, y, past, start, factors) for y in tried[::40]])
    coarse = int(np.argmin(np.abs(needed - u)))
    near = tried[max(0, 40 * coarse - 40) : 40 * coarse + 41]
    needed = np.array([_needed(model, y, past, start, factors) for y in near])
    miss = needed - u
    k = int(np.argmin(np.abs(miss)))
    for j in (k - 1, k + 1):
        # The solution lies between this output and a neighbour that errs to the other side.
        if 0 <= j < near.size and miss[j] * miss[k] < 0.0:
            return float(near[k] - miss[k] * (near[j] - near[k]) / (miss[j] - miss[k]))
    return float(near[k])


def _needed(
    model: DirectInverse, y: float, past: tuple[float, ...], start: str, factors: Array | None
) -> float:
    """Return the input that an output needs at the first sample, creep and rate at rest."""
    lowest, highest, path = _memory(model, past)
    lowest, highest = _begin(lowest, highest, past, y, start)
    lowest = np.clip(lowest, y - model.radii, y + model.radii)
    highest = np.clip(highest, y - model.radii, y + model.radii)
    # A stop of which only an interval is known answers in the middle of it.
    terms = np.concatenate([y - 0.5 * (lowest + highest), _walked(model, path, past, y)])
    # Creep and rate add nothing at the first sample, where the actuator is at rest.
    weights = np.concatenate([model.stop_weights, model.path_weights], axis=1)
    share = np.ones(model.sets) if factors is None else factors[0].copy()
    for v, schedule in enumerate(model.schedules):
        if not schedule.outside:
            xi = min(max((y - schedule.low) / (schedule.high - schedule.low), 0.0), 1.0)
            share[2 * v] = 1.0 - xi
            share[2 * v + 1] = xi
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
    model: DirectInverse,
    direction: Direction,
    range: tuple[float, float] | None,
    ramp: int,
    period: float | None,
) -> Machine:
    """Return the block of the core."""
    if direction == "forward":
        raise ParameterError(
            "the model is a direct inverse: it answers which input an output needs, and there is no model of the "
            "output to run. Leave direction out (in a terminal: --what forward), or identify another family for it."
        )
    if period is None:
        period = model.period
    if not period:
        raise ParameterError(
            "the model is a direct inverse: what creeps depends on the time between two samples, which is not known "
            "here. Pass period, the seconds between two samples of your loop (in a terminal: --period SECONDS, what "
            "your target calls it with, for example --period 0.001)."
        )
    input, output = _limited(model.card.output, None, "y"), _limited(model.card.input, range, "u")
    numbers = list(model.parameters(period))
    # The block has its own limits in place of those of the model's card.
    limits = [model.center, input.low, input.high, output.low, output.high]
    numbers[_LIMITS] = np.array(limits, float)
    slope, offset = _line(model, float(input.low or 0.0), float(input.high or 0.0))
    p = DirectParameters(tuple(numbers), slope, offset, 1.0 / ramp)
    rate = SignalCard(RATE, "", None, None)
    return Machine(
        _native.DirectBlock(p.direct, p.line_slope, p.line_offset, p.fade), p, input, output, (rate, *model.context),
        1 + _native.DIRECT_GIVEN, {RATE: 0.0}, float(period), True, False,
    )  # fmt: skip


def _limited(card: SignalCard, range: tuple[float, float] | None, name: str) -> SignalCard:
    """Return the signal with limits: those of the caller, or those of the identification."""
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
    """Return slope and offset of the straight line through the curve at both ends of y."""
    at_low, at_high = _curve(model, low), _curve(model, high)
    slope = (at_high - at_low) / (high - low)
    return slope, at_low - slope * low


def _curve(model: DirectInverse, y: float) -> float:
    """Return the curve at y, scheduling variables from outside in the middle of their ranges."""
    value = np.polynomial.polynomial.polyval
    values = [float(value(y - model.center, row)) for row in model.polynomial]
    if not model.schedules:
        return values[0]
    total = 0.0
    for v, schedule in enumerate(model.schedules):
        xi = 0.5
        if not schedule.outside:
            xi = float(np.clip((y - schedule.low) / (schedule.high - schedule.low), 0.0, 1.0))
        total += (1 - xi) * values[2 * v] + xi * values[2 * v + 1]
    return total
