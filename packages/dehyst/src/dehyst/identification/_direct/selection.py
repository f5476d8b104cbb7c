"""Selection of the terms of a direct inverse by held-out error, and the findings that only a direct inverse has."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from dehyst.arrays import Array, rank
from dehyst.findings import Finding
from dehyst.identification._direct.data import DirectData, separable, time_constants_text
from dehyst.identification._direct.program import (
    DEGREES,
    Layout,
    RowBlock,
    Shape,
    fitted_rows,
    held_out,
    merged,
    reduced_blocks,
)
from dehyst.identification._evidence import CREEP, Evidence
from dehyst.identification._fit import Fit, InputError
from dehyst.identification._schedules import learned_once, without_gain

# Blocks that rate and time are tested on, and folds that terms are chosen by, of two blocks each.
BLOCKS, FOLDS = 10, 5
# Rows of a long log that choice and fit see, evenly spread; its terms see every sample.
MOST_ROWS = 40_000
# A term is kept if it lowers the error on what was held out by this share; a lower degree is taken within it.
TERM_WORTH = 0.02


@dataclass(frozen=True)
class TriedShape:
    """One shape and its RMS on each held-out block, scaled."""

    shape: Shape
    errors: Array

    @property
    def error(self) -> float:
        """RMS over all blocks, scaled."""
        return float(np.sqrt(np.mean(self.errors**2)))

    @property
    def uncertainty(self) -> float:
        """Standard error of it, from the scatter between blocks, scaled."""
        scatter = float(np.std(self.errors**2, ddof=1)) / np.sqrt(self.errors.size)
        if not self.error > 0.0:
            return 0.0
        return float(scatter / (2.0 * self.error))


class Trials:
    """Shapes that were tried, each once."""

    def __init__(self, layout: Layout, data: DirectData) -> None:
        self._layout, self._data = layout, data
        self._every = max(1, data.fitted // MOST_ROWS)
        samples = [int(np.count_nonzero(piece.mask(True))) for piece in data.pieces]
        # Each piece begins with a row of its own, so every division is rounded up.
        self._samples = sum(-(-count // self._every) for count in samples)
        self._blocks: dict[str, list[RowBlock]] = {}
        self.shapes: dict[Shape, TriedShape] = {}

    def blocks(self, start: str) -> list[RowBlock]:
        """The fitted rows under one start, cut into `BLOCKS`; of a long log about 40 000 of them, evenly spread."""
        if start not in self._blocks:
            parts = fitted_rows(self._layout, self._data, start, self._every)
            self._blocks[start] = reduced_blocks(parts, self._samples, BLOCKS)
        return self._blocks[start]

    def system(self, shape: Shape) -> tuple[Array, int]:
        """Fitted rows of a shape, reduced, and their number."""
        systems = []
        samples = 0
        for block in self.blocks(shape.start):
            systems.append(self._layout.select(shape, block.rows))
            samples += block.samples
        return np.concatenate(systems), samples

    def __call__(self, shape: Shape) -> TriedShape:
        """Try a shape."""
        if shape not in self.shapes:
            folds = merged(self.blocks(shape.start), BLOCKS // FOLDS)
            self.shapes[shape] = TriedShape(shape, held_out(self._layout, shape, folds))
        return self.shapes[shape]

    def schedules_worth(self, shape: Shape) -> tuple[float, float]:
        """RMS on held-out blocks with the given schedules and without them, scaled."""
        bare = Trials(Layout(self._layout.bank, 0), without_given(self._data))
        return self(shape).error, bare(shape).error

    def simplest(self, shape: Shape, field: str, values: Iterable[Any]) -> TriedShape:
        """Try a shape with each of some values of a field; return the first whose error is within 2 % of the least."""
        tried = []
        for value in values:
            tried.append(self(replace(shape, **{field: value})))
        limit = (1.0 + TERM_WORTH) * min(trial.error for trial in tried)
        return next(trial for trial in tried if trial.error <= limit)


def without_given(data: DirectData) -> DirectData:
    """The same data without scheduling signals from outside."""
    pieces = tuple(replace(piece, shares=()) for piece in data.pieces)
    return replace(data, schedules=(), pieces=pieces)


def choose_shape(
    trials: Trials,
    required: tuple[str, ...],
    optional: tuple[str, ...],
    starts: tuple[str, ...],
    *,
    by_output: bool,
) -> TriedShape:
    """Choose terms, schedule of the output, degree and start.

    The start by a shape with everything; then terms one by one, the best first, as long as one of them is worth it;
    then the degree, and the start once more.
    """
    full = Shape(DEGREES[2])
    for group in (*required, *optional):
        full = full.with_group(group)
    begun = trials.simplest(full, "start", starts)
    shape = Shape(DEGREES[2], start=begun.shape.start)
    for group in required:
        shape = shape.with_group(group)
    chosen = _grown(trials, shape, optional, by_output)
    chosen = trials.simplest(chosen.shape, "degree", DEGREES)
    return trials.simplest(chosen.shape, "start", starts)


def _grown(trials: Trials, shape: Shape, optional: tuple[str, ...], by_output: bool) -> TriedShape:
    best = trials(shape)
    additions: list[Callable[[Shape], Shape]] = [_adding(group) for group in optional]
    if by_output:
        additions.append(lambda now: replace(now, by_output=True))
    while True:
        tried = []
        for add in additions:
            grown = add(best.shape)
            if grown != best.shape:
                tried.append(trials(grown))
        better = min(tried, key=lambda trial: rank(trial.error), default=best)
        if better.error >= (1.0 - TERM_WORTH) * best.error:
            return best
        best = better


def _adding(group: str) -> Callable[[Shape], Shape]:
    return lambda now: now.with_group(group)


# A forward family is called better where its error is smaller by this share, and by this many standard errors of the
# direct inverse's error between blocks: less is chance.
FORWARD_MARGIN = 0.1
STANDARD_ERRORS = 2.0


def about_terms(
    data: DirectData,
    shape: Shape,
    times: Array,
    asked: bool,
    trials: Trials,
    evidence: tuple[Evidence, ...],
) -> Iterator[Finding]:
    """Yield what limits creep and schedules."""
    low, high = separable(data)
    outside = [value for value in times if not 0.5 * low <= value <= 2.0 * high]
    if outside and asked:
        yield Finding(
            "creep-times-outside",
            f"time constants {time_constants_text(outside)} lie outside what this log tells apart, {low:.3g} to "
            f"{high:.3g} s (three samples to a third of the fitted part): their weights are guesses. Log longer or "
            f"faster, or use --creep {max(1, times.size)}, which chooses within that range.",
        )
    if "creep" in shape.groups and times.size:
        creep = next((term for term in evidence if term.group == CREEP), None)
        if asked and creep is not None and not creep.there:
            yield Finding(
                "creep-no-gain",
                f"creep was asked for, but does not lower the error on held-out blocks ({creep.figures}, p = "
                f"{creep.p:.2g}). Leave it out (--creep 0), or log with holds.",
            )
    yield from _about_schedules(data, shape, trials)


def _about_schedules(data: DirectData, shape: Shape, trials: Trials) -> Iterator[Finding]:
    if not data.schedules:
        return
    names = [signal.name for signal in data.schedules]
    fitted = []
    for piece in data.pieces:
        fitted.append(np.column_stack(piece.shares)[piece.mask(True)])
    once = tuple(learned_once(names, np.concatenate(fitted)))
    if once:
        yield from once
    else:
        yield from without_gain(names, *trials.schedules_worth(shape), left_out=False)


def about_direct_fit(
    asked: InputError, best: Fit, rises: bool, uncertainty_percent: float
) -> Iterator[Finding]:
    """Yield what only a direct inverse has to be warned of.

    Parameters
    ----------
    asked
        Its error of the input.
    best
        The forward family with the best inverse.
    rises
        Whether the input rises with the output, whatever the past.
    uncertainty_percent
        Standard error of the input's error, from its scatter between blocks.
    """
    direct, forward = asked.rms_percent, best.input_error.rms_percent
    if forward < direct - max(FORWARD_MARGIN * direct, STANDARD_ERRORS * uncertainty_percent):
        yield Finding(
            "forward-better",
            f"the inverse of the forward family '{best.family}' misses the applied input by {forward:.2f} % of its "
            f"range on the same samples, the direct inverse by {direct:.2f} %. Identify with --family {best.family} "
            f"instead, or log more loops: the direct inverse has more to learn.",
        )
    if not rises:
        yield Finding(
            "slope-not-guaranteed",
            "the weights change with the output, and more than the curve rises: after some past the input may fall "
            "while the output rises. A compensator that plays it forward stays bounded, but it has no unique output "
            "for an input there, and learned scales are not guaranteed to stay invertible. Where that matters, "
            "identify with --no-position-schedule.",
        )
