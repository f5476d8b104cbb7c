"""dehyst simulate and dehyst compensate: run a model or its inverse over a logged signal, from a start state."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dehyst.app.logs import dead_time_findings, given_of, outside, part_of, verdict_findings
from dehyst.app.requests import CompensateRequest, SimulateRequest
from dehyst.app.targets import BAND, place_of, refuse_existing
from dehyst.app.terminal import ask_progress, print_findings, tell
from dehyst.arrays import Array
from dehyst.errors import ColumnError, OutputError, ParameterError, TimeError
from dehyst.files import write_atomically
from dehyst.findings import Finding
from dehyst.io import Signal, format_csv, read_signal
from dehyst.models import Band, Model, ModelCard, SignalCard, load
from dehyst.models.card import in_units_of
from dehyst.models.speed import faster_than_log
from dehyst.models.start import ABOUT, DEFAULT, MODEL, UNKNOWN, begun, check_start

# A step of the computed input between two samples, as a share of the identified range, that is worth a warning.
JUMP = 0.1
# A jump is the inverse's, which a firmer eps lowers, where it is so many times that of the reference, of their ranges.
STEEPER = 2.0
# A band narrower than this share of its largest width has closed.
CLOSED = 1e-6
COMPENSATED = "compensated"


def run_simulate(request: SimulateRequest) -> None:
    """Write time, input and the model's output."""
    model, signal = _read(request, "input")
    x, findings = in_units_of(model.card.input, signal.values, signal.unit, f"'{signal.name}'")
    findings += outside(x, model.card.input, "input", "the model extrapolates there")
    findings += faster_than_log(model, model.card.input, "the input", [(signal.time, x)])
    with ask_progress("simulating"):
        played = _played(request, model, signal, x, "model")
    lost = model.lost(played.answer)
    if lost:
        findings.append(
            Finding(
                "outside-range",
                f"at {lost} of {x.size} samples no output within 10 % of the identified range needs the input given; "
                f"the end of the range was written. Scale the input, or identify on a log that covers it.",
            )
        )
    _write(request, signal, {_column(model.card.input): x, **played.columns}, played)
    print_findings([*_about(signal, "input"), *findings, *played.findings], stderr=True)


def run_compensate(request: CompensateRequest) -> None:
    """Write time, wanted output and the input that produces it."""
    model, signal = _read(request, "output")
    said = verdict_findings(model, f"'{request.model}'", "Do not apply this input to a machine")
    y, findings = in_units_of(model.card.output, signal.values, signal.unit, f"'{signal.name}'")
    findings += outside(y, model.card.output, "reference", "the inverse extrapolates there")
    findings += faster_than_log(model, model.card.output, "the reference", [(signal.time, y)])
    inverse = model.inverse()
    with ask_progress("inverting"):
        played = _played(request, inverse, signal, y, COMPENSATED)
        if not request.unknown_state:
            findings += _proof(model, inverse, played, y)
    findings += outside(played.answer, model.card.input, "computed input", "the actuator may not be able to give it")
    findings += [*_jumps(played.answer, y, model, signal), *dead_time_findings(model, SEND)]
    _write(request, signal, {_column(model.card.output): y, **played.columns}, played)
    print_findings([*said, *_about(signal, "reference"), *findings, *played.findings], stderr=True)


def _read(request: SimulateRequest, role: str) -> tuple[Model, Signal]:
    for target in (request.out, request.figure):
        if target is not None and place_of(target) in {place_of(request.log), place_of(request.model)}:
            raise OutputError(
                f"'{target}' is the log or the model itself; writing there would lose it. Name another file."
            )
    if request.figure is not None:
        from dehyst.report.svg import require_picture_name

        refuse_existing(require_picture_name(request.figure), request.overwrite, own=BAND)
        if not request.unknown_state:
            raise ParameterError(
                "--figure belongs to --unknown-state, which gives the band that the output lies in; add that, or leave "
                "it out."
            )
    model = load(request.model)
    column = request.column or getattr(model.card, role).name
    try:
        with ask_progress("reading"):
            signal = read_signal(request.log, column, run=request.run, **part_of(request))
    except ColumnError as fault:
        if request.column is not None:
            raise
        raise ColumnError(
            f"{fault}. It is the {role} of '{request.model}'; if another column holds that, add --{role} COLUMN.",
            **fault.facts,
        ) from None
    return model, signal


@dataclass(frozen=True)
class _Played:
    """What a model answers: columns, the answer alone, what was assumed of the past, and what to say about it."""

    columns: dict[str, Array]
    answer: Array
    start: str
    told: str
    findings: list[Finding]
    time: Array | None
    given: dict[str, Array]


def _played(request: SimulateRequest, model: Model, signal: Signal, x: Array, prefix: str) -> _Played:
    """Run a model along its input, from the past that was asked for."""
    given, findings = given_of(request, model, signal)
    start, time, card, told = _start(request), signal.time, model.card.output, ""
    if time is None and model.rate_dependent:
        raise TimeError(
            f"'{request.model}' is a {model.family} model, which depends on time (creep or rate), and '{request.log}' "
            f"has no time column. Name it with --time, or add one.",
            log=str(request.log),
        )
    if start != UNKNOWN:
        answer = begun(model, start, float(x[0])).simulate(x, time, **given)
        columns = {_column(card, prefix): answer}
        if prefix == COMPENSATED and model.bounded and request.begin is None:
            band = model.band(x, time, model.usual_past, **given)
            doubt = np.maximum(np.maximum(band.high - answer, answer - band.low), 0.0)
            told = f"{ABOUT[start]}: {_doubted(doubt, card, signal)}"
            if model.direction == "inverse" and np.any(doubt > 0.0):
                columns[_column(card, "doubt")] = doubt
    elif request.unknown_state:
        band = model.band(x, time, request.past, **given)
        answer, start = band.middle, ""
        columns = _band_columns(band, card, prefix, signal, request.figure)
        findings.append(_band_finding(band, card, prefix, signal))
    else:
        past = request.past or model.usual_past
        band = model.band(x, time, past, **given)
        answer, told = band.middle, _middle(band, past, model.card, signal)
        columns = {_column(card, prefix): answer}
        if model.direction == "inverse" and np.any(band.half_width > 0.0):
            columns[_column(card, "doubt")] = band.half_width
    return _Played(columns, answer, start, told or ABOUT.get(start, ""), findings, time, given)


def _start(request: SimulateRequest) -> str:
    """Return the start that was asked for, by name or by an option of an unknown past; if none, the usual one."""
    of_unknown = (("--unknown-state", request.unknown_state), ("--past", request.past is not None))
    options = [option for option, given in of_unknown if given]
    start = check_start(request.begin or (UNKNOWN if options else DEFAULT))
    if options and start != UNKNOWN:
        raise ParameterError(
            f"{options[0]} is for an actuator of whose past nothing is known, and the start '{start}' assumes one: "
            f"{ABOUT[start]}. Leave out {options[0]} or --start {start}."
        )
    return start


def _doubted(doubt: Array, card: SignalCard, signal: Signal) -> str:
    """How far an answer may be off if the actuator comes from elsewhere within the identified range."""
    if not np.any(doubt > 0.0):
        return "here no past within the identified range changes that"
    closed = np.flatnonzero(doubt <= CLOSED * float(np.max(doubt)))
    end = f"by {doubt[-1]:.3g} at the end" if not closed.size else f"known from {_place(signal, int(closed[0]))} on"
    first = f"the first value may then be off by {doubt[0]:.3g} {card.unit}".rstrip()
    return f"{first}, {end}. --start unknown takes the middle of what is possible, which errs by least at worst"


def _middle(band: Band, past: tuple[float, float] | None, card: ModelCard, signal: Signal) -> str:
    """Return what to say about the middle of what a model may answer after any past within a range."""
    width = band.half_width
    where = f" after a past within {past[0]:.4g} to {past[1]:.4g} {card.input.unit}".rstrip() if past else ""
    closed = _closed_from(band)
    end = f"by {width[-1]:.3g} at the end" if closed is None else f"known from {_place(signal, closed)} on"
    told = f"what the actuator did before is not known: values are the middle of what they may be{where}"
    first = f"the first may be off by {width[0]:.3g} {card.output.unit}".rstrip()
    return f"{told}; {first}, {end}. If it never moved before, type --start rest; if it begins as the log did, model"


def _column(card: SignalCard, prefix: str = "") -> str:
    """Name of a column: that of the signal with its unit."""
    return f"{prefix}_{card.label}" if prefix else card.label


def _band_columns(band: Band, card: SignalCard, prefix: str, signal: Signal, figure: Path | None) -> dict[str, Array]:
    """Return columns middle, low, high and certainty; draw them if a picture is wanted.

    Nothing is known at the first sample, and nothing new is unknown at a gap: the memory is carried on across it.
    """
    if figure is not None:
        from dehyst.report.pictures import write_band

        time, across = (signal.time, "time [s]") if signal.time is not None else (None, "sample number")
        time = np.arange(signal.values.size, dtype=np.float64) if time is None else time
        write_band(figure, time, band.low, band.high, band.certainty, across, _column(card, prefix))
    return {
        _column(card, prefix): 0.5 * (band.low + band.high),
        _column(card, f"{prefix}_low"): band.low,
        _column(card, f"{prefix}_high"): band.high,
        "certainty": band.certainty,
    }


def _band_finding(band: Band, card: SignalCard, prefix: str, signal: Signal) -> Finding:
    width = band.high - band.low
    unit = f" {card.unit}" if card.unit else ""
    closed = _closed_from(band)
    if closed is not None:
        end = f"it is known from {_place(signal, closed)} on"
    else:
        end = f"at the end it is still {0.5 * float(width[-1]):.3g}{unit}: begin with a stroke over the whole range"
    return Finding(
        "memory-unknown",
        f"nothing was assumed of the past: the first value is known to {0.5 * float(width[0]):.3g}{unit} to either "
        f"side, and {end}. The column {_column(card, prefix)} is the middle of the band.",
    )


def _closed_from(band: Band) -> int | None:
    """Return the first sample from which on a band is a point; None if it stays open."""
    width = band.high - band.low
    closed = np.flatnonzero(width <= CLOSED * max(float(width[0]), 1e-300))
    return int(closed[0]) if closed.size else None


def _place(signal: Signal, index: int) -> str:
    """Where a sample lies, in words."""
    return f"sample {index + 1}" if signal.time is None else f"{signal.time[index]:.6g} s"


def _about(signal: Signal, role: str) -> list[Finding]:
    """Findings of reading, with what is done here at gaps: nothing is unknown to a computation, it just goes on."""
    if not signal.breaks:
        return list(signal.findings)
    first, count = signal.breaks[0], len(signal.breaks)
    where = f"{'the first ' if count > 1 else ''}between {_place(signal, first - 1)} and {_place(signal, first)}"
    found = [finding for finding in signal.findings if finding.code != "gap"]
    return [
        *found,
        Finding(
            "memory-carried",
            f"the {role} has {count} gap{'s' if count > 1 else ''}, {where}. The memory was carried on as if the "
            f"signal had moved directly from the last sample before to the first one after. If it turned in between, "
            f"the result is wrong from there until both extremes have been visited again. Fill the gap, or take one "
            f"side of it with --from and --to.",
        ),
    ]


def _jumps(x: Array, y: Array, model: Model, signal: Signal) -> list[Finding]:
    """Steps of the computed input that no valve or amplifier follows from one sample to the next."""
    card = model.card.input
    if card.low is None or card.high is None or not card.high > card.low or x.size < 2:
        return []
    step = np.abs(np.diff(x))
    step[np.array(signal.breaks, dtype=np.int64) - 1] = 0.0  # across a gap there was time to move
    share = step / (card.high - card.low)
    large = int(np.sum(share > JUMP))
    if not large:
        return []
    k = int(np.argmax(step))
    unit = f" {card.unit}" if card.unit else ""
    steeper = share[k] > STEEPER * abs(y[k + 1] - y[k]) / max(float(np.ptp(y)), 1e-300)
    return [
        Finding(
            "input-jumps",
            f"the computed input jumps from one sample to the next by more than {100 * JUMP:g} % of its identified "
            f"range at {large} of {step.size} steps; the largest, {step[k]:.4g}{unit} ({100 * share[k]:.3g} %), from "
            f"{_place(signal, k)} to {_place(signal, k + 1)}. The actuator will lag there. Smooth the reference or "
            f"sample it more finely{_eps(model) if steeper else ''}.",
        )
    ]


SEND = "send each computed value that much before its time"


def _proof(model: Model, inverse: Model, played: _Played, y: Array) -> list[Finding]:
    """Run the model on the computed input: it must give the reference back, from the first sample on.

    Without its dead time, which no inverse undoes: `dead_time_findings` say what to do.
    """
    model = model.prompt
    if not math.isfinite(model.closeness):
        return []
    x = played.answer if played.start == MODEL else inverse.simulate(y, played.time, **played.given)
    error = float(np.max(np.abs(model.replay(x, y, played.time, **played.given) - y)))
    span = max(float(np.ptp(y)), 1e-300)
    if error <= model.closeness * span:
        return []
    return [
        Finding(
            "round-trip",
            f"the model's answer to the computed input differs from the reference by up to {error:.3g} "
            f"({100 * error / span:.2g} % of its range): the inverse loses digits here, or the model cannot reach it. "
            f"Keep the reference within the identified range{_eps(model)}.",
        )
    ]


def _eps(model: Model) -> str:
    """The cure of a model that was identified with a bound of its slope, for those."""
    settings = model.card.provenance.get("settings")
    bounded = isinstance(settings, dict) and "eps" in settings
    return ", or raise --eps when identifying" if bounded else ""


def _write(request: SimulateRequest, signal: Signal, columns: dict[str, Array], played: _Played) -> None:
    """Write time and columns to the file that was asked for, or to the terminal; say which start was taken.

    Nothing is said of the start where the band itself was asked for.
    """
    table: dict[str, npt.ArrayLike] = {} if signal.time is None else {"time [s]": signal.time}
    table |= columns
    text = format_csv(table, request.out or "the table")
    if request.out is None:
        sys.stdout.write(text)
    else:
        refuse_existing(request.out, request.overwrite, content=text)
        write_atomically(request.out, text)
        tell(f"wrote {request.out}: {', '.join(table)}")
    if played.start:
        tell(f"start: {played.start}, {played.told}")
