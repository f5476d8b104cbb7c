"""Signals beside input and output that change the loop: over which range they were logged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.data import Recording, range_over
from dehyst.errors import ExcitationError, ParameterError
from dehyst.families import kit as families_kit
from dehyst.findings import Finding
from dehyst.identification._policy import POLICY

RESERVED = ("x", "y", "u", "time", "measured", "limit", "value", "period", "output")
MOST = families_kit.SOURCES
FOLDS = 5
HALF_OF_RANGE = 0.5
RESOLVED = 1e-9  # of its size: a signal that moves less stands still


@dataclass(frozen=True)
class ScheduleRange:
    """Range of a scheduling signal over the fitted part; [unit]."""

    name: str
    unit: str
    low: float
    high: float

    def share(self, values: Array) -> Array:
        """Share of the range, 0 at its low end and below, 1 at its high end and above."""
        share: Array = np.clip((values - self.low) / (self.high - self.low), 0.0, 1.0)
        return share


def check_schedules(records: Sequence[Recording]) -> None:
    """Refuse recordings that do not have the same schedules in the same units, or more than the core takes."""
    first = records[0]
    for record in records[1:]:
        if record.schedule_units != first.schedule_units:
            raise ParameterError(
                f"'{first.name}' has the schedules {_listed(first)} and '{record.name}' {_listed(record)}; one model "
                f"goes with the same signals in the same units everywhere. Give both the same.",
            )
    for name in first.schedules:
        if name in RESERVED:
            raise ParameterError(
                f"a schedule is called {name!r}, as an argument of the model's functions. Give it another name (in a "
                f"terminal: --schedule NAME=COLUMN).",
                name=name,
            )
    if len(first.schedules) > MOST:
        raise ParameterError(
            f"{len(first.schedules)} schedules ({_listed(first)}); a model goes with {MOST} signals at most. Leave out "
            f"those that change the loop least.",
            schedules=list(first.schedules),
        )


def _listed(record: Recording) -> str:
    named = []
    for name, unit in record.schedule_units.items():
        named.append(f"{name} [{unit}]" if unit else name)
    return ", ".join(named) or "none"


def schedule_ranges(records: Sequence[Recording], ends: Sequence[int]) -> tuple[ScheduleRange, ...]:
    """Return the range of each scheduling signal over the fitted part of the recordings.

    Parameters
    ----------
    records
        With the same schedules, each.
    ends
        How many samples of each are fitted.

    Raises
    ------
    ExcitationError
        If a signal stands still there.
    """
    ranges = []
    for name, unit in records[0].schedule_units.items():
        fitted = []
        for record, end in zip(records, ends, strict=True):
            fitted.append(record.schedules[name][:end])
        low, high = range_over(fitted)
        if not high - low > RESOLVED * max(abs(low), abs(high), 1e-300):
            raise ExcitationError(
                f"the scheduling signal '{name}' stays at {low:g} {unit}".rstrip()
                + " in the part that is fitted: nothing can be learnt about what it changes. Leave it out, fit a "
                "larger part (--train-fraction), or log with different values of it: in one log, or in several runs "
                "that are fitted together (repeat --run, or name several logs).",
                value=low,
            )
        ranges.append(ScheduleRange(name, unit, low, high))
    return tuple(ranges)


def shares_along(
    records: Sequence[Recording], ranges: Sequence[ScheduleRange]
) -> list[list[Array]]:
    """Return the share of the range of each scheduling signal along each recording."""
    if not ranges:
        return []
    shares: list[list[Array]] = []
    for record in records:
        shares.append([signal.share(record.schedules[signal.name]) for signal in ranges])
    return shares


def learned_once(names: Sequence[str], xi: Array) -> Iterator[Finding]:
    """Yield a finding if without some fifth of the samples a schedule keeps to half of its range.

    Parameters
    ----------
    names
        Of the schedules.
    xi
        The schedules from 0 to 1 at the fitted samples, (T, schedules).
    """
    once = []
    folds = np.array_split(np.arange(len(xi)), FOLDS)
    for name, share in zip(names, xi.T, strict=True):
        left = min(float(np.ptp(np.delete(share, fold))) for fold in folds)
        if left < HALF_OF_RANGE:
            once.append(f"'{name}'")
    if once:
        yield Finding(
            "schedule-once",
            f"{' and '.join(once)} leaves half of its range in one stretch of the fitted part only: what it changes is "
            f"learnt there alone, and held-out blocks cannot judge it. Log every value of it several times, or a run "
            f"under each (repeat --run, or name several logs), or fit a larger part (--train-fraction).",
        )


def without_gain(
    names: Sequence[str], error: float, plain: float, left_out: bool
) -> Iterator[Finding]:
    """Yield a finding if the error with schedules is not clearly smaller than the plain one.

    Parameters
    ----------
    error, plain
        On held-out parts, with and without schedules.
    left_out
        Whether the model was taken without them.
    """
    if error < POLICY.schedule_worth * plain:
        return
    taken = " The model was taken without." if left_out else ""
    yield Finding(
        "schedule-no-gain",
        f"weights that depend on {' and '.join(map(repr, names))} do not lower the error on held-out blocks (rms "
        f"{error / plain:.2f} times that without).{taken} It changes too little in this log, or does not matter: leave "
        f"it out, or log more values of it.",
    )


def scheduling_of(record: Recording, part: slice) -> Array | None:
    """Return the signals of a part of a recording as the core takes them, (T, 3); None where there are none."""
    if not record.schedules:
        return None
    size = len(range(*part.indices(len(record))))
    scheduling = np.zeros((size, MOST))
    for source, values in enumerate(record.schedules.values()):
        scheduling[:, source] = values[part]
    return scheduling
