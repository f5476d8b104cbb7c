"""Result table of a sweep: one row per point with its varied parameters, error messages and figures."""

from __future__ import annotations

import math
import re
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from dehyst.robot.experiments.sweep.journal import Outcome
from dehyst.robot.experiments.sweep.points import Point
from dehyst.robot.experiments.sweep.spec import SweepSpec

_OFF = re.compile(r"(?P<trial>.+)/off/rms_deg")


def parameters_of(spec: SweepSpec) -> tuple[str, ...]:
    """Return the keys that any study sets or varies, in the order of the file."""
    keys = dict.fromkeys(spec.grid)
    for study in spec.studies:
        keys |= dict.fromkeys((*study.fixed, *study.varied))
    return tuple(keys)


def table_of(spec: SweepSpec, points: Sequence[Point], outcomes: Mapping[str, Outcome]) -> dict[str, list[Any]]:
    """Return the columns of the table, (rows,) each.

    A parameter that a study does not touch has the robot's own value there. Figures of a run that failed are None.
    """
    nominal = spec.keys.nominal
    rows = [outcomes[point.key] for point in points]
    columns: dict[str, list[Any]] = {
        "study": [point.study for point in points],
        "point": [point.number for point in points],
        "seed": [point.seed for point in points],
    }
    for key in parameters_of(spec):
        columns[key] = [point.values.get(key, nominal.get(key)) for point in points]
    columns["error"] = [row.error for row in rows]
    for name in dict.fromkeys(name for row in rows for name in row.figures):
        # A figure called like a parameter, "seed" say, stays beside it.
        columns[name if name not in columns else f"figure {name}"] = [row.figures.get(name) for row in rows]
    return columns


def ratios_of(columns: Mapping[str, Sequence[Any]]) -> dict[str, list[float | None]]:
    """Return rms with a compensator over rms without it, (rows,), by trial and compensator.

    Without such figures, every figure called a ratio; without those, the first three figures there are.

    Examples
    --------
    >>> ratios_of({"error": [""], "slow/off/rms_deg": [2.0], "slow/paper/rms_deg": [0.5]})
    {'slow, paper/off': [0.25]}
    """
    found: dict[str, list[float | None]] = {}
    for name, without in columns.items():
        match = _OFF.fullmatch(name)
        if match is None:
            continue
        trial = match["trial"]
        for other, compensated in columns.items():
            before, _, after = other.rpartition("/rms_deg")
            if not after and before.startswith(f"{trial}/") and before != f"{trial}/off" and other != name:
                label = f"{trial}, {before.removeprefix(f'{trial}/')}/off"
                found[label] = [_ratio(a, b) for a, b in zip(compensated, without, strict=True)]
    if found:
        return found
    figures = list(columns)[list(columns).index("error") + 1 :]
    named = [name for name in figures if "ratio" in name] or figures[:3]
    return {name: list(columns[name]) for name in named}


def _ratio(a: float | None, b: float | None) -> float | None:
    return a / b if a is not None and b is not None and math.isfinite(a) and math.isfinite(b) and b > 0 else None


@dataclass(frozen=True)
class Summary:
    """One set of parameters, or all random draws of a study: median and range of the figures over its runs.

    Attributes
    ----------
    study
        Its study.
    values
        What is varied there: key -> value; for random draws key -> "drawn".
    runs, failed
        How many, and how many of them failed.
    figures
        Label -> median, lowest, highest; None where there is none.
    """

    study: str
    values: Mapping[str, Any]
    runs: int
    failed: int
    figures: Mapping[str, tuple[float, float, float] | None]


def summarise(spec: SweepSpec, points: Sequence[Point], columns: Mapping[str, Sequence[Any]]) -> tuple[Summary, ...]:
    """Return medians over seeds of each point of a grid, and over draws and seeds of random studies."""
    ratios = ratios_of(columns)
    studies = {study.name: study for study in spec.studies}
    groups: dict[tuple[Any, ...], list[int]] = {}
    for row, point in enumerate(points):
        study = studies[point.study]
        place = tuple(repr(point.values[key]) for key in (*spec.grid, *study.grid))
        groups.setdefault((point.study, *place), []).append(row)
    return tuple(_summary(spec, points, columns, ratios, rows) for rows in groups.values())


def _summary(
    spec: SweepSpec,
    points: Sequence[Point],
    columns: Mapping[str, Sequence[Any]],
    ratios: Mapping[str, Sequence[float | None]],
    rows: Sequence[int],
) -> Summary:
    first = points[rows[0]]
    study = next(study for study in spec.studies if study.name == first.study)
    values = {key: first.values[key] for key in (*spec.grid, *study.grid)} | dict.fromkeys(study.random, "drawn")
    failed = sum(bool(columns["error"][row]) for row in rows)
    figures = {}
    for label, numbers in ratios.items():
        there = [number for row in rows if (number := numbers[row]) is not None and math.isfinite(number)]
        figures[label] = (statistics.median(there), min(there), max(there)) if there else None
    return Summary(first.study, values, len(rows), failed, figures)
