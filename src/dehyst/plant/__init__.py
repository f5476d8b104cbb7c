"""The simulated arm: parameters, physics of its joints and of its links, kinematics."""

from dehyst.plant.arm import Arm, ArmLog, Reference
from dehyst.plant.bench import JointBench, Reading
from dehyst.plant.mechanisms import Mechanism
from dehyst.plant.parameters import Robot, load_robot

__all__ = ["Arm", "ArmLog", "JointBench", "Mechanism", "Reading", "Reference", "Robot", "load_robot"]
