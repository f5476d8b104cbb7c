"""Simulated robot: muscles, the arm, ISO 9283, the paper's experiment; not used when working with logs."""
