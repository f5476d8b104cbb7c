"""Periodic measurements: one averaged period, and how noisy it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import RecordingError
from dehyst.models._arrays import signal_array


@dataclass(frozen=True)
class PeriodicRecord:
    """One period of a periodic experiment in its steady state.

    Attributes
    ----------
    force
        u (N,). [N]
    output
        y (N,), a mean over periods. [m]
    sampling_time
        [s]
    noise
        Standard deviation of that mean, from the differences between the periods; NaN if there was only one. [m]
    """

    force: Array
    output: Array
    sampling_time: float
    noise: float

    @property
    def time(self) -> Array:
        """(N,) from 0. [s]"""
        time: Array = np.arange(self.force.size, dtype=np.float64) * self.sampling_time
        return time


def average_periods(
    force: npt.ArrayLike, output: npt.ArrayLike, period: int, sampling_time: float, *, skip: int = 1
) -> PeriodicRecord:
    """Return the mean of the whole periods of a record after the first `skip` ones, in which the transient dies out.

    Parameters
    ----------
    force, output
        (T,). [N], [m]
    period
        Samples a period.
    sampling_time
        [s]
    skip
        Periods to leave out.

    Raises
    ------
    RecordingError
        No whole period is left, values are not finite, or the force is not periodic.

    Examples
    --------
    >>> record = average_periods([1.0, -1.0] * 3, [0.0, 0.0, 2.0, -2.0, 4.0, -4.0], 2, 0.1)
    >>> record.output.tolist(), round(record.noise, 3)
    ([3.0, -3.0], 1.0)
    """
    u, y = signal_array(force, "force"), signal_array(output, "output")
    count = u.size // period - skip if period > 0 else 0
    if u.size != y.size or count < 1:
        raise RecordingError(
            f"force has {u.size} values, output {y.size}, a period {period}, of which {skip} are skipped: no whole "
            f"period is left in both. Record more periods, or correct `period`."
        )
    forces, outputs = (
        signal[skip * period : (skip + count) * period].reshape(count, period) for signal in (u, y)
    )
    if not (np.isfinite(forces).all() and np.isfinite(outputs).all()):
        raise RecordingError(
            "force or output is not finite somewhere: repair the record before averaging it."
        )
    if np.abs(forces - forces[0]).max() > 1e-6 * np.abs(forces).max():
        raise RecordingError(
            f"the force does not repeat after {period} samples; averaging would smear it.",
            period=period,
        )
    between = (
        float(np.sqrt(outputs.var(axis=0, ddof=1).mean() / count)) if count > 1 else float("nan")
    )
    return PeriodicRecord(forces.mean(axis=0), outputs.mean(axis=0), sampling_time, between)
