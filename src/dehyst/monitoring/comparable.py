"""Whether a log can be compared with a model at all: its units, its range, its number of cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from dehyst.arrays import Array
from dehyst.data.recording import Recording
from dehyst.errors import UnitError
from dehyst.findings import Finding
from dehyst.models import SignalCard, converted
from dehyst.monitoring.cycles import Cycle

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
            values, said = converted.in_units_of(card, given, unit, f"'{name}' of {record.name}")
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


def too_few(groups: Sequence[Sequence[Cycle]], cycles: Sequence[Cycle]) -> str:
    """Return why there are too few cycles, or ""."""
    if len(groups) >= FEWEST_GROUPS:
        return ""
    return (
        f"it has {len(cycles)} complete cycle{'' if len(cycles) == 1 else 's'} whose memory is known, and a scatter "
        f"between cycles needs {FEWEST_GROUPS}. Log more of them; the first one is lost, because what was before it is "
        f"unknown"
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
