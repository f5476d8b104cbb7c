"""Finds a column by name, by name without unit, or by number; finds a run."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ColumnError, RunError
from dehyst.io._table import FRAME, LogTable, finite, list_names
from dehyst.units import parse_unit, words

RUN_WORDS = frozenset(
    words(
        "run runs trial experiment exp test episode session series recording measurement messung versuch lauf"
    )
)
MAX_NUMBERED_RUNS = 1000


def find_column(table: LogTable, typed_name: str, role: str) -> str:
    """Name of the column that a user means.

    Tried in turn: the exact name, the name in any case, the name without its unit, ``#3`` for the third column.
    """
    typed_name = str(typed_name)
    names_meant = matching(table, typed_name)
    if len(names_meant) == 1:
        if names_meant[0] in table.labels:
            example = ", ".join(dict.fromkeys(table.labels[names_meant[0]][:200].tolist()[:3]))
            raise ColumnError(
                f"{role} column '{names_meant[0]}' of {table.name} holds text ({example}), not "
                f"numbers. {_available(table)}",
                column=names_meant[0],
                columns=tuple(table.columns),
            )
        if names_meant[0] in table.columns:
            return names_meant[0]
    if len(names_meant) > 1:
        raise ColumnError(
            f"{role} column '{typed_name}' of {table.name} may be any of {list_names(names_meant)}. "
            "Type one of these names.",
            column=typed_name,
            columns=tuple(names_meant),
        )
    hint = _indexed(table, typed_name) or _similar(typed_name, table.columns)
    raise ColumnError(
        f"{table.name} has no {role} column '{typed_name}'. {hint}{_available(table)}",
        column=typed_name,
        columns=tuple(table.columns),
    )


def _similar(typed_name: str, names: Iterable[str]) -> str:
    """The name that is most like a mistyped one, as a question; "" if none is."""
    spelled: dict[str, str] = {}
    for name in names:
        spelled.setdefault(name.lower(), name)
    close = difflib.get_close_matches(typed_name.lower(), list(spelled), n=1, cutoff=0.5)
    if not close:
        return ""
    return f"Did you mean '{spelled[close[0]]}'? "


def matching(table: LogTable, typed_name: str) -> list[str]:
    """Columns that a name may mean, as `find_column` tries; none or several are no answer."""
    if typed_name in table.order:
        return [typed_name]
    low = typed_name.strip().lower()
    for spelled in (lambda name: name.lower(), lambda name: parse_unit(name)[0].lower()):
        names_meant = [name for name in table.order if spelled(name) == low]
        if names_meant:
            return names_meant
    if (
        typed_name.startswith("#")
        and typed_name[1:].isascii()
        and typed_name[1:].isdigit()
        and len(typed_name) < 8
    ):
        index = int(typed_name[1:])
        return [table.order[index - 1]] if 1 <= index <= len(table.order) else []
    return []


def _indexed(table: LogTable, typed_name: str) -> str:
    """Which column an index means: ``x[:,6]`` counts from 0 as Python does, ``x(:,7)`` from 1 as MATLAB does."""
    match = re.fullmatch(r"(.+?)(?:\[:, *(\d+)\]|\(:, *(\d+)\))", typed_name.strip())
    if not match:
        return ""
    first = 1 if match[2] else 0
    name = f"{match[1]}_{int(match[2] or match[3]) + first}"
    return f"Its columns count from 1: did you mean '{name}'? " if name in table.columns else ""


def _available(table: LogTable) -> str:
    look = "dehyst.inspect_log(df)" if table.name == FRAME else "dehyst inspect LOG"
    return f"Its columns of numbers are: {list_names(table.columns)}. To see what they hold: {look}"


def run_column(table: LogTable) -> str | None:
    """Name of the column that tells the runs apart, or None.

    A column named run, trial, experiment... that holds text or whole numbers; else a text column whose labels
    come in unbroken blocks.
    """
    texts = [name for name, labels in table.labels.items() if labels.size == table.rows.size]
    for name in texts:
        if RUN_WORDS & set(words(name)):
            return name
    for name, values in table.columns.items():
        if RUN_WORDS & set(words(name)) and values.size == table.rows.size and _is_whole(values):
            return name
    for name in texts:
        if _in_blocks(table.labels[name]):
            return name
    return None


def _is_whole(values: Array) -> bool:
    good = values[finite(values)]
    return bool(
        good.size and np.all(good == np.round(good)) and np.unique(good).size <= MAX_NUMBERED_RUNS
    )


def _in_blocks(labels: npt.NDArray[np.str_]) -> bool:
    starts = _block_starts(labels)
    return starts.size == np.unique(labels[starts]).size and starts.size <= max(1, labels.size // 4)


def _block_starts(labels: npt.NDArray[np.str_]) -> npt.NDArray[np.int64]:
    """Where a run of equal labels begins: sorting these few instead of all rows keeps large logs quick."""
    return np.concatenate(([0], np.flatnonzero(labels[1:] != labels[:-1]) + 1)).astype(np.int64)[
        : labels.size
    ]


def run_labels(table: LogTable) -> npt.NDArray[np.str_] | None:
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


def count_runs(table: LogTable) -> dict[str, int]:
    """Runs in the order of the log and their number of rows."""
    labels = run_labels(table)
    return {} if labels is None else count_labels(labels)


def count_labels(labels: npt.NDArray[np.str_]) -> dict[str, int]:
    """Labels in the order in which they come, and how often; those that are empty do not count."""
    starts = _block_starts(labels)
    lengths = np.diff(np.concatenate((starts, [labels.size])))
    runs: dict[str, int] = {}
    for name, length in zip(labels[starts].tolist(), lengths.tolist(), strict=True):
        if name:
            runs[name] = runs.get(name, 0) + length
    return runs


def select_run(table: LogTable, run: str | None) -> tuple[str | None, npt.NDArray[np.bool_]]:
    """Run that is meant and the rows that belong to it."""
    chosen = choose_run(table.name, count_runs(table), run)
    labels = None if chosen is None else run_labels(table)
    if labels is None:
        return chosen, np.ones(table.rows.size, dtype=bool)
    return chosen, np.asarray(labels == chosen)


def choose_run(log: str, runs: Mapping[str, int], run: str | None) -> str | None:
    """Name of the run that is meant, of those that a log holds; None where it does not tell runs apart."""
    listed = ", ".join(f"{name} ({rows} rows)" for name, rows in list(runs.items())[:40])
    if not runs:
        if run is None:
            return None
        raise RunError(
            f"{log} does not tell runs apart, so there is no run '{run}': it has no text column and none "
            f"called run, trial or experiment. Leave the run out, or cut a window with --from and --to.",
            run=run,
        )
    if run is None and len(runs) > 1:
        raise RunError(
            f"{log} holds {len(runs)} runs and none was named: {listed}. What the actuator remembers does not "
            f"carry over from one to the next, so name one: --run {next(iter(runs))}",
            runs=runs,
        )
    chosen = next(iter(runs)) if run is None else str(run)
    if chosen not in runs:
        hint = _similar(chosen, runs)
        raise RunError(
            f"{log} has no run '{chosen}'. {hint}It holds: {listed}.", run=chosen, runs=runs
        )
    return chosen


def provenance(
    table: LogTable,
    columns: Mapping[str, str | None],
    run: str | None,
    window: list[float | None],
    rows: tuple[int, int, int],
) -> dict[str, Any]:
    """Where samples came from: file, fingerprint, columns by role, run, window, and how many rows, from which to which.

    A recording carries it, a model card, and every report.
    """
    origin: dict[str, Any] = {"file": table.name, "sha256": table.sha256}
    if table.sheet:
        origin["sheet"] = table.sheet
    origin.update(columns)
    origin["run_column"] = None
    if run is not None:
        origin["run_column"] = run_column(table)
    origin["run"] = run
    origin["window"] = window
    origin["rows"], origin["first_row"], origin["last_row"] = rows
    return origin
