"""Where the largest errors lie and what happens there: sentences computed from the runs, no guesses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.experiments.results import TrialRun
from dehyst.loops import turning_points
from dehyst.report.text import number

Array = npt.NDArray[np.float64]

# "Near a turn": within this share of the joint's range of motion. "Large": this many times its rms over the run.
# "Standing still": slower than this share of the largest speed.
NEAR, LARGE, STILL = 0.10, 3.0, 0.01
# Flags of the joint controller that say that a pressure or a valve was limited (core/dehyst.h).
LIMITS = 16 | 32


@dataclass(frozen=True)
class Place:
    """What the runs show where the error with compensator is largest.

    Attributes
    ----------
    error, without
        Largest error with compensator, and the error without it at the same moment. [rad]
    time
        From the start of the path. [s]
    figure
        Name of the path's figure, or "".
    since
        Time since the joint's last turn, or since the start. [s]
    first
        Whether the joint has not turned before.
    travel, ahead
        How far it has moved since its last turn, and will move to the next, as shares of its range of motion.
    speed
        Desired speed there over the largest one.
    compensation_rate
        Largest rate of the compensator's pressure difference in the last 0.1 s, over its rms in the run.
    acceleration
        Largest desired acceleration in the last 0.1 s, over its rms in the run.
    limited
        Whether a pressure or a valve was limited there.
    """

    error: float
    without: float
    time: float
    figure: str
    since: float
    first: bool
    travel: float
    ahead: float
    speed: float
    compensation_rate: float
    acceleration: float
    limited: bool


def largest_error(off: TrialRun, on: TrialRun, joint: int) -> Place:
    """Find where the error with compensator is largest and measure what happens there."""
    j = joint - 1
    t, q = on.time, on.desired[:, j]
    k = int(np.argmax(np.abs(on.error[:, j])))
    span = max(float(np.ptp(q)), 1e-12)
    turns = turning_points(q, 0.01 * span)
    n = int(np.searchsorted(turns, k, side="right"))
    last, coming = int(turns[n - 1]), int(turns[min(n, turns.size - 1)])
    speed, name = np.abs(_rate(q, t)), int(on.figure[k])
    acceleration, compensation = np.abs(_rate(_rate(q, t), t)), np.abs(_rate(on.compensation[:, j], t))
    return Place(
        error=float(on.error[k, j]),
        without=float(np.interp(t[k], off.time, off.error[:, j])),
        time=float(t[k] - t[0]),
        figure=on.figures[name] if 0 <= name < len(on.figures) else "",
        since=float(t[k] - t[last]),
        first=last == 0,
        travel=float(abs(q[k] - q[last])) / span,
        ahead=float(abs(q[coming] - q[k])) / span,
        speed=float(speed[k]) / max(float(speed.max()), 1e-300),
        compensation_rate=_lately(compensation, t, k) / _rms(compensation),
        acceleration=_lately(acceleration, t, k) / _rms(acceleration),
        limited=bool(np.any(on.flags[max(0, k - 3) : k + 4, j] & LIMITS)),
    )


def _rate(values: Array, t: Array) -> Array:
    return np.gradient(values, t) if values.size > 1 else np.zeros_like(values)


def _rms(values: Array) -> float:
    return max(float(np.sqrt(np.mean(values**2))), 1e-300)


def _lately(values: Array, t: Array, k: int) -> float:
    """Largest value in the last 0.1 s or three samples up to k."""
    first = min(int(np.searchsorted(t, t[k] - 0.1)), max(0, k - 3))
    return float(np.max(values[first : k + 1]))


def in_words(place: Place, largest_off: float, largest_on: float) -> str:
    """Return a few sentences about the largest error.

    Parameters
    ----------
    place
        What the run shows.
    largest_off, largest_on
        Largest errors of the two runs. [deg]
    """
    where = f" in the {place.figure}" if place.figure else ""
    return (
        f"Largest error {number(largest_on)}° with, {number(largest_off)}° without compensator. The first lies at "
        f"{number(place.time)} s{where}, {_moment(place)}; without compensator the error at that moment is "
        f"{number(np.rad2deg(abs(place.without)))}°. {_cause(place)}"
    )


def _moment(place: Place) -> str:
    turn = "the start" if place.first else "its last turn"
    if place.speed <= STILL:
        return f"while the joint stands still, {number(place.since, 2)} s after {turn}"
    if place.ahead <= NEAR < place.travel:
        return "just before the joint turns or stops"
    return f"{number(place.since, 2)} s and {number(100 * place.travel, 2)} % of the joint's motion after {turn}"


def _cause(place: Place) -> str:
    fast, turned = place.compensation_rate >= LARGE, place.travel <= NEAR and not place.first
    if place.limited:
        return "A pressure or a valve was limited there, so what the compensator asked for was not done."
    if turned and fast:
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
    if place.first and place.travel <= NEAR:
        return "The joint has hardly moved yet: the memory of its muscles at the start is not known."
    if place.speed <= STILL or place.compensation_rate < 1.0 / LARGE:
        return "The compensator hardly moves there, so what is left is not its timing: the model leaves it, or creep."
    if turned:
        return "It lies right after a turn, but the compensator does not move fast there."
    return "No turn, limit or large acceleration is near: the model leaves it over."
