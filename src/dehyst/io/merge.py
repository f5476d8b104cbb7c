"""Two clocks: the output brought to the stamps of the input."""

from __future__ import annotations

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import TimeError
from dehyst.findings import Finding
from dehyst.gaps import gap_limit
from dehyst.io.clean import Context, Samples
from dehyst.io.table import finite

TOGETHER = 0.5  # fewer rows than this share hold both signals: they were logged in turns


def logged_in_turns(x: Array, y: Array) -> bool:
    """Whether most rows hold only one of two signals.

    Examples
    --------
    >>> n = np.nan
    >>> logged_in_turns(np.array([1, n, 2, n, 3, n, 4, n]), np.array([n, 5, n, 6, n, 7, n, 8]))
    True
    """
    has_x, has_y = finite(x), finite(y)
    either = int(np.sum(has_x | has_y))
    both = int(np.sum(has_x & has_y))
    # A sensor that was simply not connected for most of the log is no second clock.
    return min(has_x.sum(), has_y.sum()) >= 4 and both < TOGETHER * either and bool(np.any(has_x & ~has_y))


def merge_clocks(x: Samples, y: Samples, about: Context, findings: list[Finding]) -> Samples:
    """Interpolate the output linearly at the input's stamps, over the time that both cover.

    Stamps of the input that fall into a gap of the output are left out.

    Raises
    ------
    TimeError
        If a signal has no time, a clock restarts, or the two do not overlap.
    """
    tx, ty = x.time, y.time
    if tx is None or ty is None:
        raise TimeError(
            f"{' and '.join(about.columns)} of {about.log} have {x.rows.size} and {y.rows.size} samples and no time "
            f"column, so nothing tells which belong together. Log a time column for each, or resample them to one.",
            columns=about.columns,
        )
    if x.breaks or y.breaks:
        raise TimeError(
            f"{' and '.join(about.columns)} of {about.log} are on two clocks, and one of them restarts; they cannot be "
            f"matched beyond that. Cut a window that holds one recording: --from S --to S",
            columns=about.columns,
        )
    if tx.size < 2 or ty.size < 2:
        raise TimeError(f"{about.log}: a signal on two clocks needs two samples on each.", columns=about.columns)
    inside = (tx >= ty[0]) & (tx <= ty[-1])
    if not inside.any():
        raise TimeError(
            f"the clocks of {' and '.join(about.columns)} in {about.log} do not overlap: the input covers {tx[0]:.6g} "
            f"to {tx[-1]:.6g} s, the output {ty[0]:.6g} to {ty[-1]:.6g} s. Shift one of them, or name the right time "
            f"column with --time.",
            columns=about.columns,
        )
    right = np.clip(np.searchsorted(ty, tx), 1, ty.size - 1)
    exact = np.isin(tx, ty)
    inside &= exact | (ty[right] - ty[right - 1] <= gap_limit(np.diff(ty)))
    kept = x.take(inside)
    assert kept.time is not None
    output = np.interp(kept.time, ty, y.values[0])
    findings.append(
        Finding(
            "two-clocks",
            f"{' and '.join(about.columns)} of {about.log} are on two clocks (steps of {np.median(np.diff(tx)):.3g} "
            f"and {np.median(np.diff(ty)):.3g} s); the output was interpolated at the {kept.rows.size} stamps of the "
            f"input that both cover. A delay between the clocks would look like hysteresis: log both in one row.",
        )
    )
    return Samples(kept.time, (kept.values[0], output), kept.rows)
