"""Statistical tests of drift: changes with confidence intervals, status, scores and trends over cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.monitoring._groups import Contrast, Cycle, contrast, groups_of, rms, trend
from dehyst.monitoring._parts import (
    ERROR,
    GAIN,
    HYSTERESIS,
    OFFSET,
    OWN_CREEP,
    REST,
    VISCOUS,
    Estimates,
    MeasuredRecording,
    Scale,
    estimate,
)
from dehyst.monitoring._policy import POLICY
from dehyst.monitoring._result import (
    CANNOT_TELL,
    DRIFTED,
    UNCHANGED,
    LogDrift,
    PartChange,
    ScoredBlocks,
    Trend,
)

SCALED = (GAIN, HYSTERESIS, OWN_CREEP, VISCOUS)
CONFIDENCE = 0.95
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
        """Whether a change of this part with this p-value counts as a change."""
        return p_value < self.level and part not in self.ignored

    @property
    def bound(self) -> float:
        """Effect of a change that a log must be able to show to be called unchanged, percent of range."""
        if self.least is None:
            return POLICY.bound
        # A change that is hardly larger than the least one cannot be told from it: twice as much must be found.
        return max(POLICY.bound, 2.0 * self.least)

    def tolerance(self, part: str, referred: bool) -> float:
        """Change of a part that does not count, percent of range."""
        if self.least is not None:
            return self.least
        if referred or self.own_error is None:
            return POLICY.least_change
        # The card's error is one of the whole range, of which the mean is only a part.
        share = POLICY.own_share
        if part == OFFSET:
            share = POLICY.offset_share
        return max(POLICY.least_change, share * self.own_error)


def changes_of(
    now: Estimates, before: Estimates | None, alike: bool, scale: Scale, rule: Rule, unit: str
) -> list[PartChange]:
    """Compare the groups of a log with those of the reference, or with no change at all."""
    changes = []
    percent = (100.0 * now.sizes / scale.span).tolist()  # what a coefficient of 1 does
    for k, part in enumerate(now.parts):
        then = None
        if before is not None:
            then = before.values[:, k]
        tested = _compare(now, before, now.values[:, k], then)
        tolerance = rule.tolerance(part, before is not None and alike) / percent[k]
        changes.append(_change(part, tested, tolerance, rule, percent[k], unit))
    return [*changes, *_growths(now, before, alike, scale, rule)]


def status_of(changes: Sequence[PartChange], error_percent: float, rule: Rule) -> str:
    """Return what a log says: unchanged only if every change worth a word would have shown, and the error stayed.

    Where nobody knows what the error was, it must be less than what a change worth a word does.
    """
    if any(change.drifted for change in changes):
        return DRIFTED
    error_compared = ERROR in rule.ignored
    for change in changes:
        if not change.resolved:
            return CANNOT_TELL
        error_compared = error_compared or change.part == ERROR
    if error_compared or error_percent <= rule.bound:
        return UNCHANGED
    return CANNOT_TELL


def _compare(
    now: Estimates, before: Estimates | None, values: Array, then: Array | None
) -> Contrast:
    """Against zero, the groups of a reference, or group by group where both were moved alike."""
    if before is None or then is None:
        return contrast(values)
    # Groups of one motion share the errors of the model, which their differences leave out.
    if now.motion.size == before.motion.size and np.all(
        np.abs(now.motion - before.motion) <= POLICY.same_motion * before.motion
    ):
        return contrast(values - then)
    return contrast(values, then)


def factor_of(part: str, percent: float) -> float:
    """By what a coefficient is multiplied to be shown."""
    if part == OFFSET:
        return 1.0
    # A scaled part is shown in percent of itself, whatever its size on the range.
    if part in SCALED:
        return 100.0
    return percent


def _change(
    part: str, tested: Contrast, tolerance: float, rule: Rule, percent: float, unit: str
) -> PartChange:
    factor = factor_of(part, percent)
    low, high = tested.interval(CONFIDENCE)
    p_value = tested.p_value(tolerance)
    detectable = tested.detectable(tolerance, rule.level)
    if part != OFFSET:
        unit = "%"
    return PartChange(
        part=part,
        estimate=factor * tested.estimate,
        low=factor * low,
        high=factor * high,
        unit=unit,
        effect_percent=percent * abs(tested.estimate),
        detectable=factor * detectable,
        detectable_percent=percent * detectable,
        p_value=p_value,
        drifted=rule.counts(part, p_value),
        resolved=part in rule.ignored or percent * detectable <= rule.bound,
    )


def _growth(
    part: str,
    now: Array,
    tested: Contrast,
    allowed: float,
    before_rms: float,
    scale: Scale,
    rule: Rule,
) -> PartChange:
    """Growth of an RMS, on a logarithmic scale: of the whole error, or of what no part explains.

    `now` is that of the groups, `known` the RMS of all groups that it is compared with. [response]
    """
    ends = np.array([tested.estimate, *tested.interval(CONFIDENCE)])
    growth, low, high = (100.0 * np.expm1(ends.clip(-20.0, 20.0))).tolist()
    # An error that hardly shows on the range is no news, by whatever factor it grew.
    size = 100.0 * float(np.exp(np.mean(np.log(now)))) / scale.span
    small = size < rule.tolerance(OFFSET, True)
    p_value = 1.0
    if not small:
        p_value = tested.p_value(float(np.log(allowed)), sided=1)
    detectable = float(np.expm1(min(20.0, tested.detectable(float(np.log(allowed)), rule.level))))
    grown = max(high, 100.0 * (rms(now) / before_rms - 1.0))
    resolved = part == REST or small or part in rule.ignored or grown < POLICY.doubled
    return PartChange(
        part, growth, low, high, "%", size, 100.0 * detectable, None, p_value, rule.counts(part, p_value), resolved
    )  # fmt: skip


def _growths(
    now: Estimates, before: Estimates | None, alike: bool, scale: Scale, rule: Rule
) -> list[PartChange]:
    """Growth of the rest and of the error; none where nothing is known to compare them with."""
    floor = ROUNDING * scale.span
    remainder = np.maximum(now.remainder, floor)
    error = np.maximum(now.counted, floor)
    if before is not None:
        old_rest = np.maximum(before.remainder, floor)
        old_error = np.maximum(before.counted, floor)
        rest_grown = _compare(now, before, np.log(remainder), np.log(old_rest))
        error_grown = _compare(now, before, np.log(error), np.log(old_error))
        # Under another motion the model's own error is another one, too.
        allowed = POLICY.rest_growth_card
        if alike:
            allowed = POLICY.rest_growth
        return [
            _growth(REST, remainder, rest_grown, POLICY.rest_growth, rms(old_rest), scale, rule),
            _growth(ERROR, error, error_grown, allowed, rms(old_error), scale, rule),
        ]
    if rule.own_error is None:
        return []
    # Nothing but the error on the model's card: it stands for both.
    card_rms = max(0.01 * rule.own_error * scale.span, floor)
    growths = []
    for part, values in ((REST, remainder), (ERROR, error)):
        grown = contrast(np.log(values), float(np.log(card_rms)))
        growths.append(_growth(part, values, grown, POLICY.rest_growth_card, card_rms, scale, rule))
    return growths


MOST_BLOCKS = 120


def percents(estimates: Estimates, scale: Scale) -> tuple[float, float | None]:
    """Errors of all groups together, of the response and of the drive that the inverse asks for. [% of range]"""
    inverse = None
    if estimates.inverse is not None:
        inverse = 100.0 * rms(estimates.inverse) / (2.0 * scale.drive[1])
    return 100.0 * rms(estimates.error) / scale.span, inverse


def scored_blocks(
    measured: MeasuredRecording,
    cycles: Sequence[Cycle],
    steps: Sequence[Sequence[str]],
    scale: Scale,
    first: int,
    old: Sequence[Cycle],
) -> ScoredBlocks:
    """Score blocks of cycles one by one; a block is either of the reference or not."""
    # A block across the border would mix then and now.
    new = cycles[len(old) :]
    groups = list(filter(None, [*groups_of(old, MOST_BLOCKS), *groups_of(new, MOST_BLOCKS)]))
    estimates = estimate(measured, groups, steps)
    ends = np.cumsum(list(map(len, groups)))
    begins = np.concatenate([[0], ends[:-1]])
    inverse = None
    if estimates.inverse is not None:
        inverse = 100.0 * estimates.inverse / (2.0 * scale.drive[1])
    percent = 100.0 * estimates.sizes / scale.span
    changes = {}
    for k, part in enumerate(estimates.parts):
        changes[part] = factor_of(part, float(percent[k])) * estimates.values[:, k]
    return ScoredBlocks(
        first + 0.5 * (begins + ends + 1.0),
        100.0 * estimates.error / scale.span,
        inverse,
        changes,
    )


def trends_of(entries: Sequence[LogDrift], rate: float) -> tuple[Trend, ...]:
    """Straight lines over the blocks of all logs, at the false alarm rate over all parts."""
    cycles: list[Array] = []
    series: dict[str, list[Array]] = {}
    units: dict[str, str] = {}
    for entry in entries:
        for change in entry.changes:
            units[change.part] = change.unit
        if entry.blocks is None:
            continue
        cycles.append(entry.blocks.cycle)
        series.setdefault("error", []).append(entry.blocks.error_percent)
        # All logs of a call are fitted by the same parts.
        for part, changes in entry.blocks.changes.items():
            series.setdefault(part, []).append(changes)
    if not cycles:
        return ()
    units["error"] = "%"
    places = np.concatenate(cycles)
    trends = []
    for part, pieces in series.items():
        # The intervals share the false alarms, as the tests of the parts do.
        line = trend(places, np.concatenate(pieces), 1.0 - rate / len(series))
        if line is not None:
            slope, low, high = (100.0 * np.array(line)).tolist()
            trends.append(Trend(part, slope, low, high, units.get(part, "%")))
    return tuple(trends)
