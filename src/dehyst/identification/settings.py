"""The settings of an identification, checked before any work is done."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from dehyst.errors import ParameterError
from dehyst.identification.families import FAMILIES
from dehyst.identification.memory import INITIAL_STATES
from dehyst.models.arrays import parameter_array, parameter_number, strictly_increasing
from dehyst.recording import Recording

Array = npt.NDArray[np.float64]

PAPER_OPERATORS = 100
PAPER_EPS = 0.001
MOST_OPERATORS = 2000


def check_recordings(recordings: Recording | Sequence[Recording]) -> tuple[Recording, ...]:
    """Return the recordings as a tuple; refuse anything else, and recordings in different units."""
    if isinstance(recordings, Recording):
        return (recordings,)
    records = tuple(recordings) if isinstance(recordings, Iterable) else ()
    if not records or not all(isinstance(record, Recording) for record in records):
        raise ParameterError(
            "identify() takes a Recording or a list of Recordings. Make one with dehyst.read_log(path, input=..., "
            "output=...) or dehyst.Recording(input=x, output=y)."
        )
    units = {(record.input_unit, record.output_unit) for record in records}
    if len(units) > 1:
        raise ParameterError(
            f"the recordings carry different units, {sorted(units)}; one model has one pair of units. "
            f"Convert them first.",
            units=units,
        )
    return records


def check_settings(
    family: str, n: int, eps: float, thresholds: npt.ArrayLike | None, initial_state: str
) -> Array | None:
    """Return the given thresholds as an array, or None for a grid; refuse settings outside what formulas allow."""
    if family != "auto" and family not in FAMILIES:
        raise ParameterError(f"family {family!r} is not one of auto, {', '.join(FAMILIES)}.", family=family)
    if initial_state != "auto" and initial_state not in INITIAL_STATES:
        raise ParameterError(
            f"initial_state {initial_state!r} is not one of auto, {', '.join(INITIAL_STATES)}.",
            initial_state=initial_state,
        )
    if isinstance(n, bool) or not isinstance(n, (int, np.integer)) or not 1 <= n <= MOST_OPERATORS:
        raise ParameterError(
            f"n = {n!r} operators: pass a whole number from 1 to {MOST_OPERATORS} (the paper uses 100).", n=n
        )
    eps = parameter_number(eps, "eps")
    if not 0.0 < eps <= 1.0:
        raise ParameterError(
            f"eps = {eps:g} must lie in (0, 1]: it is the smallest slope after a reversal, relative to output range "
            f"over input range, and 1/eps bounds the inverse's gain. The paper uses 0.001.",
            eps=eps,
        )
    if thresholds is None:
        return None
    given = parameter_array(thresholds, "thresholds")
    strictly_increasing(given, "thresholds")
    if given[0] != 0.0:
        raise ParameterError(
            f"thresholds[0] = {given[0]:g} must be 0: without a play of radius 0 the model has no inverse.",
            first=float(given[0]),
        )
    return given
