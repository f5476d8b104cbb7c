"""Figures 3, 4 and 5 of the paper: the joint's hysteresis, the play operator, the inverse model against the data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dehyst.arrays import Array
from dehyst.report.drawing import DASHED, Line, chart
from dehyst.report.figures.operators import play_figure
from dehyst.report.parts import Draw, Figure, Panel
from dehyst.report.text import number
from dehyst.report.theme import DATA, MODEL, MUTED, TEST, TRAIN
from dehyst.report.thin import Window
from dehyst.robot.experiments.results import JointIdentification, PlantResult
from dehyst.robot.report.numbers import counted, identification_figure, left_off

TALL = (3.3,)  # of figure 3, whose right half is square [inch]
VISIBLE = 0.03  # of the hysteresis: smaller strokes need no word
HELD_STILL = 1e-4  # of the range of angles: a smaller step from sample to sample is no motion
ANGLE, HELD = "q [°]", "Δp − Δp_nom [bar]"


def joint_figures(plant: PlantResult, joint: JointIdentification) -> tuple[Figure, ...]:
    """Return figures 3, 4 and 5; figure 4 of a model with memory only."""
    play = None if joint.plays is None else play_figure(joint.plays, "x [bar]")
    return (_hysteresis(joint), *(() if play is None else (replace(play, number="4"),)), _inverse(plant, joint))


def _hysteresis(joint: JointIdentification) -> Figure:
    log, q, k = joint.log, np.rad2deg(joint.log["angle_rad"]), joint.shear
    nominal, x, across = log["nominal_difference_bar"], log["sheared_bar"], k * log["angle_rad"]
    wide = number(float(np.max(np.abs(log["pressure_difference_bar"] - nominal))), 2)
    places = np.argsort(q)[np.linspace(0, q.size - 1, 200).astype(np.int64)]
    over_angle = [
        Line(q, log["pressure_difference_bar"], TRAIN, "measured Δp", alpha=0.85),
        Line(q[places], nominal[places], MODEL, "Δp_nom, calibrated", 1.3, dashes=DASHED),
    ]
    reach = 1.05 * float(max(np.max(np.abs(x)), np.max(np.abs(across))))
    ends = np.array([-reach, reach])
    around = [Line(ends, ends, MUTED, "45°", 1.0, dashes=DASHED), Line(across, x, TRAIN, "measured", alpha=0.85)]
    square = chart("k q [bar]", "x [bar]", around, window=Window(-reach, reach, -reach, reach), square=True)
    return Figure(
        "hysteresis",
        "Hysteresis of the joint",
        f"Joint {joint.joint} in decaying loops, without load. Left: the pressure difference that holds it at an "
        f"angle, and the one that its calibrated characteristic says, without memory; they differ by up to {wide} bar. "
        f"Right: what differs, sheared, x = Δp − Δp_nom + k q with k = {number(k)} bar/rad: the loops lie "
        f"around the 45° line, and can be inverted.",
        (
            Panel(
                "a  Pressure difference over angle", chart(ANGLE, "Δp [bar]", over_angle), "Loops around a curve.", TALL
            ),
            Panel("b  Around the 45° line", square, "The same loops around the 45 degree line.", TALL),
        ),
        number="3",
    )


def _inverse(plant: PlantResult, joint: JointIdentification) -> Figure:
    log, unseen = joint.log, joint.unseen
    measured = log["sheared_bar"] - joint.shear * log["angle_rad"]
    modelled = _modelled(joint)
    weights = identification_figure(plant, joint.joint, "nonzero_weights")
    ratio = identification_figure(plant, joint.joint, "inverse_rms_ratio_unseen")
    formula = "H⁻¹[q] − k q" if joint.direct is None else "its torque over B(q)"
    refused = " That is too much: the model was not accepted, and the compensator stayed off."
    return Figure(
        "inverse",
        "The inverse model against the data",
        f"What the inverse model says the hysteresis is, {formula}, against Δp − Δp_nom as measured. Above: "
        f"the log it was identified from, {counted(weights)} operators with weight. Below: loops that it has not "
        f"seen; there the error is {ratio} of the hysteresis (rms)."
        f"{refused if left_off(plant, joint.joint) else ''}{_strokes(joint)}",
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
            _series("Unseen loops, over time", unseen["time_s"], unseen["hysteresis_bar"], unseen["inverse_bar"]),
        ),
        number="5",
    )


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


def _pair(x: Array, measured: Array, modelled: Array | None) -> list[Line]:
    lines = [Line(x, measured, DATA, "measured", 2.4)]
    return lines if modelled is None else [*lines, Line(x, modelled, MODEL, "inverse model", 0.95)]


def _loops(q: Array, measured: Array, modelled: Array | None) -> Draw:
    return chart(ANGLE, HELD, _pair(np.rad2deg(q), measured, modelled))


def _series(title: str, t: Array, measured: Array, modelled: Array | None) -> Panel:
    above = chart("time [s]", HELD, _pair(t, measured, modelled), zero=True)
    if modelled is None:
        return Panel(title, above, "Hysteresis over time as measured.")
    reach = 1.1 * float(max(np.max(np.abs(measured)), 1e-6))
    below = chart("time [s]", "error [bar]", [Line(t, measured - modelled, TEST, "error", 0.9)], zero=True, reach=reach)
    alt = "Hysteresis over time, measured and modelled, and below it their difference on the same scale."
    return Panel(title, (above, below), alt, (1.3, 0.85))


def others_figure(plant: PlantResult, joints: tuple[JointIdentification, ...]) -> Figure | None:
    """Return figure 5 of the other joints, or None if there are none."""
    if not joints:
        return None
    ratios = "; ".join(
        f"joint {j.joint}: {identification_figure(plant, j.joint, 'inverse_rms_ratio_unseen')}" for j in joints
    )
    return Figure(
        "inverse-others",
        "The same for the other joints",
        f"Loops not used in the fit. Error of the inverse model over the hysteresis, rms: {ratios}.",
        tuple(
            Panel(
                f"Joint {j.joint}, unseen loops",
                _loops(j.unseen["angle_rad"], j.unseen["hysteresis_bar"], j.unseen["inverse_bar"]),
                f"Hysteresis of joint {j.joint} over the angle, measured and modelled.",
            )
            for j in joints
        ),
    )
