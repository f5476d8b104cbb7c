"""Control of a joint: compensators, and the Python side of the joint controller in the C core."""

from dehyst.robot.control.compensator import Compensator, InverseCompensator, RampedCompensator, along
from dehyst.robot.control.controller import Controller, Reading
from dehyst.robot.control.joint import FLAGS, SWITCHES, JointController, JointOutput, JointReference
from dehyst.robot.control.loop_compensator import LoopCompensator
from dehyst.robot.control.mechanism import ModelMechanism
from dehyst.robot.control.parameters import Adaptation, JointControllerParameters, Pneumatics
from dehyst.robot.control.storage import load_adaptation, load_controller, load_partner, save_controller

__all__ = [
    "FLAGS",
    "SWITCHES",
    "Adaptation",
    "Compensator",
    "Controller",
    "InverseCompensator",
    "JointController",
    "JointControllerParameters",
    "JointOutput",
    "JointReference",
    "LoopCompensator",
    "ModelMechanism",
    "Pneumatics",
    "RampedCompensator",
    "Reading",
    "along",
    "load_adaptation",
    "load_controller",
    "load_partner",
    "save_controller",
]
