"""dehyst compare: every hysteresis family on one log, one table, one picture."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from dehyst.app.columns import named_columns, read_logs
from dehyst.app.requests import CompareRequest
from dehyst.app.targets import FAMILIES, MODEL, PAGE, refuse_clashes, refuse_other_model, save_model
from dehyst.app.terminal import ask_progress, print_end, print_findings, print_json, terminal
from dehyst.errors import IdentificationError, ParameterError
from dehyst.families import Comparison, FamilyFit, all_names, compare
from dehyst.shell import quoted, typed

if TYPE_CHECKING:
    from collections.abc import Callable


def run_compare(request: CompareRequest) -> None:
    """Read, identify every family, draw, print."""
    refuse_clashes(
        request.logs, request.overwrite, save=(request.save, MODEL), report=(request.report, PAGE),
        figure=(request.figure, FAMILIES),
    )  # fmt: skip
    if request.save is not None:
        refuse_other_model(request.save, request.overwrite, request.logs, {})
    families = _families(request.families)
    request = named_columns("compare", request, request.json)
    with ask_progress("reading", request.json):
        records = read_logs(request)
    with _progress(request.json) as told:
        found = compare(records, families, train_fraction=request.train_fraction, seed=request.seed, progress=told)
    if request.save is not None:
        _save(found, request.save, request.overwrite)
    with ask_progress("drawing", request.json):
        _draw(found, request)
    if request.json:
        print_json(found.as_dict())
    else:
        _print(found, request)


def _save(found: Comparison, path: Path, overwrite: bool) -> None:
    """Write the model of the best family."""
    if found.chosen.model is None:
        raise IdentificationError("no family could be identified, so there is no model to save; see the reasons.")
    save_model(path, overwrite, found.chosen.model.save)


def _families(text: str | None) -> tuple[str, ...] | None:
    if text is None:
        return None
    wanted = tuple(part.strip() for part in text.split(",") if part.strip())
    unknown = [name for name in wanted if name not in all_names()]
    if unknown or not wanted:
        raise ParameterError(
            f"--families {text!r} names no family '{unknown[0] if unknown else ''}'. Write names with commas: "
            f"{', '.join(all_names())}; leave it out for all of them.",
            names=unknown,
        )
    return wanted


@contextmanager
def _progress(quiet: bool) -> Iterator[Callable[[str, int, int], object] | None]:
    """Show which family is being identified, on a terminal only."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=terminal(stderr=True), transient=True) as bar:
        task = bar.add_task("families", total=None)

        def told(name: str, number: int, total: int) -> None:
            bar.update(task, description=name, completed=number, total=total)

        yield told


def _draw(found: Comparison, request: CompareRequest) -> None:
    if request.report is not None:
        from dehyst.report.compare import write_comparison_report

        write_comparison_report(found, request.report)
    if request.figure is not None:
        from dehyst.report.compare import write_comparison_figure

        write_comparison_figure(found, request.figure)


def _print(found: Comparison, request: CompareRequest) -> None:
    out = terminal()
    out.print(Text(found.verdict, style="bold"))
    out.print()
    table = Table(box=None, pad_edge=False)
    for k, name in enumerate(("family", "held out %", "fitted %", "inverse %", "parameters", "fit s")):
        # A name that was cut could not be typed again. All columns together need 78 characters at most.
        whole = max(len(entry.family) for entry in found.entries) + 2 if not k else None
        table.add_column(Text(name), justify="right" if k else "left", min_width=whole)
    for entry in found.entries:
        if entry.model is not None:
            table.add_row(
                *_row(entry, entry.family == found.auto.family), style="bold" if entry is found.chosen else None
            )
    out.print(table)
    out.print(Text("rms, percent of the output's range (inverse: of the input's); * within noise of the best"))
    if any(entry.family == found.auto.family for entry in found.entries):
        out.print(Text("< what identify takes, which chooses without the held-out errors"))
    said = found.notes
    if said:
        out.print()
    for name, words in said:
        out.print(Text.assemble((name, "bold"), f": {words}"))
    if found.auto.warnings and found.auto.family != found.chosen.family:
        out.print()
        out.print(Text(f"Warnings of identify; where they speak of a model, of its choice, {found.auto.family}:"))
    print_findings(found.auto.warnings)
    print_end(out, _next(found, request), model=request.save, report=request.report, picture=request.figure)


def _row(entry: FamilyFit, taken: bool) -> tuple[Text | str, ...]:
    return (
        Text(f"{entry.family}{' *' if entry.tied else ''}{' <' if taken else ''}"),
        "" if entry.test is None else _percent(entry.test.rmse_percent),
        "" if entry.train is None else _percent(entry.train.rmse_percent),
        _percent(entry.inverse_percent) if entry.invertible and entry.inverse_percent is not None else "none",
        str(entry.parameters),
        f"{entry.seconds:.2f}",
    )


def _percent(value: float) -> str:
    return f"{value:.3f}" if value < 1000.0 else f"{value:.0f}"


def _next(found: Comparison, request: CompareRequest) -> str:
    """What to do now: use what was saved, or identify and save what is best."""
    if found.chosen.model is None:
        return "cure what the warnings above name and compare again"
    if request.save is not None:
        what = "compensate" if found.chosen.invertible else "simulate"
        column = request.output if found.chosen.invertible else request.input
        option = "--output" if found.chosen.invertible else "--input"
        return f"dehyst {what} {quoted(request.save)} SIGNAL.csv {option} {quoted(column)}"
    log = typed(request.logs)
    signals = f"--input {quoted(request.input)} --output {quoted(request.output)}"
    window: list[tuple[str, object]] = [("--time", request.time), ("--time-unit", request.time_unit)]
    window += [*(("--run", run) for run in request.runs), ("--from", request.start), ("--to", request.stop)]
    same = "".join(f" {name} {quoted(value)}" for name, value in window if value is not None)
    # One advice: what identify takes, chosen without the errors above; a family only where named ones err less.
    named = request.families and found.chosen.error_percent < found.auto_entry.error_percent
    family = f" --family {found.chosen.family}" if named else ""
    return f"dehyst identify {log} {signals}{same}{family} --save model.json --report report.html"
