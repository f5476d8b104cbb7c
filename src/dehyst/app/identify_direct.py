"""dehyst identify --family direct-inverse: log -> compensator, comparison with forward families, evidence."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from dehyst.app.terminal import ask_progress, print_findings, terminal
from dehyst.errors import ColumnError, ParameterError, UnitError
from dehyst.grades import Grade, grade_of
from dehyst.identification import DirectFit, Score, identify_direct
from dehyst.io import Signal, read_signal
from dehyst.models import Schedule
from dehyst.recording import Recording
from dehyst.shell import quoted
from dehyst.units import MASS_FACTORS, convert, dimension, mass_unit

if TYPE_CHECKING:
    from dehyst.app.identify import IdentifyRequest

Array = npt.NDArray[np.float64]

DIRECT = "direct-inverse"
# Dimensions that a scheduling column may have; a unit that is not known passes.
DIMENSIONS = {"load": ("force", "torque"), "mean_pressure": ("pressure",)}
# A scheduling column may begin later or end earlier by this share of the recording.
UNCOVERED = 0.02


def refuse_options(request: IdentifyRequest) -> None:
    """Refuse options that say nothing to the family that was asked for."""
    direct = {
        "--creep": request.creep is not None,
        "--creep-times": request.creep_times is not None,
        "--load": request.load is not None,
        "--mean-pressure": request.mean_pressure is not None,
        "--no-position-schedule": not request.position_schedule,
    }
    forward = {
        "--n": request.n != "100",
        "--eps": request.eps is not None,
        "--thresholds": request.thresholds is not None,
        "--stream": request.stream is True,
        "--spool-dir": request.spool_dir is not None,
        "--shear": request.shear is not None,
        "--max-inverse-gain": request.max_inverse_gain is not None,
    }
    is_direct = request.family == DIRECT
    wrong = [name for name, given in (forward if is_direct else direct).items() if given]
    if not wrong:
        return
    about = (
        f"says nothing to --family {DIRECT}, whose terms are its own and which reads the log at once"
        if is_direct
        else f"belongs to --family {DIRECT}, and the family is {request.family}"
    )
    raise ParameterError(
        f"{' and '.join(wrong)} {about}. Leave it out, or choose {'another family' if is_direct else 'that family'}.",
        options=wrong,
    )


def identify_from(request: IdentifyRequest, records: list[Recording]) -> DirectFit:
    """Read the scheduling columns and identify."""
    runs = [(log, run) for log in request.logs for run in (request.runs or (None,))]
    given: dict[str, list[Array]] = {}
    units: dict[str, str] = {}
    with ask_progress("reading", request.json):
        for name, column in (("load", request.load), ("mean_pressure", request.mean_pressure)):
            if column is not None:
                given[name], units[name] = schedule_of(name, column, (request.time, request.time_unit), runs, records)
    signals: dict[str, Any] = dict(given)
    with ask_progress("identifying", request.json):
        return identify_direct(
            records,
            creep="auto" if request.creep is None else request.creep,
            creep_times=_times(request.creep_times),
            units=units,
            position_schedule=request.position_schedule,
            initial_state=request.initial_state,
            train_fraction=request.train_fraction,
            **signals,
        )


def _times(text: str | None) -> list[float] | None:
    if text is None:
        return None
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise ParameterError(
            f"--creep-times {text!r} is not a list of seconds; write them with commas: --creep-times 4,25,150"
        ) from None


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


def print_direct(fit: DirectFit, request: IdentifyRequest) -> None:
    """Verdict, errors in both directions against the forward families, evidence, findings, the next line."""
    from rich.table import Table
    from rich.text import Text

    out, first = terminal(), fit.recordings[0]
    out.print(Text(fit.verdict, style="bold"))
    out.print()
    table = Table(box=None, pad_edge=False)
    for name in ("", "rms", "rms [% of range]", "max"):
        table.add_column(Text(name), justify="left" if not name else "right")
    part = "held out" if fit.test else "fitted"
    rows: list[tuple[str, Score | None, str]] = [
        (f"input {first.input_name}, fitted", fit.train if fit.test else None, first.input_unit),
        (f"input {first.input_name}, {part}", fit.judged, first.input_unit),
        (f"curve without memory, {part}", fit.static_test or fit.static_train, first.input_unit),
        (f"read forward: {first.output_name}, {part}", fit.judged_forward, first.output_unit),
    ]
    for label, score, unit in rows:
        if score is not None:
            table.add_row(
                Text(label), f"{score.rmse:.4g} {unit}", f"{score.rmse_percent:.2f}", f"{score.max:.4g} {unit}"
            )
    out.print(table)
    out.print()
    for rival in fit.rivals:
        out.print(
            Text(
                f"against {rival.family}: input {rival.inverse_percent:.2f} % of range, output "
                f"{rival.forward_percent:.2f} % ({part})"
            )
        )
    out.print()
    for said in fit.evidence_words:
        out.print(Text(said))
    if fit.lacking:
        out.print(Text(fit.lacking))
    certificate = fit.certificate
    rises = (
        "rises with the output whatever the past" if certificate.rises else "may fall with the output after some past"
    )
    schedules = ", ".join(_schedule_words(schedule) for schedule in fit.model.schedules) or "none"
    times = ", ".join(f"{value:.3g}" for value in fit.model.time_constants)
    out.print(
        Text(
            f"{certificate.nonzero_weights} of {certificate.terms} terms carry weight; degree "
            f"{fit.settings['degree']}; schedules {schedules}; terms of creep {times + ' s' if times else 'none'}; "
            f"start "
            f"'{certificate.initial_state}'\noptimality {certificate.kkt_residual:.0e}; the input {rises}"
        )
    )
    print_findings(fit.warnings)
    out.print()
    for path, what in ((request.save, "model"), (request.report, "report"), (request.figures, "figures")):
        if path is not None:
            out.print(Text(f"{what}: {path}"))
    out.print(Text(f"next: {_next(fit, request.save)}"), soft_wrap=True)


def _schedule_words(schedule: Schedule) -> str:
    """Name and, from outside, range; a mass is said to be one."""
    if not schedule.outside:
        return schedule.name
    mass = " (a mass; no joint controller takes it)" if schedule.unit in MASS_FACTORS else ""
    return f"{schedule.name} {schedule.low:z.4g} to {schedule.high:z.4g} {schedule.unit}".rstrip() + mass


def _next(fit: DirectFit, saved: Path | None) -> str:
    if grade_of(fit.verdict) is Grade.BAD:
        return "do not compensate with this model; cure what the warnings above name and identify again"
    if saved is None:
        return "repeat with --save model.json --report report.html"
    output = quoted(fit.recordings[0].output_name)
    return f"dehyst compensate {quoted(saved)} REFERENCE.csv --output {output}"
