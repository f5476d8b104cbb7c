"""Muscle models of the literature: force from contraction and pressure, with memory, and back to the pressure."""

from dehyst.robot.muscles.base import Memory, MuscleModel, MuscleStepper
from dehyst.robot.muscles.joint import (
    JointCharacteristic,
    MuscleJoint,
    MuscleMechanism,
    SlippingJoint,
    identify_slips,
    joint_characteristic,
)
from dehyst.robot.muscles.parameters import Parameter
from dehyst.robot.muscles.registry import muscle, muscle_class, names

__all__ = [
    "JointCharacteristic",
    "Memory",
    "MuscleJoint",
    "MuscleMechanism",
    "MuscleModel",
    "MuscleStepper",
    "Parameter",
    "SlippingJoint",
    "identify_slips",
    "joint_characteristic",
    "muscle",
    "muscle_class",
    "names",
]
