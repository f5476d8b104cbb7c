"""Simulated robot: muscles, the arm, ISO 9283, the joint controller, the paper's experiment.

The public names and nothing else; each is imported when it is first used.
"""

from dehyst.lazy import lazy_names

# Type checkers take this name for true. An import of `typing` would delay the moment from which Ctrl-C is heeded.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_robot._gym import gym as gym
    from dehyst_robot.arm import Arm as Arm
    from dehyst_robot.arm import Drives as Drives
    from dehyst_robot.arm import JointBench as JointBench
    from dehyst_robot.arm import Mechanism as Mechanism
    from dehyst_robot.arm import Reference as Reference
    from dehyst_robot.arm import Robot as Robot
    from dehyst_robot.arm import load_robot as load_robot
    from dehyst_robot.control import Compensator as Compensator
    from dehyst_robot.control import Controller as Controller
    from dehyst_robot.control import InverseCompensator as InverseCompensator
    from dehyst_robot.control import JointController as JointController
    from dehyst_robot.control import JointControllerParameters as JointControllerParameters
    from dehyst_robot.experiments import Equipment as Equipment
    from dehyst_robot.experiments import Reproduction as Reproduction
    from dehyst_robot.experiments import Request as Request
    from dehyst_robot.experiments import calibrate as calibrate
    from dehyst_robot.experiments import equip as equip
    from dehyst_robot.experiments import identify_joint as identify_joint
    from dehyst_robot.experiments import plan_path as plan_path
    from dehyst_robot.experiments import reproduce as reproduce
    from dehyst_robot.experiments import run_trial as run_trial
    from dehyst_robot.report import write_reproduction_report as write_reproduction_report

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_robot",
    {
        "arm": "Arm Drives JointBench Mechanism Reference Robot load_robot",
        "control": "Compensator Controller InverseCompensator JointController JointControllerParameters",
        "experiments": "Equipment Reproduction Request calibrate equip identify_joint plan_path reproduce run_trial",
        "_gym": "gym",
        "report": "write_reproduction_report",
    },
)
