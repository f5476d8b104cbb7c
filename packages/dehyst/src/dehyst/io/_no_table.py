"""Refuses text that holds numbers, but no table: lists in brackets, and signals that stand in rows."""

from __future__ import annotations

import re
from collections.abc import Sequence

from dehyst.errors import LogError
from dehyst.io._lines import VOTERS, Parting
from dehyst.io._policy import POLICY
from dehyst.io._table import number_of
from dehyst.shell import quoted

# "[" alone, "[[0.0", '{"x"', "x = [0.0"; no "[Settings]" as an .ini file has it.
_OPENS = re.compile(r"""(?:[\w.]+\s*[:=]\s*)?(?:\[|\{|array\()\s*(?:$|[\[{("'\d.+-])""")
_STAYS_OPEN = re.compile(r"[\w.]+\s*=\s*[\[{][^\]}]*")
_NUMBER = r"[+-]?[\d.]+(?:[eE][+-]?\d+)?"
_GOES_ON = re.compile(
    r"""[\[\]{}("']|[\w.]+\s*[:=]\s*[\[{(]|"""
    rf"{_NUMBER}\s*[,;]?$|{_NUMBER}.*[\]}}]\s*[,;]?$"
)
MOST_COLUMNS = 20_000  # each is looked at for its name, unit and movement: about a second in all


def refuse_lists(body: Sequence[str], name: str) -> None:
    """Refuse a list of Python, JSON, Mathematica or MATLAB."""
    if not _OPENS.match(body[0].strip()):
        return
    lines = list(map(str.strip, body))
    inside = len(list(filter(_GOES_ON.match, lines)))
    if inside < POLICY.listed * len(lines) and not _STAYS_OPEN.fullmatch(lines[0]):
        return
    raise LogError(
        f"log '{name}' holds a list in brackets, as Python, JSON, MATLAB or Mathematica write it, not a table; its "
        f"first line is {lines[0][:40]!r}. Save one line for each sample, with a comma between its numbers: in Python "
        f"with np.savetxt('log.csv', np.column_stack([t, u, y]), delimiter=','), in MATLAB with "
        f"writematrix([t u y], 'log.csv').",
        file=name,
    )


def refuse_rows(body: Sequence[str], parting: Parting, name: str) -> None:
    """Refuse a table whose signals stand in rows, or that has too many columns to be looked at one by one."""
    if parting.width > MOST_COLUMNS:
        cut = f"cut -d {quoted(parting.delimiter)}"
        if parting.delimiter == "\t":
            cut = "cut"
        raise LogError(
            f"log '{name}' has {parting.width} columns, more than the {MOST_COLUMNS} that are read. A log has one "
            f"column for each signal and one line for each sample. If its signals stand in rows, transpose it; "
            f"otherwise write the columns that matter into a file of their own: "
            f"{cut} -f1,2,3 {quoted(name)} > few.csv",
            file=name,
            columns=parting.width,
        )
    if len(body) > POLICY.signal_rows or parting.width < POLICY.long_row:
        return
    rows = parting.rows(body)
    if not rows or parting.width < POLICY.signal_rows * len(rows) or len(rows) < len(body):
        return
    numbers = [sum(map(parting.is_number, cells[1 : VOTERS + 1])) for cells in rows]
    if min(numbers) < POLICY.listed * min(parting.width, VOTERS):
        return  # the first row is a header
    raise LogError(
        f"log '{name}' has {number_of(len(rows), 'line')} of {parting.width} cells: its signals stand "
        "in rows. A log has one line for each sample and one column for each signal. Transpose it: in a spreadsheet, "
        f"copy the cells and paste them transposed; in pandas, "
        f"pd.read_csv(file, header=None).T.to_csv(new, header=False, index=False).",
        file=name,
    )
