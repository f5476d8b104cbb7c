"""The judgement: what the data shows, what to beware of, and the verdict in words."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.findings import Finding
from dehyst.identification import facts
from dehyst.identification.cautions import about_data, about_fit, of_range, rms
from dehyst.identification.data import DataSet
from dehyst.identification.fit import Certificate, LoopFacts, Score
from dehyst.identification.scores import Part
from dehyst.recording import Recording

Array = npt.NDArray[np.float64]

GOOD_PERCENT = 3.0
# Findings that keep a small error from being called good.
SERIOUS = {
    "rate-dependent",
    "drift",
    "mixed-loop",
    "few-loops",
    "high-inverse-gain",
    "recordings-differ",
    "swapped-columns",
}


def examine(
    records: tuple[Recording, ...],
    data: DataSet,
    loop: facts.Orientation,
    swings: tuple[facts.Rows, ...],
    outputs: tuple[Array, ...],
    curves: tuple[Array, ...],
    fitted: Part,
    held_out: Part,
    certificate: Certificate,
    family: str,
) -> tuple[LoopFacts, tuple[Finding, ...]]:
    """Return what the data shows and every finding a user should know, those of reading the log first."""
    # Where a curve is as good as the model, what is left of the model's error is not about the actuator.
    better = min((outputs, curves), key=lambda answers: rms(records, answers, fitted))
    loops, turns = facts.count_loops(data, swings)
    share, size = _rate(records, better, fitted, held_out, turns, data.output_range)
    change, doubt = 0.0, 0.0
    if len(records[0]) > 8:
        change, doubt = facts.drift(records[0].input, better[0] - records[0].output)
    loop_facts = LoopFacts(
        orientation=loop.name,
        trend=data.trend,
        width_percent=100.0 * loop.width,
        loops=loops,
        turns=turns,
        rate_dependence_percent=size,
        drift_percent=-100.0 * change / data.output_range,
    )
    found = [finding for record in records for finding in record.findings]
    found += about_data(records, data, loop_facts, share, size, abs(change), doubt, family)
    found += about_fit(records, data, outputs, curves, fitted, held_out, certificate)
    unique = {(finding.code, finding.message): finding for finding in found}
    return loop_facts, tuple(unique.values())


def _rate(
    records: tuple[Recording, ...],
    outputs: tuple[Array, ...],
    fitted: Part,
    held_out: Part,
    turns: int,
    output_range: float,
) -> tuple[float, float | None]:
    """Share of the error that the rate explains, and its size in percent of range, in the first timed recording."""
    for index, record in enumerate(records):
        if record.time is None or len(record.pieces) > 1:
            continue
        rows = facts.thinned(len(record), turns)
        usable = fitted.mask(index, len(record))[rows] | held_out.mask(index, len(record))[rows]
        time, x, y, predicted = record.time[rows], record.input[rows], record.output[rows], outputs[index][rows]
        share = facts.rate_share(time, x, y, predicted, usable)
        error = float(np.sqrt(np.mean((y - predicted)[usable] ** 2)))
        return share, 100.0 * error * float(np.sqrt(1.0 - (1.0 - share) ** 2)) / output_range
    return 0.0, None


def verdict(
    family: str,
    train: Score,
    test: Score | None,
    static: Score,
    certificate: Certificate,
    findings: tuple[Finding, ...],
) -> str:
    """The judgement in one line."""
    judged = test if test is not None else train
    where = "on held-out loops" if test is not None else "on the fitted samples (none held out)"
    codes = {finding.code for finding in findings}
    serious = sorted(codes & SERIOUS)
    if codes & {"poor-fit", "static-as-good", "inverse-misses", "never-turns"}:
        grade = "do not compensate with it"
    elif judged.rmse_percent <= GOOD_PERCENT and test is not None and not serious:
        grade = "good for compensation"
    else:
        grade = "usable with care" + (f" ({', '.join(serious)})" if serious else "")
    return (
        f"{family}, {certificate.nonzero_weights} of {certificate.operators} operators: {judged.rmse_percent:.2f} % of "
        f"range rms {where}, against {static.rmse_percent:.2f} % for the best curve without hysteresis; the inverse "
        f"gives the applied input back to {of_range(certificate.inverse_miss_percent)} its range: {grade}."
    )
