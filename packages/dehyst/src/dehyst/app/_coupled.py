"""dehyst coupled: several inputs on one or two outputs; and what simulate and compensate do with such a model."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dehyst.app._logs import log_part, outside
from dehyst.app._targets import (
    COUPLED,
    MODEL,
    place_of,
    refuse_clashes,
    refuse_existing,
    save_model_file,
)
from dehyst.app._terminal import (
    ask_progress,
    print_end,
    print_findings,
    print_json,
    table,
    tell,
    terminal,
)
from dehyst.app.requests import CompensateRequest, CoupledRequest, SimulateRequest
from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.errors import ColumnError, OutputError, ParameterError, TimeError
from dehyst.families import kit as families_kit
from dehyst.files import write_atomically
from dehyst.findings import Finding
from dehyst.identification import CoupledFit, identify
from dehyst.io import format_csv, inspect_log, read_columns, read_log
from dehyst.models import Model, SignalCard, load
from dehyst.models import kit as models_kit
from dehyst.shell import command

SHOWN = 4000  # samples of a picture
# Of simulate and compensate, what a model of several inputs has.
PLAYED = (
    "model", "log", "time", "time_unit", "dt", "sheet", "run", "start", "stop", "out", "overwrite",
)  # fmt: skip


def run_coupled(request: CoupledRequest) -> None:
    """Read, identify, save, export, draw, print."""
    refuse_clashes(
        list(request.logs),
        request.overwrite,
        save=(request.save, MODEL),
        figure=(request.figure, COUPLED),
    )
    if len(request.inputs) < 2 or len(request.outputs) not in (1, 2):
        _name_columns(request)
    with ask_progress("reading", request.json):
        records = [_recording(request, log) for log in request.logs]
    first = records[0]
    inputs = [first.input_name, *request.inputs[1:]]
    outputs = [first.output_name, *request.outputs[1:]]
    with ask_progress("fitting", request.json):
        fit = identify(records, input=inputs, output=outputs, train_fraction=request.train_fraction)
    if request.save is not None:
        save_model_file(request.save, request.overwrite, fit.model.save)
    if request.figure is not None:
        with ask_progress("drawing", request.json):
            _draw(request.figure, fit, first)
    if request.json:
        print_json(fit.as_dict())
        return
    _print(fit, records)
    print_findings(fit.warnings)
    following = ""
    if request.save is not None:
        following = command("compensate", request.save, "reference.csv", out="demand.csv")
    else:
        more = {"input": list(request.inputs), "output": list(request.outputs)}
        following = command("coupled", *request.logs, **more, save="coupled.json")
    print_end(following, model=request.save, picture=request.figure)


def _name_columns(request: CoupledRequest) -> None:
    """Refuse a command that names too few columns, or too many, and show what there is."""
    from dehyst.app._inspect import print_columns

    summary = inspect_log(request.logs[0], request.run, sheet=request.sheet)
    print_columns(terminal(stderr=True), summary.columns)
    raise ColumnError(
        f"{len(request.inputs)} inputs and {len(request.outputs)} outputs are named, and two or more inputs and one or "
        f"two outputs are needed. Type: "
        f"{command('coupled', *request.logs, input=['COLUMN', 'COLUMN'], output=['COLUMN', 'COLUMN'])}",
        columns=tuple(column.name for column in summary.columns),
    )


def _recording(request: CoupledRequest, log: Path) -> Recording:
    """Return the first input and output of a log, and the others as its further signals."""
    further = [*request.inputs[1:], *request.outputs[1:]]
    return read_log(
        log, request.inputs[0], request.outputs[0], run=request.run, schedules={name: name for name in further},
        **log_part(request),
    )  # fmt: skip


def _print(fit: CoupledFit, records: list[Recording]) -> None:
    out = terminal()
    model = fit.model
    samples = sum(record.samples for record in records)
    names = ", ".join(card.name for card in model.inputs)
    out.print(
        f"{names} move {' and '.join(one.name for one in fit.outputs)}: {model.free_parameters} numbers from {samples} "
        f"samples",
        style="bold",
    )
    out.print()
    rows = []
    for one in fit.outputs:
        rows.append(
            (
                one.name, f"{one.test_percent:.2f}", f"{one.left_out_percent:.2f}", f"{one.alone_percent:.2f}",
                f"{one.curve_percent:.2f}",
            )
        )  # fmt: skip
    out.print("rms errors, percent of the range of the output", style="dim")
    out.print(table(("output", ">held out", ">left out", ">own input alone", ">curves"), rows))
    out.print()
    effect_rows = []
    for one in fit.outputs:
        effects = [f"{one.effects[card.name]:+.3g}" for card in model.inputs]
        effect_rows.append((f"{one.name} [{one.unit}]" if one.unit else one.name, *effects))
    out.print("how far each input alone moves the output along the log", style="dim")
    out.print(table(("output", *(f">{card.name}" for card in model.inputs)), effect_rows))
    out.print()
    for name, percent in fit.input_percent.items():
        out.print(
            f"inverse: asks for {name} within {percent:.2f} % of its range (rms, held out)",
            soft_wrap=True,
        )
    out.print(fit.certificate, soft_wrap=True)


def _draw(path: Path, fit: CoupledFit, record: Recording) -> None:
    """Draw each output over its own input, measured and modelled, and what is left along the log."""
    from dehyst.report import PageFigure, Panel, PanelLine, chart
    from dehyst.report import kit as report_kit

    model = fit.model
    names = {record.input_name: record.input, record.output_name: record.output, **record.schedules}
    u = np.column_stack([names[card.name] for card in model.inputs])
    time = np.arange(len(record), dtype=float) if record.time is None else record.time
    modelled = model.rested(u[0].tolist()).simulate(u, record.time)
    part = slice(max(0, len(record) - SHOWN), None)
    panels = []
    for j, card in enumerate(model.outputs):
        own = model.inputs[model.own[j]]
        across = u[part, model.own[j]]
        measured = names[card.name]
        loops = [
            PanelLine(across, measured[part], report_kit.DATA, "measured", width=1.6),
            PanelLine(across, modelled[part, j], report_kit.MODEL, "model", width=0.8),
        ]
        panels.append(
            Panel(
                f"{card.name} over {own.name}",
                chart(own.label, card.label, loops),
                f"{card.name} and its model.",
            )
        )
        left = [
            PanelLine(
                time[part], (measured - modelled[:, j])[part], report_kit.TEST, "measured - model"
            )
        ]
        axis = "sample" if record.time is None else "time [s]"
        panels.append(
            Panel(
                f"what is left of {card.name}",
                chart(axis, card.label, left, zero=True),
                "Residual along the log.",
            )
        )
    caption = f"{record.name}: the last {len(time[part])} samples."
    figure = PageFigure("coupled", "several inputs", caption, tuple(panels))
    report_kit.write_picture(figure, path, f"{COUPLED}{record.name}", headed=True)


def play_coupled(request: SimulateRequest) -> bool:
    """Write what a model of several inputs answers, or its inverse; False for a model of one input."""
    model = load(request.model)
    if not isinstance(model, families_kit.CoupledModel):
        return False
    backward = isinstance(request, CompensateRequest)
    _refuse_options(request)
    wanted = model.outputs if backward else model.inputs
    columns = {card.name: card.name for card in wanted}
    known = []
    if backward and len(model.outputs) == 1:
        # One output tells one input; the others must be known.
        known = [card for i, card in enumerate(model.inputs) if i != model.own[0]]
        columns |= {card.name: card.name for card in known}
    with ask_progress("reading"):
        log = read_columns(request.log, columns, run=request.run, **log_part(request))
    if log.time is None and model.rate_dependent:
        raise TimeError(
            f"'{request.model}' creeps or depends on the rate, and '{request.log}' has no time column. Name it with "
            f"--time, or type --dt SECONDS.",
            log=str(request.log),
        )
    findings: list[Finding] = list(log.findings)
    values = {}
    for card in (*wanted, *known):
        values[card.name], more = models_kit.in_units_of(
            card, log.values[card.name], log.units[card.name], f"'{log.names[card.name]}'"
        )
        findings += more
        findings += outside(values[card.name], card, card.name, "the model extrapolates there")
    samples = np.column_stack([values[card.name] for card in wanted])
    answers, tails = _answers(
        model, samples, log.time, backward, {c.name: values[c.name] for c in known}
    )
    if backward:
        for card, column in zip(tails, answers.T, strict=True):
            findings += outside(
                column, card, f"computed {card.name}", "the actuator may not be able to give it"
            )
    prefix = "compensated" if backward else "model"
    columns_out: dict[str, npt.ArrayLike] = {}
    if log.time is not None:
        columns_out["time [s]"] = log.time
    columns_out |= {card.label: values[card.name] for card in wanted}
    for card, column in zip(tails, answers.T, strict=True):
        columns_out[f"{prefix} {card.label}"] = column
    text = format_csv(columns_out, request.out or "the table")
    if request.out is None:
        sys.stdout.write(text)
    else:
        refuse_existing(request.out, request.overwrite, content=text)
        write_atomically(request.out, text)
        tell(f"wrote {request.out}: {', '.join(columns_out)}")
    rest = ", ".join(
        f"{card.name} = {value:.4g}" for card, value in zip(model.inputs, model.rest, strict=True)
    )
    tell(f"start: at rest at {rest}, as the log of the model began")
    print_findings(findings, stderr=True)
    return True


def refuse_coupled(models: Mapping[str, Model], verb: str) -> None:
    """Refuse a command that takes models of one input."""
    for path, model in models.items():
        if isinstance(model, families_kit.CoupledModel):
            names = ", ".join(card.name for card in model.inputs)
            raise ParameterError(
                f"'{path}' is a model of the inputs {names}, and dehyst {verb} takes models of one input. Its held-out "
                f"errors are those that dehyst coupled prints; dehyst simulate and dehyst compensate play it.",
                model=path,
            )


def _answers(
    model: families_kit.CoupledModel,
    samples: Array,
    time: Array | None,
    backward: bool,
    known: dict[str, Array],
) -> tuple[Array, tuple[SignalCard, ...]]:
    """Return what the model, or its inverse, answers, and the signals of it."""
    with ask_progress("inverting" if backward else "simulating"):
        if not backward:
            return model.simulate(samples, time), model.outputs
        demand = model.inverse().simulate(samples, time, **known)
    if len(model.outputs) == 1:
        return demand[:, list(model.own)], (model.inputs[model.own[0]],)
    return demand, model.inputs


def _refuse_options(request: SimulateRequest) -> None:
    """Refuse options that a model of several inputs does not have, and a file that would be lost."""
    typed = []
    for entry in fields(request):
        if entry.name in PLAYED:
            continue
        if getattr(request, entry.name) != entry.default:
            typed.append(entry.metadata.get("flag") or f"--{entry.name.replace('_', '-')}")
    if typed:
        raise ParameterError(
            f"{' and '.join(typed)}: a model of several inputs begins at rest, where its log began, and finds its "
            f"columns by their names. Leave it out.",
            options=typed,
        )
    if request.out is not None and place_of(request.out) in {
        place_of(request.log),
        place_of(request.model),
    }:
        raise OutputError(
            f"'{request.out}' is the log or the model itself; writing there would lose it. Name another file."
        )
