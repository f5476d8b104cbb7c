"""Offset correction from the last cycle: its parameters, for models and exported units."""

from __future__ import annotations

import hashlib
import struct
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models._arrays import parameter_number, signal_array
from dehyst.models._card import SignalCard
from dehyst.models._policy import POLICY


@dataclass(frozen=True)
class OffsetNumbers:
    """Numbers of the core's ``dehyst_offset``.

    Attributes
    ----------
    limit
        Largest size of the offset. [output of the actuator]
    turn
        Way back that makes a turning point. [x]
    part
        Offset that comes in along a way of 1. [output/x]
    """

    limit: float
    turn: float
    part: float

    @property
    def fingerprint(self) -> int:
        """First 32 bits of the SHA-256 of all of it."""
        # Little-endian on every machine, so that the fingerprint is the same everywhere.
        packed = struct.pack("<3d", self.limit, self.turn, self.part)
        return int.from_bytes(hashlib.sha256(packed).digest()[:4], "big")

    def made(self) -> _native.Offset:
        """Return the core's, with nothing seen."""
        return _native.Offset(self.limit, self.turn, self.part, self.fingerprint)


def offset_numbers(limit: float, output: float, x: float) -> OffsetNumbers:
    """Return numbers from the limit as a share of the output's range, that range, and that of x.

    Raises
    ------
    ParameterError
        If the limit is none.

    Examples
    --------
    >>> offset_numbers(0.1, 2.0, 5.0)
    OffsetNumbers(limit=0.2, turn=0.25, part=0.04)
    """
    share = parameter_number(limit, "follow_offset")
    if not 0.0 < share <= POLICY.offset_most:
        raise ParameterError(
            f"follow_offset = {share:g} is no limit of an offset; pass a share of the output's range above 0 and at "
            f"most {POLICY.offset_most:g}, for example 0.1 (in a terminal: --follow-offset 0.1).",
            follow_offset=share,
        )
    # Without a range there is nothing to count a turn or a share in.
    if not (output > 0.0 and x > 0.0):
        raise ParameterError(
            "a signal that stands still has no cycles, so no offset can follow them."
        )
    return OffsetNumbers(share * output, POLICY.turn * x, share * output / x)


def range_width(card: SignalCard, otherwise: npt.ArrayLike) -> float:
    """Return the identified range of a signal; where that is not known, the range of these values."""
    if card.low is None or card.high is None:
        return float(np.ptp(otherwise))
    return float(card.high - card.low)


def following(
    x: npt.ArrayLike, answers: npt.ArrayLike, measured: npt.ArrayLike, numbers: OffsetNumbers
) -> Array:
    """Return a model's output (T,) with the offset of the last cycle of what was measured, NaN where nothing was.

    No sample depends on a measurement of its own or later.

    Examples
    --------
    >>> x = np.sin(np.linspace(0.0, 25.0, 1000))
    >>> error = following(x, 2.0 * x, 2.0 * x + 0.3, offset_numbers(0.1, 4.0, 2.0)) - (2.0 * x + 0.3)
    >>> [round(value, 3) for value in error[[0, -1]].tolist()]
    [-0.3, 0.0]
    """
    inputs, outputs = signal_array(x, "input x"), signal_array(answers, "answers")
    measurements = signal_array(measured, "measured")
    if not inputs.shape == outputs.shape == measurements.shape:
        raise ParameterError(
            f"input, output and measurement differ: {inputs.shape}, {outputs.shape}, {measurements.shape}."
        )
    moved: Array = outputs + numbers.made().run(inputs, outputs, measurements)
    return moved
