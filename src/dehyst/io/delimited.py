"""Text logs: .csv .txt .tsv .dat, also packed with gzip.

Two ways: numpy's C parser for logs without a blemish, and a careful one, line by line, as soon as it refuses.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from itertools import compress
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io.cells import date_order, is_data, is_date_time, number, parse_date_times, parse_numbers
from dehyst.io.layout import BLANKS, Layout, find_layout, is_comment, split_line
from dehyst.io.table import Array, Rows, Table, finite, list_rows, require_columns, unique_names
from dehyst.io.text import decode, expand, lines_of
from dehyst.units import parse_unit

LABEL_WIDTH = 64  # characters of a text cell on the fast way; longer ones take the careful way
SUSPECT = " \t#%/"  # first characters of lines that may be comments or blank
PROBE = 200


def read_delimited(data: bytes, name: str, sha256: str = "") -> Table:
    """Read a text log.

    Parameters
    ----------
    data
        Bytes of the file.
    name
        File name without its folder, for messages.
    sha256
        Fingerprint of the file, carried along.

    Raises
    ------
    LogError
        If it is not text, or holds no table of numbers.
    """
    lines = lines_of(decode(expand(data, name), name))
    layout = find_layout(lines, name)
    body, rows = _body(lines, layout.first)
    findings: list[Finding] = []
    fast = _fast(body, layout, findings)
    if fast is None:
        cells, rows = _split(body, rows, layout, name, findings)
        numbers, labels, stamps = _careful(cells, layout, findings)
    else:
        numbers, labels, stamps = fast
    return _assemble(name, sha256, layout, rows, numbers, labels, stamps, findings)


def _body(lines: Sequence[str], first: int) -> tuple[list[str], Rows]:
    """Lines of data without comments and empty lines, and their numbers from 1."""
    body = list(lines[first:])
    while body and not body[-1].strip():
        body.pop()
    if all(body) and not any(line[0] in SUSPECT for line in body):
        return body, np.arange(first + 1, first + 1 + len(body), dtype=np.int64)
    keep = [not is_comment(line) for line in body]
    rows = np.flatnonzero(np.array(keep, dtype=bool)) + first + 1
    return list(compress(body, keep)), rows.astype(np.int64)


Columns = tuple[dict[int, Array], dict[int, npt.NDArray[np.str_]], set[int]]


def _fast(body: Sequence[str], layout: Layout, findings: list[Finding]) -> Columns | None:
    """Read with numpy's C parser; None if any line or cell is not as the first lines promise."""
    if not body or '"' in body[0] or (layout.decimal_comma and layout.delimiter == ","):
        return None
    probe = [split_line(line, layout.delimiter) for line in body[:PROBE]]
    if any(len(row) != layout.width for row in probe):
        return None
    if layout.decimal_comma:
        if any(_may_be_thousands([row[j] for row in probe]) for j in range(layout.width)):
            return None
        body = [line.replace(",", ".") for line in body]
        probe = [[cell.replace(",", ".") for cell in row] for row in probe]
    texts = {j for j in range(layout.width) if all(number(row[j]) is None for row in probe)}
    if texts and layout.decimal_comma:
        return None  # commas within text are not decimal signs
    width = min(LABEL_WIDTH, 8 + max((len(row[j]) for row in probe for j in texts), default=0))
    fields = [(f"c{j}", f"U{width}" if j in texts else "f8") for j in range(layout.width)]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            data: Any = np.loadtxt(
                body,
                delimiter=None if layout.delimiter == BLANKS else layout.delimiter,
                dtype=np.dtype(fields) if texts else np.float64,
                comments=None,
                ndmin=1 if texts else 2,
            )
    except (ValueError, IndexError, OverflowError, UserWarning, DeprecationWarning):
        return None
    if data.shape[0] != len(body):
        return None
    columns = {j: np.ascontiguousarray(data[f"c{j}"] if texts else data[:, j]) for j in range(layout.width)}
    labels = {j: np.char.strip(columns.pop(j)) for j in texts}
    # A label that fills its field may have been cut; a quote or an empty one needs the careful way.
    if any((np.char.str_len(v) >= width).any() or (np.char.find(v, '"') >= 0).any() for v in labels.values()):
        return None
    stamps: set[int] = set()
    for j in sorted(labels):
        if is_date_time(str(labels[j][0])):
            columns[j] = _dates(labels.pop(j).tolist(), layout, j, findings)
            stamps.add(j)
    return columns, labels, stamps


def _may_be_thousands(column: Sequence[str]) -> bool:
    tails = {len(cell.partition(",")[2].strip()) for cell in column if "," in cell}
    return tails == {3}


def _split(
    body: Sequence[str], rows: Rows, layout: Layout, name: str, findings: list[Finding]
) -> tuple[list[list[str]], Rows]:
    """Cells of every line of the right width; the others are reported."""
    cells = [split_line(line, layout.delimiter) for line in body]
    keep = np.array([len(row) == layout.width for row in cells], dtype=bool)
    ragged = rows[~keep]
    if ragged.size:
        findings.append(
            Finding(
                "ragged-lines",
                f"{list_rows(ragged)} of {name} do not have the {layout.width} cells of the others and were left "
                f"out: the logger was interrupted or lines were damaged. Look at them, and mend or delete them.",
            )
        )
    if ragged.size > 0.5 * keep.size:
        raise LogError(
            f"log '{name}' is not a table: {ragged.size} of its {keep.size} lines do not have the {layout.width} cells "
            f"of the others ({list_rows(ragged)}). Check the delimiter and the decimal sign, or cut the file.",
            file=name,
            rows=ragged,
        )
    return list(compress(cells, keep)), rows[keep]


def _careful(cells: Sequence[Sequence[str]], layout: Layout, findings: list[Finding]) -> Columns:
    columns: dict[int, Array] = {}
    labels: dict[int, npt.NDArray[np.str_]] = {}
    stamps: set[int] = set()
    for j, raw in enumerate(zip(*cells, strict=True)):
        column = [cell.strip() for cell in raw]
        filled = [cell for cell in column if cell]
        values, bad = parse_numbers(column, layout.decimal_comma)
        if bad <= 0.5 * len(filled):
            columns[j] = values
            _warn_decimal_comma(column, layout, j, findings)
        elif sum(is_date_time(cell) for cell in filled[:PROBE]) > 0.5 * len(filled[:PROBE]):
            columns[j] = _dates(column, layout, j, findings)
            stamps.add(j)
        else:
            labels[j] = np.array([cell[:200] for cell in column], dtype=np.str_)
    return columns, labels, stamps


def _dates(column: Sequence[str], layout: Layout, j: int, findings: list[Finding]) -> Array:
    """Seconds of a column of dates, and what had to be assumed."""
    order, assumed = date_order(column)
    if assumed:
        name = layout.names[j] if layout.names else f"column_{j + 1}"
        findings.append(
            Finding(
                "date-order",
                f"dates in column '{name}', such as {column[0].strip()}, were read with the {order} first; nothing in "
                f"the log tells. If that is wrong, log dates as 2024-05-01 12:00:00.",
            )
        )
    return parse_date_times(column)


def _warn_decimal_comma(column: Sequence[str], layout: Layout, j: int, findings: list[Finding]) -> None:
    """1,234 is 1.234 or 1234: say so where all commas are followed by three digits and some cells have none."""
    if not layout.decimal_comma:
        return
    tails = [len(cell.partition(",")[2]) for cell in column if "," in cell]
    if tails and set(tails) == {3} and len(tails) < sum(is_data(cell) for cell in column):
        name = layout.names[j] if layout.names else f"column_{j + 1}"
        findings.append(
            Finding(
                "decimal-comma",
                f"commas in column '{name}' were read as decimal signs (1,234 is 1.234), but three digits follow "
                f"each and other cells have none. If they separate thousands, save the log without them.",
            )
        )


def _assemble(
    name: str,
    sha256: str,
    layout: Layout,
    rows: Rows,
    numbers: dict[int, Array],
    labels: dict[int, npt.NDArray[np.str_]],
    stamps: set[int],
    findings: list[Finding],
) -> Table:
    raw = list(layout.names) if layout.names else [f"column_{j + 1}" for j in range(layout.width)]
    names = unique_names(raw)
    doubled = sorted({given for given, unique in zip(raw, names, strict=True) if given and given != unique})
    if doubled:
        findings.append(
            Finding(
                "duplicate-columns",
                f"{name} names several columns {', '.join(doubled)}; the later ones were renamed "
                f"({', '.join(u for g, u in zip(raw, names, strict=True) if g != u and g)}). "
                f"Name the one you mean, or use #3 for the third column.",
            )
        )
    units = {names[j]: parse_unit(names[j])[1] for j in numbers}
    if layout.units:
        given = {names[j]: parse_unit(f"x [{layout.units[j]}]")[1] for j in numbers if layout.units[j]}
        units.update({column: unit for column, unit in given.items() if unit})
    units.update({names[j]: "s" for j in stamps})
    columns = {names[j]: numbers[j] for j in sorted(numbers) if not _is_trailing(layout, names[j], numbers[j])}
    return require_columns(
        Table(
            name=name,
            columns=columns,
            units={column: units[column] for column in columns},
            rows=rows,
            labels={names[j]: labels[j] for j in sorted(labels)},
            row_word="line",
            stamps=frozenset(names[j] for j in stamps),
            order=tuple(names),
            sha256=sha256,
            findings=tuple(findings),
        )
    )


def _is_trailing(layout: Layout, column: str, values: Array) -> bool:
    """Column made by a delimiter at the end of every line: last, nameless, empty."""
    return column == f"column_{layout.width}" and layout.width > 1 and not finite(values).any()
