"""Drift: has the actuator changed since it was identified?"""

from dehyst.identification.drift.procedure import drift
from dehyst.identification.drift.result import Acceptance, Blocks, Change, Drift, LogDrift, Trend

__all__ = ["Acceptance", "Blocks", "Change", "Drift", "LogDrift", "Trend", "drift"]
