"""A direct inverse as a unit: y, its rate and scheduling variables in, the needed u out."""

from __future__ import annotations

from typing import Any

import numpy as np

from dehyst.control.direct_block import DirectBlock
from dehyst.errors import ParameterError
from dehyst.export.float_rules import FADE, check_direct, check_values
from dehyst.export.numbers import TOLERANCE, DirectBlockNumbers, DirectNumbers, direct_in, direct_numbers, rounded
from dehyst.export.signal import SAMPLES, moving_input
from dehyst.export.unit import Asked, Unit, c_names
from dehyst.models import DirectInverse

WHAT = "direct-inverse"


def unit_of(model: DirectInverse, asked: Asked) -> Unit:
    """Return the unit.

    Raises
    ------
    ParameterError
        If the model has no ranges, does not survive the rounding to float, or the period is missing.
    """
    if asked.what == "forward":
        raise ParameterError(
            "the model is a direct inverse: it answers which input an output needs, and there is no model of the "
            "output to export. Leave --what forward out, or identify another family for it."
        )
    if asked.period is None:
        raise ParameterError(
            "the model is a direct inverse: what creeps depends on the time between two samples, which is not known "
            "here. Add --period SECONDS, what your target calls it with, for example --period 0.001."
        )
    block = DirectBlock(model, asked.period, asked.range, asked.ramp)
    exact = direct_numbers(block.parameters)
    direct = direct_in(exact, asked.real)
    line: dict[str, Any] = {what: rounded(value, asked.real) for what, value in (
        ("line_slope", block.line_slope), ("line_offset", block.line_offset), ("fade", block.fade)
    )}  # fmt: skip
    if asked.real == "float":
        check_direct(exact, direct)
        check_values({"line_slope": block.line_slope, "line_offset": block.line_offset})
        _refuse_long_ramp(asked.ramp, line["fade"])
    names = c_names(block.given, ("y", "rate"))
    numbers = DirectBlockNumbers(direct, **line, given=names, tolerance=float_tolerance(direct))
    ranges = [(schedule.low, schedule.high) for schedule in model.outside]
    inputs, on = moving_input(direct.input_low, direct.input_high, [None, *ranges], asked.ramp, asked.real)
    more = [
        (name, f"{schedule.name}{f' [{schedule.unit}]' if schedule.unit else ''}, held beyond {schedule.low:.6g} .. "
               f"{schedule.high:.6g}")
        for name, schedule in zip(names, model.outside, strict=True)
    ]  # fmt: skip
    return Unit(
        block, numbers, inputs, on, what=WHAT, period=block.period,
        more=(("rate", "its rate of change a second, 0 if the model has no viscous term"), *more),
        heads=(f"{model.card.output.name or 'y'}_rate", *block.given),
        middle=(0.0, 0.0, *(0.5 * (low + high) for low, high in ranges)),
    )  # fmt: skip


def _refuse_long_ramp(ramp: int, fade: float) -> None:
    if fade < FADE:
        raise ParameterError(
            f"--ramp {ramp} is too long for --real float: a millionth of a switching is the smallest share that still "
            f"adds up in single precision. Pass --ramp 1000000 or less, or --real double.",
            ramp=ramp,
        )


def float_tolerance(d: DirectNumbers) -> float:
    """Return how far answers in float may be from those of the model: 1e-5 of the range of u, and rounding of y. [u]

    A creep lag adds less than its last digit when it is nearly there: that can add up over the samples of the test.
    """
    largest = max(abs(d.input_low), abs(d.input_high), d.input_high - d.input_low)
    digit = float(np.spacing(np.float32(largest)))
    table = np.array(d.weight).reshape(d.sets, d.terms)[:, d.coefficients : -1]
    weights = np.abs(table).sum(axis=0) if table.size else np.zeros(0)
    first = len(d.radius) + len(d.length)
    stalled = sum(w * 0.5 * digit * min(1.0 / gain, SAMPLES) for w, gain in zip(weights[first:], d.gain, strict=True))
    return TOLERANCE * (d.output_high - d.output_low) + digit * float(weights.sum()) + float(stalled)
