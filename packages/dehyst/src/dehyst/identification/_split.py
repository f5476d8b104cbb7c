"""Splits logs into fitted and held-out samples: a share of each recording, or whole recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.errors import ParameterError
from dehyst.models import kit as models_kit

# Share that is fitted where none is given.
HALF = 0.5
# Of fewer recordings none can be spared.
LEAST_RECORDINGS = 3
# A recording is a fair test if its input stays within the fitted range but for this share of it ...
SLACK = 0.02
# ... and whole recordings are held out if this share of all samples is fitted.
BALANCED = (0.4, 0.75)
# Ranges of inputs that differ by less, as a share of the whole, are equal.
SAME_RANGE = 0.01


@dataclass(frozen=True)
class Split:
    """What is fitted of each recording."""

    # Samples before this index are fitted, one index a recording: 0 where it is held out
    ends: tuple[int, ...]
    share: float  # Share of the samples that is fitted
    # Recordings that are held out whole; none where a share of each is
    held_out: tuple[int, ...] = ()

    @property
    def settings(self) -> dict[str, Any]:
        """As plain values, for the fit and the model's card."""
        settings: dict[str, Any] = {"train_fraction": self.share}
        if self.held_out:
            settings["held_out"] = list(self.held_out)
        return settings

    @property
    def train_fraction(self) -> float | None:
        """What to ask for to get this split of the same recordings."""
        if self.held_out:
            return None
        return self.share

    @property
    def fitted_part(self) -> str:
        """Where a signal was looked at, for a message."""
        if self.held_out:
            return " in the recordings that are fitted"
        if self.share >= 1.0:
            return ""
        return f" in the first {100 * self.share:g} % of the recording, which is fitted"


@dataclass(frozen=True)
class Outline:
    """What the choice looks at: samples that count, least and largest input, range of the output."""

    samples: int
    low: float
    high: float
    output_range: float


def tested_on(settings: Mapping[str, Any]) -> str:
    """What the error of a test is measured on, from the settings of a fit.

    Examples
    --------
    >>> tested_on({"train_fraction": 0.5}), tested_on({"train_fraction": 0.6, "held_out": [1, 3]})
    ('held-out loops', '2 recordings held out')
    """
    count = len(settings.get("held_out", ()))
    tested = f"{count} recordings held out"
    if not count:
        tested = "held-out loops"
    elif count == 1:
        tested = "1 recording held out"
    starts = settings.get("starts", 0)
    if starts:
        tested += f" (starts of {starts} pieces were estimated)"
    return tested


def split_recordings(
    records: Sequence[Recording],
    train_fraction: float | None,
    weights: Sequence[Array] | None = None,
) -> Split:
    """Return the split: the given share of each recording, or whole recordings, or halves where these do not serve."""
    share = checked_train_fraction(train_fraction)
    if share is None and len(records) >= LEAST_RECORDINGS:
        outlines = []
        for k, record in enumerate(records):
            counts = np.ones(len(record), dtype=np.bool_)
            if weights is not None:
                counts = weights[k] > 0.0
            counts[list(record.left_out)] = False
            y = record.output[counts]
            output_range = 0.0
            if y.size:
                output_range = float(np.ptp(y))
            low, high = float(record.input.min()), float(record.input.max())
            outlines.append(Outline(y.size, low, high, output_range))
        test_recordings = whole_recordings(outlines)
        if test_recordings:
            return whole(list(map(len, records)), test_recordings)
    if share is None:
        share = HALF
    ends = []
    for record in records:
        ends.append(_end_within(record, share))
    return Split(tuple(ends), share)


def checked_train_fraction(train_fraction: float | None) -> float | None:
    """Return a share, or None where it is to be chosen; refuse one outside (0, 1]."""
    if train_fraction is None:
        return None
    share = models_kit.parameter_number(train_fraction, "train_fraction")
    if not 0.0 < share <= 1.0:
        raise ParameterError(
            f"train_fraction = {share:g} must lie in (0, 1]: the share of each recording that is fitted. "
            f"0.5 fits the first half and tests on the second; 1 fits all and tests nothing.",
            train_fraction=share,
        )
    return share


def whole(sizes: Sequence[int], test_recordings: Sequence[int]) -> Split:
    """Return the split that holds out these recordings."""
    ends = list(sizes)
    for k in test_recordings:
        ends[k] = 0
    return Split(tuple(ends), sum(ends) / sum(sizes), tuple(test_recordings))


def whole_recordings(outlines: Sequence[Outline]) -> tuple[int, ...]:
    """Return the recordings to hold out, by what they hold rather than where they stand; none if that is no fair test.

    Fitted are those that the range of the input needs, and of the others, from the widest to the narrowest, every
    other one: both parts have large loops and small ones.

    Examples
    --------
    >>> wide, narrow, short = Outline(900, 0.0, 4.0, 1.0), Outline(900, 1.0, 3.0, 0.6), Outline(30, 1.0, 3.0, 0.6)
    >>> whole_recordings([narrow, wide, narrow, narrow]), whole_recordings([wide, narrow]), whole_recordings([wide] * 3)
    ((0, 3), (), (1,))
    >>> whole_recordings([wide, short, short])  # too little to test on
    ()
    """
    low = min(outline.low for outline in outlines)
    high = max(outline.high for outline in outlines)
    if len(outlines) < LEAST_RECORDINGS or not high > low:
        return ()

    def order(k: int) -> tuple[float, int, float, int]:
        outline = outlines[k]
        return (
            -round((outline.high - outline.low) / (high - low) / SAME_RANGE),
            -outline.samples,
            -outline.output_range,
            k,
        )

    slack = SLACK * (high - low)
    ranked = sorted(range(len(outlines)), key=order)
    # The widest recordings that reach either end of the input are fitted: no test may lie outside them.
    fitted = {
        next(k for k in ranked if outlines[k].low <= low + slack),
        next(k for k in ranked if outlines[k].high >= high - slack),
    }
    fitted_samples = 0
    for k in fitted:
        fitted_samples += outlines[k].samples
    test_samples = 0
    test_recordings = []
    for k in ranked:
        samples = outlines[k].samples
        if k in fitted or not samples:
            continue
        if fitted_samples <= test_samples:
            fitted_samples += samples
        else:
            test_samples += samples
            test_recordings.append(k)
    share = fitted_samples / max(fitted_samples + test_samples, 1)
    if not BALANCED[0] <= share <= BALANCED[1]:
        return ()
    return tuple(sorted(test_recordings))


def end_of(samples: int, fraction: float) -> int:
    """Number of samples of a recording that are fitted."""
    if fraction >= 1.0:
        return samples
    return max(1, min(samples - 1, int(fraction * samples)))


def _end_within(recording: Recording, fraction: float) -> int:
    """First sample that is held out, such that this share of the samples that count lies before it."""
    counted = np.delete(np.arange(len(recording)), np.array(recording.left_out, dtype=np.int64))
    if counted.size < 2 or fraction >= 1.0 or not recording.left_out:
        return end_of(len(recording), fraction)
    return int(counted[end_of(counted.size, fraction)])
