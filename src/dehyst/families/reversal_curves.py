"""Everett function from measured first-order reversal curves: the classical identification of a Preisach model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst.errors import IdentificationError
from dehyst.families.base import Scaling
from dehyst.families.preisach import Preisach
from dehyst.recording import Recording

Array = npt.NDArray[np.float64]

SWING = 0.01  # of the range: smaller turns are noise
NEAR = 0.02  # of the range: how near to the end a sweep must begin and end
LEAST = 3  # curves


@dataclass(frozen=True, eq=False)
class Curve:
    """One reversal curve: input and output from the turn to the end of the range."""

    x: Array
    y: Array

    @property
    def turn(self) -> float:
        """Where it begins. [scaled input]"""
        return float(self.x[0])


def everett_from_reversal_curves(recording: Recording) -> Preisach:
    """Return the Preisach model whose Everett function was read off first-order reversal curves (Mayergoyz 1991).

    The input goes from the lower end of its range up to a value alpha and back, again and again with another alpha
    (or, mirrored, from the upper end down). On the way back E(alpha, x) = (y(alpha) - y(x))/2, so each curve is one
    row of the table, with no least squares and no smoothing: noise of the log goes into it as it is, while
    ``identify_family(recording, "preisach")`` fits any excitation and keeps the measure of one sign.

    Parameters
    ----------
    recording
        A log with at least three such curves; the knots are where they turn.

    Returns
    -------
    model : Preisach
        With the units of the log, beginning from the end of the range at which the log begins.

    Raises
    ------
    IdentificationError
        If there are too few reversal curves.

    Examples
    --------
    >>> truth = Preisach.example().with_start("rising")
    >>> x = np.concatenate([np.linspace(-1, a, 50).tolist() + np.linspace(a, -1, 50).tolist() for a in truth.knots[1:]])
    >>> model = everett_from_reversal_curves(Recording(input=x, output=truth.simulate(x)))
    >>> bool(np.abs(model.simulate(x) - truth.simulate(x)).max() < 0.02)
    True
    """
    scaling = _scaling(recording)
    x = np.ascontiguousarray(scaling.inward(recording.input))
    y = np.ascontiguousarray((recording.output - scaling.level) / scaling.amplitude)
    curves, up = _curves(x, y), True
    mirrored = _curves(-x, -y)
    if len(mirrored) > len(curves):
        curves, up = mirrored, False
    if len(curves) < LEAST:
        raise IdentificationError(
            f"'{recording.name}' has {len(curves)} first-order reversal curves; {LEAST} are needed: sweeps from one "
            f"end of the range to a value that changes, and back. Record them, or fit any excitation with "
            f"identify_family(recording, 'preisach').",
            curves=len(curves),
        )
    return _model(curves, up, scaling)


def _scaling(recording: Recording) -> Scaling:
    """Input to -1..1; output likewise, rising."""
    x, y = recording.input, recording.output
    center, half = 0.5 * float(x.max() + x.min()), 0.5 * float(x.max() - x.min())
    level, amplitude = 0.5 * float(y.max() + y.min()), 0.5 * float(y.max() - y.min())
    if not (half > 0.0 and amplitude > 0.0):
        raise IdentificationError(f"input or output of '{recording.name}' does not move; nothing can be read off it.")
    rising = float(y[int(np.argmax(x))]) >= float(y[int(np.argmin(x))])
    return Scaling(center, half, level, amplitude if rising else -amplitude)


def _curves(x: Array, y: Array) -> list[Curve]:
    """Ways back to the lower end from turns that were reached from it, the highest last, none twice."""
    turns = _native.turning_points(x, 2.0 * SWING)
    low, near = float(x.min()), 2.0 * NEAR
    found: dict[float, Curve] = {}
    for before, at, after in zip(turns[:-2], turns[1:-1], turns[2:], strict=True):
        down = slice(int(at), int(after) + 1)
        if x[before] <= low + near and x[after] <= low + near and x[at] > low + near:
            found[float(x[at])] = Curve(x[down], y[down])
    kept: list[Curve] = []
    for turn in sorted(found):
        if not kept or turn > kept[-1].turn + 2.0 * SWING:
            kept.append(found[turn])
    return kept


def _model(curves: list[Curve], up: bool, scaling: Scaling) -> Preisach:
    """Each curve is a row of the table; of mirrored curves, E(alpha, beta) is that of (-beta, -alpha)."""
    n = len(curves)
    knots = np.array([-1.0] + [curve.turn for curve in curves])
    table = np.zeros((n + 1, n + 1))
    for row, curve in enumerate(curves, 1):
        order = np.argsort(curve.x, kind="stable")
        back = np.interp(knots[:row], curve.x[order], curve.y[order])
        table[row, :row] = 0.5 * (curve.y[0] - back)
    lowest = float(np.median([curve.y[-1] for curve in curves]))
    offset = lowest + table[-1, 0]
    if not up:
        knots, table, offset = -knots[::-1], table[::-1, ::-1].T, -offset
    everett = table[1:, :-1][np.tril_indices(n)]
    return Preisach(knots, everett, offset, scaling, "rising" if up else "falling")
