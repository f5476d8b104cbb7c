"""Summary at the top of the experiment's page: what was run, what compensation gained or lost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from dehyst.arrays import rank
from dehyst.report import PageTable, Tile
from dehyst.report import kit as report_kit
from dehyst_robot.experiments import PlantResult, Reproduction
from dehyst_robot.report._numbers import (
    NO_HYSTERESIS,
    OFF,
    Spread,
    cases_of,
    joints_of,
    left_off,
    short_names,
    tool_ratio,
    trial_figure,
    trial_name,
    trial_ratio,
    trials_of,
)
from dehyst_robot.report._policy import POLICY

MOST_CASES = 4  # that the first screen names
MECHANISMS = {
    "maxwell-slip": "40 springs in series with dry friction, whose slip force grows with pressure",
    "preisach": "a Preisach density that no sum of plays can reproduce",
    "dahl": "three Dahl elements, which forget where they turned",
    "braid": "springs whose slip force follows the angle of the braid: loops are wide where the muscle is long",
    "lugre": "a bristle of LuGre, whose sliding force falls with speed",
    "pinched": "a pinched Bouc-Wen spring, which is soft just past the zero of its force",
    "ageing": "springs whose contacts grow at rest: the stroke after a rest is stiffer",
    NO_HYSTERESIS: "the control: the same arm without hysteresis",
}
# None of these laws is a term of a compensator: docs/explanation/the-paper-and-this-repository.md.
FOREIGN = ("braid", "lugre", "pinched", "ageing")


def headline_of(result: Reproduction) -> tuple[int, str] | None:
    """Return joint and trial that the headline is about: joint 1, slow, if they were run."""
    joints, trials = joints_of(result), trials_of(result)
    if not joints or not trials:
        return None
    # Joint 1 and the slow trial if they were run, else the first of each.
    joint, trial = joints[0], trials[0]
    if 1 in joints:
        joint = 1
    if "slow" in trials:
        trial = "slow"
    return joint, trial


def relation(result: Reproduction) -> str:
    """Return what was run: controllers (if not the paper's alone), compensators, plants, seeds, joints."""
    seeds = max((len(plant.figures) for plant in result.plants.values()), default=0)
    controllers = short_names(map(str, result.settings.get("controllers", ())), 20)
    compensators = [report_kit.short(result.compensator, 40)]
    for name in result.compensators:
        if name != result.compensator:
            compensators.append(report_kit.short(name, 20))
    parts = [
        run_on(result),
        _first_of("controller", controllers),
        _first_of("compensator", compensators),
        report_kit.count(len(result.plants), "plant"),
        report_kit.count(seeds, "seed"),
        f"joints {', '.join(map(str, joints_of(result)))}",
    ]
    return " · ".join(filter(None, parts))


def run_on(result: Reproduction) -> str:
    """Return the robot, its file, its conditions and the poles of its loops; "" for a result that does not say."""
    settings = report_kit.flattened(result.settings)
    parts = []
    if "robot" in settings:
        robot = report_kit.short(str(settings["robot"]), 60)
        if "robot_file" in settings:
            robot += f" ({report_kit.short(str(settings['robot_file']), 40)})"
        parts.append(robot)
    if "conditions" in settings:
        parts.append(f"{settings['conditions']} plant")
    pole = settings.get("parameters.controller.pole_1_s")
    if isinstance(pole, (int, float)):
        parts.append(f"pole {pole:g} 1/s{_poles_of_joints(settings)}")
    return ", ".join(parts)


def _poles_of_joints(settings: Mapping[str, Any]) -> str:
    """Poles of joints that differ from the controller's, in brackets."""
    poles = []
    for key, value in settings.items():
        if key.startswith("parameters.joint.") and key.endswith(".pole_1_s"):
            poles.append(f"joint {key.split('.')[2]}: {value:g}")
    if not poles:
        return ""
    return f" ({', '.join(poles)})"


def met(result: Reproduction) -> tuple[str, ...]:
    """Return what joints met in the trials, a sentence each, with its plant."""
    sentences: list[str] = []
    for name, plant in result.everything.items():
        plant_name = report_kit.short(name, 30)
        sentences += [f"{plant_name}, {remark}" for remark in plant.remarks]
    return tuple(sentences)


def lost(result: Reproduction) -> str:
    """Say how many trials were lost; "" if none was."""
    trials = sum(": lost, " in remark for remark in met(result))
    if trials == 0:
        return ""
    if trials == 1:
        return "1 trial ended early and has no figures."
    return f"{trials} trials ended early and have no figures."


def _first_of(noun: str, names: Sequence[str]) -> str:
    """The first name, which the page is about, then those that were run beside it."""
    if not names:
        return ""
    first = f"{noun} “{names[0]}”"
    if len(names) == 1:
        return first
    return f"{first}, beside {', '.join(names[1:])}"


def lead(result: Reproduction) -> str:
    """Return the headline sentence."""
    about = headline_of(result)
    if about is None:
        return "No trial was run."
    joint, trial = about
    shares = []
    uncompensated = []
    errors = []
    for plant in result.plants.values():
        ratio = trial_ratio(plant, joint, trial, result.compensator, "rms_deg")
        name = report_kit.short(plant.plant, 30)
        if ratio and left_off(plant, joint):
            uncompensated.append(name)
        elif ratio:
            shares.append(f"{name} {_percent([ratio.mean])}")
        error = trial_figure(plant, joint, trial, OFF, "rms_deg")
        if error:
            errors.append(error.mean)
    # Without a run with compensator there is still an error to tell.
    if shares:
        plants = "; ".join(shares)
        words = f"Rms error of joint {joint} in the {trial_name(trial)} trial, with over without compensator: {plants}."
    else:
        span = report_kit.between(min(errors), max(errors))
        words = f"Without compensator, joint {joint} is {span}° off (rms) in the {trial_name(trial)} trial."
    if uncompensated:
        words += f" {_uncompensated(uncompensated)}"
    return words


def _uncompensated(names: Sequence[str]) -> str:
    """Say on which plants the compensator stayed off, and why.

    Examples
    --------
    >>> _uncompensated(["none"])
    'On plant “none” the compensator stayed off: the model identified there was not accepted.'
    """
    quoted = " and ".join(f"“{name}”" for name in names)
    if len(names) == 1:
        return f"On plant {quoted} the compensator stayed off: the model identified there was not accepted."
    return f"On plants {quoted} the compensator stayed off: the models identified there were not accepted."


def error_tiles(result: Reproduction) -> tuple[tuple[Tile, ...], str]:
    """Return the errors without and with compensator, a tile a plant or a trial, and what they show."""
    about = headline_of(result)
    if about is None:
        return (), ""
    joint, trial = about
    tiles = []
    # With one plant there is room for all trials; with several, for the trial of the headline.
    if len(result.plants) == 1:
        plant = next(iter(result.plants.values()))
        for each_trial in trials_of(result):
            name = trial_name(each_trial).capitalize()
            tiles.append(_tile(name, plant, joint, each_trial, result.compensator))
        note = f"Rms error of joint {joint} on plant {report_kit.short(plant.plant, 30)}"
        return tuple(tiles), note
    for plant in result.plants.values():
        name = report_kit.short(plant.plant, 30)
        tiles.append(_tile(name, plant, joint, trial, result.compensator))
    return tuple(tiles), f"Rms error of joint {joint} in the {trial_name(trial)} trial"


def _tile(name: str, plant: PlantResult, joint: int, trial: str, compensator: str) -> Tile:
    off = _degrees(trial_figure(plant, joint, trial, OFF, "rms_deg"))
    on = _degrees(trial_figure(plant, joint, trial, compensator, "rms_deg"))
    if left_off(plant, joint):
        return Tile(name, "", "", "model not accepted, compensator left off", off)
    ratio = trial_ratio(plant, joint, trial, compensator, "rms_deg")
    if ratio is None:
        return Tile(name, on, "", "without compensator only", off)
    return Tile(name, on, "", _change(ratio), off)


def _change(ratio: Spread) -> str:
    """What the compensator makes of an error: "down to 21.3 %"."""
    # "unchanged" has no direction, so it has no "down to".
    percent = f"{report_kit.number(100 * ratio.mean)} %"
    if abs(ratio.mean - 1.0) <= POLICY.unchanged:
        change = f"unchanged ({percent})"
    elif ratio.mean < 1.0:
        change = f"down to {percent}"
    else:
        change = f"up to {percent}"
    if ratio.seeds < 2:
        return change
    return (
        f"{change} ({report_kit.between(100 * ratio.low, 100 * ratio.high)}, {ratio.seeds} seeds)"
    )


def _degrees(spread: Spread | None) -> str:
    if spread is None:
        return ""
    return f"{report_kit.number(spread.mean)}°"


def shares_table(result: Reproduction) -> PageTable | None:
    """Return all trials in percent of the error without compensator, over the plants with hysteresis."""
    plants = [plant for name, plant in result.plants.items() if name != NO_HYSTERESIS]
    trials = trials_of(result)
    rows = []
    for joint in joints_of(result):
        cells = []
        for trial in trials:
            ratios = []
            for plant in plants:
                # Where the compensator stayed off, no error is an error with it.
                if not left_off(plant, joint):
                    ratio = trial_ratio(plant, joint, trial, result.compensator, "rms_deg")
                    ratios.append(ratio)
            cells.append(_cell(ratios))
        rows.append((f"joint {joint}", *cells))
    cells = []
    for trial in trials:
        ratios = [tool_ratio(p, trial, result.compensator, "tracking_rms_mm") for p in plants]
        cells.append(_cell(ratios))
    # The tool sums up all joints, and stands last.
    rows.append(("tool, distance", *cells))
    rows = [row for row in rows if set(row[1:]) - {"–"}]
    if not rows:
        return None
    over = f"plant {plants[0].plant}"
    if len(plants) > 1:
        over = "smallest to largest over the plants with hysteresis"
    note = f"Rms error with compensator in percent of the one without; {over}."
    return PageTable("", ("", *map(trial_name, trials)), tuple(rows), note)


def _cell(ratios: Sequence[Spread | None]) -> str:
    means = [ratio.mean for ratio in ratios if ratio is not None]
    if not means:
        return "–"
    return _percent(means)


WHY = "docs/explanation/gain-or-compensator.md#why-an-error-grows"


def grown(result: Reproduction) -> list[str]:
    """Say, a sentence each, in which cases a compensator makes an error of a joint larger than it is without."""
    sentences = []
    for name in result.compensators:
        which = ""
        if len(result.compensators) > 1:
            which = f" “{report_kit.short(name, 20)}”"
        for figure, words in (("rms_deg", "rms error"), ("max_deg", "largest error")):
            ratios = _every_ratio(result, name, figure)
            # A ratio near 1 is noise, and no warning.
            larger = [case for case in ratios if case[3] > 1.0 + POLICY.unchanged]
            if larger:
                cases = _cases(larger)
                sentences.append(
                    f"The {words} of a joint grows with the compensator{which} in {cases}."
                )
    return sentences


def _every_ratio(
    result: Reproduction, compensator: str, figure: str
) -> list[tuple[str, int, str, float]]:
    """Plant, joint, trial, and a figure with the compensator over the one without, wherever there are both."""
    cases = []
    for name, plant in result.everything.items():
        for joint, trial in cases_of(result):
            ratio = trial_ratio(plant, joint, trial, compensator, figure)
            if ratio is not None:
                cases.append((name, joint, trial, ratio.mean))
    return cases


def worse(result: Reproduction) -> str:
    """Say in which cases compensators make an error larger and where to read why, or that they do so in none."""
    sentences = grown(result)
    if sentences:
        return " ".join((*sentences, f"Why: {WHY}."))
    if not _every_ratio(result, result.compensator, "rms_deg"):
        return ""
    more = f"by more than {100 * POLICY.unchanged:g} %"
    return f"In no trial does a joint's rms or largest error grow {more} with the compensator."


def _cases(cases: Sequence[tuple[str, int, str, float]]) -> str:
    """How many cases there are, and which are the worst."""
    names = []
    for plant, joint, trial, ratio in sorted(cases, key=lambda case: -rank(case[3])):
        percent = f"{report_kit.number(100 * ratio)} %"
        names.append(
            f"{report_kit.short(plant, 30)}, joint {joint}, {trial_name(trial)} ({percent})"
        )
    more = ""
    if len(names) > MOST_CASES:
        more = f" and {len(names) - MOST_CASES} more"
    return f"{report_kit.count(len(names), 'case')}: {'; '.join(names[:MOST_CASES])}{more}"


def about_plant(name: str) -> str:
    """Return what a plant's hysteresis is, or "" for one of the user's own."""
    return MECHANISMS.get(name, "")


def _percent(values: Sequence[float]) -> str:
    low, high = f"{100 * min(values):.0f}", f"{100 * max(values):.0f}"
    if low == high:
        return f"{low} %"
    return f"{low}–{high} %"
