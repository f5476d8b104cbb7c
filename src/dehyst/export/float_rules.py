"""What a unit must be in float: the numbers that were good doubles are looked at again as they are exported."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from dehyst.errors import ParameterError
from dehyst.export.numbers import FLOAT_LIMIT, BlockNumbers, DirectNumbers, ModelNumbers

SMALLEST = float(np.finfo(np.float32).tiny)  # below it floats lose their digits, and some machines take them as 0
FADE = float(np.float32(1e-6))  # the share of a switching that still adds up in float
_CURE = "Scale the signals to a unit of their size and identify again, or export with --real double."


def check_block(exact: BlockNumbers, single: BlockNumbers) -> None:
    """Refuse a block that float cannot hold; `single` is `exact` in float.

    Raises
    ------
    ParameterError
        If numbers become infinite, zero or the same, a range becomes one number, or a switching takes too long.
    """
    if single.fade < FADE:
        raise ParameterError(
            f"--ramp {round(1 / exact.fade)} is too long for --real float: a millionth of a switching is the smallest "
            f"share that still adds up in single precision. Pass --ramp 1000000 or less, or --real double.",
            ramp=round(1 / exact.fade),
        )
    check_model(exact.model, single.model)
    named = [(entry.name, getattr(exact, entry.name), getattr(single, entry.name)) for entry in fields(exact)[1:-1]]
    for name, before, after in named:
        # How far the input may go in front of the last map is given by the largest float itself.
        if name.startswith("reach") and not exact.holds_back:
            continue
        _check_number(name.replace("_", " "), before, after)
    for what in ("input", "output"):
        low, high = getattr(single, f"{what}_low"), getattr(single, f"{what}_high")
        if not low < high:
            raise ParameterError(
                f"this unit cannot be exported with --real float: its {what} goes from "
                f"{getattr(exact, f'{what}_low'):.9g} to {getattr(exact, f'{what}_high'):.9g}, and in single precision "
                f"nothing is left of that range. Identify with a signal whose mean was taken off, widen the range, or "
                f"export with --real double.",
                low=low,
                high=high,
            )


def check_model(exact: ModelNumbers, single: ModelNumbers) -> None:
    """Refuse a model of which float cannot hold the numbers or tell neighbours apart.

    Raises
    ------
    ParameterError
        If that is so.
    """
    for what, doubles, values in _numbers(exact, single):
        for before, after in zip(doubles, values, strict=True):
            _check_number(what, before, after)
    for before, after in zip(exact.slope, single.slope, strict=True):
        if before != 0 and abs(after) < SMALLEST:
            raise ParameterError(
                f"this model cannot be exported with --real float: its slope {before:.3g} is too small for single "
                f"precision and would become zero. {_CURE}",
                value=before,
            )
    for what, doubles, values in _tables(exact, single):
        step = np.diff(values)
        if not (np.all(step > 0) or np.all(step < 0)):
            k = int(np.argmin(np.abs(step)))
            raise ParameterError(
                f"this model cannot be exported with --real float: of its {what}, number {k + 1} "
                f"({doubles[k]:.9g}) and number {k + 2} ({doubles[k + 1]:.9g}) become the same number in "
                f"single precision. Identify with fewer operators (--n 50), or export with --real double.",
                first=k,
            )


def check_direct(exact: DirectNumbers, single: DirectNumbers) -> None:
    """Refuse a direct inverse of which float cannot hold the numbers or tell neighbours apart.

    Raises
    ------
    ParameterError
        If that is so.
    """
    for what in ("radius", "length", "gain", "weight", "low", "high"):
        for before, after in zip(getattr(exact, what), getattr(single, what), strict=True):
            _check_number(what, before, after)
    for what, numbers in (("radii", (0.0, *single.radius)), ("path lengths", (0.0, *single.length))):
        if not np.all(np.diff(numbers) > 0):
            raise ParameterError(
                f"this model cannot be exported with --real float: two of its {what} become the same number in single "
                f"precision. {_CURE}"
            )
    pairs = [("schedule", *pair) for pair in zip(single.low, single.high, strict=True)]
    pairs += [("output", single.input_low, single.input_high), ("input", single.output_low, single.output_high)]
    for what, low, high in pairs:
        if not low < high:
            raise ParameterError(
                f"this model cannot be exported with --real float: the range of its {what} is {low:.9g} to {high:.9g} "
                f"in single precision, and nothing is left of it. {_CURE}",
                low=low,
                high=high,
            )


def check_values(values: Mapping[str, Any]) -> None:
    """Refuse parameters of a joint controller that float cannot hold.

    Raises
    ------
    ParameterError
        If one becomes infinite, or zero without being it.
    """
    for name, value in _leaves(values):
        with np.errstate(over="ignore", under="ignore"):
            single = float(np.float32(value))
        _check_number(f"parameter {name}", value, single)
        if value != 0 and single == 0:
            raise ParameterError(
                f"this controller cannot be exported with --real float: its parameter {name}, {value:.3g}, becomes "
                f"zero in single precision. Set it to 0 if that is meant, or export with --real double.",
                value=value,
            )


def _numbers(exact: ModelNumbers, single: ModelNumbers) -> Iterator[tuple[str, tuple[float, ...], tuple[float, ...]]]:
    for what in ("threshold", "slope", "loading", "start"):
        yield what, getattr(exact, what), getattr(single, what)
    yield "center and offset", (exact.center, exact.offset), (single.center, single.offset)
    for place in ("before", "after"):
        old, new = getattr(exact, place), getattr(single, place)
        if old is not None:
            yield f"map {place} the hysteresis", (*old[0], *old[1]), (*new[0], *new[1])


def _tables(exact: ModelNumbers, single: ModelNumbers) -> Iterator[tuple[str, tuple[float, ...], tuple[float, ...]]]:
    yield "thresholds", exact.threshold, single.threshold
    for place in ("before", "after"):
        old, new = getattr(exact, place), getattr(single, place)
        if old is not None:
            yield f"breakpoints of the map {place} the hysteresis", old[0], new[0]
            yield f"values of the map {place} the hysteresis", old[1], new[1]


def _leaves(values: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, float]]:
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{path}{name}.")
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield path + name, float(value)
        elif isinstance(value, list | tuple):
            yield from _leaves({f"{name}[{k}]": entry for k, entry in enumerate(value)}, path)


def _check_number(what: str, exact: float, single: float) -> None:
    if not abs(single) <= FLOAT_LIMIT:
        raise ParameterError(
            f"this unit cannot be exported with --real float: its {what} {exact:.3g} lies beyond {FLOAT_LIMIT:.0e}, "
            f"the largest number that the core takes in single precision. {_CURE}",
            value=exact,
        )
