"""Muscle models of the literature: force from contraction and pressure, with memory, and back to the pressure."""

from dehyst.muscles.base import Memory, MuscleModel, MuscleStepper, Parameter
from dehyst.muscles.registry import muscle, muscle_class, names

__all__ = ["Memory", "MuscleModel", "MuscleStepper", "Parameter", "muscle", "muscle_class", "names"]
