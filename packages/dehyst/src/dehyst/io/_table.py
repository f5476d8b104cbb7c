"""Table: the columns of a log file, before input and output are chosen."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Rows
from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.shell import visible
from dehyst.units import parse_unit, stray_suffixes

# No sensor reads this much: meters write 9.9e37 and 3.4e38 for an overload, and squares of more would overflow.
LARGEST = 9e36
SHOWN = 4  # rows that a message names
FRAME = "data frame"  # name of a table that was in memory

Labels = npt.NDArray[np.str_]


@dataclass(frozen=True, eq=False)
class LogTable:
    """Columns of one log file, as they stand in the file."""

    name: str  # file name without its folder
    # (rows,), NaN where a cell is no number; columns with clocks of their own may differ in length
    columns: Mapping[str, Array]
    units: Mapping[str, str]  # of columns, "" where not known
    rows: Rows  # number of each row in the file, from 1: of its line in a text log
    labels: Mapping[str, Labels] = field(default_factory=dict)  # text columns, (rows,)
    row_word: str = "row"  # what `rows` counts: "line", "row" or "sample"
    # column -> its time column, where the format says so
    clocks: Mapping[str, str] = field(default_factory=dict)
    stamps: frozenset[str] = frozenset()  # columns of date-times, in seconds since 1970
    order: tuple[str, ...] = ()  # all column names, text columns too, as in the file
    # single numbers that may matter: a sampling time Ts
    scalars: Mapping[str, float] = field(default_factory=dict)
    sheet: str = ""  # of a workbook
    sha256: str = ""  # fingerprint of the file's bytes
    findings: tuple[Finding, ...] = ()
    # column -> why it is not to be trusted, once it is used
    refused: Mapping[str, str] = field(default_factory=dict)
    every: int = 1  # one of so many rows of the file stands here, beside those that decide (`dehyst.io._thin`)
    samples: int = 0  # rows that these stand for; 0 where they stand for themselves
    # columns whose name ends in what is no unit beside the other names
    stray: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        if not self.order:
            object.__setattr__(self, "order", (*self.columns, *self.labels))
        stray = stray_suffixes(self.order)
        if stray:
            units = dict(self.units)
            # A unit that came from the ending of such a name is none; one from elsewhere stays.
            for name in stray & units.keys():
                if units[name] == parse_unit(name)[1]:
                    units[name] = ""
            object.__setattr__(self, "units", units)
            object.__setattr__(self, "stray", stray)

    def label(self, name: str) -> tuple[str, str]:
        """Name of a column without its unit, and the unit, "" where it is not known."""
        if name in self.stray:
            return name, self.units.get(name) or ""
        bare, unit = parse_unit(name)
        return bare, self.units.get(name) or unit


def finite(values: Array) -> npt.NDArray[np.bool_]:
    """Which values are measurements: neither NaN nor infinite nor beyond `LARGEST`."""
    with np.errstate(invalid="ignore"):
        return np.asarray((values <= LARGEST) & (values >= -LARGEST))


def measured(values: Array) -> Array:
    """Return the values that are measurements; the array itself, not a copy, if all are."""
    good = finite(values)
    if good.all():
        return values
    return values[good]


def usual_step(t: Array) -> float:
    """Median of the steps forward, 0 if there is none."""
    step = np.diff(t)
    step = step[step > 0]
    if step.size == 0:
        return 0.0
    return float(np.median(step))


def plural(count: int) -> str:
    """The s of a noun that is counted."""
    return "" if count == 1 else "s"


def number_of(count: int, noun: str) -> str:
    """A number and its noun.

    Examples
    --------
    >>> number_of(1, "gap"), number_of(3, "gap")
    ('1 gap', '3 gaps')
    """
    return f"{count} {noun}{plural(count)}"


def list_first(texts: Sequence[str], shown: int, mark: str = ", ") -> str:
    """Name the first few texts, and dots for the others.

    Examples
    --------
    >>> list_first(["a", "b", "c"], 2)
    'a, b, ...'
    """
    listed = list(texts[:shown])
    if len(texts) > shown:
        listed.append("...")
    return mark.join(listed)


def list_rows(rows: Rows | Sequence[int], word: str = "line", count: int = 0) -> str:
    """Name the first few rows and the number of the others; `count` if there are more rows than were kept.

    Examples
    --------
    >>> list_rows([3]), list_rows([3, 4, 9, 12, 15, 20])
    ('line 3', 'lines 3, 4, 9, 12 and 2 more')
    """
    numbers = [str(int(row)) for row in rows[:SHOWN]]
    text = f"{word}{plural(len(rows))} {', '.join(numbers)}"
    more = max(count, len(rows)) - len(numbers)
    if more > 0:
        text += f" and {more} more"
    return text


def list_names(names: Iterable[str], shown: int = 30) -> str:
    """Name the first few columns and the number of the others."""
    listed = list(names)
    text = ", ".join(listed[:shown])
    if len(listed) > shown:
        text += f" and {len(listed) - shown} more"
    return text


def unique_names(names: Sequence[str]) -> list[str]:
    """Make column names unique and non-empty: ``x, x, ""`` becomes ``x, x_2, column_3``.

    Examples
    --------
    >>> unique_names(["x", "x", ""])
    ['x', 'x_2', 'column_3']
    """
    unique_list: list[str] = []
    next_number: dict[str, int] = {}  # name -> number of the next one that is called the same
    for number, name in enumerate(names, 1):
        base = unique = name.strip() or f"column_{number}"
        while unique in next_number:
            next_number[base] += 1
            unique = f"{base}_{next_number[base]}"
        next_number[unique] = 1
        unique_list.append(unique)
    return unique_list


def shown_names(names: Sequence[str], log: str, findings: list[Finding]) -> list[str]:
    """Return column names as they can be shown and typed; say which are not as in the file."""
    shown: list[str] = []
    changed: list[str] = []
    for name in names:
        shown.append(visible(name).strip())
        if shown[-1] != name.strip():
            changed.append(shown[-1])
    if changed:
        message = (
            f"{number_of(len(changed), 'column name')} of {log} held line breaks, control characters or marks that "
            f"turn the direction of writing, which a terminal would obey; the names used here are: "
            f"{list_names(changed, 8)}. Type them like this, or rename the columns in the log."
        )
        findings.append(Finding("unprintable-names", message))
    return shown


def require_columns(table: LogTable) -> LogTable:
    """Return the table, or refuse one that holds no numbers at all."""
    if any(map(_holds_numbers, table.columns.values())):
        return table
    texts = ""
    if table.labels:
        texts = f" Its columns are text: {list_names(table.labels)}."
    if table.scalars and table.row_word == "sample":
        texts += f" Of single numbers it holds {list_names(table.scalars, 8)}."
    cure = "Check that it is the right file."
    if table.row_word == "line":
        cure = (
            "Check that it is the right file, and that its delimiter is one of , ; | tab or blanks."
        )
    # What reading noticed is the likelier cause.
    causes = [finding.message for finding in table.findings if finding.code != "column-titles"]
    if causes:
        cure = f"Noticed: {' '.join(causes)}"
    raise LogError(f"log '{table.name}' holds no column of numbers.{texts} {cure}", file=table.name)


def _holds_numbers(column: Array) -> bool:
    # Most columns show a number in their first rows: the others are looked at only if they do not.
    return bool(finite(column[:100]).any() or finite(column).any())
