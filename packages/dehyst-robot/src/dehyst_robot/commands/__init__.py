"""Commands of the simulated robot: what `dehyst` gains by entry points of the group ``dehyst.commands``."""

from dehyst.app import Command
from dehyst_robot.commands._requests import (
    MuscleRequest,
    ReproduceRequest,
    RigRequest,
    SweepRequest,
)

REPRODUCE = Command("dehyst_robot.commands._reproduce:run_reproduce", ReproduceRequest)
RIG = Command("dehyst_robot.commands._rig:run_rig", RigRequest)
SWEEP = Command("dehyst_robot.commands._sweep:run_sweep_command", SweepRequest)
MUSCLE = Command("dehyst_robot.commands._muscle:run_muscle", MuscleRequest)
