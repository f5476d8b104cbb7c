"""Tiles of the first screen: an error without and with compensator, a plant each, or a trial each of the only plant."""

from __future__ import annotations

from dehyst.experiments.results import PlantResult, Reproduction
from dehyst.report.reproduction.numbers import OFF, Spread, left_off, trial_figure, trial_name, trial_ratio, trials_of
from dehyst.report.reproduction.words import UNCHANGED, headline_of
from dehyst.report.text import number, short

Tile = tuple[str, str, str, str]


def tiles(result: Reproduction) -> tuple[tuple[Tile, ...], str]:
    """Return tiles (name, error without, error with compensator, remark), and what they show."""
    about = headline_of(result)
    if about is None:
        return (), ""
    joint, trial = about
    if len(result.plants) == 1:
        plant = next(iter(result.plants.values()))
        made = (_tile(trial_name(t).capitalize(), plant, joint, t, result.compensator) for t in trials_of(result))
        return tuple(made), f"Rms error of joint {joint} on plant {short(plant.plant, 30)}"
    made = (_tile(short(p.plant, 30), p, joint, trial, result.compensator) for p in result.plants.values())
    return tuple(made), f"Rms error of joint {joint} in the {trial_name(trial)} trial"


def _tile(name: str, plant: PlantResult, joint: int, trial: str, compensator: str) -> Tile:
    off, on = (trial_figure(plant, joint, trial, c, "rms_deg") for c in (OFF, compensator))
    if left_off(plant, joint):
        return name, _degrees(off), "", "model not accepted, compensator left off"
    ratio = trial_ratio(plant, joint, trial, compensator, "rms_deg")
    return name, _degrees(off), _degrees(on), "without compensator only" if ratio is None else _way(ratio)


def _way(ratio: Spread) -> str:
    percent = f"{number(100 * ratio.mean)} %"
    same = abs(ratio.mean - 1.0) <= UNCHANGED
    text = f"unchanged ({percent})" if same else f"{'down' if ratio.mean < 1.0 else 'up'} to {percent}"
    if ratio.seeds < 2:
        return text
    return f"{text} ({number(100 * ratio.low)}–{number(100 * ratio.high)}, {ratio.seeds} seeds)"


def _degrees(found: Spread | None) -> str:
    return "" if found is None else f"{number(found.mean)}°"
