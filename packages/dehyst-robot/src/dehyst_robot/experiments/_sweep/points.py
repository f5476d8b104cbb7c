"""The points of a sweep in a fixed order, the table of their outcomes, and its medians."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import re
import statistics
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from dehyst.errors import ParameterError
from dehyst.version import __version__
from dehyst_robot.experiments._results import RUN_SETTINGS
from dehyst_robot.experiments._sweep.spec import Draw, Study, SweepSpec

MOST = 200_000  # runs of one sweep
KEY = "key"  # column with `Point.key`
ERROR = "error"  # column with `Outcome.error`; the figures stand right of it
_RMS = re.compile(r"(?P<trial>.+)/(?P<compensator>[^/]+)/rms_deg")


@dataclass(frozen=True)
class RunOutcome:
    """The result of one run.

    Attributes
    ----------
    figures
        Name -> number; empty if it failed.
    error
        Why it failed, or "".
    """

    figures: Mapping[str, float] = field(default_factory=dict)
    error: str = ""


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
        Fingerprint of what is run, of the robot and of the version of dehyst: points of two studies that are the same
        run have the same one, and a finished run is recognised by it.
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


def expand_points(spec: SweepSpec, evaluator: str = "") -> tuple[Point, ...]:
    """Return all points, seeds fastest, then the study's values, then the sweep's grid, then studies.

    Parameters
    ----------
    spec
        The sweep.
    evaluator
        Name of the function that runs a point; it is a part of the keys.

    Raises
    ------
    ParameterError
        If there are more than 200000, or a value is none that the robot can have.

    Examples
    --------
    >>> from dehyst_robot.experiments._sweep.spec import parse_sweep
    >>> study = {"name": "size", "seeds": [1, 2], "grid": {"hysteresis.scale": [0.5, 1.0]}}
    >>> [(p.number, p.seed, p.values) for p in expand_points(parse_sweep({"study": [study]}))][1:3]
    [(1, 2, {'hysteresis.scale': 0.5}), (2, 1, {'hysteresis.scale': 1.0})]
    """
    total = sum(_size(spec, study) for study in spec.studies)
    if total > MOST:
        raise ParameterError(
            f"the sweep '{spec.name}' has {total} runs; more than {MOST} are not started at once. Take fewer values, "
            f"draws or seeds, or make several files.",
            runs=total,
        )
    # What is the same for all runs, and would change every one of them.
    common = [spec.experiment, spec.joint, spec.trials, spec.compensators]
    common += [spec.keys.robot.fingerprint, __version__, evaluator]
    points: list[Point] = []
    sets_of_changes: list[tuple[str, Mapping[str, Any]]] = []
    for study in spec.studies:
        for values in _values(spec, study):
            number = len(sets_of_changes) + 1
            for seed in study.seeds:
                points.append(
                    Point(study.name, number, seed, values, _key(spec, values, [*common, seed]))
                )
            sets_of_changes.append(
                (f"sweep '{spec.name}', study '{study.name}'", points[-1].changes)
            )
    spec.keys.try_on(sets_of_changes)
    return tuple(points)


def _key(spec: SweepSpec, values: Mapping[str, Any], common: Sequence[Any]) -> str:
    """Fingerprint of a run; a value that the robot has anyway makes no other run."""
    nominal = spec.keys.nominal
    changed_values = {key: value for key, value in values.items() if value != nominal.get(key)}
    text = json.dumps([changed_values, *common], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def _size(spec: SweepSpec, study: Study) -> int:
    size = max(study.draws, 1) * len(study.seeds)
    return size * math.prod(map(len, (*spec.grid.values(), *study.grid.values())))


def _values(spec: SweepSpec, study: Study) -> Iterator[dict[str, Any]]:
    grid = {**spec.grid, **study.grid}
    drawn = {key: _drawn(spec.random_seed, study, key, how) for key, how in study.random.items()}
    for place in itertools.product(*grid.values()):
        for k in range(max(study.draws, 1)):
            random = {key: values[k] for key, values in drawn.items()}
            yield {**study.fixed, **dict(zip(grid, place, strict=True)), **random}


def _drawn(seed: int, study: Study, key: str, how: Draw) -> list[Any]:
    """Draws of one parameter: a stream of its own, so that neither another parameter nor more draws change them."""
    stream = np.random.default_rng(
        [seed, zlib.crc32(study.name.encode()), zlib.crc32(key.encode())]
    )
    # One double a draw: integers() would take its bits in blocks, and a longer list begin differently.
    uniform = stream.random(study.draws)
    if how.choice:
        return [how.choice[int(u * len(how.choice))] for u in uniform]
    low, high = how.low, how.high
    if how.log:
        low, high = math.log(low), math.log(high)
    values = low + (high - low) * uniform
    if how.log:
        values = np.exp(values)
    return list(map(float, values))


def parameters_of(spec: SweepSpec) -> tuple[str, ...]:
    """Return the keys that any study sets or varies, in the order of the file."""
    keys = dict.fromkeys(spec.grid)
    for study in spec.studies:
        keys |= dict.fromkeys((*study.fixed, *study.varied))
    return tuple(keys)


def table_of(
    spec: SweepSpec, points: Sequence[Point], outcomes: Mapping[str, RunOutcome]
) -> dict[str, list[Any]]:
    """Return the columns of the table, (rows,) each.

    A parameter that a study does not touch has the robot's own value there. Figures of a run that failed are None.
    """
    nominal = spec.keys.nominal
    parameters = parameters_of(spec)
    columns: dict[str, list[Any]] = {}
    for name in ("study", "point", "seed", *parameters, KEY, ERROR):
        columns[name] = []
    figures: dict[str, None] = {}
    for point in points:
        columns["study"].append(point.study)
        columns["point"].append(point.number)
        columns["seed"].append(point.seed)
        for key in parameters:
            columns[key].append(point.values.get(key, nominal.get(key)))
        outcome = outcomes[point.key]
        columns[KEY].append(point.key)
        columns[ERROR].append(outcome.error)
        figures |= dict.fromkeys(outcome.figures)
    for name in figures:
        label = name
        # A figure called like a parameter, "seed" say, stays beside it.
        if name in columns:
            label = f"figure {name}"
        columns[label] = [outcomes[point.key].figures.get(name) for point in points]
    return columns


def ratios_of(columns: Mapping[str, Sequence[Any]]) -> dict[str, list[float | None]]:
    """Return rms with a compensator over rms without it, (rows,), by trial and compensator.

    Without such figures, every figure called a ratio; without those, the first three figures there are.

    Examples
    --------
    >>> ratios_of({"error": [""], "slow/off/rms_deg": [2.0], "slow/paper/rms_deg": [0.5]})
    {'slow, paper/off': [0.25]}
    """
    ratios: dict[str, list[float | None]] = {}
    for name, compensated in columns.items():
        match = _RMS.fullmatch(name)
        if match is None or match["compensator"] == "off":
            continue
        # A compensator alone has nothing to be compared with.
        without = columns.get(f"{match['trial']}/off/rms_deg")
        if without is not None:
            label = f"{match['trial']}, {match['compensator']}/off"
            ratios[label] = [_ratio(a, b) for a, b in zip(compensated, without, strict=True)]
    if ratios:
        return ratios
    names = list(columns)
    figures = names[names.index(ERROR) + 1 :]
    chosen = [name for name in figures if "ratio" in name] or figures[:3]
    return {name: list(columns[name]) for name in chosen}


def _ratio(a: float | None, b: float | None) -> float | None:
    if a is None or b is None or not math.isfinite(a) or not math.isfinite(b) or b <= 0:
        return None
    return a / b


@dataclass(frozen=True)
class Summary:
    """Median and range of the figures over all runs of one set of parameters, or over all random draws of a study.

    Attributes
    ----------
    study
        Its study.
    values
        What is varied there: key -> value; for random draws key -> "drawn".
    runs, failed
        How many, and how many of them failed.
    declined
        In how many of them a compensator was declined: the trial ran without it, and its ratio is 1.
    figures
        Label -> median, lowest, highest; None where there is none.
    """

    study: str
    values: Mapping[str, Any]
    runs: int
    failed: int
    declined: int
    figures: Mapping[str, tuple[float, float, float] | None]


def summarise(
    spec: SweepSpec, points: Sequence[Point], columns: Mapping[str, Sequence[Any]]
) -> tuple[Summary, ...]:
    """Return medians over seeds of each point of a grid, and over draws and seeds of random studies."""
    ratios = ratios_of(columns)
    declined_rows = set[int]()
    for name, numbers in columns.items():
        if name.endswith("/declined"):
            # A table read from a file has text in its columns.
            declined_rows |= {row for row, number in enumerate(numbers) if float(number or 0.0)}
    studies = {study.name: study for study in spec.studies}
    # Rows that differ in seeds and random draws alone are summarised together.
    groups: dict[tuple[str, ...], list[int]] = {}
    for row, point in enumerate(points):
        values = _grid_values(spec, studies[point.study], point)
        group = (point.study, *map(repr, values.values()))
        groups.setdefault(group, []).append(row)
    summaries = []
    for rows in groups.values():
        point = points[rows[0]]
        study = studies[point.study]
        values = _grid_values(spec, study, point)
        values |= dict.fromkeys(study.random, "drawn")
        failed = sum(bool(columns[ERROR][row]) for row in rows)
        declined = sum(row in declined_rows for row in rows)
        figures = {}
        for label, numbers in ratios.items():
            figures[label] = _median_and_range([numbers[row] for row in rows])
        summaries.append(Summary(study.name, values, len(rows), failed, declined, figures))
    return tuple(summaries)


def _grid_values(spec: SweepSpec, study: Study, point: Point) -> dict[str, Any]:
    return {key: point.values[key] for key in (*spec.grid, *study.grid)}


def _median_and_range(numbers: Sequence[float | None]) -> tuple[float, float, float] | None:
    finite = [number for number in numbers if number is not None and math.isfinite(number)]
    if not finite:
        return None
    return statistics.median(finite), min(finite), max(finite)
