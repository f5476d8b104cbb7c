"""A saved model against new logs: how well it does (`evaluate`), and whether the actuator has changed (`drift`)."""

from dehyst.monitoring.procedure import drift
from dehyst.monitoring.result import Acceptance, Blocks, Change, Drift, LogDrift, Trend

__all__ = ["Acceptance", "Blocks", "Change", "Drift", "LogDrift", "Trend", "drift"]
