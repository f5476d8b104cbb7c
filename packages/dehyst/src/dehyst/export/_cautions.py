"""What a person should know of a unit before it drives a machine: findings about range, time, cost and precision."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from dehyst.export._budget import CLOCKS, budget
from dehyst.export._numbers import DirectNumbers
from dehyst.export._policy import POLICY
from dehyst.export._subject import Subject
from dehyst.findings import Finding


def about_unit(subject: Subject) -> tuple[Finding, ...]:
    """Return what is worth a warning about a unit that is to be exported."""
    findings: list[Finding] = []
    for about in (_outside, _cost, _coarse, _stalled, _slow, _rounded, _rings, _late):
        findings += about(subject)
    return tuple(findings)


def _outside(subject: Subject) -> Iterator[Finding]:
    """Say that the unit may work where nothing was identified."""
    card, asked = subject.model.card.input, subject.settings.get("range")
    if asked is None or card.low is None or card.high is None:
        return
    low, high = asked
    beyond = max(card.low - low, high - card.high)
    if beyond > POLICY.edge * (card.high - card.low):
        yield Finding(
            "outside-range",
            f"--range goes from {low:.4g} to {high:.4g}, the model's {card.label} was identified from {card.low:.4g} "
            f"to {card.high:.4g}; beyond, the model guesses. Narrow --range, or identify from a log that goes so far.",
        )


def _slow(subject: Subject) -> Iterator[Finding]:
    """Say that the unit runs so seldom that what the model knows of time is lost."""
    if subject.period is not None and (why := subject.model.too_slow(subject.period)):
        yield Finding("long-period", why)


def _rounded(subject: Subject) -> Iterator[Finding]:
    """Say that a dead time is no whole number of periods."""
    dead_time, period = subject.model.dead_time, subject.period
    # An inverse has none.
    if subject.what != "forward" or period is None or not dead_time > 0.0:
        return
    rounded = period * round(dead_time / period)
    if abs(rounded - dead_time) > POLICY.rounded_dead_time * dead_time:
        whole = dead_time / math.ceil(dead_time / period)
        yield Finding(
            "dead-time-rounded",
            f"the dead time of the model, {dead_time:.4g} s, is {dead_time / period:.3g} periods of {period:.4g} s: "
            f"the unit delays by {rounded:.4g} s. To keep it run the unit every {whole:.6g} s (--period {whole:.6g}).",
        )


def _rings(subject: Subject) -> Iterator[Finding]:
    """Say what the unit does about a resonance."""
    resonance, period = subject.model.resonance, subject.period
    if resonance is None:
        return
    frequency = f"{resonance.frequency:.4g} Hz"
    if subject.what != "inverse" or period is None:
        yield Finding(
            "resonance-left-out",
            f"the actuator rings at {frequency}, and the unit does not: it answers as the loop alone. Put a system of "
            f"second order with that frequency and a damping of {resonance.damping:.2g} behind it, where swings count.",
        )
    elif resonance.samples(period):
        yield Finding(
            "reference-shaped",
            f"the actuator rings at {frequency}: the unit splits its reference into two parts "
            f"{period * resonance.samples(period):.3g} s apart, whose swings cancel. Give it the reference "
            f"{resonance.lead:.2g} s ahead, or the output follows that much behind. To leave the reference as it is "
            f"identify with --resonance none.",
        )
    else:
        longest = 0.5 * resonance.half_swing
        yield Finding(
            "resonance-too-fast",
            f"the actuator rings at {frequency}, and with a period of {period:g} s the unit is too slow to shape its "
            f"reference. Run it every {longest:.2g} s or faster (--period {longest:.2g}), or smooth the reference.",
        )


def _late(subject: Subject) -> Iterator[Finding]:
    """Say on which processors a step takes longer than the period, and what would help."""
    period = subject.period
    if period is None:
        return
    times = budget(subject).seconds()
    late = []
    clauses = []
    slowest = 0.0
    for name, (typical, most) in times.items():
        if max(typical, most) <= period:
            continue
        late.append(name)
        slowest = max(slowest, most)
        clauses.append(
            f"a {name} at {CLOCKS[name] / 1e6:.0f} MHz takes {typical:.2g} s a step and {most:.2g} s at most"
        )
    if not late:
        return
    needed = float(f"{1.05 * slowest:.2g}")
    cure = f"Call it more seldom (--period {needed:g})"
    if subject.real != "float":
        single = budget(replace(subject, real="float")).seconds()
        if all(max(single[name]) <= period for name in late):
            cure = "Export it with --real float, which keeps the period on all of them"
    yield Finding(
        "step-exceeds-period",
        f"the unit is to run every {period:g} s, and {'; '.join(clauses)}, at one instruction a cycle: "
        f"a step that is late answers a "
        f"sample that is old. {cure}; or identify a family with fewer terms, or take a faster processor.",
    )


def _cost(subject: Subject) -> Iterator[Finding]:
    """Say which parts cost and do nothing, and when there are many."""
    model = subject.model
    parts, words = model.parts
    idle = parts - model.pruned().parts[0]
    if idle:
        yield Finding(
            "zero-weights",
            f"{idle} of {parts} {words} have weight zero: they take memory and time and change nothing. Add --prune to "
            f"leave them out, which is exact.",
        )
    if parts >= POLICY.many_operators:
        yield Finding(
            "many-operators",
            f"{parts} {words}: a step that turns the whole stack around moves all of them, and tables and state grow "
            f"with them. Look at the budget above; identify with fewer (--n 100) if it is too much for the target.",
        )


def _coarse(subject: Subject) -> Iterator[Finding]:
    """Say where numbers of this size are too coarse in float: a small range far from zero."""
    if subject.real != "float" or subject.block is None or subject.direct is not None:
        return
    for card in (subject.input, subject.output):
        low, high = float(card.low or 0.0), float(card.high or 0.0)
        step = float(np.spacing(np.float32(max(abs(low), abs(high)))))
        if step > POLICY.coarse * (high - low):
            yield Finding(
                "coarse-float",
                f"{card.label} goes from {low:.6g} to {high:.6g}, where neighbouring floats lie {step:.2g} apart, "
                f"{100 * step / (high - low):.2g} % of the range: answers within 1e-5 of the range cannot be expected. "
                f"Export with --real double, or identify with a signal whose mean was taken off.",
            )


def _stalled(subject: Subject) -> Iterator[Finding]:
    """Say where lags are too slow for float: what they should move is less than the last digit."""
    numbers = subject.direct
    if subject.real != "float" or numbers is None or not numbers.gain:
        return
    share = stall(numbers) / (numbers.input_high - numbers.input_low)
    if share > POLICY.stalled:
        yield Finding(
            "coarse-float",
            f"the slowest creep lag moves by {min(numbers.gain):.2g} of its distance in a sample: in single precision "
            f"it stops {100 * share:.2g} % of the range before it is there. Export with --real double, or with a "
            f"longer period.",
        )


def stall(numbers: DirectNumbers) -> float:
    """Return how far from its end the slowest lag stops in float. [y]

    Examples
    --------
    >>> from dehyst.export.kit import direct_numbers
    >>> from dehyst.models import DirectInverse, ModelCard, SignalCard
    >>> card = ModelCard(SignalCard("torque", "Nm"), SignalCard("angle", "rad", -1.0, 1.0))
    >>> model = DirectInverse(time_constants=[100.0], creep_weights=[1.0], card=card)
    >>> round(stall(direct_numbers(model.parameters(1e-3))), 4)
    0.006
    """
    largest = max(abs(numbers.input_low), abs(numbers.input_high))
    return 0.5 * float(np.spacing(np.float32(largest))) / min(numbers.gain)
