"""Design of test motions: what to log for a good identification, and how to home."""

from dehyst.design.design import design_drift_motion, design_excitation
from dehyst.design.excitation import UNSEEN_TIPS, Limits, decaying_cycles, loops, triangle_sweep
from dehyst.design.homing import Homing, admissible, shortest_homing
from dehyst.design.homing_model import home_model
from dehyst.design.plan import ExcitationPlan
from dehyst.design.separability import separability

__all__ = [
    "UNSEEN_TIPS",
    "ExcitationPlan",
    "Homing",
    "Limits",
    "admissible",
    "decaying_cycles",
    "design_drift_motion",
    "design_excitation",
    "home_model",
    "loops",
    "separability",
    "shortest_homing",
    "triangle_sweep",
]
