"""Compiles a loop over samples by numba; without numba the loop runs as Python, a hundred times slower."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Parameters = tuple[float, ...]
# Of an input in shares of its range (T,), the time of a step [s], parameters and a table (N, M): the output (T,).
Mechanism = Callable[[Array, float, Parameters, Array], Array]
F = TypeVar("F", bound=Callable[..., Any])
NUMBA = find_spec("numba") is not None


def compiled(loop: F) -> F:
    """Return a loop over samples, compiled where numba is installed."""
    if not NUMBA:
        return loop
    import numba

    return cast(F, numba.njit(cache=True)(loop))
