"""Recordings on their way into a comparison: units, range, cycles, and which cycles the model was made from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from dehyst.data.recording import Recording
from dehyst.findings import Finding
from dehyst.monitoring import comparable, design, parts
from dehyst.monitoring.cycles import Cycle, cycles_of, groups_of
from dehyst.monitoring.design import Measured, Scale
from dehyst.monitoring.parts import Given, Parted, Subject

MOST_GROUPS = 12
# A log of so many cycles is long: what counts as now is its last quarter.
LONG, NOW = 48, 0.25

PEAK_RATE = 35.0 / 16.0  # of a designed stroke of length and time one


@dataclass(frozen=True)
class Log:
    """A recording on its way: comparable so far, with its cycles."""

    record: Recording
    why_not: str
    cycles: tuple[Cycle, ...] = ()
    reference: tuple[Cycle, ...] = ()
    measured: Measured | None = None
    given: Given = field(default_factory=dict)


def reference_log(subject: Subject, reference: Recording | None, given: Given, findings: list[Finding]) -> Log | None:
    """Open a recording all of whose cycles are the reference."""
    if reference is None:
        return None
    log = opened(subject, reference, given, True, findings)
    return replace(log, cycles=(), reference=(*log.reference, *log.cycles))


def opened(subject: Subject, record: Recording, given: Given, others: bool, findings: list[Finding]) -> Log:
    """Convert a recording, check its range, cut it into cycles, and set those apart that the model was made from."""
    record, found, why = comparable.in_units_of(record, (subject.model.card.input, subject.model.card.output))
    findings += [finding for finding in found if finding not in findings]
    if why:
        return Log(record, why)
    x, _ = subject.signals(record)
    why = subject.cannot(record, given) or comparable.uncovered(x, subject.drive)
    if why:
        return Log(record, why)
    cycles = cycles_of(x, record.pieces, float(np.min(x)), float(np.max(x)))
    share = _fitted_share(subject.model, record)
    if share is None:
        groups = groups_of(now_of(cycles), MOST_GROUPS)
        return Log(record, comparable.too_few(groups, cycles), cycles, given=given)
    split = len(record) if others else int(share * len(record))
    old = tuple(cycle for cycle in cycles if cycle.end <= split)
    new = tuple(cycle for cycle in cycles if cycle.begin >= split)
    why = comparable.too_few(groups_of(old, MOST_GROUPS), old)
    return Log(record, why, new, old, given=given)


def _fitted_share(model: Parted, record: Recording) -> float | None:
    """Share of a recording that the model was fitted to, None if it was identified from another."""
    given: Mapping[str, Any] = model.card.provenance
    stamp = record.provenance.get("sha256")
    listed = given.get("logs")
    for place, log in enumerate(listed if isinstance(listed, list) else []):
        if isinstance(log, dict) and stamp is not None and log.get("sha256") == stamp:
            if any(log.get(key) != record.provenance.get(key) for key in ("run", "input", "output")):
                continue
            settings = given.get("settings")
            share = settings.get("train_fraction", 1.0) if isinstance(settings, dict) else 1.0
            held = settings.get("held_out") if isinstance(settings, dict) else None
            if isinstance(held, list) and held:
                share = 0.0 if place in held else 1.0
            window, whole = _rows(log), _rows(record.provenance)
            if window is None or whole is None or not isinstance(share, int | float):
                return float(share) if isinstance(share, int | float) else 1.0
            fitted_to = window[0] + float(share) * (window[1] - window[0])
            return float(np.clip((fitted_to - whole[0]) / max(1.0, whole[1] - whole[0]), 0.0, 1.0))
    return None


def _rows(provenance: Mapping[str, Any]) -> tuple[float, float] | None:
    first, last = provenance.get("first_row"), provenance.get("last_row")
    return (float(first), float(last) + 1.0) if isinstance(first, int) and isinstance(last, int) else None


def now_of(cycles: Sequence[Cycle]) -> Sequence[Cycle]:
    """The cycles that are tested: all of a short log, the last quarter of a long one."""
    return cycles if len(cycles) < LONG else cycles[-max(MOST_GROUPS, int(NOW * len(cycles))) :]


def scale_of(subject: Subject, logs: Sequence[Log], known: Log | None) -> Scale:
    """Middle and half range of the signals: from the card, else from the logs; the period of the reference."""
    good = [log for log in [*([known] if known else []), *logs] if not log.why_not]
    pairs = [subject.signals(log.record) for log in good]
    cards = subject.drive, subject.response
    found = []
    for k, card in enumerate(cards):
        low, high = card.low, card.high
        if low is None or high is None or not high > low:
            low, high = (float(f([f(pair[k]) for pair in pairs])) for f in (np.min, np.max))
        found.append((0.5 * (low + high), max(0.5 * (high - low), 1e-300)))
    return Scale(found[0], found[1], next((p for p in map(period_of, good) if p is not None), None))


def motion_of(subject: Subject, scale: Scale) -> dict[str, Any]:
    """What a motion like that of the logs is made of, for `dehyst design --for drift`."""
    middle, half = scale.drive
    rate = None if not scale.period else PEAK_RATE * 2.0 * half / (0.5 * scale.period)
    ends = {"low": middle - half, "high": middle + half, "unit": subject.drive.unit or ""}
    return ends | {"rate": rate, "period_s": scale.period}


def period_of(log: Log) -> float | None:
    """Median length of a cycle. [s]"""
    cycles = log.reference or log.cycles
    if log.record.time is None or not cycles:
        return None
    time = log.record.time
    return float(np.median([time[cycle.end] - time[cycle.begin] for cycle in cycles]))


def with_model(subject: Subject, log: Log, scale: Scale) -> Log:
    """Run the model over a log."""
    if log.why_not:
        return log
    x, y = subject.signals(log.record)
    prediction = parts.predict(subject, log.record, log.given)
    missed = None if prediction.drive is None else prediction.drive - x
    columns = design.columns_of(log.record, x, prediction, scale)
    inside = parts.inside(subject, x)
    return replace(
        log, measured=Measured(log.record, x, y, prediction, y - prediction.response, missed, columns, inside)
    )
