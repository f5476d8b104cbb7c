"""evaluate(): scores existing models of any family on a log they were not identified from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, rank
from dehyst.data.loops import turning_points
from dehyst.data.ranges import robust_range
from dehyst.data.recording import Recording, require_recordings, takes_recordings
from dehyst.data.repeats import counted_once, refuse_repeated
from dehyst.errors import DehystError, ParameterError
from dehyst.findings import Finding, Grade, grade_of
from dehyst.identification.certify import GOOD_PERCENT
from dehyst.identification.data import range_over
from dehyst.identification.direct.data import check_given
from dehyst.identification.fit import InputError, Score
from dehyst.identification.memory import known_from
from dehyst.identification.mending import mended
from dehyst.identification.scores import Part, score
from dehyst.models import Model
from dehyst.models.model import require_model
from dehyst.models.offset import following, offset_numbers, width
from dehyst.models.speed import faster_than_log
from dehyst.models.start import DEFAULT, PASTS, UNKNOWN, begun, check_start
from dehyst.monitoring.logs import fitted_share, in_units_of, unexplained

Signals = npt.ArrayLike | Sequence[npt.ArrayLike]

FEW_TURNS = 3  # of the input: with fewer not even one loop was closed
BEYOND = 0.02  # share of the identified range that a log may leave it by without a word
# Pasts shift the output by this many percent of range before it is said: a third of what is good for compensation.
SHIFTS = 1.0
# A bias is a constant, as that of a sensor's zero, where what is left without it is smaller than this share of it.
CONSTANT = 0.5


@dataclass(frozen=True)
class Scored:
    """One model on a log.

    Attributes
    ----------
    name
        As it was called.
    model
        The model.
    output
        Errors of its output; None if it cannot be simulated here.
    output_bias
        Mean of that error: an offset of sensor or supply is no error of the loop. [output]
    input
        Error of the input that its inverse asks for at the measured output, kept within the identified range; None
        without an inverse.
    error_percent, input_percent
        RMS error of output and input, percent of their ranges, without the mean of each recording; infinite where
        there is none.
    clipped
        Share of the samples at which the inverse asked for more than the identified range.
    reason
        Why there is no output error, or no input error; "" where nothing is missing.
    predictions, demands
        Output of the model and input of its inverse, in the model's units, (T,) for each recording; empty if there is
        none. [output], [input]
    findings
        What limits these errors.
    """

    name: str
    model: Model
    output: Score | None = None
    output_bias: float = 0.0
    input: InputError | None = None
    error_percent: float = float("inf")
    input_percent: float = float("inf")
    clipped: float = 0.0
    reason: str = ""
    predictions: tuple[Array, ...] = ()
    demands: tuple[Array, ...] = ()
    findings: tuple[Finding, ...] = ()

    @property
    def bias_percent(self) -> float:
        """Mean error of the output, percent of its range."""
        score = self.output
        return 0.0 if score is None or score.rmse == 0.0 else self.output_bias * score.rmse_percent / score.rmse

    def as_dict(self) -> dict[str, Any]:
        """Return the row as printed by ``--json``."""
        output, asked = self.output, self.input
        bias = {"bias_percent": self.bias_percent, "without_bias_percent": self.error_percent}
        return {
            "name": self.name,
            "family": self.model.family,
            "direction": self.model.direction,
            "output_error": None if output is None else output.as_dict() | bias,
            "input_error": None if asked is None else asked.as_dict() | {"without_bias_percent": self.input_percent},
            "clipped": self.clipped,
            "reason": self.reason,
            "warnings": [finding.as_dict() for finding in self.findings],
        }


@dataclass(frozen=True)
class Evaluation:
    """Models on a log, the one with the smallest output error first.

    Attributes
    ----------
    entries
        One for each model.
    recordings
        The log, in the units in which it was logged.
    run
        Name of the model to compensate with; None if none of them should be used here.
    why
        Why that one, in one sentence.
    findings
        About the log itself.

    Examples
    --------
    >>> import dehyst
    >>> x = 2 * np.sin(np.linspace(0, 40, 800))
    >>> line = dehyst.PrandtlIshlinskii([0.0], [1.2])
    >>> evaluate({"line": line}, dehyst.Recording(input=x, output=1.2 * x)).run
    'line'
    """

    entries: tuple[Scored, ...]
    recordings: tuple[Recording, ...]
    run: str | None
    why: str
    findings: tuple[Finding, ...] = ()

    def __getitem__(self, name: str) -> Scored:
        """Row of a model."""
        for entry in self.entries:
            if entry.name == name:
                return entry
        raise ParameterError(f"'{name!s:.60}' is not among {', '.join(e.name for e in self.entries)}.", name=name)

    def as_dict(self) -> dict[str, Any]:
        """Return the evaluation as printed by ``dehyst evaluate --json``."""
        return {
            "models": [entry.as_dict() for entry in self.entries],
            "run": self.run,
            "why": self.why,
            "samples": sum(len(record) for record in self.recordings),
            "warnings": [finding.as_dict() for finding in self.findings],
        }


@dataclass(frozen=True, eq=False)
class _Log:
    """Recordings made ready, and which of their samples count."""

    records: tuple[Recording, ...]
    given: tuple[dict[str, Array], ...]
    part: Part = field(default_factory=lambda: Part((), ()))
    follow_offset: float | None = None
    start: str = DEFAULT


@takes_recordings
def evaluate(
    models: Model | Sequence[Model] | Mapping[str, Model],
    recordings: Recording | Sequence[Recording],
    *,
    follow_offset: float | None = None,
    start: str = DEFAULT,
    **signals: Signals,
) -> Evaluation:
    """Score saved models of any family on another log: how far output and inverse are off, and which one to run.

    Every model begins each piece as `start` says, as in `dehyst simulate`. What it says counts from where the input has
    visited both ends of its range: before, the past decides. If that leaves less than half of the log all of it counts,
    and of a piece after a gap nothing before.

    Parameters
    ----------
    models
        One model, several, or several by name.
    recordings
        The log. Signals are converted to the units of each model's card.
    follow_offset
        Limit of an offset that follows the last cycle, as a share of the output's range: outputs are scored with it.
    start
        Past of the actuator, one of `dehyst.models.start.STARTS`: "model", as the log began that it was identified
        from, "rest", "rising", "falling", or, for models of plays, "unknown".
    signals
        Scheduling signals by name that a model needs, such as `load`: an array (T,) for each recording.

    Returns
    -------
    evaluation : Evaluation
        Rows in the order of the output error without its mean, which ranks compensators better than the input error
        does (docs/decisions/0045).

    Raises
    ------
    ParameterError
        If something is no model, there is none, two have one name, or there is no such start.

    Examples
    --------
    >>> import dehyst
    >>> x = 2 * np.sin(np.linspace(0, 40, 800))
    >>> plays = dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5])
    >>> later = dehyst.Recording(input=x, output=plays.simulate(x) + 0.03)
    >>> found = evaluate({"plays": plays, "line": dehyst.PrandtlIshlinskii([0.0], [1.2])}, later)
    >>> found.run, round(found["plays"].error_percent, 6), round(found["plays"].output_bias, 3)
    ('plays', 0.0, -0.03)
    """
    named = _named(models)
    records = require_recordings(recordings)
    refuse_repeated(records)
    records = tuple(mended(counted_once(record)) for record in records)
    given: list[dict[str, Array]] = [{} for _ in records]
    for name, values in signals.items():
        for held, array in zip(given, check_given(name, values, records), strict=True):
            held[name] = array
    low, high = range_over([record.input for record in records])
    part, assumed = _counting(records, low, high, check_start(start), tuple(named.values()))
    log = _Log(records, tuple(given), part, follow_offset, start)
    entries = [_scored(name, model, log) for name, model in named.items()]
    entries.sort(key=lambda entry: rank(entry.error_percent))
    run, why = _advice(entries)
    return Evaluation(tuple(entries), records, run, why, (*_about(records), *assumed))


def _named(models: Model | Sequence[Model] | Mapping[str, Model]) -> dict[str, Model]:
    wanted = "models, such as fit.model or dehyst.load('model.json'), in a list or by name in a dict"
    if isinstance(models, Mapping):
        found = {str(name): require_model(model, wanted) for name, model in models.items()}
    else:
        given = list(models) if isinstance(models, list | tuple) else [models]
        listed = [require_model(model, wanted) for model in given]
        found = {
            f"{k + 1}: {model.family}" if len(listed) > 1 else model.family: model for k, model in enumerate(listed)
        }
    if not found:
        raise ParameterError(f"there is no model. Pass {wanted}.")
    return found


def _counting(
    records: tuple[Recording, ...], low: float, high: float, start: str, models: Sequence[Model]
) -> tuple[Part, list[Finding]]:
    """Samples that count: those after both ends were visited, where that leaves half of the log, and not left out.

    Otherwise all of each first piece counts, and what a piece after a gap did before is no part of any score either.
    """
    begins = [[known_from(record.input[piece], low, high) for piece in record.pieces] for record in records]
    counted = sum(
        max(0, piece.stop - piece.start - begin)
        for record, row in zip(records, begins, strict=True)
        for piece, begin in zip(record.pieces, row, strict=True)
    )
    assumed = 2 * counted < sum(len(record) for record in records)
    weights: list[Array | None] = []
    spans: list[tuple[slice, ...]] = []
    for record, row in zip(records, begins, strict=True):
        if assumed:
            row[0] = 0
        ends = zip(record.pieces, row, strict=True)
        spans.append(tuple(slice(min(piece.start + begin, piece.stop), piece.stop) for piece, begin in ends))
        weight = np.ones(len(record)) if record.left_out else None
        if weight is not None:
            weight[list(record.left_out)] = 0.0
        weights.append(weight)
    part = Part(tuple(spans), tuple(weights))
    if not assumed:
        return part, []
    others = [
        f"--start {other}"
        for other in PASTS
        if other != start and all(_takes(model, other, float(records[0].input[0])) for model in models)
    ]
    cure = f"If you know it, name it: {' or '.join(others)}. Otherwise log" if others else "Log"
    return part, [
        Finding(
            "start-counts",
            f"the log goes over the whole range of its input, {low:.4g} to {high:.4g}, late or never: all of it "
            f"counts, and what a model errs by may be the past, which was taken to be as --start {start} says. {cure} "
            f"a stroke over the whole range first.",
        )
    ]


def _takes(model: Model, start: str, first: float) -> bool:
    """Whether a model can begin with a past: not every model has all of them."""
    try:
        begun(model, start, first)
    except DehystError:
        return False
    return True


def _about(records: tuple[Recording, ...]) -> list[Finding]:
    """What stands against the log itself."""
    found = [finding for record in records for finding in record.findings]
    turns = sum(int(turning_points(record.input[piece]).size) for record in records for piece in record.pieces)
    if turns < FEW_TURNS:
        samples = sum(len(record) for record in records)
        found.append(
            Finding(
                "log-too-short",
                f"the input turns {turns} times in {samples} samples, less than one closed loop: errors are those of "
                f"this stroke, and say little about use. Log at least {FEW_TURNS} reversals, better the motion of use.",
            )
        )
    return found


def _bias(entry: Scored, log: _Log, records: Sequence[Recording]) -> list[Finding]:
    """Say where the output is off by a constant, and whether the past, which nobody knows, can be why."""
    if entry.output is None or log.follow_offset is not None:
        return []
    bias = entry.bias_percent
    if abs(bias) <= SHIFTS:
        return []
    shifts = _shifts(entry, log, records)
    low, high = min(shifts.values(), default=0.0), max(shifts.values(), default=0.0)
    size = abs(entry.output_bias)
    unit = f" {entry.model.card.output.unit}" if entry.model.card.output.unit else ""
    seen = (
        f"the output of {entry.name} lies {abs(bias):.3g} % of range ({size:.3g}{unit}) "
        f"{'above' if bias > 0 else 'below'} that of the log, in the mean"
    )
    if high - low > SHIFTS and low - SHIFTS <= -bias <= high + SHIFTS:
        best = min(PASTS, key=lambda start: abs(bias + shifts.get(start, np.inf)))
        stroke = "{:.4g} to {:.4g}".format(*entry.model.ends)
        could = f"what the actuator did before the log moves it by {low:+.2g} to {high:+.2g} %"
        nearest = f"--start {best} leaves {bias + shifts[best]:+.2g} %"
        if abs(bias) <= GOOD_PERCENT:
            return [
                Finding(
                    "unknown-past", f"{seen}; {could}, and the log does not tell. Log a stroke over {stroke} first."
                )
            ]
        return [
            Finding(
                "unknown-past",
                f"{seen}; {could}, which is enough for that: {nearest}. A model is not to blame for a past that it was "
                f"not told. Say how the actuator came there (--start), or log a stroke over {stroke} first.",
            )
        ]
    if abs(bias) <= GOOD_PERCENT:
        return []
    gain, left = _gain(entry, log, records)
    if entry.error_percent > CONSTANT * abs(bias) or (entry.error_percent > SHIFTS and left < CONSTANT):
        scaled = f"; times {gain:.3g} and moved, it would be off by {left * entry.error_percent:.2g} %"
        return [
            Finding(
                "offset",
                f"{seen}, and by {entry.error_percent:.3g} % rms beside that{scaled}: it is no mere constant, so this "
                f"model is not that of the actuator as it is now. Identify from this log.",
            )
        ]
    moved = f" (pasts move it by {low:+.2g} to {high:+.2g} %)" if shifts else ""
    return [
        Finding(
            "offset",
            f"{seen}, and no past of the actuator explains that{moved}: the zero of the sensor, the load or the "
            f"temperature is another one, which this log cannot tell apart. Input errors hold it, too. Zero the sensor "
            f"as in the identified log, or subtract the offset from the reference.",
        )
    ]


def _gain(entry: Scored, log: _Log, records: Sequence[Recording]) -> tuple[float, float]:
    """Factor of the output that fits the log best beside a constant, and the share of the error that it leaves."""
    masks = [log.part.mask(index, len(record)) for index, record in enumerate(records)]
    pairs = [(f[mask], r.output[mask]) for f, r, mask in zip(entry.predictions, records, masks, strict=True)]
    said, seen = (np.concatenate([part[k] - part[k].mean() for part in pairs if part[k].size]) for k in (0, 1))
    square, error = float(said @ said), float(np.sum((seen - said) ** 2))
    if square == 0.0 or error == 0.0:
        return 1.0, 1.0
    gain = float(said @ seen) / square
    return gain, float(np.sqrt(np.sum((seen - gain * said) ** 2) / error))


def _shifts(entry: Scored, log: _Log, records: Sequence[Recording]) -> dict[str, float]:
    """By how much each other past moves the output where it counts, in the mean, percent of range."""
    if entry.output is None or not entry.output.rmse > 0.0:
        return {}
    percent, inputs = entry.output.rmse_percent / entry.output.rmse, [record.input for record in records]
    shifts: dict[str, float] = {}
    for start in PASTS:
        try:
            outputs = _answers(entry.model, records, inputs, replace(log, start=start))
        except DehystError:  # a model that has no such start
            continue
        shifts[start] = percent * log.part.moments(outputs, entry.predictions).mean
    if entry.model.bounded and entry.model.direction == "forward":
        lowest, highest = _bounds(entry.model, records)
        shifts["lowest"] = percent * log.part.moments(lowest, entry.predictions).mean
        shifts["highest"] = percent * log.part.moments(highest, entry.predictions).mean
    return shifts


def _bounds(model: Model, records: Sequence[Recording]) -> tuple[list[Array], list[Array]]:
    """Least and largest output after any past within the identified range, along each recording."""
    lows, highs = [], []
    for record in records:
        bands = [
            model.band(np.ascontiguousarray(record.input[piece]), past=model.usual_past) for piece in record.pieces
        ]
        lows.append(np.concatenate([band.low for band in bands]))
        highs.append(np.concatenate([band.high for band in bands]))
    return lows, highs


def _scored(name: str, model: Model, log: _Log) -> Scored:
    """One model on the log, or why it cannot be scored there."""
    records, findings = [], []
    for record in log.records:
        changed, said, why = in_units_of(record, (model.card.input, model.card.output))
        if why:
            return Scored(name, model, reason=f"{why}.")
        if model.rate_dependent and record.time is None:
            return Scored(
                name,
                model,
                reason=f"the model depends on time, and {record.name} has no time stamps. Name its time column with "
                f"--time, or log one.",
            )
        records.append(changed)
        findings += said
    missing = [need for need in model.needs if any(need not in given for given in log.given)]
    if missing:
        option = missing[0].replace("_", "-")
        return Scored(name, model, reason=f"the model depends on '{missing[0]}', which was not given: --{option}.")
    findings += _fitted(name, model, log.records) + _outside(model, records)
    moves = [(record.time, record.input) for record in records]
    findings += faster_than_log(model, model.card.input, "the input of the log", moves)
    entry = _backward(_forward(Scored(name, model, findings=tuple(findings)), log, records), log, records)
    if entry.output is None:
        return entry
    why = _not_explained(entry.predictions, records, log)
    if not why:
        return replace(entry, findings=(*entry.findings, *_bias(entry, log, records)))
    told = _told_by(model, log, records)
    if told:
        told = (
            f"begun with --start {log.start} the model explains nothing of this log, and with --start {told} it does: "
            f"what the actuator did before decides here. Add --start {told}."
        )
        return replace(entry, findings=(*entry.findings, Finding("unknown-past", told)))
    return replace(entry, findings=(*entry.findings, Finding("unexplained", f"{why}.")))


def _not_explained(outputs: Sequence[Array], records: Sequence[Recording], log: _Log) -> str:
    """Why outputs have nothing to do with the log where it counts, the mean of each recording left out, or ""."""
    rest, response = [], []
    for index, (record, output) in enumerate(zip(records, outputs, strict=True)):
        counts = log.part.mask(index, len(record))
        error = (output - record.output)[counts]
        rest.append(error - error.mean() if error.size else error)
        response.append(record.output[counts] - (record.output[counts].mean() if error.size else 0.0))
    return unexplained(np.concatenate(rest), np.concatenate(response))


def _told_by(model: Model, log: _Log, records: Sequence[Recording]) -> str:
    """Return the past with which a model does explain a log, or ""."""
    inputs = [record.input for record in records]
    for start in PASTS:
        try:
            outputs = _answers(model, records, inputs, replace(log, start=start))
        except DehystError:  # a model that has no such start
            continue
        if not _not_explained(outputs, records, log):
            return start
    return ""


def _fitted(name: str, model: Model, records: Sequence[Recording]) -> list[Finding]:
    """Say where a log is no test of a model, as the model was fitted to it."""
    return [
        Finding(
            "fitted-log",
            f"{name} was fitted to {100.0 * share:.0f} % of these samples of {record.name}: its error on them "
            f"says less of use than that on another log. Score it on one that it was not identified from.",
        )
        for record, share in ((record, fitted_share(model, record)) for record in records)
        if share
    ]


def _outside(model: Model, records: Sequence[Recording]) -> list[Finding]:
    found = []
    for card, role in ((model.card.input, "input"), (model.card.output, "output")):
        if card.low is None or card.high is None or not card.high > card.low:
            continue
        values = np.concatenate([np.delete(getattr(record, role), record.left_out) for record in records])
        slack = BEYOND * (card.high - card.low)
        beyond = int(np.sum((values < card.low - slack) | (values > card.high + slack)))
        if beyond:
            unit = f" {card.unit}" if card.unit else ""
            found.append(
                Finding(
                    "outside-range",
                    f"the log's {role} leaves the identified range {card.low:z.4g} to {card.high:z.4g}{unit} at "
                    f"{beyond} of {values.size} samples (it spans {values.min():z.4g} to {values.max():z.4g}): the "
                    f"model extrapolates there, and is scored on it all the same. Identify on a log that covers it.",
                )
            )
    return found


def _forward(entry: Scored, log: _Log, records: Sequence[Recording]) -> Scored:
    model = entry.model
    if model.no_forward:
        return replace(entry, reason=f"no output: {model.no_forward}")
    try:
        outputs = _answers(model, records, [record.input for record in records], log)
    except DehystError as fault:
        return replace(entry, reason=f"no output: {fault}")
    measured = [record.output for record in records]
    span = robust_range(measured)
    if log.follow_offset is not None:
        outputs = _followed(model, records, outputs, log.follow_offset)
    found, within = score(tuple(records), outputs, log.part, span), _within(outputs, measured, log.part)
    return replace(
        entry,
        output=found,
        output_bias=log.part.moments(outputs, measured).mean,
        predictions=outputs,
        error_percent=100.0 * within / span,
    )


def _followed(model: Model, records: Sequence[Recording], outputs: Sequence[Array], limit: float) -> tuple[Array, ...]:
    """Outputs with an offset that follows the last cycle, begun anew in each piece."""
    inputs, measured = [record.input for record in records], [record.output for record in records]
    card = model.card
    numbers = offset_numbers(limit, width(card.output, range_over(measured)), width(card.input, range_over(inputs)))
    followed = []
    for record, output in zip(records, outputs, strict=True):
        moved = np.array(output)
        for piece in record.pieces:
            moved[piece] = following(record.input[piece], output[piece], record.output[piece], numbers)
        followed.append(moved)
    return tuple(followed)


def _backward(entry: Scored, log: _Log, records: Sequence[Recording]) -> Scored:
    model = entry.model
    if model.no_inverse:
        return replace(entry, reason=f"{entry.reason} no inverse: {model.no_inverse}".strip())
    try:
        asked = _answers(model.inverse(), records, [record.output for record in records], log)
        asked = tuple(model.ahead(demand) for demand in asked)
    except DehystError as fault:
        return replace(entry, reason=f"{entry.reason} no input: {fault}".strip())
    inputs, card = [record.input for record in records], model.card.input
    low, high = range_over(inputs) if card.low is None or card.high is None else (card.low, card.high)
    held = [np.clip(demand, low, high) for demand in asked]
    error, span = log.part.moments(held, inputs), robust_range(inputs)
    over = sum(int(np.count_nonzero(demand != kept)) for demand, kept in zip(asked, held, strict=True))
    return replace(
        entry,
        input=InputError(100.0 * error.rms / span, 100.0 * error.mean / span),
        input_percent=100.0 * _within(held, inputs, log.part) / span,
        clipped=over / max(1, sum(demand.size for demand in asked)),
        demands=asked,
    )


def _within(signals: Sequence[Array], measured: Sequence[Array], part: Part) -> float:
    """RMS of a difference without the mean of each recording: runs are offset against each other."""
    each = [part.moments(signals, measured, k) for k in range(len(measured))]
    squares = sum(moments.count * max(moments.square - moments.mean**2, 0.0) for moments in each)
    return float(np.sqrt(squares / max(sum(moments.count for moments in each), 1.0)))


def _answers(model: Model, records: Sequence[Recording], signals: Sequence[Array], log: _Log) -> tuple[Array, ...]:
    """Answers along each recording, piece by piece, each begun as the start says."""
    found = []
    for record, signal, given in zip(records, signals, log.given, strict=True):
        parts = []
        for piece in record.pieces:
            x = np.ascontiguousarray(signal[piece])
            time = None if record.time is None else np.ascontiguousarray(record.time[piece])
            held = {need: np.ascontiguousarray(given[need][piece]) for need in model.needs}
            if log.start == UNKNOWN:
                parts.append(model.band(x, time, model.usual_past, **held).middle)
            else:
                parts.append(begun(model, log.start, float(x[0])).simulate(x, time, **held))
        found.append(np.concatenate(parts))
    return tuple(found)


def _advice(entries: Sequence[Scored]) -> tuple[str | None, str]:
    """Which model to compensate with, and why: of those with an inverse the one whose output errs least."""
    able = [entry for entry in entries if entry.input is not None]
    if not able:
        return None, "no model has an inverse that could be run on this log; see the reasons."
    able = [entry for entry in able if grade_of(entry.model.card.provenance.get("verdict")) is not Grade.BAD]
    if not able:
        return None, (
            "no model should be run: when each was identified, the verdict was not to compensate with it. Identify "
            "again, from this log or a better one."
        )
    best = able[0]
    codes = {finding.code for finding in best.findings}
    if "unexplained" in codes:
        return None, (
            f"not even the best, {best.name}, has anything to do with this log: identify a model from it, or name the "
            f"right columns."
        )
    if best.output is None:
        best = min(able, key=lambda entry: rank(entry.input_percent))
        said = f"its inverse misses the input by {best.input_percent:.2f} % of range rms, and no model gives an output"
    else:
        errs = "errs least," if len(able) > 1 else "errs by"
        said = f"its output {errs} {best.error_percent:.2f} % of range rms without bias"
    other = min(able, key=lambda entry: rank(entry.input_percent))
    if len(able) > 1:
        next_best = next(entry for entry in able if entry is not best)
        if best.output is not None and next_best.output is not None:
            said += f", against {next_best.error_percent:.2f} % of {next_best.name}"
    if other is not best and rank(other.input_percent) < rank(best.input_percent):
        said += (
            f"; the inverse of {other.name} comes closer to the input, {other.input_percent:.2f} against "
            f"{best.input_percent:.2f} %, which says less about tracking"
        )
    first = next((entry for entry in entries if entry.output is not None), best)
    if first is not best and first.input is None:
        said += f"; {first.name} has no inverse"
    if best.input_percent > GOOD_PERCENT:
        said += (
            f". Its inverse misses the input by {best.input_percent:.2f} %, more than {GOOD_PERCENT:g} %: watch the "
            f"actuator, or identify from this log"
        )
    return best.name, f"{said}."
