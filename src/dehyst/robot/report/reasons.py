"""Explains in sentences where the largest errors are, and which limits and faults occurred."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.data.loops import turning_points
from dehyst.report.text import number
from dehyst.robot.experiments.results import PlantResult, Reproduction, TrialRun
from dehyst.robot.report.numbers import OFF, joints_of, pair_of, same_run, seed_figure, trial_name, trials_of

# "Near a turn": within this share of the joint's range of motion. "Large": this many times its rms over the run.
# "Standing still": slower than this share of the largest speed.
NEAR, LARGE, STILL = 0.10, 3.0, 0.01
# A turn is to blame only for an error of which at least this share has come since.
GROWN = 0.5
SMALLEST = 0.001  # angle that is given as a number [deg]
BAR = 1e5
# A push: this share of the compensator's range at least, within this share of the joint's motion at most.
JUMP, TRAVEL = 0.03, 0.01
# Bits of the flags, as in core/dehyst.h.
LIMITS, FAULTS = 16 | 32, 1 | 2 | 4 | 8 | 64 | 128
KINDS = ((16, "the desired pressure was limited"), (32, "a valve was limited"), (FAULTS, "a fault was flagged"))


@dataclass(frozen=True)
class Place:
    """What the runs show where the error with compensator is largest."""

    error: float  # there [rad]
    without: float  # error without compensator at the same moment [rad]
    time: float  # from the start of the path [s]
    figure: str  # name of the path's figure, or ""
    turn: Turn  # the joint seen from its last turn
    speed: float  # desired speed there over the largest one
    compensation_rate: float  # largest rate of the compensator's pressure in the last 0.1 s, over its rms in the run
    acceleration: float  # largest desired acceleration in the last 0.1 s, over its rms in the run
    limited: bool  # whether a pressure or a valve was limited there


def largest_error(off: TrialRun, on: TrialRun, joint: int) -> Place:
    """Find where the error with compensator is largest and measure what happens there."""
    j = joint - 1
    t, q = on.time, on.desired[:, j]
    k = int(np.argmax(np.abs(on.error[:, j])))
    speed = np.abs(_rate(q, t))
    acceleration, compensation = np.abs(_rate(_rate(q, t), t)), np.abs(_rate(on.compensation[:, j], t))
    return Place(
        error=float(on.error[k, j]),
        without=float(np.interp(t[k], off.time, off.error[:, j])),
        time=float(t[k] - t[0]),
        figure=figure_name(on, k),
        turn=turn_before(on, joint, k),
        speed=float(speed[k]) / max(float(speed.max()), 1e-300),
        compensation_rate=_lately(compensation, t, k) / _rms(compensation),
        acceleration=_lately(acceleration, t, k) / _rms(acceleration),
        limited=bool(np.any(on.flags[max(0, k - 3) : k + 4, j] & LIMITS)),
    )


def figure_name(run: TrialRun, k: int) -> str:
    """Return which figure of the path is being followed at sample k, "" on the way between two."""
    number_ = int(run.figure[k])
    return run.figures[number_] if 0 <= number_ < len(run.figures) else ""


def _rate(values: Array, t: Array) -> Array:
    return np.gradient(values, t) if values.size > 1 else np.zeros_like(values)


def _rms(values: Array) -> float:
    return max(float(np.sqrt(np.mean(values**2))), 1e-300)


def _lately(values: Array, t: Array, k: int) -> float:
    """Largest value in the last 0.1 s or three samples up to k."""
    first = min(int(np.searchsorted(t, t[k] - 0.1)), max(0, k - 3))
    return float(np.max(values[first : k + 1]))


def in_words(place: Place, largest_off: float, largest_on: float) -> str:
    """Return a few sentences about the largest error."""
    where = f" in the {place.figure}" if place.figure else ""
    return (
        f"Largest error {number(largest_on)}° with, {number(largest_off)}° without compensator. With it, it lies at "
        f"{number(place.time)} s{where}, {_moment(place)}; without compensator the error at that moment is "
        f"{number(np.rad2deg(abs(place.without)))}°. {_cause(place)}"
    )


def _moment(place: Place) -> str:
    turn = place.turn
    since = "the start" if turn.first else "its last turn"
    if place.speed <= STILL and turn.travel > TRAVEL:
        return f"while the joint stands still, {number(turn.since, 2)} s after {since}"
    if turn.ahead <= NEAR < turn.travel:
        return "just before the joint turns or stops"
    return f"{number(turn.since, 2)} s and {travelled(turn)} after {since}"


def _cause(place: Place) -> str:
    turn = place.turn
    fast, turned = place.compensation_rate >= LARGE, turn.travel <= NEAR and not turn.first
    if place.limited:
        return "A pressure or a valve was limited there, so what the compensator asked for was not done."
    if turn.is_push and turn.grown >= GROWN:
        words = push_words(turn)
        return f"{words[0].upper()}{words[1:]}"
    if turned and fast and turn.grown >= GROWN:
        return (
            f"The compensator changes its pressure difference there {number(place.compensation_rate, 2)} times as fast "
            "as on average (rms): after a turn the inverse has its largest slope, and what is wrong in its timing or "
            "size shows at once."
        )
    if place.acceleration >= LARGE:
        return (
            f"The desired acceleration there is {number(place.acceleration, 2)} times its rms: what the nominal "
            "inertia leaves over, the compensator does not touch."
        )
    if turn.first and turn.travel <= NEAR:
        return "The joint has hardly moved yet: the memory of its muscles at the start is not known."
    if place.speed <= STILL or place.compensation_rate < 1.0 / LARGE:
        return "The compensator hardly moves there, so what is left is not its timing: the model leaves it, or creep."
    if turned:
        return "It lies right after a turn, but the compensator does not move fast there."
    return "No turn, limit or large acceleration is near: the model leaves it over."


def travelled(turn: Turn) -> str:
    """Return how far the joint should have moved since its turn."""
    return f"{number(turn.travel_deg, 2)}°" if turn.travel_deg >= SMALLEST else f"less than {SMALLEST}°"


def push_words(turn: Turn) -> str:
    """Return what the compensator did right after a turn: "in those 0.02° the compensator has changed ..."."""
    return (
        f"in those {travelled(turn)} the compensator has changed the pressure difference by {number(turn.jump_bar, 2)} "
        f"bar, {number(100 * turn.jump, 2)} % of its range, and the joint has run ahead by "
        f"{number(turn.pushed_deg, 2)}°: right after a turn the inverse is steepest, and what is too much pushes the "
        "joint."
    )


@dataclass(frozen=True)
class Turn:
    """A joint at a moment, seen from its last turn."""

    since: float  # time since the turn, or since the start [s]
    first: bool  # whether the joint has not turned before
    travel_deg: float  # how far it should have moved since [deg]
    travel: float  # the same as a share of its range of motion
    ahead: float  # how far it will move to the next turn, as such a share
    jump_bar: float  # by how much the compensator has changed its pressure difference since [bar]
    jump: float  # the same as a share of the compensator's range in the run
    pushed_deg: float  # how far the joint has run ahead since, in the direction of that change [deg]
    grown: float  # share of the error that has come since the turn

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


def limit_words(plant: PlantResult) -> str:
    """Say where limits were reached, or that they were not."""
    if not plant.runs:
        return ""
    found = [words for run in plant.runs for words in _of_run(run)]
    if not found:
        return "No pressure or valve was limited and no sensor fault flagged at any logged moment of the trials."
    return f"Limits and faults at the logged moments: {'; '.join(found)}."


def _of_run(run: TrialRun) -> list[str]:
    side = "without" if run.compensator == OFF else "with compensator"
    said = []
    for bits, words in KINDS:
        hit = (run.flags & bits) != 0
        if hit.any():
            joints = ", ".join(str(j + 1) for j in np.flatnonzero(hit.any(axis=0)).tolist())
            share = number(100 * float(hit.any(axis=1).mean()), 2)
            said.append(f"{trial_name(run.trial)} {side}: {words} in {share} % of the time (joint {joints})")
    return said


def largest_errors(result: Reproduction, plant: PlantResult) -> tuple[tuple[str, str, bool], ...]:
    """Return for every joint and trial of the first seed: its name, words about the largest error, whether it rose."""
    found = []
    for joint in joints_of(result):
        for trial in trials_of(result):
            off, on = pair_of(plant, trial, result.compensator)
            if off is None or on is None or same_run(off, on):
                continue
            place = largest_error(off, on, joint)
            sizes = [_largest(plant, run, joint) for run in (off, on)]
            found.append((f"Joint {joint}, {trial_name(trial)}", in_words(place, *sizes), sizes[1] > sizes[0]))
    return tuple(found)


def _largest(plant: PlantResult, run: TrialRun, joint: int) -> float:
    """Largest error as the tables have it; from the run itself if its seed has no figures. [deg]"""
    told = seed_figure(plant, run.seed, joint, run.trial, run.compensator, "max_deg")
    return float(np.rad2deg(np.max(np.abs(run.error[:, joint - 1])))) if told is None else told
