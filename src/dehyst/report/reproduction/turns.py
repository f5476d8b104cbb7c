"""What the compensator of a joint did since the joint last turned: right after a turn the inverse is steepest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dehyst.experiments.results import TrialRun
from dehyst.loops import turning_points

BAR = 1e5
# A push: this share of the compensator's range at least, within this share of the joint's motion at most.
JUMP, TRAVEL = 0.03, 0.01


@dataclass(frozen=True)
class Turn:
    """A joint at a moment, seen from its last turn.

    Attributes
    ----------
    since
        Time since the turn, or since the start. [s]
    first
        Whether the joint has not turned before.
    travel_deg
        How far it should have moved since. [deg]
    travel, ahead
        The same, and how far it will move to the next turn, as shares of its range of motion.
    jump_bar
        By how much the compensator has changed its pressure difference since. [bar]
    jump
        The same as a share of the compensator's range in the run.
    pushed_deg
        How far the joint has run ahead of its desired angle since, in the direction of that change. [deg]
    grown
        Share of the error that has come since the turn.
    """

    since: float
    first: bool
    travel_deg: float
    travel: float
    ahead: float
    jump_bar: float
    jump: float
    pushed_deg: float
    grown: float

    @property
    def is_push(self) -> bool:
        """Whether the compensator has changed much while the joint should hardly move, and the joint ran ahead."""
        return self.jump >= JUMP and self.travel <= TRAVEL and self.pushed_deg > 0.0


def turn_before(run: TrialRun, joint: int, k: int) -> Turn:
    """Return sample k of a run, seen from the last turn of a joint."""
    q, error, added = run.desired[:, joint - 1], run.error[:, joint - 1], run.compensation[:, joint - 1]
    span = max(float(np.ptp(q)), 1e-12)
    turns = turning_points(q, 0.01 * span)
    n = int(np.searchsorted(turns, k, side="right"))
    last, coming = int(turns[n - 1]), int(turns[min(n, turns.size - 1)])
    way, change = float(abs(q[k] - q[last])), float(added[k] - added[last])
    jump = abs(change)
    return Turn(
        since=float(run.time[k] - run.time[last]),
        first=last == 0,
        travel_deg=float(np.rad2deg(way)),
        travel=way / span,
        ahead=float(abs(q[coming] - q[k])) / span,
        jump_bar=jump / BAR,
        jump=jump / max(float(np.ptp(added)), 1e-300),
        pushed_deg=float(-np.sign(change) * np.rad2deg(error[k] - error[last])),
        grown=float((error[k] - error[last]) / error[k]) if error[k] else 0.0,
    )
