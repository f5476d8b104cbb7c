"""Figures of a reproduction with their spread over seeds, from the data of ``--json``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.report.text import number
from dehyst.robot.experiments.results import TRIALS, PlantResult, Reproduction, TrialRun

OFF = "off"
NO_HYSTERESIS = "none"  # the plant that is the control
TRIAL_NAMES = {"fast": "fast", "slow": "slow", "slow_no_integrator": "slow without integrator"}
UNITS = {"mm": "mm", "deg": "°", "percent": "%", "m_s": "m/s", "mm_s": "mm/s", "Nm": "Nm", "s": "s", "bar": "bar"}


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
        >>> str(spread([0.1, 0.2])), str(spread([0.1]))
        ('0.150 (0.100–0.200)', '0.100')
        """
        ends = {number(self.low), number(self.high)}
        if self.seeds < 2 or ends == {number(self.mean)}:
            return number(self.mean)
        between = "–" if self.low >= 0.0 else " to "
        return f"{number(self.mean)} ({number(self.low)}{between}{number(self.high)})"


def cell(found: Spread | None) -> str:
    """Return a figure as a cell of a table."""
    return "–" if found is None else str(found)


def counted(found: Spread | None) -> str:
    """Return a number of things with its spread.

    Examples
    --------
    >>> counted(spread([17, 18, 18])), counted(spread([5]))
    ('17.7 (17–18)', '5')
    """
    if found is None:
        return "–"
    mean = f"{found.mean:.1f}".removesuffix(".0")
    return mean if found.low == found.high else f"{mean} ({found.low:.0f}–{found.high:.0f})"


def spread(values: Iterable[float | None]) -> Spread | None:
    """Return the spread of values, or None if there are none."""
    found = [float(value) for value in values if value is not None]
    if not found:
        return None
    return Spread(float(np.mean(found)), min(found), max(found), len(found))


def _at(table: Any, *keys: object) -> Any:
    """Value of a nested mapping, keys as they are or as words (JSON knows no other), or None."""
    for key in keys:
        if not isinstance(table, Mapping):
            return None
        table = table.get(key, table.get(str(key)))
    return table


def trial_figure(plant: PlantResult, joint: int, trial: str, compensator: str, name: str) -> Spread | None:
    """Return ``rms_deg`` or ``max_deg`` of a joint over the seeds."""
    return spread(_at(f, "joints", joint, "trials", trial, compensator, name) for f in plant.figures.values())


def seed_figure(plant: PlantResult, seed: int, joint: int, trial: str, compensator: str, name: str) -> float | None:
    """Return a joint's figure for one seed, or None."""
    found = _at(plant.figures, seed, "joints", joint, "trials", trial, compensator, name)
    return None if found is None else float(found)


def trial_ratio(plant: PlantResult, joint: int, trial: str, compensator: str, name: str) -> Spread | None:
    """Return the figure with compensator over the one without, seed by seed."""
    pairs = [
        [_at(f, "joints", joint, "trials", trial, c, name) for c in (compensator, OFF)] for f in plant.figures.values()
    ]
    return spread(on / off for on, off in pairs if on is not None and off)


def identification_figure(plant: PlantResult, joint: int, name: str) -> Spread | None:
    """Return a figure of a joint's identification over the seeds."""
    return spread(_at(f, "joints", joint, "identification", name) for f in plant.figures.values())


def tool_figures(plant: PlantResult, trial: str, compensator: str) -> dict[str, Spread]:
    """Return the tool's figures by name, nested ones as "AT_mm, line"."""
    tables = [_flat(_at(f, "tool", trial, compensator)) for f in plant.figures.values()]
    names = dict.fromkeys(name for table in tables for name in table)
    found = {name: spread(table.get(name) for table in tables) for name in names}
    return {name: value for name, value in found.items() if value is not None}


def tool_ratio(plant: PlantResult, trial: str, compensator: str, name: str) -> Spread | None:
    """Return the tool's figure with compensator over the one without, seed by seed."""
    pairs = [[_at(f, "tool", trial, c, name) for c in (compensator, OFF)] for f in plant.figures.values()]
    return spread(on / off for on, off in pairs if on is not None and off)


def _flat(table: Any, after: str = "") -> dict[str, float]:
    found: dict[str, float] = {}
    for key, value in table.items() if isinstance(table, Mapping) else ():
        if isinstance(value, Mapping):
            found |= _flat(value, after if key == "figures" else f"{after}, {key}")
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            found[f"{key}{after}"] = float(value)
    return found


def name_and_unit(key: str) -> tuple[str, str]:
    """Return name and unit of a figure whose name carries its unit.

    Examples
    --------
    >>> name_and_unit("AT_mm, line"), name_and_unit("tracking_rms_mm"), name_and_unit("FV_mm_s")
    (('AT, line', 'mm'), ('tracking rms', 'mm'), ('FV', 'mm/s'))
    """
    head, comma, part = key.partition(", ")
    unit = next((u for u in sorted(UNITS, key=len, reverse=True) if head.endswith(f"_{u}")), "")
    name = head[: len(head) - len(unit) - 1] if unit else head
    return f"{name.replace('_', ' ')}{comma}{part}", UNITS.get(unit, "")


def accepted_of(plant: PlantResult, joint: int) -> tuple[int, int]:
    """Return in how many seeds the joint's model was accepted, and of how many that is known."""
    told = [_at(f, "joints", joint, "identification", "accepted") for f in plant.figures.values()]
    known = [bool(value) for value in told if value is not None]
    if not known and joint in plant.identifications:
        known = [plant.identifications[joint].accepted]
    return sum(known), len(known)


def left_off(plant: PlantResult, joint: int) -> bool:
    """Whether the joint's compensator was never switched on, because its model was accepted in no seed."""
    accepted, known = accepted_of(plant, joint)
    return known > 0 and accepted == 0


def same_run(off: TrialRun | None, on: TrialRun | None) -> bool:
    """Whether two runs are equal to the last bit, as they are when no compensator was switched on."""
    return off is not None and on is not None and np.array_equal(off.angle, on.angle)


def joints_of(result: Reproduction) -> tuple[int, ...]:
    """Return the numbers of all joints with figures, rising."""
    found = {int(j) for plant in result.plants.values() for f in plant.figures.values() for j in f.get("joints", {})}
    return tuple(sorted(found))


def trials_of(result: Reproduction) -> tuple[str, ...]:
    """Return the trials that were run on some plant, those of the paper first."""
    found = dict.fromkeys(
        trial
        for plant in result.plants.values()
        for f in plant.figures.values()
        for joint in f.get("joints", {}).values()
        for trial in joint.get("trials", {})
    )
    return (*(t for t in TRIALS if t in found), *(t for t in found if t not in TRIALS))


def run_of(plant: PlantResult, trial: str, compensator: str) -> TrialRun | None:
    """Return the run of the first seed, or None."""
    return next((r for r in plant.runs if r.trial == trial and r.compensator == compensator), None)


Pair = tuple[TrialRun | None, TrialRun | None]


def pair_of(plant: PlantResult, trial: str, compensator: str) -> Pair:
    """Return the runs of a trial without and with compensator."""
    return run_of(plant, trial, OFF), run_of(plant, trial, compensator)


def first_cycle(run: TrialRun) -> slice:
    """Return the samples of the first cycle."""
    return slice(0, int(np.searchsorted(run.cycle, run.cycle[0] + 1)) if run.cycle.size else 0)


def trial_name(trial: str) -> str:
    """Return the trial in words."""
    return TRIAL_NAMES.get(trial, trial.replace("_", " "))
