"""Units of every kind for targets that wrap the C sources in another language."""

from dataclasses import replace

import numpy as np

from dehyst.export import subject_of
from dehyst.models import SignalCard
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.export import joint_subject
from direct_export_samples import direct_model
from element_samples import element_model, scheduled_model
from export_samples import CARD, mapped_model, play_model

HOSTILE = replace(
    CARD,
    input=SignalCard("*/ \u202e\\", "]`{0}", -1.0, 2.0),
    output=SignalCard('"\n[x', "<b>", -3.0, 5.0),
)
LOG = np.linspace(-3.0, 5.0, 50)
UNITS = {
    "plays": lambda real: subject_of(
        play_model(HOSTILE), name="plays", real=real, excerpt=LOG, excerpt_source="\u202e\nlog"
    ),
    "modified": lambda real: subject_of(mapped_model(), "forward", name="modified", real=real),
    "followed": lambda real: subject_of(
        play_model(), name="followed", real=real, follow_offset=0.2
    ),
    "sums": lambda real: subject_of(element_model(), name="sums", real=real),
    "scheduled": lambda real: subject_of(scheduled_model(), "forward", name="scheduled", real=real),
    "inverted": lambda real: subject_of(
        direct_model(schedules=3), name="inverted", real=real, period=0.004
    ),
    "axis": lambda real: joint_subject(
        play_model(), JointControllerParameters(), name="axis", real=real
    ),
    "taught": lambda real: joint_subject(
        direct_model(), JointControllerParameters(), name="taught", real=real
    ),
}


def other_precision(real):
    """A unit of the other precision than this one, for the same program."""
    return subject_of(play_model(), name="other", real={"double": "float", "float": "double"}[real])
