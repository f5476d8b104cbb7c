"""dehyst compare: every hysteresis family on one log, one table, one picture."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.table import Column
from rich.text import Text

from dehyst.app._logs import files_of, named_columns, read_logs, typed_clocks
from dehyst.app._targets import (
    FAMILIES,
    MODEL,
    PAGE,
    refuse_clashes,
    refuse_other_model,
    save_model_file,
)
from dehyst.app._terminal import (  # fmt: skip
    ask_progress,
    print_end,
    print_findings,
    print_json,
    progress_bar,
    table,
    terminal,
)
from dehyst.app.requests import CompareRequest
from dehyst.errors import IdentificationError, ParameterError
from dehyst.families import kit as families_kit
from dehyst.identification import ComparedFamily, Comparison, all_names, compare
from dehyst.shell import command, schedules_to_type


def run_compare(request: CompareRequest) -> None:
    """Read, identify every family, draw, print."""
    refuse_clashes(
        files_of(request.logs), request.overwrite, save=(request.save, MODEL), report=(request.report, PAGE),
        figure=(request.figure, FAMILIES),
    )  # fmt: skip
    if request.save is not None:
        refuse_other_model(request.save, request.overwrite, files_of(request.logs), {})
    families = _families(request.families)
    request = named_columns("compare", request, request.json)
    with ask_progress("reading", request.json) as progress:
        records = [record for _, _, record in read_logs(request, progress)]
    with _progress(request.json) as progress:
        comparison = compare(
            records,
            families,
            train_fraction=request.train_fraction,
            seed=request.seed,
            progress=progress,
        )
    if request.save is not None:
        if comparison.chosen.model is None:
            raise IdentificationError(
                "no family could be identified, so there is no model to save; see the reasons."
            )
        save_model_file(request.save, request.overwrite, comparison.chosen.model.save)
    with ask_progress("drawing", request.json):
        _draw(comparison, request)
    if request.json:
        print_json(comparison.as_dict())
    else:
        _print(comparison, request)


def _families(text: str | None) -> tuple[str, ...] | None:
    if text is None:
        return None
    # Blanks behind commas are usual, and a comma at the end is no family.
    families = tuple(part.strip() for part in text.split(",") if part.strip())
    unknown = [name for name in families if name not in all_names()]
    if unknown or not families:
        raise ParameterError(
            f"--families {text!r} names no family '{unknown[0] if unknown else ''}'. Write names with commas: "
            f"{', '.join(all_names())}; leave it out for all of them.",
            names=unknown,
        )
    return families


@contextmanager
def _progress(quiet: bool) -> Iterator[Callable[[str, int, int], object] | None]:
    """Show which family is being identified, on a terminal only."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with progress_bar(*columns, quiet=quiet) as bar:
        if bar is None:
            yield None
            return
        task = bar.add_task("families", total=None)
        yield lambda name, number, total: bar.update(
            task, description=name, completed=number, total=total
        )


def _draw(comparison: Comparison, request: CompareRequest) -> None:
    """Write the page and the picture that were asked for."""
    if request.report is not None:
        from dehyst.report import write_comparison_report

        write_comparison_report(comparison, request.report)
    if request.figure is not None:
        from dehyst.report import write_comparison_figure

        write_comparison_figure(comparison, request.figure)


def _print(comparison: Comparison, request: CompareRequest) -> None:
    """Print the verdict, a row a family, and what is to be said of the families and of the log."""
    out = terminal()
    out.print(comparison.verdict, style="bold")
    out.print()
    auto = comparison.auto.family
    families = [entry.family for entry in comparison.entries]
    rows: list[tuple[str, ...]] = []
    best, runs_everywhere = None, True
    for entry in comparison.rows:
        if entry.model is None:
            continue
        # The row of the verdict is bold, and rows without a model are not printed.
        if best is None and entry is comparison.chosen:
            best = len(rows)
        rows.append(_row(entry, entry.family == auto))
        runs_everywhere = runs_everywhere and entry.exportable
    # A name that was cut could not be typed again. All columns together need 78 characters at most.
    name = Column("family", min_width=max(map(len, families)) + 2)
    heads = (name, ">held out", ">interval", ">inverse", ">parameters", ">fit s")
    out.print(table(heads, rows, bold=best))
    out.print(
        "rms errors, percent of the output's range (inverse: of the input's)\n"
        "interval: 90 % of the errors if other samples were held out (ten parts of them, drawn anew 2000 times)\n"
        "* as good as the best, within this doubt"
    )
    if auto in families:
        out.print("< what identify takes: it chooses without the held-out errors")
    if not runs_everywhere:
        out.print("p in Python only: no target can run it")
    if len(comparison.front) > 1:
        sizes = [f"{entry.family} ({entry.parameters})" for entry in comparison.front]
        out.print(
            f"best of their size, of the rows that a target can run (parameters): {', '.join(sizes)}"
        )
    notes = comparison.notes
    if notes:
        out.print()
    for family, words in notes:
        out.print(Text.assemble((family, "bold"), f": {words}"))
    if comparison.auto.warnings and auto != comparison.chosen.family:
        out.print()
        out.print(f"Warnings of identify; where they speak of a model, of its choice, {auto}:")
    print_findings(comparison.auto.warnings)
    print_end(
        _next(comparison, request),
        model=request.save,
        report=request.report,
        picture=request.figure,
    )


def _row(entry: ComparedFamily, chosen: bool) -> tuple[str, ...]:
    """A family in the table, with the marks that are explained below it."""
    name, inverse = entry.family, "none"
    if entry.tied:
        name += " *"
    if chosen:
        name += " <"
    if not entry.exportable:
        name += " p"
    if entry.invertible and entry.inverse_percent is not None:
        inverse = _percent(entry.inverse_percent)
    redraws = ""
    if entry.interval_percent is not None:
        low, high = entry.interval_percent
        redraws = f"{_percent(low)}-{_percent(high)}"
    errors = (_percent(entry.error_percent), redraws, inverse)
    return (name, *errors, str(entry.parameters), f"{entry.seconds:.2f}")


def _percent(value: float) -> str:
    """Four digits, or three decimals: more would only widen the table."""
    decimals = 3
    for bound in (10.0, 100.0, 1000.0):
        decimals -= value >= bound
    return f"{value:.{decimals}f}"


def _next(comparison: Comparison, request: CompareRequest) -> str:
    """What to do now: use what was saved, or identify and save what is best."""
    if comparison.chosen.model is None:
        return "cure what the warnings above name and compare again"
    if request.save is not None:
        needs = schedules_to_type(comparison.chosen.model.needs)
        # Only an inverse can compensate.
        if comparison.chosen.invertible:
            return command("compensate", request.save, "SIGNAL.csv", output=request.output, **needs)
        return command("simulate", request.save, "SIGNAL.csv", input=request.input, **needs)
    windows: dict[str, object] = {
        "run": list(request.runs),
        "from": list(request.start),
        "to": list(request.stop),
    }
    family = _named(comparison)
    # A family that does not go with other signals refuses them.
    if family is None or comparison.chosen.model.needs:
        windows["schedule"] = list(request.schedules)
    return command(
        "identify", *request.logs, input=request.input, output=request.output, time=request.time,
        time_unit=request.time_unit, sheet=request.sheet, **windows, train_fraction=request.train_fraction,
        family=family, dt=request.dt, clocks=typed_clocks(request),
        save="model.json", report="report.html",
    )  # fmt: skip


def _named(comparison: Comparison) -> str | None:
    """The family that the verdict names; None where identify takes it, or one within doubt of it, by itself."""
    # Where identify takes this family by itself, the shorter command gives the same model.
    for entry in comparison.entries:
        if entry.family == comparison.auto.family:
            if entry.tied:
                return None
            break
    if comparison.auto_entry.error_percent < comparison.chosen.error_percent:
        return None
    assert comparison.chosen.model is not None
    if comparison.chosen.family == families_kit.BEST:
        family: str = comparison.chosen.model.family
        return family
    return comparison.chosen.family
