"""Settings of the whole suite."""

from hypothesis import HealthCheck, settings

# Two cores, several suites at once: a slow example is not a failure, and a failure must come back tomorrow.
settings.register_profile(
    "dehyst", deadline=None, derandomize=True, max_examples=120, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("dehyst")
