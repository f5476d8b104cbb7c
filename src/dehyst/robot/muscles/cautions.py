"""Warnings about what a test-bench log cannot determine of a muscle."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from dehyst.arrays import Array
from dehyst.findings import Finding
from dehyst.robot.muscles.base import MuscleModel
from dehyst.robot.muscles.bench_log import BenchLog
from dehyst.robot.muscles.force_map import free_contraction

POOR_PERCENT = 5.0  # of the range of force, rms: more than the best models leave of any muscle
COVERED = 0.8  # of the contractions up to the free one
SAME_PRESSURE = 0.02  # relative range of a pressure that counts as held


def cautions(
    log: BenchLog,
    model: MuscleModel,
    percent: float,
    without_effect: Sequence[str],
    undetermined: Sequence[str],
    at_bound: Sequence[str],
    missed: Array,
    force: Array,
) -> tuple[Finding, ...]:
    """Return the findings of a fit, those that matter most first."""
    found = [
        *_fit(model, percent, missed),
        *_range(log, model),
        *_slack(log, force),
        *_parameters(log, model, without_effect, undetermined, at_bound),
    ]
    return tuple(found)


def _fit(model: MuscleModel, percent: float, missed: Array) -> list[Finding]:
    if percent <= POOR_PERCENT:
        return []
    return [
        Finding(
            "muscle-poor-fit",
            f"{model.name} misses the log by {percent:.1f} % of its range of force (rms; largest "
            f"{float(np.max(np.abs(missed))):.3g} N): it cannot be bent to this muscle. Check that the pressure is "
            f"gauge and the contraction counts from the length without pressure and load; then try another model: "
            f"sarosi or aschemann-schindele bend to most: dehyst muscle --list",
        )
    ]


def _range(log: BenchLog, model: MuscleModel) -> list[Finding]:
    covers, found = log.covers, []
    (k_low, k_high), (p_low, p_high) = covers["contraction"], covers["pressure"]
    free = free_contraction(model, p_high)
    if math.isfinite(free) and (k_high < COVERED * free or k_low > (1.0 - COVERED) * free):
        found.append(
            Finding(
                "muscle-extrapolation",
                f"where it pulls, the log goes from {100 * k_low:.1f} to {100 * k_high:.1f} % of contraction, and the "
                f"model from 0 to {100 * free:.1f} % at {p_high / 1e5:.3g} bar: forces elsewhere are what the formula "
                f"makes of the rest. Log the whole range, or use the model inside it only.",
            )
        )
    if p_high - p_low < SAME_PRESSURE * p_high:
        found.append(
            Finding(
                "muscle-one-pressure",
                f"the pressure stays at {p_high / 1e5:.3g} bar: how the force depends on it is the formula's guess. "
                f"Log at three pressures or more.",
            )
        )
    return found


def _slack(log: BenchLog, force: Array) -> list[Finding]:
    slack = int(log.slack.sum())
    if not slack:
        return []
    return [
        Finding(
            "muscle-slack",
            f"{slack} of {len(log)} samples do not count: there the muscle hangs loose, with less than half a percent "
            f"of the largest force ({float(log.force.max()):.4g} N), and a formula that goes on below zero cannot be "
            f"compared. There the model pulls {max(float(force[log.slack].max()), 0.0):.3g} N at most. Nothing to do, "
            f"unless the force sensor was off.",
        )
    ]


def _parameters(
    log: BenchLog,
    model: MuscleModel,
    without_effect: Sequence[str],
    undetermined: Sequence[str],
    at_bound: Sequence[str],
) -> list[Finding]:
    found = []
    if without_effect:
        why = (
            "the log has no time, so that every row is a point at rest, and what only motion shows"
            if log.time is None
            else "no sample depends on them, and what the log does not show"
        )
        found.append(
            Finding(
                "muscle-not-in-log",
                f"{', '.join(without_effect)} of {model.name} stayed as given: {why} was not fitted. For friction and "
                f"damping, log loops of contraction at two speeds, with time.",
            )
        )
    if undetermined:
        found.append(
            Finding(
                "muscle-undetermined",
                f"{', '.join(undetermined)} cannot be told apart from this log: other values give the same forces. Use "
                f"the forces, not these values; more pressures and contractions may part them.",
            )
        )
    if at_bound:
        found.append(
            Finding(
                "muscle-at-bound",
                f"{', '.join(at_bound)} ended at a bound of the search. Where that is zero, the log shows nothing of "
                f"it; elsewhere the muscle wants a value that has no meaning in this model, or the log's units are "
                f"wrong. The bounds: dehyst muscle {model.name} --json",
            )
        )
    return found
