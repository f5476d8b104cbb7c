"""What every black box is given, and what it gives back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.identification._data import prepare
from dehyst.identification._split import split_recordings

BOUND = 1.5  # of an output, half ranges of the fitted half


@dataclass(frozen=True, eq=False)
class Half:
    """The fitted half: input and output (T,), scaled to -1 .. 1 by themselves."""

    x: Array
    y: Array

    @property
    def blocks(self) -> list[tuple[int, int]]:
        """The last two fifths, (begin, end) each: predicted from what is before them, they choose all settings."""
        fifth = self.x.size / 5.0
        return [(int(k * fifth), int((k + 1) * fifth)) for k in (3, 4)]

    def every(self, most: int) -> int:
        """Samples of which one is kept, so that no more than `most` are."""
        return -(-self.x.size // most)


# From the input of the whole run, its fitted half first, to the output of the whole run.
Predictor = Callable[[Array], Array]
Box = Callable[[Half], Predictor]


@dataclass(frozen=True, eq=False)
class Run:
    """A run as black boxes and rows see it: scaled input and output (T,), where the fitted half ends, a percent."""

    x: Array
    y: Array
    split: int
    percent: float

    @property
    def half(self) -> Half:
        """What a box is given, copied: it cannot reach the rest."""
        return Half(self.x[: self.split].copy(), self.y[: self.split].copy())

    def held_out(self, f: Array) -> tuple[float, float]:
        """Rms and mean of the error of an output (T,) on the half that is held out, percent of range."""
        error = self.percent * (f - self.y)[self.split :]
        return float(np.sqrt(np.mean(error**2))), float(np.mean(error))


def run_of(record: Recording) -> Run:
    """Scale and split a recording as `identify` does."""
    data = prepare((record,), split_recordings((record,), None))
    (piece,) = data.pieces
    x, y = (np.asarray(values[: piece.x.size], dtype=np.float64) for values in (piece.x, piece.y))
    return Run(x, y, piece.split, 100.0 * data.amplitude / data.output_range)


def ridges(a: Array, y: Array, strengths: tuple[float, ...]) -> list[Array]:
    """Weights of least squares with each of some ridges, relative to the largest singular value, squared."""
    u, s, v = np.linalg.svd(a, full_matrices=False)
    return [v.T @ (s / (s**2 + strength * s[0] ** 2) * (u.T @ y)) for strength in strengths]


def bounded(f: Array) -> Array:
    """Outputs not far beyond those of the fitted half: what extrapolates wildly is cut off."""
    return np.clip(f, -BOUND, BOUND)


def worst(errors: list[Array]) -> float:
    """Score of a setting: the largest rms error of the blocks."""
    return max(float(np.sqrt(np.mean(error**2))) for error in errors)
