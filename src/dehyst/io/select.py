"""From the columns of a table to cleaned samples: run, time window, one time column or two."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data.loops import gap_limit
from dehyst.data.recording import MINIMUM_SAMPLES
from dehyst.errors import ColumnError, DehystError, RecordingError, TimeError
from dehyst.findings import Finding
from dehyst.io.checks import check_pair
from dehyst.io.clean import Context, Samples, drop_outliers, drop_unmeasured, find_gaps, hold_unmeasured
from dehyst.io.clocks import (
    choose_clock,
    clock_names,
    newest_first,
    no_clock,
    require_unit,
    same_clock,
    seconds,
    unit_finding,
)
from dehyst.io.columns import find_column, select_run
from dehyst.io.order import Jumps, order_time
from dehyst.io.table import Table, finite

Window = tuple[float, float]

TOGETHER = 0.5  # fewer rows than this share hold both signals: they were logged in turns
WHOLE: Window = (-math.inf, math.inf)


def parse_window(start: float | None, stop: float | None) -> Window:
    """Bounds of ``start <= t < stop``, infinite where not given."""
    window = (-math.inf if start is None else float(start), math.inf if stop is None else float(stop))
    if not window[0] < window[1]:
        raise TimeError(
            f"the window from {window[0]:g} s to {window[1]:g} s is empty. --from must be less than --to, both in "
            f"seconds of the log's own time.",
            start=start,
            stop=stop,
        )
    return window


def context(table: Table, columns: tuple[str, ...], findings: list[Finding] | None = None) -> Context:
    """What messages about some columns of a table need; findings begin with those of the table."""
    units = tuple(table.label(name)[1] for name in columns)
    return Context(table.name, columns, table.row_word, units, list(table.findings) if findings is None else findings)


def read_pair(
    table: Table, about: Context, time: str | None, run: str | None, window: Window
) -> tuple[Samples, str | None, str | None]:
    """Input and output of a table, cleaned and checked, with the run and the time column that were used.

    `about` names the two columns; the errors are those of `read_log`.
    """
    samples, chosen, clock = _on_one_clock(table, about, time, run, window)
    samples = find_gaps(samples, about)
    require_samples(samples, about, window)
    about.findings.extend(check_pair(table, about.columns, samples))
    return samples, chosen, clock


def _on_one_clock(
    table: Table, about: Context, time: str | None, run: str | None, window: Window
) -> tuple[Samples, str | None, str | None]:
    x_name, y_name = about.columns
    x_size, y_size = table.columns[x_name].size, table.columns[y_name].size
    clocks = [choose_clock(table, name, _wanted_clock(table, name, time, x_size == y_size)) for name in about.columns]
    chosen, mask = select_rows(table, x_name, run)
    first, second = clocks
    if x_size == y_size and (first == second or (first and second and same_clock(table, first, second))):
        samples = samples_of(table, about.columns, first, mask, about)
        if first is None:
            about.say("no-time", no_clock(table))
        elif time is None:
            _warn_other_clocks(table, first, x_size, about)
        if first is None or not logged_in_turns(*samples.values):
            return prepare(samples, about, window), chosen, first
        pair = tuple(Samples(samples.time, (v,), samples.rows).take(np.isfinite(v)) for v in samples.values)
    else:
        masks = [select_rows(table, name, run)[1] for name in about.columns]
        pair = tuple(
            samples_of(table, (name,), clock, m, about, shift=True)
            for name, clock, m in zip(about.columns, clocks, masks, strict=True)
        )
        pair = _from_common_zero(pair)
    # Each signal keeps its own context in messages: a bad cell of one is not a bad cell of the other.
    x, y = (
        prepare(s, replace(about, columns=(name,), units=(unit,)), window)
        for s, name, unit in zip(pair, about.columns, about.units, strict=True)
    )
    return merge_clocks(x, y, about), chosen, first


def _wanted_clock(table: Table, column: str, time: str | None, one_length: bool) -> str | None:
    """Time column that was named, where it fits: of two signals of different lengths it is the clock of one."""
    if time is None or one_length:
        return time
    named = table.columns[find_column(table, time, "time")]
    return time if named.size == table.columns[column].size else None


def select_rows(table: Table, column: str, run: str | None) -> tuple[str | None, npt.NDArray[np.bool_]]:
    """Run and mask; columns on clocks of their own (other lengths) have no runs."""
    if table.columns[column].size != table.rows.size:
        return None, np.ones(table.columns[column].size, dtype=bool)
    return select_run(table, run)


def samples_of(
    table: Table,
    names: tuple[str, ...],
    clock: str | None,
    mask: npt.NDArray[np.bool_],
    about: Context,
    shift: bool = False,
) -> Samples:
    """Samples of some columns on one clock, in the rows of `mask`; `shift` keeps stamps counted from 1970."""
    wanted = dict.fromkeys((*names, *((clock,) if clock else ())))
    for column in wanted:
        if column in table.refused:
            raise ColumnError(table.refused[column], column=column)
    everything = bool(mask.all())
    columns = {n: table.columns[n] if everything else table.columns[n][mask] for n in wanted}
    part = Table(table.name, columns, table.units, table.rows, clocks=table.clocks, stamps=table.stamps)
    stamps: Array | None = None
    if clock:
        require_unit(part, clock)
        stamps, origin = seconds(part, clock)
        stamps = stamps + origin if shift else stamps
        about.findings.extend(f for f in unit_finding(part, clock, stamps) if f not in about.findings)
    rows = table.rows[: mask.size] if everything else table.rows[: mask.size][mask]
    samples = Samples(stamps, tuple(columns[n] for n in names), rows)
    if stamps is None or not newest_first(stamps):
        return samples
    turned = f"{about.log} is written newest row first; it was turned around, and time counts from the oldest row. "
    about.findings.extend(f for f in [Finding("reversed-time", turned + "Nothing to do.")] if f not in about.findings)
    return samples.take(np.arange(rows.size - 1, -1, -1))


def prepare(samples: Samples, about: Context, window: Window, hold: bool = False) -> Samples:
    """Window, then drop (or hold), then order: a fault outside the window is none of the user's business.

    Whether the clock was set is judged on the whole log: what one window shows of it may look like another thing.
    """
    jumps: Jumps | None = None
    if window != WHOLE and samples.time is not None:
        with suppress(DehystError):
            jumps = prepare(samples, replace(about, findings=[]), WHOLE, hold).jumps
    samples = cut_window(samples, about, window)
    samples = (hold_unmeasured if hold else drop_unmeasured)(samples, about)
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
        known = t[np.isfinite(t)]
        spans = f"from {known.min():.6g} s to {known.max():.6g} s" if known.size else "no time at all"
        raise TimeError(
            f"no sample of {about.log} lies in the window {_bounds(window)}; the log covers {spans}. Change --from "
            f"and --to.",
            window=window,
        )
    return samples.take(inside)


def _bounds(window: Window) -> str:
    """A window in words, without the end that was not named."""
    low, high = (f"{bound:g} s" if np.isfinite(bound) else "" for bound in window)
    return f"{low}{' <= ' if low else ''}t{' < ' if high else ''}{high}"


def require_samples(samples: Samples, about: Context, window: Window, least: int = MINIMUM_SAMPLES) -> None:
    """Refuse fewer samples than a loop needs."""
    if samples.rows.size < least:
        cut = f" in the window {_bounds(window)}" if window != WHOLE else ""
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
    return min(has_x.sum(), has_y.sum()) >= 4 and both < TOGETHER * either and bool(np.any(has_x & ~has_y))


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
        raise TimeError(f"{about.log}: a signal on two clocks needs two samples on each.", columns=about.columns)
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
    kept = x.take(inside)
    assert kept.time is not None
    output = np.interp(kept.time, ty, y.values[0])
    about.say(
        "two-clocks",
        f"{both} of {about.log} are on two clocks (steps of {np.median(np.diff(tx)):.3g} "
        f"and {np.median(np.diff(ty)):.3g} s); the output was interpolated at the {kept.rows.size} stamps of the "
        f"input that both cover. A delay between the clocks would look like hysteresis: log both in one row.",
    )
    return Samples(kept.time, (kept.values[0], output), kept.rows)


def _from_common_zero(pair: tuple[Samples, ...]) -> tuple[Samples, ...]:
    """Two epoch clocks count from the earlier of their first samples; other clocks keep their values."""
    times = [s.time for s in pair if s.time is not None and np.isfinite(s.time).any()]
    if len(times) < 2 or min(float(np.nanmedian(t)) for t in times) < 9.78e8:
        return pair
    zero = min(float(t[np.isfinite(t)][0]) for t in times)
    return tuple(Samples(s.time - zero if s.time is not None else None, s.values, s.rows) for s in pair)


def _warn_other_clocks(table: Table, clock: str, size: int, about: Context) -> None:
    others = [
        name
        for name in clock_names(table)
        if name != clock and table.columns[name].size == size and not same_clock(table, clock, name)
    ]
    if others and clock not in table.clocks.values():
        about.say(
            "several-time-columns",
            f"{table.name} has more than one time column; '{clock}' was taken, and {', '.join(others)} tells "
            f"another time. If that is the right one: --time {others[0]}",
        )
