"""The thresholds by which a motion to log is chosen: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DesignPolicy:
    """Numbers that decide which motion is proposed, and what it is made of.

    Shares are between 0 and 1.
    """

    # Among candidates with this share of the best singular value the one that takes the least time is chosen.
    as_good: float = 0.97
    # Where no rate is typed, a stroke over the whole range takes so long. [s]
    full_stroke_s: float = 4.0
    # The shortest stroke has so many samples at least: fewer do not show its course. [samples]
    stroke_samples: int = 8
    # A range is refused if its width is no more than this share of its ends: its digits would be lost.
    finest: float = 1e-9

    # Slow loops are slower by this: a decade shows what depends on rate. [factor]
    slow_by: float = 10.0
    # The loops for the test are slower by this than those for the fit. [factor]
    test_slower: float = 1.5
    # A hold is so many times as long as the next shorter one, which tells time constants apart. [factor]
    hold_ratio: float = 3.0
    # The longest hold is no longer than this: by then 63 % of the creep is over. [longest time constants]
    longest_hold: float = 1.0
    # No hold is shorter than this: creep needs time to show. [s]
    shortest_hold_s: float = 1.0
    # Homing may leave this share of what the stops can hold.
    homing_left: float = 0.1
    # Cycles for the check of drift are repeated so often: the most groups that drift makes; at four it begins to judge.
    # [groups]
    groups: int = 12


POLICY = DesignPolicy()
