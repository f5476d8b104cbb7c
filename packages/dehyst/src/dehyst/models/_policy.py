"""The thresholds by which the use of a model is warned of and its steps are chosen: one record, with reasons."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ModelPolicy:
    """Numbers that decide what is said when a model is used, and how it steps.

    Shares are between 0 and 1.
    """

    # An inverse that amplifies by more than so many times the ratio of the ranges turns noise into steps. [factor]
    high_gain: float = 20.0
    # A unit that runs more seldom than this misses what the log shows of time. [periods of the log]
    too_slow: float = 10.0
    # Within twice the speed nothing is said: a sine passes its middle 1.6 times as fast as a triangle of the same
    # period, and what creep and lags of a model say changes little within a factor of two. [factor]
    faster: float = 2.0
    # So far beyond the identified range of the output a solution is looked for, as a share of that range.
    followed_beyond: float = 0.1
    # Stops and paths up to this share of the largest radius are one group of a direct inverse, longer ones another.
    short: float = 0.25
    # Up to so many operators "auto" steps densely. There the worst logarithmic step costs as much as a dense one and
    # the typical one a sixth (benchmarks/step.py); but dense steps have the bits of blocks and of all exported code.
    # [operators]
    dense_up_to: int = 100
    # A signal turns, for the offset of the last cycle, when it has gone back by this share of the range.
    turn: float = 0.05
    # That offset is limited to no more than this share of the range: an inverse's demand still turns where its
    # reference turns.
    offset_most: float = 0.5

    # Turning points of a past that is looked for may lie so far beyond the identified range, as a share of it.
    past_beyond: float = 0.1
    # Pasts whose errors differ by less than this share explain the samples alike; the one with the fewest turns counts.
    past_alike: float = 0.02
    # A past has one turn more where that brings the error below this share.
    past_further_turn: float = 0.7
    # All pasts are possible that err up to so many times as much as the best one, ... [factor]
    past_doubt: float = 1.5
    # ... and by this share of the output's range more.
    past_open: float = 1e-3


POLICY = ModelPolicy()
