"""The fitted part of a log as families of the literature see it: scaled stretches of continuous memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from dehyst.data import Recording
from dehyst.families import Scaling, Stretch, Training, steps_of
from dehyst.identification._data import DataSet, Piece
from dehyst.identification._schedules import ScheduleRange, scheduling_of


def training_of(
    records: tuple[Recording, ...],
    data: DataSet,
    orientation: str,
    seed: int,
    schedules: Sequence[ScheduleRange] = (),
) -> Training:
    """Return the fitted part of recordings that were prepared."""
    stretches = []
    steps = []
    for piece in data.pieces:
        if not piece.split:
            continue
        stretch = stretch_of(records, piece, piece.split)
        known = np.zeros(stretch.x.size, dtype=np.bool_)
        known[piece.fitted("zero")] = True
        stretches.append(replace(stretch, counts=known & stretch.counts))
        if stretch.dt is not None and stretch.dt.size > 1:
            steps.append(stretch.dt[1:])
    period = 0.0
    if steps:
        # Differences of time stamps have no more digits.
        period = float(f"{float(np.median(np.concatenate(steps))):.9g}")
    return Training(
        tuple(stretches),
        scaling_of(data),
        orientation,
        seed,
        period,
        schedules=tuple((k, signal.low, signal.high) for k, signal in enumerate(schedules)),
        signals=tuple((signal.name, signal.unit) for signal in schedules),
    )


def stretch_of(records: tuple[Recording, ...], piece: Piece, size: int) -> Stretch:
    """Return the first samples of a piece; all of them that carry weight count."""
    part = slice(0, size)
    x = np.ascontiguousarray(np.asarray(piece.x[part], dtype=np.float64))
    y = np.ascontiguousarray(np.asarray(piece.y[part], dtype=np.float64))
    counts = np.ones(x.size, dtype=np.bool_)
    if piece.weight is not None:
        counts = piece.weight[part] > 0.0
    record = records[piece.recording]
    dt = steps_of(record, piece.start, x.size)
    scheduling = scheduling_of(record, slice(piece.start, piece.start + x.size))
    return Stretch(x, y, dt, counts, scheduling, piece.lead)


def scaling_of(data: DataSet) -> Scaling:
    """Scaling of prepared recordings."""
    return Scaling(data.center, data.half_range, data.level, data.trend * data.amplitude)
