"""dehyst sweep: the experiment over many parameters, one table and one picture."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Column

from dehyst.app.ending import Status, concluding
from dehyst.app.targets import SWEEP, refuse_existing
from dehyst.app.terminal import progress_bar, table, tell, terminal
from dehyst.report.svg import require_picture_name
from dehyst.robot.commands.requests import SweepRequest
from dehyst.robot.experiments.sweep import SweepResult, load_sweep, run_sweep
from dehyst.robot.experiments.sweep.points import Summary, ratios_of, summarise
from dehyst.robot.report.sweep import Curve, write_sweep_figure
from dehyst.shell import command

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
                spec, out, workers=request.workers, dask=request.dask, progress=progress, restart=request.restart,
                retry=request.retry, overwrite=request.overwrite,
            )  # fmt: skip
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
            f"{next(filter(None, result.columns['error']))}\nTo try them again: {_line(request, 'retry')}"
        )


def _tell(result: SweepResult, figure: Path) -> None:
    _print(result)
    tell(f"wrote {result.out} ({len(result.points)} rows) and {figure}")


def _line(request: SweepRequest, *more: str) -> str:
    """The line to type, with what was typed; what drops or replaces results is not repeated."""
    typed = {option: getattr(request, option) for option in ("out", "figure", "workers", "dask")}
    return command("sweep", request.sweep, **typed, **dict.fromkeys(more, True))


class _Told:
    """Progress as a bar that is redrawn, or where there is no terminal as a line now and then."""

    def __init__(self, bar: Progress | None) -> None:
        self._bar, self._begin = bar, time.monotonic()
        self._last = self._begin
        if bar is not None:
            self._task = bar.add_task("runs", total=None, failed="", rate="", start=False)

    def __call__(self, done: int, failed: int, total: int, resumed: int) -> None:
        now = time.monotonic()
        fresh, elapsed, first = done - resumed, now - self._begin, done == resumed
        rate, told = _rate(fresh, elapsed), f", {failed} failed" if failed else ""
        if self._bar is not None:
            if first:
                self._bar.start_task(self._task)
            self._bar.update(self._task, completed=done, total=total, failed=told, rate=rate)
        elif first or done == total or now - self._last >= LINE_SECONDS:
            self._last = now
            left = f", {_duration((total - done) * elapsed / fresh)} left" if fresh and done != total else ""
            kept = f", {resumed} of them from the journal" if first and resumed else ""
            tell(f"{done} of {total} runs{kept}{told}{', ' + rate if rate else ''}{left}")


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
    columns = (
        BarColumn(),
        TextColumn("{task.completed} of {task.total} runs{task.fields[failed]}"),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(compact=True),
        TextColumn("left"),
    )
    with progress_bar(*columns) as bar:
        yield _Told(bar)


def _print(result: SweepResult) -> None:
    """Print medians and ranges, one line a set of parameters."""
    rows = summarise(result.spec, result.points, result.columns)
    labels, out = list(rows[0].figures), terminal()
    heads: list[str | Column] = [Column("study", overflow="fold"), Column("parameters", overflow="fold"), ">runs"]
    heads += [Column(label, justify="right", overflow="fold") for label in labels]
    out.print(f"{result.spec.name}: median (lowest to highest) over the runs", style="bold")
    shown = table(heads, (_cells(row, labels) for row in rows[:MOST_ROWS]))
    out.print(shown, width=max(out.width, 60 + 22 * len(labels)), crop=False)
    if len(rows) > MOST_ROWS:
        out.print(f"and {len(rows) - MOST_ROWS} more; all are in {result.out}")


def _cells(row: Summary, labels: Sequence[str]) -> tuple[str, ...]:
    values = ", ".join(f"{key.rpartition('.')[2]} {_short(value)}" for key, value in row.values.items())
    runs = f"{row.runs}" + (f" ({row.failed} failed)" if row.failed else "")
    found = [row.figures[label] for label in labels]
    figures = ("" if figure is None else "{:.3f} ({:.3f} to {:.3f})".format(*figure) for figure in found)
    return (row.study, values, runs, *figures)


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
