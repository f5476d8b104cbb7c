"""From fits of groups to changes with intervals, and to a yes or no."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.identification.drift.design import (
    GAIN,
    HYSTERESIS,
    OFFSET,
    OWN_CREEP,
    REST,
    VISCOUS,
    Estimates,
    Scale,
)
from dehyst.identification.drift.result import Change
from dehyst.identification.drift.statistics import Contrast, contrast

Array = npt.NDArray[np.float64]

# Smallest change worth a word: RMS of what it does, percent of the response's range.
LEAST = 0.1
# Without a reference a model's own error may look like a change: by this share of it, and of it for the offset, which
# every fit brings to zero.
OWN_SHARE = 1.0
OFFSET_SHARE = 0.5
SCALED = (GAIN, HYSTERESIS, OWN_CREEP, VISCOUS)
# The rest may grow by this factor: against a reference, and against the error that the card names.
REST_GROWTH, REST_GROWTH_CARD = 1.25, 1.5
CONFIDENCE = 0.95
# Groups of cycles whose drives scatter within this share of each other were moved alike, and are compared in pairs.
SAME = 0.05
# Errors below this share of the range are rounding.
ROUNDING = 1e-6


@dataclass(frozen=True, slots=True)
class Rule:
    """When a change counts.

    Attributes
    ----------
    level
        Probability of a false alarm allowed to a single test.
    least
        Smallest change worth a word, percent of range, or None for the built-in one.
    own_error
        Error of the model when it was identified, percent of range; None if unknown.
    ignored
        Parts that are measured and never count.
    """

    level: float
    least: float | None
    own_error: float | None
    ignored: tuple[str, ...] = ()

    def counts(self, part: str, p_value: float) -> bool:
        """Whether a change of that probability is one."""
        return p_value < self.level and part not in self.ignored

    def tolerance(self, part: str, referred: bool) -> float:
        """Change of a part that does not count, percent of range."""
        if self.least is not None:
            return self.least
        if referred or self.own_error is None:
            return LEAST
        return max(LEAST, (OFFSET_SHARE if part == OFFSET else OWN_SHARE) * self.own_error)


def changes_of(
    now: Estimates, before: Estimates | None, alike: bool, scale: Scale, rule: Rule, unit: str
) -> list[Change]:
    """Compare the groups of a log with those of the reference, or with no change at all."""
    found = []
    percent = (100.0 * now.sizes / scale.span).tolist()  # what a coefficient of 1 does
    for k, part in enumerate(now.parts):
        tested = _compare(now, before, now.values[:, k], None if before is None else before.values[:, k])
        tolerance = rule.tolerance(part, before is not None and alike) / percent[k]
        found.append(_change(part, tested, tolerance, rule, percent[k], unit))
    rest = _rest(now, before, scale, rule)
    return [*found, rest] if rest is not None else found


def _compare(now: Estimates, before: Estimates | None, values: Array, then: Array | None) -> Contrast:
    """Against zero, the groups of a reference, or group by group where both were moved alike."""
    if before is None or then is None:
        return contrast(values)
    if now.motion.size == before.motion.size and np.all(np.abs(now.motion - before.motion) <= SAME * before.motion):
        return contrast(values - then)
    return contrast(values, then)


def factor_of(part: str, percent: float) -> float:
    """By what a coefficient is multiplied to be shown."""
    return 1.0 if part == OFFSET else 100.0 if part in SCALED else percent


def _change(part: str, tested: Contrast, tolerance: float, rule: Rule, percent: float, unit: str) -> Change:
    factor = factor_of(part, percent)
    low, high = tested.interval(CONFIDENCE)
    p_value = tested.p_value(tolerance)
    return Change(
        part=part,
        estimate=factor * tested.estimate,
        low=factor * low,
        high=factor * high,
        unit=unit if part == OFFSET else "%",
        effect_percent=percent * abs(tested.estimate),
        detectable=factor * tested.detectable(tolerance, rule.level),
        p_value=p_value,
        drifted=rule.counts(part, p_value),
    )


def _rest(now: Estimates, before: Estimates | None, scale: Scale, rule: Rule) -> Change | None:
    """Growth of what no part explains, on a logarithmic scale."""
    floor = ROUNDING * scale.span
    logs = np.log(np.maximum(now.rest, floor))
    if before is not None:
        tested, allowed = _compare(now, before, logs, np.log(np.maximum(before.rest, floor))), REST_GROWTH
    elif rule.own_error is not None:
        own = max(0.01 * rule.own_error * scale.span, floor)
        tested, allowed = contrast(logs, float(np.log(own))), REST_GROWTH_CARD
    else:
        return None
    ends = np.array([tested.estimate, *tested.interval(CONFIDENCE)])
    growth, low, high = (100.0 * np.expm1(ends.clip(-20.0, 20.0))).tolist()
    # A rest that hardly shows on the range is no news, by whatever factor it grew.
    size = 100.0 * float(np.exp(np.mean(logs))) / scale.span
    p_value = tested.p_value(float(np.log(allowed)), sided=1)
    if size < rule.tolerance(OFFSET, True):
        p_value = 1.0
    detectable = float(np.expm1(min(20.0, tested.detectable(float(np.log(allowed)), rule.level))))
    return Change(REST, growth, low, high, "%", size, 100.0 * detectable, p_value, rule.counts(REST, p_value))
