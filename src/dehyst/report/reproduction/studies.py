"""What a study is on the page: a figure, sentences computed from its columns, a table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.experiments.results import Reproduction
from dehyst.report.reproduction.numbers import joints_of, left_off
from dehyst.report.reproduction.picture import Plate
from dehyst.report.tables import Table
from dehyst.report.text import number, short

Columns = Mapping[str, Any]

REST, SMALLER, DOUBLE, GAINS = "rest", "smaller hysteresis", "double compensation", "high gains"


@dataclass(frozen=True)
class Study:
    """A part of the page: a figure, sentences about it, a table."""

    plate: Plate
    words: tuple[str, ...]
    table: Table | None = None


def subject(result: Reproduction) -> tuple[str, int] | None:
    """Return plant and joint that the studies are of, the first of each; None without any."""
    joints = joints_of(result)
    return (next(iter(result.plants)), joints[0]) if result.plants and joints else None


def subject_words(result: Reproduction) -> str:
    """Say what the studies are of: "Joint 1 alone on plant dahl."."""
    about = subject(result)
    return "" if about is None else f"Joint {about[1]} alone, plant {short(about[0], 40)}, first seed."


def nothing_to_study(result: Reproduction) -> str:
    """Say that the studies show nothing, because the compensator of their joint was left off; "" if it was not."""
    about = subject(result)
    if about is None or not result.studies or not left_off(result.plants[about[0]], about[1]):
        return ""
    return (
        f"The studies at rest and of where compensation hurts were run on joint {about[1]} of plant "
        f"{short(about[0], 40)}, whose model was not accepted: no compensator was switched on, so they would compare a "
        "run with itself. Name a plant with hysteresis first to see them."
    )


def other_studies(result: Reproduction) -> tuple[Table, ...]:
    """Return studies of other names as plain tables."""
    known = {REST, SMALLER, DOUBLE, GAINS}
    return tuple(table_of(short(name, 80), columns) for name, columns in result.studies.items() if name not in known)


def numbers_of(values: Any) -> Array:
    """Return a column as numbers, (N,)."""
    return np.asarray(values, dtype=np.float64)


def column(columns: Columns, study: str, name: str) -> Array:
    """Return a column by its name, (N,); raise `ParameterError` if the study has none of that name."""
    if name not in columns:
        raise ParameterError(
            f"the study {study!r} has no column {name!r}; it has {', '.join(map(str, columns)) or 'none'}. The report "
            f"draws it over that column: add it, or give the study another name to have it shown as a table.",
            study=study,
            column=name,
        )
    return numbers_of(columns[name])


def table_of(title: str, columns: Columns, limit: int = 60) -> Table:
    """Return the columns as a table of at most `limit` rows."""
    rows = list(zip(*(list(values) for values in columns.values()), strict=False))[:limit]
    cells = tuple(tuple(value if isinstance(value, str) else number(float(value)) for value in row) for row in rows)
    head = tuple(name.replace("_1_s", " [1/s]").replace("ratio_", "on/off, ").replace("_", " ") for name in columns)
    return Table(title, head, cells)
