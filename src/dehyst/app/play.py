"""dehyst simulate and dehyst compensate: a model or its inverse over a logged signal."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.app.start import MODEL, UNKNOWN, begun, middle, say, start_of
from dehyst.app.targets import refuse_existing
from dehyst.app.terminal import print_findings, tell
from dehyst.app.unknown import column, place, refuse_without_unknown_state, with_any_past
from dehyst.app.verdict import verdict_findings
from dehyst.errors import ColumnError, OutputError, ParameterError
from dehyst.families.base import LoopModel
from dehyst.files import write_atomically
from dehyst.findings import Finding
from dehyst.io import Signal, format_csv, read_signal
from dehyst.models import DirectInverse, HysteresisModel, ShearedPrandtlIshlinskii, SignalCard, load
from dehyst.units import canonical, convert

Array = npt.NDArray[np.float64]

# A step of the computed input between two samples, as a share of the identified range, that is worth a word.
JUMP = 0.1
# A signal that leaves the identified range by more than this share of it is worth a word.
BEYOND = 0.02


@dataclass(frozen=True)
class PlayRequest:
    """The command line of ``dehyst simulate`` and ``dehyst compensate``."""

    model: Path
    log: Path
    column: str | None
    time: str | None
    run: str | None
    start: float | None
    stop: float | None
    out: Path | None
    overwrite: bool = False
    time_unit: str | None = None
    load: str | None = None
    mean_pressure: str | None = None
    unknown_state: bool = False
    past: tuple[float, float] | None = None
    figure: Path | None = None
    begin: str | None = None


def run_simulate(request: PlayRequest) -> None:
    """Write time, input and the model's output."""
    model, signal = _read(request, "input")
    if isinstance(model, DirectInverse):
        from dehyst.app.play_direct import simulate_direct  # which writes with what is below

        simulate_direct(request, model, signal)
        return
    if isinstance(model, LoopModel):
        from dehyst.app.play_loop import simulate_loop

        simulate_loop(request, model, signal)
        return
    refuse_schedules(request)
    x, findings = in_units_of(model.card.input, signal)
    findings += outside(x, model.card.input, "input", "the model extrapolates there")
    given, start, told = {column(model.card.input): x}, start_of(request, MODEL), ""
    if request.unknown_state:
        columns, more = with_any_past(model, x, model.card.output, "model", signal, request.figure, request.past)
        findings += more
    elif start == UNKNOWN:
        y, told = middle(model, x, model.card.input, model.card.output, signal, request.past)
        columns = {column(model.card.output, "model"): y}
    else:
        columns = {column(model.card.output, "model"): begun(model, start, x[0]).simulate(x)}
    write(request, signal, given | columns)
    if not request.unknown_state:
        say(start, told)
    print_findings([*about(signal, "input"), *findings], stderr=True)


def run_compensate(request: PlayRequest) -> None:
    """Write time, wanted output and the input that produces it."""
    model, signal = _read(request, "output")
    if isinstance(model, DirectInverse):
        from dehyst.app.play_direct import compensate_direct  # which writes with what is below

        compensate_direct(request, model, signal)
        return
    if isinstance(model, LoopModel):
        from dehyst.app.play_loop import compensate_loop

        compensate_loop(request, model, signal)
        return
    refuse_schedules(request)
    said = verdict_findings(model, request.model, "Do not apply this input to a machine")
    y, findings = in_units_of(model.card.output, signal)
    findings += outside(y, model.card.output, "reference", "the inverse extrapolates there")
    inverse, start, told = model.inverse(), start_of(request, UNKNOWN), ""
    if request.unknown_state:
        columns, more = with_any_past(inverse, y, model.card.input, "compensated", signal, request.figure, request.past)
        x = next(iter(columns.values()))
        findings += more
    else:
        if start == UNKNOWN:
            x, told = middle(inverse, y, model.card.output, model.card.input, signal, request.past)
        else:
            x = begun(inverse, start, y[0]).simulate(y)
        columns = {column(model.card.input, "compensated"): x}
        findings += _proof(model, x if start == MODEL else inverse.simulate(y), y)
    findings += outside(x, model.card.input, "computed input", "the actuator may not be able to give it")
    findings += jumps(x, model.card.input, signal)
    write(request, signal, {column(model.card.output): y, **columns})
    if not request.unknown_state:
        say(start, told)
    print_findings([*said, *about(signal, "reference"), *findings], stderr=True)


def _read(request: PlayRequest, role: str) -> tuple[Any, Signal]:
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


def refuse_schedules(request: PlayRequest) -> None:
    """Refuse columns that only a direct inverse with a schedule takes."""
    wrong = [name for name, given in (("--load", request.load), ("--mean-pressure", request.mean_pressure)) if given]
    if wrong:
        raise ParameterError(
            f"{' and '.join(wrong)} {'belongs' if len(wrong) == 1 else 'belong'} to a direct inverse with such a "
            f"schedule, and '{request.model}' holds another model. Leave it out."
        )


def in_units_of(card: SignalCard, signal: Signal) -> tuple[Array, list[Finding]]:
    """Convert the signal to the model's unit, or say that it cannot be checked."""
    if signal.unit == card.unit or canonical(signal.unit) == canonical(card.unit) is not None:
        return signal.values, []
    if not signal.unit or not card.unit:
        return signal.values, [
            Finding(
                "unit-unknown",
                f"column '{signal.name}' is in '{signal.unit or 'unknown'}', the model in '{card.unit or 'unknown'}': "
                f"the values were taken as they are. Name the unit in the column, for example "
                f"{card.name}_{card.unit or 'bar'}.",
            )
        ]
    values = convert(signal.values, signal.unit, card.unit)
    return values, [
        Finding("unit-converted", f"column '{signal.name}' was converted from {signal.unit} to {card.unit}.")
    ]


def outside(values: Array, card: SignalCard, role: str, consequence: str) -> list[Finding]:
    """Return a finding if a signal leaves its identified range."""
    if card.low is None or card.high is None:
        return []
    slack = BEYOND * (card.high - card.low)
    beyond = int(np.sum((values < card.low - slack) | (values > card.high + slack)))
    if not beyond:
        return []
    unit = f" {card.unit}" if card.unit else ""
    return [
        Finding(
            "outside-range",
            f"{role} leaves the identified range {card.low:.4g} to {card.high:.4g}{unit} at {beyond} of {values.size} "
            f"samples (it spans {values.min():z.4g} to {values.max():z.4g}): {consequence}. Scale it, or identify "
            f"on a log that covers it.",
        )
    ]


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


def jumps(x: Array, card: SignalCard, signal: Signal, cure: str = ", or raise --eps when identifying") -> list[Finding]:
    """Steps of the computed input that no valve or amplifier follows from one sample to the next."""
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
            f"sample it more finely{cure}.",
        )
    ]


def _proof(model: HysteresisModel, x: Array, y: Array) -> list[Finding]:
    """Run the model on the computed input: it must give the reference back, from the first sample on."""
    if isinstance(model, ShearedPrandtlIshlinskii) and not model.has_forward:
        error = np.abs(model.hysteresis.simulate(x + model.shear * y) - y)
    else:
        error = np.abs(model.simulate(x) - y)
    span = max(float(np.ptp(y)), 1e-300)
    if float(np.max(error)) <= 1e-9 * span:
        return []
    return [
        Finding(
            "round-trip",
            f"the model's answer to the computed input differs from the reference by up to {float(np.max(error)):.3g} "
            f"({100 * float(np.max(error)) / span:.2g} % of its range): the inverse loses digits here. Raise "
            f"--eps when identifying.",
        )
    ]


def _refuse_sources(request: PlayRequest) -> None:
    """Refuse to write over the log or the model, whatever option is given."""
    out = request.out
    for target in (out, request.figure):
        if target is not None and target.resolve() in {request.log.resolve(), request.model.resolve()}:
            raise OutputError(
                f"'{target}' is the log or the model itself; writing there would lose it. Name another file."
            )


def write(request: PlayRequest, signal: Signal, columns: dict[str, Array]) -> None:
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
