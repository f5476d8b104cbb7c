"""From the columns of a table to cleaned samples: run, time window, one time column or two."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import MINIMUM_SAMPLES, gap_limit
from dehyst.errors import ColumnError, DehystError, RecordingError, TimeError
from dehyst.findings import Finding
from dehyst.io._checks import check_pair
from dehyst.io._clean import (
    Context,
    Samples,
    drop_outliers,
    drop_unmeasured,
    find_gaps,
    hold_unmeasured,
)
from dehyst.io._clocks import (
    EPOCH,
    choose_clock,
    clock_names,
    newest_first,
    no_clock,
    require_unit,
    same_clock,
    seconds,
    unit_finding,
)
from dehyst.io._columns import find_column, select_run
from dehyst.io._feedback import closed_loop_findings
from dehyst.io._order import Jumps, order_time
from dehyst.io._policy import POLICY
from dehyst.io._table import LogTable, finite

Window = tuple[float, float]

WHOLE: Window = (-math.inf, math.inf)


def parse_window(start: float | None, stop: float | None) -> Window:
    """Bounds of ``start <= t < stop``, infinite where not given."""
    low, high = WHOLE
    if start is not None:
        low = float(start)
    if stop is not None:
        high = float(stop)
    if not low < high:
        raise TimeError(
            f"the window from {low:g} s to {high:g} s is empty. --from must be less than --to, both in seconds of the "
            f"log's own time.",
            start=start,
            stop=stop,
        )
    return low, high


def context(
    table: LogTable, columns: tuple[str, ...], findings: list[Finding] | None = None
) -> Context:
    """What messages about some columns of a table need; findings begin with those of the table."""
    units = tuple(table.label(name)[1] for name in columns)
    if findings is None:
        findings = list(table.findings)
    return Context(table.name, columns, table.row_word, units, findings)


def read_pair(
    table: LogTable, about: Context, time: str | None, run: str | None, window: Window
) -> tuple[Samples, str | None, str | None]:
    """Input and output of a table, cleaned and checked, with the run and the time column that were used.

    `about` names the two columns; the errors are those of `read_log`.
    """
    samples, chosen, clock = _on_one_clock(table, about, time, run, window)
    samples = find_gaps(samples, about)
    require_samples(samples, about, window)
    about.findings.extend(check_pair(table, about.columns, samples))
    mask = select_rows(table, about.columns[0], run)[1]
    about.findings.extend(closed_loop_findings(table, mask, *about.columns))
    return samples, chosen, clock


def _on_one_clock(
    table: LogTable, about: Context, time: str | None, run: str | None, window: Window
) -> tuple[Samples, str | None, str | None]:
    x_name, y_name = about.columns
    x_size, y_size = table.columns[x_name].size, table.columns[y_name].size
    one_length = x_size == y_size
    first = choose_clock(table, x_name, _wanted_clock(table, x_name, time, one_length))
    second = choose_clock(table, y_name, _wanted_clock(table, y_name, time, one_length))
    chosen, mask = select_rows(table, x_name, run)
    agree = first == second or (first and second and same_clock(table, first, second))
    pair: list[Samples] = []
    if one_length and agree:
        samples = selected_samples(table, about.columns, first, mask, about)
        if first is None:
            about.say("no-time", no_clock(table))
        elif time is None:
            _warn_other_clocks(table, first, x_size, about)
        if first is None or not logged_in_turns(*samples.values):
            return prepare_recording(samples, about, window), chosen, first
        for values in samples.values:
            signal = Samples(samples.time, (values,), samples.rows)
            pair.append(signal.take(np.isfinite(values)))
    else:
        y_mask = select_rows(table, y_name, run)[1]
        pair = _from_common_zero(
            selected_samples(table, (x_name,), first, mask, about, shift=True),
            selected_samples(table, (y_name,), second, y_mask, about, shift=True),
        )
    # Each signal keeps its own context in messages: a bad cell of one is not a bad cell of the other.
    x_about = replace(about, columns=about.columns[:1], units=about.units[:1])
    y_about = replace(about, columns=about.columns[1:], units=about.units[1:])
    x = prepare_recording(pair[0], x_about, window)
    y = prepare_recording(pair[1], y_about, window)
    return merge_clocks(x, y, about), chosen, first


def _wanted_clock(table: LogTable, column: str, time: str | None, one_length: bool) -> str | None:
    """Time column that was named, where it fits: of two signals of different lengths it is the clock of one."""
    if time is None or one_length:
        return time
    named = table.columns[find_column(table, time, "time")]
    if named.size != table.columns[column].size:
        return None
    return time


def select_rows(
    table: LogTable, column: str, run: str | None
) -> tuple[str | None, npt.NDArray[np.bool_]]:
    """Run and mask; columns on clocks of their own (other lengths) have no runs."""
    if table.columns[column].size != table.rows.size:
        return None, np.ones(table.columns[column].size, dtype=bool)
    return select_run(table, run)


def selected_samples(
    table: LogTable,
    names: tuple[str, ...],
    clock: str | None,
    mask: npt.NDArray[np.bool_],
    about: Context,
    shift: bool = False,
) -> Samples:
    """Samples of some columns on one clock, in the rows of `mask`; `shift` keeps stamps counted from 1970."""
    everything = bool(mask.all())
    rows = table.rows[: mask.size]
    if not everything:
        rows = rows[mask]
    columns: dict[str, Array] = {}
    for column in filter(None, (*names, clock)):
        if column in table.refused:
            raise ColumnError(table.refused[column], column=column)
        columns[column] = table.columns[column]
        if not everything:
            columns[column] = columns[column][mask]
    part = LogTable(
        table.name, columns, table.units, table.rows, clocks=table.clocks, stamps=table.stamps
    )
    stamps: Array | None = None
    if clock:
        require_unit(part, clock)
        stamps, origin = seconds(part, clock)
        if shift:
            stamps = stamps + origin
        for finding in unit_finding(part, clock, stamps):
            about.say_once(finding)
    samples = Samples(stamps, tuple(columns[name] for name in names), rows)
    if stamps is None or not newest_first(stamps):
        return samples
    message = (
        f"{about.log} is written newest row first; it was turned around, and time counts from the oldest row. "
        f"Nothing to do."
    )
    about.say_once(Finding("reversed-time", message))
    return samples.take(np.arange(rows.size - 1, -1, -1))


def prepare_recording(
    samples: Samples, about: Context, window: Window, hold: bool = False
) -> Samples:
    """Window, then drop (or hold), then order: a fault outside the window is none of the user's business.

    Whether the clock was set is judged on the whole log: what one window shows of it may look like another thing.
    """
    jumps: Jumps | None = None
    if window != WHOLE and samples.time is not None:
        with suppress(DehystError):
            jumps = prepare_recording(samples, replace(about, findings=[]), WHOLE, hold).jumps
    samples = cut_window(samples, about, window)
    clean = drop_unmeasured
    if hold:
        clean = hold_unmeasured
    samples = clean(samples, about)
    return order_time(drop_outliers(samples, about, hold), about, jumps)


def cut_window(samples: Samples, about: Context, window: Window) -> Samples:
    """Samples of a window."""
    if window == WHOLE:
        return samples
    t = samples.time
    if t is None:
        raise TimeError(
            f"{about.log} has no time column, so it cannot be cut to {_bounds(window)}. Name one with --time, or leave "
            f"--from and --to out.",
            log=about.log,
        )
    with np.errstate(invalid="ignore"):
        inside = (t >= window[0]) & (t < window[1])
    if not inside.any():
        stamps = t[np.isfinite(t)]
        spans = "no time at all"
        if stamps.size:
            spans = f"from {stamps.min():.6g} s to {stamps.max():.6g} s"
        raise TimeError(
            f"no sample of {about.log} lies in the window {_bounds(window)}; the log covers {spans}. Change --from "
            f"and --to.",
            window=window,
        )
    return samples.take(inside)


def _bounds(window: Window) -> str:
    """A window in words, without the end that was not named."""
    text = "t"
    if math.isfinite(window[0]):
        text = f"{window[0]:g} s <= t"
    if math.isfinite(window[1]):
        text += f" < {window[1]:g} s"
    return text


def require_samples(
    samples: Samples, about: Context, window: Window, least: int = MINIMUM_SAMPLES
) -> None:
    """Refuse fewer samples than a loop needs."""
    if samples.rows.size < least:
        cut = ""
        if window != WHOLE:
            cut = f" in the window {_bounds(window)}"
        raise RecordingError(
            f"{about.log} has {samples.rows.size} usable rows{cut}; a loop needs at least {least}. Check the window "
            f"(--from, --to), the run (--run) and the columns.",
            rows=samples.rows.size,
        )


def logged_in_turns(x: Array, y: Array) -> bool:
    """Whether most rows hold only one of two signals."""
    has_x, has_y = finite(x), finite(y)
    either = int(np.sum(has_x | has_y))
    both = int(np.sum(has_x & has_y))
    # A sensor that was simply not connected for most of the log is no second clock.
    return (
        min(has_x.sum(), has_y.sum()) >= 4
        and both < POLICY.together * either
        and bool(np.any(has_x & ~has_y))
    )


def merge_clocks(x: Samples, y: Samples, about: Context) -> Samples:
    """Interpolate the output linearly at the input's stamps, over the time that both cover.

    Stamps of the input that fall into a gap of the output are left out.
    """
    tx, ty = x.time, y.time
    both = " and ".join(about.columns)
    if tx is None or ty is None:
        raise TimeError(
            f"{both} of {about.log} have {x.rows.size} and {y.rows.size} samples and no time "
            f"column, so nothing tells which belong together. Log a time column for each, or resample them to one.",
            columns=about.columns,
        )
    if x.breaks or y.breaks:
        raise TimeError(
            f"{both} of {about.log} are on two clocks, and one of them restarts; they cannot be "
            f"matched beyond that. Cut a window that holds one recording: --from S --to S",
            columns=about.columns,
        )
    if tx.size < 2 or ty.size < 2:
        raise TimeError(
            f"{about.log}: a signal on two clocks needs two samples on each.", columns=about.columns
        )
    inside = (tx >= ty[0]) & (tx <= ty[-1])
    if not inside.any():
        raise TimeError(
            f"the clocks of {both} in {about.log} do not overlap: the input covers {tx[0]:.6g} "
            f"to {tx[-1]:.6g} s, the output {ty[0]:.6g} to {ty[-1]:.6g} s. Shift one of them, or name the right time "
            f"column with --time.",
            columns=about.columns,
        )
    right = np.clip(np.searchsorted(ty, tx), 1, ty.size - 1)
    exact = np.isin(tx, ty)
    inside &= exact | (ty[right] - ty[right - 1] <= gap_limit(np.diff(ty)))
    covered = x.take(inside)
    assert covered.time is not None
    output = np.interp(covered.time, ty, y.values[0])
    about.say(
        "two-clocks",
        f"{both} of {about.log} are on two clocks (steps of {np.median(np.diff(tx)):.3g} "
        f"and {np.median(np.diff(ty)):.3g} s); the output was interpolated at the {covered.rows.size} stamps of the "
        f"input that both cover. A delay between the clocks would look like hysteresis: log both in one row.",
    )
    return Samples(covered.time, (covered.values[0], output), covered.rows)


def _from_common_zero(x: Samples, y: Samples) -> list[Samples]:
    """Two epoch clocks count from the earlier of their first samples; other clocks keep their values."""
    if x.time is None or y.time is None:
        return [x, y]
    x_stamps = x.time[np.isfinite(x.time)]
    y_stamps = y.time[np.isfinite(y.time)]
    if x_stamps.size == 0 or y_stamps.size == 0:
        return [x, y]
    if min(np.median(x_stamps), np.median(y_stamps)) < EPOCH[0]:
        return [x, y]
    zero = float(min(x_stamps[0], y_stamps[0]))
    return [Samples(x.time - zero, x.values, x.rows), Samples(y.time - zero, y.values, y.rows)]


def _warn_other_clocks(table: LogTable, clock: str, size: int, about: Context) -> None:
    if clock in table.clocks.values():
        return
    other_clocks: list[str] = []
    for name in clock_names(table):
        if table.columns[name].size == size and not same_clock(table, clock, name):
            other_clocks.append(name)
    if other_clocks:
        about.say(
            "several-time-columns",
            f"{table.name} has more than one time column; '{clock}' was taken, and {', '.join(other_clocks)} tells "
            f"another time. If that is the right one: --time {other_clocks[0]}",
        )
