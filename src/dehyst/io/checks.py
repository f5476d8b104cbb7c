"""Checks of signals that read well but may not say what they seem to say."""

from __future__ import annotations

import numpy as np

from dehyst.errors import ExcitationError, RecordingError
from dehyst.findings import Finding
from dehyst.io.clean import Context, Samples
from dehyst.io.table import Array, Table


def is_constant(values: Array) -> bool:
    """Whether a signal does not move beyond rounding."""
    span = float(np.ptp(values)) if values.size else 0.0
    return span <= 1e-12 * float(np.max(np.abs(values), initial=0.0))


def check_signal(samples: Samples, about: Context, findings: list[Finding]) -> None:
    """Findings about a single column."""


def check_pair(table: Table, x_name: str, y_name: str, samples: Samples, findings: list[Finding]) -> None:
    """Findings about input and output; a signal that never moves is refused."""
    x, y = samples.values
    if is_constant(x):
        raise ExcitationError(
            f"input '{x_name}' of {table.name} is {x[0]:.6g} in all {x.size} rows: nothing can be learned about how "
            f"the output depends on it. Name another input column, run or window.",
            column=x_name,
        )
    if is_constant(y):
        raise RecordingError(
            f"output '{y_name}' of {table.name} is {y[0]:.6g} in all {y.size} rows although the input moves: the "
            f"sensor is not connected, or it is the wrong column. Name another output column, run or window.",
            column=y_name,
        )
