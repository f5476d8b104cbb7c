"""The arm on its path: which run is shown, how much its errors are magnified, and the words below the picture."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from dehyst.experiments.results import TRIALS, PlantResult, Reproduction, TrialRun
from dehyst.report.reproduction.arm_svg import Track, close_up, whole_arm
from dehyst.report.reproduction.numbers import OFF, left_off, same_run, trial_name
from dehyst.report.reproduction.trials import first_cycle, pair_of
from dehyst.report.text import number, short

# Seconds that one cycle takes on the page, at most; a shorter one is shown as it is.
SHOWN = 16.0
# The largest error of the tool is drawn at most this share of the path's size.
VISIBLE = 0.09


@dataclass(frozen=True)
class Scene:
    """The moving picture: its views as (title, SVG), the words below, the sides that are drawn ("off", "on")."""

    views: tuple[tuple[str, str], ...]
    caption: str
    sides: tuple[str, ...]


def scene(result: Reproduction) -> Scene | None:
    """Return the moving picture of the first plant whose runs hold poses of the arm, or None."""
    plants = [*result.plants.values()]
    plants.sort(key=_without_compensator)  # stable: the first plant that shows a difference
    found = next(filter(None, (_choose(plant, result.compensator) for plant in plants)), None)
    if found is None:
        return None
    plant, trial, runs = found
    factor = magnification(runs.values())
    track = _track(runs, factor)
    duration = float(track.frame_time[-1] - track.frame_time[0])
    faster = duration / track.seconds
    speed = "in real time" if faster < 1.05 else f"shown {number(faster, 2)} times as fast as it was"
    size = "in true size" if factor == 1.0 else f"drawn {factor:g} times larger"
    left = " The compensator was left off: the runs without and with it are the same." if len(runs) == 1 else ""
    return Scene(
        (
            ("The whole arm", whole_arm(track)),
            (f"The path in its own plane{'' if factor == 1.0 else f', errors × {factor:g}'}", close_up(track)),
        ),
        f"Plant {short(plant.plant, 40)}, {trial_name(trial)} trial, first cycle, {speed}; errors of the tool "
        f"{size}.{left}",
        tuple(track.traces),
    )


def _without_compensator(plant: PlantResult) -> bool:
    joints = plant.identifications
    return bool(joints) and all(left_off(plant, joint) for joint in joints)


def _choose(plant: PlantResult, compensator: str) -> tuple[PlantResult, str, dict[str, TrialRun]] | None:
    """The slow trial, which the headline is about, or the first one that has poses."""
    for trial in ("slow", *TRIALS):
        pair = pair_of(plant, trial, compensator)
        runs = {side: run for side, run in zip((OFF, "on"), pair, strict=True) if run is not None}
        if same_run(*pair):
            del runs["on"]
        if any(len(run.frames) > 1 for run in runs.values()):
            return plant, trial, runs
    return None


def magnification(runs: Iterable[TrialRun]) -> float:
    """Return by which round factor, 1 to 1000, the errors of the tool are drawn larger."""
    size, largest = 0.0, 0.0
    for run in runs:
        part = first_cycle(run)
        error = np.linalg.norm((run.tool - run.tool_desired)[part], axis=1)
        size = max(size, float(np.max(np.ptp(run.tool_desired[part], axis=0))))
        largest = max(largest, float(np.quantile(error, 0.98)))
    choices = [m * 10.0**e for e in range(3) for m in (1, 2, 5)] + [1000.0]
    return max((c for c in choices if 0.0 < c * largest <= VISIBLE * size), default=1.0)


def _track(runs: Mapping[str, TrialRun], factor: float) -> Track:
    posed = next(run for run in reversed(list(runs.values())) if len(run.frames) > 1)
    part = first_cycle(posed)
    traces = {}
    for side, run in runs.items():
        magnified = run.tool_desired + factor * (run.tool - run.tool_desired)
        traces[side] = (run.time[first_cycle(run)], magnified[first_cycle(run)])
    duration = float(posed.frame_time[-1] - posed.frame_time[0])
    return Track(posed.tool_desired[part], traces, posed.frames, posed.frame_time, min(SHOWN, max(duration, 1.0)))
