"""Prepares logs for the drift test: units, range, cycles, whether they can be compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.data.recording import Recording
from dehyst.errors import UnitError
from dehyst.findings import Finding
from dehyst.models import Model
from dehyst.models.card import SignalCard
from dehyst.models.card import in_units_of as converted
from dehyst.monitoring.groups import Cycle, cycles_of, groups_of, samples_of
from dehyst.monitoring.parts import (
    CREEP,
    NAMES,
    OWN_CREEP,
    PARTS,
    Estimates,
    Given,
    Measured,
    Parted,
    Scale,
    Subject,
    columns_of,
    inside,
    predict,
)

# Share of the identified range that a log must cover, and by how much of it it may go beyond.
COVERED, BEYOND = 0.8, 0.1
# Groups of cycles without which no scatter can be told.
FEWEST_GROUPS = 4
# Share of the response's variance that the model and its parts must explain.
EXPLAINED = 0.5


def in_units_of(record: Recording, cards: tuple[SignalCard, SignalCard]) -> tuple[Recording, list[Finding], str]:
    """Return the recording in the model's units, what was found, and why that cannot be done, or ""."""
    findings: list[Finding] = []
    changed = record
    for role, card in zip(("input", "output"), cards, strict=True):
        given, unit, name = (getattr(record, entry) for entry in (role, f"{role}_unit", f"{role}_name"))
        try:
            values, said = converted(card, given, unit, f"'{name}' of {record.name}")
        except UnitError:
            why = (
                f"its {role} '{name}' is in {unit}, the model's '{card.name}' in {card.unit}: another column, or the "
                f"two are swapped. Name the right ones with --input and --output"
            )
            return record, findings, why
        findings += said
        if values is not given:
            changed = replace(changed, **{role: values, f"{role}_unit": card.unit})  # type: ignore[arg-type]
    return changed, findings, ""


def uncovered(x: Array, card: SignalCard) -> str:
    """Return why the range of a drive is not that of the model, or ""."""
    if card.low is None or card.high is None or not card.high > card.low:
        return ""
    low, high, span = float(np.min(x)), float(np.max(x)), card.high - card.low
    share = max(0.0, min(high, card.high) - max(low, card.low)) / span
    unit = f" {card.unit}" if card.unit else ""
    ranges = f"'{card.name}' spans {low:z.4g} to {high:z.4g}{unit}, the model {card.low:z.4g} to {card.high:z.4g}{unit}"
    if share < COVERED:
        return (
            f"{ranges}: {100 * share:.0f} % of it, less than {100 * COVERED:.0f} %. Loops of another size show other "
            f"parts of the hysteresis, not a change of it. Log the motion that the model was identified with"
        )
    if max(card.low - low, high - card.high) > BEYOND * span:
        return (
            f"{ranges}: it goes beyond by more than {100 * BEYOND:.0f} %, where the model only extrapolates. Log the "
            f"motion that the model was identified with"
        )
    return ""


def too_few(groups: Sequence[Sequence[Cycle]], cycles: Sequence[Cycle], where: str = "") -> str:
    """Return why there are too few cycles, or ""; `where` they were counted."""
    if len(groups) >= FEWEST_GROUPS:
        return ""
    return (
        f"it has {len(cycles)} complete cycle{'' if len(cycles) == 1 else 's'} whose memory is known{where}, and a "
        f"scatter between cycles needs {FEWEST_GROUPS}. Log more of them; the first one is lost, because what was "
        f"before it is unknown"
    )


def unexplained(rest: Array, response: Array) -> str:
    """Return why the model has nothing to do with the log, or ""; `rest` is what no part explains."""
    deviation = float(np.std(response))
    share = 1.0 - float(np.mean(rest**2)) / deviation**2 if deviation > 0.0 else 0.0
    if share >= EXPLAINED:
        return ""
    return (
        f"the model explains {max(0.0, 100 * share):.0f} % of the variance of its output, however its parts are "
        f"scaled: another column, another actuator, or a broken sensor. Look at the log: dehyst inspect LOG"
    )


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
    record, found, why = in_units_of(record, (subject.model.card.input, subject.model.card.output))
    findings += [finding for finding in found if finding not in findings]
    if why:
        return Log(record, why)
    x, _ = subject.signals(record)
    why = subject.cannot(record, given) or uncovered(x, subject.drive)
    if why:
        return Log(record, why)
    cycles = cycles_of(x, record.pieces, float(np.min(x)), float(np.max(x)))
    share = fitted_share(subject.model, record)
    if share is None:
        groups = groups_of(now_of(cycles), MOST_GROUPS)
        return Log(record, too_few(groups, cycles), cycles, given=given)
    split = len(record) if others else int(share * len(record))
    old = tuple(cycle for cycle in cycles if cycle.end <= split)
    new = tuple(cycle for cycle in cycles if cycle.begin >= split)
    where = "" if others else " in the part that the model was fitted to, which is what the rest is compared with"
    why = too_few(groups_of(old, MOST_GROUPS), old, where)
    return Log(record, why, new, old, given=given)


def fitted_share(model: Model, record: Recording) -> float | None:
    """Share of a recording that the model was fitted to, None if it was identified from another."""
    given: Mapping[str, Any] = model.card.provenance
    stamp = record.provenance.get("sha256")
    listed = given.get("logs")
    for place, log in enumerate(listed if isinstance(listed, list) else []):
        if isinstance(log, dict) and stamp is not None and log.get("sha256") == stamp:
            if any(log.get(key) != record.provenance.get(key) for key in ("run", "input", "output", "sheet")):
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
    prediction = predict(subject, log.record, log.given)
    missed = None if prediction.drive is None else prediction.drive - x
    columns = columns_of(log.record, x, prediction, scale)
    return replace(
        log,
        measured=Measured(log.record, x, y, prediction, y - prediction.response, missed, columns, inside(subject, x)),
    )


# Drives that differ no more than this in size, and not by more than this factor in speed, are alike.
ALIKE_SIZE = 0.15
ALIKE_SPEED = 1.5


def moved_alike(log: Log, known: Log, findings: list[Finding]) -> bool:
    """Whether a log was moved like the reference, in size and speed."""
    if log.measured is None or known.measured is None:
        return False
    sizes = [
        float(np.std(np.concatenate([m.drive[cycle.begin : cycle.end] for cycle in cycles])))
        for m, cycles in ((log.measured, log.cycles), (known.measured, known.reference))
    ]
    periods = period_of(replace(log, reference=())), period_of(known)
    fault = ""
    if abs(sizes[0] / max(sizes[1], 1e-300) - 1.0) > ALIKE_SIZE:
        fault = f"the drive scatters by {sizes[0]:.3g} here and by {sizes[1]:.3g} there"
    elif periods[0] and periods[1] and not 1 / ALIKE_SPEED <= periods[0] / periods[1] <= ALIKE_SPEED:
        fault = f"a cycle takes {periods[0]:.3g} s here and {periods[1]:.3g} s there"
    if fault:
        findings.append(
            Finding(
                "drift-other-motion",
                f"{log.record.name} was moved otherwise than the reference {known.record.name}: {fault}. The model's "
                f"own error is another one there, so that only changes larger than it count, as without a reference. "
                f"Repeat the motion of the reference.",
            )
        )
    return not fault


def say_what_is_beyond(subject: Subject, log: Log, tested: Sequence[Cycle], findings: list[Finding]) -> None:
    """Say how many samples lie where a direct inverse holds its curve and say nothing of the actuator."""
    if log.measured is None:
        return
    inside = log.measured.inside[samples_of(tested)]
    count = inside.size - int(np.count_nonzero(inside))
    if count:
        card = subject.drive
        findings.append(
            Finding(
                "drift-beyond-range",
                f"{count} of {inside.size} samples of {log.record.name} lie beyond the range {card} in which the model "
                f"was identified, where a direct inverse holds its curve: they do not count. Where they are many and "
                f"the motion is the same, the sensor has moved: look at the offset.",
            )
        )


def own_error(model: Parted) -> float | None:
    """Error on the model's card: held out, or fitted if nothing was; of a sheared model its inverse's. [% of range]"""
    for key in ("test", "train") if model.shear is None else ("inverse",):
        score = model.card.provenance.get(key)
        value = score.get("rmse_percent") if isinstance(score, dict) else None
        if isinstance(value, int | float) and not isinstance(value, bool) and 0.0 <= value < 1e6:
            return float(value)
    return None


def say_what_limits(
    subject: Subject,
    tested: Sequence[Log],
    told: tuple[str, ...],
    before: Estimates | None,
    own: float | None,
    scale: Scale,
    findings: list[Finding],
) -> None:
    """Add findings on what the judgement rests on."""
    if tested and before is None:
        error = f"{own:.3g} % of range" if own is not None else "unknown"
        findings.append(
            Finding(
                "drift-no-reference",
                f"no log of the new actuator is among the logs, so changes were measured from the model, whose own "
                f"error when it was identified was {error}: changes of that size cannot be told from it. Name the "
                f"log that it was identified from as the first one, or with --reference.",
            )
        )
    card = subject.drive
    if tested and (card.low is None or card.high is None):
        findings.append(
            Finding(
                "drift-no-range",
                "the model names no identified range, so whether the logs cover it was not checked. Identify it with "
                "`dehyst identify`, which writes the range into the model file.",
            )
        )
    offered = {part for log in tested if log.measured is not None for part in log.measured.columns} | {CREEP}
    if OWN_CREEP in offered:
        offered.discard(CREEP)
    missing = [part for part in PARTS if part in offered and part not in told]
    if tested and missing:
        without = " (there are no time stamps)" if scale.period is None and CREEP in missing else ""
        listed = ", ".join(NAMES[part] for part in missing)
        findings.append(
            Finding(
                "drift-not-told-apart",
                f"{listed} cannot be told from the other parts in these logs{without}: a change of it would show as "
                f"one of those, or as unexplained rest. Loops of several sizes, speeds and holds tell them apart.",
            )
        )
