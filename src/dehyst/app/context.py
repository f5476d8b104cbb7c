"""What a command knows of a model: signals from a log in its units, columns its weights depend on, its verdict."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np

from dehyst.app.requests import DriftRequest, EvaluateRequest, SimulateRequest
from dehyst.arrays import Array
from dehyst.data.recording import Recording
from dehyst.errors import ColumnError, ParameterError, UnitError
from dehyst.findings import Finding, Grade, doubtful, grade_of
from dehyst.io import Signal, read_log, read_signal
from dehyst.models import Model, ModelCard, SignalCard
from dehyst.models.card import in_units_of
from dehyst.units import MASS_FACTORS, convert, dimension, mass_unit

Read: TypeAlias = tuple[Path, str | None, Recording]  # log, run, what was read

# A signal that leaves the identified range by more than this share of it is worth a word.
BEYOND = 0.02
# Dimensions that a scheduling column may have; a unit that is not known passes.
DIMENSIONS = {"load": ("force", "torque"), "mean_pressure": ("pressure",)}
# A scheduling column may begin later or end earlier by this share of the recording.
UNCOVERED = 0.02


def recording_of(request: DriftRequest | EvaluateRequest, log: Path, run: str | None, card: ModelCard) -> Recording:
    """Return the recording of a run; columns that are not named are those of the model's card."""
    return read_log(
        log, request.input or card.input.name, request.output or card.output.name, time=request.time, run=run,
        start=request.start, stop=request.stop, time_unit=request.time_unit,
    )  # fmt: skip


def signals_of(
    request: DriftRequest | EvaluateRequest, read: Sequence[Read], models: Iterable[Model]
) -> dict[str, list[Array]]:
    """Scheduling signals by name, one for each recording, in the unit of the first model that needs them."""
    units: dict[str, str] = {}
    for model in models:
        units = {card.name: card.unit for card in model.context} | units
    runs, records = [(log, run) for log, run, _ in read], [record for _, _, record in read]
    clock = (request.time, request.time_unit)
    named = {"load": request.load, "mean_pressure": request.mean_pressure}
    return {
        name: schedule_of(name, column, clock, runs, records, units.get(name, ""))[0]
        for name, column in named.items()
        if column is not None
    }


def given_of(request: SimulateRequest, model: Model, signal: Signal) -> tuple[dict[str, Array], list[Finding]]:
    """Scheduling variables that the model needs, from the columns that were named."""
    named = {"load": request.load, "mean_pressure": request.mean_pressure}
    spare = [name for name, given in named.items() if given is not None and name not in model.needs]
    if spare:
        raise ParameterError(
            f"'{request.model}' does not depend on {' or '.join(spare)}; leave out "
            f"{' and '.join('--' + name.replace('_', '-') for name in spare)}."
        )
    values: dict[str, Array] = {}
    findings: list[Finding] = []
    for card in model.context:
        name, option = card.name, f"--{card.name.replace('_', '-')}"
        given = named.get(name)
        if given is None or name not in DIMENSIONS:
            raise ParameterError(
                f"'{request.model}' depends on {name}: name the column that holds it in '{request.log}' with {option} "
                f"({card.low:zg} to {card.high:zg} {card.unit})."
            )
        read = read_signal(
            request.log, given, time=request.time, run=request.run, time_unit=request.time_unit, missing="drop"
        )
        if card.unit in MASS_FACTORS or (card.unit and name == "load" and mass_unit(given, read.unit)):
            converted = schedule_values(option, name, given, read, card.unit)[0]
        else:
            refuse_unit(option, name, read)
            converted, told = in_units_of(card, read.values, read.unit, f"'{read.name}'")
            findings += told
        at = at_samples(option, given, read, np.asarray(converted), signal, signal.values.size)
        findings += outside(at, card, name, "it is held at the end of its range")
        values[name] = at
    return values, findings


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


def schedule_of(
    name: str,
    column: str,
    clock: tuple[str | None, str | None],
    runs: list[tuple[Path, str | None]],
    records: list[Recording],
    unit: str = "",
) -> tuple[list[Array], str]:
    """Samples of a scheduling column at those of each recording, in `unit`, or if that is "" in that of the first."""
    option = f"--{name.replace('_', '-')}"
    arrays = []
    for (log, run), record in zip(runs, records, strict=True):
        signal = read_signal(log, column, time=clock[0], run=run, time_unit=clock[1], missing="drop")
        values, found = schedule_values(option, name, column, signal, unit)
        unit = unit or found
        arrays.append(at_samples(option, column, signal, np.asarray(values), record, len(record)))
    return arrays, unit


def schedule_values(option: str, name: str, column: str, signal: Signal, unit: str) -> tuple[Array, str]:
    """Values of a scheduling column in `unit`, or in its own if that is "", and the unit they are in.

    A load may be a force, a torque or a mass, and stays what it is: weights that are learnt for kilograms are for
    kilograms, and none of the three can be turned into another here.
    """
    mass = mass_unit(column, signal.unit) if name == "load" else ""
    if not mass:
        refuse_unit(option, name, signal)
    own = mass or signal.unit
    if unit in MASS_FACTORS or (unit and mass):
        if not (unit in MASS_FACTORS and mass):
            raise UnitError(
                f"{option} '{column}' is in {own or 'no unit that is named'}, and the load so far in {unit}: a mass is "
                f"not a force, and which force it stands for depends on the rig. Name a column in {unit}.",
                unit=own,
            )
        return signal.values * (MASS_FACTORS[mass] / MASS_FACTORS[unit]), unit
    return np.asarray(convert(signal.values, own, unit) if unit and own != unit else signal.values), unit or own


def refuse_unit(option: str, name: str, signal: Signal) -> None:
    """Refuse a column of another dimension than its schedule."""
    allowed, found = DIMENSIONS[name], dimension(signal.unit)
    if found and found not in allowed:
        raise UnitError(
            f"{option} names column '{signal.name}' in {signal.unit}, a unit of {found}; it takes "
            f"{' or '.join((*allowed, 'mass') if name == 'load' else allowed)}. Name the column that holds it.",
            unit=signal.unit,
        )


def at_samples(option: str, column: str, signal: Signal, values: Array, record: Recording | Signal, size: int) -> Array:
    """Bring a scheduling column to the samples of a recording or a signal."""
    if record.time is None or signal.time is None:
        if values.size != size:
            raise ColumnError(
                f"{option} '{column}' has {values.size} samples and the recording {size}, and without time "
                f"stamps they cannot be brought together. Name the time column (--time).",
                column=column,
            )
        return values
    first, last = float(record.time[0]), float(record.time[-1])
    missing = max(0.0, float(signal.time[0]) - first) + max(0.0, last - float(signal.time[-1]))
    if missing > UNCOVERED * (last - first):
        raise ColumnError(
            f"{option} '{column}' has values from {signal.time[0]:.6g} s to {signal.time[-1]:.6g} s, but the recording "
            f"lasts from {first:.6g} s to {last:.6g} s. Cut it with --from and --to, or name a column that covers it.",
            column=column,
        )
    return np.interp(record.time, signal.time, values)


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
