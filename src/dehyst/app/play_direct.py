"""simulate and compensate with a direct inverse: a function of output, time and scheduling columns."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.app.identify_direct import DIMENSIONS, at_samples, refuse_unit, schedule_values
from dehyst.app.play import PlayRequest, about, in_units_of, jumps, outside, write
from dehyst.app.start import MODEL, REST, UNKNOWN, say, start_of
from dehyst.app.terminal import print_findings
from dehyst.app.unknown import band_columns, column
from dehyst.app.verdict import verdict_findings
from dehyst.errors import ParameterError, TimeError
from dehyst.findings import Finding
from dehyst.io import Signal, read_signal
from dehyst.models import DirectInverse, SignalCard
from dehyst.models.follow import follow
from dehyst.units import MASS_FACTORS, mass_unit

Array = npt.NDArray[np.float64]


def compensate_direct(request: PlayRequest, model: DirectInverse, signal: Signal) -> None:
    """Write time, wanted output, the input that it needs, and the half width of it while the past is unknown."""
    said = verdict_findings(model, request.model, "Do not apply this input to a machine")
    y, findings = in_units_of(model.card.output, signal)
    findings += outside(y, model.card.output, "reference", "the curve of the model is held there")
    given, more = _given(request, model, signal)
    start = start_of(request, UNKNOWN)
    if start != MODEL:
        _refuse_past(request)
        model = model.with_known(start == REST)
    run = model.run(y, _time(request, model, signal), given=given)
    findings += more + outside(run.u, model.card.input, "computed input", "the actuator may not be able to give it")
    findings += jumps(run.u, model.card.input, signal, "")
    columns = {column(model.card.output): y, column(model.card.input, "compensated"): run.u}
    if request.unknown_state:
        certainty = 1.0 - run.doubt / max(float(run.doubt.max()), 1e-300)
        band, told = band_columns(
            run.u - run.doubt, run.u + run.doubt, certainty, model.card.input, "compensated", signal, request.figure
        )
        columns |= band
        findings += told
    elif np.any(run.doubt > 0.0):
        columns[column(model.card.input, "doubt")] = run.doubt
    write(request, signal, columns)
    if not request.unknown_state:
        width = f"{run.doubt[0]:.3g} {model.card.input.unit}".rstrip()
        say(start, f"the middle of all pasts: the first value may be off by {width}" if start == UNKNOWN else "")
    print_findings([*said, *about(signal, "reference"), *findings], stderr=True)


def simulate_direct(request: PlayRequest, model: DirectInverse, signal: Signal) -> None:
    """Write time, input and the output for which the model asks for that input."""
    if request.unknown_state:
        raise ParameterError(
            "--unknown-state gives the band of what is computed, and a direct inverse computes the input: use it with "
            "`dehyst compensate`, or leave it out."
        )
    x, findings = in_units_of(model.card.input, signal)
    findings += outside(x, model.card.input, "input", "the model extrapolates there")
    given, more = _given(request, model, signal)
    start = start_of(request, MODEL)
    taken = start if start != MODEL else REST if model.known else UNKNOWN
    found = follow(model, x, _time(request, model, signal), given, taken)
    if found.missed:
        more.append(
            Finding(
                "outside-range",
                f"at {found.missed} of {x.size} samples no output within 10 % of the identified range needs the input "
                f"given; the end of the range was written. Scale the input, or identify on a log that covers it.",
            )
        )
    write(request, signal, {column(model.card.input): x, column(model.card.output, "model"): found.y})
    say(start, "the middle of all pasts" if start == UNKNOWN else "")
    print_findings([*about(signal, "input"), *findings, *more], stderr=True)


def _refuse_past(request: PlayRequest) -> None:
    if request.past is not None:
        raise ParameterError(
            "--past does not go with a direct inverse, whose stops begin with any past. Leave it out: the band is the "
            "wider one."
        )


def _time(request: PlayRequest, model: DirectInverse, signal: Signal) -> Array:
    if signal.time is not None:
        return signal.time
    if model.time_constants.size or np.any(model.viscous > 0.0):
        raise TimeError(
            f"'{request.model}' depends on time (creep or rate), and '{request.log}' has no time column. Name it with "
            f"--time, or add one.",
            log=str(request.log),
        )
    return np.arange(signal.values.size, dtype=np.float64)


def _given(request: PlayRequest, model: DirectInverse, signal: Signal) -> tuple[dict[str, Array], list[Finding]]:
    """Scheduling variables that the model needs, from the columns that were named."""
    named = {"load": request.load, "mean_pressure": request.mean_pressure}
    wanted = {schedule.name: schedule for schedule in model.outside}
    spare = [name for name, given in named.items() if given is not None and name not in wanted]
    if spare:
        raise ParameterError(
            f"'{request.model}' does not depend on {' or '.join(spare)}; leave out "
            f"{' and '.join('--' + name.replace('_', '-') for name in spare)}."
        )
    values, findings = {}, []
    for name, schedule in wanted.items():
        option = f"--{name.replace('_', '-')}"
        given = named.get(name)
        if given is None or name not in DIMENSIONS:
            raise ParameterError(
                f"'{request.model}' depends on {name}: name the column that holds it in '{request.log}' with {option} "
                f"({schedule.low:zg} to {schedule.high:zg} {schedule.unit})."
            )
        read = read_signal(
            request.log, given, time=request.time, run=request.run, time_unit=request.time_unit, missing="drop"
        )
        card = SignalCard(name, schedule.unit, schedule.low, schedule.high)
        if schedule.unit in MASS_FACTORS or (schedule.unit and name == "load" and mass_unit(given, read.unit)):
            converted = schedule_values(option, name, given, read, schedule.unit)[0]
        else:
            refuse_unit(option, name, read)
            converted, told = in_units_of(card, read)
            findings += told
        at = at_samples(option, given, read, np.asarray(converted), signal, signal.values.size)
        findings += outside(at, card, name, "it is held at the end of its range")
        values[name] = at
    return values, findings
