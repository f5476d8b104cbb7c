"""drift(): has the actuator changed since its model was identified?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data.recording import Recording, require_recordings, takes_recordings
from dehyst.errors import ParameterError
from dehyst.findings import Finding
from dehyst.identification.direct.data import check_given
from dehyst.identification.mending import mended
from dehyst.models import Model
from dehyst.models.arrays import parameter_number
from dehyst.monitoring import comparable, design, testing, words
from dehyst.monitoring.acceptance import accept
from dehyst.monitoring.cycles import groups_of
from dehyst.monitoring.design import Estimates, Scale
from dehyst.monitoring.limits import moved_alike, own_error, say_what_is_beyond, say_what_limits
from dehyst.monitoring.logs import (
    MOST_GROUPS,
    Log,
    motion_of,
    now_of,
    opened,
    reference_log,
    scale_of,
    with_model,
)
from dehyst.monitoring.parts import Subject
from dehyst.monitoring.result import DRIFTED, NOT_COMPARABLE, Acceptance, Change, Drift, LogDrift
from dehyst.monitoring.scoring import blocks_of, percents, trends_of
from dehyst.monitoring.statistics import rms

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
    change gets the answer "cannot tell".

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
    records = tuple(map(mended, require_recordings(recordings)))
    rate = parameter_number(false_alarm, "false_alarm")
    if not 0.0 < rate <= HIGHEST_FALSE_ALARM:
        raise ParameterError(
            f"false_alarm = {rate:g} must lie above 0 and not above {HIGHEST_FALSE_ALARM:g}: tests on few groups of "
            f"cycles keep their promise up to there. 0.01 is one false alarm in a hundred calls.",
            false_alarm=rate,
        )
    if least is not None and not 0.0 <= parameter_number(least, "least") <= 100.0:
        raise ParameterError(f"least = {least:g} must lie between 0 and 100, percent of range.", least=least)
    unknown = [part for part in ignore if part not in (*design.PARTS, design.REST)]
    if unknown or isinstance(ignore, str):
        raise ParameterError(
            f"ignore = {ignore!r} names no part; parts are {', '.join((*design.PARTS, design.REST))}. "
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
        before = design.estimate(known.measured, groups_of(known.reference, MOST_GROUPS), steps, ignore)
    tested = [log for log in logs if not log.why_not and log.cycles]
    own = own_error(subject.model) if before is None else 100.0 * rms(before.error) / scale.span
    # A rest that may grow makes the error grow.
    ignored = (*ignore, design.ERROR) if design.REST in ignore else ignore
    rule = testing.Rule(rate / max(1, len(tested) * (len(told) + 2)), least, own, ignored)
    entries, first = [], 0
    for log in logs:
        entries.append(_entry(subject, log, known, before, steps, scale, rule, first, findings))
        first += len(log.cycles) + len(log.reference)
    say_what_limits(subject, tested, told, before, own, scale, findings)
    status = words.status_of(entries)
    named = None if known is None or before is None else known.record.name
    against = "against the model" if named is None else f"against {named}"
    result = Drift(
        status=status,
        verdict=words.verdict_of(status, entries, own, against, subject.backward),
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
        return replace(result, acceptance=Acceptance(False, words.no_refit(status)))
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
    steps = design.steps_of(design.PARTS, known is not None)
    for measured, cycles in everything:
        if measured is not None and cycles:
            groups = groups_of(cycles, MOST_GROUPS)
            offered = [[part for part in step if part in measured.columns] for step in steps]
            steps = tuple(design.distinct_parts(measured, groups, step) for step in offered)
    return steps


def _explained(log: Log, steps: Steps) -> Log:
    """Refuse a log that has nothing to do with the model."""
    if log.measured is None or not log.cycles:
        return log
    groups = groups_of(now_of(log.cycles), MOST_GROUPS)
    found = design.estimate(log.measured, groups, steps)
    places = np.concatenate([np.arange(cycle.begin, cycle.end) for group in groups for cycle in group])
    return replace(log, why_not=comparable.unexplained(found.rest, log.measured.response[places]))


def _entry(
    subject: Subject,
    log: Log,
    known: Log | None,
    before: Estimates | None,
    steps: Steps,
    scale: Scale,
    rule: testing.Rule,
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
        now = design.estimate(log.measured, groups_of(log.reference, MOST_GROUPS), steps)
        return LogDrift(
            log.record, REFERENCE, "", log.record.name, len(everything), 0, *percents(now, scale), (), blocks,
            log.measured.prediction.response, where,
        )  # fmt: skip
    say_what_is_beyond(subject, log, tested, findings)
    now = design.estimate(log.measured, groups_of(tested, MOST_GROUPS), steps, rule.ignored)
    alike = known is not None and moved_alike(log, known, findings)
    unit = subject.response.unit or ""
    changes: list[Change] = testing.changes_of(now, before, alike, scale, rule, unit)
    status = testing.status_of(changes, 100.0 * rms(now.counted) / scale.span, rule)
    return LogDrift(
        log.record, status, "", log.record.name, len(everything), len(tested), *percents(now, scale), tuple(changes),
        blocks, log.measured.prediction.response, where,
    )  # fmt: skip
