"""Design of an excitation: which loops, rates and holds let hysteresis, creep and rate be told apart, in how long.

A plan consists of sections, in shares of half the range around its middle:

- home: decaying strokes after which the memory of every stop is known and all but spent (`shortest_homing`);
- loops: the whole range with minor loops of one size at three places on its branch, then a nest of loops that decays
  through the radii of the stops; again at a tenth of the rate, over a part of the range;
- holds: times at rest, each three times as long as the one before, at places on both sides;
- loops and holds again with all signs changed, so that creep to either side cancels;
- test: loops that none of the above contains, at two thirds of the rate, for judging what was identified;
- home.

How many loops and holds, how far the slow loops go and how long the holds are is chosen among candidates by the
smallest singular value of the regressors of the direct inverse (`separability`), within the time that is allowed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst.errors import ParameterError
from dehyst.evaluation.excitation import UNSEEN_TIPS
from dehyst.evaluation.homing import shortest_homing
from dehyst.evaluation.separability import TIME_CONSTANTS, Separability, separability
from dehyst.evaluation.strokes import PEAK_ACCELERATION, PEAK_RATE, Limits, sampled

Array = npt.NDArray[np.float64]

PARTS = ("home", "loops", "holds", "test")
FULL_STROKE_S = 4.0  # of the whole range, where no rate is given
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
LOOKS = 1500  # samples by which candidates are compared
AS_GOOD = 0.97  # a candidate with this share of the best singular value that takes less time is taken
MOST_SAMPLES = 20_000_000
FINEST = 1e-9  # width of a range by its ends
STROKE_SAMPLES = 8  # of the shortest stroke at least


@dataclass(frozen=True)
class Section:
    """Strokes of one purpose, one after the other.

    Attributes
    ----------
    part
        ``home``, ``loops``, ``holds`` or ``test``.
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
    """What to run on the rig for an identification of hysteresis, creep and rate.

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


def design_excitation(
    low: float,
    high: float,
    *,
    rate: float | None = None,
    acceleration: float | None = None,
    time_limit: float = 600.0,
    period: float = 0.02,
    time_constants: Sequence[float] = TIME_CONSTANTS,
    unit: str = "",
) -> ExcitationPlan:
    """Return the motion to run for an identification of hysteresis, creep and rate dependence.

    Parameters
    ----------
    low, high
        Range that the motion may use, and uses. [unit]
    rate
        Largest rate; None: that of a stroke over the whole range in 4 s. [unit/s]
    acceleration
        Largest acceleration; None: what the longest stroke of the loops takes at this rate. [unit/s^2]
    time_limit
        Longest duration; the plan may be shorter where more time does not make it better. [s]
    period
        Of the samples. [s]
    time_constants
        Of the creep that shall be told apart, (m,). [s]
    unit
        Of the range, for labels.

    Returns
    -------
    plan : ExcitationPlan

    Raises
    ------
    ParameterError
        If a value makes no sense, or limits and time cannot be met together; the message says what can.

    Examples
    --------
    >>> plan = design_excitation(-28.0, 28.0, rate=30.0, time_limit=400.0, unit="deg")
    >>> plan.duration <= 400.0, plan.peak_rate <= 30.0
    (True, True)
    >>> plan.separable.smallest > 5 * plan.one_loop.smallest
    True
    >>> time, value, part = plan.signal()
    >>> sorted(set(part.tolist()))
    ['holds', 'home', 'loops', 'test']
    """
    limits = limits_of(low, high, rate, acceleration)
    taus = _time_constants(time_constants)
    if not (math.isfinite(period) and period > 0):
        raise ParameterError(f"period = {period:g} s: no sampling. Pass the time between two samples, such as 0.02.")
    scale = 0.5 * (high - low)
    share = Limits(limits.rate / scale, limits.acceleration / scale)
    home = _home(share)
    found = list(_candidates(home, share, time_limit, max(taus)))
    if not found:
        _refuse_time(home, share, time_limit, limits, unit)
    looked = [(plan, _separable(_between(plan), taus)) for plan in found]
    best = max(figure.smallest for _, figure in looked)
    sections, figure = min(
        ((plan, figure) for plan, figure in looked if figure.smallest >= AS_GOOD * best),
        key=lambda each: sum(section.duration for section in each[0]),
    )
    shortest = min(min(section.stroke_s) for section in sections)
    if period * STROKE_SAMPLES > shortest:
        raise ParameterError(
            f"a period of {period:g} s takes {shortest / period:.1f} samples of the shortest stroke, {shortest:.3g} s: "
            f"it would not be smooth. Pass a period of {shortest / STROKE_SAMPLES:.2g} s at most, or a lower rate or "
            f"acceleration.",
            period=period,
            shortest=shortest,
        )
    duration = sum(section.duration for section in sections)
    if duration > MOST_SAMPLES * period:
        raise ParameterError(
            f"{duration:.4g} s at a period of {period:g} s are {duration / period:.3g} samples, more than a file "
            f"should hold. Pass a period of {duration / MOST_SAMPLES:.2g} s or more, or a higher rate or acceleration.",
            period=period,
        )
    middle = 0.5 * (low + high)
    scaled = tuple(replace(each, tips=tuple(middle + scale * tip for tip in each.tips)) for each in sections)
    loop = _one_loop(share, duration)
    return ExcitationPlan(low, high, unit, period, limits, scaled, figure, _separable((loop,), taus))


def limits_of(low: float, high: float, rate: float | None, acceleration: float | None) -> Limits:
    """Return limits of strokes in a range, with what is not given taken from the range as `design_excitation` says.

    The rate is never more than the longest stroke of the loops reaches within the acceleration.
    """
    size = max(abs(low), abs(high))
    if not (size <= _native.INPUT_LIMIT and high - low > FINEST * size):
        raise ParameterError(
            f"a range from {low:g} to {high:g} leaves no room to move; pass low < high, finite numbers of physical "
            f"size."
        )
    if rate is not None:
        Limits(rate)  # refuses what is no rate
    longest = 0.5 * (1.0 + NEST[0]) * (high - low)
    rate = PEAK_RATE * (high - low) / FULL_STROKE_S if rate is None else rate
    if acceleration is None:
        acceleration = PEAK_ACCELERATION * longest / (PEAK_RATE * longest / rate) ** 2
    limits = Limits(rate, acceleration)
    reached = PEAK_RATE * longest / float(limits.stroke_time(longest))  # a tenth of it is a decade
    return replace(limits, rate=min(rate, reached))


def _time_constants(values: Sequence[float]) -> tuple[float, ...]:
    taus = tuple(float(value) for value in values)
    if not taus or not all(math.isfinite(tau) and tau > 0 for tau in taus):
        raise ParameterError(f"time constants {taus} of creep: pass one or more positive numbers of seconds.")
    return taus


def _strokes(part: str, why: str, tips: Iterable[float], limits: Limits, hold_s: Sequence[float] = ()) -> Section:
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
    return _strokes("loops", why, [*LADDER, *nest, 0.0], limits)


def _slow_loops(reach: float, limits: Limits) -> Section:
    why = f"the same shapes at a tenth of the rate: tells rate from hysteresis ({reach:g} of the range)"
    slow = Limits(limits.rate / DECADE, limits.acceleration)
    return _strokes("loops", why, [reach, -reach, 0.5 * reach, -0.25 * reach, 0.0], slow)


def _holds(count: int, longest: float, limits: Limits) -> Section:
    holds = [longest / HOLD_RATIO**k for k in range(count)]
    why = "times at rest, each three times the one before: creep shows where nothing moves"
    return _strokes("holds", why, [*HOLD_PLACES[:count][::-1], 0.0], limits, holds[::-1])


def _home(limits: Limits) -> Section:
    radii = np.geomspace(*HOMED, HOMED_RADII)
    homing = shortest_homing(radii, -1.0, 1.0, limits, tolerance=HOMING_LEFT)
    why = f"decays: from any state before, the memory is known and {100 * homing.residual:.0f} % of it is left"
    return Section(
        "home", why, tuple(homing.points[1:].tolist()), tuple(homing.stroke_s.tolist()), (0.0,) * homing.stroke_s.size
    )


def _frame(home: Section, limits: Limits, levels: int, reach: float) -> tuple[list[Section], list[Section]]:
    """All sections before and after the first half's holds; the holds are what uses up the time that is left."""
    half = [_fast_loops(levels, limits), _slow_loops(reach, limits)]
    test = _strokes("test", "loops that the others do not contain: not for the fit", [*UNSEEN_TIPS, 0.0],
                    Limits(limits.rate / TEST_SLOWER, limits.acceleration / TEST_SLOWER**2))  # fmt: skip
    mirrored = [_mirrored(each, "the same with all signs changed: creep to either side cancels") for each in half]
    return [home, *half], [*mirrored, test, home]


LEVELS, REACHES, COUNTS, TIMES = (8, 11), (0.3, 0.5, 0.8), (2, 3, 4, 5), (0.5, 0.65, 0.8, 1.0)


def _candidates(home: Section, limits: Limits, time_limit: float, tau: float) -> Iterator[tuple[Section, ...]]:
    """Yield plans that keep the time, their holds as long as it allows."""
    for levels, reach in itertools.product(LEVELS, REACHES):
        before, after = _frame(home, limits, levels, reach)
        fixed = sum(section.duration for section in (*before, *after))
        seen = set()
        for count, share in itertools.product(COUNTS, TIMES):
            strokes = sum(_holds(count, 0.0, limits).stroke_s)
            left = 0.5 * (share * time_limit * (1 - 1e-12) - fixed) - strokes
            longest = min(left / sum(HOLD_RATIO**-k for k in range(count)), LONGEST_HOLD * tau)
            if not longest / HOLD_RATIO ** (count - 1) >= SHORTEST_HOLD_S or (count, longest) in seen:
                continue
            seen.add((count, longest))
            holds = _holds(count, longest, limits)
            mirrored = _mirrored(holds, "the same with all signs changed")
            yield (*before, holds, *after[:2], mirrored, *after[2:])


def _refuse_time(home: Section, limits: Limits, time_limit: float, asked: Limits, unit: str) -> None:
    before, after = _frame(home, limits, LEVELS[0], REACHES[0])
    fixed = sum(section.duration for section in (*before, *after))
    holds = 2.0 * _holds(COUNTS[0], HOLD_RATIO ** (COUNTS[0] - 1) * SHORTEST_HOLD_S, limits).duration
    need = math.ceil(fixed + holds)
    of = f" {unit}" if unit else ""
    raise ParameterError(
        f"a time limit of {time_limit:g} s is too short: at a rate of {asked.rate:.4g}{of}/s and an acceleration of "
        f"{asked.acceleration:.4g}{of}/s^2 the shortest plan takes {need} s ({fixed:.0f} s of strokes, holds of 1 and "
        f"3 s on both sides). Without all of its parts creep cannot be told from hysteresis. Allow {need} s, a higher "
        f"rate or acceleration, or a smaller range.",
        time_limit=time_limit,
        needed=float(need),
    )


def _between(sections: Sequence[Section]) -> tuple[Section, ...]:
    """What is fitted: neither home nor test."""
    return tuple(section for section in sections if section.part in ("loops", "holds"))


def _separable(sections: Sequence[Section], taus: Sequence[float]) -> Separability:
    points = np.array([0.0, *itertools.chain(*(section.tips for section in sections))])
    stroke, hold = (
        np.array([*itertools.chain(*times)])
        for times in ([each.stroke_s for each in sections], [each.hold_s for each in sections])
    )
    period = float(stroke.sum() + hold.sum()) / LOOKS
    _, value, _ = sampled(points, stroke, hold, period)
    return separability(value, period, time_constants=taus)


def _one_loop(limits: Limits, duration: float) -> Section:
    """Loop over the whole range at the same rate, as often as the time allows."""
    whole = float(limits.stroke_time(2.0))
    count = max(1, int(duration / (2.0 * whole)))
    return _strokes("loops", "", [1.0, -1.0] * count + [0.0], limits)
