"""The points of a sweep in a fixed order, and the table of what they gave."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import re
import statistics
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.errors import ParameterError
from dehyst.robot.experiments.results import RUN_SETTINGS
from dehyst.robot.experiments.sweep.journal import Outcome
from dehyst.robot.experiments.sweep.spec import Draw, Study, SweepSpec

MOST = 200_000  # runs of one sweep
_OFF = re.compile(r"(?P<trial>.+)/off/rms_deg")


@dataclass(frozen=True)
class Point:
    """One row of the table: a set of parameters and a seed.

    Attributes
    ----------
    study
        Name of its study.
    number
        Number of the set of parameters in the whole sweep, from 1; equal for all seeds.
    seed
        Of the plant's tolerances and noise.
    values
        Key -> value of everything that is set, parameters and run settings alike.
    key
        Fingerprint of what is run: points of two studies that are the same run have the same one.
    """

    study: str
    number: int
    seed: int
    values: Mapping[str, Any]
    key: str

    @property
    def changes(self) -> dict[str, Any]:
        """Changes of the robot's parameters."""
        return {key: value for key, value in self.values.items() if key not in RUN_SETTINGS}

    @property
    def run_settings(self) -> dict[str, Any]:
        """Run settings, those not named at their defaults."""
        return {key: self.values.get(key, default) for key, default in RUN_SETTINGS.items()}


def expand(spec: SweepSpec) -> tuple[Point, ...]:
    """Return all points, seeds fastest, then the study's values, then the sweep's grid, then studies.

    Raises
    ------
    ParameterError
        If there are more than 200000, or a value is none that the robot can have.

    Examples
    --------
    >>> from dehyst.robot.experiments.sweep.spec import parse_sweep
    >>> study = {"name": "size", "seeds": [1, 2], "grid": {"hysteresis.scale": [0.5, 1.0]}}
    >>> [(p.number, p.seed, p.values) for p in expand(parse_sweep({"study": [study]}))][1:3]
    [(1, 2, {'hysteresis.scale': 0.5}), (2, 1, {'hysteresis.scale': 1.0})]
    """
    total = sum(_size(spec, study) for study in spec.studies)
    if total > MOST:
        raise ParameterError(
            f"the sweep '{spec.name}' has {total} runs; more than {MOST} are not started at once. Take fewer values, "
            f"draws or seeds, or make several files.",
            runs=total,
        )
    numbers = itertools.count(1)
    points = tuple(
        Point(study.name, number, seed, values, _key(spec, values, seed))
        for study in spec.studies
        for values, number in zip(_values(spec, study), numbers, strict=False)
        for seed in study.seeds
    )
    first = {point.number: point for point in reversed(points)}.values()
    spec.keys.try_on((f"sweep '{spec.name}', study '{point.study}'", point.changes) for point in reversed(first))
    return points


def _key(spec: SweepSpec, values: Mapping[str, Any], seed: int) -> str:
    """Fingerprint of a run; a value that the robot has anyway makes no other run."""
    told = json.dumps([{k: v for k, v in values.items() if v != spec.keys.nominal.get(k)}, seed], sort_keys=True)
    return hashlib.sha256(told.encode()).hexdigest()[:24]


def _size(spec: SweepSpec, study: Study) -> int:
    lists = [*spec.grid.values(), *study.grid.values()]
    return math.prod(len(values) for values in lists) * max(study.draws, 1) * len(study.seeds)


def _values(spec: SweepSpec, study: Study) -> Iterator[dict[str, Any]]:
    grid = {**spec.grid, **study.grid}
    drawn = {key: _drawn(spec.random_seed, study, key, how) for key, how in study.random.items()}
    for place in itertools.product(*grid.values()):
        for k in range(max(study.draws, 1)):
            random = {key: values[k] for key, values in drawn.items()}
            yield {**study.fixed, **dict(zip(grid, place, strict=True)), **random}


def _drawn(seed: int, study: Study, key: str, how: Draw) -> list[Any]:
    """Draws of one parameter: a stream of its own, so that neither another parameter nor more draws change them."""
    stream = np.random.default_rng([seed, zlib.crc32(study.name.encode()), zlib.crc32(key.encode())])
    if how.choice:
        # One double a draw: integers() would take its bits in blocks, and a longer list begin differently.
        return [how.choice[int(u * len(how.choice))] for u in stream.random(study.draws)]
    low, high = (math.log(how.low), math.log(how.high)) if how.log else (how.low, how.high)
    values = low + (high - low) * stream.random(study.draws)
    return [float(value) for value in (np.exp(values) if how.log else values)]


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
