"""Control of a joint: compensators, and the host side of the core's joint controller."""

from dehyst.control.adaptation import Adaptation
from dehyst.control.block import Block, BlockParameters
from dehyst.control.compensator import Compensator, InverseCompensator, RampedCompensator, along
from dehyst.control.direct_block import DirectBlock
from dehyst.control.joint import FLAGS, SWITCHES, JointController, JointOutput, JointReference
from dehyst.control.machine_block import BLOCK_FLAGS
from dehyst.control.parameters import JointControllerParameters, Pneumatics
from dehyst.control.storage import load_adaptation, load_controller, load_partner, save_controller

__all__ = [
    "BLOCK_FLAGS",
    "FLAGS",
    "SWITCHES",
    "Adaptation",
    "Block",
    "BlockParameters",
    "Compensator",
    "DirectBlock",
    "InverseCompensator",
    "JointController",
    "JointControllerParameters",
    "JointOutput",
    "JointReference",
    "Pneumatics",
    "RampedCompensator",
    "along",
    "load_adaptation",
    "load_controller",
    "load_partner",
    "save_controller",
]
