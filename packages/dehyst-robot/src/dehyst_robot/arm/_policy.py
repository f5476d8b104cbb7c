"""The thresholds by which an arm, or a motion of it, is refused: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ArmPolicy:
    """Numbers that decide what the simulation of an arm takes.

    Shares are between 0 and 1.
    """

    # Here the simulation of a joint ends: beyond, the map of a muscle is wrong, and end stops are not simulated.
    # [ranges of the joint]
    beyond: float = 1.25
    # The polynomial of a tendon's moment arm may be off by this share of the largest arm.
    tolerated_arm: float = 1e-4
    # The table of a muscle may be off by this share of the full force, that at no contraction and the highest pressure.
    table_error: float = 1e-3


POLICY = ArmPolicy()
