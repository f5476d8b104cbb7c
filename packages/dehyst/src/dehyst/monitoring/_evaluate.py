"""evaluate(): scores existing models of any family on a log they were not identified from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from dehyst.arrays import Array, rank
from dehyst.data import (
    Loops,
    Recording,
    counted_once,
    loops_of,
    range_over,
    refuse_repeated,
    require_recordings,
    robust_range,
    turning_points,
)
from dehyst.errors import DehystError, ParameterError
from dehyst.findings import Finding, Grade, grade_in
from dehyst.identification import POLICY, InputError, Score, known_from, mended
from dehyst.identification import kit as identification_kit
from dehyst.models import Model, SignalCard
from dehyst.models import kit as models_kit
from dehyst.monitoring._logs import fitted_share, recording_in_units_of, unexplained
from dehyst.monitoring._policy import POLICY as LIMITS
from dehyst.monitoring._result import as_dicts
from dehyst.units import convert


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
    loops
        The largest loops of the predictions, measured as those of the log are (`dehyst.data.measure_loops`); None
        where there is none.
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
    loops: Loops | None = None
    findings: tuple[Finding, ...] = ()

    @property
    def bias_percent(self) -> float:
        """Mean error of the output, percent of its range."""
        score = self.output
        if score is None or score.rmse == 0.0:
            return 0.0
        return self.output_bias * score.rmse_percent / score.rmse

    def as_dict(self) -> dict[str, Any]:
        """Return the row as printed by ``--json``."""
        output_error = input_error = None
        if self.output is not None:
            bias = {"bias_percent": self.bias_percent, "without_bias_percent": self.error_percent}
            output_error = self.output.as_dict() | bias
        if self.input is not None:
            input_error = self.input.as_dict() | {"without_bias_percent": self.input_percent}
        return {
            "name": self.name,
            "family": self.model.family,
            "direction": self.model.direction,
            "output_error": output_error,
            "input_error": input_error,
            "clipped": self.clipped,
            "numbers": self.loops and self.loops.summary,
            "reason": self.reason,
            "warnings": as_dicts(self.findings),
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
    loops
        The largest loops of the log, as measured; None where no loop closes.
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
    loops: Loops | None = None
    findings: tuple[Finding, ...] = ()

    def __getitem__(self, name: str) -> Scored:
        """Row of a model."""
        rows = {entry.name: entry for entry in self.entries}
        if name not in rows:
            raise ParameterError(f"'{name!s:.60}' is not among {', '.join(rows)}.", name=name)
        return rows[name]

    def as_dict(self) -> dict[str, Any]:
        """Return the evaluation as printed by ``dehyst evaluate --json``."""
        return {
            "models": as_dicts(self.entries),
            "run": self.run,
            "why": self.why,
            "samples": sum(map(len, self.recordings)),
            "numbers": self.loops and self.loops.summary,
            "warnings": as_dicts(self.findings),
        }


@dataclass(frozen=True, eq=False)
class _Log:
    """Recordings made ready, and which of their samples count."""

    records: tuple[Recording, ...]
    part: identification_kit.Part = field(default_factory=lambda: identification_kit.Part((), ()))
    follow_offset: float | None = None
    start: str = models_kit.DEFAULT


def evaluate(
    models: Model | Sequence[Model] | Mapping[str, Model],
    recordings: Recording | Sequence[Recording],
    *,
    follow_offset: float | None = None,
    start: str = models_kit.DEFAULT,
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
        Past of the actuator, one of `dehyst.models._start.STARTS`: "model", as the log began that it was identified
        from, "rest", "rising", "falling", "unknown"; or "known": the past that agrees best with the first tenth of each
        piece, which then does not count.

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
    low, high = range_over(_inputs(records))
    # Samples before the input was at both ends tell more of the past than of the model.
    models_kit.check_start(start, (models_kit.KNOWN,))
    part, assumed = _counting(records, low, high, start)
    log = _Log(records, part, follow_offset, start)
    entries = [_scored(name, model, log) for name, model in named.items()]
    entries.sort(key=lambda entry: rank(entry.error_percent))
    run, why = _advice(entries)
    loops = loops_of(records, largest_only=True)
    return Evaluation(tuple(entries), records, run, why, loops, (*_about(records), *assumed))


def _named(models: Model | Sequence[Model] | Mapping[str, Model]) -> dict[str, Model]:
    """Models by name; a model without one is called by its family, and numbered where there are several."""
    expected = (
        "models, such as fit.model or dehyst.load('model.json'), in a list or by name in a dict"
    )
    by_name: dict[str, Model] = {}
    if isinstance(models, Mapping):
        for name, entry in models.items():
            by_name[str(name)] = models_kit.require_model(entry, expected)
    elif isinstance(models, list | tuple) and len(models) > 1:
        for number, entry in enumerate(models, 1):
            model = models_kit.require_model(entry, expected)
            by_name[f"{number}: {model.family}"] = model
    else:
        listed: Sequence[Any] = (models,)
        if isinstance(models, list | tuple):
            listed = models
        for entry in listed:
            model = models_kit.require_model(entry, expected)
            by_name[model.family] = model
    if not by_name:
        raise ParameterError(f"there is no model. Pass {expected}.")
    return by_name


def _counting(
    records: tuple[Recording, ...], low: float, high: float, start: str
) -> tuple[identification_kit.Part, list[Finding]]:
    """Samples that count: those after both ends were visited, where that leaves half of the log, and not left out.

    Otherwise all of each first piece counts, and what a piece after a gap did before is no part of any score either.
    """
    counted = 0
    known_spans: list[list[slice]] = []
    for record in records:
        spans = []
        for piece in record.pieces:
            begin = min(piece.start + known_from(record.input[piece], low, high), piece.stop)
            if start == models_kit.KNOWN:
                begin = piece.start + _telling(piece)
            spans.append(slice(begin, piece.stop))
            counted += piece.stop - begin
        known_spans.append(spans)
    assumed = 2 * counted < sum(map(len, records))
    weights: list[Array | None] = []
    for record, spans in zip(records, known_spans, strict=True):
        if assumed:
            # Too little would be left: the start that was named stands in for what nobody knows.
            spans[0] = record.pieces[0]
        weight = None
        if record.left_out:
            weight = np.ones(len(record))
            weight[list(record.left_out)] = 0.0
        weights.append(weight)
    part = identification_kit.Part(tuple(map(tuple, known_spans)), tuple(weights))
    if not assumed:
        return part, []
    return part, [_start_counts(low, high, start)]


def _telling(piece: slice) -> int:
    """Number of samples at the beginning of a piece that tell its past."""
    size: int = piece.stop - piece.start
    return max(1, round(LIMITS.telling * size))


def _start_counts(low: float, high: float, start: str) -> Finding:
    """Say that all of the log counts, so that the past of the actuator is part of the error."""
    options = " or ".join(f"--start {past}" for past in models_kit.PASTS if past != start)
    return Finding(
        "start-counts",
        f"the log goes over the whole range of its input, {low:.4g} to {high:.4g}, late or never: all of it "
        f"counts, and what a model errs by may be the past, which was taken to be as --start {start} says. If you "
        f"know it, name it: {options}. Otherwise log a stroke over the whole range first.",
    )


def _about(records: tuple[Recording, ...]) -> list[Finding]:
    """What stands against the log itself."""
    findings: list[Finding] = []
    turns = 0
    for record in records:
        findings += record.findings
        for piece in record.pieces:
            turns += int(turning_points(record.input[piece]).size)
    if turns < LIMITS.few_turns:
        samples = sum(map(len, records))
        findings.append(
            Finding(
                "log-too-short",
                f"the input turns {turns} times in {samples} samples, less than one closed loop: errors are those of "
                f"this stroke, and say little about use. Log at least {LIMITS.few_turns} reversals, better the motion "
                f"of use.",
            )
        )
    return findings


def _bias(entry: Scored, log: _Log, records: Sequence[Recording]) -> list[Finding]:
    """Say where the output is off by a constant, and whether the past, which nobody knows, can be why."""
    bias = entry.bias_percent
    if entry.output is None or log.follow_offset is not None or abs(bias) <= LIMITS.shifts:
        return []
    shifts = _shifts(entry, log, records)
    low, high = min(shifts.values(), default=0.0), max(shifts.values(), default=0.0)
    side = "below"
    if bias > 0:
        side = "above"
    size = f"{abs(entry.output_bias):.3g}{_unit(entry.model.card.output)}"
    seen = f"the output of {entry.name} lies {abs(bias):.3g} % of range ({size}) {side} that of the log, in the mean"
    # Where another past moves the output by as much, nobody can blame the model or the sensor.
    if high - low > LIMITS.shifts and low - LIMITS.shifts <= -bias <= high + LIMITS.shifts:
        could = f"what the actuator did before the log moves it by {low:+.2g} to {high:+.2g} %"
        return [_unknown_past(entry, shifts, f"{seen}; {could}")]
    if abs(bias) <= POLICY.good_percent:
        return []
    # The sensor's zero moves an output by a constant; another actuator has another gain or shape as well.
    gain, left = _gain(entry, log, records)
    wanders = entry.error_percent > LIMITS.constant_bias * abs(bias)
    if wanders or (entry.error_percent > LIMITS.shifts and left < LIMITS.constant_bias):
        scaled = (
            f"times {gain:.3g} and moved, it would be off by {left * entry.error_percent:.2g} %"
        )
        return [
            Finding(
                "offset",
                f"{seen}, and by {entry.error_percent:.3g} % rms beside that; {scaled}: it is no mere constant, so "
                f"this model is not that of the actuator as it is now. Identify from this log.",
            )
        ]
    moved = ""
    if shifts:
        moved = f" (pasts move it by {low:+.2g} to {high:+.2g} %)"
    return [
        Finding(
            "offset",
            f"{seen}, and no past of the actuator explains that{moved}: the zero of the sensor, the load or the "
            f"temperature is another one, which this log cannot tell apart. Input errors hold it, too. Zero the sensor "
            f"as in the identified log, or subtract the offset from the reference.",
        )
    ]


def _unknown_past(entry: Scored, shifts: Mapping[str, float], seen: str) -> Finding:
    """Say that a bias may come from what the actuator did before the log, and which past would explain it."""
    bias = entry.bias_percent
    stroke = "{:.4g} to {:.4g}".format(*entry.model.ends)
    if abs(bias) <= POLICY.good_percent:
        return Finding(
            "unknown-past",
            f"{seen}, and the log does not tell. Log a stroke over {stroke} first.",
        )
    pasts = (*models_kit.PASTS, models_kit.KNOWN)
    best = min(pasts, key=lambda start: abs(bias + shifts.get(start, np.inf)))
    nearest = f"--start {best} leaves {bias + shifts[best]:+.2g} %"
    return Finding(
        "unknown-past",
        f"{seen}, which is enough for that: {nearest}. A model is not to blame for a past that it was "
        f"not told. Say how the actuator came there (--start), or log a stroke over {stroke} first.",
    )


def _unit(card: SignalCard) -> str:
    """Unit of a signal as it stands behind a number, or ""."""
    if not card.unit:
        return ""
    return f" {card.unit}"


def _gain(entry: Scored, log: _Log, records: Sequence[Recording]) -> tuple[float, float]:
    """Factor of the output that fits the log best beside a constant, and the share of the error that it leaves."""
    predicted_parts, measured_parts = [], []
    for index, (record, prediction) in enumerate(zip(records, entry.predictions, strict=True)):
        mask = log.part.mask(index, len(record))
        if np.any(mask):
            predicted_parts.append(_centred(prediction[mask]))
            measured_parts.append(_centred(record.output[mask]))
    predicted, measured = np.concatenate(predicted_parts), np.concatenate(measured_parts)
    square = float(predicted @ predicted)
    error = float(np.sum((measured - predicted) ** 2))
    if square == 0.0 or error == 0.0:
        return 1.0, 1.0
    gain = float(predicted @ measured) / square
    return gain, float(np.sqrt(np.sum((measured - gain * predicted) ** 2) / error))


def _centred(values: Array) -> Array:
    """Values less their mean; nothing stays nothing."""
    if not values.size:
        return values
    return np.asarray(values - values.mean())


def _shifts(entry: Scored, log: _Log, records: Sequence[Recording]) -> dict[str, float]:
    """By how much each other past moves the output where it counts, in the mean, percent of range."""
    if entry.output is None or not entry.output.rmse > 0.0:
        return {}
    percent = entry.output.rmse_percent / entry.output.rmse
    shifts: dict[str, float] = {}
    for start in (*models_kit.PASTS, models_kit.KNOWN):
        try:
            outputs = _answers(entry.model, records, _inputs(records), replace(log, start=start))
        except DehystError:  # a model that has no such start
            continue
        shifts[start] = percent * log.part.moments(outputs, entry.predictions).mean
    if entry.model.bounded and entry.model.direction == "forward":
        lowest, highest = _bounds(entry.model, records)
        shifts["lowest"] = percent * log.part.moments(lowest, entry.predictions).mean
        shifts["highest"] = percent * log.part.moments(highest, entry.predictions).mean
    return shifts


def _inputs(records: Sequence[Recording]) -> list[Array]:
    return [record.input for record in records]


def _outputs(records: Sequence[Recording]) -> list[Array]:
    return [record.output for record in records]


def _bounds(model: Model, records: Sequence[Recording]) -> tuple[list[Array], list[Array]]:
    """Least and largest output after any past within the identified range, along each recording."""
    lows, highs = [], []
    for record in records:
        low, high = np.empty(len(record)), np.empty(len(record))
        for piece in record.pieces:
            band = model.band(np.ascontiguousarray(record.input[piece]), past=model.usual_past)
            low[piece], high[piece] = band.low, band.high
        lows.append(low)
        highs.append(high)
    return lows, highs


def _scored(name: str, model: Model, log: _Log) -> Scored:
    """One model on the log, or why it cannot be scored there."""
    records: list[Recording] = []
    findings: list[Finding] = []
    for record in log.records:
        changed, unit_findings, why = recording_in_units_of(
            record, (model.card.input, model.card.output), model.context
        )
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
        findings += unit_findings
    for need in model.needs:
        if any(need not in record.schedules for record in records):
            why = f"the model depends on '{need}', which the log does not name: --schedule {need}=COLUMN."
            return Scored(name, model, reason=why)
    findings += _fitted(name, model, log.records) + _outside(model, records)
    moves = [(record.time, record.input) for record in records]
    findings += models_kit.faster_than_log(model, model.card.input, "the input of the log", moves)
    entry = _forward(Scored(name, model, findings=tuple(findings)), log, records)
    entry = _backward(entry, log, records)
    if entry.output is None:
        return entry
    more = _unexplained(entry, log, records) or _bias(entry, log, records)
    return replace(entry, findings=(*entry.findings, *more))


def _unexplained(entry: Scored, log: _Log, records: Sequence[Recording]) -> list[Finding]:
    """Say where the outputs of a model have nothing to do with the log, and whether another past mends that."""
    why = _not_explained(entry.predictions, records, log)
    if not why:
        return []
    past = _explaining_past(entry.model, log, records)
    if not past:
        return [Finding("unexplained", f"{why}.")]
    return [
        Finding(
            "unknown-past",
            f"begun with --start {log.start} the model explains nothing of this log, and with --start {past} it does: "
            f"what the actuator did before decides here. Add --start {past}.",
        )
    ]


def _not_explained(outputs: Sequence[Array], records: Sequence[Recording], log: _Log) -> str:
    """Why outputs have nothing to do with the log where it counts, the mean of each recording left out, or ""."""
    remainders, responses = [], []
    for index, (record, output) in enumerate(zip(records, outputs, strict=True)):
        counts = log.part.mask(index, len(record))
        remainders.append(_centred((output - record.output)[counts]))
        responses.append(_centred(record.output[counts]))
    return unexplained(np.concatenate(remainders), np.concatenate(responses))


def _explaining_past(model: Model, log: _Log, records: Sequence[Recording]) -> str:
    """Return the past with which a model does explain a log, or ""."""
    for start in (*models_kit.PASTS, models_kit.KNOWN):
        try:
            outputs = _answers(model, records, _inputs(records), replace(log, start=start))
        except DehystError:  # a model that has no such start
            continue
        if not _not_explained(outputs, records, log):
            return start
    return ""


def _fitted(name: str, model: Model, records: Sequence[Recording]) -> list[Finding]:
    """Say where a log is no test of a model, as the model was fitted to it."""
    findings = []
    for record in records:
        share = fitted_share(model, record)
        if share:
            findings.append(
                Finding(
                    "fitted-log",
                    f"{name} was fitted to {100.0 * share:.0f} % of these samples of {record.name}: its error on them "
                    f"says less of use than that on another log. Score it on one that it was not identified from.",
                )
            )
    return findings


def _outside(model: Model, records: Sequence[Recording]) -> list[Finding]:
    """Say where input or output leave the range that a model was identified in."""
    findings = []
    for card, role in ((model.card.input, "input"), (model.card.output, "output")):
        if card.low is None or card.high is None or not card.high > card.low:
            continue
        # Outliers that were left out would make every log leave the range.
        counted = []
        for record in records:
            counted.append(np.delete(getattr(record, role), record.left_out))
        values = np.concatenate(counted)
        slack = LIMITS.evaluated_beyond * (card.high - card.low)
        beyond = int(np.sum((values < card.low - slack) | (values > card.high + slack)))
        if beyond:
            limits = f"{card.low:z.4g} to {card.high:z.4g}{_unit(card)}"
            findings.append(
                Finding(
                    "outside-range",
                    f"the log's {role} leaves the identified range {limits} at "
                    f"{beyond} of {values.size} samples (it spans {values.min():z.4g} to {values.max():z.4g}): the "
                    f"model extrapolates there, and is scored on it all the same. Identify on a log that covers it.",
                )
            )
    return findings


def _forward(entry: Scored, log: _Log, records: Sequence[Recording]) -> Scored:
    """Add the errors of a model's output, or why there is none."""
    model = entry.model
    if model.no_forward:
        return replace(entry, reason=f"no output: {model.no_forward}")
    try:
        outputs = _answers(model, records, _inputs(records), log)
    except DehystError as fault:
        return replace(entry, reason=f"no output: {fault}")
    measured = _outputs(records)
    # The range is a robust one: a single outlier would make all errors look small.
    span = robust_range(measured)
    if log.follow_offset is not None:
        outputs = _followed(model, records, outputs, log.follow_offset)
    predicted = []
    for logged, output in zip(log.records, outputs, strict=True):
        # In the units of the log, so that its loops stand beside those that were measured.
        source, target = model.card.output.unit, logged.output_unit
        if source and target:
            output = convert(output, source, target)
        predicted.append(replace(logged, output=output))
    return replace(
        entry,
        output=identification_kit.score(tuple(records), outputs, log.part, span),
        output_bias=log.part.moments(outputs, measured).mean,
        predictions=outputs,
        error_percent=100.0 * _within(outputs, measured, log.part) / span,
        loops=loops_of(predicted, largest_only=True),
    )


def _followed(
    model: Model, records: Sequence[Recording], outputs: Sequence[Array], limit: float
) -> tuple[Array, ...]:
    """Outputs with an offset that follows the last cycle, begun anew in each piece."""
    card = model.card
    numbers = models_kit.offset_numbers(
        limit,
        models_kit.range_width(card.output, range_over(_outputs(records))),
        models_kit.range_width(card.input, range_over(_inputs(records))),
    )
    followed = []
    for record, output in zip(records, outputs, strict=True):
        moved = np.array(output)
        for piece in record.pieces:
            moved[piece] = models_kit.following(
                record.input[piece], output[piece], record.output[piece], numbers
            )
        followed.append(moved)
    return tuple(followed)


def _backward(entry: Scored, log: _Log, records: Sequence[Recording]) -> Scored:
    """Add the errors of the input that a model's inverse asks for, or why there is none."""
    model = entry.model
    if model.no_inverse:
        return replace(entry, reason=f"{entry.reason} no inverse: {model.no_inverse}".strip())
    try:
        answers = _answers(model, records, _outputs(records), log, backward=True)
        demands = tuple(map(model.ahead, answers))
    except DehystError as fault:
        return replace(entry, reason=f"{entry.reason} no input: {fault}".strip())
    inputs, card = _inputs(records), model.card.input
    low, high = card.low, card.high
    if low is None or high is None:
        low, high = range_over(inputs)
    # What leaves the identified range is limited in use, too.
    limited, clipped, samples = [], 0, 0
    for demand in demands:
        within = np.clip(demand, low, high)
        limited.append(within)
        clipped += int(np.count_nonzero(demand != within))
        samples += demand.size
    error, span = log.part.moments(limited, inputs), robust_range(inputs)
    return replace(
        entry,
        input=InputError(100.0 * error.rms / span, 100.0 * error.mean / span),
        input_percent=100.0 * _within(limited, inputs, log.part) / span,
        clipped=clipped / max(1, samples),
        demands=demands,
    )


def _within(
    signals: Sequence[Array], measured: Sequence[Array], part: identification_kit.Part
) -> float:
    """RMS of a difference without the mean of each recording: runs are offset against each other."""
    squares, count = 0.0, 0.0
    for index in range(len(measured)):
        moments = part.moments(signals, measured, index)
        squares += moments.count * max(moments.square - moments.mean**2, 0.0)
        count += moments.count
    return float(np.sqrt(squares / max(count, 1.0)))


def _answers(
    model: Model,
    records: Sequence[Recording],
    signals: Sequence[Array],
    log: _Log,
    backward: bool = False,
) -> tuple[Array, ...]:
    """Answers along each recording, piece by piece, each begun as the start says; of the inverse, if `backward`."""
    answers = []
    for record, signal in zip(records, signals, strict=True):
        answer = []
        for piece in record.pieces:
            x = np.ascontiguousarray(signal[piece])
            time = None
            if record.time is not None:
                time = np.ascontiguousarray(record.time[piece])
            needs = record.signals(model.needs, piece)
            begun = model
            if log.start == models_kit.KNOWN:
                begun = _known(model, record, piece)
            if backward:
                begun = begun.inverse()
            if log.start == models_kit.UNKNOWN:
                answer.append(begun.band(x, time, begun.usual_past, **needs).middle)
                continue
            if log.start != models_kit.KNOWN:
                begun = models_kit.begun(begun, log.start, float(x[0]))
            answer.append(begun.simulate(x, time, **needs))
        answers.append(np.concatenate(answer))
    return tuple(answers)


def _known(model: Model, record: Recording, piece: slice) -> Model:
    """Return a model with the past that agrees best with the first samples of a piece."""
    first = slice(piece.start, piece.start + _telling(piece))
    time = None
    if record.time is not None:
        time = record.time[first]
    needs = record.signals(model.needs, first)
    known = models_kit.known_past(model, record.input[first], record.output[first], time, needs)
    return known.before


def _advice(entries: Sequence[Scored]) -> tuple[str | None, str]:
    """Which model to compensate with, and why: of those with an inverse the one whose output errs least."""
    # A good score here does not overrule the verdict of the identification, which saw more.
    invertible, able = [], []
    for entry in entries:
        if entry.input is None:
            continue
        invertible.append(entry)
        if grade_in(entry.model.card.provenance) is not Grade.BAD:
            able.append(entry)
    winged = next((entry for entry in entries if entry.model.winged and entry.output), None)
    if not invertible and winged is not None:
        return winged.name, (
            f"its output errs by {winged.error_percent:.2f} % of range rms without bias. It compensates on one wing, "
            f"which a log over both cannot score."
        )
    if not invertible:
        return None, "no model has an inverse that could be run on this log; see the reasons."
    if not able:
        return None, (
            "no model should be run: when each was identified, the verdict was not to compensate with it. Identify "
            "again, from this log or a better one."
        )
    best = able[0]
    if any(finding.code == "unexplained" for finding in best.findings):
        return None, (
            f"not even the best, {best.name}, has anything to do with this log: identify a model from it, or name the "
            f"right columns."
        )
    closest = min(able, key=lambda entry: rank(entry.input_percent))
    if best.output is None:
        best = closest
        why = f"its inverse misses the input by {best.input_percent:.2f} % of range rms, and no model gives an output"
    elif len(able) > 1:
        why = f"its output errs least, {best.error_percent:.2f} % of range rms without bias"
        if able[1].output is not None:
            why += f", against {able[1].error_percent:.2f} % of {able[1].name}"
    else:
        why = f"its output errs by {best.error_percent:.2f} % of range rms without bias"
    if closest is not best and rank(closest.input_percent) < rank(best.input_percent):
        why += (
            f"; the inverse of {closest.name} comes closer to the input, {closest.input_percent:.2f} against "
            f"{best.input_percent:.2f} %, which says less about tracking"
        )
    # Entries are in the order of their output errors: one that is better than `best` can only simulate.
    first = next((entry for entry in entries if entry.output is not None), best)
    if first is not best and first.input is None:
        why += f"; {first.name} has no inverse"
    if best.input_percent > POLICY.good_percent:
        why += (
            f". Its inverse misses the input by {best.input_percent:.2f} %, more than {POLICY.good_percent:g} %: watch "
            f"the actuator, or identify from this log"
        )
    return best.name, f"{why}."
