"""The thresholds by which commands warn, and a limit where none is typed: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CommandPolicy:
    """Numbers that decide what a command says of a signal that it plays.

    Shares are between 0 and 1.
    """

    # A signal that leaves the identified range by more than this share of it is worth a warning.
    beyond: float = 0.02
    # A past that errs by more than this share of the output's range explains no log.
    past_unexplained: float = 0.05
    # Two logs that are this share of a range apart do not join.
    past_apart: float = 0.05
    # Of a log that tells the past so many samples are looked at, the last ones. [samples]
    known_samples: int = 5000
    # A step of the computed input between two samples, as a share of the identified range, that is worth a warning.
    jump: float = 0.1
    # A jump is the inverse's, which a firmer eps lowers, where it is so many times that of the reference, of their
    # ranges. [factor]
    steeper_jump: float = 2.0
    # A band narrower than this share of its largest width has closed.
    closed: float = 1e-6
    # A motion may take so long where no limit is typed. [s]
    usual_limit: float = 600.0


POLICY = CommandPolicy()
