"""Figures of a reproduction with their spread over seeds, from the data of ``--json``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.report import kit as report_kit
from dehyst_robot.experiments import PlantResult, Reproduction
from dehyst_robot.experiments import kit as experiments_kit

OFF = "off"
NO_HYSTERESIS = "none"  # the plant that is the control
TRIAL_NAMES = {"fast": "fast", "slow": "slow", "slow_no_integrator": "slow without integrator"}
UNITS = {
    "mm": "mm",
    "deg": "°",
    "percent": "%",
    "m_s": "m/s",
    "mm_s": "mm/s",
    "Nm": "Nm",
    "s": "s",
    "bar": "bar",
}


@dataclass(frozen=True)
class Spread:
    """A figure over seeds: its mean and its smallest and largest value."""

    mean: float
    low: float
    high: float
    seeds: int

    def __str__(self) -> str:
        """Mean with the range in brackets; the mean alone for one seed.

        Examples
        --------
        >>> str(spread_over_seeds([0.1, 0.2])), str(spread_over_seeds([0.1]))
        ('0.150 (0.100–0.200)', '0.100')
        """
        ends = {report_kit.number(self.low), report_kit.number(self.high)}
        if self.seeds < 2 or ends == {report_kit.number(self.mean)}:
            return report_kit.number(self.mean)
        between = "–" if self.low >= 0.0 else " to "
        return f"{report_kit.number(self.mean)} ({report_kit.number(self.low)}{between}{report_kit.number(self.high)})"


def cell(spread: Spread | None) -> str:
    """Return a figure as a cell of a table."""
    if spread is None:
        return "–"
    return str(spread)


def counted(spread: Spread | None) -> str:
    """Return a number of things with its spread.

    Examples
    --------
    >>> counted(spread_over_seeds([17, 18, 18])), counted(spread_over_seeds([5]))
    ('17.7 (17–18)', '5')
    """
    if spread is None:
        return "–"
    # The mean of counts has a digit after the point only where the seeds differ.
    mean = f"{spread.mean:.1f}".removesuffix(".0")
    if spread.low == spread.high:
        return mean
    return f"{mean} ({spread.low:.0f}–{spread.high:.0f})"


def short_names(names: Iterable[str], most: int) -> list[str]:
    """Return names with at most so many characters each."""
    return [report_kit.short(name, most) for name in names]


def spread_over_seeds(values: Iterable[float | None]) -> Spread | None:
    """Return the spread of values, or None if there are none."""
    numbers = [float(value) for value in values if value is not None]
    if not numbers:
        return None
    return Spread(float(np.mean(numbers)), min(numbers), max(numbers), len(numbers))


def of_seeds(plant: PlantResult, *keys: object) -> list[Any]:
    """Return a figure in every seed, None where a seed has none."""
    return [_at(figures, *keys) for figures in plant.figures.values()]


def _on_over_off(on: Iterable[float | None], off: Iterable[float | None]) -> Spread | None:
    """The ratio of two figures over the seeds that have both."""
    ratios = []
    for with_it, without in zip(on, off, strict=True):
        # A figure of 0 without compensator leaves nothing to divide by.
        if with_it is not None and without:
            ratios.append(with_it / without)
    return spread_over_seeds(ratios)


def _at(table: Any, *keys: object) -> Any:
    """Value of a nested mapping, keys as they are or as words (JSON knows no other), or None."""
    for key in keys:
        if not isinstance(table, Mapping):
            return None
        # Figures that were read from a file have words for numbers.
        table = table.get(key, table.get(str(key)))
    return table


def trial_figure(
    plant: PlantResult, joint: int, trial: str, compensator: str, name: str
) -> Spread | None:
    """Return ``rms_deg`` or ``max_deg`` of a joint over the seeds."""
    return spread_over_seeds(of_seeds(plant, "joints", joint, "trials", trial, compensator, name))


def trial_ratio(
    plant: PlantResult, joint: int, trial: str, compensator: str, name: str
) -> Spread | None:
    """Return the figure with compensator over the one without, seed by seed."""
    trial_keys = ("joints", joint, "trials", trial)
    on = of_seeds(plant, *trial_keys, compensator, name)
    return _on_over_off(on, of_seeds(plant, *trial_keys, OFF, name))


def identification_figure(plant: PlantResult, joint: int, name: str) -> Spread | None:
    """Return a figure of a joint's identification over the seeds."""
    return spread_over_seeds(of_seeds(plant, "joints", joint, "identification", name))


def tool_figures(plant: PlantResult, trial: str, compensator: str) -> dict[str, Spread]:
    """Return the tool's figures by name, nested ones as "AT_mm, line"."""
    by_name: dict[str, list[float]] = {}
    for table in of_seeds(plant, "tool", trial, compensator):
        for name, value in _flat(table).items():
            by_name.setdefault(name, []).append(value)
    spreads = {}
    for name, values in by_name.items():
        spread = spread_over_seeds(values)
        if spread is not None:
            spreads[name] = spread
    return spreads


def tool_ratio(plant: PlantResult, trial: str, compensator: str, name: str) -> Spread | None:
    """Return the tool's figure with compensator over the one without, seed by seed."""
    on = of_seeds(plant, "tool", trial, compensator, name)
    return _on_over_off(on, of_seeds(plant, "tool", trial, OFF, name))


def _flat(table: Any, after: str = "") -> dict[str, float]:
    """Numbers of nested tables; what is no number is left out."""
    flat: dict[str, float] = {}
    if not isinstance(table, Mapping):
        return flat
    for key, value in table.items():
        if key == "figures" and isinstance(value, Mapping):
            flat |= _flat(value, after)
        elif isinstance(value, Mapping):
            flat |= _flat(value, f"{after}, {key}")
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            flat[f"{key}{after}"] = float(value)
    return flat


def name_and_unit(key: str) -> tuple[str, str]:
    """Return name and unit of a figure whose name carries its unit.

    Examples
    --------
    >>> name_and_unit("AT_mm, line"), name_and_unit("tracking_rms_mm"), name_and_unit("FV_mm_s")
    (('AT, line', 'mm'), ('tracking rms', 'mm'), ('FV', 'mm/s'))
    """
    name, comma, part = key.partition(", ")
    unit = ""
    # The longest first: "_mm_s" ends with "_s" too.
    for ending in sorted(UNITS, key=len, reverse=True):
        if name.endswith(f"_{ending}"):
            name = name.removesuffix(f"_{ending}")
            unit = UNITS[ending]
            break
    return f"{name.replace('_', ' ')}{comma}{part}", unit


def accepted_of(plant: PlantResult, joint: int) -> tuple[int, int]:
    """Return in how many seeds the joint's model was accepted, and how many seeds say so or not."""
    verdicts = []
    for verdict in of_seeds(plant, "joints", joint, "identification", "accepted"):
        if verdict is not None:
            verdicts.append(bool(verdict))
    # Older figures do not hold the verdict; the identification of the first seed does.
    if not verdicts and joint in plant.identifications:
        verdicts = [plant.identifications[joint].accepted]
    return sum(verdicts), len(verdicts)


def left_off(plant: PlantResult, joint: int) -> bool:
    """Whether the joint's compensator was never switched on, because its model was accepted in no seed."""
    accepted, seeds = accepted_of(plant, joint)
    return seeds > 0 and accepted == 0


def _figures_of_joints(result: Reproduction) -> Iterator[tuple[int, Mapping[str, Any]]]:
    """Joint and its figures, of every plant and seed."""
    for plant in result.plants.values():
        for figures in plant.figures.values():
            for joint, of_joint in figures.get("joints", {}).items():
                yield int(joint), of_joint


def same_run(off: experiments_kit.TrialRun | None, on: experiments_kit.TrialRun | None) -> bool:
    """Whether two runs are equal to the last bit, as they are when no compensator was switched on."""
    # Two runs with other noise are never the same to the last bit.
    return off is not None and on is not None and np.array_equal(off.angle, on.angle)


def joints_of(result: Reproduction) -> tuple[int, ...]:
    """Return the numbers of all joints with figures, rising."""
    return tuple(sorted({joint for joint, _ in _figures_of_joints(result)}))


def trials_of(result: Reproduction) -> tuple[str, ...]:
    """Return the trials that were run on some plant, those of the paper first."""
    trials: dict[str, None] = {}
    for _, figures in _figures_of_joints(result):
        trials |= dict.fromkeys(figures.get("trials", {}))
    # The user's own trials come after those of the paper.
    paper = [trial for trial in experiments_kit.TRIALS if trial in trials]
    return tuple(dict.fromkeys((*paper, *trials)))


def cases_of(result: Reproduction) -> Iterator[tuple[int, str]]:
    """Return every joint with every trial, joint by joint."""
    for joint in joints_of(result):
        for trial in trials_of(result):
            yield joint, trial


def run_of(plant: PlantResult, trial: str, compensator: str) -> experiments_kit.TrialRun | None:
    """Return the run of the first seed, or None."""
    for run in plant.runs:
        if run.trial == trial and run.compensator == compensator:
            return run
    return None


Pair = tuple[experiments_kit.TrialRun | None, experiments_kit.TrialRun | None]


def pair_of(plant: PlantResult, trial: str, compensator: str) -> Pair:
    """Return the runs of a trial without and with compensator."""
    return run_of(plant, trial, OFF), run_of(plant, trial, compensator)


def first_cycle(run: experiments_kit.TrialRun) -> slice:
    """Return the samples of the first cycle."""
    if not run.cycle.size:
        return slice(0, 0)
    return slice(0, int(np.searchsorted(run.cycle, run.cycle[0] + 1)))


def trial_name(trial: str) -> str:
    """Return the trial in words."""
    return TRIAL_NAMES.get(trial, trial.replace("_", " "))
