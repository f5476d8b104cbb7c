"""Experiments: for now the example log; the paper's experiment on the simulated arm will live here."""

from dehyst.experiments.example import example_csv, example_recording, write_example

__all__ = ["example_csv", "example_recording", "write_example"]
