"""Commands of the simulated robot: what `dehyst` gains by entry points of the group ``dehyst.commands``."""

from dehyst.app.command import Command
from dehyst.robot.commands.requests import MuscleRequest, ReproduceRequest, RigRequest, SweepRequest

REPRODUCE = Command("dehyst.robot.commands.reproduce:run_reproduce", ReproduceRequest)
RIG = Command("dehyst.robot.commands.rig:run_rig", RigRequest)
SWEEP = Command("dehyst.robot.commands.sweep:run_sweep_command", SweepRequest)
MUSCLE = Command("dehyst.robot.commands.muscle:run_muscle", MuscleRequest)
