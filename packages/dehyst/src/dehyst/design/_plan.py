"""A plan of an excitation: its sections, its samples, and the candidate plans to choose from."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.design._excitation import PEAK_ACCELERATION, PEAK_RATE, UNSEEN_TIPS, Limits, sampled
from dehyst.design._homing import shortest_homing
from dehyst.design._policy import POLICY
from dehyst.design._separability import Separability


@dataclass(frozen=True)
class PlanSection:
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
    sections: tuple[PlanSection, ...]
    separable: Separability
    one_loop: Separability

    @property
    def middle(self) -> float:
        """Where the motion begins and ends. [unit]"""
        return 0.5 * (self.low + self.high)

    @property
    def points(self) -> Array:
        """Start and tips of all sections, (K + 1,). [unit]"""
        points = [self.middle]
        for section in self.sections:
            points += section.tips
        return np.array(points)

    @property
    def stroke_s(self) -> Array:
        """Time of each stroke, (K,). [s]"""
        return np.concatenate([section.stroke_s for section in self.sections])

    @property
    def hold_s(self) -> Array:
        """Time at rest after each stroke, (K,). [s]"""
        return np.concatenate([section.hold_s for section in self.sections])

    @property
    def duration(self) -> float:
        """Of the whole motion. [s]"""
        return duration_of(self.sections)

    @property
    def begins(self) -> tuple[float, ...]:
        """When each section begins. [s]"""
        begins = [0.0]
        for section in self.sections[:-1]:
            begins.append(begins[-1] + section.duration)
        return tuple(begins)

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
        time, value, stroke = sampled(
            self.points, self.stroke_s, self.hold_s, period or self.period
        )
        # Samples know their stroke; each stroke belongs to the part of its section.
        parts: list[str] = []
        for section in self.sections:
            parts += [section.part] * len(section.tips)
        return time, value, np.array(parts)[stroke]


HOLD_PLACES = (0.8, -0.45, 0.6, -0.9, 0.25)  # the longest hold at the first one
# Tips of minor loops of 0.4 at 0.7, 0 and -0.7 of a falling branch.
LADDER = (1.0, 0.5, 0.9, -0.2, 0.2, -0.9, -0.5, -1.0)
NEST = (0.88, 0.06)  # first and last amplitude of the decaying loops
HOMED = (0.02, 0.95)  # smallest and largest radius that homing is for
HOMED_RADII = 24
# What candidates differ in: loops of the nest, range of the slow loops, number of holds, share of the time limit.
LEVELS = (8, 11)
REACHES = (0.3, 0.5, 0.8)
COUNTS = (2, 3, 4, 5)
TIMES = (0.5, 0.65, 0.8, 1.0)


def duration_of(sections: Sequence[PlanSection]) -> float:
    """Return the time that sections take together. [s]"""
    return sum([section.duration for section in sections])


def strokes_of(
    part: str, why: str, tips: Iterable[float], limits: Limits, hold_s: Sequence[float] = ()
) -> PlanSection:
    """Return a section that begins at zero, its strokes as fast as the limits allow."""
    ends = tuple(tips)
    ways = np.abs(np.diff([0.0, *ends]))
    holds = tuple(hold_s) + (0.0,) * (len(ends) - len(hold_s))
    return PlanSection(part, why, ends, tuple(limits.stroke_time(ways).tolist()), holds)


def _mirrored(section: PlanSection, why: str) -> PlanSection:
    tips = -np.array(section.tips)
    return replace(section, tips=tuple(tips.tolist()), why=why)


def _fast_loops(levels: int, limits: Limits) -> PlanSection:
    first, last = NEST
    nest = []
    # Amplitudes fall by a constant ratio, with alternating signs.
    for k in range(levels):
        nest.append(-first * (last / first) ** (k / (levels - 1)) * (-1.0) ** (k + 1))
    why = "whole range, minor loops of one size at three places, then loops that decay through all radii"
    return strokes_of("loops", why, [*LADDER, *nest, 0.0], limits)


def _slow_loops(reach: float, limits: Limits) -> PlanSection:
    why = f"the same shapes at a tenth of the rate: tells rate from hysteresis ({reach:g} of the range)"
    slow = Limits(limits.rate / POLICY.slow_by, limits.acceleration)
    return strokes_of("loops", why, [reach, -reach, 0.5 * reach, -0.25 * reach, 0.0], slow)


def holds_section(count: int, longest: float, limits: Limits) -> PlanSection:
    """Return `count` holds, the longest of `longest` seconds last, and the way back."""
    holds = [longest / POLICY.hold_ratio**k for k in range(count)]
    why = "times at rest, each three times the one before: creep shows where nothing moves"
    return strokes_of("holds", why, [*HOLD_PLACES[:count][::-1], 0.0], limits, holds[::-1])


def home_section(limits: Limits) -> PlanSection:
    """Return the decaying strokes that a plan begins and ends with."""
    radii = np.geomspace(*HOMED, HOMED_RADII)
    homing = shortest_homing(radii, -1.0, 1.0, limits, tolerance=POLICY.homing_left)
    why = f"decays: from any state before, the memory is known and {100 * homing.residual:.0f} % of it is left"
    return PlanSection(
        "home",
        why,
        tuple(homing.points[1:].tolist()),
        tuple(homing.stroke_s.tolist()),
        (0.0,) * homing.stroke_s.size,
    )


def frame(
    home: PlanSection, limits: Limits, levels: int, reach: float
) -> tuple[list[PlanSection], list[PlanSection]]:
    """Return all sections before and after the holds of the first half; the holds use the time that remains."""
    half = [_fast_loops(levels, limits), _slow_loops(reach, limits)]
    test = strokes_of("test", "loops that the others do not contain: not for the fit", [*UNSEEN_TIPS, 0.0],
                    Limits(limits.rate / POLICY.test_slower, limits.acceleration / POLICY.test_slower**2))  # fmt: skip
    why = "the same with all signs changed: creep to either side cancels"
    mirrored = [_mirrored(section, why) for section in half]
    return [home, *half], [*mirrored, test, home]


def plan_candidates(
    home: PlanSection, limits: Limits, time_limit: float, tau: float
) -> Iterator[tuple[PlanSection, ...]]:
    """Yield plans that keep the time, their holds as long as it allows."""
    for levels, reach in itertools.product(LEVELS, REACHES):
        before, after = frame(home, limits, levels, reach)
        fixed = duration_of((*before, *after))
        yielded = set()
        for count, share in itertools.product(COUNTS, TIMES):
            strokes = sum(holds_section(count, 0.0, limits).stroke_s)
            available = 0.5 * (share * time_limit * (1 - 1e-12) - fixed) - strokes
            ratios = sum([POLICY.hold_ratio**-k for k in range(count)])
            longest = min(available / ratios, POLICY.longest_hold * tau)
            shortest = longest / POLICY.hold_ratio ** (count - 1)
            # With plenty of time several shares give the same holds, as long as creep needs.
            if not shortest >= POLICY.shortest_hold_s or (count, longest) in yielded:
                continue
            yielded.add((count, longest))
            holds = holds_section(count, longest, limits)
            mirrored = _mirrored(holds, "the same with all signs changed")
            yield (*before, holds, *after[:2], mirrored, *after[2:])
