"""The thresholds by which readings of an axis are judged: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BacklashPolicy:
    """Numbers that decide which readings count, and whether a table is written.

    Shares are between 0 and 1.
    """

    # Lost motion, drift or a pitch error that chance alone would show with this probability is no finding.
    chance: float = 0.01
    # The printed interval of a lost motion leaves out the truth with this probability.
    outside: float = 0.05
    # An outlier is judged by the spread of the other readings, which fewer degrees of freedom do not tell. [degrees of
    # freedom]
    fewest_freedom: int = 4
    # Commands that differ by no more than this share of the way are one point: encoders flicker by a count or two.
    same_point: float = 1e-4
    # A measured way that differs from the commanded one by more than this share is another unit or a wrong column.
    largest_scale: float = 0.2
    # A scale error above this share is one of steps per unit: corrected there, it is right beyond the table as well. A
    # smaller one is called so too if it is a straight line, and larger over the axis than the lost motion.
    scale: float = 0.001
    # No screw or belt changes its error by more than this share of the way, a straight line apart.
    steepest: float = 0.01
    # A lost motion above this share of the approach may be larger: the axis may not have followed to the end.
    of_approach: float = 0.5
    # A stop in a log is a reading if it lasts at least this share of the longest one; at turns axes stop for a moment.
    shortest_hold: float = 0.5
    # A plan of more readings is a slip of the keyboard: at 5 s each they would take a day. [readings]
    most_readings: int = 17280


POLICY = BacklashPolicy()
