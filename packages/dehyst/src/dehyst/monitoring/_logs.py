"""Prepares logs for the drift test: units, range, cycles, whether they can be compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.data import Recording, range_over
from dehyst.errors import UnitError
from dehyst.findings import Finding
from dehyst.models import Model, SignalCard
from dehyst.models import kit as models_kit
from dehyst.monitoring._groups import Cycle, cycles_of, groups_of, samples_of_cycles
from dehyst.monitoring._parts import (
    CREEP,
    NAMES,
    OWN_CREEP,
    PARTS,
    Estimates,
    JudgedModel,
    MeasuredRecording,
    Parted,
    Scale,
    inside,
    part_columns,
    predict_parts,
)
from dehyst.monitoring._policy import POLICY


def recording_in_units_of(
    record: Recording, cards: tuple[SignalCard, SignalCard], context: Sequence[SignalCard] = ()
) -> tuple[Recording, list[Finding], str]:
    """Return the recording in the model's units, what was found, and why that cannot be done, or ""."""
    findings: list[Finding] = []
    changed = record
    for role, card in zip(("input", "output"), cards, strict=True):
        logged: Array = getattr(record, role)
        unit: str = getattr(record, f"{role}_unit")
        name: str = getattr(record, f"{role}_name")
        try:
            values, unit_findings = models_kit.in_units_of(
                card, logged, unit, f"'{name}' of {record.name}"
            )
        except UnitError:
            why = (
                f"its {role} '{name}' is in {unit}, the model's '{card.name}' in {card.unit}: another column, or the "
                f"two are swapped. Name the right ones with --input and --output"
            )
            return record, findings, why
        findings += unit_findings
        if values is not logged:
            changed = replace(changed, **{role: values, f"{role}_unit": card.unit})  # type: ignore[arg-type]
    schedules, units = dict(record.schedules), dict(record.schedule_units)
    for card in context:
        if card.name not in schedules:
            continue
        unit, column = units[card.name], f"'{card.name}' of {record.name}"
        try:
            schedules[card.name], unit_findings = models_kit.in_units_of(
                card, schedules[card.name], unit, column
            )
        except UnitError:
            why = f"its '{card.name}' is in {unit}, the model's in {card.unit}. Name another column with --schedule"
            return record, findings, why
        findings += unit_findings
        units[card.name] = card.unit
    if schedules:
        changed = replace(changed, schedules=schedules, schedule_units=units)
    return changed, findings, ""


def uncovered(x: Array, card: SignalCard) -> str:
    """Return why the range of a drive is not that of the model, or ""."""
    if card.low is None or card.high is None or not card.high > card.low:
        return ""
    low, high, span = float(np.min(x)), float(np.max(x)), card.high - card.low
    share = max(0.0, min(high, card.high) - max(low, card.low)) / span
    unit = ""
    if card.unit:
        unit = f" {card.unit}"
    ranges = f"'{card.name}' spans {low:z.4g} to {high:z.4g}{unit}, the model {card.low:z.4g} to {card.high:z.4g}{unit}"
    if share < POLICY.covered_share:
        return (
            f"{ranges}: {100 * share:.0f} % of it, less than {100 * POLICY.covered_share:.0f} %. Loops of another size "
            f"show other parts of the hysteresis, not a change of it. Log the motion that the model was identified with"
        )
    if max(card.low - low, high - card.high) > POLICY.drift_beyond * span:
        return (
            f"{ranges}: it goes beyond by more than {100 * POLICY.drift_beyond:.0f} %, where the model only "
            f"extrapolates. Log the motion that the model was identified with"
        )
    return ""


def too_few(groups: Sequence[Sequence[Cycle]], cycles: Sequence[Cycle], place: str = "") -> str:
    """Return why there are too few cycles, or ""; `place` says where in the log they were counted."""
    if len(groups) >= POLICY.fewest_groups:
        return ""
    counted = f"{len(cycles)} complete cycles"
    if len(cycles) == 1:
        counted = "1 complete cycle"
    return (
        f"it has {counted} whose memory is known{place}, and a "
        f"scatter between cycles needs {POLICY.fewest_groups}. Log more of them; the first one is lost, because what "
        f"was before it is unknown"
    )


def unexplained(remainder: Array, response: Array) -> str:
    """Return why the model has nothing to do with the log, or ""; `remainder` is what no part explains."""
    deviation = float(np.std(response))
    share = 0.0
    if deviation > 0.0:
        share = 1.0 - float(np.mean(remainder**2)) / deviation**2
    if share >= POLICY.explained:
        return ""
    return (
        f"the model explains {max(0.0, 100 * share):.0f} % of the variance of its output, however its parts are "
        f"scaled: another column, another actuator, or a broken sensor. Look at the log: dehyst inspect LOG"
    )


MOST_GROUPS = 12

PEAK_RATE = 35.0 / 16.0  # of a designed stroke of length and time one


@dataclass(frozen=True)
class Log:
    """A recording on its way: comparable so far, with its cycles."""

    record: Recording
    why_not: str
    cycles: tuple[Cycle, ...] = ()
    reference: tuple[Cycle, ...] = ()
    measured: MeasuredRecording | None = None


def reference_log(
    subject: JudgedModel, reference: Recording | None, findings: list[Finding]
) -> Log | None:
    """Open a recording all of whose cycles are the reference."""
    if reference is None:
        return None
    log = open_log(subject, reference, True, findings)
    return replace(log, cycles=(), reference=(*log.reference, *log.cycles))


def open_log(
    subject: JudgedModel,
    record: Recording,
    has_reference: bool,
    findings: list[Finding],
) -> Log:
    """Convert a recording, check its range, cut it into cycles, and set those apart that the model was made from."""
    model = subject.model
    record, unit_findings, why = recording_in_units_of(
        record, (model.card.input, model.card.output), model.context
    )
    # Several logs in a foreign unit are told of once.
    findings += [finding for finding in unit_findings if finding not in findings]
    if why:
        return Log(record, why)
    x, _ = subject.signals(record)
    why = subject.cannot(record) or uncovered(x, subject.drive)
    if why:
        return Log(record, why)
    cycles = cycles_of(x, record.pieces, float(np.min(x)), float(np.max(x)))
    share = fitted_share(model, record)
    if share is None:
        groups = groups_of(now_of(cycles), MOST_GROUPS)
        return Log(record, too_few(groups, cycles), cycles)
    # The model was made from this log: what it was fitted to is the reference of the rest, or of the other logs.
    split, place = len(record), ""
    if not has_reference:
        split = int(share * len(record))
        place = " in the part that the model was fitted to, which is what the rest is compared with"
    old, new = [], []
    for cycle in cycles:
        if cycle.end <= split:
            old.append(cycle)
        # A cycle across the border was fitted in part: it is neither the reference nor a test.
        elif cycle.begin >= split:
            new.append(cycle)
    why = too_few(groups_of(old, MOST_GROUPS), old, place)
    return Log(record, why, tuple(new), tuple(old))


def fitted_share(model: Model, record: Recording) -> float | None:
    """Share of a recording that the model was fitted to, None if it was identified from another."""
    provenance: Mapping[str, Any] = model.card.provenance
    logs = provenance.get("logs")
    settings = provenance.get("settings")
    if not isinstance(logs, list):
        return None
    if not isinstance(settings, dict):
        settings = {}
    for place, log in enumerate(logs):
        if not isinstance(log, dict) or not _same_columns(log, record.provenance):
            continue
        share = settings.get("train_fraction", 1.0)
        test_logs = settings.get("held_out")
        if isinstance(test_logs, list) and test_logs:
            share = float(place not in test_logs)
        if not isinstance(share, int | float):
            return 1.0
        window, whole = _rows(log), _rows(record.provenance)
        if window is None or whole is None:
            return float(share)
        # The recording may be another window of the same file.
        fitted_to = window[0] + float(share) * (window[1] - window[0])
        return float(np.clip((fitted_to - whole[0]) / max(1.0, whole[1] - whole[0]), 0.0, 1.0))
    return None


def _same_columns(log: Mapping[str, Any], provenance: Mapping[str, Any]) -> bool:
    """Whether two logs are the same columns of the same file."""
    # Recordings made in Python have no file: two of them are never known to be the same.
    if provenance.get("sha256") is None:
        return False
    keys = ("sha256", "run", "input", "output", "sheet")
    return all(log.get(key) == provenance.get(key) for key in keys)


def _rows(provenance: Mapping[str, Any]) -> tuple[float, float] | None:
    """First row of a window of a file and the one behind its last."""
    first, last = provenance.get("first_row"), provenance.get("last_row")
    if isinstance(first, int) and isinstance(last, int):
        return float(first), float(last) + 1.0
    return None


def now_of(cycles: Sequence[Cycle]) -> Sequence[Cycle]:
    """The cycles that are tested: all of a short log, the last quarter of a long one."""
    if len(cycles) < POLICY.long_log:
        return cycles
    return cycles[-max(MOST_GROUPS, int(POLICY.now_share * len(cycles))) :]


def scale_of(subject: JudgedModel, logs: Sequence[Log], base_log: Log | None) -> Scale:
    """Middle and half range of the signals: from the card, else from the logs; the period of the reference."""
    usable = [log for log in logs if not log.why_not]
    if base_log is not None and not base_log.why_not:
        usable.insert(0, base_log)
    drives, responses = [], []
    period = None
    for log in usable:
        drive, response = subject.signals(log.record)
        drives.append(drive)
        responses.append(response)
        if period is None:
            period = cycle_length_of(log)
    return Scale(
        _middle_and_half(subject.drive, drives),
        _middle_and_half(subject.response, responses),
        period,
    )


def _middle_and_half(card: SignalCard, signals: Sequence[Array]) -> tuple[float, float]:
    """Middle and half of the range on a card, or of the logged signals where the card names none."""
    low, high = card.low, card.high
    if low is None or high is None or not high > low:
        low, high = range_over(signals)
    return 0.5 * (low + high), max(0.5 * (high - low), 1e-300)


def logged_motion(subject: JudgedModel, scale: Scale) -> dict[str, Any]:
    """What a motion like that of the logs is made of, for `dehyst design --for drift`."""
    middle, half = scale.drive
    rate = None
    if scale.period:
        rate = PEAK_RATE * 2.0 * half / (0.5 * scale.period)
    ends = {"low": middle - half, "high": middle + half, "unit": subject.drive.unit or ""}
    return ends | {"rate": rate, "period_s": scale.period}


def cycle_length_of(log: Log) -> float | None:
    """Median length of a cycle. [s]"""
    return _median_length(log.record, log.reference or log.cycles)


def _median_length(record: Recording, cycles: Sequence[Cycle]) -> float | None:
    if record.time is None or not cycles:
        return None
    lengths = [record.time[cycle.end] - record.time[cycle.begin] for cycle in cycles]
    return float(np.median(lengths))


def with_model(subject: JudgedModel, log: Log, scale: Scale) -> Log:
    """Run the model over a log."""
    # The model would extrapolate, or fail, on a log that was refused.
    if log.why_not:
        return log
    x, y = subject.signals(log.record)
    prediction = predict_parts(subject, log.record)
    inverse_error = None
    if prediction.drive is not None:
        inverse_error = prediction.drive - x
    measured = MeasuredRecording(
        log.record,
        x,
        y,
        prediction,
        y - prediction.response,
        inverse_error,
        part_columns(log.record, x, prediction, scale),
        inside(subject, x),
    )
    return replace(log, measured=measured)


def moved_alike(log: Log, base_log: Log, findings: list[Finding]) -> bool:
    """Whether a log was moved like the reference, in size and speed."""
    if log.measured is None or base_log.measured is None:
        return False
    size = _scatter(log.measured, log.cycles)
    base_size = _scatter(base_log.measured, base_log.reference)
    period, base_period = _median_length(log.record, log.cycles), cycle_length_of(base_log)
    # A model's own error is the same only in the same motion, so that it cancels between then and now.
    fault = ""
    if abs(size / max(base_size, 1e-300) - 1.0) > POLICY.alike_size:
        fault = f"the drive scatters by {size:.3g} here and by {base_size:.3g} there"
    elif (
        period
        and base_period
        and not 1 / POLICY.alike_speed <= period / base_period <= POLICY.alike_speed
    ):
        fault = f"a cycle takes {period:.3g} s here and {base_period:.3g} s there"
    if fault:
        findings.append(
            Finding(
                "drift-other-motion",
                f"{log.record.name} was moved otherwise than the reference {base_log.record.name}: {fault}. "
                f"The model's own error is another one there, so that only changes larger than it count, as without a "
                f"reference. Repeat the motion of the reference.",
            )
        )
    return not fault


def _scatter(measured: MeasuredRecording, cycles: Sequence[Cycle]) -> float:
    """Standard deviation of the drive over cycles. [drive]"""
    return float(np.std(measured.drive[samples_of_cycles(cycles)]))


def say_what_is_beyond(
    subject: JudgedModel, log: Log, tested: Sequence[Cycle], findings: list[Finding]
) -> None:
    """Warn of samples beyond the range of a direct inverse: its curve is constant there, so they show no change."""
    if log.measured is None:
        return
    inside = log.measured.inside[samples_of_cycles(tested)]
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
    keys: tuple[str, ...] = ("inverse",)
    if model.shear is None:
        keys = ("test", "train")
    for key in keys:
        score = model.card.provenance.get(key)
        if not isinstance(score, dict):
            continue
        # Anybody may edit a card: what is no plain number does not count.
        value = score.get("rmse_percent")
        if isinstance(value, int | float) and not isinstance(value, bool) and 0.0 <= value < 1e6:
            return float(value)
    return None


def say_what_limits(
    subject: JudgedModel,
    tested: Sequence[Log],
    distinct: tuple[str, ...],
    before: Estimates | None,
    own_percent: float | None,
    scale: Scale,
    findings: list[Finding],
) -> None:
    """Add findings on what the judgement rests on."""
    if tested and before is None:
        error = "unknown"
        if own_percent is not None:
            error = f"{own_percent:.3g} % of range"
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
    # A model of its own creep has a scale of it; any other may lack creep altogether.
    offered = {CREEP}
    for log in tested:
        if log.measured is not None:
            offered.update(log.measured.columns)
    if OWN_CREEP in offered:
        offered.discard(CREEP)
    missing = [part for part in PARTS if part in offered and part not in distinct]
    if tested and missing:
        without = ""
        if scale.period is None and CREEP in missing:
            without = " (there are no time stamps)"
        listed = ", ".join(map(NAMES.__getitem__, missing))
        findings.append(
            Finding(
                "drift-not-told-apart",
                f"{listed} cannot be told from the other parts in these logs{without}: a change of it would show as "
                f"one of those, or as unexplained rest. Loops of several sizes, speeds and holds tell them apart.",
            )
        )
