"""Control of a joint: compensators, and the Python side of the joint controller in the C core."""

from dehyst.lazy import lazy_names

# Type checkers take this name for true; without an import of `typing` the room is imported faster.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_robot.control._compensator import Compensator as Compensator
    from dehyst_robot.control._compensator import InverseCompensator as InverseCompensator
    from dehyst_robot.control._compensator import PathCompensator as PathCompensator
    from dehyst_robot.control._compensator import RampedCompensator as RampedCompensator
    from dehyst_robot.control._compensator import along as along
    from dehyst_robot.control._controller import Controller as Controller
    from dehyst_robot.control._controller import Reading as Reading
    from dehyst_robot.control._controller import Seat as Seat
    from dehyst_robot.control._joint import FLAGS as FLAGS
    from dehyst_robot.control._joint import SWITCHES as SWITCHES
    from dehyst_robot.control._joint import JointController as JointController
    from dehyst_robot.control._joint import JointOutput as JointOutput
    from dehyst_robot.control._joint import JointReference as JointReference
    from dehyst_robot.control._loop_compensator import LoopCompensator as LoopCompensator
    from dehyst_robot.control._mechanism import ModelMechanism as ModelMechanism
    from dehyst_robot.control._parameters import Adaptation as Adaptation
    from dehyst_robot.control._parameters import (
        JointControllerParameters as JointControllerParameters,
    )
    from dehyst_robot.control._parameters import Pneumatics as Pneumatics
    from dehyst_robot.control._reviewed import Law as Law
    from dehyst_robot.control._reviewed import OneValveController as OneValveController
    from dehyst_robot.control._storage import about as about
    from dehyst_robot.control._storage import controller_and_adaptation as controller_and_adaptation
    from dehyst_robot.control._storage import load_adaptation as load_adaptation
    from dehyst_robot.control._storage import load_controller as load_controller
    from dehyst_robot.control._storage import load_partner as load_partner
    from dehyst_robot.control._storage import save_controller as save_controller

# Module -> names that it has; each is imported when it is first used.
__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_robot.control",
    {
        "_compensator": "Compensator InverseCompensator PathCompensator RampedCompensator along",
        "_controller": "Controller Reading Seat",
        "_joint": "FLAGS JointController JointOutput JointReference SWITCHES",
        "_loop_compensator": "LoopCompensator",
        "_mechanism": "ModelMechanism",
        "_parameters": "Adaptation JointControllerParameters Pneumatics",
        "_reviewed": "Law OneValveController",
        "_storage": "about controller_and_adaptation load_adaptation load_controller load_partner save_controller",
    },
)
