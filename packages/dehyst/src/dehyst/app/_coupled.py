"""dehyst coupled: several inputs on one or two outputs, identified from logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from dehyst.app._logs import log_part
from dehyst.app._targets import (
    COUPLED,
    MODEL,
    refuse_clashes,
    save_model_file,
)
from dehyst.app._terminal import (
    ask_progress,
    print_end,
    print_findings,
    print_json,
    table,
    terminal,
)
from dehyst.app.requests import CoupledRequest
from dehyst.data import Recording
from dehyst.errors import ColumnError
from dehyst.identification import CoupledFit, identify
from dehyst.io import inspect_log, read_log
from dehyst.shell import command

SHOWN = 4000  # samples of a picture


def run_coupled(request: CoupledRequest) -> None:
    """Read, identify, save, draw, print."""
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
    following, model_fault = "", fit.model.no_inverse
    if request.save is not None and model_fault:
        following = command("simulate", request.save, "inputs.csv")
    elif request.save is not None:
        following = command("compensate", request.save, "reference.csv", out="demand.csv")
    else:
        more = {"input": list(request.inputs), "output": list(request.outputs)}
        following = command("coupled", *request.logs, **more, save="coupled.json")
    print_end(following, model=request.save, picture=request.figure)


def _name_columns(request: CoupledRequest) -> None:
    """Refuse a command that names too few columns, or too many, and show what there is."""
    from dehyst.app._inspect import show_columns

    summary = inspect_log(request.logs[0], request.run, sheet=request.sheet)
    names = show_columns(summary)
    raise ColumnError(
        f"inputs named: {len(request.inputs)}, outputs named: {len(request.outputs)}. Needed are two inputs or more, "
        f"and one output or two, each with an option of its own. Type: "
        f"{command('coupled', *request.logs, input=['COLUMN', 'COLUMN'], output=['COLUMN', 'COLUMN'])}",
        columns=names,
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
        f"{names} move {' and '.join(one.name for one in fit.outputs)}: {model.free_parameters} parameters "
        f"from {samples} samples",
        style="bold",
    )
    out.print()
    rows = []
    for one in fit.outputs:
        errors = (one.test_percent, one.alone_percent, one.curve_percent)
        rows.append((one.name, *(f"{error:.2f}" for error in errors), one.own))
    out.print("rms errors on held-out samples, percent of the range of the output", style="dim")
    heads = ("output", ">all inputs", ">own input alone", ">curves", "own input")
    out.print(table(heads, rows))
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
            f"inverse: asks for {name} within {percent:.2f} % of its range (rms, held-out samples)",
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
