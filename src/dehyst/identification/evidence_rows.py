"""Rows of the test for rate and creep, reduced to triangles; the page in a browser has them in C."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array, Mask
from dehyst.identification.facts import velocity
from dehyst.identification.least_squares import triangle


class Stretch(NamedTuple):
    """Samples in succession, all (T,): time [s], input, output, which of them count, and shares 0..1 of known loads."""

    time: Array
    x: Array
    y: Array
    counts: Mask
    loads: tuple[Array, ...] = ()


def blocks_of(
    stretches: Sequence[Stretch], blocks: int, degree: int, radii: Array, lengths: Array, times: Array
) -> Iterator[tuple[Array, int]]:
    """Triangle and number of the rows of each block; x, which drives, and y within -1..1 as far as they count.

    Each block is less its mean; where it holds the end of one stretch and the next, each is less its own.
    """
    parts = [_columns(stretch, degree, radii, lengths, times)[stretch.counts] for stretch in stretches]
    ends = np.cumsum([0, *(part.shape[0] for part in parts)])
    for begin, end in itertools.pairwise(np.linspace(0, ends[-1], blocks + 1).round().astype(int).tolist()):
        inside = [
            part[max(begin - first, 0) : end - first]
            for part, first, last in zip(parts, ends[:-1].tolist(), ends[1:].tolist(), strict=True)
            if first < end and last > begin
        ]
        yield triangle(np.concatenate([part - part.mean(axis=0) for part in inside])), end - begin


def _columns(stretch: Stretch, degree: int, radii: Array, lengths: Array, times: Array) -> Array:
    """Powers, stops and lags at either end of the output and of each load, creep, rate, what is explained."""
    q, time, loads = np.ascontiguousarray(stretch.x), np.ascontiguousarray(stretch.time), stretch.loads
    memory, creep = np.split(_native.direct_bank(q, time, radii, lengths, times, False)[0], [-times.size], axis=1)
    inside = np.clip(q, -1.0, 1.0)
    powers: Array = np.asarray(np.polynomial.chebyshev.chebvander(inside, degree), dtype=np.float64)
    rate = velocity(time, q) if q.size > 2 else np.zeros(q.size)
    ends = [share[:, None] for load in loads for share in (load, 1.0 - load)]
    whole = ends or [np.ones((q.size, 1))]
    places = [0.5 * (1.0 + inside)[:, None], 0.5 * (1.0 - inside)[:, None], *ends]
    return np.column_stack(
        [
            powers[:, 1:],
            *(load[:, None] * powers for load in loads),
            *(share * memory for share in places),
            *(share * creep for share in whole),
            *(share * rate[:, None] for share in whole),
            stretch.y,
        ]
    )
