"""Refuses text that holds numbers, but no table: lists in brackets, and signals that stand in rows."""

from __future__ import annotations

import re
from collections.abc import Sequence

from dehyst.errors import LogError
from dehyst.io.lines import VOTERS, Parting
from dehyst.shell import quoted

# "[" alone, "[[0.0", '{"x"', "x = [0.0"; no "[Settings]" as an .ini file has it.
_OPENS = re.compile(r"""(?:[\w.]+\s*[:=]\s*)?(?:\[|\{|array\()\s*(?:$|[\[{("'\d.+-])""")
_STAYS_OPEN = re.compile(r"[\w.]+\s*=\s*[\[{][^\]}]*")
_NUMBER = r"[+-]?[\d.]+(?:[eE][+-]?\d+)?"
_GOES_ON = re.compile(
    r"""[\[\]{}("']|[\w.]+\s*[:=]\s*[\[{(]|"""
    rf"{_NUMBER}\s*[,;]?$|{_NUMBER}.*[\]}}]\s*[,;]?$"
)
LISTED = 0.8  # of the lines belong to a list: a table may begin with a line in brackets
MOST_ROWS = 8  # lines of signals that stand in rows: time, input, output and a few more
MOST_COLUMNS = 20_000  # each is looked at for its name, unit and movement: about a second in all
LONG_ROW = 32  # numbers in such a row: no log has so few samples and so many signals


def refuse_lists(body: Sequence[str], name: str) -> None:
    """Refuse a list of Python, JSON, Mathematica or MATLAB."""
    lines = [line.strip() for line in body]
    if not _OPENS.match(lines[0]):
        return
    inside = sum(bool(_GOES_ON.match(line)) for line in lines)
    if inside < LISTED * len(lines) and not _STAYS_OPEN.fullmatch(lines[0]):
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
        cut = "cut" if parting.delimiter == "\t" else f"cut -d {quoted(parting.delimiter)}"
        raise LogError(
            f"log '{name}' has {parting.width} columns, more than the {MOST_COLUMNS} that are read. A log has one "
            f"column for each signal and one line for each sample. If its signals stand in rows, transpose it; "
            f"otherwise write the columns that matter into a file of their own: "
            f"{cut} -f1,2,3 {quoted(name)} > few.csv",
            file=name,
            columns=parting.width,
        )
    if len(body) > MOST_ROWS or parting.width < LONG_ROW:
        return
    rows = [cells for cells in map(parting.split, body) if len(cells) == parting.width]
    if not rows or parting.width < MOST_ROWS * len(rows) or len(rows) < len(body):
        return
    numbers = [sum(map(parting.is_number, cells[1 : VOTERS + 1])) for cells in rows]
    if min(numbers) < LISTED * min(parting.width, VOTERS):
        return  # the first row is a header
    raise LogError(
        f"log '{name}' has {len(rows)} line{'s' if len(rows) > 1 else ''} of {parting.width} cells: its signals stand "
        f"in rows. A log has one line for each sample and one column for each signal. Transpose it: in a spreadsheet, "
        f"copy the cells and paste them transposed; in pandas, "
        f"pd.read_csv(file, header=None).T.to_csv(new, header=False, index=False).",
        file=name,
    )
