"""Pictures of what the joints of a robot can do, and of a fitted plant beside the logs."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path

import numpy as np

from dehyst.report.drawing import Line, chart
from dehyst.report.parts import Axes, Draw, Figure, Panel
from dehyst.report.svg import write_picture
from dehyst.report.text import short
from dehyst.report.theme import INK, MUTED, TEST, TRAIN
from dehyst.robot.experiments.plant_fit import UNITS, LogFit, PlantFit
from dehyst.robot.experiments.rig import PRESSURES, JointCheck

TITLE = "dehyst rig: "  # by which a picture is known that may be drawn anew


def write_rig_figure(path: str | PathLike[str], name: str, found: Mapping[int, JointCheck]) -> Path:
    """Write the picture: a panel a joint with muscles."""
    panels = tuple(
        Panel(f"joint {number}", _torques(check), f"Torque of joint {number} over its angle at 1 to 6 bar.")
        for number, check in found.items()
        if check.pulls.size
    )
    title = f"Torque of {short(name, 60)}: one muscle at 1 to 6 bar, the other at its lowest pressure"
    return write_picture(Figure("rig", title, "", panels, columns=3), path, f"{TITLE}{name}", headed=True)


def _torques(check: JointCheck) -> Draw:
    angle = np.degrees(check.angle)
    lines = [
        Line(angle, pull, token, f"muscle {muscle}" if k == len(PRESSURES) - 1 else "", 1.2, 0.4 + 0.1 * k)
        for muscle, pulls, token in ((1, check.pulls, TRAIN), (2, -check.back, TEST))
        for k, pull in enumerate(pulls)
    ]

    def gravity(axes: Axes) -> None:
        axes.axhspan(*check.gravity, color=MUTED.light, alpha=0.25, lw=0, label="gravity takes")

    return chart("angle [°]", "torque [Nm]", lines, zero=True, include=check.gravity, also=gravity)


def write_fit_figure(path: str | PathLike[str], found: PlantFit) -> Path:
    """Write the picture of a fit: a panel a log, the plant before and after over what was measured, held out."""
    panels = tuple(
        Panel(each.log.name, _against(each), "The plant's response over the measured one on parts not fitted.")
        for each in found.logs
    )
    title = "The plant on parts that were not fitted"
    return write_picture(Figure("rig-fit", title, "", panels, columns=3), path, f"{TITLE}fit", headed=True)


def _against(each: LogFit) -> Draw:
    factor, unit = UNITS[each.log.quantity]
    held = ~each.log.fitted & each.log.counted
    measured = factor * each.log.response[held]
    ends = np.array([measured.min(), measured.max()])
    lines = [
        Line(measured, factor * response[held], token, label, 0.0, marker=".")
        for response, token, label in ((each.before, MUTED, "before"), (each.after, TRAIN, "after"))
    ]
    what = each.log.quantity
    return chart(f"measured {what} [{unit}]", f"plant {what} [{unit}]", [*lines, Line(ends, ends, INK, "measured")])
