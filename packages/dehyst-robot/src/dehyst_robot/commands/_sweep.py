"""dehyst sweep: the experiment over many parameters, one table and one picture."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Column

from dehyst.app import Status, concluding, progress_bar, refuse_existing, table, tell
from dehyst.app import kit as app_kit
from dehyst.report import require_picture_name
from dehyst.shell import command
from dehyst_robot.commands._requests import SweepRequest
from dehyst_robot.experiments import Summary, run_sweep
from dehyst_robot.experiments import kit as experiments_kit
from dehyst_robot.report import SweepCurve, write_sweep_figure

LINE_SECONDS = 10.0  # between two lines where there is no terminal to draw on
MOST_ROWS = 100  # of the table at the end


def run_sweep_command(request: SweepRequest) -> None:
    """Run what is missing in the table, write table and picture, print medians; exit status 1 if runs failed."""
    # The file is read whole, so that a mistake in its last study is said now.
    spec = experiments_kit.load_sweep(request.sweep)
    out = request.out or Path(f"{request.sweep.stem}.csv")
    # Before the runs: hours later a wrong name would be a loss.
    figure = require_picture_name(request.figure or out.with_suffix(".svg"))
    refuse_existing(figure, request.overwrite, own=app_kit.SWEEP)
    try:
        with _shown_progress() as progress:
            result = run_sweep(
                spec,
                out,
                workers=request.workers,
                dask=request.dask,
                progress=progress,
                retry=request.retry,
                overwrite=request.overwrite,
            )
    except KeyboardInterrupt:
        tell(f"stopped; finished runs are kept in {out}. To go on: {_command_again(request)}")
        raise SystemExit(Status.STOPPED) from None
    # Runs that failed leave gaps, and the others are worth a picture.
    write_sweep_figure(figure, spec.name, _curves(result))
    if not result.failed:
        _tell(result, figure)
        return
    with concluding(Status.NO):
        _tell(result, figure)
        tell(
            f"{result.failed} of {result.runs} runs failed; the reason stands in the column 'error', for the first: "
            f"{next(filter(None, result.columns['error']))}\nTo try them again: {_command_again(request, 'retry')}"
        )


def _tell(result: experiments_kit.SweepResult, figure: Path) -> None:
    _print(result)
    tell(f"wrote {result.out} ({len(result.points)} rows) and {figure}")


def _command_again(request: SweepRequest, *more: str) -> str:
    """The same command line without the option that drops results."""
    options = {option: getattr(request, option) for option in ("out", "figure", "workers", "dask")}
    return command("sweep", request.sweep, **options, **dict.fromkeys(more, True))


class _ProgressDisplay:
    """Progress as a bar that is redrawn, or without a terminal as a line now and then."""

    def __init__(self, bar: Progress | None) -> None:
        self._bar = bar
        self._begin = time.monotonic()
        self._last_line = self._begin
        if bar is not None:
            self._task = bar.add_task("runs", total=None, failed="", rate="", start=False)

    def __call__(self, finished: int, failed: int, total: int, resumed: int) -> None:
        now = time.monotonic()
        elapsed = now - self._begin
        # Runs that were in the table already took no time.
        fresh = finished - resumed
        rate = _rate(fresh, elapsed)
        failures = ""
        if failed:
            failures = f", {failed} failed"
        if self._bar is not None:
            if not fresh:
                self._bar.start_task(self._task)
            self._bar.update(
                self._task, completed=finished, total=total, failed=failures, rate=rate
            )
            return
        # The first and the last line are always printed.
        if fresh and finished != total and now - self._last_line < LINE_SECONDS:
            return
        self._last_line = now
        line = f"{finished} of {total} runs"
        if resumed and not fresh:
            line += f", {resumed} of them from the table"
        line += failures
        if rate:
            line += f", {rate}"
        if fresh and finished != total:
            line += f", {_duration((total - finished) * elapsed / fresh)} left"
        tell(line)


def _rate(runs: int, seconds: float) -> str:
    if not runs or seconds <= 0.0:
        return ""
    rate = runs / seconds
    if rate < 1.0:
        return f"{60.0 * rate:.3g} runs/min"
    return f"{rate:.3g} runs/s"


def _duration(seconds: float) -> str:
    whole = round(seconds)
    if whole >= 3600:
        return f"{whole // 3600} h {whole % 3600 // 60} min"
    if whole >= 60:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole} s"


@contextmanager
def _shown_progress() -> Iterator[Any]:
    columns = (
        BarColumn(),
        TextColumn("{task.completed} of {task.total} runs{task.fields[failed]}"),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(compact=True),
        TextColumn("left"),
    )
    with progress_bar(*columns) as bar:
        yield _ProgressDisplay(bar)


def _print(result: experiments_kit.SweepResult) -> None:
    """Print medians and ranges, one line a set of parameters."""
    rows = experiments_kit.summarise(result.spec, result.points, result.columns)
    labels, out = list(rows[0].figures), app_kit.terminal()
    heads: list[str | Column] = [
        Column("study", overflow="fold"),
        Column("parameters", overflow="fold"),
        ">runs",
    ]
    # Names of figures are long, and must not push the numbers out.
    heads += [Column(label, justify="right", overflow="fold") for label in labels]
    out.print(f"{result.spec.name}: median (lowest to highest) over the runs", style="bold")
    shown = table(heads, (_cells(row, labels) for row in rows[:MOST_ROWS]))
    out.print(shown, width=max(out.width, 60 + 22 * len(labels)), crop=False)
    if len(rows) > MOST_ROWS:
        out.print(f"and {len(rows) - MOST_ROWS} more; all are in {result.out}")
    if any(row.declined for row in rows):
        out.print(
            "declined: the model explains too little of unseen loops, so the trial ran without its compensator and its "
            "ratio is 1; which one stands in the columns '.../declined'"
        )


def _cells(row: Summary, labels: Sequence[str]) -> tuple[str, ...]:
    values = []
    for key, value in row.values.items():
        values.append(f"{key.rpartition('.')[2]} {_short(value)}")
    runs = f"{row.runs}"
    if row.failed:
        runs += f" ({row.failed} failed)"
    if row.declined:
        runs += f" ({row.declined} declined)"
    figures = [_figure(row.figures[label]) for label in labels]
    return (row.study, ", ".join(values), runs, *figures)


def _figure(figure: tuple[float, float, float] | None) -> str:
    if figure is None:
        return ""
    return "{:.3f} ({:.3f} to {:.3f})".format(*figure)


def _short(value: object) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    return str(value)


def _curves(result: experiments_kit.SweepResult) -> list[SweepCurve]:
    """What the picture shows: each figure over each parameter that a study varies, apart for the sweep's own grid."""
    ratios = experiments_kit.ratios_of(result.columns)
    curves = []
    for study in result.spec.studies:
        rows, groups = [], []
        for k, point in enumerate(result.points):
            if point.study == study.name:
                rows.append(k)
                # Runs of one value of the grid share a line in the picture.
                groups.append(", ".join(_short(point.values[name]) for name in result.spec.grid))
        for key in study.varied or ("seed",):
            x = [result.columns[key][k] for k in rows]
            # A panel for each figure over each parameter.
            for label, ratio in ratios.items():
                y = [ratio[k] for k in rows]
                scattered = key in study.random
                curves.append(SweepCurve(study.name, key, label, x, y, groups, scattered))
    return curves
