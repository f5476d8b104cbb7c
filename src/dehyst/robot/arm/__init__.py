"""The simulated arm: parameters, physics of joints and links, kinematics."""

from dehyst.robot.arm.arm import Arm
from dehyst.robot.arm.drives import Drives, JointBench
from dehyst.robot.arm.mechanisms import Mechanism
from dehyst.robot.arm.parameters import Robot, load_robot
from dehyst.robot.arm.runs import ArmLog, Reference

__all__ = ["Arm", "ArmLog", "Drives", "JointBench", "Mechanism", "Reference", "Robot", "load_robot"]
