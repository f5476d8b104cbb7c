"""Parameter sweeps of the experiment: grids and random draws, thousands of runs, resumable."""

from dehyst.robot.experiments.sweep.points import Point, expand
from dehyst.robot.experiments.sweep.run import Progress, SweepResult, run_sweep
from dehyst.robot.experiments.sweep.spec import Draw, Study, SweepSpec, load_sweep

__all__ = ["Draw", "Point", "Progress", "Study", "SweepResult", "SweepSpec", "expand", "load_sweep", "run_sweep"]
