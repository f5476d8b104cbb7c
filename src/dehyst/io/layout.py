"""Detects the layout of a text log: delimiter, decimal sign, header, units row, first data line."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io.cells import is_data, is_date_time
from dehyst.io.heading import find_heading
from dehyst.io.lines import BLANKS, VOTERS, Parting, is_comment, split_line
from dehyst.io.no_table import refuse_lists, refuse_rows

SAMPLE = 400  # lines that decide the layout
SAMPLE_TEXT = 1 << 20  # characters of them; no line of a log is longer
MARKS = ("\t", ";", "|", ",")
REGULAR = 0.9  # of the lines must have equally many cells for a mark to part them
LEAST_SCORE = 0.2  # of a table: the share of its cells that are data, times that of the lines of one width
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
    score: float  # share of the cells that are data, times the share of the lines that have the width
    regular: bool  # whether almost all lines have the width, and no cell holds several numbers


def _trial(sample: Sequence[str], delimiter: str, decimal_comma: bool) -> _Trial:
    rows = [split_line(line, delimiter) for line in sample]
    parting = Parting(delimiter, decimal_comma, 0)
    good: Counter[int] = Counter()
    for row in rows:
        voters = row[:VOTERS]
        hits = sum(parting.is_data(cell) for cell in voters)
        texts = sum(bool(cell.strip()) for cell in voters) - hits
        if hits and texts <= max(1, hits):
            good[len(row)] += hits
    if not good:
        return _Trial(parting, 0.0, False)
    width, hits = good.most_common(1)[0]
    table = [row for row in rows if len(row) == width]
    share = len(table) / len(rows)
    cells = sum(sum(bool(cell.strip()) for cell in row[:VOTERS]) for row in table)
    parting = Parting(delimiter, decimal_comma, width)
    crowded = sum(any(_is_crowded(cell, parting) for cell in row[:VOTERS]) for row in table)
    return _Trial(parting, hits / max(1, cells) * share, width > 1 and share >= REGULAR and 2 * crowded < len(table))


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


def find_layout(lines: Sequence[str], name: str) -> Layout:
    """Find the layout of a text log from its first and some later lines."""
    body = [line for line in lines[: 4 * SAMPLE] if not is_comment(line)]
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
    if trial.score < LEAST_SCORE:
        _refuse_header_only(body, name)
    if trial.score < LEAST_SCORE or parting.width < 1:
        raise LogError(
            f"log '{name}' holds no table of numbers that , ; | tab or blanks would separate; its first line of "
            f"text is {body[0][:60]!r}. Save it as CSV with one header line and a . or , as decimal sign.",
            file=name,
        )
    refuse_rows(body, parting, name)
    head = find_heading(lines, sample, parting, name)
    return Layout(
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
    # Decimal commas are tried where the comma is not the delimiter.
    pairs = [(mark, comma) for mark in MARKS if mark in text for comma in (False, True) if mark != "," or not comma]
    if _QUOTED_COMMA.search(text):
        pairs.append((",", True))  # "0,020","1,23": quotes keep the two commas apart
    trials = [_trial(sample, mark, comma) for mark, comma in pairs]
    regular = [trial for trial in trials if trial.regular and trial.score >= LEAST_SCORE]
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
    cells = next((c for c in (split_line(body[0], mark) for mark in (",", ";", "\t", "|")) if len(c) > 1), [])
    names = [cell.strip() for cell in cells]
    if names and all(names) and not any(is_data(cell) for line in body for cell in re.split("[,;|\t]", line)):
        raise LogError(
            f"log '{name}' has a header ({', '.join(names[:8])}{', ...' if len(names) > 8 else ''}) but no rows below "
            f"it: the logger was started and wrote nothing, or the copy was cut. Copy the file again, or log again.",
            file=name,
            columns=tuple(names),
        )
