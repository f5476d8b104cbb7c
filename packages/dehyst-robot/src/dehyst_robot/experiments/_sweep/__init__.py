"""Parameter sweeps of the experiment: grids and random draws, thousands of runs, resumable."""

from dehyst_robot.experiments._sweep.points import Point, expand_points
from dehyst_robot.experiments._sweep.run import SweepProgress, SweepResult, run_sweep
from dehyst_robot.experiments._sweep.spec import Draw, Study, SweepSpec, load_sweep

__all__ = [
    "Draw",
    "Point",
    "Study",
    "SweepProgress",
    "SweepResult",
    "SweepSpec",
    "expand_points",
    "load_sweep",
    "run_sweep",
]
