"""The paper's experiment on the simulated arm.

Its calls are public as ``dehyst.reproduce``, ``dehyst.run_trial``, ...
"""
