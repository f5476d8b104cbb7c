"""Pictures of what the joints of a robot can do, and of a fitted plant beside the logs."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path

import numpy as np

from dehyst.report import Axes, Draw, PageFigure, Panel, PanelLine, chart
from dehyst.report import kit as report_kit
from dehyst_robot.experiments import JointCheck, LogFit, PlantFit
from dehyst_robot.experiments import kit as experiments_kit

TITLE = "dehyst rig: "  # by which a picture is known that may be drawn anew


def write_rig_figure(
    path: str | PathLike[str], name: str, checks: Mapping[int, JointCheck]
) -> Path:
    """Write the picture: a panel a joint with muscles."""
    panels = []
    for number, check in checks.items():
        if check.pulls.size:
            words = f"Torque of joint {number} over its angle at 1 to 6 bar."
            panels.append(Panel(f"joint {number}", _torques(check), words))
    title = f"Torque of {report_kit.short(name, 60)}: one muscle at 1 to 6 bar, the other at its lowest pressure"
    figure = PageFigure("rig", title, "", tuple(panels), columns=3)
    return report_kit.write_picture(figure, path, f"{TITLE}{name}", headed=True)


def _torques(check: JointCheck) -> Draw:
    angle = np.degrees(check.angle)
    muscles = ((1, check.pulls, report_kit.TRAIN), (2, -check.back, report_kit.TEST))
    lines = []
    for muscle, pulls, token in muscles:
        # The legend names each muscle once, by its line at the highest pressure.
        labels = [""] * (len(experiments_kit.PRESSURES) - 1) + [f"muscle {muscle}"]
        for k, pull in enumerate(pulls):
            lines.append(PanelLine(angle, pull, token, labels[k], 1.2, 0.4 + 0.1 * k))

    def gravity(axes: Axes) -> None:
        axes.axhspan(
            *check.gravity, color=report_kit.MUTED.light, alpha=0.25, lw=0, label="gravity takes"
        )

    return chart("angle [°]", "torque [Nm]", lines, zero=True, include=check.gravity, also=gravity)


def write_fit_figure(path: str | PathLike[str], fit: PlantFit) -> Path:
    """Write the picture of a fit: a panel a log, the plant before and after over what was measured, held out."""
    words = "The plant's response over the measured one on parts not fitted."
    panels = tuple(Panel(log_fit.log.name, _against(log_fit), words) for log_fit in fit.logs)
    title = "The plant on parts that were not fitted"
    figure = PageFigure("rig-fit", title, "", panels, columns=3)
    return report_kit.write_picture(figure, path, f"{TITLE}fit", headed=True)


def _against(log_fit: LogFit) -> Draw:
    log = log_fit.log
    factor, unit = experiments_kit.UNITS[log.quantity]
    held_out = ~log.fitted & log.counted
    measured = factor * log.response[held_out]
    before, after = factor * log_fit.before[held_out], factor * log_fit.after[held_out]
    ends = np.array([measured.min(), measured.max()])
    lines = [
        PanelLine(measured, before, report_kit.MUTED, "before", 0.0, marker="."),
        PanelLine(measured, after, report_kit.TRAIN, "after", 0.0, marker="."),
        PanelLine(ends, ends, report_kit.INK, "measured"),
    ]
    return chart(f"measured {log.quantity} [{unit}]", f"plant {log.quantity} [{unit}]", lines)
