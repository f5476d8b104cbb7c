"""The fitted part of a log as families of the literature see it: scaled stretches of continuous memory."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dehyst.data import Recording
from dehyst.families import Scaling, Stretch, Training, steps_of
from dehyst.identification._data import DataSet
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
        part = slice(0, piece.split)
        x = np.ascontiguousarray(np.asarray(piece.x[part], dtype=np.float64))
        y = np.ascontiguousarray(np.asarray(piece.y[part], dtype=np.float64))
        counts = np.zeros(x.size, dtype=np.bool_)
        counts[piece.fitted("zero")] = True
        if piece.weight is not None:
            counts &= piece.weight[part] > 0.0
        record = records[piece.recording]
        dt = steps_of(record, piece.start, x.size)
        scheduling = scheduling_of(record, slice(piece.start, piece.start + x.size))
        stretches.append(Stretch(x, y, dt, counts, scheduling))
        if dt is not None and dt.size > 1:
            steps.append(dt[1:])
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


def scaling_of(data: DataSet) -> Scaling:
    """Scaling of prepared recordings."""
    return Scaling(data.center, data.half_range, data.level, data.trend * data.amplitude)
