"""The laboratory: muscles, the simulated arm, ISO 9283, the paper's experiment. The log path knows none of it."""
