"""One formula, two kinds of numbers: arrays for logs, floats for the step of a simulation.

A model writes its formula once, with the functions of the `Arithmetic` that it is handed. On floats those are the ones
of `math`: a step costs a microsecond or two and not the ten to thirty of small arrays.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Arithmetic:
    """Functions of one kind of numbers."""

    exp: Callable[[Any], Any]
    sqrt: Callable[[Any], Any]
    maximum: Callable[[Any, Any], Any]
    minimum: Callable[[Any, Any], Any]
    where: Callable[[Any, Any, Any], Any]


ARRAYS = Arithmetic(np.exp, np.sqrt, np.maximum, np.minimum, np.where)
FLOATS = Arithmetic(math.exp, math.sqrt, max, min, lambda condition, yes, no: yes if condition else no)


def polynomial(coefficients: tuple[float, ...], x: Any) -> Any:
    """Return the value of a polynomial, coefficients lowest power first.

    Examples
    --------
    >>> polynomial((1.0, 2.0, 3.0), 10.0)
    321.0
    """
    value = coefficients[-1] + 0.0 * x
    for c in reversed(coefficients[:-1]):
        value = value * x + c
    return value
