"""Designs motions to log: one that separates hysteresis, creep and rate, and one for `drift` to compare.

The plan for an identification consists of sections, in shares of half the range around its middle:

- home: decaying strokes after which the memory of every stop is known and all but spent (`shortest_homing`);
- loops: the whole range with minor loops of one size at three places on its branch, then a nest of loops that decays
  through the radii of the stops; again at a tenth of the rate, over a part of the range;
- holds: times at rest, each three times as long as the one before, at places on both sides;
- loops and holds again with all signs changed, so that creep to either side cancels;
- test: loops that none of the above contains, at two thirds of the rate, for judging what was identified;
- home.

How many loops and holds, how far the slow loops go and how long the holds are is chosen among candidates by the
smallest singular value of the regressors of the direct inverse (`separability`), within the time that is allowed.

`drift` fits every group of cycles by itself and takes the scatter between them for the noise. So every group should
say the same, and enough: a block of three cycles, a fast one over the whole range, a smaller one, and a slow one, tells
offset, gain, size of the loop, curve and creep apart; twelve blocks are the most groups that drift makes. Before them
the motion visits both ends of the range, so that the memory is known and no cycle is lost.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import dehyst._native as _native
from dehyst.design._excitation import PEAK_ACCELERATION, PEAK_RATE, Limits, sampled
from dehyst.design._plan import (
    COUNTS,
    LEVELS,
    NEST,
    REACHES,
    ExcitationPlan,
    PlanSection,
    duration_of,
    frame,
    holds_section,
    home_section,
    plan_candidates,
    strokes_of,
)
from dehyst.design._policy import POLICY
from dehyst.design._separability import TIME_CONSTANTS, Separability, separability
from dehyst.errors import ParameterError

LOOKS = 1500  # samples by which candidates are compared
MOST_SAMPLES = 20_000_000


def design_excitation(
    low: float,
    high: float,
    *,
    rate: float | None = None,
    acceleration: float | None = None,
    time_limit: float = 600.0,
    period: float = 0.02,
    time_constants: Sequence[float] = TIME_CONSTANTS,
    hold: float | None = None,
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
    hold
        Length of the longest rest, at least; None: as long as the time allows, no longer than the longest time
        constant. [s]
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
    check_period(period)
    share = limits.shares(0.5 * (high - low))
    home = home_section(share)
    longest = max(taus)
    if hold is not None:
        longest = max(_positive_hold(hold), longest)
    plans = list(plan_candidates(home, share, time_limit, longest))
    if not plans:
        _refuse_time(home, share, time_limit, limits, unit)
    if hold is not None:
        plans = [plan for plan in plans if _longest_hold(plan) >= hold]
        if not plans:
            _refuse_hold(home, share, time_limit, hold)
    figures = [separable_by(_between(plan), taus) for plan in plans]
    best = max(figure.smallest for figure in figures)
    # Among plans that are nearly as good as the best the shortest is chosen.
    shortest = float("inf")
    for plan, candidate in zip(plans, figures, strict=True):
        duration = duration_of(plan)
        if candidate.smallest >= POLICY.as_good * best and duration < shortest:
            sections, figure, shortest = plan, candidate, duration
    return planned((low, high, unit), period, limits, sections, figure, taus)


def planned(
    span: tuple[float, float, str],
    period: float,
    limits: Limits,
    sections: tuple[PlanSection, ...],
    figure: Separability,
    taus: Sequence[float],
) -> ExcitationPlan:
    """Return a plan from its sections in shares of half the range; refuse a period at which it would not be smooth."""
    low, high, unit = span
    shortest = min([min(section.stroke_s) for section in sections])
    if period * POLICY.stroke_samples > shortest:
        most = 0.95 * shortest / POLICY.stroke_samples  # short enough when rounded to two digits
        raise ParameterError(
            f"a period of {period:g} s takes {shortest / period:.1f} samples of the shortest stroke, {shortest:.3g} s: "
            f"it would not be smooth. Pass a period of {most:.2g} s at most, or a lower rate or acceleration.",
            period=period,
            shortest=shortest,
        )
    duration = duration_of(sections)
    if duration > MOST_SAMPLES * period:
        least = 1.05 * duration / MOST_SAMPLES  # long enough when rounded to two digits
        raise ParameterError(
            f"{duration:.4g} s at a period of {period:g} s are {duration / period:.3g} samples, more than a file "
            f"should hold. Pass a period of {least:.2g} s or more, or a higher rate or acceleration.",
            period=period,
        )
    middle, scale = 0.5 * (low + high), 0.5 * (high - low)
    scaled = []
    for section in sections:
        tips = middle + scale * np.array(section.tips)
        scaled.append(replace(section, tips=tuple(tips.tolist())))
    loop = _one_loop(limits.shares(scale), duration)
    return ExcitationPlan(
        low, high, unit, period, limits, tuple(scaled), figure, separable_by((loop,), taus)
    )


def limits_of(low: float, high: float, rate: float | None, acceleration: float | None) -> Limits:
    """Return limits of strokes in a range; what is left out follows from the range, as `design_excitation` says.

    The rate is never more than the longest stroke of the loops reaches within the acceleration.
    """
    size = max(abs(low), abs(high))
    if not (size <= _native.INPUT_LIMIT and high - low > POLICY.finest * size):
        raise ParameterError(
            f"a range from {low:g} to {high:g} leaves no room to move; pass low < high, finite numbers of physical "
            f"size."
        )
    if rate is not None:
        Limits(rate)  # refuses what is no rate
    longest = 0.5 * (1.0 + NEST[0]) * (high - low)
    if rate is None:
        rate = PEAK_RATE * (high - low) / POLICY.full_stroke_s
    if acceleration is None:
        acceleration = PEAK_ACCELERATION * longest / (PEAK_RATE * longest / rate) ** 2
    limits = Limits(rate, acceleration)
    # The slow loops take a tenth of the rate, so it must be the one that the fast loops really reach.
    reached = PEAK_RATE * longest / float(limits.stroke_time(longest))
    return replace(limits, rate=min(rate, reached))


def check_period(period: float) -> None:
    """Refuse what is no time between two samples."""
    if not (math.isfinite(period) and period > 0):
        raise ParameterError(
            f"period = {period:g} s: no sampling. Pass the time between two samples, such as 0.02."
        )


def _time_constants(values: Sequence[float]) -> tuple[float, ...]:
    taus = tuple(map(float, values))
    if not taus or not (np.isfinite(taus) & (np.array(taus) > 0)).all():
        raise ParameterError(
            f"time constants {taus} of creep: pass one or more positive numbers of seconds."
        )
    return taus


def _positive_hold(hold: float) -> float:
    if not (math.isfinite(hold) and hold > 0.0):
        raise ParameterError(
            f"hold = {hold:g} s: pass how long to rest, a positive number of seconds.", hold=hold
        )
    return hold


def _refuse_hold(home: PlanSection, limits: Limits, time_limit: float, hold: float) -> None:
    before, after = frame(home, limits, LEVELS[0], REACHES[0])
    rests = (
        2.0
        * holds_section(
            COUNTS[0], max(hold, POLICY.hold_ratio * POLICY.shortest_hold_s), limits
        ).duration
    )
    need = math.ceil(1.01 * (duration_of((*before, *after)) + rests))
    raise ParameterError(
        f"a time limit of {time_limit:g} s leaves no rest of {hold:g} s to either side beside the loops. Allow {need} "
        f"s (--time-limit {need}), a shorter rest, or a higher rate.",
        time_limit=time_limit,
        needed=float(need),
    )


def _refuse_time(
    home: PlanSection, limits: Limits, time_limit: float, asked: Limits, unit: str
) -> None:
    before, after = frame(home, limits, LEVELS[0], REACHES[0])
    fixed = duration_of((*before, *after))
    longest = POLICY.hold_ratio ** (COUNTS[0] - 1) * POLICY.shortest_hold_s
    need = math.ceil(fixed + 2.0 * holds_section(COUNTS[0], longest, limits).duration)
    of = " " * bool(unit) + unit
    raise ParameterError(
        f"a time limit of {time_limit:g} s is too short: at a rate of {asked.rate:.4g}{of}/s and an acceleration of "
        f"{asked.acceleration:.4g}{of}/s^2 the shortest plan takes {need} s ({fixed:.0f} s of strokes, holds of 1 and "
        f"3 s on both sides). Without all of its parts creep cannot be told from hysteresis. Allow {need} s, a higher "
        f"rate or acceleration, or a smaller range.",
        time_limit=time_limit,
        needed=float(need),
    )


def _between(sections: Sequence[PlanSection]) -> tuple[PlanSection, ...]:
    """Return the sections that are fitted: neither home nor test."""
    return tuple(section for section in sections if section.part in ("loops", "holds"))


def separable_by(sections: Sequence[PlanSection], taus: Sequence[float]) -> Separability:
    """Return how well the effects can be told apart along sections."""
    tips, stroke_s, hold_s = [0.0], list[float](), list[float]()
    for section in sections:
        tips += section.tips
        stroke_s += section.stroke_s
        hold_s += section.hold_s
    points, stroke, hold = np.array(tips), np.array(stroke_s), np.array(hold_s)
    # Coarse samples are enough to compare candidates.
    period = float(stroke.sum() + hold.sum()) / LOOKS
    _, value, _ = sampled(points, stroke, hold, period)
    return separability(value, period, time_constants=taus)


def _one_loop(limits: Limits, duration: float) -> PlanSection:
    """Loop over the whole range at the same rate, as often as the time allows."""
    whole = float(limits.stroke_time(2.0))
    count = max(1, int(duration / (2.0 * whole)))
    return strokes_of("loops", "", [1.0, -1.0] * count + [0.0], limits)


CYCLES = 3 * POLICY.groups
# Times as long as a fast one takes the slow cycle, and rest at its top, by the time of a fast stroke; the first that
# the time allows is taken. The slower it is, the better is creep told from the loop.
PACES = ((4.0, 4.0), (3.0, 4.0), (3.0, 2.0), (2.0, 0.0), (1.0, 0.0))
MINOR = 0.5  # tips of the smaller cycle


def design_drift_motion(
    low: float,
    high: float,
    *,
    rate: float | None = None,
    acceleration: float | None = None,
    time_limit: float = 600.0,
    period: float = 0.02,
    unit: str = "",
) -> ExcitationPlan:
    """Return the motion to log once from the new actuator, and again whenever `drift` is asked.

    Parameters
    ----------
    low, high
        Range that the motion uses: that of the signal which drives the model, as its card names it. [unit]
    rate, acceleration
        Largest ones; None: those of a stroke over the whole range in 4 s. [unit/s, unit/s^2]
    time_limit
        Longest duration; where it is short, the slow cycles are faster and do not rest. [s]
    period
        Of the samples. [s]
    unit
        Of the range, for labels.

    Returns
    -------
    plan : ExcitationPlan
        Whose sections are "home", "cycles" and "home".

    Raises
    ------
    ParameterError
        If a value makes no sense, or limits and time cannot be met together; the message says what can.

    Examples
    --------
    >>> plan = design_drift_motion(0.0, 5.0, unit="bar")
    >>> [section.part for section in plan.sections], plan.duration <= 600.0
    (['home', 'cycles', 'home'], True)
    """
    limits = limits_of(low, high, rate, acceleration)
    check_period(period)
    share = limits.shares(0.5 * (high - low))
    # The first pace that keeps the time limit is the slowest one that does.
    for pace in PACES:
        sections = _sections(share, *pace)
        if duration_of(sections) <= time_limit:
            break
    else:
        need = math.ceil(duration_of(sections))
        raise ParameterError(
            f"a time limit of {time_limit:g} s is too short: {CYCLES} cycles at {limits.rate:.4g} {unit}/s take "
            f"{need} s. With fewer cycles drift cannot tell small changes from noise. Allow {need} s, a "
            f"higher rate or acceleration, or a smaller range.",
            time_limit=time_limit,
            needed=float(need),
        )
    figure = separable_by(sections[1:2], TIME_CONSTANTS)
    return planned((low, high, unit), period, limits, sections, figure, TIME_CONSTANTS)


def _sections(limits: Limits, slower: float, rest: float) -> tuple[PlanSection, ...]:
    """Return the lead-in to the lower end, blocks that begin and end there, and the way back to the middle."""
    lead = strokes_of("home", "both ends: from here on the memory is known", [1.0, -1.0], limits)
    # Times of the strokes of one block, in the order of `tips` below.
    fast = limits.stroke_time([2.0, 2.0, 1.0 + MINOR, 2.0 * MINOR]).tolist()
    slow = limits.slower(slower).stroke_time([1.0 + MINOR, 2.0]).tolist()
    pace = f"one {slower:g} times slower" if slower > 1.0 else "one more"
    pause = ""
    if rest:
        pause = f", at rest for {rest * fast[0]:.3g} s at its top"
    why = (
        f"{POLICY.groups} times: a cycle over the whole range, one of half the size, {pace}{pause}"
    )
    holds = (0.0, 0.0, 0.0, 0.0, rest * fast[0], 0.0)
    tips = (1.0, -1.0, MINOR, -MINOR, 1.0, -1.0)
    cycles = PlanSection(
        "cycles", why, POLICY.groups * tips, POLICY.groups * (*fast, *slow), POLICY.groups * holds
    )
    back = PlanSection(
        "home", "back to the middle", (0.0,), tuple(limits.stroke_time([1.0]).tolist()), (0.0,)
    )
    return lead, cycles, back


def _longest_hold(sections: Sequence[PlanSection]) -> float:
    return max([max(section.hold_s) for section in sections])
