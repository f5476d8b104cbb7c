"""Types of arrays for annotations, and the rounding of scores before they are compared."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.int64]


def rank(score: float) -> float:
    """Return a score as choices compare it: six significant digits, and nothing below 1e-10.

    Another processor or number of threads sums in another order, and the last digits of a score with it. They must not
    decide: settings of equal rank are taken in the order of preference, or by name. Scores are scaled, or in percent,
    so that 1e-10 is far below what any log shows.

    Parameters
    ----------
    score
        An error, 0 or more; infinite where there is none.

    Examples
    --------
    >>> rank(0.12345678), rank(0.12345612), rank(3e-17)
    (0.123457, 0.123456, 1e-10)
    >>> errors = {"rest": 0.2 * (1 - 1e-12), "zero": 0.2}
    >>> min(("zero", "rest"), key=lambda start: rank(errors[start]))
    'zero'
    """
    return float(f"{max(score, 1e-10):.5e}")
