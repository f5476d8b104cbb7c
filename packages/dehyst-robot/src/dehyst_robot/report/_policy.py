"""The thresholds by which pages of the robot word and grade a result: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ResultPolicy:
    """Numbers that decide what a page says of a result.

    Shares are between 0 and 1.
    """

    # A ratio of errors that differs from 1 by no more than this is called unchanged: it is noise.
    unchanged: float = 0.02
    # A fit of a muscle is good up to this error on samples left out ... [% of the range of force]
    good: float = 2.0
    # ... and usable up to this one. [% of the range of force]
    usable: float = 5.0
    # A narrower loop is none. [% of the range of the response]
    narrow: float = 1e-4
    # Hill's curve may miss by this and still be drawn. [% of F_0]
    hill: float = 2.0


POLICY = ResultPolicy()
