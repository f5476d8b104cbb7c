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


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of one log file, as they stand in the file."""

    name: str  # file name without its folder
    columns: Mapping[str, Array]  # (rows,), NaN where a cell is no number; with clocks of their own they may differ
    units: Mapping[str, str]  # of columns, "" where not known
    rows: Rows  # number of each row in the file, from 1: of its line in a text log
    labels: Mapping[str, npt.NDArray[np.str_]] = field(default_factory=dict)  # text columns, (rows,)
    row_word: str = "row"  # what `rows` counts: "line", "row" or "sample"
    clocks: Mapping[str, str] = field(default_factory=dict)  # column -> its time column, where the format says so
    stamps: frozenset[str] = frozenset()  # columns of date-times, in seconds since 1970
    order: tuple[str, ...] = ()  # all column names, text columns too, as in the file
    scalars: Mapping[str, float] = field(default_factory=dict)  # single numbers that may matter: a sampling time Ts
    sheet: str = ""  # of a workbook
    sha256: str = ""  # fingerprint of the file's bytes
    findings: tuple[Finding, ...] = ()
    refused: Mapping[str, str] = field(default_factory=dict)  # column -> why it is not to be trusted, once it is used

    stray: frozenset[str] = frozenset()  # columns whose name ends in what is no unit beside the other names

    def __post_init__(self) -> None:
        if not self.order:
            object.__setattr__(self, "order", (*self.columns, *self.labels))
        stray = stray_suffixes(self.order)
        if stray:
            ends = {name: parse_unit(name)[1] for name in stray}
            units = {name: "" if ends.get(name) == unit else unit for name, unit in self.units.items()}
            object.__setattr__(self, "units", units)
            object.__setattr__(self, "stray", stray)

    def label(self, name: str) -> tuple[str, str]:
        """Name of a column without its unit, and the unit, "" where it is not known."""
        bare, unit = (name, "") if name in self.stray else parse_unit(name)
        return bare, self.units.get(name) or unit


def finite(values: Array) -> npt.NDArray[np.bool_]:
    """Which values are measurements: neither NaN nor infinite nor beyond `LARGEST`."""
    with np.errstate(invalid="ignore"):
        return np.asarray((values <= LARGEST) & (values >= -LARGEST))


def measured(values: Array) -> Array:
    """Return the values that are measurements; the array itself, not a copy, if all are."""
    good = finite(values)
    return values if good.all() else values[good]


def list_rows(rows: Rows | Sequence[int], word: str = "line", count: int = 0, shown: int = SHOWN) -> str:
    """Name the first few rows and the number of the others; `count` if there are more rows than were kept.

    Examples
    --------
    >>> list_rows([3]), list_rows([3, 4, 9, 12, 15, 20])
    ('line 3', 'lines 3, 4, 9, 12 and 2 more')
    """
    numbers = [str(int(row)) for row in rows[:shown]]
    more = max(count, len(rows)) - len(numbers)
    text = f"{word}{'s' if len(rows) != 1 else ''} {', '.join(numbers)}"
    return f"{text} and {more} more" if more > 0 else text


def list_names(names: Iterable[str], shown: int = 30) -> str:
    """Name the first few columns and the number of the others."""
    given = list(names)
    more = f" and {len(given) - shown} more" if len(given) > shown else ""
    return ", ".join(given[:shown]) + more


def unique_names(names: Sequence[str]) -> list[str]:
    """Make column names unique and non-empty: ``x, x, ""`` becomes ``x, x_2, column_3``.

    Examples
    --------
    >>> unique_names(["x", "x", ""])
    ['x', 'x_2', 'column_3']
    """
    found: list[str] = []
    taken: dict[str, int] = {}  # name -> number of the next one that is called the same
    for number, name in enumerate(names, 1):
        base = unique = name.strip() or f"column_{number}"
        while unique in taken:
            taken[base] += 1
            unique = f"{base}_{taken[base]}"
        taken[unique] = 1
        found.append(unique)
    return found


def shown_names(names: Sequence[str], log: str, findings: list[Finding]) -> list[str]:
    """Return column names as they can be shown and typed; say which are not as in the file."""
    shown = [visible(name).strip() for name in names]
    changed = [new for old, new in zip(names, shown, strict=True) if old.strip() != new]
    if changed:
        findings.append(
            Finding(
                "unprintable-names",
                f"{len(changed)} column name{'s' if len(changed) > 1 else ''} of {log} held line breaks, control "
                f"characters or marks that turn the direction of writing, which a terminal would obey; the names used "
                f"here are: {list_names(changed, 8)}. Type them like this, or "
                f"rename the columns in the log.",
            )
        )
    return shown


def require_columns(table: Table) -> Table:
    """Return the table, or refuse one that holds no numbers at all."""
    if not any(finite(column[:100]).any() or finite(column).any() for column in table.columns.values()):
        texts = f" Its columns are text: {list_names(table.labels)}." if table.labels else ""
        if table.scalars and table.row_word == "sample":
            texts += f" Of single numbers it holds {list_names(table.scalars, 8)}."
        cure = "Check that it is the right file"
        cure += ", and that its delimiter is one of , ; | tab or blanks." if table.row_word == "line" else "."
        causes = [finding.message for finding in table.findings if finding.code != "column-titles"]
        seen = f"Noticed: {' '.join(causes)}" if causes else ""
        raise LogError(
            f"log '{table.name}' holds no column of numbers.{texts} {seen or cure}",
            file=table.name,
        )
    return table
