"""The judgement: what the data shows, what to beware of, and the verdict in words."""

from __future__ import annotations

from dehyst.arrays import rank
from dehyst.data.recording import Recording
from dehyst.findings import Finding
from dehyst.identification import facts
from dehyst.identification.cautions import Knows, about_data, about_fit, of_range
from dehyst.identification.data import DataSet
from dehyst.identification.families import STATIC
from dehyst.identification.fit import Certificate, LoopFacts, Score
from dehyst.identification.measures import Measured

GOOD_PERCENT = 3.0
# Findings that keep a small error from being called good.
SERIOUS = {
    "rate-dependent",
    "drift",
    "mixed-loop",
    "few-loops",
    "small-test",
    "high-inverse-gain",
    "paper-bound",
    "recordings-differ",
    "swapped-columns",
    "output-stopped",
    "forward-better",
    "schedule-once",
}
FEW_LOOPS = {"few-loops", "never-turns"}
# And those that forbid compensation.
UNUSABLE = {"poor-fit", "static-as-good", "inverse-misses", "never-turns", "inverse-useless", "two-actuators"}
# Of these: whatever the inverse misses of this log, on the next motion it does harm.
HARMFUL = {"never-turns", "inverse-useless", "two-actuators"}


def examine(
    records: tuple[Recording, ...],
    data: DataSet,
    loop: facts.Orientation,
    counts: tuple[int, int],
    motion: facts.Motion,
    measured: Measured,
    certificate: Certificate,
    knows: Knows,
    *,
    paper: bool,
    held_out: bool,
) -> tuple[LoopFacts, tuple[Finding, ...]]:
    """Return what the data shows and every finding a user should know, those of reading the log first.

    `paper`: the bound is the paper's, in units of the log. `held_out`: something was to be held out.
    """
    change, doubt = measured.drift
    loop_facts = LoopFacts(
        orientation=loop.name,
        trend=data.trend,
        width_percent=100.0 * loop.width,
        loops=counts[0],
        turns=counts[1],
        drift_percent=-100.0 * change / data.output_range,
        motion=motion,
        evidence=measured.evidence,
    )
    judged = [*about_data(data, loop_facts, abs(change), doubt, knows)]
    judged += about_fit(records, data, measured, certificate, paper, held_out, knows, counts[1])
    # Reading sees the whole log, identification what of it is fitted: of too few loops the latter speaks.
    said = FEW_LOOPS if {finding.code for finding in judged} & FEW_LOOPS else set()
    read = [finding for record in records for finding in record.findings if finding.code not in said]
    found = [*read, *judged]
    unique = {(finding.code, finding.message): finding for finding in found}
    return loop_facts, tuple(unique.values())


def verdict(
    name: str,
    measured: Measured,
    findings: tuple[Finding, ...],
    tested: str,
    no_inverse: str = "",
) -> str:
    """The judgement in one line; `name` is the family and its size, `tested` says what was held out, if anything was.

    A compensator is good if its input error is: within 3 % of the input's range, and no worse than that of the curve's
    inverse. Within that bound only what does harm on the next motion forbids it.
    """
    test, codes = measured.test, {finding.code for finding in findings}
    judged, static = test or measured.train, measured.static_test or measured.static_train
    where = f"on {tested}" if test is not None else "on the fitted samples (none held out)"
    inverse, curve = measured.input_error.rms_percent, measured.curve_input.rms_percent
    against = sorted(codes & (SERIOUS | UNUSABLE))
    if inverse > GOOD_PERCENT:
        against.append(f"its inverse misses more than {GOOD_PERCENT:g} %")
    elif rank(inverse) > rank(curve):
        against.append(f"the inverse of a curve without hysteresis misses less, {of_range(curve)} range")
    if codes & HARMFUL or (codes & UNUSABLE and inverse > GOOD_PERCENT):
        grade = "do not compensate with it"
    elif judged.rmse_percent <= GOOD_PERCENT and test is not None and not against:
        grade = "good for compensation"
    else:
        reasons = reasons_of(judged, test is not None, against)
        grade = "usable with care" + (f" ({reasons})" if reasons else "")
    if no_inverse:
        return (
            f"{name}: {judged.rmse_percent:.2f} % of range rms {where}, against {static.rmse_percent:.2f} % for the "
            f"best curve without hysteresis; it has no inverse, {no_inverse.rstrip('.')}: do not compensate with it."
        )
    gives = f"gives the applied input back to {of_range(inverse)} its range"
    if name == STATIC:
        return (
            f"static, a curve without memory: {judged.rmse_percent:.2f} % of range rms {where}; its inverse {gives}"
            + ("; hysteresis was not found, or does not repeat" if "no-hysteresis" in codes else "")
            + f": {grade}."
        )
    return (
        f"{name}: {judged.rmse_percent:.2f} % of range rms {where}, against {static.rmse_percent:.2f} % for the best "
        f"curve without hysteresis; the inverse {gives}: {grade}."
    )


def reasons_of(judged: Score, held_out: bool, serious: list[str]) -> str:
    """Why a model is to be used with care."""
    error = [] if judged.rmse_percent <= GOOD_PERCENT else [f"more than {GOOD_PERCENT:g} % of range"]
    return ", ".join([*serious, *error, *([] if held_out else ["nothing held out"])])
