"""Recordings made ready for any identification, whoever made them: what is no response of the actuator is left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data.outliers import bridged, find_outliers
from dehyst.data.recording import Recording
from dehyst.findings import Finding
from dehyst.identification.changed import about_change, changed_at
from dehyst.identification.stopped import about_stop, stopped_at

SHOWN = 4


def mended(record: Recording) -> Recording:
    """Recording whose outliers are bridged, and what follows the end of its actuator left out; itself if it is sound.

    A play remembers the extremes of its input, so that a false one there spoils what follows: its memory follows the
    line instead. Reading a log finds the same outliers, and drops their rows.

    Examples
    --------
    >>> x = np.sin(np.arange(200) / 10)
    >>> y = np.where(np.arange(200) == 50, 100.0, 2 * x)
    >>> found = mended(Recording(input=x, output=y))
    >>> found.left_out, found.findings[0].code, bool(found.output[50] < 2.0)
    ((50,), 'outlier', True)
    """
    record = _bridged(record)
    found = _ended(record)
    if found is None or found[0] in record.left_out:
        return record
    rest = range(found[0], len(record))
    return replace(record, left_out=(*record.left_out, *rest)).with_findings(found[1])


def _ended(record: Recording) -> tuple[int, Finding] | None:
    """First sample that is no more of the actuator that was, and why; None if it is one all along."""
    stop = stopped_at(record.input, record.output)
    if stop is not None:
        return stop[0], about_stop(record, stop, stop[1], stop[0], len(record))
    change = changed_at(record.input, record.output)
    if change is None:
        return None
    return change.begin, about_change(record, change, change.place, change.begin, len(record))


def _bridged(record: Recording) -> Recording:
    masks = [_outliers(record, values) for values in (record.input, record.output)]
    bad = masks[0] | masks[1]
    if not bad.any():
        return record
    names = (record.input_name, record.output_name)
    said = [
        f"'{name}' is {_shown(values[mask])} in {_numbers(mask)}"
        for name, values, mask in zip(names, (record.input, record.output), masks, strict=True)
        if mask.any()
    ]
    memory = " Memory follows the line through the input." if masks[0].any() else ""
    finding = Finding(
        "outlier",
        f"{int(bad.sum())} of {bad.size} samples of {record.name} hold a value far from all others "
        f"({'; '.join(said)}); they were left out of the fit and of its errors, and a straight line took their place."
        f"{memory} Check the sensor and its wiring; if the values are real, log faster so that they are more than a "
        f"spike.",
    )
    return replace(
        record,
        input=bridged(record.input, masks[0]),
        output=bridged(record.output, masks[1]),
        left_out=(*record.left_out, *np.flatnonzero(bad).tolist()),
        findings=(*record.findings, finding),
    )


def _outliers(record: Recording, values: Array) -> Mask:
    """Outliers of each piece: what a signal does across a break is no jump."""
    return np.concatenate([find_outliers(values[piece]) for piece in record.pieces])


def _shown(values: Array) -> str:
    listed = list(dict.fromkeys(f"{value:.6g}" for value in values.tolist()))
    return ", ".join(listed[:SHOWN]) + (", ..." if len(listed) > SHOWN else "")


def _numbers(mask: Mask) -> str:
    """Which samples, counted from 0 as an array counts them."""
    index = np.flatnonzero(mask)
    if index.size == 1:
        return f"sample {index[0]}"
    if index.size > SHOWN and index[-1] - index[0] == index.size - 1:
        return f"samples {index[0]} to {index[-1]}"
    return f"samples {', '.join(map(str, index[:SHOWN].tolist()))}" + (", ..." if index.size > SHOWN else "")
