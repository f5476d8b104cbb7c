"""Oscillators with a Duhem element: a free curve for the slope of the loop, as fine as a held-out record wants it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from dehyst.arrays import Array, rank
from dehyst.errors import ParameterError
from oscillator.linear import identify_linear
from oscillator.model import HystereticOscillator
from oscillator.output_error import OutputErrorFit, SteadyState, fit_output_error, lead_time
from oscillator.records import PeriodicRecord

DEGREES = (2, 4, 6, 8)
KNOTS = (5, 6, 7, 8, 9, 10)
_NODES = 257  # of the table that holds a polynomial
_MARGIN = 1.05  # of the table's range over the forces seen in estimation


@dataclass(frozen=True)
class Choice:
    """One resolution that was tried.

    Attributes
    ----------
    size
        Degree, or number of knots.
    validation
        Rms error on the record that was not fitted. [m]
    fit
        What the optimiser found.
    """

    size: int
    validation: float
    fit: OutputErrorFit


@dataclass(frozen=True)
class _Slopes:
    """m, c, k and what the slopes of the table are made of: slopes = stiffness * basis @ p[3:]."""

    linear: HystereticOscillator
    reach: float
    basis: Array

    def build(self, p: Array) -> HystereticOscillator:
        slopes = self.linear.stiffness * (self.basis @ p[3:])
        mass, damping, stiffness = p[:3] * (
            self.linear.mass,
            self.linear.damping,
            self.linear.stiffness,
        )
        return HystereticOscillator(
            float(mass),
            float(damping),
            float(stiffness),
            slope_range=self.reach,
            slopes=slopes.tolist(),
        )

    def roughness(self, p: Array) -> Array:
        """Second differences in units of the linear stiffness: what keeps knots in place that the data do not reach."""
        return np.diff(self.basis @ p[3:], n=2)


def rms_error(oscillator: HystereticOscillator, record: PeriodicRecord, lead: float) -> float:
    """Return the rms difference between a record and the simulated steady state. [m]"""
    return float(np.sqrt(np.mean((SteadyState(record, lead)(oscillator)[0] - record.output) ** 2)))


def _tried(
    shape: _Slopes,
    start: Array,
    size: int,
    records: Sequence[PeriodicRecord],
    held_out: PeriodicRecord,
    lead: float,
) -> Choice:
    prior = shape.roughness if shape.basis.shape[0] == shape.basis.shape[1] else None
    fit = fit_output_error(shape.build, start, records, lead=lead, prior=prior, evaluations=30)
    assert isinstance(fit.oscillator, HystereticOscillator)
    return Choice(size, rms_error(fit.oscillator, held_out, lead), fit)


def best(choices: Sequence[Choice]) -> Choice:
    """Return the choice with the smallest error on the held-out record."""
    return min(choices, key=lambda choice: rank(choice.validation))


def identify_duhem_polynomial(
    records: Sequence[PeriodicRecord], held_out: PeriodicRecord, degrees: Sequence[int] = DEGREES
) -> list[Choice]:
    r"""Identify oscillators with z' = y' G(sign(y') z), G a polynomial, one of each degree.

    The start is the best linear oscillator with half of its stiffness in z and a slope that falls from unloading
    to loading; each degree starts from the one before.

    Parameters
    ----------
    records
        Averaged periods.
    held_out
        Another one, for the choice between the degrees.
    degrees
        Increasing, each at least 1.

    Raises
    ------
    ParameterError
        No degree, or one below 1.
    ExcitationError, IdentificationError
        As by the linear fit and the optimiser.
    """
    if not degrees or min(degrees) < 1:
        raise ParameterError(f"degrees = {tuple(degrees)}: give at least one, each 1 or more.")
    linear = identify_linear(records)
    lead = lead_time(linear.mass, 0.5 * linear.damping)
    reach = 1.2 * linear.stiffness * max(float(np.abs(record.output).max()) for record in records)
    start = np.array([1.0, 0.25, 0.5, 0.75, -0.25])
    choices = []
    for degree in degrees:
        start = np.append(start, np.zeros(max(4 + degree - start.size, 0)))[: 4 + degree]
        basis = chebyshev.chebvander(np.linspace(-1.0, 1.0, _NODES), degree).astype(np.float64)
        shape = _Slopes(linear, reach, basis)
        choices.append(_tried(shape, start, degree, records, held_out, lead))
        start = choices[-1].fit.parameters
    return choices


def identify_duhem_table(
    records: Sequence[PeriodicRecord],
    held_out: PeriodicRecord,
    start: HystereticOscillator,
    knots: Sequence[int] = KNOTS,
) -> list[Choice]:
    r"""Identify oscillators with z' = y' G(sign(y') z), G piecewise linear on equally spaced knots, one of each number.

    Parameters
    ----------
    records
        Averaged periods.
    held_out
        Another one, for the choice between the numbers.
    start
        An oscillator with slopes, such as :func:`identify_duhem_polynomial` gives: its forces tell the table's range.
    knots
        Numbers of knots, each at least 3.

    Raises
    ------
    ParameterError
        No number of knots, one below 3, or a start without slopes.
    ExcitationError, IdentificationError
        As by the linear fit and the optimiser.
    """
    if not knots or min(knots) < 3 or not start.slopes:
        raise ParameterError(
            f"knots = {tuple(knots)}: give at least one number, each 3 or more, and a start with slopes."
        )
    linear = identify_linear(records)
    lead = lead_time(linear.mass, 0.5 * linear.damping)
    reach = _MARGIN * max(
        float(np.abs(SteadyState(record, lead)(start)[1]).max()) for record in records
    )
    given = np.linspace(-start.slope_range, start.slope_range, len(start.slopes))
    first = [
        start.mass / linear.mass,
        start.damping / linear.damping,
        start.stiffness / linear.stiffness,
    ]
    choices = []
    for count in knots:
        slopes = (
            np.interp(np.linspace(-reach, reach, count), given, start.slopes) / linear.stiffness
        )
        shape = _Slopes(linear, reach, np.eye(count))
        choices.append(_tried(shape, np.array([*first, *slopes]), count, records, held_out, lead))
    return choices
