"""Findings that only a direct inverse has."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dehyst.arrays import Array
from dehyst.findings import Finding
from dehyst.identification.direct.columns import Shape
from dehyst.identification.direct.data import DirectData
from dehyst.identification.direct.selection import FOLDS, WORTH, Trials
from dehyst.identification.direct.times import separable, words
from dehyst.identification.evidence import CREEP, Evidence
from dehyst.identification.fit import Fit, InputError

# A forward family is called better where its error is smaller by this share, and by this many standard errors of the
# direct inverse's error between blocks: less is chance.
FORWARD_MARGIN = 0.1
STANDARD_ERRORS = 2.0


def about_terms(
    data: DirectData, shape: Shape, times: Array, asked: bool, trials: Trials, evidence: tuple[Evidence, ...]
) -> Iterator[Finding]:
    """Yield what limits creep and schedules."""
    low, high = separable(data)
    outside = [value for value in times if not 0.5 * low <= value <= 2.0 * high]
    if outside and asked:
        yield Finding(
            "creep-times-outside",
            f"time constants {words(outside)} lie outside what this log tells apart, {low:.3g} to {high:.3g} s (three "
            f"samples to a third of the fitted part): their weights are guesses. Log longer or faster, or use --creep "
            f"{max(1, times.size)}, which chooses within that range.",
        )
    if "creep" in shape.groups and times.size:
        found = next((each for each in evidence if each.group == CREEP), None)
        if asked and found is not None and not found.there:
            yield Finding(
                "creep-no-gain",
                f"creep was asked for, but does not lower the error on held-out blocks ({found.figures}, p = "
                f"{found.p:.2g}). Leave it out (--creep 0), or log with holds.",
            )
    yield from _about_schedules(data, shape, trials)


def _about_schedules(data: DirectData, shape: Shape, trials: Trials) -> Iterator[Finding]:
    if not data.given:
        return
    once = [f"'{given.name}'" for k, given in enumerate(data.given) if _once(data, k)]
    if once:
        yield Finding(
            "schedule-once",
            f"{' and '.join(once)} leaves half of its range in one stretch of the fitted part only: what it changes is "
            f"learnt there alone, and held-out blocks cannot judge it. Log every value of it several times, or a run "
            f"under each (repeat --run, or name several logs), or fit a larger part (--train-fraction).",
        )
        return
    with_it, without_it = trials.schedules_worth(shape)
    if with_it < (1.0 - WORTH) * without_it:
        return
    names = " and ".join(f"'{given.name}'" for given in data.given)
    yield Finding(
        "schedule-no-gain",
        f"weights that depend on {names} do not lower the error on held-out blocks (rms {with_it / without_it:.2f} "
        f"times that without). It changes too little in this log, or does not matter: leave it out, or log more "
        "values of it.",
    )


def _once(data: DirectData, k: int) -> bool:
    """Whether without one of the folds a given schedule keeps to half of its range."""
    shares = np.concatenate([piece.given[k][piece.mask(True)] for piece in data.pieces])
    folds = np.array_split(np.arange(shares.size), FOLDS)
    return any(float(np.ptp(np.delete(shares, fold))) < 0.5 for fold in folds)


def about_direct_fit(asked: InputError, best: Fit, rises: bool, uncertainty_percent: float) -> Iterator[Finding]:
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
    own, other = asked.rms_percent, best.input_error.rms_percent
    if other < own - max(FORWARD_MARGIN * own, STANDARD_ERRORS * uncertainty_percent):
        yield Finding(
            "forward-better",
            f"the inverse of the forward family '{best.family}' misses the applied input by {other:.2f} % of its range "
            f"on the same samples, the direct inverse by {own:.2f} %. Identify with --family {best.family} instead, or "
            f"log more loops: the direct inverse has more to learn.",
        )
    if not rises:
        yield Finding(
            "slope-not-guaranteed",
            "the weights change with the output, and more than the curve rises: after some past the input may fall "
            "while the output rises. A compensator that plays it forward stays bounded, but it has no unique output "
            "for an input there, and learned scales are not guaranteed to stay invertible. Where that matters, "
            "identify with --no-position-schedule.",
        )
