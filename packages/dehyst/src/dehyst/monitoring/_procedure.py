"""drift(): tests whether the actuator has changed since its model was identified."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from dehyst.arrays import Array
from dehyst.data import Recording, refuse_repeated, require_recordings
from dehyst.errors import DehystError, ParameterError
from dehyst.findings import Finding
from dehyst.identification import ENDED, Fit, identify, mended
from dehyst.models import Model, ModelCard, model_to_dict
from dehyst.models import kit as models_kit
from dehyst.monitoring._groups import contrast, groups_of, rms, samples_of_cycles
from dehyst.monitoring._logs import (
    MOST_GROUPS,
    Log,
    logged_motion,
    moved_alike,
    now_of,
    open_log,
    own_error,
    reference_log,
    say_what_is_beyond,
    say_what_limits,
    scale_of,
    unexplained,
    with_model,
)
from dehyst.monitoring._parts import (
    DIRECT,
    ELEMENTS,
    ERROR,
    PARTS,
    REST,
    Estimates,
    JudgedModel,
    Parted,
    Scale,
    distinct_parts,
    estimate,
    fit_steps,
    predict_parts,
)
from dehyst.monitoring._policy import POLICY
from dehyst.monitoring._result import (
    DRIFTED,
    NOT_COMPARABLE,
    Acceptance,
    Drift,
    LogDrift,
    no_refit,
    status_of_all,
    verdict_of,
)
from dehyst.monitoring._testing import (
    Rule,
    changes_of,
    percents,
    scored_blocks,
    status_of,
    trends_of,
)

# Groups of held-out cycles in which two models are compared.
MOST_PAIRS = 16
FEWEST_PAIRS = 4
# Settings of the paper, for a model whose card names none.
OPERATORS = 100
EPS = 0.001
CUMULATIVE = ("pi", "pi-cumulative")
# What of a card's provenance tells how good the model is, on cycles that were held out.
JUDGED = ("test", "inverse", "verdict", "grade")


def accept(subject: JudgedModel, logs: Sequence[Log], scale: Scale) -> Acceptance:
    """Identify the family of a model anew on the first half of each log and compare both on the other half.

    What is accepted is identified once more, from the whole of each log; what it is worth was told by the half.

    Both models run over the logs in the same way, from a past of their whole range. Their errors are squared, averaged
    over groups of held-out cycles and compared group by group.
    """
    if not logs:
        return Acceptance(
            False, "no log is comparable, so nothing was identified; the old model stays"
        )
    try:
        fit = _identified(subject.model, logs, POLICY.refit_share)
        pairs = _pairs(JudgedModel.of(fit.model), logs)
    except DehystError as fault:
        return Acceptance(False, f"no new model could be identified; the old one stays ({fault})")
    if len(pairs) < FEWEST_PAIRS:
        return Acceptance(
            False,
            f"only {len(pairs)} cycles are held out, {FEWEST_PAIRS} are needed to compare two models; the old one "
            f"stays. Log more cycles.",
            fit.model,
            groups=len(pairs),
        )
    decision = _decide(fit.model, np.array(pairs), scale)
    if not decision.accepted:
        return decision
    # The half has shown that the family fits; the model to run may learn from all samples.
    try:
        whole = _identified(subject.model, logs, 1.0).model
    except DehystError as fault:
        reason = f"{decision.reason}, but not by all of the log ({fault})"
        return replace(decision, accepted=False, reason=reason)
    return replace(decision, model=_signed(whole, fit.model, subject.model, decision.reason))


def _identified(model: Parted, logs: Sequence[Log], share: float) -> Fit:
    """Fit the first part of each log with the settings of a model; hostile ones are refused by the identification."""
    records = [log.record for log in logs]
    settings: Any = model.card.provenance.get("settings")
    if not isinstance(settings, dict):
        settings = {}
    if model.core == DIRECT:
        times = settings.get("creep_times") or None
        return identify(records, model.family, creep_times=times, train_fraction=share)
    if model.core == ELEMENTS:
        return identify(records, model.family, train_fraction=share, size=settings.get("size"))
    # What is saved as one family may have been identified as another, whose weights mean the same.
    families = {"pi": CUMULATIVE, "sheared-pi": CUMULATIVE}.get(model.family, (model.family,))
    family = model.card.provenance.get("identified_family")
    if not isinstance(family, str) or family not in families:
        family = families[0]
    n, eps = settings.get("n", OPERATORS), settings.get("eps", EPS)
    if settings.get("eps_by") or (family == "pi" and settings.get("family", family) != "pi"):
        # Chosen again: the bound of a family that `auto` chose is relative, and that of "pi" is not.
        eps = "auto"
    bound = {"eps": eps}
    limit = settings.get("max_inverse_gain")
    if limit is not None:
        bound = {"max_inverse_gain": limit}  # which sets eps
    fit: Fit = identify(records, family, n=n, train_fraction=share, shear=model.shear, **bound)
    return fit


def _pairs(renewed: JudgedModel, logs: Sequence[Log]) -> list[tuple[float, float]]:
    """Mean squared errors of the old and the new model in each group of held-out cycles."""
    pairs = []
    share = max(1, MOST_PAIRS // len(logs))
    for log in logs:
        split = int(POLICY.refit_share * len(log.record))
        # A cycle that begins before the split was fitted in part.
        test_cycles = [cycle for cycle in log.cycles if cycle.begin >= split]
        if log.measured is None or not test_cycles:
            continue
        response = predict_parts(renewed, log.record).response
        old_square = log.measured.error**2
        new_square = (log.measured.response - response) ** 2
        for group in groups_of(test_cycles, share):
            place = samples_of_cycles(group)
            pairs.append((float(np.mean(old_square[place])), float(np.mean(new_square[place]))))
    return pairs


def _decide(new_model: Parted, pairs: Array, scale: Scale) -> Acceptance:
    """Decide by the mean squared errors of the old and the new model, (q, 2), whether the new one is better."""
    # Squares of small units may be too small for the test's own squares.
    largest = max(float(np.max(pairs)), 1e-300)
    p_value = contrast((pairs[:, 0] - pairs[:, 1]) / largest).p_value(0.0, sided=1)
    old = 100.0 * float(np.sqrt(np.mean(pairs[:, 0]))) / scale.span
    new = 100.0 * float(np.sqrt(np.mean(pairs[:, 1]))) / scale.span
    is_worth_it = new < (1.0 - POLICY.refit_worth) * old
    numbers = (
        f"on {len(pairs)} groups of held-out cycles the new model errs by {new:.3g} % of range rms and the old one by "
        f"{old:.3g} % (p = {p_value:.2g})"
    )
    if is_worth_it and p_value < POLICY.refit_level:
        reason = f"{numbers}: the new model is accepted"
        return Acceptance(True, reason, new_model, old, new, p_value, len(pairs))
    rule = f"accepted are gains of more than {100 * POLICY.refit_worth:g} % with p < {POLICY.refit_level:g}"
    if is_worth_it:
        rule += ". So few cycles, or so different ones, do not confirm it: log more (dehyst design --for drift)"
    reason = f"{numbers}: the old model stays; {rule}"
    return Acceptance(False, reason, new_model, old, new, p_value, len(pairs))


def _signed(new: Parted, judged: Parted, old: Parted, reason: str) -> Parted:
    """The new model, with what its family was judged by, what it replaces and why in its provenance."""
    provenance = dict(new.card.provenance)
    for key in JUDGED:
        if key in provenance:
            provenance[key] = judged.card.provenance[key]
    provenance["replaces"] = {"sha256": model_to_dict(old)["sha256"], "reason": reason}
    card: ModelCard = replace(new.card, provenance=provenance)
    return new.with_card(card)


Steps: TypeAlias = tuple[tuple[str, ...], ...]

FALSE_ALARM = 0.01
# Tests on few groups of cycles keep their promise up to this level.
HIGHEST_FALSE_ALARM = 0.08
REFERENCE = "reference"
SHOWN_CYCLES = 3


def drift(
    model: Model,
    recordings: Recording | Sequence[Recording],
    *,
    reference: Recording | None = None,
    false_alarm: float = FALSE_ALARM,
    least: float | None = None,
    ignore: Sequence[str] = (),
    refit: bool = False,
) -> Drift:
    """Tell whether an actuator has changed since its model was identified, in which part, and since when.

    The model runs over each log; its error is fitted by a shift, a change of the whole, of the size of the loop, of
    the curve and of creep, separately in groups of cycles, and the scatter between groups decides what is a change and
    what is noise. In a log of 48 cycles or more the last quarter counts as now.

    An actuator is called unchanged only if every change that does 1 % of range (rms) would have been found nine times
    in ten, and if the error has not doubled, nor may have within its 95 % interval. Otherwise a log that shows no
    change gets the answer "cannot tell". A log in which the output stops, or is another one at the same input from some
    cycle to its end, is called drifted for that alone.

    Parameters
    ----------
    model
        The model, as identified: its card names units and ranges.
    recordings
        New logs, in their order in time.
    reference
        Log of the actuator when it was new, with the same motion. By default a log that the model was identified from,
        if it is among the recordings; else changes are measured from the model, and what may be its own error is no
        change.
    false_alarm
        Probability of calling an actuator drifted that has not changed, over all logs and parts together.
    least
        Smallest change worth a word: RMS of what it does, percent of the response's range. By default 0.1 with a
        reference that was moved alike; without one at least the error that the card names (half of it for the offset),
        because a model's own error may look like a change. "Unchanged" asks that twice as much would have been found,
        if that is more than 1.
    ignore
        Parts whose change does not count, "offset" for a sensor that is zeroed at every start.
    refit
        Whether to identify the family anew where the actuator has drifted: on the first half of each log since, to be
        accepted if it is better on the other half, and then on all of them.

    Returns
    -------
    drift : Drift
        Verdict, changes with intervals, scores over the cycles, trends, and the model to use from now on.

    Raises
    ------
    ParameterError
        If a setting lies outside what its formula allows, there is no recording, or the model is of another kind.

    Examples
    --------
    >>> import numpy as np, dehyst
    >>> x = np.sin(np.linspace(0, 40 * np.pi, 4001))
    >>> model = dehyst.PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0])
    >>> later = dehyst.Recording(input=x, output=model.simulate(x) + 0.1)
    >>> dehyst.drift(model, later).verdict[:32]
    'drifted (against the model): off'
    """
    if not getattr(model, "core", ""):
        raise ParameterError(
            f"model is a {type(model).__name__}, which cannot be taken apart into loop, curve and creep. drift() takes "
            f"plays, sums of elements and direct inverses: identify one from the same log, dehyst.identify(log)."
        )
    records = require_recordings(recordings)
    refuse_repeated(records)
    records = tuple(mended(record, cut=False) for record in records)
    rate = _checked(false_alarm, least, ignore)
    findings: list[Finding] = []
    subject = JudgedModel.of(model)
    if reference is not None:
        reference = mended(reference)
    base_log = reference_log(subject, reference, findings)
    has_reference = len(records) + (reference is not None) > 1
    logs = [open_log(subject, record, has_reference, findings) for record in records]
    if base_log is not None and base_log.why_not:
        findings.append(
            Finding(
                "drift-reference",
                f"the reference {base_log.record.name} is not comparable: {base_log.why_not}. Changes were measured "
                f"from the model itself.",
            )
        )
        base_log = None
    if base_log is None:
        # A log that the model was identified from shows the actuator when it was new.
        base_log = next((log for log in logs if log.reference and not log.why_not), None)
    return _judge(subject, logs, base_log, rate, least, tuple(ignore), refit, findings)


def _checked(false_alarm: float, least: float | None, ignore: Sequence[str]) -> float:
    """Refuse settings outside what their formula allows; return the false alarm rate."""
    rate = models_kit.parameter_number(false_alarm, "false_alarm")
    if not 0.0 < rate <= HIGHEST_FALSE_ALARM:
        raise ParameterError(
            f"false_alarm = {rate:g} must lie above 0 and not above {HIGHEST_FALSE_ALARM:g}: tests on few groups of "
            f"cycles keep their promise up to there. 0.01 is one false alarm in a hundred calls.",
            false_alarm=rate,
        )
    if least is not None and not 0.0 <= models_kit.parameter_number(least, "least") <= 100.0:
        raise ParameterError(
            f"least = {least:g} must lie between 0 and 100, percent of range.", least=least
        )
    if isinstance(ignore, str) or not {*PARTS, REST}.issuperset(ignore):
        raise ParameterError(
            f"ignore = {ignore!r} names no part; parts are {', '.join((*PARTS, REST))}. "
            f"Write ignore=['offset'], or --ignore offset."
        )
    return rate


def _judge(
    subject: JudgedModel,
    logs: list[Log],
    base_log: Log | None,
    rate: float,
    least: float | None,
    ignore: tuple[str, ...],
    refit: bool,
    findings: list[Finding],
) -> Drift:
    """Fit, test and put into words."""
    scale = Scale((0.0, 1.0), (0.0, 1.0), None)
    steps: Steps = ()
    # Where every log was refused there is nothing that a scale could be taken from.
    if any(not log.why_not for log in logs):
        # One scale and the same parts for all logs: changes of different logs can then be compared.
        scale = scale_of(subject, logs, base_log)
        logs = [with_model(subject, log, scale) for log in logs]
        if base_log is not None:
            base_log = with_model(subject, base_log, scale)
        steps = _steps(logs, base_log)
        logs = [_explained(log, steps) for log in logs]
    distinct = tuple(itertools.chain(*steps))
    before = base_name = None
    against = "against the model"
    own_percent = own_error(subject.model)
    if base_log is not None and base_log.measured is not None:
        groups = groups_of(base_log.reference, MOST_GROUPS)
        before = estimate(base_log.measured, groups, steps, ignore)
        own_percent = 100.0 * rms(before.error) / scale.span
        base_name = base_log.record.name
        against = f"against {base_name}"
    tested = _tested(logs)
    # A rest that may grow makes the error grow.
    ignored = ignore
    if REST in ignore:
        ignored = (*ignore, ERROR)
    # The false alarms of a call are shared by its tests: each part of each log, and its rest and error.
    level = rate / max(1, len(tested) * (len(distinct) + 2))
    rule = Rule(level, least, own_percent, ignored)
    entries: list[LogDrift] = []
    first = 0
    for log in logs:
        entries.append(_entry(subject, log, base_log, before, steps, scale, rule, first, findings))
        first += len(log.cycles) + len(log.reference)
    say_what_limits(subject, tested, distinct, before, own_percent, scale, findings)
    status = status_of_all(entries)
    # Without a tested log nobody knows which motion would tell.
    motion: dict[str, Any] = {}
    if tested:
        motion = logged_motion(subject, scale)
    result = Drift(
        status=status,
        verdict=verdict_of(status, entries, own_percent, against, subject.backward),
        model=subject.model,
        logs=tuple(entries),
        identified_percent=own_percent,
        reference=base_name,
        trends=trends_of(entries, rate),
        findings=tuple(findings),
        settings={
            "false_alarm": rate,
            "least": least,
            "ignore": list(ignore),
            "level": level,
            "refit": refit,
        },
        motion=motion,
    )
    if refit:
        return _refitted(result, subject, logs, scale)
    return result


def _tested(logs: Sequence[Log]) -> list[Log]:
    """Logs that can be compared and have cycles of their own."""
    return [log for log in logs if not log.why_not and log.cycles]


def _refitted(result: Drift, subject: JudgedModel, logs: Sequence[Log], scale: Scale) -> Drift:
    """Identify the model anew from the logs since the actuator has drifted, and take it if it is better."""
    if result.status != DRIFTED:
        return replace(result, acceptance=Acceptance(False, no_refit(result.status)))
    statuses = [entry.status for entry in result.logs]
    decision = accept(subject, _tested(logs[statuses.index(DRIFTED) :]), scale)
    if decision.accepted and decision.model is not None:
        result = replace(result, model=decision.model)
    return replace(result, acceptance=decision)


def _steps(logs: Sequence[Log], base_log: Log | None) -> Steps:
    """Parts that every comparable log, and the reference, can tell apart, by the step in which they are fitted."""
    everything = []
    for log in logs:
        everything.append((log.measured, now_of(log.cycles)))
    if base_log is not None:
        everything.append((base_log.measured, base_log.reference))
    # A part stays only if each log tells it apart: what one log gives to it another would give to its neighbour.
    steps = fit_steps(PARTS, base_log is not None)
    for measured, cycles in everything:
        if measured is None or not cycles:
            continue
        groups = groups_of(cycles, MOST_GROUPS)
        remaining = []
        for step in steps:
            offered = list(filter(measured.columns.__contains__, step))
            remaining.append(distinct_parts(measured, groups, offered))
        steps = tuple(remaining)
    return steps


def _explained(log: Log, steps: Steps) -> Log:
    """Refuse a log that has nothing to do with the model."""
    if log.measured is None or not log.cycles:
        return log
    groups = groups_of(now_of(log.cycles), MOST_GROUPS)
    fitted = estimate(log.measured, groups, steps)
    place = samples_of_cycles(tuple(itertools.chain(*groups)))
    return replace(log, why_not=unexplained(fitted.remainder, log.measured.response[place]))


def _entry(
    subject: JudgedModel,
    log: Log,
    base_log: Log | None,
    before: Estimates | None,
    steps: Steps,
    scale: Scale,
    rule: Rule,
    first: int,
    findings: list[Finding],
) -> LogDrift:
    """Test one log; `first` is the number of cycles in the logs before it."""
    name = log.record.name
    if log.measured is None or log.why_not:
        return LogDrift(log.record, NOT_COMPARABLE, log.why_not, name, len(log.cycles))
    everything = (*log.reference, *log.cycles)
    tested = now_of(log.cycles)
    shown = (tested or everything)[-SHOWN_CYCLES:]
    entry = LogDrift(
        log.record,
        REFERENCE,
        name=name,
        cycles=len(everything),
        tested=len(tested),
        blocks=scored_blocks(log.measured, everything, steps, scale, first, log.reference),
        response=log.measured.prediction.response,
        shown=(shown[0].begin, shown[-1].end),
    )
    if not tested:
        now = estimate(log.measured, groups_of(log.reference, MOST_GROUPS), steps)
        error, inverse = percents(now, scale)
        return replace(entry, error_percent=error, inverse_percent=inverse)
    say_what_is_beyond(subject, log, tested, findings)
    now = estimate(log.measured, groups_of(tested, MOST_GROUPS), steps, rule.ignored)
    error, inverse = percents(now, scale)
    alike = base_log is not None and moved_alike(log, base_log, findings)
    changes = changes_of(now, before, alike, scale, rule, subject.response.unit or "")
    status = status_of(changes, 100.0 * rms(now.counted) / scale.span, rule)
    if any(finding.code in ENDED for finding in log.record.findings):
        # What ends within a log scatters between its cycles, which hides its changes.
        status = DRIFTED
    return replace(
        entry,
        status=status,
        error_percent=error,
        inverse_percent=inverse,
        changes=tuple(changes),
    )
