"""What limits the judgement: another motion, no reference, parts that look alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from dehyst.findings import Finding
from dehyst.monitoring import design, words
from dehyst.monitoring.cycles import Cycle, samples_of
from dehyst.monitoring.design import Estimates, Scale
from dehyst.monitoring.logs import Log, period_of
from dehyst.monitoring.parts import Parted, Subject

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
    offered = {part for log in tested if log.measured is not None for part in log.measured.columns} | {design.CREEP}
    if design.OWN_CREEP in offered:
        offered.discard(design.CREEP)
    missing = [part for part in design.PARTS if part in offered and part not in told]
    if tested and missing:
        without = " (there are no time stamps)" if scale.period is None and design.CREEP in missing else ""
        listed = ", ".join(words.NAMES[part] for part in missing)
        findings.append(
            Finding(
                "drift-not-told-apart",
                f"{listed} cannot be told from the other parts in these logs{without}: a change of it would show as "
                f"one of those, or as unexplained rest. Loops of several sizes, speeds and holds tell them apart.",
            )
        )
