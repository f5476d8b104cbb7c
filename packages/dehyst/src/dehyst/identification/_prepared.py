"""A log split and scaled once, for all candidates that are fitted to it."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from dehyst.arrays import Array
from dehyst.data import Recording, loops_of
from dehyst.families import Training
from dehyst.families import kit as families_kit
from dehyst.identification import _facts as facts
from dehyst.identification._candidate import Candidate
from dehyst.identification._data import DataSet, prepare
from dehyst.identification._fit import Fit
from dehyst.identification._judge import Seen, judge, seen_in
from dehyst.identification._schedules import ScheduleRange, schedule_ranges, shares_along
from dehyst.identification._scores import Measure
from dehyst.identification._split import HALF, Split, split_recordings
from dehyst.identification._static_curve import best_curve
from dehyst.identification._threads import single_blas
from dehyst.identification._training import training_of
from dehyst.models import StaticCurve

RESOLVED = 1e-3  # of the largest output of a recording: smaller ones count as if they were so large


class PieceStart(NamedTuple):
    """What came before a piece, and from where on it counts."""

    lead: Array  # scaled inputs and outputs of strokes before its first sample, (S, 2)
    known: int  # samples that told them and so test nothing: 0 for a piece that is fitted


@dataclass(frozen=True, eq=False)
class Prepared:
    """Recordings that were checked, with everything that is made of them once.

    Attributes
    ----------
    records
        The data.
    split
        What is fitted of each.
    schedules
        Ranges of the signals that change the loop, over what is fitted.
    measure
        Compares models with all samples.
    weights
        How much each sample counts, (T,) for each recording; None where all count alike.
    starts
        Of pieces whose past was estimated (`dehyst.identification._starts`), by their number.
    relative
        Whether errors count relative to the size of the output of their recording.
    shared
        What one candidate made of the log and others can use.
    """

    records: tuple[Recording, ...]
    split: Split
    schedules: tuple[ScheduleRange, ...]
    measure: Measure
    weights: tuple[Array, ...] | None = None
    starts: Mapping[int, PieceStart] = field(default_factory=dict)
    relative: bool = False
    shared: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)
    _fits: dict[Candidate, Fit] = field(default_factory=dict, init=False, repr=False)
    _curves: dict[bool, StaticCurve] = field(default_factory=dict, init=False, repr=False)
    _trainings: dict[int, Training] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def data(self) -> DataSet:
        """Scaled."""
        data = prepare(self.records, self.split, self.weights)
        pieces = list(data.pieces)
        for k, start in self.starts.items():
            pieces[k] = replace(
                pieces[k], lead=start.lead, known=start.known, within=None, after_break=True
            )
        return replace(data, pieces=tuple(pieces))

    @property
    def settings(self) -> dict[str, Any]:
        """What is fitted, how errors count, and how many starts were estimated, as plain values."""
        settings = dict(self.split.settings)
        if self.relative:
            settings["relative"] = True
        if self.starts:
            settings["starts"] = len(self.starts)
        return settings

    def _relative(self, training: Training) -> Training:
        """Return the training whose errors count relative to the rms deviation of their recording's output."""
        fitted = [piece for piece in self.data.pieces if piece.split]
        squares: dict[int, list[Array]] = {}
        for piece in fitted:
            y = np.asarray(piece.y[: piece.split], dtype=np.float64)
            squares.setdefault(piece.recording, []).append(y)
        size = {k: float(np.std(np.concatenate(parts))) for k, parts in squares.items()}
        least = RESOLVED * max(size.values())
        weights = np.array([max(size[piece.recording], least) ** -2 for piece in fitted])
        # Errors stay of the size of a scaled output: the mean weight of a sample is 1.
        samples = np.array([stretch.counts.sum() for stretch in training.stretches])
        weights *= samples.sum() / (weights @ samples)
        stretches = []
        for stretch, weight in zip(training.stretches, weights.tolist(), strict=True):
            stretches.append(replace(stretch, weight=weight))
        return replace(training, stretches=tuple(stretches), shared=[])

    @cached_property
    def branches(self) -> tuple[facts.Branches, ...]:
        """Of the fitted part."""
        return facts.branches(self.data)

    @cached_property
    def seen(self) -> Seen:
        """What the fitted part shows, and the numbers of the largest loops of the whole log."""
        counted = []
        for index, record in enumerate(self.records):
            if self.weights is not None:
                # A sample without weight counts in no number.
                uncounted = np.flatnonzero(self.weights[index] == 0.0).tolist()
                record = replace(record, left_out=(*record.left_out, *uncounted))
            counted.append(record)
        fitted = [(piece.x[: piece.split], piece.y[: piece.split]) for piece in self.data.pieces]
        loops = loops_of(counted, largest_only=True)
        return seen_in(self.branches, loops, families_kit.butterfly_in(fitted))

    def curve(self, initial_state: str = "zero") -> StaticCurve:
        """Return the best curve without hysteresis; of all states before the log only an unknown one changes it."""
        unknown = initial_state == "unknown"
        if unknown not in self._curves:
            self._curves[unknown] = best_curve(self.data, initial_state)
        return self._curves[unknown]

    def training(self, seed: int) -> Training:
        """Fitted part for families of the literature, which share what they make of it; one for each seed."""
        if seed not in self._trainings:
            training = training_of(
                self.records, self.data, self.seen.loop.name, seed, self.schedules
            )
            self._trainings[seed] = self._relative(training) if self.relative else training
        return self._trainings[seed]

    def fit(self, candidate: Candidate) -> Fit:
        """Fit a candidate and judge it; each once."""
        if candidate not in self._fits:
            with single_blas():
                self._fits[candidate] = judge(self.data, self.seen, candidate.fit(self))
        return self._fits[candidate]


def prepared(
    records: tuple[Recording, ...],
    train_fraction: float | None,
    weights: tuple[Array, ...] | None = None,
    relative: bool = False,
) -> Prepared:
    """Return recordings that were checked, split."""
    # One of several recordings may be all that there is at one load.
    if records[0].schedules and train_fraction is None:
        train_fraction = HALF
    split = split_recordings(records, train_fraction, weights)
    ranges = schedule_ranges(records, split.ends)
    measure = Measure(records, shares_along(records, ranges))
    return Prepared(records, split, ranges, measure, weights, relative=relative)
