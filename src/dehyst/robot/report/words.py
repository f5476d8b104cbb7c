"""Summary at the top of the experiment's page: what was run, what compensation gained or lost."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from dehyst.arrays import rank
from dehyst.report.parts import Table, Tile
from dehyst.report.text import between, count, listed, number, opened, short
from dehyst.robot.experiments.results import PlantResult, Reproduction
from dehyst.robot.report.numbers import (
    NO_HYSTERESIS,
    OFF,
    Spread,
    joints_of,
    left_off,
    tool_ratio,
    trial_figure,
    trial_name,
    trial_ratio,
    trials_of,
)
from dehyst.robot.report.tool import MEASURES, larger_figures

# A ratio within this of 1 is called unchanged.
UNCHANGED = 0.02
MOST_CASES = 4  # that the first screen names
MECHANISMS = {
    "maxwell-slip": "40 springs in series with dry friction, whose slip force grows with pressure",
    "preisach": "a Preisach density that no sum of plays can reproduce",
    "dahl": "three Dahl elements, which forget where they turned",
    NO_HYSTERESIS: "the control: the same arm without hysteresis",
}


def headline_of(result: Reproduction) -> tuple[int, str] | None:
    """Return joint and trial that the headline is about: joint 1, slow, if they were run."""
    joints, trials = joints_of(result), trials_of(result)
    if not joints or not trials:
        return None
    return (1 if 1 in joints else joints[0]), ("slow" if "slow" in trials else trials[0])


def relation(result: Reproduction) -> str:
    """Return what was run: controllers (if not the paper's alone), compensators, plants, seeds, joints."""
    seeds = max((len(plant.figures) for plant in result.plants.values()), default=0)
    controllers = [short(str(name), 20) for name in result.settings.get("controllers", ())]
    compensators = [short(name, 20) for name in result.compensators if name != result.compensator]
    said = [
        run_on(result),
        _first_of("controller", controllers[:1], controllers[1:]),
        _first_of("compensator", [short(result.compensator, 40)], compensators),
        count(len(result.plants), "plant"),
        count(seeds, "seed"),
        f"joints {', '.join(map(str, joints_of(result)))}",
    ]
    return " · ".join(filter(None, said))


def run_on(result: Reproduction) -> str:
    """Return the robot, its file, its conditions and the poles of its loops; "" for a result that does not say."""
    told = opened(result.settings)
    pole = told.get("parameters.controller.pole_1_s")
    file = f" ({short(str(told['robot_file']), 40)})" if "robot_file" in told else ""
    said = [f"{short(str(told['robot']), 60)}{file}"] if "robot" in told else []
    said += [f"{told['conditions']} plant"] if "conditions" in told else []
    own = [
        f"joint {key.split('.')[2]}: {value:g}"
        for key, value in told.items()
        if key.startswith("parameters.joint.") and key.endswith(".pole_1_s")
    ]
    others = f" ({', '.join(own)})" if own else ""
    said += [f"pole {pole:g} 1/s{others}"] if isinstance(pole, (int, float)) else []
    return ", ".join(said)


def met(result: Reproduction) -> tuple[str, ...]:
    """Return what joints met in the trials, a sentence each, with its plant."""
    return tuple(f"{short(name, 30)}, {said}" for name, plant in result.plants.items() for said in plant.remarks)


def lost(result: Reproduction) -> str:
    """Say how many trials were lost; "" if none was."""
    trials = sum(": lost, " in said for said in met(result))
    return f"{count(trials, 'trial')} ended early and {'has' if trials == 1 else 'have'} no figures." if trials else ""


def _first_of(noun: str, first: Sequence[str], others: Sequence[str]) -> str:
    """The one that the page is about, then those that were run beside it."""
    beside = f", beside {', '.join(others)}" if others else ""
    return f"{noun} “{first[0]}”{beside}" if first else ""


def lead(result: Reproduction) -> str:
    """Return the headline sentence."""
    about = headline_of(result)
    if about is None:
        return "No trial was run."
    joint, trial = about
    told = [p for p in result.plants.values() if trial_ratio(p, joint, trial, result.compensator, "rms_deg")]
    if not told:
        errors = [trial_figure(p, joint, trial, OFF, "rms_deg") for p in result.plants.values()]
        means = [error.mean for error in errors if error]
        found = between(min(means), max(means))
        return f"Without compensator, joint {joint} is {found}° off (rms) in the {trial_name(trial)} trial."
    what = f"the rms error of joint {joint} in the {trial_name(trial)} trial"
    said = [_gain(result, told, about, what), _refused(told, joint), _control(result, told, about, what)]
    text = "; ".join(filter(None, said))
    return f"{text[0].upper()}{text[1:]}."


def _gain(result: Reproduction, told: Sequence[PlantResult], about: tuple[int, str], what: str) -> str:
    """On the plants with hysteresis."""
    plants = [p for p in told if p.plant != NO_HYSTERESIS and not left_off(p, about[0])]
    if not plants:
        return ""
    ratios = [ratio.mean for ratio in _ratios(plants, result.compensator, *about)]
    where = f"on plant {short(plants[0].plant, 30)}" if len(plants) == 1 else f"on {len(plants)} plants with hysteresis"
    if len(plants) > 1 and len(plants) == sum(p.plant != NO_HYSTERESIS for p in told):
        where = f"on all {len(plants)} plants with hysteresis"
    return f"{where} the compensator brings {what} to {_percent(ratios)} of what it is without"


def _refused(told: Sequence[PlantResult], joint: int) -> str:
    """On plants with hysteresis whose model was not accepted."""
    plants = [short(p.plant, 30) for p in told if p.plant != NO_HYSTERESIS and left_off(p, joint)]
    if not plants:
        return ""
    which = f"plant{'s' if len(plants) > 1 else ''} {listed(plants)}"
    return f"on {which} the model of joint {joint} was not accepted, so its compensator stayed off"


def _control(result: Reproduction, told: Sequence[PlantResult], about: tuple[int, str], what: str) -> str:
    """On the plant without hysteresis."""
    plant = next((p for p in told if p.plant == NO_HYSTERESIS), None)
    if plant is None:
        return ""
    if left_off(plant, about[0]):
        return (
            "on the plant without hysteresis the identified model fails its test on unseen loops, "
            "so the compensator stays off there and changes nothing"
        )
    left = _ratios([plant], result.compensator, *about)[0].mean
    way = "as it is" if abs(left - 1.0) <= UNCHANGED else "larger" if left > 1.0 else "smaller"
    verb = "leaves" if way == "as it is" else "makes"
    return f"on the plant without hysteresis the compensator {verb} {what} {way} ({100 * left:.0f} %)"


def tiles(result: Reproduction) -> tuple[tuple[Tile, ...], str]:
    """Return the errors without and with compensator, a tile a plant or a trial, and what they show."""
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
        return Tile(name, "", "", "model not accepted, compensator left off", _degrees(off))
    ratio = trial_ratio(plant, joint, trial, compensator, "rms_deg")
    remark = "without compensator only" if ratio is None else _way(ratio)
    return Tile(name, _degrees(on), "", remark, _degrees(off))


def _way(ratio: Spread) -> str:
    same = abs(ratio.mean - 1.0) <= UNCHANGED
    way = "unchanged (" if same else "down to " if ratio.mean < 1.0 else "up to "
    text = f"{way}{number(100 * ratio.mean)} %{')' if same else ''}"
    return text if ratio.seeds < 2 else f"{text} ({between(100 * ratio.low, 100 * ratio.high)}, {ratio.seeds} seeds)"


def _degrees(found: Spread | None) -> str:
    return "" if found is None else f"{number(found.mean)}°"


def shares(result: Reproduction) -> Table | None:
    """Return all trials in percent of the error without compensator, over the plants with hysteresis."""
    plants = [p for n, p in result.plants.items() if n != NO_HYSTERESIS]
    trials, rows = trials_of(result), []
    for joint in joints_of(result):
        on = [p for p in plants if not left_off(p, joint)]
        rows.append((f"joint {joint}", *(_cell(_ratios(on, result.compensator, joint, trial)) for trial in trials)))
    tool = [[tool_ratio(p, trial, result.compensator, "tracking_rms_mm") for p in plants] for trial in trials]
    rows.append(("tool, distance", *(_cell([r for r in found if r is not None]) for found in tool)))
    rows = [row for row in rows if any(cell != "–" for cell in row[1:])]
    if not rows:
        return None
    over = "smallest to largest over the plants with hysteresis" if len(plants) > 1 else f"plant {plants[0].plant}"
    note = f"Rms error with compensator in percent of the one without; {over}."
    return Table("", ("", *(trial_name(trial) for trial in trials)), tuple(rows), note)


def _cell(ratios: Sequence[Spread]) -> str:
    return _percent([ratio.mean for ratio in ratios]) if ratios else "–"


WHY = "docs/explanation/gain-or-compensator.md#why-an-error-grows"


def grown(result: Reproduction) -> list[str]:
    """Say, a sentence each, in which cases a compensator makes an error of a joint larger than it is without."""
    said = []
    for name in result.compensators:
        which = f" “{short(name, 20)}”" if len(result.compensators) > 1 else ""
        for figure, words in (("rms_deg", "rms error"), ("max_deg", "largest error")):
            if found := [one for one in _every_ratio(result, name, figure) if one[3] > 1.0 + UNCHANGED]:
                said.append(f"The {words} of a joint grows with the compensator{which} in {_cases(found)}.")
    return said


def _every_ratio(result: Reproduction, compensator: str, figure: str) -> list[tuple[str, int, str, float]]:
    """Plant, joint, trial, and a figure with the compensator over the one without, wherever there are both."""
    return [
        (plant.plant, joint, trial, ratio.mean)
        for plant in result.plants.values()
        for joint in joints_of(result)
        for trial in trials_of(result)
        if (ratio := trial_ratio(plant, joint, trial, compensator, figure)) is not None
    ]


def worse(result: Reproduction) -> str:
    """Say in which cases compensators make an error larger and where to read why, or that they do so in none."""
    said = grown(result)
    if said:
        said.append(f"Why: each plant's “Where it gets worse” below, and {WHY}.")
    elif _every_ratio(result, result.compensator, "rms_deg"):
        more = f"by more than {100 * UNCHANGED:g} %"
        said.append(f"In no trial does a joint's rms or largest error grow {more} with the compensator.")
    return " ".join((*said, *filter(None, (_worse_tool(result),))))


def _worse_tool(result: Reproduction) -> str:
    """Which figures of the tool grow, and in which trials."""
    found: dict[str, dict[str, None]] = {}
    for plant in result.plants.values():
        for trial in trials_of(result):
            for symbol in larger_figures(plant, trial, result.compensator):
                found.setdefault(symbol, {})[trial_name(trial)] = None
    if not found:
        return ""
    words = [f"{MEASURES[symbol][0]} {symbol} ({listed([*trials])})" for symbol, trials in sorted(found.items())]
    where = "" if len(result.plants) == 1 else " on one plant or more"
    return f"Of the tool's figures by ISO 9283 these grow{where}: {', '.join(words)}. Each plant's part below says why."


def _cases(found: Sequence[tuple[str, int, str, float]]) -> str:
    named = [
        f"{short(plant, 30)}, joint {joint}, {trial_name(trial)} ({number(100 * ratio)} %)"
        for plant, joint, trial, ratio in sorted(found, key=lambda one: -rank(one[3]))
    ]
    more = f" and {len(named) - MOST_CASES} more" if len(named) > MOST_CASES else ""
    return f"{count(len(named), 'case')}: {'; '.join(named[:MOST_CASES])}{more}"


def _ratios(plants: Iterable[PlantResult], compensator: str, joint: int, trial: str) -> list[Spread]:
    found = (trial_ratio(plant, joint, trial, compensator, "rms_deg") for plant in plants)
    return [ratio for ratio in found if ratio is not None]


def about_plant(name: str) -> str:
    """Return what a plant's hysteresis is, or "" for one of the user's own."""
    return MECHANISMS.get(name, "")


def _percent(values: Sequence[float]) -> str:
    low, high = f"{100 * min(values):.0f}", f"{100 * max(values):.0f}"
    return f"{low} %" if low == high else f"{low}–{high} %"
