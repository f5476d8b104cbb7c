"""Rows of the test for rate and creep, reduced to triangles."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array, Mask
from dehyst.identification._facts import velocity
from dehyst.least_squares import triangle


class TimedStretch(NamedTuple):
    """Samples in succession, all (T,): time [s], input, output, which of them count, and shares 0..1 of known loads."""

    time: Array
    x: Array
    y: Array
    counts: Mask
    loads: tuple[Array, ...] = ()


def block_triangles(
    stretches: Sequence[TimedStretch],
    blocks: int,
    degree: int,
    radii: Array,
    lengths: Array,
    times: Array,
) -> Iterator[tuple[Array, int]]:
    """Triangle and number of the rows of each block; x, which drives, and y within -1..1 as far as they count.

    Each block is less its mean; where it holds the end of one stretch and the next, each is less its own.
    """
    parts = []
    for stretch in stretches:
        parts.append(_columns(stretch, degree, radii, lengths, times)[stretch.counts])
    samples = sum(part.shape[0] for part in parts)
    limits = np.linspace(0, samples, blocks + 1).round().astype(int).tolist()
    for begin, end in itertools.pairwise(limits):
        # Each stretch in the block loses its own mean: a zero that wanders is no creep.
        inside = []
        first = 0
        for part in parts:
            last = first + part.shape[0]
            if first < end and last > begin:
                rows = part[max(begin - first, 0) : end - first]
                inside.append(rows - rows.mean(axis=0))
            first = last
        yield triangle(np.concatenate(inside)), end - begin


def _columns(
    stretch: TimedStretch, degree: int, radii: Array, lengths: Array, times: Array
) -> Array:
    """Powers, stops and lags at either end of the output and of each load, creep, rate, what is explained."""
    q = np.ascontiguousarray(stretch.x)
    time = np.ascontiguousarray(stretch.time)
    bank = _native.direct_bank(q, time, radii, lengths, times, False)[0]
    memory, creep = np.split(bank, [-times.size], axis=1)
    inside = np.clip(q, -1.0, 1.0)
    powers: Array = np.asarray(np.polynomial.chebyshev.chebvander(inside, degree), dtype=np.float64)
    rate = np.zeros(q.size)
    if q.size > 2:
        rate = velocity(time, q)
    # A load changes the loop between both of its ends, so each term is offered at either.
    ends = []
    for load in stretch.loads:
        ends += [load[:, None], (1.0 - load)[:, None]]
    whole = ends or [np.ones((q.size, 1))]
    places = [0.5 * (1.0 + inside)[:, None], 0.5 * (1.0 - inside)[:, None], *ends]
    columns = [powers[:, 1:]]
    for load in stretch.loads:
        columns.append(load[:, None] * powers)
    for share in places:
        columns.append(share * memory)
    for share in whole:
        columns.append(share * creep)
    for share in whole:
        columns.append(share * rate[:, None])
    return np.column_stack([*columns, stretch.y])
