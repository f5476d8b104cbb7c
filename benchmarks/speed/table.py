"""The tables of a run, for a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any


def console(result: Mapping[str, Any]) -> list[str]:
    """Everything, line by line."""
    return [*head(result), *times(result), *limits(result["limits"]), *further(result["figures"])]


def head(result: Mapping[str, Any]) -> list[str]:
    """Machine, versions, and how it was measured."""
    lines = [", ".join(f"{key} {value}" for key, value in result["machine"].items())]
    what = f"{result['samples']:g} samples, processor time of one thread, best of {result['rounds']} interleaved runs"
    return [
        *lines,
        what + (", short form: a quarter of each ratio is asked for" if result["quick"] else ""),
    ]


def groups(result: Mapping[str, Any]) -> dict[str, tuple[str, list[str], dict[str, list[str]]]]:
    """Group -> unit, signals, and the cells of every method: ns a sample, or ms for programs."""
    found: dict[str, dict[str, Any]] = {}
    for entry in result["times"]:
        found.setdefault(entry["group"], {})[entry["signal"]] = entry["methods"]
    tables = {}
    for group, signals in found.items():
        unit, scale = ("ms", 1e-6) if group.startswith("quadratic") else ("ns/sample", 1.0)
        names = dict.fromkeys(name for methods in signals.values() for name in methods)
        rows = {
            name: [number(scale * of[name]["ns"]) if name in of else "-" for of in signals.values()]
            for name in names
        }
        tables[group] = (unit, list(signals), rows)
    return tables


def times(result: Mapping[str, Any]) -> Iterable[str]:
    """One table a group, one column a signal."""
    for group, (unit, signals, rows) in groups(result).items():
        yield ""
        yield f"{f'{group} [{unit}]':38}" + "".join(f"{signal:>12}" for signal in signals)
        for name, cells in rows.items():
            yield f"  {name:36}" + "".join(f"{cell:>12}" for cell in cells)


def limits(rows: Iterable[Mapping[str, Any]]) -> Iterable[str]:
    """One line a limit."""
    yield ""
    yield f"{'figure':46}{'signal':10}{'measured':>12}{'limit':>14}"
    for row in rows:
        measured = "not measured" if row["measured"] is None else number(row["measured"])
        verdict = {True: "ok", False: "MISSED", None: ""}[row["ok"]]
        bound = "not judged" if row["asked"] is None else f"{row['sense']} {number(row['asked'])}"
        yield f"{row['what']:46}{row['signal']:10}{measured:>12}{bound:>14}  {verdict}"


def further(figures: Iterable[Mapping[str, Any]]) -> Iterable[str]:
    """Figures without a limit; those that the table of times holds as well are left out."""
    shown = [row for row in figures if " / " not in row["what"]]
    if shown:
        yield ""
    for row in shown:
        yield f"{row['what']:46}{row['signal']:10}{number(row['measured']):>12}"


def number(value: float) -> str:
    """Three digits, without an exponent where a reader can do without."""
    if value == 0 or 1e-3 <= abs(value) < 1000:
        return f"{value:.3g}"
    return f"{value:,.0f}".replace(",", " ") if 1000 <= abs(value) < 1e7 else f"{value:.1e}"
