"""dehyst sweep: the experiment over many parameters, one table and one picture."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from dehyst.app.ending import concluding
from dehyst.app.requests import SweepRequest
from dehyst.app.status import Status
from dehyst.app.targets import SWEEP, refuse_existing
from dehyst.app.terminal import tell, terminal
from dehyst.report.svg import require_picture_name
from dehyst.robot.experiments.sweep import SweepResult, load_sweep, run_sweep
from dehyst.robot.experiments.sweep.table import Summary, ratios_of, summarise
from dehyst.robot.report.sweep import Curve, write_sweep_figure
from dehyst.shell import typed

LINE_SECONDS = 10.0  # between two lines where there is no terminal to draw on
MOST_ROWS = 100  # of the table at the end


def run_sweep_command(request: SweepRequest) -> None:
    """Run what is not done yet, write table and picture, print medians; exit status 1 if runs failed."""
    spec = load_sweep(request.sweep)
    out = request.out or Path(f"{request.sweep.stem}.csv")
    figure = require_picture_name(request.figure or out.with_suffix(".svg"))
    refuse_existing(figure, request.overwrite, own=SWEEP)
    try:
        with _shown_progress() as progress:
            result = run_sweep(
                spec,
                out,
                workers=request.workers,
                dask=request.dask,
                progress=progress,
                restart=request.restart,
                retry=request.retry,
                overwrite=request.overwrite,
            )
    except KeyboardInterrupt:
        tell(f"stopped; finished runs are kept in {out}.journal. To go on: {_line(request)}")
        raise SystemExit(Status.STOPPED) from None
    write_sweep_figure(figure, spec.name, _curves(result))
    if not result.failed:
        _tell(result, figure)
        return
    with concluding(Status.NO):
        _tell(result, figure)
        tell(
            f"{result.failed} of {result.runs} runs failed; the reason stands in the column 'error', for the first: "
            f"{next(filter(None, result.columns['error']))}\nTo try them again: {_line(request, '--retry')}"
        )


def _tell(result: SweepResult, figure: Path) -> None:
    _print(result)
    tell(f"wrote {result.out} ({len(result.points)} rows) and {figure}")


def _line(request: SweepRequest, *more: str) -> str:
    """The line to type, with what was typed; what drops or replaces results is not repeated."""
    words = ["dehyst", "sweep", str(request.sweep)]
    for option in ("out", "figure", "workers", "dask"):
        value = getattr(request, option)
        words += [] if value is None else [f"--{option}", str(value)]
    return typed([*words, *more])


class _Bar:
    """Progress as a bar that is redrawn."""

    def __init__(self, bar: Progress) -> None:
        self._bar, self._task = bar, bar.add_task("runs", total=None, failed="", rate="", start=False)
        self._begin = time.monotonic()

    def __call__(self, done: int, failed: int, total: int, resumed: int) -> None:
        rate = _rate(done - resumed, time.monotonic() - self._begin)
        if done == resumed:
            self._bar.start_task(self._task)
        told = f", {failed} failed" if failed else ""
        self._bar.update(self._task, completed=done, total=total, failed=told, rate=rate)


class _Lines:
    """Progress as a line now and then."""

    def __init__(self) -> None:
        self._begin = time.monotonic()
        self._last = self._begin

    def __call__(self, done: int, failed: int, total: int, resumed: int) -> None:
        now = time.monotonic()
        first, last = done == resumed, done == total
        if not (first or last or now - self._last >= LINE_SECONDS):
            return
        self._last = now
        fresh, elapsed = done - resumed, now - self._begin
        left = f", {_duration((total - done) * elapsed / fresh)} left" if fresh and not last else ""
        rate = _rate(fresh, elapsed)
        kept = f", {resumed} of them from the journal" if first and resumed else ""
        told = f", {failed} failed" if failed else ""
        sys.stderr.write(f"{done} of {total} runs{kept}{told}{', ' + rate if rate else ''}{left}\n")
        sys.stderr.flush()


def _rate(runs: int, seconds: float) -> str:
    if not runs or seconds <= 0.0:
        return ""
    rate = runs / seconds
    return f"{rate:.3g} runs/s" if rate >= 1.0 else f"{60.0 * rate:.3g} runs/min"


def _duration(seconds: float) -> str:
    whole = round(seconds)
    if whole >= 3600:
        return f"{whole // 3600} h {whole % 3600 // 60} min"
    return f"{whole // 60} min {whole % 60} s" if whole >= 60 else f"{whole} s"


@contextmanager
def _shown_progress() -> Iterator[Any]:
    if not sys.stderr.isatty():
        yield _Lines()
        return
    columns = (
        BarColumn(),
        TextColumn("{task.completed} of {task.total} runs{task.fields[failed]}"),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(compact=True),
        TextColumn("left"),
    )
    with Progress(*columns, console=terminal(stderr=True), transient=True) as bar:
        yield _Bar(bar)


def _print(result: SweepResult) -> None:
    """Print medians and ranges, one line a set of parameters."""
    rows = summarise(result.spec, result.points, result.columns)
    labels = list(rows[0].figures)
    table = Table(box=None, pad_edge=False)
    table.add_column("study", overflow="fold")
    table.add_column("parameters", overflow="fold")
    table.add_column("runs", justify="right")
    for label in labels:
        table.add_column(Text(label), justify="right", overflow="fold")
    for row in rows[:MOST_ROWS]:
        table.add_row(*_cells(row, labels))
    out = terminal()
    out.print(Text(f"{result.spec.name}: median (lowest to highest) over the runs", style="bold"))
    out.print(table, width=max(out.width, 60 + 22 * len(labels)), crop=False)
    if len(rows) > MOST_ROWS:
        out.print(Text(f"and {len(rows) - MOST_ROWS} more; all are in {result.out}"))


def _cells(row: Summary, labels: Sequence[str]) -> tuple[Text, ...]:
    values = ", ".join(f"{key.rpartition('.')[2]} {_short(value)}" for key, value in row.values.items())
    runs = f"{row.runs}" + (f" ({row.failed} failed)" if row.failed else "")
    figures = []
    for label in labels:
        figure = row.figures[label]
        figures.append("" if figure is None else "{:.3f} ({:.3f} to {:.3f})".format(*figure))
    return tuple(Text(cell) for cell in (row.study, values, runs, *figures))


def _short(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _curves(result: SweepResult) -> list[Curve]:
    """What the picture shows: each figure over each parameter that a study varies, apart for the sweep's own grid."""
    ratios = ratios_of(result.columns)
    curves = []
    for study in result.spec.studies:
        rows = [k for k, point in enumerate(result.points) if point.study == study.name]
        for key in study.varied or ("seed",):
            x = [result.columns[key][k] for k in rows]
            group = [", ".join(_short(result.points[k].values[each]) for each in result.spec.grid) for k in rows]
            for label, y in ratios.items():
                curves.append(Curve(study.name, key, label, x, [y[k] for k in rows], group, key in study.random))
    return curves
