"""Reads the logs of a command: columns, recordings, scheduling signals; warns of inputs outside a model's range."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np

from dehyst.app.inspect import print_columns
from dehyst.app.requests import (
    CompareRequest,
    DriftRequest,
    EvaluateRequest,
    IdentifyRequest,
    LogsRequest,
    SimulateRequest,
)
from dehyst.app.terminal import terminal
from dehyst.arrays import Array
from dehyst.data.recording import Recording
from dehyst.errors import ColumnError, ParameterError, UnitError
from dehyst.findings import Finding, Grade, doubtful, grade_of
from dehyst.io import LogSummary, Signal, inspect_log, read_log, read_signal
from dehyst.io.text import SIZE_LIMIT
from dehyst.models import Model, ModelCard, SignalCard
from dehyst.models.card import in_units_of
from dehyst.shell import command as line_of
from dehyst.shell import options_line
from dehyst.units import MASS_FACTORS, convert, dimension, mass_unit

Read: TypeAlias = tuple[Path, str | None, Recording]  # log, run, what was read
R = TypeVar("R", IdentifyRequest, CompareRequest)

# A signal that leaves the identified range by more than this share of it is worth a warning.
BEYOND = 0.02
# Dimensions that a scheduling column may have; a unit that is not known passes.
DIMENSIONS = {"load": ("force", "torque"), "mean_pressure": ("pressure",)}
# A scheduling column may begin later or end earlier by this share of the recording.
UNCOVERED = 0.02
# Bytes of memory that identifying a log at once takes for each byte of its file: 5.2 measured for NPZ with two columns,
# 3.6 for CSV with three. Logs that would take more than half of the memory are streamed.
MEMORY_PER_BYTE = 5.0
SHARE = 0.5
# How much larger packed logs are than their files, roughly.
PACKED = {".gz": 4.0, ".parquet": 2.0, ".feather": 2.0}


def part_of(request: Any) -> dict[str, Any]:
    """Time column, its unit, the sheet and the window of a request that reads one log, as all readers of logs take "
    "them."""
    return {name: getattr(request, name) for name in ("time", "time_unit", "dt", "sheet", "start", "stop")}


def parts_of(request: LogsRequest) -> list[dict[str, Any]]:
    """The same for each part of a log that a request names, the whole log if it names none.

    Raises
    ------
    ParameterError
        If several parts are not pairs of bounds one after the other.
    """
    bounds = [*zip_longest(request.start, request.stop)] or [(None, None)]
    if len(bounds) > 1:
        times = [time for pair in bounds for time in pair]
        if None in times or times != sorted(times):
            raise ParameterError(
                f"{options_line(from_=[*request.start], to=[*request.stop])}: several parts of a log are pairs "
                f"of --from and --to, one after the other in time and apart, "
                f"since samples that count twice would be fitted and tested at once. Write for example "
                f"--from 0 --to 20 --from 35 --to 60."
            )
    clock = {"time": request.time, "time_unit": request.time_unit, "dt": request.dt, "sheet": request.sheet}
    return [{**clock, "start": a, "stop": b} for a, b in bounds]


def named_columns(command: str, request: R, quiet: bool) -> R:
    """Return the request with the columns of input and output: as named, else as proposed for the first log.

    With `quiet` the standard output is for the result alone: what was proposed is said on the error stream.

    Raises
    ------
    ColumnError
        If names and units leave a choice; the columns have been printed on the error stream then.
    """
    if request.input and request.output:
        return request
    log, run = request.logs[0], next(iter(request.runs), None)
    summary = (
        None
        if is_large(request.logs)
        else inspect_log(log, run, time_unit=request.time_unit, dt=request.dt, sheet=request.sheet)
    )
    if summary is None or not summary.clear or summary.input is None or summary.output is None:
        raise _choice(command, log, summary)
    pair = request.input or summary.input, request.output or summary.output
    if pair[0] == pair[1]:
        raise _choice(command, log, summary)
    words = options_line(input=pair[0], output=pair[1])
    terminal(stderr=quiet).print(f"columns: {words}, by their names and units\n", soft_wrap=True)
    return replace(request, input=pair[0], output=pair[1])


def _choice(command: str, log: Path, summary: LogSummary | None) -> ColumnError:
    """Print what there is to choose from, and return what to type."""
    asked = line_of(command, log, input="COLUMN", output="COLUMN")
    if summary is None:
        return ColumnError(
            f"'{log}' is too large to be looked through for its input and output. Name them: {asked}", columns=()
        )
    print_columns(terminal(stderr=True), summary.columns)
    if summary.input and summary.output:  # one of them may have been named
        asked = line_of(command, log, input=summary.input, output=summary.output)
        asked = f"The best guess, to be typed if it is right: {asked}"
    else:
        asked = f"Name them: {asked}"
    return ColumnError(
        f"names and units of the columns of {log.name} do not tell which one drives and which one follows. {asked}",
        columns=tuple(column.name for column in summary.columns),
    )


def memory_size() -> float:
    """Bytes of memory that this process may use; infinite where the system does not tell."""
    try:
        size = float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        size = float("inf")
    try:  # a container may have less
        limit = Path("/sys/fs/cgroup/memory.max").read_text(encoding="ascii").strip()
    except OSError:
        return size
    return min(size, float(limit)) if limit.isdigit() else size


def is_large(logs: Sequence[Path]) -> bool:
    """Whether logs are too large to be identified at once with comfort, or at all."""
    files = [log for log in logs if log.is_file()]
    sizes = [log.stat().st_size * PACKED.get(log.suffix.lower(), 1.0) for log in files]
    if any(log.stat().st_size > SIZE_LIMIT for log in files):
        return True
    return MEMORY_PER_BYTE * sum(sizes) > SHARE * memory_size()


def read_logs(request: IdentifyRequest | CompareRequest) -> list[Read]:
    """Return the recordings of a request whose columns are named, each with its log and run."""
    return [
        (log, run, read_log(log, request.input or "", request.output or "", run=run, **part))
        for log in request.logs
        for run in request.runs or (None,)
        for part in parts_of(request)
    ]


def recordings_of(
    request: DriftRequest | EvaluateRequest, log: Path, run: str | None, card: ModelCard
) -> Iterator[Recording]:
    """Yield the recordings of a run, one a part; columns that are not named are those of the model's card."""
    columns = request.input or card.input.name, request.output or card.output.name
    for part in parts_of(request):
        yield read_log(log, *columns, run=run, **part)


def signals_of(
    request: IdentifyRequest | DriftRequest | EvaluateRequest, read: Sequence[Read], cards: Iterable[SignalCard] = ()
) -> tuple[dict[str, list[Array]], dict[str, str]]:
    """Scheduling signals by name, one for each recording, and their units: those of the first card, else of the log."""
    signals: dict[str, list[Array]] = {}
    units = {card.name: card.unit for card in reversed([*cards])}
    for name, column in _schedules(request).items():
        signals[name] = []
        for log, run, record in read:
            signal = read_signal(
                log, column, time=request.time, run=run, time_unit=request.time_unit, sheet=request.sheet,
                missing="drop", dt=request.dt,
            )  # fmt: skip
            values, found = schedule_values(name, column, signal, units.get(name, ""))
            units[name] = units.get(name) or found
            signals[name].append(at_samples(name, column, signal, values, record, len(record)))
    return signals, {name: units[name] for name in signals}


def given_of(request: SimulateRequest, model: Model, signal: Signal) -> tuple[dict[str, Array], list[Finding]]:
    """Scheduling variables that the model needs, from the columns that were named."""
    named = _schedules(request)
    spare = [name for name in named if name not in model.needs]
    if spare:
        raise ParameterError(
            f"'{request.model}' does not depend on {' or '.join(spare)}; leave out {' and '.join(map(_flag, spare))}."
        )
    values: dict[str, Array] = {}
    findings: list[Finding] = []
    for card in model.context:
        name, column = card.name, named.get(card.name)
        if column is None or name not in DIMENSIONS:
            raise ParameterError(
                f"'{request.model}' depends on {name}: name the column that holds it in '{request.log}' with "
                f"{_flag(name)} ({card.low:zg} to {card.high:zg} {card.unit})."
            )
        read = read_signal(
            request.log, column, time=request.time, run=request.run, time_unit=request.time_unit, sheet=request.sheet,
            missing="drop", dt=request.dt,
        )  # fmt: skip
        if card.unit in MASS_FACTORS or (card.unit and name == "load" and mass_unit(column, read.unit)):
            converted = schedule_values(name, column, read, card.unit)[0]
        else:
            refuse_unit(name, read)
            converted, told = in_units_of(card, read.values, read.unit, f"'{read.name}'")
            findings += told
        values[name] = at_samples(name, column, read, np.asarray(converted), signal, signal.values.size)
        findings += outside(values[name], card, name, "it is held at the end of its range")
    return values, findings


def _schedules(request: IdentifyRequest | DriftRequest | EvaluateRequest | SimulateRequest) -> dict[str, str]:
    """Scheduling variable -> the column that was named for it."""
    named = {"load": request.load, "mean_pressure": request.mean_pressure}
    return {name: column for name, column in named.items() if column is not None}


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def schedule_values(name: str, column: str, signal: Signal, unit: str) -> tuple[Array, str]:
    """Values of a scheduling column in `unit`, or in its own if that is "", and the unit they are in.

    A load may be a force, a torque or a mass, and stays what it is: weights that are learnt for kilograms are for
    kilograms, and none of the three can be turned into another here.
    """
    mass = mass_unit(column, signal.unit) if name == "load" else ""
    if not mass:
        refuse_unit(name, signal)
    own = mass or signal.unit
    if unit in MASS_FACTORS or (unit and mass):
        if not (unit in MASS_FACTORS and mass):
            raise UnitError(
                f"{_flag(name)} '{column}' is in {own or 'no unit that is named'}, and the load so far in {unit}: a "
                f"mass is not a force, and which force it stands for depends on the rig. Name a column in {unit}.",
                unit=own,
            )
        return signal.values * (MASS_FACTORS[mass] / MASS_FACTORS[unit]), unit
    return np.asarray(convert(signal.values, own, unit) if unit and own != unit else signal.values), unit or own


def refuse_unit(name: str, signal: Signal) -> None:
    """Refuse a column of another dimension than its schedule."""
    allowed, found = DIMENSIONS[name], dimension(signal.unit)
    if found and found not in allowed:
        raise UnitError(
            f"{_flag(name)} names column '{signal.name}' in {signal.unit}, a unit of {found}; it takes "
            f"{' or '.join((*allowed, 'mass') if name == 'load' else allowed)}. Name the column that holds it.",
            unit=signal.unit,
        )


def at_samples(name: str, column: str, signal: Signal, values: Array, record: Recording | Signal, size: int) -> Array:
    """Bring a scheduling column to the samples of a recording or a signal."""
    if record.time is None or signal.time is None:
        if values.size != size:
            raise ColumnError(
                f"{_flag(name)} '{column}' has {values.size} samples and the recording {size}, and without time "
                f"stamps they cannot be brought together. Name the time column (--time).",
                column=column,
            )
        return values
    first, last = float(record.time[0]), float(record.time[-1])
    missing = max(0.0, float(signal.time[0]) - first) + max(0.0, last - float(signal.time[-1]))
    if missing > UNCOVERED * (last - first):
        raise ColumnError(
            f"{_flag(name)} '{column}' has values from {signal.time[0]:.6g} s to {signal.time[-1]:.6g} s, but the "
            f"recording lasts from {first:.6g} s to {last:.6g} s. Cut it with --from and --to, or name a column that "
            f"covers it.",
            column=column,
        )
    return np.interp(record.time, signal.time, values)


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


def dead_time_findings(model: Model, cure: str) -> list[Finding]:
    """Say that an input has to be sent before its output is wanted, and how, where the model knows a dead time."""
    if not model.dead_time > 0.0:
        return []
    return [
        Finding(
            "dead-time",
            f"the actuator answers {model.dead_time:.3g} s late, which no inverse undoes: {cure}, or the output "
            f"follows what is wanted {model.dead_time:.3g} s behind.",
        )
    ]


def verdict_findings(model: Model, named: str, forbid: str = "") -> list[Finding]:
    """Return the verdict as a warning unless it was good; `forbid` is what else not to do after the worst one."""
    said = model.card.provenance.get("verdict")
    verdict = doubtful(said)  # printable: the file may come from anywhere
    if not verdict:
        return []
    cure = forbid if grade_of(said) is Grade.BAD else "Watch the actuator"
    read = f"{cure}, and read" if cure else "Read"
    return [
        Finding(
            "verdict",
            f"when {named} was identified, the verdict was: {verdict} {read} the warnings of `dehyst identify` for the "
            f"reason.",
        )
    ]
