"""Training data of a family: the first part of every recording, scaled, with initial states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask, rank
from dehyst.data import Recording
from dehyst.families._base import LoopModel, Scaling
from dehyst.families._policy import POLICY

M = TypeVar("M", bound=LoopModel)
Rows = npt.NDArray[np.intp]

MOST_SAMPLES = 6000  # of a thinned training part
# Compared samples of a long log: they say as much of the weights of some ten columns as all of it.
MOST_COMPARED = 50_000
LEAST_STROKE = 0.01  # between two turning points, scaled; a smaller one may be noise


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
    scheduling
        Signals that schedules follow, (T, 3), as in the log; None where there are none.
    lead
        Scaled inputs and outputs of strokes before the first sample, from rest, (S, 2); None where the start state of
        the model says what came before.
    weight
        How much its squared errors count in the choice among sums and in their fit.
    """

    x: Array
    y: Array
    dt: Array | None
    counts: Mask
    scheduling: Array | None = None
    lead: Array | None = None
    weight: float = 1.0

    @property
    def time(self) -> Array:
        """Time from the first sample, (T,). [s]"""
        if self.dt is None:
            return np.zeros(self.x.size)
        return np.cumsum(self.dt)

    def run(self, model: LoopModel) -> Array:
        """Return the scaled outputs of a model along the stretch, from its start state on, (T,)."""
        more = self.surroundings(model)
        memory = self.memory(model, float(self.x[0]))
        return model.run(self.x, self.steps(model), memory, **more)[0]

    def memory(self, model: LoopModel, first: float) -> Array:
        """Return the memory of a model on arrival at a first scaled input."""
        if self.lead is None:
            return model.before(first, **self.surroundings(model))
        inputs = np.ascontiguousarray(self.lead[:, 0])
        more = {}
        for name, values in self.surroundings(model).items():
            more[name] = np.repeat(values[:1], inputs.size, axis=0)
        rest = model.with_start("rest").before(float(inputs[0]), **more)
        steps = self.steps_before if model.rate_dependent else None
        return model.run(inputs, steps, rest, **more)[1]

    @property
    def steps_before(self) -> Array | None:
        """Time between the samples of the lead, the usual one of the stretch, (S,); None without time stamps. [s]"""
        if self.dt is None or self.lead is None:
            return None
        usual = float(np.median(self.dt[1:])) if self.dt.size > 1 else 0.0
        return np.full(len(self.lead), usual)

    @property
    def turned(self) -> Stretch:
        """The same with input and output exchanged, as a sum of outputs sees it."""
        lead = None if self.lead is None else np.ascontiguousarray(self.lead[:, ::-1])
        return replace(self, x=self.y, y=self.x, lead=lead)

    def run_inverse(self, model: LoopModel, first: float, last: int | None = None) -> Array:
        """Return the scaled inputs for the scaled outputs up to a last sample, (T,), from the memory at a first one."""
        part = slice(None, last)
        dt = self.steps(model)
        more = {name: values[part] for name, values in self.surroundings(model).items()}
        if dt is not None:
            dt = dt[part]
        return model.run_inverse(self.y[part], dt, self.memory(model, first), **more)[0]

    def steps(self, model: LoopModel) -> Array | None:
        """Time from the sample before, for a model that depends on it."""
        return self.dt if model.rate_dependent else None

    def surroundings(self, model: LoopModel) -> dict[str, Array]:
        """What a model with schedules takes beside input and steps of time."""
        if self.scheduling is None or not model.needs:
            return {}
        return {"scheduling": self.scheduling}


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
    before_map
        Map of the scaled input in front of forward sums; empty for none.
    schedules, signals
        As of `ElementModel`: which signals weights go with, and between which of their values.
    shared
        What one fit made and others can use: rows of elements their columns.
    """

    stretches: tuple[Stretch, ...]
    scaling: Scaling
    orientation: str
    seed: int = 0
    period: float = 0.0
    before_map: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())
    schedules: tuple[tuple[int, float, float], ...] = ()
    signals: tuple[tuple[str, str], ...] = ()
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
        """Return the scaled outputs of a model along every stretch."""
        return [stretch.run(model) for stretch in self.stretches]

    def residual(self, model: LoopModel) -> Array:
        """Return model less data at the compared samples of all stretches, joined."""
        return np.concatenate([(s.run(model) - s.y)[s.counts] for s in self.stretches])

    def rms(self, model: LoopModel) -> float:
        """Return the root of the mean squared residual, scaled; infinite if the model diverges."""
        square = float(np.mean(self.residual(model) ** 2))
        return float(np.sqrt(square)) if np.isfinite(square) else float("inf")

    @property
    def unscheduled(self) -> Training:
        """The same data without the signals that schedules follow."""
        stretches = tuple(replace(stretch, scheduling=None) for stretch in self.stretches)
        return replace(self, stretches=stretches, schedules=(), signals=(), shared=[])

    def xi(self, stretch: Stretch) -> Array:
        """Return the schedules along a stretch, from 0 to 1, (T, schedules)."""
        if stretch.scheduling is None:
            return np.zeros((stretch.x.size, 0))
        columns = []
        for source, low, high in self.schedules:
            columns.append(np.clip((stretch.scheduling[:, source] - low) / (high - low), 0.0, 1.0))
        return np.column_stack(columns)

    def best(self, models: Sequence[M]) -> M:
        """Return the model with the smallest residual."""
        return min(models, key=lambda model: rank(self.rms(model)))

    def best_start(
        self, model: M, starts: Sequence[str] = ("zero", "rest", "rising", "falling", "origin")
    ) -> M:
        """Return the model with the start of the smallest residual; with the first start if none is better by 2 %."""
        errors = {start: self.rms(model.with_start(start)) for start in starts}
        best = min(errors, key=lambda start: rank(errors[start]))
        if not errors[best] < POLICY.better_start * errors[starts[0]]:
            best = starts[0]
        return model.with_start(best)

    def joined(self, columns: Callable[[Stretch], Array]) -> Array:
        """Return rows (K, m) of a regressor at the compared samples of all stretches; `columns` gives (T, m) of one."""
        return np.concatenate([columns(stretch)[stretch.counts] for stretch in self.stretches])

    def late(self, samples: int) -> Training:
        """Return the same data with the output moved ahead by some samples, back if below 0; without short pieces."""
        if not samples:
            return self
        moved = []
        for stretch in self.stretches:
            # Of a shorter piece too little would remain.
            if stretch.x.size > 4 * abs(samples):
                moved.append(_late(stretch, samples))
        return replace(self, stretches=tuple(moved), shared=[])

    def spread(self, most: int = MOST_COMPARED) -> Training:
        """Return the same data, of which no more than about `most` samples are compared: every 3rd, 9th, 27th, ...

        A model sees all samples, so that its memory is that of the log: noise moves friction along its path, too.
        Periods of a logger are round numbers, whose factors are 2 and 5: a power of three meets all their phases.
        """
        compared = sum(int(np.count_nonzero(stretch.counts)) for stretch in self.stretches)
        every = 1
        while compared > most * every:
            every *= 3
        if every == 1:
            return self
        stretches = []
        for stretch in self.stretches:
            counts = np.zeros(stretch.counts.size, dtype=np.bool_)
            counts[np.flatnonzero(stretch.counts)[::every]] = True
            stretches.append(replace(stretch, counts=counts))
        return replace(self, stretches=tuple(stretches), shared=[])

    def thinned(self, most: int = MOST_SAMPLES) -> Training:
        """Return the same data with fewer samples, for searches: one sample of each group, and all turning points.

        A rate-independent model answers the same at the samples that remain; the rate between them is the mean one.
        """
        every = -(-self.samples // most)
        stretches = self.stretches
        if every > 1:
            stretches = tuple(_thin(stretch, every) for stretch in self.stretches)
        # A workshop keeps these data, so they must not keep the workshops: their sums are large.
        return replace(self, stretches=stretches, shared=[])


def _late(stretch: Stretch, samples: int) -> Stretch:
    size = stretch.x.size - abs(samples)
    x = slice(max(-samples, 0), max(-samples, 0) + size)
    y = slice(max(samples, 0), max(samples, 0) + size)
    dt = None
    if stretch.dt is not None:
        dt = np.ascontiguousarray(stretch.dt[x])
    counts = stretch.counts[x] & stretch.counts[y]
    moved_x, moved_y = np.ascontiguousarray(stretch.x[x]), np.ascontiguousarray(stretch.y[y])
    moved = replace(stretch, x=moved_x, y=moved_y, dt=dt, counts=counts)
    return replace(moved, scheduling=_rows_of(stretch.scheduling, x))


def _rows_of(scheduling: Array | None, rows: slice | Rows) -> Array | None:
    return None if scheduling is None else np.ascontiguousarray(scheduling[rows])


def _thin(stretch: Stretch, every: int) -> Stretch:
    x = stretch.x
    keep = np.zeros(x.size, dtype=np.bool_)
    keep[::every] = keep[-1] = True
    # Samples without a move are left out first, so that a turning point with a rest on top counts, too.
    moved = np.flatnonzero(np.diff(x) != 0.0)
    signs = np.sign(np.diff(x)[moved])
    turns = moved[1:][np.diff(signs) != 0.0]
    # Noise turns at every other sample; only turns that stand out of the strokes around them are memory.
    if turns.size:
        keep[turns[0]] = True
        height = np.abs(np.diff(x[turns]))
        keep[turns[1:][height > LEAST_STROKE]] = True
    chosen = np.flatnonzero(keep)
    dt = None
    if stretch.dt is not None:
        dt = np.diff(np.cumsum(stretch.dt)[chosen], prepend=0.0)
    return replace(
        stretch,
        x=np.ascontiguousarray(x[chosen]),
        y=np.ascontiguousarray(stretch.y[chosen]),
        dt=dt,
        counts=stretch.counts[chosen],
        scheduling=_rows_of(stretch.scheduling, chosen),
    )


def steps_of(record: Recording, start: int, size: int) -> Array | None:
    """Time from the sample before of a piece of a recording, 0 at its first. [s]"""
    if record.time is None:
        return None
    stamps = record.time[start : start + size]
    return np.ascontiguousarray(np.diff(stamps, prepend=stamps[:1]))
