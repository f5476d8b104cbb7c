"""Plan of an excitation: its sections, and the motion as samples."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.design.separability import Separability
from dehyst.design.strokes import PEAK_ACCELERATION, PEAK_RATE, Limits, sampled


@dataclass(frozen=True)
class Section:
    """Strokes of one purpose, one after the other.

    Attributes
    ----------
    part
        ``home``, ``loops``, ``holds`` or ``test``; ``cycles`` of a motion for `drift`.
    why
        What it is for.
    tips
        (K,) ends of its strokes. [unit]
    stroke_s, hold_s
        (K,) time of each stroke, and at rest after it. [s]
    """

    part: str
    why: str
    tips: tuple[float, ...]
    stroke_s: tuple[float, ...]
    hold_s: tuple[float, ...]

    @property
    def duration(self) -> float:
        """Of all strokes and holds. [s]"""
        return sum(self.stroke_s) + sum(self.hold_s)


@dataclass(frozen=True, eq=False)
class ExcitationPlan:
    """What to run on the rig for an identification of hysteresis, creep and rate, or for `drift`.

    Attributes
    ----------
    low, high
        Range. [unit]
    unit
        Of value.
    period
        Of the samples. [s]
    limits
        Rate and acceleration that no stroke exceeds.
    sections
        In order; the motion begins and ends in the middle of the range.
    separable
        How well hysteresis, creep and rate can be told apart, home and test left out.
    one_loop
        The same for the loop over the whole range, repeated for the same time at the same rate.

    Examples
    --------
    >>> from dehyst.design import design_excitation
    >>> plan = design_excitation(0.0, 5.0, unit="bar")
    >>> [section.part for section in plan.sections]
    ['home', 'loops', 'loops', 'holds', 'loops', 'loops', 'holds', 'test', 'home']
    >>> plan.middle, plan.points[-1].item(), plan.duration <= 600.0
    (2.5, 2.5, True)
    """

    low: float
    high: float
    unit: str
    period: float
    limits: Limits
    sections: tuple[Section, ...]
    separable: Separability
    one_loop: Separability

    @property
    def middle(self) -> float:
        """Where the motion begins and ends. [unit]"""
        return 0.5 * (self.low + self.high)

    @property
    def points(self) -> Array:
        """Start and tips of all sections, (K + 1,). [unit]"""
        return np.array([self.middle, *itertools.chain(*(section.tips for section in self.sections))])

    @property
    def stroke_s(self) -> Array:
        """Time of each stroke, (K,). [s]"""
        return np.array([*itertools.chain(*(section.stroke_s for section in self.sections))])

    @property
    def hold_s(self) -> Array:
        """Time at rest after each stroke, (K,). [s]"""
        return np.array([*itertools.chain(*(section.hold_s for section in self.sections))])

    @property
    def duration(self) -> float:
        """Of the whole motion. [s]"""
        return sum(section.duration for section in self.sections)

    @property
    def begins(self) -> tuple[float, ...]:
        """When each section begins. [s]"""
        return tuple(itertools.accumulate((section.duration for section in self.sections[:-1]), initial=0.0))

    @property
    def peak_rate(self) -> float:
        """Largest rate of all strokes. [unit/s]"""
        return float((PEAK_RATE * np.abs(np.diff(self.points)) / self.stroke_s).max())

    @property
    def peak_acceleration(self) -> float:
        """Largest acceleration of all strokes. [unit/s^2]"""
        return float((PEAK_ACCELERATION * np.abs(np.diff(self.points)) / self.stroke_s**2).max())

    def signal(self, period: float | None = None) -> tuple[Array, Array, npt.NDArray[np.str_]]:
        """Return the motion as samples.

        Parameters
        ----------
        period
            Of the samples; None: the plan's. [s]

        Returns
        -------
        time
            (T,) [s]
        value
            (T,) [unit]
        part
            (T,) the part that a sample belongs to.
        """
        time, value, stroke = sampled(self.points, self.stroke_s, self.hold_s, period or self.period)
        part = np.array([section.part for section in self.sections for _ in section.tips])
        return time, value, part[stroke]
