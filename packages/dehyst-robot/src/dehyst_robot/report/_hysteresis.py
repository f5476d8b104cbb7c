"""Figures 3, 4 and 5 of the paper: the joint's hysteresis, the play operator, the inverse model against the data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dehyst.arrays import Array
from dehyst.report import Draw, PageFigure, Panel, PanelLine, Window, chart
from dehyst.report import kit as report_kit
from dehyst_robot.experiments import JointIdentification, PlantResult
from dehyst_robot.report._numbers import counted, identification_figure, left_off

TALL = (3.3,)  # of figure 3, whose right half is square [inch]
ANGLE, HELD = "q [°]", "Δp − Δp_nom [bar]"


def hysteresis_figures(plant: PlantResult, joint: JointIdentification) -> tuple[PageFigure, ...]:
    """Return figures 3, 4 and 5; figure 4 of a model with memory only."""
    figures = [_hysteresis(joint)]
    if joint.plays is not None:
        play = report_kit.play_figure(joint.plays, "x [bar]")
        if play is not None:
            figures.append(replace(play, number="4"))
    return (*figures, _inverse(plant, joint))


def _hysteresis(joint: JointIdentification) -> PageFigure:
    log, q, k = joint.log, np.rad2deg(joint.log["angle_rad"]), joint.shear
    nominal, x, across = log["nominal_difference_bar"], log["sheared_bar"], k * log["angle_rad"]
    # How far the measured pressure strays from the characteristic without memory.
    wide = report_kit.number(float(np.max(np.abs(log["pressure_difference_bar"] - nominal))), 2)
    # The characteristic has one value an angle: 200 of them draw it.
    places = np.argsort(q)[np.linspace(0, q.size - 1, 200).astype(np.int64)]
    over_angle = [
        PanelLine(q, log["pressure_difference_bar"], report_kit.TRAIN, "measured Δp", alpha=0.85),
        PanelLine(
            q[places],
            nominal[places],
            report_kit.MODEL,
            "Δp_nom, calibrated",
            1.3,
            dashes=report_kit.DASHED,
        ),
    ]
    # The right half is square and symmetric, for the 45 degree line to look like one.
    reach = 1.05 * float(max(np.max(np.abs(x)), np.max(np.abs(across))))
    ends = np.array([-reach, reach])
    around = [
        PanelLine(ends, ends, report_kit.MUTED, "45°", 1.0, dashes=report_kit.DASHED),
        PanelLine(across, x, report_kit.TRAIN, "measured", alpha=0.85),
    ]
    square = chart(
        "k q [bar]", "x [bar]", around, window=Window(-reach, reach, -reach, reach), square=True
    )
    return PageFigure(
        "hysteresis",
        "Hysteresis of the joint",
        f"Joint {joint.joint} in decaying loops, without load. Left: the pressure difference that holds it at an "
        f"angle, and the one that its calibrated characteristic says, without memory; they differ by up to {wide} bar. "
        f"Right: what differs, sheared, x = Δp − Δp_nom + k q with k = {report_kit.number(k)} bar/rad: the loops lie "
        f"around the 45° line, and can be inverted.",
        (
            Panel(
                "a  Pressure difference over angle",
                chart(ANGLE, "Δp [bar]", over_angle),
                "Loops around a curve.",
                TALL,
            ),
            Panel(
                "b  Around the 45° line", square, "The same loops around the 45 degree line.", TALL
            ),
        ),
        number="3",
    )


def _inverse(plant: PlantResult, joint: JointIdentification) -> PageFigure:
    log, unseen = joint.log, joint.unseen
    measured = log["sheared_bar"] - joint.shear * log["angle_rad"]
    modelled = _modelled(joint)
    weights = identification_figure(plant, joint.joint, "nonzero_weights")
    ratio = identification_figure(plant, joint.joint, "inverse_rms_ratio_unseen")
    formula = "its torque over B(q)"
    if joint.direct is None:
        formula = "H⁻¹[q] − k q"
    refused = ""
    if left_off(plant, joint.joint):
        refused = " That is too much: the model was not accepted, and the compensator stayed off."
    return PageFigure(
        "inverse",
        "The inverse model against the data",
        f"What the inverse model says the hysteresis is, {formula}, against Δp − Δp_nom as measured. Above: "
        f"the log it was identified from, {counted(weights)} operators with weight. Below: loops that it has not "
        f"seen; there the error is {ratio} of the hysteresis (rms)."
        f"{refused}",
        (
            Panel(
                "Identification log, over angle",
                _loops(log["angle_rad"], measured, modelled),
                "Hysteresis over the angle, measured and modelled, loops of the identification.",
            ),
            _series("Identification log, over time", log["time_s"], measured, modelled),
            Panel(
                "Unseen loops, over angle",
                _loops(unseen["angle_rad"], unseen["hysteresis_bar"], unseen["inverse_bar"]),
                "Hysteresis over the angle, measured and modelled, loops not used in the fit.",
            ),
            _series(
                "Unseen loops, over time",
                unseen["time_s"],
                unseen["hysteresis_bar"],
                unseen["inverse_bar"],
            ),
        ),
        number="5",
    )


def _modelled(joint: JointIdentification) -> Array | None:
    """What the compensator says along the log; None if its fit does not hold the log sample by sample."""
    q = joint.log["angle_rad"]
    if joint.modelled_bar is not None:
        return joint.modelled_bar
    if joint.plays is None or joint.plays.inverse_predictions[0].shape != q.shape:
        return None
    return joint.plays.inverse_predictions[0] - joint.shear * q


def _pair(x: Array, measured: Array, modelled: Array | None) -> list[PanelLine]:
    lines = [PanelLine(x, measured, report_kit.DATA, "measured", 2.4)]
    if modelled is not None:
        lines.append(PanelLine(x, modelled, report_kit.MODEL, "inverse model", 0.95))
    return lines


def _loops(q: Array, measured: Array, modelled: Array | None) -> Draw:
    return chart(ANGLE, HELD, _pair(np.rad2deg(q), measured, modelled))


def _series(title: str, t: Array, measured: Array, modelled: Array | None) -> Panel:
    above = chart("time [s]", HELD, _pair(t, measured, modelled), zero=True)
    if modelled is None:
        return Panel(title, above, "Hysteresis over time as measured.")
    # The error stands on the scale of the hysteresis: a small one shall look small.
    reach = 1.1 * float(max(np.max(np.abs(measured)), 1e-6))
    below = chart(
        "time [s]",
        "error [bar]",
        [PanelLine(t, measured - modelled, report_kit.TEST, "error", 0.9)],
        zero=True,
        reach=reach,
    )
    alt = "Hysteresis over time, measured and modelled, and below it their difference on the same scale."
    return Panel(title, (above, below), alt, (1.3, 0.85))


def others_figure(plant: PlantResult, joints: tuple[JointIdentification, ...]) -> PageFigure | None:
    """Return figure 5 of the other joints, or None if there are none."""
    if not joints:
        return None
    ratios, panels = [], []
    for identified in joints:
        joint, unseen = identified.joint, identified.unseen
        ratio = identification_figure(plant, joint, "inverse_rms_ratio_unseen")
        ratios.append(f"joint {joint}: {ratio}")
        draw = _loops(unseen["angle_rad"], unseen["hysteresis_bar"], unseen["inverse_bar"])
        words = f"Hysteresis of joint {joint} over the angle, measured and modelled."
        panels.append(Panel(f"Joint {joint}, unseen loops", draw, words))
    return PageFigure(
        "inverse-others",
        "The same for the other joints",
        f"Loops not used in the fit. Error of the inverse model over the hysteresis, rms: {'; '.join(ratios)}.",
        tuple(panels),
    )
