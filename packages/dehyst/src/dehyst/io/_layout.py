"""Detects the layout of a text log: delimiter, decimal sign, header, units row, first data line."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import filterfalse

from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io._cells import is_data, is_date_time
from dehyst.io._heading import find_heading
from dehyst.io._lines import BLANKS, VOTERS, Parting, is_comment, split_line
from dehyst.io._no_table import refuse_lists, refuse_rows
from dehyst.io._policy import POLICY
from dehyst.io._table import list_first

SAMPLE = 400  # lines that decide the layout
SAMPLE_TEXT = 1 << 20  # characters of them; no line of a log is longer
MARKS = ("\t", ";", "|", ",")
_QUOTED_COMMA = re.compile(r'"\s*[+-]?\d*,\d+(?:[eE][+-]?\d+)?\s*"', re.ASCII)


@dataclass(frozen=True, slots=True)
class TableLayout:
    """How the lines of a text log are to be read."""

    delimiter: str  # , ; | tab, or one blank for any number of blanks
    decimal_comma: bool
    width: int  # cells in a line of data
    names: tuple[str, ...] | None  # of the header
    units: tuple[str, ...] | None  # of the units row
    first: int  # index of the first line of data
    unfit: tuple[str, ...] = ()  # names of a header with more or fewer cells than the data
    findings: tuple[Finding, ...] = ()

    @property
    def parting(self) -> Parting:
        """What parts the cells."""
        return Parting(self.delimiter, self.decimal_comma, self.width)


@dataclass(frozen=True, slots=True)
class _Trial:
    """A way to part the cells, and how well it does."""

    parting: Parting
    # share of the cells that are data, times the share of the lines that have the width
    score: float
    regular: bool  # whether almost all lines have the width, and no cell holds several numbers


def _trial(sample: Sequence[str], delimiter: str, decimal_comma: bool) -> _Trial:
    parting = Parting(delimiter, decimal_comma, 0)
    good: Counter[int] = Counter()  # by width of the line
    rows: Counter[int] = Counter()
    filled: Counter[int] = Counter()
    crowded: Counter[int] = Counter()
    for line in sample:
        row = split_line(line, delimiter)
        voters = row[:VOTERS]
        hits = sum(map(parting.is_data, voters))
        cells = sum(map(bool, map(str.strip, voters)))
        rows[len(row)] += 1
        filled[len(row)] += cells
        crowded[len(row)] += any(_is_crowded(cell, parting) for cell in voters)
        if hits and cells - hits <= max(1, hits):
            good[len(row)] += hits
    if not good:
        return _Trial(parting, 0.0, False)
    width, hits = good.most_common(1)[0]
    share = rows[width] / len(sample)
    return _Trial(
        Parting(delimiter, decimal_comma, width),
        hits / max(1, filled[width]) * share,
        width > 1 and share >= POLICY.regular and 2 * crowded[width] < rows[width],
    )


def _is_crowded(cell: str, parting: Parting) -> bool:
    """Whether a cell holds several numbers that blanks part; a date and its time of day are one stamp."""
    parts = cell.split() if " " in cell else ()
    return len(parts) > 1 and all(map(parting.is_data, parts)) and not is_date_time(cell)


def _best(trials: Sequence[_Trial]) -> _Trial:
    """At equal score the wider wins, then the earlier."""
    best = trials[0]
    for trial in trials[1:]:
        wider = trial.score > best.score - 1e-9 and trial.parting.width > best.parting.width
        if trial.score > best.score + 1e-9 or wider:
            best = trial
    return best


def find_layout(lines: Sequence[str], name: str) -> TableLayout:
    """Find the layout of a text log from its first and some later lines."""
    body = list(filterfalse(is_comment, lines[: 4 * SAMPLE]))
    if not body:
        raise LogError(
            f"log '{name}' holds no data: its {len(lines)} lines are empty or comments. Check that it is the "
            f"right file and that the logger had not just been started.",
            file=name,
        )
    refuse_lists(body, name)
    # The middle of the sample: preamble and header come first and must not vote.
    sample = _sample(body[len(body) // 4 :])
    trial = _find_parting(sample)
    parting = trial.parting
    if trial.score < POLICY.least_score:
        _refuse_header_only(body, name)
    if trial.score < POLICY.least_score or parting.width < 1:
        raise LogError(
            f"log '{name}' holds no table of numbers that , ; | tab or blanks would separate; its first line of "
            f"text is {body[0][:60]!r}. Save it as CSV with one header line and a . or , as decimal sign.",
            file=name,
        )
    refuse_rows(body, parting, name)
    head = find_heading(lines, sample, parting, name)
    return TableLayout(
        parting.delimiter,
        parting.decimal_comma,
        parting.width,
        head.names,
        head.units,
        head.first,
        head.unfit,
        head.findings,
    )


def _find_parting(sample: Sequence[str]) -> _Trial:
    """The mark that stands in every line, or else what gives the most numbers.

    Blanks also stand within dates, names and texts: they part cells only where no mark does.
    """
    text = "".join(sample)
    trials: list[_Trial] = []
    for mark in MARKS:
        if mark in text:
            trials.append(_trial(sample, mark, False))
            # Decimal commas are tried where the comma is not the delimiter.
            if mark != ",":
                trials.append(_trial(sample, mark, True))
    if _QUOTED_COMMA.search(text):
        # "0,020","1,23": quotes keep the two commas apart.
        trials.append(_trial(sample, ",", True))
    regular = [trial for trial in trials if trial.regular and trial.score >= POLICY.least_score]
    if regular:
        return _best(regular)
    return _best([*trials, _trial(sample, BLANKS, False), _trial(sample, BLANKS, True)])


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
    names: list[str] = []
    for mark in (",", ";", "\t", "|"):
        cells = split_line(body[0], mark)
        if len(cells) > 1:
            names = list(map(str.strip, cells))
            break
    if not names or not all(names) or any(map(is_data, re.split("[,;|\t\n]", "\n".join(body)))):
        return
    raise LogError(
        f"log '{name}' has a header ({list_first(names, 8)}) but no rows below it: the logger was started and wrote "
        f"nothing, or the copy was cut. Copy the file again, or log again.",
        file=name,
        columns=tuple(names),
    )
