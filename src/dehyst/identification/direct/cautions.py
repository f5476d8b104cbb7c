"""Findings about a direct inverse, and its verdict."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dehyst.arrays import Array
from dehyst.findings import Finding
from dehyst.identification.cautions import POOR_PERCENT, no_held_out
from dehyst.identification.direct.columns import Shape
from dehyst.identification.direct.data import DirectData
from dehyst.identification.direct.fit import DirectCertificate, Rival
from dehyst.identification.direct.selection import FOLDS, WORTH, Trials
from dehyst.identification.direct.times import separable, words
from dehyst.identification.evidence import CREEP, TOLD, Evidence
from dehyst.identification.fit import Score
from dehyst.identification.judge import GOOD_PERCENT, reasons_of
from dehyst.identification.selection import STATIC_AS_GOOD
from dehyst.recording import Recording
from dehyst.ties import rank

BEYOND = 0.02
# A forward family is called better where its error is smaller by this share, and by this many standard errors of the
# direct inverse's error between blocks: less is chance.
FORWARD_MARGIN = 0.1
STANDARD_ERRORS = 2.0
# Findings that keep a small error from being called good.
SERIOUS_DIRECT = {
    "few-loops", "recordings-differ", "swapped-columns", "forward-better", "extrapolation", "drift", "schedule-once",
}  # fmt: skip
# Findings about data that hold whatever is identified from it.
OF_DATA = ("few-loops", "never-turns", "one-loop-size", "drift", "swapped-columns", "recordings-differ")


def about_terms(
    data: DirectData, shape: Shape, times: Array, asked: bool, trials: Trials, evidence: tuple[Evidence, ...]
) -> Iterator[Finding]:
    """Yield what limits creep and schedules."""
    low, high = separable(data)
    outside = [value for value in times if not 0.5 * low <= value <= 2.0 * high]
    if outside and asked:
        yield Finding(
            "creep-times-outside",
            f"time constants {words(outside)} lie outside what this log tells apart, {low:.3g} to {high:.3g} s (three "
            f"samples to a third of the fitted part): their weights are guesses. Log longer or faster, or use --creep "
            f"{max(1, times.size)}, which chooses within that range.",
        )
    if "creep" in shape.groups and times.size:
        found = next((each for each in evidence if each.group == CREEP), None)
        if found is not None and found.own < TOLD:
            yield Finding(
                "creep-without-holds",
                f"creep was fitted, but hysteresis imitates {100 - 100 * found.own:.0f} % of its course in this log: "
                f"the split between the two is arbitrary, and wrong at other speeds. Log with holds after reversals "
                f"and at different speeds; `dehyst design` plans them.",
            )
        if asked and found is not None and not found.there:
            yield Finding(
                "creep-no-gain",
                f"creep was asked for, but does not lower the error on held-out blocks ({found.figures}, p = "
                f"{found.p:.2g}). Leave it out (--creep 0), or log with holds.",
            )
    yield from _about_schedules(data, shape, trials)


def _about_schedules(data: DirectData, shape: Shape, trials: Trials) -> Iterator[Finding]:
    if not data.given:
        return
    once = [f"'{given.name}'" for k, given in enumerate(data.given) if _once(data, k)]
    if once:
        yield Finding(
            "schedule-once",
            f"{' and '.join(once)} leaves half of its range in one stretch of the fitted part only: what it changes is "
            f"learnt there alone, and held-out blocks cannot judge it. Log every value of it several times, or a run "
            f"under each (repeat --run, or name several logs), or fit a larger part (--train-fraction).",
        )
        return
    with_it, without_it = trials.schedules_worth(shape)
    if with_it < (1.0 - WORTH) * without_it:
        return
    names = " and ".join(f"'{given.name}'" for given in data.given)
    yield Finding(
        "schedule-no-gain",
        f"weights that depend on {names} do not lower the error on held-out blocks (rms {with_it / without_it:.2f} "
        f"times that without). It changes too little in this log, or does not matter: leave it out, or log more "
        "values of it.",
    )


def _once(data: DirectData, k: int) -> bool:
    """Whether without one of the folds a given schedule keeps to half of its range."""
    shares = np.concatenate([piece.given[k][piece.mask(True)] for piece in data.pieces])
    folds = np.array_split(np.arange(shares.size), FOLDS)
    return any(float(np.ptp(np.delete(shares, fold))) < 0.5 for fold in folds)


def about_direct_fit(
    records: tuple[Recording, ...],
    data: DirectData,
    judged: Score,
    static: Score,
    rivals: tuple[Rival, ...],
    certificate: DirectCertificate,
    nothing_held_out: bool,
    uncertainty_percent: float,
    turns: bool,
) -> Iterator[Finding]:
    """Yield what limits the whole fit.

    `uncertainty_percent` is the standard error of the input's error from its scatter between blocks; where the
    output never `turns`, there is no loop that a curve could be as good on.
    """
    masked = sum(piece.known for piece in data.pieces if piece.after_break)
    if masked:
        yield Finding(
            "unknown-memory",
            f"{masked} samples after gaps do not count: until both extremes of the output were visited again, the "
            f"input depends on what happened within the gap. Log without gaps, or begin each piece with a full loop.",
        )
    beyond = _beyond(data)
    if beyond > BEYOND:
        yield Finding(
            "extrapolation",
            f"the held-out output leaves the range that was fitted by {100 * beyond:.0f} %: polynomials are held "
            f"there, and the test measures extrapolation. Fit a part that covers the whole range (--train-fraction, "
            f"--from, --to).",
        )
    if turns and judged.rmse > STATIC_AS_GOOD * static.rmse:
        yield Finding(
            "static-as-good",
            f"a curve without memory is as good: it misses the input by {static.rmse_percent:.2f} % of its range, the "
            f"model by {judged.rmse_percent:.2f} %. Either there is no hysteresis at this scale, or the loop is of a "
            f"kind this model cannot show; a clockwise one (force against displacement) is.",
        )
    if judged.rmse_percent > POOR_PERCENT:
        yield Finding(
            "poor-fit",
            f"the model misses the applied input by {judged.rmse_percent:.1f} % of its range: too much for "
            f"compensation. See the other warnings for the reason.",
        )
    best = min(rivals, key=lambda rival: rank(rival.inverse_percent), default=None)
    margin = max(FORWARD_MARGIN * judged.rmse_percent, STANDARD_ERRORS * uncertainty_percent)
    if best is not None and best.inverse_percent < judged.rmse_percent - margin:
        yield Finding(
            "forward-better",
            f"the inverse of the forward family '{best.family}' misses the applied input by {best.inverse_percent:.2f} "
            f"% of its range on the same samples, the direct inverse by {judged.rmse_percent:.2f} %. Identify with "
            f"--family {best.family} instead, or log more loops: the direct inverse has more to learn.",
        )
    if not certificate.rises:
        yield Finding(
            "slope-not-guaranteed",
            "the weights change with the output, and more than the curve rises: after some past the input may fall "
            "while the output rises. A compensator that plays it forward stays bounded, but it has no unique output "
            "for an input there, and learned scales are not guaranteed to stay invertible. Where that matters, "
            "identify with --no-position-schedule.",
        )
    if nothing_held_out:
        yield no_held_out()


def _beyond(data: DirectData) -> float:
    """How far the held-out output leaves [-1, 1], share of the range."""
    farthest = [float(np.max(np.abs(p.y[m]))) for p in data.pieces if (m := p.mask(False)).any()]
    return 0.5 * max(0.0, max(farthest, default=1.0) - 1.0)


def direct_verdict(
    judged: Score,
    forward: Score,
    static: Score,
    rivals: tuple[Rival, ...],
    certificate: DirectCertificate,
    tested: str | None,
    findings: tuple[Finding, ...],
) -> str:
    """The judgement in one line; `tested` says what was held out, None if nothing was."""
    codes = {finding.code for finding in findings}
    serious = sorted(codes & SERIOUS_DIRECT)
    if codes & {"poor-fit", "static-as-good", "never-turns"}:
        grade = "do not compensate with it"
    elif judged.rmse_percent <= GOOD_PERCENT and tested and not serious:
        grade = "good for compensation"
    else:
        reasons = reasons_of(judged, bool(tested), serious)
        grade = "usable with care" + (f" ({reasons})" if reasons else "")
    where = f"on {tested}" if tested else "on the fitted samples (none held out)"
    best = min(rivals, key=lambda rival: rank(rival.inverse_percent), default=None)
    against = f", {best.inverse_percent:.2f} % for the best forward family ({best.family})" if best else ""
    return (
        f"direct-inverse, {certificate.nonzero_weights} of {certificate.terms} terms: asks for the applied input to "
        f"{judged.rmse_percent:.2f} % of its range rms {where}, against {static.rmse_percent:.2f} % for the best curve "
        f"without memory{against}; read forward, {forward.rmse_percent:.2f} % of the output's range: {grade}."
    )


def findings_of_data(findings: tuple[Finding, ...]) -> list[Finding]:
    """Those findings of a forward fit that are about the data."""
    return [finding for finding in findings if finding.code in OF_DATA]
