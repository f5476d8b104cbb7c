"""The thresholds by which a measured core is judged: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CorePolicy:
    """Numbers that decide what is said of a B-H loop.

    Shares are between 0 and 1.
    """

    # The tips are saturated where the loop rises by no more than this times vacuum; soft cores rise a hundred times
    # more steeply before. [-]
    saturated: float = 30.0
    # A rise at the tips of this share of the slope from tip to tip is none of noise: 5 % of it made half of that. [-]
    rising: float = 0.05
    # A loop is driven about zero if the middle of its field is within this share of half its range; current probes
    # have an offset of one or two hundredths. [-]
    even: float = 0.03
    # The integral of a voltage has no zero of its own: an offset above this share of half the swing is taken out.
    offset: float = 0.01
    # No core carries more: iron saturates at 2.2 T, iron-cobalt at 2.4 T. [T]
    most_density: float = 5.0
    # A loop that goes less far than this share of the largest one is a smaller loop.
    smaller: float = 0.9
    # The field of a model's path may go back by this share of its range between turns: what is more is smoothed, as
    # models change branch at every turn. [-]
    backward: float = 0.01
    # Smoothing of a path takes no more than this share of its samples at once: more would round its corners. [-]
    widest: float = 0.06
    # B falls while H rises where they correlate less than this; a loop as wide as a circle is about 0. [-]
    falling: float = -0.1


POLICY = CorePolicy()
