"""Fit the parameters of an oscillator to periodic records: smallest output error of the simulated steady state."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from dehyst.arrays import Array
from dehyst.errors import IdentificationError, SimulationError
from oscillator.model import Oscillator
from oscillator.records import PeriodicRecord
from oscillator.upsampling import finer_periodic

STEPS = 4  # of integration a sample: at 750 Hz and 150 Hz excited its error is a thousandth of the noise
DECAYS = 25.0  # time constants of the linear oscillator before the period that counts


@dataclass(frozen=True)
class OutputErrorFit:
    """What the optimiser found.

    Attributes
    ----------
    oscillator
        The model.
    parameters
        Where it ended (p,), in the scaled unknowns of the fit.
    covariance
        Of those (p, p), for the noise that the residuals show.
    rms
        Root of the mean square of the residuals. [m]
    evaluations
        Simulations of all records that it took, derivatives not counted.
    """

    oscillator: Oscillator
    parameters: Array
    covariance: Array
    rms: float
    evaluations: int


class SteadyState:
    """Simulates one record's period after a lead-in from rest that is long enough to forget it."""

    def __init__(self, record: PeriodicRecord, lead: float, steps: int = STEPS) -> None:
        self.samples, self.dt, self.steps = record.force.size, record.sampling_time, steps
        grid = finer_periodic(record.force, 2 * steps)
        self.lead = int(min(self.samples, np.ceil(lead / self.dt)))
        self.grid = np.concatenate([grid[grid.size - 2 * steps * self.lead :], grid, grid[:1]])

    def __call__(self, oscillator: Oscillator) -> tuple[Array, Array]:
        """Return y and h, (N,) each."""
        rows, _ = oscillator.run(self.grid, self.steps, self.dt, oscillator.rest())
        period = slice(self.lead, self.lead + self.samples)
        return rows[period, 0], rows[period, 2]


def fit_output_error(
    build: Callable[[Array], Oscillator],
    start: npt.ArrayLike,
    records: Sequence[PeriodicRecord],
    *,
    lead: float,
    prior: Callable[[Array], Array] | None = None,
    lower: Array | None = None,
    evaluations: int = 60,
) -> OutputErrorFit:
    """Return the oscillator `build(parameters)` whose simulated steady states are nearest to the records.

    Gauss-Newton within a trust region, derivatives by differences. A parameter set whose simulation fails counts as one
    that is far off.

    Parameters
    ----------
    build
        From unknowns of order one to an oscillator.
    start
        (p,).
    records
        Averaged periods; each is weighted by its own noise where that is known.
    lead
        Time before the period in which the start is forgotten. [s]
    prior
        Further residuals, in units of the noise, of what the unknowns are expected to be.
    lower
        Bounds of the unknowns (p,), minus infinity where there is none; a start below is lifted.
    evaluations
        Limit of the iterations.

    Raises
    ------
    IdentificationError
        The simulation fails at the start itself.
    """
    simulated = [SteadyState(record, lead) for record in records]
    scales = [
        record.noise if record.noise > 0 else 1e-3 * float(record.output.std())
        for record in records
    ]

    def residuals(p: Array) -> Array:
        try:
            oscillator = build(p)
            errors = [
                run(oscillator)[0] - record.output
                for run, record in zip(simulated, records, strict=True)
            ]
            parts = [error / scale for error, scale in zip(errors, scales, strict=True)]
        except (SimulationError, ValueError):
            return np.full(sum(record.output.size for record in records) + beliefs, 1e6)
        return np.concatenate([*parts, prior(p)] if prior else parts)

    first = np.array(start, dtype=np.float64)
    low = np.full(first.size, -np.inf) if lower is None else lower
    first = np.maximum(first, low + 1e-6)  # strictly inside, as the optimiser wants it
    beliefs = prior(first).size if prior else 0
    if (begin := residuals(first))[0] == 1e6:
        raise IdentificationError(
            "the oscillator cannot be simulated at the start of its fit: give another one."
        )
    scale = np.maximum(np.abs(first), 0.1)
    limits = (low, np.full(first.size, np.inf))
    found = least_squares(
        residuals, first, x_scale=scale, bounds=limits, max_nfev=evaluations, xtol=1e-10, ftol=1e-10
    )
    rows = begin.size - beliefs
    variance = float(found.fun[:rows] @ found.fun[:rows]) / max(rows - first.size, 1)
    errors = np.concatenate(
        [found.fun[k : k + r.output.size] * s for k, r, s in _places(records, scales)]
    )
    covariance = np.linalg.pinv(found.jac.T @ found.jac) * variance
    return OutputErrorFit(
        build(found.x), found.x, covariance, float(np.sqrt(np.mean(errors**2))), int(found.nfev)
    )


def _places(
    records: Sequence[PeriodicRecord], scales: Sequence[float]
) -> list[tuple[int, PeriodicRecord, float]]:
    """First row of each record among the residuals, the record, its scale."""
    ends = np.cumsum([record.output.size for record in records]).tolist()
    return list(zip([0, *ends[:-1]], records, scales, strict=True))


def lead_time(mass: float, damping: float) -> float:
    """Return the time in which the linear oscillator forgets its start. [s]"""
    return DECAYS * 2.0 * mass / max(damping, 1e-9 * mass)
