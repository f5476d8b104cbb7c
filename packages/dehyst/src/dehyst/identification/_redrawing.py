"""How far an error could differ on another log: parts of the scored samples are drawn anew, with repetition.

The mean square errors of P consecutive parts are m_p. A redraw takes P of them with repetition, and its error is the
root of their mean. The interval holds a given share of the errors of many redraws; two models are compared on the same
redraws (block bootstrap: B. Efron and R. J. Tibshirani, An Introduction to the Bootstrap, 1993, chapter 8).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.identification._policy import POLICY


def part_squares(
    outputs: Sequence[Array],
    records: Sequence[Recording],
    masks: Sequence[npt.NDArray[np.bool_]],
) -> Array:
    """Mean square errors (P,) of consecutive parts of the samples that the masks choose. [output squared]"""
    errors = []
    for y, record, mask in zip(outputs, records, masks, strict=True):
        errors.append(y[mask] - record.output[mask])
    parts = np.array_split(np.concatenate(errors), POLICY.compared_blocks)
    return np.array([part @ part / part.size for part in parts if part.size])


def redrawn(squares: Array) -> Array:
    """RMS errors (`POLICY.redraws`,) of parts drawn anew; parts of the same number are drawn alike in every call.

    Examples
    --------
    >>> errors = redrawn(np.array([1.0, 1.0, 4.0]))
    >>> float(errors.min()), float(errors.max())
    (1.0, 2.0)
    """
    # The seed is fixed: a table must not change when it is printed again.
    drawn = np.random.default_rng(0).integers(0, squares.size, (POLICY.redraws, squares.size))
    means: Array = np.sqrt(np.mean(squares[drawn], axis=1))
    return means


def interval(squares: Array) -> tuple[float, float]:
    """Lowest and highest of the middle redrawn errors, of which `POLICY.redraw_share` are kept. [output]"""
    errors = np.sort(redrawn(squares))
    left_out = round(0.5 * (1.0 - POLICY.redraw_share) * errors.size)
    return float(errors[left_out]), float(errors[-1 - left_out])


def within_doubt(squares: Array, best: Array) -> bool:
    """Whether the larger of two errors could be the smaller one: their ratio over the same redraws reaches down to 1.

    An error beyond `POLICY.tied_ratio` times the other is no tie, even if one part alone makes the difference: such a
    part is what a user would meet.
    """
    if not np.sqrt(np.mean(squares)) <= POLICY.tied_ratio * np.sqrt(np.mean(best)):
        return False
    if squares.size < 2:  # one part says nothing of another log
        return True
    larger = np.sort(redrawn(squares) - redrawn(best))
    left_out = round(0.5 * (1.0 - POLICY.redraw_share) * larger.size)
    return float(larger[left_out]) <= 0.0
