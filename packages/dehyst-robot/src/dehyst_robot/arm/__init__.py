"""The simulated arm: parameters, physics of joints and links, kinematics."""

from dehyst.lazy import lazy_names

# Type checkers take this name for true; without an import of `typing` the room is imported faster.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_robot.arm._arm import Arm as Arm
    from dehyst_robot.arm._body import Hinges as Hinges
    from dehyst_robot.arm._drives import Drives as Drives
    from dehyst_robot.arm._drives import JointBench as JointBench
    from dehyst_robot.arm._joints import pneumatic_joint_parameters as pneumatic_joint_parameters
    from dehyst_robot.arm._kinematics import JointPath as JointPath
    from dehyst_robot.arm._mechanisms import Mechanism as Mechanism
    from dehyst_robot.arm._mechanisms import MechanismFactory as MechanismFactory
    from dehyst_robot.arm._parameters import Robot as Robot
    from dehyst_robot.arm._parameters import changes_from_packaged as changes_from_packaged
    from dehyst_robot.arm._parameters import load_robot as load_robot
    from dehyst_robot.arm._parameters import robot_of as robot_of
    from dehyst_robot.arm._parameters import sources as sources
    from dehyst_robot.arm._rigid_body import arm_model as arm_model
    from dehyst_robot.arm._rigid_body import bias_torque as bias_torque
    from dehyst_robot.arm._rigid_body import mujoco as mujoco
    from dehyst_robot.arm._runs import ArmLog as ArmLog
    from dehyst_robot.arm._runs import Reference as Reference
    from dehyst_robot.arm._tables import Drawn as Drawn
    from dehyst_robot.arm._tables import ForceMapTable as ForceMapTable
    from dehyst_robot.arm._tables import Hysteresis as Hysteresis
    from dehyst_robot.arm._tables import Joint as Joint
    from dehyst_robot.arm._tables import Muscle as Muscle
    from dehyst_robot.arm._tables import Tables as Tables
    from dehyst_robot.arm._tables import Valve as Valve

# Module -> names that it has; each is imported when it is first used.
__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_robot.arm",
    {
        "_arm": "Arm",
        "_body": "Hinges",
        "_drives": "Drives JointBench",
        "_joints": "pneumatic_joint_parameters",
        "_kinematics": "JointPath",
        "_mechanisms": "Mechanism MechanismFactory",
        "_parameters": "Robot changes_from_packaged load_robot robot_of sources",
        "_rigid_body": "arm_model bias_torque mujoco",
        "_runs": "ArmLog Reference",
        "_tables": "Drawn ForceMapTable Hysteresis Joint Muscle Tables Valve",
    },
)
