"""Experiments: the example log, and the paper's experiment on the simulated arm.

What belongs to the arm is imported from its modules, or as ``dehyst.reproduce``, ``dehyst.run_trial``, ...: the example
log needs neither the arm nor MuJoCo.
"""

from dehyst.robot.experiments.example import example_csv, example_recording, write_example

__all__ = ["example_csv", "example_recording", "write_example"]
