"""dehyst simulate and dehyst compensate: a model or its inverse over a logged signal."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.app.context import given_of, outside, verdict_findings
from dehyst.app.requests import SimulateRequest
from dehyst.app.start import (
    MODEL,
    REST,
    UNKNOWN,
    band_columns,
    column,
    middle_of,
    place,
    refuse_without_unknown_state,
    say,
    start_of,
)
from dehyst.app.targets import refuse_existing
from dehyst.app.terminal import print_findings, tell
from dehyst.arrays import Array
from dehyst.errors import ColumnError, OutputError, TimeError
from dehyst.files import write_atomically
from dehyst.findings import Finding
from dehyst.io import Signal, format_csv, read_signal
from dehyst.models import Model, load
from dehyst.models.card import in_units_of

# A step of the computed input between two samples, as a share of the identified range, that is worth a word.
JUMP = 0.1


def run_simulate(request: SimulateRequest) -> None:
    """Write time, input and the model's output."""
    model, signal = _read(request, "input")
    x, findings = in_units_of(model.card.input, signal.values, signal.unit, f"'{signal.name}'")
    findings += outside(x, model.card.input, "input", "the model extrapolates there")
    played = _played(request, model, signal, x, "model", MODEL)
    lost = model.lost(played.answer)
    if lost:
        findings.append(
            Finding(
                "outside-range",
                f"at {lost} of {x.size} samples no output within 10 % of the identified range needs the input given; "
                f"the end of the range was written. Scale the input, or identify on a log that covers it.",
            )
        )
    write(request, signal, {column(model.card.input): x, **played.columns})
    say(played.start, played.told)
    print_findings([*about(signal, "input"), *findings, *played.findings], stderr=True)


def run_compensate(request: SimulateRequest) -> None:
    """Write time, wanted output and the input that produces it."""
    model, signal = _read(request, "output")
    said = verdict_findings(model, f"'{request.model}'", "Do not apply this input to a machine")
    y, findings = in_units_of(model.card.output, signal.values, signal.unit, f"'{signal.name}'")
    findings += outside(y, model.card.output, "reference", "the inverse extrapolates there")
    inverse = model.inverse()
    played = _played(request, inverse, signal, y, "compensated", UNKNOWN if inverse.bounded else REST)
    if not request.unknown_state:
        findings += _proof(model, inverse, played, y)
    findings += outside(played.answer, model.card.input, "computed input", "the actuator may not be able to give it")
    findings += jumps(played.answer, model, signal)
    write(request, signal, {column(model.card.output): y, **played.columns})
    say(played.start, played.told)
    print_findings([*said, *about(signal, "reference"), *findings, *played.findings], stderr=True)


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


def _played(request: SimulateRequest, model: Model, signal: Signal, x: Array, prefix: str, default: str) -> _Played:
    """Run a model along its input, from the past that was asked for."""
    given, findings = given_of(request, model, signal)
    start, time, card, told = start_of(request, default), _time(request, model, signal), model.card.output, ""
    if start != UNKNOWN:
        begun = model.at_rest(float(x[0])) if start == REST else model
        answer = begun.simulate(x, time, **given)
        columns = {column(card, prefix): answer}
    elif request.unknown_state:
        band = model.band(x, time, request.past, **given)
        answer, start = band.middle, ""
        columns, more = band_columns(band, card, prefix, signal, request.figure)
        findings += more
    else:
        past = request.past or model.usual_past
        band = model.band(x, time, past, **given)
        answer, told = band.middle, middle_of(band, past, model.card, signal)
        columns = {column(card, prefix): answer}
        if model.direction == "inverse" and np.any(band.half_width > 0.0):
            columns[column(card, "doubt")] = band.half_width
    return _Played(columns, answer, start, told, findings, time, given)


def _read(request: SimulateRequest, role: str) -> tuple[Model, Signal]:
    _refuse_sources(request)
    refuse_without_unknown_state(request.unknown_state, request.figure, request.overwrite)
    model = load(request.model)
    try:
        signal = read_signal(
            request.log,
            request.column or getattr(model.card, role).name,
            time=request.time,
            run=request.run,
            start=request.start,
            stop=request.stop,
            time_unit=request.time_unit,
        )
    except ColumnError as fault:
        if request.column is not None:
            raise
        raise ColumnError(
            f"{fault}. It is the {role} of '{request.model}'; if another column holds that, add --{role} COLUMN.",
            **fault.facts,
        ) from None
    return model, signal


def _time(request: SimulateRequest, model: Model, signal: Signal) -> Array | None:
    if signal.time is None and model.rate_dependent:
        raise TimeError(
            f"'{request.model}' is a {model.family} model, which depends on time (creep or rate), and '{request.log}' "
            f"has no time column. Name it with --time, or add one.",
            log=str(request.log),
        )
    return signal.time


def about(signal: Signal, role: str) -> list[Finding]:
    """Findings of reading, with what is done here at gaps: nothing is unknown to a computation, it just goes on."""
    if not signal.breaks:
        return list(signal.findings)
    first, count = signal.breaks[0], len(signal.breaks)
    where = f"{'the first ' if count > 1 else ''}between {place(signal, first - 1)} and {place(signal, first)}"
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


def jumps(x: Array, model: Model, signal: Signal) -> list[Finding]:
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
    return [
        Finding(
            "input-jumps",
            f"the computed input jumps from one sample to the next by more than {100 * JUMP:g} % of its identified "
            f"range at {large} of {step.size} steps; the largest, {step[k]:.4g}{unit} ({100 * share[k]:.3g} %), from "
            f"{place(signal, k)} to {place(signal, k + 1)}. The actuator will lag there. Smooth the reference or "
            f"sample it more finely{_eps(model)}.",
        )
    ]


def _proof(model: Model, inverse: Model, played: _Played, y: Array) -> list[Finding]:
    """Run the model on the computed input: it must give the reference back, from the first sample on."""
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


def _refuse_sources(request: SimulateRequest) -> None:
    """Refuse to write over the log or the model, whatever option is given."""
    out = request.out
    for target in (out, request.figure):
        if target is not None and target.resolve() in {request.log.resolve(), request.model.resolve()}:
            raise OutputError(
                f"'{target}' is the log or the model itself; writing there would lose it. Name another file."
            )


def write(request: SimulateRequest, signal: Signal, columns: dict[str, Array]) -> None:
    """Write time and columns to the file that was asked for, or to the terminal."""
    table: dict[str, npt.ArrayLike] = {} if signal.time is None else {"time [s]": signal.time}
    table |= columns
    out = request.out
    text = format_csv(table, out or "the table")
    if out is None:
        sys.stdout.write(text)
        return
    refuse_existing(out, request.overwrite, content=text)
    write_atomically(out, text)
    tell(f"wrote {out}: {', '.join(table)}")
