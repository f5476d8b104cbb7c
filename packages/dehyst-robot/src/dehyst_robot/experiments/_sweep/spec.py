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

import itertools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from dehyst.errors import ParameterError
from dehyst.files import document_of, text_of
from dehyst.shell import did_you_mean
from dehyst_robot.arm import Robot, Tables, load_robot
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.experiments._results import RUN_SETTINGS, TRIALS, RunSettings
from dehyst_robot.fields import Key, checked_table, dotted, read, short_repr

MOST_CHECKED = 1000  # sets of parameters that are tried on the robot beforehand, about a second


@dataclass(frozen=True, eq=False)
class Keys:
    """The keys a sweep can set, and what they are when it does not.

    Attributes
    ----------
    robot
        The robot whose parameters they are.
    """

    robot: Robot = field(default_factory=load_robot)

    @cached_property
    def nominal(self) -> Mapping[str, Any]:
        """Dotted key -> value if nothing is said.

        Examples
        --------
        >>> Keys().nominal["hysteresis.scale"], Keys().nominal["initial_state"]
        (1.0, 'homed')
        """
        return flatten(self.robot.values) | dict(RUN_SETTINGS) | {"conditions": self.conditions}

    @cached_property
    def conditions(self) -> str:
        """Of the packaged arm, which this robot extends."""
        return arm_kit.conditions_of(self.robot)

    @cached_property
    def names(self) -> frozenset[str]:
        """All keys."""
        return frozenset([*dotted(Tables, self.robot.values), *RUN_SETTINGS]) - {"name"}

    @cached_property
    def foreign(self) -> Mapping[str, Any]:
        """Changes that make the packaged robot this one: whole tables by name."""
        packaged = load_robot(conditions=self.conditions).values
        return {
            name: table for name, table in self.robot.values.items() if table != packaged.get(name)
        }

    def checked(self, key: str, value: Any, where: str) -> Any:
        """Return a value for a key; a whole number as a float where the robot's own value is one.

        Raises
        ------
        ParameterError
            If there is no such key, or a run setting cannot have that value.
        """
        if key not in self.names:
            raise ParameterError(
                f"{where}: there is no parameter {short_repr(key)}.{did_you_mean(key, self.names)} Parameters are the "
                f"keys of the robot's file with their table, for example hysteresis.scale, and "
                f"{', '.join(RUN_SETTINGS)}.",
                key=key,
            )
        # Settings of the run are no parameters of the robot.
        if key in RUN_SETTINGS:
            return checked_table(RunSettings, {key: value}, where)[key]
        if isinstance(self.nominal.get(key), float) and type(value) is int and abs(value) < 1 << 53:
            return float(value)
        return value

    def try_on(self, sets_of_changes: Iterable[tuple[str, Mapping[str, Any]]]) -> None:
        """Build the robot for sets of changes, each with its place in the file, and let it refuse what it cannot be.

        The first thousand are built. A later one that is wrong fails on its own, as a row of the table.

        Raises
        ------
        ParameterError
            At the first value, or set of values, that is not physical.
        """
        for where, changes in itertools.islice(sets_of_changes, MOST_CHECKED):
            try:
                self.robot.with_changes(changes)
            except ParameterError as fault:
                raise ParameterError(
                    f"{where}: {str(fault).removeprefix('robot: ')}", **fault.facts
                ) from None


def flatten(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested tables as one with dotted keys.

    Examples
    --------
    >>> flatten({"valve": {"mpye": {"leak": 0.02}}, "name": "arm"})
    {'valve.mpye.leak': 0.02, 'name': 'arm'}
    """
    # Keys may be written dotted or as tables: both are the same.
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            flat |= flatten(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = value
    return flat


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
    choice: Annotated[tuple[Any, ...], Key(most=10_000)] = ()


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
        Number of the joint for "joint".
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


Free = Mapping[str, Any]
Seeds = Annotated[tuple[int, ...] | None, Key("", 0, 2**63 - 1, most=100_000, distinct=True)]


@dataclass(frozen=True)
class _Parts:
    """What a sweep file and each of its studies may hold."""

    name: Annotated[str | None, Key(most=80)]
    seeds: Seeds
    fixed: Annotated[Free, Key(name="set")] = field(default_factory=dict)
    grid: Free = field(default_factory=dict)


@dataclass(frozen=True)
class _Study(_Parts):
    """[[study]]."""

    random: Free = field(default_factory=dict)
    draws: Annotated[int, Key("", 0, 1_000_000)] = 0


@dataclass(frozen=True, kw_only=True)
class _File(_Parts):
    """The whole file."""

    study: Annotated[tuple[_Study, ...], Key(most=100_000)]
    experiment: Annotated[str, Key(choices=("joint", "arm"))] = "joint"
    joint: Annotated[int, Key("", 1, 12)] = 1
    trials: Annotated[tuple[str, ...], Key(choices=TRIALS, distinct=True)] = TRIALS
    compensators: Annotated[tuple[str, ...], Key(distinct=True)] = ("off", "paper")
    random_seed: Annotated[int, Key("", 0, 2**63 - 1)] = 0
    robot: Annotated[str | None, Key(most=1000)]


def load_sweep(path: str | Path) -> SweepSpec:
    """Read a sweep file.

    Raises
    ------
    ParameterError
        If it cannot be read, is no TOML, has an unknown key, or a value that its key does not allow.
    """

    def refused(problem: str) -> ParameterError:
        return ParameterError(
            f"the sweep file '{path}' {problem}. Name a TOML file such as examples/sensitivity.toml."
        )

    document = document_of(text_of(path, refused), refused, "TOML")
    return parse_sweep(document, Path(path).name, Path(path).parent)


def parse_sweep(
    document: Mapping[str, Any], name: str = "sweep.toml", folder: Path = Path()
) -> SweepSpec:
    """Return the sweep that a TOML document describes; `name` is for messages, `folder` has the robot's file.

    Examples
    --------
    >>> study = {"name": "size", "grid": {"hysteresis.scale": [0.5, 1.0]}}
    >>> parse_sweep({"name": "s", "study": [study]}).studies[0].grid
    {'hysteresis.scale': (0.5, 1.0)}
    """
    file = read(_File, document, name)
    keys = Keys()
    if file.robot is not None:
        keys = Keys(load_robot(folder / file.robot))
    if load_robot(changes=keys.foreign, conditions=keys.conditions) != keys.robot:
        raise ParameterError(
            f"{name}: the robot '{file.robot}' has joints of its own, and a sweep changes those of the packaged arm. "
            f'Name a file that begins with extends = "default" and has no [body].',
            robot=file.robot,
        )
    # What stands at the top of the file holds for all studies.
    fixed, grid = _fixed(file, keys, name), _grid(file, keys, name)
    _refuse_twice(name, fixed, grid)
    studies, names, twice = [], set[str](), set[str]()
    for number, table in enumerate(file.study, 1):
        study = _study(file, number, table, keys, fixed, grid, name)
        studies.append(study)
        if study.name in names:
            twice.add(study.name)
        names.add(study.name)
    if twice:
        raise ParameterError(
            f"{name}: two studies are called '{min(twice)}'. Give each its own name."
        )
    return SweepSpec(
        name=file.name or Path(name).stem,
        experiment=file.experiment,
        joint=file.joint,
        trials=file.trials,
        compensators=file.compensators,
        studies=tuple(studies),
        grid=grid,
        random_seed=file.random_seed,
        keys=keys,
    )


def _study(
    file: _File, number: int, table: _Study, keys: Keys, fixed: Free, crossed: Free, source: str
) -> Study:
    name = table.name or f"study {number}"
    place = f"{source}, study '{name}'"
    study_fixed, grid = _fixed(table, keys, place), _grid(table, keys, place)
    random = {key: _draw(key, how, keys, place) for key, how in _draw_tables(table.random)}
    if random and not table.draws:
        raise ParameterError(f"{place} has random but no draws. Add: draws = 100")
    if table.draws and not random:
        raise ParameterError(
            f'{place} has draws but no random."KEY". Add: random."KEY" = {{low = 1, high = 2}}'
        )
    # What a study varies or sets wins over the file's [set]; over its [grid] it must not, it would undo the crossing.
    _refuse_twice(place, study_fixed, grid, random, crossed)
    seeds = table.seeds or file.seeds or (1,)
    return Study(name, seeds, {**fixed, **study_fixed}, grid, random, table.draws)


def _refuse_twice(place: str, *tables: Free) -> None:
    keys: set[str] = set()
    for table in tables:
        both = sorted(keys & set(table))
        if both:
            raise ParameterError(
                f"{place} gives {both[0]} two times, in set, grid or random. Remove one of them."
            )
        keys |= set(table)


def _fixed(table: _Parts, keys: Keys, place: str) -> dict[str, Any]:
    return {key: keys.checked(key, value, place) for key, value in flatten(table.fixed).items()}


def _grid(table: _Parts, keys: Keys, place: str) -> dict[str, tuple[Any, ...]]:
    grid = {}
    for key, values in flatten(table.grid).items():
        if not isinstance(values, list) or not values:
            raise ParameterError(
                f'{place}: grid."{key}" must be a list of values, for example [1.0, 2.0].'
            )
        checked_values: list[Any] = []
        for value in values:
            checked_value = keys.checked(key, value, place)
            # Values need not be hashable: 1 and 1.0 are the same one.
            if checked_value in checked_values:
                raise ParameterError(f'{place}: grid."{key}" has a value two times. Remove one.')
            checked_values.append(checked_value)
        grid[key] = tuple(checked_values)
    return grid


def _draw_tables(table: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    """Dotted key and what stands there, down to the tables that say how to draw."""
    tables: list[tuple[str, Any]] = []
    for key, value in table.items():
        # A table of tables is a part of the key; one of values says how to draw.
        if isinstance(value, dict) and value and all(isinstance(v, dict) for v in value.values()):
            tables += _draw_tables(value, f"{prefix}{key}.")
        else:
            tables.append((f"{prefix}{key}", value))
    return tables


def _draw(key: str, how: Any, keys: Keys, place: str) -> Draw:
    place = f'{place}, random."{key}"'
    draw = read(Draw, how, place)
    if draw.choice:
        return Draw(choice=tuple(keys.checked(key, value, place) for value in draw.choice))
    keys.checked(key, draw.low, place)
    if not isinstance(keys.nominal.get(key, 0.0), float):
        raise ParameterError(
            f"{place}: {key} is no number with decimals. Write {{choice = [...]}} with its values."
        )
    if draw.low < draw.high and (draw.low > 0.0 or not draw.log):
        return draw
    needed = "low < high"
    if draw.log:
        needed = "0 < low < high"
    raise ParameterError(
        f"{place}: {needed} is needed, got low = {draw.low:g} and high = {draw.high:g}."
    )
