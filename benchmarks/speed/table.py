"""The tables of a run, for a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

MISSING = {"numba": "numba", "quadprog": "quadprog", "DAQP": "daqp", "qpOASES": "casadi"}


def head(result: Mapping[str, Any]) -> list[str]:
    """Machine, versions, and how it was measured."""
    lines = [", ".join(f"{key} {value}" for key, value in result["machine"].items())]
    what = f"{result['samples']:g} samples, one thread, best of {result['rounds']} interleaved runs"
    return [*lines, what + (", short form: half of each ratio is asked for" if result["quick"] else "")]


def times(result: Mapping[str, Any]) -> Iterable[str]:
    """ns a sample (ms for programs) of every method: one table a group, one column a signal."""
    groups: dict[str, dict[str, Any]] = {}
    for entry in result["times"]:
        groups.setdefault(entry["group"], {})[entry["signal"]] = entry["methods"]
    for group, signals in groups.items():
        program = group.startswith("quadratic")
        yield ""
        names = list(dict.fromkeys(name for methods in signals.values() for name in methods))
        unit = "[ms]" if program else "[ns/sample]"
        yield f"{group + ' ' + unit:38}" + "".join(f"{signal:>12}" for signal in signals)
        for name in names:
            cells = (signals[signal].get(name) for signal in signals)
            scale = 1e-6 if program else 1.0
            yield f"  {name:36}" + "".join(f"{number(cell['ns'] * scale) if cell else '-':>12}" for cell in cells)


def limits(rows: Iterable[Mapping[str, Any]]) -> Iterable[str]:
    """One line a limit."""
    yield ""
    yield f"{'figure':46}{'signal':10}{'measured':>12}{'limit':>14}"
    for row in rows:
        measured = "not measured" if row["measured"] is None else number(row["measured"])
        verdict = {True: "ok", False: "MISSED", None: ""}[row["ok"]]
        bound = f"{row['sense']} {number(row['limit'])}"
        yield f"{row['what']:46}{row['signal']:10}{measured:>12}{bound:>14}  {verdict}"


def number(value: float) -> str:
    """Three digits, without an exponent where a reader can do without."""
    if value == 0 or 1e-3 <= abs(value) < 1000:
        return f"{value:.3g}"
    return f"{value:,.0f}".replace(",", " ") if 1000 <= abs(value) < 1e7 else f"{value:.1e}"
