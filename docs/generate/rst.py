"""Docstrings -> Markdown: literal blocks, formulas, simple tables, headings. Nothing else is used in them."""

from __future__ import annotations

import re
import textwrap

_RULE = re.compile(r"^=+(\s+=+)+$")
_UNDER = re.compile(r"^-{4,}$")


def markdown(text: str, level: int = 2) -> str:
    """Return a docstring's text as Markdown; its headings get this level."""
    lines, out, k = text.split("\n"), [], 0
    while k < len(lines):
        line = lines[k]
        if _RULE.match(line):
            k, table = _table(lines, k)
            out += table
        elif line.startswith(".. math::"):
            k, block = _indented(lines, k + 1, line.removeprefix(".. math::").strip())
            out += _formulas(block)
        elif line.rstrip().endswith("::"):
            out.append(_words(line.rstrip()[:-2].rstrip() + (":" if line.strip() != "::" else "")))
            k, block = _indented(lines, k + 1, "")
            out += ["", "```text", *block, "```", ""]
        elif k + 1 < len(lines) and _UNDER.match(lines[k + 1]) and line.strip():
            out += [f"{'#' * level} {line.strip()}", ""]
            k += 2
        else:
            out.append(_words(line))
            k += 1
    return re.sub(r"\n{3,}", "\n\n", "\n".join(out)).strip()


def _words(line: str) -> str:
    line = re.sub(r":math:`([^`]*)`", r"$\1$", line)
    return re.sub(r"``([^`]*)``", r"`\1`", line)


def _indented(lines: list[str], k: int, first: str) -> tuple[int, list[str]]:
    """Block that is indented below a line, without its margin; and where the text goes on."""
    block = [first] if first else []
    start = k
    while k < len(lines) and (not lines[k].strip() or lines[k].startswith((" ", "\t"))):
        k += 1
    body = textwrap.dedent("\n".join(lines[start:k])).strip("\n").split("\n")
    return k, [*block, *(row for row in body if row or block or len(body) > 1)]


def _formulas(block: list[str]) -> list[str]:
    """Each paragraph of a math block as one formula."""
    found: list[list[str]] = [[]]
    for row in block:
        if row.strip():
            found[-1].append(row.strip())
        elif found[-1]:
            found.append([])
    return [part for rows in found if rows for part in ("", "$$", *rows, "$$", "")]


def _table(lines: list[str], k: int) -> tuple[int, list[str]]:
    """A simple table: columns as its rule says; a cell may go on in the next row, whose first cell is empty."""
    starts = [found.start() for found in re.finditer(r"=+", lines[k])]
    ends = [*starts[1:], None]
    rows: list[list[str]] = []
    head, k, rules = 0, k + 1, 1
    while k < len(lines) and rules < 3:
        if _RULE.match(lines[k]):
            rules += 1
            head = len(rows) if rules == 2 else head
        elif lines[k].strip():
            cells = [_words(lines[k][a:b].strip()) for a, b in zip(starts, ends, strict=True)]
            if cells[0] or not rows:
                rows.append(cells)
            else:
                rows[-1] = [f"{a} {b}".strip() for a, b in zip(rows[-1], cells, strict=True)]
        k += 1
    drawn = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return k, ["", *drawn[:head], "|" + "---|" * len(starts), *drawn[head:], ""]
