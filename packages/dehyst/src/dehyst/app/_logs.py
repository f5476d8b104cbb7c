"""Reads the logs of a command: columns, recordings, scheduling signals; warns of inputs outside a model's range."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np

from dehyst.app._policy import POLICY
from dehyst.app._terminal import ask_progress, terminal
from dehyst.app.requests import (
    CompareRequest,
    DriftRequest,
    EvaluateRequest,
    IdentifyRequest,
    LogsRequest,
    LoopsRequest,
    SensorRequest,
    SimulateRequest,
)
from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.errors import ColumnError, ParameterError, UnitError
from dehyst.findings import Finding, Grade, doubt_in, grade_in
from dehyst.io import kit as io_kit
from dehyst.io import read_log, read_signal
from dehyst.models import Model, ModelCard, SignalCard
from dehyst.models import kit as models_kit
from dehyst.shell import command as line_of
from dehyst.shell import options_line
from dehyst.units import MASS_FACTORS, convert, dimension, mass_unit

if TYPE_CHECKING:
    from dehyst.io import LogSignal, LogSummary

Read: TypeAlias = tuple[Path, str | None, Recording]  # log, run, what was read
Shares: TypeAlias = Callable[[float], None]  # takes the share of a log that was read
R = TypeVar("R", IdentifyRequest, CompareRequest, LoopsRequest)
# What may name input and output in two files.
Pairs: TypeAlias = IdentifyRequest | CompareRequest | LoopsRequest | SensorRequest

# Dimensions that a scheduling column may have; a unit that is not known passes.
LOAD = "load"
# What the controllers of joints take by these names. Every other name stands for whatever it is.
DIMENSIONS = {LOAD: ("force", "torque"), "mean_pressure": ("pressure",)}


def log_part(request: Any) -> dict[str, Any]:
    """Time column, its unit, the sheet and the window of a request for one log, as all readers of logs take them."""
    names = ("time", "time_unit", "dt", "sheet", "start", "stop")
    return {name: getattr(request, name) for name in names}


def parts_of(request: LogsRequest) -> list[dict[str, Any]]:
    """The same for each part of a log that a request names, the whole log if it names none.

    Raises
    ------
    ParameterError
        If several parts are not pairs of bounds one after the other.
    """
    bounds = [*zip_longest(request.start, request.stop)] or [(None, None)]
    if len(bounds) > 1:
        times = list(chain(*bounds))
        # Parts that overlap would count samples twice, and an open part reaches into the next one.
        if None in times or times != sorted(times):
            raise ParameterError(
                f"{options_line(from_=[*request.start], to=[*request.stop])}: several parts of a log are pairs "
                f"of --from and --to, one after the other in time and apart, "
                f"since samples that count twice would be fitted and tested at once. Write for example "
                f"--from 0 --to 20 --from 35 --to 60."
            )
    return [log_part(request) | {"start": start, "stop": stop} for start, stop in bounds]


def files_of(logs: Sequence[Path]) -> list[Path]:
    """Files that a command reads: of ``FILE:COLUMN`` the file."""
    places = io_kit.two_places(logs)
    if places is None:
        return list(logs)
    return [place.path for place in places]


def typed_clocks(request: Pairs) -> str | None:
    """What --clocks has to be typed again, None for the default."""
    if request.clocks == "auto":
        return None
    return request.clocks


def refuse_two_names(request: Pairs) -> None:
    """Refuse options that name columns a second time, or clocks where there is one file."""
    if io_kit.two_places(request.logs) is None:
        if request.clocks != "auto":
            raise ParameterError(
                f"--clocks {request.clocks} is about input and output in two files, and these are whole logs. Leave it "
                f"out, or name two columns: u.csv:COLUMN y.csv:COLUMN"
            )
        return
    names = options_line(input=request.input, output=request.output)
    if names:
        raise ParameterError(
            f"{names} names a column, and {request.logs[0]} {request.logs[1]} name both already, the input first. "
            f"Leave the option out."
        )


def named_columns(command: str, request: R, quiet: bool) -> R:
    """Return the request with the columns of input and output: as named, else as proposed for the first log.

    With `quiet` the standard output is for the result alone: what was proposed is said on the error stream.

    Raises
    ------
    ColumnError
        If names and units leave a choice; the columns have been printed on the error stream then.
    """
    refuse_two_names(request)
    if (request.input and request.output) or io_kit.two_places(request.logs):
        return request
    # Not loaded where columns are named.
    from dehyst.io import inspect_log

    log, run = request.logs[0], next(iter(request.runs), None)
    with ask_progress("reading", quiet) as progress:
        summary = inspect_log(
            log,
            run,
            time_unit=request.time_unit,
            dt=request.dt,
            sheet=request.sheet,
            progress=progress,
        )
    # A guess that may be wrong is never acted on: a swapped pair gives a model that looks good.
    if not summary.clear or summary.input is None or summary.output is None:
        raise _choice(command, log, summary)
    pair = request.input or summary.input, request.output or summary.output
    if pair[0] == pair[1]:
        raise _choice(command, log, summary)
    words = options_line(input=pair[0], output=pair[1])
    # A choice that was not typed is said aloud, so that it can be checked.
    terminal(stderr=quiet).print(f"columns: {words}, by their names and units\n", soft_wrap=True)
    return replace(request, input=pair[0], output=pair[1])


def _choice(command: str, log: Path, summary: LogSummary) -> ColumnError:
    """Print what there is to choose from, and return what to type."""
    from dehyst.app._inspect import show_columns

    asked = line_of(command, log, input="COLUMN", output="COLUMN")
    names = show_columns(summary)
    if summary.input and summary.output:  # one of them may have been named
        asked = line_of(command, log, input=summary.input, output=summary.output)
        asked = f"The best guess, to be typed if it is right: {asked}"
    else:
        asked = f"Name them: {asked}"
    return ColumnError(
        f"names and units of the columns of {log.name} do not tell which one drives and which one follows. {asked}",
        columns=names,
    )


def read_logs(
    request: Pairs, progress: Shares, cards: Sequence[SignalCard] | None = None
) -> list[Read]:
    """Return the recordings of a request whose columns are named, each with its log and run."""
    places = io_kit.two_places(request.logs)
    if places is not None:
        return with_schedules(request, _read_two_files(request, *places), cards)
    columns = request.input or "", request.output or ""
    read: list[Read] = []
    for log in request.logs:
        for run in request.runs or (None,):
            for part in parts_of(request):
                record = read_log(log, *columns, run=run, progress=progress, **part)
                read.append((log, run, record))
    return with_schedules(request, read, cards)


def _read_two_files(
    request: Pairs,
    input: tuple[Path, str],
    output: tuple[Path, str],
) -> list[Read]:
    """Return the recordings of input and output in two files; further signals are read from that of the input."""
    # Not loaded where there is one file.
    from dehyst.io import read_two_files

    read: list[Read] = []
    for run in request.runs or (None,):
        for part in parts_of(request):
            record = read_two_files(input, output, clocks=request.clocks, run=run, **part)
            read.append((input[0], run, record))
    return read


def recordings_of(
    request: DriftRequest | EvaluateRequest,
    log: Path,
    run: str | None,
    card: ModelCard,
    progress: Shares,
) -> Iterator[Recording]:
    """Yield the recordings of a run, one a part; columns that are not named are those of the model's card."""
    columns = request.input or card.input.name, request.output or card.output.name
    for part in parts_of(request):
        yield read_log(log, *columns, run=run, progress=progress, **part)


def with_schedules(
    request: LogsRequest, read: Sequence[Read], cards: Sequence[SignalCard] | None = None
) -> list[Read]:
    """Return recordings with their schedules: the columns that were named, and those of the cards that there are.

    They are in the units of the cards, else in that of the first log. `cards` are all signals that the models depend
    on; None where there is no model yet.
    """
    units: dict[str, str] = {}
    for card in reversed(cards or ()):
        units[card.name] = card.unit
    complete: list[Read] = []
    for log, run, record in read:
        schedules = {}
        columns = _schedule_columns(request, log, run, cards or ())
        spare = [name for name, *_ in columns if name not in units]
        if spare and cards is not None:
            needed = " and ".join(map(_flag, units)) or "no --schedule"
            raise ParameterError(
                f"no model depends on {' or '.join(spare)}, which --schedule names. Write {needed}.",
                spare=spare,
            )
        for name, column, signal in columns:
            record = _with_new_findings(record, signal)
            values, own_unit = schedule_values(name, column, signal, units.get(name, ""))
            # Where no card names a unit the first log decides, and the later ones are converted to it.
            units[name] = units.get(name) or own_unit
            converted = replace(signal, values=values)
            schedules[name] = io_kit.at_samples(name, converted, record, len(record))
        own_units = {name: units[name] for name in schedules}
        complete.append((log, run, replace(record, schedules=schedules, schedule_units=own_units)))
    return complete


def _with_new_findings(record: Recording, signal: LogSignal) -> Recording:
    """Return a recording that also says what was found in a further column of it."""
    said = {finding.code for finding in record.findings}
    more = [finding for finding in signal.findings if finding.code not in said]
    return record.with_findings(*more)


def _schedule_columns(
    request: LogsRequest | SimulateRequest,
    log: Path,
    run: str | None,
    cards: Iterable[SignalCard],
) -> list[tuple[str, str, LogSignal]]:
    """Return name, column and signal of the schedules that were typed, and of those of the cards that there are."""
    read = partial(
        read_signal, log, run=run, missing="drop", time=request.time, time_unit=request.time_unit, dt=request.dt,
        sheet=request.sheet,
    )  # fmt: skip
    schedules: dict[str, tuple[str, LogSignal]] = {}
    for text in request.schedules:
        name, separator, column = text.partition("=")
        signal = read(column or name)
        if not separator:
            name, column = signal.name, name
        schedules[name] = column, signal
    for card in cards:
        if card.name in schedules:
            continue
        # With its unit a name tells two columns of one quantity apart.
        for column in (f"{card.name}_{card.unit}", f"{card.name} [{card.unit}]", card.name):
            try:
                schedules[card.name] = column, read(column)
            except ColumnError:
                # Who needs it says that it is missing.
                continue
            break
    return [(name, column, signal) for name, (column, signal) in schedules.items()]


def given_of(
    request: SimulateRequest, model: Model, signal: LogSignal
) -> tuple[dict[str, Array], list[Finding]]:
    """Scheduling variables that the model needs, from the columns that were named."""
    columns = {}
    for name, column, read in _schedule_columns(request, request.log, request.run, model.context):
        columns[name] = column, read
    # A column that nothing depends on was typed for another model, most likely.
    spare = [name for name in columns if name not in model.needs]
    if spare:
        raise ParameterError(
            f"'{request.model}' does not depend on {' or '.join(spare)}; leave out --schedule {' and '.join(spare)}."
        )
    values: dict[str, Array] = {}
    findings: list[Finding] = []
    for card in model.context:
        name = card.name
        if name not in columns:
            raise ParameterError(
                f"'{request.model}' depends on {name}: name the column that holds it in '{request.log}' with "
                f"{_flag(name)} ({card.low:zg} to {card.high:zg} {card.unit})."
            )
        column, read = columns[name]
        if card.unit in MASS_FACTORS or (
            card.unit and name == LOAD and mass_unit(column, read.unit)
        ):
            converted = schedule_values(name, column, read, card.unit)[0]
        else:
            refuse_unit(name, read)
            converted, unit_findings = models_kit.in_units_of(
                card, read.values, read.unit, f"'{read.name}'"
            )
            findings += unit_findings
        complete = replace(read, values=np.asarray(converted))
        values[name] = io_kit.at_samples(name, complete, signal, signal.values.size)
        findings += outside(values[name], card, name, "it is held at the end of its range")
    return values, findings


def _flag(name: str) -> str:
    return f"--schedule {name}=COLUMN"


def schedule_values(name: str, column: str, signal: LogSignal, unit: str) -> tuple[Array, str]:
    """Values of a scheduling column in `unit`, or in its own if that is "", and the unit they are in.

    A load may be a force, a torque or a mass, and stays what it is: weights that are learnt for kilograms are for
    kilograms, and none of the three can be turned into another here.
    """
    mass = mass_unit(column, signal.unit) if name == LOAD else ""
    if not mass:
        refuse_unit(name, signal)
    own_unit = mass or signal.unit
    if unit in MASS_FACTORS or (unit and mass):
        # Only a mass is converted to a mass.
        if not (unit in MASS_FACTORS and mass):
            raise UnitError(
                f"--schedule {name} '{column}' is in {own_unit or 'no unit that is named'}, and the load so far in "
                f"{unit}: a mass is not a force, and which force it stands for depends on the rig. Name a column in "
                f"{unit}.",
                unit=own_unit,
            )
        return signal.values * (MASS_FACTORS[mass] / MASS_FACTORS[unit]), unit
    if unit and own_unit != unit:
        return np.asarray(convert(signal.values, own_unit, unit)), unit
    return np.asarray(signal.values), unit or own_unit


def refuse_unit(name: str, signal: LogSignal) -> None:
    """Refuse a column of another dimension than its schedule."""
    allowed, measured = DIMENSIONS.get(name, ()), dimension(signal.unit)
    if allowed and measured and measured not in allowed:
        raise UnitError(
            f"--schedule {name} names column '{signal.name}' in {signal.unit}, a unit of {measured}; it takes "
            f"{' or '.join((*allowed, 'mass') if name == 'load' else allowed)}. Name the column that holds it.",
            unit=signal.unit,
        )


def outside(values: Array, card: SignalCard, role: str, consequence: str) -> list[Finding]:
    """Return a finding if a signal leaves its identified range."""
    if card.low is None or card.high is None:
        return []
    # Noise at the end of the range is no extrapolation.
    slack = POLICY.beyond * (card.high - card.low)
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
            f"the log was {model.dead_time:.3g} s late. If the actuator is, which no inverse undoes, {cure}, or the "
            f"output follows what is wanted {model.dead_time:.3g} s behind. If only the sensor is, nothing is to do.",
        )
    ]


def seconds_ahead(text: str) -> float | None:
    """Return a typed --ahead in seconds; None for auto."""
    if text == "auto":
        return None
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0.0 <= seconds < math.inf:
        raise ParameterError(
            f"--ahead {text!r:.40} is neither auto nor a time of 0 s or more; it is how long before its time the "
            f"reference is known, such as --ahead 0.08."
        )
    return seconds


def verdict_findings(model: Model, named: str, forbid: str = "") -> list[Finding]:
    """Return the verdict as a warning unless it was good; `forbid` is what else not to do after the worst one."""
    provenance = model.card.provenance
    verdict = doubt_in(provenance)  # printable: the file may come from anywhere
    if not verdict:
        return []
    # The worst verdict forbids; a doubtful one asks for care.
    cure = forbid if grade_in(provenance) is Grade.BAD else "Watch the actuator"
    read = f"{cure}, and read" if cure else "Read"
    return [
        Finding(
            "verdict",
            f"when {named} was identified, the verdict was: {verdict} {read} the warnings of `dehyst identify` for the "
            f"reason.",
        )
    ]
