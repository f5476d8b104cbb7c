"""A plan of an excitation: its sections, its samples, and the candidate plans to choose from."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.design.excitation import PEAK_ACCELERATION, PEAK_RATE, UNSEEN_TIPS, Limits, sampled
from dehyst.design.homing import shortest_homing
from dehyst.design.separability import Separability


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


DECADE = 10.0  # fast by slow rate
TEST_SLOWER = 1.5
HOLD_RATIO = 3.0  # of a hold to the one before
LONGEST_HOLD = 1.0  # by the longest time constant
SHORTEST_HOLD_S = 1.0
HOLD_PLACES = (0.8, -0.45, 0.6, -0.9, 0.25)  # the longest hold at the first one
LADDER = (1.0, 0.5, 0.9, -0.2, 0.2, -0.9, -0.5, -1.0)  # minor loops of 0.4 at 0.7, 0 and -0.7 of a falling branch
NEST = (0.88, 0.06)  # first and last amplitude of the decaying loops
HOMED = (0.02, 0.95)  # smallest and largest radius that homing is for
HOMED_RADII = 24
HOMING_LEFT = 0.1  # share of what the stops can hold that homing leaves
LEVELS, REACHES, COUNTS, TIMES = (8, 11), (0.3, 0.5, 0.8), (2, 3, 4, 5), (0.5, 0.65, 0.8, 1.0)  # of candidates


def strokes_of(part: str, why: str, tips: Iterable[float], limits: Limits, hold_s: Sequence[float] = ()) -> Section:
    """Return a section that begins at zero, its strokes as fast as the limits allow."""
    ends = tuple(tips)
    ways = np.abs(np.diff([0.0, *ends]))
    holds = tuple(hold_s) + (0.0,) * (len(ends) - len(hold_s))
    return Section(part, why, ends, tuple(limits.stroke_time(ways).tolist()), holds)


def _mirrored(section: Section, why: str) -> Section:
    return replace(section, tips=tuple(-tip for tip in section.tips), why=why)


def _fast_loops(levels: int, limits: Limits) -> Section:
    first, last = NEST
    nest = [-first * (last / first) ** (k / (levels - 1)) * (-1.0) ** (k + 1) for k in range(levels)]
    why = "whole range, minor loops of one size at three places, then loops that decay through all radii"
    return strokes_of("loops", why, [*LADDER, *nest, 0.0], limits)


def _slow_loops(reach: float, limits: Limits) -> Section:
    why = f"the same shapes at a tenth of the rate: tells rate from hysteresis ({reach:g} of the range)"
    slow = Limits(limits.rate / DECADE, limits.acceleration)
    return strokes_of("loops", why, [reach, -reach, 0.5 * reach, -0.25 * reach, 0.0], slow)


def holds_section(count: int, longest: float, limits: Limits) -> Section:
    """Return `count` holds, the longest of `longest` seconds last, and the way back."""
    holds = [longest / HOLD_RATIO**k for k in range(count)]
    why = "times at rest, each three times the one before: creep shows where nothing moves"
    return strokes_of("holds", why, [*HOLD_PLACES[:count][::-1], 0.0], limits, holds[::-1])


def home_section(limits: Limits) -> Section:
    """Return the decaying strokes that a plan begins and ends with."""
    radii = np.geomspace(*HOMED, HOMED_RADII)
    homing = shortest_homing(radii, -1.0, 1.0, limits, tolerance=HOMING_LEFT)
    why = f"decays: from any state before, the memory is known and {100 * homing.residual:.0f} % of it is left"
    return Section(
        "home", why, tuple(homing.points[1:].tolist()), tuple(homing.stroke_s.tolist()), (0.0,) * homing.stroke_s.size
    )


def frame(home: Section, limits: Limits, levels: int, reach: float) -> tuple[list[Section], list[Section]]:
    """All sections before and after the first half's holds; the holds are what uses up the time that is left."""
    half = [_fast_loops(levels, limits), _slow_loops(reach, limits)]
    test = strokes_of("test", "loops that the others do not contain: not for the fit", [*UNSEEN_TIPS, 0.0],
                    Limits(limits.rate / TEST_SLOWER, limits.acceleration / TEST_SLOWER**2))  # fmt: skip
    mirrored = [_mirrored(each, "the same with all signs changed: creep to either side cancels") for each in half]
    return [home, *half], [*mirrored, test, home]


def candidates(home: Section, limits: Limits, time_limit: float, tau: float) -> Iterator[tuple[Section, ...]]:
    """Yield plans that keep the time, their holds as long as it allows."""
    for levels, reach in itertools.product(LEVELS, REACHES):
        before, after = frame(home, limits, levels, reach)
        fixed = sum(section.duration for section in (*before, *after))
        seen = set()
        for count, share in itertools.product(COUNTS, TIMES):
            strokes = sum(holds_section(count, 0.0, limits).stroke_s)
            left = 0.5 * (share * time_limit * (1 - 1e-12) - fixed) - strokes
            longest = min(left / sum(HOLD_RATIO**-k for k in range(count)), LONGEST_HOLD * tau)
            if not longest / HOLD_RATIO ** (count - 1) >= SHORTEST_HOLD_S or (count, longest) in seen:
                continue
            seen.add((count, longest))
            holds = holds_section(count, longest, limits)
            mirrored = _mirrored(holds, "the same with all signs changed")
            yield (*before, holds, *after[:2], mirrored, *after[2:])
