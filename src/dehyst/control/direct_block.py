"""A direct inverse as a function block of a machine: bounded, switched without a bump."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst.errors import ParameterError
from dehyst.models import DirectInverse
from dehyst.models.arrays import parameter_number, signal_array
from dehyst.models.card import SignalCard

Array = npt.NDArray[np.float64]
Words = npt.NDArray[np.uint32]

_LONGEST_RAMP = 10**9
BEYOND = 1e14  # no limit of a signal lies there
_LIMITS = 8  # place of center, input low and high, output low and high among the parameters


class DirectBlock:
    r"""A direct inverse as a function block: what runs on a machine, and what is exported.

    .. math::

        u = s \, D[y] + (1 - s)(a + b y), \qquad u_0 \le u \le u_1

    D is the direct inverse, s the share of it (1 on, 0 off), a + b y the straight line through its curve at both ends
    of the identified range, scheduling variables from outside in the middle of theirs.

    The first good sample begins at rest at its y. A sample with a number that is not finite is rejected: the last good
    output is held, nothing moves, a flag rises. `on` may change at any sample: s runs from 0 to 1 or back in `ramp`
    samples; the memory follows y in either case. While it is on and not fading, outputs have the bits of the core's
    direct inverse with these limits.

    Parameters
    ----------
    model
        Identified: y of the actuator in, its input u out.
    period
        Between two samples. [s]
    range
        Smallest and largest u that the actuator can be given; None takes the range in which the model was identified.
        [u]
    ramp
        Samples that switching takes, at least 1.

    Raises
    ------
    ParameterError
        If `model` is no direct inverse, a range is not known, or a setting makes no sense.

    Examples
    --------
    >>> from dehyst.models import ModelCard, SignalCard
    >>> card = ModelCard(SignalCard("p", "bar", -2.0, 2.0), SignalCard("x", "mm", -1.0, 1.0))
    >>> model = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0], card=card)
    >>> block = DirectBlock(model, period=1e-3)
    >>> [block.step(0.0), block.step(1.0), block.step(0.0), block.step(float("nan"))]
    [0.0, 2.0, -1.0, -1.0]
    """

    def __init__(
        self, model: DirectInverse, period: float, range: tuple[float, float] | None = None, ramp: int = 500
    ) -> None:
        if not isinstance(model, DirectInverse):
            raise ParameterError(
                f"a DirectBlock runs a DirectInverse, not {type(model).__name__}; a Block runs other models."
            )
        if isinstance(ramp, bool) or not isinstance(ramp, int | np.integer) or not 1 <= ramp <= _LONGEST_RAMP:
            raise ParameterError(
                f"the ramp takes {ramp!r:.40} samples; pass a whole number, 1 to {_LONGEST_RAMP}.", ramp=ramp
            )
        self.model = model
        self.period = parameter_number(period, "period")
        self.ramp = int(ramp)
        self.input = _ranged(model.card.output, None, "output", "y")
        self.output = _ranged(model.card.input, range, "input", "u")
        self.parameters: tuple[Any, ...] = self._parameters()
        self.line_slope, self.line_offset = _line(model, float(self.input.low or 0.0), float(self.input.high or 0.0))
        self.fade = 1.0 / self.ramp
        self._native = _native.DirectBlock(self.parameters, self.line_slope, self.line_offset, self.fade)

    def _parameters(self) -> tuple[Any, ...]:
        told = list(self.model.parameters(self.period))
        limits = [self.model.center, self.input.low, self.input.high, self.output.low, self.output.high]
        told[_LIMITS] = np.array(limits, float)
        return tuple(told)

    @property
    def given(self) -> tuple[str, ...]:
        """Names of the scheduling variables from outside, in their order."""
        return tuple(schedule.name for schedule in self.model.outside)

    @property
    def share(self) -> float:
        """Present share of the inverse in the output: 0 off, 1 on."""
        return self._native.share

    @property
    def last(self) -> float:
        """Last good output. [u]"""
        return self._native.output

    @property
    def flags(self) -> int:
        """Sum of the bits in `BLOCK_FLAGS` after the last sample."""
        return self._native.flags

    @property
    def doubt(self) -> float:
        """Guaranteed half width of D for the unknown past. [u]"""
        return self._native.doubt

    def step(
        self, y: float | None, rate: float | None = 0.0, given: Mapping[str, float] | None = None, on: bool = True
    ) -> float:
        """Return u for the next sample.

        Parameters
        ----------
        y, rate
            Wanted output and its rate; None, for a sensor without an answer, is a rejected sample. [y], [y/s]
        given
            Scheduling variables from outside by name.
        on
            Whether the inverse answers; otherwise the straight line does.

        Raises
        ------
        ParameterError
            If one of them is no number, or a scheduling variable is missing.
        """
        told = given or {}
        self._refuse_missing(told)
        try:
            values = [float("nan") if x is None else float(x) for x in (y, rate, *(told[name] for name in self.given))]
        except (TypeError, ValueError, OverflowError):
            raise ParameterError(
                "a sample is one number each, or None for a sensor without an answer. Whole signals go through run()."
            ) from None
        first, second = [*values[2:], 0.0, 0.0][:2]
        return self._native.step(values[0], values[1], first, second, bool(on))

    def run(
        self,
        y: npt.ArrayLike,
        rate: npt.ArrayLike = 0.0,
        given: Mapping[str, npt.ArrayLike] | None = None,
        on: npt.ArrayLike = True,
    ) -> tuple[Array, Words]:
        """Return outputs and flags of many samples, going on from the present state.

        Parameters
        ----------
        y
            Wanted outputs, (T,). [y]
        rate
            Their rates, (T,) or one for all. [y/s]
        given
            Scheduling variables from outside by name, (T,) or a number each.
        on
            Whether the inverse answers, (T,) or one value for all.

        Returns
        -------
        u : (T,)
            Outputs, with the bits of `step`. [u]
        flags : (T,)
            Sums of the bits in `BLOCK_FLAGS`.

        Raises
        ------
        ParameterError
            If lengths differ, values are no numbers, or a scheduling variable is missing.
        """
        told = given or {}
        self._refuse_missing(told)
        samples = signal_array(y, "y")
        table = np.zeros((samples.size, 2))
        for column, name in enumerate(self.given):
            table[:, column] = along(told[name], samples.size, name)
        switches = along(on, samples.size, "on") != 0
        return self._native.run(samples, along(rate, samples.size, "rate"), table, switches)

    def answer(self, inputs: Array, on: npt.ArrayLike) -> tuple[Array, Words]:
        """Return outputs and flags (T,) for all inputs in their order: y, rate and those of `given`, (T, m)."""
        given = {name: inputs[:, 2 + k] for k, name in enumerate(self.given)}
        return self.run(inputs[:, 0], inputs[:, 1], given, on)

    def reset(self) -> None:
        """Forget everything, flags cleared; the next good sample begins at rest and switches at once."""
        self._native.reset()

    def _refuse_missing(self, given: Mapping[str, Any]) -> None:
        missing = [name for name in self.given if name not in given]
        if missing:
            raise ParameterError(
                f"the model depends on '{missing[0]}', which was not given. Pass given={{'{missing[0]}': value}}."
            )

    def __repr__(self) -> str:
        """One line: signals and their limits."""
        return f"<DirectBlock: {self.input!s} -> {self.output!s}, every {self.period:g} s>"


def along(values: npt.ArrayLike, samples: int, name: str) -> Array:
    """One value for all samples, or one each, as (T,)."""
    array = np.asarray(values)
    if array.dtype.kind not in "biuf" or array.shape not in ((), (samples,)):
        raise ParameterError(
            f"{name} has shape {array.shape} and type {array.dtype} for {samples} samples; pass a number a sample, or "
            f"one for all."
        )
    return np.ascontiguousarray(np.broadcast_to(array.astype(np.float64), (samples,)))


def _ranged(card: SignalCard, range: tuple[float, float] | None, what: str, name: str) -> SignalCard:
    """The signal with limits: those given, or those of the identification."""
    low, high = (card.low, card.high) if range is None else range
    if low is None or high is None:
        more = ", or pass --range LO HI (in Python range=(low, high)), what the actuator can be given"
        raise ParameterError(
            f"the model does not say from where to where its {what} {card.label} goes, and without that a unit has no "
            f"limits. Identify it from a log{more if what == 'input' else ''}."
        )
    low, high = parameter_number(low, "lower limit"), parameter_number(high, "upper limit")
    if not low < high or max(abs(low), abs(high)) > BEYOND:
        raise ParameterError(
            f"{what} {card.label} goes from {low:g} to {high:g}, which is no range. Pass --range LO HI with LO < HI, "
            f"both within {BEYOND:g}.",
            low=low,
            high=high,
        )
    return replace(card, name=card.name or name, low=low, high=high)


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
