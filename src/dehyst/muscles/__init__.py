"""Muscle models of the literature: force from contraction and pressure, with memory, and back to the pressure."""

from dehyst.muscles.base import Memory, MuscleModel, MuscleStepper, Parameter
from dehyst.muscles.joint import JointCharacteristic, joint_characteristic
from dehyst.muscles.mechanism import MuscleMechanism
from dehyst.muscles.registry import muscle, muscle_class, names

__all__ = [
    "JointCharacteristic",
    "Memory",
    "MuscleMechanism",
    "MuscleModel",
    "MuscleStepper",
    "Parameter",
    "joint_characteristic",
    "muscle",
    "muscle_class",
    "names",
]
