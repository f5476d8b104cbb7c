"""Time constants of creep: which ones a log can tell apart, and whether it holds still long enough to tell them "
"from stops."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from dehyst.errors import ParameterError
from dehyst.identification.direct.data import DirectData
from dehyst.models.arrays import parameter_array, strictly_increasing

Array = npt.NDArray[np.float64]

AUTO = "auto"
MOST_TIMES = 12
# Offered where their number is not asked for.
USUAL_TIMES = 6
# A log tells time constants apart from three of its sampling steps up to a third of its fitted part; over less than
# 1 : 300 of that nothing is gained.
STEPS, SHARE, WIDEST = 3.0, 1.0 / 3.0, 300.0
# A signal holds still while it stays within this share of its range.
STILL = 0.005
# Holds tell creep from stops if they last this share of the shortest time constant, and of the longest that the log
# could tell.
HELD_SHORTEST = 0.5
HELD_LONGEST = 0.1


def check_creep(creep: int | str, times: npt.ArrayLike | None) -> Array | None:
    """Return the given time constants, or None; refuse a number or times that are none."""
    if times is not None:
        if not (isinstance(creep, str) and creep == AUTO):
            raise ParameterError(
                f"creep = {creep!r} and creep_times = {times!r} are both given: one says how many time constants, the "
                f"other which. Pass one of them (--creep or --creep-times).",
                creep=creep,
            )
        given = parameter_array(times, "creep_times")
        strictly_increasing(given, "creep_times")
        if not given[0] > 0.0:
            raise ParameterError(
                f"creep_times[0] = {given[0]:g} s must be positive: it is how long creep takes. Pass for example "
                f"creep_times=[4, 25, 150] (--creep-times 4,25,150)."
            )
        if given.size > MOST_TIMES:
            raise ParameterError(
                f"{given.size} creep times: pass at most {MOST_TIMES}; time constants closer than a factor of 2 cannot "
                f"be told apart."
            )
        return given
    if creep == AUTO and isinstance(creep, str):
        return None
    if isinstance(creep, bool) or not isinstance(creep, (int, np.integer)) or not 0 <= creep <= MOST_TIMES:
        raise ParameterError(
            f"creep = {creep!r}: pass how many time constants to offer, 0 to {MOST_TIMES} (--creep 3), or 'auto'.",
            creep=creep,
        )
    return None


def separable(data: DirectData) -> tuple[float, float]:
    """Shortest and longest time constants that the fitted part tells apart. [s]"""
    steps, longest = [], 0.0
    for piece in data.pieces:
        if piece.time is not None and piece.split >= 2:
            fitted = piece.time[: piece.split]
            steps.append(np.diff(fitted))
            longest = max(longest, float(fitted[-1] - fitted[0]))
    if not steps:
        return 0.0, 0.0
    high = SHARE * longest
    return max(STEPS * float(np.median(np.concatenate(steps))), high / WIDEST), high


def time_constants(data: DirectData, creep: int | str, given: Array | None) -> Array:
    """Time constants to offer, (m,). [s]"""
    if given is not None:
        return given
    low, high = separable(data)
    count = USUAL_TIMES if isinstance(creep, str) else int(creep)
    if count == 0 or not low < high:
        return np.zeros(0)
    return np.array([np.sqrt(low * high)]) if count == 1 else np.geomspace(low, high, count)


def longest_hold(data: DirectData) -> float:
    """Longest time for which output or input stays within 0.5 % of its range in the fitted part. [s]

    Either will do: while a position is held the input creeps, while a pressure is held the output does.
    """
    longest = 0.0
    for piece in data.pieces:
        if piece.time is not None:
            for signal in (piece.y, piece.u):
                longest = max(longest, _hold(signal[: piece.split], piece.time[: piece.split]))
    return longest


def holds_still(data: DirectData, times: Array) -> bool:
    """Whether the fitted part holds still for long enough to tell creep with these time constants from stops."""
    hold = longest_hold(data)
    return hold >= HELD_SHORTEST * float(times[0]) and hold >= HELD_LONGEST * separable(data)[1]


def _hold(signal: Array, time: Array) -> float:
    """Longest stretch whose values span at most 1 % of the range (which is 2, scaled); two fingers along the signal."""
    longest, begin = 0.0, 0
    low = high = float(signal[0]) if signal.size else 0.0
    for k, value in enumerate(signal.tolist()):
        low, high = min(low, value), max(high, value)
        if high - low > 4.0 * STILL:
            begin = _first_within(signal, k)
            inside = signal[begin : k + 1]
            low, high = float(inside.min()), float(inside.max())
        longest = max(longest, float(time[k] - time[begin]))
    return longest


def _first_within(u: Array, k: int) -> int:
    """Earliest index from which the signal up to k stays within the band around its value at k."""
    begin = k
    low = high = float(u[k])
    while begin > 0:
        value = float(u[begin - 1])
        low, high = min(low, value), max(high, value)
        if high - low > 4.0 * STILL:
            break
        begin -= 1
    return begin


def words(times: Sequence[float] | Array) -> str:
    """Time constants in words.

    Examples
    --------
    >>> words([4.0, 25.0, 150.0])
    '4, 25, 150 s'
    """
    return ", ".join(f"{value:.3g}" for value in times) + " s"
