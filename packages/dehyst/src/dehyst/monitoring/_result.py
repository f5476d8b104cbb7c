"""The result of drift(), and its verdict as text."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from dehyst.arrays import Array
from dehyst.data import Plotted, Recording
from dehyst.findings import Finding
from dehyst.identification import ENDED
from dehyst.models import Model
from dehyst.monitoring._parts import ERROR, GAIN, HYSTERESIS, NAMES, OFFSET, JudgedModel

# What is said of a log, and of all of them together.
UNCHANGED = "unchanged"
DRIFTED = "drifted"
NOT_COMPARABLE = "not comparable"
CANNOT_TELL = "cannot tell"


@dataclass(frozen=True, slots=True)
class PartChange:
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
        return _values_of(self, self.__slots__)


def _values_of(result: object, names: Iterable[str]) -> dict[str, Any]:
    return {name: getattr(result, name) for name in names}


def as_dicts(results: Iterable[Any]) -> list[dict[str, Any]]:
    """Return results, or findings, as plain values."""
    return [result.as_dict() for result in results]


@dataclass(frozen=True)
class ScoredBlocks:
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
        Part -> its change in each block, (b,), in the unit of `PartChange`.
    """

    cycle: Array
    error_percent: Array
    inverse_percent: Array | None
    changes: Mapping[str, Array]

    def as_dict(self) -> dict[str, Any]:
        """Return the blocks as plain values."""
        inverse = None
        if self.inverse_percent is not None:
            inverse = self.inverse_percent.tolist()
        return {
            "cycle": self.cycle.tolist(),
            "error_percent": self.error_percent.tolist(),
            "inverse_percent": inverse,
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
    changes: tuple[PartChange, ...] = ()
    blocks: ScoredBlocks | None = None
    response: Array | None = field(default=None, repr=False)
    shown: tuple[int, int] = (0, 0)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What reading the log found."""
        if self.recording is None:
            return ()
        return self.recording.findings

    def by_part(self) -> dict[str, PartChange]:
        """Changes by the name of the part."""
        return {change.part: change for change in self.changes}

    def as_dict(self) -> dict[str, Any]:
        """Return the log as plain values."""
        blocks = None
        if self.blocks is not None:
            blocks = self.blocks.as_dict()
        return {
            "log": self.name,
            "status": self.status,
            "reason": self.reason,
            "cycles": self.cycles,
            "tested": self.tested,
            "error_percent": self.error_percent,
            "inverse_percent": self.inverse_percent,
            "changes": as_dicts(self.changes),
            "blocks": blocks,
            "warnings": as_dicts(self.findings),
        }


@dataclass(frozen=True, slots=True)
class Trend:
    """Straight line through the blocks of all logs.

    Attributes
    ----------
    part
        As in `PartChange`, or "error".
    slope, low, high
        Change in a hundred cycles with its interval. [unit/100 cycles]
    unit
        As in `PartChange`; "%" of range for the error.
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
        return _values_of(self, self.__slots__) | {"clear": self.clear}


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
        # The model is left out: it has a file of its own.
        names = ("accepted", "reason", "old_percent", "new_percent", "p_value", "groups")
        return _values_of(self, names)


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

    def change(self, part: str, log: int = -1) -> PartChange:
        """Return the change of a part in one log, by default the last one that was tested.

        Raises
        ------
        KeyError
            If that log cannot tell the part from others.
        """
        tested = [entry for entry in self.logs if entry.changes]
        if not tested:
            raise KeyError(part)
        return tested[log].by_part()[part]

    def with_unusable(self, logs: Iterable[tuple[str, str]]) -> Drift:
        """Return the same with logs that could not be read, name and reason, as not comparable."""
        entries = list(self.logs)
        for name, reason in logs:
            entries.append(LogDrift(None, NOT_COMPARABLE, reason, name))
        return replace(self, logs=tuple(entries))

    def __repr__(self) -> str:
        """One line."""
        return f"<Drift {self.status!r}: {len(self.logs)} logs, {self.verdict}>"

    def as_dict(self) -> dict[str, Any]:
        """Return everything as plain values, the content of ``dehyst drift --json``."""
        refit = None
        if self.acceptance is not None:
            refit = self.acceptance.as_dict()
        return {
            "status": self.status,
            "verdict": self.verdict,
            "identified_percent": self.identified_percent,
            "reference": self.reference,
            "logs": [self._by_direction(entry.as_dict()) for entry in self.logs],
            "trends": as_dicts(self.trends),
            "refit": refit,
            "settings": dict(self.settings),
            "motion": dict(self.motion),
            "warnings": as_dicts(self.findings),
        }

    def _by_direction(self, entry: dict[str, Any]) -> dict[str, Any]:
        """Name the other direction as it is: a model driven by the output is read forward, not as an inverse."""
        if JudgedModel.of(self.model).backward:
            for scores in filter(None, (entry, entry["blocks"])):
                scores["forward_percent"] = scores.pop("inverse_percent")
        return entry


WHAT_TELLS = (
    "A log of a dozen cycles alike tells, against one of the same motion from the new actuator (--reference): "
    "`dehyst design --for drift`."
)
# Parts that could hide a change, named in the verdict; more would not be read.
LISTED = 2


def words_of_change(change: PartChange) -> str:
    """Return one change with its interval.

    Examples
    --------
    >>> words_of_change(PartChange("hysteresis", -10.2, -11.0, -9.4, "%", 0.8, 1.5, 0.1, 1e-6, True, True))
    'hysteresis size -10.2 % (-11 to -9.4)'
    """
    # The sign says that the estimate is a change; at the ends of its interval a plus would only be noise.
    estimate = _behind(without_exponent(change.estimate, "+.3g"), change.unit)
    low = without_exponent(change.low, "+.3g").removeprefix("+")
    high = without_exponent(change.high, "+.3g").removeprefix("+")
    return f"{NAMES[change.part]} {estimate} ({low} to {high})"


def _behind(text: str, unit: str) -> str:
    """A number with its unit behind it, if it has one."""
    if unit:
        return f"{text} {unit}"
    return text


def without_exponent(value: float, spec: str) -> str:
    """Format a number, of thousands without an exponent.

    Examples
    --------
    >>> without_exponent(1486.2, "+.3g"), without_exponent(-0.01234, "+.3g")
    ('+1490', '-0.0123')
    >>> without_exponent(331.0, ".2g"), without_exponent(1e9, ".2g")
    ('330', '1e+09')
    """
    text = format(value, spec)
    # Rounding first decides whether the number has an exponent: 999.6 becomes 1e+03.
    rounded = float(text)
    if 100.0 <= abs(rounded) < 1e6:
        sign = spec.partition(".")[0]
        return format(rounded, f"{sign}.0f")
    return text


def status_of_all(logs: Sequence[LogDrift]) -> str:
    """Return the status of all logs together: the worst of those that were tested."""
    statuses = [entry.status for entry in logs]
    # A log that is not comparable does not hide what the others say.
    for status in (DRIFTED, CANNOT_TELL, UNCHANGED):
        if status in statuses:
            return status
    return NOT_COMPARABLE


def verdict_of(
    status: str, logs: Sequence[LogDrift], before: float | None, against: str, backward: bool
) -> str:
    """Return the judgement in one or two sentences."""
    if status == NOT_COMPARABLE:
        reasons = []
        for log in logs:
            if log.status == NOT_COMPARABLE:
                reasons.append(f"{log.name}: {log.reason}")
        if not reasons:
            return "not comparable: there is no log but the one that the model was identified from."
        return f"not comparable: {'; '.join(reasons)}."
    tested = [log for log in logs if log.changes]
    if status == UNCHANGED:
        limits = _limits(tested[-1])
        return f"unchanged since it was identified ({against}); {_error(tested[-1], before, backward)}.{limits}"
    # The status of all logs together is that of the last one which has it.
    worst = [log for log in tested if log.status == status]
    last = worst[-1]
    error = _error(last, before, backward)
    # The name of a single log is no news.
    by_which, since = "", ""
    if len(tested) > 1:
        by_which = f" by {last.name}"
        since = f", first seen in {worst[0].name}"
    if status == CANNOT_TELL:
        return f"cannot tell{by_which} ({against}): {_hidden(last)}; {error}. {WHAT_TELLS}"
    if last is not tested[-1]:
        since += f"; {tested[-1].name}, the last log, does not show it"
    # An output that stopped explains all changes of the parts, so that it comes first.
    words = []
    for finding in last.findings:
        if finding.code in ENDED:
            words.append(finding.message.partition(":")[0])
    words += map(words_of_change, _changed(last))
    return f"drifted ({against}): {', '.join(words)}{since}; {error}."


def _limits(entry: LogDrift) -> str:
    """Say which changes of an unchanged actuator would have been found."""
    changes = entry.by_part()
    bounds = []
    # The parts that a user knows from a data sheet; a list of all of them would not be read.
    for part in (OFFSET, GAIN, HYSTERESIS):
        if part in changes:
            bounds.append(_bound(changes[part]))
    if not bounds:
        return ""
    return f" A change of {', '.join(bounds)} would have been found nine times in ten."


def _changed(entry: LogDrift) -> list[PartChange]:
    """Changes of a log that count, largest first; the error, the sum of the others, only where it is alone."""
    changed = [change for change in entry.changes if change.drifted]
    parts = [change for change in changed if change.part != ERROR] or changed
    return sorted(parts, key=lambda change: -change.effect_percent)


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
    reasons = []
    parts = []
    for change in entry.changes:
        if change.resolved:
            continue
        if change.part == ERROR:
            growth = without_exponent(change.estimate, ".3g")
            low, high = without_exponent(change.low, ".3g"), without_exponent(change.high, ".3g")
            reasons.append(
                f"the error is larger by {growth} % ({low} to {high}), it may have doubled"
            )
        else:
            percent = change.detectable_percent or 0.0
            parts.append((percent, f"{_bound(change)} ({percent:.2g} % of range)"))
    if parts:
        parts.sort(key=lambda part: -part[0])
        _, listed = zip(*parts[:LISTED], strict=True)
        reasons.append(f"a change of {' or '.join(listed)} may have stayed hidden")
    # All parts are resolved, so that only the missing error of the card is left as a reason.
    if not reasons:
        reasons.append("nobody knows what the error was when it was identified")
    return "; ".join(reasons)


def other_way(backward: bool) -> str:
    """What a model is called, read against its direction."""
    if backward:
        return "forward"
    return "inverse"


def _bound(change: PartChange) -> str:
    size = _behind(without_exponent(change.detectable, ".2g"), change.unit)
    return f"{NAMES[change.part]} by {size}"


def _error(entry: LogDrift, before: float | None, backward: bool) -> str:
    """The errors of a log, beside the one before."""
    words = f"error {entry.error_percent:.3g} % of range rms"
    if before is not None:
        words += f", against {before:.3g} % when it was identified"
    if entry.inverse_percent is not None:
        words += f"; {other_way(backward)} {entry.inverse_percent:.3g} %"
    return words
