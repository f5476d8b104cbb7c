"""Time constants of creep: which ones a log can tell apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.identification.direct.data import DirectData
from dehyst.models.arrays import parameter_array, strictly_increasing

AUTO = "auto"
MOST_TIMES = 12
# Offered where their number is not asked for.
USUAL_TIMES = 6
# A log tells time constants apart from three of its sampling steps up to a third of its fitted part; over less than
# 1 : 300 of that nothing is gained.
STEPS, SHARE, WIDEST = 3.0, 1.0 / 3.0, 300.0


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


def words(times: Sequence[float] | Array) -> str:
    """Time constants in words.

    Examples
    --------
    >>> words([4.0, 25.0, 150.0])
    '4, 25, 150 s'
    """
    return ", ".join(f"{value:.3g}" for value in times) + " s"
