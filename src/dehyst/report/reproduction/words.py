"""The headline of the reproduction: what compensation did, in one sentence and one tile a plant."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from dehyst.experiments.results import PlantResult, Reproduction
from dehyst.report.reproduction.numbers import (
    OFF,
    Spread,
    joints_of,
    trial_figure,
    trial_name,
    trial_ratio,
    trials_of,
)
from dehyst.report.text import count, number, short

NO_HYSTERESIS = "none"
# A ratio within this of 1 is called unchanged.
UNCHANGED = 0.02
MECHANISMS = {
    "maxwell-slip": "40 springs in series with dry friction, whose slip force grows with pressure",
    "preisach": "a Preisach density that no sum of plays can take",
    "dahl": "three Dahl elements, which forget where they turned",
    NO_HYSTERESIS: "the control: the same arm without hysteresis",
}


def headline_of(result: Reproduction) -> tuple[int, str] | None:
    """Return joint and trial that the headline is about: joint 1, slow, if they were run."""
    joints, trials = joints_of(result), trials_of(result)
    if not joints or not trials:
        return None
    return (1 if 1 in joints else joints[0]), ("slow" if "slow" in trials else trials[0])


def lead(result: Reproduction) -> str:
    """Return the headline sentence."""
    about = headline_of(result)
    if about is None:
        return "No trial was run."
    joint, trial = about
    with_it = {n: p for n, p in result.plants.items() if n != NO_HYSTERESIS}
    ratios = _ratios(with_it.values(), result.compensator, joint, trial)
    control = _ratios((p for n, p in result.plants.items() if n == NO_HYSTERESIS), result.compensator, joint, trial)
    if not ratios and not control:
        errors = [trial_figure(p, joint, trial, OFF, "rms_deg") for p in result.plants.values()]
        found = _range([error.mean for error in errors if error])
        return f"Without compensator, joint {joint} is {found}° off (rms) in the {trial_name(trial)} trial."
    said = []
    if ratios:
        plants = "On the plant" if len(with_it) == 1 else f"On all {len(ratios)} plants"
        said.append(
            f"{plants} with hysteresis the compensator brings the rms error of joint {joint} in the "
            f"{trial_name(trial)} trial to {_percent([r.mean for r in ratios])} of what it is without"
        )
    if control:
        left = control[0].mean
        way = "as it is" if abs(left - 1.0) <= UNCHANGED else "larger" if left > 1.0 else "smaller"
        verb = "leaves" if way == "as it is" else "makes"
        what = "it" if ratios else f"the rms error of joint {joint} in the {trial_name(trial)} trial"
        who = "on the plant without hysteresis it" if ratios else "On the plant without hysteresis the compensator"
        said.append(f"{who} {verb} {what} {way} ({100 * left:.0f} %)")
    return f"{'; '.join(said)}."


def others(result: Reproduction) -> tuple[str, ...]:
    """Return sentences on the other trials and joints, plants with hysteresis only."""
    about = headline_of(result)
    plants = [p for n, p in result.plants.items() if n != NO_HYSTERESIS]
    if about is None or not plants:
        return ()
    said = []
    for joint in joints_of(result):
        parts = []
        for trial in trials_of(result):
            found = _ratios(plants, result.compensator, joint, trial)
            if found and (joint, trial) != about:
                parts.append(f"{trial_name(trial)} {_percent([r.mean for r in found])}")
        if parts:
            said.append(f"Joint {joint}: {', '.join(parts)}.")
    worse = _worse(result, plants)
    return (*said, worse) if worse else tuple(said)


def _worse(result: Reproduction, plants: Sequence[PlantResult]) -> str:
    """Where the largest error grows, by name."""
    cases = [
        f"{short(plant.plant, 30)}, joint {joint}, {trial_name(trial)} ({number(100 * ratio.mean)} %)"
        for plant in plants
        for joint in joints_of(result)
        for trial in trials_of(result)
        if (ratio := trial_ratio(plant, joint, trial, result.compensator, "max_deg")) is not None and ratio.mean > 1.0
    ]
    if not cases:
        return ""
    more = f" and {len(cases) - 4} more" if len(cases) > 4 else ""
    return f"The largest error grows with the compensator in {count(len(cases), 'case')}: {'; '.join(cases[:4])}{more}."


def _ratios(plants: Iterable[PlantResult], compensator: str, joint: int, trial: str) -> list[Spread]:
    found = (trial_ratio(plant, joint, trial, compensator, "rms_deg") for plant in plants)
    return [ratio for ratio in found if ratio is not None]


def _range(values: Sequence[float]) -> str:
    low, high = number(min(values)), number(max(values))
    return low if low == high else f"{low} to {high}"


def _percent(values: Sequence[float]) -> str:
    low, high = f"{100 * min(values):.0f}", f"{100 * max(values):.0f}"
    return f"{low} %" if low == high else f"{low}–{high} %"


def tiles(result: Reproduction) -> tuple[tuple[str, str, str, str], ...]:
    """Return one tile a plant: its name, error without, error with compensator, remark."""
    about = headline_of(result)
    if about is None:
        return ()
    joint, trial = about
    made = []
    for plant in result.plants.values():
        off = trial_figure(plant, joint, trial, OFF, "rms_deg")
        on = trial_figure(plant, joint, trial, result.compensator, "rms_deg")
        ratio = trial_ratio(plant, joint, trial, result.compensator, "rms_deg")
        remark = "without compensator only" if ratio is None else _of_seeds(ratio)
        made.append((short(plant.plant, 30), _degrees(off), _degrees(on), remark))
    return tuple(made)


def _of_seeds(ratio: Spread) -> str:
    text = f"{'down' if ratio.mean < 1.0 else 'up'} to {number(100 * ratio.mean)} %"
    if ratio.seeds < 2:
        return text
    return f"{text} ({number(100 * ratio.low)}–{number(100 * ratio.high)}, {ratio.seeds} seeds)"


def _degrees(found: Spread | None) -> str:
    return "" if found is None else f"{number(found.mean)}°"


def about_plant(name: str) -> str:
    """Return what a plant's hysteresis is, or "" for one of the user's own."""
    return MECHANISMS.get(name, "")
