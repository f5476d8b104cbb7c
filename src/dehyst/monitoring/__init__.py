"""Tests a saved model on new logs: its accuracy (`evaluate`), and changes of the actuator (`drift`)."""

from dehyst.monitoring.procedure import drift
from dehyst.monitoring.result import Acceptance, Blocks, Change, Drift, LogDrift, Trend

__all__ = ["Acceptance", "Blocks", "Change", "Drift", "LogDrift", "Trend", "drift"]
