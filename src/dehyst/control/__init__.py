"""Control of a joint: compensators, and the Python side of the joint controller in the C core."""

from dehyst.control.block import BLOCK_FLAGS, Block
from dehyst.control.compensator import Compensator, InverseCompensator, RampedCompensator, along
from dehyst.control.controller import Controller, Reading
from dehyst.control.joint import FLAGS, SWITCHES, JointController, JointOutput, JointReference
from dehyst.control.parameters import Adaptation, JointControllerParameters, Pneumatics
from dehyst.control.storage import load_adaptation, load_controller, load_partner, save_controller
from dehyst.models.machine import BlockParameters

__all__ = [
    "BLOCK_FLAGS",
    "FLAGS",
    "SWITCHES",
    "Adaptation",
    "Block",
    "BlockParameters",
    "Compensator",
    "Controller",
    "InverseCompensator",
    "JointController",
    "JointControllerParameters",
    "JointOutput",
    "JointReference",
    "Pneumatics",
    "RampedCompensator",
    "Reading",
    "along",
    "load_adaptation",
    "load_controller",
    "load_partner",
    "save_controller",
]
