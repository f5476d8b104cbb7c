"""What stands above the numbers of a text log: where they begin, and the names and units of their columns.

A header that has as many cells as the rows names the columns in their order. Where it has more or fewer, only the
columns themselves can tell which name belongs to which; if they do not, no name is used, and a finding says so.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress, filterfalse, pairwise

from dehyst.findings import Finding
from dehyst.io._cells import is_data, is_date_time, is_dressed, unescaped
from dehyst.io._clocks import TIME_WORDS
from dehyst.io._lines import BLANKS, COMMENTS, VOTERS, Parting, is_comment, is_missing, split_line
from dehyst.io._table import list_first, number_of
from dehyst.units import DIMENSION, canonical, parse_unit, words

HEAD = 50  # lines above the numbers that may hold names
AHEAD = 20  # lines of data among which no header may stand: what is above one belongs to a preamble
CHARACTERS = 1 << 18  # of lines that are looked at, where these are long
ROWS = 100  # lines of data that are compared with the names
NAME_WORDS = 2  # of a name, without its unit
LINES_ABOVE = 6  # names, units, and what else a logger says of each column
SURPLUS = {"", "comment", "start", "increment"}  # names of a header that have no column
# Keys above the data in files of TwinCAT's Scope.
SCOPE_KEYS = {"symbolcomment", "data-type", "sampletime[ms]", "variablesize", "symbolbased"}
UNIT_WORDS = frozenset(words("unit units einheit einheiten uom eu"))
SHOWN_NAMES = 6  # in a message
LONGEST_UNIT = 12  # characters
COUNTS = "counts the rows"
COUNT_WORDS = frozenset(
    words(
        "n no nr num number nummer index idx row rows zeile sample samples count counter id point k i"
    )
)
_RULE = re.compile(r"[-=:+_~* ]*")
_UNIT = re.compile(
    r"[^\W\d_]{1,6}\d?|[%°‰Ω1-]|°[CFK]?"
    r"|(?:[^\W\d_]{1,4}(?:\^?-?\d)?|1|%)(?:[ ·*/^.-]{1,2}[^\W\d_]{1,5}(?:\^?-?[0-9²³])?){1,3}"
)
_STAMP_FORM = re.compile(r"[YyMmDdHhSsfF:./ \-T]{4,}")
# Units that `canonical` does not know, as they stand alone; of a ratio, what may stand above the line.
_OTHER_UNITS = frozenset(words("rpm hz khz mhz k degc degf l g kg w kw j lsb counts ppm db rh ohm"))
_ABOVE_LINE = frozenset(["m3", "m2", "1", *words("l ml nl kg g rev u umdr inc imp counts kj j w")])


@dataclass(frozen=True, slots=True)
class Heading:
    """Names and units of the columns, and where their numbers begin."""

    names: tuple[str, ...] | None
    units: tuple[str, ...] | None
    first: int  # index of the first line of data
    unfit: tuple[str, ...] = ()  # names of a header with more or fewer cells than the data
    findings: tuple[Finding, ...] = ()


def find_heading(
    lines: Sequence[str], sample: Sequence[str], parting: Parting, log: str
) -> Heading:
    """Find what stands above the numbers; `sample` are lines of data."""
    first = _first_line(lines, parting, _number_columns(sample, parting))
    above, unfit, unfit_units = _lines_above(lines, first, parting)
    above = _from_units(above)
    rows = parting.rows(_data_lines(lines, first, ROWS))
    units: tuple[str, ...] | None = None
    names_above = unfit
    if len(above) > 1:
        names_above = above[1]
    if names_above and above and _is_units_row(above[0], names_above):
        units = tuple(map(_without_brackets, above[0]))
        above = above[1:]
    if above:
        names = _with_groups(above)
        if units is None and _are_units(names):
            units = tuple(names)
        findings: tuple[Finding, ...] = ()
        if not names[-1] and len(rows) > 2 and _may_be_shifted(names, rows, parting):
            findings = (_shifted(names, log),)
        return Heading(tuple(names), units, first, (), findings)
    if not unfit:
        return Heading(None, units, first)
    before, after, why = _place_of(unfit, rows, parting)
    finding = _misfit(unfit, why, rows, parting, log)
    if not why:
        return Heading(None, units, first, tuple(unfit), (finding,))
    placed = ("",) * before + tuple(unfit) + ("",) * after
    if len(unfit_units) == len(unfit):
        units = ("",) * before + tuple(map(_without_brackets, unfit_units)) + ("",) * after
    return Heading(placed, units, first, tuple(unfit), (finding,))


def _without_brackets(cell: str) -> str:
    return cell.strip("[]() ")


def _from_units(above: list[list[str]]) -> list[list[str]]:
    """Lines from a row of units on, where what stands below it (sensors, rates, remarks) tells no columns apart."""
    for k in range(1, len(above) - 1):
        names = list(filter(None, above[k + 1]))
        if len(set(names)) < len(names) or len(names) < len(above[k + 1]) - 1:
            continue
        if any(map(is_data, names)) or not _is_units_row(above[k], above[k + 1]):
            continue
        if all(map(_is_weak, above[:k])):
            return above[k:]
    return above


def _is_weak(cells: Sequence[str]) -> bool:
    return not all(cells) or len(set(cells)) < len(cells)


def _are_units(names: Sequence[str]) -> bool:
    """Whether names are units and nothing else (``s,bar,deg``)."""
    certain = False
    for name in names:
        is_long_unit = len(name) > 1 and bool(canonical(name))
        if not name or not (is_long_unit or name in DIMENSION or _is_other_unit(name)):
            return False
        certain |= is_long_unit
    return certain


def _data_lines(lines: Sequence[str], first: int, count: int) -> list[str]:
    """Lines from one on, without comments and empty ones; fewer where they are long."""
    chosen: list[str] = []
    left = CHARACTERS
    for line in lines[first : first + 4 * count]:
        if len(chosen) == count or (left <= 0 and len(chosen) >= 3):
            break
        if not is_comment(line):
            chosen.append(line)
            left -= len(line)
    return chosen


def _number_columns(sample: Sequence[str], parting: Parting) -> list[int]:
    """Which columns hold numbers (1) or date-times (2), and which neither (0)."""
    rows = parting.rows(_data_lines(sample, 0, ROWS))
    kinds = [0] * min(parting.width, VOTERS)
    for j in range(len(kinds)):
        filled = [row[j] for row in rows if not is_missing(row[j])]
        if 2 * sum(map(parting.is_data, filled)) > len(filled):
            kinds[j] = 1 + any(map(is_date_time, filled))
    return kinds


def _first_line(lines: Sequence[str], parting: Parting, numbers: Sequence[int]) -> int:
    """Index of the first line of data.

    A line of a preamble may hold numbers as well (``Rate;1000;;``): data have no text where the others have numbers,
    and no header follows them.
    """
    start = len(lines)
    for i, line in enumerate(lines):
        if is_comment(line) or not _is_solid(parting.split(line), parting, numbers):
            continue
        below = parting.rows(_data_lines(lines, i + 1, AHEAD))
        if not any(_is_header(cells, parting, numbers) for cells in below):
            # No header follows: this is where the data begin.
            start = i
            break
    while start > 0 and _leads_data(lines[start - 1], parting):
        start -= 1
    if start == len(lines):  # a header every few lines, or text in every row
        for i, line in enumerate(lines):
            if not is_comment(line) and parting.is_data_row(parting.split(line)):
                start = i
                break
    following = _data_lines(lines, start + 1, 1)
    if following and _is_named_by_values(lines[start], following[0], parting.delimiter):
        start += 1
    return _first_missing(lines, start, parting)


def _leads_data(line: str, parting: Parting) -> bool:
    """Whether a line above data is one of theirs: most of its cells are numbers, the first among them."""
    if is_comment(line):
        return False
    cells = parting.split(line)
    if not parting.is_data_row(cells):
        return False
    first = next(filterfalse(is_missing, cells), None)
    return first is not None and parting.is_data(first)


def _is_solid(cells: Sequence[str], parting: Parting, numbers: Sequence[int]) -> bool:
    """Whether a line has numbers, and no text or date where the others have them."""
    if len(cells) != parting.width:
        return False
    for cell, kind in zip(cells, numbers, strict=False):
        if kind == 1 and is_date_time(cell):
            return False
    filled = _filled_numbers(cells, numbers)
    return bool(filled) and all(map(parting.is_data, filled))


def _is_header(cells: Sequence[str], parting: Parting, numbers: Sequence[int]) -> bool:
    """Whether a line has texts where the others have numbers, and nothing else."""
    filled = _filled_numbers(cells, numbers)
    if not filled or 2 * len(filled) < sum(map(bool, numbers)):
        return False
    return not any(map(parting.is_data, filled))


def _filled_numbers(cells: Sequence[str], numbers: Sequence[int]) -> list[str]:
    """Cells of the columns of numbers, without those that are missing."""
    return list(filterfalse(is_missing, compress(cells, numbers)))


def _is_named_by_values(line: str, below: str, delimiter: str) -> bool:
    """Whether a line names columns by values (``0 bar,2 bar``): numbers with units above plain ones."""
    for cell in split_line(line, delimiter):
        if is_data(cell) and not is_dressed(cell):
            return False
    return not any(map(is_dressed, split_line(below, delimiter)))


def _first_missing(lines: Sequence[str], first: int, parting: Parting) -> int:
    """First of the lines just above the data in which every cell is missing: data too, and no header.

    A line of dashes is a rule or says that nothing has a unit; it is passed over on the way, not taken.
    """
    start = first
    for i in range(first - 1, -1, -1):
        if is_comment(lines[i]):
            continue
        cells = parting.split(lines[i])
        if len(cells) != parting.width or not all(map(is_missing, cells)):
            break
        if any(cell.strip().strip("-") for cell in cells):
            start = i
    return start


def _lines_above(
    lines: Sequence[str], first: int, parting: Parting
) -> tuple[list[list[str]], list[str], list[str]]:
    """Cells of the lines above the data that may name the columns, the nearest first; a commented line counts too.

    Also the cells of the nearest line that looks like names, but has more or fewer than the data, and those of a line
    of units below it.
    """
    above: list[list[str]] = []
    units: list[str] = []
    rule: list[str] = []  # dashes of different lengths: names, where nothing else is
    gap = False
    below = parting.rows(_data_lines(lines, first, HEAD))
    last_empty = not any(cells[-1].strip() for cells in below)
    for line in reversed(lines[max(0, first - HEAD) : first]):
        cells = header_cells(line, parting.delimiter)
        plain = list(map(str.strip, parting.split(line)))
        if len(plain) == parting.width != len(cells) and parting.delimiter != BLANKS:
            cells = plain  # a line whose first cell is #
        if cells and cells[0].lower() in SCOPE_KEYS:
            continue
        if all(_RULE.fullmatch(cell) or is_missing(cell) for cell in cells):
            if len(set(cells)) == len(cells) == parting.width and all(map(_RULE.fullmatch, cells)):
                rule = cells
            continue
        fitting = _fitting(cells, line, parting, last_empty)
        if fitting and parting.width > 2 and sum(map(bool, fitting)) == 1:
            continue  # a title
        if gap and not above and (not all(fitting) or any(map(is_data, fitting)) or not fitting):
            break
        named = not fitting and _looks_like_names(cells, line, parting)
        if fitting and not _is_entry(fitting, parting.width):
            above.append(fitting)
        elif named and not units and _is_units_row(cells):
            units = cells
        elif named and all(map(_is_units_row, above)):
            return above, cells, units
        elif not above and not gap and len(cells) == 1 < parting.width - 1:
            gap = True  # a mark between names and numbers, such as [Data]
        elif not is_comment(line):
            break  # what stands above it is preamble
        if len(above) == LINES_ABOVE:
            break
    if not above and not units and rule:
        above.append(rule)
    if above:
        return above, [], []
    return above, units, []


def _is_entry(cells: Sequence[str], width: int) -> bool:
    """Whether a line is one of a preamble, padded with delimiters: a word, its value, and nothing (``Rate;1000;;``)."""
    filled = list(filter(None, cells))
    if len(filled) > 1 and not is_date_time(filled[0]) and all(map(is_date_time, filled[1:])):
        return True  # when each column was logged
    return len(filled) < width and 2 * sum(map(is_data, filled)) >= len(filled)


def _looks_like_names(cells: Sequence[str], line: str, parting: Parting) -> bool:
    """Whether a line of another width may be meant as names: several words and hardly a number."""
    if 2 * sum(map(is_data, cells)) >= len(cells) or (len(cells) < 2 and parting.width != 2):
        return False
    if not is_comment(line):
        return True
    # No sentence: those have more words than a log has columns, or long parts between their commas.
    return len(cells) > 1 and abs(len(cells) - parting.width) == 1 and not _is_prose(cells)


def _is_prose(cells: Sequence[str]) -> bool:
    """Whether cells are parts of a sentence, and no names."""
    return any(len(re.sub(r"[\[(].*", "", cell).split()) > NAME_WORDS for cell in cells)


def _fitting(cells: list[str], line: str, parting: Parting, last_empty: bool) -> list[str]:
    """Cells of a header if there are as many as in the data; none otherwise."""
    width = parting.width
    if len(cells) == width:
        return cells
    if len(cells) == width - 1 and last_empty:
        return [*cells, ""]
    if len(cells) > width and not any(cells[width:]):
        return cells[:width]
    columns = _without_surplus(cells, width - int(last_empty))
    if columns:
        return columns + [""] * last_empty
    # A header may be parted otherwise than the data: by tabs or wide blanks.
    text = _without_mark(line).strip()
    if width < 2 or (parting.delimiter != BLANKS and parting.delimiter in text):
        return []
    for pattern in (r"\t+", r"\s{2,}", r"\s*;\s*"):
        parts = re.split(pattern, text)
        if len(parts) == width:
            return [unescaped(part.strip().strip('"')) for part in parts]
    return []


def _without_surplus(cells: Sequence[str], width: int) -> list[str]:
    """Names of a header that goes on with what is no column: a remark, or start and step of the time; else none."""
    names = list(cells)
    while len(names) > width and (names[-1].lower() in SURPLUS or is_data(names[-1])):
        names.pop()
    if len(names) == width < len(cells) and any(names) and not any(map(is_data, names)):
        return names
    return []


def _without_mark(line: str) -> str:
    """A line without the sign that makes it a comment."""
    for mark in COMMENTS:
        if line.lstrip().startswith(mark):
            return line.lstrip().lstrip(mark[0])
    return line


def header_cells(line: str, delimiter: str) -> list[str]:
    """Cells of a line above the data, which may be a comment.

    Examples
    --------
    >>> header_cells("# time angle [deg]", " "), header_cells('"time, s",angle', ",")
    (['time', 'angle_[deg]'], ['time, s', 'angle'])
    """
    text = _without_mark(line.strip() if delimiter == BLANKS else line)
    if not text.strip():
        return []
    if delimiter == BLANKS:
        text = re.sub(r"[ \t]+(?=[\[(])", "_", text)  # angle [deg] is one name
    return [unescaped(cell.strip()) for cell in split_line(text, delimiter)]


def _with_groups(above: Sequence[Sequence[str]]) -> list[str]:
    """Names of the nearest line; with the words of the line above where the nearest has a name twice."""
    names = list(above[0])
    if len(set(map(str.lower, names))) == len(names):
        return names
    if len(above) == 1 or any(map(is_data, above[1])):
        return names
    group = ""
    combined: list[str] = []
    for over, name in zip(above[1], names, strict=True):
        group = over or group
        combined.append(f"{group} {name}".strip())
    return combined


def _is_units_row(cells: Sequence[str], names: Sequence[str] = ()) -> bool:
    """Whether a line holds units: at least half of them known; or, below names, nothing but what looks like units."""
    units = list(map(_without_brackets, cells))
    if len(cells) > 1 and UNIT_WORDS & set(words(cells[0])) and any(map(canonical, units[1:])):
        return True
    if not any(unit.strip("-") for unit in units):
        return False
    sure = blank = 0
    for cell, unit in zip(cells, units, strict=True):
        in_brackets = unit != "" and cell.strip()[:1] in {"[", "("}
        sure += in_brackets or bool(canonical(unit))
        blank += unit in {"", "-", "1"}
    has_units = sure > 0 or any(map(_is_other_unit, units))
    if has_units and sure + blank >= 0.5 * len(cells):
        return True
    if not names or not all(names) or len(set(names)) < len(names):
        return False
    if not any(map(canonical, units)) and not any(map(_is_other_unit, units)):
        return False
    return all(not unit or _STAMP_FORM.fullmatch(unit) or _is_unit_shaped(unit) for unit in units)


def _is_unit_shaped(text: str) -> bool:
    return len(text) <= LONGEST_UNIT and bool(_UNIT.fullmatch(text))


def _is_other_unit(text: str) -> bool:
    """Whether a text is a unit although no table has it: %, rpm, m3/h."""
    low = text.lower()
    top, slash, bottom = low.partition("/")
    ratio = bool(slash) and (top in _ABOVE_LINE or bool(canonical(top))) and _is_unit_shaped(bottom)
    return low in _OTHER_UNITS or ratio or bool(set("°²³%") & set(text))


def _place_of(
    cells: Sequence[str], rows: Sequence[Sequence[str]], parting: Parting
) -> tuple[int, int, str]:
    """How many columns before and after those that a narrow header names have no name, and what shows it; else ""."""
    extra = parting.width - len(cells)
    if extra < 1 or len(rows) < 3 or _is_prose(cells):
        return 0, 0, ""
    columns: list[list[str]] = []
    for column in zip(*rows, strict=True):
        columns.append(list(map(str.strip, column)))
    index = ""
    if extra == 1 and _agree(cells, columns[1:], parting):
        index = _index_of(columns[0], cells, parting)
    beside = all(_is_beside(column, parting) for column in columns[len(cells) :])
    left = beside and _agree(cells, columns[: len(cells)], parting)
    if index and not left:
        return 1, 0, f"the first column {index}"
    if left and not index:
        which = f"each of the last {extra} columns holds"
        if extra == 1:
            which = "the last column holds"
        return 0, extra, f"{which} one value, text or nothing"
    return 0, 0, ""


def _may_be_shifted(names: Sequence[str], rows: Sequence[Sequence[str]], parting: Parting) -> bool:
    """Whether the last column is a signal without a name, and the first counts the rows under another name."""
    if not names[0] or COUNT_WORDS & set(words(names[0])):
        return False
    last = [row[-1].strip() for row in rows]
    if _is_beside(last, parting):
        return False
    first = [row[0].strip() for row in rows]
    return _index_of(first, names, parting) == COUNTS


def _shifted(names: Sequence[str], log: str) -> Finding:
    return Finding(
        "header-width",
        f"the last column of {log} has no name, and the first, called '{names[0]}', counts the rows: the names may "
        f"stand one column too far to the left. They were taken as they stand. If that is wrong, write one name for "
        f"every column; otherwise there is nothing to do.",
    )


def _agree(cells: Sequence[str], columns: Sequence[Sequence[str]], parting: Parting) -> bool:
    """Whether names and columns agree: time runs forward, and what has a unit holds numbers."""
    for name, column in zip(cells, columns, strict=True):
        values = list(map(parting.value, column))
        is_text = values.count(None) > 0.5 * len(values)
        if is_text and is_date_time(column[0]):
            continue
        bare, unit = parse_unit(name)
        if is_text and canonical(unit):
            return False
        if TIME_WORDS & set(words(bare)) and not is_text and not _rises(values):
            return False
    return True


def _rises(values: Sequence[float | None]) -> bool:
    numbers = [value for value in values if value is not None and value == value]
    steps = [later - earlier for earlier, later in pairwise(numbers)]
    return bool(steps) and sum(step >= 0 for step in steps) >= 0.9 * len(steps) and max(steps) > 0


def _index_of(column: Sequence[str], names: Sequence[str], parting: Parting) -> str:
    """What a column without a name does if it is an index: counts the rows, names them, or is their time; or ""."""
    numbers = [value for value in map(parting.value, column) if value is not None]
    if not numbers:
        if len(set(column)) == len(column) and not is_date_time(column[0]):
            return "names the rows"
        return "holds dates"
    if len(numbers) < len(column):
        return ""
    steps = [later - earlier for earlier, later in pairwise(numbers)]
    if numbers[0] in {0.0, 1.0} and set(steps) == {1.0}:
        return COUNTS
    timed = any(TIME_WORDS & set(words(parse_unit(name)[0])) for name in names)
    if not timed and min(steps) > 0 and max(steps) < 2 * min(steps):
        return "runs forward evenly"
    return ""


def _is_beside(column: Sequence[str], parting: Parting) -> bool:
    """Whether a column holds one value, nothing or text: not a signal that anybody would name."""
    return len(set(column)) == 1 or not any(map(parting.is_number, filter(None, column)))


def _misfit(
    cells: Sequence[str], why: str, rows: Sequence[Sequence[str]], parting: Parting, log: str
) -> Finding:
    """What is said of names that are more or fewer than the cells."""
    names = list_first(cells, SHOWN_NAMES)
    row = ""
    if rows:
        row = list_first([*map(str.strip, rows[0])], SHOWN_NAMES)
    mismatch = (
        f"the header of {log} has {number_of(len(cells), 'name')} ({names}) and its rows have {parting.width} cells "
        f"({row})"
    )
    if why:
        return Finding(
            "header-width",
            f"{mismatch}: {why}, so the names were taken for the other columns. If that is wrong, "
            "write one name for every "
            f"column.",
        )
    last = parting.width
    before_last = max(1, last - 1)
    return Finding(
        "header-width",
        f"{mismatch}. Which name belongs to which column cannot be told, so none was used, and units "
        "in them were lost: "
        f"the columns are called column_1 to column_{last}. Write one name for every column into the file; or name "
        f"columns by their place, for example --input column_{before_last} --output column_{last}.",
    )
