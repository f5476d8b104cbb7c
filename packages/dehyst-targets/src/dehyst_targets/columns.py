"""Which column of a log has which role: those that were typed, others by their unit, else by a word of their name."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from os import PathLike
from typing import Any

from dehyst.io import inspect_log
from dehyst.units import words


def columns_of(
    path: str | PathLike[str],
    typed: Mapping[str, str | None],
    names: Mapping[str, frozenset[str]],
    reading: Mapping[str, Any],
    units: Mapping[str, Collection[str]] | None = None,
) -> tuple[dict[str, str], list[str]]:
    """Return role -> column where one column fits, and the names of all columns.

    Parameters
    ----------
    path
        Log.
    typed
        Role -> column, None where it was not typed.
    names
        Role -> words of which one is in the column's name.
    reading
        Options of reading.
    units
        Role -> units; a column in one of them comes before one by its name.
    """
    choices = {key: reading[key] for key in ("run", "time_unit", "dt", "sheet") if key in reading}
    listed = inspect_log(path, **choices).columns
    columns = {role: name for role, name in typed.items() if name is not None}
    for role, role_words in names.items():
        free = [column for column in listed if column.name not in columns.values()]
        by_unit = [column.name for column in free if units and column.unit in units[role]]
        by_name = [column.name for column in free if role_words & set(words(column.name))]
        for fitting in (by_unit, by_name):
            if role not in columns and len(fitting) == 1:
                columns[role] = fitting[0]
    return columns, [column.name for column in listed]
