"""dehyst sensor: the data sheet of a sensor, and with a model that of its corrected reading beside it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from rich.cells import cell_len
from rich.table import Column

from dehyst.app._logs import files_of, read_logs, refuse_two_names, typed_clocks
from dehyst.app._loops import findings_of
from dehyst.app._play_coupled import refuse_coupled
from dehyst.app._targets import PAGE, SENSOR, refuse_clashes
from dehyst.app._terminal import (
    ask_progress,
    print_end,
    print_findings,
    print_json,
    table,
    terminal,
)
from dehyst.app.requests import SensorRequest
from dehyst.data import kit as data_kit
from dehyst.data import sensor_data_sheet
from dehyst.errors import ColumnError, ParameterError
from dehyst.io import kit as io_kit
from dehyst.models import Model, load
from dehyst.monitoring import CorrectedReadings, corrected_readings
from dehyst.shell import command, visible

# A corrected reading should be the quantity.
IDEAL = "ideal"


def run_sensor(request: SensorRequest) -> None:
    """Read, measure, draw, print."""
    mark = SENSOR
    if request.out is not None and request.out.suffix.lower() == ".html":
        mark = PAGE
    sources = [*files_of(request.logs), request.model]
    refuse_clashes(sources, request.overwrite, out=(request.out, mark))
    if request.line == IDEAL or request.line not in data_kit.LINES:
        lines = ", ".join(name for name in data_kit.LINES if name != IDEAL)
        raise ParameterError(f"--line {request.line!r:.40} is unknown; there are: {lines}.")
    model = None
    if request.model is not None:
        model = load(request.model)
        refuse_coupled({str(request.model): model}, "sensor")
    request = _named(request, model)
    cards = None
    if model is not None and model.context:
        cards = model.context
    with ask_progress("reading", request.json) as progress:
        records = [record for *_, record in read_logs(request, progress, cards)]
    readings = None
    corrected = None
    with ask_progress("measuring", request.json):
        if model is not None:
            readings = corrected_readings(model, records)
            records = list(readings.before)
            corrected = sensor_data_sheet(readings.after, IDEAL)
        sheet = sensor_data_sheet(records, request.line)
    if request.out is not None:
        from dehyst.report import kit as report_kit

        report_kit.write_data_sheet(sheet, request.out, corrected)
    if request.json:
        print_json(_as_dict(sheet, corrected, readings))
        return
    _print(sheet, corrected, readings)
    findings = findings_of(records)
    if readings is not None:
        findings += [finding for finding in readings.findings if finding not in findings]
    print_findings(findings)
    print_end(_next(request, model), picture=request.out)


def _named(request: SensorRequest, model: Model | None) -> SensorRequest:
    """Return the request with both columns: as named, else those of the model."""
    refuse_two_names(request)
    if io_kit.two_places(request.logs) is not None:
        return request
    reading, quantity = request.input, request.output
    if model is not None:
        reading = reading or model.card.input.name
        quantity = quantity or model.card.output.name
    if reading and quantity:
        return replace(request, input=reading, output=quantity)
    # Not loaded where columns are named.
    from dehyst.app._inspect import show_columns
    from dehyst.io import inspect_log

    summary = inspect_log(request.logs[0], next(iter(request.runs), None), sheet=request.sheet)
    names = show_columns(summary)
    line = command(
        "sensor", request.logs[0], reading=reading or "COLUMN", quantity=quantity or "COLUMN"
    )
    raise ColumnError(
        f"nothing in {request.logs[0].name} tells the reading of the sensor from the true quantity: the same force may "
        f"be either. Name both: {line}",
        columns=names,
    )


def _as_dict(
    sheet: data_kit.DataSheet,
    corrected: data_kit.DataSheet | None,
    readings: CorrectedReadings | None,
) -> dict[str, object]:
    """The sheet; with a model also that of the corrected reading."""
    content = sheet.as_dict()
    if corrected is not None and readings is not None:
        content["corrected"] = corrected.as_dict()
        content["held_out"] = readings.held_out
    return content


def _print(
    sheet: data_kit.DataSheet,
    corrected: data_kit.DataSheet | None,
    readings: CorrectedReadings | None,
) -> None:
    """Print a row a figure, what the figures refer to, and what is missing."""
    out = terminal()
    out.print(
        f"{visible(sheet.reading_label)} over {visible(sheet.quantity_label)}: {sheet.caption}",
        style="bold",
        soft_wrap=True,
    )
    out.print()
    if corrected is None:
        heads = ["figure, % of full scale", ">mean of cycles", ">worst (cycle)", "where"]
        _print_rows(heads, sheet.rows)
    else:
        heads = ["figure, % of full scale", ">reading", ">worst", ">corrected", ">worst"]
        _print_rows(heads, list(_beside(sheet, corrected)))
    sentences = [sheet.basis]
    if corrected is not None:
        sentences.append(f"corrected: {corrected.basis}")
    if readings is not None and readings.held_out:
        sentences.append("both are of the part of the log that the model was not fitted to")
    for sentence in (*sentences, *sheet.lacking, *sheet.notes):
        out.print(sentence, soft_wrap=True)


def _print_rows(heads: Sequence[str], rows: Sequence[tuple[str, ...]]) -> None:
    """Print a table as wide as it is: a number in two lines is none."""
    out = terminal()
    columns = []
    for k, head in enumerate(heads):
        width = max(cell_len(row[k]) for row in (heads, *rows))
        column = Column(head.removeprefix(">"), min_width=width, no_wrap=True)
        if head.startswith(">"):
            column.justify = "right"
        columns.append(column)
    widths = sum(column.min_width or 0 for column in columns) + 2 * len(columns)
    out.print(table(columns, rows), width=max(out.width, widths), crop=False)


def _beside(sheet: data_kit.DataSheet, corrected: data_kit.DataSheet) -> Iterable[tuple[str, ...]]:
    """Figures of both readings, those of the corrected one by their names."""
    after = {label: (value, worst) for label, value, worst, _ in corrected.rows}
    for label, value, worst, _ in sheet.rows:
        yield label, value, worst, *after.get(label, ("", ""))


def _next(request: SensorRequest, model: Model | None) -> str:
    """What to type next: identify a model, or write its code."""
    if request.model is None:
        return command(
            "identify",
            *request.logs,
            input=request.input,
            output=request.output,
            dt=request.dt,
            clocks=typed_clocks(request),
            schedule=list(request.schedules),
            save="sensor.json",
        )
    what = "forward"
    if model is not None and model.card.input.name != request.input:
        what = "inverse"
    return command("export", request.model, target="c", what=what, out="sensor")
