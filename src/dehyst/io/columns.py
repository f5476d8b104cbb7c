"""Finds a column by name, by name without unit, or by number; finds a run."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ColumnError, RunError
from dehyst.io.table import FRAME, Table, finite, list_names
from dehyst.units import parse_unit, words

RUN_WORDS = frozenset(
    words("run runs trial experiment exp test episode session series recording measurement messung versuch lauf")
)
MAX_NUMBERED_RUNS = 1000


def find_column(table: Table, wanted: str, role: str) -> str:
    """Name of the column that a user means.

    Tried in turn: the exact name, the name in any case, the name without its unit, ``#3`` for the third column.
    """
    wanted = str(wanted)
    found = matching(table, wanted)
    if len(found) == 1:
        if found[0] in table.labels:
            example = ", ".join(dict.fromkeys(table.labels[found[0]][:200].tolist()[:3]))
            raise ColumnError(
                f"{role} column '{found[0]}' of {table.name} holds text ({example}), not numbers. {_available(table)}",
                column=found[0],
                columns=tuple(table.columns),
            )
        if found[0] in table.columns:
            return found[0]
    if len(found) > 1:
        raise ColumnError(
            f"{role} column '{wanted}' of {table.name} may be any of {list_names(found)}. Type one of these names.",
            column=wanted,
            columns=tuple(found),
        )
    names = list(table.columns)
    close = difflib.get_close_matches(wanted.lower(), [name.lower() for name in names], n=1, cutoff=0.5)
    hint = next((f"Did you mean '{name}'? " for name in names if close and name.lower() == close[0]), "")
    hint = _indexed(table, wanted) or hint
    raise ColumnError(
        f"{table.name} has no {role} column '{wanted}'. {hint}{_available(table)}",
        column=wanted,
        columns=tuple(names),
    )


def matching(table: Table, wanted: str) -> list[str]:
    """Columns that a name may mean, as `find_column` tries; none or several are no answer."""
    if wanted in table.order:
        return [wanted]
    low = wanted.strip().lower()
    for spelled in (lambda name: name.lower(), lambda name: parse_unit(name)[0].lower()):
        found = [name for name in table.order if spelled(name) == low]
        if found:
            return found
    if wanted.startswith("#") and wanted[1:].isascii() and wanted[1:].isdigit() and len(wanted) < 8:
        index = int(wanted[1:])
        return [table.order[index - 1]] if 1 <= index <= len(table.order) else []
    return []


def _indexed(table: Table, wanted: str) -> str:
    """Which column an index means: ``x[:,6]`` counts from 0 as Python does, ``x(:,7)`` from 1 as MATLAB does."""
    match = re.fullmatch(r"(.+?)(?:\[:, *(\d+)\]|\(:, *(\d+)\))", wanted.strip())
    if not match:
        return ""
    first = 1 if match[2] else 0
    name = f"{match[1]}_{int(match[2] or match[3]) + first}"
    return f"Its columns count from 1: did you mean '{name}'? " if name in table.columns else ""


def _available(table: Table) -> str:
    look = "dehyst.inspect_log(df)" if table.name == FRAME else "dehyst inspect LOG"
    return f"Its columns of numbers are: {list_names(table.columns)}. To see what they hold: {look}"


def run_column(table: Table) -> str | None:
    """Name of the column that tells the runs apart, or None.

    A column named run, trial, experiment... that holds text or whole numbers; else a text column whose labels
    come in unbroken blocks.
    """
    texts = [name for name, labels in table.labels.items() if labels.size == table.rows.size]
    named = [name for name in texts if RUN_WORDS & set(words(name))]
    if named:
        return named[0]
    for name, values in table.columns.items():
        if RUN_WORDS & set(words(name)) and values.size == table.rows.size and _is_whole(values):
            return name
    return next((name for name in texts if _in_blocks(table.labels[name])), None)


def _is_whole(values: Array) -> bool:
    good = values[finite(values)]
    return bool(good.size and np.all(good == np.round(good)) and np.unique(good).size <= MAX_NUMBERED_RUNS)


def _in_blocks(labels: npt.NDArray[np.str_]) -> bool:
    starts = _block_starts(labels)
    return starts.size == np.unique(labels[starts]).size and starts.size <= max(1, labels.size // 4)


def _block_starts(labels: npt.NDArray[np.str_]) -> npt.NDArray[np.int64]:
    """Where a run of equal labels begins: sorting these few instead of all rows keeps large logs quick."""
    return np.concatenate(([0], np.flatnonzero(labels[1:] != labels[:-1]) + 1)).astype(np.int64)[: labels.size]


def run_labels(table: Table) -> npt.NDArray[np.str_] | None:
    """Run of each row, (rows,), "" where it is missing; None if the log does not tell runs apart."""
    name = run_column(table)
    if name is None:
        return None
    if name in table.labels:
        return table.labels[name]
    return numbered_labels(table.columns[name])


def numbered_labels(values: Array) -> npt.NDArray[np.str_]:
    """Labels of runs that are numbered, "" where there is no number."""
    good = finite(values)
    labels = np.full(values.size, "", dtype="U24")
    labels[good] = np.char.mod("%d", values[good].astype(np.int64)) if good.any() else ""
    return labels


def count_runs(table: Table) -> dict[str, int]:
    """Runs in the order of the log and their number of rows."""
    labels = run_labels(table)
    if labels is None:
        return {}
    starts = _block_starts(labels)
    lengths = np.diff(np.concatenate((starts, [labels.size])))
    runs: dict[str, int] = {}
    for name, length in zip(labels[starts].tolist(), lengths.tolist(), strict=True):
        if name:
            runs[name] = runs.get(name, 0) + length
    return runs


def select_run(table: Table, run: str | None) -> tuple[str | None, npt.NDArray[np.bool_]]:
    """Run that is meant and the rows that belong to it."""
    everything = np.ones(table.rows.size, dtype=bool)
    runs = count_runs(table)
    listed = ", ".join(f"{name} ({rows} rows)" for name, rows in list(runs.items())[:40])
    if not runs:
        if run is None:
            return None, everything
        raise RunError(
            f"{table.name} does not tell runs apart, so there is no run '{run}': it has no text column and none "
            f"called run, trial or experiment. Leave the run out, or cut a window with --from and --to.",
            run=run,
        )
    if run is None and len(runs) > 1:
        raise RunError(
            f"{table.name} holds {len(runs)} runs and none was named: {listed}. What the actuator remembers does not "
            f"carry over from one to the next, so name one: --run {next(iter(runs))}",
            runs=runs,
        )
    chosen = next(iter(runs)) if run is None else str(run)
    if chosen not in runs:
        low = {name.lower(): name for name in runs}
        close = difflib.get_close_matches(chosen.lower(), list(low), n=1, cutoff=0.5)
        hint = f"Did you mean '{low[close[0]]}'? " if close else ""
        raise RunError(f"{table.name} has no run '{chosen}'. {hint}It holds: {listed}.", run=chosen, runs=runs)
    labels = run_labels(table)
    return chosen, everything if labels is None else np.asarray(labels == chosen)


def provenance(
    table: Table,
    columns: Mapping[str, str | None],
    run: str | None,
    window: list[float | None],
    rows: tuple[int, int, int],
) -> dict[str, Any]:
    """Where samples came from: file, fingerprint, columns by role, run, window, and how many rows, from which to which.

    A recording carries it, a model card, and every report.
    """
    return {
        "file": table.name,
        "sha256": table.sha256,
        **({"sheet": table.sheet} if table.sheet else {}),
        **columns,
        "run_column": run_column(table) if run is not None else None,
        "run": run,
        "window": window,
        **dict(zip(("rows", "first_row", "last_row"), rows, strict=True)),
    }
