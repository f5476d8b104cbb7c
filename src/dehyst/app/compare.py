"""dehyst compare: every hysteresis family on one log, one table, one picture."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.table import Column
from rich.text import Text

from dehyst.app.logs import named_columns, read_logs
from dehyst.app.requests import CompareRequest
from dehyst.app.targets import FAMILIES, MODEL, PAGE, refuse_clashes, refuse_other_model, save_model
from dehyst.app.terminal import (
    ask_progress,
    print_end,
    print_findings,
    print_json,
    progress_bar,
    table,
    terminal,
)  # fmt: skip
from dehyst.errors import IdentificationError, ParameterError
from dehyst.families import Comparison, FamilyFit, all_names, compare
from dehyst.families.registry import BEST
from dehyst.shell import command


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
        records = [record for _, _, record in read_logs(request)]
    with _progress(request.json) as told:
        found = compare(records, families, train_fraction=request.train_fraction, seed=request.seed, progress=told)
    if request.save is not None:
        if found.chosen.model is None:
            raise IdentificationError("no family could be identified, so there is no model to save; see the reasons.")
        save_model(request.save, request.overwrite, found.chosen.model.save)
    with ask_progress("drawing", request.json):
        _draw(found, request)
    if request.json:
        print_json(found.as_dict())
    else:
        _print(found, request)


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
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with progress_bar(*columns, quiet=quiet) as bar:
        if bar is None:
            yield None
            return
        task = bar.add_task("families", total=None)
        yield lambda name, number, total: bar.update(task, description=name, completed=number, total=total)


def _draw(found: Comparison, request: CompareRequest) -> None:
    if request.report is not None:
        from dehyst.report.compare import write_comparison_report

        write_comparison_report(found, request.report)
    if request.figure is not None:
        from dehyst.report.compare import write_comparison_figure

        write_comparison_figure(found, request.figure)


def _print(found: Comparison, request: CompareRequest) -> None:
    out = terminal()
    out.print(found.verdict, style="bold")
    out.print()
    fitted = [entry for entry in found.rows if entry.model is not None]
    # A name that was cut could not be typed again. All columns together need 78 characters at most.
    name = Column("family", min_width=max(len(entry.family) for entry in found.entries) + 2)
    heads = (name, ">held out %", ">fitted %", ">inverse %", ">parameters", ">fit s")
    rows = [_row(entry, entry.family == found.auto.family) for entry in fitted]
    out.print(table(heads, rows, bold=next((k for k, entry in enumerate(fitted) if entry is found.chosen), None)))
    out.print("rms, percent of the output's range (inverse: of the input's); * within noise of the best")
    if any(entry.family == found.auto.family for entry in found.entries):
        out.print("< what identify takes, which chooses without the held-out errors")
    if any(not entry.exportable for entry in fitted):
        out.print("p in Python only: no target can run it")
    said = found.notes
    if said:
        out.print()
    for family, words in said:
        out.print(Text.assemble((family, "bold"), f": {words}"))
    if found.auto.warnings and found.auto.family != found.chosen.family:
        out.print()
        out.print(f"Warnings of identify; where they speak of a model, of its choice, {found.auto.family}:")
    print_findings(found.auto.warnings)
    print_end(_next(found, request), model=request.save, report=request.report, picture=request.figure)


def _row(entry: FamilyFit, taken: bool) -> tuple[str, ...]:
    return (
        f"{entry.family}{' *' if entry.tied else ''}{' <' if taken else ''}{'' if entry.exportable else ' p'}",
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
        needs = dict.fromkeys(found.chosen.model.needs, "COLUMN")
        if found.chosen.invertible:
            return command("compensate", request.save, "SIGNAL.csv", output=request.output, **needs)
        return command("simulate", request.save, "SIGNAL.csv", input=request.input, **needs)
    windows: dict[str, object] = {"run": list(request.runs), "from": list(request.start), "to": list(request.stop)}
    return command(
        "identify", *request.logs, input=request.input, output=request.output, time=request.time,
        time_unit=request.time_unit, sheet=request.sheet, **windows, train_fraction=request.train_fraction,
        family=_named(found), dt=request.dt,
        save="model.json", report="report.html",
    )  # fmt: skip


def _named(found: Comparison) -> str | None:
    """The family that the verdict names; None where identify takes it, or one within noise of it, by itself."""
    same = next((entry for entry in found.entries if entry.family == found.auto.family), None)
    if (same is not None and same.tied) or found.auto_entry.error_percent < found.chosen.error_percent:
        return None
    assert found.chosen.model is not None
    return found.chosen.model.family if found.chosen.family == BEST else found.chosen.family
