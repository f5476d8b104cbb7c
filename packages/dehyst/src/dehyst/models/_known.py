"""Finds the memory that agrees with samples of input and output, so that a model runs on from there.

What an actuator did before the first of these samples is taken to be a few strokes: from an end of the range to a, to
b, and to the first input (or from rest at s, if it never moved before). Their turning points are those with the least
error over the samples: first the best of a grid, then by Gauss-Newton steps. So the memory is always one that the model
can have, for every family; samples that move far enough make it certain whatever came before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import DehystError, ParameterError
from dehyst.models._arrays import signal_array
from dehyst.models._policy import POLICY

if TYPE_CHECKING:
    from dehyst.models._model import Model

M = TypeVar("M", bound="Model")
TURNS = 9  # turning points that are tried on either side of the first input
STROKE = 24  # samples of a stroke before the first sample
REFINED = 4  # of the best pasts
MOST_TURNS = 8  # of a past
WITHIN = (
    0.15,
    0.4,
    0.7,
)  # where a further turn is tried, between the last sample and the turn before the last
STEPS = 12  # of Gauss-Newton
ROUNDING = 1e-10  # of the range of the output
NEAR = 1e-6  # of half the range: the step of a difference quotient
SHORTER = (1.0, 0.5, 0.2, 0.05)  # steps that are tried


@dataclass(frozen=True)
class KnownPast(Generic[M]):
    """A model that runs on after samples of input and output.

    Attributes
    ----------
    model, before
        Begun with the memory behind the last sample, and with that before the first one.
    error
        Of its answer over these samples, rms; not a number if only the input was known. [output]
    turns
        Inputs between which the strokes before the first sample went; empty if only the input was known. [input]
    strokes
        Samples of these strokes, from rest at the first turn, (S,); one as long after the other as the known samples.
        [input]
    """

    model: M
    before: M
    error: float
    turns: tuple[float, ...]
    strokes: Array = field(repr=False, compare=False)
    _apart: Callable[[], float] = field(repr=False, compare=False)

    @cached_property
    def doubt(self) -> float:
        """By how much its next answers may be off, as other pasts explain these samples nearly as well. [output]"""
        return self._apart()


@dataclass(frozen=True)
class _Window(Generic[M]):
    """The known samples, and how a model is led to them."""

    model: M
    x: Array
    y: Array
    time: Array | None
    signals: Mapping[str, Array]
    resting: dict[float, M] = field(default_factory=dict)

    def at_rest(self, first: float) -> M:
        """Return the model at rest at an input; the same one each time, as it keeps what it is made of."""
        if first not in self.resting:
            self.resting[first] = self.model.at_rest(first)
        return self.resting[first]

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the range where turning points may lie. [input]"""
        low, high = self.model.ends
        beyond = POLICY.past_beyond * (high - low)
        return min(low - beyond, float(self.x.min())), max(high + beyond, float(self.x.max()))

    def led(self, turns: Array) -> tuple[M, Array]:
        """Return the model at rest at the first turn, and the inputs from there to the last known sample."""
        parts = []
        for begin, end in zip(turns, [*turns[1:], self.x[0]], strict=True):
            parts.append(np.linspace(begin, end, STROKE, endpoint=False))
        return self.at_rest(float(turns[0])), np.concatenate([*parts, self.x])

    def before(self, size: int) -> tuple[Array | None, dict[str, Array]]:
        """Return time and signals of `size` more samples in front: as fast as the known ones, the signals held."""
        signals = {}
        for name, values in self.signals.items():
            signals[name] = np.concatenate([np.full(size, values[0]), values])
        if self.time is None:
            return None, signals
        step = self.model.period or 1.0
        if self.time.size > 1:
            step = float(np.median(np.diff(self.time)))
        early = self.time[0] - step * np.arange(size, 0, -1)
        return np.concatenate([early, self.time]), signals

    def answer(self, turns: Array) -> Array:
        """Return the output at the known samples after strokes between turns, (T,)."""
        model, x = self.led(turns)
        time, signals = self.before(x.size - self.x.size)
        try:
            return model.simulate(x, time, **signals)[x.size - self.x.size :]
        except DehystError:
            return np.full(self.x.size, np.nan)

    def error(self, turns: Array) -> float:
        """Return the rms error over the samples whose output is known; infinite where the model diverges."""
        miss = (self.answer(turns) - self.y)[np.isfinite(self.y)]
        square = float(np.mean(miss**2))
        return float(np.sqrt(square)) if np.isfinite(square) else float("inf")


def known_past(
    model: M,
    x: npt.ArrayLike,
    y: npt.ArrayLike | None = None,
    time: npt.ArrayLike | None = None,
    signals: Mapping[str, npt.ArrayLike] | None = None,
) -> KnownPast[M]:
    """Return the model that runs on after known samples.

    Parameters
    ----------
    model
        Of any family with a memory of its input.
    x
        Input, (T,), one sample or more. [input]
    y
        Measured output, (T,), NaN where it is not known; None for an input alone, which moves the model's own memory.
        [output]
    time
        (T,), needed where the model depends on time. [s]
    signals
        What `model.needs` names, (T,) or a number each.

    Raises
    ------
    ParameterError
        If the lengths differ, no output is known, or the model remembers what was measured.

    Examples
    --------
    >>> import numpy as np
    >>> from dehyst import PrandtlIshlinskii
    >>> plays = PrandtlIshlinskii([0.0, 0.5, 1.0], [1.0, 0.5, 0.5])
    >>> x = np.array([3.0, -3.0, 1.0, 0.2, 0.4, 0.9, 0.1])
    >>> y = plays.at_rest(0.0).simulate(x)
    >>> begun = known_past(plays, x[3:6], y[3:6]).model
    >>> bool(np.isclose(begun.simulate(x[6:])[0], y[6], atol=1e-9))
    True
    """
    window = _checked(model, x, y, time, signals or {})
    if _first_moved(window) is None:
        raise ParameterError(
            f"the memory of this {model.family} model is of what was measured, and cannot be told from outside. "
            f"Identify a row of elements from the same log (leave --family out)."
        )
    if y is None:
        time_stamps, given = window.before(0)
        moved = _moved(model, window.x, time_stamps, given)
        return KnownPast(moved, model, float("nan"), (), np.zeros(0), float)
    tried: list[tuple[float, int, Array]] = []
    for turns in _pasts(window):
        tried.append((window.error(turns), turns.size, turns))
    tried.sort(key=lambda past: past[:2])
    height = _height(model)
    refined = []
    for error, _, turns in tried[:REFINED]:
        error, turns = _longer(window, *_refined(window, turns, error))
        refined.append((error, turns, turns.size))
    least = min(past[0] for past in refined)
    # Of pasts that explain the samples alike, the one with the fewest turns.
    alike = POLICY.past_alike * least + ROUNDING * height
    error, turns, _ = min(
        (past for past in refined if past[0] <= least + alike or past[0] == least),
        key=lambda past: past[2],
    )
    if not np.isfinite(error):
        raise ParameterError(
            f"no past of this {model.family} model leads to finite outputs at these samples. Give samples within its "
            f"range, {model.ends[0]:g} to {model.ends[1]:g} at its input."
        )
    begun = _begun(window, turns)
    limit = POLICY.past_doubt * error + POLICY.past_open * height
    others = [past[2] for past in tried if past[0] <= limit]
    apart = partial(_doubt, window, begun, others)
    strokes = window.led(turns)[1][: -window.x.size]
    return KnownPast(begun, _led(window, turns), error, tuple(turns.tolist()), strokes, apart)


def _checked(
    model: M,
    x: npt.ArrayLike,
    y: npt.ArrayLike | None,
    time: npt.ArrayLike | None,
    signals: Mapping[str, npt.ArrayLike],
) -> _Window[M]:
    """Return the known samples, or refuse them."""
    inputs = signal_array(x, "input x")
    outputs = np.full(inputs.size, np.nan)
    if y is not None:
        outputs = np.asarray(y, dtype=np.float64)
    stamps = None
    if time is not None:
        stamps = signal_array(time, "time")
    if (
        not inputs.size
        or outputs.shape != inputs.shape
        or (stamps is not None and stamps.shape != inputs.shape)
    ):
        raise ParameterError(
            f"the known samples have {inputs.size} inputs, {outputs.size} outputs and "
            f"{'no' if stamps is None else stamps.size} time stamps. Give one of each for every sample."
        )
    if not np.isfinite(inputs).all():
        raise ParameterError(
            "an input of the known samples is not finite. Give the samples from a gap on."
        )
    if y is not None and not np.isfinite(outputs).any():
        raise ParameterError(
            "none of the known outputs is a finite number. Give them, or leave them out: the memory is then that of "
            "the model, moved by the input."
        )
    if model.rate_dependent and stamps is None:
        raise ParameterError(
            f"a {model.family} model depends on time, and the known samples have no time stamps. Give them, too (in a "
            f"terminal: --time COLUMN)."
        )
    return _Window(model, inputs, outputs, stamps, model.given(signals, inputs.size))


def _pasts(window: _Window[M]) -> Iterator[Array]:
    """Yield turning points of pasts: what an actuator in use did, then what one did that hardly moved."""
    low, high = window.ends
    first = float(window.x[0])
    above = np.linspace(first, high, TURNS + 1)[1:]
    below = np.linspace(first, low, TURNS + 1)[1:]
    for a in above:
        yield np.array([high, low, a])
        for b in below:
            yield np.array([high, low, a, b])
    for b in below:
        yield np.array([low, high, b])
        for a in above:
            yield np.array([low, high, b, a])
    for s in (*above, *below):
        yield np.array([s])
    yield np.array([first])


def _refined(window: _Window[M], turns: Array, error: float) -> tuple[float, Array]:
    """Return the error and turning points of a past after Gauss-Newton steps; its first two stay at the ends."""
    low, high = window.ends
    step = NEAR * (high - low)
    free = np.arange(min(2, turns.size - 1), turns.size)
    counted = np.isfinite(window.y)
    for _ in range(STEPS):
        answer = window.answer(turns)
        columns = []
        for k in free:
            other = turns.copy()
            # Away from an end, so that the other point lies within the range, too.
            other[k] += step if turns[k] < 0.5 * (low + high) else -step
            columns.append((window.answer(other) - answer) / (other[k] - turns[k]))
        slopes = np.stack(columns, axis=1)[counted]
        if not (np.isfinite(slopes).all() and np.isfinite(answer[counted]).all()):
            break
        move = np.linalg.lstsq(slopes, (window.y - answer)[counted], rcond=1e-9)[0]
        nearer = None
        for share in SHORTER:
            other = turns.copy()
            other[free] = np.clip(turns[free] + share * move, low, high)
            of_other = window.error(other)
            if of_other < error:
                nearer = of_other, other
                break
        if nearer is None:
            break
        error, turns = nearer
    return error, turns


def _longer(window: _Window[M], error: float, turns: Array) -> tuple[float, Array]:
    """Return error and turns of a past with more turns within its last stroke, as long as each clearly helps."""
    while 1 < turns.size < MOST_TURNS:
        last = float(window.x[0])
        candidates = []
        for share in WITHIN:
            # The stroke before the last one bounds what a further turn can be.
            turn = last + share * (turns[-2] - last)
            longer = np.append(turns, turn)
            candidates.append((window.error(longer), longer))
        best_error, longer = min(candidates, key=lambda past: past[0])
        best_error, longer = _refined(window, longer, best_error)
        if not best_error < POLICY.past_further_turn * error:
            break
        error, turns = best_error, longer
    return error, turns


def _begun(window: _Window[M], turns: Array) -> M:
    """Return the model with the memory behind the last known sample."""
    model, x = window.led(turns)
    time, signals = window.before(x.size - window.x.size)
    return _moved(model, x, time, signals)


def _led(window: _Window[M], turns: Array) -> M:
    """Return the model with the memory before the first known sample."""
    model, x = window.led(turns)
    size = x.size - window.x.size
    time, signals = window.before(size)
    early = slice(0, size)
    given = {name: values[early] for name, values in signals.items()}
    return _moved(model, x[early], None if time is None else time[early], given)


def _first_moved(window: _Window[M]) -> Any:
    """Return the model with the memory behind the first sample; None where memory is of what was measured."""
    first = {name: values[:1] for name, values in window.signals.items()}
    return window.model.moved(
        window.x[:1], None if window.time is None else window.time[:1], **first
    )


def _moved(model: M, x: Array, time: Array | None, signals: Mapping[str, Array]) -> M:
    """Return the model with the memory behind an input."""
    moved: Any = model.moved(x, time, **signals)
    return moved  # type: ignore[no-any-return]


def _doubt(window: _Window[M], begun: M, others: list[Array]) -> float:
    """Return how far answers after other pasts lie from those of the model, on a stroke to either end of the range."""
    low, high = window.model.ends
    last = float(window.x[-1])
    x = np.concatenate([np.linspace(last, high, STROKE), np.linspace(high, low, 2 * STROKE)[1:]])
    signals = {name: values[-1] for name, values in window.signals.items()}
    time = None
    if window.time is not None:
        step = window.model.period or 1.0
        time = window.time[-1] + step * np.arange(1.0, x.size + 1)
    answer = begun.simulate(x, time, **signals)
    apart = 0.0
    for turns in others:
        other = _begun(window, turns).simulate(x, time, **signals)
        apart = max(apart, float(np.max(np.abs(other - answer))))
    return apart


def _height(model: Model) -> float:
    """Return the range of the output, or of what the model answers over its range. [output]"""
    card = model.card.output
    if card.low is not None and card.high is not None:
        return float(card.high - card.low)
    ends = np.array(model.ends)
    time = None
    if model.rate_dependent:
        time = np.array([0.0, 1.0])
    signals = {
        card.name: 0.5 * (float(card.low or 0.0) + float(card.high or 0.0))
        for card in model.context
    }
    return float(np.ptp(model.simulate(ends, time, **signals)))
