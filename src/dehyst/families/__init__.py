"""Hysteresis families of the literature: one file a family, fitted to one log and compared."""

from dehyst.families.acting import ModelMechanism
from dehyst.families.base import STARTS, UNSCALED, InverseLoop, LoopModel, LoopStepper, Scaling
from dehyst.families.comparison import Comparison, all_names, compare
from dehyst.families.controlling import LoopCompensator
from dehyst.families.entry import Entry
from dehyst.families.fitting import FamilyFit, identify_family
from dehyst.families.registry import MODULES, Family, example, family, names
from dehyst.families.storage import load_file
from dehyst.families.training import Stretch, Training

__all__ = [
    "MODULES",
    "STARTS",
    "UNSCALED",
    "Comparison",
    "Entry",
    "Family",
    "FamilyFit",
    "InverseLoop",
    "LoopCompensator",
    "LoopModel",
    "LoopStepper",
    "ModelMechanism",
    "Scaling",
    "Stretch",
    "Training",
    "all_names",
    "compare",
    "example",
    "family",
    "identify_family",
    "load_file",
    "names",
]
