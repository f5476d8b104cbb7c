"""Content of a sweep file: the experiment, and the values of each varied parameter.

A sweep file is TOML::

    name = "sensitivity"
    experiment = "joint"                 # "joint" (one joint alone) or "arm"
    joint = 1
    seeds = [1, 2, 3]                    # every point runs with each of them
    trials = ["slow"]                    # of fast, slow, slow_no_integrator
    compensators = ["off", "paper"]
    random_seed = 0                      # of random draws
    robot = "my_arm.toml"                # a parameter file of one's own, beside this one; the packaged arm without it

    [set]                                # for all points
    "controller.inertia_error" = -0.1

    [grid]                               # every study is run for each of these
    "hysteresis.mechanism" = ["maxwell-slip", "dahl"]

    [[study]]
    name = "size"
    set."hysteresis.creep" = 0.0
    grid."hysteresis.scale" = [0.5, 1.0, 1.5]

    [[study]]
    name = "poles"
    seeds = [1]                          # instead of the seeds above
    draws = 200
    random."controller.pole_1_s" = {low = 4.0, high = 16.0, log = true}
    random."valve.mpye.leak" = {choice = [0.01, 0.02, 0.04]}

Keys under ``set``, ``grid`` and ``random`` are those of the robot's file with their table, and those of a run:
``load_Nm``, ``initial_state``, ... Several lists of a grid are crossed; a grid and random draws are crossed too, with
the same draws at every point of the grid.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dehyst.errors import ParameterError
from dehyst.robot.experiments.results import TRIALS
from dehyst.robot.experiments.sweep.keys import Keys, flatten, keys_of_file
from dehyst.robot.experiments.sweep.read import Reader

EXPERIMENTS = ("joint", "arm")
LARGEST_FILE = 1 << 20


@dataclass(frozen=True)
class Draw:
    """How a parameter is drawn: uniformly between two bounds, or from a list.

    Attributes
    ----------
    low, high
        Bounds; not used with `choice`.
    log
        Whether the logarithm is uniform.
    choice
        Values that are equally likely; empty for bounds.
    """

    low: float = 0.0
    high: float = 0.0
    log: bool = False
    choice: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Study:
    """A set of points: a grid, random draws, or both crossed.

    Attributes
    ----------
    name
        Its name in the table.
    fixed
        Key -> value at all its points.
    grid
        Key -> values; several keys are crossed.
    random
        Key -> how it is drawn.
    draws
        Number of random draws; 0 without any.
    seeds
        Each point is run with each of them.
    """

    name: str
    seeds: tuple[int, ...]
    fixed: Mapping[str, Any] = field(default_factory=dict)
    grid: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    random: Mapping[str, Draw] = field(default_factory=dict)
    draws: int = 0

    @property
    def varied(self) -> tuple[str, ...]:
        """Keys that differ from point to point of this study."""
        return (*self.grid, *self.random)


@dataclass(frozen=True)
class SweepSpec:
    """A sweep: what is run, and where.

    Attributes
    ----------
    name
        Its name, for tables and pictures.
    experiment
        "joint", one joint alone, or "arm", the whole arm on its path.
    joint
        Number of the joint, 1 to 7, for "joint".
    trials, compensators
        What is run at each point.
    studies
        In the order of the file.
    grid
        Key -> values, crossed with every study.
    random_seed
        Seed of the random draws.
    keys
        What can be set, and its values if it is not: of the robot that is swept.
    """

    name: str
    experiment: str
    joint: int
    trials: tuple[str, ...]
    compensators: tuple[str, ...]
    studies: tuple[Study, ...]
    grid: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    random_seed: int = 0
    keys: Keys = field(default_factory=Keys, compare=False, repr=False)


def load_sweep(path: str | Path) -> SweepSpec:
    """Read a sweep file.

    Raises
    ------
    ParameterError
        If it cannot be read, is no TOML, has an unknown key, or a value that its key does not allow.
    """
    source = Path(path)
    try:
        if source.stat().st_size > LARGEST_FILE:
            raise ParameterError(
                f"'{source}' has {source.stat().st_size} bytes; a sweep file has a few hundred. Name the TOML file."
            )
        document = tomllib.loads(source.read_bytes().decode("utf-8"))
    except OSError as fault:
        raise ParameterError(
            f"cannot read the sweep file '{source}': {fault.strerror or fault}. Name a TOML file such as "
            f"examples/sensitivity.toml."
        ) from None
    except (ValueError, RecursionError) as fault:  # TOML and UTF-8 faults, or a path with a null character
        raise ParameterError(f"sweep file {str(source)!r} is no TOML: {fault}. Correct it there.") from None
    return parse_sweep(document, source.name, source.parent)


def parse_sweep(document: Mapping[str, Any], name: str = "sweep.toml", folder: Path = Path()) -> SweepSpec:
    """Return the sweep that a TOML document describes; `name` is for messages, `folder` has the robot's file.

    Examples
    --------
    >>> study = {"name": "size", "grid": {"hysteresis.scale": [0.5, 1.0]}}
    >>> parse_sweep({"name": "s", "study": [study]}).studies[0].grid
    {'hysteresis.scale': (0.5, 1.0)}
    """
    top = Reader(name, document)
    robot = top.text("robot", "the packaged arm")
    keys = keys_of_file(folder / robot) if "robot" in document else Keys()
    seeds = top.seeds("seeds", (1,))
    fixed, grid = _fixed(top, keys), _grid(top, keys)
    if both := sorted(set(fixed) & set(grid)):
        raise ParameterError(f"{name}: {both[0]} stands in [set] and in [grid]. Remove one of them.")
    spec = SweepSpec(
        name=top.text("name", Path(name).stem),
        experiment=top.one_of("experiment", EXPERIMENTS, "joint"),
        joint=top.whole("joint", 1, 1, 7),
        trials=top.several("trials", TRIALS, TRIALS),
        compensators=top.several("compensators", None, ("off", "paper")),
        studies=tuple(_study(top, k, part, keys, seeds, fixed, grid) for k, part in enumerate(top.tables("study"), 1)),
        grid=grid,
        random_seed=top.whole("random_seed", 0, 0, 2**63),
        keys=keys,
    )
    top.finish()
    names = [study.name for study in spec.studies]
    if twice := sorted({each for each in names if names.count(each) > 1}):
        raise ParameterError(f"{name}: two studies are called '{twice[0]}'. Give each its own name.")
    return spec


def _study(
    top: Reader,
    number: int,
    table: Any,
    keys: Keys,
    seeds: tuple[int, ...],
    fixed: Mapping[str, Any],
    crossed: Mapping[str, Any],
) -> Study:
    reader = Reader(f"{top.where}, study {number}", table)
    name = reader.text("name", f"study {number}")
    reader = Reader(f"{top.where}, study '{name}'", table)
    reader.text("name", name)
    own, grid, random = _fixed(reader, keys), _grid(reader, keys), _random(reader, keys)
    study = Study(
        name, reader.seeds("seeds", seeds), {**fixed, **own}, grid, random, reader.whole("draws", 0, 0, 1_000_000)
    )
    reader.finish()
    if bool(study.random) != bool(study.draws):
        given, other = ("random", "draws = 100") if study.random else ("draws", 'random."KEY" = {low = 1, high = 2}')
        raise ParameterError(f"{reader.where} has {given} but no {other.split()[0]}. Add: {other}")
    for first, second in ((grid, random), (own, grid), (own, random), (crossed, grid), (crossed, random)):
        if both := sorted(set(first) & set(second)):
            raise ParameterError(f"{reader.where} gives {both[0]} two times. Remove one of them.")
    # What a study varies or sets wins over the file's [set]; over its [grid] it must not, it would undo the crossing.
    if both := sorted(set(own) & set(crossed)):
        raise ParameterError(f"{reader.where} sets {both[0]}, which [grid] varies in every study. Remove one of them.")
    return study


def _fixed(reader: Reader, keys: Keys) -> dict[str, Any]:
    return {key: keys.checked(key, value, reader.where) for key, value in flatten(reader.table("set")).items()}


def _grid(reader: Reader, keys: Keys) -> dict[str, tuple[Any, ...]]:
    grid = {}
    for key, values in flatten(reader.table("grid")).items():
        if not isinstance(values, list) or not values:
            raise ParameterError(f'{reader.where}: grid."{key}" must be a list of values, for example [1.0, 2.0].')
        checked = [keys.checked(key, value, reader.where) for value in values]
        if any(value in checked[:k] for k, value in enumerate(checked)):
            raise ParameterError(f'{reader.where}: grid."{key}" has a value two times. Remove one.')
        grid[key] = tuple(checked)
    return grid


def _random(reader: Reader, keys: Keys) -> dict[str, Draw]:
    return {key: _draw(key, how, keys, reader.where) for key, how in _draw_tables(reader.table("random"))}


def _draw_tables(table: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    """Dotted key and what stands there, down to the tables that say how to draw."""
    found: list[tuple[str, Any]] = []
    for key, value in table.items():
        nested = isinstance(value, dict) and value and all(isinstance(item, dict) for item in value.values())
        found += _draw_tables(value, f"{prefix}{key}.") if nested else [(f"{prefix}{key}", value)]
    return found


def _draw(key: str, how: Any, keys: Keys, where: str) -> Draw:
    reader = Reader(f'{where}, random."{key}"', how)
    choice, log = reader.items("choice"), reader.flag("log")
    if choice:
        reader.finish()
        return Draw(choice=tuple(keys.checked(key, value, where) for value in choice))
    low, high = reader.number("low"), reader.number("high")
    reader.finish()
    keys.checked(key, low, where)
    if not isinstance(keys.nominal.get(key, 0.0), float):
        raise ParameterError(
            f"{reader.where}: {key} is no number with decimals. Write {{choice = [...]}} with its values."
        )
    if low < high and (low > 0.0 or not log):
        return Draw(low, high, log)
    raise ParameterError(
        f"{reader.where}: {'0 < ' if log else ''}low < high is needed, got low = {low:g} and high = {high:g}."
    )
