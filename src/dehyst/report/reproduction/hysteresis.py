"""Figures 3, 4 and 5 of the paper: the joint's hysteresis, the play operator, the inverse model against the data."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.experiments.results import JointIdentification, PlantResult
from dehyst.report.figures.panel import Axes, label_axes, says
from dehyst.report.figures.play import play_figure
from dehyst.report.reproduction.lines import Draw, Line, draw_loop, over_angle, over_time
from dehyst.report.reproduction.numbers import counted, identification_figure
from dehyst.report.reproduction.picture import Picture, Plate, from_panel
from dehyst.report.text import number
from dehyst.report.theme import DATA, MODEL, MUTED, TEST, TRAIN
from dehyst.report.thin import Window

Array = npt.NDArray[np.float64]

DASHED = (0, (5, 3))
ANGLE, HELD = "q [°]", "Δp − Δp_nom [bar]"


def hysteresis_plate(plant: PlantResult, joint: JointIdentification) -> Plate:
    """Return figure 3."""
    held = joint.log["pressure_difference_bar"] - joint.log["nominal_difference_bar"]
    wide = number(float(np.max(np.abs(held))), 2)
    return Plate(
        "hysteresis",
        "Hysteresis of the joint",
        f"Joint {joint.joint} in decaying loops, without load. Left: the pressure difference that holds it at an "
        f"angle, and the one that its calibrated characteristic says, without memory; they differ by up to {wide} bar. "
        f"Right: sheared, x = Δp − Δp_nom + k q with k = {number(joint.shear)} bar/rad, the loop lies around the 45° "
        f"line, and can be inverted.",
        (
            Picture("a  Pressure difference over angle", (_over_angle(joint),), says("Loops around a curve.")),
            Picture("b  Around the 45° line", (_around(joint),), says("The same loops around the 45 degree line.")),
        ),
    )


def _over_angle(joint: JointIdentification) -> Draw:
    q = np.rad2deg(joint.log["angle_rad"])
    order = np.argsort(q)
    nominal = joint.log["nominal_difference_bar"]
    measured = Line(joint.log["pressure_difference_bar"], TRAIN, "measured Δp", alpha=0.85)
    loops = over_angle(q, (measured,), ANGLE, "Δp [bar]")

    def draw(axes: Axes) -> None:
        loops(axes)
        places = order[np.linspace(0, order.size - 1, 200).astype(np.int64)]
        axes.plot(q[places], nominal[places], color=MODEL.light, lw=1.3, ls=DASHED, label="Δp_nom, calibrated")

    return draw


def _around(joint: JointIdentification) -> Draw:
    x, across = joint.log["sheared_bar"], joint.shear * joint.log["angle_rad"]

    def draw(axes: Axes) -> None:
        reach = 1.05 * float(max(np.max(np.abs(x)), np.max(np.abs(across))))
        window = Window(-reach, reach, -reach, reach)
        label_axes(axes, window, "k q [bar]", "x [bar]")
        axes.set_aspect("equal", anchor="W")
        axes.plot([-reach, reach], [-reach, reach], color=MUTED.light, lw=1.0, ls=DASHED, label="45°")
        draw_loop(axes, across, Line(x, TRAIN, "measured", alpha=0.85), window)

    return draw


def play_plate(joint: JointIdentification) -> Plate | None:
    """Return figure 4, or None for a model without memory."""
    figure = play_figure(joint.fit)
    if figure is None:
        return None
    pictures = tuple(from_panel(panel) for panel in figure.panels)
    return Plate("play", figure.title, figure.caption, pictures, figure.formula)


def inverse_plate(plant: PlantResult, joint: JointIdentification) -> Plate:
    """Return figure 5."""
    log, unseen = joint.log, joint.unseen
    q, new_q = log["angle_rad"], unseen["angle_rad"]
    measured = log["sheared_bar"] - joint.shear * q
    modelled = joint.fit.inverse_predictions[0] - joint.shear * q if _whole(joint) else None
    weights = identification_figure(plant, joint.joint, "nonzero_weights")
    ratio = identification_figure(plant, joint.joint, "inverse_rms_ratio_unseen")
    return Plate(
        "inverse",
        "The inverse model against the data",
        "What the inverse model says the hysteresis is, H⁻¹[q] − k q, against Δp − Δp_nom as measured. Above: the log "
        f"it was identified from, {counted(weights)} operators with weight. Below: loops that it has not "
        f"seen; there the error is {ratio} of the hysteresis (rms).",
        (
            Picture(
                "Identification log, over angle",
                (_loops(q, measured, modelled),),
                says("Hysteresis over the angle, measured and modelled, loops of the identification."),
            ),
            _series("Identification log, over time", log["time_s"], measured, modelled),
            Picture(
                "Unseen loops, over angle",
                (_loops(new_q, unseen["hysteresis_bar"], unseen["inverse_bar"]),),
                says("Hysteresis over the angle, measured and modelled, loops not used in the fit."),
            ),
            _series("Unseen loops, over time", unseen["time_s"], unseen["hysteresis_bar"], unseen["inverse_bar"]),
        ),
    )


def _whole(joint: JointIdentification) -> bool:
    """Whether the fit's first recording is the log sample by sample."""
    return joint.fit.inverse_predictions[0].shape == joint.log["angle_rad"].shape


def _pair(measured: Array, modelled: Array | None) -> tuple[Line, ...]:
    lines = (Line(measured, DATA, "measured", 2.4),)
    return lines if modelled is None else (*lines, Line(modelled, MODEL, "inverse model", 0.95))


def _loops(q: Array, measured: Array, modelled: Array | None) -> Draw:
    return over_angle(np.rad2deg(q), _pair(measured, modelled), ANGLE, HELD)


def _series(title: str, t: Array, measured: Array, modelled: Array | None) -> Picture:
    above = over_time(t, _pair(measured, modelled), "time [s]", HELD)
    if modelled is None:
        return Picture(title, (above,), says("Hysteresis over time as measured."))
    reach = 1.1 * float(max(np.max(np.abs(measured)), 1e-6))
    left = over_time(t, (Line(measured - modelled, TEST, "error", 0.9),), "time [s]", "error [bar]", reach=reach)
    alt = says("Hysteresis over time, measured and modelled, and below it their difference on the same scale.")
    return Picture(title, (above, left), alt, (1.3, 0.85))


def others_plate(plant: PlantResult, joints: tuple[JointIdentification, ...]) -> Plate | None:
    """Return figure 5 of the other joints, or None if there are none."""
    if not joints:
        return None
    ratios = "; ".join(
        f"joint {j.joint}: {identification_figure(plant, j.joint, 'inverse_rms_ratio_unseen')}" for j in joints
    )
    return Plate(
        "inverse-others",
        "The same for the other joints",
        f"Loops not used in the fit. Error of the inverse model over the hysteresis, rms: {ratios}.",
        tuple(
            Picture(
                f"Joint {j.joint}, unseen loops",
                (_loops(j.unseen["angle_rad"], j.unseen["hysteresis_bar"], j.unseen["inverse_bar"]),),
                says(f"Hysteresis of joint {j.joint} over the angle, measured and modelled."),
            )
            for j in joints
        ),
    )
