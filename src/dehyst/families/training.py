"""Training data of a family: the first part of every recording, scaled, with initial states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np

from dehyst.arrays import Array, Mask, rank
from dehyst.data.recording import Recording
from dehyst.families.base import LoopModel, Scaling
from dehyst.identification.data import DataSet

M = TypeVar("M", bound=LoopModel)

MOST_SAMPLES = 6000  # of a thinned training part


@dataclass(frozen=True, eq=False)
class Stretch:
    """Samples of one piece with continuous memory.

    Attributes
    ----------
    x, y
        Scaled input, in [-1, 1], and scaled output, (T,), which rises with the input.
    dt
        Time from the sample before, 0 at the first, (T,); None without time stamps. [s]
    counts
        Which samples are compared, (T,); the others only move the memory.
    """

    x: Array
    y: Array
    dt: Array | None
    counts: Mask

    @property
    def time(self) -> Array:
        """Time from the first sample, (T,). [s]"""
        return np.zeros(self.x.size) if self.dt is None else np.cumsum(self.dt)


@dataclass(frozen=True, eq=False)
class Training:
    """The fitted part of all recordings.

    Attributes
    ----------
    stretches
        The data, scaled.
    scaling
        From the units of the log; what a fitted model carries.
    orientation
        Which way round the loops of the rising curve run: "counter-clockwise" where the output lags, "clockwise" where
        it leads, as a force over a displacement, "mixed" or "none".
    seed
        Of everything random in a fit.
    period
        Median time between samples of the log; 0 without time stamps. [s]
    shared
        What one fit made and others can use: rows of elements their columns.
    """

    stretches: tuple[Stretch, ...]
    scaling: Scaling
    orientation: str
    seed: int = 0
    period: float = 0.0
    shared: list[Any] = field(default_factory=list)

    @property
    def samples(self) -> int:
        """Number of samples."""
        return sum(stretch.x.size for stretch in self.stretches)

    @property
    def clockwise(self) -> bool:
        """Whether the output leads the input: its loops run clockwise, as those of a force over a displacement."""
        return self.orientation == "clockwise"

    @property
    def timed(self) -> bool:
        """Whether every sample has a time stamp."""
        return all(stretch.dt is not None for stretch in self.stretches)

    @property
    def y(self) -> Array:
        """Compared outputs of all stretches, joined."""
        return np.concatenate([stretch.y[stretch.counts] for stretch in self.stretches])

    def simulate(self, model: LoopModel) -> list[Array]:
        """Scaled outputs of a model along every stretch."""
        return [
            model.run(s.x, s.dt if model.rate_dependent else None, model.before(float(s.x[0])))[0]
            for s in self.stretches
        ]

    def residual(self, model: LoopModel) -> Array:
        """Model less data at the compared samples of all stretches, joined."""
        outputs = self.simulate(model)
        return np.concatenate([(f - s.y)[s.counts] for f, s in zip(outputs, self.stretches, strict=True)])

    def rms(self, model: LoopModel) -> float:
        """Root of the mean squared residual, scaled; infinite if the model diverges."""
        square = float(np.mean(self.residual(model) ** 2))
        return float(np.sqrt(square)) if np.isfinite(square) else float("inf")

    def best(self, models: Sequence[M]) -> M:
        """The model with the smallest residual."""
        return min(models, key=lambda model: rank(self.rms(model)))

    def best_start(self, model: M, starts: Sequence[str] = ("zero", "rest", "rising", "falling", "origin")) -> M:
        """The model with that start which leaves the smallest residual; the first one, if none is better by 2 %."""
        errors = [self.rms(model.with_start(start)) for start in starts]
        k = min(range(len(errors)), key=lambda i: rank(errors[i]))
        return model.with_start(starts[k] if errors[k] < 0.98 * errors[0] else starts[0])

    def joined(self, columns: Callable[[Stretch], Array]) -> Array:
        """Rows (K, m) of a regressor at the compared samples of all stretches; `columns` gives (T, m) of one."""
        return np.concatenate([columns(stretch)[stretch.counts] for stretch in self.stretches])

    def late(self, samples: int) -> Training:
        """The same data with the output moved ahead by some samples, back if below 0; pieces too short for it go."""
        if not samples:
            return self
        moved = tuple(_late(stretch, samples) for stretch in self.stretches if stretch.x.size > 4 * abs(samples))
        return replace(self, stretches=moved, shared=[])

    def thinned(self, most: int = MOST_SAMPLES) -> Training:
        """The same data with fewer samples, for searches: each is the last of its group, turning points are kept.

        A rate-independent model answers the same at the samples that remain; the rate between them is the mean one.
        """
        every = -(-self.samples // most)
        return (
            self if every <= 1 else replace(self, stretches=tuple(_thin(stretch, every) for stretch in self.stretches))
        )


def _late(stretch: Stretch, samples: int) -> Stretch:
    size = stretch.x.size - abs(samples)
    x = slice(max(-samples, 0), max(-samples, 0) + size)
    y = slice(max(samples, 0), max(samples, 0) + size)
    dt = None if stretch.dt is None else np.ascontiguousarray(stretch.dt[x])
    counts = stretch.counts[x] & stretch.counts[y]
    return Stretch(np.ascontiguousarray(stretch.x[x]), np.ascontiguousarray(stretch.y[y]), dt, counts)


def _thin(stretch: Stretch, every: int) -> Stretch:
    x = stretch.x
    keep = np.zeros(x.size, dtype=np.bool_)
    keep[::every] = keep[-1] = True
    moved = np.flatnonzero(np.diff(x) != 0.0)  # turning points, also those with a rest on top
    signs = np.sign(np.diff(x)[moved])
    turns = moved[1:][np.diff(signs) != 0.0]
    # Noise turns at every other sample; only turns that stand out of the strokes around them are memory.
    height = np.abs(np.diff(x[turns])) if turns.size > 1 else np.zeros(0)
    large = np.concatenate([[True], height > 0.01]) if turns.size else np.zeros(0, dtype=np.bool_)
    keep[turns[large]] = True
    chosen = np.flatnonzero(keep)
    dt = None if stretch.dt is None else np.diff(np.cumsum(stretch.dt)[chosen], prepend=0.0)
    return Stretch(np.ascontiguousarray(x[chosen]), np.ascontiguousarray(stretch.y[chosen]), dt, stretch.counts[chosen])


def training_of(records: tuple[Recording, ...], data: DataSet, orientation: str, seed: int) -> Training:
    """Return the fitted part of recordings that were prepared."""
    stretches = []
    for piece in data.pieces:
        if not piece.split:
            continue
        part = slice(0, piece.split)
        x, y = (np.ascontiguousarray(np.asarray(values[part], dtype=np.float64)) for values in (piece.x, piece.y))
        counts = np.zeros(x.size, dtype=np.bool_)
        counts[piece.fitted("zero")] = True
        if piece.weight is not None:
            counts &= piece.weight[part] > 0.0
        stretches.append(Stretch(x, y, steps_of(records[piece.recording], piece.start, x.size), counts))
    steps = [s.dt[1:] for s in stretches if s.dt is not None and s.dt.size > 1]
    median = float(np.median(np.concatenate(steps))) if steps else 0.0
    period = float(f"{median:.9g}")  # differences of time stamps have no more digits
    return Training(tuple(stretches), scaling_of(data), orientation, seed, period)


def scaling_of(data: DataSet) -> Scaling:
    """Scaling of prepared recordings."""
    return Scaling(data.center, data.half_range, data.level, data.trend * data.amplitude)


def steps_of(record: Recording, start: int, size: int) -> Array | None:
    """Time from the sample before of a piece of a recording, 0 at its first. [s]"""
    if record.time is None:
        return None
    stamps = record.time[start : start + size]
    return np.ascontiguousarray(np.diff(stamps, prepend=stamps[:1]))
