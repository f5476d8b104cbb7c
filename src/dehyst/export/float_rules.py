"""What a unit must be in float: the numbers that were good doubles are looked at again as they are exported."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, Protocol

import numpy as np

from dehyst.errors import ParameterError
from dehyst.export.numbers import FLOAT_LIMIT, INPUT_LIMIT, Tables, UnitNumbers, in_real

SMALLEST = float(np.finfo(np.float32).tiny)  # below it floats lose their digits, and some machines take them as 0
FADE = float(np.float32(1e-6))  # the share of a switching that still adds up in float
KEPT = {"slope", "gain", "half_range", "parameter"}  # that must not vanish
_CURE = "Scale the signals to a unit of their size and identify again, or export with --real double."


class Rising(Protocol):
    """What has tables of which neighbours differ."""

    @property
    def rising(self) -> Tables:
        """Their names and numbers."""
        ...


def check_unit(exact: UnitNumbers, told: UnitNumbers, ramp: int, real: str) -> None:
    """Refuse a unit that its precision cannot hold; `told` is `exact` in that precision."""
    if real == "double":
        return
    if told.fade < FADE:
        raise ParameterError(
            f"--ramp {ramp} is too long for --real float: a millionth of a switching is the smallest share that still "
            f"adds up in single precision. Pass --ramp 1000000 or less, or --real double.",
            ramp=ramp,
        )
    check_float(exact, told)


def check_float(exact: Rising, single: Rising) -> None:
    """Refuse numbers that float cannot hold, or of which it cannot tell neighbours apart."""
    _check_leaves(exact, single)
    for (what, doubles), (_, values) in zip(exact.rising, single.rising, strict=True):
        step = np.diff(values)
        if not (np.all(step > 0) or np.all(step < 0)):
            k = int(np.argmin(np.abs(step)))
            raise ParameterError(
                f"this unit cannot be exported with --real float: two of its {what} become the same number in single "
                f"precision, number {k + 1} ({doubles[k]:.9g}) and number {k + 2} ({doubles[k + 1]:.9g}), and nothing "
                f"is left of that range. Identify with fewer operators (--n 50) or with a signal whose mean was taken "
                f"off, widen the range, or export with --real double.",
                first=k,
            )


def check_values(values: Mapping[str, Any]) -> None:
    """Refuse parameters of a joint controller that float cannot hold."""
    exact = {"parameter": values}
    _check_leaves(exact, in_real(exact, "float"))


def _check_leaves(exact: object, single: object) -> None:
    for (name, before), (_, after) in zip(_leaves(exact), _leaves(single), strict=True):
        if not abs(after) <= FLOAT_LIMIT and abs(before) < INPUT_LIMIT["double"]:  # from there on it means: none
            raise ParameterError(
                f"this unit cannot be exported with --real float: its {name} {before:.3g} lies beyond "
                f"{FLOAT_LIMIT:.0e}, the largest number that the core takes in single precision. {_CURE}",
                value=before,
            )
        if before != 0 and abs(after) < SMALLEST and KEPT & set(name.split()):
            raise ParameterError(
                f"this unit cannot be exported with --real float: its {name}, {before:.3g}, is too small for single "
                f"precision and would become zero. {_CURE}",
                value=before,
            )


def _leaves(value: object, path: str = "") -> Iterator[tuple[str, float]]:
    """Real numbers of a record by the names that lead to them."""
    if isinstance(value, float):
        yield path, value
    elif isinstance(value, list | tuple):
        for k, part in enumerate(value):
            yield from _leaves(part, f"{path} {k + 1}")
    elif isinstance(value, Mapping) or is_dataclass(value):
        named = value if isinstance(value, Mapping) else {e.name: getattr(value, e.name) for e in fields(value)}
        for name, part in named.items():
            yield from _leaves(part, f"{path} {name}".strip())
