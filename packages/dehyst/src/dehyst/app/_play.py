"""dehyst simulate and dehyst compensate: run a model or its inverse over a logged signal, from a start state."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dehyst.app._logs import (
    dead_time_findings,
    given_of,
    log_part,
    outside,
    seconds_ahead,
    verdict_findings,
)
from dehyst.app._play_coupled import play_coupled, write_columns
from dehyst.app._policy import POLICY
from dehyst.app._targets import BAND, place_of, refuse_existing
from dehyst.app._terminal import ask_progress, print_findings, tell
from dehyst.app.requests import CompensateRequest, SimulateRequest
from dehyst.arrays import Array
from dehyst.errors import ColumnError, OutputError, ParameterError, TimeError
from dehyst.findings import Finding
from dehyst.io import LogSignal, read_log, read_signal
from dehyst.models import Band, Model, SignalCard, load
from dehyst.models import kit as models_kit

COMPENSATED = "compensated"
EXTREMES = ", between an actuator at rest and strokes over the whole range"


def run_simulate(request: SimulateRequest) -> None:
    """Write time, input and the model's output."""
    if play_coupled(request):
        return
    model, signal = _read(request, "input")
    x, findings = models_kit.in_units_of(
        model.card.input, signal.values, signal.unit, f"'{signal.name}'"
    )
    findings += outside(x, model.card.input, "input", "the model extrapolates there")
    # A model that depends on rates was tested only at those of its log.
    findings += models_kit.faster_than_log(model, model.card.input, "the input", [(signal.time, x)])
    model, past_words = _after(request, model, float(x[0]))
    with ask_progress("simulating"):
        played = _noted(_played(request, model, signal, x, "model"), past_words)
    # A direct inverse is solved for its input, which may lie beyond its range.
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
    if play_coupled(request):
        return
    model, signal = _read(request, "output")
    # The verdict comes first in the warnings: whoever runs a bad inverse may break a machine.
    findings_of_verdict = verdict_findings(
        model, f"'{request.model}'", "Do not apply this input to a machine"
    )
    y, findings = models_kit.in_units_of(
        model.card.output, signal.values, signal.unit, f"'{signal.name}'"
    )
    card = model.card.output
    if request.wing is not None:
        card = model.wing(request.wing, y).card.output
    findings += outside(y, card, "reference", "the inverse extrapolates there")
    findings += models_kit.faster_than_log(
        model, model.card.output, "the reference", [(signal.time, y)]
    )
    model, past_words = _after(request, model, float(y[0]), backward=True)
    # What came before may have been on the other wing.
    if request.wing is not None:
        model = model.wing(request.wing)
    inverse = model.inverse()
    shaped, lead, about_shape = _shaped(request, model, signal, y)
    findings += about_shape
    with ask_progress("inverting"):
        if request.wing is not None and not past_words and _start(request) == models_kit.MODEL:
            end = {"upper": "highest", "lower": "lowest"}[request.wing]
            past_words = f"poled, over the whole range and from the {end} {model.card.input.name} to the first sample"
        played = _noted(_played(request, inverse, signal, shaped, COMPENSATED), past_words)
        if not request.unknown_state:
            findings += _proof(model, inverse, played, shaped)
    findings += outside(
        played.answer, model.card.input, "computed input", "the actuator may not be able to give it"
    )
    findings += _jumps(played.answer, y, model, signal)
    played, finding_of_dead_time = _sent_ahead(request, model, played, lead)
    findings += finding_of_dead_time
    _write(request, signal, {_column(model.card.output): y, **played.columns}, played)
    print_findings(
        [*findings_of_verdict, *_about(signal, "reference"), *findings, *played.findings],
        stderr=True,
    )


def _read(request: SimulateRequest, role: str) -> tuple[Model, LogSignal]:
    for target in (request.out, request.figure):
        if target is not None and place_of(target) in {
            place_of(request.log),
            place_of(request.model),
        }:
            raise OutputError(
                f"'{target}' is the log or the model itself; writing there would lose it. Name another file."
            )
    if request.figure is not None:
        from dehyst.report import require_picture_name

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
            signal = read_signal(request.log, column, run=request.run, **log_part(request))
    except ColumnError as fault:
        # The user chose the column, so that advice to choose one would not help.
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
    note: str
    findings: list[Finding]
    time: Array | None
    schedules: dict[str, Array]


def _played(
    request: SimulateRequest, model: Model, signal: LogSignal, x: Array, prefix: str
) -> _Played:
    """Run a model along its input, from the past that was asked for."""
    schedules, findings = given_of(request, model, signal)
    start, time, card, note = _start(request), signal.time, model.card.output, ""
    if time is None and model.rate_dependent:
        raise TimeError(
            f"'{request.model}' is a {model.family} model, which depends on time (creep or rate), and '{request.log}' "
            f"has no time column. Name it with --time, or add one.",
            log=str(request.log),
        )
    # A named past gives one answer; its doubt is what other pasts would change.
    if start != models_kit.UNKNOWN:
        answer = models_kit.begun(model, start, float(x[0])).simulate(x, time, **schedules)
        columns = {_column(card, prefix): answer}
        if prefix == COMPENSATED and model.bounded and request.begin is None:
            band = model.band(x, time, model.usual_past, **schedules)
            doubt = np.maximum(np.maximum(band.high - answer, answer - band.low), 0.0)
            note = f"{models_kit.ABOUT[start]}: {_doubted(doubt, card, signal)}"
            # A controller can use the doubt of each sample; where there is none a column of zeros would only confuse.
            if model.direction == "inverse" and np.any(doubt > 0.0):
                columns[_column(card, "doubt")] = doubt
    elif request.unknown_state:
        band = model.band(x, time, request.past, **schedules)
        answer, start = band.middle, ""
        columns = _band_columns(band, card, prefix, signal, request.figure)
        findings.append(_band_finding(band, model, prefix, signal))
    else:
        past = request.past or model.usual_past
        band = model.band(x, time, past, **schedules)
        answer, note = band.middle, _middle(band, past, model, signal)
        columns = {_column(card, prefix): answer}
        if model.direction == "inverse" and np.any(band.half_width > 0.0):
            columns[_column(card, "doubt")] = band.half_width
    # Where the output falls with the input, a rising output is a falling input.
    moved = {"rising": "rose", "falling": "fell"}
    if start in moved:
        note = f"{models_kit.ABOUT[start]}: it is {model.card.input.name} that {moved[start]}"
    return _Played(
        columns, answer, start, note or models_kit.ABOUT.get(start, ""), findings, time, schedules
    )


def _after(
    request: SimulateRequest, model: Model, first: float, backward: bool = False
) -> tuple[Model, str]:
    """Return the model that runs on after a log, and what to say about that; "" where there is none.

    `first` is the first input that follows; for a compensator the first output that is wanted.
    """
    if request.after is None:
        return model, ""
    typed = {
        "--start": request.begin is not None,
        "--unknown-state": request.unknown_state,
        "--past": request.past is not None,
    }
    others = [option for option, is_typed in typed.items() if is_typed]
    if others:
        raise ParameterError(
            f"--after tells the past by a log, and {' and '.join(others)} by a name or a range. Leave one of them out.",
            options=others,
        )
    card = model.card
    schedules = {signal.name: signal.name for signal in model.context}
    with ask_progress("reading"):
        record = read_log(
            request.after, card.input.name, card.output.name, time=request.time, run=request.run,
            time_unit=request.time_unit, dt=request.dt, sheet=request.sheet, schedules=schedules,
        )  # fmt: skip
    # Behind the last gap, where its memory is of one piece.
    piece = record.pieces[-1]
    part = slice(max(piece.start, piece.stop - POLICY.known_samples), piece.stop)
    x, findings = models_kit.in_units_of(
        card.input, record.input[part], record.input_unit, f"'{record.input_name}'"
    )
    y, more = models_kit.in_units_of(
        card.output, record.output[part], record.output_unit, f"'{record.output_name}'"
    )
    time = None if record.time is None else record.time[part]
    signals = record.signals(model.needs, part)
    known = models_kit.known_past(model, x, y, time, signals)
    low, high = card.output.low, card.output.high
    height = float(np.ptp(y))
    if low is not None and high is not None:
        height = high - low
    share = known.error / max(height, 1e-300)
    findings += more
    if share > POLICY.past_unexplained:
        findings.append(
            Finding(
                "past-unexplained",
                f"no past of this model explains {request.after}: the best one errs by {100 * share:.3g} % of the "
                f"output's range (rms) over its last {x.size} samples. It may be of another actuator, of other "
                f"columns or units. Name the log that was recorded just before, or leave --after out.",
            )
        )
    last = float((y if backward else x)[-1])
    apart = abs(first - last)
    span = height if backward else float(model.ends[1] - model.ends[0])
    if apart > POLICY.past_apart * span:
        role = card.output if backward else card.input
        findings.append(
            Finding(
                "past-apart",
                f"{request.after} ends at {role.label} {last:.4g}, and '{request.log}' begins at "
                f"{first:.4g}: what the actuator did between them is not known, and the memory is that of "
                f"one stroke. Name the log that ends where this one begins.",
            )
        )
    print_findings(findings, stderr=True)
    doubt = f"{known.doubt:.2g} {card.output.unit}".rstrip()
    words = (
        f"runs on after {request.after}: the memory agrees with its last {x.size} samples to {100 * share:.2g} % of "
        f"the output's range (rms); other pasts that do so, too, differ by up to {doubt}"
    )
    return known.model, words


def _noted(played: _Played, known: str) -> _Played:
    """What was played, with what is known of the past in place of what is assumed of it."""
    return replace(played, note=known, start="") if known else played


def _start(request: SimulateRequest) -> str:
    """Return the start that was asked for, by name or by an option of an unknown past; if none, the usual one."""
    option = ""
    if request.unknown_state:
        option = "--unknown-state"
    elif request.past is not None:
        option = "--past"
    # Who gives the range of an unknown past has said that it is unknown.
    usual = models_kit.UNKNOWN if option else models_kit.DEFAULT
    start = models_kit.check_start(request.begin or usual)
    if option and start != models_kit.UNKNOWN:
        raise ParameterError(
            f"{option} is for an actuator of whose past nothing is known, and the start '{start}' assumes one: "
            f"{models_kit.ABOUT[start]}. Leave out {option} or --start {start}."
        )
    return start


def _doubted(doubt: Array, card: SignalCard, signal: LogSignal) -> str:
    """How far an answer may be off if the actuator comes from elsewhere within the identified range."""
    if not np.any(doubt > 0.0):
        return "here no past within the identified range changes that"
    words = f"the first value may then be off by {doubt[0]:.3g} {card.unit}".rstrip()
    closed = np.flatnonzero(doubt <= POLICY.closed * float(np.max(doubt)))
    if closed.size:
        words += f", known from {_place(signal, int(closed[0]))} on"
    else:
        words += f", by {doubt[-1]:.3g} at the end"
    return f"{words}. --start unknown takes the middle of what is possible, which errs by least at worst"


def _middle(band: Band, past: tuple[float, float] | None, model: Model, signal: LogSignal) -> str:
    """Return what to say about the middle of what a model may answer after any past within a range."""
    width, card = band.half_width, model.card
    words = "what the actuator did before is not known: values are the middle of what they may be"
    if not model.bounded:
        words += EXTREMES
    elif past:
        words += f" after a past within {past[0]:.4g} to {past[1]:.4g} {card.input.unit}".rstrip()
    words += f"; the first may be off by {width[0]:.3g} {card.output.unit}".rstrip()
    closed = _closed_from(band)
    if closed is None:
        words += f", by {width[-1]:.3g} at the end"
    else:
        words += f", known from {_place(signal, closed)} on"
    return (
        f"{words}. If it never moved before, type --start rest; if it begins as the log did, model"
    )


def _column(card: SignalCard, prefix: str = "") -> str:
    """Name of a column: that of the signal with its unit."""
    if not prefix:
        return card.label
    return f"{prefix}_{card.label}"


def _band_columns(
    band: Band, card: SignalCard, prefix: str, signal: LogSignal, figure: Path | None
) -> dict[str, Array]:
    """Return columns middle, low, high and certainty; draw them if a picture is wanted.

    Nothing is known at the first sample, and nothing new is unknown at a gap: the memory is carried on across it.
    """
    # Drawing loads matplotlib, which most calls do not need.
    if figure is not None:
        from dehyst.report import kit as report_kit

        time, across = signal.time, "time [s]"
        if time is None:
            time, across = np.arange(signal.values.size, dtype=np.float64), "sample number"
        report_kit.write_band(
            figure, time, band.low, band.high, band.certainty, across, _column(card, prefix)
        )
    return {
        _column(card, prefix): 0.5 * (band.low + band.high),
        _column(card, f"{prefix}_low"): band.low,
        _column(card, f"{prefix}_high"): band.high,
        "certainty": band.certainty,
    }


def _band_finding(band: Band, model: Model, prefix: str, signal: LogSignal) -> Finding:
    """Say what was assumed of the past, and from when on it does not matter."""
    width, card = band.high - band.low, model.card.output
    assumed = "nothing was assumed of the past"
    if not model.bounded:
        assumed = f"the past is not known{EXTREMES}"
    unit = f" {card.unit}" if card.unit else ""
    closed = _closed_from(band)
    if closed is not None:
        end = f"it is known from {_place(signal, closed)} on"
    else:
        end = f"at the end it is still {0.5 * float(width[-1]):.3g}{unit}: begin with a stroke over the whole range"
    return Finding(
        "memory-unknown",
        f"{assumed}: the first value is known to {0.5 * float(width[0]):.3g}{unit} to either "
        f"side, and {end}. The column {_column(card, prefix)} is the middle of the band.",
    )


def _closed_from(band: Band) -> int | None:
    """Return the first sample from which on a band is a point; None if it stays open."""
    width = band.high - band.low
    closed = np.flatnonzero(width <= POLICY.closed * max(float(width[0]), 1e-300))
    if not closed.size:
        return None
    return int(closed[0])


def _place(signal: LogSignal, index: int) -> str:
    """Where a sample lies, in words."""
    if signal.time is None:
        return f"sample {index + 1}"
    return f"{signal.time[index]:.6g} s"


def _about(signal: LogSignal, role: str) -> list[Finding]:
    """Findings of reading, with what is done here at gaps: nothing is unknown to a computation, it just goes on."""
    if not signal.breaks:
        return list(signal.findings)
    first, count = signal.breaks[0], len(signal.breaks)
    span = f"between {_place(signal, first - 1)} and {_place(signal, first)}"
    gaps = f"{count} gaps, the first {span}"
    if count == 1:
        gaps = f"1 gap, {span}"
    # The finding of the reader says that a fit leaves the gap out, which is not true here.
    findings = [finding for finding in signal.findings if finding.code != "gap"]
    findings.append(
        Finding(
            "memory-carried",
            f"the {role} has {gaps}. The memory was carried on as if the "
            f"signal had moved directly from the last sample before to the first one after. If it turned in between, "
            f"the result is wrong from there until both extremes have been visited again. Fill the gap, or take one "
            f"side of it with --from and --to.",
        )
    )
    return findings


def _jumps(x: Array, y: Array, model: Model, signal: LogSignal) -> list[Finding]:
    """Steps of the computed input that no valve or amplifier follows from one sample to the next."""
    card = model.card.input
    if card.low is None or card.high is None or not card.high > card.low or x.size < 2:
        return []
    step = np.abs(np.diff(x))
    # Across a gap there was time to move.
    step[np.array(signal.breaks, dtype=np.int64) - 1] = 0.0
    share = step / (card.high - card.low)
    large = int(np.sum(share > POLICY.jump))
    if not large:
        return []
    k = int(np.argmax(step))
    unit = f" {card.unit}" if card.unit else ""
    # Only where the inverse is steeper than the reference does a bound of its slope help.
    steeper = share[k] > POLICY.steeper_jump * abs(y[k + 1] - y[k]) / max(float(np.ptp(y)), 1e-300)
    return [
        Finding(
            "input-jumps",
            f"the computed input jumps from one sample to the next by more than {100 * POLICY.jump:g} % of its "
            f"identified range at {large} of {step.size} steps; the largest, {step[k]:.4g}{unit} "
            f"({100 * share[k]:.3g} %), from {_place(signal, k)} to {_place(signal, k + 1)}. The actuator will lag "
            f"there. Smooth the reference or sample it more finely{_eps(model) if steeper else ''}.",
        )
    ]


SEND = "leave --ahead 0 out, or send each computed value that much before its time"


def _shaped(
    request: CompensateRequest, model: Model, signal: LogSignal, y: Array
) -> tuple[Array, float, list[Finding]]:
    """Return a reference that does not ring the actuator, by how much it was moved ahead [s], and what to say of it."""
    resonance = model.resonance
    time = signal.time
    if time is None:
        time = model.period * np.arange(y.size, dtype=np.float64)
    # A reference shorter than a swing has no time to ring.
    if resonance is None or y.size < 2 or time[-1] - time[0] < 2.0 * resonance.half_swing:
        return y, 0.0, []
    step = float(np.median(np.diff(time)))
    rings = f"the actuator rings at {resonance.frequency:.4g} Hz"
    spacing = resonance.spacing(step)
    if not spacing:
        finding = Finding(
            "resonance-too-fast",
            f"{rings}, and the reference has a sample every {step:.3g} s: too few to shape it, which takes one every "
            f"{0.25 / resonance.frequency:.2g} s. Sample it more finely.",
        )
        return y, 0.0, [finding]
    whole = resonance.share * spacing
    typed = seconds_ahead(request.ahead)
    lead = whole
    if typed is not None:
        lead = min(whole, max(0.0, typed - model.dead_time))
    late = ""
    if lead < whole:
        late = f" With --ahead {request.ahead} the output follows {whole - lead:.2g} s behind."
    finding = Finding(
        "reference-shaped",
        f"{rings}: the reference was split into two parts {spacing:.3g} s apart, whose swings cancel, so its corners "
        f"are rounded by that time. Let it begin with a rest.{late} To leave it as it is identify with --resonance "
        f"none.",
    )
    return resonance.shaped(y, time, lead), lead, [finding]


def _sent_ahead(
    request: CompensateRequest, model: Model, played: _Played, lead: float
) -> tuple[_Played, list[Finding]]:
    """Return computed values at the time when they have to be sent, and what to say about it.

    `lead` is by how much their reference was moved ahead already. [s]
    """
    typed = seconds_ahead(request.ahead)
    ahead = model.dead_time if typed is None else typed - lead
    if not ahead > 0.0:
        return played, dead_time_findings(model, SEND)
    if played.time is not None:
        time = played.time
    else:
        # Without time stamps the samples are those of the log that the model is from.
        if not model.period > 0.0:
            raise TimeError(
                f"--ahead {request.ahead} is a time in seconds, and '{request.log}' has no time column. Name it with "
                f"--time, give --dt, or leave --ahead out.",
                log=str(request.log),
            )
        time = model.period * np.arange(played.answer.size, dtype=np.float64)
    if ahead >= float(time[-1] - time[0]):
        raise ParameterError(
            f"each value is to be sent {ahead:.3g} s before its time (--ahead, in seconds), and the reference is "
            f"{time[-1] - time[0]:.3g} s long: nothing of it would be left. Give a longer reference, or --ahead 0.",
            ahead=ahead,
        )
    columns: dict[str, Array] = {}
    for name, values in played.columns.items():
        columns[name] = models_kit.earlier(values, time, ahead)
    why = f"as typed; the model's own dead time is {model.dead_time:.3g} s"
    if ahead == model.dead_time:
        why = "the dead time of the model"
    finding = Finding(
        "dead-time",
        f"each computed value stands {ahead:.3g} s before the output that it is for ({why}). The values of the first "
        f"{ahead:.3g} s are not there any more, so let the reference begin with a rest; the last one is held. For "
        f"values beside their outputs, as where only the sensor is late, type --ahead 0.",
    )
    return replace(played, columns=columns), [finding]


def _proof(model: Model, inverse: Model, played: _Played, y: Array) -> list[Finding]:
    """Run the model on the computed input: it must give the reference back, from the first sample on.

    Without its dead time, which no inverse undoes: values are sent ahead instead.
    """
    model = model.prompt
    # Some families have no exact inverse, so that no error can be called too large.
    if not math.isfinite(model.closeness):
        return []
    x = played.answer
    if played.start != models_kit.MODEL:
        # The model begins as it was identified: so must the inverse that it is compared with.
        x = inverse.simulate(y, played.time, **played.schedules)
    error = float(np.max(np.abs(model.replay(x, y, played.time, **played.schedules) - y)))
    low, high = model.card.output.low, model.card.output.high
    span = max(float(np.ptp(y)), 1e-300)
    # A reference that rests has no range of its own.
    if low is not None and high is not None:
        span = max(span, 1e-3 * (high - low))
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
    if isinstance(settings, dict) and "eps" in settings:
        return ", or raise --eps when identifying"
    return ""


def _write(
    request: SimulateRequest, signal: LogSignal, columns: dict[str, Array], played: _Played
) -> None:
    """Write time and columns to the file that was asked for, or to the terminal; say which start was taken.

    Nothing is said of the start where the band itself was asked for.
    """
    table: dict[str, npt.ArrayLike] = {}
    if signal.time is not None:
        table["time [s]"] = signal.time
    table |= columns
    write_columns(request, table)
    if played.note and not played.start and not request.unknown_state:
        tell(f"start: {played.note}")
    if played.start:
        tell(f"start: {played.start}, {played.note}")
