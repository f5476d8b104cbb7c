"""drift(): tests whether the actuator has changed since its model was identified."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data.recording import Recording, require_recordings, takes_recordings
from dehyst.data.repeats import refuse_repeated
from dehyst.errors import DehystError, ParameterError
from dehyst.families import identify
from dehyst.findings import Finding
from dehyst.identification.direct.data import check_given
from dehyst.identification.direct.procedure import identify_direct
from dehyst.identification.fit import Fit
from dehyst.identification.mending import ENDED, mended
from dehyst.identification.plays import identify as identify_plays
from dehyst.identification.settings import AUTO
from dehyst.identification.split import end_of
from dehyst.models import Model, ModelCard
from dehyst.models.arrays import parameter_number
from dehyst.models.storage import model_to_dict
from dehyst.monitoring.groups import contrast, groups_of, rms, samples_of
from dehyst.monitoring.logs import (
    MOST_GROUPS,
    Log,
    motion_of,
    moved_alike,
    now_of,
    opened,
    own_error,
    reference_log,
    say_what_is_beyond,
    say_what_limits,
    scale_of,
    unexplained,
    with_model,
)
from dehyst.monitoring.parts import (
    DIRECT,
    ELEMENTS,
    ERROR,
    PARTS,
    REST,
    Estimates,
    Parted,
    Scale,
    Subject,
    distinct_parts,
    estimate,
    predict,
    steps_of,
)
from dehyst.monitoring.result import (
    DRIFTED,
    NOT_COMPARABLE,
    Acceptance,
    Change,
    Drift,
    LogDrift,
    no_refit,
    status_of_all,
    verdict_of,
)
from dehyst.monitoring.testing import Rule, blocks_of, changes_of, percents, status_of, trends_of

# Share of each log that the new model is fitted to.
FITTED = 0.5
# Probability of accepting a model that is no better, and the gain without which a change is not worth it.
LEVEL, WORTH = 0.01, 0.1
MOST_PAIRS, FEWEST_PAIRS = 16, 4
OPERATORS, EPS = 100, 0.001
CUMULATIVE = ("pi", "pi-cumulative")
# What of a card's provenance tells how good the model is, on cycles that were held out.
JUDGED = ("test", "inverse", "verdict")


def accept(subject: Subject, logs: Sequence[Log], scale: Scale) -> Acceptance:
    """Identify the family of a model anew on the first half of each log and compare both on the other half.

    What is accepted is identified once more, from the whole of each log; what it is worth was told by the half.

    Both models run over the logs in the same way, from a past of their whole range. Their errors are squared, averaged
    over groups of held-out cycles and compared group by group.
    """
    if not logs:
        return Acceptance(False, "no log is comparable, so nothing was identified; the old model stays")
    try:
        fit = _identified(subject.model, logs, FITTED)
        pairs = _pairs(Subject.of(fit.model), logs)
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
    try:
        whole = _identified(subject.model, logs, 1.0).model
    except DehystError as fault:
        return replace(decision, accepted=False, reason=f"{decision.reason}, but not by all of the log ({fault})")
    return replace(decision, model=_signed(whole, fit.model, subject.model, decision.reason))


def _identified(model: Parted, logs: Sequence[Log], share: float) -> Fit:
    """Fit the first part of each log with the settings of a model; hostile ones are refused by the identification."""
    records = [log.record for log in logs]
    listed = model.card.provenance.get("settings")
    settings: dict[str, Any] = listed if isinstance(listed, dict) else {}
    if model.core == DIRECT:
        known_signals = [name for name in model.needs if name in ("load", "mean_pressure")]
        signals: dict[str, Any] = {name: [log.given[name] for log in logs] for name in known_signals}
        times = settings.get("creep_times") or None
        return identify_direct(records, creep_times=times, train_fraction=share, **signals)
    if model.core == ELEMENTS:
        return identify(records, model.family, train_fraction=share)
    family = model.card.provenance.get("identified_family")
    kinds = {"pi": CUMULATIVE, "sheared-pi": CUMULATIVE}.get(model.family, (model.family,))
    known = family if isinstance(family, str) and family in kinds else kinds[0]
    n, eps = settings.get("n", OPERATORS), settings.get("eps", EPS)
    if settings.get("eps_by") or (known == "pi" and settings.get("family", known) != "pi"):
        eps = AUTO  # chosen again; the bound of a family that `auto` chose is relative, and that of "pi" is not
    limit = settings.get("max_inverse_gain")
    bound = {"eps": eps} if limit is None else {"max_inverse_gain": limit}  # which sets eps
    return identify_plays(records, known, n=n, train_fraction=share, shear=model.shear, **bound)


def _pairs(renewed: Subject, logs: Sequence[Log]) -> list[tuple[float, float]]:
    """Mean squared errors of the old and the new model in each group of held-out cycles."""
    found = []
    share = max(1, MOST_PAIRS // len(logs))
    for log in logs:
        split = end_of(len(log.record), FITTED)
        held = [cycle for cycle in log.cycles if cycle.begin >= split]
        if log.measured is None or not held:
            continue
        missed = log.measured.response - predict(renewed, log.record, log.given).response
        for group in groups_of(held, share):
            place = samples_of(group)
            found.append((float(np.mean(log.measured.error[place] ** 2)), float(np.mean(missed[place] ** 2))))
    return found


def _decide(new_model: Parted, pairs: Array, scale: Scale) -> Acceptance:
    tested = contrast((pairs[:, 0] - pairs[:, 1]) / max(float(np.max(pairs)), 1e-300))  # of any size
    old, new = (100.0 * float(np.sqrt(np.mean(pairs[:, k]))) / scale.span for k in (0, 1))
    p_value = tested.p_value(0.0, sided=1)
    better = p_value < LEVEL and new < (1.0 - WORTH) * old
    numbers = (
        f"on {len(pairs)} groups of held-out cycles the new model errs by {new:.3g} % of range rms and the old one by "
        f"{old:.3g} % (p = {p_value:.2g})"
    )
    rule = f"accepted are gains of more than {100 * WORTH:g} % with p < {LEVEL:g}"
    if new < (1.0 - WORTH) * old:
        rule += ". So few cycles, or so different ones, do not confirm it: log more (dehyst design --for drift)"
    reason = f"{numbers}: the new model is accepted" if better else f"{numbers}: the old model stays; {rule}"
    return Acceptance(better, reason, new_model, old, new, p_value, len(pairs))


def _signed(new: Parted, judged: Parted, old: Parted, reason: str) -> Parted:
    """The new model, with what its family was judged by, what it replaces and why in its provenance."""
    provenance = dict(new.card.provenance)
    provenance |= {key: judged.card.provenance[key] for key in JUDGED if key in provenance}
    provenance["replaces"] = {"sha256": model_to_dict(old)["sha256"], "reason": reason}
    card: ModelCard = replace(new.card, provenance=provenance)
    return new.with_card(card)


Steps: TypeAlias = tuple[tuple[str, ...], ...]
Signals: TypeAlias = npt.ArrayLike | Sequence[npt.ArrayLike] | None

FALSE_ALARM, HIGHEST_FALSE_ALARM = 0.01, 0.08
REFERENCE = "reference"
SHOWN_CYCLES = 3


@takes_recordings
def drift(
    model: Model,
    recordings: Recording | Sequence[Recording],
    *,
    reference: Recording | None = None,
    false_alarm: float = FALSE_ALARM,
    least: float | None = None,
    ignore: Sequence[str] = (),
    refit: bool = False,
    load: Signals = None,
    mean_pressure: Signals = None,
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
    load, mean_pressure
        Signals that the weights of a direct inverse may depend on: an array (T,) for each recording, and one more for
        the reference if there is one.

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
    rate = parameter_number(false_alarm, "false_alarm")
    if not 0.0 < rate <= HIGHEST_FALSE_ALARM:
        raise ParameterError(
            f"false_alarm = {rate:g} must lie above 0 and not above {HIGHEST_FALSE_ALARM:g}: tests on few groups of "
            f"cycles keep their promise up to there. 0.01 is one false alarm in a hundred calls.",
            false_alarm=rate,
        )
    if least is not None and not 0.0 <= parameter_number(least, "least") <= 100.0:
        raise ParameterError(f"least = {least:g} must lie between 0 and 100, percent of range.", least=least)
    unknown = [part for part in ignore if part not in (*PARTS, REST)]
    if unknown or isinstance(ignore, str):
        raise ParameterError(
            f"ignore = {ignore!r} names no part; parts are {', '.join((*PARTS, REST))}. "
            f"Write ignore=['offset'], or --ignore offset."
        )
    findings: list[Finding] = []
    subject = Subject.of(model)
    reference = None if reference is None else mended(reference)
    given = _given([*records, *([] if reference is None else [reference])], load=load, mean_pressure=mean_pressure)
    known = reference_log(subject, reference, given[-1], findings)
    others = len(records) > 1 or reference is not None
    logs = [opened(subject, record, held, others, findings) for record, held in zip(records, given, strict=False)]
    if known is not None and known.why_not:
        findings.append(
            Finding(
                "drift-reference",
                f"the reference {known.record.name} is not comparable: {known.why_not}. Changes were measured from the "
                f"model itself.",
            )
        )
        known = None
    if known is None:
        known = next((log for log in logs if log.reference and not log.why_not), None)
    return _judge(subject, logs, known, rate, least, tuple(ignore), refit, findings)


def _given(records: Sequence[Recording], **signals: Signals) -> list[dict[str, Array]]:
    """Scheduling signals of each recording by name."""
    given: list[dict[str, Array]] = [{} for _ in records]
    for name, values in signals.items():
        if values is not None:
            for held, array in zip(given, check_given(name, values, records), strict=True):
                held[name] = array
    return given


def _judge(
    subject: Subject,
    logs: list[Log],
    known: Log | None,
    rate: float,
    least: float | None,
    ignore: tuple[str, ...],
    refit: bool,
    findings: list[Finding],
) -> Drift:
    """Fit, test and put into words."""
    if any(not log.why_not for log in logs):
        scale = scale_of(subject, logs, known)
        logs = [with_model(subject, log, scale) for log in logs]
        known = None if known is None else with_model(subject, known, scale)
        steps = _steps(logs, known)
        logs = [_explained(log, steps) for log in logs]
    else:
        scale, steps = Scale((0.0, 1.0), (0.0, 1.0), None), ()
    told = tuple(part for step in steps for part in step)
    before = None
    if known is not None and known.measured is not None:
        before = estimate(known.measured, groups_of(known.reference, MOST_GROUPS), steps, ignore)
    tested = [log for log in logs if not log.why_not and log.cycles]
    own = own_error(subject.model) if before is None else 100.0 * rms(before.error) / scale.span
    # A rest that may grow makes the error grow.
    ignored = (*ignore, ERROR) if REST in ignore else ignore
    rule = Rule(rate / max(1, len(tested) * (len(told) + 2)), least, own, ignored)
    entries, first = [], 0
    for log in logs:
        entries.append(_entry(subject, log, known, before, steps, scale, rule, first, findings))
        first += len(log.cycles) + len(log.reference)
    say_what_limits(subject, tested, told, before, own, scale, findings)
    status = status_of_all(entries)
    named = None if known is None or before is None else known.record.name
    against = "against the model" if named is None else f"against {named}"
    result = Drift(
        status=status,
        verdict=verdict_of(status, entries, own, against, subject.backward),
        model=subject.model,
        logs=tuple(entries),
        identified_percent=own,
        reference=named,
        trends=trends_of(entries, rate),
        findings=tuple(findings),
        settings={"false_alarm": rate, "least": least, "ignore": list(ignore), "level": rule.level, "refit": refit},
        motion=motion_of(subject, scale) if tested else {},
    )
    if not refit:
        return result
    if status != DRIFTED:
        return replace(result, acceptance=Acceptance(False, no_refit(status)))
    since = next(k for k, entry in enumerate(entries) if entry.status == DRIFTED)
    chosen = [log for log in logs[since:] if not log.why_not and log.cycles]
    decision = accept(subject, chosen, scale)
    replaced = decision.model if decision.accepted else None
    return replace(result, acceptance=decision, model=subject.model if replaced is None else replaced)


def _steps(logs: Sequence[Log], known: Log | None) -> Steps:
    """Parts that every comparable log, and the reference, can tell apart, by the step in which they are fitted."""
    everything = [(log.measured, now_of(log.cycles)) for log in logs if log.cycles]
    if known is not None:
        everything.append((known.measured, known.reference))
    steps = steps_of(PARTS, known is not None)
    for measured, cycles in everything:
        if measured is not None and cycles:
            groups = groups_of(cycles, MOST_GROUPS)
            offered = [[part for part in step if part in measured.columns] for step in steps]
            steps = tuple(distinct_parts(measured, groups, step) for step in offered)
    return steps


def _explained(log: Log, steps: Steps) -> Log:
    """Refuse a log that has nothing to do with the model."""
    if log.measured is None or not log.cycles:
        return log
    groups = groups_of(now_of(log.cycles), MOST_GROUPS)
    found = estimate(log.measured, groups, steps)
    places = np.concatenate([np.arange(cycle.begin, cycle.end) for group in groups for cycle in group])
    return replace(log, why_not=unexplained(found.rest, log.measured.response[places]))


def _entry(
    subject: Subject,
    log: Log,
    known: Log | None,
    before: Estimates | None,
    steps: Steps,
    scale: Scale,
    rule: Rule,
    first: int,
    findings: list[Finding],
) -> LogDrift:
    if log.measured is None or log.why_not:
        return LogDrift(log.record, NOT_COMPARABLE, log.why_not, log.record.name, len(log.cycles))
    everything = (*log.reference, *log.cycles)
    blocks = blocks_of(log.measured, everything, steps, scale, first, log.reference)
    tested = now_of(log.cycles) if log.cycles else ()
    shown = (tested or everything)[-SHOWN_CYCLES:]
    where = shown[0].begin, shown[-1].end
    if not tested:
        now = estimate(log.measured, groups_of(log.reference, MOST_GROUPS), steps)
        return LogDrift(
            log.record, REFERENCE, "", log.record.name, len(everything), 0, *percents(now, scale), (), blocks,
            log.measured.prediction.response, where,
        )  # fmt: skip
    say_what_is_beyond(subject, log, tested, findings)
    now = estimate(log.measured, groups_of(tested, MOST_GROUPS), steps, rule.ignored)
    alike = known is not None and moved_alike(log, known, findings)
    unit = subject.response.unit or ""
    changes: list[Change] = changes_of(now, before, alike, scale, rule, unit)
    status = status_of(changes, 100.0 * rms(now.counted) / scale.span, rule)
    if any(finding.code in ENDED for finding in log.record.findings):  # whose scatter between cycles hides its changes
        status = DRIFTED
    return LogDrift(
        log.record, status, "", log.record.name, len(everything), len(tested), *percents(now, scale), tuple(changes),
        blocks, log.measured.prediction.response, where,
    )  # fmt: skip
