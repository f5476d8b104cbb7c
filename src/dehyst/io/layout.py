"""Detects the layout of a text log: comments, delimiter, decimal sign, header, units row, first data line."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from dehyst.errors import LogError
from dehyst.io.cells import MISSING, comma_number, is_data, is_date_time, is_dressed, number, unescaped
from dehyst.units import canonical

COMMENTS = ("#", "%", "//")
SAMPLE = 400  # lines that decide the layout
SAMPLE_TEXT = 1 << 20  # characters of them; no line of a log is longer
VOTERS = 1000  # cells of a line that tell what the others are
BLANKS = " "  # delimiter meaning one or more blanks
_QUOTED_COMMA = re.compile(r'"\s*[+-]?\d*,\d+(?:[eE][+-]?\d+)?\s*"', re.ASCII)


@dataclass(frozen=True, slots=True)
class Layout:
    """How the lines of a text log are to be read."""

    delimiter: str  # , ; | tab, or one blank for any number of blanks
    decimal_comma: bool
    width: int  # cells in a line of data
    names: tuple[str, ...] | None  # of the header
    units: tuple[str, ...] | None  # of the units row
    first: int  # index of the first line of data


def is_comment(line: str) -> bool:
    """Whether a line is empty or a comment."""
    stripped = line.lstrip()
    return not stripped or stripped.startswith(COMMENTS)


def split_line(line: str, delimiter: str) -> list[str]:
    """Cells of one line; a quoted cell may hold the delimiter, but never the end of the line.

    Examples
    --------
    >>> split_line('1,"a,b",2', ","), split_line("  1   2 ", " ")
    (['1', 'a,b', '2'], ['1', '2'])
    """
    if '"' in line:
        try:
            line = line.strip() if delimiter == BLANKS else line
            return next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
        except csv.Error:
            return [line]
    return line.split() if delimiter == BLANKS else line.split(delimiter)


def _numeric(cell: str, decimal_comma: bool) -> bool:
    value = comma_number(cell) if decimal_comma else number(cell)
    return is_dressed(cell) if value is None else value == value or cell.strip() != ""


def _score(sample: Sequence[str], delimiter: str, decimal_comma: bool) -> tuple[float, int]:
    """Share of the sample that reads as data of one width, and that width."""
    rows = [split_line(line, delimiter) for line in sample]
    good: Counter[int] = Counter()
    for row in rows:
        voters = row[:VOTERS]
        hits = sum(_numeric(cell, decimal_comma) or is_date_time(cell) for cell in voters)
        texts = sum(bool(cell.strip()) for cell in voters) - hits
        if hits and texts <= max(1, hits):
            good[len(row)] += hits
    if not good:
        return 0.0, 0
    width, hits = good.most_common(1)[0]
    lines = sum(len(row) == width for row in rows)
    cells = sum(sum(bool(cell.strip()) for cell in row[:VOTERS]) for row in rows if len(row) == width)
    return (hits / max(1, cells)) * (lines / len(rows)), width


def find_layout(lines: Sequence[str], name: str) -> Layout:
    """Find the layout of a text log from its first and some later lines."""
    body = [line for line in lines[: 4 * SAMPLE] if not is_comment(line)]
    if not body:
        raise LogError(
            f"log '{name}' holds no data: its {len(lines)} lines are empty or comments. Check that it is the "
            f"right file and that the logger had not just been started.",
            file=name,
        )
    # The middle of the sample: preamble and header come first and must not vote.
    sample = _sample(body[len(body) // 4 :])
    best: tuple[float, int, str, bool] = (0.0, 0, ",", False)
    # At equal score the earlier wins; decimal commas are tried where the comma is not the delimiter.
    marks = (",", ";", "\t", "|", BLANKS)
    trials = [(mark, False) for mark in marks] + [(mark, True) for mark in marks[1:]]
    if any(_QUOTED_COMMA.search(line) for line in sample):
        trials.append((",", True))  # "0,020","1,23": quotes keep the two commas apart
    found = "".join(sample)
    for delimiter, decimal_comma in trials:
        if best[0] > 1 - 1e-9 and not (found.split(None, 1) != [found] if delimiter == BLANKS else delimiter in found):
            continue  # one cell a line cannot do better
        score, width = _score(sample, delimiter, decimal_comma)
        if score > best[0] + 1e-9 or (score > best[0] - 1e-9 and width > best[1]):
            best = (score, width, delimiter, decimal_comma)
    score, width, delimiter, decimal_comma = best
    if score < 0.2:
        _refuse_header_only(body, name)
    if score < 0.2 or width < 1:
        raise LogError(
            f"log '{name}' holds no table of numbers that , ; | tab or blanks would separate; its first line of "
            f"text is {body[0][:60]!r}. Save it as CSV with one header line and a . or , as decimal sign.",
            file=name,
        )
    return _with_header(lines, delimiter, decimal_comma, width)


def _sample(body: Sequence[str]) -> list[str]:
    """First lines, fewer where they are long: a cut line would not tell the number of columns."""
    sample: list[str] = []
    left = SAMPLE_TEXT
    for line in body[:SAMPLE]:
        if left <= 0 and len(sample) >= 3:
            break
        sample.append(line[:SAMPLE_TEXT])
        left -= len(line)
    return sample


def _refuse_header_only(body: Sequence[str], name: str) -> None:
    """Say so when there are names, perhaps units, and nothing below."""
    if len(body) > 2:
        return
    cells = next((c for c in (split_line(body[0], mark) for mark in (",", ";", "\t", "|")) if len(c) > 1), [])
    names = [cell.strip() for cell in cells]
    if names and all(names) and not any(is_data(cell) for line in body for cell in re.split("[,;|\t]", line)):
        raise LogError(
            f"log '{name}' has a header ({', '.join(names[:8])}{', ...' if len(names) > 8 else ''}) but no rows below "
            f"it: the logger was started and wrote nothing, or the copy was cut. Copy the file again, or log again.",
            file=name,
            columns=tuple(names),
        )


def _is_data_row(cells: Sequence[str], width: int, decimal_comma: bool) -> bool:
    if len(cells) != width:
        return False
    cells = cells[:VOTERS]
    missing = sum(cell.strip().lower() in MISSING for cell in cells)
    hits = sum(_numeric(cell, decimal_comma) and cell.strip().lower() not in MISSING for cell in cells)
    dates = sum(is_date_time(cell) for cell in cells)
    texts = len(cells) - missing - hits - dates
    return hits + dates > 0 and texts <= max(1, hits + dates)


def _with_header(lines: Sequence[str], delimiter: str, decimal_comma: bool, width: int) -> Layout:
    data = (
        i
        for i, line in enumerate(lines)
        if not is_comment(line) and _is_data_row(split_line(line, delimiter), width, decimal_comma)
    )
    first = next(data, len(lines))
    if first < len(lines) and _is_named_by_values(lines[first], lines[next(data, first)], delimiter):
        first += 1
    first = _first_missing(lines, first, delimiter, width)
    # Candidates for header and units row, nearest to the data first; a commented header counts too.
    above: list[list[str]] = []
    for line in reversed(lines[max(0, first - 50) : first]):
        cells = _header_cells(line, delimiter)
        if cells and len(cells) == width - 1 and _last_empty(lines[first : first + 50], delimiter, width):
            cells = [*cells, ""]
        if cells and MISSING.issuperset(cell.lower() for cell in cells):
            continue
        if cells and len(cells) == width:
            above.append(cells)
        elif not is_comment(line):
            break  # a line of another width: what stands above it is preamble
        if len(above) == 2:
            break
    names: tuple[str, ...] | None = None
    units: tuple[str, ...] | None = None
    if above:
        if len(above) == 2 and _is_units_row(above[0]):
            units, names = tuple(cell.strip("[]() ") for cell in above[0]), tuple(above[1])
        else:
            names = tuple(above[0])
    return Layout(delimiter, decimal_comma, width, names, units, first)


def _is_named_by_values(line: str, below: str, delimiter: str) -> bool:
    """Whether a line names columns by values (``0 bar,2 bar``): numbers with units above plain ones."""
    cells = [cell for cell in split_line(line, delimiter) if is_data(cell) or is_dressed(cell)]
    return all(map(is_dressed, cells)) and not any(map(is_dressed, split_line(below, delimiter)))


def _first_missing(lines: Sequence[str], first: int, delimiter: str, width: int) -> int:
    """First of the lines just above the data in which every cell is missing: data too, and no header.

    A line of dashes is a rule or says that nothing has a unit; it is passed over on the way, not taken.
    """
    start = first
    for i in range(first - 1, -1, -1):
        cells = [cell.strip().lower() for cell in split_line(lines[i], delimiter)]
        if not is_comment(lines[i]) and (len(cells) != width or not MISSING.issuperset(cells)):
            break
        if not is_comment(lines[i]) and not {"-", "--"}.issuperset(cells):
            start = i
    return start


def _header_cells(line: str, delimiter: str) -> list[str]:
    text = line.strip() if delimiter == BLANKS else line
    for mark in COMMENTS:
        if text.lstrip().startswith(mark):
            text = text.lstrip().lstrip(mark[0])
    if not text.strip():
        return []
    if delimiter == BLANKS:
        text = re.sub(r"[ \t]+(?=[\[(])", "_", text)  # angle [deg] is one name
    return [unescaped(cell.strip()) for cell in split_line(text, delimiter)]


def _last_empty(lines: Sequence[str], delimiter: str, width: int) -> bool:
    """Whether every line ends in a delimiter, which makes an extra, empty column."""
    rows = [split_line(line, delimiter) for line in lines if not is_comment(line)]
    return all(len(row) != width or not row[-1].strip() for row in rows)


def _is_units_row(cells: Sequence[str]) -> bool:
    known = 0
    for cell in cells:
        inner = cell.strip("[]() ")
        known += bool(canonical(inner)) or inner in {"", "-", "1"} or inner != cell.strip()
    return known >= 0.5 * len(cells) and any(cell.strip("[]()- ") for cell in cells)
