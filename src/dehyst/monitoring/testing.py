"""Statistical tests of drift: changes with confidence intervals, status, scores and trends over cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.monitoring.groups import Contrast, Cycle, contrast, groups_of, rms, trend
from dehyst.monitoring.parts import (
    ERROR,
    GAIN,
    HYSTERESIS,
    OFFSET,
    OWN_CREEP,
    REST,
    VISCOUS,
    Estimates,
    Measured,
    Scale,
    estimate,
)
from dehyst.monitoring.result import CANNOT_TELL, DRIFTED, UNCHANGED, Blocks, Change, LogDrift, Trend

# Smallest change worth a word: RMS of what it does, percent of the response's range.
LEAST = 0.1
# "Unchanged" is said only where every part would have shown a change that does this: RMS, percent of range. A change
# that is not worth a word cannot be asked for: where `least` is given, twice that, if it is more.
BOUND = 1.0
# And only where the error has not doubled, nor may have for all that the scatter tells. [% more]
DOUBLED = 100.0
# Without a reference a model's own error may look like a change: by this share of it, and of it for the offset, which
# every fit brings to zero.
OWN_SHARE = 1.0
OFFSET_SHARE = 0.5
SCALED = (GAIN, HYSTERESIS, OWN_CREEP, VISCOUS)
# Rest and error may grow by this factor: against a reference that was moved alike, and against another motion or the
# error that the card names.
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

    @property
    def bound(self) -> float:
        """Effect of a change that a log must be able to show to be called unchanged, percent of range."""
        return BOUND if self.least is None else max(BOUND, 2.0 * self.least)

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
    return [*found, *_growths(now, before, alike, scale, rule)]


def status_of(changes: Sequence[Change], error_percent: float, rule: Rule) -> str:
    """Return what a log says: unchanged only if every change worth a word would have shown, and the error stayed.

    Where nobody knows what the error was, it must be less than what a change worth a word does.
    """
    if any(change.drifted for change in changes):
        return DRIFTED
    known = any(change.part == ERROR for change in changes) or ERROR in rule.ignored
    told = all(change.resolved for change in changes) and (known or error_percent <= rule.bound)
    return UNCHANGED if told else CANNOT_TELL


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
    detectable = tested.detectable(tolerance, rule.level)
    return Change(
        part=part,
        estimate=factor * tested.estimate,
        low=factor * low,
        high=factor * high,
        unit=unit if part == OFFSET else "%",
        effect_percent=percent * abs(tested.estimate),
        detectable=factor * detectable,
        detectable_percent=percent * detectable,
        p_value=p_value,
        drifted=rule.counts(part, p_value),
        resolved=part in rule.ignored or percent * detectable <= rule.bound,
    )


def _growth(part: str, now: Array, tested: Contrast, allowed: float, known: float, scale: Scale, rule: Rule) -> Change:
    """Growth of an RMS, on a logarithmic scale: of the whole error, or of what no part explains.

    `now` is that of the groups, `known` the RMS of all groups that it is compared with. [response]
    """
    ends = np.array([tested.estimate, *tested.interval(CONFIDENCE)])
    growth, low, high = (100.0 * np.expm1(ends.clip(-20.0, 20.0))).tolist()
    # An error that hardly shows on the range is no news, by whatever factor it grew.
    size = 100.0 * float(np.exp(np.mean(np.log(now)))) / scale.span
    small = size < rule.tolerance(OFFSET, True)
    p_value = 1.0 if small else tested.p_value(float(np.log(allowed)), sided=1)
    detectable = float(np.expm1(min(20.0, tested.detectable(float(np.log(allowed)), rule.level))))
    grown = max(high, 100.0 * (rms(now) / known - 1.0))
    resolved = part == REST or small or part in rule.ignored or grown < DOUBLED
    return Change(
        part, growth, low, high, "%", size, 100.0 * detectable, None, p_value, rule.counts(part, p_value), resolved
    )  # fmt: skip


def _growths(now: Estimates, before: Estimates | None, alike: bool, scale: Scale, rule: Rule) -> list[Change]:
    """Growth of the rest and of the error; none where nothing is known to compare them with."""
    floor = ROUNDING * scale.span
    found = []
    for part, later, then, allowed in (
        (REST, now.rest, None if before is None else before.rest, REST_GROWTH),
        (ERROR, now.counted, None if before is None else before.counted, REST_GROWTH if alike else REST_GROWTH_CARD),
    ):
        later = np.maximum(later, floor)
        if then is not None:
            then = np.maximum(then, floor)
            tested, known = _compare(now, before, np.log(later), np.log(then)), rms(then)
        elif rule.own_error is not None:
            known = max(0.01 * rule.own_error * scale.span, floor)
            tested, allowed = contrast(np.log(later), float(np.log(known))), REST_GROWTH_CARD
        else:
            continue
        found.append(_growth(part, later, tested, allowed, known, scale, rule))
    return found


MOST_BLOCKS = 120


def percents(found: Estimates, scale: Scale) -> tuple[float, float | None]:
    """Errors of all groups together, of the response and of the drive that the inverse asks for. [% of range]"""
    inverse = None if found.inverse is None else 100.0 * rms(found.inverse) / (2.0 * scale.drive[1])
    return 100.0 * rms(found.error) / scale.span, inverse


def blocks_of(
    measured: Measured,
    cycles: Sequence[Cycle],
    steps: Sequence[Sequence[str]],
    scale: Scale,
    first: int,
    old: Sequence[Cycle],
) -> Blocks:
    """Score blocks of cycles one by one; a block is either of the reference or not."""
    groups = [*groups_of(old, MOST_BLOCKS), *groups_of(cycles[len(old) :], MOST_BLOCKS)]
    found = estimate(measured, [group for group in groups if group], steps)
    counts = np.cumsum([0, *(len(group) for group in groups if group)])
    percent = 100.0 * found.sizes / scale.span
    inverse = None if found.inverse is None else 100.0 * found.inverse / (2.0 * scale.drive[1])
    changes = {part: factor_of(part, float(percent[k])) * found.values[:, k] for k, part in enumerate(found.parts)}
    return Blocks(
        first + 0.5 * (counts[:-1] + counts[1:] + 1.0), 100.0 * found.error / scale.span, inverse, changes
    )  # fmt: skip


def trends_of(entries: Sequence[LogDrift], rate: float) -> tuple[Trend, ...]:
    """Straight lines over the blocks of all logs, at the false alarm rate over all parts."""
    blocks = [entry.blocks for entry in entries if entry.blocks is not None]
    if not blocks:
        return ()
    places = np.concatenate([block.cycle for block in blocks])
    series = {"error": ("%", np.concatenate([block.error_percent for block in blocks]))}
    units = {change.part: change.unit for entry in entries for change in entry.changes}
    for part in blocks[0].changes:
        series[part] = (units.get(part, "%"), np.concatenate([block.changes[part] for block in blocks]))
    found = []
    for part, (unit, values) in series.items():
        line = trend(places, values, 1.0 - rate / len(series))
        if line is not None:
            slope, low, high = line
            found.append(Trend(part, 100.0 * slope, 100.0 * low, 100.0 * high, unit))
    return tuple(found)
