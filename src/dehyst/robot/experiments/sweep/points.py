"""Lists the points of a sweep in a fixed order."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.errors import ParameterError
from dehyst.robot.experiments.sweep.keys import RUN_SETTINGS
from dehyst.robot.experiments.sweep.spec import Draw, Study, SweepSpec

MOST = 200_000  # runs of one sweep


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
        return {key: self.values.get(key, default) for key, (default, _) in RUN_SETTINGS.items()}


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
