"""Figures 3, 4 and 5 of the paper: the joint's hysteresis, the play operator, the inverse model against the data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dehyst.arrays import Array
from dehyst.report.figures.panel import Axes, label_axes, says
from dehyst.report.figures.play import play_figure
from dehyst.report.text import number
from dehyst.report.theme import DATA, MODEL, MUTED, TEST, TRAIN
from dehyst.report.thin import Window
from dehyst.robot.experiments.results import JointIdentification, PlantResult
from dehyst.robot.report.lines import Draw, Line, draw_loop, over_angle, over_time
from dehyst.robot.report.numbers import counted, identification_figure, left_off
from dehyst.robot.report.picture import Picture, Plate, from_panel

DASHED = (0, (5, 3))
TALL = (3.3,)  # of figure 3, whose right half is square [inch]
VISIBLE = 0.03  # of the hysteresis: smaller strokes need no word
HELD_STILL = 1e-4  # of the range of angles: a smaller step from sample to sample is no motion
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
        f"Right: what differs, sheared, x = Δp − Δp_nom + k q with k = {number(joint.shear)} bar/rad: the loops lie "
        f"around the 45° line, and can be inverted.",
        (
            Picture("a  Pressure difference over angle", (_over_angle(joint),), says("Loops around a curve."), TALL),
            Picture(
                "b  Around the 45° line", (_around(joint),), says("The same loops around the 45 degree line."), TALL
            ),
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
        axes.locator_params(axis="both", nbins=5)
        axes.plot([-reach, reach], [-reach, reach], color=MUTED.light, lw=1.0, ls=DASHED, label="45°")
        draw_loop(axes, across, Line(x, TRAIN, "measured", alpha=0.85), window)

    return draw


def play_plate(joint: JointIdentification) -> Plate | None:
    """Return figure 4, or None for a model without memory."""
    figure = None if joint.plays is None else play_figure(joint.plays)
    if figure is None:
        return None
    over_input, *others = (from_panel(panel) for panel in figure.panels)
    named = replace(over_input, rows=tuple(_input_named_x(draw) for draw in over_input.rows))
    caption = figure.caption.replace(" = ", "\u00a0=\u00a0")
    return Plate("play", figure.title, caption, (named, *others), figure.formula)


def _input_named_x(draw: Draw) -> Draw:
    def draw_both(axes: Axes) -> None:
        draw(axes)
        axes.set_xlabel("x [bar]")

    return draw_both


def inverse_plate(plant: PlantResult, joint: JointIdentification) -> Plate:
    """Return figure 5."""
    log, unseen = joint.log, joint.unseen
    q, new_q = log["angle_rad"], unseen["angle_rad"]
    measured = log["sheared_bar"] - joint.shear * q
    modelled = _modelled(joint)
    weights = identification_figure(plant, joint.joint, "nonzero_weights")
    ratio = identification_figure(plant, joint.joint, "inverse_rms_ratio_unseen")
    return Plate(
        "inverse",
        "The inverse model against the data",
        f"What the inverse model says the hysteresis is, {_formula(joint)}, against Δp − Δp_nom as measured. Above: "
        f"the log it was identified from, {counted(weights)} operators with weight. Below: loops that it has not "
        f"seen; there the error is {ratio} of the hysteresis (rms).{_verdict(plant, joint)}{_strokes(joint)}",
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


def _formula(joint: JointIdentification) -> str:
    return "H⁻¹[q] − k q" if joint.direct is None else "its torque over B(q)"


def _verdict(plant: PlantResult, joint: JointIdentification) -> str:
    if not left_off(plant, joint.joint):
        return ""
    return " That is too much: the model was not accepted, and the compensator stayed off."


def _strokes(joint: JointIdentification) -> str:
    """What the inverse makes of the encoder's steps while the joint is held, where that can be seen."""
    q, said = joint.unseen["angle_rad"], joint.unseen["inverse_bar"]
    step, answer = np.abs(np.diff(q)), np.abs(np.diff(said))
    held = (step > 0.0) & (step < HELD_STILL * float(np.ptp(q)))
    if not held.any():
        return ""
    k = int(np.argmax(np.where(held, answer, 0.0)))
    if answer[k] < VISIBLE * float(np.ptp(said)):
        return ""
    return (
        f" The short upright strokes are the holds: a step of the encoder by {number(np.rad2deg(step[k]), 2)}° passes "
        f"for a turn there, and the inverse, steepest after a turn, answers with up to {number(answer[k], 2)} bar. The "
        "controller's inverse hears the desired angle, which has no steps."
    )


def _modelled(joint: JointIdentification) -> Array | None:
    """What the compensator says along the log; None if its fit does not hold the log sample by sample."""
    q = joint.log["angle_rad"]
    if joint.modelled_bar is not None:
        return joint.modelled_bar
    if joint.plays is None or joint.plays.inverse_predictions[0].shape != q.shape:
        return None
    return joint.plays.inverse_predictions[0] - joint.shear * q


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
