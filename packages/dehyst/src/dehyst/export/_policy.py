"""The thresholds by which an exported unit is refused, warned of and proved: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ExportPolicy:
    """Numbers that decide what is said of a unit before it drives a machine.

    Shares are between 0 and 1.
    """

    # In float a unit answers within this share of the output's range: that is the promise of its proof.
    tolerance: float = 1e-5
    # Where neighbouring floats are further apart than this share of the range, that promise is not reached.
    coarse: float = 2e-6
    # A lag that in float stops so far from its end, as a share of the range, is worth a word.
    stalled: float = 0.01
    # An input counts as outside when it leaves the identified range by more than this share of it.
    edge: float = 0.02
    # A unit whose limits are closer than this share of the identified range would do nothing.
    narrowest: float = 1e-6
    # An excerpt of a log should use this share of the input's range, or agreement on it proves little.
    excerpt_share: float = 0.1
    # From so many operators on the cost of a step is worth a word. [operators]
    many_operators: int = 1000
    # A dead time that is rounded to whole periods by more than this share of it is worth a word.
    rounded_dead_time: float = 0.02


POLICY = ExportPolicy()
