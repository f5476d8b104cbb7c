"""The result of drift(), and its verdict as text."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from dehyst.arrays import Array
from dehyst.data.plotted import Plotted
from dehyst.data.recording import Recording
from dehyst.findings import Finding
from dehyst.identification.mending import ENDED
from dehyst.models import Model
from dehyst.monitoring.parts import (
    ERROR,
    GAIN,
    HYSTERESIS,
    NAMES,
    OFFSET,
    Subject,
)

UNCHANGED, DRIFTED, NOT_COMPARABLE, CANNOT_TELL = "unchanged", "drifted", "not comparable", "cannot tell"


@dataclass(frozen=True, slots=True)
class Change:
    """How much one part of the actuator differs from the model, or from the reference.

    Attributes
    ----------
    part
        "offset", "gain" (of the whole), "hysteresis" (size of the loop beyond the gain), "bend" and "s-bend" (quadratic
        and cubic change of the curve), "creep" (that the model lacks), "own-creep" and "viscous" (sizes of what a
        direct inverse has), "rest" (what none of them explains: noise, wear, another shape), or "error" (the whole
        error of the model, less what ignored parts do).
    estimate, low, high
        Change with its 95 % interval. [unit]
    unit
        Unit of the response for the offset; "%" otherwise: of the part itself for gain, hysteresis, own-creep and
        viscous, of the range of the response (rms) for bend, s-bend and creep; for rest and error, growth of their
        rms.
    effect_percent
        RMS of what the change does to the response, percent of range; of rest and error, their own size.
    detectable
        Size of a change that this log would have shown nine times in ten. [unit]
    detectable_percent
        RMS of what such a change does to the response, percent of range; None for rest and error.
    p_value
        Probability of such an estimate if nothing worth a word had changed.
    drifted
        Whether that is less than the part's share of the false alarms allowed.
    resolved
        Whether the log can say that the part has not changed: `detectable_percent` is no more than 1, or the error has
        not doubled, nor may have within its interval. Ignored parts and the rest, which the error holds, always.
    """

    part: str
    estimate: float
    low: float
    high: float
    unit: str
    effect_percent: float
    detectable: float
    detectable_percent: float | None
    p_value: float
    drifted: bool
    resolved: bool

    def as_dict(self) -> dict[str, Any]:
        """Return the change as plain values."""
        return {name: getattr(self, name) for name in self.__slots__}


@dataclass(frozen=True)
class Blocks:
    """Cycles, or blocks of them, scored one by one.

    Attributes
    ----------
    cycle
        Number of the cycle in the middle of each block, counted over all logs, (b,).
    error_percent
        RMS of the error of the model, percent of the response's range, (b,).
    inverse_percent
        RMS of the drive that the inverse asks for less the applied one, percent of its range, (b,), or None.
    changes
        Part -> its change in each block, (b,), in the unit of `Change`.
    """

    cycle: Array
    error_percent: Array
    inverse_percent: Array | None
    changes: Mapping[str, Array]

    def as_dict(self) -> dict[str, Any]:
        """Return the blocks as plain values."""
        return {
            "cycle": self.cycle.tolist(),
            "error_percent": self.error_percent.tolist(),
            "inverse_percent": None if self.inverse_percent is None else self.inverse_percent.tolist(),
            "changes": {part: values.tolist() for part, values in self.changes.items()},
        }


@dataclass(frozen=True)
class LogDrift:
    """One log.

    Attributes
    ----------
    recording
        The log, in the units of the model; None if it could not be read.
    status
        "unchanged", "drifted", "cannot tell" or "not comparable"; "reference" for the log that the others are compared
        with.
    reason
        Why it is not comparable, or "".
    name
        Name of the log.
    cycles, tested
        Complete cycles whose memory is known, and those of them that were tested: the last quarter of long logs.
    error_percent, inverse_percent
        RMS of the tested cycles in percent of the ranges of response and drive; None where there is none. The second
        is that of the model read the other way: the inverse of a forward model, and forward for a direct inverse.
    changes
        Parts that the log can tell apart.
    blocks
        Scores over the cycles, None if not comparable.
    response
        Prediction of the model, (T,), or None. [response]
    shown
        Begin and end of the last tested cycles, drawn in the report.
    """

    recording: Recording | None
    status: str
    reason: str = ""
    name: str = ""
    cycles: int = 0
    tested: int = 0
    error_percent: float | None = None
    inverse_percent: float | None = None
    changes: tuple[Change, ...] = ()
    blocks: Blocks | None = None
    response: Array | None = field(default=None, repr=False)
    shown: tuple[int, int] = (0, 0)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What reading the log found."""
        return () if self.recording is None else self.recording.findings

    def as_dict(self) -> dict[str, Any]:
        """Return the log as plain values."""
        return {
            "log": self.name,
            "status": self.status,
            "reason": self.reason,
            "cycles": self.cycles,
            "tested": self.tested,
            "error_percent": self.error_percent,
            "inverse_percent": self.inverse_percent,
            "changes": [change.as_dict() for change in self.changes],
            "blocks": None if self.blocks is None else self.blocks.as_dict(),
            "warnings": [finding.as_dict() for finding in self.findings],
        }


@dataclass(frozen=True, slots=True)
class Trend:
    """Straight line through the blocks of all logs.

    Attributes
    ----------
    part
        As in `Change`, or "error".
    slope, low, high
        Change in a hundred cycles with its interval. [unit/100 cycles]
    unit
        As in `Change`; "%" of range for the error.
    """

    part: str
    slope: float
    low: float
    high: float
    unit: str

    @property
    def clear(self) -> bool:
        """Whether the interval leaves zero out."""
        return self.low > 0.0 or self.high < 0.0

    def as_dict(self) -> dict[str, Any]:
        """Return the trend as plain values."""
        return {name: getattr(self, name) for name in self.__slots__} | {"clear": self.clear}


@dataclass(frozen=True)
class Acceptance:
    """A model that was identified anew, and whether it replaces the old one.

    Attributes
    ----------
    accepted
        Whether it does.
    reason
        The numbers, in words.
    model
        The new model, accepted or not; None if none could be identified.
    old_percent, new_percent
        RMS errors on the same held-out cycles, percent of range.
    p_value
        Probability of such a gain if the new model were no better.
    groups
        Groups of held-out cycles that were compared in pairs.
    """

    accepted: bool
    reason: str
    model: Model | None = None
    old_percent: float | None = None
    new_percent: float | None = None
    p_value: float | None = None
    groups: int = 0

    def as_dict(self) -> dict[str, Any]:
        """Return the decision as plain values."""
        names = ("accepted", "reason", "old_percent", "new_percent", "p_value", "groups")
        return {name: getattr(self, name) for name in names}


@dataclass(frozen=True)
class Drift(Plotted):
    """Whether an actuator has changed since its model was identified.

    Attributes
    ----------
    status
        "unchanged", "drifted", "cannot tell" (the log could hide a change worth a word) or "not comparable".
    verdict
        The judgement in words, with its numbers.
    model
        The model to use from now on: a new one only if it was accepted.
    logs
        One entry a recording, in the order given.
    identified_percent
        Error when the model was identified: of the reference, or of the held-out samples by the model's card; percent
        of range, None if unknown.
    reference
        Name of the recording that the others are compared with, or None: they are compared with the model itself.
    trends
        Straight lines over the cycles, where there are enough of them.
    findings
        What limits the judgement.
    settings
        Settings of the call.
    motion
        What a motion that tells is made of: `low`, `high`, `unit` of the driving signal, and `rate`, the peak of the
        whole range in the time of the logs' cycles, `period_s`, both None without time stamps; empty if no log was
        tested.
    acceptance
        The decision about a new model, or None if none was asked for.

    Examples
    --------
    >>> import numpy as np, dehyst
    >>> x = np.sin(np.linspace(0, 40 * np.pi, 4001))
    >>> model = dehyst.PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0])
    >>> noise = 0.01 * np.random.default_rng(0).standard_normal(x.size)
    >>> smaller = dehyst.PrandtlIshlinskii([0.0, 0.5], [1.2, 0.8])
    >>> dehyst.drift(model, dehyst.Recording(input=x, output=model.simulate(x) + noise)).status
    'unchanged'
    >>> found = dehyst.drift(model, dehyst.Recording(input=x, output=smaller.simulate(x) + noise))
    >>> found.status, round(found.change("hysteresis").estimate)
    ('drifted', -20)
    """

    status: str
    verdict: str
    model: Model
    logs: tuple[LogDrift, ...]
    identified_percent: float | None
    reference: str | None
    trends: tuple[Trend, ...]
    findings: tuple[Finding, ...]
    settings: Mapping[str, Any]
    motion: Mapping[str, Any] = field(default_factory=dict)
    acceptance: Acceptance | None = None

    def change(self, part: str, log: int = -1) -> Change:
        """Return the change of a part in one log, by default the last one that was tested.

        Raises
        ------
        KeyError
            If that log cannot tell the part from others.
        """
        tested = [entry for entry in self.logs if entry.changes]
        if not tested:
            raise KeyError(part)
        found = {change.part: change for change in tested[log].changes}
        return found[part]

    def with_unusable(self, logs: Iterable[tuple[str, str]]) -> Drift:
        """Return the same with logs that could not be read, name and reason, as not comparable."""
        more = tuple(LogDrift(None, NOT_COMPARABLE, reason, name) for name, reason in logs)
        return replace(self, logs=(*self.logs, *more)) if more else self

    def __repr__(self) -> str:
        """One line."""
        return f"<Drift {self.status!r}: {len(self.logs)} logs, {self.verdict}>"

    def as_dict(self) -> dict[str, Any]:
        """Return everything as plain values, the content of ``dehyst drift --json``."""
        return {
            "status": self.status,
            "verdict": self.verdict,
            "identified_percent": self.identified_percent,
            "reference": self.reference,
            "logs": [self._told(entry.as_dict()) for entry in self.logs],
            "trends": [trend.as_dict() for trend in self.trends],
            "refit": None if self.acceptance is None else self.acceptance.as_dict(),
            "settings": dict(self.settings),
            "motion": dict(self.motion),
            "warnings": [finding.as_dict() for finding in self.findings],
        }

    def _told(self, entry: dict[str, Any]) -> dict[str, Any]:
        """Name the other direction as it is: a model driven by the output is read forward, not as an inverse."""
        if Subject.of(self.model).backward:
            for told in filter(None, (entry, entry["blocks"])):
                told["forward_percent"] = told.pop("inverse_percent")
        return entry


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
    low, high = (plain(value, "+.3g").removeprefix("+") for value in (change.low, change.high))
    return f"{name} {plain(change.estimate, '+.3g')}{unit} ({low} to {high})"


def plain(value: float, spec: str) -> str:
    """Format a number, of thousands without an exponent.

    Examples
    --------
    >>> plain(1486.2, "+.3g"), plain(-0.01234, "+.3g"), plain(331.0, ".2g"), plain(1e9, ".2g")
    ('+1490', '-0.0123', '330', '1e+09')
    """
    rounded = float(format(value, spec))
    return format(value, spec) if not 100.0 <= abs(rounded) < 1e6 else format(rounded, f"{spec.partition('.')[0]}.0f")


def status_of_all(logs: Sequence[LogDrift]) -> str:
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
    within = [finding.message.partition(":")[0] for finding in last.findings if finding.code in ENDED]
    said = ", ".join([*within, *map(in_words, parts)])
    return f"drifted ({against}): {said}{since}; {_error(last, before, backward)}."


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
        f"the error is larger by {plain(change.estimate, '.3g')} % "
        f"({plain(change.low, '.3g')} to {plain(change.high, '.3g')}), it may have doubled"
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
    return f"{NAMES[change.part]} by {plain(change.detectable, '.2g')}{unit}"


def _error(entry: LogDrift, before: float | None, backward: bool) -> str:
    was = f", against {before:.3g} % when it was identified" if before is not None else ""
    inverse = f"; {other_way(backward)} {entry.inverse_percent:.3g} %" if entry.inverse_percent is not None else ""
    return f"error {entry.error_percent:.3g} % of range rms{was}{inverse}"
