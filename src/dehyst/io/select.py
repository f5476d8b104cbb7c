"""From columns to samples: rows of a run, window, one clock or two."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data.gaps import gap_limit
from dehyst.data.recording import MINIMUM_SAMPLES
from dehyst.errors import ColumnError, RecordingError, TimeError
from dehyst.findings import Finding
from dehyst.io.clean import Context, Samples, drop_unmeasured, hold_unmeasured
from dehyst.io.clocks import choose_clock, clock_names, same_clock, seconds, unit_finding
from dehyst.io.columns import find_column, select_run
from dehyst.io.order import order_time
from dehyst.io.outliers import drop_outliers
from dehyst.io.table import Table, finite

TOGETHER = 0.5  # fewer rows than this share hold both signals: they were logged in turns


def logged_in_turns(x: Array, y: Array) -> bool:
    """Whether most rows hold only one of two signals.

    Examples
    --------
    >>> n = np.nan
    >>> logged_in_turns(np.array([1, n, 2, n, 3, n, 4, n]), np.array([n, 5, n, 6, n, 7, n, 8]))
    True
    """
    has_x, has_y = finite(x), finite(y)
    either = int(np.sum(has_x | has_y))
    both = int(np.sum(has_x & has_y))
    # A sensor that was simply not connected for most of the log is no second clock.
    return min(has_x.sum(), has_y.sum()) >= 4 and both < TOGETHER * either and bool(np.any(has_x & ~has_y))


def merge_clocks(x: Samples, y: Samples, about: Context, findings: list[Finding]) -> Samples:
    """Interpolate the output linearly at the input's stamps, over the time that both cover.

    Stamps of the input that fall into a gap of the output are left out.
    """
    tx, ty = x.time, y.time
    if tx is None or ty is None:
        raise TimeError(
            f"{' and '.join(about.columns)} of {about.log} have {x.rows.size} and {y.rows.size} samples and no time "
            f"column, so nothing tells which belong together. Log a time column for each, or resample them to one.",
            columns=about.columns,
        )
    if x.breaks or y.breaks:
        raise TimeError(
            f"{' and '.join(about.columns)} of {about.log} are on two clocks, and one of them restarts; they cannot be "
            f"matched beyond that. Cut a window that holds one recording: --from S --to S",
            columns=about.columns,
        )
    if tx.size < 2 or ty.size < 2:
        raise TimeError(f"{about.log}: a signal on two clocks needs two samples on each.", columns=about.columns)
    inside = (tx >= ty[0]) & (tx <= ty[-1])
    if not inside.any():
        raise TimeError(
            f"the clocks of {' and '.join(about.columns)} in {about.log} do not overlap: the input covers {tx[0]:.6g} "
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
    findings.append(
        Finding(
            "two-clocks",
            f"{' and '.join(about.columns)} of {about.log} are on two clocks (steps of {np.median(np.diff(tx)):.3g} "
            f"and {np.median(np.diff(ty)):.3g} s); the output was interpolated at the {kept.rows.size} stamps of the "
            f"input that both cover. A delay between the clocks would look like hysteresis: log both in one row.",
        )
    )
    return Samples(kept.time, (kept.values[0], output), kept.rows)


def parse_window(start: float | None, stop: float | None) -> tuple[float, float]:
    """Bounds of ``start <= t < stop``, infinite where not given."""
    window = (-math.inf if start is None else float(start), math.inf if stop is None else float(stop))
    if not window[0] < window[1]:
        raise TimeError(
            f"the window from {start} s to {stop} s is empty. --from must be less than --to, both in seconds of the "
            f"log's own time.",
            start=start,
            stop=stop,
        )
    return window


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
    findings: list[Finding],
    shift: bool = False,
) -> Samples:
    """Samples of some columns on one clock, in the rows of `mask`; `shift` keeps stamps counted from 1970."""
    for column in (*names, clock):
        if column is not None and column in table.refused:
            raise ColumnError(table.refused[column], column=column)
    everything = bool(mask.all())
    wanted = dict.fromkeys((*names, *((clock,) if clock else ())))
    part = Table(
        name=table.name,
        columns={n: table.columns[n] if everything else table.columns[n][mask] for n in wanted},
        units=table.units,
        rows=table.rows,
        clocks=table.clocks,
        stamps=table.stamps,
    )
    stamps: Array | None = None
    if clock:
        stamps, origin = seconds(part, clock)
        stamps = stamps + origin if shift else stamps
        findings.extend(f for f in unit_finding(part, clock, stamps) if f not in findings)
    rows = table.rows[: mask.size] if everything else table.rows[: mask.size][mask]
    return Samples(stamps, tuple(part.columns[n] for n in names), rows)


def prepare(
    samples: Samples, about: Context, window: tuple[float, float], findings: list[Finding], hold: bool = False
) -> Samples:
    """Window, then drop (or hold), then order: a fault outside the window is none of the user's business."""
    samples = cut_window(samples, about, window)
    samples = (hold_unmeasured if hold else drop_unmeasured)(samples, about, findings)
    samples = drop_outliers(samples, about, findings, hold)
    return order_time(samples, about, findings)


def cut_window(samples: Samples, about: Context, window: tuple[float, float]) -> Samples:
    """Samples of a window."""
    if not (math.isfinite(window[0]) or math.isfinite(window[1])):
        return samples
    t = samples.time
    if t is None:
        raise TimeError(
            f"{about.log} has no time column, so it cannot be cut from {window[0]:g} s to {window[1]:g} s. "
            f"Name one with --time, or leave --from and --to out.",
            log=about.log,
        )
    with np.errstate(invalid="ignore"):
        inside = (t >= window[0]) & (t < window[1])
    if not inside.any():
        known = t[np.isfinite(t)]
        spans = f"from {known.min():.6g} s to {known.max():.6g} s" if known.size else "no time at all"
        raise TimeError(
            f"no sample of {about.log} lies in the window {window[0]:g} s <= t < {window[1]:g} s; the log covers "
            f"{spans}. Change --from and --to.",
            window=window,
        )
    return samples.take(inside)


def pair_samples(
    table: Table,
    x_name: str,
    y_name: str,
    time: str | None,
    run: str | None,
    window: tuple[float, float],
    about: Context,
    findings: list[Finding],
) -> tuple[Samples, str | None, str | None]:
    """Input and output on one clock, cleaned, with the run and the time column that were used."""
    x_size, y_size = table.columns[x_name].size, table.columns[y_name].size
    clocks = [
        choose_clock(table, name, _wanted_clock(table, name, time, x_size == y_size)) for name in (x_name, y_name)
    ]
    chosen, mask = select_rows(table, x_name, run)
    one_clock = x_size == y_size and (
        clocks[0] == clocks[1] or (clocks[0] is not None and clocks[1] is not None and same_clock(table, *clocks))  # type: ignore[arg-type]
    )
    if one_clock:
        samples = samples_of(table, (x_name, y_name), clocks[0], mask, findings)
        if clocks[0] is None:
            findings.append(
                Finding(
                    "no-time",
                    f"{table.name} has no time column: gaps, rate dependence and drift cannot be seen. Log one, or "
                    f"name it with --time.",
                )
            )
        elif time is None:
            _warn_other_clocks(table, clocks[0], x_size, findings)
        if clocks[0] is None or not logged_in_turns(*samples.values):
            return prepare(samples, about, window, findings), chosen, clocks[0]
        pair = tuple(Samples(samples.time, (v,), samples.rows).take(np.isfinite(v)) for v in samples.values)
    else:
        masks = [select_rows(table, name, run)[1] for name in (x_name, y_name)]
        pair = tuple(
            samples_of(table, (name,), clock, m, findings, shift=True)
            for name, clock, m in zip((x_name, y_name), clocks, masks, strict=True)
        )
        pair = _from_common_zero(pair)
    # Each signal keeps its own context in messages: a bad cell of one is not a bad cell of the other.
    ready = [
        prepare(s, Context(about.log, (name,), about.word, (unit,)), window, findings)
        for s, name, unit in zip(pair, (x_name, y_name), about.units, strict=True)
    ]
    return merge_clocks(ready[0], ready[1], about, findings), chosen, clocks[0]


def _from_common_zero(pair: tuple[Samples, ...]) -> tuple[Samples, ...]:
    """Two epoch clocks count from the earlier of their first samples; other clocks keep their values."""
    times = [s.time for s in pair if s.time is not None and np.isfinite(s.time).any()]
    if len(times) < 2 or min(float(np.nanmedian(t)) for t in times) < 9.78e8:
        return pair
    zero = min(float(t[np.isfinite(t)][0]) for t in times)
    return tuple(Samples(s.time - zero if s.time is not None else None, s.values, s.rows) for s in pair)


def _warn_other_clocks(table: Table, clock: str, size: int, findings: list[Finding]) -> None:
    others = [
        name
        for name in clock_names(table)
        if name != clock and table.columns[name].size == size and not same_clock(table, clock, name)
    ]
    if others and clock not in table.clocks.values():
        findings.append(
            Finding(
                "several-time-columns",
                f"{table.name} has more than one time column; '{clock}' was taken, and {', '.join(others)} tells "
                f"another time. If that is the right one: --time {others[0]}",
            )
        )


def require_samples(
    samples: Samples, about: Context, window: tuple[float, float], least: int = MINIMUM_SAMPLES
) -> None:
    """Refuse fewer samples than a loop needs."""
    if samples.rows.size < least:
        cut = f" in the window {window[0]:g} s <= t < {window[1]:g} s" if window != (-math.inf, math.inf) else ""
        raise RecordingError(
            f"{about.log} has {samples.rows.size} usable rows{cut}; a loop needs at least {least}. Check the window "
            f"(--from, --to), the run (--run) and the columns.",
            rows=samples.rows.size,
        )


def _wanted_clock(table: Table, column: str, time: str | None, one_length: bool) -> str | None:
    """Time column that was named, where it fits: of two signals of different lengths it is the clock of one."""
    if time is None or one_length:
        return time
    named = table.columns[find_column(table, time, "time")]
    return time if named.size == table.columns[column].size else None
