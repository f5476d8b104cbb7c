"""Refuses text that holds numbers, but no table: lists in brackets, and signals that stand in rows."""

from __future__ import annotations

import re
from collections.abc import Sequence

from dehyst.errors import LogError
from dehyst.io.lines import VOTERS, Parting

# "[" alone, "[[0.0", '{"x"', "x = [0.0"; no "[Settings]" as an .ini file has it.
_OPENS = re.compile(r"(?:[\w.]+\s*[:=]\s*)?(?:\[|\{|array\()\s*(?:$|[\[{(\"'\d.+-])(?![\w .-]*\]$)")
_GOES_ON = re.compile(r"[\[\]{}(\"']|[\w.]+\s*[:=]\s*[\[{(]|[+-]?[\d.]+(?:[eE][+-]?\d+)?\s*(?:,|;|$)|[\d.+-].*\]\s*[,;]?$")
LISTED = 0.8  # of the lines belong to a list: a table may begin with a line in brackets
MOST_ROWS = 8  # lines of signals that stand in rows: time, input, output and a few more
LONG_ROW = 32  # numbers in such a row: no log has so few samples and so many signals


def refuse_lists(body: Sequence[str], name: str) -> None:
    """Refuse a list of Python, JSON, Mathematica or MATLAB."""
    lines = [line.strip() for line in body]
    if not _OPENS.match(lines[0]):
        return
    if sum(bool(_GOES_ON.match(line)) for line in lines) < LISTED * len(lines):
        return
    raise LogError(
        f"log '{name}' holds a list in brackets, as Python, JSON, MATLAB or Mathematica write it, not a table; its first "
        f"line is {lines[0][:40]!r}. Save one line for each sample with a comma between the numbers: in Python "
        f'np.savetxt("log.csv", np.column_stack([t, u, y]), delimiter=",", header="time_s,u,y", comments=""), in MATLAB '
        f'writematrix([t u y], "log.csv").',
        file=name,
    )


def refuse_rows(body: Sequence[str], parting: Parting, name: str) -> None:
    """Refuse a table whose signals stand in rows."""
    if len(body) > MOST_ROWS or parting.width < LONG_ROW:
        return
    rows = [cells for cells in map(parting.split, body) if len(cells) == parting.width]
    if not rows or parting.width < MOST_ROWS * len(rows) or len(rows) < len(body):
        return
    numbers = [sum(map(parting.is_number, cells[1 : VOTERS + 1])) for cells in rows]
    if min(numbers) < LISTED * min(parting.width, VOTERS):
        return  # the first row is a header
    raise LogError(
        f"log '{name}' has {len(rows)} line{'s' if len(rows) > 1 else ''} of {parting.width} cells: its signals stand in "
        f"rows. A log has one line for each sample and one column for each signal. Transpose it: in a spreadsheet, copy "
        f"the cells and paste them transposed; in pandas, pd.read_csv(file, header=None).T.to_csv(new, header=False, "
        f"index=False).",
        file=name,
    )
