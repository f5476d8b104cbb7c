"""Models as blocks of the core: parameters handed over, and the block of a sum of plays with its limits."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models._arrays import parameter_number
from dehyst.models._card import SignalCard

if TYPE_CHECKING:
    from dehyst.models._base import HysteresisModel

Direction: TypeAlias = Literal["inverse", "forward"]


@dataclass(frozen=True)
class Machine:
    """A block of the core.

    Attributes
    ----------
    native
        The block, with its memory.
    parameters
        What it was made of: what an exporter prints.
    input, output
        Signals with limits.
    more
        Further inputs in their order.
    slots
        How many of these a step of the core takes; those that are not used are 0.
    defaults
        Values of those that need not be given.
    period
        Between two samples, of what is made for one. [s]
    timed
        Whether answers depend on it.
    saved
        Whether the state has an image.
    observes
        Whether its memory can follow what something else applied to the actuator.
    """

    native: Any
    parameters: Any
    input: SignalCard
    output: SignalCard
    more: tuple[SignalCard, ...] = ()
    slots: int = 0
    defaults: Mapping[str, float] = field(default_factory=dict)
    period: float = 0.0
    timed: bool = False
    saved: bool = True
    observes: bool = False


def declared_range(card: SignalCard, bounds: tuple[float, float] | None) -> tuple[float, float]:
    """Return the range of the actuator's input: `bounds`, or those of its signal; refuse what is none."""
    if bounds is None:
        if card.low is None or card.high is None:
            raise ParameterError(
                f"the range of {card.label} is not known: this model was not identified from a log. Without it a block "
                f"has no limits; pass range=(low, high), what the actuator can be given (in a terminal: --range LO HI)."
            )
        bounds = (card.low, card.high)
    try:
        low, high = bounds
    except (TypeError, ValueError):
        raise ParameterError(
            f"range = {bounds!r:.60} is no pair of numbers; pass range=(low, high)."
        ) from None
    low, high = parameter_number(low, "range[0]"), parameter_number(high, "range[1]")
    if not low < high:
        raise ParameterError(
            f"range = ({low:g}, {high:g}) holds no input to move in; pass the smallest first, then the largest (in a "
            f"terminal: --range LO HI).",
            low=low,
            high=high,
        )
    return low, high


_NO_MAP = np.zeros(0)
EPS = float(np.finfo(np.float64).eps)
EPS_FLOAT = float(np.finfo(np.float32).eps)


@dataclass(frozen=True)
class Operator:
    """Parameters of a model y = after(H[before(x)]) as its stepper shows them."""

    thresholds: Array
    weights: Array
    center: float
    offset: float
    before_u: Array
    before_v: Array
    after_u: Array
    after_v: Array
    start: Array

    def before(self, low: float, high: float) -> tuple[float, float]:
        """Range of the argument of H while the input stays within low..high."""
        return _mapped(self.before_u, self.before_v, low, high)

    def after(self, low: float, high: float) -> tuple[float, float]:
        """Range of the output while H stays within low..high."""
        return _mapped(self.after_u, self.after_v, low, high)

    def in_front_of_after(self, low: float, high: float) -> tuple[float, float]:
        """Range of H for which the output stays within low..high."""
        u, v = self.after_u, self.after_v
        # The inverse of a falling map has to be listed backwards, as arguments increase.
        if v.size and v[-1] < v[0]:
            u, v = u[::-1], v[::-1]
        return _mapped(v, u, low, high)

    def reached(self, low: float, high: float) -> tuple[float, float]:
        """Smallest and largest H while the input stays within low..high, over all histories; also before the first.

        Let all S_i = w_1 + ... + w_i have one sign, say S_i >= 0. Then H rises with its input from any state, so that
        the largest value is taken at the upper end x = b of the range. There

            z_i = max(b - r_i, min(z_i at the start, m + r_i))

        whatever happened between, m the smallest input so far: H is piecewise linear in m, and its largest value
        lies at one of the bends, m = z_i - r_i or m = b - 2 r_i, or at an end. So it is found by a few steps. With
        S_i of both signs (such a model has no inverse) bounds that need not be reached are returned.
        """
        a, b = (x - self.center for x in self.before(low, high))
        slopes = np.cumsum(self.weights)
        if np.any(slopes > 0) and np.any(slopes < 0):
            return self._bounds(a, b, slopes)
        r, z = self.thresholds, self.start
        down_bends = up_bends = np.zeros(0)
        # With weights of one sign the largest value lies at an end: no bend has to be tried.
        if np.any(self.weights < 0) and np.any(self.weights > 0):
            down_bends = np.concatenate([z - r, b - 2 * r])
            up_bends = np.concatenate([z + r, a + 2 * r])
        down = _between(a, b, down_bends)[::-1]
        up = _between(a, b, up_bends)
        step = _native.Stepper(
            r, self.weights, 0.0, self.offset, _NO_MAP, _NO_MAP, _NO_MAP, _NO_MAP, z
        )
        values = [step.output]
        for end, turns in ((b, down), (a, up)):
            step.reset()
            values.append(step(end))
            for turn in turns.tolist():
                values += [step(turn), step(end)]
        return min(values), max(values)

    def _bounds(self, a: float, b: float, slopes: Array) -> tuple[float, float]:
        """Bounds of H from those of its states and of their differences, |z_i - z_{i+1}| <= r_{i+1} - r_i."""
        r, z = self.thresholds, self.start
        bottom, top = np.minimum(z, a + r), np.maximum(z, b - r)
        w = self.weights
        by_states = (np.minimum(w * bottom, w * top).sum(), np.maximum(w * bottom, w * top).sum())
        cells = float(np.abs(slopes[:-1]) @ np.diff(r))
        last = sorted((float(slopes[-1] * bottom[-1]), float(slopes[-1] * top[-1])))
        low, high = max(by_states[0], last[0] - cells), min(by_states[1], last[1] + cells)
        return self.offset + float(low), self.offset + float(high)

    def widened(
        self, low: float, high: float, bottom: float, top: float, eps: float = EPS
    ) -> tuple[float, float]:
        """Range of the output for H within bottom .. top and inputs within low..high, and what rounding may add."""
        more = self.rounding(low, high, eps)
        lowest, highest = self.after(bottom - more, top + more)
        if not self.after_u.size:
            return lowest, highest
        # The map rounds once more.
        last = max(abs(lowest), abs(highest)) * 8 * eps
        return lowest - last, highest + last

    def rounding(self, low: float, high: float, eps: float = EPS) -> float:
        """Bound of the rounding of H by a step while the input stays within low..high, eps that of the precision."""
        r, slopes = self.thresholds, np.cumsum(self.weights)
        largest = max(abs(x - self.center) for x in self.before(low, high))
        states = largest + float(r[-1] + np.max(np.abs(self.start)))
        cells = float(np.abs(slopes[:-1]) @ np.diff(r))
        size = abs(self.offset) + cells + abs(float(slopes[-1])) * states
        # The edge cell is a difference of states.
        size += float(np.max(np.abs(slopes))) * states
        return 4 * (r.size + 4) * eps * size


def _between(a: float, b: float, bends: Array) -> Array:
    return np.unique(np.clip(np.append(bends, [a, b]), a, b))


def _mapped(u: Array, v: Array, low: float, high: float) -> tuple[float, float]:
    if u.size == 0:
        return low, high
    ends = _native.map_values(
        np.ascontiguousarray(u), np.ascontiguousarray(v), np.array([low, high])
    )
    return float(ends.min()), float(ends.max())


@dataclass(frozen=True, eq=False)
class BlockParameters:
    """Parameters of a block with the bits that are used: what an exporter prints.

    Attributes
    ----------
    threshold, slope, loading
        r, S_i = w_1 + ... + w_i and phi_i = sum_{j<i} S_j (r_{j+1} - r_j) of the operator H, (n,). [argument of H],
        [output of H / argument], [output of H]
    center, offset
        Subtracted from the argument of H, added to its output. [argument of H], [output of H]
    before_u, before_v, after_u, after_v
        Breakpoints and values of the maps in front of H and behind it; of size 0 if there is none.
    start
        Play states after a reset, (n,). [argument of H]
    input_low, input_high, output_low, output_high
        Limits. [input], [output]
    reach_low, reach_high
        Limits of the output in front of the last map, where the input is held back; those of a forward block, which
        never does that, are the largest numbers that are taken. [output of H]
    line_slope, line_offset
        Of the straight line that answers while the block is off. [output/input], [output]
    fade
        Share of a switching that one sample makes.
    fingerprint
        First 32 bits of the SHA-256 of the model: states of another one are refused.
    """

    threshold: Array
    slope: Array
    loading: Array
    center: float
    offset: float
    before_u: Array
    before_v: Array
    after_u: Array
    after_v: Array
    start: Array
    input_low: float
    input_high: float
    output_low: float
    output_high: float
    reach_low: float
    reach_high: float
    line_slope: float
    line_offset: float
    fade: float
    fingerprint: int


def play_machine(
    model: HysteresisModel, direction: Direction, range: tuple[float, float] | None, ramp: int
) -> Machine:
    """Return the block of the core."""
    low, high = declared_range(model.card.input, range)
    operator = started_machine(model, low, high) if direction == "inverse" else model
    native = _native.Block(_image(model, operator, low, high, ramp))
    p, card = _parameters(native), operator.card
    return Machine(
        native, p, replace(card.input, low=p.input_low, high=p.input_high),
        replace(card.output, low=p.output_low, high=p.output_high),
    )  # fmt: skip


def _of(model: HysteresisModel) -> Operator:
    return Operator(*model.stepper("dense").parameters)


def started_machine(model: HysteresisModel, low: float, high: float) -> HysteresisModel:
    """Return the inverse of the model, started where an actuator is that was brought into its range."""
    inverse = model.inverse()
    # A start outside the range would be one that the actuator can never be in.
    first = inverse.stepper("dense").output
    if low <= first <= high:
        return inverse
    return model.with_state(model.final_state([min(max(first, low), high)])).inverse()


def _fingerprint(operator: Operator) -> int:
    digest = hashlib.sha256()
    for entry in fields(operator):
        # The start state does not count: a block of the same model may begin elsewhere.
        if entry.name != "start":
            values = np.atleast_1d(np.asarray(getattr(operator, entry.name), dtype="<f8"))
            digest.update(struct.pack("<Q", values.size) + values.tobytes())
    return int.from_bytes(digest.digest()[:4], "big")


def _image(
    model: HysteresisModel, stepped: HysteresisModel, low: float, high: float, ramp: int
) -> npt.NDArray[np.uint32]:
    plant, operator = _of(model), _of(stepped)
    bottom, top = plant.reached(low, high)
    reached = plant.after(bottom, top)
    slope, offset = _secant(model, low, high)
    if stepped is model:
        # Reached in exact arithmetic; what rounding adds must not be cut off. A forward block never holds its input
        # back: the actuator did get it, and on a branch that is nearly flat the point to stop at would be anywhere.
        limits = [
            low,
            high,
            *plant.widened(low, high, bottom, top),
            -_native.INPUT_LIMIT,
            _native.INPUT_LIMIT,
        ]
    else:
        limits = [*reached, low, high, *operator.in_front_of_after(low, high)]
    o = operator
    try:
        if stepped is not model:
            slope, offset = 1 / slope, -offset / slope
        of_model = (
            o.thresholds,
            o.weights,
            o.center,
            o.offset,
            o.before_u,
            o.before_v,
            o.after_u,
            o.after_v,
            o.start,
        )
        image = _native.block_image(
            *of_model, [*limits, slope, offset, 1 / ramp], _fingerprint(operator)
        )
        _native.Block(image)
    except (ValueError, ZeroDivisionError, OverflowError):
        raise ParameterError(
            f"no block can be made of this model for inputs from {low:g} to {high:g}: some of its numbers is beyond "
            f"{_native.INPUT_LIMIT:g}, or its start state is one that no input leaves. Scale its signals to a unit of "
            f"their size, and take the state from model.final_state(x)."
        ) from None
    return image


def _secant(model: HysteresisModel, low: float, high: float) -> tuple[float, float]:
    """Slope and offset of the straight line through the ends of the model's full loop."""
    # The first visit of the lower end only leaves the start state behind.
    step = model.stepper("dense")
    _, top, bottom = step(low), step(high), step(low)
    slope = (top - bottom) / (high - low)
    return slope, bottom - slope * low


def _parameters(native: _native.Block) -> BlockParameters:
    values = native.parameters
    for value in values.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return BlockParameters(**values)
