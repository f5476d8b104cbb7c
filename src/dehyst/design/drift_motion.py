"""Motion by which `drift` tells whether an actuator has changed: blocks of cycles alike, as many as it makes groups.

`drift` fits every group of cycles by itself and takes the scatter between them for the noise. So every group should
say the same, and enough: a block of three cycles, a fast one over the whole range, a smaller one, and a slow one, tells
offset, gain, size of the loop, curve and creep apart; twelve blocks are the most groups that drift makes. Before them
the motion visits both ends of the range, so that the memory is known and no cycle is lost.
"""

from __future__ import annotations

import math

from dehyst.design.design import check_period, limits_of, planned, separable_by
from dehyst.design.plan import ExcitationPlan, Section
from dehyst.design.plan_sections import strokes_of
from dehyst.design.separability import TIME_CONSTANTS
from dehyst.design.strokes import Limits
from dehyst.errors import ParameterError

BLOCKS = 12  # the most groups of cycles that drift makes; at four it begins to judge
CYCLES = 3 * BLOCKS
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
    tried = [_sections(share, *pace) for pace in PACES]
    sections = next((each for each in tried if _duration(each) <= time_limit), None)
    if sections is None:
        need = math.ceil(_duration(tried[-1]))
        raise ParameterError(
            f"a time limit of {time_limit:g} s is too short: {CYCLES} cycles at {limits.rate:.4g} {unit}/s take "
            f"{need} s. With fewer cycles drift cannot tell small changes from noise. Allow {need} s, a "
            f"higher rate or acceleration, or a smaller range.",
            time_limit=time_limit,
            needed=float(need),
        )
    figure = separable_by(sections[1:2], TIME_CONSTANTS)
    return planned((low, high, unit), period, limits, sections, figure, TIME_CONSTANTS)


def _sections(limits: Limits, slower: float, rest: float) -> tuple[Section, ...]:
    """Lead-in to the lower end, blocks that begin and end there, and back to the middle."""
    lead = strokes_of("home", "both ends: from here on the memory is known", [1.0, -1.0], limits)
    fast = limits.stroke_time([2.0, 2.0, 1.0 + MINOR, 2.0 * MINOR]).tolist()
    slow = limits.slower(slower).stroke_time([1.0 + MINOR, 2.0]).tolist()
    pace = f"one {slower:g} times slower" if slower > 1.0 else "one more"
    pause = f", at rest for {rest * fast[0]:.3g} s at its top" if rest else ""
    why = f"{BLOCKS} times: a cycle over the whole range, one of half the size, {pace}{pause}"
    holds = (0.0, 0.0, 0.0, 0.0, rest * fast[0], 0.0)
    tips = (1.0, -1.0, MINOR, -MINOR, 1.0, -1.0)
    cycles = Section("cycles", why, BLOCKS * tips, BLOCKS * (*fast, *slow), BLOCKS * holds)
    back = Section("home", "back to the middle", (0.0,), tuple(limits.stroke_time([1.0]).tolist()), (0.0,))
    return lead, cycles, back


def _duration(sections: tuple[Section, ...]) -> float:
    return sum(section.duration for section in sections)
