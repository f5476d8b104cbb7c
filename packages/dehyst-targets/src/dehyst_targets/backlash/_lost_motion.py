"""Lost motion over position: errors of both directions, their spread, and what chance alone would show."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import RecordingError
from dehyst.findings import Finding
from dehyst.shell import command
from dehyst.student import place_of_tail
from dehyst_targets.backlash._policy import POLICY
from dehyst_targets.backlash._readings import AxisReadings


@dataclass(frozen=True, eq=False)
class LostMotion:
    r"""Errors of an axis at nominal points, approached from below (rising) and from above (falling).

    The error is the actual position less the commanded one. A play of width :math:`b` makes a rising axis come short
    and a falling one stay behind above, so that the lost motion

    .. math:: b_i = \bar e_i^{falling} - \bar e_i^{rising}

    is positive. It is the reversal value of ISO 230-2 with the other sign. The mean of both directions at the point
    nearest to 0 is taken for 0 (`offset`): where an axis begins to count is set by homing, not by a table.

    Attributes
    ----------
    nominal
        Commanded positions, (n,), rising. [unit]
    rising, falling
        Mean errors, (n,). [unit]
    rising_spread, falling_spread
        Sample standard deviations, (n,), NaN of a single reading. [unit]
    counts
        Readings of each point, rising and falling, (2, n).
    spread
        Standard deviation of one reading, pooled over all points. [unit]
    freedom
        Its degrees of freedom.
    interval
        The lost motion of each point lies within plus or minus this, at 95 %, (n,). [unit]
    mean, mean_interval
        Lost motion on average over the axis, and plus or minus how much, at 95 %. [unit]
    is_significant
        Whether chance alone would show such lost motion in less than 1 % of all measurements, on average or at a
        point (Bonferroni).
    is_mean_significant
        The same of the average alone.
    is_pitch_significant
        The same of the mean errors of both directions against that of the reference point.
    offset
        What was taken away from all errors. [unit]
    unit
        Of all lengths, "" where none is known.
    findings
        Of the readings and of their evaluation.

    Examples
    --------
    >>> lost = LostMotion.example()
    >>> lost.lost_motion.round(3).tolist(), lost.is_significant
    ([0.03, 0.04, 0.05], True)
    """

    nominal: Array
    rising: Array
    falling: Array
    rising_spread: Array
    falling_spread: Array
    counts: Array
    spread: float
    freedom: int
    interval: Array
    mean: float
    mean_interval: float
    is_significant: bool
    is_mean_significant: bool
    is_pitch_significant: bool
    offset: float
    unit: str
    findings: tuple[Finding, ...] = ()

    @property
    def lost_motion(self) -> Array:
        """Error when falling less error when rising, (n,). [unit]"""
        return self.falling - self.rising

    @property
    def middle(self) -> Array:
        """Mean of both directions, (n,): what is wrong with the pitch. [unit]"""
        return 0.5 * (self.rising + self.falling)

    @property
    def reference(self) -> int:
        """Index of the point nearest to 0."""
        return int(np.argmin(np.abs(self.nominal)))

    @property
    def between(self) -> float:
        """About how far a straight line between two points may miss, 0 with fewer than three points. [unit]

        A smooth error is missed by four times as much where a point is left out, which is what is measured here. What
        repeats from point to point, as a screw whose lead is their distance, stays unseen.
        """
        missed = [0.0]
        for error in (self.rising, self.falling):
            for k in range(1, self.nominal.size - 1):
                around = [k - 1, k + 1]
                line = np.interp(self.nominal[k], self.nominal[around], error[around])
                missed.append(0.25 * abs(float(error[k] - line)))
        return max(missed)

    @property
    def expected(self) -> float:
        """Two standard deviations of a new reading, the uncertainty of the mean errors included. [unit]"""
        return 2.0 * self.spread * math.sqrt(1.0 + 1.0 / float(self.counts.min()))

    @property
    def is_reversed(self) -> bool:
        """Whether the lost motion is negative, and not by chance: no play does that."""
        return self.is_significant and self.mean < 0.0

    @classmethod
    def example(cls) -> LostMotion:
        """Return a small one: three points, three readings of each, 0.03 to 0.05 mm."""
        nominal = np.repeat([0.0, 100.0, 200.0], 6)
        rising = np.tile([True, False], 9)
        half = 0.5 * np.interp(nominal, [0.0, 200.0], [0.03, 0.05])
        noise = np.tile([0.0, 0.0, 0.001, 0.001, -0.0005, -0.001], 3)
        error = np.where(rising, -half, half) + noise
        return lost_motion(AxisReadings(nominal, error, rising, unit="mm"))


def lost_motion(readings: AxisReadings) -> LostMotion:
    """Evaluate readings of an axis.

    Readings of one point and one direction are a group. Their spread is pooled over all groups. With one reading a
    group it is taken from how the lost motion differs from point to point, which is never too small. It is no smaller
    than the rounding of the readings, q/sqrt(12). Outliers are found by studentized deleted residuals.

    Parameters
    ----------
    readings
        Of one axis, from `read_measurement`. With several approaches the longest counts.

    Returns
    -------
    LostMotion
        Errors, lost motion, their spread and findings.

    Raises
    ------
    RecordingError
        If no point was read from both sides, two points or two repeats are missing, or the axis would turn back.

    References
    ----------
    ISO 230-2: bidirectional positioning, reversal value. R. D. Cook, S. Weisberg, Residuals and Influence in
    Regression (1982): studentized deleted residuals.

    Examples
    --------
    >>> readings = AxisReadings.of([0, 0, 50, 50], [0.0, 0.03, 0.01, 0.04], [1, 0, 1, 0], unit="mm")
    >>> round(lost_motion(readings).mean, 6)
    0.03
    """
    findings = list(readings.findings)
    longest = readings
    # A short approach may end before the play is crossed; the longest one shows all of it.
    if readings.approaches.size > 1:
        longest = readings.select(readings.approach == readings.approaches[-1])
    longest, one_sided = _two_sided(longest)
    findings += one_sided
    longest, outliers = _without_outliers(longest)
    findings += outliers
    lost = _evaluated(longest)
    _refuse_turning_back(lost)
    if longest.freedom == 0:
        findings.append(_one_repeat(lost))
    else:
        findings += _drift(longest)
    findings += _approach(lost, longest) + _shape(lost)
    for shorter in readings.approaches[:-1]:
        findings += _amplitude(readings, float(shorter), lost)
    return replace(lost, findings=tuple(findings))


def _two_sided(readings: AxisReadings) -> tuple[AxisReadings, list[Finding]]:
    """Leave out points that were read from one side only."""
    both = np.intersect1d(readings.commanded[readings.rising], readings.commanded[~readings.rising])
    if not both.size:
        sides = f"{int(readings.rising.sum())} rising, {int((~readings.rising).sum())} falling"
        raise RecordingError(
            f"{readings.name}: no point was read from both sides ({sides}), and lost motion is their difference. "
            f"Read each point from below and from above: {command('backlash', 'plan', '--help')}"
        )
    used = np.isin(readings.commanded, both)
    missing = np.unique(readings.commanded[~used])
    if not missing.size:
        return readings, []
    shown = ", ".join(f"{point:g}" for point in missing[:6])
    message = (
        f"{missing.size} of {missing.size + both.size} points were read from one side only and are left out: {shown}"
        f"{' ...' * (missing.size > 6)} {readings.unit}. Their lost motion is interpolated. Read the other side too."
    )
    return readings.select(used), [Finding("backlash-one-side", message)]


def _without_outliers(readings: AxisReadings) -> tuple[AxisReadings, list[Finding]]:
    """Leave out readings that stand apart from the others of their group, one after the other."""
    findings: list[Finding] = []
    doubtful = np.zeros(readings.size, dtype=bool)
    # One at a time: a wrong reading widens the spread, and hides the next one in it.
    while readings.freedom > POLICY.fewest_freedom:
        share = _deviation(readings)
        # A pair that differs has been reported, and cannot be resolved.
        share[doubtful] = 0.0
        worst = int(np.argmax(np.abs(share)))
        limit = place_of_tail(0.5 * POLICY.chance / readings.size, readings.freedom - 1)
        if abs(share[worst]) <= limit:
            break
        group = readings.group == readings.group[worst]
        others = readings.error[group & (np.arange(readings.size) != worst)]
        place = f"{readings.place(worst)}, {readings.commanded[worst]:g} {readings.unit}"
        far = f"{readings.error[worst] - others.mean():+.4g} {readings.unit} from the others of its point"
        if group.sum() > 2:
            message = f"the reading of {place} lies {far} and is left out. Check it, and read this point again."
            readings = readings.select(np.arange(readings.size) != worst)
            doubtful = np.delete(doubtful, worst)
        else:
            # Of two readings that differ nobody knows which one is wrong.
            message = f"the two readings at {place} differ too much ({far}); both count. Read this point again."
            doubtful |= group
        findings.append(Finding("backlash-outlier", message))
    return readings, findings


def _deviation(readings: AxisReadings) -> Array:
    """Studentized deleted residual of every reading, 0 where a group has one."""
    residual, count = readings.residual, readings.group_count
    independent = 1.0 - 1.0 / count
    square = np.divide(residual**2, independent, out=np.zeros_like(residual), where=count > 1)
    deleted = (np.sum(residual**2) - square) / (readings.freedom - 1)
    # Readings that are all alike still differ by what their last digit hides.
    spread = np.sqrt(np.maximum(deleted, readings.rounding**2))
    deviation: Array = residual / (spread * np.sqrt(np.maximum(independent, 0.5)))
    return deviation


def _evaluated(readings: AxisReadings) -> LostMotion:
    nominal = np.unique(readings.commanded)
    means, spreads, counts = [], [], []
    for rising in (True, False):
        for point in nominal:
            errors = readings.error[(readings.commanded == point) & (readings.rising == rising)]
            means.append(errors.mean())
            counts.append(errors.size)
            spreads.append(math.nan)
            if errors.size > 1:
                spreads[-1] = float(errors.std(ddof=1))
    error = np.array(means).reshape(2, -1)
    count = np.array(counts, dtype=np.float64).reshape(2, -1)
    lost = error[1] - error[0]
    spread, freedom = _spread(readings, lost)
    # Variances of the lost motion of a point, of its mean over all points, of a point's mean error.
    variance = spread**2 * (1.0 / count).sum(axis=0)
    mean_deviation = math.sqrt(variance.sum()) / nominal.size
    reference = int(np.argmin(np.abs(nominal)))
    middle = 0.5 * error.sum(axis=0)
    # Homing decides where an axis begins to count, so that the reference point is taken for right.
    offset = float(middle[reference])
    pitch = np.delete(middle - offset, reference)
    pitch_deviation = 0.5 * np.sqrt(np.delete(variance, reference) + variance[reference])
    interval = place_of_tail(0.5 * POLICY.outside, freedom)
    mean_limit = place_of_tail(0.5 * POLICY.chance, freedom)
    # So many points are tested at once that one of them would stand out by chance (Bonferroni).
    point_limit = place_of_tail(0.5 * POLICY.chance / nominal.size, freedom)
    is_mean_significant = bool(abs(lost.mean()) > mean_limit * mean_deviation)
    return LostMotion(
        nominal=nominal,
        rising=error[0] - offset,
        falling=error[1] - offset,
        rising_spread=np.array(spreads[: nominal.size]),
        falling_spread=np.array(spreads[nominal.size :]),
        counts=count.astype(np.int64),
        spread=spread,
        freedom=freedom,
        interval=interval * np.sqrt(variance),
        mean=float(lost.mean()),
        mean_interval=interval * mean_deviation,
        is_significant=is_mean_significant
        or bool(np.any(np.abs(lost) > point_limit * np.sqrt(variance))),
        is_mean_significant=is_mean_significant,
        is_pitch_significant=bool(np.any(np.abs(pitch) > point_limit * pitch_deviation)),
        offset=offset,
        unit=readings.unit,
    )


def _spread(readings: AxisReadings, lost: Array) -> tuple[float, int]:
    """Standard deviation of one reading and its degrees of freedom."""
    if readings.freedom > 0:
        square, freedom = np.sum(readings.residual**2) / readings.freedom, readings.freedom
    elif lost.size > 1:
        # The difference of two readings has twice the variance of one.
        square, freedom = 0.5 * lost.var(ddof=1), lost.size - 1
    else:
        raise RecordingError(
            f"{readings.name}: one point with one reading from each side tells nothing of the repeatability, so "
            f"that no lost motion can be told from chance. Read more points, each several times: "
            f"{command('backlash', 'plan', '--help')}"
        )
    return math.sqrt(max(float(square), readings.rounding**2)), freedom


def _refuse_turning_back(lost: LostMotion) -> None:
    """Refuse errors by which the axis would go back while it is told to go on: a table of them cannot be followed."""
    for name, error in (("rising", lost.rising), ("falling", lost.falling)):
        turns = np.flatnonzero(np.diff(lost.nominal + error) <= 0.0)
        if turns.size:
            k = int(turns[0])
            raise RecordingError(
                f"{name}, the axis was measured at {lost.nominal[k] + error[k]:.6g} {lost.unit} for "
                f"{lost.nominal[k]:g} and at {lost.nominal[k + 1] + error[k + 1]:.6g} for {lost.nominal[k + 1]:g}: it "
                f"would go back while it is told to go on. Look for a slip of the pen in the sheet at these points."
            )


def _one_repeat(lost: LostMotion) -> Finding:
    return Finding(
        "backlash-one-repeat",
        f"each point was read once from each side, so that nothing shows how far a reading repeats. The spread of "
        f"{lost.spread:.3g} {lost.unit} is taken from how the lost motion differs from point to point. Measure with "
        f"`dehyst backlash plan --repeats 3`.",
    )


def _drift(readings: AxisReadings) -> list[Finding]:
    """A straight line of all readings over their order, their own groups apart."""
    order = np.arange(readings.size, dtype=np.float64)
    # Points differ in level; only what moves within a group is drift.
    order -= readings.group_mean(order)
    square = float(np.sum(order**2))
    freedom = readings.freedom - 1
    if square == 0.0 or freedom < POLICY.fewest_freedom:
        return []
    slope = float(np.sum(order * readings.residual)) / square
    variance = float(np.sum((readings.residual - slope * order) ** 2)) / freedom
    deviation = math.sqrt(max(variance, readings.rounding**2) / square)
    if abs(slope) <= place_of_tail(0.5 * POLICY.chance, freedom) * deviation:
        return []
    message = (
        f"repeated readings move by {slope * (readings.size - 1):+.3g} {readings.unit} from the first to the last, "
        f"more than chance: the axis warms up, or the gauge slips. No table compensates that. Warm the machine up, "
        f"clamp the gauge and measure again."
    )
    return [Finding("backlash-drift", message)]


def _approach(lost: LostMotion, readings: AxisReadings) -> list[Finding]:
    if not readings.approaches.size:
        return []
    approach = float(readings.approaches[-1])
    largest = float(np.max(np.abs(lost.lost_motion)))
    if largest <= POLICY.of_approach * approach:
        return []
    message = (
        f"the lost motion is up to {largest:.4g} {lost.unit}, and the points were approached over {approach:g} "
        f"{lost.unit}: the axis may not have followed to the end, and the lost motion be larger. Measure with a longer "
        f"`--approach`, at least {2.0 * largest / POLICY.of_approach:.2g}."
    )
    return [Finding("backlash-approach", message)]


def _shape(lost: LostMotion) -> list[Finding]:
    """A scale error, and errors that change faster over the way than those of a screw."""
    if lost.nominal.size < 3:
        return []
    findings = []
    # A wrong number of steps per unit is a straight line over the whole axis.
    slope, level = np.polyfit(lost.nominal, lost.middle, 1)
    if lost.is_pitch_significant and (
        abs(slope) > POLICY.scale or _line_matters(lost, slope, level)
    ):
        message = (
            f"the axis goes {1.0 + slope:.5f} times the commanded way. Multiply its steps per {lost.unit or 'unit'} by "
            f"{1.0 / (1.0 + slope):.5f} and measure again: then it is right beyond the measured points too."
        )
        findings.append(Finding("backlash-scale", message))
    line = slope * lost.nominal + level
    step = np.diff(lost.nominal)
    noise = place_of_tail(0.5 * POLICY.chance / step.size, lost.freedom)
    # One slip among readings of one repeat is in the spread, but hardly in the median.
    away = np.abs(lost.lost_motion - np.median(lost.lost_motion))
    noise *= min(math.sqrt(2.0) * lost.spread, 1.4826 * float(np.median(away)))
    for name, error in (("rising", lost.rising), ("falling", lost.falling)):
        change = np.abs(np.diff(error - line))
        k = int(np.argmax((change - noise) / step))
        if change[k] - noise > POLICY.steepest * step[k]:
            message = (
                f"{name}, the error changes by {change[k]:.4g} {lost.unit} from {lost.nominal[k]:g} to "
                f"{lost.nominal[k + 1]:g}, more than a screw or a belt does. Check the readings there, and read "
                f"points between them."
            )
            findings.append(Finding("backlash-steep", message))
    return findings


def _line_matters(lost: LostMotion, slope: float, level: float) -> bool:
    """Whether the mean errors lie on a line that misses by more than lost motion and readings do over the axis."""
    bent = lost.middle - slope * lost.nominal - level
    freedom = lost.nominal.size - 2
    away = lost.nominal - lost.nominal.mean()
    # What a screw adds to the line, as a wave, leaves its slope uncertain.
    deviation = math.sqrt(float(bent @ bent) / freedom / float(away @ away))
    is_line = abs(slope) > place_of_tail(0.5 * POLICY.chance, freedom) * deviation
    return is_line and abs(slope) * float(np.ptp(lost.nominal)) > max(abs(lost.mean), lost.expected)


def _amplitude(readings: AxisReadings, shorter: float, lost: LostMotion) -> list[Finding]:
    """Whether the lost motion after a shorter approach is another one."""
    part = readings.select(readings.approach == shorter)
    try:
        after_short = _evaluated(_two_sided(part)[0])
    except RecordingError:
        return []
    # Lost motion may change over the axis: only points that both have are compared.
    _, here, there = np.intersect1d(after_short.nominal, lost.nominal, return_indices=True)
    if not here.size:
        return []
    difference = float(np.mean(after_short.lost_motion[here] - lost.lost_motion[there]))
    variance = np.sum(1.0 / after_short.counts[:, here] + 1.0 / lost.counts[:, there])
    deviation = lost.spread * math.sqrt(float(variance)) / here.size
    limit = place_of_tail(0.5 * POLICY.chance, lost.freedom)
    if abs(difference) <= limit * deviation:
        return []
    message = (
        f"after an approach of {shorter:g} {lost.unit} the lost motion differs by {difference:+.3g} {lost.unit} from "
        f"that after {readings.approaches[-1]:g}: it depends on how far the axis goes after it turned. A table knows "
        f"the direction alone. It is right for long ways and wrong by up to so much for short ones."
    )
    return [Finding("backlash-amplitude", message)]
