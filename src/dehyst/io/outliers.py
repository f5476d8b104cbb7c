"""Cells that are no measurement although they are numbers: spikes, codes of a failed sensor, wrapped angles.

One of them is enough to spoil a fit, because a play operator remembers the extreme for ever.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask
from dehyst.data.outliers import FEWEST, find_outliers
from dehyst.findings import Finding
from dehyst.io.clean import Context, Samples, hold_last
from dehyst.io.table import list_rows
from dehyst.units import canonical

TURN = {"deg": 360.0, "rad": 2 * math.pi}
WRAPPED = 0.8  # of a turn: a jump from one end of the circle to the other
SMOOTH = 3.0  # largest other steps: what may remain of such a jump once it is unwrapped


def drop_outliers(samples: Samples, about: Context, findings: list[Finding], hold: bool = False) -> Samples:
    """Unwrap angles; leave out rows with an outlier, or hold the value before it.

    Parameters
    ----------
    samples
        Finite samples in the order of the log, without breaks.
    about
        Log, columns and units.
    findings
        Grows by ``"angle-wrap"`` and ``"outlier"``.
    hold
        Keep the rows, with the last good value: for signals that are played back sample by sample.
    """
    samples, wrapped = _unwrap(samples, about, findings, set())
    masks = [find_outliers(v) for v in samples.values]
    bad = np.logical_or.reduce(masks)
    if not bad.any():
        return samples
    what = "; ".join(
        _named(samples, v, mask, name, about)
        for v, mask, name in zip(samples.values, masks, about.columns, strict=True)
        if mask.any()
    )
    done = "the value before each was held" if hold else "their rows were left out"
    findings.append(
        Finding(
            "outlier",
            f"{int(bad.sum())} of {bad.size} rows of {about.log} hold a value far from all others ({what}); {done}. A "
            f"single one would spoil the fit, because the model remembers extremes. Check the sensor and its wiring; "
            f"if the values are real, log faster so that they are more than a spike.",
        )
    )
    if hold:
        samples = replace(
            samples, values=tuple(hold_last(v, mask) for v, mask in zip(samples.values, masks, strict=True))
        )
    else:
        samples = samples.take(~bad)
    return _unwrap(samples, about, findings, wrapped)[0]


def _named(samples: Samples, v: Array, mask: Mask, name: str, about: Context) -> str:
    rows = samples.rows[mask]
    shown = ", ".join(f"{value:.6g}" for value in dict.fromkeys(v[mask][:4].tolist()))
    return f"'{name}' is {shown} in {list_rows(rows, about.word)}"


def _unwrap(samples: Samples, about: Context, findings: list[Finding], done: set[int]) -> tuple[Samples, set[int]]:
    values = list(samples.values)
    for k, (v, unit) in enumerate(zip(samples.values, about.units, strict=False)):
        turn = TURN.get(canonical(unit) or "")
        jumps = np.zeros(0, dtype=np.int64) if turn is None or k in done else wraps(v, turn)
        if turn is None or jumps.size == 0:
            continue
        done = done | {k}
        count = np.zeros(v.size)
        count[jumps] = -np.sign(v[jumps] - v[jumps - 1])
        values[k] = v + turn * np.cumsum(count)
        findings.append(
            Finding(
                "angle-wrap",
                f"'{about.columns[k]}' of {about.log} jumps by a full turn {jumps.size} "
                f"{'times' if jumps.size > 1 else 'time'}, at {list_rows(samples.rows[jumps], about.word)}: the angle "
                f"wraps around. It was unwrapped and now runs from {values[k].min():.6g} to {values[k].max():.6g} "
                f"{unit}. Nothing to do; the model knows the unwrapped angle.",
            )
        )
    return replace(samples, values=tuple(values)), done


def wraps(v: Array, turn: float) -> npt.NDArray[np.int64]:
    """Samples at which an angle jumps by a full turn, and would be smooth if it did not.

    Examples
    --------
    >>> wraps(np.arange(100.0) * 7 % 360, 360.0).tolist()
    [52]
    """
    nothing = np.zeros(0, dtype=np.int64)
    if v.size < FEWEST or float(np.ptp(v)) > 1.001 * turn:
        return nothing
    low, high = float(v.min()), float(v.max())
    slack = 1e-3 * turn
    circle = (low >= -slack and high <= turn + slack) or (low >= -turn / 2 - slack and high <= turn / 2 + slack)
    step = np.diff(v)
    jump = np.abs(step) > WRAPPED * turn
    if not circle or not jump.any() or jump.all():
        return nothing
    usual = float(np.max(np.abs(step[~jump])))
    left = np.abs(np.abs(step[jump]) - turn)
    # A square wave between the ends of the circle does not become smooth.
    return nothing if float(np.max(left)) > SMOOTH * usual else np.flatnonzero(jump) + 1
