"""The settings of an identification, checked before any work is done."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import Recording, refuse_repeated, require_recordings
from dehyst.errors import ParameterError
from dehyst.identification._data import DataSet, arrays_of, shape_misfit
from dehyst.identification._families import FAMILIES, STATIC
from dehyst.identification._memory import INITIAL_STATES
from dehyst.identification._mending import mended
from dehyst.identification._schedules import check_schedules
from dehyst.models import kit as models_kit

PAPER_OPERATORS = 100
PAPER_EPS = 0.001
MOST_OPERATORS = 10_000
SMALLEST_EPS = 1e-12
LARGEST_WEIGHT = 1e9
AUTO = "auto"


def check_recordings(recordings: Recording | Sequence[Recording]) -> tuple[Recording, ...]:
    """Return the recordings as a tuple, their outliers left out; refuse anything else, different units, and copies."""
    records = require_recordings(recordings)
    units = {(record.input_unit, record.output_unit) for record in records}
    if len(units) > 1:
        raise ParameterError(
            f"the recordings carry different units, {sorted(units)}; one model has one pair of units. "
            f"Convert them first.",
            units=units,
        )
    check_schedules(records)
    if len(records) > 1:
        refuse_repeated(records)
    return tuple(map(mended, records))


def eps_of_call(family: str, eps: float | str | None) -> tuple[float, bool]:
    """Return the first eps, and whether a firmer one is searched for.

    None is searched for if eps is a number, or if the family is the paper's "pi" and eps is not given.

    Examples
    --------
    >>> eps_of_call("auto", None), eps_of_call("pi", None), eps_of_call("pi", "auto"), eps_of_call("stop", 0.1)
    ((0.001, True), (0.001, False), (0.001, True), (0.1, False))
    """
    if eps is None:
        return PAPER_EPS, family != "pi"
    if isinstance(eps, str):
        if eps != AUTO:
            raise ParameterError(
                f"eps = {eps!r:.40} is neither a number nor 'auto'; it is the smallest slope after a reversal. Pass "
                f"for example 0.1, or 'auto' for the firmest that costs less than 5 % of the accuracy.",
                eps=eps,
            )
        return PAPER_EPS, True
    return models_kit.parameter_number(eps, "eps"), False


def refuse_both(eps: float | str, shear: float | None, max_inverse_gain: float | None) -> None:
    """Refuse an eps beside what sets it."""
    if max_inverse_gain is not None:
        raise ParameterError(
            f"eps = {eps} and max_inverse_gain were both given; both bound the slope after a reversal. Leave one of "
            f"them out."
        )
    if isinstance(eps, str) and shear is not None:
        raise ParameterError(
            "eps = 'auto' chooses by the error of the fit, which says little of a sheared loop. Leave it out, or say "
            "what the compensator may amplify (--max-inverse-gain)."
        )


def check_settings(
    family: str, n: int | str, eps: float, thresholds: npt.ArrayLike | None, initial_state: str
) -> Array | None:
    """Return the given thresholds as an array, or None for a grid; refuse settings outside what formulas allow."""
    if not isinstance(family, str) or family not in ("auto", STATIC, *FAMILIES):
        raise ParameterError(
            f"family {family!r:.60} is not one of auto, {', '.join(FAMILIES)}, {STATIC}, direct-inverse, which can be "
            f"exported. Families of the literature (bouc-wen, preisach, dahl, ...) are identified by "
            f"dehyst.identify(recording, NAME), or `dehyst compare LOG ... --families NAME --save model.json`.",
            family=family,
        )
    if initial_state != "auto" and initial_state not in INITIAL_STATES:
        raise ParameterError(
            f"initial_state {initial_state!r} is not one of auto, {', '.join(INITIAL_STATES)}.",
            initial_state=initial_state,
        )
    check_operators(n, thresholds is not None)
    eps = models_kit.parameter_number(eps, "eps")
    if eps < SMALLEST_EPS or (eps > 1.0 and family != "pi"):
        raise ParameterError(
            f"eps = {eps:g} must lie between {SMALLEST_EPS:g} and 1: it is the smallest slope after a reversal, "
            f"relative to output range over input range, and 1/eps bounds the inverse's gain. The paper uses 0.001.",
            eps=eps,
        )
    if thresholds is None:
        return None
    grid = models_kit.parameter_array(thresholds, "thresholds")
    models_kit.strictly_increasing(grid, "thresholds")
    if grid[0] != 0.0:
        raise ParameterError(
            f"thresholds[0] = {grid[0]:g} must be 0: without a play of radius 0 the model has no inverse.",
            first=float(grid[0]),
        )
    if grid.size > MOST_OPERATORS:
        check_operators(grid.size, False)
    return grid


def check_operators(n: object, has_thresholds: bool) -> None:
    """Refuse numbers of operators that no formula or memory allows."""
    if n == AUTO and isinstance(n, str):
        if has_thresholds:
            raise ParameterError(
                "n = 'auto' chooses the thresholds, but thresholds are given too. Leave one of them out.",
                n=n,
            )
        return
    if isinstance(n, bool) or not isinstance(n, (int, np.integer)) or n < 1:
        raise ParameterError(
            f"n = {n!r} operators: pass a whole number from 1 to {MOST_OPERATORS} (the paper uses 100), or 'auto'.",
            n=n,
        )
    if n > MOST_OPERATORS:
        raise ParameterError(
            f"n = {n} operators: their sums would take several times {8e-9 * float(min(n, 10**12)) ** 2:.3g} GB, since "
            f"memory grows with n^2. Pass at most {MOST_OPERATORS}; the paper uses 100, and a log seldom tells more "
            f"than a few hundred apart.",
            n=n,
        )


def check_weights(weights: object, records: tuple[Recording, ...]) -> tuple[Array, ...] | None:
    """Return one array of weights (T,) for each recording, or None; refuse what cannot weigh samples."""
    if weights is None:
        return None
    try:
        arrays = arrays_of(weights, records)
    except (TypeError, ValueError) as fault:
        raise ParameterError(
            f"weights are not numbers ({fault}). Pass an array with one weight for each sample, or a list of such "
            f"arrays, one for each recording."
        ) from None
    misfit = shape_misfit(arrays, records)
    if misfit:
        raise ParameterError(
            f"weights have {misfit}. Pass one weight for each sample: an array, or a list of arrays for several "
            f"recordings.",
        )
    for w, record in zip(arrays, records, strict=True):
        bad = np.flatnonzero(~((w >= 0.0) & (w <= LARGEST_WEIGHT)))
        if bad.size:
            raise ParameterError(
                f"weight {w[bad[0]]:g} of sample {bad[0]} of '{record.name}' is not a number from 0 to "
                f"{LARGEST_WEIGHT:g}: squares of errors are multiplied by it. 0 leaves a sample out.",
                index=int(bad[0]),
            )
    return arrays


def paper_eps(eps: float, record: Recording, data: DataSet) -> float:
    """The paper's bound w_1 >= eps [output/input] in scaled units; refuse one above the slope of the log.

    Examples are the units: 0.001 is a hundredth of the slope of a joint in bar and radian, and a hundred times that of
    one in pascal and radian.
    """
    slope = data.amplitude / data.half_range
    if eps > slope:
        unit = ""
        if record.output_unit and record.input_unit:
            unit = f" {record.output_unit}/{record.input_unit}"
        raise ParameterError(
            f"eps = {eps:g}{unit} is larger than the mean slope of this log, {slope:.3g}{unit}: w_1 >= eps would leave "
            f"a straight line. Pass a small part of the slope, for example --eps {0.001 * slope:.1g}, or --eps auto, "
            f"which is relative to it.",
            eps=eps,
            slope=slope,
        )
    return eps / slope


def is_papers(settings: Mapping[str, Any]) -> bool:
    """Whether the bound is the paper's, w_1 >= 0.001 in units of the log."""
    return bool(settings["family"] == "pi" and settings["eps"] == PAPER_EPS)
