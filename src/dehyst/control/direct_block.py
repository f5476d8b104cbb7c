"""A direct inverse as a function block of a machine: bounded, switched without a bump."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst.arrays import Array
from dehyst.control.images import Words
from dehyst.control.machine_block import MachineBlock, along, refuse_ramp, switched
from dehyst.errors import ParameterError
from dehyst.models import DirectInverse
from dehyst.models.arrays import parameter_number, signal_array
from dehyst.models.card import SignalCard

BEYOND = 1e14  # no limit of a signal lies there
_LIMITS = 8  # place of center, input low and high, output low and high among the parameters


class DirectBlock(MachineBlock[_native.DirectBlock]):
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

    leading = ("y", "rate")

    def __init__(
        self, model: DirectInverse, period: float, range: tuple[float, float] | None = None, ramp: int = 500
    ) -> None:
        if not isinstance(model, DirectInverse):
            raise ParameterError(
                f"a DirectBlock runs a DirectInverse, not {type(model).__name__}; a Block runs other models."
            )
        refuse_ramp(ramp)
        self.model = model
        self.period = parameter_number(period, "period")
        self.ramp = int(ramp)
        input = _ranged(model.card.output, None, "output", "y")
        output = _ranged(model.card.input, range, "input", "u")
        told = list(model.parameters(self.period))
        told[_LIMITS] = np.array([model.center, input.low, input.high, output.low, output.high], float)
        self.parameters: tuple[Any, ...] = tuple(told)
        self.line_slope, self.line_offset = _line(model, float(input.low or 0.0), float(input.high or 0.0))
        self.fade = 1.0 / self.ramp
        native = _native.DirectBlock(self.parameters, self.line_slope, self.line_offset, self.fade)
        super().__init__(native, input, output, tuple(schedule.name for schedule in model.outside))

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
        return self._native.step(*self._sample(given, on, y, rate))

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
        samples = signal_array(y, "y")
        table = self._table(given, samples.size)
        switches = switched(on, samples.size)
        return self._native.run(samples, along(rate, samples.size, "rate"), table, switches)

    def __repr__(self) -> str:
        """One line: signals and their limits."""
        return f"<DirectBlock: {self.input!s} -> {self.output!s}, every {self.period:g} s>"


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
