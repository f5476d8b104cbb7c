"""The simulated arm: parameters, physics of joints and links, kinematics."""

from dehyst.control.controller import Controller, Reading
from dehyst.robot.arm.arm import Arm, ArmLog, Reference
from dehyst.robot.arm.drives import Drives, JointBench
from dehyst.robot.arm.mechanisms import Mechanism
from dehyst.robot.arm.parameters import Robot, load_robot

__all__ = [
    "Arm",
    "ArmLog",
    "Controller",
    "Drives",
    "JointBench",
    "Mechanism",
    "Reading",
    "Reference",
    "Robot",
    "load_robot",
]
