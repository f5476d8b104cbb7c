"""The judgement in words."""

from __future__ import annotations

from collections.abc import Sequence

from dehyst.monitoring.design import (
    BEND,
    CREEP,
    ERROR,
    GAIN,
    HYSTERESIS,
    OFFSET,
    OWN_CREEP,
    REST,
    S_BEND,
    VISCOUS,
)
from dehyst.monitoring.result import CANNOT_TELL, DRIFTED, NOT_COMPARABLE, UNCHANGED, Change, LogDrift

NAMES = {
    OFFSET: "offset",
    GAIN: "gain",
    HYSTERESIS: "hysteresis size",
    OWN_CREEP: "creep size",
    VISCOUS: "viscosity",
    BEND: "bend of the curve",
    S_BEND: "S of the curve",
    CREEP: "creep",
    REST: "unexplained rest",
    ERROR: "error of the model",
}

WHAT_TELLS = (
    "A log of a dozen cycles alike tells, against one of the same motion from the new actuator (--reference): "
    "`dehyst design --for drift`."
)
LISTED = 2  # parts of a log that could hide changes


def in_words(change: Change) -> str:
    """Return one change with its interval.

    Examples
    --------
    >>> in_words(Change("hysteresis", -10.2, -11.0, -9.4, "%", 0.8, 1.5, 0.1, 1e-6, True, True))
    'hysteresis size -10.2 % (-11 to -9.4)'
    """
    unit = f" {change.unit}" if change.unit else ""
    name = NAMES[change.part]
    return f"{name} {change.estimate:+.3g}{unit} ({change.low:+.3g} to {change.high:+.3g})".replace("(+", "(").replace(
        "to +", "to "
    )


def status_of(logs: Sequence[LogDrift]) -> str:
    """Return the status of all logs together: the worst of those that were tested."""
    found = {entry.status for entry in logs}
    return next((status for status in (DRIFTED, CANNOT_TELL, UNCHANGED) if status in found), NOT_COMPARABLE)


def verdict_of(status: str, logs: Sequence[LogDrift], before: float | None, against: str, backward: bool) -> str:
    """Return the judgement in one or two sentences."""
    if status == NOT_COMPARABLE:
        failed = [entry for entry in logs if entry.status == NOT_COMPARABLE]
        if not failed:
            return "not comparable: there is no log but the one that the model was identified from."
        return "not comparable: " + "; ".join(f"{entry.name}: {entry.reason}" for entry in failed) + "."
    tested = [entry for entry in logs if entry.changes]
    if status == CANNOT_TELL:
        last = [entry for entry in tested if entry.status == CANNOT_TELL][-1]
        where = f" by {last.name}" if len(tested) > 1 else ""
        return f"cannot tell{where} ({against}): {_hidden(last)}; {_error(last, before, backward)}. {WHAT_TELLS}"
    if status == UNCHANGED:
        last = tested[-1]
        bounds = ", ".join(_bound(change) for change in last.changes if change.part in (OFFSET, GAIN, HYSTERESIS))
        limits = f" A change of {bounds} would have been found nine times in ten." if bounds else ""
        return f"unchanged since it was identified ({against}); {_error(last, before, backward)}.{limits}"
    changed = [entry for entry in tested if entry.status == DRIFTED]
    last = changed[-1]
    found = sorted((c for c in last.changes if c.drifted), key=lambda c: -c.effect_percent)
    parts = [change for change in found if change.part != ERROR] or found  # the error is the sum of the others
    since = f", first seen in {changed[0].name}" if len(tested) > 1 else ""
    if last is not tested[-1]:
        since += f"; {tested[-1].name}, the last log, does not show it"
    return f"drifted ({against}): {', '.join(map(in_words, parts))}{since}; {_error(last, before, backward)}."


def no_refit(status: str) -> str:
    """Return why nothing is identified anew where no log has drifted."""
    why = {
        UNCHANGED: "the actuator has not changed",
        CANNOT_TELL: "whether the actuator has changed cannot be told",
        NOT_COMPARABLE: "no log is comparable",
    }[status]
    return f"{why}, so nothing was identified anew; the old model stays"


def _hidden(entry: LogDrift) -> str:
    """What a log in which nothing was found could hide."""
    grown = [change for change in entry.changes if change.part == ERROR and not change.resolved]
    found = [
        f"the error is larger by {change.estimate:.3g} % ({change.low:.3g} to {change.high:.3g}), it may have doubled"
        for change in grown
    ]
    parts = [(change.detectable_percent or 0.0, change) for change in entry.changes if not change.resolved]
    parts = sorted((pair for pair in parts if pair[1].part != ERROR), key=lambda pair: -pair[0])
    if parts:
        listed = " or ".join(f"{_bound(change)} ({percent:.2g} % of range)" for percent, change in parts[:LISTED])
        found.append(f"a change of {listed} may have stayed hidden")
    if not found:
        found.append("nobody knows what the error was when it was identified")
    return "; ".join(found)


def other_way(backward: bool) -> str:
    """What a model is called, read against its direction."""
    return "forward" if backward else "inverse"


def _bound(change: Change) -> str:
    unit = f" {change.unit}" if change.unit else ""
    return f"{NAMES[change.part]} by {change.detectable:.2g}{unit}"


def _error(entry: LogDrift, before: float | None, backward: bool) -> str:
    was = f", against {before:.3g} % when it was identified" if before is not None else ""
    inverse = f"; {other_way(backward)} {entry.inverse_percent:.3g} %" if entry.inverse_percent is not None else ""
    return f"error {entry.error_percent:.3g} % of range rms{was}{inverse}"
